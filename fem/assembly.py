"""Sparse matrices of elasticity, assembled by node pairs.

All matrices of a part share one pattern: the upper triangle of node pairs that some element joins,
each with a 3 x 3 block. The pattern is sorted once; a matrix is then a sum over equal pairs.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from fem.elements import Elements
from geometry.mesh import FloatArray, IntArray

BoolArray = npt.NDArray[np.bool_]

_UPPER = np.triu_indices(10)
_CHUNK = 8000  # elements at a time: bounds the memory of the dense element matrices


@dataclass(frozen=True, eq=False)
class Pattern:
    """Where the blocks of an elasticity matrix stand.

    Unknown 3 n + i is component i of node n.
    """

    elements: Elements

    @cached_property
    def _sorted(self) -> tuple[IntArray, IntArray, IntArray, BoolArray]:
        nodes = self.elements.mesh.elements
        first, second = nodes[:, _UPPER[0]].ravel(), nodes[:, _UPPER[1]].ravel()
        swapped = first > second
        low, high = np.where(swapped, second, first), np.where(swapped, first, second)
        key = low * len(self.elements.mesh.nodes) + high
        order: IntArray = np.argsort(key, kind="stable").astype(np.int64)
        starts: IntArray = np.flatnonzero(np.r_[True, np.diff(key[order]) > 0]).astype(np.int64)
        pairs: IntArray = key[order][starts]
        return order, starts, pairs, swapped

    def upper(self, blocks: FloatArray) -> sp.csr_array:
        """Sum element blocks (n_elements, 55, 3, 3) of node pairs i <= j to the upper triangle."""
        order, starts, pairs, swapped = self._sorted
        flat = blocks.reshape(-1, 3, 3)
        flat = np.where(swapped[:, None, None], np.swapaxes(flat, 1, 2), flat)
        summed = np.add.reduceat(flat[order], starts, axis=0)
        n = len(self.elements.mesh.nodes)
        rows, columns = pairs // n, pairs % n
        indptr = np.searchsorted(rows, np.arange(n + 1))
        matrix = sp.bsr_array((summed, columns, indptr), shape=(3 * n, 3 * n))
        return sp.triu(matrix.tocsr(), format="csr")

    def upper_scalar(self, values: FloatArray) -> sp.csr_array:
        """Sum multiples of the 3 x 3 identity, values (n_elements, 55), in the same way."""
        return self.upper(values[:, :, None, None] * np.eye(3))


def stiffness(pattern: Pattern, youngs_modulus: float, poisson_ratio: float) -> sp.csr_array:
    """Upper triangle of the stiffness matrix of isotropic elasticity, N/mm.

    With G_ai the gradient of shape function a, the block of nodes a and b is
    sum_q w (lambda G_ai G_bj + mu G_aj G_bi + mu delta_ij G_a . G_b).
    """
    elements = pattern.elements
    lame = youngs_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))
    shear = youngs_modulus / (2 * (1 + poisson_ratio))
    count = len(elements.mesh.elements)
    blocks = np.empty((count, 55, 3, 3))
    for start in range(0, count, _CHUNK):
        part = slice(start, min(start + _CHUNK, count))
        gradients = elements.gradients[part]  # (e, q, 10, 3)
        flat = gradients.reshape(*gradients.shape[:2], 30)
        weighted = flat * elements.weights[part][:, :, None]
        products = np.matmul(np.swapaxes(weighted, 1, 2), flat).reshape(-1, 10, 3, 10, 3)
        upper = products[:, _UPPER[0], :, _UPPER[1], :]  # (55, e, 3, 3)
        trace = np.trace(upper, axis1=2, axis2=3)
        block = lame * upper + shear * np.swapaxes(upper, 2, 3)
        block[:, :, [0, 1, 2], [0, 1, 2]] += shear * trace[:, :, None]
        blocks[part] = np.swapaxes(block, 0, 1)
    return pattern.upper(blocks)


def geometric_stiffness(pattern: Pattern, stress: FloatArray) -> sp.csr_array:
    """Upper triangle of the geometric stiffness of a stress state, N/mm.

    stress (n_elements, n_q, 3, 3), MPa. The block of nodes a and b is
    delta_ij sum_q w G_a . sigma G_b (Bathe, Finite Element Procedures, 2nd ed., section 6.8.1).
    """
    elements = pattern.elements
    count = len(elements.mesh.elements)
    values = np.empty((count, 55))
    for start in range(0, count, _CHUNK):
        part = slice(start, min(start + _CHUNK, count))
        gradients = elements.gradients[part]
        pushed = np.matmul(gradients, stress[part] * elements.weights[part][:, :, None, None])
        products = np.einsum("eqai,eqbi->eab", pushed, gradients, optimize=True)
        values[part] = products[:, _UPPER[0], _UPPER[1]]
    return pattern.upper_scalar(values)


def full(upper: sp.csr_array) -> sp.csr_array:
    """Return the symmetric matrix whose upper triangle is given."""
    return (upper + sp.triu(upper, k=1).T).tocsr()
