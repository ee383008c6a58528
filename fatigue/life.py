"""Damage, life and safety of a duty by the Palmgren-Miner rule.

Damage of a duty is the sum of n/N over its cycles, N from an S-N curve at the equivalent fully
reversed amplitude; the part fails when it reaches an allowed sum, 1 by Miner. Tests under variable
amplitudes give less: FKM takes 0.3 to 1. Miner's rule knows no order of loads.

A duty is several blocks (start, idle, stroke, overload), each run a number of times.

Between two blocks the stress goes from the extremes of one to those of the other, and that cycle
(ground-air-ground, for an aircraft) may be larger than any within a block. How often it happens
depends on the order in which the blocks run, which is not known: the highest peaks meet the lowest
valleys, as often as the counts allow. The largest cycle of each block is taken apart into its peak
and its valley, then the highest peak left is paired with the lowest valley left, min(count, count)
times, until none is left (ASME Boiler and Pressure Vessel Code, III, NB-3222.4(e)(5)). No order in
which each peak and valley happens once gives more cycles that reach above v and below u, for any
u < v. The smaller cycles of a block stay as counted within it.

Cycles are counted out of stress histories by the rainflow method.
A machine repeats its cycle: `count_closed_cycles` begins and ends at the highest peak, ASTM
E1049-85, 5.4.5, so every cycle closes. That is the count of the four-point rule with the residue
repeated, and does not depend on where the history is cut open.

The counter is the package `rainflow` (MIT, one file of Python without dependencies, exact on the
standard's example). Of the others that are kept, fatpack knows no half cycles and pyLife brings
pandas and HDF5; they are compiled, but turning points are found here in numpy, and few are left
to count.

Welds are judged by ranges of nominal stress, with the curves of EN 1993-1-9:2005.

A category is the range that 2e6 cycles endure. Normal stress (7.1(2) and (3), figure 7.1):

    N = 2e6 (S_C/S)^3         down to the range S_D = (2/5)^(1/3) S_C of 5e6 cycles,
    N = 5e6 (S_D/S)^5         down to the cut-off S_L = (5/100)^(1/5) S_D of 1e8, without end below

Shear (7.1(2), figure 7.2): N = 2e6 (T_C/T)^5 down to T_L = (2/100)^(1/5) T_C of 1e8 cycles.

Where no range of a history exceeds S_D, its life has no end: the branch below S_D holds where
larger ranges have begun the damage. Mean stress, strength, surface and compression have no part in
it: a weld as it was welded is under residual stress (7.2.1 counts compression less only where that
was relieved).

Normal and shear stress together: with equation (A.3) each ratio of (8.3) to its power is a Miner's
sum, so (8.3) says that the sum of both sums stays within 1 (docs/theory/welds.md).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np
import numpy.typing as npt
import rainflow  # type: ignore[import-untyped]

from fatigue.goodman import equivalent_amplitude, goodman_utilisation
from fatigue.sn_curve import SNCurve
from fatigue.stress_path import FloatArray, point_blocks, refuse

# Cycles smaller than this fraction of the largest stress of their history are its round-off.
_ROUND_OFF = 1e-12
_Counts = dict[tuple[float, float], float]  # how often each (valley, peak) was counted
# Powers of two between which the safety is sought, and the steps that halve it down to round-off.
_LARGEST_POWER, _N_STEPS = 60.0, 58
REFERENCE, KNEE, CUT_OFF = 2e6, 5e6, 1e8  # cycles
SLOPE, SLOPE_BELOW, SHEAR_SLOPE = 3.0, 5.0, 5.0
AT_KNEE = (REFERENCE / KNEE) ** (1 / SLOPE)  # of the category
AT_CUT_OFF = AT_KNEE * (KNEE / CUT_OFF) ** (1 / SLOPE_BELOW)
SHEAR_CUT_OFF = (REFERENCE / CUT_OFF) ** (1 / SHEAR_SLOPE)


@dataclass(frozen=True, eq=False)
class Cycles:
    """Stress cycles and how often each happens, the largest first.

    stress_amplitude  (n_cycles,) or (n_points, n_cycles)  MPa, half the range
    mean_stress       the same shape                       MPa
    cycle_counts      the same shape                       half cycles count 0.5

    A point with fewer cycles than others has zeros behind its last.
    """

    stress_amplitude: FloatArray
    mean_stress: FloatArray
    cycle_counts: FloatArray

    def __post_init__(self) -> None:
        shape = self.stress_amplitude.shape
        others = (self.mean_stress.shape, self.cycle_counts.shape)
        if len(shape) not in (1, 2) or others != (shape, shape):
            raise ValueError(
                "cycles need amplitudes, means and counts of one shape, (n_cycles,) or "
                f"(n_points, n_cycles), got {shape}, {others[0]} and {others[1]}"
            )
        for what, values in (
            ("amplitude", self.stress_amplitude),
            ("mean", self.mean_stress),
            ("count", self.cycle_counts),
        ):
            refuse(~np.isfinite(values), f"the {what} of a cycle is not finite", values)
        refuse(self.stress_amplitude < 0.0, "an amplitude is below 0 MPa", self.stress_amplitude)
        refuse(self.cycle_counts < 0.0, "a cycle count is below 0", self.cycle_counts)

    @property
    def stress_range(self) -> FloatArray:
        """Twice the amplitude, MPa."""
        return 2.0 * self.stress_amplitude

    @property
    def peak(self) -> FloatArray:
        """The highest stress of each cycle, MPa."""
        return self.mean_stress + self.stress_amplitude

    @property
    def valley(self) -> FloatArray:
        """The lowest stress of each cycle, MPa."""
        return self.mean_stress - self.stress_amplitude

    def of_point(self, point: int) -> Cycles:
        """The cycles of one point, without the zeros behind its last."""
        used = self.cycle_counts[point] > 0.0
        return Cycles(
            self.stress_amplitude[point][used],
            self.mean_stress[point][used],
            self.cycle_counts[point][used],
        )

    def repeated(self, times: float) -> Cycles:
        """Return these cycles with all counts multiplied."""
        return replace(self, cycle_counts=self.cycle_counts * times)


@dataclass(frozen=True, eq=False)
class LifeVerdict:
    """Number of duties that each point endures, and the factor by which the loads could grow.

    damage               (n_points,)  of one duty; infinite where a cycle cannot be endured once
    infinite_utilisation (n_points,)  of the worst cycle against the endurance limit, both amplitude
                                      and mean growing; at most 1 is an infinite life
    safety               (n_points,)  factor on all stresses of the duty with which it does just the
                                      allowed damage; infinite if unloaded
    allowed_damage                    for which the safety holds
    """

    damage: FloatArray
    infinite_utilisation: FloatArray
    safety: FloatArray
    allowed_damage: float

    @property
    def critical(self) -> int:
        """The point with the smallest safety; of equal ones, the first."""
        return int(self.safety.argmin())


def miner_damage(
    stress_amplitude: npt.ArrayLike, cycle_counts: npt.ArrayLike, curve: SNCurve
) -> FloatArray:
    """Return the damage of fully reversed amplitudes, summed over their last axis.

    Both (n_cycles,) or (n_points, n_cycles), MPa and cycles; the result is () or (n_points,).

    >>> curve = SNCurve(knee_amplitude=100.0, knee_cycles=1e6, slope=5.0)
    >>> float(miner_damage([200.0, 99.0], [31250.0, 1e9], curve))
    1.0
    """
    counts = _counts(cycle_counts)
    per_cycle = curve.damage_per_cycle(stress_amplitude)
    if np.isfinite(per_cycle).all():
        return np.asarray(np.einsum("...c,...c->...", per_cycle, counts))
    with np.errstate(over="ignore"):
        return np.asarray((np.where(counts > 0.0, per_cycle, 0.0) * counts).sum(axis=-1))


def life_verdict(
    duty: Cycles,
    curve: SNCurve,
    ultimate_strength: float,
    *,
    allowed_damage: float = 1.0,
) -> LifeVerdict:
    """Return damage, life and safety of every point under a duty, mean stress by Goodman.

    The safety scales amplitudes and means together, as the loads do. On a curve with an endurance
    limit (Miner original) damage jumps where a cycle reaches it: the safety then is the largest
    factor with no more than the allowed damage, to 1e-15 of it.
    """
    if not (isfinite(allowed_damage) and allowed_damage > 0.0):
        raise ValueError(f"the allowed damage must be above 0, got {allowed_damage:g}")
    amplitude, mean, counts = (
        np.atleast_2d(a) for a in (duty.stress_amplitude, duty.mean_stress, duty.cycle_counts)
    )

    def damage_at(factor: FloatArray) -> FloatArray:
        scaled = equivalent_amplitude(
            factor[:, None] * amplitude, factor[:, None] * mean, ultimate_strength
        )
        return miner_damage(scaled, counts, curve)

    knee = np.asarray(curve.knee_amplitude, dtype=np.float64)
    utilisation = goodman_utilisation(
        amplitude, mean, knee[:, None] if knee.ndim else knee, ultimate_strength
    )
    worst = np.where(counts > 0.0, utilisation, 0.0).max(axis=1)
    n_points = len(worst)
    damage = damage_at(np.ones(n_points))
    safety = largest_factor(damage_at, n_points, allowed_damage)
    return LifeVerdict(damage, worst, safety, allowed_damage)


def largest_factor(
    damage_at: Callable[[FloatArray], FloatArray], n_points: int, allowed_damage: float
) -> FloatArray:
    """Largest factor (n_points,) on all loads with no more than the allowed damage.

    damage_at  factors (n_points,) to damage (n_points,), which nowhere falls as they rise

    By bisection of its logarithm, so that a damage that jumps is no obstacle; infinite where no
    factor brings so much damage.
    """
    endured, failing = np.full(n_points, -_LARGEST_POWER), np.full(n_points, _LARGEST_POWER)
    never = damage_at(2.0**failing) <= allowed_damage
    for _ in range(_N_STEPS):
        middle = (endured + failing) / 2.0
        fails = damage_at(2.0**middle) > allowed_damage
        failing = np.where(fails, middle, failing)
        endured = np.where(fails, endured, middle)
    return np.where(never, np.inf, 2.0**endured)


def _counts(cycle_counts: npt.ArrayLike) -> FloatArray:
    counts = np.asarray(cycle_counts, dtype=np.float64)
    refuse(~(np.isfinite(counts) & (counts >= 0.0)), "a cycle count must be at least 0", counts)
    return counts


def duty_cycles(histories: Sequence[npt.ArrayLike], counts: Sequence[float]) -> Cycles:
    """Return the cycles of one duty, the transitions between its blocks among them.

    histories  one per block, each (n_positions,) or each (n_points, n_positions), MPa, as in
               `count_closed_cycles`; blocks may differ in n_positions
    counts     how often each block runs in one duty
    """
    blocks = [check_histories(history) for history in histories]
    if not blocks or len(counts) != len(blocks):
        raise ValueError(
            f"a duty needs at least one block and a count for each, got {len(blocks)} blocks "
            f"and {len(counts)} counts"
        )
    kinds = {
        (np.ndim(history), len(block)) for history, block in zip(histories, blocks, strict=True)
    }
    if len(kinds) > 1:
        raise ValueError(
            "the blocks of a duty must hold the same points, got the shapes "
            f"{[np.shape(history) for history in histories]}"
        )
    times = np.asarray(counts, dtype=np.float64)
    refuse(~(np.isfinite(times) & (times > 0.0)), "a block's count must be above 0", times, "block")
    cycles = _paired(blocks, times)
    if np.ndim(histories[0]) == 1:
        return Cycles(cycles.stress_amplitude[0], cycles.mean_stress[0], cycles.cycle_counts[0])
    return cycles


def _paired(blocks: list[FloatArray], times: FloatArray) -> Cycles:
    """Return the cycles of blocks in the order that makes the largest ones most frequent."""
    inner: list[Cycles] = []
    for block, n in zip(blocks, times, strict=True):
        cycles = count_closed_cycles(block).repeated(float(n))
        rest = cycles.cycle_counts.copy()
        rest[:, 0] -= n  # one of the largest cycles per run of the block goes into the pairing
        inner.append(Cycles(cycles.stress_amplitude, cycles.mean_stress, rest))
    peaks = np.stack([block.max(axis=1) for block in blocks], axis=1)
    valleys = np.stack([block.min(axis=1) for block in blocks], axis=1)

    n_points, n_blocks = peaks.shape
    descending = np.argsort(-peaks, axis=1, kind="stable")
    ascending = np.argsort(valleys, axis=1, kind="stable")
    # both queues, counted from their fronts; the pair changes where either goes on to its next
    ends = np.concatenate(
        [np.cumsum(times[descending], axis=1), np.cumsum(times[ascending], axis=1)], axis=1
    )
    cuts = np.sort(ends, axis=1)
    counts = np.diff(cuts, axis=1, prepend=0.0)
    middle = (cuts - counts / 2.0)[:, :, None]
    last = n_blocks - 1
    at_peak = np.minimum((ends[:, None, :n_blocks] < middle).sum(axis=2), last)
    at_valley = np.minimum((ends[:, None, n_blocks:] < middle).sum(axis=2), last)
    rows = np.arange(n_points)[:, None]
    peak = np.take_along_axis(peaks[rows, descending], at_peak, axis=1)
    valley = np.take_along_axis(valleys[rows, ascending], at_valley, axis=1)
    # sums of counts are known to this; and a peak below a valley is no cycle but on the way of one
    round_off = 4.0 * n_blocks * np.finfo(float).eps * float(times.sum())
    counts = np.where((counts > round_off) & (peak >= valley), counts, 0.0)
    amplitude = np.where(counts > 0.0, peak / 2.0 - valley / 2.0, 0.0)
    mean = np.where(counts > 0.0, peak / 2.0 + valley / 2.0, 0.0)
    return _together([Cycles(amplitude, mean, counts), *inner])


def _together(parts: list[Cycles]) -> Cycles:
    """Return all cycles of all parts, the largest first; columns that no point uses are dropped."""
    amplitude, mean, counts = (
        np.concatenate([getattr(part, name) for part in parts], axis=1)
        for name in ("stress_amplitude", "mean_stress", "cycle_counts")
    )
    used = counts > 0.0
    # unused ones last; of equal amplitudes the higher mean first
    order = np.lexsort((-mean, -amplitude, ~used), axis=1)
    columns = order[:, : max(1, int(used.sum(axis=1).max()))]
    kept = np.take_along_axis(used, columns, axis=1)
    return Cycles(
        *(
            np.where(kept, np.take_along_axis(values, columns, axis=1), 0.0)
            for values in (amplitude, mean, counts)
        )
    )


def count_closed_cycles(history: npt.ArrayLike) -> Cycles:
    """Return the cycles of one repetition of histories that repeat without end.

    history  (n_positions,) or (n_points, n_positions)  MPa; its last position is followed by its
             first, and may or may not repeat it

    ASTM E1049-85 (2017), 5.4.5: the count starts at the highest peak, so that all cycles are whole.
    A history that never changes is one cycle without amplitude, so that its mean is not lost.
    Cycles below 1e-12 of the largest stress of their history are round-off, and left out.

    >>> cycles = count_closed_cycles([0, 500, 200, 400, 300, 500, -300, 200, -500])
    >>> cycles.stress_range.tolist(), cycles.cycle_counts.tolist()
    ([1000.0, 500.0, 300.0, 100.0], [1.0, 1.0, 1.0, 1.0])
    """
    histories = check_histories(history)
    found: list[_Counts] = []
    smallest: list[float] = []
    for block in point_blocks(len(histories), 8 * histories.shape[1]):
        path = _from_the_peak(histories[block])
        turning = _turning_points(path)
        smallest += _smallest(path).tolist()
        for values, turns in zip(path, turning, strict=True):
            between = values[turns].tolist()
            peak = float(values[0])
            if len(between) > 1:
                found.append(_count([peak, *between, peak]))
            else:  # one valley or none: nothing to sort out
                found.append({(between[0] if between else peak, peak): 1.0})
    assert all(count.is_integer() for counts in found for count in counts.values())
    cycles = _as_cycles(found, smallest)
    return _of_one_point(cycles) if np.ndim(history) == 1 else cycles


def check_histories(history: npt.ArrayLike) -> FloatArray:
    """Return histories (n_points, n_positions) of floats, or say which value cannot be used."""
    histories = np.asarray(history, dtype=np.float64)
    if histories.ndim not in (1, 2) or 0 in histories.shape:
        raise ValueError(
            "a stress history needs the shape (n_positions,) or (n_points, n_positions) with at "
            f"least one position, got {histories.shape}"
        )
    refuse(~np.isfinite(histories), "the stress history is not finite", histories, "position")
    return np.atleast_2d(histories)


def _from_the_peak(histories: FloatArray) -> FloatArray:
    """Turn each history so that it begins at its highest value, and repeat that at the end."""
    n_positions = histories.shape[1]
    order = np.arange(n_positions + 1) + histories.argmax(axis=1)[:, None]
    return np.take_along_axis(histories, order % n_positions, axis=1)


def _turning_points(path: FloatArray) -> npt.NDArray[np.bool_]:
    """Return where each path turns, not counting its ends; a plateau turns at its last position."""
    turns = np.zeros(path.shape, dtype=bool)
    if path.shape[1] < 3:
        return turns
    # signs of the differences: the difference of two huge or two tiny numbers cannot mislead these
    direction = (path[:, 1:] > path[:, :-1]).astype(np.int8) - (path[:, 1:] < path[:, :-1])
    steps = np.where(direction != 0, np.arange(direction.shape[1]), 0)
    latest = np.maximum.accumulate(steps, axis=1)  # the step that led onto a plateau
    direction = np.take_along_axis(direction, latest, axis=1)
    turns[:, 1:-1] = direction[:, :-1] * direction[:, 1:] < 0
    return turns


def _count(values: list[float]) -> _Counts:
    """Return how often the package counts each (valley, peak) of a list of turning points.

    The package compares ranges with one end in common, which only the order of the other ends
    decides; it is given their ranks, as differences of stresses are rounded and whole numbers not.
    The last is given twice: it finds nothing in a list of two.
    """
    values = [*values, values[-1]]
    rank = {value: index for index, value in enumerate(sorted(set(values)))}
    counts: _Counts = defaultdict(float)
    for _, _, count, first, second in rainflow.extract_cycles([rank[value] for value in values]):
        low, high = values[first], values[second]
        if low != high:
            counts[(low, high) if low < high else (high, low)] += count
    return counts


def _smallest(path: FloatArray) -> FloatArray:
    """Return, per path, the smallest amplitude that is not round-off, MPa."""
    return np.asarray(_ROUND_OFF / 2.0 * np.abs(path).max(axis=-1))


def _as_cycles(found: Sequence[_Counts], smallest: Iterable[float]) -> Cycles:
    """Return (n_points, n_cycles) cycles, the largest first, of each point's counts."""
    rows = []
    for counts, limit in zip(found, smallest, strict=True):
        # halves first: the sum or difference of two large numbers could overflow
        row = [
            (high / 2.0 - low / 2.0, low / 2.0 + high / 2.0, count)
            for (low, high), count in counts.items()
        ]
        kept = [cycle for cycle in row if cycle[0] >= limit]
        # without any amplitude, the mean is what there is to judge
        rows.append(sorted(kept, reverse=True) or [(0.0, mean, n) for _, mean, n in row[:1]])
    table = np.zeros((3, len(rows), max(map(len, rows))))
    for index, row in enumerate(rows):
        if row:
            table[:, index, : len(row)] = np.transpose(row)
    return Cycles(table[0], table[1], table[2])


def _of_one_point(cycles: Cycles) -> Cycles:
    return Cycles(cycles.stress_amplitude[0], cycles.mean_stress[0], cycles.cycle_counts[0])


def weld_damage(stress_range: npt.ArrayLike, category: float) -> FloatArray:
    """Damage 1/N of one cycle of each range of normal stress, MPa; the shape of the ranges.

    >>> [float(round(1 / n)) for n in weld_damage([160.0, 80.0], 80.0)]
    [250000.0, 2000000.0]
    """
    ranges, knee = np.asarray(stress_range, dtype=np.float64), AT_KNEE * category
    slope = np.where(ranges > knee, SLOPE, SLOPE_BELOW)
    return np.where(ranges > AT_CUT_OFF * category, (ranges / knee) ** slope / KNEE, 0.0)


def weld_shear_damage(stress_range: npt.ArrayLike, category: float) -> FloatArray:
    """Damage 1/N of one cycle of each range of shear stress, MPa; the shape of the ranges."""
    ranges = np.asarray(stress_range, dtype=np.float64)
    harm = (ranges / category) ** SHEAR_SLOPE / REFERENCE
    return np.where(ranges > SHEAR_CUT_OFF * category, harm, 0.0)


def weld_safety(
    normal: Cycles, shear: Cycles, categories: tuple[float, float], *, allowed_damage: float = 1.0
) -> FloatArray:
    """Factor (n_points,) on all ranges with which both sums together reach the allowed damage.

    normal      (n_points, n_cycles) of each point; shear: (n_cycles,) of all of them
    categories  MPa, of normal stress and of shear

    At a cut-off damage jumps: the safety is the largest factor with no more than the allowed
    damage. Infinite where nothing is loaded.
    """

    def damage_at(factor: FloatArray) -> FloatArray:
        own = weld_damage(factor[:, None] * normal.stress_range, categories[0])
        beside = weld_shear_damage(factor[:, None] * shear.stress_range, categories[1])
        found = (own * normal.cycle_counts).sum(axis=1) + (beside * shear.cycle_counts).sum(axis=1)
        return np.asarray(found)

    return largest_factor(damage_at, len(normal.stress_amplitude), allowed_damage)


def endless_weld_safety(
    normal: FloatArray, shear: float, categories: tuple[float, float], *, begun: bool = False
) -> FloatArray:
    """Factor (n_points,) on all ranges up to which a life has no end.

    normal  (n_points,) MPa, largest range of each point; shear: of all of them
    begun   whether earlier use has done damage: then the cut-off is the limit, not S_D

    Both together as in equation (8.3), with the limits of an endless life for the categories: the
    root n of (n S/S_D)^3 + (n T/T_L)^5 = 1.
    """
    first = normal / ((AT_CUT_OFF if begun else AT_KNEE) * categories[0])
    second = np.full(len(first), shear / (SHEAR_CUT_OFF * categories[1]))
    largest = np.maximum(first, second)
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = 0.5 / largest, 1.0 / largest
        for _ in range(_N_STEPS):
            middle = (low + high) / 2.0
            beyond = (middle * first) ** SLOPE + (middle * second) ** SHEAR_SLOPE > 1.0
            low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return np.where(largest > 0.0, low, np.inf)
