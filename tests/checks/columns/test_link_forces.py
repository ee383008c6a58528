"""Loads on the frame of a linkage from its cycle: forces along bars and beside them, contacts."""

from copy import copy
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import solve_cycles
from checks.columns.link_joints import BarForces, JointRows, forces_of, link_model
from checks.columns.linkage_frame import COARSE, worst_mode
from checks.columns.linkage_search import IN, SOFT, STIFF, Search, _spread
from fem.frame_joints import slot_force
from loads import Fixed, Slot
from tests.checks.columns.test_linkage_frame import BAR
from tests.small_machine import machine, solved

DESIGNS = Path(__file__).parents[3] / "designs"


@pytest.fixture(scope="module")
def quick_return():
    """A lever of 0.35529 kg with a slot, in which a block slides from 180 mm to 40 mm and back."""
    design = read_design(DESIGNS / "quick_return.toml", ["cycles.at_10_loaded.positions=13"])
    design = replace(design, cycles={"at_10_loaded": design.cycles["at_10_loaded"]})
    run = solve_cycles(design, {})["at_10_loaded"]
    model = link_model(design, run.linkage, COARSE)
    return model, run, JointRows(model, run)


# along bars and beside them ----------------------------------------------------------------------


def test_a_force_that_wanders_along_a_bar_presses_it_as_far_as_it_has_come():
    """7 N at the foot, held by a contact at 40 mm in one position and at 80 mm in the other."""
    points = np.array([[10.0, 30, 50, 60, 70, 90]])
    along = np.array([[0.0, 0.0], [40.0, 80.0]])
    forces = BarForces(points, along, np.array([[7.0, 7.0], [-7.0, -7.0]]))
    assert_allclose(forces.axial(0), [[-7, -7, 0, 0, 0, 0]], atol=1e-12)
    assert_allclose(forces.axial(1), [[-7, -7, -7, -7, -7, 0]], atol=1e-12)


def test_a_bar_that_stands_presses_its_foot_by_all_of_its_weight_and_its_top_by_none():
    points = np.array([[10.0, 30, 50, 60, 70, 90]])
    forces = BarForces(points, np.array([[0.0], [100.0]]), np.array([[5.0], [0.0]]))
    assert_allclose(forces.axial(0), 5 * (points / 100 - 1), rtol=1e-12)


def test_weight_and_inertia_of_a_rigid_body_act_at_its_centre(quick_return):
    """m (g - a) of the lever: at k = 0 the crank turns at 10 rad/s square to it, 180 of 110 mm."""
    model, run, rows = quick_return
    link = model.number("lever")
    lever = run.linkage.body("lever")
    arms = [(at, force) for k, at, force in forces_of(model, rows).arms if k == link]
    (force,) = [force for at, force in arms if np.allclose(at, lever.centre)]
    _, _, alpha = run.accelerations[0, link + 1]
    omega = run.velocities[0, link + 1, 2]
    assert_allclose(omega, 10 * 70 / 180, rtol=1e-9)
    centre = lever.centre[0]
    expected = lever.mass * np.array([omega**2 * centre, -9810.0 - alpha * centre])
    assert_allclose(force[0], expected, rtol=1e-6, atol=1e-9)


def form(forces, placed, k, column):
    """Geometric stiffness of 1 N of one of the forces alone."""
    sizes = np.zeros_like(forces.sizes)
    sizes[:, column] = 1.0
    alone = replace(forces)
    alone.__dict__["sizes"] = sizes
    return alone.geometric(placed, k)


def test_what_a_block_presses_in_a_slot_goes_along_with_the_block(quick_return):
    """From the lever's pivot to the crank pin: 110 mm and 70 mm at the angle of the crank."""
    model, run, rows = quick_return
    link = model.number("lever")
    forces = forces_of(model, rows)
    first = next(n for n, (k, _, _) in enumerate(forces.arms) if k == link)
    place = forces.arms[first][1]
    distance = np.hypot(110 + 70 * np.cos(run.positions), 70 * np.sin(run.positions))
    assert_allclose(place[:, 0], distance, rtol=1e-6)
    assert_allclose(place[:, 1], 0, atol=1e-6)
    before = sum(len(bar.pushed) for bar in forces.bars.values()) + 2 * first
    for k in (0, 3, 8):
        placed = model.placed(run.poses[k])
        along_x = form(forces, placed, k, before)  # f . r of a turn in the plane
        turn = placed.part(link)[5]
        assert_allclose(along_x[turn, turn], 110 + 70 * np.cos(run.positions[k]), rtol=1e-6)


def test_a_block_that_carries_a_lever_turns_its_force_with_it(quick_return):
    """Lever level at k = 0: what hangs at 200 mm, less its weight, over 180 mm, up on the block."""
    model, run, rows = quick_return
    forces, placed = forces_of(model, rows), model.placed(run.poses[0])
    slot = next(joint for joint in run.linkage.joints if joint.name == "slot")
    a, b, normal = rows.contact(placed, slot, 0)
    assert_allclose(normal, [0, 1], atol=1e-9)
    lever = run.linkage.body("lever")
    link = model.number("lever")
    rod = next(load for load in run.body_loads("lever") if load.point == "B").force[0, 1]
    centre, alpha = lever.centre[0], run.accelerations[0, link + 1, 2]
    inertia = lever.inertia + lever.mass * centre**2
    up = (200 * rod - lever.mass * 9810 * centre - inertia * alpha) / 180
    sizes = forces.sizes[0]
    found = sum(sizes[n] * form(forces, placed, 0, n) for n in (len(sizes) - 2, len(sizes) - 1))
    expected = slot_force(a, b, normal, up)
    assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())
    assert up > 200


def test_forces_of_many_positions_add_up_to_what_each_makes_by_itself(quick_return):
    model, run, rows = quick_return
    forces = forces_of(model, rows)
    some = np.array([0, 7, len(run.positions) - 1])
    together = forces.geometric(model.placed(run.poses[some]), some)
    for k, found in zip(some, together, strict=True):
        placed = model.placed(run.poses[k])
        forms = [form(forces, placed, k, n) for n in range(forces.sizes.shape[1])]
        one_by_one = np.tensordot(forces.sizes[k], forms, 1)
        assert_allclose(found, one_by_one, rtol=0, atol=1e-12 * np.abs(one_by_one).max())


def test_joints_of_many_positions_hold_what_each_does_by_itself(quick_return):
    model, run, rows = quick_return
    some = np.array([0, 5, 8])
    for stiff in (False, True):
        together = rows.rows(model.placed(run.poses[some]), some, stiff=stiff)
        for k, found in zip(some, together, strict=True):
            alone = rows.rows(model.placed(run.poses[k]), int(k), stiff=stiff)
            assert_allclose(found, alone, rtol=0, atol=1e-12 * np.abs(alone).max())


# joints ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stiff", [False, True])
def test_joints_let_the_linkage_go_its_own_way_and_only_the_drive_holds_it(quick_return, stiff):
    """Velocities of the cycle, of all nodes of all links: a block slides, it is not pinned."""
    model, run, rows = quick_return
    for k in range(len(run.positions)):
        placed = model.placed(run.poses[k])
        going = np.zeros(placed.n_unknowns)
        for n, link in enumerate(model.links):
            v_x, v_y, omega = run.velocities[k, n + 1]
            c, s = np.cos(placed.angles[n]), np.sin(placed.angles[n])
            nodes = np.zeros((1, 2)) if link.frame is None else link.frame.nodes[:, :2]
            for node, place in enumerate(nodes):
                x, y = placed.to_ground(n, place) - run.poses[k, n + 1, :2]
                v = np.array([v_x - omega * y, v_y + omega * x])
                own = placed.part(n)[6 * node + np.array([0, 1, 5])]
                going[own] = c * v[0] + s * v[1], -s * v[0] + c * v[1], omega
        *joints, drive = rows.rows(placed, k, stiff=stiff) @ going
        assert_allclose(joints, 0, atol=1e-6)  # of up to 2 m/s
        assert_allclose(drive, 10.0, rtol=1e-9)


def test_a_slot_with_stiff_forks_holds_sideways_and_tilts_and_with_soft_ones_neither(
    quick_return,
):
    model, run, rows = quick_return
    placed = model.placed(run.poses[2])
    slot = next(joint for joint in run.linkage.joints if joint.name == "slot")
    counts = [len(rows.rows(placed, 2, stiff=stiff)) for stiff in (False, True)]
    by_joint = [len(rows._slide_holds(slot, stiff)) for stiff in (False, True)]
    assert by_joint == [1, 4]  # the guide's turn; then z and both tilts besides
    pairs = [(first, body) for _, (first, *others) in rows._pins for body in others]
    soft_pins = sum(rows._soft_axis(placed, *pair) is not None for pair in pairs)
    assert len(pairs) == len(run.linkage.joints[2:])
    assert counts[1] - counts[0] == 3 + soft_pins


def with_joint(model, name, joint):
    """The model with another joint in place of a named one, however many it may then move by."""
    joints = [joint if one.name == name else one for one in model.linkage.joints]
    linkage = copy(model.linkage)
    object.__setattr__(linkage, "joints", tuple(joints))
    return replace(model, linkage=linkage)


def test_a_pin_in_a_slot_is_held_square_to_it_and_nowhere_else(quick_return):
    """Across the lever, not along it and not against turning; z and tilts only by stiff forks."""
    model, run, _ = quick_return
    slot = Slot("slot", "lever", "block", "O1", "a", (1.0, 0.0))
    rows = JointRows(with_joint(model, "slot", slot), run)
    placed = model.placed(run.poses[3])
    block, turn = (
        placed.part(model.number("block")),
        placed.angles[model.number("lever")],
    )
    for stiff, count in ((False, 1), (True, 2)):
        held = rows.rows(placed, 3, stiff=stiff)[5 : 5 + count, block]  # behind the hammer's guide
        along = np.array([np.cos(turn), np.sin(turn), 0, 0, 0, 0])
        across = np.array([-np.sin(turn), np.cos(turn), 0, 0, 0, 0])
        angle = placed.angles[model.number("block")]
        c, s = np.cos(angle), np.sin(angle)
        own = np.eye(6)
        own[:2, :2] = [[c, s], [-s, c]]  # a motion in ground axes in those of the block
        assert_allclose(held @ own @ along, 0, atol=1e-12)
        assert_allclose(held @ own @ across, np.eye(count)[0], atol=1e-12)
        assert_allclose(held[:, 5], 0, atol=1e-12)


def test_a_weld_holds_the_turn_that_a_pin_lets_go(quick_return):
    model, run, pinned = quick_return
    welded = JointRows(with_joint(model, "a", Fixed("a", "crank", "block", "a")), run)
    placed = model.placed(run.poses[0])
    turn = placed.part(model.number("block"))[5]
    held = [np.abs(rows.rows(placed, 0, stiff=True)[10:, turn]).max() for rows in (pinned, welded)]
    assert_allclose(held, [0, 1], atol=1e-12)


# which position is the lowest --------------------------------------------------------------------


def test_a_position_that_only_the_fine_frame_shows_to_be_the_lowest_is_found():
    """Coarse factors are up to 3 % too high: 1/0.98 may be 1/1.005 in truth, 1/0.95 may not."""
    asked, proven = [], []

    def largest_inverses(places, case):
        asked.extend(k for _, k in places)
        return {place: {4: 1.001, 7: 1.005, 1: 1.002}[place[1]] for place in places}

    def factor(name, k, case):
        proven.append(k)
        return 1 / 1.005

    ranked = [(1.0, ("a", 4)), (0.98, ("a", 7)), (0.979, ("a", 1)), (0.95, ("a", 2))]
    search = SimpleNamespace(factor=factor, largest_inverses=largest_inverses)
    assert Search.lowest(search, IN, ranked) == (1 / 1.005, "a", 7)
    assert asked == [4, 7, 1]
    assert proven == [7]


def test_phase_ends_and_largest_forces_are_asked_between_the_even_positions():
    """A blow at 37, its pull at 53, and a second phase from 61 on; every 20th position besides."""
    phases = np.repeat([0, 1], [61, 39])
    forces = np.zeros((100, 2))
    forces[37, 0], forces[53, 1] = 9e3, -5e3
    run = SimpleNamespace(positions=np.arange(100.0), phase_of=phases)
    asked = _spread(run, 20, forces)
    assert asked.tolist() == [0, 20, 37, 40, 53, 60, 61, 80, 99]


@pytest.fixture(scope="module")
def two_pushes(tmp_path_factory):
    """400 N on the crank and slider, and twice all forces in the same poses; coarse frames."""
    design = machine(tmp_path_factory.mktemp("rod"), BAR, "cycles.turn.positions=73")
    run = solved(design)["turn"]
    twice = replace(
        run,
        reactions={name: replace(f, force=2 * f.force) for name, f in run.reactions.items()},
        efforts={name: 2 * effort for name, effort in run.efforts.items()},
    )
    runs = {"turn": run, "twice": twice}
    return runs, Search(design, runs, COARSE)


def test_positions_are_ranked_by_their_own_loads_and_none_near_the_lowest_is_left_out(
    two_pushes,
):
    """Poses of both cycles are solved together; every position by itself gives the same factor."""
    runs, search = two_pushes
    ranked = search.ranked()
    for case in (IN, SOFT, STIFF):
        inverses = [inverse for inverse, _ in ranked[case]]
        assert inverses == sorted(inverses, reverse=True)
        known = {place: inverse for inverse, place in ranked[case]}
        assert len(known) == len(inverses)
        for name, run in runs.items():
            for k in range(0, len(run.positions), 3):
                factor = search.factor(name, k, case)
                inverse = 0.0 if factor is None else 1 / factor
                if (name, k) in known:
                    assert known[name, k] == pytest.approx(inverse, rel=1e-6)
                else:
                    assert inverse * 1.03 <= inverses[0] * (1 + 1e-9)
    assert ranked[IN][0][1][0] == "twice"


def test_the_lowest_with_stiff_forks_is_that_of_frames_with_stiff_forks(two_pushes):
    _, search = two_pushes
    ranked = search.ranked()[STIFF]
    factor, name, k = search.lowest(STIFF, ranked)
    assert factor == pytest.approx(search.factor(name, k, STIFF))
    assert factor > 1.5 * search.factor(name, k, SOFT)


def test_forks_that_hold_all_tilts_leave_the_mode_in_the_plane_as_the_lowest(tmp_path):
    """A round rod: out of the plane 21 with soft forks and above 100 with stiff ones, 36 in it.

    The crank stops short of a whole turn: it swings in a fork.
    """
    design = machine(tmp_path, BAR, 'cycles.turn.phases[0].to="449 deg"')
    mode = worst_mode(design, solved(design))
    assert mode.plane == "out of plane"
    assert mode.factor < mode.other_plane
    assert mode.stiff_factor == mode.other_plane
