"""Plain data of a part's charts, whatever model its stress comes from.

    peaks        cycle -> (n,) MPa, largest von Mises stress at each position
    by           the model of these: "formula" or "solid"
    haigh        diagram of the critical point by Goodman's line
    fkm          the same by the FKM guideline's
    sn           S-N line and the duty's cycles, of either chain
    column       stress and slenderness as a column (checks.by_formula.column)
    pressed      bores with a bush that is pressed in, which no factor on the loads changes
    convergence  the judged stresses on every mesh
    pins         the judged stresses by clearance and arc of pins (checks.ladder.pin_settings)

Keys without data are left out; the pages say why.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

import fatigue
from checks import by_formula
from checks.design.data import Part
from checks.design.effort import FORMULA
from checks.models.stress_words import chord_at, deciding_pair
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.strength.fatigue_assessment import FatigueUse, FkmUse
from checks.strength.finite_life import (
    LifeTask,
    counted,
    cycles_of,
    life_curve,
    lives_of,
    readings_of,
    why_no_curve,
)
from checks.strength.fkm_strength import fkm_points, slopes_of
from checks.strength.part_strength import life_task
from checks.stress.duty_verdict import DutyVerdict, FatiguePeak
from checks.stress.error_bars import mesh_bar
from checks.stress.judged import Judged, StaticPeak
from checks.stress.solid_mesh_level import Level
from checks.stress.stress_result import RungLevel, Stressed
from geometry.mesh import FloatArray, IntArray

SOLID = "solid"
_MOST_USED = 300  # points of the cloud
_MOST_CYCLES = 60  # of a duty that are listed, the most damaging first
_LOW_CYCLE = 1e3  # cycles at which Shigley's line begins
_FKM_FIRST = 1e4  # cycles from which the guideline's line is drawn
_ONWARDS = 1e3  # times the cycles of the knee, as far as a line is drawn
# mean over amplitude: FKM's diagram is straight between these but for the last stretch
_RAYS = np.r_[0.0, np.linspace(1.0, 3.0, 9), np.geomspace(3.0, 30.0, 9)[1:]]


def charts_of(
    loaded: LoadedPart, level: Stressed, use: FatigueUse | None, levels: Sequence[Level] = ()
) -> dict[str, Any]:
    """Plain data of a part's charts.

    level   whose stress is reported
    use     how its fatigue is judged, None without a cycle of the duty
    levels  of its meshes, coarse to fine; none of a part that was not meshed
    """
    part, loads = loaded.part, loaded.loads
    charts: dict[str, Any] = {
        "peaks": {
            name: level.peaks_by_position[columns].tolist()
            for name, columns in loads.cycles.items()
        },
        "by": FORMULA if isinstance(level, RungLevel) else SOLID,
    }
    if isinstance(use, FkmUse):
        charts["fkm"], charts["sn"] = fkm_data(loaded, level, use)
    elif use is not None:
        peak = use.worst(level)
        charts["haigh"] = haigh_data(part, level, peak)
        charts["sn"] = life_data(loaded, level, peak, life_task(part, loaded.duty))
    charts |= by_formula.charts(loaded)
    if loads.press_fits:
        charts["pressed"] = sorted(loads.press_fits)
    if len(levels) > 1:
        charts["convergence"] = convergence_data(levels, _judged(loads, use))
    return charts


def _judged(loads: PartLoads, use: FatigueUse | None) -> dict[str, Judged]:
    static: dict[str, Judged] = {"static": StaticPeak(loads)}
    return static if use is None else static | {"fatigue": use}


# Plain data of a part's convergence: what is judged, on every mesh, with its error bar.


def convergence_data(
    levels: Sequence[Level], judged: Mapping[str, Judged]
) -> dict[str, list[dict[str, Any]]]:
    """Kind of check -> one entry per mesh, coarse to fine.

    unknowns  of the mesh
    half      whether the mesh is half of the part
    value     MPa
    bar       MPa, what a finer mesh makes smaller of the numerical error; None on the first mesh
    """
    return {
        kind: [
            {
                "unknowns": level.unknowns,
                "half": level.half,
                "value": what.value(level),
                "bar": mesh_bar(what, levels[: k + 1]) * abs(what.value(level)) if k else None,
            }
            for k, level in enumerate(levels)
        ]
        for kind, what in judged.items()
    }


# Plain data of a part's fatigue diagrams: Haigh's by Goodman or FKM, and the S-N line's.
#
# A position of a cycle has no amplitude of its own. What is drawn of it is the swing from one
# state of the deciding pair, the less stressed one, to the state there: amplitude and mean are
# those of a cycle between the two, so that the path passes through the critical point, at the
# pair's other end.


def haigh_data(part: Part, level: Stressed, peak: FatiguePeak) -> dict[str, Any]:
    """Data of a Haigh diagram: the critical point, its path, and the most used points.

    away   MPa, endurance limit away from notches and fretting
    paths  cycle -> mean and amplitude of each position, (n,) MPa
    """
    duty, history = level.judged_duty, level.history
    order = np.argsort(-duty.worst.goodman_bound, kind="stable")[:_MOST_USED]
    ultimate = part.material.ultimate_stress
    cloud = fatigue.goodman(history.basis[order], duty.path, level.limits[order], ultimate)
    amplitude, mean = chord_at(level, peak)
    return {
        "cycle": peak.cycle,
        "criterion": peak.criterion,
        "mean": mean,
        "amplitude": amplitude,
        "endurance": float(level.limits[peak.point]),
        "ultimate": ultimate,
        "yield": part.material.yield_stress,
        "cloud": np.stack([cloud.mean, cloud.amplitude], axis=1).tolist(),
        "away": float(duty.limit),
        "paths": _paths(level, deciding_pair(level, peak), peak),
    }


def _paths(
    level: Stressed, pair: tuple[int, int], peak: FatiguePeak
) -> dict[str, dict[str, list[float]]]:
    basis = level.history.basis[peak.point]
    ends = np.ascontiguousarray(level.coefficients[:, list(pair)])
    states = (basis @ ends).T
    least = states[int(np.argmin(fatigue.von_mises(states)))]
    return {
        name: _swings(basis @ level.coefficients[:, run], least)
        for name, run in _judged_cycles(level, peak).items()
    }


def _judged_cycles(level: Stressed, peak: FatiguePeak) -> Mapping[str, IntArray]:
    """The cycles of the path that decides: one, or all of the duty."""
    own = cycles_of(level.judged_duty)
    return {peak.cycle: own[peak.cycle]} if peak.cycle in own else own


def _swings(stress: FloatArray, least: FloatArray) -> dict[str, list[float]]:
    """Mean and amplitude, as Goodman has them, of the cycles from a state (6,) to others (6, n)."""
    states = stress.T
    amplitude = fatigue.von_mises(states - least) / 2.0
    mean = np.maximum(fatigue.principal_stresses((states + least) / 2.0)[..., 2], 0.0)
    return {"mean": mean.tolist(), "amplitude": amplitude.tolist()}


def life_data(
    loaded: LoadedPart, level: Stressed, peak: FatiguePeak, task: LifeTask
) -> dict[str, Any]:
    """The S-N line of the critical point and the duty's cycles on it.

    asked            what the design asks for, "infinite" or "finite" life
    required         safety on all loads
    why              why there is no line; "" where there is one
    limit, away      MPa, endurance limit at the point, and away from notches and fretting
    line, below      (2, 2) cycles and MPa: to the knee, and on with the slope below it
    endless          whether a life without a cycle above the limit is infinite
    cycles           (n, 4) count, equivalent fully reversed amplitude (MPa), damage, and that
                     amplitude with all loads times the required safety, None beyond all bounds
    left_out         how many more cycles there are, and `left_damage` what they do
    damage, allowed  Miner's sum of a life, None without a finite one, and what is allowed of it
    state            "beyond the curve" where a cycle reaches the ultimate strength: no finite
                     number of them does the damage, and those that do have None for it; else ""
    """
    duty, point, required = level.judged_duty, peak.point, loaded.required.fatigue
    limit = float(level.limits[point])
    why = why_no_curve(task.material, limit, axial=task.axial) or ""
    data: dict[str, Any] = {
        "asked": loaded.duty.life, "required": required, "chain": "Marin", "why": why,
        "limit": limit, "away": float(duty.limit), "line": [], "below": [],
        "ultimate": task.material.ultimate_stress, "endless": task.endless,
        "allowed": task.allowed_damage, "damage": None, "state": "",
    }  # fmt: skip
    if why:
        return data | _listed(task, _plain_cycles(duty, point, task), None, required)
    (life,) = lives_of(duty, task, np.array([point]))
    curve = life_curve(task.material, np.array([limit]), axial=task.axial)
    per_cycle = curve.damage_per_cycle(_equivalent(task, life.cycles)[None])[0]
    if not life.damage:
        per_cycle = np.zeros_like(per_cycle)  # no cycle has begun it
    return data | {
        "line": _line(curve, limit, _LOW_CYCLE),
        "below": _below(curve, limit),
        "damage": _finite(life.damage),
        "state": "" if np.isfinite(life.damage) else "beyond the curve",
        **_listed(task, life.cycles, per_cycle, required),
    }


def _line(curve: fatigue.SNCurve, at_knee: float, first: float) -> list[list[float]]:
    """Cycles and amplitude, MPa, at the beginning of a line and at its knee."""
    knee, slope = _one(curve.knee_cycles), _one(curve.slope)
    return [[first, at_knee * (knee / first) ** (1.0 / slope)], [knee, at_knee]]


def _below(curve: fatigue.SNCurve, at_knee: float) -> list[list[float]]:
    """The same from the knee on, for a thousand times as many cycles; empty if it is level."""
    knee, slope = _one(curve.knee_cycles), _one(curve.slope_below)
    if not np.isfinite(slope):
        return []
    return [[knee, at_knee], [knee * _ONWARDS, at_knee * _ONWARDS ** (-1.0 / slope)]]


def _one(value: float | FloatArray) -> float:
    return float(np.ravel(value)[0])


def _equivalent(task: LifeTask, cycles: fatigue.Cycles, factor: float = 1.0) -> FloatArray:
    """Fully reversed amplitudes (n,), MPa, that do as much as cycles under all loads x factor."""
    amplitude, mean = factor * cycles.stress_amplitude, factor * cycles.mean_stress
    return fatigue.equivalent_amplitude(amplitude, mean, task.material.ultimate_stress)


def _plain_cycles(duty: DutyVerdict, point: int, task: LifeTask) -> fatigue.Cycles:
    """The cycles of a point by the reading with the largest one."""
    found = counted(duty, readings_of(duty, np.array([point])), task.counts).cycles
    row = int(found.stress_amplitude.max(axis=1).argmax())
    used = found.cycle_counts[row] > 0.0
    return fatigue.Cycles(
        found.stress_amplitude[row][used],
        found.mean_stress[row][used],
        found.cycle_counts[row][used],
    )


def _listed(
    task: LifeTask, cycles: fatigue.Cycles, per_cycle: FloatArray | None, required: float
) -> dict[str, Any]:
    """The cycles that do most damage, or are largest, and what the others come to."""
    counts, equivalent = cycles.cycle_counts, _equivalent(task, cycles)
    raised = _equivalent(task, cycles, required)
    with np.errstate(over="ignore"):  # beyond the curve
        harm = np.zeros_like(counts) if per_cycle is None else per_cycle * counts
    order = np.lexsort((-counts, -equivalent, -harm))
    kept, rest = order[:_MOST_CYCLES], order[_MOST_CYCLES:]
    return {
        "cycles": [
            [_finite(column[k]) for column in (counts, equivalent, harm, raised)] for k in kept
        ],
        "left_out": float(counts[rest].sum()),
        "left_damage": _finite(harm[rest].sum()),
    }


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def fkm_data(
    loaded: LoadedPart, level: Stressed, use: FkmUse
) -> tuple[dict[str, Any], dict[str, Any]]:
    """FKM's diagram of the critical point, and its S-N line with one cycle per run of the duty.

    line   (k, 2) MPa, mean and amplitude that are endured, compression without credit
    cloud  (m, 2) MPa, of the most used points, each brought to the critical point's strength in
           proportion to its own
    """
    found, duty = use.found(level), level.judged_duty
    assert isinstance(level, Level)
    strength = found.strength
    limit = float(found.limit.limit) * strength.endurance_share
    slopes = slopes_of(level.solutions)
    verdict = duty.verdicts[found.run]
    order = np.argsort(-verdict.goodman_bound, kind="stable")[:_MOST_USED]
    path = np.ascontiguousarray(duty.coefficients[:, duty.runs[found.run]])
    points = fkm_points(strength, duty.basis, path, order, slopes)
    own = np.asarray(strength.limit(points.gradient).limit) * strength.endurance_share
    cloud = np.stack([points.mean, points.amplitude], axis=1) * (limit / own)[:, None]
    peak = use.worst(level)
    factor = fatigue.fkm_factor(np.ones_like(_RAYS), _RAYS, found.limit.sensitivity)
    haigh = {
        "cycle": found.run,
        "criterion": "FKM",
        "mean": found.mean,
        "amplitude": found.amplitude,
        "endurance": limit,
        "sensitivity": found.limit.sensitivity,
        "ultimate": loaded.part.material.ultimate_stress,
        "yield": loaded.part.material.yield_stress,
        "line": np.stack([_RAYS * factor * limit, factor * limit], axis=1).tolist(),
        "cloud": cloud.tolist(),
        "paths": _paths(level, found.pair, peak),
    }
    return haigh, _fkm_life(loaded, level, use, limit)


def _fkm_life(loaded: LoadedPart, level: Level, use: FkmUse, limit: float) -> dict[str, Any]:
    """The guideline's S-N line and the longest chord of every cycle of the duty."""
    found, duty = use.found(level), level.judged_duty
    slopes = slopes_of(level.solutions)
    curve, required = fatigue.fkm_curve(found.limit), loaded.required.fatigue
    cycles = []
    for name, run in cycles_of(duty).items():
        path = np.ascontiguousarray(duty.coefficients[:, run])
        one = fkm_points(found.strength, duty.basis, path, np.array([found.point]), slopes)
        used = float(one.utilisation[0]) if len(one.points) else 0.0
        cycles.append([loaded.duty.cycles[name], used * limit, 0.0, required * used * limit])
    at_knee = float(found.limit.limit)
    return {
        "asked": "infinite", "required": required, "chain": "FKM", "why": "", "limit": limit,
        "line": _line(curve, at_knee, _FKM_FIRST), "below": _below(curve, at_knee),
        "ultimate": found.strength.material.ultimate_strength, "endless": True,
        "allowed": 1.0, "damage": None, "state": "", "cycles": cycles,
        "left_out": 0.0, "left_damage": 0.0,
    }  # fmt: skip
