"""Cost of a batch's machinery, and the speed of two workers over one.

python -m bench.batch overhead          100 jobs of 50 ms that do nothing: seconds
python -m bench.batch press [N]         N = 100 variants of the toggle press by solids: hours
python -m bench.batch swept [N]         N = 60 variants of a link on carried meshes: minutes
python -m bench.batch memory [N]        N = 1000 formula designs by one worker: an hour

Prints JSON. Shares and ratios are of one run; starts of interpreters are not counted.
"""

import csv
import json
import os
import sys
import tempfile
from pathlib import Path
from time import perf_counter, process_time, sleep
from typing import Any

from ballesta.batches.job import GAVE_UP, RUN, Job, ended
from ballesta.batches.plan import Plan, Request, planned
from ballesta.batches.processes import resident_bytes
from ballesta.batches.run import Settings, run_batch
from tests.small_machine import MACHINE, PLATE

ROOT = Path(__file__).parents[1]
PRESS = ROOT / "designs" / "toggle_press.toml"
SECONDS = 0.05  # of a job that does nothing
MODEST = ("parts.bar_upper.mesh.fineness=0.4", "parts.bar_lower.mesh.fineness=0.4",
          "accuracy=20 %")  # fmt: skip


def nothing(job: dict[str, Any], seconds: float = SECONDS) -> dict[str, Any]:
    """A job that takes its time and says how long that was."""
    start = perf_counter()
    sleep(seconds)
    done = ended(Job(**{**job, "overrides": tuple(job["overrides"])}), GAVE_UP, "nothing", "")
    return done | {"seconds": perf_counter() - start}


class Watch:
    """Told of a batch; notes when jobs end and how large the parent is then."""

    def __init__(self) -> None:
        self.ends: list[float] = []
        self.work: list[float] = []
        self.sizes: list[int] = []
        self.processor: list[float] = []

    def say(self, text: str) -> None:
        """Nothing is shown."""

    def kept(self, count: int, total: int, damaged: int) -> None:
        """Nothing is shown."""

    def workers(self, count: int) -> None:
        """Nothing is shown."""

    def finished(self, outcome: Any, timings: Any) -> None:
        """Note a job."""
        self.ends.append(perf_counter())
        self.work.append(timings["seconds"])
        self.sizes.append(resident_bytes())
        self.processor.append(process_time())

    def running(self, steps: Any) -> None:
        """Nothing is shown."""


def run(plan: Plan, out: Path, settings: Settings, function: str = RUN) -> tuple[Watch, float]:
    """Run a plan; returns what was seen and the time until the tables were written."""
    out.mkdir(parents=True, exist_ok=True)
    watch, start = Watch(), perf_counter()
    run_batch(plan, out, settings, watch, function=function)
    return watch, perf_counter() - start


def idle_plan(folder: Path, count: int) -> Plan:
    """Jobs for functions that look at none of what they are given."""
    jobs = [
        Job(f"j{k:04d}", f"{k}", (), "formula", None, None, str(folder / f"j{k}"))
        for k in range(count)
    ]
    return Plan(tuple(jobs), {})


def overhead(folder: Path, workers: int = 2) -> dict[str, float]:
    """Share of the machinery in the time of 100 jobs that do nothing for 50 ms.

    From the end of the first jobs, when all workers have started, until the tables are written.
    """
    os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    first, count = 20, 100
    start = perf_counter()
    plan, settings = idle_plan(folder, first + count), Settings(workers, None)
    watch, seconds = run(plan, folder, settings, "bench.batch:nothing")
    spent = start + seconds - watch.ends[first - 1]
    work = sum(watch.work[first:]) / workers
    tables = start + seconds - watch.ends[-1]
    return {
        "jobs": count,
        "workers": workers,
        "work s": work,
        "overhead": spent / work - 1.0,
        "of that, tables": tables / work,
        "parent's processor time": (watch.processor[-1] - watch.processor[first - 1]) / spent,
    }


def press(folder: Path, count: int) -> dict[str, float]:
    """Two workers against one, and a second run, over variants of the press by solids."""
    sweep = f"parts.bar_upper.wall = 5..7 mm : {count}"
    found: dict[str, float] = {"variants": count}
    times = {}
    for workers in (1, 2):
        out = folder / f"workers_{workers}"
        request = Request((str(PRESS),), MODEST, (sweep,), fidelity="solid")
        plan = planned(request, out, False)
        watch, seconds = run(plan, out, Settings(workers, None))
        begun = min(end - work for end, work in zip(watch.ends, watch.work, strict=True))
        times[workers] = watch.ends[-1] - begun
        found[f"{workers} workers s"] = times[workers]
        found[f"{workers} workers, work s"] = sum(watch.work)
        found[f"{workers} workers, overhead"] = times[workers] * workers / sum(watch.work) - 1.0
        _, again = run(plan, out, Settings(workers, None))
        found[f"{workers} workers, second run"] = again / seconds
    same = {(folder / f"workers_{workers}" / "results.csv").read_bytes() for workers in (1, 2)}
    return found | {"two over one": times[1] / times[2], "same tables": len(same) == 1}


def swept(folder: Path, count: int, rounds: int = 2) -> dict[str, Any]:
    """Variants an hour by one worker and by two, in turns, once each worker has its neighbour."""
    file = folder / "machine.toml"
    file.write_text(MACHINE + PLATE)
    sweep = f"parts.rod.thickness = 7.4..8.7 mm : {count}"
    request = Request((str(file),), ("accuracy=10 %",), (sweep,), fidelity="swept")
    rates: dict[int, list[float]] = {1: [], 2: []}
    tables = set()
    for turn in range(rounds):
        for workers in rates:
            out = folder / f"{turn}_{workers}"
            plan = planned(request, out, False)
            watch, _ = run(plan, out, Settings(workers, None))
            spent = watch.ends[-1] - watch.ends[workers - 1]
            rates[workers].append((count - workers) / spent * 3600)
            tables.add((out / "results.csv").read_bytes())
    ratios = [two / one for one, two in zip(*rates.values(), strict=True)]
    return {
        "variants": count,
        "an hour by one": rates[1],
        "an hour by two": rates[2],
        "two over one": ratios,
        "same tables": len(tables) == 1,
    }


def memory(folder: Path, count: int) -> dict[str, float]:
    """Largest worker and parent in the first and the last tenth of many formula designs."""
    sweep = f"parts.bar_upper.wall = 5..7 mm : {count}"
    plan = planned(Request((str(PRESS),), (), (sweep,), fidelity="formula"), folder, False)
    watch, _ = run(plan, folder, Settings(1, None))
    with (folder / "timings.csv").open(encoding="utf-8", newline="") as rows:
        peaks = [int(row["peak_memory_bytes"]) for row in csv.DictReader(rows)]
    tenth = max(count // 10, 1)
    return {
        "designs": count,
        "worker, last over first tenth": max(peaks[-tenth:]) / max(peaks[:tenth]),
        "parent, MiB a design": (watch.sizes[-1] - watch.sizes[tenth]) / (count - tenth) / 2**20,
    }


def main() -> None:
    """Measure what is asked for."""
    what = sys.argv[1] if len(sys.argv) > 1 else "overhead"
    usual = {"press": 100, "swept": 60, "memory": 1000}
    count = int(sys.argv[2]) if len(sys.argv) > 2 else usual.get(what, 0)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        measure = {
            "overhead": lambda: overhead(folder),
            "press": lambda: press(folder, count),
            "swept": lambda: swept(folder, count),
            "memory": lambda: memory(folder, count),
        }[what]
        print(json.dumps(measure(), indent=1))


if __name__ == "__main__":
    main()
