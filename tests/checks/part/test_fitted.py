"""The rod of the slider-crank with stated fits: arc = 129 deg/sqrt(E* dR t/F), 90 to 120 deg."""

from math import degrees

import pytest

from checks.part.loaded_part import LoadedPart

from ...small_machine import PLATE, machine, solved


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    return solved(machine(tmp_path_factory.mktemp("rod")))


def arc_of(folder, runs, *fits):
    design = machine(folder, PLATE, *(f"parts.rod.fits.{fit}" for fit in fits))
    loaded = LoadedPart.of(design, design.parts["rod"], runs)
    return degrees(loaded.part.bearing_arc), loaded.part.arc_stated, loaded


def test_the_arc_follows_from_clearance_and_force(tmp_path, runs):
    """E* = E/(2 (1 - nu^2)) of steel on steel; the clearance for 100 deg is that of p = 1.29^2."""
    _, _, loaded = arc_of(tmp_path, runs)
    material = loaded.part.material
    star = material.youngs_modulus / (1 - material.poisson_ratio**2) / 2
    line = [loaded.loads.resultant(name).max() / 8 for name in ("first", "second")]
    looser, tighter = (float(2 * 1.29**2 * force / star) for force in sorted(line, reverse=True))
    assert looser != tighter
    arc, stated, _ = arc_of(tmp_path, runs, f"first={tighter:.12f} mm", f"second={tighter:.12f} mm")
    assert arc == pytest.approx(100.0)
    assert stated


@pytest.mark.parametrize(
    ("fits", "arc", "stated"),
    [
        ([], 90, False),
        (["first=0 mm", "second=0 mm"], 120, True),
        (["first=0 mm"], 90, False),  # nobody knows the other one
        (["first=H7/f7", "second=H7/f7"], 90, False),  # loose: 90 deg and more in bores hold it
        (["first=0 mm", "second=0 .. 0.1 mm"], 90, False),
    ],
)
def test_a_loose_or_unknown_fit_keeps_the_band_of_an_arc_that_is_not_stated(
    fits, arc, stated, tmp_path, runs
):
    assert arc_of(tmp_path, runs, *fits)[:2] == (pytest.approx(arc), stated)
