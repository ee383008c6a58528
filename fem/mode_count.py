"""Number of modes below a value: a proof by inertia, independent of any eigenvalue solver.

With A = K - value B, the number of modes of K x = lambda B x, C x = 0 with lambda between 0 and the
value is the number of negative eigenvalues of A on C x = 0 (Sylvester's law of inertia; K is
positive definite there). Some unknowns H, of nodes far apart, are chosen so that A without them is
positive definite, which one Cholesky factorisation proves. The rest of the count is a small dense
matrix (Haynsworth 1968, inertia additivity):

    S = [ A_HH - A_HF A_FF^-1 A_FH     C_H' - A_HF A_FF^-1 C_F' ]
        [ C_H - C_F A_FF^-1 A_FH         - C_F A_FF^-1 C_F'     ]

has as many negative eigenvalues as A on C x = 0 has, and one more per row of C. A part of B that is
w v v' joins H as one more unknown: with s = value w, A - s v v' has the inertia of
[A, v; v', 1/s] without the inertia of 1/s (the same additivity).

Elastic and geometric energy of displacement fields, summed at the integration points.

x' K x by matrix loses the square of (displacement over strain times element size) to round-off, the
sum of strains at the points only its first power: what slender parts need.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from fem.elements import Elements
from fem.end_conditions import SupportedSolid
from fem.solvers import Factor, SolverError, factorize
from fem.unit_solutions import Elastic, rigid_modes
from geometry.mesh import BoolArray, FloatArray, IntArray

_HELD_NODES = (0, 24, 96)  # far apart, beside what the known modes ask for; tried in turn
_ZERO = 1e-11  # of the largest: a smaller eigenvalue of S has no certain sign


@dataclass(frozen=True, eq=False)
class LowRank:
    """The matrix V diag(weights) V' of a few vectors.

    vectors  (3 n_nodes, k)
    weights  (k,) of any sign
    """

    vectors: FloatArray
    weights: FloatArray

    def times(self, fields: FloatArray) -> FloatArray:
        """Products (3 n_nodes, m) with fields (3 n_nodes, m)."""
        return np.asarray(self.vectors @ (self.weights[:, None] * (self.vectors.T @ fields)))

    def form(self, fields: FloatArray) -> FloatArray:
        """The form (m, m) between fields (3 n_nodes, m)."""
        seen = self.vectors.T @ fields
        return np.asarray(seen.T @ (self.weights[:, None] * seen))


def count_below(
    solid: SupportedSolid,
    matrix: "scipy.sparse.csr_array",
    value: float,
    known: FloatArray,
    beside: LowRank | None = None,
) -> int:
    """Number of modes of K x = lambda B x with lambda in (0, value), with the solid's supports.

    matrix  upper triangle of B without `beside`, with the pattern of the stiffness
    known   (3 n_nodes, k) modes thought to lie below the value: where they move, the part is held.
            They make the count quick and have no say in its result

    Raises SolverError if the count cannot be made for certain: the value is an eigenvalue to
    round-off, or lies above so many that holding 96 nodes does not stop them.
    """
    difference = shifted(solid, matrix, value)
    more = np.zeros(0) if beside is None else value * beside.weights
    kept = more != 0.0
    vectors = np.zeros((len(known), 0)) if beside is None else beside.vectors[:, kept]
    vectors, signs = vectors * np.sqrt(np.abs(more[kept])), np.sign(more[kept])
    moving = _where_it_moves(solid, known)
    for count in _HELD_NODES:
        held = moving.copy()
        held[_nodes_far_apart(solid, count)] = True
        held[solid.fixed] = False
        try:
            return _count(solid, difference, held, vectors, signs)
        except _IndefiniteError:
            continue
    raise SolverError(
        f"the modes below {value:.6g} cannot be counted: with {_HELD_NODES[-1]} nodes held the "
        "part still has some of them"
    )


def shifted(
    solid: SupportedSolid, matrix: "scipy.sparse.csr_array", value: float
) -> "scipy.sparse.csr_array":
    """Upper triangle of K - value B for matrices of one pattern."""
    stiff = solid.stiffness
    if matrix.nnz != stiff.nnz or not np.array_equal(matrix.indices, stiff.indices):
        raise ValueError("a mode count needs two matrices of the same pattern")
    data = stiff.data - value * matrix.data
    return scipy.sparse.csr_array((data, stiff.indices, stiff.indptr), shape=stiff.shape)


class _IndefiniteError(Exception):
    """Holding these unknowns leaves a negative direction."""


def _count(
    solid: SupportedSolid,
    difference: "scipy.sparse.csr_array",
    held: BoolArray,
    vectors: FloatArray,
    signs: FloatArray,
) -> int:
    """Modes with some unknowns held, of A - vectors diag(signs) vectors' (of few columns)."""
    still = held.copy()
    still[solid.fixed] = True
    rest, chosen = np.flatnonzero(~still), np.flatnonzero(held)
    to_rest = difference[:, rest]
    place = None if solid.place is None else solid.place[rest]
    coupling = to_rest[chosen].T + difference[rest][:, chosen]
    rows = np.vstack([solid.rows, vectors.T])
    border = np.hstack([coupling.toarray(), rows[:, rest].T])
    corner = difference[chosen][:, chosen].toarray()
    corner += np.triu(corner, k=1).T
    n_held, n_rows = len(chosen), len(solid.rows)
    whole = np.diag(np.r_[np.zeros(n_held + n_rows), signs])
    whole[:n_held, :n_held] = corner
    whole[:n_held, n_held:] = rows[:, chosen].T
    whole[n_held:, :n_held] = rows[:, chosen]
    if len(rest):
        whole -= border.T @ _positive(to_rest[rest], place).apply(border)
    return _negative(whole) - n_rows - int((signs < 0).sum())


def _positive(own: "scipy.sparse.csr_array", place: IntArray | None) -> Factor:
    try:
        return factorize(own, place=place)
    except SolverError as error:
        if "positive definite" not in str(error):
            raise
        raise _IndefiniteError from error


def _negative(matrix: FloatArray) -> int:
    """Number of negative eigenvalues of a symmetric matrix; a scaling keeps their signs."""
    if not len(matrix):
        return 0
    scale = 1 / np.sqrt(np.abs(matrix).max(axis=1))
    values = np.linalg.eigvalsh((matrix + matrix.T) / 2 * scale[:, None] * scale)
    if np.abs(values).min() < _ZERO * np.abs(values).max():
        raise SolverError("the modes cannot be counted at an eigenvalue itself")
    return int((values < 0).sum())


def _where_it_moves(solid: SupportedSolid, known: FloatArray) -> BoolArray:
    """Unknowns (3 n_nodes,), as many as there are modes and conditions, that stop all of them.

    Outside of the conditions A has at most one more negative direction for each; these are near the
    part's rigid motions and the answers to the conditions' forces. Pivoted QR finds the unknowns.
    """
    fields = [known]
    if len(solid.rows):
        fields += [solid.answers, rigid_modes(solid.elements.mesh.nodes)]
    together = np.concatenate(fields, axis=1)
    together[solid.fixed] = 0.0
    held = np.zeros(len(together), dtype=bool)
    if together.shape[1]:
        together /= np.abs(together).max(axis=0)
        *_, order = scipy.linalg.qr(together.T, mode="economic", pivoting=True)
        held[order[: together.shape[1]]] = True
    return held


def _nodes_far_apart(solid: SupportedSolid, count: int) -> IntArray:
    """Unknowns of nodes that stand as far from each other as possible, and from the middle."""
    places = solid.elements.mesh.nodes
    away = np.linalg.norm(places - places.mean(axis=0), axis=1)
    chosen: list[int] = []
    while len(chosen) < min(count, len(places)):
        chosen.append(int(away.argmax()))
        nearer = np.linalg.norm(places - places[chosen[-1]], axis=1)
        away = nearer if len(chosen) == 1 else np.minimum(away, nearer)
    return (3 * np.array(chosen, dtype=np.int64)[:, None] + np.arange(3)).ravel()


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
