"""The ladder as text for a terminal or a pipe: value and bar against seconds, rung by rung."""

from collections.abc import Sequence
from pathlib import Path
from shutil import get_terminal_size

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
)
from reports.terminal import labelled, table_row

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
