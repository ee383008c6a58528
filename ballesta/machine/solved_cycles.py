"""Cycles of a design solved, with its starts and stops, and the masses of its parts they need.

Nothing of stress.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from time import perf_counter

import numpy as np

import loads
from checks.design.data import Cycle, Design, Part
from checks.design.errors import DesignError, NumericsError
from checks.part.part_loads import part_placing, pins_carried, shown_name, shown_position
from checks.store.store import Store
from checks.stress.kept_models import Models, told_of_part
from geometry.closed_form import closed_body
from geometry.mesh import FloatArray
from geometry.progress import expect
from reports.loads_figures import EventFigures

_PACKAGES = ("loads",)
Say = Callable[[str], None]


def part_masses(
    design: Design, models: Models, say: Say = lambda _: None
) -> dict[str, tuple[float, tuple[float, float], float]]:
    """Mass, centre and inertia of every body that has a part, in the body's frame.

    Of its part with the pins that turn with it. What the design states of them goes before; beside
    a stated mass the part's inertia grows with the mass.
    """
    masses = {}
    for part in design.parts.values():
        if part.body is None:
            continue
        say(f"{part.name}: building")
        with told_of_part(design, part):
            body = models.body(part.geometry)
        first, second = (body.interfaces[name].centre for name in part.geometry.interfaces[:2])
        built = float(np.linalg.norm((second - first)[:2]))
        asked = part.geometry.length  # as the linkage has it, which was compared as it was read
        if abs(built - asked) > 1e-9 * built:
            raise AssertionError(f"{part.name} was built {built} mm long")
        properties = body.mass_properties(part.material.density)
        own = part_placing(design, part).to_body(properties)
        mass, centre, inertia = _with_pins(design, part.body, own)
        stated = design.stated_mass(part)
        if stated.mass is not None:
            inertia *= stated.mass / mass
        masses[part.body] = (
            mass if stated.mass is None else stated.mass,
            centre if stated.centre is None else stated.centre,
            inertia if stated.inertia is None else stated.inertia,
        )
    return masses


def _with_pins(
    design: Design, body: str, own: tuple[float, tuple[float, float], float]
) -> tuple[float, tuple[float, float], float]:
    """Mass, centre and inertia of a body: its part's `own` and those of pins that turn with it."""
    pieces = [own]
    for pin, properties in pins_carried(design, body):
        at = design.bodies[body].points[str(pin.joint)]
        pieces.append((properties.mass, at, properties.inertia))
    if len(pieces) == 1:
        return own
    whole = sum(mass for mass, _, _ in pieces)
    x, y = (sum(mass * at[axis] for mass, at, _ in pieces) / whole for axis in (0, 1))
    about = sum(
        inertia + mass * ((at[0] - x) ** 2 + (at[1] - y) ** 2) for mass, at, inertia in pieces
    )
    return whole, (x, y), about


def linkage_of(
    design: Design,
    masses: Mapping[str, tuple[float, tuple[float, float], float]],
    cycle: Cycle | None = None,
    compliances: Mapping[str, loads.MatrixCompliance] | None = None,
) -> loads.Linkage:
    """Return the linkage of a design, with the (mass, centre, inertia) of the bodies in `masses`.

    With a cycle, under the friction of that cycle; `compliances` (ballesta.machine.elastic_parts)
    of bodies that give way as their parts, which a cycle with a contact needs. Raises
    loads.LinkageError where the linkage does not have one degree of freedom.
    """
    parts = compliances or {}
    missing = [body for body in design.as_parts if body not in parts]
    if missing and cycle is not None and cycle.has_contact:
        raise ValueError(
            f"cycle {cycle.run.name!r}: the compliance of {missing} has not been solved"
        )
    own_friction = None if cycle is None else cycle.friction
    return loads.Linkage(
        bodies=(design.ground, *design.bodies.values()),
        joints=tuple(joint for joints in design.joints.values() for joint in joints),
        forces=tuple(design.forces.values()),
        assembled=design.assembled,
        friction=design.friction if own_friction is None else own_friction,
        gravity=design.gravity,
        compliance=(*design.compliance, *parts.values()),
    ).with_mass_properties(masses)


def solve_cycles(
    design: Design,
    masses: Mapping[str, tuple[float, tuple[float, float], float]],
    compliances: Mapping[str, loads.MatrixCompliance] | None = None,
    store: Store | None = None,
) -> dict[str, loads.CycleLoads]:
    """Solve every cycle of a design; raises DesignError, LinkageError for the linkage itself.

    compliances  of bodies that give way as their parts (elastic_parts), for cycles with contacts
    store        of the loads of cycles
    """
    solved: dict[str, loads.CycleLoads] = {}
    took = 0.0
    for name, cycle in design.cycles.items():
        start = perf_counter()
        expect(f"{name}, {len(solved) + 1} of {len(design.cycles)} cycles", took)
        linkage = linkage_of(design, masses, cycle, compliances)
        with told_of_cycle(design, name):
            solved[name] = stored_loads(store, linkage, cycle.run)
        took = perf_counter() - start
    return solved


def try_cycles(design: Design) -> None:
    """Raise what `solve_cycles` would, as far as a few positions without masses tell.

    Nothing is tried where masses and compliances take no mesh: the cycles are solved as soon.
    """
    shapes = [part.geometry for part in design.parts.values() if part.body is not None]
    if not design.as_parts and all(closed_body(shape) for shape in shapes):
        return
    for name, cycle in design.cycles.items():
        linkage = linkage_of(design, {}, cycle)
        with told_of_cycle(design, name):
            loads.try_cycle(linkage, cycle.run)


@contextmanager
def told_of_cycle(design: Design, name: str) -> Iterator[None]:
    """Tell of an error which of the design's cycles it is in."""
    try:
        yield
    except loads.UnsettledError as error:
        raise NumericsError(
            str(error),
            f"{design.file}: cycles.{name}",
            "a larger drive.flywheel steadies the speed; or state drive.irregularity in place of a "
            "motor",
        ) from error
    except loads.CycleError as error:
        if design.cycles[name].event is not None:
            raise DesignError(design.file, f"events.{name}", error.problem) from error
        key = f"cycles.{name}.phases[{design.cycles[name].entry(error.phase)}]"
        raise DesignError(design.file, key, error.problem) from error
    except loads.LinkageError as error:
        raise DesignError(design.file, f"cycles.{name}", str(error)) from error


def parts_that_give(design: Design) -> Iterator[Part]:
    """Parts whose bodies give way as they do."""
    for body in design.as_parts:
        part = design.part_of(body)
        assert part is not None
        yield part


def without_unknown_contacts(design: Design) -> Design:
    """Return the design as it can be solved before any part is: without what pushes on parts.

    Contacts give no force in it, if the compliance of a part is needed to know theirs.
    """
    if not design.as_parts:
        return design
    return replace(
        design, cycles={name: _untouched(cycle) for name, cycle in design.cycles.items()}
    )


def _untouched(cycle: Cycle) -> Cycle:
    phases = tuple(
        replace(
            phase,
            given={
                force: 0.0 if isinstance(law, loads.Contact) else law
                for force, law in phase.given.items()
            },
        )
        for phase in cycle.run.phases
    )
    return replace(cycle, run=replace(cycle.run, phases=phases))


def stored_loads(
    store: Store | None, linkage: loads.Linkage, cycle: loads.Cycle
) -> loads.CycleLoads:
    """Return the loads of a cycle; raises CycleError and LinkageError."""

    def run() -> loads.CycleLoads:
        return loads.run_cycle(linkage, cycle)

    return run() if store is None else store.remember("loads", _PACKAGES, (linkage, cycle), run)


# Starts and stops of a design as cycles: solved, told, and their energy balanced.
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
