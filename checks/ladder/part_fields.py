"""Fields of a part at every position for a page: stress, displacement and fatigue by node."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from checks.ladder.levels import Say, first_level
from checks.models.bar_modes import Mode
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.live_fields import FATIGUE, LiveFields, LivePeak
from checks.result.verdict import PartResult
from checks.strength.fatigue_assessment import FatigueUse, FkmUse, LifeUse
from checks.strength.fkm_strength import fkm_points, slopes_of
from checks.stress.duty_verdict import DutyVerdict, NodalUse
from checks.stress.solid_mesh_level import Level, Models
from checks.stress.stress_result import Stressed
from checks.stress.symmetry import mirrored, shown_surface, surface_triangles
from fatigue.stress_path import fewer_loads
from fem.solvers import SolverError
from fem.unit_solutions import rigid_modes
from geometry.mesh import FloatArray, IntArray, MeshError, TooManyElementsError

_IMAGE = np.array([1.0, 1.0, 1.0, 1.0, -1.0, -1.0])  # of xx, yy, zz, xy, yz, zx, mirrored at z = 0
FREE_SIZE = "buckling mode: {}; its size is free"  # a note
_LOST = 1e-9  # of the largest stress: single precision, in which the page has fields, loses more
_UNJUDGED = "fatigue was not judged: no cycle of the duty loads this part"
ENDLESS = (
    "the utilisation that is drawn is that of endless life; the verdict counts a finite life "
    "(Miner's sum) at the worst point, so that 1 is no limit here"
)
_BY_CHORDS = (
    "the utilisation that is drawn is Goodman's, and Findley's where that could decide: at "
    "places that do not decide, out of phase, Findley's may be higher"
)


def solid_fields(loads: PartLoads, level: Level, use: FatigueUse | None) -> LiveFields:
    """Fields on the surface of a solid, six-node facets split in four; of the whole of a half.

    use  how its fatigue is judged; None where it is not
    """
    history, mesh = level.history, level.solutions.mesh
    nodes = history.nodes
    points, triangles = history.points, surface_triangles(mesh, nodes)
    shares, coefficients = fewer_loads(history.basis, history.coefficients, _LOST)
    stress = np.moveaxis(
        (history.basis.reshape(-1, len(shares)) @ shares).reshape(len(nodes), 6, -1), 2, 0
    )
    unit = level.solutions.moved(shares)
    moved = np.moveaxis(unit.reshape(len(mesh.nodes), 3, -1)[nodes], 2, 0)
    fatigue, missing, notes = _fatigue(level, use)
    if level.half:
        on_cut = np.isin(nodes, mesh.cut_nodes)
        points, triangles, beside = mirrored(points, triangles, on_cut)
        stress = np.concatenate([stress, stress[:, beside] * _IMAGE], axis=1)
        moved = np.concatenate([moved, moved[:, beside] * [1, 1, -1]], axis=1)
        fatigue = {name: np.r_[values, values[beside]] for name, values in fatigue.items()}
    return LiveFields(
        nodes=points,
        triangles=triangles,
        stress=stress,
        displacement=without_rigid_motion(points, moved),
        coefficients=_by_cycle(loads, coefficients),
        peaks=_by_cycle(loads, level.peaks_by_position),
        fatigue=fatigue,
        judged=bool(fatigue) and not isinstance(use, LifeUse),
        missing=missing,
        notes=notes,
        peak=_peak(loads, level, level.peak.point),
    )


def with_mode(live: LiveFields, moves: tuple[FloatArray, FloatArray] | None) -> LiveFields:
    """The fields with a buckling mode: nodes (m, 3) mm of its own mesh, motion (m, 3) of these.

    On another mesh the mean of the nearest three nodes, by the inverse of their distance.
    """
    from scipy.spatial import cKDTree

    if moves is None:
        return live
    nodes, shape = moves
    away, near = cKDTree(nodes).query(live.nodes, k=3)
    weights = 1 / np.maximum(away, 1e-9)
    moved = (weights[..., None] * shape[near]).sum(axis=1) / weights.sum(axis=1)[:, None]
    return replace(live, mode=moved / np.linalg.norm(moved, axis=1).max())


def as_it_buckles(live: LiveFields, mode: Mode, words: str) -> LiveFields:
    """The fields with a buckling mode by formula, and a note that tells what it is of, in words."""
    moved = mode(np.asarray(live.nodes))
    shape = moved / np.linalg.norm(moved, axis=1).max()
    return replace(
        live, mode=shape, notes=(*live.notes, FREE_SIZE.format(f"{words}, an estimate by formula"))
    )


def _by_cycle(loads: PartLoads, values: FloatArray) -> dict[str, FloatArray]:
    """Values (..., n) of all positions, by the cycle that these belong to."""
    return {name: values[..., columns] for name, columns in loads.cycles.items()}


def _peak(loads: PartLoads, level: Stressed, node: int) -> LivePeak:
    peak = level.peak
    cycle = next(
        name
        for name, columns in loads.cycles.items()
        if columns.start <= peak.position < columns.stop
    )
    first = loads.cycles[cycle].start
    return LivePeak(node, cycle, peak.position - first, peak.value, level.place(peak.point))


def without_rigid_motion(points: FloatArray, moved: FloatArray) -> FloatArray:
    """Displacements (M, n, 3) less the rigid motion that fits each of them best."""
    modes, _ = np.linalg.qr(rigid_modes(points))
    flat = moved.reshape(len(moved), -1)
    return np.asarray(flat - (flat @ modes) @ modes.T).reshape(moved.shape)


def _fatigue(
    level: Level, use: FatigueUse | None
) -> tuple[dict[str, FloatArray], dict[str, str], tuple[str, ...]]:
    """Fields over the duty by name, why there are none, and what is to be said of them."""
    duty = level.duty
    if duty is None or use is None:
        return {}, dict.fromkeys(FATIGUE, _UNJUDGED), ()
    found = _by_fkm(level, use, duty) if isinstance(use, FkmUse) else duty.everywhere
    fields = (found.utilisation, found.amplitude, found.mean)
    notes = [ENDLESS] if isinstance(use, LifeUse) else []
    if found.goodman_only:
        notes.append(_BY_CHORDS)
    return dict(zip(FATIGUE, fields, strict=True)), {}, tuple(notes)


def _by_fkm(level: Level, use: FkmUse, duty: DutyVerdict) -> NodalUse:
    """The use of every point by the FKM guideline's chain, on the path that uses it most."""
    n = len(level.history.nodes)
    used, amplitude, mean = np.full(n, -1.0), np.zeros(n), np.zeros(n)
    decides = use.found(level).run
    for name in sorted(duty.runs, key=lambda name: name != decides):
        bounds = duty.verdicts[name].bounds
        highest = use.strength.utilisation(bounds.amplitude, bounds.mean, use.strength.plain)
        some: IntArray = np.flatnonzero(highest * (1.0 + 1e-9) > used)
        if not len(some):
            continue
        path = np.ascontiguousarray(duty.coefficients[:, duty.runs[name]])
        found = fkm_points(use.strength, duty.basis, path, some, slopes_of(level.solutions))
        higher = found.utilisation > used[some]
        worse = some[higher]
        used[worse] = found.utilisation[higher]
        amplitude[worse], mean[worse] = found.amplitude[higher], found.mean[higher]
    return NodalUse(used, amplitude, mean)


# Stress to look at of a part whose checks needed no mesh: one solid of it, which decides nothing.
#
# `ballesta check --fields`: designers want to see where a part is stressed, also where a formula
# has settled its verdict. One mesh is enough for that; it has no error bar, and the page says so.

TO_LOOK_AT = ", to look at"  # ends the names of its fields
_UNDRAWN = "no mesh to look at: "


def with_drawn_fields(
    loaded: LoadedPart, use: FatigueUse | None, result: PartResult, models: Models, say: Say
) -> PartResult:
    """The result of a part with fields of one mesh, if its own model has none all over it.

    use  how its fatigue is judged; None where it is not

    A part that cannot be meshed or solved stays as it is, and the page says why.
    """
    loads = loaded.loads
    live = result.live
    if not isinstance(live, LiveFields) or (live.n_fields and not live.estimated):
        return result
    say(f"{loaded.part.name}: meshing, to draw its stress")
    try:
        level = first_level(loaded, models)
    except (MeshError, SolverError, TooManyElementsError) as error:
        return replace(result, live=undrawn(live, str(error)))
    methods = ", ".join(dict.fromkeys(check.method for check in result.checks))
    note = (
        "drawn from one mesh, to be looked at: its stress has no error bar and decides no check; "
        f"the checks are decided by {methods}"
    )
    drawn = solid_fields(loads, level, use)
    drawn = replace(drawn, decides=False, judged=False, notes=(note, *drawn.notes))
    surface = shown_surface(loads, level)
    named = {f"{name}{TO_LOOK_AT}": values for name, values in surface.fields.items()}
    return replace(result, live=drawn, surface=replace(surface, fields=named))


def undrawn(live: LiveFields, why: str) -> LiveFields:
    """The fields that a part has without a mesh, and why there is none."""
    told = _UNDRAWN + why
    return replace(live, missing=dict.fromkeys(live.missing, told), notes=(told, *live.notes))


def undrawn_warnings(results: Sequence[PartResult]) -> list[str]:
    """Parts whose stress was asked for and could not be drawn, and why."""
    return [
        f"{result.name}: {note}"
        for result in results
        if isinstance(result.live, LiveFields)
        for note in result.live.notes
        if note.startswith(_UNDRAWN)
    ]
