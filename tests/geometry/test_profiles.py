"""Section properties of rolled profiles against printed ones."""

import pytest

from geometry.profiles import hollow_profile, i_profile

# Dimensions in mm: alezen9/themis, flanged-sections.ts, commit 467b7c3f. Beside them kg/m as
# suppliers' lists print them, at 7.85 t/m3 and rounded to 0.1.
ROLLED = {
    "IPE 80": ((80, 46, 3.8, 5.2, 5), 6.0),
    "IPE 100": ((100, 55, 4.1, 5.7, 7), 8.1),
    "IPE 120": ((120, 64, 4.4, 6.3, 7), 10.4),
    "IPE 140": ((140, 73, 4.7, 6.9, 7), 12.9),
    "IPE 160": ((160, 82, 5.0, 7.4, 9), 15.8),
    "IPE 180": ((180, 91, 5.3, 8.0, 9), 18.8),
    "IPE 200": ((200, 100, 5.6, 8.5, 12), 22.4),
    "IPE 220": ((220, 110, 5.9, 9.2, 12), 26.2),
    "IPE 240": ((240, 120, 6.2, 9.8, 15), 30.7),
}


@pytest.mark.parametrize("name", ROLLED)
def test_a_rolled_sections_mass_is_the_printed_one(name):
    sizes, mass = ROLLED[name]
    assert i_profile(*sizes).section.area * 7.85e-3 == pytest.approx(mass, abs=0.05)


def test_torsion_and_warping_of_an_ipe_80_are_the_printed_ones():
    """IPE 80 as printed: I_t = 0.70 cm4, I_w = 117.9 cm6 (by another formula: 118.0), 80.1 cm4."""
    profile = i_profile(*ROLLED["IPE 80"][0])
    assert float(profile.sections.torsion) == pytest.approx(0.70e4, abs=50)
    assert profile.warping == pytest.approx(117.9e6, rel=2e-3)
    assert profile.section.inertia_in_plane == pytest.approx(80.1e4, abs=500)
    assert profile.section.inertia_out_of_plane == pytest.approx(8.49e4, abs=50)


def test_a_tube_of_even_walls_has_bredts_torsion():
    square = hollow_profile(52.0, 52.0, 2.0, 0.0)
    expected = 2 * 50**3 + 4 * 50 * 2**3 / 3
    assert float(square.sections.torsion) == pytest.approx(expected, rel=1e-12)
    assert square.torque == pytest.approx(1 / (2 * 50**2 * 2), rel=1e-12)
