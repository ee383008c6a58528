"""Screws of a cap: opening, yield and fatigue against a textbook and hand; refusals in words."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

from ballesta.pipeline import check_file
from checks import by_formula
from checks.by_formula import bolts
from checks.design.effort import Effort
from checks.design.errors import DesignError
from checks.part.loaded_part import LoadedPart
from checks.result.verdict import Status

from ...small_machine import PLATE, loads_of, machine

# Bhandari, Design of Machine Elements, example 7.20: bolts of a big end, stroke 100 mm, rod 200 mm,
# 5 kg at 2000 rpm, preload that opens at 3000 rpm, parts 4 times as stiff as bolts; data, steps and
# result as FOSSEE/Scilab-TBC-Uploads has them, 764/CH7/EX7.20
SPEED = 2000 * 2 * pi / 60
INERTIA = 5 * 0.05 * SPEED**2 * (1 + 50 / 200)
PRELOAD = 1.5**2 * INERTIA / 2 * 4 / 5
ENGINE = f"""
name = "Engine"
ground = ["O"]
gravity = "0, 0 m/s2"
[points]
O = "0, 0 mm"
A = "50, 0 mm"
B = "250, 0 mm"
[bodies.crank]
pins = ["O", "A"]
mass = "1e-6 kg"
inertia = "1e-9 kg m2"
centre = "0, 0 mm"
[bodies.rod]
pins = ["A", "B"]
mass = "1e-6 kg"
inertia = "1e-9 kg m2"
centre = "100, 0 mm"
[bodies.slider]
pins = ["B"]
mass = "5 kg"
guide = {{ along = "1, 0" }}
[forces.drive]
turns = "crank"
at = "O"
[cycles.turn]
coordinate = "crank.angle"
start = "0 deg"
pace = {{ coordinate = "crank.angle", speed = "{SPEED!r} rad/s" }}
positions = 25
phases = [{{ name = "round", to = "360 deg", solve = "drive" }}]
[duty]
cycles = {{ turn = 1e6 }}
[parts.rod]
body = "rod"
shape = "plate_link"
interfaces = {{ first = "A", second = "B" }}
material = "S355"
width = "30 mm"
thickness = "8 mm"
hole = "12 mm"
bolts = [{{ at = "first", opens = "-1, 0", count = 2, size = "M10", property_class = "8.8", \
largest_preload = "{PRELOAD!r} N", thread_friction = 0, tightening_factor = 1, settling = "0 N", \
joint_constant = 0.2, pushed_beside = true }}]
"""
STATED = {
    "at": '"first"', "opens": '"-1, 0"', "count": "2", "size": '"M12"', "property_class": '"8.8"',
    "largest_preload": '"41.9 kN"', "thread_friction": "0.14", "tightening_factor": "1.8",
    "settling": '"0 N"', "joint_constant": "0.25",
}  # fmt: skip
TORQUE = {"largest_preload": None, "torque": '"95 N m"', "head_friction": "0.14",
          "head_diameter": '"15.75 mm"'}  # fmt: skip
AREA = pi / 4 * (12 - 0.938194 * 1.75) ** 2  # 84.27 mm2


def table(**changes):
    stated = {key: value for key, value in (STATED | changes).items() if value is not None}
    return "{ " + ", ".join(f"{key} = {value}" for key, value in stated.items()) + " }"


def capped(folder, *overrides, more="", **changes):
    return machine(folder, PLATE + f"bolts = [{table(**changes)}{more}]\n", *overrides)


def pulled(design, forces):
    """Checks, by the first word, under forces that pull the rod at its ends, N."""
    rows = {"first": [(-f, 0, 0) for f in forces], "second": [(f, 0, 0) for f in forces]}
    found = bolts.checks(LoadedPart(design, design.parts["rod"], loads_of(rows)))
    return {check.quantity.split()[0]: check for check in found}


def test_the_bolts_of_a_big_end_are_those_of_a_printed_example(tmp_path):
    """To 7 digits: the area that its Goodman line asks for from the forces that are found here."""
    file = tmp_path / "engine.toml"
    file.write_text(ENGINE)
    result = check_file(file, effort=Effort("formula"))
    (rod,) = result.parts
    checks = {one.quantity.split()[0]: one for one in rod.checks if one.kind == "bolts"}
    opening, fatigue = checks["opening"], checks["fatigue"]
    assert opening.value == pytest.approx(INERTIA / 2, rel=1e-6)
    assert opening.safety == pytest.approx(1.5**2, rel=1e-6)
    assert opening.position == "crank.angle = 0 deg round"
    values = fatigue.derivation.values
    least, largest = values["F_S_1"], values["F_S_2"]
    slope = (1 + 600 / (600 / 2 * 0.897 / 3)) * 2
    area = ((largest - least) / 2 + least / slope) / (600 / slope)
    assert area == pytest.approx(38.128117, abs=2e-5)
    # by hand: 1371 N on M10, 57.99 mm2, are 23.64 MPa; 0.7368 * 50 MPa endures without end
    assert fatigue.safety == pytest.approx(36.84 / 23.64, rel=1e-3)
    assert fatigue.required == 1.35
    # (640 * 57.99 - 12337)/0.2 is more than the 37 113 N that yield with the joint open
    assert checks["yield"].limit == pytest.approx(640 * 57.99, rel=1e-4)
    assert "welds, screws that no part states, circlips and other fasteners" in result.not_checked
    assert any("screws as pulled along themselves" in one for one in rod.assumed)


def test_screws_that_no_part_states_are_told_as_not_checked(tmp_path):
    file = tmp_path / "engine.toml"
    file.write_text(ENGINE[: ENGINE.index("bolts =")])
    told = check_file(file, effort=Effort("formula")).not_checked
    assert "welds, screws, circlips and other fasteners" in told


def test_both_ends_of_a_preload_are_as_printed(tmp_path):
    """Bossard's example of VDI 2230's tables: 41.9 kN at 90 % of yield, 23.3 kN over 1.8."""
    values = pulled(capped(tmp_path), [0.0, 1e3])["opening"].derivation.values
    assert values["F_0"] == pytest.approx(23.3e3, abs=50)
    equivalent = values["F_1"] * sqrt(1 + 3 * values["k"] ** 2) / values["A_s"]
    assert equivalent / 640 == pytest.approx(0.9, rel=2e-3)
    assert values["A_s"] == pytest.approx(84.3, abs=0.05)


def test_a_torque_makes_the_preload_by_hand(tmp_path):
    """0.28 + 0.8821 + 1.1025 mm: 95 N m over 2.2646 mm."""
    values = pulled(capped(tmp_path, **TORQUE), [0.0, 1e3])["opening"].derivation.values
    assert values["F_1"] == pytest.approx(95e3 / 2.2646, rel=1e-4)


def test_the_safety_is_on_the_force_and_the_preload_at_its_worse_end(tmp_path):
    """Least preload 41 900/1.8 - 3278 = 20 000 N; 12 kN with 1.5 on two screws are 9 kN each."""
    design = capped(tmp_path, settling='"3277.7777778 N"', prying="1.5")
    found = pulled(design, [0.0, 12e3])
    assert found["opening"].value == pytest.approx(9e3)
    assert found["opening"].limit == pytest.approx(20e3 / 0.75)
    k = 1.5 * 10.8633 / 10.3582 * (1.75 / (pi * 10.8633) + 1.155 * 0.14)
    holds = sqrt((640 * AREA) ** 2 - 3 * (k * 41.9e3) ** 2)
    assert found["yield"].limit == pytest.approx((holds - 41.9e3) / 0.25, rel=1e-3)
    assert found["fatigue"].derivation.values["S"] == pytest.approx(0.25 * 9e3 / AREA, rel=1e-5)


def test_a_joint_that_opens_leaves_all_of_the_force_to_the_screw(tmp_path):
    """27 kN per screw open 23 278/0.75 = 31 037 N not, 40 kN do: 40 000 - 23 278 N of range."""
    design = capped(tmp_path)
    shut = pulled(design, [0.0, 54e3])["fatigue"].derivation.values["S"]
    assert shut == pytest.approx(0.25 * 27e3 / AREA, rel=1e-5)
    found = pulled(design, [0.0, 80e3])
    assert found["fatigue"].derivation.values["S"] == pytest.approx(16722 / AREA, rel=1e-4)
    assert found["opening"].safety < 1


@pytest.mark.parametrize(("beside", "range_of_force"), [("false", 0.25 * 6e3), ("true", 1e3)])
def test_a_push_takes_tension_off_the_screws_unless_it_goes_beside_the_joint(
    tmp_path, beside, range_of_force
):
    found = pulled(capped(tmp_path, pushed_beside=beside), [8e3, -4e3])
    swing = found["fatigue"].derivation.values["S"]
    assert swing == pytest.approx(range_of_force / AREA, rel=1e-5)
    assert found["opening"].value == pytest.approx(4e3)


def test_a_steady_force_has_no_fatigue(tmp_path):
    assert pulled(capped(tmp_path), [5e3, 5e3]).keys() == {"opening", "yield"}


def test_a_finite_life_is_by_miner(tmp_path):
    """1e6 ranges of 50 MPa are half of the 2e6 that the category endures."""
    design = capped(tmp_path, "duty.life=finite")
    force = 2 * 60.0 * AREA / 0.25  # 60 MPa
    check = pulled(design, [0.0, force])["fatigue"]
    assert check.safety == pytest.approx(50 / 60, rel=1e-6)
    assert check.derivation.values["D"] == pytest.approx(0.5, rel=1e-6)


def test_other_directions_open_by_their_component(tmp_path):
    design = capped(tmp_path, opens='"-3, 4"')
    rows = {"first": [(-2e3, 1e3, 0.0), (0, 0, 0)], "second": [(2e3, -1e3, 0.0), (0, 0, 0)]}
    found = next(bolts.checks(LoadedPart(design, design.parts["rod"], loads_of(rows))))
    assert found.value == pytest.approx((2e3 * 0.6 + 1e3 * 0.8) / 2)


@pytest.mark.parametrize("couple", [0.0, 1e5])
def test_a_couple_that_screws_bear_by_their_distances_is_told(tmp_path, couple):
    """500 N on an arm of 200 mm; as a force alone the two screws have 250 N each."""
    design = capped(tmp_path, opens='"0, 1"')
    rows = {"first": [(0, 500, couple)], "second": [(0, -500, 0)]}
    loaded = LoadedPart(design, design.parts["rod"], loads_of(rows))
    (opening, *_), without = bolts.checks(loaded), Status.UNDECIDED if couple else Status.PASS
    assert opening.value == pytest.approx(250)
    assert opening.status is without
    assert ("no prying is stated" in opening.note) == bool(couple)
    pushed = {name: [*own, (0, -1e6 if name == "first" else 1e6, 0)] for name, own in rows.items()}
    later = next(bolts.checks(replace(loaded, loads=loads_of(pushed))))
    assert later.status is without  # a push at another time makes no friction at this one
    stated = [entry.model_copy(update={"prying": 3.0}) for entry in loaded.part.bolts]
    pried = replace(loaded, part=replace(loaded.part, bolts=tuple(stated)))
    assert next(bolts.checks(pried)).status is Status.PASS
    told = [text for text in bolts.not_checked(loaded) if "NOT CHECKED" in text]
    assert len(told) == bool(couple)
    assert all("a couple of up to 100 N m at first" in text for text in told)


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"at": '"cap"'}, "at", "no interface with a pin is named"),
        ({"size": '"M5"'}, "size", "M6"),
        ({"property_class": '"4.6"'}, "property_class", "8.8"),
        ({"joint_constant": "1.0"}, "joint_constant", "below 1"),
        ({"tightening_factor": "0.9"}, "tightening_factor", "at least 1"),
        ({"largest_preload": None}, "torque", "needs either torque or largest_preload"),
        ({"torque": '"9 N m"'}, "torque", "needs either torque or largest_preload"),
        ({"head_friction": "0.1"}, "head_friction", "is of a torque; leave it out"),
        (TORQUE | {"head_friction": None}, "head_friction", "must be stated"),
        (TORQUE | {"head_diameter": None}, "head_diameter", "must be stated"),
        (TORQUE | {"thread_friction": "0"}, "thread_friction", "a torque needs its friction"),
    ],
)
def test_a_refusal_says_how_to_mend_it(tmp_path, changes, key, words):
    with pytest.raises(DesignError) as error:
        capped(tmp_path, **changes)
    assert f"bolts[0].{key}" in str(error.value)
    assert words in str(error.value)


def test_screws_twice_at_one_interface_are_refused(tmp_path):
    with pytest.raises(DesignError, match="other screws stand at first"):
        capped(tmp_path, more=", " + table())


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"largest_preload": '"48 kN"'}, "largest_preload", "makes M12 8.8 yield as it is tight"),
        (TORQUE | {"torque": '"110 N m"'}, "torque", "makes M12 8.8 yield as it is tightened"),
        ({"settling": '"24 kN"'}, "settling", "leaves nothing"),
    ],
)
def test_a_preload_that_cannot_be_is_refused(tmp_path, changes, key, words):
    with pytest.raises(DesignError, match=words) as error:
        pulled(capped(tmp_path, **changes), [0.0, 1e3])
    assert f"parts.rod.bolts[0].{key}" in str(error.value)


def test_earlier_use_that_leaves_nothing_is_refused(tmp_path):
    design = capped(tmp_path, "duty.life=finite", "duty.damage_so_far=0.5", "duty.allowed_damage=1")
    with pytest.raises(DesignError, match="leaves a screw nothing"):
        pulled(design, [0.0, 1e4])


def test_the_check_registers_by_being_there():
    assert bolts in by_formula.registered()
    assert np.isclose(AREA, 84.27, atol=0.01)
