"""Forces tabled over the motion, strokes with a law, speeds that change, and ends of slots."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads import (
    GROUND,
    Angle,
    Body,
    Contact,
    Cycle,
    Fixed,
    Force,
    Linkage,
    LinkageError,
    Phase,
    PointCoordinate,
    Prismatic,
    SteadyPace,
    StrokePace,
    Table,
    run_cycle,
)

from .machines import slider_crank

X = PointCoordinate("block", "P", (1.0, 0.0))


def block(mass=2e-3, ends=None):
    """A block on a level guide, pushed by ``push`` against ``load``; nothing else acts."""
    return Linkage(
        bodies=(Body(GROUND, {"O": (0.0, 0.0)}), Body("block", {"P": (0.0, 0.0)}, mass)),
        joints=(Prismatic("rail", GROUND, "block", "O", "P", (1.0, 0.0), ends),),
        forces=(
            Force("push", X),
            Force("load", PointCoordinate("block", "P", (-1.0, 0.0))),
        ),
        assembled={"block": (0.0, 0.0, 0.0)},
        gravity=(0.0, -9810.0),
    )


def slid(linkage, pace, *stops, load=0.0, positions=200, start=0.0):
    phases = tuple(Phase(f"to {stop:g}", stop, {"load": load}, "push") for stop in stops)
    return run_cycle(linkage, Cycle("slide", X, start, pace, phases, positions))


# strokes


@pytest.mark.parametrize(
    ("law", "speed", "acceleration"),
    [("harmonic", np.pi / 2, np.pi**2 / 2), ("cycloidal", 2.0, 2 * np.pi),
     ("polynomial", 1.875, 10 / np.sqrt(3))],
)  # fmt: skip
def test_a_stroke_reaches_the_largest_speed_and_force_of_its_law(law, speed, acceleration):
    """Norton, Design of Machinery, table 8-2: peak factors of way/time and way/time2."""
    cycle = slid(block(), StrokePace(X, law, 0.5), 100.0, positions=2000)
    assert_allclose(np.abs(cycle.velocities[:, 1, 0]).max(), speed * 100 / 0.5, rtol=1e-4)
    force = np.abs(cycle.efforts["push"]).max()
    assert_allclose(force, 2e-3 * acceleration * 100 / 0.5**2, rtol=1e-3)
    assert_allclose(cycle.times[-1], 0.5)
    assert_allclose(cycle.velocities[[0, -1], 1, 0], 0.0, atol=1e-9)


@pytest.mark.parametrize("law", ["harmonic", "cycloidal", "polynomial"])
def test_position_speed_and_acceleration_of_a_stroke_belong_to_its_time(law):
    """Speed integrates to the way, acceleration to the speed (trapezoids over uneven times)."""
    cycle = slid(block(), StrokePace(X, law, 0.3), 40.0, positions=4000)
    spans = np.diff(cycle.times)
    for rate, value in (
        (cycle.velocities[:, 1, 0], cycle.positions),
        (cycle.accelerations[:, 1, 0], cycle.velocities[:, 1, 0]),
    ):
        gone = np.cumsum(0.5 * (rate[1:] + rate[:-1]) * spans)
        assert_allclose(gone, value[1:] - value[0], atol=1e-4 * np.ptp(value))


def test_phases_of_one_direction_are_one_stroke_and_the_way_back_another():
    """At 30 of 100 mm a harmonic stroke runs at sqrt(0.3 x 0.7) pi way/time, and does not stop."""
    cycle = slid(block(), StrokePace(X, "harmonic", 0.5), 30.0, 100.0, 0.0)
    border = int(np.argmax(cycle.phase_of == 1))
    expected = np.pi * np.sqrt(0.3 * 0.7) * 100 / 0.5
    assert_allclose(cycle.velocities[border, 1, 0], expected, rtol=1e-9)
    turn = int(np.argmax(cycle.phase_of == 2))
    assert_allclose(cycle.times[[turn - 1, turn, -1]], [0.5, 0.5, 1.0])
    assert (np.diff(cycle.times) >= 0.0).all()


def test_friction_at_the_ends_of_a_stroke_is_that_of_the_motion_beginning_there():
    """A block at rest that is about to slide needs mu W: the sign is the motion's, not zero."""
    from loads import Friction

    rough = replace(block(), friction={"rail": Friction(0.2)})
    cycle = slid(rough, StrokePace(X, "cycloidal", 1.0), 10.0, 0.0)
    weight = 2e-3 * 9810.0
    assert_allclose(cycle.efforts["push"][[0, -1]], [0.2 * weight, -0.2 * weight], rtol=1e-9)


# speeds that change


def test_a_speed_rises_evenly_in_time():
    """v2 = v0^2 + 2 a s; t = (v - v0) / a, here 100, 300 mm/s and 2 s over 400 mm."""
    cycle = slid(block(), SteadyPace(X, 100.0, 100.0), 100.0, 400.0)
    assert_allclose(cycle.velocities[-1, 1, 0], 300.0)
    assert_allclose(cycle.times[-1], 2.0)
    assert_allclose(cycle.efforts["push"], 2e-3 * 100.0, rtol=1e-9)


@pytest.mark.parametrize("acceleration", [100.0, 0.0, -12.0])
def test_a_steady_pace_goes_on_over_phases_there_and_back(acceleration):
    """Over all the way there and back, v2 = v0^2 + 2 a s and s = (v0 + v) t / 2."""
    cycle = slid(block(), SteadyPace(X, 100.0, acceleration), 60.0, 100.0, 40.0, 30.0, 90.0)
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(cycle.positions)))])
    speed = np.sqrt(100.0**2 + 2 * acceleration * way)
    assert_allclose(np.abs(cycle.velocities[:, 1, 0]), speed, rtol=1e-9)
    assert_allclose(cycle.times, 2 * way / (100.0 + speed), rtol=1e-9, atol=1e-12)
    assert_allclose(way[-1], 100.0 + 70.0 + 60.0)


def test_a_pace_with_two_speeds_keeps_each_in_its_direction():
    """60 mm out at 120 mm/s and 50 back at 100 are 0.5 s each, 20 out again 1/6 s."""
    cycle = slid(block(), SteadyPace(X, 120.0, falling=100.0), 60.0, 10.0, 30.0)
    assert_allclose(cycle.times[[0, -1]], [0.0, 1.0 + 20.0 / 120.0], rtol=1e-12)
    for k, speed in enumerate((120.0, -100.0, 120.0)):
        rows = cycle.phase_of == k
        assert_allclose(cycle.velocities[rows, 1, 0], speed, rtol=1e-12)
        assert_allclose(np.diff(cycle.times[rows]), np.diff(cycle.positions[rows]) / speed)
    assert np.diff(cycle.times).min() > -1e-12
    assert SteadyPace(X, 120.0, falling=100.0).times(0.5) == SteadyPace(X, 60.0, falling=50.0)


def test_a_turning_crank_carries_its_acceleration():
    """Drive torque of a bare flywheel: I alpha, whichever way it turns."""
    linkage = slider_crank(50.0, 200.0, crank_body={"inertia": 3.0})
    crank = Angle("crank")
    for stop in (6.0, -6.0):
        phase = Phase("turn", stop, {"push": 0.0}, "drive")
        cycle = run_cycle(linkage, Cycle("run", crank, 0.0, SteadyPace(crank, 4.0, 2.0), (phase,)))
        assert_allclose(cycle.efforts["drive"], np.sign(stop) * 6.0, rtol=1e-9, atol=1e-9)


def test_a_speed_that_falls_to_nothing_is_refused():
    with pytest.raises(
        LinkageError, match=r"P\.x slows down by 100 mm/s2 and stands still before P\.x = 50"
    ):
        slid(block(), SteadyPace(X, 100.0, -100.0), 60.0)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: SteadyPace(X, 0.0),
        lambda: SteadyPace(X, float("nan")),
        lambda: SteadyPace(X, 1.0, falling=0.0),
        lambda: SteadyPace(X, 1.0, 2.0, 3.0),
        lambda: StrokePace(X, "sine", 1.0),
        lambda: StrokePace(X, "harmonic", 0.0),
        lambda: Table(X, (0.0, 1.0, 1.0), (1.0, 2.0, 3.0)),
        lambda: Table(X, (0.0,), (1.0,)),
        lambda: Table(X, (0.0, float("inf")), (1.0, 1.0)),
        lambda: Contact(float("nan")),
        lambda: Contact(0.0, -1.0),
        lambda: Contact(0.0, 1.0, side=0),
        lambda: block(ends=(5.0, 5.0)),
    ],
)
def test_what_cannot_be_meant_is_refused_when_it_is_stated(wrong):
    with pytest.raises(LinkageError):
        wrong()


# tables and contacts


def test_a_table_is_linear_between_its_points_and_has_a_position_at_each():
    table = Table(X, (0.0, 10.0, 50.0), (0.0, 300.0, 100.0))
    cycle = slid(block(mass=0.0), SteadyPace(X, 10.0), 50.0, load=table, positions=37)
    expected = np.interp(cycle.positions, table.values, table.forces)
    assert_allclose(cycle.efforts["push"], expected, atol=1e-9)
    assert np.abs(cycle.positions - 10.0).min() < 1e-9
    assert_allclose(cycle.drive("push").work, 0.5 * 300 * 10 + 0.5 * 400 * 40, rtol=1e-9)


def test_a_table_over_another_coordinate_follows_the_linkage():
    """Over the slider's place while the crank is swept."""
    linkage = slider_crank(50.0, 200.0)
    slider = PointCoordinate("slider", "B", (1.0, 0.0))
    table = Table(slider, (140.0, 200.0, 260.0), (0.0, -50.0, 0.0))
    crank = Angle("crank")
    phase = Phase("turn", 6.0, {"push": table}, "drive")
    cycle = run_cycle(linkage, Cycle("run", crank, 0.0, SteadyPace(crank, 4.0), (phase,)))
    places = cycle.poses[:, 3, 0]
    assert_allclose(cycle.efforts["push"], np.interp(places, table.values, table.forces))
    # a corner lies where the table has one, to a step squared of the sweep
    assert np.abs(places - 200.0).min() < 0.02


def test_a_table_that_does_not_cover_the_cycle_is_refused_with_the_place():
    table = Table(X, (0.0, 40.0), (0.0, 1.0))
    told = r"'slide', phase 'to 50': force 'load': its table goes .*, the phase from 0 mm to 50 mm"
    with pytest.raises(LinkageError, match=told):
        slid(block(), SteadyPace(X, 10.0), 50.0, load=table)


def test_a_spring_in_the_way_pushes_back_from_where_it_is_touched():
    """k (x - 30), which on the way back is the same: no work is lost."""
    spring = Contact(-30.0, 50.0, stops=False)
    cycle = slid(block(mass=0.0), SteadyPace(X, 10.0), 50.0, 0.0, load=spring)
    expected = 50.0 * np.maximum(cycle.positions - 30.0, 0.0)
    assert_allclose(cycle.efforts["push"], expected, atol=1e-9)
    assert np.abs(cycle.positions - 30.0).min() < 1e-9
    assert abs(cycle.drive("push").work) < 1e-6
    assert_allclose(cycle.contacts["load"].approach_speed, 10.0)


def test_a_rope_pulls_where_a_distance_grows():
    """Side -1: it is taut above its length and pulls the coordinate down."""
    rope = replace(block(mass=0.0), forces=(Force("push", X), Force("load", X)))
    taut = Contact(30.0, 50.0, side=-1, stops=False)
    cycle = slid(rope, SteadyPace(X, 10.0), 50.0, load=taut)
    assert_allclose(cycle.efforts["load"], -50.0 * np.maximum(cycle.positions - 30.0, 0.0))


# ends of slots, welds


def test_travel_up_to_the_end_of_a_slot_is_allowed_and_its_margin_told():
    cycle = slid(block(ends=(-5.0, 50.0)), SteadyPace(X, 10.0), 50.0)
    assert cycle.slot_margin["rail"] == pytest.approx(0.0, abs=1e-9)
    assert_allclose(cycle.travel("rail"), cycle.positions, atol=1e-9)


def test_travel_beyond_the_end_of_a_slot_is_refused_with_joint_and_place():
    with pytest.raises(
        LinkageError, match=r"'P' slides beyond the end of -5 \.\.\. 49\.9 mm, up to 50 mm at"
    ):
        slid(block(ends=(-5.0, 49.9)), SteadyPace(X, 10.0), 50.0)


def test_a_welded_arm_hands_its_weight_on_as_force_and_moment():
    """Arm of 3 kg, 200 mm beyond the weld: the weld carries W and W x 200 mm."""
    base = block()
    arm = Body("arm", {"P": (0.0, 0.0)}, 3e-3, 10.0, (200.0, 0.0))
    linkage = replace(
        base,
        bodies=(*base.bodies, arm),
        joints=(*base.joints, Fixed("weld", "block", "arm", "P")),
        assembled={**base.assembled, "arm": (0.0, 0.0, 0.0)},
    )
    cycle = slid(linkage, SteadyPace(X, 10.0), 50.0)
    weld = cycle.reactions["weld"]
    assert_allclose(weld.force[:, 1], 3e-3 * 9810.0)
    assert_allclose(weld.moment, 3e-3 * 9810.0 * 200.0)
    assert max(cycle.equilibrium_residual.values()) < 1e-12


# the drive


def test_ripple_and_irregularity_of_a_torque_that_swings_once_a_turn():
    """Pendulum on the crank: T = m g r cos, ripple 2 m g r; irregularity = ripple / (J w^2)."""
    mass, radius, inertia = 2e-3, 30.0, 50.0
    linkage = slider_crank(
        50.0, 200.0,
        crank_body={"mass": mass, "inertia": inertia, "centre": (radius, 0.0)},
        gravity=(0.0, -9810.0),
    )  # fmt: skip
    crank = Angle("crank")
    phase = Phase("turn", 2 * np.pi, {"push": 0.0}, "drive")
    cycle = run_cycle(linkage, Cycle("run", crank, 0.0, SteadyPace(crank, 7.0), (phase,), 2000))
    drive = cycle.drive("drive")
    whole = inertia + mass * radius**2
    assert drive.closed
    assert_allclose(drive.energy_ripple, 2 * mass * 9810.0 * radius, rtol=1e-5)
    assert_allclose(drive.mean_reduced_mass, whole, rtol=1e-9)
    assert_allclose(drive.irregularity, drive.energy_ripple / (whole * 49.0), rtol=1e-9)
    assert_allclose(drive.reduced_mass_for(drive.irregularity), whole, rtol=1e-9)
    assert_allclose(drive.peak_power, mass * 9810.0 * radius * 7.0, rtol=1e-5)
    assert abs(drive.mean_power) < 1e-6 * drive.peak_power


def test_an_open_cycle_has_no_irregularity():
    drive = slid(block(), SteadyPace(X, 10.0), 50.0).drive("push")
    assert drive.irregularity is None
    assert not drive.closed


def test_an_irregularity_without_any_mass_is_refused():
    linkage = slider_crank(50.0, 200.0)
    crank = Angle("crank")
    phase = Phase("turn", 2 * np.pi, {"push": 10.0}, "drive")
    cycle = run_cycle(linkage, Cycle("run", crank, 0.0, SteadyPace(crank, 7.0), (phase,), 100))
    with pytest.raises(LinkageError, match="nothing that it drives has a mass"):
        _ = cycle.drive("drive").irregularity


@pytest.mark.parametrize(
    ("speed", "torques", "ripple", "irregularity"),
    [(5.0, (-50.2407, 54.5741), 100.7, 5.7), (10.0, (-75.6504, 87.6727), 104.4, 1.5)],
)
def test_the_hammer_cannot_run_at_a_constant_speed(speed, torques, ripple, irregularity):
    """Mean reduced inertia 0.708 kg m2, ripple in J (independent solution); 40 kg m2 for 0.1."""
    from .machine_hammer import hammer

    crank = Angle("crank")
    phase = Phase("turn", 2 * np.pi, {"work": 0.0}, "drive")
    cycle = run_cycle(hammer(), Cycle("run", crank, 0.0, SteadyPace(crank, speed), (phase,), 721))
    drive = cycle.drive("drive")
    assert_allclose((drive.smallest, drive.largest), torques, rtol=1e-4)
    assert_allclose(drive.mean_reduced_mass, 0.708, atol=5e-4)
    assert_allclose(drive.energy_ripple, ripple, atol=0.06)
    assert_allclose(drive.irregularity, irregularity, atol=0.05)
    if speed == 5.0:
        assert_allclose(drive.reduced_mass_for(0.1), 40.0, atol=0.5)
