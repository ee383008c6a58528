"""Solved cycles as people see them: shown positions, phases and pace in words, drives' limits."""

from collections.abc import Sequence

import numpy as np

import loads
from ballesta.machine.solved_cycles import event_figures, summed
from checks.design.data import Cycle, Design
from checks.part.part_loads import shown_name, shown_of, shown_position
from checks.result.words import brief, number
from geometry.mesh import FloatArray
from reports.loads_figures import BlowSummary, ContactStated, MotorFigures, ShownPhase
from reports.loads_summary import ShownCycle, ShownRun

EVEN = 0.1  # irregularity that is assumed of a drive of which nothing is stated
_FINE = 5  # digits


def shown_cycle(
    design: Design, cycle: loads.CycleLoads, blows: Sequence[BlowSummary] = ()
) -> ShownCycle:
    """Return a solved cycle with the names and units of its positions and forces."""
    stated = design.cycles[cycle.name]
    name, unit = shown_name(stated)
    return ShownCycle(
        loads=cycle,
        shown_name=name,
        unit=unit,
        shown=shown_position(stated, cycle.positions),
        pace=_pace(stated.run.pace),
        motor=motor_figures(design, cycle),
        event=event_figures(design, cycle),
        duty=design.duty.cycles.get(cycle.name, 0.0),
        phases=_phases(cycle, stated),
        available=design.available,
        allowed_irregularity=design.drive.irregularity or EVEN,
        stated=_contacts(cycle.linkage, stated.run),
        blows=blows,
    )


def shown_run(design: Design, run: loads.MeasuredLoads) -> ShownRun:
    """Return a measured run of a design as people see it."""
    name, unit, shown = shown_of(design, run.name, run)
    return ShownRun(
        loads=run,
        file=design.measured[run.name].file,
        shown_name=name,
        unit=unit,
        shown=shown,
        duty=design.duty.cycles.get(run.name, 0.0),
    )


def _contacts(linkage: loads.Linkage, run: loads.Cycle) -> dict[str, ContactStated]:
    """The contacts as the design has them; a force may have another one in another phase."""
    touched: dict[str, dict[str, list[float]]] = {}
    for phase in run.phases:
        for force, law in phase.given.items():
            if isinstance(law, loads.Contact):
                coordinate, at = _touched(linkage, force, law)
                touched.setdefault(force, {}).setdefault(coordinate, []).append(at)
    return {
        force: ContactStated(coordinate, tuple(dict.fromkeys(places)))
        for force, own in touched.items()
        for coordinate, places in own.items()
    }


def _touched(linkage: loads.Linkage, force: str, law: loads.Contact) -> tuple[str, float]:
    """Coordinate at which a contact touches, as the design states it, without the force's sign."""
    coordinate = linkage.force(force).coordinate
    way = sum(coordinate.direction) if isinstance(coordinate, loads.PointCoordinate) else 1.0
    return coordinate.label.removeprefix("-"), way * law.at


def _phases(cycle: loads.CycleLoads, stated: Cycle) -> tuple[ShownPhase, ...]:
    run = stated.run
    ends = shown_position(stated, np.array(run.spans).ravel()).reshape(-1, 2)
    return tuple(
        ShownPhase(
            phase.name,
            float(start),
            float(stop),
            float(np.ptp(cycle.times[cycle.phase_of == k])),
            phase.solve,
            tuple(_law(cycle.linkage, name, law) for name, law in phase.given.items()),
        )
        for k, (phase, (start, stop)) in enumerate(zip(run.phases, ends.tolist(), strict=True))
    )


def _law(linkage: loads.Linkage, name: str, law: loads.Law) -> str:
    """A given force in words."""
    angular = linkage.force(name).coordinate.angular
    per_1e3, unit = (1e-3, "N m") if angular else (1.0, "N")
    if isinstance(law, loads.Table):
        low, high = min(law.forces) * per_1e3, max(law.forces) * per_1e3
        over = law.coordinate.label
        return f"{name} {number(low, 4)} ... {number(high, 4)} {unit} in a table over {over}"
    if isinstance(law, loads.Expression):
        return f"{name} = {brief(law.text, 200)}"
    if isinstance(law, loads.Contact):
        stiffness = "rigid" if law.stiffness is None else f"{number(law.stiffness, 4)} N/mm"
        coordinate, at = _touched(linkage, name, law)
        return f"{name} touches at {coordinate} = {at:.{_FINE}g} mm ({stiffness})"
    if isinstance(law, loads.Opposing):
        if law.speeds:
            low, high = min(law.forces) * per_1e3, max(law.forces) * per_1e3
            size = f"{number(low, 4)} ... {number(high, 4)} {unit} in a table over its speed"
        else:
            damping = "N m s/rad" if angular else "N s/mm"
            parts = [(law.dry * per_1e3, unit), (law.viscous * per_1e3, damping)]
            size = (
                " and ".join(f"{number(part, 4)} {of}" for part, of in parts if part) or "nothing"
            )
        return f"{name} against the motion, {size}"
    return f"{name} {law * per_1e3:.6g} {unit}"


def _pace(pace: loads.Pace) -> str:
    unit = "rad" if pace.coordinate.angular else "mm"
    if isinstance(pace, loads.StrokePace):
        rest = f"from rest to rest in {number(pace.time)} s a stroke"
        return f"{pace.coordinate.label} {pace.law} {rest}"
    if isinstance(pace, loads.MotorPace):
        return f"{pace.coordinate.label} by drive.motor"
    if isinstance(pace, loads.RunPace):
        return f"{pace.coordinate.label} as it starts or stops"
    rising = f", changing by {pace.acceleration:.4g} {unit}/s2" if pace.acceleration else ""
    if pace.falling is not None:
        rising = f" as it grows, {pace.falling:.4g} {unit}/s as it falls"
    if pace.cushion:
        rising += f", braked to rest along the last {pace.cushion:g} mm of a stroke"
    return f"{pace.coordinate.label} at {pace.speed:.4g} {unit}/s{rising}"


# Speed, torque and energy of a motor over a cycle.


def motor_figures(design: Design, cycle: loads.CycleLoads) -> MotorFigures | None:
    """Return the figures of a cycle that a motor turns; None for any other."""
    stated = design.cycles[cycle.name]
    pace = stated.run.pace
    if not isinstance(pace, loads.MotorPace):
        return None
    geared = pace.motor
    drive = stated.run.phases[0].solve

    def torques(speeds: FloatArray) -> FloatArray:
        return np.array([geared.torque(float(value))[0] for value in speeds])

    at_all = np.abs(cycle.rate(drive))
    cycle = cycle.unstruck or cycle  # a motor turns on through a blow, in which poses stay
    speed = np.abs(cycle.rate(drive))
    own = np.array([geared.motor.torque(float(value) * geared.ratio)[0] for value in speed])
    shown = shown_position(stated, cycle.positions)
    slowest, fastest = int(speed.argmin()), int(speed.argmax())
    duration = float(cycle.times[-1])
    return MotorFigures(
        slowest=float(speed[slowest]),
        slowest_at=float(shown[slowest]),
        fastest=float(speed[fastest]),
        fastest_at=float(shown[fastest]),
        mean=summed(cycle, speed, cycle.times) / duration,
        largest=float(np.abs(own).max()),
        effective=float(np.sqrt(summed(cycle, own**2, cycle.times) / duration)),
        rated=geared.motor.rated_torque,
        power=summed(cycle, own * speed * geared.ratio, cycle.times) / duration,
        ratio=geared.ratio,
        missing=_missing(cycle, drive, torques(speed) * speed),
        speed=at_all,
        torque=torques(at_all),
    )


def _missing(cycle: loads.CycleLoads, drive: str, power: FloatArray) -> float:
    """Energy balance error of a turn: motor less drive, over the energy the drive turns over."""
    sign = cycle.linkage.force(drive).sign
    taken = sign * cycle.efforts[drive] * cycle.rate(drive)
    whole = summed(cycle, np.abs(taken), cycle.times)
    return abs(summed(cycle, power - taken, cycle.times)) / whole if whole else 0.0
