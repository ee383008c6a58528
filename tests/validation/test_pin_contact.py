import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

from bench.closed_forms import lug_factor
from bench.pin_contact import compare, condensed, contact, cosine
from bench.pin_models import EYES, Eye, Grid, box
from checks.handbook.pin_loaded_hole import BEYOND_ARCS
from fem.contact.persson import persson_half_arc, persson_pressure
from tests.fem.calculix import needs_calculix


@pytest.mark.parametrize("degrees", [5, 30, 84])
def test_perssons_pressure_carries_the_force(degrees):
    """Quadrature to 1e-9; the formulas have no other error."""
    half = np.radians(degrees)
    carried, _ = quad(lambda a: persson_pressure(half, a) * np.cos(a), -half, half)
    assert_allclose(carried, 1, rtol=1e-8)


def test_small_arcs_are_those_of_hertz():
    """Half arc sqrt(4/(pi p)) and pressure sqrt(p/pi); Persson differs by O(half arc squared)."""
    parameter = 1e3
    half = persson_half_arc(parameter)
    assert_allclose(half, np.sqrt(4 / (np.pi * parameter)), rtol=half**2)
    assert_allclose(persson_pressure(half), np.sqrt(parameter / np.pi), rtol=half**2)


@pytest.mark.parametrize(
    ("share", "of_half_circle", "of_band"),
    [(0.3, 1.13, 1.065), (0.4, 1.07, 1.02), (0.5, 1.08, 1.01)],
)
def test_a_square_ended_lug_reaches_the_charts_factor_by_its_bars_not_by_its_value(
    share, of_half_circle, of_band
):
    """Peterson's chart over the peak under cosines on 180, and on 180 to 90 degrees.

    "Pins in holes" in bench/validation_notes.md; half a per cent for the mesh.
    """
    width, force = 20.0, 1000.0
    reach, corners = box(2.5 * width, width / 2, width)
    eye = Eye("lug", share * width, 1.0, force, reach, corners, -2.5 * width)
    grid = Grid(eye, 1.2, 0.0, 1.0)
    nominal = force / (width - eye.hole)
    peaks = [cosine(grid, arc).hoop / nominal for arc in (180.0, 135.0, 90.0)]
    chart = lug_factor(eye.hole, width)
    assert chart / peaks[0] == pytest.approx(of_half_circle, abs=8e-3)
    assert chart / max(peaks) == pytest.approx(of_band, abs=8e-3)
    assert (1 + BEYOND_ARCS) * max(peaks) > chart  # the upper end of a check's default bars


# K_tb of Niu's Fig. 7.7.25, as digitised in Borlag/jolt, jolt/fatigue.py at 3df95dd, between points
NIUS = {0.2: 1.2816, 0.3: 1.5583, 0.4: 1.9722, 0.5: 2.6506, 0.6: 3.572}
# Net factors at 1 % clearance by ESDU 81006, as fitted in a public calculator, for a/W 0.6 and 0.5.
ESDUS = {(0.6, 0.3): 3.893, (0.6, 0.4): 3.313, (0.6, 0.5): 3.048,
         (0.5, 0.3): 4.207, (0.5, 0.4): 3.674, (0.5, 0.5): 3.447}  # fmt: skip


@pytest.mark.parametrize(
    ("front", "share", "factor"),
    [
        *((1.0, u, bearing * (1 - u) / u) for u, bearing in NIUS.items()),
        *((*at, factor) for at, factor in ESDUS.items()),
    ],
)
def test_a_lugs_default_bars_hold_the_charts_of_niu_and_of_esdu(front, share, factor):
    """Above the half circle's own peak, below the upper end of the bars: "Pins in holes"."""
    width, force = 20.0, 1000.0
    reach, corners = box(2.5 * width, width / 2, front * width)
    eye = Eye("lug", share * width, 1.0, force, reach, corners, -2.5 * width)
    grid = Grid(eye, 1.2, 0.0, 1.0)
    nominal = force / (width - eye.hole)
    peaks = [cosine(grid, arc).hoop / nominal for arc in (180.0, 135.0, 90.0)]
    assert peaks[0] < factor < (1 + BEYOND_ARCS) * max(peaks)


@pytest.mark.parametrize(
    ("share", "neat", "loose"), [(0.15, 6.39, 7.94), (0.3, 3.43, 3.47), (0.5, 2.24, 2.51)]
)
def test_clearance_raises_a_lugs_factor_by_less_than_the_default_bars(share, neat, loose):
    """Net factors of contact at E* dR t/F 0 and 4, half a per cent: "Measured" of "Pins in holes".

    Less than the 35 to 50 % of Budynas and Nisbett's figure A-15-12, which the page tells of.
    """
    width, force = 20.0, 1000.0
    reach, corners = box(2.5 * width, width / 2, width)
    eye = Eye("lug", share * width, 1.0, force, reach, corners, -2.5 * width)
    nominal = force / (width - eye.hole)
    half = Grid(eye, 1.2, 0.0, 1.0)
    top = (1 + BEYOND_ARCS) * max(cosine(half, arc).hoop for arc in (180.0, 135.0, 90.0))
    for parameter, expected in ((0.0, neat), (4.0, loose)):
        grid = Grid(eye, persson_half_arc(parameter), eye.clearance(parameter), 1.0)
        found = condensed(grid).hoop
        assert found / nominal == pytest.approx(expected, rel=5e-3)
        assert found < top


@pytest.mark.parametrize(
    ("eye", "clearance", "arc", "pressure", "mises", "hoop"),
    [
        (EYES[0], 0.0, 153, 156, 216, 91),
        (EYES[0], 0.1, 93, 195, 199, 85.7),
        (EYES[1], 0.0, 180, 3.8, 9.46, 9.47),
        (EYES[1], 0.1, 15, 32.9, 35.7, 14.8),
        (EYES[2], 0.0, 182, 6.55, 17, 17.1),
        (EYES[2], 0.1, 13, 71.3, 76.2, 26.5),
        (EYES[3], 0.0, 193, 2.02, 6.09, 6.9),
        (EYES[3], 0.1, 9, 28.2, 14.3, 11.6),
    ],
)
def test_condensed_contact_is_calculixs(eye, clearance, arc, pressure, mises, hoop):
    """The table of "Pins in holes" in docs/validation.md; measured 0.3 % at most, hoop 2 %."""
    grid = Grid(eye, persson_half_arc(eye.parameter(clearance)), clearance)
    found = condensed(grid)
    assert_allclose(found.arc, arc, atol=2)
    assert_allclose(found.pressure, pressure, rtol=6e-3)
    assert_allclose(found.mises, mises, rtol=8e-3)
    assert_allclose(found.hoop, hoop, rtol=0.025)


@pytest.mark.parametrize("eye", EYES, ids=lambda eye: eye.name)
@pytest.mark.parametrize("arc", [120, 180])
def test_cosine_pressures_carry_the_force_and_end_where_they_should(eye, arc):
    """Read from recovered stress on elements of 4 degrees: 0.3 %, and one element at each end."""
    reading = cosine(Grid(eye, 1.2, 0.0, 0.6), arc)
    assert_allclose(reading.carried, 1, atol=3e-3)
    assert_allclose(reading.arc, arc, atol=2 * 4.2)


def test_the_eye_takes_its_clearance_back_from_the_parameter():
    for eye in EYES:
        assert_allclose(eye.clearance(eye.parameter(0.1)), 0.1)


@needs_calculix
@pytest.mark.slow
def test_contact_in_the_wide_cheek_is_near_perssons_theory():
    """8 degrees and 10 %: the cheek is no infinite plate and coarse here."""
    eye, half = EYES[0], persson_half_arc(4.0)
    reading = contact(Grid(eye, half, eye.clearance(4.0), 0.6))
    theory = persson_pressure(half) * eye.force / eye.thickness / (eye.hole / 2)
    assert_allclose(reading.arc, 2 * np.degrees(half), atol=8)
    assert_allclose(reading.pressure, theory, rtol=0.1)


@needs_calculix
@pytest.mark.slow
def test_the_band_holds_the_peaks_at_a_parameter_of_2_and_not_at_8():
    """The rule of "Pins in holes" in bench/validation_notes.md."""
    eye = EYES[2]
    inside, outside = (compare(eye, eye.clearance(value), 0.6) for value in (2.0, 8.0))
    for quantity in ("mises", "hoop"):
        assert inside.beyond(quantity) == 0
        assert 0.03 < outside.beyond(quantity) < 0.15
