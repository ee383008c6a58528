"""A part as a bar along x: its loads in balance, fibres of its sections, deflection, buckling.

Fibres are of square tubes and of plates in their walls.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from math import pi
from typing import Self

import numpy as np

from checks.columns.column_moments import axial_compression
from checks.design.data import Part
from checks.handbook.bar_forces import BarForces, BarLoads, balanced_bar, deflection
from checks.handbook.column_curves import column_force, lateral_share
from checks.models.bar_modes import Mode, half_wave, sideways
from checks.models.formula_points import (
    XX,
    XY,
    Points,
    acceleration_units,
    along_x,
    in_section,
    sheared,
    wrench_units,
)
from checks.part.derived import numbers
from checks.part.part_loads import PartLoads, first_largest
from checks.result.derivation import Column, Given, Item, Step, Sum
from checks.stress.stress_result import ElasticLoad, RungModel
from geometry.bars import Section
from geometry.mesh import FloatArray

SHARE = "share"  # the symbol of the result
_QUOTIENT = "Timoshenko's quotient: Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., 2.8"
LATERAL = (
    "the share is the largest eigenvalue of bars that are bent aside and twist, which no formula "
    "gives"
)
_LATERAL = "Timoshenko and Gere, 2nd ed., 6.1 to 6.3"
_FORCE_SHARE = Step(SHARE, "share of the elastic buckling load", "max(0, F/F_cr)", main=True)

_CLAMPED = 4.0  # times the load of a column whose ends are hinged

_STATIONS = 33  # of deflection and lateral buckling
_IN_PLANE = "in plane: Euler's column"
ASIDE = "out of plane: the bar is bent aside and twists"
_SIDEWAYS = "out of plane: Euler's column and lateral buckling of the bent bar"
PRESSED = 8 / (3 * pi)  # of a bore's radius: where the resultant of a half cosine pressure stands
HARDLY = 0.05  # of the largest force: what presses a part that is nearly always pulled
# E (t/b)^2 over a long plate's critical stress, both edges held along it, or one free: k = 4 or
# 0.425 in k pi^2 E/(12 (1 - nu^2)) (t/b)^2 (docs/theory/buckling.md)
_HELD, _FREE = 0.28, 2.6
_STOUT = 12.0  # the same of what is no plate
_NO_MOMENT = 1e-9  # of the largest force times the length: round-off
_PULLED = "only pulled: lateral buckling of the bent bar, without the pull that stiffens it"
_KINDS = {
    "axial": "axial force",
    "shear": "shear force",
    "torque": "torque",
    "moment_y": "moment M_y",
    "moment_z": "moment M_z",
}


@dataclass(frozen=True)
class Aside:
    """Buckling of a bar by a model of its shape's own.

    share     largest of all positions, at `position`
    held      the share there with forks that hold it against tilting
    mode      its mode, as `ElasticLoad` has it
    words     how it buckles
    """

    share: float
    position: int
    held: float
    mode: Mode
    words: str = ASIDE


@dataclass(frozen=True, eq=False)
class Stretches:
    """A part's mass and stiffness along x, in cells.

    cuts       (m + 1,) mm, rising
    area       (m,) mm2
    inertia_z  (m,) mm4, bending in the linkage's plane
    inertia_y  (m,) mm4, out of it
    torsion    (m,) mm4, Saint-Venant's
    racking    (m,) mm2, shear stiffness out of the plane over E; None without shear strain
    sliding    the same in the plane
    """

    cuts: FloatArray
    area: FloatArray
    inertia_z: FloatArray
    inertia_y: FloatArray
    torsion: FloatArray
    racking: FloatArray | None = None
    sliding: FloatArray | None = None

    @property
    def middles(self) -> FloatArray:
        """Middles of the cells, mm."""
        return (self.cuts[1:] + self.cuts[:-1]) / 2

    def at(self, values: FloatArray, places: FloatArray) -> FloatArray:
        """Values of the cells that hold some places, mm."""
        cell = np.clip(np.searchsorted(self.cuts, places) - 1, 0, len(values) - 1)
        return np.asarray(values[cell])


def bar_loads(part: Part, loads: PartLoads, places: dict[str, float], mass: Stretches) -> BarLoads:
    """All loads of a part along its axis; interfaces at x = `places`, sliding ones from there."""
    points: list[tuple[float | FloatArray, FloatArray]] = []
    for name, wrench in loads.wrenches.items():
        reach = loads.reaches.get(name)
        if reach is None:
            points.append((places[name], wrench))
            continue
        moved = wrench.copy()  # its couple is about the interface's centre
        moved[:, 5] -= reach * wrench[:, 1]
        points.append((places[name] + reach, moved))
    weight = part.material.density * mass.area * np.diff(mass.cuts)
    return balanced_bar(points, mass.middles, weight, loads.accelerations)


class SectionForces:
    """Section forces of a bar per unit of what acts on it, as columns of its points."""

    def __init__(self, points: Points, bar: BarLoads) -> None:
        self._points, self._bar = points, bar
        self._columns: list[int] = []
        if any(np.ndim(x) for x, _ in bar.points):
            return
        acting = [bar.accelerations, *(wrench for _, wrench in bar.points)]
        names = acceleration_units() + [
            name for x, _ in bar.points for name in wrench_units(f"x = {float(x):.4g} mm")
        ]
        self._columns = points.columns(np.concatenate(acting, axis=1).T, names)
        own, *units = np.split(np.eye(len(self._columns)), np.arange(4, len(self._columns), 6), 1)
        at = [(x, unit) for (x, _), unit in zip(bar.points, units, strict=True)]
        self._bar = replace(bar, points=at, accelerations=own)

    def at(self, places: FloatArray) -> tuple[list[int], BarForces]:
        """Columns, and the forces (k, columns) at places (k,) per unit of each.

        Where a contact slides past a place what acts is not in proportion: the columns are the
        section forces themselves, then.
        """
        forces = self._bar.at(places)
        if self._columns:
            return self._columns, forces
        rows = [getattr(forces, kind.name) for kind in fields(forces)]
        names = [
            in_section(float(x), _KINDS[kind.name])[0] for kind in fields(forces) for x in places
        ]
        columns = self._points.columns(np.concatenate(rows), names)
        return columns, BarForces(*np.split(np.eye(len(columns)), len(rows)))


def holds_last(loads: PartLoads, places: dict[str, float]) -> bool:
    """True if the interface farther along x takes the couples out of the plane."""
    at = places.get(loads.tilt_held_at or "")
    return at is not None and 2 * at > min(places.values()) + max(places.values())


def left_over(bar: BarLoads, loads: PartLoads, length: float) -> float:
    """Couples out of the plane that no interface holds, over the largest force times the length.

    In the plane nothing is left: an acceleration makes up for it.
    """
    couples = sum(wrench[:, 3:5] for _, wrench in bar.points)
    largest = loads.largest_force * length
    return float(np.abs(couples).max()) / largest if largest else 0.0


@dataclass(frozen=True, eq=False)
class BarPart:
    """A part that is a bar between two pins, with the points where its stress is asked.

    forces     its loads in balance
    length     mm, from pin to pin
    radii      mm, of the bores of both pins; 0 of an end face
    held_last  True if the second end takes the couples out of the plane (`tilt_held_at`)
    """

    part: Part
    loads: PartLoads
    forces: BarLoads
    mass: Stretches
    length: float
    points: Points
    radii: tuple[float, float]
    held_last: bool

    @classmethod
    def of(
        cls,
        part: Part,
        loads: PartLoads,
        places: dict[str, float],
        mass: Stretches,
        length: float,
        radii: tuple[float, float] = (0.0, 0.0),
    ) -> Self:
        """A bar without points yet; interfaces at x = `places`, as in `bar_loads`."""
        forces, points = bar_loads(part, loads, places, mass), Points(len(loads.accelerations))
        held_last = holds_last(loads, places)
        return cls(part, loads, forces, mass, length, points, radii, held_last)

    def model(
        self,
        *,
        neglects: str,
        local: Callable[[], float | None] | None = None,
        stretch: Mode | None = None,
        aside: Callable[[bool], Aside] | None = None,
        buckles: Callable[[], ElasticLoad] | None = None,
    ) -> RungModel:
        """The rung `formula` of its points; `local`, `stretch` and `aside` as in `elastic_load`.

        Nothing is known of a stretch by itself where `local` gives None: then no buckling load is.

        buckles  the buckling load by a model of the shape's own, in place of these
        """
        part, loads, bar, mass, length = self.part, self.loads, self.forces, self.mass, self.length

        def as_bar() -> ElasticLoad | None:
            known = 0.0 if local is None else local()
            if known is None:
                return None
            return elastic_load(
                part,
                loads,
                bar,
                mass,
                length,
                self.radii,
                held_last=self.held_last,
                local=known,
                stretch=stretch,
                aside=aside,
            )

        return self.points.model(
            residual=left_over(bar, loads, length),
            deflection=most_deflected(bar, part, mass, length),
            buckles=buckles or as_bar,
            neglects=neglects,
        )


def add_rectangle_fibres(
    points: Points,
    name: str,
    places: FloatArray,
    forces: BarForces,
    size: tuple[float, float],
    torsion: float,
) -> None:
    """Add corners and middles of the faces of solid rectangular sections.

    size     height along y and thickness along z, mm
    torsion  mm3, torque over the shear stress in the middle of the long faces
    """
    height, thickness = size
    area, inertia = height * thickness, thickness * height**3 / 12
    across = height * thickness**3 / 12
    for k, x in enumerate(places):
        axial, moment, bent, shear, torque = points.columns(
            np.stack(
                [
                    forces.axial[k],
                    forces.moment_z[k],
                    forces.moment_y[k],
                    forces.shear[k],
                    forces.torque[k],
                ]
            ),
            in_section(x, "axial force", "moment M_z", "moment M_y", "shear force", "torque"),
        )
        y, z = (half.ravel() for half in np.meshgrid([-0.5, 0.0, 0.5], [-0.5, 0.5]))
        y, z = y * height, z * thickness
        middle = (y == 0).astype(float)
        points.add(
            name,
            np.column_stack([np.full(len(y), x), y, z]),
            {
                axial: along_x(np.full(len(y), 1 / area)),
                moment: along_x(-y / inertia),
                bent: along_x(z / across),
                shear: sheared(middle * 1.5 / area),
                torque: sheared(-middle * np.sign(z) / torsion),
            },
        )


def most_deflected(loads: BarLoads, part: Part, mass: Stretches, length: float) -> float:
    """Largest displacement in the plane, mm: off the chord of the pins, or along it between them.

    Off the chord at the positions where the moment is largest at one of the places.
    """
    places = np.linspace(0.0, length, _STATIONS)
    forces = loads.at(places[1:-1])
    young = part.material.youngs_modulus
    inner = young * mass.at(mass.area, places[1:-1])
    along = np.abs(forces.axial / inner[:, None]).mean(axis=0).max() * length
    moment = np.pad(forces.moment_z, ((1, 1), (0, 0)), mode="edge")
    chosen = np.unique(np.abs(moment).argmax(axis=1))
    stiffness = young * mass.at(mass.inertia_z, places)
    off = np.abs(deflection(moment[:, chosen], stiffness, places)).max()
    return float(max(along, off))


def _worked(bar: BarLoads, first: float, last: float) -> FloatArray:
    """Mean compression (n,) from one place to another, N, weighed by cos^2 of a half wave."""
    share = (np.arange(_STATIONS) + 0.5) / _STATIONS
    weight = np.cos(pi * share) ** 2
    return np.asarray(-(weight / weight.sum()) @ bar.at(first + (last - first) * share).axial)


def as_plate(breadth: float, wall: float, *, free: bool = False) -> float:
    """E over the critical stress of a long plate, mm; `free` at one edge, or held at both."""
    return (_FREE if free else _HELD) * (breadth / wall) ** 2


def of_walls(most: float) -> float:
    """`ElasticLoad.local` of a part whose most slender wall has `most` for E over its stress."""
    return max(1.0, most / _STOUT)


def elastic_load(
    part: Part,
    loads: PartLoads,
    bar: BarLoads,
    mass: Stretches,
    length: float,
    radii: tuple[float, float] = (0.0, 0.0),
    *,
    held_last: bool = False,
    local: float = 0.0,
    stretch: Mode | None = None,
    aside: Callable[[bool], Aside] | None = None,
) -> ElasticLoad:
    """Largest share of the elastic buckling load over the positions.

    In the plane Euler's of a hinged column with the part's steps, from pin to pin: the push of a
    pin goes through its axis, however far the bore turns. Where the shape tells its shear area, the
    shear strain counts in both planes (Engesser). Out of the plane the same, with ends free to
    tilt, together with the lateral buckling of the bent bar. A part that is pulled at every
    position is no column; what bends it may buckle it sideways, and the pull counts as nothing, as
    it does for one that is hardly ever pressed.

    A pin that pushes presses on the side of its bore that faces the other pin: the resultant of its
    half cosine stands `PRESSED` radii from its centre, and the bore takes it along as it tilts
    out of the plane. Beyond it the bar carries nothing and stays straight, so the column's length
    is between both resultants. The compression is the mean over a column, weighed by the wave's
    squared slope, on which the force works.

    radii    mm, of the bores
    held_last  True if the second end holds it against twisting and not the first
    local    1/N, share that 1 N of compression is of the load under which a stretch of the part
             buckles by itself
    stretch  the mode of that; None where only its load is known
    aside    buckling out of the plane by a model of the shape's own, by whether what pulls counts
             as nothing
    """
    force = axial_compression(part, loads)
    largest = loads.largest_force
    only_pulled = bool(force.max() <= 0.0)
    pulled = bool(force.max() <= HARDLY * largest)
    if pulled:
        force = np.maximum(force, 0.0)
    places = np.linspace(0.0, length, _STATIONS)
    first, last = PRESSED * radii[0], length - PRESSED * radii[1]
    pressed_at, column = np.linspace(first, last, _STATIONS), last - first
    push = force
    within, force = (
        np.where(push > 0.0, np.maximum(_worked(bar, *ends), HARDLY * push), push)
        for ends in ((0.0, length), (first, last))
    )
    young, ratio = part.material.youngs_modulus, part.material.poisson_ratio
    flat, firm = (
        young * mass.at(mass.inertia_z, places),
        young * mass.at(mass.inertia_y, pressed_at),
    )
    racking = np.inf if mass.racking is None else young * mass.at(mass.racking, pressed_at)
    sliding = np.inf if mass.sliding is None else young * mass.at(mass.sliding, places)
    explain: Callable[[], Sequence[Item]]
    mode: Mode | None = half_wave(np.zeros(3), np.array([length, 0.0, 0.0]), "in plane")
    if aside is not None:
        euler = within / column_force(flat, sliding, length)
        (position,) = first_largest(euler)
        own = aside(pulled)
        if own.share > euler[position]:
            fixity = max(0.0, 1 - max(float(euler[position]), own.held) / own.share)
            items = partial(factor_items, own.share)
            load = ElasticLoad(own.share, own.position, own.words, items, LATERAL, pulled, fixity)
            return replace(load, mode=own.mode)
        explain = partial(column_items, float(within[position]), flat, sliding, length)
        load = ElasticLoad(float(euler[position]), position, _IN_PLANE, explain, pulled=pulled)
        return replace(load, plane="in plane", span=length, mode=mode)
    across = young * mass.at(mass.inertia_y, places)
    twisting = young / (2 * (1 + ratio)) * mass.at(mass.torsion, places)
    moment = bar.at(places).moment_z
    if only_pulled:
        least = _NO_MOMENT * largest * length
        moment = np.where(np.abs(moment) > least, moment, 0.0)
    pressing = force / column_force(firm, racking, column)
    aside_at = partial(
        lateral_share, stiffness=across, twisting=twisting, length=length, held_last=held_last
    )
    shares = {
        _IN_PLANE: within / column_force(flat, sliding, length),
        _SIDEWAYS: aside_at(pressing, moment),
        "a stretch by itself: plates and columns": push * local,
    }
    words = _SIDEWAYS if only_pulled else max(shares, key=lambda name: float(shares[name].max()))
    share = np.maximum(shares[words], 0.0)
    (position,) = first_largest(share)
    pressed = float((within if words == _IN_PLANE else force)[position])
    if words == _IN_PLANE:
        explain = partial(column_items, pressed, flat, sliding, length)
    elif words == _SIDEWAYS:
        bent = moment[:, [position]]
        alone = float(aside_at(np.zeros(1), bent)[0])
        explain = partial(column_items, pressed, firm, racking, column, alone)
        of_both = float(pressing[position]), bent[:, 0], (across, firm), twisting, length
        mode = partial(sideways, *of_both, (first, last), held_last)
    else:
        explain, mode = partial(stretch_items, float(push[position]), local), stretch
    told, most = _PULLED if only_pulled else words, float(share[position])
    fixity = 0.0
    if words == _SIDEWAYS and most > 0.0:
        others = max(float(one[position]) for name, one in shares.items() if name != _SIDEWAYS)
        fixity = 1 - max(others / most, 1 / _CLAMPED)
    load = ElasticLoad(most, position, told, explain, pulled=pulled, fixity=fixity, mode=mode)
    return replace(load, plane="in plane", span=length) if words == _IN_PLANE else load


def column_items(
    force: float,
    stiffness: FloatArray,
    shear: FloatArray | float,
    length: float,
    sideways: float | None = None,
) -> list[Item]:
    """Formulas of the share of a bar between its pins, as a hinged column.

    force      N, compression
    stiffness  (k,) N mm2, E I of the section at even places from pin to pin
    shear      N, shear stiffness there, (k,) or of all; infinite where no shear strain is counted
    length     mm, between the hinges
    sideways   share that its moments alone are of those that buckle it sideways; None where the
               share is the compression's alone
    """
    critical = _critical(force, stiffness, shear, length)
    return [*critical, *([_FORCE_SHARE] if sideways is None else _bent_besides(sideways))]


def stretch_items(force: float, local: float) -> list[Item]:
    """Formulas of the share of a stretch of a part that buckles by itself.

    force  N, compression
    local  1/N, share that 1 N is of the compression under which it buckles
    """
    return [
        Given("F", "largest compression", force, "N", "the loads", main=True),
        Given("F_cr", "force under which a stretch buckles by itself: plates and columns",
              1 / local, "N", "Timoshenko and Gere, 2nd ed., 9.2; docs/theory/rungs.md"),
        _FORCE_SHARE,
    ]  # fmt: skip


def factor_items(share: float) -> list[Item]:
    """How a share comes about that is an eigenvalue."""
    if not share > 0.0:
        return [Step(SHARE, "share of the elastic buckling load", "0", main=True)]
    return [
        Given("lam", "lowest factor on all loads at which the bar, or a rail, buckles",
              1 / share, "", "eigenvalue: docs/theory/rungs.md", main=True),
        Step(SHARE, "share of the elastic buckling load", "1/lam", main=True),
    ]  # fmt: skip


def _bent_besides(moments: float) -> list[Item]:
    """Out of the plane, where a bent bar also gives way sideways."""
    return [
        Step("p", "compression over it", "F/F_cr"),
        Given(
            "m",
            "share that the moments are of those that buckle the bar sideways: the lowest of an "
            "energy of three waves",
            moments,
            "",
            _LATERAL,
        ),
        Step(SHARE, "share of the elastic buckling load", "(p + sqrt(p^2 + 4*m^2))/2", "",
             _LATERAL, main=True),
    ]  # fmt: skip


def _critical(
    force: float, stiffness: FloatArray, shear: FloatArray | float, length: float
) -> list[Item]:
    """Compression, and the force under which such a hinged column buckles."""
    count = len(stiffness)
    weights = np.ones(count)
    weights[[0, -1]] = 0.5
    columns = [
        Column("t", "place over the length, times π", "", numbers(np.linspace(0, pi, count))),
        Column("w", "weight", "", numbers(weights)),
    ]
    bends = Column("B", "E I of the section there", "N mm2", numbers(stiffness))
    slides, gives = [], "w*sin(t)^2/B"
    if np.isfinite(shear).all():
        slides = [Column("K", "shear stiffness there", "N",
                         numbers(np.broadcast_to(np.asarray(shear), count)))]  # fmt: skip
        gives += " + w*(pi/L*cos(t))^2/K"
    names = tuple(f"station {number}" for number in range(1, count + 1))
    return [
        Given("F", "compression", force, "N", "the loads", main=True),
        Given("L", "length: in the plane between the pins, out of it between where they press",
              length, "mm", "pins' distance; out of the plane less 8/(3π) of the bores' radii"),
        Sum("Q_1", "work of the force, one wave", "w*(pi/L*cos(t))^2", names, tuple(columns), "",
            _QUOTIENT),
        Sum("Q_2", "what bends and slides", gives, names, (*columns, bends, *slides), "",
            _QUOTIENT),
        Step("F_cr", "buckling force of the hinged column", "Q_1/Q_2", "N", _QUOTIENT, main=True),
    ]  # fmt: skip


def add_tube_fibres(
    points: Points,
    name: str,
    places: FloatArray,
    sections: SectionForces,
    tube: Section,
    size: tuple[float, float],
) -> None:
    """Add corners and middles of the walls: sigma of N, M_z, M_y; shear of V in the cheeks."""
    width, wall = size
    half = width / 2
    y = half * np.array([1.0, 1.0, -1.0, -1.0, 0.0, 0.0, 1.0, -1.0])
    z = half * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 0.0, 0.0])
    cheek = (y == 0).astype(float)
    columns, forces = sections.at(places)
    stress = fibre_stress(forces, tube.area, y / tube.inertia_in_plane)
    stress[:, :, XX] += z[:, None] / tube.inertia_out_of_plane * forces.moment_y[:, None]
    # V S/(2 t I) in the middle of a thin square box: S = 3/8 of w^2 t, I = 2/3 w^3 t
    sheared = cheek[:, None] * 9 / (16 * (width - wall) * wall)
    stress[:, :, XY] = sheared * forces.shear[:, None]
    add_fibres(points, name, places, (y, z), columns, stress)


def fibre_stress(forces: BarForces, area: float, levers: FloatArray) -> FloatArray:
    """Stress (k, fibres, 6, columns) of N and M_z; levers (fibres,) y/I, 1/mm3."""
    stress = np.zeros((len(forces.axial), len(levers), 6, forces.axial.shape[1]))
    stress[:, :, XX] = forces.axial[:, None] / area - levers[:, None] * forces.moment_z[:, None]
    return stress


def add_fibres(
    points: Points,
    name: str,
    places: FloatArray,
    at: tuple[FloatArray, FloatArray],
    columns: list[int],
    stress: FloatArray,
) -> None:
    """Add fibres at y and z (fibres,) of the sections at places (k,)."""
    y, z = at
    x = np.repeat(places, len(y))
    found = np.column_stack([x, np.tile(y, len(places)), np.tile(z, len(places))])
    points.add_block(name, found, columns, stress.reshape(len(found), 6, -1))
