"""The process that checks a design for its baseline; started by path, apart from the user's code.

    python -I worker.py DESIGN --fidelity RUNG   < rungs pinned so far, as JSON

Prints one JSON table on standard output: the record, or the error's exit code and words. Our
packages are imported when it is known where they stand.
"""

import argparse
import json
import os
import sys
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
_PACKAGES = ("ballesta", "reports", "checks", "fem", "fatigue", "loads", "geometry")
Rungs = Mapping[str, Mapping[str, str]]


def import_from_root() -> None:
    """Let our packages be imported from beside this file, wherever else their names stand."""
    if any(_home(name) != ROOT for name in _PACKAGES):
        sys.path.insert(0, str(ROOT))


def _home(package: str) -> Path | None:
    spec = find_spec(package)
    if spec is None or not spec.origin:
        return None
    return Path(spec.origin).resolve().parent.parent


def main(argv: Sequence[str] | None = None) -> int:
    """Check the design that the arguments name; 0 whatever the check says."""
    from checks.design.errors import DesignError, NumericsError

    parser = argparse.ArgumentParser(prog="ballesta.regression.worker")
    parser.add_argument("design", type=Path)
    parser.add_argument("--fidelity", default="auto")
    wanted = parser.parse_args(argv)
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what libraries print is no answer
    rungs = json.load(sys.stdin)
    try:
        answer: dict[str, Any] = {"record": measured(wanted.design, wanted.fidelity, rungs)}
    except DesignError as error:
        answer = {"exit_code": 2, "error": str(error)}
    except NumericsError as error:
        answer = {"exit_code": 3, "error": str(error)}
    with answers:
        json.dump(answer, answers, allow_nan=False)
    return 0


def measured(path: Path, fidelity: str, rungs: Rungs) -> dict[str, Any]:
    """Check a design by the rungs that are pinned, its other parts as `fidelity` says.

    Where a solid decides something that was not pinned, all is checked again, pinned: a solid
    stops early where its verdict is settled, and numbers to be repeated may not depend on that.

    Raises DesignError and NumericsError.
    """
    from ballesta.design.read import read_design
    from ballesta.pipeline import check_design
    from ballesta.regression.file import has_new_solid, record_of, rungs_of
    from checks.design.effort import Effort, effort_of
    from checks.store.fingerprints import stages_of

    design = read_design(path)

    def say(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    def checked(pinned: Rungs) -> dict[str, Any]:
        effort = Effort(effort_of(fidelity, None).fidelity, pinned=pinned)
        return check_design(design, effort=effort, say=say).to_dict()

    result = checked(rungs)
    found = {part["name"]: rungs_of(part) for part in result["parts"]}
    if has_new_solid(rungs, found):
        result = checked(found)
    return record_of(result, stages_of(design), design.accuracy)


if __name__ == "__main__":
    import_from_root()
    from fem.threads import ONE_THREAD

    os.environ.update(ONE_THREAD)  # before a library that has threads is loaded
    sys.exit(main())
