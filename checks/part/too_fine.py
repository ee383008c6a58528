"""What a mesher or a solver could not do with a part, told of the part and its size."""

import dataclasses
from collections.abc import Iterator
from statistics import median
from typing import Any

from checks.design.data import Design, Part
from checks.design.errors import DesignError, NumericsError
from geometry.mesh import TooFineError
from geometry.parameters import GIVEN_BY_LINKAGE
from geometry.parts import Pin


def told_of_size(design: Design, part: Part, error: Exception) -> DesignError:
    """What a mesher refused, with the key of the size that is farthest from the part's others."""
    key, sizes = f"parts.{part.name}", dict(_sizes(part.geometry))
    if not isinstance(error, TooFineError) or not sizes:
        return DesignError(design.file, key, str(error))
    least, most = min(sizes, key=sizes.__getitem__), max(sizes, key=sizes.__getitem__)
    usual = median(sizes.values())
    odd, other = (most, least) if sizes[most] / usual > usual / sizes[least] else (least, most)
    told = f"{sizes[odd]:.4g} mm beside {other} = {sizes[other]:.4g} mm"
    if odd in _linked(part.geometry):
        odd, told = "interfaces", f"pins that are {told.replace(' beside', ' apart beside')}"
    return DesignError(design.file, f"{key}.{odd}", f"{told} are too far from each other: {error}")


def gave_up(design: Design, part: Part, error: Exception) -> NumericsError:
    """What a mesher or a solver said, with the part it said it of."""
    return NumericsError(
        str(error),
        f"{design.file}: parts.{part.name}",
        "check the part's dimensions, or change mesh.fineness",
    )


def _linked(geometry: Any) -> set[str]:
    fields = dataclasses.fields(geometry)
    return {f.name for f in fields if f.metadata.get("given_by") == GIVEN_BY_LINKAGE}


def _sizes(geometry: Any) -> Iterator[tuple[str, float]]:
    """Every length of a shape above 0 by its key, mm."""
    for parameter in dataclasses.fields(geometry):
        value = getattr(geometry, parameter.name)
        if isinstance(geometry, Pin) and parameter.name == "seats":
            for index, seat in enumerate(value):
                yield from ((f"stack[{index}].{key}", size) for key, size in _sizes(seat))
        elif parameter.metadata.get("dimension") == "length":
            many = value if isinstance(value, tuple) else (value,)
            for index, size in enumerate(many):
                if size:
                    name = parameter.name if value is size else f"{parameter.name}[{index}]"
                    yield name, abs(float(size))
