"""Finite life of a part on one mesh: the cycles of its duty counted point by point, Miner's sum.

Each point is read along several chords; the cycles of
each reading, those between the cycles of the duty among them, are counted by rainflow
(`fatigue.duty_cycles`), and the reading with the smallest safety decides. Where Findley's criterion
is worse than Goodman's on a path, the cycles read along its chord are raised by the ratio of both
at that point.

The points are counted in the order of a bound on 1/safety. No cycle of a point exceeds the
amplitude a or the tension m of its whole path, and rainflow's ranges, twice as long in all, are no
longer than the path: L in one run of a cycle, in von Mises stress. A curve's damage grows at least
as fast as the amplitude, so that n runs do no more than n L/(4 a) cycles of a. With R the
amplitude that as many endure

    1/safety <= a/R + m/S_u

and the count ends where that is not above the worst found. Where the duty has several cycles, the
largest of each run may close with another one's: n more cycles of a.

Below the endurance limit damage is Haibach's, but only where a larger cycle has begun it: where
none exceeds the limit the life is infinite, and the safety is at least that against the limit. That
needs an endurance limit, which aluminium has not, and a part that nothing has used before.

A reading of a stress path is one stress with a sign over a duty. Rainflow counts one number over
time. A stress path of six components is therefore read along chords: the longest of each cycle of
the duty, and the longest of all together. The reading along a chord is the component of the
deviator in its direction, an equivalent stress (von Mises) with a sign. Each reading is counted
over the whole duty, transitions among it, and the worst one decides: what a cycle does along its
own chord is not hidden by a larger one in another direction.

The mean of a counted cycle is Goodman's: the largest principal stress in the middle between the
states at its peak and at its valley, never below 0.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from checks.design.materials import Material
from checks.stress.duty_verdict import JOINED, DutyVerdict
from fatigue import (
    Cycles,
    SNCurve,
    basquin_curve,
    chord_path,
    critical_plane,
    duty_cycles,
    equivalent_amplitude,
    findley_criterion,
    goodman,
    life_verdict,
    low_cycle_fraction,
    path_lengths,
    principal_stresses,
)
from fatigue.proportionality import PROPORTIONAL
from fatigue.stress_path import deviatoric_basis, point_blocks
from geometry.mesh import FloatArray, IntArray

_SAME = 1e-9  # of the largest: values along a chord that count as equal
_PARALLEL = 1e-9  # chords whose readings differ by less, of their size, are one
_TOGETHER = 32  # points that are counted before the bound is asked again
_ROUND_OFF = 1e-9  # of a bound
_LEAST = 1e-200  # instead of no amplitude, or no cycle
_AXIAL = 0.75  # of the ultimate strength, what 1e3 cycles of axial force leave
_ALUMINIUM = 0.9  # the same in bending, of metals other than steel


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings of some points over a duty, n of them, several per point.

    points   (n,)     surface points
    runs     (n,)     name of the path whose longest chord is read along
    along    (n, p)   MPa, over the positions of all cycles behind one another
    raised   (n,)     by how much cycles are raised: bound of Findley's utilisation on that path
                      over Goodman's, at least 1
    stress   point -> (6, p) MPa
    highest  point -> (p,) MPa, the largest principal stress
    """

    points: IntArray
    runs: tuple[str, ...]
    along: FloatArray
    raised: FloatArray
    stress: Mapping[int, FloatArray]
    highest: Mapping[int, FloatArray]

    def only(self, rows: IntArray) -> "Readings":
        """Some of the readings, by row."""
        return replace(
            self,
            points=self.points[rows],
            runs=tuple(self.runs[row] for row in rows),
            along=self.along[rows],
            raised=self.raised[rows],
        )


@dataclass(frozen=True, eq=False)
class CountedReadings:
    """Counted cycles of readings, (n, n_cycles), and where each has its ends.

    cycles        means as Goodman has them, amplitudes and means raised
    peak, valley  (n, n_cycles) of the positions behind one another; 0 where there is no cycle
    """

    cycles: Cycles
    peak: IntArray
    valley: IntArray


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
    Metals with a stated endurance ratio: 0.9 S_u, axial 0.75 S_u, and the ratio's own cycles, 5e8
    where none are stated (Norton, Machine Design, 5th ed., section 6.6). Below the knee the slope
    is Haibach's 2 k - 1: cycles under the endurance limit do damage where larger ones have begun
    it.
    """
    fraction, knee = _start_and_knee(material, axial=axial)
    ultimate = material.ultimate_stress
    return basquin_curve(ultimate, limits, fraction, knee_cycles=knee).below_knee("haibach")


def why_no_curve(material: Material, limit: float, *, axial: bool) -> str | None:
    """Why there is no S-N curve through an endurance limit, MPa; None where there is one."""
    fraction, knee = _start_and_knee(material, axial=axial)
    start = fraction * material.ultimate_stress
    if limit >= start:
        return (
            f"no S-N line: the endurance limit of {limit:.4g} MPa is not below the {start:.4g} MPa "
            f"that {material.name} endures 1000 times; lower its endurance_ratio"
        )
    if knee / 1e3 <= start / limit:
        return (
            f"no S-N line: from the {start:.4g} MPa that {material.name} endures 1000 times it "
            f"would fall to {limit:.4g} MPa within {knee:.4g} cycles, by more than a slope of 1; "
            "raise its endurance_ratio or endurance_cycles"
        )
    return None


def _start_and_knee(material: Material, *, axial: bool) -> tuple[float, float]:
    """Share of the ultimate strength endured 1e3 times, and the cycles of the knee."""
    steel = material.endurance_ratio is None
    fraction = low_cycle_fraction(material.ultimate_stress) if steel else _ALUMINIUM
    return min(fraction, _AXIAL) if axial else fraction, 1e6 if steel else material.endurance_cycles


def shortest_life(verdict: DutyVerdict, task: LifeTask) -> DutyLife:
    """Return the life of the point with the smallest safety; of equal ones the first found."""
    found = shorter_life(verdict, task, None)
    assert found is not None
    return found


def shorter_life(verdict: DutyVerdict, task: LifeTask, than: float | None) -> DutyLife | None:
    """Return the shortest life where its safety is below another; None where none is.

    than  None: whatever it is
    """
    bound = most_used(verdict, task)
    order = np.argsort(-bound, kind="stable")
    best: DutyLife | None = None
    done = 0
    while done < len(order) and (than is None or than * float(bound[order[done]]) > 1.0):
        points = order[done : done + _TOGETHER]
        done += len(points)
        readings = readings_of(verdict, points)
        bounds = _lives(verdict, task, readings)
        for least_life in sorted(_least(bounds, points), key=lambda life: life.safety):
            if than is None or least_life.safety < than:
                [life] = _exactly(verdict, task, readings, bounds, np.array([least_life.point]))
                if than is None or life.safety < than:
                    best, than = life, life.safety
    return best


def lives_of(
    verdict: DutyVerdict, task: LifeTask, points: IntArray, factor: float = 1.0
) -> list[DutyLife]:
    """Return the lives of some points, all loads multiplied by a factor."""
    readings = readings_of(verdict, points, factor)
    return _exactly(verdict, task, readings, _lives(verdict, task, readings), points)


def _exactly(
    verdict: DutyVerdict,
    task: LifeTask,
    readings: Readings,
    bounds: Sequence[DutyLife],
    points: IntArray,
) -> list[DutyLife]:
    """Lives of some points of those read, Findley's planes searched where they may raise them.

    bounds  lives by every reading, raised as much as may be
    """
    rows = np.flatnonzero(np.isin(readings.points, points))
    own, lives = readings.only(rows), [bounds[int(row)] for row in rows]
    raised = own.raised.copy()
    for row in np.flatnonzero(raised > 1.0):
        raised[row] = raised_exactly(verdict, own.runs[row], int(own.points[row]))
    if (raised != own.raised).any():
        lives = _lives(verdict, task, replace(own, raised=raised))
    return _least(lives, points)


def _least(lives: Sequence[DutyLife], points: IntArray) -> list[DutyLife]:
    """The life of each point by the reading with the least safety; the first of equal ones."""
    return [
        min((life for life in lives if life.point == point), key=lambda life: life.safety)
        for point in points
    ]


def _lives(verdict: DutyVerdict, task: LifeTask, readings: Readings) -> list[DutyLife]:
    """The life by every reading."""
    found = counted(verdict, readings, task.counts)
    cycles = found.cycles
    curve = life_curve(task.material, verdict.limits[readings.points], axial=task.axial)
    ultimate = task.material.ultimate_stress
    life = life_verdict(cycles, curve, ultimate, allowed_damage=task.allowed_damage)
    per_cycle = curve.damage_per_cycle(
        equivalent_amplitude(cycles.stress_amplitude, cycles.mean_stress, ultimate)
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


def most_used(verdict: DutyVerdict, task: LifeTask) -> FloatArray:
    """Not less than 1/safety (n_points,) of a finite life, as its cycles are read and raised.

    No normal stress is above p + 2/3 of the von Mises stress, p the hydrostatic stress.
    """
    path = np.ascontiguousarray(verdict.coefficients[:, joined(verdict)])
    amplitude, endured = largest_endured(verdict, task)
    vectors, trace = deviatoric_basis(verdict.basis), verdict.basis[:, :3].sum(axis=1)
    tension = np.empty(len(trace))
    for block in point_blocks(len(trace), 5 * path.shape[1]):
        swing = vectors[block] @ path
        equivalent = np.sqrt(np.einsum("pdk,pdk->pk", swing, swing))
        tension[block] = (trace[block] @ path + 2.0 * equivalent).max(axis=1) / 3.0
    tension = np.maximum(tension, 0.0)
    used = amplitude / endured + tension / verdict.ultimate
    return np.asarray(used * _raised(verdict) * (1.0 + _ROUND_OFF))


def largest_endured(verdict: DutyVerdict, task: LifeTask) -> tuple[FloatArray, FloatArray]:
    """No less than the largest amplitude of each point (n_points,), and what is endured of it, MPa.

    Half the longest chord is at most the largest amplitude over all paths. It is endured as often
    as the length of the path allows at the most.
    """
    amplitude = verdict.verdicts.get(JOINED, verdict.worst).bounds.amplitude
    runs = cycles_of(verdict)
    often = np.full(
        len(amplitude), sum(task.counts[name] for name in runs) if len(runs) > 1 else 0.0
    )
    for name, run in runs.items():
        length = path_lengths(verdict.basis, np.ascontiguousarray(verdict.coefficients[:, run]))
        often = often + task.counts[name] * length / (4.0 * np.maximum(amplitude, _LEAST))
    curve = life_curve(task.material, verdict.limits, axial=task.axial)
    return amplitude, curve.amplitude(task.allowed_damage / np.maximum(often, _LEAST))


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


def cycles_of(verdict: DutyVerdict) -> dict[str, IntArray]:
    """Positions of the cycles of the duty, without the path that joins them."""
    return {name: run for name, run in verdict.runs.items() if name != JOINED}


def joined(verdict: DutyVerdict) -> IntArray:
    """Positions (p,) of all cycles of a duty behind one another."""
    return np.concatenate(list(cycles_of(verdict).values()))


def readings_of(verdict: DutyVerdict, points: IntArray, factor: float = 1.0) -> Readings:
    """Read some points, all loads multiplied by a factor."""
    place = np.full(verdict.coefficients.shape[1], -1)
    whole = joined(verdict)
    place[whole] = np.arange(len(whole))
    path = factor * np.ascontiguousarray(verdict.coefficients[:, whole])
    chords = {}
    for name, run in verdict.runs.items():
        own = factor * np.ascontiguousarray(verdict.coefficients[:, run])
        chords[name] = goodman(verdict.basis[points], own, verdict.limits[points], verdict.ultimate)
    found: list[tuple[int, str, FloatArray, float]] = []
    for row, point in enumerate(points):
        kept: list[FloatArray] = []
        for name, run in verdict.runs.items():
            chord = chords[name]
            first, second = (int(place[run[k]]) for k in chord.pair[row])
            along = chord_path(verdict.basis[point], path, (first, second)).along
            raised = raised_at_most(
                verdict, name, int(point), float(chord.utilisation[row]) / factor
            )
            size = float(np.abs(along).max())
            same = [k for k in kept if np.abs(along - k).max() <= _PARALLEL * size]
            if (same and raised == 1.0) or (kept and not chord.amplitude[row] > 0.0):
                continue
            kept.append(along)
            found.append((int(point), name, along, raised))
    stress = {int(point): verdict.basis[point] @ path for point in points}
    return Readings(
        np.array([point for point, *_ in found]),
        tuple(name for _, name, *_ in found),
        np.stack([along for _, _, along, _ in found]),
        np.array([raised for *_, raised in found]),
        stress,
        {point: principal_stresses(own.T)[:, 2] for point, own in stress.items()},
    )


def raised_at_most(verdict: DutyVerdict, run: str, point: int, by_chord: float) -> float:
    """Bound of Findley's utilisation of a point on a path over Goodman's, at least 1.

    by_chord  Goodman's, of the loads as they are
    """
    bound = float(verdict.verdicts[run].plane_bound[point])
    return max(1.0, bound / by_chord) if by_chord > 0.0 else 1.0


def raised_exactly(verdict: DutyVerdict, run: str, point: int) -> float:
    """Findley's utilisation of a point on a path over Goodman's, at least 1."""
    if verdict.verdicts[run].bounds.width[point] <= PROPORTIONAL:
        return 1.0
    criterion = findley_criterion()
    path = np.ascontiguousarray(verdict.coefficients[:, verdict.runs[run]])
    limit = float(verdict.limits[point])
    plane = critical_plane(verdict.basis[point] @ path, criterion.k)
    chord = goodman(verdict.basis[[point]], path, limit, verdict.ultimate)
    by_chord = float(chord.utilisation[0])
    return max(1.0, plane.value / (criterion.limit_ratio * limit) / by_chord) if by_chord else 1.0


def counted(
    verdict: DutyVerdict, readings: Readings, counts: Mapping[str, float]
) -> CountedReadings:
    """Count every reading over the whole duty, each cycle of it as often as `counts` says."""
    runs = cycles_of(verdict)
    ends = np.cumsum([len(run) for run in runs.values()])[:-1]
    blocks = np.split(readings.along, ends, axis=1)
    cycles = duty_cycles(blocks, [counts[name] for name in runs])
    mean = np.zeros_like(cycles.mean_stress)
    peak, valley = (np.zeros(mean.shape, dtype=np.intp) for _ in range(2))
    count = cycles.cycle_counts > 0.0
    middle = []
    for row, point in enumerate(readings.points):
        used, along = count[row], readings.along[row]
        stress, highest = readings.stress[int(point)], readings.highest[int(point)]
        peak[row, used] = _places(cycles.peak[row][used], along, highest)
        valley[row, used] = _places(cycles.valley[row][used], along, highest)
        middle.append((stress[:, peak[row, used]] + stress[:, valley[row, used]]).T / 2.0)
    mean[count] = np.maximum(principal_stresses(np.concatenate(middle))[:, 2], 0.0)
    raised = readings.raised[:, None]
    found = Cycles(raised * cycles.stress_amplitude, raised * mean, cycles.cycle_counts)
    return CountedReadings(found, peak, valley)


def _places(values: FloatArray, along: FloatArray, highest: FloatArray) -> IntArray:
    """Positions where a reading has some values; of several the one with the highest principal."""
    slack = _SAME * max(float(np.abs(along).max()), 1e-300)
    near = np.abs(along - values[:, None])
    same = near <= near.min(axis=1, keepdims=True) + slack
    return np.asarray(np.where(same, highest, -np.inf).argmax(axis=1))
