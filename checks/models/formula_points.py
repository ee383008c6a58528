"""Points of a handbook model: where they are, and of which forces their stress is made.

There are points round a bore and on the outline of its lug, by the bore's wrench and a bush in it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from checks.design.data import Part
from checks.handbook.lug_stress import Lug, cartesian, polar
from checks.handbook.pin_loaded_hole import ComplexArray, patterns_of
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import ElasticLoad, RungModel, UnitName, no_answer
from fem.stress_history import StressHistory
from fem.unit_loads import ACCELERATIONS, IN_PLANE, bearing_coefficients, harmonics_of
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
ANGLES = np.radians(np.arange(0.0, 360.0, 10.0))


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
            places=self._places,
            units=self.units,
            fretting=np.concatenate(self._fretting),
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


def bore_columns(
    points: Points,
    part: Part,
    loads: PartLoads,
    name: str,
    rim: FloatArray,
    angles: FloatArray,
    thickness: float,
    passing: tuple[Sequence[int], FloatArray] | None = None,
) -> tuple[list[int], list[int]]:
    """Columns of what acts in a bore: the pin's pressure, and a bush that is pressed in.

    rim        (k, 3, 8) xx, yy, xy at angles (k,), rad, per unit of the patterns, MPa
    thickness  mm, of the lug
    passing    columns of what passes the bore, and xx, yy, xy (k, 3, m) of them; None: nothing

    Returns their numbers, and which of the patterns each is of. The bush presses more where the
    loads close the bore.
    """
    wrench = loads.wrenches[name][:, IN_PLANE]
    names = patterns_of(harmonics_of(loads.arc))
    pressure = bearing_coefficients(wrench, inward=False, arc=loads.arc)
    columns = points.columns(pressure.T, interface_units(name, names))
    patterns = list(range(len(names)))
    fit = loads.press_fits.get(name)
    if fit is None:
        return columns, patterns
    even, material = names.index("cos 0"), part.material
    hoop, radial, _ = _means(rim, angles)
    per_pressure = fit.per_pressure(thickness)
    lug = (per_pressure * float(hoop[even]) + material.poisson_ratio) / material.youngs_modulus
    strain = (hoop - material.poisson_ratio * radial) / material.youngs_modulus
    strain[even] = 0.0
    own = points.coefficients(columns)
    opened = strain @ own
    if passing is not None:
        past, stress = passing
        hoop, *_ = _means(stress, angles)
        opened = opened + hoop @ points.coefficients(past) / material.youngs_modulus
    force = per_pressure * fit.pressures(lug, opened, own[even] / per_pressure)
    return [*columns, points.column(force, pressed_unit(name))], [*patterns, even]


def on_arc(model: RungModel, loads: PartLoads, arc: float) -> RungModel:
    """A model of pins on a narrower arc than the half circle, with pins that press on another such.

    Their patterns are the same, with other coefficients. Without bushes that are pressed in.
    """
    waves = patterns_of(harmonics_of(arc))[:-1]  # the last is the couple
    rows: dict[str, FloatArray] = {}
    for bore, wrench in loads.wrenches.items():
        pressure = bearing_coefficients(wrench[:, IN_PLANE], inward=False, arc=arc).T[:-1]
        names = (name for name, _ in interface_units(bore, waves))
        rows |= dict(zip(names, pressure, strict=True))
    before = zip(model.units, model.history.coefficients, strict=True)
    now = np.stack([rows.get(name, row) for (name, _), row in before])
    return replace(model, history=replace(model.history, coefficients=now))


def _means(plane: FloatArray, angles: FloatArray) -> FloatArray:
    """Means (3, m) of hoop, radial and shear stress of xx, yy, xy (k, 3, m) at angles (k,)."""
    count = plane.shape[2]
    every = polar(plane.transpose(0, 2, 1).reshape(-1, 3), np.repeat(angles, count))
    return np.array([one.reshape(-1, count).mean(axis=0) for one in every])


def add_bore(
    points: Points,
    part: Part,
    loads: PartLoads,
    name: str,
    centre: float,
    lug: Lug,
    faces: Sequence[float],
    *,
    tilts: bool = False,
    edges: ComplexArray | None = None,
) -> None:
    """Add the bore's rim, and places on the lug's edges, on some faces.

    centre  mm, x of the bore
    faces   z, mm, where the lug's plane stress stands
    edges   x + i y from the bore's middle, on the first of the faces
    tilts   whether its couples about x and y act on the lug, whose middle plane is z = 0: then its
            faces are added, with these couples
    """
    wrench = loads.wrenches[name]
    rim = lug.hole.radius * np.exp(1j * ANGLES)
    plane = lug.stress(rim)
    columns, patterns = bore_columns(points, part, loads, name, plane, ANGLES, lug.thickness)
    plane = plane[:, :, patterns]
    for z in faces:
        _add(points, name, centre, rim, z, _by_column(columns, plane))
    if edges is not None:
        stress = _by_column(columns, lug.stress(edges)[:, :, patterns])
        _add(points, f"{name} edge", centre, edges, faces[0], stress)
    if not tilts:
        return
    count = len(columns)
    every = np.repeat(ANGLES, count)
    hoop, radial, shear = polar(plane.transpose(0, 2, 1).reshape(-1, 3), every)
    relieved = cartesian(lug.relief * hoop, radial, shear, every)
    own = _by_column(columns, relieved.reshape(-1, count, 3).transpose(0, 2, 1))
    turned = points.columns(wrench[:, 3:5].T, interface_units(name, ("M_x", "M_y")))
    tilt = lug.tilted(ANGLES)
    for z in (-lug.thickness / 2, lug.thickness / 2):
        _add(points, name, centre, rim, z, own | _by_column(turned, np.sign(z) * tilt))


def _by_column(columns: list[int], plane: FloatArray) -> dict[int, FloatArray]:
    """Stress (k, 6) by column of xx, yy, xy (k, 3, columns)."""
    return {column: _in_plane(plane[:, :, k]) for k, column in enumerate(columns)}


def _add(
    points: Points,
    place: str,
    centre: float,
    arms: ComplexArray,
    z: float,
    stress: dict[int, FloatArray],
) -> None:
    at = np.column_stack([centre + arms.real, arms.imag, np.full(len(arms), z)])
    points.add(place, at, stress)


def _in_plane(values: FloatArray) -> FloatArray:
    """Stress (k, 6) of xx, yy, xy (k, 3)."""
    stress = np.zeros((len(values), 6))
    stress[:, [XX, YY, XY]] = values
    return stress


def strip_edges(half_width: float, end: float | None, reach: float, outward: float) -> ComplexArray:
    """Places on the edges of a lug that goes on as a strip, from its end to `reach` from its hole.

    end      mm, from the hole to the square end; None: round about the hole
    outward  1 where the end is at +x, -1 where it is at -x
    """
    along = np.linspace(0.0 if end is None else -end, reach, 9) + 1j * half_width
    if end is None:
        free = half_width * np.exp(1j * np.radians([180.0, 160.0, 140.0, 120.0]))
    else:
        free = np.array([-end + 0j, -end + 0.5j * half_width])
    upper = np.concatenate([free, along])
    both = np.concatenate([upper, upper[1:].conj()])
    return np.asarray(both if outward < 0 else -both.conj())
