"""Fatigue of welds by ranges of nominal stress: the curves of EN 1993-1-9:2005.

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

import numpy as np
import numpy.typing as npt

from fatigue.life import Cycles, largest_factor
from fatigue.stress_path import FloatArray

REFERENCE, KNEE, CUT_OFF = 2e6, 5e6, 1e8  # cycles
SLOPE, SLOPE_BELOW, SHEAR_SLOPE = 3.0, 5.0, 5.0
AT_KNEE = (REFERENCE / KNEE) ** (1 / SLOPE)  # of the category
AT_CUT_OFF = AT_KNEE * (KNEE / CUT_OFF) ** (1 / SLOPE_BELOW)
SHEAR_CUT_OFF = (REFERENCE / CUT_OFF) ** (1 / SHEAR_SLOPE)
_N_STEPS = 58  # halvings, down to round-off


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
