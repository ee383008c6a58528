"""Words that only the page has: reach of bars, worth of a pass, meaning of a place."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite

from checks.result.verdict import Check, DesignResult, Gate, PartResult, Status
from checks.result.words import (
    bar_words,
    brief,
    check_titles,
    headline,
    number,
    utilisation_text,
    value_and_bars,
)

LOADS_IN_DOUBT = "loads not valid"
PART_IN_DOUBT = "a gate of the part is broken"
NO_BAR = "no error bar stated"
_NAMED = 3  # failing checks in the headline
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


def page_headline(result: DesignResult) -> tuple[str, str]:
    """The headline, and what it leaves out: what fails, or may; passes in doubt."""
    over, more = _over(result), []
    failing = _failing(result)
    if len(failing) > 1:  # of one alone the card tells everything
        more.append(f"Failing: {', '.join(failing)}.")
    elif over is not None and not failing:
        check, title = over
        share = 100.0 * (check.utilisation - 1.0)
        by = f"{share:{'.0f' if share >= 10 else '.2g'}} %" if share >= 0.1 else "up to 0.1 %"
        named = f"{brief(check.part, 40)} {brief(title, 40)}"
        more.append(
            f"The best estimate of {named} is {by} over what is allowed; within its error bars it "
            "may hold."
        )
    broken = _binding(result.gates)
    if broken and any(check.status is Status.PASS for check in result.checks):
        more.append(f"A pass below is not proven: the loads are not valid ({_kinds(broken)}).")
    return headline(result, doubted=over is not None), " ".join(more)


def _failing(result: DesignResult) -> list[str]:
    """The checks that fail, the worst first, with their utilisation; three and how many more."""
    titled = zip(result.checks, check_titles(result.checks), strict=True)
    failed = [(check, title) for check, title in titled if check.status is Status.FAIL]
    failed.sort(key=lambda pair: -pair[0].utilisation)
    told = [
        f"{brief(check.part, 40)} {brief(title, 40)} at {utilisation_text(check.utilisation)}"
        for check, title in failed[:_NAMED]
    ]
    left = len(failed) - len(told)
    return [*told, f"{left} more"] if left else told


def _over(result: DesignResult) -> tuple[Check, str] | None:
    """The undecided check whose estimate is furthest over what is allowed, with its title."""
    titled = zip(result.checks, check_titles(result.checks), strict=True)
    open_ = [
        (check, title)
        for check, title in titled
        if check.status is Status.UNDECIDED and check.utilisation > 1.0
    ]
    return max(open_, key=lambda pair: pair[0].utilisation, default=None)


def _kinds(gates: Sequence[Gate]) -> str:
    """Quantities that the gates measure, each kind once, without the cycle."""
    kinds = dict.fromkeys(gate.name.partition(": ")[2] or gate.name for gate in gates)
    shown = [brief(kind, 50) for kind in list(kinds)[:3]]
    return ", ".join([*shown, *(["more"] if len(kinds) > len(shown) else [])])


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
