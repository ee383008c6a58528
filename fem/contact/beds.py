"""Flexibility of a bore and the round pin in it to a line load along them.

Waves along of the three-dimensional bore and bar (fem/contact/cylinder_waves.py), with the shape
around that the plane contact has: of the mean line load, its arc held.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from fem.contact.condensed import CondensedContact
from fem.contact.cylinder_waves import Lining, bore_waves, lined_bore_waves, local_bar_waves
from fem.contact.hats import Hats, disc_flexibility, lining_flexibility, sheet_flexibility
from geometry.mesh import FloatArray

_ALONG = 128  # waves along a lug: half of the shortest is half of the finest patch
_AROUND = 48  # waves around the pin
_HATS = 144  # around the pin


@dataclass(frozen=True)
class RoundBar:
    """A round pin, which may be stepped.

    cuts       (m + 1,) mm along it, rising
    diameters  (m,) mm between them
    """

    cuts: tuple[float, ...]
    diameters: tuple[float, ...]
    youngs_modulus: float
    poisson_ratio: float

    def diameter(self, place: FloatArray) -> FloatArray:
        """Diameter at places along it, mm."""
        at = np.clip(np.searchsorted(self.cuts, place) - 1, 0, len(self.diameters) - 1)
        return np.asarray(np.array(self.diameters)[at])

    def radius_in(self, lug: "Lug") -> float:
        """Its radius in the middle of a lug, mm."""
        return float(self.diameter(np.array([(lug.low + lug.high) / 2]))[0]) / 2


@dataclass(frozen=True)
class Lug:
    """A lug on a pin.

    low, high   mm, its faces along the pin
    force       N along x and y, with which the pin presses on it
    tilt        rad/(N mm), by which it gives way to a couple that tilts it; 0: it is held
    clearance   mm, on diameter
    lining      its bush, all along it
    """

    low: float
    high: float
    force: tuple[float, float]
    youngs_modulus: float
    poisson_ratio: float
    tilt: float = 0.0
    clearance: float = 0.0
    lining: Lining | None = None

    @property
    def size(self) -> float:
        """Size of its force, N."""
        return float(np.hypot(*self.force))

    @property
    def width(self) -> float:
        """Its length on the pin, mm."""
        return self.high - self.low


@dataclass(frozen=True, eq=False)
class Along:
    """Hats of line load along a lug: 1 at a node, 0 at its neighbours; half a hat at either end.

    nodes  (n,) mm, rising
    """

    nodes: FloatArray

    @staticmethod
    def graded(lug: Lug, patches: int) -> "Along":
        """As many patches as asked for, finer towards the faces."""
        share = (1 - np.cos(np.pi * np.arange(patches + 1) / patches)) / 2
        return Along(lug.low + lug.width * share)

    @property
    def lengths(self) -> FloatArray:
        """Integrals (n,) of the hats, mm."""
        steps = np.diff(self.nodes)
        return np.asarray((np.r_[0, steps] + np.r_[steps, 0]) / 2)

    @property
    def places(self) -> FloatArray:
        """Places (n,) of the resultants of the hats, mm."""
        z = self.nodes
        inner = (z[:-2] + z[1:-1] + z[2:]) / 3
        return np.asarray(np.r_[(2 * z[0] + z[1]) / 3, inner, (2 * z[-1] + z[-2]) / 3])

    def beyond(self, x: FloatArray, power: int) -> FloatArray:
        """Shear (power 0) or moment (1) at sections x (m,) of unit forces on the hats beyond them.

        (n, m): means over each hat of (z - x)^power where that is above 0.
        """
        factor = (2.0, 6.0)[power]
        away = np.maximum(self.nodes[:, None] - x, 0.0)
        ramp = away ** (power + 2) / factor / np.ones((len(self.nodes), 1))
        slope = np.diff(ramp, axis=0) / np.diff(self.nodes)[:, None]
        ends = away[[0, -1]] ** (power + 1) / (power + 1)
        whole = np.concatenate(
            [[slope[0] - ends[0]], np.diff(slope, axis=0), [ends[1] - slope[-1]]]
        )
        return np.asarray(whole / self.lengths[:, None])

    def waves(self, numbers: FloatArray) -> FloatArray:
        """Complex means (n, m) of exp(i k (z - low)) over the hats, k (m,) in 1/mm."""
        turn = np.exp(1j * numbers * (self.nodes - self.nodes[0])[:, None])
        slope = np.diff(turn, axis=0) / np.diff(self.nodes)[:, None] / numbers**2
        ends = 1j * turn[[0, -1]] / numbers
        whole = np.concatenate(
            [[ends[0] - slope[0]], -np.diff(slope, axis=0), [slope[-1] - ends[1]]]
        )
        return np.asarray(whole / self.lengths[:, None])


def wave_bed(bar: RoundBar, lug: Lug, hats: Along) -> FloatArray:
    """Flexibility (n, n), mm/N, of the bore and the pin's surface to a lug's hats of line load."""
    return bore_bed(bar, lug, hats) + pin_bed(bar, lug, hats)


def bore_bed(bar: RoundBar, lug: Lug, hats: Along) -> FloatArray:
    """Flexibility (n, n), mm/N, of the bore: waves whose faces do not move along the pin."""
    numbers: FloatArray = np.pi / lug.width * np.arange(1.0, _ALONG + 1)
    elastic = lug.youngs_modulus, lug.poisson_ratio
    moves = _bore_waves(*elastic, lug.lining, _in_steps(numbers * bar.radius_in(lug)))
    size = around_waves(bar, lug) @ moves * 2 / (lug.width * np.pi * lug.youngs_modulus)
    cosines = hats.waves(numbers).real
    return np.asarray((cosines * size) @ cosines.T)


def pin_bed(bar: RoundBar, lug: Lug, hats: Along) -> FloatArray:
    """Flexibility (n, n), mm/N, of the pin's surface, which goes on beyond the lug."""
    numbers: FloatArray = np.pi / (2 * lug.width) * np.arange(0.5, 2 * _ALONG)
    moves = _bar_waves(bar.poisson_ratio, _in_steps(numbers * bar.radius_in(lug)))
    size = around_waves(bar, lug) @ moves / (2 * lug.width * np.pi * bar.youngs_modulus)
    both = hats.waves(numbers)
    return np.asarray(((both * size) @ both.conj().T).real)


def _in_steps(x: FloatArray) -> tuple[float, float, int]:
    """First, last and number of even waves, to be known again."""
    return float(x[0]), float(x[-1]), len(x)


@lru_cache(maxsize=64)
def _bar_waves(poisson_ratio: float, x: tuple[float, float, int]) -> FloatArray:
    return local_bar_waves(_AROUND, np.linspace(*x), poisson_ratio)


@lru_cache(maxsize=64)
def _bore_waves(
    young: float, poisson_ratio: float, lining: Lining | None, x: tuple[float, float, int]
) -> FloatArray:
    if lining is None:
        return bore_waves(_AROUND, np.linspace(*x), poisson_ratio)
    return lined_bore_waves(_AROUND, np.linspace(*x), young, poisson_ratio, lining)


def around_waves(bar: RoundBar, lug: Lug) -> FloatArray:
    """Shares (_AROUND + 1,) with which waves around give way to a line load.

    Squares of its harmonics, half of the mean's: a line load q has the pressure
    q (w_0/2 + sum w_n cos(n a))/(pi R) and work with u_n is (w_0 u_0/2 + sum w_n u_n) q, w_1 = 1.
    """
    return _around(
        lug.clearance * lug.width / lug.size if lug.clearance > 0 else 0.0,
        (bar.youngs_modulus, bar.poisson_ratio),
        (lug.youngs_modulus, lug.poisson_ratio),
        lug.lining,
    )


@lru_cache(maxsize=64)
def _around(
    opening: float, pin: tuple[float, float], bore: tuple[float, float], lining: Lining | None
) -> FloatArray:
    """By clearance over mean line load, mm2/N: a plane pin touches, then its arc is held."""
    hats = Hats.even(_HATS)
    flexibility = disc_flexibility(hats, 1.0, *pin, strain=True)
    flexibility += sheet_flexibility(hats, 1.0, *bore, strain=True)
    if lining is not None:
        flexibility += lining_flexibility(hats, 1.0, *bore, lining)
    problem = CondensedContact((flexibility + flexibility.T) / 2, hats.directions[:, :1])
    state = problem.solve(np.full(_HATS, opening / 2), np.ones(1))
    touching = np.flatnonzero(state.touching)
    shape = np.linalg.solve(
        problem.flexibility[np.ix_(touching, touching)], problem.directions[touching, 0]
    )
    waves = hats.waves(np.arange(1.0, _AROUND + 1)).real[touching]
    found = np.r_[shape.sum(), shape @ waves]
    found = (found / found[1]) ** 2
    found[0] /= 2
    return np.asarray(found)
