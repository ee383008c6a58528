"""A crank pin in the slot of a swinging lever: the one joint whose line turns."""

import numpy as np
from numpy.testing import assert_allclose

from loads import (
    GROUND,
    Angle,
    Body,
    Cycle,
    Force,
    Friction,
    Linkage,
    Phase,
    Revolute,
    Slot,
    SteadyPace,
    run_cycle,
)

RADIUS, BASE, SPEED = 70.0, 110.0, 4.0


def lever(mass=0.0, coefficient=0.0):
    """Crank about (110, 0), lever about the origin, with the crank's pin in its slot."""
    return Linkage(
        bodies=(
            Body(GROUND, {"O1": (0.0, 0.0), "O2": (BASE, 0.0)}),
            Body("crank", {"O2": (0.0, 0.0), "a": (RADIUS, 0.0)}, mass, 100 * mass, (20.0, 5.0)),
            Body("lever", {"O1": (0.0, 0.0)}, mass, 3000 * mass, (100.0, -7.0)),
        ),
        joints=(
            Revolute("O1", GROUND, "lever", "O1"),
            Revolute("O2", GROUND, "crank", "O2"),
            Slot("slot", "lever", "crank", "O1", "a", (1.0, 0.0)),
        ),
        forces=(
            Force("drive", Angle("crank", point="O2")),
            Force("load", Angle("lever", point="O1")),
        ),
        assembled={"crank": (BASE, 0.0, 0.0), "lever": (0.0, 0.0, 0.0)},
        friction={"slot": Friction(coefficient)},
    )


def turn(linkage):
    crank = Angle("crank")
    phase = Phase("turn", 2 * np.pi, {"load": -5000.0}, "drive")
    return run_cycle(linkage, Cycle("turn", crank, 0.0, SteadyPace(crank, SPEED), (phase,), 120))


def test_the_lever_turns_as_its_closed_form_says():
    """w1 = r w (r + d cos) / L2 and its derivative, L2 = r2 + d2 + 2 r d cos (law of cosines)."""
    loads = turn(lever())
    c, s = np.cos(loads.positions), np.sin(loads.positions)
    square = RADIUS**2 + BASE**2 + 2 * RADIUS * BASE * c
    omega = RADIUS * SPEED * (RADIUS + BASE * c) / square
    alpha = RADIUS * BASE * SPEED**2 * s * (RADIUS**2 - BASE**2) / square**2
    assert_allclose(loads.velocities[:, 2, 2], omega, atol=1e-11)
    assert_allclose(loads.accelerations[:, 2, 2], alpha, atol=1e-10)
    # massless and without friction: the torques' powers cancel, the pin pushes across the slot
    assert_allclose(loads.efforts["drive"], 5000.0 * omega / SPEED, atol=1e-7)
    push = np.hypot(*loads.reactions["slot"].force.T)
    assert_allclose(push, 5000.0 / np.sqrt(square), rtol=1e-10)


def test_a_heavy_lever_with_friction_is_in_equilibrium_and_balances_power():
    """The slot's force acts on the lever where the pin is, though stated at the lever's pivot."""
    loads = turn(lever(mass=1e-3, coefficient=0.12))
    assert max(loads.equilibrium_residual.values()) < 1e-11
    assert loads.power_balance_error < 1e-11
    normal = np.hypot(*loads.reactions["slot"].force.T) / np.hypot(1.0, 0.12)
    rubbing = np.abs(loads.reactions["slot"].friction_force)
    sliding = rubbing > 0.0
    assert sliding.sum() > 0.9 * len(sliding)
    assert_allclose(rubbing[sliding], 0.12 * normal[sliding], rtol=1e-10)
    history = loads.part_history("lever", {"pivot": "O1"})
    body = loads.linkage.body("lever")
    left = history.equilibrium_residual(body.mass, body.centre, body.inertia)
    assert np.abs(left).max() < 1e-10 * np.abs(history.wrenches).max()
