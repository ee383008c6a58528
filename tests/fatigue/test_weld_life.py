"""Fatigue of welds: the curves of EN 1993-1-9:2005 and safeties on load, against sums by hand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fatigue.life import (
    AT_CUT_OFF,
    AT_KNEE,
    SHEAR_CUT_OFF,
    Cycles,
    endless_weld_safety,
    weld_damage,
    weld_safety,
    weld_shear_damage,
)

NOTHING = Cycles(np.zeros(1), np.zeros(1), np.zeros(1))


def cycles(ranges, counts):
    """Of one point, (1, n_cycles)."""
    half = np.atleast_2d(ranges) / 2.0
    return Cycles(half, np.zeros_like(half), np.atleast_2d(np.asarray(counts, dtype=float)))


def flat(ranges, counts):
    one = cycles(ranges, counts)
    return Cycles(one.stress_amplitude[0], one.mean_stress[0], one.cycle_counts[0])


def test_limits_are_those_that_the_code_prints():
    """EN 1993-1-9:2005, 7.1(2) and (3): 0,737, of the knee 0,549, and of shear 0,457."""
    assert_allclose(AT_KNEE, 0.737, atol=0.0005)
    assert_allclose(AT_CUT_OFF / AT_KNEE, 0.549, atol=0.0005)
    assert_allclose(SHEAR_CUT_OFF, 0.457, atol=0.0005)


@pytest.mark.parametrize(
    ("category", "stress_range", "printed"), [(100.0, 80.0, 3_906_250), (120.0, 150.0, 1_024_000)]
)
def test_printed_lives_on_the_slope_of_three(category, stress_range, printed):
    """Example table of codingace.net, Fatigue Life Calculator: cases A and B."""
    assert round(1.0 / float(weld_damage(stress_range, category))) == printed


@pytest.mark.parametrize(
    ("category", "printed"),
    [(112, 2.810e12), (90, 1.458e12), (80, 1.024e12), (71, 7.158e11), (63, 5.001e11),
     (56, 3.512e11), (50, 2.500e11), (45, 1.823e11), (40, 1.280e11), (36, 9.331e10)],
)  # fmt: skip
def test_the_constants_that_iiw_prints(category, printed):
    """IIW XIII-1965-03 (February 2005), table {4}-1: C of N = C/S^3 above the knee."""
    stress = 1.3 * category
    last_digit = 10.0 ** (np.floor(np.log10(printed)) - 3)
    assert_allclose(
        stress**3 / weld_damage(stress, category), printed, rtol=0, atol=0.5001 * last_digit
    )


@pytest.mark.parametrize(("category", "printed"), [(100.0, 45.7), (80.0, 36.6)])
def test_the_cut_off_of_shear_that_iiw_prints(category, printed):
    """The same table: range at 1e8 cycles on slope 5."""
    assert_allclose(SHEAR_CUT_OFF * category, printed, atol=0.05)


def test_a_printed_limit_of_constant_amplitude():
    """reuven.tools, Fatigue Life Calculator: category 90 endures 66.3 MPa without end."""
    (safety,) = endless_weld_safety(np.array([60.0]), 0.0, (90.0, 80.0))
    assert_allclose(safety * 60.0, 66.3, atol=0.05)


def test_lives_at_the_corners_of_the_curves():
    """2e6 at the category, 5e6 at the knee, 1e8 above the cut-off, and no damage below it."""
    corners = np.array([71.0, AT_KNEE * 71.0, AT_CUT_OFF * 71.0 * (1 + 1e-12)])
    assert_allclose(1.0 / weld_damage(corners, 71.0), [2e6, 5e6, 1e8], rtol=1e-10)
    assert weld_damage(AT_CUT_OFF * 71.0 * 0.999, 71.0) == 0.0
    shear = np.array([80.0, SHEAR_CUT_OFF * 80.0 * (1 + 1e-12)])
    assert_allclose(1.0 / weld_shear_damage(shear, 80.0), [2e6, 1e8], rtol=1e-10)
    assert weld_shear_damage(36.5, 80.0) == 0.0


def test_safety_of_one_block_by_hand():
    """1e6 cycles of 60 MPa on category 90: 2e6 (90/(60 n))^3 = 1e6, n = 1.5 x 2^(1/3)."""
    (safety,) = weld_safety(cycles([60.0], [1e6]), NOTHING, (90.0, 80.0))
    assert_allclose(safety, 1.5 * 2 ** (1 / 3), rtol=1e-12)


def test_safety_of_two_blocks_on_both_slopes_by_hand():
    """At n = 1: 1e5 of 100 MPa take 1e5/2e6 x (100/50)^3 = 0.4, the rest 3e6-fold on slope 5."""
    knee = AT_KNEE * 50.0
    small = 0.8 * knee
    count = 0.6 * 5e6 * 0.8**-5
    (safety,) = weld_safety(cycles([100.0, small], [1e5, count]), NOTHING, (50.0, 80.0))
    assert_allclose(safety, 1.0, rtol=1e-12)


def test_normal_and_shear_stress_add_their_sums():
    """0.5 each: 1e6 cycles of 36 MPa on 36, and of 80 MPa shear on 80."""
    own, beside = cycles([36.0], [1e6]), flat([80.0], [1e6])
    (safety,) = weld_safety(own, beside, (36.0, 80.0))
    assert_allclose(safety, 1.0, rtol=1e-12)


def test_the_sum_is_that_of_equation_8_3_by_equivalent_ranges():
    """Annex A: S_E2 = S_C D_s^(1/3), T_E2 = T_C D_t^(1/5); 8.3 of both at the safety is 1."""
    own, beside = cycles([55.0, 40.0], [4e5, 2e6]), flat([60.0], [3e6])
    (safety,) = weld_safety(own, beside, (40.0, 80.0))
    s = 40.0 * float((weld_damage(safety * own.stress_range, 40.0) * own.cycle_counts).sum()) ** (
        1 / 3
    )
    t = 80.0 * float(
        (weld_shear_damage(safety * beside.stress_range, 80.0) * beside.cycle_counts).sum()
    ) ** (1 / 5)
    assert_allclose((s / 40.0) ** 3 + (t / 80.0) ** 5, 1.0, rtol=1e-9)


def test_a_cut_off_that_many_cycles_come_to_is_the_safety():
    """1e9 cycles do ten times the limit just above the cut-off and nothing below it."""
    (safety,) = weld_safety(cycles([20.0], [1e9]), NOTHING, (71.0, 80.0))
    assert_allclose(safety, AT_CUT_OFF * 71.0 / 20.0, rtol=1e-12)


def test_a_life_without_end_under_both_stresses():
    """Root of (n S/S_D)^3 + (n T/T_L)^5 = 1: with both at 0.8 of their limits n = 0.8376/0.8."""
    limits = AT_KNEE * 36.0, SHEAR_CUT_OFF * 80.0
    (safety,) = endless_weld_safety(np.array([0.8 * limits[0]]), 0.8 * limits[1], (36.0, 80.0))
    root = 0.8 * safety
    assert_allclose(root**3 + root**5, 1.0, rtol=1e-12)
    assert_allclose(root, 0.8376, atol=5e-5)


def test_earlier_damage_lowers_the_endless_range_to_the_cut_off():
    fresh, begun = (
        endless_weld_safety(np.array([10.0]), 0.0, (71.0, 80.0), begun=one) for one in (False, True)
    )
    assert_allclose(begun / fresh, AT_CUT_OFF / AT_KNEE, rtol=1e-12)


def test_nothing_that_changes_is_endured_without_bound():
    assert endless_weld_safety(np.zeros(2), 0.0, (71.0, 80.0)).tolist() == [np.inf, np.inf]
    assert weld_safety(cycles([0.0], [1e6]), NOTHING, (71.0, 80.0)).tolist() == [np.inf]


def test_safeties_of_random_spectra_leave_the_limit():
    """Miner's sum counted again cycle by cycle, at the safety and just beyond it."""
    rng = np.random.default_rng(24)
    for _ in range(40):
        ranges, counts = rng.uniform(2.0, 200.0, 9), 10.0 ** rng.uniform(2.0, 7.0, 9)
        turned, often = rng.uniform(2.0, 100.0, 3), 10.0 ** rng.uniform(2.0, 7.0, 3)
        (safety,) = weld_safety(cycles(ranges, counts), flat(turned, often), (36.0, 80.0))

        def summed(factor, ranges=ranges, counts=counts, turned=turned, often=often):
            total = 0.0
            for r, n in zip(factor * ranges, counts, strict=True):
                if r > 36.0 * 0.4 ** (1 / 3):
                    total += n / (2e6 * (36.0 / r) ** 3)
                elif r > 36.0 * 0.4 ** (1 / 3) * 0.05**0.2:
                    total += n / (5e6 * (36.0 * 0.4 ** (1 / 3) / r) ** 5)
            for r, n in zip(factor * turned, often, strict=True):
                if r > 80.0 * 0.02**0.2:
                    total += n / (2e6 * (80.0 / r) ** 5)
            return total

        assert summed(safety * (1 - 1e-9)) <= 1.0 < summed(safety * (1 + 1e-9))
