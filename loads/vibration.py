"""Natural frequencies of an elastic linkage that is held at its drive.

A held linkage is statically determinate: unit loads on its masses give joint forces by equilibrium
alone, these deform bodies and joints, and by virtual forces (Timoshenko and Young, Theory of
Structures, ch. 6) the displacements of the masses are u = F f with F = S' S, where S are the
deformations of unit loads (`loads.vibration`). Free vibration has f = omega^2 M u, so that
1/omega^2 are the eigenvalues of sqrt(M) F sqrt(M) (Clough and Penzien, Dynamics of Structures,
ch. 11): the squared singular values of S sqrt(M). All of them are found; none can be skipped.

S is the deformation as a list of numbers whose squares add up to the elastic energy: of loads in
equilibrium every joint, beam and matrix gives rows s = sqrt(C) w, so that the work of one system of
loads on the deformations of another is s . s' (`loads.elasticity.deflection`).

Lumped mass of a linkage that vibrates: points on its beams, one place on every other body.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from loads.bodies import (
    Angle,
    BeamCompliance,
    Body,
    Coordinate,
    FloatArray,
    Force,
    IntArray,
    JointCompliance,
    LinkageError,
    MatrixCompliance,
    PointCoordinate,
    shared_pins,
)
from loads.cycle_loads import CycleLoads, OwnSwing
from loads.elasticity import LoadState, beam_loads, section_forces, wrenches_on
from loads.forces import ForceSolution, JointLoad, unit_forces
from loads.kinematics import Kinematics, rotated, turned_left
from loads.linkage import Linkage
from loads.motion import Motion, coordinate_share

_POINTS = 5  # along a beam; the first mode between two pins is then 0.02 % off
_GAUSS = 0.5 / np.sqrt(3.0)  # two points integrate the product of two linear moments exactly
_ROUNDING = 1e-6  # of the largest eigenvalue of a compliance: what may be below zero
_NO_MASS = 1e-12  # of a body's mass: what a lump may be beside zero
_STIFF = 1e-8  # of the softest mode's root: stiffer ones are rigid but for rounding
_PUSH = ("push x", "push y", "turn")  # forces put on bodies to find what unit loads do


@dataclass(frozen=True, eq=False)
class Lumps:
    """Ways in which mass can move, d in all: of a place along its body's x or y, or its turn.

    bodies  (d,)    rows of their bodies in poses
    way     (d,)    0 along x, 1 along y of the body, 2 turning
    places  (d, 2)  mm, in the body's frame
    arms    (d, 2)  mm, from the body's centre of mass
    masses  (d,)    tonne, of a turn tonne mm2: all above 0
    """

    bodies: IntArray
    way: IntArray
    places: FloatArray
    arms: FloatArray
    masses: FloatArray

    def of(self, row: int) -> IntArray:
        """Return which of them belong to a body."""
        return np.flatnonzero(self.bodies == row)

    def wrenches(self, angles: FloatArray) -> FloatArray:
        """Return the force and couple of unit loads at their body's centre (n, 3, d), ground axes.

        angles  (n, bodies) rad
        """
        along = np.eye(3)[self.way][:, :2]
        result = np.zeros((len(angles), 3, len(self.way)))
        result[:, :2] = np.swapaxes(rotated(along[None], angles[:, self.bodies]), 1, 2)
        turning = self.arms[:, 0] * along[:, 1] - self.arms[:, 1] * along[:, 0]
        result[:, 2] = np.where(self.way == 2, 1.0, turning)
        return result

    def rates(self, velocities: FloatArray, poses: FloatArray) -> FloatArray:
        """Return the rates (n, d) of all lumps, along their ways, for rates of the bodies."""
        angles = poses[:, self.bodies, 2]
        spin = velocities[:, self.bodies, 2]
        places = rotated(self.places[None], angles)
        speed = velocities[:, self.bodies, :2] + spin[..., None] * turned_left(places)
        own = rotated(speed, -angles)
        return np.where(self.way == 0, own[..., 0], np.where(self.way == 1, own[..., 1], spin))

    def inertia_loads(self, motion: Motion) -> FloatArray:
        """Return weight and inertia of a motion on every lump (n, d): N, and N mm on turns."""
        gravity = np.array(motion.kinematics.linkage.gravity, dtype=float)
        angles = motion.poses[:, self.bodies, 2]
        places = rotated(self.places[None], angles)
        spin, turn = motion.velocities[:, self.bodies, 2], motion.accelerations[:, self.bodies, 2]
        pull = (
            motion.accelerations[:, self.bodies, :2]
            + turn[..., None] * turned_left(places)
            - (spin**2)[..., None] * places
            - gravity
        )
        own = rotated(pull, -angles)
        each = np.where(self.way == 0, own[..., 0], np.where(self.way == 1, own[..., 1], turn))
        return np.asarray(-self.masses * each)

    def body_motions(self, shapes: FloatArray, poses: FloatArray) -> FloatArray:
        """Return the mean motion of every body (n, bodies, 3, k) for shapes (n, d, k).

        Of its centre of mass in ground axes and its turn: as a rigid body that has the same
        momentum; rates, accelerations or displacements alike.
        """
        n, _, k = shapes.shape
        result = np.zeros((n, poses.shape[1], 3, k))
        wrenches = self.wrenches(poses[:, :, 2])
        for row in np.unique(self.bodies):
            own = self.of(row)
            momentum = wrenches[:, :, own] @ (self.masses[own, None] * shapes[:, own])
            result[:, row, :2] = momentum[:, :2] / (self.masses[own] @ (self.way[own] == 0) or 1.0)
            spread = self.arms[own, 0] * (self.way[own] == 1) - self.arms[own, 1] * (
                self.way[own] == 0
            )
            inertia = float(self.masses[own] @ np.where(self.way[own] == 2, 1.0, spread**2))
            result[:, row, 2] = momentum[:, 2] / (inertia or 1.0)
        return result


@dataclass(frozen=True, eq=False)
class LinkageModes:
    """All natural modes of a held linkage at every position, softest first.

    frequencies    (n, k)        Hz; infinite where fewer than k ways can deform
    shapes         (n, d, k)     motion of the lumps, mass-normalised: 1/sqrt(tonne), in body axes
    strains        (n, rows, k)  orthonormal: deformations of the modes
    unit_strains   (n, rows, d)  deformations under unit loads on the lumps, the drive held
    holder         name of the force along the held coordinate, in `kinematics.linkage`
    """

    kinematics: Kinematics
    motion: Motion
    lumps: Lumps
    holder: str
    frequencies: FloatArray
    shapes: FloatArray
    strains: FloatArray
    unit_strains: FloatArray

    @property
    def displacements(self) -> FloatArray:
        """Mean motion of every body in its modes (n, bodies, 3, k): 1/sqrt(tonne), turn over mm.

        Of its centre of mass in ground axes, and its turn.
        """
        return self.lumps.body_motions(self.shapes, self.motion.poses)

    def at(self, positions: IntArray) -> "LinkageModes":
        """Return the modes at some of the positions."""
        return replace(
            self,
            motion=motion_at(self.motion, positions),
            frequencies=self.frequencies[positions],
            shapes=self.shapes[positions],
            strains=self.strains[positions],
            unit_strains=self.unit_strains[positions],
        )


def linkage_modes(motion: Motion, hold: Coordinate, solved: Sequence[str] = ()) -> LinkageModes:
    """Return all modes of a linkage with a coordinate held, at every position of a motion.

    solved  forces that drive it, of which the one along `hold` holds

    Only poses and the way of the motion count, not its speed; friction and weight do not.
    Raises LinkageError for a linkage without elasticity or mass, and at a dead centre of `hold`.
    """
    bare, holder = _held(motion.kinematics.linkage, hold, solved)
    if not bare.compliance:
        raise LinkageError("nothing of the linkage is elastic: it has no natural frequencies")
    lumps = lumps_of(bare)
    if not len(lumps.masses):
        raise LinkageError("no body of the linkage has mass: it has no natural frequencies")
    kinematics = Kinematics(bare)
    pushed = _rebased(motion, Kinematics(_pushed(bare)), hold)
    pushes = _unit_pushes(pushed, lumps, holder)
    poses = motion.poses
    wrenches = lumps.wrenches(poses[:, :, 2])
    strains: FloatArray | None = None
    for row, body in enumerate(bare.moving, start=1):
        own = lumps.of(row)
        if not len(own):
            continue
        for k, what in enumerate(_PUSH):
            solution = pushes[_name(body.name, what)]
            if strains is None:
                strains = lump_strains(kinematics, poses, solution, lumps)
            found = joint_strains(kinematics, poses, solution, lumps)
            strains[:, :, own] += found[:, :, None] * wrenches[:, None, k, own]
    assert strains is not None
    weighted = strains * np.sqrt(lumps.masses)
    left, sizes, right = np.linalg.svd(weighted, full_matrices=False)
    soft = sizes > _STIFF * sizes[:, :1]
    frequencies = np.full(sizes.shape, np.inf)
    frequencies[soft] = 1.0 / (2.0 * np.pi * sizes[soft])
    shapes = np.swapaxes(right, 1, 2) / np.sqrt(lumps.masses)[:, None]
    return LinkageModes(kinematics, motion, lumps, holder, frequencies, shapes, left, strains)


def cycle_modes(cycle: CycleLoads, positions: IntArray | None = None) -> LinkageModes:
    """Return the modes at some positions of a solved cycle, or all of them, its pace held."""
    motion = motion_of(cycle)
    some = motion if positions is None else motion_at(motion, positions)
    return linkage_modes(some, cycle.pace, cycle.solved)


def motion_of(cycle: CycleLoads) -> Motion:
    """Return the motion of a solved cycle, by the coordinate of its pace."""
    kinematics = Kinematics(cycle.linkage)
    return Motion(
        kinematics,
        cycle.pace,
        kinematics.value(cycle.pace, cycle.poses),
        cycle.poses,
        cycle.velocities,
        cycle.accelerations,
        cycle.heading,
    )


def load_strains(modes: LinkageModes, cycle: CycleLoads) -> FloatArray:
    """Return the deformations (n, rows) of the loads of a cycle at the positions of its modes.

    Weight and inertia of beams act where their lumps are.
    """
    efforts = {modes.holder: np.zeros(len(cycle.positions)), **cycle.efforts}
    solution = ForceSolution(cycle.reactions, efforts, np.zeros((len(cycle.positions), 0)))
    acting = modes.lumps.inertia_loads(modes.motion)
    # what a lump's load does where it enters; what it does to the joints is in the solution
    direct = lump_strains(modes.kinematics, cycle.poses, solution, modes.lumps)
    result: FloatArray = joint_strains(modes.kinematics, cycle.poses, solution, modes.lumps)
    result += np.einsum("nrd,nd->nr", direct, acting)
    return result


def followed(modes: LinkageModes, count: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return which mode at each position continues each of the first `count` of the first one.

    Returns their columns (n, count), signs (n, count), and the sign (count,) with which each comes
    back at the last position, if that is the first one again: 1, -1, or 0 for another mode or none.
    Of two neighbouring positions those modes belong together that move most of the mass alike.
    """
    weighted = modes.shapes * np.sqrt(modes.lumps.masses)[:, None]
    n = len(weighted)
    columns, signs = np.zeros((n, count), dtype=int), np.ones((n, count))
    columns[0] = np.arange(count)
    for i in range(1, n):
        before = weighted[i - 1][:, columns[i - 1]]
        overlap = before.T @ weighted[i]
        columns[i] = _most_alike(np.abs(overlap))
        alike = overlap[np.arange(count), columns[i]]
        signs[i] = signs[i - 1] * np.where(alike < 0.0, -1.0, 1.0)
    last = weighted[-1][:, columns[-1]] * signs[-1]
    back = np.einsum("dk,dk->k", weighted[0][:, :count], last)
    return columns, signs, np.where(np.abs(back) > 0.5, np.sign(back), 0.0)


def _most_alike(overlap: FloatArray) -> IntArray:
    """Return the columns (k,), each taken once, that give the largest sum of (k, n) overlaps."""
    best: IntArray = overlap.argmax(axis=1)
    if len(np.unique(best)) == len(best):  # no sum can be larger than that of all rows' largest
        return best
    from scipy.optimize import linear_sum_assignment

    return np.asarray(linear_sum_assignment(overlap, maximize=True)[1])


def closes(cycle: CycleLoads) -> bool:
    """Return True if a cycle ends in the pose that it starts in, and so can run again and again."""
    gap = cycle.poses[-1] - cycle.poses[0]
    gap[:, 2] = np.remainder(gap[:, 2] + np.pi, 2.0 * np.pi) - np.pi
    size = Kinematics(cycle.linkage).size
    widest: float = np.abs(gap / np.array([size, size, 1.0])).max()
    return bool(widest < 1e-6)


def with_body_loads(modes: LinkageModes, cycle: CycleLoads, lumped: FloatArray) -> CycleLoads:
    """Return the cycle with further loads on its lumps (n, d), the drive held.

    They are added as inertia: to the joints and the drive's effort what they cause there, to every
    body the acceleration that has their resultant, so that each stays in equilibrium, and to a beam
    what they are beyond the inertia of that acceleration.
    Raises LinkageError where no force of the linkage is the drive's.
    """
    if modes.holder not in cycle.efforts:
        raise LinkageError(
            f"no force acts along {cycle.pace.label}, which sets the pace: what drives the linkage "
            "is not known, so what vibration adds to it has no place; let a force set the pace"
        )
    linkage = cycle.linkage
    pushed = pushed_motion(modes, cycle.pace)
    pushes = _unit_pushes(pushed, modes.lumps, modes.holder)
    wrenches = modes.lumps.wrenches(cycle.poses[:, :, 2])
    reactions = dict(cycle.reactions)
    efforts = dict(cycle.efforts)
    accelerations, own_swing = cycle.accelerations.copy(), dict(cycle.own_swing)
    for row, body in enumerate(linkage.moving, start=1):
        own = modes.lumps.of(row)
        if not len(own):
            continue
        if (modes.lumps.way[own] == 1).sum() > 1:
            own_swing[body.name] = _own_swing(modes.lumps, row, lumped, own_swing.get(body.name))
        total = np.einsum("nkd,nd->nk", wrenches[:, :, own], lumped[:, own])
        turn = -total[:, 2] / body.inertia if body.inertia else np.zeros(len(total))
        arm = rotated(np.array(body.centre, dtype=float), cycle.poses[:, row, 2])
        shift = -total[:, :2] / body.mass if body.mass else np.zeros((len(total), 2))
        accelerations[:, row, :2] += shift - turn[:, None] * turned_left(arm)
        accelerations[:, row, 2] += turn
        for k, what in enumerate(_PUSH):
            solution = pushes[_name(body.name, what)]
            efforts[modes.holder] = (
                efforts[modes.holder] + solution.efforts[modes.holder] * total[:, k]
            )
            reactions = {
                name: grown(load, solution.joints[name], total[:, k])
                for name, load in reactions.items()
            }
    return replace(
        cycle,
        accelerations=accelerations,
        reactions=reactions,
        efforts=efforts,
        own_swing=own_swing,
    )


def _own_swing(lumps: Lumps, row: int, lumped: FloatArray, known: OwnSwing | None) -> OwnSwing:
    """Loads on the lumps of a beam across it, less their share of a rigid motion."""
    own = lumps.of(row)
    own = own[lumps.way[own] == 1]
    mass, arms, across = lumps.masses[own], lumps.arms[own, 0], lumped[:, own]
    shift = across.sum(axis=1) / mass.sum()
    turn = across @ arms / (mass @ arms**2)
    across = across - mass * (shift[:, None] + turn[:, None] * arms)
    if known is not None:
        across = across + known.across
    return OwnSwing(np.broadcast_to(lumps.places[own, 0], across.shape), across)


def pushed_motion(modes: LinkageModes, hold: Coordinate) -> Motion:
    """Return the motion of the modes for a linkage with forces on the centres of all bodies."""
    return _rebased(modes.motion, Kinematics(_pushed(modes.kinematics.linkage)), hold)


def grown(load: JointLoad, unit: JointLoad, size: FloatArray) -> JointLoad:
    """Return a joint's load with a number (n,) of unit loads added."""
    return replace(
        load, force=load.force + unit.force * size[:, None], moment=load.moment + unit.moment * size
    )


def _held(linkage: Linkage, hold: Coordinate, solved: Sequence[str]) -> tuple[Linkage, str]:
    """Return the linkage without friction, and the name of a force along the held coordinate.

    An angle that no torque drives is held at the pin about which its body turns (`_pivot`).
    """
    linkage.check_coordinate(hold, "held coordinate")
    bare = replace(linkage, friction={})
    driver = linkage.driver(hold, solved)
    if driver is not None:
        return bare, driver
    if isinstance(hold, Angle) and hold.point is None:
        hold = replace(hold, point=_pivot(linkage, hold))
    name = f"hold {hold.label}"
    return replace(bare, forces=(*bare.forces, Force(name, hold))), name


def _pivot(linkage: Linkage, angle: Angle) -> str | None:
    """Return the pin between the bodies of an angle, or else that nearest its body's origin."""
    pins = {}
    for joints in shared_pins(linkage.joints):
        bodies = {body for joint in joints for body in (joint.body_a, joint.body_b)}
        if angle.body in bodies:
            pins[joints[0].point] = angle.relative_to in bodies
    body = linkage.body(angle.body)
    return min(
        pins, key=lambda point: (not pins[point], hypot(*body.place(point)), point), default=None
    )


def _name(body: str, what: str) -> str:
    return f"{what} of {body}"


def _pushed(linkage: Linkage) -> Linkage:
    """Return the linkage with forces on the centre of mass of every body."""
    bodies, forces = [], list(linkage.forces)
    for body in linkage.bodies:
        if body not in linkage.moving:
            bodies.append(body)
            continue
        centre = "centre of mass"
        bodies.append(replace(body, points={**body.points, centre: body.centre}))
        ways: tuple[Coordinate, ...] = (
            PointCoordinate(body.name, centre, (1.0, 0.0)),
            PointCoordinate(body.name, centre, (0.0, 1.0)),
            Angle(body.name),
        )
        forces += [
            Force(_name(body.name, what), way) for what, way in zip(_PUSH, ways, strict=True)
        ]
    return replace(linkage, bodies=tuple(bodies), forces=tuple(forces))


def _unit_pushes(pushed: Motion, lumps: Lumps, holder: str) -> dict[str, ForceSolution]:
    """Return the forces of each push alone of the bodies that have lumps, by its name."""
    moving = pushed.kinematics.linkage.moving
    bodies = [body.name for row, body in enumerate(moving, start=1) if len(lumps.of(row))]
    names = [_name(body, what) for body in bodies for what in _PUSH]
    return dict(zip(names, unit_forces(pushed, names, 1.0, holder), strict=True))


def _rebased(motion: Motion, kinematics: Kinematics, hold: Coordinate) -> Motion:
    """Return the motion for another linkage of the same bodies, all along the held coordinate."""
    share = coordinate_share(kinematics, hold, motion.poses, motion.heading)
    heading = motion.heading * np.where(share < 0.0, -1.0, 1.0)[:, None, None]
    return replace(motion, kinematics=kinematics, heading=heading)


def motion_at(motion: Motion, positions: IntArray) -> Motion:
    """Return a motion at some of its positions."""
    return replace(
        motion,
        values=motion.values[positions],
        poses=motion.poses[positions],
        velocities=motion.velocities[positions],
        accelerations=motion.accelerations[positions],
        heading=motion.heading[positions],
    )


def joint_strains(
    kinematics: Kinematics, poses: FloatArray, solution: ForceSolution, lumps: Lumps
) -> FloatArray:
    """Return the rows (n, rows) of joints and forces, without loads on the lumps."""
    state = LoadState(solution, None)
    parts = []
    for compliance in kinematics.linkage.compliance:
        match compliance:
            case JointCompliance(joint=joint, stiffness=stiffness):
                parts.append(solution.joints[joint].force / np.sqrt(stiffness))
            case MatrixCompliance():
                parts.append(wrenches_on(kinematics, poses, compliance, state) @ _root(compliance))
            case BeamCompliance():
                places, loads = _on_beam(kinematics, poses, compliance, state, lumps)
                parts.append(_beam_rows(compliance, places, loads))
    return np.concatenate(parts, axis=1)


def lump_strains(
    kinematics: Kinematics, poses: FloatArray, solution: ForceSolution, lumps: Lumps
) -> FloatArray:
    """Return the rows (n, rows, d) of unit loads on the lumps alone, where they enter a beam.

    Of a body with a matrix, inertia is spread as its mass; that is in the matrix already.
    solution  any, for where the loads of beams are
    """
    state = LoadState(solution, None)
    parts = []
    for compliance in kinematics.linkage.compliance:
        match compliance:
            case JointCompliance():
                parts.append(np.zeros((len(poses), 2, len(lumps.way))))
            case MatrixCompliance():
                rows = 3 * compliance.n_places
                parts.append(np.zeros((len(poses), rows, len(lumps.way))))
            case BeamCompliance():
                places, loads = _on_beam(kinematics, poses, compliance, state, lumps)
                own = lumps.of(kinematics.index[compliance.body])
                rows = _n_rows(compliance, places.shape[1])
                part = np.zeros((len(poses), rows, len(lumps.way)))  # other bodies' lumps: none
                for at, d in enumerate(own, start=loads.shape[1] - len(own)):
                    acting = np.zeros_like(loads)
                    acting[:, at, lumps.way[d]] = 1.0
                    if lumps.way[d] == 0:  # a force along x beside the axis
                        acting[:, at, 2] = -lumps.places[d, 1]
                    part[:, :, d] = _beam_rows(compliance, places, acting)
                parts.append(part)
    return np.concatenate(parts, axis=1)


def _root(compliance: MatrixCompliance) -> FloatArray:
    """Return the matrix (m, m) that makes rows of wrenches."""
    matrix = np.asarray(compliance.matrix, dtype=float)
    sizes, vectors = np.linalg.eigh((matrix + matrix.T) / 2.0)
    # lengths and angles differ by orders: a negative value counts against the largest
    if sizes[0] < -_ROUNDING * sizes[-1]:
        raise LinkageError(
            f"body {compliance.body!r}: its compliance gives energy back for some loads (lowest "
            f"eigenvalue {sizes[0]:.3g}, highest {sizes[-1]:.3g}); it cannot vibrate"
        )
    return np.asarray(vectors * np.sqrt(np.maximum(sizes, 0.0)))


def _on_beam(
    kinematics: Kinematics,
    poses: FloatArray,
    beam: BeamCompliance,
    state: LoadState,
    lumps: Lumps,
) -> tuple[FloatArray, FloatArray]:
    """Return places (n, k) and loads (n, k, 3) on a beam: joints and forces, then its lumps."""
    places, loads = beam_loads(kinematics, poses, beam.body, state)
    own = lumps.of(kinematics.index[beam.body])
    at = np.broadcast_to(lumps.places[own, 0], (len(poses), len(own)))
    none = np.zeros((len(poses), len(own), 3))
    return (
        np.concatenate([places[:, :-1], at], axis=1),  # without the weight at the centre of mass
        np.concatenate([loads[:, :-1], none], axis=1),
    )


def _n_rows(beam: BeamCompliance, n_places: int) -> int:
    """Number of rows of `_beam_rows` for a number of loads."""
    return (n_places - 1) * (2 * (beam.bending is not None) + (beam.axial is not None))


def _beam_rows(beam: BeamCompliance, places: FloatArray, loads: FloatArray) -> FloatArray:
    """Return two rows of bending and one of stretching for every stretch between two loads."""
    order = np.argsort(places, axis=1, kind="stable")
    lengths = np.diff(np.take_along_axis(places, order, axis=1), axis=1)
    normal, start, end = section_forces(loads, order, lengths)
    rows = []
    if beam.bending is not None:
        weight = np.sqrt(lengths / (2.0 * beam.bending))
        middle, rise = (start + end) / 2.0, end - start
        rows += [weight * (middle - _GAUSS * rise), weight * (middle + _GAUSS * rise)]
    if beam.axial is not None:
        rows.append(np.sqrt(lengths / beam.axial) * normal)
    return np.concatenate(rows, axis=1)


def lumps_of(linkage: Linkage) -> Lumps:
    """Return the lumps of a linkage; mass, centre and inertia of every body are kept.

    A beam has the mass of an even bar in Gauss points along its x axis, and of lumps at its
    outermost points where it is heavier there (`_along`). Every other body has all of it at its
    centre.
    """
    beams = {c.body for c in linkage.compliance if isinstance(c, BeamCompliance)}
    rows: list[tuple[int, int, float, float, float, float, float]] = []
    for row, body in enumerate(linkage.moving, start=1):
        rows += [(row, *entry) for entry in _of_body(body, body.name in beams)]
    table = np.array([entry for entry in rows if entry[6] > 0.0], dtype=float).reshape(-1, 7)
    whole = table[:, :2].astype(int)
    return Lumps(whole[:, 0], whole[:, 1], table[:, 2:4], table[:, 4:6], table[:, 6])


def _of_body(body: Body, beam: bool) -> list[tuple[int, float, float, float, float, float]]:
    x, y = body.centre
    if not beam or body.mass <= 0.0 or body.inertia <= 0.0:
        return [(way, x, y, 0.0, 0.0, mass) for way, mass in enumerate((body.mass,) * 2)] + [
            (2, x, y, 0.0, 0.0, body.inertia)
        ]
    return [(way, x + arm, y, arm, 0.0, mass) for arm, mass in _along(body) for way in (0, 1)]


def _along(body: Body) -> list[tuple[float, float]]:
    """Return the arms from the centre, mm, and masses, tonne, of a body that bends along x.

    An even bar of its mass and inertia, sqrt(12 I/m) long, if that ends within its outermost
    points. Else one that reaches from point to point, with lumps at both (eyes, pins), if mass,
    centre and inertia allow it without a mass below 0.
    """
    half = float(np.sqrt(3.0 * body.inertia / body.mass))
    ends = [point[0] - body.centre[0] for point in body.points.values()]
    first, last = min(ends, default=0.0), max(ends, default=0.0)
    nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
    if (half > -first or half > last) and first < last:
        moments = np.array(
            [[1.0, 1.0, 1.0], [(first + last) / 2.0, first, last],
             [(first**2 + first * last + last**2) / 3.0, first**2, last**2]]
        )  # fmt: skip
        parts = np.linalg.solve(moments, [body.mass, 0.0, body.inertia])
        parts[np.abs(parts) < _NO_MASS * body.mass] = 0.0
        if (parts >= 0.0).all():
            even, *lumps = parts.tolist()
            along = (first + last) / 2.0 + (last - first) / 2.0 * nodes
            bar = list(zip(along.tolist(), (even * weights / 2.0).tolist(), strict=True))
            return [*bar, *zip((first, last), lumps, strict=True)]
    return list(zip((half * nodes).tolist(), (body.mass * weights / 2.0).tolist(), strict=True))
