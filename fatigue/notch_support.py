"""Notch support: support numbers and notch factors, as a notch endures more than its peak says.

Two chains, never mixed:

* FKM takes the local stress and divides its demand by a support number n >= 1 that depends on the
  related stress gradient G (1/mm) at the surface: `stieler_support`, or `fkm_2012_support`.
* Marin's chain takes the nominal stress times K_f, Neuber's `neuber_notch_factor`.

G = -(d sigma/dn)/sigma along the inward normal n: 2/h of a beam in bending (height h), 2/d of a
round bar in torsion, 7/(3 r) of the hoop stress beside a hole in a sheet. Negative where the stress
grows inwards; there nothing is supported.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
import numpy.typing as npt

from fatigue.fkm_groups import StressKind, fkm_group, stress_ratio
from fatigue.stress_path import FloatArray, refuse

STEEPEST = 100.0  # 1/mm, the end of Stieler's law; what is steeper counts as this
REFERENCE_AREA = 500.0  # mm2, highly stressed surface of the specimens behind n_st

_MPA_PER_KPSI = 6.894757
_SQRT_MM_PER_SQRT_INCH = 25.4**0.5
# sqrt(a) in sqrt(inch) of S_u in kpsi: Shigley, 9th ed., eqs. (6-35a) and (6-35b)
_NEUBER = {
    "bending": (0.246, -3.08e-3, 1.51e-5, -2.67e-8),
    "axial": (0.246, -3.08e-3, 1.51e-5, -2.67e-8),
    "torsion": (0.190, -2.51e-3, 1.35e-5, -2.67e-8),
}
# E (MPa), plastic strain at the fatigue limit and cyclic exponent n' of n_vm; None: n_vm = 1.
_PLASTIC = {
    "steel": (2.1e5, 2e-4, 0.15),
    "forged_steel": (2.1e5, 2e-4, 0.15),
    "case_hardened_steel": (2.1e5, 2e-4, 0.15),
    "stainless_steel": (2.1e5, 2e-4, 0.15),
    "wrought_aluminium": (0.7e5, 1.6e-5, 0.11),
}
_FRACTURE_STRENGTH = dict.fromkeys(_PLASTIC, 680.0) | {  # MPa, R_m,bm of n_bm; others: n_bm = 1
    "wrought_aluminium": 270.0,
    "cast_aluminium": 270.0,
}


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


@dataclass(frozen=True, eq=False)
class SupportNumber:
    """The support number of the 2012 guideline, n = n_st n_vm n_bm.

    value        n, of the shape of the gradients
    statistical  n_st: a large highly stressed surface holds a weaker spot; below 1 above 500 mm2
    plastic      n_vm: stress that yields at the notch is carried on by what is around
    fracture     n_bm: a crack grows into falling stress, of the shape of the gradients
    """

    value: FloatArray
    statistical: float
    plastic: float
    fracture: FloatArray


def fkm_2012_support(
    gradient: npt.ArrayLike, stressed_area: float, ultimate_strength: float, group: str = "steel"
) -> SupportNumber:
    """Return the support number of a highly stressed surface in mm2 and related gradients in 1/mm.

    n_st = (500 mm2 / area)**(1/k_st), the area stressed above 90 % of the peak;
    n_vm = sqrt(1 + E e_pl n_st**(1/n' - 1) / sigma_W), e_pl of steel falling above 630 MPa;
    n_bm = (5 + sqrt G) / (5 n_vm n_st + R_m/R_bm sqrt((7.5 + sqrt G)/(1 + 0.2 sqrt G))) >= 1.

    FKM guideline, 6th ed., section 4.3.1.3.2, for normal stress.
    """
    gradient = _gradients(gradient)
    _above_zero("highly stressed area", stressed_area, "mm2")
    _above_zero("ultimate strength", ultimate_strength, "MPa")
    own = fkm_group(group)
    statistical = (REFERENCE_AREA / stressed_area) ** (1.0 / own.weibull)
    plastic = 1.0
    if group in _PLASTIC:
        modulus, strain, exponent = _PLASTIC[group]
        if group != "wrought_aluminium" and ultimate_strength > 630.0:
            strain *= max(0.0, 1.0 - 0.375 * (ultimate_strength / 630.0 - 1.0))
        strength = own.strength_ratio * ultimate_strength
        plastic = (1.0 + modulus * strain * statistical ** (1.0 / exponent - 1.0) / strength) ** 0.5
    fracture = np.ones_like(gradient)
    if group in _FRACTURE_STRENGTH:
        root = np.sqrt(gradient)
        share = ultimate_strength / _FRACTURE_STRENGTH[group]
        depth = share * np.sqrt((7.5 + root) / (1.0 + 0.2 * root))
        fracture = np.maximum((5.0 + root) / (5.0 * plastic * statistical + depth), 1.0)
    value = np.asarray(statistical * plastic * fracture)
    return SupportNumber(value, statistical, plastic, np.asarray(fracture))


def neuber_notch_factor(
    stress_concentration: float, notch_radius: float, ultimate_strength: float, load: str = "axial"
) -> float:
    """Return K_f = 1 + (K_t - 1)/(1 + sqrt(a/r)) of steel: for nominal stress in Marin's chain.

    notch_radius r in mm; load bending, axial or torsion. Shigley, 9th ed., eqs. (6-33) to (6-35),
    given for 340 to 1700 MPa (50 to 250 kpsi) and refused beyond.

    >>> round(neuber_notch_factor(1.65, 3.0, 690.0), 2)
    1.55
    """
    if load not in _NEUBER:
        raise ValueError(f"load {load!r} is unknown; one of {', '.join(_NEUBER)}")
    if not (isfinite(stress_concentration) and stress_concentration >= 1.0):
        raise ValueError(
            f"the stress concentration factor must be at least 1, got {stress_concentration:g}"
        )
    _above_zero("notch radius", notch_radius, "mm")
    if not 340.0 <= ultimate_strength <= 1700.0:
        raise ValueError(
            "Neuber's constant is given for ultimate strengths from 340 to 1700 MPa, "
            f"got {ultimate_strength:g} MPa"
        )
    kpsi = ultimate_strength / _MPA_PER_KPSI
    root = sum(factor * kpsi**power for power, factor in enumerate(_NEUBER[load]))
    root = max(0.0, root) * _SQRT_MM_PER_SQRT_INCH
    return float(1.0 + (stress_concentration - 1.0) / (1.0 + root / notch_radius**0.5))


def _gradients(gradient: npt.ArrayLike) -> FloatArray:
    """Return gradients between 0 and the steepest that counts; NaN is refused with its place."""
    gradient = np.asarray(gradient, dtype=np.float64)
    refuse(np.isnan(gradient), "the related stress gradient is not a number", gradient, "point")
    return np.asarray(np.clip(gradient, 0.0, STEEPEST))


def _above_zero(what: str, value: float, unit: str) -> None:
    if not (isfinite(value) and value > 0.0):
        raise ValueError(f"the {what} must be above 0 {unit}, got {value:g}")
