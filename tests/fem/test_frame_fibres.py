"""Stress at fibres by section forces, against formulas by hand and integrals over sections."""

import numpy as np
from numpy.testing import assert_allclose

from checks.models.shapes.step_part import rectangle_fibres

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


def test_the_shear_of_torsion_turns_about_the_axis_on_every_side():
    """y tau_zx - z tau_xy is above 0 at every fibre that carries any: the torque's own sense."""
    fibres = rectangle_fibres(20.0, 6.0)
    shear = fibres.unit[:, [3, 5], 3]
    turn = fibres.places[:, 0] * shear[:, 1] - fibres.places[:, 1] * shear[:, 0]
    sheared = np.abs(shear).max(axis=1) > 0
    assert sheared.sum() == 4
    assert (turn[sheared] > 0).all()
