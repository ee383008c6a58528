from dataclasses import replace
from math import inf

import pytest
from rich.cells import cell_len

from checks.result.verdict import Gate
from checks.result.words import clean, number, safety_text, utilisation_text, value_and_bars
from reports.terminal import verdict_text, wrap

from . import results


def rows(text, part):
    return [line for line in text.splitlines() if line[2:].startswith(part)]


def test_each_check_shows_its_outcome_and_the_deciding_one_is_marked():
    text = verdict_text(results.mixed(), 140)
    static, undecided, fatigue = rows(text, "bar_upper")
    assert {"pass", "2.51", "(1.5)", "0.60"} <= set(static.split())
    assert "141 ±4 ±20 MPa" in static
    assert "UNDECIDED" in undecided
    assert {"FAIL", "0.833", "(1.3)", "1.56"} <= set(fatigue.split())
    assert [line[0] for line in (static, undecided, fatigue)] == [" ", " ", ">"]


def test_checks_of_the_same_kind_are_told_apart_by_their_quantity():
    text = verdict_text(results.mixed(), 160)
    assert "static (von Mises stress)" in text
    assert "fatigue (" not in text


def test_an_infinite_bar_is_called_singular_and_is_no_pass():
    singular = results.design(results.part(checks=[results.SINGULAR]))
    text = verdict_text(singular, 200)
    assert "±∞ (singular)" in text
    assert "no mesh settles it" in text
    assert "pass" not in text.lower()


def test_an_infinite_model_bar_is_unknown_and_not_singular():
    unknown = results.design(results.part(checks=[results.check(model=inf)]))
    assert "±4 ±∞ (unknown)" in verdict_text(unknown, 140)


def test_a_pass_says_under_how_many_assumptions():
    text = verdict_text(results.design(), 120)
    assert "PASS (under 2 assumptions); decided by bar_upper static, safety 2.51" in text
    assert "FAIL" not in text
    assert "UNDECIDED" not in text


def test_what_several_parts_assume_in_the_same_words_is_one_assumption():
    text = verdict_text(results.mixed(), 200)
    assert "ASSUMED  2: " in text
    assert "bar_upper, pin_B (bearing arc 120 deg)" in text


def test_the_ends_of_an_undecided_range_lie_on_both_sides_of_what_is_needed():
    """Limit over value 1.2987 to 1.3013: rounding both the same way would hide why."""
    close = results.check(value=100.0, numerical=0.1, model=0.0, limit=130.0, required=1.3)
    text = verdict_text(results.design(results.part(checks=[close])), 200)
    assert "between 1.298 and 1.302 within its error bars" in text


def test_where_and_by_which_method_stand_uncut_below_each_check():
    passing = results.check(place="knee bore (22.000, -0.000, -40.000) of the cheek" + " far" * 12)
    for width in (60, 100):
        text = verdict_text(results.design(results.part(checks=[passing])), width)
        assert "…" not in text
        below = " ".join(line.strip() for line in text.splitlines() if line.startswith(" " * 6))
        assert f"{passing.place}, press: x = 2 mm; {passing.method}" in below


def test_an_undecided_check_says_whether_a_finer_mesh_helps():
    mesh = results.check(value=225.0, numerical=30.0, model=2.0)
    assert "a finer mesh can settle it" in verdict_text(
        results.design(results.part(checks=[mesh])), 200
    )
    undecided = verdict_text(results.design(results.part(checks=[results.UNDECIDED])), 200)
    assert "which no finer mesh narrows" in " ".join(undecided.split())


def test_a_broken_gate_takes_the_pass_away_and_is_named():
    broken = results.design(gates=[Gate("loop closure", 3e-3, 1e-9, "the joints gape")])
    text = verdict_text(broken, 200)
    assert "NOT VALID  loads: loop closure: 0.00300 > 1e-09; the joints gape" in text
    assert (
        "UNDECIDED: every check passes, but these validity checks do not hold: loads loop closure"
        in text
    )


def test_a_result_without_checks_is_undecided_and_not_a_crash():
    empty = results.design(results.part(checks=[]))
    assert "UNDECIDED: nothing was checked" in verdict_text(empty, 100)


def test_warnings_gaps_assumptions_timings_and_the_report_are_there():
    text = verdict_text(results.design(overrides=["parts.a.wall=5mm"]), 120, "out/a b/report.html")
    for line in (
        "SET      parts.a.wall=5mm",
        "WARNING  stroke takes 4.2 s, duty allows 3.0 s",
        "NOT CHECKED  contact fatigue, wear, frame",
        "25.2 s: mesh 6.0, solve 19.2",
        "report: out/a b/report.html",
    ):
        assert line in text.splitlines()
    assert "ASSUMED  2: cycles.press.stop (x = 2 mm, nothing mechanical" in text


@pytest.mark.parametrize("width", [100, 120])
@pytest.mark.parametrize("make", [results.mixed, results.hostile])
def test_no_line_is_wider_than_the_terminal(make, width):
    lines = verdict_text(make(), width).splitlines()
    assert max(cell_len(line) for line in lines) <= width
    assert len(lines) < 80


def test_hostile_names_cannot_steer_the_terminal():
    text = verdict_text(results.hostile(), 100)
    assert not {"\x1b", "\u202e", "\x00"} & set(text)


def test_wrapping_keeps_every_letter_and_the_width():
    text = "short " + "x" * 33 + " 😀😀😀😀😀😀 end"
    lines = wrap(text, 10)
    assert max(map(cell_len, lines)) <= 10
    assert "".join(lines).replace(" ", "") == text.replace(" ", "")


def test_a_key_breaks_behind_its_dots_and_underscores():
    key = "parts.bar_upper.inner_radius"
    assert wrap(key, 26) == ["parts.bar_upper.inner_", "radius"]
    assert wrap(f"set {key}", 10) == ["set", "parts.bar_", "upper.", "inner_", "radius"]


def test_rounding_never_flatters():
    assert safety_text(1.4999) == "1.49"
    assert safety_text(1.15) == "1.15"
    assert utilisation_text(1.0001) == "1.01"
    assert utilisation_text(1.0) == "1.00"


@pytest.mark.parametrize(
    ("value", "text"),
    [(141.34, "141"), (0.012345, "0.0123"), (1.1e7, "1.1e+07"), (0, "0"), (123456.0, "123000"),
     (-2.5, "-2.50"), (inf, "∞"), (999.6, "1000"), (4.2e-9, "4.2e-09")],
)  # fmt: skip
def test_numbers_are_written_to_three_digits(value, text):
    assert number(value) == text


@pytest.mark.parametrize(
    ("bars", "text"),
    [((4.0, 20.0), ("56", "±4", "±20")), ((0.4, 20.0), ("56.0", "±0.4", "±20.0")),
     ((0.0, 2.0), ("56", "±0", "±2")), ((0.003, 2.0), ("56.0", "±0.003", "±2.0"))],
)  # fmt: skip
def test_a_value_is_written_as_finely_as_its_bars_deserve(bars, text):
    check = replace(results.PASSING, value=56.0, numerical=bars[0], model=bars[1])
    assert value_and_bars(check) == text


def test_cleaning_leaves_honest_text_alone():
    assert clean("Kniehebelpresse Ø 40 µm 😀") == "Kniehebelpresse Ø 40 µm 😀"
    assert clean("a\tb\nc") == "a b c"
    assert clean("a\r\n\tb", lines=True) == "a\n\tb"
    assert clean("\ud800") == "\N{REPLACEMENT CHARACTER}"
