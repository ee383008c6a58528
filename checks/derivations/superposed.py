"""The stress at a point of a part as the sum of its unit loads."""

from collections.abc import Sequence

import numpy as np

from checks.models.formula_points import columns_of
from checks.part.part_loads import PartLoads
from checks.result.derivation import Superposition, UnitLoad
from checks.stress.part_model import RungLevel, UnitName
from checks.stress.solid_mesh_level import Level
from checks.stress.stress_result import Stressed

PATTERNS = (
    "cos n and sin n of a bore or journal: a pressure that goes round it as cos nθ or sin nθ; "
    "n = 1 carries the force, the others have no resultant, and together they are the half-cosine "
    "pressure of a pin (docs/theory/bearing.md). Unit loads that add nothing here are left out"
)
CONTACT = (
    "contact cos n and contact sin n are in the same way the long waves of the pressure of a pin "
    "whose fit is stated, as its contact was solved; a short wave is what of it no element "
    "follows, and makes stress at the bore only (docs/theory/contact.md)"
)


def units_of(level: Stressed) -> Sequence[UnitName]:
    """Name of each unit load of a level with where it acts, and the unit of its coefficient."""
    if isinstance(level, RungLevel):
        return level.model.units
    if isinstance(level, Level):
        own = [(unit.interface.name, unit.names) for unit in level.solutions.interfaces]
        return columns_of(own)
    raise TypeError(f"the unit loads of a {type(level).__name__} have no names")


def patterns_of(level: Stressed) -> str:
    """Meaning of the names of a level's unit loads."""
    solved = isinstance(level, Level) and level.contact is not None
    return f"{PATTERNS}. {CONTACT}" if solved else PATTERNS


def superposed(
    level: Stressed, loads: PartLoads, point: int, position: int, symbol: str
) -> Superposition:
    """The stress at a point of a level at one of all positions, unit load by unit load."""
    basis = level.history.basis[point]
    coefficients = level.coefficients[:, position]
    acts = np.flatnonzero((basis * coefficients).any(axis=0))
    names = units_of(level)
    return Superposition(
        symbol,
        f"stress at {level.place(point)}",
        f"{loads.cycle_names[position]}, {loads.labels[position]}",
        tuple(
            UnitLoad(
                names[k][0],
                names[k][1],
                float(coefficients[k]),
                tuple(float(one) for one in basis[:, k]),
            )
            for k in acts.tolist()
        ),
        _source(level),
    )


def _source(level: Stressed) -> str:
    if isinstance(level, Level):
        body = "half of the part" if level.half else "the part"
        return f"solved on a mesh of {body} with {level.unknowns} unknowns"
    assert isinstance(level, RungLevel)
    rung, unknowns = level.model.rung, level.model.unknowns
    if rung == "formula":
        return "handbook stress of the place per unit: docs/theory/rungs.md"
    return f"solved by the rung {rung} with {unknowns} unknowns: docs/theory/rungs_{rung}.md"
