"""Finite life of a part on one mesh: the cycles of its duty counted point by point, Miner's sum.

Each point is read along several chords (`checks.strength.equivalent_stress_history`); the cycles of
each reading, those between the cycles of the duty among them, are counted by rainflow
(`fatigue.duty_cycles`), and the reading with the smallest safety decides. Where Findley's criterion
is worse than Goodman's on a path, the cycles read along its chord are raised by the ratio of both
at that point.

The points are counted in the order of a bound on their utilisation u, amplitude and highest
principal stress of the whole path together: no cycle of a point exceeds it. Loads n times as large
do at most the damage of `total` cycles at n u of the endurance limit, so the safety is at least

    c/u,   c = min(1, (allowed damage N_D / total)**(1/k'))     k' the slope below the knee

and the count ends where that is not below the worst safety found.

Below the endurance limit damage is Haibach's, but only where a larger cycle has begun it: where
none exceeds the limit the life is infinite, and the safety is at least that against the limit. That
needs an endurance limit, which aluminium has not, and a part that nothing has used before.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from checks.design.materials import Material
from checks.strength.equivalent_stress_history import (
    Readings,
    counted,
    cycles_of,
    joined,
    raised_exactly,
    readings_of,
)
from checks.stress.duty_verdict import JOINED, DutyVerdict
from fatigue import (
    Cycles,
    MeanStressMaterial,
    SNCurve,
    basquin_curve,
    equivalent_amplitude,
    goodman,
    life_verdict,
    low_cycle_fraction,
    von_mises_peaks,
)
from fatigue.proportionality import PROPORTIONAL
from fatigue.stress_path import point_blocks
from geometry.mesh import FloatArray, IntArray

_TOGETHER = 32  # points that are counted before the bound is asked again
_ROUND_OFF = 1e-9  # of a bound
_AXIAL = 0.75  # of the ultimate strength, what 1e3 cycles of axial force leave
_ALUMINIUM = 0.9  # the same in bending, of metals other than steel
_NO_KNEE = 5e8  # cycles at which the strength of metals without an endurance limit is stated


@dataclass(frozen=True, eq=False)
class DutyLife:
    """Life of one point of a part.

    point     surface point
    safety    factor on all loads with which the life's cycles do just the allowed damage
    damage    Miner's sum of the life's cycles; 0 where none exceeds the endurance limit
    pair      valley and peak of the cycle that does most damage, of all positions of all cycles
    run       the path whose longest chord the cycles were read along
    raised    by how much Findley's plane raised them, at least 1
    cycles    counted on that reading, (n_cycles,), the largest first
    """

    point: int
    safety: float
    damage: float
    pair: tuple[int, int]
    run: str
    raised: float
    cycles: Cycles


@dataclass(frozen=True, eq=False)
class LifeTask:
    """Data of a finite life: how often the cycles run, and the material of the S-N curve.

    counts          of a life, by the duty's cycles
    axial           whether the whole section is stressed alike
    allowed_damage  Miner's sum that is left
    begun           whether earlier use has done damage, which then goes on below the limit
    """

    counts: Mapping[str, float]
    material: Material
    axial: bool
    allowed_damage: float
    begun: bool = False

    @property
    def endless(self) -> bool:
        """True if a life without a cycle above the endurance limit is infinite."""
        return not self.begun and self.material.endurance_ratio is None


def life_curve(material: Material, limits: FloatArray, *, axial: bool) -> SNCurve:
    """Return the S-N curve through the strength at 1e3 cycles and the endurance limits, MPa.

    Steel: f S_u (Shigley, 9th ed., figure 6-18), in axial force not above 0.75 S_u, knee at 1e6.
    Metals with a stated endurance ratio: 0.9 S_u, axial 0.75 S_u, and the ratio's 5e8 cycles
    (Norton, Machine Design, 5th ed., section 6.6). Below the knee the slope is Haibach's 2 k - 1:
    cycles under the endurance limit do damage where larger ones have begun it.
    """
    fraction, knee = _start_and_knee(material, axial=axial)
    ultimate = material.ultimate_stress
    return basquin_curve(ultimate, limits, fraction, knee_cycles=knee).below_knee("haibach")


def why_no_curve(material: Material, limit: float, *, axial: bool) -> str | None:
    """Why there is no S-N curve through an endurance limit, MPa; None where there is one."""
    fraction, _ = _start_and_knee(material, axial=axial)
    start = fraction * material.ultimate_stress
    if limit < start:
        return None
    return (
        f"no S-N line: the endurance limit of {limit:.4g} MPa is not below the {start:.4g} MPa "
        f"that {material.name} endures 1000 times; lower its endurance_ratio"
    )


def _start_and_knee(material: Material, *, axial: bool) -> tuple[float, float]:
    """Share of the ultimate strength endured 1e3 times, and the cycles of the knee."""
    steel = material.endurance_ratio is None
    fraction = low_cycle_fraction(material.ultimate_stress) if steel else _ALUMINIUM
    return min(fraction, _AXIAL) if axial else fraction, 1e6 if steel else _NO_KNEE


def shortest_life(verdict: DutyVerdict, task: LifeTask) -> DutyLife:
    """Return the life of the point with the smallest safety; of equal ones the first found."""
    bound = _bound(verdict)
    most = sum(task.counts[name] * len(run) / 2 for name, run in cycles_of(verdict).items())
    curve = life_curve(task.material, verdict.limits, axial=task.axial)
    least = _least_share(curve, most, task.allowed_damage)
    order = np.argsort(-bound, kind="stable")
    best: DutyLife | None = None
    done = 0
    while done < len(order) and (best is None or least < best.safety * float(bound[order[done]])):
        points = order[done : done + _TOGETHER]
        done += len(points)
        for life in lives_of(verdict, task, points, below=np.inf if best is None else best.safety):
            if best is None or life.safety < best.safety:
                best = life
    assert best is not None
    return best


def lives_of(
    verdict: DutyVerdict,
    task: LifeTask,
    points: IntArray,
    factor: float = 1.0,
    below: float = np.inf,
) -> list[DutyLife]:
    """Return the lives of some points, all loads multiplied by a factor.

    Points whose safety is not below `below` may be left with a bound of it: Findley's plane is
    searched only where the bound says that it can matter.
    """
    readings = readings_of(verdict, points, factor)
    lives = _lives(verdict, task, readings)
    rows = [row for row, life in enumerate(lives) if life.safety < below]
    raised = readings.raised.copy()
    for row in rows:
        if raised[row] > 1.0:
            raised[row] = raised_exactly(verdict, readings.runs[row], lives[row].point)
    if (raised != readings.raised).any():
        readings = replace(readings, raised=raised)
        lives = _lives(verdict, task, readings)
    return [
        min((life for life in lives if life.point == point), key=lambda life: life.safety)
        for point in points
    ]


def _lives(verdict: DutyVerdict, task: LifeTask, readings: Readings) -> list[DutyLife]:
    """The life by every reading."""
    found = counted(verdict, readings, task.counts)
    cycles = found.cycles
    curve = life_curve(task.material, verdict.limits[readings.points], axial=task.axial)
    strength = MeanStressMaterial(task.material.ultimate_stress, task.material.yield_stress)
    life = life_verdict(cycles, curve, strength, allowed_damage=task.allowed_damage)
    per_cycle = curve.damage_per_cycle(
        equivalent_amplitude(cycles.stress_amplitude, cycles.mean_stress, strength)
    )
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        endless = 1.0 / life.infinite_utilisation if task.endless else np.zeros(len(life.safety))
        harm = np.where(cycles.cycle_counts > 0.0, per_cycle * cycles.cycle_counts, -1.0)
    whole = joined(verdict)
    lives = []
    for row, point in enumerate(readings.points):
        used = cycles.cycle_counts[row] > 0.0
        worst = int(harm[row].argmax()) if life.damage[row] > 0.0 else 0  # else the largest
        ends = whole[[found.peak[row, worst], found.valley[row, worst]]]
        lives.append(
            DutyLife(
                int(point),
                float(max(life.safety[row], endless[row])),
                0.0 if endless[row] >= 1.0 else float(life.damage[row]),
                (int(ends.min()), int(ends.max())),
                readings.runs[row],
                float(readings.raised[row]),
                Cycles(
                    cycles.stress_amplitude[row][used],
                    cycles.mean_stress[row][used],
                    cycles.cycle_counts[row][used],
                ),
            )
        )
    return lives


def _bound(verdict: DutyVerdict) -> FloatArray:
    """Utilisation (n_points,) that no cycle of a point exceeds, as it is read and raised.

    Half the longest chord is at most the largest amplitude over all paths; no normal stress is
    above p + 2/3 of the von Mises stress, p the hydrostatic stress: both at their largest.
    """
    path = np.ascontiguousarray(verdict.coefficients[:, joined(verdict)])
    widest = verdict.verdicts.get(JOINED, verdict.worst).bounds
    equivalent, _ = von_mises_peaks(verdict.basis, path)
    pressure = np.empty(len(verdict.basis))
    trace = verdict.basis[:, :3].sum(axis=1) / 3.0
    for block in point_blocks(len(trace), path.shape[1]):
        pressure[block] = (trace[block] @ path).max(axis=1)
    tension = np.maximum(pressure + 2.0 / 3.0 * equivalent, 0.0)
    used = widest.amplitude / verdict.limits + tension / verdict.ultimate
    return np.asarray(used * _raised(verdict) * (1.0 + _ROUND_OFF))


def _raised(verdict: DutyVerdict) -> FloatArray:
    """By how much Findley may raise the cycles of each point at most, (n_points,)."""
    raised = np.ones(len(verdict.basis))
    for name, run in verdict.runs.items():
        single = verdict.verdicts[name]
        points = np.flatnonzero((single.bounds.width > PROPORTIONAL) & (single.plane_bound > 0.0))
        if len(points):
            own = np.ascontiguousarray(verdict.coefficients[:, run])
            limits = verdict.limits[points]
            chords = goodman(verdict.basis[points], own, limits, verdict.ultimate)
            with np.errstate(divide="ignore"):
                ratio = single.plane_bound[points] / chords.utilisation
            raised[points] = np.maximum(raised[points], ratio)
    return raised


def _least_share(curve: SNCurve, most_cycles: float, allowed_damage: float) -> float:
    """Least product of a point's safety and its bound; the flattest curve gives it."""
    slope = float(np.min(curve.slope_below))
    at_limit = allowed_damage * float(np.min(curve.knee_cycles)) / most_cycles
    return float(min(1.0, at_limit ** (1.0 / slope)))
