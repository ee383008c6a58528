"""Peaks over a cycle from a basis and coefficients, against the stress written out."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.recovery import von_mises
from fem.stress_history import StressHistory


def random_history(n_points, n_positions, n_basis=5):
    random = np.random.default_rng(4)
    basis = random.normal(size=(n_points, 6, n_basis))
    coefficients = random.normal(size=(n_basis, n_positions))
    return StressHistory(np.arange(n_points), np.zeros((n_points, 3)), basis, coefficients)


@pytest.mark.parametrize("few", [0, 100_000])
@pytest.mark.parametrize("numbers", [100_000, 600, 1])
def test_peaks_by_position_are_those_of_the_stress_written_out(monkeypatch, numbers, few):
    """Any number of points at a time, one included, block by block or at once.

    Round-off of a sum of five.
    """
    monkeypatch.setattr("fem.stress_history._NUMBERS", numbers)
    monkeypatch.setattr("fem.stress_history._FEW", few)
    history = random_history(37, 41)
    peaks, where = history.peaks_by_position()
    for k in range(41):
        stress = von_mises(history.at(k))
        assert where[k] == stress.argmax()
        assert_allclose(peaks[k], stress.max(), rtol=1e-14)


@pytest.mark.parametrize("numbers", [100_000, 600, 1])
def test_peaks_by_point_are_those_of_the_stress_written_out(monkeypatch, numbers):
    monkeypatch.setattr("fem.stress_history._NUMBERS", numbers)
    history = random_history(37, 41)
    stresses = [von_mises(history.at(k)) for k in range(41)]
    assert_allclose(history.peaks_by_point(), np.max(stresses, axis=0), rtol=1e-14)


def test_of_equal_peaks_the_first_point_is_named(monkeypatch):
    history = random_history(3, 4)
    twice = StressHistory(
        np.arange(6), np.zeros((6, 3)), np.tile(history.basis, (2, 1, 1)), history.coefficients
    )
    for numbers in (100_000, 1):
        monkeypatch.setattr("fem.stress_history._NUMBERS", numbers)
        assert (twice.peaks_by_position()[1] < 3).all()
