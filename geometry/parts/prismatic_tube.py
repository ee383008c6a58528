"""A plain square tube between two pins, loaded on its end faces."""

from dataclasses import dataclass

from geometry.parameters import GIVEN_BY_LINKAGE, length


@dataclass(frozen=True)
class PrismaticTube:
    """Square tube along x from x = 0 (interface "start") to x = `length` (interface "end")."""

    length: float = length("distance between the pin axes", given_by=GIVEN_BY_LINKAGE)
    width: float = length("outer width of the square tube")
    wall: float = length("wall thickness")
    inner_radius: float = length("radius of the tube's inner corners", default=0.0)
