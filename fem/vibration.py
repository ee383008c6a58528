"""Natural frequencies of a solid on its supports, such as the pins of a link.

They are the lowest modes of K x = omega^2 M x with the consistent mass matrix
(docs/theory/vibration.md).
"""

from dataclasses import dataclass

import numpy as np
import scipy

from fem.assembly import Pattern, full
from fem.end_conditions import SupportedSolid, link_solid
from fem.lowest_modes import lowest_modes
from fem.mode_count import elastic_and_geometric_energy
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray

_CHUNK = 2000  # elements at a time: bounds memory
_UPPER = np.triu_indices(10)
_MASS_DEGREE = 4  # of two quadratic shape functions


@dataclass(frozen=True, eq=False)
class Vibration:
    """The lowest natural frequencies; rigid motions are not among them.

    angular  (k,) rad/s, ascending
    shapes   (k, n_nodes, 3), largest displacement 1
    proven   rad/s: every frequency below it is among these, or follows the last of them in steps
             below 0.1 %: a count by inertia says so; 0 if no count was asked for
    """

    angular: FloatArray
    shapes: FloatArray
    proven: float

    @property
    def hertz(self) -> FloatArray:
        """(k,) Hz, ascending."""
        return np.asarray(self.angular / (2 * np.pi))


def link_vibration(solutions: UnitSolutions, *, tilt_held: bool, count: int = 4) -> Vibration:
    """Return the vibration of a part whose pins stand still, as buckling holds it.

    tilt_held  True if the forks hold the ends against tilting out of the plane

    Raises SolverError if the modes do not converge or cannot be proven, ValueError for a stack of
    tied bodies, half of a part and a part without mass.
    """
    solid = link_solid(solutions, tilt_held=tilt_held, what="vibration")
    return solid_vibration(solid, count=count)


def solid_vibration(solid: SupportedSolid, *, count: int = 4, prove: bool = True) -> Vibration:
    """Return the vibration of a supported solid, its modes counted unless `prove` is False."""
    upper = mass(solid.pattern, solid.material.density)
    by_node = full(upper[::3][:, ::3].tocsr())  # the blocks are multiples of the identity

    def times(fields: FloatArray) -> FloatArray:
        return np.asarray(by_node @ fields.reshape(by_node.shape[0], -1)).reshape(fields.shape)

    def energies(fields: FloatArray) -> tuple[FloatArray, FloatArray]:
        elements = solid.elements
        none = np.zeros((*elements.weights.shape, 3, 3))
        elastic, _ = elastic_and_geometric_energy(elements, solid.material, none, fields)
        return elastic, fields.T @ times(fields)

    found = lowest_modes(solid, upper, times, energies, count, prove=prove)
    shapes = found.shapes.T.reshape(len(found.values), -1, 3)
    shapes = shapes / np.abs(shapes).max(axis=(1, 2), keepdims=True)
    return Vibration(np.sqrt(found.values), shapes, float(np.sqrt(found.proven)))


def mass(pattern: Pattern, density: float) -> "scipy.sparse.csr_array":
    """Upper triangle of the consistent mass matrix, t.

    The block of nodes a and b is delta_ij sum_q w density N_a N_b, by a rule of degree 4: exact in
    elements with straight edges. Raises ValueError for a part without mass.
    """
    if not density > 0:
        raise ValueError(f"frequencies need a density above 0 t/mm3, got {density}")
    import skfem

    points, weights = skfem.quadrature.get_quadrature(skfem.refdom.RefTet, _MASS_DEGREE)
    element = skfem.ElementTetP2()
    both = [element.lbasis(points, node) for node in range(10)]
    values = np.stack([value for value, _ in both])  # (10, n_q)
    slopes = np.stack([slope for _, slope in both])  # (10, 3, n_q)
    mesh = pattern.elements.mesh
    products = (values[:, None] * values[None, :] * weights).reshape(100, -1)
    blocks = np.empty((len(mesh.elements), 55))
    for start in range(0, len(mesh.elements), _CHUNK):
        part = slice(start, start + _CHUNK)
        corners = mesh.nodes[mesh.elements[part]]  # (e, 10, 3)
        jacobian = np.einsum("eax,akq->eqxk", corners, slopes, optimize=True)
        local = (np.abs(np.linalg.det(jacobian)) @ products.T).reshape(-1, 10, 10)
        order = pattern.order[part]
        each = np.arange(len(order))[:, None]
        blocks[part] = density * local[each, order[:, _UPPER[0]], order[:, _UPPER[1]]]
    return pattern.upper_scalar(blocks)
