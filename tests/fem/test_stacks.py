"""Leaves that are tied across and slide along: a spring pack bends like its leaves, not as one."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.testing import assert_allclose
from scipy.integrate import quad

from fem.assembly import bodies_of, ties_of
from fem.buckling import buckling_modes
from fem.leaf_stack import tie_tension
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.mesh import MeshError, Tie
from tests.bonded import bonded

from .blocks import block, wrench
from .stacks import POISSON, YOUNG, clamped, sliding, stack

STEEL = Elastic(YOUNG, POISSON, 7.85e-9)
HALF, THICK, WIDE = 120.0, 4.0, 10.0
COUNTS, SIZES = (48, 1, 2), (2 * HALF, THICK, WIDE)
FORCE = 100.0


def with_clamps(mesh):
    """Clamps of 20 mm at both ends and of 20 mm in the middle."""
    for name, place in (("left", -110.0), ("pivot", 0.0), ("right", 110.0)):
        mesh = clamped(mesh, name, place, 10.0)
    return mesh


@pytest.fixture(scope="module")
def pack():
    mesh = with_clamps(stack(3, COUNTS, SIZES, start=-HALF))
    return solve_unit_loads(sliding(mesh, "rail", (40.0, 80.0), 10.0, x=(30.0, 90.0)), STEEL)


def three_points(solutions):
    """Coefficients of 100 N up at both ends and 200 N down in the middle."""
    wrenches = {name: wrench(fy=FORCE) for name in ("left", "right")} | {
        "pivot": wrench(fy=-2 * FORCE),
        "rail": wrench(),
    }
    return solutions.coefficients(wrenches, np.zeros((1, 4)), {"rail": np.array([50.0])})[0][:, 0]


def deflection(solutions):
    """How far the ends rise over the middle under `three_points`, from the work of the forces."""
    coefficients = three_points(solutions)
    work = (solutions.loads @ coefficients) @ (solutions.displacement @ coefficients)
    return work / (2 * FORCE)


def beam_deflection(inertia, area):
    """Same of a beam with even pressures on the clamps, bending and shear (k = 0.85)."""

    def shear(x):
        # right half: the end's force on 100 to 120, half the middle's on 0 to 10
        return FORCE * (np.clip((120 - x) / 20, 0, 1) - np.clip((10 - x) / 10, 0, 1))

    def moment(x):
        return quad(shear, x, HALF, points=[10, 100], limit=100)[0]

    bent = quad(lambda x: moment(x) ** 2, 0, HALF, limit=200)[0]
    sheared = quad(lambda x: shear(x) ** 2, 0, HALF, points=[10, 100])[0]
    work = 2 * (bent / (YOUNG * inertia) + sheared / (0.85 * YOUNG / 2.6 * area))
    return work / (2 * FORCE)


def test_three_leaves_bend_like_three_beams_side_by_side(pack):
    """n E I against glued n^3 E I, 8.9 times apart and not 9 for the shear.

    One element through a leaf is too stiff by 0.55 % (0.32 % with twice as many each way, towards
    some 0.25 %); the glued pack, three elements high, by 0.2 %.
    """
    leaf = WIDE * THICK**3 / 12
    area = WIDE * THICK
    apart = deflection(pack)
    assert_allclose(apart, beam_deflection(3 * leaf, 3 * area), rtol=0.007)
    glued = deflection(solve_unit_loads(bonded(pack.mesh), STEEL))
    assert_allclose(glued, beam_deflection(27 * leaf, 3 * area), rtol=0.003)
    assert 8.8 < apart / glued < 9.0


def test_every_leaf_has_the_bending_stress_of_a_third_of_the_moment(pack):
    """M t / (2 n I) at x = 60 on both faces of each leaf, of its own sign, recovered to 2 %."""
    stress = pack.basis @ three_points(pack)
    nodes = pack.recovery.points
    at = pack.mesh.nodes[nodes]
    body = bodies_of(pack.mesh)[nodes]
    # M_z here is the moment of the end's force, which lifts: its top is pressed
    navier = FORCE * 50 / 3 * THICK / 2 / (WIDE * THICK**3 / 12)
    for leaf in range(3):
        middle = (leaf - 1) * THICK
        own = body == body[np.isclose(at[:, 1], middle)][0]
        for side in (-1, 1):
            on = own & np.isclose(at[:, 1], middle + side * THICK / 2) & np.isclose(at[:, 0], 60)
            assert_allclose(stress[on, 0].mean(), -side * navier, rtol=0.02)


def test_tied_nodes_move_together_across_and_slide_along(pack):
    """At the ends two leaves slide by the thickness times their slope; across not at all."""
    u = (pack.displacement @ three_points(pack)).reshape(-1, 3)
    first, second = pack.mesh.ties[0].pairs.T
    slip = u[second] - u[first]
    assert np.array_equal(slip[:, 1], np.zeros(len(slip)))
    at_end = np.isclose(pack.mesh.nodes[first, 0], HALF)
    ends = np.isclose(pack.mesh.nodes[:, 0], HALF) & np.isclose(pack.mesh.nodes[:, 2], 0)
    near = np.isclose(pack.mesh.nodes[:, 0], HALF - 5) & np.isclose(pack.mesh.nodes[:, 2], 0)
    slope = (u[ends, 1].mean() - u[near, 1].mean()) / 5
    middle = np.isclose(pack.mesh.nodes[first, 0], 0)
    turn = np.abs(slip[middle, 0]).max()
    assert turn < 1e-15
    assert_allclose(slip[at_end, 0], THICK * slope, rtol=0.01)


def test_leaves_tied_along_all_axes_are_the_glued_pack():
    """The same matrix by two ways: nodes made one, or T' K T. Round-off, 1e-9."""
    mesh = with_clamps(stack(3, (24, 1, 1), SIZES, start=-HALF, axes=(0, 1, 2)))
    tied, glued = (solve_unit_loads(m, STEEL) for m in (mesh, bonded(mesh)))
    assert tied.ties is not None
    assert glued.ties is None
    for solutions in (tied, glued):
        assert len(solutions.held) == 6
        assert solutions.residual < 1e-13
    wrenches = {name: wrench(fy=FORCE) for name in ("left", "right")} | {
        "pivot": wrench(fy=-2 * FORCE)
    }
    values = []
    for solutions in (tied, glued):
        coefficients, _ = solutions.coefficients(wrenches, np.zeros((1, 4)))
        load, u = solutions.loads @ coefficients, solutions.displacement @ coefficients
        values.append((load.T @ u).item())
    assert_allclose(values[0], values[1], rtol=1e-9)


def test_a_pack_in_equilibrium_needs_no_support(pack):
    """Also under forces along x on the outer leaves only, which go through the bolt to the rest."""
    wrenches = {
        "left": wrench(fx=300.0, fy=FORCE),
        "right": wrench(fx=-300.0, fy=FORCE, mz=500.0),
        "pivot": wrench(fy=-2 * FORCE, mz=-500.0),
        "rail": wrench(),
    }
    coefficients, added = pack.coefficients(wrenches, np.zeros((1, 4)), {"rail": np.array([50.0])})
    assert np.abs(pack.reactions(coefficients)).max() < 1e-7 * 300
    assert np.abs(added).max() < 1e-3
    # the leaf in the middle has its share of an inertia along x only through the bolt
    moving = {name: wrench() for name in wrenches}
    mass = pack.mesh.mass_properties(STEEL.density).mass
    moving["pivot"] = wrench(fx=mass * 1e5)
    coefficients, added = pack.coefficients(
        moving, np.array([[1e5, 0.0, 0.0, 0.0]]), {"rail": np.array([50.0])}
    )
    assert np.abs(added[:, :2]).max() < 1e-6 * 1e5
    assert np.abs(pack.reactions(coefficients)).max() < 1e-7 * mass * 1e5


def test_a_load_that_nothing_carries_leans_on_the_support(pack):
    """1000 N along x at the rail: the reactions along x, some at tied nodes, sum up to -1000 N."""
    first = sum(len(unit.names) for unit in pack.interfaces[:3])
    names = pack.interfaces[3].names
    coefficients = np.zeros((pack.loads.shape[1], 1))
    coefficients[first + names.index("t 2")] = 1000.0
    reactions = pack.reactions(coefficients)[:, 0]
    assert_allclose(reactions[pack.held % 3 == 0].sum(), -1000.0, rtol=1e-8)
    assert_allclose(reactions[pack.held % 3 == 1].sum(), 0.0, atol=1e-4)


@pytest.fixture(scope="module")
def doubled():
    """Two blocks in the same place, all nodes tied along all axes, loaded on the first alone."""
    one = block((4, 2, 2), (20.0, 5.0, 4.0), start=(0.0, -2.5, -2.0))
    count = len(one.nodes)
    pairs = np.arange(count)[:, None] + [0, count]
    mesh = replace(
        one,
        nodes=np.tile(one.nodes, (2, 1)),
        elements=np.concatenate([one.elements, one.elements + count]),
        volume_cad=2 * one.volume_cad,
        ties=tuple(Tie(axis, pairs) for axis in range(3)),
    )
    return solve_unit_loads(one, STEEL), solve_unit_loads(mesh, STEEL)


def test_two_blocks_tied_everywhere_are_one_of_twice_the_stiffness(doubled):
    one, two = doubled
    wrenches = {"start": wrench(-100.0, 30.0, 50.0), "end": wrench(100.0, -30.0, 550.0)}
    stress = []
    for solutions in doubled:
        coefficients, _ = solutions.coefficients(wrenches, np.zeros((1, 4)))
        assert np.abs(solutions.reactions(coefficients)).max() < 1e-7 * 100
        stress.append(solutions.basis @ coefficients)
    points = len(one.recovery.points)
    assert_allclose(2 * stress[1][:points], stress[0], atol=1e-8 * np.abs(stress[0]).max())
    assert_allclose(stress[1][points:], stress[1][:points], rtol=1e-12, atol=1e-12)
    assert_allclose(two.unit_resultants[:, :6], one.unit_resultants[:, :6], atol=1e-9)


def test_supports_at_tied_nodes_carry_what_both_bodies_lean_on_them(doubled):
    """The reactions are those of the single block: the load does not care for the stiffness."""
    one, two = doubled
    assert np.array_equal(two.held, one.held)
    coefficients = np.zeros((one.loads.shape[1], 1))
    coefficients[[0, 1, 4]] = np.array([[500.0], [-70.0], [9.0]])
    expected = one.reactions(coefficients)
    assert np.abs(expected).max() > 100
    assert_allclose(two.reactions(coefficients), expected, rtol=0, atol=1e-6 * 500)


def test_a_squeezed_pack_carries_the_pressure_from_leaf_to_leaf(pack):
    """All hats press on both faces: 1 N over 10 mm and the width between the stations, in all
    faces the same; pulling turns it round. 3 % for the ripple where it ends.
    """
    names = pack.interfaces[3].names
    first = sum(len(unit.names) for unit in pack.interfaces[:3])
    coefficients = np.zeros(pack.loads.shape[1])
    coefficients[first : first + len(names)] = [name[0] in "+-" for name in names]
    pressure = 1 / (10.0 * WIDE)
    tension, compression = tie_tension(pack, coefficients, window=2 * THICK)
    assert_allclose(compression, pressure, rtol=0.03)
    assert tension < 0.03 * pressure
    turned = tie_tension(pack, -coefficients, window=2 * THICK)
    assert_allclose(turned, (compression, tension), rtol=1e-12)
    both = tie_tension(pack, np.column_stack([coefficients, -2 * coefficients]), window=2 * THICK)
    assert_allclose(both, (2 * compression, compression), rtol=1e-12)


def test_a_contact_presses_two_thirds_of_its_force_through_the_first_gap(pack):
    """Equal leaves bend alike, so each keeps a third of 100 N on the lowest.

    A hat of 10 mm seen through one of 8 mm: (2/80) int_0^8 (1 - x/10)(1 - x/8) dx = 0.0733 of it
    per mm, 0.489 MPa; the leaf between spreads it a little (6 %), and lifts beside it (6 %).
    """
    wrenches = {
        "left": wrench(fy=-FORCE * 50 / 220),
        "right": wrench(fy=-FORCE * 170 / 220),
        "pivot": wrench(),
        "rail": wrench(fy=FORCE, mz=60 * FORCE),
    }
    coefficients = pack.coefficients(wrenches, np.zeros((1, 4)), {"rail": np.array([60.0])})[0]
    clamps = [(-120.0, -100.0), (100.0, 120.0)]
    tension, compression = tie_tension(pack, coefficients, clamps, window=8.0)
    assert_allclose(compression, 2 / 3 * FORCE / WIDE * 2.9333 / 40, rtol=0.07)
    assert 0 < tension < 0.07 * compression
    assert tie_tension(pack, coefficients, window=8.0)[0] > 2 * tension  # inside a clamp


def test_between_leaves_goes_what_the_clamps_give_the_outer_ones_and_inertia_takes_of_all(pack):
    """1 MPa under each leaf. Clamps give half of it all to either outer leaf, which keeps a third:
    a sixth goes on, pushed from below and pulled from above, 0.5 MPa in a window over everything.
    """
    acceleration = 1 / (7.85e-9 * THICK)
    wrenches = {name: wrench(fy=3 * WIDE * HALF) for name in ("left", "right")}
    wrenches |= {name: wrench() for name in ("pivot", "rail")}
    fields, reach = np.array([[0.0, acceleration, 0.0, 0.0]]), {"rail": np.array([60.0])}
    coefficients, added = pack.coefficients(wrenches, fields, reach)
    assert_allclose(added, 0, atol=1e-6 * acceleration)
    assert_allclose(tie_tension(pack, coefficients, window=1e9), 0.5, rtol=1e-5)


def test_the_stress_between_leaves_is_not_asked_of_a_part_of_one_body(pack):
    with pytest.raises(ValueError, match="nothing is tied along y"):
        tie_tension(
            replace(pack, elements=replace(pack.elements, mesh=bonded(pack.mesh))), 1.0, window=1.0
        )


def test_leaves_without_a_bolt_are_refused_as_a_mechanism():
    """Three leaves on each other: two can each shift along x and z and turn about y."""
    mesh = with_clamps(stack(3, (24, 1, 1), SIZES, start=-HALF, bolted=False))
    with pytest.raises(
        MeshError, match=r"the 3 bodies .* move against each other in 6 independent"
    ):
        solve_unit_loads(mesh, STEEL)


def test_leaves_bolted_in_one_point_can_still_turn():
    mesh = stack(2, (4, 1, 2), (20.0, 3.0, 6.0), start=-10.0, bolted=False)
    pairs = mesh.ties[0].pairs
    one = pairs[(np.abs(mesh.nodes[pairs[:, 0]][:, [0, 2]]) < 1e-9).all(axis=1)]
    assert len(one) == 1
    bolted = replace(mesh, ties=(*mesh.ties, Tie(0, one), Tie(2, one)))
    with pytest.raises(MeshError, match="in 1 independent"):
        ties_of(bolted)


def test_nodes_that_are_apart_cannot_be_tied():
    mesh = stack(2, (4, 1, 2), (20.0, 3.0, 6.0), start=-10.0)
    wrong = Tie(1, mesh.ties[0].pairs[:, ::-1] * [1, 0])
    with pytest.raises(MeshError, match="tied along y must be at the same place, they are up to"):
        ties_of(replace(mesh, ties=(wrong,)))


def test_a_mesh_without_ties_keeps_its_unknowns():
    assert ties_of(block((2, 1, 1), (4.0, 2.0, 2.0))) is None


def test_chains_of_ties_through_several_leaves_are_one_unknown():
    """At the bolt the leaves touch two by two: nodes at a common place of 3 leaves stay 2 groups,
    tied again at the same place (a thin middle leaf of no height) they would be one.
    """
    mesh = stack(3, (4, 1, 2), (20.0, 3.0, 6.0), start=-10.0)
    ties = ties_of(mesh)
    pairs = sum(len(tie.pairs) for tie in mesh.ties)
    assert len(ties.first) == 3 * len(mesh.nodes) - pairs
    assert np.array_equal(ties.number[ties.first], np.arange(len(ties.first)))
    values = np.random.default_rng(1).standard_normal(len(ties.first))
    whole = ties.expand(values)
    for tie in mesh.ties:
        first, second = (3 * tie.pairs + tie.axis).T
        assert np.array_equal(whole[first], whole[second])
    # what a load does does not depend on which of the tied nodes has it
    load = np.random.default_rng(2).standard_normal((3 * len(mesh.nodes), 2))
    assert_allclose(ties.collect(load).T @ values, load.T @ whole, rtol=1e-12)


def test_the_tied_matrix_is_that_of_the_tied_displacements():
    """T' K T of a full random matrix, entries between tied unknowns included, by its upper half."""
    mesh = stack(2, (2, 1, 1), (4.0, 1.0, 2.0), start=-2.0)
    ties = ties_of(mesh)
    n = len(ties.number)
    matrix = np.random.default_rng(4).standard_normal((n, n))
    matrix += matrix.T
    whole = ties.expand(np.eye(len(ties.first)))
    expected = np.triu(whole.T @ matrix @ whole)
    got = ties.collect_upper(sp.csr_array(np.triu(matrix))).toarray()
    assert_allclose(got, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_buckling_of_a_stack_is_refused(pack):
    with pytest.raises(ValueError, match="buckling is computed for parts of one body"):
        buckling_modes(pack, three_points(pack), tilt_held=False)
