"""Cycles counted out of stress histories by the rainflow method.

`count_cycles` is ASTM E1049-85 (2017), 5.4.4, to the letter, with half cycles; it suits a history
that happens once. A machine repeats its cycle: `count_closed_cycles` begins and ends at the highest
peak, ASTM E1049-85, 5.4.5, so every cycle closes. That is the count of the four-point rule with the
residue repeated, and does not depend on where the history is cut open. Verdicts use this one.

The counter is the package `rainflow` (MIT, one file of Python without dependencies, exact on the
standard's example). Of the others that are kept, fatpack knows no half cycles and pyLife brings
pandas and HDF5; they are compiled, but turning points are found here in numpy, and few are left
to count.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import rainflow  # type: ignore[import-untyped]

from fatigue.stress_path import FloatArray, point_blocks, refuse

# Cycles smaller than this fraction of the largest stress of their history are its round-off.
_ROUND_OFF = 1e-12

_Counts = dict[tuple[float, float], float]  # how often each (valley, peak) was counted


@dataclass(frozen=True, eq=False)
class Cycles:
    """Stress cycles and how often each happens, the largest first.

    stress_amplitude  (n_cycles,) or (n_points, n_cycles)  MPa, half the range
    mean_stress       the same shape                       MPa
    cycle_counts      the same shape                       half cycles count 0.5

    A point with fewer cycles than others has zeros behind its last.
    """

    stress_amplitude: FloatArray
    mean_stress: FloatArray
    cycle_counts: FloatArray

    def __post_init__(self) -> None:
        shape = self.stress_amplitude.shape
        others = (self.mean_stress.shape, self.cycle_counts.shape)
        if len(shape) not in (1, 2) or others != (shape, shape):
            raise ValueError(
                "cycles need amplitudes, means and counts of one shape, (n_cycles,) or "
                f"(n_points, n_cycles), got {shape}, {others[0]} and {others[1]}"
            )
        for what, values in (
            ("amplitude", self.stress_amplitude),
            ("mean", self.mean_stress),
            ("count", self.cycle_counts),
        ):
            refuse(~np.isfinite(values), f"the {what} of a cycle is not finite", values)
        refuse(self.stress_amplitude < 0.0, "an amplitude is below 0 MPa", self.stress_amplitude)
        refuse(self.cycle_counts < 0.0, "a cycle count is below 0", self.cycle_counts)

    @property
    def stress_range(self) -> FloatArray:
        """Twice the amplitude, MPa."""
        return 2.0 * self.stress_amplitude

    @property
    def peak(self) -> FloatArray:
        """The highest stress of each cycle, MPa."""
        return self.mean_stress + self.stress_amplitude

    @property
    def valley(self) -> FloatArray:
        """The lowest stress of each cycle, MPa."""
        return self.mean_stress - self.stress_amplitude

    def repeated(self, times: float) -> Cycles:
        """Return these cycles with all counts multiplied."""
        return replace(self, cycle_counts=self.cycle_counts * times)


def count_cycles(history: npt.ArrayLike) -> Cycles:
    """Return the cycles and half cycles of a history (n_positions,) that happens once.

    ASTM E1049-85 (2017), 5.4.4; equal cycles are one entry. A history that never changes has none.

    >>> count_cycles([-2, 1, -3, 5, -1, 3, -4, 4, -2]).stress_range.tolist()
    [9.0, 8.0, 8.0, 6.0, 4.0, 4.0, 3.0]
    """
    values = check_histories(history)
    if len(values) != 1 or np.ndim(history) != 1:
        raise ValueError(f"count_cycles takes one history, got shape {np.shape(history)}")
    turning = _turning_points(values)[0]
    turning[[0, -1]] = True
    cycles = _as_cycles([_count(values[0][turning].tolist())], _smallest(values).tolist())
    return _of_one_point(cycles)


def count_closed_cycles(history: npt.ArrayLike) -> Cycles:
    """Return the cycles of one repetition of histories that repeat without end.

    history  (n_positions,) or (n_points, n_positions)  MPa; its last position is followed by its
             first, and may or may not repeat it

    ASTM E1049-85 (2017), 5.4.5: the count starts at the highest peak, so that all cycles are whole.
    A history that never changes is one cycle without amplitude, so that its mean is not lost.
    Cycles below 1e-12 of the largest stress of their history are round-off, and left out.

    >>> cycles = count_closed_cycles([0, 500, 200, 400, 300, 500, -300, 200, -500])
    >>> cycles.stress_range.tolist(), cycles.cycle_counts.tolist()
    ([1000.0, 500.0, 300.0, 100.0], [1.0, 1.0, 1.0, 1.0])
    """
    histories = check_histories(history)
    found: list[_Counts] = []
    smallest: list[float] = []
    for block in point_blocks(len(histories), 8 * histories.shape[1]):
        path = _from_the_peak(histories[block])
        turning = _turning_points(path)
        smallest += _smallest(path).tolist()
        for values, turns in zip(path, turning, strict=True):
            between = values[turns].tolist()
            peak = float(values[0])
            if len(between) > 1:
                found.append(_count([peak, *between, peak]))
            else:  # one valley or none: nothing to sort out
                found.append({(between[0] if between else peak, peak): 1.0})
    assert all(count.is_integer() for counts in found for count in counts.values())
    cycles = _as_cycles(found, smallest)
    return _of_one_point(cycles) if np.ndim(history) == 1 else cycles


def check_histories(history: npt.ArrayLike) -> FloatArray:
    """Return histories (n_points, n_positions) of floats, or say which value cannot be used."""
    histories = np.asarray(history, dtype=np.float64)
    if histories.ndim not in (1, 2) or 0 in histories.shape:
        raise ValueError(
            "a stress history needs the shape (n_positions,) or (n_points, n_positions) with at "
            f"least one position, got {histories.shape}"
        )
    refuse(~np.isfinite(histories), "the stress history is not finite", histories, "position")
    return np.atleast_2d(histories)


def _from_the_peak(histories: FloatArray) -> FloatArray:
    """Turn each history so that it begins at its highest value, and repeat that at the end."""
    n_positions = histories.shape[1]
    order = np.arange(n_positions + 1) + histories.argmax(axis=1)[:, None]
    return np.take_along_axis(histories, order % n_positions, axis=1)


def _turning_points(path: FloatArray) -> npt.NDArray[np.bool_]:
    """Return where each path turns, not counting its ends; a plateau turns at its last position."""
    turns = np.zeros(path.shape, dtype=bool)
    if path.shape[1] < 3:
        return turns
    # signs of the differences: the difference of two huge or two tiny numbers cannot mislead these
    direction = (path[:, 1:] > path[:, :-1]).astype(np.int8) - (path[:, 1:] < path[:, :-1])
    steps = np.where(direction != 0, np.arange(direction.shape[1]), 0)
    latest = np.maximum.accumulate(steps, axis=1)  # the step that led onto a plateau
    direction = np.take_along_axis(direction, latest, axis=1)
    turns[:, 1:-1] = direction[:, :-1] * direction[:, 1:] < 0
    return turns


def _count(values: list[float]) -> _Counts:
    """Return how often the package counts each (valley, peak) of a list of turning points.

    The package compares ranges with one end in common, which only the order of the other ends
    decides; it is given their ranks, as differences of stresses are rounded and whole numbers not.
    The last is given twice: it finds nothing in a list of two.
    """
    values = [*values, values[-1]]
    rank = {value: index for index, value in enumerate(sorted(set(values)))}
    counts: _Counts = defaultdict(float)
    for _, _, count, first, second in rainflow.extract_cycles([rank[value] for value in values]):
        low, high = values[first], values[second]
        if low != high:
            counts[(low, high) if low < high else (high, low)] += count
    return counts


def _smallest(path: FloatArray) -> FloatArray:
    """Return, per path, the smallest amplitude that is not round-off, MPa."""
    return np.asarray(_ROUND_OFF / 2.0 * np.abs(path).max(axis=-1))


def _as_cycles(found: Sequence[_Counts], smallest: Iterable[float]) -> Cycles:
    """Return (n_points, n_cycles) cycles, the largest first, of each point's counts."""
    rows = []
    for counts, limit in zip(found, smallest, strict=True):
        # halves first: the sum or difference of two large numbers could overflow
        row = [
            (high / 2.0 - low / 2.0, low / 2.0 + high / 2.0, count)
            for (low, high), count in counts.items()
        ]
        kept = [cycle for cycle in row if cycle[0] >= limit]
        # without any amplitude, the mean is what there is to judge
        rows.append(sorted(kept, reverse=True) or [(0.0, mean, n) for _, mean, n in row[:1]])
    table = np.zeros((3, len(rows), max(map(len, rows))))
    for index, row in enumerate(rows):
        if row:
            table[:, index, : len(row)] = np.transpose(row)
    return Cycles(table[0], table[1], table[2])


def _of_one_point(cycles: Cycles) -> Cycles:
    return Cycles(cycles.stress_amplitude[0], cycles.mean_stress[0], cycles.cycle_counts[0])
