"""A chart as the page takes it: a picture, what it says in words, and the table behind it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import floor, isfinite, log10
from typing import Any

import numpy as np
import numpy.typing as npt

from geometry.mesh import FloatArray
from reports.svg import SERIES

_DIGITS = 3  # that a curve's largest value is read off with
_ROWS = 13  # even places of a cycle that its table has


def numbers(values: Any) -> FloatArray:
    """Numbers (n,) with a gap where there is none; empty for None."""
    if values is None:
        return np.zeros(0)
    plain = np.asarray(values, dtype=object).ravel().tolist()
    return np.array([np.nan if value is None else value for value in plain], dtype=float)


def largest(curves: Mapping[str, FloatArray]) -> float:
    """The largest magnitude of some curves, 0 without any number."""
    found = [float(np.abs(v[np.isfinite(v)]).max(initial=0.0)) for v in curves.values()]
    return max(found, default=0.0)


def decimals_of(size: float) -> int:
    """Decimals that show a number of this size with three digits, at most six.

    >>> [decimals_of(size) for size in (207.2, 61.1, 0.0254, 0.0)]
    [0, 1, 4, 1]
    """
    if not (size > 0 and isfinite(size)):
        return 1
    return min(6, max(0, _DIGITS - 1 - floor(log10(size))))


def fixed(value: float, decimals: int) -> str:
    """A number with so many decimals, a true minus, and a dash for a gap."""
    if not isfinite(value):
        return "–"
    return f"{round(value, decimals) + 0.0:.{decimals}f}".replace("-", "−")


def table_rows(curves: Sequence[FloatArray], runs: Sequence[npt.NDArray[np.intp]]) -> list[int]:
    """Which positions a table shows: even ones, ends of phases, and every curve's extremes."""
    n = sum(len(run) for run in runs)
    if not n:
        return []
    chosen = set(np.linspace(0, n - 1, min(n, _ROWS)).round().astype(int).tolist())
    chosen |= {int(run[end]) for run in runs for end in (0, -1)}
    for values in curves:
        known = np.flatnonzero(np.isfinite(values))
        if len(known):
            chosen |= {int(known[values[known].argmax()]), int(known[values[known].argmin()])}
    return sorted(chosen)


def power_unit(size: float) -> tuple[str, float]:
    """Unit in which a power [N mm/s] of this size is read well, and the factor to it.

    >>> power_unit(2e6), power_unit(4e7)
    (('W', 0.001), ('kW', 1e-06))
    """
    return ("kW", 1e-6) if size >= 1e7 else ("W", 1e-3)


def work_text(work: float) -> str:
    """A work [N mm] in J or kJ, with its sign."""
    joule = work * 1e-3
    unit, value = ("kJ", joule * 1e-3) if abs(joule) >= 1e4 else ("J", joule)
    return f"{fixed(value, decimals_of(abs(value)))} {unit}"


SIZE = (460.8, 223.2)  # points of a chart: text of 10 points stays readable on a phone
_DASHES = ("-", (0, (6, 2)), (0, (1.5, 1.5)), (0, (7, 2, 1.5, 2)), (0, (3, 1.5)), (0, (10, 3)))


@dataclass(frozen=True)
class Series:
    """A row of a chart's readout.

    name      of the curve or number
    unit      "" for a number without one
    peak      its extreme and where, in words; "" of what has none
    swatch    SVG of its stroke, "" of a number that is no curve
    decimals  of its value as it is read off
    """

    name: str
    unit: str
    peak: str = ""
    swatch: str = ""
    decimals: int = 1


@dataclass(frozen=True)
class Chart:
    """A picture with its words and numbers; `svg` and the swatches are markup, all else is text.

    key      which chart it is, such as "haigh"
    columns  of the table behind the picture; rows as long as they are
    series   rows of the readout under the picture
    """

    key: str
    title: str
    caption: str
    svg: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    series: Sequence[Series] = ()

    def __post_init__(self) -> None:
        if any(len(row) != len(self.columns) for row in self.rows):
            raise ValueError(f"the table of {self.key} needs {len(self.columns)} cells in each row")


@dataclass(frozen=True)
class Missing:
    """A chart that there is no data for, and why."""

    key: str
    title: str
    why: str


@dataclass(frozen=True)
class Charts:
    """The charts of a part or cycle, and what is missing."""

    charts: tuple[Chart, ...]
    missing: tuple[Missing, ...]

    def __bool__(self) -> bool:
        return bool(self.charts)

    @property
    def reasons(self) -> list[tuple[str, list[str]]]:
        """Why charts are missing, each reason once, with the titles that it holds for."""
        found: dict[str, list[str]] = {}
        for item in self.missing:
            found.setdefault(item.why, []).append(item.title)
        return list(found.items())


def gathered(made: Sequence[Chart | Missing]) -> Charts:
    """Return the charts, and the missing ones."""
    return Charts(
        tuple(item for item in made if isinstance(item, Chart)),
        tuple(item for item in made if isinstance(item, Missing)),
    )


def stroke(index: int) -> dict[str, Any]:
    """Colour and dashes of a series, told apart without colour too."""
    return {
        "color": SERIES[index % len(SERIES)],
        "linestyle": _DASHES[index % len(_DASHES)],
        "linewidth": 1.7,
    }


def swatch(index: int) -> str:
    """A piece of a series' stroke as SVG."""
    tint, dashes = SERIES[index % len(SERIES)], _DASHES[index % len(_DASHES)]
    gaps = ""
    if dashes != "-":
        gaps = f";stroke-dasharray:{' '.join(f'{1.7 * float(d):g}' for d in dashes[1])}"
    return (
        '<svg class="swatch" viewBox="0 0 34 8" width="34" height="8" aria-hidden="true">'
        f'<path d="M1 4H33" style="stroke:{tint};stroke-width:2.4{gaps}"/></svg>'
    )


def plain(named: Mapping[str, Any] | None) -> dict[str, Any]:
    """A mapping that may be missing."""
    return dict(named or {})


# Curves with fewer points, none of which is missed by more than a stated amount.

IntArray = npt.NDArray[np.intp]


def thinned(values: FloatArray, tolerance: float, across: FloatArray | None = None) -> IntArray:
    """Which points of a curve (n,) to keep, so that straight lines between them hold it.

    Its ends and its extremes are kept as they are; every other value lies within the tolerance of
    the line, whether that is drawn over the index or over `across` (n,), which rises.
    """
    n = len(values)
    if n < 3:
        return np.arange(n)
    axes = [np.arange(n, dtype=float)] + ([] if across is None else [across])
    kept = sorted({0, n - 1, int(values.argmax()), int(values.argmin())})
    found = set(kept)
    waiting = list(pairwise(kept))
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        inside = slice(first + 1, last)
        missed = np.zeros(last - first - 1)
        for axis in axes:
            line = _line(axis, values, first, last)
            missed = np.maximum(missed, np.abs(line - values[inside]))
        worst = int(missed.argmax())
        if missed[worst] > tolerance:
            middle = first + 1 + worst
            found.add(middle)
            waiting += [(first, middle), (middle, last)]
    return np.array(sorted(found), dtype=np.intp)


def _line(axis: FloatArray, values: FloatArray, first: int, last: int) -> FloatArray:
    """The straight line between two points, at the points between them."""
    way = axis[last] - axis[first]
    if not way > 0:
        return np.full(last - first - 1, values[first])
    share = (axis[first + 1 : last] - axis[first]) / way
    return np.asarray(values[first] + share * (values[last] - values[first]))


def gapless(values: FloatArray, run: IntArray) -> list[IntArray]:
    """The pieces of a run of positions in which a curve has no gap."""
    known = run[np.isfinite(values[run])]
    if not len(known):
        return []
    return np.split(known, np.flatnonzero(np.diff(known) > 1) + 1)
