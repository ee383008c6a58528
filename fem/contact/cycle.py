"""Contact of a part's bores at every position of a cycle.

The pressure assumed in a bore is taken off the coefficients; what is left says how the bore opens
without it. The contact of all bores together is solved at each position, started from what touched
at the one before, turned with the force, or from Persson's arc about it. fem/contact/superposed.py
makes stress of it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy

from fem.contact.bore import BoreHarmonics
from fem.contact.condensed import CondensedContact, ContactError, ContactState, largest_misses
from fem.contact.cylinder_waves import Lining
from fem.contact.hats import Hats, disc_flexibility, lining_flexibility
from fem.contact.persson import persson_half_arc
from geometry.mesh import BoolArray, FloatArray, IntArray

_SMALL = 1e-9  # of the largest force: a bore that carries less carries nothing
_HATS_IN_ARC = 24  # of Persson's arc at the largest force, at least
_FEWEST, _MOST = 144, 720  # hats around a bore
_FEW = 8  # hats that touched: fewer are no start for the next position alone


@dataclass(frozen=True)
class FittedPin:
    """A pin in a bore.

    clearance       mm, on diameter; below 0 it is pressed in
    youngs_modulus  MPa
    poisson_ratio   1
    strain          True: its sections stay plane (a long pin); False: plane stress
    lining          the bush in the bore
    """

    clearance: float
    youngs_modulus: float
    poisson_ratio: float
    strain: bool = True
    lining: Lining | None = None


@dataclass(frozen=True, eq=False)
class BorePressure:
    """Pressure in one bore over the cycle.

    harmonics  of the bore
    hats       around the bore
    forces     (n_hats, n_positions) N of the hats
    pressures  (n_hats, n_positions) MPa at the hats' angles, even along the pin
    """

    harmonics: BoreHarmonics
    hats: Hats
    forces: FloatArray
    pressures: FloatArray

    def at(self, angles: FloatArray) -> FloatArray:
        """Pressure (n, n_positions) MPa at angles (n,) around the bore, rad."""
        left, right, share = self.hats.beside(angles)
        share = share[:, None]
        return np.asarray((1 - share) * self.pressures[left] + share * self.pressures[right])

    @cached_property
    def arcs(self) -> FloatArray:
        """Arc of contact (n_positions,), rad; 0 where nothing presses."""
        return np.array([self.hats.arc(column) for column in self.pressures.T])


@dataclass(frozen=True, eq=False)
class ContactCycle:
    """Contact of a part's bores over a cycle, or at some of its positions.

    bores              name -> pressure
    others             (n_basis, n_positions) coefficients of the part's unit loads without the
                       pressure that was assumed in these bores
    not_complementary  largest of all positions, scaled (ContactState)
    unbalanced         largest of all positions, scaled
    steps              equations solved, all positions together
    """

    bores: Mapping[str, BorePressure]
    others: FloatArray
    not_complementary: float
    unbalanced: float
    steps: int

    def over(self, positions: IntArray) -> "ContactCycle":
        """Some of its positions (m,) alone."""
        bores = {
            name: replace(
                bore, forces=bore.forces[:, positions], pressures=bore.pressures[:, positions]
            )
            for name, bore in self.bores.items()
        }
        return replace(self, bores=bores, others=self.others[:, positions])


class _Bore:
    """A bore of the part with its pin and its hats."""

    def __init__(
        self, harmonics: BoreHarmonics, pin: FittedPin, coefficients: FloatArray, finer: int
    ) -> None:
        self.name, self.pin, self.harmonics = harmonics.loads.interface.name, pin, harmonics
        self.columns = harmonics.pressing
        self.forces = coefficients[[self.columns[name] for name in ("cos 1", "sin 1")]]
        self.sizes = np.hypot(*self.forces)
        self.directions = np.arctan2(*self.forces[::-1])
        if not self.sizes.max(initial=0.0) > 0 and pin.clearance >= 0:
            raise ContactError(
                f"nothing presses in {self.name!r} at any position: its pin floats, and has no "
                "contact to be solved"
            )
        half = self.half_arc(float(self.sizes.max(initial=0.0)))
        count = int(np.ceil(_HATS_IN_ARC * np.pi / half / 12)) * 12
        self.hats = Hats.even(finer * min(max(count, _FEWEST), _MOST))
        self.waves = harmonics.waves(self.hats)

    def half_arc(self, force: float) -> float:
        """Half of the arc, rad, that a force N presses by Persson's theory."""
        if self.pin.clearance <= 0 or not force:
            return np.pi / 2
        material, pin = self.harmonics.solutions.material, self.pin
        softness = 1 / material.youngs_modulus + 1 / pin.youngs_modulus
        per_length = force / self.harmonics.loads.interface.length
        return persson_half_arc(pin.clearance / 2 / (softness * per_length))

    def start(self, position: int, last: int, before: BoolArray | None) -> BoolArray:
        """Hats that may touch at a position: those of the `last` one, turned, or Persson's."""
        if before is not None and before.any():
            turn = self.directions[position] - self.directions[last]
            hats = -round(turn / self.hats.widths[0]) % len(before)
            turned = np.concatenate([before[hats:], before[:hats]]) if hats else before
            if np.count_nonzero(turned) >= _FEW:
                return turned
            # a light force touched few hats, which may not hold a heavier one
            return np.asarray(turned | self._about(position, _FEW / 2 * self.hats.widths[0]))
        half = max(self.half_arc(self.sizes[position]), 2 * self.hats.widths[0])
        return self._about(position, half)

    def _about(self, position: int, half: float) -> BoolArray:
        """Hats up to some angle, rad, on both sides of the force."""
        away = np.cos(self.hats.angles - self.directions[position])
        return np.asarray(away >= np.cos(half) - 1e-12)

    @cached_property
    def flexibility(self) -> FloatArray:
        """Mean opening (n_hats, n_hats), mm/N, of bore, bush and pin per force on each hat."""
        pin, length = self.pin, self.harmonics.loads.interface.length
        found = self.harmonics.hat_flexibility(self.hats) + disc_flexibility(
            self.hats, length, pin.youngs_modulus, pin.poisson_ratio, strain=pin.strain
        )
        if pin.lining is not None:
            material = self.harmonics.solutions.material
            elastic = material.youngs_modulus, material.poisson_ratio
            found += lining_flexibility(self.hats, length, *elastic, pin.lining)
        return found

    @property
    def areas(self) -> FloatArray:
        """Area of each hat, mm2: its force over its pressure."""
        interface = self.harmonics.loads.interface
        return np.asarray(self.hats.extents * interface.radius * interface.length)


class PartContact:
    """Contact of pins in bores of one part: its flexibility once, then any of its positions.

    harmonics     of the bores, of one part
    coefficients  (n_basis, n_positions) of the part's unit loads, with any pressure in the bores
    pins          bore -> its pin
    finer         times as many hats as Persson's arc asks for
    lasting       bore -> (n_positions,) N of its even pressure that is no pin's but a pressed
                  bush's: it is in the stress and moves no gap between bush and pin

    Raises ContactError if a pin floats at all positions, ValueError without bores.
    """

    def __init__(
        self,
        harmonics: Sequence[BoreHarmonics],
        coefficients: FloatArray,
        pins: Mapping[str, FittedPin],
        finer: int = 1,
        lasting: Mapping[str, FloatArray] | None = None,
    ) -> None:
        if not harmonics:
            raise ValueError("contact needs at least one pin in a bore")
        self._bores = [
            _Bore(one, pins[one.loads.interface.name], coefficients, finer) for one in harmonics
        ]
        self._others = np.array(coefficients)
        for bore in self._bores:
            self._others[list(bore.columns.values())] = 0.0
        self._lasting = np.zeros_like(self._others)
        for bore in self._bores:
            self._lasting[bore.columns["cos 0"]] = (lasting or {}).get(bore.name, 0.0)
        self._limits = np.cumsum([0, *(len(b.hats.angles) for b in self._bores)])
        self._largest = max(float(bore.sizes.max(initial=0.0)) for bore in self._bores)
        self._problems: dict[tuple[int, ...], tuple[CondensedContact, IntArray]] = {}

    @cached_property
    def _flexibility(self) -> FloatArray:
        """Mean opening (all hats, all hats), mm/N, of each hat per force on each."""
        blocks = [
            [
                a.flexibility if a is b else a.waves @ a.harmonics.moved_by(b.harmonics) @ b.waves.T
                for b in self._bores
            ]
            for a in self._bores
        ]
        flexibility = np.block(blocks)
        return np.asarray((flexibility + flexibility.T) / 2)

    def solve(self, positions: Sequence[int] | None = None) -> ContactCycle:
        """Solve some positions in their order, each started from the one before; all by default.

        Raises ContactError if a position has no solution.
        """
        chosen = range(self._others.shape[1]) if positions is None else positions
        others = self._others[:, list(chosen)]
        opened = np.concatenate(
            [
                bore.waves @ (bore.harmonics.moved_by_loads @ others) + bore.pin.clearance / 2
                for bore in self._bores
            ]
        )
        forces, steps = np.zeros(opened.shape), 0
        solved: dict[tuple[int, ...], list[ContactState]] = {}
        before: list[BoolArray | None] = [None] * len(self._bores)
        last = -1
        for column, position in enumerate(chosen):
            pressed = self._pressed(position)
            if not pressed:
                before = [None] * len(self._bores)
                continue
            problem, at = self._problem(pressed)
            state = self._state(problem, pressed, opened[at, column], position, last, before)
            last = position
            forces[at, column] = state.forces
            before = [forces[a:b, column] > 0 for a, b in pairwise(self._limits)]
            solved.setdefault(pressed, []).append(state)
            steps += state.steps
        misses = [largest_misses(states) for states in solved.values()]
        complementary, unbalanced = np.max([(0.0, 0.0), *misses], axis=0).tolist()
        bores = {}
        for bore, (low, high) in zip(self._bores, pairwise(self._limits), strict=True):
            own = forces[low:high]
            pressures = own / bore.areas[:, None]
            bores[bore.name] = BorePressure(bore.harmonics, bore.hats, own, pressures)
        whole = others + self._lasting[:, list(chosen)]
        return ContactCycle(bores, whole, complementary, unbalanced, steps)

    def _pressed(self, position: int) -> tuple[int, ...]:
        """Numbers of the bores that a force, or a pin larger than its bore, presses."""
        return tuple(
            i
            for i, bore in enumerate(self._bores)
            if bore.sizes[position] > _SMALL * self._largest or bore.pin.clearance < 0
        )

    def _problem(self, pressed: tuple[int, ...]) -> tuple[CondensedContact, IntArray]:
        """The contact of some bores, and which of all hats are theirs."""
        if pressed not in self._problems:
            limits = self._limits
            at = np.concatenate([np.arange(limits[i], limits[i + 1]) for i in pressed])
            arms = scipy.linalg.block_diag(*(self._bores[i].hats.directions for i in pressed))
            problem = CondensedContact(self._flexibility[np.ix_(at, at)], arms)
            self._problems[pressed] = problem, at
        return self._problems[pressed]

    def _state(
        self,
        problem: CondensedContact,
        pressed: tuple[int, ...],
        opened: FloatArray,
        position: int,
        last: int,
        before: Sequence[BoolArray | None],
    ) -> ContactState:
        load = np.concatenate([self._bores[i].forces[:, position] for i in pressed])
        start = np.concatenate([self._bores[i].start(position, last, before[i]) for i in pressed])
        try:
            return problem.solve(opened, load, start)
        except ContactError as error:
            names = ", ".join(self._bores[i].name for i in pressed)
            count = self._others.shape[1]
            raise ContactError(f"{names}, position {position + 1} of {count}: {error}") from error
