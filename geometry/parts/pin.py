"""A pin in its stack of lugs, stepped where a lug has a smaller bore."""

from dataclasses import dataclass

from geometry.parameters import length


@dataclass(frozen=True)
class Seat:
    """Where one lug, or a pair of lugs at +-`at`, presses on the pin."""

    name: str
    at: float = length("distance of the lug's mid-plane from the pin's mid-plane", default=0.0)
    width: float = length("width of the lug on the pin")
    diameter: float | None = length("diameter of the pin in this lug, if stepped", default=None)


@dataclass(frozen=True)
class Pin:
    """Round pin along z, mid-plane at z = 0, one interface per seat."""

    seats: tuple[Seat, ...]
    diameter: float = length("diameter of the pin")
    step_fillet: float = length("radius at a step of the pin; 0 is a sharp edge", default=0.0)
    overhang: float = length("length of the pin beyond the outermost lug", default=5.0)
