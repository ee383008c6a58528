"""Loads of a known motion under other masses and forces: nothing is traced or placed again.

A linkage whose points, joints and pace stay moves as before, whatever its bodies weigh and its
forces are; only the forces at its positions must be solved for again. The positions stay those that
were placed for the loads they were solved with first, closest where these turned fast, and hold
both ends of every phase and the corners of its tables whatever the loads.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from loads.bodies import Body, LinkageError
from loads.contact import solve_laws
from loads.cycle import CycleError
from loads.cycle_loads import CycleLoads
from loads.forces import one_after_another
from loads.kinematics import Kinematics
from loads.laws import Contact, Law
from loads.linkage import Linkage
from loads.motion import Motion
from loads.pace import MotorPace
from loads.phases import Cycle


def moves_alike(known: Linkage, cycle: Cycle, other: Linkage, other_cycle: Cycle) -> bool:
    """Return True if a linkage goes through a cycle as a known one does, at the same positions.

    Masses, gravity, friction and constant forces may differ. False for cycles with a contact, which
    holds bodies still by an amount that depends on the forces, and for those that a motor turns.
    """
    if _has_contact(cycle) or _has_contact(other_cycle) or isinstance(cycle.pace, MotorPace):
        return False
    return (
        _shape(known) == _shape(other)
        and (cycle.coordinate, cycle.start, cycle.pace, cycle.n_positions)
        == (other_cycle.coordinate, other_cycle.start, other_cycle.pace, other_cycle.n_positions)
        and [(p.name, p.stop, p.solve, _variable(p.given)) for p in cycle.phases]
        == [(p.name, p.stop, p.solve, _variable(p.given)) for p in other_cycle.phases]
    )


def forces_again(known: CycleLoads, linkage: Linkage, cycle: Cycle) -> CycleLoads:
    """Return the loads of a linkage at the positions of a cycle that one like it went through.

    The two must move alike (`moves_alike`). `unresolved` stays what the known loads have: how well
    its positions follow them. Raises LinkageError, which names the phase, where friction locks the
    linkage or a force is missing.
    """
    kinematics = Kinematics(linkage)
    motions, solutions = [], []
    for k, phase in enumerate(cycle.phases):
        rows = np.flatnonzero(known.phase_of == k)
        motion = Motion(
            kinematics,
            cycle.coordinate,
            known.positions[rows],
            known.poses[rows],
            known.velocities[rows],
            known.accelerations[rows],
            known.heading[rows],
        )
        try:
            solved = solve_laws(motion, phase.given, phase.solve)
        except LinkageError as error:
            raise CycleError(cycle.name, k, phase.name, str(error)) from None
        motions.append(solved[0])
        solutions.append(solved[1])
    whole = one_after_another(solutions)
    return replace(
        known,
        linkage=linkage,
        reactions=whole.joints,
        efforts={force.name: whole.efforts[force.name] for force in linkage.forces},
        conditioning=whole.conditioning,
    )


def _has_contact(cycle: Cycle) -> bool:
    return any(isinstance(law, Contact) for phase in cycle.phases for law in phase.given.values())


def _shape(linkage: Linkage) -> object:
    """Return the data of a linkage that its motion depends on, to be compared."""
    bodies = tuple((body.name, _points(body)) for body in linkage.bodies)
    return bodies, linkage.joints, linkage.forces, dict(linkage.assembled)


def _points(body: Body) -> object:
    return dict(body.points)


def _variable(given: Mapping[str, Law]) -> Mapping[str, Law | None]:
    """The laws of a phase, without the size of those that are constant."""
    return {name: None if isinstance(law, float | int) else law for name, law in given.items()}
