"""The one full check of the toggle press that several tests look at."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from fem.threads import ONE_THREAD

os.environ.update(ONE_THREAD)  # before any test loads a library that has threads of its own
ROOT = Path(__file__).parent.parent


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
    """Run the command line as a user does, 120 columns wide."""
    done = subprocess.run(
        [sys.executable, "-P", "-m", "ballesta.cli", *arguments],
        cwd=cwd,
        capture_output=True,
        text=True,
        env=os.environ | {"COLUMNS": "120", "PYTHONPATH": str(ROOT)},
        check=False,
    )
    return Run(done.returncode, done.stdout, done.stderr, out)


@pytest.fixture(scope="session")
def command() -> Callable[..., Run]:
    """The command line as a function: arguments, and `out`, the folder it writes to."""
    return run_ballesta


@pytest.fixture(scope="session")
def press(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """`ballesta check designs/toggle_press.toml`, whole and at its usual fineness."""
    out = tmp_path_factory.mktemp("press")
    return run_ballesta("check", "designs/toggle_press.toml", "--out", str(out), out=out)
