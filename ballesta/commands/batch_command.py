"""`ballesta batch`: many designs and their variations, side by side, resumed if killed."""

import json
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any

from ballesta.batches.cluster import LOCAL, scheduler_of, security_of
from ballesta.batches.job import EXIT_CODES, sentence
from ballesta.batches.plan import Request, claim_folder, design_files, planned
from ballesta.batches.processes import parse_memory
from ballesta.batches.run import Settings, run_batch
from ballesta.design.read import read_design
from ballesta.run import guarded, output_folders, store_at, told_of_folder
from ballesta.supervisor import STOPPED, terminated_as_interrupted
from ballesta.sweeps.sweep import parse_sweep
from ballesta.sweeps.threshold_search import UntilResult, until_pass, until_text
from checks.design.effort import SWEPT, Effort, effort_of
from checks.design.errors import DesignError, listed
from checks.design.units import measure
from checks.result.verdict import DesignResult
from checks.result.words import brief, clean
from checks.store.store import Store, keep_result, recalled_result
from geometry.progress import step
from reports.files import plain, write_whole

_HERE = Path("command line")


@dataclass(frozen=True)
class Wanted:
    """The options of the command, as they were written.

    until    "pass", or "pass of PART, PART" to judge only these: a search in place of a batch
    reports  None: for batches of up to `plan.REPORTS_UP_TO` designs
    store    None: the folder `store` of the batch
    """

    out: Path
    jobs: int | None = None
    sweeps: tuple[str, ...] = ()
    sample: int | None = None
    seed: int = 0
    until: str | None = None
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
    if wanted.until is not None:
        return run_until(designs, wanted)

    def work() -> int:
        with terminated_as_interrupted():
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
    effort_of(wanted.fidelity, wanted.within, of_batch=True)  # raises what is wrong with them
    if wanted.fidelity == SWEPT and wanted.reports:
        raise DesignError(_HERE, "--reports", f"is not for --fidelity {SWEPT}: check one design")
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


# Progress of a batch: a line per finished design, and a bar on a terminal.

Steps = Callable[[], list[tuple[str, float, str]]]
_SHOW_EVERY = 0.5  # s


class Lines:
    """Lines of plain text: finished designs on standard output, the rest on standard error."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.done = self.total = 0

    def kept(self, count: int, total: int, damaged: int) -> None:
        """Tell what was done before."""
        self.done, self.total = count, total
        if damaged:
            records = "1 record" if damaged == 1 else f"{damaged} records"
            self.say(f"{records} of the journal damaged: these designs are checked again")
        if count:
            self.say(f"{count} of {total} designs are done already, with the same inputs and code")

    def workers(self, count: int) -> None:
        """Tell how many run beside each other."""
        workers = f"{count} at a time" if count else "waiting for workers"
        self.say(f"{self.total - self.done} designs to check, {workers}")

    def finished(self, outcome: Mapping[str, Any], timings: Mapping[str, float]) -> None:
        """Tell of a finished design."""
        self.done += 1
        self.counts[outcome["status"]] += 1
        width = len(str(self.total))
        print(
            f"[{self.done:{width}d}/{self.total}] {brief(outcome['name'], 50)}  "
            f"{outcome['status']}  {sentence(outcome)}  {timings['seconds']:.1f} s",
            flush=True,
        )

    def running(self, steps: Steps) -> None:
        """Lines tell of what is finished only."""

    def say(self, text: str) -> None:
        """Tell anything else."""
        print(f"ballesta: {clean(text)}", file=sys.stderr, flush=True)


class ProgressBar(Lines):
    """The same with a bar below the lines: how much is done, what runs, how long it will take."""

    def __init__(self, progress: Any) -> None:
        super().__init__()
        self._progress, self._shown, self._begun = progress, 0.0, monotonic()
        self._task = progress.add_task("", total=None, found="", step="", left="")

    def kept(self, count: int, total: int, damaged: int) -> None:
        """Tell what was done before."""
        super().kept(count, total, damaged)
        self._progress.update(self._task, total=total, completed=count)

    def finished(self, outcome: Mapping[str, Any], timings: Mapping[str, float]) -> None:
        """Tell of a finished design."""
        super().finished(outcome, timings)
        found = ", ".join(f"{self.counts[s]} {s}" for s in EXIT_CODES if self.counts[s])
        left = f"about {self._left()} left,"
        self._progress.update(self._task, completed=self.done, found=found, left=left)

    def _left(self) -> str:
        """Time that the rest takes if it goes on as since the start."""
        checked = sum(self.counts.values())
        seconds = (monotonic() - self._begun) / checked * (self.total - self.done)
        if seconds < 90:
            return f"{seconds:.0f} s"
        return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"

    def running(self, steps: Steps) -> None:
        """Show what is being run."""
        if monotonic() - self._shown < _SHOW_EVERY:
            return
        self._shown = monotonic()
        texts = [
            f"{brief(name, 24)} {seconds:.0f} s {brief(step, 28)}"
            for name, seconds, step in steps()
        ]
        self._progress.update(self._task, step=" | ".join(texts)[:120])


@contextmanager
def live() -> Iterator[Lines]:
    """Yield a display of the progress, with a bar where standard error is a terminal."""
    if not sys.stderr.isatty():
        yield Lines()
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
        TextColumn("{task.fields[left]}", markup=False),
        TextColumn("{task.fields[found]}", markup=False),
        TextColumn("{task.fields[step]}", markup=False),
    )  # fmt: skip
    terminal = sys.stdout.isatty()
    with Progress(
        *columns, console=Console(stderr=True), transient=True, redirect_stdout=terminal
    ) as bar:
        yield ProgressBar(bar)


# `ballesta batch --sweep ... --until pass`: searches of designs, one after the other.
# Whatever is checked is kept in the store of the output folder, so that a search that was killed
# goes on where it was, and a wider one begins with what is known.
_OF_A_BATCH = ("sample", "jobs", "time_limit", "memory", "reports", "no_store", "executor", "tls")


def run_until(designs: Sequence[Path], wanted: Wanted) -> int:
    """Search every design, print the threshold and write OUT/DESIGN/until.json.

    Returns the highest exit code: 0 a value passes, 1 none does, 2 an input is wrong, 3 the
    numerics gave up.
    """

    def every() -> int:
        parts = parts_of(wanted.until or "pass")
        if len(wanted.sweeps) != 1:
            raise DesignError(_HERE, "--until", f"needs one --sweep, got {len(wanted.sweeps)}")
        given = [name for name in _OF_A_BATCH if getattr(wanted, name) != getattr(Wanted, name)]
        if given:
            options = listed([f"--{name.replace('_', '-')}" for name in given])
            told = f"searches by itself, one check after the other: leave out {options}"
            raise DesignError(_HERE, "--until", told)
        accuracy = () if wanted.accuracy is None else (f"accuracy={wanted.accuracy}",)
        overrides = (*wanted.overrides, *accuracy)
        effort = effort_of(wanted.fidelity, wanted.within)
        files, _ = design_files([str(path) for path in designs])
        store = store_at(wanted.store or wanted.out / "store")
        folders = output_folders(files, wanted.out)

        def one(file: Path, folder: Path) -> int:
            with told_of_folder(wanted.out):
                folder.mkdir(parents=True, exist_ok=True)
            before = read_design(file, overrides).sources
            result = until_pass(
                file,
                wanted.sweeps[0],
                overrides,
                parts=parts,
                effort=effort,
                check=stored_check(file, store),
                say=lambda text: step(f"{file.stem}: {text}"),
            )
            if read_design(file, overrides).sources != before:
                raise DesignError(file, "--until", "was edited during the search: search again")
            _write(result, folder / "until.json", wanted.out)
            print(until_text(result), end="", flush=True)
            return result.exit_code

        codes = [
            guarded(lambda file=file, folder=folder: one(file, folder))  # type: ignore[misc]
            for file, folder in zip(files, folders, strict=True)
        ]
        return max(codes, default=0)

    return guarded(every)


def parts_of(until: str) -> tuple[str, ...]:
    """Return the parts that are judged; none for all of them. Raises DesignError.

    >>> parts_of("pass of bar_upper, bar_lower"), parts_of("pass")
    (('bar_upper', 'bar_lower'), ())
    """
    word, of, names = until.strip().partition(" of ")
    parts = tuple(name.strip() for name in names.split(",")) if of else ()
    if word.strip() != "pass" or not all(parts):
        raise DesignError(
            _HERE, "--until", f'must be pass, or such as "pass of bar_upper", got "{until}"'
        )
    return parts


def stored_check(
    file: Path, store: Store | None
) -> Callable[[tuple[str, ...], Effort], DesignResult]:
    """Return a check of a design with overrides that computes nothing twice."""
    from ballesta.pipeline import check_design

    def check(overrides: tuple[str, ...], effort: Effort) -> DesignResult:
        kept = recalled_result(store, file, overrides, effort)
        if kept is not None:
            return kept.result
        design = read_design(file, overrides)
        result = check_design(design, effort=effort, store=store)
        keep_result(store, design, effort, result, {})
        return result

    return check


def _write(result: UntilResult, path: Path, out: Path) -> None:
    text = json.dumps(plain(result.to_dict()), indent=1, allow_nan=False, ensure_ascii=False)
    with told_of_folder(out):
        write_whole(path, f"{text}\n".encode())
