"""Sizes of a shape: the smallest and largest that a part of a machine has, and their ratio."""

import dataclasses
from collections.abc import Callable, Iterator
from math import floor, log10
from statistics import median
from typing import Any, TypeVar

from geometry.parameters import GIVEN_BY_LINKAGE as LINKAGE
from geometry.parameters import ParameterError

LEAST, MOST = 1e-6, 1e7  # mm: a nanometre and 10 km
FARTHEST = 1e6  # largest over smallest size of one part: squares and cubes stay within double
_PLACES = ("at",)  # where something stands: 0 but for round-off is one of them


def sizes_of(shape: Any) -> dict[str, float]:
    """Return every length of a shape that is not 0, mm, without its sign; of seats as a `stack`."""
    return dict(_sizes(shape))


def _sizes(shape: Any) -> Iterator[tuple[str, float]]:
    for parameter in dataclasses.fields(shape):
        value = getattr(shape, parameter.name)
        if parameter.name == "seats":
            for index, seat in enumerate(value):
                yield from ((f"stack[{index}].{key}", size) for key, size in _sizes(seat))
        elif parameter.metadata.get("dimension") == "length":
            many = value if isinstance(value, tuple) else (value,)
            for index, size in enumerate(many):
                if size:
                    name = parameter.name if value is size else f"{parameter.name}[{index}]"
                    yield name, abs(float(size))


def far_apart(sizes: dict[str, float]) -> tuple[str, str]:
    """Return the key of the size that is farthest from the usual one, and that at the other end."""
    least, most = min(sizes, key=sizes.__getitem__), max(sizes, key=sizes.__getitem__)
    usual = median(sizes.values())
    return (most, least) if sizes[most] / usual > usual / sizes[least] else (least, most)


def key_of(shape: type[Any] | Any, name: str) -> str:
    """Return the key that a size comes from: distances between pins follow from `interfaces`."""
    linked = (f.name for f in dataclasses.fields(shape) if f.metadata.get("given_by") == LINKAGE)
    return "interfaces" if name in linked else name


def check_sizes(shape: Any) -> None:
    """Raise ParameterError where a size is none of a machine's part, or far from its others.

    Numbers beyond that are accepted by no model: a mesh cannot have both sizes, and a frame's
    stiffness loses its digits.
    """
    sizes = sizes_of(shape)
    small = {name: size for name, size in sizes.items() if name.rpartition(".")[2] not in _PLACES}
    for name, size in sizes.items():
        least = LEAST if name in small else 0.0
        if not least <= size <= MOST:
            raise ParameterError(
                name,
                f"must be between {LEAST:g} and {MOST:g} mm, as of any part of a machine, got "
                f"{size:g} mm; is its unit wrong?",
            )
    if not small:
        return
    known = {name: size for name, size in sizes.items() if size >= min(small.values())}
    odd, other = far_apart(known)
    ratio = max(known.values()) / min(known.values())
    if ratio > FARTHEST:
        raise ParameterError(
            odd,
            f"{sizes[odd]:g} mm is too far from {other} = {sizes[other]:g} mm: the largest size "
            f"of a part may be {FARTHEST:g} times the smallest; is its unit wrong?",
        )


# The unit of length in which a shape is built and meshed, so that its size is 3 to 3000 of them.
#
# gmsh and its CAD kernel have absolute tolerances, 1e-8 and 1e-7 of whatever the unit is: a part
# of 1 um or of 1 km has no mesh by them, or another one than the same part has in mm. Units are
# 1000 times apart, so that most parts of machines are meshed in mm.

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
