"""The solid model of one part: meshes until the verdict is settled, error bars, checks, gates."""

from collections.abc import Callable, Mapping, Sequence
from math import degrees, pi

import numpy as np

import fatigue
from ballesta.design_data import Design, Part
from ballesta.hand import hand_checks
from ballesta.levels import Level, Models, peak_of, solve_level
from ballesta.part_loads import PartLoads
from ballesta.stability import axial_compression, column_checks, eigenvalue_check
from fem.convergence import ErrorBar, discretisation_error, moves_like_singular
from fem.direct import direct_stress, has_bearings
from fem.recovery import von_mises
from fem.singularity import singular_exponent
from fem.solvers import BACKWARD_LIMIT
from fem.unit_solutions import Elastic
from geometry.mesh import FloatArray, boundary_facets
from reports.verdict import Check, Gate, PartResult, Surface

LEVELS = (0.7, 1.0, 1.4)  # finenesses; the third only where the verdict is not settled by two
_LOAD_LIMIT, _RAW_LIMIT = 1e-6, 1e-3

Say = Callable[[str], None]


def check_solid(
    design: Design, part: Part, loads: PartLoads, models: Models, say: Say = lambda _: None
) -> PartResult:
    """Check one part as a solid over all cycles of its design.

    Starts on two meshes and takes a third where the numerical error bar alone leaves a check
    undecided. Raises MeshError and SolverError.
    """
    material = elastic_of(part)
    limit = endurance_of(part)
    levels: list[Level] = []
    checks: list[Check] = []
    for number, fineness in enumerate(LEVELS):
        if number > 1 and not any(check.settled_by_mesh for check in checks):
            break
        solutions = models.solutions(part.geometry, fineness * part.fineness, material)
        unknowns = 3 * len(solutions.mesh.nodes)
        say(f"{part.name}: {unknowns} unknowns, {solutions.factor.solver}; superposing the cycle")
        levels.append(
            solve_level(
                solutions,
                fineness * part.fineness,
                loads,
                limit.value,
                part.material.ultimate_stress,
                design.duty.cycles,
            )
        )
        if number:
            checks = _stress_checks(design, part, loads, levels, limit.value)
    checks += column_checks(design, part, loads)
    eigen = eigenvalue_check(
        design, part, loads, [(level.solutions, level.coefficients) for level in levels]
    )
    assumed = _assumed(design, part, levels[-1])
    if eigen:
        checks.append(eigen[0])
    elif part.geometry.sections and axial_compression(part, loads).max() > 0:
        assumed.append(
            "compression does not buckle the solid: none of its 12 factors of smallest size is "
            "positive"
        )
    finest = levels[-1]
    return PartResult(
        name=part.name,
        shape=part.shape,
        material=part.material.name,
        checks=checks,
        gates=_gates(design, part, loads, levels),
        hand_checks=hand_checks(part, loads, finest),
        meshes=[_mesh_row(level) for level in levels],
        facts=_facts(part, loads, finest, limit),
        charts=_charts(part, loads, finest, limit.value),
        surface=_surface(loads, finest),
        assumed=assumed,
    )


def elastic_of(part: Part) -> Elastic:
    """Return the elastic constants of a part's material."""
    material = part.material
    return Elastic(material.youngs_modulus, material.poisson_ratio, material.density)


def endurance_of(part: Part) -> fatigue.EnduranceLimit:
    """Endurance limit by Marin's factors.

    The load factor is that of bending where the shape's peaks are local, with a gradient below
    them, and of axial force where the whole section is stressed alike; there no size factor applies
    (Shigley, 6-20). The part does not turn under its load: the size factor takes an equivalent
    diameter.
    """
    if part.geometry.stressed_evenly:
        return fatigue.endurance_limit(
            part.material.ultimate_stress, part.surface, load="axial", reliability=part.reliability
        )
    section = part.geometry.stressed_section
    if len(section) == 1:
        diameter = fatigue.round_equivalent_diameter(*section)
    else:
        diameter = fatigue.rectangle_equivalent_diameter(*section)
    return fatigue.endurance_limit(
        part.material.ultimate_stress,
        part.surface,
        equivalent_diameter=diameter,
        load="bending",
        reliability=part.reliability,
    )


def _stress_checks(
    design: Design,
    part: Part,
    loads: PartLoads,
    levels: Sequence[Level],
    limit: float,
) -> list[Check]:
    finest = levels[-1]
    peak = finest.peak
    state = finest.coefficients[:, peak.position]
    arcs = _arcs(part, finest)
    direct = {arc: _direct(loads, finest, peak.position, arc) for arc in arcs}
    peaks = {arc: peak_of(stress) for arc, stress in direct.items()}
    bar, model, note = _bars(
        design.accuracy,
        [level.peak.value for level in levels],
        levels,
        [von_mises(level.history.at(level.peak.position)) for level in levels],
        finest.scatter(state, peak.point),
        peaks,
    )
    method = "solid"
    checks = [
        Check(
            part=part.name,
            kind="static",
            quantity="peak von Mises stress",
            value=peak.value,
            unit="MPa",
            numerical=bar.value,
            model=model[0],
            model_below=model[1],
            limit=part.material.yield_stress,
            required=design.require.static,
            cycle=loads.cycle_names[peak.position],
            position=loads.labels[peak.position],
            place=finest.place(peak.point),
            method=method,
            basis=f"yield stress, guaranteed minimum ({part.material.source})",
            note=note,
        )
    ]
    worst = finest.fatigue
    if worst is None:
        return checks
    first, second = worst.pair
    pairs = {
        arc: np.stack([_direct(loads, finest, k, arc) for k in (first, second)], axis=2)
        for arc in arcs
    }
    result = finest.fatigue_results[worst.cycle]
    values = {
        arc: float(
            fatigue.goodman(
                stress, np.eye(2), limit, part.material.ultimate_stress
            ).utilisation.max()
        )
        * limit
        for arc, stress in pairs.items()
    }
    swing = finest.coefficients[:, first] - finest.coefficients[:, second]
    middle = (finest.coefficients[:, first] + finest.coefficients[:, second]) / 2
    bar, model, note = _bars(
        design.accuracy,
        [level.fatigue.value for level in levels if level.fatigue],
        levels,
        [level.fatigue_results[worst.cycle].utilisation * limit for level in levels],
        finest.scatter(swing, worst.point) / 2
        + finest.scatter(middle, worst.point) * limit / part.material.ultimate_stress,
        values,
    )
    checks.append(
        Check(
            part=part.name,
            kind="fatigue",
            quantity="Goodman equivalent amplitude",
            value=worst.value,
            unit="MPa",
            numerical=bar.value,
            model=model[0],
            model_below=model[1],
            limit=limit,
            required=design.require.fatigue,
            cycle=worst.cycle,
            position=f"{loads.labels[first]} to {loads.labels[second]}",
            place=finest.place(worst.point),
            method=method,
            basis=f"endurance limit, Marin: {part.surface}, "
            f"{100 * part.reliability:g} % survival; infinite life",
            note=". ".join(
                text
                for text in (
                    f"amplitude {result.amplitude[worst.point]:.4g} MPa, "
                    f"mean {result.mean[worst.point]:.4g} MPa",
                    note,
                )
                if text
            ),
        )
    )
    return checks


def _arcs(part: Part, level: Level) -> list[float]:
    """Arcs of contact: the half circle of the unit loads, and down to the narrowest stated."""
    if not has_bearings(level.solutions):
        return []
    narrow = part.bearing_arc
    return [pi] if narrow >= pi else [pi, (pi + narrow) / 2, narrow]


def _direct(loads: PartLoads, level: Level, position: int, arc: float) -> FloatArray:
    wrenches = {name: wrench[position] for name, wrench in loads.wrenches.items()}
    return direct_stress(level.solutions, wrenches, level.coefficients[:, position], arc)


def _bars(
    accuracy: float,
    values: Sequence[float],
    levels: Sequence[Level],
    fields: Sequence[FloatArray],
    scatter: float,
    by_arc: Mapping[float, float],
) -> tuple[ErrorBar, tuple[float, float], str]:
    """Numerical bar, model band (above, below) and a note for a peak from several meshes."""
    sizes = [1 / level.fineness for level in levels]
    truncation = abs(by_arc[pi] - values[-1]) if by_arc else 0.0
    angle, exponent = _singular_edge(levels, fields, sizes, values[-1])
    bar = ErrorBar(discretisation_error(values, sizes), scatter, truncation, exponent)
    above = max((value - by_arc[pi] for value in by_arc.values()), default=0.0)
    below = max((by_arc[pi] - value for value in by_arc.values()), default=0.0)
    notes = []
    if exponent:
        notes.append(
            f"singular: a sharp re-entrant edge of {degrees(angle):.0f} deg, where stress grows "
            f"like 1/distance^{exponent:.2f} and {values[-1]:.4g} MPa is only what this mesh "
            "shows; give the edge its radius"
        )
    elif bar.value > accuracy * abs(values[-1]):
        notes.append(
            f"numerical error {100 * bar.value / abs(values[-1]):.2g} %, asked for "
            f"{100 * accuracy:g} %; a finer mesh is taken only where it can change the verdict"
        )
    if by_arc:
        arcs = ", ".join(f"{degrees(a):.0f} deg {v:.4g}" for a, v in by_arc.items())
        notes.append(f"by arc of contact, MPa: {arcs}")
    return bar, (above, below), "; ".join(notes)


def _singular_edge(
    levels: Sequence[Level], fields: Sequence[FloatArray], sizes: Sequence[float], peak: float
) -> tuple[float, float]:
    """Interior angle (rad) and exponent of a sharp re-entrant edge that spoils a peak, else 0, 0.

    fields  per mesh the judged quantity (n_points,) at its surface points

    An edge counts if it carries at least half the peak and its largest value moves with the mesh.
    A sharp edge of the body is sharp on every mesh; what only some show is a coarse fillet.
    """
    if not all(len(level.edges[0]) for level in levels):
        return 0.0, 0.0
    points, angles = levels[-1].edges
    values = [
        float(field[level.edges[0]].max()) for level, field in zip(levels, fields, strict=True)
    ]
    worst = points[fields[-1][points].argmax()]
    angle = float(angles[points == worst][0])
    exponent = singular_exponent(angle)
    if values[-1] >= peak / 2 and moves_like_singular(values, sizes, exponent):
        return angle, exponent
    return 0.0, 0.0


def _gates(design: Design, part: Part, loads: PartLoads, levels: Sequence[Level]) -> list[Gate]:
    level = levels[-1]
    solutions = level.solutions
    slender = np.abs(solutions.displacement @ level.coefficients[:, level.peak.position]).max()
    size = float(np.ptp(solutions.mesh.nodes, axis=0).max())
    gates = []
    if not _stated_mass(design, part):
        driving = levels[1]  # whose mass properties the linkage was solved with
        gates.append(
            Gate(
                f"{part.name}: balance",
                driving.balance_residual(loads),
                _LOAD_LIMIT,
                "resultant of the loads with the part's own inertia, over the largest pin force",
            )
        )
    return [
        *gates,
        Gate(
            f"{part.name}: loads on the mesh",
            level.load_residual(loads),
            _LOAD_LIMIT,
            "force and moment that reached each interface less those asked for, at every position, "
            "over the largest pin force",
        ),
        Gate(
            f"{part.name}: support reactions",
            level.reaction_residual(loads),
            _LOAD_LIMIT,
            "what the determinate support carries, over the largest pin force",
        ),
        Gate(
            f"{part.name}: raw unit loads",
            solutions.raw_deviation,
            _RAW_LIMIT,
            "resultants of the unit loads on the faceted surfaces before they were normalised",
        ),
        Gate(
            f"{part.name}: equation residual",
            solutions.residual,
            BACKWARD_LIMIT,
            f"backward error of the unit loads' solutions ({solutions.factor.solver})",
        ),
        Gate(
            f"{part.name}: small displacements",
            float(slender) / size,
            0.01,
            "largest displacement over the part's size; linear theory needs it small",
        ),
    ]


def _mesh_row(level: Level) -> dict[str, float | int | str]:
    mesh = level.solutions.mesh
    return {
        "fineness": level.fineness,
        "unknowns": level.unknowns,
        "elements": len(mesh.elements),
        "peak": level.peak.value,
        "equivalent amplitude": level.fatigue.value if level.fatigue else 0.0,
        "smallest scaled det J": mesh.jacobian_minimum,
        "mesher": mesh.mesher,
        "solver": level.solutions.factor.solver,
    }


def _facts(
    part: Part, loads: PartLoads, level: Level, limit: fatigue.EnduranceLimit
) -> dict[str, float | str]:
    mass = level.solutions.mesh.mass_properties(part.material.density)
    facts: dict[str, float | str] = {
        "mass [kg]": mass.mass * 1e3,
        "centre of mass x [mm]": float(mass.centre[0]),
        "inertia about the centre [kg m2]": mass.inertia * 1e-3,
        "yield stress [MPa]": part.material.yield_stress,
        "ultimate stress [MPa]": part.material.ultimate_stress,
        "endurance limit [MPa]": limit.value,
        "Marin factors": f"surface {limit.surface:.3f}, size {limit.size:.3f}, load "
        f"{limit.load:.3f}, temperature {limit.temperature:.3f}, reliability "
        f"{limit.reliability:.3f} on {limit.uncorrected:.4g} MPa",
    }
    for name in loads.wrenches:
        facts[f"largest force at {name} [N]"] = float(loads.resultant(name).max())
    return facts


def _charts(
    part: Part, loads: PartLoads, level: Level, endurance: float
) -> dict[str, dict[str, object]]:
    charts: dict[str, dict[str, object]] = {
        "peaks": {
            name: level.peaks_by_position[columns].tolist()
            for name, columns in loads.cycles.items()
        }
    }
    worst = level.fatigue
    if worst is None:
        return charts
    result = level.fatigue_results[worst.cycle]
    path = result.critical_path(
        level.history.basis,
        np.ascontiguousarray(level.coefficients[:, loads.cycles[worst.cycle]]),
    )
    most_used = np.argsort(-result.utilisation)[:300]
    return charts | {
        "haigh": {
            "cycle": worst.cycle,
            "along": [float(v) for v in path.along],
            "mean": float(result.mean[worst.point]),
            "amplitude": float(result.amplitude[worst.point]),
            "endurance": endurance,
            "ultimate": part.material.ultimate_stress,
            "yield": part.material.yield_stress,
            "cloud": [[float(result.mean[k]), float(result.amplitude[k])] for k in most_used],
        }
    }


def _surface(loads: PartLoads, level: Level) -> Surface:
    """Stress at the worst position and utilisation, on six-node facets split in four."""
    nodes = level.history.nodes
    facets = boundary_facets(level.solutions.mesh.elements)
    split = facets[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]].reshape(-1, 3)
    triangles = np.searchsorted(nodes, split)
    state = level.coefficients[:, level.peak.position]
    displacement = (level.solutions.displacement @ state).reshape(-1, 3)[nodes]
    fields = {"von Mises [MPa]": von_mises(level.history.at(level.peak.position))}
    if level.fatigue is not None:
        result = level.fatigue_results[level.fatigue.cycle]
        fields["Goodman utilisation"] = np.asarray(result.utilisation)
    for axis, name in enumerate("xyz"):
        fields[f"displacement {name} [mm]"] = displacement[:, axis]
    return Surface(level.history.points, triangles, fields, level.peak.point)


def _assumed(design: Design, part: Part, level: Level) -> list[str]:
    said = []
    if has_bearings(level.solutions):
        said.append(
            "pins press with a cosine pressure, even along their length, on "
            f"{degrees(part.bearing_arc):.0f} to 180 deg; both cheeks carry the same share"
        )
    stated = _stated_mass(design, part)
    if stated:
        added = np.abs(level.added).max(axis=0)
        said.append(
            f"the body's {stated} of the design file stand for the model's; a residual inertia "
            f"field up to ({added[0]:.3g}, {added[1]:.3g}) mm/s2 and {added[2]:.3g} rad/s2 "
            "balances the loads on the mesh"
        )
    points, angles = level.edges
    if len(points):
        stress = von_mises(level.history.at(level.peak.position))[points]
        said.append(
            f"sharp re-entrant edges of up to {degrees(float(angles.max())):.0f} deg: no finite "
            f"stress there; {float(stress.max()):.3g} MPa on this mesh"
        )
    return said


def _stated_mass(design: Design, part: Part) -> str:
    """Which mass properties the part's body states itself."""
    if part.body is None:
        return ""
    body = design.bodies[part.body]
    stated = {"mass": body.mass, "centre": body.centre, "inertia": body.inertia}
    return ", ".join(name for name, value in stated.items() if value is not None)
