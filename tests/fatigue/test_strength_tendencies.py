"""Tendencies that never lengthen a life, by both chains: rougher, larger, hotter and so on."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fatigue import (
    FKM_GROUPS,
    FkmMaterial,
    basquin_curve,
    component_limit,
    endurance_limit,
    fkm_curve,
    fkm_factor,
    fkm_utilisation,
)

COMMON = settings(max_examples=60, deadline=None, derandomize=True)
STRENGTH = st.floats(340.0, 1500.0)
AMPLITUDE = st.floats(0.05, 0.85)  # of the ultimate strength
GROUP = st.sampled_from(sorted(FKM_GROUPS))
ROUGHER = ("ground", "machined", "hot_rolled", "as_forged")
KEEP = 1.0 + 1e-12


def pair(low, high):
    """Two numbers, the worse one last."""
    number = st.floats(low, high)
    return st.tuples(number, number).map(sorted)


def marin_life(strength, amplitude, *, notch=1.0, surface="machined", **changes):
    """Cycles that a nominal amplitude endures, by Shigley's line."""
    limit = endurance_limit(strength, surface, **changes).value
    return float(basquin_curve(strength, limit).cycles_to_failure(notch * amplitude * strength))


def of_group(group, strength):
    """A material of that strength; of aluminium 0.4 of it, which goes to 600 MPa."""
    return FkmMaterial(strength * (0.4 if "aluminium" in group else 1.0), group)


def fkm_life(group, strength, amplitude, *, roughness=10.0, **changes):
    """Cycles that a local amplitude endures, by the guideline."""
    material = of_group(group, strength)
    limit = component_limit(material, roughness=roughness, **changes)
    return float(fkm_curve(limit).cycles_to_failure(amplitude * material.ultimate_strength))


@COMMON
@given(STRENGTH, AMPLITUDE, st.integers(0, 3), st.integers(0, 3))
def test_a_rougher_surface_never_lengthens_life_by_marin(strength, amplitude, one, other):
    smooth, rough = sorted((one, other))
    lives = [marin_life(strength, amplitude, surface=ROUGHER[i]) for i in (smooth, rough)]
    assert lives[1] <= lives[0] * KEEP


@COMMON
@given(GROUP, STRENGTH, AMPLITUDE, pair(0.0, 200.0))
def test_a_rougher_surface_never_lengthens_life_by_the_guideline(group, strength, amplitude, rz):
    lives = [fkm_life(group, strength, amplitude, roughness=value) for value in rz]
    assert lives[1] <= lives[0] * KEEP


@COMMON
@given(STRENGTH, AMPLITUDE, pair(0.5, 600.0))
def test_a_larger_part_never_lives_longer_by_marin(strength, amplitude, sizes):
    lives = [marin_life(strength, amplitude, equivalent_diameter=size) for size in sizes]
    assert lives[1] <= lives[0] * KEEP


@COMMON
@given(STRENGTH, AMPLITUDE, pair(-50.0, 537.0))
def test_a_hotter_part_never_lives_longer_by_marin(strength, amplitude, heat):
    lives = [marin_life(strength, amplitude, temperature=celsius) for celsius in heat]
    assert lives[1] <= lives[0] * KEEP


@COMMON
@given(STRENGTH, AMPLITUDE, pair(0.5, 0.999999))
def test_a_more_reliable_part_never_lives_longer(strength, amplitude, survive):
    lives = [marin_life(strength, amplitude, reliability=share) for share in survive]
    assert lives[1] <= lives[0] * KEEP


def beside_an_elliptic_hole(group, strength, amplitude, radius, depth):
    """Life where K_t = 1 + 2 sqrt(a/r) (Inglis) and G = (2 + 1/K_t)/r (from Muskhelishvili)."""
    factor = 1.0 + 2.0 * (depth / radius) ** 0.5
    gradient = (2.0 + 1.0 / factor) / radius
    return fkm_life(group, strength, factor * amplitude, gradient=gradient)


@COMMON
@given(GROUP, STRENGTH, st.floats(0.02, 0.3), pair(0.05, 300.0), st.floats(5.0, 20.0))
def test_a_sharper_notch_never_lengthens_life_by_the_guideline(
    group, strength, amplitude, radii, depth
):
    """Support grows less than K_t in notches from 5 mm deep on, in all groups."""
    blunt, sharp = (
        beside_an_elliptic_hole(group, strength, amplitude, radius, depth)
        for radius in reversed(radii)
    )
    assert sharp <= blunt * KEEP


@COMMON
@given(STRENGTH, st.floats(0.02, 0.3), pair(0.05, 300.0), st.floats(0.2, 5.0))
def test_in_steel_that_holds_for_shallow_notches_too(strength, amplitude, radii, depth):
    blunt, sharp = (
        beside_an_elliptic_hole("steel", strength, amplitude, radius, depth)
        for radius in reversed(radii)
    )
    assert sharp <= blunt * KEEP


@COMMON
@given(GROUP, STRENGTH, AMPLITUDE, pair(-3.0, 6.0))
def test_a_higher_mean_never_lowers_the_utilisation_by_the_guideline(
    group, strength, amplitude, means
):
    limit = component_limit(of_group(group, strength), roughness=10.0)
    size = amplitude * strength
    use = [fkm_utilisation(size, size * mean, limit) for mean in means]
    assert use[0] <= use[1] * KEEP
    factor = [fkm_factor(size, size * mean, limit.sensitivity) for mean in means]
    assert factor[1] <= factor[0] * KEEP


@COMMON
@given(GROUP, STRENGTH, AMPLITUDE, st.floats(0.0, 3.0))
def test_twice_the_load_is_twice_the_utilisation_of_the_guideline(
    group, strength, amplitude, share
):
    limit = component_limit(of_group(group, strength), roughness=10.0)
    size = amplitude * strength
    once = fkm_utilisation(size, share * size, limit)
    assert fkm_utilisation(2 * size, 2 * share * size, limit) == pytest.approx(2 * once, rel=1e-12)
