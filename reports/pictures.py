"""Stills, drawn by a process of its own: VTK kills it where GL is missing."""

import atexit
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile, gettempdir, mkdtemp
from threading import Condition, Thread
from typing import IO, Any

import numpy as np

from checks.result.verdict import PartResult, Surface
from checks.result.words import clean
from fem.threads import ONE_THREAD
from geometry import INSTALL
from geometry.progress import signal_name
from reports.plain_still import AHEAD, ESTIMATE, PLAIN


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
    return environment if window else environment | without_display()


def without_display() -> dict[str, str]:
    """Settings with which VTK draws where there is no display."""
    if not sys.platform.startswith("linux") or os.environ.get("DISPLAY"):
        return {}
    return {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}


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
    name = signal_name(-code if code < 0 else code - 128)
    return f"exit code {code}" + (f", signal {name}" if name.startswith("SIG") else "")


VIEWS = ("whole", "peak")
MODE = "mode"
_WORKER = (sys.executable, "-P", "-m", "reports.pictures_worker")
_LONGEST = 180.0  # s, to draw the stills of a design


@dataclass(frozen=True, eq=False)
class Pictures:
    """Pictures that could be drawn, and why the rest could not.

    images  part name -> view ("whole", "peak", and "mode" where one was found; of a part that
            was not meshed "estimate" alone, or "plain" where none is known) -> PNG
    reason  what went wrong and its cure; "" when everything was drawn
    """

    images: Mapping[str, Mapping[str, bytes]] = field(default_factory=dict)
    reason: str = ""


def prepare_drawing(worker: Sequence[str] = _WORKER, *, stress: bool = True) -> None:
    """Start the process that draws, so that it loads its libraries beside other work.

    stress  True if stills of stress are likely, which need graphics libraries

    It draws for every design that this process checks, and ends with it.
    """
    process = _standing(worker)
    if stress:
        process.prepare()


_ahead: list[Path] = []  # removed by the process that draws, or at our end


def draw_ahead(part: PartResult) -> None:
    """Have the process draw the stills of a part before the whole result is there.

    They are not drawn again for it.
    """
    folder = Path(mkdtemp(prefix="ballesta-"))
    _ahead.append(folder)
    _asked([part], folder)
    (folder / AHEAD).touch()
    _standing(_WORKER).hand(folder)


@contextmanager
def drawing(
    parts: Sequence[PartResult], timeout: float = _LONGEST, worker: Sequence[str] = _WORKER
) -> Iterator[Callable[[], Pictures]]:
    """Have a process draw stills of each part beside other work; yields what waits for them.

    A part that was not meshed is drawn once: by its utilisation as its section forces estimate it,
    in grey where that is not known. Others are drawn whole, around their peak stress and in their
    buckling mode. Surfaces that are alike are drawn once.

    One process draws them all, for at most `timeout` seconds of waiting. Its failure is a reason in
    the result, never an exception, and what it had drawn until then is kept.
    """
    if not parts:
        yield Pictures
        return
    with TemporaryDirectory(prefix="ballesta-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        views = _asked(parts, folder)
        process = _standing(worker)
        process.hand(folder)

        @cache
        def drawn() -> Pictures:
            ended = process.answer(folder, timeout)
            if ended.code != 0 or not process.runs:
                _end(worker)
            images: dict[str, dict[str, bytes]] = {part.name: {} for part in parts}
            for part, job, shown in views:
                images[part] |= _collected(folder, job, shown)
            asked = sum(len(shown) for _, _, shown in views)
            missing = asked - sum(len(made) for made in images.values())
            if missing == 0 and not ended.words:
                return Pictures(images)
            problem = ended.words or "the worker ended well but left pictures out"
            lack = f"{missing} of {asked} pictures are missing"
            cure = f"Where GL libraries are missing: {INSTALL}"
            return Pictures(images, f"{lack}: {problem}. {cure}")

        try:
            yield drawn
        finally:
            if not drawn.cache_info().currsize:
                _end(worker)  # it would miss the folder that goes now


_running: dict[tuple[str, ...], StandingWorker] = {}


def _standing(command: Sequence[str]) -> StandingWorker:
    """The process of a command, started unless it runs."""
    key = tuple(command)
    if key not in _running or not _running[key].runs:
        _end(command)
        _running[key] = StandingWorker(command)
    return _running[key]


def _end(command: Sequence[str]) -> None:
    """End the process of a command, if there is one."""
    process = _running.pop(tuple(command), None)
    if process is not None:
        process.end()


@atexit.register
def _end_all() -> None:
    for command in list(_running):
        _end(command)
    for folder in _ahead:
        shutil.rmtree(folder, ignore_errors=True)


def _asked(parts: Sequence[PartResult], folder: Path) -> list[tuple[str, int, Sequence[str]]]:
    """Write what is to be drawn; returns name of the part, number of the job, its views."""
    jobs: list[dict[str, Any]] = []
    asked: list[tuple[str, int, Sequence[str]]] = []
    alike: dict[str, int] = {}
    for part in parts:
        for surface, views in _shown(part):
            name = stress_field(surface)
            data: dict[str, Any] = {
                "nodes": np.asarray(surface.nodes, dtype=float),
                "triangles": np.asarray(surface.triangles, dtype=np.int64),
                "values": np.asarray(surface.fields[name], dtype=float),
                "peak": np.asarray(surface.peak, dtype=np.int64),
            }
            job = {"field": clean(name), "views": list(views)}
            digest = sha256(json.dumps(job).encode())
            for array in data.values():
                digest.update(f"{array.shape}".encode() + array.tobytes())
            number = alike.setdefault(digest.hexdigest(), len(jobs))
            if number == len(jobs):
                jobs.append(job)
                np.savez(folder / f"part_{number}.npz", **data)
            asked.append((part.name, number, views))
    (folder / "jobs.json").write_text(json.dumps(jobs), encoding="utf-8")
    return asked


def stress_field(surface: Surface) -> str:
    """Name of the field that is drawn: the von Mises stress, else the first there is."""
    names = list(surface.fields)
    if not names:
        raise ValueError("a surface without fields cannot be drawn")
    return next((name for name in names if name.startswith("von Mises")), names[0])


def _shown(part: PartResult) -> list[tuple[Surface, Sequence[str]]]:
    """Surfaces of a part, and the views of each."""
    from reports.live.section import estimate_of  # else it is loaded beside the check

    views = (PLAIN,) if part.surface.is_bare else VIEWS
    estimate = estimate_of(part)
    shown: list[tuple[Surface, Sequence[str]]] = [
        (part.surface, views) if estimate is None else (estimate, (ESTIMATE,))
    ]
    return shown if part.mode is None else [*shown, (part.mode, (MODE,))]


def _collected(folder: Path, index: int, views: Sequence[str]) -> dict[str, bytes]:
    files = {view: folder / f"part_{index}_{view}.png" for view in views}
    return {view: file.read_bytes() for view, file in files.items() if file.is_file()}
