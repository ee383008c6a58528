"""A toggle bar: square tube with a bolt hole through both cheeks at each end, folded open at the knee."""

from dataclasses import dataclass

from geometry.parameters import GIVEN_BY_LINKAGE, length


@dataclass(frozen=True)
class ToggleBar:
    """Square tube along x; pin axes along z at x = 0 (interface "knee") and x = `length` ("end").

    The cheeks are the two walls normal to z. The two other walls are cut away over
    `cutout_length` from the knee's end, with corners of radius `cutout_corner`.
    """

    length: float = length("distance between the pin axes", given_by=GIVEN_BY_LINKAGE)
    width: float = length("outer width of the square tube")
    wall: float = length("wall thickness")
    hole: float = length("diameter of the holes through the cheeks")
    overhang: float = length("from each pin axis to the bar's end")
    inner_radius: float = length("radius of the tube's inner corners")
    cutout_length: float = length("length over which the side walls are removed at the knee")
    cutout_corner: float = length("corner radius of the cut-out")
