"""A flat link with rounded ends and a hole at each, such as a crank or a connecting rod."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from geometry.bars import (
    BESIDE,
    Bar,
    RulingSection,
    Section,
    Sections,
    Walls,
    bored,
    chord,
    even,
    plate_section,
    rectangle,
)
from geometry.mesh import FloatArray, Interface
from geometry.parameters import GIVEN_BY_LINKAGE, ParameterError, a_length, check_above, check_below
from geometry.parts._plates import bore_at, drill, stadium
from geometry.shape import Body, Ligament, Region, Shape


@dataclass(frozen=True)
class PlateLink(Shape):
    """Flat plate along x; holes along z at x = 0 (interface "first") and x = `length` ("second").

    Its ends are round about the holes. Plates are mounted side by side, so that their pins also
    tilt in the holes.
    """

    name: ClassVar[str] = "plate_link"
    middle_plane: ClassVar[bool] = True
    interfaces: ClassVar[tuple[str, ...]] = ("first", "second")

    length: float = a_length("distance between the pin axes", given_by=GIVEN_BY_LINKAGE)
    width: float = a_length("width of the plate, in the linkage's plane")
    thickness: float = a_length("thickness of the plate")
    hole: float = a_length("diameter of the hole at the first pin")
    second_hole: float | None = a_length(
        "diameter of the hole at the second pin, if it is another", default=None
    )

    def __post_init__(self) -> None:
        for name in ("length", "width", "thickness", "hole"):
            check_above(name, getattr(self, name), 0)
        check_below("hole", self.hole, self.width, "the width of the plate")
        if self.second_hole is not None:
            check_above("second_hole", self.second_hole, 0)
            check_below("second_hole", self.second_hole, self.width, "the width of the plate")
        if not sum(self._holes.values()) / 2 < self.length:
            raise ParameterError(
                "hole", f"{self.hole:g} mm: the holes meet, the pins are {self.length:g} mm apart"
            )

    @property
    def _holes(self) -> dict[str, float]:
        """Diameter of the hole by interface, mm."""
        second = self.hole if self.second_hole is None else self.second_hole
        return {"first": self.hole, "second": second}

    @property
    def stressed_section(self) -> tuple[float, float]:
        """The plate, width and thickness in mm, for Marin's size factor."""
        return (self.width, self.thickness)

    @cached_property
    def sections(self) -> tuple[Section, ...]:
        """The plate's one section, away from the holes."""
        return (plate_section("plate", self.width, self.thickness),)

    @property
    def walls(self) -> tuple[Walls, ...]:
        """The plate between its holes, where their stress has died away."""
        first, second = (max(hole / 2, BESIDE * self.width) for hole in self._holes.values())
        if not first < self.length - second:
            return ()
        stretch = (first, self.length - second)
        return (Walls("flat", self.width, self.thickness, stretch, self.sections[0]),)

    def link(self, poisson_ratio: float) -> Bar:
        """The plate from hole to hole."""
        return even(rectangle(self.width, self.thickness), 0.0, self.length)

    @property
    def profile(self) -> Bar:
        """The plate with its round ends and holes."""
        half, thick = self.width / 2, self.thickness
        holes = [(float(one.centre[0]), one.radius) for one in self.placed_interfaces]

        def at(x: FloatArray) -> Sections:
            ends = np.maximum(np.maximum(-x, x - self.length), 0.0)
            height = 2 * np.sqrt(half**2 - ends**2)
            return bored(rectangle(height, thick), chord(x, holes), height, thick)

        return Bar((-half, 0.0, self.length, self.length + half), at)

    @property
    def proportions(self) -> Mapping[str, float]:
        """Holes, thickness and length over the width or the holes."""
        holes = self._holes.values()
        return {
            "hole / width": max(holes) / self.width,
            "thickness / hole": self.thickness / min(holes),
            "length / width": self.length / self.width,
        }

    def ligaments(self, interface: str) -> Sequence[Ligament]:
        """The plate behind a hole, towards its round end and both edges."""
        (direction, end), hole = self.outward(interface), self._holes[interface]
        return [Ligament(direction, self.thickness * (self.width - hole) / 2, end, round=1.0)]

    def bore_key(self, interface: str) -> str:
        """The second hole has a key of its own where it is another."""
        own = interface == "second" and self.second_hole is not None
        return "second_hole" if own else "hole"

    @property
    def ruling_sections(self) -> tuple[RulingSection, ...]:
        """Sizes that grade the strength of its material."""
        return (RulingSection(self.thickness),)

    @property
    def placed_interfaces(self) -> list[Interface]:
        """Where other parts press on it."""
        return [
            Interface(name, "bore", np.array([x, 0.0, 0.0]), hole / 2, self.thickness, tilts=True)
            for (name, x), hole in zip(self.pin_places.items(), self._holes.values(), strict=True)
        ]

    def build(self, gmsh: Any) -> Body:
        """Build the plate in gmsh's current model."""
        occ = gmsh.model.occ
        half = self.width / 2
        plate = stadium(gmsh, -half, self.length + half, self.width, self.thickness)
        tools = [
            drill(gmsh, self.pin_places[end], d, self.thickness) for end, d in self._holes.items()
        ]
        occ.cut([(3, plate)], tools)
        occ.synchronize()
        return self.named(gmsh)

    def named(self, gmsh: Any) -> Body:
        """Return the body of the model, of the whole part or its half at z >= 0."""
        bores = {name: bore_at(gmsh, self.pin_places[name], d) for name, d in self._holes.items()}
        return Body(
            surfaces=bores,
            interfaces=self.placed_interfaces,
            size=min(self.width / 4, max(self.thickness / 2, self.width / 8)),
            regions=[
                Region([(2, tag) for tag in bores[name]], hole / 14, hole / 2)
                for name, hole in self._holes.items()
            ],
        )
