"""Bushes of the pins' stacks that state how they are pressed in, at the bores they are in."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import inf

from checks.design.data import Part
from checks.design.errors import Problems
from checks.design.model import Bush, StackEntry
from checks.handbook.fits import LARGEST, LEAST, PressFit, interferences_of, ring_flexibility
from geometry.mesh import Interface
from geometry.parts.pin import as_pin

_MOST = 0.01  # of the bore's diameter: more is a mistake in the unit


def with_press_fits(parts: Mapping[str, Part], problems: Problems) -> dict[str, Part]:
    """Return the parts with the bushes that are pressed into their bores.

    A bush that is pressed in is narrower inside: the clearances of its pin are those that are left.
    """
    found, sound = dict(parts), not problems
    for pin in parts.values():
        for index, entry in enumerate(pin.stack):
            if entry.bush is None or entry.bush.fit is None:
                continue
            key, told = f"parts.{pin.name}.stack[{index}].bush", len(problems)
            if entry.bush.material is None:
                problems.add(
                    f"{key}.material",
                    "must be stated where the fit of the bush in its lug is: the pressure between "
                    "them depends on it",
                )
            bores = list(_bores(pin, entry, parts))
            if not bores and sound:  # a part that is not understood may have it
                problems.add(
                    f"{key}.fit",
                    f"no part of the design has the bore of {entry.name} at {pin.joint} that the "
                    "bush is pressed into; leave it out",
                )
            for part, bore in bores if len(problems) == told else ():
                fit = _fit(pin, entry, entry.bush, bore, f"{key}.fit", problems)
                if fit is not None:
                    found[part.name] = _pressed(found[part.name], bore.name, fit, problems)
    return found


def _bores(
    pin: Part, entry: StackEntry, parts: Mapping[str, Part]
) -> Iterator[tuple[Part, Interface]]:
    """The parts with a bore for an entry of a pin's stack."""
    for part in parts.values():
        if entry.body is not None and part.body == entry.body:
            for face in part.geometry.placed_interfaces:
                if face.kind == "bore" and part.interfaces.get(face.name) == pin.joint:
                    yield part, face


def _fit(
    pin: Part, entry: StackEntry, bush: Bush, bore: Interface, key: str, problems: Problems
) -> PressFit | None:
    """The bush in a bore; None where it does not fit."""
    shape, material = as_pin(pin.geometry), pin.bushes.get(entry.name)
    if shape is None or material is None:
        return None
    ratio = 2 * bore.radius / (entry.diameter or shape.diameter)
    if ratio <= 1.0:
        return None  # told with the hole
    assert bush.fit is not None
    try:
        least, largest = (
            bush.fit if isinstance(bush.fit, tuple) else interferences_of(bush.fit, 2 * bore.radius)
        )
    except ValueError as error:
        problems.add(key, str(error))
        return None
    if largest > _MOST * 2 * bore.radius:
        problems.add(
            key,
            f"an interference of {largest:g} mm is more than a hundredth of the bore's diameter of "
            f"{2 * bore.radius:g} mm; is it in another unit?",
        )
        return None
    elastic = material.youngs_modulus, material.poisson_ratio
    return PressFit(
        least,
        largest,
        bore.radius,
        ratio,
        *elastic,
        pin=pin.name,
        yield_stress=material.yield_stress,
    )


def _pressed(part: Part, bore: str, fit: PressFit, problems: Problems) -> Part:
    """Return the part with a bush in a bore, and the clearance that it leaves there."""
    own = part.material
    lug = ring_flexibility(inf, own.youngs_modulus, own.poisson_ratio)
    less, more = (fit.at(share).closing(lug) for share in (LEAST, LARGEST))
    clearances = dict(part.clearances)
    if bore in clearances:
        least, largest = clearances[bore]
        if least < more:
            problems.add(
                f"parts.{part.name}.fits.{bore}",
                f"leaves the pin a clearance of at least {least:.3g} mm, but its bush closes by "
                f"{less:.3g} to {more:.3g} mm as it is pressed in (the bush in "
                f"parts.{fit.pin}.stack); state the clearance before it is, which must be at least "
                f"{more:.3g} mm",
            )
        clearances[bore] = (max(least - more, 0.0), max(largest - less, 0.0))
    return replace(part, clearances=clearances, press_fits={**part.press_fits, bore: fit})
