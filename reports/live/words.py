"""The tables behind the live view: what it draws, as numbers from the solver."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from checks.result.verdict import DesignResult, PartResult
from checks.result.words import brief, number, place_text

ROWS = 8  # positions of a cycle, evenly spread; the worst one is added


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
