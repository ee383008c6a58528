"""Support numbers and notch factors against pyLife, the guideline's example and the book."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fatigue import stieler_support

from .fkm_oracle import GROUPS, pylife_stieler

GRADIENTS = np.r_[0.0, 1e-9, 0.03, 0.1, 0.100001, 0.5, 1.0, 1.000001, 7.0, 99.9]


def test_the_gradient_of_the_guideline_s_example_gives_its_support_number():
    """FT-09, guideline example 6.2: GJL, 210 MPa, G = 0.5/mm; printed 1.682."""
    assert stieler_support(0.5, 210.0, "grey_iron") == pytest.approx(1.682118773, rel=1e-9)


@pytest.mark.parametrize("group", GROUPS)
def test_stieler_is_pylifes_in_all_three_branches(group):
    ours = stieler_support(GRADIENTS, 640.0, group)
    assert_allclose(ours, pylife_stieler(group, "normal", GRADIENTS, 640.0), rtol=1e-9)


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


def test_unknown_words_and_impossible_sizes_are_refused():
    with pytest.raises(ValueError, match="group 'iron' is unknown; one of steel"):
        stieler_support(0.1, 500.0, "iron")
