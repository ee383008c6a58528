"""Invariances of random machines of four kinds: nothing changes, or in a known way (SI units).

Every machine is driven by its crank under gravity and a force or torque on what it drives. Numbers
are compared with the largest of their kind over the turn: all differences are rounding.
"""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from loads import Angle, LinkageError, move, solve_forces, trace

from .machines import HAMMER, QUICK_RETURN, four_bar, hammer, quick_return, slider_crank
from .transforms import in_mm_and_tonnes, is_angle, mirrored, turned, with_masses

CRANK = Angle("crank")
AT = 0.4
ANGLES = AT + 2 * pi * np.arange(24) / 24
FEW = settings(
    derandomize=True,
    deadline=None,
    database=None,
    max_examples=6,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)


def reals(low, high):
    return st.floats(low, high, allow_nan=False, allow_infinity=False)


@st.composite
def slider_cranks(draw, at=AT):
    rod, offset = draw(reals(1.4, 4.0)), draw(reals(-0.3, 0.3))
    masses = [draw(reals(0.1, 3.0)) for _ in range(3)]
    return slider_crank(
        0.1,
        0.1 * rod,
        0.1 * offset,
        {"mass": masses[0], "inertia": 1e-3 * masses[0], "centre": (0.05, 0.01)},
        {"mass": masses[1], "inertia": 2e-3 * masses[1], "centre": (0.06 * rod, -0.01)},
        masses[2],
        (0.0, -9.81),
        draw(st.sampled_from([0.0, 0.12])),
        at=at,
    )


@st.composite
def four_bars(draw, at=AT):
    """Crank-rockers: shortest and longest together shorter than the others (Grashof)."""
    crank, coupler, rocker = draw(reals(0.1, 0.4)), draw(reals(0.7, 1.3)), draw(reals(0.7, 1.3))
    sides = sorted([crank, coupler, rocker, 1.0])
    assume(sides[0] + sides[3] < 0.95 * (sides[1] + sides[2]))
    masses = {
        name: (mass := draw(reals(0.1, 3.0)), 0.02 * mass)
        for name in ("crank", "coupler", "rocker")
    }
    linkage = four_bar(
        crank, coupler, rocker, 1.0, masses, at=at, side=draw(st.sampled_from([1, -1]))
    )
    return replace(linkage, gravity=(0.0, -9.81))


@st.composite
def hammers(draw, at=AT):
    changed = {"l1": draw(reals(0.03, 0.14)), "m4": draw(reals(5.0, 80.0))}
    changed |= draw(st.sampled_from([{}, {"mu_guide": 0.15, "mu_slot": 0.1}]))
    return hammer(HAMMER | changed, at=at)


@st.composite
def quick_returns(draw, at=AT):
    changed = {"r": draw(reals(0.02, 0.08)), "D": draw(reals(0.15, 0.2))}
    changed |= draw(st.sampled_from([{}, {"mu_slot": 0.1, "mu_pin": 0.1, "r_pin": 0.004}]))
    return quick_return(QUICK_RETURN | changed, at=at)


KINDS = {
    "slider_crank": slider_cranks,
    "four_bar": four_bars,
    "hammer": hammers,
    "quick_return": quick_returns,
}
of_every_kind = pytest.mark.parametrize("kind", KINDS)


def loads_of(linkage, angles=ANGLES, speed=6.0, push=-30.0, direction=1):
    """Motion, and forces under a push on what is driven, at crank angles (any order)."""
    linkage.force("drive")
    path = trace(linkage, CRANK, min(angles), max(angles))
    motion = move(path.at(np.asarray(angles)), CRANK, speed, direction)
    given_force = {linkage.forces[1].name: push}
    return motion, solve_forces(motion, given_force, "drive")


def assert_same(found, expected, allowed=1e-10):
    largest = np.abs(expected).max()
    assert np.abs(found - expected).max() <= allowed * largest + 1e-300


def assert_forces(found, expected, allowed=1e-10, of_joint=lambda force: force, torque=1.0):
    """All joint forces over the turn, against the largest of them; the driving torque too."""
    forces = np.stack([load.force for load in found.joints.values()])
    others = np.stack([of_joint(expected.joints[name].force) for name in found.joints])
    assert_same(forces, others, allowed)
    assert_same(found.efforts["drive"], torque * expected.efforts["drive"], allowed)


@of_every_kind
@FEW
@given(data=st.data())
def test_a_reversed_crank_reverses_speeds_and_keeps_accelerations(kind, data):
    """Without friction the forces stay too: they follow accelerations and positions alone."""
    linkage = replace(data.draw(KINDS[kind]()), friction={})
    forth, back = loads_of(linkage), loads_of(linkage, direction=-1)
    assert_same(back[0].velocities, -forth[0].velocities)
    assert_same(back[0].accelerations, forth[0].accelerations)
    assert_forces(back[1], forth[1])


@of_every_kind
@FEW
@given(data=st.data())
def test_friction_opposes_a_crank_in_both_directions(kind, data):
    """The crank's torque, along its way, is less by friction's part in neither direction."""
    linkage = data.draw(KINDS[kind]())
    free = loads_of(replace(linkage, friction={}))[1].efforts["drive"]
    forth = loads_of(linkage)[1].efforts["drive"]
    back = loads_of(linkage, direction=-1)[1].efforts["drive"]
    rounding = 1e-10 * np.abs(free).max()
    assert (forth >= free - rounding).all()
    assert (back <= free + rounding).all()


@of_every_kind
@FEW
@given(data=st.data())
def test_a_mirrored_machine_has_mirrored_forces_and_reversed_torques(kind, data):
    linkage = data.draw(KINDS[kind]())
    other = mirrored(linkage)
    torque_given = is_angle(linkage.forces[1])
    _, expected = loads_of(linkage)
    _, found = loads_of(other, -ANGLES, push=30.0 if torque_given else -30.0, direction=-1)
    assert_forces(found, expected, of_joint=lambda force: force * [1.0, -1.0], torque=-1.0)


@of_every_kind
@FEW
@given(data=st.data(), angle=reals(-3.0, 3.0))
def test_a_turned_frame_turns_the_forces_with_it(kind, data, angle):
    linkage = data.draw(KINDS[kind]())
    _, expected = loads_of(linkage)
    _, found = loads_of(turned(linkage, angle), ANGLES + angle)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, s], [-s, c]])
    assert_forces(found, expected, of_joint=lambda force: force @ turn)


@of_every_kind
@FEW
@given(data=st.data(), k=st.integers(1, 23))
def test_it_does_not_matter_at_which_angle_a_machine_is_assembled(kind, data, k):
    """The same machine put together elsewhere on its turn has the same loads there."""
    linkage = data.draw(KINDS[kind]())
    motion, expected = loads_of(linkage)
    names = linkage.body_names[1:]
    poses = dict(zip(names, map(tuple, motion.poses[k, 1:]), strict=True))
    elsewhere = replace(linkage, assembled=poses)
    _, found = loads_of(elsewhere, np.concatenate([ANGLES[k:], ANGLES[:k] + 2 * pi]))
    for name, load in expected.joints.items():
        largest = max(np.abs(each.force).max() for each in expected.joints.values())
        assert np.abs(found.joints[name].force - np.roll(load.force, -k, axis=0)).max() < (
            1e-9 * largest
        )


@of_every_kind
@FEW
@given(data=st.data())
def test_millimetres_and_tonnes_give_the_newtons_of_metres_and_kilograms(kind, data):
    linkage = data.draw(KINDS[kind]())
    torque_given = is_angle(linkage.forces[1])
    _, expected = loads_of(linkage)
    _, found = loads_of(in_mm_and_tonnes(linkage), push=-3e4 if torque_given else -30.0)
    assert_forces(found, expected, torque=1000.0)


@of_every_kind
@FEW
@given(data=st.data(), decade=reals(-3.0, 3.0))
def test_without_gravity_forces_grow_with_the_square_of_the_speed(kind, data, decade):
    """From 1e-3 to 1e3 rad/s, against 1 rad/s; friction follows the forces."""
    linkage = replace(data.draw(KINDS[kind]()), gravity=(0.0, 0.0))
    speed = 10.0**decade
    _, expected = loads_of(linkage, speed=1.0, push=0.0)
    _, found = loads_of(linkage, speed=speed, push=0.0)
    assert_forces(
        found, expected, of_joint=lambda force: force * speed**2, torque=speed**2, allowed=1e-9
    )


@of_every_kind
@FEW
@given(data=st.data(), decade=reals(-6.0, 6.0), body=st.integers(0, 2))
def test_forces_of_masses_add_up_for_mass_ratios_to_a_million(kind, data, decade, body):
    """Without friction all forces are linear in the masses: one body alone, and all the others."""
    linkage = replace(data.draw(KINDS[kind]()), friction={})
    heavy = linkage.moving[body].name
    factor = 10.0**decade
    others = {b.name: 1.0 for b in linkage.moving if b.name != heavy}
    _, alone = loads_of(with_masses(linkage, {heavy: factor}), push=0.0)
    _, rest = loads_of(with_masses(linkage, others), push=0.0)
    _, both = loads_of(with_masses(linkage, others | {heavy: factor}), push=0.0)
    largest = max(np.abs(load.force).max() for load in both.joints.values())
    for name, load in both.joints.items():
        total = alone.joints[name].force + rest.joints[name].force
        assert np.abs(load.force - total).max() < 1e-10 * largest


def test_the_kinds_of_machines_close_over_a_turn_or_are_refused():
    """A hammer whose crank is too long for its rod and rocker."""
    with pytest.raises(LinkageError, match=r"cannot be reached|dead centre"):
        loads_of(hammer(HAMMER | {"l1": 0.5, "l2": 1.4}, at=AT))
