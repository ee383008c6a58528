"""Stress at the nodes of a plane model by the rule of solids, and the elements' scatter there.

The rule: in each element the stress at the three integration points, where quadratic elements are
most accurate, is continued linearly to its six nodes; at a node the elements that share it are
averaged with their volumes as weights. Components are ordered xx, yy, zz, xy everywhere; of an
axisymmetric model x is the radius, y the axis and zz the hoop direction.
"""

from dataclasses import dataclass

import numpy as np

from fem.recovery import von_mises
from geometry.mesh import FloatArray

from .elements import PlaneElements

PLANE_COMPONENTS = ("xx", "yy", "zz", "xy")


@dataclass(frozen=True, eq=False)
class PlaneRecovery:
    """Stress recovery at the nodes of a plane mesh.

    elements  the finite elements
    volumes   (n_elements, n_q) mm3, of the integration points
    strains   (n_elements, n_q, 4, 12): strain xx, yy, zz and the angle xy, of the element's
              unknowns (x and y of its six nodes in turn)
    moduli    (4, 4) MPa, stress of strain
    """

    elements: PlaneElements
    volumes: FloatArray
    strains: FloatArray
    moduli: FloatArray

    def quadrature_stress(self, displacement: FloatArray) -> FloatArray:
        """Stress (n_elements, n_q, 4, m) at the integration points, MPa.

        displacement (2 n_nodes, m), mm
        """
        columns = displacement.reshape(len(self.elements.mesh.nodes), 2, -1)
        nodes = self.elements.mesh.elements
        local = columns[nodes].reshape(len(nodes), 1, 12, -1)
        return np.asarray(np.matmul(self.moduli @ self.strains, local))

    def element_stress(self, displacement: FloatArray) -> FloatArray:
        """Stress (n_elements, 6, 4, m) of each element at its own nodes, not averaged, MPa."""
        stress = self.quadrature_stress(displacement)
        return np.asarray(np.einsum("aq,eqkm->eakm", self.elements.continuation, stress))

    def nodal_stress(self, displacement: FloatArray) -> FloatArray:
        """Stress (n_nodes, 4, m), MPa."""
        return self._average(self.element_stress(displacement))

    def scatter(self, displacement: FloatArray) -> FloatArray:
        """Von Mises size (n_nodes,) of the elements' scatter about the recovered stress, MPa.

        displacement (2 n_nodes,): the weighted root mean square over the elements at each node.
        """
        stress = self.element_stress(displacement[:, None])
        away = stress - self._average(stress)[self.elements.mesh.elements]
        squares = von_mises_plane(away[..., 0]) ** 2
        return np.asarray(np.sqrt(self._average(squares)))

    def _average(self, values: FloatArray) -> FloatArray:
        return nodal_average(self.elements, self.volumes, values)


def nodal_average(elements: PlaneElements, volumes: FloatArray, values: FloatArray) -> FloatArray:
    """Mean (n_nodes, ...) over the elements at each node of values (n_elements, 6, ...).

    volumes (n_elements, n_q): their sums are the weights
    """
    nodes, count = elements.mesh.elements, len(elements.mesh.nodes)
    weights = np.broadcast_to(volumes.sum(axis=1)[:, None], nodes.shape)
    trailing = (..., *(None,) * (values.ndim - 2))
    total = np.zeros((count, *values.shape[2:]))
    np.add.at(total, nodes, values * weights[trailing])
    return np.asarray(total / np.bincount(nodes.ravel(), weights.ravel(), count)[trailing])


def von_mises_plane(stress: FloatArray) -> FloatArray:
    """Von Mises stress of components (..., 4) ordered xx, yy, zz, xy."""
    return von_mises(np.concatenate([stress, np.zeros((*stress.shape[:-1], 2))], axis=-1))


def largest_principal(stress: FloatArray) -> FloatArray:
    """Largest principal stress of components (..., 4) ordered xx, yy, zz, xy."""
    xx, yy, zz, xy = np.moveaxis(stress, -1, 0)
    return np.asarray(np.maximum((xx + yy) / 2 + np.hypot((xx - yy) / 2, xy), zz))
