from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.result.motion import motion_gaps

from ...reports import loads_results, motion_results


@pytest.fixture(scope="module")
def press():
    return motion_results.press()


def test_a_node_is_turned_moved_and_lifted_by_its_part_s_frame(press):
    motion = press.motion["press"]
    nodes = np.array([[0.0, 0.0, 0.0], [250.0, 0.0, 3.0]])
    for row in (0, len(motion.index) // 2):
        origin, end = motion_results.placed(motion, "bar_lower", nodes, row)
        assert_allclose(origin, [0, 0, 10])  # C is the origin of the machine
        knee = motion.point("lower", "B")[row]
        assert_allclose(end, [*knee, 13.0], atol=1e-9)


def test_between_two_rows_the_frame_is_between_theirs(press):
    motion = press.motion["press"]
    upper = motion.parts["bar_upper"]
    low, high = upper[3:5]
    assert_allclose(motion_results.between(upper, 3.25), 0.75 * low + 0.25 * high)
    assert_allclose(motion_results.between(upper, 1e9), upper[-1])
    assert_allclose(motion_results.between(upper, -1.0), upper[0])


def test_rows_of_positions_that_are_not_kept_are_fractions(press):
    motion = press.motion["press"]
    assert motion.row_of(4) == 2
    assert motion.row_of(5) == 2.5
    assert motion.row_of(1e6) == len(motion.index) - 1


def test_points_and_travels_are_those_of_the_solved_cycle():
    shown = loads_results.press()
    motion = motion_results.motion(shown, {}, [], every=3)
    for body in shown.loads.linkage.bodies:
        for point in body.points:
            assert_allclose(
                motion.point(body.name, point), shown.loads.point(body.name, point)[::3], atol=1e-9
            )
    guides = [joint.name for joint in shown.loads.linkage.joints if hasattr(joint, "direction")]
    assert guides
    for name in guides:
        assert_allclose(motion.travel(name), shown.loads.travel(name)[::3], atol=1e-9)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"index": np.arange(0)}, "keeps one or more rising positions, got 0"),
        ({"index": np.zeros(5, dtype=int)}, "rising"),
        ({"times": np.zeros(3)}, "times needs finite numbers"),
        ({"layer": {}}, "needs a layer"),
    ],
)
def test_a_motion_that_does_not_fit_together_is_refused(press, changes, words):
    with pytest.raises(ValueError, match=words):
        replace(press.motion["press"], **changes)


def test_a_frame_that_is_no_number_is_refused(press):
    motion = press.motion["press"]
    parts = dict(motion.parts) | {"bar_upper": np.full_like(motion.parts["bar_upper"], np.nan)}
    with pytest.raises(ValueError, match="the frame of 'bar_upper' needs finite numbers"):
        replace(motion, parts=parts)


def test_a_measured_run_is_told_to_have_no_motion(press):
    (gap,) = motion_gaps(press)
    assert gap.startswith("rig: no motion is shown")
