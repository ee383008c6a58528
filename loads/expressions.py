"""Forces that a formula over coordinates of the linkage and their rates gives.

A formula is a tree of numbers, coordinates and functions, in units that go together. It has no
function that jumps: a force that jumps is one against the motion, or another phase's. Where `abs`,
`min` and `max` change over, the force has a kink: `kinks` says where, so that a position stands
there. Where it would divide by nothing on the way it is refused, as no grid of positions sees a
pole between two of them.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import reduce
from itertools import combinations

import numpy as np

from loads.bodies import FloatArray, LinkageError
from loads.joints import Coordinate
from loads.kinematics import dot
from loads.motion import Motion


@dataclass(frozen=True)
class Number:
    """A number, in units that go together."""

    value: float


@dataclass(frozen=True)
class Reading:
    """A coordinate [mm, rad], or its rate in time [mm/s, rad/s]."""

    coordinate: Coordinate
    rate: bool = False


@dataclass(frozen=True)
class Apply:
    """A function of `FUNCTIONS` of other terms."""

    function: str
    terms: "tuple[Term, ...]"


Term = Number | Reading | Apply

FUNCTIONS: dict[str, tuple[Callable[..., FloatArray], int, int]] = {  # and how many terms
    "+": (np.add, 2, 2),
    "-": (np.subtract, 2, 2),
    "*": (np.multiply, 2, 2),
    "/": (np.divide, 2, 2),
    "**": (np.power, 2, 2),
    "sqrt": (np.sqrt, 1, 1),
    "exp": (np.exp, 1, 1),
    "log": (np.log, 1, 1),
    "sin": (np.sin, 1, 1),
    "cos": (np.cos, 1, 1),
    "tan": (np.tan, 1, 1),
    "asin": (np.arcsin, 1, 1),
    "acos": (np.arccos, 1, 1),
    "atan": (np.arctan, 1, 1),
    "abs": (np.abs, 1, 1),
    "min": (lambda *values: reduce(np.minimum, values), 2, 8),
    "max": (lambda *values: reduce(np.maximum, values), 2, 8),
}


@dataclass(frozen=True)
class Expression:
    """A force by a formula [N, N mm].

    text  the formula as people wrote it, for messages
    """

    text: str
    term: Term


def expressed(motion: Motion, name: str, law: Expression) -> FloatArray:
    """Return the value of a force by a formula (n,), N or N mm.

    Raises LinkageError where it is no finite number, and where it divides by something that passes
    through nothing within the motion.
    """
    owner = f"force {name!r}: {law.text}"
    for coordinate in _coordinates(law.term):
        motion.kinematics.linkage.check_coordinate(coordinate, owner)
    for below in _divisors(law.term):
        values = _value(motion, below)
        if values.min() <= 0.0 <= values.max():
            k = int(np.argmin(np.abs(values)))
            raise LinkageError(f"{owner} divides by nothing at or near {motion.place(k)}")
    values = _value(motion, law.term)
    if not np.isfinite(values).all():
        k = int(np.argmin(np.isfinite(values)))
        raise LinkageError(f"{owner} is no finite number at {motion.place(k)}")
    return values


def kinks(motion: Motion, law: Expression) -> FloatArray:
    """Return functions (m, n) of the motion whose roots are where a formula has its kinks."""
    found = [_value(motion, term) for term in _switches(law.term)]
    return np.array(found).reshape(len(found), len(motion.values))


def _value(motion: Motion, term: Term) -> FloatArray:
    n = len(motion.values)
    match term:
        case Number(value):
            return np.full(n, value)
        case Reading(coordinate, True):
            gradient = motion.kinematics.gradient(coordinate, motion.poses)
            return dot(gradient, motion.velocities.reshape(n, -1))
        case Reading(coordinate):
            return motion.kinematics.value(coordinate, motion.poses)
        case Apply(function, terms):
            with np.errstate(all="ignore"):
                found = FUNCTIONS[function][0](*(_value(motion, part) for part in terms))
            return np.asarray(found, dtype=float)


def _parts(term: Term) -> Iterator[Term]:
    """A term and all within it."""
    yield term
    if isinstance(term, Apply):
        for part in term.terms:
            yield from _parts(part)


def _coordinates(term: Term) -> list[Coordinate]:
    return [part.coordinate for part in _parts(term) if isinstance(part, Reading)]


def _divisors(term: Term) -> Iterator[Term]:
    """Divisors of a formula: also below a power under 0, and the cosine of a tangent."""
    for part in _parts(term):
        match part:
            case Apply("/", (_, below)):
                yield below
            case Apply("**", (base, Number(power))) if power < 0.0:
                yield base
            case Apply("tan", terms):
                yield Apply("cos", terms)
            case _:
                pass


def _switches(term: Term) -> Iterator[Term]:
    """Terms whose sign decides which branch of abs, min and max holds."""
    for part in _parts(term):
        match part:
            case Apply("abs", (inner,)):
                yield inner
            case Apply("min" | "max", terms):
                yield from (Apply("-", pair) for pair in combinations(terms, 2))
            case _:
                pass
