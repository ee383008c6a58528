"""Starts and stops by a motor and a brake: closed forms, and integration in time by hand."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from loads import (
    Event,
    Friction,
    Geared,
    LinkageError,
    Motor,
    MotorPace,
    Phase,
    StallError,
    run_cycle,
    solve_event,
)

from .machines import slider_crank
from .test_motors import (
    CRANK,
    FLYWHEEL,
    FREE,
    GEARED,
    INERTIA,
    MASS,
    RATED,
    ROD,
    driven,
    kloss,
    machine,
    slider,
)
from .test_motors import cycle as turn

STARTING = replace(GEARED, motor=replace(GEARED.motor, starting=2.2))
WHOLE = INERTIA + FLYWHEEL + 2.0  # crank, flywheel, rotor by the ratio squared


def torque(v):
    """Of the motor that has 2.2 of its rated torque at standstill, on the crank."""
    slip, rated = 1 - 10 * v / FREE, 1 - RATED / FREE
    most = rated * (2.8 + np.sqrt(2.8**2 - 1))
    if slip <= most:
        return kloss(v)
    return 9.0 * 2e4 * (2.8 + (2.2 - 2.8) * (slip - most) / (1 - most))


def rotor():
    """A crank alone that weighs: rod and slider have no mass, and nothing pushes."""
    return slider_crank(CRANK, ROD, crank_body={"inertia": INERTIA})


def unrolled(loads):
    """Angle of the crank over all turns; the names of the phases have their number."""
    numbers = [int(name.split()[1]) for name in loads.phases]
    return loads.positions + 2 * pi * (np.array(numbers)[loads.phase_of] - 1)


def even(most=2e3):
    """A controller that gives an even torque nearly up to the speed without load."""
    return MotorPace(
        driven().steady, Geared(Motor(0.2 * most, RATED, FREE, most=0.1 * most), 10.0), FLYWHEEL
    )


def test_a_rotor_starts_by_its_torque_over_its_inertia():
    """v = T t / J, turns = J v^2 / (4 pi T), from rest to 0.99 of the speed without load.

    The straight line of the motor is cut up to 0.946 of that speed; a turn there is stated.
    """
    run = solve_event("start", rotor(), turn(even(), push=0.0), Event("start", "turn", turns=1.25))
    loads = run_cycle(rotor(), run.cycle)
    accelerated = 2e3 / (INERTIA + FLYWHEEL)
    speed, way = loads.velocities[:, 1, 2], unrolled(loads)
    assert_allclose(speed, np.sqrt(2 * accelerated * way), rtol=1e-8, atol=1e-8)
    assert_allclose(loads.times, np.sqrt(2 * way / accelerated), rtol=1e-8, atol=1e-8)
    assert_allclose(loads.accelerations[:, 1, 2], accelerated, rtol=1e-6)
    assert_allclose([run.turns, run.time], [1.25, np.sqrt(2.5 * pi * 2 / accelerated)], rtol=1e-9)
    # the crank itself takes its share of the torque
    assert_allclose(loads.efforts["drive"], 2e3 * INERTIA / (INERTIA + FLYWHEEL), rtol=1e-6)


@pytest.mark.parametrize("delay", [0.0, 0.05])
def test_a_brake_stops_a_rotor_in_the_turns_of_its_energy(delay):
    """J v^2 / (2 M) of angle and J v / M of time; before them the way of the delay, motor off."""
    event = Event("brake", "turn", at=0.5, torque=3e4, delay=delay)
    cycle = turn(driven(), push=0.0)
    run = solve_event("stop", rotor(), cycle, event)
    assert_allclose(
        run.turns, (FREE / 10 * delay + WHOLE * (FREE / 10) ** 2 / 6e4) / (2 * pi), rtol=1e-8
    )
    assert_allclose(run.time, delay + WHOLE * FREE / 10 / 3e4, rtol=1e-8)
    loads = run_cycle(rotor(), run.cycle)
    assert_allclose(loads.positions[0], 0.5)
    assert abs(loads.velocities[-1, 1, 2]) < 1e-4
    braked = np.array([name.endswith("braked") for name in loads.phases])[loads.phase_of]
    assert (~braked).any() == (delay > 0.0)
    assert_allclose(loads.accelerations[braked, 1, 2], -3e4 / WHOLE, rtol=1e-6)
    assert_allclose(loads.efforts["drive"][braked], -3e4 * INERTIA / WHOLE, rtol=1e-6)


def by_hand(kind, state, delay=0.0, brake=0.0, turning=WHOLE, tends=10.0):
    """The crank with its slider over the time, phase by phase, until it stands or `tends`."""

    def slope(t, y):
        q, v = y
        first, second = slider(q)
        out = q % (2 * pi) >= pi
        force = -800.0 * first if out else 0.0
        given = torque(v) if kind == "start" else -brake if t >= delay else 0.0
        whole = turning + MASS * first**2
        return [v, (given + force - MASS * first * second * v**2) / whole]

    t, parts = 0.0, []
    while True:
        border = pi * (np.floor(state[0] / pi + 1e-9) + 1)
        ends = [lambda _, y, at=border: y[0] - at, lambda _, y: y[1]]
        for end, direction in zip(ends, (1.0, -1.0), strict=True):
            end.terminal, end.direction = True, direction
        until = delay if t < delay and kind != "start" else tends
        # a hair inside: the phase is that of the piece
        state = [max(state[0], border - pi + 1e-13), state[1]]
        run = solve_ivp(
            slope, (t, until), state, "DOP853", events=ends, rtol=1e-12, atol=1e-13,
            dense_output=True,
        )  # fmt: skip
        parts.append(run)
        t, state = run.t[-1], run.y[:, -1].tolist()
        if len(run.t_events[1]) or t >= tends:
            return t, state, parts


@pytest.mark.parametrize(("heavier", "turns"), [(1.0, 2.3), (40.0, 26.3)])
def test_a_start_against_the_load_is_that_of_an_integration_by_hand(heavier, turns):
    """Speed over the angle to 1e-6; the slider is pushed back by 800 N from 180 deg on."""
    event = Event("start", "turn", at=1.0, turns=turns)
    drive = replace(driven(STARTING), inertia=heavier * FLYWHEEL)
    run = solve_event("start", machine(), turn(drive), event)
    loads = run_cycle(machine(), run.cycle)
    way = unrolled(loads)
    whole = WHOLE + (heavier - 1.0) * FLYWHEEL
    _, _, parts = by_hand("start", [1.0, 0.0], turning=whole, tends=run.time)
    worst = 0.0
    for q, v, t in zip(way, loads.velocities[:, 1, 2], loads.times, strict=True):
        part = next(one for one in parts if one.t[-1] >= t - 1e-9)
        there = part.sol(min(t, part.t[-1]))
        worst = max(worst, abs(there[0] - q), abs(there[1] - v) / 14.0)
    assert worst < 1e-6
    assert_allclose(way[-1] - way[0], turns * 2 * pi, rtol=1e-9)


def test_a_start_ends_within_a_hundredth_of_the_steady_speed():
    cycle = turn(driven(STARTING))
    run = solve_event("start", machine(), cycle, Event("start", "turn", at=0.0))
    loads, steady = run_cycle(machine(), run.cycle), run_cycle(machine(), cycle)
    speed = np.interp(loads.positions, steady.positions, steady.velocities[:, 1, 2])
    share = loads.velocities[:, 1, 2] / speed
    assert_allclose(share[-1], 0.99, rtol=1e-4)
    assert (share[:-1] < 0.99).all()
    assert run.cycle.phases[0].name == "back 1"


@pytest.mark.parametrize("heavier", [1.0, 600.0])
def test_an_emergency_stop_is_that_of_an_integration_by_hand(heavier):
    """Brake torque of 60 N m after 30 ms in which the motor is off: time and angle to 1e-6."""
    cycle = turn(replace(driven(), inertia=heavier * FLYWHEEL), n=720)
    event = Event("brake", "turn", at=2.0, torque=6e4, delay=0.03)
    run = solve_event("stop", machine(), cycle, event)
    steady = run_cycle(machine(), cycle)
    from scipy.interpolate import CubicSpline

    rows = steady.phase_of == 0
    at = CubicSpline(steady.positions[rows], steady.velocities[rows, 1, 2])(2.0)
    whole = WHOLE + (heavier - 1.0) * FLYWHEEL
    time, (angle, _), _ = by_hand("brake", [2.0, float(at)], 0.03, 6e4, whole, 60.0)
    assert run.turns > (0.1 if heavier == 1.0 else 20.0)
    assert_allclose(run.time, time, rtol=1e-6)
    assert_allclose(run.turns * 2 * pi, angle - 2.0, rtol=1e-6)


@pytest.mark.parametrize("event", [
    Event("start", "turn", at=1.0, turns=2.0),
    Event("coast", "turn", at=1.0),
    Event("brake", "turn", at=1.0, torque=4e4, delay=0.02),
])  # fmt: skip
def test_no_energy_is_lost_or_found(event):
    """Work of motor, brake and push against the kinetic energy, to 1e-8 of what is turned over.

    By the knots of the run, and Gauss' rule between them: the push gives by hand what it gives.
    """
    run = solve_event("event", machine(), turn(driven(STARTING)), event)
    nodes, weights = np.polynomial.legendre.leggauss(5)
    work, turned = 0.0, 0.0

    def energy(way, speed):
        return 0.5 * (WHOLE + MASS * slider(way)[0] ** 2) * speed**2

    for k, (phase, knots) in enumerate(zip(run.cycle.phases, run.cycle.pace.knots, strict=True)):
        given = {"start": torque, "coast": lambda v: 0.0, "brake": lambda v: 0.0}[event.kind]
        if phase.name.endswith("braked"):

            def given(v):
                return -4e4

        low, high = knots[:-1, 0], knots[1:, 0]
        times = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * nodes
        over = run.cycle.pace._over(k)
        way, speed = 1.0 + over(times), over(times, 1)
        push = -800.0 * slider(way)[0] if phase.name.startswith("out") else 0.0 * way
        power = np.vectorize(given)(speed) * speed + push * speed
        parts = (0.5 * (high - low)[:, None] * weights * power).sum(axis=1)
        work, turned = work + parts.sum(), turned + np.abs(parts).sum()
    first, last = run.cycle.pace.knots[0][0], run.cycle.pace.knots[-1][-1]
    gained = energy(1.0 + last[1], last[2]) - energy(1.0, first[2])
    assert abs(work - gained) < 1e-8 * turned


def test_friction_and_acceleration_are_solved_together():
    """A guide's friction of 0.2: the torque that is left turns flywheel and rotor, everywhere."""
    rubbing = machine(mu_slider=0.2)
    event = Event("brake", "turn", at=0.3, torque=4e4)
    run = solve_event("stop", rubbing, turn(driven()), event)
    loads = run_cycle(rubbing, run.cycle)
    left = -4e4 - (FLYWHEEL + 2.0) * loads.accelerations[:, 1, 2]
    assert_allclose(left, loads.efforts["drive"], atol=1e-2 * 4e4)
    assert np.median(np.abs(left - loads.efforts["drive"])) < 1e-5 * 4e4
    smooth = solve_event("stop", machine(), turn(driven()), event)
    assert run.time < smooth.time


def test_the_place_with_the_largest_joint_force_is_taken_where_none_is_stated():
    cycle = turn(driven())
    event = Event("brake", "turn", torque=2e5)
    run = solve_event("stop", machine(), cycle, event)
    assert len(run.tried) == 12
    for place, force in run.tried[::4]:
        own = solve_event("stop", machine(), cycle, replace(event, at=place))
        assert_allclose(own.force, force, rtol=1e-2)  # tried by rough runs
        assert own.force <= run.force * (1.0 + 1e-3)
        forces = run_cycle(machine(), own.cycle).reactions.values()
        largest = max(float(np.hypot(*one.force.T).max()) for one in forces)
        assert_allclose(largest, force, rtol=2e-2)
    assert dict(run.tried)[run.at] == run.force == max(force for _, force in run.tried)
    steady = run_cycle(machine(), cycle).reactions.values()
    assert_allclose(run.steady[0], max(np.hypot(*one.force.T).max() for one in steady), rtol=1e-2)


def test_a_machine_that_turns_backwards_stops_alike():
    """The mirrored crank angle: phases from 360 deg down, the load where it was."""
    cycle = turn(driven())
    event = Event("brake", "turn", at=2.0, torque=6e4, delay=0.03)
    phases = (
        Phase("out", pi, {"push": 0.0}, "drive"),
        Phase("back", 0.0, {"push": -800.0}, "drive"),
    )
    mirrored = replace(cycle, start=2 * pi, phases=phases)
    there = solve_event("stop", machine(), cycle, event)
    back = solve_event("stop", machine(), mirrored, replace(event, at=2 * pi - 2.0))
    assert_allclose(back.turns, there.turns, rtol=1e-8)
    assert_allclose(run_cycle(machine(), back.cycle).velocities[0, 1, 2], -run_cycle(
        machine(), there.cycle).velocities[0, 1, 2], rtol=1e-8)  # fmt: skip


def test_a_start_that_the_load_holds_stalls_with_the_torque_that_is_missing():
    weak = Geared(Motor(1e3, RATED, FREE, breakdown=2.8, starting=1.5), 10.0, 0.9, 0.02)
    heavy = turn(MotorPace(driven().steady, weak, 20.0 * FLYWHEEL), push=-400.0)
    with pytest.raises(StallError, match=r"rest at crank.angle = 270 deg stalls at .* are missing"):
        solve_event("start", machine(), heavy, Event("start", "turn", at=1.5 * pi))
    with pytest.raises(StallError, match=r"stalls at crank\.angle"):
        solve_event("start", machine(), heavy, Event("start", "turn"))


def test_a_stop_that_does_not_end_is_refused():
    with pytest.raises(LinkageError, match="after 100 turns: a brake brings it to rest"):
        solve_event("coast", rotor(), turn(driven(), push=0.0), Event("coast", "turn", at=0.0))
    event = Event("brake", "turn", at=0.0, torque=1e4, motor_on=True)
    with pytest.raises(LinkageError, match="after 100 turns: a stronger brake"):
        solve_event("stop", rotor(), turn(driven(STARTING), push=0.0), event)


@pytest.mark.parametrize(("stated", "said"), [
    ({"kind": "halt"}, "is one of start, coast, brake"),
    ({"kind": "brake"}, "torque of a brake must be above 0"),
    ({"kind": "brake", "torque": 1.0, "delay": -1.0}, "delay of a brake is not negative"),
])  # fmt: skip
def test_an_event_that_cannot_be_is_refused(stated, said):
    with pytest.raises(LinkageError, match=said):
        Event(cycle="turn", **stated)


def test_friction_of_pins_costs_a_start_time():
    """Over the same quarter of a turn; the steady speed that it would near is lower, too."""
    rubbing = replace(machine(), friction={"A": Friction(0.1, 20.0), "B": Friction(0.1, 15.0)})
    event = Event("start", "turn", at=3.5, turns=0.25)
    run = solve_event("start", rubbing, turn(driven(STARTING)), event)
    assert run.time > solve_event("start", machine(), turn(driven(STARTING)), event).time
