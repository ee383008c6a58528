"""The parent's end of a worker process: start it, hand it a job, read replies, end it."""

import json
import os
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from fem.threads import ONE_THREAD

_ROOT = Path(__file__).resolve().parents[2]
_LONGEST_LOG = 4000  # bytes of what a worker said last


@dataclass
class Task:
    """A job on its way: its place in the batch, how often it was begun, whether it needs peace."""

    index: int
    job: Any
    attempts: int = 0
    alone: bool = False


class WorkerProcess:
    """A started interpreter that runs one job after the other.

    folder  of its log and of what it keeps for a moment; removed with it
    cwd     that the paths of its jobs start from; None for where this process is
    """

    def __init__(self, function: str, folder: Path, cwd: Path | None = None) -> None:
        self.task: Task | None = None
        self.ready = False
        self.done = 0  # jobs
        self.since = monotonic()  # it was started, or was handed its job
        self.cap = 0  # bytes that its job may take
        self._buffer = b""
        self._folder = folder
        self._log = folder / "log"
        temporary = folder / "tmp"
        temporary.mkdir(parents=True)
        paths = [str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
        environment = {
            **os.environ,
            **ONE_THREAD,
            "PYTHONPATH": os.pathsep.join(paths),
            "TMPDIR": str(temporary),
        }
        with self._log.open("ab") as log:
            self._process = subprocess.Popen(
                # -P: modules of the user's own folder must not stand in for ours
                [sys.executable, "-P", "-m", "ballesta.batch.worker", function],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log,
                env=environment, cwd=cwd, start_new_session=True, bufsize=0,
            )  # fmt: skip

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    def fileno(self) -> int:
        """Where its replies arrive."""
        assert self._process.stdout is not None
        return self._process.stdout.fileno()

    def give(self, task: Task, cap: int) -> bool:
        """Hand it a job; False when it is no longer there to take it."""
        assert self._process.stdin is not None
        assert self.task is None
        with suppress(OSError):
            os.truncate(self._log, 0)
        message = json.dumps({"memory": cap, "job": task.job}).encode() + b"\n"
        try:
            while message:
                message = message[self._process.stdin.write(message) or 0 :]
        except OSError:
            return False
        self.task, self.cap, self.since = task, cap, monotonic()
        task.attempts += 1
        return True

    def replies(self) -> list[dict[str, Any]] | None:
        """Replies that have arrived; None when it has ended."""
        data = os.read(self.fileno(), 1 << 20)
        if not data:
            return None
        *lines, self._buffer = (self._buffer + data).split(b"\n")
        return [json.loads(line) for line in lines]

    def said(self) -> list[str]:
        """The last lines that it told, errors of libraries among them."""
        try:
            with self._log.open("rb") as log:
                log.seek(max(0, self._log.stat().st_size - _LONGEST_LOG))
                return log.read().decode(errors="replace").splitlines()
        except OSError:
            return []

    def ending(self) -> str:
        """How a worker whose replies have stopped has ended, in words."""
        options = os.WEXITED | os.WNOWAIT | os.WNOHANG  # reaped by `end`: until then its id is kept
        for _ in range(200):
            found = os.waitid(os.P_PID, self.pid, options)
            if found is not None:
                killed = found.si_code in (os.CLD_KILLED, os.CLD_DUMPED)
                return ending(-found.si_status if killed else found.si_status)
            sleep(0.005)
        return "no longer answers"

    def end(self) -> None:
        """Kill it with everything it started."""
        with suppress(OSError):
            os.killpg(self.pid, signal.SIGKILL)
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with suppress(OSError):
                    stream.close()

    def tidy(self) -> None:
        """Remove its folder."""
        shutil.rmtree(self._folder, ignore_errors=True)


def ending(code: int) -> str:
    """How a process ended, in words.

    >>> ending(-11), ending(1)
    ('was killed by signal SIGSEGV', 'ended with exit code 1')
    """
    if code >= 0:
        return f"ended with exit code {code}"
    try:
        return f"was killed by signal {signal.Signals(-code).name}"
    except ValueError:
        return f"was killed by signal {-code}"
