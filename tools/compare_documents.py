"""Write docs/documents.md: the published values of the four documents against ballesta.

`--check` writes nothing and exits 1 if the page would change. The values stand in documents.toml;
what ballesta finds and the documents' own formulae are functions of documents_<machine>.py.
"""

import re
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import documents_hammer
import documents_quick_return
import documents_slider_crank
import documents_toggle
import documents_toggle_parts
import numpy as np
from written_page import write_or_check

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "documents.md"
DATA = Path(__file__).parent / "documents.toml"
MODULES = {
    "hammer": (documents_hammer,),
    "slider_crank": (documents_slider_crank,),
    "quick_return": (documents_quick_return,),
    "toggle": (documents_toggle, documents_toggle_parts),
}
PUBLISHED = ("Quantity", "Where", "Document", "Its formula", "ballesta", "Difference", "Reason")
COMPARED = ("Quantity", "Where", "Its formula", "ballesta", "Furthest apart", "Reason")
ERROR = re.compile(r"\b[HSQT]-[A-Z]\d*\b")
ZERO = 1e-5  # no quantity of the page is that small but by rounding
SMALL = 2e-4  # of the largest of a row
HEAD = """\
# Published values against ballesta

Written by `make documents` from `tools/documents.toml` and the designs; do not edit.

Four documents describe the machines of `designs/`. Each number that they publish stands here with
what ballesta finds for the same quantity, and with the error of the document that explains the
difference. *Its formula* is the document's own formula or script computed anew, errors included:
where it meets the published number and ballesta does not, the errors named are the reason.
Differences are ballesta less document, in % of the published number (of the largest published of
the row where that is 0); of a row of numbers, the range of the differences. *By hand* marks what is
no result of ballesta's but the document's formula set right.
"""

Value = float | list[float]


@dataclass(frozen=True)
class Row:
    """One published value: the document's number or words, its formula's value, and ballesta's."""

    table: str
    quantity: str
    where: str
    unit: str
    document: Any
    formula: Value | None
    found: Value
    bounds: tuple[float, float] | None
    by_hand: bool
    joint: str
    reason: str


@dataclass(frozen=True)
class Comparison:
    """One formula over a turn: the ranges of formula and ballesta, and where they are furthest."""

    quantity: str
    where: str
    unit: str
    formula: tuple[float, float]
    found: tuple[float, float]
    deviation: float
    reason: str


def read_data() -> dict[str, Any]:
    """Return documents.toml."""
    return tomllib.loads(DATA.read_text(encoding="utf-8"))


def _call(machine: str, name: str, arguments: Mapping[str, Any]) -> Any:
    for module in MODULES[machine]:
        if hasattr(module, name):
            return getattr(module, name)(**arguments)
    raise SystemExit(f"documents.toml: {machine}: no function is named {name!r}")


def rows_of(machine: str, table: Mapping[str, Any]) -> Iterator[Row]:
    """Yield the rows of a table of published values."""
    for stated in table["rows"]:
        row = {**table, **stated}
        arguments = row.get("with", {})
        again = row.get("formula_with", arguments)
        yield Row(
            table=table["title"],
            quantity=row["quantity"],
            where=row["where"],
            unit=row["unit"],
            document=row["document"],
            formula=_call(machine, row["formula"], again) if "formula" in row else None,
            found=_call(machine, row["find"], arguments),
            bounds=tuple(row["bounds"]) if "bounds" in row else None,
            by_hand=row.get("by_hand", False),
            joint=" … " if row.get("range") else ", ",
            reason=row.get("reason", ""),
        )


def comparisons_of(machine: str, table: Mapping[str, Any]) -> Iterator[Comparison]:
    """Yield the rows of a table of formulae over a turn."""
    for row in table["rows"]:
        formula, found = _call(machine, row["find"], {})
        apart = formula - found
        if apart.ndim == 2:  # vectors by their size
            formula, found, apart = (np.hypot(*part.T) for part in (formula, found, apart))
        yield Comparison(
            row["quantity"],
            row["where"],
            row["unit"],
            (float(formula.min()), float(formula.max())),
            (float(found.min()), float(found.max())),
            float(np.abs(apart).max()),
            row["reason"],
        )


def number(value: float) -> str:
    """Return a number with four significant digits, all of those before the point."""
    if abs(value) < ZERO:
        return "0"
    magnitude = int(f"{value:.3e}".partition("e")[2])
    return f"{value:.{max(0, 3 - magnitude)}f}"


def shown(value: Value | tuple[float, float], joint: str = " … ") -> str:
    """Return a value of ballesta's or of a formula; in a row, 0 is what is small beside others."""
    if isinstance(value, float):
        return number(value)
    small = SMALL * max(abs(part) for part in value)
    return joint.join(number(part if abs(part) > small else 0.0) for part in value)


def published(value: Any, joint: str) -> str:
    """Return a value as the document prints it."""
    if isinstance(value, list):
        return joint.join(str(part) for part in value)
    return str(value)


def differences(row: Row) -> list[float]:
    """Return ballesta less document in %, for every number of a row."""
    stated = row.document if isinstance(row.document, list) else [row.document]
    found = row.found if isinstance(row.found, list) else [row.found]
    largest = max(abs(part) for part in stated)
    return [
        100.0 * (ours - theirs) / (abs(theirs) or largest)
        for ours, theirs in zip(found, stated, strict=True)
    ]


def _percent(value: float) -> str:
    digits = 0 if abs(value) >= 10.0 else 1 if abs(value) >= 1.0 else 2
    text = f"{value:+.{digits}f}"
    return "0" if float(text) == 0.0 else text


def difference(row: Row) -> str:
    """Return the difference of a row in words."""
    if isinstance(row.document, str):
        if row.bounds is None:
            return ""
        found = row.found if isinstance(row.found, list) else [row.found]
        inside = min(found) >= row.bounds[0] and max(found) <= row.bounds[1]
        return "agrees" if inside else "disagrees"
    parts = differences(row)
    if len(parts) == 2:
        return f"{_percent(parts[0])}, {_percent(parts[1])} %"
    low, high = _percent(min(parts)), _percent(max(parts))
    return f"{low} %" if low == high else f"{low} … {high} %"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return a table without the columns that are empty in all rows."""
    kept = [k for k in range(len(head)) if any(row[k] for row in rows)]
    lines = [[head[k] for k in kept], ["---"] * len(kept)]
    lines += [[row[k] for k in kept] for row in rows]
    return ["| " + " | ".join(line) + " |" for line in lines] + [""]


def _named(row: Row | Comparison) -> str:
    return f"{row.quantity} [{row.unit}]" if row.unit else row.quantity


def _section(machine: str, table: Mapping[str, Any]) -> list[str]:
    lines = [f"### {table['title']}", ""]
    if "text" in table:
        lines += [table["text"], ""]
    if "reason_of_all" in table:
        lines += [f"Reason: {table['reason_of_all']}", ""]
    if table.get("over_a_turn"):
        compared = [
            (
                _named(row),
                row.where,
                shown(row.formula),
                shown(row.found),
                number(row.deviation),
                row.reason,
            )
            for row in comparisons_of(machine, table)
        ]
        return [*lines, *_table(COMPARED, compared)]
    values = [
        (
            _named(row),
            "" if "where" in table else row.where,
            published(row.document, row.joint),
            "" if row.formula is None else shown(row.formula, row.joint),
            shown(row.found, row.joint) + (" (by hand)" if row.by_hand else ""),
            difference(row),
            row.reason,
        )
        for row in rows_of(machine, table)
    ]
    return [*lines, *_table(PUBLISHED, values)]


def _errors(machine: str, stated: Mapping[str, str], text: str) -> list[str]:
    named, known = set(ERROR.findall(text)), set(stated)
    if named != known:
        odd = ", ".join(sorted(named ^ known))
        raise SystemExit(f"documents.toml: {machine}: explained but not named, or reverse: {odd}")
    lines = ["### Errors of the document that explain them", ""]
    return [*lines, *(f"- **{key}** {words}" for key, words in stated.items()), ""]


def page() -> str:
    """Return docs/documents.md."""
    lines = [HEAD]
    for machine, stated in read_data().items():
        lines += [f"## {stated['title']}", "", stated["document"], "", stated["intro"].strip(), ""]
        tables = [line for table in stated["tables"] for line in _section(machine, table)]
        lines += [*tables, *_errors(machine, stated["errors"], "\n".join(tables))]
    return "\n".join(lines).rstrip() + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page, or say whether it is up to date."""
    return write_or_check(PAGE, page(), "make documents", __doc__, arguments)


if __name__ == "__main__":
    sys.exit(main())
