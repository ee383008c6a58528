"""Loads of a blow in a cycle: a mass that a spring pushes at a steady speed, by hand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import loads

MASS, SPRING, SPEED, YIELDS = 5e-3, 800.0, 300.0, 900.0  # t, N/mm, mm/s, N


def solved(struck, *, tip=None):
    """A sled is moved at a steady speed; a pin that gives way pushes a mass before it to a stop.

    tip  N/mm, of a pin between the mass and a tip without mass that meets the stop in its place
    """
    place = loads.PointCoordinate("sled", "P", (1.0, 0.0))
    bodies = [
        loads.Body("ground", {"O": (0.0, 0.0)}),
        loads.Body("sled", {"P": (0.0, 0.0)}, 2e-3),
        loads.Body("mass", {"Q": (0.0, 0.0)}, MASS),
        loads.Body("link", {"P": (0.0, 0.0), "Q": (100.0, 0.0)}),
    ]
    joints = [
        loads.Prismatic("guide_1", "ground", "sled", "O", "P", (1.0, 0.0)),
        loads.Slot("guide_2", "ground", "mass", "O", "Q", (1.0, 0.0)),
        loads.Revolute("P", "sled", "link", "P"),
        loads.Fixed("Q", "link", "mass", "Q"),
    ]
    gives = [loads.JointCompliance("P", SPRING)]
    start = {"sled": (0.0, 0, 0), "mass": (100.0, 0, 0), "link": (0.0, 0, 0)}
    ahead = loads.PointCoordinate("mass", "Q", (-1.0, 0.0))
    if tip is not None:
        bodies.append(loads.Body("tip", {"Q": (0.0, 0.0), "S": (20.0, 0.0)}))
        joints.append(loads.Revolute("T", "mass", "tip", "Q"))
        joints.append(loads.Slot("guide_3", "ground", "tip", "O", "S", (1.0, 0.0)))
        gives.append(loads.JointCompliance("T", tip))
        start["tip"] = (100.0, 0, 0)
        ahead = loads.PointCoordinate("tip", "Q", (-1.0, 0.0))
    linkage = loads.Linkage(
        tuple(bodies),
        tuple(joints),
        (loads.Force("drive", place), loads.Force("stop", ahead)),
        start,
        compliance=tuple(gives),
    )
    contact = loads.Contact(-150.0, 1e3, struck=struck)
    phase = loads.Phase("push", 55.0, {"stop": contact}, "drive")
    cycle = loads.Cycle("push", place, 0.0, loads.SteadyPace(place, SPEED), (phase,), 111)
    found = loads.run_cycle(linkage, cycle)
    (row,) = found.contacts["stop"].begins
    return found, int(row), struck


@pytest.fixture(scope="module")
def pushed():
    return solved(loads.Struck(yields=YIELDS))


def test_what_gives_way_without_mass_is_a_spring_behind_the_workpiece():
    """A tip on a pin of 5 kN/mm meets a stop of 3 kN/mm: 15/8 kN/mm on the mass itself."""
    tipped, plain = (
        loads.blow_loads(cycle, cycle, "stop", row, struck, 0.0, inertia=0.0)
        for cycle, row, struck in (
            solved(loads.Struck(3e3), tip=5e3),
            solved(loads.Struck(15e3 / 8)),
        )
    )
    assert tipped.blow.force.max() == pytest.approx(plain.blow.force.max(), rel=1e-6)
    assert tipped.blow.contact == pytest.approx(plain.blow.contact, rel=1e-6)
    forces = [found.loads.reactions["P"].force[:, 0].max() for found in (tipped, plain)]
    assert forces[0] == pytest.approx(forces[1], rel=1e-3)
    assert_allclose(tipped.loads.reactions["T"].force[:, 0], tipped.blow.force, atol=1e-6)


def test_the_pin_behind_a_mass_carries_what_the_mass_lags_behind(pushed):
    """m u'' + k u = F_y of the lag u: k u = F_y (1 - cos wt) until u' = v, u' = v from there on."""
    cycle, row, struck = pushed
    found = loads.blow_loads(cycle, cycle, "stop", row, struck, 0.0)
    omega = np.sqrt(SPRING / MASS)
    stands = np.arcsin(SPEED * SPRING / (YIELDS * omega)) / omega
    times = found.blow.times
    lag = np.where(
        times < stands,
        YIELDS / SPRING * (1 - np.cos(omega * times)),
        YIELDS / SPRING * (1 - np.cos(omega * stands)) + SPEED * (times - stands),
    )
    assert found.blow.contact == pytest.approx(stands, rel=1e-6)
    assert_allclose(found.loads.reactions["P"].force[:, 0], SPRING * lag, rtol=1e-6, atol=1e-3)
    assert_allclose(found.loads.efforts["drive"], SPRING * lag, rtol=1e-6, atol=1e-3)
    pressed = times < stands
    assert_allclose(found.loads.efforts["stop"][pressed], YIELDS)
    assert_allclose(found.loads.efforts["stop"][~pressed], (SPRING * lag)[~pressed], rtol=1e-5)
    given = YIELDS - SPRING * lag[pressed]
    mass = found.loads.body_index("mass")
    assert_allclose(found.loads.accelerations[pressed, mass, 0], -given / MASS, rtol=1e-5)
    way = SPEED * stands - lag[pressed][-1]
    assert found.blow.depth == pytest.approx(
        SPEED * stands - YIELDS / SPRING * (1 - np.cos(omega * stands)), rel=1e-6
    )
    assert found.blow.energy == pytest.approx(YIELDS * found.blow.depth, rel=1e-6)
    assert way > 0


def test_the_moments_of_a_blow_take_the_place_of_the_positions_in_its_time(pushed):
    cycle, row, struck = pushed
    found = loads.blow_loads(cycle, cycle, "stop", row, struck, 0.02)
    whole = loads.with_blow(cycle, found)
    assert np.diff(whole.times).min() >= 0.0
    assert np.diff(whole.positions).min() >= -1e-9
    assert max(whole.equilibrium_residual.values()) < 1e-12
    assert whole.power_balance_error < 1e-12
    before, count = row + 1, len(found.blow.times)
    assert_allclose(whole.times[:before], cycle.times[:before])
    assert_allclose(whole.times[before : before + count], found.loads.times)
    kept = cycle.times > found.loads.times[-1]
    assert_allclose(whole.times[before + count :], cycle.times[kept])
    for name, load in cycle.reactions.items():
        assert_allclose(whole.reactions[name].force[before + count :], load.force[kept])
    assert whole.touches["stop"].gap.shape == whole.times.shape
    moments = np.flatnonzero(loads.moments_of_blows(whole))
    assert_allclose(moments, np.arange(before, before + count))


@pytest.mark.parametrize("inertia", [0.0, 4e-3])
def test_a_drive_that_is_not_held_strikes_with_its_inertia(pushed, inertia):
    """Two masses on one spring against an elastic workpiece, integrated by themselves."""
    cycle, row, _ = pushed
    stiffness = 3e3
    found = loads.blow_loads(
        cycle, cycle, "stop", row, loads.Struck(stiffness), 0.0, inertia=inertia
    )
    sled = 2e-3 + inertia

    def rates(_, state):
        sled_at, mass_at, *speeds = state
        spring = SPRING * (sled_at - mass_at)
        force = stiffness * max(mass_at, 0.0)
        return [*speeds, -spring / sled, (spring - force) / MASS]

    times = found.blow.times
    alone = solve_ivp(
        rates, (0.0, times[-1]), [0.0, 0.0, SPEED, SPEED], t_eval=times, rtol=1e-10, atol=1e-9,
        max_step=times[-1] / 2000,
    )  # fmt: skip
    assert_allclose(found.blow.force, stiffness * np.maximum(alone.y[1], 0.0), atol=0.2)
    spring = SPRING * (alone.y[0] - alone.y[1])
    assert_allclose(found.loads.reactions["P"].force[:, 0], spring, atol=0.2)
    assert_allclose(found.loads.efforts["drive"], inertia / sled * spring, atol=0.2)
    assert found.blow.deepest == pytest.approx(found.blow.force.max() / stiffness, rel=1e-6)
    assert found.turned == pytest.approx(0.0, abs=1e-12)


def test_a_drive_that_presses_on_against_a_spring_has_no_force(pushed):
    """On a contact as soft as its own spring the mass follows the sled, and never leaves."""
    cycle, row, _ = pushed
    with pytest.raises(loads.LinkageError, match="the drive keeps its rate and presses on"):
        loads.blow_loads(cycle, cycle, "stop", row, loads.Struck(50.0), 0.5)


def test_a_linkage_in_which_nothing_gives_way_has_no_modes_to_strike_with(pushed):
    cycle, row, struck = pushed
    rigid = loads.CycleLoads(
        **{
            **{name: getattr(cycle, name) for name in cycle.__dataclass_fields__},
            "linkage": loads.Linkage(
                cycle.linkage.bodies,
                cycle.linkage.joints,
                cycle.linkage.forces,
                cycle.linkage.assembled,
            ),
        }
    )
    with pytest.raises(loads.LinkageError, match="nothing of the linkage is elastic"):
        loads.blow_loads(rigid, rigid, "stop", row, struck, 0.0)
