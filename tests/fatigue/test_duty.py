"""Duties of several blocks: against long histories written out, and against all orders."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fatigue import count_closed_cycles, duty_cycles

blocks = st.lists(
    st.tuples(st.lists(st.integers(-9, 9), min_size=1, max_size=6), st.integers(1, 4)),
    min_size=1,
    max_size=4,
)


def as_table(cycles):
    """How often each (valley, peak) was counted, cycles without amplitude left out."""
    table = {}
    for low, high, n in zip(cycles.valley, cycles.peak, cycles.cycle_counts, strict=True):
        if n > 0.0 and high > low:
            key = (float(low), float(high))
            table[key] = table.get(key, 0.0) + float(n)
    return table


def damage(cycles, slope=5.0):
    return float((cycles.cycle_counts * cycles.stress_amplitude**slope).sum())


def n_beyond(cycles, low, high):
    """Cycles that reach to `low` or below and to `high` or above."""
    reach = (cycles.valley <= low) & (cycles.peak >= high)
    return float(cycles.cycle_counts[reach].sum())


@given(blocks, st.integers(0, 9))
@settings(deadline=None)
def test_one_block_alone_is_its_closed_count(duty, shift):
    history, n = duty[0]
    expected = as_table(count_closed_cycles(history).repeated(n))
    assert as_table(duty_cycles([np.roll(history, shift)], [n])) == expected


def test_the_cycle_between_the_extremes_of_two_blocks_is_counted():
    """Ground-air-ground: 20 flights of 0..100 MPa amid a million cycles of 0..-60."""
    cycles = duty_cycles([[0.0, 100.0], [-60.0, 0.0]], [20, 1e6])
    assert as_table(cycles) == {(-60.0, 100.0): 20.0, (-60.0, 0.0): 1e6 - 20.0}


def test_ripple_stays_with_its_block():
    cycles = duty_cycles([[0.0, 100.0, 80.0, 90.0], [-50.0, 10.0]], [3, 2])
    expected = {(-50.0, 100.0): 2.0, (0.0, 100.0): 1.0, (80.0, 90.0): 3.0, (0.0, 10.0): 2.0}
    assert as_table(cycles) == expected


def test_a_standstill_makes_start_stop_cycles():
    """A machine under 80 to 100 MPa that stops 5 times: 5 cycles from nothing to 100."""
    cycles = duty_cycles([[80.0, 100.0], [0.0]], [1e6, 5])
    assert as_table(cycles) == {(0.0, 100.0): 5.0, (80.0, 100.0): 1e6 - 5.0}


@given(st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=2, max_size=5))
@settings(max_examples=60, deadline=None)
def test_no_order_of_simple_blocks_has_more_cycles_beyond_any_two_levels(extremes):
    """Every order of blocks of one peak and one valley, written out and counted."""
    bound = duty_cycles([list(pair) for pair in extremes], [1] * len(extremes))
    levels = sorted({value for pair in extremes for value in pair})
    for order in permutations(sorted((max(p), min(p)) for p in extremes)):
        cycles = count_closed_cycles(np.concatenate(order))
        for i, low in enumerate(levels):
            for high in levels[i + 1 :]:
                assert n_beyond(cycles, low, high) <= n_beyond(bound, low, high)
        assert damage(cycles) <= damage(bound) * (1.0 + 1e-12)


def test_the_unknown_order_of_two_blocks_is_the_worst_one_and_no_worse():
    """Alternating strokes and idle turns, written out: here the bound is reached."""
    stroke, idle = [0.0, 100.0], [-30.0, 60.0]
    alternating = count_closed_cycles(np.array([*stroke[::-1], *idle[::-1]] * 7)[::-1])
    bound = duty_cycles([stroke, idle], [7, 7])
    assert as_table(bound) == {(-30.0, 100.0): 7.0, (0.0, 60.0): 7.0}
    assert damage(bound) == pytest.approx(damage(alternating), rel=1e-12)


@given(blocks, st.floats(0.1, 100.0))
@settings(deadline=None)
def test_all_counts_multiplied_multiply_the_cycles(duty, factor):
    histories, counts = zip(*duty, strict=True)
    one = duty_cycles(histories, counts)
    more = duty_cycles(histories, [factor * n for n in counts])
    assert damage(more) == pytest.approx(factor * damage(one), rel=1e-9, abs=1e-9)


def test_the_rounding_of_summed_counts_makes_no_cycles():
    """0.1 + 0.2 is not 0.3 in floating point."""
    cycles = duty_cycles([[0.0, 9.0], [-1.0, 8.0], [-2.0, 7.0]], [0.1, 0.2, 0.3])
    expected = {(-2.0, 9.0): 0.1, (-2.0, 8.0): 0.2, (-1.0, 7.0): 0.2, (0.0, 7.0): 0.1}
    assert as_table(cycles) == pytest.approx(expected)


@given(blocks)
@settings(deadline=None)
def test_the_order_in_which_blocks_are_named_changes_nothing_when_it_is_unknown(duty):
    histories, counts = zip(*duty, strict=True)
    backwards = duty_cycles(histories[::-1], counts[::-1])
    assert as_table(backwards) == as_table(duty_cycles(histories, counts))


def test_many_points_are_counted_as_each_of_them_alone():
    rng = np.random.default_rng(3)
    histories = [rng.integers(-9, 9, size=(20, n)).astype(float) for n in (6, 4, 1)]
    counts = [1000, 3, 20]
    together = duty_cycles(histories, counts)
    for point in range(20):
        alone = duty_cycles([block[point] for block in histories], counts)
        n = len(alone.cycle_counts)
        assert together.stress_amplitude[point, :n].tolist() == alone.stress_amplitude.tolist()
        assert together.mean_stress[point, :n].tolist() == alone.mean_stress.tolist()
        assert together.cycle_counts[point, :n].tolist() == alone.cycle_counts.tolist()
        assert not together.cycle_counts[point, n:].any()


def test_duties_that_make_no_sense_are_refused():
    with pytest.raises(ValueError, match="1 blocks and 2 counts"):
        duty_cycles([[1.0]], [1, 2])
    with pytest.raises(ValueError, match="at least one block"):
        duty_cycles([], [])
    with pytest.raises(ValueError, match=r"must be above 0: 0 at block 1"):
        duty_cycles([[1.0], [2.0]], [1, 0])
    with pytest.raises(ValueError, match=r"hold the same points, got the shapes"):
        duty_cycles([[[1.0, 2.0]], [[1.0], [2.0]]], [1, 1])
    with pytest.raises(ValueError, match=r"nan at position 1"):
        duty_cycles([[1.0, np.nan]], [1])
