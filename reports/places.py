"""Governing places: cycle, position and part that decide a check, which the page shows first."""

import re
from typing import Any

from checks.result.verdict import Check, DesignResult
from checks.result.words import brief, check_titles, need_text, safety_text

Place = tuple[int, int, int]  # cycle, position in it, part, -1: the linkage; by their numbers

# Field of the live view that a check is judged by, by its kind and unit; of others the stress.
_FIELDS = {("fatigue", "MPa"): "utilisation", ("buckling", "MPa"): "column"}
_STRESS = "static"
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
        "field": _FIELDS.get((check.kind, check.unit), _STRESS),
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
