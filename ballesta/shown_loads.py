"""Solved cycles as people see them: shown positions, phases and pace in words, drives' limits."""

from itertools import pairwise

import numpy as np

import loads
from ballesta.design_data import Cycle, Design
from ballesta.machine import cycle_of
from ballesta.part_loads import shown_name, shown_position
from reports.loads_figures import ShownPhase
from reports.loads_summary import ShownCycle
from reports.words import number

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
    )


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
        for phase, (start, stop) in zip(run.phases, pairwise(ends), strict=True)
    )


def _law(linkage: loads.Linkage, name: str, law: loads.Law) -> str:
    """A given force in words."""
    angular = linkage.force(name).coordinate.angular
    per_1e3, unit = (1e-3, "N m") if angular else (1.0, "N")
    if isinstance(law, loads.Table):
        low, high = min(law.forces) * per_1e3, max(law.forces) * per_1e3
        return (
            f"{name} {number(low, 4)} ... {number(high, 4)} {unit} in a table over "
            f"{law.coordinate.label}"
        )
    if isinstance(law, loads.Contact):
        length = "rad" if angular else "mm"
        stiffness = (
            "rigid" if law.stiffness is None else f"{number(law.stiffness, 4)} {unit}/{length}"
        )
        return f"{name} touches at {law.at:.{_FINE}g} {length} ({stiffness})"
    return f"{name} {law * per_1e3:.6g} {unit}"


def _pace(design: Design, stated: Cycle) -> str:
    pace = cycle_of(design, stated).pace
    unit = "rad" if pace.coordinate.angular else "mm"
    if isinstance(pace, loads.StrokePace):
        rest = f"from rest to rest in {number(pace.time)} s a stroke"
        return f"{stated.pace.coordinate} {pace.law} {rest}"
    rising = f", changing by {pace.acceleration:.4g} {unit}/s2" if pace.acceleration else ""
    return f"{stated.pace.coordinate} at {pace.speed:.4g} {unit}/s{rising}"
