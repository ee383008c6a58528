"""The positions a linkage can take along one coordinate.

They come in two steps: a coarse walk from the assembled pose, one small step after the other,
settles the branch; then Newton's method solves all wanted positions together from there.
"""

import pickle
from collections import OrderedDict
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from loads.assembly import assemble, change_point_error, check_change_points, closest_approach
from loads.bodies import BoolArray, FloatArray, IntArray, LinkageError
from loads.joints import Coordinate, in_words, place_in_words
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
