"""Orders of convergence with a displacement made up, and the body force that belongs to it."""

import numpy as np
import pytest
import skfem
from numpy.testing import assert_allclose

from fem.unit_solutions import Elastic
from geometry.mesh import _shape, shape_gradients

from ...boundary_value import SolidProblem, body_load, traction_load, unknowns
from .meshes import mapped, on

MATERIAL = Elastic(210e3, 0.3, 0.0)
LAME, SHEAR = 210e3 * 0.3 / (1.3 * 0.4), 210e3 / 2.6
SIZE = np.array([1e-3, -2e-3, 1.5e-3])  # u_i = SIZE_i sin(WAVE_i . x + PHASE_i)
WAVE = np.array([[1.1, 0.7, -0.5], [-0.6, 1.3, 0.8], [0.9, -0.4, 1.2]])
PHASE = np.array([0.3, 0.8, -0.4])


def displacement(points):
    return SIZE * np.sin(points @ WAVE.T + PHASE)


def slopes(points):
    """d u_i / d x_j."""
    return (SIZE * np.cos(points @ WAVE.T + PHASE))[..., None] * WAVE


def stress(points):
    slope = slopes(points)
    symmetric = slope + np.swapaxes(slope, -1, -2)
    trace = np.trace(slope, axis1=-2, axis2=-1)
    return SHEAR * symmetric + LAME * trace[..., None, None] * np.eye(3)


def force(points):
    """-div sigma = -mu laplace u - (lambda + mu) grad div u."""
    wave = SIZE * np.sin(points @ WAVE.T + PHASE)
    laplace = -wave * (WAVE**2).sum(axis=1)
    gradient = -np.einsum("...i,i,ij->...j", wave, np.diagonal(WAVE), WAVE)
    return -SHEAR * laplace - (LAME + SHEAR) * gradient


def bent_block(n):
    """A block with an even twist, so that its elements and sides are curved."""

    def mapping(x, y, z):
        angle = 0.5 * z
        x, y = 2 * x - 1, 2 * y - 1
        return x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle), 2 * z

    return mapped((n, n, n), mapping, 8.0)


def straight_block(n):
    return mapped((n, n, n), lambda x, y, z: (2 * x, 2 * y, 2 * z), 8.0, distortion=0.15)


def solved(mesh):
    """Given on one side, tractions on the others, so that boundary terms count too."""
    held = unknowns(on(mesh, "x0"))
    problem = SolidProblem(mesh, MATERIAL, held)
    load = body_load(problem.elements, force)
    for side in ("x1", "y0", "y1", "z0", "z1"):
        load += traction_load(
            problem.elements,
            side,
            lambda points, normals: np.einsum("...ij,...j->...i", stress(points), normals),
        )
    return problem.solve(load, displacement(mesh.nodes).ravel()[held])


def norms(solution):
    """L2 error of displacement and energy of the error, by a rule of degree 6."""
    mesh = solution.problem.mesh
    rule, weights = skfem.quadrature.get_quadrature(skfem.refdom.RefTet, 6)
    values, local = _shape(rule.T), shape_gradients(rule.T)
    corners = mesh.nodes[mesh.elements]
    found = solution.displacement.reshape(-1, 3)[mesh.elements]  # (e, 10, 3)
    jacobians = np.einsum("eax,qar->eqxr", corners, local)
    volumes = np.linalg.det(jacobians) * weights
    points = np.einsum("qa,eax->eqx", values, corners)
    off = np.einsum("qa,eax->eqx", values, found) - displacement(points)
    by_local = np.einsum("eai,qar->eqir", found, local)
    slope = by_local @ np.linalg.inv(jacobians) - slopes(points)
    strain = (slope + np.swapaxes(slope, 2, 3)) / 2
    trace = np.trace(strain, axis1=2, axis2=3)
    density = SHEAR * (strain**2).sum(axis=(2, 3)) + LAME / 2 * trace**2
    return np.sqrt((volumes * (off**2).sum(axis=2)).sum()), (volumes * density).sum()


@pytest.mark.parametrize("make", [straight_block, bent_block])
def test_errors_fall_at_the_order_of_quadratic_elements(make):
    """Displacement O(h^3) in L2, energy of the error O(h^4) (that is H1 at order 2); 0.35 tells
    one order from the next. Recovered stress at the surface nodes, the worst of them, at least
    order 1.5: the rule continues linearly from inside to edges and corners.
    """
    errors, worst = [], []
    for n in (2, 4, 8):
        solution = solved(make(n))
        errors.append(norms(solution))
        points = solution.problem.recovery.points
        exact = stress(solution.problem.mesh.nodes[points])
        exact = exact[:, [0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]
        worst.append(np.abs(solution.stress - exact).max() / np.abs(exact).max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert_allclose(orders[:, 0], 3, atol=0.35)
    assert_allclose(orders[:, 1], 4, atol=0.5)
    assert np.log2(np.divide(worst[:-1], worst[1:])).min() > 1.5, worst


def test_the_solved_energy_is_half_the_work_of_loads_and_supports():
    """Clapeyron: u' (f + r) / 2; round-off."""
    solution = solved(straight_block(3))
    held = solution.problem.held
    work = solution.load @ solution.displacement
    work += solution.reactions @ solution.displacement[held]
    assert_allclose(solution.energy, work / 2, rtol=1e-10)
    assert solution.residual < 1e-14
