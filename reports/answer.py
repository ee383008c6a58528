"""The answer in about twenty lines: verdict, place, moment, why, each part's governing check."""

from pathlib import Path
from shutil import get_terminal_size

from rich.cells import cell_len

from checks.result.verdict import DesignResult
from reports.answer_facts import HEADINGS, Answer, answer_of
from reports.terminal import footer, labelled, table_row

_NARROWEST = (8, 10, 10, 5, 6, 9)  # columns that each keeps
_RIGHT = {2, 3, 4}
_INDENT = 13


def answer_text(
    result: DesignResult, width: int | None = None, report: str | Path | None = None
) -> str:
    """Verdict and its reason as plain lines of at most `width` columns.

    width   None: the terminal's width (COLUMNS counts), and 100 when piped
    report  path that the last line names

    Each part has its governing check alone, and parts of one outcome share a row; `verdict_text`
    has all checks. Of a warning the first sentence stands here.
    """
    width = max(60, width or get_terminal_size((100, 24)).columns)
    answer = answer_of(result)
    lines = labelled("", f"{answer.name} ({answer.file}): {str(answer.status).upper()}", width)
    for override in answer.overrides:
        lines += labelled("set", override, width)
    if answer.check:
        bars = f"; {answer.within} within its error bars" if answer.within else ""
        said = f"{answer.safety}, {answer.required} required{bars}"
        lines += labelled("safety", said, width, indent=_INDENT)
    for fact in (*answer.headline, *answer.beside):
        lines += labelled(fact.label, fact.line, width, indent=_INDENT)
    if answer.rows:
        lines += ["", *_table(answer, width), ""]
    for fact in (*answer.ways, *answer.warnings):
        lines += labelled(fact.label, fact.line, width, indent=_INDENT)
    more = "-v prints all checks, warnings, assumptions and models tried; so does the report"
    lines += labelled("more", more, width, indent=_INDENT)
    lines += footer(result, report, width)
    return "\n".join(lines) + "\n"


def _table(answer: Answer, width: int) -> list[str]:
    table = [row.cells for row in answer.rows]
    widths = [max(cell_len(row[i]) for row in (*table, HEADINGS)) for i in range(len(HEADINGS))]
    for column in (0, 1, 2, 4, 3, 5):
        lack = sum(widths) + len(widths) + 2 - width
        widths[column] -= max(0, min(lack, widths[column] - _NARROWEST[column]))
    lines = table_row("  ", list(HEADINGS), widths, _RIGHT)
    for row in answer.rows:
        lines += table_row("> " if row.decides else "  ", list(row.cells), widths, _RIGHT)
    return [*lines, f"  {answer.others}"] if answer.others else lines
