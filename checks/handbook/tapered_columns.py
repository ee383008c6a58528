"""Lowest buckling force of a column whose section changes along it, with any ends.

State y = (w, t, M, T): deflection, turn of the section, bending moment M = B t', and the force T
across the undeformed axis. With bending stiffness B and shear stiffness S, and Engesser's shear
strain -M'/S (the shear force acts square to the deflected axis):

    w' = c t - c T/S,  t' = M/B,  M' = c T - c F t,  T' = 0,  c = 1/(1 - F/S)

For a hinged, even column this gives F_E/(1 + F_E/S) (Engesser, Z. Architektur- und Ingenieurwesen
35 (1889) 455; Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., 2.17). Every stretch is
solved by the exponential of its matrix, exact for an even one; a taper by Magnus' series to fourth
order (Iserles and Norsett, Phil. Trans. A 357 (1999) 983). The stretches' stiffness matrices count
the critical forces below F by their negative pivots (Wittrick and Williams, Q. J. Mech. Appl. Math.
24 (1971) 263), the stretches being cut until none buckles by itself. So the lowest is never missed.

It is right to 1e-9 for stretches alike, to 1e-6 where their stiffness differs 100 times over short
pieces: round-off of the stiffest.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import inf
from typing import Self

import numpy as np

from checks.handbook.column_counter import GAUSS, SHEARED, ColumnCounter
from geometry.mesh import FloatArray
from geometry.roots import root

_NEAR_SHEARED = 0.9999  # of the ceiling: beyond it the force is bracketed by bisection only
_EXACT = 1e-13  # relative width to which the force is bracketed
_LARGEST = 1e12  # times B/L^2: no column with any freedom carries it


@dataclass(frozen=True)
class ColumnEnd:
    """Support of a column's end.

    turning  N mm/rad, stiffness against turning: 0 a hinge, infinite clamped
    held     True if it is held sideways
    """

    turning: float = 0.0
    held: bool = True

    def __post_init__(self) -> None:
        if not self.turning >= 0:
            raise ValueError(
                f"a column's end must have a stiffness of at least 0 against turning, got "
                f"{self.turning} N mm/rad"
            )

    @property
    def fixings(self) -> tuple[bool, float]:
        """Both, held first."""
        return self.held, self.turning


HINGED = ColumnEnd()
CLAMPED = ColumnEnd(inf)
FREE = ColumnEnd(held=False)


@dataclass(frozen=True, eq=False)
class ColumnShape:
    """A column's stiffness along it, in stretches.

    lengths  (n,)    mm
    bending  (n, 2)  N mm2, E I at the two Gauss points of each stretch
    shear    (n,)    N, G times shear area; infinite: no shear strain
    """

    lengths: FloatArray
    bending: FloatArray
    shear: FloatArray

    def __post_init__(self) -> None:
        count = len(self.lengths)
        shapes = self.lengths.shape, self.bending.shape, self.shear.shape
        if not count or shapes != ((count,), (count, 2), (count,)):
            raise ValueError(
                f"a column needs lengths (n,), bending (n, 2) and shear (n,), n > 0, got {shapes}"
            )
        for name in ("lengths", "bending"):
            values = getattr(self, name)
            if not ((values > 0) & np.isfinite(values)).all():
                raise ValueError(
                    f"a column's {name} must be above 0 and finite, got {values.min()}"
                )
        if not (self.shear > 0).all():
            raise ValueError(f"a column's shear stiffness must be above 0, got {self.shear.min()}")

    @classmethod
    def stepped(
        cls,
        lengths: Sequence[float],
        bending: Sequence[float],
        shear: Sequence[float] | None = None,
    ) -> Self:
        """Even stretches one behind the other: mm, N mm2 and, where there is shear strain, N."""
        size = np.asarray(lengths, dtype=float)
        stiff = np.asarray(bending, dtype=float)
        rigid = np.full(len(size), inf) if shear is None else np.asarray(shear, dtype=float)
        return cls(size, np.stack([stiff, stiff], axis=-1), rigid)

    @classmethod
    def tapered(
        cls, length: float, bending: Callable[[FloatArray], FloatArray], stretches: int = 64
    ) -> Self:
        """A column with the bending stiffness (N mm2) of a function of x (mm) that is smooth."""
        if not length > 0 or stretches < 1:
            raise ValueError(f"a column needs a length and stretches, got {length}, {stretches}")
        size = length / stretches
        middle = (np.arange(stretches) + 0.5) * size
        places = np.stack([middle - GAUSS * size, middle + GAUSS * size], axis=-1)
        values = np.broadcast_to(np.asarray(bending(places), dtype=float), places.shape)
        return cls(np.full(stretches, size), values, np.full(stretches, inf))

    @property
    def length(self) -> float:
        """The whole length, mm."""
        return float(self.lengths.sum())

    def turned(self) -> Self:
        """The column from its other end."""
        return type(self)(self.lengths[::-1], self.bending[::-1, ::-1], self.shear[::-1])

    def followed_by(self, other: Self) -> Self:
        """The two columns, the other one behind."""
        return type(self)(
            np.concatenate([self.lengths, other.lengths]),
            np.concatenate([self.bending, other.bending]),
            np.concatenate([self.shear, other.shear]),
        )

    def over(self, length: float) -> Self:
        """The same stiffness at the same shares of another length, mm."""
        return type(self)(self.lengths * (length / self.length), self.bending, self.shear)


def critical_force(shape: ColumnShape, start: ColumnEnd = HINGED, end: ColumnEnd = HINGED) -> float:
    """Lowest compressive force, N, at which a column buckles elastically.

    Raises ValueError for a column that moves without bending.

    >>> shape = ColumnShape.stepped([1000.0], [2.1e9])
    >>> round(critical_force(shape), 3), round(critical_force(shape, CLAMPED, FREE), 3)
    (20726.169, 5181.542)
    """
    _check_held(start, end)
    return _lowest(tuple(map(tuple, _table(shape).tolist())), start, end)


def least_critical_force(
    shapes: Iterable[ColumnShape], start: ColumnEnd = HINGED, end: ColumnEnd = HINGED
) -> float:
    """The least of the columns' critical forces, N: of those that it leaves straight, no other's.

    Raises ValueError for columns that move without bending.
    """
    least = inf
    for shape in shapes:
        counter = _counter(shape, start, end)
        share = least / counter.unit
        if share >= counter.ceiling or counter.below(share):
            least = min(least, critical_force(shape, start, end))
    return least


def _table(shape: ColumnShape) -> FloatArray:
    """Stretches (m, 4) as `ColumnCounter` has them."""
    return np.column_stack([shape.lengths, shape.bending, shape.shear])


def _counter(shape: ColumnShape, start: ColumnEnd, end: ColumnEnd) -> ColumnCounter:
    _check_held(start, end)
    return ColumnCounter(_table(shape), (start.fixings, end.fixings))


@lru_cache(maxsize=1024)
def _lowest(stretches: tuple[tuple[float, ...], ...], start: ColumnEnd, end: ColumnEnd) -> float:
    """Lowest critical force, N, of stretches (length, two bending stiffnesses, shear stiffness).

    A design asks for the same column once for each section and plane that it is judged in.
    """
    counter = ColumnCounter(np.array(stretches), (start.fixings, end.fixings))
    ceiling = counter.ceiling
    low, high = 0.0, min(1.0, ceiling)
    while not counter.below(high):
        if high == ceiling:
            return high * counter.unit / (1 - SHEARED)  # it gives way by shear
        low, high = high, min(4 * high, ceiling)
        if high > _LARGEST:
            raise ValueError(f"no force up to {high * counter.unit:.3g} N buckles the column")
    while high > _NEAR_SHEARED * ceiling and high - low > _EXACT * high:
        middle = (low + high) / 2  # the determinant has its pole at the ceiling
        if counter.below(middle):
            high = middle
        else:
            low = middle
    if high - low <= _EXACT * high:
        return (low + high) / 2 * counter.unit
    return root(counter.left, low, high, _EXACT) * counter.unit


def count_critical_forces(
    shape: ColumnShape, force: float, start: ColumnEnd = HINGED, end: ColumnEnd = HINGED
) -> int:
    """Number of compressive forces below this one, N, at which a column buckles elastically.

    Raises ValueError for a column that moves without bending or gives way by shear before.

    >>> count_critical_forces(ColumnShape.stepped([1.0], [1.0]), 40.0)  # pi^2 and 4 pi^2
    2
    """
    counter = _counter(shape, start, end)
    if not 0 <= force < counter.ceiling * counter.unit:
        raise ValueError(
            f"critical forces are counted from 0 to the least shear stiffness, "
            f"{counter.ceiling * counter.unit:.4g} N; got {force:.4g} N"
        )
    return counter.below(force / counter.unit)


def _check_held(start: ColumnEnd, end: ColumnEnd) -> None:
    stiff_turning = start.turning > 0 or end.turning > 0
    if not (start.held or end.held) or not (stiff_turning or (start.held and end.held)):
        raise ValueError(
            "the column moves without bending: hold both ends sideways, or one of them, and one "
            "against turning"
        )
