"""Blows of a machine's cycles: what strikes where a contact is met, its impulses and forces.

Where the design says how the workpiece answers, the linkage of a cycle swings by its blows, and
their moments stand among its positions, so that stresses and fatigue have them
(docs/theory/blows.md).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isinf

import numpy as np

import loads
from ballesta.machine.quasi_static import CycleVibration, vibration_of, with_dynamics, with_sections
from checks.design.data import Cycle, Design
from checks.design.errors import DesignError
from checks.part.part_loads import shown_position
from checks.result.verdict import Gate
from checks.result.words import brief, number
from geometry.parts import LeafPack
from loads.vibration import closes
from reports.loads_figures import BlowForceSummary, BlowSummary, JointBlow

SWING_ENDS = "lowest", "highest"
_WAVES = "ring-down of fast modes and stress waves in a blow"
_AFTER = "swing after a blow, stress waves in it"
_LEAVES = "leaves that part in it"
_MISSING = 1e-6
_TURNED = 0.1  # of the speed: the pose counts as one through a blow
_REPEATS = 0.02  # of the largest deformation
_STILL = 0.1
_SURGE = 0.1  # of its speed: a drive that the swing speeds up and slows by more does not keep it
_THROUGH = 0.25  # the same: beyond it the drive may not get through
_MINUTE = 60.0  # s
_SOFT = 0.9  # share of the linkage in the compliance of both, above which it pushes back too late


@dataclass(frozen=True, eq=False)
class StruckCycle:
    """The blows of a cycle whose workpiece is stated.

    blows  of one contact after another, in their order
    swung  the cycle as the linkage swings by them; None where it does not end as it begins, or the
           drive does not keep its speed and the first blow alone is nearer to the truth: its pose
           holds, or the drive may not get through
    surge  as in SwungCycle
    """

    blows: tuple[loads.BlowLoads, ...]
    swung: loads.SwungCycle | None = None
    surge: float = 0.0


Blows = Mapping[str, StruckCycle]


@dataclass(frozen=True, eq=False)
class Transients:
    """Cycles with vibration, where the design asks for it, and with blows on stated workpieces.

    cycles     with all that
    smooth     without it; those that swing by their blows without the contact
    vibration  of these
    """

    cycles: dict[str, loads.CycleLoads]
    smooth: Mapping[str, loads.CycleLoads]
    blows: Blows
    vibration: Mapping[str, CycleVibration]


def transients_of(
    design: Design,
    solved: Mapping[str, loads.CycleLoads],
    known: Mapping[str, CycleVibration] | None = None,
    pick: str = "",
    *,
    every: bool = True,
) -> Transients:
    """Return solved cycles with all that is not as if slowly.

    known  vibration, if it is known
    every  False for the vibration of those cycles alone whose loads it changes
    pick   "lowest" or "highest" frequency of the swing; "": at the touch

    Raises DesignError where nothing gives way in a blow, or it cannot be followed.
    """
    free = _without_struck_contacts(design, solved)
    asked = {**solved, **free} if every or design.dynamics.apply else free
    vibration = vibration_of(design, asked) if known is None else dict(known)
    for name, cycle in free.items() if known is not None else ():
        response = vibration[name].response if name in vibration else None
        if response is None or not np.array_equal(response.modes.motion.poses, cycle.poses):
            vibration |= vibration_of(design, {name: cycle})
    free = {
        name: cycle
        for name, cycle in free.items()
        if name in vibration and vibration[name].response is not None
    }
    smooth = {**solved, **free}
    result = with_dynamics(design, smooth, vibration)
    blows = {}
    for name, cycle in solved.items():
        met = [one for one in _met(design.cycles[name], cycle) if one[1].struck is not None]
        if not met:
            continue
        try:
            if name in free:
                one = _swung(design, cycle, free[name], result[name], vibration[name], met[0], pick)
            else:
                one = _struck(design, cycle, met)
        except loads.LinkageError as error:
            raise DesignError(
                design.file, f"cycles.{name}", f"the blow of {met[0][0]}: {error}"
            ) from error
        blows[name] = one
        whole = cycle if one.swung is None else one.swung.loads
        for blow in reversed(one.blows):
            whole = loads.with_blow(whole, blow)
        result[name] = whole
    return Transients(result, smooth, blows, vibration)


def _without_struck_contacts(
    design: Design, solved: Mapping[str, loads.CycleLoads]
) -> dict[str, loads.CycleLoads]:
    """Cycles that run again and again and strike a stated workpiece, without its contact."""
    found = {}
    for name, cycle in solved.items():
        stated = design.cycles[name]
        met = [one for one in _met(stated, cycle) if one[1].struck is not None]
        if not met or len(cycle.touches) > 1 or stated.event is not None or not closes(cycle):
            continue
        force = met[0][0]
        touch = cycle.touches[force]
        if np.isfinite(touch.gap).all() and not touch.touching[0]:
            found[name] = loads.without_contact(cycle, stated.run, force)
    return found


def _swung(
    design: Design,
    touching: loads.CycleLoads,
    free: loads.CycleLoads,
    base: loads.CycleLoads,
    vibration: CycleVibration,
    met: tuple[str, loads.Contact, int],
    pick: str,
) -> StruckCycle:
    """A cycle that swings by its blows.

    base  the free cycle, with vibration where the design asks for it
    """
    assert vibration.response is not None
    elastic, _, _ = with_sections(design, free)
    force, law, _ = met
    pace = design.cycles[free.name].run.pace
    _, inertia, known = driven(design, pace)
    swung = loads.swung_cycle(
        touching,
        base,
        elastic,
        vibration.response,
        force,
        law,
        design.dynamics.damping,
        inertia if known else inf,
        pick,
        slowed=isinstance(pace, loads.MotorPace),
    )
    if swung.surge > _SURGE:
        first = _struck(design, touching, [met])
        turned = max(one.turned for one in first.blows)
        if turned <= _TURNED or swung.surge > _THROUGH:
            return replace(first, surge=swung.surge)
    return StruckCycle(swung.blows, swung, swung.surge)


def _struck(
    design: Design, cycle: loads.CycleLoads, met: Sequence[tuple[str, loads.Contact, int]]
) -> StruckCycle:
    """The blows of a cycle that goes on after each as if slowly."""
    elastic, _, _ = with_sections(design, cycle)
    _, inertia, known = driven(design, design.cycles[cycle.name].run.pace)
    found: list[loads.BlowLoads] = []
    for name, law, k in sorted(met, key=lambda one: one[2]):
        assert law.struck is not None
        damping, held = design.dynamics.damping, inertia if known else inf
        found.append(loads.blow_loads(cycle, elastic, name, k, law.struck, damping, held))
    return StruckCycle(tuple(found))


def blows_of(
    design: Design, cycle: loads.CycleLoads, solved: StruckCycle | None = None
) -> list[BlowSummary]:
    """Every blow of a solved cycle, in the order in which they come.

    solved  its blows whose forces are known; of a swing the hardest

    A contact that appears with a phase, or in which a cycle begins, is not met on the way and no
    blow; nor is one that comes into touch by a deflection while it goes away.
    """
    shown = shown_position(design.cycles[cycle.name], cycle.positions)
    found: list[BlowSummary] = []
    swung = None if solved is None else solved.swung
    forces = {} if solved is None else {one.row: one for one in solved.blows}
    for name, law, k in _met(design.cycles[cycle.name], cycle):
        summary = _summary(design, cycle, name, law, k, float(shown[k]))
        one = forces.get(k)
        if swung is not None:
            if found:
                continue  # the swing has its own
            one = max(swung.blows, key=lambda one: _force(one, swung).peak, default=None)
        if one is not None:
            summary = replace(
                summary,
                time=float(one.loads.times[0]),
                at=float(shown[one.row]),
                speed=one.speed,
                solved=_force(one, swung),
            )
        found.append(summary)
    return sorted(found, key=lambda one: one.time)


def _met(stated: Cycle, cycle: loads.CycleLoads) -> Iterator[tuple[str, loads.Contact, int]]:
    """Force, law and row of every contact that is met at a speed."""
    for name, contact in cycle.contacts.items():
        for k in contact.begins.tolist():
            law = stated.run.phases[int(cycle.phase_of[k + 1])].given[name]
            assert isinstance(law, loads.Contact)
            if np.isfinite(cycle.touches[name].gap[k]) and law.side * contact.rate[k] < 0.0:
                yield name, law, k


def blow_gates(blows: Blows) -> list[Gate]:
    """Validity checks of blows."""
    return [gate for name, one in blows.items() for gate in _gates(name, one)]


def swing_gates(ends: Sequence[Blows]) -> list[Gate]:
    """Validity checks of swings at the ends of doubts: the worst of each cycle, if it fails."""
    found: dict[str, Gate] = {}
    for blows in ends:
        for name, one in blows.items():
            if one.swung is None:
                continue
            gate = _repeats(f"{name}: swing that repeats, at the ends of doubts", one.swung.swing)
            if not gate.holds and (name not in found or gate.value > found[name].value):
                found[name] = gate
    return list(found.values())


def _repeats(name: str, swing: loads.Swing) -> Gate:
    return Gate(
        name,
        swing.changed,
        _REPEATS,
        "how far the linkage begins its next cycle otherwise, over its largest deformation, "
        f"after {swing.turns} cycles: beyond the limit no blow is as the one before, and loads may "
        "be larger than told",
        cure="A workpiece that yields (blow.yields), or more damping (dynamics.damping), lets the "
        "linkage come to rest on it",
    )


def _gates(name: str, struck: StruckCycle) -> Iterator[Gate]:
    missing = [one.blow.missing for one in struck.blows]
    if struck.swung is not None:
        missing.append(struck.swung.swing.missing)
        yield _repeats(f"{name}: swing that repeats", struck.swung.swing)
        yield Gate(
            f"{name}: modes in the swing",
            struck.swung.still,
            _STILL,
            "share of what gives way at the contact in modes that are not among those that swing",
        )
        yield Gate(
            f"{name}: pose in the swing",
            struck.swung.turned,
            _TURNED,
            "by how much the linkage gives way otherwise at later poses in touch than at the "
            "first, over the way that it presses: modes and stiffness are those of the touch",
            cure="A stiffer linkage (elastic), or a workpiece that is met at a later pose",
        )
    if struck.surge:
        yield Gate(
            f"{name}: speed of the drive in the swing",
            struck.surge,
            _SURGE,
            "range of the work that the swing by the blows asks of the drive over twice its "
            "kinetic energy: beyond the limit the drive does not keep the speed of the cycle"
            + (", and the loads have the first blow alone" if struck.swung is None else ""),
            cure="A larger drive.flywheel",
        )
    yield Gate(
        f"{name}: energy of the blow",
        max(missing),
        _MISSING,
        "energy that is not accounted for, over what the drive and the motion gave",
    )
    if not struck.blows:
        return
    yield Gate(
        f"{name}: modes in the blow",
        max(one.blow.unresolved for one in struck.blows),
        1.0,
        "three periods of the fastest mode over the time of contact: more, and the lumped masses "
        "are too few for it",
        cure="State how far the workpiece and what lies beneath it give way (blow.stiffness), "
        "also beside blow.yields: on a stiff one all is over too soon",
    )
    if struck.swung is not None:
        return
    yield Gate(
        f"{name}: pose in the blow",
        max(one.turned for one in struck.blows),
        _TURNED,
        "change of the struck point's speed over the drive's, while it presses in",
    )


def blow_subject(
    design: Design, solved: Mapping[str, loads.CycleLoads], struck: Blows | None = None
) -> str:
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
            swings = all(one.swung for one in (struck or {}).values())
            after = _WAVES if struck and swings else _AFTER
            after = f"{after}, {_LEAVES}" if packs else after
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


def _force(struck: loads.BlowLoads, swung: loads.SwungCycle | None) -> BlowForceSummary:
    """A blow's force over time, in figures; one of those of a swing.

    Where the drive still presses on at the end of its moments the swing has the rest.
    """
    blow = struck.blow
    found = BlowForceSummary(
        peak=float(blow.force.max()),
        contact=blow.contact,
        depth=blow.depth,
        energy=blow.energy,
        rebound=blow.rebound,
        until=float(blow.times[-1]),
        count=0 if swung is None else len(swung.swing.strikes),
        joints={
            name: float(np.hypot(*load.force.T).max())
            for name, load in struck.loads.reactions.items()
        },
    )
    if swung is None or not isinf(blow.contact):
        return found
    start, times = float(struck.loads.times[0]), swung.loads.times
    first = int(np.searchsorted(times, start, "right"))
    pressing = np.append(swung.swing.force[first:] > 0.0, False)
    last = first + int(pressing.argmin())
    rows = slice(first, last)
    peak = max([found.peak, *swung.swing.force[rows].tolist()])
    return replace(
        found,
        peak=peak,
        depth=swung.swing.depth,
        energy=peak * swung.swing.depth,
        contact=float(times[last]) - start if last < len(times) else inf,
        until=max(found.until, float(times[min(last, len(times) - 1)]) - start),
        joints={
            name: max([force, *np.hypot(*swung.loads.reactions[name].force[rows].T).tolist()])
            for name, force in found.joints.items()
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
