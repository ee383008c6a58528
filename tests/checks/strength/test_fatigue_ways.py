"""Three ways to judge a part's fatigue from a design file: Goodman, a finite life, FKM."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.design.errors import DesignError
from checks.ladder.levels import first_level
from checks.ladder.solid import check_solid
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import loads_on
from checks.strength.part_strength import fatigue_use
from checks.stress.solid_mesh_level import Models

from ...small_machine import PLATE, machine, solved

COARSE = PLATE.replace("fineness = 0.5", "fineness = 0.3")
HEAVY = 'cycles.turn.phases[0].forces.push="45000 N"'
PULL = """
[cycles.pull]
like = "turn"
phases = [{ name = "round", to = "450 deg", forces = { push = "-400 N" }, solve = "drive" }]
"""


@pytest.fixture(scope="module")
def models():
    """One mesh and factor for all."""
    return Models()


def checked(folder, models, *overrides, text=COARSE):
    """The rod's result and its fatigue check, on coarse meshes."""
    design = machine(folder, text, 'accuracy="50 %"', *overrides)
    part = design.parts["rod"]
    result = check_solid(LoadedPart(design, part, loads_on(design, part, solved(design))), models)
    (check,) = (check for check in result.checks if check.kind == "fatigue")
    (gate,) = (gate for gate in result.gates if gate.name == "rod: fatigue safety")
    assert gate.value < 1e-9
    assert gate.holds
    return result, check


def test_goodman_is_the_verdict_on_the_stresses_of_the_facts(tmp_path, models):
    result, check = checked(tmp_path, models)
    assert check.quantity == "Goodman amplitude of equal safety"
    facts = result.facts
    amplitude, mean = facts["fatigue amplitude [MPa]"], facts["fatigue mean stress [MPa]"]
    limit = facts["endurance limit [MPa]"]
    assert_allclose(check.safety, 1 / (amplitude / limit + mean / 410), rtol=1e-9)
    assert facts["stress path at the critical point"].startswith(("proportional", "not propor"))
    assert result.charts["haigh"]["amplitude"] == amplitude


def test_a_finite_life_allows_more_than_the_endurance_limit_and_less_with_more_runs(
    tmp_path, models
):
    finite = 'duty.life="finite"'
    _, endless = checked(tmp_path, models, HEAVY)
    result, few = checked(tmp_path, models, HEAVY, finite, "duty.cycles.turn=1e4")
    _, many = checked(tmp_path, models, HEAVY, finite, "duty.cycles.turn=1e5")
    _, most = checked(tmp_path, models, HEAVY, finite, "duty.cycles.turn=1e12")
    assert endless.safety < 1
    assert few.quantity == "Miner amplitude of equal safety"
    assert few.safety > 1.04 * many.safety > 1.04**2 * endless.safety
    assert_allclose(most.safety, endless.safety, rtol=0.02)
    assert few.cycle == "the whole duty"
    damage = result.charts["sn"]["damage"]
    assert few.basis.split("Miner's sum ")[1].split(" of")[0] == (
        "inf" if damage is None else f"{damage:.3g}"
    )


def test_what_is_used_up_already_leaves_less(tmp_path, models):
    finite = ('duty.life="finite"', "duty.cycles.turn=1e4", HEAVY)
    _, new = checked(tmp_path, models, *finite)
    _, used = checked(tmp_path, models, *finite, "duty.damage_so_far=0.29")
    assert used.safety < 0.95 * new.safety


def test_the_fkm_chain_tells_nothing_of_marins(tmp_path, models):
    result, check = checked(tmp_path, models, 'parts.rod.strength="fkm"')
    facts = result.facts
    assert check.quantity == "FKM amplitude of equal safety"
    assert "Marin" not in check.basis + check.note + " ".join(facts)
    factor = float(facts["FKM mean stress factor"].split()[1].rstrip(","))
    strength = facts["FKM component strength, fully reversed [MPa]"]
    safety = factor * strength / facts["fatigue amplitude [MPa]"]
    assert_allclose(check.safety, safety, rtol=1e-3)
    assert "haigh" not in result.charts  # it has Goodman's line


def test_a_pull_and_a_push_in_two_cycles_of_a_duty_are_one_range(tmp_path, models):
    text = PULL + COARSE
    _, alone = checked(tmp_path, models, text=text)
    _, both = checked(tmp_path, models, "duty.cycles.pull=10", text=text)
    assert alone.cycle == "turn"
    assert both.cycle == "between cycles"
    assert both.position.startswith("turn ")
    assert " to pull " in both.position
    assert both.value > 1.3 * alone.value


@pytest.mark.parametrize(
    ("overrides", "key"),
    [
        (('parts.rod.strength="fkm"', 'duty.life="finite"'), r"parts\.rod\.strength"),
        (
            ("duty.damage_so_far=0.3", 'duty.life="finite"'),
            r"duty\.damage_so_far: 0\.3 leaves nothing",
        ),
        (("duty.damage_so_far=0.1",), r"duty\.damage_so_far: is of a finite life only"),
        (("duty.allowed_damage=0",), r"duty\.allowed_damage"),
        (('duty.life="endless"',), r"duty\.life: must be 'infinite' or 'finite'"),
    ],
)
def test_a_duty_that_cannot_be_judged_is_refused_at_the_door(tmp_path, overrides, key):
    with pytest.raises(DesignError, match=key):
        machine(tmp_path, PLATE, *overrides)


def test_points_of_a_finite_life_are_judged_by_their_own_lives(tmp_path, models):
    """Error bars set other points beside the worst one: for endless life it has 1.13 of it."""
    design = machine(tmp_path, COARSE, 'duty.life="finite"', "duty.cycles.turn=1e4", HEAVY)
    part = design.parts["rod"]
    loaded = LoadedPart(design, part, loads_on(design, part, solved(design)))
    use, level = fatigue_use(loaded), first_level(loaded, models)
    every = np.arange(len(level.history.points))
    worst, some = np.array([use.point(level)]), np.argsort(-use.bound(level, every))[:40]
    assert_allclose(use.at(level, worst), use.value(level), rtol=1e-9)
    assert use.at(level, some).max() <= use.value(level) * (1 + 1e-9)
    assert (use.bound(level, some) >= use.at(level, some)).all()
    assert level.judged_duty.utilisation_at(worst)[0] * use.limit > 1.1 * use.value(level)
