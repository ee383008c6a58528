"""Mean-stress effect by eight rules side by side: Goodman is the verdict, the others a band.

s_a is the amplitude (half the range), s_m the mean, S_e the endurance limit at s_m = 0. Each rule
gives the fully reversed amplitude s_ar that does the same damage, and, with s_ar = S_e, the line
between enduring and failing:

goodman        s_ar = s_a / (1 - s_m/S_u)                    Shigley, 9th ed., eq. (6-46)
soderberg      s_ar = s_a / (1 - s_m/S_y)                    eq. (6-45)
gerber         s_ar = s_a / (1 - (s_m/S_u)**2)               eq. (6-47)
asme_elliptic  s_ar = s_a / sqrt(1 - (s_m/S_y)**2)           eq. (6-48)
morrow         s_ar = s_a / (1 - s_m/s_f')                   Dowling, Mechanical Behavior of
swt            s_ar = sqrt((s_a + s_m) s_a)                  Materials, 4th ed., section 9.7
walker         s_ar = (s_a + s_m)**(1 - gamma) s_a**gamma
fkm            s_ar = s_a / K_AK, see `fkm_factor`           FKM guideline, 6th ed., chapter 4.4

Where the mean reaches the strength of its rule nothing is endured: s_ar is infinite, with any s_a.

**Compression** earns no credit: a mean below 0 counts as 0. With `credit` the rules that hold for
compression (all but gerber and asme_elliptic, which are even in s_m) say what it would be.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from fatigue.stress_path import FloatArray, refuse

Rule = Literal["goodman", "gerber", "soderberg", "asme_elliptic", "morrow", "walker", "swt", "fkm"]
RULES: tuple[Rule, ...] = get_args(Rule)

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
class MeanStressMaterial:
    """Material properties that the mean-stress rules ask for.

    ultimate_strength, yield_strength   MPa
    fracture_strength   MPa, s_f' of morrow: true fracture strength or fatigue strength coefficient
    walker_exponent     gamma of walker, above 0 and at most 1; smaller is more sensitive to mean
    mean_stress_sensitivity   M of fkm, not below 0, see `fkm_sensitivity`

    A rule whose number is None cannot be used, and is missing from `mean_stress_band`.
    """

    ultimate_strength: float
    yield_strength: float
    fracture_strength: float | None = None
    walker_exponent: float | None = None
    mean_stress_sensitivity: float | None = None

    def __post_init__(self) -> None:
        for name in ("ultimate_strength", "yield_strength", "fracture_strength"):
            value = getattr(self, name)
            if value is not None and not (isfinite(value) and value > 0.0):
                raise ValueError(f"the {name.replace('_', ' ')} must be above 0 MPa, got {value:g}")
        gamma, sensitivity = self.walker_exponent, self.mean_stress_sensitivity
        if gamma is not None and not 0.0 < gamma <= 1.0:
            raise ValueError(f"Walker's exponent must be above 0 and at most 1, got {gamma:g}")
        if sensitivity is not None and not 0.0 <= sensitivity < 1.0:
            raise ValueError(
                f"the mean stress sensitivity must be at least 0 and below 1, got {sensitivity:g}"
            )

    def number(self, rule: Rule) -> float:
        """Return the one number that a rule needs: a strength in MPa, an exponent, or M."""
        numbers: dict[Rule, tuple[str, float | None]] = {
            "goodman": ("ultimate strength", self.ultimate_strength),
            "gerber": ("ultimate strength", self.ultimate_strength),
            "soderberg": ("yield strength", self.yield_strength),
            "asme_elliptic": ("yield strength", self.yield_strength),
            "morrow": ("fracture strength", self.fracture_strength),
            "walker": ("Walker exponent", self.walker_exponent),
            "swt": ("Walker exponent", 0.5),  # SWT is Walker's rule with this exponent
            "fkm": ("mean stress sensitivity", self.mean_stress_sensitivity),
        }
        if rule not in numbers:
            raise ValueError(f"mean stress rule {rule!r} is unknown; one of {', '.join(RULES)}")
        what, value = numbers[rule]
        if value is None:
            raise ValueError(f"the mean stress rule {rule!r} needs the material's {what}")
        return value


def equivalent_amplitude(
    amplitude: npt.ArrayLike,
    mean: npt.ArrayLike,
    material: MeanStressMaterial,
    rule: Rule = "goodman",
    *,
    credit: bool = False,
) -> FloatArray:
    """Return s_ar, MPa: the fully reversed amplitude that does the same damage, of any shape.

    >>> steel = MeanStressMaterial(ultimate_strength=800.0, yield_strength=600.0)
    >>> equivalent_amplitude(100.0, [0.0, 200.0, -50.0], steel).round(2).tolist()
    [100.0, 133.33, 100.0]
    """
    amplitude, mean = _stresses(amplitude, mean, credit)
    number = material.number(rule)
    if rule in ("walker", "swt"):
        peak = np.maximum(amplitude + mean, 0.0)
        if rule == "swt":
            return np.asarray(np.sqrt(peak) * np.sqrt(amplitude))
        return np.asarray(peak ** (1.0 - number) * amplitude**number)
    if rule == "fkm":
        return _fkm_equivalent(amplitude, mean, number)
    share = mean / number
    if rule in ("gerber", "asme_elliptic"):
        share = np.maximum(share, 0.0) ** 2
    left = 1.0 - share
    if rule == "asme_elliptic":
        left = np.sqrt(np.maximum(left, 0.0))
    reversed_amplitude = np.full(amplitude.shape, np.inf)
    np.divide(amplitude, left, out=reversed_amplitude, where=left > 0.0)
    return reversed_amplitude


def mean_stress_utilisation(
    amplitude: npt.ArrayLike,
    mean: npt.ArrayLike,
    endurance_limit: npt.ArrayLike,
    material: MeanStressMaterial,
    rule: Rule = "goodman",
    *,
    credit: bool = False,
) -> FloatArray:
    """Return demand over capacity when amplitude and mean grow together (radial load line).

    Its reciprocal is the factor on both that reaches the line of the rule: for Gerber the root of
    n s_a/S_e + (n s_m/S_u)**2 = 1 (Shigley, 9th ed., table 6-7). FKM calls it overload case F2.
    `endurance_limit` in MPa, of any shape that goes with the stresses. Never negative.
    """
    amplitude, mean = _stresses(amplitude, mean, credit)
    limit = _limit(endurance_limit)
    number = material.number(rule)
    if rule in ("walker", "swt", "fkm"):
        reversed_amplitude = equivalent_amplitude(amplitude, mean, material, rule, credit=True)
        return np.asarray(reversed_amplitude / limit)
    demand, share = amplitude / limit, mean / number
    if rule == "gerber":
        share = np.maximum(share, 0.0)
        return np.asarray((demand + np.hypot(demand, 2.0 * share)) / 2.0)
    if rule == "asme_elliptic":
        return np.asarray(np.hypot(demand, np.maximum(share, 0.0)))
    return np.asarray(np.maximum(demand + share, 0.0))


def mean_stress_band(
    amplitude: npt.ArrayLike,
    mean: npt.ArrayLike,
    endurance_limit: npt.ArrayLike,
    material: MeanStressMaterial,
    *,
    credit: bool = False,
) -> dict[Rule, FloatArray]:
    """Return the radial utilisation by every rule that the material's data allow."""
    missing = {
        "morrow": material.fracture_strength is None,
        "walker": material.walker_exponent is None,
        "fkm": material.mean_stress_sensitivity is None,
    }
    return {
        rule: mean_stress_utilisation(
            amplitude, mean, endurance_limit, material, rule, credit=credit
        )
        for rule in RULES
        if not missing.get(rule, False)
    }


def yield_utilisation(
    amplitude: npt.ArrayLike, mean: npt.ArrayLike, yield_strength: float
) -> FloatArray:
    """Return (s_a + |s_m|) / S_y: above 1 the first cycle yields, in tension or compression.

    Langer's line; Shigley, 9th ed., eq. (6-49).
    """
    _strength(yield_strength, "yield strength")
    amplitude, mean = _stresses(amplitude, mean, credit=True)
    return np.asarray((amplitude + np.abs(mean)) / yield_strength)


def fkm_sensitivity(ultimate_strength: float, group: str = "steel") -> float:
    """Return M = a_M Rm/1000 + b_M, not below 0, of one of FKM_SENSITIVITIES, for normal stress.

    >>> round(fkm_sensitivity(1200.0), 5)
    0.32
    """
    _strength(ultimate_strength, "ultimate strength")
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
    amplitude, mean = _stresses(amplitude, mean, credit=True)
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


def _fkm_equivalent(amplitude: FloatArray, mean: FloatArray, sensitivity: float) -> FloatArray:
    return np.asarray(amplitude * _fkm_growth(amplitude, mean, sensitivity))


def _stresses(
    amplitude: npt.ArrayLike, mean: npt.ArrayLike, credit: bool
) -> tuple[FloatArray, FloatArray]:
    """Return both as floats of one shape, the mean not below 0 unless compression has credit."""
    amplitude = np.asarray(amplitude, dtype=np.float64)
    mean = np.asarray(mean, dtype=np.float64)
    refuse(~np.isfinite(amplitude), "the amplitude is not finite", amplitude)
    refuse(~np.isfinite(mean), "the mean stress is not finite", mean)
    refuse(amplitude < 0.0, "the amplitude, half the range, is below 0 MPa", amplitude)
    amplitude, mean = np.broadcast_arrays(amplitude, mean if credit else np.maximum(mean, 0.0))
    return amplitude, mean


def _limit(endurance_limit: npt.ArrayLike) -> FloatArray:
    limit = np.asarray(endurance_limit, dtype=np.float64)
    bad = ~(np.isfinite(limit) & (limit > 0.0))
    refuse(bad, "the endurance limit must be above 0 MPa", limit, "point")
    return limit


def _strength(value: float, what: str) -> None:
    if not (isfinite(value) and value > 0.0):
        raise ValueError(f"the {what} must be above 0 MPa, got {value:g}")
