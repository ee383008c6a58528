"""The 18 machines as a user checks them: by `auto`, by solids, and within 1, 3, 10 and 60 s.

    python -m bench.auto_cost [DESIGN...]   resumes; writes bench/rungs/machines.jsonl

One line of JSON for each design and way of asking: seconds of the whole command, report included,
by the clock and of the processor, and every check. A time limit counts from the command's start.
"""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

from bench.run import machine
from checks.result.verdict import Check

FILE = Path(__file__).parent / "rungs" / "machines.jsonl"
DESIGNS = Path(__file__).parents[1] / "designs"
FOUR = ("toggle_press", "slider_crank", "quick_return", "spring_hammer")
MACHINES = (*FOUR, *sorted(f"gallery/{file.stem}" for file in DESIGNS.glob("gallery/*.toml")))
LIMITS = (1, 3, 10, 60)
ASKED = {
    "auto": (),
    **{f"within {limit} s": ("--within", f"{limit}s") for limit in LIMITS},
    "solid": ("--fidelity", "solid"),
}


def measured(name: str, asked: str) -> dict[str, Any]:
    """One command: its seconds, and the checks of its result; none where nothing was finished."""
    ballesta = Path(sys.executable).with_name("ballesta")
    with TemporaryDirectory() as out:
        command = [ballesta, "check", DESIGNS / f"{name}.toml", "--no-store", "--out", out]
        start, busy = perf_counter(), _busy()
        ended = subprocess.run(
            [*command, *ASKED[asked]], capture_output=True, text=True, check=False
        )
        row: dict[str, Any] = {
            "design": name,
            "asked": asked,
            "machine": machine(),
            "seconds": perf_counter() - start,
            "processor": _busy() - busy,
            "code": ended.returncode,
        }
        written = Path(out) / Path(name).name / "result.json"
        if not written.exists():
            return row | {"said": ended.stderr.splitlines()[-1]}
        result = json.loads(written.read_text())
    return row | {
        "versions": result["versions"],
        "loads": result["timings"]["loads"],
        "checks": list(_told(result)),
        "rungs": {
            part["name"]: [one["rung"] for one in part["rungs"] if one["checks"]]
            for part in result["parts"]
        },
    }


def _busy() -> float:
    used = getrusage(RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _told(result: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """The checks of a result, with the ends of their bars over the limit that is allowed."""
    for data in (*(one for part in result["parts"] for one in part["checks"]), *result["linkage"]):
        check = Check.from_dict(data)
        yield {
            "part": check.part,
            "kind": check.kind,
            "quantity": check.quantity,
            "method": check.method,
            "utilisation": check.utilisation,
            "status": str(check.status),
        }


def known() -> dict[tuple[str, str], dict[str, Any]]:
    """The lines of the file, by design and way of asking."""
    rows = map(json.loads, FILE.read_text().splitlines()) if FILE.exists() else ()
    return {(row["design"], row["asked"]): row for row in rows}


def main() -> None:
    """Measure what is missing."""
    done = known()
    for asked in ASKED:
        for name in sys.argv[1:] or MACHINES:
            if (name, asked) in done:
                continue
            row = measured(name, asked)
            with FILE.open("a") as file:
                file.write(json.dumps(row) + "\n")
            print(f"{name}, {asked}: {row['seconds']:.1f} s", flush=True)


if __name__ == "__main__":
    main()
