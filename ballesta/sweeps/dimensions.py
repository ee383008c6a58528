"""Dimensions of a design file as they are changed: read, rounded, at preferred sizes, written."""

import re
from math import ceil, floor, log10

_DIMENSION = re.compile(r"^\s*(\d+(?:\.\d+)?)\s*(mm|cm|m|deg)\s*$")
_VARIED = re.compile(r"parts\.\w+\.(\w+(?<!hole)|welds\[\d+\]\.throat)$")  # a pin sets a hole
_CYLINDER = re.compile(r"cylinders\.\w+\.(rod|wall)$")
_DIGITS = 2  # of the change, to which a dimension is rounded
# R20 of ISO 3:1973, as the package renard 1.3 lists it: steps of about 12 %.
_R20 = (
    1.0, 1.12, 1.25, 1.4, 1.6, 1.8, 2.0, 2.24, 2.5, 2.8, 3.15, 3.55, 4.0, 4.5, 5.0, 5.6, 6.3, 7.1,
    8.0, 9.0,
)  # fmt: skip


def dimension(key: str, value: str) -> tuple[float, str] | None:
    """Number and unit of a dimension of a part but a hole's, or of a weld's throat; else None."""
    return _read(value) if _VARIED.match(key) else None


def of_cylinder(key: str, value: str) -> tuple[float, str] | None:
    """Number and unit of the thickness of a cylinder's rod or wall; else None."""
    return _read(value) if _CYLINDER.match(key) else None


def _read(value: str) -> tuple[float, str] | None:
    match = _DIMENSION.match(value)
    return (float(match[1]), match[2]) if match and float(match[1]) else None


def rounded(value: float, old: float, *, up: bool) -> float:
    """Rounded to two digits of the change, and no finer than a hundredth of the old value's."""
    change = abs(value - old)
    if not change:
        return value
    unit = 10.0 ** max(floor(log10(change)) - _DIGITS + 1, floor(log10(old)) - 2)
    count = value / unit
    return round((ceil(count - 1e-9) if up else floor(count + 1e-9)) * unit, 9)


def standard(value: float, *, up: bool) -> float:
    """The next length of R20 on one side, or the value if it is one.

    >>> standard(6.42, up=True), standard(5.42, up=False), standard(80.0, up=True)
    (7.1, 5.0, 80.0)
    """
    decade = 10.0 ** floor(log10(value))
    sizes = [round(decade * size * ten, 9) for ten in (0.1, 1.0, 10.0) for size in _R20]
    if up:
        return next(size for size in sizes if size >= value * (1 - 1e-9))
    return next(size for size in reversed(sizes) if size <= value * (1 + 1e-9))


def written(value: float, unit: str) -> str:
    """A length or angle as a design file has it."""
    return f"{value:.9g} {unit}"
