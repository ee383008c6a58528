"""Triangles over all directions of planes, and their division in four.

A plane is known by its normal n; n and -n are the same plane, so half of a sphere is enough: of
each pair of opposite triangles of an icosahedron one is kept.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from fatigue.stress_path import FloatArray, IntArray

_GOLDEN = (1.0 + 5.0**0.5) / 2.0
_FOUR = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])  # of corners a, b, c, ab, bc, ca


def divided(n_normals: int, cells: IntArray) -> tuple[IntArray, IntArray]:
    """Return the edges whose middles become new normals, and four cells for each cell.

    cells (n_cells, 3) are indices of normals. The middle of edges[i] (n_edges, 2) gets the index
    n_normals + i; an edge that two cells share has one middle.
    """
    sides = np.sort(cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    # one number per edge, in the order of its ends: NumPy sorts rows ten times as slowly
    number, which = np.unique(sides[:, 0] * n_normals + sides[:, 1], return_inverse=True)
    edges = np.array(np.divmod(number, n_normals)).T
    middle = n_normals + which.reshape(-1, 3)
    corners = np.concatenate([cells, middle], axis=1)
    return edges, np.concatenate([corners[:, four] for four in _FOUR])


def middles(normals: FloatArray, edges: IntArray) -> FloatArray:
    """Return the unit vectors in the middle of each edge, (n_edges, 3)."""
    between = normals[edges].sum(axis=1)
    return np.asarray(between / np.sqrt((between * between).sum(axis=1, keepdims=True)))


def longest_edges(normals: FloatArray, cells: IntArray) -> FloatArray:
    """Return the length, rad, of each cell's longest edge, (n_cells,)."""
    corners = normals[cells]
    sides = corners - corners[:, [1, 2, 0]]
    chord = np.sqrt((sides * sides).sum(axis=2)).max(axis=1)
    return np.asarray(2.0 * np.arcsin(np.minimum(chord / 2.0, 1.0)))


@cache
def half_sphere(n_divisions: int) -> tuple[FloatArray, IntArray]:
    """Return normals (n, 3) and cells (n_cells, 3) that cover every plane.

    10 * 4**n_divisions cells; their edges are 63.4 degrees long, halved (within 17 %) by each
    division. Do not write into the arrays: they are kept.
    """
    zero, one, gold = np.zeros(4), np.array([1, 1, -1, -1.0]), np.array([1, -1, 1, -1.0]) * _GOLDEN
    normals = np.concatenate(
        [np.roll(np.stack([zero, one, gold], axis=1), turn, axis=1) for turn in range(3)]
    )
    normals /= np.linalg.norm(normals[0])
    near = normals @ normals.T > 0.4  # neighbours: cos 63.4 deg = 0.447; the next: -0.447
    cells = np.array(
        [
            (i, j, k)
            for i in range(12)
            for j in range(i + 1, 12)
            for k in range(j + 1, 12)
            if near[i, j] and near[j, k] and near[i, k]
        ]
    )
    side = normals[cells].sum(axis=1) @ np.array([1.0, 0.1, 0.01])  # no triangle's middle is at 0
    cells = cells[side > 0.0]
    for _ in range(n_divisions):
        edges, cells = divided(len(normals), cells)
        normals = np.concatenate([normals, middles(normals, edges)])
    used, renamed = np.unique(cells, return_inverse=True)
    return normals[used], renamed.reshape(cells.shape)
