"""Facts on a part's fatigue: the stresses behind its verdict, and its life."""

from math import inf, isfinite

import numpy as np

import fatigue
from checks.stress.duty_verdict import FatiguePeak, widest
from checks.stress.stress_result import Stressed
from fatigue.proportionality import PROPORTIONAL
from geometry.mesh import FloatArray, IntArray


def path_of(level: Stressed, peak: FatiguePeak) -> IntArray:
    """Positions of the path that decides; of a finite life those of all cycles."""
    runs = level.judged_duty.runs
    if peak.cycle in runs:
        return runs[peak.cycle]
    return runs[widest(runs)]


def deciding_pair(level: Stressed, peak: FatiguePeak) -> tuple[int, int]:
    """Positions of the deciding pair; where Findley's plane decides, the longest chord's ends."""
    if peak.criterion != "Findley":
        return peak.pair
    run = path_of(level, peak)
    path = np.ascontiguousarray(level.coefficients[:, run])
    chords = fatigue.goodman(level.history.basis[[peak.point]], path, 1.0, 1.0)
    first, second = (int(run[k]) for k in chords.pair[0])
    return first, second


def chord_at(level: Stressed, peak: FatiguePeak) -> tuple[float, float]:
    """Amplitude and mean as Goodman counts it, of the `deciding_pair`, MPa."""
    path = np.ascontiguousarray(level.coefficients[:, list(deciding_pair(level, peak))])
    chord = fatigue.chord_path(level.history.basis[peak.point], path, (0, 1))
    return chord.amplitude, chord.mean


def plane_at(level: Stressed, peak: FatiguePeak) -> str:
    """Findley's critical plane of the critical point, in words."""
    plane = fatigue.critical_plane(_stress(level, peak), fatigue.findley_criterion().k)
    x, y, z = plane.normal
    return (
        f"on the plane with normal ({x:.3f}, {y:.3f}, {z:.3f}) shear amplitude "
        f"{plane.shear_amplitude:.4g} MPa, normal stress {plane.normal_stress:.4g} MPa"
    )


def _stress(level: Stressed, peak: FatiguePeak) -> FloatArray:
    """Stress (6, n) of the critical point over the path that decides, MPa."""
    path = np.ascontiguousarray(level.coefficients[:, path_of(level, peak)])
    return np.asarray(level.history.basis[peak.point] @ path)


def fatigue_facts(level: Stressed, peak: FatiguePeak) -> dict[str, float | str]:
    """Facts of the critical point, by name: its stresses, and whether their path is straight.

    The safety by Findley's plane is on all loads.
    """
    amplitude, mean = chord_at(level, peak)
    facts: dict[str, float | str] = {
        "fatigue amplitude [MPa]": amplitude,
        "fatigue mean stress [MPa]": mean,
    }
    limit = float(level.limits[peak.point])
    criterion = fatigue.findley_criterion()
    path = np.ascontiguousarray(level.coefficients[:, path_of(level, peak)])
    bounds = fatigue.path_bounds(level.history.basis[[peak.point]], path, criterion.k)
    stress = _stress(level, peak)
    width = float(bounds.width[0])
    if width <= PROPORTIONAL:
        facts["stress path at the critical point"] = "proportional: Goodman alone decides"
    else:
        facts["stress path at the critical point"] = (
            f"not proportional, {width:.2g} as wide as long"
        )
        used = fatigue.critical_plane(stress, criterion.k).value / (criterion.limit_ratio * limit)
        facts["Findley's critical plane"] = (
            f"{plane_at(level, peak)}; safety for infinite life {_safety(used)}"
        )
    return facts


def _safety(utilisation: float) -> str:
    safety = 1.0 / utilisation if utilisation > 0.0 else inf
    return f"{safety:.3g}" if isfinite(safety) else "no limit"
