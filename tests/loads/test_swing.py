"""Swing between blows: a mass that a crank pushes to and fro on a spring, against a stop."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import loads
from loads.harmonics import cycle_response, with_vibration

MASS, SPRING, SPIN, DAMPING = 5e-3, 8.0, 5.0, 0.1  # t, N/mm, rad/s, ratio
CRANK, ROD = 30.0, 200.0
OMEGA = np.sqrt(SPRING / MASS)


def pushed(struck, at=205.0):
    """Crank, rod and sled; a pin that gives way pushes a mass before the sled to a stop."""
    turn = loads.Angle("crank")
    place = loads.PointCoordinate("mass", "Q", (-1.0, 0.0))
    linkage = loads.Linkage(
        (
            loads.Body("ground", {"O": (0.0, 0.0)}),
            loads.Body("crank", {"O": (0.0, 0.0), "A": (CRANK, 0.0)}),
            loads.Body("rod", {"A": (0.0, 0.0), "B": (ROD, 0.0)}),
            loads.Body("sled", {"B": (0.0, 0.0)}, 2e-3),
            loads.Body("link", {"B": (0.0, 0.0), "Q": (100.0, 0.0)}),
            loads.Body("mass", {"Q": (0.0, 0.0)}, MASS),
        ),
        (
            loads.Revolute("O", "ground", "crank", "O"),
            loads.Revolute("A", "crank", "rod", "A"),
            loads.Revolute("B", "rod", "sled", "B"),
            loads.Prismatic("guide", "ground", "sled", "O", "B", (1.0, 0.0)),
            loads.Revolute("spring", "sled", "link", "B"),
            loads.Fixed("weld", "link", "mass", "Q"),
            loads.Slot("track", "ground", "mass", "O", "Q", (1.0, 0.0)),
        ),
        (loads.Force("drive", turn), loads.Force("stop", place)),
        {"crank": (0.0, 0, 0), "rod": (CRANK, 0, 0), "sled": (CRANK + ROD, 0, 0),
         "link": (CRANK + ROD, 0, 0), "mass": (CRANK + ROD + 100.0, 0, 0)},
        compliance=(loads.JointCompliance("spring", SPRING),),
    )  # fmt: skip
    contact = loads.Contact(-100.0 - at, struck=struck)
    whole = loads.Phase("turn", 1.5 * np.pi, {"stop": contact}, "drive")
    cycle = loads.Cycle("turn", turn, -0.5 * np.pi, loads.SteadyPace(turn, SPIN), (whole,), 721)
    return loads.run_cycle(linkage, cycle), cycle, contact


def way(time):
    """Place of the sled, mm, and its rate: crank angle -90 deg at time 0."""
    angle = SPIN * time - 0.5 * np.pi
    lean = np.arcsin(CRANK * np.sin(angle) / ROD)
    rate = -CRANK * SPIN * np.sin(angle + lean) / np.cos(lean)
    return CRANK * np.cos(angle) + ROD * np.cos(lean), rate


def swung(struck, **kept):
    touching, cycle, contact = pushed(struck)
    free = loads.without_contact(touching, cycle, "stop")
    response = cycle_response(free, DAMPING)
    moving = with_vibration(free, response)
    found = loads.swung_cycle(touching, moving, free, response, "stop", contact, DAMPING, **kept)
    return touching, free, found


def alone(force, times, cycles):
    """Place of the mass by an integration of its own, over the last of some cycles."""
    drag = 2 * DAMPING * OMEGA * MASS

    def rates(time, state):
        sled, rate = way(time)
        pull = SPRING * (sled - state[0]) + drag * (rate - state[1])
        return [state[1], (pull - force(*state)) / MASS]

    start = [way(0.0)[0], way(0.0)[1]]
    shift = (cycles - 1) * 2 * np.pi / SPIN
    return solve_ivp(
        rates, (0.0, cycles * 2 * np.pi / SPIN), start, t_eval=shift + times, rtol=1e-9, atol=1e-9,
        max_step=1e-3,
    ).y  # fmt: skip


def test_a_mass_on_a_spring_bounces_on_an_elastic_stop_as_integrated_by_itself():
    """Every bounce, the force in the spring, and what the next cycle begins with."""
    stiffness = 60.0
    _, free, found = swung(loads.Struck(stiffness))
    times = free.times
    apart = np.append(True, np.diff(times) > 0)
    place, _ = alone(lambda x, _: stiffness * max(x - 205.0, 0.0), times[apart], 12)
    assert found.swing.changed < 0.005
    assert found.swing.missing < 1e-6
    assert len(found.swing.strikes) == 2
    assert_allclose(
        found.loads.efforts["stop"][apart], stiffness * np.maximum(place - 205.0, 0.0), atol=2.0
    )
    # of the spring alone, as damping of a mode is of no joint
    spring = SPRING * (way(times[apart])[0] - place)
    assert_allclose(found.loads.reactions["spring"].force[apart, 0], spring, atol=2.0)
    assert max(found.loads.equilibrium_residual.values()) < 1e-9
    assert found.loads.power_balance_error < 1e-9


def test_a_mass_that_rests_on_what_it_has_pressed_in_leaves_it_by_a_swing_of_the_sleds_speed():
    """It stands still until the spring pulls; then it lags by (v/w) e^(-zeta w t) sin wt.

    As if slowly it has none of that: it would follow the sled at once. By hand the spring's force
    is m v w e^(-zeta pi/2) = 25.7 N after a quarter of a swing, the sled's speed of 150 mm/s nearly
    the same all that time.
    """
    touching, free, found = swung(loads.Struck(yields=400.0))
    (strike,) = found.swing.strikes
    assert found.swing.turns == 2
    energy = 0.5 * MASS * strike.speed**2
    (blow,) = found.blows
    assert blow.blow.energy == pytest.approx(energy, rel=0.02)
    assert blow.speed == pytest.approx(strike.speed)
    assert blow.blow.force.max() == pytest.approx(400.0)
    times, stop = free.times, found.loads.efforts["stop"]
    leaves = times[np.flatnonzero(stop > 0.0)[-1] + 1]
    spring = found.loads.reactions["spring"].force[:, 0]
    speed = abs(way(leaves)[1])
    later = spring[times > leaves]
    expected = MASS * OMEGA * speed * np.exp(-DAMPING * np.pi / 2)
    assert np.abs(later).max() == pytest.approx(expected, rel=0.02)
    assert (
        np.abs(later).max() > 4 * np.abs(touching.reactions["spring"].force[times > leaves]).max()
    )


def test_a_drive_that_is_not_held_is_asked_for_the_work_of_the_swing():
    """The work of the spring's force on the sled, as integrated by itself, with the stop and free.

    Where the speed has the work of the contact as if slowly it is less by that.
    """
    inertia = 5e3
    found = swung(loads.Struck(60.0), inertia=inertia)[2]
    times = np.linspace(0.0, 2 * np.pi / SPIN, 20001)
    drag = 2 * DAMPING * OMEGA * MASS
    sled, rate = way(times)

    def power(stiffness):
        place, speed = alone(lambda x, _: stiffness * max(x - 205.0, 0.0), times, 12)
        return (SPRING * (sled - place) + drag * (rate - speed)) * rate

    def asked(power):
        work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(times))])
        return np.ptp(work - work[-1] * times / times[-1]) / (inertia * SPIN**2)

    struck = power(60.0) - power(0.0)
    assert found.surge == pytest.approx(asked(struck), rel=0.03)
    slowly = SPRING * np.maximum(sled - 205.0, 0.0) * rate
    slowed = swung(loads.Struck(60.0), inertia=inertia, slowed=True)[2].surge
    assert slowed == pytest.approx(asked(struck - slowly), rel=0.05)
    assert swung(loads.Struck(60.0))[2].surge == 0.0


def test_a_swing_that_never_repeats_says_so(monkeypatch):
    """Hardly damped on a stiff stop it bounces otherwise in every cycle, of 8 in place of 40."""
    monkeypatch.setattr("loads.swing._TURNS", 8)
    touching, cycle, contact = pushed(loads.Struck(5e3), at=200.0)
    free = loads.without_contact(touching, cycle, "stop")
    response = cycle_response(free, 1e-4)
    found = loads.swung_cycle(touching, free, free, response, "stop", contact, 1e-4)
    assert found.swing.turns == 8
    assert found.swing.changed > 0.02
    assert found.swing.missing < 1e-6


def test_without_its_contact_a_cycle_is_as_one_that_never_had_it():
    touching, cycle, _ = pushed(loads.Struck(60.0))
    free = loads.without_contact(touching, cycle, "stop")
    never = loads.run_at_positions(
        touching,
        touching.linkage,
        loads.Cycle(
            cycle.name, cycle.coordinate, cycle.start, cycle.pace,
            (loads.Phase("turn", 1.5 * np.pi, {"stop": 0.0}, "drive"),), 721,
        ),
    )  # fmt: skip
    assert_allclose(free.accelerations, never.accelerations, atol=1e-6)
    for name, load in never.reactions.items():
        assert_allclose(free.reactions[name].force, load.force, atol=1e-9)
    assert_allclose(free.efforts["drive"], never.efforts["drive"], atol=1e-6)
