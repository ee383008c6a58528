"""Sparse direct solvers, best first; every solution's residual is checked."""

import os
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from fem.threads import LARGE, threads_for
from geometry.mesh import FloatArray, IntArray

BACKWARD_LIMIT = 1e-12
_INDEFINITE = "the stiffness matrix is not positive definite"
_ZERO_PIVOT = -4  # PARDISO's word for the same

Apply = Callable[[FloatArray], FloatArray]


class SolverError(RuntimeError):
    """The linear equations could not be solved to a trustworthy residual."""


@dataclass(frozen=True, eq=False)
class Factor:
    """A factorised symmetric positive definite matrix.

    solver  name of the method, with why not those before it where they are installed and broken
    """

    solver: str
    _upper: "scipy.sparse.csr_array"
    _apply: Apply

    def apply(self, right: FloatArray) -> FloatArray:
        """Solution without a check, for use inside an iteration that checks its own result."""
        return self._apply(right)

    def solve(self, right: FloatArray) -> tuple[FloatArray, float]:
        """Solution for right-hand sides (n,) or (n, m), and the largest backward error.

        The normwise backward error |r| / (|K| |x| + |b|), in largest-entry norms (Rigal and Gaches
        1967; Higham, Accuracy and Stability, theorem 7.1), tells a bad solution from a slender
        part: the plain residual |r| / |b| grows with the condition of K although nothing is wrong.
        One step of refinement follows where it asks for it. Raises SolverError above 1e-12.
        """
        solution = self._apply(right)
        residual = right - self._times(solution)
        worst = self._backward(residual, solution, right)
        if not worst < 1e-15:
            solution = solution + self._apply(residual)
            worst = self._backward(right - self._times(solution), solution, right)
        if not worst < BACKWARD_LIMIT:
            raise SolverError(
                f"backward error {worst:.1e} after refinement ({self.solver}), limit "
                f"{BACKWARD_LIMIT:.0e}: the part may be a mechanism or badly scaled"
            )
        return solution, worst

    @cached_property
    def _norm(self) -> float:
        sizes = abs(self._upper)
        sums = sizes.sum(axis=0) + sizes.sum(axis=1) - sizes.diagonal()
        return float(sums.max())

    def _times(self, values: FloatArray) -> FloatArray:
        """The whole matrix times a vector or several, without forming it."""
        diagonal = self._upper.diagonal()
        product = self._upper @ values
        product += self._upper.T @ values
        product -= (values.T * diagonal).T
        return np.asarray(product)

    def _backward(self, residual: FloatArray, solution: FloatArray, right: FloatArray) -> float:
        def sizes(values: FloatArray) -> FloatArray:
            return np.asarray(np.abs(values).max(axis=0, initial=0.0))

        scale = self._norm * sizes(solution) + sizes(right)
        return float(np.max(sizes(residual) / np.where(scale > 0, scale, 1.0), initial=0.0))


def factorize(
    upper: "scipy.sparse.csr_array", solver: str | None = None, *, place: IntArray | None = None
) -> Factor:
    """Factorise the symmetric positive definite matrix whose upper triangle is given.

    solver  one of SOLVERS; without it the first that can be loaded
    place   (n,) where each unknown stands in a good order of elimination, if it is known already;
            for CHOLMOD, equal places in the order of the unknowns

    CHOLMOD if scikit-sparse is there, else PARDISO if pypardiso is, else SciPy's SuperLU, which
    takes many times the time and the memory; the factor's name says which, and what is installed
    and cannot be loaded. Raises SolverError if the matrix is not positive definite or the named
    solver cannot be loaded.
    """
    if solver is not None and solver not in SOLVERS:
        raise ValueError(f"no solver is named {solver!r}; there are {', '.join(SOLVERS)}")
    upper = scipy.sparse.csr_array(upper)
    upper.sort_indices()
    broken = []
    for name in SOLVERS if solver is None else (solver,):
        try:
            apply = SOLVERS[name](upper, place)
        except ImportError as error:
            if solver is not None or not isinstance(error, ModuleNotFoundError):
                broken.append(f"{name} cannot be loaded: {error}")
        else:
            if upper.shape[0] >= LARGE:
                apply = _threaded(apply, upper.shape[0])
            return Factor(f"{name} ({'; '.join(broken)})" if broken else name, upper, apply)
    raise SolverError("; ".join(broken))


def chosen_solver() -> str:
    """Name of the solver that `factorize` takes here, as a factor tells it."""
    return factorize(scipy.sparse.csr_array([[1.0]])).solver


def chosen_fill() -> float:
    """Memory of the factor by `chosen_solver` over the memory of CHOLMOD's factor."""
    return _FILL.get(chosen_solver().partition(" ")[0], 1.0)


def _threaded(apply: Apply, unknowns: int) -> Apply:
    def threaded(right: FloatArray) -> FloatArray:
        with threads_for(unknowns):
            return apply(right)

    return threaded


def _cholmod(upper: "scipy.sparse.csr_array", place: IntArray | None) -> Apply:
    from sksparse import cholmod

    order = dissection(upper, cholmod) if place is None else np.argsort(place, kind="stable")
    try:
        with threads_for(len(order), team=False):
            factor = cholmod.cholesky(
                permuted(upper, order), mode="supernodal", ordering_method="natural"
            )
    except cholmod.CholmodError as error:
        raise SolverError(f"{_INDEFINITE}: {error}") from error

    def apply(right: FloatArray) -> FloatArray:
        solution = np.empty(right.shape)
        solution[order] = factor(right[order])
        return solution

    return apply


def _pardiso(upper: "scipy.sparse.csr_array", _: IntArray | None) -> Apply:
    from pypardiso import PyPardisoSolver
    from pypardiso.pardiso_wrapper import PyPardisoError

    # a matrix of type 2 is symmetric positive definite and given by its upper triangle
    solver = PyPardisoSolver(mtype=2)
    os.environ.setdefault("PYPARDISO_MKL_RT", solver.libmkl._name)  # else 70 ms of search each time
    if os.environ.get("OMP_THREAD_LIMIT", "").isdecimal():
        # asking for more it is refused a team, and says that there is no memory (error -2)
        most = int(os.environ["OMP_THREAD_LIMIT"])
        solver.libmkl.MKL_Set_Num_Threads(min(most, solver.libmkl.MKL_Get_Max_Threads()))
    try:
        with threads_for(upper.shape[0]):
            solver.factorize(upper)
    except PyPardisoError as error:
        solver.free_memory(everything=True)
        cause = f"{_INDEFINITE}: " if error.value == _ZERO_PIVOT else ""
        raise SolverError(f"{cause}{error}") from error

    def apply(right: FloatArray) -> FloatArray:
        return np.asarray(solver.solve(upper, right))

    # MKL keeps the factor outside of Python's memory
    weakref.finalize(apply, solver.free_memory, everything=True)
    return apply


def _superlu(upper: "scipy.sparse.csr_array", _: IntArray | None) -> Apply:
    from scipy.sparse.linalg import splu

    lu = splu(
        (upper + scipy.sparse.triu(upper, k=1).T).tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,  # pivots stay on the diagonal, so their signs are the matrix's
        options={"SymmetricMode": True},
    )
    if not np.array_equal(lu.perm_r, lu.perm_c) or not lu.U.diagonal().min() > 0:
        raise SolverError(_INDEFINITE)

    def apply(right: FloatArray) -> FloatArray:
        return np.asarray(lu.solve(right))

    return apply


# The best first: time of factorisation and solves, measured in bench/solid.py.
SOLVERS: dict[str, Callable[["scipy.sparse.csr_array", IntArray | None], Apply]] = {
    "CHOLMOD": _cholmod,
    "PARDISO": _pardiso,
    "SuperLU": _superlu,
}
# Memory of the factor over CHOLMOD's, on cubes of 14 000 to 86 000 unknowns (SuperLU: 5.4 to 7.1).
_FILL = {"SuperLU": 7.0}


# The order in which CHOLMOD eliminates unknowns: nested dissection of the mesh's nodes.
#
# The three unknowns of a node are coupled to the same others, so a graph with one vertex for them
# is dissected (METIS) in a third of the time that the graph of all unknowns takes, with no more
# fill.

# Corners of the edges that the nodes 4 to 9 of a tetrahedron lie on.
_EDGES = np.array([(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)])


def dissection(upper: "scipy.sparse.csr_array", cholmod: Any) -> IntArray:
    """Order (n,) in which the unknowns of a matrix, given its upper triangle, are eliminated.

    cholmod  scikit-sparse's module, which reaches METIS

    Any order gives a right solution; a good one saves time and memory.
    """
    first, group = _groups(upper)
    graph = upper[first][:, first]
    graph.data = np.ones_like(graph.data)
    graph = scipy.sparse.csc_matrix(graph.T)
    place = np.argsort(cholmod.analyze(graph, mode="supernodal", ordering_method="metis").P())
    return np.argsort(place[group], kind="stable").astype(np.int64)


def node_dissection(elements: IntArray) -> IntArray | None:
    """Place (n_nodes,) of each node in the order of elimination, None without CHOLMOD.

    elements  (n, 10) nodes of a mesh of ten-node tetrahedra, in gmsh's order

    Only the graph of corners is dissected, an eighth of the work. A separator of corners and of the
    edges between them separates all nodes; so a node on an edge is eliminated right before the
    first of the edge's corners. On 57 000 nodes that takes 0.07 s instead of 0.5 s, and the factor
    0.2 s more.
    """
    try:
        from sksparse import cholmod
    except ImportError:
        return None
    corners, numbers = np.unique(elements[:, :4], return_inverse=True)
    of_element = numbers.reshape(-1, 4)
    first, second = of_element[:, _EDGES[:, 0]], of_element[:, _EDGES[:, 1]]
    low, high = np.minimum(first, second).ravel(), np.maximum(first, second).ravel()
    joined = np.unique(low.astype(np.int64) * len(corners) + high)
    low, high = joined // len(corners), joined % len(corners)
    graph = scipy.sparse.csc_matrix((np.ones(len(joined)), (high, low)), shape=2 * (len(corners),))
    of_corner = np.argsort(cholmod.analyze(graph, mode="supernodal", ordering_method="metis").P())
    place = np.zeros(int(elements.max()) + 1)
    place[corners] = of_corner + 0.5
    place[elements[:, 4:]] = np.minimum(of_corner[first], of_corner[second])
    return np.argsort(np.argsort(place, kind="stable"))


def permuted(upper: "scipy.sparse.csr_array", order: IntArray) -> "scipy.sparse.csc_matrix":
    """Lower triangle of the symmetric matrix whose upper triangle is given, in another order.

    The rows of a column are in no order: CHOLMOD needs none, and sorting took longer than the rest.
    """
    place = np.empty(len(order), dtype=np.int32)
    place[order] = np.arange(len(order), dtype=np.int32)
    rows = np.repeat(place, np.diff(upper.indptr))
    columns = place[upper.indices]
    low, high = np.minimum(rows, columns), np.maximum(rows, columns)
    above = scipy.sparse.coo_array((upper.data, (low, high)), shape=upper.shape)
    above.has_canonical_format = True  # a matrix without duplicates leaves none
    above = above.tocsr()
    return scipy.sparse.csc_matrix((above.data, above.indices, above.indptr), shape=upper.shape)


def _groups(upper: "scipy.sparse.csr_array") -> tuple[IntArray, IntArray]:
    """One unknown (n_groups,) of each set coupled to the same unknowns, and the set (n,) of each.

    Sets are told apart by a sum of random numbers over the unknowns that each one is coupled to:
    two that are not equal meet with a probability of 2**-64 per pair, and would only cost time.
    """
    n = upper.shape[0]
    ones = scipy.sparse.csr_array(
        (np.ones(upper.nnz, np.uint64), upper.indices, upper.indptr), upper.shape
    )
    random = np.random.default_rng(0).integers(2**64, size=n, dtype=np.uint64)
    mark = ones @ random + ones.T @ random - random
    _, first, group = np.unique(mark, return_index=True, return_inverse=True)
    order = np.argsort(first)  # in the order of the nodes
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return first[order].astype(np.int64), place[group].astype(np.int64)
