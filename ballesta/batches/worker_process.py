"""The parent's end of a worker process: start it, hand it a job, read replies, end it."""

import json
import os
import shutil
import subprocess
import sys
import threading
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from time import monotonic
from typing import Any

from ballesta.batches.processes import end_with_children, ending
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


Replies = SimpleQueue[tuple["WorkerProcess", dict[str, Any] | None]]


class WorkerProcess:
    """A started interpreter that runs one job after the other.

    folder   of its log and of what it keeps for a moment; removed with it
    replies  takes each reply together with the worker, None when it has ended
    cwd      that the paths of its jobs start from; None for where this process is
    """

    def __init__(
        self, function: str, folder: Path, replies: Replies, cwd: Path | None = None
    ) -> None:
        self.task: Task | None = None
        self.ready = False
        self.done = 0  # jobs
        self.since = monotonic()  # it was started, or was handed its job
        self.cap = 0  # bytes that its job may take
        self._folder = folder
        self._log = folder / "log"
        temporary = folder / "tmp"
        temporary.mkdir(parents=True)
        paths = [str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
        environment = {
            **os.environ,
            **ONE_THREAD,
            "PYTHONPATH": os.pathsep.join(paths),
            **dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(temporary)),
        }
        with self._log.open("ab") as log:
            self._process = subprocess.Popen(
                # -P: modules of the user's own folder must not stand in for ours
                [sys.executable, "-P", "-m", "ballesta.batches.worker", function],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log,
                env=environment, cwd=cwd, start_new_session=True,
            )  # fmt: skip
        threading.Thread(target=self._read, args=(replies,), daemon=True).start()

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    def give(self, task: Task, cap: int) -> bool:
        """Hand it a job; False when it is no longer there to take it."""
        assert self._process.stdin is not None
        assert self.task is None
        with suppress(OSError):
            os.truncate(self._log, 0)
        message = json.dumps({"memory": cap, "job": task.job}).encode() + b"\n"
        try:
            self._process.stdin.write(message)
            self._process.stdin.flush()
        except OSError:
            return False
        self.task, self.cap, self.since = task, cap, monotonic()
        task.attempts += 1
        return True

    def _read(self, replies: Replies) -> None:
        """Pass its replies on, then None: by a thread of its own, for Windows selects no pipe."""
        assert self._process.stdout is not None
        with self._process.stdout as lines:
            for line in lines:
                if line.endswith(b"\n"):  # else it was killed in the middle of it
                    replies.put((self, json.loads(line)))
        replies.put((self, None))

    def said(self) -> list[str]:
        """The last lines that it told, errors of libraries among them."""
        try:
            with self._log.open("rb") as log:
                log.seek(max(0, self._log.stat().st_size - _LONGEST_LOG))
                return log.read().decode(errors="replace").splitlines()
        except OSError:
            return []

    def ending(self) -> str:
        """Exit of a worker that has stopped replying, in words."""
        try:
            return ending(self._process.wait(1.0))
        except subprocess.TimeoutExpired:
            return "no longer answers"

    def end(self) -> None:
        """Kill it with everything it started."""
        end_with_children(self._process)
        assert self._process.stdin is not None
        with suppress(OSError):
            self._process.stdin.close()

    def tidy(self) -> None:
        """Remove its folder."""
        shutil.rmtree(self._folder, ignore_errors=True)
