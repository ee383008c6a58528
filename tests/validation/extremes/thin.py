"""Thin walls and long elements: cylinders, and the patch test stretched."""

from typing import NamedTuple

import numpy as np

from fem.unit_solutions import Elastic
from geometry.mesh import Mesh

from ...boundary_value import SolidProblem, pressure_load
from ..plane import domains
from ..plane.model import PlaneModel
from ..solids.meshes import on, ring
from ..solids.problems import held
from ..solids.test_patch import EXACT, patch, solved

WALLS = (1.0, 0.1, 0.02, 0.01, 0.005, 1e-3, 1e-4)  # over the inner radius
ASPECTS = (1, 10, 100, 1000)
RADIUS, PRESSURE = 100.0, 1.0
STEEL = Elastic(210e3, 0.3, 7.85e-9)


class Walls(NamedTuple):
    """Largest errors of the hoop stress at the bore over Lame's, and how two models agree.

    solid   of quadratic tetrahedra, one through the wall
    aspect  of their bricks: longest over shortest side
    plane   of quadratic triangles in the cross-section, plane strain
    ring    of axisymmetric triangles
    apart   ring against plane, displacement of the bore
    """

    solid: float
    aspect: float
    plane: float
    ring: float
    apart: float


def hoop_at_bore(ratio):
    """Lame: MPa under PRESSURE, of a wall `ratio` times the inner radius thick."""
    square = (1 + ratio) ** 2
    return PRESSURE * (square + 1) / (square - 1)


def walls(ratio):
    """A pressed cylinder of one wall thickness in three models; 16 elements along a quarter."""
    exact, outer = hoop_at_bore(ratio), RADIUS * (1 + ratio)
    through = 8 if ratio > 0.2 else 2
    mesh = ring((through, 16, 1), RADIUS, outer, RADIUS / 10)
    supports = held(mesh, ("z0", "z"), ("z1", "z"), ("y0", "y"), ("y1", "x"))
    problem = SolidProblem(mesh, STEEL, supports)
    solution = problem.solve(pressure_load(problem.elements, "x0", PRESSURE))
    bore = np.isin(problem.recovery.points, on(mesh, "x0"))
    solid = np.abs(_around(mesh.nodes[problem.recovery.points], solution.stress)[bore] - exact)
    sides = np.array([RADIUS * ratio / through, RADIUS * np.pi / 32, RADIUS / 10])

    flat = domains.mapped(through, 16, domains.ring(RADIUS, outer, 0, 90))
    bend = PlaneModel(flat, 210e3, 0.3, "strain").solve(
        dirichlet={"bottom": (None, 0.0), "top": (0.0, None)},
        tractions={"left": lambda _, normals: -PRESSURE * normals},
    )
    inside = flat.edge_nodes("left")
    places, stress = flat.nodes[inside], bend.stress[inside]
    plane = np.abs(_around(places, stress[:, [0, 1, 2, 3]]) - exact)

    def wall(s, t):
        return RADIUS + (outer - RADIUS) * s, RADIUS * ratio * t

    section = domains.mapped(4 * through, 2, wall)
    turned = PlaneModel(section, 210e3, 0.3, "axisymmetric").solve(
        dirichlet={"bottom": (None, 0.0), "top": (None, 0.0)},
        tractions={"left": lambda _, normals: -PRESSURE * normals},
    )
    bore = section.edge_nodes("left")
    hoop = np.abs(turned.stress[bore, 2] - exact)
    moved = np.linalg.norm(bend.displacement[inside], axis=1).mean()
    return Walls(
        float(solid.max() / exact),
        float(sides.max() / sides.min()),
        float(plane.max() / exact),
        float(hoop.max() / exact),
        float(moved / turned.displacement[bore, 0].mean() - 1),
    )


def _around(places, stress):
    """Normal stress around z of xx, yy, zz, xy, ..."""
    c, s = places[:, :2].T / np.linalg.norm(places[:, :2], axis=1)
    return stress[:, 0] * s**2 + stress[:, 1] * c**2 - 2 * stress[:, 3] * c * s


def stretched_patch(aspect, axis):
    """Largest error of an even stress in the patch of MacNeal and Harder, stretched along an axis.

    The field is given on its boundary; over the largest stress.
    """
    mesh = patch()
    nodes = mesh.nodes.copy()
    nodes[:, axis] *= aspect
    stress, _ = solved(Mesh(nodes, mesh.elements, {}, {}, float(aspect)))
    return float(np.abs(stress - EXACT).max() / EXACT.max())
