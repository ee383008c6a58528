"""Positions that a grid must not step over: roots and extremes of functions along the motion."""

from collections.abc import Callable

import numpy as np

from loads.bodies import FloatArray, IntArray

Function = Callable[[FloatArray], FloatArray]
"""Values (n,) or of several functions (rows, n) at places (n,) of a grid."""

_ROOT_STEPS = 9  # of the Illinois method: from a step of the grid to rounding
_EXTREME_STEPS = 4  # parabolas, each through the best three points


def with_roots(grid: FloatArray, function: Function) -> FloatArray:
    """Return the grid with the function's roots put in (Illinois method)."""
    values = np.atleast_2d(function(grid))
    before, after = values[:, :-1], values[:, 1:]
    row, k = np.nonzero(((before < 0.0) != (after < 0.0)) & np.isfinite(before + after))
    if not len(k):
        return grid
    one, other = grid[k], grid[k + 1]
    value_one, value_other = values[row, k], values[row, k + 1]
    for _ in range(_ROOT_STEPS):
        apart = value_other - value_one
        step = np.divide(value_other, apart, out=np.zeros_like(apart), where=apart != 0.0)
        middle = other - step * (other - one)
        value = _inside(grid, function, middle, row)
        crossed = (value < 0.0) != (value_other < 0.0)
        one = np.where(crossed, other, one)
        value_one = np.where(crossed, value_other, 0.5 * value_one)
        other, value_other = middle, value
    return _merged(grid, other)


def with_extremes(grid: FloatArray, function: Function) -> FloatArray:
    """Return the grid with the function's smallest and largest values between put in."""
    values = np.atleast_2d(function(grid))
    before, here, after = values[:, :-2], values[:, 1:-1], values[:, 2:]
    turning = np.isfinite(before + here + after) & ((here - before) * (after - here) < 0.0)
    row, k = np.nonzero(turning)
    if not len(k):
        return grid
    x = np.stack([grid[k], grid[k + 1], grid[k + 2]])
    y = np.stack([before[row, k], here[row, k], after[row, k]])
    for _ in range(_EXTREME_STEPS):
        trial = _vertex(x, y)
        value = _inside(grid, function, trial, row)
        x, y = _narrowed(x, y, trial, value)
    return _merged(grid, x[1])


def _vertex(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the vertex of the parabola through three points each (3, m), inside them."""
    left, right = x[1] - x[0], x[2] - x[1]
    rise, fall = (y[1] - y[0]) * right, (y[2] - y[1]) * left
    bend = 2.0 * (fall - rise)
    shift = np.divide(rise * right + fall * left, bend, out=np.zeros_like(bend), where=bend != 0.0)
    low, high = np.minimum(x[0], x[2]), np.maximum(x[0], x[2])
    vertex: FloatArray = np.clip(x[1] - shift, low, high)
    # a vertex on the middle point teaches nothing: look a little beside it
    same = vertex == x[1]
    return np.where(same, x[1] + 0.1 * np.where(np.abs(left) > np.abs(right), -left, right), vertex)


def _narrowed(
    x: FloatArray, y: FloatArray, trial: FloatArray, value: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the best of four points with its neighbours."""
    sense = np.sign(y[1] - y[0])  # 1: a top, -1: a bottom
    places = np.concatenate([x, trial[None]])
    heights = np.concatenate([y, value[None]])
    order = np.argsort(places, axis=0)
    places = np.take_along_axis(places, order, axis=0)
    heights = np.take_along_axis(heights, order, axis=0)
    best = 1 + np.argmax(sense * heights[1:3], axis=0)
    rows = best + np.arange(-1, 2)[:, None]
    return np.take_along_axis(places, rows, axis=0), np.take_along_axis(heights, rows, axis=0)


def _inside(grid: FloatArray, function: Function, places: FloatArray, row: IntArray) -> FloatArray:
    """Return the functions at a place each, between the grid's ends, which keep its direction.

    row  (m,) which of the functions is asked for at which of the places (m,)
    """
    values = np.atleast_2d(function(np.concatenate([grid[:1], places, grid[-1:]])))
    found: FloatArray = values[:, 1:-1][row, np.arange(len(places))]
    return found


def _merged(grid: FloatArray, places: FloatArray) -> FloatArray:
    rising = np.sort(np.concatenate([grid, places]))
    apart = np.diff(rising, prepend=-np.inf) > 1e-13 * abs(grid[-1] - grid[0])
    kept = rising[apart]
    kept[0], kept[-1] = min(grid[0], grid[-1]), max(grid[0], grid[-1])
    result: FloatArray = kept if grid[-1] > grid[0] else kept[::-1]
    return result
