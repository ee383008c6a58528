"""A crooked column that is bent besides: how far all loads may be raised until its edge yields.

First-order moments (couples at the pins with their friction, weight and inertia, offsets of the
force) grow with the axial force F, and so does what a crooked or eccentric column adds to them.
With a moment's sine series b_n over the length, r = F/F_cr and hinged ends (Timoshenko and Gere,
Theory of Elastic Stability, 2nd ed., 1.11)

    M(x) = M_1(x) + sum b_n r/(n^2 - r) sin(n pi x/L)

which for a crookedness e sin(pi x/L) is F e/(1 - r) and for equal end moments the secant formula.
The stress F/A + M/W rises faster than the load: the safety is the factor on all loads at which it
reaches yield, never the ratio of stresses.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isfinite, pi

import numpy as np

from checks.columns.column_limits import Plane, is_stepped, whole_force
from checks.design.data import Part
from checks.handbook.column_curves import BOW
from checks.part.part_loads import PartLoads, first_largest
from geometry.bars import Section
from geometry.mesh import FloatArray, IntArray
from geometry.roots import root

STRAIGHTNESS = 1000.0  # L/e of a bar without a stated curve or crookedness
_TERMS = 9  # of the moments' sine series
_ORDER = np.arange(1, _TERMS + 1)
_SQUARES = _ORDER**2.0
_EVEN = 4 / (pi * _ORDER) * (_ORDER % 2)  # of an even moment
_CLOSE = 1e-9  # of the load factor
_ROUND_OFF = 1e-6  # of a stress: more than what `first_largest` takes as equal
_EXACT = 1e-13  # of the load factor of one edge
_NO_MOMENT = 1e-9  # of the largest force times the length
GRID = 129  # even places along the part at which moments are computed


def axial_compression(part: Part, loads: PartLoads) -> FloatArray:
    """Compressive force (n,), the larger one of a part's two ends, N; < 0 is tension.

    The ends differ by the part's weight and inertia.
    """
    first, second = part.geometry.interfaces[:2]
    return np.asarray(np.maximum(loads.wrenches[first][:, 0], -loads.wrenches[second][:, 0]))


@dataclass(frozen=True, eq=False)
class CrookedColumn:
    """A part's sections under all positions at which it is compressed, one plane crooked.

    plane       the crooked one
    other       the other one
    positions   (n,)     which of all positions these are, or are next to
    sections    (k,)
    force       (n,)     N, compression
    places      (k,)     share of the length
    areas       (k,)     mm2
    moduli      (2, k)   mm3, W in the crooked plane and in the other
    moments     (2, n, k)  N mm, first order
    series      (2, n, m)  N mm, their sine series
    critical    (2,)     N, Euler's force in both planes; infinite for a plane without moments
    bow         (k,)     mm, crookedness
    beside      mm, eccentricity
    """

    plane: Plane
    other: Plane
    positions: IntArray
    sections: Sequence[Section]
    force: FloatArray
    places: FloatArray
    areas: FloatArray
    moduli: FloatArray
    moments: FloatArray
    series: FloatArray
    critical: FloatArray
    bow: FloatArray
    beside: float

    def stress(
        self,
        factor: float,
        rows: int | slice | IntArray = slice(None),
        places: int | slice = slice(None),
    ) -> FloatArray:
        """Largest compressive stress (n, k), MPa, under all loads times `factor`.

        One row at one place, both by number, takes a fifth of the time.
        """
        force = factor * (self.force[rows] if isinstance(rows, int) else self.force[rows, None])
        total = force / self.areas[places]
        waves = self._waves[:, places]
        for plane in (0, 1):
            moment = abs(factor * self.moments[plane][rows, places])
            if isfinite(self.critical[plane]):
                ratio = force / self.critical[plane]
                grown = ratio / (_SQUARES - ratio)
                series = factor * self.series[plane][rows]
                moment += abs((grown * series) @ waves)
                if plane == 0:
                    moment += force * (self.bow[places] / (1 - ratio))
                if plane == 0 and self.beside:
                    moment += force * self.beside * (1 + (grown * _EVEN) @ waves)
            total += moment / self.moduli[plane][places]
        return np.asarray(total)

    @cached_property
    def _waves(self) -> FloatArray:
        """The series' sines (m, k) at the places."""
        return np.asarray(np.sin(pi * _ORDER[:, None] * self.places))

    def load_factor(self, yield_stress: float) -> tuple[float, int, int]:
        """Least factor on all loads at which an edge yields, and at which position and place."""
        largest = float((self.force / self.critical.min()).max())
        factor = min(1.0, 0.5 / largest)
        row, place = self._worst_at(factor)
        best = (np.inf, row, place)
        while True:
            found = self._factor_at(row, place, yield_stress)
            if not found < best[0] * (1 - _CLOSE):
                return best
            best = (found, row, place)
            if found * largest >= 1:  # another position is beyond its critical force there
                (row,) = first_largest(self.force)
                (place,) = first_largest(self._near_critical(row))
                continue
            row, place = self._worst_at(found)
            if (row, place) == best[1:]:
                return best

    def _worst_at(self, factor: float) -> tuple[int, int]:
        """Row and place of the largest stress, under loads that buckle the part in no row.

        Rows are left out whose bound is below the stress of the one with the largest bound.
        """
        bound = self._bound(factor)
        first = int(bound.argmax())
        least = float(self.stress(factor, slice(first, first + 1)).max())
        rows = np.flatnonzero(bound >= least * (1 - _ROUND_OFF))
        row, place = first_largest(self.stress(factor, rows))
        return int(rows[row]), place

    def _bound(self, factor: float) -> FloatArray:
        """Bound (n,) of the stress of each row, MPa: every wave has its crest at the worst place.

        Only below the critical force. Waves of higher order grow no more than the second does.
        """
        force = factor * self.force
        total = factor * self._straight
        for plane, (first, others) in enumerate(self._sizes):
            if not isfinite(self.critical[plane]):
                continue
            ratio = force / self.critical[plane]
            grown, less = ratio / (1 - ratio), ratio / (4 - ratio)
            moment = factor * (grown * first + less * others)
            if plane == 0:
                even = grown * _EVEN[0] + less * np.abs(_EVEN[1:]).sum()
                moment += force * (self.bow.max() / (1 - ratio) + self.beside * (1 + even))
            total += moment / self.moduli[plane].min()
        return np.asarray(total)

    @cached_property
    def _sizes(self) -> FloatArray:
        """Sizes (2, 2, n) of the first wave of each plane, and of all others together, N mm."""
        sizes = np.abs(self.series)
        return np.stack([sizes[:, :, 0], sizes[:, :, 1:].sum(axis=2)], axis=1)

    @cached_property
    def _straight(self) -> FloatArray:
        """Bound (n,) of the stress of the undeformed part, MPa: its least section is everywhere."""
        largest = np.maximum(self.moments.max(axis=2), -self.moments.min(axis=2))
        bent = (largest / self.moduli.min(axis=1)[:, None]).sum(axis=0)
        return np.asarray(self.force / self.areas.min() + bent)

    def _near_critical(self, row: int) -> FloatArray:
        factor = 0.999 * float(self.critical.min() / self.force[row])
        return np.asarray(self.stress(factor, slice(row, row + 1))[0])

    def _factor_at(self, row: int, place: int, yield_stress: float) -> float:
        force = float(self.force[row])
        # the edge yields at the latest where the stress without growth does
        straight = force / self.areas[place] + sum(
            abs(self.moments[plane][row, place]) / self.moduli[plane][place] for plane in (0, 1)
        )
        most = yield_stress / straight if straight else np.inf
        most = min(most, float(self.critical.min()) / force) if force else most

        def over(share: float) -> float:
            return float(self.stress(share * most, row, place) / yield_stress - 1)

        top = 1 - 1e-12
        if over(top) <= 0:
            return float(most)
        return most * root(over, 0.0, top, _EXACT)


@dataclass(frozen=True, eq=False)
class _Pressed:
    """A part at the positions that compress it, before it is taken to be crooked in a plane.

    Where the compression ends between two positions, that place is one more: as it does not bend
    less there, the positions alone would leave out what lies between them.

    positions  (n,)    which of all positions these are, or are next to
    force      (n,)    N, compression
    places     (k,)    share of the length
    sections   (k,)
    moments    plane -> (n, k) N mm, first order
    series     plane -> (n, m) N mm, their sine series
    bent       plane -> whether there are any
    """

    positions: IntArray
    force: FloatArray
    places: FloatArray
    sections: list[Section]
    moments: dict[str, FloatArray]
    series: dict[str, FloatArray]
    bent: dict[str, bool]


def _pressed(part: Part, loads: PartLoads, length: float, mass: float | None) -> _Pressed:
    force = axial_compression(part, loads)
    mix, pressed = _compressed(force, loads.steps)
    waves = np.sin(pi * _ORDER[:, None] * np.linspace(0.0, 1.0, GRID))
    weights = np.full(GRID, 1 / (GRID - 1))
    weights[[0, -1]] /= 2
    places, sections = _stations(part, length)
    largest = _NO_MOMENT * length * force.max()
    force = np.maximum(mix(force), 0.0)  # nothing, less round-off, where it ends
    moments, series, bent = {}, {}, {}
    planes = first_order(part, loads, length, mass)
    for name, whole in zip(("in plane", "out of plane"), planes, strict=True):
        moment = FirstOrder(mix(whole.acting), whole.shapes)
        series[name] = moment.over(2 * weights * waves)
        moments[name] = moment.at(places)
        bent[name] = bool(np.abs(moment.moments).max() > largest)
    return _Pressed(pressed, force, places, sections, moments, series, bent)


def _compressed(
    force: FloatArray, steps: IntArray
) -> tuple[Callable[[FloatArray], FloatArray], IntArray]:
    """Positions under compression and places where it ends: what mixes loads to them, and which.

    force  (n,)  N, compression
    steps  (m,)  positions after which the loads go on to the next one without a jump

    The function takes loads (n, ...) to those (k, ...) at the k positions and places; these are
    numbered (k,) by the position that is compressed.
    """
    own = np.flatnonzero(force > 0)
    before, after = force[steps], force[steps + 1]
    ends = (before > 0) != (after > 0)
    first, before, after = steps[ends], before[ends], after[ends]
    share = before / (before - after)

    def mix(values: FloatArray) -> FloatArray:
        part = share.reshape(-1, *[1] * (values.ndim - 1))
        between = (1 - part) * values[first] + part * values[first + 1]
        return np.concatenate([values[own], between])

    return mix, np.concatenate([own, np.where(before > 0, first, first + 1)])


def _crooked(part: Part, pressed: _Pressed, plane: Plane, other: Plane) -> CrookedColumn:
    sides = (plane, other)
    sections = pressed.sections
    moduli, critical = [], []
    for side in sides:
        moduli.append([inertia / half for inertia, half in map(side.built_up, sections)])
        carried = min(whole_force(part, side, section) for section in set(sections))
        judged = side is plane or pressed.bent[side.name]
        critical.append(carried if judged else np.inf)  # its own check judges it
    return CrookedColumn(
        plane,
        other,
        pressed.positions,
        sections,
        pressed.force,
        pressed.places,
        np.array([section.area for section in sections]),
        np.array(moduli),
        np.stack([pressed.moments[side.name] for side in sides]),
        np.stack([pressed.series[side.name] for side in sides]),
        np.array(critical),
        crookedness(part, plane) * np.sin(pi * pressed.places),
        part.column.eccentricity,
    )


def crooked_columns(
    part: Part, loads: PartLoads, planes: tuple[Plane, Plane], mass: float | None = None
) -> list[CrookedColumn]:
    """The part crooked in each of both planes; a stated `mass` of its body, t, is its own."""
    pressed = _pressed(part, loads, planes[0].own, mass)
    return [_crooked(part, pressed, *both) for both in (planes, planes[::-1])]


def crookedness(part: Part, plane: Plane) -> float:
    """Largest initial deflection, mm: as stated, as Eurocode 3 has it for the curve, or L/1000."""
    column = part.column
    if column.crookedness is not None:
        return column.crookedness
    return plane.length / (STRAIGHTNESS if column.curve is None else BOW[column.curve])


def _stations(part: Part, length: float) -> tuple[FloatArray, list[Section]]:
    """Places, as shares of the length, at which each section is judged."""
    places, sections = [], []
    for section in part.geometry.sections:
        start, stop = (0.0, length) if section.stretch is None else section.stretch
        found = np.linspace(start / length, stop / length, 33)
        places.append(found)
        sections += [section] * len(found)
    return np.concatenate(places), sections


# First-order moments of a part as a column: those of the undeformed part between its two pins.
#
# They are linear in what acts on the part, so each is a shape along the part times a size per
# position: what follows from the shapes is computed once and not at every position.


@dataclass(frozen=True, eq=False)
class FirstOrder:
    """Moments of a part in one plane, (n, m) N mm: acting @ shapes.

    acting  (n, r) couples at both pins, N mm; forces across there, N, or accelerations
    shapes  (r, 129) moment per unit, at even places between the pins
    """

    acting: FloatArray
    shapes: FloatArray

    @property
    def moments(self) -> FloatArray:
        """The moments (n, 129), N mm."""
        return self.acting @ self.shapes

    def at(self, places: FloatArray) -> FloatArray:
        """Moments (n, k), N mm, at places (k,), shares of the length: straight between the 129."""
        grid = np.linspace(0.0, 1.0, GRID)
        shapes = np.stack([np.interp(places, grid, shape) for shape in self.shapes])
        return np.asarray(self.acting @ shapes)

    def over(self, rows: FloatArray) -> FloatArray:
        """Weighted sums (n, m) of the moments, N mm, by rows (m, 129) of weights."""
        return self.acting @ (self.shapes @ rows.T)


def first_order(
    part: Part, loads: PartLoads, length: float, mass: float | None = None
) -> tuple[FirstOrder, FirstOrder]:
    """Moments about z and about y of the undeformed part.

    About z those of a bar on two supports: of the couples at its pins, and of the weight and
    inertia of its sections. All other mass (eyes, what stands beyond the pins) is at the pins,
    whose forces carry it there. A stated `mass` of the body, t, is spread as the sections' is.
    About y, where no inertia acts, from both ends towards the other, each in its share.
    """
    first, second = (loads.wrenches[name] for name in part.geometry.interfaces[:2])
    x = np.linspace(0.0, length, GRID)
    share = x / length
    own = _own_shapes(part, x, mass)
    turned = [share - 1.0, share]
    # a force along z has a lever about -y
    across = [(share - 1.0) * x, share * (x - length)]
    z = [first[:, 5], second[:, 5], loads.accelerations[:, 1], loads.accelerations[:, 2]]
    y = [first[:, 4], second[:, 4], first[:, 2], second[:, 2]]
    return (
        FirstOrder(np.stack(z, axis=1), np.stack([*turned, *own])),
        FirstOrder(np.stack(y, axis=1), np.stack([*turned, *across])),
    )


def _own_shapes(part: Part, x: FloatArray, mass: float | None) -> list[FloatArray]:
    """Moment about z, (m,) each, of the sections' mass per unit of a_y and of alpha.

    Between supports at both ends.
    """
    areas = _areas(part, x)
    volumes = _cumulated(areas * np.stack([x**0, x, x**2]), x)
    density = part.material.density if mass is None else mass / float(volumes[0, -1])
    shapes = []
    for order in (0, 1):
        alone = density * (volumes[order + 1] - x * volumes[order])  # the first end free
        shapes.append(alone - x / x[-1] * alone[-1])
    return shapes


def _areas(part: Part, x: FloatArray) -> FloatArray:
    """Area of the section at each place, mm2; the largest where stretches are not told."""
    sections = part.geometry.sections
    if not is_stepped(part):
        return np.full(len(x), max(section.area for section in sections))
    areas = np.zeros(len(x))
    for section in sections:
        assert section.stretch is not None
        areas[(x >= section.stretch[0]) & (x <= section.stretch[1])] = section.area
    return areas


def _cumulated(values: FloatArray, x: FloatArray) -> FloatArray:
    """Integral (n, k) from the first place to each, by trapezoids."""
    pieces = (values[:, 1:] + values[:, :-1]) / 2 * np.diff(x)
    return np.concatenate([np.zeros((len(values), 1)), np.cumsum(pieces, axis=1)], axis=1)
