"""The closed positions of a linkage, and those that it can take along one coordinate.

They come in two steps: a coarse walk from the assembled pose, one small step after the other,
settles the branch; then Newton's method solves all wanted positions together from there.

At change points the joints leave a linkage more than one way to go on. There the Jacobian of the
joints (without the row of the coordinate that leads) loses rank, whatever leads the motion. A
determinant tells this only where its sign changes: it does not where an even number of loops folds
at once, as two parallel four-bars side by side do. So the smallest singular value is bounded
between the positions, too.
"""

import pickle
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from loads.bodies import (
    BoolArray,
    Coordinate,
    FloatArray,
    IntArray,
    LinkageError,
    in_words,
    place_in_words,
)
from loads.kinematics import Kinematics
from loads.linkage import Linkage
from loads.motion import (
    Geometry,
    closed_poses,
    derivative,
    differentiate,
    matrix,
    orientation,
    pose_norm,
)

_INVOLVED = 0.05  # share of a joint in what is held twice
_ALSO = 100.0  # times the limit: singular values that vanish with the smallest one
_LARGEST_STEP = 0.5  # rad of a body in one step: its way is 1.01 of the chord
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
    return np.asarray((least <= limit) | (turn > _LARGEST_STEP))


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


_STRAIGHT = 0.95  # cosine of the largest turn of the motion in one step of the walk
_LONGEST_CHORD = 1.5  # of what the rates at the ends of a step make of it
_LARGEST_TURN = np.pi  # of a body in one step: a whole turn more closes the joints as well
_REFINEMENTS = 30  # of the knots, where they do not lead to the positions between them
_CHANGE_POINT = 1e-4  # smallest over largest singular value of the joints where it stops
_SMALLEST_STEP = 1e-10  # of the range that is walked

_KEPT = 16  # paths: a cycle is tried and then solved, with other masses, by the same one

_Knot = tuple[float, FloatArray, FloatArray]


@dataclass(frozen=True, eq=False)
class Path:
    """One branch of a linkage's positions between two values of a coordinate: coarse knots on it.

    values    (k,)            rising
    poses     (k, bodies, 3)
    tangents  (k, bodies, 3)  d poses / d coordinate
    """

    kinematics: Kinematics
    coordinate: Coordinate
    values: FloatArray
    poses: FloatArray
    tangents: FloatArray

    @cached_property
    def orientation(self) -> float:
        """The sign of the Jacobian's determinant, one all along the branch."""
        return float(orientation(self.kinematics, self.coordinate, self.poses[:1])[0])

    def at(self, values: FloatArray) -> Geometry:
        """Return the positions at the given values of the coordinate, solved together."""
        values = np.asarray(values, dtype=float)
        poses = self.poses_at(values)
        return differentiate(self.kinematics, self.coordinate, values, poses)

    def poses_at(self, values: FloatArray) -> FloatArray:
        """Return the poses (n, bodies, 3) at the given values (n,), without their derivatives."""
        coordinate = self.coordinate
        low, high = self.values[0], self.values[-1]
        outside = (values < low) | (values > high)
        if outside.any():
            raise LinkageError(
                f"{place_in_words(coordinate, float(values[outside][0]))} is outside the path "
                f"{in_words(coordinate, low)} ... {in_words(coordinate, high)}"
            )
        path = self
        for level in range(_REFINEMENTS + 1):
            poses, wrong = path._guided(values)
            if not wrong.any():
                return poses
            if level < _REFINEMENTS:
                path = path._refined(values[wrong])
        raise LinkageError(
            "the positions jump to another branch at "
            f"{place_in_words(coordinate, float(values[wrong][0]))}: the way the linkage is "
            "assembled is not unique there"
        )

    def _guided(self, values: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return poses found from the knots, and which of them are not on the branch."""
        k = self._interval(values)
        guess = self._hermite(values, k)
        poses, converged = closed_poses(self.kinematics, self.coordinate, values, guess)
        chord = pose_norm(self.kinematics, self.poses[k + 1] - self.poses[k])
        strayed = pose_norm(self.kinematics, poses - guess) > 0.25 * chord + 1e-6
        turned = orientation(self.kinematics, self.coordinate, poses) != self.orientation
        return poses, ~converged | strayed | turned

    def _interval(self, values: FloatArray) -> IntArray:
        return np.clip(np.searchsorted(self.values, values) - 1, 0, len(self.values) - 2)

    def _refined(self, values: FloatArray) -> "Path":
        """Return the path with more knots around the given values."""
        knots: list[_Knot] = []
        crowded = set(self._interval(values).tolist())
        for k in range(len(self.values)):
            knot = (float(self.values[k]), self.poses[k : k + 1], self.tangents[k : k + 1])
            knots.append(knot)
            if k in crowded:
                middle = 0.5 * (self.values[k] + self.values[k + 1])
                knots += _walk(self.kinematics, self.coordinate, knot, float(middle))
        return _path(self.kinematics, self.coordinate, knots)

    def _hermite(self, values: FloatArray, k: IntArray) -> FloatArray:
        start, step = self.values[k], self.values[k + 1] - self.values[k]
        t = ((values - start) / step)[:, None, None]
        h = step[:, None, None]
        return np.asarray(
            (1 + 2 * t) * (1 - t) ** 2 * self.poses[k]
            + t * (1 - t) ** 2 * h * self.tangents[k]
            + t**2 * (3 - 2 * t) * self.poses[k + 1]
            + t**2 * (t - 1) * h * self.tangents[k + 1]
        )


_traced: OrderedDict[bytes, Path] = OrderedDict()


def trace(linkage: Linkage, coordinate: Coordinate, first: float, second: float) -> Path:
    """Return the branch of positions that holds the assembled pose, between two values.

    Raises LinkageError if the assembled pose does not close, if a value cannot be reached, or if
    the way there comes to a change point.
    """
    linkage.check_coordinate(coordinate, "swept coordinate")
    kinematics = Kinematics(linkage)
    low, high = min(first, second), max(first, second)
    key = pickle.dumps((geometry_of(linkage), coordinate, low, high))
    if key not in _traced:
        _traced[key] = _traced_anew(kinematics, coordinate, low, high)
        if len(_traced) > _KEPT:
            _traced.popitem(last=False)
    return replace(_traced[key], kinematics=kinematics)


def geometry_of(linkage: Linkage) -> tuple[object, ...]:
    """All of a linkage that its positions depend on: not masses, forces or what gives way."""
    points = [(body.name, dict(body.points)) for body in linkage.bodies]
    return points, linkage.joints, dict(linkage.assembled)


def _traced_anew(kinematics: Kinematics, coordinate: Coordinate, low: float, high: float) -> Path:
    pose = assemble(kinematics)
    start = float(kinematics.value(coordinate, pose)[0])
    scale = max(abs(low), abs(high), abs(start), 1e-3 * kinematics.coordinate_scale(coordinate))
    knots = [(start, pose, _tangent(kinematics, coordinate, start, pose))]
    try:
        for end in (low, high):
            if (end < start) == (end == low) and abs(end - start) > 1e-13 * scale:
                knots += _walk(kinematics, coordinate, knots[0], end)
        knots.sort(key=lambda knot: knot[0])
        if len(knots) == 1:
            raise LinkageError(f"{coordinate.label} does not change: {low:g} to {high:g}")
        # the assembled value and the asked end may differ by rounding only
        knots[0] = (min(knots[0][0], low), *knots[0][1:])
        knots[-1] = (max(knots[-1][0], high), *knots[-1][1:])
        path = _path(kinematics, coordinate, knots)
        check_change_points(kinematics, coordinate, path.values, path.poses, start, path.poses_at)
    except LinkageError as error:
        if low - 1e-9 * scale <= start <= high + 1e-9 * scale:
            raise
        end = high if start < low else low
        raise LinkageError(f"{error}{_as_drawn(coordinate, end, start)}") from error
    return path


def _tangent(
    kinematics: Kinematics, coordinate: Coordinate, value: float, pose: FloatArray
) -> FloatArray:
    jacobian = matrix(kinematics, coordinate, pose)
    right = np.zeros(jacobian.shape[:2])
    right[:, -1] = 1.0
    return derivative(kinematics, coordinate, jacobian, right, np.array([value]), leading=True)


def _path(kinematics: Kinematics, coordinate: Coordinate, knots: list[_Knot]) -> Path:
    return Path(
        kinematics,
        coordinate,
        np.array([knot[0] for knot in knots]),
        np.concatenate([knot[1] for knot in knots]),
        np.concatenate([knot[2] for knot in knots]),
    )


def _walk(kinematics: Kinematics, coordinate: Coordinate, knot: _Knot, end: float) -> list[_Knot]:
    """Return knots from one value of the coordinate to another, each near the one before."""
    knots: list[_Knot] = []
    total = end - knot[0]
    slack = 1e-12 * abs(total) + 16 * np.finfo(float).eps * abs(end)
    share = 1.0 / 16.0
    before: _Knot | None = None
    while knot[0] != end:
        value, pose, _ = knot
        target = value + share * total
        # sums of steps stray by rounding: a rest that is no more than that is not walked
        if (end - target) * np.sign(total) <= slack:
            target = end
        following = _step(kinematics, coordinate, before, knot, target)
        if following is None:
            share /= 2.0
            if share < _SMALLEST_STEP:
                raise _stopped(kinematics, coordinate, pose, end, value)
            continue
        knots.append(following)
        before, knot = knot, following
        share = min(2.0 * share, 1.0 / 16.0)
    return knots


def _as_drawn(coordinate: Coordinate, end: float, start: float) -> str:
    """Say in words where the points are drawn, from where a path is led past all to its far end.

    An angle may have been meant full turns beside it.
    """
    drawn = f"; as drawn it is {in_words(coordinate, start)}"
    turns = round((end - start) / (2 * np.pi)) if coordinate.angular else 0
    meant = end - 2 * np.pi * turns
    if turns and abs(meant - start) <= np.pi / 2:
        return f"{drawn}: is {in_words(coordinate, meant)} meant?"
    return f"{drawn}, and is led from there: draw the points within the cycle"


def _step(
    kinematics: Kinematics,
    coordinate: Coordinate,
    before: _Knot | None,
    knot: _Knot,
    target: float,
) -> _Knot | None:
    value, pose, tangent = knot
    ahead = target - value
    guess = pose + tangent * ahead
    if before is not None:  # the tangent goes on turning as it did
        guess += (tangent - before[2]) / (value - before[0]) * (0.5 * ahead**2)
    poses, converged = closed_poses(kinematics, coordinate, np.array([target]), guess)
    if not converged[0]:
        return None
    try:
        following = _tangent(kinematics, coordinate, target, poses)
    except LinkageError:
        return None
    if len(set(orientation(kinematics, coordinate, np.concatenate([pose, poses])))) > 1:
        return None
    if np.abs(poses[0, :, 2] - pose[0, :, 2]).max() > _LARGEST_TURN:
        return None
    # a chord longer than the rates at its ends allow has swallowed a turn of a body
    fastest = max(float(pose_norm(kinematics, each)[0]) for each in (tangent, following))
    if (
        float(pose_norm(kinematics, poses - pose)[0])
        > _LONGEST_CHORD * abs(target - value) * fastest
    ):
        return None
    chord = (poses - pose) * np.sign(target - value)
    for direction in (tangent, following):
        if _cosine(kinematics, chord, direction) < _STRAIGHT:
            return None
    return target, poses, following


def _cosine(kinematics: Kinematics, a: FloatArray, b: FloatArray) -> float:
    scaled = [change.reshape(-1)[3:] / kinematics.pose_scale for change in (a, b)]
    lengths = float(np.linalg.norm(scaled[0]) * np.linalg.norm(scaled[1]))
    return float(scaled[0] @ scaled[1]) / lengths if lengths else 1.0


def _stopped(
    kinematics: Kinematics, coordinate: Coordinate, pose: FloatArray, end: float, last: float
) -> LinkageError:
    """Return the error of a value that cannot be reached, with the gap that stays in the joints."""
    wanted, reached = (in_words(coordinate, value) for value in (end, last))
    joint, gap = closest_approach(kinematics, coordinate, end, pose)
    where = end
    if gap < 1e-6 * kinematics.size:
        # the end can be reached from the other side: how far do they open on the way?
        where = last + 1e-2 * (end - last)
        joint, gap = closest_approach(kinematics, coordinate, where, pose)
    if gap >= 1e-9 * kinematics.size:
        place = "there" if where == end else f"at {in_words(coordinate, where)}"
        return LinkageError(
            f"{coordinate.label} = {wanted} cannot be reached: joint {joint!r} stays open by "
            f"{gap:.4g} mm {place}; the last value that can be reached is {reached}"
        )
    sizes = np.linalg.svd(kinematics.joints_jacobian(pose)[0], compute_uv=False)
    if sizes[-1] < _CHANGE_POINT * sizes[0]:
        return change_point_error(kinematics, coordinate, last, pose, float(sizes[-1]))
    return LinkageError(
        f"{coordinate.label} cannot be led to {wanted}: it stands still at {reached} (dead "
        "centre); end before it, or sweep another coordinate"
    )
