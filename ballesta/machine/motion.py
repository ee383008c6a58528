"""Motion of a design's parts through its cycles, thinned for pictures, and how they buckle."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

import loads
from checks.by_formula.crooked_column import CROOKED
from checks.columns.linkage_frame import LINKAGE
from checks.columns.linkage_search import LinkageMode
from checks.columns.stability import ELASTIC
from checks.design.data import Design, Part
from checks.ladder.part_fields import FREE_SIZE, as_it_buckles
from checks.models.bar_modes import Mode, half_wave, moved_with
from checks.models.shapes.toggle_bar import cheeks_alone
from checks.part.part_loads import interface_distance, interface_heights, loads_on, part_placing
from checks.result.live_fields import LiveFields
from checks.result.motion import MOST_POSITIONS, PartsMotion, PinForce
from checks.result.verdict import Check, DesignResult, PartResult, deciding_of
from checks.result.words import brief, number
from geometry.mesh import FloatArray, IntArray
from geometry.parts import ToggleBar
from geometry.parts.pin import as_pin
from loads.blow_loads import at_rows
from loads.kinematics import rotated

_STEP = np.radians(6.0) + 1e-9  # that a body turns by between two kept positions, at most
Spans = list[tuple[float, float]]
_AROUND = 1.3  # of the radius of a bore: what stands at a joint
_GAP = 0.03  # between parts that are moved apart, over the thickness of what is there
_TOLD = 6  # names in a sentence


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
    kept = at_rows(cycle, rows)
    return PartsMotion(
        index=rows,
        times=kept.times,
        parts={name: frame[rows] for name, frame in frames.items()},
        layer=layer,
        layers_told=told,
        pins={
            label: replace(pin, place=pin.place[rows], force=pin.force[rows])
            for label, pin in pins.items()
        },
        bodies={part.name: carrier_of(part) for part in parts},
        linkage=cycle.linkage,
        poses=kept.poses,
        reactions=kept.reactions,
        efforts=kept.efforts,
    )


def part_frame(design: Design, part: Part, cycle: loads.CycleLoads) -> FloatArray:
    """The part's frame in the machine's at every position (n, 3): x, y [mm], angle [rad]."""
    body = carrier_of(part)
    pose = cycle.poses[:, cycle.body_index(body)]
    frame, placing = pose.copy(), part_placing(design, part)
    if part.body is None:
        assert part.joint is not None
        frame[:, :2] = cycle.point(body, part.joint)
    else:
        frame[:, :2] += rotated(np.array(placing.origin, dtype=np.float64), pose[:, 2])
    frame[:, 2] += placing.angle
    frame[:, 2] = np.unwrap(frame[:, 2])
    return frame


def carrier_of(part: Part) -> str:
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
    pin = as_pin(part.geometry)
    seats = [] if pin is None else pin.seats
    pairs = {seat.name: (-seat.at, seat.at) for seat in seats if not seat.single and seat.at}
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
            place=_place(part, interface, cycle) + rotated(own, frame[:, 2]),
            force=rotated(wrench[:, :2], frame[:, 2]),
            z=layer + heights.get(interface, 0.0) + part.offsets.get(interface, 0.0),
            halves=tuple(layer + height for height in pairs.get(interface, ())),
        )
    return found


def _place(part: Part, interface: str, cycle: loads.CycleLoads) -> FloatArray:
    """Positions (n, 2) of the linkage's point at an interface, mm."""
    body, named = carrier_of(part), part.interfaces[interface]
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


# Heights of parts across the linkage's plane in a picture: as stated, else side by side.


@dataclass(frozen=True, eq=False)
class PartSkin:
    """The surface of a part in its own frame: nodes (n, 3) mm, triangles (m, 3)."""

    nodes: FloatArray
    triangles: IntArray


@dataclass(frozen=True)
class _Meeting:
    """Two parts that share a joint; a line where one slides along the other."""

    joint: str
    first: str
    second: str
    line: bool


def layers(design: Design, skins: Mapping[str, PartSkin]) -> tuple[dict[str, float], str]:
    """Height of every part's plane z = 0 over the machine's [mm], and its origin in words.

    A pin's stack of lugs and the offsets of interfaces say it, where they are stated. Parts that
    would stand in each other at a joint are moved apart, by as little as it takes.
    """
    steps = [*_of_stacks(design), *_of_offsets(design)]
    meetings = list(_meetings(design))
    found: dict[str, float] = {}
    moved: dict[str, float] = {}
    while len(found) < len(design.parts):
        name, height = _next(design, steps, found)
        found[name] = height
        if design.parts[name].body is not None:
            shift = _shift(design, skins, meetings, found, name)
            if shift:
                found[name] += shift
                moved[name] = shift
    return {name: found[name] for name in design.parts}, _told(bool(steps), moved)


def _next(
    design: Design, steps: Sequence[tuple[str, str, float]], found: Mapping[str, float]
) -> tuple[str, float]:
    """A part that is not placed yet, and its height: beside a placed one where that is stated."""
    for first, second, rise in steps:
        for known, new, sign in ((first, second, 1.0), (second, first, -1.0)):
            if known in found and new not in found:
                return new, found[known] + sign * rise
    return next(name for name in design.parts if name not in found), 0.0


def _told(stated: bool, moved: Mapping[str, float]) -> str:
    said = (
        "Across the plane the parts stand as the pins' stacks and the offsets state it"
        if stated
        else "Nothing states where the parts stand across the plane"
    )
    if not moved:
        return f"{said}."
    names = [
        f"{brief(name, 40)} by {number(shift, 2)} mm" for name, shift in list(moved.items())[:_TOLD]
    ]
    more = f" and {len(moved) - _TOLD} more" if len(moved) > _TOLD else ""
    said += "; drawn aside so that parts do not stand in each other"
    return f"{said}: {', '.join(names)}{more}."


def _of_stacks(design: Design) -> Iterator[tuple[str, str, float]]:
    """(pin, part, how much higher the part's plane is) of every lug on a pin that is a part."""
    of_body = {part.body: part for part in design.parts.values() if part.body is not None}
    for pin in design.parts.values():
        for lug in pin.stack:
            part = of_body.get(lug.body or "")
            if part is None:
                continue
            interface = _interface_at(part, pin.joint)
            height = 0.0 if interface is None else interface_heights(part).get(interface, 0.0)
            yield pin.name, part.name, (lug.at if lug.single else 0.0) - height


def _of_offsets(design: Design) -> Iterator[tuple[str, str, float]]:
    """(part, other part, how much higher) at joints without a pin part, where an offset says it."""
    pinned = {part.joint for part in design.parts.values()}
    for meeting in _meetings(design):
        first, second = design.parts[meeting.first], design.parts[meeting.second]
        one = first.offsets.get(_interface_at(first, meeting.joint) or "", 0.0)
        other = second.offsets.get(_interface_at(second, meeting.joint) or "", 0.0)
        if meeting.joint not in pinned and (one or other):
            yield first.name, second.name, one - other


def _interface_at(part: Part, joint: str | None) -> str | None:
    return next((name for name, point in part.interfaces.items() if point == joint), None)


def _meetings(design: Design) -> Iterator[_Meeting]:
    """Every pair of body parts that share a joint."""
    of_body = {part.body: part.name for part in design.parts.values() if part.body is not None}
    for point, bodies in design.pins.items():
        here = [of_body[body] for body in bodies if body in of_body]
        for k, first in enumerate(here):
            for second in here[k + 1 :]:
                yield _Meeting(point, first, second, False)
    for slide in design.slides.values():
        on = slide.body_a
        sliding = dict.fromkeys([slide.body_b, *design.pins.get(slide.point_b, ())])
        for body in sliding:  # or what is pinned to a block without a part that slides
            if on in of_body and body in of_body and body != on:
                yield _Meeting(slide.name, of_body[on], of_body[body], True)


def _shift(
    design: Design,
    skins: Mapping[str, PartSkin],
    meetings: Sequence[_Meeting],
    found: Mapping[str, float],
    name: str,
) -> float:
    """The least by which a part must move so that it stands in no other at a joint, mm."""
    own: list[tuple[Spans, Spans]] = []
    for meeting in meetings:
        pair = (meeting.first, meeting.second)
        other = pair[1] if pair[0] == name else pair[0]
        if name not in pair or other not in found or other == name:
            continue
        spans = _spans(design, skins, name, other, meeting)
        own.append((_raised(spans[0], found[name]), _raised(spans[1], found[other])))
    gap = _GAP * max((top - low for pair in own for low, top in (pair[0] + pair[1])), default=0.0)
    choices = [0.0]
    for mine, others in own:
        for low, top in mine:
            for other_low, other_top in others:
                choices += [other_top - low + gap, other_low - top - gap]
    free = (shift for shift in choices if not any(_meet(pair, shift) for pair in own))
    return min(free, key=lambda shift: (abs(shift), -shift), default=0.0)


def _raised(spans: Spans, height: float) -> Spans:
    return [(low + height, top + height) for low, top in spans]


def _meet(pair: tuple[Spans, Spans], shift: float) -> bool:
    """True if two parts overlap when the first is moved."""
    mine, others = pair
    return any(
        low + shift < other_top and other_low < top + shift
        for low, top in mine
        for other_low, other_top in others
    )


def _spans(
    design: Design, skins: Mapping[str, PartSkin], name: str, other: str, meeting: _Meeting
) -> tuple[Spans, Spans]:
    """Stretches of z [mm] that two parts fill at their joint, each in its own frame."""
    if meeting.line:
        both = (skins[name].nodes[:, 2], skins[other].nodes[:, 2])
        first, second = ([(float(z.min()), float(z.max()))] for z in both)
        return first, second
    near = [
        _distance(design, design.parts[each], skins[each], meeting.joint) for each in (name, other)
    ]
    reach = _AROUND * max(float(distance.min()) for distance in near)
    first, second = (
        _filled(skins[each], distance <= max(reach, 1.001 * float(distance.min())))
        for each, distance in zip((name, other), near, strict=True)
    )
    return first, second


def _distance(design: Design, part: Part, skin: PartSkin, joint: str) -> FloatArray:
    """Distance (n,) of a part's nodes from the axis of a joint, mm."""
    assert part.body is not None
    placing = part_placing(design, part)
    x, y = np.array(design.bodies[part.body].points[joint]) - placing.origin
    c, s = np.cos(placing.angle), np.sin(placing.angle)
    place = c * x + s * y, -s * x + c * y
    return np.asarray(np.hypot(skin.nodes[:, 0] - place[0], skin.nodes[:, 1] - place[1]))


def _filled(skin: PartSkin, near: np.typing.NDArray[np.bool_]) -> Spans:
    """Stretches of z that triangles with a node near by fill, joined where they touch."""
    z = skin.nodes[skin.triangles[near[skin.triangles].any(axis=1)], 2]
    ends = sorted(zip(z.min(axis=1).tolist(), z.max(axis=1).tolist(), strict=True))
    if not ends:
        return []
    breaks = [0]
    top = ends[0][1]
    for k, (low, high) in enumerate(ends):
        if low > top + 1e-6:
            breaks.append(k)
        top = max(top, high)
    return [
        (ends[first][0], max(high for _, high in ends[first:last]))
        for first, last in pairwise([*breaks, len(ends)])
    ]


# Shapes in which parts buckle, for the live view: where no solid has told them.
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
