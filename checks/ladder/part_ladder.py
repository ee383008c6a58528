"""All parts of a design, each by the cheapest models that settle its verdict."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from math import inf
from time import perf_counter

import loads
from checks.design.data import Design, Part
from checks.design.effort import DEFAULT_EFFORT as DEFAULT_EFFORT
from checks.design.effort import SOLID
from checks.design.effort import Effort as Effort
from checks.joints.bushes import bush_checks, bushes_not_checked
from checks.joints.lug_checks import lug_checks
from checks.joints.pin_checks import pin_checks
from checks.joints.slot_checks import slot_checks
from checks.ladder.climb import Climb, climb_rungs, start_climb
from checks.ladder.drawn import undrawn, with_drawn_fields
from checks.ladder.explained import explained
from checks.ladder.pinned import climb_pinned
from checks.ladder.result import cheap_result, solid_result
from checks.ladder.solid import FIRST
from checks.part.part_loads import Doubt, check_reach, loads_on
from checks.part.too_fine import gave_up, told_of_size
from checks.result.live_fields import LiveFields
from checks.result.verdict import Check, PartResult
from checks.strength.sampling import sampled
from checks.stress.cost import check_seconds, report_seconds
from checks.stress.solid_mesh_level import Models
from fem.solvers import SolverError
from geometry.cad_body import SolidBody
from geometry.mesh import Mesh, MeshError, TooManyElementsError
from geometry.parts.step_part import StepPart

Say = Callable[[str], None]
Solved = Mapping[str, loads.CycleLoads | loads.MeasuredLoads]
_TELL_EVERY = 5.0  # s, what is known of a part by cheap models; it takes 0.1 s
Finished = Callable[[PartResult, Sequence[str]], None]


def check_parts(
    design: Design,
    solved: Solved,
    models: Models,
    effort: Effort,
    begun: float,
    say: Say,
    *,
    live: bool = False,
    finished: Finished | None = None,
    doubts: Sequence[Doubt] = (),
) -> list[PartResult]:
    """Check every part of a design; raises DesignError and NumericsError.

    begun     when the check began, on the clock of `perf_counter`
    live      whether a page will show the fields at every position
    finished  is handed each part's result, and what a better model may still settle of it, before
              the models that take longer are begun, and when it is final
    doubts    what the runs may be instead

    The cheap rungs of all parts come first, and of these the cheapest of all parts, so that what
    time there is goes to solids that settle something; under a time limit the ones that are
    expected to be quickest come first.
    """
    deadline = (
        inf if effort.within is None else begun + effort.within - report_seconds(len(design.parts))
    )
    climbs: dict[str, Climb] = {}
    climbing: dict[str, Iterator[None]] = {}
    wanted: dict[str, bool] = {}  # whether a part's solid is
    settled: list[str] = []  # without a mesh
    solids: dict[str, frozenset[str]] = {}
    results: dict[str, PartResult] = {}
    told_at: dict[str, float] = {}
    complete: dict[str, tuple[PartResult, PartResult]] = {}  # a result without and with formulas

    def completed(name: str, result: PartResult) -> PartResult:
        if name not in complete or complete[name][0] is not result:
            complete[name] = result, _with_formulas(climbs[name], result, solved, models)
        return complete[name][1]

    def told(name: str, result: PartResult, left: Sequence[str] = ()) -> None:
        if finished is not None:
            told_at[name] = perf_counter()
            finished(completed(name, result), left)

    for part in design.parts.values():
        with told_of_part(design, part):
            part_loads = loads_on(design, part, solved, doubts)
            check_reach(design, part, part_loads, models.body(part.geometry).interfaces)
            climb = climbs[part.name] = start_climb(design, part, part_loads, solved)
            rungs = effort.pinned.get(part.name)
            if rungs:
                solids[part.name] = climb_pinned(climb, rungs, say)
                wanted[part.name] = bool(solids[part.name])
            else:
                climbing[part.name] = climb_rungs(climb, effort.fidelity, say)
    while True:
        for name, climb in climbs.items():
            with told_of_part(design, climb.part):
                if name in climbing:
                    try:
                        next(climbing[name])
                    except StopIteration as stop:
                        wanted[name] = stop.value
                        del climbing[name]
                if not wanted.get(name, True) and name not in results:
                    results[name] = cheap_result(climb, models, live=live)
                    settled.append(name)
                    told(name, results[name])
        for name, climb in climbs.items():
            if wanted.get(name, True):  # what follows may take long
                with told_of_part(design, climb.part):
                    long_ago = perf_counter() - told_at.get(name, -inf) > _TELL_EVERY
                    if finished is not None and climb.levels and long_ago:
                        told(name, cheap_result(climb, models, live=live), climb.open)
        if not climbing:
            break
    waiting = [name for name in design.parts if wanted[name]]
    if effort.within is not None:
        if waiting:
            say(f"meshing {', '.join(waiting)}, to tell the time of their solids")
        costs = {name: _cost(design, climbs[name], models) for name in waiting}
        waiting.sort(key=lambda name: costs[name])
    for done, name in enumerate(waiting):
        climb = climbs[name]
        with told_of_part(design, climb.part):
            if climb.levels and deadline < inf and perf_counter() + costs[name] > deadline:
                _leave(climb, costs[name], deadline - perf_counter())
                results[name] = cheap_result(climb, models, live=live)
                settled.append(name)
            else:
                say(f"{name}: solving")
                pinned = solids.get(name)
                everything = effort.fidelity == SOLID and pinned is None
                results[name] = solid_result(
                    climb,
                    models,
                    say,
                    everything=everything,
                    deadline=deadline,
                    pinned=pinned,
                    live=live,
                )
            told(name, results[name])
        models.keep_only({climbs[other].part.geometry for other in waiting[done + 1 :]})
    for name in settled if live and effort.fields else []:
        results[name] = _drawn(design, climbs[name], results[name], models, deadline, say)
        told(name, results[name])
        models.keep_only(set())
    return [completed(name, results[name]) for name in design.parts]


def _drawn(
    design: Design, climb: Climb, result: PartResult, models: Models, deadline: float, say: Say
) -> PartResult:
    """The result with stress to look at, if there is time for a mesh."""
    if deadline < inf and isinstance(result.live, LiveFields):
        cost, left = _cost(design, climb, models), deadline - perf_counter()
        if cost > left:
            why = f"about {cost:.0f} s for its mesh, {max(left, 0.0):.0f} s are left"
            return replace(result, live=undrawn(result.live, why))
    return with_drawn_fields(design, climb.part, climb.loads, climb.use, result, models, say)


def _cost(design: Design, climb: Climb, models: Models) -> float:
    """Expected time of a part's solid, s."""
    part = climb.part
    with told_of_part(design, part):
        return check_seconds(3 * len(models.mesh(part.geometry, FIRST * part.fineness).nodes))


def _leave(climb: Climb, cost: float, left: float) -> None:
    """Note that there is no time for a part's solid."""
    climb.skip(
        SOLID,
        f"no time: about {cost:.0f} s, {max(left, 0.0):.0f} s are left; it may settle "
        f"{', '.join(climb.open)}",
        cost,
    )


def time_warnings(results: Sequence[PartResult]) -> list[str]:
    """What a longer run would settle."""
    return [
        f"{result.name}: solid: {tried.why}"
        for result in results
        for tried in result.rungs
        if tried.rung == SOLID and tried.why.startswith("no time")
    ]


def _with_formulas(climb: Climb, result: PartResult, solved: Solved, models: Models) -> PartResult:
    """Add the checks that are formulas on every rung."""
    part = climb.part
    body = models.body(part.geometry)
    checks = [*result.checks, *formula_checks(climb, solved, models, body)]
    return replace(
        result,
        checks=explained(climb, checks, solved, _with_ligaments(climb, models, body), body),
        assumed=[*result.assumed, *bushes_not_checked(part, solved)],
    )


def _with_ligaments(climb: Climb, models: Models, body: SolidBody) -> Mesh | SolidBody:
    """The part as its ligaments are known: of one from CAD they are measured on its mesh."""
    part = climb.part
    if isinstance(part.geometry, StepPart):
        return models.mesh(part.geometry, FIRST * part.fineness)
    return body


def formula_checks(climb: Climb, solved: Solved, models: Models, body: SolidBody) -> list[Check]:
    """The checks of a part that are formulas on every rung and need no rung's stress."""
    design, part, part_loads = climb.design, climb.part, climb.loads
    lugs = _with_ligaments(climb, models, body)
    return [
        *sampled(
            lambda some: [
                *pin_checks(design, part, some),
                *lug_checks(design, part, some, lugs),
                *slot_checks(design, part, some, body.interfaces, solved=some is part_loads),
            ],
            part_loads,
        ),
        *bush_checks(design, part, part_loads, solved),
    ]


@contextmanager
def told_of_part(design: Design, part: Part) -> Iterator[None]:
    """Turn what goes wrong with a part into an error that names it."""
    try:
        yield
    except (loads.LinkageError, TooManyElementsError) as error:
        raise told_of_size(design, part, error) from error
    except (MeshError, SolverError) as error:
        raise gave_up(design, part, error) from error
