"""Layout of a mechanism's picture over one or several cycles of a linkage.

Lengths are mm of the machine; y points down in SVG, so places of the picture have their y changed
in sign. Widths, letters and marks are shares of the picture's size.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import atan2, cos, hypot, pi, sin
from typing import Any, Protocol

import numpy as np

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
from reports.loads_figures import FloatArray

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
