"""The positions a linkage can take along one coordinate, and how it moves through them.

Positions come in two steps: a coarse walk from the assembled pose, one small step after the other,
settles the branch; then Newton's method solves all wanted positions together from there.
"""

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from loads.assembly import assemble, closest_approach
from loads.bodies import BoolArray, FloatArray, IntArray, LinkageError
from loads.elements import Coordinate, in_words, place_in_words
from loads.kinematics import Kinematics, dot
from loads.linkage import Linkage

# A coordinate whose share of the motion is below this cannot lead (or load) it: beyond, more than
# ten of the sixteen digits of a double are lost.
SINGULAR = 1e-6
_STRAIGHT = 0.95  # cosine of the largest turn of the motion in one step of the walk
_REFINEMENTS = 30  # of the knots, where they do not lead to the positions between them
_CHANGE_POINT = 1e-4  # smallest over largest singular value of the joints where it stops
_SMALLEST_STEP = 1e-10  # of the range that is walked


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
        return float(_orientation(self.kinematics, self.coordinate, self.poses[:1])[0])

    def at(self, values: FloatArray) -> Geometry:
        """Return the positions at the given values of the coordinate, solved together."""
        kinematics, coordinate = self.kinematics, self.coordinate
        values = np.asarray(values, dtype=float)
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
                return differentiate(kinematics, coordinate, values, poses)
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
        poses, converged = _newton(self.kinematics, self.coordinate, values, guess)
        chord = _norm(self.kinematics, self.poses[k + 1] - self.poses[k])
        strayed = _norm(self.kinematics, poses - guess) > 0.25 * chord + 1e-6
        turned = _orientation(self.kinematics, self.coordinate, poses) != self.orientation
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
        guess: FloatArray = (
            (1 + 2 * t) * (1 - t) ** 2 * self.poses[k]
            + t * (1 - t) ** 2 * h * self.tangents[k]
            + t**2 * (3 - 2 * t) * self.poses[k + 1]
            + t**2 * (t - 1) * h * self.tangents[k + 1]
        )
        return guess


def trace(linkage: Linkage, coordinate: Coordinate, first: float, second: float) -> Path:
    """Return the branch of positions that holds the assembled pose, between two values.

    Raises LinkageError if the assembled pose does not close, or if a value cannot be reached.
    """
    linkage.check_coordinate(coordinate, "swept coordinate")
    kinematics = Kinematics(linkage)
    low, high = min(first, second), max(first, second)
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
    return _path(kinematics, coordinate, knots)


def differentiate(
    kinematics: Kinematics, coordinate: Coordinate, values: FloatArray, poses: FloatArray
) -> Geometry:
    """Return first and second derivatives of solved poses by the coordinate.

    With A the constraint Jacobian over the coordinate's gradient: A q' = (0, 1) and
    A q'' = -(quadratic terms for q').
    """
    matrix = _matrix(kinematics, coordinate, poses)
    right = np.zeros(matrix.shape[:2])
    right[:, -1] = 1.0
    first = _solve(kinematics, coordinate, matrix, right, values, leading=True)
    scale = kinematics.coordinate_scale(coordinate)
    bend = np.concatenate(
        [
            kinematics.quadratic(poses, first) / kinematics.row_scale,
            kinematics.curvature(coordinate, poses, first)[:, None] / scale,
        ],
        axis=1,
    )
    # times scale: _solve divides once, as for a first derivative
    second = _solve(kinematics, coordinate, matrix, -bend * scale, values, leading=False)
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
    """Return how much of the motion a coordinate sees (n,), between -1 and 1, 0 at a dead centre.

    The coordinate's derivative along the motion over the product of the lengths of its gradient and
    of the motion, lengths measured by the linkage's size and angles in rad.
    """
    gradient = kinematics.gradient(coordinate, poses)[:, 3:] * kinematics.pose_scale
    rates = first.reshape(len(poses), -1)[:, 3:] / kinematics.pose_scale
    length = np.linalg.norm(gradient, axis=1) * np.linalg.norm(rates, axis=1)
    result: FloatArray = dot(gradient, rates) / length
    return result


def _matrix(kinematics: Kinematics, coordinate: Coordinate, poses: FloatArray) -> FloatArray:
    """Return the unit-free Jacobian of the constraints, the coordinate as its last row."""
    return _bordered(kinematics, coordinate, poses, kinematics.jacobian(poses))


def _bordered(
    kinematics: Kinematics, coordinate: Coordinate, poses: FloatArray, jacobian: FloatArray
) -> FloatArray:
    scale = kinematics.coordinate_scale(coordinate)
    n, rows, _ = jacobian.shape
    result = np.empty((n, rows + 1, len(kinematics.pose_scale)))
    result[:, :-1] = jacobian[:, :, 3:] * (kinematics.pose_scale / kinematics.row_scale[:, None])
    result[:, -1] = kinematics.gradient(coordinate, poses)[:, 3:] * (kinematics.pose_scale / scale)
    return result


def _solve(
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
    solution = _solved(matrix, right)
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


def _tangent(
    kinematics: Kinematics, coordinate: Coordinate, value: float, pose: FloatArray
) -> FloatArray:
    matrix = _matrix(kinematics, coordinate, pose)
    right = np.zeros(matrix.shape[:2])
    right[:, -1] = 1.0
    return _solve(kinematics, coordinate, matrix, right, np.array([value]), leading=True)


def _norm(kinematics: Kinematics, change: FloatArray) -> FloatArray:
    result: FloatArray = np.linalg.norm(
        change.reshape(len(change), -1)[:, 3:] / kinematics.pose_scale, axis=1
    )
    return result


def _newton(
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
        step = _solved(_bordered(kinematics, coordinate, poses, jacobian), error)
        size = np.linalg.norm(step, axis=1)
        # what runs away is left where it is, so that the others come to their end
        lost |= ~np.isfinite(size) | (size > 10.0)
        step[lost] = 0.0
        poses[:, 1:] -= (step * kinematics.pose_scale).reshape(len(poses), -1, 3)
        # the step after a step of 1e-8 is at rounding: quadratic convergence
        done = (size < 1e-8) & ~lost
    residual = np.abs(error).max(axis=1)
    return poses, done & (residual < 1e-12)


def closed_poses(
    kinematics: Kinematics, coordinate: Coordinate, values: FloatArray, guess: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return poses near a guess with the given values of a coordinate, and which closed."""
    return _newton(kinematics, coordinate, values, guess)


def _solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Return solutions (n, k) of n systems; infinite where one is singular."""
    try:
        return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
    except np.linalg.LinAlgError:
        result = np.full(right.shape, np.inf)
        for k, (one, load) in enumerate(zip(matrix, right, strict=True)):
            with suppress(np.linalg.LinAlgError):
                result[k] = np.linalg.solve(one, load)
        return result


def _orientation(kinematics: Kinematics, coordinate: Coordinate, poses: FloatArray) -> FloatArray:
    """Return the sign of the Jacobian's determinant (n,).

    It is the same all along a branch and changes at every fold of the coordinate and every change
    point, so that it tells two branches apart that come near each other there.
    """
    signs: FloatArray = np.linalg.slogdet(_matrix(kinematics, coordinate, poses))[0]
    return signs


_Knot = tuple[float, FloatArray, FloatArray]


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
    poses, converged = _newton(kinematics, coordinate, np.array([target]), guess)
    if not converged[0]:
        return None
    try:
        following = _tangent(kinematics, coordinate, target, poses)
    except LinkageError:
        return None
    if len(set(_orientation(kinematics, coordinate, np.concatenate([pose, poses])))) > 1:
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
    """Return the error of a value that cannot be reached: how far the joints stay open there."""
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
    scaled = kinematics.jacobian(pose)[0, :, 3:] * (
        kinematics.pose_scale / kinematics.row_scale[:, None]
    )
    sizes = np.linalg.svd(scaled, compute_uv=False)
    if sizes[-1] < _CHANGE_POINT * sizes[0]:
        return LinkageError(
            f"{coordinate.label} cannot be led to {wanted}: at {reached} the linkage can go on in "
            "two ways (change point); end before it, or begin behind it"
        )
    return LinkageError(
        f"{coordinate.label} cannot be led to {wanted}: it stands still at {reached} (dead "
        "centre); end before it, or sweep another coordinate"
    )
