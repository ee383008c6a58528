"""Error bound of rounded fields, proven for every position from a look at a few.

The error of a sum is the sum of the fields' errors E times the weights w, and its size is a norm:
von Mises stress is one (the square root of a quadratic form). A norm of E w is convex in w, so
between two positions it does not exceed the larger of both, and over a cycle it does not exceed
its largest value at the corners of any polygon around the path of w. Corners are chosen on the path
itself; where the path leaves their polygon, by at most d, it adds no more than d |E|, with |E| at
a node the root of the sum of squares of the fields' errors there (Cauchy and Schwarz).
"""

import heapq
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from checks.result.live_fields import DEVIATOR, FloatArray, IntArray

# Rows whose squares sum up to that of the von Mises stress, and the mean stress.
STRESS_METRIC = np.vstack([DEVIATOR, [1 / 3, 1 / 3, 1 / 3, 0.0, 0.0, 0.0]])
LENGTH_METRIC = np.eye(3)
_TOGETHER = 24  # corners that are looked at together
_SINGLE = 2.0**-24


@dataclass(frozen=True, eq=False)
class Corners:
    """Points of some paths, and how far these are from the polygon through them.

    kept      per path the indices of the points
    points    (r, n_points) all of them
    distance  largest distance of a path from the straight line between its neighbours there
    """

    kept: Sequence[IntArray]
    points: FloatArray
    distance: float


@dataclass(frozen=True)
class Bound:
    """Proven bounds, in shares of each cycle's size.

    norm       of the von Mises stress, or the length of a displacement
    principal  of any principal stress; 0 of displacements
    """

    norm: float
    principal: float


def corners(
    paths: Sequence[FloatArray],
    most: int,
    tolerance: float = 0.0,
    wanted: Sequence[Sequence[int]] = (),
) -> Corners:
    """Choose points of paths (r, K) so that the straight lines between them stay near the paths.

    most       number of points that are chosen, at most; every path keeps its ends and `wanted`
    tolerance  distance from which on no more are needed
    wanted     per path indices that must be among them

    Points between are taken from the line in proportion to their indices, as the page does it.
    """
    kept = [
        sorted({0, path.shape[1] - 1, *(wanted[number] if wanted else ())})
        for number, path in enumerate(paths)
    ]
    segments: list[tuple[float, int, int, int, int]] = []

    def look(number: int, first: int, last: int) -> None:
        if last - first < 2:
            return
        ends = paths[number][:, [first, last]]
        share = np.arange(1, last - first) / (last - first)
        line = ends[:, :1] + (ends[:, 1:] - ends[:, :1]) * share
        away = np.sqrt(((paths[number][:, first + 1 : last] - line) ** 2).sum(axis=0))
        farthest = int(away.argmax())
        entry = (-float(away[farthest]), number, first, first + 1 + farthest, last)
        heapq.heappush(segments, entry)

    for number, indices in enumerate(kept):
        for first, last in pairwise(indices):
            look(number, first, last)
    count = sum(len(indices) for indices in kept)
    while segments and count < most and -segments[0][0] > tolerance:
        _, number, first, middle, last = heapq.heappop(segments)
        kept[number].append(middle)
        look(number, first, middle)
        look(number, middle, last)
        count += 1
    chosen = [np.array(sorted(indices), dtype=np.int64) for indices in kept]
    points = [path[:, indices] for path, indices in zip(paths, chosen, strict=True)]
    distance = -segments[0][0] if segments else 0.0
    return Corners(chosen, np.concatenate(points, axis=1), distance)


def error_bound(errors: FloatArray, around: Corners, metric: FloatArray) -> Bound:
    """Bounds of a sum of fields' errors (r, n, c) over paths of weights.

    metric  STRESS_METRIC, or LENGTH_METRIC
    """
    if not errors.size:
        return Bound(0.0, 0.0)
    stress = metric.shape == STRESS_METRIC.shape
    rank, n, _ = errors.shape
    measured = np.einsum("kc,jnc->knj", metric, errors, optimize=True)
    squares = (measured**2).sum(axis=2)
    apart = around.distance * np.sqrt(squares[:5].sum(axis=0))  # (n,), of the norm
    mean_apart = around.distance * np.sqrt(squares[5]) if stress else np.zeros(n)
    norm, principal = 0.0, 0.0
    rows = measured.reshape(-1, rank).astype(np.float32)
    points = around.points.astype(np.float32)
    for first in range(0, points.shape[1], _TOGETHER):
        sums = (rows @ points[:, first : first + _TOGETHER]).reshape(len(metric), n, -1)
        mean = np.abs(sums[5]).max(axis=1) if stress else np.zeros(n)
        sums = sums[:5]
        sums *= sums
        sizes = np.sqrt(sums.sum(axis=0).max(axis=1)) + apart
        norm = max(norm, float(sizes.max()))
        if stress:
            # no principal value of a deviator exceeds 2/3 of its von Mises stress
            principal = max(principal, float((2 / 3 * sizes + mean + mean_apart).max()))
    # a sum of r products in single precision is off by at most (r + 2) units of their sizes
    lost = 4 * (rank + 2) * _SINGLE * float(np.sqrt(squares.sum(axis=0).max()))
    lost *= float(np.sqrt((around.points**2).sum(axis=0).max()))
    return Bound(norm + lost, principal + 2 * lost if stress else 0.0)


def largest_sizes(fields: FloatArray, metric: FloatArray) -> tuple[Bound, float]:
    """Bounds of sums of fields (r, n, c) whose weights are no longer than 1.

    And the same of the plain length of the c numbers.
    """
    squares = np.stack([((fields @ row) ** 2).sum(axis=0) for row in metric])
    norms = np.sqrt(squares[:5].sum(axis=0))
    principal = 0.0
    if metric.shape == STRESS_METRIC.shape:
        principal = float((2 / 3 * norms + np.sqrt(squares[5])).max(initial=0.0))
    plain = float(np.sqrt((fields**2).sum(axis=(0, 2)).max(initial=0.0)))
    return Bound(float(norms.max(initial=0.0)), principal), plain


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
