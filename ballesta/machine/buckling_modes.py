"""Shapes in which parts buckle, for the live view: where no solid has told them."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

import loads
from ballesta.machine.motion import carrier_of, part_frame
from checks.columns.linkage_frame import LINKAGE, LinkageMode
from checks.design.data import Design
from checks.ladder.part_fields import FREE_SIZE, moved_with
from checks.part.part_loads import interface_distance
from checks.result.live_fields import LiveFields
from checks.result.verdict import Check, DesignResult, PartResult, deciding_of
from geometry.mesh import FloatArray

_UNKNOWN = "its buckling mode is not drawn: the formula has none; --fidelity solid finds it"
_ITS_OWN = 1.01  # of the distance of its pins: another column is not the part alone
_PLACES = 33  # of a half wave


def with_modes(
    design: Design,
    solved: Mapping[str, loads.CycleLoads],
    result: DesignResult,
    linkage: LinkageMode | None,
) -> DesignResult:
    """The result with the buckling modes of what buckling decides, in its live fields.

    linkage  the mode of all bodies together

    A part whose governing check is buckling has its solid's mode where that has judged it, else
    Euler's half wave between its own pins where a column between them governs. All parts have the
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
    if check.plane != linkage.plane:
        return False
    return check.span > _ITS_OWN * interface_distance(design, design.parts[check.part])


def _of_part(design: Design, part: PartResult) -> PartResult:
    live, governing = part.live, deciding_of(part.checks) if part.checks else None
    if not isinstance(live, LiveFields) or not governing or governing.kind != "buckling":
        return part
    if live.mode is not None or governing.method.startswith("solid"):
        return part
    own = interface_distance(design, design.parts[part.name])
    if not 1 / _ITS_OWN < governing.span / own < _ITS_OWN:
        return replace(part, live=replace(live, notes=(*live.notes, _UNKNOWN)))
    first, last = (pin.centre for pin in design.parts[part.name].geometry.placed_interfaces[:2])
    moved = moved_with(np.asarray(live.nodes), *half_wave(first, last, governing.plane))
    moved /= np.linalg.norm(moved, axis=1).max()
    notes = (*live.notes, FREE_SIZE.format(f"Euler's half wave {governing.plane}, of an even bar"))
    return replace(part, live=replace(live, mode=moved, notes=notes))


def half_wave(first: FloatArray, last: FloatArray, plane: str) -> tuple[FloatArray, FloatArray]:
    """Places (m, 3) and motions (m, 6) of a bar that buckles from `first` to `last`, hinged.

    Its sections turn with the axis.
    """
    share = np.linspace(0.0, 1.0, _PLACES)[:, None]
    way, out = last - first, np.array([0.0, 0.0, 1.0])
    length = np.linalg.norm(way)
    aside = np.cross(out, way / length) if plane == "in plane" else out
    slope = np.pi / length * np.cos(np.pi * share)
    turns = slope * np.cross(way / length, aside)
    return first + share * way, np.hstack([np.sin(np.pi * share) * aside, turns])


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
            part = replace(part, live=replace(live, mode=shape, notes=(*live.notes, told)))
        yield part
