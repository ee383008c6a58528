"""Damage, life and safety of a duty by the Palmgren-Miner rule.

Damage of a duty is the sum of n/N over its cycles, N from an S-N curve at the equivalent fully
reversed amplitude; the part fails when it reaches an allowed sum, 1 by Miner. Tests under variable
amplitudes give less: FKM takes 0.3 to 1. Miner's rule knows no order of loads.

A duty is several blocks (start, idle, stroke, overload), each run a number of times.

Between two blocks the stress goes from the extremes of one to those of the other, and that cycle
(ground-air-ground, for an aircraft) may be larger than any within a block. How often it happens
depends on the order in which the blocks run:

"unknown"    The highest peaks meet the lowest valleys, as often as the counts allow: the largest
             cycle of each block is taken apart into its peak and its valley, then the highest peak
             left is paired with the lowest valley left, min(count, count) times, until none is
             left. ASME Boiler and Pressure Vessel Code, III, NB-3222.4(e)(5). No order in which
             each peak and valley happens once gives more cycles that reach above v and below u,
             for any u < v. The smaller cycles of a block stay as counted within it.
"as_listed"  All repetitions of the first block, then all of the second, and so on, over and over.
             Exactly the count of that long history (docs/theory/life.md); the transitions run from
             the last position of a block to the first of the next.

Where blocks mix, as idle turns and strokes do, "as_listed" would count one transition per duty
instead of thousands; "unknown" is therefore the default.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Literal

import numpy as np
import numpy.typing as npt

from fatigue.counting import Cycles, check_histories, count_closed_cycles
from fatigue.mean_stress import (
    MeanStressMaterial,
    Rule,
    equivalent_amplitude,
    mean_stress_utilisation,
)
from fatigue.sn_curve import SNCurve
from fatigue.stress_path import FloatArray, refuse

Order = Literal["unknown", "as_listed"]

# Powers of two between which the safety is sought, and the steps that halve it down to round-off.
_LARGEST_POWER, _N_STEPS = 60.0, 58


@dataclass(frozen=True, eq=False)
class LifeVerdict:
    """Number of duties that each point endures, and the factor by which the loads could grow.

    damage               (n_points,)  of one duty; infinite where a cycle cannot be endured once
    duties_to_failure    (n_points,)  allowed damage over damage; infinite without damage
    infinite_utilisation (n_points,)  of the worst cycle against the endurance limit, both amplitude
                                      and mean growing; at most 1 is an infinite life
    safety               (n_points,)  factor on all stresses of the duty with which the required
                                      duties do just the allowed damage; infinite if unloaded
    required_duties, allowed_damage   for which the safety holds
    """

    damage: FloatArray
    duties_to_failure: FloatArray
    infinite_utilisation: FloatArray
    safety: FloatArray
    required_duties: float
    allowed_damage: float

    @property
    def critical(self) -> int:
        """The point with the smallest safety; of equal ones, the first."""
        return int(self.safety.argmin())

    @property
    def finite_life(self) -> bool:
        """True if every point endures the required duties."""
        return bool((self.damage * self.required_duties <= self.allowed_damage).all())


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
    material: MeanStressMaterial,
    rule: Rule = "goodman",
    *,
    required_duties: float = 1.0,
    allowed_damage: float = 1.0,
    credit: bool = False,
) -> LifeVerdict:
    """Return damage, life and safety of every point under a duty.

    The safety scales amplitudes and means together, as the loads do. On a curve with an endurance
    limit (Miner original) damage jumps where a cycle reaches it: the safety then is the largest
    factor with no more than the allowed damage, to 1e-15 of it.
    """
    for what, value in (("required duties", required_duties), ("allowed damage", allowed_damage)):
        if not (isfinite(value) and value > 0.0):
            raise ValueError(f"the {what} must be above 0, got {value:g}")
    amplitude, mean, counts = (
        np.atleast_2d(a) for a in (duty.stress_amplitude, duty.mean_stress, duty.cycle_counts)
    )

    def damage_at(factor: FloatArray) -> FloatArray:
        scaled = equivalent_amplitude(
            factor[:, None] * amplitude, factor[:, None] * mean, material, rule, credit=credit
        )
        return miner_damage(scaled, counts, curve)

    knee = np.asarray(curve.knee_amplitude, dtype=np.float64)
    utilisation = mean_stress_utilisation(
        amplitude, mean, knee[:, None] if knee.ndim else knee, material, rule, credit=credit
    )
    worst = np.where(counts > 0.0, utilisation, 0.0).max(axis=1)
    n_points = len(worst)
    damage = damage_at(np.ones(n_points))
    with np.errstate(divide="ignore", over="ignore"):
        duties = allowed_damage / damage

    endured = np.full(n_points, -_LARGEST_POWER)
    failing = np.full(n_points, _LARGEST_POWER)
    never = damage_at(2.0**failing) * required_duties <= allowed_damage
    for _ in range(_N_STEPS):
        middle = (endured + failing) / 2.0
        fails = damage_at(2.0**middle) * required_duties > allowed_damage
        failing = np.where(fails, middle, failing)
        endured = np.where(fails, endured, middle)
    safety = np.where(never, np.inf, 2.0**endured)
    return LifeVerdict(damage, duties, worst, safety, required_duties, allowed_damage)


def _counts(cycle_counts: npt.ArrayLike) -> FloatArray:
    counts = np.asarray(cycle_counts, dtype=np.float64)
    refuse(~(np.isfinite(counts) & (counts >= 0.0)), "a cycle count must be at least 0", counts)
    return counts


def duty_cycles(
    histories: Sequence[npt.ArrayLike], counts: Sequence[float], *, order: Order = "unknown"
) -> Cycles:
    """Return the cycles of one duty, the transitions between its blocks among them.

    histories  one per block, each (n_positions,) or each (n_points, n_positions), MPa, as in
               `count_closed_cycles`; blocks may differ in n_positions
    counts     how often each block runs in one duty; whole numbers if "as_listed"
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
    if order == "unknown":
        cycles = _paired(blocks, times)
    elif order == "as_listed":
        refuse(times != np.round(times), "blocks as listed need whole counts", times, "block")
        whole = count_closed_cycles(np.concatenate(blocks, axis=1))
        again = [
            count_closed_cycles(block).repeated(n - 1.0)
            for block, n in zip(blocks, times, strict=True)
        ]
        cycles = _together([whole, *again])
    else:
        raise ValueError(f"order {order!r} is unknown; one of 'unknown', 'as_listed'")
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
