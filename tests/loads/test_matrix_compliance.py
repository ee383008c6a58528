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
from loads.elasticity import LoadState, beam_displacements, matrix_displacements
from loads.forces import ForceSolution
from loads.kinematics import Kinematics

BENDING, AXIAL = 2e9, 5e6  # N mm2, N: soft, so that bending and shortening are both seen
SPAN, TRACK, SWING = 800.0, 400.0, 0.6
FARTHEST = TRACK / np.cos(SWING)  # of the block along the lever
TURN = Angle("lever")


def cantilevers(places):
    """Compliance (3 k, 3 k) of a beam along x that is held at 0: N N / E A + M M / E I, summed up.

    The moment at s of a force y and a couple 1 at x = a is a - s and 1, for s between 0 and a.
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


def shared_softness(angle, steps):
    """a2 b2 / 3 E I L less 2 M D - D2 over E I, D the triangle cut off the moment's peak.

    D is h t (1 - t) high and h long; the moment falls from a b / L by b / L and a / L to its sides.
    The force at C also shortens the lever.
    """
    cosine = np.cos(angle)
    a = TRACK / cosine
    b = SPAN - a
    h = (FARTHEST - TRACK) / steps
    before = (a - TRACK) % h
    after = h - before
    high = before * after / h
    peak = a * b / SPAN * h / 2 - (b / SPAN * before**2 + a / SPAN * after**2) / 6
    lost = 2 * high * peak - h * high**2 / 3
    held = a / SPAN / cosine**2  # at C, along y
    shorter = held**2 * (1 - cosine**2) * SPAN / AXIAL
    return (a**2 * b**2 / (3 * SPAN) - lost) / BENDING / cosine**2 + shorter


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("steps", [2, 4, 8])
def test_two_places_share_a_contact_and_lose_a_known_part_of_its_deflection(side, steps):
    cycle = swung(lever(side), as_matrix(side, steps))
    assert_allclose(softness(cycle), shared_softness(cycle.positions, steps), rtol=1e-9)


@pytest.mark.parametrize("side", [1, -1])
def test_a_guided_block_that_is_twisted_bends_its_lever_as_a_beam(side):
    """Force and couple of the block: places 5 mm apart are within 3 h2 / 4 a b = 1e-4 of the beam.

    The couple makes the force up to half as large again, or as small.
    """
    twist = 3e7
    beam, matrix = (
        swung(lever(side, guided=True), compliance, twist=twist)
        for compliance in (as_beam(), as_matrix(side, 17))
    )
    plain = swung(lever(side, guided=True), as_beam(), twist=0.0)
    at = np.linspace(0.05, 0.55, 11)
    one, other, none = (
        np.interp(at, cycle.positions, cycle.efforts["work"]) for cycle in (matrix, beam, plain)
    )
    assert np.abs(other / none - 1).max() > 0.15
    assert_allclose(one, other, rtol=3e-4)


def test_the_deflected_shape_of_a_matrix_is_that_of_its_beam():
    """Where and how far the block is moved and its line turned: the next order of the forces."""
    beam = swung(lever(), BeamCompliance("lever", 50 * BENDING, 50 * AXIAL))
    fine = as_matrix(steps=17)
    matrix = swung(lever(), replace(fine, matrix=fine.matrix / 50))
    assert beam.second_order > 0.01
    assert_allclose(matrix.second_order, beam.second_order, rtol=1e-3)


def test_what_a_matrix_moves_is_what_its_beam_moves_but_for_a_rigid_motion():
    linkage = lever()
    cycle = swung(linkage, as_matrix(steps=17))
    kinematics, none = Kinematics(cycle.linkage), np.zeros(0)
    state = LoadState(ForceSolution(cycle.reactions, cycle.efforts, none), None)
    moves = (
        matrix_displacements(kinematics, cycle.poses, as_matrix(steps=17), state),
        beam_displacements(kinematics, cycle.poses, as_beam(), state),
    )
    assert set(moves[0]) == set(moves[1]) == {"joint 'R'", "joint 'slot'", "force 'cylinder'"}
    one, other = moves
    turn = one["joint 'R'"][1] - other["joint 'R'"][1]
    shift = one["joint 'R'"][0] - other["joint 'R'"][0]
    size = np.abs(other["joint 'slot'"][0]).max()
    for source, (moved, turning, place) in one.items():
        beam, turning_beam, place_beam = other[source]
        assert_allclose(place, place_beam, atol=1e-6)
        assert_allclose(turning - turning_beam, turn, atol=1e-3 * np.abs(turning_beam).max())
        rigid = shift + np.column_stack([-turn * place[:, 1], turn * place[:, 0]])
        assert_allclose(moved - beam, rigid, atol=1e-3 * size)


def test_two_contacts_slide_along_one_body():
    """A second block on the lever, 200 mm from R, is pushed down with 20 kN: it lifts the first."""
    plain = lever()
    second = {"D": (0.0, 0.0)}
    linkage = replace(
        plain,
        bodies=(
            Body(GROUND, {**plain.body(GROUND).points, "other line": (200.0, 0.0)}),
            *plain.bodies[1:],
            Body("other", second),
        ),
        joints=(
            Slot("other slot", "lever", "other", "R", "D", (1.0, 0.0)),
            *plain.joints,
            Prismatic("other track", GROUND, "other", "other line", "D", (0.0, 1.0)),
        ),
        forces=(*plain.forces, Force("push", PointCoordinate("other", "D", (0.0, 1.0)))),
        assembled={**plain.assembled, "other": (200.0, 0.0, 0.0)},
    )
    lines = {
        "other slot": tuple(np.linspace(200.0, 200.0 / np.cos(SWING), 15)),
        "slot": tuple(np.linspace(TRACK, FARTHEST, 18)),
    }
    places = [0.0, SPAN, *lines["other slot"], *lines["slot"]]
    matrix = MatrixCompliance("lever", ("R", "C"), cantilevers(places), lines)
    one, other, alone = (
        swung(linkage, compliance, push=push)
        for compliance, push in ((matrix, -2e4), (as_beam(), -2e4), (as_beam(), 0.0))
    )
    at = np.linspace(0.05, 0.55, 11)
    found, expected, none = (
        np.interp(at, cycle.positions, cycle.efforts["work"]) for cycle in (one, other, alone)
    )
    assert np.abs(expected / none - 1).min() > 0.1
    assert_allclose(found, expected, rtol=3e-4)


def turned(vector, angle):
    c, s = np.cos(angle), np.sin(angle)
    return c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]


def test_the_frame_of_a_body_is_of_no_account_to_its_line():
    """The lever's frame turned by 0.7 rad and moved; its line goes through C instead, backwards."""
    plain, stated = lever(), as_matrix(steps=4)
    angle, shift = 0.7, (30.0, -50.0)

    def there(point):
        x, y = turned(point, angle)
        return x + shift[0], y + shift[1]

    points = {name: there(point) for name, point in plain.body("lever").points.items()}
    x, y, _ = plain.assembled["lever"]
    back = turned(shift, -angle)
    direction = turned((-1.0, 0.0), angle)
    other = replace(
        plain,
        bodies=(plain.bodies[0], Body("lever", points), plain.bodies[2]),
        joints=(
            plain.joints[0],
            Slot("slot", "lever", "block", "C", "D", direction),
            plain.joints[2],
        ),
        assembled={**plain.assembled, "lever": (x - back[0], y - back[1], -angle)},
    )
    order = [0, 1, *range(len(stated.slides["slot"]) + 1, 1, -1)]  # places backwards
    turn = np.eye(3)
    turn[:2, :2] = np.transpose([turned((1.0, 0.0), angle), turned((0.0, 1.0), angle)])
    turns = np.kron(np.eye(len(order)), turn)
    rows = np.concatenate([[3 * k, 3 * k + 1, 3 * k + 2] for k in order])
    matrix = turns @ stated.matrix[np.ix_(rows, rows)] @ turns.T
    places = tuple(SPAN - place for place in reversed(stated.slides["slot"]))
    moved = MatrixCompliance("lever", ("R", "C"), matrix, {"slot": places})
    laws = {"work": Contact(500.0, 200.0, stops=False)}
    phase = Phase("swing", SWING - angle, laws, "cylinder")
    run = Cycle("swing", TURN, -angle, SteadyPace(TURN, 1.0), (phase,), 60)
    cycle = run_cycle(replace(other, compliance=(moved,)), run)
    assert_allclose(softness(cycle), shared_softness(cycle.positions + angle, 4), rtol=1e-9)
    stiff, same = (replace(each, matrix=each.matrix / 50) for each in (moved, stated))
    second = run_cycle(replace(other, compliance=(stiff,)), run).second_order
    assert_allclose(second, swung(plain, same).second_order, rtol=0.01)


@pytest.mark.parametrize(
    ("slides", "words"),
    [
        ({"slot": (400.0,)}, r"under joint 'slot' needs at least two places .* that rise"),
        ({"slot": (400.0, 390.0)}, r"needs at least two places .* got \(400.0, 390.0\)"),
        ({"slot": (400.0, np.nan)}, r"needs at least two places along the line that rise"),
        ({}, r"the compliance of 2 points is 6 x 6, got \(12, 12\)"),
        ({"slot": (400.0, 450.0, 500.0)}, r"of 2 points and 3 places along lines is 15 x 15, got"),
    ],
)
def test_a_matrix_that_does_not_fit_its_places_is_refused(slides, words):
    with pytest.raises(LinkageError, match=words):
        MatrixCompliance("lever", ("R", "C"), np.eye(12), slides)


SHORT = as_matrix(steps=1)


@pytest.mark.parametrize(
    ("compliance", "words"),
    [
        (
            replace(SHORT, slides={"track": SHORT.slides["slot"]}),
            r"places along joint 'track', which is no slot or guide on a line of this body",
        ),
        (
            replace(SHORT, slides={"R": SHORT.slides["slot"]}),
            r"joint 'R', which is no slot or guide",
        ),
        (replace(SHORT, slides={"slit": SHORT.slides["slot"]}), r"no joint is named 'slit'"),
        (
            MatrixCompliance("lever", ("R", "C"), SHORT.matrix[:6, :6]),
            r"joint 'slot' slides along it, and its compliance has no places along that line",
        ),
        (
            as_matrix(more=-10.0),
            r"joint 'slot' acts at (4|39).* mm along its line, .* known from 410 to 474.6.* mm",
        ),
    ],
)
def test_a_contact_for_which_a_matrix_has_no_places_is_refused(compliance, words):
    with pytest.raises(LinkageError, match=words):
        swung(lever(), compliance)
