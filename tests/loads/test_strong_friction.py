"""Friction that carries a good part of the load: the one solution that grows out of none."""

from dataclasses import replace
from math import cos, hypot, pi, sin

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import fsolve

from loads import Angle, Friction, LinkageError, move, solve_forces, trace

from .machines import slider_crank

CRANK_RADIUS, ROD_MASS, ROD_CENTRE = 50.0, 1e-2, 20.0

# crank angle, rod, offset, coefficient and radius of the pins, of the guide, N on the slider
ROUGH = [
    (1.86, 76.0, 3.0, 1.10, 25.0, 1.08, 13.0),
    (3.18, 77.0, 16.0, 0.87, 44.0, 1.35, 58.0),
    (2.29, 94.0, 25.0, 1.24, 57.0, 0.15, 14.0),
    (3.43, 89.0, 23.0, 1.31, 59.0, 1.32, -12.0),
]


def torque_by_hand(angle, rod, offset, mu, radius, mu_guide, push, steps=400):
    """Torque that turns the crank on slowly, friction grown in small steps (own equations, fsolve).

    Unknown: force of crank on rod at A, of rod on slider at B, normal force of the guide, torque.
    Every couple and force of friction is against the sliding of the body it acts on.
    """
    a = np.array([CRANK_RADIUS * cos(angle), CRANK_RADIUS * sin(angle)])
    b = np.array([a[0] + np.sqrt(rod**2 - (offset - a[1]) ** 2), offset])
    along = (b - a) / rod
    rod_turns = -a[0] / (b[0] - a[0])  # B keeps its height while A rises by a[0]
    slides = -a[1] - rod_turns * (b[1] - a[1])
    weight = np.array([0.0, -ROD_MASS * 9810.0])

    def moment(arm, force):
        return arm[0] * force[1] - arm[1] * force[0]

    def left(unknown, share):
        at_a, at_b, normal, torque = unknown[:2], unknown[2:4], unknown[4], unknown[5] * 50.0
        couple = share * mu * radius
        on_rod = -couple * hypot(*at_a) * np.sign(rod_turns - 1.0)
        on_slider = couple * hypot(*at_b) * np.sign(rod_turns)
        on_crank = -couple * hypot(*at_a)  # of the ground: its force is that of the pin A
        rubbed = share * mu_guide * abs(normal) * np.sign(slides)
        turning = moment(along * ROD_CENTRE, weight) - moment(b - a, at_b) + on_rod - on_slider
        return [
            *(at_a - at_b + weight),
            turning / 50.0,
            at_b[0] + push - rubbed,
            at_b[1] + normal,
            (torque - moment(a, at_a) - on_rod + on_crank) / 50.0,
        ]

    unknown = np.ones(6)
    for share in np.linspace(0.0, 1.0, steps + 1):
        unknown, _, flag, message = fsolve(left, unknown, (share,), full_output=True, xtol=1e-13)
        assert flag == 1 or np.abs(left(unknown, share)).max() < 1e-9, message
    return unknown[5] * 50.0


def rough(angle, rod, offset, mu, radius, mu_guide):
    linkage = slider_crank(
        CRANK_RADIUS, rod, offset=offset, at=angle, gravity=(0.0, -9810.0),
        rod_body={"mass": ROD_MASS, "centre": (ROD_CENTRE, 0.0)},
    )  # fmt: skip
    pins = {name: Friction(mu, radius) for name in "OAB"}
    linkage = replace(linkage, friction={**pins, "guide": Friction(mu_guide)})
    crank = Angle("crank")
    path = trace(linkage, crank, angle - 0.01, angle + 0.01)
    return move(path.at(np.array([angle])), crank, 1e-6, 1)


@pytest.mark.parametrize("case", ROUGH, ids=lambda case: f"{case[0]}")
def test_friction_is_grown_to_the_solution_that_belongs_to_none(case):
    """In one step Newton's method leaves that branch and would tell of self-locking."""
    *given, push = case
    torque = solve_forces(rough(*given), {"push": push}, "drive").efforts["drive"]
    assert_allclose(torque, torque_by_hand(*case), rtol=1e-7)


def test_more_of_it_locks():
    """Friction circles of mu r = 90 mm around pins that are 50 mm apart."""
    with pytest.raises(LinkageError, match=r"friction locks the linkage at crank\.angle"):
        solve_forces(rough(pi / 3, 76.0, 3.0, 1.5, 60.0, 1.0), {"push": -50.0}, "drive")
