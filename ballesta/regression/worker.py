"""The process that checks a design for its baseline; started by path, apart from the user's code.

    python -I worker.py DESIGN --fidelity RUNG   < rungs pinned so far, as JSON

Prints one JSON table on standard output: the record, or the error's exit code and words.
"""

import os
import sys
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_PACKAGES = ("ballesta", "reports", "checks", "fem", "fatigue", "loads", "geometry")


def import_from_root() -> None:
    """Let our packages be imported from beside this file, wherever else their names stand."""
    if any(_home(name) != ROOT for name in _PACKAGES):
        sys.path.insert(0, str(ROOT))


def _home(package: str) -> Path | None:
    spec = find_spec(package)
    if spec is None or not spec.origin:
        return None
    return Path(spec.origin).resolve().parent.parent


if __name__ == "__main__":
    import_from_root()
    from fem.threads import ONE_THREAD

    os.environ.update(ONE_THREAD)  # before a library that has threads is loaded
    from ballesta.regression.work import main

    sys.exit(main())
