"""Whole results of the designs, kept to show that a change of the code changes no number.

    python -m bench.frozen write   [DESIGN ...] [--fidelity RUNG] [--folder DIR]
    python -m bench.frozen compare [DESIGN ...] [--fidelity RUNG] [--folder DIR] [--tolerance SHARE]

Without names: every design in designs/. Without a fidelity: formula and auto; solid takes
minutes a design. Each result is `result.json` without what differs from run to run (times,
versions, paths of reports), as DIR/DESIGN.RUNG.json.gz; DIR is out/frozen if nothing else is said,
and not tracked. Numbers are compared bit for bit, which holds on one machine with one thread;
elsewhere a tolerance such as 1e-9 is needed. Ends with 1 where something differs.
"""

import argparse
import gzip
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fem.threads import ONE_THREAD

ROOT = Path(__file__).parents[1]
RUNGS = ("formula", "auto")
ALL_RUNGS = (*RUNGS, "solid")
CHANGING = frozenset({"date", "timings", "seconds", "versions", "report", "command"})
MOST_TOLD = 20
# The child's code: a process of its own for each result, so that none depends on those before it.
_CHECK = """
import json, sys
from pathlib import Path
from ballesta.pipeline import check_file
from checks.ladder.part_ladder import Effort
from reports.files import plain
result = check_file(Path(sys.argv[1]), effort=Effort(sys.argv[2]))
print("RESULT " + json.dumps(plain(result.to_dict()), allow_nan=False))
"""


def steady(data: Any) -> Any:
    """Return plain data without the keys whose values differ from run to run."""
    if isinstance(data, dict):
        return {key: steady(value) for key, value in data.items() if key not in CHANGING}
    return [steady(value) for value in data] if isinstance(data, list) else data


def result_of(design: str, rung: str) -> Any:
    """Check a design in a process of its own; raises RuntimeError with what it said last."""
    done = subprocess.run(
        [sys.executable, "-c", _CHECK, f"designs/{design}.toml", rung],
        cwd=ROOT, env={**os.environ, **ONE_THREAD, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True,
    )  # fmt: skip
    lines = [line for line in done.stdout.splitlines() if line.startswith("RESULT ")]
    if done.returncode or not lines:
        raise RuntimeError(f"{design} by {rung} was not checked:\n{done.stderr[-2000:]}")
    return steady(json.loads(lines[-1].removeprefix("RESULT ")))


def differences(old: Any, new: Any, tolerance: float = 0.0, at: str = "") -> Iterator[str]:
    """Yield where two plain results differ: a line each, with both values.

    tolerance  as a share of the larger of two numbers; 0 compares bit for bit
    """
    numbers = [isinstance(x, int | float) and not isinstance(x, bool) for x in (old, new)]
    if isinstance(old, dict) and isinstance(new, dict):
        for key in [*old, *(key for key in new if key not in old)]:
            if key in old and key in new:
                yield from differences(old[key], new[key], tolerance, f"{at}/{key}")
            else:
                yield f"{at}/{key}: only in the {'old' if key in old else 'new'} result"
    elif isinstance(old, list) and isinstance(new, list):
        if len(old) != len(new):
            yield f"{at}: {len(old)} entries before, {len(new)} now"
            return
        for number, (before, now) in enumerate(zip(old, new, strict=True)):
            yield from differences(before, now, tolerance, f"{at}[{number}]")
    elif all(numbers):
        apart, size = abs(new - old), max(abs(old), abs(new))
        if apart > tolerance * size:
            yield f"{at}: {old!r} before, {new!r} now, {apart / size:.3g} of it"
    elif old != new:
        yield f"{at}: {str(old)[:100]!r} before, {str(new)[:100]!r} now"


def main() -> int:
    """Keep results, or compare with those that were kept."""
    parser = argparse.ArgumentParser(prog="python -m bench.frozen")
    parser.add_argument("action", choices=("write", "compare"))
    parser.add_argument("designs", nargs="*", help="names in designs/; else all")
    parser.add_argument("--fidelity", action="append", choices=ALL_RUNGS)
    parser.add_argument("--folder", type=Path, default=ROOT / "out" / "frozen")
    parser.add_argument("--tolerance", type=float, default=0.0)
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    apart = False
    for design in asked.designs or sorted(path.stem for path in (ROOT / "designs").glob("*.toml")):
        for rung in asked.fidelity or RUNGS:
            file = asked.folder / f"{design}.{rung}.json.gz"
            if asked.action == "compare" and not file.exists():
                parser.error(f"{file} is not there: write it with the code to compare with")
            new = result_of(design, rung)
            if asked.action == "write":
                file.write_bytes(gzip.compress(json.dumps(new).encode(), mtime=0))
                print(f"{design} {rung}: written", flush=True)
                continue
            old = json.loads(gzip.decompress(file.read_bytes()))
            told = list(differences(old, new, asked.tolerance))
            apart |= bool(told)
            print(f"{design} {rung}: {len(told) or 'no'} differences", flush=True)
            for line in told[:MOST_TOLD]:
                print(f"  {line}")
    return int(apart)


if __name__ == "__main__":
    sys.exit(main())
