"""Forces whose direction turns with a body: torque by hand, work, what they cannot be."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import loads

ARM = 300.0  # mm


def wiper(law, direction=(0.0, 1.0), follows="arm", solve="motor", positions=61):
    """An arm on a pivot, rubbed at its tip along a direction, which swings 100 degrees."""
    ground = loads.Body("ground", {"O": (0.0, 0.0)})
    arm = loads.Body("arm", {"O": (0.0, 0.0), "T": (ARM, 0.0)})
    linkage = loads.Linkage(
        (ground, arm),
        (loads.Revolute("O", "ground", "arm", "O"),),
        (
            loads.Force("motor", loads.Angle("arm")),
            loads.Force("rub", loads.PointCoordinate("arm", "T", direction, follows)),
        ),
        {"arm": (0.0, 0.0, 0.2)},
        gravity=(0.0, 0.0),
    )
    angle = loads.Angle("arm")
    other = {"motor": "rub", "rub": "motor"}[solve]
    phases = (
        loads.Phase("there", 0.2 + np.radians(100), {other: law}, solve),
        loads.Phase("back", 0.2, {other: law}, solve),
    )
    return linkage, loads.Cycle(
        "swing", angle, 0.2, loads.SteadyPace(angle, 3.0), phases, positions
    )


def slider_crank(direction, size):
    """A massless in-line slider-crank; a force of constant size on A turns with the rod."""
    crank, rod, start = 60.0, 200.0, 0.5
    turn = -np.arcsin(crank * np.sin(start) / rod)
    end = crank * np.cos(start) + rod * np.cos(turn)
    linkage = loads.Linkage(
        (
            loads.Body("ground", {"O": (0.0, 0.0)}),
            loads.Body("crank", {"O": (0.0, 0.0), "A": (crank, 0.0)}),
            loads.Body("rod", {"A": (0.0, 0.0), "B": (rod, 0.0)}),
            loads.Body("slider", {"B": (0.0, 0.0)}),
        ),
        (
            loads.Revolute("O", "ground", "crank", "O"),
            loads.Revolute("A", "crank", "rod", "A"),
            loads.Revolute("B", "rod", "slider", "B"),
            loads.Prismatic("guide", "ground", "slider", "O", "B", (1.0, 0.0)),
        ),
        (
            loads.Force("motor", loads.Angle("crank")),
            loads.Force("jet", loads.PointCoordinate("crank", "A", direction, "rod")),
        ),
        {
            "crank": (0.0, 0.0, start),
            "rod": (crank * np.cos(start), crank * np.sin(start), turn),
            "slider": (end, 0.0, 0.0),
        },
        gravity=(0.0, 0.0),
    )
    angle = loads.Angle("crank")
    phase = loads.Phase("turn", start + 2 * np.pi, {"jet": size}, "motor")
    cycle = loads.Cycle("cycle", angle, start, loads.SteadyPace(angle, 5.0), (phase,), 361)
    return loads.run_cycle(linkage, cycle)


def test_a_force_across_an_arm_keeps_its_torque_while_its_arm_turns():
    """F across the arm at its tip is F l at any angle; on the ground it turns with the arm."""
    run = loads.run_cycle(*wiper(8.0))
    assert_allclose(run.efforts["motor"], -8.0 * ARM, rtol=1e-12)
    across = np.stack([-np.sin(run.positions), np.cos(run.positions)], axis=1)
    (push,) = [load for load in run.body_loads("arm") if load.source == "force 'rub'"]
    assert_allclose(push.force, 8.0 * across, atol=1e-12)
    assert_allclose(run.reactions["O"].force, -8.0 * across, atol=1e-12)
    assert run.power_balance_error < 1e-12


def test_a_wiper_that_rubs_across_its_arm_takes_its_force_times_the_arc_and_reverses_at_the_ends():
    linkage, cycle = wiper(loads.Opposing(dry=8.0), positions=721)
    split, _ = loads.split_cycle(linkage, cycle)
    run = loads.run_cycle(linkage, split)
    there = run.phase_of == 0
    assert_allclose(run.efforts["rub"][there], -8.0)
    assert_allclose(run.efforts["rub"][~there], 8.0)
    arc = ARM * np.radians(100)
    assert run.drive("rub").work == pytest.approx(-8.0 * 2 * arc, rel=1e-5)
    assert run.power_balance_error < 1e-12


def test_a_force_that_turns_with_another_body_than_it_acts_on_has_the_power_of_its_own_point():
    """By hand: the torque on the crank is that of F (cos, sin)(rod's angle + 30 deg) at its pin."""
    run = slider_crank((np.cos(np.pi / 6), np.sin(np.pi / 6)), 40.0)
    rod = -np.arcsin(60.0 * np.sin(run.positions) / 200.0)
    torque = 40.0 * 60.0 * np.sin(rod + np.pi / 6 - run.positions)
    assert_allclose(run.efforts["motor"], -torque, atol=1e-6)
    assert run.power_balance_error < 1e-9


def test_a_force_that_follows_can_be_the_one_that_is_solved_for():
    run = loads.run_cycle(*wiper(2400.0, solve="rub"))
    assert_allclose(run.efforts["rub"], -8.0, rtol=1e-12)


def test_a_direction_that_turns_gives_no_position_to_sweep_touch_or_table():
    linkage, cycle = wiper(loads.Contact(at=1.0, stiffness=1.0))
    with pytest.raises(loads.LinkageError, match=r"T along \(0, 1\) of arm has no position"):
        loads.run_cycle(linkage, cycle)
    turning = loads.PointCoordinate("arm", "T", (0.0, 1.0), "arm")
    linkage, cycle = wiper(loads.Table(turning, (0.0, 1.0), (0.0, 1.0)))
    with pytest.raises(loads.LinkageError, match="has no position"):
        loads.run_cycle(linkage, cycle)


def test_a_direction_of_a_body_that_is_not_there_is_refused():
    with pytest.raises(loads.LinkageError, match=r"force 'rub'.*arn"):
        wiper(1.0, follows="arn")
