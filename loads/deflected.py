"""Change of the forces of an elastic linkage when solved in its deflected, not its rigid, shape.

The joints' places are moved by the loads' deflections, all poses are solved again with the effort's
coordinate held, and the forces once more in that shape. The difference is the next term of a series
whose first term is the result; where it is not small, the first order does not hold (a softly held
knee folds, a leaf swings as far as its arm).
"""

from collections.abc import Mapping

import numpy as np

from loads.bodies import BoolArray, FloatArray
from loads.compliance import BeamCompliance, JointCompliance, MatrixCompliance
from loads.elasticity import Displacements, LoadState, beam_displacements, matrix_displacements
from loads.forces import ForceSolution, solve_forces
from loads.joints import Joint, Prismatic, Slot
from loads.kinematics import Kinematics, dot, rotated, turned_left, unit
from loads.loop_closure import closed_poses
from loads.motion import Motion


def second_order(motion: Motion, solution: ForceSolution, solve: str, touching: BoolArray) -> float:
    """Return the largest change of effort and reactions in the deflected shape, while touching.

    Each over the largest of its kind; infinite where the deflected linkage does not close.
    """
    if not touching.any() or not motion.kinematics.linkage.compliance:
        return 0.0
    kinematics = motion.kinematics
    linkage = kinematics.linkage
    shape = _deflected(motion, solution)
    effort = linkage.force(solve).coordinate
    values = kinematics.value(effort, motion.poses)
    poses, closed = closed_poses(shape, effort, values, motion.poses)
    if not closed[touching].all():
        return float("inf")
    poses[~closed] = motion.poses[~closed]
    moved = Motion(
        shape,
        motion.coordinate,
        motion.values,
        poses,
        motion.velocities,
        motion.accelerations,
        motion.heading,
    )
    given = {name: size for name, size in solution.efforts.items() if name != solve}
    again = solve_forces(moved, given, solve)
    changes = [_change(solution.efforts[solve], again.efforts[solve], touching)]
    largest = max(_size(load.force, touching) for load in solution.joints.values())
    for name, load in solution.joints.items():
        off = _size(again.joints[name].force - load.force, touching)
        changes.append(off / largest if largest else 0.0)
    return max(changes)


def _size(force: FloatArray, where: BoolArray) -> float:
    return float(np.hypot(force[:, 0], force[:, 1])[where].max(initial=0.0))


def _change(before: FloatArray, after: FloatArray, where: BoolArray) -> float:
    largest = float(np.abs(before[where]).max(initial=0.0))
    return float(np.abs(after - before)[where].max(initial=0.0)) / largest if largest else 0.0


def _deflected(motion: Motion, solution: ForceSolution) -> Kinematics:
    """Return the kinematics with every joint's places where the loads have moved them."""
    kinematics, poses = motion.kinematics, motion.poses
    state = LoadState(solution, motion)
    offsets = np.zeros((len(poses), kinematics.n_constraints))
    moved: dict[str, Displacements] = {}
    for compliance in kinematics.linkage.compliance:
        match compliance:
            case JointCompliance():
                _part(kinematics, poses, compliance, solution, offsets)
            case BeamCompliance():
                moved[compliance.body] = beam_displacements(kinematics, poses, compliance, state)
            case MatrixCompliance():
                moved[compliance.body] = matrix_displacements(kinematics, poses, compliance, state)
    joints = kinematics.linkage.joints
    ends_a = [
        _end(kinematics, poses, moved, joint, joint.body_a, joint.point_a) for joint in joints
    ]
    ends_b = [
        _end(kinematics, poses, moved, joint, joint.body_b, joint.point_b) for joint in joints
    ]
    lines = [
        rotated(unit(joint.direction), turn)
        for joint, (_, turn) in zip(joints, ends_a, strict=True)
        if isinstance(joint, Prismatic | Slot)
    ]
    places = [place for place, _ in (*ends_a, *ends_b)]
    return kinematics.displaced(np.stack([*places, *lines], axis=1), offsets)


def _part(
    kinematics: Kinematics,
    poses: FloatArray,
    compliance: JointCompliance,
    solution: ForceSolution,
    offsets: FloatArray,
) -> None:
    """Open a joint by its deflection under the force on body b: b goes where a pulls it back."""
    joint = kinematics.linkage.joint(compliance.joint)
    parting = -solution.joints[joint.name].force / compliance.stiffness
    row = kinematics.rows[joint.name].start
    if isinstance(joint, Prismatic | Slot):
        offsets[:, row] = dot(turned_left(kinematics.line(poses, joint)), parting)
    else:
        offsets[:, row : row + 2] = parting


def _end(
    kinematics: Kinematics,
    poses: FloatArray,
    moved: Mapping[str, Displacements],
    joint: Joint,
    body: str,
    point: str,
) -> tuple[FloatArray, FloatArray]:
    """Return where the end of a joint is in its deformed body (n, 2), and its turn (n,).

    The line of a slot goes through the moved place of its pin, turned with it.
    """
    own = np.broadcast_to(np.array(kinematics.linkage.body(body).place(point)), (len(poses), 2))
    if body not in moved:
        return own, np.zeros(len(poses))
    shift, turn, at = moved[body][f"joint {joint.name!r}"]
    return own + shift + turned_left(own - at) * turn[:, None], turn
