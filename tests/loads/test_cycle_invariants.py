"""Invariants over a whole cycle of each of the four machines, whatever the numbers (SI units)."""

import numpy as np
import pytest

from loads import Angle, Cycle, Phase, SteadyPace, move, run_cycle, trace

from .machines import HAMMER, QUICK_RETURN, hammer, press_cycle, quick_return, slider_crank, toggle

CRANK = Angle("crank")
ROUGH = {"mu_guide": 0.1, "mu_slot": 0.12, "mu_pin": 0.1, "r_pin": 0.01}
SLIDER_CRANK = {
    "crank": 0.1,
    "rod": 0.15,
    "offset": 0.025,
    "crank_body": {"mass": 0.058241, "inertia": 4.853416667e-05, "centre": (0.05, 0.0)},
    "rod_body": {"mass": 0.085241, "inertia": 0.000159826875, "centre": (0.075, 0.0)},
    "slider_mass": 0.069621,
    "gravity": (0.0, -9.81),
}


def press(rough):
    friction = {"mu_pin": 0.1, "r_pin": 0.02, "mu_guide": 0.1} if rough else {}
    return toggle(0.5, 0.35, 4.14134, 10.0, 0.02156947917, 9.81, **friction)


MACHINES = {
    "slider_crank": lambda rough: slider_crank(**SLIDER_CRANK, mu_slider=0.15 * rough, at=0.3),
    "hammer": lambda rough: hammer(HAMMER | (ROUGH if rough else {}), at=0.3),
    "quick_return": lambda rough: quick_return(QUICK_RETURN | (ROUGH if rough else {}), at=0.3),
}


def turn(linkage, speed=5.0, force=-150.0, start=0.3, n_positions=721):
    """One turn of the crank at a speed under a constant force on what the machine drives."""
    other = linkage.forces[1].name
    phase = Phase("turn", start + 2 * np.pi, {other: force}, "drive")
    return Cycle("turn", CRANK, start, SteadyPace(CRANK, speed), (phase,), n_positions)


def whole_cycle(machine, rough):
    if machine == "toggle":
        return run_cycle(press(rough), press_cycle(press(rough), h=0.5, speed=0.1))
    linkage = MACHINES[machine](rough)
    return run_cycle(linkage, turn(linkage))


@pytest.fixture(scope="module", params=["toggle", *MACHINES])
def smooth(request):
    return whole_cycle(request.param, rough=False)


def test_power_is_balanced_at_every_position(smooth):
    """Efforts and gravity less the rate of kinetic energy; measured below 1e-15 of the turnover."""
    assert smooth.power_balance_error < 1e-13


def test_every_body_is_in_equilibrium_to_rounding(smooth):
    """Measured below 5e-16 of the largest force."""
    assert max(smooth.equilibrium_residual.values()) < 1e-13


def test_joints_stay_closed(smooth):
    """Measured below 5e-16 m on machines of 0.3 to 1.9 m."""
    assert smooth.constraint_residual < 1e-14


@pytest.mark.parametrize("machine", ["toggle", *MACHINES])
def test_with_friction_too_power_is_balanced_and_friction_only_takes(machine):
    """Reactions and friction are solved together, to 1e-13: measured below 1e-14."""
    loads = whole_cycle(machine, rough=True)
    assert loads.power_balance_error < 1e-12
    assert max(loads.equilibrium_residual.values()) < 1e-12
    for joint in loads.linkage.joints:
        load = loads.reactions[joint.name]
        b, a = loads.body_index(joint.body_b), loads.body_index(joint.body_a)
        turning = loads.velocities[:, b, 2] - loads.velocities[:, a, 2]
        assert (load.friction_couple * turning <= 0.0).all()


@pytest.mark.parametrize("machine", ["toggle", *MACHINES])
def test_velocities_and_accelerations_are_differences_of_positions(machine):
    """Central differences of order 8 over equal steps in time, at 60 places of the cycle.

    Both shrink to the rounding of positions, over h and over h**2, times the size (radians and
    metres alike). Measured 2e-11 (truncation, quick return) and 2e-10 of the largest.
    """
    if machine == "toggle":
        linkage = press(rough=False)
        coordinate = linkage.force("cylinder").coordinate
        low, high, speed, step = 0.38, 0.56, 0.1, 1e-3
    else:
        linkage, coordinate = MACHINES[machine](rough=False), CRANK
        low, high, speed, step = 0.3, 0.3 + 2 * np.pi, 5.0, 8e-3
    path = trace(linkage, coordinate, low - 5 * step, high + 5 * step)
    centres = np.linspace(low, high, 60)
    grid = centres[:, None] + step * np.arange(-4, 5)
    poses = path.at(grid.ravel()).poses.reshape(60, 9, -1)
    motion = move(path.at(centres), coordinate, speed, 1)
    first = np.array([3, -32, 168, -672, 0, 672, -168, 32, -3]) / 840
    second = np.array([-9, 128, -1008, 8064, -14350, 8064, -1008, 128, -9]) / 5040
    for found, weights, power, allowed in (
        (motion.velocities, first, 1, 1e-10),
        (motion.accelerations, second, 2, 1e-9),
    ):
        expected = np.einsum("k,nkj->nj", weights, poses) * (speed / step) ** power
        largest = np.abs(expected).max()
        assert np.abs(found.reshape(60, -1) - expected).max() < allowed * largest
