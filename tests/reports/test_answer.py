"""The ten questions of a designer, in the first lines of the answer."""

from dataclasses import replace
from math import inf

import pytest
from rich.cells import cell_len

from checks.result.verdict import Change, Gate, Way
from reports.answer_facts import answer_text

from . import results

MASS = {"mass [kg]": 4.15}


def words(text):
    return " ".join(text.split())


def test_the_first_25_lines_answer_what_a_designer_asks():
    design = results.design(
        results.part(checks=[results.check(), results.check(kind="fatigue", value=400.0)]),
        warnings=["a: the stop is ASSUMED; it may be lower. More of it"],
    )
    design = replace(design, parts=[replace(part, facts=MASS) for part in design.parts])
    lines = answer_text(design, 100).splitlines()
    assert len(lines) <= 25
    text = words("\n".join(lines))
    deciding = design.deciding
    assert lines[0].endswith(": FAIL")  # does it survive?
    said = f"decided by {deciding.kind} of bar_upper: {deciding.place}"
    assert said in text  # which part, where?
    assert f"when {deciding.cycle}: {deciding.position}" in text
    assert f", {deciding.required:g} required" in text  # by how much?
    assert "mass 4.15 kg" in text
    assert lines[-1].endswith("-v tells all")
    assert "why the limit is exceeded even at the lower end of the error bars" in text
    assert "assumed 2 assumptions" in text
    assert "not checked " in text
    assert "warning a: the stop is ASSUMED; it may be lower mass" in text


WALL = Change(
    key="parts.bar_upper.wall",
    was="6.3 mm",
    value="7.1 mm",
    parts=("bar_upper",),
    safety=1.4821,
    lower=1.3712,
    required=1.3,
    governing="bar_upper fatigue",
    model="solid",
    mass=10.06e-3,
    saved=-0.84e-3,
)


def test_changes_that_make_it_pass_stand_in_the_answer_with_the_command_that_checks_them():
    """Least value and standard size, safety with its end, mass; a part they leave open is named."""
    steel = replace(
        WALL, key="parts.bar_upper.material", was="S355", value="S450J0",
        lower=1.4821, saved=0.0, mass=9.21e-3,
    )  # fmt: skip
    failing = [replace(results.FAILING, part=name) for name in ("bar_upper", "bar_lower")]
    parts = [results.part(check.part, [check]) for check in failing]
    text = words(answer_text(replace(results.design(*parts), changes=[WALL, steel]), 100))
    assert "to pass bar_upper.wall=7.1 mm (now 6.3): safety 1.48 (≥ 1.37); 10.1 kg (+0.84)" in text
    assert "or bar_upper.material=S450J0 (now S355): safety 1.48; 9.21 kg" in text
    assert (
        "estimated by formula, set against the solid; bar_lower does not pass by these; checked "
        "by: ballesta improve" in text
    )
    assert "--verify" in text


def test_without_a_known_error_bar_no_change_is_promised():
    unknown = results.check(value=300.0, model=inf, model_below=0.0)
    text = words(answer_text(results.design(results.part(checks=[unknown])), 100))
    assert "a model that knows its error bar" in text
    assert "ballesta improve" not in text


def test_parts_whose_safeties_read_the_same_share_a_row_with_the_larger_value():
    """200 and 200.1 MPa against 355 MPa are both 1.77."""
    values = {"a": 200.0, "b": 200.1}
    same = [results.part(n, [results.check(part=n, value=v)]) for n, v in values.items()]
    rows = [line.split() for line in answer_text(results.design(*same), 140).splitlines()]
    (row,) = (row for row in rows if row[:1] == [">"])
    assert row[1:3] == ["a,", "b"]
    assert row[4] == "200"
    assert "1.77" in row


def test_parts_of_one_outcome_share_a_row_and_others_do_not():
    same = [results.part(name=n, checks=[results.check(part=n)]) for n in ("a", "b")]
    other = results.part(name="c", checks=[results.check(part="c", value=100.0)])
    rows = [line.split() for line in answer_text(results.design(*same, other), 140).splitlines()]
    assert [row[:3] for row in rows if row[:1] in (["a,"], ["c"], [">"])] == [
        [">", "a,", "b"],
        ["c", "static", row_value(rows)],
    ]


def row_value(rows):
    return next(row[2] for row in rows if row[:1] == ["c"])


def test_each_part_has_its_governing_check_and_the_others_are_counted():
    checks = [results.check(), results.check(kind="buckling", value=1.0)]
    text = answer_text(results.design(results.part(checks=checks)), 100)
    assert "and 1 other check, it passes" in text
    assert "buckling" not in text
    two_open = [results.check(kind=k, value=300.0, model=inf) for k in ("static", "fatigue", "pin")]
    text = answer_text(results.design(results.part(checks=two_open)), 100)
    assert "and 2 other checks: 2 open" in text


@pytest.mark.parametrize(("binding", "label"), [(True, "NOT VALID"), (False, "not met")])
def test_a_validity_check_that_does_not_hold_is_told_with_its_cure(binding, label):
    gate = Gate("speed", 2.0, 1.0, "the drive slows down", binding, "State drive.control")
    text = words(answer_text(results.design(gates=[gate]), 100))
    assert f"{label} speed: 2.00 > 1.00; the drive slows down. State drive.control" in text


def test_a_cure_that_stands_among_the_ways_out_is_not_told_twice():
    gate = Gate("speed", 2.0, 1.0, "the drive slows down" * 20, cure="State drive.control")
    way = Way("speed", gate.cure)
    text = words(answer_text(replace(results.design(gates=[gate]), ways=[way]), 100))
    assert text.count("State drive.control") == 1
    assert "way out speed: State drive.control NOT VALID speed: 2.00 > 1.00 " in text


def test_validity_checks_that_do_not_hold_are_one_paragraph_that_counts_what_it_leaves_out():
    gates = [Gate(f"one: kind {k}", 2.0, 1.0, "told", False) for k in range(6)]
    binding = Gate("speed", 2.0, 1.0, "the drive slows down")
    text = words(answer_text(results.design(gates=[*gates, binding]), 100))
    assert "NOT VALID speed: 2.00 > 1.00; the drive slows down" in text
    kinds = "; ".join(f"one: kind {k}: 2.00 > 1.00" for k in (1, 2, 3))
    assert f"not met one: kind 0: 2.00 > 1.00; told; {kinds}; and 2 more" in text


def test_a_safety_near_the_need_has_four_digits_and_is_rounded_down():
    near = results.check(value=100.0, limit=128.859, required=1.3, numerical=0.0, model=25.0)
    text = answer_text(results.design(results.part(checks=[near])), 100)
    assert "safety       1.288, 1.3 required; between 1.03 and 1.72 within its error bars" in text
    assert "why open     the limit lies within the model's own error bar" in text


@pytest.mark.parametrize("width", [60, 80, 100, 200])
@pytest.mark.parametrize("make", [results.mixed, results.hostile, results.design])
def test_no_line_is_wider_than_the_terminal_and_nothing_is_cut(make, width):
    text = answer_text(make(), width)
    assert max(map(cell_len, text.splitlines())) <= width
    if make is not results.hostile:
        assert "…" not in text
    assert not {"\x1b", "\u202e"} & set(text)


def test_a_row_has_one_bar_and_no_digit_that_it_does_not_deserve():
    """Numerical and model bar together, by the wider side; one below the last digit is 0."""
    said = [("45", "+27", "−32"), ("41.3", "±0.3"), ("0.036", "+0", "−0.019"), ("20.0",)]
    checks = [
        results.check(value=45.31, numerical=0.3, model=26.6, model_below=31.9),
        results.check(value=41.3, numerical=0.3, model=0.0),
        results.check(value=0.0356, numerical=2e-6, model=0.0, model_below=0.0192),
        results.check(value=20.0, numerical=1e-4, model=0.0),
    ]
    for check, words_ in zip(checks, said, strict=True):
        text = answer_text(results.design(results.part(checks=[check])), 100)
        (row,) = (line for line in text.splitlines() if line.startswith("> "))
        assert row.split()[3 : 4 + len(words_)] == [*words_, "MPa"], row


def test_a_failing_value_without_an_upper_bar_is_told_by_how_much_it_fails_at_least():
    """100 less 20 MPa of 60, twice required: 160 MPa must be 62.5 % lower at the lower end."""
    wild = results.check(
        value=100.0, limit=60.0, required=2.0, numerical=0.0, model=inf, model_below=20.0
    )
    text = words(answer_text(results.design(results.part(checks=[wild])), 100))
    assert "to pass its value must be 62 % lower even at the lower end of its error bars" in text


def test_a_way_is_told_with_the_number_of_its_checks_and_what_only_fails_is_not():
    parts = [
        results.part(
            "rod",
            [
                results.check(part="rod", kind=k, value=300.0, limit=400.0, model=90.0)
                for k in ("static", "fatigue")
            ],
        )
    ]
    judge = Way("static of rod, fatigue of rod", "let a solid judge it; ballesta plan x", "check x")
    fails = Way("fatigue of rod", "state how: without its bar it is a FAIL", "check y", 2.0)
    open_ = replace(results.design(*parts), ways=[judge, fails])
    text = words(answer_text(open_, 100))
    assert "way out let a solid judge it (2 checks): check x" in text
    assert "check y" not in text  # of another check than the one that decides
    text = words(
        answer_text(replace(open_, ways=[judge, replace(fails, settles="static of rod")]), 100)
    )
    assert "without its bar it is a FAIL (about 2.0 s): check y" in text
    failing = results.part("arm", [replace(results.FAILING, part="arm")])
    text = words(answer_text(replace(results.design(*parts, failing), ways=[fails]), 100))
    assert "check y" not in text
    text = words(answer_text(replace(results.design(*parts, failing), ways=[fails, judge]), 100))
    assert "also open let a solid judge it (2 checks): check x" in text
    more = replace(judge, settles="fatigue of arm", command="check z")
    text = words(answer_text(replace(results.design(*parts, failing), ways=[more]), 100))
    assert "check z" not in text  # the arm fails, whatever its fatigue


def test_a_way_of_the_linkage_alone_is_told_before_those_of_other_checks_as_one():
    """The comma in the name of its check makes no two of it."""
    frame = replace(
        results.check(kind="buckling", value=300.0, limit=400.0, model=90.0),
        part="linkage",
        quantity="frame, share",
    )
    other = replace(frame, quantity="ram, share", value=1.0, model=0.0)
    ways = [
        Way("static of rod", "let a solid judge it", "check x"),
        Way("buckling (frame, share) of the linkage", "state forks", "check y"),
    ]
    text = words(answer_text(replace(results.design(), linkage=[frame, other], ways=ways), 100))
    assert "way out state forks: check y" in text
    assert "check x" not in text


def test_a_design_without_parts_says_that_nothing_was_checked():
    empty = replace(results.design(), parts=())
    assert "nothing was checked" in answer_text(empty, 100)
