"""Bounds of Findley's parameter of many paths at once: which of them reach no floor on any plane.

As the search for one path (fatigue/shear_planes.py): on a triangle of planes with longest edge e
the parameter is at most its largest corner + M e^2/4, and triangles that stay below the floor are
dropped, the others divided. Here all paths take their triangles from the same grids, one twice as
fine as the other, so that each step is a few products for all of them. A path that is above its
floor somewhere, or near it, is left to the search.
"""

from __future__ import annotations

from functools import cache
from math import sqrt

import numpy as np

from fatigue.plane_grid import half_sphere, longest_edges
from fatigue.shear_planes import plane_rows
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
