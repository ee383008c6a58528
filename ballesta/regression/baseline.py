"""Writes the baseline of a design: a small, readable record of its numbers."""

from pathlib import Path

from ballesta.regression.file import (
    BaselineError,
    baseline_path,
    is_old,
    read_baseline,
    write_record,
)
from ballesta.regression.isolated import CheckError, measure
from ballesta.regression.record import rungs_of
from checks.design.errors import DesignError, NumericsError
from checks.result.verdict import DesignResult

_OPTION = "--write-baseline"


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
