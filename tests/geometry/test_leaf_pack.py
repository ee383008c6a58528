"""The hammer's leaf spring: separate leaves, tied across, with the patches where it is loaded."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from geometry.mesh import boundary_facets
from geometry.meshing import mesh_shape
from geometry.parts import LeafPack
from tests.bonded import bonded

from .facets import area

STEEL = 7.85e-9
PACK = LeafPack(
    length=460,
    leaves=3,
    width=60,
    thickness=9.6,
    arm=453.5,
    overhang=26.5,
    clamp_length=80,
    rod_length=40,
    contact_from=427,
    contact_to=448.5,
    contact_length=10,
)
SHORT = replace(PACK, length=90, arm=100, clamp_length=40, contact_from=70, contact_to=90)


@pytest.fixture(scope="module")
def pack():
    return mesh_shape(PACK)


def test_the_pack_has_the_mass_properties_of_a_block(pack):
    """3 x 60 x 9.6 x 940 mm of steel, 12.75 kg; about the centre m (940^2 + 28.8^2) / 12, which is
    0.940 kg m2; the centre half way between -453.5 and 486.5. Plane faces: round-off.
    """
    mass = 3 * 60 * 9.6 * 940 * STEEL
    assert_allclose(mass * 1e3, 12.75, atol=0.005)
    properties = pack.mass_properties(STEEL)
    assert_allclose(properties.mass, mass, rtol=1e-11)
    assert_allclose(properties.centre, [16.5, 0, 0], atol=1e-9)
    assert_allclose(properties.inertia, mass * (940**2 + 28.8**2) / 12, rtol=1e-11)
    assert_allclose(properties.inertia * 1e-3, 0.939, atol=0.001)


def test_the_pack_is_small_enough_to_be_solved_in_a_moment(pack):
    assert 3 * len(pack.nodes) < 100_000


@pytest.mark.parametrize(
    ("surface", "expected", "heights", "start", "stop"),
    [
        ("pivot", 2 * 80 * 60, [-14.4, 14.4], -40, 40),
        ("rod", 2 * 40 * 60, [-14.4, 14.4], 440, 480),
        ("contact+", 31.5 * 60, [-14.4], -453.5, -422),
        ("contact-", 31.5 * 60, [14.4], -453.5, -422),
    ],
)
def test_each_patch_ends_on_lines_of_the_mesh(pack, surface, expected, heights, start, stop):
    """Lengths times the width of 60 mm; a contact's patch reaches 5 mm beyond its travel."""
    facets = pack.surfaces[surface]
    assert_allclose(area(pack, facets), expected, rtol=1e-10)
    places = pack.nodes[facets]
    assert_allclose(np.unique(np.round(places[..., 1], 9)), heights)
    assert_allclose([places[..., 0].min(), places[..., 0].max()], [start, stop], atol=1e-9)


def test_the_contact_travels_between_its_two_places(pack):
    contact = pack.interfaces["contact"]
    assert contact.kind == "slide"
    assert contact.travel == (-448.5, -427)
    assert contact.patch == 5
    assert contact.surfaces == ("contact+", "contact-")
    assert [pack.interfaces[name].kind for name in ("pivot", "rod")] == ["clamp", "clamp"]
    assert_allclose(pack.interfaces["rod"].centre, [460, 0, 0])


def parted(mesh):
    """Number of groups of elements that share no node."""
    ends = mesh.elements[:, [0]], mesh.elements
    first, second = (array.ravel() for array in np.broadcast_arrays(*ends))
    size = (len(mesh.nodes),) * 2
    links = coo_matrix((np.ones(len(first)), (first, second)), shape=size)
    return connected_components(links, directed=False)[0]


def test_leaves_share_no_node_and_bonded_ones_are_one_body(pack):
    assert parted(pack) == 3
    glued = bonded(pack)
    assert parted(glued) == 1
    assert_allclose(area(glued, glued.surfaces["pivot"]), 9600, rtol=1e-10)
    # outside faces only: no leaf's inner face is a boundary any more
    outside = 2 * (940 * 60 + 940 * 28.8 + 60 * 28.8)
    assert_allclose(area(glued, boundary_facets(glued.elements)), outside, rtol=1e-10)
    assert_allclose(area(pack, boundary_facets(pack.elements)), outside + 4 * 940 * 60, rtol=1e-10)


def test_every_node_between_leaves_is_tied_to_the_next_leafs_along_y(pack):
    ties = {tie.axis: tie.pairs for tie in pack.ties}
    lower, upper = ties[1].T
    assert np.array_equal(pack.nodes[lower], pack.nodes[upper])
    between = np.isclose(np.abs(pack.nodes[:, 1]), 4.8)
    assert np.array_equal(np.sort(ties[1].ravel()), np.flatnonzero(between))
    middles = np.empty(len(pack.nodes))
    middles[pack.elements] = pack.nodes[pack.elements, 1].mean(axis=1, keepdims=True)
    assert np.all(middles[lower] < middles[upper])


def test_the_bolt_ties_the_line_at_the_pivot_along_x_and_its_middle_along_z(pack):
    ties = {tie.axis: tie.pairs for tie in pack.ties}
    assert sorted(ties) == [0, 1, 2]
    middle = pack.nodes[ties[2][:, 0]]
    assert_allclose(sorted(middle[:, 1]), [-4.8, 4.8])
    assert np.all(middle[:, 0] == 0)
    assert np.abs(middle[:, 2]).max() < 4
    bolt = pack.nodes[ties[0][:, 0]]
    assert np.all(bolt[:, 0] == 0)
    for height in (-4.8, 4.8):  # the whole width, from edge to edge
        line = bolt[np.isclose(bolt[:, 1], height)]
        assert_allclose([line[:, 2].min(), line[:, 2].max()], [-30, 30])
        assert len(line) > 5


def test_a_single_leaf_has_no_ties():
    mesh = mesh_shape(replace(SHORT, leaves=1), fineness=0.6)
    assert mesh.ties == ()
    assert_allclose(mesh.volume, (90 + 26.5 + 100) * 60 * 9.6, rtol=1e-11)


def test_four_leaves_are_tied_at_three_heights():
    mesh = mesh_shape(replace(SHORT, leaves=4), fineness=0.6)
    heights = np.unique(np.round(mesh.nodes[mesh.ties[1].pairs[:, 0], 1], 9))
    assert_allclose(heights, [-9.6, 0, 9.6], atol=1e-9)


def test_separate_leaves_bend_each_on_its_own():
    """n b t^3 / 12 = 3 x 4423.68 mm4."""
    assert_allclose(PACK.inertia_separate, 13271.04, rtol=1e-12)
    assert PACK.stressed_section == (9.6, 60)
    assert PACK.sections == ()


def test_only_the_clamps_surface_has_a_notch_factor(pack):
    assert PACK.notch_factors == {"pivot": 1.3}
    assert replace(PACK, clamp_factor=1.8).notch_factors == {"pivot": 1.8}
    assert set(PACK.notch_factors) <= set(pack.surfaces)
