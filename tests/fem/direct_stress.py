"""Stress under bearing pressures that are applied as they are."""

from fem.unit_solutions import direct_displacement


def direct_stress(solutions, wrenches, coefficients, arcs):
    """Surface stress (n_points, 6, n_arcs) of `direct_displacement`, MPa."""
    moved = direct_displacement(solutions, wrenches, coefficients, arcs)
    return solutions.recovery.surface_stress(moved)
