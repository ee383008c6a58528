"""Pressure in the holes of parts, and pins that tear out behind them, by hand."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from checks.by_formula import formula_checks
from checks.by_formula.lug_shear_out import _pull, ligament_all_round, ligaments
from checks.part.loaded_part import LoadedPart
from checks.stress.solid_mesh_level import Models
from geometry.mesh import Interface
from geometry.meshing import mesh_shape
from geometry.parts import PlateLink, SlottedLever, ToggleBar, TubeRod
from geometry.parts.step_part import NamedHole, StepPart

from ...geometry.step_files import LINK, hole, link_file, link_part, plate_with, write_step
from ...small_machine import PLATE, Meshed, loads_of, machine

DESIGNS = Path(__file__).parents[3] / "designs"
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


AS_LONG = "points.B=48, 24 mm"  # the rod, as the link of 60 mm


def lug_checks(loaded, mesh):
    """Pressure in the holes and shear behind them, of a part with this mesh."""
    found = formula_checks(replace(loaded, bodies=Meshed(mesh)))
    return [check for check in found if check.kind in ("bearing", "shear-out")]


CRANK = (
    PLATE.replace("[parts.rod]", "[parts.crank]")
    .replace('body = "rod"', 'body = "crank"')
    .replace('first = "A", second = "B"', 'first = "O", second = "A"')
)


def checks_of(design, wrenches, name="rod"):
    part = design.parts[name]
    mesh = Models().mesh(part.geometry, 0.5)
    return lug_checks(LoadedPart(design, part, loads_of(wrenches)), mesh)


def test_a_hole_bears_the_largest_force_over_diameter_and_thickness(tmp_path):
    """5000 N at 45 deg on 12 x 8 mm: 52.08 MPa against 275 MPa."""
    along = 5000 / 2**0.5
    found = checks_of(
        machine(tmp_path),
        {"first": [(0, 0, 0), (along, along, 0)], "second": [(-10, 0, 0), (-along, -along, 0)]},
    )
    assert [check.kind for check in found] == ["bearing", "shear-out"]
    assert_allclose(found[1].value, along / (2 * 72))  # across; it points into the rod
    assert_allclose(found[0].value, 5000 / 96)
    assert found[0].limit == 275
    assert found[0].position == "k = 1"
    assert found[0].required == machine(tmp_path).require.static


def test_a_pin_bears_no_longer_in_a_lug_than_the_hole_there(tmp_path):
    """The rod of 8 mm in a stack that says 16: as one that says 8, and told."""
    wide = PIN.replace('at = "0 mm", width = "8 mm"', 'at = "0 mm", width = "16 mm"')
    wide, stated = (text.replace('at = "12 mm"', 'at = "13 mm"') for text in (wide, PIN))
    found, same = (machine(tmp_path, PLATE + text) for text in (wide, stated))
    assert found.parts["pin_A"].geometry == same.parts["pin_A"].geometry
    assert found.parts["pin_A"].stack == same.parts["pin_A"].stack
    told = dict(found.assumed)
    assert told == {"parts.pin_A.stack[1].width": "the hole of rod is 8 mm long, which counts"}
    assert not same.assumed


def test_lugs_that_their_parts_are_too_thick_for_are_told(tmp_path):
    """The crank bears from 8 to 16 mm; the rod of 20 mm reaches to 10, one of 16 mm to 8."""
    thick, thin = (
        machine(tmp_path, PLATE.replace('thickness = "8 mm"', f'thickness = "{size} mm"') + PIN)
        for size in (20, 16)
    )
    (told,) = thick.assumed
    assert told[0] == "parts.pin_A.stack[0].at"
    assert told[1].startswith("rod and crank overlap by 2 mm as thick as they are")
    assert not thin.assumed


def test_a_pair_of_lugs_of_a_part_with_one_hole_is_told(tmp_path):
    """The crank of one plate on both sides of the rod; on one side nothing is to be told."""
    pair = PIN.replace('width = "8 mm", single = true', 'width = "8 mm"')
    assert pair != PIN
    (told,) = machine(tmp_path, PLATE + CRANK + pair).assumed
    assert told[0] == "parts.pin_A.stack[0].at"
    assert told[1].startswith("crank has two lugs in the stack and one hole, 8 mm long")
    assert not machine(tmp_path, PLATE + CRANK + PIN).assumed


def test_a_pin_bears_no_longer_in_each_cheek_than_its_wall(tmp_path):
    """Cheeks of 5 mm, and so bushes, in a stack that says 6.3; the bore has 10 in all."""
    text = (DESIGNS / "toggle_press.toml").read_text()
    file = tmp_path / "press.toml"
    text = text.replace('wall = "6.3 mm"', 'wall = "5 mm"')
    file.write_text(text)
    design = read_design(file)
    pin = design.parts["pin_B"]
    assert [lug.width for lug in pin.stack] == [5.0, 5.0, 43.0]
    assert [seat.width for seat in pin.geometry.seats] == [5.0, 5.0, 43.0]
    assert [lug.bush.length for lug in pin.stack[:2]] == [5.0, 5.0]
    said = "the hole of upper is 5 mm long, which counts"
    assert dict(design.assumed)["parts.pin_B.stack[0].width"] == said


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


def test_the_worst_bore_and_position_tear_a_pin_out(tmp_path):
    """3000 N towards x < 0 and 9000 across at the first hole, over 2 t (W - d)/2 = 2 x 72 mm2."""
    wrenches = {
        "first": [(4000, 9000, 0), (-3000, 9000, 0)],
        "second": [(-4000, -9000, 0), (1000, -9000, 0)],
    }
    _, torn = checks_of(machine(tmp_path), wrenches)
    assert torn.kind == "shear-out"
    assert_allclose(torn.value, np.hypot(3000, 9000) / (2 * 8 * (30 - 12) / 2))
    assert_allclose(torn.limit, 275 / 3**0.5)
    assert (torn.position, torn.place) == ("k = 1", "first, towards the end at x < 0")


def test_a_pushed_link_has_nothing_to_tear_out(tmp_path):
    found = checks_of(machine(tmp_path), {"first": [(900, 1e-9, 0)], "second": [(-900, 0, 0)]})
    assert [check.kind for check in found] == ["bearing"]


def test_a_link_is_torn_by_all_of_a_force_that_does_not_point_into_it(tmp_path):
    """300 N outwards and 400 N aside: 500 N over two planes of 8 x 9 mm; inwards the 400 N alone.

    A rod of 20 mm in an eye of 40: from 30 degrees beside the rod on the eye bears all of it.
    """
    design = machine(tmp_path)
    for along, force in ((-300, 500), (300, 400)):
        wrenches = {"first": [(along, 400, 0)], "second": [(-along, -400, 0)]}
        found = next(c for c in checks_of(design, wrenches) if c.kind == "shear-out")
        assert_allclose(found.value, force / (2 * 72))
    eye = TubeRod(length=200, tube_diameter=20, eye_diameter=40, eye_width=20, hole=16)
    forces = np.array([(400, 300, 0), (480, 140, 0), (-480, 140, 0), (500, 0, 0)], dtype=float)
    (behind,) = eye.ligaments("first")
    assert_allclose(_pull(forces, behind)[0], [500, 280, 500, 0])


EDGES = {"the edge at y > 0": 88.0, "the edge at y < 0": 88.0}  # 15 - 4 mm beside a hole


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
            {"the end at x < 0": 88.0, "the slot": 192.0, **EDGES},
        ),
        (
            SlottedLever(
                length=220, width=30, thickness=8, hole=8, slot_width=12, slot_from=28, slot_to=190,
                overhang=10,
            ),
            "tip",
            {"the end at x > 220 mm": 48.0, "the slot": 208.0, **EDGES},
        ),
    ],
)  # fmt: skip
def test_every_shape_knows_the_ligaments_behind_its_holes(shape, interface, areas):
    part = Of(shape)
    found = {one.until: one.area for one in ligaments(part, part, interface)}
    assert_allclose(list(found.values()), list(areas.values()))
    assert found.keys() == areas.keys()


def test_an_eye_is_torn_through_less_than_its_middle_plane_suggests():
    """A ball of 30 mm cut to 20 mm about a hole of 16 mm: under 20 x 7 mm2, over the flats'."""
    shape = TubeRod(length=200, tube_diameter=20, eye_diameter=30, eye_width=20, hole=16)
    (found,) = ligaments(Of(shape), Of(shape), "first")
    flats = 20 * ((225 - 100) ** 0.5 - 8)
    assert flats < found.area < 20 * 7


def areas_at(found, *degrees):
    """Areas of a ligament for forces in some directions."""
    return found.areas(np.radians(degrees))


def plate_of(folder, *tools, fineness=0.4):
    """A plate of 8 mm with a hole of 12 mm, 20 mm from three sides, one of 10 mm, and others."""
    file = write_step(folder / "plate.step", plate_with(hole(0, 0, 12), hole(60, 0, 10), *tools))
    shape = StepPart(file, (NamedHole("first", 12), NamedHole("second", 10)))
    return shape, mesh_shape(shape, fineness=fineness)


@pytest.fixture(scope="module")
def plate(tmp_path_factory):
    """The plate with its two holes alone, and its mesh."""
    return plate_of(tmp_path_factory.mktemp("plate"))


def test_the_ligament_of_a_part_from_cad_is_found_in_every_direction(plate):
    """20 - 6 mm towards three sides of the plate, 8 mm thick.

    At 45 degrees the plane that begins 40 degrees off, at (6 cos 85, 6 sin 85), is the shortest:
    (20 - 5.98) / sin 45 mm; at 25 degrees (20 - 5.44) / sin 25, at 27.4 degrees 9 % less. At 10
    degrees material goes on for more than three diameters, and towards +x there is a pin.
    """
    shape, mesh = plate
    (found,) = ligaments(Of(shape), mesh, "first")
    assert_allclose(areas_at(found, 90, 180, 270), 8 * 14, rtol=5e-4)
    assert_allclose(areas_at(found, 45), 8 * 14.02 * 2**0.5, rtol=5e-4)
    assert_allclose(areas_at(found, 25, 27.4), [8 * 34.45, 8 * 31.42], rtol=5e-4)
    assert (areas_at(found, 0, 10) == np.inf).all()
    many = np.arange(-180, 180, 2.5)
    alone = [areas_at(found, one)[0] for one in many]
    assert_allclose(areas_at(found, *many), alone, rtol=1e-12)
    towards = 500.0 * np.column_stack([np.cos(np.radians(many)), np.sin(np.radians(many))])
    force, area = _pull(np.pad(towards, ((0, 0), (0, 4))), found)
    assert_allclose(force, 500.0)
    assert_allclose(area, alone, rtol=1e-9)


@pytest.mark.parametrize("bottom", [-6, 4])
def test_a_pocket_in_one_side_of_a_plate_is_where_its_pin_tears_out(tmp_path, bottom):
    """Half of the thickness is cut away from y = 12 mm on: 6 mm are left of 14."""
    _, mesh = plate_of(tmp_path, (0, 15, bottom, 0, 0, 10, 3))
    found = ligament_all_round(mesh, "first")
    assert_allclose(areas_at(found, 90), 8 * 6, rtol=1e-3)
    assert_allclose(areas_at(found, 270), 8 * 14, rtol=5e-4)


@pytest.mark.slow
def test_a_hole_beside_the_way_shortens_the_plane_that_meets_it(tmp_path):
    """4 mm at (3.86, 15): of the planes, 10 degrees apart, the one 30 degrees off is the shortest.

    It begins at 6 cos 30 = 5.196 mm, 3 mm aside, and ends at 15 - sqrt(4 - 0.86^2) = 13.194 mm.
    """
    _, mesh = plate_of(tmp_path, hole(3.86, 15, 4), fineness=0.6)
    assert_allclose(areas_at(ligament_all_round(mesh, "first"), 90), 8 * 7.998, rtol=5e-4)


def test_a_hole_without_a_pin_ends_a_plane_and_one_with_a_pin_is_held(tmp_path):
    """A hole of 10 mm, 25 mm away: 25 - 5 - 6 mm to it; a pin in it is pushed at instead."""
    shape, mesh = plate_of(tmp_path, hole(25, 0, 10.5))
    assert_allclose(areas_at(ligament_all_round(mesh, "first"), 0), 8 * (25 - 5.25 - 6), rtol=0.02)
    named = StepPart(shape.path, (*shape.holes, NamedHole("third", 10.5)))
    mesh = mesh_shape(named, fineness=0.4)
    assert areas_at(ligament_all_round(mesh, "first"), 0) == np.inf


def link_from_cad(tmp_path):
    """A design whose rod is the plate link of 24 x 8 mm as a STEP file, and its mesh."""
    design = machine(tmp_path, PLATE, AS_LONG)
    shape = link_part(link_file(tmp_path))
    part = replace(design.parts["rod"], geometry=shape)
    return design, part, mesh_shape(shape, fineness=0.4)


def test_a_link_from_cad_is_torn_out_as_the_parametric_one_and_not_where_it_is_pushed(tmp_path):
    """Pulled at its hole of 12 mm: 2000 / (2 x 8 x (24 - 12) / 2); pushed by as much: nothing."""
    design, part, mesh = link_from_cad(tmp_path)

    def checks(force):
        loads = loads_of({"first": [(-force, 0, 0)], "second": [(force, 0, 0)]})
        parametric = replace(part, geometry=LINK)
        return [lug_checks(LoadedPart(design, one, loads), mesh) for one in (part, parametric)]

    (_, torn), (_, stated) = checks(2000)
    assert_allclose(torn.value, 2000 / 96, rtol=0.01)
    assert_allclose(torn.value, stated.value, rtol=0.01)
    assert torn.place == "second, towards the wall that the force points at"
    for found in checks(-2000):
        assert [check.kind for check in found] == ["bearing"]


def test_a_part_from_cad_is_judged_in_the_direction_that_the_pin_pulls(tmp_path, plate):
    """2000 N across: 14 mm of ligament; at 45 degrees 19.8 mm; along it nothing tears."""
    shape, mesh = plate
    design = machine(tmp_path, PLATE, AS_LONG)
    part = replace(design.parts["rod"], geometry=shape)

    def torn(x, y):
        loads = loads_of({"first": [(x, y, 0)], "second": [(0, 0, 0)]})
        return lug_checks(LoadedPart(design, part, loads), mesh)[1:]

    assert_allclose(torn(0, 2000)[0].value, 2000 / (2 * 8 * 14), rtol=5e-4)
    assert_allclose(torn(1414.2, 1414.2)[0].value, 2000 / (2 * 8 * 19.83), rtol=5e-4)
    assert not torn(2000, 0)


@pytest.mark.parametrize(
    ("interface", "direction"), [("first", (-1.0, 0.0)), ("second", (1.0, 0.0))]
)
def test_a_link_is_torn_by_a_force_from_its_bore_to_the_end_behind_it(interface, direction):
    """A unit vector: forces are taken along it. Area 20 mm (90 - 44)/2 beside the bore."""
    (found,) = PlateLink(length=250.0, width=90.0, thickness=20.0, hole=44.0).ligaments(interface)
    assert found.direction == direction
    assert found.area == 460.0
