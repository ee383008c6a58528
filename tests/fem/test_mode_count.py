"""The count that proves that no mode was skipped, against dense eigenvalues of small solids."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from numpy.testing import assert_allclose

import fem.lowest_modes
from fem.assembly import full, geometric_stiffness
from fem.buckling import part_buckling
from fem.lowest_modes import mass
from fem.mode_count import LowRank, count_below, link_solid, shifted
from fem.recovery import tensor
from fem.solvers import SolverError
from fem.unit_solutions import Elastic, solve_unit_loads

from .blocks import block, wrench

STEEL = Elastic(210e3, 0.3, 7.85e-9)


@pytest.fixture(scope="module")
def column():
    """A square column of 120 mm, whose modes come in pairs."""
    return solve_unit_loads(block((6, 1, 1), (120.0, 8.0, 8.0)), STEEL)


@pytest.fixture(scope="module")
def state(column):
    ends = {"start": wrench(1000.0, 0.0, 300.0), "end": wrench(-1000.0, 0.0, -300.0)}
    return column.coefficients(ends, np.zeros((1, 4)))[0][:, 0]


@pytest.fixture(scope="module", params=[False, True])
def solid(column, request):
    return link_solid(column, tilt_held=request.param, what="buckling")


@pytest.fixture(scope="module")
def geometric(column, state):
    displacement = (column.displacement @ state)[:, None]
    stress = column.recovery.quadrature_stress(displacement, slice(None))[..., 0]
    upper = geometric_stiffness(column.pattern, tensor(stress))
    return replace_data(upper, -upper.data)


def replace_data(matrix, data):
    changed = matrix.copy()
    changed.data = data
    return changed


def dense_values(solid, matrix):
    """All positive values of K x = lambda B x on C x = 0, by LAPACK."""
    space = scipy.linalg.null_space(solid.rows)
    stiff, other = (space.T @ (full(m) @ space) for m in (solid.stiffness, matrix))
    inverse = scipy.linalg.eigh(other, stiff, eigvals_only=True)
    return np.sort(1 / inverse[inverse > 0])


def test_the_count_is_that_of_dense_eigenvalues_between_any_two_modes(solid, geometric):
    """Of a bent column, between each of the first 24 values; ends of pairs are told apart."""
    values = dense_values(solid, geometric)[:25]
    nothing = np.zeros((len(solid.rows[0]), 0))
    for number in range(25):
        below = values[number - 1] if number else 0.0
        if values[number] < 1.0001 * below:
            continue
        middle = (below + values[number]) / 2
        assert count_below(solid, geometric, middle, nothing) == number
    assert count_below(solid, geometric, 0.9999 * values[0], nothing) == 0


def test_the_count_does_not_believe_what_it_is_told(solid, geometric):
    """Fields that are no modes, as many as there are modes or more, change nothing."""
    values = dense_values(solid, geometric)
    false = np.random.default_rng(3).standard_normal((len(solid.rows[0]), 6))
    assert count_below(solid, geometric, (values[2] + values[3]) / 2, false) == 3


@pytest.mark.parametrize("signs", [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)])
def test_a_part_of_few_vectors_is_counted_and_found_with_the_matrix(solid, geometric, signs):
    """Of either sign, and large enough to move the values; without it they are others."""
    rng = np.random.default_rng(5)
    vectors = rng.standard_normal((len(solid.rows[0]), 2))
    vectors /= np.linalg.norm(vectors, axis=0)
    seen = np.abs(vectors.T @ (full(geometric) @ vectors)).max()
    more = LowRank(vectors, 40.0 * seen * np.array(signs))
    space = scipy.linalg.null_space(solid.rows)
    both = full(geometric).toarray() + vectors @ np.diag(more.weights) @ vectors.T
    stiff, other = (space.T @ (m @ space) for m in (full(solid.stiffness), both))
    inverse = scipy.linalg.eigh(other, stiff, eigvals_only=True)
    values = np.sort(1 / inverse[inverse > 0])[:12]
    assert np.abs(values / dense_values(solid, geometric)[:12] - 1).max() > 1e-3
    nothing = np.zeros((len(vectors), 0))
    for number in range(12):
        below = values[number - 1] if number else 0.0
        if values[number] > 1.0001 * below:
            middle = (below + values[number]) / 2
            assert count_below(solid, geometric, middle, nothing, more) == number
    assert_allclose(more.form(space), space.T @ more.times(space), rtol=1e-9, atol=1e-9 * seen)


def test_frequencies_are_counted_likewise(solid):
    matrix = mass(solid.pattern, STEEL.density)
    values = dense_values(solid, matrix)
    nothing = np.zeros((len(solid.rows[0]), 0))
    for number in (1, 6, 15):
        middle = (values[number - 1] + values[number]) / 2
        assert count_below(solid, matrix, middle, nothing) == number


def test_a_count_far_above_what_can_be_held_is_refused(solid):
    """Above half of all values no few held nodes leave a definite matrix."""
    matrix = mass(solid.pattern, STEEL.density)
    high = float(np.median(dense_values(solid, matrix)))
    with pytest.raises(SolverError, match="cannot be counted"):
        count_below(solid, matrix, high, np.zeros((len(solid.rows[0]), 0)))


def test_the_modes_are_those_of_dense_eigenvalues(column, state, solid, geometric):
    """Round-off of LAPACK on a reduced matrix is what is left: cond(K) eps, 1e-9."""
    tilt_held = len(solid.rows) == 9  # three more than with hinged ends
    found = part_buckling(column, state, tilt_held=tilt_held, count=6)
    dense = dense_values(solid, geometric)
    np.testing.assert_allclose([m.factor for m in found.modes], dense[:6], rtol=1e-9)
    assert dense[5] < found.proven
    assert (dense < found.proven).sum() == 6


def test_a_search_that_skips_a_mode_is_found_out_and_searches_again(column, state, monkeypatch):
    """The first search is made to lose its lowest mode, as a poor start would."""
    right = part_buckling(column, state, tilt_held=False, count=2)
    whole, calls = fem.lowest_modes._search, []

    def losing(*arguments):
        calls.append(arguments)
        found = whole(*arguments)
        return replace(found, shapes=found.shapes[:, 1:]) if len(calls) == 1 else found

    monkeypatch.setattr(fem.lowest_modes, "_search", losing)
    found = part_buckling(column, state, tilt_held=False, count=2)
    assert len(calls) == 2
    np.testing.assert_allclose(
        [m.factor for m in found.modes], [m.factor for m in right.modes], rtol=1e-9
    )


def test_a_search_that_goes_on_skipping_is_an_error_and_no_result(column, state, monkeypatch):
    whole = fem.lowest_modes._search

    def losing(*arguments):
        found = whole(*arguments)
        return replace(found, shapes=found.shapes[:, 1:])

    monkeypatch.setattr(fem.lowest_modes, "_search", losing)
    with pytest.raises(SolverError, match=r"2 modes lie below .*, but only 1 were found"):
        part_buckling(column, state, tilt_held=False, count=2)


def test_matrices_of_other_patterns_are_refused(solid):
    other = solid.stiffness[:, ::-1].tocsr()
    with pytest.raises(ValueError, match="same pattern"):
        shifted(solid, other, 1.0)


def test_where_modes_are_missed_a_count_may_still_prove_a_lower_bound(column, state, monkeypatch):
    """The search loses the lowest mode of a column: the count proves none below half the next."""
    known = part_buckling(column, state, tilt_held=False, count=3).modes
    whole = fem.lowest_modes._search

    def losing(*arguments):
        found = whole(*arguments)
        return replace(found, shapes=found.shapes[:, 1:])

    monkeypatch.setattr(fem.lowest_modes, "_search", losing)
    found = part_buckling(column, state, tilt_held=False, count=2, weaker=True)
    assert 0 < found.proven < known[0].factor


def test_where_no_count_can_be_made_at_a_mode_one_lower_down_is_tried(column, state, monkeypatch):
    """Counts fail above half of the lowest factor: none is below that, and no more is said."""
    known = part_buckling(column, state, tilt_held=False, count=1).modes[0]
    count, values = fem.lowest_modes.count_below, []

    def failing(solid, matrix, value, *rest):
        values.append(value)
        if value > 0.51 * values[0]:
            raise SolverError("cannot be counted")
        return count(solid, matrix, value, *rest)

    monkeypatch.setattr(fem.lowest_modes, "count_below", failing)
    with pytest.raises(SolverError, match="cannot be counted"):
        part_buckling(column, state, tilt_held=False, count=1)
    values.clear()
    found = part_buckling(column, state, tilt_held=False, count=1, weaker=True)
    assert found.modes[0].factor == pytest.approx(known.factor, rel=1e-9)
    assert found.proven == pytest.approx(known.factor / 2, rel=1e-6)
