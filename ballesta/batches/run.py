"""A batch as a Python function: runs the jobs without a result and writes the tables.

Journal of a batch: a file of JSON lines, one per finished job, to which lines are only added.

Every line carries the sha256 of what it says. A line that was cut short by a kill is cut away, one
that has been damaged is left aside, and their designs are checked again.
"""

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from hashlib import sha256
from pathlib import Path
from time import monotonic
from typing import Any, Protocol, Self

from ballesta.batches.cluster import Cluster
from ballesta.batches.job import (
    NOT_RUN,
    RUN,
    STOPPED,
    TIMINGS,
    WRONG_INPUT,
    Job,
    ended,
    folder_error,
    step_of,
    text_digest,
)
from ballesta.batches.plan import Plan
from ballesta.batches.pool import Finished, Limits, Pool, PoolError, fatal_words
from ballesta.batches.processes import FIRST_ESTIMATE, FIRST_ESTIMATES, Admission, planned_budget
from ballesta.batches.results import prepare, write_results
from checks.design.errors import DesignError, NumericsError
from checks.store.store import BY_THE_DAY

_SYNC_EVERY = 1.0  # s; waiting for the disk after each job would keep workers waiting, too
_TABLES_EVERY = 60.0  # s, while designs are checked, and a twentieth of the time at the most
_TABLES_SHARE = 20.0
Write = Callable[[int, bytes], int]


@dataclass(frozen=True)
class JournalEntry:
    """A job that has ended.

    key      digest of the job, the code and the libraries
    sources  files that its design was read from, by their paths from the batch's folder -> sha256
             of their texts
    result   sha256 of its result.json; "" without one
    outcome  as `run_job` returns it, without timings
    timings  seconds, peak_memory_bytes, attempts
    """

    key: str
    sources: Mapping[str, str]
    result: str
    outcome: dict[str, Any]
    timings: Mapping[str, float]


class Journal:
    """The journal of a folder. Opening reads it; raises OSError for a file that takes nothing.

    damaged  number of lines that were left aside
    write    how bytes reach the file, as `os.write`
    """

    def __init__(self, path: Path, write: Write = os.write) -> None:
        self._write, self._synced = write, monotonic()
        self.entries: dict[str, JournalEntry] = {}
        self.damaged = 0
        self._stream = path.open("a+b", buffering=0)
        self._file = self._stream.fileno()
        try:
            self._size = self._read(path)
            os.ftruncate(self._file, self._size)
        except BaseException:
            self._stream.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            os.fsync(self._file)
        finally:
            self._stream.close()

    def add(self, entries: Iterable[JournalEntry]) -> None:
        """Add entries: all of them or, with an OSError, none.

        A kill of any process loses none of them, a loss of power those of the last second.
        """
        entries = list(entries)
        if not entries:
            return
        data = b"".join(_line(entry) for entry in entries)
        left = data
        try:
            while left:
                left = left[self._write(self._file, left) :]
            if monotonic() - self._synced > _SYNC_EVERY:
                os.fsync(self._file)
                self._synced = monotonic()
        except OSError:
            os.ftruncate(self._file, self._size)
            raise
        self._size += len(data)
        self.entries.update((entry.key, entry) for entry in entries)

    def _read(self, path: Path) -> int:
        """Take in all lines; returns the size up to the end of the last whole one."""
        size = 0
        with path.open("rb") as lines:
            for line in lines:
                if not line.endswith(b"\n"):
                    break
                size += len(line)
                entry = _entry_journal(line)
                if entry is None:
                    self.damaged += 1
                else:
                    self.entries[entry.key] = entry
        return size


def _line(entry: JournalEntry) -> bytes:
    text = json.dumps(vars(entry), allow_nan=False, separators=(",", ":"))
    return f'{{"sha256":"{sha256(text.encode()).hexdigest()}","entry":{text}}}\n'.encode()


def _entry_journal(line: bytes) -> JournalEntry | None:
    """The entry of a line; None if the line is not as it was written."""
    head, found, text = line.rstrip(b"\n").partition(b'","entry":')
    if not found or head != b'{"sha256":"' + sha256(text[:-1]).hexdigest().encode():
        return None
    return JournalEntry(**json.loads(text[:-1]))


# Who runs the jobs of a batch: processes of this machine, or dask workers on others.

SCRATCH = ".work"  # in the batch's folder, while it runs


@dataclass(frozen=True)
class Settings:
    """Settings of a batch run: time, memory, processes; none of them changes a result.

    workers    processes at a time at most; None for one per core
    seconds    that a design may take; None for any time
    memory     bytes that a design may take; None for its share of what is free, and all of that,
               by itself, where the share is not enough
    scheduler  of dask workers, as `cluster.scheduler_of` returns it; None for this machine
    tls        folder of certificates for it, as `cluster.security_of` reads it
    """

    workers: int | None = None
    seconds: float | None = 600.0
    memory: int | None = None
    scheduler: str | None = None
    tls: Path | None = None


Executor = Pool | Cluster


def executor_of(
    jobs: Sequence[Job], settings: Settings, function: str, out: Path, say: Callable[[str], None]
) -> Executor:
    """The executor that runs some jobs by a function "module:function".

    out  folder of the batch
    say  takes what the user should know
    """
    if settings.scheduler is not None:
        seconds, memory = settings.seconds, settings.memory
        return Cluster(settings.scheduler, function, seconds, memory, out, say, settings.tls)
    budget = planned_budget()
    estimate = max(FIRST_ESTIMATES.get(job.fidelity, FIRST_ESTIMATE) for job in jobs)
    if settings.memory is not None:
        estimate = min(estimate, settings.memory)
    most = min(settings.workers or _cores(), len(jobs))
    admission = Admission(budget, estimate)
    share = max(budget // admission.fitting(most), 1)
    limits = Limits(settings.seconds, settings.memory or share, settings.memory or budget)
    return Pool(function, most, limits, admission, out / SCRATCH)


def _cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


# The batch itself.


class Live(Protocol):
    """Receiver of a batch's progress."""

    def say(self, text: str) -> None:
        """Anything else that the user should know."""

    def kept(self, count: int, total: int, damaged: int) -> None:
        """So many jobs of all were done before; so many records of the journal were damaged."""

    def workers(self, count: int) -> None:
        """So many workers run beside each other; 0 if they are still to come."""

    def finished(self, outcome: Mapping[str, Any], timings: Mapping[str, float]) -> None:
        """A job has ended."""

    def running(self, steps: Callable[[], list[tuple[str, float, str]]]) -> None:
        """Some time has passed; `steps` gives name, seconds and step of what is being run."""


def run_batch(
    plan: Plan,
    out: Path,
    settings: Settings,
    live: Live,
    *,
    function: str = RUN,
    write: Write = os.write,
) -> list[dict[str, Any]]:
    """Run the jobs without a result, write the tables; returns all outcomes in the jobs' order.

    out        folder that `claim_folder` has made the batch's
    function   what a worker calls with a job's data, "module:function"
    write      how the journal's bytes reach the disk, as `os.write`

    Raises DesignError for a folder that takes no files, with all that is finished kept, and
    NumericsError where no worker starts. A KeyboardInterrupt leaves tables that say what has not
    been run.
    """
    outcomes: list[dict[str, Any] | None] = [None] * len(plan.jobs)
    timings: list[Mapping[str, float]] = [{} for _ in plan.jobs]
    try:
        with locked(out), Journal(out / "journal.jsonl", write) as journal:
            keys = [key_of(job) for job in plan.jobs]
            seen: dict[str, str | None] = {}
            for index, (job, key) in enumerate(zip(plan.jobs, keys, strict=True)):
                entry = journal.entries.get(key)
                if job.name in plan.refused:
                    outcomes[index] = ended(job, WRONG_INPUT, plan.refused[job.name], "")
                elif entry is not None and _still_holds(entry, job, out, seen):
                    outcomes[index], timings[index] = entry.outcome, entry.timings
            done = sum(outcome is not None for outcome in outcomes) - len(plan.refused)
            live.kept(done, len(plan.jobs), journal.damaged)
            tables = _Tables(plan, out)
            try:
                left = [index for index, outcome in enumerate(outcomes) if outcome is None]
                for finished in _run(plan, left, settings, live, function, out):
                    entries = [_entry(plan.jobs[f.index], keys[f.index], f, out) for f in finished]
                    journal.add(entries)
                    for f in finished:
                        for text in (f.outcome or {}).get("said", ()):
                            live.say(f"{plan.jobs[f.index].name}: {text}")
                    for f, entry in zip(finished, entries, strict=True):
                        outcomes[f.index], timings[f.index] = entry.outcome, entry.timings
                        live.finished(entry.outcome, entry.timings)
                    tables.now_and_then(outcomes, timings)
            except KeyboardInterrupt:
                tables.write(outcomes, timings, "the batch was stopped before")
                raise
            return tables.write(outcomes, timings, "")
    except OSError as error:
        raise folder_error(out, error) from error
    except PoolError as error:
        raise NumericsError(str(error), "batch", "try `ballesta check` on one design") from error


class _Tables:
    """Index and tables of a batch: at its end, and now and then while it runs."""

    def __init__(self, plan: Plan, out: Path) -> None:
        self._plan, self._out = plan, out
        self._next = monotonic() + _TABLES_EVERY

    def write(
        self,
        outcomes: Sequence[dict[str, Any] | None],
        timings: Sequence[Mapping[str, float]],
        why: str,
    ) -> list[dict[str, Any]]:
        """Write all outcomes, with the word `why` in place of those that there are not."""
        found = [
            ended(job, NOT_RUN, why, "") if outcome is None else outcome
            for job, outcome in zip(self._plan.jobs, outcomes, strict=True)
        ]
        write_results(self._plan, self._out, found, timings)
        return found

    def now_and_then(
        self, outcomes: Sequence[dict[str, Any] | None], timings: Sequence[Mapping[str, float]]
    ) -> None:
        """Write the outcomes so far where a minute has passed since the last time."""
        start = monotonic()
        if start >= self._next:
            self.write(outcomes, timings, "the batch has not come to it yet")
            end = monotonic()
            self._next = end + max(_TABLES_EVERY, _TABLES_SHARE * (end - start))


def _run(
    plan: Plan, left: Sequence[int], settings: Settings, live: Live, function: str, out: Path
) -> Iterator[list[Finished]]:
    if not left:
        return
    jobs = [plan.jobs[index] for index in left]
    with executor_of(jobs, settings, function, out, live.say) as executor:
        executor.start(len(jobs))
        live.workers(executor.at_a_time)
        prepare()
        for finished in executor.results(list(zip(left, map(asdict, jobs), strict=True))):
            yield finished
            live.running(lambda: _steps(plan, executor))


def _steps(plan: Plan, executor: Executor) -> list[tuple[str, float, str]]:
    """Name, seconds and step of every job that is being run."""
    return [(plan.jobs[i].name, s, step_of("\n".join(said))) for i, s, said in executor.running]


def key_of(job: Job) -> str:
    """Digest of everything that a job's result is made from, but the texts of its design's files.

    These stand in the journal as they were read: a design may be like others that nobody knows
    before reading it.
    """
    from checks.store.fingerprints import code_digest, digest, libraries

    # workers have one thread each, whatever this process may take
    # where results go changes none of them; one path may be two files from two folders
    told = replace(job, folder="", store=None, file=os.path.abspath(job.file))
    return digest(told, code_digest(), {**libraries(), "threads": "1"})


def _still_holds(entry: JournalEntry, job: Job, out: Path, seen: dict[str, str | None]) -> bool:
    """True if a finished job need not be done again.

    What was stopped by circumstances is tried again, and so is what cannot be read.
    """
    if entry.outcome["status"] in STOPPED or not entry.sources:
        return False
    if any(BY_THE_DAY in check["note"] for check in entry.outcome.get("checks", ())):
        return False
    here = os.path.realpath(out)
    known = {os.path.join(here, file): digest for file, digest in entry.sources.items()}
    if any(_text_digest(file, seen) != digest for file, digest in known.items()):
        return False
    folder = Path(job.folder)
    if not entry.result:
        return True
    try:
        written = sha256((folder / "result.json").read_bytes()).hexdigest()
    except OSError:
        return False
    return written == entry.result and (not job.reports or (folder / "report.html").is_file())


def _text_digest(file: str, seen: dict[str, str | None]) -> str | None:
    if file not in seen:
        seen[file] = text_digest(Path(file))
    return seen[file]


def _from(out: Path, file: str) -> str:
    """Path of a file from the batch's folder; as it is where no path leads there."""
    try:
        return os.path.relpath(file, os.path.realpath(out))
    except ValueError:  # another drive
        return file


def _entry(job: Job, key: str, finished: Finished, out: Path) -> JournalEntry:
    """The record of a job that has ended; raises what is not its design's fault."""
    outcome = finished.outcome
    if outcome is None:
        if finished.kind == "FolderError":
            raise DesignError(
                Path(job.folder), "--out", finished.error.partition("FolderError: ")[2]
                or finished.error,
            )  # fmt: skip
        error = "; ".join(filter(None, [finished.error, fatal_words(finished.said)]))
        outcome = ended(job, finished.status, error, step_of("\n".join(finished.said)))
    outcome = {key: value for key, value in outcome.items() if key != "said"}
    _refuse_other_code(outcome.pop("code", None), job)
    timings = {
        "seconds": outcome.pop("seconds", finished.seconds),
        "peak_memory_bytes": finished.peak,
        "attempts": finished.attempts,
    }
    assert set(timings) == set(TIMINGS)
    sources, result = outcome.pop("sources", {}), outcome.pop("result_sha256", "")
    sources = {_from(out, file): digest for file, digest in sources.items()}
    return JournalEntry(key, sources, result, outcome, timings)


def _refuse_other_code(code: str | None, job: Job) -> None:
    from checks.store.fingerprints import code_digest

    if code is not None and code != code_digest():
        raise NumericsError(
            "ballesta's own code was changed while the batch ran",
            job.name,
            "run the same command again",
        )


@contextmanager
def locked(out: Path) -> Iterator[None]:
    """Keep other batches out of a folder; raises DesignError when one is running there."""
    from filelock import FileLock, Timeout

    try:
        with FileLock(out / "batch.lock", blocking=False):
            yield
    except Timeout:
        raise DesignError(out, "--out", "another batch is running in this folder") from None
