"""Result of a part that climbed the ladder, meshed or not."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf
from time import perf_counter

import numpy as np

from checks import by_formula
from checks.columns.stability import ELASTIC, axial_compression
from checks.design.effort import FORMULA, SOLID
from checks.ladder.chart_data import charts_of
from checks.ladder.climb import Climb, answered
from checks.ladder.leaf_checks import friction_facts, friction_gates, leaf_band, with_leaf_checks
from checks.ladder.levels import Asked, Say, first_of
from checks.ladder.part_facts import SMALL_DISPLACEMENT, edges_words, facts_of
from checks.ladder.part_fields import as_it_buckles, section_fields
from checks.ladder.passing_fits import by_run_in_edges, edges_that_pass
from checks.ladder.solid import RESCALED, check_solid
from checks.models.checked import BALANCE, BUCKLING, FATIGUE, STATIC, Estimate
from checks.models.stress_words import fatigue_facts
from checks.part.part_loads import PartLoads
from checks.result.live_fields import LiveFields
from checks.result.verdict import (
    NOT_MESHED,
    Check,
    Gate,
    PartResult,
    RungTried,
    Status,
    Surface,
    deciding_of,
)
from checks.result.ways import mesh_that_settles
from checks.strength.load_doubts import LoadBars, load_bars
from checks.strength.part_strength import endurance_of
from checks.stress.solid_mesh_level import Models
from checks.stress.stress_result import RungLevel
from fem.recovery import LARGEST_RATIO, MEANING
from geometry.cad_body import Skin

_HARDLY = 1e-3  # of the largest force: less compression is none


def cheap_result(climb: Climb, models: Models, *, live: bool = False) -> PartResult:
    """Result of a part whose verdict needed no solid.

    live  whether a page will show the fields at every position
    """
    loaded, part, loads = climb.loaded, climb.part, climb.loads
    level = climb.level
    assert level is not None
    body = models.body(part.geometry)
    mass = body.mass_properties(part.material.density)
    size = body.size
    facts = facts_of(part, loads, mass, size, endurance_of(part))
    facts |= by_formula.facts(loaded)
    facts |= friction_facts(loaded)
    gates = [*rung_gates(climb, level, size), *friction_gates(loaded)]
    peak = None
    if climb.use is not None:
        peak = climb.use.worst(level)
        facts |= fatigue_facts(level, peak)
        missed = climb.use.safety_missed(level)
        gates.append(Gate(f"{part.name}: fatigue safety", missed, *RESCALED))
    facts |= edges_that_pass(loaded, answered(climb), climb.with_edges)
    facts |= by_run_in_edges(loaded, answered(climb), climb.with_edges)
    bores = {kind: climb.best[kind].bores for kind in (STATIC, FATIGUE) if kind in climb.best}
    bent = {kind: one.evened if one else 0.0 for kind, one in bores.items()}
    assumed = [f"{FORMULA}: {level.model.neglects}", *edges_words(loaded, bent)]
    skin = models.skin(part.geometry)
    return PartResult(
        name=part.name,
        shape=part.shape,
        material=part.material.name,
        checks=answered(climb),
        gates=gates,
        hand_checks=[],
        meshes=[],
        facts=facts,
        charts=charts_of(loaded, level, climb.use),
        surface=_unstressed(skin),
        assumed=assumed,
        rungs=climb.tried,
        live=section_fields(loaded, skin, climb.use) if live else None,
    )


def with_mode_by_formula(climb: Climb, result: PartResult) -> PartResult:
    """The result with the formula's buckling mode, where its elastic load governs all checks."""
    live, level = result.live, climb.level
    if not isinstance(live, LiveFields) or live.mode is not None:
        return result
    if level is None or not result.checks:
        return result
    governing, load = deciding_of(result.checks), level.model.buckling
    if governing.quantity != ELASTIC.quantity or governing.method != FORMULA:
        return result
    if load is None or load.mode is None:
        return result
    return replace(result, live=as_it_buckles(live, load.mode, load.words))


def rung_gates(climb: Climb, level: RungLevel, size: float) -> list[Gate]:
    """Gates that must hold for a rung's answer to count; size of the part in mm."""
    name, model = climb.part.name, level.model
    missing = [kind for kind in climb.asked if kind not in climb.best]
    if climb.unbuckled and BUCKLING in missing:
        missing.remove(BUCKLING)
    gates = [
        Gate(
            f"{name}: balance",
            model.residual,
            BALANCE,
            f"what is left of the part's balance by the rung {FORMULA}, over the largest force",
        ),
        Gate(
            f"{name}: small displacements",
            model.deflection / size,
            SMALL_DISPLACEMENT,
            "largest displacement over the part's size, by the same model; linear theory makes "
            "bending moments too large by up to 2.4 times its square",
        ),
        Gate(
            f"{name}: compressible material",
            climb.part.material.poisson_ratio,
            LARGEST_RATIO,
            MEANING,
        ),
    ]
    if missing:
        told = f"not answered by the rung that was asked for: {', '.join(missing)}"
        gates.append(Gate(f"{name}: every check was made", float(len(missing)), 0.0, told))
    return gates


def _unstressed(skin: Skin) -> Surface:
    return Surface(skin.nodes, skin.triangles, {NOT_MESHED: np.zeros(len(skin.nodes))}, 0)


def solid_result(
    climb: Climb,
    models: Models,
    say: Say,
    *,
    everything: bool,
    deadline: float = inf,
    pinned: frozenset[str] | None = None,
    live: bool = False,
) -> PartResult:
    """Check a part as a solid: all of it, or what the rungs below left open.

    pinned  kinds of checks that are the solid's, refined to the accuracy whatever the verdict
    live    whether a page will show the fields at every position
    """
    loaded = climb.loaded
    start = perf_counter()
    kinds = frozenset(climb.asked if everything else climb.open)
    enough, settling = _by_verdict(climb)
    asked = Asked(kinds | frozenset([STATIC, FATIGUE, BUCKLING])) if everything else Asked(
        kinds,
        modes=False,
        first=first_of(loaded.accuracy, kinds),
        enough=enough,
        settling=settling,
        deadline=deadline,
    )  # fmt: skip
    if pinned is not None:
        kinds, asked = pinned, Asked(pinned, modes=False)
    result = check_solid(loaded, models, say, replace(asked, live=live))
    result = with_leaf_checks(loaded, result, models)
    result = replace(result, checks=[_buckling_doubted(climb, c) for c in result.checks])
    checks = [check for check in result.checks if check.method.startswith(SOLID)]
    solid = RungTried(
        SOLID,
        perf_counter() - start,
        int(result.meshes[-1]["unknowns"]),
        [replace(check, derivation=None) for check in checks],  # the result's own have them
        _why(checks, loaded.accuracy),
    )
    if not everything:
        result = replace(
            result, checks=_merged(climb, result.checks, kinds, exactly=pinned is not None)
        )
    return replace(result, rungs=[*climb.tried, solid])


def _buckling_doubted(climb: Climb, check: Check) -> Check:
    """A solid's buckling check with its load bars: of the formula, the forces and the compression.

    Under loads of one pattern it goes with them all; an eigenvalue at the ends of each doubt would
    cost as much as the solid. A pull may be the largest force, and stay as it is.
    """
    if check.kind != BUCKLING or not check.method.startswith(SOLID):
        return check

    least = _HARDLY * climb.loads.largest_force

    def pushed(some: PartLoads) -> dict[str, float]:
        return {BUCKLING: max(least, float(axial_compression(climb.part, some).max()))}

    bars = [
        load_bars(climb.loads, lambda some: {BUCKLING: some.largest_force}),
        load_bars(climb.loads, pushed),
        *([climb.doubts] if climb.doubts else []),
    ]
    shares: dict[str, list[float]] = {}
    for one in bars:
        for words, ends in one.shares.get(BUCKLING, {}).items():
            shares.setdefault(words, []).extend(ends)
    return LoadBars({BUCKLING: shares})(check)


def _by_verdict(
    climb: Climb,
) -> tuple[Callable[[Sequence[Check]], str], Callable[[Sequence[Check], float], float]]:
    """Why no finer mesh is needed, and what a finer one must leave of the bars, by checks."""
    band = leaf_band(climb.loaded)

    def enough(checks: Sequence[Check]) -> str:
        estimates = [Estimate(band(check)) for check in checks]
        failed = [e.check.kind for e in estimates if e.check.status is Status.FAIL]
        if failed:
            return f"fails already ({', '.join(failed)}): no finer mesh would make it pass"
        if all(estimate.settled or estimate.open_for_good for estimate in estimates):
            return "settled: no finer mesh changes the verdict"
        return ""

    def settling(checks: Sequence[Check], unknowns: float) -> float:
        left = 1.0
        for check in map(band, checks):
            share, more = mesh_that_settles(check)
            if share and unknowns * more <= climb.part.most_unknowns:
                left = min(left, share * check.value / check.numerical)
        return left

    return enough, settling


def _merged(
    climb: Climb, checks: Sequence[Check], kinds: frozenset[str], *, exactly: bool
) -> list[Check]:
    """The checks of a solid, but for those that a rung below knows better or alone.

    exactly  no check of a solid stands for a rung's that was not asked of the solid
    """
    merged = []
    for check in checks:
        best = climb.best.get(check.kind)
        by_solid = check.method.startswith(SOLID)
        if by_solid and check.kind not in kinds and best and (exactly or _better(best, check)):
            merged.append(best.check)
        else:
            merged.append(check)
    here = {check.kind for check in checks if check.method.startswith(SOLID)} | kinds
    alone = {k: climb.best[k].check for k in climb.asked if k in climb.best and k not in here}
    buckling = [alone.pop(BUCKLING)] if BUCKLING in alone else []
    return [*alone.values(), *merged, *buckling]


def _better(best: Estimate, check: Check) -> bool:
    """True if a rung's settled estimate is to stand instead of one that a mesh gave besides."""
    by_mesh = Estimate(check)
    return best.settled and by_mesh.spread > best.spread and best.agrees(by_mesh)


def _why(checks: Sequence[Check], accuracy: float) -> str:
    left = [check for check in checks if check.status is Status.UNDECIDED]
    if not left:
        return "stopped: " + "; ".join(f"{check.kind} {check.status}" for check in checks)
    by_mesh = [check.kind for check in left if check.settled_by_mesh]
    if by_mesh:
        return (
            f"stopped: {', '.join(by_mesh)} would take a numerical error below the "
            f"{100 * accuracy:g} % asked for, or more unknowns than allowed"
        )
    return "stopped: " + "; ".join(f"{c.kind} stays UNDECIDED by its model band" for c in left)
