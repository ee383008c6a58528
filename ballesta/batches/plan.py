"""Jobs of a batch: designs from files and folders, each with its variations."""

import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

from ballesta.batches.job import Job
from ballesta.run import folder_name
from checks.design.effort import SWEPT
from checks.design.errors import DesignError
from geometry.parameters import read_bounded
from reports.files import write_whole

REPORTS_UP_TO = 50  # jobs have a report each unless asked otherwise
_FORMAT = "ballesta-batch/1"
_OWN = ("batch.json", "batch.lock", "journal.jsonl", "index.html", "results.csv",
        "results.parquet", "timings.csv", "store")  # fmt: skip


@dataclass(frozen=True)
class Request:
    """Request of a batch: designs, variations, options. Another request is another batch.

    designs    files and folders, as given
    overrides  that every job has
    sweeps, sample, seed  the variations of every design, as `ballesta.sweeps.sweep` takes them
    """

    designs: tuple[str, ...]
    overrides: tuple[str, ...] = ()
    sweeps: tuple[str, ...] = ()
    sample: int | None = None
    seed: int = 0
    fidelity: str = "auto"
    within: str | None = None
    accuracy: str | None = None


@dataclass(frozen=True)
class Plan:
    """The jobs of a batch in their order.

    notes    what is to be told of single ones beside their results, by name
    refused  why single ones need not be tried, by name
    """

    jobs: tuple[Job, ...]
    notes: dict[str, str]
    refused: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class _Design:
    """A design file, its variations, notes on it, and the reason if it has none."""

    file: Path
    variations: Sequence[tuple[str, ...]]
    note: str
    refused: DesignError | None = None


def planned(request: Request, out: Path, reports: bool | None, store: Path | None = None) -> Plan:
    """The jobs of a request.

    reports  None for reports of up to `REPORTS_UP_TO` jobs
    store    folder of the stages that jobs share; None for none

    Raises DesignError for a folder without designs, and for sweeps that no design can take. A file
    that cannot be read is a job like any other, which ends with its cause.
    """
    files, twice = design_files(request.designs)
    designs = [
        _with_variations(file, note, request)
        for file, note in zip(files, _notes(files, twice), strict=True)
    ]
    refusals = [design.refused for design in designs if design.refused is not None]
    if refusals and len(refusals) == len(designs):
        raise refusals[0]
    wanted = reports
    if reports is None:
        wanted = (
            request.fidelity != SWEPT
            and sum(len(design.variations) for design in designs) <= REPORTS_UP_TO
        )
    taken = {name.casefold() for name in _OWN}
    jobs, notes, refused = [], {}, {}
    for design in designs:
        stem, count = _stem(design.file, files), len(design.variations)
        for number, variation in enumerate(design.variations, 1):
            wish = stem if count == 1 else f"{stem}-{number:0{len(str(count))}d}"
            name = _untaken(wish, taken)
            if design.note:
                notes[name] = design.note
            if design.refused is not None:
                refused[name] = str(design.refused)
            jobs.append(
                Job(
                    name, str(design.file), (*request.overrides, *variation), request.fidelity,
                    request.within, request.accuracy, str(out / name), bool(wanted),
                    None if store is None else str(store),
                )
            )  # fmt: skip
    return Plan(tuple(jobs), notes, refused)


def _with_variations(file: Path, note: str, request: Request) -> _Design:
    """A design's variations; a single one of a design that cannot be read, or not be varied so."""
    single: list[tuple[str, ...]] = [()]
    if not request.sweeps:
        return _Design(file, single, note)
    from ballesta.design.read import read_design
    from ballesta.sweeps.sweep import design_variations, variations

    variations(request.sweeps, request.sample, request.seed)  # raises what no design can take
    try:
        read_design(file, request.overrides)
    except DesignError:
        return _Design(file, single, note)
    try:
        found = design_variations(
            file, request.sweeps, request.sample, request.seed, request.overrides
        )
    except DesignError as error:
        return _Design(file, single, note, error)
    return _Design(file, found, note)


def design_files(given: Sequence[str]) -> tuple[list[Path], set[Path]]:
    """Design files of the files and folders that were given, and those that were given twice.

    Of a folder the files NAME.toml in it, by name, but hidden ones and those of deeper folders.
    """
    files: dict[Path, Path] = {}
    twice: set[Path] = set()
    for text in given:
        path = Path(text)
        inside = [path]
        if path.is_dir():
            try:
                inside = sorted(p for p in path.glob("*.toml") if not p.name.startswith("."))
            except OSError as error:
                raise DesignError(path, "cannot be read", str(error.strerror).lower()) from error
            if not inside:
                raise DesignError(path, "DESIGN", "holds no design file (*.toml)")
        for file in inside:
            real = Path(os.path.realpath(file))
            if real in files:
                twice.add(files[real])
            files.setdefault(real, file)
    return list(files.values()), twice


def _notes(files: Sequence[Path], twice: set[Path]) -> list[str]:
    """A note for every file that is there twice, by name or by content."""
    notes, seen = [], dict[str, Path]()
    for file in files:
        found = ["given more than once, checked once"] if file in twice else []
        try:
            content = read_bounded(file)
        except (OSError, ValueError):  # the job tells why
            content = b""
        if content.strip():
            first = seen.setdefault(sha256(content).hexdigest(), file)
            found += [] if first is file else [f"duplicate: the same text as {first.name}"]
        notes.append("; ".join(found))
    return notes


def _stem(file: Path, files: Sequence[Path]) -> str:
    alone = sum(other.stem == file.stem for other in files) == 1
    return folder_name(file.stem if alone else f"{file.resolve().parent.name}_{file.stem}")


def _untaken(wish: str, taken: set[str]) -> str:
    """The wish, or with a number behind it; no two names may be one folder on any system."""
    name, number = wish, 2
    while name.casefold() in taken:
        name, number = f"{wish}_{number}", number + 1
    taken.add(name.casefold())
    return name


def claim_folder(out: Path, request: Request) -> None:
    """Make the output folder this batch's; raises DesignError if it is or holds anything else."""
    asked = {"format": _FORMAT, **json.loads(json.dumps(asdict(request)))}
    record = out / "batch.json"
    try:
        out.mkdir(parents=True, exist_ok=True)
        inside = [path.name for path in out.iterdir()]
        found = record.read_bytes() if record.name in inside else None
        if found is None:
            foreign = sorted(n for n in inside if n != "batch.lock" and not n.endswith(".tmp"))
            if foreign:
                raise DesignError(
                    out, "--out", f"is not empty and no batch ({foreign[0]}): name a new folder"
                )
            text = json.dumps(asked, indent=1) + "\n"
            write_whole(record, text.encode())
            return
    except OSError as error:
        raise DesignError(out, "--out", f"cannot be written: {error.strerror}") from error
    _compare(out, found, asked)


def _compare(out: Path, found: bytes, asked: dict[str, Any]) -> None:
    try:
        before = json.loads(found)
        known = before["format"] == _FORMAT
    except (ValueError, KeyError, TypeError):
        known = False
    if not known:
        raise DesignError(
            out, "--out", "its batch.json is not one of this version: name a new folder"
        )
    for key, now in asked.items():
        if before.get(key) != now:
            option = {"designs": "DESIGN", "overrides": "--set", "sweeps": "--sweep"}
            there, here = _shown(before.get(key)), _shown(now)
            raise DesignError(
                out,
                "--out",
                f"holds another batch ({option.get(key, f'--{key}')}: {there} there, {here} now): "
                "name a new folder, or ask for the same batch",
            )


def _shown(value: Any) -> str:
    return ", ".join(map(str, value)) if isinstance(value, list) and value else str(value or "none")
