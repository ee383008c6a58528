"""Elastic and geometric energy of displacement fields, summed at the integration points.

x' K x by matrix loses the square of (displacement over strain times element size) to round-off, the
sum of strains at the points only its first power: what slender parts need.
"""

import numpy as np

from fem.elements import Elements
from fem.unit_solutions import Elastic
from geometry.mesh import FloatArray

_CHUNK = 2000  # elements at a time: bounds memory


def elastic_and_geometric_energy(
    elements: Elements, material: Elastic, stress: FloatArray, fields: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Bilinear forms (m, m) of stiffness and geometric stiffness on fields (3 n_nodes, m), N mm.

    stress (n_elements, n_q, 3, 3), MPa, of the geometric stiffness

    sum w (lambda div u div v + 2 mu e(u):e(v)) and sum w sigma_ij u_k,i v_k,j.
    """
    young, poisson = material.youngs_modulus, material.poisson_ratio
    lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    shear = young / (2 * (1 + poisson))
    count = fields.shape[1]
    elastic, geometric = np.zeros((count, count)), np.zeros((count, count))
    for start in range(0, len(elements.mesh.elements), _CHUNK):
        part = slice(start, start + _CHUNK)
        slope = _slopes(elements, part, fields)  # (e, q, i, k, m): d u_k / d x_i
        weights = elements.weights[part][:, :, None]
        size = slope.shape[0] * slope.shape[1]
        pushed = np.matmul(stress[part], slope.reshape(*slope.shape[:3], -1)).reshape(slope.shape)
        pushed *= weights[..., None, None]
        geometric += pushed.reshape(-1, count).T @ slope.reshape(-1, count)
        strain = (slope + slope.swapaxes(2, 3)) / 2
        volume = np.einsum("eqiim->eqm", strain)
        weighted = strain * (2 * shear * weights[..., None, None])
        elastic += weighted.reshape(-1, count).T @ strain.reshape(-1, count)
        elastic += (lame * weights * volume).reshape(size, count).T @ volume.reshape(size, count)
    return elastic, geometric


def geometric_forms(elements: Elements, stress: FloatArray, fields: FloatArray) -> FloatArray:
    """Forms (n_basis, m, m) of the geometric stiffness of several stresses on fields, N mm.

    stress (n_elements, n_q, 6, n_basis), MPa, components xx, yy, zz, xy, yz, zx; fields
    (3 n_nodes, m)
    """
    count = fields.shape[1]
    first, second = np.triu_indices(count)
    total = np.zeros((stress.shape[-1], len(first)))
    for start in range(0, len(elements.mesh.elements), _CHUNK):
        part = slice(start, start + _CHUNK)
        slope = _slopes(elements, part, fields)  # (e, q, i, k, m)
        one, two = slope[..., first], slope[..., second]
        products = np.empty((*slope.shape[:2], 6, len(first)))
        for row, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))):
            products[:, :, row] = (one[:, :, i] * two[:, :, j]).sum(axis=2)
            if i != j:
                products[:, :, row] += (one[:, :, j] * two[:, :, i]).sum(axis=2)
        products *= elements.weights[part][:, :, None, None]
        total += stress[part].reshape(-1, len(total)).T @ products.reshape(-1, len(first))
    forms = np.empty((len(total), count, count))
    forms[:, first, second] = forms[:, second, first] = total
    return forms


def _slopes(elements: Elements, part: slice, fields: FloatArray) -> FloatArray:
    """Slopes (n_elements, n_q, 3, 3, m) of fields, d u_k / d x_i at [i, k]."""
    nodes = elements.mesh.elements[part]
    local = fields.reshape(len(elements.mesh.nodes), -1)[nodes]  # (e, 10, 3 m)
    gradients = elements.gradients[part].swapaxes(2, 3)  # (e, q, 3, 10)
    slope = np.matmul(gradients.reshape(len(nodes), -1, 10), local)
    return np.asarray(slope.reshape(*gradients.shape[:3], 3, -1))
