"""Positions near folds and change points, where two ways of assembling a linkage come together."""

from collections import OrderedDict
from math import acos, atan2, cos, hypot, pi, sin

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import loads.path
from loads import Angle, trace

from .machines import four_bar

CRANK, ROCKER = Angle("crank"), Angle("rocker")


def rocker_angle(crank, coupler, rocker, ground, angle):
    """The rocker of the open four-bar by two triangles, between -pi and pi."""
    a = (crank * cos(angle), crank * sin(angle))
    gap = hypot(ground - a[0], a[1])
    lift = acos((coupler**2 + gap**2 - rocker**2) / (2 * coupler * gap))
    theta = atan2(-a[1], ground - a[0]) + lift
    return atan2(a[1] + coupler * sin(theta), a[0] + coupler * cos(theta) - ground)


def wrapped(angles):
    return np.remainder(np.asarray(angles) + pi, 2 * pi) - pi


@pytest.mark.parametrize("crank", [90.0, 99.9, 100.1, 101.0])
def test_a_kite_beside_its_change_point_stays_on_its_branch(crank):
    """Rocker and coupler nearly fold onto crank and ground: the branches are 0.001 to 0.1 apart.

    Asked for one position at a time, so that none is put right by what its neighbours need.
    """
    lengths = (crank, 250.0, 250.0, 100.0)
    path = trace(four_bar(*lengths, at=1.0), CRANK, -3.0, 3.0)
    for value in (*np.linspace(-0.2, 0.2, 41), -2.0, 2.0):
        pose = path.at(np.array([value])).poses[0]
        expected = rocker_angle(*lengths, value)
        assert_allclose(wrapped(pose[3, 2] - expected), 0.0, atol=1e-9)


@pytest.mark.parametrize("before", [1e-4, 1e-5, 3e-6, 1e-6, 1e-7])
def test_a_rocker_just_before_its_limit_does_not_fall_to_another_branch(before):
    """At the limit the crank lies back along the coupler: 150, 300 and 200 mm make a triangle.

    The crank has come there from its assembled angle, over no more than half a turn.
    """
    lengths = (100.0, 250.0, 200.0, 300.0)
    folded = pi + acos((150.0**2 + 300.0**2 - 200.0**2) / (2 * 150.0 * 300.0))
    limit = rocker_angle(*lengths, folded)
    linkage = four_bar(*lengths)
    begin = linkage.assembled["rocker"][2]
    path = trace(linkage, ROCKER, begin, limit - before)
    for value in np.linspace(begin, limit - before, 150):
        crank = path.at(np.array([value])).poses[0, 1, 2]
        assert_allclose(rocker_angle(*lengths, crank), value, atol=1e-9)
        assert linkage.assembled["crank"][2] - 1e-9 < crank < folded


@pytest.mark.parametrize("crank", [100.5, 101.0, 102.0])
def test_a_body_that_turns_fast_does_not_gain_a_turn_in_one_step(crank):
    """Near its change point the rocker turns by half a turn while the crank turns by some degrees.

    The ground is the shortest side, so that the rocker turns with the crank, once for each turn.
    """
    lengths = (crank, 250.0, 250.0, 100.0)
    values = np.linspace(-3.0, 3.0, 6001)
    expected = np.unwrap([rocker_angle(*lengths, value) for value in values])
    found = trace(four_bar(*lengths, at=1.0), CRANK, -3.0, 3.0).at(values).poses[:, 3, 2]
    assert_allclose(found - found[0], expected - expected[0], atol=1e-8)


def test_a_body_that_swings_does_not_gain_a_turn_where_it_is_fast():
    """The rocker of a crank-rocker comes back: crank + coupler < rocker + ground."""
    path = trace(four_bar(90.0, 250.0, 250.0, 100.0, at=1.0), CRANK, -3.0, 3.0)
    rocker = path.at(np.linspace(-3.0, 3.0, 2001)).poses[:, 3, 2]
    assert np.abs(np.diff(rocker)).max() < 0.1


def test_a_branch_is_traced_once_for_linkages_that_differ_in_masses_alone(monkeypatch):
    traced = []
    anew = loads.path._traced_anew
    monkeypatch.setattr("loads.path._traced_anew", lambda *all: traced.append(all) or anew(*all))
    monkeypatch.setattr("loads.path._traced", OrderedDict())
    bare = four_bar(90.0, 250.0, 250.0, 100.0, at=1.0)
    heavy = bare.with_mass_properties({"crank": (1e-3, (45.0, 0.0), 2.0)})
    first, second = (trace(linkage, CRANK, -1.0, 1.0) for linkage in (bare, heavy))
    assert len(traced) == 1
    assert second.kinematics.linkage is heavy
    assert_array_equal(second.poses, first.poses)
    longer = trace(four_bar(90.0, 251.0, 250.0, 100.0, at=1.0), CRANK, -1.0, 1.0)
    trace(bare, CRANK, -1.0, 1.1)
    assert len(traced) == 3
    assert not np.array_equal(longer.poses[-1], first.poses[-1])
