"""Puts the cycles and the duty of a design together."""

from collections.abc import Mapping
from dataclasses import replace
from math import degrees, pi

import loads
from ballesta.design.expressions import coordinate_of, dimension_along
from ballesta.design.files import Reading, telling
from ballesta.design.forces import check_dimension
from ballesta.design.laws import law_of
from ballesta.design.linkage import friction_of
from checks.design.data import Cycle, Design, Duty, Shown, Stop
from checks.design.errors import Problems, listed, no_such
from checks.design.model import DesignFile
from checks.design.tables import Available, CycleEntry, DriveEntry, MotorEntry, PaceEntry
from checks.design.units import Measured
from checks.result.words import number
from geometry.parameters import ParameterError

_MOST_TURNS = 100  # of a body in a cycle: 5 to 7 s of walking
_MOST_TRAVEL = 1e7  # mm, 10 km


def cycles_of(read: Reading) -> dict[str, Cycle]:
    """Return the cycles whose entries are in order."""
    cycles = {}
    for name, entry in read.file.cycles.items():
        cycle = _cycle(read, name, entry)
        if cycle is not None:
            cycles[name] = cycle
    _check_gear(read.file, cycles, read.problems)
    return cycles


def duty_of(file: DesignFile, problems: Problems) -> Duty:
    """Return the duty; a cycle, event or measured run that does not exist is a problem."""
    known = (*file.cycles, *file.events, *file.measured)
    for name in file.duty.cycles:
        if name not in known:
            problems.add(f"duty.cycles.{name}", no_such("cycle", name, known))
    duty = file.duty
    if duty.damage_so_far and duty.life != "finite":
        problems.add(
            "duty.damage_so_far", 'is of a finite life only; state life = "finite", or leave it out'
        )
    elif duty.damage_so_far >= duty.allowed_damage:
        problems.add(
            "duty.damage_so_far",
            f"{duty.damage_so_far:g} leaves nothing of the allowed damage of "
            f"{duty.allowed_damage:g}",
        )
    return Duty(dict(duty.cycles), duty.rate, duty.life, duty.allowed_damage, duty.damage_so_far)


def events_of(
    file: DesignFile, cycles: Mapping[str, Cycle], problems: Problems
) -> dict[str, loads.Event]:
    """Return the events whose entries are in order."""
    found = {}
    if file.drive.brake is not None and file.drive.motor is None:
        problems.add("drive.brake", "needs drive.motor, whose events it ends; leave it out")
    for name, entry in file.events.items():
        key, told = f"events.{name}", len(problems)
        if name in file.cycles or name in file.measured:
            problems.add(key, f"{name} is the name of a cycle or measured run, too")
        if entry.cycle not in file.cycles:
            problems.add(f"{key}.cycle", no_such("cycle", entry.cycle, file.cycles))
        motor, brake = file.drive.motor, file.drive.brake
        if motor is None:
            problems.add(key, "needs drive.motor: a start or stop is that of its cycle's motor")
        drives = entry.kind == "start" or (entry.kind == "brake" and entry.motor == "on")
        if motor is not None and drives and motor.breakdown and motor.starting is None:
            problems.add(
                "drive.motor.starting",
                f"must be stated for {key}, as catalogues print it, such as 2.2: the torque of an "
                "asynchronous motor from rest does not follow from its breakdown torque",
            )
        if entry.kind == "brake" and brake is None:
            problems.add(
                "drive.brake", f'must be stated for {key}, such as {{ torque = "120 N m" }}'
            )
        if entry.kind != "start" and entry.turns is not None:
            problems.add(f"{key}.turns", "is of a start; a stop ends at rest")
        if entry.kind != "brake" and entry.motor == "on":
            problems.add(f"{key}.motor", f'is of kind = "brake", not "{entry.kind}"; leave it out')
        if entry.at is not None:
            with telling(problems, key):
                check_dimension("at", entry.at, "angle")
                _check_span("at", entry.at)
        if len(problems) > told or entry.cycle not in cycles:
            continue
        braked = brake is not None and entry.kind == "brake"
        found[name] = loads.Event(
            entry.kind,
            entry.cycle,
            None if entry.at is None else entry.at.value,
            entry.turns,
            brake.torque if braked and brake else 0.0,
            brake.delay if braked and brake else 0.0,
            entry.motor == "on",
            entry.positions,
        )
    return found


def split_cycles(design: Design) -> dict[str, Cycle]:
    """Return the cycles with phases that end where a force against the motion, or a cushion, jumps.

    A linkage that cannot go through them stays as it is: solving it tells why.
    """
    if not any(_jumps(cycle.run) for cycle in design.cycles.values()):
        return dict(design.cycles)
    found = {}
    for name, cycle in design.cycles.items():
        try:
            linkage = loads.Linkage(
                bodies=(design.ground, *design.bodies.values()),
                joints=tuple(joint for joints in design.joints.values() for joint in joints),
                forces=tuple(design.forces.values()),
                assembled=design.assembled,
            )
            run, entries = loads.split_cycle(linkage, cycle.run)
        except loads.LinkageError:
            run, entries = cycle.run, ()
        found[name] = replace(cycle, run=run, entries=entries)
    return found


def _jumps(run: loads.Cycle) -> bool:
    laws = (law for phase in run.phases for law in phase.given.values())
    brakes = isinstance(run.pace, loads.SteadyPace) and run.pace.cushion > 0.0
    return brakes or any(isinstance(law, loads.Opposing) for law in laws)


def _cycle(read: Reading, name: str, entry: CycleEntry) -> Cycle | None:
    key, problems = f"cycles.{name}", read.problems
    told = len(problems)
    swept = paced = pace = None
    with telling(problems, f"{key}.coordinate"):
        swept = coordinate_of(read, entry.coordinate)
    with telling(problems, f"{key}.pace.coordinate"):
        paced = coordinate_of(read, entry.pace.coordinate)

    def along(where: str, measured: Measured) -> float:
        if swept is not None:
            with telling(problems, key):
                check_dimension(where, measured, dimension_along(swept))
        return measured.value

    def place(where: str, measured: Measured) -> float:
        with telling(problems, key):
            _check_span(where, measured)
        return along(where, measured)

    start = place("start", entry.start)
    ends = [place(f"phases[{i}].to", phase.to) for i, phase in enumerate(entry.phases)]
    phases = _phases(read, key, entry, ends, start)
    shown, stop, friction = None, None, None
    if entry.shown is not None:
        zero = along("shown.zero", entry.shown.zero)
        shown = Shown(entry.shown.name, zero, entry.shown.sign)
    if entry.stop is not None:
        stop = Stop(entry.stop.basis, along("stop.tolerance", entry.stop.tolerance))
        if stop.tolerance < 0.0:
            problems.add(f"{key}.stop.tolerance", "must be at least 0: it counts to either side")
    if entry.friction is not None:
        friction = friction_of(f"{key}.friction", entry.friction, read.file, read.joints, problems)
    with telling(problems, f"{key}.pace"):
        pace = _pace(read, f"{key}.pace", entry.pace, paced)
        if read.file.drive.motor is not None and pace is not None:
            pace = _by_motor(pace, read.file.drive, read.file.drive.motor, problems)
    if swept is None or pace is None or len(problems) > told:
        return None
    run = loads.Cycle(name, swept, start, pace, phases, entry.positions)
    return Cycle(run, shown, stop, friction)


def _check_span(field: str, measured: Measured) -> None:
    """Refuse a place that no cycle goes to; the walk to it would take its turns one by one."""
    if measured.dimension == "angle" and not abs(measured.value) <= _MOST_TURNS * 2 * pi:
        raise ParameterError(
            field,
            f"must be within {360 * _MOST_TURNS} deg of 0, got {degrees(measured.value):g} deg; a "
            "motion that repeats is stated once, such as from 0 to 360 deg",
        )
    if measured.dimension == "length" and not abs(measured.value) <= _MOST_TRAVEL:
        raise ParameterError(
            field,
            f"must be within {_MOST_TRAVEL:g} mm of 0, as any machine's travel, got "
            f"{measured.value:g} mm; is its unit wrong?",
        )


def _pace(
    read: Reading, key: str, entry: PaceEntry, coordinate: loads.Coordinate | None
) -> loads.Pace | None:
    stated = [name for name in ("speed", "flow", "law") if getattr(entry, name) is not None]
    if len(stated) > 1:
        raise ParameterError("", f"has {listed(stated)}; a stroke runs by one of them")
    if not stated:
        turns = coordinate is not None and coordinate.angular
        such = '"60 rpm"' if turns else '"0.1 m/s", flow such as "40 l/min"'
        raise ParameterError("", f'needs speed such as {such}, or law and time, "1.5 s"')
    if entry.acceleration is not None and entry.speed is None:
        read.problems.add(f"{key}.acceleration", f"follows from the {stated[0]}; leave it out")
    if entry.law is not None and entry.time is None:
        raise ParameterError("time", 'must be stated such as "1.5 s": of each stroke')
    if entry.law is None and entry.time is not None:
        read.problems.add(f"{key}.time", "is only used with law; leave it out")
    if entry.flow is None and entry.cushion is not None:
        read.problems.add(f"{key}.cushion", "is only used with flow; leave it out")
    if coordinate is None:
        return None
    angular = "angular " if coordinate.angular else ""
    for field, dimension in (("speed", "speed"), ("acceleration", "acceleration")):
        measured = getattr(entry, field)
        if measured is not None:
            with telling(read.problems, key):
                check_dimension(field, measured, angular + dimension)
    if entry.law is not None and entry.time is not None:
        return loads.StrokePace(coordinate, entry.law, entry.time)
    if entry.flow is not None:
        return _filled(read.file, entry, entry.flow, coordinate)
    assert entry.speed is not None
    acceleration = entry.acceleration.value if entry.acceleration else 0.0
    return loads.SteadyPace(coordinate, entry.speed.value, acceleration)


def _filled(
    file: DesignFile, entry: PaceEntry, flow: float, coordinate: loads.Coordinate
) -> loads.Pace | None:
    """Return the pace of a cylinder: a flow fills the piston's side or, as it pulls, the rod's."""
    name = entry.coordinate
    force = file.forces.get(name.removesuffix(".length"))
    size = None if force is None else force.available
    if not isinstance(size, Available) or size.bore is None or size.rod is None:
        raise ParameterError(
            "flow",
            "is for the length of a force between two points whose `available` has bore and rod, "
            f"not for {name}",
        )
    if size.rod >= size.bore:
        return None  # told with `available`
    piston, rod = (pi * diameter**2 / 4 for diameter in (size.bore, size.rod))
    pulls = flow / (piston - rod)
    return loads.SteadyPace(coordinate, flow / piston, falling=pulls, cushion=entry.cushion or 0.0)


def _check_gear(file: DesignFile, cycles: Mapping[str, Cycle], problems: Problems) -> None:
    """Note that cycles of several speeds do not say which gear the machine has."""
    paces = [cycle.run.pace for cycle in cycles.values()]
    speeds = sorted({pace.steady.speed for pace in paces if isinstance(pace, loads.MotorPace)})
    motor = file.drive.motor
    if motor is not None and motor.ratio is None and len(speeds) > 1:
        gears = [f"{number(motor.speed / speed)} for {speed:g} rad/s" for speed in speeds]
        problems.add(
            "drive.motor.ratio",
            f"must be stated where cycles have different speeds; {' and '.join(gears)} bring the "
            "rated speed",
        )


def _by_motor(
    pace: loads.Pace, drive: DriveEntry, entry: MotorEntry, problems: Problems
) -> loads.Pace | None:
    """Return the pace that the machine's motor sets to a cycle; raises ParameterError."""
    if not isinstance(pace, loads.SteadyPace) or not pace.coordinate.angular:
        raise ParameterError("", "must be the speed of an angle, which drive.motor turns")
    ratio = entry.speed / pace.speed if entry.ratio is None else entry.ratio
    try:
        motor = loads.Motor(
            entry.power / entry.speed,
            entry.speed,
            entry.free_speed,
            entry.breakdown,
            entry.torque_limit,
            entry.starting,
        )
        geared = loads.Geared(motor, ratio, entry.efficiency, entry.inertia)
    except loads.LinkageError as error:
        problems.add("drive.motor", str(error))
        return None
    try:
        return loads.MotorPace(pace, geared, drive.flywheel or 0.0)
    except loads.LinkageError as error:
        raise ParameterError("", str(error)) from error


def _phases(
    read: Reading, key: str, entry: CycleEntry, ends: list[float], start: float
) -> tuple[loads.Phase, ...]:
    file, problems = read.file, read.problems
    phases: list[loads.Phase] = []
    for index, (phase, end) in enumerate(zip(entry.phases, ends, strict=True)):
        here = f"{key}.phases[{index}]"
        if end == (ends[index - 1] if index else start):
            problems.add(f"{here}.to", f"phase {phase.name!r} ends where it starts")
        if phase.name in [earlier.name for earlier in phases]:
            problems.add(f"{here}.name", f"{phase.name!r} is there twice")
        given: dict[str, loads.Law] = {}
        for force, entered in phase.forces.items():
            if force not in file.forces:
                problems.add(f"{here}.forces.{force}", no_such("force", force, file.forces))
                continue
            at = f"{here}.forces.{force}"
            law = law_of(read, at, force, entered)
            if law is None:
                continue
            others = [name for name, other in given.items() if isinstance(other, loads.Contact)]
            if others and isinstance(law, loads.Contact):
                problems.add(at, f"is a second contact beside {others[0]}; a phase can have one")
            given[force] = law
        if phase.solve not in file.forces:
            problems.add(f"{here}.solve", no_such("force", phase.solve, file.forces))
        elif phase.solve in phase.forces:
            problems.add(
                f"{here}.solve",
                f"phase {phase.name!r} both gives and solves {phase.solve}; it can only do one",
            )
        named = {*phase.forces, phase.solve}
        for force in file.forces if named <= file.forces.keys() else ():  # else it may be misspelt
            if force not in named:
                rest = "0 N" if file.forces[force].turns is None else "0 N m"
                problems.add(
                    f"{here}.forces",
                    f"phase {phase.name!r} leaves {force} neither given nor solved; "
                    f'state it, {force} = "{rest}" when it rests',
                )
        phases.append(loads.Phase(phase.name, end, given, phase.solve))
    return tuple(phases)
