"""Stress at surface nodes by one rule, and the scatter of the elements that meet there.

The rule: in each element the stress at the four integration points, where quadratic elements are
most accurate, is continued linearly to its ten nodes; at a node the elements that share it are
averaged with their volumes as weights. Components are ordered xx, yy, zz, xy, yz, zx everywhere.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fem.elements import Elements
from geometry.mesh import FloatArray, IntArray

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")
_TENSOR = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
_NODE_POINTS = np.array(
    [
        [0, 0, 0],
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
        [0.5, 0, 0],
        [0.5, 0.5, 0],
        [0, 0.5, 0],
        [0, 0, 0.5],
        [0.5, 0, 0.5],
        [0, 0.5, 0.5],
    ]
)


@dataclass(frozen=True, eq=False)
class Recovery:
    """Stress recovery at the surface nodes of a mesh.

    elements        the finite elements
    youngs_modulus  MPa
    poisson_ratio   1
    """

    elements: Elements
    youngs_modulus: float
    poisson_ratio: float

    @cached_property
    def points(self) -> IntArray:
        """The surface nodes, (n_points,)."""
        return self.elements.mesh.surface_nodes

    @cached_property
    def _touching(self) -> IntArray:
        on_surface = np.zeros(len(self.elements.mesh.nodes), dtype=bool)
        on_surface[self.points] = True
        return np.flatnonzero(on_surface[self.elements.mesh.elements].any(axis=1))

    @cached_property
    def _continuation(self) -> FloatArray:
        """(10, n_q): linear continuation from the integration points to the nodes."""
        local = self.elements.local_points
        design = np.column_stack([np.ones(len(local)), local])
        at_nodes = np.column_stack([np.ones(10), _NODE_POINTS])
        return np.asarray(at_nodes @ np.linalg.inv(design))

    def quadrature_stress(self, displacement: FloatArray, part: IntArray | slice) -> FloatArray:
        """Stress (n_elements, n_q, 6, m) at the integration points of some elements, MPa.

        displacement (3 n_nodes, m), mm
        """
        nodes = self.elements.mesh.elements[part]
        columns = displacement.reshape(len(self.elements.mesh.nodes), 3, -1)
        local = columns[nodes].reshape(*nodes.shape, -1)  # (e, 10, 3 m)
        gradients = self.elements.gradients[part]
        slope = np.matmul(np.swapaxes(gradients, 2, 3), local[:, None])  # (e, q, 3, 3 m)
        slope = slope.reshape(*slope.shape[:3], 3, -1)  # d u_j / d x_i at [i, j]
        lame = self.youngs_modulus * self.poisson_ratio
        lame /= (1 + self.poisson_ratio) * (1 - 2 * self.poisson_ratio)
        shear = self.youngs_modulus / (2 * (1 + self.poisson_ratio))
        volume = lame * (slope[:, :, 0, 0] + slope[:, :, 1, 1] + slope[:, :, 2, 2])
        stress = np.empty((*slope.shape[:2], 6, slope.shape[-1]))
        for k, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))):
            stress[:, :, k] = shear * (slope[:, :, i, j] + slope[:, :, j, i])
            if k < 3:
                stress[:, :, k] += volume
        return stress

    def surface_stress(self, displacement: FloatArray) -> FloatArray:
        """Stress (n_points, 6, m) at the surface nodes, MPa."""
        total = np.zeros(
            (len(self.points), 6, displacement.reshape(displacement.shape[0], -1).shape[1])
        )
        weight = np.zeros(len(self.points))
        for part in _chunks(self._touching, 2000):
            values, places, weights = self._contributions(displacement, part)
            np.add.at(total, places, values * weights[:, None, None])
            np.add.at(weight, places, weights)
        return np.asarray(total / weight[:, None, None])

    def scatter(self, displacement: FloatArray) -> FloatArray:
        """Von Mises size (n_points,) of the elements' scatter about the recovered stress, MPa.

        displacement (3 n_nodes,): the weighted root mean square over the elements at each node.
        """
        mean = self.surface_stress(displacement)[:, :, 0]
        total, weight = np.zeros(len(self.points)), np.zeros(len(self.points))
        for part in _chunks(self._touching, 20000):
            values, places, weights = self._contributions(displacement, part)
            away = values[:, :, 0] - mean[places]
            np.add.at(total, places, von_mises(away) ** 2 * weights)
            np.add.at(weight, places, weights)
        return np.asarray(np.sqrt(total / weight))

    def _contributions(
        self, displacement: FloatArray, part: IntArray
    ) -> tuple[FloatArray, IntArray, FloatArray]:
        nodes = self.elements.mesh.elements[part]
        stress = self.quadrature_stress(displacement, part)
        at_nodes = np.einsum("aq,eqkm->eakm", self._continuation, stress, optimize=True)
        place = np.searchsorted(self.points, nodes)
        place = np.minimum(place, len(self.points) - 1)
        keep = self.points[place] == nodes
        volumes = np.broadcast_to(self.elements.weights[part].sum(axis=1)[:, None], nodes.shape)
        return at_nodes[keep], place[keep], volumes[keep]


def von_mises(stress: FloatArray) -> FloatArray:
    """Von Mises stress of components (..., 6) ordered xx, yy, zz, xy, yz, zx."""
    xx, yy, zz, xy, yz, zx = np.moveaxis(stress, -1, 0)
    normal = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2
    return np.asarray(np.sqrt(normal + 3 * (xy**2 + yz**2 + zx**2)))


def tensor(stress: FloatArray) -> FloatArray:
    """Tensors (..., 3, 3) of components (..., 6)."""
    return np.asarray(stress[..., _TENSOR])


def _chunks(indices: IntArray, size: int) -> list[IntArray]:
    return [indices[start : start + size] for start in range(0, len(indices), size)]
