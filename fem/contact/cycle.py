"""Contact of a part's bores at every position of a cycle.

The pressure assumed in a bore is taken off the coefficients; what is left says how the bore opens
without it. The contact of all bores together is solved at each position, started from what touched
at the one before, turned with the force, or from Persson's arc about it. fem/contact/superposed.py
makes stress of it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fem.contact.bore import BoreHarmonics
from fem.contact.condensed import CondensedContact, ContactError
from fem.contact.hats import Hats, disc_flexibility
from fem.contact.persson import persson_half_arc
from fem.unit_solutions import UnitSolutions
from geometry.mesh import BoolArray, FloatArray

_SMALL = 1e-9  # of the largest force: a bore that carries less carries nothing
_HATS_IN_ARC = 24  # of Persson's arc at the largest force, at least
_FEWEST, _MOST = 144, 720  # hats around a bore


@dataclass(frozen=True)
class FittedPin:
    """A pin in a bore.

    clearance       mm, on diameter; below 0 it is pressed in
    youngs_modulus  MPa
    poisson_ratio   1
    strain          True: its sections stay plane (a long pin); False: plane stress
    """

    clearance: float
    youngs_modulus: float
    poisson_ratio: float
    strain: bool = True


@dataclass(frozen=True, eq=False)
class BorePressure:
    """Pressure in one bore over the cycle.

    harmonics  of the bore
    hats       around the bore
    forces     (n_hats, n_positions) N of the hats
    pressures  (n_hats, n_positions) MPa at the hats' angles, even along the pin
    arcs       (n_positions,) rad, 0 where nothing presses
    """

    harmonics: BoreHarmonics
    hats: Hats
    forces: FloatArray
    pressures: FloatArray
    arcs: FloatArray


@dataclass(frozen=True, eq=False)
class ContactCycle:
    """Contact of a part's bores over a cycle.

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


class _Bore:
    """A bore of the part with its pin and its hats."""

    def __init__(self, harmonics: BoreHarmonics, pin: FittedPin, coefficients: FloatArray) -> None:
        self.name, self.pin, self.harmonics = harmonics.loads.interface.name, pin, harmonics
        self.columns = harmonics.pressing
        self.forces = coefficients[[self.columns[name] for name in ("cos 1", "sin 1")]]
        self.sizes = np.hypot(*self.forces)
        if not self.sizes.max(initial=0.0) > 0 and pin.clearance >= 0:
            raise ContactError(
                f"nothing presses in {self.name!r} at any position: its pin floats, and has no "
                "contact to be solved"
            )
        half = self.half_arc(float(self.sizes.max(initial=0.0)))
        count = int(np.ceil(_HATS_IN_ARC * np.pi / half / 12)) * 12
        self.hats = Hats.even(min(max(count, _FEWEST), _MOST))
        self.waves = harmonics.waves(self.hats)

    def half_arc(self, force: float) -> float:
        """Half of the arc, rad, that a force N presses by Persson's theory."""
        if self.pin.clearance <= 0 or not force:
            return np.pi / 2
        material, pin = self.harmonics.solutions.material, self.pin
        softness = 1 / material.youngs_modulus + 1 / pin.youngs_modulus
        per_length = force / self.harmonics.loads.interface.length
        return persson_half_arc(pin.clearance / 2 / (softness * per_length))

    def start(self, position: int, before: BoolArray | None) -> BoolArray:
        """Hats that may touch at a position: those of the position before, turned, or Persson's."""
        x, y = self.forces[:, position]
        if before is not None and before.any():
            turn = np.arctan2(y, x) - np.arctan2(*self.forces[::-1, position - 1])
            return np.roll(before, round(turn / self.hats.widths[0]))
        half = max(self.half_arc(self.sizes[position]), 2 * self.hats.widths[0])
        away = np.cos(self.hats.angles - np.arctan2(y, x))
        return np.asarray(away >= np.cos(half) - 1e-12)

    @property
    def areas(self) -> FloatArray:
        """Area of each hat, mm2: its force over its pressure."""
        interface = self.harmonics.loads.interface
        return np.asarray(self.hats.extents * interface.radius * interface.length)


def solve_contact(
    harmonics: Sequence[BoreHarmonics],
    coefficients: FloatArray,
    pins: Mapping[str, FittedPin],
) -> ContactCycle:
    """Solve the contact of pins in bores of one part at all positions.

    harmonics     of the bores, of one part
    coefficients  (n_basis, n_positions) of the part's unit loads, with any pressure in the bores
    pins          bore -> its pin

    Raises ContactError if a position has no solution or a pin floats at all of them, ValueError
    without bores.
    """
    if not harmonics:
        raise ValueError("contact needs at least one pin in a bore")
    bores = [_Bore(one, pins[one.loads.interface.name], coefficients) for one in harmonics]
    others = np.array(coefficients)
    for bore in bores:
        others[list(bore.columns.values())] = 0.0
    forces, worst, steps = _solve_cycle(harmonics[0].solutions, bores, others)
    limits = np.cumsum([0, *(len(b.hats.angles) for b in bores)])
    pressures = {}
    for bore, (low, high) in zip(bores, pairwise(limits), strict=True):
        own = forces[low:high]
        arcs = np.array([bore.hats.arc(column) for column in (own / bore.areas[:, None]).T])
        pressures[bore.name] = BorePressure(
            bore.harmonics, bore.hats, own, own / bore.areas[:, None], arcs
        )
    return ContactCycle(pressures, others, worst[0], worst[1], steps)


def _solve_cycle(
    part: UnitSolutions, bores: list[_Bore], others: FloatArray
) -> tuple[FloatArray, tuple[float, float], int]:
    """Forces (all hats, n_positions), worst complementarity and balance, and steps."""
    blocks = [
        [
            a.harmonics.hat_flexibility(a.hats)
            + disc_flexibility(
                a.hats,
                a.harmonics.loads.interface.length,
                a.pin.youngs_modulus,
                a.pin.poisson_ratio,
                strain=a.pin.strain,
            )
            if a is b
            else a.waves @ a.harmonics.moved_by(b.harmonics.displacement) @ b.waves.T
            for b in bores
        ]
        for a in bores
    ]
    flexibility = np.block(blocks)
    flexibility = (flexibility + flexibility.T) / 2
    limits = np.cumsum([0, *(len(b.hats.angles) for b in bores)])
    n = others.shape[1]
    opened = np.concatenate(
        [
            bore.waves @ (bore.harmonics.moved_by(part.displacement) @ others)
            + bore.pin.clearance / 2
            for bore in bores
        ]
    )
    found, complementary, unbalanced, steps = np.zeros((limits[-1], n)), 0.0, 0.0, 0
    largest = max(float(bore.sizes.max(initial=0.0)) for bore in bores)
    problems: dict[tuple[int, ...], tuple[CondensedContact, FloatArray]] = {}
    before: list[BoolArray | None] = [None] * len(bores)
    for position in range(n):
        pressed = tuple(
            i
            for i, bore in enumerate(bores)
            if bore.sizes[position] > _SMALL * largest or bore.pin.clearance < 0
        )
        if not pressed:
            before = [None] * len(bores)
            continue
        if pressed not in problems:
            at = np.concatenate([np.arange(limits[i], limits[i + 1]) for i in pressed])
            arms = np.zeros((len(at), 2 * len(pressed)))
            row = 0
            for k, i in enumerate(pressed):
                count = len(bores[i].hats.angles)
                arms[row : row + count, 2 * k : 2 * k + 2] = bores[i].hats.directions
                row += count
            problems[pressed] = CondensedContact(flexibility[np.ix_(at, at)], arms), at
        problem, at = problems[pressed]
        load = np.concatenate([bores[i].forces[:, position] for i in pressed])
        start = np.concatenate([bores[i].start(position, before[i]) for i in pressed])
        try:
            state = problem.solve(opened[at, position], load, start)
        except ContactError as error:
            names = ", ".join(bores[i].name for i in pressed)
            raise ContactError(f"{names}, position {position + 1} of {n}: {error}") from error
        found[at, position] = state.forces
        before = [found[low:high, position] > 0 for low, high in pairwise(limits)]
        complementary = max(complementary, state.not_complementary)
        unbalanced = max(unbalanced, state.unbalanced)
        steps += state.steps
    return found, (complementary, unbalanced), steps
