"""Holes and journals of a part that carry a pin of the machine: what presses in them."""

from dataclasses import dataclass, replace

from checks.design.data import Part
from checks.design.materials import Material
from checks.design.model import StackEntry
from checks.part.loaded_part import LoadedPart
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
