"""The solid model of one part: meshes until the stress is known well enough, and its checks."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

import fatigue
from ballesta.design_data import Design, Part
from ballesta.errors import DesignError
from ballesta.fatigue_facts import chord_at, fatigue_facts, plane_at
from ballesta.finite_life import LifeTask, why_no_curve
from ballesta.halves import MEANING, half_of, mode_surface, shown_surface
from ballesta.hand import hand_checks
from ballesta.judged import Bars, Judged, StaticPeak, bars_of, mesh_bar
from ballesta.judged_fatigue import FatigueUse, FkmUse, LifeUse
from ballesta.levels import Level, Models, solve_level
from ballesta.part_facts import assumed_of, charts_of, facts_of, gates_of, mesh_row
from ballesta.part_loads import PartLoads
from ballesta.part_vibration import frequency_facts
from ballesta.stability import (
    column_checks,
    column_facts,
    column_told,
    eigenvalue_check,
)
from fem.buckling import BucklingMode
from fem.error_estimate import refined_sizes, stress_error
from fem.unit_solutions import Elastic, UnitSolutions
from geometry.mesh import FloatArray, MeshError, TooManyElementsError
from geometry.sizing import SizeField
from reports.verdict import Check, Gate, PartResult, Status, Surface

FIRST = 0.7  # fineness of the first mesh; where the stress decides, later ones are finer
_MOST_MESHES = 5
_RESCALED = 1e-6
_EXAGGERATED = 0.1  # of the part's size: the largest displacement of a mode as it is drawn
_FINER = 1.3  # general elements, where a mesh with small ones in places is not usable
_LEAST_STEP = 1.15  # elements that decide must become smaller by this, or a mesh is not worth it

Say = Callable[[str], None]


def check_solid(
    design: Design, part: Part, loads: PartLoads, models: Models, say: Say = lambda _: None
) -> PartResult:
    """Check one part as a solid over all cycles of its design.

    After the first mesh each is finer where the last one was uncertain, until the numerical error
    of what is judged is within the accuracy asked for, or the mesh would have more unknowns than
    allowed. The finer ones are halves where shape and loads allow it: the first gives the masses,
    and its buckling may be sideways. Raises MeshError and SolverError.
    """
    limit = endurance_of(part)
    judged: list[Judged] = [StaticPeak(loads)]
    use = fatigue_use(design, part, loads)
    if use is not None:
        judged.append(use)
    levels, sizes, stopped = solve_levels(design, part, loads, models, judged, limit.value, say)
    finest = levels[-1]
    checks = [
        _stress_check(
            design, part, loads, finest, what, bars_of(what, part, levels, design.accuracy)
        )
        for what in judged
    ]
    if stopped:
        checks = [
            replace(check, note=f"{check.note}; {stopped}")
            if check.numerical > design.accuracy * check.value
            else check
            for check in checks
        ]
    checks += column_checks(design, part, loads)
    whole = [(level.solutions, level.coefficients) for level in levels if not level.half]
    eigen = eigenvalue_check(design, part, loads, whole, finest.peak.position)
    if eigen and eigen[0].status is Status.UNDECIDED and finest.half:
        whole.append(_whole_again(part, loads, models, finest, sizes))
        eigen = eigenvalue_check(design, part, loads, whole, finest.peak.position)
    assumed = assumed_of(design, part, finest)
    if finest.half:
        assumed.append(MEANING)
    gates = gates_of(design, part, loads, levels)
    facts = facts_of(part, loads, finest, None if part.fkm else limit)
    facts |= column_facts(design, part, loads)
    facts |= frequency_facts(part, levels[0].solutions)
    told = column_told(part, loads)
    if told:
        assumed.append(told)
    peak = None
    if use is not None:
        peak = use.worst(finest)
        gates.append(
            Gate(
                f"{part.name}: fatigue safety",
                use.safety_missed(finest),
                _RESCALED,
                "how far from 1 the fatigue safety is when all loads are multiplied by it and "
                "judged again",
            )
        )
        if isinstance(use, FkmUse):  # no fact of the other chain
            facts |= use.found(finest).facts()
            peak = None
        else:
            facts |= fatigue_facts(part, finest, peak, life_task(design, part))
    if eigen:
        checks.append(eigen[0])
    elif levels[0].solutions.ties is not None:
        assumed.append("buckling of a stack of bodies that slide on each other is not computed")
    elif part.body is not None:
        assumed.append(
            "the solid does not buckle at the positions asked: no factor is positive before its "
            "stress is a tenth of Young's modulus"
        )
    return PartResult(
        name=part.name,
        shape=part.shape,
        material=part.material.name,
        checks=checks,
        gates=gates,
        hand_checks=hand_checks(part, loads, finest),
        meshes=[{"body": "half" if lv.half else "whole", **mesh_row(lv)} for lv in levels],
        facts=facts,
        charts=charts_of(part, loads, finest, peak),
        surface=shown_surface(loads, finest),
        assumed=assumed,
        mode=None if eigen is None else _mode_of(whole, eigen[1]),
    )


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
    design: Design,
    part: Part,
    loads: PartLoads,
    models: Models,
    judged: Sequence[Judged],
    limit: float,
    say: Say,
) -> tuple[list[Level], SizeField | None, str]:
    """Solve a part on finer and finer meshes.

    Returns the last one's sizes too, and why it stopped short of the accuracy, or nothing.
    """
    material, base = elastic_of(part), FIRST * part.fineness
    finer = half_of(part, loads) or part.geometry
    levels: list[Level] = []
    sizes = None
    check_first_mesh(part, 3 * len(models.mesh(part.geometry, base).nodes))
    while True:
        try:
            solutions = models.solutions(finer if levels else part.geometry, base, material, sizes)
        except TooManyElementsError as error:
            if len(levels) < 2:  # one mesh has no error bar
                raise
            return levels, sizes, f"a finer mesh was not solved: {error}"
        except MeshError:
            if not levels or base > _FINER * FIRST * part.fineness:
                raise
            base *= _FINER  # sizes between two places may leave a round face too coarse
            continue
        unknowns = 3 * len(solutions.mesh.nodes)
        say(f"{part.name}: {unknowns} unknowns, {solutions.factor.solver}; superposing the cycle")
        level = solve_level(
            solutions,
            base,
            loads,
            limit,
            part.material.ultimate_stress,
            design.duty.cycles,
            part.geometry.notch_factors,
        )
        levels.append(level)
        if len(levels) > 1 and all(mesh_bar(what, levels) <= design.accuracy for what in judged):
            return levels, sizes, ""
        if len(levels) == _MOST_MESHES:
            return levels, sizes, f"given up after {_MOST_MESHES} meshes"
        most = part.most_unknowns * len(solutions.mesh.elements) / unknowns
        if finer is not part.geometry and not level.half:
            most *= 2  # the next mesh has half of the elements that are estimated on this one
        errors = [
            stress_error(solutions.recovery, solutions.displacement @ state)
            for what in judged
            for state in what.states(level)
        ]
        sharp = level.history.nodes[level.edges[0]]
        wanted, step = refined_sizes(solutions.recovery, errors, design.accuracy, most, sharp)
        if step < _LEAST_STEP and len(levels) > 1:
            return (
                levels,
                sizes,
                f"{unknowns} unknowns taken, at most {part.most_unknowns} allowed "
                "(mesh.most_unknowns)",
            )
        sizes = wanted


def check_first_mesh(part: Part, unknowns: int) -> None:
    """Raise TooManyElementsError if the first mesh of a part is more than it may have."""
    if unknowns > part.most_unknowns:
        raise TooManyElementsError(
            f"mesh.most_unknowns is {part.most_unknowns}, but the first mesh of mesh.fineness "
            f"{part.fineness:g} has {unknowns} unknowns; allow at least twice as many, or lower "
            "mesh.fineness"
        )


def _whole_again(
    part: Part, loads: PartLoads, models: Models, finest: Level, sizes: SizeField | None
) -> tuple[UnitSolutions, FloatArray]:
    """Solutions and coefficients of the whole part with the element sizes of a half."""
    solutions = models.solutions(part.geometry, finest.fineness, elastic_of(part), sizes)
    coefficients, _ = solutions.coefficients(
        loads.wrenches, loads.accelerations, loads.reaches, loads.tilt_held_at
    )
    return solutions, coefficients


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
    ultimate, ratio = part.material.ultimate_stress, part.material.endurance_ratio
    specimen = None if ratio is None else ratio * ultimate
    if part.geometry.stressed_evenly:
        return fatigue.endurance_limit(
            ultimate,
            part.surface,
            load="axial",
            reliability=part.reliability,
            specimen_limit=specimen,
        )
    section = part.geometry.stressed_section
    if len(section) == 1:
        diameter = fatigue.round_equivalent_diameter(*section)
    else:
        diameter = fatigue.rectangle_equivalent_diameter(*section)
    return fatigue.endurance_limit(
        ultimate,
        part.surface,
        equivalent_diameter=diameter,
        load="bending",
        reliability=part.reliability,
        specimen_limit=specimen,
    )


def life_task(design: Design, part: Part) -> LifeTask:
    """What a finite life of a part is asked of."""
    duty = design.duty
    return LifeTask(
        duty.cycles,
        part.material,
        part.geometry.stressed_evenly,
        duty.allowed_damage - duty.damage_so_far,
        begun=duty.damage_so_far > 0,
    )


def fatigue_use(design: Design, part: Part, loads: PartLoads) -> FatigueUse | None:
    """How the part's fatigue is judged, None where no cycle of the duty loads it."""
    if not any(name in loads.cycles for name in design.duty.cycles):
        return None
    ultimate = part.material.ultimate_stress
    if part.fkm is not None:
        return FkmUse(loads, part.fkm.reference, ultimate, part.fkm)
    limit = endurance_of(part).value
    if design.duty.life == "finite":
        why = why_no_curve(part.material, limit, axial=part.geometry.stressed_evenly)
        if why:
            raise DesignError(design.file, f"parts.{part.name}.material", why)
        return LifeUse(loads, limit, ultimate, life_task(design, part))
    return FatigueUse(loads, limit, ultimate)


def _stress_check(
    design: Design, part: Part, loads: PartLoads, level: Level, judged: Judged, bars: Bars
) -> Check:
    more, why = 0.0, ""
    if isinstance(judged, FatigueUse):
        said = _fatigue_words(design, part, loads, level, judged)
        more, why = judged.band(level)
    else:
        said = _static_words(design, part, loads, level)
    return Check(
        part=part.name,
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
        place=level.place(judged.point(level)),
        method="solid",
        basis=said.basis,
        note=". ".join(text for text in (said.note, why, bars.note) if text),
    )


@dataclass(frozen=True)
class _Words:
    """What stands in a check beside its numbers."""

    kind: str
    quantity: str
    limit: float
    required: float
    cycle: str
    position: str
    basis: str
    note: str = ""


def _static_words(design: Design, part: Part, loads: PartLoads, level: Level) -> _Words:
    return _Words(
        "static",
        "peak von Mises stress",
        part.material.yield_stress,
        design.require.static,
        loads.cycle_names[level.peak.position],
        loads.labels[level.peak.position],
        f"yield stress, guaranteed minimum ({part.material.source})",
    )


def _fatigue_words(
    design: Design, part: Part, loads: PartLoads, level: Level, use: FatigueUse
) -> _Words:
    worst = use.worst(level)
    if isinstance(use, FkmUse):
        found = use.found(level)
        amplitude, mean = found.amplitude, found.mean
        note = f"support {float(found.limit.support):.3f}, K_AK {found.mean_factor:.3f}"
        basis = (
            f"FKM guideline, {use.strength.material.group}, Rz {use.strength.roughness:g} um: even "
            "reversed stress; infinite life"
        )
    else:
        amplitude, mean, _ = chord_at(level, worst)
        factor = use.limit / float(level.limits[worst.point])
        note = f"fatigue notch factor {factor:.3g}" if factor > 1 else ""
        if worst.criterion == "Findley":
            note = ", ".join(
                text for text in (f"longest chord; {plane_at(level, worst)}", note) if text
            )
        life = "infinite life"
        if isinstance(use, LifeUse):
            lasts = use.life(level)
            life = f"finite life: Miner's sum {lasts.damage:.3g} of {use.task.allowed_damage:g}"
            if lasts.raised > 1.0:
                raised = f"cycles raised by {lasts.raised:.4g}, Findley's plane over the chord"
                note = ", ".join(text for text in (raised, note) if text)
        basis = (
            f"endurance limit, Marin: {part.surface}, {100 * part.reliability:g} % survival; {life}"
        )
    return _Words(
        "fatigue",
        f"{worst.criterion} equivalent amplitude",
        use.limit,
        design.require.fatigue,
        worst.cycle,
        " to ".join(_position(loads, k, worst.cycle) for k in worst.pair),
        basis,
        ", ".join(
            text
            for text in (f"amplitude {amplitude:.4g} MPa", f"mean {mean:.4g} MPa", note)
            if text
        ),
    )


def _position(loads: PartLoads, position: int, cycle: str) -> str:
    """Where in the duty, with the cycle's name where the pair may be of two."""
    label = loads.labels[position]
    return label if cycle in loads.cycles else f"{loads.cycle_names[position]} {label}"
