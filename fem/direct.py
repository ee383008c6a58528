"""Stress under bearing pressures that are applied as they are, on an arc, without a series.

It measures two errors of the unit loads at the positions that govern: the truncation of the bearing
series, and the effect of the arc on which a pin presses.
"""

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from fem.unit_loads import ACCELERATIONS, InterfaceLoads, direct_bearing
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray, IntArray

_TILTING = ("M_x", "M_y")  # columns whose pressure has no resultant force, hence no direction


def direct_displacement(
    solutions: UnitSolutions,
    wrenches: Mapping[str, FloatArray],
    coefficients: FloatArray,
    arcs: Sequence[float],
    solved: Collection[str] = (),
) -> FloatArray:
    """Displacement (3 n_nodes, n_arcs) at one position with cosine pressures on arcs, mm.

    wrenches      interface -> (6,) N, N mm
    coefficients  (n_basis,) of that position; used as they are for end faces, clamps, sliding
                  contacts, inertia, and the couples about x and y of pins that tilt
    arcs          rad, full angles of contact of every bore and journal
    solved        names of those whose pressure is solved: their columns are used as they are
    """
    load = np.zeros((len(solutions.loads), len(arcs)))
    column = 0
    for unit in solutions.interfaces:
        columns = slice(column, column + len(unit.names))
        column = columns.stop
        assumed = _is_bearing(unit) and unit.interface.name not in solved
        kept = np.array([not assumed or name in _TILTING for name in unit.names])
        load += (solutions.loads[:, columns][:, kept] @ coefficients[columns][kept])[:, None]
        if assumed:
            planar = np.asarray(wrenches[unit.interface.name])[[0, 1, 5]]
            for k, arc in enumerate(arcs):
                load[:, k] += direct_bearing(solutions.elements, unit, planar, arc)
    inertia = slice(column, column + len(ACCELERATIONS))
    load += (solutions.loads[:, inertia] @ coefficients[inertia])[:, None]
    return solutions.solve(load)


def tilting_columns(solutions: UnitSolutions) -> IntArray:
    """Columns (n,) of the basis that are couples about x and y of bores and journals."""
    named = [(_is_bearing(u), name) for u in solutions.interfaces for name in u.names]
    return np.flatnonzero([bearing and name in _TILTING for bearing, name in named])


def has_bearings(solutions: UnitSolutions, solved: Collection[str] = ()) -> bool:
    """Return True if any interface is a bore or a journal, and not one of those solved."""
    return any(
        _is_bearing(unit) and unit.interface.name not in solved for unit in solutions.interfaces
    )


def _is_bearing(unit: InterfaceLoads) -> bool:
    return unit.interface.kind in ("bore", "journal")
