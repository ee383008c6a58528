"""Saint-Venant torsion of a section: its torsion constant, warping and shear stress.

A section that turns by theta per length and warps by theta w(x, y) is sheared by
G theta (dw/dx - y, dw/dy + x). Equilibrium on a surface free of load makes w the minimum of
integral |grad w + (-y, x)|^2, and that minimum is the torsion constant J = T / (G theta)
(Timoshenko and Goodier, Theory of Elasticity, 3rd ed., articles 104 and 105). So the J of a mesh
is never below that of the meshed section. Holes need nothing special.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fem.solvers import factorize
from geometry.mesh import FloatArray

from .elements import PlaneElements
from .mesh import PlaneMesh
from .recovery import nodal_average


@dataclass(frozen=True, eq=False)
class SectionTorsion:
    """Torsion of one section, free to warp; its stiffness and its stress need no material."""

    mesh: PlaneMesh

    @cached_property
    def elements(self) -> PlaneElements:
        """The finite elements."""
        return PlaneElements(self.mesh)

    @cached_property
    def centroid(self) -> FloatArray:
        """Centroid of the section, (2,), mm."""
        areas = self.elements.areas
        moment = np.einsum("eq,eqx->x", areas, self.elements.points)
        return np.asarray(moment / areas.sum())

    @cached_property
    def _turning(self) -> FloatArray:
        """(-y, x) about the centroid at the integration points, (n_elements, n_q, 2), mm."""
        x, y = np.moveaxis(self.elements.points - self.centroid, -1, 0)
        return np.stack([-y, x], axis=-1)

    @cached_property
    def warping(self) -> FloatArray:
        """Warping w at the nodes about the centroid, mean 0 over the nodes, (n_nodes,), mm2.

        Raises ValueError if the section falls into several pieces.
        """
        gradients, areas = self.elements.gradients, self.elements.areas
        nodes, count = self.mesh.elements, len(self.mesh.nodes)
        blocks = np.einsum("eq,eqai,eqbi->eab", areas, gradients, gradients, optimize=True)
        rows = np.broadcast_to(nodes[:, :, None], blocks.shape).ravel()
        columns = np.broadcast_to(nodes[:, None, :], blocks.shape).ravel()
        matrix = sp.coo_array((blocks.ravel(), (rows, columns)), (count, count)).tocsr()
        pieces, _ = sp.csgraph.connected_components(matrix, directed=False)
        if pieces > 1:
            raise ValueError(f"the section must be one piece, and the mesh has {pieces}")
        right = np.zeros(count)
        push = np.einsum("eq,eqai,eqi->ea", areas, gradients, self._turning, optimize=True)
        np.subtract.at(right, nodes, push)
        warping = np.zeros(count)  # node 0 is held: a shift along the bar strains nothing
        upper = sp.triu(matrix[1:][:, 1:], format="csr")
        warping[1:], _ = factorize(upper).solve(right[1:])
        return np.asarray(warping - warping.mean())

    @cached_property
    def _sheared(self) -> FloatArray:
        """Shear stress over G theta at the integration points, (n_elements, n_q, 2), mm."""
        local = self.warping[self.mesh.elements]
        slope = np.einsum("eqai,ea->eqi", self.elements.gradients, local)
        return np.asarray(slope + self._turning)

    @cached_property
    def torsion_constant(self) -> float:
        """J = T / (G theta), mm4."""
        return float(np.einsum("eq,eqi,eqi->", self.elements.areas, self._sheared, self._sheared))

    @cached_property
    def _element_shear(self) -> FloatArray:
        at_nodes = np.einsum("aq,eqi->eai", self.elements.continuation, self._sheared)
        return np.asarray(at_nodes / self.torsion_constant)

    @cached_property
    def shear(self) -> FloatArray:
        """Shear stress xz, yz per unit torque at the nodes, by the rule of stress, (n_nodes, 2).

        In 1/mm3: N mm of torque give MPa.
        """
        return nodal_average(self.elements, self.elements.areas, self._element_shear)

    @cached_property
    def scatter(self) -> FloatArray:
        """Root mean square of the elements' scatter about `shear`, (n_nodes,), 1/mm3."""
        away = self._element_shear - self.shear[self.mesh.elements]
        squares = (away**2).sum(axis=-1)
        return np.asarray(np.sqrt(nodal_average(self.elements, self.elements.areas, squares)))
