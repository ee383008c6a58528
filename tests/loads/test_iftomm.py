"""Planar benchmarks of IFToMM's library of multibody problems, led through their free motion.

Statements as published by the Laboratorio de Ingeniería Mecánica, Universidade da Coruña,
lim.ii.udc.es/mbsbenchmark/dist: A01 (simple pendulum: 1 kg on a massless link of 1 m, 9.81 N/kg,
released at rest from the horizontal) and A02 (N four-bar linkages: 2 N + 1 links of 1 m with 1 kg
each, evenly spread; at the start the cranks are upright and B0 moves at 1 m/s along x). A03,
Andrews' squeezer, stands in test_andrews.py; where A02 folds in test_change_points.py. A04 and A05
are spatial. The published time histories could not be opened. A free motion needs no drive: led at
the speed and acceleration that conservation of energy gives in closed form, the torque must vanish.
"""

from math import cos, radians, sin, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads import GROUND, Angle, Body, Force, Linkage, Revolute, solve_forces

from .machines import at_state, parallel_four_bars

LENGTH, MASS, G = 1000.0, 1e-3, 9810.0  # mm, t, mm/s2
WEIGHT = MASS * G


def pendulum(at):
    """A01; the angle is that from the x axis to the link, which is at -90 degrees at its lowest."""
    return Linkage(
        bodies=(
            Body(GROUND, {"O": (0.0, 0.0)}),
            Body("link", {"O": (0.0, 0.0)}, MASS, 0.0, (LENGTH, 0.0)),
        ),
        joints=(Revolute("O", GROUND, "link", "O"),),
        forces=(Force("drive", Angle("link", point="O")),),
        assembled={"link": (0.0, 0.0, at)},
        gravity=(0.0, -G),
    )


@pytest.mark.parametrize("below", [1.0, 20.0, 45.0, 90.0, 135.0, 179.0])
def test_a_pendulum_swings_without_a_drive_and_pulls_three_times_as_much(below):
    """Released from the horizontal: m l w^2 = 2 m g sin, and its weight's m g sin on top of it."""
    angle = radians(below)
    speed = sqrt(2 * G / LENGTH * sin(angle))
    rate = G / LENGTH * cos(angle)  # of the speed, along the way
    motion = at_state(pendulum(-angle), Angle("link"), -angle, speed, rate, direction=-1)
    solved = solve_forces(motion, {}, "drive")
    assert abs(solved.efforts["drive"][0]) < 1e-9 * WEIGHT * LENGTH
    assert np.hypot(*solved.joints["O"].force[0]) == pytest.approx(
        3 * WEIGHT * sin(angle), rel=1e-9
    )


@pytest.mark.parametrize(
    ("n", "at"), [(1, 60.0), (1, 10.0), (2, 90.0), (2, 60.0), (2, 10.0), (40, 60.0)]
)
def test_four_bars_side_by_side_fall_without_a_drive(n, at):
    """n + 1 cranks turn (m l^2 / 3 each), n couplers follow them (m l^2 each): closed form.

    w^2 = w0^2 + 2 (n + (n + 1) / 2) m g l (1 - sin) / J from upright.
    """
    angle = radians(at)
    inertia = ((n + 1) / 3 + n) * MASS * LENGTH**2
    lever = (n + (n + 1) / 2) * WEIGHT * LENGTH
    speed = sqrt(1.0 + 2 * lever * (1 - sin(angle)) / inertia)
    motion = at_state(
        parallel_four_bars(n, angle), Angle("C0"), angle, speed, lever * cos(angle) / inertia,
        direction=-1,
    )  # fmt: skip
    solved = solve_forces(motion, {}, "drive")
    assert abs(solved.efforts["drive"][0]) < 1e-9 * lever
    assert_allclose(motion.velocities[0, 1, 2], -speed, rtol=1e-12)
