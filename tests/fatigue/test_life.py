"""Damage, life and safety of duties: textbook cases, rescaling, tendencies, extremes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fatigue import (
    Cycles,
    SNCurve,
    count_closed_cycles,
    duty_cycles,
    goodman_utilisation,
    life_verdict,
    miner_damage,
)

CURVE = SNCurve(knee_amplitude=100.0, knee_cycles=1e6, slope=5.0)
ULTIMATE = 800.0

# FT-14
AMPLITUDES = np.array([250.0, 180.0, 120.0, 80.0, 40.0])
COUNTS = np.array([100.0, 2000.0, 20000.0, 200000.0, 1000000.0])

VARIANTS = ("original", "elementary", "haibach")


def cycles(amplitude, mean, counts):
    return Cycles(*(np.array(values, dtype=float) for values in (amplitude, mean, counts)))


@pytest.mark.parametrize(
    ("variant", "expected"),
    [("original", 0.097323385), ("elementary", 0.173099385), ("haibach", 0.1244290746)],
)
def test_a_block_programme_does_the_damage_of_the_closed_form(variant, expected):
    """FT-14, to the digits of the case, and the closed form itself to round-off."""
    curve = CURVE.below_knee(variant)
    found = miner_damage(AMPLITUDES, COUNTS, curve)
    assert found == pytest.approx(expected, rel=1e-9)
    slopes = np.where(AMPLITUDES >= 100.0, 5.0, curve.slope_below)
    assert found == pytest.approx(sum(COUNTS / 1e6 * (AMPLITUDES / 100.0) ** slopes), rel=1e-12)


def test_the_programme_is_endured_ten_times():
    """FT-14: 10.2750228 blocks to failure by the original rule."""
    programme = cycles(AMPLITUDES, 0 * AMPLITUDES, COUNTS)
    verdict = life_verdict(programme, CURVE, ULTIMATE)
    assert (1.0 / verdict.damage).tolist() == pytest.approx([10.2750228], rel=1e-9)
    assert verdict.damage.tolist() == pytest.approx([0.097323385], rel=1e-9)
    assert verdict.infinite_utilisation.tolist() == pytest.approx([2.5], rel=1e-14)
    assert verdict.safety[0] > 1.0
    strict = life_verdict(programme, CURVE, ULTIMATE, allowed_damage=0.3 / 3.1)
    assert strict.safety[0] < 1.0


@pytest.mark.parametrize("variant", VARIANTS)
def test_stresses_times_the_safety_do_just_the_allowed_damage(variant):
    """Where damage is continuous; at the jump of the original rule, never more than allowed."""
    curve = CURVE.below_knee(variant)
    duty = cycles([[150.0, 60.0], [30.0, 10.0]], [[100.0, -20.0], [250.0, 5.0]], [[2e3, 1e5]] * 2)
    verdict = life_verdict(duty, curve, ULTIMATE, allowed_damage=0.5 / 40.0)
    factor = verdict.safety[:, None]
    scaled = Cycles(factor * duty.stress_amplitude, factor * duty.mean_stress, duty.cycle_counts)
    again = life_verdict(scaled, curve, ULTIMATE, allowed_damage=0.5 / 40.0)
    assert_allclose(again.safety, 1.0, rtol=1e-12)
    if variant == "original":
        assert (again.damage * 40.0 <= 0.5 * (1.0 + 1e-9)).all()
        beyond = cycles(
            1.000001 * scaled.stress_amplitude, 1.000001 * scaled.mean_stress, duty.cycle_counts
        )
        assert (life_verdict(beyond, curve, ULTIMATE).damage * 40.0 > 0.5).all()
    else:
        assert_allclose(again.damage * 40.0, 0.5, rtol=1e-9)


def test_the_safety_of_one_frequent_cycle_is_that_of_the_goodman_verdict():
    """With an endurance limit and enough cycles, finite and infinite life are the same question."""
    verdict = life_verdict(cycles([60.0], [120.0], [1e9]), CURVE, ULTIMATE)
    utilisation = float(goodman_utilisation(60.0, 120.0, 100.0, ULTIMATE))
    assert utilisation == pytest.approx(0.6 + 0.15, rel=1e-15)
    assert verdict.infinite_utilisation.tolist() == [utilisation]
    assert verdict.safety.tolist() == pytest.approx([1.0 / utilisation], rel=1e-12)
    assert verdict.damage.tolist() == [0.0]
    assert (verdict.infinite_utilisation <= 1).all()


def test_the_weakest_point_is_critical():
    curve = SNCurve(np.array([100.0, 80.0, 100.0]), 1e6, 5.0)
    duty = cycles([[90.0], [90.0], [20.0]], np.zeros((3, 1)), [[1e7]] * 3)
    verdict = life_verdict(duty, curve, ULTIMATE)
    assert verdict.critical == 1
    assert verdict.infinite_utilisation.tolist() == pytest.approx([0.9, 1.125, 0.2])
    assert verdict.damage[0] == verdict.damage[2] == 0.0 < 1.0 < verdict.damage[1]


def test_a_duty_runs_through_counting_mean_stress_and_damage():
    """By hand: stroke 0..240 MPa 1000 times, standstill at -40 MPa 10 times.

    10 cycles of amplitude 140, mean 100: 140/(1 - 100/800) = 160. 990 of 120, 120: 141.176.
    """
    duty = duty_cycles([[0.0, 240.0], [-40.0]], [1000, 10])
    verdict = life_verdict(duty, CURVE, ULTIMATE)
    expected = 10.0 / 1e6 * 1.6**5 + 990.0 / 1e6 * (1.2 / 0.85) ** 5
    assert verdict.damage.tolist() == pytest.approx([expected], rel=1e-12)
    assert verdict.infinite_utilisation.tolist() == pytest.approx([1.4 + 0.125], rel=1e-12)


def duties(most_mean=500.0):
    one = st.tuples(st.floats(0.0, 900.0), st.floats(-500.0, most_mean), st.floats(0.0, 1e9))

    def rows(values):
        values = np.array(values)
        values[np.abs(values) < 1e-100] = 0.0  # products of such numbers carry no digits
        return cycles(*values.T)

    return st.lists(one, min_size=1, max_size=5).map(rows)


@given(duties(), st.sampled_from(VARIANTS), st.floats(0.0, 300.0))
@settings(max_examples=60, deadline=None)
def test_a_higher_mean_never_lengthens_life(duty, variant, more):
    curve = CURVE.below_knee(variant)
    higher = Cycles(duty.stress_amplitude, duty.mean_stress + more, duty.cycle_counts)
    before, after = (life_verdict(d, curve, ULTIMATE) for d in (duty, higher))
    assert (after.damage >= before.damage * (1.0 - 1e-12)).all()
    assert (after.safety <= before.safety * (1.0 + 1e-12)).all()


@given(duties(), st.sampled_from(VARIANTS))
@settings(max_examples=60, deadline=None)
def test_twice_the_load_halves_the_safety(duty, variant):
    curve = CURVE.below_knee(variant)
    double = Cycles(2 * duty.stress_amplitude, 2 * duty.mean_stress, duty.cycle_counts)
    before, after = (life_verdict(d, curve, ULTIMATE) for d in (duty, double))
    assert_allclose(2.0 * after.safety, before.safety, rtol=1e-12)
    assert_allclose(after.infinite_utilisation, 2.0 * before.infinite_utilisation, rtol=1e-12)


@given(duties(), st.sampled_from(VARIANTS), st.floats(1.0, 1e6))
@settings(max_examples=60, deadline=None)
def test_more_duties_never_leave_more_safety(duty, variant, more):
    curve = CURVE.below_knee(variant)
    once = life_verdict(duty, curve, ULTIMATE)
    strict = life_verdict(duty, curve, ULTIMATE, allowed_damage=1.0 / more)
    assert (strict.safety <= once.safety).all()


@given(st.lists(st.floats(-300.0, 300.0), min_size=1, max_size=20), st.integers(0, 20))
@settings(deadline=None)
def test_where_a_closed_history_is_cut_open_changes_no_damage(history, shift):
    curve = CURVE.below_knee("haibach")
    first, second = (
        life_verdict(count_closed_cycles(h), curve, ULTIMATE).damage
        for h in (history, np.roll(history, shift))
    )
    assert_allclose(first, second, rtol=1e-12)


@given(duties(), st.sampled_from([1e-3, 145.0377]))
@settings(max_examples=60, deadline=None)
def test_other_units_of_stress_change_no_life(duty, unit):
    scaled = Cycles(unit * duty.stress_amplitude, unit * duty.mean_stress, duty.cycle_counts)
    curve = SNCurve(100.0 * unit, 1e6, 5.0, 9.0, ultimate_strength=800.0 * unit)
    here = SNCurve(100.0, 1e6, 5.0, 9.0, ultimate_strength=800.0)
    assert_allclose(
        life_verdict(scaled, curve, 800.0 * unit).safety,
        life_verdict(duty, here, ULTIMATE).safety,
        rtol=1e-9,
    )


def test_extremes_have_a_life():
    """Nothing, constant, above ultimate, mean at ultimate, compressive, 1e9 cycles, no count."""
    amplitude = [[0.0], [0.0], [900.0], [50.0], [50.0], [101.0], [900.0]]
    mean = [[0.0], [100.0], [0.0], [800.0], [-700.0], [0.0], [800.0]]
    counts = [[1.0], [1.0], [1.0], [1.0], [1.0], [1e9], [0.0]]
    curve = SNCurve(100.0, 1e6, 5.0, ultimate_strength=800.0)
    verdict = life_verdict(cycles(amplitude, mean, counts), curve, ULTIMATE)
    assert not np.isnan(verdict.safety).any()
    assert verdict.damage[[0, 1, 4, 6]].tolist() == [0.0] * 4
    assert verdict.infinite_utilisation[6] == 0.0
    assert verdict.safety[[0, 6]].tolist() == [np.inf, np.inf]
    assert verdict.damage[2] >= 1.0
    assert verdict.damage[5] == pytest.approx(1e3 * 1.01**5)
    assert verdict.damage[3] == np.inf
    assert verdict.safety[3] < 1.0


def test_damage_of_a_curve_per_point_goes_with_cycles_for_all():
    curve = SNCurve(np.array([100.0, 200.0]), 1e6, 5.0)
    assert miner_damage([200.0], [1e6], curve).tolist() == pytest.approx([32.0, 1.0])


def test_requirements_without_sense_are_refused():
    one = cycles([1.0], [0.0], [1.0])
    with pytest.raises(ValueError, match="allowed damage must be above 0, got 0"):
        life_verdict(one, CURVE, ULTIMATE, allowed_damage=0.0)
    with pytest.raises(ValueError, match="allowed damage must be above 0, got nan"):
        life_verdict(one, CURVE, ULTIMATE, allowed_damage=float("nan"))
    with pytest.raises(ValueError, match=r"cycle count must be at least 0: -1 at cycle 0"):
        miner_damage([1.0], [-1.0], CURVE)
