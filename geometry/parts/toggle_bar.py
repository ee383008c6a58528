"""A toggle bar: square tube with a hole through both cheeks at each end, cut open at the knee."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
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
    plate_pair_section,
    rectangle,
    square_tube_section,
)
from geometry.bars import square_tube as square_section
from geometry.mesh import FloatArray, Interface
from geometry.parameters import (
    GIVEN_BY_LINKAGE,
    ParameterError,
    a_length,
    check_above,
    check_square_tube,
)
from geometry.parts._plates import bore_at, drill, square_tube
from geometry.shape import Body, Ligament, Region, Shape, faces_where

_TURN = 0.27  # of cheeks, times 12/(E t^3): solids have 0.31 and more
_CLEAR, _THICK = 1.1, (1.0, 8.0)  # of them: to the nearest edge over radius; radius over wall


@dataclass(frozen=True)
class ToggleBar(Shape):
    """Square tube along x; pin axes along z at x = 0 (interface "knee") and x = `length` ("end").

    The cheeks are the two walls normal to z. The two other walls are cut away over
    `cutout_length` from the knee's end, with corners of radius `cutout_corner`.
    """

    name: ClassVar[str] = "toggle_bar"
    middle_plane: ClassVar[bool] = True
    interfaces: ClassVar[tuple[str, ...]] = ("knee", "end")

    length: float = a_length("distance between the pin axes", given_by=GIVEN_BY_LINKAGE)
    width: float = a_length("outer width of the square tube")
    wall: float = a_length("wall thickness")
    hole: float = a_length("diameter of the holes through the cheeks")
    overhang: float = a_length("from each pin axis to the bar's end")
    inner_radius: float = a_length("radius of the tube's inner corners")
    cutout_length: float = a_length("length over which the side walls are removed at the knee")
    cutout_corner: float = a_length("corner radius of the cut-out")

    def __post_init__(self) -> None:
        check_square_tube(self.length, self.width, self.wall, self.inner_radius)
        self._check_holes()
        self._check_cut_out()

    def _check_holes(self) -> None:
        check_above("hole", self.hole, 0)
        flat = self.width - 2 * self.wall - 2 * self.inner_radius
        if self.hole >= self.width:
            raise ParameterError(
                "hole", f"{self.hole:g} mm is larger than the bar's width of {self.width:g} mm"
            )
        if self.hole >= flat:
            raise ParameterError(
                "hole",
                f"{self.hole:g} mm cuts into the side walls; it must be below {flat:g} mm, "
                "the flat width of the cheek",
            )
        if self.hole >= self.length:
            raise ParameterError(
                "hole", f"{self.hole:g} mm: the holes meet, the pins are {self.length:g} mm apart"
            )
        if self.overhang <= self.hole / 2:
            raise ParameterError(
                "overhang",
                f"{self.overhang:g} mm does not hold the hole of {self.hole:g} mm; "
                f"it must be above {self.hole / 2:g} mm",
            )

    def _check_cut_out(self) -> None:
        check_above("cutout_length", self.cutout_length, 0)
        total = self.length + 2 * self.overhang
        if self.cutout_length >= total:
            raise ParameterError(
                "cutout_length",
                f"{self.cutout_length:g} mm is longer than the bar, which is {total:g} mm",
            )
        check_above("cutout_corner", self.cutout_corner, 0)
        largest = min(self.width / 2 - self.wall, self.cutout_length)
        if self.cutout_corner >= largest:
            raise ParameterError(
                "cutout_corner",
                f"{self.cutout_corner:g} mm is too large for the cut-out; "
                f"it must be below {largest:g} mm",
            )

    @property
    def stressed_section(self) -> tuple[float, float]:
        """The plate that a bore weakens, height and thickness in mm, for Marin's size factor."""
        return (self.width, self.wall)

    @cached_property
    def sections(self) -> tuple[Section, ...]:
        """The tube, and the two cheeks that alone carry the load beside the cut-out."""
        free = self.cutout_length - self.overhang
        tube = square_tube_section("tube", self.width, self.wall, self.inner_radius)
        if not free > 0:
            return (tube,)
        apart = self.width - self.wall
        cheeks = plate_pair_section("cheeks", self.width, self.wall, free, apart)
        if free < self.length:
            tube = replace(tube, stretch=(free, self.length))
            cheeks = replace(cheeks, stretch=(0.0, free))
        return tube, cheeks

    @property
    def walls(self) -> tuple[Walls, ...]:
        """The closed tube, a width beyond the cut-out, where the holes' stress has died away."""
        beside, free = BESIDE * self.width, self.cutout_length - self.overhang
        stretch = (max(free + self.width, beside), self.length - beside)
        if not stretch[0] < stretch[1]:
            return ()
        return (Walls("rectangular", self.width, self.wall, stretch, self.sections[0]),)

    def link(self, poisson_ratio: float) -> Bar:
        """A tube, and its cheeks alone beside the cut-out at the knee.

        The cheeks alone carry out-of-plane bending by pushing and pulling, as the pin makes them
        turn together, and the shear by their own bending, hinged at the pin. Without an axial force
        their shear stiffness were 6 E I/free^2; they sway aside under pi^2/2 E I/free^2, I of one
        cheek, and the bar buckles where its force is its shear stiffness, so this lower one is
        taken.
        """
        free, cheek = self._free, rectangle(self.width, self.wall)
        if not free > 0:
            return even(self._tube, 0.0, self.length)
        ratio = 2 * (1 + poisson_ratio)  # E/G
        sway = np.pi**2 / 2 * ratio * cheek.inertia_y / free**2
        cuts = (0.0, free, self.length) if free < self.length else (0.0, self.length)
        return Bar(cuts, partial(self._at, float(sway)))

    @property
    def profile(self) -> Bar:
        """The tube with its holes, from end to end; its cheeks alone beside the cut-out."""
        holes = [(float(one.centre[0]), one.radius) for one in self.placed_interfaces]

        def at(x: FloatArray) -> Sections:
            whole, taken = self._at(np.inf, x), chord(x, holes)
            less = bored(whole, taken, self.width, 2 * self.wall)
            beside = 2 * self.wall * self.cheeks_at**2
            return replace(less, inertia_y=whole.inertia_y - taken * beside)

        ends = {-self.overhang, 0.0, self._free, self.length, self.length + self.overhang}
        return Bar(tuple(sorted(ends)), at)

    @property
    def _free(self) -> float:
        """Place at which the side walls begin, mm."""
        return self.cutout_length - self.overhang

    @property
    def _tube(self) -> Sections:
        tube = self.sections[0]
        return square_section(self.width, self.wall, tube.area, tube.inertia_in_plane)

    def _at(self, sway: float, x: FloatArray) -> Sections:
        """Sections at places x, holes filled; cheeks shear by no more than `sway`, mm2."""
        cheek, beside = rectangle(self.width, self.wall), self.cheeks_at
        cheeks = Sections(
            area=2 * cheek.area,
            inertia_y=2 * (cheek.area * beside**2 + cheek.inertia_y),
            inertia_z=2 * cheek.inertia_z,
            torsion=2 * (cheek.shear_area_y * beside**2 + cheek.torsion),
            shear_area_y=2 * cheek.shear_area_y,
            shear_area_z=np.minimum(sway, 2 * cheek.shear_area_z),
        )
        whole = self._tube
        pairs = ((getattr(cheeks, f.name), getattr(whole, f.name)) for f in fields(Sections))
        return Sections(*(np.where(x < self._free, own, other) for own, other in pairs))

    @property
    def proportions(self) -> Mapping[str, float]:
        """Holes, walls and cut-out over the width and the walls."""
        free = self.cutout_length - self.overhang  # of the cheeks, beyond the knee's axis
        return {
            "hole / width": self.hole / self.width,
            "overhang / hole": self.overhang / self.hole,
            "hole / wall": self.hole / self.wall,
            "width / wall": self.width / self.wall,
            "cut-out / width": self.cutout_length / self.width,
            "cut-out corner / wall": self.cutout_corner / self.wall,
            "hole to the cut-out's end / width": (free - self.hole / 2) / self.width,
            "length / width": self.length / self.width,
        }

    def ligaments(self, interface: str) -> Sequence[Ligament]:
        """Both cheeks behind a hole."""
        direction, end = self.outward(interface)
        return [Ligament(direction, 2 * self.wall * (self.overhang - self.hole / 2), end)]

    @property
    def cheeks_at(self) -> float:
        """Height +-z of the middles of the cheeks, mm."""
        return (self.width - self.wall) / 2

    @property
    def cheeks_turn(self) -> float:
        """Below all solids that were compared, at both ends (docs/theory/contact.md)."""
        radius, clear = self.hole / 2, min(self.width / 2 - self.wall, self.overhang)
        compared = _CLEAR * radius <= clear and _THICK[0] <= radius / self.wall <= _THICK[1]
        return _TURN * 12 / self.wall**3 if compared else 0.0

    @property
    def ruling_sections(self) -> tuple[RulingSection, ...]:
        """Sizes that grade the strength of its material."""
        return (RulingSection(self.wall),)

    @property
    def placed_interfaces(self) -> list[Interface]:
        """Where other parts press on it."""
        return [
            Interface(
                name,
                "bore",
                np.array([x, 0.0, 0.0]),
                self.hole / 2,
                2 * self.wall,
                piece=self.wall,
            )
            for name, x in self.pin_places.items()
        ]

    def build(self, gmsh: Any) -> Body:
        """Build the bar in gmsh's current model."""
        occ = gmsh.model.occ
        tube = square_tube(
            gmsh,
            -self.overhang,
            self.length + self.overhang,
            self.width,
            self.wall,
            self.inner_radius,
        )
        tools = [self._cut_out(occ)]
        tools += [drill(gmsh, x, self.hole, self.width) for x in self.pin_places.values()]
        occ.cut([(3, tube)], tools)
        occ.remove(occ.getEntities(2))
        occ.synchronize()
        return self.named(gmsh)

    def _cut_out(self, occ: Any) -> tuple[int, int]:
        """Prism along y that removes the side walls from the knee's end up to the cut-out's end."""
        clear = self.width / 2 - self.wall
        beyond = 2 * self.cutout_corner
        profile = occ.addRectangle(
            -self.overhang - beyond,
            -clear,
            0,
            beyond + self.cutout_length,
            2 * clear,
            roundedRadius=self.cutout_corner,
        )
        occ.rotate([(2, profile)], 0, 0, 0, 1, 0, 0, np.pi / 2)
        occ.translate([(2, profile)], 0, self.width, 0)
        extruded = occ.extrude([(2, profile)], 0, -2 * self.width, 0)
        return 3, next(int(tag) for dimension, tag in extruded if dimension == 3)

    def named(self, gmsh: Any) -> Body:
        """Return the body of the model, of the whole part or its half at z >= 0."""
        radius, cut_end = self.hole / 2, self.cutout_length - self.overhang
        wanted, tolerance = (cut_end - self.cutout_corner, cut_end), 1e-4 * self.width
        corners = faces_where(
            gmsh,
            lambda box, kind: (
                kind == "Cylinder" and np.allclose(box[[0, 3]], wanted, atol=tolerance)
            ),
        )
        bores = {name: bore_at(gmsh, x, self.hole) for name, x in self.pin_places.items()}
        return Body(
            surfaces={**bores, "cutout_corner": corners},
            interfaces=self.placed_interfaces,
            size=1.1 * self.wall,
            regions=[
                Region([(2, tag) for tags in bores.values() for tag in tags], radius / 9, radius),
                Region([(2, tag) for tag in corners], self.cutout_corner / 3, self.cutout_corner),
            ],
        )
