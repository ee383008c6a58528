"""Writes the baseline of a design: a small, readable record of its numbers.

Its check runs in a process of its own, so that the user's modules and ours never meet.
"""

import json
import signal
import site
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ballesta.regression.file import (
    BaselineError,
    baseline_path,
    is_old,
    read_baseline,
    rungs_of,
    write_record,
)
from checks.design.errors import DesignError, NumericsError
from checks.result.verdict import DesignResult

WORKER = Path(__file__).resolve().with_name("worker.py")
_LAST_LINES = 15
_OPTION = "--write-baseline"


class CheckError(Exception):
    """A check that came to no numbers; `exit_code` is the tool's, None where it died."""

    def __init__(self, exit_code: int | None, words: str) -> None:
        super().__init__(exit_code, words)
        self.exit_code, self.words = exit_code, words

    def __str__(self) -> str:
        return self.words


def write_baseline(result: DesignResult) -> Path:
    """Write the baseline beside the design, whole or not at all; returns its path.

    The rungs are those that decided the result; the numbers are measured as a test will measure
    them, in a process of its own with one thread. Bands that a baseline states are kept.

    Raises DesignError and NumericsError as the check does, OSError where it cannot be written.
    """
    path = baseline_path(result.file)
    if result.overrides:
        said = (
            f"keeps the numbers of the file as it stands; leave out {', '.join(result.overrides)}"
        )
        raise DesignError(path, _OPTION, said)
    try:
        bands = read_baseline(path).bands if path.exists() and not is_old(path) else {}
    except BaselineError as error:
        raise DesignError(path, _OPTION, f"{error}; mend or delete it") from error
    rungs = {part["name"]: rungs_of(part) for part in result.to_dict()["parts"]}
    try:
        record = measure(Path(result.file), rungs=rungs)
    except CheckError as error:
        if error.exit_code == 2:  # the file was changed meanwhile
            raise DesignError(path, _OPTION, str(error)) from error
        raise NumericsError(str(error), f"{path}: {_OPTION}", "try a coarser fidelity") from error
    write_record(path, record, bands)
    return path


def measure(
    design: Path,
    *,
    fidelity: str = "auto",
    rungs: Mapping[str, Mapping[str, str]] | None = None,
    timeout: float | None = None,
) -> dict[str, Any]:
    """Check a design in an isolated process, of one thread; returns its record (`record_of`).

    fidelity  of parts whose rungs are not pinned
    rungs     part -> kind of check -> the rung that decides it
    timeout   s

    Raises CheckError with the tool's own words.
    """
    command = [sys.executable, *_isolation(), str(WORKER), design.name, "--fidelity", fidelity]
    process = subprocess.Popen(
        command,
        cwd=design.resolve().parent,  # so that no digest or message has a path of this machine
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        errors="replace",
    )
    try:
        answer, said = process.communicate(json.dumps(rungs or {}), timeout)
    except subprocess.TimeoutExpired as error:
        process.kill()
        _, said = process.communicate()
        raise CheckError(
            None, f"the check took longer than {timeout:g} s (ballesta_timeout){_last(said)}"
        ) from error
    finally:  # whatever stopped us, such as a time limit of another plugin
        if process.poll() is None:
            process.kill()
            process.wait()
    return _record(process.returncode, answer, said)


def _record(code: int, answer: str, said: str) -> dict[str, Any]:
    if code < 0:
        raise CheckError(None, f"the check was killed by {_signal(-code)}{_last(said)}")
    try:
        found = json.loads(answer)
    except ValueError as error:
        raise CheckError(None, f"the check died with exit code {code}{_last(said)}") from error
    if "error" in found:
        raise CheckError(found["exit_code"], found["error"])
    record: dict[str, Any] = found["record"]
    return record


def _isolation() -> list[str]:
    """Options of Python that shut the user's modules out, but for the site that holds us."""
    here = site.getusersitepackages()
    return ["-E", "-P"] if WORKER.is_relative_to(Path(here).resolve()) else ["-I"]


def _signal(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _last(said: str) -> str:
    lines = said.strip().splitlines()[-_LAST_LINES:]
    return "\n".join(["; it said last:", *lines]) if lines else ", and said nothing"
