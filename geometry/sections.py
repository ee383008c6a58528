"""Cross-sections of parts that may buckle."""

from dataclasses import dataclass, field
from math import pi


@dataclass(frozen=True)
class RulingSection:
    """Size of what a part is made from, by which standards grade strengths.

    size   mm, thickness of what is flat, diameter of what is round
    round  True for a round bar
    """

    size: float
    round: bool = False


@dataclass(frozen=True)
class Section:
    """A cross-section along a part in compression.

    name                  as reports call it
    area                  mm2
    inertia_in_plane      mm4, bending in the plane of the linkage (about z)
    inertia_out_of_plane  mm4, bending out of it (about y)
    length                mm, effective length in plane; None for the whole part's
    length_out_of_plane   mm, effective length out of plane; None for the whole part's
    depth_in_plane        mm, outer size in the plane of the linkage, along y
    depth_out_of_plane    mm, outer size out of it, along z
    stretch               mm, from where to where along x the part has it; None for all along
    inertia_built_up      mm4, about y, of plates that the pin makes bend together out of the plane
                          as a part of the whole column; None for `inertia_out_of_plane`
    racking_area          mm2, E times it is the shear stiffness out of plane of such plates, which
                          bend in S shape between the tube and the pin; None without shear strain
    """

    name: str
    area: float
    inertia_in_plane: float
    inertia_out_of_plane: float
    length: float | None = None
    length_out_of_plane: float | None = None
    depth_in_plane: float = field(kw_only=True)
    depth_out_of_plane: float = field(kw_only=True)
    stretch: tuple[float, float] | None = field(default=None, kw_only=True)
    inertia_built_up: float | None = field(default=None, kw_only=True)
    racking_area: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if self.stretch is not None and not self.stretch[0] < self.stretch[1]:
            raise ValueError(
                f"section {self.name!r} stretches from {self.stretch[0]:g} mm, to "
                f"{self.stretch[1]:g} mm"
            )


def square_tube_section(name: str, width: float, wall: float, inner_radius: float) -> Section:
    """Return a square tube; the inner corners' fillets count in area and, at their place, in I.

    >>> square_tube_section("tube", 30.0, 1.6, 0.0).inertia_in_plane
    24510.941...
    """
    inner = width - 2 * wall
    fillet = (1 - 3.141592653589793 / 4) * inner_radius**2
    arm = inner / 2 - 0.2234 * inner_radius  # centroid of a spandrel: 0.2234 r from its walls
    inertia = (width**4 - inner**4) / 12 + 4 * fillet * arm**2
    return Section(
        name,
        width**2 - inner**2 + 4 * fillet,
        inertia,
        inertia,
        depth_in_plane=width,
        depth_out_of_plane=width,
    )


def round_tube_section(name: str, diameter: float, bore: float) -> Section:
    """Return a round tube; a bore of 0 is a solid bar.

    >>> round_tube_section("tube", 20.0, 15.0).area
    137.44...
    """
    inertia = pi * (diameter**4 - bore**4) / 64
    return Section(
        name,
        pi * (diameter**2 - bore**2) / 4,
        inertia,
        inertia,
        depth_in_plane=diameter,
        depth_out_of_plane=diameter,
    )


def plate_section(name: str, height: float, thickness: float) -> Section:
    """Return one flat plate, `height` in the plane of the linkage."""
    return Section(
        name,
        height * thickness,
        thickness * height**3 / 12,
        height * thickness**3 / 12,
        depth_in_plane=height,
        depth_out_of_plane=thickness,
    )


def plate_pair_section(
    name: str, height: float, wall: float, length: float, apart: float
) -> Section:
    """Two plates with their middles `apart`, `height` in the linkage's plane, free over `length`.

    In the plane they bend together between pin and tube. Out of it nothing keeps their ends from
    splaying apart or folding: each is a cantilever, of twice its free length.

    As a part of the whole column they carry its moment by pushing and pulling, A apart^2/4, and its
    shear by bending, hinged at the pin: the shear stiffness is 2 x 3 E I/length^2, I of one plate.
    """
    one = height * wall**3 / 12
    return Section(
        name,
        2 * height * wall,
        2 * wall * height**3 / 12,
        2 * one,
        length,
        2 * length,
        depth_in_plane=height,
        depth_out_of_plane=apart + wall,
        inertia_built_up=2 * (one + height * wall * (apart / 2) ** 2),
        racking_area=6 * one / length**2,
    )
