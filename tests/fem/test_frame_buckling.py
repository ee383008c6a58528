"""Buckling of frames: closed forms of columns, joints as constraints, loads that go along, counts.

Cases of Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., chapter 2, unless named.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem import frame_joints
from fem.frame import (
    Frame,
    LooseFrameError,
    buckling_modes,
    gauss_points,
    integration_matrix,
    whitening,
)
from fem.frame_joints import (
    IN_PLANE,
    OUT_OF_PLANE,
    Link,
    PlacedLinks,
    chain,
    dead_force,
    following_force,
    pin,
    slide,
    slot_force,
)
from fem.unit_solutions import Elastic
from geometry.bars import Sections, rectangle
from tests.fem.buckled_frames import axial_stiffness, frame_buckling

STEEL = Elastic(210e3, 0.3, 7.85e-9)
UP = np.array([0.0, 1.0, 0.0])
LENGTH, INERTIA = 1000.0, 1e4
EULER = np.pi**2 * 210e3 * INERTIA / LENGTH**2  # hinged at both ends


def slim(inertia):
    """Sections without shear, that bend along y only with `inertia`."""
    inertia = np.asarray(inertia, dtype=float)
    wide = np.full(inertia.shape, 1e6)
    none = np.full(inertia.shape, np.inf)
    return Sections(np.full(inertia.shape, 500.0), wide, inertia, wide, none, none)


def column(count, section=lambda x: slim(np.full(x.shape, INERTIA)), length=LENGTH):
    nodes = np.zeros((count + 1, 3))
    nodes[:, 0] = np.linspace(0, length, count + 1)
    members = chain(count + 1)
    return Frame(nodes, members, UP, section(gauss_points(nodes, members)[..., 0]), STEEL)


HELD = {"hinged": [1], "clamped": [1, 5], "free": []}


def held(frame, start, end):
    """At both ends still along z, without twist or turn about y; along x at the start."""
    last = 6 * (len(frame.nodes) - 1)
    ends = [*HELD[start], *(last + k for k in HELD[end])]
    return np.array([0, 2, 3, 4, last + 2, last + 3, last + 4, *ends])


def factors(frame, start, end, count=1, axial=-1.0):
    forces = np.full(len(frame.members), axial)
    return frame_buckling(frame, forces, held(frame, start, end), count=count).factors


# BK-01; the error of cubics falls with h^4
@pytest.mark.parametrize(
    ("start", "end", "load", "error"),
    [
        ("hinged", "hinged", 20726.16924, 1.3e-7),
        ("clamped", "free", 5181.542311, 1e-8),
        ("clamped", "clamped", 82904.67697, 2.1e-6),
        ("clamped", "hinged", 42400.52997, 6e-7),
    ],
)
def test_columns_buckle_at_eulers_load_from_above_with_the_fourth_order(start, end, load, error):
    """BK-01, E = 210 GPa, I = 1e4 mm4, L = 1 m: closed forms."""
    errors = [factors(column(n), start, end)[0] / load - 1 for n in (8, 16, 32)]
    assert 0 < errors[-1] < error
    assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 4, atol=0.1)


def test_higher_factors_of_a_hinged_column_are_squares():
    found = factors(column(32), "hinged", "hinged", count=4)
    assert_allclose(found / EULER, [1, 4, 9, 16], rtol=4e-5)


def test_shear_lowers_the_load_to_engessers_not_haringxs():
    """BK-02: rectangle 20 x 10, 100 long, k = 5/6; Engesser 1253119.6, Haringx 1263207.4 N.

    The shear strain is even in a member, so here the error falls with h^2.
    """
    errors = [
        factors(
            column(n, lambda x: rectangle(np.full(x.shape, 20.0), 10.0), 100.0), *["hinged"] * 2
        )
        / 1253119.556
        - 1
        for n in (16, 32, 64)
    ]
    assert 0 < errors[-1][0] < 2e-5
    assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.1)


def test_stepped_columns_buckle_at_the_root_of_their_matching_equation():
    """BK-04; stated tolerance 0.1 % with 8 elements per part."""

    def tip(x):
        return slim(np.where(x < 500, INERTIA, INERTIA / 2))

    def middle(x):
        return slim(np.where(np.abs(x - 500) < 250, INERTIA, 0.4 * INERTIA))

    unit = 210e3 * INERTIA / LENGTH**2
    assert_allclose(factors(column(16, tip), "clamped", "free") / unit, 2.067232897, rtol=4e-7)
    assert_allclose(factors(column(32, middle), "hinged", "hinged") / unit, 7.605976316, rtol=4e-7)


@pytest.mark.parametrize(("power", "load"), [(2, 1.591198665), (3, 1.533986952), (4, 1.505084814)])
def test_tapered_columns_need_no_steps(power, load):
    """BK-05, cantilevers with I1/I2 = 0.2; stated tolerance 0.5 % with 16 stepped elements."""
    thin = 0.2 ** (1 / power)

    def taper(x):
        return slim(INERTIA * (1 - (1 - thin) * x / LENGTH) ** power)

    unit = 210e3 * INERTIA / LENGTH**2
    assert_allclose(factors(column(16, taper), "clamped", "free") / unit, load, rtol=4e-7)


def test_a_column_buckles_under_its_own_weight():
    """9/4 j^2 = 7.837347 times E I / L^2 for the whole weight of a cantilever, j = 1.866351 the
    first zero of J_(-1/3) (Timoshenko and Gere, 2.12)."""
    frame = column(16)
    weight = -(1 - frame.points[..., 0] / LENGTH)
    found = frame_buckling(frame, weight, held(frame, "clamped", "free")).factors
    assert_allclose(found * LENGTH**2 / (210e3 * INERTIA), 9 / 4 * 1.866350859**2, rtol=2e-6)


def test_a_cross_of_plates_twists_aside_when_its_stress_is_that_of_wagner():
    """G J A / I_p, at any length (Timoshenko and Gere, 5.3)."""
    section = Sections(*(np.array(v) for v in (100.0, 9e9, 9e9, 50.0, np.inf, np.inf)))
    frame = column(4, lambda x: section.broadcast(x.shape))
    found = factors(frame, "clamped", "clamped")
    assert_allclose(found, 210e3 / 2.6 * 50.0 * 100.0 / 18e9, rtol=1e-10)


def test_factor_times_load_does_not_depend_on_the_load_over_18_decades():
    frame = column(8)
    loads = np.array([1e-9, 1e-3, 1.0, 1e4, 1e9])
    found = np.array([factors(frame, "hinged", "hinged", axial=-p)[0] * p for p in loads])
    assert_allclose(found, found[2], rtol=1e-12)


def test_tension_has_no_factor_but_tells_that_of_the_loads_turned_round():
    frame = column(8)
    place = held(frame, "hinged", "hinged")
    pulled = frame_buckling(frame, np.full(8, 7.0), place)
    assert not len(pulled.factors)
    assert_allclose(pulled.reversed, EULER / 7, rtol=4e-5)
    assert frame_buckling(frame, np.full(8, -7.0), place).reversed is None
    nothing = frame_buckling(frame, np.zeros(8), place)
    assert not len(nothing.factors)
    assert nothing.reversed is None


def test_the_count_below_a_factor_is_that_of_the_modes_also_of_equal_ones():
    """A hinged square column buckles as soon one way as the other: two equal factors."""
    both = Sections(*(np.array(v) for v in (500.0, INERTIA, INERTIA, 1e6, np.inf, np.inf)))
    frame = column(16, lambda x: both.broadcast(x.shape))
    last = 6 * 16
    place = np.array([0, 1, 2, 3, last + 1, last + 2])
    found = frame_buckling(frame, np.full(16, -1.0), place, count=4).factors
    assert_allclose(found / EULER, [1, 1, 4, 4], rtol=4e-5)
    free = np.setdiff1d(np.arange(6 * 17), place)
    stiffness = frame.dense_stiffness()[np.ix_(free, free)]
    geometric = axial_stiffness(frame, np.full(16, -1.0))[np.ix_(free, free)]
    for share, count in ((0.5, 0), (0.999, 0), (1.001, 2), (3.99, 2), (4.01, 4), (9.01, 6)):
        values = np.linalg.eigvalsh(stiffness + share * EULER * geometric)
        assert (values < 0).sum() == count


def test_a_frame_turned_in_space_has_the_same_factors():
    frame = column(8, lambda x: rectangle(np.full(x.shape, 20.0), 10.0))
    along, aside, up = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
    nodes = frame.nodes[:, :1] * along
    turned = Frame(nodes, frame.members, aside, frame.sections, STEEL)
    clamped = np.arange(6)
    one, two = (
        frame_buckling(f, np.full(8, -1.0), clamped, count=3).factors for f in (frame, turned)
    )
    assert_allclose(two, one, rtol=1e-9)
    assert up @ along == pytest.approx(0, abs=1e-12)


def test_what_can_move_and_forces_of_a_wrong_shape_are_refused():
    frame = column(4)
    with pytest.raises(ValueError, match="the frame can move"):
        frame_buckling(frame, np.full(4, -1.0), np.array([0, 1, 2]))
    with pytest.raises(ValueError, match="axial forces of 4 members must be finite"):
        axial_stiffness(frame, np.ones(3))
    singular = np.diag([1.0, 1.0]) + np.array([[0.0, 1.0], [1.0, 0.0]])
    with pytest.raises(ValueError, match="without strain"):
        buckling_modes(singular, np.eye(2))


def test_integrals_through_gauss_points_are_those_of_polynomials():
    x = gauss_points(np.array([[0, 0, 0], [1.0, 0, 0]]), np.array([[0, 1]]))[0, :, 0]
    for power in range(6):
        assert_allclose(integration_matrix() @ x**power, x ** (power + 1) / (power + 1), atol=1e-16)


# links and joints ---------------------------------------------------------------------------------


def cantilever(count=16, others=(), origins=((0.0, 0.0),), angle=0.0):
    """A clamped bar along x as link 0, and more links; its rows."""
    links = (Link("bar", column(count)), *others)
    c, s = np.cos(angle), np.sin(angle)
    turned = np.array(origins) @ np.array([[c, s], [-s, c]])
    placed = PlacedLinks(links, turned, np.full(len(links), angle))
    ground, foot = placed.motion(None, np.zeros(2)), placed.motion(0, np.zeros(2))
    return placed, foot.rows - ground.rows


def pressed(placed, count=16):
    return placed.axial(0, np.full((1, count, 6), -1.0))[0]


ROOT_UNIT = 210e3 * INERTIA / LENGTH**2


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_rigid_head_on_a_cantilever_follows_the_transcendental_root(angle):
    """cot(k a) = k b for a bar of length a below a rigid one of length b, force at its top."""
    ratio = 0.5
    head = Link("head")
    placed, clamp = cantilever(others=(head,), origins=((0, 0), (LENGTH, 0)), angle=angle)
    top, foot = placed.motion(0, np.array([LENGTH, 0])), placed.motion(1, np.zeros(2))
    end = placed.motion(1, np.array([ratio * LENGTH, 0]))
    rows = np.vstack([clamp, foot.rows - top.rows])
    down = -np.array([np.cos(angle), np.sin(angle)])
    geometric = pressed(placed) + dead_force(end, down)
    found = placed.buckling(rows, geometric, IN_PLANE).factors[0] / ROOT_UNIT
    z = np.sqrt(found)
    assert_allclose(1 / np.tan(z), ratio * z, rtol=1e-6)
    sideways = placed.buckling(rows, geometric, OUT_OF_PLANE).factors[0]
    assert sideways > 50 * found * ROOT_UNIT  # 1e6 mm4 against 1e4


def test_a_dead_force_works_on_the_second_order_of_a_turn_in_space():
    """-f . (R r - r - t x r) of a finite turn t, Rodrigues' formula; third order is left."""
    placed = PlacedLinks((Link("body"),), np.array([[7.0, -3.0]]), np.array([0.4]))
    at = placed.motion(0, np.array([30.0, -20.0]))
    force, arm = np.array([5.0, 8.0, 0.0]), np.append(at.arm, 0.0)
    form = dead_force(at, force[:2])
    turns = at.rows[3:, 3:6]  # own turns to those in global axes
    for t in np.random.default_rng(2).standard_normal((5, 3)) * 1e-4:
        size = np.linalg.norm(t)
        first, second = np.cross(t, arm), np.cross(t, np.cross(t, arm))
        moved = np.sin(size) / size * first + (1 - np.cos(size)) / size**2 * second
        work = -force @ (moved - first)
        unknowns = np.zeros(6)
        unknowns[3:] = np.linalg.solve(turns, t)
        assert_allclose(unknowns @ form @ unknowns / 2, work, atol=2e-4 * 400 * size**2)


def test_a_force_that_points_to_the_foot_quadruples_the_load_of_a_cantilever():
    """pi^2 E I / L^2: tip force through the clamp (Timoshenko and Gere, 2.9)."""
    placed, clamp = cantilever(32)
    tip = placed.motion(0, np.array([LENGTH, 0.0]))
    foot = placed.motion(None, np.zeros(2))
    geometric = pressed(placed, 32) + following_force(foot, tip, 1.0)
    found = placed.buckling(clamp, geometric, IN_PLANE).factors[0]
    assert_allclose(found / ROOT_UNIT, np.pi**2, rtol=2e-6)


def test_a_plate_on_top_that_a_slider_presses_turns_its_force():
    """tan z = -1/z: a cantilever's cross plate slides on what presses it, z = 2.79839.

    With the force P on the line y = 0, square to the plate: E I v'' = -P v'(L) (L - x) - P v.
    """
    placed, clamp = cantilever(32, others=(Link("slider"),), origins=((0, 0), (LENGTH, 0)))
    plate, slider = placed.motion(0, np.array([LENGTH, 0.0])), placed.motion(1, np.zeros(2))
    ground = placed.motion(None, np.array([LENGTH, 0.0]))
    normal = np.array([1.0, 0.0])
    rows = np.vstack(
        [
            clamp,
            slide(plate, slider, normal),
            slide(ground, slider, np.array([0.0, 1.0]), (2, 3, 4, 5)),
        ]
    )
    geometric = pressed(placed, 32) + slot_force(plate, slider, normal, 1.0)
    found = placed.buckling(rows, geometric, IN_PLANE).factors[0]
    assert_allclose(np.sqrt(found / ROOT_UNIT), 2.798386, rtol=1e-5)


def test_pins_are_hinges_about_z_only():
    """Two halves of a column pinned in the middle: loose in the plane, one column out of it."""
    round_bar = Sections(*(np.array(v) for v in (500.0, INERTIA, INERTIA, 1e6, np.inf, np.inf)))
    half = column(16, lambda x: round_bar.broadcast(x.shape), LENGTH / 2)
    placed = PlacedLinks(
        (Link("a", half), Link("b", half)), np.array([[0, 0], [LENGTH / 2, 0]]), np.zeros(2)
    )
    start, end = (placed.motion(k, np.array([k * LENGTH / 2, 0.0])) for k in (0, 1))
    middle = (placed.motion(0, np.array([LENGTH / 2, 0.0])), placed.motion(1, np.zeros(2)))
    grounds = [placed.motion(None, motion.place) for motion in (start, end)]
    along = np.array([1.0, 0.0])
    soft = np.vstack([pin(grounds[0], start, along), pin(*middle)])
    top = slide(grounds[1], end, np.array([0.0, 1.0]), (2, 3))
    geometric = sum(placed.axial(k, np.full((1, 16, 6), -1.0))[0] for k in (0, 1))
    with pytest.raises(ValueError, match="without strain"):
        placed.buckling(np.vstack([soft, top]), geometric, IN_PLANE)
    found = placed.buckling(np.vstack([soft, top]), geometric, OUT_OF_PLANE).factors[0]
    assert_allclose(found / EULER, 1, rtol=2e-6)
    stiff = np.vstack([pin(grounds[0], start), pin(*middle), top, end.rows[4]])
    found = placed.buckling(stiff, geometric, OUT_OF_PLANE).factors[0]
    assert_allclose(found / EULER, 4, rtol=3e-6)


@pytest.mark.parametrize("plane", [IN_PLANE, OUT_OF_PLANE])
def test_rows_that_others_imply_leave_the_same_motions_free(plane):
    """Rows that do not imply each other are taken apart another way (QR) than others (SVD)."""
    placed, clamp = cantilever(angle=0.7)
    twice = np.vstack([clamp, clamp[0] - 2 * clamp[1], clamp[2] + 3e-4 * clamp[3]])
    projectors = []
    for rows in (clamp, twice):
        free = placed.free_motions(rows, plane)
        assert_allclose(rows @ free, 0, atol=1e-12)
        assert free.shape[1] == len(placed.unknowns(plane)) - 3
        projectors.append(free @ np.linalg.pinv(free))
    assert_allclose(projectors[0], projectors[1], atol=1e-9)


@pytest.mark.parametrize("plane", [IN_PLANE, OUT_OF_PLANE])
def test_motions_of_unit_stiffness_are_those_that_rows_leave_free_in_every_position(plane):
    """Two angles at once, by blocks; with rows that others imply, each by itself."""
    placed, clamp = cantilever(angle=0.7)
    other, turned = cantilever(angle=-0.2)
    both = PlacedLinks(
        placed.links,
        np.array([placed.origins, other.origins]),
        np.array([placed.angles, other.angles]),
    )
    own = placed.unknowns(plane)
    for rows in (
        np.array([clamp, turned]),
        np.array([np.vstack([r, r[:1]]) for r in (clamp, turned)]),
    ):
        for number, motions in enumerate(both.unit_motions(rows, plane)):
            assert motions.shape == (len(own), len(own) - 3)
            assert_allclose(rows[number][:, own] @ motions, 0, atol=1e-12 * np.abs(motions).max())
            stiffness = motions.T @ placed.stiffness[np.ix_(own, own)] @ motions
            assert_allclose(stiffness, np.eye(len(own) - 3), atol=1e-9)


def test_what_no_row_holds_is_taken_apart_once_and_gives_the_same_motions(monkeypatch):
    placed, clamp = cantilever(angle=0.7)
    both = PlacedLinks(
        placed.links, np.repeat(placed.origins[None], 2, 0), np.repeat(placed.angles[None], 2, 0)
    )
    rows, taken = np.array([clamp, clamp]), []
    by_blocks = frame_joints.Inner.unit_motions

    def seen(inner, free):
        taken.append(by_blocks(inner, free))
        return taken[-1]

    monkeypatch.setattr(frame_joints.Inner, "unit_motions", seen)
    found = both.unit_motions(rows, IN_PLANE)
    assert taken
    assert taken[0] is not None
    monkeypatch.setattr(frame_joints.Inner, "unit_motions", lambda *_: None)
    whole = both.unit_motions(rows, IN_PLANE)
    for one, other in zip(found, whole, strict=True):
        assert_allclose(one @ one.T, other @ other.T, rtol=1e-6, atol=1e-9 * (one @ one.T).max())


def test_motions_of_many_positions_tell_what_moves_without_strain():
    placed, clamp = cantilever()
    both = PlacedLinks(
        placed.links, np.repeat(placed.origins[None], 2, 0), np.repeat(placed.angles[None], 2, 0)
    )
    with pytest.raises(LooseFrameError):
        both.unit_motions(np.array([clamp[:2], clamp[:2]]), IN_PLANE)


def test_motion_between_nodes_is_that_of_a_node_there():
    """A cubic in both planes with twist; the member's ends from it, its middle and an arm read."""
    placed, _ = cantilever(1)
    x = np.array([0.0, LENGTH, 400.0])
    cubic, slope = 1e-6 * x**3 - 2e-3 * x**2 + x, 3e-6 * x**2 - 4e-3 * x + 1
    values = np.stack([0.1 * x, cubic, 2 * cubic, 0.01 * x, -2 * slope, slope], axis=1)
    motion = placed.motion(0, np.array([400.0, 30.0]))
    u, v, w, twist, tilt, turn = values[2]
    wanted = [u - 30 * turn, v, w + 30 * twist, twist, tilt, turn]
    assert_allclose(motion.rows @ values[:2].ravel(), wanted, rtol=1e-12)
    assert_allclose(motion.arm, [0, 30])


def test_links_off_their_axis_and_out_of_order_are_refused():
    frame = column(2)
    with pytest.raises(ValueError, match="'bar': its nodes must rise"):
        Link("bar", Frame(-frame.nodes, frame.members, UP, frame.sections, STEEL))
    with pytest.raises(ValueError, match="'bar': its members must join"):
        Link("bar", Frame(frame.nodes, frame.members[::-1], UP, frame.sections, STEEL))


@pytest.mark.parametrize("softest", [1.0, 1e-8, 3e-13])
def test_whitened_motions_have_the_unit_matrix_as_their_stiffness(softest):
    """Down to what counts as a mechanism; round-off grows with the root of the conditioning."""
    stiffness = with_values(np.append(softest, np.linspace(0.5, 2.0, 11)))
    motions = whitening(stiffness)
    error = np.abs(motions.T @ stiffness @ motions - np.eye(12)).max()
    assert error < 1e-12 / softest**0.5 / softest**0.25


@pytest.mark.parametrize("softest", [1e-15, 0.0, -1e-15])
def test_what_moves_without_strain_is_not_whitened(softest):
    with pytest.raises(LooseFrameError, match="without strain"):
        whitening(with_values(np.append(softest, np.linspace(0.5, 2.0, 11))))


def with_values(values):
    """A matrix with these eigenvalues, in directions that are none of its axes."""
    directions, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(len(values),) * 2))
    return directions @ (values[:, None] * directions.T)
