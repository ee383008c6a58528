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

Numbers of the material groups: tables 4.2.1 (strength ratios) and 4.3.1 to 4.3.5, section 4.2.3
(temperature). Their values are those of pyLife's module `fkm_linear`, not compared with the printed
tables.

A notch endures more than its peak says. FKM takes the local stress and divides its demand by a
support number n >= 1 that depends on the related stress gradient G (1/mm) at the surface.

G = -(d sigma/dn)/sigma along the inward normal n: 2/h of a beam in bending (height h), 2/d of a
round bar in torsion, 7/(3 r) of the hoop stress beside a hole in a sheet. Negative where the stress
grows inwards; there nothing is supported.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, log10
from typing import Literal, NoReturn, get_args

import numpy as np
import numpy.typing as npt

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


# Numbers of the material groups.

StressKind = Literal["normal", "shear"]


@dataclass(frozen=True)
class TemperatureLaw:
    """K_T,D = 1 - slope ((T - offset)/1000)**power of T in deg C, above `start`, up to `end`."""

    start: float
    end: float
    slope: float = 0.0
    offset: float = 0.0
    power: int = 1


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
    weibull          k_st of the statistical support number
    temperature      of the fatigue strength
    endures          True if its S-N curve is horizontal from 1e6 cycles on
    """

    strength_ratio: float
    shear_ratio: float
    roughness: float
    least_strength: float
    support: tuple[float, float]
    surface_notch: float
    sensitivity: str
    weibull: float
    temperature: TemperatureLaw
    endures: bool = True


_STEEL_HEAT = TemperatureLaw(100.0, 500.0, 1.4, 100.0)
_ALUMINIUM_HEAT = TemperatureLaw(50.0, 200.0, 1.2, 50.0)

FKM_GROUPS = {
    "steel": FkmGroup(0.45, 0.577, 0.22, 400.0, (0.5, 2700.0), 2.0, "steel", 30.0, _STEEL_HEAT),
    "forged_steel": FkmGroup(
        0.40, 0.577, 0.22, 400.0, (0.5, 2700.0), 2.0, "steel", 30.0, _STEEL_HEAT
    ),
    "case_hardened_steel": FkmGroup(
        0.40, 0.577, 0.22, 400.0, (0.5, 2700.0), 2.0, "steel", 30.0, _STEEL_HEAT
    ),
    # no temperature factor is known; austenite has no horizontal part of the curve at 1e6
    "stainless_steel": FkmGroup(
        0.40,
        0.577,
        0.22,
        400.0,
        (0.4, 2400.0),
        2.0,
        "steel",
        30.0,
        TemperatureLaw(100.0, 100.0),
        endures=False,
    ),
    "cast_steel": FkmGroup(
        0.34,
        0.577,
        0.20,
        400.0,
        (0.25, 2000.0),
        2.0,
        "cast_steel",
        15.0,
        TemperatureLaw(100.0, 500.0, 1.2, 100.0),
    ),
    "nodular_iron": FkmGroup(
        0.34,
        0.65,
        0.16,
        400.0,
        (0.05, 3200.0),
        1.5,
        "nodular_iron",
        10.0,
        TemperatureLaw(100.0, 500.0, 1.6, power=2),
    ),
    "malleable_iron": FkmGroup(
        0.30,
        0.75,
        0.12,
        350.0,
        (-0.05, 3200.0),
        1.2,
        "malleable_iron",
        10.0,
        TemperatureLaw(100.0, 500.0, 1.3, power=2),
    ),
    "grey_iron": FkmGroup(
        0.34,
        1.0,
        0.06,
        100.0,
        (-0.05, 3200.0),
        1.0,
        "grey_iron",
        10.0,
        TemperatureLaw(100.0, 500.0, 1.0, power=2),
    ),
    "wrought_aluminium": FkmGroup(
        0.30,
        0.577,
        0.22,
        133.0,
        (0.05, 850.0),
        2.0,
        "wrought_aluminium",
        20.0,
        _ALUMINIUM_HEAT,
        endures=False,
    ),
    "cast_aluminium": FkmGroup(
        0.30,
        0.75,
        0.20,
        133.0,
        (-0.05, 3200.0),
        1.2,
        "cast_aluminium",
        10.0,
        _ALUMINIUM_HEAT,
        endures=False,
    ),
}


def fkm_group(name: str) -> FkmGroup:
    """Return the numbers of a group; ValueError with the known names if there is none."""
    if name not in FKM_GROUPS:
        raise ValueError(f"material group {name!r} is unknown; one of {', '.join(FKM_GROUPS)}")
    return FKM_GROUPS[name]


def stress_ratio(group: FkmGroup, stress: StressKind) -> float:
    """Return 1 for normal stress, f_W,tau for shear stress."""
    if stress not in get_args(StressKind):
        raise ValueError(f"stress {stress!r} is unknown; one of {', '.join(get_args(StressKind))}")
    return group.shear_ratio if stress == "shear" else 1.0


def fkm_temperature_factor(temperature: float, group: str = "steel") -> float:
    """Return K_T,D of a temperature in deg C; beyond the data of the group it is refused.

    Steel, for one, has 1 - 1.4e-3 (T - 100) from 100 to 500 deg C (not for fine-grained steels,
    which lose from 60 deg C on).
    """
    law = fkm_group(group).temperature
    if not (isfinite(temperature) and -273.15 <= temperature <= law.end):
        raise ValueError(
            f"the temperature of {group} must lie between -273.15 and {law.end:g} deg C, the end "
            f"of the FKM temperature factor's data, got {temperature:g} deg C"
        )
    if temperature <= law.start:
        return 1.0
    return float(1.0 - law.slope * ((temperature - law.offset) / 1000.0) ** law.power)
