"""Damage, life and safety of a duty by the Palmgren-Miner rule.

Damage of a duty is the sum of n/N over its cycles, N from an S-N curve at the equivalent fully
reversed amplitude; the part fails when it reaches an allowed sum, 1 by Miner. Tests under variable
amplitudes give less: FKM takes 0.3 to 1, see `fkm_damage_sum`. Miner's rule knows no order of
loads; `overstressed_curve` does, for one block after another.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite, log10
from typing import Literal

import numpy as np
import numpy.typing as npt

from fatigue.counting import Cycles
from fatigue.mean_stress import (
    MeanStressMaterial,
    Rule,
    equivalent_amplitude,
    mean_stress_utilisation,
)
from fatigue.sn_curve import LOW_CYCLE, SNCurve
from fatigue.stress_path import FloatArray, refuse

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


def fkm_damage_sum(
    stress_amplitude: npt.ArrayLike, cycle_counts: npt.ArrayLike, slope: float
) -> FloatArray:
    """Return the damage sum at failure, 2 / A**(1/4), between 0.3 and 1, over the last axis.

    A = sum n / sum n (S/S_max)**k is how many times longer the spectrum lives than its largest
    amplitude: long spectra fail early. Wächter, Müller, Esderts, Angewandter Festigkeitsnachweis
    nach FKM-Richtlinie (2017), p. 99. Without any amplitude it is 1.
    """
    amplitude = np.asarray(stress_amplitude, dtype=np.float64)
    counts = _counts(cycle_counts)
    refuse(~(np.isfinite(amplitude) & (amplitude >= 0.0)), "not an amplitude", amplitude)
    largest = np.where(counts > 0.0, amplitude, 0.0).max(axis=-1, keepdims=True)
    fullness = (counts * (amplitude / np.where(largest > 0.0, largest, 1.0)) ** slope).sum(axis=-1)
    total = np.broadcast_to(counts, amplitude.shape).sum(axis=-1)
    share = np.where(largest[..., 0] > 0.0, fullness / np.where(total > 0.0, total, 1.0), 1.0)
    return np.asarray(np.clip(2.0 * share**0.25, 0.3, 1.0))


def overstressed_curve(
    curve: SNCurve, amplitude: float, cycles: float, method: Literal["miner", "manson"]
) -> SNCurve:
    """Return the curve of a part that has already borne `cycles` of an amplitude above the knee.

    Both pass through (amplitude, cycles that are left). Miner keeps the slope, and so lowers even
    the strength at 1e3 cycles; Manson keeps that strength and turns the line about it. Shigley,
    9th ed., chapter 6, cumulative fatigue damage. For several blocks, apply it again.
    """
    if method not in ("miner", "manson"):
        raise ValueError(f"method {method!r} is unknown; one of 'miner', 'manson'")
    if np.ndim(curve.knee_amplitude) or np.ndim(curve.slope) or np.ndim(curve.knee_cycles):
        raise ValueError("overstress is worked out for a single curve, not for one per point")
    knee, knee_cycles = float(curve.knee_amplitude), float(curve.knee_cycles)
    slope = float(curve.slope)
    if not (isfinite(amplitude) and isfinite(cycles) and cycles >= 0.0):
        raise ValueError(f"{cycles:g} cycles of {amplitude:g} MPa cannot be applied")
    if amplitude < knee:
        return curve
    left = float(curve.cycles_to_failure(amplitude)) - cycles
    if left <= 0.0:
        raise ValueError(
            f"{cycles:g} cycles of {amplitude:g} MPa already break the part: it endures "
            f"{left + cycles:.0f}"
        )
    if method == "miner":
        return replace(curve, knee_amplitude=amplitude * (left / knee_cycles) ** (1.0 / slope))
    start = knee * (knee_cycles / LOW_CYCLE) ** (1.0 / slope)
    if amplitude >= start or left <= LOW_CYCLE:
        raise ValueError(
            f"Manson's line needs an amplitude below {start:g} MPa and more than 1000 cycles left, "
            f"got {amplitude:g} MPa and {left:.0f}"
        )
    steeper = log10(left / LOW_CYCLE) / log10(start / amplitude)
    lowered = start * (LOW_CYCLE / knee_cycles) ** (1.0 / steeper)
    straight = float(curve.slope_below) == slope  # Miner elementary stays elementary
    below = steeper if straight else curve.slope_below
    return replace(curve, knee_amplitude=lowered, slope=steeper, slope_below=below)


def _counts(cycle_counts: npt.ArrayLike) -> FloatArray:
    counts = np.asarray(cycle_counts, dtype=np.float64)
    refuse(~(np.isfinite(counts) & (counts >= 0.0)), "a cycle count must be at least 0", counts)
    return counts
