"""`ballesta why`: which check is told, from a design file, a result.json or a folder."""

import json
import re
from pathlib import Path

import pytest

from ballesta import pipeline as check_module
from ballesta.cli import main
from ballesta.commands.why import Wanted, checks_behind, run_why, wanted_checks
from ballesta.pipeline import check_file
from checks.design.effort import Effort
from checks.design.errors import LINKAGE, DesignError
from reports.files import write_json

from ...small_machine import MACHINE, PLATE

ARM = '\n[parts.arm]\nlike = "rod"\nbody = "crank"\ninterfaces = { first = "O", second = "A" }\n'


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A machine of two parts, and the folder of its result."""
    folder = tmp_path_factory.mktemp("why")
    design = folder / "machine.toml"
    design.write_text(MACHINE + PLATE + ARM, encoding="utf-8")
    result = check_file(design, effort=Effort("formula"))
    (folder / "out" / "machine").mkdir(parents=True)
    write_json(result, folder / "out" / "machine" / "result.json")
    return folder


@pytest.fixture
def computes_nothing(monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("a result is told, not computed")

    monkeypatch.setattr(check_module, "check_design", refuse)


@pytest.fixture
def result(place):
    return place / "out" / "machine" / "result.json"


def test_a_result_is_told_without_computing_anything(result, capsys, computes_nothing):
    assert run_why(result, Wanted("rod", ("static",))) == 0
    told = capsys.readouterr().out
    assert told.startswith("rod static: peak von Mises stress")
    assert "S_y = 275 MPa" in told
    assert told.count("\n") <= 17  # two of them tell the load bar of an unstated drive


def test_a_folder_with_one_result_stands_for_it(place, result, capsys, computes_nothing):
    run_why(place / "out", Wanted("rod"))
    folder = capsys.readouterr().out
    run_why(result, Wanted("rod"))
    assert folder == capsys.readouterr().out
    assert folder.startswith("rod ")


def test_a_design_file_is_checked_and_tells_the_same(place, result, capsys):
    assert run_why(place / "machine.toml", Wanted("rod", ("fatigue",)), fidelity="formula") == 0
    computed = capsys.readouterr().out
    assert run_why(result, Wanted("rod", ("fatigue",))) == 0
    assert computed == capsys.readouterr().out


def test_values_may_be_set(place, capsys):
    wanted = Wanted("rod", ("static",))
    run_why(place / "machine.toml", wanted, ("parts.rod.material=S355",), "formula")
    assert "S_y = 355 MPa" in capsys.readouterr().out


def test_without_a_part_it_is_what_decides_the_design(result):
    checks = checks_behind(result)
    ((deciding, _),) = wanted_checks(result, checks, Wanted())
    assert deciding.utilisation <= max(check.utilisation for check in checks)
    data = json.loads(result.read_text(encoding="utf-8"))
    assert data["decided_by"].items() >= {"part": deciding.part, "kind": deciding.kind}.items()


def test_of_several_checks_of_a_kind_the_nearest_to_its_limit_is_told(result):
    checks = checks_behind(result)
    ((one, _),) = wanted_checks(result, checks, Wanted("rod", ("buckling",)))
    every = wanted_checks(result, checks, Wanted("rod", ("buckling",), every=True))
    assert len(every) == 5
    assert one in [check for check, _ in every]
    top = max(check.value + check.numerical + check.model for check, _ in every if check is one)
    assert top * one.required / one.limit == pytest.approx(
        max(
            (c.value + c.numerical + c.model) * c.required / c.limit
            for c, _ in every
            if c.status is one.status
        )
    )


def test_words_of_a_quantity_name_a_check_too(result):
    ((found, _),) = wanted_checks(result, checks_behind(result), Wanted("rod", ("Crooked bar in",)))
    assert found.quantity == "crooked bar in plane"


def test_several_kinds_are_told_one_behind_the_other(result, capsys):
    run_why(result, Wanted("rod", ("static", "bearing")))
    told = capsys.readouterr().out
    assert told.index("rod static") < told.index("rod bearing")


def test_the_linkage_has_its_own(result, capsys):
    assert run_why(result, Wanted(LINKAGE)) == 0
    assert "no formula gives it" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        (Wanted("rood"), "PART: no part is named 'rood', did you mean rod? There are rod, arm"),
        (Wanted("rod", ("fatige",)), "KIND: no check is named 'fatige', did you mean fatigue?"),
        (Wanted("rod", ("",)), "KIND: no check is named ''"),
    ],
)
def test_a_wrong_name_says_the_nearest_right_one(result, capsys, wanted, said):
    assert run_why(result, wanted) == 2
    assert said in capsys.readouterr().err


def test_a_wrong_part_of_a_design_is_refused_before_anything_is_computed(
    place, capsys, computes_nothing
):
    assert run_why(place / "machine.toml", Wanted("rood")) == 2
    assert "did you mean rod?" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("overrides", "fidelity", "said"),
    [(("a=1",), None, "--set"), ((), "formula", "--fidelity")],
)
def test_options_of_a_design_are_refused_of_a_result(result, overrides, fidelity, said):
    with pytest.raises(DesignError, match=f"{said}: belongs to a design file"):
        checks_behind(result, overrides, fidelity)


def test_a_folder_of_several_results_asks_for_one(result, tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "result.json").write_text(result.read_text("utf-8"), "utf-8")
    named = re.escape(f"{tmp_path}: cannot be explained: has 2 results, name one of them: ")
    with pytest.raises(DesignError, match=f"{named}{tmp_path / 'a'}, {tmp_path / 'b'}$"):
        checks_behind(tmp_path)


def test_of_a_folder_of_very_many_results_some_are_named_whole_and_the_others_counted(tmp_path):
    names = [f"a_design_with_a_long_name_{k:02}" for k in range(23)]
    for name in names:
        (tmp_path / name).mkdir()
        (tmp_path / name / "result.json").write_text("{}", "utf-8")
    with pytest.raises(DesignError) as caught:
        checks_behind(tmp_path)
    told = str(caught.value)
    assert all(str(tmp_path / name) in told for name in names[:20])
    assert told.endswith(f"{names[19]} and 3 more")


def test_a_folder_without_a_result_is_told_with_what_to_give(tmp_path, capsys):
    assert run_why(tmp_path, Wanted()) == 2
    said = capsys.readouterr().err
    assert "cannot be explained: there is no result.json in the folder; ballesta check FILE" in said
    (tmp_path / "press.toml").write_text("", "utf-8")
    assert run_why(tmp_path, Wanted()) == 2
    assert f"ballesta why {tmp_path / 'press.toml'} tells of a design" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["report.html", "rod.vtu"])
def test_of_what_is_written_beside_a_result_the_result_is_named(result, tmp_path, capsys, name):
    file = tmp_path / name
    file.write_text("<html>", "utf-8")
    assert run_why(file, Wanted()) == 2
    assert "neither a design file nor a result; name a design file" in capsys.readouterr().err
    (tmp_path / "result.json").write_text(result.read_text("utf-8"), "utf-8")
    assert run_why(file, Wanted()) == 2
    named = f"the result stands beside it: ballesta why {tmp_path / 'result.json'}"
    assert named in capsys.readouterr().err
    assert run_why(tmp_path / "none.html", Wanted()) == 2
    assert "there is no such file" in capsys.readouterr().err


def test_a_result_of_an_earlier_version_has_no_derivations_and_says_so(result, tmp_path, capsys):
    data = json.loads(result.read_text(encoding="utf-8"))
    for check in data["parts"][0]["checks"]:
        del check["derivation"]
    old = tmp_path / "result.json"
    old.write_text(json.dumps(data), encoding="utf-8")
    assert run_why(old, Wanted("rod", ("static",))) == 2
    assert "has no derivation" in capsys.readouterr().err


@pytest.mark.parametrize("broken", ["{}", "[1]", "no json", '{"format": "ballesta-result/1"}'])
def test_what_is_no_result_is_refused(tmp_path, broken):
    path = tmp_path / "result.json"
    path.write_text(broken, encoding="utf-8")
    assert run_why(path, Wanted()) == 2


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ([1], "it holds a list"),
        (None, "it holds null"),
        (7, "it holds a number"),
        ({}, "it has no format"),
        ({"format": "x" * 500}, "it has format 'xxx"),
    ],
)
def test_of_json_that_is_no_result_it_is_told_what_it_is(tmp_path, capsys, data, said):
    path = tmp_path / "result.json"
    path.write_text(json.dumps(data), encoding="utf-8")
    assert run_why(path, Wanted()) == 2
    told = capsys.readouterr().err
    assert "cannot be explained: must be a result.json that ballesta check wrote" in told
    assert said in told
    assert "compared" not in told
    assert len(told) < 400


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (("parts", 0, "checks", 1, "limit"), "7", "parts[0].checks[1]: limit: '7' is no number"),
        (("parts", 0, "checks", 0, "unit"), 7, "parts[0].checks[0]: unit: '7' is no text"),
        (("parts", 0, "checks", 0, "unit"), ..., "parts[0].checks[0]: a check must have unit"),
        (("linkage", 0, "part"), [], "linkage[0]: part: '[]' is no text"),
    ],
)
def test_of_an_altered_result_the_key_is_named(result, tmp_path, capsys, path, value, said):
    data = json.loads(result.read_text(encoding="utf-8"))
    file = tmp_path / "result.json"
    file.write_text(json.dumps(altered(data, path, value)), encoding="utf-8")
    assert run_why(file, Wanted()) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("name", ["value", "limit", "numerical", "model", "model_below"])
def test_a_number_that_was_changed_is_named(result, tmp_path, capsys, name):
    """By its own formulas: 0.1 % of the smallest error bar, 0.004 of 8.6 MPa, is enough."""
    data = json.loads(result.read_text(encoding="utf-8"))
    file = tmp_path / "result.json"
    assert run_why(result, Wanted("rod", ("static",))) == 0
    kinds = [check["kind"] for check in data["parts"][0]["checks"]]
    where = ("parts", 0, "checks", kinds.index("static"), name)
    stated = data["parts"][0]["checks"][kinds.index("static")][name]
    file.write_text(json.dumps(altered(data, where, (stated or 1.0) * 1.001)), "utf-8")
    assert run_why(file, Wanted("rod", ("static",))) == 2
    assert "rod static: a" in (said := capsys.readouterr().err)
    assert "stands in the result, and its own formulas give" in said


def nested(depth):
    value = []
    for _ in range(depth):
        value = [value]
    return value


FORMULAS = (
    "(-8)^0.5", "9^9^9^9", "sigma", "s", "von_mises(1)", "1/0", "+".join(["1"] * 5000), "_", "",
    "(" * 900 + "1", "-" * 1900 + "1", "a.b" * 300, "__import__('os')", "\ud800", "\0",
)  # fmt: skip
HOSTILE = (
    None, True, -1, 0, 1e308, -1e308, 10**400, 5e-324, "", "x" * 10_000, "\ud800\0<script>",
    [], {}, [1], nested(200), {"a": nested(50)}, *FORMULAS,
)  # fmt: skip


EVERY = 7  # place is altered, each value beginning at another


def places(data, *before):
    """Paths to everything in some plain data, of a list the first three and the last only."""
    named = data.items() if isinstance(data, dict) else list(enumerate(data))
    if isinstance(data, list):
        named = [*named[:3], *named[3:][-1:]]
    for key, value in named:
        yield (*before, key)
        if isinstance(value, dict | list):
            yield from places(value, *before, key)


def altered(data, path, value):
    """The same data with one value in it replaced; `...` leaves it out."""
    again = json.loads(json.dumps(data))
    inside = again
    for key in path[:-1]:
        inside = inside[key]
    if value is ...:
        del inside[path[-1]]
    else:
        inside[path[-1]] = value
    return again


@pytest.fixture(scope="module")
def two_checks(place):
    """A result with a stress and a crooked column only: sums, superposition, root, bars."""
    data = json.loads((place / "out" / "machine" / "result.json").read_text(encoding="utf-8"))
    own = data["parts"][0]["checks"]
    chosen = [
        next(c for c in own if c["kind"] == "static"),
        next(c for c in own if c["quantity"] == "crooked bar in plane"),
    ]
    return {"format": data["format"], "parts": [{"checks": chosen}], "linkage": []}


@pytest.mark.parametrize("value", [..., *HOSTILE], ids=lambda value: str(value)[:12])
def test_a_result_that_was_altered_is_told_or_refused_but_no_traceback_comes(
    two_checks, tmp_path, capsys, value
):
    """Told as it stands, or refused in words."""
    path = tmp_path / "result.json"
    for where in list(places(two_checks))[len(str(value)) % EVERY :: EVERY]:
        path.write_text(json.dumps(altered(two_checks, where, value)), encoding="utf-8")
        for wanted in (Wanted(every=True, verbose=True), Wanted(every=True, as_json=True)):
            code = run_why(path, wanted)
            said = capsys.readouterr()
            assert code in (0, 2), (where, said.err[-600:])
            assert "Traceback" not in said.err
            assert code == 0 or said.err.startswith("ballesta: "), where


@pytest.mark.parametrize("formula", [f for f in FORMULAS if f not in ("sigma", "\ud800")])
def test_a_formula_without_a_number_is_refused_in_words(two_checks, tmp_path, capsys, formula):
    sections = two_checks["parts"][0]["checks"][0]["derivation"]["sections"]
    (at,) = [k for k, s in enumerate(sections) if s["title"] == "Demand"]
    where = ("parts", 0, "checks", 0, "derivation", "sections", at, "items", 0, "formula")
    path = tmp_path / "result.json"
    path.write_text(json.dumps(altered(two_checks, where, formula)), encoding="utf-8")
    assert run_why(path, Wanted(every=True)) == 2
    said = capsys.readouterr().err
    assert "the formulas give no number" in said
    assert len(said) < 1000


def test_the_example_of_the_documentation_runs(result, tmp_path, monkeypatch):
    page = Path(__file__).parents[3] / "docs" / "derivations.md"
    code = page.read_text(encoding="utf-8").split("```")[-2]
    (tmp_path / "out" / "toggle_press").mkdir(parents=True)
    (tmp_path / "out" / "toggle_press" / "result.json").write_bytes(result.read_bytes())
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(code, names)
    assert names["limit"] == names["check"].limit


def test_a_missing_file_is_refused(tmp_path):
    assert run_why(tmp_path / "none.toml", Wanted()) == 2
    assert run_why(tmp_path / "none.json", Wanted()) == 2


def test_everything_names_every_unit_load(result, capsys):
    run_why(result, Wanted("rod", ("static",), verbose=True))
    told = capsys.readouterr().out
    assert "second cos 1" in told
    assert "sum: s" in told


def test_as_json_the_check_has_its_derivation(result, capsys):
    assert run_why(result, Wanted("rod", ("static",), as_json=True)) == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert found["derivation"]["value"] == "sigma"


def test_the_command_line_has_it(result, capsys):
    assert main(["why", str(result), "rod", "static"]) == 0
    assert capsys.readouterr().out.startswith("rod static")


def test_a_result_of_another_format_is_not_told(result, tmp_path):
    """Another number behind the name may mean other numbers inside."""
    data = json.loads(result.read_text())
    path = tmp_path / "result.json"
    for wrong in ("ballesta-result/2", "ballesta-result/1x", "ballesta-result/"):
        path.write_text(json.dumps({**data, "format": wrong}))
        with pytest.raises(DesignError, match=r"is no result of this version \(format"):
            checks_behind(path)
    path.write_text(json.dumps(data))
    assert checks_behind(path)
