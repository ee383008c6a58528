"""Progress of a batch: a line per finished design, and a bar on a terminal."""

import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from time import monotonic
from typing import Any

from ballesta.batches.outcome import EXIT_CODES, sentence
from checks.result.words import brief, clean

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
