"""Elastic machines that several tests press: the spring hammer and the toggle."""

from dataclasses import replace

import numpy as np

from loads import (
    Angle,
    BeamCompliance,
    Contact,
    Cycle,
    JointCompliance,
    Phase,
    SteadyPace,
    run_cycle,
)

from .machine_hammer import HAMMER, hammer
from .machines import toggle

PACK = 3 * 210e9 * 0.06 * 0.0096**3 / 12  # N m2, three free leaves of 60 x 9.6 mm
FLOOR = 1.1135  # m, height of the ram's pin on the bare anvil


def forged(speed=5.0, height=0.01, pack=PACK, parameters=HAMMER, stops=True, positions=721):
    linkage = replace(hammer(parameters), compliance=(BeamCompliance("rocker", bending=pack),))
    crank = Angle("crank")
    work = Contact(FLOOR + height, stops=stops)
    phase = Phase("turn", 2 * np.pi, {"work": work}, "drive")
    return run_cycle(
        linkage, Cycle("turn", crank, 0.0, SteadyPace(crank, speed), (phase,), positions)
    )


def tip_stiffness(x):
    """N/m at a distance x from the pivot of a beam on two supports 0.46 m apart (E I = PACK)."""
    return 3 * PACK / (x**2 * (x + 0.46))


def weightless():
    return toggle(m_bar=0.0, m_mould=0.0, i_bar=0.0)


def pressed(linkage, contact, to=95.0, positions=400):
    """Knee from 10 degrees before its dead centre through it, led by the lower bar's angle."""
    knee = Angle("lower")
    phase = Phase("close", np.radians(to), {"process": contact}, "cylinder")
    return run_cycle(
        linkage,
        Cycle("press", knee, np.radians(80.0), SteadyPace(knee, 0.01), (phase,), positions),
    )


STEEL = {"axial": 210e3 * 1857.0}  # E A of a tube 80 x 80 x 6.3


def elastic(**changes):
    return replace(
        toggle(m_bar=0.0, m_mould=0.0, i_bar=0.0, **changes),
        compliance=(
            BeamCompliance("lower", **STEEL),
            BeamCompliance("upper", **STEEL),
            JointCompliance("C", 400e3),
        ),
    )
