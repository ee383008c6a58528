"""Formulas of pin joints."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bench.closed_forms import lug_factor
from checks.handbook.pin_diagrams import (
    round_bending,
    round_shear,
    round_torsion,
)
from geometry.parts.tube_rod import ball_ligament


def test_the_ligament_of_an_eye_is_the_area_between_its_circle_and_the_hole():
    """R = 20, w = 24, r = 8: numerically by the trapezoidal rule on 1e5 strips, 1e-8."""
    z = np.linspace(-12, 12, 100_001)
    wanted = np.trapezoid(np.sqrt(400 - z**2) - 8, z)
    assert_allclose(ball_ligament(40.0, 24.0, 16.0), wanted, rtol=1e-8)


def test_the_lug_factor_is_petersons_fit_and_ends_where_the_fit_does():
    """12.882 - 52.714 u + 89.762 u^2 - 51.667 u^3 at u = 0.3."""
    by_hand = 12.882 - 52.714 * 0.3 + 89.762 * 0.09 - 51.667 * 0.027
    assert_allclose(lug_factor(30.0, 100.0), by_hand, rtol=1e-12)
    assert lug_factor(14.0, 100.0) is None
    assert lug_factor(76.0, 100.0) is None


@pytest.mark.parametrize("diameter", [10.0, 40.0])
def test_a_round_bars_stresses_are_moment_and_force_over_its_section(diameter):
    """I = pi d^4 / 64, J = 2 I, A = pi d^2 / 4, and Q = d^3 / 12 of the half circle (Jourawski)."""
    second, first, breadth = np.pi * diameter**4 / 64, diameter**3 / 12, diameter
    assert_allclose(round_bending(np.array(1e5), np.array(diameter)), 1e5 * diameter / 2 / second)
    assert_allclose(round_shear(np.array(1e4), np.array(diameter)), 1e4 * first / second / breadth)
    assert_allclose(round_torsion(np.array(1e5), np.array(diameter)), 1e5 * diameter / 4 / second)
