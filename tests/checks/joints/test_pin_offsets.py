"""Plates side by side: pins' stacks against the offsets of the parts, and what cannot be meant."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ballesta.commands.plan import plan
from ballesta.machine.warnings_of import design_warnings
from checks.design.errors import DesignError
from checks.joints import pin_offsets
from checks.joints.pin_offsets import offset_gates
from checks.part.part_loads import check_reach, loads_on
from geometry.mesh import Interface, TooManyElementsError
from geometry.parts import Pin, Seat

from ...small_machine import PLATE, machine, solved
from .test_slot_checks import MESH, lever

CRANK = (
    PLATE.replace("[parts.rod]", "[parts.crank]")
    .replace('"rod"', '"crank"')
    .replace('first = "A", second = "B"', 'first = "O", second = "A"')
)
PIN = """
[parts.pin_A]
joint = "A"
shape = "pin"
fixed_to = "crank"
material = "S275"
diameter = "12 mm"
stack = [
  { body = "crank", at = "0 mm", width = "8 mm", single = true },
  { body = "rod", at = "10.5 mm", width = "8 mm", single = true },
]
"""


def gates(folder, *overrides):
    design = machine(folder, PLATE + CRANK + PIN, *overrides)
    runs = solved(design)
    return {
        part: {gate.name: gate for gate in offset_gates(design, design.parts[part], runs)}
        for part in ("crank", "rod", "pin_A")
    }


def test_a_forgotten_offset_breaks_a_gate_that_tells_the_right_one(tmp_path):
    found = gates(tmp_path)
    gate = found["crank"]["crank: lever arm of pin_A left out, mm"]
    assert gate.binding
    assert not gate.holds
    assert gate.value == pytest.approx(10.5)
    assert 'state offsets = { second = "10.5 mm" }' in gate.meaning
    (rod,) = found["rod"].values()
    assert rod.value == 0
    assert not found["pin_A"]


def three_lugs(arms, forces, offset):
    """What is left out of a plate in which a pin is fixed that carries two lugs at some heights.

    forces  (2, n, 2) of the two on the pin, N
    """
    seats = [Seat("plate", at=0.0, width=8.0, single=True)]
    seats += [Seat(f"lug{k}", at=at, width=8.0, single=True) for k, at in enumerate(arms)]
    pin = SimpleNamespace(geometry=Pin(seats=tuple(seats), diameter=12.0), fixed_to="plate")
    wrenches = {f"lug{k}": np.pad(each, ((0, 0), (0, 4))) for k, each in enumerate(forces)}
    return pin_offsets._missing_arm(pin, "plate", offset, wrenches)


def test_a_couple_that_keeps_step_with_its_force_has_an_offset_for_three_lugs():
    """Forces 3 and 1 at 10 and 22 mm are 4 at 13 mm."""
    turning = np.array([[300.0, 0.0], [0.0, -600.0], [200.0, 100.0]])
    forces = np.array([turning, turning / 3])
    arm, couple, wanted = three_lugs((10.0, 22.0), forces, 0.0)
    assert wanted == pytest.approx(13.0)
    assert couple == pytest.approx(13.0 * 800.0)
    assert arm == pytest.approx(13.0 * 800.0 / 600.0)
    assert three_lugs((10.0, 22.0), forces, wanted)[0] == pytest.approx(0.0, abs=1e-12)


def test_a_couple_that_does_not_is_told_by_what_the_best_offset_leaves():
    """One lug presses, then the other, as hard: 16 mm is the best, and 6 mm of 500 N is left."""
    forces = np.array([[[500.0, 0.0], [0.0, 0.0]], [[0.0, 0.0], [500.0, 0.0]]])
    _, _, wanted = three_lugs((10.0, 22.0), forces, 0.0)
    assert wanted == pytest.approx(16.0)
    assert three_lugs((10.0, 22.0), forces, wanted)[:2] == pytest.approx((6.0, 3000.0))


def test_what_is_left_out_is_told_as_stress(tmp_path):
    """M = 10.5 mm times the largest force; 6 M / (w t^2) in the plate."""
    (gate,) = gates(tmp_path)["crank"].values()
    couple, stress, width, thickness = map(
        float,
        re.search(
            r"have: (\S+) N mm, (\S+) MPa of bending in its plate of (\S+) x (\S+) mm", gate.meaning
        ).groups(),
    )
    assert stress == pytest.approx(6 * couple / (width * thickness**2), rel=5e-3)


def offsets(crank, rod):
    return f'parts.crank.offsets={{second="{crank}"}}', f'parts.rod.offsets={{first="{rod}"}}'


def test_offsets_as_the_stack_has_them_leave_no_arm_out(tmp_path):
    found = gates(tmp_path, *offsets("10.5 mm", "0 mm"))
    values = [next(iter(found[part].values())).value for part in ("crank", "rod")]
    assert values == pytest.approx((0, 0), abs=1e-9)


@pytest.mark.parametrize(
    ("crank", "rod", "key", "said"),
    [
        ("-3 mm", "0 mm", "crank.offsets.second", "is -3 mm, but by parts.pin_A.stack .* 10.5 mm"),
        ("0 mm", "0 mm", "crank.offsets.second", "is 0 mm, but by parts.pin_A.stack .* 10.5 mm"),
        ("10.5 mm", "4 mm", "rod.offsets.first", "is 4 mm, but .* 0 mm .* as pin_A turns in rod"),
    ],
)
def test_an_offset_that_the_stack_contradicts_is_refused_with_both(tmp_path, crank, rod, key, said):
    """It only broke a gate: 62.8 to 118.8 MPa in a crank, with gates that are broken anyway."""
    with pytest.raises(DesignError, match=said) as caught:
        gates(tmp_path, *offsets(crank, rod))
    assert caught.value.key == f"parts.{key}"


@pytest.mark.parametrize(
    ("override", "key", "said"),
    [
        ('parts.pin_A.diameter="7 mm"', "pin_A.diameter", r"has 7 mm where parts.crank .* 12 mm"),
        ('parts.crank.second_hole="16 mm"', "pin_A.diameter", r"16 mm .*parts.crank.second_hole"),
        ('parts.rod.hole="11.9 mm"', "pin_A.diameter", r"12 mm cannot pass rod, .* 11.9 mm"),
    ],
)
def test_a_pin_that_does_not_fit_its_hole_is_refused_with_both(tmp_path, override, key, said):
    with pytest.raises(DesignError, match=said) as caught:
        gates(tmp_path, override, *offsets("10.5 mm", "0 mm"))
    assert caught.value.key == f"parts.{key}"


def test_a_bush_stands_between_a_pin_and_a_wider_hole(tmp_path):
    bush = 'bush={length="8 mm",allowable="140 MPa"}'
    stack = (
        'parts.pin_A.stack=[{body="crank",at="0 mm",width="8 mm",single=true},'
        f'{{body="rod",at="10.5 mm",width="8 mm",single=true,{bush}}}]'
    )
    assert gates(tmp_path, stack, 'parts.rod.hole="16 mm"', *offsets("10.5 mm", "0 mm"))


def test_the_hole_at_a_pin_is_the_second_one_where_it_sits_there(tmp_path):
    """The first is the shaft's, 20 mm."""
    holes = 'parts.crank.hole="20 mm"', 'parts.crank.second_hole="12 mm"'
    assert gates(tmp_path, *holes, *offsets("10.5 mm", "0 mm"))


def test_a_fork_has_no_arm(tmp_path):
    stack = (
        'parts.pin_A.stack=[{body="crank",at="0 mm",width="8 mm"},'
        '{body="rod",at="10 mm",width="8 mm"}]'
    )
    (gate,) = gates(tmp_path, stack)["crank"].values()
    assert gate.value == 0


def test_an_offset_in_the_wrong_unit_is_told(tmp_path):
    design = machine(tmp_path, PLATE, 'parts.rod.offsets={second="5 m"}')
    warnings = design_warnings(design, {}, solved(design))
    assert any("417 times its hole of 12 mm" in warning for warning in warnings)
    near = machine(tmp_path, PLATE, 'parts.rod.offsets={second="10 mm"}')
    assert not any("times its hole" in text for text in design_warnings(near, {}, solved(near)))


def test_a_roller_wider_than_its_slot_is_refused(tmp_path):
    with pytest.raises(DesignError) as caught:
        lever(tmp_path, 'contacts = { slot = { radius = "7 mm" } }')
    assert caught.value.key == "parts.lever.contacts.slot.radius"
    assert "at most 6 mm; is 7 mm its diameter?" in str(caught.value)
    lever(tmp_path, 'contacts = { slot = { radius = "6 mm" } }')


def test_a_contact_that_leaves_its_stretch_is_refused_with_both(tmp_path):
    design = lever(tmp_path)
    part = design.parts["lever"]
    loads = loads_on(design, part, solved(design))
    reach = loads.reaches["slot"]
    low, high = float(reach.min()), float(reach.max())

    def with_travel(*travel):
        slide = replace(MESH.interfaces["slot"], travel=travel, centre=np.array([3.0, 0, 0]))
        return {"slot": slide}

    check_reach(design, part, loads, with_travel(low, high))
    for travel in ((low + 0.1, high), (low, high - 0.1)):
        with pytest.raises(DesignError) as caught:
            check_reach(design, part, loads, with_travel(*travel))
        assert caught.value.key == "parts.lever.interfaces.slot"
        assert f"slides from x = {low + 3:.4g} to {high + 3:.4g} mm" in caught.value.problem
        assert "travel_from, travel_to" in caught.value.problem
    assert isinstance(MESH.interfaces["slot"], Interface)


def test_a_first_mesh_larger_than_allowed_is_refused(tmp_path):
    with pytest.raises((DesignError, TooManyElementsError), match=r"most_unknowns is 100, but"):
        plan(machine(tmp_path, PLATE, "parts.rod.mesh.most_unknowns=100"))
