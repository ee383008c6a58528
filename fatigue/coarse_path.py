"""Few positions of a stress path that answer for all of them, and how far the others lie off them.

A path of hundreds of positions is mostly straight pieces. Of the positions that are kept, chords
run from one to the next; each other position x has a place z on the chord beside it, which lies in
the convex hull of what is kept. With e = |x - z| in von Mises stress and g the difference of the
hydrostatic stresses, on the plane with normal n

    |tau(x) - tau(z)| <= e / sqrt(3),    |sigma_n(x) - sigma_n(z)| <= 2/3 e + g

as the largest shear of a deviator is at most its von Mises norm over sqrt(3), and its largest
principal stress at most 2/3 of it. The circle around the kept shear holds all tau(z), and sigma_n
and half its range are extreme at what is kept. So Findley's parameter of the whole path is at most

    F(kept) + e (1/sqrt(3) + 2/3 k) + k g

with the largest e and g of all positions, on every plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heappop, heappush
from math import sqrt

import numpy as np

from fatigue.stress_path import FloatArray, IntArray, deviatoric_basis

_MOST = 48  # positions kept
_CLOSE = 1e-3  # of the longest radius of the path: positions so near a chord need not be kept
_DIMENSIONS = 8  # of the path that is looked at for what to keep
_PRESSURE = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]) / 3.0


@dataclass(frozen=True, eq=False)
class CoarsePath:
    """Positions that are kept of the paths of some points, and what they miss.

    kept   (m,)        positions, ascending
    slack  (n_points,) MPa, by how much Findley's parameter may exceed the kept positions'
    """

    kept: IntArray
    slack: FloatArray


def coarse_path(basis: FloatArray, coefficients: FloatArray, k: float) -> CoarsePath:
    """Return positions that stand for all on every point; k is the weight of the normal stress.

    basis (n_points, 6, n_basis) and coefficients (n_basis, n_positions) as in `stress_path`.
    """
    vectors = np.concatenate([deviatoric_basis(basis), (_PRESSURE @ basis)[:, None]], axis=1)
    rows = vectors.reshape(-1, vectors.shape[2])
    values, turn = np.linalg.eigh(rows.T @ rows)
    main = slice(-min(_DIMENSIONS, len(values)), None)
    path = (turn[:, main] * np.sqrt(np.maximum(values[main], 0.0))).T @ coefficients
    kept, share = _chords(path)
    first = np.searchsorted(kept, np.arange(path.shape[1]), side="right") - 1
    last = np.minimum(first + 1, len(kept) - 1)
    ends = coefficients[:, kept]
    off = coefficients - (1.0 - share) * ends[:, first] - share * ends[:, last]
    off = np.delete(off, kept, axis=1)
    apart = (rows @ off).reshape(*vectors.shape[:2], -1)
    apart *= apart
    deviator = np.sqrt(apart[:, :5].sum(axis=1).max(axis=1, initial=0.0))
    pressure = np.sqrt(apart[:, 5].max(axis=1, initial=0.0))
    slack = deviator * (1.0 / sqrt(3.0) + 2.0 / 3.0 * k) + k * pressure
    return CoarsePath(kept, slack)


def _chords(path: FloatArray) -> tuple[IntArray, FloatArray]:
    """Positions to keep of a path (d, n), and each one's share (n,) of the chord beside it.

    The position farthest from its chord is kept next, until all are close.
    """
    n = path.shape[1]
    share = np.zeros(n)
    kept = [0, n - 1]
    middle = path.mean(axis=1, keepdims=True)
    close = _CLOSE**2 * float(((path - middle) ** 2).sum(axis=0).max())
    waiting: list[tuple[float, int, int, int]] = []

    def look(first: int, last: int) -> None:
        if last - first < 2:
            return
        start = path[:, first, None]
        chord, away = path[:, last, None] - start, path[:, first + 1 : last] - start
        length = float((chord * chord).sum())
        along = np.clip((chord * away).sum(axis=0) / length, 0.0, 1.0) if length else np.zeros(1)
        share[first + 1 : last] = along
        away = away - chord * along
        squared = (away * away).sum(axis=0)
        farthest = int(squared.argmax())
        heappush(waiting, (-float(squared[farthest]), first, first + 1 + farthest, last))

    look(0, n - 1)
    while waiting and len(kept) < _MOST:
        squared, first, farthest, last = heappop(waiting)
        if -squared <= close:
            break
        kept.append(farthest)
        share[farthest] = 0.0
        look(first, farthest)
        look(farthest, last)
    return np.unique(kept), share
