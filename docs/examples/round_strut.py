"""A solid round bar between two pins, pressed and pulled on its end faces: its geometry."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import Any, ClassVar

import numpy as np

from geometry.bars import Bar, RulingSection, Section, even, round_tube, round_tube_section
from geometry.mesh import Interface
from geometry.parameters import GIVEN_BY_LINKAGE, a_length, check_above
from geometry.shape import Body, Shape, faces_where


@dataclass(frozen=True)
class RoundStrut(Shape):
    """Round bar along x from x = 0 (interface "start") to x = `length` (interface "end")."""

    name: ClassVar[str] = "round_strut"
    stressed_evenly: ClassVar[bool] = True
    interfaces: ClassVar[tuple[str, ...]] = ("start", "end")

    length: float = a_length("distance between the pin axes", given_by=GIVEN_BY_LINKAGE)
    diameter: float = a_length("diameter of the bar")

    def __post_init__(self) -> None:
        for name in ("length", "diameter"):
            check_above(name, getattr(self, name), 0)

    @property
    def stressed_section(self) -> tuple[float]:
        """The bar's diameter, mm, for Marin's size factor."""
        return (self.diameter,)

    @property
    def ruling_sections(self) -> tuple[RulingSection, ...]:
        """Sizes that grade the strength of its material."""
        return (RulingSection(self.diameter, round=True),)

    @property
    def sections(self) -> tuple[Section, ...]:
        """The bar's one section, as a column."""
        return (round_tube_section("bar", self.diameter, 0.0),)

    def link(self, poisson_ratio: float) -> Bar:
        """The bar from end to end."""
        return self.profile

    @property
    def profile(self) -> Bar:
        """The bar from end to end."""
        return even(round_tube(self.diameter), 0.0, self.length)

    @property
    def proportions(self) -> Mapping[str, float]:
        """Length over diameter."""
        return {"length / diameter": self.length / self.diameter}

    @property
    def placed_interfaces(self) -> list[Interface]:
        """The end faces."""
        places = zip(self.interfaces, (0.0, self.length), strict=True)
        return [Interface(name, "face", np.array([x, 0.0, 0.0])) for name, x in places]

    def build(self, gmsh: Any) -> Body:
        """Build the bar in gmsh's current model."""
        gmsh.model.occ.addCylinder(0, 0, 0, self.length, 0, 0, self.diameter / 2, angle=2 * pi)
        gmsh.model.occ.synchronize()

        def end_at(x: float) -> list[int]:
            near = 1e-4 * self.diameter
            return faces_where(gmsh, lambda box, _: bool(np.allclose(box[[0, 3]], x, atol=near)))

        return Body(
            surfaces={"start": end_at(0.0), "end": end_at(self.length)},
            interfaces=self.placed_interfaces,
            size=self.diameter / 3,
            regions=[],
        )
