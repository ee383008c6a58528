"""Buckling of straight bars out of the plane in which they are loaded: bent aside and twisted.

A section moves aside by w and twists by t, so that a point y beside the bar's axis moves aside by
w + y t. The bar's energy is 1/2 integral B w''^2 + C t'^2 + D t''^2, D the warping of a plate that
twists, whose fibres along it bend: E b^3 t^3/144 of a plate b wide. The stress in it works

    1/2 integral [N (w'^2 + r^2 t'^2) - 2 M w' t' + 2 V w' t]

(Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., 5.3, 6.1 and 6.3; derived in
fem/frame.py). A pin's pressure keeps its direction and stays at its points of the bore.
With the sums T_xx, T_xy, T_yy of place times force, from the pin's axis, a bore that turns as a
whole adds 1/2 (T_xx w'^2 + 2 T_xy w' t + T_yy t^2) (docs/theory/rungs.md).

Members have cubics for w and t between their nodes, so that shares come from below: by less than
1e-3 with four members along a wave.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import pi

import numpy as np

from fem.buckling import leading_states, worst_position
from geometry.mesh import FloatArray

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_W, _T = np.array([0, 1, 4, 5]), np.array([2, 3, 6, 7])  # of a member's w, w', t, t' at both ends
_SAMPLED = 6  # every n-th section force measures the size of a load
_CLOSE = 0.999  # of the largest share: an estimate below that over it asks for no other position
_COUNT = 1  # modes of each state
_NONE = 1e-12  # of the largest eigenvalue: below it, round-off


@dataclass(frozen=True, eq=False)
class Stiffness:
    """Of a bar at places (m,).

    bending   N mm2, out of the plane
    twisting  N mm2, Saint-Venant's
    warping   N mm4
    gyration  mm2, polar second moment of area over the area
    """

    bending: FloatArray
    twisting: FloatArray
    warping: FloatArray
    gyration: FloatArray


@dataclass(frozen=True, eq=False)
class Acting:
    """Section forces (m, n) at a chain's points over n positions: N, N mm and N.

    The moment bends in the plane, -dM/dx is the shear; a pull is above 0.
    """

    axial: FloatArray
    moment: FloatArray
    shear: FloatArray

    def at(self, position: int) -> "Acting":
        """Those of one position."""
        here = slice(position, position + 1)
        return Acting(self.axial[:, here], self.moment[:, here], self.shear[:, here])


@dataclass(frozen=True, eq=False)
class Chain:
    """A straight bar along x, in members from node to node.

    nodes      (k,) mm, rising
    stiffness  at places (m,)
    beside     mm, y of its axis
    """

    nodes: FloatArray
    stiffness: Callable[[FloatArray], Stiffness]
    beside: float = 0.0

    @property
    def unknowns(self) -> int:
        """w/l, w', t and l t' at each node, l the chain's length: one unit for all keeps digits."""
        return 4 * len(self.nodes)

    @cached_property
    def points(self) -> FloatArray:
        """Gauss points (4 (k - 1),) at which section forces are asked, mm."""
        sizes = np.diff(self.nodes)[:, None]
        return np.asarray((self.nodes[:-1, None] + sizes * (1 + _POINTS) / 2).ravel())

    @cached_property
    def weights(self) -> FloatArray:
        """Lengths (m,) of the points, mm."""
        return np.asarray((np.diff(self.nodes)[:, None] * _WEIGHTS / 2).ravel())

    def rows(self, places: FloatArray, slopes: int) -> tuple[FloatArray, FloatArray]:
        """Rows (m, unknowns) that give w and t, or their first or second slopes, at places (m,)."""
        member = np.clip(np.searchsorted(self.nodes, places) - 1, 0, len(self.nodes) - 2)
        size = np.diff(self.nodes)[member]
        own = cubics((places - self.nodes[member]) / size, size, slopes)
        aside, twist = (np.zeros((len(places), self.unknowns)) for _ in range(2))
        row = np.arange(len(places))[:, None]
        length = float(np.ptp(self.nodes))
        aside[row, 4 * member[:, None] + _W] = own * np.array([length, 1.0, length, 1.0])
        twist[row, 4 * member[:, None] + _T] = own / np.array([1.0, length, 1.0, length])
        return aside, twist

    @cached_property
    def energy(self) -> FloatArray:
        """Elastic stiffness (unknowns, unknowns)."""
        own = self.stiffness(self.points)
        (_, rate), (bent, warped) = self.rows(self.points, 1), self.rows(self.points, 2)
        parts = ((bent, own.bending), (rate, own.twisting), (warped, own.warping))
        return np.asarray(sum((row.T * (self.weights * value)) @ row for row, value in parts))


def cubics(s: FloatArray, size: FloatArray, slopes: int) -> FloatArray:
    """Hermite's cubics (m, 4) at shares (m,) of members' sizes, mm, or their slopes along x."""
    if slopes == 0:
        found = (1 - 3 * s**2 + 2 * s**3, s - 2 * s**2 + s**3, 3 * s**2 - 2 * s**3, s**3 - s**2)
    elif slopes == 1:
        found = (6 * s**2 - 6 * s, 1 - 4 * s + 3 * s**2, 6 * s - 6 * s**2, 3 * s**2 - 2 * s)
    else:
        found = (12 * s - 6, 6 * s - 4, 6 - 12 * s, 6 * s - 2)
    turns = np.stack([np.ones_like(size), size, np.ones_like(size), size], axis=1)
    return np.asarray(np.stack(found, axis=1) * turns / size[:, None] ** slopes)


@dataclass(frozen=True, eq=False)
class Pressed:
    """A bore, or a flank, that is pressed.

    chain   number of its chain
    place   mm along it
    places  (3, n) N mm, sums of place times force over n positions: xx, xy and yy
    """

    chain: int
    place: float
    places: FloatArray

    def at(self, position: int) -> "Pressed":
        """That of one position."""
        return replace(self, places=self.places[:, position : position + 1])


def bore_pressure(radius: float, wrench: FloatArray) -> FloatArray:
    """Sums (3, n) of place times force on a bore, N mm: xx, xy, yy.

    wrench  (n, 6) N, N mm. A half cosine pressure has 8/(3 pi) F r along its force and 4/(3 pi) F r
            across: integrals of cos^3 and cos sin^2 over cos^2's. A couple comes from
            friction all round, half from forces along x and half along y; M alone has it from those
            along x, so half of it is added to xy (fem/frame.py).

    >>> force = np.array([[pi, 0.0, 0.0, 0.0, 0.0, 0.0]])
    >>> bool(np.allclose(bore_pressure(3.0, force)[:, 0], [8.0, 0.0, 4.0]))
    True
    """
    x, y, couple = wrench[:, 0], wrench[:, 1], wrench[:, 5]
    size = np.hypot(x, y)
    over = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    along, across = 8 / (3 * pi) * radius, 4 / (3 * pi) * radius
    xx, xy, yy = x * x * over, x * y * over, y * y * over
    crossed = (along - across) * xy + couple / 2
    return np.stack([along * xx + across * yy, crossed, along * yy + across * xx])


def spaced(nodes: FloatArray) -> FloatArray:
    """The same nodes, rising, without those nearer than 1e-3 of the whole: they cost digits.

    >>> spaced(np.array([0.0, 4.0, 1.0, 1.0001, 3.9999])).tolist()
    [0.0, 1.0, 4.0]
    """
    rising = np.unique(nodes)
    least = 1e-3 * (rising[-1] - rising[0])
    kept = [float(rising[0])]
    for node in rising[1:-1].tolist():
        if node - kept[-1] > least and rising[-1] - node > least:
            kept.append(node)
    return np.array([*kept, float(rising[-1])])


def interpolated(places: FloatArray, values: FloatArray, wanted: FloatArray) -> FloatArray:
    """Values (m, n) at places (m,) between those (k, n) at places (k,), the nearest beyond them.

    Of two values at one place each counts on its own side.
    """
    at = np.clip(np.searchsorted(places, wanted) - 1, 0, len(places) - 2)
    share = (wanted - places[at]) / (places[at + 1] - places[at])
    share = np.clip(share, 0.0, 1.0)[:, None]
    return np.asarray((1 - share) * values[at] + share * values[at + 1])


@dataclass(frozen=True, eq=False)
class LateralBar:
    """Chains, how they are held and joined.

    held    (chain, place): held sideways there; at the first one against twisting, too
    joined  (chain, place, branch): a branch beside the chain goes on from its section there
    tilts   False if forks hold it against tilting and twisting wherever it is held
    """

    chains: Sequence[Chain]
    held: Sequence[tuple[int, float]]
    joined: Sequence[tuple[int, float, int]] = field(default=())
    tilts: bool = True

    @cached_property
    def starts(self) -> list[int]:
        """Number of each chain's first unknown, and of all."""
        return [0, *np.cumsum([chain.unknowns for chain in self.chains]).tolist()]

    def _spread(self, chain: int, rows: FloatArray) -> FloatArray:
        """Rows of a chain's unknowns as rows of all."""
        found = np.zeros((len(rows), self.starts[-1]))
        found[:, self.starts[chain] : self.starts[chain + 1]] = rows
        return found

    def _at(self, chain: int, place: float, slopes: int) -> tuple[FloatArray, FloatArray]:
        aside, twist = self.chains[chain].rows(np.array([place]), slopes)
        return self._spread(chain, aside), self._spread(chain, twist)

    @cached_property
    def _conditions(self) -> FloatArray:
        rows = [self._at(chain, place, 0)[0] for chain, place in self.held]
        rows += [self._at(*at, 0)[1] for at in self.held[: 1 if self.tilts else None]]
        if not self.tilts:
            rows += [self._at(chain, place, 1)[0] for chain, place in self.held]
        for chain, place, branch in self.joined:
            arm = self.chains[branch].beside - self.chains[chain].beside
            (own, turned), (slope, rate) = self._at(chain, place, 0), self._at(chain, place, 1)
            (aside, twist), (sloped, _) = self._at(branch, place, 0), self._at(branch, place, 1)
            rows += [aside - own - arm * turned, sloped - slope - arm * rate, twist - turned]
        found = np.concatenate(rows)
        return np.asarray(found / np.linalg.norm(found, axis=1)[:, None])

    @cached_property
    def _free(self) -> FloatArray:
        """Motions (unknowns, k) that the supports allow, of unit strain energy and none between."""
        conditions = self._conditions
        free = np.linalg.qr(conditions.T, mode="complete")[0][:, len(conditions) :]
        energy = np.zeros((self.starts[-1],) * 2)
        for chain, start in zip(self.chains, self.starts, strict=False):
            own = slice(start, start + chain.unknowns)
            energy[own, own] = chain.energy
        lower = np.linalg.cholesky(free.T @ energy @ free)
        return np.asarray(np.linalg.solve(lower, free.T).T)

    @cached_property
    def _motions(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """w', t', t (m, k) at all chains' points by the free motions, and r^2 (m,)."""
        slopes, rates, twists, gyrations = (list[FloatArray]() for _ in range(4))
        for k, chain in enumerate(self.chains):
            slope, rate = chain.rows(chain.points, 1)
            _, twist = chain.rows(chain.points, 0)
            for rows, found in ((slope, slopes), (rate, rates), (twist, twists)):
                found.append(self._spread(k, rows) @ self._free)
            gyrations.append(chain.stiffness(chain.points).gyration)
        return (
            np.concatenate(slopes),
            np.concatenate(rates),
            np.concatenate(twists),
            np.concatenate(gyrations),
        )

    def worst_of_forks(
        self, acting: Sequence[Acting], pressed: Sequence[Pressed]
    ) -> tuple[float, int, float]:
        """As `worst`, and the share there with forks that hold it against tilting."""
        share, position = self.worst(acting, pressed)
        if not share > 0.0:
            return share, position, 0.0
        here = [one.at(position) for one in acting], [one.at(position) for one in pressed]
        held, _ = replace(self, tilts=False).worst(*here)
        return share, position, held

    def worst(self, acting: Sequence[Acting], pressed: Sequence[Pressed]) -> tuple[float, int]:
        """Largest share of its buckling load over all positions, and where; 0 where none buckles.

        acting  section forces of each chain
        """
        works, loads = self._works(acting, pressed)
        if not np.abs(loads).max(initial=0.0) > 0.0:
            return 0.0, 0

        def modes(state: FloatArray) -> tuple[float, FloatArray]:
            values, vectors = np.linalg.eigh(-works.of(state))
            size = float(np.abs(values).max())
            largest = max(float(values[-1]), 0.0) if values[-1] > _NONE * size else 0.0
            return largest, vectors[:, -_COUNT:]

        scale = np.full(len(loads), max(float(np.ptp(chain.nodes)) for chain in self.chains))
        count = len(works.slopes)
        scale[count : 2 * count] = 1.0  # moments as they are, forces times the length
        measure = np.diag(scale)[::_SAMPLED]
        states = leading_states(measure, loads)
        fields = [modes(sign * state)[1] for state in states for sign in (1.0, -1.0)]
        found = worst_position(
            lambda position: modes(loads[:, position]),
            lambda known: works.shares(known, loads),
            fields,
            close=_CLOSE,
        )
        return (0.0, 0) if found is None else (found[1], found[0])

    def mode(self, acting: Sequence[Acting], pressed: Sequence[Pressed]) -> "BentMode":
        """The lowest mode, of free size.

        acting, pressed  at one position
        """
        works, loads = self._works(acting, pressed)
        return BentMode(self, self._free @ np.linalg.eigh(-works.of(loads[:, 0]))[1][:, -1])

    def _works(
        self, acting: Sequence[Acting], pressed: Sequence[Pressed]
    ) -> tuple["_Works", FloatArray]:
        """Second-order work by the free motions, and the loads (rows, n) that it is of."""
        weights = np.concatenate([chain.weights for chain in self.chains])[:, None]
        slopes, rates, twists, gyration = self._motions
        loads = np.concatenate(
            [
                weights * np.concatenate([getattr(one, name) for one in acting])
                for name in ("axial", "moment", "shear")
            ]
            + [one.places for one in pressed]
        )
        tilts, turns = (
            np.concatenate(
                [self._at(one.chain, one.place, n)[1 - n] @ self._free for one in pressed]
            )
            if pressed
            else np.zeros((0, slopes.shape[1]))
            for n in (1, 0)
        )
        return _Works(slopes, rates, twists, gyration, tilts, turns), loads


@dataclass(frozen=True, eq=False)
class BentMode:
    """A motion of chains that are bent aside and twisted, by their unknowns (k,)."""

    bar: LateralBar
    unknowns: FloatArray

    def at(self, chain: int, places: FloatArray, slopes: int = 0) -> tuple[FloatArray, FloatArray]:
        """Motions w and t (m,), or their first slopes, at places (m,) of a chain."""
        start = self.bar.starts[chain]
        own = self.unknowns[start : start + self.bar.chains[chain].unknowns]
        aside, twist = self.bar.chains[chain].rows(places, slopes)
        return aside @ own, twist @ own

    def moved(self, chain: int, nodes: FloatArray) -> FloatArray:
        """Displacements (n, 3) of nodes (n, 3) mm of a plate whose middle plane is a chain's.

        Kirchhoff's: a point y beside the chain and z off its plane has w + y t aside, and moves
        within the plate by -z times the slopes of that.
        """
        x, y, z = nodes.T
        beside = y - self.bar.chains[chain].beside
        aside, twist = self.at(chain, x)
        slope, rate = self.at(chain, x, 1)
        return np.stack([-z * (slope + beside * rate), -z * twist, aside + beside * twist], axis=1)


@dataclass(frozen=True, eq=False)
class _Works:
    """Second-order work of the loads, by the free motions: of w', t', t and of pressed bores."""

    slopes: FloatArray
    rates: FloatArray
    twists: FloatArray
    gyration: FloatArray
    tilts: FloatArray
    turns: FloatArray

    def of(self, state: FloatArray, motions: FloatArray | None = None) -> FloatArray:
        """Form (k, k) of a load state."""
        axial, moment, shear, pressed = self._parts(state[:, None])
        a, b, c, tilt, turn = self._moved(motions)
        xx, xy, yy = pressed[..., 0]
        crossed = a.T @ (-moment * b + shear * c) + tilt.T @ (xy[:, None] * turn)
        form = a.T @ (axial * a) + b.T @ (axial * self.gyration[:, None] * b)
        form += tilt.T @ (xx[:, None] * tilt) + turn.T @ (yy[:, None] * turn)
        return np.asarray(form + crossed + crossed.T)

    def shares(self, known: FloatArray, loads: FloatArray) -> FloatArray:
        """Share (n,) of each position's load among known fields (k, j)."""
        own = np.linalg.qr(known)[0]
        a, b, c, tilt, turn = self._moved(own)
        axial, moment, shear, (xx, xy, yy) = self._parts(loads)

        def summed(first: FloatArray, second: FloatArray, weight: FloatArray) -> FloatArray:
            size = first.shape[1] * second.shape[1]
            pairs = (first[:, :, None] * second[:, None]).reshape(len(first), size)
            return np.asarray((weight.T @ pairs).reshape(-1, first.shape[1], second.shape[1]))

        crossed = summed(a, b, -moment) + summed(a, c, shear) + summed(tilt, turn, xy)
        forms = summed(a, a, axial) + summed(b, b, axial * self.gyration[:, None])
        forms += summed(tilt, tilt, xx) + summed(turn, turn, yy)
        forms += crossed + crossed.swapaxes(1, 2)
        return np.asarray(np.maximum(np.linalg.eigvalsh(-forms)[:, -1], 0.0))

    def _parts(self, loads: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        count = len(self.slopes)
        axial, moment, shear = (loads[k * count : (k + 1) * count] for k in range(3))
        pressed = loads[3 * count :].reshape(len(self.tilts), 3, loads.shape[1]).swapaxes(0, 1)
        return axial, moment, shear, pressed

    def _moved(self, motions: FloatArray | None) -> tuple[FloatArray, ...]:
        rows = (self.slopes, self.rates, self.twists, self.tilts, self.turns)
        return rows if motions is None else tuple(row @ motions for row in rows)
