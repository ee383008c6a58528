"""Sparse direct solvers, best first; every solution's residual is checked."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from geometry.mesh import FloatArray

BACKWARD_LIMIT = 1e-12


class SolverError(RuntimeError):
    """The linear equations could not be solved to a trustworthy residual."""


@dataclass(frozen=True, eq=False)
class Factor:
    """A factorised symmetric positive definite matrix.

    solver  name of the method, with what it replaced if the first choice is not there
    """

    solver: str
    _matrix: sp.csr_array
    _apply: Callable[[FloatArray], FloatArray]

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
        residual = right - self._matrix @ solution
        worst = self._backward(residual, solution, right)
        if not worst < 1e-15:
            solution = solution + self._apply(residual)
            worst = self._backward(right - self._matrix @ solution, solution, right)
        if not worst < BACKWARD_LIMIT:
            raise SolverError(
                f"backward error {worst:.1e} after refinement ({self.solver}), limit "
                f"{BACKWARD_LIMIT:.0e}: the part may be a mechanism or badly scaled"
            )
        return solution, worst

    @cached_property
    def _norm(self) -> float:
        return float(abs(self._matrix).sum(axis=1).max())

    def _backward(self, residual: FloatArray, solution: FloatArray, right: FloatArray) -> float:
        def sizes(values: FloatArray) -> FloatArray:
            return np.asarray(np.abs(values).max(axis=0, initial=0.0))

        scale = self._norm * sizes(solution) + sizes(right)
        return float(np.max(sizes(residual) / np.where(scale > 0, scale, 1.0), initial=0.0))


def factorize(upper: sp.csr_array) -> Factor:
    """Factorise the symmetric positive definite matrix whose upper triangle is given.

    CHOLMOD if scikit-sparse is there, else SciPy's SuperLU, about ten times slower; the factor's
    name says which. Raises SolverError if the matrix is not positive definite.
    """
    whole = (upper + sp.triu(upper, k=1).T).tocsr()
    try:
        from sksparse import cholmod
    except ImportError:
        from scipy.sparse.linalg import splu

        lu = splu(
            whole.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,  # pivots stay on the diagonal, so their signs are the matrix's
            options={"SymmetricMode": True},
        )
        if not np.array_equal(lu.perm_r, lu.perm_c) or not lu.U.diagonal().min() > 0:
            raise SolverError("the stiffness matrix is not positive definite") from None
        return Factor("SuperLU (scikit-sparse is not installed: slow)", whole, lu.solve)
    try:
        cholesky = cholmod.cholesky(sp.csc_matrix(upper.T), mode="supernodal")
    except cholmod.CholmodError as error:
        raise SolverError(f"the stiffness matrix is not positive definite: {error}") from error
    return Factor("CHOLMOD", whole, cholesky)
