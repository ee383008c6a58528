"""The proof that no buckling mode of a frame was skipped: solvers that lose or invent one."""

import numpy as np
import pytest

from fem.solvers import SolverError
from tests.fem.buckled_frames import frame_buckling
from tests.fem.test_frame_buckling import EULER, column, held


def buckled(monkeypatch, change, count):
    """A hinged column of factors 1, 4, 9, ... whose eigenvalues (ascending 1/factor) are changed.

    The load is Euler's.
    """
    whole = np.linalg.eigh

    def changed(matrix):
        return change(*whole(matrix))

    frame = column(8)
    place = held(frame, "hinged", "hinged")
    monkeypatch.setattr(np.linalg, "eigh", changed)
    return frame_buckling(frame, np.full(8, -EULER), place, count=count).factors


def test_as_long_as_nothing_is_changed_the_factors_are_squares(monkeypatch):
    found = buckled(monkeypatch, lambda values, vectors: (values, vectors), 3)
    np.testing.assert_allclose(found, [1, 4, 9], rtol=5e-3)


@pytest.mark.parametrize(("lost", "count"), [(1, 1), (1, 3), (2, 3)])
def test_a_mode_that_the_solver_loses_is_missed_in_the_count(monkeypatch, lost, count):
    """The lowest of all below what is told as the first, or another one below the last."""

    def losing(values, vectors):
        return np.delete(values, -lost), np.delete(vectors, -lost, axis=1)

    with pytest.raises(SolverError, match="buckling modes of a frame stand below the factor"):
        buckled(monkeypatch, losing, count)


def test_a_mode_that_the_solver_invents_is_none_of_the_count(monkeypatch):
    """Half of Euler's load, under which nothing buckles."""

    def inventing(values, vectors):
        return np.append(values, 2 * values[-1]), vectors[:, [*range(len(values)), -1]]

    with pytest.raises(SolverError, match=r"0 buckling modes of a frame .* 1 were found"):
        buckled(monkeypatch, inventing, 1)


def test_a_factor_that_is_too_high_is_found_out_by_the_mode_below_it(monkeypatch):
    """The first is told as 2 instead of 1: as many modes are below it, but one is before it."""

    def halving(values, vectors):
        return np.append(values[:-1], values[-1] / 2), vectors

    with pytest.raises(SolverError, match=r"1 buckling modes of a frame .* 0 were found"):
        buckled(monkeypatch, halving, 1)
