"""Readings of a stress path: one stress with a sign over a duty, whose cycles can be counted.

Rainflow counts one number over time. A stress path of six components is therefore read along
chords: the longest of each cycle of the duty, and the longest of all together. The reading along a
chord is the component of the deviator in its direction, an equivalent stress (von Mises) with a
sign. Each reading is counted over the whole duty, transitions among it, and the worst one decides:
what a cycle does along its own chord is not hidden by a larger one in another direction.

The mean of a counted cycle is Goodman's: the largest principal stress in the middle between the
states at its peak and at its valley, never below 0.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from checks.stress.duty_verdict import JOINED, DutyVerdict
from fatigue import (
    Cycles,
    chord_path,
    critical_plane,
    duty_cycles,
    findley_criterion,
    goodman,
    principal_stresses,
)
from fatigue.proportionality import PROPORTIONAL
from geometry.mesh import FloatArray, IntArray

_SAME = 1e-9  # of the largest: values along a chord that count as equal
_PARALLEL = 1e-9  # chords whose readings differ by less, of their size, are one


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings of some points over a duty, n of them, several per point.

    points   (n,)     surface points
    runs     (n,)     name of the path whose longest chord is read along
    along    (n, p)   MPa, over the positions of all cycles behind one another
    raised   (n,)     by how much cycles are raised: bound of Findley's utilisation on that path
                      over Goodman's, at least 1
    stress   point -> (6, p) MPa
    """

    points: IntArray
    runs: tuple[str, ...]
    along: FloatArray
    raised: FloatArray
    stress: Mapping[int, FloatArray]


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
    return Readings(
        np.array([point for point, *_ in found]),
        tuple(name for _, name, *_ in found),
        np.stack([along for _, _, along, _ in found]),
        np.array([raised for *_, raised in found]),
        {int(point): verdict.basis[point] @ path for point in points},
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


@dataclass(frozen=True, eq=False)
class CountedReadings:
    """Counted cycles of readings, (n, n_cycles), and where each has its ends.

    cycles        means as Goodman has them, amplitudes and means raised
    peak, valley  (n, n_cycles) of the positions behind one another; 0 where there is no cycle
    """

    cycles: Cycles
    peak: IntArray
    valley: IntArray


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
    for row, point in enumerate(readings.points):
        used = cycles.cycle_counts[row] > 0.0
        stress, along = readings.stress[int(point)], readings.along[row]
        peak[row, used] = _places(cycles.peak[row][used], along, stress)
        valley[row, used] = _places(cycles.valley[row][used], along, stress)
        middle = (stress[:, peak[row, used]] + stress[:, valley[row, used]]).T / 2.0
        mean[row, used] = np.maximum(principal_stresses(middle)[:, 2], 0.0)
    raised = readings.raised[:, None]
    found = Cycles(raised * cycles.stress_amplitude, raised * mean, cycles.cycle_counts)
    return CountedReadings(found, peak, valley)


def _places(values: FloatArray, along: FloatArray, stress: FloatArray) -> IntArray:
    """Positions where a reading has some values; of several the one with the highest principal."""
    highest = principal_stresses(stress.T)[:, 2]
    slack = _SAME * max(float(np.abs(along).max()), 1e-300)
    near = np.abs(along - values[:, None])
    same = near <= near.min(axis=1, keepdims=True) + slack
    return np.asarray(np.where(same, highest, -np.inf).argmax(axis=1))
