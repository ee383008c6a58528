"""Section forces, deflection and buckling of bars by formula."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.handbook.bar_forces import balanced_bar, deflection
from checks.handbook.column_curves import column_force, lateral_share
from checks.models.shapes.pin import section_stress, surface_stress, under_band
from checks.models.shapes.slotted_lever import rail_forces

X = np.linspace(0.5, 99.5, 100)
MASS = np.full(100, 1e-6)


def wrench(*values):
    return np.array([values], dtype=float)


def test_a_bar_held_at_both_ends_has_the_force_and_moment_of_its_ends():
    """Pull 10, couple 30 at the first end less 100 mm times 0.2 of shear: M(x) by hand."""
    loads = [(0.0, wrench(-10, -0.2, 0, -7, 5, 30)), (100.0, wrench(10, 0.2, 0, 7, -5, -50))]
    bar = balanced_bar(loads, X, MASS, np.zeros((1, 4)))
    assert_allclose(bar.added, 0, atol=1e-9)
    forces = bar.at(np.array([25.0]))
    assert_allclose(forces.axial, 10)
    assert_allclose(forces.shear, 0.2)
    assert_allclose(forces.torque, 7)
    assert_allclose(forces.moment_y, -5)
    assert_allclose(forces.moment_z, -50 + 75 * 0.2)


def test_a_turning_bar_is_pulled_by_what_lies_beyond():
    """Turns about x = 0, held there: m omega2 (L^2 - x^2)/(2 L); cells of 1 mm, exact at cuts."""
    omega2, total = 400.0, MASS.sum()
    hold = wrench(-total * omega2 * 50, 0, 0, 0, 0, 0)
    bar = balanced_bar([(0.0, hold)], X, MASS, np.array([[0, 0, 0, omega2]]))
    assert_allclose(bar.added, 0, atol=1e-9 * omega2 * 50)
    forces = bar.at(np.array([20.0, 50.0]))
    wanted = 1e-6 * omega2 * (100**2 - np.array([[20.0], [50.0]]) ** 2) / 2
    assert_allclose(forces.axial, wanted, rtol=1e-12)


def test_a_free_force_is_balanced_by_the_bars_own_acceleration():
    """At its end: a = 4 F/m at the end of a uniform bar, -2 F/m at the other (textbook)."""
    bar = balanced_bar([(100.0, wrench(0, 1, 0, 0, 0, 0))], X, MASS, np.zeros((1, 4)))
    a_y, alpha = bar.added[0, 1:]
    assert_allclose([a_y, a_y + 100 * alpha], [-2e4, 4e4], rtol=1e-3)  # cells as points: 1e-4
    assert_allclose(bar.at(np.array([-1.0])).moment_z, 0, atol=1e-9)


def test_a_bar_under_even_bending_is_an_arc():
    """M L^2/(8 E I)."""
    places = np.linspace(0, 10, 101)
    found = deflection(np.full((101, 1), 3.0), np.full(101, 2.0), places)
    assert_allclose(np.abs(found).max(), 3 * 100 / (8 * 2), rtol=1e-3)


def test_a_stepped_column_is_between_its_even_ones():
    stiffness = np.where(np.linspace(0, 1, 201) < 0.5, 1.0, 3.0)
    low, high = (column_force(np.full(201, s), np.inf, 1.0) for s in (1.0, 3.0))
    assert low < column_force(stiffness, np.inf, 1.0) < high


def test_shear_takes_off_a_columns_force_as_engesser_has_it():
    """F_E/(1 + F_E/S), even column: the trapezoids are exact for a sine squared."""
    euler = np.pi**2 * 5.0 / 4
    found = column_force(np.full(65, 5.0), np.full(65, 7.0), 2.0)
    assert_allclose(found, euler / (1 + euler / 7), rtol=1e-9)


def test_a_bar_bent_by_a_force_at_its_end_buckles_sideways_as_prandtl_found():
    """4.013 sqrt(E I G J)/L^2 at the clamped end's moment F L; three waves: 1 %."""
    s = np.linspace(0, 1, 401)
    moment = 4.013 * np.sqrt(6.0) / 10 * (1 - s)
    share = lateral_share(np.zeros(1), moment[:, None], np.full(401, 2.0), np.full(401, 3.0), 10.0)
    assert_allclose(share, 1.0, rtol=0.01)


def test_tension_takes_off_and_compression_adds_to_lateral_buckling():
    """(1 - s p) = (s m)^2: m = 1, p = 1.5 has s = 1/2; p = -1.5 has s = 2."""
    s = np.linspace(0, 1, 401)
    flat = np.full(401, 1.0)
    m = lateral_share(np.zeros(1), np.ones((401, 1)) * (1 - s)[:, None], flat, flat, 1.0)[0]
    moment = (1 - s)[:, None] / m * np.ones(2)
    share = lateral_share(np.array([1.5, -1.5]), moment, flat, flat, 1.0)
    assert_allclose(share, [2.0, 0.5], rtol=1e-9)


def test_the_rails_beside_a_slot_share_an_even_moment_as_one_section():
    """P a + 2 m = M, both in the proportion of their second moments; nothing spreads them."""
    places = np.linspace(10, 90, 17)
    found = rail_forces(
        places,
        np.full((17, 1), 600.0),
        np.zeros(1),
        np.array([50.0]),
        area=20.0,
        inertia=100.0,
        apart=8.0,
    )
    steiner = 20 * 8**2 / 2
    assert_allclose(found.axial[1], 600 * steiner / (steiner + 200) / 8)
    assert_allclose(found.moment, 600 * 100 / (steiner + 200))


def test_a_force_on_one_rail_spreads_them_as_a_clamped_bar():
    """Half of 8 N in the middle of 80 mm: Q L/8 = 40 at ends and middle, the other way round."""
    places = np.linspace(10, 90, 17)
    found = rail_forces(
        places,
        np.zeros((17, 1)),
        np.array([8.0]),
        np.array([50.0]),
        area=20.0,
        inertia=100.0,
        apart=8.0,
    )
    assert_allclose(found.moment[0, [0, 8, 16], 0], [40, -40, 40])
    assert_allclose(found.moment[1], -found.moment[0])


def test_a_pins_section_bends_and_is_sheared_by_what_acts_below_it():
    """A force along x 20 mm below: the side it comes from is pulled, 32 M/(pi d^3)."""
    angles = np.radians([0.0, 90.0, 180.0])
    along, sheared = section_stress(
        angles, 10.0, np.array([[50.0, 0.0]]), np.array([[1000.0, 0.0]]), np.zeros(1), 0.3
    )
    assert_allclose(along[:, 0], 32e3 / (np.pi * 1e3) * np.array([-1, 0, 1]), atol=1e-12)
    # the rest above answers with -50 N: at 90 degrees its direction is +x there, (-sin, cos)
    assert_allclose(sheared[:, 0], [0, 1.6 / 1.3 * 50 / (25 * np.pi), 0], atol=1e-12)


def test_stress_around_a_pin_is_turned_into_its_axes():
    """At 90 degrees x runs against the way around, y along the radius: -z shear is +x there."""
    one = np.ones(1)
    found = surface_stress(np.array([np.pi / 2]), -7 * one, -3 * one, 2 * one, 5 * one)
    assert_allclose(found[0], [-3, -7, 2, 0, 0, -5], atol=1e-14)


def band(place, half):
    return under_band(np.array([place]), np.array([-half]), np.array([half]), 1.0, 0.3)[:, 0, 0]


def test_under_a_long_band_a_pin_is_pressed_as_a_disc_and_under_a_short_one_as_a_half_space():
    """-1 around and along the radius, nothing along z; and -1 along z, -2 nu around.

    Half a band of a hundredth of the radius differs from a half-space by some per cent: 5 %.
    """
    assert_allclose(band(0.0, 6.0), [0, -1, -1], atol=0.01)
    assert_allclose(band(0.0, 0.01), [-1, -0.6, -1], atol=0.05)
    assert_allclose(band(6.0, 0.5), 0, atol=0.01)


def test_the_stress_along_a_pin_under_a_band_is_in_balance_over_the_section():
    """Beside it the surface is pulled, and the sum over z vanishes as for any even pressure.

    For k = 0 nothing acts along z: the integral of sigma_z over z is 0; 1 % of the band's.
    """
    places = np.linspace(-7.9, 7.9, 1581)
    along = under_band(places, np.array([-0.5]), np.array([0.5]), 1.0, 0.3)[0, :, 0]
    assert along.max() > 0.2
    assert abs(along.sum() * 0.01) < 0.01 * 1.0


def test_two_bands_side_by_side_press_as_the_whole():
    lows, highs = np.array([-1.0, 0.0]), np.array([0.0, 1.0])
    both = under_band(np.array([0.3]), lows, highs, 1.0, 0.3).sum(axis=2)[:, 0]
    assert_allclose(both, band(0.3, 1.0), atol=1e-12)


@pytest.mark.parametrize("off", [1e-15, -1e-15, 3e-14])
def test_half_a_band_presses_at_its_edge_less_round_off(off):
    """At 5.5 mm, the sum of lengths, as at the edge itself: a pin of 10 um had lost 6 % so."""
    edge, low, high = 5.5, np.array([5.5]), np.array([15.5])
    at, beside = (under_band(np.array([z]), low, high, 5.0, 0.3) for z in (edge, edge + off))
    assert_allclose(beside, at, rtol=0, atol=1e-12)
    assert at[2, 0, 0] == -0.5
