"""Numbers of charts: gaps, units, and the decimals that a reader can use."""

from collections.abc import Mapping, Sequence
from math import floor, isfinite, log10
from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

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
