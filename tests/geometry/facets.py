"""Areas and normals of six-node facets of a mesh."""

import numpy as np


def area(mesh, facets):
    """Area of six-node facets by the six-point rule of degree 4 (Dunavant 1985)."""
    a, b = 0.445948490915965, 0.091576213509771
    corners = np.array(
        [[a, a], [a, 1 - 2 * a], [1 - 2 * a, a], [b, b], [b, 1 - 2 * b], [1 - 2 * b, b]]
    )
    weights = np.repeat([0.223381589678011, 0.109951743655322], 3) / 2
    total = 0.0
    for (r, s), weight in zip(corners, weights, strict=True):
        t = 1 - r - s
        by_r = [1 - 4 * t, 4 * r - 1, 0, 4 * (t - r), 4 * s, -4 * s]
        by_s = [1 - 4 * t, 0, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)]
        first, second = (
            np.einsum("a,nax->nx", np.array(d), mesh.nodes[facets]) for d in (by_r, by_s)
        )
        total += weight * np.linalg.norm(np.cross(first, second), axis=1).sum()
    return total


def normals(mesh, facets):
    """Unit normals of six-node facets at their nodes, (n, 6, 3), by the curved geometry."""
    r, s = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]]).T
    t, zero = 1 - r - s, np.zeros(6)
    by_r = np.array([1 - 4 * t, 4 * r - 1, zero, 4 * (t - r), 4 * s, -4 * s])
    by_s = np.array([1 - 4 * t, zero, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)])
    along = [np.einsum("aq,nax->nqx", by, mesh.nodes[facets]) for by in (by_r, by_s)]
    found = np.cross(*along)
    return found / np.linalg.norm(found, axis=2, keepdims=True)
