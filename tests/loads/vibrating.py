"""Linkages on a carrier that is held: whatever stands on it vibrates as on the ground."""

from dataclasses import replace
from math import atan2, cos, sin

import numpy as np

from loads import (
    GROUND,
    Body,
    Cycle,
    Fixed,
    Force,
    JointCompliance,
    Linkage,
    Phase,
    PointCoordinate,
    Prismatic,
    SteadyPace,
    StrokePace,
    move,
    run_cycle,
    trace,
)
from loads.vibration import linkage_modes


def on_carrier(bodies, joints, compliance, places, turn=0.0, carrier_points=None, gravity=0.0):
    """Carrier that slides along x (turned), and bodies welded or pinned to it at `places`."""
    along = (cos(turn), sin(turn))

    def placed(place):
        x, y, angle = place
        return (along[0] * x - along[1] * y, along[1] * x + along[0] * y, angle + turn)

    return Linkage(
        bodies=(
            Body(GROUND, {"O": (0.0, 0.0)}),
            Body("carrier", {"O": (0.0, 0.0), **(carrier_points or {})}, mass=1.0),
            *bodies,
        ),
        joints=(Prismatic("rail", GROUND, "carrier", "O", "O", along), *joints),
        forces=(Force("drive", PointCoordinate("carrier", "O", along)),),
        assembled={
            "carrier": (0.0, 0.0, atan2(along[1], along[0])),
            **{name: placed(place) for name, place in places.items()},
        },
        gravity=(0.0, -gravity),
        compliance=compliance,
    )


def frequencies(linkage, hold=None):
    """All its frequencies in Hz where it is assembled, and the modes."""
    held = linkage.force("drive").coordinate if hold is None else hold
    start = 0.0 if hold is None else next(iter(linkage.assembled.values()))[2]
    geometry = trace(linkage, held, start - 1e-3, start + 1e-3).at(np.array([start]))
    modes = linkage_modes(move(geometry, held, 1.0, 1), held)
    return modes.frequencies[0], modes


def springs(masses, stiffnesses, turn=0.0):
    """Masses one after another on springs: welds that give way along x and y alike."""
    names = [f"mass {k}" for k in range(len(masses))]
    bodies = [Body(name, {"O": (0.0, 0.0)}, mass) for name, mass in zip(names, masses, strict=True)]
    before = ["carrier", *names[:-1]]
    joints = [
        Fixed(f"spring {k}", one, two, "O")
        for k, (one, two) in enumerate(zip(before, names, strict=True))
    ]
    soft = tuple(JointCompliance(f"spring {k}", value) for k, value in enumerate(stiffnesses))
    return on_carrier(bodies, joints, soft, {name: (0.0, 0.0, 0.0) for name in names}, turn)


def shaken(mass, stiffness, stroke, time, forces=("drive",)):
    """A mass on a spring whose foot goes to and fro as a cosine: one harmonic, 2 `time` long.

    forces  all along the foot's way; those besides the drive are of 7 N
    """
    linkage = springs([mass], [stiffness])
    foot = linkage.force("drive").coordinate
    linkage = replace(linkage, forces=tuple(Force(name, foot) for name in forces))
    given = {name: 7.0 for name in forces if name != "drive"}
    phases = (Phase("out", stroke, given, "drive"), Phase("back", 0.0, given, "drive"))
    pace = StrokePace(foot, "harmonic", time)
    return run_cycle(linkage, Cycle("shaken", foot, 0.0, pace, phases, 4000))


def once_along(linkage):
    """A cycle that does not come back."""
    foot = linkage.force("drive").coordinate
    phase = Phase("out", 1.0, {}, "drive")
    return run_cycle(linkage, Cycle("out", foot, 0.0, SteadyPace(foot, 1.0), (phase,), 20))
