"""Shapes in which parts buckle, for the live view: where no solid has told them."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

import loads
from ballesta.machine.motion import carrier_of, part_frame
from checks.columns.column_limits import Plane, planes_of
from checks.columns.linkage_frame import LINKAGE, LinkageMode
from checks.design.data import Design
from checks.result.live_fields import LiveFields
from checks.result.verdict import Check, DesignResult, PartResult, deciding_of
from geometry.mesh import FloatArray

_NOTE = "buckling mode: {}; its size is free"
_UNKNOWN = "its buckling mode is not drawn: the formula has none; --fidelity solid finds it"
_EULER = "in plane: Euler's column"  # the words of a share whose mode is a half wave
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
    plane = _plane(design, check)
    return plane is not None and plane.length > _ITS_OWN * plane.own and plane.name == linkage.plane


def _plane(design: Design, check: Check) -> Plane | None:
    """The plane in which a part buckles as a column by formula; None where it buckles otherwise."""
    if check.kind != "buckling" or check.part not in design.parts:
        return None
    words = check.note.partition(";")[0]
    said = words if words == _EULER else check.quantity if check.unit == "MPa" else ""
    planes = planes_of(design, design.parts[check.part]) if said else ()
    return next((p for p in planes if said.endswith(p.name) or said.startswith(p.name)), None)


def _of_part(design: Design, part: PartResult) -> PartResult:
    live, governing = part.live, deciding_of(part.checks) if part.checks else None
    if not isinstance(live, LiveFields) or not governing or governing.kind != "buckling":
        return part
    if governing.method.startswith("solid"):
        return part
    plane = _plane(design, governing)
    if plane is None or not 1 / _ITS_OWN < plane.length / plane.own < _ITS_OWN:
        return replace(part, live=replace(live, notes=(*live.notes, _UNKNOWN)))
    pins = design.parts[part.name].geometry.placed_interfaces[:2]
    first = min((pin.centre for pin in pins), key=lambda centre: float(centre[0]))
    moved = moved_with(np.asarray(live.nodes), *half_wave(first, plane.own, plane.name))
    moved /= np.linalg.norm(moved, axis=1).max()
    notes = (*live.notes, _NOTE.format(f"Euler's half wave {plane.name}, of an even bar"))
    return replace(part, live=replace(live, mode=moved, notes=notes))


def half_wave(first: FloatArray, length: float, plane: str) -> tuple[FloatArray, FloatArray]:
    """Places (m, 3) and motions (m, 6) of a bar that buckles from `first` on along x, hinged.

    Its sections turn with the axis.
    """
    x = np.linspace(0.0, length, _PLACES)
    places, motions = np.zeros((_PLACES, 3)), np.zeros((_PLACES, 6))
    places[:, 0] = first[0] + x
    inside = plane == "in plane"
    motions[:, 1 if inside else 2] = np.sin(np.pi * x / length)
    slope = np.pi / length * np.cos(np.pi * x / length)
    motions[:, 5 if inside else 4] = slope if inside else -slope
    return places, motions


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
    told = _NOTE.format(f"of the linkage, {mode.plane}, at {mode.position}")
    for part in result.parts:
        live = part.live
        if part.name in moves and isinstance(live, LiveFields) and most:
            shape = moves[part.name] / most
            part = replace(part, live=replace(live, mode=shape, notes=(*live.notes, told)))
        yield part


def moved_with(nodes: FloatArray, places: FloatArray, motions: FloatArray) -> FloatArray:
    """Displacements (n, 3) of nodes (n, 3) whose sections move with the axis of a bar.

    places   (m, 3) mm of the axis, in a straight row; a single one is of a rigid body
    motions  (m, 6) mm and rad
    """
    way = places[-1] - places[0]
    along = places @ way
    order = np.argsort(along)
    axis = np.hstack([places, motions])[order]
    at = np.stack([np.interp(nodes @ way, along[order], column) for column in axis.T], axis=1)
    return np.asarray(at[:, 3:6] + np.cross(at[:, 6:9], nodes - at[:, :3]))
