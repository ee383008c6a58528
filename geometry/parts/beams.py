"""Straight beams of a rolled or hollow profile, with pins anywhere along their middle line."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import pi
from typing import Any, ClassVar

import numpy as np

from geometry.bars import (
    BESIDE,
    Bar,
    Profile,
    RulingSection,
    Section,
    Sections,
    Walls,
    chord,
    even,
    hollow_profile,
    i_profile,
)
from geometry.mesh import FloatArray, Interface
from geometry.parameters import ParameterError, a_length, check_above, check_at_least
from geometry.parts._plates import bore_at, drill
from geometry.shape import Body, Ligament, Region, Shape, faces_where

_PER_RADIUS = 5.0  # elements along the radius of a bore
_UNIFY = "Geometry.OCCUnionUnify"


@dataclass(frozen=True)
class PinHole:
    """A hole of a beam in which a pin sits, and the round boss about it.

    at        mm, place along the beam
    diameter  mm, of the hole
    boss      mm, outer diameter of the boss
    """

    name: str
    at: float = a_length("place along the beam", given_by="linkage")
    diameter: float = a_length("diameter of the hole")
    boss: float = a_length("outer diameter of the round boss about the hole")


@dataclass(frozen=True)
class Beam(Shape):
    """A profile along x with round bosses along z through its webs, on the middle line y = 0.

    holes     the outermost two first: at x = 0 and at x = `length`
    overhang  mm, from the outermost pins to the ends
    fillet    mm, radius all round where bosses meet webs
    """

    middle_plane: ClassVar[bool] = True

    holes: tuple[PinHole, ...]
    height: float = a_length("outer height, in the linkage's plane")
    width: float = a_length("outer width, out of that plane")
    overhang: float = a_length("from the outermost pins' axes to the beam's ends")
    fillet: float = a_length(
        "radius where the bosses meet the webs; 0 is a sharp edge", default=0.0
    )

    def __post_init__(self) -> None:
        self._check_profile()
        check_at_least("fillet", self.fillet, 0)
        if len(self.holes) < 2:
            raise ParameterError("holes", f"needs at least two holes, got {len(self.holes)}")
        flat = self.flat
        for hole in self.holes:
            check_above(f"holes.{hole.name}.diameter", hole.diameter, 0)
            check_above(f"holes.{hole.name}.boss", hole.boss, hole.diameter)
            if not self._foot(hole) < flat / 2:
                raise ParameterError(
                    f"holes.{hole.name}.boss",
                    f"{hole.boss:g} mm with its fillet meets the corners of the profile: it must "
                    f"be below {flat - 2 * self.fillet:.6g} mm",
                )
        row = sorted(self.holes, key=lambda hole: hole.at)
        for one, other in pairwise(row):
            if not self._foot(one) + self._foot(other) < other.at - one.at:
                raise ParameterError(
                    f"holes.{other.name}.boss",
                    f"{other.boss:g} mm meets the boss of {one.name}, {one.boss:g} mm: their pins "
                    f"are {other.at - one.at:.6g} mm apart",
                )
        for hole in (row[0], row[-1]):
            check_above("overhang", self.overhang, self._foot(hole))

    @abstractmethod
    def _check_profile(self) -> None:
        """Raise ParameterError for a profile that cannot be drawn."""

    @property
    @abstractmethod
    def flat(self) -> float:
        """Height of the webs between their roundings, mm."""

    @property
    @abstractmethod
    def web_face(self) -> float:
        """Height z of a web's face on which the bosses' fillets stand, mm."""

    @property
    @abstractmethod
    def shoulder(self) -> float:
        """Thickness of the flat bar whose shoulder a boss's fillet is, mm."""

    @property
    @abstractmethod
    def boss_length(self) -> float:
        """Length of the bosses along z, mm."""

    @property
    def gaps(self) -> float:
        """Length of a boss that is not within the webs, mm."""
        return self.boss_length - self.form.webs

    @property
    @abstractmethod
    def thinnest(self) -> float:
        """Thinnest wall, mm."""

    @property
    @abstractmethod
    def plates(self) -> Sequence[tuple[float, float, bool]]:
        """Breadth and thickness of flat walls, mm, and True for one with a free edge."""

    @property
    @abstractmethod
    def form(self) -> Profile:
        """The profile's properties."""

    @abstractmethod
    def _solid(self, gmsh: Any) -> list[tuple[int, int]]:
        """Build profile and bosses with their fillets, holes left out."""

    def _foot(self, hole: PinHole) -> float:
        """Radius at which a boss with its fillet ends, mm."""
        return hole.boss / 2 + self.fillet

    @property
    def interfaces(self) -> tuple[str, ...]:
        """Names of the holes."""
        return tuple(hole.name for hole in self.holes)

    @property
    def length(self) -> float:
        """Distance of the outermost pins, mm."""
        return self.holes[1].at

    @property
    def stressed_section(self) -> tuple[float, float]:
        """The profile's outline, height and width in mm, for Marin's size factor."""
        return (self.height, self.width)

    @property
    def ruling_sections(self) -> tuple[RulingSection, ...]:
        """Sizes that grade the strength of its material: thickest wall, thickest boss."""
        rings = max((hole.boss - hole.diameter) / 2 for hole in self.holes)
        return (RulingSection(max(rings, self._thickest)),)

    @property
    def _thickest(self) -> float:
        return self.thinnest

    @cached_property
    def sections(self) -> tuple[Section, ...]:
        """The profile of a beam with two pins, which is a column; none of one with more."""
        return (self.form.section,) if len(self.holes) == 2 else ()

    @property
    def told(self) -> Sequence[str]:
        """Notes on checks that it does not have: sentences for the report."""
        said = [
            "its bosses are taken as one piece with the webs: where they are welded in, their "
            "welds and root gaps are not judged, and decide its fatigue"
        ]
        if len(self.holes) > 2:
            said.append(
                "no column formula judged it, so yield was not checked by one: it has a pin "
                "between its outermost ones"
            )
        return said

    @property
    def bending(self) -> tuple[float, float, str]:
        """Second moment in the plane, mm4, area, mm2, and what it is of, in words."""
        one = self.form.section
        return one.inertia_in_plane, one.area, one.name

    def link(self, poisson_ratio: float) -> Bar:
        """The profile between the outermost pins."""
        return even(self.form.sections, 0.0, self.length)

    @property
    def profile(self) -> Bar:
        """The profile from end to end, bosses and holes in its area."""
        own = self.form.sections
        ends = [-self.overhang, self.length + self.overhang]
        for hole in self.holes:
            ends += [hole.at - hole.boss / 2, hole.at + hole.boss / 2]

        def at(x: FloatArray) -> Sections:
            area = np.full(x.shape, own.area)
            for hole in self.holes:
                area += self.gaps * chord(x, [(hole.at, hole.boss / 2)])
                area -= self.boss_length * chord(x, [(hole.at, hole.diameter / 2)])
            return replace(own, area=area)

        return Bar(tuple(sorted(ends)), at)

    @property
    def walls(self) -> tuple[Walls, ...]:
        """The profile from boss to boss, where the pins' forces have spread over its height."""
        row = sorted(self.holes, key=lambda hole: hole.at)
        found = []
        for one, other in pairwise(row):
            start, stop = one.at + BESIDE * self.height, other.at - BESIDE * self.height
            if start < stop:
                found.append(self._walls((start, stop)))
        return tuple(found)

    @abstractmethod
    def _walls(self, stretch: tuple[float, float]) -> Walls:
        """Walls of a stretch of the profile."""

    def ligaments(self, interface: str) -> Sequence[Ligament]:
        """The ring of the boss, on whatever side a force points to; webs behind it left out."""
        (hole,) = (one for one in self.holes if one.name == interface)
        ring = (hole.boss - hole.diameter) / 2
        return [Ligament(None, self.boss_length * ring, "the boss's outside")]

    def bore_key(self, interface: str) -> str:
        """Key of the part's entry that states a bore's diameter."""
        return f"holes.{interface}.diameter"

    @property
    def placed_interfaces(self) -> list[Interface]:
        """Where other parts press on it."""
        return [
            Interface(
                hole.name,
                "bore",
                np.array([hole.at, 0.0, 0.0]),
                hole.diameter / 2,
                self.boss_length,
                tilts=True,
            )
            for hole in self.holes
        ]

    def build(self, gmsh: Any) -> Body:
        """Build the beam in gmsh's current model."""
        occ = gmsh.model.occ
        solid = self._solid(gmsh)
        occ.cut(
            solid, [drill(gmsh, hole.at, hole.diameter, self.boss_length) for hole in self.holes]
        )
        occ.remove(occ.getEntities(2))
        occ.synchronize()
        return self.named(gmsh)

    def _bosses(self, gmsh: Any) -> list[tuple[int, int]]:
        """Solid cylinders of the bosses."""
        half = self.boss_length / 2
        return [
            (3, gmsh.model.occ.addCylinder(one.at, 0, -half, 0, 0, 2 * half, one.boss / 2))
            for one in self.holes
        ]

    def _filleted(
        self, gmsh: Any, solids: list[tuple[int, int]], height: float
    ) -> list[tuple[int, int]]:
        """Solids with fillets on the bosses' circles at z = +-height."""
        occ = gmsh.model.occ
        if not self.fillet:
            return solids
        occ.synchronize()
        near = 1e-4 * self.thinnest
        radii = {hole.boss / 2 for hole in self.holes}
        feet = []
        for _, tag in gmsh.model.getEntities(1):
            box = np.array(gmsh.model.getBoundingBox(1, tag))
            radius = (box[3] - box[0]) / 2
            flat = np.allclose(np.abs(box[[2, 5]]), height, rtol=0, atol=near)
            round_one = any(abs(radius - one) < near for one in radii)
            if flat and round_one and gmsh.model.getType(1, tag) == "Circle":
                feet.append(tag)
        made = occ.fillet([tag for _, tag in solids], feet, [self.fillet])
        return [one for one in made if one[0] == 3]

    def named(self, gmsh: Any) -> Body:
        """Return the body of the model, of the whole part or its half at z >= 0."""
        bores = {one.name: bore_at(gmsh, one.at, one.diameter) for one in self.holes}
        feet = [(2, tag) for tag in faces_where(gmsh, lambda _, kind: kind == "Torus")]
        wall = self.thinnest
        rounds = min(one.boss for one in self.holes) / 4
        size = max(1.5 * wall, min(3 * wall, self.height / 6, self.width / 6, rounds))
        fine = max(self.fillet / 3, wall / 4)
        return Body(
            surfaces=bores,
            interfaces=self.placed_interfaces,
            size=size,
            regions=[
                *(
                    Region(
                        [(2, tag) for tag in bores[one.name]],
                        min(one.diameter / 2 / _PER_RADIUS, size),
                        one.diameter / 2,
                    )
                    for one in self.holes
                ),
                *([Region(feet, fine, 3 * wall)] if feet and fine < size else []),
            ],
        )

    @property
    def proportions(self) -> Mapping[str, float]:
        """Walls, bosses and holes over the height, the shortest stretch too; the longest sleeve."""
        row = sorted(hole.at for hole in self.holes)
        return {
            "width / height": self.width / self.height,
            "web / height": self.form.webs / self.height,
            "boss / height": max(hole.boss for hole in self.holes) / self.height,
            "boss length / web": self.boss_length / self.form.webs,
            "boss length / boss": self.boss_length / min(hole.boss for hole in self.holes),
            "hole / boss": max(hole.diameter / hole.boss for hole in self.holes),
            "fillet / wall": self.fillet / self.thinnest,
            "overhang / boss": self.overhang / max(hole.boss for hole in self.holes),
            "length / height": min(b - a for a, b in pairwise(row)) / self.height,
        }


@dataclass(frozen=True)
class RhsBeam(Beam):
    """Rectangular hollow section along x with two or more pins on its middle line, y = 0.

    Each pin goes through both webs, the walls normal to z, in a round sleeve that ends flush with
    them. The ends are open.
    """

    name: ClassVar[str] = "rhs_beam"

    wall: float = a_length("wall thickness")
    corner: float = a_length(
        "outer radius of the corners: about 1.5 walls hot finished, 2 to 3 cold formed; the inner "
        "one is a wall less"
    )

    def _check_profile(self) -> None:
        for name in ("height", "width", "wall"):
            check_above(name, getattr(self, name), 0)
        least = min(self.height, self.width)
        if not self.wall < least / 2:
            raise ParameterError(
                "wall",
                f"{self.wall:g} mm is too thick: two walls fill {least:g} mm; it must be below "
                f"{least / 2:g} mm",
            )
        check_at_least("corner", self.corner, 0)
        if not self.corner < least / 2:
            raise ParameterError(
                "corner", f"must be below {least / 2:g} mm, half of a side, got {self.corner:g} mm"
            )
        if not 2 * self.fillet < self.width - 2 * self.wall:
            raise ParameterError(
                "fillet",
                f"{self.fillet:g} mm: two do not fit between the webs, it must be below "
                f"{self.width / 2 - self.wall:g} mm",
            )

    @property
    def flat(self) -> float:
        """Height of the webs between their roundings, mm."""
        return self.height - 2 * max(self.corner, self.wall)

    @property
    def web_face(self) -> float:
        """Height z of a web's face on which the bosses' fillets stand, mm."""
        return self.width / 2 - self.wall

    @property
    def shoulder(self) -> float:
        """Thickness of the flat bar whose shoulder a boss's fillet is, mm: both faces mirrored."""
        return 2 * self.wall

    @property
    def boss_length(self) -> float:
        """Length of the sleeves, mm."""
        return self.width

    @property
    def thinnest(self) -> float:
        """The wall, mm."""
        return self.wall

    @property
    def plates(self) -> Sequence[tuple[float, float, bool]]:
        """Webs and flanges, held along both edges."""
        sides = (self.height, self.width)
        return [(side - 2 * self.wall, self.wall, False) for side in sides]

    @cached_property
    def form(self) -> Profile:
        """The profile's properties."""
        return hollow_profile(self.height, self.width, self.wall, self.corner)

    def _walls(self, stretch: tuple[float, float]) -> Walls:
        section = self.form.section
        return Walls("rectangular", self.height, self.wall, stretch, section, corner=self.corner)

    def _solid(self, gmsh: Any) -> list[tuple[int, int]]:
        occ = gmsh.model.occ
        h, w, t = self.height, self.width, self.wall
        inner = max(self.corner - t, 0.0)
        start, total = -self.overhang, self.length + 2 * self.overhang
        outside = _bar(occ, start, total, h, w, self.corner)
        hollow = _bar(occ, start, total, h - 2 * t, w - 2 * t, inner)
        hollow, _ = occ.cut(hollow, self._bosses(gmsh))
        hollow = self._filleted(gmsh, hollow, w / 2 - t)
        solid, _ = occ.cut(outside, hollow)
        return list(solid)


@dataclass(frozen=True)
class IBeam(Beam):
    """I section along x, its web in the linkage's plane, with two or more pins on y = 0.

    Each pin goes through the web in a round boss, as long on either side of it.
    """

    name: ClassVar[str] = "i_beam"

    web: float = a_length("thickness of the web")
    flange: float = a_length("thickness of the flanges")
    root: float = a_length("radius where web and flanges meet")
    boss_width: float = a_length("length of the bosses, along the pins")

    def _check_profile(self) -> None:
        for name in ("height", "width", "web", "flange"):
            check_above(name, getattr(self, name), 0)
        check_at_least("root", self.root, 0)
        for name, taken, room in (
            ("flange", 2 * (self.flange + self.root), self.height),
            ("web", self.web + 2 * self.root, self.width),
        ):
            if not taken < room:
                raise ParameterError(
                    name,
                    f"{getattr(self, name):g} mm with the roots takes {taken:g} mm of the "
                    f"profile's {room:g} mm",
                )
        check_above("boss_width", self.boss_width, self.web + 2 * self.fillet)

    @property
    def flat(self) -> float:
        """Height of the web between its roundings, mm."""
        return self.height - 2 * (self.flange + self.root)

    @property
    def web_face(self) -> float:
        """Height z of the web's face, mm."""
        return self.web / 2

    @property
    def shoulder(self) -> float:
        """Thickness of the flat bar whose shoulder a boss's fillet is, mm."""
        return self.web

    @property
    def boss_length(self) -> float:
        """Length of the bosses, mm."""
        return self.boss_width

    @property
    def thinnest(self) -> float:
        """Thinner of web and flange, mm."""
        return min(self.web, self.flange)

    @property
    def plates(self) -> Sequence[tuple[float, float, bool]]:
        """The web, and halves of the flanges, free at their tips."""
        outstand = (self.width - self.web) / 2
        return [
            (self.height - 2 * self.flange, self.web, False),
            (outstand, self.flange, True),
        ]

    @property
    def proportions(self) -> Mapping[str, float]:
        """Those of a beam, and how thick the flanges are."""
        return {**super().proportions, "flange / web": self.flange / self.web}

    @property
    def _thickest(self) -> float:
        return max(self.web, self.flange)

    @cached_property
    def form(self) -> Profile:
        """The profile's properties."""
        return i_profile(self.height, self.width, self.web, self.flange, self.root)

    def _walls(self, stretch: tuple[float, float]) -> Walls:
        form = self.form
        return Walls(
            "I",
            self.height,
            self._thickest,
            stretch,
            form.section,
            shear=form.shear,
            torsion=float(form.sections.torsion),
            warping=form.warping,
        )

    def _solid(self, gmsh: Any) -> list[tuple[int, int]]:
        occ = gmsh.model.occ
        h, b, s, f = self.height, self.width, self.web, self.flange
        start, total = -self.overhang, self.length + 2 * self.overhang
        profile = _bar(occ, start, total, h, b, 0.0)
        height, side = h - 2 * f, (b - s) / 2
        gaps = []
        for way in (1.0, -1.0):
            # twice as wide as the gap, so that the roundings stand at the web alone
            gap = _bar(occ, start, total, height, 2 * side, self.root)
            occ.translate(gap, 0, 0, way * (s / 2 + side))
            gaps += gap
        solid, _ = occ.cut(profile, gaps)
        before = gmsh.option.getNumber(_UNIFY)
        gmsh.option.setNumber(_UNIFY, 0)  # or both arcs of a root would be one again
        solid, _ = occ.fuse(solid, self._bosses(gmsh))
        gmsh.option.setNumber(_UNIFY, before)
        return self._filleted(gmsh, list(solid), s / 2)


def _bar(
    occ: Any, start: float, length: float, height: float, width: float, radius: float
) -> list[tuple[int, int]]:
    """A bar along x of a rectangle with round corners."""
    if not radius:
        return [(3, occ.addBox(start, -height / 2, -width / 2, length, height, width))]
    tips: list[list[int]] = []
    for k in range(4):  # the corners in turn, from that at y, z > 0
        turn = np.exp(1j * pi / 2 * np.array([k, k + 0.5, k + 1]))
        side = np.exp(1j * pi / 2 * (k + 0.5))
        y, z = np.sign(side.real) * (height / 2 - radius), np.sign(side.imag) * (width / 2 - radius)
        middle = occ.addPoint(start, y, z)
        tips.append([occ.addPoint(start, y + radius * t.real, z + radius * t.imag) for t in turn])
        tips[-1].append(middle)
    curves = []
    for k, (first, half, last, middle) in enumerate(tips):
        curves.append(occ.addLine(tips[k - 1][2], first))
        # two arcs: a quarter of a circle in one element would miss 1 % of its square
        curves += [occ.addCircleArc(first, middle, half), occ.addCircleArc(half, middle, last)]
    face = occ.addPlaneSurface([occ.addCurveLoop(curves)])
    made = occ.extrude([(2, face)], length, 0, 0)
    occ.remove([(2, face)])
    return [one for one in made if one[0] == 3]
