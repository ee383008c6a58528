"""The FKM guideline's chain for parts that are not welded: its example, pyLife, and refusals."""

import numpy as np
import pylife._fkm_linear_functions as pylife_functions
import pytest
from numpy.testing import assert_allclose

from fatigue import (
    FKM_GROUPS,
    ComponentLimit,
    FkmMaterial,
    component_limit,
    endurance_limit,
    fkm_curve,
    fkm_factor,
    fkm_utilisation,
    goodman,
    goodman_utilisation,
    roughness_factor,
)

from .fkm_oracle import GROUPS, numbers, pylife_roughness

GREY = FkmMaterial(210.0, "grey_iron")
STEEL = FkmMaterial(600.0)


def example():
    """Guideline example 6.2 without K_NL,E: grey iron, Rz 200 micrometres, G = 0.5/mm, GJL-200."""
    given = {"roughness": 200.0, "gradient": 0.5}
    return component_limit(GREY, **given)


def test_the_guideline_s_worked_example_is_reached():
    """FT-09: guideline example 6.2; the exact values beside what it prints.

    The example has K_NL,E = 1.05 for grey iron in bending, by which no part that can be checked
    is judged: it divides the design factor.
    """
    limit, bent = example(), 1.05
    assert limit.strength == pytest.approx(71.4, rel=1e-12)  # 71
    assert limit.roughness == pytest.approx(0.9139530813, rel=1e-9)  # 0.914
    assert limit.support == pytest.approx(1.682118773, rel=1e-9)  # 1.682
    assert limit.design_factor / bent == pytest.approx(0.6194840684, rel=1e-9)  # 0.619
    assert limit.limit * bent == pytest.approx(115.2572013, rel=1e-9)  # 115
    at_mean = fkm_factor(47.0, 13.0, limit.sensitivity)
    assert at_mean == pytest.approx(0.8785046729, rel=1e-9)  # 0.879
    assert at_mean * limit.limit * bent == pytest.approx(101.25399, rel=1e-7)  # 101
    assert fkm_utilisation(47.0, 13.0, limit) / bent == pytest.approx(0.4641792389, rel=1e-9)


@pytest.mark.parametrize("group", GROUPS)
def test_the_numbers_of_every_group_are_pylifes(group):
    own = FKM_GROUPS[group]
    theirs, ratio = numbers(group, "shear")
    assert own.shear_ratio == ratio
    assert (own.strength_ratio, own.roughness, own.least_strength) == (
        theirs.fw_s,
        theirs.aR_s,
        theirs.RmNmin,
    )
    assert (*own.support, own.surface_notch) == (theirs.aG, theirs.bG, theirs.Kf_loc)
    expected = theirs.a_M * 0.6 + theirs.b_M
    assert FkmMaterial(600.0, group).sensitivity == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("group", GROUPS)
def test_the_roughness_factor_is_pylifes(group):
    for roughness in (1.0, 6.3, 25.0, 200.0):
        ours = roughness_factor(roughness, 700.0, group)
        assert ours == pytest.approx(pylife_roughness(group, "normal", roughness, 700.0), rel=1e-9)


def test_the_design_factor_and_the_factor_of_mean_stress_are_pylifes():
    support, notch, rough, none = 1.3, 2.0, 0.85, 1.0
    limit = ComponentLimit(
        limit=np.array(1.3 * 270.0 / (1 + (1 / 0.85 - 1) / 2)),
        strength=270.0,
        support=np.array(support),
        roughness=rough,
        notch_factor=notch,
        sensitivity=0.11,
        endures=True,
    )
    columns = [np.array([v]) for v in (support, notch, rough, none, none, none)]
    assert_allclose(limit.design_factor, pylife_functions.design_factor(*columns)[0], rtol=1e-9)
    ratios = np.array([-4.0, -1.0, -0.2, 0.1, 0.5])
    shares = (1 + ratios) / (1 - ratios)
    theirs = pylife_functions.sm_factor(ratios, np.full(5, 0.11), shares)
    ours = fkm_factor(50.0, 50.0 * shares, limit.sensitivity)
    assert_allclose(ours, theirs, rtol=1e-9)


def test_the_chain_of_a_steel_by_hand():
    """Rm 600, Rz 10, G 0.5: sigma_W 270, n = 1 + 0.70711 10**-0.72222 = 1.13404.

    K_R = 1 - 0.22 lg 3 = 0.895034, K_f~ 2: 1 + 0.117276/2 = 1.058638.
    """
    limit = component_limit(STEEL, roughness=10.0, gradient=0.5)
    assert limit.limit == pytest.approx(270.0 * 1.13404 / 1.058638, rel=1e-5)


def test_a_limit_per_point_takes_a_gradient_per_point():
    gradients = np.array([0.0, 0.2, 5.0])
    limit = component_limit(STEEL, roughness=10.0, gradient=gradients)
    one = [component_limit(STEEL, roughness=10.0, gradient=g).limit for g in gradients]
    assert_allclose(limit.limit, one, rtol=1e-15)
    use = fkm_utilisation([100.0, 100.0, 100.0], 0.0, limit)
    assert_allclose(use, 100.0 / limit.limit, rtol=1e-15)
    assert fkm_curve(limit).knee_amplitude.shape == (3,)


def test_an_even_stress_has_no_support():
    assert component_limit(STEEL, roughness=1.0).limit == pytest.approx(270.0)


def test_the_example_is_used_as_far_as_the_guideline_says():
    limit = example()
    assert fkm_utilisation(47.0, 13.0, limit) == pytest.approx(1.05 * 0.4641792389)
    assert fkm_curve(limit).knee_amplitude == pytest.approx(limit.limit)


def test_compression_does_not_help():
    limit = example()
    assert fkm_utilisation(50.0, -50.0, limit) == fkm_utilisation(50.0, 0.0, limit)
    assert fkm_utilisation(50.0, 50.0, limit) > 1.2 * fkm_utilisation(50.0, 0.0, limit)


def test_the_extremes_of_a_stress_are_judged_or_refused_with_their_place():
    limit = component_limit(STEEL, roughness=10.0)
    assert fkm_utilisation(0.0, 0.0, limit) == 0.0
    assert fkm_utilisation(0.0, 500.0, limit) == 0.0  # constant stress: a case for yield
    above = fkm_utilisation([700.0, 100.0], [0.0, 600.0], limit)
    assert above[0] == pytest.approx(700.0 / limit.limit)
    assert above[1] == pytest.approx(100.0 / limit.limit * (1 + 0.11) ** 2 / (1 + 0.11 / 3))
    with pytest.raises(ValueError, match="amplitude is not finite: nan at cycle 1"):
        fkm_utilisation([1.0, np.nan], 0.0, limit)
    assert fkm_curve(limit).cycles_to_failure(0.999 * limit.limit) == np.inf


def test_aluminium_goes_on_to_fail_below_the_knee():
    """Knee at 1e6, then slope 15: half the amplitude lasts 2**15 times as long, 3.3e10 cycles."""
    limit = component_limit(FkmMaterial(295.0, "wrought_aluminium"), roughness=10.0)
    curve = fkm_curve(limit)
    assert curve.cycles_to_failure(limit.limit) == pytest.approx(1e6)
    assert curve.cycles_to_failure(0.5 * limit.limit) == pytest.approx(1e6 * 2**15)
    assert curve.cycles_to_failure(2.0 * limit.limit) == pytest.approx(1e6 / 2**5)


def test_a_surface_smoother_than_1_micrometre_or_a_soft_material_gains_nothing():
    assert roughness_factor(0.0, 600.0) == roughness_factor(1.0, 600.0) == 1.0
    assert roughness_factor(100.0, 150.0) == 1.0  # 2 Rm below R_m,N,min
    with pytest.raises(ValueError, match="leaves no strength"):
        roughness_factor(1e7, 2000.0)
    with pytest.raises(ValueError, match="Rz must be at least 0 micrometres, got nan"):
        roughness_factor(np.nan, 600.0)


def test_marin_s_limit_and_the_guideline_s_refuse_each_other():
    marin = endurance_limit(600.0, "machined")
    fkm = component_limit(STEEL, roughness=10.0)
    with pytest.raises(TypeError, match=r"ComponentLimit, got EnduranceLimit: .* never mixed"):
        fkm_utilisation(100.0, 0.0, marin)
    with pytest.raises(TypeError, match="ComponentLimit, got float"):
        fkm_curve(200.0)
    history = np.zeros((1, 6, 1)), np.ones((1, 2))
    with pytest.raises(TypeError, match="cannot stand for an endurance limit of Marin's chain"):
        goodman(*history, fkm, 600.0)
    with pytest.raises(TypeError, match="cannot stand for an endurance limit of Marin's chain"):
        goodman_utilisation(np.array([1.0]), np.array([0.0]), fkm, 600.0)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((0.0,), "ultimate strength must be above 0 MPa"),
        ((600.0, "iron"), "'iron' is unknown; one of steel"),
        ((850.0, "cast_aluminium"), r"sensitivity would be 1\.05, which must be below 1"),
    ],
)
def test_impossible_materials_are_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        FkmMaterial(*arguments)
