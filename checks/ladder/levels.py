"""Finer and finer meshes of a part, until its stress is known well enough."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from math import inf
from time import perf_counter

from checks.design.data import Part
from checks.design.errors import DesignError
from checks.part.loaded_part import FIRST, LoadedPart
from checks.result.verdict import Check
from checks.result.words import TOO_MANY
from checks.strength.part_strength import elastic_of, endurance_of
from checks.stress.error_bars import mesh_bar
from checks.stress.judged import Judged
from checks.stress.kept_models import check_seconds
from checks.stress.pins_in_bores import fits_of, pinned_bores
from checks.stress.solid_mesh_level import Level, Models, half_of, solve_level
from fem.contact.condensed import ContactError
from fem.recovery import refined_sizes, stress_error
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray, Mesh, MeshError, TooManyElementsError, TooManyUnknownsError
from geometry.shape import Buildable
from geometry.sizing import SizeField

# Fineness of the first mesh for a verdict on stress alone, and the accuracy from which on.
COARSE, LOOSE = 0.5, 0.05
_MOST_MESHES = 5
_NEXT = 2.5  # times what a mesh took, a finer one takes
_FINER = 1.3  # general elements, where a mesh with small ones in places is not usable
_FOR_THE_SECOND = 0.5  # of the unknowns: a third mesh has a bar that the second one may not have
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
    """Solve a part on finer and finer meshes, from a coarse one where the first would be too large.

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
            if not levels and asked.first > COARSE:
                asked = replace(asked, first=COARSE)
                base = COARSE * part.fineness
                continue
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
        levels.append(level_on(loaded, solutions, base, limit))
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
    if len(levels) == 1:
        most *= _FOR_THE_SECOND
    if half_of(part, loaded.loads) is not None and not level.half:
        most *= 2  # the next mesh has half of the elements that are estimated on this one
    errors = [
        stress_error(recovery, level.solutions.moved(state))
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
    return level_on(loaded, solutions, fineness, endurance_of(part).value)


def level_on(loaded: LoadedPart, solutions: UnitSolutions, fineness: float, limit: float) -> Level:
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


def assumed_pressure(level: Level) -> tuple[UnitSolutions, FloatArray]:
    """Unit loads of a mesh and coefficients (n_basis, n), without waves of contact."""
    if level.contact is None:
        return level.solutions, level.coefficients
    return level.contact.pins.solutions, level.contact.assumed


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


def planned_mesh(part: Part, models: Models) -> Mesh:
    """The first mesh of a part's whole shape, as `solve_levels` takes it."""
    try:
        return first_mesh(part, part.geometry, FIRST * part.fineness, models)
    except TooManyElementsError:
        return first_mesh(part, part.geometry, COARSE * part.fineness, models)


def _too_many(part: Part, found: str) -> TooManyElementsError:
    return TooManyElementsError(
        f"{TOO_MANY} is {part.most_unknowns}, but the first mesh of mesh.fineness "
        f"{part.fineness:g} {found} unknowns; allow at least twice as many, or lower mesh.fineness"
    )
