"""Cross-sections against hand values of square tubes."""

from dataclasses import replace

import pytest
from numpy.testing import assert_allclose

from geometry.bars import plate_pair_section, round_tube_section, square_tube_section


@pytest.mark.parametrize(
    ("width", "wall", "area", "inertia"),
    [(30, 1.6, 181.76, 24510.94), (13, 1.6, 72.96, 1611.443), (80, 6.3, 1857.24, 1693611)],
)
def test_a_sharp_cornered_tube_has_the_area_and_inertia_of_two_squares(width, wall, area, inertia):
    """b^2 - a^2 and (b^4 - a^4)/12; half a unit of the last printed digit of seven."""
    section = square_tube_section("tube", width, wall, 0.0)
    assert section.area == pytest.approx(area, abs=1e-9 * area)
    assert_allclose(section.inertia_in_plane, inertia, rtol=5e-7)
    assert section.inertia_out_of_plane == section.inertia_in_plane
    assert section.length is None


def test_inner_fillets_add_the_spandrels_of_four_quarter_circles():
    """Area exact. Inertia: the spandrels' own (7.5e-3 r^4 each, 2 mm4) is left out on purpose."""
    sharp, filleted = (square_tube_section("tube", 80, 6.3, r) for r in (0.0, 3.0))
    assert_allclose(filleted.area - sharp.area, 9 * (4 - 3.141592653589793), rtol=1e-12)
    added = filleted.inertia_in_plane - sharp.inertia_in_plane
    assert_allclose(added, (filleted.area - sharp.area) * (33.7 - 0.2234 * 3) ** 2, rtol=1e-3)


def test_two_plates_bend_each_on_its_own():
    section = plate_pair_section("cheeks", 80, 6.3, 16, 73.7)
    assert_allclose(section.area, 1008)
    assert_allclose(section.inertia_in_plane, 1008 * 80**2 / 12)
    assert_allclose(section.inertia_out_of_plane, 1008 * 6.3**2 / 12)
    assert section.length == 16


def test_two_plates_carry_the_columns_moment_by_pushing_and_pulling():
    """80 (80^3 - 67.4^3)/12 = 1 372 081 mm4; 2 x 3 E I/a^3 x a with I = 1667 mm4 over 16 mm."""
    section = plate_pair_section("cheeks", 80, 6.3, 16, 73.7)
    assert_allclose(section.inertia_built_up, 80 * (80**3 - 67.4**3) / 12)
    assert_allclose(section.racking_area, 6 * 80 * 6.3**3 / 12 / 256)
    assert section.depth_out_of_plane == 80


def test_a_stretch_that_ends_before_it_starts_is_refused():
    with pytest.raises(ValueError, match="'tube' stretches from 9 mm, to 3 mm"):
        replace(square_tube_section("tube", 30, 1.6, 0.0), stretch=(9.0, 3.0))


def test_a_round_tube_has_the_area_and_inertia_of_two_discs():
    """30 mm with a bore of 20: pi/4 (900 - 400) mm2, pi/64 (810 000 - 160 000) mm4."""
    section = round_tube_section("tube", 30.0, 20.0)
    assert section.area == pytest.approx(392.699081699)
    assert section.inertia_in_plane == section.inertia_out_of_plane == pytest.approx(31906.8003880)
