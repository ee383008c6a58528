"""Forces that follow laws over the motion, and contacts that the elastic linkage settles.

A contact pushes with F = max(0, k (at - coordinate)), with the coordinate of the deflected linkage:
its rigid value plus the deflection delta(F) that all loads together cause. F and delta are
solved for together; without friction delta is linear in F and one step does it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from loads.bodies import BoolArray, FloatArray, LinkageError
from loads.elasticity import LoadState, deflection
from loads.forces import ForceSolution, solve_forces, unit_forces
from loads.joints import Fixed, Force, PointCoordinate, in_words
from loads.kinematics import dot, unit
from loads.laws import Contact, Expression, Law, Opposing, Table, expressed
from loads.linkage import Linkage
from loads.motion import Motion
from loads.reversals import opposing

_STEPS = 60
_LEFT = 1e-12  # of depth and deflection: what may be left of a contact's gap


@dataclass(frozen=True, eq=False)
class Touch:
    """A contact at every position of a stretch of the motion.

    touching    (n,) True if the linkage, moving on freely, would be in what it touches
    gap         (n,) mm, of the freely moving linkage to the contact; below 0 where it touches
    lift        (n,) mm, of the linkage as it is held, without the contact's force; below 0 where
                the contact pushes
    deflection  (n,) mm, of the linkage along the force, under all its loads
    held        (n,) share of its acceleration along the force that the pushed body loses: 0 free,
                1 stopped by a rigid contact
    """

    touching: BoolArray
    gap: FloatArray
    lift: FloatArray
    deflection: FloatArray
    held: FloatArray


def solve_laws(
    motion: Motion, laws: Mapping[str, Law], solve: str
) -> tuple[Motion, ForceSolution, dict[str, Touch]]:
    """Return motion, forces and contacts for forces that follow laws.

    The motion differs from the one given where a contact holds a body still.
    Raises LinkageError where a table does not cover the motion or nothing gives way at a contact.
    """
    given, contacts = _sorted(motion, laws)
    if not contacts:
        return motion, solve_forces(motion, given, solve), {}
    if len(contacts) > 1:
        raise LinkageError(
            f"{' and '.join(contacts)} are contacts of one phase; only one is solved at a time"
        )
    ((name, contact),) = contacts.items()
    return _solve_contact(motion, given, solve, name, contact)


def _sorted(
    motion: Motion, laws: Mapping[str, Law]
) -> tuple[dict[str, float | FloatArray], dict[str, Contact]]:
    """Forces that are known at every position, and contacts, by name."""
    given: dict[str, float | FloatArray] = {}
    contacts: dict[str, Contact] = {}
    for name, law in laws.items():
        match law:
            case Contact():
                contacts[name] = law
            case Table():
                given[name] = _tabled(motion, name, law)
            case Expression():
                given[name] = expressed(motion, name, law)
            case Opposing():
                given[name] = opposing(motion, name, law)
            case _:
                given[name] = law
    return given, contacts


def _tabled(motion: Motion, name: str, table: Table) -> FloatArray:
    kinematics = motion.kinematics
    kinematics.linkage.check_coordinate(table.coordinate, f"table of force {name!r}")
    places = kinematics.value(table.coordinate, motion.poses)
    low, high = table.values[0], table.values[-1]
    slack = 1e-9 * (high - low)
    outside = (places < low - slack) | (places > high + slack)
    if outside.any():
        coordinate = table.coordinate
        wrap = "; angles are not wrapped, let the table go on" if coordinate.angular else ""
        raise LinkageError(
            f"force {name!r}: its table goes from {in_words(coordinate, low)} to "
            f"{in_words(coordinate, high)} of {coordinate.label} and does not cover "
            f"{in_words(coordinate, float(places[outside][0]))}{wrap}"
        )
    return np.interp(places, table.values, table.forces)


class _Approach:
    """A linkage in front of a contact: how it gives way along the contact's force.

    sense     of the force's value where the contact pushes
    slope     (n,) mm/N, compliance of the linkage and the contact together
    held      (n,) as in Touch; `slowed` is the motion that follows from it
    depth     (n,) mm, how far the rigid linkage would be in the contact
    """

    def __init__(
        self,
        motion: Motion,
        given: Mapping[str, float | FloatArray],
        solve: str,
        name: str,
        contact: Contact,
    ) -> None:
        kinematics, poses = motion.kinematics, motion.poses
        force = kinematics.linkage.force(name)
        self._given, self._solve, self._name = given, solve, name
        self.motion, self.sense = motion, contact.side * force.sign
        self._unit = LoadState(unit_forces(motion, [name], self.sense, solve)[0], None)
        softness = deflection(kinematics, poses, self._unit, self._unit)
        self.soft = 0.0 if contact.stiffness is None else 1.0 / contact.stiffness
        self.slope = softness + self.soft
        # the pushed body follows the contact, whose surface gives way by this share of all
        self.held = np.zeros(len(poses))
        if contact.stops:
            np.divide(softness, self.slope, out=self.held, where=self.slope > 0.0)
        self.slowed = _slowed(motion, force, self.held)
        self.depth = contact.side * (contact.at - kinematics.value(force.coordinate, poses))

    def solved(self, moving: Motion, size: FloatArray) -> ForceSolution:
        """All forces where the contact pushes with some force (n,)."""
        return solve_forces(moving, {**self._given, self._name: self.sense * size}, self._solve)

    def way(self, moving: Motion, solution: ForceSolution) -> FloatArray:
        """Deflection of the linkage along the contact's force (n,), mm."""
        state = LoadState(solution, moving)
        return deflection(self.motion.kinematics, self.motion.poses, self._unit, state)

    def deflected(self, moving: Motion, size: FloatArray) -> FloatArray:
        """Deflection along the contact's force where it pushes with `size` (n,), mm."""
        return self.way(moving, self.solved(moving, size))

    @cached_property
    def gap(self) -> FloatArray:
        """As in Touch."""
        return self.deflected(self.motion, np.zeros(len(self.depth))) - self.depth

    @cached_property
    def lift(self) -> FloatArray:
        """As in Touch."""
        if self.slowed is self.motion:
            return self.gap
        return self.deflected(self.slowed, np.zeros(len(self.depth))) - self.depth


def contact_gaps(motion: Motion, laws: Mapping[str, Law], solve: str, name: str) -> FloatArray:
    """Gap and lift (2, n) of a contact as in Touch, mm, without settling its force."""
    given, contacts = _sorted(motion, laws)
    approach = _Approach(motion, given, solve, name, contacts[name])
    return np.stack([approach.gap, approach.lift])


def _solve_contact(
    motion: Motion,
    given: Mapping[str, float | FloatArray],
    solve: str,
    name: str,
    contact: Contact,
) -> tuple[Motion, ForceSolution, dict[str, Touch]]:
    kinematics = motion.kinematics
    approach = _Approach(motion, given, solve, name, contact)
    touching, lift = approach.gap < 0.0, approach.lift
    if (touching & (lift < 0.0) & (approach.slope <= 0.0)).any():
        raise LinkageError(
            f"force {name!r}: nothing gives way between a rigid contact and a rigid linkage; "
            "state the stiffness of the contact, or the elasticity of a body or joint"
        )
    size = np.zeros(len(lift))
    if (touching & (lift < 0.0)).any():
        scale = kinematics.coordinate_scale(kinematics.linkage.force(name).coordinate)
        try:
            size = _settled(approach, touching, scale)
        except _Unsettled as unsettled:
            raise LinkageError(
                f"force {name!r}: contact and friction do not settle at "
                f"{motion.place(unsettled.position)}; friction comes close to locking there"
            ) from None
    mixed = _chosen(touching, approach.slowed, motion)
    final = approach.solved(mixed, size)
    held = np.where(touching, approach.held, 0.0)
    touch = Touch(touching, approach.gap, lift, approach.way(mixed, final), held)
    return mixed, final, {name: touch}


class _Unsettled(Exception):
    def __init__(self, position: int) -> None:
        super().__init__(position)
        self.position = position


def _settled(approach: _Approach, touching: BoolArray, scale: float) -> FloatArray:
    """Return the contact's force (n,): secants from the frictionless slope, each position alone."""
    depth, soft, slope = approach.depth, approach.soft, approach.slope
    size = np.zeros(len(depth))
    given_way = approach.lift + depth
    first = np.where(slope > 0.0, slope, 1.0)
    slope = first.copy()
    for _ in range(_STEPS):
        left = depth - given_way - soft * size
        allowed = _LEFT * (np.abs(depth) + np.abs(given_way)) + 1e-14 * scale
        settled = ~touching | (np.abs(left) <= allowed) | ((size == 0.0) & (left <= 0.0))
        if settled.all():
            return size
        following = np.where(settled, size, np.maximum(size + left / slope, 0.0))
        change = following - size
        way = approach.deflected(approach.slowed, following)
        moved = change != 0.0
        secant = np.divide(way - given_way + soft * change, change, out=slope.copy(), where=moved)
        slope = np.clip(secant, 0.05 * first, 1e3 * first)
        size, given_way = following, way
    raise _Unsettled(int(np.argmax(np.where(settled, 0.0, np.abs(left)))))


def rigidly_joined(linkage: Linkage, body: str) -> tuple[str, ...]:
    """Return a body and all that are welded to it."""
    together = [body]
    for name in together:
        for joint in linkage.joints:
            if isinstance(joint, Fixed) and name in (joint.body_a, joint.body_b):
                other = joint.body_b if joint.body_a == name else joint.body_a
                if other not in together:
                    together.append(other)
    return tuple(together)


def _slowed(motion: Motion, force: Force, held: FloatArray) -> Motion:
    """Return the motion in which the pushed body loses a share of its acceleration."""
    if not (held > 0.0).any():
        return motion
    kinematics, coordinate = motion.kinematics, force.coordinate
    cure = "state that the contact does not stop it (stops = false)"
    if not isinstance(coordinate, PointCoordinate):
        raise LinkageError(
            f"force {force.name!r}: a contact holds a body still only where it pushes a point "
            f"along a direction; {cure}"
        )
    row = kinematics.index[coordinate.body]
    turning = np.abs(motion.heading[:, row, 2]) * kinematics.size
    if (turning > 1e-9 * np.abs(motion.heading[:, row]).max(axis=1)).any():
        raise LinkageError(
            f"force {force.name!r}: body {coordinate.body!r} turns, and a contact can only hold a "
            f"body still that slides; {cure}"
        )
    along = unit(coordinate.direction)
    lost = held * dot(motion.accelerations[:, row, :2], along)
    accelerations = motion.accelerations.copy()
    for body in rigidly_joined(kinematics.linkage, coordinate.body):
        accelerations[:, kinematics.index[body], :2] -= lost[:, None] * along
    return replace(motion, accelerations=accelerations)


def _chosen(touching: BoolArray, held: Motion, free: Motion) -> Motion:
    accelerations = np.where(touching[:, None, None], held.accelerations, free.accelerations)
    return replace(free, accelerations=accelerations)
