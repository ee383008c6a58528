"""Claims of docs/trade.md on the rungs, from the data it is made of."""

import pytest

from bench import trade_page

# what was not drawn near its limit may stay open in one check of ten
MOST_LEFT_OPEN = 0.10


@pytest.fixture(scope="module")
def rows():
    return trade_page.compared()


@pytest.fixture(scope="module")
def verdicts():
    return trade_page.rows_of("verdicts.jsonl")


def test_the_page_is_that_of_its_data():
    assert trade_page.PAGE.read_text(encoding="utf-8") == trade_page.page()


def test_the_bars_hold_95_of_100_solids(rows):
    inside, total, _, _ = trade_page.coverage(rows)["all"]
    assert inside / total >= 0.95


@pytest.mark.parametrize("rung", ["formula", "beam", "all"])
def test_a_median_bar_is_at_most_three_times_the_median_error(rows, rung):
    _, _, bar, error = trade_page.coverage(rows)[rung]
    assert bar <= 3 * error


def test_every_part_of_the_machines_was_compared(rows):
    compared = {row.variation for row in rows}
    assert {f"{scene.name}/0" for scene in trade_page.SCENES} <= compared


def test_auto_never_turns_a_solids_verdict_round(verdicts):
    """The verdict with its bars; where these hold the limit, that of its value but for 3 %."""
    opposite = {("pass", "FAIL"), ("FAIL", "pass")}
    assert [row for row in verdicts if (row["solid with bars"], row["auto"]) in opposite] == []
    for row in verdicts:
        if (row["solid"], row["auto"]) in opposite:
            assert abs(row["utilisation"] - 1) < 0.03


def test_forty_and_more_loadings_were_drawn_near_the_limit(verdicts):
    near = {(row["variation"]) for row in verdicts if row["drawn"] == "near"}
    assert len(near) >= 40


def test_auto_leaves_few_verdicts_open_that_are_away_from_the_limit(verdicts):
    far = [row for row in verdicts if abs(row["utilisation"] - 1) > trade_page.MARGIN]
    left = [row for row in far if row["auto"] == "UNDECIDED"]
    assert len(left) <= MOST_LEFT_OPEN * len(far)
