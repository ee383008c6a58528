"""The solid model of one part and its checks.

Its buckling is the lowest factor, and the surface as it buckles.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees, isfinite, radians

import numpy as np

from checks import by_formula
from checks.columns.stability import eigenvalue_check
from checks.derivations.buckling import solid_share
from checks.derivations.stresses import of_solid
from checks.design.data import Part
from checks.ladder.chart_data import charts_of
from checks.ladder.edge_checks import NotJudged, edge_fatigue, edge_static, known_at_edges
from checks.ladder.levels import (
    EVERYTHING,
    Asked,
    Say,
    assumed_pressure,
    level_on,
    none_settles,
    solve_levels,
)
from checks.ladder.part_facts import (
    assumed_of,
    contact_facts,
    edges_words,
    facts_of,
    gates_of,
    hand_checks,
    mesh_row,
)
from checks.ladder.part_fields import solid_fields, with_mode
from checks.ladder.passing_fits import (
    by_run_in_edges,
    clearances_that_pass,
    edges_that_pass,
    with_assumed_fits,
)
from checks.ladder.pin_settings import pins_data
from checks.models.stress_words import fatigue_check, fatigue_facts, static_check
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.derivation import HandComparison
from checks.result.verdict import Check, Gate, PartResult, Status, Surface
from checks.result.ways import arc_fact
from checks.store.solutions import remembered
from checks.strength.fatigue_assessment import FatigueUse, FkmUse
from checks.strength.load_doubts import AMPLITUDE, LoadBars, load_bars
from checks.strength.part_strength import amplitude_use, elastic_of, endurance_of, fatigue_use
from checks.strength.sampling import fatigue_rise, static_rise, with_sampling
from checks.stress.error_bars import Bars, arcs_of, banded, bars_of, mesh_bar, singular_edge
from checks.stress.judged import Judged, StaticPeak
from checks.stress.kept_models import judging_seconds
from checks.stress.solid_mesh_level import (
    MEANING,
    Level,
    Models,
    coefficients_of,
    mode_surface,
    shown_surface,
    solve_level,
)
from checks.stress.stress_result import Stressed
from fem.buckling import BucklingMode
from fem.contact.condensed import ContactError
from fem.lowest_modes import link_vibration
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray, MassProperties, MeshError
from geometry.progress import expect
from geometry.sizing import SizeField

_EXAGGERATED = 0.1  # of the part's size: the largest displacement of a mode as it is drawn
_COUNT = 2
RESCALED = (  # limit and meaning of the gate that proves the safety factor
    1e-6,
    "how far from 1 the fatigue safety is when all loads are multiplied by it and judged again",
)
_ARCS = tuple(radians(arc) for arc in range(105, 181, 15))  # that are tried, narrow ones first


@dataclass(frozen=True, eq=False)
class Buckled:
    """Buckling of a solid.

    checks  by its lowest factor, none without one
    untold  why there is none, in words; "" where nothing is to be said
    mode    the surface as it buckles
    moves   nodes (n, 3) mm of the mesh and their motion (n, 3) in that mode
    """

    checks: Sequence[Check] = ()
    untold: str = ""
    mode: Surface | None = None
    moves: tuple[FloatArray, FloatArray] | None = None


def check_solid(
    loaded: LoadedPart, models: Models, say: Say = lambda _: None, asked: Asked = EVERYTHING
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
    solved = by_arcs = solve_stress(loaded, models, both, judged, say, once)
    fitted = with_assumed_fits(loaded, by_arcs.finest, by_arcs.checks)
    if fitted is not None:
        say(f"{part.name}: contact of its pins")
        try:
            solved = solve_stress(fitted, models, both, judged, say, asked, by_arcs)
            loaded = fitted
        except (ContactError, MeshError):
            pass  # as where no contact is asked for: arcs, and their band, are told
    if solved is by_arcs and any(check.settled_by_mesh for check in by_arcs.checks):
        solved = solve_stress(loaded, models, both, judged, say, asked, by_arcs)
    levels, finest = solved.levels, solved.finest
    stressed, by_hand = list(solved.checks), list(solved.by_hand)
    arcs = _arcs_that_pass(loaded, levels, both, stressed, solved.doubts)
    arcs |= clearances_that_pass(by_arcs.loaded, by_arcs.finest, both, stressed, solved.bars)
    arcs |= _edges_that_pass(loaded, finest, stressed, solved.bars)
    buckled = Buckled()
    if "buckling" in asked.kinds:
        buckled = judge_buckling(by_arcs.loaded, models, levels, solved.sizes)
    assumed = assumed_of(loaded, finest)
    evened = {_kind(what): bars.evened for what, bars in solved.bars.items()}
    assumed += edges_words(loaded, evened)
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
        facts=solid_facts(loaded, levels, use, properties, asked) | arcs,
        charts=charts_of(loaded, finest, use, levels)
        | (pins_data(part, finest, solved.bars, loaded.uneven) if asked.live else {}),
        surface=shown_surface(loads, finest),
        assumed=assumed,
        mode=buckled.mode,
        live=with_mode(solid_fields(loads, finest, use), buckled.moves) if asked.live else None,
    )


@dataclass(frozen=True, eq=False)
class SolvedStress:
    """A part on its meshes, and its stress checks on the last of them.

    sizes    of the elements of the last mesh; None where it is the first
    stopped  why the accuracy was not reached, or no more was asked for
    doubts   bars of its loads
    bars     of the stresses that are judged by themselves, not by sharp edges
    """

    loaded: LoadedPart
    levels: Sequence[Level]
    sizes: SizeField | None
    stopped: str
    doubts: LoadBars
    by_hand: Sequence[HandComparison]
    checks: Sequence[Check]
    bars: Mapping[Judged, Bars]

    @property
    def finest(self) -> Level:
        """The last mesh."""
        return self.levels[-1]


def solve_stress(
    loaded: LoadedPart,
    models: Models,
    both: Sequence[Judged],
    judged: Sequence[Judged],
    say: Say,
    asked: Asked,
    before: SolvedStress | None = None,
) -> SolvedStress:
    """Solve a part on meshes as fine as is asked for, and judge its stress.

    both    the stresses that a check is made of; judged: those that meshes are refined for
    before  the same part, or it with other fits, on the first meshes
    """
    doubts: list[LoadBars] = [] if before is None else [before.doubts]
    arc = loaded.narrowest_arc
    if before is not None and before.loaded is not loaded:
        if loaded.loads.press_fits:  # no share of what the pins make, which is another now
            doubts.clear()
        if loaded.loads.rubs[0] and before.loaded.narrowest_arc != arc:
            doubts.clear()

    def widened(levels: Sequence[Level]) -> LoadBars:
        if not doubts:
            doubts.append(load_bars(loaded.loads, mesh_values(loaded, levels[0]), arc))
        return doubts[0]

    known: dict[tuple[int, Judged], _Judgement] = {}

    def judgements_of(levels: Sequence[Level], wanted: Sequence[Judged]) -> list[_Judgement]:
        for what in wanted:
            if (len(levels), what) not in known:
                known[len(levels), what] = _judgement(loaded, levels, what, widened(levels))
        return [known[len(levels), what] for what in wanted]

    def checks_of(levels: Sequence[Level]) -> list[Check]:
        return [judgement.check for judgement in judgements_of(levels, judged)]

    def enough(levels: Sequence[Level]) -> str:
        found = judgements_of(levels, judged)
        checks = [one.check for one in found]
        edges = [one.where_singular(levels) for one in found]
        return asked.enough(checks) or known_at_edges(loaded, levels, judged, checks, edges)

    def accuracy(levels: Sequence[Level]) -> float:
        left = asked.settling(checks_of(levels), levels[-1].unknowns)
        return left * max(mesh_bar(what, levels) for what in judged)

    limit = endurance_of(loaded.part).value
    begun = [] if before is None else list(before.levels)
    if before is not None and before.loaded is not loaded:
        begun = [level_on(loaded, assumed_pressure(one)[0], one.fineness, limit) for one in begun]
    levels, sizes, stopped = solve_levels(
        loaded, models, judged, limit, say, asked, enough, accuracy, begun,
        None if before is None else before.sizes,
    )  # fmt: skip
    finest = levels[-1]
    expect("judging, buckling, fields", judging_seconds(finest.unknowns))
    by_hand = hand_checks(loaded.part, loaded.loads, finest)
    # buckling alone is asked of one mesh, on which a stress has no error bar
    wanted = both if len(levels) > 1 else judged
    stressed = [
        judgement.derived(loaded, finest, by_hand) for judgement in judgements_of(levels, wanted)
    ]
    if stopped:
        stressed = [
            replace(check, note=f"{check.note}; {stopped}")
            if check.numerical - check.sampling > loaded.accuracy * check.value
            else check
            for check in stressed
        ]
    bars = {one.what: one.bars for one in judgements_of(levels, wanted) if one.own is not None}
    return SolvedStress(loaded, levels, sizes, stopped, widened(levels), by_hand, stressed, bars)


@dataclass(frozen=True, eq=False)
class _Judgement:
    """A stress judged on the last of some meshes.

    bars      of it
    own       its check by the stress itself, without a derivation; None where edges are judged
    at_edges  the check at sharp edges, or why there is none; None if they decide nothing
    """

    what: Judged
    bars: Bars
    own: Check | None
    at_edges: Check | NotJudged | None

    def where_singular(self, levels: Sequence[Level]) -> Check | NotJudged | None:
        """As `at_edges`, of a singular peak; one that grows off the edges may settle."""
        if not self.bars.numerical.singular:
            return None
        if isinstance(self.at_edges, NotJudged) and not singular_edge(self.what, levels)[1]:
            return replace(self.at_edges, finer=True)
        return self.at_edges

    @property
    def check(self) -> Check:
        """The check, without a derivation."""
        return self._of(self.own)

    def derived(self, loaded: LoadedPart, level: Level, by_hand: Sequence[HandComparison]) -> Check:
        """The check, with its derivation where it is one of the stress itself."""
        if self.own is None:
            return self.check
        part, loads = loaded.part, loaded.loads
        return self._of(of_solid(part, loads, level, self.what, self.bars, self.own, by_hand))

    def _of(self, own: Check | None) -> Check:
        if isinstance(self.at_edges, Check):
            return self.at_edges
        assert own is not None
        return replace(own, note=f"{own.note}; {self.at_edges.why}") if self.at_edges else own


def _judgement(
    loaded: LoadedPart, levels: Sequence[Level], what: Judged, doubts: LoadBars
) -> _Judgement:
    """Judge a stress on the last mesh."""
    bars = bars_of(what, loaded.part, levels, loaded.accuracy, loaded.uneven, loaded.loose)
    own = doubts(stress_check(loaded, levels[-1], what, bars))
    at_edges = _edges_judged(loaded, levels, what, bars)
    if isinstance(at_edges, Check):
        return _Judgement(what, bars, None, doubts(at_edges))
    return _Judgement(what, bars, own, at_edges)


def _edges_judged(
    loaded: LoadedPart, levels: Sequence[Level], what: Judged, bars: Bars
) -> Check | NotJudged | None:
    """The check of a part with sharp edges, or why there is none where the peak lies on one.

    Fatigue of edges is judged wherever it can be: what elements show there may be far less than the
    stress that counts. None where edges decide nothing.
    """

    def make(level: Stressed, bars: Bars) -> Check:
        return stress_check(loaded, level, what, bars)

    if not all(len(level.edges[0]) for level in levels):
        return None
    if isinstance(what, FatigueUse):
        if not bars.numerical.singular and loaded.part.material.threshold is None:
            return None
        judged = edge_fatigue(loaded, levels, what, make)
        return judged if isinstance(judged, Check) or bars.numerical.singular else None
    if not bars.numerical.singular:
        return None
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
    None where contact is solved in every bore: no arc is assumed then.
    """
    if not arcs_of(loaded.part, levels[-1]):
        return {}

    def passes(what: Judged, arc: float) -> bool:
        closer = replace(loaded, part=replace(loaded.part, bearing_arc=arc, arc_stated=True))
        return _judgement(closer, levels, what, doubts).check.status is Status.PASS

    found = {}
    for what in judged:
        kind = _kind(what)
        for check in checks:
            if check.kind != kind or check.status is not Status.UNDECIDED:
                continue
            if check.settled_by_mesh or not isfinite(check.numerical):
                continue
            wider = [arc for arc in _ARCS if arc > loaded.part.bearing_arc]
            if wider and passes(what, wider[-1]):
                found[arc_fact(kind)] = degrees(next(arc for arc in wider if passes(what, arc)))
    return found


def _edges_that_pass(
    loaded: LoadedPart, level: Level, checks: Sequence[Check], bars: Mapping[Judged, Bars]
) -> dict[str, float]:
    """As `edges_that_pass` and `by_run_in_edges`, on the last mesh.

    Singular checks and those at edges are left out.
    """
    by_kind = {_kind(what): what for what in bars}
    finite = {
        check.kind: check for check in checks if isfinite(check.numerical) and check.kind in by_kind
    }

    def again(other: LoadedPart, kind: str) -> tuple[Check, Check]:
        check, what = finite[kind], by_kind[kind]
        now = bars[what]
        tried = banded(now, what, other.part, level, other.uneven, other.loose)
        others = max(0.0, check.model - now.above)  # the loads' bars, another criterion's
        steel = replace(check, model=others + tried.above_steel)
        return replace(check, model=others + tried.above), steel

    judged = list(finite.values())
    return edges_that_pass(loaded, judged, again) | by_run_in_edges(loaded, judged, again)


def _kind(what: Judged) -> str:
    return "static" if isinstance(what, StaticPeak) else "fatigue"


def mesh_values(loaded: LoadedPart, level: Level) -> Callable[[PartLoads], Mapping[str, float]]:
    """A function for the stress checks' values on one mesh under other loads, by kind.

    Only their ratios count: pressures are the assumed ones, whose stress grows with the force.
    Contact's grows less.
    """
    part = loaded.part
    solutions, _ = assumed_pressure(level)

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
            if loads.rubs[1]:
                values[AMPLITUDE] = amplitude_use(loaded.under(loads)).value(other)
        return values

    return values_of


def solid_facts(
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
        facts |= fatigue_facts(finest, use.worst(finest))
    return facts


def stress_check(loaded: LoadedPart, level: Stressed, judged: Judged, bars: Bars) -> Check:
    """The check of a stress with its bars, without a derivation and the doubts about its loads."""
    loads = loaded.loads
    more, why = 0.0, ""
    if isinstance(judged, FatigueUse):
        check = fatigue_check(loaded, level, judged, "solid")
        more, why = judged.band(level)
        rise = fatigue_rise(level, loads, judged)
    else:
        check = static_check(loaded, level, "solid")
        rise = static_rise(level, loads)
    check = replace(
        check,
        numerical=bars.numerical.value,
        model=bars.above + more,
        model_below=bars.below,
        note=". ".join(text for text in (check.note, why, bars.note) if text),
    )
    return with_sampling(check, rise)


def judge_buckling(
    loaded: LoadedPart, models: Models, levels: Sequence[Level], sizes: SizeField | None
) -> Buckled:
    """Ask the whole solid for its lowest factor; of finer halves a whole one where it decides.

    Where pins press in their bores does not matter to it: pressures are the assumed ones.

    sizes  of the elements of the last mesh
    """
    finest = levels[-1]
    whole = [assumed_pressure(level) for level in levels if not level.half]
    found = eigenvalue_check(loaded, whole, finest.peak.position)
    if found and found[0].status is Status.UNDECIDED and finest.half:
        whole.append(_whole_again(loaded, models, finest, sizes))
        found = eigenvalue_check(loaded, whole, finest.peak.position)
    if found:
        check, mode = found
        unknowns = whole[-1 if "two" in check.method else 0][0].loads.shape[0]
        derivation = solid_share(loaded, check, mode, unknowns)
        return Buckled([replace(check, derivation=derivation)], "", *_mode_of(whole, mode))
    if levels[0].solutions.ties is not None:
        said = "buckling of a stack of bodies that slide on each other is not computed"
        return Buckled(untold=said)
    if loaded.part.body is None:
        return Buckled()
    return Buckled(
        untold="the solid does not buckle at the positions asked: no factor is positive before its "
        "stress is a tenth of Young's modulus"
    )


def _mode_of(
    whole: Sequence[tuple[UnitSolutions, FloatArray]], mode: BucklingMode
) -> tuple[Surface, tuple[FloatArray, FloatArray]]:
    """The surface of the mesh that a mode was found on, displaced by a part of its size.

    And nodes and motion of that mesh.
    """
    for solutions, _ in whole:
        mesh = solutions.mesh
        if len(mesh.nodes) == len(mode.shape):
            moved = _EXAGGERATED * float(np.ptp(mesh.nodes, axis=0).max()) * mode.shape
            size = np.linalg.norm(mode.shape, axis=1)
            surface = mode_surface(mesh, solutions.recovery.points, moved, size / size.max())
            return surface, (mesh.nodes, mode.shape)
    raise AssertionError("a mode is of one of the meshes that it was sought on")


def _whole_again(
    loaded: LoadedPart, models: Models, finest: Level, sizes: SizeField | None
) -> tuple[UnitSolutions, FloatArray]:
    """Solutions and coefficients of the whole part with the element sizes of a half."""
    part, loads = loaded.part, loaded.loads
    solutions = models.solutions(part.geometry, finest.fineness, elastic_of(part), sizes)
    return solutions, coefficients_of(solutions, loads)[0]


# Natural frequencies of a part by itself, its pins standing still.


def frequency_facts(part: Part, solutions: UnitSolutions) -> dict[str, float | str]:
    """The lowest natural frequencies of a part of one body between its pins, by name.

    On the mesh given, ends free to tilt, which is the lower bound of what forks make of them.
    Nothing for pins, for stacks and for parts with fewer than two interfaces.
    """
    if part.body is None or solutions.ties is not None or len(solutions.interfaces) < 2:
        return {}
    found = remembered(
        solutions,
        "vibration",
        (part.tilt_held_at, _COUNT),
        lambda: link_vibration(
            solutions, tilt_held=False, twist_held_at=part.tilt_held_at, count=_COUNT
        ),
    )
    said = [
        f"{hertz:.4g} {_plane(shape)}"
        for hertz, shape in zip(found.hertz, found.shapes, strict=True)
    ]
    name = "natural frequencies between still pins, forks that let it tilt [Hz]"
    return {name: ", ".join(said) + "; counted: none is lower"}


def _plane(shape: np.typing.NDArray[np.float64]) -> str:
    """In which plane a mode (n_nodes, 3) moves most."""
    sideways = np.abs(shape[:, 2]).max() > np.abs(shape[:, :2]).max()
    return "out of plane" if sideways else "in plane"
