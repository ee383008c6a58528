"""Resolution of the notch in which a peak sits by the mesh.

The stress below a concave surface of radius rho falls off within a fraction of rho. Elements of
size h that are not small against it carry the peak too low, each of them alike, so that neither
their scatter nor a short step from one such mesh to the next tells. The missing part is of the
order (h / rho)^2; measured on fillets of 0.15 to 2 mm between bars under bending and tension it is
0.05 to 0.16 of the peak times that (tests/ballesta/test_small_fillets.py).
"""

import numpy as np

from geometry.mesh import FloatArray, Mesh

_SHARE = 0.17  # of the peak times (h / rho)^2
_SIDES = ((0, 1), (1, 2), (2, 0))
_CORNERS = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))


def concave_curvature(mesh: Mesh, node: int) -> float:
    """Largest concave curvature, 1/mm, of the surface of the elements that meet at a node."""
    near = np.unique(mesh.elements[(mesh.elements == node).any(axis=1)])
    facets = mesh.facets
    corners = mesh.nodes[facets[np.isin(facets[:, :3], near).any(axis=1)]]
    normals = np.stack([facet_normals(corners, r, s) for r, s in _CORNERS], axis=1)
    largest = 0.0
    for first, second in _SIDES:
        along = corners[:, second] - corners[:, first]
        turned = ((normals[:, second] - normals[:, first]) * along).sum(axis=1)
        # a chord c of a circle of curvature k: the normals' difference along it is k c
        largest = max(largest, float((-turned / (along**2).sum(axis=1)).max(initial=0.0)))
    return largest


def notch_error(size: float, curvature: float) -> float:
    """Error of a peak, as a share of it, on elements of a size (mm) in a notch (1/mm)."""
    return _SHARE * (size * curvature) ** 2


def facet_normals(corners: FloatArray, r: float, s: float) -> FloatArray:
    """Return unit outward normals (n, 3) of six-node facets (n, 6, 3) at local coordinates."""
    t = 1 - r - s
    by_r = np.array([1 - 4 * t, 4 * r - 1, 0, 4 * (t - r), 4 * s, -4 * s])
    by_s = np.array([1 - 4 * t, 0, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)])
    normal = np.cross(np.einsum("a,nax->nx", by_r, corners), np.einsum("a,nax->nx", by_s, corners))
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))
