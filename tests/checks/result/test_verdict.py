"""Checks, gates and surfaces as data: ends of the bars, bare surfaces, plain data and back."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from checks.result.verdict import NOT_MESHED, Check, Status
from reports.page_words import reach_words

from ...reports import results
from ...reports.test_derivation import explained


def test_the_ends_of_the_bars_hold_both_bars():
    check = results.check(value=100.0, numerical=4.0, model=20.0, model_below=10.0)
    assert (check.upper, check.lower) == (124.0, 86.0)
    assert replace(check, model_below=None).lower == 76.0
    open_ended = replace(check, numerical=inf)
    assert (open_ended.upper, open_ended.lower) == (inf, -inf)
    assert open_ended.status is Status.UNDECIDED


def test_numbers_of_numpy_are_written_as_python_writes_them():
    """The page of a linkage whose bar was one of NumPy's ended with a traceback."""
    names = ("value", "numerical", "model", "model_below", "limit", "required", "loads", "sampling")
    check = results.check(**dict.fromkeys(names, np.float64(1.5)))
    assert {type(getattr(check, name)) for name in names} == {float}
    assert reach_words(check) == "up to 4.50"


def test_a_surface_is_bare_where_nothing_but_its_shape_is_known():
    box = results.box()
    nothing = {NOT_MESHED: np.zeros(len(box.nodes))}
    assert replace(box, fields=nothing).is_bare
    assert not box.is_bare
    assert not replace(box, fields=nothing | box.fields).is_bare
    assert not replace(box, fields={}).is_bare


@pytest.mark.parametrize("check", [results.PASSING, results.SINGULAR, explained()])
def test_a_check_comes_back_from_its_plain_data(check):
    again = Check.from_dict(check.to_dict() | {"governing": True})
    assert replace(again, model_below=check.model_below) == check
    assert again.below == check.below
    assert again.derivation == check.derivation


@pytest.mark.parametrize(
    "data",
    [
        "a check",
        None,
        results.PASSING.to_dict() | {"value": "1"},
        results.PASSING.to_dict() | {"part": 1},
        results.PASSING.to_dict() | {"limit": 0.0},
        results.PASSING.to_dict() | {"limit": 1e-300, "value": 1e300},
        {name: value for name, value in results.PASSING.to_dict().items() if name != "method"},
        results.PASSING.to_dict() | {"derivation": {}},
    ],
)
def test_what_is_no_check_is_refused(data):
    with pytest.raises((TypeError, ValueError)):
        Check.from_dict(data)


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("value", "1", "value: '1' is no number"),
        ("part", 1, "part: '1' is no text"),
        ("model", [], r"model: '\[\]' is no number"),
        ("derivation", {}, "derivation: not a derivation"),
        ("part", "\ud800", "part: .*surrogates not allowed"),
    ],
)
def test_the_key_of_a_wrong_value_is_named(key, value, said):
    with pytest.raises((TypeError, ValueError), match=f"^{said}"):
        Check.from_dict(results.PASSING.to_dict() | {key: value})


def test_what_a_check_lacks_is_named():
    with pytest.raises(TypeError, match="a check must have part, kind, quantity"):
        Check.from_dict({})


def test_a_check_without_some_of_its_doubts_has_the_bars_of_the_others():
    doubts = (("speed", 6.0, 2.0), ("play", 3.0, 1.0))
    check = replace(results.PASSING, model=20.0, model_below=9.0, doubts=doubts)
    without = check.without(doubts[:1])
    assert (without.model, without.below) == pytest.approx((14.0, 7.0))
    without = check.without(doubts)
    assert (without.model, without.below) == pytest.approx((11.0, 6.0))
    endless = ("play", inf, 0.0)
    assert replace(check, model=inf).without([endless]).model == inf
