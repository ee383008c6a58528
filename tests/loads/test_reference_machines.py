"""Machines with independent solutions: a toggle press and an offset slider-crank (SI units).

Signs: toggle C ground on lower bar, B lower on upper, A upper on mould, guide on mould;
slider-crank O ground on crank, A crank on rod, B rod on slider, guide on slider.
"""

import json
from math import radians
from pathlib import Path

import numpy as np
import pytest

from loads import Angle, move, solve_forces, trace

from .machines import at_state, slider_crank, toggle, toggle_height

REFERENCE = json.loads((Path(__file__).parent / "reference_machines.json").read_text())


def states(machine):
    return [
        pytest.param(case["parameters"], state, id=f"{machine}-{i}-{j}")
        for i, case in enumerate(REFERENCE[machine])
        for j, state in enumerate(case["states"])
    ]


def compare(checks, values):
    assert checks
    for check in checks:
        value, expected = float(values[check["quantity"]]), check["value"]
        allowed = max(check["tol_abs"], check["tol_rel"] * abs(expected))
        assert abs(value - expected) <= allowed, (check["quantity"], value, expected)


@pytest.mark.parametrize(("parameters", "state"), states("toggle"))
def test_the_toggle_press_agrees_with_the_independent_solution(parameters, state):
    """Friction of pins and guide, weights and inertia included, down to 1 mm before dead centre."""
    p = parameters
    linkage = toggle(
        p["h"],
        p["l"],
        p["m_bar"],
        p["m_mould"],
        p["I_bar"],
        p["g"],
        p["mu_pin"],
        p["r_pin"],
        p["mu_guide"],
    )
    cylinder = linkage.force("cylinder").coordinate
    height = p["h"] - state["x_m"]
    geometry = trace(linkage, toggle_height(linkage), 0.29, height).at(np.array([height]))
    motion = move(geometry, cylinder, p["v_cyl"], direction=1)
    solution = solve_forces(motion, {"cylinder": p["F_B"]}, "process")
    k, pose, rates = motion.kinematics, motion.poses, motion.velocities
    knee = k.point(pose, "lower", "B")[0]
    reach = k.span(pose, cylinder)[0]
    mould = pose[0, 3]
    joints = {name: load.force[0] for name, load in solution.joints.items()}
    to_knee = knee / np.hypot(*knee)
    to_mould = (mould[:2] - knee) / np.hypot(*(mould[:2] - knee))
    compare(
        state["checks"],
        {
            "gamma": np.arctan2(knee[0], knee[1]),
            "a": knee[0],
            "BD": np.hypot(*reach),
            "alpha": np.arctan2(-reach[1], reach[0]),
            "v_B": np.hypot(*k.velocity(pose, rates, "lower", knee[None])[0]),
            "v_A": rates[0, 3, 1],
            "bar_omega": rates[0, 1, 2],
            "a_A": motion.accelerations[0, 3, 1],
            "F_A": solution.efforts["process"][0],
            "C_x": joints["C"][0],
            "C_y": joints["C"][1],
            "B_x": joints["B"][0],
            "B_y": joints["B"][1],
            "A_x": joints["A"][0],
            "A_y": joints["A"][1],
            "N_guide": joints["guide"][0],
            "comp_lower": joints["C"] @ to_knee,
            "comp_upper": joints["A"] @ to_mould,
        },
    )


@pytest.mark.parametrize(("parameters", "state"), states("slider_crank"))
def test_the_slider_crank_agrees_with_the_independent_solution(parameters, state):
    """Offset and centred, slow and at 300 rpm, with guide friction."""
    p, angle = parameters, radians(state["crank_angle_deg"])
    linkage = slider_crank(
        p["R2"],
        p["R3"],
        p["yb"],
        {"mass": p["m2"], "inertia": p["I2"], "centre": (p["R2"] / 2, 0.0)},
        {"mass": p["m3"], "inertia": p["I3"], "centre": (p["R3"] / 2, 0.0)},
        p["m4"],
        (0.0, -p["g"]),
        p["mu"],
        at=angle,
    )
    motion = at_state(linkage, Angle("crank"), angle, p["omega"], p["alpha"])
    solution = solve_forces(motion, {"push": p["Fp"]}, "drive")
    pose, rates, rises = motion.poses[0], motion.velocities[0], motion.accelerations[0]
    along = np.array([np.cos(pose[2, 2]), np.sin(pose[2, 2])])
    arm = p["R3"] / 2 * along
    centre = rises[2, :2] + rises[2, 2] * np.array([-arm[1], arm[0]]) - rates[2, 2] ** 2 * arm
    joints = {name: load.force[0] for name, load in solution.joints.items()}
    compare(
        state["checks"],
        {
            "rod_angle": pose[2, 2],
            "rod_omega": rates[2, 2],
            "rod_alpha": rises[2, 2],
            "slider_x": pose[3, 0],
            "slider_v": rates[3, 0],
            "slider_a": rises[3, 0],
            "G3_ax": centre[0],
            "G3_ay": centre[1],
            "O_x": joints["O"][0],
            "O_y": joints["O"][1],
            "A_x": joints["A"][0],
            "A_y": joints["A"][1],
            "B_x": joints["B"][0],
            "B_y": joints["B"][1],
            "N_guide": joints["guide"][1],
            "drive_torque": solution.efforts["drive"][0],
            "rod_axial": -joints["B"] @ along,
        },
    )
