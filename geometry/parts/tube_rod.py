"""A long round rod, hollow or solid, with an eye at each end."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import asin, hypot, pi, sqrt
from typing import Any, ClassVar

import numpy as np

from geometry.bars import (
    Bar,
    RulingSection,
    Section,
    Sections,
    Walls,
    bored,
    chord,
    even,
    round_tube,
    round_tube_section,
)
from geometry.mesh import FloatArray, Interface
from geometry.parameters import (
    GIVEN_BY_LINKAGE,
    ParameterError,
    a_length,
    check_above,
    check_at_least,
    check_at_most,
    check_below,
)
from geometry.parts._plates import Outline, bore_at, drill
from geometry.shape import Body, Ligament, Region, Shape, faces_where

_ANGLES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


def ball_ligament(ball: float, width: float, hole: float) -> float:
    """Area, mm2, of the ligament behind the hole of an eye: a ball of diameter `ball`, cut flat.

    The integral of sqrt(R^2 - z^2) - r over the eye's width.

    >>> round(ball_ligament(40.0, 1e-3, 20.0) / 1e-3, 6)
    10.0
    """
    radius, half = ball / 2, width / 2
    circle = half * sqrt(radius**2 - half**2) + radius**2 * asin(half / radius)
    return circle - width * hole / 2


@dataclass(frozen=True)
class TubeRod(Shape):
    """Round tube along x; holes along z at x = 0 (interface "first") and x = `length` ("second").

    Each eye is a ball about the pin's middle with flats at z = +-`eye_width` / 2, and the tube runs
    into it with a fillet. The tube's bore ends in hemispheres that stop where the balls end.
    """

    name: ClassVar[str] = "tube_rod"
    middle_plane: ClassVar[bool] = True
    interfaces: ClassVar[tuple[str, ...]] = ("first", "second")

    length: float = a_length("distance between the pin axes", given_by=GIVEN_BY_LINKAGE)
    tube_diameter: float = a_length("outer diameter of the tube")
    wall: float | None = a_length("wall thickness; without it the rod is solid", default=None)
    eye_diameter: float = a_length("diameter of the eyes about the pin axes")
    eye_width: float = a_length("width of the eyes on the pins")
    hole: float = a_length("diameter of the holes")
    fillet: float = a_length("radius where the tube joins the eyes; 0 is a sharp edge", default=0.0)

    def __post_init__(self) -> None:
        for name in ("length", "tube_diameter", "eye_width", "hole"):
            check_above(name, getattr(self, name), 0)
        if self.wall is not None:
            check_above("wall", self.wall, 0)
            check_below("wall", self.wall, self.tube_diameter / 2, "half the tube's diameter")
        check_at_least("fillet", self.fillet, 0)
        check_above("eye_diameter", self.eye_diameter, self.tube_diameter)
        self._check_eyes()

    def _check_eyes(self) -> None:
        check_below("hole", self.hole, self.eye_diameter, "the diameter of the eye")
        flat = sqrt(self.eye_diameter**2 - self.hole**2)
        check_below("eye_width", self.eye_width, flat, "where the eye's flats hold the hole")
        if not self.shank_end < self.length / 2:
            raise ParameterError(
                "fillet",
                f"{self.fillet:g} mm: eyes and fillets take {2 * self.shank_end:.4g} mm, the pins "
                f"are {self.length:g} mm apart",
            )
        ends = self.eye_diameter + self.bore
        if self.bore and not ends < self.length:
            raise ParameterError(
                "wall",
                f"{self.wall:g} mm: no room for a bore, eyes and hemispheres take {ends:g} mm, "
                f"the pins are {self.length:g} mm apart",
            )
        check_at_most(
            "tube_diameter", self.tube_diameter, self.eye_width, "or it reaches beyond the flats"
        )

    @property
    def bore(self) -> float:
        """Diameter of the tube's bore, mm; 0 for a solid rod."""
        return 0.0 if self.wall is None else self.tube_diameter - 2 * self.wall

    @property
    def shank_end(self) -> float:
        """Distance from the pin axis to where the tube's fillet begins, mm."""
        radius, reach = self.eye_diameter / 2, self.tube_diameter / 2 + self.fillet
        return sqrt((radius + self.fillet) ** 2 - reach**2)

    @property
    def stressed_section(self) -> tuple[float, float]:
        """The eyes, diameter and width in mm, for Marin's size factor: larger than the tube."""
        return (self.eye_diameter, self.eye_width)

    @property
    def sections(self) -> tuple[Section, ...]:
        """The tube, or the solid rod."""
        name = "tube" if self.bore else "rod"
        return (round_tube_section(name, self.tube_diameter, self.bore),)

    @property
    def net_section(self) -> float:
        """The eye on both sides of its hole, mm2."""
        return 2 * self.ligament

    @property
    def walls(self) -> tuple[Walls, ...]:
        """The tube, or the solid rod, between the fillets of the eyes."""
        wall = self.tube_diameter if self.wall is None else self.wall
        stretch = (self.shank_end, self.length - self.shank_end)
        return (Walls("round", self.tube_diameter, wall, stretch, self.sections[0]),)

    def build(self, gmsh: Any) -> Body:
        """Build the rod in gmsh's current model."""
        occ = gmsh.model.occ
        rod = self._outside().revolve(gmsh)
        occ.rotate([(3, rod)], 0, 0, 0, 0, 1, 0, pi / 2)
        far = self.length + self.eye_diameter
        slab = occ.addBox(-far, -far, -self.eye_width / 2, 3 * far, 2 * far, self.eye_width)
        solids, _ = occ.intersect([(3, rod)], [(3, slab)])
        tools = [drill(gmsh, x, self.hole, self.eye_width) for x in (0.0, self.length)]
        if self.bore:
            bore = self._inside().revolve(gmsh)
            occ.rotate([(3, bore)], 0, 0, 0, 0, 1, 0, pi / 2)
            tools.append((3, bore))
        occ.cut(solids, tools)
        occ.synchronize()
        return self.named(gmsh)

    def _outside(self) -> Outline:
        """Ball, fillet, tube, fillet, ball, along the axis of revolution."""
        eye, tube, fillet = self.eye_diameter / 2, self.tube_diameter / 2, self.fillet
        centre = (tube + fillet, self.shank_end)
        r, z = (eye / hypot(*centre) * place for place in centre)
        outline = Outline()
        outline.line_to(0.0, -eye)
        outline.arc_to(r, z, (0.0, 0.0))
        outline.arc_to(tube, centre[1], centre)
        outline.line_to(tube, self.length - centre[1])
        outline.arc_to(r, self.length - z, (centre[0], self.length - centre[1]))
        outline.arc_to(0.0, self.length + eye, (0.0, self.length))
        return outline

    def _inside(self) -> Outline:
        """Hemisphere, cylinder, hemisphere."""
        start, radius = self.eye_diameter / 2, self.bore / 2
        outline = Outline()
        outline.line_to(0.0, start)
        outline.arc_to(radius, start + radius, (0.0, start + radius))
        outline.line_to(radius, self.length - start - radius)
        outline.arc_to(0.0, self.length - start, (0.0, self.length - start - radius))
        return outline

    def link(self, poisson_ratio: float) -> Bar:
        """The tube, its eyes left out."""
        return even(round_tube(self.tube_diameter, self.bore), 0.0, self.length)

    @property
    def profile(self) -> Bar:
        """Eyes, fillets and tube: discs cut at the eyes' flats, less the tube's bore and the holes.

        The areas of a cut disc are integrals over z, by Gauss.
        """
        eye, end = self.eye_diameter / 2, self.shank_end
        hollow = eye + self.bore / 2 if self.bore else end
        marks = {0.0, self.joint, end, *((eye, hollow) if self.bore else ())}
        far = self.length + eye
        return Bar(tuple(sorted({-eye, far, *marks, *(self.length - x for x in marks)})), self._at)

    @property
    def joint(self) -> float:
        """Distance from the pin axis to where an eye's ball goes over into the fillet, mm."""
        eye = self.eye_diameter / 2
        return self.shank_end * eye / (eye + self.fillet)

    def outer_radius(self, from_pin: FloatArray) -> FloatArray:
        """Outer radius at places beside a pin's axis: ball, fillet, tube; 0 beyond."""
        eye, tube, end = self.eye_diameter / 2, self.tube_diameter / 2, self.shank_end
        ball = np.sqrt(np.maximum(eye**2 - from_pin**2, 0.0))
        below = np.maximum(self.fillet**2 - (end - from_pin) ** 2, 0.0)
        fillet = tube + self.fillet - np.sqrt(below)
        return np.where(from_pin < self.joint, ball, np.where(from_pin < end, fillet, tube))

    def inner_radius(self, from_pin: FloatArray) -> FloatArray:
        """Radius of the tube's bore at places beside a pin's axis; 0 where it is solid."""
        eye, bore = self.eye_diameter / 2, self.bore / 2
        inside = np.maximum(bore**2 - np.maximum(eye + bore - from_pin, 0.0) ** 2, 0.0)
        return np.where(from_pin > eye, np.sqrt(inside), 0.0)

    def _at(self, x: FloatArray) -> Sections:
        from_pin = np.where(x > self.length / 2, self.length - x, x)
        outer, inner = self.outer_radius(from_pin), self.inner_radius(from_pin)
        half = np.minimum(outer, self.eye_width / 2)
        most = np.arcsin(np.minimum(half / outer, 1.0))[..., None]
        angle, weight = most * _ANGLES, most * _WEIGHTS
        width, z = outer[..., None] * np.cos(angle), outer[..., None] * np.sin(angle)
        strip = weight * width  # dz
        area = (2 * width * strip).sum(axis=-1) - np.pi * inner**2
        about_z = (2 / 3 * width**3 * strip).sum(axis=-1) - np.pi / 4 * inner**4
        about_y = (2 * width * z**2 * strip).sum(axis=-1) - np.pi / 4 * inner**4
        # Saint-Venant's of an ellipse, and so of a full disc or tube: 4 I_y I_z / (I_y + I_z)
        torsion = 4 * about_y * about_z / (about_y + about_z)
        round_one = round_tube(2 * outer, 2 * inner)
        shear = area * round_one.shear_area_y / round_one.area
        solid = Sections(area, about_y, about_z, torsion, shear, shear)
        holes = [(place, self.hole / 2) for place in self.pin_places.values()]
        return bored(solid, chord(x, holes), 2 * outer, 2 * half)

    @property
    def proportions(self) -> Mapping[str, float]:
        """Sizes over the eyes' and the tube's diameter."""
        wall = self.tube_diameter / 2 if self.wall is None else self.wall
        return {
            "hole / eye": self.hole / self.eye_diameter,
            "eye width / eye": self.eye_width / self.eye_diameter,
            "tube / eye": self.tube_diameter / self.eye_diameter,
            "wall / tube": wall / self.tube_diameter,
            "fillet / tube": self.fillet / self.tube_diameter,
            "length / eye": self.length / self.eye_diameter,
        }

    @property
    def ligament(self) -> float:
        """Area of the eye behind its hole, mm2."""
        return ball_ligament(self.eye_diameter, self.eye_width, self.hole)

    def ligaments(self, interface: str) -> Sequence[Ligament]:
        """The eye behind a hole: a ball cut flat."""
        direction, end = self.outward(interface)
        neck = self.tube_diameter / self.eye_diameter
        return [Ligament(direction, self.ligament, end, round=neck)]

    @property
    def ruling_sections(self) -> tuple[RulingSection, ...]:
        """Sizes that grade the strength of its material."""
        return (RulingSection(min(self.eye_diameter, self.eye_width)), self._shank_size)

    @property
    def _shank_size(self) -> RulingSection:
        if self.wall is None:
            return RulingSection(self.tube_diameter, round=True)
        return RulingSection(self.wall)

    @property
    def placed_interfaces(self) -> list[Interface]:
        """Where other parts press on it."""
        return [
            Interface(name, "bore", np.array([x, 0.0, 0.0]), self.hole / 2, self.eye_width)
            for name, x in self.pin_places.items()
        ]

    def named(self, gmsh: Any) -> Body:
        """Return the body of the model, of the whole part or its half at z >= 0."""
        bores = {name: bore_at(gmsh, x, self.hole) for name, x in self.pin_places.items()}
        fillets = faces_where(gmsh, lambda _, kind: kind == "Torus")
        holes = [(2, tag) for tags in bores.values() for tag in tags]
        around = [(2, tag) for tag in fillets]
        fine = min(self.fillet / 1.5, self.tube_diameter / 6)
        return Body(
            surfaces={**bores, **({"fillet": fillets} if fillets else {})},
            interfaces=self.placed_interfaces,
            size=self.tube_diameter / (4 if self.bore else 3),
            regions=[
                Region(holes, self.hole / 14, self.hole / 2),
                *([Region(around, fine, self.tube_diameter / 2)] if fillets else []),
            ],
        )
