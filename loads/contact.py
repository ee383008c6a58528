"""Forces that follow laws: tables over the motion, and contacts that the elastic linkage settles.

A contact pushes with F = max(0, k (at - coordinate)), where the coordinate is that of the deflected
linkage: its rigid value plus the deflection delta(F) that all loads together cause. F and delta are
solved for together; without friction delta is linear in F and one step does it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from loads.bodies import BoolArray, FloatArray, LinkageError
from loads.elasticity import LoadState, deflection
from loads.elements import Force, PointCoordinate
from loads.forces import ForceSolution, solve_forces, unit_forces
from loads.kinematics import dot, turned_left, unit
from loads.laws import Contact, Law, Table
from loads.motion import Motion

_STEPS = 50
_EQUAL = 1e-11  # of the largest contact force


@dataclass(frozen=True, eq=False)
class Touch:
    """A contact at every position of a stretch of the motion.

    touching    (n,) whether it pushes
    gap         (n,) mm, from the deflected linkage to the contact without its force; below 0 where
                it pushes
    deflection  (n,) mm, how far the linkage gives way along the force, under all its loads
    """

    touching: BoolArray
    gap: FloatArray
    deflection: FloatArray


def solve_laws(
    motion: Motion, laws: Mapping[str, Law], solve: str
) -> tuple[Motion, ForceSolution, dict[str, Touch]]:
    """Return motion, forces and contacts for forces that follow laws.

    The motion differs from the one given where a contact holds a body still.
    Raises LinkageError where a table does not cover the motion or nothing gives way at a contact.
    """
    given: dict[str, float | FloatArray] = {}
    contacts: dict[str, Contact] = {}
    for name, law in laws.items():
        match law:
            case Contact():
                contacts[name] = law
            case Table():
                given[name] = _tabled(motion, name, law)
            case _:
                given[name] = law
    if not contacts:
        return motion, solve_forces(motion, given, solve), {}
    if len(contacts) > 1:
        raise LinkageError(
            f"{' and '.join(contacts)} are contacts of one phase; only one is solved at a time"
        )
    ((name, contact),) = contacts.items()
    return _solve_contact(motion, given, solve, name, contact)


def _tabled(motion: Motion, name: str, table: Table) -> FloatArray:
    kinematics = motion.kinematics
    kinematics.linkage.check_coordinate(table.coordinate, f"table of force {name!r}")
    places = kinematics.value(table.coordinate, motion.poses)
    low, high = table.values[0], table.values[-1]
    slack = 1e-9 * (high - low)
    outside = (places < low - slack) | (places > high + slack)
    if outside.any():
        unit_name = "rad" if table.coordinate.angular else "mm"
        raise LinkageError(
            f"force {name!r}: its table goes from {low:.6g} to {high:.6g} {unit_name} of "
            f"{table.coordinate.label} and does not cover {places[outside][0]:.6g} {unit_name}"
        )
    return np.interp(places, table.values, table.forces)


def _solve_contact(
    motion: Motion,
    given: Mapping[str, float | FloatArray],
    solve: str,
    name: str,
    contact: Contact,
) -> tuple[Motion, ForceSolution, dict[str, Touch]]:
    kinematics = motion.kinematics
    force = kinematics.linkage.force(name)
    sense = contact.side * force.sign  # of the force's value where the contact pushes
    held = _held(motion, force) if contact.stops else motion
    unit_state = LoadState(unit_forces(motion, name, sense, solve), None)
    softness = deflection(kinematics, motion.poses, unit_state, unit_state)
    soft = 0.0 if contact.stiffness is None else 1.0 / contact.stiffness
    if (softness + soft <= 0.0).any():
        raise LinkageError(
            f"force {name!r}: nothing gives way between a rigid contact and a rigid linkage; "
            "state the stiffness of the contact, or the elasticity of a body or joint"
        )
    depth = contact.side * (contact.at - kinematics.value(force.coordinate, motion.poses))

    def deflected(size: FloatArray) -> FloatArray:
        real = LoadState(solve_forces(held, {**given, name: sense * size}, solve), held)
        return deflection(kinematics, motion.poses, unit_state, real)

    size = np.zeros(len(depth))
    given_way = deflected(size)
    gap = given_way - depth
    slope = softness + soft
    # what rounding of the positions is worth as a force
    rounding = 1e-14 * kinematics.coordinate_scale(force.coordinate) / float(slope.min())
    for _ in range(_STEPS):
        left = depth - given_way - soft * size
        following = np.maximum(size + left / slope, 0.0)
        change = np.abs(following - size)
        size = following
        if float(change.max()) <= _EQUAL * float(size.max()) + rounding:
            break
        given_way = deflected(size)
    else:
        k = int(np.argmax(change))
        raise LinkageError(
            f"force {name!r}: contact and friction do not settle at {motion.values[k]:.6g}"
        )
    touching = gap < 0.0
    mixed = _chosen(touching, held, motion)
    final = solve_forces(mixed, {**given, name: sense * size}, solve)
    way = deflection(kinematics, motion.poses, unit_state, LoadState(final, mixed))
    return mixed, final, {name: Touch(touching, gap, way)}


def _held(motion: Motion, force: Force) -> Motion:
    """Return the motion with no acceleration of the pushed body along the force."""
    coordinate = force.coordinate
    if not isinstance(coordinate, PointCoordinate):
        raise LinkageError(
            f"force {force.name!r}: a contact holds a body still only where it pushes a point "
            "along a direction; state that it does not stop the body"
        )
    kinematics = motion.kinematics
    row = kinematics.index[coordinate.body]
    arm = kinematics.arm(motion.poses, coordinate.body, coordinate.point)
    spin, turn = motion.velocities[:, row, 2:], motion.accelerations[:, row, 2:]
    pull = motion.accelerations[:, row, :2] + turn * turned_left(arm) - spin**2 * arm
    along = unit(coordinate.direction)
    accelerations = motion.accelerations.copy()
    accelerations[:, row, :2] -= dot(pull, along)[:, None] * along
    return replace(motion, accelerations=accelerations)


def _chosen(touching: BoolArray, held: Motion, free: Motion) -> Motion:
    accelerations = np.where(touching[:, None, None], held.accelerations, free.accelerations)
    return replace(free, accelerations=accelerations)
