"""Kinetostatics: the joint reactions and the one unknown effort that go with a given motion.

For every position, over the coordinates of all bodies,

    J' reactions + effort + given forces + friction(reactions) = mass x (acceleration - gravity)

(Nikravesh, Planar Multibody Dynamics, ch. 8), unit-free in lengths so that it does not matter
whether a linkage is stated in mm or in m. Coulomb friction depends on the reactions. It is grown
from nothing to its full size, with Newton's method at every step, which follows the one solution
that belongs to the frictionless linkage; where that solution ends, the linkage locks itself.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from loads.bodies import (
    Angle,
    Distance,
    Fixed,
    FloatArray,
    Force,
    IntArray,
    LinkageError,
    Prismatic,
    Revolute,
    Slot,
    Vector,
    nearest,
)
from loads.kinematics import Kinematics, acceleration_at, centre_arm, cross, dot, turned_left
from loads.motion import SINGULAR, Motion, coordinate_share

_AT_REST = 1e-10  # of the rates of the linkage: slower sliding is rounding, sign(0) = 0
_STEPS = 8  # in which friction grows
_LOCKED = 1e-6  # of the frictionless determinant


@dataclass(frozen=True, eq=False)
class JointLoad:
    """Reaction of a joint on its body b, at the point of body b; body a gets the opposite there.

    force            (n, 2)  N, ground axes, everything: normal and, of guides, friction
    moment           (n,)    N mm, couple of a guide or weld (zero for pins and slots)
    friction_couple  (n,)    N mm, of a pin
    friction_force   (n,)    N, of a guide or slot, along its direction
    """

    force: FloatArray
    moment: FloatArray
    friction_couple: FloatArray
    friction_force: FloatArray


@dataclass(frozen=True, eq=False)
class ForceSolution:
    """Reactions by joint and efforts by force name (n,).

    vector  (n, constraints + 1)  all reactions, moments over the size of the linkage [N]
    """

    joints: Mapping[str, JointLoad]
    efforts: Mapping[str, FloatArray]
    vector: FloatArray


def one_after_another(solutions: Sequence[ForceSolution]) -> ForceSolution:
    """Join the solutions of successive phases into one over all positions."""
    first = solutions[0]
    return ForceSolution(
        {
            name: JointLoad(
                *(
                    np.concatenate([getattr(one.joints[name], part) for one in solutions])
                    for part in ("force", "moment", "friction_couple", "friction_force")
                )
            )
            for name in first.joints
        },
        {name: np.concatenate([one.efforts[name] for one in solutions]) for name in first.efforts},
        np.concatenate([one.vector for one in solutions]),
    )


@dataclass(frozen=True, eq=False)
class _Sliding:
    """Friction at one place of a joint: |combined reaction| times a factor, along ``pull``.

    combined  (m, k)         what of the reaction in the k rows presses there, m ways
    pull      (n, unknowns)
    factor    (n,)           signed: what to multiply the size by to get couple or force
    """

    joint: str
    rows: slice
    combined: FloatArray
    pull: FloatArray
    factor: FloatArray

    def pressed(self, vector: FloatArray) -> FloatArray:
        """Return what presses (n, m) for unknowns (n, unknowns)."""
        return np.asarray(vector[:, self.rows] @ self.combined.T)


def solve_forces(
    motion: Motion, given: Mapping[str, float | FloatArray], solve: str
) -> ForceSolution:
    """Return reactions and the effort ``solve`` for a motion under given forces [N, N mm].

    given  by force name, the same everywhere or one for each position (n,)

    Raises LinkageError at a dead centre of the effort and where friction locks the linkage.
    """
    _check_names(motion, given, solve)
    linkage, n = motion.kinematics.linkage, len(motion.values)
    _check_dead_centre(motion, linkage.force(solve))
    matrix = _matrix(motion, linkage.force(solve))
    right = _inertia(motion)
    for name, value in given.items():
        size = np.broadcast_to(np.asarray(value, dtype=float), n)
        right -= size[:, None] * _generalised(motion, linkage.force(name))
    frictions = _frictions(motion)
    vector = _solve_with_friction(motion, matrix, right, frictions)
    efforts = {name: np.zeros(n) + value for name, value in given.items()}
    return _unpacked(motion, solve, vector, efforts, frictions)


def unit_forces(
    motion: Motion, names: Sequence[str], size: float, solve: str
) -> list[ForceSolution]:
    """Return the forces of each given force alone: no weight, no inertia, no friction."""
    linkage, n = motion.kinematics.linkage, len(motion.values)
    effort = linkage.force(solve)
    _check_dead_centre(motion, effort)
    matrix = _matrix(motion, effort)
    found = []
    for name in names:
        right = -size * _generalised(motion, linkage.force(name))
        vector = np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
        efforts = {force.name: np.zeros(n) for force in linkage.forces}
        efforts[name] = np.full(n, float(size))
        found.append(_unpacked(motion, solve, vector, efforts, []))
    return found


def _check_dead_centre(motion: Motion, effort: Force) -> None:
    """Raise LinkageError where an effort's coordinate stands still."""
    share = coordinate_share(motion.kinematics, effort.coordinate, motion.poses, motion.heading)
    singular = (np.abs(share) < SINGULAR) | (share * share[0] <= 0.0)
    if singular.any():
        place = motion.place(int(np.argmax(singular)))
        raise LinkageError(
            f"force {effort.name!r} cannot balance the linkage at or before {place}: its "
            f"coordinate {effort.coordinate.label} stands still there (dead centre), the force "
            "would be infinite; end the phase before it, or solve for another force"
        )


def _matrix(motion: Motion, effort: Force) -> FloatArray:
    """Return the matrix from reactions and effort to generalised forces, unit-free in lengths."""
    kinematics = motion.kinematics
    size = kinematics.n_constraints + 1
    matrix = np.empty((len(motion.values), size, size))
    matrix[:, :, :-1] = np.swapaxes(kinematics.joints_jacobian(motion.poses), 1, 2)
    scale = kinematics.coordinate_scale(effort.coordinate)
    matrix[:, :, -1] = _generalised(motion, effort) * kinematics.size / scale
    return matrix


def _unpacked(
    motion: Motion,
    solve: str,
    vector: FloatArray,
    efforts: dict[str, FloatArray],
    frictions: list[_Sliding],
) -> ForceSolution:
    kinematics = motion.kinematics
    unknown = vector[:, :-1] * kinematics.size / kinematics.row_scale
    scale = kinematics.coordinate_scale(kinematics.linkage.force(solve).coordinate)
    efforts = efforts | {solve: vector[:, -1] * kinematics.size / scale}
    zero = np.zeros(len(vector))
    sliding: dict[str, FloatArray] = {}
    for friction in frictions:
        own = friction.factor * np.linalg.norm(friction.pressed(vector), axis=1)
        sliding[friction.joint] = sliding.get(friction.joint, zero) + own
    joints: dict[str, JointLoad] = {}
    for joint in kinematics.linkage.joints:
        part = unknown[:, kinematics.rows[joint.name]]
        slid = sliding.get(joint.name, zero)
        match joint:
            case Revolute():
                joints[joint.name] = JointLoad(part, zero, slid, zero)
            case Fixed():
                joints[joint.name] = JointLoad(part[:, :2], part[:, 2], zero, zero)
            case Slot() | Prismatic():
                along = kinematics.line(motion.poses, joint)
                force = turned_left(along) * part[:, :1] + along * slid[:, None]
                couple = part[:, 1] if isinstance(joint, Prismatic) else zero
                joints[joint.name] = JointLoad(force, couple, zero, slid)
    return ForceSolution(joints, efforts, vector)


def _check_names(motion: Motion, given: Mapping[str, float | FloatArray], solve: str) -> None:
    linkage = motion.kinematics.linkage
    known = {force.name for force in linkage.forces}
    for name in (*given, solve):
        if name not in known:
            raise LinkageError(f"no force is named {name!r}; {nearest(name, known)}")
    if solve in given:
        raise LinkageError(f"force {solve!r} is both given and to be solved for")
    for name in sorted(known - {*given, solve}):
        raise LinkageError(
            f"force {name!r} is neither given nor solved for; state 0 N if it is idle"
        )


def _generalised(motion: Motion, force: Force) -> FloatArray:
    """Return the load of a unit force on all coordinates, moments over the linkage's size."""
    kinematics = motion.kinematics
    gradient = kinematics.gradient(force.coordinate, motion.poses)[:, 3:]
    return np.asarray(force.sign * gradient * kinematics.pose_scale / kinematics.size)


def _inertia(motion: Motion) -> FloatArray:
    """Return mass x (acceleration - gravity) over all coordinates, moments over the size [N]."""
    kinematics = motion.kinematics
    result = np.zeros((len(motion.values), kinematics.n_bodies - 1, 3))
    for i, body in enumerate(kinematics.linkage.moving):
        arm = centre_arm(body, motion.poses[:, i + 1])
        own = motion.accelerations[:, i + 1]
        pull = acceleration_at(arm, motion.velocities[:, i + 1], own)
        pull -= np.array(kinematics.linkage.gravity)
        result[:, i, :2] = body.mass * pull
        result[:, i, 2] = body.inertia * own[:, 2] + body.mass * (
            arm[:, 0] * pull[:, 1] - arm[:, 1] * pull[:, 0]
        )
    flat: FloatArray = result.reshape(len(motion.values), -1)
    return flat * kinematics.pose_scale / kinematics.size


def _frictions(motion: Motion) -> list[_Sliding]:
    """Return the friction of every joint that has some, against the sliding of b on a."""
    kinematics = motion.kinematics
    n = len(motion.values)
    scaled = motion.heading.reshape(n, -1)[:, 3:] / kinematics.pose_scale
    typical = np.linalg.norm(scaled, axis=1)
    result = []
    for joint in kinematics.linkage.joints:
        friction = kinematics.linkage.friction.get(joint.name)
        if friction is None or not friction.coefficient:
            continue
        rows = kinematics.rows[joint.name]
        combined = [np.eye(2)]
        if isinstance(joint, Prismatic | Slot):
            combined = [np.eye(1)]
            if isinstance(joint, Prismatic) and friction.length:  # two bearings, N/2 +- M/L
                scale = kinematics.row_scale[rows]
                arm = float(scale[0] / scale[1] / friction.length)
                combined = [np.array([[0.5, sign * arm]]) for sign in (1.0, -1.0)]
            rows = slice(rows.start, rows.start + combined[0].shape[1])
            rate = kinematics.sliding(motion.poses, motion.heading, joint) / kinematics.size
            gradient = kinematics.sliding_gradient(motion.poses, joint)
            factor = friction.coefficient
        else:
            b, a = kinematics.index[joint.body_b], kinematics.index[joint.body_a]
            rate = motion.heading[:, b, 2] - motion.heading[:, a, 2]
            gradient = np.zeros((n, 3 * kinematics.n_bodies))
            gradient[:, 3 * b + 2], gradient[:, 3 * a + 2] = 1.0, -1.0
            factor = friction.coefficient * friction.radius
        sign = np.where(np.abs(rate) > _AT_REST * typical, np.sign(rate), 0.0)
        pull = gradient[:, 3:] * kinematics.pose_scale / kinematics.size
        result += [_Sliding(joint.name, rows, one, pull, -factor * sign) for one in combined]
    return result


def _solve_with_friction(
    motion: Motion, matrix: FloatArray, right: FloatArray, frictions: list[_Sliding]
) -> FloatArray:
    """Return the unknowns of matrix z + friction(z) = right, on the branch of no friction."""
    vector: FloatArray = np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0], dtype=float)
    if not frictions:
        return vector
    signs, sizes = np.linalg.slogdet(matrix)
    for share in np.arange(1, _STEPS + 1) / _STEPS:
        converged = np.zeros(len(right), dtype=bool)
        for _ in range(40):
            slope, friction = _linearised(matrix, vector, frictions, share)
            error = right - np.einsum("nij,nj->ni", matrix, vector) - friction
            scale = np.abs(vector).max(axis=1) + np.abs(right).max(axis=1)
            converged = np.abs(error).max(axis=1) <= 1e-13 * scale
            if converged.all():
                break
            new_signs, new_sizes = np.linalg.slogdet(slope)
            if ((new_signs != signs) | (new_sizes < sizes + np.log(_LOCKED))).any():
                break
            step = np.linalg.solve(slope, error[..., None])[..., 0]
            vector = vector + step
            if (np.abs(step).max(axis=1) <= 1e-13 * np.abs(vector).max(axis=1)).all():
                converged = np.ones(len(right), dtype=bool)
                break
        slope, _friction = _linearised(matrix, vector, frictions, share)
        new_signs, new_sizes = np.linalg.slogdet(slope)
        locked = ~converged | (new_signs != signs) | (new_sizes < sizes + np.log(_LOCKED))
        if locked.any():
            raise _locking(motion, vector, frictions, int(np.argmax(locked)))
    return vector


def _linearised(
    matrix: FloatArray, vector: FloatArray, frictions: list[_Sliding], share: float
) -> tuple[FloatArray, FloatArray]:
    """Return the matrix with the slope of friction added, and the friction itself."""
    slope, load = matrix.copy(), np.zeros_like(vector)
    for friction in frictions:
        part = friction.pressed(vector)
        size = np.linalg.norm(part, axis=1)
        pull = share * friction.factor[:, None] * friction.pull
        load += pull * size[:, None]
        along = (part / np.where(size > 0.0, size, 1.0)[:, None]) @ friction.combined
        slope[:, :, friction.rows] += pull[:, :, None] * along[:, None, :]
    return slope, load


def _locking(motion: Motion, vector: FloatArray, frictions: list[_Sliding], k: int) -> LinkageError:
    """Return the error of self-locking, naming the joint whose friction takes the most power."""
    rates = motion.heading.reshape(len(vector), -1)[k, 3:] / motion.kinematics.pose_scale
    power: dict[str, float] = {}
    for friction in frictions:
        pressed = float(np.linalg.norm(friction.pressed(vector[[k]])))
        own = abs(float(friction.factor[k] * (friction.pull[k] @ rates))) * pressed
        power[friction.joint] = power.get(friction.joint, 0.0) + own
    joint = max(power, key=lambda name: power[name])
    coefficient = motion.kinematics.linkage.friction[joint].coefficient
    return LinkageError(
        f"friction locks the linkage at {motion.place(k)}: no force moves it; most of it is "
        f"in joint {joint!r}, coefficient {coefficient:g}"
    )


# Loads on one body, point by point.
_NOWHERE: FloatArray = np.zeros(0)


@dataclass(frozen=True, eq=False)
class LoadHistory:
    """Loads on one part over the cycle, in the part's own axes and in equilibrium.

    positions      (n,)       swept coordinate, mm or rad
    times          (n,)       s
    phases, phase_of          names of the phases, and the phase of each position (n,)
    locations      (m, 2)     mm, of the interfaces, in the body frame
    wrenches       (n, m, 6)  N, N mm: force and moment (Fx, Fy, Fz, Mx, My, Mz) ON the part
    accelerations  (n, 4)     mm/s2, mm/s2, rad/s2, rad2/s2: of the frame origin minus gravity,
                              angular, and omega**2
    reaches        (n, m, 2)  mm, in the body frame: from an interface's location, where its wrench
                              is stated, to where its force acts; not zero where a contact slides

    A material point (x, y) has the acceleration minus gravity
    (a_x - alpha y - omega2 x, a_y + alpha x - omega2 y).
    """

    part: str
    interfaces: tuple[str, ...]
    positions: FloatArray
    times: FloatArray
    phases: tuple[str, ...]
    phase_of: IntArray
    locations: FloatArray
    wrenches: FloatArray
    accelerations: FloatArray
    reaches: FloatArray = field(default_factory=lambda: _NOWHERE)

    def __post_init__(self) -> None:
        n, m = len(self.positions), len(self.interfaces)
        if self.reaches is _NOWHERE:
            object.__setattr__(self, "reaches", np.zeros((n, m, 2)))
        for name, expected in (
            ("positions", (n,)),
            ("times", (n,)),
            ("phase_of", (n,)),
            ("locations", (m, 2)),
            ("wrenches", (n, m, 6)),
            ("accelerations", (n, 4)),
            ("reaches", (n, m, 2)),
        ):
            values = np.asarray(getattr(self, name))
            if values.shape != expected:
                raise ValueError(
                    f"loads on {self.part!r}: {n} positions and {m} interfaces need {name} "
                    f"of shape {expected}, got {values.shape}"
                )
            if not np.isfinite(values).all():
                raise ValueError(f"loads on {self.part!r}: {name} are not all finite numbers")
        if n and not (np.min(self.phase_of) >= 0 and np.max(self.phase_of) < len(self.phases)):
            raise ValueError(f"loads on {self.part!r}: phase_of points outside {self.phases}")

    def scaled(self, factor: float) -> Self:
        """Return the same history with all loads and accelerations times a factor."""
        return replace(
            self, wrenches=factor * self.wrenches, accelerations=factor * self.accelerations
        )

    def equilibrium_residual(self, mass: float, centre: Vector, inertia: float) -> FloatArray:
        """Return residual forces and moment about the origin, d'Alembert's included (n, 3).

        mass, centre (in the body frame) and inertia about the centre belong to the part's model;
        the units are N and N mm. Zero where they agree with the linkage's body.
        """
        x, y = self.locations[:, 0], self.locations[:, 1]
        force_x, force_y = self.wrenches[:, :, 0], self.wrenches[:, :, 1]
        moment = np.sum(self.wrenches[:, :, 5] + x * force_y - y * force_x, axis=1)
        a_x, a_y, alpha, omega2 = self.accelerations.T
        c_x, c_y = centre
        centre_x = a_x - alpha * c_y - omega2 * c_x
        centre_y = a_y + alpha * c_x - omega2 * c_y
        return np.stack(
            [
                force_x.sum(axis=1) - mass * centre_x,
                force_y.sum(axis=1) - mass * centre_y,
                moment - inertia * alpha - mass * (c_x * centre_y - c_y * centre_x),
            ],
            axis=1,
        )


@dataclass(frozen=True, eq=False)
class PointLoad:
    """One force and couple on a body, at one of its points.

    source  "joint B" or "force cylinder"
    point   of the body; None for a torque that enters at no stated point
    force   (n, 2) N, moment (n,) N mm about the point: ground axes
    reach   (n, 2) mm from the point to where the force really acts, ground axes: along the line of
            a guide or slot it moves, elsewhere it is zero
    """

    source: str
    point: str | None
    force: FloatArray
    moment: FloatArray
    reach: FloatArray


def body_loads(
    kinematics: Kinematics,
    poses: FloatArray,
    joints: Mapping[str, JointLoad],
    efforts: Mapping[str, FloatArray],
    body: str,
) -> list[PointLoad]:
    """Return every joint and force load on a body (not weight and inertia), one by one."""
    loads = []
    zero, nowhere = np.zeros(len(poses)), np.zeros((len(poses), 2))
    for joint in kinematics.linkage.joints:
        load = joints[joint.name]
        moment = load.moment + load.friction_couple
        source = f"joint {joint.name!r}"
        if body == joint.body_b:
            loads.append(PointLoad(source, joint.point_b, load.force, moment, nowhere))
        elif body == joint.body_a:
            # the force of a guide acts under the slider, not at the guide's own point
            lever = nowhere
            if isinstance(joint, Prismatic | Slot):
                lever = kinematics.separation(poses, joint)
            about = -moment - cross(lever, load.force)
            loads.append(PointLoad(source, joint.point_a, -load.force, about, lever))
    for force in kinematics.linkage.forces:
        for point, direction, couple in _force_on(kinematics, poses, force, body):
            size = force.sign * efforts[force.name]
            loads.append(
                PointLoad(
                    f"force {force.name!r}",
                    point,
                    direction * size[:, None],
                    zero + couple * size,
                    nowhere,
                )
            )
    return loads


def _force_on(
    kinematics: Kinematics, poses: FloatArray, force: Force, body: str
) -> list[tuple[str | None, FloatArray, float]]:
    """Return point, direction (n, 2) and couple of a unit force on a body."""
    coordinate, none = force.coordinate, np.zeros((len(poses), 2))
    result: list[tuple[str | None, FloatArray, float]] = []
    if isinstance(coordinate, Distance):
        span = kinematics.span(poses, coordinate)
        along = span / np.sqrt(dot(span, span))[:, None]
        if coordinate.body_b == body:
            result.append((coordinate.point_b, along, 0.0))
        if coordinate.body_a == body:
            result.append((coordinate.point_a, -along, 0.0))
    elif isinstance(coordinate, Angle):
        if coordinate.body == body:
            result.append((coordinate.point, none, 1.0))
        if coordinate.relative_to == body:
            known = coordinate.point in kinematics.linkage.body(body).points
            result.append((coordinate.point if known else None, none, -1.0))
    elif coordinate.body == body:
        result.append((coordinate.point, none + kinematics.along(poses, coordinate), 0.0))
    return result
