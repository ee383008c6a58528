"""Plates side by side: pins' stacks against the offsets of the parts, and what cannot be meant."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from ballesta.commands.plan import plan
from ballesta.design.read import read_design
from ballesta.machine.elastic_parts import body_compliance
from ballesta.machine.warnings_of import design_warnings
from checks.design.errors import DesignError
from checks.part.loaded_part import LoadedPart, check_reach
from checks.part.part_loads import loads_on
from geometry.mesh import Interface
from loads import LinkageError

from ...small_machine import MACHINE, PLATE, machine, solved
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


# a second rod and slider on the pin: each presses on its own
TWO_RODS = """
[bodies.rod2]
pins = ["A", "C"]
mass = "0.2 kg"
inertia = "5e-4 kg m2"
centre = "80, 0 mm"
[bodies.slider2]
pins = ["C"]
mass = "40 kg"
guide = { along = "0, 1" }
"""
THREE_LUGS = PIN.replace(
    "single = true },\n]",
    'single = true },\n  { body = "rod2", at = "22 mm", width = "8 mm", single = true },\n]',
)


def two_rods(folder, *overrides):
    path = folder / "two_rods.toml"
    points = MACHINE.replace("[bodies.crank]", 'C = "12, 204 mm"\n[bodies.crank]', 1)
    path.write_text(points + TWO_RODS + PLATE + CRANK + THREE_LUGS, encoding="utf-8")
    return read_design(path, list(overrides))


def design_of(folder, *overrides):
    return machine(folder, PLATE + CRANK + PIN, *overrides)


def loads_of(design, name="crank"):
    return loads_on(design, design.parts[name], solved(design))


def test_an_offset_that_is_not_stated_is_taken_from_the_stack(tmp_path):
    """It was left out, with a gate that broke: 62.8 instead of 71.2 MPa in the slider-crank."""
    stated = loads_of(design_of(tmp_path, *offsets("10.5 mm", "0 mm")))
    found = loads_of(design_of(tmp_path))
    assert found.tilt_held_at == stated.tilt_held_at == "first"
    assert np.abs(found.wrenches["first"][:, 3:5]).max() > 0
    for name, wrench in stated.wrenches.items():
        assert_array_equal(found.wrenches[name], wrench)
    turns = loads_of(design_of(tmp_path), "rod")
    assert not turns.wrenches["first"][:, 3:5].any()


def test_three_lugs_hand_the_plate_the_couple_that_no_offset_has(tmp_path):
    """By hand: 10.5 mm of one rod's force, 22 mm of the other's, turned into the crank's axes."""
    design = two_rods(tmp_path)
    (cycle,) = solved(design).values()
    on_pin = {
        body: -sum(load.force for load in cycle.body_loads(body) if load.point == "A")
        for body in ("rod", "rod2")
    }
    couple = 10.5 * on_pin["rod"] + 22.0 * on_pin["rod2"]
    along = cycle.poses[:, cycle.body_index("crank"), 2]  # from the crank's own x, at its start 0
    along = along - along[0] + np.pi / 2
    x, y = (
        np.stack(axis, axis=1)
        for axis in ((np.cos(along), np.sin(along)), (-np.sin(along), np.cos(along)))
    )
    about = np.stack([-(couple * y).sum(axis=1), (couple * x).sum(axis=1)], axis=1)
    found = loads_of(design)
    assert_allclose(found.wrenches["second"][:, 3:5], about, atol=1e-9 * np.abs(about).max())
    assert_allclose(found.wrenches["first"][:, 3:5], -about, atol=1e-9 * np.abs(about).max())
    force = found.wrenches["second"][:, :2]
    best = (couple * sum(on_pin.values())).sum() / (force**2).sum()
    left = couple - best * sum(on_pin.values())
    assert np.hypot(*left.T).max() > 0.2 * np.hypot(*couple.T).max()


def test_an_offset_beside_lugs_at_several_heights_is_refused(tmp_path):
    with pytest.raises(DesignError, match=r"has 10.5 and 22 mm beside .* leave it out") as caught:
        two_rods(tmp_path, 'parts.crank.offsets={second="13 mm"}')
    assert caught.value.key == "parts.crank.offsets.second"


def test_a_plate_with_a_pin_beside_it_gives_way_in_no_contact_by_its_mesh(tmp_path):
    part = design_of(tmp_path).parts["crank"]
    with pytest.raises(LinkageError, match="beside it they also twist"):
        body_compliance(design_of(tmp_path), part, None)


def offsets(crank, rod):
    return f'parts.crank.offsets={{second="{crank}"}}', f'parts.rod.offsets={{first="{rod}"}}'


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
        design_of(tmp_path, *offsets(crank, rod))
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
        design_of(tmp_path, override, *offsets("10.5 mm", "0 mm"))
    assert caught.value.key == f"parts.{key}"


@pytest.mark.parametrize(
    ("diameter", "fit", "said"),
    [
        ("11.5 mm", "0.02 .. 0.06 mm", r"at most 0.06 mm, but parts.pin_A.diameter .* leaves 0.5"),
        ("11.9 mm", "H7/f7", r"at most 0.052 mm, .* of 11.9 mm leaves 0.1 mm .*parts.rod.hole"),
    ],
)
def test_a_fit_that_the_diameters_contradict_is_refused_with_both(tmp_path, diameter, fit, said):
    """The contact was solved for the fit, though the pin is ten times as loose by its diameter."""
    loose = f'parts.rod.fits={{first="{fit}"}}', f'parts.pin_A.diameter="{diameter}"'
    with pytest.raises(DesignError, match=said) as caught:
        design_of(tmp_path, *loose, *offsets("10.5 mm", "0 mm"))
    assert caught.value.key == "parts.rod.fits.first"


def test_a_fit_goes_with_nominal_diameters_and_with_those_that_are_within_it(tmp_path):
    for diameter in ("12 mm", "11.95 mm"):
        fitted = 'parts.rod.fits={first="H7/f7"}', f'parts.pin_A.diameter="{diameter}"'
        assert design_of(tmp_path, *fitted, *offsets("10.5 mm", "0 mm"))


def test_a_bush_longer_than_its_lug_is_refused_with_both(tmp_path):
    """Its mean pressure came out ten times too low: F / (d 80 mm) in a lug 8 mm wide."""
    bush = 'bush={length="80 mm",allowable="140 MPa"}'
    stack = (
        'parts.pin_A.stack=[{body="crank",at="0 mm",width="8 mm",single=true},'
        f'{{body="rod",at="10.5 mm",width="8 mm",single=true,{bush}}}]'
    )
    said = r"a bush of 80 mm is longer than the lug, .* 8 mm wide .*stack\[1\]\.width"
    with pytest.raises(DesignError, match=said) as caught:
        design_of(tmp_path, stack, *offsets("10.5 mm", "0 mm"))
    assert caught.value.key == "parts.pin_A.stack[1].bush.length"


def test_a_bush_stands_between_a_pin_and_a_wider_hole(tmp_path):
    bush = 'bush={length="8 mm",allowable="140 MPa"}'
    stack = (
        'parts.pin_A.stack=[{body="crank",at="0 mm",width="8 mm",single=true},'
        f'{{body="rod",at="10.5 mm",width="8 mm",single=true,{bush}}}]'
    )
    assert design_of(tmp_path, stack, 'parts.rod.hole="16 mm"', *offsets("10.5 mm", "0 mm"))


def test_the_hole_at_a_pin_is_the_second_one_where_it_sits_there(tmp_path):
    """The first is the shaft's, 20 mm."""
    holes = 'parts.crank.hole="20 mm"', 'parts.crank.second_hole="12 mm"'
    assert design_of(tmp_path, *holes, *offsets("10.5 mm", "0 mm"))


def test_a_fork_has_no_arm(tmp_path):
    stack = (
        'parts.pin_A.stack=[{body="crank",at="0 mm",width="8 mm"},'
        '{body="rod",at="10 mm",width="8 mm"}]'
    )
    assert not design_of(tmp_path, stack).parts["crank"].beside


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

    check_reach(LoadedPart(design, part, loads), with_travel(low, high))
    for travel in ((low + 0.1, high), (low, high - 0.1)):
        with pytest.raises(DesignError) as caught:
            check_reach(LoadedPart(design, part, loads), with_travel(*travel))
        assert caught.value.key == "parts.lever.interfaces.slot"
        assert f"slides from x = {low + 3:.4g} to {high + 3:.4g} mm" in caught.value.problem
        assert "travel_from, travel_to" in caught.value.problem
    assert isinstance(MESH.interfaces["slot"], Interface)


def test_a_first_mesh_larger_than_allowed_is_refused(tmp_path):
    with pytest.raises(DesignError, match=r"parts\.rod: mesh\.most_unknowns is 100, but"):
        plan(machine(tmp_path, PLATE, "parts.rod.mesh.most_unknowns=100"))
