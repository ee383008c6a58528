"""Reading a design file: units, names and tables become the machine."""

import math
import pickle
import tomllib
from pathlib import Path

import jsonschema
import pytest

from ballesta.design.authoring import design_schema, new_design, templates
from ballesta.design.files import parse_override
from ballesta.design.read import read_design
from checks.design.errors import DesignError
from checks.design.materials import known_materials
from checks.design.units import KNOWN_UNITS, measure, measure_pair, pint_unit
from loads import Distance

from ...small_machine import PLATE, machine

DESIGNS = Path(__file__).parents[3] / "designs"
PRESS = DESIGNS / "toggle_press.toml"
ALL = sorted(DESIGNS.glob("*.toml"))


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("6.3 mm", "length", 6.3),
        ("2 m", "length", 2000.0),
        ("11.31 kN", "force", 11310.0),
        ("4.14134 kg", "mass", 4.14134e-3),
        ("0.0215695 kg m2", "inertia", 21.5695),
        ("0.0215695 kg*m^2", "inertia", 21.5695),
        ("7850 kg/m3", "density", 7.85e-9),
        ("9.81 m/s2", "acceleration", 9810.0),
        ("120 deg", "angle", 2 * math.pi / 3),
        ("20 1/min", "rate", 1 / 3),
        ("5 %", "fraction", 0.05),
        ("210 GPa", "stress", 210e3),
    ],
)
def test_quantities_arrive_in_newton_millimetre_second_tonne(text, dimension, value):
    """Conversions are products of a few factors: 8 eps."""
    assert measure(text, dimension).value == pytest.approx(value, rel=8 * 2.2e-16)


def test_the_unit_of_a_point_serves_both_numbers_or_each_has_its_own():
    assert measure_pair("200, 150 mm", "length") == (200.0, 150.0)
    assert measure_pair("0.2 m, 150 mm", "length") == pytest.approx((200.0, 150.0))


def test_the_toggle_press_is_read_whole():
    """Brief 4.2 to 4.5: 250 mm between the pins, 2.2 million cycles a year, 40 mm pin."""
    design = read_design(PRESS)
    assert design.pins == {
        "C": ("ground", "lower"),
        "B": ("lower", "upper"),
        "A": ("upper", "mould"),
    }
    assert design.parts["bar_lower"].geometry.length == pytest.approx(250.0)
    assert design.parts["bar_lower"].geometry.wall == 6.3
    assert design.parts["pin_B"].geometry.length == pytest.approx(2 * (42.95 + 3.15 + 5))
    assert design.forces["cylinder"].coordinate == Distance("ground", "D", "lower", "B")
    assert design.duty.cycles == {"press": 1.1e7}
    assert design.gravity == pytest.approx((0.0, -9810.0))
    assert [phase.solve for phase in design.cycles["press"].run.phases] == [
        "cylinder",
        "process",
        "cylinder",
    ]
    assert pickle.loads(pickle.dumps(design)) == design


def test_points_are_told_in_the_frame_of_their_body():
    design = read_design(PRESS)
    assert design.bodies["upper"].points["A"] == pytest.approx((250.0, 0.0), abs=1e-12 * 250)
    x, y, angle = design.assembled["upper"]
    assert (x, y) == (200.0, 150.0)
    assert angle == pytest.approx(math.atan2(150, -200))


def test_what_the_file_does_not_state_and_what_it_assumes_is_listed():
    design = read_design(PRESS)
    assert ("gravity", "0, -9810 mm/s2") in design.defaults_used
    assert ("parts.pin_B.bearing_arc", "90 deg") in design.defaults_used
    assert "parts.bar_upper.bearing_arc" not in dict(design.defaults_used)
    assert {"cycles.press.stop", "parts.bar_upper.hole"} <= set(dict(design.assumed))


@pytest.mark.parametrize(
    ("bore", "fit", "clearances"),
    [("knee", "H7/f7", (0.025, 0.075)), ("end", "0.02 .. 0.06 mm", (0.02, 0.06))],
)
def test_a_fit_becomes_the_clearances_of_its_bore(bore, fit, clearances):
    """One bore of the press' bar; the other has H7/f7 in the file."""
    design = read_design(PRESS, [f"parts.bar_upper.fits.{bore}={fit}"])
    both = {"knee": (0.025, 0.075), "end": (0.025, 0.075), bore: clearances}
    assert design.parts["bar_upper"].clearances == both
    assert design.parts["bar_lower"].clearances == design.parts["bar_upper"].clearances
    assert design.parts["pin_B"].clearances == {}


def test_a_fit_is_of_the_pin_and_not_of_the_hole_of_its_bush():
    """H7/f7 above 50 mm leaves 30 to 90 um; the pin of 40 mm has a bush in the knee alone."""
    design = read_design(PRESS, ["parts.bar_upper.hole=51 mm", "parts.bar_upper.overhang=50 mm"])
    assert design.parts["bar_upper"].clearances == {"knee": (0.025, 0.075), "end": (0.03, 0.09)}


def test_an_override_reaches_the_parts_that_are_like_the_changed_one():
    design = read_design(
        PRESS, ["parts.bar_upper.wall=5mm", "friction.pins={coefficient=0.1, diameter='40 mm'}"]
    )
    assert design.parts["bar_lower"].geometry.wall == 5.0
    assert design.friction["B"].radius == 20.0
    assert read_design(PRESS).parts["bar_lower"].geometry.wall == 6.3


def test_an_override_inside_an_inherited_table_keeps_the_rest_of_that_table():
    design = read_design(PRESS, ["parts.bar_lower.column.in_plane=300 mm"])
    assert design.parts["bar_lower"].column.out_of_plane == 500.0
    assert design.parts["bar_lower"].column.in_plane == 300.0
    assert design.parts["bar_upper"].column.in_plane is None


def test_the_value_of_an_override_is_toml_where_it_parses_and_text_elsewhere():
    assert parse_override('ground=["C"]').value == ["C"]
    assert parse_override("a.b[1].c=0.1 m/s").path == ("a", "b", 1, "c")
    assert parse_override("a=5 %").value == "5 %"


def test_the_document_tube_and_its_mistaken_twin_differ_in_width_only():
    sized = read_design(DESIGNS / "toggle_press_as_sized.toml").parts["bar_upper"].geometry
    twin = read_design(DESIGNS / "toggle_press_30x30.toml").parts["bar_upper"].geometry
    assert (sized.width, twin.width) == (13.0, 30.0)
    assert sized.wall == twin.wall == 1.6


@pytest.fixture(scope="module")
def by_schema():
    schema = design_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("file", ALL, ids=lambda file: file.stem)
def test_every_design_follows_the_schema_and_a_bare_number_does_not(file, by_schema):
    data = tomllib.loads(file.read_text())
    assert [error.message for error in by_schema.iter_errors(data)] == []
    data.setdefault("parts", {}).setdefault("bar_upper", {})["wall"] = 6.3
    assert not by_schema.is_valid(data)


def test_the_schema_describes_the_parameters_as_the_shapes_do():
    wall = design_schema()["$defs"]["ToggleBarPart"]["properties"]["wall"]
    assert wall["description"] == "wall thickness"
    assert wall["type"] == "string"
    assert "length" not in design_schema()["$defs"]["ToggleBarPart"]["properties"]


def test_a_template_is_a_design_that_reads_and_the_press_is_the_one_in_designs(tmp_path):
    for name in templates():
        (tmp_path / f"{name}.toml").write_text(new_design(name))
        read_design(tmp_path / f"{name}.toml")
    assert new_design("toggle_press") == PRESS.read_text()
    with pytest.raises(DesignError, match=r"'togle-press', did you mean toggle-press\?"):
        new_design("togle_press")


def test_known_materials_say_where_their_values_come_from():
    assert {"S275", "S355", "C45", "42CrMo4"} <= set(known_materials())
    assert all("EN " in material.source for material in known_materials().values())
    assert known_materials()["42CrMo4"].ultimate_stress == 900.0


@pytest.mark.parametrize("name", KNOWN_UNITS)
def test_the_units_of_most_designs_are_those_that_pint_knows(name):
    assert KNOWN_UNITS[name] == pint_unit(name)


def test_units_beside_the_table_are_read_by_pint():
    assert measure("1 psi", "stress").value == pytest.approx(6.894757293168e-3, rel=1e-12)
    assert measure("2 lbf", "force").value == pytest.approx(2 * 4.4482216152605, rel=1e-12)


def test_an_offset_that_no_file_states_may_be_set(tmp_path):
    """Of a part that states none at all: the table is begun."""
    design = machine(tmp_path, PLATE, "parts.rod.offsets.second=-4.3 mm")
    assert design.parts["rod"].offsets["second"] == pytest.approx(-4.3)


def test_a_pin_may_hold_a_cylinders_eye_in_one_body(tmp_path):
    """Rear pivot of the press's cylinder: the frame alone has it, so no joint is there."""
    pin = """
[parts.pin_D]
like = "pin_B"
joint = "D"
fixed_to = "ground"
stack = [
  { body = "ground", at = "30 mm", width = "10 mm" },
  { force = "cylinder", at = "0 mm", width = "43 mm" },
]
"""
    file = tmp_path / "press.toml"
    file.write_text(PRESS.read_text() + pin)
    design = read_design(file)
    assert design.parts["pin_D"].interfaces == {"ground": "D", "cylinder": "D"}
    assert "D" not in design.pins
    file.write_text(PRESS.read_text() + pin.replace('"cylinder", at', '"process", at'))
    with pytest.raises(DesignError, match="no force at point D is named 'process'"):
        read_design(file)
