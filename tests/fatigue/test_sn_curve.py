"""S-N curves: textbook lines, the knee, and what cannot be."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fatigue import SNCurve, basquin_curve, endurance_limit, low_cycle_fraction

KNEE = SNCurve(knee_amplitude=100.0, knee_cycles=1e6, slope=5.0)


def test_a_notched_rotating_shaft_lives_as_long_as_in_the_book():
    """FT-03: Shigley, 9th ed., ex. 6-9; the book rounds to 68 000 cycles.

    Life goes with stress to the power 7.6, and the case gives ten digits: 1e-8.
    """
    limit = endurance_limit(690.0, "machined", equivalent_diameter=32.0).value
    assert limit == pytest.approx(236.0580212, rel=1e-9)
    notch_factor = 1.0 + (1.65 - 1.0) / (1.0 + 0.313 / np.sqrt(3.0))
    assert notch_factor == pytest.approx(1.550515919, rel=1e-9)
    moment = 6.8e3 * 225.0 / 550.0 * 250.0
    stress = notch_factor * moment / (np.pi * 32.0**3 / 32.0)
    assert stress == pytest.approx(335.1931618, rel=1e-9)
    life = basquin_curve(690.0, limit, 0.844).cycles_to_failure(stress)
    assert life == pytest.approx(68412.09631, rel=1e-8)


def test_the_line_of_the_overstress_example_has_the_constants_of_the_book():
    """FT-06 (kpsi): a = 129.6, b = -0.08509083503, N(60) = 8522.159176."""
    curve = basquin_curve(80.0, 40.0, 0.9)
    assert -1.0 / curve.slope == pytest.approx(-0.08509083503, rel=1e-9)
    at_one_cycle = curve.knee_amplitude * curve.knee_cycles ** (1.0 / curve.slope)
    assert at_one_cycle == pytest.approx(129.6, rel=1e-9)
    assert curve.cycles_to_failure(60.0) == pytest.approx(8522.159176, rel=1e-9)


def test_the_line_passes_through_its_three_points():
    """Ultimate strength once, its fraction 1e3 times, the endurance limit at 1e6."""
    curve = basquin_curve(690.0, 236.0, 0.844)
    found = curve.cycles_to_failure([690.0, 0.844 * 690.0, 236.0])
    assert_allclose(found, [1.0, 1e3, 1e6], rtol=1e-10)
    assert curve.cycles_to_failure(235.99) == np.inf


def test_below_a_thousand_cycles_life_falls_faster_than_on_the_line():
    """Straight from (1e3, f S_u) to (1, S_u): in the middle, sqrt(1e3) cycles."""
    curve = basquin_curve(800.0, 300.0, 0.85)
    middle = 800.0 * np.sqrt(0.85)
    assert curve.cycles_to_failure(middle) == pytest.approx(np.sqrt(1e3), rel=1e-10)
    line = SNCurve(curve.knee_amplitude, 1e6, curve.slope)
    assert line.cycles_to_failure(middle) > 10.0 * np.sqrt(1e3)
    assert line.cycles_to_failure(800.0) > 100.0


def test_the_ultimate_strength_breaks_the_part_in_the_first_cycle():
    """Also where the line itself would still endure some cycles more there."""
    curve = basquin_curve(800.0, 300.0)
    assert (curve.cycles_to_failure([800.0, 900.0, 1e4]) <= 1.0 + 1e-12).all()
    steep = SNCurve(100.0, 1e6, 3.0, ultimate_strength=500.0)  # 1e3 cycles only at 1000 MPa
    assert steep.cycles_to_failure(499.0) == pytest.approx(1e6 * 4.99**-3.0, rel=1e-12)
    assert steep.cycles_to_failure(500.0) == 1.0


def test_the_low_cycle_fraction_is_that_of_the_chart():
    """Shigley, 9th ed., fig. 6-18: 0.844 at 690 MPa (ex. 6-9), 0.9 at 482, about 0.77 at 1380.

    By hand at 1500, S_e' = 700: 1845/1500 * 2000**(-lg(1845/700)/lg 2e6) = 0.740.
    """
    assert low_cycle_fraction(690.0) == pytest.approx(0.844, abs=5e-4)
    assert low_cycle_fraction(482.0) == pytest.approx(0.9, abs=1e-3)
    assert low_cycle_fraction(300.0) == 0.9
    assert low_cycle_fraction(1380.0) == pytest.approx(0.775, abs=5e-3)
    assert low_cycle_fraction(1500.0) == pytest.approx(0.740, abs=5e-4)
    default = basquin_curve(690.0, 236.0)
    assert default.cycles_to_failure(low_cycle_fraction(690.0) * 690.0) == pytest.approx(1e3)


def test_twice_the_amplitude_shortens_life_by_two_to_the_slope():
    assert KNEE.cycles_to_failure(200.0) == 1e6 / 2.0**5
    assert KNEE.below_knee("elementary").cycles_to_failure(50.0) == 1e6 * 2.0**5
    assert KNEE.below_knee("haibach").cycles_to_failure(50.0) == 1e6 * 2.0**9


def test_an_amplitude_at_the_knee_belongs_to_the_upper_branch():
    assert KNEE.cycles_to_failure(100.0) == 1e6
    assert KNEE.cycles_to_failure(np.nextafter(100.0, 0.0)) == np.inf
    assert KNEE.below_knee("haibach").below_knee("original").slope_below == np.inf


def test_no_stress_is_endured_without_end_and_infinite_stress_not_at_all():
    for variant in ("original", "elementary", "haibach"):
        curve = KNEE.below_knee(variant)
        assert curve.cycles_to_failure([0.0, np.inf]).tolist() == [np.inf, 0.0]


@given(st.floats(0.0, 2000.0), st.floats(0.0, 500.0), st.sampled_from([None, 800.0, 300.0]))
@settings(deadline=None)
def test_more_amplitude_never_does_less_damage(amplitude, more, strength):
    for below in (np.inf, 5.0, 9.0):
        curve = SNCurve(100.0, 1e6, 5.0, below, ultimate_strength=strength)
        low, high = curve.damage_per_cycle([amplitude, amplitude + more])
        assert high >= low * (1.0 - 1e-12)


def test_a_curve_per_point_is_the_curve_of_each_point():
    knees, slopes = np.array([80.0, 100.0, 120.0]), np.array([4.0, 5.0, 6.0])
    curve = SNCurve(knees, 1e6, slopes, 2.0 * slopes - 1.0, ultimate_strength=700.0)
    amplitude = np.array([[50.0, 300.0], [90.0, 650.0], [500.0, 900.0]])
    found = curve.cycles_to_failure(amplitude)
    for point in range(3):
        k = slopes[point]
        alone = SNCurve(knees[point], 1e6, k, 2.0 * k - 1.0, ultimate_strength=700.0)
        assert_allclose(found[point], alone.cycles_to_failure(amplitude[point]), rtol=1e-14)
    assert curve.cycles_to_failure([90.0, 95.0]).shape == (3, 2)
    limits = basquin_curve(700.0, knees, 0.85)
    assert_allclose(limits.cycles_to_failure([595.0]), [[1e3]] * 3, rtol=1e-9)


def test_curves_that_cannot_be_are_refused():
    with pytest.raises(ValueError, match=r"knee amplitude .* must be above 0: -1 at point 1"):
        SNCurve(np.array([1.0, -1.0]), 1e6, 5.0)
    with pytest.raises(ValueError, match=r"slope of an S-N curve must be above 1: 0.5"):
        SNCurve(100.0, 1e6, 0.5)
    with pytest.raises(ValueError, match=r"must not be less than that above: 3"):
        SNCurve(100.0, 1e6, 5.0, 3.0)
    with pytest.raises(ValueError, match=r"one per point, \(n_points,\), got \(1, 2\)"):
        SNCurve(np.ones((1, 2)), 1e6, 5.0)
    with pytest.raises(ValueError, match=r"amplitude must be at least 0 MPa: nan at cycle 1"):
        KNEE.cycles_to_failure([1.0, np.nan])
    with pytest.raises(ValueError, match=r"'haybach' is unknown; one of original"):
        KNEE.below_knee("haybach")
    with pytest.raises(ValueError, match=r"below 582.36 MPa, endured 1e3 times: 600"):
        basquin_curve(690.0, 600.0, 0.844)


def test_the_amplitude_of_a_damage_does_it():
    """Of every stretch of the curve, point by point: below the knee, above it, and the bend."""
    curve = basquin_curve(500.0, np.full(5, 150.0), 0.9).below_knee("haibach")
    damage = np.array([1e-9, 1e-6, 1e-4, 1e-3, 0.2])
    amplitude = curve.amplitude(damage)
    assert_allclose(curve.damage_per_cycle(amplitude[:, None])[:, 0], damage, rtol=1e-9)
    assert curve.amplitude(np.full(5, 30.0)) == pytest.approx(500.0)
