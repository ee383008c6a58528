"""Fibres of square tubes and of plates in their walls."""

import numpy as np

from checks.handbook.bar_forces import BarForces
from checks.models.formula_bars import SectionForces
from checks.models.formula_points import XX, XY, Points
from geometry.mesh import FloatArray
from geometry.sections import Section


def add_tube_fibres(
    points: Points,
    name: str,
    places: FloatArray,
    sections: SectionForces,
    tube: Section,
    size: tuple[float, float],
) -> None:
    """Add corners and middles of the walls: sigma of N, M_z, M_y; shear of V in the cheeks."""
    width, wall = size
    half = width / 2
    y = half * np.array([1.0, 1.0, -1.0, -1.0, 0.0, 0.0, 1.0, -1.0])
    z = half * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 0.0, 0.0])
    cheek = (y == 0).astype(float)
    columns, forces = sections.at(places)
    stress = fibre_stress(forces, tube.area, y / tube.inertia_in_plane)
    stress[:, :, XX] += z[:, None] / tube.inertia_out_of_plane * forces.moment_y[:, None]
    # V S/(2 t I) in the middle of a thin square box: S = 3/8 of w^2 t, I = 2/3 w^3 t
    sheared = cheek[:, None] * 9 / (16 * (width - wall) * wall)
    stress[:, :, XY] = sheared * forces.shear[:, None]
    add_fibres(points, name, places, (y, z), columns, stress)


def fibre_stress(forces: BarForces, area: float, levers: FloatArray) -> FloatArray:
    """Stress (k, fibres, 6, columns) of N and M_z; levers (fibres,) y/I, 1/mm3."""
    stress = np.zeros((len(forces.axial), len(levers), 6, forces.axial.shape[1]))
    stress[:, :, XX] = forces.axial[:, None] / area - levers[:, None] * forces.moment_z[:, None]
    return stress


def add_fibres(
    points: Points,
    name: str,
    places: FloatArray,
    at: tuple[FloatArray, FloatArray],
    columns: list[int],
    stress: FloatArray,
) -> None:
    """Add fibres at y and z (fibres,) of the sections at places (k,)."""
    y, z = at
    x = np.repeat(places, len(y))
    found = np.column_stack([x, np.tile(y, len(places)), np.tile(z, len(places))])
    points.add_block(name, found, columns, stress.reshape(len(found), 6, -1))
