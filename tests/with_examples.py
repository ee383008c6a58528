"""A plugin of pytest: only modules with an example in them are searched for doctests.

Each worker collects all tests. To look through every docstring of 900 files for the examples of a
few is a sixth of what that takes.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from _pytest.doctest import DoctestModule

PROMPT = ">>>"


@pytest.hookimpl(wrapper=True)
def pytest_collect_file(file_path: Path) -> Iterator[None]:
    """Leave out a module of doctests whose text holds none."""
    found: list[Any] = yield
    if file_path.suffix == ".py" and PROMPT not in file_path.read_text(encoding="utf-8"):
        found = [each for each in found if not isinstance(each, DoctestModule)]
    return found
