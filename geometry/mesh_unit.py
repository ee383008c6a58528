"""The unit of length in which a shape is built and meshed, so that its size is 3 to 3000 of them.

gmsh and its CAD kernel have absolute tolerances, 1e-8 and 1e-7 of whatever the unit is: a part of
1 um or of 1 km has no mesh by them, or another one than the same part has in mm. Units are 1000
times apart, so that most parts of machines are meshed in mm.
"""

import dataclasses
from collections.abc import Callable
from math import floor, log10
from typing import Any, TypeVar

from geometry.part_sizes import sizes_of

_LEAST = 3.0  # of a unit: the largest length that a shape states is from here to 1000 times as much
_DECADES = 3  # between units

T = TypeVar("T")


def unit_of(shape: Any) -> float:
    """Return the unit in mm, a power of 1000, by the largest length that a shape states.

    1 for a shape that states none, such as a file from CAD.
    """
    whole = getattr(shape, "whole", shape)
    sizes = sizes_of(whole) if dataclasses.is_dataclass(whole) else {}
    if not sizes:
        return 1.0
    steps = floor(log10(max(sizes.values()) / _LEAST) / _DECADES)
    return float(f"1e{_DECADES * steps}")


def in_unit(shape: T, unit: float) -> T:
    """Return a shape with its lengths in a unit of so many mm, to the 12 digits they have."""
    if unit == 1.0:
        return shape
    changed: T = _changed(shape, lambda length: float(f"{length / unit:.12g}"))
    return changed


def _changed(shape: Any, change: Callable[[float], float]) -> Any:
    """Return a shape with every length changed; of seats and of a shape that is halved, too."""
    changed: dict[str, Any] = {}
    for parameter in dataclasses.fields(shape):
        name, value = parameter.name, getattr(shape, parameter.name)
        if name == "whole":
            changed[name] = _changed(value, change)
        elif name == "seats":
            changed[name] = tuple(_changed(seat, change) for seat in value)
        elif parameter.metadata.get("dimension") == "length" and value is not None:
            many = isinstance(value, tuple)
            changed[name] = tuple(change(one) for one in value) if many else change(value)
    return dataclasses.replace(shape, **changed)
