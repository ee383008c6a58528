"""Component strength by the FKM guideline: local stresses, parts that are not welded.

sigma_W   = f_W R_m                                       strength of the material, R = -1
K_R       = 1 - a_R lg(Rz) lg(2 R_m/R_m,N,min)            roughness, Rz in micrometres
K_WK      = (1 + (1/K_R - 1)/K_f~) / (n K_V K_S K_NL,E)   design factor
sigma_WK  = K_T,D sigma_W / K_WK                          strength of the part, R = -1
sigma_AK  = K_AK sigma_WK                                 at the mean stress, `fkm_factor`
a_BK      = sigma_a / sigma_AK                            utilisation

FKM guideline, 6th ed. (2012), chapter 4. R_m holds for the part at its size: take it from the
range of thickness of its standard, or lower it by the technological size factor. Strengths hold
for a survival of 97.5 %. Nothing here goes with Marin's factors (`marin`), which start from another
strength at 50 %; a `ComponentLimit` and an `EnduranceLimit` refuse each other's functions.

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

from fatigue.fkm_groups import FkmGroup, StressKind, fkm_group, fkm_temperature_factor, stress_ratio
from fatigue.mean_stress import MeanStressMaterial, fkm_sensitivity, mean_stress_utilisation
from fatigue.sn_curve import SNCurve
from fatigue.stress_path import FloatArray, refuse

STEEPEST = 100.0  # 1/mm, the end of Stieler's law; what is steeper counts as this

SURVIVAL = 0.975  # share of parts, of all FKM strengths
KNEE_CYCLES = 1e6
SLOPES = {"normal": 5.0, "shear": 8.0}  # of the component S-N curve, section 4.4.3
_SLOPES_BELOW = {"normal": 15.0, "shear": 25.0}  # of aluminium and austenite, to 1e8 cycles
CAST_ROUGHNESS = 200.0  # micrometres: rolling, forging and casting skin


@dataclass(frozen=True)
class FkmMaterial:
    """Material properties that the guideline asks for.

    ultimate_strength         MPa, R_m of the part at its size
    group                     one of FKM_GROUPS
    reversed_strength         MPa, sigma_W in tension where it was measured; None: f_W R_m
    mean_stress_sensitivity   M of normal stress; None: by the group's formula
    """

    ultimate_strength: float
    group: str = "steel"
    reversed_strength: float | None = None
    mean_stress_sensitivity: float | None = None

    def __post_init__(self) -> None:
        fkm_group(self.group)
        for name in ("ultimate_strength", "reversed_strength"):
            value = getattr(self, name)
            if value is not None and not (isfinite(value) and value > 0.0):
                raise ValueError(f"the {name.replace('_', ' ')} must be above 0 MPa, got {value:g}")
        sensitivity = self.mean_stress_sensitivity
        if sensitivity is not None and not 0.0 <= sensitivity < 1.0:
            raise ValueError(
                f"the mean stress sensitivity must be at least 0 and below 1, got {sensitivity:g}"
            )
        if not self.sensitivity() < 1.0:
            raise ValueError(
                f"{self.ultimate_strength:g} MPa is too much for the group {self.group!r}: its "
                f"mean stress sensitivity would be {self.sensitivity():g}, which must be below 1"
            )

    @property
    def numbers(self) -> FkmGroup:
        """The numbers of the group."""
        return fkm_group(self.group)

    def strength(self, stress: StressKind = "normal") -> float:
        """Return sigma_W or tau_W, MPa."""
        tension = self.reversed_strength
        if tension is None:
            tension = self.numbers.strength_ratio * self.ultimate_strength
        return tension * stress_ratio(self.numbers, stress)

    def sensitivity(self, stress: StressKind = "normal") -> float:
        """Return M_sigma, or M_tau = f_W,tau M_sigma."""
        own = self.mean_stress_sensitivity
        if own is None:
            own = fkm_sensitivity(self.ultimate_strength, self.numbers.sensitivity)
        return own * stress_ratio(self.numbers, stress)


@dataclass(frozen=True, eq=False)
class ComponentLimit:
    """The fully reversed local stress amplitude sigma_WK that a part endures, and its factors.

    limit          (n_points,) or a number, MPa: sigma_WK
    strength       MPa, sigma_W of the material
    support        n, (n_points,) or a number
    roughness      K_R, at most 1
    notch_factor   K_f~, at least 1
    treatment      K_V of a hardened surface layer, at least 1
    coating        K_S of a protective layer, at most 1
    nonlinearity   K_NL,E of grey iron in bending, at least 1
    temperature    K_T,D, at most 1
    sensitivity    M
    stress         "normal" or "shear"
    endures        True if the S-N curve is horizontal from 1e6 cycles on
    """

    limit: FloatArray
    strength: float
    support: FloatArray
    roughness: float
    notch_factor: float
    treatment: float
    coating: float
    nonlinearity: float
    temperature: float
    sensitivity: float
    stress: StressKind
    endures: bool

    def __post_init__(self) -> None:
        for name in ("roughness", "coating", "temperature"):
            if not 0.0 < getattr(self, name) <= 1.0:
                raise ValueError(
                    f"the {name} factor must be above 0 and at most 1, got {getattr(self, name):g}"
                )
        for name in ("notch_factor", "treatment", "nonlinearity"):
            if not (isfinite(getattr(self, name)) and getattr(self, name) >= 1.0):
                raise ValueError(
                    f"the {name.replace('_', ' ')} must be at least 1, got {getattr(self, name):g}"
                )
        bad = ~(np.isfinite(self.support) & (self.support > 0.0))
        refuse(bad, "the support number must be above 0", self.support, "point")
        product = self.temperature * self.strength / self.design_factor
        if self.limit.shape != product.shape or not np.allclose(self.limit, product, 1e-9, 0.0):
            raise ValueError("a component limit must be K_T,D sigma_W / K_WK of its own factors")

    @property
    def design_factor(self) -> FloatArray:
        """K_WK, of the shape of the support number."""
        rough = 1.0 + (1.0 / self.roughness - 1.0) / self.notch_factor
        layers = self.treatment * self.coating * self.nonlinearity
        return np.asarray(rough / (self.support * layers))

    def __float__(self) -> NoReturn:
        raise TypeError(
            "an FKM component limit cannot stand for an endurance limit of Marin's chain: use it "
            "with fkm_utilisation and fkm_curve"
        )


def component_limit(
    material: FkmMaterial,
    *,
    roughness: float,
    gradient: npt.ArrayLike | None = None,
    support: npt.ArrayLike | None = None,
    stress: StressKind = "normal",
    notch_factor: float | None = None,
    treatment: float = 1.0,
    coating: float = 1.0,
    nonlinearity: float = 1.0,
    temperature: float = 20.0,
) -> ComponentLimit:
    """Return sigma_WK of one point or of (n_points,).

    roughness     micrometres, Rz; CAST_ROUGHNESS for a skin left by rolling, forging or casting
    gradient      1/mm, related gradient of the local stress, for Stieler's support number; or
    support       that number from elsewhere; neither: 1
    notch_factor  K_f~, None for the group's table value
    treatment     K_V, stated by the user: it depends on the process, the layer, notch and size
    temperature   deg C
    """
    if gradient is not None and support is not None:
        raise ValueError(
            "either the related gradient or the support number must be given, not both"
        )
    if gradient is not None:
        number = stieler_support(gradient, material.ultimate_strength, material.group, stress)
    else:
        number = np.asarray(1.0 if support is None else support, dtype=np.float64)
    strength = material.strength(stress)
    heat = fkm_temperature_factor(temperature, material.group)
    rough = roughness_factor(roughness, material.ultimate_strength, material.group, stress)
    table = material.numbers.surface_notch
    notch = table if notch_factor is None else notch_factor
    inverse = number * treatment * coating * nonlinearity / (1.0 + (1.0 / rough - 1.0) / notch)
    return ComponentLimit(
        limit=np.asarray(heat * strength * inverse),
        strength=strength,
        support=number,
        roughness=rough,
        notch_factor=notch,
        treatment=treatment,
        coating=coating,
        nonlinearity=nonlinearity,
        temperature=heat,
        sensitivity=material.sensitivity(stress),
        stress=stress,
        endures=material.numbers.endures,
    )


def roughness_factor(
    roughness: float, ultimate_strength: float, group: str = "steel", stress: StressKind = "normal"
) -> float:
    """Return K_R of Rz in micrometres, at most 1: below 1 micrometre a surface counts as polished.

    FKM guideline, 6th ed., section 4.3.1.4; in shear a_R is multiplied by f_W,tau.
    """
    own = fkm_group(group)
    if not (isfinite(roughness) and roughness >= 0.0):
        raise ValueError(f"the roughness Rz must be at least 0 micrometres, got {roughness:g}")
    if not (isfinite(ultimate_strength) and ultimate_strength > 0.0):
        raise ValueError(f"the ultimate strength must be above 0 MPa, got {ultimate_strength:g}")
    depth = log10(max(roughness, 1.0))
    hardness = max(0.0, log10(2.0 * ultimate_strength / own.least_strength))
    factor = 1.0 - own.roughness * stress_ratio(own, stress) * depth * hardness
    if not factor > 0.0:
        raise ValueError(
            f"a roughness Rz of {roughness:g} micrometres at {ultimate_strength:g} MPa leaves no "
            "strength: the roughness factor is beyond its data"
        )
    return factor


def fkm_utilisation(
    amplitude: npt.ArrayLike,
    mean: npt.ArrayLike,
    limit: ComponentLimit,
    *,
    credit: bool = False,
) -> FloatArray:
    """Return sigma_a / sigma_AK of local stresses in MPa, at constant R (overload case F2).

    A compressive mean counts as 0; with `credit` it helps as the guideline allows.
    """
    _check(limit)
    material = MeanStressMaterial(1.0, 1.0, mean_stress_sensitivity=limit.sensitivity)
    return mean_stress_utilisation(amplitude, mean, limit.limit, material, "fkm", credit=credit)


def fkm_curve(limit: ComponentLimit) -> SNCurve:
    """Return the component S-N curve of fully reversed local stress.

    Slope 5 (8 in shear) to 1e6 cycles; horizontal from there, but for aluminium and austenite,
    which go on with 15 (25). The guideline makes theirs horizontal at 1e8 cycles; this one goes on.
    """
    _check(limit)
    below = float("inf") if limit.endures else _SLOPES_BELOW[limit.stress]
    slope = SLOPES[limit.stress]
    return SNCurve(limit.limit, KNEE_CYCLES, slope, slope_below=below, survival=SURVIVAL)


def _check(limit: ComponentLimit) -> None:
    if not isinstance(limit, ComponentLimit):
        raise TypeError(
            f"the FKM chain needs a ComponentLimit, got {type(limit).__name__}: Marin's endurance "
            "limit and the guideline's strength are never mixed"
        )


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
