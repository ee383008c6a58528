"""Peaks between the positions of a cycle: the sampling's share of every check's error bar.

Loads are known at positions; a smooth peak between two of them is missed by a share of order h^2 of
the step h. Between two jumps loads follow a cubic spline through the positions, whose error is of
order h^4; where it meets a corner it rings, which widens the bar. Where a contact begins or ends,
or friction of a joint reverses, the loads jump somewhere in a step: both sides go on along their
tangents over all of it. Each check is made again under loads on a grid of an eighth of the step,
where it may have more, and what it rises by, with a margin, is added to its numerical bar. Rows of
measured loads are taken as they are.

Cubic splines through values at rising places, for less time than SciPy takes to load its own.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import isfinite
from typing import Self
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from checks.part.part_loads import PartLoads
from checks.result.verdict import Check
from checks.strength.fatigue_assessment import FatigueUse, LifeUse
from checks.strength.load_doubts import doubted
from checks.stress.stress_result import ElasticLoad, RungModel, Stressed
from fatigue.stress_path import deviatoric_basis
from fem.stress_history import StressHistory
from geometry.mesh import FloatArray, IntArray

PIECES = 8  # of a step between two positions
MARGIN = 2.0  # times what was found: a Findley amplitude rose by 1.38 times it, at a corner
NEAR = 0.9  # of the largest: positions and points that may have more between
_MOST_POINTS = 200
_ROUND_OFF = 1e-9  # of a value
_STRAIGHT = 1e-6  # of the largest: what leaves the chord by less changes nothing that is told
_FORMS = 0.7  # of the largest use: positions that may form what decides
_UNEVEN = 20.0  # times the step before: between the two a spline does not go on
_OF_ITS_OWN = 3  # steps of a spline beside such a place: a cubic
_FEW = 256  # positions: what lies beside these is asked at once
_stretches_of: WeakKeyDictionary[PartLoads, list[tuple[int, int]]] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class Spline:
    """A curve with continuous first and second derivatives, a cubic polynomial in every step.

    The first two steps share theirs, and so do the last two ("not a knot", as of
    `scipy.interpolate.CubicSpline`); through three values goes a parabola, through two a line.

    places  (n,) rising
    values  (n, ...)
    slopes  (n, ...)
    """

    places: FloatArray
    values: FloatArray
    slopes: FloatArray

    @classmethod
    def through(cls, places: FloatArray, values: FloatArray) -> Self:
        """The spline through values (n, ...) at places (n,), two at least."""
        step = np.diff(places)
        h = step.reshape(-1, *[1] * (values.ndim - 1))
        rise = np.diff(values, axis=0) / h
        if len(step) < 3:
            bend = (rise[-1] - rise[0]) / (places[-1] - places[0])  # half the second derivative
            first = rise[0] - bend * step[0]
            return cls(places, values, first + 2 * bend * np.concatenate([0 * h[:1], h]).cumsum(0))
        slopes = np.empty(values.shape)
        slopes[1:-1] = 3 * (h[1:] * rise[:-1] + h[:-1] * rise[1:])
        for end, next_one in ((0, 1), (-1, -2)):
            both = h[end] + h[next_one]
            weight = h[next_one] * (h[end] + 2 * both)
            slopes[end] = (weight * rise[end] + h[end] ** 2 * rise[next_one]) / both
        below = [*step[1:].tolist(), float(step[-2] + step[-1])]
        main = [step[1], *(2 * (step[1:] + step[:-1])).tolist(), step[-2]]
        above = [float(step[0] + step[1]), *step[:-1].tolist()]
        for k, low in enumerate(below):  # elimination of a matrix of three diagonals
            share = low / main[k]
            main[k + 1] -= share * above[k]
            slopes[k + 1] -= share * slopes[k]
        slopes[-1] /= main[-1]
        for k in reversed(range(len(step))):
            slopes[k] = (slopes[k] - above[k] * slopes[k + 1]) / main[k]
        return cls(places, values, slopes)

    def at(self, x: FloatArray, derivative: int = 0) -> FloatArray:
        """The value (m, ...) at places x (m,) within the spline, or its first or second derivative.

        Where two steps meet, of the later one.
        """
        k = np.clip(np.searchsorted(self.places, x, side="right") - 1, 0, len(self.places) - 2)
        shape = (-1, *[1] * (self.values.ndim - 1))
        h = (self.places[k + 1] - self.places[k]).reshape(shape)
        t = (x - self.places[k]).reshape(shape)
        rise = (self.values[k + 1] - self.values[k]) / h
        start, end = self.slopes[k], self.slopes[k + 1]
        cubic = (start + end - 2 * rise) / h**2
        square = (rise - start) / h - cubic * h
        if derivative == 0:
            return np.asarray(self.values[k] + t * (start + t * (square + t * cubic)))
        if derivative == 1:
            return np.asarray(start + t * (2 * square + 3 * t * cubic))
        return np.asarray(2 * square + 6 * t * cubic)


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
        return self.on(Curves.of(self.loads, values))

    def on(self, curves: "Curves") -> FloatArray:
        """Values (m, ...) at the places, of curves of the same loads."""
        found = curves.values[self.before]
        path = self.loads.path
        assert path is not None
        between = np.flatnonzero(self.share)
        stretches = _stretches(self.loads)
        for (first, last), curve in zip(stretches, curves.splines, strict=True):
            own = between[(self.before[between] >= first) & (self.before[between] <= last)]
            if not len(own):
                continue
            sign = 1.0 if path[last] > path[first] else -1.0
            k, share = self.before[own], self.share[own]
            step = path[k + np.sign(share).astype(int)] - path[k]
            places = sign * (path[k] + np.abs(share) * step)
            ends = np.clip(places, sign * path[first], sign * path[last])
            found[own] = curve.at(ends)
            out = np.flatnonzero(places != ends)
            if len(out):
                beyond = (places - ends)[out].reshape(-1, *[1] * (found.ndim - 1))
                found[own[out]] += beyond * curve.at(ends[out], 1)
        return found

    def only(self, kept: NDArray[np.bool_]) -> "Finer":
        """Some of the places."""
        return Finer(self.loads, self.before[kept], self.share[kept])

    @cached_property
    def between(self) -> PartLoads:
        """The loads at the places."""
        loads, runs = self.loads, self.loads.cycles
        assert loads.path is not None
        starts = {name: int(np.searchsorted(self.before, run.start)) for name, run in runs.items()}
        stops = {name: int(np.searchsorted(self.before, run.stop)) for name, run in runs.items()}
        found = self.on(_load_curves(loads))
        names, ends = [*loads.wrenches], 6 * np.arange(1 + len(loads.wrenches))
        forces = zip(names, ends[:-1], ends[1:], strict=True)
        rest = ends[-1] + loads.accelerations.shape[1]
        turn = rest + len(loads.reaches)
        bent = turn + len(loads.spins)
        return replace(
            loads,
            wrenches={name: np.ascontiguousarray(found[:, a:b]) for name, a, b in forces},
            accelerations=np.ascontiguousarray(found[:, ends[-1] : rest]),
            cycles={name: slice(starts[name], stops[name]) for name in runs},
            labels=tuple(loads.labels[k] for k in self.before),
            cycle_names=tuple(loads.cycle_names[k] for k in self.before),
            reaches={name: found[:, rest + k].copy() for k, name in enumerate(loads.reaches)},
            stretch_of=None if loads.stretch_of is None else loads.stretch_of[self.before],
            path=None,
            doubts=(),
            spins={name: found[:, turn + k].copy() for k, name in enumerate(loads.spins)},
            own_swing={x: found[:, bent + k].copy() for k, x in enumerate(loads.own_swing)},
        )


@dataclass(frozen=True, eq=False)
class Curves:
    """Values (n, ...) at the positions of a part's loads, and a cubic spline through each stretch.

    bend  (n, ...) by how much the splines may leave their chords beside a position: an eighth of
          the step squared times the second derivative, which is largest at an end of the step;
          infinite beside a jump
    """

    values: FloatArray
    splines: Sequence[Spline]
    bend: FloatArray

    @staticmethod
    def of(loads: PartLoads, values: FloatArray) -> "Curves":
        """The curves of any values that the positions have."""
        values = np.asarray(values, dtype=np.float64)
        path = loads.path
        assert path is not None
        splines, bend = [], np.full(values.shape, np.inf)
        for first, last in _stretches(loads):
            known = path[first : last + 1]
            sign = 1.0 if known[-1] > known[0] else -1.0
            curve = Spline.through(sign * known, values[first : last + 1])
            splines.append(curve)
            second = np.abs(curve.at(sign * known, 2))
            square = (np.diff(known) ** 2 / 8).reshape(-1, *[1] * (values.ndim - 1))
            off = square * np.maximum(second[1:], second[:-1])
            shared = np.isfinite(bend[first])  # with the stretch before
            bend[first] = np.where(shared, np.maximum(bend[first], off[0]), off[0])
            bend[last] = off[-1]
            bend[first + 1 : last] = np.maximum(off[1:], off[:-1])
        for k in _jumps(loads):
            bend[k : k + 2] = np.inf
        return Curves(values, splines, bend)


_curves_of_loads: WeakKeyDictionary[PartLoads, Curves] = WeakKeyDictionary()
_curves_of_level: WeakKeyDictionary[Stressed, Curves] = WeakKeyDictionary()


def _load_curves(loads: PartLoads) -> Curves:
    """The curves of all columns of a part's loads, made once."""
    if loads not in _curves_of_loads:
        others = loads.reaches, loads.spins, loads.own_swing
        more = [own[:, None] for some in others for own in some.values()]
        columns = np.hstack([*loads.wrenches.values(), loads.accelerations, *more])
        _curves_of_loads[loads] = Curves.of(loads, columns)
    return _curves_of_loads[loads]


def _level_curves(level: Stressed, loads: PartLoads) -> Curves:
    """The curves of a level's coefficients, made once."""
    if level not in _curves_of_level:
        _curves_of_level[level] = Curves.of(loads, level.coefficients.T)
    return _curves_of_level[level]


def finer(loads: PartLoads, near: NDArray[np.bool_] | None = None) -> Finer | None:
    """Places between the positions; None where there are none.

    near  (n,) positions next to which there are some; None for all

    Where the loads may jump within a cycle, somewhere between two positions, those of either side
    go on along their tangent to the other position.
    """
    if loads.path is None:
        return None
    asked = _steps(loads)
    if near is not None:
        asked &= near[:-1] | near[1:]
    if not asked.any():
        return None
    within = _within(loads)
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


def _steps(loads: PartLoads) -> NDArray[np.bool_]:
    """True (n - 1,) for steps from a position to another one of the same cycle."""
    assert loads.path is not None
    step = np.diff(loads.path)
    asked = np.zeros(len(step), dtype=bool)
    for run in loads.cycles.values():
        asked[run.start : run.stop - 1] = True
    return np.asarray(asked & np.isfinite(step) & (step != 0.0))


def _within(loads: PartLoads) -> NDArray[np.bool_]:
    """True (n - 1,) for steps within a stretch without a jump."""
    within = np.zeros(len(loads.labels) - 1, dtype=bool)
    for first, last in _stretches(loads):
        within[first:last] = True
    return within


def _jumps(loads: PartLoads) -> IntArray:
    """Positions after which the loads may jump before the next one of the same cycle."""
    return np.flatnonzero(_steps(loads) & ~_within(loads))


def _stretches(loads: PartLoads) -> list[tuple[int, int]]:
    """First and last positions of stretches along which the loads change without a jump."""
    if loads in _stretches_of:
        return _stretches_of[loads]
    assert loads.path is not None
    step = np.diff(loads.path)
    smooth = np.zeros(len(step), dtype=bool)
    smooth[loads.steps] = True
    smooth &= np.isfinite(step) & (step != 0.0)
    found: list[tuple[int, int]] = []
    for k in np.flatnonzero(smooth).tolist():
        if found and found[-1][1] == k and (step[k] > 0) == (step[k - 1] > 0):
            found[-1] = (found[-1][0], k + 1)
        else:
            found.append((k, k + 1))
    found = [part for stretch in found for part in _even(np.abs(step), *stretch)]
    _stretches_of[loads] = found
    return found


def _even(step: FloatArray, first: int, last: int) -> list[tuple[int, int]]:
    """A stretch in parts that share a position, where its steps become far longer or shorter.

    A blow has its moments close together; there a spline of short steps rings in the long ones.
    """
    at = np.arange(first + _OF_ITS_OWN, last - _OF_ITS_OWN + 1)
    before = np.maximum(step[at - 1], step[at - 2])  # one short step alone rings nowhere
    after = np.maximum(step[at], step[at + 1])
    ends = [first]
    for k in at[(step[at - 1] > _UNEVEN * after) | (step[at] > _UNEVEN * before)].tolist():
        if k - ends[-1] >= _OF_ITS_OWN:
            ends.append(k)
    return [*pairwise([*ends, last])]


def sampled(
    make: Callable[[PartLoads], Sequence[Check]], loads: PartLoads, *, whole: bool = False
) -> list[Check]:
    """Make checks that are formulas of the loads, with what the positions miss of them in the bars.

    whole  whether a check is of ranges over the cycles, which no position shows by itself: then all
           places between positions are asked, and all at once

    A check of the same kind and quantity under the loads between counts by its utilisation: which
    of several places it is about may change.
    """
    checks = list(make(loads))
    places = (finer(loads) if whole else _that_matter(make, loads, checks)) if checks else None
    if places is None:
        return doubted(make, loads, checks)
    between = _used(make(places.between))
    done = []
    for check in checks:
        other = between.get((check.kind, check.quantity))
        more = 0.0
        if other is not None and check.utilisation:
            more = check.value * (other / check.utilisation - 1)
        done.append(with_sampling(check, more))
    return doubted(make, loads, done)


def _used(checks: Sequence[Check]) -> dict[tuple[str, str], float]:
    return {(check.kind, check.quantity): check.utilisation for check in checks}


def _that_matter(
    make: Callable[[PartLoads], Sequence[Check]], loads: PartLoads, checks: Sequence[Check]
) -> Finer | None:
    """The places that may have more of a check; None without any.

    Left out are steps along which every load goes straight, and of many positions those rows in
    which no check comes near its largest.
    """
    if loads.path is None or not _steps(loads).any():
        return None
    curves = _load_curves(loads)
    largest_of_loads = np.abs(np.nan_to_num(curves.values)).max(axis=0)
    near = (curves.bend > _STRAIGHT * largest_of_loads).any(axis=1)
    # a force times where it acts, or times a speed, bends where neither does
    near |= bool(loads.reaches) or bool(loads.spins)
    largest = _used(checks)
    at = np.flatnonzero(near)
    if len(at) > _FEW:
        length = int(np.sqrt(PIECES * len(at)))
        for row in np.split(at, range(length, len(at), length)):
            used = _used(make(Finer(loads, row, np.zeros(len(row))).between))
            near[row] = any(used.get(name, 0.0) >= NEAR * most for name, most in largest.items())
    places = finer(loads, near)
    if places is None:
        return None
    return places.only((places.share != 0.0) | near[places.before])


def with_sampling(check: Check, more: float) -> Check:
    """Return a check with what it rises by between the positions in its numerical bar."""
    missed = MARGIN * float(more)
    if not missed > _ROUND_OFF * check.value:
        return check
    found = replace(check, numerical=check.numerical + missed, sampling=missed)
    return found.explained_by(check.derivation)


def buckling_rise(
    loads: PartLoads, load: ElasticLoad, again: Callable[[PartLoads], RungModel | None]
) -> float:
    """How far a rung's share of the elastic buckling load rises beside the worst position.

    The positions are among the loads, too: whether a part counts as pulled, so that its pull
    stiffens nothing, hangs on all of them.

    again  builds the rung's model under other loads
    """
    places = finer(loads, np.arange(len(loads.labels)) == load.position)
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
    return None if places is None else places.only(places.share != 0.0)


def static_rise(level: Stressed, loads: PartLoads) -> float:
    """How far the largest von Mises stress rises between the positions, MPa."""
    places = finer(loads, level.peaks_by_position >= NEAR * level.peak.value)
    if places is None:
        return 0.0
    states = places.only(places.share != 0.0).on(_level_curves(level, loads)).T
    history = level.history
    between = StressHistory(
        history.nodes, history.points, history.basis, np.ascontiguousarray(states)
    )
    return max(0.0, float(between.peaks_by_position()[0].max()) - level.peak.value)


def fatigue_rise(level: Stressed, loads: PartLoads, use: FatigueUse) -> float:
    """How far what is judged of fatigue rises between the positions, MPa.

    Asked are the points that come near the worst one, and the steps that may change them.
    """
    if loads.path is None or level.duty is None or not _steps(loads).any():
        return 0.0
    used = level.duty.bound
    points = np.flatnonzero(used >= NEAR * float(level.duty.worst.utilisation.max()))
    if len(points) > _MOST_POINTS:
        nearest = np.argsort(-level.duty.utilisation_at(points), kind="stable")
        points = points[nearest[:_MOST_POINTS]]
    points = np.union1d(points, [use.point(level)])
    places = finer(loads, _that_tire(level, loads, use, points))
    if places is None:
        return 0.0
    starts = {
        name: int(np.searchsorted(places.before, run.start)) for name, run in loads.cycles.items()
    }
    stops = {
        name: int(np.searchsorted(places.before, run.stop)) for name, run in loads.cycles.items()
    }
    runs = {name: slice(starts[name], stops[name]) for name in loads.cycles}
    states = np.ascontiguousarray(places.on(_level_curves(level, loads)).T)
    basis = level.judged_duty.basis[points]
    found = use.anew(level, points, basis, states, runs)
    return max(0.0, found - use.value(level)) if isfinite(found) else 0.0


def _that_tire(
    level: Stressed, loads: PartLoads, use: FatigueUse, points: IntArray
) -> NDArray[np.bool_]:
    """Positions (n,) beside which some points may be used more.

    Left out are steps along which the stress goes straight: every criterion is convex in each
    state, so that what lies on the chord of two adds nothing. Of what is judged by its largest
    swing, also positions k far from any that forms it: with c the middle of the governing pair and
    R the largest distance from it, in von Mises stress, no swing of k exceeds |k - c| + R. Of three
    positions that hold a circle of radius r each is sqrt 2 r or more from another. The largest
    tension counts by itself; p + 2/3 of the von Mises stress is not less.
    """
    duty = level.judged_duty
    curves = _level_curves(level, loads)
    basis = duty.basis[points]
    vectors = deviatoric_basis(basis)
    sizes = np.linalg.norm(vectors, axis=1) + np.abs(basis[:, :3].sum(axis=1))
    jumps = np.asarray(np.isinf(curves.bend).any(axis=1))
    off = np.where(jumps[:, None], 0.0, curves.bend) @ sizes.max(axis=0)
    bends = np.asarray(jumps | (off > _STRAIGHT * use.value(level)))
    inside = np.zeros(len(bends), dtype=bool)
    for run in duty.runs.values():
        inside[run] = True
    bends &= inside
    if isinstance(use, LifeUse):
        return np.asarray(bends)
    run, near = np.flatnonzero(inside), np.zeros(len(bends), dtype=bool)
    states = level.coefficients[:, run]
    middle = level.coefficients[:, list(use.worst(level).pair)].mean(axis=1)
    for point in range(len(points)):
        apart = np.linalg.norm(vectors[point] @ (states - middle[:, None]), axis=0)
        tension = basis[point, :3].sum(axis=0) / 3 @ states
        tension += 2 / 3 * (apart + np.linalg.norm(vectors[point] @ middle))
        most = np.maximum(tension, 0.0)
        swing = (apart + apart.max()) / 2 / duty.limits[points[point]]
        demand = swing + (most + most.max()) / 2 / duty.ultimate
        near[run] |= demand >= _FORMS * demand.max()
        near[run] |= (most >= NEAR * most.max()) & (most > 0.0)
    return np.asarray(near & bends)
