"""The main job as a user has it: `ballesta check` of the toggle press, whole processes.

python -m bench.main_job installed [PAIRS]   as installed over OMP_THREAD_LIMIT=1
                                             OPENBLAS_NUM_THREADS=1, idle and beside four busy loops
python -m bench.main_job peer [PAIRS]        verdict and all files over one static step of CalculiX
                                             on 170 000 unknowns, one thread each
python -m bench.main_job short [RUNS]        formula check, loads and import, s, and over an import
                                             of the libraries, by the clock and of processors
python -m bench.main_job batch N [ROUNDS]    a batch of N workers over N independent runs

Prints a line of JSON: medians, and the ratio of each pair, whose runs follow each other at once.
"""

import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import Any

ROOT = Path(__file__).parents[1]
PRESS = ROOT / "designs" / "toggle_press.toml"
BALLESTA = (sys.executable, "-m", "ballesta")
BOUND = {"OMP_THREAD_LIMIT": "1", "OPENBLAS_NUM_THREADS": "1"}
ONE = {**BOUND, "OMP_NUM_THREADS": "1"}
_LIBRARIES = "import scipy.interpolate, scipy.optimize, gmsh, jinja2, meshio, matplotlib.figure"
# the verdict is there
_TOLD_AFTER = ("seeking single changes", "encoding the fields", "writing the report")


def environment(**stated: str) -> dict[str, str]:
    """The environment, with nothing about threads but what is stated."""
    kept = {k: v for k, v in os.environ.items() if not k.endswith(("_THREADS", "_THREAD_LIMIT"))}
    return kept | stated


def check(stated: dict[str, str], *options: str) -> tuple[float, float]:
    """Seconds of a check of the press from the start of its process: to the verdict, to the end."""
    with tempfile.TemporaryDirectory() as out:
        start = perf_counter()
        process = subprocess.Popen(
            [*BALLESTA, "check", str(PRESS), "--out", out, *options],
            env=environment(**stated), cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
            text=True,
        )  # fmt: skip
        assert process.stderr is not None
        verdict = 0.0
        for line in process.stderr:
            if not verdict and any(words in line for words in _TOLD_AFTER):
                verdict = perf_counter() - start
        if process.wait() not in (0, 1) or not verdict:
            raise RuntimeError(f"the check ended with exit code {process.returncode}")
        return verdict, perf_counter() - start


def _middle(rows: Sequence[Sequence[float]]) -> list[float]:
    return [round(statistics.median(column), 3) for column in zip(*rows, strict=True)]


@contextmanager
def busy(count: int) -> Iterator[None]:
    """Loops that take a processor each."""
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def installed(pairs: int) -> dict[str, Any]:
    """Whole checks as installed, over the same with one thread by the environment."""
    found = {}
    for name, loops in (("idle", 0), ("beside four busy loops", 4)):
        ratios, times = [], []
        with busy(loops):
            check({})  # files are read
            for k in range(pairs):
                one, other = ({}, BOUND) if k % 2 else (BOUND, {})
                first, second = check(one), check(other)
                ours, theirs = (first, second) if k % 2 else (second, first)
                ratios.append([a / b for a, b in zip(ours, theirs, strict=True)])
                times.append([*ours, *theirs])
        found[name] = {
            "verdict and all files over bound": _middle(ratios),
            "pairs": [[round(x, 3) for x in row] for row in ratios],
            "seconds, as installed and bound": _middle(times),
        }
    return found


def peer(pairs: int) -> dict[str, Any]:
    """Verdict and all files of the press over one static step of CalculiX."""
    from bench.solid import FINENESS

    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        command = (
            sys.executable,
            "-m",
            "bench.solid",
            "prepare",
            temporary,
            str(FINENESS),
            "decks",
        )
        subprocess.run(command, env=environment(), cwd=ROOT, check=True, stdout=subprocess.PIPE)
        rows, ratios = [], []
        for _ in range(pairs):
            ours = check(ONE)
            start = perf_counter()
            done = subprocess.run(
                ("ccx", "one"), cwd=folder, env=environment(**ONE), check=True, text=True,
                stdout=subprocess.PIPE,
            )  # fmt: skip
            theirs = perf_counter() - start
            if "Job finished" not in done.stdout:
                raise RuntimeError("CalculiX did not finish")
            rows.append([*ours, theirs])
            ratios.append([seconds / theirs for seconds in ours])
        version = next(line for line in done.stdout.splitlines() if "Version" in line)
    return {
        "peer": version.strip(" *") + ", SPOOLES, one thread",
        "seconds: verdict, all files, CalculiX": _middle(rows),
        "verdict and all files over CalculiX": _middle(ratios),
        "pairs": [[round(x, 3) for x in row] for row in ratios],
    }


def short(runs: int) -> dict[str, Any]:
    """Seconds of what must answer at once, by the clock and of processors, as installed.

    The least is the work, the median what a user has; all over an import of some libraries, in
    turns, which tells how fast the machine is.
    """
    with tempfile.TemporaryDirectory() as out:
        ours = (sys.executable, "-m", "ballesta")
        commands = {
            "check --fidelity formula": (
                *ours, "check", str(PRESS), "--fidelity", "formula", "--out", out,
            ),
            "loads": (*ours, "loads", str(PRESS)),
            "import ballesta": (sys.executable, "-c", "import ballesta"),
            "libraries": (sys.executable, "-c", _LIBRARIES),
        }  # fmt: skip
        times: dict[str, list[tuple[float, float]]] = {name: [] for name in commands}
        for _ in range(runs + 1):
            for name, command in commands.items():
                start, before = perf_counter(), _processor_seconds()
                subprocess.run(command, cwd=ROOT, env=environment(), capture_output=True)
                times[name].append((perf_counter() - start, _processor_seconds() - before))
    return {
        name: {
            "least": _each(min, row[1:]),
            "median": _each(statistics.median, row[1:]),
            "over libraries": _each(
                statistics.median,
                [
                    (one[0] / other[0], one[1] / other[1])
                    for one, other in zip(row[1:], times["libraries"][1:], strict=True)
                ],
            ),
        }
        for name, row in times.items()
    }


def _processor_seconds() -> float:
    """Processor seconds of ended children; a process that was killed counts, too."""
    spent = os.times()
    return spent.children_user + spent.children_system


def _each(of: Callable[[list[float]], float], rows: Sequence[tuple[float, float]]) -> list[float]:
    """By the clock and of processors."""
    return [round(of(list(column)), 3) for column in zip(*rows, strict=True)]


def batch(workers: int, rounds: int) -> dict[str, Any]:
    """Throughput of N workers of a batch over N runs side by side that know nothing of each other.

    Twice as many variants of the press as workers, bars as solids, without reports; the independent
    runs are batches of one worker each, with a share of the same variants.
    """
    each = 2
    values = [5.0 + 0.1 * k for k in range(each * workers)]
    ratios = []
    with tempfile.TemporaryDirectory() as temporary:

        def command(out: Path, some: Sequence[float], jobs: int) -> list[str]:
            sweep = f"parts.bar_upper.wall = {some[0]}..{some[-1]} mm : {len(some)}"
            return [
                *BALLESTA, "batch", str(PRESS), "--out", str(out), "--sweep", sweep, "--jobs",
                str(jobs), "--no-store", "--no-reports",
            ]  # fmt: skip

        def timed(commands: Sequence[Sequence[str]]) -> float:
            start = perf_counter()
            started = [
                subprocess.Popen(
                    c, cwd=ROOT, env=environment(),
                    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                )
                for c in commands
            ]  # fmt: skip
            codes = [process.wait() for process in started]
            if any(code not in (0, 1) for code in codes):
                raise RuntimeError(f"batches ended with {codes}")
            return perf_counter() - start

        for k in range(rounds):
            folder = Path(temporary) / str(k)
            together = timed([command(folder / "all", values, workers)])
            apart = timed(
                [
                    command(folder / str(n), values[each * n : each * (n + 1)], 1)
                    for n in range(workers)
                ]
            )
            ratios.append([apart / together, together, apart])
            shutil.rmtree(folder)
    return {"workers": workers, "throughput over independent runs, s, s": _middle(ratios),
            "rounds": [round(row[0], 3) for row in ratios]}  # fmt: skip


def main(arguments: list[str]) -> None:
    """Run one of the measurements."""
    what, *numbers = arguments
    counts = [int(number) for number in numbers]
    if what == "installed":
        answer = installed(*(counts or [10]))
    elif what == "peer":
        answer = peer(*(counts or [5]))
    elif what == "short":
        answer = short(*(counts or [7]))
    else:
        answer = batch(counts[0], *(counts[1:] or [3]))
    print(json.dumps(answer))


if __name__ == "__main__":
    main(sys.argv[1:])
