"""Validity checks of loads: what a bore lacks of the force of its pin."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import solve_cycles
from ballesta.machine.validity_checks import endless_gates, load_gates
from loads import MeasuredBody, MeasuredLoad, MeasuredLoads

from ...small_machine import PLATE, machine, solved

SLIDER = """
[parts.slider]
body = "slider"
shape = "plate_link"
interfaces = { first = "B", second = "T" }
material = "S275"
width = "30 mm"
thickness = "8 mm"
hole = "12 mm"
"""
PIN = """
[parts.pin]
joint = "B"
shape = "pin"
fixed_to = "slider"
material = "C45"
diameter = "12 mm"
stack = [
  { body = "rod", at = "0 mm", width = "8 mm" },
  { body = "slider", at = "10 mm", width = "4 mm" },
  { force = "push", at = "20 mm", width = "4 mm" },
]
"""
QUICK_RETURN = Path(__file__).parents[3] / "designs" / "quick_return.toml"
ADDED = ("points.T=244, -12 mm", 'bodies.slider.pins=["B", "T"]', "bodies.slider.centre=50, 0 mm")


def gates(folder, text, *overrides):
    design = machine(folder, text, *ADDED, *overrides)
    found = load_gates(design, solved(design))
    return [gate for gate in found if gate.name == "turn: pin in first of slider"]


def test_a_force_at_a_pin_does_not_unload_the_pins_bore(tmp_path):
    """Rod and push meet at B: 400 N in the bore of the slider, of which the sum left 40 N."""
    (gate,) = gates(tmp_path, SLIDER)
    assert gate.binding
    assert gate.value > 0.85
    assert "force 'push'" in gate.cure


def test_a_guide_takes_what_stands_across_it(tmp_path):
    """The rod of 161 mm stands up to 72 mm aslant: cos 26.6 deg of its force are left."""
    (gate,) = gates(tmp_path, SLIDER, "forces.push.at=T")
    assert gate.value == pytest.approx(1 - math.cos(math.asin(72 / 161)), abs=0.01)
    assert "joint 'guide:slider'" in gate.cure
    assert "push" not in gate.cure


def test_a_force_by_an_eye_on_the_pin_comes_through_it(tmp_path):
    (gate,) = gates(tmp_path, SLIDER + PIN)
    assert "push" not in gate.cure


def test_a_bore_without_a_pin_has_all_that_acts_there(tmp_path):
    text = SLIDER.replace('first = "B", second = "T"', 'first = "T", second = "B"')
    design = machine(tmp_path, text, *ADDED, "forces.push.at=T")
    names = [gate.name for gate in load_gates(design, solved(design)) if "pin in" in gate.name]
    assert names == ["turn: pin in second of slider"]


def test_a_slots_face_is_no_bore(tmp_path):
    """The lever's slot stands at its pivot's point in the linkage, and presses on its own faces."""
    design = read_design(QUICK_RETURN, ["cycles.at_10_loaded.positions=37"])
    name = "at_10_loaded"
    design = replace(design, cycles={name: design.cycles[name]})
    found = load_gates(design, solve_cycles(design, {}))
    values = {gate.name: gate.value for gate in found if "pin in" in gate.name}
    assert values == {f"{name}: pin in first of crank": 0.0}


def test_aluminium_has_no_life_without_end(tmp_path):
    """Safety of a rod in 1e12 runs: 0.95 by a finite life, 1.49 by an endless one."""
    aluminium = PLATE.replace('"S275"', '"6082-T6"')

    def gates(text, *overrides):
        design = machine(tmp_path, text, *overrides)
        return list(endless_gates(design, solved(design)))

    assert not gates(aluminium, "duty.cycles.turn=5e8")
    (gate,) = gates(aluminium, "duty.cycles.turn=1e9")
    assert gate.binding
    assert gate.value == 2.0
    assert not gates(aluminium, "duty.cycles.turn=1e9", gate.key)
    assert not gates(PLATE, "duty.cycles.turn=1e12")


@pytest.mark.parametrize("couples", [False, True])
def test_a_measured_run_of_many_cycles_counts_all_of_them(tmp_path, couples):
    """100 pulls or couples in a run, and as many ripples of a fifth: 1e7 runs are 1e9 cycles."""
    design = machine(tmp_path, PLATE.replace('"S275"', '"6082-T6"'), "duty.cycles.turn=1e7")
    pull = np.tile([0.0, 1e3, 800.0, 1e3], 100)
    zeros = np.zeros(len(pull))
    ends = [
        MeasuredLoad(point, zeros[:, None] * [1, 1], sign * 100 * pull)
        if couples
        else MeasuredLoad(point, sign * np.column_stack([pull, zeros]), zeros)
        for point, sign in (("A", -1), ("B", 1))
    ]
    rod = MeasuredBody(
        design.bodies["rod"], tuple(ends), zeros, np.zeros((len(pull), 2)), zeros, zeros
    )
    run = MeasuredLoads("turn", np.arange(len(pull)) * 1.0, None, {"rod": rod})
    (gate,) = endless_gates(design, {"turn": run})
    assert gate.value == 2.0


def test_a_body_that_turns_under_a_steady_force_has_a_cycle_a_turn(tmp_path):
    """100 turns in a run, 1e7 runs: 1e9 cycles of bending, of a force that stands still."""
    design = machine(tmp_path, PLATE.replace('"S275"', '"6082-T6"'), "duty.cycles.turn=1e7")
    angle = np.arange(800) * np.pi / 4
    zeros, force = np.zeros(800), np.tile([0.0, 1e3], (800, 1))
    ends = tuple(MeasuredLoad(point, sign * force, zeros) for point, sign in (("A", -1), ("B", 1)))
    rod = MeasuredBody(design.bodies["rod"], ends, angle, 0 * force, zeros, zeros)
    run = MeasuredLoads("turn", angle, None, {"rod": rod})
    (gate,) = endless_gates(design, {"turn": run})
    assert gate.value == pytest.approx(2.0, rel=0.02)
