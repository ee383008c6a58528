"""Finite life of a part on one mesh: the cycles of its duty counted point by point, Miner's sum.

At each point the stress path is read along the longest chord of the duty, as an equivalent stress
with a sign (von Mises), and its cycles are counted by rainflow, those between the cycles of the
duty among them (`fatigue.duty_cycles`). The mean of a counted cycle is that of the normal stress at
its peak and its valley, in the direction of the largest principal stress in the middle of the
longest chord: for the longest chord itself, Goodman's. Where Findley's criterion is worse than
Goodman's on the duty, amplitudes and means are raised by the ratio of their worst utilisations.

The points are counted in the order of a bound on their utilisation u, amplitude and highest
principal stress of the whole path together: no cycle of a point exceeds it. Loads n times as large
do at most the damage of `total` cycles at n u of the endurance limit, so the safety is at least

    c/u,   c = min(1, (allowed damage N_D / total)**(1/k'))     k' the slope below the knee

and the count ends where that is not below the worst safety found.

Below the endurance limit damage is Haibach's, but only where a larger cycle has begun it: where
none exceeds the limit the life is infinite, and the safety is at least that against the limit.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ballesta.duty_verdict import JOINED, DutyVerdict
from ballesta.materials import Material
from fatigue import (
    Cycles,
    MeanStressMaterial,
    SNCurve,
    basquin_curve,
    chord_path,
    duty_cycles,
    goodman,
    life_verdict,
    low_cycle_fraction,
    von_mises_peaks,
)
from fatigue.stress_path import point_blocks
from geometry.mesh import FloatArray, IntArray

_TOGETHER = 32  # points that are counted before the bound is asked again
_SAME = 1e-9  # of the range: values along the chord that count as equal
_AXIAL = 0.75  # of the ultimate strength, what 1e3 cycles of axial force leave
_ALUMINIUM = 0.9  # the same in bending, of metals other than steel
_NO_KNEE = 5e8  # cycles at which the strength of metals without an endurance limit is stated


@dataclass(frozen=True, eq=False)
class DutyLife:
    """Life of one point of a part.

    point     surface point
    safety    factor on all loads with which the life's cycles do just the allowed damage
    damage    Miner's sum of the life's cycles; 0 where none exceeds the endurance limit
    pair      positions at the ends of its longest chord, of all positions of all cycles
    cycles    counted at the point, (n_cycles,), the largest first
    """

    point: int
    safety: float
    damage: float
    pair: tuple[int, int]
    cycles: Cycles


@dataclass(frozen=True, eq=False)
class LifeTask:
    """What a life is asked of: how often the cycles run, and what the S-N curve needs to know.

    counts          of a life, by the duty's cycles
    axial           whether the whole section is stressed alike
    allowed_damage  Miner's sum that is left
    """

    counts: Mapping[str, float]
    material: Material
    axial: bool
    allowed_damage: float


def life_curve(material: Material, limits: FloatArray, *, axial: bool) -> SNCurve:
    """Return the S-N curve through the strength at 1e3 cycles and the endurance limits, MPa.

    Steel: f S_u (Shigley, 9th ed., figure 6-18), in axial force not above 0.75 S_u, knee at 1e6.
    Metals with a stated endurance ratio: 0.9 S_u, axial 0.75 S_u, and the ratio's 5e8 cycles
    (Norton, Machine Design, 5th ed., section 6.6). Below the knee the slope is Haibach's 2 k - 1:
    cycles under the endurance limit do damage where larger ones have begun it.
    """
    ultimate = material.ultimate_stress
    steel = material.endurance_ratio is None
    fraction = low_cycle_fraction(ultimate) if steel else _ALUMINIUM
    if axial:
        fraction = min(fraction, _AXIAL)
    knee = 1e6 if steel else _NO_KNEE
    return basquin_curve(ultimate, limits, fraction, knee_cycles=knee).below_knee("haibach")


def shortest_life(verdict: DutyVerdict, task: LifeTask) -> DutyLife:
    """Return the life of the point with the smallest safety; of equal ones the first found."""
    bound = _raised_by(verdict) * _bound(verdict, _joined(verdict)[1])
    runs = _cycles_of(verdict)
    most = sum(task.counts[name] * len(run) / 2 for name, run in runs.items())
    curve = life_curve(task.material, verdict.limits, axial=task.axial)
    least = _least_share(curve, most, task.allowed_damage)
    order = np.argsort(-bound, kind="stable")
    best: DutyLife | None = None
    counted = 0
    while counted < len(order) and (
        best is None or least < best.safety * float(bound[order[counted]])
    ):
        points = order[counted : counted + _TOGETHER]
        counted += len(points)
        for life in lives_of(verdict, task, points):
            if best is None or life.safety < best.safety:
                best = life
    assert best is not None
    return best


def lives_of(
    verdict: DutyVerdict, task: LifeTask, points: IntArray, factor: float = 1.0
) -> list[DutyLife]:
    """Return the lives of some points, all loads multiplied by a factor."""
    joined, path = _joined(verdict)
    runs = _cycles_of(verdict)
    ends = np.cumsum([len(run) for run in runs.values()])[:-1]
    pairs, along, normal = _histories(verdict, factor * path, points)
    cycles = duty_cycles(np.split(along, ends, axis=1), [task.counts[name] for name in runs])
    cycles = _with_means(cycles, along, normal, _raised_by(verdict))
    life = life_verdict(
        cycles,
        life_curve(task.material, verdict.limits[points], axial=task.axial),
        MeanStressMaterial(task.material.ultimate_stress, task.material.yield_stress),
        allowed_damage=task.allowed_damage,
    )
    endless = life.infinite_utilisation <= 1.0
    with np.errstate(divide="ignore"):
        safety = np.maximum(life.safety, 1.0 / life.infinite_utilisation)
    return [
        DutyLife(
            int(point),
            float(safety[row]),
            0.0 if endless[row] else float(life.damage[row]),
            (int(joined[pairs[row, 0]]), int(joined[pairs[row, 1]])),
            _used(cycles, row),
        )
        for row, point in enumerate(points)
    ]


def _used(cycles: Cycles, row: int) -> Cycles:
    """The cycles of one point, without the zeros behind its last."""
    used = cycles.cycle_counts[row] > 0.0
    return Cycles(
        cycles.stress_amplitude[row][used],
        cycles.mean_stress[row][used],
        cycles.cycle_counts[row][used],
    )


def _cycles_of(verdict: DutyVerdict) -> dict[str, IntArray]:
    """Positions of the cycles of the duty, without the path that joins them."""
    return {name: run for name, run in verdict.runs.items() if name != JOINED}


def _joined(verdict: DutyVerdict) -> tuple[IntArray, FloatArray]:
    """Positions (n,) of all cycles behind one another, and their coefficients (n_basis, n)."""
    joined = np.concatenate(list(_cycles_of(verdict).values()))
    return joined, np.ascontiguousarray(verdict.coefficients[:, joined])


def _raised_by(verdict: DutyVerdict) -> float:
    """Worst utilisation of the duty over Goodman's worst: above 1 where Findley decides."""
    worst = float(verdict.worst.utilisation.max())
    by_chord = max(float(v.goodman.utilisation.max()) for v in verdict.verdicts.values())
    return max(1.0, worst / by_chord) if by_chord > 0.0 else 1.0


def _bound(verdict: DutyVerdict, path: FloatArray) -> FloatArray:
    """Utilisation (n_points,) that no cycle of a point exceeds.

    Half the longest chord is at most the largest amplitude over all paths; no normal stress is
    above p + 2/3 of the von Mises stress, p the hydrostatic stress: both at their largest.
    """
    widest = verdict.verdicts.get(JOINED, verdict.worst).bounds
    equivalent, _ = von_mises_peaks(verdict.basis, path)
    pressure = np.empty(len(verdict.basis))
    trace = verdict.basis[:, :3].sum(axis=1) / 3.0
    for block in point_blocks(len(trace), path.shape[1]):
        pressure[block] = (trace[block] @ path).max(axis=1)
    tension = np.maximum(pressure + 2.0 / 3.0 * equivalent, 0.0)
    used = widest.amplitude / verdict.limits + tension / verdict.ultimate
    return np.asarray(used * (1.0 + _SAME))


def _least_share(curve: SNCurve, most_cycles: float, allowed_damage: float) -> float:
    """What a point's safety times its bound is at least; the flattest curve gives the least."""
    slope = float(np.min(curve.slope_below))
    at_limit = allowed_damage * float(np.min(curve.knee_cycles)) / most_cycles
    return float(min(1.0, at_limit ** (1.0 / slope)))


def _histories(
    verdict: DutyVerdict, path: FloatArray, points: IntArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Ends (n, 2) of the longest chord of some points over the whole duty, and two histories.

    Stress along the chord, and normal stress as the mean takes it, both (n, n_positions), MPa.
    """
    chords = goodman(verdict.basis[points], path, verdict.limits[points], verdict.ultimate)
    along = np.empty((len(points), path.shape[1]))
    normal = np.empty_like(along)
    for row, point in enumerate(points):
        first, second = (int(k) for k in chords.pair[row])
        along[row] = chord_path(verdict.basis[point], path, (first, second)).along
        stress = verdict.basis[point] @ path
        xx, yy, zz, xy, yz, zx = (stress[:, first] + stress[:, second]) / 2.0
        middle = np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
        x, y, z = np.linalg.eigh(middle)[1][:, 2]
        weights = np.array([x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * z * x])
        normal[row] = weights @ stress
    return chords.pair, along, normal


def _with_means(cycles: Cycles, along: FloatArray, normal: FloatArray, ratio: float) -> Cycles:
    """The cycles with the mean of the normal stress at their peak and valley, raised by a ratio.

    Peak and valley are found again by their value along the chord; of positions with equal values
    the one with the higher normal stress counts.
    """
    mean = np.zeros_like(cycles.mean_stress)
    for row, (values, stress) in enumerate(zip(along, normal, strict=True)):
        slack = _SAME * max(float(np.abs(values).max()), 1e-300)
        used = cycles.cycle_counts[row] > 0.0
        for ends in (cycles.peak[row][used], cycles.valley[row][used]):
            near = np.abs(values - ends[:, None])
            same = near <= near.min(axis=1, keepdims=True) + slack
            mean[row, used] += np.where(same, stress, -np.inf).max(axis=1) / 2.0
    return Cycles(ratio * cycles.stress_amplitude, ratio * mean, cycles.cycle_counts)
