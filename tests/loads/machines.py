"""Linkages that several tests use. Units follow the arguments."""

from math import acos, atan2, cos, hypot, pi, sin, sqrt

from loads import (
    GROUND,
    Angle,
    Body,
    Cycle,
    Distance,
    Force,
    Friction,
    Linkage,
    Phase,
    PointCoordinate,
    Prismatic,
    Revolute,
    SteadyPace,
)

from .machine_hammer import HAMMER, hammer
from .machine_quick_return import QUICK_RETURN, quick_return

__all__ = [
    "HAMMER",
    "QUICK_RETURN",
    "at_state",
    "four_bar",
    "hammer",
    "parallel_four_bars",
    "press_cycle",
    "quick_return",
    "slider_crank",
    "toggle",
    "toggle_height",
]


def toggle(
    h=500.0,
    base=350.0,
    m_bar=4.14134e-3,
    m_mould=1e-2,
    i_bar=21.56947917,
    g=9810.0,
    mu_pin=0.0,
    r_pin=20.0,
    mu_guide=0.0,
    turn=0.0,
    mirror=1,
    opening=None,
):
    """Toggle press; turned by an angle about the ground's origin, mirrored at its y axis by -1."""
    x = 0.4 * h if opening is None else opening

    def place(px, py):
        px *= mirror
        return (px * cos(turn) - py * sin(turn), px * sin(turn) + py * cos(turn))

    bar = h / 2
    offset = sqrt(bar**2 - ((h - x) / 2) ** 2)
    c, b, a, d = (0.0, 0.0), (offset, (h - x) / 2), (0.0, h - x), (-base, h / 2)
    c, b, a, d = place(*c), place(*b), place(*a), place(*d)
    up = place(0.0, 1.0)
    bars = {"mass": m_bar, "inertia": i_bar, "centre": (bar / 2, 0.0)}
    return Linkage(
        bodies=(
            Body(GROUND, {"C": c, "D": d, "O": c}),
            Body("lower", {"C": (0.0, 0.0), "B": (bar, 0.0)}, **bars),
            Body("upper", {"B": (0.0, 0.0), "A": (bar, 0.0)}, **bars),
            Body("mould", {"A": (0.0, 0.0)}, mass=m_mould),
        ),
        joints=(
            Revolute("C", GROUND, "lower", "C"),
            Revolute("B", "lower", "upper", "B"),
            Revolute("A", "upper", "mould", "A"),
            Prismatic("guide", GROUND, "mould", "O", "A", up),
        ),
        forces=(
            Force("cylinder", Distance(GROUND, "D", "lower", "B"), -1),
            Force("process", PointCoordinate("mould", "A", (-up[0], -up[1]))),
        ),
        assembled={
            "lower": (*c, atan2(b[1] - c[1], b[0] - c[0])),
            "upper": (*b, atan2(a[1] - b[1], a[0] - b[0])),
            "mould": (*a, 0.0),
        },
        friction={
            "C": Friction(mu_pin, r_pin),
            "B": Friction(mu_pin, r_pin),
            "A": Friction(mu_pin, r_pin),
            "guide": Friction(mu_guide),
        },
        gravity=place(0.0, -g),
    )


def toggle_height(linkage):
    """The coordinate A.y of the (turned) toggle."""
    x, y = linkage.force("process").coordinate.direction
    return PointCoordinate("mould", "A", (-x, -y))


def press_cycle(linkage, h=500.0, speed=100.0, pull=11000.0, n_positions=361, last=2.0):
    """Close to x = last under no load, then press, then open; lengths follow h."""
    k = h / 500.0
    return Cycle(
        "press",
        toggle_height(linkage),
        start=300.0 * k,
        pace=SteadyPace(linkage.force("cylinder").coordinate, speed),
        phases=(
            Phase("approach", 493.0 * k, {"process": 0.0}, "cylinder"),
            Phase("press", h - last * k, {"cylinder": pull}, "process"),
            Phase("return", 300.0 * k, {"process": 0.0}, "cylinder"),
        ),
        n_positions=n_positions,
    )


def slider_crank(
    crank,
    rod,
    offset=0.0,
    crank_body=None,
    rod_body=None,
    slider_mass=0.0,
    gravity=(0.0, 0.0),
    mu_slider=0.0,
    at=0.0,
):
    """Crank from O at the origin, rod, slider on y = offset; torque drive, force push (+x)."""
    a = (crank * cos(at), crank * sin(at))
    reach = sqrt(rod**2 - (offset - a[1]) ** 2)
    return Linkage(
        bodies=(
            Body(GROUND, {"O": (0.0, 0.0), "rail": (0.0, offset)}),
            Body("crank", {"O": (0.0, 0.0), "A": (crank, 0.0)}, **(crank_body or {})),
            Body("rod", {"A": (0.0, 0.0), "B": (rod, 0.0)}, **(rod_body or {})),
            Body("slider", {"B": (0.0, 0.0)}, mass=slider_mass),
        ),
        joints=(
            Revolute("O", GROUND, "crank", "O"),
            Revolute("A", "crank", "rod", "A"),
            Revolute("B", "rod", "slider", "B"),
            Prismatic("guide", GROUND, "slider", "rail", "B", (1.0, 0.0)),
        ),
        forces=(
            Force("drive", Angle("crank", point="O")),
            Force("push", PointCoordinate("slider", "B", (1.0, 0.0))),
        ),
        assembled={
            "crank": (0.0, 0.0, at),
            "rod": (*a, atan2(offset - a[1], reach)),
            "slider": (a[0] + reach, offset, 0.0),
        },
        friction={"guide": Friction(mu_slider)},
        gravity=gravity,
    )


def four_bar(crank, coupler, rocker, ground, masses=None, at=2 * pi / 9, side=1):
    """Pivots at (0, 0) and (ground, 0); side 1 is the open branch. Torques drive and load."""
    a = (crank * cos(at), crank * sin(at))
    gap = hypot(ground - a[0], a[1])
    along = atan2(-a[1], ground - a[0])

    lift = acos((coupler**2 + gap**2 - rocker**2) / (2 * coupler * gap))
    theta3 = along + side * lift
    b = (a[0] + coupler * cos(theta3), a[1] + coupler * sin(theta3))
    masses = masses or {}

    def bar(name, first, second, length):
        mass, inertia = masses.get(name, (0.0, 0.0))
        points = {first: (0.0, 0.0), second: (length, 0.0)}
        return Body(name, points, mass, inertia, (length / 2, 0.0))

    return Linkage(
        bodies=(
            Body(GROUND, {"O2": (0.0, 0.0), "O4": (ground, 0.0)}),
            bar("crank", "O2", "A", crank),
            bar("coupler", "A", "B", coupler),
            bar("rocker", "O4", "B", rocker),
        ),
        joints=(
            Revolute("O2", GROUND, "crank", "O2"),
            Revolute("A", "coupler", "crank", "A"),
            Revolute("B", "rocker", "coupler", "B"),
            Revolute("O4", GROUND, "rocker", "O4"),
        ),
        forces=(
            Force("drive", Angle("crank", point="O2")),
            Force("load", Angle("rocker", point="O4")),
        ),
        assembled={
            "crank": (0.0, 0.0, at),
            "coupler": (*a, theta3),
            "rocker": (ground, 0.0, atan2(b[1], b[0] - ground)),
        },
        gravity=(0.0, 0.0),
    )


def parallel_four_bars(n, at, length=1000.0, mass=1e-3, g=9810.0):
    """Return n parallelograms side by side, cranks as long as couplers and as the ground between.

    Neighbours share a crank: cranks C0 ... Cn from A0 ... An, couplers from B0 to B1 and so on.
    """
    bars = {"mass": mass, "inertia": mass * length**2 / 12, "centre": (length / 2, 0.0)}
    cranks = [
        Body(f"C{k}", {f"A{k}": (0.0, 0.0), f"B{k}": (length, 0.0)}, **bars) for k in range(n + 1)
    ]
    couplers = [
        Body(f"D{k}", {f"B{k}": (0.0, 0.0), f"B{k + 1}": (length, 0.0)}, **bars) for k in range(n)
    ]
    b = [(k * length + length * cos(at), length * sin(at)) for k in range(n)]
    return Linkage(
        bodies=(
            Body(GROUND, {f"A{k}": (k * length, 0.0) for k in range(n + 1)}),
            *cranks,
            *couplers,
        ),
        joints=(
            *(Revolute(f"A{k}", GROUND, f"C{k}", f"A{k}") for k in range(n + 1)),
            *(Revolute(f"B{k}", f"C{k}", f"D{k}", f"B{k}") for k in range(n)),
            *(Revolute(f"E{k}", f"D{k - 1}", f"C{k}", f"B{k}") for k in range(1, n + 1)),
        ),
        forces=(Force("drive", Angle("C0", point="A0")),),
        assembled={f"C{k}": (k * length, 0.0, at) for k in range(n + 1)}
        | {f"D{k}": (*b[k], 0.0) for k in range(n)},
        gravity=(0.0, -g),
    )


def at_state(linkage, coordinate, value, speed, acceleration=0.0, pace=None, direction=1):
    """Motion of a linkage at one value of a coordinate."""
    import numpy as np

    from loads import move, trace

    path = trace(linkage, coordinate, value - 1e-3, value + 1e-3)
    geometry = path.at(np.array([value]))
    return move(geometry, pace or coordinate, speed, direction, acceleration)
