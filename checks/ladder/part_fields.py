"""Fields of a part at every position for a page: stress, displacement and fatigue by node.

A part that no mesh was solved for has an estimate all over it, by its section forces: normal force,
bending and mean shear in the part's own sections, cut from its surface: what a reader needs to see
where such a part is stressed. Bores and slots weaken the sections; the peaks beside them, and at
fillets and pressed edges, are not in it. It decides no check.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from checks.design.data import Duty, Part
from checks.handbook.pin_diagrams import pin_diagram
from checks.ladder.levels import Say, first_level
from checks.models.bar_modes import Mode
from checks.models.formula_bars import Stretches, bar_loads
from checks.models.formula_points import XX, XY, YZ, ZX, ZZ
from checks.models.shapes.leaf_pack import leaf_bar
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.live_fields import FATIGUE, LiveFields, LivePeak
from checks.result.verdict import PartResult
from checks.strength.fatigue_assessment import FatigueUse, FkmUse, LifeUse
from checks.strength.fkm_strength import fkm_points, slopes_of
from checks.stress.duty_verdict import DutyVerdict, NodalUse, duty_runs
from checks.stress.solid_mesh_level import Level, Models, mirrored, shown_surface, surface_triangles
from checks.stress.stress_result import Stressed
from fatigue import goodman
from fatigue.stress_path import fewer_loads
from fem.solvers import SolverError
from fem.unit_solutions import rigid_modes
from geometry.cad_body import Skin
from geometry.mesh import FloatArray, IntArray, MeshError, TooManyElementsError
from geometry.parts import LeafPack, Pin
from geometry.parts.leaf_pack import as_leaves
from geometry.parts.pin import as_pin

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
NOTE = (
    "estimate: stress of the section forces (normal force, bending, mean shear) in the part's own "
    "sections; peaks at bores, fillets and pressed edges, which the checks count, are not in it; "
    "ballesta check --fields meshes the part, to look at"
)
PRESSED = (
    "lugs that press on a bent pin relieve its rim, which its checks count and the estimate leaves "
    "out: it may be higher than theirs"
)
_UNMOVED = "no displacement: it is estimated from section forces, without a mesh"
_BY_FKM = "the FKM guideline judges the part: its use is not estimated from section forces"
_SECTIONS = 49
_ASIDE = 1e-7  # of the length, off a section, so that no node lies on it
_THIN = 0.02  # of the largest area: a section at a round end, which nothing goes through
_KEPT = 1e-3  # of the largest singular value of the section forces
_TOGETHER = 1_000_000  # numbers of stress that are looked at together
_JUDGED = 48  # positions of the duty that fatigue is estimated at, with all extremes of the forces


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


def section_fields(loaded: LoadedPart, skin: Skin, use: FatigueUse | None) -> LiveFields:
    """Return the estimate on a part's surface at every position.

    use  how its fatigue is judged; None where it is not
    """
    part, loads = loaded.part, loaded.loads
    basis, coefficients = _superposition(part, loads, skin)
    peaks = _peaks(basis, coefficients)
    fields = LiveFields(
        nodes=skin.nodes,
        triangles=skin.triangles,
        stress=basis,
        displacement=None,
        coefficients={name: coefficients[:, columns] for name, columns in loads.cycles.items()},
        peaks={name: peaks[columns] for name, columns in loads.cycles.items()},
        decides=False,
        estimated=True,
        missing={"displacement": _UNMOVED},
        notes=(NOTE,) if as_pin(part.geometry) is None else (NOTE, PRESSED),
    )
    return _with_fatigue(fields, loaded.duty, coefficients, loads, use)


def _superposition(part: Part, loads: PartLoads, skin: Skin) -> tuple[FloatArray, FloatArray]:
    """Fields (r, n, 6) and their coefficients (r, positions): as few as the forces need."""
    pin, leaves = as_pin(part.geometry), as_leaves(part.geometry)
    if pin is not None:
        places, modes, coefficients = _pin_sections(pin, loads)
        along, components = 2, (ZZ, ZX, YZ)
        aside = skin.nodes[:, :2].T
    else:
        places, sections = _bar_sections(part, loads, skin)
        depths = np.ptp(skin.nodes[:, 1:], axis=0) / 2
        modes, coefficients = _modes(sections, np.array([1.0, *depths, 1.0, 1.0]))
        along, components = 0, (XX, XY, ZX)
        aside = skin.nodes[:, 1:].T.copy()
        if leaves is not None:
            aside[0] = _from_own_leaf(leaves, aside[0])
    x = skin.nodes[:, along]
    basis = np.zeros((len(modes), len(x), 6))
    for mode, field in zip(modes, basis, strict=True):
        even, first, second, shear, shear_aside = (np.interp(x, places, row) for row in mode)
        field[:, components[0]] = even + first * aside[0] + second * aside[1]
        field[:, components[1]], field[:, components[2]] = shear, shear_aside
    return basis, coefficients


def _modes(sections: FloatArray, sizes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The few modes (r, 5, m) and coefficients (r, positions) that sections (5, m, positions) have.

    sizes  (5,) that make a stress of each row, 1 or mm

    A contact that slides makes many; what is below a thousandth of the largest is left out.
    """
    scale = sizes[:, None]
    flat = (sections * scale[..., None]).reshape(-1, sections.shape[2])
    left, values, right = np.linalg.svd(flat, full_matrices=False)
    kept = values > _KEPT * values[0] if values[0] else np.arange(len(values)) == 0
    modes = left[:, kept].T.reshape(-1, *sections.shape[:2]) / scale
    return modes, values[kept, None] * right[kept]


def _bar_sections(part: Part, loads: PartLoads, skin: Skin) -> tuple[FloatArray, FloatArray]:
    """Places (m,) along x, and what makes up the stress there (5, m, positions).

    Stress along x is row 0 + row 1 y + row 2 z; rows 3 and 4 are shear along y and z.
    """
    low, high = skin.nodes[:, 0].min(), skin.nodes[:, 0].max()
    places = np.linspace(low, high, _SECTIONS)
    inside = np.clip(places, *np.array([low, high]) + np.array([1, -1]) * _ASIDE * (high - low))
    inside[1:-1] += _ASIDE * (high - low)
    area, y, z, about_z, about_y = sections_of(skin, inside)
    leaves = as_leaves(part.geometry)
    if leaves is not None:
        bar = leaf_bar(part, leaves, loads)
        about_z, y = np.full_like(area, leaves.inertia_separate), np.zeros_like(area)
    else:
        centres = {one.name: float(one.centre[0]) for one in part.geometry.placed_interfaces}
        cells = (area[1:] + area[:-1]) / 2
        bar = bar_loads(part, loads, centres, Stretches(places, cells, cells, cells, cells))
    forces = bar.at(inside)
    thick = area > _THIN * area.max()
    per_area, per_z, per_y = (
        np.where(thick, 1 / np.where(thick, one, 1.0), 0.0)[:, None]
        for one in (area, about_z, about_y)
    )
    first, second = -forces.moment_z * per_z, forces.moment_y * per_y
    even = forces.axial * per_area - first * y[:, None] - second * z[:, None]
    shear = forces.shear * per_area
    return places, np.stack([even, first, second, shear, np.zeros_like(shear)])


def _pin_sections(shape: Pin, loads: PartLoads) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Places (m,) along z; sections (r, 5, m) by a unit of what acts, and how much acts.

    Rows as in `_bar_sections`, along z: stress along z is row 1 x + row 2 y, shear along x and y.
    """
    names = [seat.name for seat in shape.seats]
    acting = np.concatenate([loads.wrenches[name].T for name in names])
    units = np.split(np.eye(len(acting)), len(names), axis=1)
    diagram = pin_diagram(shape, dict(zip(names, units, strict=True)))
    area = np.pi / 4 * diagram.diameter**2
    bent = -diagram.moment / (np.pi / 64 * diagram.diameter**4)[:, None]
    sheared = diagram.shear / area[:, None]
    rows = [np.zeros_like(bent[..., 0]), bent[..., 0], bent[..., 1], *np.moveaxis(sheared, 2, 0)]
    modes = np.stack(rows, axis=1)
    used = np.flatnonzero(modes.any(axis=(1, 2)) & acting.any(axis=1))
    if not len(used):  # a field of nothing is one field
        used = np.array([0])
    return diagram.places, modes[used], acting[used]


def _from_own_leaf(shape: LeafPack, y: FloatArray) -> FloatArray:
    """Heights over the middle of the own leaf; of two leaves that touch the outer one's."""
    bottom, thickness = -shape.leaves * shape.thickness / 2, shape.thickness
    leaf = np.where(y > 0, np.ceil((y - bottom) / thickness - 1e-6) - 1, (y - bottom) // thickness)
    leaf = np.clip(leaf, 0, shape.leaves - 1)
    return np.asarray(y - (bottom + (leaf + 0.5) * thickness))


def sections_of(skin: Skin, places: FloatArray) -> FloatArray:
    """Sections of a closed surface at places x, mm: area, y and z of the centroid, I_z, I_y (5, m).

    I_z and I_y about the centroid. By Green's theorem over the edges that a plane cuts from the
    triangles; no node may lie on a plane.
    """
    found = np.zeros((5, len(places)))
    corners = skin.nodes[skin.triangles]
    lowest, highest = corners[..., 0].min(axis=1), corners[..., 0].max(axis=1)
    for k, place in enumerate(places):
        cut = corners[(lowest < place) & (highest > place)]
        if not len(cut):
            continue
        over = cut[..., 0] > place
        ends = []
        for way in (True, False):  # where the outline of each triangle comes up, and goes down
            crosses = (over != np.roll(over, -1, axis=1)) & (np.roll(over, -1, axis=1) == way)
            row, edge = np.arange(len(cut)), crosses.argmax(axis=1)
            first, second = cut[row, edge], cut[row, (edge + 1) % 3]
            share = (place - first[:, 0]) / (second[:, 0] - first[:, 0])
            ends.append(first[:, 1:] + share[:, None] * (second - first)[:, 1:])
        (y0, z0), (y1, z1) = ends[0].T, ends[1].T
        cross = y0 * z1 - y1 * z0
        area = cross.sum() / 2
        if not area:
            continue
        y, z = ((y0 + y1) * cross).sum() / (6 * area), ((z0 + z1) * cross).sum() / (6 * area)
        second_y = ((y0**2 + y0 * y1 + y1**2) * cross).sum() / 12 / area - y**2
        second_z = ((z0**2 + z0 * z1 + z1**2) * cross).sum() / 12 / area - z**2
        found[:, k] = abs(area), y, z, abs(area) * second_y, abs(area) * second_z
    return found


def _peaks(basis: FloatArray, coefficients: FloatArray) -> FloatArray:
    """Largest von Mises stress (n,) of fields (r, points, 6) at each position, MPa.

    One normal stress and shear beside it: sigma^2 + 3 tau^2, of the components that are not nothing
    and of each set of equal points once.
    """
    acting = np.flatnonzero(basis.any(axis=(0, 1)))
    parts = np.unique(basis[:, :, acting].swapaxes(0, 1).reshape(basis.shape[1], -1), axis=0)
    parts = parts.reshape(len(parts), len(basis), -1)
    if len(basis) == 1:  # one field, larger or smaller: the same point is worst everywhere
        size = (parts[:, 0] ** 2) @ np.where(acting < 3, 1.0, 3.0)
        return np.asarray(np.sqrt(size.max(initial=0.0)) * np.abs(coefficients[0]))
    count, step = coefficients.shape[1], max(1, _TOGETHER // len(parts))
    found = np.zeros(count)
    for k in range(0, count, step):
        some = coefficients[:, k : k + step]
        square = np.zeros((len(parts), some.shape[1]))
        for column, component in enumerate(acting):
            stress = parts[:, :, column] @ some
            stress *= stress
            square += stress if component < 3 else 3 * stress
        found[k : k + step] = np.sqrt(square.max(axis=0))
    return found


def _with_fatigue(
    fields: LiveFields,
    duty: Duty,
    coefficients: FloatArray,
    loads: PartLoads,
    use: FatigueUse | None,
) -> LiveFields:
    """The fields with Goodman's use of the estimated stress over the duty, without a notch."""
    runs = duty_runs(loads.cycles, duty.cycles)
    if use is None or not runs or isinstance(use, FkmUse):
        why = _UNJUDGED if use is None else _BY_FKM
        return replace(fields, missing={**fields.missing, **dict.fromkeys(FATIGUE, why)})
    path = coefficients[:, np.concatenate([runs[name] for name in runs if name in loads.cycles])]
    # of one field the extremes say all
    between = min(_JUDGED, path.shape[1]) if len(path) > 1 else 0
    even = np.linspace(0, path.shape[1] - 1, between).astype(int)
    kept = np.unique(np.r_[even, path.argmax(axis=1), path.argmin(axis=1)])
    basis = np.ascontiguousarray(np.moveaxis(fields.stress, 0, 2), dtype=np.float64)
    found = goodman(basis, np.ascontiguousarray(path[:, kept]), use.limit, use.ultimate)
    endless = isinstance(use, LifeUse)
    return replace(
        fields,
        fatigue=dict(zip(FATIGUE, (found.utilisation, found.amplitude, found.mean), strict=True)),
        judged=not endless,
        notes=(*fields.notes, *([ENDLESS] if endless else [])),
    )
