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
_BELOW = "where; method"
_INDENT = 6  # columns of what stands below a row
_NARROWEST = 8  # columns of a cell that wraps
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
    below = [f"{brief(where(check), 300)}; {brief(check.method, 60)}" for check in checks]
    deciding = next(k for k, check in enumerate(checks) if check is result.deciding)
    return table(_HEADINGS, rows, {3, 5}, width, marked=deciding, below=[_BELOW, *below])


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


def table(
    headings: Sequence[str],
    rows: Sequence[Sequence[str]],
    right: Set[int],
    width: int,
    *,
    marked: int | None = None,
    below: Sequence[str] = (),
    between: str = " ",
) -> list[str]:
    """Lines of aligned columns of at most `width` together; `right` are set to the right.

    marked  row with a > in front
    below   texts in lines of their own below heading and rows

    Where the columns are too wide, the widest wrap.
    """
    columns = range(len(headings))
    widths = [max(cell_len(row[i]) for row in (headings, *rows)) for i in columns]
    room = width - 2 - len(between) * (len(widths) - 1)
    while sum(widths) > room and max(widths) > _NARROWEST:
        widths[widths.index(max(widths))] -= 1
    lines = []
    for index, row in enumerate((headings, *rows)):
        wrapped = [wrap(cell, width) for cell, width in zip(row, widths, strict=True)]
        for level in range(max(map(len, wrapped))):
            cells = (cell[level] if level < len(cell) else "" for cell in wrapped)
            aligned = (_flush(cell, widths[i], i in right) for i, cell in enumerate(cells))
            mark = "> " if marked == index - 1 and level == 0 else "  "
            lines.append((mark + between.join(aligned)).rstrip())
        if below:
            lines += [" " * _INDENT + line for line in wrap(below[index], width - _INDENT)]
    return lines


def _flush(text: str, width: int, right: bool) -> str:
    gap = " " * (width - cell_len(text))
    return gap + text if right else text + gap


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

    Such a word breaks behind a . or _ where it has one, as keys do. Columns are counted as a
    terminal does, where a wide letter takes two.
    """
    lines = [""]
    for word in text.split():
        if cell_len(f"{lines[-1]} {word}".lstrip()) <= width:
            lines[-1] = f"{lines[-1]} {word}".lstrip()
            continue
        pieces = [word] if cell_len(word) <= width else _pieces(word, width)
        lines += pieces if lines[-1] else []
        if not lines[-1]:
            lines[-1:] = pieces
    return lines


def _pieces(word: str, width: int) -> list[str]:
    """Pieces of at most `width` columns of a word that is longer."""
    whole = chop_cells(word, width)[0]
    end = 1 + max(whole.rfind(mark) for mark in "._") or len(whole)  # -1: it has none
    rest = word[end:]
    return [word[:end], *(_pieces(rest, width) if cell_len(rest) > width else [rest])]


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
