"""Bounds of Findley's parameter of many paths at once: which of them reach no floor on any plane.

As the search for one path (fatigue/shear_planes.py): on a triangle of planes with longest edge e
the parameter is at most its largest corner + M e^2/4, and triangles that stay below the floor are
dropped, the others divided. Here all paths take their triangles from the same grids, one twice as
fine as the other, so that each step is a few products for all of them. A path that is above its
floor somewhere, or near it, is left to the search.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from heapq import heappop, heappush
from math import sqrt

import numpy as np

from fatigue.shear_planes import half_sphere, longest_edges, plane_rows
from fatigue.stress_path import FloatArray, IntArray, deviatoric_basis

_FIRST, _LAST = 2, 5  # divisions of the grids: edges of 18 and of 2.3 degrees
_MOST = 64  # triangles of a path that are divided: more are left to the search
_REACHED = 0.9  # of a bound at a normal: the parameter is seldom below, so it is above the floor
_NUMBERS = 1_500_000  # of resolved stresses at once


def plane_bounds(stress: FloatArray, k: float, floors: FloatArray) -> FloatArray:
    """Return a proven bound of Findley's parameter of each path on any plane, MPa.

    stress (n, 6, n_positions), floors (n,) MPa. Where no plane is shown to stay below the floor the
    bound is infinite. Compression earns no credit.
    """
    bounds = np.full(len(stress), np.inf)
    size = max(1, _NUMBERS // (3 * 93 * stress.shape[2]))
    for start in range(0, len(stress), size):
        some = slice(start, start + size)
        bounds[some] = _bounds(stress[some], k, floors[some])
    return bounds


def _bounds(stress: FloatArray, k: float, floors: FloatArray) -> FloatArray:
    swing, scale = _swings(stress, k)
    normals, cells, rows, edges = _grid(_FIRST)
    upper = _upper(rows[None], swing[:, None], stress[:, None], k)
    tops = upper[:, cells].max(axis=2) + scale[:, None] * edges**2
    hopeful = tops > floors[:, None]
    lost = (_REACHED * upper.max(axis=1) > floors) | (hopeful.sum(axis=1) > _MOST)
    hopeful[lost] = False
    bounds = np.where(hopeful, -np.inf, tops).max(axis=1)
    path, cell = np.nonzero(hopeful)
    for level in range(_FIRST + 1, _LAST + 1):
        if not len(path):
            break
        before = len(cells)
        normals, cells, rows, edges = _grid(level)
        path = np.tile(path, 4)
        cell = np.concatenate([cell + before * child for child in range(4)])
        asked, which = np.unique(
            path[:, None] * len(normals) + cells[cell], return_inverse=True
        )  # each normal once for each path
        of, normal = np.divmod(asked, len(normals))
        upper = _upper(rows[normal], swing[of], stress[of], k)
        tops = upper[which.reshape(-1, 3)].max(axis=1) + scale[path] * edges[cell] ** 2
        above = tops > floors[path]
        np.maximum.at(bounds, path[~above], tops[~above])
        lost[of[_REACHED * upper > floors[of]]] = True
        lost |= np.bincount(path[above], minlength=len(stress)) > _MOST
        above &= ~lost[path]
        path, cell = path[above], cell[above]
    lost[path] = True
    bounds[lost] = np.inf
    return np.asarray(bounds)


def _swings(stress: FloatArray, k: float) -> tuple[FloatArray, FloatArray]:
    """Paths about the middle of a long chord of each, and M/4 (n,), MPa."""
    every = np.arange(len(stress))
    path = deviatoric_basis(stress)
    first = ((path - path.mean(axis=2, keepdims=True)) ** 2).sum(axis=1).argmax(axis=1)
    start = path[every, :, first]
    other = ((path - start[:, :, None]) ** 2).sum(axis=1).argmax(axis=1)
    middle = (start + path[every, :, other]) / 2.0
    radius = np.sqrt(((path - middle[:, :, None]) ** 2).sum(axis=1).max(axis=1))
    largest = np.sqrt((path**2).sum(axis=1).max(axis=1))
    centre = (stress[every, :, first] + stress[every, :, other]) / 2.0
    return stress - centre[:, :, None], (radius + k * np.maximum(largest, radius)) / sqrt(3.0)


def _upper(rows: FloatArray, swing: FloatArray, stress: FloatArray, k: float) -> FloatArray:
    """Upper bounds of the parameter: the circle around the middle of a long chord."""
    along, across, normal = rows[..., 0, :], rows[..., 1, :], rows[..., 2, :]
    if rows.ndim == 4:  # the same planes for all paths
        shear = along[0] @ swing[:, 0]
        other = across[0] @ swing[:, 0]
        pressed = normal[0] @ stress[:, 0]
    else:
        both = rows[:, :2] @ swing
        shear, other = both[:, 0], both[:, 1]
        pressed = (normal[:, None] @ stress)[:, 0]
    shear *= shear
    other *= other
    shear += other
    largest = pressed.max(axis=-1)
    counted = np.maximum(largest, (largest - pressed.min(axis=-1)) / 2.0)
    return np.asarray(np.sqrt(shear.max(axis=-1)) + k * counted)


@cache
def _grid(level: int) -> tuple[FloatArray, IntArray, FloatArray, FloatArray]:
    """Normals, triangles, rows and edges; triangle i + j n of a grid is part j of the last one's.

    n are the triangles of the grid before; its own order is kept.
    """
    normals, cells = half_sphere(level)
    return normals, cells, plane_rows(normals), longest_edges(normals, cells)


# Few positions of a stress path that answer for all of them, and how far the others lie off them.
#
# A path of hundreds of positions is mostly straight pieces. Of the positions that are kept,
# chords run from one to the next; each other position x has a place z on the chord beside it,
# which lies in the convex hull of what is kept. With e = |x - z| in von Mises stress and g the
# difference of the hydrostatic stresses, on the plane with normal n
#
#     |tau(x) - tau(z)| <= e / sqrt(3),    |sigma_n(x) - sigma_n(z)| <= 2/3 e + g
#
# as the largest shear of a deviator is at most its von Mises norm over sqrt(3), and its largest
# principal stress at most 2/3 of it. The circle around the kept shear holds all tau(z), and
# sigma_n and half its range are extreme at what is kept. So Findley's parameter of the whole path
# is at most
#
#     F(kept) + e (1/sqrt(3) + 2/3 k) + k g
#
# with the largest e and g of all positions, on every plane.

_MOST_PATH = 48  # positions kept
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
    while waiting and len(kept) < _MOST_PATH:
        squared, first, farthest, last = heappop(waiting)
        if -squared <= close:
            break
        kept.append(farthest)
        share[farthest] = 0.0
        look(first, farthest)
        look(farthest, last)
    return np.unique(kept), share
