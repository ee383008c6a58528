"""A plain square tube between two pins, loaded on its end faces."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from geometry.bars import Bar, RulingSection, Section, Walls, even, square_tube_section
from geometry.bars import square_tube as square_section
from geometry.mesh import Interface
from geometry.parameters import GIVEN_BY_LINKAGE, a_length, check_square_tube
from geometry.parts._plates import square_tube
from geometry.shape import Body, Shape, faces_where


@dataclass(frozen=True)
class PrismaticTube(Shape):
    """Square tube along x from x = 0 (interface "start") to x = `length` (interface "end")."""

    name: ClassVar[str] = "prismatic_tube"
    stressed_evenly: ClassVar[bool] = True
    middle_plane: ClassVar[bool] = True
    interfaces: ClassVar[tuple[str, ...]] = ("start", "end")

    length: float = a_length("distance between the pin axes", given_by=GIVEN_BY_LINKAGE)
    width: float = a_length("outer width of the square tube")
    wall: float = a_length("wall thickness")
    inner_radius: float = a_length("radius of the tube's inner corners", default=0.0)

    def __post_init__(self) -> None:
        check_square_tube(self.length, self.width, self.wall, self.inner_radius)

    @property
    def stressed_section(self) -> tuple[float, float]:
        """The tube's outline, height and width in mm, for Marin's size factor."""
        return (self.width, self.width)

    @cached_property
    def sections(self) -> tuple[Section, ...]:
        """The tube's one section."""
        return (square_tube_section("tube", self.width, self.wall, self.inner_radius),)

    def link(self, poisson_ratio: float) -> Bar:
        """The tube from end to end."""
        return self.profile

    @property
    def profile(self) -> Bar:
        """The tube from end to end."""
        (tube,) = self.sections
        one = square_section(self.width, self.wall, tube.area, tube.inertia_in_plane)
        return even(one, 0.0, self.length)

    @property
    def walls(self) -> tuple[Walls, ...]:
        """The tube from end to end."""
        return (Walls("rectangular", self.width, self.wall, (0.0, self.length), self.sections[0]),)

    @property
    def clear_width(self) -> float:
        """Clear width between the walls, mm."""
        return self.width - 2 * self.wall

    @property
    def proportions(self) -> Mapping[str, float]:
        """Width over wall and length over width."""
        return {"width / wall": self.width / self.wall, "length / width": self.length / self.width}

    @property
    def ruling_sections(self) -> tuple[RulingSection, ...]:
        """Sizes that grade the strength of its material."""
        return (RulingSection(self.wall),)

    @property
    def placed_interfaces(self) -> list[Interface]:
        """Where other parts press on it."""
        return [
            Interface(name, "face", np.array([x, 0.0, 0.0])) for name, x in self.pin_places.items()
        ]

    def build(self, gmsh: Any) -> Body:
        """Build the tube in gmsh's current model."""
        square_tube(gmsh, 0.0, self.length, self.width, self.wall, self.inner_radius)
        gmsh.model.occ.synchronize()
        return self.named(gmsh)

    def named(self, gmsh: Any) -> Body:
        """Return the body of the model, of the whole part or its half at z >= 0."""
        ends = {name: faces_where(gmsh, self._at(x)) for name, x in self.pin_places.items()}
        return Body(
            surfaces=ends,
            interfaces=self.placed_interfaces,
            size=max(1.5 * self.wall, min(3 * self.wall, self.width / 6)),
            regions=[],
        )

    def _at(self, x: float) -> Callable[[Any, str], bool]:
        """Test of a face's bounding box: does the face lie in the plane at `x`."""
        return lambda box, _: bool(np.allclose(box[[0, 3]], x, atol=1e-4 * self.width))
