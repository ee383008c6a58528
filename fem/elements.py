"""Second-order tetrahedra: scikit-fem's shape functions and quadrature on a mesh's own arrays."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

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
    """A mesh with its shape-function gradients at four points per element.

    Four points integrate the stiffness of a straight-sided quadratic tetrahedron exactly; it is
    the rule of CalculiX's C3D10 too.
    """

    mesh: Mesh

    @cached_property
    def _rule(self) -> tuple[FloatArray, FloatArray]:
        import skfem

        points, weights = skfem.quadrature.get_quadrature(skfem.refdom.RefTet, 2)
        if points.shape != (3, 4):
            raise AssertionError("the four-point rule is expected")
        return points, weights

    @cached_property
    def _shape(self) -> tuple[FloatArray, FloatArray]:
        """Shape functions (n_q, 10) and their slopes (n_q, 10, 3) in the reference element."""
        import skfem

        element = skfem.ElementTetP2()  # numbers its nodes as the mesh does
        both = [element.lbasis(self._rule[0], node) for node in range(10)]
        values = np.stack([value for value, _ in both], axis=1)
        return values, np.ascontiguousarray(np.stack([slope.T for _, slope in both], axis=1))

    @cached_property
    def _mapping(self) -> tuple[FloatArray, FloatArray]:
        """Inverse Jacobian matrices (n_elements, n_q, 3, 3), dr_k/dx_i at [k, i], and det J."""
        slopes = self._shape[1]
        n_elements, n_q = len(self.mesh.elements), len(slopes)
        sides = slopes.transpose(1, 0, 2).reshape(10, -1)  # (10, n_q 3)
        corners = self.mesh.nodes[self.mesh.elements].transpose(0, 2, 1)
        jacobian = corners.reshape(-1, 10) @ sides
        # [i][k] is dx_i/dr_k, (n_elements, n_q)
        j = jacobian.reshape(n_elements, 3, n_q, 3).transpose(1, 3, 0, 2)
        inverse = np.empty((n_elements, n_q, 3, 3))
        for k in range(3):
            for i in range(3):
                (p, q), (r, s) = ((i + 1) % 3, (i + 2) % 3), ((k + 1) % 3, (k + 2) % 3)
                inverse[:, :, k, i] = j[p, r] * j[q, s] - j[p, s] * j[q, r]
        determinant = np.einsum("keq,eqk->eq", j[0], inverse[:, :, :, 0])
        inverse /= determinant[:, :, None, None]
        return inverse, np.ascontiguousarray(determinant)

    @cached_property
    def gradients(self) -> FloatArray:
        """(n_elements, n_q, 10, 3), 1/mm."""
        return np.asarray(np.matmul(self._shape[1], self._mapping[0]))

    @property
    def values(self) -> FloatArray:
        """Shape functions at the quadrature points, (n_q, 10)."""
        return self._shape[0]

    @cached_property
    def weights(self) -> FloatArray:
        """(n_elements, n_q), mm3."""
        return np.asarray(np.abs(self._mapping[1]) * self._rule[1])

    @cached_property
    def points(self) -> FloatArray:
        """Quadrature points, (n_elements, n_q, 3), mm."""
        nodes = self.mesh.nodes[self.mesh.elements]
        return np.asarray(np.einsum("qa,eax->eqx", self.values, nodes))

    @property
    def local_points(self) -> FloatArray:
        """Quadrature points in the reference tetrahedron, (n_q, 3)."""
        return np.asarray(self._rule[0].T)

    @cached_property
    def _surfaces(self) -> dict[tuple[str, int], FacetQuadrature]:
        return {}

    def surface(self, name: str, *, degree: int = 8) -> FacetQuadrature:
        """Quadrature over a named surface of the mesh."""
        if (name, degree) not in self._surfaces:
            self._surfaces[name, degree] = self._surface(name, degree)
        return self._surfaces[name, degree]

    def _surface(self, name: str, degree: int) -> FacetQuadrature:
        import skfem

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
