"""A part as a solid on one mesh, carried over from a part of nearly the same dimensions.

The neighbour is solved on several meshes. The first one whose bars are as narrow as was asked for,
carried over, has the same elements at the same places, so a stress there errs by nearly the same
share of itself: by the step from that mesh to the neighbour's finest, a third more, and by what is
left on that one. A measured factor and a share cover what the dimensions between the two parts add.
The model band is the one on the neighbour's finest mesh, as coarse elements even a pressure out,
and a share of its whole width more on each side.

Where a stress is largest at a place that the neighbour does not know, where an element folds or the
bodies differ in more than dimensions, the part needs meshes of its own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter

import numpy as np

from checks.design.effort import SOLID
from checks.ladder.chart_data import charts_of
from checks.ladder.climb import Climb
from checks.ladder.levels import COARSE, Asked, Say, level_on
from checks.ladder.part_facts import assumed_of, gates_of, hand_checks, mesh_row
from checks.ladder.solid import RESCALED, mesh_values, solid_facts, solve_stress, stress_check
from checks.part.loaded_part import LoadedPart
from checks.part.pressed_along import that_count
from checks.result.verdict import Check, Gate, PartResult, RungTried, Surface
from checks.strength.load_doubts import load_bars
from checks.strength.part_strength import elastic_of, endurance_of, fatigue_use
from checks.stress.error_bars import Bars, pressed_points
from checks.stress.judged import Judged, StaticPeak
from checks.stress.solid_mesh_level import MEANING, Level, Models, half_of, surface_triangles
from fem.convergence import ErrorBar
from fem.recovery import von_mises
from geometry.carrying import Carrier
from geometry.mesh import FloatArray, IntArray, Mesh, MeshError
from geometry.shape import Buildable

METHOD = "solid, mesh carried over"
WIDER = 1.25  # times the neighbour's numerical bars (bench/swept.py)
ADDED = (
    0.01  # of the stress: another peak of the same place, which the neighbour's bar may not know
)
_BAND = 0.25  # of the whole width of its model band, that each side is wider
_BESIDE = 2.0  # elements: two places that are nearer are one
_COMPETES = 0.75  # of the largest: places that another part may have its peak at
_PLACES = 24


@dataclass(frozen=True)
class Place:
    """A place where a stress of the neighbour is large.

    node    of the mesh that is carried over
    reach   mm, within which a peak is at this place
    error   of that mesh there, over the value
    """

    node: int
    reach: float
    error: float


@dataclass(frozen=True, eq=False)
class Neighbour:
    """A part of nearly the same dimensions, solved.

    shape     that was meshed: all of the part, or its half
    mesh      the first one that is fine enough
    fineness  of that mesh
    places    kind of check -> where its stress is large
    bands     kind of check -> model band above and below, over the value
    bent      kind of check -> bores whose bent pin is in that band
    loose     kind of check -> what loose pins add to that band, over the value
    """

    shape: Buildable
    mesh: Mesh
    fineness: float
    places: Mapping[str, Sequence[Place]]
    bands: Mapping[str, tuple[float, float]]
    bent: Mapping[str, frozenset[str]]
    loose: Mapping[str, float]

    @cached_property
    def carrier(self) -> Carrier:
        """Carrier of its mesh; raises MeshError."""
        return Carrier(self.mesh, self.shape)


def neighbour_of(loaded: LoadedPart, models: Models) -> Neighbour | str:
    """Solve a part whose mesh others are to have; in words, why none may have it.

    Raises MeshError and SolverError.
    """
    if loaded.part.fkm is not None:
        return "FKM's chain asks for the stress below the surface"
    judged = judged_of(loaded)
    both, asked = list(judged.values()), Asked(frozenset(judged), modes=False, first=COARSE)
    solved = solve_stress(loaded, models, both, both, lambda _: None, asked)
    finest = solved.finest
    if all(len(level.edges[0]) for level in solved.levels):
        return "it has sharp edges, which are judged apart"
    left, bands = {}, {}
    for kind, what in judged.items():
        bars, value = solved.bars[what], what.value(finest)
        if bars.numerical.singular or not value > 0.0:
            return f"its {kind} stress has no finite error bar"
        left[kind] = bars.numerical.value / value
        bands[kind] = bars.above / value, bars.below / value
    for level in solved.levels:
        places = {kind: _places(what, level, finest, left[kind]) for kind, what in judged.items()}
        if all(WIDER * known[0].error <= loaded.accuracy for known in places.values()):
            mesh = level.solutions.mesh
            bent = {kind: _bent(loaded, kind) for kind in judged}
            loose = {kind: _loosely(loaded, kind, what, finest) for kind, what in judged.items()}
            return Neighbour(_meshed(loaded), mesh, level.fineness, places, bands, bent, loose)
    return "its error bars are wider than was asked for"


def _bent(loaded: LoadedPart, kind: str) -> frozenset[str]:
    """Bores whose bent pin is in the band of a kind of check."""
    return frozenset(that_count(loaded.part, loaded.uneven, static=kind == "static"))


def _loosely(loaded: LoadedPart, kind: str, what: Judged, level: Level) -> float:
    """The most that loose pins add to the band of a stress, over the value."""
    value = what.value(level)
    bent = {bore: loaded.uneven[bore].most for bore in _bent(loaded, kind)}
    adds = [
        what.of_pressure(level, points, more.times(bent.get(bore, 1.0)))
        for bore, more in loaded.loose.items()
        if len(points := pressed_points(loaded.loads, level, bore))
    ]
    return max(adds, default=0.0) / value if value else 0.0


def judged_of(loaded: LoadedPart) -> dict[str, Judged]:
    """The stresses that a part is judged by, by kind of check."""
    use = fatigue_use(loaded)
    found: dict[str, Judged] = {"static": StaticPeak(loaded.loads)}
    return found if use is None else {**found, "fatigue": use}


def _meshed(loaded: LoadedPart) -> Buildable:
    return half_of(loaded.part, loaded.loads) or loaded.part.geometry


def _places(what: Judged, first: Level, finest: Level, left: float) -> list[Place]:
    """Where a stress is large; left: error of the finest mesh, over the value."""
    every = np.arange(len(first.history.nodes))
    bound = what.bound(first, every)
    bound[first.left_out] = 0.0
    bound[what.point(first)] = np.inf
    found: list[Place] = []
    while len(found) < _PLACES:
        point = int(bound.argmax())
        if bound[point] < _COMPETES * what.value(first):
            break
        reach = _BESIDE * first.size_at(point)
        at = first.history.points[point]
        coarse, fine = (_largest(what, level, at, reach) for level in (first, finest))
        error = left + (4 / 3) * abs(fine / coarse - 1.0)
        found.append(Place(int(first.history.nodes[point]), reach, error))
        bound[_near(first, at, reach)] = 0.0
    return found


def _near(level: Level, at: FloatArray, reach: float) -> IntArray:
    return np.flatnonzero(np.linalg.norm(level.history.points - at, axis=1) <= reach)


def _largest(what: Judged, level: Level, at: FloatArray, reach: float) -> float:
    """The quantity within a reach of a place, MPa."""
    points = np.union1d(_near(level, at, reach), [level.nearest(at)])
    points = np.setdiff1d(points, level.left_out)
    return what.anew(level, points, level.history.basis[points], level.coefficients)


def carried_result(
    climb: Climb, neighbour: Neighbour, models: Models, say: Say
) -> PartResult | str:
    """Judge a part's stress on its neighbour's mesh; in words, why it needs meshes of its own.

    climb  of the part; its other checks stand beside

    Raises SolverError.
    """
    loaded, start = climb.loaded, perf_counter()
    part, loads, shape = loaded.part, loaded.loads, _meshed(loaded)
    if type(shape) is not type(neighbour.shape):
        return "only one of the two is its own mirror image"
    judged = judged_of(loaded)
    for kind in judged:
        if not _bent(loaded, kind) <= neighbour.bent[kind]:
            return f"its bent pin is in the band of {kind}, the neighbour's is not"
    limit = endurance_of(part).value
    try:
        say(f"{part.name}: {3 * len(neighbour.mesh.nodes)} unknowns, a mesh carried over")
        solutions = models.carried(neighbour.carrier, shape, elastic_of(part))
        level = level_on(loaded, solutions, neighbour.fineness, limit)
    except MeshError as error:
        return f"carried over, {error}"
    doubts = load_bars(loads, mesh_values(loaded, level), loaded.narrowest_arc)
    checks: list[Check] = []
    for kind, what in judged.items():
        share = _error_of(what, level, neighbour, kind)
        if share is None:
            return f"its {kind} stress is largest where the neighbour's is not large"
        value = what.value(level)
        off = WIDER * share + ADDED
        bar = ErrorBar(off * value, 0.0, 0.0, value)
        above, below = (
            value * (one + _BAND * sum(neighbour.bands[kind])) for one in neighbour.bands[kind]
        )
        above += value * max(0.0, _loosely(loaded, kind, what, level) - neighbour.loose[kind])
        said = "error bars by a neighbour of nearly the same dimensions"
        if off > loaded.accuracy:
            more = f"numerical error {100 * off:.2g} %, asked for"
            said = f"{more} {100 * loaded.accuracy:g} %; {said}"
        bars = Bars(bar, above, below, said)
        checks.append(doubts(replace(stress_check(loaded, level, what, bars), method=METHOD)))
    properties = models.body(part.geometry).mass_properties(part.material.density)
    gates = gates_of(loaded, [level], properties)
    if climb.use is not None:
        gates.append(
            Gate(f"{part.name}: fatigue safety", climb.use.safety_missed(level), *RESCALED)
        )
    why = "the mesh of a neighbour on the grid of dimensions, its error bars made wider"
    tried = RungTried(SOLID, perf_counter() - start, level.unknowns, checks, why)
    return PartResult(
        name=part.name,
        shape=part.shape,
        material=part.material.name,
        checks=[*checks, *(best.check for kind, best in climb.best.items() if kind not in judged)],
        gates=gates,
        hand_checks=hand_checks(part, loads, level),
        meshes=[{"body": "half" if level.half else "whole", **mesh_row(level)}],
        facts=solid_facts(loaded, [level], climb.use, properties, Asked(modes=False)),
        charts=charts_of(loaded, level, climb.use, [level]),
        surface=_surface(level),
        assumed=[*assumed_of(loaded, level), *([MEANING] if level.half else [])],
        rungs=[*climb.tried, tried],
    )


def _surface(level: Level) -> Surface:
    """The part's surface that is meshed, at the position of its peak."""
    stress = von_mises(level.history.at(level.peak.position))
    triangles = surface_triangles(level.solutions.mesh, level.history.nodes)
    return Surface(level.history.points, triangles, {"von Mises [MPa]": stress}, level.peak.point)


def _error_of(what: Judged, level: Level, neighbour: Neighbour, kind: str) -> float | None:
    """Error of a stress over itself, by the neighbour; None where it does not know the place."""
    nodes = neighbour.mesh.nodes
    here = nodes[level.history.nodes[what.point(level)]]
    known = [
        place.error
        for place in neighbour.places[kind]
        if float(np.linalg.norm(nodes[place.node] - here)) <= place.reach
    ]
    return max(known, default=None)
