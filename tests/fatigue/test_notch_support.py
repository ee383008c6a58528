"""Support numbers and notch factors against pyLife, the guideline's example and the book."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pylife.strength.fkm_linear.fkm_functions import FkmLinearFunctions

from fatigue import FKM_GROUPS, fkm_2012_support, neuber_notch_factor, stieler_support

from .fkm_oracle import GROUPS, pylife_stieler

GRADIENTS = np.r_[0.0, 1e-9, 0.03, 0.1, 0.100001, 0.5, 1.0, 1.000001, 7.0, 99.9]


def test_the_gradient_of_the_guideline_s_example_gives_its_support_number():
    """FT-09, guideline example 6.2: GJL, 210 MPa, G = 0.5/mm; printed 1.682."""
    assert stieler_support(0.5, 210.0, "grey_iron") == pytest.approx(1.682118773, rel=1e-9)


@pytest.mark.parametrize("stress", ["normal", "shear"])
@pytest.mark.parametrize("group", GROUPS)
def test_stieler_is_pylifes_in_all_three_branches(group, stress):
    ours = stieler_support(GRADIENTS, 640.0, group, stress)
    assert_allclose(ours, pylife_stieler(group, stress, GRADIENTS, 640.0), rtol=1e-9)


def test_the_three_branches_of_stieler_meet():
    for edge in (0.1, 1.0):
        below, above = stieler_support([edge * (1 - 1e-9), edge * (1 + 1e-9)], 600.0)
        assert above == pytest.approx(below, rel=1e-8)


def test_the_support_numbers_of_steel_by_hand():
    """540 MPa: 10**-(0.5 + 0.2) = 0.1995; times G sqrt(10), sqrt(G), G**(1/4)."""
    expected = 1 + 10**-0.7 * np.array([0.05 * 10**0.5, 0.6, 2.0])
    assert_allclose(stieler_support([0.05, 0.36, 16.0], 540.0), expected, rtol=1e-14)


def test_no_support_where_stress_grows_inwards_or_is_even():
    assert stieler_support([-3.0, 0.0, -np.inf], 500.0).tolist() == [1.0, 1.0, 1.0]


def test_a_gradient_beyond_100_per_mm_counts_as_100():
    at_end, beyond, spike = stieler_support([100.0, 1e4, np.inf], 500.0)
    assert at_end == beyond == spike


def test_a_gradient_that_is_not_a_number_is_refused_with_its_place():
    with pytest.raises(ValueError, match="not a number: nan at point 2"):
        stieler_support([0.1, 0.2, np.nan], 500.0)
    with pytest.raises(ValueError, match="not a number"):
        fkm_2012_support(np.nan, 100.0, 500.0)


@pytest.mark.parametrize("area", [3.0, 500.0, 2e4])
@pytest.mark.parametrize("ultimate", [400.0, 900.0])
@pytest.mark.parametrize("group", GROUPS)
def test_the_2012_support_numbers_are_pylifes(group, ultimate, area):
    oracle = FkmLinearFunctions()
    for gradient in (0.0, 0.4, 5.0):
        limit = FKM_GROUPS[group].strength_ratio * ultimate
        theirs = oracle.support_fkm2012_local_surf(GROUPS[group], gradient, area, ultimate, limit)
        ours = fkm_2012_support(gradient, area, ultimate, group)
        got = (ours.statistical, ours.plastic, float(ours.fracture), float(ours.value))
        assert_allclose(got, theirs, rtol=1e-9)


def test_the_plastic_support_of_very_hard_steel_ends_at_1():
    """e_pl reaches 0 at 630 (1 + 1/0.375) = 2310 MPa, and stays there."""
    assert fkm_2012_support(0.0, 500.0, 2400.0).plastic == 1.0
    assert fkm_2012_support(0.0, 500.0, 2300.0).plastic > 1.0


def test_neuber_s_factor_of_shigley_s_shaft():
    """FT-03, example 6-9: K_t 1.65, r 3 mm, 690 MPa; book 1.55, with sqrt(a) = 0.313 sqrt(mm)."""
    assert neuber_notch_factor(1.65, 3.0, 690.0) == pytest.approx(1.5505159, abs=5e-4)


def test_neuber_s_factor_lies_between_1_and_the_stress_concentration():
    for load in ("bending", "axial", "torsion"):
        factors = [neuber_notch_factor(2.5, r, 600.0, load) for r in (1e-9, 0.1, 1.0, 10.0, 1e8)]
        assert factors == sorted(factors)
        assert factors[0] == pytest.approx(1.0, abs=1e-3)
        assert factors[-1] == pytest.approx(2.5, abs=1e-3)
    assert neuber_notch_factor(1.0, 1.0, 600.0) == 1.0


@pytest.mark.parametrize("load", ["bending", "torsion"])
def test_neuber_s_constant_is_never_below_0_and_falls_with_strength(load):
    factors = [neuber_notch_factor(2.0, 1.0, s, load) for s in np.linspace(340.0, 1700.0, 60)]
    assert factors == sorted(factors)
    assert factors[-1] <= 2.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((0.9, 1.0, 600.0), "at least 1, got 0.9"),
        ((2.0, 0.0, 600.0), "notch radius must be above 0 mm"),
        ((2.0, 1.0, 2000.0), "from 340 to 1700 MPa, got 2000"),
        ((2.0, 1.0, 600.0, "shear"), "'shear' is unknown; one of bending, axial, torsion"),
    ],
)
def test_neuber_refuses_what_it_has_no_data_for(arguments, words):
    with pytest.raises(ValueError, match=words):
        neuber_notch_factor(*arguments)


def test_unknown_words_and_impossible_sizes_are_refused():
    with pytest.raises(ValueError, match="group 'iron' is unknown; one of steel"):
        stieler_support(0.1, 500.0, "iron")
    with pytest.raises(ValueError, match="stress 'bending' is unknown; one of normal, shear"):
        stieler_support(0.1, 500.0, "steel", "bending")
    with pytest.raises(ValueError, match="highly stressed area must be above 0 mm2"):
        fkm_2012_support(0.1, 0.0, 500.0)
