"""Parameters of a parametric part, fields that know their dimension and meaning; bounded files.

A part's parameters are the fields of a frozen dataclass, in mm inside the code. Their metadata is
what the design file's door, its JSON schema and the documentation of the parts are made from, so a
parameter is described once, beside the geometry that uses it.
"""

import errno
import stat
from dataclasses import MISSING, field
from pathlib import Path
from typing import Any

GIVEN_BY_LINKAGE = "linkage"
GIVEN_BY_DESIGN = "design"
ROUND_OFF = 1e-10  # of a length in another unit, written with 12 digits, or summed up


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


def a_force(meaning: str, *, default: Any = MISSING) -> Any:
    """Declare a force in N; `default` makes it optional."""
    return _of_design("force", meaning, default)


def a_number(meaning: str, *, default: Any = MISSING) -> Any:
    """Declare a plain number, without a unit; `default` makes it optional."""
    return _of_design("number", meaning, default)


def a_count(meaning: str, *, default: Any = MISSING) -> Any:
    """Declare a whole number; `default` makes it optional."""
    return _of_design("count", meaning, default)


def a_flag(meaning: str) -> Any:
    """Declare something that is so or not, and is not so unless it is stated."""
    return _of_design("flag", meaning, False)


def _of_design(dimension: str, meaning: str, default: Any) -> Any:
    return field(
        default=default,
        kw_only=True,
        metadata={"dimension": dimension, "meaning": meaning, "given_by": GIVEN_BY_DESIGN},
    )


def within(value: float, limit: float) -> bool:
    """Return True if a value is at most a limit, which it may pass by the round-off of its unit.

    >>> within(448.50000000000006, 448.5), within(448.5001, 448.5)
    (True, False)
    """
    return value <= limit + ROUND_OFF * max(abs(value), abs(limit))


def check_above(field: str, value: float, limit: float, unit: str = "mm") -> None:
    """Raise ParameterError unless the value is above the limit."""
    if not value > limit:
        raise ParameterError(field, f"must be above {limit:g} {unit}, got {value:g} {unit}")


def check_at_least(field: str, value: float, limit: float, unit: str = "mm") -> None:
    """Raise ParameterError unless the value is at least the limit, but for round-off."""
    if not within(limit, value):
        behind = f" {unit}" if unit else ""
        raise ParameterError(field, f"must be at least {limit:g}{behind}, got {value:g}{behind}")


def check_at_most(field: str, value: float, limit: float, because: str, unit: str = "mm") -> None:
    """Raise ParameterError, with its reason `because`, unless the value is at most the limit.

    It may pass the limit by round-off.
    """
    if not within(value, limit):
        raise ParameterError(
            field, f"must be at most {limit:g} {unit}, {because}, got {value:g} {unit}"
        )


def check_below(field: str, value: float, limit: float, because: str) -> None:
    """Raise ParameterError, with its reason `because`, unless the length is below the limit, mm."""
    if not value < limit:
        raise ParameterError(field, f"must be below {limit:g} mm, {because}, got {value:g} mm")


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


# Reading files that somebody names: whole ones of a bounded size, never a device or a pipe.
MEBIBYTE = 2**20
MOST_TEXT = 16 * MEBIBYTE  # of a design, a table, or a result
MOST_CAD = 128 * MEBIBYTE


def read_bounded(path: Path, most: int = MOST_TEXT) -> bytes:
    """Content of a file of at most so many bytes.

    Raises OSError with the reason in words for a larger one, and for what is no file: a device may
    have no end, and a pipe may never begin.
    """
    with_type = path.stat().st_mode
    if stat.S_ISDIR(with_type):
        raise IsADirectoryError(errno.EISDIR, "is a directory", str(path))
    if not stat.S_ISREG(with_type):
        raise OSError(errno.EINVAL, "is a device or a pipe, not a file", str(path))
    with path.open("rb") as stream:
        content = stream.read(most + 1)
    if len(content) > most:
        told = f"has more than {most // MEBIBYTE} MiB, the most that is read"
        raise OSError(errno.EFBIG, told, str(path))
    return content
