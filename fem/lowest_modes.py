"""The lowest modes of K x = lambda B x where a solid's supports hold, refined and counted.

Block Lanczos steps u = K^-1 B x with full orthogonalisation in the inner product of K find the
largest 1 / lambda of both signs; a random block keeps modes of equal value apart. K appears in no
product: of every vector the force that gives it is kept beside it. The last step is one inverse
iteration and a Rayleigh-Ritz step with energies summed at the integration points. Their round-off
grows with the slenderness; the round-off of x' K x grows with its square or worse.

Energies of displacement fields are summed at the integration points. x' K x by matrix loses the
square of (displacement over strain times element size) to round-off, the sum of strains at the
points only its first power: what slender parts need.

Natural frequencies of a solid, afloat, on the pins of a link, or with fixed unknowns, are such
modes of K x = omega^2 M x with the consistent mass matrix (docs/theory/vibration.md).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from fem.assembly import Pattern, full
from fem.elements import Elements
from fem.end_conditions import SupportedSolid, link_solid, loose_solid
from fem.solvers import Factor, SolverError, factorize
from fem.unit_solutions import Elastic, UnitSolutions, rigid_modes
from geometry.mesh import BoolArray, FloatArray, IntArray

_CHUNK = 2000  # elements at a time: bounds memory
_UPPER = np.triu_indices(10)
_MASS_DEGREE = 4  # of two quadratic shape functions

_TOLERANCE = 1e-5  # a mode's residual in the norm of energy; the value's error is its square
_BLOCK = 4  # vectors: solves in blocks cost half as much each
_STEPS = 60  # blocks
_GAP = 1e-3  # relative: values nearer to each other are told apart by no count
_LOST = 1e-11  # relative: what orthogonalisation leaves below this is round-off
_CANCELLED = 1e-2  # relative: what is left below this is made orthogonal once more
_NEARLY = 1e-3  # residual of the mode after the last, and of the negative one
_FIRST_STEPS = 3
_AROUND = 3.0  # times the highest mode: modes that the count is told of
_WEAKER = (0.5, 0.1)  # of the lowest value found: where a count may still prove something
_BEYOND = 0.02  # relative: how far above the highest mode the count is made at most


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


Times = Callable[[FloatArray], FloatArray]
Energies = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
_HELD_NODES = (0, 24, 96)  # far apart, beside what the known modes ask for; tried in turn
_ZERO = 1e-11  # of the largest: a smaller eigenvalue of S has no certain sign


@dataclass(frozen=True, eq=False)
class Modes:
    """The lowest positive modes.

    values    (k,) ascending
    shapes    (3 n_nodes, k), each with x' K x = 1
    proven    all values in (0, proven) are among `values` or follow the last of them in steps
              below 0.2 %: a count by inertia says so; 0 if no count was asked for
    negative  the negative value nearest to zero, None if there is none within the limit
    """

    values: FloatArray
    shapes: FloatArray
    proven: float
    negative: float | None


def lowest_modes(
    solid: SupportedSolid,
    matrix: "scipy.sparse.csr_array",
    times: Times,
    energies: Energies,
    count: int,
    *,
    beside: LowRank | None = None,
    limit: float = np.inf,
    prove: bool = True,
    weaker: bool = False,
) -> Modes:
    """Return the lowest positive values of K x = lambda B x and their shapes.

    matrix    upper triangle of B without `beside`, with the pattern of the stiffness
    times     x (3 n_nodes, m) to B x
    energies  x (3 n_nodes, m) to x' K x and x' B x, (m, m) each
    beside    part of B that couples nodes which no element joins
    limit     values above it are not wanted
    prove     whether no value is skipped is proven by a count
    weaker    where the count finds others, or cannot be made: whether a proof that none lies below
              half or a tenth of the lowest found, or of the limit, will do; `proven` is then that

    Raises SolverError if the modes do not converge, the count finds others or cannot be made.
    """
    if count < 1:
        raise ValueError(f"the number of modes must be at least 1, got {count}")
    block = _BLOCK
    for seed in range(3):
        found = _search(solid, times, count, limit, block, seed)
        values, shapes = _refined(solid, times, energies, found.shapes)
        inside = values < limit
        values, shapes = values[inside], shapes[:, inside]
        if not prove:
            return Modes(values[:count], shapes[:, :count], 0.0, found.negative)
        cut = _cut(values, found.following, limit)
        below = np.count_nonzero(values < cut)
        try:
            counted = count_below(solid, matrix, cut, found.around, beside)
        except SolverError as error:
            problem = error
            break
        if counted == below:
            return Modes(values[:count], shapes[:, :count], cut, found.negative)
        problem = SolverError(f"{counted} modes lie below {cut:.6g}, but only {below} were found")
        block *= 2
    for share in _WEAKER if weaker else ():
        proven = share * float(values[0] if len(values) else limit)
        if _none_below(solid, matrix, proven, found.around, beside):
            return Modes(values[:count], shapes[:, :count], proven, found.negative)
    raise problem


def _none_below(
    solid: SupportedSolid,
    matrix: "scipy.sparse.csr_array",
    value: float,
    known: FloatArray,
    beside: LowRank | None,
) -> bool:
    """Return True if a count can be made and shows that no mode lies below a value."""
    try:
        return count_below(solid, matrix, value, known, beside) == 0
    except SolverError:
        return False


def _cut(values: FloatArray, following: float, limit: float) -> float:
    """Where to count: above the last of some modes, below the one that follows."""
    if not len(values):
        return limit
    gap = max(following / values[-1] - 1, 0.0)
    return float(min(values[-1] * (1 + min(gap / 2, _BEYOND)), limit))


def _refined(
    solid: SupportedSolid, times: Times, energies: Energies, shapes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """One inverse iteration and a Rayleigh-Ritz step: values ascending, shapes."""
    if not shapes.shape[1]:
        return np.zeros(0), shapes
    shapes = solid.inverse(times(shapes))
    shapes /= np.abs(shapes).max(axis=0)
    stiff, other = energies(shapes)
    inverse_values, mix = scipy.linalg.eigh(other, stiff)
    return 1 / inverse_values[::-1], np.asarray(shapes @ mix[:, ::-1])


@dataclass(frozen=True, eq=False)
class _Found:
    """Ritz vectors of the wanted modes, an estimate of the next value, the negative one.

    around  (3 n_nodes, m) all that the space knows of the modes up to _AROUND times the last
    """

    shapes: FloatArray
    around: FloatArray
    following: float
    negative: float | None


class _Krylov:
    """A space of displacements, orthonormal in energy, that grows by blocks of K^-1 B.

    small    (done, done) B within the space
    leaving  (.., width) what K^-1 B of the newest block has outside of the space
    """

    def __init__(self, solid: SupportedSolid, times: Times, width: int, seed: int) -> None:
        self._solid, self._times = solid, times
        size = solid.stiffness.shape[0]
        self.room = min((_STEPS + 1) * width, len(solid.free) - len(solid.rows))
        self._vectors = np.empty((size, self.room), order="F")
        self._forces = np.empty((size, self.room), order="F")
        self._small = np.zeros((self.room, self.room))
        self.done = self._last = 0
        force = np.random.default_rng(seed).standard_normal((size, width))
        force[solid.fixed] = 0.0
        self._next(force)

    def grow(self) -> bool:
        """Take the next block in; False if there is none, for the space is whole."""
        wide = min(self._new.shape[1], self.room - self.done)
        if not wide:
            return False
        self._last, self.done = self.done, self.done + wide
        block = slice(self._last, self.done)
        self._vectors[:, block] = self._new[:, :wide]
        self._forces[:, block] = self._force[:, :wide]
        self._next(self._times(self._vectors[:, block]))
        return True

    def ritz(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """1 / lambda in descending order, mixes (done, done), and residuals in energy."""
        values, mix = np.linalg.eigh(self._small[: self.done, : self.done])
        values, mix = values[::-1], mix[:, ::-1]
        return values, mix, np.linalg.norm(self._leaving @ mix[self._last :], axis=0)

    def combined(self, mix: FloatArray) -> FloatArray:
        """Displacements of some mixes (done, k)."""
        return np.asarray(self._vectors[:, : self.done] @ mix)

    def _next(self, force: FloatArray) -> None:
        """Solve for the next block and make it orthonormal."""
        new = self._solid.inverse(force)
        vectors, forces = self._vectors[:, : self.done], self._forces[:, : self.done]
        before = np.sqrt(np.abs(np.einsum("nj,nj->j", new, force)).max())
        inside = forces.T @ new
        if self.done:  # V' K K^-1 B V of the newest block is V' B V
            self._small[: self.done, self._last : self.done] = inside
            self._small[self._last : self.done, : self.done] = inside.T
        new -= vectors @ inside
        force = force - forces @ inside
        after = np.sqrt(np.abs(np.einsum("nj,nj->j", new, force)).min())
        if after < _CANCELLED * before:  # twice is enough (Parlett, 6.9)
            inside = forces.T @ new
            new -= vectors @ inside
            force = force - forces @ inside
        gram = new.T @ force
        squares, turn = np.linalg.eigh((gram + gram.T) / 2)
        kept = squares > (_LOST * before) ** 2
        sizes, turn = np.sqrt(squares[kept]), turn[:, kept]
        self._leaving = sizes[:, None] * turn.T
        self._new, self._force = new @ (turn / sizes), force @ (turn / sizes)


def _search(
    solid: SupportedSolid, times: Times, count: int, limit: float, width: int, seed: int
) -> _Found:
    """Grow the space until the wanted modes, and the first negative one, have converged."""
    space = _Krylov(solid, times, width, seed)
    for step in range(_STEPS):
        whole = not space.grow()
        values, mix, residuals = space.ritz()
        if whole:
            residuals = np.zeros_like(residuals)
        wanted = _wanted(values, count, limit)
        errors = residuals / np.maximum(np.abs(values), 1e-300)
        positive = np.count_nonzero(values > 0)
        settled = (errors[:wanted] < _TOLERANCE).all()
        settled &= (errors[wanted : min(wanted + 1, positive)] < _NEARLY).all() or wanted < count
        backwards = -values[-1] > 1 / limit
        settled &= not backwards or errors[-1] < _NEARLY
        if whole or (settled and step >= _FIRST_STEPS * (seed + 1)):
            following = 1 / values[wanted] if wanted < positive else np.inf
            negative = float(1 / values[-1]) if backwards else None
            around = _around(values, wanted, limit)
            fields = space.combined(mix[:, :around])
            return _Found(fields[:, :wanted], fields, float(following), negative)
    raise SolverError(
        f"the modes did not converge in {_STEPS} blocks of {width} vectors: residuals "
        f"{np.array2string(errors[:wanted], precision=1)} of the first {wanted}"
    )


def _around(values: FloatArray, wanted: int, limit: float) -> int:
    """Number of 1 / lambda (descending) that belong to modes not far above the last wanted."""
    least = (values[wanted - 1] if wanted else 1 / limit) / _AROUND
    return max(int(np.count_nonzero(values > least)), wanted)


def _wanted(values: FloatArray, count: int, limit: float) -> int:
    """Number of 1 / lambda (descending) to find: `count`, and those equal to the last of them."""
    inside = int(np.count_nonzero(values > 1 / limit))
    wanted = min(count, inside)
    while 0 < wanted < inside and values[wanted] > (1 - 2 * _GAP) * values[wanted - 1]:
        wanted += 1
    return wanted


# Number of modes below a value: a proof by inertia, independent of any eigenvalue solver.
#
# With A = K - value B, the number of modes of K x = lambda B x, C x = 0 with lambda between 0 and
# the value is the number of negative eigenvalues of A on C x = 0 (Sylvester's law of inertia; K
# is positive definite there). Some unknowns H, of nodes far apart, are chosen so that A without
# them is positive definite, which one Cholesky factorisation proves. The rest of the count is a
# small dense matrix (Haynsworth 1968, inertia additivity):
#
#     S = [ A_HH - A_HF A_FF^-1 A_FH     C_H' - A_HF A_FF^-1 C_F' ]
#         [ C_H - C_F A_FF^-1 A_FH         - C_F A_FF^-1 C_F'     ]
#
# has as many negative eigenvalues as A on C x = 0 has, and one more per row of C. A part of B that
# is w v v' joins H as one more unknown: with s = value w, A - s v v' has the inertia of
# [A, v; v', 1/s] without that of 1/s (the same additivity).


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


def mass(pattern: Pattern, density: float) -> "scipy.sparse.csr_array":
    """Upper triangle of the consistent mass matrix, t.

    The block of nodes a and b is delta_ij sum_q w density N_a N_b, by a rule of degree 4: exact in
    elements with straight edges.
    """
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


def _slopes(elements: Elements, part: slice, fields: FloatArray) -> FloatArray:
    """Slopes (n_elements, n_q, 3, 3, m) of fields, d u_k / d x_i at [i, k]."""
    nodes = elements.mesh.elements[part]
    local = fields.reshape(len(elements.mesh.nodes), -1)[nodes]  # (e, 10, 3 m)
    gradients = elements.gradients[part].swapaxes(2, 3)  # (e, q, 3, 10)
    slope = np.matmul(gradients.reshape(len(nodes), -1, 10), local)
    return np.asarray(slope.reshape(*gradients.shape[:3], 3, -1))


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


def free_vibration(solutions: UnitSolutions, *, count: int = 4, prove: bool = True) -> Vibration:
    """Return the elastic vibration of a part afloat; its six rigid motions are left out.

    Raises SolverError if the modes do not converge or cannot be proven, ValueError for a stack of
    tied bodies, half of a part and a part without mass.
    """
    upper = _mass(solutions)
    momentum = full(upper) @ rigid_modes(solutions.mesh.nodes)
    return _vibration(loose_solid(solutions, momentum, "vibration"), upper, count, prove)


def link_vibration(
    solutions: UnitSolutions, *, tilt_held: bool, count: int = 4, prove: bool = True
) -> Vibration:
    """Return the vibration of a part whose pins stand still, as buckling holds it.

    tilt_held  True if the forks hold the ends against tilting out of the plane
    """
    solid = link_solid(solutions, tilt_held=tilt_held, what="vibration")
    return _vibration(solid, _mass(solutions), count, prove)


def solid_vibration(solid: SupportedSolid, *, count: int = 4, prove: bool = True) -> Vibration:
    """Return the vibration of a supported solid."""
    _check_mass(solid.material.density)
    return _vibration(solid, mass(solid.pattern, solid.material.density), count, prove)


def _mass(solutions: UnitSolutions) -> "scipy.sparse.csr_array":
    _check_mass(solutions.material.density)
    return mass(solutions.pattern, solutions.material.density)


def _check_mass(density: float) -> None:
    if not density > 0:
        raise ValueError(f"frequencies need a density above 0 t/mm3, got {density}")


def _vibration(
    solid: SupportedSolid, upper: "scipy.sparse.csr_array", count: int, prove: bool
) -> Vibration:
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
