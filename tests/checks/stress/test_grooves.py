"""Errors in notches count what acts across a groove, not along it."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.stress.solid_mesh_level import Level
from fem.stress_history import StressHistory

ALONG, ACROSS, SHEAR = ([row] for row in np.eye(6)[[0, 1, 3]].tolist())


def share(basis, coefficients, across=(0.0, 1.0, 0.0), runs=None):
    """Of one point, stress (m, 6) by coefficients (m, n), and the paths of its duty."""
    basis = np.array(basis).T[None]
    history = StressHistory(np.arange(1), np.zeros((1, 3)), basis, np.array(coefficients))
    duty = SimpleNamespace(runs=runs or {"turn": np.arange(history.coefficients.shape[1])})
    level = SimpleNamespace(history=history, duty=duty)
    found = Level._share_across(level, np.arange(1), np.array([across]))
    return float(found[0])


@pytest.mark.parametrize(
    ("stress", "wanted"),
    [(ALONG, 0.0), (ACROSS, 1.0), (SHEAR, 1.0)],
    ids=["along", "across", "shear"],
)
def test_stress_along_a_groove_is_not_missed(stress, wanted):
    assert share(stress, [[80.0, -20.0]]) == pytest.approx(wanted, abs=1e-12)


def test_both_together_by_their_share_of_von_mises_stress():
    """100 along and 10 across: 10 of sqrt(100^2 - 1000 + 10^2), times 2 over the root of 3."""
    found = share([*ALONG, *ACROSS], [[100.0, 0.0], [10.0, 0.0]])
    assert_allclose(found, 2 / np.sqrt(3) * 10 / np.sqrt(9100.0), rtol=1e-3)


@pytest.mark.parametrize(("across", "wanted"), [(35.0, 0.4598), (40.0, 1.0)])
def test_from_half_of_the_stress_across_on_all_of_it_counts(across, wanted):
    """Of 100 along: 2/root 3 35/root(10 000 - 3500 + 1225) = 0.46, and 0.53 of 40."""
    found = share([*ALONG, *ACROSS], [[100.0, 0.0], [across, 0.0]])
    assert_allclose(found, wanted, rtol=1e-3)


def test_a_swing_across_counts_beside_a_steady_stress_along():
    assert share([*ALONG, *ACROSS], [[100.0, 100.0], [5.0, -5.0]]) == 1.0


def test_a_swing_across_counts_beside_a_larger_stress_along_of_another_cycle():
    """An overload of 200 along, which is in no duty or is rare; a cycle of +-40 across."""
    states = [[200.0, 0.0, 0.0, 0.0], [0.0, 0.0, 40.0, -40.0]]
    turn, every = np.array([2, 3]), np.arange(4)
    for runs in ({"turn": turn}, {"turn": turn, "between cycles": every}):
        assert share([*ALONG, *ACROSS], states, runs=runs) == 1.0
    assert share([*ALONG, *ACROSS], states, runs={"overload": np.array([0, 1])}) < 0.5


def test_a_steady_stress_along_has_no_swing_that_counts():
    assert share(ALONG, [[80.0, 80.0]]) == pytest.approx(0.0, abs=1e-12)


def test_where_no_groove_is_all_counts():
    assert share(ALONG, [[80.0, -20.0]], across=(0.0, 0.0, 0.0)) == 1.0
