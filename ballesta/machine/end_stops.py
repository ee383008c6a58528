"""Warnings of assumed stops, and of dead centres that a drive pulls through."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import loads
from checks.design.data import Cycle, Design
from checks.part.part_loads import shown_name, shown_position


def stop_warnings(design: Design, solved: Mapping[str, loads.CycleLoads]) -> list[str]:
    """Warn of the largest load if an assumed stop is passed by its tolerance."""
    warnings, told = [], set()
    for cycle in design.cycles.values():
        if cycle.stop is None or cycle.stop.basis != "assumed":
            continue
        run = cycle.run
        ends = [run.start, *(phase.stop for phase in run.phases)]
        forward = int(np.argmax(np.abs(np.array(ends) - run.start)))
        end = ends[forward]
        if (run.coordinate, end) in told:
            continue
        told.add((run.coordinate, end))
        further = end + np.sign(end - run.start) * cycle.stop.tolerance
        phase = run.phases[forward - 1]
        beyond_it = (replace(phase, stop=float(further)),)
        longer = replace(run, start=ends[forward - 1], phases=beyond_it, n_positions=40)
        shown, unit = shown_name(cycle)
        at, there = (
            round(float(shown_position(cycle, np.array([v]))[0]), 9) + 0.0 for v in (end, further)
        )
        now = _largest_joint_force(solved[run.name])
        said = f"{run.name}: the stop at {shown} = {at:.4g} {unit} is ASSUMED; "
        through = _pulled_through(cycle, phase, solved[run.name])
        try:
            beyond = loads.run_cycle(solved[run.name].linkage, longer)
            after = _largest_joint_force(beyond)
            warnings.append(
                f"{said}at {shown} = {there:.4g} {unit} the largest joint force is "
                f"{after / 1e3:.3g} kN instead of {now / 1e3:.3g} kN{through}"
            )
        except loads.LinkageError as error:
            warnings.append(
                f"{said}{shown} = {there:.4g} {unit} cannot be: the loads grow "
                f"without bound on the way there ({error}){through}"
            )
    return warnings


def _largest_joint_force(cycle: loads.CycleLoads) -> float:
    return max(
        float(np.hypot(load.force[:, 0], load.force[:, 1]).max())
        for load in cycle.reactions.values()
    )


def _pulled_through(cycle: Cycle, phase: loads.Phase, run: loads.CycleLoads) -> str:
    """Say below which stiffness the drive pulls the linkage through its dead centre, if it can."""
    constant = {name: law for name, law in phase.given.items() if isinstance(law, float)}
    drives = [
        name
        for name, size in constant.items()
        if size and isinstance(run.linkage.force(name).coordinate, loads.Distance)
    ]
    if len(drives) != 1 or len(constant) < len(phase.given):
        return ""
    (drive,) = drives
    others = {name: size for name, size in constant.items() if name != drive}
    last = int(np.flatnonzero(run.phase_of == cycle.run.phases.index(phase))[-1])
    try:
        touch = float(run.coordinate(phase.solve)[last])
        found = loads.pull_through(run.linkage, drive, constant[drive], phase.solve, touch, others)
    except loads.LinkageError:
        return ""  # the linkage cannot go on from there: told by the travel beyond the stop
    if found is None:
        return ""
    return (
        f". Nothing else stops it: where all that {phase.solve} meets there (workpiece, frame and "
        f"parts in series) is softer than {found.stiffness / 1e3:.3g} kN/mm, "
        f"{abs(constant[drive]) / 1e3:.4g} kN of {drive} pull the linkage through its dead "
        f"centre, and {phase.solve} reaches up to {found.force / 1e3:.3g} kN"
    )


def dead_centre_warnings(design: Design, solved: Mapping[str, loads.CycleLoads]) -> list[str]:
    """Warnings of cylinders that pull a linkage through a contact's dead centre, or jam before.

    A crank is meant to pass its dead centres; of a drive without a stated limit nothing is known.
    """
    warnings = []
    for name, run in solved.items():
        for contact, touch in run.touches.items():
            slope = run.slope(contact)
            passed = np.flatnonzero((slope[1:] * slope[:-1] <= 0.0) & touch.touching[1:])
            if not len(passed):
                continue
            drive = design.cycles[name].run.phases[int(run.phase_of[passed[0]])].solve
            limits = design.available.get(drive)
            if limits is None or run.linkage.force(drive).coordinate.angular:
                continue
            needed = np.where(touch.touching, run.efforts[drive], 0.0)[: passed[0] + 2]
            worst = int(np.argmax(np.abs(needed)))
            limit = limits[0 if needed[worst] > 0 else 1]
            shown, unit = shown_name(design.cycles[name])
            place = shown_position(design.cycles[name], run.positions)
            at = f"{shown} = {place[worst]:.4g} {unit}"
            if abs(needed[worst]) <= limit:
                warnings.append(
                    f"{name}: nothing stops the linkage: {drive} needs "
                    f"{abs(needed[worst]) / 1e3:.4g} kN at most ({at}), has {limit / 1e3:.4g} kN "
                    f"and pulls it through the dead centre of {contact}, which reaches "
                    f"{np.abs(run.efforts[contact]).max() / 1e3:.3g} kN"
                )
            else:
                stuck = int(np.argmax(np.abs(needed) > limit))
                warnings.append(
                    f"{name}: {drive} has {limit / 1e3:.4g} kN and jams at {shown} = "
                    f"{place[stuck]:.4g} {unit}; the loads beyond need "
                    f"{abs(needed[worst]) / 1e3:.4g} kN ({at})"
                )
    return warnings
