"""Loads of a blow in a solved cycle: the transient of all bodies, put where the contact is met.

Modes of the elastic linkage with its drive held (`loads/vibration.py`) answer to the force of the
workpiece (`loads/blow_force.py`). A unit force of the contact, in equilibrium with the held drive,
deforms the linkage by s; its share in mode i, of deformations e_i of unit length, is a_i = e_i . s,
and the shape of the struck point is phi_i = omega_i a_i, as its static answer phi / omega^2 has the
energy a^2 / 2. What is left, s . s - sum a_i^2, yields without mass.

At every moment the bodies are in equilibrium with the force F and their inertia -M u'', where
u'' = sum of shapes times q'', q'' = phi F - omega^2 q: joint forces are those without the blow, and
what F and these inertia forces add, the drive held. Modes stay those of the touch; so does the
pose, but in a cycle that swings, where every moment has the pose of its nearest position.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from math import inf, isinf
from typing import Any

import numpy as np

from loads.blow_force import BlowForce, Course, Struck, blow_force
from loads.bodies import (
    GROUND,
    BoolArray,
    Coordinate,
    FloatArray,
    IntArray,
    Joint,
    JointCompliance,
    LinkageError,
    Prismatic,
    Revolute,
    Slot,
)
from loads.contact import Touch
from loads.cycle_loads import CycleLoads, OwnSwing
from loads.forces import JointLoad, unit_forces
from loads.kinematics import Kinematics, centre_arm, turned_left
from loads.linkage import Linkage
from loads.vibration import (
    LinkageModes,
    cycle_modes,
    grown,
    joint_strains,
    motion_at,
    motion_of,
    pushed_motion,
    with_body_loads,
)

_ROUND_OFF = 1e-9  # of a compliance
_SAME_POSE = 0.1  # of the struck point's rate over the pace's


@dataclass(frozen=True, eq=False)
class BlowLoads:
    """A blow in a cycle.

    row    of the cycle, at which the contact is met
    blow   its force
    loads  the cycle at the moments of the blow alone, its times since the cycle's start
    turned  relative change of the struck point's rate over the pace's, in the way that it presses;
            0 in a swing, whose pose turns on
    speed  mm/s at which it is met
    """

    row: int
    blow: BlowForce
    loads: CycleLoads
    turned: float
    speed: float


@dataclass(frozen=True, eq=False)
class Swinging:
    """A linkage that swings as its contact is met (`loads/swing.py`).

    time           s, in the cycle
    side           of the contact
    way            of the struck point towards the workpiece at a time of the cycle, as in `Course`
    strain, rates  (rows,) deformation of the linkage by the contact's force before, and its rate
    """

    time: float
    side: int
    way: Callable[[float], tuple[float, float, float]]
    strain: FloatArray
    rates: FloatArray

    def course(self, along: FloatArray, modal: FloatArray, rates: FloatArray) -> Course:
        """The course from the touch on, of modes that are where they are."""
        start = self.way(self.time)[0] - float(along @ modal)

        def at(time: float) -> tuple[float, float, float]:
            way, rate, change = self.way(self.time + time)
            return way - start, rate, change

        return Course(at, modal, rates)


def blow_loads(
    cycle: CycleLoads,
    elastic: CycleLoads,
    force: str,
    row: int,
    struck: Struck,
    damping: float,
    inertia: float = inf,
    swinging: Swinging | None = None,
) -> BlowLoads:
    """Return the blow of a contact that is met at a row of a cycle.

    elastic  the cycle of a linkage in which everything gives way that can
    inertia  t or t mm2 on the coordinate of the pace besides the bodies; infinite where the drive
             keeps its rate through the blow
    swinging  None: as if slowly; else the loads of both cycles are without the contact

    Raises LinkageError where nothing of the linkage is elastic, the blow cannot be followed, or the
    drive presses on against what does not yield.
    """
    modes = cycle_modes(elastic, np.array([row]))
    pushed = pushed_motion(modes, elastic.pace)
    (unit,) = unit_forces(pushed, [force], 1.0, modes.holder)
    strain = joint_strains(modes.kinematics, modes.motion.poses, unit, modes.lumps)[0]
    free = np.isfinite(modes.frequencies[0])
    omega = 2.0 * np.pi * modes.frequencies[0, free]
    shapes = modes.shapes[0][:, free]
    shares = modes.strains[0][:, free].T @ strain
    left = float(strain @ strain - shares @ shares)
    rate = float(cycle.rate(force)[row])
    side = -np.sign(rate) if swinging is None else swinging.side
    way = side * cycle.linkage.force(force).sign  # of the effort that the workpiece is
    along = way * omega * shares
    started = np.zeros((2, len(omega)))
    if swinging is not None:
        own = modes.strains[0][:, free].T
        started = np.array([own @ swinging.strain, own @ swinging.rates]) / omega
    holds = inf
    if not isinf(inertia):
        holds = _holds(cycle, force, row)
        omega, shapes, along, started = _with_free_drive(
            modes, elastic, omega, shapes, along, inertia, side * rate, started
        )
    course = None if swinging is None else swinging.course(along, *started)
    speed = abs(rate) if course is None else course.at(0.0)[1] - float(along @ course.rates)
    blow = blow_force(
        omega,
        along,
        left if left > _ROUND_OFF * float(strain @ strain) else 0.0,
        speed,
        struck,
        damping,
        holds,
        course,
    )
    if course is None and isinf(blow.contact) and blow.force[-1] < (1.0 - 1e-6) * struck.yields:
        raise LinkageError(
            "the drive keeps its rate and presses on, so that the force has no end; state its "
            "inertia (drive.flywheel, drive.motor) or the force at which the workpiece yields"
        )
    count = len(blow.times)
    times = blow.times + (cycle.times[row] if swinging is None else swinging.time)
    own = np.flatnonzero(cycle.phase_of == cycle.phase_of[row])
    rows = np.full(count, row) if swinging is None else _nearest(cycle.times, own, times)
    there = replace(
        modes.at(np.zeros(count, dtype=int)), motion=motion_at(motion_of(elastic), rows)
    )
    (unit,) = unit_forces(pushed_motion(there, elastic.pace), [force], 1.0, modes.holder)
    push = way * blow.force
    # elastic inertia forces M u'' of the modes, without and with the force itself
    answer = blow.modal * omega**2 - np.outer(blow.force, along)
    lumped = modes.lumps.masses * (answer @ shapes.T)
    still = at_rows(elastic, rows)
    moved = with_body_loads(there, still, lumped)
    reactions = {
        name: grown(load, unit.joints[name], push) for name, load in moved.reactions.items()
    }
    efforts = dict(moved.efforts)
    efforts[force] = efforts[force] + push
    efforts[modes.holder] = efforts[modes.holder] + unit.efforts[modes.holder] * push
    loads = replace(
        at_rows(cycle, rows),
        times=times,
        positions=np.interp(times, cycle.times[own], cycle.positions[own]),
        accelerations=moved.accelerations,
        reactions=reactions,
        efforts=efforts,
        own_swing=moved.own_swing,
        moments=np.ones(count, dtype=bool),
    )
    turned = _turned(cycle, force, row, blow.deepest) if swinging is None else 0.0
    return BlowLoads(row, blow, loads, turned, speed)


def _nearest(known: FloatArray, rows: IntArray, times: FloatArray) -> IntArray:
    """Which of some rows, at known times, are nearest to times."""
    middles = 0.5 * (known[rows[1:]] + known[rows[:-1]])
    return np.asarray(rows[np.searchsorted(middles, times)])


def _turned(cycle: CycleLoads, force: str, row: int, deepest: float) -> float:
    """Relative change of the contact's rate over the pace's, while it goes so far beyond a row."""
    own = np.flatnonzero(cycle.phase_of == cycle.phase_of[row])
    own = own[own >= row]
    way = np.abs(cycle.coordinate(force)[own] - cycle.coordinate(force)[row])
    slope = cycle.slope(force)[own]
    last = int(np.searchsorted(np.maximum.accumulate(way), deepest))
    there = np.interp(deepest, way[: last + 1], slope[: last + 1])
    return abs(float(there / slope[0]) - 1.0)


def _holds(cycle: CycleLoads, force: str, row: int) -> float:
    """Time from a row in which the contact's rate over the pace's stays within a tenth, s."""
    own = np.flatnonzero(cycle.phase_of == cycle.phase_of[row])
    own = own[own >= row]
    slope = cycle.slope(force)[own]
    left = np.flatnonzero(np.abs(slope / slope[0] - 1.0) > _SAME_POSE)
    last = own[left[0] - 1] if len(left) else own[-1]
    return float(cycle.times[last] - cycle.times[row])


def _with_free_drive(
    modes: LinkageModes,
    cycle: CycleLoads,
    omega: FloatArray,
    shapes: FloatArray,
    along: FloatArray,
    inertia: float,
    rate: float,
    started: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Frequencies, shapes of the lumps and of the struck point, where the drive is not held.

    And what the modes start with (2, k): places and rates.

    The rigid motion r of a unit rate of the pace joins the modes S of the held drive: masses
    [r' M r + I, r' M S; S' M r, 1] and stiffnesses diag(0, omega^2) have the free modes.
    rate  of the contact's coordinate in that motion, away from what is struck
    """
    from scipy.linalg import eigh

    motion = modes.motion
    gradient = motion.kinematics.gradient(cycle.pace, motion.poses)[0]
    pace = float(gradient @ motion.velocities[0].ravel())
    rigid = modes.lumps.rates(motion.velocities, motion.poses)[0] / pace
    weighted = modes.lumps.masses * rigid
    mass = np.eye(len(omega) + 1)
    mass[0, 0] = float(weighted @ rigid) + inertia
    mass[0, 1:] = mass[1:, 0] = weighted @ shapes
    squares, mix = eigh(np.diag(np.r_[0.0, omega**2]), mass)
    squares[0] = 0.0
    together = np.column_stack([rigid, shapes]) @ mix
    start = np.column_stack([np.zeros(2), started]) @ mass @ mix
    return np.sqrt(squares), together, np.r_[rate / pace, along] @ mix, start


def with_blow(cycle: CycleLoads, blow: BlowLoads) -> CycleLoads:
    """Return the cycle with the moments of a blow in place of its own positions in that time."""
    end = blow.loads.times[-1]
    after = np.arange(len(cycle.times)) > blow.row
    kept = np.flatnonzero(
        after & ((cycle.times > end) | (cycle.phase_of != blow.loads.phase_of[0]))
    )
    before = np.arange(blow.row + 1)
    still = {
        name: OwnSwing(np.broadcast_to(own.places[0], shape), np.zeros(shape))
        for name, own in blow.loads.own_swing.items()
        for shape in [(len(cycle.times), own.places.shape[1])]
    }
    cycle = replace(cycle, own_swing={**still, **cycle.own_swing})
    whole = joined([at_rows(cycle, before), blow.loads, at_rows(cycle, kept)])
    return replace(whole, unstruck=cycle.unstruck or cycle)


def moments_of_blows(cycle: CycleLoads) -> BoolArray:
    """Return which rows (n,) are moments of a blow."""
    none = np.zeros(len(cycle.times), dtype=bool)
    return none if cycle.moments is None else cycle.moments


def at_rows(cycle: CycleLoads, rows: IntArray) -> CycleLoads:
    """Return the cycle at some of its positions."""
    return _mapped([cycle], lambda arrays: arrays[0][rows])


def joined(parts: Sequence[CycleLoads]) -> CycleLoads:
    """Return stretches of one cycle, one after another."""
    return _mapped(parts, np.concatenate)


def _mapped(parts: Sequence[CycleLoads], change: Callable[[Sequence[Any]], Any]) -> CycleLoads:
    """Return the first cycle with every array over the positions made of those of all."""
    first = parts[0]

    def of(name: str) -> Any:
        return change([getattr(part, name) for part in parts])

    def over(owner: str, kind: type[Any]) -> dict[str, Any]:
        return {
            key: kind(
                *(
                    change([getattr(getattr(part, owner)[key], field.name) for part in parts])
                    for field in fields(kind)
                )
            )
            for key in getattr(first, owner)
        }

    changed: dict[str, Any] = {
        name: of(name)
        for name in ("positions", "times", "phase_of", "poses", "velocities", "accelerations",
                     "heading")
    }  # fmt: skip
    return replace(
        first,
        **changed,
        moments=change([moments_of_blows(part) for part in parts]),
        reactions=over("reactions", JointLoad),
        own_swing=over("own_swing", OwnSwing),
        efforts={key: change([part.efforts[key] for part in parts]) for key in first.efforts},
        touches=over("touches", Touch),
    )


# Blows: the impulses in a linkage that meets a contact at a speed.
#
# In the moment of a blow no position changes and no finite force has an impulse; so over the
# coordinates of the bodies, with J the constraint Jacobian and g the gradient of the contact's
# coordinate,
#
#     M (v+ - v-) = J' reactions + g impulse,   J v+ = 0,   g v+ = -e g v-
#
# (the equations of `loads/forces.py`, integrated over the moment; e is the speed of the contact's
# coordinate after over its speed before). Within the motions that J leaves, the mass that the
# contact meets is m = 1 / (g M^-1 g'), the impulse (1 + e) m v, and m v^2 (1 - e^2) / 2 of kinetic
# energy is lost.
#
# Springs push with finite forces: what gives way passes no impulse on. A joint that is elastic, or
# on an elastic body, is open in that moment, and the blow stays with the bodies that are joined
# rigidly to the one that is pushed. Friction of joints has no part in it.
_NONE = 1e-12  # of the largest: no mass, no share


@dataclass(frozen=True, eq=False)
class JointImpulse:
    """Impulse of a joint on its body b, in the ground's axes, in a blow without rebound.

    force   (2,)  N s
    couple  N mm s
    """

    force: FloatArray
    couple: float


@dataclass(frozen=True, eq=False)
class Blow:
    """A linkage meets a contact.

    force   of the contact
    speed   mm/s, of its coordinate towards the contact, before
    mass    t, that the contact meets; 0 where none has a share, infinite where a drive that holds
            its speed stands behind rigid bodies
    joints  impulses in a blow without rebound; (1 + e) times that with restitution e
    open    joints that are open in the moment, as something gives way there
    """

    force: str
    speed: float
    mass: float
    joints: Mapping[str, JointImpulse]
    open: tuple[str, ...]

    def impulse(self, restitution: float) -> float:
        """Impulse on the contact, N s."""
        return (1.0 + restitution) * self.mass * self.speed

    def energy(self, restitution: float) -> float:
        """Kinetic energy that is lost, N mm."""
        left = 1.0 - restitution**2
        return 0.5 * left * self.mass * self.speed**2 if left else 0.0


def blow(
    linkage: Linkage,
    force: str,
    pose: FloatArray,
    rates: FloatArray,
    driven: Coordinate | None = None,
    inertia: float = 0.0,
    *,
    rigid: bool = False,
) -> Blow:
    """Return the blow of a contact in one position.

    pose, rates  (bodies, 3), before the blow; the ground first
    driven       coordinate with an inertia besides the bodies' own: t or t mm2, infinite where it
                 keeps its rate
    rigid        True as if nothing gave way
    """
    kinematics, poses = Kinematics(linkage), pose[None]
    coordinate = linkage.force(force).coordinate
    open_ = () if rigid else _open_joints(linkage)
    rows, own = _struck(linkage, kinematics, coordinate, open_)
    scale = kinematics.pose_scale
    gradient = _own(kinematics.gradient(coordinate, poses)[0, 3:] * scale, own)
    jacobian = kinematics.joints_jacobian(poses)[0][rows][:, own]
    mass = mass_matrix(kinematics, poses)[0][np.ix_(own, own)] * np.outer(scale[own], scale[own])
    if driven is not None and inertia > 0.0:
        lead = _own(kinematics.gradient(driven, poses)[0, 3:] * scale, own)
        if not isinf(inertia):
            mass = mass + inertia * np.outer(lead, lead)
        elif lead.any():
            jacobian = np.vstack([jacobian, lead / np.abs(lead).max()])
    rate = float(gradient @ (rates.reshape(-1)[3:] / scale)[own])
    sense = -1.0 if rate > 0.0 else 1.0
    met, change = _response(mass, jacobian, sense * gradient)
    if not 0.0 < met < inf:
        return Blow(force, abs(rate), met, {}, open_)
    impulse = met * abs(rate)
    left = impulse * (mass @ change - sense * gradient)
    reactions = np.zeros(kinematics.n_constraints)
    solution = np.linalg.lstsq(jacobian.T, left, rcond=None)[0][: len(rows)]
    reactions[rows] = solution / kinematics.row_scale[rows]
    joints = {
        joint.name: _unpacked(kinematics, poses, joint, reactions[kinematics.rows[joint.name]])
        for joint in linkage.joints
    }
    return Blow(force, abs(rate), met, joints, open_)


def _response(mass: FloatArray, jacobian: FloatArray, push: FloatArray) -> tuple[float, FloatArray]:
    """Return the mass that a push meets, and the change of rates by its unit impulse.

    Within the motions that the constraints leave. A motion without mass that it can push leaves
    nothing to meet (0); no motion at all is infinite.
    """
    _, sizes, right = np.linalg.svd(jacobian, full_matrices=True)
    free = right[int((sizes > _NONE * sizes.max(initial=1.0)).sum()) :].T
    nothing = np.zeros(len(push))
    along = free.T @ push
    if not np.abs(along).max(initial=0.0) > _NONE * np.abs(push).max():
        return inf, nothing
    values, modes = np.linalg.eigh(free.T @ mass @ free)
    shares = modes.T @ along
    heavy = values > _NONE * values.max()
    if not heavy.any() or np.abs(shares[~heavy]).max(initial=0.0) > 1e-6 * np.abs(shares).max():
        return 0.0, nothing
    change = free @ (modes[:, heavy] @ (shares[heavy] / values[heavy]))
    return 1.0 / float(push @ change), change


def _open_joints(linkage: Linkage) -> tuple[str, ...]:
    """Joints that are elastic, or on an elastic body."""
    joints, bodies = set(), set()
    for compliance in linkage.compliance:
        if isinstance(compliance, JointCompliance):
            joints.add(compliance.joint)
        else:
            bodies.add(compliance.body)
    return tuple(
        joint.name
        for joint in linkage.joints
        if joint.name in joints or {joint.body_a, joint.body_b} & bodies
    )


def _struck(
    linkage: Linkage, kinematics: Kinematics, coordinate: Coordinate, open_: Sequence[str]
) -> tuple[list[int], list[int]]:
    """Constraints of closed joints, and coordinates of the bodies that the blow reaches."""
    reached = [body for body in coordinate.bodies if body != GROUND]
    closed = [joint for joint in linkage.joints if joint.name not in open_]
    for body in reached:
        for joint in closed:
            ends = (joint.body_a, joint.body_b)
            if body in ends:
                reached += [end for end in ends if end != GROUND and end not in reached]
    rows = [
        row
        for joint in closed
        for row in range(kinematics.n_constraints)[kinematics.rows[joint.name]]
    ]
    numbers = sorted(kinematics.index[body] - 1 for body in reached)
    return rows, [3 * number + i for number in numbers for i in range(3)]


def _own(vector: FloatArray, own: Sequence[int]) -> FloatArray:
    return np.asarray(vector[own])


def mass_matrix(kinematics: Kinematics, poses: FloatArray) -> FloatArray:
    """Mass matrix (n, 3 moving, 3 moving) over the bodies' frames' x, y [mm] and angle [rad]."""
    bodies = kinematics.linkage.moving
    result = np.zeros((len(poses), 3 * len(bodies), 3 * len(bodies)))
    for i, body in enumerate(bodies):
        arm = centre_arm(body, poses[:, i + 1])
        # velocity of the centre over the rates
        centre = np.zeros((len(poses), 2, 3))
        centre[:, 0, 0] = centre[:, 1, 1] = 1.0
        centre[:, :, 2] = turned_left(arm)
        own = slice(3 * i, 3 * i + 3)
        result[:, own, own] = body.mass * np.swapaxes(centre, 1, 2) @ centre
        result[:, 3 * i + 2, 3 * i + 2] += body.inertia
    return result


def _unpacked(
    kinematics: Kinematics, poses: FloatArray, joint: Joint, part: FloatArray
) -> JointImpulse:
    if isinstance(joint, Prismatic | Slot):
        along = kinematics.line(poses, joint)[0]
        couple = float(part[1]) if isinstance(joint, Prismatic) else 0.0
        return JointImpulse(turned_left(along) * part[0], couple)
    return JointImpulse(part[:2], 0.0 if isinstance(joint, Revolute) else float(part[2]))
