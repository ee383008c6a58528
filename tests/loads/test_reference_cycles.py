"""Figures of whole cycles of the four machines against independent solutions (SI).

Extremes are taken from 7200 positions: between two of them a smooth quantity rises above both by
at most (2 pi / 7200)**2 / 8 = 1e-7 of its second derivative.

Not here: reference_machines.json, forging_force_cycles (the hammer on a workpiece, dp > 0), whose
force depends on the position by a law; their test belongs to the laws of forces.
"""

import json
import re
from functools import cache
from math import pi, radians
from pathlib import Path

import numpy as np
import pytest

from loads import Angle, LinkageError, move, trace

from .machines import QUICK_RETURN, quick_return, toggle_height
from .readings import (
    read_hammer,
    read_quick_return,
    read_slider_crank,
    read_toggle,
    toggle_of,
)

REFERENCE = json.loads((Path(__file__).parent / "reference_machines.json").read_text())
TURN = np.linspace(0.0, 2 * pi, 7201)
CRANK = Angle("crank")


def checks(machine):
    return [pytest.param(check, id=check["quantity"]) for check in REFERENCE["cycles"][machine]]


def bisected(low, high, above, tolerance):
    """The value between low and high from which on a condition holds that low does not meet."""
    assert above(high)
    assert not above(low)
    while abs(high - low) > tolerance:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if above(middle) else (middle, high)
    return 0.5 * (low + high)


@pytest.fixture(scope="module")
def slider_crank_turn():
    return read_slider_crank(REFERENCE["slider_crank"][0]["parameters"], TURN)


@pytest.mark.parametrize("check", checks("slider_crank"))
def test_extremes_of_the_slider_crank(check, slider_crank_turn, meets):
    """Each also at the crank angle stated, to the nearest hundredth of a degree."""
    _, extreme, quantity = check["quantity"].split("_", 2)
    values = slider_crank_turn[quantity]
    meets("slider_crank cycle", check, getattr(np, extreme)(values))
    where = TURN[getattr(np, f"arg{extreme}")(values)]
    assert abs(np.degrees(where) - check["at_deg"]) <= 0.005 + 360.0 / 7200


@pytest.mark.parametrize("cycle", REFERENCE["cycles"]["hammer"], ids=lambda c: f"{c['omega']}")
def test_extremes_of_the_hammer_without_workpiece(cycle, meets):
    """Stress of a leaf left of the pivot: bending by D over the distance to D, three leaves.

    M (t / 2) / (n I), 60 x 9.6 mm each; the mean torque of a turn without losses is zero.
    """
    assert cycle["dp"] == 0.0
    p = REFERENCE["hammer"][0]["parameters"] | {"omega": cycle["omega"]}
    turn = read_hammer(p, TURN)
    width, thickness, leaves = 0.06, 0.0096, 3
    modulus = leaves * width * thickness**2 / 6
    turn["leaf_stress_R_left"] = turn["D_normal"] * turn["slot_distance"] / modulus * 1e-6
    for check in cycle["checks"]:
        _, extreme, quantity = check["quantity"].split("_", 2)
        values = turn[quantity][:-1]  # a mean counts no position twice
        meets("hammer cycle", check, getattr(np, extreme)(values))


@pytest.mark.parametrize("check", checks("toggle"))
def test_figures_of_the_toggle_press(check, meets):
    """Closed form of statics (the engine at 1e-6 m/s), bar forces at 0.1 m/s, cylinder's stroke."""
    p = REFERENCE["toggle"][0]["parameters"]
    slow, moving = (read_toggle({**p, "v_cyl": speed}, 0.002) for speed in (1e-6, 0.1))
    linkage = toggle_of(p)
    cylinder = linkage.force("cylinder").coordinate
    path = trace(linkage, cylinder, 0.34, 0.57)

    def folded_beyond(length):  # the mould falls with the length once the knee is past the line
        return path.at(np.array([length])).first[0, 3, 1] < 0.0

    dead_centre = bisected(0.34, 0.5, folded_beyond, 1e-9)
    values = {
        "static closed form F_A at x=0.002, 11 kN": slow["F_A"][0],
        "bar force AB at x=0.002": moving["comp_upper"][0],
        "bar force BC at x=0.002": moving["comp_lower"][0],
        "cylinder stroke x=0.2 -> 0": read_toggle(p, 0.2)["BD"][0] - dead_centre,
    }
    meets("toggle cycle", check, values[check["quantity"]])
    assert toggle_height(linkage).label == "A.y"


def turn_of(width, at=pi / 2):
    """Path of the quick return with the hammer's line at a distance, over a turn of the crank."""
    linkage = quick_return({**QUICK_RETURN, "D": width}, at=at)
    return trace(linkage, CRANK, at, at + 2 * pi)


def turns_round(width):
    try:
        turn_of(width)
    except LinkageError:
        return False
    return True


def stroke_and_gap(width, n=1001):
    """Stroke of the hammer, and the smallest |R sin theta - y| (0 where the rod lies level).

    The lever's dead points are among the positions: there the stroke ends, unless it grows.
    """
    path = turn_of(width)
    low, high = path.values[[0, -1]]
    angles = np.concatenate([np.linspace(low, high, n), dead_points()])
    poses = path.at(angles).poses
    height, lever = poses[:, 5, 1], poses[:, 3, 2]
    drop = QUICK_RETURN["R"] * np.sin(lever) - height
    return np.ptp(height), np.abs(drop).min()


@cache
def dead_points():
    """The two crank angles at which the lever stands still, by bisection of its speed's sign."""
    path = turn_of(0.17, at=0.1)

    def turned_back(angle):
        return path.at(np.array([angle])).first[0, 3, 2] < 0.0

    there = bisected(0.2, 3.1, turned_back, 1e-12)
    return there, bisected(6.2, 3.2, turned_back, 1e-12)


@pytest.fixture(scope="module")
def quick_return_figures():
    p = REFERENCE["quick_return"][0]["parameters"]
    turn = read_quick_return(p, TURN)
    there, back = dead_points()
    swing = trace(quick_return(at=0.1), CRANK, 0.0, 2 * pi).at(np.array([there, back])).poses
    widest = bisected(0.2242, 0.2244, lambda width: not turns_round(width), 3e-8)
    best = bisected(0.222, widest - 1e-7, lambda width: stroke_and_gap(width)[1] < 0.01, 1e-6)
    stroke = stroke_and_gap(0.17)[0]
    return {
        "stroke": np.ptp(turn["hammer_y"]),
        "hammer_y_min": turn["hammer_y"].min(),
        "hammer_y_max": turn["hammer_y"].max(),
        "lever_swing_half_angle": np.degrees(np.ptp(swing[:, 3, 2]) / 2),
        "time_ratio_slow_to_fast": (there + 2 * pi - back) / (back - there),
        "D_min_for_full_rotation": bisected(0.1299, 0.1301, turns_round, 3e-8),
        "D_max_for_full_rotation": widest,
        "D_above_which_stroke_grows": bisected(
            0.2, 0.215, lambda width: stroke_and_gap(width)[0] > stroke * (1 + 1e-9), 1e-5
        ),
        "best_D_with_min_denominator_0.010": best,
        "stroke_at_best_D_with_min_denominator_0.010": stroke_and_gap(best)[0],
    }


@pytest.mark.parametrize("check", checks("quick_return"))
def test_figures_of_the_quick_return(check, quick_return_figures, meets):
    """Where the engine refuses a turn, where the stroke grows, where the gap of 10 mm is left."""
    meets("quick_return cycle", check, quick_return_figures[check["quantity"]])


def test_the_stroke_of_the_quick_return_grows_up_to_the_best_width(quick_return_figures):
    """So the best width is where the least allowed |R sin theta - y| ends it."""
    best = quick_return_figures["best_D_with_min_denominator_0.010"]
    strokes = [stroke_and_gap(width)[0] for width in np.linspace(0.2095, best, 6)]
    assert (np.diff(strokes) > 0.0).all()


@pytest.mark.parametrize("width", [0.13 - 1e-6, 0.2242778 + 1e-6])
def test_a_turn_that_just_fails_to_close_is_refused_where_the_rod_lies_level(width):
    """1 um beyond the limits. Below, the lever is level (0, 180 deg); above, it turns back."""
    with pytest.raises(
        LinkageError, match=r"crank\.angle .*(cannot be reached|dead centre)"
    ) as info:
        turn_of(width)
    level = (0.0, pi) if width < 0.17 else dead_points()
    stated = [radians(float(number)) for number in re.findall(r"([\d.]+) deg", str(info.value))]
    off = [abs((value - angle + pi) % (2 * pi) - pi) for value in stated for angle in level]
    assert min(off) < 0.03, str(info.value)


def test_speeds_of_the_quick_return_are_those_of_the_crank():
    """The largest lever speed r omega / (d - r), at 180 degrees (closed form)."""
    path = turn_of(0.17, at=0.1)
    motion = move(path.at(np.array([pi])), CRANK, 4.0, 1)
    assert motion.velocities[0, 3, 2] == pytest.approx(-4.0 * 0.07 / 0.04, rel=1e-12)
