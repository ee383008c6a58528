"""Whole results that are kept: what counts as a difference between two of them."""

import math

import pytest

from bench.frozen import differences, steady

RESULT = {
    "name": "press",
    "timings": {"read": 0.1},
    "parts": [{"value": 207.1, "status": "pass", "rungs": [{"rung": "formula", "seconds": 0.2}]}],
}


def told(new, tolerance=0.0):
    return list(differences(steady(RESULT), steady(new), tolerance))


def part(**changes):
    return RESULT | {"parts": [RESULT["parts"][0] | changes]}


def test_times_are_no_part_of_a_result():
    later = part(rungs=[{"rung": "formula", "seconds": 9.0}]) | {"timings": {"read": 7.0}}
    assert told(later) == []


@pytest.mark.parametrize(
    ("new", "where"),
    [
        (part(value=math.nextafter(207.1, 300.0)), "/parts[0]/value"),  # the last bit
        (part(value="207.1"), "/parts[0]/value"),
        (part(status="FAIL"), "/parts[0]/status"),
        (part(place="bore"), "/parts[0]/place: only in the new result"),
        (RESULT | {"parts": []}, "/parts: 1 entries before, 0 now"),
        ({"name": "press"}, "/parts: only in the old result"),
    ],
)
def test_a_difference_is_told_with_its_place(new, where):
    (line,) = told(new)
    assert line.startswith(where)


def test_a_tolerance_lets_pass_what_is_within_it_and_no_more():
    assert told(part(value=207.1 * (1 + 5e-10)), 1e-9) == []
    assert len(told(part(value=207.1 * (1 + 2e-9)), 1e-9)) == 1
