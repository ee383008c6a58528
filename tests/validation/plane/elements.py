"""Six-node triangles: scikit-fem's mapping and quadrature, in the mesh's own node numbers."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geometry.mesh import FloatArray, IntArray

from .mesh import PlaneMesh

_EDGE_DEGREE = 8  # a traction that varies like r^3 or a cosine along an edge keeps its resultant


@dataclass(frozen=True, eq=False)
class EdgeQuadrature:
    """Quadrature over one named edge.

    shape    (3, n_q)           shape functions of a piece's nodes
    nodes    (n_pieces, 3)      node indices
    points   (n_pieces, n_q, 2) mm
    normals  (n_pieces, n_q, 2) outward, of length 1
    weights  (n_pieces, n_q)    mm
    """

    shape: FloatArray
    nodes: IntArray
    points: FloatArray
    normals: FloatArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class PlaneElements:
    """A plane mesh seen by scikit-fem, with shape-function gradients at three points per element.

    Three points integrate the stiffness of a straight-sided quadratic triangle exactly.
    """

    mesh: PlaneMesh

    @cached_property
    def _basis(self) -> Any:
        import skfem

        corners, elements = np.unique(self.mesh.elements[:, :3], return_inverse=True)
        straight = skfem.MeshTri1(
            np.ascontiguousarray(self.mesh.nodes[corners].T),
            np.ascontiguousarray(elements.reshape(-1, 3).T),
            sort_t=False,  # the local node order is ours to keep
        )
        quadratic = skfem.MeshTri2.from_mesh(straight)
        dofs = skfem.CellBasis(quadratic, skfem.ElementTriP2(), intorder=0).element_dofs
        locations = quadratic.doflocs.copy()
        locations[:, dofs] = np.moveaxis(self.mesh.nodes[self.mesh.elements], (0, 1, 2), (2, 1, 0))
        curved = skfem.MeshTri2(locations, quadratic.t, sort_t=False)
        basis = skfem.CellBasis(curved, skfem.ElementTriP2(), intorder=2)
        if basis.X.shape[1] != 3:
            raise AssertionError("the three-point rule is expected")
        return basis

    @cached_property
    def gradients(self) -> FloatArray:
        """(n_elements, n_q, 6, 2), 1/mm."""
        stacked = np.stack([field[0].grad for field in self._basis.basis])  # (6, 2, e, q)
        return np.ascontiguousarray(np.moveaxis(stacked, (2, 3, 0, 1), (0, 1, 2, 3)))

    @cached_property
    def values(self) -> FloatArray:
        """Shape functions at the quadrature points, (n_q, 6)."""
        return np.stack([np.asarray(field[0])[0] for field in self._basis.basis], axis=1)

    @cached_property
    def areas(self) -> FloatArray:
        """Weights of the quadrature points in the plane, (n_elements, n_q), mm2."""
        return np.ascontiguousarray(self._basis.dx)

    @cached_property
    def points(self) -> FloatArray:
        """Quadrature points, (n_elements, n_q, 2), mm."""
        nodes = self.mesh.nodes[self.mesh.elements]
        return np.asarray(np.einsum("qa,eax->eqx", self.values, nodes))

    @cached_property
    def continuation(self) -> FloatArray:
        """(6, n_q): linear continuation from the quadrature points to the element's nodes."""
        local = self._basis.X.T
        middle = [[0.5, 0], [0.5, 0.5], [0, 0.5]]
        nodes = np.vstack([[[0, 0], [1, 0], [0, 1]], middle])
        design = np.column_stack([np.ones(len(local)), local])
        return np.asarray(np.column_stack([np.ones(6), nodes]) @ np.linalg.inv(design))

    def edge(self, name: str) -> EdgeQuadrature:
        """Quadrature over a named edge of the mesh; raises MeshError for an unknown name."""
        import skfem

        self.mesh.edge_nodes(name)
        pieces = self.mesh.edges[name]
        (s,), weights = skfem.quadrature.get_quadrature(skfem.refdom.RefLine, _EDGE_DEGREE)
        shape = np.stack([(1 - s) * (1 - 2 * s), s * (2 * s - 1), 4 * s * (1 - s)])
        slope = np.stack([4 * s - 3, 4 * s - 1, 4 - 8 * s])
        corners = self.mesh.nodes[pieces]
        tangents = np.einsum("aq,kax->kqx", slope, corners)
        lengths = np.linalg.norm(tangents, axis=-1)
        # The domain is on the left: outward is the tangent turned by -90 degrees.
        outward = np.stack([tangents[..., 1], -tangents[..., 0]], axis=-1)
        return EdgeQuadrature(
            shape=shape,
            nodes=pieces,
            points=np.einsum("aq,kax->kqx", shape, corners),
            normals=outward / lengths[..., None],
            weights=lengths * weights,
        )
