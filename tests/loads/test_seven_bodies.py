"""Seven bodies in three loops, as Andrews' squeezer has them, against energy and momentum.

Dimensions and masses are our own. The independent solution knows no constraints and no multipliers:
three times two circles meet, and what the drive does and the ground bears follows from kinetic
energy, momentum and angular momentum of points, differentiated numerically.
"""

from math import atan2, cos, hypot, sin, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads import (
    GROUND,
    Angle,
    Body,
    Distance,
    Force,
    Linkage,
    Revolute,
    move,
    solve_forces,
    trace,
)

ORIGIN, A, B, C = (0.0, 0.0), (-55.0, -5.0), (25.0, 40.0), (15.0, 75.0)  # mm, on the ground
CRANK, FE, BE, EG, AG, EH, AH = 8.0, 30.0, 38.0, 26.0, 42.0, 24.0, 45.0  # mm
D = (12.0, 20.0)  # the spring's end on the body from B to E, from B along B-E and across
MASSES = {"K1": 0.05, "K2": 0.012, "K3": 0.03, "K4": 0.02, "K5": 0.07, "K6": 0.015, "K7": 0.06}
STIFFNESS, FREE = 4.5, 70.0  # N/mm, mm
SPEED, GRAVITY = 120.0, (0.0, -9810.0)  # rad/s, mm/s2
ENDS = {"K1": "OF", "K2": "FE", "K3": "BE", "K4": "EG", "K5": "AG", "K6": "EH", "K7": "AH"}
STEP = 2e-3  # rad of the crank; differences of eighth order leave 1e-10 or less


def meet(p, q, r, s, side):
    """Where the circle of radius r about p meets that of s about q."""
    dx, dy = q[0] - p[0], q[1] - p[1]
    apart = hypot(dx, dy)
    along = (r**2 - s**2 + apart**2) / (2 * apart)
    across = side * sqrt(r**2 - along**2)
    return (
        p[0] + (along * dx - across * dy) / apart,
        p[1] + (along * dy + across * dx) / apart,
    )


def places(angle):
    """All points at an angle of the crank."""
    f = (CRANK * cos(angle), CRANK * sin(angle))
    e = meet(f, B, FE, BE, 1)
    g, h = meet(e, A, EG, AG, 1), meet(e, A, EH, AH, -1)
    c, s = (e[0] - B[0]) / BE, (e[1] - B[1]) / BE
    d = (B[0] + c * D[0] - s * D[1], B[1] + s * D[0] + c * D[1])
    return {"O": ORIGIN, "A": A, "B": B, "C": C, "D": d, "E": e, "F": f, "G": g, "H": h}


def body_states(angle):
    """Middle (x, y) and direction of every body (7, 3)."""
    at = places(angle)
    rows = []
    for first, second in ENDS.values():
        (x0, y0), (x1, y1) = at[first], at[second]
        rows.append(((x0 + x1) / 2, (y0 + y1) / 2, atan2(y1 - y0, x1 - x0)))
    return np.array(rows)


def slope(function, angle):
    """Derivative by the angle, of eighth order."""
    weights = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
    terms = [
        w * (function(angle + k * STEP) - function(angle - k * STEP))
        for k, w in enumerate(weights, 1)
    ]
    return sum(terms) / STEP


def inertias():
    """Masses, t, and inertias, t mm2, of slender bars between the ends."""
    lengths = np.array([CRANK, FE, BE, EG, AG, EH, AH])
    masses = np.array([MASSES[name] for name in ENDS]) * 1e-3
    return masses, masses * lengths**2 / 12


def turn_free(rows):
    """Directions without jumps by a whole turn, beside each other."""
    return np.remainder(rows + np.pi, 2 * np.pi) - np.pi


def rates(angle):
    """Velocities (7, 3) at the crank's speed."""
    own = body_states(angle)

    def relative(other):
        states = body_states(other)
        states[:, 2] = turn_free(states[:, 2] - own[:, 2])
        return states

    return SPEED * slope(relative, angle)


def momenta(angle):
    """Momentum x and y, angular momentum about O, kinetic energy."""
    masses, inertia = inertias()
    state, speed = body_states(angle), rates(angle)
    push = masses[:, None] * speed[:, :2]
    turning = state[:, 0] * push[:, 1] - state[:, 1] * push[:, 0] + inertia * speed[:, 2]
    energy = 0.5 * (push * speed[:, :2]).sum() + 0.5 * (inertia * speed[:, 2] ** 2).sum()
    return np.array([*push.sum(axis=0), turning.sum(), energy])


def spring(angle):
    """Length of the spring and its pull."""
    at = places(angle)
    length = hypot(at["D"][0] - C[0], at["D"][1] - C[1])
    return length, STIFFNESS * (length - FREE)


def independent(angle):
    """Torque of the drive about O, sum of the ground's forces (2,) and of their moments about O."""
    masses, _ = inertias()
    change = SPEED * slope(momenta, angle)
    state = body_states(angle)
    stretching = SPEED * slope(lambda a: spring(a)[0], angle)
    length, pull = spring(angle)
    weights = masses[:, None] * np.array(GRAVITY)
    power = change[3] - (weights * rates(angle)[:, :2]).sum() + pull * stretching
    at = places(angle)["D"]
    tug = pull / length * (np.array(C) - np.array(at))  # on the body at D
    force = change[:2] - weights.sum(axis=0) - tug
    weigh = (state[:, 0] * weights[:, 1] - state[:, 1] * weights[:, 0]).sum()
    moment = change[2] - weigh - (at[0] * tug[1] - at[1] * tug[0])
    return power / SPEED, force, moment


def squeezer(angle):
    """The same as a linkage, assembled at an angle."""
    at = places(angle)
    masses, inertia = inertias()
    bodies, assembled = [], {}
    for k, (name, (first, second)) in enumerate(ENDS.items()):
        length = hypot(at[second][0] - at[first][0], at[second][1] - at[first][1])
        points = {first: (0.0, 0.0), second: (length, 0.0)}
        if name == "K3":
            points["D"] = D
        bodies.append(Body(name, points, masses[k], inertia[k], (length / 2, 0.0)))
        assembled[name] = (*at[first], body_states(angle)[k, 2])
    return Linkage(
        bodies=(Body(GROUND, {"O": ORIGIN, "A": A, "B": B, "C": C}), *bodies),
        joints=(
            Revolute("O", GROUND, "K1", "O"),
            Revolute("F", "K1", "K2", "F"),
            Revolute("B", GROUND, "K3", "B"),
            *(Revolute(f"E{other}", "K3", f"K{other}", "E") for other in (2, 4, 6)),
            Revolute("G", "K4", "K5", "G"),
            Revolute("H", "K6", "K7", "H"),
            Revolute("A5", GROUND, "K5", "A"),
            Revolute("A7", GROUND, "K7", "A"),
        ),
        forces=(
            Force("drive", Angle("K1", point="O")),
            Force("spring", Distance(GROUND, "C", "K3", "D"), -1),
        ),
        assembled=assembled,
        gravity=GRAVITY,
    )


@pytest.fixture(scope="module")
def turn():
    """A turn of the crank in 13 positions: angles, poses and forces."""
    angles = 0.3 + np.linspace(0.0, 2 * np.pi, 13)
    crank = Angle("K1")
    motion = move(trace(squeezer(0.3), crank, angles[0], angles[-1]).at(angles), crank, SPEED, 1)
    pull = np.array([spring(angle)[1] for angle in angles])
    return angles, motion, solve_forces(motion, {"spring": pull}, "drive")


def test_positions_are_where_circles_meet(turn):
    angles, motion, _ = turn
    for pose, angle in zip(motion.poses[:, 1:], angles, strict=True):
        at = places(angle)
        found = pose[:, :2] - [at[first] for first, _ in ENDS.values()]
        assert_allclose(found, 0.0, atol=1e-9)


def test_the_drive_gives_what_energy_and_spring_take(turn):
    angles, _, solution = turn
    expected = np.array([independent(angle)[0] for angle in angles])
    assert np.ptp(expected) > 100.0  # N mm
    assert_allclose(solution.efforts["drive"], expected, rtol=0, atol=1e-7 * np.abs(expected).max())


def test_the_ground_bears_what_changes_momentum_and_angular_momentum(turn):
    angles, _, solution = turn
    ground = {"O": ORIGIN, "B": B, "A5": A, "A7": A}
    for k, angle in enumerate(angles):
        torque, force, moment = independent(angle)
        own = {name: solution.joints[name].force[k] for name in ground}
        size = max(np.hypot(*each) for each in own.values())
        assert_allclose(sum(own.values()), force, rtol=0, atol=1e-7 * size)
        turning = sum(p[0] * own[n][1] - p[1] * own[n][0] for n, p in ground.items())
        assert_allclose(turning + torque, moment, rtol=0, atol=1e-6 * size * 70.0)
