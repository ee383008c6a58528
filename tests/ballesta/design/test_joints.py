"""Slots, guides and welds, torques and drives in a design file: what is read, what is refused."""

# ruff: noqa: E501 - one refusal a line: the change of the file, then the wording

import math
import re
from pathlib import Path

import pytest

import loads
from ballesta.commands.plan import plan_text
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import linkage_of
from ballesta.pipeline import _assumed_here
from checks.design.errors import DesignError, DesignErrors

DESIGNS = Path(__file__).parents[3] / "designs"
LEVER = (DESIGNS / "quick_return.toml").read_text()
PRESS = (DESIGNS / "toggle_press.toml").read_text()
AVAILABLE = '{ bore = "160 mm", rod = "40 mm", pressure = "0.6 MPa" }'


def read(tmp_path, *changes, text=LEVER, overrides=()):
    """Read a design with pieces of its text exchanged."""
    for old, new in changes:
        assert text.count(old) >= 1, old
        text = text.replace(old, new, 1)
    file = tmp_path / "machine.toml"
    file.write_text(text)
    return read_design(file, overrides)


def test_a_guide_between_two_bodies_has_its_line_in_the_frame_of_the_one(tmp_path):
    slide = read(tmp_path).slides["slot"]
    assert isinstance(slide, loads.Prismatic)
    assert (slide.body_a, slide.body_b, slide.point_b) == ("lever", "block", "a")
    assert slide.direction == pytest.approx((1.0, 0.0), abs=1e-15)
    assert slide.ends == (28.0, 192.0)
    askew = read(tmp_path, ('along = "B"', 'along = "0.6, 0.8"')).slides["slot"]
    assert askew.direction == pytest.approx((0.6, 0.8))


def test_a_point_that_slides_needs_no_other_use(tmp_path):
    """D of the hammer's ram is on no other body; the rocker's slot is what holds it."""
    design = read_design(DESIGNS / "spring_hammer.toml")
    assert "D" not in design.pins
    assert design.slides["slot"].point_b == "D"


def test_the_plan_names_every_joint_and_that_nothing_is_checked(tmp_path):
    whole = (DESIGNS / "quick_return.toml").read_text()
    plain = tmp_path / "plain.toml"
    plain.write_text(whole[: whole.index("[duty]")])
    text = plan_text(plain)
    assert "slot: guide of block at a on lever, through O1 along 1, 0, from 28 to 192 mm" in text
    assert "guide of hammer" in text
    assert "no parts to check" in text
    turned = plan_text(DESIGNS / "gallery" / "shaper.toml")  # its lever's frame, by 90°
    assert "block at P on lever, through O along 1, 0, from 110 to 290 mm" in turned


WELD = 'pins = ["O2", "a"]\nmass = "0.110 kg"\ninertia = "9.0e-5 kg m2"\ncentre = "35, 0 mm"\n'
DISC = '[bodies.disc]\npins = ["O2"]\nmass = "1 kg"\ninertia = "0.01 kg m2"\ncentre = "0, 0 mm"\n'
FIXED = '[joints.key]\nkind = "fixed"\nbodies = ["crank", "disc"]\npoint = "O2"\n'


def test_a_disc_welded_to_the_crank_turns_with_it_and_loads_the_pin(tmp_path):
    """The disc's centre is on the axis and the crank runs evenly: its weight goes to the pin O2."""
    plain = read(tmp_path)
    disc = read(tmp_path, ("[joints.slot]", DISC + FIXED + "[joints.slot]"))
    assert disc.pins["O2"] == ("ground", "crank", "disc")
    linkage = linkage_of(disc, {})
    assert [type(joint).__name__ for joint in linkage.joints if "disc" in joint.body_b] == ["Fixed"]
    results = [
        loads.run_cycle(linkage_of(design, {}), design.cycles["at_4"].run)
        for design in (plain, disc)
    ]
    pins = [results[0].reactions["O2"], results[1].reactions["O2:crank"]]
    difference = pins[1].force.mean(axis=0) - pins[0].force.mean(axis=0)
    assert difference == pytest.approx([0.0, 9.81], abs=1e-6)


def test_a_weld_of_two_bodies_takes_the_place_of_their_pin(tmp_path):
    text = LEVER.replace('ground = ["O1", "O2"]', 'ground = ["O1", "O2", "F"]')
    text = text.replace('O2 = "110', 'F = "110, -50 mm"\nO2 = "110', 1)
    design = read(
        tmp_path,
        ("[joints.slot]", '[bodies.foot]\npins = ["F"]\nmass = "1 kg"\ninertia = "0 kg m2"\ncentre = "0, 0 mm"\n'
         '[joints.bolts]\nkind = "fixed"\nbodies = ["ground", "foot"]\npoint = "F"\n[joints.slot]'),
        text=text,
    )  # fmt: skip
    assert "F" not in design.pins
    assert design.joints["bolts"] == (loads.Fixed("bolts", "ground", "foot", "F"),)
    assert loads.run_cycle(linkage_of(design, {}), design.cycles["at_4"].run)


def test_a_torque_is_stated_in_newton_metres_and_may_brace_against_a_body(tmp_path):
    design = read(
        tmp_path, ('turns = "crank"\nat = "O2"', 'turns = "crank"\nagainst = "lever"\navailable = "50 N m"')
    )  # fmt: skip
    assert design.forces["drive"] == loads.Force("drive", loads.Angle("crank", "lever"))
    assert design.available["drive"] == (50e3, 50e3)


def test_a_cylinder_pushes_with_its_piston_and_pulls_with_the_ring_around_its_rod(tmp_path):
    """Brief 4.3: bore 160, rod 40, 0.6 MPa: 12 064 N extending, 11 310 N retracting."""
    for table in (
        '{ bore = "160 mm", rod = "40 mm", pressure = "6 bar" }',
        '{ push = "12.0637 kN", pull = "11.3097 kN" }',
    ):
        design = read(tmp_path, (AVAILABLE, table), text=PRESS)
        pull, push = design.available["cylinder"]
        assert pull == pytest.approx(11310, abs=0.5)
        assert push == pytest.approx(12064, abs=0.5)
    one = read(tmp_path, (AVAILABLE, '"11.31 kN"'), text=PRESS)
    assert one.available["cylinder"] == (11310.0, 11310.0)
    assert pull == pytest.approx(0.6 * math.pi / 4 * (160**2 - 40**2), rel=1e-5)


SLOT = "[joints.slot]"
REFUSED = {
    "unknown kind": (('kind = "guide"', 'kind = "slider"'), r"joints\.slot\.kind: must be 'slot', 'guide' or 'fixed', got \"slider\""),
    "unknown key": (('through = "O1"', 'trough = "O1"'), r"joints\.slot\.trough: unknown key, did you mean through\?"),
    "unknown body": (('on = "lever"', 'on = "levr"'), r"joints\.slot\.on: no body is named 'levr', did you mean lever\? There are ground, lever"),
    "sliding ground": (('body = "block"\npoint', 'body = "ground"\npoint'), r"joints\.slot\.body: the ground does not slide"),
    "on itself": (('body = "block"\npoint = "a"', 'body = "lever"\npoint = "B"'), r"joints\.slot\.body: lever cannot slide on itself"),
    "unknown point": (('through = "O1"', 'through = "O3"'), r"joints\.slot\.through: no point is named 'O3'; there are O1, O2, a, B, C"),
    "point of another body": (('through = "O1"', 'through = "O2"'), r"joints\.slot\.through: no point of body lever is named 'O2'; there are O1, B; `pins` lists them"),
    "not of the slider": (('point = "a"', 'point = "C"'), r"joints\.slot\.point: no point of body block is named 'C'; there are a"),
    "along itself": (('along = "B"', 'along = "O1"'), r"joints\.slot\.along: O1 is where O1 is"),
    "along with a unit": (('along = "B"', 'along = "1, 0 mm"'), r"joints\.slot\.along: must be such as \"0, 1\", got \"1, 0 mm\"; a direction has no unit; or the name of a second point of lever"),
    "nothing along": (('along = "B"\n', ""), r"joints\.slot\.along: must be stated for kind = \"guide\": a second point"),
    "falling ends": (('["28 mm", "192 mm"]', '["192 mm", "28 mm"]'), r"joints\.slot\.ends: must rise, got 192 mm and then 28 mm"),
    "one end": (('["28 mm", "192 mm"]', '["192 mm"]'), r"joints\.slot\.ends: must be at least 2 long"),
    "ends in degrees": (('["28 mm", "192 mm"]', '["28 deg", "192 mm"]'), r"joints\.slot\.ends\[0\]: must be a length .*, which is an angle"),
    "bodies of a guide": (('ends = [', 'bodies = ["lever", "block"]\nends = ['), r"joints\.slot\.bodies: is not used with kind = \"guide\"; leave it out"),
    "weld without bodies": ((SLOT, '[joints.key]\nkind = "fixed"\npoint = "B"\n' + SLOT), r"joints\.key\.bodies: must be stated for kind = \"fixed\": the two bodies"),
    "weld apart": ((SLOT, '[joints.key]\nkind = "fixed"\nbodies = ["lever", "crank"]\npoint = "B"\n' + SLOT), r"joints\.key\.point: no point of body crank is named 'B'"),
    "name of a pin": ((SLOT, "[joints.a]"), r"joints\.a: the pin joint at point a already has this name"),
    "two kinds of force": (('turns = "crank"', 'turns = "crank"\nbetween = ["O2", "a"]'), r"forces\.drive: needs one of .*; it has between and turns"),
    "no kind of force": (('turns = "crank"\nat = "O2"', ""), r"forces\.drive: needs one of between = \[point, point\], body with at and direction, or turns"),
    "turns nothing": (('turns = "crank"', 'turns = "crnk"'), r"forces\.drive\.turns: no body is named 'crnk', did you mean crank\?"),
    "against itself": (('turns = "crank"', 'turns = "crank"\nagainst = "crank"'), r"forces\.drive\.against: crank cannot be turned against itself"),
    "direction of a torque": (('turns = "crank"', 'turns = "crank"\ndirection = "0, 1"'), r"forces\.drive\.direction: is only used for a force on a body, this is a torque; leave it out"),
    "torque elsewhere": (('turns = "crank"\nat = "O2"', 'turns = "crank"\nat = "B"'), r"forces\.drive\.at: no point of body crank is named 'B'"),
    "newton for a torque": (('turns = "crank"', 'turns = "crank"\navailable = "50 N"'), r"forces\.drive\.available: must be a moment such as \"12 N m\", this is a torque; got a force"),
    "cylinder of a torque": (('turns = "crank"', 'turns = "crank"\navailable = { push = "1 N", pull = "2 N" }'), r"forces\.drive\.available: a table is for a force between two points"),
    "unit of a drive": (('turns = "crank"', 'turns = "crank"\navailable = "50 kg"'), r"forces\.drive\.available: must be a force such as \"11 kN\" or a moment such as \"12 N m\", got \"50 kg\", which is a mass"),
    "friction of no joint": ((SLOT, '[friction.joints]\nslt = { coefficient = 0.1 }\n' + SLOT), r"friction\.joints\.slt: no joint is named 'slt', did you mean slot\?"),
    "diameter of a guide": ((SLOT, '[friction.joints]\nslot = { coefficient = 0.1, diameter = "8 mm" }\n' + SLOT), r"friction\.joints\.slot\.diameter: is not used, slot is a guide; leave it out"),
    "pin without diameter": ((SLOT, '[friction.joints]\nB = { coefficient = 0.1 }\n' + SLOT), r"friction\.joints\.B\.diameter: must be stated: B is a pin joint"),
    "friction of no slot": ((SLOT, '[friction]\nslots = { coefficient = 0.1 }\n' + SLOT), r"friction\.slots: no joint is a slot; slot is a guide, guide:hammer is a guide; leave it out"),
    "irregularity": ((SLOT, '[drive]\nirregularity = 0\n' + SLOT), r"drive\.irregularity: must be above 0, got 0"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_joint_or_torque_that_cannot_be_meant_is_refused_at_its_key(case, tmp_path):
    change, message = REFUSED[case]
    with pytest.raises(DesignError) as caught:
        read(tmp_path, change)
    assert any(re.search(message, line) for line in str(caught.value).splitlines()), str(
        caught.value
    )


CYLINDERS = {
    "half": ('{ bore = "160 mm", rod = "40 mm" }', r"available\.pressure: must be stated: pressure of the fluid"),
    "thick rod": ('{ bore = "40 mm", rod = "40 mm", pressure = "6 bar" }', r"available\.rod: must be below the bore of 40 mm, got 40 mm"),
    "one way": ('{ push = "1 kN" }', r"available\.pull: must be stated beside the other direction"),
    "mixed": ('{ push = "1 kN", bore = "40 mm" }', r"available: needs either push and pull, or bore, rod and pressure; it has push, bore"),
    "nothing": ("{}", r"available: needs either push and pull, or bore, rod and pressure; it has none"),
    "misspelt": ('{ boar = "160 mm" }', r"forces\.cylinder\.available\.boar: unknown key, did you mean bore\?"),
    "negative": ('"-11 kN"', r"forces\.cylinder\.available: must be above 0 kN, got \"-11 kN\""),
}  # fmt: skip


@pytest.mark.parametrize("case", CYLINDERS)
def test_a_drive_that_cannot_be_meant_is_refused_at_its_key(case, tmp_path):
    table, message = CYLINDERS[case]
    with pytest.raises(DesignError, match=message):
        read(tmp_path, (AVAILABLE, table), text=PRESS)


def test_friction_may_be_stated_for_slots_by_name_and_for_one_cycle(tmp_path):
    design = read(
        tmp_path,
        ("[joints.slot]", '[friction]\nguides = { coefficient = 0.1 }\njoints.slot = { coefficient = 0.12 }\n[joints.slot]'),
        ("[cycles.at_10]\n", '[cycles.at_10]\nfriction = { pins = { coefficient = 0.05, diameter = "8 mm" } }\n'),
    )  # fmt: skip
    assert {name: f.coefficient for name, f in design.friction.items()} == {
        "slot": 0.12,
        "guide:hammer": 0.1,
    }
    own = linkage_of(design, {}, design.cycles["at_10"]).friction
    assert set(own) == {"O1", "O2", "a", "B", "C"}
    assert set(linkage_of(design, {}, design.cycles["at_4"]).friction) == {"slot", "guide:hammer"}


def test_several_wrong_joints_are_told_at_once(tmp_path):
    with pytest.raises(DesignErrors) as caught:
        read(
            tmp_path,
            ('on = "lever"', 'on = "levr"'),
            ('turns = "crank"', 'turns = "crnk"'),
            ('["28 mm", "192 mm"]', '["192 mm", "28 mm"]'),
            ('speed = "10 rad/s"', 'speed = "10 mm/s"'),
        )
    assert {error.key for error in caught.value.errors} == {
        "joints.slot.on",
        "forces.drive.turns",
        "joints.slot.ends",
        "cycles.at_10.pace.speed",
    }


def test_a_design_without_cycles_is_refused(tmp_path):
    text = LEVER[: LEVER.index("[cycles.at_4]")]
    with pytest.raises(DesignError, match=r"cycles: must be stated: what the machine does"):
        read(tmp_path, text=text)


@pytest.mark.parametrize("bearer", ["", "coupler", "rocker", "toggle"])
def test_three_bodies_on_a_pin_rub_on_the_one_that_it_turns_with(tmp_path, bearer):
    """Without a part that is the pin, on the first of the file, which is told as assumed."""
    text = (DESIGNS / "gallery" / "riveting_press.toml").read_text()
    pin = f"""[parts.pin_B]
joint = "B"
shape = "pin"
fixed_to = "{bearer}"
material = "42CrMo4"
diameter = "40 mm"
stack = [
  {{ body = "coupler", at = "0 mm", width = "20 mm" }},
  {{ body = "rocker", at = "30 mm", width = "30 mm" }},
  {{ body = "toggle", at = "65 mm", width = "30 mm" }},
]
"""
    rubs = '[friction.pins]\ncoefficient = 0.1\ndiameter = "30 mm"\n'
    change = ("[assumed]", rubs + (pin if bearer else "") + "[assumed]")
    design = read(tmp_path, ('hole = "30 mm"', 'hole = "40 mm"'), change, text=text)
    joints = design.joints["B"]
    assert [joint.body_a for joint in joints] == [bearer or "coupler"] * 2
    assert {joint.body_b for joint in joints} == {"coupler", "rocker", "toggle"} - {
        joints[0].body_a
    }
    told = [words for key, words in _assumed_here(design) if key == "friction of B"]
    assert [words[:48] for words in told] == [
        "3 bodies on one pin, which turns with coupler, t"
    ] * (not bearer)


def test_the_body_that_takes_a_force_at_a_shared_point_is_assumed_where_no_on_names_it(tmp_path):
    """B of the press is on both bars; by the order of the file its pin has another force."""
    assert not [key for key, _ in read(tmp_path, text=PRESS).assumed if key.endswith(".on")]
    silent = read(tmp_path, ('on = "lower"', ""), text=PRESS)
    (words,) = [words for key, words in silent.assumed if key == "forces.cylinder.on"]
    assert words.startswith("lower takes its force at B, as the first of lower, upper in the file")
