"""Curves with fewer points, none of which is missed by more than a stated amount."""

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from reports.charts.numbers import FloatArray

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
