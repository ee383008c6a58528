"""Points of a handbook model: where they are, and of which forces their stress is made."""

from collections.abc import Mapping

import numpy as np

from fem.stress_history import StressHistory
from geometry.mesh import FloatArray

XX, YY, ZZ, XY, YZ, ZX = range(6)


class Points:
    """Collects columns of coefficients and the points whose stress they make up."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._rows: list[FloatArray] = []
        self._points: list[FloatArray] = []
        self._stress: list[tuple[list[int], FloatArray]] = []
        self._places: list[str] = []
        self._fretting: list[FloatArray] = []

    def column(self, values: FloatArray) -> int:
        """Number of a new column with these coefficients (n,)."""
        if values.shape != (self._count,):
            raise ValueError(f"a column needs ({self._count},) values, got {values.shape}")
        self._rows.append(values)
        return len(self._rows) - 1

    def columns(self, values: FloatArray) -> list[int]:
        """Numbers of new columns with coefficients (k, n)."""
        return [self.column(row) for row in values]

    def add(
        self,
        place: str,
        points: FloatArray,
        stress: Mapping[int, FloatArray],
        fretting: float = 1.0,
    ) -> None:
        """Add points (k, 3), mm, with stress (k, 6), MPa per unit, by number of column."""
        self.add_block(place, points, list(stress), np.stack([*stress.values()], axis=2), fretting)

    def add_block(
        self,
        place: str,
        points: FloatArray,
        columns: list[int],
        stress: FloatArray,
        fretting: float = 1.0,
    ) -> None:
        """Add points (k, 3), mm, with stress (k, 6, m), MPa per unit, of m different columns."""
        self._points.append(points)
        self._stress.append((columns, stress))
        self._places += [place] * len(points)
        self._fretting.append(np.full(len(points), fretting))

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self._rows)

    @property
    def places(self) -> list[str]:
        """What stands at each point."""
        return self._places

    @property
    def fretting(self) -> FloatArray:
        """Factor of fretting at each point."""
        return np.concatenate(self._fretting)

    def history(self) -> StressHistory:
        """All points over all positions; columns that are nothing everywhere are left out."""
        points = np.concatenate(self._points)
        rows = np.stack(self._rows)
        acts = np.flatnonzero(rows.any(axis=1))
        if not len(acts):
            acts = np.array([0])  # a history has a column, if of nothing
        basis = np.zeros((len(points), 6, len(rows)))
        start = 0
        for columns, stress in self._stress:
            basis[start : start + len(stress), :, columns] = stress
            start += len(stress)
        return StressHistory(
            np.arange(len(points)), points, np.ascontiguousarray(basis[:, :, acts]), rows[acts]
        )


def along_x(values: FloatArray) -> FloatArray:
    """Stress (k, 6) with these (k,) along x and nothing else."""
    stress = np.zeros((len(values), 6))
    stress[:, XX] = values
    return stress


def sheared(values: FloatArray, component: int = XY) -> FloatArray:
    """Stress (k, 6) with these (k,) as one of its shear components."""
    stress = np.zeros((len(values), 6))
    stress[:, component] = values
    return stress
