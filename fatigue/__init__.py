"""How long a part lasts: Goodman on the stress path of each point, endurance limits by Marin."""

from fatigue.goodman import ChordPath, FatigueResult, chord_path, goodman, goodman_utilisation
from fatigue.marin import (
    EnduranceLimit,
    endurance_limit,
    rectangle_equivalent_diameter,
    round_equivalent_diameter,
)
from fatigue.stress_path import (
    COMPONENTS,
    principal_extremes,
    principal_stresses,
    von_mises,
    von_mises_peaks,
)

__all__ = [
    "COMPONENTS",
    "ChordPath",
    "EnduranceLimit",
    "FatigueResult",
    "chord_path",
    "endurance_limit",
    "goodman",
    "goodman_utilisation",
    "principal_extremes",
    "principal_stresses",
    "rectangle_equivalent_diameter",
    "round_equivalent_diameter",
    "von_mises",
    "von_mises_peaks",
]
