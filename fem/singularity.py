"""Sharp re-entrant edges: where linear elasticity has no finite stress.

At a re-entrant edge whose interior angle is omega > 180 degrees the stress grows towards the edge
like r^(lambda - 1), with lambda in (1/2, 1) the smallest root of sin(lambda omega) +
lambda sin(omega) = 0 (M. L. Williams, J. Appl. Mech. 19 (1952) 526, free faces, symmetric mode). A
finite-element peak there grows with every refinement and means nothing.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from geometry.mesh import FloatArray, IntArray, Mesh, boundary_facets

_SHARP = np.radians(35)  # a turn of the surface that no smooth, meshed fillet shows along one edge


@dataclass(frozen=True, eq=False)
class ReentrantEdges:
    """Sharp concave edges of a mesh.

    nodes   (n,)  node indices on them
    angles  (n,)  rad, interior angle there (the largest, where several meet)
    """

    nodes: IntArray
    angles: FloatArray


def reentrant_edges(mesh: Mesh) -> ReentrantEdges:
    """Find edges where two boundary facets meet at an interior angle well above 180 degrees.

    The facets' normals are those of the curved facets at the edge's mid-side node, so a fillet
    does not look sharp unless its elements are as large as itself.
    """
    facets = boundary_facets(mesh.elements)
    edges = facets[:, [[0, 1, 3], [1, 2, 4], [2, 0, 5]]].reshape(-1, 3)
    normals = np.stack([_normal_at_middle(mesh.nodes[facets], side) for side in range(3)], axis=1)
    normals = normals.reshape(-1, 3)
    opposite = facets[:, [2, 0, 1]].reshape(-1)
    order = np.argsort(edges[:, 2], kind="stable")  # a mid-side node names its edge
    first, second = order[0::2], order[1::2]
    if not np.array_equal(edges[first, 2], edges[second, 2]):
        raise AssertionError("the boundary of the mesh is not closed")
    turn = np.arccos(np.clip(np.einsum("ex,ex->e", normals[first], normals[second]), -1, 1))
    inward = mesh.nodes[opposite[second]] - mesh.nodes[edges[second, 2]]
    concave = np.einsum("ex,ex->e", normals[first], inward) > 0
    sharp = concave & (turn > _SHARP)
    nodes = edges[first[sharp]]
    found = np.unique(nodes)
    angles = np.zeros(len(mesh.nodes))
    np.maximum.at(angles, nodes, (np.pi + turn[sharp])[:, None])
    return ReentrantEdges(found, angles[found])


def singular_exponent(interior_angle: float) -> float:
    """How steeply stress grows towards the edge: stress ~ r^-exponent. 0 up to 180 degrees.

    >>> round(singular_exponent(3 * 3.141592653589793 / 2), 4)
    0.4555
    """
    if interior_angle <= np.pi * (1 + 1e-9):
        return 0.0
    root = brentq(
        lambda x: np.sin(x * interior_angle) + x * np.sin(interior_angle), 0.5 - 1e-12, 1 - 1e-9
    )
    return float(1 - root)


def _normal_at_middle(corners: FloatArray, side: int) -> FloatArray:
    """Return unit outward normals of six-node facets (n, 6, 3) at the middle of one side."""
    r, s = ((0.5, 0.0), (0.5, 0.5), (0.0, 0.5))[side]
    t = 1 - r - s
    by_r = np.array([1 - 4 * t, 4 * r - 1, 0, 4 * (t - r), 4 * s, -4 * s])
    by_s = np.array([1 - 4 * t, 0, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)])
    normal = np.cross(np.einsum("a,nax->nx", by_r, corners), np.einsum("a,nax->nx", by_s, corners))
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))
