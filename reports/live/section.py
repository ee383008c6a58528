"""The live view of a design as a section of the page: data of parts and motion, markup, tables."""

from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
from markupsafe import Markup

from checks.result.live_fields import EncodedPart, LiveFields, grey, von_mises, with_required_safety
from checks.result.motion import PartsMotion, motion_gaps
from checks.result.verdict import Check, DesignResult, PartResult, Surface, deciding_of
from checks.result.words import brief, clean, number, place_text
from reports.live.encode import TOLERANCE, encode
from reports.page_words import JUDGED_BY, STATIC, deciding_place, shown_of
from reports.plain_still import colour_maps
from reports.templating import json_markup, packed_json, page_template, series

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
    for index, part in enumerate(with_encoded_fields(result, budget).parts):
        assert isinstance(part.live, EncodedPart)
        head = dict(part.live.head)
        block = f"live-part-{index}"
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
    field = JUDGED_BY.get((check.kind, check.unit), STATIC)
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


ROWS = 8  # positions of a cycle, evenly spread; the worst one is added
# name of a colour map -> (its name in matplotlib, what it is called)
MAPS = {
    "viridis": ("viridis", "Viridis (safe for colour-blind eyes)"),
    "cividis": ("cividis", "Cividis (safe for colour-blind eyes)"),
    "turbo": ("turbo", "Turbo (rainbow)"),
    # for fields with two signs, unless turbo is chosen
    "signed": ("RdBu_r", "Blue to red, white at 0"),
}
USED = "use"  # the map of utilisations, which the script makes: its change of colour is at 1
MAP_NAMES = {USED: "Grey to blue, red over 1"} | {key: shown for key, (_, shown) in MAPS.items()}
# field -> (its name, what the colour bar says)
FIELDS = {
    "mises": ("von Mises stress", "von Mises"),
    "principal": ("Principal stress of largest size, signed", "principal, signed"),
    "utilisation": ("Fatigue utilisation over the duty", "utilisation"),
    "static": ("Static utilisation (von Mises)", "utilisation"),
    "column": ("Column utilisation (von Mises)", "utilisation"),
    "amplitude": ("Stress amplitude that counts for fatigue", "amplitude"),
    "mean": ("Mean stress as Goodman takes it (tension only)", "mean"),
    "displacement": ("Displacement", "displacement"),
}
_CURVE = 180  # points of the curve of the peak behind the slider


def live_section(
    result: DesignResult,
    mechanism: Markup | None = None,
    answer: Markup | None = None,
    below: Markup | None = None,
) -> Markup:
    """Live view of a result; the scripts that run it are those of the page.

    answer     stands beside the picture, on narrow screens above it
    below      stands under the slider
    mechanism  stands with the readings
    """
    payload = live_payload(result)
    body = page_template("live").render(
        parts=[_part(k, part, result, payload) for k, part in enumerate(result.parts)],
        linked=bool(result.motion) and any(head["block"] for head in payload.header["parts"]),
        fields=FIELDS,
        maps=MAP_NAMES,
        meshed=any(part.meshes for part in result.parts),
        stressed=any(head["fields"] for head in payload.header["parts"]),
        cycles=result.cycles,
        mechanism=mechanism,
        answer=answer,
        below=below,
        data={
            "live-cycles": json_markup(cycles_data(result)),
            "live-section": json_markup(_section_data(result, payload)),
            "live-header": json_markup(payload.header),
        },
        blocks=[(name, Markup(text)) for name, text in payload.blocks],
        motion=Markup(motion_text(result)),
    )
    return Markup(body)


@cache
def style_text() -> str:
    """Style sheet of the section."""
    return files("reports.live").joinpath("live.css").read_text(encoding="utf-8")


def cycles_data(result: DesignResult) -> list[dict[str, Any]]:
    """Every cycle's positions as the page's script reads them."""
    data = []
    for name, cycle in result.cycles.items():
        phases = list(dict.fromkeys(cycle["phase"]))
        number_of = {phase: k for k, phase in enumerate(phases)}
        data.append(
            {
                "name": clean(name),
                "shown": brief(name, 60),
                "shown_name": brief(cycle["shown_name"], 40),
                "unit": brief(cycle["unit"], 20),
                "position": _rounded(cycle["position"], 7),
                "time": _rounded(cycle["time"], 7) or None,
                "phase": [brief(phase, 40) for phase in phases],
                "phase_of": [number_of[phase] for phase in cycle["phase"]],
            }
        )
    return data


def _section_data(result: DesignResult, payload: LivePayload) -> dict[str, Any]:
    """Data for the script beside the parts themselves."""
    heads: Sequence[Mapping[str, Any]] = payload.header["parts"]
    first = first_part(result, heads)
    motions = list(result.motion.values())
    return {
        "maps": {key: colour_maps()[name] for key, (name, _) in MAPS.items()},
        "use": colour_maps()["use"],
        "titles": {key: short for key, (_, short) in FIELDS.items()},
        "long_titles": {key: long for key, (long, _) in FIELDS.items()},
        "names": [brief(part.name, 60) for part in result.parts],
        "full_names": [clean(part.name) for part in result.parts],
        "first": first,
        "start": _start(result, heads, first),
        "shown": shown_of(result.deciding, result) if result.checks else None,
        "curves": [
            [_curve(part, cycle) for cycle in result.cycles.values()] for part in result.parts
        ],
        "layers": brief(motions[0].layers_told, 400) if motions else "",
        "gaps": _gaps(result),
    }


def _start(
    result: DesignResult, heads: Sequence[Mapping[str, Any]], first: int
) -> list[int] | None:
    """Cycle and position that the page begins with: those that decide the verdict, if known.

    Else the worst of the part that is shown first.
    """
    place = deciding_place(result)
    if place is not None:
        return list(place[:2])
    if first < 0:
        return None
    peak = heads[first]["peak"]
    if peak:
        return [peak["cycle"], peak["position"]]
    curves = [_curve(result.parts[first], cycle) for cycle in result.cycles.values()]
    known = [(curve["most"], -k, curve["at"]) for k, curve in enumerate(curves) if curve]
    if not known:
        return None
    _, cycle, position = max(known)
    return [-cycle, position]


def _gaps(result: DesignResult) -> dict[str, str]:
    """Reason that a cycle has no motion, by the cycle's name."""
    missing = [name for name in result.cycles if name not in result.motion]
    return {clean(name): clean(why) for name, why in zip(missing, motion_gaps(result), strict=True)}


def first_part(result: DesignResult, heads: Sequence[Mapping[str, Any]]) -> int:
    """The part that is shown first: the deciding one, else one with stress.

    -1, all together, where the linkage decides, and if none is drawn.
    """
    place = deciding_place(result)
    if place is not None and place[2] < 0:
        return -1
    decides = result.deciding.part if result.checks else ""
    order = sorted(
        (k for k, head in enumerate(heads) if head["block"]),
        key=lambda k: (not heads[k]["fields"], result.parts[k].name != decides, k),
    )
    return order[0] if order else -1


def _curve(part: PartResult, cycle: Mapping[str, Any]) -> dict[str, Any] | None:
    """The peak stress over a cycle: as a picture's bytes, 255 the largest; None if not known."""
    peaks = np.asarray((cycle.get("peaks") or {}).get(part.name, ()), dtype=float)
    if not len(peaks) or len(peaks) != len(cycle["position"]):
        return None
    most = float(peaks.max())
    count = min(_CURVE, len(peaks))
    starts = np.unique(np.linspace(0, len(peaks), count, endpoint=False).astype(int))
    shares = np.maximum.reduceat(peaks, starts) / (most or 1.0)
    return {
        "most": float(f"{most:.5g}"),
        "at": int(peaks.argmax()),
        "heights": b64encode(np.rint(255 * shares).astype(np.uint8).tobytes()).decode(),
    }


def _part(
    index: int, part: PartResult, result: DesignResult, payload: LivePayload
) -> dict[str, Any]:
    head = payload.header["parts"][index]
    return {
        "index": index,
        "name": part.name,
        "notes": list(head["notes"]),
        "tables": peak_tables(part, head, result),
    }


def _rounded(values: Sequence[float], digits: int) -> list[float]:
    return [float(f"{value:.{digits}g}") for value in values]


def peak_tables(
    part: PartResult, head: Mapping[str, Any], result: DesignResult
) -> list[dict[str, Any]]:
    """Peak stress at some positions of every cycle that loads the part, from the solver, as text.

    head  the part's entry in the header of the live view

    `kind` says what the numbers are, and where they stand.
    """
    tables = []
    for index, (name, cycle) in enumerate(result.cycles.items()):
        peaks = np.asarray((cycle.get("peaks") or {}).get(part.name, ()), dtype=float)
        if not len(peaks) or len(peaks) != len(cycle["position"]):
            continue
        kind = "largest stress of the part's model, which is no field on its surface"
        if head["fields"] and not head["decides"]:
            kind = "largest stress of the model that decides, which is not the one that is drawn"
        elif head["fields"]:
            kind = "largest von Mises stress on the surface"
            if head["peak"] and head["peak"]["cycle"] == index:
                kind += f"; the reported peak is at {brief(head['peak']['place'], 120)}"
        rows = [
            {
                "position": place_text(cycle["position"][k]),
                "phase": brief(cycle["phase"][k], 40),
                "value": number(peaks[k], 4),
                "worst": k == int(np.argmax(peaks)),
            }
            for k in rows_of(peaks)
        ]
        quantity = shown_axis(cycle)
        tables.append({"cycle": brief(name, 60), "quantity": quantity, "kind": kind, "rows": rows})
    return tables


def rows_of(peaks: Any) -> list[int]:
    """Positions that a table tells: evenly spread ones and the worst; peaks (n,)."""
    spread = np.linspace(0, len(peaks) - 1, min(ROWS, len(peaks))).round().astype(int)
    return sorted({*spread.tolist(), int(np.argmax(peaks))})


def shown_axis(cycle: Mapping[str, Any]) -> str:
    """Name of the quantity shown along a cycle, with its unit."""
    unit = brief(cycle["unit"], 20)
    return f"{brief(cycle['shown_name'], 40)}{f' [{unit}]' if unit else ''}"
