"""Measured loads: balance, the loads of parts and pins, and the slip that explains an imbalance.

The truth is a solved slider-crank, handed over as columns; each slip is put into them on purpose.
"""

# ruff: noqa: E501 - one slip a line: what is done to the data, then what is suggested

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads import LinkageError, MeasuredLoads, diagnose
from loads.kinematics import rotated, turned_left

from .exported import measured_from, noisy, solved_slider_crank, with_body, with_load

TOLERANCE = 0.01
GRAVITY = np.array([0.0, -9810.0])


@pytest.fixture(scope="module")
def fast():
    """A sixth of the rod's loads is inertia, its weight is not to be seen."""
    return solved_slider_crank()


@pytest.fixture(scope="module")
def runs(fast):
    slow = solved_slider_crank(speed=10.0, push=-20.0)
    return {
        "fast": measured_from(fast),
        "in body axes": measured_from(fast, in_body_frame=True),
        "slow": measured_from(slow),  # the weight is a third of the loads
    }


def scaled(x, y, moment=1.0):
    return lambda load: replace(load, force=load.force * [x, y], moment=load.moment * moment)


def swapped(load):
    return replace(load, force=load.force[:, ::-1])


def other_frame(load):
    return replace(load, in_body_frame=not load.in_body_frame)


def at(point, *changes):
    def slip(run, body):
        for change in changes:
            run = with_load(run, body, point, change)
        return run

    return slip


def motion(**changes):
    def slip(run, body):
        entry = run.bodies[body]
        changed = {key: change(getattr(entry, key)) for key, change in changes.items()}
        return with_body(run, body, **changed)

    return slip


def masses(mass, inertia=1.0):
    def slip(run, body):
        own = run.bodies[body].body
        changed = own.with_mass_properties(own.mass * mass, own.centre, own.inertia * inertia)
        return with_body(run, body, body=changed)

    return slip


def acceleration_of(point):
    def slip(run, body):
        entry = run.bodies[body]
        arm = np.array(entry.body.place(point)) - entry.body.centre
        arm = rotated(np.tile(arm, (len(entry.angle), 1)), entry.angle)
        moved = entry.acceleration + entry.angular_acceleration[:, None] * turned_left(arm)
        return with_body(run, body, acceleration=moved - entry.angular_velocity[:, None] ** 2 * arm)

    return slip


def both(first, second):
    return lambda run, body: second(first(run, body), body)


def in_the_body(acceleration_in_body_frame):
    return not acceleration_in_body_frame


SINGLE = {
    "Fx reversed": ("fast", "rod", at("B", scaled(-1, 1)), "reversing Fx at B"),
    "Fy reversed": ("fast", "rod", at("A", scaled(1, -1)), "reversing Fy at A"),
    "force reversed": ("fast", "rod", at("B", scaled(-1, -1)), "reversing the force at B"),
    "all reversed": ("fast", "rod", at(None, scaled(-1, -1)), "reversing the forces at all points"),
    "moment reversed": ("fast", "crank", at("O", scaled(1, 1, -1)), "reversing the moment at O"),
    "load by the body": ("fast", "crank", at("O", scaled(-1, -1, -1)), "reversing the force and moment at O (as given, they act by the body)"),
    "swapped": ("fast", "rod", at("A", swapped), "swapping x and y of the force at A"),
    "all swapped": ("fast", "rod", at(None, swapped), "swapping x and y of the forces at all points"),
    "ground for body": ("fast", "rod", at("B", other_frame), "taking the force at B as given in the ground's frame"),
    "body for ground": ("in body axes", "rod", at("B", other_frame), "taking the force at B as given in the body's frame"),
    "all body for ground": ("in body axes", "rod", at(None, other_frame), "taking the forces at all points as given in the body's frame"),
    "kN for N": ("fast", "rod", at("B", scaled(1e-3, 1e-3)), "multiplying the force at B by 1000 (kN taken for N)"),
    "N for kN": ("fast", "rod", at("A", scaled(1e3, 1e3)), "dividing the force at A by 1000 (N taken for kN)"),
    "all kN for N": ("fast", "rod", at(None, scaled(1e-3, 1e-3)), "multiplying the forces at all points by 1000 (kN taken for N)"),
    "kgf for N": ("fast", "rod", at("B", scaled(1 / 9.80665, 1 / 9.80665)), "multiplying the force at B by 9.807 (kgf taken for N)"),
    "lbf for N": ("fast", "rod", at("A", scaled(1 / 4.4482216, 1 / 4.4482216)), "multiplying the force at A by 4.448 (lbf taken for N)"),
    "N mm for N m": ("fast", "crank", at("O", scaled(1, 1, 1e3)), "dividing the moment at O by 1000 (N mm taken for N m)"),
    "N m for N mm": ("fast", "crank", at("O", scaled(1, 1, 1e-3)), "multiplying the moment at O by 1000 (N m taken for N mm)"),
    "deg for rad": ("fast", "rod", motion(angle=lambda a: a * 180 / pi), "taking the angle as deg (deg taken for rad)"),
    "deg for rad, in body axes": ("in body axes", "rod", motion(angle=lambda a: a * 180 / pi), "taking the angle as deg (deg taken for rad)"),
    "rad for deg": ("fast", "rod", motion(angle=lambda a: a * pi / 180), "taking the angle as rad (rad taken for deg)"),
    "angle clockwise": ("fast", "rod", motion(angle=lambda a: -a), "reversing the angle (it was counted clockwise)"),
    "angle from y": ("fast", "rod", motion(angle=lambda a: a - pi / 2), "turning the angle by 90 deg (it was counted from another axis)"),
    "acceleration reversed": ("fast", "rod", motion(acceleration=lambda a: -a), "reversing the acceleration"),
    "acceleration swapped": ("fast", "rod", motion(acceleration=lambda a: a[:, ::-1]), "swapping x and y of the acceleration"),
    "acceleration frame": ("in body axes", "rod", motion(acceleration_in_body_frame=in_the_body), "taking the acceleration as given in the body's frame"),
    "mm/s2 for m/s2": ("fast", "rod", motion(acceleration=lambda a: a * 1e3), "dividing the acceleration by 1000 (mm/s2 taken for m/s2)"),
    "acceleration in g": ("fast", "rod", motion(acceleration=lambda a: a / 9.80665), "multiplying the acceleration by 9.807 (g taken for m/s2)"),
    "accelerometer": ("slow", "rod", motion(acceleration=lambda a: a - GRAVITY), "leaving the weight out (the acceleration has gravity in it already, or the forces are of a machine without weight)"),
    "accelerometer upside down": ("slow", "rod", motion(acceleration=lambda a: a + GRAVITY), "taking gravity out of the acceleration (it has gravity in it, with the wrong sign)"),
    "acceleration of a pin": ("fast", "rod", acceleration_of("A"), "taking the acceleration as that of A, not of the centre of mass"),
    "angular acceleration reversed": ("fast", "rod", motion(angular_acceleration=lambda a: -a), "reversing the angular acceleration"),
    "deg/s2 for rad/s2": ("fast", "rod", motion(angular_acceleration=lambda a: a * 180 / pi), "dividing the angular acceleration by 57.3 (deg/s2 taken for rad/s2)"),
    "mass in g": ("fast", "rod", masses(1e3), "a mass of 0.8 kg instead of 800 kg (g taken for kg)"),
    "inertia in kg mm2": ("fast", "rod", masses(1, 1e6), "an inertia of 0.006 kg m2 instead of 6000 kg m2 (kg mm2 taken for kg m2)"),
}  # fmt: skip
DOUBLE = {
    "swapped and reversed": (
        "fast", "rod", at("B", scaled(-1, 1), swapped),
        {"reversing Fy at B", "swapping x and y of the force at B"},
    ),
    "frame and sign": (
        "fast", "rod", at("B", scaled(1, -1), other_frame),
        {"reversing Fy at B", "taking the force at B as given in the ground's frame"},
    ),
    "unit and sign": (
        "fast", "rod", at("A", scaled(-1e-3, 1e-3)),
        {"reversing Fx at A", "multiplying the force at A by 1000 (kN taken for N)"},
    ),
    "units of force and moment": (
        "fast", "crank", at("O", scaled(1e-3, 1e-3, 1e3)),
        {"multiplying the force at O by 1000 (kN taken for N)",
         "dividing the moment at O by 1000 (N mm taken for N m)"},
    ),
    "two points": (
        "fast", "rod", both(at("A", scaled(-1, 1)), at("B", swapped)),
        {"reversing Fx at A", "swapping x and y of the force at B"},
    ),
    "angle and sign": (
        "fast", "rod", both(motion(angle=lambda a: a * 180 / pi), at("B", scaled(-1, 1))),
        {"taking the angle as deg (deg taken for rad)", "reversing Fx at B"},
    ),
    "accelerometer on the rod": (
        "slow", "rod",
        lambda run, body: with_body(run, body, acceleration=rotated(
            run.bodies[body].acceleration - GRAVITY, -run.bodies[body].angle)),
        {"taking the acceleration as given in the body's frame",
         "leaving the weight out (the acceleration has gravity in it already, or the forces are "
         "of a machine without weight)"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("noise", [0.0, 0.005])
@pytest.mark.parametrize(("run", "body", "slip", "mended"), SINGLE.values(), ids=SINGLE)
def test_a_slip_is_the_first_suggestion_also_in_noisy_data(runs, run, body, slip, mended, noise):
    clean = noisy(runs[run], body, noise) if noise else runs[run]
    diagnosis = diagnose(slip(clean, body), body, TOLERANCE)
    assert diagnosis.suggestions[0].words == mended
    assert diagnosis.suggestions[0].left < (TOLERANCE if noise else 1e-5)  # lbf to 8 digits
    assert len(diagnosis.suggestions) <= 3
    assert f"{mended} closes it (left: " in str(diagnosis)


@pytest.mark.parametrize(("run", "body", "slip", "mended"), DOUBLE.values(), ids=DOUBLE)
def test_two_slips_at_once_are_found(runs, run, body, slip, mended):
    diagnosis = diagnose(slip(runs[run], body), body, TOLERANCE)
    assert set(diagnosis.suggestions[0].words.split(" and ", 1)) == mended or all(
        words in diagnosis.suggestions[0].words for words in mended
    )


def test_slips_that_no_balance_can_tell_apart_are_both_told(runs):
    """Turned half round and pulled at its ends, a rod lacks only the sign of its acceleration."""
    diagnosis = diagnose(motion(angle=lambda a: a + pi)(runs["fast"], "rod"), "rod", TOLERANCE)
    assert {entry.words for entry in diagnosis.suggestions} == {
        "reversing the angular acceleration",
        "turning the angle by 180 deg (it was counted from another axis)",
    }
    assert "; so does turning the angle by 180 deg" in str(diagnosis)


def without(point):
    def slip(run, body):
        kept = tuple(load for load in run.bodies[body].loads if load.point != point)
        return with_body(run, body, loads=kept)

    return slip


NONE = {
    "a force is missing": (without("A"), "rod", r"acts through A \(is a force missing"),
    "another is missing": (without("B"), "rod", r"acts through B \(is a force missing"),
    "the drive's side is missing": (without("O"), "crank", "no single error of sign"),
    "a constant force more": (at("A", lambda load: replace(load, force=load.force + np.array([0.0, 200.0]))), "rod", r"points along \(-?0\.00, 1\.00\) in the ground's axes, acts through A "),
    "a wrong calibration": (at("B", scaled(1.3, 1.3)), "rod", "vanishes with 0.769 times the force at B"),
    "no acceleration": (motion(acceleration=lambda a: 0 * a), "rod", "no single error of sign"),
    "a delay": (at("B", lambda load: replace(load, force=np.roll(load.force, 10, axis=0))), "rod", "acts through B "),
    "noise": (lambda run, body: noisy(run, body, 0.2), "rod", "jumps from row to row like noise"),
}  # fmt: skip


@pytest.mark.parametrize(("slip", "body", "told"), NONE.values(), ids=NONE)
def test_nothing_is_suggested_where_no_slip_closes_it(runs, slip, body, told):
    diagnosis = diagnose(slip(runs["fast"], body), body, TOLERANCE)
    assert diagnosis.suggestions == ()
    assert " closes it (left" not in str(diagnosis)
    with pytest.raises(AssertionError, match=told):
        raise AssertionError(str(diagnosis))


def more_moment(size):
    return at("A", lambda load: replace(load, moment=load.moment + size))


def faster(factor):
    return motion(
        acceleration=lambda a: a * factor**2, angular_acceleration=lambda a: a * factor**2
    )


NO_SLIPS = {
    "a constant moment": ("fast", "rod", more_moment(3000.0), TOLERANCE, "no single error"),
    "a large constant moment": ("slow", "rod", more_moment(3000.0), 3 * TOLERANCE, "no single error"),
    "a moment on the crank": ("slow", "crank", more_moment(500.0), TOLERANCE, "no single error"),
    "a lower speed": ("fast", "crank", faster(0.8), TOLERANCE, "times the mass"),
    "a higher speed": ("slow", "crank", faster(1.2), TOLERANCE, "no single error"),
    "half the mass": ("fast", "crank", masses(0.5), TOLERANCE, "vanishes with 2 times the mass"),
    "half the mass, slow": ("slow", "crank", masses(0.5), TOLERANCE, "vanishes with 2 times the mass"),
    "half the rod's mass": ("fast", "rod", masses(0.5), 3 * TOLERANCE, "vanishes with 2 times the mass"),
    "twice the inertia": ("fast", "rod", masses(1.0, 2.0), TOLERANCE, "vanishes with 0.5 times the inertia"),
    "four times the inertia": ("slow", "rod", masses(1.0, 4.0), 3 * TOLERANCE, "vanishes with 0.25 times the inertia"),
    "a gauge turned": ("slow", "rod", at("A", lambda load: replace(load, force=rotated(load.force, np.full(len(load.force), 0.035)))), TOLERANCE, "acts through A"),
}  # fmt: skip


@pytest.mark.parametrize(("run", "body", "fault", "limit", "told"), NO_SLIPS.values(), ids=NO_SLIPS)
def test_a_fault_that_is_no_slip_is_not_explained_by_one(runs, run, body, fault, limit, told):
    """Slips that only take away what is wrong, or that leave a good part of it, explain nothing."""
    diagnosis = diagnose(fault(runs[run], body), body, limit)
    assert diagnosis.suggestions == ()
    assert told in str(diagnosis)


@pytest.mark.parametrize("seed", range(2))
def test_strong_noise_is_never_explained_by_a_slip(runs, seed):
    for run in runs.values():
        assert diagnose(noisy(run, "rod", 0.2, seed), "rod", TOLERANCE).suggestions == ()


def test_the_sentence_says_where_how_much_and_what_closes_it(runs):
    diagnosis = diagnose(at("B", scaled(1, -1))(runs["fast"], "rod"), "rod", TOLERANCE)
    left = 2 * np.abs(runs["fast"].bodies["rod"].loads[1].force[:, 1])
    assert str(diagnosis).startswith(f"pin B of rod: unbalanced by {left.max():.4g} N (")
    assert "% of the largest force) at crank angle " in str(diagnosis)
    assert str(diagnosis).endswith(" deg; reversing Fy at B closes it (left: round-off)")


@pytest.mark.parametrize("run", ["fast", "in body axes", "slow"])
@pytest.mark.parametrize("body", ["crank", "rod"])
def test_a_clean_export_balances_to_round_off(runs, run, body):
    """A few sums of a few forces each."""
    assert runs[run].equilibrium_residual[body] < 1e-13
    assert diagnose(runs[run], body, TOLERANCE) is None


@pytest.mark.parametrize("seed", range(5))
def test_readings_off_by_half_a_percent_pass_one_percent(runs, seed):
    """Two forces, each off by at most 0.5 % of itself."""
    assert diagnose(noisy(runs["fast"], "rod", 0.005, seed), "rod", TOLERANCE) is None


@pytest.mark.parametrize("run", ["fast", "in body axes"])
def test_a_part_gets_the_loads_of_the_solved_cycle(fast, runs, run):
    """Round-off of turning to and fro."""
    interfaces = {"start": "A", "end": "B"}
    own, other = fast.part_history("rod", interfaces), runs[run].part_history("rod", interfaces)
    assert other.interfaces == own.interfaces
    largest = np.abs(own.wrenches).max()
    assert_allclose(other.wrenches, own.wrenches, rtol=0, atol=1e-12 * largest)
    for k in range(4):
        scale = np.abs(own.accelerations[:, k]).max()
        assert_allclose(other.accelerations[:, k], own.accelerations[:, k], atol=1e-11 * scale)


def test_what_noise_leaves_is_taken_up_by_inertia(runs):
    run = noisy(runs["fast"], "rod", 0.005)
    body = run.bodies["rod"].body
    history = run.part_history("rod", {"start": "A", "end": "B"})
    left = history.equilibrium_residual(body.mass, body.centre, body.inertia)
    assert run.equilibrium_residual["rod"] > 1e-3
    assert np.abs(left).max() < 1e-12 * np.abs(history.wrenches).max() * 220.0


def test_a_pin_gets_the_loads_of_the_solved_cycle_and_the_unmeasured_lug_what_follows(fast, runs):
    seats = {"crank": "crank", "rod": "rod"}
    own = fast.pin_history("A", seats, "rod")
    for bodies in (("crank", "rod"), ("rod",)):
        measured = MeasuredLoads(
            "run",
            runs["fast"].positions,
            None,
            {name: runs["fast"].bodies[name] for name in bodies},
        )
        other = measured.pin_history("A", seats, "rod")
        largest = np.abs(own.wrenches).max()
        assert_allclose(other.wrenches, own.wrenches, rtol=0, atol=1e-12 * largest)
        assert not other.times.any()
        left = measured.pin_residual("A", seats)
        assert (left is None) == (len(bodies) == 1)


def test_what_the_measured_seats_of_a_pin_leave_is_shared_by_them_evenly(runs):
    """Crank and rod give the pin minus their loads; their sum, halved, is taken off each."""
    run = with_load(runs["fast"], "crank", "A", scaled(1.04, 0.97))
    crank, rod = (
        next(load for load in run.bodies[name].loads if load.point == "A").force
        for name in ("crank", "rod")
    )
    history = run.pin_history("A", {"crank": "crank", "rod": "rod"}, "ground")
    assert np.abs(crank + rod).max() > 1.0
    assert_allclose(history.wrenches[:, 0, :2], (rod - crank) / 2, atol=1e-9)
    assert_allclose(history.wrenches[:, 1, :2], (crank - rod) / 2, atol=1e-9)
    assert_allclose(run.pin_residual("A", {"crank": "crank", "rod": "rod"})[:, :2], -crank - rod)


def test_an_angular_velocity_that_is_not_the_rate_of_the_angle_is_noticed(runs):
    """rpm taken for rad/s; the crank turns evenly, the rod's difference quotient is coarser."""
    run = runs["fast"]
    assert run.spin_mismatch("crank") < 1e-9
    assert run.spin_mismatch("rod") < 0.01
    wrong = with_body(run, "rod", angular_velocity=run.bodies["rod"].angular_velocity * 30 / pi)
    assert diagnose(wrong, "rod", TOLERANCE) is None
    assert wrong.spin_mismatch("rod") == pytest.approx(1 - pi / 30, abs=0.01)
    assert replace(run, times=None).spin_mismatch("rod") is None


def test_what_a_part_needs_and_the_run_does_not_have_is_refused(runs):
    run = runs["fast"]
    with pytest.raises(LinkageError, match="has nothing of body 'slider'; known are crank, rod"):
        run.part_history("slider", {"start": "B"})
    with pytest.raises(LinkageError, match="has a load at point 'B', which is no interface"):
        run.part_history("rod", {"start": "A"})
    with pytest.raises(LinkageError, match="no load at B on slider, frame; at most one seat"):
        run.pin_history("B", {"a": "rod", "b": "slider", "c": "frame"}, "rod")
    with pytest.raises(LinkageError, match="turns with 'slider', of which run 'turn' has no angle"):
        run.pin_history("B", {"a": "rod", "b": "slider"}, "slider")
    with pytest.raises(LinkageError, match="needs at least 2 positions, got 1"):
        MeasuredLoads("run", np.zeros(1), None, run.bodies)
