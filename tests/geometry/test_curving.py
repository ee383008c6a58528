"""Folded curved elements are mended inside of the part; the measure of that is a lower bound."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry import meshing
from geometry.curving import ENOUGH, bent, least_coefficients
from geometry.mesh import TET_EDGES, shape_gradients
from geometry.meshing import mesh_shape
from geometry.parts import ToggleBar

CORNERS = np.array([[0, 0, 0], [10, 0, 0], [0, 10, 0], [0, 0, 10]], dtype=float)
BAR = ToggleBar(
    length=250, width=80, wall=6.3, inner_radius=3, hole=44, overhang=40, cutout_length=56,
    cutout_corner=5,
)  # fmt: skip


def curved(corners, middles):
    """One ten-node tetrahedron, the middles of some edges moved."""
    nodes = np.vstack([corners, [(corners[i] + corners[j]) / 2 for i, j in TET_EDGES]])
    for edge, move in middles.items():
        nodes[4 + edge] += move
    return nodes, np.arange(10)[None]


def sampled(nodes, element):
    """Least det J over the straight one's, at 286 points of an element."""
    steps = np.array([(i, j, k) for i in range(11) for j in range(11) for k in range(11)]) / 10
    points = steps[steps.sum(axis=1) < 1 + 1e-9]
    jacobians = np.einsum("ax,qar->qxr", nodes[element], shape_gradients(points))
    straight = np.linalg.det(nodes[element[1:4]] - nodes[element[0]])
    return np.linalg.det(jacobians).min() / straight


def test_the_measure_of_a_straight_element_is_one():
    assert_allclose(least_coefficients(*curved(CORNERS, {})), 1.0, rtol=1e-12)


def test_the_measure_is_not_above_what_an_element_has_anywhere():
    """A polynomial lies in the hull of its Bernstein coefficients; at corners it equals them."""
    random = np.random.default_rng(1)
    for _ in range(50):
        moves = {edge: random.normal(size=3) for edge in range(6)}
        nodes, elements = curved(CORNERS, moves)
        (least,) = least_coefficients(nodes, elements)
        assert least <= sampled(nodes, elements[0]) + 1e-12
    # one middle moved outwards along its edge: det J falls linearly, least at a corner
    nodes, elements = curved(CORNERS, {0: [2.0, 0, 0]})
    assert_allclose(least_coefficients(nodes, elements), sampled(nodes, elements[0]), atol=1e-12)


def test_a_folded_element_is_mended_by_its_inner_edges_alone():
    """The middle of edge 01 bulges inwards and folds the element; edges 03 and 13 are inside."""
    nodes, elements = curved(CORNERS, {0: [0, 0, 3.0]})
    inside = np.array([4 + TET_EDGES.index((0, 3)), 4 + TET_EDGES.index((1, 3))])
    assert sampled(nodes, elements[0]) < 0
    found = bent(nodes, elements, inside)
    moved = np.flatnonzero((found != nodes).any(axis=1))
    assert set(moved) <= set(inside.tolist())
    assert least_coefficients(found, elements)[0] > ENOUGH
    assert sampled(found, elements[0]) > ENOUGH


def test_what_folds_on_a_small_fillet_is_mended_but_for_few_elements(monkeypatch):
    """A toggle bar's inner fillet of 3 mm under elements of 10 mm: over 50 fold, under 10 stay."""
    counts = []

    def watched(nodes, elements, inside):
        found = bent(nodes, elements, inside)
        on_surface = np.setdiff1d(np.arange(len(nodes)), inside)
        assert np.array_equal(found[on_surface], nodes[on_surface])
        counts.append([(least_coefficients(n, elements) < ENOUGH).sum() for n in (nodes, found)])
        return found

    monkeypatch.setattr(meshing, "bent", watched)
    mesh = mesh_shape(BAR, fineness=0.5)
    assert counts[0][0] > 50
    assert counts[0][1] < 10
    assert mesh.jacobian_minimum > 0


@pytest.mark.slow
def test_rounding_does_not_decide_where_nodes_go(monkeypatch):
    """The last digit of a processor's sums; a mend that ended early went 0.05 mm elsewhere."""
    away = []

    def twice(name):
        mend = getattr(meshing, name)

        def watched(nodes, elements, where):
            other = nodes * (1 + 1e-15 * np.random.default_rng(1).normal(size=nodes.shape))
            found = mend(nodes, elements, where)
            away.append(np.abs(mend(other, elements, where) - found).max())
            return found

        monkeypatch.setattr(meshing, name, watched)

    twice("bent")
    twice("moved")
    mesh_shape(BAR)
    assert len(away) > 1
    assert max(away) < 1e-6
