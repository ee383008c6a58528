"""The lowest modes of K x = lambda B x where a solid's supports hold, refined and counted.

Natural frequencies of a solid are those of K x = omega^2 M x with the consistent mass matrix
(docs/theory/vibration.md).

Block Lanczos steps u = K^-1 B x with full orthogonalisation in the inner product of K find the
largest 1 / lambda of both signs; a random block keeps modes of equal value apart. K appears in no
product: of every vector the force that gives it is kept beside it. The last step is one inverse
iteration and a Rayleigh-Ritz step with energies summed at the integration points. Their round-off
grows with the slenderness; the round-off of x' K x grows with its square or worse.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from fem.assembly import Pattern, full
from fem.mode_count import (
    LowRank,
    SupportedSolid,
    count_below,
    elastic_and_geometric_energy,
    link_solid,
)
from fem.solvers import SolverError
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray

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

Times = Callable[[FloatArray], FloatArray]
Energies = Callable[[FloatArray], tuple[FloatArray, FloatArray]]


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


def link_vibration(
    solutions: UnitSolutions,
    *,
    tilt_held: bool,
    twist_held_at: str | None = None,
    count: int = 4,
) -> Vibration:
    """Return the vibration of a part whose pins stand still, as buckling holds it.

    tilt_held, twist_held_at  as `link_solid` has them

    Raises SolverError if the modes do not converge or cannot be proven, ValueError for a stack of
    tied bodies, half of a part and a part without mass.
    """
    solid = link_solid(
        solutions, tilt_held=tilt_held, twist_held_at=twist_held_at, what="vibration"
    )
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
