"""A judged stress where bent pins press unevenly along a part's bores."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np

from checks.design.data import Part
from checks.part.part_loads import PartLoads, first_largest
from checks.part.pressed_along import Stack, most_pressed, why_even
from checks.stress.judged import Judged, StaticPeak, Under
from checks.stress.pins_in_bores import LEAST, MIDDLE, Contact
from checks.stress.solid_mesh_level import Level
from fem.contact.bore import BoreHarmonics
from fem.contact.cycle import BorePressure
from fem.contact.uneven import BoreAlong
from geometry.mesh import FloatArray


@dataclass(frozen=True)
class Setting:
    """How pins are set as a stress is asked for.

    share   of the range of clearances, at which the even contact is solved
    bends   the same, at which pins bend: the least clearance bends them most
    factor  on all loads; stresses are over it (`Contact`)
    """

    share: float = MIDDLE
    bends: float = LEAST
    factor: float = 1.0


AS_JUDGED = Setting()


@dataclass(frozen=True)
class BeyondEven:
    """A judged stress under pressure that is uneven along the pins.

    even, uneven  MPa, the quantity at the positions that decide it; uneven as the band has it
    bent          MPa, the same with all bent pins, those that count in no band included
    words         how uneven the pressure is, at which edges, and what does not count
    """

    even: float
    uneven: float
    bent: float
    words: str

    @property
    def above(self) -> float:
        """How far it lies above, MPa."""
        return max(self.uneven - self.even, 0.0)

    @property
    def below(self) -> float:
        """How far it lies below, MPa."""
        return max(self.even - self.uneven, 0.0)


def beyond_even(
    judged: Judged, level: Level, part: Part, at: Setting = AS_JUDGED
) -> BeyondEven | None:
    """The quantity under uneven pressure, at the positions that decide it under an even one.

    part  states how the edges of its bores are

    None where no bore has a pin whose stack is known, or all carry nothing.
    """
    contact = level.contact
    if contact is None:
        return None
    static = isinstance(judged, StaticPeak)
    why = {
        (name := bore.loads.interface.name): why_even(
            part, name, stack, static=static, factor=at.factor
        )
        for bore, stack in known_stacks(contact)
    }
    if not why:
        return None
    known = _known.setdefault(level, WeakKeyDictionary()).setdefault(judged, {})
    asked = (at, tuple(sorted(why.items())))
    if asked not in known:
        known[asked] = _beyond(judged, level, contact, why, at)
    return known[asked]


def _beyond(
    judged: Judged, level: Level, contact: Contact, why: Mapping[str, str], at: Setting
) -> BeyondEven | None:
    """Uneven pressure; why: bore -> why its bent pin counts in no band, "" where it does."""
    positions = (unevenness(contact, position) for position in judged.deciding(level))
    told = next((words for words in positions if words), {})
    counts = frozenset(name for name in told if not why[name])
    if not told:
        return None
    even, bent = judged.direct(level, [0.0, 1.0], _under(frozenset(why), at))
    uneven = even
    if counts == told.keys():
        uneven = bent
    elif counts:
        (uneven,) = judged.direct(level, [1.0], _under(counts, at))
    words = []
    if counts:
        by = ", ".join(told[name] for name in why if name in counts)
        words.append(f"its pin bends, which presses {by}; {uneven:.4g} MPa")
    words += [
        f"not in the band: its pin bends, which presses {told[name]}: {reason}; elastic, with it, "
        f"{bent:.4g} MPa"
        for name, reason in why.items()
        if name in told and reason
    ]
    return BeyondEven(even, uneven, bent, "; ".join(words))


def unevenness(contact: Contact, position: int) -> dict[str, str]:
    """By bore, where a bent pin presses most at a position, in words; of stacks that are known."""
    found = {}
    for bore, stack in known_stacks(contact):
        shares = _shares(contact, bore, stack, position, AS_JUDGED)
        if shares is not None:
            name = bore.loads.interface.name
            most, edge = most_pressed(shares)
            found[name] = f"up to {most:.3g} times the mean at the {edge} of {name}"
    return found


_Asked = tuple[Setting, tuple[tuple[str, str], ...]]
_known: WeakKeyDictionary[Level, WeakKeyDictionary[Judged, dict[_Asked, BeyondEven | None]]] = (
    WeakKeyDictionary()
)


def known_stacks(contact: Contact) -> list[tuple[BoreHarmonics, Stack]]:
    """Bores whose pin's stack is known and has as many lugs of the part as the bore."""
    found = []
    for bore in contact.pins.harmonics:
        stack = contact.pins.fits[bore.loads.interface.name].stack
        if stack is not None and stack.paired == BoreAlong(bore).paired:
            found.append((bore, stack))
    return found


def _shares(
    contact: Contact, bore: BoreHarmonics, stack: Stack, position: int, at: Setting
) -> FloatArray | None:
    """The a_k (n,) of the line load in a bore; None where nothing presses there."""
    name = bore.loads.interface.name
    forces = contact.cycle.bores[name].forces.sum(axis=0)
    if not forces[position] > 0:
        return None
    heaviest = int(first_largest(forces)[0])
    lugs, own = stack.lugs(heaviest, 0.0)
    if own < 0:
        return None
    tilt = bore.once(
        "tilt", stack, lambda: np.array([BoreAlong(bore).tilt(
            stack.bar, lugs[own], _waves(bore, contact.cycle.bores[name], heaviest))])
    )  # fmt: skip
    clearance = contact.pins.fits[name].clearance(at.bends) / at.factor
    return replace(stack, clearance=clearance).shares(position, float(tilt[0]))


def _waves(bore: BoreHarmonics, pressed: BorePressure, position: int) -> FloatArray:
    """Long waves (2 last + 1,), N, of the even pressure in a bore."""
    return np.asarray(bore.waves(pressed.hats).T @ pressed.forces[:, position])


def _under(names: frozenset[str], at: Setting) -> Under:
    """Stress with shares of what uneven pressure in some bores adds."""

    def under(
        _loads: PartLoads, level: Level, position: int, numbers: Sequence[float]
    ) -> FloatArray:
        """Stress (n, 6, m) at a position."""
        even, added = _even(level, position, at), _added(level, position, names, at)
        return np.stack([even + share * added for share in numbers], axis=-1)

    return under


def _even(level: Level, position: int, at: Setting) -> FloatArray:
    """Stress (n, 6) under even pressure at a position, MPa."""
    contact, here = level.contact, np.array([position])
    assert contact is not None
    if contact.is_middle(at.share) and at.factor == 1.0:
        return level.history.at(position)
    basis = level.history.basis
    stress = np.asarray(basis @ contact.solutions.state(contact.over(here, at.share, at.factor)))
    contact.add_short_waves(stress, np.arange(len(basis)), here, at.share, at.factor)
    return stress[:, :, 0]


def _added(level: Level, position: int, names: frozenset[str], at: Setting) -> FloatArray:
    """Stress (n, 6) that uneven pressure in some bores adds at a position, solved once, MPa."""
    known = level.direct_stresses.setdefault(f"along {sorted(names)} {at}".encode(), {})
    if position in known:
        return known[position]
    contact = level.contact
    assert contact is not None
    vector = np.zeros(3 * len(level.solutions.mesh.nodes))
    short = np.zeros((len(level.history.nodes), 6))
    even = contact.over(np.array([position]), at.share, at.factor)
    for bore, stack in known_stacks(contact):
        shares = _shares(contact, bore, stack, position, at)
        if shares is None or bore.loads.interface.name not in names:
            continue
        along = BoreAlong(bore)
        pressed = even.bores[bore.loads.interface.name]
        vector += along.vector(_waves(bore, pressed, 0), shares)
        pressure = bore.short_waves(pressed.hats, pressed.forces)[:, 0]
        short[bore.points] += along.short_wave_stress(pressure, shares)
    moved = level.solutions.solve(vector[:, None])
    known[position] = level.stress_of(moved)[:, :, 0] + short
    return known[position]
