"""Stress under bearing pressures that are applied as they are, on an arc, without a series.

What the unit loads cannot say of themselves is measured with it at the positions that govern: the
truncation of the bearing series, and how much depends on the arc on which a pin presses.
"""

from collections.abc import Mapping

import numpy as np

from fem.unit_loads import ACCELERATIONS, direct_bearing
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray


def direct_stress(
    solutions: UnitSolutions,
    wrenches: Mapping[str, FloatArray],
    coefficients: FloatArray,
    arc: float,
) -> FloatArray:
    """Surface stress (n_points, 6) at one position with cosine pressures on an arc, MPa.

    wrenches      interface -> (6,) N, N mm
    coefficients  (n_basis,) of that position; those of end faces and inertia are used as they are
    arc           rad, full angle of contact of every bore and journal
    """
    load = np.zeros(len(solutions.loads))
    column = 0
    for unit in solutions.interfaces:
        columns = slice(column, column + len(unit.names))
        column = columns.stop
        if unit.interface.kind == "face":
            load += solutions.loads[:, columns] @ coefficients[columns]
        else:
            planar = np.asarray(wrenches[unit.interface.name])[[0, 1, 5]]
            load += direct_bearing(solutions.elements, unit.interface, planar, arc)
    inertia = slice(column, column + len(ACCELERATIONS))
    load += solutions.loads[:, inertia] @ coefficients[inertia]
    displacement = solutions.solve(load[:, None])
    return solutions.recovery.surface_stress(displacement)[:, :, 0]


def has_bearings(solutions: UnitSolutions) -> bool:
    """Whether any interface is a bore or a journal."""
    return any(unit.interface.kind != "face" for unit in solutions.interfaces)
