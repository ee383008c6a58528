"""Who runs the jobs of a batch: processes of this machine, or dask workers on others."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, Self

from ballesta.batches.cluster import Cluster
from ballesta.batches.memory import FIRST_ESTIMATE, FIRST_ESTIMATES, Admission, planned_budget
from ballesta.batches.outcome import Job
from ballesta.batches.pool import Finished, Limits, Pool

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


class Executor(Protocol):
    """Runs jobs; `Pool` and `Cluster` do."""

    def __enter__(self) -> Self:
        """Nothing happens yet."""

    def __exit__(self, *_: object) -> None:
        """Stop whatever is being run."""

    def start(self, jobs: int) -> None:
        """Make ready for so many jobs ahead of `results`."""

    @property
    def at_a_time(self) -> int:
        """Number of jobs that run beside each other, as estimated so far."""

    def results(self, jobs: Sequence[tuple[int, Mapping[str, Any]]]) -> Iterator[list[Finished]]:
        """Run jobs, (place, data as JSON knows it); yields those that ended since the last time.

        Also yields an empty list many times a second, for who shows progress.
        """

    @property
    def running(self) -> list[tuple[int, float, Sequence[str]]]:
        """Place, seconds and last words of the jobs that are being run, as far as known."""


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
