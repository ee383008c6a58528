"""Size of elements against the notch in which a peak sits."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.singularity import across_notches, concave_curvatures, notch_error
from geometry.meshing import mesh_shape
from geometry.parts import PinHole, PlateLink, RhsBeam
from geometry.shape import Half


@pytest.fixture(scope="module")
def link():
    return mesh_shape(PlateLink(length=60, width=30, thickness=6, hole=10), fineness=1.0)


def at(mesh, *place):
    return int(((mesh.nodes - np.array(place)) ** 2).sum(axis=1).argmin())


def test_a_hole_is_as_concave_as_its_radius(link):
    assert concave_curvatures(link)[at(link, 0, 5, 0)] == pytest.approx(1 / 5, rel=0.03)


def test_flat_and_convex_surfaces_are_no_notch(link):
    for place in ((30, 15, 0), (-15, 0, 0)):
        assert concave_curvatures(link)[at(link, *place)] < 1e-6


def test_half_the_size_misses_a_quarter():
    assert notch_error(0.5, 1.0) == pytest.approx(0.0425)
    assert notch_error(0.25, 1.0) == pytest.approx(0.0425 / 4)


def test_elements_larger_than_the_radius_see_a_sharp_corner():
    """Four times the size, and so a corner's stress at four times the distance: half of it."""
    assert (1 + notch_error(8.0, 1.0)) / (1 + notch_error(2.0, 1.0)) == pytest.approx(2.0)
    assert notch_error(1.5 + 1e-9, 1.0) == pytest.approx(0.17 * 1.5**2)


def test_across_a_hole_is_around_it(link):
    """Unit vectors; none on flat faces."""
    across = across_notches(link)
    for place, wanted in (((0, 5, 0), (1, 0, 0)), ((5, 0, 0), (0, 1, 0))):
        assert_allclose(np.abs(across[at(link, *place)]), wanted, atol=0.25)  # facets beside it
    assert not across[at(link, 30, 15, 0)].any()


def test_where_coarse_elements_reach_from_a_bore_to_a_fillet_no_groove_is_along_the_other():
    """Bores run along z, inner corners of the hollow section along x."""
    holes = tuple(
        PinHole(name, at=at, diameter=30.0, boss=50.0) for name, at in (("A", 0.0), ("B", 300.0))
    )
    sizes = {"height": 120.0, "width": 60.0, "overhang": 60.0, "fillet": 4.0}
    mesh = mesh_shape(Half(RhsBeam(holes=holes, **sizes, wall=5.0, corner=10.0)), fineness=0.35)
    across, (x, y, _) = across_notches(mesh), mesh.nodes.T
    concave = across.any(axis=1) & (concave_curvatures(mesh) > 0.05)  # radii of 15 and 5 mm
    on_rim = np.abs(np.hypot(x, y) - 15.0) < 0.3
    in_corner = (np.abs(y) > 54.0) & (np.abs(x - 150.0) < 100.0)
    for place, line in ((on_rim, 2), (in_corner, 0)):
        assert np.count_nonzero(place & concave) > 100
        assert np.abs(across[place & concave, line]).max() < 0.02
