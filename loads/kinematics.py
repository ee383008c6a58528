"""Constraints and coordinates of a linkage, with first and second derivatives, for many poses.

Poses are arrays (n, bodies, 3) of x, y [mm] and angle [rad], the ground first. The quadratic term
of a function g of the poses is v' (d2g/dq2) v for rates v, so that
d2g/dt2 = gradient . accelerations + quadratic term (Nikravesh, Planar Multibody Dynamics, ch. 7).
"""

from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from loads.bodies import (
    GROUND,
    Angle,
    Body,
    Coordinate,
    Distance,
    Fixed,
    FloatArray,
    Joint,
    LinkageError,
    PointCoordinate,
    Prismatic,
    Slot,
)

if TYPE_CHECKING:
    from loads.linkage import Linkage


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the z component of a x b, for vectors along the last axis."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the scalar product along the last axis."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def turned_left(vector: FloatArray) -> FloatArray:
    """Return k x vector: the vectors turned by 90 degrees ccw."""
    result = np.empty_like(vector)
    result[..., 0] = -vector[..., 1]
    result[..., 1] = vector[..., 0]
    return result


def rotated(vector: FloatArray, angle: FloatArray) -> FloatArray:
    """Return vectors (..., 2) turned ccw by angles (...)."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vector[..., 0], vector[..., 1]
    along = c * x - s * y
    result = np.empty((*along.shape, 2))
    result[..., 0] = along
    result[..., 1] = s * x + c * y
    return result


def centre_arm(body: Body, poses: FloatArray) -> FloatArray:
    """Return the vectors from a body's origin to its centre of mass, ground axes; poses (n, 3)."""
    return rotated(np.array(body.centre, dtype=float), poses[:, 2])


def velocity_at(arm: FloatArray, rates: FloatArray) -> FloatArray:
    """Return the velocity (n, 2) at an arm from a body's origin; rates (n, 3) of its pose."""
    return np.asarray(rates[:, :2] + rates[:, 2:] * turned_left(arm))


def acceleration_at(arm: FloatArray, rates: FloatArray, accelerations: FloatArray) -> FloatArray:
    """Return the acceleration (n, 2) at an arm from a body's origin, of its pose's (n, 3)."""
    turning = accelerations[:, 2:] * turned_left(arm)
    return np.asarray(accelerations[:, :2] + turning - rates[:, 2:] ** 2 * arm)


class _JointTable:
    """The joints of a linkage as arrays, so that all are evaluated at once.

    bodies_a, bodies_b  (joints,)    rows of their bodies in poses
    places_a, places_b  (joints, 2)  mm, in the bodies' frames
    points, lines       which joints hold a point, and which lead it along a line
    turns               which joints hold the angle
    *_rows              first row of each in the constraints
    vectors, turned_by  places_a, places_b and the unit vectors along the lines, one after another,
                        and the rows of the bodies that turn them
    constant            (constraints x 3 bodies,)  derivatives that no pose alters
    arm_cells           cells of them that arms alter: of points b by x and y, then of points a
    line_cells          and that lines alter: by x, y and angle of bodies b, then of bodies a
    """

    def __init__(self, linkage: "Linkage", index: dict[str, int], rows: dict[str, slice]) -> None:
        joints = linkage.joints
        self.bodies_a = np.array([index[joint.body_a] for joint in joints], dtype=int)
        self.bodies_b = np.array([index[joint.body_b] for joint in joints], dtype=int)
        self.places_a = np.array(
            [linkage.body(joint.body_a).place(joint.point_a) for joint in joints], dtype=float
        ).reshape(-1, 2)
        self.places_b = np.array(
            [linkage.body(joint.body_b).place(joint.point_b) for joint in joints], dtype=float
        ).reshape(-1, 2)
        is_line = np.array([isinstance(joint, Prismatic | Slot) for joint in joints], dtype=bool)
        turning = [isinstance(joint, Prismatic | Fixed) for joint in joints]
        first = np.array([rows[joint.name].start for joint in joints], dtype=int)
        last = np.array([rows[joint.name].stop - 1 for joint in joints], dtype=int)
        self.points, self.lines = np.flatnonzero(~is_line), np.flatnonzero(is_line)
        self.turns = np.flatnonzero(turning)
        self.point_rows, self.line_rows = first[self.points], first[self.lines]
        self.turn_rows = last[self.turns]
        directions = np.array(
            [unit(joint.direction) for joint in joints if isinstance(joint, Prismatic | Slot)]
        ).reshape(-1, 2)
        self.vectors = np.concatenate([self.places_a, self.places_b, directions])
        self.turned_by = np.concatenate([self.bodies_a, self.bodies_b, self.bodies_a[self.lines]])

        width = 3 * len(index)
        x, line, turn = width * self.point_rows, width * self.line_rows, width * self.turn_rows
        y = x + width
        point_b, point_a = 3 * self.bodies_b[self.points], 3 * self.bodies_a[self.points]
        line_b, line_a = 3 * self.bodies_b[self.lines], 3 * self.bodies_a[self.lines]
        self.arm_cells = np.concatenate(
            [x + point_b + 2, y + point_b + 2, x + point_a + 2, y + point_a + 2]
        )
        self.line_cells = np.concatenate(
            [line + own + k for own in (line_b, line_a) for k in range(3)]
        )
        self.constant = np.zeros(width * sum(joint.n_constraints for joint in joints))
        self.constant[[*(x + point_b), *(y + point_b + 1)]] = 1.0
        self.constant[[*(x + point_a), *(y + point_a + 1)]] = -1.0
        self.constant[turn + 3 * self.bodies_b[self.turns] + 2] = 1.0
        self.constant[turn + 3 * self.bodies_a[self.turns] + 2] = -1.0


@dataclass(frozen=True, eq=False)
class _Placed:
    """Arms of both ends of all joints, and the vectors from a to b (n, joints, 2).

    tangents  (n, lines, 2)  unit vectors along guides and slots, ground axes
    """

    arm_a: FloatArray
    arm_b: FloatArray
    apart: FloatArray
    tangents: FloatArray


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
        self._joints = _JointTable(linkage, self.index, self.rows)
        self._offsets: FloatArray | float = 0.0
        self._assembled_turn: Final = self._turns(self.assembled)[0]

    def displaced(self, vectors: FloatArray, offsets: FloatArray) -> "Kinematics":
        """Return the same linkage with other places and lines of its joints at every position.

        vectors  (n, 2 joints + lines, 2) of ends a, ends b and unit vectors along lines, body axes
        offsets  (n, constraints) mm or rad, what each constraint is open by
        """
        other = copy(self)
        other._joints = copy(self._joints)
        other._joints.vectors = vectors
        other._offsets = offsets
        return other

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
        """Factors from unit-free pose changes of the moving bodies to mm and rad (3 moving,)."""
        return np.tile([self.size, self.size, 1.0], self.n_bodies - 1)

    @cached_property
    def row_scale(self) -> FloatArray:
        """Factors from unit-free constraint errors to mm and rad (constraints,)."""
        scale = np.full(self.n_constraints, self.size)
        for joint in self.linkage.joints:
            if isinstance(joint, Prismatic | Fixed):
                scale[self.rows[joint.name].stop - 1] = 1.0
        return scale

    def coordinate_scale(self, coordinate: Coordinate) -> float:
        """Return the factor from a unit-free coordinate to mm or rad."""
        return 1.0 if coordinate.angular else self.size

    def arm(self, poses: FloatArray, body: str, point: str) -> FloatArray:
        """Return the vector from a body's frame origin to its point, ground axes (n, 2) [mm]."""
        place = np.array(self.linkage.body(body).place(point), dtype=float)
        return rotated(place, poses[:, self.index[body], 2])

    def point(self, poses: FloatArray, body: str, point: str) -> FloatArray:
        """Return where a point of a body is (n, 2) [mm]."""
        return np.asarray(poses[:, self.index[body], :2] + self.arm(poses, body, point))

    def velocity(
        self, poses: FloatArray, rates: FloatArray, body: str, arm: FloatArray
    ) -> FloatArray:
        """Return the velocity of the body's material point at an arm from its origin (n, 2)."""
        return velocity_at(arm, rates[:, self.index[body]])

    def line(self, poses: FloatArray, joint: Prismatic | Slot) -> FloatArray:
        """Return the unit vector along a guide or slot (n, 2), ground axes."""
        direction = np.array(joint.direction, dtype=float)
        return rotated(direction / np.hypot(*direction), poses[:, self.index[joint.body_a], 2])

    def _turns(self, poses: FloatArray) -> FloatArray:
        """Return the angle of body b against a at every joint that holds it (n, turns)."""
        table = self._joints
        angles = poses[:, :, 2]
        return np.asarray(
            angles[:, table.bodies_b[table.turns]] - angles[:, table.bodies_a[table.turns]]
        )

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

    def _placed(self, poses: FloatArray) -> "_Placed":
        table = self._joints
        turned = rotated(table.vectors, poses[:, table.turned_by, 2])
        n_joints = len(table.bodies_a)
        arm_a, arm_b = turned[:, :n_joints], turned[:, n_joints : 2 * n_joints]
        between = poses[:, table.bodies_b, :2] - poses[:, table.bodies_a, :2]
        return _Placed(arm_a, arm_b, between + arm_b - arm_a, turned[:, 2 * n_joints :])

    def constraints(self, poses: FloatArray) -> FloatArray:
        """Return the error of each constraint (n, constraints) [mm, rad]."""
        return self._violations(poses, self._placed(poses))

    def jacobian(self, poses: FloatArray) -> FloatArray:
        """Return the derivatives of the constraints (n, constraints, 3 bodies)."""
        return self._slopes(self._placed(poses))

    def joints_jacobian(self, poses: FloatArray) -> FloatArray:
        """Return the same by the moving bodies alone (n, constraints, 3 moving), unit-free."""
        own = self.jacobian(poses)[:, :, 3:]
        return np.asarray(own * self.pose_scale / self.row_scale[:, None])

    def linearised(self, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return constraints and their derivatives together, which costs less than one by one."""
        placed = self._placed(poses)
        return self._violations(poses, placed), self._slopes(placed)

    def _violations(self, poses: FloatArray, placed: "_Placed") -> FloatArray:
        table, apart = self._joints, placed.apart
        result = np.zeros((len(poses), self.n_constraints))
        result[:, table.point_rows] = apart[:, table.points, 0]
        result[:, table.point_rows + 1] = apart[:, table.points, 1]
        if len(table.lines):
            normals = turned_left(placed.tangents)
            result[:, table.line_rows] = dot(normals, apart[:, table.lines])
        result[:, table.turn_rows] = self._turns(poses) - self._assembled_turn
        return result - self._offsets

    def _slopes(self, placed: "_Placed") -> FloatArray:
        table = self._joints
        arm_a, arm_b, apart = placed.arm_a, placed.arm_b, placed.apart
        result = np.empty((len(apart), len(table.constant)))
        result[:] = table.constant
        a, b = arm_a[:, table.points], arm_b[:, table.points]
        result[:, table.arm_cells] = np.concatenate(
            [-b[..., 1], b[..., 0], a[..., 1], -a[..., 0]], axis=1
        )
        if len(table.lines):
            normals = turned_left(placed.tangents)
            # the line turns with body a: as if its point under the slider were pushed
            under = arm_a[:, table.lines] + apart[:, table.lines]
            pushed = [
                normals[..., 0], normals[..., 1], cross(arm_b[:, table.lines], normals),
                -normals[..., 0], -normals[..., 1], -cross(under, normals),
            ]  # fmt: skip
            result[:, table.line_cells] = np.concatenate(pushed, axis=1)
        return result.reshape(len(apart), self.n_constraints, -1)

    def quadratic(self, poses: FloatArray, rates: FloatArray) -> FloatArray:
        """Return the quadratic terms of the constraints for rates (n, constraints)."""
        table = self._joints
        result = np.zeros((len(poses), self.n_constraints))
        placed = self._placed(poses)
        arm_a, arm_b, apart = placed.arm_a, placed.arm_b, placed.apart
        spin_a = rates[:, table.bodies_a, 2:]
        spin_b = rates[:, table.bodies_b, 2:]
        bend = spin_a**2 * arm_a - spin_b**2 * arm_b
        result[:, table.point_rows] = bend[:, table.points, 0]
        result[:, table.point_rows + 1] = bend[:, table.points, 1]
        parting = (
            rates[:, table.bodies_b, :2]
            + spin_b * turned_left(arm_b)
            - rates[:, table.bodies_a, :2]
            - spin_a * turned_left(arm_a)
        )
        tangents = placed.tangents
        normals = turned_left(tangents)
        spin = spin_a[:, table.lines, 0]
        result[:, table.line_rows] = (
            dot(normals, bend[:, table.lines])
            - 2.0 * spin * dot(tangents, parting[:, table.lines])
            - spin**2 * dot(normals, apart[:, table.lines])
        )
        return result

    def _bend(self, poses: FloatArray, rates: FloatArray, body: str, point: str) -> FloatArray:
        """Return the centripetal acceleration of a point at these rates (n, 2)."""
        spin = rates[:, self.index[body], 2:]
        return np.asarray(-(spin**2) * self.arm(poses, body, point))

    def _parting(self, poses: FloatArray, rates: FloatArray, ends: Joint | Distance) -> FloatArray:
        a, b = ends.body_a, ends.body_b
        return self.velocity(poses, rates, b, self.arm(poses, b, ends.point_b)) - self.velocity(
            poses, rates, a, self.arm(poses, a, ends.point_a)
        )

    def travel(self, poses: FloatArray, joint: Prismatic | Slot) -> FloatArray:
        """Return the position of point b along the line from its point a (n,) [mm]."""
        return dot(self.line(poses, joint), self.separation(poses, joint))

    def travel_of(self, poses: FloatArray, joint: str) -> FloatArray:
        """Return the travel (n,) [mm] of a joint by its name; raises LinkageError for others."""
        found = self.linkage.joint(joint)
        if not isinstance(found, Prismatic | Slot):
            raise LinkageError(f"joint {joint!r} is neither a slot nor a guide")
        return self.travel(poses, found)

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

    def along(self, poses: FloatArray, coordinate: PointCoordinate) -> FloatArray:
        """Return the unit vector along which a point is measured (n, 2), ground axes."""
        direction = unit(coordinate.direction)
        if coordinate.follows == GROUND:
            return np.broadcast_to(direction, (len(poses), 2))
        return rotated(direction, poses[:, self.index[coordinate.follows], 2])

    def steps(self, coordinate: Coordinate, poses: FloatArray) -> FloatArray:
        """Return how far a coordinate moves from each position to the next (n - 1,) [mm or rad].

        Along a direction that turns with a body: by its mean at both ends, of second order.
        """
        if isinstance(coordinate, PointCoordinate) and coordinate.follows != GROUND:
            along = self.along(poses, coordinate)
            way = np.diff(self.point(poses, coordinate.body, coordinate.point), axis=0)
            return dot(0.5 * (along[:-1] + along[1:]), way)
        return np.diff(self.value(coordinate, poses))

    def value(self, coordinate: Coordinate, poses: FloatArray) -> FloatArray:
        """Return a coordinate (n,) [mm or rad].

        Raises LinkageError along a direction that turns with a body: a point has no position there.
        """
        match coordinate:
            case PointCoordinate():
                _check_fixed(coordinate)
                return dot(
                    self.point(poses, coordinate.body, coordinate.point), unit(coordinate.direction)
                )
            case Distance():
                span = self.span(poses, coordinate)
                return np.sqrt(dot(span, span))
            case Angle():
                return np.asarray(
                    poses[:, self.index[coordinate.body], 2]
                    - poses[:, self.index[coordinate.relative_to], 2]
                )

    def gradient(self, coordinate: Coordinate, poses: FloatArray) -> FloatArray:
        """Return the derivatives of a coordinate (n, 3 bodies)."""
        row = np.zeros((len(poses), 3 * self.n_bodies))
        match coordinate:
            case PointCoordinate(body=body, point=point):
                direction = self.along(poses, coordinate)
                self._add_point(row, body, direction, self.arm(poses, body, point))
            case Distance(body_a=a, body_b=b):
                span = self.span(poses, coordinate)
                length = np.linalg.norm(span, axis=1, keepdims=True)
                if (length <= 1e-12 * self.size).any():
                    raise LinkageError(
                        f"{coordinate.label} shrinks to nothing: it has no direction there"
                    )
                along = span / length
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
                _check_fixed(coordinate)
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
                return np.asarray(dot(along, bend) + across**2 / length)
            case Angle():
                return np.zeros(len(poses))


def _check_fixed(coordinate: PointCoordinate) -> None:
    if coordinate.follows != GROUND:
        raise LinkageError(
            f"{coordinate.label} has no position, as its direction turns with "
            f"{coordinate.follows!r}: it can only be the direction of a force that is given, or "
            "solved for in a rigid linkage"
        )


def unit(direction: tuple[float, float]) -> FloatArray:
    """Return the unit vector along a direction."""
    vector = np.array(direction, dtype=float)
    return np.asarray(vector / np.hypot(*vector))
