"""A judged stress where bent pins press unevenly along a part's bores."""

from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from checks.part.part_loads import PartLoads, first_largest
from checks.part.pressed_along import Stack, most_pressed
from checks.stress.judged import Judged
from checks.stress.pins_in_bores import Contact
from checks.stress.solid_mesh_level import Level
from fem.contact.bore import BoreHarmonics
from fem.contact.uneven import BoreAlong
from geometry.mesh import FloatArray


@dataclass(frozen=True)
class BeyondEven:
    """A judged stress under pressure that is uneven along the pins.

    even, uneven  MPa, the quantity at the positions that decide it
    words         how uneven the pressure is, at which edges
    """

    even: float
    uneven: float
    words: str

    @property
    def above(self) -> float:
        """How far it lies above, MPa."""
        return max(self.uneven - self.even, 0.0)

    @property
    def below(self) -> float:
        """How far it lies below, MPa."""
        return max(self.even - self.uneven, 0.0)


def beyond_even(judged: Judged, level: Level) -> BeyondEven | None:
    """The quantity under uneven pressure, at the positions that decide it under an even one.

    None where no bore has a pin whose stack is known, or all carry nothing.
    """
    contact = level.contact
    if contact is None:
        return None
    bores = [bore for bore, _ in known_stacks(contact)]
    if not bores:
        return None
    known = _known.setdefault(level, WeakKeyDictionary())
    if judged not in known:
        even, uneven = judged.direct(level, [0.0, 1.0], _under)
        said = (unevenness(contact, position) for position in judged.deciding(level))
        told = next((words for words in said if words), {})
        by = ", ".join(told[name] for bore in bores if (name := bore.loads.interface.name) in told)
        words = f"its pin bends, which presses {by}; {uneven:.4g} MPa"
        known[judged] = BeyondEven(even, uneven, words) if by else None
    return known[judged]


def unevenness(contact: Contact, position: int) -> dict[str, str]:
    """By bore, where a bent pin presses most at a position, in words; of stacks that are known."""
    found = {}
    for bore, stack in known_stacks(contact):
        shares = _shares(contact, bore, stack, position)
        if shares is not None:
            name = bore.loads.interface.name
            most, edge = most_pressed(shares)
            found[name] = f"up to {most:.3g} times the mean at the {edge} of {name}"
    return found


_known: WeakKeyDictionary[Level, WeakKeyDictionary[Judged, BeyondEven | None]] = WeakKeyDictionary()


def known_stacks(contact: Contact) -> list[tuple[BoreHarmonics, Stack]]:
    """Bores whose pin's stack is known and has as many lugs of the part as the bore."""
    found = []
    for bore in contact.pins.harmonics:
        stack = contact.pins.fits[bore.loads.interface.name].stack
        if stack is not None and stack.paired == BoreAlong(bore).paired:
            found.append((bore, stack))
    return found


def _shares(
    contact: Contact, bore: BoreHarmonics, stack: Stack, position: int
) -> FloatArray | None:
    """The a_k (n,) of the line load in a bore; None where nothing presses there."""
    forces = contact.cycle.bores[bore.loads.interface.name].forces.sum(axis=0)
    if not forces[position] > 0:
        return None
    heaviest = int(first_largest(forces)[0])
    lugs, own = stack.lugs(heaviest, 0.0)
    if own < 0:
        return None
    tilt = bore.once(
        "tilt", stack, lambda: np.array([BoreAlong(bore).tilt(
            stack.bar, lugs[own], _waves(contact, bore, heaviest))])
    )  # fmt: skip
    return stack.shares(position, float(tilt[0]))


def _waves(contact: Contact, bore: BoreHarmonics, position: int) -> FloatArray:
    """Long waves (2 last + 1,), N, of the even pressure in a bore."""
    pressed = contact.cycle.bores[bore.loads.interface.name]
    return np.asarray(bore.waves(pressed.hats).T @ pressed.forces[:, position])


def _under(_loads: PartLoads, level: Level, position: int, numbers: Sequence[float]) -> FloatArray:
    """Stress (n, 6, m) at a position with shares of what uneven pressure adds."""
    even, added = level.history.at(position), _added(level, position)
    return np.stack([even + share * added for share in numbers], axis=-1)


def _added(level: Level, position: int) -> FloatArray:
    """Stress (n, 6) that uneven pressure adds at a position, solved once, MPa."""
    known = level.direct_stresses.setdefault(b"along", {})
    if position in known:
        return known[position]
    contact = level.contact
    assert contact is not None
    vector = np.zeros(3 * len(level.solutions.mesh.nodes))
    short = np.zeros((len(level.history.nodes), 6))
    for bore, stack in known_stacks(contact):
        shares = _shares(contact, bore, stack, position)
        if shares is None:
            continue
        along = BoreAlong(bore)
        pressed = contact.cycle.bores[bore.loads.interface.name]
        vector += along.vector(_waves(contact, bore, position), shares)
        pressure = bore.short_waves(pressed.hats, pressed.forces[:, [position]])[:, 0]
        short[bore.points] += along.short_wave_stress(pressure, shares)
    moved = level.solutions.solve(vector[:, None])
    known[position] = level.stress_of(moved)[:, :, 0] + short
    return known[position]
