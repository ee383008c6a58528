"""The shear below a line contact against the integral of its pressure."""

from math import pi

import numpy as np
from numpy.testing import assert_allclose
from scipy.integrate import quad

from checks.by_formula.slot_pressure import _DEEP, _SHEARED, FIRST_YIELD


def below_a_line(depth):
    """Stress per p0 under an elliptic line pressure of half width 1, from Flamant's line forces."""

    def stress(power):
        def share(x):
            pressure = np.sqrt(1 - x**2)
            r = x * x + depth * depth
            return 2 / pi * pressure * depth * x**power * depth ** (2 - power) / r**2

        return quad(share, -1.0, 1.0, epsabs=1e-12)[0]

    return stress(0), stress(2)  # along z, across


def test_the_shear_below_a_line_is_the_largest_that_the_pressure_makes():
    """Flamant's solution integrated over the pressure, at depths on both sides of the largest.

    FE-20 has six digits of the size, and of the depth over the half width.
    """
    shears = []
    for depth in _DEEP * np.array([0.98, 1.0, 1.02]):
        along, across = below_a_line(depth)
        shears.append((along - across) / 2)
    assert_allclose(shears[1], _SHEARED, rtol=1e-8)
    assert shears[1] > max(shears[0], shears[2])
    assert_allclose((_SHEARED, _DEEP), (0.300283, 0.786152), rtol=2e-6)
    assert_allclose(FIRST_YIELD * _SHEARED, 0.5, rtol=2e-6)
