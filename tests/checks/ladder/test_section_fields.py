"""Stress of section forces all over parts that no mesh was solved for."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.ladder.part_fields import _peaks, _superposition, sections_of
from checks.part.part_loads import PartLoads
from geometry.cad_body import Skin, cad_skin
from geometry.parts import PlateLink

DESIGNS = Path(__file__).parents[3] / "designs"


def loads_of(wrenches):
    return PartLoads(
        {name: np.array([wrench], dtype=float) for name, wrench in wrenches.items()},
        np.zeros((1, 4)),
        {"press": slice(0, 1)},
        ("x",),
        ("press",),
    )


def stress(basis, coefficients):
    return np.einsum("rnc,r->nc", basis, coefficients[:, 0])


def test_sections_of_a_plate_and_through_its_hole_are_those_by_hand():
    """40 x 12 mm off the pins; at a pin of 16 mm the hole's height is gone."""
    skin = cad_skin(PlateLink(length=200.0, width=40.0, thickness=12.0, hole=16.0))
    moved = Skin(skin.nodes + np.array([0.0, 5.0, -3.0]), skin.triangles)
    area, y, z, about_z, about_y = sections_of(moved, np.array([100.001, 0.001]))
    assert_allclose(area, [480.0, 12.0 * 24.0], rtol=5e-3)
    assert_allclose([*y, *z], [5.0, 5.0, -3.0, -3.0], atol=0.02)
    assert_allclose(about_z, [12 * 40**3 / 12, 12 * (40**3 - 16**3) / 12], rtol=5e-3)
    assert_allclose(about_y, [40 * 12**3 / 12, 24 * 12**3 / 12], rtol=5e-3)


@pytest.fixture(scope="module")
def bars():
    """Bars of a plain tube: the formula's peak is that of the section forces."""
    design = read_design(DESIGNS / "toggle_press_30x30.toml", ())
    return check_design(design, effort=Effort("formula"), live=True)


def test_the_estimate_of_a_plain_tube_is_what_its_formula_says(bars):
    for part in bars.parts:
        (static,) = [check for check in part.checks if check.kind == "static"]
        (fatigue,) = [check for check in part.checks if check.kind == "fatigue"]
        live = part.live
        assert live.estimated
        assert not live.decides
        assert "estimate" in live.notes[0]
        peak = max(float(peaks.max()) for peaks in live.peaks.values())
        assert_allclose(peak, static.value, rtol=2e-3)
        # without the required safety, which the page adds; the surface factor's limit is the same
        assert_allclose(live.fatigue["utilisation"].max(), 1 / fatigue.safety, rtol=0.01)


def test_no_part_stays_grey(bars):
    assert all(part.live.n_fields and not part.live.missing.keys() & {"mises", "principal"}
               for part in bars.parts)  # fmt: skip


def test_a_pin_is_pulled_on_the_side_that_its_middle_is_pushed_to():
    """Three lugs: the middle one pushes towards +x, both cheeks hold; M/W of the even pressures."""
    part = read_design(DESIGNS / "toggle_press.toml", ()).parts["pin_B"]
    seats = {seat.name: seat for seat in part.geometry.seats}
    force = 10e3
    wrenches = {name: np.zeros(6) for name in seats}
    wrenches["cylinder"][0], wrenches["upper"][0] = force, -force
    middle, cheek = seats["cylinder"], seats["upper"]
    skin = cad_skin(part.geometry)
    found = stress(*_superposition(part, loads_of(wrenches), skin))
    at = np.abs(skin.nodes[:, 2]) < 1.5
    x = skin.nodes[at, 0]
    moment = force / 2 * (max(cheek.places) - middle.width / 4)
    radius = (middle.diameter or part.geometry.diameter) / 2
    expected = moment * x / (np.pi / 4 * radius**4)
    assert_allclose(found[at, 2], expected, atol=0.02 * np.abs(expected).max())


@pytest.mark.parametrize("count", [1, 2])
def test_peaks_are_the_largest_von_mises_stress_of_the_fields_at_each_position(count):
    """sqrt(xx^2 + 3 xy^2 + 3 zx^2), of one field as of more."""
    random = np.random.default_rng(count)
    basis, coefficients = np.zeros((count, 40, 6)), random.normal(size=(count, 9))
    basis[:, :, [0, 3, 5]] = random.normal(size=(count, 40, 3))
    xx, xy, zx = (np.einsum("rn,rk->nk", basis[:, :, k], coefficients) for k in (0, 3, 5))
    expected = np.sqrt(xx**2 + 3 * (xy**2 + zx**2)).max(axis=0)
    assert_allclose(_peaks(basis, coefficients), expected, rtol=1e-12)
