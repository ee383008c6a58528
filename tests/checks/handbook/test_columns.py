"""Column formulas against the closed forms of BK-02 and BK-06 and the hand values of the press."""

from math import pi, sqrt

import pytest
from numpy.testing import assert_allclose

from bench.closed_forms import engesser_force
from checks.handbook.column_curves import (
    IMPERFECTION,
    column_strength,
    eurocode_reduction,
    eurocode_stress,
    perry_robertson,
    transition_slenderness,
)

STEEL = 210e3
LAST_DIGIT = 1e-9  # of values printed with ten digits


def euler_of(slenderness):
    return pi**2 * STEEL / slenderness**2


def strength_at(slenderness, yield_stress=350.0):
    """A column of 1 mm2 whose radius of gyration is 1 mm."""
    return column_strength(1.0, 1.0, slenderness, yield_stress, STEEL)


def test_johnson_meets_euler_at_half_the_yield_stress():
    """BK-06; both sides of the switch, where the two curves touch."""
    switch = transition_slenderness(350.0, STEEL)
    assert_allclose(switch, 108.8279619, rtol=LAST_DIGIT)
    below, above = strength_at(switch * (1 - 1e-7)), strength_at(switch * (1 + 1e-7))
    assert (below.governs, above.governs) == ("Johnson", "Euler")
    assert_allclose([below.critical, above.critical], 175.0, rtol=1e-6)


@pytest.mark.parametrize(
    ("slenderness", "stress", "law"),
    [
        (40, 326.3583905, "Johnson"),
        (80, 255.4335619, "Johnson"),
        (108, 177.6526666, "Johnson"),
        (150, 92.11630774, "Euler"),
    ],
)
def test_johnson_and_euler_give_the_published_stress(slenderness, stress, law):
    """BK-06, closed form."""
    strength = strength_at(slenderness)
    assert_allclose(strength.critical, stress, rtol=LAST_DIGIT)
    assert strength.governs == law


@pytest.mark.parametrize(
    ("slenderness", "stress"), [(50, 284.892695), (100, 156.7987214), (150, 79.8616527)]
)
def test_perry_and_robertson_give_the_published_stress(slenderness, stress):
    """BK-06, eta = 0.003 L/k."""
    found = perry_robertson(euler_of(slenderness), 350.0, 0.003 * slenderness)
    assert_allclose(found, stress, rtol=LAST_DIGIT)


@pytest.mark.parametrize(
    ("curve", "slenderness", "share"),
    [
        ("a0", 1.0, 0.7253442179),
        ("a", 1.0, 0.6656030593),
        ("b", 1.0, 0.5970231916),
        ("c", 1.0, 0.5399390272),
        ("d", 1.0, 0.4670914028),
        ("c", 0.15, 1.0),
        ("b", 2.0, 0.2094611296),
    ],
)
def test_eurocode_gives_the_published_reduction(curve, slenderness, share):
    """BK-06, EN 1993-1-1, 6.3.1.2; half a unit of the last of ten digits."""
    assert_allclose(eurocode_reduction(slenderness, curve), share, rtol=LAST_DIGIT)


def test_eurocode_is_perry_and_robertson_with_an_imperfection_that_grows_with_slenderness():
    for curve, alpha in IMPERFECTION.items():
        eta = alpha * (sqrt(355 / euler_of(90)) - 0.2)
        expected = perry_robertson(euler_of(90), 355.0, eta)
        assert_allclose(eurocode_stress(euler_of(90), 355.0, curve), expected, rtol=1e-14)


def test_a_straight_column_carries_the_lesser_of_yield_and_euler():
    for slenderness in (5, 50, 70, 90, 120, 500):
        expected = min(350.0, euler_of(slenderness))
        assert_allclose(perry_robertson(euler_of(slenderness), 350.0, 0.0), expected, rtol=1e-12)


def test_perry_and_robertson_stay_exact_at_any_slenderness():
    """(S_y - s)(s_E - s) = eta s_E s; the plain root of the quadratic loses all digits here."""
    for slenderness in (1e-4, 5, 500, 1e6):
        euler = euler_of(slenderness)
        s = perry_robertson(euler, 350.0, 0.1)
        assert 0 < s < min(350.0, euler)
        assert_allclose((350 - s) * (1 - s / euler), 0.1 * s, rtol=0, atol=1e-12 * 350)


def test_every_curve_lies_below_the_one_before_it_and_above_zero():
    for slenderness in (5, 30, 60, 120, 250, 500):
        stresses = [eurocode_stress(euler_of(slenderness), 355.0, c) for c in IMPERFECTION]
        assert stresses == sorted(stresses, reverse=True)
        assert 0 < stresses[-1] <= stresses[0] <= min(355.0, 1.0001 * euler_of(slenderness))


def test_shear_lowers_the_buckling_force_as_engesser_says():
    """BK-02: L = 100, h = 20, b = 10, k = 5/6. Haringx would give 1263207 N."""
    euler = pi**2 * STEEL * 10 * 20**3 / 12 / 100**2
    assert_allclose(euler, 1381744.616, rtol=LAST_DIGIT)
    found = engesser_force(euler, 5 / 6 * 200 * STEEL / 2.6)
    assert_allclose(found, 1253119.556, rtol=LAST_DIGIT)


@pytest.mark.parametrize(
    ("side", "wall", "length", "force", "johnson", "euler"),
    [
        (13, 1.6, 250, 61398.94, 0.3707291, 732.4352),
        (30, 1.6, 250, 61398.94, 1.030055, 4471.989),
        (30, 1.6, 500, 61398.94, 0.967, 1117.997),
        (80, 6.3, 250, 61398.94, 10.70678, 30240.2),
        (80, 6.3, 500, 61398.94, 10.61, 7560.05),
    ],
)
def test_the_tubes_of_the_toggle_press_have_their_hand_values(
    side, wall, length, force, johnson, euler
):
    """BRIEF T-E1, T-E4, T-E6 and reference.json (seven digits); three digits at 0.5 m."""
    inner = side - 2 * wall
    area, inertia = side**2 - inner**2, (side**4 - inner**4) / 12
    strength = column_strength(area, inertia, length, 355.0, STEEL)
    assert_allclose(strength.critical * area / force, johnson, rtol=1e-6 if length == 250 else 1e-3)
    assert_allclose(strength.euler, euler, rtol=1e-6)


def test_the_hammers_rod_is_safe_as_a_tube_and_not_as_a_bar_of_equal_mass():
    """1053 N: 6845 N and 1900 N by Euler are 6.5 and 1.8 of it; area 137 mm2 both."""
    areas, safeties = [], []
    for outer, bore in ((20.0, 15.0), (13.2, 0.0)):
        area, inertia = pi / 4 * (outer**2 - bore**2), pi / 64 * (outer**4 - bore**4)
        strength = column_strength(area, inertia, 1275.0, 275.0, STEEL)
        assert strength.governs == "Euler"
        areas.append(area)
        safeties.append(strength.critical * area / 1053)
    assert_allclose(areas[1], areas[0], rtol=5e-3)
    assert_allclose(safeties, [6.50, 1.80], atol=0.006)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: eurocode_reduction(1.0, "e"), r"no column curve is named 'e'; there are a0, a, b"),
        (lambda: eurocode_reduction(-1.0, "a"), "slenderness must be at least 0, got -1"),
        (lambda: perry_robertson(100.0, 350.0, -0.1), "eta must be at least 0, got -0.1"),
        (lambda: perry_robertson(0.0, 350.0, 0.1), "euler stress must be above 0, got 0"),
        (lambda: column_strength(0.0, 1.0, 1.0, 1.0, 1.0), "area must be above 0, got 0"),
    ],
)
def test_what_is_no_column_is_refused_in_words(call, words):
    with pytest.raises(ValueError, match=words):
        call()
