"""Splines against SciPy's, which are of the same kind, and where they end."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import CubicSpline

from checks.part.part_loads import PartLoads
from checks.strength.sampling import Spline, finer


@pytest.mark.parametrize("count", [2, 3, 4, 5, 40])
@pytest.mark.parametrize("columns", [(), (3,)])
def test_values_and_derivatives_are_those_of_scipys_spline(count, columns):
    """Round-off of a well-conditioned system of three diagonals: 1e-13 of the largest."""
    chance = np.random.default_rng(count)
    places = np.cumsum(chance.uniform(0.1, 2.0, count))
    values = chance.normal(size=(count, *columns))
    asked = np.union1d(np.linspace(places[0], places[-1], 101), places)
    other, own = CubicSpline(places, values), Spline.through(places, values)
    for derivative in range(3):
        expected = other(asked, derivative)
        size = np.abs(expected).max() + np.abs(values).max()
        assert_allclose(own.at(asked, derivative), expected, rtol=0, atol=1e-13 * size)


def test_a_burst_of_close_positions_rings_in_no_long_step():
    """A force of 100 N that swings by 1 N within a thousandth of a step, and is even elsewhere.

    A spline through all of it has -2037 N half a step before.
    """
    burst = np.linspace(9.0, 9.001, 41)
    path = np.concatenate([np.arange(9.0), burst, np.arange(10.0, 19.0)])
    force = 100.0 + np.where((path >= 9.0) & (path <= 9.001), np.sin(4e3 * np.pi * path), 0.0)
    wrench = np.zeros((len(path), 6))
    wrench[:, 0] = force
    loads = PartLoads(
        {"bore": wrench}, np.zeros((len(path), 4)), {"turn": slice(0, len(path))},
        ("",) * len(path), ("turn",) * len(path), path=path,
    )  # fmt: skip
    found = finer(loads).between.wrenches["bore"][:, 0]
    assert 98.9 < found.min() < found.max() < 101.1
