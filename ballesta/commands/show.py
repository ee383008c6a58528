"""A design's parts in an interactive window: `ballesta show`."""

import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from ballesta.design.read import read_design
from ballesta.diff.difference import RESULT
from ballesta.run import GAVE_UP, WRONG_INPUT, guarded, progress, store_at, told_of_folder
from checks.design.effort import FORMULA, effort_of
from checks.design.errors import DesignError, no_such
from checks.result.words import brief, verdict_sentence
from reports.window import Window, advising, scene_of, try_window, write_picture


@dataclass(frozen=True)
class Wanted:
    """Options of `ballesta show`; picture: a file to draw in place of a window."""

    part: str | None = None
    picture: Path | None = None
    fidelity: str = "auto"
    within: str | None = None
    store: Path | None = None
    fields: bool = False


def run_show(path: Path, wanted: Wanted, overrides: Sequence[str] = ()) -> int:
    """Check a design and show its parts with their fields; returns the exit code.

    0: shown, whatever the checks say; 2: an input is wrong, or there is no display; 3: the
    numerics gave up, or nothing can be drawn here.
    """

    def work() -> int:
        effort = effort_of(wanted.fidelity, wanted.within, fields=wanted.fields)
        store = store_at(wanted.store)
        _refuse_result(path)
        start = perf_counter()
        design = read_design(path, overrides)
        reading = perf_counter() - start
        if wanted.part is not None and wanted.part not in design.parts:
            raise DesignError(path, "PART", no_such("part", wanted.part, design.parts))
        if wanted.picture is not None and (problem := _why_no_picture(wanted.picture)):
            raise DesignError(wanted.picture, "--off-screen", problem)
        # before the check, which may take minutes
        trouble = try_window(off_screen=wanted.picture is not None)
        if trouble is not None:
            print(f"ballesta: show: {trouble.words}", file=sys.stderr)
            return WRONG_INPUT if trouble.display else GAVE_UP
        if wanted.fidelity == FORMULA and not wanted.fields:
            print(
                f"ballesta: show: --fidelity {wanted.fidelity} makes no mesh: stress is estimated "
                "from section forces; --fields gives each part a mesh to look at",
                file=sys.stderr,
            )
        from ballesta.pipeline import check_design  # the solvers, which a trial does not need

        with progress(path) as say:
            result = check_design(
                design, effort=effort, say=say, reading=reading, store=store, live=True
            )
        print(verdict_sentence(result), flush=True)
        scene = scene_of(result)
        for name, live in scene.parts.items():
            if live.estimated:
                print(f"{brief(name, 40)}: {advising(live.notes[0])}", file=sys.stderr)
            if not live.n_fields:
                why = brief(live.missing.get("mises", "nothing loads it"), 200)
                print(f"{brief(name, 40)} is shown without stress: {why}", file=sys.stderr)
        if wanted.picture is None:
            Window(scene, wanted.part).plotter.show()
            return 0
        with told_of_folder(wanted.picture, "--off-screen"):
            write_picture(scene, wanted.picture, wanted.part)
        print(f"written: {wanted.picture}")
        return 0

    return guarded(work)


def _refuse_result(path: Path) -> None:
    """Refuse a result, and the folder of one, in place of a design; raises DesignError."""
    if path.is_dir():
        what = "is a directory, not a design file"
    elif path.name == RESULT and path.is_file():
        what = "is a result, not a design file"
    else:
        return
    raise DesignError(
        path,
        "cannot be read",
        f"{what}: show needs the design file (.toml), which it checks itself; a result has no "
        "fields, its report.html shows them in a browser",
    )


def _why_no_picture(file: Path) -> str:
    """Reason that a picture cannot be written to a file; "" for none."""
    if file.suffix.lower() != ".png":
        return f'must be named .png, got "{file.name}"'
    if file.is_dir():
        return f"is a folder, name a file in it such as {file / 'window.png'}"
    folder = next(folder for folder in file.absolute().parents if folder.exists())
    if not folder.is_dir():
        return f"cannot be written: {folder} is no folder"
    if not os.access(folder, os.W_OK | os.X_OK):
        return f"cannot be written: no permission to write in {folder}"
    return ""
