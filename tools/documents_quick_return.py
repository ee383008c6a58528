"""The quick-return hammer: the draft's formulae as printed against ballesta, over one turn.

In the letters of the draft: theta, w1 and a1 of the lever, y of the hammer, beta of the rod from
the vertical, A = D sin theta - y cos theta, B = D cos theta + y sin theta, N = R sin theta - y.
"""

from types import SimpleNamespace

import numpy as np
from documents_designs import Floats, run

R, K, D = 200.0, 70.0, 170.0
FINE = ("cycles.at_4.positions=2161",)


def _turn() -> SimpleNamespace:
    turn = run("quick_return", "at_4", FINE)
    lever, rod, hammer = (turn.body_index(name) for name in ("lever", "rod", "hammer"))
    theta, y = turn.poses[:, lever, 2], turn.poses[:, hammer, 1]
    return SimpleNamespace(
        cos=np.cos(theta),
        sin=np.sin(theta),
        w=turn.velocities[:, lever, 2],
        a=turn.accelerations[:, lever, 2],
        y=y,
        speed=turn.velocities[:, hammer, 1],
        acceleration=turn.accelerations[:, hammer, 1],
        A=D * np.sin(theta) - y * np.cos(theta),
        B=D * np.cos(theta) + y * np.sin(theta),
        N=R * np.sin(theta) - y,
        beta=turn.poses[:, rod, 2] + np.pi / 2,
        rod_speed=turn.velocities[:, rod, 2],
        rod_acceleration=turn.accelerations[:, rod, 2],
    )


def hammer_speed() -> tuple[Floats, Floats]:
    """Return the speed of the hammer by (11) and ballesta's [m/s]."""
    t = _turn()
    return R * t.w * t.A / t.N / 1e3, t.speed / 1e3


def hammer_acceleration() -> tuple[Floats, Floats]:
    """Return the acceleration of the hammer by (12) and ballesta's [m/s2]."""
    t = _turn()
    # right: + w^2 B and - speed in the last bracket
    first = (t.a * t.A - t.w**2 * t.B - t.w * t.speed * t.cos) * t.N
    found = R * (first - t.w * t.A * (R * t.w * t.cos + t.speed)) / t.N**2
    return found / 1e3, t.acceleration / 1e3


def hammer_acceleration_simplified() -> tuple[Floats, Floats]:
    """Return the acceleration of the hammer by (14) and ballesta's [m/s2]."""
    t = _turn()
    # right: + w^2 B, + the last term, and - R^2 w^2 cos theta A / N^2
    found = R * (t.a * t.A - t.w**2 * t.B) / t.N
    found -= R * t.w * t.speed * (D - R * t.cos) * t.sin / t.N**2
    return found / 1e3, t.acceleration / 1e3


def rod_speed() -> tuple[Floats, Floats]:
    """Return the speed of the rod by (16) and (17), and ballesta's [rad/s]."""
    t = _turn()
    return -t.w * R * t.sin / (K * np.cos(t.beta)), t.rod_speed


def rod_acceleration() -> tuple[Floats, Floats]:
    """Return the angular acceleration of the rod by (20) and ballesta's [rad/s2]."""
    t = _turn()
    # right: + the last term
    top = t.a * R * t.sin + t.w**2 * R * t.cos - t.rod_speed**2 * K * np.sin(t.beta)
    return top / (K * np.cos(t.beta)), t.rod_acceleration
