"""Stiffness, loads and stress against exact solutions of elasticity."""

import numpy as np
import pytest
import skfem
from numpy.testing import assert_allclose
from skfem.models.elasticity import linear_elasticity

import fem.recovery
from bench.scikit_fem import to_scikit_fem
from fem.assembly import Elements, Pattern, full, geometric_stiffness, stiffness
from fem.recovery import Recovery, energy_error, tensor, von_mises
from fem.solvers import factorize
from fem.unit_loads import acceleration_loads, resultants
from fem.unit_solutions import Elastic, rigid_modes, solve_unit_loads
from geometry.meshing import mesh_shape

from .blocks import PIN, block, wrench

STEEL = Elastic(210e3, 0.3, 7.85e-9)
FOAM = Elastic(210e3, 0.0, 7.85e-9)  # without Poisson's effect bars are exactly one-dimensional


@pytest.fixture(scope="module")
def distorted():
    return block((3, 2, 2), (12.0, 5.0, 4.0), distortion=0.25)


@pytest.fixture(scope="module")
def pin():
    return Elements(mesh_shape(PIN, fineness=0.4))


def solve_with_given(mesh, material, given, values, load):
    """Displacement with some unknowns given, by the package's own factorisation."""
    upper = stiffness(Pattern(Elements(mesh)), material.youngs_modulus, material.poisson_ratio)
    free = np.setdiff1d(np.arange(upper.shape[0]), given)
    displacement = np.zeros(upper.shape[0])
    displacement[given] = values
    right = load - full(upper) @ displacement
    displacement[free] = factorize(upper[free][:, free].tocsr()).solve(right[free])[0]
    return displacement


def test_a_uniform_stress_is_exact_on_a_distorted_mesh(distorted):
    """Patch test (Irons), with the unit load of an end face. cond(K) eps = 1e-12 here."""
    solutions = solve_unit_loads(distorted, STEEL)
    coefficients, _ = solutions.coefficients(
        {"start": wrench(-600.0), "end": wrench(600.0)}, np.zeros((1, 4))
    )
    stress = solutions.basis @ coefficients[:, 0]
    assert_allclose(stress, np.tile([30.0, 0, 0, 0, 0, 0], (len(stress), 1)), atol=1e-8)


def test_any_linear_displacement_is_exact_on_a_distorted_mesh(distorted):
    """Patch test with all nine slopes: prescribed on the boundary, recovered inside; round-off."""
    slopes = 1e-4 * np.array([[3.0, -1.0, 2.0], [0.5, 4.0, -2.5], [1.5, 2.0, -3.5]])
    exact = (distorted.nodes @ slopes.T).ravel()
    given = (3 * distorted.surface_nodes[:, None] + np.arange(3)).ravel()
    found = solve_with_given(distorted, STEEL, given, exact[given], np.zeros(len(exact)))
    assert len(given) < len(exact)
    assert_allclose(found, exact, rtol=0, atol=1e-12 * np.abs(exact).max() * 100)


def test_a_rigid_motion_needs_no_force(pin):
    """Translations and small rotations: K R = 0 to round-off of the largest entry, on curved
    elements too.
    """
    matrix = full(stiffness(Pattern(pin), 210e3, 0.3))
    modes = rigid_modes(pin.mesh.nodes)
    assert np.linalg.matrix_rank(modes) == 6
    assert np.abs(matrix @ modes).max() < 1e-11 * np.abs(matrix).max() * np.abs(modes).max()


def test_the_stiffness_is_that_of_scikit_fem_entry_by_entry(pin):
    """scikit-fem's own linear_elasticity on the same curved elements and quadrature; round-off."""
    vector = skfem.ElementVector(skfem.ElementTetP2())
    basis = skfem.CellBasis(to_scikit_fem(pin.mesh), vector, intorder=2)
    lame, shear = 210e3 * 0.3 / (1.3 * 0.4), 210e3 / 2.6
    theirs = linear_elasticity(lame, shear).assemble(basis).tocsr()
    to_ours = np.empty(basis.N, dtype=int)
    for k in range(basis.element_dofs.shape[0]):  # element by element: 10 nodes of 3 components
        to_ours[basis.element_dofs[k]] = 3 * pin.mesh.elements[:, k // 3] + k % 3
    order = np.argsort(to_ours)
    ours = full(stiffness(Pattern(pin), 210e3, 0.3))
    difference = ours - theirs[order][:, order]
    assert np.abs(difference).max() < 1e-12 * np.abs(ours).max()


def test_the_geometric_stiffness_of_a_bar_under_tension_is_force_over_length():
    """u' K_s u = sum of sigma (du_y/dx)^2: a bar turned by a small slope gains F L slope^2."""
    mesh = block((3, 1, 1), (30.0, 4.0, 5.0))
    elements = Elements(mesh)
    stress = np.zeros((*elements.weights.shape, 6))
    stress[..., 0] = 7.0
    matrix = full(geometric_stiffness(Pattern(elements), tensor(stress)))
    turned = np.zeros_like(mesh.nodes)
    turned[:, 1] = 1e-3 * mesh.nodes[:, 0]
    energy = turned.ravel() @ matrix @ turned.ravel()
    assert_allclose(energy, 7.0 * 20.0 * 30.0 * 1e-6, rtol=1e-12)


@pytest.mark.parametrize(("quantity", "order"), [("displacement", 3), ("stress", 2)])
def test_errors_fall_at_the_order_of_quadratic_elements(quantity, order):
    """u = grad(e^x sin y): no volume change, no body force. Displacement O(h^3), stress O(h^2).

    Stress at the four integration points is better than O(h^2) on regular meshes; 0.35 each way
    still tells one order from the next.
    """
    errors = []
    for n in (2, 4, 8):
        mesh = block((n, n, 1), (2.0, 2.0, 2.0 / n), distortion=0.0)
        x, y, _ = mesh.nodes.T
        field = [np.exp(x) * np.sin(y), np.exp(x) * np.cos(y), 0 * x]
        exact = 1e-3 * np.stack(field, axis=1).ravel()
        on = mesh.nodes[:, :2]
        rim = ((on < 1e-9) | (on > 2 - 1e-9)).any(axis=1)
        given = np.union1d(
            (3 * np.flatnonzero(rim)[:, None] + np.arange(3)).ravel(),
            3 * np.arange(len(mesh.nodes)) + 2,  # plane strain
        )
        load = np.zeros(len(exact))
        found = solve_with_given(mesh, STEEL, given, exact[given], load)
        elements = Elements(mesh)
        if quantity == "displacement":
            u = found.reshape(-1, 3)[mesh.elements]
            at = np.einsum("qa,eax->eqx", elements.values, u)[..., 0]
            px, py, _ = np.moveaxis(elements.points, -1, 0)
            wanted = 1e-3 * np.exp(px) * np.sin(py)
        else:
            recovery = Recovery(elements, 210e3, 0.3)
            at = recovery.quadrature_stress(found[:, None], slice(None))[:, :, 0, 0]
            px, py, _ = np.moveaxis(elements.points, -1, 0)
            wanted = 210e3 / 1.3 * 1e-3 * np.exp(px) * np.sin(py)  # 2 mu du_x/dx
        errors.append(np.sqrt((elements.weights * (at - wanted) ** 2).sum() * n))
    assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), order, atol=0.35)


def test_a_bar_hanging_along_y_carries_the_weight_below():
    """Accelerated by a_y with its top held: sigma = rho a (y from the free end).

    With nu = 0 the displacement is quadratic and the elements hold it; round-off, 1e-10.
    """
    mesh = block((1, 4, 1), (3.0, 20.0, 3.0))
    elements = Elements(mesh)
    top = np.flatnonzero(mesh.nodes[:, 1] > 20 - 1e-9)
    given = (3 * top[:, None] + np.arange(3)).ravel()
    load = 9810.0 * acceleration_loads(elements, FOAM.density)[:, 1]
    displacement = solve_with_given(mesh, FOAM, given, 0.0, load)
    recovery = Recovery(elements, FOAM.youngs_modulus, 0.0)
    stress = recovery.surface_stress(displacement)[:, :, 0]
    exact = np.zeros_like(stress)
    exact[:, 1] = FOAM.density * 9810.0 * mesh.nodes[recovery.points, 1]
    assert_allclose(stress, exact, rtol=0, atol=1e-10 * exact.max())


def test_a_bar_pulled_along_x_carries_the_inertia_behind():
    """The pull at the end balances the inertia; nothing at the free start. Exact as above."""
    mesh = block((4, 1, 1), (20.0, 3.0, 3.0))
    solutions = solve_unit_loads(mesh, FOAM)
    pull = FOAM.density * 180.0 * 5e5
    coefficients, added = solutions.coefficients(
        {"start": wrench(), "end": wrench(pull)}, np.array([[5e5, 0.0, 0.0, 0.0]])
    )
    stress = solutions.basis @ coefficients[:, 0]
    exact = FOAM.density * 5e5 * mesh.nodes[solutions.recovery.points, 0]
    assert_allclose(stress[:, 0], exact, rtol=0, atol=1e-9 * exact.max())
    assert np.abs(added).max() < 1e-9 * 5e5


def test_a_bar_that_turns_about_its_middle_is_pulled_apart():
    """sigma = rho omega^2 (L^2 - x^2)/2: tension, largest in the middle.

    The displacement is cubic: an element of length h = L/8 misses h^2/8 of the curvature, 1/256 of
    the peak at L = 8 h; twice that is allowed.
    """
    half, omega2 = 40.0, 1e4
    mesh = block((16, 1, 1), (2 * half, 2.0, 2.0), start=(-half, -1.0, -1.0))
    solutions = solve_unit_loads(mesh, FOAM)
    coefficients, added = solutions.coefficients(
        {"start": wrench(), "end": wrench()}, np.array([[0.0, 0.0, 0.0, omega2]])
    )
    stress = (solutions.basis @ coefficients[:, 0])[:, 0]
    x = mesh.nodes[solutions.recovery.points, 0]
    exact = FOAM.density * omega2 * (half**2 - x**2) / 2
    assert_allclose(stress, exact, rtol=0, atol=exact.max() / 128)
    assert np.abs(added).max() < 1e-9 * omega2 * half


def test_inertia_loads_have_the_resultants_of_a_rigid_body(pin):
    """About the frame origin: -m a, -(I + m c^2) alpha, m c omega^2. Round-off of the quadrature
    on straight-sided elements.
    """
    mesh = block((3, 2, 2), (12.0, 5.0, 4.0), start=(2.0, 1.0, -2.0), distortion=0.2)
    properties = mesh.mass_properties(STEEL.density)
    m, (cx, cy, _) = properties.mass, properties.centre
    got = resultants(Elements(mesh), acceleration_loads(Elements(mesh), STEEL.density), np.zeros(3))
    about_origin = properties.inertia + m * (cx**2 + cy**2)
    expected = np.array(
        [
            [-m, 0, m * cy, m * cx],
            [0, -m, -m * cx, m * cy],
            [m * cy, -m * cx, -about_origin, 0],
        ]
    )
    assert_allclose(got[[0, 1, 5]], expected, rtol=0, atol=1e-12 * about_origin)


def test_a_linear_stress_field_is_recovered_exactly(distorted):
    """A quadratic displacement on straight-sided elements: every component linear in x, y, z."""
    x, y, z = distorted.nodes.T
    displacement = 1e-5 * np.stack(
        [x * x + 2 * x * y - z * z, y * y - 3 * y * z + x * z, 2 * z * z + x * y - y * y], axis=1
    )
    recovery = Recovery(Elements(distorted), 210e3, 0.3)
    stress = recovery.surface_stress(displacement.ravel())[:, :, 0]
    x, y, z = distorted.nodes[recovery.points].T
    slope = 1e-5 * np.array(
        [
            [2 * x + 2 * y, 2 * x, -2 * z],
            [z, 2 * y - 3 * z, -3 * y + x],
            [y, x - 2 * y, 4 * z],
        ]
    )
    lame, shear = 210e3 * 0.3 / (1.3 * 0.4), 210e3 / 2.6
    exact = shear * (slope + slope.swapaxes(0, 1))
    exact[[0, 1, 2], [0, 1, 2]] += lame * np.trace(slope)
    components = exact[[0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]].T  # xx, yy, zz, xy, yz, zx
    assert_allclose(stress, components, rtol=0, atol=1e-11 * np.abs(components).max())
    scatter = recovery.scatter(displacement.ravel())
    assert scatter.max() < 1e-10 * np.abs(components).max()


def test_the_error_of_a_field_is_counted_as_energy(distorted, monkeypatch):
    """Of a pull s and an error of shear t: 2 (1 + nu) t^2/s^2; a linear stress field has none."""
    recovery = Recovery(Elements(distorted), 210e3, 0.3)
    x, y, z = distorted.nodes.T
    pulled = 1e-3 * np.stack([x, -0.3 * y, -0.3 * z], axis=1)
    assert energy_error(recovery, pulled.ravel()) < 1e-20
    bent = 1e-5 * np.stack([x * x + 2 * x * y, y * y - z * x, z * y], axis=1)
    assert energy_error(recovery, bent.ravel()) < 1e-20
    off = np.array([0.0, 0.0, 0.0, 0.0, 0.2 * 210.0, 0.0])
    monkeypatch.setattr(fem.recovery, "_smoothed", lambda _, raw: raw + off)
    assert_allclose(energy_error(recovery, pulled.ravel()), 2 * 1.3 * 0.2**2, rtol=1e-9)


def test_a_node_of_a_single_element_takes_the_scatter_around_it():
    """xx = E x^2: elements disagree by the second derivative times their size squared everywhere.

    One element meets at the middle of most edges of a block; it would agree with itself exactly.
    """
    mesh = block((3, 2, 2), (3.0, 2.0, 2.0), distortion=0.2)
    recovery = Recovery(Elements(mesh), 210e3, 0.0)
    moved = np.zeros_like(mesh.nodes)
    moved[:, 0] = 1e-3 * mesh.nodes[:, 0] ** 3 / 3
    scatter = recovery.scatter(moved.ravel())
    meet = np.bincount(mesh.elements.ravel(), minlength=len(mesh.nodes))[recovery.points]
    assert (meet == 1).sum() > 10
    usual = np.median(scatter[meet > 1])
    assert scatter[meet == 1].min() > usual / 4
    assert scatter[meet == 1].max() <= scatter[meet > 1].max()
    single = np.flatnonzero(meet == 1)[:3]
    assert_allclose(recovery.scatter(moved.ravel(), single), scatter[single], rtol=1e-12)


@pytest.mark.parametrize(
    ("stress", "equivalent"),
    [
        ([100, 0, 0, 0, 0, 0], 100),
        ([50, 50, 50, 0, 0, 0], 0),
        ([0, 0, 0, 10, 0, 0], 10 * 3**0.5),
        ([0, 0, 0, 0, 0, 10], 10 * 3**0.5),
        ([120, 40, 0, 30, 0, 0], (120**2 - 120 * 40 + 40**2 + 3 * 30**2) ** 0.5),
    ],
)
def test_von_mises_of_simple_states_is_their_textbook_value(stress, equivalent):
    assert_allclose(von_mises(np.array(stress, dtype=float)), equivalent, rtol=1e-14, atol=1e-12)


@pytest.mark.parametrize(
    ("constants", "says"),
    [((0, 0.3, 1e-9), "Young"), ((1e5, 0.5, 1e-9), "Poisson"), ((1e5, 0.3, -1e-9), "density")],
)
def test_impossible_elastic_constants_are_refused(constants, says):
    with pytest.raises(ValueError, match=says):
        Elastic(*constants)
