"""Screws: coarse pitches of ISO 261, and yield stresses by the designation of ISO 898-1.

A class a.b has the nominal tensile strength 100 a and the nominal yield stress 10 a b, MPa; the
least ones of ISO 898-1 are at or above it.
"""

from typing import Literal

ScrewSize = Literal["M6", "M8", "M10", "M12", "M14", "M16", "M18", "M20", "M22", "M24"]
PropertyClass = Literal["8.8", "10.9", "12.9"]
COARSE_PITCH: dict[ScrewSize, float] = {
    "M6": 1.0, "M8": 1.25, "M10": 1.5, "M12": 1.75, "M14": 2.0,
    "M16": 2.0, "M18": 2.5, "M20": 2.5, "M22": 2.5, "M24": 3.0,
}  # fmt: skip


def yield_stress_of(name: PropertyClass) -> float:
    """Nominal yield stress of a property class, MPa.

    >>> yield_stress_of("10.9")
    900.0
    """
    tensile, share = map(float, name.split("."))
    return 10.0 * tensile * share
