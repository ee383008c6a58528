"""Closing the joints of a linkage: at its assembled pose, or as far as they close at all."""

import numpy as np

from loads.bodies import FloatArray, LinkageError
from loads.change_points import held_twice
from loads.joints import Coordinate
from loads.kinematics import Kinematics
from loads.linkage import Linkage

# An assembled pose may be stated in rounded numbers; a larger gap is a wrong number.
_LARGEST_GAP = 1e-3  # of the size of the linkage


def worst_joint(kinematics: Kinematics, pose: FloatArray) -> tuple[str, float]:
    """Return the joint that is open widest in one pose, and its gap [mm].

    An angle error counts as the gap it opens over the size of the linkage.
    """
    errors = kinematics.constraints(pose)[0] / kinematics.row_scale * kinematics.size
    gaps = {name: float(np.linalg.norm(errors[rows])) for name, rows in kinematics.rows.items()}
    worst = max(gaps, key=lambda name: gaps[name])
    return worst, gaps[worst]


def assembly_gap(linkage: Linkage) -> tuple[str, float]:
    """Return the joint that the assembled pose leaves open widest, and its gap [mm]."""
    kinematics = Kinematics(linkage)
    return worst_joint(kinematics, kinematics.assembled)


def worst_gaps(kinematics: Kinematics, poses: FloatArray) -> FloatArray:
    """Return the largest constraint error of each pose (n,) [mm], angles over the size."""
    errors = np.abs(kinematics.constraints(poses)) / kinematics.row_scale * kinematics.size
    return np.asarray(errors.max(axis=1))


def assemble(kinematics: Kinematics) -> FloatArray:
    """Return the assembled pose moved onto the constraints (1, bodies, 3)."""
    pose = kinematics.assembled.copy()
    joint, gap = worst_joint(kinematics, pose)
    if gap > _LARGEST_GAP * kinematics.size:
        raise LinkageError(
            f"the assembled pose leaves joint {joint!r} open by {gap:.4g} mm "
            f"(at most {_LARGEST_GAP * kinematics.size:.3g} mm are closed without asking)"
        )
    for _ in range(20):
        matrix = kinematics.joints_jacobian(pose)[0]
        left, sizes, _ = np.linalg.svd(matrix)
        if sizes[-1] < 1e-9 * sizes[0]:
            names = ", ".join(held_twice(kinematics, left[:, -1:]))
            raise LinkageError(
                f"joints {names} hold the same motion twice in the assembled pose: a "
                "redundant guide, or a pose in which the linkage can move on in two ways"
            )
        error = kinematics.constraints(pose)[0] / kinematics.row_scale
        step = np.linalg.lstsq(matrix, error, rcond=None)[0]
        pose[:, 1:] -= (step * kinematics.pose_scale).reshape(1, -1, 3)
        if np.linalg.norm(step) < 1e-9:
            return pose
    raise LinkageError(f"the assembled pose does not close at joint {joint!r} (gap {gap:.4g} mm)")


def closest_approach(
    kinematics: Kinematics, coordinate: Coordinate, value: float, pose: FloatArray
) -> tuple[str, float]:
    """Return the joint that stays open, and its gap [mm], when a coordinate is forced to a value.

    First all joints give way alike; then the widest of them alone (the others 1000 times as stiff).
    """
    pose = _least_squares(kinematics, coordinate, value, pose, np.ones(kinematics.n_constraints))
    joint, _ = worst_joint(kinematics, pose)
    weights = np.full(kinematics.n_constraints, 1e3)
    weights[kinematics.rows[joint]] = 1.0
    pose = _least_squares(kinematics, coordinate, value, pose, weights)
    return worst_joint(kinematics, pose)


def _least_squares(
    kinematics: Kinematics,
    coordinate: Coordinate,
    value: float,
    pose: FloatArray,
    weights: FloatArray,
) -> FloatArray:
    """Return the pose of least weighted gaps at a value (Levenberg-Marquardt)."""
    scale = kinematics.coordinate_scale(coordinate)
    row_weights = np.append(weights, 1e6)

    def errors(pose: FloatArray) -> FloatArray:
        result: FloatArray = row_weights * np.append(
            kinematics.constraints(pose)[0] / kinematics.row_scale,
            (kinematics.value(coordinate, pose) - value) / scale,
        )
        return result

    damping, error = 1e-3, errors(pose)
    for _ in range(200):
        matrix = row_weights[:, None] * np.vstack(
            [
                kinematics.jacobian(pose)[0, :, 3:] / kinematics.row_scale[:, None],
                kinematics.gradient(coordinate, pose)[:, 3:] / scale,
            ]
        )
        matrix = matrix * kinematics.pose_scale
        damped = np.vstack([matrix, damping * np.eye(matrix.shape[1])])
        step = np.linalg.lstsq(damped, np.append(error, np.zeros(matrix.shape[1])), rcond=None)[0]
        trial = pose.copy()
        trial[:, 1:] -= (step * kinematics.pose_scale).reshape(1, -1, 3)
        trial_error = errors(trial)
        if np.linalg.norm(trial_error) < np.linalg.norm(error):
            pose, error, damping = trial, trial_error, max(damping / 5.0, 1e-9)
        else:
            damping *= 5.0
        if np.linalg.norm(step) < 1e-12:
            break
    return pose
