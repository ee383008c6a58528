"""Dimensions that a pin and the parts on it both state, which must agree.

And bushes of the pins' stacks that state how they are pressed in, at the bores they are in.
"""

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from math import inf
from typing import Any

from checks.design.data import Part
from checks.design.errors import Problems
from checks.design.model import Bush, StackEntry
from checks.handbook.fits import (
    DEFAULT,
    LARGEST,
    LEAST,
    PressFit,
    clearances_of,
    interferences_of,
    ring_flexibility,
)
from geometry.mesh import Interface
from geometry.parameters import within
from geometry.parts.pin import as_pin

APART = 0.1  # mm, between where a force acts and where the model of a part has it
_LOOSE = 1.25  # times the pin: up to here a check tells the play, beyond no pin is meant so
_ROUND_OFF = 1e-9  # of a length that is stated in two units
_MOST = 0.01  # of the bore's diameter: more is a mistake in the unit


def check_stacks(parts: Mapping[str, Part], stated: Mapping[str, Any], problems: Problems) -> None:
    """Note pins that do not fit the holes of parts on them, and what a stack contradicts.

    Those are bushes longer than their lugs, fits and offsets.

    stated  the entry of each part, as the design file has it
    """
    for pin in parts.values():
        if pin.joint is not None:
            _check_bushes(pin, problems)
            for part, interface in _carried(pin, parts):
                _check_fit(pin, part, interface, problems)
                if interface in stated[part.name].offsets:
                    _check_offset(pin, part, interface, problems)


def with_widths(parts: Mapping[str, Part]) -> dict[str, Part]:
    """The parts with pins that bear no longer in a lug than the part there has a hole."""
    found = dict(parts)
    for pin in parts.values():
        shape = as_pin(pin.geometry)
        if pin.joint is None or shape is None:
            continue
        stack = tuple(
            lug if within(lug.width, length) else _narrowed(lug, length)
            for lug, length in zip(pin.stack, _hole_lengths(pin, parts), strict=True)
        )
        widths = {lug.name: lug.width for lug in stack}
        seats = tuple(replace(seat, width=widths[seat.name]) for seat in shape.seats)
        found[pin.name] = replace(pin, stack=stack, geometry=replace(shape, seats=seats))
    return found


def _narrowed(lug: StackEntry, width: float) -> StackEntry:
    """A lug that is no wider than its hole is long; nor does its bush bear beyond."""
    bush = lug.bush
    if bush is not None and within(bush.length, lug.width):
        bush = bush.model_copy(update={"length": min(bush.length, width)})
    return lug.model_copy(update={"width": width, "bush": bush})


def told_of_widths(
    parts: Mapping[str, Part], stated: Mapping[str, Any]
) -> Iterator[tuple[str, str]]:
    """Keys of the lugs that are stated wider than their parts' holes are long, and what counts."""
    for name, part in parts.items():
        for k, lug in enumerate(part.stack):
            if lug.width != stated[name].stack[k].width:
                said = f"the hole of {lug.body} is {lug.width:g} mm long, which counts"
                yield f"parts.{name}.stack[{k}].width", said


def told_of_pairs(parts: Mapping[str, Part]) -> Iterator[tuple[str, str]]:
    """Keys of the pairs of lugs whose part has its hole in one piece, and how it is judged."""
    for pin in parts.values():
        shape = as_pin(pin.geometry)
        if pin.joint is None or shape is None:
            continue
        bores = _bores_for(pin, parts)
        for k, (lug, seat) in enumerate(zip(pin.stack, shape.seats, strict=True)):
            bore = bores.get(lug.body)
            if seat.paired and bore is not None and bore.piece >= bore.length:
                said = (
                    f"{lug.body} has two lugs in the stack and one hole, {bore.length:g} mm long: "
                    "one plate bears all; single = true puts it on one side"
                )
                yield f"parts.{pin.name}.stack[{k}].at", said


def told_of_overlaps(parts: Mapping[str, Part]) -> Iterator[tuple[str, str]]:
    """Keys of the lugs beside which another one stands that the part there is too thick for.

    Of two lugs that bear beside each other, seats as wide as stated; of single ones the whole hole.
    """
    for pin in parts.values():
        shape = as_pin(pin.geometry)
        if pin.joint is None or shape is None:
            continue
        bodies = [lug.body for lug in pin.stack]
        spans = []
        for k, (length, seat) in enumerate(
            zip(_hole_lengths(pin, parts), shape.seats, strict=True)
        ):
            alone = not seat.paired and math.isfinite(length)
            thick = max(seat.width, length) if alone else seat.width
            spans += [(place - thick / 2, place + thick / 2, k) for place in seat.places]
        for (_, top, lower), (bottom, _, upper) in pairwise(sorted(spans)):
            if top - bottom > APART and lower != upper:
                both = f"{bodies[lower]} and {bodies[upper]} overlap by {top - bottom:.3g} mm"
                said = "as thick as they are; the pin bends as its stack says, more if they part"
                yield f"parts.{pin.name}.stack[{upper}].at", f"{both} {said}"


def with_plays(parts: Mapping[str, Part]) -> dict[str, Part]:
    """The parts with the clearance that a pin's diameter leaves in a hole, where no fit is stated.

    Arcs of contact are assumed up to the default fit's clearance; a looser pin presses on less.
    A part whose arc is stated keeps it.
    """
    found = dict(parts)
    for pin in parts.values():
        for part, interface in _carried(pin, parts) if pin.joint is not None else ():
            neck, hole = _bare_seat(pin, part, interface)
            if hole is None or part.arc_stated or interface in part.clearances:
                continue
            assumed = 0.0
            with suppress(ValueError):  # larger than the standard's table
                assumed = clearances_of(DEFAULT, hole)[1]
            play = hole - neck
            if play > assumed + _ROUND_OFF * hole:
                known = found[part.name]
                clearances = {**known.clearances, interface: (play, play)}
                found[part.name] = replace(known, clearances=clearances)
    return found


def _hole_lengths(pin: Part, parts: Mapping[str, Part]) -> list[float]:
    """Length of the hole that each lug of a stack has for the pin, mm; inf where none is known."""
    bores, found = _bores_for(pin, parts), []
    for lug in pin.stack:
        bore = bores.get(lug.body)
        whole = bore.length if bore else math.inf
        found.append(min(bore.piece, whole) if bore and lug.at else whole)  # of one cheek
    return found


def _bores_for(pin: Part, parts: Mapping[str, Part]) -> dict[str | None, Interface]:
    """The bore that each body has for a pin, of those whose parts are stated."""
    return {
        part.body: face
        for part, interface in _carried(pin, parts)
        for face in part.geometry.placed_interfaces
        if face.name == interface and face.kind == "bore"
    }


def _bare_seat(pin: Part, part: Part, interface: str) -> tuple[float, float | None]:
    """Diameter of a pin in a part, mm, and of the hole it bears in; None with a bush between."""
    shape, lug = as_pin(pin.geometry), next(one for one in pin.stack if one.body == part.body)
    assert shape is not None
    hole = part.geometry.stated_bore(interface) if lug.bush is None else None
    return shape.diameter if lug.diameter is None else lug.diameter, hole


def _carried(pin: Part, parts: Mapping[str, Part]) -> Iterator[tuple[Part, str]]:
    """The parts on a pin, and which of their interfaces sits on it."""
    bodies = {lug.body for lug in pin.stack}
    for part in parts.values():
        if part.body is not None and part.body in bodies:
            for interface, point in part.interfaces.items():
                if point == pin.joint:
                    yield part, interface


def _check_bushes(pin: Part, problems: Problems) -> None:
    """A bush bears on the pin no longer than its lug is wide there, and slides if it says so."""
    for index, lug in enumerate(pin.stack):
        if lug.bush is not None and lug.bush.pv is not None and lug.body == pin.fixed_to:
            problems.add(
                f"parts.{pin.name}.stack[{index}].bush.pv",
                f"the pin turns with {lug.body} (fixed_to), so that nothing slides in this bush; "
                f"if the pin turns in it, parts.{pin.name}.fixed_to is another body, else leave "
                "pv out",
            )
        if lug.bush is not None and not within(lug.bush.length, lug.width):
            key = f"parts.{pin.name}.stack[{index}]"
            problems.add(
                f"{key}.bush.length",
                f"a bush of {lug.bush.length:g} mm is longer than the lug, which is "
                f"{lug.width:g} mm wide on the pin ({key}.width); `width` is all that bears there",
            )


def _check_fit(pin: Part, part: Part, interface: str, problems: Problems) -> None:
    shape, hole = as_pin(pin.geometry), part.geometry.stated_bore(interface)
    assert shape is not None
    room = hole or float(getattr(part.geometry, "width", math.inf))
    if shape.diameter > room * (1 + _ROUND_OFF):
        problems.add(
            f"parts.{pin.name}.diameter",
            f"a pin of {shape.diameter:g} mm cannot pass {part.name}, which has {room:g} mm there",
        )
    index, lug = next((k, lug) for k, lug in enumerate(pin.stack) if lug.body == part.body)
    neck = shape.diameter if lug.diameter is None else lug.diameter
    if hole is not None and lug.bush is not None and lug.bush.material and hole <= neck:
        bush = f"parts.{pin.name}.stack[{index}].bush.material"
        problems.add(
            bush,
            f"there is no room for a bush between the pin of {neck:g} mm and the hole of {hole:g} "
            f"mm in parts.{part.name}.{part.geometry.bore_key(interface)}; the hole is the bush's "
            "outer diameter",
        )
    if hole is None or lug.bush is not None:
        return
    bore = f"parts.{part.name}.{part.geometry.bore_key(interface)}"
    own = "diameter" if lug.diameter is None else f"stack[{index}].diameter"
    most = part.clearances.get(interface, (0.0, math.inf))[1]
    if hole - neck > most + _ROUND_OFF * hole and hole <= _LOOSE * neck:
        problems.add(
            f"parts.{part.name}.fits.{interface}",
            f"leaves the pin a clearance of at most {most:.3g} mm, but parts.{pin.name}.{own} of "
            f"{neck:g} mm leaves {hole - neck:.3g} mm in a hole of {hole:g} mm "
            f"({bore}); state one of them otherwise",
        )
    if hole <= _LOOSE * neck:
        return
    problems.add(
        f"parts.{pin.name}.{own}",
        f"the pin has {neck:g} mm where parts.{part.name} has a hole of {hole:g} mm for it "
        f"({bore}); make them fit, or state the "
        f"bush between them in parts.{pin.name}.stack[{index}].bush",
    )


def _check_offset(pin: Part, part: Part, interface: str, problems: Problems) -> None:
    """One height of all other lugs tells the offset; of several no offset has the couple."""
    shape = as_pin(pin.geometry)
    assert shape is not None
    heights = {seat.name: seat.at if seat.single else 0.0 for seat in shape.seats}
    own = heights.pop(str(part.body))
    # a pin hands the couple of its other lugs to the one that it is fixed in; in the rest it turns
    arms = {height - own if pin.fixed_to == part.body else 0.0 for height in heights.values()}
    key = f"parts.{part.name}.offsets.{interface}"
    if len(arms) > 1:
        beside = " and ".join(f"{arm:g}" for arm in sorted(arms))
        problems.add(
            key,
            f"is one place for forces that parts.{pin.name}.stack has {beside} mm beside the "
            "part's middle plane; leave it out: their couple is then taken from the stack",
        )
        return
    (wanted,) = arms
    offset = part.offsets[interface]
    if abs(offset - wanted) <= APART:
        return
    turns = "" if pin.fixed_to == part.body else f", as {pin.name} turns in {part.body}"
    problems.add(
        key,
        f"is {offset:g} mm, but by parts.{pin.name}.stack the force acts {wanted:g} mm beside the "
        f"part's middle plane{turns}; leave it out, or state one of them otherwise",
    )


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
