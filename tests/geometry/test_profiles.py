"""Section properties of rolled profiles against printed ones."""

import re
from pathlib import Path

import numpy as np
import pytest

from geometry.bars import hollow_profile, i_profile

PAGE = Path(__file__).parents[2] / "docs" / "beams.md"
ROW = re.compile(r"^\| ((?:IPE|HEA) \d+) \|(.*)\|$", re.MULTILINE)
ROLLED = {
    name: [float(cell) for cell in cells.split("|")]
    for name, cells in ROW.findall(PAGE.read_text(encoding="utf-8"))
}
PRINTED = {  # kg/m, of a supplier's list
    "IPE 80": 6.0, "IPE 100": 8.1, "IPE 120": 10.4, "IPE 140": 12.9, "IPE 160": 15.8,
    "IPE 180": 18.8, "IPE 200": 22.4, "IPE 220": 26.2, "IPE 240": 30.7, "IPE 270": 36.1,
    "IPE 300": 42.2, "IPE 330": 49.1, "IPE 360": 57.1, "IPE 400": 66.3, "IPE 450": 77.6,
    "IPE 500": 90.7, "IPE 550": 106.0, "IPE 600": 122.0,
}  # fmt: skip


@pytest.mark.parametrize("name", PRINTED)
def test_a_rolled_sections_mass_is_the_printed_one(name):
    digit = 0.5 if PRINTED[name] > 100 else 0.05
    mass = i_profile(*ROLLED[name][:5]).section.area * 7.85e-3
    assert mass == pytest.approx(PRINTED[name], abs=digit + 1e-3)


@pytest.mark.parametrize("name", ROLLED)
def test_the_pages_values_are_those_of_its_dimensions(name):
    *sizes, mass, in_plane, out_of_plane = ROLLED[name]
    section = i_profile(*sizes).section
    assert section.area * 7.85e-3 == pytest.approx(mass, abs=0.0501)
    assert section.inertia_in_plane / 1e4 == pytest.approx(in_plane, rel=6e-4)
    assert section.inertia_out_of_plane / 1e4 == pytest.approx(out_of_plane, rel=6e-4)


def test_the_torsion_constant_of_an_ipe_80_is_the_printed_one():
    """IPE 80 as printed: I_t = 0.70 cm4, 80.1 and 8.49 cm4."""
    profile = i_profile(*ROLLED["IPE 80"][:5])
    assert float(profile.sections.torsion) == pytest.approx(0.70e4, abs=50)
    assert profile.section.inertia_in_plane == pytest.approx(80.1e4, abs=500)
    assert profile.section.inertia_out_of_plane == pytest.approx(8.49e4, abs=50)


def test_a_tube_of_even_walls_has_bredts_torsion():
    square = hollow_profile(52.0, 52.0, 2.0, 0.0)
    expected = 2 * 50**3 + 4 * 50 * 2**3 / 3
    assert float(square.sections.torsion) == pytest.approx(expected, rel=1e-12)


def test_the_shear_area_of_a_thin_square_tube_is_that_of_its_strain_energy():
    """I^2 over the integral of S^2/t along the walls: 5/12 of the area of walls a by t."""
    tube = hollow_profile(101.0, 101.0, 1.0, 0.0).sections
    areas = [float(tube.shear_area_y), float(tube.shear_area_z)]
    assert areas == pytest.approx([5 / 12 * 400.0] * 2, rel=1e-6)


@pytest.mark.parametrize("name", ["IPE 80", "IPE 160", "IPE 300", "HEA 200"])
def test_the_shear_of_an_i_section_is_that_of_its_thin_walls(name):
    """S = b t_f h_m/2 + s (h_i^2/4 - y^2)/2 in the web and t_f z h_m/2 in flanges; no roots."""
    height, width, web, flange = ROLLED[name][:4]
    profile = i_profile(height, width, web, flange, 0.0)
    inner, apart = height - 2 * flange, height - flange
    inertia = (width * height**3 - (width - web) * inner**3) / 12
    y, z = np.linspace(-inner / 2, inner / 2, 2001), np.linspace(0.0, width / 2, 2001)
    moment = width * flange * apart / 2 + web * (inner**2 / 4 - y**2) / 2
    energy = np.trapezoid(moment**2 / web, y)
    energy += 4 * np.trapezoid((flange * z * apart / 2) ** 2 / flange, z)
    assert profile.shear == pytest.approx(moment.max() / (inertia * web), rel=1e-6)
    assert float(profile.sections.shear_area_y) == pytest.approx(inertia**2 / energy, rel=1e-6)
