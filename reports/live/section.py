"""The live view as a section of the page: its markup, data blocks and style, and its tables."""

from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
from markupsafe import Markup

from checks.result.motion import motion_gaps
from checks.result.verdict import DesignResult, PartResult
from checks.result.words import brief, clean, number, place_text
from reports.live.colours import colour_maps
from reports.live.payload import LivePayload, live_payload, motion_text
from reports.page_words import deciding_place, shown_of
from reports.templating import environment, json_markup

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


@dataclass(frozen=True)
class LiveSection:
    """The live view: `body` for the page, `style` for its style sheet."""

    body: Markup
    style: str


def live_section(
    result: DesignResult,
    mechanism: Markup | None = None,
    answer: Markup | None = None,
    below: Markup | None = None,
) -> LiveSection:
    """Live view of a result; the scripts that run it are those of the page.

    answer     stands beside the picture, on narrow screens above it
    below      stands under the slider
    mechanism  stands with the readings
    """
    payload = live_payload(result)
    body = _template().render(
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
    return LiveSection(Markup(body), style_text())


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


@cache
def _template() -> Any:
    return environment().get_template("live.html.j2")


@dataclass(frozen=True)
class PeakRow:
    """A part's peak stress at a position, as text; `worst` of the cycle."""

    position: str
    phase: str
    value: str
    worst: bool


@dataclass(frozen=True)
class PeakTable:
    """Peaks of one part over one cycle; `kind` says what the numbers are, and where they stand."""

    cycle: str
    quantity: str
    kind: str
    rows: Sequence[PeakRow]


def peak_tables(part: PartResult, head: Mapping[str, Any], result: DesignResult) -> list[PeakTable]:
    """Peak stress at some positions of every cycle that loads the part, from the solver.

    head  the part's entry in the header of the live view
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
        rows = [_row(cycle, peaks, k) for k in rows_of(peaks)]
        tables.append(PeakTable(brief(name, 60), shown_axis(cycle), kind, rows))
    return tables


def rows_of(peaks: Any) -> list[int]:
    """Positions that a table tells: evenly spread ones and the worst; peaks (n,)."""
    spread = np.linspace(0, len(peaks) - 1, min(ROWS, len(peaks))).round().astype(int)
    return sorted({*spread.tolist(), int(np.argmax(peaks))})


def shown_axis(cycle: Mapping[str, Any]) -> str:
    """Name of the quantity shown along a cycle, with its unit."""
    unit = brief(cycle["unit"], 20)
    return f"{brief(cycle['shown_name'], 40)}{f' [{unit}]' if unit else ''}"


def _row(cycle: Mapping[str, Any], peaks: Any, index: int) -> PeakRow:
    return PeakRow(
        position=place_text(cycle["position"][index]),
        phase=brief(cycle["phase"][index], 40),
        value=number(peaks[index], 4),
        worst=index == int(np.argmax(peaks)),
    )
