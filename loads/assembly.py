"""Closing the joints of a linkage, and places where they close in more than one way.

At change points the joints leave a linkage more than one way to go on. There the Jacobian of the
joints (without the row of the coordinate that leads) loses rank, whatever leads the motion. A
determinant tells this only where its sign changes: it does not where an even number of loops folds
at once, as two parallel four-bars side by side do. So the smallest singular value is bounded
between the positions, too.
"""

from collections.abc import Callable

import numpy as np

from loads.bodies import BoolArray, FloatArray, IntArray, LinkageError
from loads.joints import Coordinate, in_words
from loads.kinematics import Kinematics
from loads.linkage import Linkage

_CHANGE_POINT = 1e-4  # of the smallest singular value where the linkage is farthest from one
_INVOLVED = 0.05  # share of a joint in what is held twice
_ALSO = 100.0  # times the limit: singular values that vanish with the smallest one
_LARGEST_TURN = 0.5  # rad of a body in one step: its way is 1.01 of the chord
_WAY = 1.1  # length of a step in the space of Jacobians over its chord, at most
_LEAST = 1e-9  # of the range: the smallest step; at a change point it is left far above
_MOST = 100_000  # steps at once: machines take hundreds; 100 MB of Jacobians of eleven rows


def held_twice(kinematics: Kinematics, left: FloatArray) -> list[str]:
    """Return the joints that hold the same motion, the most involved first.

    left  (constraints, k)  left singular vectors of the singular values that vanish
    """
    shares = {name: float(np.linalg.norm(left[rows])) for name, rows in kinematics.rows.items()}
    return sorted((n for n in shares if shares[n] > _INVOLVED), key=lambda n: -shares[n])


def change_point_error(
    kinematics: Kinematics, coordinate: Coordinate, value: float, pose: FloatArray, limit: float
) -> LinkageError:
    """Return the error of a change point: where it is, and which joints let it be one.

    limit  singular values of the joints up to it have vanished
    """
    left, sizes, _ = np.linalg.svd(kinematics.joints_jacobian(pose)[0], full_matrices=False)
    gone = sizes <= max(_ALSO * limit, float(sizes[-1]))
    step = 1e-4 * (np.pi / 180.0 if coordinate.angular else kinematics.size)
    place = in_words(coordinate, float(np.round(value / step) * step) + 0.0)  # not -0
    return LinkageError(
        f"{coordinate.label} cannot be led on: at {place} the linkage can go on in two ways "
        f"(change point of joints {', '.join(held_twice(kinematics, left[:, gone]))}); end before "
        "it, or begin behind it"
    )


def check_change_points(
    kinematics: Kinematics,
    coordinate: Coordinate,
    values: FloatArray,
    poses: FloatArray,
    start: float,
    poses_at: Callable[[FloatArray], FloatArray],
) -> None:
    """Raise LinkageError where a path comes to a change point, at its positions or between them.

    values    (k,)            of the coordinate, rising
    poses     (k, bodies, 3)  there
    start     where the linkage is assembled: of several change points the nearest is reported
    poses_at  the poses (n, bodies, 3) at other values (n,)

    The smallest singular value s of the Jacobian J changes by no more than J does (Weyl). Between
    two positions a and b it is therefore at least (s_a + s_b - way) / 2, way being the length of
    what J runs through. Steps are halved until that is above the limit, or s itself is below. A
    linkage that is still not told from one at a change point after very many steps is refused, too.
    """
    jacobians = kinematics.joints_jacobian(poses)
    sizes = _smallest(jacobians)
    limit = _CHANGE_POINT * float(sizes.max())
    step_limit = _LEAST * float(values[-1] - values[0])
    first = np.arange(len(values) - 1)
    while True:
        if sizes.min() <= limit:
            k = int(np.argmin(np.where(sizes <= limit, np.abs(values - start), np.inf)))
            value = _meeting(values, sizes, k)
            raise change_point_error(kinematics, coordinate, value, poses[k : k + 1], limit)
        first = first[_undecided(values, poses, jacobians, sizes, first, limit)]
        if not len(first):
            return
        if len(first) > _MOST:
            share = float(sizes[first].min() / np.linalg.norm(jacobians[first[0]], ord=2))
            raise LinkageError(
                f"{coordinate.label} cannot be led on: between {in_words(coordinate, values[0])} "
                f"and {in_words(coordinate, values[-1])} the linkage cannot be told from one that "
                f"can go on in two ways: its joints are held to {share:.1g} of the best hold; "
                "lengths that differ that much are most likely mistyped"
            )
        middle = 0.5 * (values[first] + values[first + 1])
        if (values[first + 1] - values[first]).min() < step_limit:
            k = int(first[np.argmin(sizes[first])])
            raise change_point_error(
                kinematics, coordinate, float(values[k]), poses[k : k + 1], float(sizes[k])
            )
        between = poses_at(middle)
        values = np.insert(values, first + 1, middle)
        poses = np.insert(poses, first + 1, between, axis=0)
        added = kinematics.joints_jacobian(between)
        jacobians = np.insert(jacobians, first + 1, added, axis=0)
        sizes = np.insert(sizes, first + 1, _smallest(added))
        # every halved step has become two, and the ones behind it have moved up
        first = first + np.arange(len(first))
        first = np.sort(np.concatenate([first, first + 1]))


def _smallest(jacobians: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.svd(jacobians, compute_uv=False)[:, -1], dtype=float)


def _undecided(
    values: FloatArray,
    poses: FloatArray,
    jacobians: FloatArray,
    sizes: FloatArray,
    first: IntArray,
    limit: float,
) -> BoolArray:
    """Return which of the steps that begin at ``first`` may hold a change point."""
    turn = np.abs(poses[first + 1, :, 2] - poses[first, :, 2]).max(axis=1)
    way = _WAY * np.linalg.norm(jacobians[first + 1] - jacobians[first], axis=(1, 2))
    least = 0.5 * (sizes[first] + sizes[first + 1] - way)
    return np.asarray((least <= limit) | (turn > _LARGEST_TURN))


def _meeting(values: FloatArray, sizes: FloatArray, k: int) -> float:
    """Return where singular values fall to nothing, as near the one at k as straight lines tell."""
    if k in (0, len(values) - 1):
        return float(values[k])
    # beyond the point the slope has changed its sign: the sum over the step is smaller there
    other = min((k - 1, k + 1), key=lambda i: (sizes[k] + sizes[i]) / abs(values[k] - values[i]))
    share = float(sizes[k] / (sizes[k] + sizes[other]))
    return float(values[k] + share * (values[other] - values[k]))


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
