"""Fixtures for tests of all folders: the command line, one full check of the press, a store."""

import ctypes
import fcntl
import gc
import io
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from ballesta.batches.processes import MIB, ending, resident_bytes
from ballesta.cli import main
from fem.threads import ONE_THREAD

from . import longest_first, processor_budget, with_examples

os.environ.update(ONE_THREAD)  # before any test loads a library that has threads of its own
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # or each process compiles some 600 modules anew
ROOT = Path(__file__).parent.parent
collect_ignore = ["windows/sitecustomize.py"]  # imported it blocks modules, as is its purpose
SHARES: list[tuple[Any, str, Any, Any]] = []  # place, name, with the shared store and without
MORE = 300 * MIB  # that a module of tests may leave behind, else memory is given back
LEFT = [0]  # bytes that this process held after it was given back
AS_A_USER = {"COLUMNS": "120", "PYTHONPATH": str(ROOT)}


def pytest_configure(config: pytest.Config) -> None:
    """Give tests a budget of processor time, what lasts long the first turn, no empty doctests."""
    for plugin in (processor_budget, longest_first, with_examples):
        if not config.pluginmanager.is_registered(plugin):
            config.pluginmanager.register(plugin)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any, error: Any) -> None:
    """Say how a process of the tests ended that was not to end: pytest-xdist does not."""
    if error:
        print(f"\n{node.gateway.id} {ending(node.gateway._io.popen.wait(10))}")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Keep the garbage collector from what is collected, which stays to the end."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@dataclass(frozen=True)
class Run:
    """A finished command: exit code, what it printed, and the folder it wrote to."""

    code: int
    stdout: str
    stderr: str
    out: Path

    @property
    def result(self) -> dict[str, Any]:
        """result.json of the toggle press."""
        return json.loads((self.out / "toggle_press" / "result.json").read_text())


def run_ballesta(*arguments: str, out: Path, cwd: Path = ROOT) -> Run:
    """Run the command line in this process, 120 columns wide."""
    told, said = io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patch, chdir(cwd):
        for name, value in AS_A_USER.items():
            patch.setenv(name, value)
        with redirect_stdout(told), redirect_stderr(said):
            code = main(arguments)
    return Run(code, told.getvalue(), said.getvalue(), out)


@pytest.fixture(scope="session")
def command() -> Callable[..., Run]:
    """The command line as a function: arguments, and `out`, the folder it writes to."""
    return run_ballesta


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that the processes of one run of the tests have in common."""
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "shared"
    folder.mkdir(exist_ok=True)
    return folder


def made_once(kept: Path, make: Callable[[], Any]) -> Any:
    """Return what `make` gives, as JSON holds it; one process makes it, the others wait for it."""
    with kept.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not kept.exists():
            kept.write_text(json.dumps(make()))
    return json.loads(kept.read_text())


@pytest.fixture(scope="session")
def press(shared: Path) -> Run:
    """`ballesta check designs/toggle_press.toml`, whole, at its usual fineness, as a user runs it.

    One process of the tests runs it, the others wait for it.
    """
    out = shared / "press"

    def run() -> tuple[int, str, str]:
        done = subprocess.run(
            [sys.executable, "-P", "-m", "ballesta", "check", "designs/toggle_press.toml",
             "--out", str(out)],
            cwd=ROOT, env=os.environ | AS_A_USER, capture_output=True, text=True, check=False,
        )  # fmt: skip
        return done.returncode, done.stdout, done.stderr

    return Run(*made_once(shared / "press.json", run), out)


@pytest.fixture(scope="session", autouse=True)
def equal_scenes_are_made_once(shared: Path) -> Iterator[None]:
    """What has no store of its own shares one among all tests, bit by bit equal.

    That is meshes and solutions of parts, loads of cycles, and the buckling of linkages. A test
    that looks at how they are made, or alters it, asks for `unshared`.
    """
    from ballesta import pipeline
    from ballesta.machine import solved_cycles
    from checks.columns.linkage_store import unjudged
    from checks.store.store import GIB, Store
    from checks.stress.solid_mesh_level import Models

    store = Store(shared / "store", limit=GIB)
    begin, mode, cycle = Models.__init__, pipeline.worst_mode, solved_cycles.stored_loads
    packages = ("checks", "fem", "geometry", "loads")

    def with_store(self: Models, own: Store | None = None) -> None:
        begin(self, store if own is None else own)

    def one_mode(design: Any, solved: Any, *motions: Any) -> Any:
        found = (unjudged(design), solved)
        return store.remember(
            "linkage_mode", packages, found, lambda: mode(design, solved, *motions)
        )

    def one_cycle(own: Store | None, *linkage_and_cycle: Any) -> Any:
        return cycle(store if own is None else own, *linkage_and_cycle)

    SHARES[:] = [
        (Models, "__init__", with_store, begin),
        (pipeline, "worst_mode", one_mode, mode),
        (solved_cycles, "stored_loads", one_cycle, cycle),
    ]
    with pytest.MonkeyPatch.context() as patch:
        for place, name, with_it, _ in SHARES:
            patch.setattr(place, name, with_it)
        yield


@pytest.fixture(scope="module", autouse=True)
def memory_is_given_back() -> Iterator[None]:
    """Arrays of solids in cycles, and their gaps on the heap, made a process grow to 2.5 GB."""
    yield
    if resident_bytes() > LEFT[0] + MORE:
        gc.collect()
        if hasattr(ctypes.CDLL(None), "malloc_trim"):
            ctypes.CDLL(None).malloc_trim(0)
        LEFT[0] = resident_bytes()


@pytest.fixture(scope="module")
def unshared(equal_scenes_are_made_once: None) -> Iterator[None]:
    """Nothing is shared, as a check without a store has it, for the tests of a module."""
    with pytest.MonkeyPatch.context() as patch:
        for place, name, _, without in SHARES:
            patch.setattr(place, name, without)
        yield
