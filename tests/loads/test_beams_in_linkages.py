"""Beams and compliance matrices inside linkages, against beam elements and textbook beams.

Every linkage here is one lever, so that its deflection can be had in another way: from a frame of
Euler-Bernoulli elements on the same supports, or from the tables of simple beams.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads import (
    GROUND,
    Angle,
    BeamCompliance,
    Body,
    Contact,
    Cycle,
    Distance,
    Force,
    Linkage,
    LinkageError,
    MatrixCompliance,
    Phase,
    PointCoordinate,
    Prismatic,
    Revolute,
    Slot,
    SteadyPace,
    run_cycle,
)

BENDING, AXIAL = 2e9, 5e6  # N mm2, N: soft, so that bending and shortening are both seen
SPRING = 50.0  # N/mm of what is touched
TURN = Angle("lever")
REAR = (-300.0, 500.0)  # of the cylinder that holds the lever at C
PUSHED = np.array([0.6, 0.8])  # the direction that the contact pushes D in
SPEED, ACCELERATION, TORQUE = 3.0, 2.0, 5e4

# C held, E under the torque, D pushed, centre of mass: on the lever, which is pinned at its origin
LEVERS = {
    "overhanging": ((-460.0, 0.0), (200.0, 0.0), (400.0, 0.0), (100.0, 30.0)),
    "pushed inside the span": ((-460.0, 0.0), (-110.0, 0.0), (-300.0, 0.0), (-200.0, -25.0)),
    "pushed beside its axis": ((-460.0, -3.0), (200.0, 0.0), (400.0, 4.0), (250.0, -40.0)),
    "held at its far end": ((500.0, 0.0), (350.0, 0.0), (200.0, 0.0), (420.0, 35.0)),
}


def lever(held, twisted, pushed, centre=(0.0, 0.0), mass=5e-3, inertia=300.0):
    points = {"R": (0.0, 0.0), "C": held, "E": twisted, "D": pushed}
    return Linkage(
        bodies=(
            Body(GROUND, {"R": (0.0, 0.0), "P": REAR}),
            Body("lever", points, mass, inertia, centre),
        ),
        joints=(Revolute("R", GROUND, "lever", "R"),),
        forces=(
            Force("cylinder", Distance(GROUND, "P", "lever", "C"), -1),
            Force("torque", Angle("lever", point="E")),
            Force("work", PointCoordinate("lever", "D", tuple(PUSHED))),
        ),
        assembled={"lever": (0.0, 0.0, 0.2)},
        compliance=(BeamCompliance("lever", BENDING, AXIAL),),
    )


def swung(linkage, contact, torque=TORQUE, to=0.5):
    phase = Phase("swing", to, {"torque": torque, "work": contact}, "cylinder")
    pace = SteadyPace(TURN, SPEED, ACCELERATION)
    return run_cycle(linkage, Cycle("swing", TURN, 0.2, pace, (phase,), 40))


def turned(vector, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


def at(place, force=(0.0, 0.0), couple=0.0):
    """A load at a place beside the axis, and the displacement it works on: x, then x y turn there.

    An arm that does not deform itself leads from the axis to the place.
    """
    return place[0], np.array([force[0], force[1], couple - place[1] * force[0]])


class Frame:
    """Euler-Bernoulli elements along x (Cook, Concepts and Applications of FEA, ch. 2)."""

    def __init__(self, stations, bending=BENDING, axial=AXIAL):
        self.nodes = sorted(set(stations))
        size = 3 * len(self.nodes)
        self.stiffness = np.zeros((size, size))
        for k, h in enumerate(np.diff(self.nodes)):
            i = 3 * k
            bar = axial / h * np.array([[1.0, -1.0], [-1.0, 1.0]])
            self.stiffness[np.ix_([i, i + 3], [i, i + 3])] += bar
            bend = [
                [12.0, 6 * h, -12.0, 6 * h],
                [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                [-12.0, -6 * h, 12.0, -6 * h],
                [6 * h, 2 * h * h, -6 * h, 4 * h * h],
            ]
            rows = [i + 1, i + 2, i + 4, i + 5]
            self.stiffness[np.ix_(rows, rows)] += bending / h**3 * np.array(bend)

    def vector(self, load):
        x, values = load
        result = np.zeros(len(self.stiffness))
        k = 3 * self.nodes.index(x)
        result[k : k + 3] = values
        return result

    def displacement(self, asked, loads, supports):
        """What ``loads`` do at ``asked`` where the displacements of ``supports`` are zero."""
        rows = np.array([self.vector(support) for support in supports])
        n = len(rows)
        system = np.block([[self.stiffness, rows.T], [rows, np.zeros((n, n))]])
        pushed = sum(self.vector(load) for load in loads)
        solved = np.linalg.solve(system, np.concatenate([pushed, np.zeros(n)]))
        return float(self.vector(asked) @ solved[: len(pushed)])


def expected_force(body, angle, first, torque, mass_moves=True):
    """The contact's force at an angle: (depth - what the other loads do) / (1 / k + softness)."""
    points, centre = body.points, np.array(body.centre)
    stations = [points[name][0] for name in "RCED"] + [centre[0]]
    frame = Frame(stations)
    to_rear = turned(points["C"], angle) - REAR
    supports = [
        at(points["R"], (1.0, 0.0)),
        at(points["R"], (0.0, 1.0)),
        at(points["C"], turned(to_rear / np.hypot(*to_rear), -angle)),
    ]
    square = SPEED**2 + 2 * ACCELERATION * (angle - 0.2)
    arm = turned(centre, angle)
    pull = ACCELERATION * np.array([-arm[1], arm[0]]) - square * arm + np.array([0.0, 9810.0])
    inertia = at(centre, turned(-body.mass * pull, -angle), -body.inertia * ACCELERATION)
    push = at(points["D"], turned(PUSHED, -angle))
    loads = [at(points["E"], couple=torque)] + [inertia] * mass_moves
    way = frame.displacement(push, loads, supports)
    softness = frame.displacement(push, [push], supports)
    depth = first - turned(points["D"], angle) @ PUSHED
    return max(0.0, (depth - way) / (1 / SPRING + softness)), way, softness


@pytest.mark.parametrize("places", LEVERS.values(), ids=LEVERS)
def test_a_heavy_twisted_lever_bends_as_a_frame_of_beam_elements(places):
    """Weight, centrifugal and tangential inertia, couples and shortening, at every position."""
    linkage = lever(*places)
    body = linkage.body("lever")
    first = max(turned(places[2], angle) @ PUSHED for angle in (0.2, 0.5)) + 20.0
    cycle = swung(linkage, Contact(first, SPRING, stops=False))
    for k in range(0, len(cycle.positions), 5):
        force, way, softness = expected_force(body, cycle.positions[k], first, TORQUE)
        assert force > 100.0
        assert_allclose(cycle.efforts["work"][k], force, rtol=1e-9)
        assert_allclose(cycle.contacts["work"].deflection[k], way + softness * force, rtol=1e-9)


@pytest.mark.parametrize("places", LEVERS.values(), ids=LEVERS)
def test_a_matrix_with_its_turns_does_what_the_beam_does(places):
    """Compliance of beam elements clamped at R, for forces and couples at every point."""
    linkage = lever(*places, mass=0.0, inertia=0.0)
    body = linkage.body("lever")
    frame = Frame([body.points[name][0] for name in "RCED"])
    clamp = [at((0.0, 0.0), (1.0, 0.0)), at((0.0, 0.0), (0.0, 1.0)), at((0.0, 0.0), couple=1.0)]
    units = [
        at(body.points[name], force, couple)
        for name in "RCED"
        for force, couple in (((1.0, 0.0), 0.0), ((0.0, 1.0), 0.0), ((0.0, 0.0), 1.0))
    ]
    matrix = np.array([[frame.displacement(a, [b], clamp) for b in units] for a in units])
    first = max(turned(places[2], angle) @ PUSHED for angle in (0.2, 0.5)) + 20.0
    stated = replace(linkage, compliance=(MatrixCompliance("lever", tuple("RCED"), matrix),))
    cycle = swung(stated, Contact(first, SPRING, stops=False))
    for k in range(0, len(cycle.positions), 5):
        force, _, _ = expected_force(body, cycle.positions[k], first, TORQUE, mass_moves=False)
        assert_allclose(cycle.efforts["work"][k], force, rtol=1e-8)


def simple_beam(span, place, couple_at, side):
    """A level lever pinned at R, propped at C, pushed up at D, twisted at E; bends only."""
    points = {"R": (0.0, 0.0), "C": (side * span, 0.0)}
    points |= {"D": (side * place, 0.0), "E": (side * couple_at, 0.0)}
    return Linkage(
        bodies=(Body(GROUND, {"R": (0.0, 0.0)}), Body("lever", points)),
        joints=(Revolute("R", GROUND, "lever", "R"),),
        forces=(
            Force("cylinder", PointCoordinate("lever", "C", (0.0, 1.0))),
            Force("torque", Angle("lever", point="E")),
            Force("work", PointCoordinate("lever", "D", (0.0, 1.0))),
        ),
        assembled={"lever": (0.0, 0.0, 0.0)},
        compliance=(BeamCompliance("lever", BENDING),),
        gravity=(0.0, 0.0),
    )


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("couple_at", [100.0, 250.0, 500.0, 700.0])
def test_a_simple_beam_twisted_inside_its_span_lifts_as_in_the_tables(side, couple_at):
    """Pushed at a, b = L - a from the end: softness a2 b2 / 3 E I L; a couple M at x lifts it by

    M b (L2 - b2 - 3 x2) / 6 E I L for x < a, mirrored beyond (Timoshenko, Strength of Materials
    I, art. 32: the slope under a force, and Maxwell's reciprocity).
    """
    span, a, torque = 800.0, 300.0, 3e4
    cycle = run_cycle(
        simple_beam(span, a, couple_at, side),
        Cycle(
            "hold", TURN, 0.0, SteadyPace(TURN, 1.0),
            (Phase("hold", 1e-7, {"torque": torque, "work": Contact(30.0, SPRING, stops=False)},
                   "cylinder"),), 2,
        ),
    )  # fmt: skip
    b, x, sense = span - a, couple_at, 1.0
    if couple_at > a:
        b, x, sense = a, span - couple_at, -1.0
    lift = side * sense * torque * b * (span**2 - b**2 - 3 * x**2) / (6 * BENDING * span)
    softness = a**2 * (span - a) ** 2 / (3 * BENDING * span)
    expected = (30.0 - lift) / (1 / SPRING + softness)
    assert_allclose(cycle.efforts["work"][0], expected, rtol=1e-9)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("track", [200.0, 400.0, 600.0])
def test_a_pin_sliding_between_two_supports_bends_the_beam_there(side, track):
    """Simple beam of span L under N = F / cos at a = track / cos: N a2 b2 / 3 E I L, over cos."""
    span = 800.0
    linkage = Linkage(
        bodies=(
            Body(GROUND, {"R": (0.0, 0.0), "line": (side * track, 0.0)}),
            Body("lever", {"R": (0.0, 0.0), "C": (side * span, 0.0)}),
            Body("block", {"D": (0.0, 0.0)}),
        ),
        joints=(
            Revolute("R", GROUND, "lever", "R"),
            Slot("slot", "lever", "block", "R", "D", (1.0, 0.0)),
            Prismatic("guide", GROUND, "block", "line", "D", (0.0, 1.0)),
        ),
        forces=(
            Force("cylinder", PointCoordinate("lever", "C", (0.0, 1.0))),
            Force("work", PointCoordinate("block", "D", (0.0, 1.0))),
        ),
        assembled={"lever": (0.0, 0.0, 0.0), "block": (side * track, 0.0, 0.0)},
        gravity=(0.0, 0.0),
        compliance=(BeamCompliance("lever", BENDING),),
    )
    phase = Phase("swing", 0.2, {"work": Contact(200.0, stops=False)}, "cylinder")
    cycle = run_cycle(linkage, Cycle("swing", TURN, 0.0, SteadyPace(TURN, 1.0), (phase,), 40))
    cosine = np.cos(cycle.positions)
    a = track / cosine
    softness = a**2 * (span - a) ** 2 / (3 * BENDING * span) / cosine**2
    depth = 200.0 - side * track * np.tan(cycle.positions)
    assert_allclose(cycle.efforts["work"], depth / softness, rtol=1e-9)


def test_a_load_far_beside_the_axis_of_a_beam_is_refused():
    linkage = lever((-460.0, 0.0), (200.0, 0.0), (0.0, 400.0))
    with pytest.raises(LinkageError, match=r"force 'work' acts 400 mm beside the axis"):
        swung(linkage, Contact(900.0, SPRING, stops=False))
