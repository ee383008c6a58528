"""Change points: places where the joints leave a linkage more than one way to go on.

There the Jacobian of the joints (without the row of the coordinate that leads) loses rank, whatever
leads the motion. A determinant tells this only where its sign changes: it does not where an even
number of loops folds at once, as two parallel four-bars side by side do. So the smallest singular
value is bounded between the positions, too.
"""

from collections.abc import Callable

import numpy as np

from loads.bodies import BoolArray, FloatArray, IntArray, LinkageError
from loads.joints import Coordinate, in_words
from loads.kinematics import Kinematics

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
