"""Holes and journals of a part that carry a pin of the machine: what presses in them."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from checks.design.data import Part
from checks.design.materials import Material
from checks.design.model import StackEntry
from checks.part.derived import Band, Series
from checks.part.loaded_part import LoadedPart
from checks.result.derivation import Given, Item, Step
from geometry.mesh import Interface
from geometry.parts.pin import as_pin

_ROUND = ("bore", "journal")


@dataclass(frozen=True)
class Lug:
    """A hole: what presses in it, mm, and the weaker of both.

    diameter, width  of the pin where it bears in the hole itself, else of the hole and its bush
    softer           the part's material, or the bare pin's if that yields first
    """

    interface: str
    diameter: float
    width: float
    softer: Material
    note: str


def lugs_of(loaded: LoadedPart) -> list[Lug]:
    """Return the holes and journals of a part that carry a pin of the machine; none of a pin."""
    part = loaded.part
    if part.body is None:
        return []
    return [
        _lug(loaded, interface)
        for name, interface in loaded.measurable.interfaces.items()
        if interface.kind in _ROUND and name in part.interfaces
    ]


def _lug(loaded: LoadedPart, interface: Interface) -> Lug:
    """A hole or journal, and in a hole the pin of the design that is in it, if it has its part."""
    part = loaded.part
    whole = Lug(interface.name, 2 * interface.radius, interface.length, part.material, "")
    pin = _pin_in(loaded, part.interfaces[interface.name])
    if interface.kind != "bore" or pin is None:
        return whole
    shape, entry = as_pin(pin.geometry), _entry(pin, part)
    assert shape is not None
    count = 2 if entry.at and not entry.single else 1
    if entry.bush is not None:
        return replace(whole, width=min(whole.width, count * entry.bush.length))
    diameter = min(whole.diameter, entry.diameter or shape.diameter)
    softer = min(part.material, pin.material, key=lambda material: material.yield_stress)
    told = f"pin of {diameter:g} mm in a hole of {whole.diameter:g} mm"
    return replace(
        whole,
        diameter=diameter,
        width=min(whole.width, count * entry.width),
        softer=softer,
        note=told if diameter < whole.diameter else "",
    )


def _pin_in(loaded: LoadedPart, point: str) -> Part | None:
    """The part of the pin at a point of a part, if the design has it and the part a lug on it."""
    for other in loaded.design.parts.values():
        lugs = {entry.body for entry in other.stack}
        if other.joint == point and loaded.part.body in lugs:
            return other
    return None


def _entry(pin: Part, part: Part) -> StackEntry:
    return next(entry for entry in pin.stack if entry.body == part.body)


# Bushes of a pin: which lugs have them, and how a pair shares the load.

# A pair of lugs shares the load evenly only if nothing is out of square; ASSUMED band.
SHARE_BAND = 0.05


@dataclass(frozen=True)
class BushOnPin:
    """A bush, or a pair of equal ones, in a lug of a pin.

    name       what turns in it: a body, or a force
    diameter   mm, of the pin
    length     mm, of one bush
    count      how many share the load
    allowable  MPa
    pv         MPa mm/s, allowable pressure times speed; None where it is not stated
    """

    name: str
    diameter: float
    length: float
    count: int
    allowable: float
    pv: float | None

    @property
    def note_on_sharing(self) -> str:
        """How a pair shares the load, in words."""
        return "; 50 to 52.5 % of the load in one bush of the pair" if self.count == 2 else ""


def bushes_of(part: Part) -> Iterator[BushOnPin]:
    """Bushes in the stack of a pin, in its order; none of another part."""
    shape = as_pin(part.geometry)
    for entry in part.stack:
        if entry.bush is None or shape is None:
            continue
        yield BushOnPin(
            entry.name,
            entry.diameter or shape.diameter,
            entry.bush.length,
            2 if entry.at and not entry.single else 1,
            entry.bush.allowable,
            entry.bush.pv,
        )


def pressure_on(loaded: LoadedPart, bush: BushOnPin) -> list[Series | Item]:
    """Formulas of the mean pressure p of one bush on its projected area."""
    force = loaded.loads.resultant(bush.name)
    design = "the design"
    return [
        Series("F", f"force of {bush.name} on the pin", force, "N", main=True),
        Given("m", "bushes that share it", float(bush.count), "", design),
        Given("d", "diameter of the pin", bush.diameter, "mm", design),
        Given("l", "length of a bush", bush.length, "mm", design),
        Step("p", "mean pressure on the projected area", "F/(m*d*l)", "MPa",
             "docs/theory/fits.md", main=True),
    ]  # fmt: skip


def uneven_share(bush: BushOnPin, value: str, unit: str) -> Band:
    """The model band of a value of one bush of a pair."""
    if bush.count == 1:
        return Band()
    said = "share that one of a pair may take beyond its half"
    above = (
        Given("s", said, SHARE_BAND, "", "assumed"),
        Step("b_up", "model band above", f"s*{value}", unit),
    )
    return Band(above, words="a pair shares the load evenly only if nothing is askew")
