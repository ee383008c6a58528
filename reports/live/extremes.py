"""Largest sums of fields times weights over all nodes: peaks, ends of scales, errors."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from checks.result.live_fields import LiveFields, largest_principal
from fem.stress_history import DEVIATOR
from geometry.mesh import FloatArray

# Rows whose squares sum up to that of the von Mises stress, and the mean stress.
STRESS_METRIC = np.vstack([DEVIATOR, [1 / 3, 1 / 3, 1 / 3, 0.0, 0.0, 0.0]])
LENGTH_METRIC = np.eye(3)
_NUMBER = np.eye(1)
_TOGETHER = 200_000  # nodes times positions, so that their sums stay near the processor
_BLOCK = 32  # positions whose sums are bounded together
_TOP = 64  # nodes of the highest bounds, which tell what others must reach
_SINGLE = 2.0**-24
_MORE = 1.0 + 1e-5  # peaks are known in double precision, fields in single


def largest_sizes(fields: FloatArray, weights: FloatArray, metric: FloatArray) -> FloatArray:
    """Largest sizes (2, K) of sums of fields (r, n, c) times weights (r, K), over the nodes.

    metric  STRESS_METRIC, or LENGTH_METRIC

    Row 0 is the von Mises stress, or the length of a displacement; row 1 a bound of any principal
    stress: no principal value of a deviator exceeds 2/3 of its von Mises stress. Both are norms of
    the sum, hence convex in the weights: between two positions they do not exceed the larger of
    both. Sums are in single precision. One field is only scaled.
    """
    if len(fields) == 1 < weights.shape[1]:
        return np.asarray(largest_sizes(fields, np.ones((1, 1)), metric) * np.abs(weights))
    return _largest(_rows(fields, metric), np.ascontiguousarray(weights, dtype=np.float32))


def largest_anywhere(fields: FloatArray, weights: FloatArray, metric: FloatArray) -> FloatArray:
    """Largest (2,) of `largest_sizes` over all positions.

    In a block of positions a node reaches at most the sizes of its fields times their largest
    weights there. Only nodes that may reach more than is known are asked for their sums, those of
    the highest bounds first.
    """
    if not fields.size or not weights.size:
        return np.zeros(2)
    rows = _rows(fields, metric)
    shares = np.ascontiguousarray(weights, dtype=np.float32)
    reached = [np.sqrt(_squared(rows.copy()))]  # (n, r)
    if metric is STRESS_METRIC:
        reached.append(2 / 3 * reached[0] + np.abs(rows[:, 5]))
    starts = np.arange(0, shares.shape[1], _BLOCK)
    most = np.maximum.reduceat(np.abs(shares), starts, axis=1)  # (r, blocks)
    bounds = np.stack([one @ most for one in reached])  # (1 or 2, n, blocks)
    bounds *= 1 + 4 * len(fields) * _SINGLE
    known = np.zeros((2, 1))
    for block in np.argsort(-bounds[0].max(axis=0), kind="stable"):
        own = shares[:, starts[block] : starts[block] + _BLOCK]
        top = np.argpartition(bounds[0, :, block], -min(_TOP, len(rows)))[-_TOP:]
        known = np.maximum(known, _largest(rows[top], own).max(axis=1, keepdims=True))
        left = (bounds[:, :, block] > known[: len(bounds)]).any(axis=0)
        known = np.maximum(known, _largest(rows[left], own).max(axis=1, keepdims=True))
    return known[:, 0]


def _rows(fields: FloatArray, metric: FloatArray) -> npt.NDArray[np.float32]:
    """Rows (n, m, r) of a metric (m, c) for fields (r, n, c), in single precision."""
    return np.ascontiguousarray((fields @ metric.T).transpose(1, 2, 0), dtype=np.float32)


def _squared(sums: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Squares (n, k) of the sizes of sums (n, m, k): of the first five of m, in place."""
    squares = np.square(sums[:, :5], out=sums[:, :5])
    return np.asarray(squares.sum(axis=1))


def _largest(rows: npt.NDArray[np.float32], weights: npt.NDArray[np.float32]) -> FloatArray:
    """`largest_sizes` (2, K) of sums of rows (n, m, r) times weights (r, K)."""
    count, m, r = rows.shape
    found = np.zeros((2, weights.shape[1]))
    size = max(1, _TOGETHER // max(1, weights.shape[1]))
    for first in range(0, count if r else 0, size):
        some = rows[first : first + size]
        sums = (some.reshape(-1, r) @ weights).reshape(len(some), m, -1)
        sizes = np.sqrt(_squared(sums))
        np.maximum(found[0], sizes.max(axis=0), out=found[0])
        if m > 5:
            both = 2 / 3 * sizes + np.abs(sums[:, 5])
            np.maximum(found[1], both.max(axis=0), out=found[1])
    return found


def largest_by_cycle(
    fields: FloatArray, weights: Mapping[str, FloatArray], metric: FloatArray
) -> dict[str, FloatArray]:
    """`largest_sizes` for the weights (r, K) of each cycle."""
    ends = np.cumsum([own.shape[1] for own in weights.values()])[:-1]
    found = largest_sizes(fields, np.hstack([*weights.values()]), metric)
    return dict(zip(weights, np.split(found, ends, axis=1), strict=True))


def lost_in_single(
    fields: npt.NDArray[Any], coefficients: Mapping[str, FloatArray], metric: FloatArray
) -> dict[str, float]:
    """Cycle -> largest error of a sum at any node by single precision of unit fields (M, n, c).

    In the unit of the sum; of its norm, and of any principal stress. It is much where unit loads
    nearly cancel each other: their sizes count, not the size of their sum.
    """
    # v' G v is at most the sum of v_i^2 times the sizes in row i of G
    rows = np.abs(metric.T @ metric).sum(axis=1)
    sizes = np.array([np.sqrt((field.astype(np.float64) ** 2 @ rows).max()) for field in fields])
    return {
        name: _SINGLE * float((sizes @ np.abs(c)).max(initial=0.0))
        for name, c in coefficients.items()
    }


def largest_principal_stress(live: LiveFields, lost: Mapping[str, float]) -> float:
    """Largest size of a principal stress at any node and position, MPa.

    lost  cycle -> what single precision of the unit fields may cost, MPa

    No principal stress exceeds the mean stress by more than 2/3 of the von Mises stress, and that
    one is not above its peak at the position: only nodes that this bound leaves are looked at, the
    most promising position first.
    """
    means = live.stress[..., :3].astype(np.float64).mean(axis=2)
    order = []
    for name, (sizes, _) in largest_by_cycle(means[..., None], live.coefficients, _NUMBER).items():
        reach = 2 / 3 * _MORE * live.peaks[name] + (live.n_fields + 4) * lost[name]
        about = reach + sizes * _MORE
        order += [(-most, name, k) for k, most in enumerate(about.tolist())]
    known = 0.0
    for most, name, k in sorted(order):
        if -most <= known:
            break
        weights = live.coefficients[name][:, k]
        reach = 2 / 3 * _MORE * live.peaks[name][k] + (live.n_fields + 4) * lost[name]
        some = np.flatnonzero(np.abs(weights @ means) + reach > known)
        stress = np.tensordot(weights, live.stress[:, some].astype(np.float64), axes=1)
        known = largest_principal(stress, known)
    return known
