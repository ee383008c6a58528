"""Bars and plates of mapped elements for the stability and frequency cases, and their supports."""

import numpy as np

from bench.fixed_solid import fixed_solid
from fem.mode_count import surface_weights
from fem.unit_solutions import Elastic

from ...boundary_value import SolidProblem, uniform_load, unknowns
from ..solids.meshes import mapped, on


def bar(counts, length, height, width, *, shape=None):
    """A bar along x from 0, centred in y, from z = 0 or, if width is a pair, between its two.

    shape  of x / length to the factors of height and width
    """
    low, high = width if isinstance(width, tuple) else (0.0, width)

    def mapping(x, y, z):
        tall, wide = (np.ones_like(x), np.ones_like(x)) if shape is None else shape(x)
        return length * x, height * tall * (y - 0.5), wide * (low + (high - low) * z)

    x = np.linspace(0.0, 1.0, 20001)
    tall, wide = (np.ones_like(x), np.ones_like(x)) if shape is None else shape(x)
    volume = length * height * (high - low) * np.trapezoid(tall * wide, x)
    return mapped(counts, mapping, volume)


def pushed(solid, stress=-1.0):
    """Stress (n_elements, n_q, 6) of uniform compression along x."""
    field = np.zeros((*solid.elements.weights.shape, 6))
    field[..., 0] = stress
    return field


def solved(mesh, material, held, force):
    """Stress at the integration points under a force along x at "x1"."""
    problem = SolidProblem(mesh, material, held)
    found = problem.solve(uniform_load(problem.elements, "x1", (force, 0.0, 0.0)))
    return problem.recovery.quadrature_stress(found.displacement[:, None], slice(None))[..., 0]


def guided(mesh, elements, name, conditions):
    """Rows that hold mean displacements ("y", "z") or tilts ("yx", "zx") of a side.

    The tilt "yx" is the mean of u_x times y, which turns about z.
    """
    weights = surface_weights(elements, name)
    centre = weights @ mesh.nodes
    rows = []
    for condition in conditions:
        row = np.zeros((len(weights), 3))
        if len(condition) == 1:
            row[:, "xyz".index(condition)] = weights
        else:
            axis = "xyz".index(condition[0])
            row[:, 0] = weights * (mesh.nodes[:, axis] - centre[axis])
        rows.append(row.ravel() / np.linalg.norm(row))
    return np.array(rows)


def clamped(mesh, material, rows=None):
    """The bar with its side "x0" fixed."""
    return fixed_solid(mesh, material, unknowns(on(mesh, "x0")), rows)


def steel(poisson=0.3, density=7.85e-9):
    return Elastic(210e3, poisson, density)
