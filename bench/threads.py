"""Seconds of a factorisation and of 24 solves by number of unknowns and threads.

python -m bench.threads [RUNS]   prints a line of JSON per size: wall and processor seconds

The toggle bar of the press at five finenesses; the least of RUNS (3) runs in turns. CHOLMOD's own
team is off throughout, as `fem.threads` has it.
"""

import json
import os
import sys
from collections.abc import Callable
from time import perf_counter, process_time
from typing import Any

FINENESSES = (0.15, 0.34, 0.6, 1.1, 1.87)  # 6 000 to 570 000 unknowns
COLUMNS = 24


def stiffness_of(fineness: float) -> tuple[Any, Any]:
    """Upper triangle of the bar's stiffness without its supports, and the order of its unknowns."""
    import fem.unit_solutions as solving
    from bench.solid import bar, elastic
    from geometry.meshing import mesh_shape

    class Taken(Exception):
        """The matrix is there: nothing need be solved."""

    found: dict[str, Any] = {}

    def take(upper: Any, *_: Any, place: Any = None) -> None:
        found.update(upper=upper, place=place)
        raise Taken

    factorize, solving.factorize = solving.factorize, take
    try:
        solving.solve_unit_loads(mesh_shape(bar(), fineness=fineness), elastic())
    except Taken:
        return found["upper"], found["place"]
    finally:
        solving.factorize = factorize
    raise AssertionError("nothing was factorised")


def measured(upper: Any, place: Any, runs: int) -> dict[str, list[float]]:
    """Least wall and processor seconds of factorisation and solves by number of threads."""
    import numpy as np

    import fem.solvers
    import fem.threads
    from fem.solvers import factorize

    right = np.random.default_rng(0).standard_normal((upper.shape[0], COLUMNS))
    times: dict[str, list[list[float]]] = {}
    fem.threads.LARGE = fem.solvers.LARGE = 0
    for _ in range(runs):
        for threads in [n for n in (1, 2, 4) if n <= (os.cpu_count() or 1)]:
            os.environ[fem.threads.OWN] = str(threads)
            factor, factorising = _timed(lambda: factorize(upper, place=place))
            _, solving = _timed(lambda factor=factor: factor.apply(right))
            row = [*factorising, *solving]
            times.setdefault(str(threads), []).append(row)
    return {
        n: [round(min(column), 3) for column in zip(*rows, strict=True)]
        for n, rows in times.items()
    }


def _timed(work: Callable[[], Any]) -> tuple[Any, tuple[float, float]]:
    """An answer, and its wall and processor seconds."""
    wall, processor = perf_counter(), process_time()
    answer = work()
    return answer, (perf_counter() - wall, process_time() - processor)


def main(arguments: list[str]) -> None:
    """Measure every size."""
    runs = int(arguments[0]) if arguments else 3
    for fineness in FINENESSES:
        upper, place = stiffness_of(fineness)
        print(json.dumps({"unknowns": upper.shape[0], **measured(upper, place, runs)}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
