"""Mass matrix and frequencies of solids: scikit-fem's mass, rigid motions, refusals, tendencies."""

from dataclasses import replace

import numpy as np
import pytest
import skfem
from numpy.testing import assert_allclose
from skfem.helpers import dot

from bench.fixed_solid import fixed_solid, free_vibration
from bench.scikit_fem import to_scikit_fem
from fem.assembly import Elements, Pattern, full
from fem.lowest_modes import link_vibration, mass, solid_vibration
from fem.unit_solutions import Elastic, rigid_modes, solve_unit_loads
from geometry.mesh import MeshError
from geometry.meshing import mesh_shape

from .blocks import PIN, block

STEEL = Elastic(210e3, 0.3, 7.85e-9)
SIZES = (80.0, 8.0, 6.0)


@pytest.fixture(scope="module")
def bar():
    return solve_unit_loads(block((6, 1, 1), SIZES), STEEL)


def test_the_mass_of_curved_elements_is_that_of_scikit_fem():
    """One rule of degree 4 in both: round-off."""
    mesh = mesh_shape(PIN, fineness=0.4)
    element = skfem.ElementVector(skfem.ElementTetP2())
    basis = skfem.CellBasis(to_scikit_fem(mesh), element, intorder=4)
    theirs = skfem.BilinearForm(lambda u, v, w: dot(u, v)).assemble(basis)
    to_ours = np.empty(basis.N, dtype=int)
    for k in range(30):
        to_ours[basis.element_dofs[k]] = 3 * mesh.elements[:, k // 3] + k % 3
    order = np.argsort(to_ours)
    ours = full(mass(Pattern(Elements(mesh)), 2.0))
    apart = abs(ours - 2.0 * theirs.tocsr()[order][:, order]).max()
    assert apart < 1e-13 * abs(ours).max()


def test_rigid_motion_has_the_mass_and_inertia_of_the_bar(bar):
    """MD-04: density times volume in each direction, m (b^2 + c^2) / 12 about its middle; 1e-10."""
    modes = rigid_modes(bar.mesh.nodes)
    kinetic = modes.T @ (full(mass(bar.pattern, STEEL.density)) @ modes)
    whole = STEEL.density * np.prod(SIZES)
    a, b, c = np.square(SIZES)
    turning = whole * np.array([b + c, a + c, a + b]) / 12
    middle = bar.mesh.nodes.mean(axis=0) - np.array(SIZES) / 2
    assert_allclose(middle, 0.0, atol=1e-12)
    assert_allclose(np.diag(kinetic), [whole] * 3 + list(turning), rtol=1e-10)


def test_modes_of_a_floating_bar_carry_no_momentum_and_are_orthogonal(bar):
    found = free_vibration(bar, count=5)
    shapes = found.shapes.reshape(5, -1).T
    matrix = full(mass(bar.pattern, STEEL.density))
    kinetic = shapes.T @ (matrix @ shapes)
    size = np.sqrt(np.diag(kinetic))
    assert_allclose(kinetic / size / size[:, None], np.eye(5), atol=1e-8)
    rigid = rigid_modes(bar.mesh.nodes)
    own = np.sqrt(np.einsum("ni,ni->i", rigid, matrix @ rigid))
    assert_allclose(rigid.T @ (matrix @ shapes) / own[:, None] / size, 0.0, atol=1e-9)


def test_frequencies_scale_with_the_root_of_stiffness_over_density(bar):
    mesh = bar.mesh
    other = solve_unit_loads(mesh, Elastic(4 * 210e3, 0.3, 9 * 7.85e-9))
    for tilt_held in (False, True):
        one, two = (link_vibration(part, tilt_held=tilt_held) for part in (bar, other))
        assert_allclose(two.angular, one.angular * 2 / 3, rtol=1e-9)
        assert_allclose(two.proven, one.proven * 2 / 3, rtol=1e-6)


def test_holding_more_raises_every_frequency(bar):
    free, held = (link_vibration(bar, tilt_held=t, count=4).hertz for t in (False, True))
    assert (held > free * (1 - 1e-9)).all()
    assert held.sum() > 1.1 * free.sum()


def test_a_stack_half_a_part_and_a_part_without_mass_are_refused(bar):
    with pytest.raises(ValueError, match="density above 0"):
        free_vibration(replace(bar, material=replace(STEEL, density=0.0)))
    with pytest.raises(ValueError, match="number of modes"):
        free_vibration(bar, count=0)


@pytest.mark.parametrize("ask", [free_vibration, lambda part: link_vibration(part, tilt_held=True)])
def test_half_of_a_part_is_refused(bar, ask, monkeypatch):
    def refuse(_, what):
        raise MeshError(f"{what} needs the whole part")

    monkeypatch.setattr(type(bar.mesh), "check_whole", refuse)
    with pytest.raises(MeshError, match=r"vibration.* needs the whole part"):
        ask(bar)


@pytest.mark.parametrize("ask", [free_vibration, lambda part: link_vibration(part, tilt_held=True)])
def test_a_stack_of_tied_bodies_is_refused(bar, ask):
    with pytest.raises(ValueError, match="vibration is computed for parts of one body"):
        ask(replace(bar, ties=object()))


def test_a_solid_that_can_move_is_refused(bar):
    with pytest.raises(ValueError, match="at least six"):
        fixed_solid(bar.mesh, STEEL, np.arange(3))


def test_conditions_that_say_the_same_twice_are_refused(bar):
    row = np.zeros((1, bar.stiffness.shape[0]))
    row[0, -1] = 1.0
    fixed = np.flatnonzero(np.repeat(bar.mesh.nodes[:, 0] < 1e-9, 3))
    with pytest.raises(ValueError, match="of 2 conditions only 1 are independent"):
        fixed_solid(bar.mesh, STEEL, fixed, np.concatenate([row, 2 * row]))
    one = solid_vibration(fixed_solid(bar.mesh, STEEL, fixed, row), count=1)
    none = solid_vibration(fixed_solid(bar.mesh, STEEL, fixed), count=1)
    assert one.angular[0] > 1.01 * none.angular[0]


def test_an_unproven_answer_says_so(bar):
    """The same frequencies, but `proven` is 0."""
    proven, quick = (free_vibration(bar, count=3, prove=p) for p in (True, False))
    assert_allclose(quick.angular, proven.angular, rtol=1e-12)
    assert quick.proven == 0.0
    assert proven.proven > proven.angular[-1]


def test_all_modes_of_a_tiny_solid_are_found_and_counted():
    """More modes are asked for than one block holds; the last are many in little room."""
    mesh = block((2, 1, 1), (20.0, 9.0, 7.0))
    solid = fixed_solid(mesh, STEEL, np.flatnonzero(np.repeat(mesh.nodes[:, 0] < 1e-9, 3)))
    found = solid_vibration(solid, count=12)
    assert len(found.angular) == 12
    assert (np.diff(found.angular) > 0).all()
