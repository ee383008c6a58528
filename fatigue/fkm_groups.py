"""Numbers of the FKM guideline for its material groups: ratios, roughness, support, temperature.

FKM guideline, Analytical Strength Assessment of Components, 6th ed. (2012), chapter 4: tables
4.2.1 (strength ratios) and 4.3.1 to 4.3.5, section 4.2.3 (temperature). The values are those of
pyLife's module `fkm_linear`, not compared with the printed tables.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Literal, get_args

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
