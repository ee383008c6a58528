"""docs/regression.md is true: its design, its edit, its files and what pytest prints."""

import re

import pytest

from .conftest import ROOT

pytest_plugins = ("pytester",)

NUMBER = r"(?<=: )[\d.]+"
TEXT = (ROOT / "docs" / "regression.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```\n", TEXT, re.DOTALL)


def texts(block):
    """What is left of a block without its numbers."""
    return re.sub(NUMBER, "#", block).split()


def numbers(block):
    return [float(number) for number in re.findall(NUMBER, block)]


def test_the_documented_example_runs_as_it_is_told(run, repository):
    """Commands in their order, the documented edit before the last; times and rules left out."""
    folder = repository.path / "designs"
    design, baseline = folder / "machine.toml", folder / "machine.baseline.json"
    baseline.unlink()
    design.write_text(blocks("toml")[0], encoding="utf-8")
    old, new = re.search(r"changes `(width = .*?)` to `(width = .*?)`", TEXT).groups()
    commands = blocks("console")
    assert len(commands) == 3
    for number, block in enumerate(commands):
        if number == 2:
            design.write_text(design.read_text(encoding="utf-8").replace(old, new))
        command, *shown = block.splitlines()
        words = command.split()
        assert words[:2] == ["$", "pytest"]
        printed = run(*words[2:], "-q", "--no-header", "-rN").outlines
        for line in shown:
            assert any(other.startswith(line) for other in printed), (line, printed)
    shown, written = blocks("json")[0], baseline.read_text(encoding="utf-8")
    begin = written.index(shown.splitlines()[0])
    lines = written[begin:].splitlines()[: len(shown.splitlines())]
    assert texts(shown) == texts("\n".join(lines))
    # another processor's round-off, which is the band of formulas
    assert numbers("\n".join(lines)) == pytest.approx(numbers(shown), rel=1e-6)
