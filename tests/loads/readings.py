"""The quantities of the reference machines, by their names, at many positions at once (SI).

Reactions are named as in the reference: hammer A ground on crank, B crank on rod, C rod on rocker,
R ground on rocker, D ram on rocker; slider-crank O ground on crank, A crank on rod, B rod on
slider; quick return O1 ground on lever, O2 ground on crank, a crank on block, B lever on rod, C rod
on hammer, Q_block block on lever across it; toggle C ground on lower bar, B lower on upper, A upper
on mould; N_guide guide on what slides. Compressions of the bars and tension of the rods positive.
"""

import numpy as np

from loads import Angle, move, solve_forces, trace

from .machines import hammer, quick_return, slider_crank, toggle, toggle_height


def solved(
    linkage, coordinate, values, speed, given, solve, acceleration=0.0, pace=None, margin=1e-6
):
    """Motion and forces at values of a coordinate (rising), which sets the pace unless stated.

    margin  how far the path is followed beyond them
    """
    values = np.atleast_1d(np.asarray(values, dtype=float))
    path = trace(linkage, coordinate, values.min() - margin, values.max() + margin)
    motion = move(path.at(values), pace or coordinate, speed, 1, acceleration)
    return motion, solve_forces(motion, given, solve)


def _forces(solution, names):
    read = {}
    for name in names:
        read[f"{name}_x"], read[f"{name}_y"] = solution.joints[name].force.T
    return read


def _along(angle):
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _across(angle):
    return np.stack([-np.sin(angle), np.cos(angle)], axis=-1)


def _dot(a, b):
    return np.sum(a * b, axis=-1)


def toggle_of(p):
    """The toggle press of a case's parameters; no case has a mass at the knee."""
    assert p["m_B"] == 0.0
    return toggle(
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


def read_toggle(p, x):
    """Toggle press at distances x from the dead centre; the cylinder sets the pace."""
    linkage = toggle_of(p)
    cylinder = linkage.force("cylinder").coordinate
    motion, solution = solved(
        linkage,
        toggle_height(linkage),
        p["h"] - np.asarray(x),
        p["v_cyl"],
        {"cylinder": p["F_B"]},
        "process",
        pace=cylinder,
    )
    k, poses, rates = motion.kinematics, motion.poses, motion.velocities
    knee, reach = k.point(poses, "lower", "B"), k.span(poses, cylinder)
    bars = {name: _along(poses[:, row, 2]) for name, row in (("C", 1), ("A", 2))}
    forces = {name: load.force for name, load in solution.joints.items()}
    return {
        "gamma": np.arctan2(knee[:, 0], knee[:, 1]),
        "a": knee[:, 0],
        "BD": np.hypot(*reach.T),
        "alpha": np.arctan2(-reach[:, 1], reach[:, 0]),
        "v_B": np.hypot(*k.velocity(poses, rates, "lower", knee).T),
        "v_A": rates[:, 3, 1],
        "bar_omega": rates[:, 1, 2],
        "a_A": motion.accelerations[:, 3, 1],
        "F_A": solution.efforts["process"],
        **_forces(solution, "ABC"),
        "N_guide": forces["guide"][:, 0],
        "comp_lower": _dot(forces["C"], bars["C"]),
        "comp_upper": _dot(forces["A"], bars["A"]),
    }


def read_slider_crank(p, angles):
    """Slider-crank at crank angles [rad]; drive torque for the given force on the slider."""
    angles = np.atleast_1d(angles)
    assert not p["mu_pin"]
    linkage = slider_crank(
        p["R2"],
        p["R3"],
        p["yb"],
        {"mass": p["m2"], "inertia": p["I2"], "centre": (p["R2"] / 2, 0.0)},
        {"mass": p["m3"], "inertia": p["I3"], "centre": (p["R3"] / 2, 0.0)},
        p["m4"],
        (0.0, -p["g"]),
        p["mu"],
        at=angles[0],
    )
    motion, solution = solved(
        linkage, Angle("crank"), angles, p["omega"], {"push": p["Fp"]}, "drive", p["alpha"]
    )
    poses, rates, rises = motion.poses, motion.velocities, motion.accelerations
    rod = poses[:, 2, 2]
    centre = rises[:, 2, :2] + p["R3"] / 2 * (
        rises[:, 2, 2:] * _across(rod) - rates[:, 2, 2:] ** 2 * _along(rod)
    )
    return {
        "rod_angle": rod,
        "rod_omega": rates[:, 2, 2],
        "rod_alpha": rises[:, 2, 2],
        "slider_x": poses[:, 3, 0],
        "slider_v": rates[:, 3, 0],
        "slider_a": rises[:, 3, 0],
        "G3_ax": centre[:, 0],
        "G3_ay": centre[:, 1],
        **_forces(solution, "OAB"),
        "N_guide": solution.joints["guide"].force[:, 1],
        "drive_torque": solution.efforts["drive"],
        "rod_axial": -_dot(solution.joints["B"].force, _along(rod)),
    }


def read_hammer(p, angles):
    """Power hammer at crank angles [rad]; drive torque for a given force F up on the ram."""
    angles = np.atleast_1d(angles)
    motion, solution = solved(
        hammer(p, at=angles[0]),
        Angle("crank"),
        angles,
        p["omega"],
        {"work": p["F"]},
        "drive",
        p["alpha"],
    )
    poses, rates, rises = motion.poses, motion.velocities, motion.accelerations
    rod, rocker = poses[:, 2, 2], poses[:, 3, 2]
    on_rocker = -solution.joints["slot"].force
    return {
        "rod_angle": rod,
        "rocker_angle": rocker % (2 * np.pi),
        "slot_distance": -p["r"] / np.cos(rocker),
        "ram_height": poses[:, 4, 1],
        "ram_gap": p["hb"] - p["l5"] + poses[:, 4, 1] - p["l"] - p["hp"] + p["hc"],
        "rod_omega": rates[:, 2, 2],
        "rocker_omega": rates[:, 3, 2],
        "ram_velocity": rates[:, 4, 1],
        "rod_alpha": rises[:, 2, 2],
        "rocker_alpha": rises[:, 3, 2],
        "ram_acceleration": rises[:, 4, 1],
        **_forces(solution, "ABCR"),
        "D_x": on_rocker[:, 0],
        "D_y": on_rocker[:, 1],
        "R_force": np.hypot(*solution.joints["R"].force.T),
        # upwards across the rocker, which points to the left
        "D_normal": -_dot(on_rocker, _across(rocker)),
        "N_guide": solution.joints["guide"].force[:, 0],
        "drive_torque": solution.efforts["drive"],
        "rod_axial": -_dot(solution.joints["C"].force, _along(rod)),
    }


def read_quick_return(p, angles):
    """Quick return at crank angles [rad]; drive torque for a given force F up on the hammer."""
    angles = np.atleast_1d(angles)
    motion, solution = solved(
        quick_return(p, at=angles[0]),
        Angle("crank"),
        angles,
        p["omega"],
        {"work": p["F"]},
        "drive",
        p["alpha"],
    )
    poses, rates, rises = motion.poses, motion.velocities, motion.accelerations
    lever = poses[:, 3, 2]
    return {
        "lever_angle": lever,
        "lever_omega": rates[:, 3, 2],
        "lever_alpha": rises[:, 3, 2],
        "block_distance": _dot(poses[:, 2, :2], _along(lever)),
        "block_speed": _dot(rates[:, 2, :2], _along(lever)),
        "rod_beta": poses[:, 4, 2] + np.pi / 2,
        "rod_omega": rates[:, 4, 2],
        "rod_alpha": rises[:, 4, 2],
        "hammer_y": poses[:, 5, 1],
        "hammer_v": rates[:, 5, 1],
        "hammer_a": rises[:, 5, 1],
        "denominator": p["R"] * np.sin(lever) - poses[:, 5, 1],
        **_forces(solution, ["O1", "O2", "a", "B", "C"]),
        "Q_block": -_dot(solution.joints["slot"].force, _across(lever)),
        "N_guide": solution.joints["guide"].force[:, 0],
        "drive_torque": solution.efforts["drive"],
    }


READERS = {
    "toggle": read_toggle,
    "slider_crank": read_slider_crank,
    "hammer": read_hammer,
    "quick_return": read_quick_return,
}
