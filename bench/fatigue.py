"""The fatigue verdict of a part over 720 positions, against what the part's solution costs.

`python -m bench.fatigue` prints everything as a line of JSON; the other commands are its children:
verdict, passes, memory, pylife. The part is the lug bar of bench/solid.py under the press' cycle,
and under a cycle out of phase at nearly every point, which no press has.
"""

import importlib.util
import json
import os
import pickle
import resource
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

from bench.solid import FINENESS, THREADS, elastic
from bench.solid import python as solid

RUNS = 5
ENDURANCE, ULTIMATE = 200.0, 500.0  # MPa
POINTS, CYCLES = 30_000, 8  # of the duty that pyLife judges too
HISTORY = "history.npz"


def python(*arguments: str, threads: str = THREADS) -> dict[str, Any]:
    """The last line's JSON of one of this module's commands."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    done = subprocess.run(
        [sys.executable, "-m", "bench.fatigue", *arguments],
        env={**os.environ, **dict.fromkeys(names, threads)},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answer


def seconds_of(work: Callable[..., Any], *arguments: Any, **named: Any) -> tuple[float, Any]:
    """How long something takes, and its answer."""
    start = perf_counter()
    answer = work(*arguments, **named)
    return perf_counter() - start, answer


def out_of_phase(coefficients: Any) -> Any:
    """Each unit load a quarter of the cycle later than the one before it.

    Both pins of the bar have a multiple of four unit loads, so the same one of both moves alike.
    """
    import numpy as np

    quarter = coefficients.shape[1] // 4
    return np.stack([np.roll(row, quarter * i) for i, row in enumerate(coefficients)])


def one_product_per_point(basis: Any, coefficients: Any) -> None:
    """The stress histories, rebuilt in blocks as the package itself does: stacked products."""
    from fatigue.stress_path import point_blocks

    for block in point_blocks(len(basis), 6 * coefficients.shape[1]):
        basis[block] @ coefficients


def one_product_per_block(basis: Any, coefficients: Any) -> None:
    """The same blocks as one matrix each, into memory that stays: the quickest way in numpy."""
    import numpy as np

    from fatigue.stress_path import point_blocks

    n_basis, n_positions = coefficients.shape
    blocks = list(point_blocks(len(basis), 6 * n_positions))
    room = np.empty((6 * blocks[0].stop, n_positions))
    for block in blocks:
        rows = basis[block].reshape(-1, n_basis)
        np.matmul(rows, coefficients, out=room[: len(rows)])


def middles(runs: list[dict[str, float]]) -> dict[str, Any]:
    """The median of each number over the runs."""
    return {name: statistics.median(run[name] for run in runs) for name in runs[0]}


def verdict(folder: Path) -> dict[str, Any]:
    """Solution and verdict in one process, in turns; medians of times and of each turn's ratios."""
    import numpy as np

    import fatigue.verdict as judging
    import fem.unit_solutions as solving
    from fatigue import ductile_verdict, findley_criterion, path_bounds
    from fem.threads import keep_freed_memory

    keep_freed_memory()  # as `ballesta check` does
    spent = {"solution": 0.0, "search": 0.0}

    def timed(stage: str, work: Any) -> Any:
        def run(*arguments: Any, **named: Any) -> Any:
            seconds, answer = seconds_of(work, *arguments, **named)
            spent[stage] += seconds
            return answer

        return run

    # nothing else of the solution counts: no assembly, no order of elimination, no stress
    solving.factorize = timed("solution", solving.factorize)
    solving._solve_held = timed("solution", solving._solve_held)
    judging.critical_plane = timed("search", judging.critical_plane)
    mesh = pickle.loads((folder / "mesh.pickle").read_bytes())
    wrenches, accelerations = pickle.loads((folder / "loads.pickle").read_bytes())
    k = findley_criterion().k
    strengths = (ENDURANCE, ULTIMATE)
    governing = {"every_point": False}  # as `ballesta check` asks

    runs: list[dict[str, float]] = []
    for _ in range(RUNS):
        spent["solution"] = 0.0
        solutions = solving.solve_unit_loads(mesh, elastic())
        basis = solutions.basis
        coefficients, _ = solutions.coefficients(wrenches, accelerations)
        del solutions
        apart = out_of_phase(coefficients)
        run = {"solution": spent["solution"]}
        cycle = (basis, coefficients)
        run["verdict"], result = seconds_of(ductile_verdict, *cycle, *strengths, **governing)
        run["every point"], whole = seconds_of(ductile_verdict, *cycle, *strengths)
        run["first pass"], _ = seconds_of(path_bounds, *cycle, k)
        spent["search"] = 0.0
        run["apart"], round_ = seconds_of(ductile_verdict, basis, apart, *strengths, **governing)
        run["apart search"] = spent["search"]
        for name in ("verdict", "every point", "apart"):
            run[f"{name} over solution"] = run[name] / run["solution"]
        assert abs(result.safety / whole.safety - 1.0) < 1e-12
        runs.append(run)
    np.savez(folder / HISTORY, basis=basis, cycle=coefficients, apart=apart)
    return middles(runs) | {
        "points": len(basis),
        "positions": coefficients.shape[1],
        "unit loads": len(coefficients),
        "searched": result.n_searched,
        "apart searched": round_.n_searched,
        "proportional": float(result.proportional.mean()),
        "apart proportional": float(round_.proportional.mean()),
        "criteria": [result.criterion, round_.criterion],
    }


def passes(folder: Path) -> dict[str, Any]:
    """The first pass and the products in turns; for one thread, as the pass has little to share."""
    import numpy as np

    from fatigue import findley_criterion, path_bounds

    with np.load(folder / HISTORY) as file:
        cycle = (file["basis"], file["cycle"])
    runs: list[dict[str, float]] = []
    for _ in range(RUNS):
        run = {"bounds": seconds_of(path_bounds, *cycle, findley_criterion().k)[0]}
        for name, product in (
            ("by point", one_product_per_point),
            ("by block", one_product_per_block),
        ):
            run[name], _ = seconds_of(product, *cycle)
            run[f"first pass over {name}"] = run["bounds"] / run[name]
        runs.append(run)
    return middles(runs)


def memory(folder: Path, which: str) -> dict[str, Any]:
    """GiB that the verdict takes beyond its arguments: its peak, over what was in use before."""
    import numpy as np

    from fatigue import ductile_verdict

    with np.load(folder / HISTORY) as file:
        basis, coefficients = file["basis"], file[which]
    in_use = int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()
    ductile_verdict(basis, coefficients, ENDURANCE, ULTIMATE, every_point=False)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    return {"memory": (peak - in_use) / 2**30}


def pylife() -> dict[str, Any]:
    """FKM's line of mean stress and Miner's sum, by us and by pyLife, on the same arrays.

    pyLife gets its table ready and flat, its quickest form, and sums the cycles of a point as an
    array. Up to R = 0.5 both mean the same line. Nothing where pyLife is not installed.
    """
    if importlib.util.find_spec("pylife") is None:
        print("pyLife is not installed: it is not compared with", file=sys.stderr)
        return {}
    import numpy as np
    import pandas as pd
    from pylife.strength import Fatigue
    from pylife.strength.meanstress import HaighDiagram
    from pylife.stress.collective import LoadCollective

    from fatigue import SNCurve, fkm_factor, miner_damage

    rng = np.random.default_rng(0)
    shape = (POINTS, CYCLES)
    amplitude, counts = rng.uniform(20.0, 300.0, shape), rng.uniform(1.0, 1e5, shape)
    mean = amplitude * rng.uniform(-3.0, 3.0, shape)
    curve = SNCurve(120.0, 2e6, 5.0).below_knee("haibach")
    table = pd.DataFrame(
        {"range": 2.0 * amplitude.ravel(), "mean": mean.ravel(), "cycles": counts.ravel()}
    )
    diagram = HaighDiagram.fkm_goodman(pd.Series({"M": 0.3}))
    strength = Fatigue(pd.Series({"SD": 120.0, "ND": 2e6, "k_1": 5.0, "k_2": 9.0}))

    def ours() -> Any:
        return miner_damage(amplitude / fkm_factor(amplitude, mean, 0.3), counts, curve)

    def theirs() -> Any:
        damage = strength.damage(LoadCollective(diagram.transform(table, -1.0)))
        return damage.to_numpy().reshape(shape).sum(axis=1)

    apart = float(np.abs(ours() / theirs() - 1.0).max())
    assert apart < 1e-9, apart
    runs = []
    for _ in range(RUNS):
        run = {"ours": seconds_of(ours)[0], "theirs": seconds_of(theirs)[0]}
        runs.append(run | {"ours over theirs": run["ours"] / run["theirs"]})
    return middles(runs)


def measure() -> dict[str, Any]:
    """Everything, each in a process of its own."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        solid("prepare", str(folder), str(FINENESS))
        result = python("verdict", str(folder))
        result |= python("passes", str(folder), threads="1")
        for which in ("cycle", "apart"):
            result[f"{which} memory"] = python("memory", str(folder), which)["memory"]
        result["pylife"] = python("pylife")
        return result


def main(arguments: list[str]) -> None:
    """Run a command of this module; without one, everything."""
    if not arguments:
        answer = measure()
    elif arguments[0] == "verdict":
        answer = verdict(Path(arguments[1]))
    elif arguments[0] == "passes":
        answer = passes(Path(arguments[1]))
    elif arguments[0] == "memory":
        answer = memory(Path(arguments[1]), arguments[2])
    else:
        answer = pylife()
    print(json.dumps(answer))


if __name__ == "__main__":
    main(sys.argv[1:])
