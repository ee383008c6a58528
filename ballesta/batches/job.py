"""One design of a batch, its check and its outcome: judged or why not, from and to plain data."""

import errno
import io
import os
import re
import sys
from base64 import b64decode
from collections.abc import Mapping
from contextlib import redirect_stderr
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from io import TextIOBase
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, TextIO

from checks.design.errors import DesignError, NumericsError

if TYPE_CHECKING:
    from checks.result.verdict import DesignResult

WRONG_INPUT, GAVE_UP, CRASHED = "wrong input", "gave up", "crashed"
OUT_OF_TIME, OUT_OF_MEMORY = "out of time", "out of memory"
NOT_RUN = "not run"  # the batch was stopped before
EXIT_CODES = {
    "pass": 0, "UNDECIDED": 1, "FAIL": 1, WRONG_INPUT: 2,
    GAVE_UP: 3, CRASHED: 3, OUT_OF_TIME: 3, OUT_OF_MEMORY: 3, NOT_RUN: 3,
}  # fmt: skip
STOPPED = (CRASHED, OUT_OF_TIME, OUT_OF_MEMORY)  # by circumstances that may be others next time
TIMINGS = ("seconds", "peak_memory_bytes", "attempts")  # what differs from run to run
_OF_A_CHECK = (
    "part", "kind", "quantity", "value", "unit", "numerical", "model", "model_below", "limit",
    "required", "safety", "utilisation", "status", "cycle", "position", "place", "method", "note",
)  # fmt: skip


@dataclass(frozen=True)
class Job:
    """A design to check.

    name       the row it becomes, one of its kind in a batch
    file       the design file, as given
    overrides  "key=value", put in before it is read
    fidelity, within, accuracy  as the options of `ballesta check`; None where not given
    folder     where its results go
    reports    whether report.html and a .vtu per part are written beside result.json
    store      folder of what earlier checks have left (docs/store.md); None for none
    """

    name: str
    file: str
    overrides: tuple[str, ...]
    fidelity: str
    within: str | None
    accuracy: str | None
    folder: str
    reports: bool = False
    store: str | None = None


def ended(job: Job, status: str, error: str, stage: str) -> dict[str, Any]:
    """Outcome of a design without a verdict: status, cause, and the step that was running."""
    return _outcome(job, status) | {"error": error, "stage": stage}


def judged(job: Job, result: "DesignResult") -> dict[str, Any]:
    """Outcome of a design that was checked; the first governing check decides its status."""
    from checks.result.words import broken_gates, check_titles
    from reports.files import plain

    deciding = result.deciding if result.checks else None
    titles = check_titles(result.checks)
    checks = [
        {name: entry[name] for name in _OF_A_CHECK}
        | {"check": title, "governing": check is deciding}
        for check, entry, title in zip(
            result.checks, [check.to_dict() for check in result.checks], titles, strict=True
        )
    ]
    masses = {part.name: part.facts.get("mass [kg]") for part in result.parts}
    known = [mass for mass in masses.values() if mass is not None]
    outcome: dict[str, Any] = plain(
        _outcome(job, str(result.status))
        | {
            "design": result.name,
            "checks": checks,
            "inputs": dict(result.inputs),
            "mass": sum(known) if len(known) == len(masses) else None,
            "masses": masses,
            "broken_gates": [
                f"{owner}: {gate.name}" for owner, gate in broken_gates(result) if gate.binding
            ],
            "warnings": len(result.warnings),
        }
    )
    return outcome


def _outcome(job: Job, status: str) -> dict[str, Any]:
    return {
        "name": job.name,
        "design": "",
        "file": job.file,
        "overrides": list(job.overrides),
        "status": status,
        "exit_code": EXIT_CODES[status],
        "error": "",
        "stage": "",
        "folder": Path(job.folder).name,
        "checks": [],
        "inputs": {},
        "mass": None,
        "masses": {},
        "broken_gates": [],
        "warnings": 0,
        "sources": {},
        "result_sha256": "",
    }


def governing(outcome: Mapping[str, Any]) -> dict[str, Any] | None:
    """The check that decides an outcome; None without a verdict."""
    found: dict[str, Any] | None = next((c for c in outcome["checks"] if c["governing"]), None)
    return found


def sentence(outcome: Mapping[str, Any]) -> str:
    """The deciding check of an outcome, or the reason of its end, in a line."""
    from checks.result.words import brief, need_text, safety_text

    check = governing(outcome)
    if check is None:
        cause = outcome["error"].splitlines() or ["nothing was checked"]
        more = f" (and {len(cause) - 1} more)" if len(cause) > 1 else ""
        at = f"; last step: {outcome['stage']}" if outcome["stage"] else ""
        return brief(f"{cause[0]}{more}{at}", 300)
    safety = float("inf") if check["safety"] is None else check["safety"]
    broken = "; validity checks do not hold" if outcome["broken_gates"] else ""
    return brief(
        f"{check['part']} {check['check']}: safety {safety_text(safety, check['required'])} "
        f"({need_text(check['required'])} required){broken}",
        160,
    )


def folder_error(folder: Path, error: OSError) -> DesignError:
    """The error of an output folder that takes no files."""
    return DesignError(
        folder,
        "--out",
        f"cannot be written: {error.strerror}; what is finished is kept: make room or choose "
        "another folder, and run the same command again",
    )


# The check of one design.
_WIDTH = 180  # pixels
_STILL = re.compile(r'<img alt="([^"]*)"[^>]*? src="data:image/png;base64,([^"]*)"')
if TYPE_CHECKING:
    from checks.design.data import Design
    from checks.result.verdict import DesignResult
    from checks.store.store import Store

RUN = "ballesta.batches.job:run_plain"  # what a worker process is told to call
_NOT_THE_DESIGN = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO)


class FolderError(Exception):
    """The output folder takes no files: no design's fault, so the batch stops."""


def run_job(job: Job) -> dict[str, Any]:
    """Check a design and write its folder; returns the outcome as plain data (`outcome`).

    Raises FolderError where the output folder takes no files. The outcome names
    whatever else is wrong with the design; a bug of ours is raised.
    """
    start = perf_counter()
    told, sources = _Told(sys.stderr), dict[str, str]()
    _clear(Path(job.folder))
    try:
        with redirect_stderr(told):
            result = _checked(job, sources)
    except (DesignError, NumericsError, OSError) as error:
        _raise_if_folder_fails(error)
        if not isinstance(error, DesignError | NumericsError):
            raise
        outcome = ended(job, _status_of(error), str(error), told.step)
        outcome["sources"] = sources
    except MemoryError:
        outcome = ended(job, OUT_OF_MEMORY, "there was not enough memory", told.step)
    else:
        written = (Path(job.folder) / "result.json").read_bytes()
        outcome = judged(job, result)
        outcome |= {"sources": sources, "result_sha256": sha256(written).hexdigest()}
    return outcome | {"seconds": perf_counter() - start, "said": told.said}


def run_plain(job: Mapping[str, Any]) -> dict[str, Any]:
    """`run_job` of a job as JSON knows it."""
    from checks.store.fingerprints import code_digest

    outcome = run_job(Job(**{**job, "overrides": tuple(job["overrides"])}))
    return outcome | {"code": code_digest()}


def _checked(job: Job, sources: dict[str, str]) -> "DesignResult":
    """Result of a design; the digests of the files it is read from are put into `sources`."""
    from ballesta.design.read import read_design
    from ballesta.pipeline import check_design
    from ballesta.run import check_to_folder, progress
    from ballesta.sweeps.sweep import Neighbours
    from checks.design.effort import effort_of
    from checks.store.store import keep_result, recalled_result
    from reports.files import write_json

    effort = effort_of(job.fidelity, job.within, of_batch=True)
    accuracy = () if job.accuracy is None else (f"accuracy={job.accuracy}",)
    overrides = (*job.overrides, *accuracy)
    path, folder, store = Path(job.file), Path(job.folder), _store(job.store)
    start = perf_counter()
    design = read_design(path, overrides)
    reading = perf_counter() - start
    sources.update(sources_digests(design))
    if job.reports:
        result = check_to_folder(path, folder, overrides, effort=effort, store=store)
        if result.sha256 != design.sha256:
            raise DesignError(path, "cannot be read", "it was edited while it was being checked")
        if result.checks:
            write_thumbnail(folder, result.deciding.part)
        return result
    kept = recalled_result(store, path, overrides, effort)
    if kept is not None and kept.result.sha256 == design.sha256:
        result = kept.result
    else:
        with progress(path) as say:
            neighbours = Neighbours(path, overrides, store).of
            result = check_design(
                design, effort=effort, say=say, reading=reading, store=store, neighbours=neighbours
            )
        keep_result(store, design, effort, result, {})
    write_json(result, folder / "result.json")
    return result


@cache
def _store(folder: str | None) -> "Store | None":
    """The store of a folder, one for all jobs of a worker."""
    from ballesta.run import store_at

    return store_at(None if folder is None else Path(folder))


def _clear(folder: Path) -> None:
    """Remove what an earlier run has written: it must not be taken for what this one finds."""
    try:
        for name in ("result.json", "report.html", "thumbnail.png"):
            (folder / name).unlink(missing_ok=True)
        for file in folder.glob("*.vtu"):
            file.unlink()
    except OSError as error:
        _raise_if_folder_fails(error)


def sources_digests(design: "Design") -> dict[str, str]:
    """Every file that a design was read from, and the sha256 of its text as it was read."""
    return {
        os.path.abspath(file): sha256(text.encode()).hexdigest() for file, text in design.sources
    }


def text_digest(file: Path) -> str | None:
    """The sha256 of a file's text as designs read it; None if it cannot be read."""
    from ballesta.design.files import read_text

    try:
        return sha256(read_text(file).encode()).hexdigest()
    except DesignError:
        return None


def _status_of(error: Exception) -> str:
    """Status of a check that raised an error: out of memory, wrong input, or numerics."""
    from geometry.memory import TooLargeError

    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, TooLargeError | MemoryError):
            return OUT_OF_MEMORY
        cause = cause.__cause__
    return WRONG_INPUT if isinstance(error, DesignError) else GAVE_UP


def _raise_if_folder_fails(error: Exception) -> None:
    cause = error if isinstance(error, OSError) else error.__cause__
    if isinstance(cause, OSError) and cause.errno in _NOT_THE_DESIGN:
        raise FolderError(str(error)) from error


class _Told(TextIOBase):
    """Passes text on; remembers the step that runs, and messages to the user beside it."""

    def __init__(self, stream: TextIO) -> None:
        self._stream, self.step = stream, ""
        self.said: list[str] = []

    def write(self, text: str) -> int:
        self.step = step_of(text) or self.step
        if text.startswith("ballesta: "):
            self.said.append(text.removeprefix("ballesta: "))
        return self._stream.write(text)

    def flush(self) -> None:
        self._stream.flush()


def step_of(text: str) -> str:
    """The step that the last line of a check's progress tells; "" if there is none.

    >>> step_of("toggle_press    2.7 s  bar_lower: building")
    'bar_lower: building'
    """
    lines = [line for line in text.splitlines() if line.strip()]
    return lines[-1].partition(" s  ")[2].strip() if lines else ""


def write_thumbnail(folder: Path, part: str) -> None:
    """Write thumbnail.png from the first still of a part in report.html; nothing without stills."""
    from markupsafe import escape

    from checks.result.words import brief
    from reports.files import write_whole

    stills = _STILL.findall((folder / "report.html").read_text(encoding="utf-8"))
    named = f" of {escape(brief(part, 60))}, "
    found = next((data for words, data in stills if named in words), None)
    if found is None:
        return
    from PIL import Image

    with Image.open(io.BytesIO(b64decode(found))) as image:
        small = image.convert("RGB")
        small.thumbnail((_WIDTH, _WIDTH))
        out = io.BytesIO()
        small.quantize(64).save(out, "PNG", optimize=True)
    write_whole(folder / "thumbnail.png", out.getvalue())
