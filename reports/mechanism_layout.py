"""Layout and elements of a mechanism's picture over one or several cycles of a linkage.

Lengths are mm of the machine; y points down in SVG, so places of the picture have their y changed
in sign. Widths, letters and marks are shares of the picture's size. Every moving thing has an id
that begins with the picture's prefix, for a script.
"""

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from itertools import pairwise
from math import atan2, cos, degrees, hypot, pi, sin
from typing import Any, Protocol

import numpy as np

from checks.result.words import brief
from geometry.mesh import FloatArray
from loads import (
    GROUND,
    Angle,
    Distance,
    Fixed,
    JointLoad,
    Linkage,
    PointCoordinate,
    Prismatic,
    Revolute,
)

ARROW = 0.2  # length of the longest arrow over the picture's size


class Drawable(Protocol):
    """A cycle that can be drawn: `loads.CycleLoads`, or the thinned `Motion`."""

    @property
    def linkage(self) -> Linkage:
        """The mechanism."""

    @property
    def times(self) -> FloatArray:
        """(k,) s, from the start of the cycle."""

    @property
    def poses(self) -> FloatArray:
        """(k, bodies, 3): mm, mm, rad."""

    @property
    def reactions(self) -> Mapping[str, JointLoad]:
        """Forces and moments at each joint."""

    @property
    def efforts(self) -> Mapping[str, FloatArray]:
        """(k,) N or N mm of each force and torque of the linkage."""

    def point(self, body: str, point: str) -> FloatArray:
        """Positions (k, 2) of a point of a body, mm."""

    def travel(self, joint: str) -> FloatArray:
        """Travel of a pin along its slot or guide (k,), mm."""


class Layout:
    """Places of one picture, of all frames of its cycles one behind the other.

    cycles       of one linkage
    others       places (n, 2) mm and forces (n, 2) N that must have room, too
    stretches    the frames of each cycle
    marks        (body, point) of every joint's point on its body b, then of forces elsewhere
    marked       (n, marks, 2) mm
    box          x, y, width, height of the picture, mm
    size, unit   the linkage's larger side, and a hundredth of it, mm
    largest      largest force of each cycle, N: the longest arrow
    arrow_ends   (n, joints + efforts, 4) mm, from where to where
    reaching     forces between two points; span_ends (n, them, 4) mm, barrels their length, mm
    turning      torques; centres (n, them, 2) mm, torques (n, them) N mm
    turned       largest torque of each cycle, N mm
    """

    def __init__(
        self, *cycles: Drawable, others: Sequence[tuple[FloatArray, FloatArray]] = ()
    ) -> None:
        self.cycles = cycles
        self.linkage = linkage = cycles[0].linkage
        ends = np.cumsum([0, *(len(cycle.times) for cycle in cycles)]).tolist()
        self.stretches = [slice(first, last) for first, last in pairwise(ends)]
        self.joints = linkage.joints
        self.marks = [(joint.body_b, joint.point_b) for joint in self.joints]
        self.marks += self._loaded_points()
        self.places = [self.point(*mark) for mark in self.marks]
        every = [self.point(body.name, point) for body in linkage.bodies for point in body.points]
        corners = np.concatenate([*every, *(self.line(k) for k in self.lines)])
        low, high = corners.min(axis=0), corners.max(axis=0)
        self.size = max(float(np.max(high - low)), 1e-9)
        self.unit = self.size / 100.0
        self.forces = [
            np.concatenate([cycle.reactions[joint.name].force for cycle in cycles])
            for joint in self.joints
        ]
        self.efforts = [f for f in linkage.forces if not isinstance(f.coordinate, Angle)]
        self.pushes = [self._push(force.name) for force in self.efforts]
        drawn = (
            *self.forces,
            *(force for _, force in self.pushes),
            *(force for _, force in others),
        )
        self.largest = self._most([np.hypot(*force.T) for force in drawn])
        self._place_arrows(low, high, others)
        self.marked = flipped(np.stack(self.places, axis=1))
        self.reaching = [f for f in linkage.forces if isinstance(f.coordinate, Distance)]
        self.span_ends = flipped(
            self._stacked([self._ends(force.coordinate) for force in self.reaching], 4)
        )
        lengths = np.hypot(
            self.span_ends[..., 2] - self.span_ends[..., 0],
            self.span_ends[..., 3] - self.span_ends[..., 1],
        )
        self.barrels = 0.75 * lengths.min(axis=0)
        self.turning = [f for f in linkage.forces if isinstance(f.coordinate, Angle)]
        self.centres = flipped(
            self._stacked([self.point(*entry(linkage, f.coordinate)) for f in self.turning], 2)
        )
        torques = [force.sign * self._effort(force.name) for force in self.turning]
        self.torques = np.stack(torques, axis=1) if torques else np.zeros((self.n, 0))
        self.turned = self._most([np.abs(torque) for torque in torques])

    @property
    def n(self) -> int:
        """Frames of all cycles together."""
        return sum(len(cycle.times) for cycle in self.cycles)

    def scaled(self, largest: Sequence[float]) -> FloatArray:
        """One over the largest value of its cycle for every frame (n,); of 0 it is 1."""
        shares = np.ones(self.n)
        for stretch, value in zip(self.stretches, largest, strict=True):
            shares[stretch] = 1.0 / (value or 1.0)
        return shares

    def point(self, body: str, point: str) -> FloatArray:
        """Positions (n, 2) of a point of a body, mm."""
        return np.concatenate([cycle.point(body, point) for cycle in self.cycles])

    @property
    def lines(self) -> list[int]:
        """Joints along a line: slots and guides."""
        return [k for k, joint in enumerate(self.joints) if not at_one_point(joint)]

    def line(self, k: int) -> FloatArray:
        """The stretch of its line that a slot or guide uses, in the frame of body a (2, 2)."""
        joint = self.joints[k]
        assert not isinstance(joint, Revolute | Fixed)
        travel = np.concatenate([cycle.travel(joint.name) for cycle in self.cycles])
        low, high = joint.ends or (float(travel.min()), float(travel.max()))
        start = np.array(self.linkage.body(joint.body_a).place(joint.point_a))
        along = np.array(joint.direction) / hypot(*joint.direction)
        return np.array([start + low * along, start + high * along])

    def poses_at(self, frame: int | None) -> dict[str, tuple[float, float, float]]:
        """Pose of every body at a frame, or as it is assembled."""
        if frame is None:
            return {GROUND: (0.0, 0.0, 0.0), **self.linkage.assembled}
        k = next(k for k, stretch in enumerate(self.stretches) if frame < stretch.stop)
        poses = self.cycles[k].poses[frame - self.stretches[k].start]
        return {
            name: (float(x), float(y), float(angle))
            for name, (x, y, angle) in zip(self.linkage.body_names, poses, strict=True)
        }

    def _place_arrows(
        self, low: FloatArray, high: FloatArray, others: Sequence[tuple[FloatArray, FloatArray]]
    ) -> None:
        scale = (ARROW * self.size * self.scaled(self.largest))[:, None]
        ends = [
            *(
                np.concatenate([p, p + scale * f], axis=1)
                for p, f in zip(self.places, self.forces, strict=False)  # joints come first
            ),
            # a pushing force is drawn up to the point where it acts
            *(np.concatenate([p - scale * f, p], axis=1) for p, f in self.pushes),
        ]
        self.arrow_ends = flipped(np.stack(ends, axis=1))
        ends += [np.concatenate([p, p + scale * f], axis=1) for p, f in others]
        tips = np.concatenate(ends).reshape(-1, 2)
        low = np.minimum(low - 0.08 * self.size, tips.min(axis=0)) - 0.04 * self.size
        high = np.maximum(high + 0.08 * self.size, tips.max(axis=0)) + 0.04 * self.size
        wide, tall = high - low
        self.box = (float(low[0]), float(-high[1]), float(wide), float(tall))

    def _most(self, sizes: Sequence[FloatArray]) -> list[float]:
        """The largest of some values (n,) in each cycle."""
        return [
            max((float(size[stretch].max()) for size in sizes), default=0.0)
            for stretch in self.stretches
        ]

    def _stacked(self, places: Sequence[FloatArray], wide: int) -> FloatArray:
        return np.stack(places, axis=1) if places else np.zeros((self.n, 0, wide))

    def _effort(self, name: str) -> FloatArray:
        return np.concatenate([cycle.efforts[name] for cycle in self.cycles])

    def _loaded_points(self) -> list[tuple[str, str]]:
        """Body and point of forces that act where no joint is."""
        known = {
            (body, point)
            for joint in self.joints
            for body, point in ((joint.body_a, joint.point_a), (joint.body_b, joint.point_b))
        }
        found = []
        for force in self.linkage.forces:
            coordinate = force.coordinate
            if isinstance(coordinate, PointCoordinate):
                found.append((coordinate.body, coordinate.point))
            elif isinstance(coordinate, Distance):
                found.append((coordinate.body_a, coordinate.point_a))
                found.append((coordinate.body_b, coordinate.point_b))
        return [mark for mark in dict.fromkeys(found) if mark not in known]

    def _ends(self, span: Any) -> FloatArray:
        assert isinstance(span, Distance)
        ends = (self.point(span.body_a, span.point_a), self.point(span.body_b, span.point_b))
        return np.concatenate(ends, axis=1)

    def _push(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Point of action of a force on its (second) body, and the force there (n, 2)."""
        force = self.linkage.force(name)
        coordinate, effort = force.coordinate, force.sign * self._effort(name)[:, None]
        if isinstance(coordinate, PointCoordinate):
            row = self.linkage.body_names.index(coordinate.follows)
            turned = np.concatenate([cycle.poses[:, row, 2] for cycle in self.cycles])
            x, y = coordinate.direction
            angle = turned + atan2(y, x)
            direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)
            return self.point(coordinate.body, coordinate.point), effort * direction
        assert isinstance(coordinate, Distance)
        ends = self._ends(coordinate)
        along = ends[:, 2:] - ends[:, :2]
        return ends[:, 2:], effort * along / np.hypot(*along.T)[:, None]

    def is_rail(self, k: int) -> bool:
        """Return True if a joint along a line is a guide, not a slot."""
        return isinstance(self.joints[k], Prismatic)


# Places of a mechanism's picture: ends of forces, entries of torques, outlines of bodies.


def both_ends(force: Any) -> tuple[tuple[str, str], ...]:
    """Body and point of either end of a force between two points."""
    span = force.coordinate
    return (span.body_a, span.point_a), (span.body_b, span.point_b)


def same(first: tuple[float, float], second: tuple[float, float]) -> bool:
    """Return True if two places, mm, are the same within 1e-6 mm."""
    return hypot(first[0] - second[0], first[1] - second[1]) < 1e-6


def entry(linkage: Linkage, coordinate: Any) -> tuple[str, str]:
    """Body and point at which a torque is drawn: where it enters, else the body's first point."""
    assert isinstance(coordinate, Angle)
    points = linkage.body(coordinate.body).points
    return coordinate.body, coordinate.point or next(iter(points))


def at_one_point(joint: Any) -> bool:
    """Return True if a joint is at a point of both bodies, not along a line."""
    return isinstance(joint, Revolute | Fixed)


def arrow_path(ends: FloatArray, tip: float) -> str:
    """Path of an arrow from (x, y) to (x, y); none where it is too short for its tip of a size."""
    x0, y0, x1, y1 = (float(value) for value in ends)
    length = hypot(x1 - x0, y1 - y0)
    if length < 0.4 * tip:
        return ""
    ux, uy = tip * (x1 - x0) / length, tip * (y1 - y0) / length
    sides = ((2 * ux + uy, 2 * uy - ux), (2 * ux - uy, 2 * uy + ux))
    head = "".join(f"M{x1:.5g} {y1:.5g}L{x1 - dx:.5g} {y1 - dy:.5g}" for dx, dy in sides)
    return f"M{x0:.5g} {y0:.5g}L{x1:.5g} {y1:.5g}{head}"


def bent_path(share: float, tip: float) -> str:
    """Path of an arc about the origin, the longer the larger a torque; above 0 it goes ccw."""
    if abs(share) < 0.02:
        return ""
    radius, turn, way = 5 * tip, 1.6 * pi * abs(share), -1.0 if share > 0 else 1.0
    c, s = cos(way * turn), sin(way * turn)
    x, y, ux, uy = radius * c, radius * s, -way * s * tip, way * c * tip
    sides = ((2 * ux + uy, 2 * uy - ux), (2 * ux - uy, 2 * uy + ux))
    head = "".join(f"M{x:.5g} {y:.5g}L{x - dx:.5g} {y - dy:.5g}" for dx, dy in sides)
    flags = f"{int(turn > pi)} {int(way > 0)}"
    return f"M{radius:.5g} 0A{radius:.5g} {radius:.5g} 0 {flags} {x:.5g} {y:.5g}{head}"


def flipped(values: FloatArray) -> FloatArray:
    """Places (n, m, 2 or 4) with the signs of their y changed."""
    result = values.copy()
    result[..., 1::2] *= -1.0
    return result


def hull(points: FloatArray) -> list[tuple[float, float]]:
    """The convex hull of points in order (Andrew's monotone chain); two ends if all are in line."""
    places = sorted({(round(float(x), 9), round(float(y), 9)) for x, y in points})
    if len(places) < 3:
        return places

    def chain(ordered: list[tuple[float, float]]) -> list[tuple[float, float]]:
        kept: list[tuple[float, float]] = []
        for x, y in ordered:
            while len(kept) > 1:
                (x0, y0), (x1, y1) = kept[-2:]
                if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 0:
                    break
                kept.pop()
            kept.append((x, y))
        return kept[:-1]

    return chain(places) + chain(places[::-1])


# The elements of a mechanism's picture: bodies, pivots, guides, slots, forces and names.
_TINTS = 7  # colours of series that the page has
_BY_POINT = 2.4  # where a name stands beside its point, in shares (%) of the picture's size
_BY_TORQUE = 5.6
TIP = 1.4  # half the width of an arrow's tip, likewise


class Picture:
    """The elements, with the bodies as they are assembled or at one frame of the layout."""

    def __init__(self, layout: Layout, prefix: str, frame: int | None = None) -> None:
        self.layout, self.prefix, self.frame = layout, prefix, frame
        self.unit, self.joints, self.marks = layout.unit, layout.joints, layout.marks
        self.drawn = layout.poses_at(frame)

    def svg(self, label: str) -> str:
        """The whole picture as an SVG element."""
        x, y, width, height = self.layout.box
        parts = [
            f'<svg class="mechanism" role="img" aria-label="{escape(label)}" '
            f'viewBox="{x:.6g} {y:.6g} {width:.6g} {height:.6g}" '
            f'style="--u: {self.unit:.6g}px">',
            *self.paths(),
            *self.ground(),
            *self.bodies(),
            *self.spans(),
            *self.pins(),
            *self.arrows(),
            *self.labels(),
            "</svg>",
        ]
        return "\n".join(parts)

    def _point(self, body: str, point: str) -> tuple[float, float]:
        """Where a point of a body is drawn."""
        x, y = self.layout.linkage.body(body).place(point)
        x0, y0, angle = self.drawn[body]
        c, s = float(np.cos(angle)), float(np.sin(angle))
        return x0 + c * x - s * y, -(y0 + s * x + c * y)

    def paths(self) -> Iterator[str]:
        """The ways of the points, once where cycles have the same."""
        layout, told = self.layout, set()
        for (_, name), place in zip(self.marks, layout.places, strict=True):
            for stretch in layout.stretches:
                way = place[stretch]
                if np.ptp(way, axis=0).max() < 1e-6 * layout.size:
                    continue
                points = " ".join(f"{x:.5g},{-y:.5g}" for x, y in way[:: max(1, len(way) // 180)])
                if points not in told:
                    told.add(points)
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
        for force in self.layout.reaching:
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
        for k in self.layout.lines:
            joint = self.joints[k]
            if joint.body_a != body:
                continue
            (x0, y0), (x1, y1) = self.layout.line(k)
            kind = "rail" if self.layout.is_rail(k) else "slot"
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

    def bodies(self) -> Iterator[str]:
        """Every moving body in its own frame, behind a transform."""
        for index, body in enumerate(self.layout.linkage.moving):
            x, y, angle = self.drawn[body.name]
            tint = index % _TINTS
            yield (
                f'<g id="{self.prefix}-body-{index}" class="body tint{tint}" '
                f'transform="translate({x:.6g} {-y:.6g}) rotate({-degrees(angle):.6g})">'
                f"<title>{escape(brief(body.name, 60))}</title>"
            )
            yield from self._rails(body.name)
            # a body reaches at least as far as the lines that it has
            own = [k for k in self.layout.lines if self.joints[k].body_a == body.name]
            lines = [self.layout.line(k) for k in own]
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
            x, y = self.layout.linkage.body(body).place(joint.point_b)
            along = np.degrees(np.arctan2(joint.direction[1], joint.direction[0]))
            turned = self.drawn[body][2] - self.drawn[joint.body_a][2]
            angle = -along + np.degrees(turned)
            yield (
                f'<rect class="block" x="{x - 5 * u:.5g}" y="{-y - 3 * u:.5g}" '
                f'width="{10 * u:.5g}" height="{6 * u:.5g}" rx="{0.8 * u:.5g}" '
                f'transform="rotate({angle:.6g} {x:.5g} {-y:.5g})"/>'
            )

    def spans(self) -> Iterator[str]:
        """Forces between two points, drawn as the cylinder that gives them."""
        for index, force in enumerate(self.layout.reaching):
            span = force.coordinate
            assert isinstance(span, Distance)
            (x0, y0), (x1, y1) = (
                self._point(span.body_a, span.point_a),
                self._point(span.body_b, span.point_b),
            )
            share = float(self.layout.barrels[index]) / max(hypot(x1 - x0, y1 - y0), 1e-9)
            middle = (x0 + share * (x1 - x0), y0 + share * (y1 - y0))
            yield (
                f'<g class="span"><title>{escape(brief(force.name, 60))}</title>'
                f'<line id="{self.prefix}-span-{index}" class="rod" '
                f'x1="{x0:.5g}" y1="{y0:.5g}" x2="{x1:.5g}" y2="{y1:.5g}"/>'
                f'<line id="{self.prefix}-barrel-{index}" class="barrel" '
                f'x1="{x0:.5g}" y1="{y0:.5g}" x2="{middle[0]:.5g}" y2="{middle[1]:.5g}"/></g>'
            )

    def pins(self) -> Iterator[str]:
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
            spanned = any((body, point) in both_ends(force) for force in self.layout.reaching)
            bare = isinstance(joint, Prismatic) or (joint is None and not spanned)
            hidden = ' visibility="hidden"' if bare else ""
            name = point if joint is None else joint.name
            yield (
                f'<g id="{self.prefix}-point-{index}" class="pin"{hidden} '
                f'transform="translate({x:.6g} {y:.6g})">'
                f"<title>{escape(brief(name, 60))}</title>{shape}</g>"
            )

    def arrows(self) -> Iterator[str]:
        """Arrows of reactions and forces; empty ones, for a script, of the assembled linkage."""
        layout, tip = self.layout, TIP * self.unit
        names = [f"reaction of {joint.name} on {joint.body_b}" for joint in self.joints]
        names += [force.name for force in layout.efforts]
        for index, name in enumerate(names):
            kind = "reaction" if index < len(self.joints) else "effort"
            shape = ""
            if self.frame is not None:
                shape = f' d="{arrow_path(layout.arrow_ends[self.frame, index], tip)}"'
            yield (
                f'<path id="{self.prefix}-arrow-{index}" class="arrow {kind}"{shape}>'
                f"<title>{escape(brief(name, 80))}</title></path>"
            )
        for index, force in enumerate(layout.turning):
            x, y = self._point(*entry(layout.linkage, force.coordinate))
            shape = ""
            if self.frame is not None:
                share = layout.torques[self.frame, index] * layout.scaled(layout.turned)[self.frame]
                shape = f' d="{bent_path(float(share), tip)}"'
            yield (
                f'<path id="{self.prefix}-torque-{index}" class="arrow effort" '
                f'transform="translate({x:.6g} {y:.6g})"{shape}>'
                f"<title>{escape(brief(force.name, 60))}</title></path>"
            )

    @property
    def lifts(self) -> list[float]:
        """Offset of each point's name to the right of the point, and above it [mm].

        Names keep clear of the arc that shows a torque.
        """
        linkage = self.layout.linkage
        turned = [self._point(*entry(linkage, f.coordinate)) for f in self.layout.turning]
        return [
            (_BY_TORQUE if any(same(self._point(*mark), at) for at in turned) else _BY_POINT)
            * self.unit
            for mark in self.marks
        ]

    def labels(self) -> Iterator[str]:
        """Names of the points, one for each place."""
        told: set[tuple[float, float]] = set()
        for index, ((body, point), lift) in enumerate(zip(self.marks, self.lifts, strict=True)):
            x, y = self._point(body, point)
            if (round(x, 6), round(y, 6)) in told:
                continue
            told.add((round(x, 6), round(y, 6)))
            yield (
                f'<text id="{self.prefix}-label-{index}" x="{x + lift:.6g}" '
                f'y="{y - lift:.6g}">{escape(brief(point, 16))}</text>'
            )
