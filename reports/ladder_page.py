"""The ladder as one HTML page that stands alone: a chart of every part, and its numbers."""

from collections.abc import Sequence
from functools import cache
from math import inf
from pathlib import Path
from shutil import get_terminal_size
from typing import Any

from markupsafe import Markup
from rich.cells import cell_len

from checks.result.verdict import Check, RungTried
from checks.result.words import brief, clean, number
from reports.ladder_summary import (
    AUTO,
    LadderPart,
    LadderResult,
    check_of,
    chosen_sentence,
    needed,
    no_answer,
    seconds_text,
    status_word,
    value_and_bar,
    whole_bar,
)
from reports.svg import SERIES, Drawing, colour, colour_variables, draw
from reports.templating import environment
from reports.terminal import labelled, table_row

_MARKERS = "os^Dv<>P"
_LEFT, _WIDE, _HIGH, _PITCH = 50.0, 450.0, 110.0, 165.0  # points of a panel, and to the next one
_SHORTEST = 1e-4  # s: a logarithm needs more than 0


def ladder_html(result: LadderResult) -> str:
    """Page as text. The same result gives the same page."""
    text: str = _template().render(
        result=result,
        parts=[
            {
                "part": part,
                "chart": Markup(ladder_chart(part)),
                "rows": _rows(part),
                "auto": chosen_sentence(part.chosen, part.seconds),
            }
            for part in result.parts
        ],
        light=Markup(colour_variables(dark=False)),
        dark=Markup(colour_variables(dark=True)),
    )
    return text


def _rows(part: LadderPart) -> list[dict[str, Any]]:
    """One row for each kind and rung: its check, or why there is none."""
    rows: list[dict[str, Any]] = []
    for kind in part.kinds:
        for rung in part.rungs:
            check = check_of(rung.checks, kind)
            why = no_answer(rung) if check is None else rung.why
            rows.append(_row(kind, rung.rung, rung.seconds, check, rung.unknowns, why))
        if chosen := check_of(part.chosen, kind):
            why = f"takes it by {brief(chosen.method, 40)}"
            rows.append(_row(kind, AUTO, part.seconds, chosen, None, why))
    return rows


def _row(
    kind: str, rung: str, seconds: float, check: Check | None, unknowns: int | None, why: str
) -> dict[str, Any]:
    return {
        "kind": kind,
        "rung": rung,
        "seconds": seconds_text(seconds),
        "unknowns": unknowns,
        "check": check,
        "value": value_and_bar(check) if check else None,
        "allowed": needed(check) if check else None,
        "why": why,
    }


def ladder_chart(part: LadderPart) -> str:
    """Value and whole bar against seconds, a panel for each kind of check; "" without a value."""
    panels = [(kind, _points(part, kind)) for kind in part.kinds]
    panels = [(kind, points) for kind, points in panels if points]
    if not panels:
        return ""
    names = [rung.rung for rung in part.rungs] + [AUTO]

    def plot(figure: Drawing) -> None:
        for row, (kind, points) in enumerate(panels):
            _panel(figure, 20.0 + row * _PITCH, kind, points, names)
        shown = [name for name in names if any(name == at[0] for _, p in panels for at in p)]
        entries = [(brief(n, 24), _style(names.index(n), n)) for n in shown]
        entries.append(("allowed", {"color": colour("fail")}))
        for row, entry in enumerate(entries):
            figure.legend([entry], (_LEFT + _WIDE + 12, 20.0 + 15 * row, 0.0))

    size = (_LEFT + _WIDE + 150, _PITCH * len(panels))
    return draw(plot, size, f"Ladder of {brief(part.name, 40)}")


def _points(part: LadderPart, kind: str) -> list[tuple[str, float, Check]]:
    """Name, seconds and check of every rung that has a value, and of auto."""
    rungs = [(rung.rung, rung.seconds, check_of(rung.checks, kind)) for rung in part.rungs]
    rungs.append((AUTO, part.seconds, check_of(part.chosen, kind)))
    return [(name, max(seconds, _SHORTEST), check) for name, seconds, check in rungs if check]


def _panel(
    figure: Drawing, top: float, kind: str, points: list[tuple[str, float, Check]], names: list[str]
) -> None:
    allowed = [needed(check) for _, _, check in points]
    times = [seconds for _, seconds, _ in points]
    across, up = (min(times) / 2, max(times) * 2), (0.0, _top(points, allowed))
    axes = figure.frame((_LEFT, top, _WIDE, _HIGH), across, up, logarithmic="x")
    if max(allowed) - min(allowed) <= 1e-9 * max(allowed):
        axes.line([[end, allowed[0]] for end in across], color=colour("fail"), linewidth=1.6)
    else:  # points on different places of the part may take differently much
        marks = list(zip(times, allowed, strict=True))
        axes.line(marks, linestyle="", marker="_", color=colour("fail"), markersize=16)
    for name, seconds, check in points:
        above, below = whole_bar(check)
        style = _style(names.index(name), name)
        axes.line([[seconds, check.value]], **style)
        if above < inf and below < inf:
            low, high = max(0.0, check.value - below), check.value + above
            axes.line([[seconds, low], [seconds, high]], color=style["color"], marker="_")
        else:
            axes.line([[seconds, up[0]], [seconds, up[1]]], color=style["color"], linewidth=1.2,
                      linestyle=":")  # fmt: skip
    unit = points[0][2].unit
    least, most = number(min(allowed)), number(max(allowed))
    told = most if least == most else f"{least} to {most}"
    title = f"{brief(kind, 40)}, allowed {told} {brief(unit, 8)}".strip()
    quantity = f"{brief(points[0][2].quantity, 30)} [{brief(unit, 8) or '–'}]"
    figure.text(_LEFT, top - 6, f"{title}: {quantity}", anchor="start", weight="bold")
    figure.text(_LEFT + _WIDE / 2, top + _HIGH + 27, "time [s]", size=9)


def _top(points: list[tuple[str, float, Check]], allowed: list[float]) -> float:
    """Upper end of the axis: values, finite bars, and what is allowed if it is not far away."""
    ends = [check.value + whole_bar(check)[0] for _, _, check in points]
    values = max(check.value for _, _, check in points)
    inside = max([values, *(end for end in ends if end <= 4 * values)])
    near = [limit for limit in allowed if limit <= 5 * inside]
    return 1.08 * max([inside, *near]) or 1.0


def _style(index: int, name: str) -> dict[str, Any]:
    """Colour and marker of a rung; auto is a ring about whichever it took."""
    ring = {"marker": "o", "markersize": 14, "markerfacecolor": "none", "color": colour("ink")}
    return {"linestyle": ""} | (
        ring
        if name == AUTO
        else {
            "marker": _MARKERS[index % len(_MARKERS)],
            "markersize": 7,
            "color": SERIES[index % len(SERIES)],
        }
    )


@cache
def _template() -> Any:
    return environment().get_template("ladder.html.j2")


# The ladder as text for a terminal or a pipe: value and bar against seconds, rung by rung.

_HEADINGS = ("check", "rung", "time", "unknowns", "value", "± bar", "allowed", "status")
_RIGHT = {2, 3, 4, 6}
_LONGEST_NAME = 18
_MAY_WRAP = ((5, 8), (1, 8), (4, 8), (3, 6), (0, 8), (7, 6))  # column, its least width


def ladder_text(
    result: LadderResult, width: int | None = None, files: Sequence[str | Path] = ()
) -> str:
    """Whole ladder as plain lines of at most `width` columns (paths are never broken).

    width  None: the terminal's width (COLUMNS counts), and 100 when piped
    """
    width = max(60, width or get_terminal_size((100, 24)).columns)
    lines = labelled("", f"{brief(result.name, 60)} ({brief(result.file, 60)})", width)
    for override in result.overrides:
        lines += labelled("SET", brief(override, 200), width)
    for part in result.parts:
        lines += ["", *_part(part, width)]
    lines += ["", *labelled("SOLIDS", result.solids, width)]
    said = (
        "value ± bar: numerical bar and model band together; allowed: limit over required safety; "
        "times are those of the part alone, without the loads"
    )
    lines += labelled("NOTE", said, width)
    lines += [f"written: {clean(file)}" for file in files]
    return "\n".join(lines) + "\n"


def _part(part: LadderPart, width: int) -> list[str]:
    title = f"{brief(part.name, 40)}: {brief(part.shape, 40)}, {brief(part.material, 40)}"
    lines = labelled("", title, width)
    table = [list(_HEADINGS)]
    for kind in part.kinds:
        first = brief(kind, _LONGEST_NAME)
        for rung in part.rungs:
            check = check_of(rung.checks, kind)
            start = [first, brief(rung.rung, _LONGEST_NAME)]
            table.append(
                [*start, *_cells(rung.seconds, rung, check)]
                if check
                else [*start, brief(no_answer(rung), 160)]
            )
            first = ""
        if check := check_of(part.chosen, kind):
            table.append(["", AUTO, *_cells(part.seconds, None, check)])
    lines += _aligned(table, width)
    lines += labelled("AUTO", chosen_sentence(part.chosen, part.seconds), width)
    for rung in part.tried:
        cost = seconds_text(rung.seconds) if rung.checks else "passed over"
        lines += labelled(f"  {brief(rung.rung, 16)}", f"{cost}, {brief(rung.why, 300)}", width)
    return lines


def _cells(seconds: float, rung: RungTried | None, check: Check) -> list[str]:
    unit = f" {brief(check.unit, 8)}" if check.unit else ""
    value, bar = value_and_bar(check)
    return [
        seconds_text(seconds),
        str(rung.unknowns) if rung else "",
        f"{value}{unit}",
        bar,
        number(needed(check)),
        status_word(check),
    ]


def _aligned(rows: Sequence[list[str]], width: int) -> list[str]:
    """Rows in columns; a row that is short ends in words, which take the columns that it lacks."""
    count = len(_HEADINGS)
    whole = [row for row in rows if len(row) == count]
    widths = [max(cell_len(row[i]) for row in whole) for i in range(count)]
    widths[1] = max(cell_len(row[1]) for row in rows)
    widths[0] = max(cell_len(row[0]) for row in rows)
    for column, least in _MAY_WRAP:
        lack = 1 + count + sum(widths) - width
        widths[column] -= max(0, min(lack, widths[column] - least))
    lines = []
    for row in rows:
        if len(row) == count:
            lines += table_row("  ", row, widths, _RIGHT)
        else:
            first = len(row) - 1
            rest = max(width - 2 - sum(widths[:first]) - first, 20)
            lines += table_row("  ", row, [*widths[:first], rest], _RIGHT - {first})
    return lines
