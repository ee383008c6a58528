"""Pressure in the holes of parts, and pins that tear out behind them, by hand."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.levels import Models
from ballesta.lug_checks import ligament_all_round, ligaments, lug_checks
from geometry.mesh import Interface
from geometry.meshing import mesh_shape
from geometry.parts import SlottedLever, ToggleBar, TubeRod
from geometry.parts.step_part import NamedHole, StepPart

from ..geometry.step_files import hole, plate_with, write_step
from .small_machine import PLATE, loads_of, machine

PIN = """
[parts.pin_A]
joint = "A"
shape = "pin"
fixed_to = "crank"
material = "S275"
diameter = "10 mm"
stack = [
  { body = "crank", at = "12 mm", width = "8 mm", single = true },
  { body = "rod", at = "0 mm", width = "8 mm", single = true },
]
"""


def checks_of(design, wrenches, name="rod"):
    part = design.parts[name]
    mesh = Models().mesh(part.geometry, 0.5)
    return lug_checks(design, part, loads_of(wrenches), mesh)


def test_a_hole_bears_the_largest_force_over_diameter_and_thickness(tmp_path):
    """5000 N at 45 deg on 12 x 8 mm: 52.08 MPa against 275 MPa."""
    along = 5000 / 2**0.5
    found = checks_of(
        machine(tmp_path),
        {"first": [(0, 0, 0), (along, along, 0)], "second": [(-10, 0, 0), (-along, -along, 0)]},
    )
    assert [check.kind for check in found] == ["bearing"]
    assert_allclose(found[0].value, 5000 / 96)
    assert found[0].limit == 275
    assert found[0].position == "k = 1"
    assert found[0].required == machine(tmp_path).require.static


def test_a_pin_thinner_than_its_hole_bears_on_its_own_diameter(tmp_path):
    """Without a bush the pin of 10 mm presses in the hole of 12 mm; with one the bush does."""
    wrenches = {"first": [(5000, 0, 0)], "second": [(-5000, 0, 0)]}
    bare = checks_of(machine(tmp_path, PLATE + PIN), wrenches)[0]
    assert_allclose(bare.value, 5000 / 80)
    assert bare.place.startswith("first, 10 x 8")
    assert "pin of 10 mm in a hole of 12 mm" in bare.note
    bushed = PIN.replace(
        'body = "rod", at = "0 mm"',
        'body = "rod", bush = { length = "8 mm", allowable = "20 MPa" }, at = "0 mm"',
    )
    assert_allclose(checks_of(machine(tmp_path, PLATE + bushed), wrenches)[0].value, 5000 / 96)


STRONG = PLATE.replace("S275", "S355")


def test_the_softer_of_pin_and_hole_limits_the_pressure_between_them(tmp_path):
    """A pin of S275 in a link of S355; through a bush the pin does not press on the link."""
    wrenches = {"first": [(5000, 0, 0)], "second": [(-5000, 0, 0)]}
    found = checks_of(machine(tmp_path, STRONG + PIN), wrenches)[0]
    assert found.limit == 275
    assert "yield stress of S275" in found.basis
    hard = PIN.replace("S275", "42CrMo4")
    assert checks_of(machine(tmp_path, STRONG + hard), wrenches)[0].limit == 355
    bushed = PIN.replace(
        'body = "rod", at = "0 mm"',
        'body = "rod", bush = { length = "8 mm", allowable = "20 MPa" }, at = "0 mm"',
    )
    assert checks_of(machine(tmp_path, STRONG + bushed), wrenches)[0].limit == 355


def test_the_hole_that_is_nearest_to_its_limit_is_told_not_the_one_with_most_pressure(tmp_path):
    """50 of 275 MPa by the softer pin at the first hole, against 52.1 of 355 MPa at the second."""
    wrenches = {"first": [(4000, 0, 0)], "second": [(-5000, 0, 0)]}
    found = checks_of(machine(tmp_path, STRONG + PIN), wrenches)[0]
    assert_allclose(found.value, 50.0)
    assert "other holes, MPa: second 52.1" in found.note


def test_a_lug_or_bush_that_is_narrower_than_the_hole_bears_on_its_own_width(tmp_path):
    wrenches = {"first": [(5000, 0, 0)], "second": [(-5000, 0, 0)]}
    narrow = PIN.replace('at = "0 mm", width = "8 mm"', 'at = "0 mm", width = "5 mm"')
    assert_allclose(checks_of(machine(tmp_path, PLATE + narrow), wrenches)[0].value, 5000 / 50)
    bushed = PIN.replace(
        'body = "rod", at = "0 mm"',
        'body = "rod", bush = { length = "6 mm", allowable = "20 MPa" }, at = "0 mm"',
    )
    assert_allclose(checks_of(machine(tmp_path, PLATE + bushed), wrenches)[0].value, 5000 / 72)


def test_only_what_pulls_towards_the_end_tears_a_pin_out(tmp_path):
    """3000 N towards x < 0 at the first hole: F / (2 t (W - d)/2) = 3000 / (2 x 72 mm2)."""
    wrenches = {
        "first": [(4000, 9000, 0), (-3000, 9000, 0)],
        "second": [(-4000, -9000, 0), (1000, -9000, 0)],
    }
    _, torn = checks_of(machine(tmp_path), wrenches)
    assert torn.kind == "shear-out"
    assert_allclose(torn.value, 3000 / (2 * 8 * (30 - 12) / 2))
    assert_allclose(torn.limit, 275 / 3**0.5)
    assert (torn.position, torn.place) == ("k = 1", "first, towards the end at x < 0")


def test_a_pushed_link_has_nothing_to_tear_out(tmp_path):
    found = checks_of(machine(tmp_path), {"first": [(900, 5, 0)], "second": [(-900, -5, 0)]})
    assert [check.kind for check in found] == ["bearing"]


class Of:
    """A part and a mesh of which only the shape and the holes count."""

    def __init__(self, shape, holes=()):
        self.geometry = shape
        self.interfaces = {
            name: Interface(name, "bore", np.zeros(3), radius, length)
            for name, radius, length in holes
        }


@pytest.mark.parametrize(
    ("shape", "interface", "areas"),
    [
        # two cheeks of 6.3 mm, 40 mm beyond the axis of a hole of 44 mm
        (
            ToggleBar(
                length=250, width=80, wall=6.3, hole=44, overhang=40, inner_radius=3,
                cutout_length=56, cutout_corner=5,
            ),
            "knee",
            {"the end at x < 0": 2 * 6.3 * 18},
        ),
        # a plate of 8 mm: 15 - 4 mm to its end, 28 - 4 mm to the slot; 220 - 192 - 4 mm at the tip
        (
            SlottedLever(
                length=220, width=30, thickness=8, hole=8, slot_width=12, slot_from=28, slot_to=192,
            ),
            "pivot",
            {"the end at x < 0": 88.0, "the slot": 192.0},
        ),
        (
            SlottedLever(
                length=220, width=30, thickness=8, hole=8, slot_width=12, slot_from=28, slot_to=190,
                overhang=10,
            ),
            "tip",
            {"the end at x > 220 mm": 48.0, "the slot": 208.0},
        ),
    ],
)  # fmt: skip
def test_every_shape_knows_the_ligaments_behind_its_holes(shape, interface, areas):
    part = Of(shape)
    found = {one.until: one.area[0] for one in ligaments(part, part, interface)}
    assert_allclose(list(found.values()), list(areas.values()))
    assert found.keys() == areas.keys()


def test_an_eye_is_torn_through_less_than_its_middle_plane_suggests():
    """A ball of 30 mm cut to 20 mm about a hole of 16 mm: under 20 x 7 mm2, over the flats'."""
    shape = TubeRod(length=200, tube_diameter=20, eye_diameter=30, eye_width=20, hole=16)
    (found,) = ligaments(Of(shape), Of(shape), "first")
    flats = 20 * ((225 - 100) ** 0.5 - 8)
    assert flats < found.area[0] < 20 * 7


def test_the_ligament_of_a_part_from_cad_is_found_in_every_direction(tmp_path):
    """A hole of 12 mm, 20 mm from three sides of a plate of 8 mm: 14 mm less chords, 2 %.

    Towards +x the next hole is 49 mm away, but the sides, within 40 degrees, 20 / sin 40 - 6 mm or
    up to one element of 4 mm more.
    """
    file = write_step(tmp_path / "plate.step", plate_with(hole(0, 0, 12), hole(60, 0, 10)))
    shape = StepPart(file, (NamedHole("first", 12), NamedHole("second", 10)))
    mesh = mesh_shape(shape, fineness=0.6)
    (found,) = ligaments(Of(shape), mesh, "first")
    areas = np.array(found.area)
    assert found.direction is None
    assert_allclose(areas[[18, 36, 54]], 8 * 14, rtol=0.02)
    assert 8 * 24.9 < areas[0] < 8 * 29.5
    assert_allclose(areas, ligament_all_round(mesh, "first").area)


def test_a_part_from_cad_is_judged_in_the_direction_that_the_pin_pulls(tmp_path):
    """2000 N across: 14 mm of ligament; 2000 N along: more of it, so less shear."""
    file = write_step(tmp_path / "plate.step", plate_with(hole(0, 0, 12), hole(60, 0, 10)))
    shape = StepPart(file, (NamedHole("first", 12), NamedHole("second", 10)))
    design = machine(tmp_path)
    part = replace(design.parts["rod"], geometry=shape, interfaces={"first": "A", "second": "B"})
    mesh = mesh_shape(shape, fineness=0.6)

    def torn(x, y):
        loads = loads_of({"first": [(x, y, 0)], "second": [(-x, -y, 0)]})
        return lug_checks(design, part, loads, mesh)[1]

    across, along = torn(0, 2000), torn(2000, 0)
    assert_allclose(across.value, 2000 / (2 * 8 * 14), rtol=0.02)
    assert along.value < 0.65 * across.value
