"""Hertz contact against closed forms and against the pressure's own integral."""

from math import inf, pi

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

from checks.by_formula.slot_pressure import HertzBody, HertzError, line_contact

STEEL = (210e3, 0.3)
FLAT = HertzBody(inf, *STEEL)


def steel(radius):
    return HertzBody(radius, *STEEL)


def test_a_roller_on_a_flat_has_the_width_and_pressure_of_hertz():
    """FE-20, line: R = 10 mm, 100 N/mm; ten digits of the closed form, six of the shear's."""
    found = line_contact(100.0, steel(10.0), FLAT)
    assert_allclose(found.half_width, 0.1050463837, rtol=1e-9)
    assert_allclose(found.peak_pressure, 606.0368288, rtol=1e-9)
    assert_allclose(found.shear / found.peak_pressure, 0.300283, rtol=2e-6)
    assert_allclose(found.shear_depth / found.half_width, 0.786152, rtol=1e-6)


def below_a_line(depth, half):
    """Stress per p0 under an elliptic line pressure, from Flamant's line forces."""

    def stress(power):
        def share(x):
            pressure = np.sqrt(1 - (x / half) ** 2)
            r = x * x + depth * depth
            return 2 / pi * pressure * depth * x**power * depth ** (2 - power) / r**2

        return quad(share, -half, half, epsabs=1e-12)[0]

    return stress(0), stress(2)  # along z, across


def test_the_shear_below_a_line_is_the_largest_that_the_pressure_makes():
    """Flamant's solution integrated over the pressure, at depths on both sides of the largest."""
    found = line_contact(100.0, steel(10.0), FLAT)
    b = found.half_width
    shears = []
    for depth in found.shear_depth * np.array([0.98, 1.0, 1.02]):
        along, across = below_a_line(depth, b)
        shears.append((along - across) / 2 * found.peak_pressure)
    assert_allclose(shears[1], found.shear, rtol=1e-8)
    assert shears[1] > max(shears[0], shears[2])


def test_the_pressure_carries_the_force():
    """Elliptic pressure: pi b p0 / 2 per length."""
    line = line_contact(70.0, steel(8.0), steel(30.0))
    assert_allclose(pi / 2 * line.half_width * line.peak_pressure, 70.0, rtol=1e-14)


def test_a_pin_in_a_groove_is_as_wide_as_one_of_the_relative_radius_on_a_flat():
    """1/R = 1/10 - 1/30 = 1/15; either order."""
    wide = line_contact(50.0, steel(10.0), steel(-30.0))
    same = line_contact(50.0, steel(15.0), FLAT)
    assert_allclose(wide.half_width, same.half_width, rtol=1e-14)
    assert_allclose(line_contact(50.0, steel(-30.0), steel(10.0)).shear, wide.shear, rtol=1e-14)
    assert line_contact(50.0, steel(10.0), steel(30.0)).half_width < wide.half_width


def test_a_softer_body_spreads_the_contact():
    """Bronze on steel: E* by 1/E* = sum (1 - nu^2)/E; b ~ E*^-1/2."""
    bronze = HertzBody(inf, 105e3, 0.34)
    one, two = line_contact(100.0, steel(10.0), FLAT), line_contact(100.0, steel(10.0), bronze)
    steel_part, bronze_part = 0.91 / 210e3, (1 - 0.34**2) / 105e3
    wanted = np.sqrt((steel_part + bronze_part) / (2 * steel_part))
    assert_allclose(two.half_width / one.half_width, wanted, rtol=1e-12)


@pytest.mark.parametrize(
    ("first", "second", "says"),
    [
        (steel(10.0), steel(-10.0), "fit each other"),
        (steel(10.0), steel(-10.0 * (1 + 1e-9)), "fit each other"),
        (steel(10.0), steel(-9.0), "cannot touch"),
        (FLAT, FLAT, "two flats"),
    ],
)
def test_bodies_that_fit_each_other_are_refused(first, second, says):
    with pytest.raises(HertzError, match=says):
        line_contact(100.0, first, second)


def test_a_contact_as_wide_as_its_radius_is_refused():
    """A close pin: 0.01 mm of clearance on 20 mm under 2000 N/mm."""
    with pytest.raises(HertzError, match="not small against a radius of 10 mm"):
        line_contact(2000.0, steel(10.0), steel(-10.005))


@pytest.mark.parametrize("force", [0.0, -1.0, inf, float("nan")])
def test_a_contact_without_force_is_refused(force):
    with pytest.raises(HertzError, match="above 0 N/mm"):
        line_contact(force, steel(10.0), FLAT)


@pytest.mark.parametrize(
    ("given", "says"),
    [((0.0, 1e5, 0.3), "radius"), ((10.0, 0.0, 0.3), "Young"), ((10.0, 1e5, 0.6), "Poisson")],
)
def test_bodies_that_cannot_be_are_refused(given, says):
    with pytest.raises(HertzError, match=says):
        HertzBody(*given)
