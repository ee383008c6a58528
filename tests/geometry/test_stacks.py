"""Bodies that touch keep nodes of their own and are tied where they touch."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry.mesh import MeshError, boundary_facets
from geometry.meshing import mesh_shape, split_bodies, ties_of
from geometry.shape import Body, faces_where
from tests.bonded import bonded

from .facets import area

NODES = np.arange(60.0).reshape(20, 3)


def body(*nodes):
    """One element of ten nodes that uses these; the others are of no concern."""
    return np.array([[*nodes, *[nodes[-1]] * (10 - len(nodes))]])


def test_nodes_of_two_bodies_are_doubled_and_paired():
    split = split_bodies(NODES, [body(0, 1, 2, 3), body(2, 3, 4)])
    assert split.pairs.tolist() == [[2, 20], [3, 21]]
    assert split.copies[0].tolist() == list(range(20))
    assert split.copies[1][[2, 3, 4]].tolist() == [20, 21, 4]
    assert np.array_equal(split.nodes[20:], NODES[2:4])


def test_a_node_of_three_bodies_is_chained_from_one_to_the_next():
    split = split_bodies(NODES, [body(0, 1), body(1, 2), body(1, 3)])
    assert split.pairs.tolist() == [[1, 20], [20, 21]]
    assert [own[1] for own in split.copies] == [1, 20, 21]


def test_one_body_is_left_as_it_is():
    split = split_bodies(NODES, [body(0, 1, 2)])
    assert np.array_equal(split.nodes, NODES)
    assert ties_of(split.nodes, split.pairs, 0.0) == ()


def test_bodies_that_do_not_touch_are_refused():
    with pytest.raises(MeshError, match="the 3 bodies of the stack fall into 2"):
        split_bodies(NODES, [body(0, 1), body(1, 2), body(5, 6)])


def test_all_pairs_are_tied_along_y_and_those_of_the_bolt_along_x_too():
    nodes = np.array([[0.0, 1, 2], [5, 1, 2], [0, 1, 2], [5, 1, 2]])
    pairs = np.array([[0, 2], [1, 3]])
    ties = {tie.axis: tie.pairs.tolist() for tie in ties_of(nodes, pairs, 5.0)}
    assert ties == {0: [[1, 3]], 1: [[0, 2], [1, 3]], 2: [[1, 3]]}
    assert [tie.axis for tie in ties_of(nodes, pairs, None)] == [1]


def test_along_z_only_the_pair_nearest_the_middle_of_each_two_bodies_is_tied():
    lower = np.array([[5.0, 1, -3], [5, 1, 0.5], [5, 1, 3], [5, 2, -1], [5, 2, 2]])
    nodes = np.concatenate([lower, lower])
    pairs = np.array([[k, k + 5] for k in range(5)])
    ties = {tie.axis: tie.pairs[:, 0].tolist() for tie in ties_of(nodes, pairs, 5.0)}
    assert ties == {0: [0, 1, 2, 3, 4], 1: [0, 1, 2, 3, 4], 2: [1, 3]}


def test_a_bolt_where_no_node_is_is_refused():
    with pytest.raises(MeshError, match="no nodes of the stack lie at the bolt's x = 3 mm"):
        ties_of(NODES, np.array([[0, 1]]), 3.0)


class Pile:
    """Boxes of 10 mm on top of each other, `gap` apart, made conformal; "side" is at x = 10."""

    def __init__(self, count, gap=0.0, stacked=True):
        self.count, self.gap, self.stacked = count, gap, stacked

    def build(self, gmsh):
        occ = gmsh.model.occ
        boxes = [(3, occ.addBox(0, k * (10 + self.gap), 0, 10, 10, 10)) for k in range(self.count)]
        if self.count > 1:
            occ.fragment(boxes[:1], boxes[1:])
        occ.synchronize()
        side = faces_where(gmsh, lambda box, _: bool(box[0] > 9.9))
        return Body({"side": side}, [], 5.0, [], stacked=self.stacked)


def test_a_pile_of_boxes_has_all_its_boxes_volume_and_is_tied_where_they_touch():
    mesh = mesh_shape(Pile(3))
    assert_allclose(mesh.volume, 3000, rtol=1e-12)
    assert [tie.axis for tie in mesh.ties] == [1]
    first, second = mesh.ties[0].pairs.T
    assert np.array_equal(mesh.nodes[first], mesh.nodes[second])
    assert sorted(set(mesh.nodes[first, 1])) == [10, 20]
    assert len(set(mesh.ties[0].pairs.ravel())) == 2 * len(first)


def test_a_bonded_pile_is_the_same_mesh_with_one_node_where_there_were_two():
    mesh = mesh_shape(Pile(3))
    glued = bonded(mesh)
    assert glued.ties == ()
    assert len(glued.nodes) == len(mesh.nodes) - len(mesh.ties[0].pairs)
    assert len(np.unique(glued.nodes, axis=0)) == len(glued.nodes)
    assert np.array_equal(glued.nodes[glued.elements], mesh.nodes[mesh.elements])


def test_a_surface_across_all_boxes_takes_each_boxs_own_nodes():
    mesh = mesh_shape(Pile(3))
    for same in (mesh, bonded(mesh)):
        facets = same.surfaces["side"]
        assert_allclose(area(same, facets), 300, rtol=1e-12)
        assert_allclose(same.nodes[facets][..., 0], 10)
        boundary = {tuple(sorted(facet)) for facet in boundary_facets(same.elements).tolist()}
        assert {tuple(sorted(facet)) for facet in facets.tolist()} <= boundary


def test_a_pile_with_a_gap_is_refused():
    with pytest.raises(MeshError, match="the 2 bodies of the stack fall into 2"):
        mesh_shape(Pile(2, gap=1.0))


def test_a_pile_that_is_no_stack_is_refused():
    with pytest.raises(MeshError, match="one solid, the CAD kernel built 2"):
        mesh_shape(Pile(2, stacked=False))
