"""Frames: rigid motion, equilibrium, direction, distributed loads, what is refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.frame import gauss_points
from fem.unit_solutions import Elastic, rigid_modes
from geometry.bars import Sections, rectangle, rectangle_torsion, round_tube
from tests.fem.solved_frames import Frame

STEEL = Elastic(210e3, 0.3, 7.85e-9)
UP = np.array([0.3, 1.0, 0.2])


def bent_frame():
    """Five nodes in space, a branch, and a taper along every member."""
    nodes = np.array([[0, 0, 0], [120, 10, 0], [200, 90, 40], [260, 60, -30], [150, -80, 60.0]])
    members = np.array([[0, 1], [1, 2], [2, 3], [1, 4]])
    height = 10 + 0.02 * gauss_points(nodes, members)[..., 0]
    return Frame(nodes, members, UP, rectangle(height, 6.0), STEEL)


def turn():
    angle, axis = np.radians(37), np.array([1, 2, 3])
    axis = axis / np.linalg.norm(axis)
    cross = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def test_a_rigid_motion_needs_no_force_and_there_are_six_of_them():
    frame = bent_frame()
    shape = rigid_modes(frame.nodes).reshape(-1, 3, 6)
    turns = np.zeros_like(shape)
    turns[:, [0, 1, 2], [3, 4, 5]] = 1
    modes = np.concatenate([shape, turns], axis=1).reshape(-1, 6)
    matrix = frame.stiffness.toarray()
    assert np.abs(matrix @ modes).max() < 1e-12 * np.abs(matrix).max() * np.abs(modes).max()
    scale = 1 / np.sqrt(matrix.diagonal())
    values = np.linalg.eigvalsh(scale[:, None] * matrix * scale)
    assert (np.abs(values[:6]) < 1e-12).all()
    assert values[6] > 1e-6


def test_reactions_balance_nodal_and_distributed_loads():
    frame = bent_frame()
    loads = frame.nodal(4, [10.0, -20.0, 30.0, 400.0, -500.0, 600.0])
    field = np.random.default_rng(1).uniform(-1e6, 1e6, (*frame.points.shape, 1))
    loads += frame.inertia(field)
    solution = frame.held(np.arange(6)).solve(loads)
    applied = frame.resultants(loads)[:, 0]
    assert_allclose(solution.reactions[:, 0], -applied, rtol=0, atol=1e-10 * abs(applied).max())


def test_a_turned_frame_moves_as_the_frame_turned():
    """37 degrees about (1, 2, 3), loads with it."""
    frame, by = bent_frame(), turn()
    other = Frame(frame.nodes @ by.T, frame.members, by @ UP, frame.sections, STEEL)
    force, couple = np.array([10.0, -20.0, 30.0]), np.array([400.0, -500.0, 600.0])
    spin = np.moveaxis(np.stack([frame.points * 1e4]), 0, -1)
    one = frame.held(np.arange(6)).solve(frame.nodal(3, [*force, *couple]) + frame.inertia(spin))
    two = other.held(np.arange(6)).solve(
        other.nodal(3, [*by @ force, *by @ couple])
        + other.inertia(np.einsum("ij,mgjc->mgic", by, spin))
    )
    turned = (one.displacement.reshape(-1, 3) @ by.T).ravel()
    assert_allclose(two.displacement[:, 0], turned, rtol=0, atol=1e-9 * np.abs(turned).max())
    stations = np.array([0.0, 0.3, 1.0])
    ours, theirs = one.section_forces(stations), two.section_forces(stations)
    assert_allclose(theirs, ours, rtol=0, atol=1e-9 * np.abs(ours).max())


def test_a_member_may_run_either_way():
    """Start and end swapped: the same displacement, tapers and distributed loads included."""
    frame = bent_frame()
    swapped = frame.members[:, ::-1]
    height = 10 + 0.02 * gauss_points(frame.nodes, swapped)[..., 0]
    other = Frame(frame.nodes, swapped, UP, rectangle(height, 6.0), STEEL)
    unit = [
        f.planar_inertia() + f.nodal(3, [1, 2, 3, 4, 5, 6.0]).combined(np.ones((1, 4)))
        for f in (frame, other)
    ]
    one, two = (
        f.held(np.arange(6)).solve(u).displacement
        for f, u in zip((frame, other), unit, strict=True)
    )
    assert_allclose(two, one, rtol=0, atol=1e-9 * np.abs(one).max())


def test_local_axes_decide_which_way_a_flat_bends():
    """Flat 20 x 4, 300 long: 25 times as stiff on edge, F L^3 / 3 E I without shear."""
    section = rectangle(20.0, 4.0, shear_coefficient=np.inf)
    nodes, members = np.array([[0, 0, 0], [0, 0, 300.0]]), np.array([[0, 1]])
    flat = Frame(nodes, members, np.array([1.0, 0, 0]), section, STEEL)
    for force, inertia in (([10, 0, 0], 4 * 20**3 / 12), ([0, 10, 0], 20 * 4**3 / 12)):
        solution = flat.held(np.arange(6)).solve(flat.nodal(1, [*force, 0, 0, 0]))
        moved = np.array(force) * 300**3 / (3 * 210e3 * inertia)
        assert_allclose(solution.displacement[6:9, 0], moved, rtol=1e-10, atol=1e-12)


def test_twist_and_stretch_are_those_of_a_bar():
    bar = Frame(
        np.array([[0, 0, 0], [250.0, 0, 0]]), np.array([[0, 1]]), UP, round_tube(20.0, 15.0), STEEL
    )
    solution = bar.held(np.arange(6)).solve(bar.nodal(1, [1000.0, 0, 0, 5e4, 0, 0]))
    area, polar = np.pi / 4 * (400 - 225), np.pi / 32 * (20**4 - 15**4)
    assert_allclose(solution.displacement[6, 0], 1000 * 250 / (210e3 * area), rtol=1e-12)
    assert_allclose(solution.displacement[9, 0], 5e4 * 250 / (210e3 / 2.6 * polar), rtol=1e-12)


@pytest.mark.parametrize(("axis", "area", "inertia"), [(1, 50.0, 4e3), (2, 20.0, 1e3)])
def test_each_direction_has_its_own_shear_area_and_inertia(axis, area, inertia):
    """F L^3 / 3 E I + F L / G A_s, along y and along z of a short member."""
    values = (100.0, 1e3, 4e3, 900.0, 50.0, 20.0)
    nodes, members = np.array([[0, 0, 0], [30.0, 0, 0]]), np.array([[0, 1]])
    own = Sections(*(np.array(v) for v in values))
    bar = Frame(nodes, members, np.array([0, 1.0, 0]), own, STEEL)
    load = np.zeros(6)
    load[axis] = 700.0
    solution = bar.held(np.arange(6)).solve(bar.nodal(1, load))
    wanted = 700 * 30**3 / (3 * 210e3 * inertia) + 700 * 30 / (210e3 / 2.6 * area)
    assert_allclose(solution.displacement[6 + axis, 0], wanted, rtol=1e-12)


def test_round_bars_and_thin_tubes_have_cowpers_shear_areas():
    """6/7 of a full circle's area, 1/2 of a thin tube's (nu = 0)."""
    bar, tube = round_tube(20.0), round_tube(20.0, 20.0 * (1 - 1e-6))
    assert_allclose(bar.shear_area_y / bar.area, 6 / 7, rtol=1e-14)
    assert_allclose(tube.shear_area_z / tube.area, 0.5, rtol=1e-6)


def test_section_forces_under_an_even_load_are_those_of_the_textbook_cantilever():
    """q along -y: V = q (L - x), M_z = -q (L - x)^2 / 2, also between the nodes of one member."""
    bar = Frame(
        np.array([[0, 0, 0], [400.0, 0, 0]]), np.array([[0, 1]]), UP * [0, 1, 0],
        rectangle(10.0, 10.0), STEEL,
    )  # fmt: skip
    field = np.zeros((1, 6, 3, 1))
    field[..., 1, 0] = 1e6
    q = 7.85e-9 * 100 * 1e6
    stations = np.linspace(0, 1, 7)
    solution = bar.held(np.arange(6)).solve(bar.inertia(field))
    found = solution.section_forces(stations)[0, :, :, 0]
    rest = 400 * (1 - stations)
    assert_allclose(found[:, 1], -q * rest, atol=1e-9 * q * 400)
    assert_allclose(found[:, 5], -q * rest**2 / 2, atol=1e-9 * q * 400**2)
    tip = -q * 400**4 / (8 * 210e3 * 1e4 / 12) - q * 400**2 / (2 * 210e3 / 2.6 * 100 * 5 / 6)
    assert_allclose(solution.displacement[7, 0], tip, rtol=1e-9)


def test_the_planar_unit_accelerations_are_those_of_a_rigid_body():
    """Forces -m a, moments about the origin -(I + m c^2) alpha, m c omega^2; a bar beside it."""
    nodes, members = np.array([[50.0, 20, 0], [350.0, 20, 0]]), np.array([[0, 1]])
    bar = Frame(nodes, members, np.array([0, 1.0, 0]), rectangle(10.0, 8.0), STEEL)
    mass, cx, cy = 7.85e-9 * 80 * 300, 200.0, 20.0
    about = mass * (300**2 / 12 + cx**2 + cy**2)
    wanted = np.array(
        [
            [-mass, 0, mass * cy, mass * cx],
            [0, -mass, -mass * cx, mass * cy],
            [mass * cy, -mass * cx, -about, 0],
        ]
    )
    found = bar.resultants(bar.planar_inertia())[[0, 1, 5]]
    assert_allclose(found, wanted, rtol=0, atol=1e-12 * about)


def test_a_relieved_frame_in_space_has_no_reactions_wherever_it_is_held():
    frame = bent_frame()
    loads = frame.nodal(3, [10.0, -20.0, 30.0, 400.0, -500.0, 600.0])
    balanced, accelerations = frame.relieved(loads)
    left = frame.resultants(balanced)
    assert np.abs(left).max() < 1e-10 * 600
    assert np.abs(accelerations).min() > 0
    forces = []
    for held in (np.arange(6), np.arange(24, 30), np.array([0, 1, 2, 7, 8, 14])):
        solution = frame.held(held).solve(balanced)
        assert np.abs(solution.reactions).max() < 1e-8 * 30
        forces.append(solution.section_forces(np.array([0.0, 0.5, 1.0])))
    size = np.abs(forces[0]).max()
    assert size > 100
    assert_allclose(forces[1], forces[0], rtol=0, atol=1e-9 * size)
    assert_allclose(forces[2], forces[0], rtol=0, atol=1e-9 * size)


@pytest.mark.parametrize("ratio", [1.0, 2.0, 10.0])
def test_a_rectangle_twists_alike_on_edge_and_flat(ratio):
    on_edge, flat = rectangle_torsion(3 * ratio, 3.0), rectangle_torsion(3.0, 3 * ratio)
    assert_allclose(on_edge, flat, rtol=1e-15)


def straight(**changes):
    given = {
        "nodes": np.array([[0, 0, 0], [10.0, 0, 0]]),
        "members": np.array([[0, 1]]),
        "up": np.array([0, 1.0, 0]),
        "sections": rectangle(2.0, 2.0),
        "material": STEEL,
    }
    return Frame(**given | changes)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"nodes": np.zeros((2, 3))}, "member 0 has no length"),
        ({"nodes": np.zeros((2, 2))}, r"shape \(n, 3\)"),
        ({"members": np.array([[0, 2]])}, "outside 0 .. 1"),
        ({"members": np.zeros((0, 2), dtype=int)}, "m > 0"),
        ({"up": np.array([1.0, 0, 0])}, "member 0 lies along its `up`"),
        ({"sections": rectangle(np.ones((2, 6)), 2.0)}, "do not fit 1 members"),
    ],
)
def test_frames_that_cannot_be_are_refused(changes, says):
    with pytest.raises(ValueError, match=says):
        straight(**changes)


def test_sections_that_cannot_be_are_refused():
    with pytest.raises(ValueError, match="height and width must be above 0"):
        rectangle(0.0, 2.0)
    with pytest.raises(ValueError, match="area must be above 0, got -1"):
        Sections(*(np.array(v) for v in (-1.0, 1.0, 1.0, 1.0, 1.0, 1.0)))
    with pytest.raises(ValueError, match="inertia_y must be finite"):
        Sections(*(np.array(v) for v in (1.0, np.inf, 1.0, 1.0, 1.0, 1.0)))
    with pytest.raises(ValueError, match="bore"):
        round_tube(10.0, 10.0)


def test_a_frame_that_can_move_is_refused():
    with pytest.raises(ValueError, match=r"can move.* its supports stop 5"):
        straight().held(np.arange(5))
    apart = straight(nodes=np.array([[0, 0, 0], [10.0, 0, 0], [20.0, 0, 0]]))
    with pytest.raises(ValueError, match="node 2, its supports stop 0"):
        apart.held(np.arange(6))


def test_a_straight_bar_without_inertia_about_itself_cannot_balance_a_twist():
    frame = straight()
    with pytest.raises(ValueError, match="case 0 turns the frame about an axis"):
        frame.relieved(frame.nodal(1, [0, 0, 0, 50.0, 0, 0]))


def test_loads_of_unequal_cases_are_refused():
    frame = straight()
    with pytest.raises(ValueError, match="1 cases of nodal loads cannot go with 4"):
        type(frame.no_loads())(np.zeros((12, 1)), frame.planar_inertia().distributed)
