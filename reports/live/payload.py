"""The live view's data of a whole design: a header, a block of text per part, and the motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from checks.result.live_fields import (
    EncodedPart,
    LiveFields,
    grey,
    von_mises,
    with_required_safety,
)
from checks.result.motion import PartsMotion
from checks.result.verdict import Check, DesignResult, PartResult, Surface, deciding_of
from reports.live.encode import TOLERANCE, encode
from reports.page_words import FIELDS, STATIC
from reports.templating import packed_json, series

FORMAT = "ballesta-live/1"
SHARES = {"static": "allowed", "column": "column"}  # field -> limit that it is a share of


@dataclass(frozen=True)
class Budget:
    """Budget of text for the live view of a page.

    coarse     characters, above which the tolerance is raised
    most       characters, above which the largest parts are shown without fields
    tolerance  of a cycle's peak, when raised
    """

    coarse: int = 20_000_000
    most: int = 40_000_000
    tolerance: float = 5e-3


BUDGET = Budget()


@dataclass(frozen=True, eq=False)
class LivePayload:
    """Data that a page carries for its live view.

    header  plain data; viewer.js says what stands in it
    blocks  id and text of each block, base64
    """

    header: Mapping[str, Any]
    blocks: Sequence[tuple[str, str]]


def live_payload(result: DesignResult, budget: Budget = BUDGET) -> LivePayload:
    """Return the payload of a result's page; the same result gives the same payload.

    A part whose fields nobody has asked for is its bare surface.
    """
    parts: list[dict[str, Any]] = []
    blocks = []
    for number, part in enumerate(with_encoded_fields(result, budget).parts):
        assert isinstance(part.live, EncodedPart)
        head = dict(part.live.head)
        block = f"live-part-{number}"
        head["limits"] = {**_limits(part), **head["limits"]}
        parts.append({"name": part.name, "block": block, **_with_shares(head)})
        blocks.append((block, part.live.text))
    return LivePayload({"format": FORMAT, "parts": parts}, blocks)


def with_encoded_fields(result: DesignResult, budget: Budget = BUDGET) -> DesignResult:
    """The result with the fields of its parts as a page carries them, a hundredth of their size."""
    if all(isinstance(part.live, EncodedPart) for part in result.parts):
        return result
    cycles = list(result.cycles)
    fields = [_fields_of(part) for part in result.parts]
    encoded = [live if isinstance(live, EncodedPart) else encode(live, cycles) for live in fields]
    if _size(encoded) > budget.coarse:
        encoded = [
            _coarser(live, before, cycles, budget)
            for live, before in zip(fields, encoded, strict=True)
        ]
    while _size(encoded) > budget.most:
        largest = max(range(len(encoded)), key=lambda k: (_weight(encoded[k]), -k))
        if not encoded[largest].head["fields"]:
            break
        encoded[largest] = encode(_bare(result.parts[largest], encoded, budget), cycles)
    parts = [
        replace(part, live=replace(live, estimate=estimate_of(part)))
        for part, live in zip(result.parts, encoded, strict=True)
    ]
    return replace(result, parts=parts)


def without_fields(result: DesignResult) -> DesignResult:
    """The result without its live fields and its motion, once its page is written."""
    parts = [replace(part, live=None) for part in result.parts]
    return replace(result, parts=parts, motion={})


def has_fields(result: DesignResult) -> bool:
    """Return True if a page of the result can be written just as after a fresh check."""
    return all(part.live is not None for part in result.parts)


def _fields_of(part: PartResult) -> LiveFields | EncodedPart:
    if isinstance(part.live, LiveFields):
        return with_required_safety(part.live, part.required_safety("fatigue"))
    if part.live is not None:
        return part.live
    why = "its stress over the cycle was not kept when it was checked"
    if part.surface.is_bare:
        methods = ", ".join(dict.fromkeys(check.method for check in part.checks))
        why = f"decided by {methods or 'no check'}, without a mesh: no stress all over its surface"
    return grey(np.asarray(part.surface.nodes), np.asarray(part.surface.triangles), why)


def estimate_of(part: PartResult) -> Surface | None:
    """Utilisation on a part that was not meshed, as the live view paints it; its name says which.

    That of the check that decides the part, at its position; where the fields have not its own, the
    static one. None where section forces tell none.
    """
    if isinstance(part.live, EncodedPart):
        return part.live.estimate
    if part.live is None or not (part.surface.is_bare and part.live.estimated and part.checks):
        return None
    check = deciding_of(part.checks)
    field = FIELDS.get((check.kind, check.unit), STATIC)
    live = with_required_safety(part.live, part.required_safety("fatigue"))
    if field in live.fatigue and live.judged:
        name, values = "fatigue utilisation over the duty", np.asarray(live.fatigue[field], float)
    else:
        allowed = _limits(part)
        limit = allowed[SHARES[field]] if field in SHARES else allowed["allowed"]
        place = _place(check, live)
        if not limit or place is None:
            return None
        kind = field if field in SHARES else STATIC
        name, values = f"{kind} utilisation (von Mises)", von_mises(live.at(*place)) / limit
    if not values.any():
        return None
    return Surface(live.nodes, live.triangles, {f"{name}, estimate": values}, int(values.argmax()))


def _place(check: Check, live: LiveFields) -> tuple[str, int] | None:
    """Cycle and position of a check, where it stresses the part most; else the part's worst."""
    cases = () if check.derivation is None else check.derivation.cases
    known = [(case.cycle, case.index) for case in cases if case.cycle in live.peaks]
    known = known or [(cycle, int(peaks.argmax())) for cycle, peaks in live.peaks.items()]
    return max(known, key=lambda place: live.peaks[place[0]][place[1]], default=None)


def _size(encoded: Sequence[EncodedPart]) -> int:
    return sum(len(part.text) for part in encoded)


def _weight(part: EncodedPart) -> int:
    """Characters that a part's fields take; nothing of one without."""
    return len(part.text) if part.head["fields"] else 0


def _coarser(
    live: LiveFields | EncodedPart, before: EncodedPart, cycles: Sequence[str], budget: Budget
) -> EncodedPart:
    """The part with larger steps, if it has fields and they are at hand."""
    if not isinstance(live, LiveFields) or not before.head["fields"]:
        return before
    note = (
        f"its stress is drawn to {100 * budget.tolerance:g} % of the cycle's peak, not to "
        f"{100 * TOLERANCE:g} %: the page would be larger than "
        f"{budget.coarse / 1e6:g} MB"
    )
    coarse = encode(live, cycles, budget.tolerance)
    if coarse.head["accuracy"]["share"] > budget.tolerance:  # its own note says to what
        return coarse
    return replace(coarse, head={**coarse.head, "notes": [*coarse.head["notes"], note]})


def _bare(part: PartResult, encoded: Sequence[EncodedPart], budget: Budget) -> LiveFields:
    """The part's surface alone."""
    why = (
        f"left out of the live view: the page's fields take {_size(encoded) / 1e6:.0f} MB, more "
        f"than {budget.most / 1e6:g} MB, and this part's are the largest"
    )
    surface = part.live if isinstance(part.live, LiveFields) else part.surface
    return grey(np.asarray(surface.nodes), np.asarray(surface.triangles), why)


def _with_shares(head: dict[str, Any]) -> dict[str, Any]:
    """The head with the fields that are the von Mises stress over what a check allows."""
    mises = head["scale"].get("mises")
    known = {field: head["limits"][limit] for field, limit in SHARES.items()}
    if mises is None or not any(known.values()):
        return head
    scale, accuracy = dict(head["scale"]), dict(head["accuracy"])
    for field, allowed in known.items():
        if allowed:
            scale[field] = {"from": 0.0, "to": mises["to"] / allowed, "unit": ""}
            accuracy[field] = [error and error / allowed for error in accuracy["mises"]]
    return {**head, "scale": scale, "accuracy": accuracy}


def _limits(part: PartResult) -> dict[str, float | None]:
    """Limits of the stress: of the first static check, and of the column check used most.

    yield    MPa, what the part can take
    allowed  MPa, over the safety that must be shown
    column   MPa, that buckling as a column allows
    """
    static = next((check for check in part.checks if check.kind == "static"), None)
    columns = [c for c in part.checks if (c.kind, c.unit) == ("buckling", "MPa")]
    column = max(columns, key=lambda check: check.utilisation, default=None)
    return {
        "yield": static.limit if static else None,
        "allowed": static.limit / static.required if static else None,
        "column": column.limit / column.required if column else None,
    }


def motion_text(result: DesignResult) -> str:
    """Packed JSON: a list over the cycles, null where nobody knows the motion.

    A cycle's motion is {index, parts, pins}: `index` (k) the positions of the cycle that are kept;
    `parts`, one for each part of the result or null, {x, y, angle: series, z} in mm and rad;
    `pins` [{on: index of the part, minor, z, x, y, fx, fy: series}] in mm and N; a minor one acts
    on a pin, against those on the bodies that it joins, and one of a pair of lugs is half of it.
    `templating` says what a series is. "" where no cycle has a motion.
    """
    if not result.motion:
        return ""
    return packed_json(
        [
            _motion(result.motion[name], result.parts) if name in result.motion else None
            for name in result.cycles
        ]
    )


def _motion(motion: PartsMotion, shown: Sequence[PartResult]) -> dict[str, Any]:
    names = [part.name for part in shown]
    parts: list[dict[str, Any] | None] = []
    for name in names:
        pose = motion.parts.get(name)
        if pose is None:
            parts.append(None)
            continue
        x, y, angle = (series(values) for values in np.asarray(pose).T)
        parts.append({"x": x, "y": y, "angle": angle, "z": round(float(motion.layer[name]), 4)})
    pins = [
        {
            "on": names.index(pin.on),
            "minor": shown[names.index(pin.on)].shape == "pin",
            "z": round(float(z), 4),
            "x": series(pin.place[:, 0]),
            "y": series(pin.place[:, 1]),
            "fx": series(pin.force[:, 0] / len(heights)),
            "fy": series(pin.force[:, 1] / len(heights)),
        }
        for pin in motion.pins.values()
        if pin.on in names
        for heights in [pin.halves or (pin.z,)]
        for z in heights
    ]
    return {"index": np.asarray(motion.index).tolist(), "parts": parts, "pins": pins}
