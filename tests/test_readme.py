"""The README is true: its design is the design, its output the output, its Python runs."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```\n", TEXT, re.DOTALL)


def without_times(text):
    """Output without what differs between runs: seconds and the folder."""
    text = re.sub(r"^[\d.]+ s: .*?(?=^report:)", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^report: .*$", "", text, flags=re.MULTILINE)
    return [line.rstrip() for line in text.strip().splitlines()]


def test_the_design_in_the_readme_is_the_design_file():
    (shown,) = blocks("toml")
    assert shown == (ROOT / "designs" / "toggle_press.toml").read_text(encoding="utf-8")


def test_the_output_in_the_readme_is_what_the_command_prints(press):
    (shown,) = blocks("console")
    command, output = shown.split("\n", 1)
    assert command == "$ ballesta check designs/toggle_press.toml"
    assert without_times(output) == without_times(press.stdout)


def test_the_python_in_the_readme_runs(monkeypatch):
    monkeypatch.chdir(ROOT)
    found = blocks("python")
    assert found
    names = {}
    for block in found:
        exec(compile(block, "README.md", "exec"), names)


@pytest.mark.parametrize("target", [*re.findall(r"^make (\w+)", TEXT, re.MULTILINE), "bench"])
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
    used = set(re.findall(r"ballesta (check|plan|new|schema|\w+) ?(?:DESIGN|toggle|`)", TEXT))
    assert used
    assert used <= known
