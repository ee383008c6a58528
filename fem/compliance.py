"""The compliance of a part at its interfaces, for a linkage that gives way.

The displacement of an interface is the mean motion of its loaded surface, weighted with the unit
load itself: c_ij = f_i . u_j, the work of load i on the displacements of load j, which makes the
matrix symmetric (Maxwell and Betti). A single load is not in equilibrium. It is balanced by the
inertia of the accelerated part, not by supports, whose point reactions have no finite compliance
in a solid; for loads that balance each other the choice drops out.
"""

from collections.abc import Sequence

import numpy as np

from fem.sliding import sliding_coefficients
from fem.unit_loads import ACCELERATIONS, InterfaceLoads
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray

_IN_PLANE = [0, 1, 5]


def compliance(solutions: UnitSolutions, places: Sequence[str | tuple[str, float]]) -> FloatArray:
    """Compliance (3 m, 3 m) of a part at m places: mm/N, rad/N, rad/(N mm).

    places  names of interfaces; of a sliding contact its name and where it is along x from the
            interface's centre, mm

    Displacements x, y and turn of every place for forces x, y and couple at every place, in the
    part's axes, against a frame that moves with the part as a whole. A bore or journal is loaded by
    the first harmonic of a pin's pressure, a sliding contact half on each of its two surfaces.
    Raises ValueError for a place that the part does not have, a part without mass, or half of one.
    """
    solutions.mesh.check_whole("a compliance")
    if not solutions.material.density > 0:
        raise ValueError("a compliance needs a density above 0: inertia balances its unit loads")
    columns = np.concatenate([_unit_forces(solutions, place) for place in places], axis=1)
    balance = solutions.unit_resultants[_IN_PLANE]
    first = len(columns) - len(ACCELERATIONS)
    columns[first : first + 3] -= np.linalg.solve(balance[:, first : first + 3], balance @ columns)
    return np.asarray((solutions.loads @ columns).T @ (solutions.displacement @ columns))


def _unit_forces(solutions: UnitSolutions, place: str | tuple[str, float]) -> FloatArray:
    """Coefficients (n_basis, 3) of the unit loads for 1 N along x, along y, and 1 N mm there."""
    name, at = (place, None) if isinstance(place, str) else place
    result = np.zeros((solutions.loads.shape[1], 3))
    column = 0
    for loads in solutions.interfaces:
        columns = slice(column, column + len(loads.names))
        column = columns.stop
        if loads.interface.name == name:
            result[columns] = _of_interface(loads, at)
            return result
    known = ", ".join(loads.interface.name for loads in solutions.interfaces)
    raise ValueError(f"the part has no interface {name!r}; it has {known}")


def _of_interface(loads: InterfaceLoads, at: float | None) -> FloatArray:
    interface = loads.interface
    if (interface.kind == "slide") != (at is not None):
        need = "needs" if interface.kind == "slide" else "does not slide, so it takes no"
        raise ValueError(f"interface {interface.name!r} {need} place along x")
    if at is not None:
        unit = np.eye(3)
        unit[1, 2] = at  # a force at the contact has a moment about the centre
        reach = np.full(3, at)
        pushed = sliding_coefficients(interface, unit, reach)
        pulled = sliding_coefficients(interface, -unit, reach)
        return np.asarray((pushed - pulled).T / 2)
    result = np.zeros((len(loads.names), 3))
    if interface.kind in ("bore", "journal"):
        sign = -1.0 if interface.kind == "journal" else 1.0
        rows, sizes = ("cos 1", "sin 1", "couple"), (sign, sign, 1.0)
    else:
        rows, sizes = ("F_x", "F_y", "M_z"), (1.0, 1.0, 1.0)
    for axis, (row, size) in enumerate(zip(rows, sizes, strict=True)):
        result[loads.names.index(row), axis] = size
    return result
