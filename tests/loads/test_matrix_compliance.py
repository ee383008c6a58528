"""Compliance matrices of bodies along which a contact slides, against beams of the same stiffness.

Every matrix is of a cantilever on either side of R, in closed form; how it is held is of no account
to loads in equilibrium.
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
SPAN, TRACK, SWING = 800.0, 400.0, 0.6
FARTHEST = TRACK / np.cos(SWING)  # of the block along the lever
TURN = Angle("lever")


def cantilevers(places):
    """Compliance (3 k, 3 k) of a beam along x that is held at 0: integrals of N N / E A + M M / E I.

    The moment at s of forces x, y and a couple 1 at x = a is 0, a - s and 1, for s between 0 and a.
    """
    result = np.zeros((3 * len(places), 3 * len(places)))
    for i, a in enumerate(places):
        for k, b in enumerate(places):
            if a * b <= 0:
                continue
            m = np.sign(a) * min(abs(a), abs(b))
            block = np.array(
                [
                    [m / AXIAL, 0, 0],
                    [0, (a * b * m - (a + b) * m**2 / 2 + m**3 / 3), (a * m - m**2 / 2)],
                    [0, (b * m - m**2 / 2), m],
                ]
            )
            block[1:, 1:] /= BENDING
            result[3 * i : 3 * i + 3, 3 * k : 3 * k + 3] = np.sign(a) * block
    return result


def lever(side=1, guided=False):
    """A block on a level lever R-C, pinned at R and held at C, is pushed up at D on its track.

    guided  the lever also keeps the block from turning, which a torque tries to do
    """
    joint = Prismatic if guided else Slot
    track = Slot if guided else Prismatic
    twist = (Force("twist", Angle("block")),) if guided else ()
    return Linkage(
        bodies=(
            Body(GROUND, {"R": (0.0, 0.0), "line": (side * TRACK, 0.0)}),
            Body("lever", {"R": (0.0, 0.0), "C": (side * SPAN, 0.0)}),
            Body("block", {"D": (0.0, 0.0)}),
        ),
        joints=(
            Revolute("R", GROUND, "lever", "R"),
            joint("slot", "lever", "block", "R", "D", (1.0, 0.0)),
            track("track", GROUND, "block", "line", "D", (0.0, 1.0)),
        ),
        forces=(
            Force("cylinder", PointCoordinate("lever", "C", (0.0, 1.0))),
            Force("work", PointCoordinate("block", "D", (0.0, 1.0))),
            *twist,
        ),
        assembled={"lever": (0.0, 0.0, 0.0), "block": (side * TRACK, 0.0, 0.0)},
        gravity=(0.0, 0.0),
    )


def swung(linkage, compliance, **given):
    laws = {"work": Contact(500.0, 200.0, stops=False), **given}
    phase = Phase("swing", SWING, laws, "cylinder")
    return run_cycle(
        replace(linkage, compliance=(compliance,)),
        Cycle("swing", TURN, 0.0, SteadyPace(TURN, 1.0), (phase,), 60),
    )


def as_beam():
    return BeamCompliance("lever", BENDING, AXIAL)


def as_matrix(side=1, steps=4, more=0.0):
    """The lever as a matrix, with places along the slot from where the block starts."""
    along = np.linspace(TRACK - more, FARTHEST + more, steps + 1)
    along = along if side > 0 else -along[::-1]
    places = [0.0, side * SPAN, *along]
    slides = {"slot": tuple(along)}
    return MatrixCompliance("lever", ("R", "C"), cantilevers(places), slides)


def softness(cycle):
    """Of the lever along the force, mm/N: deflection over force, without other loads."""
    return cycle.contacts["work"].deflection / cycle.efforts["work"]


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("steps", [2, 4, 8])
def test_two_places_share_a_contact_and_lose_a_known_part_of_its_deflection(side, steps):
    """a2 b2 / 3 E I L less 2 M D - D2 over E I, D the triangle they cut off the moment's peak.

    It is h t (1 - t) high and h long; the moment falls from a b / L by b / L and a / L to its sides.
    """
    cycle = swung(lever(side), as_matrix(side, steps))
    a = TRACK / np.cos(cycle.positions)
    b = SPAN - a
    h = (FARTHEST - TRACK) / steps
    before = (a - TRACK) % h
    after = h - before
    high = before * after / h
    peak = a * b / SPAN * h / 2 - (b / SPAN * before**2 + a / SPAN * after**2) / 6
    lost = 2 * high * peak - h * high**2 / 3
    expected = (a**2 * b**2 / (3 * SPAN) - lost) / BENDING / np.cos(cycle.positions) ** 2
    assert lost.max() > 1e-4 * (a**2 * b**2 / (3 * SPAN)).max()
    assert_allclose(softness(cycle), expected, rtol=1e-9)


@pytest.mark.parametrize("side", [1, -1])
def test_a_guided_block_that_is_twisted_bends_its_lever_as_a_beam(side):
    """Force and couple of the block: places 5 mm apart are within 3 h2 / 4 a b = 1e-4 of the beam;
    without the couple it would be a third off.
    """
    twist = 2e5
    beam, matrix = (
        swung(lever(side, guided=True), compliance, twist=twist)
        for compliance in (as_beam(), as_matrix(side, 17))
    )
    plain = swung(lever(side, guided=True), as_beam(), twist=0.0)
    at = np.linspace(0.05, 0.55, 11)
    one, other, none = (
        np.interp(at, cycle.positions, cycle.efforts["work"]) for cycle in (matrix, beam, plain)
    )
    print(one/other-1, other/none-1, matrix.second_order, beam.second_order)
    assert_allclose(one, other, rtol=1e-3)
