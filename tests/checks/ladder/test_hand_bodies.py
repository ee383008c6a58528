"""Hand checks of links, rods, levers and pins beside their meshed parts, loaded by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.design.materials import known_materials
from checks.ladder.hand_bodies import lever_hand_checks, link_hand_checks
from checks.ladder.hand_calculations import hand_checks
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
    hand = lever_hand_checks if shape is LEVER else link_hand_checks
    return {check.quantity.split(" at ")[0]: check for check in hand(shape, loads, level)}


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
    assert list(found) == ["bending stress"]
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


def test_beside_a_pulled_hole_the_peak_is_petersons_and_more_in_a_round_end(solved):
    """u = 0.4: Kt = 2.85 on 9000 N / (18 x 8 mm2) = 178 MPa; a round end has 20 to 30 % more."""
    found = checks_of(solved, LINK, PULLED)
    lugs = [check for name, check in found.items() if name.startswith("peak beside")]
    assert len(found) == 2
    (peak,) = lugs
    factor = 12.882 - 52.714 * 0.4 + 89.762 * 0.16 - 51.667 * 0.064
    assert_allclose(peak.hand, factor * 9000 / 144, rtol=1e-9)
    assert 1.1 < peak.model / peak.hand < 1.35


@pytest.mark.parametrize(("fx", "fy"), [(-3000.0, 0.0), (3000.0, 600.0)])
def test_a_hole_that_is_pushed_or_pulled_askew_has_no_such_peak(solved, fx, fy):
    wrenches = {"first": [(-fx, -fy, -200 * fy)], "second": [(fx, fy, 0.0)]}
    found = checks_of(solved, LINK, wrenches)
    assert not [name for name in found if name.startswith("peak")]


def test_the_strips_beside_a_slot_carry_its_moment_together(solved):
    """100 N at the tip, the block at 60 mm: half-way to 186 mm, M = 100 N x 97 mm = 9.7 N m.

    Two strips of 9 x 8 mm, 21 mm apart: I = 72 x 21^2 / 2 + 2 x 8 x 9^3 / 12 = 16848 mm4.
    """
    force = 100.0
    block = -force * 220 / 60
    wrenches = {
        "tip": [(0.0, force, 0.0)],
        "slot": [(0.0, block, block * 60)],
        "pivot": [(0.0, -force - block, 0.0)],
    }
    found = checks_of(solved, LEVER, wrenches, reaches={"slot": [60.0]})
    (strips,) = found.values()
    assert_allclose(strips.hand, 9700 * 10.5 / 16848, rtol=1e-9)
    assert_allclose(strips.model, strips.hand, rtol=0.03)
    assert "x = 123.0 mm" in strips.formula


def test_a_pin_in_single_shear_strains_as_even_pressures_bend_it():
    """400 N, 10.5 mm beside the lug of 10 mm that holds it: the crank gives -40 N/mm, and back the
    couple of 4.2 N m by 50.4 s N/mm2, s from its middle. The moment's extreme in it: 2.50 N m at
    s = 3.41 mm; 25.5 MPa in 10 mm. A coarse mesh, and pressures across the pin: 5 %.
    """
    seats = (
        Seat("crank", at=0.0, width=10.0, single=True),
        Seat("rod", at=10.5, width=10.0, single=True),
    )
    pin = Pin(seats=seats, diameter=10.0)
    s = np.linspace(-5, 5, 100_001)
    moment = -20 * (s + 5) ** 2 + 4200 * (s + 5) ** 2 * (10 - s) / 500
    loads = loads_of({"crank": [(-400.0, 0.0, 0.0)], "rod": [(400.0, 0.0, 0.0)]})
    loads.wrenches["crank"][0, 4] = -4200.0
    elastic = Elastic(STEEL.youngs_modulus, STEEL.poisson_ratio, STEEL.density)
    solutions = solve_unit_loads(mesh_shape(pin, fineness=0.7), elastic)
    level = solve_level(solutions, 0.7, loads, 100.0, STEEL.ultimate_stress, {})
    (found,) = hand_checks(SimpleNamespace(geometry=pin), loads, level)
    assert_allclose(found.hand, 32 * np.abs(moment).max() / (np.pi * 1000), rtol=5e-3)
    assert found.quantity.endswith("z = 3.44 mm")
    assert_allclose(found.model, found.hand, rtol=0.05)
