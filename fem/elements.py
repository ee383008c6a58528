"""Second-order tetrahedra: scikit-fem's mapping and quadrature, in the mesh's own node numbers."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import skfem

from geometry.mesh import FloatArray, IntArray, Mesh


@dataclass(frozen=True, eq=False)
class FacetQuadrature:
    """Quadrature over one named surface of six-node facets.

    shape    (6, n_q)           shape functions of a facet's nodes
    nodes    (n_facets, 6)      node indices
    points   (n_facets, n_q, 3) mm
    weights  (n_facets, n_q)    mm2
    """

    shape: FloatArray
    nodes: IntArray
    points: FloatArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class Elements:
    """A mesh seen by scikit-fem, with shape-function gradients at four points per element.

    Four points integrate the stiffness of a straight-sided quadratic tetrahedron exactly; it is
    the rule of CalculiX's C3D10 too.
    """

    mesh: Mesh

    @cached_property
    def _skfem_mesh(self) -> Any:
        corners, elements = np.unique(self.mesh.elements[:, :4], return_inverse=True)
        elements = elements.reshape(-1, 4)
        straight = skfem.MeshTet1(
            np.ascontiguousarray(self.mesh.nodes[corners].T), np.ascontiguousarray(elements.T)
        )
        if not np.array_equal(straight.t, elements.T):  # local node order is ours to keep
            raise AssertionError("scikit-fem reordered the corners of the elements")
        quadratic = skfem.MeshTet2.from_mesh(straight)
        dofs = skfem.CellBasis(quadratic, skfem.ElementTetP2(), intorder=0).element_dofs
        locations = quadratic.doflocs.copy()
        locations[:, dofs] = np.moveaxis(self.mesh.nodes[self.mesh.elements], (0, 1, 2), (2, 1, 0))
        return skfem.MeshTet2(locations, quadratic.t)

    @cached_property
    def _basis(self) -> Any:
        basis = skfem.CellBasis(self._skfem_mesh, skfem.ElementTetP2(), intorder=2)
        if basis.X.shape[1] != 4:
            raise AssertionError("the four-point rule is expected")
        return basis

    @cached_property
    def gradients(self) -> FloatArray:
        """(n_elements, n_q, 10, 3), 1/mm."""
        stacked = np.stack([field[0].grad for field in self._basis.basis])  # (10, 3, e, q)
        return np.ascontiguousarray(np.moveaxis(stacked, (2, 3, 0, 1), (0, 1, 2, 3)))

    @cached_property
    def values(self) -> FloatArray:
        """Shape functions at the quadrature points, (n_q, 10)."""
        return np.stack([np.asarray(field[0])[0] for field in self._basis.basis], axis=1)

    @cached_property
    def weights(self) -> FloatArray:
        """(n_elements, n_q), mm3."""
        return np.ascontiguousarray(self._basis.dx)

    @cached_property
    def points(self) -> FloatArray:
        """Quadrature points, (n_elements, n_q, 3), mm."""
        nodes = self.mesh.nodes[self.mesh.elements]
        return np.asarray(np.einsum("qa,eax->eqx", self.values, nodes))

    @property
    def local_points(self) -> FloatArray:
        """Quadrature points in the reference tetrahedron, (n_q, 3)."""
        return np.asarray(self._basis.X.T)

    @cached_property
    def _surfaces(self) -> dict[tuple[str, int], FacetQuadrature]:
        return {}

    def surface(self, name: str, *, degree: int = 8) -> FacetQuadrature:
        """Quadrature over a named surface of the mesh."""
        if (name, degree) not in self._surfaces:
            self._surfaces[name, degree] = self._surface(name, degree)
        return self._surfaces[name, degree]

    def _surface(self, name: str, degree: int) -> FacetQuadrature:
        rule, weights = skfem.quadrature.get_quadrature(skfem.refdom.RefTri, degree)
        facets = self.mesh.surfaces[name]
        corners = self.mesh.nodes[facets]  # (f, 6, 3)
        r, s = rule
        t = 1 - r - s
        shape = np.stack(
            [t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * r * t, 4 * r * s, 4 * s * t]
        )
        zero = np.zeros_like(r)
        by_r = np.stack([1 - 4 * t, 4 * r - 1, zero, 4 * (t - r), 4 * s, -4 * s])
        by_s = np.stack([1 - 4 * t, zero, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)])
        tangents = (np.einsum("aq,fax->fqx", slope, corners) for slope in (by_r, by_s))
        areas = np.linalg.norm(np.cross(*tangents), axis=-1)
        return FacetQuadrature(
            shape=shape,
            nodes=facets,
            points=np.einsum("aq,fax->fqx", shape, corners),
            weights=areas * weights,
        )
