"""Marin's factors against Shigley's Mechanical Engineering Design, 9th edition, chapter 6."""

import math
from itertools import pairwise

import pytest

from fatigue import endurance_limit, rectangle_equivalent_diameter, round_equivalent_diameter
from fatigue.marin import (
    SURFACES,
    EnduranceLimit,
    load_factor,
    reliability_factor,
    size_factor,
    surface_factor,
    temperature_factor,
)

ROUGHER_AND_ROUGHER = ["ground", "machined", "hot_rolled", "as_forged"]


def test_the_rotating_shaft_of_example_6_9_has_the_book_s_endurance_limit():
    """Shigley example 6-9: AISI 1050 CD, 690 MPa, machined, 32 mm; unrounded values, book 236."""
    limit = endurance_limit(690.0, "machined", equivalent_diameter=32.0)
    assert limit.uncorrected == 345.0
    assert limit.surface == pytest.approx(0.79777704, rel=1e-7)
    assert limit.size == pytest.approx(0.85766588, rel=1e-7)
    assert (limit.load, limit.temperature, limit.reliability) == (1.0, 1.0, 1.0)
    assert limit.value == pytest.approx(236.05802, rel=1e-7)


@pytest.mark.parametrize(
    ("surface", "expected"), [("machined", 0.860), ("cold_drawn", 0.860), ("as_forged", 0.540)]
)
def test_example_6_3_surface_factors(surface, expected):
    """Shigley example 6-3, 520 MPa; half a unit of the last printed digit."""
    assert surface_factor(520.0, surface) == pytest.approx(expected, abs=5e-4)


def test_surface_power_laws_agree_between_the_two_unit_systems_of_the_table():
    """Table 6-2 prints a in kpsi as well, three digits: a_MPa = a_kpsi * 6.894757**-b, 1 %."""
    in_kpsi = {"ground": 1.34, "machined": 2.70, "hot_rolled": 14.4, "as_forged": 39.9}
    for surface, a in in_kpsi.items():
        expected = a * (900.0 / 6.894757) ** SURFACES[surface][1]
        assert surface_factor(900.0, surface) == pytest.approx(expected, rel=1e-2)


def test_half_the_ultimate_strength_is_capped_at_700_mpa():
    assert endurance_limit(1400.0, "ground").uncorrected == 700.0
    assert endurance_limit(1800.0, "ground").uncorrected == 700.0


def test_a_rougher_surface_never_raises_the_limit():
    for ultimate in (200.0, 300.0, 430.0, 690.0, 1100.0, 1500.0, 2000.0):
        limits = [endurance_limit(ultimate, s).value for s in ROUGHER_AND_ROUGHER]
        assert limits == sorted(limits, reverse=True)
        assert limits[0] <= min(0.5 * ultimate, 700.0)


def test_a_soft_ground_steel_gets_no_credit_above_the_polished_specimen():
    """1.58 * 200**-0.085 = 1.007."""
    limit = endurance_limit(200.0, "ground")
    assert limit.surface == 1.0


def test_a_soft_machined_steel_gets_no_credit_over_a_ground_one():
    """The laws cross at 339 MPa: at 300 MPa 0.995 machined, 1.58 * 300**-0.085 = 0.973 ground."""
    limit = endurance_limit(300.0, "machined")
    assert limit.surface == pytest.approx(0.973, abs=5e-4)


def test_a_larger_part_never_endures_more():
    sizes = [size_factor(0.5 * 1.02**i) for i in range(400)]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] == 1.0


@pytest.mark.parametrize(
    ("diameter", "expected"),
    [
        (2.79, 1.0),
        (7.62, 1.0),
        (20.0, (20.0 / 7.62) ** -0.107),
        (51.0, (51.0 / 7.62) ** -0.107),
        (52.0, 1.51 * 52.0**-0.157),
        (254.0, 0.63302),
    ],
)
def test_size_factor_in_the_book_s_ranges(diameter, expected):
    """Eq. (6-20); the last value is 1.51 * exp(-0.157 ln 254), computed apart from the code."""
    assert size_factor(diameter) == pytest.approx(expected, rel=1e-5)


def test_the_size_factor_jumps_by_no_more_than_0_2_percent_at_51_mm_and_not_at_7_62_mm():
    assert 0.0 < 1.0 - size_factor(51.0000001) / size_factor(51.0) < 2e-3
    assert size_factor(7.6200001) == pytest.approx(1.0, abs=1e-8)


def test_axial_load_has_no_size_effect_but_its_own_factor():
    limit = endurance_limit(500.0, "machined", equivalent_diameter=100.0, load="axial")
    assert (limit.size, limit.load) == (1.0, 0.85)


def test_torsion_has_no_factor_because_stresses_are_compared_in_the_von_mises_norm():
    assert load_factor("torsion") == 1.0


def test_equivalent_diameters_of_the_book():
    """Eq. (6-25), example 6-4: a rectangle h by b; and (6-24) for a round bar that does not turn.

    Both equate the area stressed above 95 %: 0.0105 d**2 and 0.05 hb with 0.0766 de**2 of a
    turning bar; the coefficients are printed with three digits.
    """
    assert round_equivalent_diameter(32.0) == pytest.approx(
        32.0 * math.sqrt(0.01046 / 0.0766), 2e-3
    )
    assert rectangle_equivalent_diameter(40.0, 6.0) == pytest.approx(
        math.sqrt(0.05 * 240.0 / 0.0766), rel=2e-2
    )
    assert rectangle_equivalent_diameter(6.0, 40.0) == rectangle_equivalent_diameter(40.0, 6.0)


@pytest.mark.parametrize(
    ("celsius", "expected"),
    [(300.0, 0.975), (350.0, 0.943), (400.0, 0.900), (450.0, 0.843), (500.0, 0.768)],
)
def test_temperature_factors_of_table_6_4(celsius, expected):
    """Shigley table 6-4; the polynomial (6-27) was fitted to it, within 0.006."""
    assert temperature_factor(celsius) == pytest.approx(expected, abs=6e-3)


def test_the_temperature_factor_is_1_up_to_250_c_never_rises_and_has_no_step():
    assert temperature_factor(-40.0) == temperature_factor(250.0) == 1.0
    values = [temperature_factor(250.0 + 0.5 * i) for i in range(575)]
    assert values == sorted(values, reverse=True)
    assert max(a - b for a, b in pairwise(values)) < 2e-3


@pytest.mark.parametrize("celsius", [538.0, 2000.0, -300.0, math.nan])
def test_temperatures_without_data_are_refused(celsius):
    with pytest.raises(ValueError, match="the temperature must lie between"):
        endurance_limit(500.0, "machined", temperature=celsius)


@pytest.mark.parametrize(
    ("survive", "expected"),
    [
        (0.5, 1.000),
        (0.90, 0.897),
        (0.95, 0.868),
        (0.99, 0.814),
        (0.999, 0.753),
        (0.9999, 0.702),
        (0.99999, 0.659),
        (0.999999, 0.620),
    ],
)
def test_reliability_factors_of_table_6_5(survive, expected):
    """Half a unit of the last digit, and the same again for the book's rounded z at 90 %."""
    assert reliability_factor(survive) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("survive", [0.0, 0.49, 0.9999999, 1.0, 99.0, math.nan])
def test_reliabilities_outside_the_table_are_refused(survive):
    with pytest.raises(ValueError, match=r"reliability must lie between 0\.5 and 0\.999999"):
        reliability_factor(survive)


def test_all_factors_multiply():
    limit = endurance_limit(
        600.0, "hot_rolled", equivalent_diameter=40.0, temperature=400.0, reliability=0.99
    )
    product = 300.0 * 57.7 * 600.0**-0.718 * (40.0 / 7.62) ** -0.107
    assert limit.value == pytest.approx(product * limit.temperature * limit.reliability, rel=1e-12)
    assert limit.temperature < 0.91
    assert limit.reliability < 0.82


def test_a_measured_specimen_limit_replaces_half_the_ultimate_strength():
    limit = endurance_limit(600.0, "machined", specimen_limit=250.0)
    assert limit.value == pytest.approx(250.0 * 4.51 * 600.0**-0.265, rel=1e-12)


@pytest.mark.parametrize("bad", [0.0, -430.0, math.nan, math.inf])
def test_impossible_strengths_are_refused(bad):
    with pytest.raises(ValueError, match="ultimate strength must be above 0 MPa"):
        endurance_limit(bad, "machined")
    with pytest.raises(ValueError, match="specimen limit must be above 0 MPa"):
        endurance_limit(430.0, "machined", specimen_limit=bad)
    with pytest.raises(ValueError, match="equivalent diameter must be above 0 mm"):
        endurance_limit(430.0, "machined", equivalent_diameter=bad)


def test_unknown_words_are_refused_with_the_known_ones():
    with pytest.raises(ValueError, match="'polished' is unknown; one of ground, machined"):
        endurance_limit(430.0, "polished")
    with pytest.raises(ValueError, match="'bend' is unknown; one of bending, axial, torsion"):
        endurance_limit(430.0, "machined", load="bend")


def test_a_result_that_is_not_its_product_is_refused():
    with pytest.raises(ValueError, match="product of its factors"):
        EnduranceLimit(200.0, 300.0, 0.5, 1.0, 1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match="at most at 1"):
        EnduranceLimit(360.0, 300.0, 1.2, 1.0, 1.0, 1.0, 1.0)
