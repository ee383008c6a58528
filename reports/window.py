"""The interactive window of a checked design, and pictures of it, from a process of its own.

Where there is no display, or graphics libraries are missing, a message says so and gives the cure:
neither can crash or hang the process that asked for the window.
"""

import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from geometry.graphics import INSTALL
from reports.files import replacing
from reports.window_scene import Scene, write_scene
from reports.window_worker import NO_WINDOW
from reports.worker import run_worker

_WORKER = (sys.executable, "-m", "reports.window_worker")
_PROBING = 60.0  # s
_DRAWING = 180.0
_NO_DISPLAY = (
    "there is no display to open a window on{said}: run it in a desktop session, over ssh with "
    "ssh -X, or write a picture with --off-screen FILE.png; the report of ballesta check shows the "
    "same fields in a browser"
)


@dataclass(frozen=True)
class Trouble:
    """Reason that nothing could be shown; display: True for lack of one, not of graphics."""

    words: str
    display: bool = False


def probe_window(
    *, off_screen: bool = False, worker: Sequence[str] = _WORKER, timeout: float = _PROBING
) -> Trouble | None:
    """Try to open a window (or to draw without one) and tell what keeps it from it."""
    if not off_screen and sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        return Trouble(_NO_DISPLAY.format(said=" (DISPLAY is not set)"), display=True)
    with TemporaryDirectory(prefix="ballesta-") as name:
        what = "--probe-picture" if off_screen else "--probe"
        ended = run_worker([*worker, what], Path(name), timeout, window=not off_screen)
    return _trouble(ended.code, ended.words)


def open_window(
    scene: Scene, part: str | None = None, *, worker: Sequence[str] = _WORKER
) -> Trouble | None:
    """Show a scene in a window, from the named part on, until it is closed."""
    with TemporaryDirectory(prefix="ballesta-") as name:
        write_scene(scene, Path(name))
        ended = run_worker([*worker, name, part or ""], Path(name), None, window=True)
    return _trouble(ended.code, ended.words)


def window_picture(
    scene: Scene,
    file: Path,
    part: str | None = None,
    keys: Sequence[str] = (),
    *,
    worker: Sequence[str] = _WORKER,
    timeout: float = _DRAWING,
) -> Trouble | None:
    """Write a picture of the window to a PNG file, after some keys were pressed in it.

    Raises OSError where the file cannot be written.
    """
    with TemporaryDirectory(prefix="ballesta-") as name:
        folder = Path(name)
        write_scene(scene, folder)
        drawn = folder / "window.png"
        ended = run_worker([*worker, name, part or "", *keys, str(drawn)], folder, timeout)
        if ended.words or not drawn.is_file():
            return _trouble(ended.code, ended.words or "the worker ended well but drew nothing")
        with replacing(file) as temporary:
            temporary.write_bytes(drawn.read_bytes())
    return None


def _trouble(code: int | None, words: str) -> Trouble | None:
    if not words:
        return None
    if code == NO_WINDOW:
        said = os.environ.get("DISPLAY", "")
        return Trouble(_NO_DISPLAY.format(said=f" (DISPLAY is {said[:60]})"), display=True)
    return Trouble(f"{words}. Where GL libraries are missing: {INSTALL}")
