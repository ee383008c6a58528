"""The offset slider-crank: what ballesta finds, and formulae as the thesis prints them."""

import numpy as np
from documents_designs import Floats, run

import loads

FINE = ("cycles.bench.positions=1441",)
NO_WEIGHT = ("gravity=0, 0 m/s2", *FINE)
RADIUS, ROD = 100.0, 150.0


def _bench(overrides: tuple[str, ...] = FINE) -> loads.CycleLoads:
    return run("slider_crank", "bench", overrides)


def _row(values: Floats) -> list[float]:
    return [float(values.min()), float(values.max())]


def rod_speed() -> list[float]:
    """Return the range of the rod's speed [deg/s] at 1 rad/s."""
    turn = _bench()
    return _row(np.degrees(turn.velocities[:, turn.body_index("rod"), 2]))


def rod_acceleration() -> list[float]:
    """Return the range of the rod's angular acceleration [deg/s2] at 1 rad/s."""
    turn = _bench()
    return _row(np.degrees(turn.accelerations[:, turn.body_index("rod"), 2]))


def slider_speed() -> float:
    """Return the largest speed of the slider [mm/s] at 1 rad/s."""
    turn = _bench()
    return float(np.abs(turn.velocities[:, turn.body_index("slider"), 0]).max())


def slider_speeds() -> tuple[Floats, Floats]:
    """Return the speed of the slider by (2.26), w x (w x r), and ballesta's [mm/s], over a turn."""
    turn = _bench()
    rod = turn.velocities[:, turn.body_index("rod"), 2]
    return rod**2 * ROD, np.abs(turn.velocities[:, turn.body_index("slider"), 0])


def crank_centres() -> tuple[Floats, Floats]:
    """Return the acceleration of the crank's centre along x by (2.39), and ballesta's [mm/s2]."""
    turn = _bench()
    return RADIUS * np.cos(turn.positions), _centre(turn, "crank", RADIUS / 2)[:, 0]


def rod_centres() -> tuple[Floats, Floats]:
    """Return the acceleration of the rod's centre (n, 2) by (2.40), and ballesta's [mm/s2]."""
    turn = _bench()
    angle = turn.poses[:, turn.body_index("rod"), 2]
    return RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1), _centre(turn, "rod", ROD / 2)


def _centre(turn: loads.CycleLoads, body: str, way: float) -> Floats:
    """Return the acceleration (n, 2) of the point `way` along a body's own x axis [mm/s2]."""
    row = turn.body_index(body)
    angle, spin = turn.poses[:, row, 2], turn.velocities[:, row, 2]
    bend = turn.accelerations[:, row, 2]
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    found: Floats = turn.accelerations[:, row, :2] + way * (
        bend[:, None] * across - (spin**2)[:, None] * along
    )
    return found


def torques() -> tuple[Floats, Floats]:
    """Return the crank's torque at 1 rad/s [N mm] without the weights, and ballesta's with them."""
    return _bench(NO_WEIGHT).efforts["drive"], _bench().efforts["drive"]
