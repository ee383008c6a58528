"""Drawing in a process of its own: VTK kills its process where graphics libraries are missing."""

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from reports.words import clean


@dataclass(frozen=True)
class Ended:
    """How a worker ended: its exit code, None where it did not start or was stopped; in words.

    words  "" where it ended well
    """

    code: int | None
    words: str


def run_worker(
    command: Sequence[str], folder: Path, timeout: float | None, *, window: bool = False
) -> Ended:
    """Run a worker in a folder until it ends, for at most `timeout` seconds.

    window  whether it opens one, and so must not be kept from the display

    Its failure is told in the result, never an exception.
    """
    environment = dict(os.environ)
    here = str(Path(__file__).resolve().parent.parent)
    paths = [here, *filter(None, [environment.get("PYTHONPATH")])]
    environment["PYTHONPATH"] = os.pathsep.join(paths)
    linux = sys.platform.startswith("linux")
    if linux and not window and not environment.get("DISPLAY"):
        environment["VTK_DEFAULT_OPENGL_WINDOW"] = "vtkEGLRenderWindow"
    try:
        done = subprocess.run(
            command, cwd=folder, env=environment, timeout=timeout, check=False,
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return Ended(None, f"drawing took longer than {timeout:g} s and was stopped")
    except OSError as error:
        return Ended(None, f"the worker did not start ({clean(error)})")
    if done.returncode == 0:
        return Ended(0, "")
    last = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
    said = f"; it said: {clean(last[0])[:300]}" if last else ""
    return Ended(done.returncode, f"the worker ended with {_ending(done.returncode)}{said}")


def _ending(code: int) -> str:
    """Exit code in words; shells report a signal as 128 and its number."""
    number = -code if code < 0 else code - 128
    try:
        name = signal.Signals(number).name
    except ValueError:
        return f"exit code {code}"
    return f"exit code {code}, signal {name}"
