"""Component strength by the FKM guideline: local stresses, parts that are not welded.

sigma_W   = f_W R_m                                       strength of the material, R = -1
K_R       = 1 - a_R lg(Rz) lg(2 R_m/R_m,N,min)            roughness, Rz in micrometres
K_WK      = (1 + (1/K_R - 1)/K_f~) / n                    design factor
sigma_WK  = sigma_W / K_WK                                strength of the part, R = -1
sigma_AK  = K_AK sigma_WK                                 at the mean stress, `fkm_factor`
a_BK      = sigma_a / sigma_AK                            utilisation

FKM guideline, 6th ed. (2012), chapter 4. R_m holds for the part at its size: take it from the
range of thickness of its standard, or lower it by the technological size factor. Strengths hold
for a survival of 97.5 %, at room temperature, without a treated or coated surface. Nothing here
goes with Marin's factors (`marin`), which start from another strength at 50 %; a `ComponentLimit`
and an `EnduranceLimit` refuse each other's functions.

Numbers of the material groups: tables 4.2.1 (strength ratios) and 4.3.1 to 4.3.5. Their values are
those of pyLife's module `fkm_linear`, not compared with the printed tables.

A notch endures more than its peak says. FKM takes the local stress and divides its demand by a
support number n >= 1 that depends on the related stress gradient G (1/mm) at the surface.

G = -(d sigma/dn)/sigma along the inward normal n: 2/h of a beam in bending (height h), 2/d of a
round bar in torsion, 7/(3 r) of the hoop stress beside a hole in a sheet. Negative where the stress
grows inwards; there nothing is supported.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, log10
from typing import NoReturn

import numpy as np
import numpy.typing as npt

from fatigue.sn_curve import SNCurve
from fatigue.stress_path import FloatArray, checked_cycles, refuse

STEEPEST = 100.0  # 1/mm, the end of Stieler's law; what is steeper counts as this

SURVIVAL = 0.975  # share of parts, of all FKM strengths
KNEE_CYCLES = 1e6
SLOPE = 5.0  # of the component S-N curve of normal stress, section 4.4.3
_SLOPE_BELOW = 15.0  # of aluminium and austenite, to 1e8 cycles
CAST_ROUGHNESS = 200.0  # micrometres: rolling, forging and casting skin


# a_M and b_M of M = a_M Rm/1000 + b_M, Rm in MPa: FKM guideline, 6th ed., chapter 4.4.
FKM_SENSITIVITIES = {
    "steel": (0.35, -0.1),
    "cast_steel": (0.35, 0.05),
    "nodular_iron": (0.35, 0.08),
    "malleable_iron": (0.35, 0.13),
    "grey_iron": (0.0, 0.5),
    "wrought_aluminium": (1.0, -0.04),
    "cast_aluminium": (1.0, 0.2),
}


@dataclass(frozen=True)
class FkmMaterial:
    """Material properties that the guideline asks for.

    ultimate_strength         MPa, R_m of the part at its size
    group                     one of FKM_GROUPS
    """

    ultimate_strength: float
    group: str = "steel"

    def __post_init__(self) -> None:
        fkm_group(self.group)
        if not self.sensitivity < 1.0:
            raise ValueError(
                f"{self.ultimate_strength:g} MPa is too much for the group {self.group!r}: its "
                f"mean stress sensitivity would be {self.sensitivity:g}, which must be below 1"
            )

    @property
    def numbers(self) -> FkmGroup:
        """The numbers of the group."""
        return fkm_group(self.group)

    @property
    def strength(self) -> float:
        """sigma_W, MPa."""
        return self.numbers.strength_ratio * self.ultimate_strength

    @property
    def sensitivity(self) -> float:
        """M_sigma; raises ValueError unless the ultimate strength is above 0 MPa."""
        return fkm_sensitivity(self.ultimate_strength, self.numbers.sensitivity)


@dataclass(frozen=True, eq=False)
class ComponentLimit:
    """The fully reversed local stress amplitude sigma_WK that a part endures, and its factors.

    limit          (n_points,) or a number, MPa: sigma_WK
    strength       MPa, sigma_W of the material
    support        n, (n_points,) or a number
    roughness      K_R, at most 1
    notch_factor   K_f~, at least 1
    sensitivity    M
    endures        True if the S-N curve is horizontal from 1e6 cycles on
    """

    limit: FloatArray
    strength: float
    support: FloatArray
    roughness: float
    notch_factor: float
    sensitivity: float
    endures: bool

    def __post_init__(self) -> None:
        product = self.strength / self.design_factor
        if self.limit.shape != product.shape or not np.allclose(self.limit, product, 1e-9, 0.0):
            raise ValueError("a component limit must be sigma_W / K_WK of its own factors")

    @property
    def design_factor(self) -> FloatArray:
        """K_WK, of the shape of the support number."""
        return np.asarray((1.0 + (1.0 / self.roughness - 1.0) / self.notch_factor) / self.support)

    def __float__(self) -> NoReturn:
        raise TypeError(
            "an FKM component limit cannot stand for an endurance limit of Marin's chain: use it "
            "with fkm_utilisation and fkm_curve"
        )


def component_limit(
    material: FkmMaterial, *, roughness: float, gradient: npt.ArrayLike = 0.0
) -> ComponentLimit:
    """Return sigma_WK of one point or of (n_points,).

    roughness     micrometres, Rz; CAST_ROUGHNESS for a skin left by rolling, forging or casting
    gradient      1/mm, related gradient of the local stress, for Stieler's support number
    """
    number = stieler_support(gradient, material.ultimate_strength, material.group)
    rough = roughness_factor(roughness, material.ultimate_strength, material.group)
    notch = material.numbers.surface_notch
    inverse = number / (1.0 + (1.0 / rough - 1.0) / notch)
    return ComponentLimit(
        limit=np.asarray(material.strength * inverse),
        strength=material.strength,
        support=number,
        roughness=rough,
        notch_factor=notch,
        sensitivity=material.sensitivity,
        endures=material.numbers.endures,
    )


def roughness_factor(roughness: float, ultimate_strength: float, group: str = "steel") -> float:
    """Return K_R of Rz in micrometres, at most 1: below 1 micrometre a surface counts as polished.

    FKM guideline, 6th ed., section 4.3.1.4.
    """
    own = fkm_group(group)
    if not (isfinite(roughness) and roughness >= 0.0):
        raise ValueError(f"the roughness Rz must be at least 0 micrometres, got {roughness:g}")
    depth = log10(max(roughness, 1.0))
    hardness = max(0.0, log10(2.0 * ultimate_strength / own.least_strength))
    factor = 1.0 - own.roughness * depth * hardness
    if not factor > 0.0:
        raise ValueError(
            f"a roughness Rz of {roughness:g} micrometres at {ultimate_strength:g} MPa leaves no "
            "strength: the roughness factor is beyond its data"
        )
    return factor


def fkm_utilisation(
    amplitude: npt.ArrayLike, mean: npt.ArrayLike, limit: ComponentLimit
) -> FloatArray:
    """Return sigma_a / sigma_AK of local stresses in MPa, at constant R (overload case F2).

    A compressive mean counts as 0, which the guideline would credit.
    """
    _check(limit)
    amplitude, mean = checked_cycles(amplitude, mean)
    growth = _fkm_growth(amplitude, np.maximum(mean, 0.0), limit.sensitivity)
    return np.asarray(amplitude * growth / limit.limit)


def fkm_sensitivity(ultimate_strength: float, group: str = "steel") -> float:
    """Return M = a_M Rm/1000 + b_M, not below 0, of one of FKM_SENSITIVITIES, for normal stress.

    >>> round(fkm_sensitivity(1200.0), 5)
    0.32
    """
    if not (isfinite(ultimate_strength) and ultimate_strength > 0.0):
        raise ValueError(f"the ultimate strength must be above 0 MPa, got {ultimate_strength:g}")
    if group not in FKM_SENSITIVITIES:
        raise ValueError(
            f"material group {group!r} is unknown; one of {', '.join(FKM_SENSITIVITIES)}"
        )
    slope, offset = FKM_SENSITIVITIES[group]
    return max(0.0, slope * ultimate_strength / 1000.0 + offset)


def fkm_factor(amplitude: npt.ArrayLike, mean: npt.ArrayLike, sensitivity: float) -> FloatArray:
    """Return K_AK: the amplitude endured at this stress ratio over that at R = -1.

    R > 1          1/(1 - M)
    R <= 0         1/(1 + M s_m/s_a)
    0 < R < 0.5    (1 + M/3)/(1 + M) / (1 + M/3 s_m/s_a)
    R >= 0.5       (3 + M)/(3 (1 + M)**2)

    FKM guideline, 6th ed., chapter 4.4, overload case F2 (constant R). The guideline credits
    compression, and so does this. Constant stress (s_a = 0) counts as R >= 0.5 in tension, R > 1
    in compression, and R = -1 at s_m = 0.
    """
    if not 0.0 <= sensitivity < 1.0:
        raise ValueError(
            f"the mean stress sensitivity must be at least 0 and below 1, got {sensitivity:g}"
        )
    amplitude, mean = checked_cycles(amplitude, mean)
    return np.asarray(1.0 / _fkm_growth(amplitude, mean, sensitivity))


def _fkm_growth(amplitude: FloatArray, mean: FloatArray, sensitivity: float) -> FloatArray:
    """Return 1/K_AK: one line up to s_m = s_a, then one with a third of its slope up to 3 s_a."""
    third = sensitivity / 3.0
    ratio = np.asarray(4.0 * np.sign(mean))  # constant stress: any ratio beyond 3 stands for it
    # a ratio that overflows is beyond 3 too
    with np.errstate(over="ignore"):
        np.divide(mean, amplitude, out=ratio, where=amplitude > 0.0)
    growth = 1.0 + sensitivity * np.clip(ratio, -1.0, 1.0)
    growth *= 1.0 + third * np.clip(ratio, 1.0, 3.0)
    return np.asarray(growth / (1.0 + third))


def fkm_curve(limit: ComponentLimit) -> SNCurve:
    """Return the component S-N curve of fully reversed local stress.

    Slope 5 to 1e6 cycles; horizontal from there, but for aluminium and austenite, which go on with
    15. The guideline makes theirs horizontal at 1e8 cycles; this one goes on.
    """
    _check(limit)
    below = float("inf") if limit.endures else _SLOPE_BELOW
    return SNCurve(limit.limit, KNEE_CYCLES, SLOPE, slope_below=below)


def _check(limit: ComponentLimit) -> None:
    if not isinstance(limit, ComponentLimit):
        raise TypeError(
            f"the FKM chain needs a ComponentLimit, got {type(limit).__name__}: Marin's endurance "
            "limit and the guideline's strength are never mixed"
        )


def stieler_support(
    gradient: npt.ArrayLike, ultimate_strength: float, group: str = "steel"
) -> FloatArray:
    """Return n >= 1 of related gradients, 1/mm, of any shape.

    G <= 0.1          1 + G 10**-(a_G - 0.5 + R_m/b_G)
    0.1 < G <= 1      1 + sqrt(G) 10**-(a_G + R_m/b_G)
    1 < G <= 100      1 + G**(1/4) 10**-(a_G + R_m/b_G)

    FKM guideline, 6th ed., section 4.3.1.3.1. NaN is refused with its place.

    >>> stieler_support([0.0, 0.5], 210.0, "grey_iron").round(3).tolist()
    [1.0, 1.682]
    """
    given = np.asarray(gradient, dtype=np.float64)
    refuse(np.isnan(given), "the related stress gradient is not a number", given, "point")
    related = np.clip(given, 0.0, STEEPEST)
    a, b = fkm_group(group).support
    reach = 10.0 ** -(a + ultimate_strength / b)
    root = np.where(related <= 1.0, np.sqrt(related), related**0.25)
    return np.asarray(1.0 + reach * np.where(related <= 0.1, related * 10.0**0.5, root))


# Numbers of the material groups.


@dataclass(frozen=True)
class FkmGroup:
    """One material group.

    strength_ratio   f_W,sigma: fully reversed strength in tension over the ultimate strength
    shear_ratio      f_W,tau: fully reversed strength in shear over that in tension
    roughness        a_R of the roughness factor
    least_strength   MPa, R_m,N,min of the roughness factor
    support          a_G and b_G (MPa) of Stieler's support number
    surface_notch    K_f~ of the design factor, table value
    sensitivity      the group of `FKM_SENSITIVITIES` that it belongs to
    endures          True if its S-N curve is horizontal from 1e6 cycles on
    """

    strength_ratio: float
    shear_ratio: float
    roughness: float
    least_strength: float
    support: tuple[float, float]
    surface_notch: float
    sensitivity: str
    endures: bool = True


FKM_GROUPS = {
    "steel": FkmGroup(0.45, 0.577, 0.22, 400.0, (0.5, 2700.0), 2.0, "steel"),
    "forged_steel": FkmGroup(0.40, 0.577, 0.22, 400.0, (0.5, 2700.0), 2.0, "steel"),
    "case_hardened_steel": FkmGroup(0.40, 0.577, 0.22, 400.0, (0.5, 2700.0), 2.0, "steel"),
    # austenite has no horizontal part of the curve at 1e6
    "stainless_steel": FkmGroup(
        0.40, 0.577, 0.22, 400.0, (0.4, 2400.0), 2.0, "steel", endures=False
    ),
    "cast_steel": FkmGroup(0.34, 0.577, 0.20, 400.0, (0.25, 2000.0), 2.0, "cast_steel"),
    "nodular_iron": FkmGroup(0.34, 0.65, 0.16, 400.0, (0.05, 3200.0), 1.5, "nodular_iron"),
    "malleable_iron": FkmGroup(0.30, 0.75, 0.12, 350.0, (-0.05, 3200.0), 1.2, "malleable_iron"),
    "grey_iron": FkmGroup(0.34, 1.0, 0.06, 100.0, (-0.05, 3200.0), 1.0, "grey_iron"),
    "wrought_aluminium": FkmGroup(
        0.30, 0.577, 0.22, 133.0, (0.05, 850.0), 2.0, "wrought_aluminium", endures=False
    ),
    "cast_aluminium": FkmGroup(
        0.30, 0.75, 0.20, 133.0, (-0.05, 3200.0), 1.2, "cast_aluminium", endures=False
    ),
}


def fkm_group(name: str) -> FkmGroup:
    """Return the numbers of a group; ValueError with the known names if there is none."""
    if name not in FKM_GROUPS:
        raise ValueError(f"material group {name!r} is unknown; one of {', '.join(FKM_GROUPS)}")
    return FKM_GROUPS[name]
