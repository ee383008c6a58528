"""Points of a handbook model: where they are, and of which forces their stress is made."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from checks.handbook.pin_loaded_hole import PATTERNS
from checks.stress.stress_result import ElasticLoad, RungModel, UnitName, no_answer
from fem.stress_history import StressHistory
from fem.unit_loads import ACCELERATIONS
from geometry.mesh import FloatArray, IntArray

XX, YY, ZZ, XY, YZ, ZX = range(6)
PRESSED_IN = " press fit"  # ends the name of that column
_SECTION = {  # what acts in a section, and its unit
    "axial force": "N",
    "shear force": "N",
    "moment M_z": "N mm",
    "moment M_y": "N mm",
    "torque": "N mm",
}


class Points:
    """Collects columns of coefficients and the points whose stress they make up."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._rows: list[FloatArray] = []
        self._names: list[UnitName] = []
        self._points: list[FloatArray] = []
        self._stress: list[tuple[list[int], FloatArray]] = []
        self._places: list[str] = []
        self._fretting: list[FloatArray] = []

    def column(self, values: FloatArray, name: UnitName) -> int:
        """Number of a new column with these coefficients (n,), named for whoever explains it."""
        if values.shape != (self._count,):
            raise ValueError(f"a column needs ({self._count},) values, got {values.shape}")
        self._rows.append(values)
        self._names.append(name)
        return len(self._rows) - 1

    def columns(self, values: FloatArray, names: Sequence[UnitName]) -> list[int]:
        """Numbers of new columns with coefficients (k, n) and k names."""
        return [self.column(row, name) for row, name in zip(values, names, strict=True)]

    def coefficients(self, columns: Sequence[int]) -> FloatArray:
        """Coefficients (k, n) of columns."""
        return np.array([self._rows[k] for k in columns]).reshape(-1, self._count)

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
        """Name of the place at each point."""
        return self._places

    @property
    def fretting(self) -> FloatArray:
        """Factor of fretting at each point."""
        return np.concatenate(self._fretting)

    def history(self) -> StressHistory:
        """All points over all positions; columns that are nothing everywhere are left out."""
        points = np.concatenate(self._points)
        rows, acts = np.stack(self._rows), self._acting()
        basis = np.zeros((len(points), 6, len(rows)))
        start = 0
        for columns, stress in self._stress:
            basis[start : start + len(stress), :, columns] = stress
            start += len(stress)
        return StressHistory(
            np.arange(len(points)), points, np.ascontiguousarray(basis[:, :, acts]), rows[acts]
        )

    def model(
        self,
        *,
        residual: float,
        deflection: float,
        neglects: str,
        buckles: Callable[[], ElasticLoad | None] = no_answer,
        ring: int = 0,
    ) -> RungModel:
        """The rung `formula` of these points; parameters as `RungModel` has them."""
        return RungModel(
            history=self.history(),
            places=self.places,
            units=self.units,
            fretting=self.fretting,
            residual=residual,
            deflection=deflection,
            buckles=buckles,
            neglects=neglects,
            ring=ring,
        )

    def _acting(self) -> IntArray:
        """Columns that are something somewhere; a history has at least one, if of nothing."""
        acts = [k for k, row in enumerate(self._rows) if row.any()]
        return np.array(acts or [0])

    @property
    def units(self) -> list[UnitName]:
        """Names of the columns of the history."""
        return [self._names[k] for k in self._acting()]


def in_section(place: float, *kinds: str) -> list[UnitName]:
    """Names of what acts in the section at a place, mm, such as "axial force" and "moment M_z"."""
    return [(f"{kind} at x = {place:.4g} mm", _SECTION[kind]) for kind in kinds]


def along_x(values: FloatArray) -> FloatArray:
    """Stress (k, 6) with these (k,) along x and nothing else."""
    stress = np.zeros((len(values), 6))
    stress[:, XX] = values
    return stress


def sheared(values: FloatArray) -> FloatArray:
    """Stress (k, 6) with these (k,) as shear along y in the section across x, nothing else."""
    stress = np.zeros((len(values), 6))
    stress[:, XY] = values
    return stress


# Names of unit loads, with where each acts, and the units of their coefficients.

_WRENCH = ("F_x", "F_y", "F_z", "M_x", "M_y", "M_z")
_ACCELERATIONS = {"a_x": "mm/s2", "a_y": "mm/s2", "alpha": "rad/s2", "omega2": "1/s2"}
_COUPLES = ("couple", "M_x", "M_y", "M_z")


def interface_units(interface: str, columns: Sequence[str]) -> list[UnitName]:
    """Names of an interface's columns as the solid's unit loads have them."""
    return [(f"{interface} {name}", "N mm" if name in _COUPLES else "N") for name in columns]


def bearing_units(interface: str, patterns: Sequence[str] = PATTERNS) -> list[UnitName]:
    """Names of a bore's columns: harmonics of the pressure and the friction couple."""
    return interface_units(interface, patterns)


def pressed_unit(interface: str) -> UnitName:
    """Name of the column of a bush that is pressed into a bore."""
    return f"{interface}{PRESSED_IN}", "N"


def wrench_units(place: str) -> list[UnitName]:
    """Names of the six forces and couples at a place."""
    return [(f"{name} at {place}", "N mm" if name in _COUPLES else "N") for name in _WRENCH]


def acceleration_units() -> list[UnitName]:
    """Names of the four accelerations of a part's frame."""
    return [(name, _ACCELERATIONS[name]) for name in ACCELERATIONS]


def columns_of(interfaces: Sequence[tuple[str, Sequence[str]]]) -> list[UnitName]:
    """Names of the columns of all interfaces, then of the accelerations."""
    own = [
        name for interface, columns in interfaces for name in interface_units(interface, columns)
    ]
    return own + acceleration_units()
