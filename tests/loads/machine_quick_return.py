"""A quick-return hammer: a crank's block slides along a lever, which lifts a hammer by a rod."""

from math import atan2, cos, sin, sqrt

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
)

# SI. r crank about (d, 0), R lever about the origin, K rod down to the hammer on the line x = D;
# lam and c2 from the pivots to the centres of lever and crank, inertias about the centres
QUICK_RETURN = {
    "r": 0.07,
    "d": 0.11,
    "R": 0.2,
    "K": 0.07,
    "D": 0.17,
    "lam": 0.1093458,
    "g": 9.81,
    "m1": 0.35529,
    "I1": 0.0020765,
    "m2": 0.11,
    "I2": 9e-05,
    "c2": 0.035,
    "mb": 0.05,
    "m3": 0.06,
    "I3": 2.45e-05,
    "m4": 0.8,
    "mu_slot": 0.0,
    "mu_guide": 0.0,
    "mu_pin": 0.0,
    "r_pin": 0.0,
}


def quick_return(parameters=QUICK_RETURN, at=0.0, ends=None, gravity=None):
    """Quick return at a crank angle: torque drive on the crank, force work on the hammer (up).

    Frames: crank at O2, block at the crank's pin a and lever at O1 along the lever, rod at B
    towards C. The block does not turn on the lever and turns without friction on the crank;
    ``ends`` of its slot, from O1.
    """
    p = parameters
    pin = (p["d"] + p["r"] * cos(at), p["r"] * sin(at))
    lever = atan2(pin[1], pin[0])
    end = (p["R"] * cos(lever), p["R"] * sin(lever))
    drop = sqrt(p["K"] ** 2 - (end[0] - p["D"]) ** 2)
    hammer = (p["D"], end[1] - drop)
    rod = atan2(-drop, p["D"] - end[0])
    return Linkage(
        bodies=(
            Body(GROUND, {"O1": (0.0, 0.0), "O2": (p["d"], 0.0), "line": (p["D"], 0.0)}),
            Body("crank", {"O2": (0.0, 0.0), "a": (p["r"], 0.0)}, p["m2"], p["I2"], (p["c2"], 0.0)),
            Body("block", {"a": (0.0, 0.0)}, p["mb"]),
            Body(
                "lever", {"O1": (0.0, 0.0), "B": (p["R"], 0.0)}, p["m1"], p["I1"], (p["lam"], 0.0)
            ),
            Body("rod", {"B": (0.0, 0.0), "C": (p["K"], 0.0)}, p["m3"], p["I3"], (p["K"] / 2, 0.0)),
            Body("hammer", {"C": (0.0, 0.0)}, p["m4"]),
        ),
        joints=(
            Revolute("O2", GROUND, "crank", "O2"),
            Revolute("a", "crank", "block", "a"),
            Prismatic("slot", "lever", "block", "O1", "a", (1.0, 0.0), ends),
            Revolute("O1", GROUND, "lever", "O1"),
            Revolute("B", "lever", "rod", "B"),
            Revolute("C", "rod", "hammer", "C"),
            Prismatic("guide", GROUND, "hammer", "line", "C", (0.0, 1.0)),
        ),
        forces=(
            Force("drive", Angle("crank", point="O2")),
            Force("work", PointCoordinate("hammer", "C", (0.0, 1.0))),
        ),
        assembled={
            "crank": (p["d"], 0.0, at),
            "block": (*pin, lever),
            "lever": (0.0, 0.0, lever),
            "rod": (*end, rod),
            "hammer": (*hammer, 0.0),
        },
        friction={
            **{name: Friction(p["mu_pin"], p["r_pin"]) for name in ("O1", "O2", "B", "C")},
            "slot": Friction(p["mu_slot"]),
            "guide": Friction(p["mu_guide"]),
        },
        gravity=(0.0, -p["g"]) if gravity is None else gravity,
    )
