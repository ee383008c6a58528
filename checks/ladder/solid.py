"""The solid model of one part: meshes until the stress is known well enough, and its checks."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees, inf, isfinite, radians
from time import perf_counter

import numpy as np

from checks import by_formula
from checks.columns.stability import eigenvalue_check
from checks.derivations.buckling import solid_share
from checks.derivations.solids import of_solid
from checks.design.data import Part
from checks.design.errors import DesignError
from checks.ladder.chart_data import charts_of
from checks.ladder.edge_checks import edge_fatigue, edge_static, known_at_edges
from checks.ladder.hand_calculations import hand_checks
from checks.ladder.part_facts import assumed_of, contact_facts, facts_of, gates_of, mesh_row
from checks.ladder.part_fields import solid_fields
from checks.ladder.part_vibration import frequency_facts
from checks.ladder.passing_fits import clearances_that_pass, with_assumed_fits
from checks.models.stress_words import fatigue_words, static_words
from checks.part.loaded_part import FIRST as FIRST
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check, Gate, HandCheck, PartResult, Status, Surface
from checks.result.ways import arc_fact
from checks.strength.fatigue_assessment import FatigueUse, FkmUse
from checks.strength.fatigue_facts import fatigue_facts
from checks.strength.load_doubts import LoadBars, load_bars
from checks.strength.part_strength import elastic_of, endurance_of, fatigue_use, life_task
from checks.strength.sampling import fatigue_rise, static_rise, with_sampling
from checks.stress.cost import check_seconds, judging_seconds
from checks.stress.error_bars import Bars, Judged, StaticPeak, bars_of, mesh_bar
from checks.stress.pins_in_bores import fits_of, pinned_bores
from checks.stress.solid_mesh_level import Level, Models, solve_level
from checks.stress.stress_result import Stressed
from checks.stress.symmetry import MEANING, half_of, mode_surface, shown_surface
from fem.buckling import BucklingMode
from fem.contact.condensed import ContactError
from fem.error_estimate import refined_sizes, stress_error
from fem.unit_solutions import UnitSolutions
from geometry.mesh import (
    FloatArray,
    MassProperties,
    Mesh,
    MeshError,
    TooManyElementsError,
    TooManyUnknownsError,
)
from geometry.meshing import Buildable
from geometry.progress import expect
from geometry.sizing import SizeField

# Fineness of the first mesh for a verdict on stress alone, and the accuracy from which on.
COARSE, LOOSE = 0.5, 0.05
_MOST_MESHES = 5
_NEXT = 2.5  # times what a mesh took, a finer one takes
RESCALED = (  # limit and meaning of the gate that proves the safety factor
    1e-6,
    "how far from 1 the fatigue safety is when all loads are multiplied by it and judged again",
)
_ARCS = tuple(radians(arc) for arc in range(105, 181, 15))  # that are tried, narrow ones first
_EXAGGERATED = 0.1  # of the part's size: the largest displacement of a mode as it is drawn
_FINER = 1.3  # general elements, where a mesh with small ones in places is not usable
_LEAST_STEP = 1.15  # elements that decide must become smaller by this, or a mesh is not worth it

Say = Callable[[str], None]


def none_settles(_checks: Sequence[Check], _unknowns: float) -> float:
    """Share of the bars left where no mesh is asked for but for the accuracy: 1."""
    return 1.0


@dataclass(frozen=True)
class Asked:
    """Questions that a solid is solved for.

    kinds      checks that its meshes are refined for: "static", "fatigue", "buckling"
    modes      True if its frequencies, and a buckling mode to look at, are wanted too
    first      fineness of the first mesh; after a coarse one the accuracy alone is not enough
    enough     says of the checks on the meshes so far why no finer one is needed; "" if one is
    settling   share of the numerical bars left, on a mesh finer than one of some unknowns, with
               which what of the checks is open would be settled; 1 where no mesh does
    deadline   on the clock of `perf_counter`: no mesh is begun that is expected to end later
    live       whether a page will show the fields at every position
    """

    kinds: frozenset[str] = frozenset(("static", "fatigue", "buckling"))
    modes: bool = True
    first: float = FIRST
    enough: Callable[[Sequence[Check]], str] = lambda _: ""
    settling: Callable[[Sequence[Check], float], float] = none_settles
    deadline: float = inf
    live: bool = False


EVERYTHING = Asked()


def first_of(accuracy: float, kinds: Collection[str]) -> float:
    """Fineness of the first mesh for a verdict on some kinds of checks to an accuracy.

    Bars from a step between meshes 0.5 and 0.8 hold 93 % of the references with known answers, as
    those of 0.7 and 1 do (docs/theory/error_bars.md); buckling has no other mesh than the first.
    """
    return COARSE if accuracy >= LOOSE and "buckling" not in kinds else FIRST


def check_solid(
    loaded: LoadedPart,
    models: Models,
    say: Say = lambda _: None,
    asked: Asked = EVERYTHING,
) -> PartResult:
    """Check one part as a solid over all cycles of its design.

    After the first mesh each is finer where the last one was uncertain, until the numerical error
    of what is judged is within the accuracy asked for, or the mesh would have more unknowns than
    allowed. The finer ones are halves where shape and loads allow it: the first may buckle
    sideways. Raises MeshError and SolverError.
    """
    part, loads = loaded.part, loaded.loads
    static, use = StaticPeak(loads), fatigue_use(loaded)
    both: list[Judged] = [static] if use is None else [static, use]
    judged = [what for what in both if (what is static and "static" in asked.kinds)
              or (what is use and "fatigue" in asked.kinds)]  # fmt: skip

    once = replace(asked, settling=none_settles)
    solved = by_arcs = _solved(loaded, models, both, judged, say, once)
    fitted = with_assumed_fits(loaded, by_arcs.finest, by_arcs.checks)
    if fitted is not None:
        say(f"{part.name}: contact of its pins")
        try:
            solved = _solved(fitted, models, both, judged, say, asked, by_arcs)
            loaded = fitted
        except (ContactError, MeshError):
            pass  # as where no contact is asked for: arcs, and their band, are told
    if solved is by_arcs and any(check.settled_by_mesh for check in by_arcs.checks):
        solved = _solved(loaded, models, both, judged, say, asked, by_arcs)
    levels, finest = solved.levels, solved.finest
    stressed, by_hand = list(solved.checks), list(solved.by_hand)
    arcs = _arcs_that_pass(loaded, levels, both, stressed, solved.doubts)
    arcs |= clearances_that_pass(by_arcs.loaded, by_arcs.finest, both, stressed)
    buckled = _Buckled()
    if "buckling" in asked.kinds:
        buckled = _judge_buckling(by_arcs.loaded, models, levels, solved.sizes)
    assumed = assumed_of(loaded, finest)
    if finest.half:
        assumed.append(MEANING)
    if buckled.untold:
        assumed.append(buckled.untold)
    properties = models.body(part.geometry).mass_properties(part.material.density)
    gates = gates_of(loaded, levels, properties)
    if use is not None:
        missed = use.safety_missed(finest)
        gates.append(Gate(f"{part.name}: fatigue safety", missed, *RESCALED))
    return PartResult(
        name=part.name,
        shape=part.shape,
        material=part.material.name,
        checks=[*stressed, *buckled.checks],
        gates=gates,
        hand_checks=by_hand,
        meshes=[{"body": "half" if lv.half else "whole", **mesh_row(lv)} for lv in levels],
        facts=_facts(loaded, levels, use, properties, asked) | arcs,
        charts=charts_of(loaded, finest, use, levels),
        surface=shown_surface(loads, finest),
        assumed=assumed,
        mode=buckled.mode,
        live=solid_fields(loads, finest, use) if asked.live else None,
    )


@dataclass(frozen=True, eq=False)
class _Solved:
    """A part on its meshes, and its stress checks on the last of them.

    sizes    of the elements of the last mesh; None where it is the first
    stopped  why the accuracy was not reached, or no more was asked for
    doubts   bars of its loads
    """

    loaded: LoadedPart
    levels: Sequence[Level]
    sizes: SizeField | None
    stopped: str
    doubts: LoadBars
    by_hand: Sequence[HandCheck]
    checks: Sequence[Check]

    @property
    def finest(self) -> Level:
        """The last mesh."""
        return self.levels[-1]


def _solved(
    loaded: LoadedPart,
    models: Models,
    both: Sequence[Judged],
    judged: Sequence[Judged],
    say: Say,
    asked: Asked,
    before: _Solved | None = None,
) -> _Solved:
    """Solve a part on meshes as fine as is asked for, and judge its stress.

    both    the stresses that a check is made of; judged: those that meshes are refined for
    before  the same part, or it with other fits, on the first meshes
    """
    doubts: list[LoadBars] = [] if before is None else [before.doubts]

    def widened(levels: Sequence[Level]) -> LoadBars:
        if not doubts:
            doubts.append(load_bars(loaded.loads, _values(loaded, levels[0])))
        return doubts[0]

    known: dict[int, list[Check]] = {}

    def checks_of(levels: Sequence[Level]) -> list[Check]:
        if len(levels) not in known:
            known[len(levels)] = _stress_checks(loaded, levels, judged, widened(levels))
        return known[len(levels)]

    def enough(levels: Sequence[Level]) -> str:
        checks = checks_of(levels)
        return asked.enough(checks) or known_at_edges(loaded, levels, judged, checks)

    def accuracy(levels: Sequence[Level]) -> float:
        left = asked.settling(checks_of(levels), levels[-1].unknowns)
        return left * max(mesh_bar(what, levels) for what in judged)

    limit = endurance_of(loaded.part).value
    begun = [] if before is None else list(before.levels)
    if before is not None and before.loaded is not loaded:
        begun = [_level(loaded, _assumed_pressure(one)[0], one.fineness, limit) for one in begun]
    levels, sizes, stopped = solve_levels(
        loaded, models, judged, limit, say, asked, enough, accuracy, begun,
        None if before is None else before.sizes,
    )  # fmt: skip
    finest = levels[-1]
    expect("judging, buckling, fields", judging_seconds(finest.unknowns))
    by_hand = hand_checks(loaded.part, loaded.loads, finest)
    # buckling alone is asked of one mesh, on which a stress has no error bar
    stressed = _stress_checks(
        loaded, levels, both if len(levels) > 1 else judged, widened(levels), by_hand
    )
    if stopped:
        stressed = [
            replace(check, note=f"{check.note}; {stopped}")
            if check.numerical - check.sampling > loaded.accuracy * check.value
            else check
            for check in stressed
        ]
    return _Solved(loaded, levels, sizes, stopped, widened(levels), by_hand, stressed)


def _stress_checks(
    loaded: LoadedPart,
    levels: Sequence[Level],
    wanted: Sequence[Judged],
    doubts: LoadBars,
    by_hand: Sequence[HandCheck] | None = None,
) -> list[Check]:
    """Check what is wanted on the last mesh; with derivations where hand checks are given."""
    part = loaded.part
    found = []
    for what in wanted:
        bars = bars_of(what, part, levels, loaded.accuracy)
        check = doubts(_stress_check(loaded, levels[-1], what, bars))
        at_edges = _edges_judged(loaded, levels, what, bars)
        if isinstance(at_edges, Check):
            check = doubts(at_edges)
        elif by_hand is not None:
            check = of_solid(part, loaded.loads, levels[-1], what, bars, check, by_hand)
        if isinstance(at_edges, str) and at_edges:
            check = replace(check, note=f"{check.note}; {at_edges}")
        found.append(check)
    return found


def _edges_judged(
    loaded: LoadedPart, levels: Sequence[Level], what: Judged, bars: Bars
) -> Check | str:
    """The check of a part with sharp edges, or why there is none where the peak lies on one.

    Fatigue of edges is judged wherever it can be: what elements show there may be far less than the
    stress that counts. "" where edges decide nothing.
    """

    def make(level: Stressed, bars: Bars) -> Check:
        return _stress_check(loaded, level, what, bars)

    if not all(len(level.edges[0]) for level in levels):
        return ""
    if isinstance(what, FatigueUse):
        if not bars.numerical.singular and loaded.part.material.threshold is None:
            return ""
        judged = edge_fatigue(loaded, levels, what, make)
        return judged if isinstance(judged, Check) or bars.numerical.singular else ""
    if not bars.numerical.singular:
        return ""
    return edge_static(loaded, levels, what, make)


def _arcs_that_pass(
    loaded: LoadedPart,
    levels: Sequence[Level],
    judged: Sequence[Judged],
    checks: Sequence[Check],
    doubts: LoadBars,
) -> dict[str, float]:
    """The narrowest arc of contact, deg, from which on an open check passes, as a fact by kind.

    A band over arcs begins at the half circle: a check that is open there is open on every arc.
    """

    def passes(what: Judged, arc: float) -> bool:
        closer = replace(loaded, part=replace(loaded.part, bearing_arc=arc, arc_stated=True))
        (again,) = _stress_checks(closer, levels, [what], doubts)
        return again.status is Status.PASS

    found = {}
    for what in judged:
        kind = "static" if isinstance(what, StaticPeak) else "fatigue"
        for check in checks:
            if check.kind != kind or check.status is not Status.UNDECIDED:
                continue
            if check.settled_by_mesh or not isfinite(check.numerical):
                continue
            wider = [arc for arc in _ARCS if arc > loaded.part.bearing_arc]
            if wider and passes(what, wider[-1]):
                found[arc_fact(kind)] = degrees(next(arc for arc in wider if passes(what, arc)))
    return found


def _values(loaded: LoadedPart, level: Level) -> Callable[[PartLoads], Mapping[str, float]]:
    """A function for the stress checks' values on one mesh under other loads, by kind.

    Only their ratios count: pressures are the assumed ones, whose stress grows with the force.
    Contact's grows less.
    """
    part = loaded.part
    solutions, _ = _assumed_pressure(level)

    def values_of(loads: PartLoads) -> Mapping[str, float]:
        other = solve_level(
            solutions,
            level.fineness,
            loads,
            endurance_of(part).value,
            part.material.ultimate_stress,
            loaded.duty.cycles,
            part.geometry.notch_factors,
        )
        values = {"static": other.peak.value}
        use = fatigue_use(loaded.under(loads))
        if use is not None:
            values["fatigue"] = use.value(other)
        return values

    return values_of


@dataclass(frozen=True, eq=False)
class _Buckled:
    """Buckling of a solid.

    checks  by its lowest factor, none without one
    untold  why there is none, in words; "" where nothing is to be said
    mode    the surface as it buckles
    """

    checks: Sequence[Check] = ()
    untold: str = ""
    mode: Surface | None = None


def _judge_buckling(
    loaded: LoadedPart,
    models: Models,
    levels: Sequence[Level],
    sizes: SizeField | None,
) -> _Buckled:
    """Ask the whole solid for its lowest factor; of finer halves a whole one where it decides.

    Where pins press in their bores does not matter to it: pressures are the assumed ones.

    sizes  of the elements of the last mesh
    """
    finest = levels[-1]
    whole = [_assumed_pressure(level) for level in levels if not level.half]
    found = eigenvalue_check(loaded, whole, finest.peak.position)
    if found and found[0].status is Status.UNDECIDED and finest.half:
        whole.append(_whole_again(loaded, models, finest, sizes))
        found = eigenvalue_check(loaded, whole, finest.peak.position)
    if found:
        check, mode = found
        unknowns = whole[-1 if "two" in check.method else 0][0].loads.shape[0]
        derivation = solid_share(loaded, check, mode, unknowns)
        return _Buckled([replace(check, derivation=derivation)], "", _mode_of(whole, mode))
    if levels[0].solutions.ties is not None:
        said = "buckling of a stack of bodies that slide on each other is not computed"
        return _Buckled(untold=said)
    if loaded.part.body is None:
        return _Buckled()
    return _Buckled(
        untold="the solid does not buckle at the positions asked: no factor is positive before its "
        "stress is a tenth of Young's modulus"
    )


def _assumed_pressure(level: Level) -> tuple[UnitSolutions, FloatArray]:
    """Unit loads of a mesh and coefficients (n_basis, n), without waves of contact."""
    if level.contact is None:
        return level.solutions, level.coefficients
    return level.contact.pins.solutions, level.contact.assumed


def _facts(
    loaded: LoadedPart,
    levels: Sequence[Level],
    use: FatigueUse | None,
    properties: MassProperties,
    asked: Asked,
) -> dict[str, float | str]:
    """Facts beside the checks, by name; of fatigue by the chain that judges the part."""
    part = loaded.part
    finest = levels[-1]
    size = float(np.ptp(finest.solutions.mesh.nodes, axis=0).max())
    facts = facts_of(part, loaded.loads, properties, size, None if part.fkm else endurance_of(part))
    facts |= by_formula.facts(loaded) | contact_facts(finest)
    if asked.modes:
        facts |= frequency_facts(part, levels[0].solutions)
    if isinstance(use, FkmUse):
        facts |= use.found(finest).facts()
    elif use is not None:
        facts |= fatigue_facts(part, finest, use.worst(finest), life_task(part, loaded.duty))
    return facts


def _mode_of(
    whole: Sequence[tuple[UnitSolutions, FloatArray]], mode: BucklingMode
) -> Surface | None:
    """The surface of the mesh that a mode was found on, displaced by a part of its size."""
    for solutions, _ in whole:
        mesh = solutions.mesh
        if len(mesh.nodes) == len(mode.shape):
            moved = _EXAGGERATED * float(np.ptp(mesh.nodes, axis=0).max()) * mode.shape
            size = np.linalg.norm(mode.shape, axis=1)
            return mode_surface(mesh, solutions.recovery.points, moved, size / size.max())
    return None


def solve_levels(
    loaded: LoadedPart,
    models: Models,
    judged: Sequence[Judged],
    limit: float,
    say: Say,
    asked: Asked = EVERYTHING,
    enough: Callable[[Sequence[Level]], str] = lambda _: "",
    accuracy: Callable[[Sequence[Level]], float] | None = None,
    begun: Sequence[Level] = (),
    sizes: SizeField | None = None,
) -> tuple[list[Level], SizeField | None, str]:
    """Solve a part on finer and finer meshes.

    enough    why no finer mesh than some is needed; "" if one is
    accuracy  wanted where the design's is reached, by the meshes; none other if nothing is said
    begun     meshes to go on from, and the sizes of the last one

    Returns the last one's sizes too, and why it stopped short of the accuracy, or nothing.
    """
    part, loads = loaded.part, loaded.loads
    material, base = elastic_of(part), asked.first * part.fineness
    finer = half_of(part, loads) or part.geometry
    sideways = asked.modes or "buckling" in asked.kinds
    first: Buildable = part.geometry if sideways else finer
    wanted = accuracy or (lambda _: inf)
    levels = list(begun)
    took = check_seconds(levels[-1].unknowns) if levels else 0.0
    while True:
        if levels:
            found = _next_sizes(loaded, levels, judged, asked, enough, wanted, took)
            if isinstance(found, str):
                return levels, sizes, found
            sizes = found
        start = perf_counter()
        try:
            if not levels:
                first_mesh(part, first, base, models)
            solutions = models.solutions(finer if levels else first, base, material, sizes)
        except TooManyElementsError as error:
            if len(levels) < 2:  # one mesh has no error bar
                raise
            return levels, sizes, f"a finer mesh was not solved: {error}"
        except MeshError:
            if base > _FINER * max(asked.first, FIRST) * part.fineness:
                raise
            base *= _FINER  # sizes between two places may leave a round face too coarse
            continue
        unknowns = 3 * len(solutions.mesh.nodes)
        say(f"{part.name}: {unknowns} unknowns, {solutions.factor.solver}; superposing the cycle")
        levels.append(_level(loaded, solutions, base, limit))
        took = perf_counter() - start


def _next_sizes(
    loaded: LoadedPart,
    levels: Sequence[Level],
    judged: Sequence[Judged],
    asked: Asked,
    enough: Callable[[Sequence[Level]], str],
    accuracy: Callable[[Sequence[Level]], float],
    took: float,
) -> SizeField | str:
    """Element sizes of the next mesh, or why there is none; "" where it would be asked for nothing.

    took  s, for the last mesh
    """
    part, level = loaded.part, levels[-1]
    asked_for = loaded.accuracy
    bars = [mesh_bar(what, levels) for what in judged] if len(levels) > 1 else [inf]
    if not judged:
        return ""
    if max(bars) <= asked_for and (asked.first >= FIRST or len(levels) > 2):
        asked_for = accuracy(levels)
        if max(bars) <= asked_for:
            return ""
    if len(levels) == _MOST_MESHES:
        return f"given up after {_MOST_MESHES} meshes"
    why = enough(levels) if len(levels) > 1 else ""
    if why:
        return why
    if len(levels) > 1 and perf_counter() + _NEXT * took > asked.deadline:
        return f"the time is up: a finer mesh would take about {_NEXT * took:.0f} s"
    recovery, mesh = level.solutions.recovery, level.solutions.mesh
    most = part.most_unknowns * len(mesh.elements) / level.unknowns
    if half_of(part, loaded.loads) is not None and not level.half:
        most *= 2  # the next mesh has half of the elements that are estimated on this one
    errors = [
        stress_error(recovery, level.solutions.displacement @ state)
        for what in judged
        for state in what.states(level)
    ]
    sharp = level.history.nodes[level.edges[0]]
    sizes, step = refined_sizes(recovery, errors, asked_for, most, sharp, level.missed_in_notches)
    if step < _LEAST_STEP and len(levels) > 1:
        return (
            f"{level.unknowns} unknowns taken, at most {part.most_unknowns} allowed "
            "(mesh.most_unknowns)"
        )
    return sizes


def first_level(loaded: LoadedPart, models: Models) -> Level:
    """Solve a whole part on its first mesh under some loads; raises MeshError and SolverError."""
    part = loaded.part
    fineness = FIRST * part.fineness
    first_mesh(part, part.geometry, fineness, models)
    solutions = models.solutions(part.geometry, fineness, elastic_of(part))
    return _level(loaded, solutions, fineness, endurance_of(part).value)


def _level(loaded: LoadedPart, solutions: UnitSolutions, fineness: float, limit: float) -> Level:
    """Superpose the cycle of a part on one mesh.

    Raises DesignError for a stated fit without contact, ContactError for an assumed one.
    """
    part = loaded.part
    try:
        return solve_level(
            solutions,
            fineness,
            loaded.loads,
            limit,
            part.material.ultimate_stress,
            loaded.duty.cycles,
            part.geometry.notch_factors,
            pinned_bores(solutions, fits_of(loaded)),
        )
    except ContactError as error:
        if part.fit_assumed:
            raise
        key = f"parts.{part.name}.fits"
        raise DesignError(loaded.design.file, key, str(error)) from error


def first_mesh(part: Part, shape: Buildable, fineness: float, models: Models) -> Mesh:
    """Return the first mesh of a part, of its whole shape or of half of it.

    Raises MeshError, and TooManyElementsError if it has more unknowns than the part may have, or
    surely would have more, by an estimate before it is made.
    """
    try:
        mesh = models.mesh(shape, fineness, None, part.most_unknowns)
    except TooManyUnknownsError as error:
        raise _too_many(part, f"would have about {error.unknowns:.2g}") from error
    unknowns = 3 * len(mesh.nodes)
    if unknowns > part.most_unknowns:
        raise _too_many(part, f"has {unknowns}")
    return mesh


def _too_many(part: Part, found: str) -> TooManyElementsError:
    return TooManyElementsError(
        f"mesh.most_unknowns is {part.most_unknowns}, but the first mesh of mesh.fineness "
        f"{part.fineness:g} {found} unknowns; allow at least twice as many, or lower mesh.fineness"
    )


def _whole_again(
    loaded: LoadedPart, models: Models, finest: Level, sizes: SizeField | None
) -> tuple[UnitSolutions, FloatArray]:
    """Solutions and coefficients of the whole part with the element sizes of a half."""
    part, loads = loaded.part, loaded.loads
    solutions = models.solutions(part.geometry, finest.fineness, elastic_of(part), sizes)
    coefficients, _ = solutions.coefficients(
        loads.wrenches, loads.accelerations, loads.reaches, loads.tilt_held_at
    )
    return solutions, coefficients


def _stress_check(loaded: LoadedPart, level: Stressed, judged: Judged, bars: Bars) -> Check:
    loads = loaded.loads
    more, why = 0.0, ""
    if isinstance(judged, FatigueUse):
        said = fatigue_words(loaded, level, judged)
        more, why = judged.band(level)
        rise = fatigue_rise(level, loads, judged)
    else:
        said = static_words(loaded, level)
        rise = static_rise(level, loads)
    check = Check(
        part=loaded.part.name,
        kind=said.kind,
        quantity=said.quantity,
        value=judged.value(level),
        unit="MPa",
        numerical=bars.numerical.value,
        model=bars.above + more,
        model_below=bars.below,
        limit=said.limit,
        required=said.required,
        cycle=said.cycle,
        position=said.position,
        place=level.place_in_words(judged.point(level), loaded.part.geometry.placed_interfaces),
        method="solid",
        basis=said.basis,
        note=". ".join(text for text in (said.note, why, bars.note) if text),
    )
    return with_sampling(check, rise)
