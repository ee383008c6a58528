"""Solids that buckle in the plane of their pins: a pin's push goes through its axis.

A round rod of 14 mm between two eyes of 40 mm, 160 mm apart, whose holes are half of that. Its eyes
are rigid up to b, where the rod meets the balls, and the push passes a mm from the pin's axis as
the eye turns by 1 rad, a = 0 where it goes through the axis:

    cot(k (L/2 - b)) = k (b - a),   P = E I k^2
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from fem.buckling import (
    part_buckling,
    pins_pressing,
    round_contacts,
    shares_of,
    solid_buckling,
    worst_buckling,
)
from fem.mode_count import link_solid, surface_weights
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.meshing import mesh_shape
from geometry.parts import TubeRod

from .blocks import wrench

STEEL = Elastic(210e3, 0.3, 7.85e-9)
ROD = TubeRod(
    length=160, tube_diameter=14, wall=None, eye_diameter=40, eye_width=30, hole=20, fillet=2
)
RADIUS = ROD.hole / 2


def critical(beside):
    """Load of the rod with rigid eyes, N; beside (mm) as `a` above."""
    inertia, rigid = np.pi / 64 * 14**4, np.sqrt(20**2 - 7**2)
    free = ROD.length / 2 - rigid
    x = brentq(lambda x: np.cos(x) - np.sin(x) * x * (rigid - beside) / free, 0.1, 3.0)
    euler = STEEL.youngs_modulus * inertia * (x / free) ** 2
    return euler / (1 + euler / (0.9 * STEEL.youngs_modulus / 2.6 * np.pi / 4 * 14**2))


@pytest.fixture(scope="module")
def rod():
    return solve_unit_loads(mesh_shape(ROD, fineness=0.7), STEEL)


@pytest.fixture(scope="module")
def pushed(rod):
    wrenches = {"first": wrench(1.0), "second": wrench(-1.0)}
    return rod.coefficients(wrenches, np.zeros((1, 4)))[0][:, 0]


@pytest.fixture(scope="module")
def dead(rod, pushed):
    """Its buckling if the pressure turned with the bores."""
    solid = link_solid(rod, tilt_held=False, what="buckling")
    moved = (rod.displacement @ pushed)[:, None]
    return solid_buckling(solid, rod.recovery.quadrature_stress(moved, slice(None))[..., 0])


def by_plane(found):
    return {mode.plane: mode.factor for mode in reversed(found.modes)}


def virials(rod, state):
    return [one.virials @ state[one.columns] for one in round_contacts(rod)]


def test_the_virial_of_a_half_cosine_is_4_over_pi_of_force_and_radius(rod, pushed):
    """Radius times the integral of the pressure, 4/pi of its resultant, whichever way it acts."""
    assert_allclose(virials(rod, pushed), 4 / np.pi * RADIUS, rtol=1e-4)
    pulled = rod.coefficients({"first": wrench(-1.0), "second": wrench(1.0)}, np.zeros((1, 4)))[0]
    assert_allclose(virials(rod, pulled[:, 0]), 4 / np.pi * RADIUS, rtol=1e-4)


def test_with_its_pins_no_motion_gives_the_loads_a_moment_about_an_axis(rod, pushed):
    """A turn of one bore's points works on any motion: on the moment that the loads have lost.

    It is that about the mean of the moved bore. A shift of the bore's points works on none.
    """
    pins = pins_pressing(rod, pushed)
    motion = np.random.default_rng(1).standard_normal((len(rod.loads) // 3, 3))
    answer = pins.times(motion.reshape(-1, 1)).reshape(-1, 3)
    for loads, contact in zip(rod.interfaces, round_contacts(rod), strict=True):
        x, y, _ = (rod.mesh.nodes - loads.interface.centre).T
        near = np.abs(np.hypot(x, y) - RADIUS) < 1e-3
        force = (rod.loads[:, contact.columns] @ pushed[contact.columns]).reshape(-1, 3)
        axis = surface_weights(rod.elements, loads.interface.name) @ motion
        moved = motion - axis
        lost = (moved[:, 1] @ force[:, 0]) - (moved[:, 0] @ force[:, 1])
        turned = x[near] @ answer[near, 1] - y[near] @ answer[near, 0]
        assert_allclose(turned, lost, rtol=1e-6)
        assert_allclose(answer[near].sum(axis=0), 0.0, atol=1e-6 * abs(lost))


def test_a_thick_eyed_rod_buckles_in_the_plane_as_from_pin_to_pin(rod, pushed, dead):
    """It is softer by 1 % than with rigid eyes, alike in both planes: their ratio within 1 %.

    Pressure that turned with the bores would stand 4/pi r beside the axis: 38 % more.
    """
    found = part_buckling(rod, pushed, tilt_held=False)
    factors = by_plane(found)
    pinned, turning = critical(0.0), critical(4 / np.pi * RADIUS)
    tilting = critical(8 / (3 * np.pi) * RADIUS)
    assert found.modes[0].plane == "in plane"
    assert_allclose(factors["in plane"], pinned, rtol=0.02)
    assert_allclose(factors["in plane"] / factors["out of plane"], pinned / tilting, rtol=0.01)
    assert_allclose(by_plane(dead)["in plane"] / factors["in plane"], turning / pinned, rtol=0.01)
    assert found.proven > found.modes[1].factor


def test_out_of_the_plane_the_pins_press_where_they_did(rod, pushed, dead):
    found = by_plane(part_buckling(rod, pushed, tilt_held=False))
    assert_allclose(found["out of plane"], by_plane(dead)["out of plane"], rtol=2e-4)


@pytest.mark.slow
def test_a_push_all_round_the_bore_needs_no_correction(rod, pushed):
    """Pressure in proportion to cos goes through the axis by itself, even if it turns: no virial.

    In front it presses, behind it pulls, half of the force each, and so the rod buckles alike.
    """
    round_about = pushed.copy()
    for loads, contact in zip(rod.interfaces, round_contacts(rod), strict=True):
        own = round_about[contact.columns]
        own[[k for k, name in enumerate(loads.names) if name not in ("cos 1", "sin 1")]] = 0.0
    assert np.abs(virials(rod, round_about)).max() < 1e-2
    ours = by_plane(part_buckling(rod, pushed, tilt_held=False))["in plane"]
    even = by_plane(part_buckling(rod, round_about, tilt_held=False))["in plane"]
    assert_allclose(even, ours, rtol=0.01)


@pytest.mark.slow
def test_positions_are_judged_with_their_pins(rod, pushed):
    """Of its own mode a position's estimate is the mode's share; the larger push is found."""
    states = np.stack([0.5 * pushed, -pushed, pushed], axis=1)
    found = part_buckling(rod, pushed, tilt_held=False)
    own = np.stack([mode.shape.ravel() for mode in found.modes], axis=1)
    share = 1 / found.modes[0].factor
    assert_allclose(shares_of(rod, states, own)[[0, 2]], [0.5 * share, share], rtol=1e-6)
    position, worst = worst_buckling(rod, states, [0], tilt_held=False)
    assert position == 2
    assert_allclose(worst.modes[0].factor, found.modes[0].factor, rtol=1e-6)
