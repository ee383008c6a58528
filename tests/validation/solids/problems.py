"""The solid problems whose answers are known: body, supports and loads on a given mesh.

Units N, mm, s, t. Each function takes a mesh with the sides of `meshes.mapped` or faces of the
same names, and returns what was solved.
"""

import numpy as np

from fem.unit_solutions import Elastic, determinate_hold

from ...boundary_value import (
    SolidProblem,
    body_load,
    pressure_load,
    traction_load,
    uniform_load,
    unknowns,
)
from .meshes import mapped, on

STEEL = Elastic(210e3, 0.3, 7.85e-9)


def held(mesh, *supports, line=None):
    """Unknowns of sides, given as (name, axes), and of more nodes as (nodes, axes)."""
    parts = [unknowns(on(mesh, name), axes) for name, axes in supports]
    if line is not None:
        parts.append(unknowns(*line))
    return np.unique(np.concatenate(parts))


def pressed_ring(mesh):
    """FE-04: quarter of a thick cylinder, 100 MPa inside, no strain along z."""
    problem = SolidProblem(
        mesh, STEEL, held(mesh, ("z0", "z"), ("z1", "z"), ("y0", "y"), ("y1", "x"))
    )
    return problem.solve(pressure_load(problem.elements, "x0", 100.0))


def thick_plate(mesh):
    """FE-08, NAFEMS LE10: quarter of an elliptic plate, 1 MPa on its top; mm, MPa."""
    rim = on(mesh, "x1")
    line = rim[np.abs(mesh.nodes[rim, 2] - 300) < 1e-6]
    supports = held(mesh, ("y1", "x"), ("y0", "y"), ("x1", "xy"), line=(line, "z"))
    problem = SolidProblem(mesh, STEEL, supports)
    return problem.solve(pressure_load(problem.elements, "z1", 1.0))


def thick_plate_mesh(counts):
    """LE10's quarter plate; elements towards its hole and D are half the mean size."""

    def mapping(x, y, z):
        x, angle = (1 + x) * x / 2, np.pi / 4 * (1 + y) * y
        return 1e3 * (2 + 1.25 * x) * np.cos(angle), 1e3 * (1 + 1.75 * x) * np.sin(angle), 600 * z

    return mapped(counts, mapping, np.pi / 4 * (3.25 * 2.75 - 2) * 0.6e9)


def twisted_beam(counts):
    """FE-12, MacNeal and Harder: tip deflections along loads (a) and (b); the case's own units."""

    def mapping(x, y, z):
        angle, width, depth = np.pi / 2 * x, 1.1 * (y - 0.5), 0.32 * (z - 0.5)
        return (
            12 * x,
            width * np.cos(angle) - depth * np.sin(angle),
            width * np.sin(angle) + depth * np.cos(angle),
        )

    mesh = mapped(counts, mapping, 12 * 1.1 * 0.32)
    problem = SolidProblem(mesh, Elastic(29e6, 0.22, 0.0), held(mesh, ("x0", "xyz")))
    tips = []
    for axis in (2, 1):  # the section has turned by 90 degrees: the width points along z
        force = np.eye(3)[axis]
        solution = problem.solve(uniform_load(problem.elements, "x1", force))
        tips.append(float(solution.displacement_at((12, 0, 0))[axis]))
    return tips


def twist(x_axis_sign, width, height):
    """Traction on an end face normal to x that is linear across it and has a torque of 1 N mm."""
    second = width * height * (width**2 + height**2) / 12

    def traction(points, _):
        _x, y, z = np.moveaxis(points, -1, 0)
        return x_axis_sign * np.stack([0 * y, -z, y], axis=-1) / second

    return traction


def twisted_bar(mesh, width, height):
    """FE-14: a bar along x about its axis under end torques of 1 N mm, free to warp."""
    problem = SolidProblem(mesh, STEEL, determinate_hold(mesh.nodes))
    load = traction_load(problem.elements, "x1", twist(1, width, height))
    return problem.solve(load + traction_load(problem.elements, "x0", twist(-1, width, height)))


def turning_disc(mesh, omega=1000.0):
    """FE-17: quarter disc turning about z, its middle plane z = 0 held along z."""

    def force(points):
        return STEEL.density * omega**2 * points * [1, 1, 0]

    problem = SolidProblem(mesh, STEEL, held(mesh, ("y0", "y"), ("y1", "x"), ("z0", "z")))
    return problem.solve(body_load(problem.elements, force))


def turning_bar(mesh, omega=300.0):
    """FE-18: a bar along x turning about its start, which rolls on x = 0; nu = 0, no side force.

    So it is one-dimensional exactly: sigma = rho omega^2 (L^2 - x^2) / 2.
    """

    def force(points):
        return STEEL.density * omega**2 * points * [1, 0, 0]

    material = Elastic(210e3, 0.0, 7.85e-9)
    problem = SolidProblem(mesh, material, held(mesh, ("x0", "x"), ("y0", "y"), ("z0", "z")))
    return problem.solve(body_load(problem.elements, force))
