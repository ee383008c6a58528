"""Warnings about the machine rather than its parts: drive, cycle time, stop, assembly."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

import loads
from ballesta.machine.drive_speed import shown_cycle
from ballesta.machine.solved_cycles import linkage_of
from checks.design.data import Cycle, Design, Part
from checks.part.part_loads import (
    interface_distance,
    is_loaded,
    part_placing,
    shown_name,
    shown_position,
)
from checks.result.verdict import PartResult
from checks.result.words import quantity_unit
from geometry.closed_form import closed_body
from geometry.mesh import MassProperties
from geometry.parts import Pin
from geometry.parts.pin import as_pin

_ARM = 1e-3  # mm, of the largest force or effort: a smaller couple is none
_BEYOND = 0.05  # of a part's largest force: less inertia of what it does not have is not told
_HALF_TURN = 180.0 + 1e-6  # deg
_STATED = 1e-3  # mm, how exactly points are usually stated
_FAR = 3.0  # diameters of its hole that a plate beside another may stand away
_ROUND_OFF = 1e-6
_THIN = 0.1  # of a pin's diameter, by which its friction's may be less
_RESERVE = 0.10  # of a drive's available force; less is worth a warning


def design_warnings(
    design: Design,
    masses: Mapping[str, tuple[float, tuple[float, float], float]],
    solved: Mapping[str, loads.CycleLoads | loads.MeasuredLoads],
) -> list[str]:
    """Everything about drive, cycle and assembly that a designer should act on, in words."""
    computed = {n: cycle for n, cycle in solved.items() if isinstance(cycle, loads.CycleLoads)}
    return [
        *(
            []
            if design.duty.cycles
            else ["no cycle stands in the duty: fatigue was not checked, and a PASS leaves it open"]
        ),
        *load_warnings(design, masses, computed),
        *_assembly(design, solved),
        *_short_columns(design),
        *_thin_friction(design),
        *_masses_beyond(design, masses, solved),
    ]


def _thin_friction(design: Design) -> list[str]:
    """Pins whose friction is stated on a diameter well below their own, so that couples lack."""
    stated = [design.friction, *(cycle.friction for cycle in design.cycles.values())]
    warnings = []
    for pin in design.parts.values():
        shape = as_pin(pin.geometry)
        if shape is None or pin.joint is None:
            continue
        least = min(shape.neck(seat) for seat in shape.seats)
        names = [joint.name for joint in design.joints.get(pin.joint, ())]
        radii = [own[name].radius for own in stated if own for name in names if name in own]
        if radii and 2 * min(radii) < (1 - _THIN) * least:
            warnings.append(
                f"{pin.joint}: its friction is stated on a diameter of {2 * min(radii):g} mm, "
                f"{pin.name} has {least:g} mm, whose couple is {least / 2 / min(radii):.3g} times "
                "as large; is it a rolling bearing?"
            )
    return warnings


def _masses_beyond(
    design: Design,
    masses: Mapping[str, tuple[float, tuple[float, float], float]],
    solved: Mapping[str, loads.CycleLoads | loads.MeasuredLoads],
) -> list[str]:
    """Parts whose body states another mass, with the inertia that no place of the part has.

    Of parts from CAD the solid tells the acceleration that stands for it.
    """
    from fem.unit_loads import inertia_of  # loads alone need nothing that meshes or solves

    warnings = []
    for part in design.parts.values():
        body, solid = part.body, closed_body(part.geometry)
        if body is None or body not in masses or solid is None:
            continue
        if design.stated_masses[body] == (None, None, None):
            continue
        own = part_placing(design, part).to_body(solid.mass_properties(part.material.density))
        mine, whole = (
            MassProperties(mass, np.array([*centre, 0.0]), inertia)
            for mass, centre, inertia in (own, masses[body])
        )
        rest = inertia_of(whole) - inertia_of(mine)
        rest[2] += np.array([mine.centre[1], -mine.centre[0]]) @ rest[:2]  # about its own centre
        force = largest = 0.0
        for run in solved.values():
            if not is_loaded(part, run):
                continue
            every = {point: point for point in design.bodies[body].points}
            history = run.part_history(body, every)
            left = history.accelerations @ rest.T
            couple = float(np.abs(left[:, 2]).max()) / part.geometry.length
            force = max(force, float(np.hypot(*left[:, :2].T).max()), couple)
            largest = max(largest, float(np.hypot(*history.wrenches.T[:2]).max()))
        if force > _BEYOND * largest > 0.0:
            warnings.append(
                f"{part.name}: {body} is stated with {whole.mass * 1e3:.3g} kg, the part has "
                f"{mine.mass * 1e3:.3g} kg. Inertia of up to {design.load_factor * force:.3g} N, "
                f"{100 * force / largest:.2g} % of its largest force, is of what the part does not "
                "have, and is spread along it: where that sits in one place sections beside it "
                "carry up to about as much more, which is in no error bar"
            )
    return warnings


def _short_columns(design: Design) -> list[str]:
    """Effective lengths below what any ends give that only hold the part sideways."""
    warnings = []
    for part in design.parts.values():
        if part.body is None or not part.geometry.sections:
            continue
        least = interface_distance(design, part) / 2
        for plane in ("in_plane", "out_of_plane"):
            length = getattr(part.column, plane)
            if length is not None and length < (1 - _ROUND_OFF) * least:
                warnings.append(
                    f"{part.name}: column.{plane} = {length:.4g} mm is less than half the distance "
                    f"between its pins, {least:.4g} mm, which even clamped ends have: is it guided "
                    "in between?"
                )
    return warnings


def load_warnings(
    design: Design,
    masses: Mapping[str, tuple[float, tuple[float, float], float]],
    solved: Mapping[str, loads.CycleLoads],
) -> list[str]:
    """Warnings of the loads alone, beside their gates: small reserves, assumed stops."""
    return [
        *_assembly_gap(design, masses),
        *_turns_apart(design),
        *_drives(design, solved),
        *_open_cycles(design, solved),
        *_couples_that_rub(solved),
        *stop_warnings(design, solved),
        *dead_centre_warnings(design, solved),
    ]


def _assembly_gap(
    design: Design, masses: Mapping[str, tuple[float, tuple[float, float], float]]
) -> list[str]:
    """Say where the stated points do not meet; the linkage is closed by moving its bodies."""
    if not design.bodies or not design.cycles:
        return []
    linkage = linkage_of(design, masses)
    joint, gap = loads.assembly_gap(linkage)
    if gap <= _STATED:
        return []
    return [
        f"the stated points leave joint {joint} open by {gap:.3g} mm; the bodies were moved and "
        "turned until it closed"
    ]


def _turns_apart(design: Design) -> list[str]:
    """Formulas of angles that are more than half a turn apart where the linkage is assembled."""
    warnings: dict[str, None] = {}
    for cycle in design.cycles.values():
        for phase in cycle.run.phases:
            for name, law in phase.given.items():
                if not isinstance(law, loads.Expression):
                    continue
                angles = {body: math.degrees(design.assembled[body][2]) for body in law.turned}
                if angles and max(angles.values()) - min(angles.values()) > _HALF_TURN:
                    told = " and ".join(f"{body}.angle = {a:.4g} deg" for body, a in angles.items())
                    warnings[
                        f"{name}: its formula has {told} where the linkage is assembled, more than "
                        "half a turn apart: angles are from -180 to 180 deg there, and go on from "
                        "that; must 360 deg be added to one?"
                    ] = None
    return list(warnings)


def unloaded_warnings(results: Sequence[PartResult]) -> list[str]:
    """Warnings of parts that pass because no load acts on them."""
    return [
        f"{result.name}: nothing loads it in any cycle, so a pass says nothing about its "
        "strength: is a force or a mass of 0 meant, or a column of the wrong unit?"
        for result in results
        if result.checks and not any(check.value for check in result.checks)
    ]


def solver_warnings(results: Sequence[PartResult]) -> list[str]:
    """Parts that were solved by the solver of last resort, what that costs and how to cure it."""
    slow = {
        result.name: mesh["solver"]
        for result in results
        for mesh in result.meshes
        if str(mesh.get("solver")).startswith("SuperLU")
    }
    if not slow:
        return []
    solver = next(iter(slow.values()))
    return [
        f"{', '.join(slow)}: solved by SciPy's {solver}, for there is neither CHOLMOD nor PARDISO: "
        "the same numbers in 4 to 11 times the time of the solve and up to 7 times its memory. "
        'Cure: pip install "ballesta[pardiso]" (Windows, Linux on x86-64), elsewhere SuiteSparse '
        'and pip install "ballesta[cholmod]"'
    ]


def _drives(design: Design, solved: Mapping[str, loads.CycleLoads]) -> list[str]:
    """Warn of drives with little reserve; a lack of torque breaks a validity check instead."""
    warnings = []
    for name in design.available:
        reserves = [
            (1 - direction.needed / direction.available, direction.words, direction)
            for cycle in solved.values()
            for direction in shown_cycle(design, cycle).directions(name)
            if direction.available is not None
        ]
        if not reserves:
            continue
        reserve, words, direction = min(reserves, key=lambda entry: entry[0])
        assert direction.available is not None
        if 0 <= reserve < _RESERVE:
            angular = design.forces[name].coordinate.angular
            unit, factor = quantity_unit(angular, direction.available)
            warnings.append(
                f"{name}, {words}: {direction.available * factor:.4g} {unit} available, "
                f"{direction.needed * factor:.4g} {unit} needed: {100 * reserve:.1f} % reserve"
            )
    return warnings


def _open_cycles(design: Design, solved: Mapping[str, loads.CycleLoads]) -> list[str]:
    """Cycles of the duty that cannot follow one another as they are stated."""
    return [
        f"{name}: stands in the duty but is not closed, it ends in another pose than it starts "
        "from; loads and fatigue of the way back are not checked, unless another cycle has them"
        for name, cycle in solved.items()
        if name in design.duty.cycles
        and design.cycles[name].event is None
        and not shown_cycle(design, cycle).closed
    ]


def _couples_that_rub(solved: Mapping[str, loads.CycleLoads]) -> list[str]:
    """Guides with friction that bear couples, too, whose friction no length tells."""
    most: dict[str, tuple[float, float]] = {}
    for cycle in solved.values():
        for name, own in cycle.linkage.friction.items():
            load = cycle.reactions[name]
            couple = float(np.abs(load.moment).max())
            efforts = (float(np.abs(effort).max()) for effort in cycle.efforts.values())
            largest = max(_largest_joint_force(cycle), *efforts)
            if not own.coefficient or own.length or couple <= _ARM * largest:
                continue
            whole = (load.force**2).sum(axis=1) - load.friction_force**2
            pressed = float(np.sqrt(np.maximum(whole, 0.0)).max())
            known = most.get(name, (0.0, 0.0))
            most[name] = max(known[0], couple), max(known[1], pressed)
    return [
        f"{name}: friction of its couple of up to {couple * 1e-3:.3g} N m is left out, as no "
        "length of the guide is stated (friction.guides.length). Two bearings in a distance L "
        f"press with 2/L times the couple in all: {2 * couple / 100:.3g} N at 100 mm, beside a "
        f"force of up to {pressed:.3g} N whose friction counts. Drive and loads may be larger, "
        "and the guide may jam"
        for name, (couple, pressed) in most.items()
    ]


def _assembly(
    design: Design, solved: Mapping[str, loads.CycleLoads | loads.MeasuredLoads]
) -> list[str]:
    """Say what cannot be put together, or is modelled elsewhere than it stands."""
    warnings = []
    for part in design.parts.values():
        warnings += _far_offsets(part)
        pin = as_pin(part.geometry)
        if pin is not None:
            warnings += _necks(part.name, pin)
            for entry in part.stack:
                warnings += _cheek_offset(design, part.name, entry.body, entry.at)
        elif part.geometry.clear_width is not None:
            warnings.append(
                f"{part.name}: loaded on its end faces, neither pin nor lug is modelled"
                + _pin_too_thick(part, part.geometry.clear_width, solved)
            )
    return warnings


def _pin_too_thick(
    part: Part, clear: float, solved: Mapping[str, loads.CycleLoads | loads.MeasuredLoads]
) -> str:
    """That the thinnest pin for the load cannot pass the tube, if so.

    Double shear at 250 MPa: von Mises yield of a 650 MPa steel over a safety of 1.5.
    """
    assert part.body is not None
    force = max(
        float(np.hypot(*load.force.T).max())
        for cycle in solved.values()
        if is_loaded(part, cycle)
        for load in cycle.body_loads(part.body)
    )
    pin = float(np.sqrt(2 * force / (np.pi * 250.0)))
    if pin <= clear:
        return ""
    return (
        f"; a pin for {force / 1e3:.3g} kN needs at least {pin:.3g} mm and cannot pass the "
        f"{clear:.3g} mm between the tube's walls"
    )


def _necks(name: str, pin: Pin) -> list[str]:
    seated = pin.seated()
    for number, (seat, _, _) in enumerate(seated):
        neck = pin.neck(seat)
        if neck < pin.diameter and 0 < number < len(seated) - 1:
            return [
                f"{name}: a one-piece pin with {pin.diameter:g} mm on both sides of the "
                f"{neck:g} mm seat of {seat.name!r} cannot be put through that bore"
            ]
    return []


def _far_offsets(part: Part) -> list[str]:
    """Name forces far beside a part: a length in the wrong unit does not look wrong."""
    hole = float(getattr(part.geometry, "hole", 0.0))
    return [
        f"{part.name}: its force at {name} acts {offset:g} mm beside its middle plane, "
        f"{abs(offset) / hole:.3g} times its hole of {hole:g} mm; columns are checked without it"
        for name, offset in part.offsets.items()
        if hole and abs(offset) > _FAR * hole
    ]


def _cheek_offset(design: Design, pin: str, body: str | None, at: float) -> list[str]:
    """Name a bar whose cheeks do not stand where the pin's stack has them."""
    for part in design.parts.values():
        cheek = part.geometry.cheeks_at
        if part.body == body and body and cheek is not None and abs(cheek - at) > 0.1:
            return [
                f"{pin}: has the cheeks of {part.name} at +-{at:g} mm, the bar's tube has them "
                f"at +-{cheek:g} mm; the offset of {at - cheek:+.2f} mm is not in the "
                "bar's model"
            ]
    return []


# Warnings of assumed stops, and of dead centres that a drive pulls through.


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
