"""Constraints and coordinates of a linkage, with first and second derivatives, for many poses.

Poses are arrays (n, bodies, 3) of x, y [mm] and angle [rad], the ground first. The quadratic term
of a function g of the poses is v' (d2g/dq2) v for rates v, so that
d2g/dt2 = gradient . accelerations + quadratic term (Nikravesh, Planar Multibody Dynamics, ch. 7).
"""

from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from loads.bodies import FloatArray
from loads.elements import (
    Angle,
    Coordinate,
    Distance,
    Fixed,
    Joint,
    PointCoordinate,
    Prismatic,
    Slot,
)

if TYPE_CHECKING:
    from loads.linkage import Linkage


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the z component of a x b, for vectors along the last axis."""
    result: FloatArray = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return result


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the scalar product along the last axis."""
    result: FloatArray = np.sum(a * b, axis=-1)
    return result


def turned_left(vector: FloatArray) -> FloatArray:
    """Return k x vector: the vectors turned by 90 degrees ccw."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def rotated(vector: FloatArray, angle: FloatArray) -> FloatArray:
    """Return vectors (..., 2) turned ccw by angles (...)."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vector[..., 0], vector[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


class Kinematics:
    """The geometry of one linkage, prepared once, evaluated for any number of poses."""

    def __init__(self, linkage: "Linkage") -> None:
        self.linkage: Final = linkage
        self.index: Final = {name: i for i, name in enumerate(linkage.body_names)}
        self.n_bodies: Final = len(self.index)
        self.rows: Final[dict[str, slice]] = {}
        row = 0
        for joint in linkage.joints:
            self.rows[joint.name] = slice(row, row + joint.n_constraints)
            row += joint.n_constraints
        self.n_constraints: Final = row
        self._assembled_turn: Final = {
            joint.name: self._turn(self.assembled, joint)[0] for joint in linkage.joints
        }

    @cached_property
    def assembled(self) -> FloatArray:
        """The pose stated in the linkage (1, bodies, 3)."""
        poses = [self.linkage.assembled[body.name] for body in self.linkage.moving]
        return np.array([[(0.0, 0.0, 0.0), *poses]], dtype=float)

    @cached_property
    def size(self) -> float:
        """The largest distance of two points of the assembled linkage [mm], its unit of length."""
        places = np.array(
            [
                self.point(self.assembled, body.name, point)[0]
                for body in self.linkage.bodies
                for point in body.points
            ]
        )
        if len(places) < 2:
            return 1.0
        spread = float(np.max(np.linalg.norm(places[:, None] - places[None], axis=2)))
        return spread or 1.0

    @cached_property
    def pose_scale(self) -> FloatArray:
        """What turns unit-free pose changes of the moving bodies into mm and rad (3 moving,)."""
        return np.tile([self.size, self.size, 1.0], self.n_bodies - 1)

    @cached_property
    def row_scale(self) -> FloatArray:
        """What turns unit-free constraint errors into mm and rad (constraints,)."""
        scale = np.full(self.n_constraints, self.size)
        for joint in self.linkage.joints:
            if isinstance(joint, Prismatic | Fixed):
                scale[self.rows[joint.name].stop - 1] = 1.0
        return scale

    def coordinate_scale(self, coordinate: Coordinate) -> float:
        """Return what turns a unit-free coordinate into mm or rad."""
        return 1.0 if coordinate.angular else self.size

    def arm(self, poses: FloatArray, body: str, point: str) -> FloatArray:
        """Return the vector from a body's frame origin to its point, ground axes (n, 2) [mm]."""
        place = np.array(self.linkage.body(body).place(point), dtype=float)
        return rotated(place, poses[:, self.index[body], 2])

    def point(self, poses: FloatArray, body: str, point: str) -> FloatArray:
        """Return where a point of a body is (n, 2) [mm]."""
        place: FloatArray = poses[:, self.index[body], :2] + self.arm(poses, body, point)
        return place

    def velocity(
        self, poses: FloatArray, rates: FloatArray, body: str, arm: FloatArray
    ) -> FloatArray:
        """Return the velocity of the body's material point at an arm from its origin (n, 2)."""
        i = self.index[body]
        speed: FloatArray = rates[:, i, :2] + rates[:, i, 2:] * turned_left(arm)
        return speed

    def line(self, poses: FloatArray, joint: Prismatic | Slot) -> FloatArray:
        """Return the unit vector along a guide or slot (n, 2), ground axes."""
        direction = np.array(joint.direction, dtype=float)
        return rotated(direction / np.hypot(*direction), poses[:, self.index[joint.body_a], 2])

    def _turn(self, poses: FloatArray, joint: Joint) -> FloatArray:
        turn: FloatArray = (
            poses[:, self.index[joint.body_b], 2] - poses[:, self.index[joint.body_a], 2]
        )
        return turn

    def _add_point(
        self, row: FloatArray, body: str, direction: FloatArray, arm: FloatArray
    ) -> None:
        """Add the gradient of direction . (point at this arm of the body) to rows (n, 3 bodies)."""
        i = 3 * self.index[body]
        row[:, i : i + 2] += direction
        row[:, i + 2] += cross(arm, direction)

    def separation(self, poses: FloatArray, joint: Joint) -> FloatArray:
        """Return the vector from point a to point b of a joint (n, 2) [mm]."""
        return self.point(poses, joint.body_b, joint.point_b) - self.point(
            poses, joint.body_a, joint.point_a
        )

    def constraints(self, poses: FloatArray) -> FloatArray:
        """Return by how much each constraint is violated (n, constraints) [mm, rad]."""
        result = np.zeros((len(poses), self.n_constraints))
        for joint in self.linkage.joints:
            rows = self.rows[joint.name]
            apart = self.separation(poses, joint)
            if isinstance(joint, Prismatic | Slot):
                result[:, rows.start] = dot(turned_left(self.line(poses, joint)), apart)
            else:
                result[:, rows.start : rows.start + 2] = apart
            if isinstance(joint, Prismatic | Fixed):
                turn = self._turn(poses, joint) - self._assembled_turn[joint.name]
                result[:, rows.stop - 1] = turn
        return result

    def jacobian(self, poses: FloatArray) -> FloatArray:
        """Return the derivatives of the constraints (n, constraints, 3 bodies)."""
        n = len(poses)
        result = np.zeros((n, self.n_constraints, 3 * self.n_bodies))
        for joint in self.linkage.joints:
            rows = self.rows[joint.name]
            a, b = joint.body_a, joint.body_b
            arm_a, arm_b = self.arm(poses, a, joint.point_a), self.arm(poses, b, joint.point_b)
            if isinstance(joint, Prismatic | Slot):
                normal = turned_left(self.line(poses, joint))
                row = result[:, rows.start]
                self._add_point(row, b, normal, arm_b)
                # the line turns with body a: as if its point under the slider were pushed
                self._add_point(row, a, -normal, arm_a + self.separation(poses, joint))
            else:
                for k, axis in enumerate(np.eye(2)):
                    direction = np.broadcast_to(axis, (n, 2))
                    self._add_point(result[:, rows.start + k], b, direction, arm_b)
                    self._add_point(result[:, rows.start + k], a, -direction, arm_a)
            if isinstance(joint, Prismatic | Fixed):
                result[:, rows.stop - 1, 3 * self.index[b] + 2] += 1.0
                result[:, rows.stop - 1, 3 * self.index[a] + 2] -= 1.0
        return result

    def quadratic(self, poses: FloatArray, rates: FloatArray) -> FloatArray:
        """Return the quadratic terms of the constraints for rates (n, constraints)."""
        result = np.zeros((len(poses), self.n_constraints))
        for joint in self.linkage.joints:
            rows = self.rows[joint.name]
            bend = self._bend(poses, rates, joint.body_b, joint.point_b) - self._bend(
                poses, rates, joint.body_a, joint.point_a
            )
            if isinstance(joint, Prismatic | Slot):
                tangent = self.line(poses, joint)
                normal = turned_left(tangent)
                spin = rates[:, self.index[joint.body_a], 2]
                apart = self.separation(poses, joint)
                parting = self._parting(poses, rates, joint)
                result[:, rows.start] = (
                    dot(normal, bend)
                    - 2.0 * spin * dot(tangent, parting)
                    - spin**2 * dot(normal, apart)
                )
            else:
                result[:, rows.start : rows.start + 2] = bend
        return result

    def _bend(self, poses: FloatArray, rates: FloatArray, body: str, point: str) -> FloatArray:
        """Return the centripetal acceleration of a point at these rates (n, 2)."""
        spin = rates[:, self.index[body], 2:]
        result: FloatArray = -(spin**2) * self.arm(poses, body, point)
        return result

    def _parting(self, poses: FloatArray, rates: FloatArray, ends: Joint | Distance) -> FloatArray:
        a, b = ends.body_a, ends.body_b
        return self.velocity(poses, rates, b, self.arm(poses, b, ends.point_b)) - self.velocity(
            poses, rates, a, self.arm(poses, a, ends.point_a)
        )

    def travel(self, poses: FloatArray, joint: Prismatic | Slot) -> FloatArray:
        """Return how far point b is along the line from its point a (n,) [mm]."""
        return dot(self.line(poses, joint), self.separation(poses, joint))

    def sliding(self, poses: FloatArray, rates: FloatArray, joint: Prismatic | Slot) -> FloatArray:
        """Return how fast body b slides along the line of body a (n,) [mm/s]."""
        arm_a = self.arm(poses, joint.body_a, joint.point_a) + self.separation(poses, joint)
        arm_b = self.arm(poses, joint.body_b, joint.point_b)
        relative = self.velocity(poses, rates, joint.body_b, arm_b) - self.velocity(
            poses, rates, joint.body_a, arm_a
        )
        return dot(self.line(poses, joint), relative)

    def sliding_gradient(self, poses: FloatArray, joint: Prismatic | Slot) -> FloatArray:
        """Return the derivative of the sliding distance (n, 3 bodies)."""
        row = np.zeros((len(poses), 3 * self.n_bodies))
        tangent = self.line(poses, joint)
        arm_a = self.arm(poses, joint.body_a, joint.point_a) + self.separation(poses, joint)
        self._add_point(row, joint.body_b, tangent, self.arm(poses, joint.body_b, joint.point_b))
        self._add_point(row, joint.body_a, -tangent, arm_a)
        return row

    def span(self, poses: FloatArray, distance: Distance) -> FloatArray:
        """Return the vector from the first to the second point of a distance (n, 2) [mm]."""
        return self.point(poses, distance.body_b, distance.point_b) - self.point(
            poses, distance.body_a, distance.point_a
        )

    def value(self, coordinate: Coordinate, poses: FloatArray) -> FloatArray:
        """Return a coordinate (n,) [mm or rad]."""
        match coordinate:
            case PointCoordinate():
                return dot(
                    self.point(poses, coordinate.body, coordinate.point), unit(coordinate.direction)
                )
            case Distance():
                span = self.span(poses, coordinate)
                return np.sqrt(dot(span, span))
            case Angle():
                turn: FloatArray = (
                    poses[:, self.index[coordinate.body], 2]
                    - poses[:, self.index[coordinate.relative_to], 2]
                )
                return turn

    def gradient(self, coordinate: Coordinate, poses: FloatArray) -> FloatArray:
        """Return the derivatives of a coordinate (n, 3 bodies)."""
        row = np.zeros((len(poses), 3 * self.n_bodies))
        match coordinate:
            case PointCoordinate(body=body, point=point):
                direction = np.broadcast_to(unit(coordinate.direction), (len(poses), 2))
                self._add_point(row, body, direction, self.arm(poses, body, point))
            case Distance(body_a=a, body_b=b):
                span = self.span(poses, coordinate)
                along = span / np.linalg.norm(span, axis=1, keepdims=True)
                self._add_point(row, b, along, self.arm(poses, b, coordinate.point_b))
                self._add_point(row, a, -along, self.arm(poses, a, coordinate.point_a))
            case Angle():
                row[:, 3 * self.index[coordinate.body] + 2] += 1.0
                row[:, 3 * self.index[coordinate.relative_to] + 2] -= 1.0
        return row

    def curvature(self, coordinate: Coordinate, poses: FloatArray, rates: FloatArray) -> FloatArray:
        """Return the quadratic term of a coordinate for rates (n,)."""
        match coordinate:
            case PointCoordinate(body=body, point=point):
                return dot(self._bend(poses, rates, body, point), unit(coordinate.direction))
            case Distance(body_a=a, body_b=b):
                span = self.span(poses, coordinate)
                length = np.linalg.norm(span, axis=1)
                along = span / length[:, None]
                bend = self._bend(poses, rates, b, coordinate.point_b) - self._bend(
                    poses, rates, a, coordinate.point_a
                )
                parting = self._parting(poses, rates, coordinate)
                across: FloatArray = cross(along, parting)
                result: FloatArray = dot(along, bend) + across**2 / length
                return result
            case Angle():
                return np.zeros(len(poses))


def unit(direction: tuple[float, float]) -> FloatArray:
    """Return the unit vector along a direction."""
    vector = np.array(direction, dtype=float)
    result: FloatArray = vector / np.hypot(*vector)
    return result
