"""Results of CalculiX, read back from the text files that it writes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geometry.mesh import FloatArray

_WIDTH = 12  # characters of one value in an .frd file
_FIRST = 13  # characters before the first value: key, node number


@dataclass(frozen=True, eq=False)
class FrdStep:
    """Results of one step at all nodes, in the order of their numbers.

    time    the step's time
    fields  name -> (n_nodes, n_components): "DISP" mm; "FORC" N, reactions; "STRESS" MPa, averaged
            at nodes, ordered xx, yy, zz, xy, yz, zx
    """

    time: float
    fields: Mapping[str, FloatArray]


def read_frd(path: Path | str) -> tuple[FrdStep, ...]:
    """Return the steps of an .frd file that is text; six digits per value.

    Format: cgx manual 2.20, chapter "Result Format": records -4 (field), -5 (component), -1
    (values, I10 and 6E12.5), -3 (end). Raises ValueError where there is no result in it.
    """
    steps: list[tuple[float, dict[str, FloatArray]]] = []
    with Path(path).open("rb") as stream:
        lines = iter(stream)
        time = 0.0
        for line in lines:
            if line.startswith(b"  100C"):
                time = float(line[12:24])
            elif line.startswith(b" -4"):
                name = line.split()[1].decode("ascii")
                if not steps or steps[-1][0] != time or name in steps[-1][1]:
                    steps.append((time, {}))
                steps[-1][1][name] = _field(lines)
    if not steps:
        raise ValueError(f"{path}: no results; see what CalculiX printed")
    return tuple(FrdStep(time, fields) for time, fields in steps)


def read_dat(path: Path | str, what: str) -> tuple[FloatArray, ...]:
    """Return the tables of a .dat file whose heading begins with `what`, each (n, columns).

    Such as "displacements" (node, 3 values) and "stresses" (element, point, 6 values: xx, yy, zz,
    xy, xz, yz, CalculiX's order in this file); seven digits.
    """
    tables = []
    with Path(path).open(encoding="ascii") as stream:
        lines = iter(stream)
        for line in lines:
            if line.strip().startswith(what):
                tables.append(np.array(list(_rows(lines))))
    return tuple(tables)


def _rows(lines: Iterator[str]) -> Iterator[list[float]]:
    next(lines)  # an empty line follows the heading
    for line in lines:
        if not line.strip():
            return
        yield [float(value) for value in line.split()]


def _field(lines: Iterator[bytes]) -> FloatArray:
    components = 0
    rows: list[bytes] = []
    for line in lines:
        if line.startswith(b" -1"):
            rows.append(line.rstrip(b"\r\n"))
        elif line.startswith(b" -5"):
            components += len(line.split()) == 6  # a seventh entry: derived, not in the file
        elif line.startswith(b" -3"):
            break
    width = _FIRST + components * _WIDTH
    if any(len(row) != width for row in rows):
        raise ValueError(f"lines of {width} characters are expected: {components} components")
    letters = np.frombuffer(b"".join(rows), dtype=np.uint8).reshape(len(rows), width)
    numbers = np.ascontiguousarray(letters[:, 3:_FIRST]).view("S10").ravel().astype(np.int64)
    values = np.ascontiguousarray(letters[:, _FIRST:]).view(f"S{_WIDTH}").astype(np.float64)
    return np.asarray(values[np.argsort(numbers)])
