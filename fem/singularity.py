"""Sharp re-entrant edges: where linear elasticity has no finite stress.

At a re-entrant edge whose interior angle is omega > 180 degrees the stress grows towards the edge
like r^(lambda - 1), with lambda in (1/2, 1) the smallest root of sin(lambda omega) +
lambda sin(omega) = 0 (M. L. Williams, J. Appl. Mech. 19 (1952) 526, free faces, symmetric mode). A
finite-element peak there grows with every refinement and means nothing.
"""

from dataclasses import dataclass

import numpy as np

from fem.notch_resolution import facet_normals
from geometry.mesh import FloatArray, IntArray, Mesh

_SHARP = np.radians(12)  # a turn of the surface beyond what curved facets leave between them


@dataclass(frozen=True, eq=False)
class ReentrantEdges:
    """Sharp concave edges of a mesh.

    nodes   (n,)  node indices on them
    angles  (n,)  rad, interior angle there (the largest, where several meet)
    """

    nodes: IntArray
    angles: FloatArray


def reentrant_edges(mesh: Mesh) -> ReentrantEdges:
    """Find edges where two boundary facets meet at an interior angle above 192 degrees.

    The facets' normals are those of the curved facets at the edge's mid-side node. A parabola
    through three points of a circle does not meet it at the right angle; twice what the facets' own
    turn lets expect of that is not taken for an edge.
    """
    facets = mesh.facets
    edges = facets[:, [[0, 1, 3], [1, 2, 4], [2, 0, 5]]].reshape(-1, 3)
    corners = mesh.nodes[facets]
    normals = np.stack([facet_normals(corners, *_MIDDLES[side]) for side in range(3)], axis=1)
    far = np.stack([facet_normals(corners, *_OPPOSITE[side]) for side in range(3)], axis=1)
    slack = 2 * _parabola_error(_angle(normals, far)).reshape(-1)
    normals = normals.reshape(-1, 3)
    opposite = facets[:, [2, 0, 1]].reshape(-1)
    order = np.argsort(edges[:, 2], kind="stable")  # a mid-side node names its edge
    first, second = order[0::2], order[1::2]
    if not np.array_equal(edges[first, 2], edges[second, 2]):
        raise AssertionError("the boundary of the mesh is not closed")
    turn = _angle(normals[first], normals[second])
    inward = mesh.nodes[opposite[second]] - mesh.nodes[edges[second, 2]]
    concave = np.einsum("ex,ex->e", normals[first], inward) > 0
    sharp = concave & (turn > _SHARP + slack[first] + slack[second])
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
    from scipy.optimize import brentq

    if interior_angle <= np.pi * (1 + 1e-9):
        return 0.0
    root = brentq(
        lambda x: np.sin(x * interior_angle) + x * np.sin(interior_angle), 0.5 - 1e-12, 1 - 1e-9
    )
    return float(1 - root)


def _angle(first: FloatArray, second: FloatArray) -> FloatArray:
    """Angles (...) between unit vectors (..., 3), rad."""
    return np.asarray(np.arccos(np.clip((first * second).sum(axis=-1), -1, 1)))


def _parabola_error(turn: FloatArray) -> FloatArray:
    """Angle by which a parabola through the ends and the middle of an arc misses its end's slope.

    turn  rad, by which the arc turns; a chord c of it rises by c tan(turn/4)/2 at the middle
    """
    return np.asarray(turn / 2 - np.arctan(2 * np.tan(turn / 4)))


_MIDDLES = ((0.5, 0.0), (0.5, 0.5), (0.0, 0.5))  # of a facet's sides, in its local coordinates
_OPPOSITE = ((0.0, 1.0), (0.0, 0.0), (1.0, 0.0))  # the corner that a side does not have
