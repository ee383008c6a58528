"""Blows of a machine's cycles: what strikes where a contact is met, and the impulses of it."""

from collections.abc import Mapping
from math import inf, isinf

import numpy as np

import loads
from checks.design.data import Design
from checks.part.part_loads import shown_position
from checks.result.words import brief, number
from reports.loads_figures import BlowSummary, JointBlow

_MINUTE = 60.0  # s
_SOFT = 0.9  # share of the linkage in the compliance of both, above which it pushes back too late


def blows_of(design: Design, cycle: loads.CycleLoads) -> list[BlowSummary]:
    """Every blow of a solved cycle, in the order in which they come.

    A contact that appears with a phase, or in which a cycle begins, is not met on the way and no
    blow; nor is one that comes into touch by a deflection while it goes away.
    """
    stated = design.cycles[cycle.name]
    shown = shown_position(stated, cycle.positions)
    found = []
    for name, contact in cycle.contacts.items():
        for k in contact.begins.tolist():
            law = stated.run.phases[int(cycle.phase_of[k + 1])].given[name]
            assert isinstance(law, loads.Contact)
            if np.isfinite(cycle.touches[name].gap[k]) and law.side * contact.rate[k] < 0.0:
                found.append(_summary(design, cycle, name, law, k, float(shown[k])))
    return sorted(found, key=lambda one: one.time)


def blow_subject(design: Design, solved: Mapping[str, loads.CycleLoads]) -> str:
    """The impact as a subject that no check covers, with the heaviest blow's impulse and energy.

    "" where nothing is struck.
    """
    blows = [(name, blow) for name, cycle in solved.items() for blow in blows_of(design, cycle)]
    blows = [(name, blow) for name, blow in blows if blow.impulse[1] > 0.0]
    if not blows:
        return ""
    name, blow = max(blows, key=lambda one: one[1].impulse[1])
    said = "without a bound of its impulse"
    if not isinf(blow.impulse[1]):
        energy = number(blow.energy[0] * 1e-3)
        said = f"of up to {number(blow.impulse[1])} N s and {energy} J a blow"
    return f"impact {said} on {brief(blow.force, 20)}, in {brief(name, 20)}; its force is unknown"


def _summary(
    design: Design, cycle: loads.CycleLoads, force: str, law: loads.Contact, k: int, at: float
) -> BlowSummary:
    driven, inertia, known = _driven(design, design.cycles[cycle.name].run.pace)

    def struck(inertia: float, rigid: bool) -> loads.Blow:
        return loads.blow(
            cycle.linkage, force, cycle.poses[k], cycle.velocities[k], driven, inertia, rigid=rigid
        )

    blow = struck(inertia, False)
    rigid = struck(inertia, True).mass if blow.open else blow.mass
    stiff = bool(blow.open) and cycle.contacts[force].held[k + 1] < _SOFT
    largest = rigid if stiff else blow.mass
    more = largest / blow.mass if blow.mass > 0.0 and not isinf(blow.mass) else 1.0
    low, high = (0.0, 1.0) if law.restitution is None else (law.restitution,) * 2
    closed = cycle.drive(cycle.linkage.forces[0].name).closed
    return BlowSummary(
        force=force,
        stated=law.restitution is not None,
        restitution=(low, high),
        at=at,
        phase=cycle.phases[int(cycle.phase_of[k])],
        time=float(cycle.times[k]),
        speed=blow.speed,
        mass=(blow.mass, largest),
        impulse=(blow.impulse(low), more * blow.impulse(high)),
        energy=(more * blow.energy(low), blow.energy(high)),
        joints=tuple(
            JointBlow(
                joint.name,
                joint.body_b,
                (1.0 + high) * float(blow.joints[joint.name].force[0]),
                (1.0 + high) * float(blow.joints[joint.name].force[1]),
                (1.0 + high) * blow.joints[joint.name].couple,
            )
            for joint in cycle.linkage.joints
            if joint.name in blow.joints and not stiff
        ),
        open=blow.open,
        rigid_mass=rigid,
        drive_struck=struck(inf, stiff).mass != largest or isinf(largest),
        drive_stated=known,
        per_minute=_MINUTE / float(cycle.times[-1]) if closed else None,
    )


def _driven(design: Design, pace: loads.Pace) -> tuple[loads.Coordinate, float, bool]:
    """Coordinate of the drive, its inertia besides the bodies' own, and True if that is all.

    Infinite where the drive holds its speed whatever the load.
    """
    drive = design.drive
    if isinstance(pace, loads.RunPace):
        return pace.coordinate, pace.inertia, True
    if isinstance(pace, loads.MotorPace):
        return pace.coordinate, pace.motor.reflected + pace.inertia, True
    if drive.control == "constant":
        return pace.coordinate, inf, True
    if drive.flywheel is not None and pace.coordinate.angular:
        return pace.coordinate, drive.flywheel, True
    return pace.coordinate, 0.0, False
