"""Fatigue assessment of a part: Goodman and Findley, a finite life, or the FKM guideline."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import repeat
from math import isfinite
from weakref import WeakKeyDictionary

import numpy as np

import fatigue
from checks.design.strength import FkmStrength
from checks.part.loaded_part import Loose
from checks.part.part_loads import PartLoads
from checks.strength.finite_life import (
    DutyLife,
    LifeTask,
    largest_endured,
    lives_of,
    most_used,
    shorter_life,
    shortest_life,
)
from checks.strength.fkm_strength import (
    FkmJudgement,
    SlopesAt,
    fkm_judgement,
    fkm_points,
    slopes_of,
)
from checks.stress.duty_verdict import WHOLE_DUTY, DutyVerdict, FatiguePeak, duty_runs, duty_verdict
from checks.stress.judged import Judged, RaisedInBores, Under, direct_under
from checks.stress.solid_mesh_level import Level
from checks.stress.stress_result import Stressed
from fem.recovery import von_mises
from geometry.mesh import FloatArray, IntArray

_ROUND_OFF = 1e-6  # of a bound: how well stresses are known


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

    def worst(self, level: Stressed) -> FatiguePeak:
        """The point and the pair of positions."""
        assert level.fatigue is not None
        return level.fatigue

    def value(self, level: Stressed) -> float:
        """The quantity on one mesh, MPa."""
        return self.worst(level).value

    def point(self, level: Stressed) -> int:
        """Index of the surface point that carries it."""
        return self.worst(level).point

    def at(self, level: Stressed, points: IntArray) -> FloatArray:
        """Equivalent amplitude at some surface points (n,) on the path that decides, MPa."""
        return level.judged_duty.utilisation_at(points) * self.limit

    def bound(self, level: Stressed, points: IntArray) -> FloatArray:
        """Not less than the quantity (n,) at some surface points on any path, MPa."""
        return level.judged_duty.bound[points] * self.limit

    def deciding(self, level: Stressed) -> list[int]:
        """The pair of positions."""
        return list(self.worst(level).pair)

    def deciding_at(self, level: Stressed, points: IntArray) -> list[int]:
        """The pair of positions between which Goodman or Findley uses some points most."""
        duty, history = level.judged_duty, level.history.at_points(points)
        found = duty_verdict(
            history.basis, history.coefficients, duty.limits[points], duty.limit, duty.ultimate,
            duty.runs,
        )  # fmt: skip
        assert found is not None
        return list(found.peak.pair)

    def states(self, level: Stressed) -> list[FloatArray]:
        """Half the swing, and the middle, of the pair of positions."""
        first, second = (level.coefficients[:, k] for k in self.worst(level).pair)
        return [(first - second) / 2, (first + second) / 2]

    def scatter(self, level: Level, *, of_edges: bool = True) -> float:
        """Scatter of amplitude and mean, as they enter the quantity, MPa."""
        point = self.point(level)
        states = self.states(level)
        swing, middle = (level.scatter(state, point, of_edges=of_edges) for state in states)
        factor = self.limit / float(level.limits[point])
        return self._over_pair(level) * (factor * swing + middle * self.limit / self.ultimate)

    def direct(
        self,
        level: Level,
        numbers: Sequence[float],
        under: Under | None = None,
        positions: Sequence[int] = (),
    ) -> list[float]:
        """The quantity between the same two positions under other pressures."""
        under = under or direct_under
        some = under.points(level) if isinstance(under, RaisedInBores) else slice(None)
        limits = level.limits[some]
        pair = [under(self.loads, level, k, numbers) for k in positions or self.deciding(level)]
        stress = np.stack(pair, axis=2)
        return self.of_states(level, np.moveaxis(stress, -1, 0), repeat(limits))

    def of_pressure(self, level: Stressed, points: IntArray, more: Loose) -> float:
        """Half of how it swings, its amplitude, where the least of the points endures it."""
        return more.swing / 2 * self.limit / float(self.endured(level, points).min())

    def of_states(
        self, level: Stressed, stress: Iterable[FloatArray], limits: Iterable[FloatArray]
    ) -> list[float]:
        """The quantity between two states, each stress (n, 6, 2) of the same two positions, MPa.

        0 where there are no points.
        """
        over = self._over_pair(level)
        pairs = zip(stress, limits, strict=False)
        return [over * self._of_pair(*pair) if len(pair[0]) else 0.0 for pair in pairs]

    def band(self, level: Stressed) -> tuple[float, str]:
        """How far another criterion of the same strength lies above, MPa, and what is said of it.

        Nothing where both criteria have been asked.
        """
        return 0.0, ""

    def anew(
        self,
        level: Stressed,
        points: IntArray,
        basis: FloatArray,
        coefficients: FloatArray,
        cycles: Mapping[str, slice] | None = None,
        states: FloatArray | None = None,
        reached: float = 0.0,
    ) -> float:
        """The quantity at some surface points (n,) with another history, MPa.

        reached  MPa; where no point has more, the answer is any value that is not above it
        """
        cycles, duty = self.loads.cycles if cycles is None else cycles, level.judged_duty
        runs = duty_runs(cycles, [name for name in duty.runs if name in cycles])
        limits = duty.limits[points]
        floor = self._floor(reached)
        found = duty_verdict(basis, coefficients, limits, duty.limit, duty.ultimate, runs, floor)
        assert found is not None

        @cache
        def of_solid() -> SlopesAt:
            return slopes_of(_solid(level).solutions)

        def slopes(some: IntArray) -> FloatArray:
            own = of_solid()(points[some])
            if states is not None:
                own = own @ states
            return np.pad(own, ((0, 0), (0, 0), (0, basis.shape[2] - own.shape[2])))

        return self._of_duty(found, slopes, reached)

    def _floor(self, reached: float) -> float:
        """The utilisation up to which points need not be judged where a value is reached, MPa."""
        return reached / self.limit

    def _of_duty(self, duty: DutyVerdict, slopes: SlopesAt, reached: float) -> float:
        """The quantity over a duty, and the slopes of its basis into the part, MPa."""
        return duty.peak.value

    def safety_missed(self, level: Stressed) -> float:
        """How far from 1 the safety is that all loads times the safety leave."""
        return level.judged_duty.safety_missed()

    def _of_pair(self, stress: FloatArray, limits: FloatArray) -> float:
        """Goodman's amplitude of equal safety of two states, stress (n, 6, 2), at the worst point.

        The largest principal stress of the middle is between its hydrostatic stress and that and
        2/3 of its von Mises stress: points whose upper bound is below another's lower one are left
        out.
        """
        demand = von_mises(stress[..., 0] - stress[..., 1]) / 2 / limits
        middle = stress.mean(axis=2)
        hydrostatic = middle[:, :3].mean(axis=1)
        least = demand + np.maximum(hydrostatic, 0.0) / self.ultimate
        highest = hydrostatic + 2 / 3 * von_mises(middle)
        most = demand + np.maximum(highest, 0.0) / self.ultimate
        may = most * (1 + _ROUND_OFF) >= least.max()
        mean = np.maximum(fatigue.principal_stresses(middle[may])[:, 2], 0.0)
        return float((demand[may] + mean / self.ultimate).max()) * self.limit

    def _over_pair(self, level: Stressed) -> float:
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
    _lives: WeakKeyDictionary[Stressed, DutyLife] = field(default_factory=WeakKeyDictionary)
    _bounds: WeakKeyDictionary[Stressed, FloatArray] = field(default_factory=WeakKeyDictionary)

    def life(self, level: Stressed) -> DutyLife:
        """Life of the worst point of a level, sought once."""
        if level not in self._lives:
            self._lives[level] = shortest_life(level.judged_duty, self.task)
        return self._lives[level]

    def worst(self, level: Stressed) -> FatiguePeak:
        """The point that lasts the shortest, and the ends of the longest chord of its path."""
        life = self.life(level)
        value = self.limit / life.safety
        return FatiguePeak(value, life.point, WHOLE_DUTY, life.pair, "Miner")

    def at(self, level: Stressed, points: IntArray) -> FloatArray:
        """The endurance limit over the safety of some surface points (n,), MPa."""
        lives = lives_of(level.judged_duty, self.task, points) if len(points) else []
        return self.limit / np.array([life.safety for life in lives])

    def bound(self, level: Stressed, points: IntArray) -> FloatArray:
        """Not less than the quantity (n,) at some surface points, MPa."""
        if level not in self._bounds:
            self._bounds[level] = most_used(level.judged_duty, self.task)
        return self._bounds[level][points] * self.limit

    def endured(self, level: Stressed, points: IntArray) -> FloatArray:
        """Amplitude (n,) that some surface points endure as often as their paths have it, MPa."""
        return largest_endured(level.judged_duty, self.task)[1][points]

    def _floor(self, reached: float) -> float:
        return 0.0  # Miner's sum may use a point more than the two criteria do

    def _of_duty(self, duty: DutyVerdict, slopes: SlopesAt, reached: float) -> float:
        than = self.limit / reached if reached else None
        life = shorter_life(duty, self.task, than)
        return self.limit / life.safety if life else reached

    def safety_missed(self, level: Stressed) -> float:
        """How far from 1 the safety is that all loads times the safety leave, counted again."""
        life = self.life(level)
        if not isfinite(life.safety):
            return 0.0
        (again,) = lives_of(level.judged_duty, self.task, np.array([life.point]), life.safety)
        return abs(again.safety - 1.0)


@dataclass(frozen=True, eq=False)
class FkmUse(FatigueUse):
    """The largest utilisation by the FKM guideline's chain, times its reference strength.

    strength  of the part; `limit` is its reference
    """

    strength: FkmStrength
    _judged: WeakKeyDictionary[Stressed, FkmJudgement] = field(default_factory=WeakKeyDictionary)

    def judgement(self, level: Stressed, factor: float = 1.0) -> FkmJudgement:
        """The worst point of a level, all loads multiplied by a factor."""
        duty = level.judged_duty
        slopes = slopes_of(_solid(level).solutions)
        return fkm_judgement(
            self.strength, duty.basis, factor * duty.coefficients, duty.runs, slopes
        )

    def found(self, level: Stressed) -> FkmJudgement:
        """The worst point of a level, sought once."""
        if level not in self._judged:
            self._judged[level] = self.judgement(level)
        return self._judged[level]

    def worst(self, level: Stressed) -> FatiguePeak:
        """The point and the pair of positions."""
        found = self.found(level)
        return FatiguePeak(found.demand, found.point, found.run, found.pair, "FKM")

    def at(self, level: Stressed, points: IntArray) -> FloatArray:
        """Equivalent amplitude at some surface points (n,) on the path that decides, MPa."""
        return self._on(level, points, self.found(level).run)

    def bound(self, level: Stressed, points: IntArray) -> FloatArray:
        """The quantity (n,) at some surface points on the path that uses each most, MPa."""
        every = [self._on(level, points, run) for run in level.judged_duty.runs]
        return np.asarray(np.max(every, axis=0))

    def _on(self, level: Stressed, points: IntArray, run: str) -> FloatArray:
        if not len(points):
            return np.zeros(0)
        duty = level.judged_duty
        path = np.ascontiguousarray(duty.coefficients[:, duty.runs[run]])
        slopes = slopes_of(_solid(level).solutions)
        used = fkm_points(self.strength, duty.basis, path, points, slopes).utilisation
        return np.asarray(used * self.strength.reference)

    def band(self, level: Stressed) -> tuple[float, str]:
        """How far Findley's criterion with the same component strength lies above, MPa.

        The guideline's chain judges the longest chord of a path only. Of all points on all paths:
        the worst by planes need not be the worst by chords.
        """
        duty, criterion, own = level.judged_duty, fatigue.findley_criterion(), self.strength
        slopes = slopes_of(_solid(level).solutions)
        demand = most = self.found(level).demand
        for name, run in duty.runs.items():
            single, path = duty.verdicts[name], np.ascontiguousarray(duty.coefficients[:, run])
            known = np.isfinite(single.plane_utilisation)
            bound = np.where(known, single.plane_utilisation, single.plane_bound) * own.reference
            points = np.flatnonzero(bound * (1.0 + _ROUND_OFF) > most)
            if not len(points):
                continue
            judged = fkm_points(own, duty.basis, path, points, slopes)
            # over the reference, which has no support
            stronger = own.limit(judged.gradient).limit * own.endurance_share / own.reference
            bound = bound[points] * (1.0 + _ROUND_OFF) / stronger
            for row in np.argsort(-bound, kind="stable"):
                if bound[row] <= most:
                    break
                limit = criterion.limit_ratio * float(stronger[row])
                stress = duty.basis[points[row]] @ path
                plane = fatigue.critical_plane(stress, criterion.k, floor=most * limit)
                most = max(most, plane.value / limit)
        if most <= demand:
            return 0.0, ""
        said = "paths are not proportional, FKM judges longest chords only: by Findley's planes"
        return most - demand, f"{said} {most:.4g} MPa"

    def scatter(self, level: Level, *, of_edges: bool = True) -> float:
        """Scatter of amplitude and mean, as they enter the quantity, MPa."""
        found = self.found(level)
        states = self.states(level)
        swing, middle = (level.scatter(state, found.point, of_edges=of_edges) for state in states)
        more = found.utilisation_with(found.amplitude + swing, found.mean + middle)
        return (more - found.utilisation) * self.strength.reference

    def direct(
        self,
        level: Level,
        numbers: Sequence[float],
        under: Under | None = None,
        positions: Sequence[int] = (),
    ) -> list[float]:
        """The quantity between the same two positions under other pressures."""
        found = self.found(level)
        under = under or direct_under
        pair = positions or found.pair
        stress = np.stack([under(self.loads, level, k, numbers) for k in pair], axis=2)
        used = [found.utilisation_between(stress[..., k]) for k in range(len(numbers))]
        return [float(one.max()) * self.strength.reference for one in used]

    def _of_duty(self, duty: DutyVerdict, slopes: SlopesAt, reached: float) -> float:
        worst = fkm_judgement(self.strength, duty.basis, duty.coefficients, duty.runs, slopes)
        return worst.demand

    def safety_missed(self, level: Stressed) -> float:
        """How far from 1 the safety is that all loads times the safety leave."""
        safety = self.found(level).safety
        return abs(self.judgement(level, safety).safety - 1.0) if isfinite(safety) else 0.0


def _solid(level: Stressed) -> Level:
    """A level that is a solid: FKM's support needs the stress below the surface."""
    if not isinstance(level, Level):
        raise TypeError("the FKM guideline's notch support needs a solid's stress gradient")
    return level
