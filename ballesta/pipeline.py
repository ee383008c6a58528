"""Check a design: its cycles, its parts, its verdict."""

import platform
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import date
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from math import inf
from pathlib import Path
from time import perf_counter
from typing import Any

import loads
from ballesta.design.plate_parts import told_of_steps
from ballesta.design.read import read_design
from ballesta.machine.blows import blow_gates, blow_subject
from ballesta.machine.drive_speed import speed_warnings
from ballesta.machine.measured_balance import balance_gates, not_measured
from ballesta.machine.motion import motions_of, with_modes
from ballesta.machine.quasi_static import assumptions_of, quasi_static_gates
from ballesta.machine.runs import MachineDoubts, MachineRuns, doubts_of, run_machine
from ballesta.machine.solved_cycles import event_assumptions
from ballesta.machine.validity_checks import endless_gates, load_gates
from ballesta.machine.warnings_of import design_warnings, solver_warnings, unloaded_warnings
from ballesta.unfinished import FRAME, PART, Keep, KeptPart, with_parts, without_live
from checks.columns.cylinders import cylinder_checks, not_checked_of
from checks.columns.linkage_frame import least_factor, linkage_check, worst_mode
from checks.columns.linkage_search import FreeMotions, LinkageMode
from checks.columns.linkage_store import stored_mode
from checks.derivations.buckling import linkage_share
from checks.design.data import Design
from checks.design.errors import DesignError, NumericsError
from checks.ladder.carried import Neighbour
from checks.ladder.leaf_checks import LeafBand
from checks.ladder.part_fields import undrawn_warnings
from checks.ladder.part_ladder import (
    DEFAULT_EFFORT,
    Effort,
    Finished,
    Ladder,
    time_warnings,
)
from checks.part.part_loads import Doubt, Runs, is_loaded, loads_on, shown_of
from checks.result.verdict import Check, DesignResult, PartResult
from checks.result.ways import ways_out
from checks.store.store import Store
from checks.strength.load_doubts import only_at, with_doubts
from checks.strength.part_strength import beyond_size_data
from checks.stress.kept_models import told_of_part
from checks.stress.solid_mesh_level import Models
from fem.solvers import SolverError, chosen_solver
from fem.threads import keep_freed_memory, one_thread, policy

Say = Callable[[str], None]
_FAR = 0.2  # use of a linkage's buckling load that no doubt about its speed brings to its limit
_CAD = (".step", ".stp")

NOT_CHECKED = (
    "contact fatigue, wear and lubrication of pins and bushes",
    "welds, screws, circlips and other fasteners",
    "keys, splines and press fits that bring a couple into a bore",
    "frame, guides, and bodies and cylinders that no entry describes",
    "lateral loads, and clearances that no column states as its eccentricity",
    "vibration out of the plane, of drive and frame, and after an impact",
    "corrosion, temperature, residual stress and manufacturing defects",
)


def check_file(
    path: str | Path,
    overrides: Sequence[str] = (),
    *,
    effort: Effort = DEFAULT_EFFORT,
    say: Say = lambda _: None,
    store: Store | None = None,
) -> DesignResult:
    """Read and check one design file.

    store  what earlier checks have left (docs/store.md); this one's stages are kept there

    Raises DesignError for a file that cannot be checked as written, NumericsError where a solver
    gave up.
    """
    start = perf_counter()
    design = read_design(path, overrides)
    reading = perf_counter() - start
    return check_design(design, effort=effort, say=say, reading=reading, store=store)


@dataclass(frozen=True, eq=False)
class Checked:
    """A result, and what was solved for it that a search for changes may share.

    cycles   name -> loads of a cycle, without dynamic factors
    rubbing  part -> friction between its leaves
    """

    result: DesignResult
    cycles: Mapping[str, loads.CycleLoads]
    rubbing: Mapping[str, LeafBand]


def check_design(
    design: Design,
    *,
    effort: Effort = DEFAULT_EFFORT,
    say: Say = lambda _: None,
    reading: float = 0.0,
    store: Store | None = None,
    live: bool = False,
    neighbours: Callable[[str], Neighbour | str] | None = None,
) -> DesignResult:
    """Check all parts of a design over all its cycles; as `check_with_cycles`."""
    return check_with_cycles(
        design, effort=effort, say=say, reading=reading, store=store, live=live,
        neighbours=neighbours,
    ).result  # fmt: skip


@one_thread()
def check_with_cycles(
    design: Design,
    *,
    effort: Effort = DEFAULT_EFFORT,
    say: Say = lambda _: None,
    reading: float = 0.0,
    store: Store | None = None,
    live: bool = False,
    begun: float | None = None,
    keep: Keep | None = None,
    neighbours: Callable[[str], Neighbour | str] | None = None,
) -> Checked:
    """Check all parts of a design over all its cycles; raises DesignError and NumericsError.

    effort  which models may be used, and how long it may take
    store   of loads, meshes and solutions (docs/store.md)
    live    whether fields and motion at every position are wanted, for a page or a window
    begun   when its time began, on the clock of `perf_counter`; None for when reading began
    keep    is handed what is finished meanwhile (ballesta/unfinished.py)
    neighbours  of swept solids, as the ladder asks for them
    """
    if begun is None:
        begun = perf_counter() - reading
    if not design.parts:
        raise DesignError(
            design.file, "parts", "there are none to check; ballesta loads solves the loads alone"
        )
    keep_freed_memory()
    models = Models(store)
    timings = {"read": reading}
    try:
        start = perf_counter()
        # where stress is shown, a mesh has a better surface
        machine = run_machine(design, models, say, store, skins=not effort.shows_stress)
        design = machine.design
        say("loads: both ends of what is not known of them")
        runs, doubts = machine.all, doubts_of(design, machine)
        say("loads: buckling of the linkage")
        motions = FreeMotions()
        mode = stored_mode(store, design, runs) if store else worst_mode(design, runs, motions)
        linkage = [*_of_linkage(design, mode, doubts.all, motions)]
        linkage += _of_cylinders(design, runs, doubts.all)
        timings["loads"] = perf_counter() - start - sum(models.seconds.values())
    except loads.LinkageError as error:
        raise DesignError(design.file, "linkage", str(error)) from error
    except SolverError as error:
        raise NumericsError(
            str(error),
            f"{design.file}: linkage",
            "check the sections and lengths of its bars: one may be far stiffer than another",
        ) from error
    frame = _frame(design, machine, doubts, linkage, effort, timings)
    start = perf_counter()
    before = sum(models.seconds.values())
    ladder = Ladder(
        design, models, effort, begun, say, live, _kept(design, frame, keep), neighbours
    )
    results = ladder.check(runs, doubts.all)
    spent = sum(models.seconds.values()) - before
    timings |= models.seconds
    timings["cycle, fatigue, buckling"] = perf_counter() - start - spent
    whole = with_parts(frame, results, _warnings_of_parts(design, results))
    whole = replace(whole, ways=ways_out(whole))
    if live:
        whole = with_modes(design, machine.solved, whole, mode)
        whole = replace(whole, motion=motions_of(design, machine.solved, results))
    return Checked(whole, machine.rigid, ladder.rubbing)


def _frame(
    design: Design,
    machine: MachineRuns,
    doubts: MachineDoubts,
    linkage: Sequence[Check],
    effort: Effort,
    timings: dict[str, float],
) -> DesignResult:
    """The result of a design before any of its parts is checked."""
    vibration = machine.vibration
    return DesignResult(
        name=design.name,
        file=str(design.file),
        sha256=design.sha256,
        overrides=design.overrides,
        parts=(),
        cycles=_cycle_data(design, machine.all),
        gates=[
            *load_gates(design, machine.solved, doubts.covered),
            *blow_gates(machine.blows),
            *doubts.gates,
            *quasi_static_gates(design, vibration),
            *balance_gates(design, machine.measured),
            *endless_gates(design, machine.all),
        ],
        warnings=[
            *machine.warnings,
            *speed_warnings(doubts.evenness),
            *design_warnings(design, machine.masses, machine.all),
            *_load_factor_warnings(design),
        ],
        not_checked=(
            *_not_checked(design, machine),
            *not_checked_of(design),
            *_not_checked_here(design),
            *not_measured(design),
        ),
        assumed=(
            *design.assumed,
            *_assumed_here(design),
            *doubts.assumed,
            *event_assumptions(design),
            *assumptions_of(design, vibration),
        ),
        defaults=design.defaults_used,
        inputs=list(design.inputs),
        source=_all_sources(design),
        versions=versions_of_libraries(),
        command=" ".join(
            [
                "ballesta check",
                str(design.file),
                *effort.options,
                *(f"--set {o!r}" for o in design.overrides),
            ]
        ),
        timings=timings,
        linkage=linkage,
        assumed_by_design=_assumed_by_design(design),
        date=date.today().isoformat(),
    )


def _kept(design: Design, frame: DesignResult, keep: Keep | None) -> Finished | None:
    """The function that hands over a part's result as soon as it is there; None without `keep`."""
    if keep is None:
        return None
    keep(FRAME, (frame, list(design.parts)))

    def kept(result: PartResult, left: Sequence[str]) -> None:
        warnings = _warnings_of_parts(design, [result])
        keep(f"{PART}{result.name}", KeptPart(without_live(result), left, warnings))

    return kept


def _warnings_of_parts(design: Design, results: Sequence[PartResult]) -> list[str]:
    return [
        *time_warnings(results),
        *solver_warnings(results),
        *undrawn_warnings(results),
        *unloaded_warnings(results),
    ]


def _of_linkage(
    design: Design, mode: LinkageMode | None, doubts: Sequence[Doubt], motions: FreeMotions
) -> Iterator[Check]:
    """Its check, where anything presses it; one that is only there at an end stands by itself."""
    if mode is None:
        yield from _only_doubted(design, doubts, motions)
        return
    mode = mode.under(design.load_factor)
    check = linkage_check(design, mode)
    ends = {
        doubt.words: [_linkage_share(design, end, motions) for end in doubt.ends]
        for doubt in doubts
        if check.utilisation > _FAR or not doubt.speed
    }
    yield with_doubts(check, ends).explained_by(linkage_share(design, mode, check))


def _only_doubted(design: Design, doubts: Sequence[Doubt], motions: FreeMotions) -> Iterator[Check]:
    """The worst of the linkage's checks at the ends of doubts; its load may as well be none."""
    pressed = [
        (mode.under(design.load_factor), doubt.words)
        for doubt in doubts
        for end in doubt.ends
        if (mode := worst_mode(design, end, motions)) is not None
    ]
    if pressed:
        mode, words = min(pressed, key=lambda one: one[0].factor)
        check = only_at(words, linkage_check(design, mode))
        yield check.explained_by(linkage_share(design, mode, check))


def _of_cylinders(design: Design, runs: Runs, doubts: Sequence[Doubt]) -> list[Check]:
    if not design.cylinders:
        return []
    at_ends = {
        doubt.words: [
            {check.quantity: check.value for check in cylinder_checks(design, end, doubted=True)}
            for end in doubt.ends
        ]
        for doubt in doubts
    }
    return [
        with_doubts(
            check,
            {
                words: [end.get(check.quantity, inf) for end in ends]
                for words, ends in at_ends.items()
            },
        )
        for check in cylinder_checks(design, runs)
    ]


def _linkage_share(design: Design, runs: Runs, motions: FreeMotions) -> float:
    factor = least_factor(design, runs, motions)
    return 0.0 if factor is None else 1 / (factor / design.load_factor)


def _not_checked(design: Design, machine: MachineRuns) -> tuple[str, ...]:
    """Effects that no check of a design knows."""
    blow = blow_subject(design, machine.rigid, machine.blows)
    changes = "any speed change within a cycle"
    parts = design.parts.values()
    told: tuple[str, ...] = NOT_CHECKED
    for subject, stated in (
        ("welds", any(part.welds for part in parts)),
        ("screws", any(part.bolts for part in parts)),
    ):
        if stated:
            told = tuple(one.replace(subject, f"{subject} that no part states") for one in told)
    if design.drive.motor:
        return (blow or "impact", *told)
    return ((blow, changes) if blow else (f"impact and {changes}",)) + told


def _not_checked_here(design: Design) -> list[str]:
    left = [] if design.duty.cycles else ["fatigue: no cycle stands in the duty"]
    if design.events:
        left.append(
            f"vibration as the torque of {' and '.join(design.events)} jumps, and the torque peaks "
            "of a motor's currents as it is switched on"
        )
    following = [
        name
        for name, force in design.forces.items()
        if isinstance(force.coordinate, loads.PointCoordinate)
        and force.coordinate.follows != loads.GROUND
    ]
    if following:
        left.append(
            f"the turning of {' and '.join(following)} with its body as the linkage buckles (its "
            "direction is held fixed there) and flutter"
        )
    return left


def _load_factor_warnings(design: Design) -> list[str]:
    if design.load_factor == 1.0:
        return []
    return [
        f"load_factor: loads of all parts and of the linkage are multiplied by "
        f"{design.load_factor:g}; motion, drives and the joint forces beside them are without it"
    ]


def _assumed_by_design(design: Design) -> list[str]:
    """Keys that the file marks as assumed; program defaults excluded."""
    ours = {
        *told_of_steps(design.parts),
        *(pair for run in design.measured.values() for pair in run.assumed),
    }
    return [pair[0] for pair in design.assumed if pair not in ours]


def _assumed_here(design: Design) -> Iterator[tuple[str, str]]:
    if design.cycles and not design.friction:
        yield (
            "friction",
            "none is stated: pins and guides are taken without friction; it changes the forces and "
            "bends the parts by its couples",
        )
    for body, own in design.stated_masses.items():
        if own.mass is not None and own.inertia is None:
            yield (
                f"bodies.{body}.inertia",
                "none is stated beside the mass: its part's, of as much mass",
            )
    of_cycles = [cycle.friction or {} for cycle in design.cycles.values()]
    rubbing = set(design.friction or {}).union(*of_cycles)
    stated = {part.joint for part in design.parts.values()}
    for point, joints in design.joints.items():
        if len(joints) > 1 and point not in stated and rubbing.intersection(j.name for j in joints):
            yield (
                f"friction of {point}",
                f"{len(joints) + 1} bodies on one pin, which turns with {joints[0].body_a}, the "
                "first of them in the file; a pin part's fixed_to states another",
            )
    for part in design.parts.values() if design.duty.cycles else ():
        beyond = beyond_size_data(part)
        if beyond is not None:
            yield f"parts.{part.name}.strength", beyond


def _cycle_data(
    design: Design,
    solved: Mapping[str, loads.CycleLoads | loads.MeasuredLoads],
) -> dict[str, dict[str, Any]]:
    """Plain data over every cycle, but for the peaks, which parts add (unfinished.with_parts)."""
    data = {}
    for name, cycle in solved.items():
        shown, unit, position = shown_of(design, name, cycle)
        links = {}
        for part in design.parts.values():
            if not is_loaded(part, cycle):
                continue
            with told_of_part(design, part):
                part_loads = loads_on(design, part, {name: cycle})
            for interface in part_loads.wrenches:
                links[f"{part.name} {interface}"] = part_loads.resultant(interface).tolist()
        efforts, torques = _efforts(cycle)
        powers, works = _powers(cycle)
        data[name] = {
            "shown_name": shown,
            "unit": unit,
            "position": position.tolist(),
            "time": [] if cycle.times is None else cycle.times.tolist(),
            "phase": [cycle.phases[k] for k in cycle.phase_of],
            "efforts": efforts,
            "torques": torques,
            "powers": powers,
            "works": works,
            "links": links,
            "peaks": {},
            "duty": design.duty.cycles.get(name, 0.0),
        }
    return data


def _efforts(
    cycle: loads.CycleLoads | loads.MeasuredLoads,
) -> tuple[dict[str, list[float]], dict[str, list[float]]]:
    """Return forces [N] and torques [N mm] over a cycle, by name."""
    if not isinstance(cycle, loads.CycleLoads):
        return {}, {}
    forces: dict[str, list[float]] = {}
    torques: dict[str, list[float]] = {}
    for force in cycle.linkage.forces:
        kind = torques if force.coordinate.angular else forces
        kind[force.name] = cycle.efforts[force.name].tolist()
    return forces, torques


def _powers(
    cycle: loads.CycleLoads | loads.MeasuredLoads,
) -> tuple[dict[str, list[float]], dict[str, float]]:
    """Return powers [N mm/s] and works [N mm] that forces do on the linkage, by name."""
    if not isinstance(cycle, loads.CycleLoads):
        return {}, {}
    forces = cycle.linkage.forces
    return (
        {f.name: (f.sign * cycle.efforts[f.name] * cycle.rate(f.name)).tolist() for f in forces},
        {f.name: cycle.drive(f.name).work for f in forces},
    )


def _all_sources(design: Design) -> str:
    """Return the text of the design file, then of the files that it is like or reads.

    CAD files are named only: they are long, and nobody reads them.
    """
    others = [(Path(file), text) for file, text in design.sources if Path(file) != design.file]
    return "\n".join(
        [
            design.source,
            *(
                f"# {file}: {len(text)} characters, not printed here"
                if file.suffix.lower() in _CAD
                else f"# {file}\n{text}"
                for file, text in others
            ),
        ]
    )


def versions() -> dict[str, str]:
    """Return the same, and the solver that is taken here, which takes time to load."""
    return {**versions_of_libraries(), "solver": chosen_solver()}


def versions_of_libraries() -> dict[str, str]:
    """Return the versions of Python, our packages, libraries and installed extras."""
    return {
        **_installed(),
        "threads": policy(),
        "python": platform.python_version(),
        "platform": f"{sys.platform} {platform.machine()}",
    }


@cache
def _installed() -> Mapping[str, str]:
    """Versions of our packages, libraries and installed extras: reading them takes 15 ms."""
    names = ("ballesta", "gmsh", "scikit-fem", "numpy", "scipy", "meshio")
    found = {name: version(name) for name in names}
    for extra in ("scikit-sparse", "pypardiso", "mkl"):
        with suppress(PackageNotFoundError):
            found[extra] = version(extra)
    return found
