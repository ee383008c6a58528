"""Cycles of a design solved, and the masses of its parts that they need: nothing of stress."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from time import perf_counter

import numpy as np

import loads
from ballesta.supervised import expect
from checks.design.data import ContactLaw, Cycle, Design, Part
from checks.design.errors import DesignError
from checks.part.linkage_builder import cycle_of, interface_distance, linkage_of, part_placing
from checks.part.too_fine import gave_up, told_of_size
from checks.store.loads import stored_loads
from checks.store.store import Store
from checks.stress.kept_models import Models
from geometry.mesh import MeshError, TooManyElementsError
from geometry.parts.step_part import StepPart

Say = Callable[[str], None]


def part_masses(
    design: Design, models: Models, say: Say = lambda _: None
) -> dict[str, tuple[float, tuple[float, float], float]]:
    """Mass, centre and inertia of every body that has a part, in the body's frame."""
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
        asked = interface_distance(design, part)
        if isinstance(part.geometry, StepPart):
            asked = part.geometry.length  # the door has compared it with the linkage's
        if abs(built - asked) > 1e-9 * built:
            raise AssertionError(f"{part.name} was built {built} mm long")
        properties = body.mass_properties(part.material.density)
        masses[part.body] = part_placing(design, part).to_body(properties)
    return masses


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
            solved[name] = stored_loads(store, linkage, cycle_of(design, cycle))
        took = perf_counter() - start
    return solved


def try_cycles(design: Design) -> None:
    """Raise what `solve_cycles` would, as far as a few positions without masses tell."""
    for name, cycle in design.cycles.items():
        linkage = linkage_of(design, {}, cycle)
        with told_of_cycle(design, name):
            loads.try_cycle(linkage, cycle_of(design, cycle))


@contextmanager
def told_of_cycle(design: Design, name: str) -> Iterator[None]:
    """Tell of an error which of the design's cycles it is in."""
    try:
        yield
    except loads.CycleError as error:
        key = f"cycles.{name}.phases[{error.phase}]"
        raise DesignError(design.file, key, error.problem) from error
    except loads.LinkageError as error:
        raise DesignError(design.file, f"cycles.{name}", str(error)) from error


def parts_that_give(design: Design) -> Iterator[Part]:
    """Parts whose bodies give way as they do."""
    for body in design.bodies.values():
        if body.elastic is not None and body.elastic.as_part:
            assert body.part is not None
            yield design.parts[body.part]


def without_unknown_contacts(design: Design) -> Design:
    """Return the design as it can be solved before any part is: without what pushes on parts.

    Contacts give no force in it, if the compliance of a part is needed to know theirs.
    """
    if not any(parts_that_give(design)):
        return design
    return replace(
        design, cycles={name: _untouched(cycle) for name, cycle in design.cycles.items()}
    )


def _untouched(cycle: Cycle) -> Cycle:
    phases = tuple(
        replace(
            phase,
            given={
                force: 0.0 if isinstance(law, ContactLaw) else law
                for force, law in phase.given.items()
            },
        )
        for phase in cycle.phases
    )
    return replace(cycle, phases=phases)
