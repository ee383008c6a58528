"""A pool of worker processes that outlives kills, hangs and memory blow-ups of its workers.

Plain processes with pipes: in `concurrent.futures` a killed worker breaks the whole pool, and a job
that hangs cannot be stopped. pebble's pool can stop it, but ends the worker without what it has
started, watches no memory, and lets it work on when the parent is killed.

The parent's end of a worker process: start it, hand it a job, read replies, end it.
"""

import json
import os
import shutil
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from shutil import rmtree
from time import monotonic
from typing import Any

from ballesta.batches.job import CRASHED, OUT_OF_MEMORY, OUT_OF_TIME
from ballesta.batches.processes import Admission, end_with_children, ending, resident_bytes
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
                [sys.executable, "-P", "-m", "ballesta.batches.processes", function],
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


_LOOK_EVERY = 0.05  # s, for time limits and memory
_LONGEST_START = 120.0  # s, of an interpreter
_ATTEMPTS = 2  # a job whose worker dies is tried again: it may have been killed for another's sake
_JOBS_OF_A_WORKER = 250  # what libraries never give back ends with the process
_MIB = 2**20


class PoolError(Exception):
    """Workers do not start at all."""


@dataclass(frozen=True)
class Limits:
    """Time and memory that one job may take.

    seconds  of time; None for any
    beside   bytes, while others run beside it
    alone    bytes, once it has been stopped for taking more and is given the machine to itself
    """

    seconds: float | None
    beside: int
    alone: int


@dataclass(frozen=True)
class Finished:
    """A job that has ended: its place, and its outcome or how it failed.

    outcome  what the job's function returned; None if it returned nothing
    status, error, stage, kind  of a failure; kind is the name of the exception, if it was one
    """

    index: int
    outcome: dict[str, Any] | None
    seconds: float
    peak: int
    attempts: int
    status: str = ""
    error: str = ""
    said: Sequence[str] = ()
    kind: str = ""


class Pool:
    """Runs jobs by a function that is named "module:function" in `most` workers at a time.

    folder  of what workers keep for a moment; removed at the end, as is what a kill has left there
    cwd     that the paths of jobs start from; None for where this process is

    To be used by one thread: on Linux its workers end with the thread that started them.
    """

    def __init__(
        self,
        function: str,
        most: int,
        limits: Limits,
        admission: Admission,
        folder: Path,
        cwd: Path | None = None,
    ) -> None:
        self._function, self._most, self._limits, self._cwd = function, most, limits, cwd
        self._admission = admission
        self._workers: list[WorkerProcess] = []
        self._replies: Replies = SimpleQueue()
        self._folder = folder.resolve()
        rmtree(folder, ignore_errors=True)
        self._started = self._failed_starts = 0
        self._look_at = 0.0
        self._waiting: deque[Task] = deque()
        self._alone: deque[Task] = deque()

    def __enter__(self) -> "Pool":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def at_a_time(self) -> int:
        """Number of jobs that run beside each other, as estimated so far."""
        return self._admission.fitting(self._most)

    @property
    def running(self) -> list[tuple[int, float, Sequence[str]]]:
        """Place, seconds and last words of every job that is being run."""
        now = monotonic()
        return [(w.task.index, now - w.since, w.said()) for w in self._workers if w.task]

    def results(self, jobs: Sequence[tuple[int, Mapping[str, Any]]]) -> Iterator[list[Finished]]:
        """Run jobs, (place, data as JSON knows it); yields those that ended since the last time.

        Also yields an empty list some twenty times a second, for who shows progress. Workers are
        handed their next jobs before anything is yielded. Raises PoolError.
        """
        self._waiting.extend(Task(index, job) for index, job in jobs)
        while self._waiting or self._alone or any(worker.task for worker in self._workers):
            self._hand_out()
            finished = self._collected()
            self._hand_out()
            yield finished

    def start(self, jobs: int) -> None:
        """Start workers for so many jobs ahead of `results`."""
        for _ in range(min(jobs, self.at_a_time)):
            self._start()

    def close(self) -> None:
        """End all workers at once, whatever they are doing."""
        for worker in self._workers:
            worker.end()
            worker.tidy()
        self._workers.clear()
        rmtree(self._folder, ignore_errors=True)

    def _hand_out(self) -> None:
        busy = sum(worker.task is not None for worker in self._workers)
        queue, room, cap = self._waiting, self.at_a_time, self._limits.beside
        if not queue and self._alone and not busy:
            queue, room, cap = self._alone, 1, self._limits.alone
        while queue and busy < room:
            worker = next((w for w in self._workers if w.ready and w.task is None), None)
            if worker is None:
                break
            if worker.give(queue[0], cap):
                queue.popleft()
                busy += 1
            else:
                self._drop(worker)
        starting = sum(not worker.ready for worker in self._workers)
        for _ in range(min(len(queue), room - busy) - starting):
            self._start()

    def _start(self) -> None:
        folder = self._folder / f"worker_{self._started}"
        self._workers.append(WorkerProcess(self._function, folder, self._replies, self._cwd))
        self._started += 1

    def _drop(self, worker: WorkerProcess) -> None:
        self._workers.remove(worker)
        worker.end()
        worker.tidy()

    def _collected(self) -> list[Finished]:
        finished: list[Finished] = []
        for worker, reply in self._arrived():
            if worker not in self._workers:
                continue  # ended since it replied
            if reply is None:
                finished += self._died(worker)
            elif "ready" in reply:
                worker.ready, self._failed_starts = True, 0
            else:
                finished += self._replied(worker, reply)
        if monotonic() >= self._look_at:
            for worker in list(self._workers):
                finished += self._overstepped(worker)
            self._look_at = monotonic() + _LOOK_EVERY
        return finished

    def _arrived(self) -> Iterator[tuple[WorkerProcess, dict[str, Any] | None]]:
        """Replies that are there, after the first; waits for one until it is time to look."""
        with suppress(Empty):
            yield self._replies.get(timeout=max(0.0, self._look_at - monotonic()))
            while True:
                yield self._replies.get_nowait()

    def _replied(self, worker: WorkerProcess, reply: Mapping[str, Any]) -> list[Finished]:
        task, seconds = worker.task, monotonic() - worker.since
        assert task is not None
        peak = int(reply["peak"])
        self._admission.saw(peak)
        outcome = reply.get("outcome")
        status = reply.get("failed", "") or (outcome or {}).get("status", "")
        said = worker.said() if "failed" in reply else ()
        worker.task = None
        worker.done += 1
        if "failed" in reply or status == OUT_OF_MEMORY:
            self._drop(worker)  # nobody knows what a failure has left behind
        elif worker.done >= _JOBS_OF_A_WORKER or reply["resident"] > worker.cap / 2 + 512 * _MIB:
            self._drop(worker)
        if status == OUT_OF_MEMORY and self._may_be_alone(task):
            return []
        return [
            Finished(
                task.index, outcome, seconds, peak, task.attempts, reply.get("failed", ""),
                reply.get("error", ""), said, reply.get("kind", ""),
            )
        ]  # fmt: skip

    def _may_be_alone(self, task: Task) -> bool:
        if task.alone or self._limits.alone <= self._limits.beside:
            return False
        task.alone, task.attempts = True, 0
        self._alone.append(task)
        return True

    def _died(self, worker: WorkerProcess) -> list[Finished]:
        """A worker has ended by itself, or somebody has killed it."""
        task, seconds, said = worker.task, monotonic() - worker.since, worker.said()
        ready, ending = worker.ready, worker.ending()
        self._drop(worker)
        if task is None:
            if not ready:
                self._failed_starts += 1
                if self._failed_starts >= 3:
                    raise PoolError(
                        "; ".join(["worker processes do not start", ending, *said[-1:]])
                    )
            return []
        if task.attempts < _ATTEMPTS:
            (self._alone if task.alone else self._waiting).appendleft(task)
            return []
        error = f"its process {ending}, {task.attempts} times"
        if "SIGKILL" in ending:
            error += ": the system does so for want of memory, or somebody did"
        return [self._failure(task, seconds, 0, CRASHED, error, said)]

    def _overstepped(self, worker: WorkerProcess) -> list[Finished]:
        """Stop a worker whose job takes more time or memory than it may."""
        task, seconds = worker.task, monotonic() - worker.since
        if task is None:
            if not worker.ready and seconds > _LONGEST_START:
                said = worker.said()
                self._drop(worker)
                raise PoolError("; ".join(["a worker process does not start", *said[-1:]]))
            return []
        resident = resident_bytes(worker.pid)
        if resident > worker.cap:
            said, cap = worker.said(), worker.cap
            self._drop(worker)
            self._admission.saw(min(resident, self._limits.beside))
            if self._may_be_alone(task):
                return []
            error = f"took {resident / _MIB:.0f} MiB of memory, it may take {cap / _MIB:.0f} MiB"
            return [self._failure(task, seconds, resident, OUT_OF_MEMORY, error, said)]
        limit = self._limits.seconds
        if limit is not None and seconds > limit:
            said = worker.said()
            self._drop(worker)
            error = f"took longer than {limit:g} s (--time-limit)"
            return [self._failure(task, seconds, resident, OUT_OF_TIME, error, said)]
        return []

    def _failure(
        self, task: Task, seconds: float, peak: int, status: str, error: str, said: Sequence[str]
    ) -> Finished:
        return Finished(task.index, None, seconds, peak, task.attempts, status, error, tuple(said))


def fatal_words(said: Sequence[str]) -> str:
    """The reason that a dying worker printed; "" if it printed none."""
    with suppress(StopIteration):
        return next(line.strip() for line in said if line.startswith("Fatal Python error"))
    return ""
