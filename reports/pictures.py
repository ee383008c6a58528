"""Stills of the parts, drawn by a process of its own: VTK kills it where GL is missing."""

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from geometry.graphics import INSTALL
from reports.pictures_worker import PLAIN as PLAIN
from reports.verdict import PartResult, Surface
from reports.words import clean
from reports.worker import run_worker

VIEWS = ("whole", "peak")
MODE = "mode"
_WORKER = (sys.executable, "-m", "reports.pictures_worker")


@dataclass(frozen=True, eq=False)
class Pictures:
    """What could be drawn, and why the rest could not.

    images  part name -> view ("whole", "peak", and "mode" where one was found; "plain" alone of a
            part that was not meshed) -> PNG
    reason  what went wrong and its cure; "" when everything was drawn
    """

    images: Mapping[str, Mapping[str, bytes]] = field(default_factory=dict)
    reason: str = ""


def render_stills(
    parts: Sequence[PartResult], timeout: float = 180.0, worker: Sequence[str] = _WORKER
) -> Pictures:
    """Stills of each part: all of it, the surroundings of its peak stress, its buckling mode.

    A part that was not meshed is drawn once and in grey: there is no stress on it to show.

    One worker process draws them all, for at most `timeout` seconds. Its failure is a reason in
    the result, never an exception, and what it had drawn until then is kept.
    """
    if not parts:
        return Pictures()
    with TemporaryDirectory(prefix="ballesta-") as name:
        folder = Path(name)
        jobs: list[dict[str, Any]] = []
        for index, part in enumerate(parts):
            for surface, views in _shown(part):
                field_name = stress_field(surface)
                np.savez(
                    folder / f"part_{len(jobs)}.npz",
                    nodes=np.asarray(surface.nodes, dtype=float),
                    triangles=np.asarray(surface.triangles, dtype=np.int64),
                    values=np.asarray(surface.fields[field_name], dtype=float),
                    peak=np.int64(surface.peak),
                )
                jobs.append({"field": clean(field_name), "views": list(views), "part": index})
        (folder / "jobs.json").write_text(json.dumps(jobs), encoding="utf-8")
        problem = run_worker([*worker, name], folder, timeout).words
        images: dict[str, dict[str, bytes]] = {part.name: {} for part in parts}
        for index, job in enumerate(jobs):
            images[parts[job["part"]].name] |= _collected(folder, index, job["views"])
    asked = sum(len(job["views"]) for job in jobs)
    missing = asked - sum(len(views) for views in images.values())
    if missing and not problem:
        problem = "the worker ended well but left pictures out"
    if not problem:
        return Pictures(images)
    lack = f"{missing} of {asked} pictures are missing"
    cure = f"Where GL libraries are missing: {INSTALL}"
    return Pictures(images, f"{lack}: {problem}. {cure}")


def stress_field(surface: Surface) -> str:
    """Name of the field that is drawn: the von Mises stress, else the first there is."""
    names = list(surface.fields)
    if not names:
        raise ValueError("a surface without fields cannot be drawn")
    return next((name for name in names if name.startswith("von Mises")), names[0])


def _shown(part: PartResult) -> list[tuple[Surface, Sequence[str]]]:
    """Surfaces of a part, and the views of each."""
    views = (PLAIN,) if part.surface.is_bare else VIEWS
    shown: list[tuple[Surface, Sequence[str]]] = [(part.surface, views)]
    return shown if part.mode is None else [*shown, (part.mode, (MODE,))]


def _collected(folder: Path, index: int, views: Sequence[str]) -> dict[str, bytes]:
    files = {view: folder / f"part_{index}_{view}.png" for view in views}
    return {view: file.read_bytes() for view, file in files.items() if file.is_file()}
