"""Stress at fibres by section forces, against formulas by hand and integrals over sections."""

import numpy as np
from numpy.testing import assert_allclose

from fem.frame_fibres import rectangle_fibres, round_fibres, square_tube_fibres
from geometry.sections import square_tube_section

ROUND_OFF = 1e-12


def test_corners_of_a_rectangle_add_axial_force_and_both_moments():
    """N/A = 1200/120, M_z c/I = 6 M/(b h^2), M_y likewise; M_z above 0 pulls the fibres at -y."""
    fibres = rectangle_fibres(20.0, 6.0)
    stress = fibres.unit @ np.array([1200.0, 0, 0, 0, 600.0, 4000.0])
    corner = int(np.flatnonzero((fibres.places == [-10.0, 3.0]).all(axis=1))[0])
    expected = 1200 / 120 + 6 * 4000 / (6 * 20**2) + 6 * 600 / (20 * 6**2)
    assert_allclose(stress[corner], [expected, 0, 0, 0, 0, 0], rtol=ROUND_OFF, atol=1e-12)
    assert corner == stress[:, 0].argmax()


def test_the_side_of_a_rectangle_carries_one_and_a_half_times_the_mean_shear():
    fibres = rectangle_fibres(20.0, 6.0)
    stress = fibres.unit @ np.array([0, 800.0, 0, 0, 0, 0])
    assert_allclose(np.abs(stress[:, 3]).max(), 1.5 * 800 / 120, rtol=ROUND_OFF)
    assert not stress[:, [0, 1, 2, 4, 5]].any()


def test_the_shear_of_torsion_turns_about_the_axis_on_every_section():
    """y tau_zx - z tau_xy is above 0 at every fibre that carries any: the torque's own sense."""
    tube = square_tube_section("tube", 30.0, 2.0, 0.0)
    sections = (
        rectangle_fibres(20.0, 6.0),
        round_fibres(16.0),
        square_tube_fibres(30.0, 2.0, tube.area, tube.inertia_in_plane),
    )
    for fibres in sections:
        shear = fibres.unit[:, [3, 5], 3]
        turn = fibres.places[:, 0] * shear[:, 1] - fibres.places[:, 1] * shear[:, 0]
        sheared = np.abs(shear).max(axis=1) > 0
        assert sheared.sum() >= 4
        assert (turn[sheared] > 0).all()


def test_a_round_bar_is_twisted_and_bent_as_by_hand():
    fibres = round_fibres(16.0, count=8)
    stress = fibres.unit @ np.array([0, 0, 0, 5000.0, 0, 7000.0])
    assert_allclose(np.hypot(stress[:, 3], stress[:, 5]), 16 * 5000 / (np.pi * 16**3), rtol=1e-12)
    assert_allclose(stress[:, 0].max(), 32 * 7000 / (np.pi * 16**3), rtol=ROUND_OFF)


def test_a_thin_round_tube_carries_twice_the_mean_shear():
    """V/(pi r t) beside the neutral axis; a wall of 1 % leaves 1 % of Jourawski's formula."""
    fibres = round_fibres(100.0, 98.0)
    area = np.pi / 4 * (100.0**2 - 98.0**2)
    most = np.abs(fibres.unit[:, 3, 1]).max()
    assert_allclose(most, 2 / area, rtol=0.01)


def test_turned_fibres_of_a_member_along_z_have_their_stress_along_z():
    fibres = round_fibres(16.0, count=4)
    axes = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    stress = fibres.turned(axes) @ np.array([100.0, 0, 0, 0, 0, 0])
    assert_allclose(stress[:, 2], 100 / (np.pi * 8**2), rtol=ROUND_OFF)
    assert not stress[:, [0, 1, 3, 4, 5]].any()


def test_notch_factors_raise_what_they_stand_for_and_nothing_else():
    plain = rectangle_fibres(20.0, 6.0)
    notched = plain.notched(2.0, 3.0, 1.5)
    for force, factor in ((0, 2.0), (1, 1.0), (2, 1.0), (3, 1.5), (4, 3.0), (5, 3.0)):
        assert_allclose(notched.unit[:, :, force], factor * plain.unit[:, :, force], rtol=1e-15)
