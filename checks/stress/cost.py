"""Expected time and memory of a part's solids, before they are paid for."""

from functools import cache
from time import perf_counter

import numpy as np

from fem.threads import one_thread

# Memory, measured with CHOLMOD (bench/results.json): 137 628 unknowns with 20 unit loads.
_UNKNOWNS, _GIBIBYTES, _MEMORY_EXPONENT = 137_628, 1.3, 1.2

# Processor time, s, of 100 000 unknowns with one thread on a core of 2.3 GHz on which `_trial`
# takes `_TRIAL`: the solids of the press and of the slider-crank, 8 000 to 120 000 unknowns
# (python -m bench.plan_times compares them with a check).
_HUNDRED_THOUSAND = 100_000
_MESH, _SOLVE, _SOLVE_EXPONENT, _JUDGE = 5.0, 4.0, 1.4, 22.0
_TRIAL = 0.0022
_REPORT, _REPORT_OF_A_PART = 2.0, 1.0  # encoding, pictures and page
SECOND_MESH = 1.8  # times the unknowns of the first, as parts of the press need them


def mesh_seconds(unknowns: int) -> float:
    """Estimated time to mesh a part, s."""
    return slowness() * _MESH * unknowns / _HUNDRED_THOUSAND


def solve_seconds(unknowns: int) -> float:
    """Estimated time from a mesh to the stress basis of a part's unit loads, s."""
    return slowness() * _SOLVE * float((unknowns / _HUNDRED_THOUSAND) ** _SOLVE_EXPONENT)


def judging_seconds(unknowns: int) -> float:
    """Estimated time of what follows the solves on the last mesh, s: fatigue, buckling, fields."""
    return slowness() * _JUDGE * unknowns / _HUNDRED_THOUSAND


def solve_gibibytes(unknowns: int) -> float:
    """Estimated memory to solve a part's unit loads, GiB."""
    return float(_GIBIBYTES * (unknowns / _UNKNOWNS) ** _MEMORY_EXPONENT)


def solid_seconds(first: int, second: int) -> float:
    """Estimated time of a part's check on two meshes of so many unknowns, s."""
    each = (mesh_seconds(n) + solve_seconds(n) for n in (first, second))
    return sum(each) + judging_seconds(second)


def check_seconds(first: int) -> float:
    """Estimated time of a part's check once its first mesh is made, of so many unknowns, s."""
    return solid_seconds(first, int(SECOND_MESH * first)) - mesh_seconds(first)


def report_seconds(parts: int) -> float:
    """Estimated time of the pictures and the page of a check of so many parts, s."""
    return slowness() * (_REPORT + _REPORT_OF_A_PART * parts)


@cache
def slowness() -> float:
    """How many times longer this machine takes now than the one of the constants, from a trial.

    The best of four rounds of products, sums and sorts, of 2 ms each.
    """
    with one_thread():
        return min(_trial() for _ in range(4)) / _TRIAL


def _trial() -> float:
    """Time, s, of work such as a solid takes: dense products, gathering, sorting."""
    random = np.random.default_rng(0)
    dense, places = random.random((200, 200)), random.integers(0, 20_000, 50_000)
    values = random.random(20_000)
    start = perf_counter()
    _ = dense @ dense @ dense
    np.bincount(places, values[places], 20_000)
    np.argsort(places)
    values[places].sum()
    return perf_counter() - start
