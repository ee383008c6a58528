"""Second-order tetrahedra: scikit-fem's mapping and quadrature, in the mesh's own node numbers."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import skfem

from geometry.mesh import FloatArray, IntArray, Mesh


@dataclass(frozen=True, eq=False)
class FacetQuadrature:
    """Quadrature over one named surface.

    shape    (6 or 10, n_facets, n_q)  shape functions of `nodes`
    nodes    (n_facets, 10)            nodes of the element behind each facet
    points   (n_facets, n_q, 3)        mm
    weights  (n_facets, n_q)           mm2
    normals  (n_facets, n_q, 3)        outward
    """

    shape: FloatArray
    nodes: IntArray
    points: FloatArray
    weights: FloatArray
    normals: FloatArray


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
        mesh = self._skfem_mesh
        corners = np.unique(self.mesh.elements[:, :4])
        index = np.full(len(self.mesh.nodes), -1)
        index[corners] = np.arange(len(corners))
        wanted = np.sort(index[self.mesh.surfaces[name][:, :3]], axis=1)
        key = np.array([len(corners) ** 2, len(corners), 1])
        known = key @ np.sort(mesh.facets, axis=0)
        order = np.argsort(known)
        place = np.searchsorted(known[order], wanted @ key)
        facets = order[np.minimum(place, len(order) - 1)]
        if not np.array_equal(known[facets], wanted @ key):
            raise AssertionError(f"surface {name!r} has a facet that no element has")
        basis = skfem.FacetBasis(mesh, skfem.ElementTetP2(), facets=facets, intorder=degree)
        return FacetQuadrature(
            shape=np.stack([np.asarray(field[0]) for field in basis.basis]),
            nodes=self.mesh.elements[mesh.f2t[0, facets]],
            points=np.moveaxis(np.asarray(basis.global_coordinates()), 0, -1),
            weights=np.asarray(basis.dx),
            normals=np.moveaxis(np.asarray(basis.normals), 0, -1),
        )
