"""Laws of given forces: constant, a table, a formula, against the motion, or a contact.

A formula gives a force over coordinates of the linkage and their rates. It is a tree of numbers,
coordinates and functions, in units that go together. It has no function that jumps: a force that
jumps is one against the motion, or another phase's. Where `abs`, `min` and `max` change over, the
force has a kink, and may have a narrow peak where what stands in another bent function, under a
power or below a division has its own, or between two smooth steps: `kinks`, `crests` and `steps`
say where, so that a position stands there. Where it would divide by nothing on the way it is
refused, as no grid of positions sees a pole between two of them.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import reduce
from itertools import combinations, pairwise
from math import isfinite

import numpy as np

from loads.blow_force import Struck
from loads.bodies import Angle, Coordinate, FloatArray, LinkageError
from loads.kinematics import dot
from loads.motion import Motion

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


@dataclass(frozen=True)
class Expression:
    """A force by a formula [N, N mm].

    text  the formula as people wrote it, for messages
    """

    text: str
    term: Term

    @property
    def turned(self) -> list[str]:
        """Bodies whose angles, not their rates, it has."""
        read = [part for part in _parts(self.term) if isinstance(part, Reading) and not part.rate]
        angles = [part.coordinate for part in read if isinstance(part.coordinate, Angle)]
        return list(dict.fromkeys(angle.body for angle in angles))


@dataclass(frozen=True)
class Table:
    """A force tabled over a coordinate, linear between the points; it must cover the phase.

    values  mm or rad of the coordinate, rising
    forces  N or N mm, one for each value
    """

    coordinate: Coordinate
    values: tuple[float, ...]
    forces: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.values) < 2 or len(self.values) != len(self.forces):
            raise LinkageError(
                "a table needs as many forces as values and at least two, got "
                f"{len(self.values)} values and {len(self.forces)} forces"
            )
        if not all(isfinite(number) for number in (*self.values, *self.forces)):
            raise LinkageError("a table holds finite numbers only")
        for before, after in pairwise(self.values):
            if after <= before:
                raise LinkageError(f"the values of a table must rise: {before:g}, then {after:g}")


@dataclass(frozen=True)
class Contact:
    """A one-sided spring along the force's own coordinate: it pushes, and never pulls.

    at         mm or rad, value of the force's coordinate where an undeformed linkage touches
    stiffness  N/mm (N mm/rad) of what is touched; None is rigid, then the linkage must be elastic
    side       1: touches below `at` and pushes the coordinate up; -1: above, and down
    stops      the body that is pushed follows the contact while it touches: stopped by a rigid one,
               slowed by one that gives way less than the linkage. Only a body that slides can be.
    restitution  speed after over speed before a blow; None: not known. Blows alone know it.
    struck     how the workpiece answers to a blow; None: the force of a blow is not wanted
    """

    at: float
    stiffness: float | None = None
    side: int = 1
    stops: bool = True
    restitution: float | None = None
    struck: Struck | None = None

    def __post_init__(self) -> None:
        if not isfinite(self.at):
            raise LinkageError(f"a contact must be at a finite value, got {self.at:g}")
        if self.stiffness is not None and not (isfinite(self.stiffness) and self.stiffness > 0.0):
            raise LinkageError(f"the stiffness of a contact must be above 0, got {self.stiffness}")
        if self.side not in (1, -1):
            raise LinkageError(f"the side of a contact must be 1 or -1, got {self.side}")
        if self.restitution is not None and not 0.0 <= self.restitution <= 1.0:
            raise LinkageError(f"restitution goes from 0 to 1, got {self.restitution:g}")


@dataclass(frozen=True)
class Opposing:
    """A force against the rate of its own coordinate: dry, viscous, or along a table.

    dry      N (N mm), at any speed
    viscous  N s/mm (N mm s/rad), times the speed, besides
    speeds   mm/s (rad/s), rising from 0: instead of both, linear between; it must cover the motion
    forces   N (N mm), one for each speed

    It jumps where the coordinate reverses: `split_cycle` makes that the border of a phase.
    """

    dry: float = 0.0
    viscous: float = 0.0
    speeds: tuple[float, ...] = ()
    forces: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        sizes = (self.dry, self.viscous, *self.forces)
        if not all(isfinite(size) and size >= 0.0 for size in sizes):
            raise LinkageError(f"a force against the motion must be 0 or above, got {min(sizes):g}")
        if not self.speeds and not self.forces:
            return
        if self.dry or self.viscous:
            raise LinkageError("a table over the speed stands alone, without dry and viscous")
        if len(self.speeds) < 2 or len(self.speeds) != len(self.forces):
            raise LinkageError(
                "a table over the speed needs as many forces as speeds and at least two, got "
                f"{len(self.speeds)} speeds and {len(self.forces)} forces"
            )
        if self.speeds[0] != 0.0 or not isfinite(self.speeds[-1]):
            raise LinkageError(f"the speeds of a table must begin at 0, got {self.speeds[0]:g}")
        for before, after in pairwise(self.speeds):
            if after <= before:
                raise LinkageError(f"the speeds of a table must rise: {before:g}, then {after:g}")


Law = float | Table | Expression | Opposing | Contact


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


_BENT = ("**", "exp", "log", "sqrt", "atan", "asin", "acos")


def kinks(motion: Motion, law: Expression) -> FloatArray:
    """Return functions (m, n) of the motion whose roots are where a formula has its kinks."""
    return _values(motion, _switches(law.term))


def steps(motion: Motion, law: Expression) -> FloatArray:
    """Return functions (m, n) whose roots are where a formula may step, and between two steps."""
    return _values(motion, _steps(law.term))


def crests(motion: Motion, law: Expression) -> FloatArray:
    """Return functions (m, n) whose extremes are where a formula may have peaks, however narrow."""
    return _values(motion, _inner(law.term))


def _values(motion: Motion, terms: Iterable[Term]) -> FloatArray:
    found = [_value(motion, term) for term in terms]
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


def _steps(term: Term) -> Iterator[Term]:
    """Terms that are 0 where a smooth step is half way, and half way between two steps."""
    inner = [
        part.terms[0]
        for part in _parts(term)
        if isinstance(part, Apply) and part.function in ("exp", "atan")
    ]
    yield from inner
    for pair in combinations(inner, 2):
        yield from (Apply(sign, pair) for sign in "+-")


def _inner(term: Term) -> Iterator[Term]:
    """Terms in bent functions, under powers and below divisions: wide where these are narrow."""
    for part in _parts(term):
        match part:
            case Apply(function, (inner, *_)) if function in _BENT:
                yield inner
            case Apply("/", (_, inner)):
                yield inner
            case _:
                pass
