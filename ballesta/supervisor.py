"""Long commands are run by a child, so that Ctrl-C, a time limit and progress never wait for one.

The child (`run` of ballesta/__main__.py) is the same command line in another interpreter. It hands
over what it has finished; when it is ended, another one writes the report of that. This process
imports nothing that takes time. Either has its standard output for itself.
"""

import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from math import inf
from time import monotonic, process_time

from geometry.progress import Child, Order, signal_name

STOPPED, GAVE_UP = 130, 3  # exit codes: of an interrupt as shells report it; of numerics
_CHILD = "ballesta.__main__:run"  # its function
_LONG = frozenset(("check", "loads", "diff", "why", "show", "plan", "export"))
_LOOK_EVERY = 0.1  # s
_TELL_EVERY = 5.0  # s, where progress is lines
_GRACE = 2.0  # s after a time limit, in which the command has ended
# Processor time, s, of writing the report of what is finished without pictures: in any case, and
# for each part; and of the imports for it (the press on a core of 2.5 GHz: 2.3 s, 1.5 s).
_REPORT, _REPORT_OF_A_PART, _READY = 1.2, 0.5, 2.0
_WIDTH = 100  # characters of a line of progress


def is_long(argv: Sequence[str]) -> bool:
    """True for a command line that may take long."""
    if not argv or "--help" in argv:
        return False
    searches = any(word.split("=")[0] == "--until" for word in argv)
    return argv[0] in _LONG or (argv[0] == "batch" and searches)


def supervise(argv: Sequence[str]) -> int:
    """Run a command line in a child; returns its exit code.

    130 after an interrupt or SIGTERM, once what was finished is written and told; a second one ends
    that, too.
    """
    with terminated_as_interrupted():
        run = _Run(argv)
        try:
            return run.to_its_end()
        except KeyboardInterrupt:
            return run.stopped()
        finally:
            run.kill()


class _Run:
    """A command line on its way."""

    def __init__(self, argv: Sequence[str]) -> None:
        self._argv, self._progress = argv, _progress()
        self._began = monotonic() - process_time()  # the interpreter's start counts
        self._kept: dict[str, bytes] = {}
        self._within: float | None = None
        self._deadline = inf
        self._spare: Child | None = None
        self._child, self._since = Child(_CHILD), monotonic()
        self._child.send(Order(argv, self._began))

    def to_its_end(self) -> int:
        """Wait for the end; past a time limit another child tells what was finished."""
        while True:
            code = self._watched()
            if code is None:
                self._go_on(f"the time is up (--within {self._within:g}s)", stop=False)
                continue
            self._progress.clear()
            if code >= 0:
                return code
            _say(f"the process was killed by signal {signal_name(-code)}{_likely(-code)}")
            if not self._told():
                return GAVE_UP
            self._go_on(f"the process was killed by signal {signal_name(-code)}", stop=True)
            self._watched()
            return GAVE_UP

    def stopped(self) -> int:
        """Tell what is finished after an interrupt."""
        self._child.kill()
        text = self._progress.text
        self._progress.clear()
        try:
            if self._told():
                _say("stopped; writing what is finished (again to leave it)")
                self._deadline = inf
                self._go_on("stopped by the user", stop=True)
                self._watched()
            else:
                at = f" at: {text}" if text else ""
                _say(f"stopped{at}; nothing of it was finished")
        except KeyboardInterrupt:
            _say("stopped; what was finished is not written")
        return STOPPED

    def _told(self) -> bool:
        """True if a finished part or result was kept for a successor to report."""
        return any(name.startswith(("part ", "done")) for name in self._kept)

    def kill(self) -> None:
        """End what still runs."""
        self._progress.clear()
        for child in (self._child, self._spare):
            if child is not None:
                child.kill()

    def _go_on(self, why: str, *, stop: bool) -> None:
        """Have another child go on with what the last one has handed over."""
        self._child.kill()
        self._child, self._spare = self._spare or Child(_CHILD), None
        self._child.send(Order(self._argv, self._began, self._kept, why, stop))
        self._kept, self._deadline, self._since = {}, inf, monotonic()

    def _watched(self) -> int | None:
        """Exit code of the child when it ends; None when its time is up before."""
        while True:
            messages = self._child.messages(_LOOK_EVERY)
            if messages is None:
                return self._child.ended()
            for kind, *said in messages:
                getattr(self, f"_{kind}")(*said)
            left = self._time_left()
            if left < _READY * self._slowness() and self._spare is None:
                self._spare = Child(_CHILD)
                self._spare.send(None)
            if left < 0:
                return None
            self._progress.show()

    def _time_left(self) -> float:
        """Time that the child has until the report of what is finished must be begun, s."""
        if self._deadline == inf:
            return inf
        parts = sum(name.startswith("part ") for name in self._kept)
        report = _REPORT + _REPORT_OF_A_PART * parts
        return self._deadline - monotonic() - self._slowness() * report

    def _slowness(self) -> float:
        """Ratio of clock time to processor time of the work."""
        if self._deadline == inf:
            return 1.0
        return max(1.0, (monotonic() - self._since) / max(self._child.processor_seconds(), 0.1))

    # what a child sends

    def _step(self, name: str, text: str) -> None:
        self._progress.step(name, text)

    def _expect(self, text: str, seconds: float) -> None:
        self._progress.expect(text, seconds)

    def _keep(self, name: str, value: bytes) -> None:
        self._kept[name] = value

    def _forget(self, prefix: str) -> None:
        self._kept = {k: v for k, v in self._kept.items() if not k.startswith(prefix)}

    def _clear(self) -> None:
        self._progress.clear()
        self._child.send(None)

    def _limit(self, seconds: float | None, since: float) -> None:
        self._within = seconds
        if seconds is None:
            self._deadline = inf
        else:
            self._deadline = since + seconds + _GRACE


class _Lines:
    """Progress as a line per step, and one every few seconds of a long one."""

    text = ""

    def __init__(self) -> None:
        self._name, self._began = "", monotonic()
        self._since = self._told = self._began
        self._expected = ("", 0.0)

    def step(self, name: str, text: str) -> None:
        """Begin another step."""
        if name != self._name:
            self._name, self._began = name, monotonic()
        self.text, self._expected = text, ("", 0.0)
        self._since = self._told = monotonic()
        self._line(text)

    def expect(self, text: str, seconds: float) -> None:
        """Begin something inside of a step that takes about so long, s."""
        self._expected, self._since = (text, seconds), monotonic()

    def show(self) -> None:
        """Tell how long a step has taken."""
        if self.text and monotonic() - self._told > _TELL_EVERY:
            self._told = monotonic()
            self._line(self._words())

    def clear(self) -> None:
        """Leave the terminal as it was."""
        self.text = ""

    def _words(self) -> str:
        inside, seconds = self._expected
        so_far = f"{monotonic() - self._since:.0f} s"
        told = f"{self.text}: {inside}" if inside else self.text
        return f"{told}, {so_far} of about {seconds:.0f} s" if seconds >= 1 else f"{told}, {so_far}"

    def _line(self, text: str) -> None:
        passed = f"{monotonic() - self._began:6.1f} s  " if self._name else ""
        print(f"{self._name} {passed}{text}".lstrip(), file=sys.stderr, flush=True)


class _OneLine(_Lines):
    """Progress on one line of a terminal that is written again and again."""

    def show(self) -> None:
        if self.text and monotonic() - self._told > _LOOK_EVERY:
            self._told = monotonic()
            self._line(self._words())

    def clear(self) -> None:
        super().clear()
        print("\r\x1b[K", end="", file=sys.stderr, flush=True)

    def _line(self, text: str) -> None:
        passed = f"{monotonic() - self._began:.0f} s  "
        line = f"{self._name} {passed}{text}".lstrip()[:_WIDTH]
        print(f"\r\x1b[K{line}", end="", file=sys.stderr, flush=True)


def _progress() -> _Lines:
    return _OneLine() if sys.stderr.isatty() else _Lines()


def _say(text: str) -> None:
    print(f"ballesta: {text}", file=sys.stderr, flush=True)


def _likely(number: int) -> str:
    """Likely cause of a signal from the system."""
    if signal_name(number) == "SIGKILL":
        return ": likely for want of memory; lower mesh.fineness or mesh.most_unknowns"
    return ": a library crashed on this input"


@contextmanager
def terminated_as_interrupted() -> Iterator[None]:
    """Let SIGTERM, which queues and `timeout` send before they kill, stop as an interrupt does."""

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


# Standard output and standard error of the program.


def claim_standard_output() -> None:
    """Leave standard output to this program: what libraries print there goes to standard error.

    Tetgen inside gmsh tells of intersecting facets by C's printf, in front of what `--json` prints.
    """
    stream = sys.stdout
    if stream is not sys.__stdout__ or not isinstance(stream, TextIOWrapper):
        return
    stream.flush()
    own = os.dup(1)
    with suppress(OSError):  # there is no standard error: all stays as it is
        os.dup2(2, 1)
        sys.stdout = os.fdopen(own, "w", encoding=stream.encoding, errors=stream.errors)
        sys.__stdout__ = sys.stdout  # type: ignore[misc]  # it tells how wide the terminal is


def finish_standard_output() -> None:
    """Hand over what is printed; a reader that has seen enough, such as `head`, is no error."""
    stream = sys.__stdout__  # sys.stdout may be one that typer has put before it
    if stream is None:
        return
    try:
        stream.flush()
    except BrokenPipeError:  # the interpreter would flush once more at its end, and complain
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def speak_utf8() -> None:
    """Write UTF-8 into files and pipes: Windows' code pages have no minus sign and no sigma."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper) and stream.encoding.lower() != "utf-8":
            stream.reconfigure(encoding="utf-8")
