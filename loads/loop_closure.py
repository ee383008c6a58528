"""Closing all joints at given values of a coordinate: Newton's method for many poses together."""

from contextlib import suppress

import numpy as np

from loads.bodies import BoolArray, FloatArray
from loads.joints import Coordinate
from loads.kinematics import Kinematics


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
    signs: FloatArray = np.linalg.slogdet(matrix(kinematics, coordinate, poses))[0]
    return signs


def pose_norm(kinematics: Kinematics, change: FloatArray) -> FloatArray:
    """Return the unit-free length of changes of poses (n,): by the linkage's size, and in rad."""
    result: FloatArray = np.linalg.norm(
        change.reshape(len(change), -1)[:, 3:] / kinematics.pose_scale, axis=1
    )
    return result
