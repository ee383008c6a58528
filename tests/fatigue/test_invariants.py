"""Crossland, Dang Van and Papadopoulos against public values and closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fatigue import compared_criteria
from fatigue.proportionality import deviator_components
from fatigue.stress_path import deviatoric_basis
from tests.fatigue.multiaxial_cases import (
    BENDING_LIMIT,
    NISHIHARA_KAWAMOTO,
    TORSION_LIMIT,
    bending_and_torsion,
    random_path,
    random_rotation,
    turned,
)


def criteria(stress):
    result = compared_criteria(stress, BENDING_LIMIT, TORSION_LIMIT)
    return np.array([result.dang_van, result.crossland, result.papadopoulos])


def test_proportional_bending_and_torsion_of_code_aster_szlz107():
    """Public case FT-10: 313.579 MPa, 137 MPa and criterion less limit -8.281 MPa, unrounded."""
    path = bending_and_torsion(411.0, 205.0)
    result = compared_criteria(path, 540.97, 352.0)
    assert result.shear_radius == pytest.approx(313.5793361, abs=1e-6)
    assert result.pressure == pytest.approx(137.0, abs=1e-6)
    assert (result.crossland - 1.0) * 352.0 == pytest.approx(-8.280898295, abs=1e-6)
    assert (result.papadopoulos - 1.0) * 352.0 == pytest.approx(-8.280898295, abs=1e-6)


@pytest.mark.parametrize("test", NISHIHARA_KAWAMOTO)
def test_the_criteria_have_their_public_values_in_and_out_of_phase(test):
    """Public case FT-11. 1440 positions cut an ellipse short by (pi/1440)**2 / 2 = 2.4e-6."""
    found = criteria(bending_and_torsion(test.bending, test.torsion, test.phase))
    assert_allclose(found, test.expected[1:], rtol=5e-6)


def test_all_criteria_agree_with_the_reversed_tests_they_are_calibrated_on():
    """And Dang Van's a = 3 (t/b - 1/2) = 0.37511946 of public case FT-12 follows from it."""
    assert_allclose(criteria(bending_and_torsion(BENDING_LIMIT, 0.0)), 1.0, rtol=1e-12)
    assert_allclose(criteria(bending_and_torsion(0.0, TORSION_LIMIT)), 1.0, rtol=1e-12)
    pressed = bending_and_torsion(BENDING_LIMIT, 0.0)
    pressed[:3] += 100.0
    rise = criteria(pressed)[0] - 1.0
    assert rise * TORSION_LIMIT / 100.0 == pytest.approx(0.3751194648, rel=1e-8)


def test_static_shear_does_not_change_the_limit_in_torsion():
    """Public case FT-12; the reversed half keeps its range about any static shear."""
    static = bending_and_torsion(0.0, TORSION_LIMIT)
    static[3] += 150.0
    assert_allclose(criteria(static), 1.0, rtol=1e-12)


def test_without_a_torsion_limit_it_is_the_bending_limit_over_root_3():
    path = random_path(1)
    stated = compared_criteria(path, 200.0, 200.0 / np.sqrt(3.0))
    assert compared_criteria(path, 200.0) == stated
    assert stated.crossland * 200.0 / np.sqrt(3.0) == pytest.approx(stated.shear_radius)


def test_the_shear_radius_is_that_of_the_smallest_ball_and_not_about_the_mean():
    """A spike: half of its 80 MPa of shear, although the mean of 720 positions is near 0."""
    path = np.zeros((6, 720))
    path[3, 411] = 80.0
    result = compared_criteria(path, 200.0)
    assert result.shear_radius == pytest.approx(40.0, rel=1e-9)
    assert result.dang_van * 200.0 / np.sqrt(3.0) == pytest.approx(40.0, rel=1e-9)


def test_turning_the_frame_and_starting_elsewhere_change_nothing():
    """The quadrature of Papadopoulos is exact for polynomials; 0.2 % on kinked amplitudes."""
    for seed in range(5):
        path = random_path(seed)
        before = criteria(path)
        assert_allclose(criteria(np.roll(path, 31, axis=1)), before, rtol=1e-12)
        after = criteria(turned(path, random_rotation(seed)))
        assert_allclose(after[:2], before[:2], rtol=1e-10)
        assert after[2] == pytest.approx(before[2], rel=2e-3)
        ellipse = bending_and_torsion(120.0, 80.0, 70.0)
        again = turned(ellipse, random_rotation(seed))
        assert criteria(again)[2] == pytest.approx(criteria(ellipse)[2], rel=1e-4)


def test_deviators_and_vectors_are_each_other_s_inverse():
    stress = random_path(3)
    deviator = deviator_components(deviatoric_basis(stress[None])[0].T).T
    expected = stress.copy()
    expected[:3] -= stress[:3].mean(axis=0)
    assert_allclose(deviator, expected, atol=1e-12)


@pytest.mark.parametrize("n_positions", [1, 2])
def test_one_and_two_positions_and_no_stress(n_positions):
    path = np.zeros((6, n_positions))
    nothing = compared_criteria(path, 200.0)
    assert (nothing.crossland, nothing.dang_van, nothing.papadopoulos) == (0.0, 0.0, 0.0)
    path[0, 0] = 90.0
    assert compared_criteria(path, 200.0).shear_radius == pytest.approx(
        (n_positions - 1) * 45.0 / np.sqrt(3.0)
    )


def test_what_cannot_be_judged_is_refused():
    path = random_path(4)
    path[2, 17] = np.nan
    with pytest.raises(ValueError, match="not finite at position 17"):
        compared_criteria(path, 200.0)
    with pytest.raises(ValueError, match=r"must be \(6, n_positions\), got \(3, 4\)"):
        compared_criteria(np.ones((3, 4)), 200.0)
    with pytest.raises(ValueError, match="above 0 MPa, got 0 and 100"):
        compared_criteria(np.ones((6, 4)), 0.0, 100.0)
