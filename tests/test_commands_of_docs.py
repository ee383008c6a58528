"""Every command of README and docs can be typed as it stands."""

import re
import shlex
from pathlib import Path

import pytest
from typer.main import get_command

from ballesta.cli import app

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
FOUND = ". .venv/bin/activate"
COMMAND = re.compile(r"^(?:\$ )?(ballesta (?:.*\\\n)*.*)$", re.MULTILINE)


def commands(text):
    """Commands of a page's code blocks, with where each begins."""
    for block in re.finditer(r"^```\w*\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
        for found in COMMAND.finditer(block[1]):
            yield block.start(), found[1].replace("\\\n", " ")


def test_pages_with_commands_say_before_them_how_they_are_found():
    told = 0
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        first = next((start for start, _ in commands(text)), None)
        if first is not None:
            told += 1
            assert FOUND in text[:first], page
    assert told >= 6


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_command_has_the_options_and_files_that_it_names(page):
    group = get_command(app)
    for _, line in commands(page.read_text(encoding="utf-8")):
        name, *words = shlex.split(line, comments=True)[1:]
        group.commands[name].make_context(name, list(words))  # raises for what it does not know
        for word in words:
            if word.startswith("designs/"):
                assert (ROOT / word).exists(), line
