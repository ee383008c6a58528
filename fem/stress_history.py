"""The stress of a part over the cycle: a basis at its surface points and coefficients in time."""

from dataclasses import dataclass

import numpy as np

from geometry.mesh import FloatArray, IntArray

_NUMBERS = 100_000  # of the history at a time: they stay in the cache
_R = np.sqrt(3.0)
# Rows: xx - (yy + zz)/2, sqrt(3)/2 (yy - zz), sqrt(3) times each shear stress. The sum of their
# squares is the square of the von Mises stress (Ilyushin's five-dimensional stress space).
_DEVIATOR = np.array(
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

    def peaks_by_position(self) -> tuple[FloatArray, IntArray]:
        """Largest von Mises stress (n_positions,) at each position, and the point it is at."""
        n_positions = self.coefficients.shape[1]
        best, where = np.full(n_positions, -1.0), np.zeros(n_positions, dtype=np.int64)
        size = max(1, _NUMBERS // (5 * n_positions))
        for start in range(0, len(self.nodes), size):
            vectors = _DEVIATOR @ self.basis[start : start + size]
            # one small product per point: as fast as one large one, and BLAS starts no threads,
            # which wait for each other where other processes take the cores
            paths = vectors @ self.coefficients
            paths *= paths
            squares = paths.sum(axis=1)
            top = squares.argmax(axis=0)
            peak = squares[top, np.arange(n_positions)]
            better = peak > best
            best[better], where[better] = peak[better], start + top[better]
        return np.sqrt(best), where
