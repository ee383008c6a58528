"""The stress of a part over the cycle: a basis at its surface points and coefficients in time."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.mesh import FloatArray, IntArray

_NUMBERS = 2_000_000  # of the history at a time
_BLOCK = 16  # positions that are looked at together
_FEW = 50_000  # points times positions
_ROUND_OFF = 1e-12  # of a stress
_R = np.sqrt(3.0)
# Rows: xx - (yy + zz)/2, sqrt(3)/2 (yy - zz), sqrt(3) times each shear stress. The sum of their
# squares is the square of the von Mises stress (Ilyushin's five-dimensional stress space).
DEVIATOR = np.array(
    [
        [1.0, -0.5, -0.5, 0.0, 0.0, 0.0],
        [0.0, _R / 2, -_R / 2, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, _R, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, _R, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, _R],
    ]
)


@dataclass(frozen=True, eq=False)
class StressHistory:
    """stress(point, position) = sum_j basis[point, :, j] coefficients[j, position].

    nodes         (n_points,)             node indices of the surface points
    points        (n_points, 3)           mm
    basis         (n_points, 6, n_basis)  MPa per unit; xx, yy, zz, xy, yz, zx
    coefficients  (n_basis, n_positions)  the units
    """

    nodes: IntArray
    points: FloatArray
    basis: FloatArray
    coefficients: FloatArray

    def __post_init__(self) -> None:
        n = len(self.nodes)
        expected = (n, 6, len(self.coefficients))
        if self.points.shape != (n, 3) or self.basis.shape != expected:
            raise ValueError(
                f"{n} points and {len(self.coefficients)} coefficients need points ({n}, 3) and "
                f"basis {expected}, got {self.points.shape} and {self.basis.shape}"
            )

    def at(self, position: int) -> FloatArray:
        """Stress (n_points, 6) at one position."""
        return np.asarray(self.basis @ self.coefficients[:, position])

    def between(self, columns: slice) -> "StressHistory":
        """Return the same points over some of the positions."""
        return StressHistory(self.nodes, self.points, self.basis, self.coefficients[:, columns])

    def at_points(self, points: IntArray) -> "StressHistory":
        """Return some of the points over all positions."""
        return StressHistory(
            self.nodes[points], self.points[points], self.basis[points], self.coefficients
        )

    def peaks_by_position(self) -> tuple[FloatArray, IntArray]:
        """Largest von Mises stress (n_positions,) at each position, and the point it is at."""
        return self._peaks

    @cached_property
    def _peaks(self) -> tuple[FloatArray, IntArray]:
        """As `peaks_by_position`, sought once.

        Exact, without every point at every position: the stress of a point moves from the middle of
        a block of positions by at most the sum of its unit stresses times the largest changes of
        their coefficients. Only points that can be the largest somewhere in the block are followed
        through it.
        """
        n_positions = self.coefficients.shape[1]
        best, where = np.empty(n_positions), np.zeros(n_positions, dtype=np.int64)
        vectors = np.ascontiguousarray(DEVIATOR @ self.basis)  # (n_points, 5, n_basis)
        norms = np.linalg.norm(vectors, axis=1)
        starts = np.arange(0, n_positions, _BLOCK)
        batch = max(1, _NUMBERS // (5 * max(len(self.nodes), 1)))
        for first in range(0, len(starts), batch):
            blocks = [slice(start, start + _BLOCK) for start in starts[first : first + batch]]
            middles = [min(b.start + _BLOCK // 2, n_positions - 1) for b in blocks]
            anchors = np.ascontiguousarray(self.coefficients[:, middles])
            paths = _product(vectors, anchors)
            paths *= paths
            sizes = np.sqrt(paths.sum(axis=1))  # (n_points, n_blocks)
            own = self.coefficients[:, blocks[0].start : blocks[-1].stop]
            apart = np.abs(own - np.repeat(anchors, _BLOCK, axis=1)[:, : own.shape[1]])
            changes = np.maximum.reduceat(apart, np.arange(0, own.shape[1], _BLOCK), axis=1)
            reach = norms @ changes
            reach += _ROUND_OFF * sizes
            may = sizes + reach >= (sizes - reach).max(axis=0)
            anywhere = np.count_nonzero(may.any(axis=1))
            # of few points one product over all blocks costs less than many small ones
            if anywhere * _BLOCK * len(blocks) <= _FEW:
                blocks = [slice(blocks[0].start, blocks[-1].stop)]
                may = may.any(axis=1, keepdims=True)
            for column, block in enumerate(blocks):
                points = np.flatnonzero(may[:, column])
                followed = _product(vectors[points], self.coefficients[:, block])
                followed *= followed
                squares = followed.sum(axis=1)
                top = squares.argmax(axis=0)
                best[block] = squares[top, np.arange(squares.shape[1])]
                where[block] = points[top]
        return np.sqrt(best), where

    def peaks_by_point(self, points: IntArray | slice = slice(None)) -> FloatArray:
        """Largest von Mises stress (n,) of each point, or of some, over the positions."""
        vectors = np.ascontiguousarray(DEVIATOR @ self.basis[points])
        found = np.zeros(len(vectors))
        if not len(vectors):
            return found
        batch = max(1, _NUMBERS // (5 * max(len(vectors), 1)))
        for first in range(0, self.coefficients.shape[1], batch):
            paths = _product(vectors, self.coefficients[:, first : first + batch])
            paths *= paths
            np.maximum(found, paths.sum(axis=1).max(axis=1), out=found)
        return np.sqrt(found)


def _product(vectors: FloatArray, coefficients: FloatArray) -> FloatArray:
    """Paths (n, 5, k) of vectors (n, 5, m) and coefficients (m, k), in one product of all rows."""
    rows = vectors.reshape(-1, vectors.shape[2]) @ np.ascontiguousarray(coefficients)
    return np.asarray(rows.reshape(*vectors.shape[:2], -1))
