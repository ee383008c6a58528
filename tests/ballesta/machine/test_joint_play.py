"""Play of pins in a design: a doubt where its fit is stated, an assumption where it is not."""

from pathlib import Path

import numpy as np
import pytest

from ballesta.design.read import read_design
from ballesta.machine.runs import play_pairs, run_machine
from checks.design.errors import DesignError
from checks.result.words import number
from checks.stress.solid_mesh_level import Models

DESIGNS = Path(__file__).parents[3] / "designs"


def solved(file, *overrides):
    machine = run_machine(read_design(DESIGNS / file, overrides), Models(None))
    return machine.design, machine.rigid


def of_rocker(*overrides):
    return solved("gallery/crank_rocker.toml", *overrides)


def test_without_fits_an_assumption_tells_what_the_usual_one_would_add():
    pairs, ((key, reason),) = play_pairs(*of_rocker())
    assert not pairs
    assert key == "parts.fits"
    assert "H7/f7" in reason
    assert "not in the error bars" in reason


@pytest.mark.parametrize("play", [0.08, 0.01])
def test_a_stated_fit_is_a_doubt_of_its_joint_alone(play):
    """The stirrer's torque turns at once: the coupler's pin falls through its play, by hand.

    The contact is 6 mm long; both are of steel.
    """
    (end, most, words), name = reversed_at("first", play), f"play of {play:g} mm in B"
    steel = read_design(DESIGNS / "gallery" / "crank_rocker.toml").parts["coupler"].material
    stiffness = 1.51 * steel.youngs_modulus / (1.0 - steel.poisson_ratio**2) * 6.0
    assert words == f"{name} as its force reverses"
    force = 1250.0  # 100 N m over 80 mm, the coupler square to the rocker; less at the dead centres
    falls = np.sqrt(force**2 + 2.0 * stiffness * play * force)
    assert falls < end < 1.3 * falls
    assert most > force


def test_a_soft_joint_is_hit_less():
    stiff, *_ = reversed_at("first", 0.05)
    soft, *_ = reversed_at("first", 0.05, 'elastic.joints.B="2 kN/mm"')
    assert soft < 0.2 * stiff


def test_a_pin_that_is_cushioned_hits_nothing_and_what_it_would_add_is_told():
    fit = 'parts.coupler.fits.first="0.05 .. 0.05 mm"'
    pairs, told = play_pairs(*of_rocker(fit, 'dynamics.cushioned=["B"]'))
    assert not pairs
    ((_, silent), (key, reason)) = told
    assert "H7/f7 that of A hits" in silent  # its own fit is not stated
    assert key == "dynamics.cushioned"
    added, *_ = reversed_at("first", 0.05)
    assert reason.startswith("stated of B: pins are slowed as they cross their play")
    assert f"that of B hits its bore by up to {number(added)} N on top of" in reason
    with pytest.raises(DesignError, match=r"dynamics\.cushioned: no pin is named 'Q'"):
        of_rocker('dynamics.cushioned=["B", "Q"]')


def reversed_at(bore, play, *more):
    """Largest force that the play of the coupler's bore adds, the joint's without it, and words."""
    design, cycles = of_rocker(f'parts.coupler.fits.{bore}="{play} .. {play} mm"', *more)
    (pair,), _ = play_pairs(design, cycles)
    point = design.parts["coupler"].interfaces[bore]
    without, end = (next(iter(one.values())).reactions[point].force for one in pair.ends)
    return np.hypot(*(end - without).T).max(), np.hypot(*without.T).max(), pair.words


@pytest.mark.parametrize("file", ["toggle_press.toml", "slider_crank.toml"])
def test_a_machine_whose_forces_do_not_reverse_has_no_doubt(file):
    assert play_pairs(*solved(file)) == ([], [])


def test_a_machine_of_measured_loads_alone_has_no_cycle_to_hit_in():
    design = read_design(DESIGNS / "gallery" / "crank_rocker.toml")
    assert play_pairs(design, {}) == ([], [])
