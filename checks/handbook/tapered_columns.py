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

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import exp, factorial, inf, isinf, log, sqrt
from typing import Self

import numpy as np

from geometry.mesh import FloatArray, IntArray
from geometry.roots import root

GAUSS = sqrt(3) / 6  # of a stretch, from its middle
_SERIES = 1 / np.array([factorial(k) for k in range(20)], dtype=float).reshape(5, 4)
_ANGLE = 1.0  # rad, largest sqrt(F/B) times length of a cut: the series is right to 1e-16
SHEARED = 1e-6  # nearer than this share below the least S, the column fails by shear
_LARGEST_EXPONENT = 600.0  # beyond it a ratio of determinants says no more than its sign
_NO_PIVOT = 1e-30  # for a pivot of zero, which no force hits but by accident

_End = tuple[bool, float]  # whether it is held sideways; N mm/rad, stiffness against turning


class ColumnCounter:
    """Counts critical forces below a given one; lengths over the column's, forces over `unit`.

    table  (m, 4) stretches: length, bending stiffness at two Gauss points, shear stiffness; mm, N
    """

    def __init__(self, table: FloatArray, ends: tuple[_End, _End]) -> None:
        lengths, bending, shear = table[:, 0], table[:, 1:3], table[:, 3]
        length, largest = float(lengths.sum()), float(bending.max())
        self.unit = largest / length**2
        self._lengths = lengths / length
        self._flexible = largest / bending
        self._shear = shear / self.unit
        least = float(self._shear.min())
        self.ceiling = inf if isinf(least) else least * (1 - SHEARED)
        self._ends = [(held, turning * length / largest) for held, turning in ends]
        self._unloaded: dict[tuple[int, ...], float] = {}

    def below(self, force: float) -> int:
        """Number of critical forces below this one."""
        return self._determinant(force, self._cuts(force))[0]

    def left(self, force: float) -> float:
        """Size of the determinant over that without force; below 0 if a critical force is passed.

        Nearly smooth: where the number of cuts changes it jumps by a factor of about 1.
        """
        cuts = self._cuts(force)
        key = tuple(cuts.tolist())
        if key not in self._unloaded:
            self._unloaded[key] = self._determinant(0.0, cuts)[1]
        count, size = self._determinant(force, cuts)
        ratio = exp(min(size - self._unloaded[key], _LARGEST_EXPONENT))
        return -ratio if count else ratio

    def _cuts(self, force: float) -> IntArray:
        """Number of pieces (m,) that the stretches are cut into so that none buckles by itself."""
        loosened = 1 / (1 - force / self._shear)
        angle = self._lengths * np.sqrt(force * loosened * self._flexible.max(axis=1))
        return np.asarray(np.maximum(np.ceil(angle / _ANGLE), 1).astype(np.int64))

    def _determinant(self, force: float, cuts: IntArray) -> tuple[int, float]:
        """Number of critical forces below this one, and the logarithm of the determinant's size."""
        blocks = self._stiffness(force, cuts)
        count = len(blocks)
        diagonal = np.zeros((count + 1, 2, 2))
        diagonal[:-1] += blocks[:, :2, :2]
        diagonal[1:] += blocks[:, 2:, 2:]
        coupling = blocks[:, :2, 2:].copy()
        for place, (held, turning) in zip((0, count), self._ends, strict=True):
            if not isinf(turning):
                diagonal[place, 1, 1] += turning
            for unknown, still in enumerate((held, isinf(turning))):
                if still:
                    diagonal[place, unknown, :] = diagonal[place, :, unknown] = 0.0
                    diagonal[place, unknown, unknown] = 1.0
                    if place:
                        coupling[-1, :, unknown] = 0.0
                    else:
                        coupling[0, unknown, :] = 0.0
        return _negative_pivots(diagonal.tolist(), coupling.tolist())

    def _stiffness(self, force: float, cuts: IntArray) -> FloatArray:
        """Stiffness (m, 4, 4) of the stretches' cuts on w, t at their start and end."""
        loosened = 1 / (1 - force / self._shear)
        matrix = np.zeros((len(self._lengths), 2, 4, 4))
        matrix[..., 0, 1] = loosened[:, None]
        matrix[..., 0, 3] = (-loosened / self._shear)[:, None]
        matrix[..., 1, 2] = self._flexible
        matrix[..., 2, 1] = (-loosened * force)[:, None]
        matrix[..., 2, 3] = loosened[:, None]
        first, second = matrix[:, 0], matrix[:, 1]
        size = self._lengths[:, None, None]
        turn = second @ first - first @ second
        exponent = size / 2 * (first + second) + GAUSS / 2 * size**2 * turn
        exponent /= cuts[:, None, None]
        carried = _exponential(exponent)
        to_moved, to_forced = carried[:, :2, :2], carried[:, :2, 2:]
        from_moved, from_forced = carried[:, 2:, :2], carried[:, 2:, 2:]
        inverse = np.linalg.inv(to_forced)
        blocks = np.empty((len(cuts), 4, 4))
        # forces on the cut's ends: (T, -M) at its start, (-T, M) at its end; rows M, T of y
        at_start = np.concatenate([-inverse @ to_moved, inverse], axis=2)
        at_end = np.concatenate([from_moved, np.zeros_like(from_moved)], axis=2)
        at_end = at_end + from_forced @ at_start
        blocks[:, 0], blocks[:, 1] = at_start[:, 1], -at_start[:, 0]
        blocks[:, 2], blocks[:, 3] = -at_end[:, 1], at_end[:, 0]
        blocks = (blocks + np.swapaxes(blocks, 1, 2)) / 2
        return np.asarray(np.repeat(blocks, cuts, axis=0))


def _exponential(exponent: FloatArray) -> FloatArray:
    """Exponentials of small matrices (m, 4, 4) by their series.

    Summed four powers at a time, which takes 7 products instead of 19 (Paterson and Stockmeyer,
    SIAM J. Comput. 2 (1973) 60).
    """
    powers = np.empty((4, *exponent.shape))
    powers[0], powers[1] = np.eye(4), exponent
    square = np.matmul(exponent, exponent, out=powers[2])
    np.matmul(square, exponent, out=powers[3])
    parts = (_SERIES @ powers.reshape(4, -1)).reshape(-1, *exponent.shape)
    fourth = square @ square
    carried = parts[-1]
    for part in parts[-2::-1]:
        carried = carried @ fourth + part
    return np.asarray(carried)


def _negative_pivots(
    diagonal: list[list[list[float]]], coupling: list[list[list[float]]]
) -> tuple[int, float]:
    """Number of negative eigenvalues of a symmetric matrix of 2 by 2 blocks along its diagonal.

    And the logarithm of its determinant's size.
    """
    (a, b), (_, d) = diagonal[0]
    over = a * d - b * b or _NO_PIVOT
    count, size = _negative(a, b, d), log(abs(over))
    for ((p, q), (r, s)), ((a2, b2), (_, d2)) in zip(coupling, diagonal[1:], strict=True):
        # the next block less C' D^-1 C
        u, v = (d * p - b * r) / over, (d * q - b * s) / over
        x, y = (a * r - b * p) / over, (a * s - b * q) / over
        a, b, d = a2 - p * u - r * x, b2 - p * v - r * y, d2 - q * v - s * y
        over = a * d - b * b or _NO_PIVOT
        count += _negative(a, b, d)
        size += log(abs(over))
    return count, size


def _negative(a: float, b: float, d: float) -> int:
    """Number of negative eigenvalues of [[a, b], [b, d]]."""
    if a * d - b * b < 0:
        return 1
    return 2 if a + d < 0 else 0


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


def _check_held(start: ColumnEnd, end: ColumnEnd) -> None:
    stiff_turning = start.turning > 0 or end.turning > 0
    if not (start.held or end.held) or not (stiff_turning or (start.held and end.held)):
        raise ValueError(
            "the column moves without bending: hold both ends sideways, or one of them, and one "
            "against turning"
        )
