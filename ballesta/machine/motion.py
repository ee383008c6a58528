"""Motion of a design's parts through its solved cycles, thinned for pictures."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace

import numpy as np

import loads
from ballesta.machine.motion_layers import PartSkin, layers
from checks.design.data import Design, Part
from checks.part.part_loads import interface_heights, loads_on
from checks.part.placing import part_placing
from checks.result.motion import MOST_POSITIONS, PartsMotion, PinForce
from checks.result.verdict import PartResult
from geometry.mesh import FloatArray, IntArray

_STEP = np.radians(6.0) + 1e-9  # that a body turns by between two kept positions, at most


def motions_of(
    design: Design, solved: Mapping[str, loads.CycleLoads], results: Sequence[PartResult]
) -> dict[str, PartsMotion]:
    """Motion of the parts with a result in every cycle that was solved.

    Measured runs have none: nobody knows where their bodies are.
    """
    if not solved or not results:
        return {}
    skins = {
        result.name: PartSkin(
            np.asarray(result.surface.nodes, dtype=np.float64),
            np.asarray(result.surface.triangles, dtype=np.int64),
        )
        for result in results
    }
    layer, told = layers(design, skins)
    return {name: _motion(design, cycle, results, layer, told) for name, cycle in solved.items()}


def _motion(
    design: Design,
    cycle: loads.CycleLoads,
    results: Sequence[PartResult],
    layer: Mapping[str, float],
    told: str,
) -> PartsMotion:
    parts = [design.parts[result.name] for result in results]
    frames = {part.name: part_frame(design, part, cycle) for part in parts}
    pins: dict[str, PinForce] = {}
    for part in parts:
        pins |= _pins(design, part, cycle, frames[part.name], layer[part.name])
    peaks = [
        int(np.argmax(result.charts["peaks"][cycle.name]))
        for result in results
        if len(result.charts.get("peaks", {}).get(cycle.name, ()))
    ]
    peaks += [int(np.hypot(*pin.force.T).argmax()) for pin in pins.values()]
    turned = np.unwrap(cycle.poses[:, :, 2], axis=0)
    rows = kept_rows(np.asarray(cycle.phase_of), peaks, turned=turned)
    return PartsMotion(
        index=rows,
        times=cycle.times[rows],
        parts={name: frame[rows] for name, frame in frames.items()},
        layer=layer,
        layers_told=told,
        pins={
            label: replace(pin, place=pin.place[rows], force=pin.force[rows])
            for label, pin in pins.items()
        },
        bodies={part.name: _carrier(part) for part in parts},
        linkage=cycle.linkage,
        poses=cycle.poses[rows],
        reactions={name: _at(load, rows) for name, load in cycle.reactions.items()},
        efforts={name: effort[rows] for name, effort in cycle.efforts.items()},
    )


def part_frame(design: Design, part: Part, cycle: loads.CycleLoads) -> FloatArray:
    """The part's frame in the machine's at every position (n, 3): x, y [mm], angle [rad]."""
    body = _carrier(part)
    pose = cycle.poses[:, cycle.body_index(body)]
    frame, placing = pose.copy(), part_placing(design, part)
    if part.body is None:
        assert part.joint is not None
        frame[:, :2] = cycle.point(body, part.joint)
    else:
        frame[:, :2] += _turned(np.array(placing.origin, dtype=np.float64), pose[:, 2])
    frame[:, 2] += placing.angle
    frame[:, 2] = np.unwrap(frame[:, 2])
    return frame


def _carrier(part: Part) -> str:
    """Body of the linkage that a part moves with."""
    carrier = part.body or part.fixed_to
    assert carrier is not None
    return carrier


def _pins(
    design: Design, part: Part, cycle: loads.CycleLoads, frame: FloatArray, layer: float
) -> dict[str, PinForce]:
    """Force on a part at each of its interfaces, in the machine's frame."""
    found = {}
    part_loads = loads_on(design, part, {cycle.name: cycle})
    heights = interface_heights(part)
    shifts = part_placing(design, part).shifts
    for interface, wrench in part_loads.wrenches.items():
        own = np.zeros((len(frame), 2))
        own[:] = shifts.get(interface, (0.0, 0.0))
        if interface in part_loads.reaches:
            own[:, 0] += part_loads.reaches[interface]
        found[f"{part.name} {interface}"] = PinForce(
            on=part.name,
            interface=interface,
            point=part.interfaces[interface],
            place=_place(part, interface, cycle) + _turned(own, frame[:, 2]),
            force=_turned(wrench[:, :2], frame[:, 2]),
            z=layer + heights.get(interface, 0.0) + part.offsets.get(interface, 0.0),
        )
    return found


def _place(part: Part, interface: str, cycle: loads.CycleLoads) -> FloatArray:
    """Positions (n, 2) of the linkage's point at an interface, mm."""
    body, named = _carrier(part), part.interfaces[interface]
    if part.body is None:
        assert part.joint is not None
        return cycle.point(body, part.joint)
    if named not in cycle.linkage.body(body).points:  # a slot or guide whose line the body has
        named = cycle.linkage.joint(named).point_a
    return cycle.point(body, named)


def kept_rows(
    phase_of: IntArray,
    wanted: Sequence[int],
    most: int = MOST_POSITIONS,
    turned: FloatArray | None = None,
) -> IntArray:
    """Rows of a cycle's positions to keep, at most so many but for what turns.

    All if they are few. Else the wanted ones, both ends and both sides of every change of phase,
    in this order, and evenly spread ones between them; then as many more that no body turns by
    more than _STEP between two rows, where the cycle itself has such positions.

    turned  (n, bodies) rad, without jumps; places between rows lie on straight lines, which cut
            off arcs
    """
    n = len(phase_of)
    if n <= most:
        return np.arange(n)
    changes = np.flatnonzero(np.diff(phase_of))
    needed = dict.fromkeys([0, n - 1, *wanted, *changes.tolist(), *(changes + 1).tolist()])
    kept = list(needed)[:most]
    others = np.setdiff1d(np.arange(n), kept)
    even = np.linspace(0, len(others) - 1, most - len(kept)).round().astype(np.int64)
    rows = np.sort(np.concatenate([np.array(kept, dtype=np.int64), others[even]]))
    return rows if turned is None else np.union1d(rows, _turning_rows(rows, turned))


def _turning_rows(rows: IntArray, turned: FloatArray) -> IntArray:
    """Rows to add so that no body turns by more than _STEP from one to the next, if it can be."""
    kept = np.zeros(len(turned), dtype=bool)
    kept[rows] = True
    more, last = [], 0
    for row in range(1, len(turned)):
        if np.abs(turned[row] - turned[last]).max(initial=0.0) > _STEP and row - 1 > last:
            last = row - 1
            more.append(last)
        if kept[row]:
            last = row
    return np.array(more, dtype=np.int64)


def _at(load: loads.JointLoad, rows: IntArray) -> loads.JointLoad:
    return loads.JointLoad(
        **{field.name: getattr(load, field.name)[rows] for field in fields(load)}
    )


def _turned(vectors: FloatArray, angle: FloatArray) -> FloatArray:
    """Vectors (..., 2) turned by angles (n,): (n, 2)."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)
