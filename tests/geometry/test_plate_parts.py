"""Cranks, connecting rods and slotted levers cut from plate."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry.meshing import mesh_shape
from geometry.parts import PlateLink, SlottedLever

from .facets import area

STEEL, ALUMINIUM = 7.85e-9, 2.7e-9
CRANK = PlateLink(length=100, width=20, thickness=10, hole=10)
ROD = replace(CRANK, length=150)
UNEVEN = PlateLink(length=70, width=16, thickness=6, hole=8, second_hole=10)
LEVER = SlottedLever(
    length=200, width=30, thickness=8, hole=8, slot_width=12, slot_from=28, slot_to=192
)
QUICK_RETURN = replace(LEVER, overhang=15, boss_diameter=22, boss_height=9.75, boss_fillet=2)


def round_ended(length, width):
    """Area and polar moment about the middle of a plate with half-round ends about its axes.

    A half disc: centroid 4 R / (3 pi) beyond the axis, polar moment pi R^4 / 4 about the axis.
    """
    radius, half = width / 2, length / 2
    disc = pi * radius**2
    ends = pi * radius**4 / 2 + disc * half**2 + 2 * half * disc * 4 * radius / (3 * pi)
    return width * length + disc, width * length * (width**2 + length**2) / 12 + ends


def hole_moment(diameter, arm):
    return pi * diameter**4 / 32 + pi / 4 * diameter**2 * arm**2


@pytest.mark.parametrize(("shape", "kilograms"), [(CRANK, 0.058241), (ROD, 0.085241)])
def test_links_of_the_slider_crank_have_their_mass_and_inertia(shape, kilograms):
    """Aluminium 2700 kg/m3. Facets around the circles: 1e-5."""
    properties = mesh_shape(shape).mass_properties(ALUMINIUM)
    assert_allclose(properties.mass * 1e3, kilograms, rtol=2e-5)
    assert_allclose(properties.centre, [shape.length / 2, 0, 0], atol=1e-4)
    _, moment = round_ended(shape.length, 20)
    moment -= 2 * hole_moment(10, shape.length / 2)
    assert_allclose(properties.inertia, ALUMINIUM * 10 * moment, rtol=2e-5)


def test_a_link_with_two_different_holes_balances_beyond_the_smaller():
    properties = mesh_shape(UNEVEN).mass_properties(STEEL)
    plate, _ = round_ended(70, 16)
    small, large = pi * 16, pi * 25
    rest = plate - small - large
    assert_allclose(properties.mass, STEEL * 6 * rest, rtol=2e-5)
    assert_allclose(properties.centre[0], (plate * 35 - large * 70) / rest, rtol=2e-5)


def test_bores_of_a_link_have_their_own_diameters_and_tilt():
    mesh = mesh_shape(UNEVEN)
    for name, hole in (("first", 8), ("second", 10)):
        interface = mesh.interfaces[name]
        assert (interface.radius, interface.length, interface.tilts) == (hole / 2, 6, True)
        assert_allclose(area(mesh, mesh.surfaces[name]), pi * hole * 6, rtol=1e-4)
    assert_allclose(mesh.interfaces["second"].centre, [70, 0, 0])


def test_a_links_column_is_its_plate():
    (section,) = CRANK.sections
    assert (section.area, section.length) == (200, None)
    assert_allclose(section.inertia_in_plane, 10 * 20**3 / 12)
    assert_allclose(section.inertia_out_of_plane, 20 * 10**3 / 12)
    assert CRANK.stressed_section == (20, 10)


def test_a_plain_lever_weighs_its_plate_less_slot_and_holes():
    """Round ends, a slot with round ends 28 to 192 mm, two holes of 8 mm."""
    properties = mesh_shape(LEVER).mass_properties(STEEL)
    plate, plate_moment = round_ended(200, 30)
    slot, slot_moment = round_ended(164 - 12, 12)
    hole = pi * 16
    rest = plate - slot - 2 * hole
    centre = (plate * 100 - slot * 110 - hole * 200) / rest
    moment = (
        plate_moment + plate * (centre - 100) ** 2
        - slot_moment - slot * (centre - 110) ** 2
        - hole_moment(8, centre) - hole_moment(8, 200 - centre)
    )  # fmt: skip
    assert_allclose(properties.mass, STEEL * 8 * rest, rtol=2e-5)
    assert_allclose(properties.centre, [centre, 0, 0], rtol=2e-5, atol=1e-4)
    assert_allclose(properties.inertia, STEEL * 8 * moment, rtol=2e-5)


def test_square_ends_and_a_sharp_boss_add_up():
    """230 x 30 x 8 mm less slot (28 to 186 mm, clear of the boss) and holes, plus two rings."""
    shape = replace(LEVER, slot_to=186, overhang=15, boss_diameter=20, boss_height=5)
    slot, _ = round_ended(158 - 12, 12)
    rings = 2 * 5 * pi / 4 * (20**2 - 8**2)
    volume = 8 * (230 * 30 - slot - 2 * pi * 16) + rings
    assert_allclose(mesh_shape(shape).volume_cad, volume, rtol=1e-8)


@pytest.fixture(scope="module")
def lever():
    return mesh_shape(QUICK_RETURN)


def test_the_quick_return_lever_is_the_one_its_loads_were_found_with(lever):
    """0.35529 kg, 0.0020765 kg m2 about the centre, which is 109.3458 mm from the pivot.

    A plate without holes with a point mass at B; as built, holes and a boss move each by under 1 %:
    measured -0.4, -0.9, +0.9 %.
    """
    properties = lever.mass_properties(STEEL)
    assert_allclose(properties.mass * 1e3, 0.35529, rtol=0.01)
    assert_allclose(properties.inertia * 1e-3, 0.0020765, rtol=0.01)
    assert_allclose(properties.centre, [109.3458, 0, 0], rtol=0.01, atol=1e-3)


def test_the_boss_lengthens_the_bore_at_the_tip(lever):
    assert lever.interfaces["tip"].length == pytest.approx(8 + 2 * 9.75)
    assert_allclose(area(lever, lever.surfaces["tip"]), pi * 8 * 27.5, rtol=1e-3)
    assert_allclose(area(lever, lever.surfaces["pivot"]), pi * 8 * 8, rtol=1e-3)


@pytest.mark.parametrize(("surface", "y"), [("slot+", 6), ("slot-", -6)])
def test_the_flanks_of_the_slot_are_flat_and_as_long_as_its_straight_part(lever, surface, y):
    """A force along +y presses on the flank at y > 0. Plane faces: round-off."""
    facets = lever.surfaces[surface]
    assert_allclose(area(lever, facets), 152 * 8, rtol=1e-9)
    assert_allclose(lever.nodes[facets][..., 1], y, atol=1e-9)
    assert_allclose(
        [lever.nodes[facets][..., 0].min(), lever.nodes[facets][..., 0].max()], [34, 186], atol=1e-9
    )


def test_a_block_as_long_as_the_slot_is_wide_travels_the_straight_part_less_itself(lever):
    """40 to 180 mm, the travel of the quick return."""
    slot = lever.interfaces["slot"]
    assert (slot.kind, slot.travel, slot.patch, slot.length) == ("slide", (40, 180), 6, 8)
    assert_allclose(slot.centre, 0)
    assert lever.interfaces["tip"].tilts
    assert lever.interfaces["pivot"].tilts


def test_travel_and_contact_may_be_stated():
    shape = replace(LEVER, contact_length=4, travel_from=50, travel_to=90)
    slot = mesh_shape(shape, fineness=0.7).interfaces["slot"]
    assert (slot.travel, slot.patch) == ((50, 90), 2)


def test_neither_link_nor_lever_has_notches_that_the_mesh_lacks():
    assert CRANK.notch_factors == LEVER.notch_factors == {}
    assert LEVER.sections == ()
    assert np.all(np.array(LEVER.stressed_section) == [30, 8])
