"""Where a check begins to pass: the search by itself, and on a design with made-up verdicts."""

import json
from dataclasses import replace
from math import inf
from types import SimpleNamespace

import pytest

from ballesta.commands.batch_command import Wanted, run_until
from ballesta.sweeps.threshold_search import search_passing, until_pass, until_text
from checks.design.effort import Effort
from checks.design.errors import DesignError, NumericsError
from checks.result.verdict import Check, Gate, Status

from ...conftest import run_ballesta
from ...small_machine import MACHINE, PLATE

PASS, UNDECIDED, FAIL = Status.PASS, Status.UNDECIDED, Status.FAIL


def smallest_passing(check, low, high, *, count=1000, probes=5):
    numbers = [low + (high - low) * k / count for k in range(count + 1)]
    return search_passing(check, numbers, probes=probes)


def above(limit):
    """Pass from a limit on, undecided in the tenth below it."""
    return lambda x: PASS if x >= limit else UNDECIDED if x >= 0.9 * limit else FAIL


@pytest.mark.parametrize("limit", [1.01, 2.5, 3.333, 7.99])
def test_the_smallest_number_that_passes_is_found_to_a_thousandth_of_the_range(limit):
    search = smallest_passing(above(limit), 1, 8)
    assert search.safer == "larger"
    assert search.beyond < limit <= search.found
    assert search.found - search.beyond == pytest.approx(7e-3)
    assert len(search.tried) <= 7 + 8  # both ends, five between, and 2**8 > 1000 / 6


def test_where_smaller_is_safer_it_is_the_largest_that_passes():
    search = smallest_passing(lambda x: PASS if x <= 2.5 else FAIL, 1, 8, count=10_000)
    assert search.safer == "smaller"
    assert search.found <= 2.5 < search.beyond
    assert search.beyond - search.found == pytest.approx(7e-4)


def test_with_a_step_only_what_can_be_made_is_tried():
    search = smallest_passing(above(5.2), 4, 8, count=8)
    assert (search.found, search.beyond) == (5.5, 5.0)
    assert all(value % 0.5 == 0 for value, _ in search.tried)


def test_undecided_is_no_pass():
    search = smallest_passing(lambda x: UNDECIDED if x > 2 else FAIL, 0, 4)
    assert search.found is None
    assert "none of 7 values passes" in search.problem


def test_a_verdict_that_turns_back_gives_no_value_but_what_was_found():
    search = smallest_passing(lambda x: PASS if 1 < x < 3 else FAIL, 0, 4)
    assert search.found is None
    assert "does not go one way" in search.problem
    assert [status for _, status in search.tried] == [FAIL, FAIL, PASS, PASS, PASS, FAIL, FAIL]


def test_a_dip_between_the_ends_is_seen_though_both_ends_are_in_order():
    def dip(x):
        return FAIL if x < 1 or 5 < x < 7 else PASS

    assert smallest_passing(dip, 0, 8).found is None
    assert smallest_passing(dip, 0, 8, probes=0).found is not None  # which is why there are probes


def test_undecided_below_fail_is_out_of_order_too():
    values = [UNDECIDED, FAIL, PASS]
    search = search_passing(lambda k: values[k], [0, 1, 2])
    assert (search.found, search.tried) == (None, tuple(enumerate(values)))


def test_disorder_that_only_the_bisection_meets_gives_no_value():
    def odd(x):
        return PASS if x > 30 else FAIL if x == 25 else UNDECIDED

    search = search_passing(odd, range(0, 101), probes=1)
    assert (25, FAIL) in search.tried
    assert search.found is None


def test_a_range_that_passes_as_a_whole_has_no_edge():
    search = smallest_passing(lambda x: PASS, 4, 8)
    assert (search.found, search.beyond, search.safer, len(search.tried)) == (4, None, None, 7)


def test_no_value_is_checked_twice():
    asked = []

    def check(x):
        asked.append(x)
        return PASS if x > 3.21 else FAIL

    smallest_passing(check, 0, 8)
    assert len(asked) == len(set(asked))


# A design: the verdicts are made up, the design and its keys are real.

SWEEP = "parts.rod.width = 20..40 mm : step 2 mm"


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(MACHINE + PLATE, encoding="utf-8")
    return path


def check_of(part, value):
    return Check(part, "static", "stress", value, "MPa", 0.0, 0.0, 100.0, 1.0, "", "", "", "", "")


def result_of(gates=(), **stresses):
    """What until_pass reads of a result."""
    parts = [
        SimpleNamespace(name=name, checks=[check_of(name, value)], gates=[],
                        facts={"mass [kg]": 2.0})
        for name, value in stresses.items()
    ]  # fmt: skip
    return SimpleNamespace(parts=parts, linkage=[], gates=list(gates))


def words_of(result):
    """The text without its line breaks."""
    return " ".join(until_text(result).split())


def width_of(overrides):
    (width,) = [o.partition("=")[2] for o in overrides if o.startswith("parts.rod.width=")]
    return float(width.removesuffix(" mm"))


def by_width(overrides, _effort=None):
    return result_of(rod=3000 / width_of(overrides))


def test_the_smallest_width_that_passes_is_told_with_what_was_checked(file):
    result = until_pass(file, SWEEP, check=by_width)
    assert result.found.value == "30 mm"
    assert result.search.beyond == ("parts.rod.width=28 mm",)
    assert result.exit_code == 0
    text = words_of(result)
    assert "30 mm is the smallest that passes, 28 mm does not (FAIL); larger is safer" in text
    assert f"{len(result.trials)} checks" in text
    assert max(map(len, until_text(result).splitlines())) <= 100
    assert result.to_dict()["found"] == "30 mm"


def test_further_overrides_reach_every_check(file):
    seen = []
    until_pass(
        file, SWEEP, ["accuracy=5 %"], check=lambda given, _: seen.append(given) or by_width(given)
    )
    assert all(given[0] == "accuracy=5 %" for given in seen)
    with pytest.raises(DesignError, match="set by --set, too"):
        until_pass(file, SWEEP, ["parts.rod.width=30 mm"], check=by_width)


def test_only_the_parts_that_are_named_are_judged_and_the_result_says_so(tmp_path):
    path = tmp_path / "machine.toml"
    other = '[parts.arm]\nlike = "rod"\nbody = "crank"\ninterfaces = {first = "O", second = "A"}\n'
    path.write_text(MACHINE + PLATE + other, encoding="utf-8")

    def check(given, _effort):
        return result_of(rod=3000 / width_of(given), arm=1000.0)

    assert until_pass(path, SWEEP, check=check).exit_code == 1
    found = until_pass(path, SWEEP, parts=["rod"], check=check)
    assert found.found.value == "30 mm"
    assert "Judged: rod, loads and linkage; not judged: arm" in words_of(found)
    with pytest.raises(DesignError, match="did you mean rod"):
        until_pass(path, SWEEP, parts=["rood"], check=check)


def test_a_gate_of_the_loads_that_breaks_keeps_a_value_from_passing(file):
    broken = Gate("irregularity", 2.0, 1.0, "speed")

    def check(given, _effort):
        return result_of([broken] if width_of(given) < 35 else [], rod=3000 / width_of(given))

    result = until_pass(file, SWEEP, check=check)
    assert result.found.value == "36 mm"
    assert "validity checks do not hold: irregularity" in words_of(result)


def test_a_width_that_cannot_be_built_does_not_pass_and_says_why(file):
    """From the design's own door: the hole of 12 mm does not fit in 10 mm."""

    def check(given, _effort):
        from ballesta.design.read import read_design

        read_design(file, given)
        return by_width(given)

    result = until_pass(file, "parts.rod.width = 10..40 mm : step 2 mm", check=check)
    assert result.found.value == "30 mm"
    assert result.trials[0].status is None
    assert "12 mm" in result.trials[0].words
    with pytest.raises(DesignError, match="12 mm"):
        until_pass(file, "parts.rod.width = 6..10 mm : step 1 mm", check=check)


def test_a_solver_that_gives_up_is_no_verdict(file):
    def check(given, _effort):
        raise NumericsError("did not converge", "rod", "try again")

    with pytest.raises(NumericsError):
        until_pass(file, SWEEP, check=check)


def test_no_value_is_exit_code_1_and_tells_every_verdict(file):
    result = until_pass(file, SWEEP, check=lambda given, _: result_of(rod=120.0))
    assert result.exit_code == 1
    assert "NO VALUE: none of 7 values passes: 20 mm FAIL, " in words_of(result)


def test_a_range_without_a_count_is_searched_to_a_thousandth_of_it(file):
    result = until_pass(file, "parts.rod.width = 20..40 mm", check=by_width)
    assert result.found.value == "30 mm"
    assert result.search.beyond == ("parts.rod.width=29.98 mm",)


def test_a_list_is_searched_in_its_order(file):
    """Of materials, too: here the strong one stands last."""
    strength = {"S275": 110.0, "S355": 90.0, "C45": 80.0}

    def check(given, _effort):
        return result_of(rod=strength[given[-1].partition("=")[2]])

    found = until_pass(file, "material = S275, S355, C45", check=check)
    assert found.found.value == "S355"


def banded(model, note="", method="formula", **stresses):
    """A result whose checks have a model band, such as infinite bars beyond what was compared."""
    result = result_of(**stresses)
    for part in result.parts:
        part.checks = [replace(c, model=model, note=note, method=method) for c in part.checks]
    return result


UNRANGED = "no error bar: width / hole is 2.3, solids were compared from 2.4 to 5"


def test_where_a_models_range_ends_a_better_model_searches_on(file):
    """Safety 2 at 30 mm, where the formula's range ends; the solid finds the limit, 1 at 15 mm."""

    def check(given, effort):
        width = width_of(given)
        if effort.fidelity == "solid":
            return banded(0.0, method="solid (two meshes)", rod=1500 / width)
        if width < 30:
            return banded(inf, UNRANGED, rod=1500 / width)
        return banded(0.0, rod=1500 / width)

    found = until_pass(
        file, "parts.rod.width = 12..40 mm : step 1 mm", check=check, effort=Effort("formula")
    )
    assert found.found.value == "15 mm"
    text = words_of(found)
    assert "15 mm is the smallest that passes, 14 mm does not (FAIL)" in text
    assert "14 mm is limited by rod static, by solid (two meshes)" in text
    rungs = {trial.value: trial.effort.fidelity for trial in found.trials}
    assert (rungs["15 mm"], rungs["40 mm"]) == ("solid", "formula")
    limits = next(t for t in found.to_dict()["trials"] if t["value"] == "15 mm")["limits"]
    assert (limits["kind"], limits["method"], limits["needed"]) == (
        "static", "solid (two meshes)", 1.0
    )  # fmt: skip
    assert limits["least safety"] == pytest.approx(1.0)


def test_where_no_model_tells_more_the_edge_is_named_as_no_limit_of_strength(file):
    def check(given, _effort):
        open_ = width_of(given) < 30
        return banded(inf if open_ else 0.0, UNRANGED if open_ else "", rod=500 / width_of(given))

    found = until_pass(file, SWEEP, check=check)
    assert found.found.value == "30 mm"
    text = words_of(found)
    assert "30 mm passes, 28 mm does not, but that is NO limit of strength" in text
    assert "is the smallest" not in text
    assert "width / hole is 2.3" in text


def test_bars_that_widen_between_two_values_are_no_limit_of_strength_either(file):
    """Safety 6 and 5.6 against 1; below 30 mm the bars reach to ten times the value."""

    def check(given, _effort):
        stress = 500 / width_of(given)
        return banded(0.1 * stress if width_of(given) >= 30 else 9 * stress, rod=stress)

    text = words_of(until_pass(file, SWEEP, check=check))
    assert "30 mm passes, 28 mm does not, but that is NO limit of strength" in text
    assert "still has a safety of 5.60 there, 1 required, but its error bars are wider" in text


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sweep", "more"),
    [("width = 16..40 mm", "6 kN"), ("thickness = 2..16 mm", "4 kN")],
)
def test_what_is_found_has_its_least_safety_at_the_need(file, sweep, more):
    """By real checks: within 2 % at the upper end of the bars, and beyond it not enough."""
    text = file.read_text("utf-8").replace('push = "400 N"', f'push = "{more}"')
    file.write_text(text, encoding="utf-8")
    options = ["duty.cycles.turn=1", 'drive.control="constant"', "cycles.turn.positions=121",
               'parts.rod.bearing_arc="90 deg"']  # fmt: skip
    found = until_pass(file, f"parts.rod.{sweep}", options, effort=Effort("formula"))
    limit = found.found.check
    assert limit.limit / limit.upper == pytest.approx(limit.required, rel=0.02)
    assert limit.limit / limit.upper >= limit.required


def test_the_design_is_really_checked_without_a_check_of_one_s_own(file):
    result = until_pass(
        file, "parts.rod.thickness = 1, 8 mm", ["duty.cycles.turn=1"], effort=Effort("formula")
    )
    assert [trial.mass for trial in result.trials] == sorted(trial.mass for trial in result.trials)
    assert all(trial.words for trial in result.trials)
    assert "--fidelity formula" in words_of(result)


# The command: real checks of a small machine, kept in the store of the output folder.


def command(file, out, *sweeps, **options):
    given = {
        "until": "pass",
        "fidelity": "formula",
        "overrides": ("duty.cycles.turn=1",),
        **options,
    }
    return run_until([file], Wanted(out, sweeps=sweeps, **given))


THICK = "parts.rod.thickness = 1, 4, 8, 16 mm"


def test_the_command_prints_the_search_writes_it_and_computes_nothing_twice(
    file, tmp_path, capsys, monkeypatch
):
    code = command(file, tmp_path / "out", THICK)
    first = capsys.readouterr().out
    written = json.loads((tmp_path / "out" / "machine" / "until.json").read_text("utf-8"))
    assert code == (0 if written["found"] else 1)
    assert [trial["value"] for trial in written["trials"]] == ["1 mm", "4 mm", "8 mm", "16 mm"]
    assert "until pass: parts.rod.thickness" in first

    def never(*_, **__):
        raise AssertionError("checked again")

    monkeypatch.setattr("ballesta.pipeline.check_design", never)
    assert command(file, tmp_path / "out", THICK) == code
    assert capsys.readouterr().out == first


def test_a_search_that_was_stopped_goes_on_with_what_it_had(file, tmp_path, monkeypatch, capsys):
    from ballesta import pipeline as check

    real, checked = check.check_design, []

    def stops(design, **options):
        if len(checked) == 2:
            raise KeyboardInterrupt
        checked.append(design.overrides)
        return real(design, **options)

    monkeypatch.setattr(check, "check_design", stops)
    with pytest.raises(KeyboardInterrupt):
        command(file, tmp_path / "out", THICK)
    again = []
    monkeypatch.setattr(
        check,
        "check_design",
        lambda design, **o: again.append(design.overrides) or real(design, **o),
    )
    command(file, tmp_path / "out", THICK)
    assert len(again) == 2
    assert not set(again) & set(checked)


@pytest.mark.slow
def test_a_design_that_is_edited_during_its_search_gives_no_answer_and_spoils_no_store(
    file, tmp_path, monkeypatch, capsys
):
    from ballesta import pipeline as check

    real, thick = check.check_design, file.read_text(encoding="utf-8")
    thin = thick.replace('width = "30 mm"', 'width = "20 mm"')

    def edited_meanwhile(design, **options):
        file.write_text(thin, encoding="utf-8")
        return real(design, **options)

    monkeypatch.setattr(check, "check_design", edited_meanwhile)
    assert command(file, tmp_path / "out", THICK) == 2
    assert "was edited during the search" in capsys.readouterr().err
    assert not (tmp_path / "out" / "machine" / "until.json").exists()
    monkeypatch.setattr(check, "check_design", real)
    command(file, tmp_path / "out", THICK)
    kept = json.loads((tmp_path / "out" / "machine" / "until.json").read_text("utf-8"))
    command(file, tmp_path / "fresh", THICK)
    fresh = json.loads((tmp_path / "fresh" / "machine" / "until.json").read_text("utf-8"))
    assert kept["trials"] == fresh["trials"]


@pytest.mark.parametrize(
    ("sweeps", "options", "told"),
    [
        ((THICK, "material = S275, S355"), {}, "--until: needs one --sweep, got 2"),
        ((), {}, "--until: needs one --sweep, got 0"),
        ((THICK,), {"sample": 3, "jobs": 2}, "leave out --sample, --jobs"),
        ((THICK,), {"until": "fail"}, "must be pass"),
        ((THICK,), {"until": "pass of "}, "must be pass"),
        ((THICK,), {"until": "pass of rood"}, "did you mean rod"),
        ((THICK,), {"fidelity": "formla"}, "did you mean formula"),
        (("parts.rod.thicknes = 1, 2 mm",), {}, "did you mean thickness"),
    ],
)
def test_a_search_that_is_not_understood_is_exit_code_2(
    file, tmp_path, capsys, sweeps, options, told
):
    assert command(file, tmp_path / "out", *sweeps, **options) == 2
    captured = capsys.readouterr()
    assert told in captured.err
    assert "Traceback" not in captured.err


def test_a_bad_design_costs_itself_alone(file, tmp_path, capsys):
    bad = tmp_path / "bad.toml"
    bad.write_text("not toml", encoding="utf-8")
    given = {"until": "pass", "fidelity": "formula", "overrides": ("duty.cycles.turn=1",)}
    assert run_until([bad, file], Wanted(tmp_path / "out", sweeps=(THICK,), **given)) == 2
    captured = capsys.readouterr()
    (written,) = (tmp_path / "out").glob("*/until.json")
    assert json.loads(written.read_text())["file"] == str(file)
    assert "bad.toml" in captured.err


def test_an_output_folder_that_cannot_be_written_is_told_before_anything_is_checked(
    file, tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr("ballesta.pipeline.check_design", None)
    (tmp_path / "taken").write_text("a file")
    assert command(file, tmp_path / "taken", THICK) == 2
    assert "--out: cannot be written" in capsys.readouterr().err


@pytest.mark.slow
def test_the_command_line_prints_the_value_that_just_passes(tmp_path):
    out = tmp_path / "out"
    options = ["--sweep", "parts.lower_left.thickness = 5, 6 mm", "--fidelity", "formula"]
    design = "designs/gallery/scissors_jack.toml"
    until = ["batch", design, *options, "--until", "pass", "--out", str(out)]
    run = run_ballesta(*until, out=out)
    assert run.code == 0, run.stderr
    written = json.loads((out / "scissors_jack" / "until.json").read_text())
    assert (written["beyond"], written["found"]) == ("5 mm", "6 mm")
    assert "6 mm is the smallest that passes, 5 mm does not (FAIL)" in run.stdout
    refused = run_ballesta(*until, "--jobs", "2", "--no-reports", out=out)
    assert refused.code == 2
    assert "leave out --jobs, --reports" in refused.stderr
