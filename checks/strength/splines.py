"""Cubic splines through values at rising places, for less time than SciPy takes to load its own."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from geometry.mesh import FloatArray


@dataclass(frozen=True, eq=False)
class Spline:
    """A curve with continuous first and second derivatives, a cubic polynomial in every step.

    The first two steps share theirs, and so do the last two ("not a knot", as of
    `scipy.interpolate.CubicSpline`); through three values goes a parabola, through two a line.

    places  (n,) rising
    values  (n, ...)
    slopes  (n, ...)
    """

    places: FloatArray
    values: FloatArray
    slopes: FloatArray

    @classmethod
    def through(cls, places: FloatArray, values: FloatArray) -> Self:
        """The spline through values (n, ...) at places (n,), two at least."""
        step = np.diff(places)
        h = step.reshape(-1, *[1] * (values.ndim - 1))
        rise = np.diff(values, axis=0) / h
        if len(step) < 3:
            bend = (rise[-1] - rise[0]) / (places[-1] - places[0])  # half the second derivative
            first = rise[0] - bend * step[0]
            return cls(places, values, first + 2 * bend * np.concatenate([0 * h[:1], h]).cumsum(0))
        slopes = np.empty(values.shape)
        slopes[1:-1] = 3 * (h[1:] * rise[:-1] + h[:-1] * rise[1:])
        for end, next_one in ((0, 1), (-1, -2)):
            both = h[end] + h[next_one]
            weight = h[next_one] * (h[end] + 2 * both)
            slopes[end] = (weight * rise[end] + h[end] ** 2 * rise[next_one]) / both
        below = [*step[1:].tolist(), float(step[-2] + step[-1])]
        main = [step[1], *(2 * (step[1:] + step[:-1])).tolist(), step[-2]]
        above = [float(step[0] + step[1]), *step[:-1].tolist()]
        for k, low in enumerate(below):  # elimination of a matrix of three diagonals
            share = low / main[k]
            main[k + 1] -= share * above[k]
            slopes[k + 1] -= share * slopes[k]
        slopes[-1] /= main[-1]
        for k in reversed(range(len(step))):
            slopes[k] = (slopes[k] - above[k] * slopes[k + 1]) / main[k]
        return cls(places, values, slopes)

    def at(self, x: FloatArray, derivative: int = 0) -> FloatArray:
        """The value (m, ...) at places x (m,) within the spline, or its first or second derivative.

        Where two steps meet, of the later one.
        """
        k = np.clip(np.searchsorted(self.places, x, side="right") - 1, 0, len(self.places) - 2)
        shape = (-1, *[1] * (self.values.ndim - 1))
        h = (self.places[k + 1] - self.places[k]).reshape(shape)
        t = (x - self.places[k]).reshape(shape)
        rise = (self.values[k + 1] - self.values[k]) / h
        start, end = self.slopes[k], self.slopes[k + 1]
        cubic = (start + end - 2 * rise) / h**2
        square = (rise - start) / h - cubic * h
        if derivative == 0:
            return np.asarray(self.values[k] + t * (start + t * (square + t * cubic)))
        if derivative == 1:
            return np.asarray(start + t * (2 * square + 3 * t * cubic))
        return np.asarray(2 * square + 6 * t * cubic)
