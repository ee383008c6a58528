"""Pressure of sliding contacts, by Hertz and on flat blocks."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.by_formula import slot_pressure
from checks.by_formula.slot_pressure import FIRST_YIELD
from checks.design.errors import DesignError
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import loads_on
from geometry.mesh import Interface

from ...small_machine import Meshed, loads_of, machine, solved

# a block on the slider's pin slides in a slot of the lever
LEVER = """
[parts.lever]
body = "lever"
shape = "slotted_lever"
interfaces = { pivot = "P", tip = "T", slot = "slot" }
material = "S275"
width = "30 mm"
thickness = "8 mm"
hole = "8 mm"
slot_width = "12 mm"
slot_from = "28 mm"
slot_to = "192 mm"
contact_length = "10 mm"
[bodies.lever]
pins = ["P", "T"]
[joints.slot]
kind = "slot"
on = "lever"
through = "P"
along = "T"
body = "slider"
point = "B"
"""
SLIDE = Interface("slot", "slide", np.zeros(3), length=8.0, travel=(40.0, 180.0), patch=5.0)
MESH = SimpleNamespace(interfaces={"slot": SLIDE})


def lever(folder, contacts="", *overrides):
    text = LEVER.replace('"10 mm"\n', f'"10 mm"\n{contacts}\n')
    points = ['points.P="144, -120 mm"', 'points.T="144, 100 mm"', 'ground=["O", "P"]']
    return machine(folder, text, *points, *overrides)


def checks_of(design, force, couple=0.0):
    reach = np.array([60.0, 120.0])
    rows = [(0.0, 0.1 * force, 0.1 * force * 60.0), (0.0, force, 120.0 * force + couple)]
    return slot_checks(design, loads_of({"slot": rows}, {"slot": reach}))


def slot_checks(design, loads):
    loaded = LoadedPart(design, design.parts["lever"], loads, bodies=Meshed(MESH))
    return list(slot_pressure.checks(loaded))


def test_a_pin_on_a_flank_presses_as_hertz_says(tmp_path):
    """Steel on steel, E* = 210e3 / (2 x 0.91): p0 = sqrt(P E* / (pi R)), P = 800 N / 8 mm."""
    (found,) = checks_of(lever(tmp_path, 'contacts = { slot = { radius = "6 mm" } }'), -800.0)
    by_hand = np.sqrt(100.0 * 210e3 / (2 * 0.91) / (np.pi * 6))
    assert_allclose(found.value, by_hand, rtol=1e-9)
    assert_allclose(by_hand, 782.4, atol=0.1)
    carried = np.pi / 2 * found.derivation.number("b") * found.value
    assert_allclose(carried, 100.0, rtol=1e-12)  # the elliptic pressure's resultant
    assert_allclose(found.limit, 1.67 * 275, rtol=5e-3)
    assert (found.kind, found.position) == ("contact", "k = 1")


def test_a_roller_on_a_flat_has_the_width_and_pressure_of_hertz(tmp_path):
    """FE-20, line: R = 10 mm, 100 N/mm; ten digits of the closed form, six of the shear's."""
    text = 'contacts = { slot = { radius = "10 mm" } }'
    (found,) = checks_of(lever(tmp_path, text, "parts.lever.slot_width=20 mm"), 800.0)
    assert_allclose(found.derivation.number("b"), 0.1050463837, rtol=1e-9)
    assert_allclose(found.value, 606.0368288, rtol=1e-9)
    # 0.300283 p0 and 0.786152 b
    assert "0.21 mm wide; largest shear 182 MPa at 0.083 mm depth; even along" in found.note


def test_yield_under_a_line_contact_begins_at_1_67_times_the_yield_stress():
    """Johnson 1985, 6.1(a): p0 = 1.67 Sy by Tresca, as printed."""
    assert_allclose(FIRST_YIELD, 1.67, atol=0.005)


def test_a_softer_pin_yields_first_and_gives_way_more(tmp_path):
    soft = "{ slot = { radius = '6 mm', material = 'bronze' } }"
    design = lever(
        tmp_path,
        f'contacts = {soft}\n[materials.bronze]\nyoungs_modulus = "100 GPa"\npoisson_ratio = 0.34\n'
        'density = "8800 kg/m3"\nyield_stress = "120 MPa"\nultimate_stress = "300 MPa"\n'
        "endurance_ratio = 0.3\n",
    )
    (found,) = checks_of(design, 800.0)
    (steel,) = checks_of(lever(tmp_path, 'contacts = { slot = { radius = "6 mm" } }'), 800.0)
    stiffness = 1 / (0.91 / 210e3 + (1 - 0.34**2) / 100e3)
    assert_allclose(found.value, np.sqrt(100.0 * stiffness / (np.pi * 6)), rtol=1e-9)
    assert found.value < steel.value
    assert_allclose(found.limit / steel.limit, 120 / 275)
    assert "bronze" in found.basis


@pytest.mark.parametrize(("radius", "yields"), [(8, 235), (9, 225)])
def test_a_pin_in_a_slot_has_the_strength_of_its_own_diameter(tmp_path, radius, yields):
    """EN 10025-2: S235 has 235 MPa up to 16 mm, 225 up to 40."""
    entry = f"contacts = {{ slot = {{ radius = '{radius} mm', material = 'S235' }} }}"
    wide = ["parts.lever.slot_width=20 mm", "parts.lever.width=40 mm"]
    (found,) = checks_of(lever(tmp_path, entry, *wide), 800.0)
    assert_allclose(found.limit, FIRST_YIELD * yields)


def test_a_flat_block_presses_evenly_and_its_edges_are_told(tmp_path):
    """800 N on 10 x 8 mm: 10 MPa."""
    (found,) = checks_of(lever(tmp_path), 800.0)
    assert_allclose(found.value, 10.0)
    assert found.limit == 275
    assert "edges press without a bound: they are not modelled" in found.note


def test_a_couple_on_the_block_presses_its_end_more(tmp_path):
    """6 M / (b L^2) = 6 x 1000 / (8 x 100) = 7.5 MPa more, whichever way it turns."""
    for couple in (1000.0, -1000.0):
        (found,) = checks_of(lever(tmp_path), 800.0, couple)
        assert_allclose(found.value, 17.5)
        assert "couple 1 N m" in found.note
        assert found.derivation.number("C") == pytest.approx(1000.0)


def test_a_roller_that_its_load_would_flatten_is_refused(tmp_path):
    design = lever(tmp_path, 'contacts = { slot = { radius = "0.001 mm" } }')
    with pytest.raises(DesignError, match=r"contacts\.slot\.radius: .* of 0\.001 mm .*Hertz"):
        checks_of(design, 8000.0)


def test_a_roller_cannot_take_a_couple(tmp_path):
    design = lever(tmp_path, 'contacts = { slot = { radius = "6 mm" } }')
    with pytest.raises(DesignError, match="takes no couple, but up to 1 N m act here"):
        checks_of(design, 800.0, 1000.0)


def test_friction_in_a_slot_is_no_couple_on_its_roller(tmp_path):
    """It acts along the line through the pin; the loads are the linkage's own."""
    text = 'contacts = { slot = { radius = "6 mm" } }'
    heavy = ['mass="3 kg"', 'inertia="0.02 kg m2"', 'centre="100, 0 mm"']
    rubs = "friction={slots={coefficient=0.3}}"
    design = lever(tmp_path, text, rubs, *(f"bodies.lever.{key}" for key in heavy))
    cycles = solved(design)
    loads = loads_on(design, design.parts["lever"], cycles)
    along, across = np.abs(loads.wrenches["slot"][:, :2]).max(axis=0)
    assert_allclose(along, 0.3 * across, rtol=1e-6)
    (found,) = slot_checks(design, loads)
    assert found.value > 0


@pytest.mark.parametrize(
    ("contacts", "told"),
    [
        ('{ slit = { radius = "6 mm" } }', r"contacts\.slit: no sliding interface .* slot"),
        ('{ pivot = { radius = "6 mm" } }', r"contacts\.pivot: no sliding interface"),
        ('{ slot = { radius = "0 mm" } }', r"contacts\.slot\.radius: must be above 0 mm"),
        (
            '{ slot = { radius = "6 mm", material = "S257" } }',
            r"contacts\.slot\.material: no material is named 'S257', did you mean S275",
        ),
    ],
)
def test_contacts_that_cannot_be_meant_are_refused(tmp_path, contacts, told):
    with pytest.raises(DesignError, match=told):
        lever(tmp_path, f"contacts = {contacts}")


def test_a_roller_that_nothing_presses_at_some_positions_has_a_pressure_at_the_others(tmp_path):
    design = lever(tmp_path, 'contacts = { slot = { radius = "6 mm" } }')
    reach = np.array([60.0, 120.0])
    pressed, free = (0.0, 800.0, 800.0 * 60.0), (0.0, 0.0, 0.0)
    (found,) = slot_checks(design, loads_of({"slot": [free, pressed]}, {"slot": reach[::-1]}))
    assert found.position == "k = 1"
    assert slot_checks(design, loads_of({"slot": [free, free]}, {"slot": reach})) == []
