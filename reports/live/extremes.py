"""Ends of the colour scales: extremes over all nodes and all positions that a page keeps."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from checks.result.live_fields import (
    FloatArray,
    IntArray,
    LiveFields,
    RealArray,
    largest_principal,
)
from reports.live.accuracy import LENGTH_METRIC, lost_in_single
from reports.live.sampling import Sample

_TOGETHER, _AT_ONCE = 64, 16  # positions
_MORE = 1.0 + 1e-5  # peaks are known in double precision, fields in single


def scales(
    live: LiveFields, sample: Sample, kept: Mapping[str, IntArray], moved: Mapping[str, float]
) -> dict[str, dict[str, Any]]:
    """Field -> smallest and largest value, and its unit.

    kept   cycle -> positions that count
    moved  cycle -> largest displacement at these, of `displacements`
    """
    most = largest_size(live, sample, kept)
    scale: dict[str, dict[str, Any]] = {
        "mises": {"from": 0.0, "to": max(sample.peaks.values(), default=0.0), "unit": "MPa"},
        "principal": {"from": -most, "to": most, "unit": "MPa"},  # 0 is in the middle
    }
    if any(moved.values()):
        scale["displacement"] = {"from": 0.0, "to": max(moved.values()), "unit": "mm"}
    return scale


def displacements(live: LiveFields, kept: Mapping[str, IntArray]) -> dict[str, float]:
    """Cycle -> largest displacement at some positions, mm; 0 where it is not known."""
    moved = dict.fromkeys(kept, 0.0)
    if live.displacement is None:
        return moved
    ways = np.ascontiguousarray(live.displacement.transpose(2, 0, 1))
    lost = lost_in_single(live.displacement, live.coefficients, LENGTH_METRIC)
    for name, positions in kept.items():
        weights = live.coefficients[name][:, positions]
        about = _lengths(ways, weights.astype(ways.dtype))
        close = about >= about.max(initial=0.0) - 4 * (len(weights) + 4) * lost[name]
        moved[name] = float(_lengths(ways.astype(np.float64), weights[:, close]).max())
    return moved


def _lengths(ways: RealArray, weights: RealArray) -> FloatArray:
    """Largest length over the nodes (K,) of sums of fields (3, M, n) times weights (M, K)."""
    found = [np.zeros(0)]
    for first in range(0, weights.shape[1], _TOGETHER):
        some = weights[:, first : first + _TOGETHER].T
        square = np.zeros((len(some), ways.shape[2]), dtype=ways.dtype)
        for way in ways:
            part = some @ way
            part *= part
            square += part
        found.append(np.sqrt(square.max(axis=1).astype(np.float64)))
    return np.concatenate(found)


def largest_size(live: LiveFields, sample: Sample, kept: Mapping[str, IntArray]) -> float:
    """Largest size of a principal stress at some positions, MPa.

    No principal stress exceeds the mean stress by more than 2/3 of the von Mises stress, and that
    one is not above its peak at the position: only nodes that this bound leaves are looked at.
    Pull and push are bounded together: one that stays far below the other is not searched for.
    """
    known = 0.0
    fields = live.stress
    means = (fields[..., 0] + fields[..., 1] + fields[..., 2]) / 3
    for name, positions in kept.items():
        weights = live.coefficients[name][:, positions]
        reach = 2 / 3 * _MORE * live.peaks[name][positions]
        reach += (len(fields) + 4) * sample.lost[name]  # sums in single precision, too
        most, least = np.zeros(len(positions)), np.zeros(len(positions))
        for first in range(0, len(positions), _TOGETHER):
            some = slice(first, first + _TOGETHER)
            block = weights[:, some].T.astype(means.dtype) @ means
            most[some], least[some] = block.max(axis=1), block.min(axis=1)
        ways = [(weights, most), (-weights, -least)]
        for signed, mean in sorted(ways, key=lambda way: -float((way[1] + reach).max(initial=0))):
            known = _highest(fields, means, signed, reach, mean, known)
    return known


def _highest(
    fields: RealArray,
    means: RealArray,
    weights: FloatArray,
    reach: FloatArray,
    most: FloatArray,
    known: float,
) -> float:
    """Largest principal stress over positions, or `known` if that is larger.

    means (M, n) of the fields; reach and most (K,): how far a principal stress is above the mean
    stress at a position at most, and the largest mean stress there.
    """
    order = np.argsort(-(most + reach), kind="stable")
    first, together = 0, 1  # what the most promising position holds leaves few nodes of the others
    while first < len(order) and (most + reach)[order[first]] > known:
        positions = order[first : first + together]
        drive = weights[:, positions].T
        bounds = drive.astype(means.dtype) @ means + reach[positions, None].astype(means.dtype)
        some = np.flatnonzero(bounds.max(axis=0) > known)
        stress = np.tensordot(drive, fields[:, some].astype(np.float64), axes=1)
        known = largest_principal(stress.reshape(-1, 6), known)
        first, together = first + together, _AT_ONCE
    return known
