"""Resolution of the notch in which a peak sits by the mesh.

The stress below a concave surface of radius rho falls off within a fraction of rho. Elements of
size h that are not small against it carry the peak too low, each of them alike, so that neither
their scatter nor a short step from one such mesh to the next tells. The missing part is of the
order (h / rho)^2; measured on fillets of 0.15 to 2 mm between bars under bending and tension it is
0.05 to 0.16 of the peak times that (tests/ballesta/test_small_fillets.py). Elements larger than the
radius see a sharp corner, whose stress grows towards it like 1 / sqrt(distance) at most (a crack).
"""

import numpy as np

from geometry.mesh import FloatArray, Mesh

_SHARE = 0.17  # of the peak times (h / rho)^2
_CORNER = 1.5  # h / rho from which on elements see a sharp corner
_SIDES = ((0, 1), (1, 2), (2, 0))
_CORNERS = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))


def concave_curvatures(mesh: Mesh) -> FloatArray:
    """Largest concave curvature (n_nodes,), 1/mm, of the surface of the elements at each node."""
    facets = mesh.facets
    corners = mesh.nodes[facets]
    normals = np.stack([facet_normals(corners, r, s) for r, s in _CORNERS], axis=1)
    largest = np.zeros(len(facets))
    for first, second in _SIDES:
        along = corners[:, second] - corners[:, first]
        turned = ((normals[:, second] - normals[:, first]) * along).sum(axis=1)
        # a chord c of a circle of curvature k: the normals' difference along it is k c
        largest = np.maximum(largest, -turned / (along**2).sum(axis=1))
    of_corners, found = np.zeros(len(mesh.nodes)), np.zeros(len(mesh.nodes))
    np.maximum.at(of_corners, facets[:, :3], largest[:, None])
    np.maximum.at(found, mesh.elements, of_corners[mesh.elements].max(axis=1)[:, None])
    return found


def notch_error(size: FloatArray, curvature: FloatArray) -> FloatArray:
    """Errors of stresses, as shares of them, on elements of sizes (mm) in notches (1/mm)."""
    ratio = np.asarray(size * curvature)
    beyond = np.sqrt(np.maximum(ratio / _CORNER, 1.0))
    return (1.0 + _SHARE * np.minimum(ratio, _CORNER) ** 2) * beyond - 1.0


def facet_normals(corners: FloatArray, r: float, s: float) -> FloatArray:
    """Return unit outward normals (n, 3) of six-node facets (n, 6, 3) at local coordinates."""
    t = 1 - r - s
    by_r = np.array([1 - 4 * t, 4 * r - 1, 0, 4 * (t - r), 4 * s, -4 * s])
    by_s = np.array([1 - 4 * t, 0, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)])
    normal = np.cross(np.einsum("a,nax->nx", by_r, corners), np.einsum("a,nax->nx", by_s, corners))
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))
