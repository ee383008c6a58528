"""A power hammer: crank, rod and rocker lift a ram whose pin slides along the rocker's line."""

from math import acos, atan2, cos, hypot, sin, tan

from loads import (
    GROUND,
    Angle,
    Body,
    Force,
    Friction,
    Linkage,
    PointCoordinate,
    Prismatic,
    Revolute,
    Slot,
)

# SI. l1 crank, l2 rod, l3 rocker from pivot R to rod, R at (-d, l), ram line at x = -d - r;
# I1 about the crank's axis, I2 about the rod's middle, I3R about R, where the rocker's weight acts
HAMMER = {
    "l1": 0.135,
    "l2": 1.275,
    "l3": 0.46,
    "d": 0.202,
    "l": 1.25,
    "r": 0.427,
    "m1": 26.0,
    "m2": 1.467,
    "m3": 14.623,
    "m4": 39.85,
    "I1": 0.293,
    "I2": 0.224,
    "I3R": 0.995,
    "g": 9.8,
    "mu_guide": 0.0,
    "mu_slot": 0.0,
    "mu_pin": 0.0,
    "r_pin": 0.0,
}


def hammer(parameters=HAMMER, at=0.0, gravity=None):
    """Hammer at a crank angle: torque drive on the crank, force work on the ram (up).

    Frames: crank at A, rod at B towards C, rocker at R with x from C to R and on to the ram's D.
    """
    p = parameters
    crank_pin = (p["l1"] * cos(at), p["l1"] * sin(at))
    pivot = (-p["d"], p["l"])
    along = atan2(pivot[1] - crank_pin[1], pivot[0] - crank_pin[0])
    gap = hypot(pivot[0] - crank_pin[0], pivot[1] - crank_pin[1])
    rod = along - acos((gap**2 + p["l2"] ** 2 - p["l3"] ** 2) / (2 * gap * p["l2"]))
    end = (crank_pin[0] + p["l2"] * cos(rod), crank_pin[1] + p["l2"] * sin(rod))
    rocker = atan2(pivot[1] - end[1], pivot[0] - end[0])
    ram = (-p["d"] - p["r"], p["l"] - p["r"] * tan(rocker))
    return Linkage(
        bodies=(
            Body(GROUND, {"A": (0.0, 0.0), "R": pivot, "line": (ram[0], p["l"])}),
            Body("crank", {"A": (0.0, 0.0), "B": (p["l1"], 0.0)}, p["m1"], p["I1"]),
            Body(
                "rod", {"B": (0.0, 0.0), "C": (p["l2"], 0.0)}, p["m2"], p["I2"], (p["l2"] / 2, 0.0)
            ),
            Body("rocker", {"R": (0.0, 0.0), "C": (-p["l3"], 0.0)}, p["m3"], p["I3R"]),
            Body("ram", {"D": (0.0, 0.0)}, p["m4"]),
        ),
        joints=(
            Revolute("A", GROUND, "crank", "A"),
            Revolute("B", "crank", "rod", "B"),
            Revolute("C", "rod", "rocker", "C"),
            Revolute("R", GROUND, "rocker", "R"),
            Slot("slot", "rocker", "ram", "R", "D", (1.0, 0.0)),
            Prismatic("guide", GROUND, "ram", "line", "D", (0.0, 1.0)),
        ),
        forces=(
            Force("drive", Angle("crank", point="A")),
            Force("work", PointCoordinate("ram", "D", (0.0, 1.0))),
        ),
        assembled={
            "crank": (0.0, 0.0, at),
            "rod": (*crank_pin, rod),
            "rocker": (*pivot, rocker),
            "ram": (*ram, 0.0),
        },
        friction={
            **{name: Friction(p["mu_pin"], p["r_pin"]) for name in "ABCR"},
            "slot": Friction(p["mu_slot"]),
            "guide": Friction(p["mu_guide"]),
        },
        gravity=(0.0, -p["g"]) if gravity is None else gravity,
    )
