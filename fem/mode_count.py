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

The supports stand on the factor of the solid's stress analysis. Some unknowns may be fixed for
good; any other condition is a row of C in C u = 0. With the rigid modes R of a part that nothing
fixes, K u + C' m = f, C u = 0 needs only solves with the held stiffness and a dense system as small
as C (docs/theory/buckling.md).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from fem.assembly import Elements, Pattern
from fem.solvers import Factor, SolverError, factorize, node_dissection
from fem.unit_loads import InterfaceLoads
from fem.unit_solutions import Elastic, UnitSolutions, rigid_modes
from geometry.mesh import BoolArray, FloatArray, IntArray, Interface

_HELD_NODES = (0, 24, 96)  # far apart, beside what the known modes ask for; tried in turn
_ZERO = 1e-11  # of the largest: a smaller eigenvalue of S has no certain sign


@dataclass(frozen=True, eq=False)
class SupportedSolid:
    """A solid, its stiffness and its supports.

    stiffness  upper triangle of the whole matrix, N/mm
    fixed      (k,) unknowns that never move
    rows       (c, 3 n_nodes) conditions rows @ u = 0, independent of each other
    held       (h,) unknowns left out of the factor: the fixed ones, or six if none is fixed
    factor     of the stiffness without the held unknowns
    """

    elements: Elements
    pattern: Pattern
    material: Elastic
    stiffness: "scipy.sparse.csr_array"
    fixed: IntArray
    rows: FloatArray
    held: IntArray
    factor: Factor

    def __post_init__(self) -> None:
        size = self.stiffness.shape[0]
        if self.rows.ndim != 2 or self.rows.shape[1] != size:
            raise ValueError(f"conditions must have shape (c, {size}), got {self.rows.shape}")
        if len(self.fixed) and not np.array_equal(np.sort(self.fixed), np.sort(self.held)):
            raise ValueError("a solid with fixed unknowns must be held at these and no others")
        known = np.linalg.matrix_rank(self.rows @ self.rows.T) if len(self.rows) else 0
        if known < len(self.rows):
            raise ValueError(f"of {len(self.rows)} conditions only {known} are independent")
        if not len(self.fixed) and len(self.rows) < 6:
            raise ValueError(f"{len(self.rows)} conditions cannot stop six rigid motions")

    @cached_property
    def free(self) -> IntArray:
        """Unknowns that may move."""
        return np.setdiff1d(np.arange(self.stiffness.shape[0]), self.fixed)

    @cached_property
    def place(self) -> IntArray | None:
        """Where each unknown stands in the order of elimination, None without CHOLMOD."""
        by_node = node_dissection(self.elements.mesh.elements)
        return None if by_node is None else np.repeat(by_node, 3)

    def inverse(self, forces: FloatArray) -> FloatArray:
        """Displacement (3 n_nodes, m) under forces (3 n_nodes, m), where the supports hold."""
        response = self._held_solve(forces)
        if not len(self.rows):
            return response
        modes, back, bordered = self._border
        right = np.concatenate([self._sparse_rows @ response, modes.T @ forces])
        response += back @ np.linalg.solve(bordered, right)
        return response

    @property
    def answers(self) -> FloatArray:
        """Displacement (3 n_nodes, c) of the held part under each condition's force."""
        return -self._border[1][:, : len(self.rows)]

    @cached_property
    def _border(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Rigid modes R (n, 6 or 0), [-K_h^-1 C', R] (n, c + 6 or c), and the dense system."""
        modes = rigid_modes(self.elements.mesh.nodes)
        if len(self.fixed):
            modes = modes[:, :0]
        else:
            modes[:, 3:] /= np.abs(modes[:, 3:]).max()
        responses = self._held_solve(self.rows.T.copy())
        count, size = len(self.rows), len(self.rows) + modes.shape[1]
        bordered = np.zeros((size, size))
        bordered[:count, :count] = self.rows @ responses
        bordered[:count, count:] = -self.rows @ modes
        bordered[count:, :count] = modes.T @ self.rows.T
        return modes, np.hstack([-responses, modes]), bordered

    @cached_property
    def _sparse_rows(self) -> "scipy.sparse.csr_array":
        """The conditions, of which those of a link touch its interfaces only."""
        return scipy.sparse.csr_array(self.rows)

    def _held_solve(self, forces: FloatArray) -> FloatArray:
        response = np.zeros(forces.shape)
        response[self._solved] = self.factor.apply(forces[self._solved])
        return response

    @cached_property
    def _solved(self) -> IntArray:
        return np.setdiff1d(np.arange(self.stiffness.shape[0]), self.held)


def link_solid(
    solutions: UnitSolutions, *, tilt_held: bool, twist_held_at: str | None = None, what: str
) -> SupportedSolid:
    """Return a part held at two of its interfaces as pins hold a link.

    tilt_held      True if both forks hold their ends against any turn but that about the pin
    twist_held_at  interface that holds the part against turning about its own axis where forks are
                   soft; None for the first one
    what           is asked, for the message

    At each interface the mean displacement is held, along the part at one only; about the pins both
    ends may turn. Raises ValueError for a stack of tied bodies and MeshError for half of a part.
    """
    check_whole(solutions, what)
    rows = end_conditions(solutions, tilt_held=tilt_held, twist_held_at=twist_held_at)
    return supported(solutions, rows)


def end_conditions(
    solutions: UnitSolutions, *, tilt_held: bool, twist_held_at: str | None = None
) -> FloatArray:
    """Rows (n_rows, 3 n_nodes) of mean displacements and rotations held to zero."""
    nodes, (first, second) = solutions.mesh.nodes, holding(solutions.interfaces, twist_held_at)
    c, s = unit_vector(second.centre[:2] - first.centre[:2])
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    rows = []
    for interface in (first, second):
        weights = surface_weights(solutions.elements, interface.name)
        x, y, z = axes @ (nodes - interface.centre).T

        def mean(axis: int, factor: FloatArray, weights: FloatArray = weights) -> FloatArray:
            return np.asarray(np.outer(weights * factor, axes[axis]).ravel())

        one = np.ones(len(weights))
        rows += [mean(axis, one) for axis in ((0, 1, 2) if interface is first else (1, 2))]
        if tilt_held or interface is first:  # no turning about the part's own axis
            rows.append(mean(2, y) - mean(1, z))
        if tilt_held:
            rows.append(mean(0, z) - mean(2, x))
    return np.array([row / np.linalg.norm(row) for row in rows])


def holding(interfaces: Sequence[InterfaceLoads], name: str | None) -> tuple[Interface, Interface]:
    """Return the two interfaces by which a part is held, the one called `name` first.

    The other is the one nearest to it, whatever their order, so that what lies beyond both is free
    for the longest way; of several as near, the one with the least x, then y. Contacts that slide
    hold nothing where two others do.
    """
    known = [loads.interface for loads in interfaces]
    fixed = [interface for interface in known if interface.kind != "slide"]
    known = fixed if len(fixed) > 1 else known
    first = next((one for one in known if one.name == name), known[0])
    others = [one for one in known if one is not first]
    return first, min(others, key=lambda one: nearness(one.centre[:2], first.centre[:2]))


def nearness(point: FloatArray, start: FloatArray) -> tuple[float, ...]:
    """Rank of a point (2,) by its distance from a start, then by x and y; to a nanometre."""
    return tuple(round(float(value), 6) for value in (np.hypot(*(point - start)), *point))


def unit_vector(apart: FloatArray) -> FloatArray:
    """Direction (2,) of a vector, along x of one without length."""
    length = np.hypot(*apart)
    return apart / length if length else np.array([1.0, 0.0])


def surface_weights(elements: Elements, name: str) -> FloatArray:
    """Shares (n_nodes,) of the nodes in the mean over a named surface; their sum is 1."""
    surface = elements.surface(name)
    weights = np.zeros(len(elements.mesh.nodes))
    np.add.at(weights, surface.nodes, np.einsum("aq,fq->fa", surface.shape, surface.weights))
    return np.asarray(weights / weights.sum())


def supported(solutions: UnitSolutions, rows: FloatArray) -> SupportedSolid:
    """Return a part with conditions rows @ u = 0 (c, 3 n_nodes) and nothing fixed for good."""
    return SupportedSolid(
        elements=solutions.elements,
        pattern=solutions.pattern,
        material=solutions.material,
        stiffness=solutions.stiffness,
        fixed=np.zeros(0, dtype=np.int64),
        rows=rows,
        held=solutions.held,
        factor=solutions.factor,
    )


def check_whole(solutions: UnitSolutions, what: str) -> None:
    """Raise ValueError for a stack of tied bodies, MeshError for half of a part."""
    solutions.mesh.check_whole(f"{what}, which may be sideways,")
    if solutions.ties is not None:
        raise ValueError(
            f"{what} is computed for parts of one body; this one is a stack of tied bodies that "
            "slide on each other"
        )


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
