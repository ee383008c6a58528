"""Elastic deflections of a linkage to first order, by the principle of virtual forces.

The work of a system of forces in equilibrium (unit force at the place asked for, the effort that
is solved for as its support) on the deformations that the real loads cause is the deflection:
delta = sum over the elastic bodies and joints of unit loads . compliance . real loads
(Timoshenko and Young, Theory of Structures, ch. 6). Displacements are small against the linkage:
the forces stay those of the rigid geometry, an error of the order of the strain.

The change of the forces, when solved in the deflected shape, is computed beside: the joints' places
are moved by the loads' deflections, all poses are solved again with the effort's coordinate held,
and the forces once more in that shape. The difference is the next term of a series whose first term
is the result; where it is not small, the first order does not hold (a softly held knee folds, a
leaf swings as far as its arm).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from loads.bodies import (
    BeamCompliance,
    BoolArray,
    FloatArray,
    IntArray,
    Joint,
    JointCompliance,
    LinkageError,
    MatrixCompliance,
    Prismatic,
    Slot,
)
from loads.forces import ForceSolution, PointLoad, body_loads, solve_forces
from loads.kinematics import (
    Kinematics,
    acceleration_at,
    centre_arm,
    cross,
    dot,
    rotated,
    turned_left,
    unit,
)
from loads.linkage import Linkage
from loads.motion import Motion, closed_poses

_ASIDE = 1e-2  # of the size of the linkage: how far from its axis a beam may be loaded
_ON_POINT = 1e-6  # of a size: how far from a stated place a load may act
Displacements = dict[str, tuple[FloatArray, FloatArray, FloatArray]]


@dataclass(frozen=True, eq=False)
class LoadState:
    """Forces of a linkage at every position, and the motion whose inertia belongs to them.

    motion  None for a system of forces without mass
    """

    solution: ForceSolution
    motion: Motion | None


def check_compliance(linkage: Linkage) -> None:
    """Raise LinkageError where a compliance names a thing that does not exist, or is repeated."""
    seen: set[str] = set()
    for compliance in linkage.compliance:
        if isinstance(compliance, JointCompliance):
            linkage.joint(compliance.joint)
            name = f"joint {compliance.joint!r}"
        else:
            body = linkage.body(compliance.body)
            name = f"body {compliance.body!r}"
            if isinstance(compliance, MatrixCompliance):
                for point in compliance.points:
                    body.place(point)
                for line in compliance.slides:
                    _line(linkage, compliance.body, line)
        if name in seen:
            raise LinkageError(f"{name}: its compliance is stated twice")
        seen.add(name)


def deflection(
    kinematics: Kinematics, poses: FloatArray, unit: LoadState, real: LoadState
) -> FloatArray:
    """Return the work of the unit loads on the deformations of the real ones (n,) [N mm per N]."""
    total = np.zeros(len(poses))
    for compliance in kinematics.linkage.compliance:
        match compliance:
            case JointCompliance(joint=joint, stiffness=stiffness):
                ours, theirs = (state.solution.joints[joint].force for state in (unit, real))
                total += dot(ours, theirs) / stiffness
            case BeamCompliance():
                total += _beam(kinematics, poses, compliance, unit, real)
            case MatrixCompliance():
                ours, theirs = (
                    wrenches_on(kinematics, poses, compliance, state) for state in (unit, real)
                )
                total += np.einsum("ni,ij,nj->n", ours, compliance.matrix, theirs)
    return total


def _loads_on(
    kinematics: Kinematics, poses: FloatArray, state: LoadState, body: str
) -> list[PointLoad]:
    return body_loads(kinematics, poses, state.solution.joints, state.solution.efforts, body)


@dataclass(frozen=True, eq=False)
class _Entering:
    """One load where it enters a body that has a matrix.

    shares  (n, k) of the matrix's points and places along lines, each with three rows
    wrench  (n, 3) force x, y and couple, place (n, 2) mm where it acts: the body's axes
    """

    source: str
    shares: FloatArray
    wrench: FloatArray
    place: FloatArray


def _entering(
    kinematics: Kinematics, poses: FloatArray, compliance: MatrixCompliance, state: LoadState
) -> list[_Entering]:
    angle = poses[:, kinematics.index[compliance.body], 2]
    return [
        _enters(kinematics, compliance, load, angle)
        for load in _loads_on(kinematics, poses, state, compliance.body)
    ]


def _enters(
    kinematics: Kinematics, compliance: MatrixCompliance, load: PointLoad, angle: FloatArray
) -> _Entering:
    owner = kinematics.linkage.body(compliance.body)
    shares = np.zeros((len(angle), compliance.n_places))
    wrench = np.column_stack([rotated(load.force, -angle), load.moment])
    first = len(compliance.points)
    for name, places in compliance.slides.items():
        if load.source == f"joint {name!r}":
            joint = _line(kinematics.linkage, owner.name, name)
            along = unit(joint.direction)
            travel = rotated(load.reach, -angle) @ along
            shares[:, first : first + len(places)] = _shares(
                owner.name, load.source, places, travel
            )
            wrench[:, 2] -= cross(load.reach, load.force)
            place = np.array(owner.place(joint.point_a)) + travel[:, None] * along
            return _Entering(load.source, shares, wrench, place)
        first += len(places)
    if load.point not in compliance.points:
        raise LinkageError(
            f"body {compliance.body!r}: {load.source} acts at "
            f"{'no stated point' if load.point is None else f'point {load.point!r}'}, for "
            f"which its compliance has no rows (these are {', '.join(compliance.points)})"
        )
    if np.abs(load.reach).max(initial=0.0) > _ON_POINT * kinematics.size:
        raise LinkageError(
            f"body {compliance.body!r}: {load.source} slides along it, and its compliance has no "
            f"places along that line; it has point {load.point!r} only"
        )
    shares[:, compliance.points.index(load.point)] = 1.0
    place = np.broadcast_to(np.array(owner.place(load.point), dtype=float), (len(angle), 2))
    return _Entering(load.source, shares, wrench, place)


def _line(linkage: Linkage, body: str, name: str) -> Prismatic | Slot:
    """Return the slot or guide whose line a body has; LinkageError for any other joint."""
    joint = linkage.joint(name)
    if not isinstance(joint, Prismatic | Slot) or joint.body_a != body:
        raise LinkageError(
            f"body {body!r}: its compliance has places along joint {name!r}, which is no slot or "
            "guide on a line of this body"
        )
    return joint


def _shares(body: str, source: str, places: Sequence[float], travel: FloatArray) -> FloatArray:
    """Return each place's share (n, k) of a load at `travel`: two neighbours, linearly."""
    low, high = places[0], places[-1]
    slack = _ON_POINT * (high - low)
    outside = np.maximum(low - travel, travel - high)
    if outside.max(initial=0.0) > slack:
        worst = float(travel[int(np.argmax(outside))])
        raise LinkageError(
            f"body {body!r}: {source} acts at {worst:.7g} mm along its line, and the compliance is "
            f"known from {low:.7g} to {high:.7g} mm only"
        )
    return np.stack([np.interp(travel, places, row) for row in np.eye(len(places))], axis=1)


def wrenches_on(
    kinematics: Kinematics, poses: FloatArray, compliance: MatrixCompliance, state: LoadState
) -> FloatArray:
    """Return the loads on a body at the places of its compliance, in its own axes (n, 3 k)."""
    result = np.zeros((len(poses), compliance.n_places, 3))
    for load in _entering(kinematics, poses, compliance, state):
        result += load.shares[:, :, None] * load.wrench[:, None, :]
    return result.reshape(len(poses), -1)


def _beam(
    kinematics: Kinematics,
    poses: FloatArray,
    beam: BeamCompliance,
    unit: LoadState,
    real: LoadState,
) -> FloatArray:
    """Return the integral of M M' / E I + N N' / E A along a body's x axis (n,) [mm N]."""
    places, ours = beam_loads(kinematics, poses, beam.body, unit)
    _, theirs = beam_loads(kinematics, poses, beam.body, real)
    order = np.argsort(places, axis=1)
    lengths = np.diff(np.take_along_axis(places, order, axis=1), axis=1)
    (force, start, end), (other_force, other_start, other_end) = (
        section_forces(loads, order, lengths) for loads in (ours, theirs)
    )
    result = np.zeros(len(poses))
    if beam.bending is not None:
        products = (
            2.0 * start * other_start
            + start * other_end
            + end * other_start
            + 2.0 * end * other_end
        )
        result += np.sum(lengths * products, axis=1) / (6.0 * beam.bending)
    if beam.axial is not None:
        result += np.sum(lengths * force * other_force, axis=1) / beam.axial
    return result


def section_forces(
    loads: FloatArray, order: IntArray, lengths: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return normal force, and bending moment at both ends, of each stretch (n, k - 1).

    loads  (n, k, 3) along, across and couple, not yet in order
    """
    along, across, couple = (
        np.take_along_axis(loads[:, :, i], order, axis=1)[:, :-1] for i in range(3)
    )
    shear = np.cumsum(across, axis=1)
    normal = np.cumsum(along, axis=1)
    jumps = np.cumsum(couple, axis=1)
    grown = np.cumsum(shear * lengths, axis=1)
    end = grown - jumps
    start = end - shear * lengths
    return normal, start, end


def beam_loads(
    kinematics: Kinematics, poses: FloatArray, body: str, state: LoadState
) -> tuple[FloatArray, FloatArray]:
    """Return places along the body's x axis (n, k) and loads there (n, k, 3), its weight last.

    Weight and inertia act at the centre of mass, as a force and a couple.
    """
    row = kinematics.index[body]
    owner = kinematics.linkage.body(body)
    angle = poses[:, row, 2]
    places, loads = [], []
    for load in _loads_on(kinematics, poses, state, body):
        if load.point is None:
            raise LinkageError(
                f"body {body!r}: {load.source} enters at no stated point, and its bending needs one"
            )
        reach = rotated(load.reach, -angle)
        place = np.array(owner.place(load.point), dtype=float) + reach
        force = rotated(load.force, -angle)
        aside = float(np.abs(place[:, 1]).max())
        if aside > _ASIDE * kinematics.size:
            raise LinkageError(
                f"body {body!r}: {load.source} acts {aside:.4g} mm beside the axis that it bends "
                "along; a beam carries its loads on its x axis, state a matrix instead"
            )
        pure = load.moment - cross(load.reach, load.force)
        places.append(place[:, 0])
        loads.append(np.stack([force[:, 0], force[:, 1], pure - place[:, 1] * force[:, 0]], axis=1))
    x, y = owner.centre
    places.append(np.full(len(poses), x))
    weight = np.zeros((len(poses), 3))
    if state.motion is not None:
        own = state.motion.accelerations[:, row]
        arm = centre_arm(owner, poses[:, row])
        pull = acceleration_at(arm, state.motion.velocities[:, row], own)
        inertia = -owner.mass * rotated(pull - np.array(kinematics.linkage.gravity), -angle)
        weight[:, :2] = inertia
        weight[:, 2] = -owner.inertia * own[:, 2] - y * inertia[:, 0]
    loads.append(weight)
    return np.stack(places, axis=1), np.stack(loads, axis=1)


def beam_displacements(
    kinematics: Kinematics, poses: FloatArray, beam: BeamCompliance, state: LoadState
) -> Displacements:
    """Return the deflections of a beam under its loads, by source, against its leftmost load.

    Shift (n, 2) mm and turn (n,) in the body's axes, and the place along its axis (n, 2) mm that is
    moved. E I v'' = M and E A u' = -N, with M and N as `section_forces` has them.
    """
    places, loads = beam_loads(kinematics, poses, beam.body, state)
    order = np.argsort(places, axis=1)
    lengths = np.diff(np.take_along_axis(places, order, axis=1), axis=1)
    normal, start, end = section_forces(loads, order, lengths)
    n, k = places.shape
    along, across, turn = (np.zeros((n, k)) for _ in range(3))
    for i in range(k - 1):
        length = lengths[:, i]
        shortened = 0.0 if beam.axial is None else normal[:, i] * length / beam.axial
        bent = np.zeros(n) if beam.bending is None else length / beam.bending
        along[:, i + 1] = along[:, i] - shortened
        turn[:, i + 1] = turn[:, i] + bent * (start[:, i] + end[:, i]) / 2.0
        across[:, i + 1] = (
            across[:, i]
            + turn[:, i] * length
            + bent * length * (2.0 * start[:, i] + end[:, i]) / 6.0
        )
    back = np.argsort(order, axis=1)
    along, across, turn = (np.take_along_axis(each, back, axis=1) for each in (along, across, turn))
    result: Displacements = {}
    for i, load in enumerate(_loads_on(kinematics, poses, state, beam.body)):
        shift = np.stack([along[:, i], across[:, i]], axis=1)
        place = np.stack([places[:, i], np.zeros(n)], axis=1)
        result[load.source] = shift, turn[:, i], place
    return result


def matrix_displacements(
    kinematics: Kinematics, poses: FloatArray, compliance: MatrixCompliance, state: LoadState
) -> Displacements:
    """Return the deflections of a body under its loads, by source, as `beam_displacements`."""
    wrenches = wrenches_on(kinematics, poses, compliance, state)
    moved = (wrenches @ np.asarray(compliance.matrix, dtype=float)).reshape(len(poses), -1, 3)
    result: Displacements = {}
    for load in _entering(kinematics, poses, compliance, state):
        own = np.einsum("nk,nki->ni", load.shares, moved)
        result[load.source] = own[:, :2], own[:, 2], load.place
    return result


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
