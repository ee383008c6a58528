"""Peaks of loads that a cycle's positions miss, by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from loads.cycle_loads import NOTHING, unresolved


def solved(angles, forces, efforts):
    """One joint P between ground and a body at these angles, its force on the body in its axes."""
    c, s = np.cos(angles), np.sin(angles)
    x, y = np.array(forces, dtype=float).T
    ground = np.stack([c * x - s * y, s * x + c * y], axis=1)
    joint = SimpleNamespace(name="P", body_a="bar", body_b="bar")
    poses = np.zeros((len(angles), 1, 3))
    poses[:, 0, 2] = angles
    linkage = SimpleNamespace(joints=(joint,))
    motion = SimpleNamespace(
        kinematics=SimpleNamespace(linkage=linkage, index={"bar": 0}), poses=poses
    )
    solution = SimpleNamespace(
        joints={"P": SimpleNamespace(force=ground)}, efforts={"drive": np.array(efforts)}
    )
    return [(motion, solution)]


def test_a_component_is_compared_in_the_axes_of_its_body():
    """Along the turning bar 80 N at most, and 100 N where it was not seen: 20 N of 100 N."""
    turned = np.radians([0.0, 50.0, 90.0])
    cycle = solved(turned, [(80, 60), (0, 100), (-80, 0)], [1.0, 1.0, 1.0])
    other = solved(turned[:2], [(100, 0), (0, 100)], [1.0, 1.0])
    found = unresolved(cycle, [other])
    assert found.share == pytest.approx(0.2, rel=1e-12)
    assert found.what == "x of the force in joint P on bar"


def test_an_effort_is_compared_with_the_largest_effort():
    """From -4 to 2 N, and -5 N between: 1 N of 5 N."""
    angles = np.zeros(2)
    cycle = solved(angles, [(1, 0), (1, 0)], [-4.0, 2.0])
    found = unresolved(cycle, [solved(angles, [(1, 0), (1, 0)], [-5.0, 2.0])])
    assert found.share == pytest.approx(0.2, rel=1e-12)
    assert found.what == "the effort of drive"


def test_what_only_the_cycle_has_is_not_missed():
    angles = np.zeros(2)
    cycle = solved(angles, [(9, 0), (-9, 0)], [-4.0, 2.0])
    assert unresolved(cycle, [solved(angles, [(1, 0), (1, 0)], [-1.0, 1.0])]) == NOTHING


def test_no_load_misses_nothing():
    idle = solved(np.zeros(2), [(0, 0), (0, 0)], [0.0, 0.0])
    assert unresolved(idle, [idle]) == NOTHING


def test_what_rounding_leaves_on_a_joint_that_carries_nothing_is_not_missed():
    """Beside 1 kN a force that doubles between the positions: 1e-13 N is none, 1 N is half of 2."""
    angles = np.zeros(2)

    def beside(force):
        return solved(angles, [(force, 0), (0, 0)], [1000.0, 1000.0])

    assert unresolved(beside(1e-13), [beside(2e-13)]).share < 1e-6
    assert unresolved(beside(1.0), [beside(2.0)]).share == pytest.approx(0.5, rel=1e-12)


def test_the_worst_of_several_grids_counts():
    """2 and 3 N beyond 10 N: 3 of 13."""
    angles = np.zeros(2)
    cycle, one, two = (
        solved(angles, [(most, 0), (0, 0)], [0.0, 0.0]) for most in (10.0, 13.0, 12.0)
    )
    assert unresolved(cycle, [one, two]).share == pytest.approx(3 / 13, rel=1e-12)
