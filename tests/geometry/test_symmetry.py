"""Halves of parts that are their own mirror image about z = 0."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry.mesh import SYMMETRY, MeshError
from geometry.meshing import gmsh_session, mesh_shape
from geometry.parts import (
    SHAPES,
    Pin,
    PlateLink,
    PrismaticTube,
    Seat,
    SlottedLever,
    ToggleBar,
    TubeRod,
)
from geometry.shape import Body, Half, has_middle_plane
from geometry.sizing import SizeField, element_sizes

from .bars import SHORT_I, SHORT_RHS
from .facets import area

LINK = PlateLink(length=60, width=20, thickness=8, hole=8, second_hole=12)
MIRRORED = {
    "toggle_bar": ToggleBar(
        length=60,
        width=40,
        wall=6,
        hole=16,
        overhang=16,
        inner_radius=2,
        cutout_length=22,
        cutout_corner=3,
    ),
    "plate_link": LINK,
    "prismatic_tube": PrismaticTube(length=60, width=13, wall=1.6, inner_radius=0.8),
    "slotted_lever": SlottedLever(
        length=120,
        width=30,
        thickness=8,
        hole=10,
        slot_width=12,
        slot_from=20,
        slot_to=90,
        boss_diameter=22,
        boss_height=6,
        boss_fillet=3.0,
    ),
    "rhs_beam": SHORT_RHS,
    "i_beam": SHORT_I,
    "tube_rod": TubeRod(
        length=150, tube_diameter=20, wall=2.5, eye_diameter=36, eye_width=20, hole=14, fillet=4
    ),
}


@dataclass(frozen=True)
class Box:
    """A box that claims a middle plane, mm and degrees."""

    middle_plane: ClassVar[bool] = True
    length: float = 20.0
    high: float = 0.0
    turned: float = 0.0
    nick: float = 0.0

    def build(self, gmsh):
        occ = gmsh.model.occ
        box = occ.addBox(0, -5, -5 + self.high, self.length, 10, 10)
        occ.rotate([(3, box)], self.length / 2, 0, 0, 0, 1, 0, np.radians(self.turned))
        if self.nick:
            slot = occ.addBox(0, -5, 5 - self.nick, 3, 10, 10)
            occ.cut([(3, box)], [(3, slot)])
        occ.synchronize()
        return self.named(gmsh)

    def named(self, gmsh):
        return Body(surfaces={}, interfaces=[], size=5.0, regions=[])


_SLOW = ("toggle_bar", "rhs_beam", "i_beam")


@pytest.fixture(
    scope="module",
    params=[pytest.param(n, marks=pytest.mark.slow if n in _SLOW else ()) for n in MIRRORED],
)
def both(request):
    shape = MIRRORED[request.param]
    fineness = 0.8 if request.param == "tube_rod" else 0.5  # its curves leave 1e-4 of the volume
    return mesh_shape(shape, fineness=fineness), mesh_shape(Half(shape), fineness=fineness)


def test_parts_in_one_plane_can_be_halved_and_the_others_say_nothing():
    assert {name for name, shape in SHAPES.items() if has_middle_plane(shape)} == set(MIRRORED)


def test_half_of_a_part_has_half_its_volume_and_its_mass(both):
    """Curved elements follow the body to 1e-4 of the volume, on either mesh."""
    whole, half = both
    assert_allclose(2 * half.volume_cad, whole.volume_cad, rtol=1e-5)
    assert (whole.half, half.half) == (False, True)
    one, other = whole.mass_properties(7.85e-9), half.mass_properties(7.85e-9)
    assert_allclose(other.mass, one.mass, rtol=1e-4)
    assert_allclose(other.inertia, one.inertia, rtol=1e-4)
    assert_allclose(other.centre, one.centre, rtol=0, atol=2e-3)
    assert other.centre[2] == 0


def test_half_of_a_part_has_half_of_every_surface_and_all_interfaces(both):
    whole, half = both
    assert set(half.surfaces) == {*whole.surfaces, SYMMETRY}
    for name, facets in whole.surfaces.items():
        ratio = 2 * area(half, half.surfaces[name]) / area(whole, facets)
        assert_allclose(ratio, 1, rtol=1e-3, err_msg=name)
    assert list(half.interfaces) == list(whole.interfaces)
    for name, wanted in whole.interfaces.items():
        found = half.interfaces[name]
        assert (found.kind, found.radius, found.length) == (
            wanted.kind,
            wanted.radius,
            wanted.length,
        )
        assert (found.travel, found.patch) == (wanted.travel, wanted.patch)
        assert_allclose(found.centre, wanted.centre)
        assert not found.tilts


def test_half_of_a_part_ends_at_its_middle_plane(both):
    whole, half = both
    assert half.nodes[:, 2].min() == 0
    assert not half.nodes[half.cut_nodes, 2].any()
    assert (half.nodes[:, 2] == 0).sum() == len(half.cut_nodes)
    assert_allclose(area(half, half.boundary), area(whole, whole.boundary) / 2, rtol=1e-3)
    assert len(whole.cut_nodes) == 0


def test_the_cut_of_a_plate_is_its_outline_without_its_holes():
    """A = 60 * 20 + pi 10^2 - pi (4^2 + 6^2) = 1350.8 mm2; curved edges to 1e-4."""
    half = mesh_shape(Half(LINK))
    wanted = 1200 + np.pi * (100 - 16 - 36)
    assert_allclose(area(half, half.surfaces[SYMMETRY]), wanted, rtol=1e-4)


def test_sizes_wanted_on_the_whole_are_taken_by_the_half():
    whole = mesh_shape(LINK, fineness=0.5)
    near = np.hypot(*whole.nodes[:, :2].T) < 7
    sizes = SizeField(whole.nodes, whole.elements[:, :4], np.where(near, 0.7, 3.0))
    small, plain = (
        mesh_shape(Half(LINK), fineness=0.5, sizes=sizes),
        mesh_shape(Half(LINK), fineness=0.5),
    )
    found = []
    for mesh in (small, plain):
        middles = mesh.nodes[mesh.elements].mean(axis=1)
        at = np.hypot(middles[:, 0], middles[:, 1]) < 5
        found.append(element_sizes(mesh)[at].mean())
    assert 0.7 < found[0] < 0.7 * found[1]


def test_a_shape_without_a_middle_plane_cannot_be_halved():
    pin = Pin(seats=(Seat("lug", at=20, width=6), Seat("eye", width=20)), diameter=20)
    with pytest.raises(MeshError, match="a Pin has no middle plane"):
        Half(pin)


@pytest.mark.parametrize(
    "box",
    [
        Box(high=1e-3),
        Box(turned=0.05),
        Box(nick=0.01),
        Box(length=5000, nick=0.01),  # 6e-7 of the volume
    ],
    ids=["beside", "turned", "nick", "nick in a long part"],
)
def test_a_body_that_is_not_its_own_mirror_image_is_refused(box):
    with pytest.raises(MeshError, match="not its own mirror image about z = 0: its surface at"):
        mesh_shape(Half(box))


def test_a_slender_rod_is_halved_though_the_kernel_integrates_its_volume_less_well():
    """2.1 m of tube with fillets: twice the half has 1.00003 of the volume of the whole."""
    rod = TubeRod(length=2093.7, tube_diameter=32.436, wall=5.3146, eye_diameter=45.444,
                  eye_width=32.932, hole=8.1167, fillet=11.686)  # fmt: skip
    with gmsh_session() as gmsh:
        body = Half(rod).build(gmsh)
    assert body.half


def test_a_box_about_the_plane_is_halved():
    assert_allclose(mesh_shape(Half(Box())).volume, 1000, rtol=1e-9)


def test_equal_size_fields_are_one_by_their_numbers():
    """Two equal bars ask for the same mesh although each has its own field."""
    corners, elements = np.vstack([np.zeros(3), np.eye(3)]), np.array([[0, 1, 2, 3]])
    one, same, finer = (
        SizeField(corners.copy(), elements.copy(), np.full(4, size)) for size in (2.0, 2.0, 1.0)
    )
    assert one == same
    assert one != finer
    assert len({one, same, finer}) == 2
