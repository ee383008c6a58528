"""The line load q(z) along a round pin in its stack of lugs, where pin and bores give way.

The pin is a Timoshenko beam. In each lug it presses on the bore as far as that gives way: waves
along the pin of the three-dimensional bore and bar (fem/contact/cylinder_waves.py), with the shape
around that the plane contact has (the mean line load, its arc held). Lugs move freely along their
force and may tilt. No pull: where the pin lifts off, it presses nothing. Forces of all lugs and
the moments about the pin balance exactly. The condensed contact of fem/contact/condensed.py, with
hats of line load along the lugs. docs/theory/contact.md, "Along the pin", derives it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from fem.contact.condensed import CondensedContact
from fem.contact.cylinder_waves import bore_waves, local_bar_waves, shear_of_bar
from fem.contact.hats import Hats, disc_flexibility, sheet_flexibility
from geometry.mesh import FloatArray

_PATCHES = 12  # along a lug, graded to its edges
_ALONG = 128  # waves along a lug: half of the shortest is half of the finest patch
_AROUND = 48  # waves around the pin
_HATS = 144  # around the pin
_GAUSS = np.polynomial.legendre.leggauss(4)  # exact for squares of cubics
_LEVEL = 1e-9  # of the largest force: what is across it is none

# Flexibility (n, n), mm/N, of a bore and the pin in it to the hats of its lug.
Bed = Callable[["RoundBar", "Lug", "Along"], FloatArray]


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


@dataclass(frozen=True)
class Lug:
    """A lug on a pin.

    low, high   mm, its faces along the pin
    force       N along x and y, with which the pin presses on it
    tilt        rad/(N mm), by which it gives way to a couple that tilts it; 0: it is held
    clearance   mm, on diameter
    """

    low: float
    high: float
    force: tuple[float, float]
    youngs_modulus: float
    poisson_ratio: float
    tilt: float = 0.0
    clearance: float = 0.0

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


@dataclass(frozen=True, eq=False)
class LineLoad:
    """What presses along a pin.

    bar    the pin
    lugs   that it presses on; `hats` and `forces` (n,), N, of the hats, one of each lug
    """

    bar: RoundBar
    lugs: Sequence[Lug]
    hats: Sequence[Along]
    forces: Sequence[FloatArray]

    def intensity(self, lug: int) -> FloatArray:
        """Line load (n,), N/mm, at the nodes of a lug's hats."""
        return np.asarray(self.forces[lug] / self.hats[lug].lengths)

    def unevenness(self, lug: int, inside: float = 0.0) -> float:
        """Largest line load of a lug over its mean, at least `inside` mm from its faces.

        In the middle of a lug that is less than twice as wide.
        """
        one = self.lugs[lug]
        inside = min(inside, one.width / 2)
        nodes, values = self.hats[lug].nodes, self.intensity(lug)
        ends = np.array([one.low + inside, one.high - inside])
        kept = values[(nodes > ends[0]) & (nodes < ends[1])]
        most = max(kept.max(initial=0.0), *np.interp(ends, nodes, values))
        return float(most * one.width / one.size)

    def shift(self, lug: int) -> float:
        """Place of the resultant of a lug, mm from its middle."""
        one = self.lugs[lug]
        at = self.forces[lug] @ self.hats[lug].places / self.forces[lug].sum()
        return float(at - (one.low + one.high) / 2)

    def moment(self, places: FloatArray) -> FloatArray:
        """Bending moment (m, 2) at places along the pin, N mm: forces times their distance."""
        found = np.zeros((len(places), 2))
        for lug, hats, forces in zip(self.lugs, self.hats, self.forces, strict=True):
            direction = np.array(lug.force) / lug.size
            found += np.outer(forces @ hats.beyond(places, 1), direction)
        return found

    @cached_property
    def largest_moment(self) -> float:
        """Largest bending moment of the pin, N mm."""
        low, high = self.bar.cuts[0], self.bar.cuts[-1]
        places = np.unique(np.r_[np.linspace(low, high, 201), *(h.nodes for h in self.hats)])
        return float(np.hypot(*self.moment(places).T).max())


def line_load(
    bar: RoundBar, lugs: Sequence[Lug], bed: Bed | None = None, patches: int = _PATCHES
) -> LineLoad:
    """Solve what presses along a pin.

    lugs     that carry a force
    bed      flexibility of bore and pin in a lug, where it is not that of waves
    patches  along a lug

    Raises ContactError where no pressure balances the forces.
    """
    hats = [Along.graded(lug, patches) for lug in lugs]
    places = np.concatenate([h.places for h in hats])
    count = [len(h.nodes) for h in hats]
    owner = np.repeat(np.arange(len(lugs)), count)
    directions = np.array([lug.force for lug in lugs]) / np.array([[lug.size] for lug in lugs])
    along = directions[owner]
    flexibility = _beam(bar, hats) * (along @ along.T)
    for k, (lug, own) in enumerate(zip(lugs, hats, strict=True)):
        at = np.flatnonzero(owner == k)
        block = (bed or wave_bed)(bar, lug, own)
        arm = own.places - (lug.low + lug.high) / 2
        flexibility[np.ix_(at, at)] += block + lug.tilt * np.outer(arm, arm)
    flexibility = (flexibility + flexibility.T) / 2
    # the pin turns; each lug moves along its force
    turning = along * places[:, None]
    moves = (owner[:, None] == np.arange(len(lugs))).astype(float)
    turning = turning[:, np.abs(along).max(axis=0) > _LEVEL]
    load = np.r_[np.zeros(turning.shape[1]), [lug.size for lug in lugs]]
    problem = CondensedContact(flexibility, np.column_stack([turning, moves]))
    state = problem.solve(np.zeros(len(places)), load)
    return LineLoad(bar, lugs, hats, np.split(state.forces, np.cumsum(count)[:-1]))


def _beam(bar: RoundBar, hats: Sequence[Along]) -> FloatArray:
    """Flexibility (n, n), mm/N, of the pin as a beam held at its lowest hat."""
    nodes = np.concatenate([h.nodes for h in hats])
    start, stop = nodes.min(), nodes.max()
    inner = [c for c in bar.cuts if start < c < stop]
    cuts = np.unique(np.r_[nodes, inner])
    steps = np.diff(cuts)
    x = (cuts[:-1, None] + steps[:, None] * (1 + _GAUSS[0]) / 2).ravel()
    weight = (steps[:, None] * _GAUSS[1] / 2).ravel() / bar.youngs_modulus
    area = np.pi * bar.diameter(x) ** 2 / 4
    bent = np.concatenate([h.beyond(x, 1) for h in hats])
    sheared = np.concatenate([h.beyond(x, 0) for h in hats])
    found = (bent * (weight * 4 * np.pi / area**2)) @ bent.T
    found += (sheared * (weight * shear_of_bar(bar.poisson_ratio) / area)) @ sheared.T
    return np.asarray(found)


def wave_bed(bar: RoundBar, lug: Lug, hats: Along) -> FloatArray:
    """Flexibility (n, n), mm/N, of the bore and the pin's surface to a lug's hats of line load.

    The bore's waves are those whose faces do not move along the pin; the pin goes on beyond them.
    """
    radius = float(bar.diameter(np.array([(lug.low + lug.high) / 2]))[0]) / 2
    around = around_waves(bar, lug)
    own = np.pi / lug.width * np.arange(1.0, _ALONG + 1)
    cosines = hats.waves(own).real
    size = around @ bore_waves(_AROUND, own * radius, lug.poisson_ratio)
    found = (cosines * (2 / lug.width * size / (np.pi * lug.youngs_modulus))) @ cosines.T
    pins: FloatArray = np.pi / (2 * lug.width) * np.arange(0.5, 2 * _ALONG)
    both = hats.waves(pins)
    size = around @ local_bar_waves(_AROUND, pins * radius, bar.poisson_ratio)
    size = size / (2 * lug.width * np.pi * bar.youngs_modulus)
    return np.asarray(found + ((both * size) @ both.conj().T).real)


def around_waves(bar: RoundBar, lug: Lug) -> FloatArray:
    """Shares (_AROUND + 1,) with which waves around give way to a line load.

    Squares of its harmonics, half of the mean's: a line load q has the pressure
    q (w_0/2 + sum w_n cos(n a))/(pi R) and work with u_n is (w_0 u_0/2 + sum w_n u_n) q, w_1 = 1.
    """
    return _around(
        lug.clearance * lug.width / lug.size if lug.clearance > 0 else 0.0,
        (bar.youngs_modulus, bar.poisson_ratio),
        (lug.youngs_modulus, lug.poisson_ratio),
    )


@lru_cache(maxsize=64)
def _around(opening: float, pin: tuple[float, float], bore: tuple[float, float]) -> FloatArray:
    """By clearance over mean line load, mm2/N: a plane pin touches, then its arc is held."""
    hats = Hats.even(_HATS)
    flexibility = disc_flexibility(hats, 1.0, *pin, strain=True)
    flexibility += sheet_flexibility(hats, 1.0, *bore, strain=True)
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
