"""Cost of `auto` over the four machines, as a share of `--fidelity solid` in the same run.

python -m bench.auto_cost   prints JSON; a design in turn by both, fresh models each
"""

import json
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from ballesta.pipeline import check_file
from checks.ladder.part_ladder import Effort

MACHINES = ("toggle_press", "slider_crank", "quick_return", "spring_hammer")
FILE = Path(__file__).parent / "rungs" / "cost.json"
DESIGNS = Path(__file__).parents[1] / "designs"


def measured(name: str) -> dict[str, Any]:
    """Seconds and verdicts of a design by `auto` and by solids, and the rungs of its parts."""
    row: dict[str, Any] = {"design": name}
    for fidelity in ("auto", "solid"):
        start, busy = perf_counter(), process_time()
        result = check_file(DESIGNS / f"{name}.toml", effort=Effort(fidelity))
        row[fidelity] = perf_counter() - start
        row[f"{fidelity}, processor"] = process_time() - busy
        row[f"{fidelity} loads"] = result.timings["loads"]
        row[f"{fidelity} status"] = {
            f"{check.part} {check.kind}: {check.quantity}": str(check.status)
            for check in result.checks
            if not check.method.startswith("formula") or fidelity == "auto"
        }
        if fidelity == "auto":
            row["rungs"] = {
                part.name: [tried.rung for tried in part.rungs if tried.checks]
                for part in result.parts
            }
    return row


def main() -> None:
    """Measure all four."""
    rows = [measured(name) for name in MACHINES]
    data = {
        "rows": rows,
        "auto over solid": _share(rows, ""),
        "auto over solid, processor": _share(rows, ", processor"),
    }
    FILE.write_text(json.dumps(data, indent=1) + "\n")
    print({name: share for name, share in data.items() if name != "rows"})


def _share(rows: list[dict[str, Any]], clock: str) -> float:
    auto, solid = (sum(row[f"{fidelity}{clock}"] for row in rows) for fidelity in ("auto", "solid"))
    return float(auto / solid)


if __name__ == "__main__":
    main()
