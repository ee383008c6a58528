"""Solved cycles as people see them: shown positions, phases and pace in words, drives' limits."""

from itertools import pairwise

import numpy as np

import loads
from ballesta.machine.blows import blows_of
from ballesta.machine.motor_figures import motor_figures
from checks.design.data import Cycle, Design
from checks.part.part_loads import shown_name, shown_of, shown_position
from checks.result.words import brief, number
from reports.loads_figures import ContactStated, ShownPhase
from reports.loads_runs import ShownRun
from reports.loads_summary import ShownCycle

EVEN = 0.1  # irregularity that is assumed of a drive of which nothing is stated
_FINE = 5  # digits


def shown_cycle(design: Design, cycle: loads.CycleLoads) -> ShownCycle:
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
        duty=design.duty.cycles.get(cycle.name, 0.0),
        phases=_phases(cycle, stated),
        available=design.available,
        allowed_irregularity=design.drive.irregularity or EVEN,
        stated=_contacts(cycle.linkage, stated.run),
        blows=blows_of(design, cycle),
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
    ends = shown_position(stated, np.array([run.start, *(phase.stop for phase in run.phases)]))
    return tuple(
        ShownPhase(
            phase.name,
            float(start),
            float(stop),
            phase.solve,
            tuple(_law(cycle.linkage, name, law) for name, law in phase.given.items()),
        )
        for phase, (start, stop) in zip(run.phases, pairwise(ends), strict=True)
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
    rising = f", changing by {pace.acceleration:.4g} {unit}/s2" if pace.acceleration else ""
    return f"{pace.coordinate.label} at {pace.speed:.4g} {unit}/s{rising}"
