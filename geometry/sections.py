"""Cross-sections of parts that may buckle."""

from dataclasses import dataclass
from math import pi


@dataclass(frozen=True)
class Section:
    """A cross-section along a part in compression.

    name                  as reports call it
    area                  mm2
    inertia_in_plane      mm4, bending in the plane of the linkage (about z)
    inertia_out_of_plane  mm4, bending out of it (about y)
    length                mm, effective length in plane; None for the whole part's
    length_out_of_plane   mm, effective length out of plane; None for the whole part's
    """

    name: str
    area: float
    inertia_in_plane: float
    inertia_out_of_plane: float
    length: float | None = None
    length_out_of_plane: float | None = None


def square_tube_section(name: str, width: float, wall: float, inner_radius: float) -> Section:
    """Return a square tube; the inner corners' fillets count in area and, at their place, in I.

    >>> square_tube_section("tube", 30.0, 1.6, 0.0).inertia_in_plane
    24510.941...
    """
    inner = width - 2 * wall
    fillet = (1 - 3.141592653589793 / 4) * inner_radius**2
    arm = inner / 2 - 0.2234 * inner_radius  # centroid of a spandrel: 0.2234 r from its walls
    inertia = (width**4 - inner**4) / 12 + 4 * fillet * arm**2
    return Section(name, width**2 - inner**2 + 4 * fillet, inertia, inertia)


def round_tube_section(name: str, diameter: float, bore: float) -> Section:
    """Return a round tube; a bore of 0 is a solid bar.

    >>> round_tube_section("tube", 20.0, 15.0).area
    137.44...
    """
    inertia = pi * (diameter**4 - bore**4) / 64
    return Section(name, pi * (diameter**2 - bore**2) / 4, inertia, inertia)


def plate_section(name: str, height: float, thickness: float) -> Section:
    """Return one flat plate, `height` in the plane of the linkage."""
    return Section(name, height * thickness, thickness * height**3 / 12, height * thickness**3 / 12)


def plate_pair_section(name: str, height: float, wall: float, length: float) -> Section:
    """Two parallel plates, `height` in the plane of the linkage, free over `length`.

    In the plane they bend together between pin and tube. Out of it nothing keeps their ends from
    splaying apart or folding: each is a cantilever, of twice its free length.
    """
    return Section(
        name,
        2 * height * wall,
        2 * wall * height**3 / 12,
        2 * height * wall**3 / 12,
        length,
        2 * length,
    )
