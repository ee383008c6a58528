"""Points round a bore and on the outline of its lug, by the bore's wrench and a bush in it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from checks.design.data import Part
from checks.handbook.lug_stress import Lug, cartesian, polar
from checks.handbook.pin_loaded_hole import ComplexArray, patterns_of
from checks.models.formula_points import (
    XX,
    XY,
    YY,
    Points,
    bearing_units,
    interface_units,
    pressed_unit,
)
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import RungModel
from fem.unit_loads import IN_PLANE, bearing_coefficients, harmonics_of
from geometry.mesh import FloatArray

ANGLES = np.radians(np.arange(0.0, 360.0, 10.0))


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
    columns = points.columns(pressure.T, bearing_units(name, names))
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
        names = (name for name, _ in bearing_units(bore, waves))
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
