"""pytest in a user's own repository: what is a test, what fails, and what it says."""

import subprocess
import sys
from xml.etree import ElementTree

import pytest

from ballesta.regression.file import read_baseline

from .conftest import ROOT

pytest_plugins = ("pytester",)


def designs(repository, name):
    return repository.path / "designs" / name


def changed(repository, old, new):
    """Edit the design, as a colleague would."""
    file = designs(repository, "machine.toml")
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")


def test_a_design_inside_its_baseline_passes(run):
    result = run("designs/", "-v")
    result.assert_outcomes(passed=1)
    result.stdout.fnmatch_lines(["designs/machine.baseline.json::machine PASSED*"])


def test_a_design_that_leaves_its_baseline_fails_with_a_table_and_the_likely_cause(run, repository):
    changed(repository, 'width = "30 mm"', 'width = "29 mm"')
    result = run("designs/")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "*design machine*",
            "machine has left its baseline (machine.baseline.json)",
            "quantity * baseline * now * change * band",
            "rod: static: peak von Mises stress [[]MPa] * +* % * ±0.0001 %",
            "likely cause: the geometry of rod*",
            "if the change is meant: pytest designs/machine.baseline.json::machine "
            "--update-baselines, review, commit",
        ]
    )
    result.stdout.no_fnmatch_line("*Traceback*")


def test_a_new_baseline_fails_its_first_run_and_passes_the_next(run, repository):
    baseline = designs(repository, "machine.baseline.json")
    before = read_baseline(baseline).record
    baseline.unlink()
    run("designs/").assert_outcomes()
    first = run("designs/", "--update-baselines", "--baseline-fidelity", "formula")
    first.assert_outcomes(failed=1)
    first.stdout.fnmatch_lines(
        ["machine.baseline.json is new: review machine.baseline.json and commit it; run without*"]
    )
    assert read_baseline(baseline).record["parts"] == before["parts"]
    run("designs/").assert_outcomes(passed=1)


def test_a_rewritten_baseline_fails_keeps_bands_and_rungs_and_tells_what_changed(run, repository):
    baseline = designs(repository, "machine.baseline.json")
    text = baseline.read_text(encoding="utf-8").replace('"bands": {}', '"bands": {"static": "3 %"}')
    baseline.write_text(text, encoding="utf-8")
    changed(repository, 'width = "30 mm"', 'width = "26 mm"')
    result = run("designs/", "--update-baselines")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "machine.baseline.json was written again: review machine.baseline.json and commit it*",
            "rod: static: peak von Mises stress [[]MPa] * ±3 %",
        ]
    )
    now = baseline.read_text(encoding="utf-8")
    assert '"bands": {"static": "3 %"}' in now
    assert '"rungs": {"static": "formula", "fatigue": "formula", "buckling": "formula"}' in now
    assert now != text


def test_the_users_modules_and_ours_do_not_meet(run_apart, repository):
    """The user's own loads.py, reports/ and fem/ are theirs, and break nothing of ours."""
    broken = "raise AssertionError('taken for one of ballesta')"
    for package in ("fem", "fatigue", "geometry"):
        repository.mkpydir(package).joinpath("__init__.py").write_text(broken, encoding="utf-8")
    repository.mkpydir("reports").joinpath("__init__.py").write_text("OURS = 1", encoding="utf-8")
    repository.makepyfile(loads="OURS = 2", conftest="import loads")
    designs(repository, "loads.py").write_text(broken, encoding="utf-8")
    repository.makepyfile(
        test_own="""
        import loads, reports

        def test_own_modules():
            assert (reports.OURS, loads.OURS) == (1, 2)
        """
    )
    run_apart().assert_outcomes(passed=2)


def test_the_plugin_imports_nothing_that_the_user_may_have_too():
    code = (
        "import sys, ballesta.regression.plugin as plugin\n"
        "ours = {'loads', 'reports', 'fem', 'fatigue', 'geometry', 'numpy', 'gmsh', 'pydantic'}\n"
        "print(plugin.__file__, sorted(ours & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.split(maxsplit=1)[1].strip() == "[]"


@pytest.mark.slow
def test_designs_run_side_by_side_under_xdist_with_a_junit_report(run_apart, repository):
    pytest.importorskip("xdist")
    for name in ("machine.toml", "machine.baseline.json"):
        text = designs(repository, name).read_text(encoding="utf-8")
        copy = designs(repository, f"other{name.removeprefix('machine')}")
        copy.write_text(text.replace('push = "400 N"', 'push = "500 N"'), encoding="utf-8")
    run_apart("designs/", "-n", "2", "--junitxml=junit.xml").assert_outcomes(passed=1, failed=1)
    cases = ElementTree.parse(repository.path / "junit.xml").findall(".//testcase")
    assert {case.get("name") for case in cases} == {"machine", "other"}
    (failure,) = ElementTree.parse(repository.path / "junit.xml").findall(".//failure")
    assert "likely cause: the loads (linkage" in failure.text


@pytest.mark.parametrize(
    ("arguments", "collected"),
    [
        ((), True),
        (("-k", "machine"), True),
        (("-k", "press"), False),
        (("-m", "ballesta", "--strict-markers"), True),
        (("-m", "not ballesta"), False),
    ],
)
def test_designs_are_collected_and_chosen_as_any_test(run, arguments, collected):
    result = run("designs/", "--collect-only", "-q", *arguments)
    assert ("designs/machine.baseline.json::machine" in result.outlines) is collected


def test_only_designs_are_collected_where_baselines_are_to_be_written(run, repository):
    designs(repository, "machine.baseline.json").unlink()
    designs(repository, "tool.toml").write_text("[tool.parts_list]\na = 1\n", encoding="utf-8")
    designs(repository, "bytes.toml").write_bytes(b"\xff\xfe\x00")
    designs(repository, "eslint.baseline.json").write_text("{}", encoding="utf-8")
    assert "machine" not in run("designs/", "--collect-only", "-q").stdout.str()
    result = run("designs/", "--collect-only", "-q", "--update-baselines")
    assert [line for line in result.outlines if "::" in line] == ["designs/machine.toml::machine"]


def test_a_design_that_is_named_without_a_baseline_fails_and_says_how_to_get_one(run, repository):
    designs(repository, "machine.baseline.json").unlink()
    result = run("designs/machine.toml")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        ["machine.toml has no baseline; --update-baselines writes machine.baseline.json"]
    )


def test_a_design_that_cannot_be_checked_fails_with_the_tools_own_words(run, repository):
    changed(repository, 'thickness = "8 mm"', 'thickness = "8 kg"')
    result = run("designs/")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "machine could not be checked (exit code 2):",
            "machine.toml: parts.rod.thickness: *8 kg*",
        ]
    )
    result.stdout.no_fnmatch_line("*Traceback*")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "machine.baseline.json: is no JSON text in UTF-8: *"),
        ('{"format": "ballesta-baseline/1"}', "machine.baseline.json: format: must be *"),
    ],
)
def test_a_broken_baseline_fails_in_words_and_is_not_replaced(run, repository, text, said):
    baseline = designs(repository, "machine.baseline.json")
    baseline.write_text(text, encoding="utf-8")
    result = run("designs/")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([said])
    run("designs/", "--update-baselines").assert_outcomes(failed=1)
    assert baseline.read_text(encoding="utf-8") == text


def test_a_baseline_without_its_design_fails(run, repository):
    designs(repository, "machine.toml").unlink()
    result = run("designs/")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["machine.baseline.json is the baseline of no design: *"])


def test_a_check_that_takes_too_long_fails_and_says_so(run_apart):
    result = run_apart("designs/", "-o", "ballesta_timeout=0.05")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["the check took longer than 0.05 s (ballesta_timeout)*"])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("-o", "ballesta_timeout=soon"), "*ballesta_timeout: must be above 0 s, got 'soon'"),
        (("--baseline-fidelity", "formula"), "*--baseline-fidelity needs --update-baselines*"),
    ],
)
def test_options_that_mean_nothing_are_refused(run, arguments, said):
    result = run("designs/", *arguments)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([said])
