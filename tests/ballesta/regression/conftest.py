"""A user's repository with a small design in it, whose check takes about a second."""

from importlib.metadata import entry_points
from pathlib import Path

import pytest

from ballesta.regression.file import write_record
from ballesta.regression.isolated import measure

from ..small_machine import MACHINE, PLATE

ROOT = Path(__file__).parents[3]
DESIGN = MACHINE + PLATE


@pytest.fixture(scope="session")
def small_record(tmp_path_factory):
    """What the small machine gives by formula."""
    design = tmp_path_factory.mktemp("small") / "machine.toml"
    design.write_text(DESIGN, encoding="utf-8")
    return measure(design, fidelity="formula")


@pytest.fixture
def repository(pytester, monkeypatch, small_record):
    """A folder with designs/machine.toml and its baseline; pytest there finds the plugin."""
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    for name in ("PYTEST_ADDOPTS", "PYTEST_PLUGINS"):
        monkeypatch.delenv(name, raising=False)
    folder = pytester.mkdir("designs")
    (folder / "machine.toml").write_text(DESIGN, encoding="utf-8")
    write_record(folder / "machine.baseline.json", small_record, {})
    return pytester


@pytest.fixture
def run(repository):
    """Run pytest in the repository, as its user does."""
    installed = {found.name for found in entry_points(group="pytest11")}
    plugin = [] if "ballesta" in installed else ["-p", "ballesta.regression.plugin"]

    def run_pytest(*arguments):
        return repository.runpytest_subprocess(*plugin, *arguments, timeout=300)

    return run_pytest
