"""What lies between the positions of a cycle: the sampling's share of every check's error bar.

Loads are known at positions; a smooth peak between two of them is missed by a share of order h^2 of
the step h. Between two jumps loads follow a cubic spline through the positions, whose error is of
order h^4; where it meets a corner it rings, which widens the bar. Where a contact begins or ends
the loads jump somewhere in a step: both sides go on along their tangents over all of it. Each
check is made again under loads on a grid of an eighth of the step, and what it rises by, with a
margin, is added to its numerical bar. Rows of measured loads are taken as they are.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from ballesta.judged_fatigue import FatigueUse
from ballesta.part_loads import PartLoads
from ballesta.rungs.model import ElasticLoad, RungModel
from ballesta.stressed import Stressed
from fem.stress_history import StressHistory
from geometry.mesh import FloatArray, IntArray
from reports.verdict import Check

PIECES = 8  # of a step between two positions
MARGIN = 2.0  # times what was found: a Findley amplitude rose by 1.38 times it, at a corner
_NEAR = 0.9  # of the largest: positions and points that may have more between
_MOST_POINTS = 200
_ROUND_OFF = 1e-9  # of a value


@dataclass(frozen=True, eq=False)
class Finer:
    """The positions of a part's loads, and places between them.

    loads   at the positions (n,)
    before  (m,) position that a place belongs to
    share   (m,) of the step to the next one, up to 1, or back to the last one, down to -1; 0 at a
            position
    """

    loads: PartLoads
    before: IntArray
    share: FloatArray

    def of(self, values: FloatArray) -> FloatArray:
        """Values (m, ...) at the places, of those (n, ...) at the positions."""
        values = np.asarray(values, dtype=np.float64)
        found = values[self.before]
        path = self.loads.path
        assert path is not None
        between = np.flatnonzero(self.share)
        for first, last in _stretches(self.loads):
            own = between[(self.before[between] >= first) & (self.before[between] <= last)]
            if not len(own):
                continue
            known = path[first : last + 1]
            sign = 1.0 if known[-1] > known[0] else -1.0
            curve = CubicSpline(sign * known, values[first : last + 1])
            k, share = self.before[own], self.share[own]
            step = path[k + np.sign(share).astype(int)] - path[k]
            places = sign * (path[k] + np.abs(share) * step)
            ends = np.clip(places, sign * known[0], sign * known[-1])
            beyond = (places - ends).reshape(-1, *[1] * (values.ndim - 1))
            found[own] = curve(ends) + beyond * curve.derivative()(ends)
        return found

    @cached_property
    def between(self) -> PartLoads:
        """The loads at the places."""
        loads, runs = self.loads, self.loads.cycles
        assert loads.path is not None
        starts = {name: int(np.searchsorted(self.before, run.start)) for name, run in runs.items()}
        stops = {name: int(np.searchsorted(self.before, run.stop)) for name, run in runs.items()}
        return replace(
            loads,
            wrenches={name: self.of(wrench) for name, wrench in loads.wrenches.items()},
            accelerations=self.of(loads.accelerations),
            cycles={name: slice(starts[name], stops[name]) for name in runs},
            labels=tuple(loads.labels[k] for k in self.before),
            cycle_names=tuple(loads.cycle_names[k] for k in self.before),
            reaches={name: self.of(reach) for name, reach in loads.reaches.items()},
            stretch_of=None if loads.stretch_of is None else loads.stretch_of[self.before],
            path=None,
        )


def finer(loads: PartLoads, near: NDArray[np.bool_] | None = None) -> Finer | None:
    """Places between the positions; None where there are none.

    near  (n,) positions next to which there are some; None for all

    Where the loads may jump within a cycle, somewhere between two positions, those of either side
    go on along their tangent to the other position.
    """
    if loads.path is None:
        return None
    step = np.diff(loads.path)
    open_ = np.array(loads.cycle_names)
    asked = (open_[1:] == open_[:-1]) & np.isfinite(step) & (step != 0.0)
    if near is not None:
        asked &= near[:-1] | near[1:]
    if not asked.any():
        return None
    within = np.zeros(len(step), dtype=bool)
    for first, last in _stretches(loads):
        within[first:last] = True
    shares = np.arange(1, PIECES) / PIECES
    own = np.arange(len(loads.path))
    inner = np.flatnonzero(asked & within)
    jumps = np.flatnonzero(asked & ~within)
    pairs = [(own, np.zeros(1)), (inner, shares)]
    pairs += [(jumps, np.append(shares, 1.0)), (jumps + 1, -np.append(shares, 1.0))]
    before = np.concatenate([np.repeat(k, len(share)) for k, share in pairs])
    share = np.concatenate([np.tile(share, len(k)) for k, share in pairs])
    order = np.lexsort((share, before))
    return Finer(loads, before[order], share[order])


def _stretches(loads: PartLoads) -> list[tuple[int, int]]:
    """First and last positions of stretches along which the loads change without a jump."""
    assert loads.path is not None
    step = np.diff(loads.path)
    smooth = np.zeros(len(step), dtype=bool)
    smooth[loads.steps] = True
    smooth &= np.isfinite(step) & (step != 0.0)
    found: list[tuple[int, int]] = []
    for k in np.flatnonzero(smooth):
        if found and found[-1][1] == k and (step[k] > 0) == (step[k - 1] > 0):
            found[-1] = (found[-1][0], int(k) + 1)
        else:
            found.append((int(k), int(k) + 1))
    return found


def sampled(make: Callable[[PartLoads], Sequence[Check]], loads: PartLoads) -> list[Check]:
    """Make checks that are formulas of the loads, with what the positions miss of them in the bars.

    A check of the same kind and quantity under the loads between counts by its utilisation: which
    of several places it is about may change.
    """
    checks = list(make(loads))
    places = finer(loads)
    if places is None or not checks:
        return checks
    between = {(check.kind, check.quantity): check for check in make(places.between)}
    done = []
    for check in checks:
        other = between.get((check.kind, check.quantity))
        more = 0.0
        if other is not None and check.utilisation:
            more = check.value * (other.utilisation / check.utilisation - 1)
        done.append(with_sampling(check, more))
    return done


def with_sampling(check: Check, more: float) -> Check:
    """Return a check with what it rises by between the positions in its numerical bar."""
    missed = MARGIN * float(more)
    if not missed > _ROUND_OFF * check.value:
        return check
    return replace(check, numerical=check.numerical + missed, sampling=missed)


def buckling_rise(
    loads: PartLoads, load: ElasticLoad, again: Callable[[PartLoads], RungModel | None]
) -> float:
    """How far a rung's share of the elastic buckling load rises beside the worst position.

    again  builds the rung's model under other loads
    """
    places = beside(loads, load.position)
    if places is None:
        return 0.0
    model = again(places.between)
    if model is None or model.buckling is None:
        return 0.0
    return max(0.0, model.buckling.share - load.share)


def beside(loads: PartLoads, position: int) -> Finer | None:
    """The places of the steps to and from a position, without the positions; None without any."""
    near = np.zeros(len(loads.labels), dtype=bool)
    near[position] = True
    places = finer(loads, near)
    if places is None:
        return None
    own = places.share != 0.0
    return Finer(loads, places.before[own], places.share[own])


def static_rise(level: Stressed, loads: PartLoads) -> float:
    """How far the largest von Mises stress rises between the positions, MPa."""
    places = finer(loads, level.peaks_by_position >= _NEAR * level.peak.value)
    if places is None:
        return 0.0
    own = places.share != 0.0
    states = places.of(level.coefficients.T)[own].T
    history = level.history
    between = StressHistory(
        history.nodes, history.points, history.basis, np.ascontiguousarray(states)
    )
    return max(0.0, float(between.peaks_by_position()[0].max()) - level.peak.value)


def fatigue_rise(level: Stressed, loads: PartLoads, use: FatigueUse) -> float:
    """How far what is judged of fatigue rises between the positions, MPa.

    Asked are the points that come near the worst one.
    """
    places = finer(loads)
    if places is None or level.duty is None:
        return 0.0
    used = level.duty.bound
    points = np.flatnonzero(used >= _NEAR * float(level.duty.worst.utilisation.max()))
    if len(points) > _MOST_POINTS:
        nearest = np.argsort(-level.duty.utilisation_at(points), kind="stable")
        points = points[nearest[:_MOST_POINTS]]
    points = np.union1d(points, [use.point(level)])
    between = places.between
    states = np.ascontiguousarray(places.of(level.coefficients.T).T)
    found = use.over(level, points, states, between.cycles)
    return max(0.0, found - use.value(level)) if isfinite(found) else 0.0
