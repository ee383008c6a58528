"""Outcome of one design of a batch as plain data: judged, or ended without a verdict, and why."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from checks.design.errors import DesignError

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
