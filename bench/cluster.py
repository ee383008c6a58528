"""Cost of a cluster beside processes of this machine: a scheduler and two workers on it.

python -m bench.cluster [ROUNDS]    3 rounds of both in turns: ten minutes on two quiet cores

Prints JSON: milliseconds and ratios of one run, medians of the rounds. Starts of interpreters are
not counted. docs/cluster.md is written from it.
"""

import json
import os
import statistics
import sys
import tempfile
from pathlib import Path
from time import process_time
from typing import Any

import psutil

from ballesta.batches.job import run_plain
from ballesta.batches.plan import Request, planned
from ballesta.batches.run import Settings
from bench.batch import PRESS, ROOT, SECONDS, Watch, idle_plan, nothing, run
from tests.ballesta.batches.dask_machines import DaskMachines

WORKERS = 2
FIRST, IDLE, AT_ONCE, DESIGNS = 40, 200, 1000, 12  # jobs: until all have started, and then


def at_once(job: dict[str, Any]) -> dict[str, Any]:
    """A job that ends as soon as it has begun."""
    return nothing(job, 0.0)


def checked(job: dict[str, Any]) -> dict[str, Any]:
    """A design, with the processor time that it took in place of seconds."""
    start = process_time()
    done = run_plain(job)
    return done | {"seconds": process_time() - start}


def idle(folder: Path, settings: Settings) -> float:
    """Milliseconds of a worker's time that a job of 50 ms takes beside its own."""
    watch, _ = run(idle_plan(folder, FIRST + IDLE), folder, settings, "bench.batch:nothing")
    spent = (watch.ends[-1] - watch.ends[FIRST - 1]) * WORKERS
    return 1e3 * (spent - sum(watch.work[FIRST:])) / IDLE


def busiest(folder: Path, settings: Settings, scheduler: psutil.Process) -> dict[str, float]:
    """Processor time per job, in ms, of what there is one of, and jobs a second on this machine."""
    before, mine = sum(scheduler.cpu_times()[:2]), process_time()
    watch, _ = run(idle_plan(folder, AT_ONCE), folder, settings, "bench.cluster:at_once")
    after, mine = sum(scheduler.cpu_times()[:2]), process_time() - mine
    steady = watch.ends[-1] - watch.ends[FIRST - 1]
    return {
        "scheduler ms": 1e3 * (after - before) / AT_ONCE,
        "parent ms": 1e3 * mine / AT_ONCE,
        "jobs/s": (AT_ONCE - FIRST) / steady,
    }


def designs(folder: Path, settings: Settings) -> tuple[float, Watch]:
    """Seconds from the end of the press' first formula designs to the end of the last."""
    sweep = f"parts.bar_upper.wall = 5..7 mm : {DESIGNS}"
    plan = planned(Request((str(PRESS),), (), (sweep,), fidelity="formula"), folder, False)
    watch, _ = run(plan, folder, settings, "bench.cluster:checked")
    return watch.ends[-1] - watch.ends[WORKERS - 1], watch


def measure(folder: Path, rounds: int) -> dict[str, float]:
    """All of it, on this machine and on a cluster of it, in turns."""
    os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    found: dict[str, list[float]] = {}

    def note(values: dict[str, float]) -> None:
        for name, value in values.items():
            found.setdefault(name, []).append(value)

    machines = DaskMachines(folder)
    try:
        for _ in range(WORKERS):
            machines.add_worker()
        scheduler = psutil.Process(machines.scheduler.pid)
        there = Settings(None, None, None, machines.address)
        settings = {"local": Settings(WORKERS, None), "cluster": there}
        for number in range(rounds):
            idles, times = {}, {}
            for name, each in settings.items():
                out = folder / f"{name}_{number}"
                idles[name] = idle(out / "idle", each)
                times[name], watch = designs(out / "designs", each)
                note({
                    f"{name}: ms beside a job": idles[name],
                    f"{name}: s of {DESIGNS} designs": times[name],
                    f"{name}: processor s of a design": statistics.median(watch.work),
                })  # fmt: skip
            note(busiest(folder / f"at_once_{number}", there, scheduler))
            note({
                "ms beside a job, cluster over local": idles["cluster"] / idles["local"],
                "designs, cluster over local": times["cluster"] / times["local"],
            })  # fmt: skip
    finally:
        machines.kill()
    return {name: statistics.median(values) for name, values in found.items()}


def main() -> None:
    """Measure, and say how busy the machine was with other things."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    with tempfile.TemporaryDirectory() as name:
        others = os.getloadavg()[0]
        found = measure(Path(name), rounds)
    told = {"job ms": 1e3 * SECONDS, "workers": WORKERS, "load before": others}
    print(json.dumps(told | found, indent=1))


if __name__ == "__main__":
    main()
