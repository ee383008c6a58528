"""Slider-crank, four-bar linkage and toggle with exact values (ten digits, closed forms)."""

from math import pi, radians, tan

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads import (
    GROUND,
    Angle,
    Body,
    Force,
    Linkage,
    LinkageError,
    PointCoordinate,
    Prismatic,
    Revolute,
    solve_forces,
)

from .machines import at_state, four_bar, slider_crank

LAST_DIGIT = 1e-7  # the references are printed with eight digits


def test_slider_crank_motion_forces_and_torque():
    """Closed form and Newton-Euler: crank 50 mm, rod 200 mm, 60 deg, 100 rad/s, 1500 N (metres)."""
    linkage = slider_crank(
        0.05,
        0.2,
        0.0,
        None,
        {"mass": 0.8, "inertia": 0.004, "centre": (0.2 / 3, 0.0)},
        1.2,
        at=pi / 3,
    )
    motion = at_state(linkage, Angle("crank"), pi / 3, 100.0)
    solution = solve_forces(motion, {"push": -1500.0}, "drive")
    found = [
        motion.poses[0, 3, 0],
        np.degrees(motion.poses[0, 2, 2]),
        motion.velocities[0, 3, 0],
        motion.accelerations[0, 3, 0],
        motion.velocities[0, 2, 2],
        motion.accelerations[0, 2, 2],
        *solution.joints["B"].force[0],
        *solution.joints["A"].force[0],
        solution.joints["guide"].force[0, 1],
        solution.efforts["drive"][0],
    ]
    expected = [
        0.22025624,
        -12.503917,
        -4.884543,
        -187.55578,
        -12.803688,
        2181.3087,
        1274.9331,
        -236.88984,
        1091.5848,
        -467.82995,
        236.88984,
        -58.962759,
    ]
    assert_allclose(found, expected, rtol=LAST_DIGIT)


def test_four_bar_kinematics_of_the_open_branch():
    """Norton's example: 40, 120, 80, 100 mm, 40 deg, 25 rad/s, 15 rad/s2."""
    linkage = four_bar(40.0, 120.0, 80.0, 100.0)
    motion = at_state(linkage, Angle("crank"), radians(40), 25.0, 15.0)
    assert_allclose(np.degrees(motion.poses[0, 2:, 2]), [20.297883, 57.32488], rtol=LAST_DIGIT)
    assert_allclose(motion.velocities[0, 2:, 2], [-4.1209144, 6.9979852], rtol=LAST_DIGIT)
    assert_allclose(motion.accelerations[0, 2:, 2], [296.08919, 470.13353], rtol=LAST_DIGIT)


def test_four_bar_takes_the_branch_it_is_assembled_in():
    """The crossed branch is the mirror image at the diagonal: both close, only one is asked for."""
    linkage = four_bar(40.0, 120.0, 80.0, 100.0, side=-1)
    motion = at_state(linkage, Angle("crank"), radians(40), 25.0, 15.0)
    assert_allclose(np.degrees(motion.poses[0, 2, 2]), -60.98, atol=0.01)


def test_four_bar_joint_forces_and_torque():
    """Newton-Euler, equal to the power balance; torque -5 N m on the rocker (metres)."""
    masses = {"crank": (0.2, 5e-5), "coupler": (0.6, 8e-4), "rocker": (0.4, 3e-4)}
    linkage = four_bar(0.04, 0.12, 0.08, 0.1, masses)
    motion = at_state(linkage, Angle("crank"), radians(40), 25.0, 15.0)
    solution = solve_forces(motion, {"load": -5.0}, "drive")
    found = [solution.efforts["drive"][0]]
    for name in ("O2", "A", "B", "O4"):
        found += list(solution.joints[name].force[0])
    expected = [
        1.8514982,
        -128.3259,
        -47.239549,
        126.37222,
        45.678543,
        110.37908,
        46.097719,
        103.62434,
        49.499183,
    ]
    assert_allclose(found, expected, rtol=LAST_DIGIT)


def slider_toggle(angle):
    """Two links of 100 mm from a pivot to a slider; Q presses the knee, the slider holds."""
    c, s = 100.0 * np.cos(angle), 100.0 * np.sin(angle)
    return Linkage(
        bodies=(
            Body(GROUND, {"O": (0.0, 0.0)}),
            Body("first", {"O": (0.0, 0.0), "K": (100.0, 0.0)}),
            Body("second", {"K": (0.0, 0.0), "S": (100.0, 0.0)}),
            Body("slider", {"S": (0.0, 0.0)}),
        ),
        joints=(
            Revolute("O", GROUND, "first", "O"),
            Revolute("K", "first", "second", "K"),
            Revolute("S", "second", "slider", "S"),
            Prismatic("guide", GROUND, "slider", "O", "S", (1.0, 0.0)),
        ),
        forces=(
            Force("knee", PointCoordinate("first", "K", (0.0, -1.0))),
            Force("hold", PointCoordinate("slider", "S", (-1.0, 0.0))),
        ),
        assembled={"first": (0, 0, angle), "second": (c, s, -angle), "slider": (2 * c, 0, 0)},
        gravity=(0.0, 0.0),
    )


@pytest.mark.parametrize("degrees", [10.0, 1.0, 0.1, 0.01, 0.001])
def test_toggle_force_close_to_dead_centre(degrees):
    """Q / (2 tan phi), closed form, kept to 1e-9 down to 0.001 deg."""
    angle = radians(degrees)
    motion = at_state(slider_toggle(radians(5.0)), Angle("first"), angle, 1.0, direction=-1)
    solution = solve_forces(motion, {"knee": 100.0}, "hold")
    assert_allclose(solution.efforts["hold"], 50.0 / tan(angle), rtol=1e-9)


def test_a_dead_centre_is_refused_instead_of_a_huge_number():
    """phi = 0: the slider stands still, no force on it balances the knee."""
    motion = at_state(slider_toggle(radians(5.0)), Angle("first"), 0.0, 1.0, direction=-1)
    with pytest.raises(LinkageError, match=r"'hold' cannot balance .* -S\.x stands still there"):
        solve_forces(motion, {"knee": 100.0}, "hold")
