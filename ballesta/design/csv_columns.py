"""Named columns of numbers in a text file, as measuring and simulation programs write them."""

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from checks.design.errors import listed, no_such
from checks.design.units import MOST
from geometry.mesh import FloatArray

_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")
_MARKS = {";": "semicolons", "\t": "tabs", ",": "commas"}
_MOST_NAMES = 30
MOST_ROWS = 20_000  # as many positions as a cycle may have


class ColumnsError(ValueError):
    """A file that has no columns of numbers, or not those asked for; says the line."""


@dataclass(frozen=True)
class Columns:
    """The cells of a file by column, as text.

    lines  number of the line in the file that each row stands in
    """

    names: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]

    def numbers(self, name: str) -> FloatArray:
        """Return a column; raises ColumnsError where it is missing or not all finite numbers."""
        where = [k for k, known in enumerate(self.names) if known == name]
        if not where:
            raise ColumnsError(no_such("column", name, self.names[:_MOST_NAMES]))
        if len(where) > 1:
            places = listed(str(k + 1) for k in where)
            raise ColumnsError(f"{len(where)} columns are named {name!r}: {places}; rename them")
        return np.array(
            [
                _number(row[where[0]], line, name)
                for row, line in zip(self.rows, self.lines, strict=True)
            ]
        )


def read_columns(text: str) -> Columns:
    """Return the columns of a text: names in the first line, then at least two rows of numbers.

    Cells are parted by semicolons, tabs or commas, whichever the first line has, in this order.
    """
    text = text.removeprefix("\ufeff")
    if not text.strip():
        raise ColumnsError("the file is empty; its first line must name the columns")
    if "\0" in text:
        raise ColumnsError("is not text (it may be UTF-16); save the file as UTF-8")
    first = next(line for line in text.splitlines() if line.strip())
    mark = next((mark for mark in _MARKS if mark in first), ",")
    reader = csv.reader(io.StringIO(text), delimiter=mark)
    table: list[tuple[int, tuple[str, ...]]] = []
    try:
        for found in reader:
            cells = tuple(cell.strip() for cell in found)
            if any(cells):
                table.append((reader.line_num, cells))
            if len(table) > 1 + MOST_ROWS:
                raise ColumnsError(f"has more than {MOST_ROWS} rows of numbers; resample it")
    except csv.Error as error:
        raise ColumnsError(f"line {reader.line_num}: is not CSV: {error}") from None
    (line, names), *rows = table
    if all(_is_number(name) for name in names if name):
        raise ColumnsError(
            f"line {line}: must name the columns, got numbers: {listed(names[:_MOST_NAMES])}"
        )
    for line, row in rows:
        if len(row) != len(names):
            raise ColumnsError(_uneven(line, row, names, mark))
    if len(rows) < 2:
        count = "one row" if rows else "no row"
        raise ColumnsError(f"has {count} of numbers under the names; at least two are needed")
    return Columns(names, tuple(row for _, row in rows), tuple(line for line, _ in rows))


def _uneven(line: int, row: Sequence[str], names: Sequence[str], mark: str) -> str:
    said = f"line {line}: has {len(row)} cells, the first line names {len(names)} columns"
    if mark == "," and len(row) > len(names):
        return f"{said}; are these decimal commas? Decimals are written with a point"
    other = next((other for other in _MARKS if other != mark and other in "".join(row)), None)
    if len(row) == 1 and other:
        return f"{said} parted by {_MARKS[mark]}; this line is parted by {_MARKS[other]}"
    return said


def _number(cell: str, line: int, name: str) -> float:
    here = f"line {line}, column {name!r}"
    try:
        if "_" in cell:  # Python would take 1_000
            raise ValueError
        value = float(cell)
    except ValueError:
        if not cell:
            raise ColumnsError(f"{here}: is empty, a number is needed") from None
        if _DECIMAL_COMMA.fullmatch(cell):
            raise ColumnsError(
                f'{here}: "{cell}" has a decimal comma; decimals are written with a point'
            ) from None
        hint = "; units stand in the design, not in the file" if line == 2 else ""
        raise ColumnsError(f'{here}: must be a number, got "{cell[:40]}"{hint}') from None
    if not abs(value) <= MOST:
        raise ColumnsError(
            f'{here}: must be a finite number, got "{cell[:40]}"; at most {MOST:g} is taken'
        )
    return value


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", ".", 1))
    except ValueError:
        return False
    return True
