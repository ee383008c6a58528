"""Mean-stress rules: textbook cases, each rule's own line, tendencies, extremes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fatigue import (
    RULES,
    MeanStressMaterial,
    equivalent_amplitude,
    fkm_factor,
    fkm_sensitivity,
    goodman_utilisation,
    mean_stress_band,
    mean_stress_utilisation,
    yield_utilisation,
)

# sums and roots of a few numbers, and the digits of cases.json
ROUND_OFF = 1e-12

# FT-07
MATERIAL = MeanStressMaterial(
    ultimate_strength=800.0,
    yield_strength=600.0,
    fracture_strength=1000.0,
    walker_exponent=0.65,
    mean_stress_sensitivity=0.3,
)
LIMIT = 250.0

rules = st.sampled_from(RULES)
amplitudes = st.floats(0.0, 400.0)
means = st.floats(-900.0, 900.0)


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        ("goodman", [100.0, 106.6666667, 133.3333333, 94.11764706]),
        ("gerber", [100.0, 100.3921569, 106.6666667, 100.0]),
        ("soderberg", [100.0, 109.0909091, 150.0, 92.30769231]),
        ("asme_elliptic", [100.0, 1200.0 / 143**0.5, 300.0 / 8**0.5, 100.0]),
        ("morrow", [100.0, 105.2631579, 125.0, 95.23809524]),
        ("swt", [100.0, 122.4744871, 173.2050808, 70.71067812]),
        ("walker", [100.0, 115.2476134, 146.8900705, 78.45840979]),
    ],
)
def test_equivalent_amplitudes_are_those_of_the_closed_forms(rule, expected):
    """FT-07, to its ten digits; asme_elliptic and Soderberg's last by hand.

    100/sqrt(1 - (50/600)**2) = 100/sqrt(143/144), 100/sqrt(1 - (200/600)**2), 100/(1 + 50/600).
    """
    found = equivalent_amplitude(100.0, [0.0, 50.0, 200.0, -50.0], MATERIAL, rule, credit=True)
    assert_allclose(found, expected, rtol=5e-10)


@pytest.mark.parametrize("rule", RULES)
def test_compression_earns_no_credit_unless_asked(rule):
    assert equivalent_amplitude(100.0, -50.0, MATERIAL, rule) == pytest.approx(100.0, rel=1e-15)
    with_credit = float(equivalent_amplitude(100.0, -50.0, MATERIAL, rule, credit=True))
    if rule in ("gerber", "asme_elliptic"):  # even in the mean: never a credit
        assert with_credit == 100.0
    else:
        assert 0.0 < with_credit < 96.0
    utilisation = [
        float(mean_stress_utilisation(100.0, m, LIMIT, MATERIAL, rule)) for m in (-50.0, 0.0)
    ]
    assert utilisation == pytest.approx([0.4, 0.4], rel=1e-15)


def test_repeated_axial_load_has_the_safety_factors_of_the_book():
    """FT-04: Shigley, 9th ed., ex. 6-10 (kpsi); amplitude and mean grow together."""
    material = MeanStressMaterial(100.0, 84.0)
    band = mean_stress_band(8.38, 8.38, 33.9, material)
    safety = {rule: 1.0 / float(utilisation) for rule, utilisation in band.items()}
    expected = {
        "gerber": 3.663974285,
        "asme_elliptic": 3.751371851,
        "goodman": 3.021169576,
        "soderberg": 2.8821804,
    }
    for rule, value in expected.items():
        assert safety[rule] == pytest.approx(value, rel=1e-9)
    assert 1.0 / yield_utilisation(8.38, 8.38, 84.0) == pytest.approx(5.011933174, rel=1e-9)
    assert set(band) == {*expected, "swt"}  # no numbers for morrow, walker and fkm


def test_the_guidelines_factor_holds_in_all_four_fields():
    """FT-08: FKM guideline, chapter 4.4, overload case F2; from R = 0.5 on it is constant."""
    means = [-150.0, -100.0, -50.0, 0.0, 50.0, 100.0, 150.0, 300.0, 350.0]
    factors = [10 / 7, 10 / 7, 1 / 0.85, 1.0, 1 / 1.15, 1 / 1.3, 11 / 14.95, 1.1 / 1.69, 1.1 / 1.69]
    equivalent = [70.0, 70.0, 85.0, 100.0, 115.0, 130.0, 1495 / 11, 1690 / 11, 1690 / 11]
    assert_allclose(factors[6:8], [0.7357859532, 0.650887574], rtol=1e-9)  # as the case prints
    assert_allclose(equivalent[6:8], [135.9090909, 153.6363636], rtol=1e-9)
    assert_allclose(fkm_factor(100.0, means, 0.3), factors, rtol=ROUND_OFF)
    found = equivalent_amplitude(100.0, means, MATERIAL, "fkm", credit=True)
    assert_allclose(found, equivalent, rtol=ROUND_OFF)


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


def test_goodman_is_the_rule_of_the_verdict():
    amplitude, mean = np.meshgrid([0.0, 30.0, 300.0], [-100.0, 0.0, 250.0, 900.0])
    found = mean_stress_utilisation(amplitude, mean, LIMIT, MATERIAL)
    assert_allclose(found, goodman_utilisation(amplitude, mean, LIMIT, 800.0), rtol=1e-15)


@given(amplitudes, means, rules, st.booleans())
@settings(deadline=None)
def test_the_utilisation_is_1_on_the_line_and_doubles_with_the_load(amplitude, mean, rule, credit):
    utilisation = float(
        mean_stress_utilisation(amplitude, mean, LIMIT, MATERIAL, rule, credit=credit)
    )
    assert utilisation >= 0.0
    doubled = mean_stress_utilisation(
        2.0 * amplitude, 2.0 * mean, LIMIT, MATERIAL, rule, credit=credit
    )
    assert doubled == pytest.approx(2.0 * utilisation, rel=1e-12)
    if utilisation > 1e-3 and amplitude > 1.0:
        factor = 1.0 / utilisation
        on_line = equivalent_amplitude(
            factor * amplitude, factor * mean, MATERIAL, rule, credit=credit
        )
        # the line is steep near the strength of the rule: the tolerance follows the slope
        assert on_line == pytest.approx(LIMIT, rel=1e-9)


@given(amplitudes, means, st.floats(0.0, 500.0), rules, st.booleans())
@settings(deadline=None)
def test_a_higher_mean_never_does_less_damage(amplitude, mean, more, rule, credit):
    low, high = equivalent_amplitude(amplitude, [mean, mean + more], MATERIAL, rule, credit=credit)
    assert high >= low * (1.0 - 1e-14)
    low, high = mean_stress_utilisation(
        amplitude, [mean, mean + more], LIMIT, MATERIAL, rule, credit=credit
    )
    assert high >= low * (1.0 - 1e-14)


@given(amplitudes, means, st.floats(0.0, 500.0), rules, st.booleans())
@settings(deadline=None)
def test_a_larger_amplitude_never_does_less_damage(amplitude, mean, more, rule, credit):
    low, high = equivalent_amplitude(
        [amplitude, amplitude + more], mean, MATERIAL, rule, credit=credit
    )
    assert high >= low * (1.0 - 1e-14)


@given(amplitudes, means, rules, st.sampled_from([1e-3, 6.894757, 1e6]))
@settings(deadline=None)
def test_other_units_of_stress_change_nothing(amplitude, mean, rule, unit):
    scaled = MeanStressMaterial(800.0 * unit, 600.0 * unit, 1000.0 * unit, 0.65, 0.3)
    found = equivalent_amplitude(unit * amplitude, unit * mean, scaled, rule)
    expected = equivalent_amplitude(amplitude, mean, MATERIAL, rule)
    near_strength = float(expected) > 1e6  # there round-off in the mean decides
    assert near_strength or found == pytest.approx(unit * expected, rel=1e-9)


@pytest.mark.parametrize(
    ("rule", "strength"),
    [("goodman", 800.0), ("gerber", 800.0), ("soderberg", 600.0), ("asme_elliptic", 600.0),
     ("morrow", 1000.0)],
)  # fmt: skip
def test_a_mean_at_the_strength_is_endured_with_no_amplitude(rule, strength):
    for mean in (strength, 1.5 * strength):
        found = equivalent_amplitude([0.0, 1e-9, 100.0], mean, MATERIAL, rule)
        assert found.tolist() == [np.inf] * 3
    assert mean_stress_utilisation(0.0, strength, LIMIT, MATERIAL, rule) == 1.0


@pytest.mark.parametrize("rule", RULES)
def test_extremes_have_finite_utilisations(rule):
    """Nothing, constant tension, constant compression, above ultimate, wholly compressive."""
    amplitude = np.array([0.0, 0.0, 0.0, 900.0, 50.0, 1e-300])
    mean = np.array([0.0, 100.0, -100.0, 0.0, -500.0, 1.0])
    for credit in (False, True):
        found = mean_stress_utilisation(amplitude, mean, LIMIT, MATERIAL, rule, credit=credit)
        assert np.isfinite(found).all()
        assert found[0] == found[2] == 0.0
        assert found[3] == pytest.approx(3.6)
    assert yield_utilisation(amplitude, mean, 600.0)[2] == pytest.approx(100.0 / 600.0)


def test_an_endurance_limit_per_point_goes_with_stresses_per_point():
    found = mean_stress_utilisation([10.0, 20.0], 0.0, [100.0, 400.0], MATERIAL)
    assert found.tolist() == [0.1, 0.05]


def test_numbers_without_sense_are_refused_with_their_place():
    with pytest.raises(ValueError, match=r"half the range, is below 0 MPa: -5 at cycle 1"):
        equivalent_amplitude([5.0, -5.0], 0.0, MATERIAL)
    with pytest.raises(ValueError, match=r"mean stress is not finite: nan at point 0, cycle 1"):
        equivalent_amplitude(1.0, [[0.0, np.nan]], MATERIAL)
    with pytest.raises(ValueError, match=r"endurance limit must be above 0 MPa: 0 at point 1"):
        mean_stress_utilisation(1.0, 0.0, [1.0, 0.0], MATERIAL)
    with pytest.raises(ValueError, match="rule 'godman' is unknown; one of goodman, gerber"):
        equivalent_amplitude(1.0, 0.0, MATERIAL, "godman")
    with pytest.raises(ValueError, match="'walker' needs the material's Walker exponent"):
        equivalent_amplitude(1.0, 0.0, MeanStressMaterial(800.0, 600.0), "walker")
    with pytest.raises(ValueError, match="the yield strength must be above 0 MPa, got -1"):
        MeanStressMaterial(800.0, -1.0)
    with pytest.raises(ValueError, match="Walker's exponent must be above 0 and at most 1"):
        MeanStressMaterial(800.0, 600.0, walker_exponent=1.5)
    with pytest.raises(ValueError, match=r"at least 0 and below 1, got -0\.1"):
        MeanStressMaterial(800.0, 600.0, mean_stress_sensitivity=-0.1)
    with pytest.raises(ValueError, match="sensitivity must be at least 0 and below 1, got 1"):
        fkm_factor(1.0, 0.0, 1.0)
