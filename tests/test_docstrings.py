"""Docstrings begin with the name of a thing, as a textbook's index would."""

import ast
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FOLDERS = ("geometry", "loads", "fatigue", "fem", "checks", "reports", "ballesta", "bench", "tools")
BEGINNINGS = ("What", "Whether")
SAID = ("is told", "that of")


def statements(node):
    """A module or statement and all statements in it; expressions, most of a tree, have none."""
    yield node
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.expr):
            yield from statements(child)


@cache
def docstrings(folder):
    """Place and text of every docstring in a folder."""
    found = []
    for file in sorted((ROOT / folder).rglob("*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        for node in statements(tree):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                text = ast.get_docstring(node)
                if text:
                    line = getattr(node, "lineno", 1)
                    module = isinstance(node, ast.Module)
                    found.append((f"{file.relative_to(ROOT)}:{line}", module, text))
    return found


@pytest.mark.parametrize("folder", FOLDERS)
def test_no_docstring_begins_with_a_question(folder):
    """A module's does not begin with How, either: it names its subject."""
    found = docstrings(folder)
    assert len(found) > 20
    asked = [
        place
        for place, is_module, text in found
        if text.split()[0] in (*BEGINNINGS, *(("How",) if is_module else ()))
    ]
    assert asked == []


def test_no_module_of_tests_begins_with_a_question():
    """Functions have sentences for names, and docstrings for their sources only."""
    asked = [
        place
        for place, is_module, text in docstrings("tests")
        if is_module and text.split()[0] in (*BEGINNINGS, "How")
    ]
    assert asked == []


@pytest.mark.parametrize("folder", FOLDERS)
def test_no_docstring_says_that_something_is_told_or_is_that_of_another(folder):
    said = [
        place
        for place, _, text in docstrings(folder)
        if any(words in " ".join(text.split()) for words in SAID)
    ]
    assert said == []
