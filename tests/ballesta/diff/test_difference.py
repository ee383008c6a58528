"""`ballesta diff`: what changed, the largest first, of real checks and of results by hand."""

import copy
import json

import pytest

from ballesta.diff.compared import compared
from ballesta.diff.difference import Wanted, differences_of, run_diff
from ballesta.pipeline import check_file
from checks.design.effort import Effort
from checks.design.errors import DesignError
from reports.difference_text import (
    INPUTS,
    LIMITS,
    LOADS,
    MASSES,
    SAFETY,
    STRESSES,
    VERDICTS,
    difference_html,
    difference_text,
    values_text,
)
from reports.files import plain

from ...small_machine import MACHINE, PLATE

FORMULA = Effort("formula")
ARM = '\n[parts.arm]\nlike = "rod"\nbody = "crank"\ninterfaces = { first = "O", second = "A" }\n'


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A machine and one whose rod is thinner and of another steel, both checked once."""
    place = tmp_path_factory.mktemp("diff")
    thin = PLATE.replace('thickness = "8 mm"', 'thickness = "2 mm"').replace("S275", "S355")
    for name, text in (("one", PLATE), ("two", thin)):
        (place / f"{name}.toml").write_text(MACHINE + text, encoding="utf-8")
        result = plain(check_file(place / f"{name}.toml", effort=FORMULA).to_dict())
        (place / "runs" / name).mkdir(parents=True)
        (place / "runs" / name / "result.json").write_text(json.dumps(result), encoding="utf-8")
    return place


@pytest.fixture
def one(folder):
    return json.loads((folder / "runs" / "one" / "result.json").read_text(encoding="utf-8"))


@pytest.fixture
def two(folder):
    return json.loads((folder / "runs" / "two" / "result.json").read_text(encoding="utf-8"))


def difference(a, b):
    return compared("machine", a, b, ("a", "b"))


def changed(a, b, group):
    return {(c.of, c.what): c for c in difference(a, b).changes[group]}


def test_a_result_beside_itself_is_the_same_in_everything(one):
    found = difference(one, copy.deepcopy(one))
    assert found.same
    assert not found.notes
    assert found.compared[VERDICTS] > 10
    assert all(found.compared[group] for group in (INPUTS, LOADS, STRESSES, SAFETY, MASSES))


def test_what_was_edited_is_the_only_change_of_inputs(one, two):
    found = changed(one, two, INPUTS)
    thickness, steel = found["", "parts.rod.thickness"], found["", "parts.rod.material"]
    assert len(found) == 2
    assert (thickness.before, thickness.after) == ("8 mm", "2 mm")
    assert thickness.relative == pytest.approx(-0.75)
    assert (steel.before, steel.after, steel.relative) == ("S275", "S355", None)


def test_a_thinner_rod_has_a_quarter_of_the_mass_and_higher_stress(one, two):
    """The rod's mass is stated for the linkage, so the loads stay as they are."""
    found = difference(one, two)
    (mass,) = found.changes[MASSES]
    assert mass.relative == pytest.approx(-0.75, rel=1e-3)
    static = changed(one, two, STRESSES)["rod", "static: peak von Mises stress"]
    assert static.after / static.before == pytest.approx(4, rel=0.1)
    assert static.relative == pytest.approx(static.after / static.before - 1)
    assert found.changes[LOADS] == []
    assert found.compared[LOADS] > 2


def test_the_largest_change_of_each_group_comes_first(one, two):
    for group in (STRESSES, SAFETY, LIMITS):
        sizes = [abs(change.relative) for change in difference(one, two).changes[group]]
        assert sizes == sorted(sizes, reverse=True)
        assert len(sizes) > 1


def test_a_force_that_changes_by_a_millionth_is_told_and_by_round_off_is_not(one):
    for size, told in ((1e-6, 1), (1e-10, 0)):
        other = copy.deepcopy(one)
        efforts = other["cycles"]["turn"]["torques"]["drive"]
        largest = max(range(len(efforts)), key=lambda k: abs(efforts[k]))
        efforts[largest] *= 1 + size
        assert len(difference(one, other).changes[LOADS]) == told


def test_a_force_next_to_nothing_is_no_change_from_nothing(one):
    """1e-13 N beside links of 400 N is round-off of 0, whatever it is a multiple of."""
    for value, after in ((1e-13, 3e-13), (0.0, 2e-14)):
        a, b = copy.deepcopy(one), copy.deepcopy(one)
        for data, size in ((a, value), (b, after)):
            data["cycles"]["turn"]["links"]["rod first"] = [size] * 3
        assert difference(a, b).changes[LOADS] == []


def test_a_force_that_was_nothing_comes_first_and_says_so(one):
    other = copy.deepcopy(one)
    one["cycles"]["turn"]["efforts"]["push"] = [0.0] * 3
    text = difference_text_of(one, other)
    assert "from 0" in text.split("LOADS")[1]


def difference_text_of(a, b, **options):
    from reports.difference_text import Difference

    return difference_text(Difference("a", "b", [difference(a, b)]), 100, **options)


def test_verdicts_are_told_first_and_what_became_worse_before_what_became_better(one):
    other = copy.deepcopy(one)
    checks, news = one["parts"][0]["checks"], other["parts"][0]["checks"]
    for check, new, before, after in zip(
        checks, news, ("FAIL", "pass", "UNDECIDED"), ("pass", "FAIL", "pass"), strict=False
    ):
        check["status"], new["status"] = before, after
    one["status"], other["status"] = "FAIL", "UNDECIDED"
    turned = difference(one, other).changes[VERDICTS]
    assert [(c.before, c.after) for c in turned] == [
        ("FAIL", "UNDECIDED"), ("pass", "FAIL"), ("FAIL", "pass"), ("UNDECIDED", "pass"),
    ]  # fmt: skip
    assert turned[0].of == "design"
    text = difference_text_of(one, other)
    assert text.index("VERDICTS: 4 of") < text.index("decided by")


def test_a_gate_that_breaks_is_a_verdict_that_turns(one):
    other = copy.deepcopy(one)
    gate = other["gates"][0]
    gate["holds"], gate["value"] = False, 7.0
    (turned,) = difference(one, other).changes[VERDICTS]
    assert (turned.before, turned.after) == ("holds", "broken")
    assert turned.what == f"validity check {gate['name']}"


def test_another_model_or_place_is_told_beside_the_stress(one):
    other = copy.deepcopy(one)
    check = other["parts"][0]["checks"][0]
    check["method"], check["place"], check["value"] = "solid", "elsewhere", 2 * check["value"]
    (change,) = (c for c in difference(one, other).changes[STRESSES])
    assert "model: formula → solid" in change.note
    assert "→ elsewhere" in change.note


def test_a_check_that_is_no_longer_loaded_has_no_safety_and_says_so(one):
    other = copy.deepcopy(one)
    check = other["parts"][0]["checks"][0]
    check["value"], check["safety"] = 0.0, None
    (change,) = difference(one, other).changes[SAFETY]
    assert change.after == "not loaded"


def test_parts_checks_and_cycles_of_one_side_are_told_as_such(one):
    other = copy.deepcopy(one)
    other["parts"][0]["name"] = "bar"
    other["linkage"] = []
    other["cycles"]["back"] = other["cycles"].pop("turn")
    found = difference(one, other)
    assert {"part rod", "cycle turn"} <= set(found.only_a)
    assert {"part bar", "cycle back"} <= set(found.only_b)
    assert any(name.startswith("check linkage:") for name in found.only_a)
    assert not found.same


def test_a_value_written_in_another_unit_is_no_change(one):
    other = copy.deepcopy(one)
    for pair in other["inputs"]:
        if pair[0] == "parts.rod.width":
            pair[1] = "3 cm"
        if pair[0] == "points.A":
            pair[1] = "0, 6 cm"
    assert difference(one, other).changes[INPUTS] == []


def test_a_default_that_becomes_stated_is_told_if_it_is_another_value(one):
    other = copy.deepcopy(one)
    other["inputs"].append(["accuracy", "5 %"])
    (change,) = difference(one, other).changes[INPUTS]
    assert (change.before, change.after, change.note) == ("3 %", "5 %", "A is the default")
    other["inputs"][-1][1] = "0.03"
    assert difference(one, other).changes[INPUTS] == []


def test_a_result_of_another_version_is_compared_as_far_as_it_goes(one):
    old = copy.deepcopy(one)
    old["format"], old["versions"]["ballesta"] = "ballesta-result/0", "0.0.9"
    del old["linkage"], old["cycles"]
    old["parts"][0]["checks"].append({"kind": "new", "value": "much", "limit": None})
    old["parts"][0]["facts"] = None
    found = difference(old, one)
    told = " ".join(found.notes)
    assert "A has format 'ballesta-result/0'" in told
    assert "A has no cycles, linkage: not compared" in told
    assert "ballesta 0.0.9 → 0.1.0" in told
    assert found.changes[INPUTS] == []
    assert LOADS not in found.changes
    assert not any("cycle" in name or "linkage" in name for name in found.only_b)


def test_a_formula_beside_a_solid_is_no_other_version(one):
    solid = copy.deepcopy(one)
    solid["versions"] |= {"solver": "CHOLMOD"}
    one["versions"].pop("solver", None)
    assert not any("versions" in note for note in difference(solid, one).notes)


def test_values_that_look_alike_get_as_many_digits_as_tell_them_apart(one):
    other = copy.deepcopy(one)
    other["parts"][0]["facts"]["mass [kg]"] *= 1 + 1e-6
    (mass,) = difference(one, other).changes[MASSES]
    before, after = values_text(mass, MASSES)
    assert before != after


def test_a_safety_is_rounded_down(one):
    other = copy.deepcopy(one)
    one["parts"][0]["checks"][0]["safety"] = 1.49999
    other["parts"][0]["checks"][0]["safety"] = 2.0
    (change,) = difference(one, other).changes[SAFETY]
    assert values_text(change, SAFETY)[0] == "1.499"


def test_design_files_are_checked_and_say_what_their_results_say(folder, one, two):
    told = []
    found = differences_of(
        folder / "one.toml", folder / "two.toml", effort=FORMULA, say=told.append
    )
    expected = difference(one, two)
    (design,) = found.designs
    assert design.name == "one → two"
    assert design.changes == expected.changes
    assert any(text.startswith("two: ") for text in told)


def test_a_wrong_second_file_is_told_before_the_first_is_checked(folder, tmp_path):
    told = []
    with pytest.raises(DesignError, match=r"nosuch\.toml: cannot be read: there is no such file"):
        differences_of(folder / "one.toml", tmp_path / "nosuch.toml", say=told.append)
    assert told == []


def test_runs_are_paired_by_the_names_of_their_folders(folder, tmp_path):
    """The one that changed stands before the one that did not."""
    for name, source in (("one", "one"), ("two", "one"), ("three", "two")):
        (tmp_path / name).mkdir()
        text = (folder / "runs" / source / "result.json").read_text(encoding="utf-8")
        (tmp_path / name / "result.json").write_text(text, encoding="utf-8")
    found = differences_of(folder / "runs", tmp_path)
    assert [(design.name, design.same) for design in found.designs] == [
        ("two", False), ("one", True),
    ]  # fmt: skip
    assert (found.only_a, found.only_b) == ([], ["three"])
    text = difference_text(found, 100)
    assert "ONLY IN B  three" in text
    assert "1 of 2 designs differs" in text
    assert "SAME     one" in text


def test_a_broken_result_among_others_costs_itself_alone_and_is_told(folder, tmp_path):
    for name, text in (("one", None), ("two", "{")):
        (tmp_path / name).mkdir()
        whole = (folder / "runs" / "one" / "result.json").read_text(encoding="utf-8")
        (tmp_path / name / "result.json").write_text(text or whole, encoding="utf-8")
    found = differences_of(folder / "runs", tmp_path)
    assert [design.name for design in found.designs] == ["one"]
    (note,) = found.notes
    assert "two" in note
    assert "is not JSON" in difference_text(found, 100)


def test_a_single_result_is_paired_with_a_single_other_whatever_their_names(folder):
    runs = folder / "runs"
    (design,) = differences_of(runs / "one", runs / "two" / "result.json").designs
    assert design.name == "one → two"


def test_hidden_folders_of_a_run_are_left_alone(folder, tmp_path):
    text = (folder / "runs" / "one" / "result.json").read_text(encoding="utf-8")
    for name in ("one", ".store"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "result.json").write_text(text, encoding="utf-8")
    assert [d.name for d in differences_of(tmp_path, tmp_path).designs] == ["one"]


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (None, "there is no such file"),
        (b"{", "is not JSON"),
        (b"\xff\xfe", "is not UTF-8 text"),
        (b"[]", "it holds a list"),
        (b'{"format": "ballesta-baseline/1"}', "format 'ballesta-baseline/1'"),
        (b'{"format": "ballesta-result/1", "x": NaN}', "holds no NaN"),
    ],
)
def test_what_is_no_result_is_exit_code_2_in_words(folder, tmp_path, capsys, content, told):
    path = tmp_path / "result.json"
    if content is not None:
        path.write_bytes(content)
    assert run_diff(folder / "runs" / "one", path, Wanted()) == 2
    captured = capsys.readouterr()
    assert told in captured.err
    assert "Traceback" not in captured.err
    assert captured.out == ""


def test_a_folder_without_results_and_runs_without_a_common_design_are_exit_code_2(
    folder, tmp_path, capsys
):
    assert run_diff(folder / "runs", tmp_path, Wanted()) == 2
    assert "the folder has no result.json" in capsys.readouterr().err
    for name in ("five", "six"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "result.json").write_text('{"format": "ballesta-result/1"}')
    with pytest.raises(DesignError, match=r"no design stands on both sides.*one, two.*five, six"):
        differences_of(folder / "runs", tmp_path)


def test_a_wrong_fidelity_and_a_page_that_cannot_be_written_are_exit_code_2(
    folder, tmp_path, capsys
):
    runs = folder / "runs"
    assert run_diff(runs / "one", runs / "two", Wanted(fidelity="formla")) == 2
    assert "did you mean formula" in capsys.readouterr().err
    (tmp_path / "taken").write_text("a file")
    wanted = Wanted(html=tmp_path / "taken" / "page.html")
    assert run_diff(runs / "one", runs / "two", wanted) == 2
    assert "--html: cannot be written" in capsys.readouterr().err


def test_the_command_line_tells_the_difference_as_text_page_and_json(folder, tmp_path, capsys):
    from ballesta.cli import main

    runs, page = folder / "runs", tmp_path / "page.html"
    given = ["diff", str(runs / "one"), str(runs / "two")]
    assert main([*given, "--html", str(page)]) == 0
    text = capsys.readouterr().out
    assert f"written: {page}" in text
    assert max(map(len, text.replace(str(page), "").splitlines())) <= 100
    assert main([*given, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["format"] == "ballesta-diff/1"
    (design,) = data["designs"]
    assert {change["what"] for change in design["changes"]["inputs"]} == {
        "parts.rod.thickness", "parts.rod.material",
    }  # fmt: skip
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_the_page_has_every_change_and_the_text_the_largest(one, two):
    from reports.difference_text import Difference

    for key in range(40):
        one["inputs"].append([f"parts.k{key}", "1"])
        two["inputs"].append([f"parts.k{key}", "2"])
    found = Difference("a", "b", [difference(one, two)])
    page, text = difference_html(found), difference_text(found, 100)
    assert page.count("parts.k") == 40
    assert text.count("parts.k") < 13
    assert "30 more, in --html and --json" in text


def test_what_a_result_says_cannot_break_out_of_the_page_or_the_terminal(one, two):
    from reports.difference_text import Difference

    one["inputs"].append(["x", "<script>alert(1)</script>\x1b[2J"])
    found = Difference("<b>", "b", [difference(one, two)])
    page, text = difference_html(found), difference_text(found, 100)
    assert "<script" not in page
    assert "&lt;script&gt;" in page
    assert "\x1b" not in text + page
