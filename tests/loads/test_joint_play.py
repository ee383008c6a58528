"""Play of pins as forces reverse: by hand, and beside pins that are followed through bores."""

from dataclasses import replace
from math import cos, hypot, pi, sin, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import loads
from loads.joint_play import Hit, play_hits, with_hits

from .machines import slider_crank

GROUND = loads.GROUND
MASS, PLAY = 2e-3, 0.05  # t, mm


def pulled(rate, law=None, weight=0.0):
    """Cycle of a mass on a line that a slider without mass leads by a pin at 100 mm/s.

    A push on the mass falls by a rate, N/s, through nothing in the middle: the pin's force rises.
    """
    linkage = loads.Linkage(
        bodies=(
            loads.Body(GROUND, {"O": (0.0, 0.0)}),
            loads.Body("leader", {"P": (0.0, 0.0)}),
            loads.Body("mass", {"P": (0.0, 0.0), "Q": (50.0, 0.0)}, mass=MASS, inertia=1.0),
        ),
        joints=(
            loads.Prismatic("lead", GROUND, "leader", "O", "P", (1.0, 0.0)),
            loads.Revolute("P", "leader", "mass", "P"),
            loads.Slot("line", GROUND, "mass", "O", "Q", (1.0, 0.0)),
        ),
        forces=(
            loads.Force("drive", loads.PointCoordinate("leader", "P", (1.0, 0.0))),
            loads.Force("push", loads.PointCoordinate("mass", "P", (1.0, 0.0))),
        ),
        assembled={"leader": (0.0, 0.0, 0.0), "mass": (0.0, 0.0, 0.0)},
        gravity=(0.0, -weight / MASS),
    )
    along = loads.PointCoordinate("leader", "P", (1.0, 0.0))
    push = law or loads.Table(
        loads.PointCoordinate("mass", "P", (1.0, 0.0)), (0.0, 100.0), (rate / 2, -rate / 2)
    )
    cycle = loads.Cycle(
        "pull", along, 0.0, loads.SteadyPace(along, 100.0),
        (loads.Phase("go", 100.0, {"push": push}, "drive"),), n_positions=41,
    )  # fmt: skip
    return loads.run_cycle(linkage, cycle)


@pytest.mark.parametrize("rate", [2e3, 2e5])
def test_a_force_that_rises_evenly(rate):
    (hit,) = play_hits(pulled(rate), "P", PLAY, 1e5)
    time = (6 * MASS * PLAY / rate) ** (1 / 3)
    speed = rate * time**2 / (2 * MASS)
    assert hit.leaves == pytest.approx(0.5, abs=1e-9)
    assert hit.hits - hit.leaves == pytest.approx(time, rel=1e-6)
    assert hit.force == pytest.approx(rate * time, rel=1e-6)
    assert hit.added == pytest.approx(hypot(rate * time, speed * sqrt(1e5 * MASS)), rel=1e-6)


def test_a_force_that_jumps_is_a_falling_weight():
    """Timoshenko's sudden fall: F + sqrt(F^2 + 2 k c F) in all."""
    coordinate = loads.PointCoordinate("mass", "P", (1.0, 0.0))
    law = loads.Table(coordinate, (0.0, 50.0, 50.0 + 1e-9, 100.0), (400.0, 400.0, -900.0, -900.0))
    (hit,) = play_hits(pulled(0.0, law), "P", PLAY, 1e5)
    assert hit.force == pytest.approx(900.0)
    assert hit.added == pytest.approx(sqrt(900.0**2 + 2 * 1e5 * PLAY * 900.0), rel=1e-4)


@pytest.mark.parametrize("law", [(900.0, 300.0), (-300.0, -900.0)])
def test_a_force_that_jumps_on_its_own_side_leaves_no_wall(law):
    coordinate = loads.PointCoordinate("mass", "P", (1.0, 0.0))
    before, after = law
    table = loads.Table(coordinate, (0.0, 50.0, 51.0, 100.0), (before, before, after, after))
    assert not play_hits(pulled(0.0, table), "P", PLAY, 1e5)


@pytest.mark.parametrize(("share", "count"), [(0.5, 1), (2.0, 0)])
def test_a_force_that_turns_in_the_bore_keeps_the_pin_on_its_wall(share, count):
    rate = 2e4
    across = share * (6 * MASS * PLAY * rate**2) ** (1 / 3)
    assert len(play_hits(pulled(rate, weight=across), "P", PLAY, 1e5)) == count


RESTITUTION = 0.84
DAMPING = -np.log(RESTITUTION) / hypot(pi, np.log(RESTITUTION))


def followed(mass, force, stiffness, times, start):
    """Largest force of a pin's contact beyond the force without play, N, along one line."""
    damper = 2.0 * DAMPING * sqrt(stiffness * mass)

    def contact(state):
        away = abs(state[0]) - PLAY / 2
        side = np.sign(state[0])
        return -side * max(stiffness * away + damper * side * state[1], 0.0) if away > 0.0 else 0.0

    def rates(time, state):
        return [state[1], (contact(state) - force(time)) / mass]

    found = solve_ivp(rates, times, start, rtol=1e-8, atol=1e-12,
                      max_step=0.2 * sqrt(mass / stiffness))  # fmt: skip
    carried = np.array([contact(state) for state in found.y.T])
    without = np.array([force(time) for time in found.t])
    return float((np.abs(carried) - np.abs(without)).max())


@pytest.mark.parametrize("stiffness", [3e3, 1e5, 3e6])
def test_a_pin_that_is_followed_hits_less(stiffness):
    rate = 2e5
    (hit,) = play_hits(pulled(rate), "P", PLAY, stiffness)
    time = hit.hits - hit.leaves
    seat = PLAY / 2 + 3.0 * time * rate / stiffness
    peak = followed(MASS, lambda t: rate * t, stiffness, (-3.0 * time, 8.0 * time), [seat, 0.0])
    loose = 0.3 if stiffness == 3e3 else 0.7  # it yields by more than the play
    assert loose * hit.added < peak < hit.added


# Slider-crank whose gudgeon pin has play: the rod turns about the crank's pin, the slider is free.
CRANK, ROD, SPEED = 50.0, 200.0, 60.0
ROD_MASS, ROD_INERTIA, SLIDER = 1e-3, 4.0, 1.5e-3
ANGLE = loads.Angle("crank", point="O")
TURN = loads.Cycle(
    "turn", ANGLE, 0.0, loads.SteadyPace(ANGLE, SPEED),
    (loads.Phase("turn", 2 * pi, {"push": 0.0}, "drive"),), n_positions=361,
)  # fmt: skip


def engine(brake=None):
    """Its loads; with a brake of 3 N m before or after the drive among its forces."""
    linkage = slider_crank(
        CRANK, ROD, crank_body={"mass": 2e-3, "inertia": 1.0},
        rod_body={"mass": ROD_MASS, "inertia": ROD_INERTIA, "centre": (ROD / 3, 0.0)},
        slider_mass=SLIDER,
    )  # fmt: skip
    if brake is None:
        return loads.run_cycle(linkage, TURN)
    own = (loads.Force("brake", ANGLE),)
    forces = own + linkage.forces if brake == "first" else linkage.forces + own
    phases = tuple(replace(one, given={**one.given, "brake": -3e3}) for one in TURN.phases)
    return loads.run_cycle(replace(linkage, forces=forces), replace(TURN, phases=phases))


def contact_with_play(stiffness):
    """Times and force on the slider's pin (n, 2) of an engine with play, over two turns."""
    about = ROD_INERTIA + ROD_MASS * (ROD / 3) ** 2
    damper = 2.0 * DAMPING * sqrt(stiffness * SLIDER)

    def state_of(time, state):
        turned, x, spin, speed = state
        crank = SPEED * time
        pin = CRANK * np.array([cos(crank), sin(crank)])
        along, across = np.array([cos(turned), sin(turned)]), np.array([-sin(turned), cos(turned)])
        apart = np.array([x, 0.0]) - pin - ROD * along
        rate = (
            np.array([speed, 0.0])
            - CRANK * SPEED * np.array([-sin(crank), cos(crank)])
            - ROD * spin * across
        )
        away = hypot(*apart)
        force = np.zeros(2)
        if away > PLAY / 2:
            out = apart / away
            force = -out * max(stiffness * (away - PLAY / 2) + damper * float(rate @ out), 0.0)
        return force, pin, across

    def rates(time, state):
        force, pin, across = state_of(time, state)
        dragged = -(SPEED**2) * pin  # acceleration of the crank's pin
        turning = -ROD * float(across @ force) - ROD_MASS * ROD / 3 * float(across @ dragged)
        return [state[2], state[3], turning / about, force[0] / SLIDER]

    x = CRANK + ROD
    swing = -CRANK * SPEED / ROD
    seat = PLAY / 2 + np.abs(SLIDER * SPEED**2 * CRANK * (1 + CRANK / ROD)) / stiffness
    found = solve_ivp(rates, (0.0, 4 * pi / SPEED), [0.0, x + seat, swing, 0.0], rtol=1e-8,
                      atol=1e-11, max_step=0.2 * sqrt(SLIDER / stiffness))  # fmt: skip
    forces = [state_of(t, y)[0] for t, y in zip(found.t, found.y.T, strict=True)]
    return found.t, np.array(forces)


@pytest.mark.parametrize("stiffness", [1e5, pytest.param(1e6, marks=pytest.mark.slow)])
def test_a_slider_crank_with_play_in_its_gudgeon_pin(stiffness):
    cycle = engine()
    hits = play_hits(cycle, "B", PLAY, stiffness)
    bound = np.hypot(*with_hits(cycle, "B", hits).reactions["B"].force.T)
    times, force = contact_with_play(stiffness)
    second = times >= cycle.times[-1]
    times, sizes = times[second] - cycle.times[-1], np.hypot(*force[second].T)
    without, found = (
        np.interp(times, cycle.times, values)
        for values in (np.hypot(*cycle.reactions["B"].force.T), bound)
    )
    assert len(hits) == 2
    assert (sizes <= found).all()
    assert (sizes - without).max() > max(hit.added for hit in hits) / 3.5


@pytest.mark.parametrize("inertia", [float("inf"), 50.0])
def test_bodies_stay_in_equilibrium_under_hits(inertia):
    cycle = engine()
    assert not play_hits(cycle, "A", PLAY, 1e6, inertia)  # the rod's centrifugal force stays
    hits = play_hits(cycle, "B", PLAY, 1e6, inertia)
    hit = with_hits(cycle, "B", hits, inertia)
    assert max(hit.equilibrium_residual.values()) < 1e-9
    # what keeps the drive's rate, or holds it back, has its share of the hit
    assert np.abs(hit.efforts["drive"] - cycle.efforts["drive"]).max() > 1e3


@pytest.mark.parametrize("brake", ["first", "last"])
def test_of_two_torques_on_one_angle_the_drive_alone_has_its_share_of_a_hit(brake):
    plain, braked = engine(), engine(brake)
    hits = play_hits(plain, "B", PLAY, 1e6)
    one, other = with_hits(plain, "B", hits), with_hits(braked, "B", hits)
    assert (other.efforts["brake"] == -3e3).all()
    assert_allclose(other.efforts["drive"], one.efforts["drive"] + 3e3, rtol=1e-9)
    assert max(other.equilibrium_residual.values()) < 1e-9


def test_hits_on_other_times_last_up_to_a_jump_of_the_loads():
    """A phase ends where its last time stands twice; of both rows a hit may have one alone."""
    cycle = pulled(-200.0)
    times = cycle.times.copy()
    times[21] = times[20]
    hit = Hit(0.0, 0.0, 10.0, 70.0, np.arange(5, 21))
    cycle = replace(cycle, times=times)
    own, found = (
        np.hypot(*one.reactions["P"].force.T)
        for one in (cycle, with_hits(cycle, "P", [hit], times=times))
    )
    assert_allclose(found[5:21] - own[5:21], 70.0)
    assert_allclose(found[22:], own[22:])


def test_a_linkage_without_mass_has_no_hits():
    cycle = engine()
    bodies = tuple(
        body if body.name == GROUND else body.with_mass_properties(0.0, (0.0, 0.0), 0.0)
        for body in cycle.linkage.bodies
    )
    light = loads.run_cycle(replace(cycle.linkage, bodies=bodies), TURN)
    assert not play_hits(light, "B", PLAY, 1e6)
