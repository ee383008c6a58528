"""Cycles of a design solved, and the masses of its parts that they need: nothing of stress."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from time import perf_counter

import numpy as np

import loads
from checks.design.data import Cycle, Design, Part
from checks.design.errors import DesignError, NumericsError
from checks.part.part_loads import part_placing
from checks.part.too_fine import gave_up, told_of_size
from checks.store.store import Store
from checks.stress.kept_models import Models
from geometry.closed_form import closed_body
from geometry.mesh import MeshError, TooManyElementsError
from geometry.progress import expect

_PACKAGES = ("loads",)
Say = Callable[[str], None]


def part_masses(
    design: Design, models: Models, say: Say = lambda _: None
) -> dict[str, tuple[float, tuple[float, float], float]]:
    """Mass, centre and inertia of every body that has a part, in the body's frame.

    What the design states of them goes before what its part has.
    """
    masses = {}
    for part in design.parts.values():
        if part.body is None:
            continue
        say(f"{part.name}: building")
        try:
            body = models.body(part.geometry)
        except TooManyElementsError as error:
            raise told_of_size(design, part, error) from error
        except MeshError as error:
            raise gave_up(design, part, error) from error
        first, second = (body.interfaces[name].centre for name in part.geometry.interfaces[:2])
        built = float(np.linalg.norm((second - first)[:2]))
        asked = part.geometry.length  # as the linkage has it, which was compared as it was read
        if abs(built - asked) > 1e-9 * built:
            raise AssertionError(f"{part.name} was built {built} mm long")
        properties = body.mass_properties(part.material.density)
        mass, centre, inertia = part_placing(design, part).to_body(properties)
        stated = design.stated_mass(part)
        masses[part.body] = (
            mass if stated.mass is None else stated.mass,
            centre if stated.centre is None else stated.centre,
            inertia if stated.inertia is None else stated.inertia,
        )
    return masses


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
