"""Stills, drawn by a process of its own: VTK kills it where GL is missing."""

import atexit
import json
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp
from typing import Any

import numpy as np

from checks.result.verdict import DesignResult, PartResult, Surface
from checks.result.words import clean
from geometry.graphics import INSTALL
from reports.worker import AHEAD, StandingWorker
from reports.worker import ESTIMATE as ESTIMATE
from reports.worker import PLAIN as PLAIN

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


def draw_ahead(part: PartResult, worker: Sequence[str] = _WORKER) -> None:
    """Have the process draw the stills of a part before the whole result is there.

    They are not drawn again for it.
    """
    folder = Path(mkdtemp(prefix="ballesta-"))
    _ahead.append(folder)
    _asked([part], folder)
    (folder / AHEAD).touch()
    _standing(worker).hand(folder)


@contextmanager
def drawing(result: DesignResult) -> Iterator[Callable[[], Pictures]]:
    """Have a process draw the stills of a result beside other work.

    Yields what waits for them.
    """
    with _drawing(result.parts, _LONGEST, _WORKER) as pictures:
        yield pictures


def render_stills(
    parts: Sequence[PartResult], timeout: float = _LONGEST, worker: Sequence[str] = _WORKER
) -> Pictures:
    """Stills of each part: all of it, the surroundings of its peak stress, its buckling mode.

    A part that was not meshed is drawn once: by its utilisation as its section forces estimate it,
    in grey where that is not known. Surfaces that are alike are drawn once.

    One process draws them all, for at most `timeout` seconds of waiting. Its failure is a reason in
    the result, never an exception, and what it had drawn until then is kept.
    """
    with _drawing(parts, timeout, worker) as pictures:
        return pictures()


@contextmanager
def _drawing(
    parts: Sequence[PartResult], timeout: float, worker: Sequence[str]
) -> Iterator[Callable[[], Pictures]]:
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
    from reports.live.payload import estimate_of  # else it is loaded beside the check

    views = (PLAIN,) if part.surface.is_bare else VIEWS
    estimate = estimate_of(part)
    shown: list[tuple[Surface, Sequence[str]]] = [
        (part.surface, views) if estimate is None else (estimate, (ESTIMATE,))
    ]
    return shown if part.mode is None else [*shown, (part.mode, (MODE,))]


def _collected(folder: Path, index: int, views: Sequence[str]) -> dict[str, bytes]:
    files = {view: folder / f"part_{index}_{view}.png" for view in views}
    return {view: file.read_bytes() for view, file in files.items() if file.is_file()}
