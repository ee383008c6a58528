"""Factorisation: each solver, the order of the unknowns, and what is said of the choice."""

import gc
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.testing import assert_allclose

from fem.assembly import Elements, Pattern, full, stiffness
from fem.solvers import (
    SOLVERS,
    Factor,
    SolverError,
    chosen_solver,
    dissection,
    factorize,
    node_dissection,
    permuted,
)

from .blocks import block

INDEFINITE = sp.csr_array(np.triu([[2.0, 1.0, 0.0], [1.0, -3.0, 1.0], [0.0, 1.0, 4.0]]))
PACKAGES = {"CHOLMOD": "sksparse", "PARDISO": "pypardiso"}
ROOT = Path(__file__).parents[2]
SMALL = """
import numpy as np
from fem.assembly import Pattern, stiffness
from fem.assembly import Elements
from fem.solvers import factorize
from tests.fem.blocks import block
matrix = stiffness(Pattern(Elements(block((6, 3, 3), (12.0, 4.0, 4.0)))), 210e3, 0.3)
factor = factorize(matrix[147:][:, 147:].tocsr(), "PARDISO")
factor.solve(np.ones(matrix.shape[0] - 147))
from pypardiso import PyPardisoSolver
print(PyPardisoSolver().libmkl.MKL_Get_Max_Threads())
"""


@pytest.fixture(scope="module")
def upper():
    """Upper triangle of a block held on one face (its first nodes), so no longer in threes."""
    mesh = block((6, 3, 3), (12.0, 4.0, 4.0), distortion=0.2)
    matrix = stiffness(Pattern(Elements(mesh)), 210e3, 0.3)
    free = np.r_[2, 100, np.arange(147, matrix.shape[0])]
    return matrix[free][:, free].tocsr()


@pytest.fixture
def without(monkeypatch):
    """Makes packages impossible to import."""

    def hide(*names):
        for name in names:
            monkeypatch.setitem(sys.modules, name, None)

    return hide


def there(name):
    if name in PACKAGES:
        pytest.importorskip(PACKAGES[name])
    return name


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("columns", [(), (1,), (7,)])
def test_every_solver_solves_one_or_several_right_hand_sides(upper, name, columns):
    exact = np.random.default_rng(1).normal(size=(upper.shape[0], *columns))
    factor = factorize(upper, there(name))
    assert factor.solver == name
    right = full(upper) @ exact
    found, error = factor.solve(right)
    assert error < 1e-14
    assert found.shape == exact.shape
    assert_allclose(found, exact, rtol=0, atol=1e-9 * np.abs(exact).max())
    assert_allclose(factor.apply(right), exact, rtol=0, atol=1e-9 * np.abs(exact).max())


@pytest.mark.parametrize("name", SOLVERS)
def test_every_solver_refuses_an_indefinite_matrix(name):
    with pytest.raises(SolverError, match="not positive definite"):
        factorize(INDEFINITE, there(name))


@pytest.mark.parametrize("name", SOLVERS)
def test_a_factor_repeats_to_the_last_bit(upper, name):
    right = np.random.default_rng(2).normal(size=(upper.shape[0], 3))
    first, second = (factorize(upper, there(name)).solve(right)[0] for _ in range(2))
    assert np.array_equal(first, second)


def test_the_first_solver_that_is_there_is_taken_without_a_remark(upper):
    there("CHOLMOD")
    assert factorize(upper).solver == "CHOLMOD"


def test_without_cholmod_pardiso_takes_its_place(upper, without):
    there("PARDISO")
    without("sksparse")
    assert factorize(upper).solver == chosen_solver() == "PARDISO"


def test_without_both_superlu_solves_the_same(upper, without):
    right = np.linspace(-1, 1, upper.shape[0])
    expected, _ = factorize(upper).solve(right)
    without("sksparse", "pypardiso")
    factor = factorize(upper)
    assert factor.solver == chosen_solver() == "SuperLU"
    assert_allclose(factor.solve(right)[0], expected, atol=1e-9 * np.abs(expected).max(), rtol=0)


def test_a_solver_that_is_installed_and_broken_is_told_with_its_cause(upper, without, monkeypatch):
    def broken(*_):
        raise ImportError("libcholmod.so.3: cannot open shared object file")

    without("pypardiso")
    monkeypatch.setitem(SOLVERS, "CHOLMOD", broken)
    assert factorize(upper).solver == (
        "SuperLU (CHOLMOD cannot be loaded: libcholmod.so.3: cannot open shared object file)"
    )


@pytest.mark.parametrize(
    ("number", "words"), [(-2, "error code -2"), (-4, "not positive definite")]
)
def test_pardiso_tells_a_lack_of_memory_from_a_part_that_moves(upper, monkeypatch, number, words):
    there("PARDISO")
    from pypardiso import PyPardisoSolver
    from pypardiso.pardiso_wrapper import PyPardisoError

    def refuse(*_):
        raise PyPardisoError(number)

    monkeypatch.setattr(PyPardisoSolver, "factorize", refuse)
    with pytest.raises(SolverError, match=words) as told:
        factorize(upper, "PARDISO")
    assert ("positive definite" in str(told.value)) == (number == -4)


def test_pardiso_keeps_to_a_limit_of_threads_that_stands_in_the_environment():
    """MKL asks for as many threads as there are cores; refused them it told of no memory."""
    there("PARDISO")
    done = subprocess.run(
        [sys.executable, "-c", SMALL],
        env={**os.environ, "OMP_THREAD_LIMIT": "1", "OMP_NUM_THREADS": "2", "MKL_DYNAMIC": "false"},
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.stdout == "1\n", done.stderr


def test_without_both_an_indefinite_matrix_is_refused_too(without):
    without("sksparse", "pypardiso")
    with pytest.raises(SolverError, match="not positive definite"):
        factorize(INDEFINITE)


def test_a_named_solver_that_is_not_there_is_not_replaced(upper, without):
    without("sksparse")
    with pytest.raises(SolverError, match="CHOLMOD cannot be loaded"):
        factorize(upper, "CHOLMOD")


def test_a_solver_that_no_one_knows_is_refused(upper):
    with pytest.raises(ValueError, match="no solver is named 'LAPACK'; there are CHOLMOD"):
        factorize(upper, "LAPACK")


def test_the_memory_of_pardiso_goes_with_its_factor(upper, monkeypatch):
    there("PARDISO")
    freed = []
    from pypardiso import PyPardisoSolver

    keep = PyPardisoSolver.free_memory
    monkeypatch.setattr(
        PyPardisoSolver,
        "free_memory",
        lambda self, everything=False: (freed.append(everything), keep(self, everything)),
    )
    factor = factorize(upper, "PARDISO")
    factor.solve(np.ones(upper.shape[0]))
    assert not freed
    del factor
    gc.collect()
    assert freed == [True]


def test_the_matrix_is_left_as_it_was_given(upper):
    before = upper.copy()
    factorize(upper)
    assert np.array_equal(upper.indices, before.indices)
    assert np.array_equal(upper.data, before.data)


def test_indices_in_any_order_are_understood(upper):
    shuffled = sp.csr_array(upper)
    shuffled.data, shuffled.indices = shuffled.data.copy(), shuffled.indices.copy()
    for start, stop in zip(upper.indptr[:-1], upper.indptr[1:], strict=True):
        shuffled.indices[start:stop] = upper.indices[start:stop][::-1]
        shuffled.data[start:stop] = upper.data[start:stop][::-1]
    shuffled.has_sorted_indices = False
    right = np.ones(upper.shape[0])
    expected = factorize(upper).solve(right)[0]
    assert_allclose(factorize(shuffled).solve(right)[0], expected, rtol=1e-9)


def test_a_solution_that_is_wrong_is_refused_by_its_backward_error(upper):
    """A factor of another matrix: refinement does not mend it."""
    other = factorize((1.5 * upper).tocsr())
    with pytest.raises(SolverError, match="backward error"):
        Factor("wrong", upper, other.apply).solve(np.ones(upper.shape[0]))


def test_the_backward_error_is_that_of_the_whole_matrix(upper):
    """|r| / (|K| |x| + |b|) in largest-entry norms, of a solution off by 1e-7 of itself, of which
    one refinement leaves 1e-14.
    """
    whole = full(upper)
    exact = np.ones(upper.shape[0])
    right = whole @ exact
    good = factorize(upper)
    _, error = Factor("off", upper, lambda b: good.apply(b) * (1 + 1e-7)).solve(right)
    left = np.abs(right - whole @ (exact * (1 - 1e-14))).max()
    expected = left / (abs(whole).sum(axis=1).max() + np.abs(right).max())
    assert_allclose(error, expected, rtol=0.2)


def test_dissection_is_an_order_with_less_fill_than_that_of_the_nodes():
    """METIS on all nodes, and on corners alone, against the lattice order of 6 x 6 x 6 bricks."""
    cholmod = pytest.importorskip("sksparse.cholmod")
    mesh = block((6, 6, 6), (6.0, 6.0, 6.0))
    matrix = stiffness(Pattern(Elements(mesh)), 210e3, 0.3)[507:][:, 507:].tocsr()
    order = dissection(matrix, cholmod)
    assert np.array_equal(np.sort(order), np.arange(matrix.shape[0]))
    lower = permuted(matrix, order)
    whole = full(matrix)[order][:, order]
    assert abs(lower - sp.tril(whole)).max() == 0
    by_node = node_dissection(mesh.elements)
    assert np.array_equal(np.sort(by_node), np.arange(len(mesh.nodes)))
    by_corner = np.argsort(by_node[np.arange(507, 3 * len(by_node)) // 3], kind="stable")
    all_nodes, corners, lattice = (
        cholmod.cholesky(given, mode="supernodal", ordering_method="natural").L().nnz
        for given in (lower, permuted(matrix, by_corner), sp.csc_matrix(matrix.T))
    )
    assert all_nodes < 0.6 * lattice
    assert corners < 1.15 * all_nodes
