"""The hammer's connecting rod: a long tube with ball eyes."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

from geometry.cad_body import cad_body
from geometry.mesh import boundary_facets
from geometry.meshing import mesh_shape
from geometry.parts import TubeRod

from .facets import area, normals

STEEL = 7.85e-9
ROD = TubeRod(
    length=1275,
    tube_diameter=20,
    wall=2.5,
    eye_diameter=28.5,
    eye_width=21,
    hole=16,
    fillet=6,
)
SHORT = replace(ROD, length=120)


@pytest.fixture(scope="module")
def rod():
    return mesh_shape(ROD)


def outline(shape, x):
    """Outer radius at x: ball, then fillet (a circle that touches ball and tube), then tube."""
    x = min(abs(x), abs(shape.length - x)) if 0 < x < shape.length else min(x, shape.length - x)
    ball, tube, fillet = shape.eye_diameter / 2, shape.tube_diameter / 2, shape.fillet
    end = np.sqrt((ball + fillet) ** 2 - (tube + fillet) ** 2)
    if x >= end:
        return tube
    if x >= end * ball / (ball + fillet):
        return tube + fillet - np.sqrt(fillet**2 - (end - x) ** 2)
    return np.sqrt(max(ball**2 - x**2, 0))


def section_area(shape, x):
    """Area of the cut normal to x: a disc within the flats, less the hole and the bore."""
    radius, flat = outline(shape, x), shape.eye_width / 2
    near = min(abs(x), abs(shape.length - x))
    half_hole = np.sqrt(max((shape.hole / 2) ** 2 - near**2, 0))

    def chord(z):
        half = np.sqrt(radius**2 - z**2)
        return half - min(half, half_hole)

    top = min(radius, flat)
    cut = 4 * quad(chord, 0, top, limit=200)[0]
    if shape.wall is None:
        return cut
    bore, start = shape.tube_diameter / 2 - shape.wall, shape.eye_diameter / 2
    into = min(x, shape.length - x) - start
    if into <= 0:
        return cut
    return cut - np.pi * (bore**2 if into >= bore else bore**2 - (bore - into) ** 2)


@pytest.mark.parametrize(
    "shape",
    [
        SHORT,
        replace(SHORT, wall=None),
        replace(SHORT, fillet=0.0),
        replace(SHORT, tube_diameter=13.2, wall=None, eye_width=18),
    ],
    ids=["tube", "solid", "sharp", "solid bar of 13.2 mm"],
)
def test_a_rod_has_the_volume_of_its_sections_added_up(shape):
    """Trapezoids of 0.12 mm along half of the symmetric rod: 1e-4 with room."""
    x = np.linspace(-shape.eye_diameter / 2, shape.length / 2, 601)
    areas = [section_area(shape, place) for place in x]
    volume = 2 * np.trapezoid(areas, x)
    assert_allclose(cad_body(shape).volume, volume, rtol=1e-4)


def test_the_rod_of_the_hammer_has_the_mass_and_inertia_that_its_loads_were_found_with(rod):
    """1.467 kg and 0.2235 kg m2: a plain tube of 1275 mm and 46 g more at either end.

    The tube: pi/4 (20^2 - 15^2) x 1275 x 7.85e-6 = 1.3756 kg. Measured 1.4681 kg, 0.2239 kg m2;
    the document states 0.224.
    """
    plain = np.pi / 4 * (20**2 - 15**2) * 1275 * STEEL
    properties = rod.mass_properties(STEEL)
    assert_allclose((properties.mass - plain) / 2 * 1e6, 46, atol=0.5)
    assert_allclose(properties.mass * 1e3, 1.467, rtol=1e-3)
    assert_allclose(properties.inertia * 1e-3, 0.2235, rtol=3e-3)
    assert_allclose(properties.centre, [637.5, 0, 0], atol=0.005)


def test_a_rod_is_small_enough_to_be_solved_in_a_moment(rod):
    assert 3 * len(rod.nodes) < 200_000


def test_eyes_are_bores_as_long_as_the_flats_are_apart(rod):
    for name, x in (("first", 0), ("second", 1275)):
        interface = rod.interfaces[name]
        assert (interface.kind, interface.radius, interface.length) == ("bore", 8, 21)
        assert_allclose(interface.centre, [x, 0, 0])
        assert_allclose(area(rod, rod.surfaces[name]), np.pi * 16 * 21, rtol=1e-3)


def test_flats_are_plane_and_as_far_apart_as_the_eye_is_wide(rod):
    assert_allclose([rod.nodes[:, 2].min(), rod.nodes[:, 2].max()], [-10.5, 10.5], atol=1e-6)
    assert_allclose([rod.nodes[:, 0].min(), rod.nodes[:, 0].max()], [-14.25, 1289.25], atol=1e-6)


@pytest.mark.slow
def test_no_edge_of_a_filleted_rod_is_re_entrant():
    """A sharp re-entrant edge has no finite stress. Without the fillet there is one, where the tube
    (radius 10) meets the ball (14.25) at asin(10 / 14.25) = 44.6 degrees.

    What is left with it are kinks between quadratic facets on round faces, measured under 0.1.
    """
    assert sharpest_re_entrant_edge(mesh_shape(SHORT)) < 0.2
    sharp = sharpest_re_entrant_edge(mesh_shape(replace(SHORT, fillet=0.0)))
    assert_allclose(sharp, np.sqrt(1 - (10 / 14.25) ** 2), atol=0.1)


def sharpest_re_entrant_edge(mesh):
    """Largest sine of the angle by which facets lean towards each other along a common side."""
    facets = boundary_facets(mesh.elements)
    middles = mesh.nodes[facets[:, :3]].mean(axis=1)
    sides = facets[:, [3, 4, 5]].ravel()  # a mid-side node belongs to two facets
    order = np.argsort(sides, kind="stable").reshape(-1, 2)
    assert np.array_equal(sides[order[:, 0]], sides[order[:, 1]])
    first, second = order.T
    at_sides = normals(mesh, facets)[:, 3:].reshape(-1, 3)
    lean = np.einsum("nx,nx->n", at_sides[first], middles[second // 3] - mesh.nodes[sides[first]])
    sine = np.linalg.norm(np.cross(at_sides[first], at_sides[second]), axis=1)
    return sine[lean > 0].max()


def test_a_rods_column_is_its_tube():
    """A = pi/4 (D^2 - d^2), I = pi/64 (D^4 - d^4): 137.4 mm2 and 5369 mm4; 1490 mm4 of d13.2."""
    (tube,) = ROD.sections
    assert tube.name == "tube"
    assert_allclose([tube.area, tube.inertia_in_plane], [137.445, 5368.9], rtol=1e-4)
    assert tube.inertia_out_of_plane == tube.inertia_in_plane
    (bar,) = replace(ROD, tube_diameter=13.2, wall=None).sections
    assert bar.name == "rod"
    assert_allclose([bar.area, bar.inertia_in_plane], [136.85, 1490.3], rtol=1e-4)
    assert ROD.stressed_section == (28.5, 21)
    assert ROD.notch_factors == {}
