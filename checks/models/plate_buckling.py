"""Elastic buckling and deflection of a plate with pins, as a bar along its bores laid straight.

In the plane it is Euler's column, out of it a bar that is bent aside and twisted
(checks/handbook/lateral_buckling.py), held by the pins that hold the solid.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise

import numpy as np

from checks.design.data import Part
from checks.handbook.bar_forces import deflection
from checks.handbook.column_curves import column_force
from checks.handbook.lateral_buckling import (
    Acting,
    Chain,
    LateralBar,
    Pressed,
    Stiffness,
    bore_pressure,
    interpolated,
    spaced,
)
from checks.models.bar_modes import Mode, bent_aside, laid_straight
from checks.models.formula_bars import ASIDE, HARDLY, LATERAL, column_items, factor_items
from checks.models.formula_points import Points, acceleration_units, wrench_units
from checks.part.part_loads import PartLoads, first_largest
from checks.part.plate_loads import FlatSection, PlateLoads
from checks.stress.stress_result import ElasticLoad
from fem.mode_count import nearness
from geometry.bars import rectangle_torsion
from geometry.mesh import FloatArray
from geometry.parts.plate import Plate

_STATIONS = 33
_OF_ARM = 13  # stations of an arm, from bore to bore
_MEMBERS = 6  # of an arm
_OF_MODE = 65  # places at which a mode is told
_IN_PLANE = "in plane: Euler's column along its bores, under the largest compression of its arms"


class PlateForces(PlateLoads):
    """Loads on a plate, as columns of a model's points."""

    def __init__(self, part: Part, shape: Plate, loads: PartLoads, points: Points) -> None:
        super().__init__(part, shape, loads)
        units = acceleration_units() + [unit for name in self.names for unit in wrench_units(name)]
        self.columns = points.columns(self.acting, units)

    @cached_property
    def way(self) -> "_Way | None":
        """The plate as a bar along the bores' longest way; None where that leaves the plate."""
        return _along(self)

    @cached_property
    def residual(self) -> float:
        """Couples out of the plane that no bore holds, over the largest force times the length."""
        largest = self.loads.largest_force * self.shape.length
        couples = sum(self.loads.wrenches[name][:, 3:5] for name in self.names)
        return float(np.abs(couples).max()) / largest if largest else 0.0


def elastic_load(part: Part, forces: PlateForces) -> ElasticLoad | None:
    """Largest share of the elastic buckling load over the positions.

    The plate is a bar along the longest way from bore to bore, laid straight. In the plane it is
    hinged at both ends; what holds it at bores between is left out, and its largest compression
    acts all along it. Out of the plane it is held where the solid is, at two pins
    (fem/mode_count.py), and free to tilt.
    """
    way = forces.way
    if way is None:
        return None
    flat = part.material.youngs_modulus * way.flat
    force = (-(way.axial @ forces.acting)).max(axis=0)
    pulled = bool(force.max() <= HARDLY * forces.loads.largest_force)
    force = np.maximum(force, 0.0)
    column = force / column_force(flat, np.inf, way.length)
    sideways = _sideways(part, forces, pulled)
    if sideways is None:
        return None
    aside, where, held, mode = sideways
    (position,) = first_largest(column)
    if column[position] >= aside:
        explain = partial(column_items, float(force[position]), flat, np.inf, way.length)
        load = ElasticLoad(float(column[position]), position, _IN_PLANE, explain, pulled=pulled)
        mode = laid_straight(way.corners)
        return replace(load, plane="in plane", span=way.length, mode=mode)
    explain, fixity = partial(factor_items, aside), 1 - max(column[position], held) / aside
    found = ElasticLoad(aside, where, ASIDE, explain, LATERAL, pulled, max(0.0, fixity))
    return replace(found, mode=mode) if aside > 0.0 else found


def _turned_into(arm: complex, wrench: FloatArray) -> FloatArray:
    """A wrench (n, 6) with its forces along and across an arm, a unit vector."""
    local = (wrench[:, 0] + 1j * wrench[:, 1]) * np.conj(arm)
    found = wrench.copy()
    found[:, 0], found[:, 1] = local.real, local.imag
    return found


def _holding(forces: PlateForces, way: Sequence[str]) -> list[str]:
    """The bores at which the solid is held, the one that holds its twist first.

    Where one of them stands beside the way, the ends of the way, the nearest to that one first.
    """
    at = {bore.name: np.array([bore.centre.real, bore.centre.imag]) for bore in forces.shape.bores}
    first = forces.loads.tilt_held_at or forces.names[0]
    near = sorted(forces.names, key=lambda name: (name != first, nearness(at[name], at[first])))
    held = near[:2]
    return held if {*held} <= {*way} else [name for name in near if name in (way[0], way[-1])]


def _sideways(
    part: Part, forces: PlateForces, pulled: bool
) -> tuple[float, int, float, Mode] | None:
    """Share out of the plane, where, the share with forks that hold against tilting, and the mode.

    None where an arm leaves the plate.

    The section of a bore is the plate beside it, and turns the bore as a whole under its pressure,
    taken along the arm it is in; in a bend the mean along both arms.

    pulled  True if what pulls counts as nothing
    """
    shape, depth = forces.shape, forces.shape.thickness
    way = [shape.bores[k] for k in shape.longest_way]
    reached = np.r_[0.0, np.cumsum(np.abs(np.diff([bore.centre for bore in way])))]
    places, heights, nodes = [], [], []
    acting: list[FloatArray] = []
    for k, (low, high) in enumerate(pairwise(way)):
        arm = float(reached[k + 1] - reached[k])
        along = (high.centre - low.centre) / arm
        ahead = {shape.bores[n].name: 1.0 for n in shape.beyond(low, high)}
        for step in np.linspace(0.0, arm, _OF_ARM):
            cut = shape.outline.cut(low.centre + along * float(step), along)
            if cut is None:
                return None
            places.append(reached[k] + step)
            heights.append(cut.ends[1] - cut.ends[0])
            section = FlatSection(cut, depth).filled()
            acting.append(forces.across(section, ahead) @ forces.acting)
        nodes += [*np.linspace(0.0, arm, _MEMBERS + 1), low.diameter / 2, arm - high.diameter / 2]
        nodes[-_MEMBERS - 3 :] = [float(reached[k] + node) for node in nodes[-_MEMBERS - 3 :]]
    young, twists = part.material.youngs_modulus, 2 * (1 + part.material.poisson_ratio)

    def stiffness(x: FloatArray) -> Stiffness:
        height = np.interp(x, places, heights)
        open_ = sum(
            2 * np.sqrt(np.maximum((bore.diameter / 2) ** 2 - (x - at) ** 2, 0.0))
            for bore, at in zip(way, reached, strict=True)
        )
        left = height - open_
        torsion = rectangle_torsion(height, depth)[0] * left / height
        return Stiffness(
            young * left * depth**3 / 12,
            young / twists * torsion,
            np.zeros_like(x),
            (height**2 + depth**2) / 12,
        )

    chain = Chain(spaced(np.array(nodes)), stiffness)
    axial, shear, moment = (
        interpolated(np.array(places), np.array(rows), chain.points)
        for rows in np.swapaxes(np.array(acting), 0, 1)
    )
    arms = np.diff([bore.centre for bore in way])
    arms /= np.abs(arms)
    pressed = []
    for k, (bore, at) in enumerate(zip(way, reached, strict=True)):
        radius = 0.0 if pulled else bore.diameter / 2
        wrench = forces.loads.wrenches[bore.name]
        beside = [_turned_into(arm, wrench) for arm in arms[max(k - 1, 0) : k + 1]]
        pressure = np.mean([bore_pressure(radius, local) for local in beside], axis=0)
        pressed.append(Pressed(0, float(at), pressure))
    if pulled:
        axial = np.minimum(axial, 0.0)
    names = [bore.name for bore in way]
    held = [(0, float(reached[names.index(name)])) for name in _holding(forces, names)]
    bar, acts = LateralBar([chain], held), Acting(axial, moment, shear)
    share, position, stiff = bar.worst_of_forks([acts], pressed)

    def mode(nodes: FloatArray) -> FloatArray:
        along = np.linspace(0.0, float(reached[-1]), _OF_MODE)
        found = bar.mode([acts.at(position)], [one.at(position) for one in pressed])
        (aside, twist), (slope, _) = found.at(0, along), found.at(0, along, 1)
        corners = np.array([bore.centre for bore in way])
        return bent_aside(corners, along, aside, slope, twist)(nodes)

    return share, position, stiff, mode


def deflected(part: Part, forces: PlateForces) -> float:
    """Largest displacement in the plane, mm: off the chord of the ends of the bores' way."""
    way = forces.way
    if way is None:
        return np.inf
    young = part.material.youngs_modulus
    places = np.linspace(0.0, way.length, _STATIONS)
    moments = way.moment @ forces.acting
    chosen = np.unique(np.abs(moments).argmax(axis=1))
    off = deflection(moments[:, chosen], young * way.flat, places)
    along = np.abs(way.axial @ forces.acting) / way.area[:, None] / young
    return float(max(np.abs(off).max(), along.mean(axis=0).max() * way.length))


@dataclass(frozen=True, eq=False)
class _Way:
    """The bar along the bores' longest way, at even places (k,).

    corners         (b,) mm, x + i y of its bores
    length          mm
    area            (k,) mm2
    flat            (k,) mm4, bending in the plane
    axial, moment   (k, columns) N and N mm per unit of what acts
    """

    corners: FloatArray
    length: float
    area: FloatArray
    flat: FloatArray
    axial: FloatArray
    moment: FloatArray


def _along(forces: PlateForces) -> _Way | None:
    """The bar; None where the way leaves the plate."""
    shape = forces.shape
    way = [shape.bores[k] for k in shape.longest_way]
    corners = np.array([bore.centre for bore in way])
    reached = np.r_[0.0, np.cumsum(np.abs(np.diff(corners)))]
    rows = []
    for place in np.linspace(0.0, reached[-1], _STATIONS):
        k = int(np.clip(np.searchsorted(reached, place) - 1, 0, len(way) - 2))
        low, high, arm = way[k], way[k + 1], float(reached[k + 1] - reached[k])
        along = complex(corners[k + 1] - corners[k]) / arm
        inside = np.clip(place - reached[k], low.diameter / 2, arm - high.diameter / 2)
        cut = shape.outline.cut(low.centre + along * float(inside), along)
        if cut is None:
            return None
        section = FlatSection(cut, shape.thickness).filled()
        ahead = {shape.bores[n].name: 1.0 for n in shape.beyond(low, high)}
        axial, _, moment = forces.across(section, ahead)
        rows.append((section.area, section.inertia, axial, moment))
    columns = (np.array(column) for column in zip(*rows, strict=True))
    return _Way(corners, float(reached[-1]), *columns)


def directed(along: complex, axial: FloatArray, shear: FloatArray) -> FloatArray:
    """Stress (..., 6) of a normal stress along a unit vector and of shear across it."""
    c, s = along.real, along.imag
    found = np.zeros((*axial.shape, 6))
    found[..., 0] = axial * c**2 - 2 * c * s * shear
    found[..., 1] = axial * s**2 + 2 * c * s * shear
    found[..., 3] = axial * c * s + (c**2 - s**2) * shear
    return found
