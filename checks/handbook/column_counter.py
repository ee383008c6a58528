"""Count of the critical forces of a column by the stiffness of its stretches.

The theory stands in `checks.handbook.tapered_columns`.
"""

from math import exp, factorial, inf, isinf, log, sqrt

import numpy as np

from geometry.mesh import FloatArray, IntArray

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
