"""Ends of a travel beside a dead centre: the loads where it ends a little sooner or later.

Next to a dead centre the loads of rigid bodies depend on where the travel ends. What its stop is
off by at most is stated (`stop.tolerance`), so the loads at both ends of that are a doubt with
bars. Where one of them comes next to the dead centre itself no bar tells anything: the gate binds.
"""

from dataclasses import replace

import numpy as np

import loads
from ballesta.machine.load_pairs import LoadPair, Solved
from ballesta.machine.validity_checks import dead_centre_gate, is_near_dead_centre
from checks.design.data import Design
from checks.part.part_loads import shown_name

_AT_END = 1e-9  # of the travel
_LEFT = 0.2  # of the share of the motion that the solved force sees: less is the dead centre


def stop_doubts(design: Design, solved: Solved) -> list[LoadPair]:
    """The loads of every cycle that comes too near to a dead centre at a stop with a tolerance.

    None with `dynamics.apply`: what vibration adds is known at the cycle's own positions only.
    """
    found = []
    for name, cycle in solved.items():
        stop = design.cycles[name].stop
        if stop is None or design.dynamics.apply or not is_near_dead_centre(cycle):
            continue
        moved = [_moved(design, name, cycle, way * stop.tolerance) for way in (-1.0, 1.0)]
        if all(moved):
            _, unit = shown_name(design.cycles[name])
            size = float(np.degrees(stop.tolerance)) if unit == "deg" else stop.tolerance
            first, second = ({**solved, name: end} for end in moved if end is not None)
            words = f"{name}: end of its travel off by up to {size:.3g} {unit}"
            found.append(LoadPair(words, (first, second), dead_centre_gate(name)))
    return found


def _moved(
    design: Design, name: str, cycle: loads.CycleLoads, by: float
) -> loads.CycleLoads | None:
    """The cycle with the end next to the dead centre elsewhere; None where that tells nothing."""
    run = design.cycles[name].run
    worst = int(cycle.conditioning.argmin())
    at = float(cycle.positions[worst])
    ends = np.array([run.start, *(phase.stop for phase in run.phases)])
    there = np.abs(ends - at) <= _AT_END * float(np.ptp(ends))
    if not there.any():
        return None
    elsewhere = np.where(there, ends + by, ends)
    phases = tuple(
        replace(phase, stop=float(stop))
        for phase, stop in zip(run.phases, elsewhere[1:], strict=True)
    )
    try:
        found = loads.run_cycle(
            cycle.linkage, replace(run, start=float(elsewhere[0]), phases=phases)
        )
    except loads.LinkageError:
        return None
    return found if found.conditioning.min() >= _LEFT * cycle.conditioning[worst] else None
