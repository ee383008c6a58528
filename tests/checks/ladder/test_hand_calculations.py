"""Hand checks of links, rods, levers and pins beside their meshed parts, loaded by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.design.materials import known_materials
from checks.ladder.part_facts import hand_checks
from checks.stress.solid_mesh_level import solve_level
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.meshing import mesh_shape
from geometry.parts import Pin, PlateLink, Seat, SlottedLever, TubeRod

from ...small_machine import loads_of

LINK = PlateLink(length=200.0, width=30.0, thickness=8.0, hole=12.0)
ROD = TubeRod(
    length=200.0, tube_diameter=20.0, wall=2.5, eye_diameter=28.5, eye_width=21.0, hole=12.0,
    fillet=6.0,
)  # fmt: skip
LEVER = SlottedLever(
    length=220.0, width=30.0, thickness=8.0, hole=8.0, slot_width=12.0, slot_from=28.0,
    slot_to=192.0, contact_length=12.0,
)  # fmt: skip
STEEL = known_materials()["S275"]


@pytest.fixture(scope="module")
def solved():
    """Solutions of the three shapes, made once."""
    elastic = Elastic(STEEL.youngs_modulus, STEEL.poisson_ratio, STEEL.density)
    shapes = {LINK: 0.5, ROD: 0.7, LEVER: 0.7}
    return {
        shape: solve_unit_loads(mesh_shape(shape, fineness=fineness), elastic)
        for shape, fineness in shapes.items()
    }


def checks_of(solved, shape, wrenches, accelerations=None, reaches=None):
    """Hand checks by the first words of their quantity."""
    loads = loads_of(wrenches, reaches)
    if accelerations is not None:
        loads = replace(loads, accelerations=np.array(accelerations))
    level = solve_level(solved[shape], 1.0, loads, 100.0, STEEL.ultimate_stress, {})
    part = SimpleNamespace(geometry=shape, material=STEEL, body="link")
    return {check.quantity.split(" at ")[0]: check for check in hand_checks(part, loads, level)}


PULLED = {
    "first": [(-3000.0, 0.0, 0.0), (-9000.0, 0.0, 0.0), (5000.0, 0.0, 0.0)],
    "second": [(3000.0, 0.0, 0.0), (9000.0, 0.0, 0.0), (-5000.0, 0.0, 0.0)],
}


def test_a_link_carries_force_over_area_at_mid_length_at_its_worst_position(solved):
    """9000 N on 30 x 8 mm: 37.5 MPa; Saint-Venant's rest of the holes is below 1 %."""
    axial = checks_of(solved, LINK, PULLED)["axial stress"]
    assert_allclose(axial.hand, 9000 / 240)
    assert_allclose(axial.model, axial.hand, rtol=0.01)


def test_a_tube_carries_force_over_the_area_of_its_ring_pushed_as_pulled(solved):
    """pi/4 (20^2 - 15^2) = 137.4 mm2."""
    pushed = {name: [(-fx, fy, mz) for fx, fy, mz in rows] for name, rows in PULLED.items()}
    for wrenches, sign in ((PULLED, 1), (pushed, -1)):
        axial = checks_of(solved, ROD, wrenches)["axial stress"]
        assert_allclose(axial.hand, sign * 9000 / (np.pi / 4 * 175))
        assert_allclose(axial.model, axial.hand, rtol=0.01)


@pytest.mark.parametrize(
    ("shape", "modulus"),
    [(LINK, 8 * 30**2 / 6), (ROD, np.pi * (20**4 - 15**4) / 32 / 20)],
)
def test_a_link_held_in_its_first_hole_is_bent_by_force_times_half_its_length(
    solved, shape, modulus
):
    """300 N across the second pin: M = 30 N m at mid-length."""
    wrenches = {"first": [(0.0, -300.0, -60e3)], "second": [(0.0, 300.0, 0.0)]}
    found = checks_of(solved, shape, wrenches)
    assert "axial stress" not in found
    bending = found["bending stress"]
    assert_allclose(bending.hand, 30e3 / modulus, rtol=1e-9)
    assert_allclose(bending.model, bending.hand, rtol=0.01)


def test_the_own_inertia_of_a_turning_link_is_in_both_numbers(solved):
    """1000 rad/s about the first pin, 1e6 rad/s2 faster every second.

    An even bar from the first to the second pin: at mid-length rho omega^2 int_{L/2}^{L} x dx =
    117.75 MPa, and the moment rho A alpha int x (x - L/2) dx. The half disc beyond the second pin,
    4 R/(3 pi) beyond it, less the hole, pulls on one side of the middle: half of it is in the mean
    of both sides, all of it in the model. Rotary inertia of the width: 1.5 % in bending.
    """
    mass = solved[LINK].mesh.mass_properties(STEEL.density)
    omega2, alpha = 1e6, 1e6
    pull = mass.mass * mass.centre[0] * omega2
    about = (mass.inertia + mass.mass * mass.centre[0] ** 2) * alpha
    across = mass.mass * mass.centre[0] * alpha
    found = checks_of(
        solved,
        LINK,
        {"first": [(-pull, across, about)], "second": [(0.0, 0.0, 0.0)]},
        [(0.0, 0.0, alpha, omega2)],
    )
    axial, bending = found["axial stress"], found["bending stress"]
    disc, hole, x = np.pi * 15**2 / 2 / 30, np.pi * 6**2 / 30, 200 + 4 * 15 / (3 * np.pi)
    pulls = STEEL.density * omega2 * np.array([(200**2 - 100**2) / 2, disc * x - hole * 200])
    assert_allclose(axial.hand, pulls @ [1, 0.5], rtol=0.005)
    assert_allclose(axial.model, pulls @ [1, 1], rtol=0.02)
    moments = [833333.3, disc * x * (x - 100) - hole * 200 * 100]
    bends = STEEL.density * 240 * alpha / 1200 * np.array(moments)
    assert_allclose(bending.hand, bends @ [1, 0.5], rtol=0.02)
    assert_allclose(bending.model, bends @ [1, 1], rtol=0.02)


BENT = {"first": [(0.0, -300.0, -60e3)], "second": [(0.0, 300.0, 0.0)]}
BLOCK = -100.0 * 220 / 60
SLID = {
    "tip": [(0.0, 100.0, 0.0)],
    "slot": [(0.0, BLOCK, BLOCK * 60)],
    "pivot": [(0.0, -100.0 - BLOCK, 0.0)],
}


@pytest.mark.parametrize(
    ("shape", "wrenches", "reaches", "ratios"),
    [
        (LINK, PULLED, None, {"first": (0.95, 1.05), "second": (0.95, 1.05)}),
        (LINK, BENT, None, {"first": (0.95, 1.05), "plate": (1.0, 1.25)}),
        (ROD, PULLED, None, {"first": (0.96, 1.04), "tube": (0.98, 1.02)}),
        (LEVER, SLID, {"slot": [60.0]}, {"slot's end": (0.6, 1.0), "rail": (0.95, 1.1)}),
    ],
)
def test_the_rung_formula_stands_beside_the_solid_at_its_named_places(
    solved, shape, wrenches, reaches, ratios
):
    """Solid over formula: bores of links within 5 %, of rods 4 %; clamped is the rail's end."""
    found = checks_of(solved, shape, wrenches, reaches=reaches)
    for name, (low, high) in ratios.items():
        peak = found[f"peak von Mises stress by formula: {name}"]
        assert low < peak.model / peak.hand < high, name
    assert all(one.hand > 0 for name, one in found.items() if name.startswith("peak"))


def test_a_pin_in_a_stack_has_its_rung_beside_the_solid():
    """At the crank's edge M = 400 N x 5.5 mm, to the rod's middle: 32 M/(pi d^3) = 22.4 MPa."""
    seats = (
        Seat("crank", at=0.0, width=10.0, single=True),
        Seat("rod", at=10.5, width=10.0, single=True),
    )
    pin = Pin(seats=seats, diameter=10.0)
    loads = loads_of({"crank": [(-400.0, 0.0, 0.0)], "rod": [(400.0, 0.0, 0.0)]})
    loads.wrenches["crank"][0, 4] = -4200.0
    elastic = Elastic(STEEL.youngs_modulus, STEEL.poisson_ratio, STEEL.density)
    solutions = solve_unit_loads(mesh_shape(pin, fineness=0.7), elastic)
    level = solve_level(solutions, 0.7, loads, 100.0, STEEL.ultimate_stress, {})
    part = SimpleNamespace(geometry=pin, material=STEEL, body=None)
    found = {one.quantity.split(": ")[1]: one for one in hand_checks(part, loads, level)}
    assert_allclose(found["crank on the pin"].hand, 32 * 2200 / (np.pi * 1000), rtol=0.01)
    assert_allclose(found["crank on the pin"].model, found["crank on the pin"].hand, rtol=0.1)
