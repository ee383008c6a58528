"""Hats of pressure around a circle, and how discs and holes in sheets give way to them.

A hat is 1 at its angle, 0 at its neighbours' and straight between: hats that are not negative make
a pressure that is nowhere negative and has no steps, whose size is known at every angle. Of a
pressure p cos(n angle) on a circle of radius R, plane stress (docs/theory/contact.md):

    free disc, inwards         n = 0: (p R/E) (1 - nu),  n >= 2: (p R/E) (2n - 1 + nu)/(n^2 - 1)
    hole in an infinite sheet  n = 0: (p R/E) (1 + nu),  n >= 2: (p R/E) (2n + 1 - nu)/(n^2 - 1)

n = 1 is the force: its radial displacement is as of a rigid motion, which the pin's motion takes
up. A sheet's has no size (a logarithm of the distance), so here it is 0 of both.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache

import numpy as np

from fem.contact.cylinder_waves import Lining, bore_waves, lined_bore_waves
from geometry.mesh import FloatArray, IntArray

_EVEN = 1e-12  # rad, between the widths of even hats: rounding
_LONG = np.array([0.01])  # k R of waves along that are as long as the plane's, to 1e-4
_WAVES = 6  # of the finest hat's width: hats' series fall with the fourth power of the number


@dataclass(frozen=True, eq=False)
class Hats:
    """Hats around a whole circle.

    angles  (n,) rad, rising, less than a turn apart in all, at least three
    """

    angles: FloatArray

    def __post_init__(self) -> None:
        widths = self.widths
        if len(self.angles) < 3 or not (widths.min() > 0 and widths.max() < np.pi):
            raise ValueError("hats need at least three rising angles around a circle, in rad")

    @staticmethod
    @cache
    def even(count: int) -> "Hats":
        """Return `count` hats, the first at 0 rad."""
        return Hats(2 * np.pi * np.arange(count) / count)

    @cached_property
    def widths(self) -> FloatArray:
        """Angles (n,) from each hat to the next, rad."""
        return np.diff(np.r_[self.angles, self.angles[0] + 2 * np.pi])

    @property
    def extents(self) -> FloatArray:
        """Integral (n,) of each hat over the angle, rad."""
        return np.asarray((self.widths + np.roll(self.widths, 1)) / 2)

    def values(self, angle: FloatArray) -> FloatArray:
        """Values (..., n) of the hats at angles (...), rad."""
        left, right, share = self.beside(angle)
        numbers = np.arange(len(self.angles))
        at_left = (numbers == left[..., None]) * (1 - share[..., None])
        return np.asarray(at_left + (numbers == right[..., None]) * share[..., None])

    def beside(self, angle: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
        """Hats (...) on both sides of angles (...), rad, and the share of the way to the second."""
        beyond = (angle - self.angles[0]) % (2 * np.pi)
        starts = self.angles - self.angles[0]
        left = np.clip(np.searchsorted(starts, beyond, side="right") - 1, 0, len(starts) - 1)
        return left, (left + 1) % len(starts), (beyond - starts[left]) / self.widths[left]

    def waves(self, numbers: FloatArray) -> FloatArray:
        """Complex means (n, len(numbers)) of exp(i number angle) over the hats, numbers above 0."""
        after, before = self.widths, np.roll(self.widths, 1)
        turn = np.exp(1j * numbers * self.angles[:, None])
        # the second derivative of a hat are three jumps
        jumps = (
            np.roll(turn, 1, axis=0) / before[:, None]
            - turn * (1 / before + 1 / after)[:, None]
            + np.roll(turn, -1, axis=0) / after[:, None]
        )
        return np.asarray(-jumps / numbers**2 / self.extents[:, None])

    @property
    def directions(self) -> FloatArray:
        """Mean normals (n, 2) of the hats: their resultants per unit of force."""
        first = self.waves(np.ones(1))[:, 0]
        return np.column_stack([first.real, first.imag])

    def arc(self, pressures: FloatArray) -> float:
        """Angle of contact, rad, of pressures (n,) on one arc; 0 of none, 2 pi all around.

        Pressure falls to its end as the root of the distance, so its square is continued straight
        from the last two hats that press, to the next hat at most.
        """
        pressed = pressures > 0
        if pressed.all() or not pressed.any():
            return 2 * np.pi * bool(pressed.all())
        first = int(np.flatnonzero(pressed & ~np.roll(pressed, 1))[0])
        order = (first + np.arange(len(pressures))) % len(pressures)
        squares, widths = pressures[order] ** 2, self.widths[order]
        last = int(np.flatnonzero(pressed[order])[-1])
        arc = float(widths[:last].sum())
        for end, inner, inside, outside in (
            (0, 1, widths[0], widths[-1]),
            (last, last - 1, widths[last - 1], widths[last]),
        ):
            rise = (squares[inner] - squares[end]) / inside if last else 0.0
            arc += min(squares[end] / rise, outside) if rise > 0 else outside
        return arc

    def flexibility(self, mean: float, wave: Callable[[FloatArray], FloatArray]) -> FloatArray:
        """Mean displacement (n, n) of each hat per force on each hat, 1 per unit of length.

        mean  mm/MPa: even displacement per even pressure, over the radius times the length
        wave  the same of cos(number angle), for numbers (m,) from 2
        """
        waves = self._series
        size = np.tile(wave(self.numbers) / np.pi, 2)
        if np.ptp(self.widths) < _EVEN:  # the first hat gives way as each other one, turned
            first = waves @ (size * waves[0])
            first = (first + np.roll(first[::-1], 1)) / 2
            steps = np.arange(len(first))
            return np.asarray(first[steps[:, None] - steps] + mean / (2 * np.pi))
        parts = waves * np.sqrt(size)
        return np.asarray(parts @ parts.T + mean / (2 * np.pi))

    @property
    def numbers(self) -> FloatArray:
        """Numbers (m,) of the waves from 2 that the hats have."""
        return np.arange(2.0, int(np.ceil(_WAVES * 2 * np.pi / self.widths.min())) + 1)

    @cached_property
    def _series(self) -> FloatArray:
        """Cosines and sines (n, 2 m) of the waves over the hats."""
        waves = self.waves(self.numbers)
        return np.concatenate([waves.real, waves.imag], axis=1)


def disc_flexibility(
    hats: Hats, length: float, youngs_modulus: float, poisson_ratio: float, *, strain: bool = False
) -> FloatArray:
    """Mean inward displacement (n, n) mm/N of a free disc's rim per force on each hat.

    length  mm, along the axis; strain: plane strain instead of plane stress. The radius does not
            matter: displacement per force is a matter of length alone.
    """
    young, poisson = _plane(youngs_modulus, poisson_ratio, strain)
    size = 1 / (young * length)
    return hats.flexibility(
        size * (1 - poisson), lambda n: size * (2 * n - 1 + poisson) / (n * n - 1)
    )


def sheet_flexibility(
    hats: Hats, length: float, youngs_modulus: float, poisson_ratio: float, *, strain: bool = False
) -> FloatArray:
    """Mean outward displacement (n, n) mm/N of a hole in an infinite sheet per force on each hat.

    As `disc_flexibility`.
    """
    young, poisson = _plane(youngs_modulus, poisson_ratio, strain)
    size = 1 / (young * length)
    return hats.flexibility(
        size * (1 + poisson), lambda n: size * (2 * n + 1 - poisson) / (n * n - 1)
    )


def lining_flexibility(
    hats: Hats, length: float, youngs_modulus: float, poisson_ratio: float, lining: Lining
) -> FloatArray:
    """Mean outward displacement (n, n) mm/N that a bush adds to a hole's, by force on each hat.

    Over a hole of the bush's inner radius without it, in plane strain; as `sheet_flexibility`.
    """
    last = int(hats.numbers[-1])
    added = _added(last, youngs_modulus, poisson_ratio, lining) / (youngs_modulus * length)
    return hats.flexibility(added[0], lambda n: added[n.astype(int)])


@lru_cache(maxsize=64)
def _added(last: int, young: float, poisson: float, lining: Lining) -> FloatArray:
    lined = lined_bore_waves(last, _LONG, young, poisson, lining)
    return np.asarray(lined - bore_waves(last, _LONG, poisson))[:, 0]


def _plane(young: float, poisson: float, strain: bool) -> tuple[float, float]:
    """Young's modulus and Poisson's ratio with which plane stress' formulas are plane strain's."""
    return (young / (1 - poisson**2), poisson / (1 - poisson)) if strain else (young, poisson)
