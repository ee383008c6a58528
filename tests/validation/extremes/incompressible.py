"""A thick cylinder under inner pressure, no strain along it, towards Poisson's ratio 0.5."""

from typing import NamedTuple

import numpy as np

from fem.recovery import von_mises
from fem.unit_solutions import Elastic

from ...boundary_value import SolidProblem, pressure_load
from ..solids.bodies import ring_body
from ..solids.meshes import on, ring
from ..solids.problems import held

RATIOS = (0.0, 0.3, 0.4, 0.45, 0.48, 0.49, 0.495, 0.499, 0.4999)
INNER, OUTER, E = 3.0, 9.0, 1000.0


class Errors(NamedTuple):
    """Largest errors over the surface: of displacement at the bore, of stress over its largest.

    direct     of the stress components around and along the cylinder
    von_mises  of the von Mises stress
    scatter    von Mises size of the elements' scatter, by which a check sees its error
    """

    displacement: float
    direct: float
    von_mises: float
    scatter: float


def mapped_meshes():
    """Regular meshes, each twice as fine as the one before."""
    return {f"{n} x {2 * n} bricks": ring((n, 2 * n, 1), INNER, OUTER, 1.0) for n in (2, 4, 8)}


def free_meshes():
    """Meshes as a user's part has them, by gmsh: elements at the bore a seventh of its radius."""
    body = ring_body(INNER, OUTER, 1.0, 1.0, 0.4)
    return {f"gmsh, fineness {fineness:g}": body.mesh(fineness) for fineness in (1.0, 1.4)}


def bore_displacement(poisson_ratio):
    """Of the exact solution (Lame), mm, under 1 MPa."""
    b = OUTER**2 / INNER
    factor = (1 + poisson_ratio) * INNER**2 / (E * (OUTER**2 - INNER**2))
    return factor * ((1 - 2 * poisson_ratio) * INNER + b)


def errors(mesh, poisson_ratio):
    """Solve and compare."""
    supports = held(mesh, ("z0", "z"), ("z1", "z"), ("y0", "y"), ("y1", "x"))
    problem = SolidProblem(mesh, Elastic(E, poisson_ratio, 0.0), supports)
    solution = problem.solve(pressure_load(problem.elements, "x0", 1.0))
    bore = on(mesh, "x0")
    moved = (solution.displacement.reshape(-1, 3)[bore] * mesh.nodes[bore])[:, :2].sum(axis=1)
    moved /= np.linalg.norm(mesh.nodes[bore, :2], axis=1)
    wanted = bore_displacement(poisson_ratio)

    x, y = mesh.nodes[problem.recovery.points, :2].T
    radius = np.hypot(x, y)
    c, s = x / radius, y / radius
    found = solution.stress
    around = found[:, 0] * s**2 + found[:, 1] * c**2 - 2 * found[:, 3] * c * s
    share = INNER**2 / (OUTER**2 - INNER**2)
    radial = share * (1 - OUTER**2 / radius**2)
    hoop = share * (1 + OUTER**2 / radius**2)
    zero = np.zeros_like(hoop)
    exact = np.stack([radial, hoop, poisson_ratio * (radial + hoop), zero, zero, zero], axis=1)
    sizes = von_mises(exact)
    direct = max(np.abs(around - hoop).max(), np.abs(found[:, 2] - exact[:, 2]).max())
    return Errors(
        float(np.abs(moved - wanted).max() / wanted),
        float(direct / hoop.max()),
        float(np.abs(von_mises(found) - sizes).max() / sizes.max()),
        float(solution.scatter.max() / sizes.max()),
    )
