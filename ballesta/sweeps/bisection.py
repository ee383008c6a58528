"""Threshold of a check along one input, by bisection, and the largest value of a number.

Bisection needs an input of which more is safer all along the range, or less: that is looked at, at
both ends and at values spread between them, and where it is not so no value is given.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil, isfinite
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


def smallest_passing(
    check: Callable[[float], Status | None],
    low: float,
    high: float,
    *,
    tolerance: float = TOLERANCE,
    step: float | None = None,
    probes: int = PROBES,
) -> Search[float]:
    """Return the smallest number that passes, or the largest where smaller numbers are safer.

    tolerance  of the result, as a share of the range; it is `beyond` less `found` at the most
    step       instead of it: only low, low + step, ... up to high are tried

    >>> smallest_passing(lambda x: Status.PASS if x > 2 else Status.FAIL, 0, 4, step=1).found
    3.0
    """
    if not (isfinite(low) and isfinite(high) and low < high):
        raise ValueError(f"a range goes from the smaller to the larger, got {low} to {high}")
    if step is not None:
        tolerance = step / (high - low)
    if not 0 < tolerance <= 1:
        raise ValueError(f"tolerance or step must be above 0 and within the range, got {tolerance}")
    count = ceil(1 / tolerance - 1e-9)
    if step is not None and abs(count * step - (high - low)) > 1e-9 * (high - low):
        raise ValueError(f"steps of {step} from {low} do not end at {high}")
    numbers = [low + (high - low) * k / count for k in range(count)] + [float(high)]
    return search_passing(check, numbers, probes=probes)


def greatest(
    value: Callable[[float], float | None],
    low: float,
    high: float,
    *,
    tolerance: float = TOLERANCE,
    probes: int = 16,
) -> tuple[float, float] | None:
    """Return where a value is greatest, and that value; None where it is allowed nowhere.

    value      a number, or None where what is asked of the design does not hold
    tolerance  of the place, as a share of the range
    probes     evenly spread over the range; the greatest lies next to the best of them if the value
               rises and falls no more than once between each two

    Golden section between the neighbours of the best probe; also finds a greatest value at the edge
    of what is allowed.
    """
    if not (isfinite(low) and isfinite(high) and low < high and 0 < tolerance < 1 and probes > 1):
        raise ValueError(f"wrong range {low} to {high}, tolerance {tolerance} or probes {probes}")
    width = (high - low) / (probes - 1)
    best: tuple[float, float] | None = None
    for k in range(probes):
        place = high if k == probes - 1 else low + k * width
        found = value(place)
        if found is not None and (best is None or found > best[1]):
            best = place, found
    if best is None:
        return None
    left, right = max(low, best[0] - width), min(high, best[0] + width)
    share = (3 - 5**0.5) / 2
    while right - left > tolerance * (high - low):
        to_right = right - best[0] > best[0] - left
        place = best[0] + share * ((right if to_right else left) - best[0])
        found = value(place)
        if found is not None and found > best[1]:
            left, right = (best[0], right) if to_right else (left, best[0])
            best = place, found
        else:
            left, right = (left, place) if to_right else (place, right)
    return best
