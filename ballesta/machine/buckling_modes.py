"""Shapes in which parts buckle, for the live view: where no solid has told them."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

import loads
from ballesta.machine.motion import carrier_of, part_frame
from checks.by_formula.crooked_column import CROOKED
from checks.columns.linkage_frame import LINKAGE, LinkageMode
from checks.columns.stability import ELASTIC
from checks.design.data import Design, Part
from checks.ladder.part_fields import FREE_SIZE, as_it_buckles
from checks.models.bar_modes import Mode, half_wave, moved_with
from checks.models.shapes.toggle_bar import cheeks_alone
from checks.part.part_loads import interface_distance
from checks.result.live_fields import LiveFields
from checks.result.verdict import Check, DesignResult, PartResult, deciding_of
from geometry.parts import ToggleBar

_UNKNOWN = (
    "its buckling mode is not drawn: its shape's formula gives a load alone; --fidelity solid "
    "finds it"
)
_SHORTER = (
    "its buckling mode is not drawn: an effective length of {} mm is stated for its {} mm, and not "
    "how its ends are held; --fidelity solid finds it"
)
_ITS_OWN = 1.01  # of the distance of its pins: another column is not the part alone


def with_modes(
    design: Design,
    solved: Mapping[str, loads.CycleLoads],
    result: DesignResult,
    linkage: LinkageMode | None,
) -> DesignResult:
    """The result with the buckling modes of what buckling decides, in its live fields.

    linkage  the mode of all bodies together

    A part whose governing check is buckling has its mode by solid or formula already, or Euler's
    half wave where a column governs; a crooked bar bows as its column does. All parts have the
    linkage's mode where that decides the verdict, or a column in its plane that is more than a
    part.
    """
    deciding = result.deciding if result.checks else None
    if linkage and deciding and _is_of(design, deciding, linkage):
        parts = list(_of_linkage(design, solved[linkage.cycle], result, linkage))
    else:
        parts = [_of_part(design, part) for part in result.parts]
    return replace(result, parts=parts)


def _is_of(design: Design, check: Check, linkage: LinkageMode) -> bool:
    if check.quantity == LINKAGE.quantity:
        return True
    if check.plane != linkage.plane or check.quantity == ELASTIC.quantity:
        return False
    return check.span > _ITS_OWN * interface_distance(design, design.parts[check.part])


def _of_part(design: Design, part: PartResult) -> PartResult:
    live, governing = part.live, deciding_of(part.checks) if part.checks else None
    if not isinstance(live, LiveFields) or not governing or governing.kind != "buckling":
        return part
    if live.mode is not None or governing.method.startswith("solid"):
        return part
    found = _of_column(design, design.parts[part.name], governing) if governing.plane else _UNKNOWN
    if isinstance(found, str):
        return replace(part, live=replace(live, notes=(*live.notes, found)))
    return replace(part, live=as_it_buckles(live, *found))


def _of_column(design: Design, part: Part, check: Check) -> tuple[Mode, str] | str:
    """The mode of a column and what it is, in words; or why there is none."""
    own, plane = interface_distance(design, part), check.plane
    if not check.span:
        if isinstance(part.geometry, ToggleBar):
            words = f"of the {check.place} by themselves, {plane}"
            return partial(cheeks_alone, part.geometry, plane), words
        return _UNKNOWN
    pins = part.geometry.placed_interfaces[:2]
    if check.span > _ITS_OWN * own:
        pins.sort(key=lambda pin: _moves(design, part.interfaces[pin.name]))
    first, last = (pin.centre for pin in pins)
    far = check.span / own
    mode = half_wave(first, first + far * (last - first), plane)
    words = f"Euler's half wave {plane}, of an even bar"
    if far < 1 / _ITS_OWN:
        return _SHORTER.format(f"{check.span:.4g}", f"{own:.4g}")
    if far > _ITS_OWN:
        words += f" of {check.span:.4g} mm, of which this is a part"
    if CROOKED.has(f"{check.kind}: {check.quantity}"):
        words += ", into which a crooked bar bows: it yields before, and has no mode of its own"
    return mode, words


def _moves(design: Design, point: str) -> int:
    """How free a pin is to move aside: 0 on the ground, 1 on what a guide holds, 2 elsewhere."""
    bodies = design.pins.get(point, ())
    if loads.GROUND in bodies:
        return 0
    return 1 if any(f"guide:{body}" in design.joints for body in bodies) else 2


def _of_linkage(
    design: Design, cycle: loads.CycleLoads, result: DesignResult, mode: LinkageMode
) -> Iterator[PartResult]:
    """The parts with the mode of the linkage, each in its own axes."""
    moves, most = {}, 0.0
    for part in result.parts:
        own = design.parts[part.name]
        body = carrier_of(own)
        if not isinstance(part.live, LiveFields) or body not in mode.shape:
            continue
        x, y, angle = part_frame(design, own, cycle)[mode.index]
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        places = np.pad(mode.places[body] - [x, y], ((0, 0), (0, 1))) @ turn.T
        motions = np.hstack([mode.shape[body][:, :3] @ turn.T, mode.shape[body][:, 3:] @ turn.T])
        moves[part.name] = moved_with(np.asarray(part.live.nodes), places, motions)
        most = max(most, float(np.linalg.norm(moves[part.name], axis=1).max()))
    told = FREE_SIZE.format(f"of the linkage, {mode.plane}, at {mode.position}")
    for part in result.parts:
        live = part.live
        if part.name in moves and isinstance(live, LiveFields) and most:
            shape = moves[part.name] / most
            notes = [note for note in live.notes if not note.startswith(FREE_SIZE.split("{")[0])]
            part = replace(part, live=replace(live, mode=shape, notes=(*notes, told)))
        yield part
