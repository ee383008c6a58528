"""Gradients and sums over element matrices, against scikit-fem's own and other node numbers."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
import skfem
from numpy.testing import assert_allclose

from bench.scikit_fem import to_scikit_fem
from fem.assembly import Elements, Pattern, full, geometric_stiffness, stiffness
from geometry.meshing import mesh_shape

from .blocks import PIN, block

YOUNG, POISSON = 210e3, 0.3


@pytest.fixture(scope="module")
def pin():
    return mesh_shape(PIN, fineness=0.4)


@pytest.fixture(scope="module")
def basis(pin):
    return skfem.CellBasis(to_scikit_fem(pin), skfem.ElementTetP2(), intorder=2)


def test_gradients_on_curved_elements_are_those_of_scikit_fem(pin, basis):
    theirs = np.stack([field[0].grad for field in basis.basis])  # (10, 3, e, q)
    theirs = np.moveaxis(theirs, (2, 3, 0, 1), (0, 1, 2, 3))
    ours = Elements(pin).gradients
    assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())


def test_weights_points_and_values_are_those_of_scikit_fem(pin, basis):
    elements = Elements(pin)
    assert_allclose(elements.weights, basis.dx, rtol=1e-12)
    theirs = np.moveaxis(np.asarray(basis.global_coordinates()), 0, -1)
    assert_allclose(elements.points, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())
    values = np.stack([np.asarray(field[0])[0] for field in basis.basis], axis=1)
    assert_allclose(elements.values, values, rtol=0, atol=1e-15)
    assert_allclose(elements.local_points, basis.X.T, rtol=0, atol=0)


def test_the_gradient_of_a_quadratic_field_is_exact_inside_a_straight_element():
    """u = x y + z**2: slopes y, x, 2 z at every integration point; round-off."""
    mesh = block((2, 2, 2), (3.0, 2.0, 1.0), distortion=0.2)
    elements = Elements(mesh)
    x, y, z = mesh.nodes.T
    field = (x * y + z**2)[mesh.elements]
    found = np.einsum("eqai,ea->eqi", elements.gradients, field)
    px, py, pz = np.moveaxis(elements.points, -1, 0)
    assert_allclose(found, np.stack([py, px, 2 * pz], axis=-1), rtol=0, atol=1e-12)


def test_the_matrix_does_not_depend_on_the_numbers_of_the_nodes(pin):
    """Blocks whose nodes swap their order are transposed: a slip there shows; round-off."""
    moved = np.random.default_rng(5).permutation(len(pin.nodes))  # new number of each node
    nodes = np.empty_like(pin.nodes)
    nodes[moved] = pin.nodes
    other = replace(pin, nodes=nodes, elements=moved[pin.elements], surfaces={}, interfaces={})
    first = full(stiffness(Pattern(Elements(pin)), YOUNG, POISSON))
    second = full(stiffness(Pattern(Elements(other)), YOUNG, POISSON))
    unknowns = (3 * moved[:, None] + np.arange(3)).ravel()
    difference = abs(second[unknowns][:, unknowns] - first)
    assert difference.max() < 1e-13 * abs(first).max()


def test_all_matrices_of_a_part_share_the_upper_triangle_of_its_node_pairs(pin):
    pattern = Pattern(Elements(pin))
    stress = np.zeros((len(pin.elements), 4, 3, 3))
    stress[:, :, 0, 0] = 1.0
    first, second = stiffness(pattern, YOUNG, POISSON), geometric_stiffness(pattern, stress)
    assert np.array_equal(first.indices, second.indices)
    assert np.array_equal(first.indptr, second.indptr)
    count = len(pin.nodes)
    touch = np.zeros((count, count), dtype=bool)
    for nodes in pin.elements:
        touch[np.ix_(nodes, nodes)] = True
    expected = np.triu(np.kron(touch, np.ones((3, 3), dtype=bool)))
    assert np.array_equal(np.flatnonzero(expected.any(axis=1)), np.arange(3 * count))
    pattern_of = sp.csr_array(
        (np.ones(first.nnz, dtype=bool), first.indices, first.indptr), first.shape
    )
    assert np.array_equal(pattern_of.toarray(), expected)


def test_the_geometric_stiffness_is_that_of_scikit_fem(pin):
    """Bilinear form grad u . sigma grad v with a stress that differs from point to point."""
    elements = Elements(pin)
    x, y, z = np.moveaxis(elements.points, -1, 0)
    zero = np.zeros_like(x)
    rows = [[x, y, zero], [y, z, x], [zero, x, -y]]
    stress = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)

    @skfem.BilinearForm
    def form(u, v, w):
        return np.einsum("ieq,ijeq,jeq->eq", u.grad, w["s"], v.grad)

    basis = skfem.CellBasis(to_scikit_fem(pin), skfem.ElementTetP2(), intorder=2)
    theirs = form.assemble(basis, s=np.moveaxis(stress, (2, 3), (0, 1))).tocsr()
    place = np.empty(basis.N, dtype=int)
    place[basis.element_dofs.T] = pin.elements
    order = np.argsort(place)
    ours = full(geometric_stiffness(Pattern(elements), stress))[1::3][:, 1::3]
    difference = abs(ours - theirs[order][:, order])
    assert difference.max() < 1e-12 * abs(ours).max()


def test_assembly_repeats_to_the_last_bit(pin):
    first, second = (stiffness(Pattern(Elements(pin)), YOUNG, POISSON) for _ in range(2))
    assert np.array_equal(first.data, second.data)
