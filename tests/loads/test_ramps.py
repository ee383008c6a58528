"""A load that jumps, sampled: the half wave of a cosine in which it rises, and what it keeps."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads.harmonics import SAMPLES, sampled

TIMES, VALUES = np.array([0.0, 1.0, 1.0, 2.0]), np.array([0.0, 0.0, 8.0, 0.0])


def at(samples, time):
    """Value at a time of the period of 2 s."""
    return np.interp(time, np.arange(SAMPLES) * 2.0 / SAMPLES, samples)


def test_a_jump_rises_by_half_a_cosine_wave_about_where_it_is():
    """0 to 8 N within 0.4 s about t = 1 s, on a load that falls by 8 N/s after it: 4 (1 + sin)."""
    _, samples, jump = sampled(TIMES, VALUES, 0.4)
    assert jump == 8.0
    # without the jump the load is -8 (t - 1) after 1 s; each share of the rise is on top of it
    for share, risen in ((-0.5, 0.0), (-0.25, 4 - 4 * np.sqrt(0.5)), (0.0, 4.0),
                         (0.25, 4 + 4 * np.sqrt(0.5)), (0.5, 8.0)):  # fmt: skip
        time = 1.0 + 0.4 * share
        assert_allclose(at(samples, time), risen - 8 * max(time - 1, 0), atol=0.02)


@pytest.mark.parametrize("rise", [0.0, 1e-3, 0.4, 1.9])
def test_a_rise_of_any_length_takes_nothing_from_the_mean(rise):
    """Half of 8 N for half of the time: 2 N; sudden, a sample of 1/4096 of the time is 0.002 N."""
    _, samples, _ = sampled(TIMES, VALUES, rise)
    assert_allclose(samples.mean(), 2.0, atol=2.5e-3)


@pytest.mark.parametrize("rise", [0.0, 0.4])
def test_away_from_its_jump_a_load_is_as_it_is_stated(rise):
    _, samples, _ = sampled(TIMES, VALUES, rise)
    for time, value in ((0.1, 0.0), (0.7, 0.0), (1.3, 5.6), (1.9, 0.8)):
        assert_allclose(at(samples, time), value, atol=1e-9)


def test_a_sudden_jump_lies_between_the_two_values_that_are_stated_for_it():
    """At t = 1 s itself the load is anything from 0 to 8 N; one sample on either side it is not."""
    _, samples, _ = sampled(TIMES, VALUES, 0.0)
    assert 0.0 <= samples[SAMPLES // 2] <= 8.0
    assert_allclose(samples[SAMPLES // 2 - 1], 0.0, atol=1e-12)
    assert_allclose(samples[SAMPLES // 2 + 1], 8.0, atol=0.01)
