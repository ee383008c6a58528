"""The error bars' calibration: the numbers that docs/validation.md shows."""

import pytest

from bench.error_bars import PAGE, PAIRS, calibration, readings, summary


@pytest.fixture(scope="module")
def pairs():
    done = {}
    return [readings(pair, done) for pair in PAIRS]


@pytest.mark.slow
def test_nine_of_ten_references_lie_inside_bars_that_are_not_too_wide(pairs):
    for found in pairs:
        sums = calibration(found)
        assert sums.count >= 70
        assert sums.holds, sums


@pytest.mark.slow
def test_the_page_shows_the_calibration_as_it_is(pairs):
    assert summary(pairs) in PAGE.read_text(encoding="utf-8")
