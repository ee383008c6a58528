"""`ballesta batch`: many designs and their variations, side by side, resumed if killed."""

import signal
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ballesta.batches.cluster import LOCAL, scheduler_of, security_of
from ballesta.batches.executor import Settings
from ballesta.batches.live import live
from ballesta.batches.memory import parse_memory
from ballesta.batches.outcome import EXIT_CODES
from ballesta.batches.plan import Request, claim_folder, planned
from ballesta.batches.run import run_batch
from ballesta.run import guarded
from ballesta.sweeps.sweep_text import parse_sweep
from checks.design.effort import effort_of
from checks.design.errors import DesignError
from checks.design.units import measure

STOPPED = 130  # as shells report an interrupt
_HERE = Path("command line")


@dataclass(frozen=True)
class Wanted:
    """The options of the command, as they were written.

    reports  None: for batches of up to `plan.REPORTS_UP_TO` designs
    store    None: the folder `store` of the batch
    """

    out: Path
    jobs: int | None = None
    sweeps: tuple[str, ...] = ()
    sample: int | None = None
    seed: int = 0
    fidelity: str = "auto"
    within: str | None = None
    accuracy: str | None = None
    time_limit: str = "600s"
    memory: str | None = None
    overrides: tuple[str, ...] = ()
    reports: bool | None = None
    store: Path | None = None
    no_store: bool = False
    executor: str = LOCAL
    tls: Path | None = None


def run_batch_command(designs: Sequence[Path], wanted: Wanted) -> int:
    """Run a batch and tell of it; returns the highest exit code of its designs.

    130 when it is stopped by an interrupt or SIGTERM.
    """

    def work() -> int:
        with _terminated_as_interrupted():
            outcomes = outcomes_of(designs, wanted)
        print(summary(outcomes, wanted.out))
        return max((outcome["exit_code"] for outcome in outcomes), default=0)

    try:
        return guarded(work)
    except KeyboardInterrupt:
        print(
            f"ballesta: stopped; what is finished is in {wanted.out}, "
            "the same command goes on from there",
            file=sys.stderr,
        )
        return STOPPED


def outcomes_of(designs: Sequence[Path], wanted: Wanted) -> list[dict[str, Any]]:
    """Run a batch with its progress on the terminal; returns the outcomes in the jobs' order.

    Raises DesignError for a wrong option, a sweep that no design can take, or a folder that is
    another batch's or takes no files; NumericsError where no worker starts.
    """
    request, settings = _request(designs, wanted), _settings(wanted)
    store = None if wanted.no_store else wanted.store or wanted.out / "store"
    plan = planned(request, wanted.out, wanted.reports, store)
    claim_folder(wanted.out, request)
    with live() as told:
        for note in dict.fromkeys(plan.notes.values()):
            told.say(f"{', '.join(n for n in plan.notes if plan.notes[n] == note)}: {note}")
        return run_batch(plan, wanted.out, settings, told)


def summary(outcomes: Sequence[Mapping[str, Any]], out: Path) -> str:
    """Count of each status of a batch, and the folder of its tables."""
    counts = Counter(outcome["status"] for outcome in outcomes)
    found = ", ".join(f"{counts[status]} {status}" for status in EXIT_CODES if counts[status])
    many = "1 design" if len(outcomes) == 1 else f"{len(outcomes)} designs"
    return f"{many}: {found}\nindex: {out / 'index.html'}; tables: results.csv, results.parquet"


def _request(designs: Sequence[Path], wanted: Wanted) -> Request:
    effort_of(wanted.fidelity, wanted.within)  # raises what is wrong with them
    if wanted.sample is not None and not wanted.sweeps:
        raise DesignError(_HERE, "--sample", "needs a --sweep to take samples from")
    swept = {key for text in wanted.sweeps for key in parse_sweep(text).keys}
    if wanted.accuracy is not None and "accuracy" in swept:
        raise DesignError(_HERE, "--accuracy", "is swept, too: leave out one of the two")
    return Request(
        tuple(str(path) for path in designs),
        wanted.overrides,
        wanted.sweeps,
        wanted.sample,
        wanted.seed,
        wanted.fidelity,
        wanted.within,
        wanted.accuracy,
    )


def _settings(wanted: Wanted) -> Settings:
    if wanted.jobs is not None and wanted.jobs < 1:
        raise DesignError(_HERE, "--jobs", f"must be at least 1, got {wanted.jobs}")
    scheduler = scheduler_of(wanted.executor)
    if scheduler is not None and wanted.jobs is not None:
        raise DesignError(_HERE, "--jobs", "is for --executor local: a cluster has its own workers")
    if wanted.tls is not None:
        if scheduler is None or not scheduler.startswith("tls://"):
            raise DesignError(_HERE, "--tls", "is for --executor tls://HOST:PORT")
        security_of(wanted.tls)
    seconds, memory = _time_limit(wanted.time_limit), _memory(wanted.memory)
    return Settings(wanted.jobs, seconds, memory, scheduler, wanted.tls)


def _time_limit(text: str) -> float | None:
    if text.strip() == "none":
        return None
    try:
        seconds = measure(text, "time").value
    except ValueError as error:
        raise DesignError(_HERE, "--time-limit", f"{error}; or none") from error
    if not seconds > 0:
        raise DesignError(_HERE, "--time-limit", f'must be above 0 s, got "{text}"')
    return seconds


def _memory(text: str | None) -> int | None:
    try:
        return None if text is None else parse_memory(text)
    except ValueError as error:
        raise DesignError(_HERE, "--memory", str(error)) from error


@contextmanager
def _terminated_as_interrupted() -> Iterator[None]:
    """Let SIGTERM, which queues send before they kill, stop a batch as an interrupt does."""

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    try:
        before = signal.signal(signal.SIGTERM, stop)
    except ValueError:  # only the main thread may
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
