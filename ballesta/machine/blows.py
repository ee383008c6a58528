"""Blows of a machine's cycles: what strikes where a contact is met, and the impulses of it."""

from collections.abc import Mapping
from math import inf, isinf

import numpy as np

import loads
from checks.design.data import Cycle, Design
from checks.part.part_loads import shown_position
from checks.result.words import brief, number
from reports.loads_figures import BlowSummary, JointBlow

_MINUTE = 60.0  # s


def blows_of(design: Design, cycle: loads.CycleLoads) -> list[BlowSummary]:
    """Every blow of a solved cycle, in the order in which they come.

    A contact that appears with a phase, or in which a cycle begins, is not met on the way and no
    blow.
    """
    stated = design.cycles[cycle.name]
    shown = shown_position(stated, cycle.positions)
    found = [
        _summary(design, stated, cycle, name, k, float(shown[k]))
        for name, contact in cycle.contacts.items()
        for k in contact.begins.tolist()
        if np.isfinite(cycle.touches[name].gap[k])
    ]
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
    if isinf(blow.mass):
        said = "no bound of its impulse"
    else:
        energy = number(blow.energy[0] * 1e-3)
        said = f"up to {number(blow.impulse[1])} N s, {energy} J a blow"
    return f"impact, {brief(blow.force, 20)}: {said} ({brief(name, 20)}); its force is unknown"


def _summary(
    design: Design, stated: Cycle, cycle: loads.CycleLoads, force: str, k: int, at: float
) -> BlowSummary:
    law = stated.run.phases[int(cycle.phase_of[k + 1])].given[force]
    assert isinstance(law, loads.Contact)
    driven, inertia, known = _driven(design, stated.run.pace)

    def struck(inertia: float, rigid: bool) -> loads.Blow:
        return loads.blow(
            cycle.linkage, force, cycle.poses[k], cycle.velocities[k], driven, inertia, rigid=rigid
        )

    blow = struck(inertia, False)
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
        mass=blow.mass,
        impulse=(blow.impulse(low), blow.impulse(high)),
        energy=(blow.energy(low), blow.energy(high)),
        joints=tuple(
            JointBlow(
                joint.name,
                joint.body_b,
                float(blow.joints[joint.name].force[0]),
                float(blow.joints[joint.name].force[1]),
                blow.joints[joint.name].couple,
            )
            for joint in cycle.linkage.joints
            if joint.name in blow.joints
        ),
        open=blow.open,
        rigid_mass=struck(inertia, True).mass if blow.open else blow.mass,
        drive_struck=struck(inf, False).mass != blow.mass or isinf(blow.mass),
        drive_stated=known,
        per_minute=_MINUTE / float(cycle.times[-1]) if closed else None,
    )


def _driven(design: Design, pace: loads.Pace) -> tuple[loads.Coordinate, float, bool]:
    """Coordinate of the drive, its inertia besides the bodies' own, and True if that is all.

    Infinite where the drive holds its speed whatever the load.
    """
    drive = design.drive
    if isinstance(pace, loads.MotorPace):
        return pace.coordinate, pace.motor.reflected + pace.inertia, True
    if drive.control == "constant":
        return pace.coordinate, inf, True
    if drive.flywheel is not None and pace.coordinate.angular:
        return pace.coordinate, drive.flywheel, True
    return pace.coordinate, 0.0, False
