"""Mean stress by Goodman's line and by FKM's: textbook cases, tendencies, extremes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fatigue import equivalent_amplitude, fkm_factor, fkm_sensitivity, goodman_utilisation

# sums and roots of a few numbers, and the digits of cases.json
ROUND_OFF = 1e-12
ULTIMATE, LIMIT = 800.0, 250.0  # FT-07

amplitudes = st.floats(0.0, 400.0)
means = st.floats(-900.0, 900.0)


def test_equivalent_amplitudes_are_those_of_the_closed_form():
    """FT-07, to its ten digits; compression earns no credit."""
    found = equivalent_amplitude(100.0, [0.0, 50.0, 200.0, -50.0], ULTIMATE)
    assert_allclose(found, [100.0, 106.6666667, 133.3333333, 100.0], rtol=5e-10)


def test_repeated_axial_load_has_the_safety_factor_of_the_book():
    """FT-04: Shigley, 9th ed., ex. 6-10 (kpsi); amplitude and mean grow together."""
    assert 1.0 / goodman_utilisation(8.38, 8.38, 33.9, 100.0) == pytest.approx(
        3.021169576, rel=1e-9
    )


def test_the_guidelines_factor_holds_in_all_four_fields():
    """FT-08: FKM guideline, chapter 4.4, overload case F2; from R = 0.5 on it is constant."""
    means = [-150.0, -100.0, -50.0, 0.0, 50.0, 100.0, 150.0, 300.0, 350.0]
    factors = [10 / 7, 10 / 7, 1 / 0.85, 1.0, 1 / 1.15, 1 / 1.3, 11 / 14.95, 1.1 / 1.69, 1.1 / 1.69]
    equivalent = [70.0, 70.0, 85.0, 100.0, 115.0, 130.0, 1495 / 11, 1690 / 11, 1690 / 11]
    assert_allclose(factors[6:8], [0.7357859532, 0.650887574], rtol=1e-9)  # as the case prints
    assert_allclose(equivalent[6:8], [135.9090909, 153.6363636], rtol=1e-9)
    assert_allclose(fkm_factor(100.0, means, 0.3), factors, rtol=ROUND_OFF)
    assert_allclose(100.0 / fkm_factor(100.0, means, 0.3), equivalent, rtol=ROUND_OFF)


def test_constant_stress_lies_at_the_ends_of_the_guidelines_line():
    found = fkm_factor(0.0, [100.0, -100.0, 0.0], 0.3)
    assert_allclose(found, [1.1 / 1.69, 1.0 / 0.7, 1.0], rtol=ROUND_OFF)


@pytest.mark.parametrize("kink", [-100.0, 100.0, 300.0])
def test_the_guidelines_factor_has_no_steps(kink):
    before, after = fkm_factor(100.0, [kink * (1 - 1e-9), kink * (1 + 1e-9)], 0.3)
    assert before == pytest.approx(after, rel=2e-9)


def test_the_sensitivity_to_mean_stress_grows_with_strength():
    """FT-08, steel; below 286 MPa the formula is negative, which is not used."""
    found = [fkm_sensitivity(strength) for strength in (473.0, 865.6, 1200.0, 200.0)]
    assert found == pytest.approx([0.06555, 0.20296, 0.32, 0.0], rel=ROUND_OFF)
    assert fkm_sensitivity(210.0, "grey_iron") == 0.5
    with pytest.raises(ValueError, match="'brass' is unknown; one of steel, cast_steel"):
        fkm_sensitivity(300.0, "brass")


@given(amplitudes, means)
@settings(deadline=None)
def test_the_amplitude_is_the_limit_where_the_utilisation_is_1(amplitude, mean):
    utilisation = float(goodman_utilisation(amplitude, mean, LIMIT, ULTIMATE))
    assert utilisation >= 0.0
    if utilisation > 1e-3 and amplitude > 1.0:
        factor = 1.0 / utilisation
        on_line = equivalent_amplitude(factor * amplitude, factor * mean, ULTIMATE)
        # the line is steep near the ultimate strength: the tolerance follows the slope
        assert on_line == pytest.approx(LIMIT, rel=1e-9)


@given(amplitudes, means, st.floats(0.0, 500.0))
@settings(deadline=None)
def test_more_amplitude_or_mean_never_does_less_damage(amplitude, mean, more):
    low, high = equivalent_amplitude(amplitude, [mean, mean + more], ULTIMATE)
    assert high >= low * (1.0 - 1e-14)
    low, high = equivalent_amplitude([amplitude, amplitude + more], mean, ULTIMATE)
    assert high >= low * (1.0 - 1e-14)


def test_a_mean_at_the_ultimate_strength_is_endured_with_no_amplitude():
    for mean in (ULTIMATE, 1.5 * ULTIMATE):
        found = equivalent_amplitude([0.0, 1e-9, 100.0], mean, ULTIMATE)
        assert found.tolist() == [np.inf] * 3


def test_numbers_without_sense_are_refused_with_their_place():
    with pytest.raises(ValueError, match=r"half the range, is below 0 MPa: -5 at cycle 1"):
        equivalent_amplitude([5.0, -5.0], 0.0, ULTIMATE)
    with pytest.raises(ValueError, match=r"mean stress is not finite: nan at point 0, cycle 1"):
        equivalent_amplitude(1.0, [[0.0, np.nan]], ULTIMATE)
    with pytest.raises(ValueError, match="sensitivity must be at least 0 and below 1, got 1"):
        fkm_factor(1.0, 0.0, 1.0)
