"""The verdict as text for a terminal or a pipe: one table, and what else a reader must know."""

from collections.abc import Sequence, Set
from pathlib import Path
from shutil import get_terminal_size

from rich.cells import cell_len, chop_cells

from checks.result.verdict import Check, DesignResult, RungTried, Status
from checks.result.words import (
    assumptions,
    brief,
    broken_gates,
    check_titles,
    clean,
    clipped,
    gate_sentence,
    need_text,
    number,
    safety_text,
    utilisation_text,
    value_and_bars,
    verdict_sentence,
    where,
)

_HEADINGS = ("part", "check", "value ±num ±model", "limit", "safety (required)", "util.", "status")
_BELOW = "where; method"  # in lines of its own below the row
_INDENT = 6
_RIGHT = {3, 5}
# Least widths of columns, in the order in which they give way.
_LEAST = ((1, 14), (0, 12), (2, 18), (1, 8), (0, 8), (4, 8), (2, 12), (0, 6), (1, 6))
_LONGEST_TEXT = 2000  # of an assumption: ours have up to 500, files may say anything
_LONGEST_NAME = 18
_LONGEST_WHY = 90


def verdict_text(
    result: DesignResult, width: int | None = None, report: str | Path | None = None
) -> str:
    """Whole verdict as plain lines of at most `width` columns.

    width   None: the terminal's width (COLUMNS counts), and 100 when piped
    report  path that the last line names

    The check that decides carries a > in front.
    """
    width = line_width(width)
    positions = ", ".join(
        f"{brief(name, 24)}: {len(cycle.get('position', ()))} positions"
        for name, cycle in result.cycles.items()
    )
    name = f"{brief(result.name, 60)} ({brief(result.file, 60)})"
    lines = labelled("", f"{name}, {positions}" if positions else name, width)
    for override in result.overrides:
        lines += labelled("SET", brief(override, 200), width)
    for warning in result.warnings:
        lines += labelled("WARNING", brief(warning, 400), width)
    if result.checks:
        lines += _table(result, width)
    for part in result.parts:
        if part.rungs:
            text = f"{brief(part.name, 24)}: {tried_sentence(part.rungs)}"
            lines += labelled("LADDER", text, width)
    for owner, gate in broken_gates(result):
        text = f"{brief(owner, 40)}: {brief(gate_sentence(gate), 200)}; {brief(gate.told, 300)}"
        lines += labelled("NOT VALID" if gate.binding else "DOES NOT HOLD", text, width)
    if result.not_checked:
        text = ", ".join(brief(item, 80) for item in result.not_checked)
        lines += labelled("NOT CHECKED", text, width)
    assumed = assumptions(result)
    if assumed or result.defaults:
        items = "; ".join(
            f"{brief(keys, 200)} ({brief(what, _LONGEST_TEXT)})" for keys, what in assumed
        )
        count = len(result.defaults)
        defaults = f"({count} default value{'s' if count > 1 else ''}, listed in the report)"
        text = f"{len(assumed)}: {items}" if assumed else "nothing beyond the defaults"
        lines += labelled("ASSUMED", f"{text} {defaults if result.defaults else ''}", width)
    lines += labelled("", verdict_sentence(result), width)
    lines += footer(result, report, width)
    return "\n".join(lines) + "\n"


def _row(check: Check, title: str) -> list[str]:
    value, numerical, model = value_and_bars(check)
    status = "pass" if check.status is Status.PASS else str(check.status)
    return [
        brief(check.part, _LONGEST_NAME),
        brief(title, 40),
        f"{value} {numerical} {model} {brief(check.unit, 8)}",
        number(check.limit),
        f"{safety_text(check.safety, check.required)} ({need_text(check.required)})",
        utilisation_text(check.utilisation),
        status,
    ]


def _table(result: DesignResult, width: int) -> list[str]:
    checks = result.checks
    rows = [_row(check, title) for check, title in zip(checks, check_titles(checks), strict=True)]
    widths = [max(cell_len(row[i]) for row in (*rows, _HEADINGS)) for i in range(len(_HEADINGS))]
    gaps = 1 + len(widths)
    for column, least in _LEAST:  # names wrap first
        lack = sum(widths) + gaps - width
        widths[column] -= max(0, min(lack, widths[column] - least))
    lines = table_row("  ", list(_HEADINGS), widths, _RIGHT) + _below(_BELOW, width)
    for check, row in zip(checks, rows, strict=True):
        lines += table_row("> " if check is result.deciding else "  ", row, widths, _RIGHT)
        lines += _below(f"{brief(where(check), 300)}; {brief(check.method, 60)}", width)
    return lines


def _below(text: str, width: int) -> list[str]:
    return [" " * _INDENT + line for line in wrap(text, width - _INDENT)]


def tried_sentence(rungs: Sequence[RungTried]) -> str:
    """Models tried, their times and their outcomes, in words.

    Of the models passed over, only those before the first that answered, and the last, are named.
    """
    answering = [k for k, rung in enumerate(rungs) if rung.checks]
    first = answering[0] if answering else len(rungs)
    shown = [r for k, r in enumerate(rungs) if k < first or r.checks or r is rungs[-1]]
    return ", ".join(
        f"{brief(r.rung, 24)} {f'{number(r.seconds, 2)} s' if r.checks else 'passed over'} "
        f"({clipped(r.why, _LONGEST_WHY)})"
        for r in shown
    )


def table_row(
    mark: str, cells: Sequence[str], widths: Sequence[int], right: Set[int], between: str = " "
) -> list[str]:
    """Lines of a table's row: cells wrapped to their widths, those of `right` flush right."""
    wrapped = [wrap(cell, width) for cell, width in zip(cells, widths, strict=True)]
    lines = []
    for level in range(max(len(cell) for cell in wrapped)):
        parts = []
        for column, (cell, width) in enumerate(zip(wrapped, widths, strict=True)):
            text = cell[level] if level < len(cell) else ""
            gap = " " * (width - cell_len(text))
            parts.append(gap + text if column in right else text + gap)
        lines.append((mark if level == 0 else "  ") + between.join(parts).rstrip())
    return lines


def labelled(label: str, text: str, width: int, *, indent: int = 9) -> list[str]:
    """Paragraph behind its label, continuation lines under the first, `indent` columns in."""
    indent = max(indent, len(label) + 2) if label else 0
    first, *rest = wrap(clean(text), width - (indent or 2))
    return [(label.ljust(indent) + first).rstrip(), *(" " * (indent or 2) + line for line in rest)]


def line_width(width: int | None) -> int:
    """Columns of a line, at least 60: the terminal's (COLUMNS counts) where no width is asked for.

    It is 100 when piped.
    """
    return max(60, width or get_terminal_size((100, 24)).columns)


def wrap(text: str, width: int) -> list[str]:
    """Lines of at most `width` columns, broken at spaces, or inside a word that is too long.

    Columns are counted as a terminal does, where a wide letter takes two.
    """
    lines = [""]
    for word in text.split():
        if cell_len(f"{lines[-1]} {word}".lstrip()) <= width:
            lines[-1] = f"{lines[-1]} {word}".lstrip()
            continue
        pieces = [word] if cell_len(word) <= width else chop_cells(word, width)
        lines += pieces if lines[-1] else []
        if not lines[-1]:
            lines[-1:] = pieces
    return lines


def footer(result: DesignResult, report: str | Path | None, width: int) -> list[str]:
    """Times of the stages, and the path of the report, never wrapped."""
    lines: list[str] = []
    if result.timings:
        stages = ", ".join(f"{clean(stage)} {time:.1f}" for stage, time in result.timings.items())
        lines += labelled("", f"{sum(result.timings.values()):.1f} s: {stages}", width)
    return [*lines, *report_line(report)]


def report_line(report: str | Path | None) -> list[str]:
    """The report's path, never wrapped or shortened: it is there to be copied."""
    return [] if report is None else [f"report: {clean(report)}"]
