"""Threshold of a check along one input, by bisection, and the largest value of a number.

Bisection needs an input of which more is safer all along the range, or less: that is looked at, at
both ends and at values spread between them, and where it is not so no value is given.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from checks.result.verdict import Status

T = TypeVar("T")
PROBES = 5
TOLERANCE = 1e-3  # of the range
_ORDER = {None: 0, Status.FAIL: 1, Status.UNDECIDED: 2, Status.PASS: 3}
LARGER, SMALLER = "larger", "smaller"


@dataclass(frozen=True)
class Search(Generic[T]):
    """Result of a search for the value that just passes.

    tried    every value that was checked and its status (None: it cannot be checked), in the order
             of the values
    found    the value at the edge of those that pass; None without one
    beyond   its neighbour, which does not pass; None where every value that was tried passes
    safer    "larger" or "smaller": which values pass; None where the range does not tell
    problem  why no value is found
    """

    tried: tuple[tuple[T, Status | None], ...]
    found: T | None = None
    beyond: T | None = None
    safer: str | None = None
    problem: str = ""


def search_passing(
    check: Callable[[T], Status | None], values: Sequence[T], *, probes: int = PROBES
) -> Search[T]:
    """Return where, along values in their order, a check begins or ceases to pass.

    check   the status of a value, or None where it cannot be checked, which is no pass
    probes  how many values between the ends are looked at, evenly spread, before any bisection

    Statuses of all values that are looked at must be in order (FAIL, UNDECIDED, pass, or the other
    way round), else there is no `found` and `problem` says at which values they are not.
    """
    if len(values) < 2 or probes < 0:
        raise ValueError(f"a search needs two values or more, got {len(values)}, {probes} probes")
    known: dict[int, Status | None] = {}

    def passes(index: int) -> bool:
        if index not in known:
            known[index] = check(values[index])
        return known[index] is Status.PASS

    last = len(values) - 1
    places = sorted({round(k * last / (probes + 1)) for k in range(probes + 2)})
    passing = [index for index in places if passes(index)]
    if not passing:
        return Search(_tried(known, values), problem=f"none of {len(known)} values passes")
    if len(passing) == len(places):
        return Search(_tried(known, values), values[0])
    safer = LARGER if passes(last) else SMALLER
    if _ordered(known, safer):
        if safer == LARGER:
            good = passing[0]
            bad = max(index for index in places if index < good)
        else:
            good = passing[-1]
            bad = min(index for index in places if index > good)
        while abs(good - bad) > 1:
            middle = (good + bad) // 2
            good, bad = (middle, bad) if passes(middle) else (good, middle)
        if _ordered(known, safer):
            return Search(_tried(known, values), values[good], values[bad], safer)
    return Search(
        _tried(known, values), problem="passing does not go one way with this input over its range"
    )


def _ordered(known: dict[int, Status | None], safer: str) -> bool:
    ranks = [_ORDER[known[index]] for index in sorted(known, reverse=safer == SMALLER)]
    return ranks == sorted(ranks)


def _tried(
    known: dict[int, Status | None], values: Sequence[T]
) -> tuple[tuple[T, Status | None], ...]:
    return tuple((values[index], known[index]) for index in sorted(known))
