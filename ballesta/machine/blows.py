"""Blows of a machine's cycles: what strikes where a contact is met, its impulses and forces.

Where the design says how the workpiece answers, the moments of the blow stand among the positions
of the cycle, so that stresses and fatigue have them (docs/theory/blows.md).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf, isinf

import numpy as np

import loads
from ballesta.machine.quasi_static import with_sections
from checks.design.data import Cycle, Design
from checks.design.errors import DesignError
from checks.part.part_loads import shown_position
from checks.result.verdict import Gate
from checks.result.words import brief, number
from geometry.parts import LeafPack
from reports.loads_figures import BlowForceSummary, BlowSummary, JointBlow

Blows = Mapping[str, Sequence[loads.BlowLoads]]
_AFTER = "swing after a blow, stress waves in it"
_LEAVES = "leaves that part in it"
_MISSING = 1e-6
_TURNED = 0.1  # of the speed: the pose counts as one through a blow
_MINUTE = 60.0  # s
_SOFT = 0.9  # share of the linkage in the compliance of both, above which it pushes back too late


def blows_of(
    design: Design, cycle: loads.CycleLoads, solved: Sequence[loads.BlowLoads] = ()
) -> list[BlowSummary]:
    """Every blow of a solved cycle, in the order in which they come.

    solved  those of the cycle whose forces are known

    A contact that appears with a phase, or in which a cycle begins, is not met on the way and no
    blow; nor is one that comes into touch by a deflection while it goes away.
    """
    shown = shown_position(design.cycles[cycle.name], cycle.positions)
    found = []
    forces = {one.row: _force(one) for one in solved}
    for name, law, k in _met(design.cycles[cycle.name], cycle):
        summary = _summary(design, cycle, name, law, k, float(shown[k]))
        found.append(replace(summary, solved=forces.get(k)))
    return sorted(found, key=lambda one: one.time)


def _met(stated: Cycle, cycle: loads.CycleLoads) -> Iterator[tuple[str, loads.Contact, int]]:
    """Force, law and row of every contact that is met at a speed."""
    for name, contact in cycle.contacts.items():
        for k in contact.begins.tolist():
            law = stated.run.phases[int(cycle.phase_of[k + 1])].given[name]
            assert isinstance(law, loads.Contact)
            if np.isfinite(cycle.touches[name].gap[k]) and law.side * contact.rate[k] < 0.0:
                yield name, law, k


def solved_blows(design: Design, solved: Mapping[str, loads.CycleLoads]) -> Blows:
    """Blows whose workpiece is stated, by cycle, in the order in which they come.

    Bodies without stated elasticity give way by the least section of their part. A drive of which
    no inertia is stated keeps its rate. Raises DesignError where nothing gives way, or a blow
    cannot be followed.
    """
    found: dict[str, list[loads.BlowLoads]] = {}
    for own, cycle in solved.items():
        stated = design.cycles[own]
        for name, law, k in sorted(_met(stated, cycle), key=lambda one: one[2]):
            if law.struck is None:
                continue
            elastic, _, _ = with_sections(design, cycle)
            _, inertia, known = driven(design, stated.run.pace)
            try:
                blow = loads.blow_loads(
                    cycle,
                    elastic,
                    name,
                    k,
                    law.struck,
                    design.dynamics.damping,
                    inertia if known else inf,
                )
            except loads.LinkageError as error:
                raise DesignError(
                    design.file, f"cycles.{own}", f"the blow of {name}: {error}"
                ) from error
            found.setdefault(own, []).append(blow)
    return found


def with_blows(solved: Mapping[str, loads.CycleLoads], blows: Blows) -> dict[str, loads.CycleLoads]:
    """Return the cycles with the moments of their blows."""
    result = dict(solved)
    for name, own in blows.items():
        for blow in reversed(own):
            result[name] = loads.with_blow(result[name], blow)
    return result


def blow_gates(blows: Blows) -> list[Gate]:
    """Validity checks of blows."""
    return [
        gate
        for name, own in blows.items()
        for gate in (
            Gate(
                f"{name}: energy of the blow",
                max(one.blow.missing for one in own),
                _MISSING,
                "energy that is not accounted for, over what the drive and the motion gave",
            ),
            Gate(
                f"{name}: modes in the blow",
                max(one.blow.unresolved for one in own),
                1.0,
                "three periods of the fastest mode over the time of contact: more, and the "
                "lumped masses are too few for it",
            ),
            Gate(
                f"{name}: pose in the blow",
                max(one.turned for one in own),
                _TURNED,
                "change of the struck point's speed over the drive's, while it presses in",
            ),
        )
    ]


def blow_subject(design: Design, solved: Mapping[str, loads.CycleLoads]) -> str:
    """The impact as a subject that no check covers, with the heaviest blow's impulse and energy.

    Of blows whose workpiece is stated only what comes after them. "" where nothing is struck.
    """
    blows, after = [], ""
    for name, cycle in solved.items():
        known = {
            float(cycle.times[k]) for _, law, k in _met(design.cycles[name], cycle) if law.struck
        }
        if known:
            packs = any(isinstance(part.geometry, LeafPack) for part in design.parts.values())
            after = f"{_AFTER}, {_LEAVES}" if packs else _AFTER
        blows += [(name, one) for one in blows_of(design, cycle) if one.time not in known]
    blows = [(name, blow) for name, blow in blows if blow.impulse[1] > 0.0]
    if not blows:
        return after
    name, blow = max(blows, key=lambda one: one[1].impulse[1])
    said = "without a bound of its impulse"
    if not isinf(blow.impulse[1]):
        energy = number(blow.energy[0] * 1e-3)
        said = f"of up to {number(blow.impulse[1])} N s and {energy} J a blow"
    return f"impact {said} on {brief(blow.force, 20)}, in {brief(name, 20)}; its force is unknown"


def _summary(
    design: Design, cycle: loads.CycleLoads, force: str, law: loads.Contact, k: int, at: float
) -> BlowSummary:
    pace, inertia, known = driven(design, design.cycles[cycle.name].run.pace)

    def struck(inertia: float, rigid: bool) -> loads.Blow:
        return loads.blow(
            cycle.linkage,
            force,
            cycle.poses[k],
            cycle.velocities[k],
            pace,
            inertia,
            rigid=rigid,
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


def _force(struck: loads.BlowLoads) -> BlowForceSummary:
    """A blow's force over time, in figures."""
    blow = struck.blow
    return BlowForceSummary(
        peak=float(blow.force.max()),
        contact=blow.contact,
        depth=blow.depth,
        energy=blow.energy,
        rebound=blow.rebound,
        until=float(blow.times[-1]),
        joints={
            name: float(np.hypot(*load.force.T).max())
            for name, load in struck.loads.reactions.items()
        },
    )


def driven(design: Design, pace: loads.Pace) -> tuple[loads.Coordinate, float, bool]:
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
