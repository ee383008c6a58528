"""Notch support: support numbers, as a notch endures more than its peak says.

FKM takes the local stress and divides its demand by a support number n >= 1 that depends on the
related stress gradient G (1/mm) at the surface.

G = -(d sigma/dn)/sigma along the inward normal n: 2/h of a beam in bending (height h), 2/d of a
round bar in torsion, 7/(3 r) of the hoop stress beside a hole in a sheet. Negative where the stress
grows inwards; there nothing is supported.
"""

from __future__ import annotations

from math import isfinite

import numpy as np
import numpy.typing as npt

from fatigue.fkm_groups import StressKind, fkm_group, stress_ratio
from fatigue.stress_path import FloatArray, refuse

STEEPEST = 100.0  # 1/mm, the end of Stieler's law; what is steeper counts as this


def stieler_support(
    gradient: npt.ArrayLike,
    ultimate_strength: float,
    group: str = "steel",
    stress: StressKind = "normal",
) -> FloatArray:
    """Return n >= 1 of related gradients, 1/mm, of any shape.

    G <= 0.1          1 + G 10**-(a_G - 0.5 + R/b_G)
    0.1 < G <= 1      1 + sqrt(G) 10**-(a_G + R/b_G)
    1 < G <= 100      1 + G**(1/4) 10**-(a_G + R/b_G)

    R is the ultimate strength, times f_W,tau for shear. FKM guideline, 6th ed., section 4.3.1.3.1.

    >>> stieler_support([0.0, 0.5], 210.0, "grey_iron").round(3).tolist()
    [1.0, 1.682]
    """
    gradient = _gradients(gradient)
    _above_zero("ultimate strength", ultimate_strength, "MPa")
    own = fkm_group(group)
    a, b = own.support
    reach = 10.0 ** -(a + ultimate_strength * stress_ratio(own, stress) / b)
    root = np.where(gradient <= 1.0, np.sqrt(gradient), gradient**0.25)
    return np.asarray(1.0 + reach * np.where(gradient <= 0.1, gradient * 10.0**0.5, root))


def _gradients(gradient: npt.ArrayLike) -> FloatArray:
    """Return gradients between 0 and the steepest that counts; NaN is refused with its place."""
    gradient = np.asarray(gradient, dtype=np.float64)
    refuse(np.isnan(gradient), "the related stress gradient is not a number", gradient, "point")
    return np.asarray(np.clip(gradient, 0.0, STEEPEST))


def _above_zero(what: str, value: float, unit: str) -> None:
    if not (isfinite(value) and value > 0.0):
        raise ValueError(f"the {what} must be above 0 {unit}, got {value:g}")
