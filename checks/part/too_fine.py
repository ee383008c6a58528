"""Errors of a mesher or a solver, with the part and the size that they are about."""

from checks.design.data import Design, Part
from checks.design.errors import DesignError, NumericsError
from geometry.mesh import TooFineError
from geometry.part_sizes import far_apart, key_of, sizes_of


def told_of_size(design: Design, part: Part, error: Exception) -> DesignError:
    """The error of a mesher, with the key of the size that is farthest from the part's others."""
    key, sizes = f"parts.{part.name}", sizes_of(part.geometry)
    if not isinstance(error, TooFineError) or not sizes:
        return DesignError(design.file, key, str(error))
    odd, other = far_apart(sizes)
    stated = key_of(part.geometry, odd)
    pins, apart = ("pins that are ", " apart") if stated == "interfaces" else ("", "")
    told = f"{pins}{sizes[odd]:.4g} mm{apart} beside {other} = {sizes[other]:.4g} mm"
    return DesignError(
        design.file, f"{key}.{stated}", f"{told} are too far from each other: {error}"
    )


def gave_up(design: Design, part: Part, error: Exception) -> NumericsError:
    """The error of a mesher or a solver, with the part that it is about."""
    return NumericsError(
        str(error),
        f"{design.file}: parts.{part.name}",
        "check the part's dimensions, or change mesh.fineness",
    )
