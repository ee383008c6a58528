"""When a check's bars leave its verdict alone, and when no better model can settle it."""

from dataclasses import replace
from math import inf

import pytest

from checks.models.checked import Estimate
from checks.result.verdict import Check, Status

CHECK = Check(
    part="rod",
    kind="static",
    quantity="peak von Mises stress",
    value=100.0,
    unit="MPa",
    numerical=0.0,
    model=10.0,
    model_below=10.0,
    limit=300.0,
    required=1.0,
    cycle="turn",
    position="crank = 0 deg",
    place="bore",
    method="formula",
    basis="yield stress",
)


def estimate(limit, above=10.0, below=10.0, shared=(0.0, 0.0), guard=1.5):
    """A value of 100 whose own band is `above` and `below`, and one that all models share."""
    check = replace(CHECK, limit=limit, model=above + shared[0], model_below=below + shared[1])
    return Estimate(check, above, below, guard)


@pytest.mark.parametrize(
    ("limit", "settled"),
    [(116.0, True), (114.0, False), (86.0, False), (84.0, True)],
)
def test_a_verdict_is_settled_where_one_and_a_half_times_the_bars_leave_it(limit, settled):
    assert estimate(limit).settled is settled


def test_a_numerical_bar_counts_as_a_models_own():
    """100 + 12 + 4 holds 123; 100 + 1.5 (12 + 4) does not."""
    check = replace(CHECK, limit=123.0, numerical=12.0, model=4.0)
    assert not Estimate(check, 4.0, 4.0).settled
    assert Estimate(check, 4.0, 4.0, guard=1.0).settled


def test_what_all_models_share_is_not_widened():
    assert estimate(136.0, shared=(20.0, 0.0)).settled
    assert not estimate(134.0, shared=(20.0, 0.0)).settled


def test_a_shared_band_across_the_limit_stays_open_whatever_model_comes():
    """At 90 as at 110 the shared +40 -40 has the limit of 105 inside."""
    assert estimate(105.0, shared=(40.0, 40.0)).open_for_good


def test_a_better_model_may_leave_a_shared_band_on_one_side():
    """At 90 the shared +12 ends below 105: a pass; so a better model is worth it."""
    assert not estimate(105.0, shared=(12.0, 12.0)).open_for_good


def test_an_unknown_band_is_open_but_not_for_good():
    unknown = Estimate(replace(CHECK, model=inf, model_below=inf), inf, inf)
    assert unknown.check.status is Status.UNDECIDED
    assert not unknown.settled
    assert not unknown.open_for_good


def test_the_spread_is_what_a_better_model_takes_away():
    check = replace(CHECK, numerical=3.0)
    assert Estimate(check, 10.0, 4.0).spread == pytest.approx((10.0 + 4.0 + 6.0) / 100.0)
    assert Estimate(replace(check, value=0.0), 1.0, 1.0).spread == 0.0
