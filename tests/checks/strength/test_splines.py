"""Splines against SciPy's, which are of the same kind."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import CubicSpline

from checks.strength.sampling import Spline


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
