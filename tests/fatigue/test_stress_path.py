"""Peaks and principal stresses over the cycle."""

from inspect import ismodule

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fatigue
from fatigue import path_lengths, principal_stresses, von_mises, von_mises_peaks
from fatigue.stress_path import deviatoric_basis


def test_the_front_door_lists_what_is_there():
    """Whatever its order: the formatter's puts constants first."""
    here = {name for name, value in vars(fatigue).items() if not ismodule(value)}
    assert sorted(fatigue.__all__) == sorted(name for name in here if not name.startswith("_"))


def test_the_order_of_the_components_is_stated():
    assert fatigue.COMPONENTS == ("xx", "yy", "zz", "xy", "yz", "zx")


def test_peaks_are_those_of_the_stress_at_every_position():
    rng = np.random.default_rng(0)
    basis, coefficients = rng.normal(size=(900, 6, 5)), rng.normal(size=(5, 300))
    peak, position = von_mises_peaks(basis, coefficients)
    history = von_mises(np.swapaxes(basis @ coefficients, 1, 2))
    assert position.tolist() == history.argmax(axis=1).tolist()
    assert_allclose(peak, history.max(axis=1), rtol=1e-12)


def test_of_equal_peaks_the_first_position_is_named():
    basis = np.zeros((1, 6, 1))
    basis[0, 0, 0] = 1.0
    peak, position = von_mises_peaks(basis, np.array([[1.0, -7.0, 7.0, 2.0]]))
    assert (peak[0], position[0]) == (7.0, 1)


def test_principal_stresses_of_a_turned_tensor_are_what_it_was_made_of():
    rng = np.random.default_rng(1)
    for _ in range(20):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        t = turn @ np.diag([-30.0, 20.0, 70.0]) @ turn.T
        stress = np.array([t[0, 0], t[1, 1], t[2, 2], t[0, 1], t[1, 2], t[2, 0]])
        assert_allclose(principal_stresses(stress), [-30.0, 20.0, 70.0], rtol=1e-12)


def test_a_point_that_is_not_finite_is_named():
    basis = np.zeros((3, 6, 2))
    basis[2, 0, 0] = np.nan
    with pytest.raises(ValueError, match="not finite at point 2"):
        von_mises_peaks(basis, np.ones((2, 4)))


def test_the_von_mises_norm_of_the_five_vectors_is_the_textbook_s():
    stress = np.random.default_rng(17).normal(size=(200, 6))
    xx, yy, zz, xy, yz, zx = stress.T
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    expected = np.sqrt(0.5 * normal + 3.0 * (xy**2 + yz**2 + zx**2))
    assert_allclose(von_mises(stress), expected, rtol=1e-14)
    vectors = deviatoric_basis(stress[:, :, None])[:, :, 0]
    assert_allclose(np.linalg.norm(vectors, axis=1), expected, rtol=1e-14)


def test_a_closed_path_is_as_long_as_its_steps_and_the_one_back():
    """Pressure has no length; a pull of 60 MPa is von Mises stress, a shear of 80/sqrt(3) is 80."""
    basis = np.eye(6)[None]
    corners = np.zeros((6, 4))
    corners[0, 1:] = 60.0
    corners[3, 2] = 80.0 / np.sqrt(3.0)
    corners[:3, 3] += 500.0
    assert_allclose(path_lengths(basis, corners), [60.0 + 80.0 + 80.0 + 60.0], rtol=1e-12)
