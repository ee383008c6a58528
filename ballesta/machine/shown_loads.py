"""Solved cycles as people see them: shown positions, phases and pace in words, drives' limits."""

from itertools import pairwise

import numpy as np

import loads
from checks.design.data import ContactLaw, Cycle, Design, Law, TableLaw
from checks.part.linkage_builder import cycle_of
from checks.part.part_loads import shown_name, shown_of, shown_position
from checks.result.words import number
from reports.loads_figures import ContactStated, ShownPhase
from reports.loads_runs import ShownRun
from reports.loads_summary import ShownCycle

_FINE = 5  # digits


def shown_cycle(design: Design, cycle: loads.CycleLoads) -> ShownCycle:
    """Return a solved cycle of a design with what people call its positions and forces."""
    stated = design.cycles[cycle.name]
    name, unit = shown_name(stated)
    return ShownCycle(
        loads=cycle,
        shown_name=name,
        unit=unit,
        shown=shown_position(stated, cycle.positions),
        pace=_pace(design, stated),
        duty=design.duty.cycles.get(cycle.name, 0.0),
        phases=_phases(design, cycle, stated),
        available={
            force.name: force.limits for force in design.forces.values() if force.limits is not None
        },
        allowed_irregularity=design.irregularity,
        stated=_contacts(stated),
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


def _contacts(stated: Cycle) -> dict[str, ContactStated]:
    """The contacts as the design has them; a force may have another one in another phase."""
    laws: dict[str, list[ContactLaw]] = {}
    for phase in stated.phases:
        for force, law in phase.given.items():
            if isinstance(law, ContactLaw):
                laws.setdefault(force, []).append(law)
    return {
        force: ContactStated(
            str(found[0].coordinate), tuple(dict.fromkeys(law.at for law in found))
        )
        for force, found in laws.items()
    }


def _phases(design: Design, cycle: loads.CycleLoads, stated: Cycle) -> tuple[ShownPhase, ...]:
    run = cycle_of(design, stated)
    ends = shown_position(stated, np.array([run.start, *(phase.stop for phase in run.phases)]))
    return tuple(
        ShownPhase(
            phase.name,
            float(start),
            float(stop),
            phase.solve,
            tuple(_law(cycle.linkage, name, law) for name, law in phase.given.items()),
        )
        for phase, (start, stop) in zip(stated.phases, pairwise(ends), strict=True)
    )


def _law(linkage: loads.Linkage, name: str, law: Law) -> str:
    """A given force in words."""
    angular = linkage.force(name).coordinate.angular
    per_1e3, unit = (1e-3, "N m") if angular else (1.0, "N")
    if isinstance(law, TableLaw):
        low, high = min(law.forces) * per_1e3, max(law.forces) * per_1e3
        return (
            f"{name} {number(low, 4)} ... {number(high, 4)} {unit} in a table over {law.coordinate}"
        )
    if isinstance(law, ContactLaw):
        stiffness = "rigid" if law.stiffness is None else f"{number(law.stiffness, 4)} N/mm"
        return f"{name} touches at {law.coordinate} = {law.at:.{_FINE}g} mm ({stiffness})"
    return f"{name} {law * per_1e3:.6g} {unit}"


def _pace(design: Design, stated: Cycle) -> str:
    pace = cycle_of(design, stated).pace
    unit = "rad" if pace.coordinate.angular else "mm"
    if isinstance(pace, loads.StrokePace):
        rest = f"from rest to rest in {number(pace.time)} s a stroke"
        return f"{stated.pace.coordinate} {pace.law} {rest}"
    rising = f", changing by {pace.acceleration:.4g} {unit}/s2" if pace.acceleration else ""
    return f"{stated.pace.coordinate} at {pace.speed:.4g} {unit}/s{rising}"
