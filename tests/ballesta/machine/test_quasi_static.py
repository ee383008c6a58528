"""The gate on whether a machine's loads may ignore vibration, and what a user reads of it."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from ballesta.machine.quasi_static import (
    assumptions_of,
    quasi_static_gates,
    vibration_of,
    vibration_warnings,
    with_dynamics,
    with_sections,
)
from ballesta.machine.solved_cycles import solve_cycles
from checks.design.errors import DesignError
from loads import BeamCompliance

from ...small_machine import machine, solved

DESIGNS = Path(__file__).parents[3] / "designs"
SLOTTED = """
[parts.rod]
body = "rod"
shape = "tube_rod"
interfaces = { first = "A", second = "B" }
material = "S275"
tube_diameter = "20 mm"
wall = "2.5 mm"
eye_diameter = "28.5 mm"
eye_width = "21 mm"
hole = "16 mm"
fillet = "6 mm"
"""


def hammer(*cycles, overrides=()):
    design = read_design(DESIGNS / "spring_hammer.toml", overrides)
    return replace(design, cycles={name: design.cycles[name] for name in cycles})


def gates(design):
    found = vibration_of(design, solve_cycles(design, {}))
    return {gate.name.split(":")[0]: gate for gate in quasi_static_gates(design, found)}, found


def test_the_hammer_is_quasi_static_at_3_rad_s_told_at_6_and_refused_at_10():
    """5.0 to 5.6 Hz: harmonics 3 and 4 of 10 rad/s stand on both sides of the resonance."""
    design = hammer("at_3", "at_6", "at_10")
    found, known = gates(design)
    assert found["at_3"].meaning.startswith("valid.")
    assert found["at_6"].meaning.startswith("amplification 1.08.")
    assert found["at_10"].meaning.startswith("not valid.")
    assert [found[name].holds for name in design.cycles] == [True, True, False]
    assert found["at_10"].binding
    # the other modes add 5e-5 to the sum of share x deviation
    assert_allclose(found["at_10"].value, 1.0 + known["at_10"].worst.deviation, atol=1e-3)
    assert "of the mode that differs most" in found["at_10"].meaning
    numbers = known["at_10"].frequencies[:, 0]
    assert 5.0 < numbers.min() < numbers.max() < 5.6
    assert len(numbers) == 12


def test_more_damping_brings_the_hammer_nearer_to_quasi_static():
    loose = gates(hammer("at_10"))[0]["at_10"].value
    damped = gates(hammer("at_10", overrides=["dynamics={damping=0.1}"]))[0]["at_10"].value
    assert 1.2 < damped < loose - 0.1


def test_the_default_damping_is_told_and_must_be_above_zero():
    assert ("dynamics.damping", "0.02") in hammer("at_3").defaults_used
    with pytest.raises(DesignError, match=r"dynamics\.damping: must be above 0"):
        hammer("at_3", overrides=["dynamics={damping=0}"])


def test_a_contact_is_told_to_be_a_load_and_no_support():
    found, _ = gates(hammer("at_5_work_10"))
    assert "The contact counts as a load, not as a support." in found["at_5_work_10"].meaning
    assert not found["at_5_work_10"].holds


def test_a_mode_that_deforms_next_to_nothing_does_not_count():
    """The leaf's second mode differs by more than the gate lets pass, and carries 1 %."""
    _, known = gates(hammer("at_10_work_10"))
    first, *others = known["at_10_work_10"].response.responses
    assert known["at_10_work_10"].telling == (first,)
    assert max(mode.deviation for mode in others) > 0.2
    assert max(mode.share for mode in others) < 0.02


def test_bodies_with_a_part_give_way_by_its_section_and_the_others_are_named_rigid(tmp_path):
    design = machine(tmp_path)
    cycles = solved(design)
    elastic, sections, rigid = with_sections(design, cycles["turn"])
    rod = next(c for c in elastic.linkage.compliance if c.body == "rod")
    young = design.parts["rod"].material.youngs_modulus
    assert_allclose((rod.bending, rod.axial), (young * 8 * 30**3 / 12, young * 8 * 30))
    assert sections == (("rod", "plate"),)
    assert rigid == ("crank", "slider")
    told = dict(assumptions_of(design, vibration_of(design, cycles)))
    assert told["bodies.rod.elastic"].startswith("its part's section all along it (plate)")
    assert told["dynamics"] == "rigid in vibration: crank, slider"


def test_of_several_sections_the_least_is_taken():
    """The press's bars: between their two cheeks 80 x 6.3 mm, and the tube."""
    design = read_design(DESIGNS / "toggle_press.toml")
    design = replace(design, cycles={"capacity": design.cycles["capacity"]})
    elastic, sections, rigid = with_sections(design, solve_cycles(design, {})["capacity"])
    bar = elastic.linkage.compliance[0]
    assert_allclose((bar.bending, bar.axial), (210e3 * 6.3 * 80**3 / 6, 210e3 * 2 * 80 * 6.3))
    assert sections == (("lower", "cheeks"), ("upper", "cheeks"))
    assert rigid == ("mould",)


def test_vibration_keeps_a_rod_in_equilibrium_whose_centre_is_not_its_origin(tmp_path):
    asking = ("dynamics={apply=true}", 'cycles.turn.pace.speed="400 rad/s"')
    design = machine(tmp_path, SLOTTED, *asking)
    cycles = solved(design)
    after = with_dynamics(design, cycles, vibration_of(design, cycles))["turn"]
    change = np.abs(after.reactions["B"].force - cycles["turn"].reactions["B"].force).max()
    assert change > 0.01 * np.abs(cycles["turn"].reactions["B"].force).max()
    assert max(after.equilibrium_residual.values()) < 1e-12


def test_stated_elasticity_stays(tmp_path):
    design = machine(tmp_path, SLOTTED, 'bodies.rod.elastic={bending="5 N m2"}')
    elastic, sections, _ = with_sections(design, solved(design)["turn"])
    assert elastic.linkage.compliance == (BeamCompliance("rod", bending=5e6),)
    assert sections == ()


def test_a_slider_crank_shakes_its_rod_as_a_beam_between_pins(tmp_path):
    """Half a wave, with the mass and inertia that the design states for it.

    An even bar with these is sqrt(12 I / m) = 173 mm long and sits 80 mm along the 161 mm rod.
    """
    design = machine(tmp_path, SLOTTED)
    found = vibration_of(design, solved(design))["turn"]
    young, length = design.parts["rod"].material.youngs_modulus, np.hypot(144.0, 72.0)
    inertia = np.pi * (20.0**4 - 15.0**4) / 64
    even = np.pi / 2 * np.sqrt(young * inertia / (2e-4 / np.sqrt(12 * 0.5 / 2e-4) * length**4))
    assert_allclose(found.frequencies[:, 0], even, rtol=2e-2)


def test_a_linkage_without_anything_elastic_has_no_gate(tmp_path):
    design = machine(tmp_path, "")
    found = vibration_of(design, solved(design))
    assert found == {}
    assert quasi_static_gates(design, found) == []


def test_a_cycle_that_does_not_come_back_is_told_to_be_unasked(tmp_path):
    design = machine(tmp_path, SLOTTED, 'cycles.turn.phases[0].to="300 deg"')
    found = vibration_of(design, solved(design))
    assert quasi_static_gates(design, found) == []
    assert "not asked" in dict(assumptions_of(design, found))["cycles.turn"]
    assert np.isfinite(found["turn"].frequencies[:, 0]).all()


def test_vibration_is_put_on_the_loads_only_where_the_design_asks_for_it():
    design = hammer("at_10", "at_10_work_10")
    cycles = solve_cycles(design, {})
    found = vibration_of(design, cycles)
    assert with_dynamics(design, cycles, found) == cycles
    asking = replace(design, dynamics=design.dynamics.model_copy(update={"apply": True}))
    after = with_dynamics(asking, cycles, found)
    assert after["at_10_work_10"] is cycles["at_10_work_10"]
    told = dict(assumptions_of(asking, found))
    assert "not put on its loads" in told["cycles.at_10_work_10"]
    pushes = [np.hypot(*c["at_10"].reactions["R"].force.T).max() for c in (cycles, after)]
    assert pushes[1] > 1.3 * pushes[0]
    assert vibration_warnings(design, cycles, found) == []
    on, off = vibration_warnings(asking, cycles, found)
    assert on.startswith("at_10: vibration is on its loads")
    assert off.startswith("at_10_work_10: vibration is NOT on its loads")
    free, followed, touching = quasi_static_gates(asking, found)
    assert not free.binding
    assert followed.binding
    assert followed.holds
    assert "What it adds is in the loads." in free.meaning
    assert touching.binding


def test_vibration_that_is_lost_between_the_positions_is_no_load():
    """Of the hammer's 5.6 Hz at 10 rad/s 3.5 waves are in a turn; 13 positions have three each.

    Straight between positions dt apart a wave keeps cos(pi f dt) of its size.
    """

    def scene(positions):
        overrides = ("dynamics={apply=true}", f"cycles.at_10.positions={positions}")
        design = hammer("at_10", overrides=overrides)
        return design, solve_cycles(design, {})

    def gate(positions):
        design, cycles = scene(positions)
        gates = quasi_static_gates(design, vibration_of(design, cycles))
        return next(one for one in gates if "between the" in one.name)

    few = gate(13)
    found = vibration_of(*scene(13))["at_10"]
    worst, step = found.worst, found.response.step
    kept = np.cos(np.pi * worst.highest * step)
    assert few.value == pytest.approx(worst.share * worst.deviation * (1.0 - kept), rel=1e-3)
    assert few.binding
    assert not few.holds
    wanted = int(re.search(r"cycles\.at_10\.positions = (\d+) or more", few.cure)[1])
    assert gate(wanted).holds
    assert not gate(wanted // 2).holds

    def way_out(positions):
        design = hammer("at_10", overrides=(f"cycles.at_10.positions={positions}",))
        (gate,) = quasi_static_gates(design, vibration_of(design, solve_cycles(design, {})))
        assert not gate.holds
        return gate.cure, gate.key

    apply = "dynamics.apply=true"
    assert way_out(wanted) == (f"Put what it adds on the loads ({apply})", apply)
    also = f"Put what it adds on the loads ({apply} with cycles.at_10.positions={wanted})"
    assert way_out(13) == (also, "")


def test_a_load_that_jumps_is_told_and_overshoots_where_its_rise_is_stated(tmp_path):
    """From 400 N to 4 kN at once in the middle of the turn, on a rod of about 500 Hz."""
    jump = [
        'cycles.turn.phases=[{ name = "a", to = "200 deg", forces = { push = "400 N" }, '
        'solve = "drive" }, { name = "b", to = "450 deg", forces = { push = "4 kN" }, '
        'solve = "drive" }]'
    ]
    gate, found = gates(machine(tmp_path, SLOTTED, *jump))
    assert found["turn"].worst.jump > 0.5
    # 4/f of about 500 Hz: far below 5 % of the cycle of 0.63 s
    assert found["turn"].worst.rise == pytest.approx(4.0 / found["turn"].worst.lowest)
    assert "a single sudden jump adds up to as much again" in gate["turn"].meaning
    assert gate["turn"].value < 1.1
    sudden, _ = gates(machine(tmp_path, SLOTTED, *jump, 'dynamics={rise="1e-6 s"}'))
    assert sudden["turn"].value > 1.4


def test_a_load_for_half_of_every_turn_is_not_valid_without_a_stated_rise(tmp_path):
    """The hammer at 5 rad/s: four periods of its 5 Hz are most of the turn of 1.26 s."""
    text = (DESIGNS / "spring_hammer.toml").read_text(encoding="utf-8").split("[cycles.at_3]")[0]
    turn = '{ name = "turn", to = "360 deg", forces = { workpiece = "0 N" }, solve = "drive" }'
    assert turn in text
    up = turn.replace('"turn", to = "360', '"up", to = "180').replace("0 N", "3000 N")
    path = tmp_path / "hammer.toml"
    path.write_text(text.replace(turn, f"{up}, {turn}") + "[duty]\ncycles = { at_5 = 1e7 }\n")
    values = [
        gates(read_design(path, rise))[0]["at_5"].value
        for rise in ((), ('dynamics.rise="1e-3 s"',))
    ]
    assert values[0] > 3.0
    assert values[1] == pytest.approx(values[0], rel=0.2)


def test_a_mode_of_little_share_in_resonance_counts_by_its_share():
    """3 % of the deformation, 25 times as large: 0.75 of all the deformation there is."""
    design = hammer("at_3")
    known = vibration_of(design, solve_cycles(design, {}))["at_3"]
    first, second, *_ = known.response.responses
    pair = (
        replace(first, share=1.0, deviation=0.0),
        replace(second, share=0.03, deviation=25.0),
    )
    known = replace(known, response=replace(known.response, responses=pair))
    assert known.telling == pair[:1]
    assert known.worst is pair[1]
    (gate,) = quasi_static_gates(design, {"at_3": known})
    assert gate.value == pytest.approx(1.75)
    assert gate.meaning.startswith("not valid. 1 + sum over all modes")
    assert "most of it by mode 2, share 0.03, difference 25" in gate.meaning
    alone = replace(known, response=replace(known.response, responses=pair[1:]))
    assert quasi_static_gates(design, {"at_3": alone})[0].value == pytest.approx(1.75)


def test_modes_that_cannot_be_followed_leave_the_cycle_unasked_and_the_check_goes_on():
    """Quick return with 181 positions; with those of the design every mode comes back."""
    design = read_design(DESIGNS / "quick_return.toml", ["cycles.at_10.positions=181"])
    design = replace(design, cycles={"at_10": design.cycles["at_10"]})
    cycles = solve_cycles(design, {})
    found = vibration_of(design, cycles)
    assert quasi_static_gates(design, found) == []
    told = dict(assumptions_of(design, found))["cycles.at_10"]
    assert told.startswith("quasi-static: not asked, mode ")
    assert told.endswith("comes back as another one after the cycle 'at_10'; its response has no "
                         "harmonics; more positions may help")  # fmt: skip
    asking = replace(design, dynamics=design.dynamics.model_copy(update={"apply": True}))
    assert with_dynamics(asking, cycles, found)["at_10"] is cycles["at_10"]
    told = dict(assumptions_of(asking, found))["cycles.at_10"]
    assert told.endswith("vibration is not put on its loads")


def test_a_mode_that_is_lost_beside_a_far_softer_one_leaves_the_cycle_unasked(recwarn):
    """A hammer of 8e8 t: an infinite frequency went into its response as a number."""
    overrides = ["bodies.hammer.mass=8e11 kg", "cycles.at_4.positions=73"]
    design = read_design(DESIGNS / "quick_return.toml", overrides)
    design = replace(design, cycles={"at_4": design.cycles["at_4"]})
    found = vibration_of(design, solve_cycles(design, {}))
    told = dict(assumptions_of(design, found))["cycles.at_4"]
    assert "is too stiff beside the softest one to be followed through the cycle 'at_4'" in told
    assert not recwarn


def test_the_damping_of_a_design_without_dynamics_can_be_set():
    assert hammer("at_3", overrides=["dynamics.damping=0.05"]).dynamics.damping == 0.05
