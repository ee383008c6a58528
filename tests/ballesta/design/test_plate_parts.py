"""Levers and drawn plates in a design file: what is read, and what is refused where."""

import tomllib

import jsonschema
import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.authoring import design_schema
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import part_masses, solve_cycles
from checks.design.errors import DesignError
from checks.part.part_loads import loads_on
from checks.stress.solid_mesh_level import Models

from ...geometry.drawn_plates import drawing

# a bell crank: 80 mm from A to its pivot O, 60 mm from O to B, square to it
MACHINE = """
name = "Bell crank"
ground = ["O"]
[points]
O = "0, 0 mm"
A = "-80, 0 mm"
B = "0, 60 mm"
[bodies.crank]
pins = ["A", "O", "B"]
[forces.drive]
body = "crank"
at = "A"
direction = "0, 1"
[forces.work]
body = "crank"
at = "B"
direction = "1, 0"
[cycles.push]
coordinate = "crank.angle"
start = "0 deg"
pace = { coordinate = "crank.angle", speed = "1 rad/s" }
positions = 5
phases = [{ name = "out", to = "10 deg", forces = { work = "4 kN" }, solve = "drive" }]
[duty]
cycles = { push = 1000 }
[parts.crank]
body = "crank"
interfaces = { O = "O", A = "A", B = "B" }
material = "S355"
thickness = "12 mm"
SHAPE
"""
LEVER = """
shape = { lever = ["A", "O", "B"], fillet = "12 mm" }
[parts.crank.holes]
A = { diameter = "12 mm", eye = "30 mm" }
O = { diameter = "20 mm", eye = "46 mm" }
B = { diameter = "12 mm", eye = "30 mm" }
"""
DRAWN = """
shape = { dxf = "crank.dxf" }
[parts.crank.holes]
A = { at = "110, 40 mm" }
O = { diameter = "20 mm" }
B = { at = "190, 100 mm", diameter = "12 mm" }
"""


def machine(folder, shape):
    file = folder / "crank.toml"
    file.write_text(MACHINE.replace("SHAPE", shape))
    return file


def drawn(folder, **how):
    """The machine with a drawing: a rectangle of 130 x 110 mm with the three holes."""
    _, space, saved = drawing(folder / "crank.dxf", **how)
    space.add_lwpolyline([(90, 10), (220, 10), (220, 120), (90, 120)], close=True)
    for x, y, radius in ((110, 40, 6), (190, 40, 10), (190, 100, 6)):
        space.add_circle((x, y), radius)
    saved()
    return machine(folder, DRAWN)


def crank(file):
    return read_design(file).parts["crank"]


def test_a_lever_stands_where_its_points_do(tmp_path):
    part = crank(machine(tmp_path, LEVER))
    plate = part.geometry
    assert part.shape == "lever"
    assert plate.interfaces == ("A", "O", "B")
    assert_allclose([bore.at for bore in plate.bores], [(0, 0), (80, 0), (80, 60)], atol=1e-9)
    assert [bore.diameter for bore in plate.bores] == [12, 20, 12]
    assert plate.stressed_section[1] == 12


def test_the_order_of_keys_makes_no_difference(tmp_path):
    first = crank(machine(tmp_path, LEVER)).geometry
    turned = LEVER.replace('A = { diameter = "12 mm", eye = "30 mm" }\n', "")
    turned += 'A = { eye = "30 mm", diameter = "12 mm" }\n'
    assert crank(machine(tmp_path, turned)).geometry == first


def test_three_pins_are_in_balance_and_have_their_mass(tmp_path):
    design = read_design(machine(tmp_path, LEVER))
    part = design.parts["crank"]
    masses = part_masses(design, Models())
    loads = loads_on(design, part, solve_cycles(design, masses))
    # 4 kN at 60 mm is held by 3 kN at 80 mm, but for the weight of 5 N
    assert_allclose(loads.wrenches["B"][0, :2], [4000, 0], atol=1e-6)
    assert_allclose(abs(loads.wrenches["A"][0, 1]), 3000, rtol=2e-3)
    total = sum(wrench[:, :2] for wrench in loads.wrenches.values())
    assert np.abs(total).max() < 10
    area = part.geometry.outline.moments.area
    assert_allclose(masses["crank"][0], area * 12 * part.material.density, rtol=1e-12)


def test_a_drawing_is_moved_to_where_the_linkage_has_its_holes(tmp_path):
    file = drawn(tmp_path)
    design = read_design(file)
    plate = design.parts["crank"].geometry
    assert design.parts["crank"].shape == "crank.dxf"
    assert_allclose([bore.at for bore in plate.bores], [(0, 0), (80, 0), (80, 60)], atol=1e-9)
    assert_allclose(plate.outline.moments.area, 130 * 110 - np.pi * (36 + 100 + 36), rtol=1e-9)
    assert plate.told[0] == "drawn in mm, by its header"
    assert any(str(path).endswith("crank.dxf") for path, _ in design.sources)
    schema = design_schema()
    jsonschema.validate(tomllib.loads(file.read_text()), schema)
    jsonschema.validate(tomllib.loads(machine(tmp_path, LEVER).read_text()), schema)


def test_holes_that_are_a_little_off_shift_their_forces(tmp_path):
    _, space, saved = drawing(tmp_path / "crank.dxf")
    space.add_lwpolyline([(90, 10), (220, 10), (220, 120), (90, 120)], close=True)
    for x, y, radius in ((110, 40, 6), (190.02, 40, 10), (190, 100.03, 6)):
        space.add_circle((x, y), radius)
    saved()
    shape = DRAWN.replace("190, 100 mm", "190, 100.03 mm")
    plate = crank(machine(tmp_path, shape)).geometry
    assert_allclose(plate.shifts["O"], (0.02, 0), atol=1e-9)
    assert_allclose(plate.shifts["B"], (0, 0.03), atol=1e-9)
    assert any("B is 0.03 mm from where the linkage has it" in said for said in plate.told)


def test_a_mirrored_drawing_is_flipped(tmp_path):
    _, space, saved = drawing(tmp_path / "crank.dxf")
    space.add_lwpolyline([(90, 10), (220, 10), (220, -120), (90, -120)], close=True)
    for x, y, radius in ((110, -40, 6), (190, -40, 10), (190, -100, 6)):
        space.add_circle((x, y), radius)
    saved()
    shape = DRAWN.replace("110, 40", "110, -40").replace("190, 100", "190, -100")
    with pytest.raises(DesignError, match=r"holes\.B: is at \(80, -60\) mm .*; flip = true puts"):
        crank(machine(tmp_path, shape))
    plate = crank(machine(tmp_path, shape.replace('" }\n[', '" }\nflip = true\n['))).geometry
    assert_allclose(plate.bores[2].at, (80, 60), atol=1e-9)


def test_an_svg_path(tmp_path):
    path = "M 90 -10 H 220 V -120 H 90 Z"
    for x, y, r in ((110, 40, 6), (190, 40, 10), (190, 100, 6)):
        arcs = f"A {r} {r} 0 1 0 {x - r} {-y} A {r} {r} 0 1 0 {x + r} {-y} Z"
        path += f" M {x + r} {-y} {arcs}"
    plate = crank(machine(tmp_path, DRAWN.replace('dxf = "crank.dxf"', f'svg = "{path}"'))).geometry
    assert_allclose([bore.at for bore in plate.bores], [(0, 0), (80, 0), (80, 60)], atol=1e-9)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (('"B"]', '"C"]'), "shape.lever: no hole of the part is named 'C'"),
        ((', "B"]', "]"), "shape.lever: leaves out B: it goes once past every hole"),
        ((', fillet = "12 mm"', ""), "shape.fillet: must be stated: at O the lever has"),
        (('fillet = "12 mm"', 'fillet = "90 mm"'), "shape.fillet: 90 mm does not fit at O: it"),
        (('fillet = "12 mm"', 'unit = "mm"'), "shape.unit: belongs to dxf or svg, not to lever"),
        (('eye = "46 mm"', 'at = "0, 0 mm"'), "holes.O.at: belongs to dxf or svg, not to lever"),
        ((', eye = "46 mm"', ""), "holes.O.eye: must be stated for a lever"),
        (('eye = "46 mm"', 'eye = "18 mm"'), "holes.O.eye: must be above 20 mm, got 18 mm"),
        (('"20 mm"', '"12 inch"'), "holes.O.eye: must be above 304.8 mm, got 46 mm"),
        (("lever =", "lever_ ="), "did you mean lever?"),
        (("shape = {", 'shape = "lever"\nx = {'), "shape: must be a table"),
        (("shape = { lever", 'shape = { dxf = "a.dxf", lever'), "needs one of lever, dxf, svg"),
    ],
)  # fmt: skip
def test_levers_that_are_refused(tmp_path, change, told):
    with pytest.raises(DesignError) as caught:
        crank(machine(tmp_path, LEVER.replace(*change)))
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (('"20 mm"', '"21 mm"'), "holes.O: no round hole of 21 mm is in the drawing within"),
        (("{ at = \"110, 40 mm\" }", '{ diameter = "12 mm" }'), "holes.A: 2 holes are a round"),
        (("{ at = \"110, 40 mm\" }", "{}"), "holes.A: must say which hole it is: diameter, at or"),
        (('{ diameter = "20 mm" }', '{ at = "110, 40 mm" }'), "holes.O: is the same hole as A"),
        (("crank.dxf", "crnk.dxf"), "there is no such file, did you mean crank.dxf?"),
        (("190, 100 mm", "190, 90 mm"), "holes.B: no round hole of 12 mm at (190, 90) mm is in"),
        (('dxf = "crank.dxf"', 'dxf = "crank.dxf", unit = "in"'), "shape.dxf: is drawn in mm by"),
        (('dxf = "crank.dxf"', 'dxf = "crank.dxf", layers = ["X"]'), "has no layer 'X'"),
        (('dxf = "crank.dxf"', 'dxf = "crank.toml"'), "shape.dxf: is no DXF file"),
        (('"crank.dxf" }', '"crank.dxf", fillet = "1 mm" }'), "shape.fillet: belongs to lever"),
    ],
)  # fmt: skip
def test_drawings_that_are_refused(tmp_path, change, told):
    drawn(tmp_path)
    with pytest.raises(DesignError) as caught:
        crank(machine(tmp_path, DRAWN.replace(*change)))
    assert told in str(caught.value)


def test_a_drawing_in_another_unit_is_seen(tmp_path):
    drawn(tmp_path, units=1)
    shape = DRAWN.replace("110, 40", "2794, 1016").replace("190, 100", "4826, 2540")
    shape = shape.replace('"20 mm"', '"508 mm"').replace('"12 mm"', '"304.8 mm"')
    with pytest.raises(DesignError, match=r"is 2032 mm from A .* 25\.4 times apart"):
        crank(machine(tmp_path, shape))
