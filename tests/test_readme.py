"""README and the pages that go on from it are true: designs, output and Python are real."""

import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from ballesta.design.authoring import new_design
from ballesta.design.read import read_design
from geometry.parts import PlateLink
from tools.update_readme import folder

from .conftest import run_ballesta
from .geometry.step_files import write_step

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
DESIGN_FILES, LINKAGE_LOADS, FROM_CAD, TUTORIAL = (
    (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")
    for name in ("design_files", "linkage_loads", "parts_from_cad", "tutorial")
)
TEXT = README + DESIGN_FILES + LINKAGE_LOADS + FROM_CAD


def blocks(text, language):
    return re.findall(rf"```{language}\n(.*?)```\n", text, re.DOTALL)


def without_times(text):
    """Output without what differs between runs: seconds and the folder."""
    text = re.sub(r"^report: .*$", "", text, flags=re.MULTILINE)
    text = re.sub(r"^LADDER .*\n(?: {9}.*\n)*", _without_seconds, text, flags=re.MULTILINE)
    return [line.rstrip() for line in text.strip().splitlines()]


def _without_seconds(ladder):
    """A part's rungs in one line, whatever they took: how it is wrapped depends on that."""
    return re.sub(r"\d\S* (?:s|min) \(", "some s (", " ".join(ladder[0].split())) + "\n"


def test_the_readme_is_short():
    assert len(README.splitlines()) <= 250


def test_the_designs_that_are_shown_are_those_that_are_there():
    assert blocks(README, "toml")[0] == new_design("four_bar")
    press = (ROOT / "designs" / "toggle_press.toml").read_text(encoding="utf-8")
    assert blocks(DESIGN_FILES, "toml")[0] == press


def test_every_piece_of_a_design_file_in_the_docs_is_toml():
    pages = sorted((ROOT / "docs").rglob("*.md"))
    assert sum(len(list(map(tomllib.loads, blocks(page.read_text(), "toml")))) for page in pages)


def test_the_part_from_cad_in_the_docs_is_read(tmp_path):
    """In place of the press' lower bar, with a plate of 250 mm between its holes."""
    (press,), (shown,) = blocks(DESIGN_FILES, "toml"), blocks(FROM_CAD, "toml")
    bracket = tomllib.loads(shown)["parts"]["bracket"]
    plate = PlateLink(length=250.0, width=90.0, thickness=20.0, hole=44.0, second_hole=40.0)
    write_step(tmp_path / bracket["shape"]["step"], plate.build)
    lower = re.search(r"\[parts\.bar_lower\]\n(.+\n)+", press)[0]
    design = tmp_path / "press.toml"
    design.write_text(press.replace(lower, shown), encoding="utf-8")
    part = read_design(design).parts["bracket"]
    assert part.geometry.length == pytest.approx(250, rel=1e-9)
    assert part.geometry.found["knee"].centre == pytest.approx([0, 0, 0], abs=1e-6)


def console(text, number):
    command, output = blocks(text, "console")[number].split("\n", 1)
    return command, without_times(output)


def printed(command, where):
    done = run_ballesta(*shlex.split(command)[2:], out=Path(where), cwd=where)
    assert done.code in (0, 1), done.stderr
    return without_times(done.stdout)


def test_the_four_bar_of_the_readme_gets_the_answer_that_is_shown():
    command, output = console(README, 0)
    assert command == "$ ballesta check four_bar.toml"
    with folder() as where:
        assert output == printed(command, where)


@pytest.mark.slow
def test_the_verdict_of_the_press_in_the_docs_is_what_the_command_prints(press):
    command, output = console(DESIGN_FILES, 0)
    assert command == "$ ballesta check designs/toggle_press.toml"
    assert output == without_times(press.stdout)


def test_the_derivation_in_the_docs_is_what_the_command_prints(press):
    """Told from the result of the press: its numbers do not differ by the fourth digit."""
    command, output = console(DESIGN_FILES, 1)
    assert command == "$ ballesta why out/toggle_press bar_upper fatigue"
    folder_of_press = str(press.out / "toggle_press")
    assert output == printed(command.replace("out/toggle_press", folder_of_press), ROOT)


def test_the_loads_in_the_docs_are_what_the_command_prints():
    """Round-off gates differ between machines: their numbers are not compared."""

    def comparable(lines):
        plain = [re.sub(r"\d\.?\d*e-1\d", "round-off", line) for line in lines]
        return [" ".join(line.split()) for line in plain]

    command, output = console(LINKAGE_LOADS, 0)
    assert comparable(output) == comparable(printed(command, ROOT))


def test_the_errors_and_bars_of_the_models_in_the_readme_are_those_of_the_trade():
    trade = (ROOT / "docs" / "trade.md").read_text(encoding="utf-8")
    _, _, _, bar, error, _ = re.search(r"^\| formula \|(.*)\|$", trade, re.MULTILINE)[1].split("|")
    assert f"|{error}|{bar}|" in re.search(r"^\| `formula` \|.*$", README, re.MULTILINE)[0]


@pytest.mark.slow
def test_the_commands_of_the_tutorial_say_what_it_shows(tmp_path):
    """Those up to the batch, in their order; what follows pytest is not of this machine."""
    steps = re.findall(r"```\n(ballesta .*?)```\n(?:\n```text\n(.*?)```\n)?", TUTORIAL, re.DOTALL)
    assert len(steps) == 7
    for command, shown in steps:
        (line,) = command.strip().splitlines()
        done = subprocess.run(
            [sys.executable, "-m", "ballesta", *shlex.split(line)[1:]],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            env=os.environ | {"COLUMNS": "120", "PYTHONPATH": str(ROOT)},
            check=False,
        )
        assert done.returncode in (0, 1), done.stderr
        for text in shown.splitlines():
            assert text.strip() in done.stdout, line


def test_the_python_in_the_readme_runs(monkeypatch):
    monkeypatch.chdir(ROOT)
    found = blocks(README, "python")
    assert found
    names = {}
    for block in found:
        exec(compile(block, "README.md", "exec"), names)


@pytest.mark.parametrize("target", [*re.findall(r"^make (\w+)", README, re.MULTILINE), "bench"])
def test_the_make_targets_in_the_readme_exist(target):
    assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text(), re.MULTILINE)


@pytest.mark.parametrize(
    "path", sorted(set(re.findall(r"`((?:designs|docs|tools|tests|bench)/[\w./]*)`", TEXT)))
)
def test_the_paths_in_the_readme_exist(path):
    assert (ROOT / path).exists() or path == "bench/results.json"


def test_the_commands_in_the_readme_exist():
    from ballesta.cli import app

    known = {command.callback.__name__ for command in app.registered_commands}
    used = set(re.findall(r"ballesta (check|plan|new|schema|\w+) ?(?:DESIGN|TEMPLATE|`)", README))
    assert used
    assert used <= known
