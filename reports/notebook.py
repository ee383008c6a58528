"""Results as HTML for a notebook: the answer of the terminal and the page, and tables."""

from collections.abc import Iterable, Sequence
from html import escape

from checks.result.verdict import DesignResult
from reports.answer_facts import HEADINGS, answer_of
from reports.loads_summary import LoadsResult
from reports.loads_text import loads_text

_WIDTH = 120
_LEFT = "text-align: left"


def answer_html(result: DesignResult) -> str:
    """Verdict, safety with its range, a row for each part's governing check, and the facts."""
    answer = answer_of(result)
    safety = ""
    if answer.check is not None:
        bars = f"; {answer.within} within its error bars" if answer.within else ""
        safety = f" safety {answer.safety}, {answer.required} required{bars}"
    facts = [*answer.headline, *answer.beside]
    return "\n".join(
        [
            f"<p><b>{escape(answer.name)}: {escape(str(answer.status).upper())}</b>"
            f"{escape(safety)}</p>",
            html_table(HEADINGS, (row.cells for row in answer.rows)),
            f"<p>{escape(answer.others)}</p>",
            html_table((), ((fact.label, fact.line) for fact in facts)),
        ]
    )


def loads_html(result: LoadsResult) -> str:
    """The loads as the terminal has them."""
    return f"<pre>{escape(loads_text(result, _WIDTH))}</pre>"


def html_table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of plain texts; headings may be missing."""

    def cells(tag: str, texts: Sequence[str]) -> str:
        found = (f'<{tag} style="{_LEFT}">{escape(text)}</{tag}>' for text in texts)
        return f"<tr>{''.join(found)}</tr>"

    head = [f"<thead>{cells('th', headings)}</thead>"] if headings else []
    body = [cells("td", row) for row in rows]
    return "\n".join(["<table>", *head, "<tbody>", *body, "</tbody>", "</table>"])
