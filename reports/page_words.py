"""Words that only the page has: reach of bars, worth of a pass, meaning of a place."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

from checks.result.verdict import Check, DesignResult, Gate, PartResult, Status
from checks.result.words import (
    bar_words,
    brief,
    check_titles,
    need_text,
    number,
    safety_text,
    utilisation_text,
    value_and_bars,
)

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


Place = tuple[int, int, int]  # cycle, position in it, part, -1: the linkage; by their numbers

# Field of the live view that a check is judged by, by its kind and unit; of others the stress.
JUDGED_BY = {("fatigue", "MPa"): "utilisation", ("buckling", "MPa"): "column"}
STATIC = "static"
_AT = re.compile(r"\((-?[\d.]+), (-?[\d.]+), (-?[\d.]+)\)$")


def shown_of(check: Check, result: DesignResult) -> dict[str, Any]:
    """The view of a check: part, field and place, as the page's script takes it.

    part      number of its part, -1: the whole linkage
    position  [cycle, position in it], None where it is not known
    field     of the live view; mode: whether it is shown as it buckles
    at        [x, y, z] mm in the part's own axes, None where the place has no coordinates
    told      the check with its safety, in words; short: without its part
    """
    place = place_of(check, result)
    found = _AT.search(check.place)
    titles = dict(zip(map(id, result.checks), check_titles(result.checks), strict=True))
    part = _part(check, result)
    needed = need_text(check.required)
    safety = f"safety {safety_text(check.safety, check.required)}, {needed} required"
    return {
        "part": -1 if part is None else part,
        "position": None if place is None else list(place[:2]),
        "mode": check.kind == "buckling",
        "field": JUDGED_BY.get((check.kind, check.unit), STATIC),
        "at": None if found is None else [float(value) for value in found.groups()],
        "told": f"{brief(check.part, 40)} {brief(titles[id(check)], 60)}: {safety}",
        "short": f"{brief(check.kind, 40)}: {safety}",
    }


def deciding_place(result: DesignResult) -> Place | None:
    """Where the check that decides the verdict is decided, else its part's peak in its cycle.

    None without checks, and where neither is known.
    """
    if not result.checks:
        return None
    decides = result.deciding
    return place_of(decides, result) or _peak(decides, result)


def place_of(check: Check, result: DesignResult) -> Place | None:
    """Governing place of a check: its load case, else for a static check its part's peak.

    Of the two ends of a swing the one that stresses the part more. None where that is not known,
    as for a check of the linkage as a whole whose motion is not.
    """
    part = _part(check, result)
    if check.cycle not in result.cycles:
        return None
    names = list(result.cycles)
    cases = () if check.derivation is None else check.derivation.cases
    places = [(names.index(case.cycle), case.index) for case in cases if case.cycle in names]
    if part is None:
        return (*places[0], -1) if places and result.motion else None
    if places:
        peaks = [result.cycles[names[k]].get("peaks") or {} for k, _ in places]
        stress = [
            float(each[check.part][index]) if check.part in each else 0.0
            for each, (_, index) in zip(peaks, places, strict=True)
        ]
        return *places[stress.index(max(stress))], part
    return _peak(check, result) if check.kind == "static" else None


def _part(check: Check, result: DesignResult) -> int | None:
    return next((k for k, each in enumerate(result.parts) if each.name == check.part), None)


def _peak(check: Check, result: DesignResult) -> Place | None:
    """Where the part of a check has its largest stress in the cycle of the check."""
    part = _part(check, result)
    peaks = (result.cycles.get(check.cycle, {}).get("peaks") or {}).get(check.part)
    if part is None or peaks is None or not len(peaks):
        return None
    position = max(range(len(peaks)), key=lambda k: float(peaks[k]))
    return list(result.cycles).index(check.cycle), position, part
