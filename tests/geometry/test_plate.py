"""Levers and drawn plates: outline, solid, mass against closed forms, names, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry.cad_body import cad_body
from geometry.closed_form import closed_body
from geometry.meshing import mesh_shape
from geometry.outlines import Contour, PlateOutline
from geometry.parameters import ParameterError
from geometry.parts import PlateLink
from geometry.parts.plate import Eye, Plate, PlateBore, lever_outline
from geometry.shape import Half

STRAIGHT = ((0, 30), (100, 30), (160, 30))
BENT = ((0, 30), (100, 46), (120 + 70j, 24))


def lever(places=BENT, hole=10.0, fillet=12.0, thickness=10.0):
    eyes = [Eye(f"p{k}", complex(at), hole, eye) for k, (at, eye) in enumerate(places)]
    bores = tuple(PlateBore(eye.name, hole, (eye.centre.real, eye.centre.imag)) for eye in eyes)
    return Plate(lever_outline(eyes, fillet), bores, thickness)


def test_a_straight_lever_of_equal_eyes_is_a_flat_link():
    found = lever(STRAIGHT).outline.moments
    assert_allclose(found.area, 160 * 30 + math.pi * (15**2 - 3 * 5**2), rtol=1e-11)


def test_a_tapered_arm_in_closed_form():
    # two discs of radii a and b at c, and their common tangents: s = (a - b)/c, w^2 = 1 - s^2
    a, b, c = 20.0, 12.0, 90.0
    s = (a - b) / c
    w, turn = math.sqrt(1 - s * s), math.acos(s)
    area = (a + b) * c * w + a * a * (math.pi - turn) + b * b * turn - math.pi * 2 * 25
    found = lever(((0, 2 * a), (c, 2 * b)))
    assert_allclose(found.outline.moments.area, area, rtol=1e-11)


def test_a_bend_in_closed_form():
    # equal eyes of radius r at a right angle: two bars, an eye's sector outside, and inside what
    # the tangents and the fillet R leave: r^2 of the bars' overlap, R^2 (1 - pi/4) in the corner
    r, fillet = 15.0, 12.0
    arms = (100.0, 80.0)
    found = lever(((0, 30), (100, 30), (100 + 80j, 30)), fillet=fillet).outline.moments
    area = (
        sum(arms) * 2 * r - r * r  # the bars from pin to pin; the inner quarter is in both
        + math.pi * r * r + math.pi * r * r / 4  # half an eye at either end, a quarter outside
        + fillet**2 * (1 - math.pi / 4) - 3 * math.pi * 25
    )  # fmt: skip
    assert_allclose(found.area, area, rtol=1e-11)


@pytest.mark.parametrize(
    "places",
    [
        STRAIGHT,
        BENT,
        ((0, 50), (100, 30), (160, 44)),  # waisted: a bend on either side
        ((0, 30), (100, 50), (100 - 70j, 24)),
        ((0, 40), (100, 30), (160 + 10j, 30), (160 + 80j, 40)),
    ],
)
def test_outlines_have_no_corner_and_solids_have_their_mass(places):
    plate = lever(places)
    edges = plate.outline.outer.edges
    ways = (edges.ends - edges.starts) / np.abs(edges.ends - edges.starts)
    after, before = (ways * np.exp(sign * 0.5j * edges.angles) for sign in (-1, 1))
    assert np.abs(np.angle(np.roll(after, -1) / before)).max() < 1e-9
    by_formula, by_kernel = closed_body(plate), cad_body(plate)
    assert_allclose(by_formula.volume, by_kernel.volume, rtol=1e-9)
    assert_allclose(by_formula.centre, by_kernel.centre, atol=1e-7)
    assert_allclose(by_formula.second, by_kernel.second, rtol=1e-7)
    assert_allclose(by_formula.size, by_kernel.size, rtol=1e-6)


def test_the_mesh_has_the_bores_and_the_half_half_of_it():
    plate = lever()
    mesh = mesh_shape(plate, fineness=0.4)
    found = mesh.mass_properties(1.0)
    wanted = plate.outline.moments
    assert_allclose(found.mass, 10 * wanted.area, rtol=2e-4)
    assert_allclose(found.centre, [wanted.centre.real, wanted.centre.imag, 0], atol=2e-2)
    assert_allclose(found.inertia, 10 * wanted.polar, rtol=5e-4)
    for bore in plate.bores:
        arms = mesh.nodes[np.unique(mesh.surfaces[bore.name][:, :3]), :2] - bore.at
        assert_allclose(np.hypot(*arms.T), 5.0, rtol=1e-6)
        assert mesh.interfaces[bore.name].tilts
    half = mesh_shape(Half(plate), fineness=0.4)
    assert set(half.surfaces) == {"p0", "p1", "p2", "symmetry"}
    assert_allclose(half.volume_cad, mesh.volume_cad / 2, rtol=1e-9)


def test_windows_and_arcs_of_more_than_a_half_circle_are_meshed():
    key = Contour.either_way([60 - 4j, 60 + 4j, 50 + 4j, 50 - 4j], [0.0, 0.0, 1.6, 0.0])
    outer = Contour.of((-20 - 20j, 120 - 20j, 120 + 20j, -20 + 20j), (0.0, 0.6, 0.0, 0.0))
    holes = (Contour.round(0, 6), Contour.round(100, 8))
    plate = Plate(
        PlateOutline(outer, (*holes, key)),
        (PlateBore("a", 12, (0, 0)), PlateBore("b", 16, (100, 0))),
        8.0,
    )
    assert_allclose(cad_body(plate).volume, 8 * plate.outline.moments.area, rtol=1e-9)
    assert plate.windows == (key,)
    assert mesh_shape(plate, fineness=0.3).volume_cad > 0


def test_neighbours_join_all_bores_by_the_shortest_lines():
    assert lever().neighbours == ((0, 1), (1, 2))
    assert lever(STRAIGHT).stressed_section == (30.0, 10.0)


def test_the_section_of_a_waisted_plate_is_its_eyes():
    """Bores decide beside a shank of 16 mm between eyes of 40 mm, as those of a rod with eyes."""
    outer = Contour.of(
        (-20j, 19 - 8j, 101 - 8j, 120 - 20j, 120 + 20j, 101 + 8j, 19 + 8j, 20j),
        (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
    )
    holes = tuple(Contour.round(x, 6) for x in (0, 120))
    bores = (PlateBore("a", 12, (0, 0)), PlateBore("b", 12, (120, 0)))
    plate = Plate(PlateOutline(outer, holes), bores, 8.0)
    assert_allclose(plate.stressed_section, (40, 8))


@pytest.mark.parametrize(
    ("change", "field", "told"),
    [
        ({"fillet": None}, "fillet", "at p1 the lever has a re-entrant corner"),
        ({"fillet": 200.0}, "fillet", r"200 mm does not fit at p1: it must be at most \d"),
        ({"hole": 30.0}, "holes.p0.eye", "must be above 30 mm, got 30 mm"),
        ({"places": ((0, 30), (25, 30), (160, 30))}, "holes.p1.eye", "meets the eye of p0"),
        ({"thickness": 0.0}, "thickness", "must be above 0 mm"),
    ],
)
def test_levers_that_cannot_be_drawn(change, field, told):
    with pytest.raises(ParameterError, match=told) as caught:
        lever(**change)
    assert caught.value.field == field


def test_a_bore_is_a_round_hole_of_the_outline():
    with pytest.raises(ParameterError, match=r"holes\.b: is no round hole of the plate: 10 mm"):
        Plate(lever().outline, (PlateBore("a", 10, (0, 0)), PlateBore("b", 10, (50, 0))), 10.0)


def test_a_straight_lever_is_a_bar_from_its_first_bore_to_its_last():
    bar = lever(STRAIGHT).link(0.3)
    wanted = PlateLink(length=160, width=30, thickness=10, hole=10).link(0.3)
    assert bar.cuts == (0.0, 100.0, 160.0)
    x = np.linspace(1, 159, 6)[None, :]
    for name in ("area", "inertia_y", "inertia_z", "torsion"):
        own, other = (np.broadcast_to(getattr(one.at(x), name), x.shape) for one in (bar, wanted))
        assert_allclose(own, other, rtol=1e-9)
    tapered = lever(((0, 30), (100, 50), (160, 30))).link(0.3)
    assert_allclose(tapered.at(np.full((1, 6), 50.0)).area, 10 * 40 / np.sqrt(0.99), rtol=2e-3)
    assert lever(BENT).link(0.3) is None


def _waisted(**changes):
    """Two eyes of 48 mm with a shank of 10 mm between them, 150 mm apart, in one outline."""
    upper = [174 + 24j, 105 + 24j, 90 + 5j, 60 + 5j, 45 + 24j, -24 + 24j]
    corners = [*upper, *(point.conjugate() for point in upper[::-1])]
    holes = tuple(Contour.round(complex(x), 10.0) for x in (0.0, 150.0))
    outline = PlateOutline(Contour.either_way(corners, [0.0] * len(corners)), holes)
    bores = tuple(PlateBore(name, 20.0, (x, 0.0)) for name, x in (("a", 0.0), ("b", 150.0)))
    return Plate(outline, bores, 8.0, **changes)


def test_a_plate_between_two_bores_is_a_column_of_its_least_sections():
    plate = _waisted()
    covered = [place for section in plate.sections for place in section.stretch]
    assert covered[0] == 0.0
    assert covered[-1] == 150.0
    assert covered[1:-1:2] == covered[2::2]
    shank = next(one for one in plate.sections if one.stretch[0] < 75 < one.stretch[1])
    assert_allclose((shank.area, shank.inertia_in_plane), (80.0, 8 * 10**3 / 12), rtol=1e-12)
    assert_allclose(shank.inertia_out_of_plane, 10 * 8**3 / 12, rtol=1e-12)
    assert shank.stretch == pytest.approx((60.0, 90.0), abs=2.2)  # its corners, and a station
    assert plate.net_section == pytest.approx(8 * (48 - 20), rel=1e-12)
    assert plate.shank_decides
    assert not lever(((0, 30), (100, 30))).shank_decides
    moved = _waisted(moved=(("b", (0.04, 0.0)),))  # as the linkage has its pins
    assert moved.sections[-1].stretch[1] == pytest.approx(149.96, rel=1e-15)


def test_a_column_is_as_narrow_as_a_notch_between_its_stations():
    """Arcs of 1 mm over 135 degrees, 2 mm between stations: narrowest beside their middles."""
    side = np.exp(-0.25j * np.pi)
    notch = [73.3 + side.real + 24j, 73.3 + 24j + side, 72.3 + 24j]
    upper = [174 + 24j, *notch, -24 + 24j]
    corners = [*upper, *(point.conjugate() for point in upper[::-1])]
    bulges = np.zeros(len(corners))
    bulges[[2, 6]] = -np.tan(np.radians(135 / 4))
    whole = _waisted()
    contour = Contour.either_way(corners, bulges.tolist())
    plate = Plate(replace(whole.outline, outer=contour), whole.bores, 8.0)
    assert_allclose(min(one.area for one in plate.sections), 8 * 2 * 23, rtol=1e-12)


def test_a_plate_that_is_no_column_says_why():
    plate = lever(STRAIGHT)
    assert not plate.sections
    assert [said for said in plate.told if "no column" in said and "more than two holes" in said]
