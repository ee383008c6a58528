"""Parts as sheets: their outline, their thickness, and their mesh."""

from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from geometry.meshing import gmsh_session
from geometry.parts import (
    LeafPack,
    Pin,
    PlateLink,
    PrismaticTube,
    Seat,
    SlottedLever,
    ToggleBar,
    TubeRod,
)
from geometry.plane_outlines import mesh_outline, plane_sizes
from geometry.plane_shapes import outline_of

LINK = PlateLink(length=100.0, width=30.0, thickness=8.0, hole=12.0, second_hole=10.0)
LEVER = SlottedLever(
    length=200.0,
    width=30.0,
    thickness=8.0,
    hole=8.0,
    slot_width=12.0,
    slot_from=28.0,
    slot_to=170.0,
    overhang=15.0,
    boss_diameter=22.0,
    boss_height=9.0,
    boss_fillet=2.0,
)
BAR = ToggleBar(
    length=250.0,
    width=80.0,
    wall=10.0,
    hole=44.0,
    overhang=50.0,
    inner_radius=5.0,
    cutout_length=110.0,
    cutout_corner=15.0,
)
ROD = TubeRod(
    length=200.0,
    tube_diameter=20.0,
    wall=2.5,
    eye_diameter=28.5,
    eye_width=21.0,
    hole=16.0,
    fillet=6.0,
)
TUBE = PrismaticTube(length=250.0, width=30.0, wall=1.6, inner_radius=0.0)
PACK = LeafPack(
    length=300.0,
    leaves=3,
    width=60.0,
    thickness=10.0,
    arm=250.0,
    overhang=30.0,
    clamp_length=80.0,
    rod_length=40.0,
    contact_from=180.0,
    contact_to=220.0,
    contact_length=10.0,
)


def sheet_of(shape, **how):
    return mesh_outline(outline_of(shape), **how)


def areas(mesh):
    """Area of each triangle, its sides taken as straight."""
    a, b, c = np.moveaxis(mesh.nodes[mesh.elements[:, :3]], 1, 0)
    along, across = b - a, c - a
    return (along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]) / 2


def volume(sheet):
    return float(areas(sheet.mesh) @ sheet.thickness)


def cad_volume(shape):
    with gmsh_session() as gmsh:
        shape.build(gmsh)
        return sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.getEntities(3))


def test_a_link_as_a_sheet_has_the_volume_of_a_plate_with_two_holes():
    """Straight sides cut a circle of 48 elements by 1 - sin(2 pi/48)/(2 pi/48) = 0.3 %, of which
    the circles are a third: 1e-3."""
    flat = 100.0 * 30 + pi * 15**2
    holes = pi * (6**2 + 5**2)
    assert_allclose(volume(sheet_of(LINK, fineness=3)), 8.0 * (flat - holes), rtol=1e-3)


@pytest.mark.parametrize("shape", [LEVER, BAR, ROD, TUBE, PACK], ids=lambda s: type(s).__name__)
def test_a_sheet_has_the_volume_of_its_part(shape):
    """The other route is the CAD body. 1e-2: sides taken as straight, 16 samples of thickness."""
    assert_allclose(volume(sheet_of(shape)), cad_volume(shape), rtol=1e-2)


def test_the_thickness_of_a_toggle_bar_is_that_of_its_walls():
    """Two cheeks of 10 mm beside the cut-out; beyond it the side walls are seen over 80 mm."""
    places = np.array([[-20.0, 0.0], [20.0, 38.0], [150.0, 0.0], [150.0, 38.0], [60.0, 38.0]])
    assert_allclose(outline_of(BAR).thickness(places[:4]), [20, 20, 20, 80])
    # at the cut-out's end, 60 mm from the knee, its corner of 15 mm has grown in from each cheek
    assert_allclose(outline_of(BAR).thickness(places[4:] - [1e-9, 0]), [50], rtol=1e-4)


def test_the_thickness_of_a_rod_is_its_chord_along_z():
    """A tube of 20 x 2.5 mm, and a ball of 28.5 mm between flats 21 mm apart."""
    thickness = outline_of(ROD).thickness
    x = np.array([100.0, 100.0, 100.0, 0.0, 0.0])
    y = np.array([0.0, 6.0, 9.0, 9.0, 12.0])
    hollow = 2 * 64**0.5 - 2 * (7.5**2 - 36) ** 0.5
    chords = [5.0, hollow, 2 * 19**0.5, 21.0, 2 * (14.25**2 - 144) ** 0.5]
    assert_allclose(thickness(np.column_stack([x, y])), chords)


def test_the_nodes_of_a_bore_lie_on_its_circle():
    """gmsh keeps 1e-8 mm."""
    mesh = sheet_of(LINK).mesh
    on = mesh.nodes[mesh.edge_nodes("second")] - [100.0, 0.0]
    assert_allclose(np.hypot(*on.T), 5.0, rtol=0, atol=1e-7)


def test_places_on_a_seam_belong_to_both_sides_of_it():
    """Where a boss begins, the sheet has two thicknesses, so two stresses."""
    sheet = sheet_of(LEVER)
    nodes, region = sheet.sides
    foot = np.flatnonzero(np.abs(np.hypot(*(sheet.mesh.nodes - [200.0, 0.0]).T) - 13.0) < 1e-6)
    sides = [set(region[nodes == node]) for node in foot]
    assert len(foot) > 10
    assert all(len(side) == 2 for side in sides)
    assert set(foot) <= set(nodes[sheet.shown])


def test_leaves_have_nodes_of_their_own_that_are_tied():
    sheet = sheet_of(PACK)
    nodes, regions = sheet.sides
    assert len(np.unique(nodes)) == len(nodes)
    assert len(np.unique(regions)) == 3
    first, other = sheet.ties.T
    assert_array_equal(sheet.mesh.nodes[first], sheet.mesh.nodes[other])
    assert set(np.round(sheet.mesh.nodes[first, 1], 9)) == {-5.0, 5.0}
    assert_array_equal(sheet.mesh.nodes[first[sheet.bolted]], [[0, -5], [0, 5]])


def test_wanted_sizes_are_met_where_they_are_smaller():
    """A third of the size at one bore only; gmsh keeps a size to some 20 %."""
    sheet = sheet_of(LINK)
    near = np.hypot(*sheet.mesh.nodes[sheet.mesh.elements[:, 0]].T) < 8.0
    wanted = np.where(near, sheet.element_sizes / 3, sheet.element_sizes)
    finer = sheet_of(LINK, sizes=plane_sizes(sheet, wanted))
    count = {
        name: len(edge) / len(sheet.mesh.edges[name]) for name, edge in finer.mesh.edges.items()
    }
    assert 2.4 < count["first"] < 3.6
    assert 0.9 < count["second"] < 1.2


def test_the_same_part_gives_the_same_mesh():
    assert_array_equal(sheet_of(LEVER).mesh.nodes, sheet_of(LEVER).mesh.nodes)


def test_a_pin_is_no_sheet():
    pin = Pin(
        diameter=10.0, overhang=1.0, seats=(Seat("a", width=10.0), Seat("b", at=12.0, width=8.0))
    )
    assert outline_of(pin) is None


def test_a_fineness_of_zero_is_refused():
    with pytest.raises(ValueError, match="fineness must be above 0, got 0"):
        sheet_of(LINK, fineness=0)
