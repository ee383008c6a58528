"""docs/sweeps.md: its Python blocks print what stands behind them, its sweeps fit their designs."""

import contextlib
import io
import re
import shlex
from itertools import pairwise
from pathlib import Path

import pytest

from ballesta.commands.batch_command import parts_of
from ballesta.design.read import read_design
from ballesta.sweeps.sweep import design_variations, parse_sweep

ROOT = Path(__file__).parent.parent.parent
PAGE = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
BLOCKS = re.findall(
    r"^#+ ([^\n]*)\n(?:(?!^#+ ).)*?^```python\n(.*?)^```\n\n```text\n(.*?)^```", PAGE, re.S | re.M
)

FAST = "Differences"  # the shortest example, which `make test` runs, too


@pytest.mark.budget(60.0, "a page's example is run as it stands")
@pytest.mark.parametrize(("code", "printed"), [
    pytest.param(code, printed, id=title, marks=() if title == FAST else pytest.mark.slow)
    for title, code, printed in BLOCKS
])  # fmt: skip
def test_an_example_prints_what_the_page_says(code, printed, monkeypatch):
    monkeypatch.chdir(ROOT)
    told = io.StringIO()
    with contextlib.redirect_stdout(told):
        exec(compile(code, "docs/sweeps.md", "exec"), {"__name__": "example"})
    expected, more, _ = printed.partition("...\n")
    assert told.getvalue()[: len(expected)] == expected
    assert more or len(told.getvalue()) == len(expected)


def test_every_example_of_the_page_is_run():
    assert FAST in [title for title, *_ in BLOCKS]
    assert len(BLOCKS) == PAGE.count("```python") == PAGE.count("```text") == 5


def test_every_sweep_of_the_table_is_understood():
    table = PAGE.split("| Written |")[1].split("\n\n")[0]
    sweeps = re.findall(r"^\| `(.*?)` \|", table, re.M)
    assert len(sweeps) == 8
    for sweep in sweeps:
        parse_sweep(sweep)


def test_the_commands_of_the_page_fit_their_designs(monkeypatch):
    """Every variation reads but for what only its check could tell."""
    monkeypatch.chdir(ROOT)
    commands = [
        shlex.split(line) for line in PAGE.splitlines() if line.startswith("ballesta batch")
    ]
    assert len(commands) == 3
    for words in commands:
        given = [(option, value) for option, value in pairwise(words) if option.startswith("--")]
        sweeps = [value for option, value in given if option == "--sweep"]
        samples = [int(value) for option, value in given if option == "--sample"]
        found = design_variations(words[2], sweeps, *samples)
        assert len(found) == (samples or [4 if len(sweeps) == 1 else 14])[0]
        for variation in found[:20]:
            read_design(words[2], variation)
        for option, value in given:
            if option == "--until":
                assert parts_of(value) == ("lower_left", "lower_right")
