"""Drawing in a process of its own: VTK kills its process where graphics libraries are missing."""

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile, gettempdir
from threading import Condition, Thread
from typing import IO

from checks.result.words import clean
from fem.threads import ONE_THREAD

PLAIN, ESTIMATE = "plain", "estimate"  # views that are drawn without graphics libraries
AHEAD = "ahead"  # a file of a folder that is not waited for


@dataclass(frozen=True)
class Ended:
    """End of a worker.

    code   exit code; None where it did not start or was stopped
    words  reason in words; "" where it ended well
    """

    code: int | None
    words: str


def run_worker(
    command: Sequence[str], folder: Path, timeout: float | None, *, window: bool = False
) -> Ended:
    """Run a worker in a folder until it ends, for at most `timeout` seconds.

    window  True if it opens one, and so must not be kept from the display

    A failure of the worker is reported in the result, never as an exception.
    """
    try:
        done = subprocess.run(
            command, cwd=folder, env=_environment(window), timeout=timeout, check=False,
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return _too_long(timeout)
    except OSError as error:
        return _not_started(error)
    return _ended(done.returncode, done.stderr)


class StandingWorker:
    """A worker that stays: it draws one folder after the other, as they are handed to it.

    Started ahead, it loads its libraries beside other work. It reads the path of a folder from each
    line of its standard input and answers with the same line when that is drawn; it ends with its
    input.
    """

    def __init__(self, command: Sequence[str]) -> None:
        self._said: IO[bytes] = TemporaryFile()  # noqa: SIM115 (closed by `end`)
        self._heard = Condition()
        self._drawn: set[bytes] = set()
        self._silent = False  # it has ended
        self._process: subprocess.Popen[bytes] | None = None
        try:
            self._process = subprocess.Popen(
                command, cwd=gettempdir(), env=_environment(window=False), bufsize=0,
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._said,
            )  # fmt: skip
        except OSError as error:
            self._failure = _not_started(error)
            return
        self._listener = Thread(target=self._listen, daemon=True)
        self._listener.start()

    @property
    def runs(self) -> bool:
        """True if it was started and has not ended."""
        return self._process is not None and self._process.poll() is None

    def hand(self, folder: Path) -> None:
        """Hand it a folder to draw; `answer` reports the outcome."""
        self._tell(_line(folder))

    def prepare(self) -> None:
        """Have it load the modules that only some folders need."""
        self._tell(b"\n")

    def answer(self, folder: Path, timeout: float) -> Ended:
        """Wait until the folder is drawn, or the worker has ended, for at most `timeout` seconds.

        A failure of the worker is reported in the result, never as an exception.
        """
        if self._process is None:
            return self._failure
        line = _line(folder)
        with self._heard:
            told = self._heard.wait_for(lambda: line in self._drawn or self._silent, timeout)
            if line in self._drawn:
                self._drawn.remove(line)
                return Ended(0, "")
        if not told:
            return _too_long(timeout)
        code = self._process.wait()
        self._said.seek(0)
        return _ended(code, self._said.read())

    def end(self) -> None:
        """Stop it; one that has ended is tidied up."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._listener.join()
            for stream in (self._process.stdin, self._process.stdout):
                if stream is not None:
                    with suppress(OSError):
                        stream.close()
        self._said.close()

    def _tell(self, line: bytes) -> None:
        if self._process is not None and self._process.stdin is not None:
            with suppress(OSError):
                self._process.stdin.write(line)

    def _listen(self) -> None:
        assert self._process is not None
        assert self._process.stdout is not None
        for line in self._process.stdout:
            with self._heard:
                self._drawn.add(line)
                self._heard.notify_all()
        with self._heard:
            self._silent = True
            self._heard.notify_all()


def _line(folder: Path) -> bytes:
    return os.fsencode(folder) + b"\n"


def _environment(window: bool) -> dict[str, str]:
    """The environment of a worker, which finds these modules and, unless it opens a window, GL."""
    environment = {**os.environ, **ONE_THREAD}
    here = str(Path(__file__).resolve().parent.parent)
    paths = [here, *filter(None, [environment.get("PYTHONPATH")])]
    environment["PYTHONPATH"] = os.pathsep.join(paths)
    linux = sys.platform.startswith("linux")
    if linux and not window and not environment.get("DISPLAY"):
        environment["VTK_DEFAULT_OPENGL_WINDOW"] = "vtkEGLRenderWindow"
    return environment


def _too_long(timeout: float | None) -> Ended:
    return Ended(None, f"drawing took longer than {timeout:g} s and was stopped")


def _not_started(error: OSError) -> Ended:
    return Ended(None, f"the worker did not start ({clean(error)})")


def _ended(code: int, errors: bytes) -> Ended:
    """Return the end of a worker that left these errors."""
    if code == 0:
        return Ended(0, "")
    last = errors.decode(errors="replace").strip().splitlines()[-1:]
    said = f"; it said: {clean(last[0])[:300]}" if last else ""
    return Ended(code, f"the worker ended with {_ending(code)}{said}")


def _ending(code: int) -> str:
    """Exit code in words; shells report a signal as 128 and its number."""
    number = -code if code < 0 else code - 128
    try:
        name = signal.Signals(number).name
    except ValueError:
        return f"exit code {code}"
    return f"exit code {code}, signal {name}"
