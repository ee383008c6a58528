"""Starts and stops of a design as cycles: solved, told, and their energy balanced."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import loads
from ballesta.machine.solved_cycles import linkage_of
from checks.design.data import Cycle, Design
from checks.design.errors import DesignError, NumericsError
from checks.part.part_loads import shown_name, shown_position
from geometry.mesh import FloatArray
from reports.loads_figures import EventFigures

Masses = Mapping[str, tuple[float, tuple[float, float], float]]


def with_events(
    design: Design,
    masses: Masses,
    compliances: Mapping[str, loads.MatrixCompliance] | None = None,
) -> Design:
    """Return the design with its events among its cycles.

    Raises DesignError where a start stalls or a stop does not end, NumericsError where none is
    found.
    """
    cycles = dict(design.cycles)
    for name, event in design.events.items():
        cycle = design.cycles[event.cycle]
        linkage = linkage_of(design, masses, cycle, compliances)
        try:
            solved = loads.solve_event(name, linkage, cycle.run, event)
        except loads.UnsettledError as error:
            raise NumericsError(
                str(error),
                f"{design.file}: events.{name}",
                "a larger drive.flywheel steadies the speed",
            ) from error
        except loads.LinkageError as error:
            raise DesignError(design.file, f"events.{name}", str(error)) from error
        cycles[name] = Cycle(solved.cycle, cycle.shown, None, cycle.friction, (), solved)
    return replace(design, cycles=cycles)


def event_figures(design: Design, cycle: loads.CycleLoads) -> EventFigures | None:
    """Return the figures of a cycle that is an event; None for any other."""
    stated = design.cycles[cycle.name]
    if stated.event is None:
        return None
    event, run = design.events[cycle.name], stated.event
    name, unit = shown_name(stated)
    return EventFigures(
        kind=event.kind,
        cycle=event.cycle,
        shown_name=name,
        unit=unit,
        at=float(shown_position(stated, np.array([run.at]))[0]),
        tried=len(run.tried) if event.at is None else 0,
        time=run.time,
        turns=run.turns,
        force=run.force,
        steady_force=run.steady[0],
        torque=run.torque,
        steady_torque=run.steady[1],
        missing=_missing(design, cycle, event),
    )


def _missing(design: Design, cycle: loads.CycleLoads, event: loads.Event) -> float:
    """Energy that motor, brake, linkage and flywheel do not agree on, over what is turned over."""
    base = design.cycles[event.cycle].run.pace
    run = design.cycles[cycle.name].run
    assert isinstance(base, loads.MotorPace)
    assert isinstance(run.pace, loads.RunPace)
    drive = run.phases[0].solve
    speed = np.abs(cycle.rate(drive))
    sign = cycle.linkage.force(drive).sign * np.sign(cycle.slope(drive))
    taken = sign * cycle.efforts[drive]
    given = np.array([base.motor.torque(float(v))[0] if event.drives else 0.0 for v in speed])
    braked = np.array([name.endswith("braked") for name in cycle.phases])[cycle.phase_of]
    given = given - np.where(braked, event.torque, 0.0)

    way = np.abs(np.array(run.spans)[cycle.phase_of, 0] - cycle.positions)
    kept = 0.5 * run.pace.inertia * float(speed[-1] ** 2 - speed[0] ** 2)
    whole = summed(cycle, np.abs(given), way) + summed(cycle, np.abs(taken), way) + abs(kept)
    return abs(summed(cycle, given - taken, way) - kept) / whole if whole else 0.0


def summed(cycle: loads.CycleLoads, values: FloatArray, over: FloatArray) -> float:
    """Integral of values (n,) over a time or way (n,), by parabolas within each phase."""
    from scipy.integrate import simpson

    rows = [cycle.phase_of == k for k in range(len(cycle.phases))]
    return float(sum(simpson(values[row], x=over[row]) for row in rows))


def event_assumptions(design: Design) -> list[tuple[str, str]]:
    """Places of events that the design does not state, key and reason."""
    found = []
    for name, cycle in design.cycles.items():
        if cycle.event is not None and design.events[name].at is None:
            shown, unit = shown_name(cycle)
            at = float(shown_position(cycle, np.array([cycle.event.at]))[0])
            found.append(
                (
                    f"events.{name}.at",
                    f"none is stated: {shown} = {at:.4g} {unit}, with the largest joint force of "
                    f"{len(cycle.event.tried)} places of a turn",
                )
            )
    return found
