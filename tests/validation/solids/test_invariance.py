"""FE-21: equilibrium, rigid bodies, rotation, symmetry."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose

from fem.assembly import Elements, Pattern, full, stiffness
from fem.recovery import tensor

from ...boundary_value import SolidProblem, body_load, pressure_load
from .meshes import ring
from .problems import STEEL, held


def pressed(mesh, direction=(0.0, 0.0, 1.0)):
    """A ring held at its upper side, pressed inside, with weight along its axis."""
    problem = SolidProblem(mesh, STEEL, held(mesh, ("z1", "xyz")))
    load = pressure_load(problem.elements, "x0", 80.0)
    axis = np.array(direction)
    load += body_load(problem.elements, lambda points: np.broadcast_to(0.02 * axis, points.shape))
    return problem.solve(load)


def turned(mesh):
    """37 degrees about (1, 2, 3)."""
    angle, axis = np.radians(37), np.array([1.0, 2.0, 3.0]) / np.sqrt(14)
    cross = np.cross(np.eye(3), axis)
    by = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    assert_allclose(by @ by.T, np.eye(3), atol=1e-15)
    return replace(mesh, nodes=mesh.nodes @ by.T), by


def test_a_free_solid_has_six_zero_eigenvalues():
    """Below 1e-9 of the first elastic one, on curved elements."""
    mesh = ring((2, 4, 1), 50.0, 100.0, 40.0)
    values = np.linalg.eigvalsh(full(stiffness(Pattern(Elements(mesh)), 210e3, 0.3)).toarray())
    assert (np.abs(values[:6]) < 1e-9 * values[6]).all()
    assert values[6] > 1.0


def test_reactions_balance_the_loads():
    """Forces and moments, 1e-9 of the load."""
    mesh = ring((3, 6, 2), 50.0, 100.0, 40.0)
    solution = pressed(mesh)
    outer = solution.load.copy()
    outer[solution.problem.held] += solution.reactions
    forces = outer.reshape(-1, 3)
    size = np.abs(solution.load).sum()
    assert size > 1e4
    assert np.abs(forces.sum(axis=0)).max() < 1e-9 * size
    assert np.abs(np.cross(mesh.nodes, forces).sum(axis=0)).max() < 1e-9 * size * 100


def test_a_turned_solid_has_the_same_stress_turned():
    """37 degrees about (1, 2, 3): energy, reactions, stress; 1e-8 (round-off is 1e-12)."""
    mesh = ring((3, 6, 2), 50.0, 100.0, 40.0)
    other, by = turned(mesh)
    one, two = pressed(mesh), pressed(other, by @ [0, 0, 1])
    assert_allclose(two.energy, one.energy, rtol=1e-10)
    moved = one.displacement.reshape(-1, 3) @ by.T
    assert_allclose(two.displacement.reshape(-1, 3), moved, rtol=0, atol=1e-9 * np.abs(moved).max())
    wanted = by @ tensor(one.stress) @ by.T
    found = tensor(two.stress)
    assert_allclose(found, wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())
    assert_allclose(two.scatter, one.scatter, rtol=0, atol=1e-9 * np.abs(wanted).max())


def test_half_a_model_carries_half_the_force():
    """A half ring and its quarter with the symmetry held: supports carry p 2 a h, and half of it.

    The resultant of a pressure depends on the rim of its face only, which is met exactly: 1e-9.
    The bore's stress differs by the mesh, which is not symmetric about the cut.
    """
    half = ring((4, 16, 1), 50.0, 100.0, 25.0, angle=np.pi)
    quarter = ring((4, 8, 1), 50.0, 100.0, 25.0)
    top = np.argmin(np.abs(half.nodes - [0.0, 100.0, 0.0]).sum(axis=1))  # nothing pulls it aside
    flat = (("y0", "y"), ("z0", "z"), ("z1", "z"))
    carried, hoops = [], []
    for mesh, supports in (
        (half, held(half, *flat, ("y1", "y"), line=(np.array([top]), "x"))),
        (quarter, held(quarter, *flat, ("y1", "x"))),
    ):
        problem = SolidProblem(mesh, STEEL, supports)
        solution = problem.solve(pressure_load(problem.elements, "x0", 100.0))
        reactions = np.zeros(3 * len(mesh.nodes))
        reactions[problem.held] = solution.reactions
        carried.append(reactions.reshape(-1, 3).sum(axis=0))
        hoops.append(solution.stress_at((50, 0, 0))[1])
    assert_allclose(carried[0][:2], [0.0, -250e3], rtol=0, atol=1e-9 * 250e3)
    assert_allclose(carried[1][:2], [-125e3, -125e3], rtol=0, atol=1e-9 * 250e3)
    assert_allclose(hoops[0], hoops[1], rtol=5e-3)
