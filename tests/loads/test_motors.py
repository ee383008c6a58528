"""Motors that turn linkages: speeds against integration in time, by hand, and where they stall."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import cumulative_trapezoid, quad, solve_ivp

from loads import (
    Angle,
    Cycle,
    Force,
    Friction,
    Geared,
    LinkageError,
    Motor,
    MotorPace,
    Phase,
    PointCoordinate,
    RunawayError,
    StallError,
    SteadyPace,
    StrokePace,
    UnsettledError,
    moves_alike,
    run_cycle,
    try_cycle,
)
from loads.running import running
from loads.turning import with_points

from .machines import slider_crank

CRANK, ROD, MASS, INERTIA = 100.0, 400.0, 5e-3, 20.0
ANGLE = Angle("crank", point="O")
FREE, RATED = 157.08, 140.0
KLOSS = Motor(2e4, RATED, FREE, breakdown=2.8)
GEARED = Geared(KLOSS, ratio=10.0, efficiency=0.9, inertia=0.02)
FLYWHEEL = 200.0


def machine(**more):
    return slider_crank(CRANK, ROD, crank_body={"inertia": INERTIA}, slider_mass=MASS, **more)


def cycle(pace, push=-800.0, n=361):
    """The slider pushed back on its way out, from 180 to 360 deg of the crank."""
    phases = (
        Phase("back", pi, {"push": 0.0}, "drive"),
        Phase("out", 2 * pi, {"push": push}, "drive"),
    )
    return Cycle("turn", ANGLE, 0.0, pace, phases, n)


def driven(motor=GEARED, flywheel=FLYWHEEL, speed=14.0):
    return MotorPace(SteadyPace(ANGLE, speed), motor, flywheel)


def slider(q):
    """First and second derivative of the slider's place by the crank's angle."""
    reach = np.sqrt(ROD**2 - (CRANK * np.sin(q)) ** 2)
    first = -CRANK * np.sin(q) - CRANK**2 * np.sin(q) * np.cos(q) / reach
    second = -CRANK * np.cos(q) - (
        CRANK**2 * np.cos(2 * q) / reach + (CRANK**2 * np.sin(q) * np.cos(q)) ** 2 / reach**3
    )
    return first, second


def kloss(speed):
    """Torque on the crank at its speed, by the formula as textbooks print it."""
    slip, rated = 1 - 10 * speed / FREE, 1 - RATED / FREE
    most = rated * (2.8 + np.sqrt(2.8**2 - 1))
    torque = 10 * 2 * 2.8 * 2e4 / (slip / most + most / slip)
    return torque * (0.9 if torque > 0 else 1 / 0.9)


def test_an_asynchronous_motor_has_its_rated_and_its_breakdown_torque():
    assert_allclose(KLOSS.torque(RATED)[0], 2e4, rtol=1e-12)
    assert KLOSS.torque(FREE)[0] == 0.0
    speeds = np.linspace(0.0, FREE, 100_001)
    torques = np.array([KLOSS.torque(speed)[0] for speed in speeds])
    assert_allclose(torques.max(), 2.8 * 2e4, rtol=1e-8)
    assert KLOSS.largest_torque == 2.8 * 2e4
    assert KLOSS.torque(1.1 * FREE)[0] < 0.0  # driven faster it brakes


def test_a_motor_without_breakdown_torque_has_a_line_that_is_cut():
    line = Motor(2e4, RATED, FREE, most=3e4)
    assert_allclose(line.torque(RATED)[0], 2e4)
    assert_allclose(line.torque((RATED + FREE) / 2)[0], 1e4)
    assert line.torque(0.0) == (3e4, 0.0)
    assert line.torque(10 * FREE) == (-3e4, 0.0)
    assert_allclose(Motor(2e4, RATED, FREE).largest_torque, 2e4 * FREE / (FREE - RATED))


@pytest.mark.parametrize("motor", [KLOSS, Motor(2e4, RATED, FREE, most=5e4), GEARED])
def test_the_slope_is_the_change_of_the_torque(motor):
    for speed in (1.0, 9.0, 15.0):
        change = motor.torque(speed + 1e-4)[0] - motor.torque(speed - 1e-4)[0]
        assert_allclose(motor.torque(speed)[1], change / 2e-4, rtol=1e-6, atol=1e-3)


def test_a_gear_multiplies_torque_and_loses_either_way():
    assert_allclose(GEARED.torque(14.0)[0], kloss(14.0), rtol=1e-12)
    forward, back = Geared(KLOSS, 10.0), GEARED
    assert_allclose(back.torque(16.0)[0], forward.torque(16.0)[0] / 0.9)
    assert GEARED.reflected == 2.0


@pytest.mark.slow
def test_the_steady_state_is_that_of_a_long_integration_in_time():
    """60 turns, some 30 time constants, step by step with the equation of motion by hand."""
    found = run_cycle(machine(), cycle(driven(), n=720))
    speed = found.velocities[:, 1, 2]

    def rate(out):
        def slope(_, state):
            q, v = state
            first, second = slider(q)
            force = -800.0 * first if out else 0.0
            whole = INERTIA + FLYWHEEL + 2.0 + MASS * first**2
            return [v, (kloss(v) + force - MASS * first * second * v**2) / whole]

        return slope

    state, took = [0.0, 14.0], 0.0
    for turn in range(60):
        took = 0.0
        for out in (False, True):
            stop = 2 * pi * turn + (2 * pi if out else pi)

            def there(_, state, stop=stop):
                return state[0] - stop

            there.terminal = True
            run = solve_ivp(
                rate(out), (0, 10), state, "DOP853", events=there, rtol=1e-11, atol=1e-12
            )
            state, took = [stop, run.y[1, -1]], took + run.t[-1]
    assert_allclose(speed[[0, -1]], state[1], rtol=1e-9)
    assert_allclose(found.times[-1], took, rtol=1e-8)
    assert np.ptp(speed) > 0.5


def test_motor_flywheel_and_linkage_balance_at_every_position():
    """T - J dv/dt is the torque that the linkage takes, with its inertia; energy over a turn."""
    found = run_cycle(machine(), cycle(driven(), n=720))
    speed, change = found.velocities[:, 1, 2], found.accelerations[:, 1, 2]
    given = np.array([kloss(v) for v in speed])
    left = given - (FLYWHEEL + 2.0) * change - found.efforts["drive"]
    assert np.abs(left).max() < 1e-7 * np.abs(given).max()
    assert_allclose(found.drive("drive").work, 800.0 * 2 * CRANK, rtol=1e-5)
    assert_allclose(np.trapezoid(given * speed, found.times), 800.0 * 2 * CRANK, rtol=1e-4)


def test_the_irregularity_under_even_torque_is_the_ripple_over_the_energy():
    """By hand: ripple / (J w^2), to 1 % at 0.02; a motor of 100 times the speed is even."""
    push, mean = 800.0, 800.0 * 2 * CRANK / (2 * pi)
    light = slider_crank(CRANK, ROD, crank_body={"inertia": INERTIA})
    angle = np.linspace(0.0, 2 * pi, 20_001)
    demand = np.where(angle > pi, push * slider(angle)[0], 0.0)
    stored = np.concatenate([[0.0], np.cumsum(mean - 0.5 * (demand[1:] + demand[:-1]))])
    ripple = np.ptp(stored * (angle[1] - angle[0]))
    inertia = ripple / (0.02 * 14.0**2)
    even = Geared(Motor(mean, 14.0, 1_400.0))
    found = run_cycle(light, cycle(driven(even, inertia - INERTIA), n=720))
    speed = found.velocities[:, 1, 2]
    average = 2 * pi / found.times[-1]
    assert_allclose(np.ptp(speed) / average, ripple / (inertia * average**2), rtol=1e-2)
    assert_allclose(average, 14.0, rtol=1e-2)


def test_wittenbauers_tangents_have_the_speeds_of_the_run():
    """Energy over reduced inertia, by hand: from the origin its tangents are w^2 / 2, exactly."""
    mean = 800.0 * 2 * CRANK / (2 * pi)
    even = Motor(mean, 14.0, 1_400.0)
    heavy = slider_crank(CRANK, ROD, crank_body={"inertia": INERTIA}, slider_mass=10 * MASS)
    found = run_cycle(heavy, cycle(driven(Geared(even), 600.0), n=720))
    angle, speed = found.positions, found.velocities[:, 1, 2]
    reduced = INERTIA + 600.0 + 10 * MASS * slider(angle)[0] ** 2
    place = CRANK * np.cos(angle) + np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)
    given = cumulative_trapezoid([even.torque(v)[0] for v in speed], angle, initial=0.0)
    taken = np.where(found.phase_of == 1, 800.0 * (place - (ROD - CRANK)), 0.0)
    energy = 0.5 * reduced[0] * speed[0] ** 2 + given - taken
    slopes = energy / reduced
    assert_allclose(slopes, 0.5 * speed**2, rtol=5e-7)
    assert np.ptp(reduced) > 0.5 * reduced.min()  # not that of a flywheel alone
    assert slopes.max() > 1.2 * slopes.min()


def test_energy_over_a_turn_is_kept_to_a_hundred_millionth():
    """What the motor gives between the positions, too, is what is taken."""
    ways = [with_points(np.linspace(0.0, 2 * pi, 301))]

    def taken(_, squares, accelerations):
        return 5e4 + 4e4 * np.sin(ways[0]) + 30.0 * squares + 40.0 * accelerations

    found = running(taken, ways, GEARED, FLYWHEEL, 14.0, place)

    def given(way):
        return kloss(float(found.rates(0, np.array([way]))[0][0]))

    def drag(way):
        square = float(found.rates(0, np.array([way]))[0][0]) ** 2
        return 5e4 + 4e4 * np.sin(way) + 30.0 * square

    turn = quad(given, 0, 2 * pi, epsrel=1e-12, limit=400)[0]
    assert_allclose(turn, quad(drag, 0, 2 * pi, epsrel=1e-12, limit=400)[0], rtol=1e-8)
    start, end = found.rates(0, np.array([0.0, 2 * pi]))[0]
    assert_allclose(start, end, rtol=1e-12)


@pytest.mark.parametrize("mu", [0.1, 0.3])
def test_friction_that_depends_on_the_acceleration_is_in_the_balance(mu):
    rubbing = machine(mu_slider=mu, gravity=(0.0, -9810.0))
    pins = {name: Friction(mu, 20.0) for name in ("O", "A", "B")}
    rubbing = replace(rubbing, friction={"guide": Friction(mu), **pins})
    found = run_cycle(rubbing, cycle(driven()))
    speed, change = found.velocities[:, 1, 2], found.accelerations[:, 1, 2]
    given = np.array([kloss(v) for v in speed])
    left = given - (FLYWHEEL + 2.0) * change - found.efforts["drive"]
    assert np.abs(left).max() < 1e-2 * np.abs(given).max()  # where a normal force turns its sign
    assert np.median(np.abs(left)) < 1e-5 * np.abs(given).max()
    even = run_cycle(machine(), cycle(driven()))
    assert speed.mean() < even.velocities[:, 1, 2].mean()


def place(k, i):
    return f"way {i} of phase {k}"


def test_a_torque_that_switches_with_the_acceleration_settles():
    """As a contact that opens: it takes nothing while the speed falls quickly."""
    ways = [with_points(np.linspace(0.0, 2 * pi, 201))]

    def taken(_, squares, accelerations):
        return 8e4 + 6e4 * np.sin(ways[0]) + 50.0 * np.maximum(accelerations, -2.0)

    found = running(taken, ways, GEARED, 100.0, 14.0, place)
    speed, change = found.rates(0, ways[0])
    given = np.array([kloss(v) for v in speed])
    left = given - 102.0 * change - taken(0, speed**2, change)
    assert np.abs(left).max() < 1e-6 * np.abs(given).max()


def test_a_motor_too_weak_stalls_where_it_stands_with_the_torque_that_is_missing():
    with pytest.raises(StallError, match=r"stalls at crank\.angle = \d\d\d.* N m are missing"):
        run_cycle(machine(), cycle(driven(), push=-6000.0))
    heavy = run_cycle(machine(), cycle(driven(flywheel=2e4), push=-6000.0))
    assert heavy.velocities[:, 1, 2].min() > 12.0


def test_a_run_without_any_mass_is_refused():
    light = slider_crank(CRANK, ROD)
    with pytest.raises(LinkageError, match="nothing that the motor turns has a mass at crank"):
        run_cycle(light, cycle(driven(replace(GEARED, inertia=0.0), 0.0)))


def test_a_demand_that_never_settles_is_no_result():
    ways, count = [with_points(np.linspace(0.0, 2 * pi, 41))], [0]

    def taken(_, squares, __):
        count[0] += 1
        return np.full(len(squares), 5e4 + 1e3 * (count[0] % 7))

    with pytest.raises(UnsettledError, match="do not settle on each other"):
        running(taken, ways, GEARED, FLYWHEEL, 14.0, place)


def one(stop=2 * pi, solve="drive", sweep=ANGLE, start=0.0):
    other = {"drive": "push", "push": "drive"}[solve]
    return Cycle("turn", sweep, start, driven(), (Phase("a", stop, {other: 0.0}, solve),))


@pytest.mark.parametrize(
    ("bad", "said"),
    [
        (one(stop=4.0), "end in the pose that it starts from"),
        (one(solve="push", start=0.5, stop=2.5), "end in the pose"),
        (one(sweep=PointCoordinate("slider", "B", (1.0, 0.0)), start=450.0, stop=400.0),
         "must lead the cycle"),
    ],
)  # fmt: skip
def test_cycles_that_no_motor_turns_are_refused(bad, said):
    with pytest.raises(LinkageError, match=said):
        run_cycle(machine(at=0.3), bad)


def test_a_motor_is_refused_what_it_cannot_be():
    with pytest.raises(LinkageError, match="without load lies above"):
        Motor(2e4, FREE, RATED)
    with pytest.raises(LinkageError, match="breakdown torque of a motor lies above"):
        Motor(2e4, RATED, FREE, breakdown=1.0)
    with pytest.raises(LinkageError, match="not both"):
        Motor(2e4, RATED, FREE, breakdown=2.0, most=3e4)
    with pytest.raises(LinkageError, match="efficiency of a gear"):
        Geared(KLOSS, efficiency=1.1)
    with pytest.raises(LinkageError, match="turns an angle"):
        MotorPace(SteadyPace(PointCoordinate("slider", "B", (1.0, 0.0)), 1.0), GEARED)
    assert isinstance(StrokePace(ANGLE, "harmonic", 1.0), StrokePace)


def test_a_cycle_is_tried_at_the_speed_that_it_begins_with():
    try_cycle(machine(), cycle(driven(), push=-6000.0))  # that it stalls only its masses tell


def test_loads_of_a_motor_are_solved_anew_for_every_variation():
    assert not moves_alike(machine(), cycle(driven()), machine(), cycle(driven()))


def even(torque, inertia):
    """A constant torque on the angle, to be turned by the motor with an inertia of its own."""
    ways = [with_points(np.linspace(0.0, 2 * pi, 201))]

    def taken(_, squares, accelerations):
        return torque + inertia * accelerations

    return running(taken, ways, GEARED, 0.0, 14.0, place)


@pytest.mark.parametrize("torque", [1e5, -2e5])
def test_an_even_load_is_turned_or_braked_at_the_speed_of_its_torque(torque):
    speed = even(torque, 300.0).rates(0, np.array([1.0]))[0][0]
    assert_allclose(kloss(speed), torque, rtol=1e-6)


def test_a_load_beyond_what_the_motor_brakes_runs_away():
    """Its breakdown torque, braking through the gear, is 622 N m."""
    with pytest.raises(RunawayError, match="2 times its speed without load"):
        even(-7e5, 300.0)


@pytest.mark.parametrize("inertia", [1e-3, 1.0, 30.0])
def test_a_strong_motor_on_hardly_any_inertia_has_the_speed_of_the_load_everywhere(inertia):
    """Its run settles within a step: T(v) is what is taken, whatever little inertia there is."""
    ways = [with_points(np.linspace(0.0, 2 * pi, 201))]
    load = 1e5 + 5e4 * np.sin(ways[0])
    light = Geared(KLOSS, ratio=10.0, efficiency=0.9)
    found = running(lambda _, __, change: load + inertia * change, ways, light, 0.0, 14.0, place)
    speed = found.rates(0, ways[0])[0]
    assert_allclose([kloss(v) for v in speed], load, rtol=1e-3 * max(1.0, inertia))


def drawn(random):
    """A motor, an inertia, and functions a, b and c of a torque a dv/dt + b v2 + c."""
    free = RATED * (1 + 10 ** random.uniform(-2.5, -0.7))
    breakdown = random.choice([None, 1.5, 2.8])
    most = 2e4 * random.uniform(1, 3) if breakdown is None and random.random() < 0.5 else None
    motor = Motor(2e4, RATED, free, breakdown=breakdown, most=most)
    geared = Geared(motor, 10.0, random.choice([1.0, 0.9, 0.6]))
    level, swing = 2e5 * random.uniform(-0.5, 1.5), 2e5 * random.uniform(0, 1.5)
    wave, phase = 20.0 * random.uniform(0, 0.8), random.uniform(0, 2 * pi)
    return (
        geared,
        10 ** random.uniform(0.5, 4),
        lambda s: 20.0 + wave * np.cos(2 * s),
        lambda s: -wave * np.sin(2 * s),
        lambda s: level + swing * np.sin(s + phase),
    )


def in_time(geared, whole, b, c):
    """Squared speed at the start of a turn that repeats, by LSODA from the speed without load."""
    free = geared.free_speed**2

    def slope(s, state):
        torque = geared.torque(np.sqrt(max(state[0], 1e-12)))[0]
        return [2 * (torque - b(s) * state[0] - c(s)) / whole(s)]

    def stands(_, state):
        return state[0] - 1e-6 * free

    stands.terminal = True
    start = free
    for _ in range(400):
        run = solve_ivp(
            slope, (0, 2 * pi), [start], "LSODA", rtol=1e-9, atol=1e-9, events=stands, max_step=0.1
        )
        if run.status == 1:
            return "stands"
        end = run.y[0, -1]
        if end > 16 * free:
            return "runs away"
        if abs(end - start) < 1e-9 * start:
            return end
        start = end
    raise AssertionError("it does not settle in 400 turns")


@pytest.mark.slow
def test_random_motors_run_stall_and_run_away_as_integration_in_time_says():
    random, ways = np.random.default_rng(7), [with_points(np.linspace(0.0, 2 * pi, 301))]
    outcomes = []
    for _ in range(40):
        geared, flywheel, a, b, c = drawn(random)

        def taken(_, squares, changes, a=a, b=b, c=c):
            return a(ways[0]) * changes + b(ways[0]) * squares + c(ways[0])

        expected = in_time(geared, lambda s, a=a, j=flywheel: j + a(s), b, c)
        try:
            found = running(taken, ways, geared, flywheel, 14.0, place).rates(0, ways[0])[0][0] ** 2
        except StallError:
            found = "stands"
        except RunawayError:
            found = "runs away"
        outcomes.append("runs" if isinstance(expected, float) else expected)
        if isinstance(expected, float) and isinstance(found, float):
            assert_allclose(found, expected, rtol=1e-5)
        else:
            assert found == expected
    assert {"runs", "stands"} <= set(outcomes)


def test_a_motor_that_holds_its_speed_to_rounding_has_no_acceleration_to_compute():
    """1 GW at a slip of 7e-8: rounding of the speed is more torque than the load's."""
    stiff = Geared(Motor(6.4e9, 1499.9999 * pi / 30, 1500 * pi / 30, breakdown=50.0), 5.0)
    with pytest.raises(UnsettledError, match=r'drive\.control = "constant"'):
        run_cycle(machine(), cycle(driven(stiff, speed=31.4)))


def test_phases_that_solve_for_different_torques_have_no_one_motor():
    twice = machine()
    twice = replace(twice, forces=(*twice.forces, Force("second", ANGLE)))
    phases = (
        Phase("a", pi, {"push": 0.0, "second": 0.0}, "drive"),
        Phase("b", 2 * pi, {"push": 0.0, "drive": 0.0}, "second"),
    )
    with pytest.raises(LinkageError, match="must solve for the same"):
        run_cycle(twice, Cycle("turn", ANGLE, 0.0, driven(), phases))
