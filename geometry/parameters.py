"""Parameters of a parametric part: plain dataclass fields that know their dimension and meaning.

A part's parameters are the fields of a frozen dataclass, in mm inside the code. Their metadata is
what the design file's door, its JSON schema and the documentation of the parts are made from, so a
parameter is described once, beside the geometry that uses it.
"""

from dataclasses import MISSING, field
from typing import Any

GIVEN_BY_LINKAGE = "linkage"
GIVEN_BY_DESIGN = "design"


class ParameterError(ValueError):
    """A parameter with which the part cannot be built: which field, and why."""

    def __init__(self, field: str, problem: str) -> None:
        super().__init__(field, problem)
        self.field, self.problem = field, problem

    def __str__(self) -> str:
        return f"{self.field}: {self.problem}"


def a_length(meaning: str, *, default: Any = MISSING, given_by: str = GIVEN_BY_DESIGN) -> Any:
    """Declare a length in mm; `default` makes it optional, `given_by` says who fills it in.

    `given_by="linkage"` is a length that follows from the mechanism (the distance between two
    pins): the design file must not state it a second time.
    """
    return field(
        default=default,
        kw_only=True,
        metadata={"dimension": "length", "meaning": meaning, "given_by": given_by},
    )


def check_above(field: str, value: float, limit: float, unit: str = "mm") -> None:
    """Raise ParameterError unless the value is above the limit."""
    if not value > limit:
        raise ParameterError(field, f"must be above {limit:g} {unit}, got {value:g} {unit}")


def check_at_least(field: str, value: float, limit: float, unit: str = "mm") -> None:
    """Raise ParameterError unless the value is at least the limit."""
    if not value >= limit:
        raise ParameterError(field, f"must be at least {limit:g} {unit}, got {value:g} {unit}")


def check_square_tube(length: float, width: float, wall: float, inner_radius: float) -> None:
    """Raise ParameterError unless a square tube of these sizes, mm, is hollow and has walls."""
    check_above("length", length, 0)
    check_above("width", width, 0)
    check_above("wall", wall, 0)
    if wall >= width / 2:
        raise ParameterError(
            "wall",
            f"{wall:g} mm is too thick: two walls fill the width of {width:g} mm; "
            f"it must be below {width / 2:g} mm",
        )
    check_at_least("inner_radius", inner_radius, 0)
    if inner_radius >= width / 2 - wall:
        raise ParameterError(
            "inner_radius",
            f"{inner_radius:g} mm is too large for the opening of {width - 2 * wall:g} mm; "
            f"it must be below {width / 2 - wall:g} mm",
        )
