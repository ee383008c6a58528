"""What is judged at the worst point of a part, and its error bars from one mesh to the next."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import degrees, isfinite, pi
from weakref import WeakKeyDictionary

import numpy as np

import fatigue
from ballesta.design_data import Part
from ballesta.duty_verdict import WHOLE_DUTY, FatiguePeak
from ballesta.finite_life import DutyLife, LifeTask, lives_of, shortest_life
from ballesta.levels import Level, peak_of
from ballesta.part_loads import PartLoads
from fem.convergence import (
    ErrorBar,
    discretisation_error,
    growth_exponent,
    moves_like_singular,
)
from fem.direct import direct_stress, has_bearings
from fem.recovery import von_mises
from fem.singularity import singular_exponent
from geometry.mesh import FloatArray, IntArray

_UNRESOLVED = 0.05  # error that elements make in a notch, over the peak


@dataclass(frozen=True)
class Bars:
    """Numerical error bar, model band above and below, and what must be said of them."""

    numerical: ErrorBar
    above: float
    below: float
    note: str


class Judged(ABC):
    """A quantity of a part that is judged at its worst point."""

    @abstractmethod
    def value(self, level: Level) -> float:
        """The quantity on one mesh, MPa."""

    @abstractmethod
    def point(self, level: Level) -> int:
        """Index of the surface point that carries it."""

    @abstractmethod
    def at(self, level: Level, points: IntArray) -> FloatArray:
        """The quantity at some surface points (n,), MPa."""

    @abstractmethod
    def scatter(self, level: Level) -> float:
        """Scatter of the elements that meet at the point, in the quantity, MPa."""

    @abstractmethod
    def states(self, level: Level) -> list[FloatArray]:
        """Coefficients (n_basis,) of the load states whose stress it is made of."""

    @abstractmethod
    def direct(self, level: Level, arc: float) -> float:
        """The quantity under bearing pressures as they are, on an arc, without a series."""


@dataclass(frozen=True, eq=False)
class StaticPeak(Judged):
    """The largest von Mises stress over all cycles."""

    loads: PartLoads

    def value(self, level: Level) -> float:
        """The quantity on one mesh, MPa."""
        return level.peak.value

    def point(self, level: Level) -> int:
        """Index of the surface point that carries it."""
        return level.peak.point

    def at(self, level: Level, points: IntArray) -> FloatArray:
        """Von Mises stress at some surface points (n,) at the position of the peak, MPa."""
        return von_mises(level.history.at(level.peak.position)[points])

    def states(self, level: Level) -> list[FloatArray]:
        """The load state of the peak."""
        return [level.coefficients[:, level.peak.position]]

    def scatter(self, level: Level) -> float:
        """Scatter of the elements that meet at the point, MPa."""
        return level.scatter(self.states(level)[0], level.peak.point)

    def direct(self, level: Level, arc: float) -> float:
        """The peak at the same position under pressures as they are."""
        return peak_of(_direct(self.loads, level, level.peak.position, arc))


@dataclass(frozen=True, eq=False)
class FatigueUse(Judged):
    """The largest fatigue utilisation over the duty, times the endurance limit.

    limit     MPa, endurance limit away from notches
    ultimate  MPa

    Goodman's or Findley's, whichever is worse. Its bars are those of the pair of positions that
    decides, as Goodman judges it, in proportion.
    """

    loads: PartLoads
    limit: float
    ultimate: float

    def worst(self, level: Level) -> FatiguePeak:
        """The point and the pair of positions."""
        assert level.fatigue is not None
        return level.fatigue

    def value(self, level: Level) -> float:
        """The quantity on one mesh, MPa."""
        return self.worst(level).value

    def point(self, level: Level) -> int:
        """Index of the surface point that carries it."""
        return self.worst(level).point

    def at(self, level: Level, points: IntArray) -> FloatArray:
        """Equivalent amplitude at some surface points (n,) on the path that decides, MPa."""
        assert level.duty is not None
        return level.duty.utilisation_at(points) * self.limit

    def states(self, level: Level) -> list[FloatArray]:
        """Half the swing, and the middle, of the pair of positions."""
        first, second = (level.coefficients[:, k] for k in self.worst(level).pair)
        return [(first - second) / 2, (first + second) / 2]

    def scatter(self, level: Level) -> float:
        """Scatter of amplitude and mean, as they enter the quantity, MPa."""
        point = self.point(level)
        swing, middle = (level.scatter(state, point) for state in self.states(level))
        factor = self.limit / float(level.limits[point])
        return self._over_pair(level) * (factor * swing + middle * self.limit / self.ultimate)

    def direct(self, level: Level, arc: float) -> float:
        """The quantity between the same two positions under pressures as they are."""
        pair = [_direct(self.loads, level, k, arc) for k in self.worst(level).pair]
        stress = np.stack(pair, axis=2)
        return self._over_pair(level) * self._of_pair(stress, level.limits)

    def safety_missed(self, level: Level) -> float:
        """How far from 1 the safety is that all loads times the safety leave."""
        assert level.duty is not None
        return level.duty.safety_missed()

    def _of_pair(self, stress: FloatArray, limits: FloatArray) -> float:
        """Goodman's equivalent amplitude of two states, stress (n, 6, 2), at the worst point."""
        result = fatigue.goodman(stress, np.eye(2), limits, self.ultimate)
        return float(result.utilisation.max()) * self.limit

    def _over_pair(self, level: Level) -> float:
        """The quantity over Goodman's for the deciding pair at its point: 1 where he decides."""
        point = [self.point(level)]
        pair = level.coefficients[:, list(self.worst(level).pair)]
        judged = self._of_pair(level.history.basis[point] @ pair, level.limits[point])
        return self.value(level) / judged if judged else 1.0


@dataclass(frozen=True, eq=False)
class LifeUse(FatigueUse):
    """The endurance limit over the safety that a finite life leaves: Miner's sum over the duty.

    task  what the life is asked of
    """

    task: LifeTask
    _lives: WeakKeyDictionary[Level, DutyLife] = field(default_factory=WeakKeyDictionary)

    def life(self, level: Level) -> DutyLife:
        """Life of the worst point of a level, sought once."""
        assert level.duty is not None
        if level not in self._lives:
            self._lives[level] = shortest_life(level.duty, self.task)
        return self._lives[level]

    def worst(self, level: Level) -> FatiguePeak:
        """The point that lasts the shortest, and the ends of the longest chord of its path."""
        life = self.life(level)
        value = self.limit / life.safety
        return FatiguePeak(value, life.point, WHOLE_DUTY, life.pair, "Miner")

    def safety_missed(self, level: Level) -> float:
        """How far from 1 the safety is that all loads times the safety leave, counted again."""
        life = self.life(level)
        if not isfinite(life.safety):
            return 0.0
        assert level.duty is not None
        (again,) = lives_of(level.duty, self.task, np.array([life.point]), life.safety)
        return abs(again.safety - 1.0)


def bars_of(judged: Judged, part: Part, levels: Sequence[Level], accuracy: float) -> Bars:
    """Numerical bar, model band and a note for a quantity known on several meshes."""
    finest = levels[-1]
    value = judged.value(finest)
    by_arc = {arc: judged.direct(finest, arc) for arc in arcs_of(part, finest)}
    values = [judged.value(level) for level in levels]
    sizes = sizes_at_peak(judged, levels)
    angle, exponent = _singular_edge(judged, levels)
    notch = finest.notch_error(judged.point(finest))
    # a notch that the mesh does not follow yet grows, too; its own error is in the bar
    grows = 0.0 if exponent or notch > _UNRESOLVED else growth_exponent(values, sizes)
    bar = ErrorBar(
        discretisation_error(values, sizes),
        judged.scatter(finest),
        abs(by_arc[pi] - value) if by_arc else 0.0,
        abs(value),
        exponent or grows,
        notch * abs(value),
    )
    notes = []
    if exponent:
        notes.append(
            f"singular: a sharp re-entrant edge of {degrees(angle):.0f} deg, where stress grows "
            f"like 1/distance^{exponent:.2f} and {value:.4g} MPa is only what this mesh "
            "shows; give the edge its radius"
        )
    elif grows:
        notes.append(
            f"singular: the peak grows like 1/size^{grows:.2f} of the elements from mesh to mesh, "
            f"and {value:.4g} MPa is only what the last one shows"
        )
    elif bar.value > accuracy * abs(value):
        notes.append(
            f"numerical error {100 * bar.value / abs(value):.2g} %, asked for {100 * accuracy:g} %"
            + (": elements too large for the notch at the peak" if bar.notch_decides else "")
        )
    if by_arc:
        by = ", ".join(f"{degrees(a):.0f} deg {v:.4g}" for a, v in by_arc.items())
        notes.append(f"by arc of contact, MPa: {by}")
    above = max((other - by_arc[pi] for other in by_arc.values()), default=0.0)
    below = max((by_arc[pi] - other for other in by_arc.values()), default=0.0)
    return Bars(bar, above, below, "; ".join(notes))


def mesh_bar(judged: Judged, levels: Sequence[Level]) -> float:
    """The part of the numerical bar that a finer mesh makes smaller, over the value."""
    values = [judged.value(level) for level in levels]
    finest, value = levels[-1], abs(values[-1])
    if not value:
        return 0.0
    left = discretisation_error(values, sizes_at_peak(judged, levels))
    notch = finest.notch_error(judged.point(finest)) * value
    return ErrorBar(left, judged.scatter(finest), 0.0, value, 0.0, notch).mesh / value


def sizes_at_peak(judged: Judged, levels: Sequence[Level]) -> list[float]:
    """Size of the elements of every mesh where the last one has its peak, mm."""
    finest = levels[-1]
    place = finest.history.points[judged.point(finest)]
    return [level.size_at(level.nearest(place)) for level in levels]


def arcs_of(part: Part, level: Level) -> list[float]:
    """Arcs of contact: the half circle of the unit loads, and down to the narrowest stated."""
    if not has_bearings(level.solutions):
        return []
    narrow = part.bearing_arc
    return [pi] if narrow >= pi else [pi, (pi + narrow) / 2, narrow]


def _direct(loads: PartLoads, level: Level, position: int, arc: float) -> FloatArray:
    wrenches = {name: wrench[position] for name, wrench in loads.wrenches.items()}
    return direct_stress(level.solutions, wrenches, level.coefficients[:, position], arc)


def _singular_edge(judged: Judged, levels: Sequence[Level]) -> tuple[float, float]:
    """Interior angle (rad) and exponent of a sharp re-entrant edge that spoils a peak, else 0, 0.

    An edge counts if it carries at least half the peak and its largest value moves with the mesh.
    A sharp edge of the body is sharp on every mesh; what only some show is a coarse fillet.
    """
    if not all(len(level.edges[0]) for level in levels):
        return 0.0, 0.0
    values, sizes, worst = [], [], 0
    for level in levels:
        on_edge = level.edges[0]
        found = judged.at(level, on_edge)
        worst = int(on_edge[found.argmax()])
        values.append(float(found.max()))
        sizes.append(level.size_at(worst))
    points, angles = levels[-1].edges
    angle = float(angles[points == worst][0])
    exponent = singular_exponent(angle)
    if values[-1] >= judged.value(levels[-1]) / 2 and moves_like_singular(values, sizes, exponent):
        return angle, exponent
    return 0.0, 0.0
