"""Sections that planes cut from a body, against closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry.cad_body import Skin, cad_skin, skin_of
from geometry.mesh import MeshError
from geometry.meshing import gmsh_session
from geometry.parts import PlateLink, PrismaticTube, TubeRod
from geometry.slices import in_stretches, sliced

BORE = 12.0
LINK = PlateLink(length=100.0, width=30.0, thickness=8.0, hole=BORE)


def section(skin, place):
    (one,) = sliced(skin, np.array([place]))
    return one


@pytest.fixture(scope="module")
def link():
    return cad_skin(LINK)


def turned(skin, angle):
    """The skin, turned about x and moved aside."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return Skin(
        np.column_stack([skin.nodes[:, 0], skin.nodes[:, 1:] @ turn.T + [3.0, -5.0]]),
        skin.triangles,
    )


def test_a_rectangle_has_its_area_moments_walls_and_outline(link):
    one = section(link, 50.0)
    assert_allclose(one.area, 240.0, rtol=1e-12)
    assert_allclose(one.moments, (8 * 30**3 / 12, 30 * 8**3 / 12, 0.0), atol=1e-9)
    assert_allclose(one.centre, 0.0, atol=1e-12)
    assert_allclose((one.weak_area, one.weak_moment), (240.0, 1280.0), rtol=1e-12)
    wall, fin = one.walls
    assert_allclose(fin, 8.0, rtol=1e-12)
    assert wall == one.breadth
    assert 30.0 <= one.breadth <= np.hypot(30, 8)
    assert_allclose(np.abs(one.outline[[2, 6]]), [[15.0, 4.0]] * 2, rtol=1e-12)


def test_a_section_that_is_turned_and_moved_has_the_same_least_moment(link):
    """Mohr's circle: y y and z z with their mean, and y z of half their difference."""
    angle = 0.4
    one = section(turned(link, angle), 50.0)
    high, low = 18000.0, 1280.0
    assert_allclose(one.centre, [3.0, -5.0], rtol=1e-12)
    across = (high - low) / 2 * np.array([np.cos(2 * angle), np.sin(2 * angle)])
    middle = (high + low) / 2
    assert_allclose(one.moments, (middle + across[0], middle - across[0], across[1]), rtol=1e-9)
    assert_allclose(one.weak_moment, low, rtol=1e-9)
    assert_allclose(one.walls[1], 8.0, rtol=1e-9)


def test_beside_a_pin_there_are_two_bodies_and_the_weaker_one_alone_is_told(link):
    """Facets take up to 1 % of a bore's radius."""
    one = section(link, 0.0)
    assert_allclose(one.area, 8 * (30 - BORE), rtol=0.01)
    assert_allclose(one.moments[0], 8 * (30**3 - BORE**3) / 12, rtol=0.01)
    assert_allclose(one.weak_area, 8 * 9.0, rtol=0.01)
    assert_allclose(one.weak_moment, 9 * 8**3 / 12, rtol=0.02)


@pytest.mark.parametrize("wall", [2.0, 5.0])
def test_a_round_tube_is_one_body_whose_wall_is_held_on_both_sides(wall):
    """Area and second moment to the 20 facets of a turn, which lose up to 4 and 8 %."""
    sizes = {"tube_diameter": 20, "eye_diameter": 34, "eye_width": 26, "hole": 20, "fillet": 6}
    rod = TubeRod(length=240, wall=wall, **sizes)
    one = section(cad_skin(rod), 120.0)
    bore = 20 - 2 * wall
    area, moment = np.pi * (20**2 - bore**2) / 4, np.pi * (20**4 - bore**4) / 64
    assert_allclose(one.area, area, rtol=0.04)
    assert area > one.area
    assert_allclose(one.weak_moment, moment, rtol=0.08)
    assert one.weak_area == pytest.approx(one.area)
    assert 0.9 * wall < one.walls[0] <= wall
    assert one.walls[1] == one.breadth


def test_a_square_tube_has_the_moments_of_its_walls():
    tube = PrismaticTube(length=200.0, width=40.0, wall=3.0)
    one = section(cad_skin(tube), 100.0)
    assert_allclose(one.moments[:2], tube.sections[0].inertia_in_plane, rtol=0.01)
    assert one.walls[0] == pytest.approx(3.0)


def test_a_plane_beside_the_body_cuts_nothing(link):
    assert sliced(link, np.array([-500.0])) == []


def test_the_sections_hold_the_volume(link):
    """Middles of 2000 cells; the body of facets has the skin's own volume."""
    cuts = np.linspace(link.nodes[:, 0].min(), link.nodes[:, 0].max(), 2001)
    areas = [one.area for one in sliced(link, (cuts[1:] + cuts[:-1]) / 2)]
    corners = link.nodes[link.triangles]
    volume = np.einsum("ij,ij->", np.cross(corners[:, 0], corners[:, 1]), corners[:, 2]) / 6
    assert_allclose(np.array(areas) @ np.diff(cuts), volume, rtol=1e-4)


def test_a_fin_is_told_from_a_wall_between_two_cavities():
    """A block of 30 x 20 mm with a slot that leaves 2 mm, open, and a bore 3 mm below it."""
    with gmsh_session() as gmsh:
        occ = gmsh.model.occ
        block = occ.addBox(0, 0, 0, 50, 30, 20)
        slot, bore = occ.addBox(-1, 10, 2, 60, 21, 6), occ.addBox(-1, 5, 11, 60, 10, 4)
        occ.cut([(3, block)], [(3, slot), (3, bore)])
        occ.synchronize()
        gmsh.option.setNumber("Mesh.ElementOrder", 1)
        gmsh.model.mesh.generate(2)
        skin = Skin(*skin_of(gmsh))
    one = section(skin, 25.0)
    assert one.area == pytest.approx(600 - 20 * 6 - 40)
    assert one.walls == (pytest.approx(3.0), pytest.approx(2.0))


def test_a_surface_turned_inside_out_is_refused(link):
    with pytest.raises(MeshError, match="not closed at x = 50 mm"):
        section(Skin(link.nodes, link.triangles[:, ::-1]), 50.0)


def test_a_skew_section_bends_in_a_plane_as_if_nothing_held_it_sideways(link):
    """By hand: I_1 I_2 over the second moment about the axis at right angles."""
    angle = 0.5
    (found,) = in_stretches(sliced(turned(link, angle), np.linspace(40.0, 60.0, 5)), 100.0)
    one, two, c, s = 8 * 30**3 / 12, 30 * 8**3 / 12, np.cos(angle) ** 2, np.sin(angle) ** 2
    assert_allclose(found.inertia_in_plane, one * two / (one * s + two * c), rtol=1e-9)
    assert_allclose(found.inertia_out_of_plane, one * two / (one * c + two * s), rtol=1e-9)
    assert found.stretch == (0.0, 100.0)
