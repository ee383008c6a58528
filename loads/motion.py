"""Positions of a linkage with their derivatives, and how it moves through them.

All joints are closed at given values of a coordinate by Newton's method for many poses together.
"""

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from loads.bodies import BoolArray, Coordinate, FloatArray, LinkageError, place_in_words
from loads.kinematics import Kinematics, dot

# A coordinate whose share of the motion is below this cannot lead (or load) it: beyond, more than
# ten of the sixteen digits of a double are lost.
SINGULAR = 1e-6


@dataclass(frozen=True, eq=False)
class Geometry:
    """Positions of a linkage and their derivatives by the swept coordinate.

    values  (n,)             swept coordinate, mm or rad
    poses   (n, bodies, 3)   mm, mm, rad; the ground first
    first   (n, bodies, 3)   d poses / d coordinate
    second  (n, bodies, 3)   d2 poses / d coordinate2
    """

    kinematics: Kinematics
    coordinate: Coordinate
    values: FloatArray
    poses: FloatArray
    first: FloatArray
    second: FloatArray

    def place(self, k: int) -> str:
        """Return where position k is, in words."""
        return place_in_words(self.coordinate, float(self.values[k]))


@dataclass(frozen=True, eq=False)
class Motion:
    """Positions of a linkage with their rates in time.

    poses, velocities, accelerations  (n, bodies, 3)  mm, rad, s; the ground first
    heading                           (n, bodies, 3)  d poses / d swept coordinate, the way it goes:
                                      the direction of the velocities, also where they are zero
    """

    kinematics: Kinematics
    coordinate: Coordinate
    values: FloatArray
    poses: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
    heading: FloatArray

    def place(self, k: int) -> str:
        """Return where position k is, in words."""
        return place_in_words(self.coordinate, float(self.values[k]))


def differentiate(
    kinematics: Kinematics, coordinate: Coordinate, values: FloatArray, poses: FloatArray
) -> Geometry:
    """Return first and second derivatives of solved poses by the coordinate.

    With A the constraint Jacobian over the coordinate's gradient: A q' = (0, 1) and
    A q'' = -(quadratic terms for q').
    """
    jacobian = matrix(kinematics, coordinate, poses)
    right = np.zeros(jacobian.shape[:2])
    right[:, -1] = 1.0
    first = derivative(kinematics, coordinate, jacobian, right, values, leading=True)
    scale = kinematics.coordinate_scale(coordinate)
    bend = np.concatenate(
        [
            kinematics.quadratic(poses, first) / kinematics.row_scale,
            kinematics.curvature(coordinate, poses, first)[:, None] / scale,
        ],
        axis=1,
    )
    # times scale: _solve divides once, as for a first derivative
    second = derivative(kinematics, coordinate, jacobian, -bend * scale, values, leading=False)
    return Geometry(kinematics, coordinate, values, poses, first, second)


def move(
    geometry: Geometry,
    pace: Coordinate,
    speed: float | FloatArray,
    direction: int,
    acceleration: float | FloatArray = 0.0,
) -> Motion:
    """Return the motion in which the pace coordinate changes at the given speed.

    speed         mm/s or rad/s, magnitude of the pace's rate, one or (n,)
    direction     1: the swept coordinate rises, -1: it falls
    acceleration  of the pace along its way (its speed rises where positive), one or (n,)
    """
    kinematics = geometry.kinematics
    kinematics.linkage.check_coordinate(pace, "pace")
    if not (np.isfinite(speed).all() and np.min(speed) >= 0.0 and np.max(speed) > 0.0):
        raise LinkageError(f"the speed of {pace.label} must be above 0, got {np.min(speed):g}")
    n = len(geometry.values)
    gradient = kinematics.gradient(pace, geometry.poses)
    slope = np.einsum("nj,nj->n", gradient, geometry.first.reshape(n, -1))
    share = coordinate_share(kinematics, pace, geometry.poses, geometry.first)
    turning = (share * share[0] <= 0.0) | (np.abs(share) < SINGULAR)
    if turning.any():
        k = int(np.argmax(turning))
        raise LinkageError(
            f"{pace.label} sets the pace but stands still at or before "
            f"{geometry.place(k)}: choose another coordinate for the pace, or end the phase "
            "before it"
        )
    curvature = kinematics.curvature(pace, geometry.poses, geometry.first) + np.einsum(
        "nj,nj->n", gradient, geometry.second.reshape(n, -1)
    )
    along = np.sign(slope) * direction
    rate = along * speed / slope  # of the swept coordinate
    change = (along * acceleration - curvature * rate**2) / slope
    rate, change = rate[:, None, None], change[:, None, None]
    return Motion(
        kinematics,
        geometry.coordinate,
        geometry.values,
        geometry.poses,
        geometry.first * rate,
        geometry.second * rate**2 + geometry.first * change,
        geometry.first * direction,
    )


def coordinate_share(
    kinematics: Kinematics, coordinate: Coordinate, poses: FloatArray, first: FloatArray
) -> FloatArray:
    """Return a coordinate's share of the motion (n,), between -1 and 1, 0 at a dead centre.

    The coordinate's derivative along the motion over the product of the lengths of its gradient and
    of the motion, lengths measured by the linkage's size and angles in rad.
    """
    gradient = kinematics.gradient(coordinate, poses)[:, 3:] * kinematics.pose_scale
    rates = first.reshape(len(poses), -1)[:, 3:] / kinematics.pose_scale
    length = np.linalg.norm(gradient, axis=1) * np.linalg.norm(rates, axis=1)
    return np.asarray(dot(gradient, rates) / length)


def derivative(
    kinematics: Kinematics,
    coordinate: Coordinate,
    matrix: FloatArray,
    right: FloatArray,
    values: FloatArray,
    leading: bool,
) -> FloatArray:
    """Return derivatives (n, bodies, 3) by the coordinate for unit-free right sides.

    leading  the solution is the motion itself: the coordinate must see enough of it
    """
    solution = solved(matrix, right)
    lead = 1.0 / (np.linalg.norm(matrix[:, -1], axis=1) * np.linalg.norm(solution, axis=1) + 1e-300)
    if leading and (~np.isfinite(lead) | (lead < SINGULAR)).any():
        k = int(np.argmin(np.where(np.isfinite(lead), lead, 0.0)))
        raise LinkageError(
            f"{place_in_words(coordinate, float(values[k]))} is a dead centre: {coordinate.label} "
            "stands still there and cannot lead the motion through it; end before it, or sweep "
            "another coordinate"
        )
    result = np.zeros((len(matrix), kinematics.n_bodies, 3))
    scale = kinematics.coordinate_scale(coordinate)
    result[:, 1:] = (solution * kinematics.pose_scale / scale).reshape(len(matrix), -1, 3)
    return result


def matrix(kinematics: Kinematics, coordinate: Coordinate, poses: FloatArray) -> FloatArray:
    """Return the unit-free Jacobian of the constraints, the coordinate as its last row."""
    return bordered(kinematics, coordinate, poses, kinematics.jacobian(poses))


def bordered(
    kinematics: Kinematics, coordinate: Coordinate, poses: FloatArray, jacobian: FloatArray
) -> FloatArray:
    """Return the unit-free Jacobian from one in mm and rad that is at hand."""
    scale = kinematics.coordinate_scale(coordinate)
    n, rows, _ = jacobian.shape
    result = np.empty((n, rows + 1, len(kinematics.pose_scale)))
    result[:, :-1] = jacobian[:, :, 3:] * (kinematics.pose_scale / kinematics.row_scale[:, None])
    result[:, -1] = kinematics.gradient(coordinate, poses)[:, 3:] * (kinematics.pose_scale / scale)
    return result


def closed_poses(
    kinematics: Kinematics, coordinate: Coordinate, values: FloatArray, guess: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return poses on the constraints with the given coordinate values, and which converged."""
    poses = guess.copy()
    scale = kinematics.coordinate_scale(coordinate)
    done = np.zeros(len(values), dtype=bool)
    lost = np.zeros(len(values), dtype=bool)
    for _ in range(12):
        violations, jacobian = kinematics.linearised(poses)
        error = np.column_stack(
            [
                violations / kinematics.row_scale,
                (kinematics.value(coordinate, poses) - values) / scale,
            ]
        )
        if (done | lost).all():
            break
        step = solved(bordered(kinematics, coordinate, poses, jacobian), error)
        size = np.linalg.norm(step, axis=1)
        # what runs away is left where it is, so that the others come to their end
        lost |= ~np.isfinite(size) | (size > 10.0)
        step[lost] = 0.0
        poses[:, 1:] -= (step * kinematics.pose_scale).reshape(len(poses), -1, 3)
        # the step after a step of 1e-8 is at rounding: quadratic convergence
        done = (size < 1e-8) & ~lost
    residual = np.abs(error).max(axis=1)
    return poses, done & (residual < 1e-12)


def solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Return solutions (n, k) of n systems; infinite where one is singular."""
    try:
        return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
    except np.linalg.LinAlgError:
        result = np.full(right.shape, np.inf)
        for k, (one, load) in enumerate(zip(matrix, right, strict=True)):
            with suppress(np.linalg.LinAlgError):
                result[k] = np.linalg.solve(one, load)
        return result


def orientation(kinematics: Kinematics, coordinate: Coordinate, poses: FloatArray) -> FloatArray:
    """Return the sign of the Jacobian's determinant (n,).

    It is the same all along a branch and changes at every fold of the coordinate and every change
    point, so that it tells two branches apart that come near each other there.
    """
    return np.asarray(np.linalg.slogdet(matrix(kinematics, coordinate, poses))[0])


def pose_norm(kinematics: Kinematics, change: FloatArray) -> FloatArray:
    """Return the unit-free length of changes of poses (n,): by the linkage's size, and in rad."""
    result: FloatArray = np.linalg.norm(
        change.reshape(len(change), -1)[:, 3:] / kinematics.pose_scale, axis=1
    )
    return result
