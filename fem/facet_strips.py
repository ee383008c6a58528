"""Quadrature over a surface cut along lines x = constant, for loads that have kinks there.

Each facet is cut into triangles that lie between two neighbouring lines. A load that is smooth
between the lines is then integrated without an error on straight-sided facets, whatever the size
of the facets.
"""

from dataclasses import dataclass

import numpy as np

from geometry.mesh import FloatArray, IntArray, Mesh

_DEGREE = 6  # a linear load, linear along z, times quadratic shape functions, and two to spare


@dataclass(frozen=True, eq=False)
class FacetStrips:
    """Quadrature points of the cut triangles of one surface.

    nodes    (m, 6)       node indices of the facet that each triangle lies in
    shape    (m, n_q, 6)  the facet's shape functions at the points
    points   (m, n_q, 3)  mm
    weights  (m, n_q)     mm2
    """

    nodes: IntArray
    shape: FloatArray
    points: FloatArray
    weights: FloatArray

    def nodal_forces(self, traction: FloatArray, n_nodes: int) -> FloatArray:
        """Nodal forces (3 n_nodes,) of a traction (m, n_q, 3) at the points, MPa."""
        forces = np.zeros((n_nodes, 3))
        nodal = np.einsum("mqa,mqx,mq->max", self.shape, traction, self.weights, optimize=True)
        np.add.at(forces, self.nodes, nodal)
        return forces.ravel()


def cut_along_x(mesh: Mesh, surface: str, lines: FloatArray) -> FacetStrips:
    """Quadrature over a named surface, cut at the places x = `lines`, mm."""
    import skfem

    facets = mesh.surfaces[surface]
    corners = np.broadcast_to(np.eye(3), (len(facets), 3, 3))  # barycentric, (m, corner, 3)
    owner: IntArray = np.arange(len(facets), dtype=np.int64)
    across = mesh.nodes[facets[:, :3], 0]  # x of the facets' corners
    for line in lines:
        corners, owner = _cut(corners, owner, across - line)
    rule, weights = skfem.quadrature.get_quadrature(skfem.refdom.RefTri, _DEGREE)
    inside = np.stack([1 - rule.sum(axis=0), *rule], axis=1)  # (n_q, 3)
    places = np.matmul(inside, corners)  # (m, n_q, 3) barycentric in the facet
    share = np.abs(np.linalg.det(corners))  # of the facet's area
    nodes = facets[owner]
    at = mesh.nodes[nodes]
    t, r, s = np.moveaxis(places, -1, 0)
    shape = np.stack(
        [t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * r * t, 4 * r * s, 4 * s * t],
        axis=-1,
    )
    zero = np.zeros_like(r)
    by_r = np.stack([1 - 4 * t, 4 * r - 1, zero, 4 * (t - r), 4 * s, -4 * s], axis=-1)
    by_s = np.stack([1 - 4 * t, zero, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)], axis=-1)
    areas = np.linalg.norm(np.cross(by_r @ at, by_s @ at), axis=-1)
    return FacetStrips(nodes, shape, shape @ at, areas * weights * share[:, None])


def _cut(corners: FloatArray, owner: IntArray, level: FloatArray) -> tuple[FloatArray, IntArray]:
    """Cut triangles where a function that is linear in each facet is zero.

    level  (n_facets, 3) the function at the facets' corners
    """
    value = np.einsum("mca,ma->mc", corners, level[owner])
    value[np.abs(value) < 1e-9 * np.abs(level).max(axis=1)[owner][:, None]] = 0.0
    crossed = (value.min(axis=1) < 0) & (value.max(axis=1) > 0)
    kept, kept_owner = corners[~crossed], owner[~crossed]
    corners, owner, value = corners[crossed], owner[crossed], value[crossed]
    side = np.sign(value)
    side[side == 0] = 1.0
    alone = np.argmax(side * side.sum(axis=1, keepdims=True) < 0, axis=1)  # on a side by itself
    turn = (alone[:, None] + np.arange(3)) % 3
    corners = np.take_along_axis(corners, turn[:, :, None], axis=1)
    value = np.take_along_axis(value, turn, axis=1)
    first, second, third = np.moveaxis(corners, 1, 0)

    def crossing(k: int) -> FloatArray:
        along = (value[:, 0] / (value[:, 0] - value[:, k]))[:, None]
        return np.asarray(first + along * (corners[:, k] - first))

    left, right = crossing(1), crossing(2)
    parts = [(first, left, right), (left, second, third), (left, third, right)]
    return (
        np.concatenate([kept, *(np.stack(part, axis=1) for part in parts)]),
        np.concatenate([kept_owner, owner, owner, owner]),
    )
