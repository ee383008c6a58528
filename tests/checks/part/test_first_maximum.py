"""Positions that load a part alike: every machine names the same one, the first."""

import numpy as np
import pytest

from checks.part.part_loads import TIE, first_largest

ONE_DIGIT = np.finfo(float).eps


def test_the_first_of_values_that_differ_by_round_off_is_named():
    values = np.array([1.0, 206.7, 206.7 * (1 + 4 * ONE_DIGIT), 5.0])
    assert values.argmax() == 2
    assert first_largest(values) == (1,)


def test_a_value_that_is_larger_by_more_than_round_off_is_named():
    assert first_largest(np.array([206.7, 206.7 * (1 + 3 * TIE), 5.0])) == (1,)


def test_of_tables_the_first_row_counts_before_the_first_column():
    table = np.array([[0.0, 2.0, 1.0], [2.0 * (1 + ONE_DIGIT), 0.0, 0.0]])
    assert first_largest(table) == (0, 1)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_only_round_off_apart_holds_for_values_of_either_sign(sign):
    values = sign * np.array([3.0, 3.0 * (1 + sign * ONE_DIGIT), 3.0 * (1 - sign * 1e-3)])
    assert first_largest(values) == (0,)


def test_no_values_are_refused():
    with pytest.raises(ValueError, match="zero-size"):
        first_largest(np.array([]))
