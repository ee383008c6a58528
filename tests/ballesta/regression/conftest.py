"""A user's repository with a small design in it, whose check takes about a second."""

from importlib.metadata import entry_points
from pathlib import Path

import pytest

from ballesta.regression import plugin
from ballesta.regression.file import CheckError, measure, write_record
from ballesta.regression.worker import measured
from checks.design.errors import DesignError

from ...conftest import made_once
from ...small_machine import MACHINE, PLATE

ROOT = Path(__file__).parents[3]
DESIGN = MACHINE + PLATE
INSTALLED = "ballesta" in {found.name for found in entry_points(group="pytest11")}
PLUGIN = [] if INSTALLED else ["-p", "ballesta.regression.plugin"]


@pytest.fixture(scope="session")
def small_record(tmp_path_factory, shared):
    """What the small machine gives by formula."""
    design = tmp_path_factory.mktemp("small") / "machine.toml"
    design.write_text(DESIGN, encoding="utf-8")
    return made_once(shared / "small_record.json", lambda: measure(design, fidelity="formula"))


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
def run_apart(repository):
    """Run pytest in the repository, as its user does: processes of their own."""

    def run_pytest(*arguments):
        return repository.runpytest_subprocess(*PLUGIN, *arguments, timeout=300)

    return run_pytest


@pytest.fixture
def run(repository, monkeypatch):
    """Run pytest and the checks of its designs in this process."""

    def measured_here(design, *, fidelity="auto", rungs=None, timeout=None):
        with pytest.MonkeyPatch.context() as patch:
            patch.chdir(design.resolve().parent)
            try:
                return measured(Path(design.name), fidelity, rungs or {})
            except DesignError as error:
                raise CheckError(2, str(error)) from error

    def run_pytest(*arguments):
        return repository.runpytest_inprocess(*PLUGIN, *arguments)

    monkeypatch.setattr(plugin, "measure", measured_here)
    return run_pytest
