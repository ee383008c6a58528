"""Ends of the colour scales: extremes over all nodes and all positions that a page keeps."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from reports.live.fields import FloatArray, IntArray, LiveFields, principal_range
from reports.live.sampling import Sample

_TOGETHER = 64  # positions
_MORE = 1.0 + 1e-5  # peaks are known in double precision, fields in single


def scales(
    live: LiveFields, sample: Sample, kept: Mapping[str, IntArray], moved: Mapping[str, float]
) -> dict[str, dict[str, Any]]:
    """Field -> smallest and largest value, and its unit.

    kept   cycle -> positions that count
    moved  cycle -> largest displacement at these, of `displacements`
    """
    low, high = principals(live, sample, kept)
    scale: dict[str, dict[str, Any]] = {
        "mises": {"from": 0.0, "to": max(sample.peaks.values(), default=0.0), "unit": "MPa"},
        "principal": {"from": low, "to": high, "unit": "MPa"},
    }
    if any(moved.values()):
        scale["displacement"] = {"from": 0.0, "to": max(moved.values()), "unit": "mm"}
    return scale


def displacements(live: LiveFields, kept: Mapping[str, IntArray]) -> dict[str, float]:
    """Cycle -> largest displacement at some positions, mm; 0 where it is not known."""
    moved = dict.fromkeys(kept, 0.0)
    if live.displacement is None:
        return moved
    ways = np.ascontiguousarray(live.displacement.transpose(2, 1, 0), dtype=np.float64)
    for name, positions in kept.items():
        weights = live.coefficients[name][:, positions]
        for first in range(0, len(positions), _TOGETHER):
            some = weights[:, first : first + _TOGETHER]
            square = np.zeros((len(live.nodes), some.shape[1]))
            for way in ways:
                part = way @ some
                part *= part
                square += part
            moved[name] = max(moved[name], float(np.sqrt(square.max(initial=0.0))))
    return moved


def principals(
    live: LiveFields, sample: Sample, kept: Mapping[str, IntArray]
) -> tuple[float, float]:
    """Smallest and largest principal stress at some positions, MPa; 0 is counted in.

    No principal stress exceeds the mean stress by more than 2/3 of the von Mises stress, and that
    one is not above its peak at the position: only nodes that this bound leaves are looked at.
    """
    ranges = [principal_range(stress.swapaxes(1, 2)) for stress in sample.stress.values()]
    low, high = min(0.0, *(r[0] for r in ranges)), max(0.0, *(r[1] for r in ranges))
    fields = live.stress.astype(np.float64)
    means = np.ascontiguousarray(fields[:, :, :3].mean(axis=2).T)
    for name, positions in kept.items():
        weights = live.coefficients[name][:, positions]
        reach = 2 / 3 * (_MORE * live.peaks[name][positions] + sample.lost[name])
        blocks = [
            means @ weights[:, first : first + _TOGETHER]
            for first in range(0, len(positions), _TOGETHER)
        ]
        most = np.concatenate([block.max(axis=0) for block in blocks])
        least = np.concatenate([block.min(axis=0) for block in blocks])
        high = _highest(fields, means, weights, reach, most, high)
        low = -_highest(fields, means, -weights, reach, -least, -low)
    return low, high


def _highest(
    fields: FloatArray,
    means: FloatArray,
    weights: FloatArray,
    reach: FloatArray,
    most: FloatArray,
    known: float,
) -> float:
    """Largest principal stress over positions, or `known` if that is larger.

    means (n, M) of the fields; reach and most (K,): how far a principal stress is above the mean
    stress at a position at most, and the largest mean stress there.
    """
    for position in np.argsort(-(most + reach), kind="stable"):
        if most[position] + reach[position] <= known:
            break
        drive = weights[:, position]
        some = np.flatnonzero(means @ drive + reach[position] > known)
        known = max(known, principal_range(np.tensordot(drive, fields[:, some], axes=1))[1])
    return known
