"""Natural frequencies of an elastic linkage that is held at its drive.

A held linkage is statically determinate: unit loads on its masses give joint forces by equilibrium
alone, these deform bodies and joints, and by virtual forces (Timoshenko and Young, Theory of
Structures, ch. 6) the displacements of the masses are u = F f with F = S' S, where S are the
deformations of unit loads (`loads.strains`). Free vibration has f = omega^2 M u, so that
1/omega^2 are the eigenvalues of sqrt(M) F sqrt(M) (Clough and Penzien, Dynamics of Structures,
ch. 11): the squared singular values of S sqrt(M). All of them are found; none can be skipped.
"""

from dataclasses import dataclass, replace

import numpy as np

from loads.bodies import FloatArray, IntArray, LinkageError
from loads.cycle_loads import CycleLoads
from loads.forces import ForceSolution, JointLoad, unit_forces
from loads.joints import Angle, Coordinate, Distance, Force, PointCoordinate
from loads.kinematics import Kinematics, rotated, turned_left
from loads.linkage import Linkage
from loads.lumped_masses import Lumps, lumps_of
from loads.motion import Motion, coordinate_share
from loads.strains import joint_strains, lump_strains

_STIFF = 1e-8  # of the softest mode's root: stiffer ones are rigid but for rounding
_PUSH = ("push x", "push y", "turn")  # forces put on bodies to find what unit loads do


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
            motion=_motion_at(self.motion, positions),
            frequencies=self.frequencies[positions],
            shapes=self.shapes[positions],
            strains=self.strains[positions],
            unit_strains=self.unit_strains[positions],
        )


def linkage_modes(motion: Motion, hold: Coordinate) -> LinkageModes:
    """Return all modes of a linkage with a coordinate held, at every position of a motion.

    Only poses and the way of the motion count, not its speed; friction and weight do not.
    Raises LinkageError for a linkage without elasticity or mass, and at a dead centre of `hold`.
    """
    bare, holder = _held(motion.kinematics.linkage, hold)
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
    return linkage_modes(motion if positions is None else _motion_at(motion, positions), cycle.pace)


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
    solution = ForceSolution(
        cycle.reactions, efforts, cycle.conditioning, np.zeros((len(cycle.positions), 0))
    )
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
    body the acceleration that has their resultant, so that each stays in equilibrium.
    Raises LinkageError where no force of the linkage is the drive's.
    """
    if modes.holder not in cycle.efforts:
        raise LinkageError(
            f"no force acts along {cycle.pace.label}, which sets the pace: what drives the linkage "
            "is not known, so what vibration adds to it has no place; let a force set the pace"
        )
    linkage = cycle.linkage
    pushed = _rebased(modes.motion, Kinematics(_pushed(modes.kinematics.linkage)), cycle.pace)
    pushes = _unit_pushes(pushed, modes.lumps, modes.holder)
    wrenches = modes.lumps.wrenches(cycle.poses[:, :, 2])
    reactions = dict(cycle.reactions)
    efforts = dict(cycle.efforts)
    accelerations = cycle.accelerations.copy()
    for row, body in enumerate(linkage.moving, start=1):
        own = modes.lumps.of(row)
        if not len(own):
            continue
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
                name: _grown(load, solution.joints[name], total[:, k])
                for name, load in reactions.items()
            }
    return replace(cycle, accelerations=accelerations, reactions=reactions, efforts=efforts)


def _grown(load: JointLoad, unit: JointLoad, size: FloatArray) -> JointLoad:
    return replace(
        load, force=load.force + unit.force * size[:, None], moment=load.moment + unit.moment * size
    )


def _held(linkage: Linkage, hold: Coordinate) -> tuple[Linkage, str]:
    """Return the linkage without friction, and the name of a force along the held coordinate."""
    linkage.check_coordinate(hold, "held coordinate")
    bare = replace(linkage, friction={})
    for force in linkage.forces:
        if _same(force.coordinate, hold):
            return bare, force.name
    name = f"hold {hold.label}"
    return replace(bare, forces=(*bare.forces, Force(name, hold))), name


def _same(one: Coordinate, other: Coordinate) -> bool:
    match one, other:
        case Angle(), Angle():
            return (one.body, one.relative_to) == (other.body, other.relative_to)
        case Distance(), Distance():
            ends, others = ({(d.body_a, d.point_a), (d.body_b, d.point_b)} for d in (one, other))
            return ends == others
        case PointCoordinate(), PointCoordinate():
            return one == other
    return False


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


def _motion_at(motion: Motion, positions: IntArray) -> Motion:
    return replace(
        motion,
        values=motion.values[positions],
        poses=motion.poses[positions],
        velocities=motion.velocities[positions],
        accelerations=motion.accelerations[positions],
        heading=motion.heading[positions],
    )
