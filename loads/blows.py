"""Blows: the impulses in a linkage that meets a contact at a speed.

In the moment of a blow no position changes and no finite force has an impulse; so over the
coordinates of the bodies, with J the constraint Jacobian and g the gradient of the contact's
coordinate,

    M (v+ - v-) = J' reactions + g impulse,   J v+ = 0,   g v+ = -e g v-

(the equations of `loads/forces.py`, integrated over the moment; e is the speed of the contact's
coordinate after over its speed before). Within the motions that J leaves, the mass that the contact
meets is m = 1 / (g M^-1 g'), the impulse (1 + e) m v, and m v^2 (1 - e^2) / 2 of kinetic energy is
lost.

Springs push with finite forces: what gives way passes no impulse on. A joint that is elastic, or on
an elastic body, is open in that moment, and the blow stays with the bodies that are joined rigidly
to the one that is pushed. Friction of joints has no part in it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isinf

import numpy as np

from loads.bodies import GROUND, FloatArray
from loads.compliance import JointCompliance
from loads.joints import Coordinate, Joint, Prismatic, Revolute, Slot
from loads.kinematics import Kinematics, rotated, turned_left
from loads.linkage import Linkage

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
        arm = rotated(np.array(body.centre, dtype=float), poses[:, i + 1, 2])
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
