"""The mechanism in the report: drawn moving with the page's position, with the forces at its pins.

It needs only what a result carries (`DesignResult.motion`), so it is the same for one that was
recalled. The script is reports/scripts/mechanism.js; without it the picture stands at the position
that decides the verdict, with the forces there.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from checks.result.motion import PartsMotion, PinForce, motion_gaps
from checks.result.verdict import DesignResult
from checks.result.words import brief, number, place_text, quantity_unit
from geometry.mesh import FloatArray
from loads import Angle, PointCoordinate
from reports.loads_summary import ShownCycle
from reports.mechanism_layout import ARROW, TIP, Layout, Picture, both_ends, entry
from reports.page_words import deciding_place
from reports.templating import packed_json, page_template, series

PREFIX = "mechanism"
_PRINTED = 24  # rows of forces that paper has room for
_STAYS = 1e-9  # of the linkage's size: a pin that moves less on its body is fixed there


def mechanism_panel(result: DesignResult) -> Markup | None:
    """The panel as a figure with its data and tables; None where no cycle has a motion.

    The same result gives the same text.
    """
    names = [name for name in result.cycles if name in result.motion]
    if not names:
        return None
    motions = [result.motion[name] for name in names]
    layout = Layout(*motions, others=list(_at_pins(motions)))
    cycle, row = _start(result, names)
    frame = layout.stretches[names.index(cycle)].start + row
    picture = Picture(layout, PREFIX, frame)
    where = (
        f"cycle {brief(cycle, 40)}, {_where(result, cycle, int(result.motion[cycle].index[row]))}"
    )
    tables = [_table(result, name) for name in names]
    text = page_template("mechanism").render(
        svg=Markup(picture.svg(f"The mechanism in {where}, with the forces at its pins")),
        where=where,
        scale=force_text(layout.largest[names.index(cycle)]),
        torques=bool(layout.turning),
        efforts=_named([force.name for force in layout.linkage.forces]),
        gaps=motion_gaps(result),
        tables=tables,
        short=sum(len(table["rows"]) for table in tables) <= _PRINTED,
        data=Markup(packed_json(_data(result, names, picture))),
    )
    return Markup(text)


def _at_pins(motions: Sequence[PartsMotion]) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Places and forces (n, 2) of every pin force, over all cycles one behind the other."""
    for label in motions[0].pins:
        pins = [motion.pins[label] for motion in motions]
        places, forces = [pin.place for pin in pins], [pin.force for pin in pins]
        yield np.concatenate(places), np.concatenate(forces)


def _start(result: DesignResult, names: Sequence[str]) -> tuple[str, int]:
    """Cycle and kept row nearest to what decides the verdict, else the first of all."""
    place = deciding_place(result)
    if place is not None:
        cycle, position, _ = place
        name = list(result.cycles)[cycle]
        if name in names:
            return name, round(result.motion[name].row_of(position))
    return names[0], 0


def _where(result: DesignResult, cycle: str, position: int) -> str:
    """A position of a cycle in words."""
    data = result.cycles[cycle]
    phase = data["phase"][position] if len(data["phase"]) else ""
    shown = f"{brief(data['shown_name'], 20)} = {place_text(data['position'][position])}"
    said = f"{shown} {brief(data['unit'], 10)}".strip()
    return f"{said}, {brief(phase, 24)}" if phase and phase != cycle else said


def _named(names: Sequence[str]) -> str:
    shown = [brief(name, 30) for name in names[:6]]
    return ", ".join([*shown, *(["more"] if len(names) > 6 else [])])


def _table(result: DesignResult, cycle: str) -> dict[str, Any]:
    """The largest force on every part at each pin, and where in the cycle."""
    motion = result.motion[cycle]
    sizes = {label: np.hypot(*pin.force.T) for label, pin in motion.pins.items()}
    largest = max((float(size.max()) for size in sizes.values()), default=0.0)
    unit, factor = quantity_unit(False, largest)
    rows = []
    for index, (label, pin) in enumerate(motion.pins.items()):
        row = int(sizes[label].argmax())
        rows.append(
            {
                "part": pin.on,
                "interface": pin.interface,
                "point": pin.point,
                "size": _tidy(sizes[label][row], largest, factor),
                "x": _tidy(pin.force[row, 0], largest, factor),
                "y": _tidy(pin.force[row, 1], largest, factor),
                "where": _where(result, cycle, int(motion.index[row])),
                "pin": index,
            }
        )
    return {"cycle": cycle, "number": list(result.cycles).index(cycle), "unit": unit, "rows": rows}


def _tidy(value: float, largest: float, factor: float) -> str:
    """A force in the unit of its table; rounding error beside the largest becomes 0."""
    return "0" if abs(value) <= 1e-9 * largest else number(float(value) * factor, 4)


def _data(result: DesignResult, names: Sequence[str], picture: Picture) -> dict[str, Any]:
    """Data of the script's motion, packed by reports/templating.py, which explains a series.

    A place is [body, x, y]: in the frame of a body of the linkage, mm, y up; body 0 is the ground.

    tip      mm, half the length of an arrow's tip
    joints   their number; the reaction of joint k acts at mark k
    marks    [*place, lift] of every joint, then of forces that act elsewhere; a label stands `lift`
             mm beside and above it
    spans    [*place, *place, mm, length of the barrel] of forces that reach from point to point
    pushes   place at which each force acts, where its arrow ends
    turning  place of each torque, about which its arc is drawn
    pins     {name, part, body, at} of each force at a pin: its interface; the part that it acts on,
             -1 where that is not shown; that part's body; [x, y] on it, null where it slides
    parts    for each part of the result {body, mark: of one that is a pin, else null}, or null
             where it does not move with the linkage
    names    of the parts
    efforts  {name, unit, factor to that unit} of the forces, then of the torques
    cycles   for each cycle of the page, null where nobody knows the motion:

    index      the positions of the cycle that are kept; a series has a value for each
    scale      mm of an arrow for each N
    longest    the force of the longest arrow, in words
    turned     N mm, the torque of the longest arc
    poses      series x [mm], y [mm], angle [rad] of each body but the ground
    reactions  series x, y [N] at each joint
    pushes     series x, y [N] of each force in `pushes`
    efforts    series [N, N mm] of each of `efforts`
    torques    series [N mm] of each of `turning`, as its arc is drawn
    pins       series x, y [N] of each of `pins`
    places     series x, y [mm], in the machine's frame, of each of `pins` that slides
    """
    layout = picture.layout
    linkage = layout.linkage
    order = {name: index for index, name in enumerate(linkage.body_names)}

    def place(body: str, point: str) -> list[float]:
        x, y = linkage.body(body).place(point)
        return [order[body], round(x, 4), round(y, 4)]

    first = result.motion[names[0]]
    fixed = {label: _fixed(result, names, label) for label in first.pins}
    index_of = {part.name: index for index, part in enumerate(result.parts)}
    stretch_of = {name: k for k, name in enumerate(names)}
    return {
        "tip": round(TIP * layout.unit, 6),
        "joints": len(layout.joints),
        "marks": [
            [*place(*mark), round(lift, 4)]
            for mark, lift in zip(layout.marks, picture.lifts, strict=True)
        ],
        "spans": [
            [*(value for end in both_ends(force) for value in place(*end)), round(float(barrel), 4)]
            for force, barrel in zip(layout.reaching, layout.barrels, strict=True)
        ],
        "pushes": [place(*_pushed(force.coordinate)) for force in layout.efforts],
        "turning": [place(*entry(linkage, force.coordinate)) for force in layout.turning],
        "pins": [
            {
                "name": brief(pin.interface, 40),
                "part": index_of.get(pin.on, -1),
                "body": order[first.bodies[pin.on]],
                "at": fixed[label],
            }
            for label, pin in first.pins.items()
        ],
        "parts": [_drawn_as(first, part.name, layout) for part in result.parts],
        "names": [brief(part.name, 40) for part in result.parts],
        "efforts": list(_efforts(layout)),
        "cycles": [
            _cycle(result.motion[name], layout, stretch_of[name], fixed)
            if name in stretch_of
            else None
            for name in result.cycles
        ],
    }


def _pushed(coordinate: Any) -> tuple[str, str]:
    """Body and point that a force acts on; of one between two points the second."""
    if isinstance(coordinate, PointCoordinate):
        return coordinate.body, coordinate.point
    return coordinate.body_b, coordinate.point_b


def _drawn_as(motion: PartsMotion, name: str, layout: Layout) -> dict[str, int | None] | None:
    """Body of the picture that is a part, or the pin that it is."""
    if name not in motion.parts:
        return None
    number_of = layout.linkage.body_names.index(motion.bodies[name])
    points = {pin.point for pin in motion.pins.values() if pin.on == name}
    if len(points) > 1:  # a pin has all its forces at one point, a body's part at several
        return {"body": number_of, "mark": None}
    marks = [
        k
        for k, mark in enumerate(layout.marks)
        if np.hypot(*(motion.point(*mark)[0] - motion.parts[name][0, :2])) < 1e-6 * layout.size
    ]
    return {"body": number_of, "mark": marks[0] if marks else None}


def _fixed(result: DesignResult, names: Sequence[str], label: str) -> list[float] | None:
    """Where a pin's force acts on its part's body, mm; None where that changes."""
    own = []
    for name in names:
        motion = result.motion[name]
        pin: PinForce = motion.pins[label]
        body = motion.linkage.body_names.index(motion.bodies[pin.on])
        x, y, angle = motion.poses[:, body].T
        across, up = (pin.place - np.column_stack([x, y])).T
        c, s = np.cos(angle), np.sin(angle)
        own.append(np.column_stack([c * across + s * up, -s * across + c * up]))
    places = np.concatenate(own)
    size = max(float(np.abs(places).max()), 1.0)
    if float(np.ptp(places, axis=0).max()) > _STAYS * size:
        return None
    x, y = places[0]
    return [round(float(x), 4), round(float(y), 4)]


def _efforts(layout: Layout) -> Iterator[dict[str, Any]]:
    """Names of forces and torques, with the unit in which all their values are read well."""
    for force in (*layout.efforts, *layout.turning):
        angular = isinstance(force.coordinate, Angle)
        most = max(float(np.abs(cycle.efforts[force.name]).max()) for cycle in layout.cycles)
        unit, factor = quantity_unit(angular, most)
        yield {"name": brief(force.name, 24), "unit": unit, "factor": factor}


def _cycle(
    motion: PartsMotion, layout: Layout, k: int, fixed: dict[str, list[float] | None]
) -> dict[str, Any]:
    """Series of one cycle, in the order of the lists of `_data`."""
    stretch = layout.stretches[k]

    def both(vectors: FloatArray) -> list[dict[str, Any]]:
        return [series(vectors[:, 0]), series(vectors[:, 1])]

    sliding = [label for label, place in fixed.items() if place is None]
    return {
        "index": motion.index.tolist(),
        "scale": ARROW * layout.size / (layout.largest[k] or 1.0),
        "longest": force_text(layout.largest[k]),
        "turned": layout.turned[k] or 1.0,
        "poses": [
            series(motion.poses[:, body, axis])
            for body in range(1, motion.poses.shape[1])
            for axis in range(3)
        ],
        "reactions": [one for force in layout.forces for one in both(force[stretch])],
        "pushes": [one for _, force in layout.pushes for one in both(force[stretch])],
        "efforts": [
            series(motion.efforts[force.name]) for force in (*layout.efforts, *layout.turning)
        ],
        "torques": [series(layout.torques[stretch, i]) for i in range(len(layout.turning))],
        "pins": [one for pin in motion.pins.values() for one in both(pin.force)],
        "places": [one for label in sliding for one in both(motion.pins[label].place)],
    }


# A picture of the mechanism as SVG, and the numbers by which a page's script moves it.
#
# Lengths are mm of the machine; y points down in SVG, so y and angles change their sign here.

_MOST_FRAMES = 240


def mechanism_svg(cycle: ShownCycle, prefix: str) -> str:
    """The linkage as it is assembled: bodies, pivots, guides, slots and the paths of its points.

    Every moving thing has an id that begins with `prefix`, for the script; arrows are hidden.
    """
    label = f"The mechanism in cycle {brief(cycle.name, 40)}, as it is assembled"
    return Picture(Layout(cycle.loads), prefix).svg(label)


def mechanism_data(cycle: ShownCycle, prefix: str) -> dict[str, Any]:
    """Data for the script to show any position: poses, points, arrows and readings by frame."""
    loads = cycle.loads
    layout = Layout(loads)
    frames = _frames(len(loads.times))
    poses = loads.poses[frames, 1:]
    moved = np.stack([poses[..., 0], -poses[..., 1], -np.degrees(poses[..., 2])], axis=-1)
    torques = layout.torques[frames] * layout.scaled(layout.turned)[frames, None]
    return {
        "prefix": prefix,
        "bodies": _rounded(moved.reshape(len(frames), -1), 3),
        "points": _rounded(layout.marked[frames].reshape(len(frames), -1), 3),
        "spans": _rounded(layout.span_ends[frames].reshape(len(frames), -1), 3),
        "arrows": _rounded(layout.arrow_ends[frames].reshape(len(frames), -1), 3),
        "barrels": [_rounded(length, 3) for length in layout.barrels],
        "torques": _rounded(torques, 4),
        "centres": _rounded(layout.centres[frames].reshape(len(frames), -1), 3),
        "times": _rounded(loads.times[frames], 6),
        "readings": [_reading(cycle, int(frame)) for frame in frames],
        "duration": cycle.duration,
        "lifts": [round(lift, 3) for lift in Picture(layout, prefix).lifts],
        "tip": TIP * layout.unit,
    }


def arrow_scale(cycle: ShownCycle) -> str:
    """Force that the longest arrow of the picture stands for, in words."""
    return force_text(Layout(cycle.loads).largest[0])


def force_text(force: float) -> str:
    """A force in the unit in which it is read well, N or kN."""
    unit, factor = quantity_unit(False, force)
    return f"{number(force * factor, 4)} {unit}"


def _frames(n: int) -> Any:
    return np.unique(np.linspace(0, n - 1, min(n, _MOST_FRAMES)).round().astype(int))


def _rounded(values: FloatArray, digits: int) -> Any:
    return (np.round(values, digits) + 0.0).tolist()


def _reading(cycle: ShownCycle, index: int) -> str:
    """Position, phase, time and efforts in one line."""
    said = [
        f"{brief(cycle.shown_name, 20)} = {cycle.shown[index] + 0.0:.1f} {cycle.unit}",
        f"{cycle.loads.times[index]:.3f} s",
        brief(cycle.phase_at(index), 24),
    ]
    for effort in cycle.efforts:
        unit, factor = quantity_unit(effort.angular, effort.largest)
        value = float(cycle.loads.efforts[effort.quantity][index])
        if abs(value) < 1e-9 * effort.largest:
            value = 0.0
        said.append(f"{brief(effort.quantity, 24)} {number(value * factor)} {unit}")
    return " · ".join(said)
