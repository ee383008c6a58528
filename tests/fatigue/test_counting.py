"""Rainflow: the standard's example, the residue, and an independent four-point counter."""

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from fatigue import Cycles, count_closed_cycles

# FT-01: ASTM E1049-85, 5.4.4, figure 6
ASTM = [-2, 1, -3, 5, -1, 3, -4, 4, -2]
# FT-02: as in the rainflow verification case of code_aster
RESIDUE = [0, 500, 200, 400, 300, 500, -300, 200, -500]

whole_histories = st.lists(st.integers(-20, 20), min_size=1, max_size=40)


def as_counter(cycles):
    """How often each (range, mean) was counted."""
    table = Counter()
    parts = (cycles.stress_range, cycles.mean_stress, cycles.cycle_counts)
    for stress_range, mean, n in zip(*map(np.ravel, parts), strict=True):
        if n > 0.0:
            table[float(stress_range), float(mean)] += float(n)
    return table


def four_point_closed(history):
    """Amzallag et al. (1994): the four-point rule, then once more over the residue twice."""

    def turning(values):
        kept = []
        for value in values:
            if kept and value == kept[-1]:
                continue
            if len(kept) > 1 and (kept[-1] - kept[-2]) * (value - kept[-1]) > 0:
                kept.pop()
            kept.append(value)
        return kept

    def extract(values, found):
        stack = []
        for value in values:
            stack.append(value)
            while len(stack) >= 4:
                a, b, c, d = stack[-4:]
                if abs(b - c) > abs(a - b) or abs(b - c) > abs(c - d):
                    break
                found[float(abs(b - c)), (b + c) / 2.0] += 1.0
                del stack[-3:-1]
        return stack

    closed = turning([*history, history[0]])
    residue = extract(closed, Counter())
    found = Counter()
    extract(closed, found)
    extract(turning(residue + residue), found)
    return found


def test_the_astm_example_is_counted_exactly():
    """Whole numbers, so no tolerance: the example begins and ends at its highest peak, 5.

    Read on from there: 5, -1, 3, -4, 4, -2, -2, 1, -3, 5 has the cycles 3 -1 (4, mean 1),
    1 -2 (3, mean -0.5), 4 -3 (7, mean 0.5) and 5 -4 (9, mean 0.5).
    """
    expected = {(4.0, 1.0): 1.0, (3.0, -0.5): 1.0, (7.0, 0.5): 1.0, (9.0, 0.5): 1.0}
    assert as_counter(count_closed_cycles(ASTM)) == expected


def test_a_repeated_history_closes_its_residue():
    """FT-02, residue repeated: ranges 100, 300, 500 and 1000, once each."""
    cycles = count_closed_cycles(RESIDUE)
    assert cycles.stress_range.tolist() == [1000.0, 500.0, 300.0, 100.0]
    assert cycles.stress_amplitude.tolist() == [500.0, 250.0, 150.0, 50.0]
    assert cycles.cycle_counts.tolist() == [1.0] * 4
    assert (cycles.cycle_counts * cycles.stress_amplitude**5).sum() == 32302812500000.0


@given(whole_histories)
@settings(deadline=None)
def test_closed_counts_are_those_of_the_four_point_rule_with_its_residue_repeated(history):
    counted = as_counter(count_closed_cycles(history))
    if len(set(history)) == 1:
        assert counted == {(0.0, float(history[0])): 1.0}
    else:
        assert counted == four_point_closed(history)


@given(whole_histories, st.integers(0, 100))
@settings(deadline=None)
def test_where_a_closed_history_is_cut_open_changes_nothing(history, shift):
    turned = np.roll(history, shift)
    assert as_counter(count_closed_cycles(turned)) == as_counter(count_closed_cycles(history))


@given(whole_histories)
@settings(deadline=None)
def test_dwells_and_points_on_the_way_change_nothing(history):
    between = [(a + b) / 2 for a, b in pairwise(history)]
    finer = [v for pair in zip(history, between, strict=False) for v in (pair[0], *pair)]
    finer += [history[-1]] * 2
    assert as_counter(count_closed_cycles(finer)) == as_counter(count_closed_cycles(history))


@given(whole_histories)
@settings(deadline=None)
def test_the_opposite_stress_has_the_opposite_means(history):
    opposite = as_counter(count_closed_cycles(-np.array(history)))
    expected = {(r, -m): n for (r, m), n in as_counter(count_closed_cycles(history)).items()}
    assert opposite == expected


@given(whole_histories)
@settings(deadline=None)
def test_each_peak_and_each_valley_of_a_closed_history_is_in_one_cycle(history):
    cycles = count_closed_cycles(history)
    turning = [v for i, v in enumerate(history) if v != history[i - 1]]
    n_peaks = sum(
        turning[i - 1] > turning[i - 2] and turning[i - 1] > turning[i] for i in range(len(turning))
    )
    assert cycles.cycle_counts.sum() == max(1, n_peaks)
    assert cycles.peak[0] == max(history)
    assert cycles.valley[0] == min(history)


@given(st.lists(st.lists(st.integers(-9, 9), min_size=7, max_size=7), min_size=1, max_size=6))
@settings(deadline=None)
def test_many_points_are_counted_as_each_of_them_alone(histories):
    together = count_closed_cycles(histories)
    for point, history in enumerate(histories):
        alone = count_closed_cycles(history)
        n = len(alone.cycle_counts)
        for name in ("stress_amplitude", "mean_stress", "cycle_counts"):
            row = getattr(together, name)[point]
            assert_array_equal(row[:n], getattr(alone, name))
            assert not row[n:].any()


def test_many_points_are_counted_in_blocks(monkeypatch):
    monkeypatch.setattr("fatigue.stress_path.BLOCK", 1)
    histories = np.array([[0.0, 3.0, 1.0, 2.0], [5.0, 5.0, 5.0, 5.0], [1.0, -1.0, 1.0, -1.0]])
    cycles = count_closed_cycles(histories)
    assert cycles.stress_range.tolist() == [[3.0, 1.0], [0.0, 0.0], [2.0, 0.0]]
    assert cycles.cycle_counts.tolist() == [[1.0, 1.0], [1.0, 0.0], [2.0, 0.0]]


@pytest.mark.parametrize("history", [[7.0], [7.0, 7.0], [7.0] * 5])
def test_a_constant_stress_keeps_its_mean_as_a_cycle_without_amplitude(history):
    cycles = count_closed_cycles(history)
    assert as_counter(cycles) == {(0.0, 7.0): 1.0}


def test_two_positions_are_one_cycle():
    assert as_counter(count_closed_cycles([-10.0, 30.0])) == {(40.0, 10.0): 1.0}


def test_a_single_spike_is_one_cycle_from_zero():
    history = np.zeros(1000)
    history[400] = 90.0
    assert as_counter(count_closed_cycles(history)) == {(90.0, 45.0): 1.0}


def test_round_off_is_not_counted_but_small_cycles_are():
    angle = np.linspace(0.0, 2.0 * np.pi, 72)
    noise = 1e-11 * (-1.0) ** np.arange(72)
    assert count_closed_cycles(100.0 * np.cos(angle) + noise).cycle_counts.tolist() == [1.0]
    assert count_closed_cycles(100.0 + noise).stress_amplitude.tolist() == [0.0]
    ripple = count_closed_cycles([0.0, 100.0, 50.0, 50.0 + 1e-6])
    assert ripple.stress_range.tolist() == pytest.approx([100.0, 1e-6])


@pytest.mark.parametrize("shift", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("n_positions", [24, 72, 720])
def test_coarse_positions_miss_no_more_of_a_peak_than_the_stated_sampling_error(n_positions, shift):
    """An extreme is missed by at most max|s''| step**2 / 8 (docs/theory/life.md)."""
    angle = 2.0 * np.pi * (np.arange(n_positions) + shift) / n_positions
    found = count_closed_cycles(100.0 * np.cos(angle) + 30.0 * np.cos(2.0 * angle))
    curvature = 100.0 + 4.0 * 30.0
    missed = curvature * (2.0 * np.pi / n_positions) ** 2 / 8.0
    # s' = 0 at the peaks 130 and -70 and at cos = -100/120, where s = -71.67
    valley = 100.0 * (-100.0 / 120.0) + 30.0 * (2.0 * (100.0 / 120.0) ** 2 - 1.0)
    exact = np.array([(130.0 - valley) / 2.0, (-70.0 - valley) / 2.0])
    amplitudes = found.stress_amplitude[:2]
    assert (amplitudes <= exact[: len(amplitudes)] + 1e-12).all()
    assert exact[0] - amplitudes[0] <= missed
    if n_positions == 720:
        assert_allclose(amplitudes, exact, rtol=0.0, atol=missed)
        assert exact[1] == pytest.approx(5.0 / 6.0)


def test_amplitudes_reach_the_largest_numbers_without_overflow():
    cycles = count_closed_cycles([-1.5e308, 1.5e308])
    assert cycles.stress_amplitude.tolist() == [1.5e308]
    smallest = count_closed_cycles([1e-300, 3e-300]).stress_amplitude
    assert smallest.tolist() == pytest.approx([1e-300], rel=1e-15, abs=0.0)


def test_stresses_that_differ_by_less_than_ranges_can_show_are_still_told_apart():
    """2 - 1e-119 is 2 in floating point, but the peak at -1e-119 is not that at 0."""
    cycles = count_closed_cycles([-2.0, 0.0, -1.0, -1e-119])
    assert as_counter(cycles) == {(2.0, -1.0): 1.0, (1.0, -0.5): 1.0}


def test_a_stress_that_is_no_number_is_refused_with_its_place():
    with pytest.raises(ValueError, match=r"not finite: nan at position 2 \(1 of 4\)"):
        count_closed_cycles([0.0, 1.0, np.nan, 2.0])
    with pytest.raises(ValueError, match=r"not finite: inf at point 1, position 0 \(1 of 4\)"):
        count_closed_cycles([[0.0, 1.0], [np.inf, 2.0]])


def test_histories_of_the_wrong_shape_are_refused():
    with pytest.raises(ValueError, match=r"at least one position, got \(0,\)"):
        count_closed_cycles([])


def test_cycles_without_sense_are_refused():
    one = np.ones(2)
    with pytest.raises(ValueError, match=r"below 0 MPa: -1 at cycle 1"):
        Cycles(np.array([1.0, -1.0]), one, one)
    with pytest.raises(ValueError, match=r"count is below 0: -2 at cycle 0"):
        Cycles(one, one, np.array([-2.0, 1.0]))
    with pytest.raises(ValueError, match=r"the mean of a cycle is not finite: nan at cycle 0"):
        Cycles(one, np.array([np.nan, 1.0]), one)
    with pytest.raises(ValueError, match=r"one shape"):
        Cycles(one, one, np.ones(3))


def test_repeating_cycles_multiplies_their_counts_only():
    cycles = count_closed_cycles(RESIDUE)
    again = cycles.repeated(1e9)
    assert again.cycle_counts.tolist() == [1e9] * 4
    assert again.stress_amplitude is cycles.stress_amplitude
    assert cycles.cycle_counts.tolist() == [1.0] * 4
