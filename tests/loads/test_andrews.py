"""Andrews' squeezing mechanism, as published, driven through its published state.

Source: Test Set for IVP Solvers (Mazzia, Magherini, Iavernaro, University of Bari), Andrews'
squeezing mechanism, problems/andrews.f, revision 1.2 of 2006-10-02, as deTestSet of R carries it
(pkg/deTestSet/src/Ex_andrews.f; parameters and initial values in pkg/deTestSet/R/ex_andrews.R).
It is benchmark A03 of IFToMM's library. The reference solution at t = 0.03 s was computed with
tolerances of 1e-14 (subroutine andsoln). The published problem is free: a torque of 0.033 N m
turns the crank from rest. Here the crank is led through the published angle at the published
speed and acceleration; all other angles, their rates, and the torque must then come out.
Lengths there in m, here in mm.
"""

from math import hypot

import numpy as np
import pytest

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

A, B, C = (-69.34, -2.27), (-36.35, 32.73), (14.0, 72.0)
TORQUE, STIFFNESS, FREE = 33.0, 4.53, 77.85  # N mm, N/mm, mm
# body: mass in kg, inertia in kg m2, points and centre of mass from its origin, mm
BODIES = {
    "K1": (0.04325, 2.194e-6, {"O": (0.0, 0.0), "F": (7.0, 0.0)}, (0.92, 0.0)),
    "K2": (0.00365, 4.410e-7, {"F": (0.0, 0.0), "E": (-28.0, 0.0)}, (-11.5, 0.0)),
    "K3": (0.02373, 5.255e-6, {"B": (0.0, 0.0), "E": (0.0, -35.0), "D": (20.0, -18.0)},
           (10.43, -18.74)),
    "K4": (0.00706, 5.667e-7, {"E": (0.0, -20.0), "G": (0.0, 0.0)}, (0.0, -5.79)),
    "K5": (0.07050, 1.169e-5, {"A": (0.0, 0.0), "G": (40.0, 0.0)}, (23.08, 9.16)),
    "K6": (0.00706, 5.667e-7, {"E": (20.0, 0.0), "H": (0.0, 0.0)}, (5.79, 0.0)),
    "K7": (0.05498, 1.912e-5, {"A": (0.0, 0.0), "H": (0.0, -40.0)}, (-4.49, -12.28)),
}  # fmt: skip
# beta, theta, gamma, phi, delta, Omega, epsilon
START = np.array([-0.0617138900142764496, 0.0, 0.455279819163070380, 0.222668390165885885,
                  0.487364979543842550, -0.222668390165885885, 1.23054744454982119])  # fmt: skip
AT_START = np.array([14222.4439199541387, -10666.8329399655854, 0, 0, 0, 0, 0])  # 1/s2, from rest
END = np.array([15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948,
                0.5244099658805304, 0.5347301163226948, 1.048080741042263])  # fmt: skip
SPEEDS = np.array([1139.920302151208, -1424.379294994111, 11.03291221937134, 19.29337464421385,
                   0.5735699284790808, -19.29337464421385, 0.3231791658026955])  # fmt: skip
RATES = np.array([-24631.76316945196, 51850.37701610329, 324102.5686413781, 566749.3645176213,
                  16743.62929479361, -566749.3645176222, 9826.520791458422])  # fmt: skip
# Multipliers of the loops O-F-E-B, O-F-E-G-A and O-F-E-H-A, N: what E of K2 does to each other body
MULTIPLIERS = np.array([[199.1753333731910, -29.75531228015052],
                        [23.06654119098399, 31.45271365475927],
                        [22.64249232082739, 11.61740700019673]])  # fmt: skip


def directions(angles):
    """Of the seven bodies: some of the published angles are of one body against another."""
    beta, theta, gamma, phi, delta, omega, epsilon = angles
    return np.array([beta, beta + theta, gamma, phi + delta, delta, omega + epsilon, epsilon])


def squeezer(angles):
    """The linkage, assembled where the published angles have it."""
    turns = directions(angles)
    c, s = np.cos(turns), np.sin(turns)
    turn = np.array([[c, -s], [s, c]]).transpose(2, 0, 1)
    g = A + turn[4] @ BODIES["K5"][2]["G"]
    h = A + turn[6] @ BODIES["K7"][2]["H"]
    f = turn[0] @ BODIES["K1"][2]["F"]
    origins = [(0.0, 0.0), f, B, g, A, h, A]
    rows = zip(BODIES, origins, turns, strict=True)
    return Linkage(
        bodies=(
            Body(GROUND, {"O": (0.0, 0.0), "A": A, "B": B, "C": C}),
            *(
                Body(name, points, 1e-3 * mass, 1e3 * inertia, centre)
                for name, (mass, inertia, points, centre) in BODIES.items()
            ),
        ),
        joints=(
            Revolute("O", GROUND, "K1", "O"),
            Revolute("F", "K1", "K2", "F"),
            Revolute("B", GROUND, "K3", "B"),
            *(Revolute(f"E{other}", "K2", f"K{other}", "E") for other in (3, 4, 6)),
            Revolute("G", "K4", "K5", "G"),
            Revolute("H", "K6", "K7", "H"),
            Revolute("A5", GROUND, "K5", "A"),
            Revolute("A7", GROUND, "K7", "A"),
        ),
        forces=(
            Force("motor", Angle("K1", point="O")),
            Force("spring", Distance(GROUND, "C", "K3", "D"), -1),
        ),
        assembled={name: (float(x), float(y), float(turn)) for name, (x, y), turn in rows},
        gravity=(0.0, 0.0),
    )


@pytest.fixture(scope="module")
def end():
    """The last position: from the published start, two and a half turns, to the published end."""
    crank = Angle("K1")
    geometry = trace(squeezer(START), crank, START[0], END[0]).at(np.array([START[0], END[0]]))
    return move(geometry, crank, SPEEDS[0], 1, RATES[0])


def solved(motion):
    """Forces at all positions, with the spring's pull from where its ends are."""
    pulls = []
    for x, y, turn in motion.poses[:, 3]:
        dx, dy = BODIES["K3"][2]["D"]
        at = x + np.cos(turn) * dx - np.sin(turn) * dy, y + np.sin(turn) * dx + np.cos(turn) * dy
        pulls.append(STIFFNESS * (hypot(at[0] - C[0], at[1] - C[1]) - FREE))
    return solve_forces(motion, {"spring": np.array(pulls)}, "motor")


@pytest.mark.parametrize(
    ("quantity", "published", "digits"),
    [("poses", END, 1e-12), ("velocities", SPEEDS, 1e-10), ("accelerations", RATES, 2e-7)],
)
def test_angles_speeds_and_accelerations_are_the_published_ones(end, quantity, published, digits):
    """The published accelerations leave the loops, differentiated twice, open by 1e-6 of E's."""
    found, expected = getattr(end, quantity)[1, 1:, 2], directions(published)
    np.testing.assert_allclose(found, expected, rtol=0, atol=digits * np.abs(expected).max())


def test_the_motor_gives_its_torque_at_the_published_accelerations(end):
    assert solved(end).efforts["motor"][1] == pytest.approx(TORQUE, rel=1e-7)


def test_the_motor_gives_its_torque_at_the_start(end):
    """From rest: a speed of 1e-6 rad/s has no part in it."""
    crank = Angle("K1")
    geometry = trace(squeezer(START), crank, START[0], START[0] + 0.01)
    start = move(geometry.at(np.array([START[0], START[0] + 0.01])), crank, 1e-6, 1, AT_START[0])
    np.testing.assert_allclose(
        start.accelerations[0, 1:, 2], directions(AT_START), rtol=0, atol=1e-6
    )
    assert solved(start).efforts["motor"][0] == pytest.approx(TORQUE, rel=1e-9)


@pytest.mark.parametrize(("other", "row"), [(3, 0), (4, 1), (6, 2)])
def test_forces_in_the_pins_at_e_are_the_published_multipliers(end, other, row):
    force = solved(end).joints[f"E{other}"].force[1]
    np.testing.assert_allclose(force, MULTIPLIERS[row], rtol=0, atol=1e-6 * 200)
