"""Errors of a mesher or a solver, with the part and the size that they are about."""

from checks.design.data import Design, Part
from checks.design.errors import DesignError, NumericsError
from geometry.mesh import TooFineError, TooManyUnknownsError
from geometry.parts.pin import as_pin
from geometry.shape import far_apart, key_of, sizes_of

_BY_WIDTH = 3  # power of a narrow lug's width by which unknowns fall


def told_of_size(design: Design, part: Part, error: Exception) -> DesignError:
    """The error of a mesher, with the key of the size that is farthest from the part's others."""
    key, sizes = f"parts.{part.name}", sizes_of(part.geometry)
    pin, many = as_pin(part.geometry), error.__cause__
    if pin is not None and isinstance(many, TooManyUnknownsError) and pin.narrow:
        index = min(range(len(pin.seats)), key=lambda k: pin.seats[k].width)
        width = pin.seats[index].width
        least = width * (many.unknowns / part.most_unknowns) ** (1 / _BY_WIDTH)
        return DesignError(
            design.file,
            f"{key}.stack[{index}].width",
            f"a lug of {width:g} mm on a pin of {pin.diameter:g} mm takes about "
            f"{many.unknowns:.1g} unknowns, where mesh.most_unknowns is {part.most_unknowns:g}; it "
            f"must be at least about {least:.2g} mm for a solid (--fidelity formula takes none)",
        )
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
