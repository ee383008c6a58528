"""Roots between two places, against those known exactly."""

from math import cos, exp, log, tan

import pytest
from numpy.testing import assert_allclose

from geometry.roots import root


@pytest.mark.parametrize(
    ("function", "low", "high", "expected"),
    [
        (lambda x: x - 0.3, 0.0, 1.0, 0.3),
        (lambda x: 2 - x, 0.0, 5.0, 2.0),  # falls
        (lambda x: x**9 - 1e-3, 0.0, 1.0, 1e-3 ** (1 / 9)),
        (lambda x: exp(50 * x) - 2, 0.0, 1.0, log(2) / 50),
        (lambda x: 1 / (1 - x) - 1e6, 0.0, 1 - 1e-12, 1 - 1e-6),  # beside a pole
        (lambda x: cos(x) - x, 0.0, 1.0, 0.7390851332151607),
        (lambda x: tan(x) - 1, 0.5, 1.57, 0.7853981633974483),
        (lambda x: x, 0.0, 1.0, 0.0),  # at an end
    ],
)
def test_a_root_is_found_to_its_share(function, low, high, expected):
    assert_allclose(root(function, low, high, 1e-13), expected, rtol=3e-13, atol=0)


def test_a_function_of_one_sign_is_refused():
    with pytest.raises(ValueError, match="no root between 1 and 2: 1 and 4 there"):
        root(lambda x: x * x, 1.0, 2.0, 1e-13)
