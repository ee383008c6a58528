"""An interface that names a slot or guide gets its force where the contact really is."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads import (
    GROUND,
    Angle,
    Body,
    Cycle,
    Force,
    Friction,
    Linkage,
    LinkageError,
    MeasuredBody,
    MeasuredLoad,
    MeasuredLoads,
    Phase,
    Prismatic,
    Revolute,
    Slot,
    SteadyPace,
    run_cycle,
)

RADIUS, BASE, SPEED = 70.0, 110.0, 4.0
OWN = {"pivot": "O1", "flanks": "slot"}


def lever(coefficient=0.12, guided=False, line="O1", loaded=True):
    """Crank about (110, 0); its pin, or a block on it, slides along a heavy lever about O1.

    line    point of the lever, O1 or L, through which the slot's line is stated
    loaded  whether a torque holds the lever back, or its inertia alone
    """
    mass, block = 1e-3, Body("block", {"a": (0.0, 0.0)}, 5e-4)
    slider = "block" if guided else "crank"
    kind = Prismatic if guided else Slot
    return Linkage(
        bodies=(
            Body(GROUND, {"O1": (0.0, 0.0), "O2": (BASE, 0.0)}),
            Body("crank", {"O2": (0.0, 0.0), "a": (RADIUS, 0.0)}, mass, 100 * mass, (20.0, 5.0)),
            Body(
                "lever",
                {"O1": (0.0, 0.0), "L": (30.0, 0.0)},
                mass,
                3000 * mass,
                (100.0, -7.0),
            ),
            *([block] if guided else []),
        ),
        joints=(
            Revolute("O1", GROUND, "lever", "O1"),
            Revolute("O2", GROUND, "crank", "O2"),
            *([Revolute("a", "crank", "block", "a")] if guided else []),
            kind("slot", "lever", slider, line, "a", (1.0, 0.0)),
        ),
        forces=(
            Force("drive", Angle("crank", point="O2")),
            *([Force("load", Angle("lever", point="O1"))] if loaded else []),
        ),
        assembled={
            "crank": (BASE, 0.0, 0.0),
            "lever": (0.0, 0.0, 0.0),
            **({"block": (BASE + RADIUS, 0.0, 0.0)} if guided else {}),
        },
        friction={
            "slot": Friction(coefficient),
            **({"a": Friction(coefficient, 6.0)} if guided else {}),
        },
    )


def turn(linkage):
    crank = Angle("crank")
    given = {force.name: -5000.0 for force in linkage.forces if force.name == "load"}
    phase = Phase("turn", 2 * np.pi, given, "drive")
    return run_cycle(linkage, Cycle("turn", crank, 0.0, SteadyPace(crank, SPEED), (phase,), 60))


@pytest.fixture(scope="module")
def loads():
    return turn(lever())


def test_the_contact_is_where_the_law_of_cosines_puts_the_pin(loads):
    history = loads.part_history("lever", OWN)
    distance = np.sqrt(RADIUS**2 + BASE**2 + 2 * RADIUS * BASE * np.cos(loads.positions))
    assert history.interfaces == ("pivot", "flanks")
    assert_allclose(history.reaches[:, 1, 0], distance, rtol=1e-10)
    assert_allclose(history.reaches[:, 1, 1], 0.0, atol=1e-9)
    assert not history.reaches[:, 0].any()
    assert_allclose(history.reaches[:, 1, 0], loads.travel("slot"), rtol=1e-12)


def test_a_pin_presses_on_its_slot_without_a_couple_at_the_contact(loads):
    """Its wrench, stated at O1, is the moment of the force at the contact and nothing else."""
    history = loads.part_history("lever", OWN)
    wrench, reach = history.wrenches[:, 1], history.reaches[:, 1]
    moment = reach[:, 0] * wrench[:, 1] - reach[:, 1] * wrench[:, 0]
    assert_allclose(wrench[:, 5], moment, rtol=0, atol=1e-10 * np.abs(moment).max())
    # across the line the normal force, along it the friction, against the pin's way
    ratio = np.abs(wrench[:, 0]) / np.abs(wrench[:, 1])
    assert_allclose(ratio[ratio > 1e-9], 0.12, rtol=1e-9)


def test_the_pivot_keeps_everything_else_at_the_same_point(loads):
    """Pivot and slot add up to what the point O1 gets where no interface names the slot."""
    alone = loads.part_history("lever", {"pivot": "O1"})
    history = loads.part_history("lever", OWN)
    scale = np.abs(alone.wrenches).max()
    total = history.wrenches.sum(axis=1)
    assert_allclose(total, alone.wrenches[:, 0], rtol=0, atol=1e-12 * scale)
    assert not alone.reaches.any()
    pin = loads.reactions["O1"].force
    angle = loads.poses[:, 2, 2]
    assert_allclose(
        history.wrenches[:, 0, 0], np.cos(angle) * pin[:, 0] + np.sin(angle) * pin[:, 1], rtol=1e-9
    )
    body = loads.linkage.body("lever")
    left = history.equilibrium_residual(body.mass, body.centre, body.inertia)
    assert np.abs(left).max() < 1e-10 * scale


def test_a_slots_wrench_is_stated_at_the_point_of_its_line():
    """Line through L, 30 mm from the pivot: the way to the contact is 30 mm shorter, the moment
    about L is that of the force there, and the part is in equilibrium.
    """
    at_pivot, at_line = turn(lever()), turn(lever(line="L"))
    near, far = (run.part_history("lever", OWN) for run in (at_pivot, at_line))
    assert_allclose(far.locations, [[0, 0], [30, 0]])
    assert_allclose(far.reaches[:, 1, 0], near.reaches[:, 1, 0] - 30, rtol=0, atol=1e-9)
    scale = np.abs(near.wrenches).max()
    moved = near.wrenches[:, 1, 5] - 30 * near.wrenches[:, 1, 1]
    assert_allclose(far.wrenches[:, 1, 5], moved, rtol=0, atol=1e-9 * scale)
    body = at_line.linkage.body("lever")
    left = far.equilibrium_residual(body.mass, body.centre, body.inertia)
    assert np.abs(left).max() < 1e-10 * scale


def test_an_interface_at_a_point_never_has_a_reach():
    """Also where the slot's force is the last that is summed there."""
    history = turn(lever(loaded=False)).part_history("lever", {"pivot": "O1"})
    assert np.abs(history.wrenches).max() > 0
    assert not history.reaches.any()


def test_a_block_that_rubs_on_its_pin_presses_with_a_couple():
    """The couple of the pin's friction goes through the guide into the lever: mu r F."""
    loads = turn(lever(guided=True))
    history = loads.part_history("lever", OWN)
    wrench, reach = history.wrenches[:, 1], history.reaches[:, 1]
    couple = wrench[:, 5] - reach[:, 0] * wrench[:, 1] + reach[:, 1] * wrench[:, 0]
    rubbed = loads.reactions["a"].friction_couple
    assert np.abs(rubbed).max() > 1.0
    assert_allclose(np.abs(couple), np.abs(rubbed), rtol=1e-8, atol=1e-8 * np.abs(rubbed).max())


def test_two_interfaces_on_one_slot_are_refused(loads):
    with pytest.raises(LinkageError, match="two interfaces are at the same joint 'slot'"):
        loads.part_history("lever", {**OWN, "again": "slot"})


def test_a_slot_of_another_body_is_no_interface(loads):
    """The crank's pin slides in it, but the line is the lever's."""
    with pytest.raises(LinkageError, match=r"interface 'eye' needs a point, 'slot', that it does"):
        loads.part_history("crank", {"axis": "O2", "eye": "slot"})
    with pytest.raises(LinkageError, match=r"a point or a slot or guide on it, 'slat', .*'slot'"):
        loads.part_history("lever", {"pivot": "O1", "flanks": "slat"})


def test_a_slot_alone_does_not_take_the_loads_of_its_point(loads):
    with pytest.raises(LinkageError, match=r"joint 'O1' acts at point 'O1', which is no interface"):
        loads.part_history("lever", {"flanks": "slot"})


def test_measured_loads_know_points_only():
    n = 3
    load = MeasuredLoad("P", np.zeros((n, 2)), np.zeros(n))
    entry = MeasuredBody(
        Body("lever", {"P": (0.0, 0.0)}), (load,), np.zeros(n), np.zeros((n, 2)), *np.zeros((2, n))
    )
    run = MeasuredLoads("run", np.arange(n) * 1.0, None, {"lever": entry})
    with pytest.raises(LinkageError, match=r"'flanks' needs a point 'slot'.*no slots or guides"):
        run.part_history("lever", {"pivot": "P", "flanks": "slot"})
    assert run.part_history("lever", {"pivot": "P"}).reaches.shape == (n, 1, 2)


def test_a_history_with_reaches_of_another_shape_is_refused(loads):
    history = loads.part_history("lever", OWN)
    with pytest.raises(ValueError, match=r"need reaches of shape \(60, 2, 2\), got \(60, 2\)"):
        replace(history, reaches=history.reaches[:, :, 0])
    assert_allclose(history.scaled(2.0).reaches, history.reaches)


def test_a_torque_at_no_stated_point_is_refused_with_those_it_may_have():
    linkage = lever()
    drive, load = linkage.forces
    turned = turn(replace(linkage, forces=(drive, replace(load, coordinate=Angle("lever")))))
    with pytest.raises(LinkageError, match=r"stated point; state its `at`, one of O1$"):
        turned.part_history("lever", OWN)
