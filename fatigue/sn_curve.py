"""S-N curve: number of cycles to failure over the fully reversed stress amplitude.

    N = N_D (S/S_D)**-k   from the knee (S_D, N_D) up, N_D (S/S_D)**-k' below it

An amplitude at the knee belongs to the upper branch. Below it k' is infinite (an endurance limit:
Miner's rule in its original form), k (elementary) or 2 k - 1 (Haibach, Betriebsfestigkeit, 3rd ed.,
2006, section 3.2.2).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite, log10
from typing import Literal

import numpy as np
import numpy.typing as npt

from fatigue.stress_path import FloatArray, refuse

Variant = Literal["original", "elementary", "haibach"]

LOW_CYCLE = 1e3  # cycles, where Shigley's high-cycle line begins


@dataclass(frozen=True, eq=False)
class SNCurve:
    """Cycles endured over fully reversed stress amplitude.

    knee_amplitude     MPa   S_D
    knee_cycles              N_D
    slope                    k above the knee
    slope_below              k' below the knee, not less than k; infinite: endured without end
    ultimate_strength  MPa   if given, the curve bends at 1e3 cycles to reach it in the first cycle

    The knee and the slopes may be arrays (n_points,); the last axis of amplitudes then counts the
    cycles, (n_points, n_cycles), or (n_cycles,) for all points alike.

    >>> curve = SNCurve(knee_amplitude=200.0, knee_cycles=1e6, slope=5.0)
    >>> float(curve.cycles_to_failure(400.0))
    31250.0
    """

    knee_amplitude: float | FloatArray
    knee_cycles: float | FloatArray
    slope: float | FloatArray
    slope_below: float | FloatArray = float("inf")
    ultimate_strength: float | None = None

    def __post_init__(self) -> None:
        for name, least in (("knee_amplitude", 0.0), ("knee_cycles", 0.0), ("slope", 1.0)):
            value = np.asarray(getattr(self, name), dtype=np.float64)
            if value.ndim > 1:
                raise ValueError(
                    f"the {name.replace('_', ' ')} of an S-N curve must be one number or one per "
                    f"point, (n_points,), got {value.shape}"
                )
            problem = f"the {name.replace('_', ' ')} of an S-N curve must be above {least:g}"
            refuse(~(np.isfinite(value) & (value > least)), problem, value, "point")
        below = np.asarray(self.slope_below, dtype=np.float64)
        problem = "the slope below the knee of an S-N curve must not be less than that above"
        bad = ~(below >= np.asarray(self.slope))
        refuse(bad, problem, np.broadcast_to(below, bad.shape), "point")
        strength = self.ultimate_strength
        if strength is not None and not (isfinite(strength) and strength > 0.0):
            raise ValueError(f"the ultimate strength must be above 0 MPa, got {strength:g}")

    def damage_per_cycle(self, amplitude: npt.ArrayLike) -> FloatArray:
        """Return 1/N of amplitudes in MPa; infinite ones are allowed."""
        amplitude = np.asarray(amplitude, dtype=np.float64)
        refuse(~(amplitude >= 0.0), "the amplitude must be at least 0 MPa", amplitude)
        ratio = amplitude / _column(self.knee_amplitude)
        exponent = np.where(ratio >= 1.0, _column(self.slope), _column(self.slope_below))
        with np.errstate(over="ignore"):
            damage = ratio**exponent / _column(self.knee_cycles)
            if self.ultimate_strength is not None:
                damage = self._static(amplitude, damage, self.ultimate_strength)
        return np.asarray(damage)

    def _static(self, amplitude: FloatArray, damage: FloatArray, strength: float) -> FloatArray:
        """Bend the curve so that the ultimate strength breaks the part in the first cycle."""
        start = self._low_cycle_amplitude()
        # where the line itself passes the ultimate strength before 1e3 cycles, there is no bend
        decades = np.log10(strength / np.minimum(start, np.nextafter(strength, 0.0)))
        static = (amplitude / strength) ** (log10(LOW_CYCLE) / decades)
        damage = np.where((amplitude > start) & (start < strength), static, damage)
        return np.where(amplitude >= strength, np.maximum(damage, 1.0), damage)

    def _low_cycle_amplitude(self) -> FloatArray:
        decades = _column(self.knee_cycles) / LOW_CYCLE
        return np.asarray(_column(self.knee_amplitude) * decades ** (1.0 / _column(self.slope)))

    def cycles_to_failure(self, amplitude: npt.ArrayLike) -> FloatArray:
        """Return N of amplitudes in MPa; infinite below an endurance limit."""
        damage = self.damage_per_cycle(amplitude)
        with np.errstate(divide="ignore", over="ignore"):
            return np.asarray(1.0 / damage)

    def amplitude(self, damage_per_cycle: FloatArray) -> FloatArray:
        """Return the amplitudes, MPa, that do so much damage above 0 a cycle, one per point."""
        knee, often = np.asarray(self.knee_amplitude), damage_per_cycle * self.knee_cycles
        slope = np.where(often >= 1.0, self.slope, self.slope_below)
        found = knee * often ** (1.0 / slope)
        if self.ultimate_strength is None:
            return np.asarray(found)
        strength = self.ultimate_strength
        start = self._low_cycle_amplitude().ravel()
        bent = start * (strength / start) ** (np.log10(damage_per_cycle * LOW_CYCLE) / 3.0)
        found = np.where((found > start) & (start < strength), bent, found)
        return np.asarray(np.minimum(found, strength))

    def below_knee(self, variant: Variant) -> SNCurve:
        """Return this curve with an endurance limit, or continued as Miner's variants do."""
        slopes = {
            "original": float("inf"),
            "elementary": self.slope,
            "haibach": 2.0 * self.slope - 1.0,
        }
        if variant not in slopes:
            raise ValueError(f"Miner's variant {variant!r} is unknown; one of {', '.join(slopes)}")
        return replace(self, slope_below=slopes[variant])


def basquin_curve(
    ultimate_strength: float,
    endurance_limit: npt.ArrayLike,
    fraction: float | None = None,
    *,
    knee_cycles: float = 1e6,
) -> SNCurve:
    """Return the line through (1e3, fraction * ultimate strength) and (1e6, endurance limit).

    Shigley, 9th ed., eqs. (6-13) to (6-15); below 1e3 cycles (6-17), straight to the ultimate
    strength at the first cycle. None takes `low_cycle_fraction`, for steel.
    """
    if fraction is None:
        fraction = low_cycle_fraction(ultimate_strength)
    if not 0.0 < fraction <= 1.0:
        raise ValueError(f"the fraction at 1e3 cycles must be above 0, at most 1, got {fraction:g}")
    if not (isfinite(knee_cycles) and knee_cycles > LOW_CYCLE):
        raise ValueError(f"the knee must lie above 1e3 cycles, got {knee_cycles:g}")
    limit = np.asarray(endurance_limit, dtype=np.float64)
    start = fraction * ultimate_strength
    problem = f"the endurance limit must be above 0 and below {start:g} MPa, endured 1e3 times"
    refuse(~((limit > 0.0) & (limit < start)), problem, limit, "point")
    slope = log10(knee_cycles / LOW_CYCLE) / np.log10(start / limit)
    return SNCurve(limit, knee_cycles, slope, ultimate_strength=ultimate_strength)


def low_cycle_fraction(ultimate_strength: float) -> float:
    """Return f, the share of the ultimate strength in MPa that steel endures 1e3 times.

    f = s_F'/S_u (2e3)**b with s_F' = S_u + 345 MPa, b = -lg(s_F'/S_e')/lg(2e6), S_e' = S_u/2 but
    not above 700 MPa: Shigley, 9th ed., eqs. (6-8) to (6-12), figure 6-18. The book gives no more
    than 0.9, at 482 MPa, and says to use that below.

    >>> round(low_cycle_fraction(690.0), 3)
    0.844
    """
    if not (isfinite(ultimate_strength) and ultimate_strength > 0.0):
        raise ValueError(f"the ultimate strength must be above 0 MPa, got {ultimate_strength:g}")
    first = ultimate_strength + 345.0
    exponent = -log10(first / min(0.5 * ultimate_strength, 700.0)) / log10(2e6)
    return min(0.9, float(first / ultimate_strength * 2e3**exponent))


def _column(value: float | FloatArray) -> FloatArray:
    """Return a number per point as a column, so that it goes with (n_points, n_cycles)."""
    value = np.asarray(value, dtype=np.float64)
    return value[:, None] if value.ndim == 1 else value
