"""A picture of the mechanism as SVG, and the numbers by which a page's script moves it.

Lengths are mm of the machine; y points down in SVG, so y and angles change their sign here.
Widths, letters and marks are shares of the picture's size.
"""

from collections.abc import Iterator
from html import escape
from math import degrees, hypot
from typing import Any

import numpy as np

from loads import GROUND, Angle, CycleLoads, Distance, Fixed, PointCoordinate, Prismatic, Revolute
from reports.loads_figures import FloatArray
from reports.loads_summary import ShownCycle
from reports.mechanism_places import at_one_point, both_ends, entry, flipped, hull, same
from reports.words import brief, number, quantity_unit

_MOST_FRAMES = 240
_ARROW = 0.2  # length of the longest arrow over the picture's size
_TINTS = 7  # colours of series that the page has
_BY_POINT = 2.4  # where a name stands beside its point, in shares (%) of the picture's size
_BY_TORQUE = 5.6


def mechanism_svg(cycle: ShownCycle, prefix: str) -> str:
    """The linkage as it is assembled: bodies, pivots, guides, slots and the paths of its points.

    Every moving thing has an id that begins with `prefix`, for the script; arrows are hidden.
    """
    drawing = _Drawing(cycle.loads)
    x, y, width, height = drawing.box
    unit = drawing.unit
    label = f"The mechanism in cycle {brief(cycle.name, 40)}, as it is assembled"
    parts = [
        f'<svg class="mechanism" role="img" aria-label="{escape(label)}" '
        f'viewBox="{x:.6g} {y:.6g} {width:.6g} {height:.6g}" '
        f'style="--u: {unit:.6g}px">',
        *drawing.paths(),
        *drawing.ground(),
        *drawing.bodies(prefix),
        *drawing.spans(prefix),
        *drawing.pins(prefix),
        *drawing.arrows(prefix),
        *drawing.labels(prefix),
        "</svg>",
    ]
    return "\n".join(parts)


def mechanism_data(cycle: ShownCycle, prefix: str) -> dict[str, Any]:
    """What the script needs to show any position: poses, points, arrows and readings by frame."""
    loads = cycle.loads
    drawing = _Drawing(loads)
    frames = _frames(len(loads.times))
    poses = loads.poses[frames, 1:]
    moved = np.stack([poses[..., 0], -poses[..., 1], -np.degrees(poses[..., 2])], axis=-1)
    return {
        "prefix": prefix,
        "bodies": _rounded(moved.reshape(len(frames), -1), 3),
        "points": _rounded(drawing.marked[frames].reshape(len(frames), -1), 3),
        "spans": _rounded(drawing.span_ends[frames].reshape(len(frames), -1), 3),
        "arrows": _rounded(drawing.arrow_ends[frames].reshape(len(frames), -1), 3),
        "barrels": [_rounded(length, 3) for length in drawing.barrels],
        "torques": _rounded(drawing.torques[frames] / (drawing.largest_torque or 1.0), 4),
        "centres": _rounded(drawing.centres[frames].reshape(len(frames), -1), 3),
        "times": _rounded(loads.times[frames], 6),
        "readings": [_reading(cycle, int(frame)) for frame in frames],
        "duration": cycle.duration,
        "lifts": [round(lift, 3) for lift in drawing.lifts],
        "tip": 1.4 * drawing.unit,
    }


def arrow_scale(cycle: ShownCycle) -> str:
    """How large a force the longest arrow of the picture stands for, in words."""
    largest = _Drawing(cycle.loads).largest_force
    unit, factor = quantity_unit(False, largest)
    return f"{number(largest * factor, 4)} {unit}"


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


class _Drawing:
    """Places and elements of one picture."""

    def __init__(self, loads: CycleLoads) -> None:
        self.loads = loads
        linkage = loads.linkage
        self.joints = linkage.joints
        # the joints' points of body b, where they are marked and their reactions drawn
        self.marks = [(joint.body_b, joint.point_b) for joint in self.joints]
        self.marks += self._loaded_points()
        self.places = [loads.point(*mark) for mark in self.marks]
        self.assembled = {
            GROUND: (0.0, 0.0, 0.0),
            **{name: tuple(pose) for name, pose in linkage.assembled.items()},
        }
        every = [loads.point(body.name, point) for body in linkage.bodies for point in body.points]
        corners = np.concatenate([*every, *(self._line(k) for k in self._lines())])
        low, high = corners.min(axis=0), corners.max(axis=0)
        self.size = max(float(np.max(high - low)), 1e-9)
        self.unit = self.size / 100.0
        forces = [loads.reactions[joint.name].force for joint in self.joints]
        self.efforts = [f for f in linkage.forces if not isinstance(f.coordinate, Angle)]
        pushes = [self._push(force.name) for force in self.efforts]
        self.largest_force = max(
            (float(np.hypot(*force.T).max()) for force in (*forces, *(f for _, f in pushes))),
            default=0.0,
        )
        scale = _ARROW * self.size / (self.largest_force or 1.0)
        ends = [
            *(
                np.concatenate([p, p + scale * f], axis=1)
                for p, f in zip(self.places, forces, strict=False)  # joints come first
            ),
            # a pushing force is drawn up to the point where it acts
            *(np.concatenate([p - scale * f, p], axis=1) for p, f in pushes),
        ]
        self.arrow_ends = flipped(np.stack(ends, axis=1))
        tips = np.concatenate([*ends]).reshape(-1, 2)
        low = np.minimum(low - 0.08 * self.size, tips.min(axis=0)) - 0.04 * self.size
        high = np.maximum(high + 0.08 * self.size, tips.max(axis=0)) + 0.04 * self.size
        wide, tall = high - low
        self.box = (float(low[0]), float(-high[1]), float(wide), float(tall))
        self.marked = flipped(np.stack(self.places, axis=1))
        self.reaching = [f for f in linkage.forces if isinstance(f.coordinate, Distance)]
        self.span_ends = flipped(
            np.stack([self._ends(force.coordinate) for force in self.reaching], axis=1)
            if self.reaching
            else np.zeros((len(loads.times), 0, 4))
        )
        lengths = np.hypot(
            self.span_ends[..., 2] - self.span_ends[..., 0],
            self.span_ends[..., 3] - self.span_ends[..., 1],
        )
        self.barrels = 0.75 * lengths.min(axis=0)
        self.turning = [f for f in linkage.forces if isinstance(f.coordinate, Angle)]
        centres = [loads.point(*entry(loads, force.coordinate)) for force in self.turning]
        self.centres = flipped(
            np.stack(centres, axis=1) if centres else np.zeros((len(loads.times), 0, 2))
        )
        torques = [force.sign * loads.efforts[force.name] for force in self.turning]
        self.torques = np.stack(torques, axis=1) if torques else np.zeros((len(loads.times), 0))
        self.largest_torque = float(np.abs(self.torques).max(initial=0.0))

    def _loaded_points(self) -> list[tuple[str, str]]:
        """Body and point of forces that act where no joint is."""
        known = {
            (body, point)
            for joint in self.joints
            for body, point in ((joint.body_a, joint.point_a), (joint.body_b, joint.point_b))
        }
        found = []
        for force in self.loads.linkage.forces:
            coordinate = force.coordinate
            if isinstance(coordinate, PointCoordinate):
                found.append((coordinate.body, coordinate.point))
            elif isinstance(coordinate, Distance):
                found.append((coordinate.body_a, coordinate.point_a))
                found.append((coordinate.body_b, coordinate.point_b))
        return [mark for mark in dict.fromkeys(found) if mark not in known]

    def _ends(self, span: Any) -> FloatArray:
        assert isinstance(span, Distance)
        return np.concatenate(
            [
                self.loads.point(span.body_a, span.point_a),
                self.loads.point(span.body_b, span.point_b),
            ],
            axis=1,
        )

    def _push(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Where a force acts on its (second) body, and its force there (n, 2)."""
        force = self.loads.linkage.force(name)
        coordinate, effort = force.coordinate, force.sign * self.loads.efforts[name][:, None]
        if isinstance(coordinate, PointCoordinate):
            direction = np.array(coordinate.direction) / hypot(*coordinate.direction)
            return self.loads.point(coordinate.body, coordinate.point), effort * direction
        assert isinstance(coordinate, Distance)
        ends = self._ends(coordinate)
        along = ends[:, 2:] - ends[:, :2]
        return ends[:, 2:], effort * along / np.hypot(*along.T)[:, None]

    def _lines(self) -> list[int]:
        return [k for k, joint in enumerate(self.joints) if not at_one_point(joint)]

    def _line(self, k: int) -> FloatArray:
        """The stretch of its line that a slot or guide uses, in the frame of body a (2, 2)."""
        joint = self.joints[k]
        assert not isinstance(joint, Revolute | Fixed)
        travel = self.loads.travel(joint.name)
        low, high = joint.ends or (float(travel.min()), float(travel.max()))
        start = np.array(self.loads.linkage.body(joint.body_a).place(joint.point_a))
        along = np.array(joint.direction) / hypot(*joint.direction)
        return np.array([start + low * along, start + high * along])

    def _point(self, body: str, point: str) -> tuple[float, float]:
        """Where a point of the assembled linkage is drawn."""
        x, y = self.loads.linkage.body(body).place(point)
        x0, y0, angle = self.assembled[body]
        c, s = float(np.cos(angle)), float(np.sin(angle))
        return x0 + c * x - s * y, -(y0 + s * x + c * y)

    def paths(self) -> Iterator[str]:
        """The ways of the points."""
        for (_, name), place in zip(self.marks, self.places, strict=True):
            if np.ptp(place, axis=0).max() < 1e-6 * self.size:
                continue
            points = " ".join(f"{x:.5g},{-y:.5g}" for x, y in place[:: max(1, len(place) // 180)])
            title = f"<title>way of {escape(brief(name, 30))}</title>"
            yield f'<polyline class="way" points="{points}">{title}</polyline>'

    def ground(self) -> Iterator[str]:
        """Pivots on the ground, and the guides and slots that it has."""
        u = self.unit
        yield from self._rails(GROUND)
        for joint in self.joints:
            if isinstance(joint, Revolute | Fixed) and GROUND in (joint.body_a, joint.body_b):
                x, y = self._point(GROUND, joint.point)
                yield (
                    f'<path class="pivot" d="M{x:.5g} {y:.5g}l{-3 * u:.5g} {5 * u:.5g}'
                    f'h{6 * u:.5g}z"/><path class="hatch" d="M{x - 4.4 * u:.5g} {y + 5 * u:.5g}'
                    f'h{8.8 * u:.5g}"/>'
                )
        for force in self.reaching:
            span = force.coordinate
            assert isinstance(span, Distance)
            for body, point in ((span.body_a, span.point_a), (span.body_b, span.point_b)):
                if body == GROUND:
                    x, y = self._point(body, point)
                    yield (
                        f'<path class="pivot" d="M{x:.5g} {y:.5g}l{-3 * u:.5g} {5 * u:.5g}'
                        f'h{6 * u:.5g}z"/>'
                    )

    def _rails(self, body: str) -> Iterator[str]:
        """Guides and slots whose line this body has, in its frame."""
        for k in self._lines():
            joint = self.joints[k]
            if joint.body_a != body:
                continue
            (x0, y0), (x1, y1) = self._line(k)
            kind = "rail" if isinstance(joint, Prismatic) else "slot"
            over = 5 * self.unit / max(hypot(x1 - x0, y1 - y0), 1e-9)
            if kind == "rail":  # a guide is drawn as long as the body that slides on it needs
                x0, y0, x1, y1 = (
                    x0 - over * (x1 - x0), y0 - over * (y1 - y0),
                    x1 + over * (x1 - x0), y1 + over * (y1 - y0),
                )  # fmt: skip
            line = f'x1="{x0:.5g}" y1="{-y0:.5g}" x2="{x1:.5g}" y2="{-y1:.5g}"'
            yield f'<line class="{kind}" {line}/>'
            if kind == "slot":
                yield f'<line class="slot inner" {line}/>'

    def bodies(self, prefix: str) -> Iterator[str]:
        """Every moving body in its own frame, behind a transform."""
        for index, body in enumerate(self.loads.linkage.moving):
            x, y, angle = self.assembled[body.name]
            tint = index % _TINTS
            yield (
                f'<g id="{prefix}-body-{index}" class="body tint{tint}" '
                f'transform="translate({x:.6g} {-y:.6g}) rotate({-degrees(angle):.6g})">'
                f"<title>{escape(brief(body.name, 60))}</title>"
            )
            yield from self._rails(body.name)
            # a body reaches at least as far as the lines that it has
            lines = [self._line(k) for k in self._lines() if self.joints[k].body_a == body.name]
            places = [np.array(list(body.points.values()), dtype=float).reshape(-1, 2), *lines]
            outline = hull(np.concatenate(places) * [1.0, -1.0])
            if len(outline) > 1:
                shape = "M" + "L".join(f"{px:.5g} {py:.5g}" for px, py in outline)
                yield f'<path class="link" d="{shape}{"z" if len(outline) > 2 else ""}"/>'
            yield from self._sliders(body.name)
            yield "</g>"

    def _sliders(self, body: str) -> Iterator[str]:
        """A block where a body is guided."""
        u = self.unit
        for joint in self.joints:
            if not isinstance(joint, Prismatic) or joint.body_b != body:
                continue
            x, y = self.loads.linkage.body(body).place(joint.point_b)
            along = np.degrees(np.arctan2(joint.direction[1], joint.direction[0]))
            turned = self.assembled[body][2] - self.assembled[joint.body_a][2]
            angle = -along + np.degrees(turned)
            yield (
                f'<rect class="block" x="{x - 5 * u:.5g}" y="{-y - 3 * u:.5g}" '
                f'width="{10 * u:.5g}" height="{6 * u:.5g}" rx="{0.8 * u:.5g}" '
                f'transform="rotate({angle:.6g} {x:.5g} {-y:.5g})"/>'
            )

    def spans(self, prefix: str) -> Iterator[str]:
        """Forces between two points, drawn as the cylinder that gives them."""
        for index, force in enumerate(self.reaching):
            span = force.coordinate
            assert isinstance(span, Distance)
            (x0, y0), (x1, y1) = (
                self._point(span.body_a, span.point_a),
                self._point(span.body_b, span.point_b),
            )
            share = float(self.barrels[index]) / max(hypot(x1 - x0, y1 - y0), 1e-9)
            middle = (x0 + share * (x1 - x0), y0 + share * (y1 - y0))
            yield (
                f'<g class="span"><title>{escape(brief(force.name, 60))}</title>'
                f'<line id="{prefix}-span-{index}" class="rod" x1="{x0:.5g}" y1="{y0:.5g}" '
                f'x2="{x1:.5g}" y2="{y1:.5g}"/>'
                f'<line id="{prefix}-barrel-{index}" class="barrel" x1="{x0:.5g}" y1="{y0:.5g}" '
                f'x2="{middle[0]:.5g}" y2="{middle[1]:.5g}"/></g>'
            )

    def pins(self, prefix: str) -> Iterator[str]:
        """The joints' points and those of forces: circles for pins, squares for welds."""
        for index, (body, point) in enumerate(self.marks):
            x, y = self._point(body, point)
            u = 1.5 * self.unit
            joint = self.joints[index] if index < len(self.joints) else None
            shape = (
                f'<rect x="{-u:.5g}" y="{-u:.5g}" width="{2 * u:.5g}" height="{2 * u:.5g}"/>'
                if isinstance(joint, Fixed)
                else f'<circle r="{u:.5g}"/>'
            )
            spanned = any((body, point) in both_ends(force) for force in self.reaching)
            bare = isinstance(joint, Prismatic) or (joint is None and not spanned)
            hidden = ' visibility="hidden"' if bare else ""
            name = point if joint is None else joint.name
            yield (
                f'<g id="{prefix}-point-{index}" class="pin"{hidden} '
                f'transform="translate({x:.6g} {y:.6g})">'
                f"<title>{escape(brief(name, 60))}</title>{shape}</g>"
            )

    def arrows(self, prefix: str) -> Iterator[str]:
        """Empty arrows of reactions and forces, which the script fills in."""
        names = [f"reaction of {joint.name} on {joint.body_b}" for joint in self.joints]
        names += [force.name for force in self.efforts]
        for index, name in enumerate(names):
            kind = "reaction" if index < len(self.joints) else "effort"
            yield (
                f'<path id="{prefix}-arrow-{index}" class="arrow {kind}">'
                f"<title>{escape(brief(name, 80))}</title></path>"
            )
        for index, force in enumerate(self.turning):
            x, y = self._point(*entry(self.loads, force.coordinate))
            yield (
                f'<path id="{prefix}-torque-{index}" class="arrow effort" '
                f'transform="translate({x:.6g} {y:.6g})">'
                f"<title>{escape(brief(force.name, 60))}</title></path>"
            )

    @property
    def lifts(self) -> list[float]:
        """How far to the right of each point, and above it, its name stands [mm].

        Names keep clear of the arc that shows a torque.
        """
        turned = [self._point(*entry(self.loads, force.coordinate)) for force in self.turning]
        return [
            (_BY_TORQUE if any(same(self._point(*mark), at) for at in turned) else _BY_POINT)
            * self.unit
            for mark in self.marks
        ]

    def labels(self, prefix: str) -> Iterator[str]:
        """Names of the points, one for each place."""
        told: set[tuple[float, float]] = set()
        for index, ((body, point), lift) in enumerate(zip(self.marks, self.lifts, strict=True)):
            x, y = self._point(body, point)
            if (round(x, 6), round(y, 6)) in told:
                continue
            told.add((round(x, 6), round(y, 6)))
            yield (
                f'<text id="{prefix}-label-{index}" x="{x + lift:.6g}" '
                f'y="{y - lift:.6g}">{escape(brief(point, 16))}</text>'
            )
