"""Words that only the page has: reach of bars, worth of a pass, meaning of a place."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite

from checks.result.verdict import Check, DesignResult, Gate, PartResult, Status
from checks.result.words import bar_words, number, utilisation_text, value_and_bars

LOADS_IN_DOUBT = "loads not valid"
PART_IN_DOUBT = "a validity check of the part does not hold"
NO_BAR = "no error bar stated"
_NOISE = 1e-3  # of the value: a bar that reaches less far is not written
_PLACE = re.compile(r"\(-?[\d.]+, -?[\d.]+, (-?[\d.]+)\)")


@dataclass(frozen=True)
class RungBeside:
    """Number of a cheaper model beside the number of the model that decided, each as text."""

    quantity: str
    cheap: str
    decided: str
    unit: str
    ratio: str
    model: str


def without_noise(check: Check) -> Check:
    """The check with bars of 0 where they reach less than a thousandth of its value."""
    least = _NOISE * check.value

    def kept(bar: float) -> float:
        return bar if bar >= least else 0.0

    return replace(
        check,
        numerical=kept(check.numerical),
        model=kept(check.model),
        model_below=kept(check.below),
    )


def page_bars(check: Check) -> str:
    """The error bars in words; what is below a thousandth of the value counts as 0.

    A bar of exactly 0 is one that nobody stated, so it is not written as a number.
    """
    if not (check.numerical or check.model or check.below):
        return NO_BAR
    found = without_noise(check)
    if not (found.numerical or found.model or found.below):
        return "±0 (below 0.1 % of the value)"
    return bar_words(found)


def upper_utilisation(check: Check) -> float | None:
    """Utilisation at the upper end of the bars; None where it is as good as the value's own."""
    bars = check.numerical + check.model
    if bars < _NOISE * check.value or not bars:
        return None
    return check.upper * check.required / check.limit


def reach_words(check: Check) -> str:
    """Utilisation at the upper end of its bars; "" where that reads like the utilisation itself."""
    upper = upper_utilisation(check)
    if upper is None:
        return ""
    if not isfinite(upper):
        return "no upper end"
    written = utilisation_text(upper)
    return "" if written == utilisation_text(check.utilisation) else f"up to {written}"


def doubt_of(check: Check, result: DesignResult) -> str:
    """Doubt about a pass that rests on a broken gate, in a few words; "" without doubt or pass."""
    if check.status is not Status.PASS:
        return ""
    if _binding(result.gates):
        return LOADS_IN_DOUBT
    part = next((part for part in result.parts if part.name == check.part), None)
    return PART_IN_DOUBT if part is not None and _binding(part.gates) else ""


def _binding(gates: Sequence[Gate]) -> list[Gate]:
    return [gate for gate in gates if gate.binding and not gate.holds]


def capitalise(text: str) -> str:
    """A text with a capital at its beginning."""
    return text[:1].upper() + text[1:]


def mirrored(check: Check, part: PartResult | None) -> str:
    """The place of a check that was found on a half, as it is on the other half; else ""."""
    if part is None or not part.meshes or part.meshes[-1].get("body") != "half":
        return ""
    found = _PLACE.search(check.place)
    if found is None or check.method != "solid" or not float(found[1]):
        return ""
    height = f"{-float(found[1]):g}".replace("-", "\N{MINUS SIGN}")
    return f"and its mirror image at z = {height} mm"


def has_place(check: Check) -> bool:
    """Return True if the place of a check has coordinates."""
    return _PLACE.search(check.place) is not None


def swings(check: Check) -> bool:
    """Return True if a check is of the swing between two positions, as for fatigue, not of one."""
    return check.kind == "fatigue"


def rungs_beside(part: PartResult) -> list[RungBeside]:
    """The formulas' numbers beside those of the solid that decided."""
    formula = next((rung for rung in part.rungs if rung.rung == "formula"), None)
    if formula is None:
        return []
    found = []
    for check in part.checks:
        if check.method != "solid":
            continue
        same = [c for c in formula.checks if (c.kind, c.quantity) == (check.kind, check.quantity)]
        if len(same) == 1 and same[0].unit == check.unit:
            found.append(_beside(check, same[0]))
    return found


def _beside(check: Check, cheap: Check) -> RungBeside:
    return RungBeside(
        quantity=f"{check.kind}: {check.quantity}",
        cheap=_with_bars(cheap),
        decided=_with_bars(check),
        unit=check.unit,
        ratio=number(check.value / cheap.value) if cheap.value else "–",
        model=check.method,
    )


def _with_bars(check: Check) -> str:
    """A value with its bars, as "199 +21 −27 model"."""
    bars = page_bars(check)
    return f"{value_and_bars(without_noise(check))[0]} {'' if bars == NO_BAR else bars}".strip()
