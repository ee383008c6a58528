"""A leaf spring that rocks: flat leaves on top of each other, clamped at a pivot."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar

import numpy as np

from geometry.bars import Bar, RulingSection, Sections, even, rectangle
from geometry.mesh import Interface
from geometry.parameters import (
    GIVEN_BY_LINKAGE,
    ParameterError,
    a_count,
    a_force,
    a_length,
    a_number,
    check_above,
    check_at_least,
    check_at_most,
    check_below,
    within,
)
from geometry.shape import Body, Region, Shape, faces_where


@dataclass(frozen=True)
class LeafPack(Shape):
    """Equal flat leaves along x, stacked along y, their width along z; the pack's middle is y = 0.

    They are clamped at x = 0 (interface "pivot") and, by the rod's bracket, at x = `length`
    ("rod"). At the other side, x < 0, a contact slides along them ("contact"): a force along +y
    presses on the bottom of the pack, one along -y on its top. The leaves slide on each other
    without friction and never part: each has its own nodes, tied along y to the next leaf's. A bolt
    through the middle of the clamp, at x = 0, keeps them together along x and, in their middle, z.
    """

    name: ClassVar[str] = "leaf_pack"
    may_buckle: ClassVar[bool] = False
    interfaces: ClassVar[tuple[str, ...]] = ("pivot", "rod", "contact")

    length: float = a_length("distance from the pivot to the rod's pin", given_by=GIVEN_BY_LINKAGE)
    leaves: int = a_count("number of leaves")
    width: float = a_length("width of the leaves, out of the linkage's plane")
    thickness: float = a_length("thickness of one leaf")
    arm: float = a_length("from the pivot to the leaves' end on the side of the contact")
    overhang: float = a_length("from the rod's pin to the leaves' other end")
    clamp_length: float = a_length("length of the clamp at the pivot, half of it on either side")
    rod_length: float = a_length("length of the rod's bracket, half of it on either side")
    contact_from: float = a_length("distance of the contact from the pivot at its nearest")
    contact_to: float = a_length("distance of the contact from the pivot at its farthest")
    contact_length: float = a_length("length on which the contact presses")
    clamp_factor: float = a_number(
        "fatigue notch factor of the fretting at the clamp's edges, about 1.2 to 1.8", default=1.3
    )
    friction: float | None = a_number(
        "coefficient of friction between the leaves; silent: 0.1 to 0.3", default=None
    )
    clamp_preload: float | None = a_force(
        "force by which the bolts of the pivot's clamp press the leaves together; silent: from "
        "none to so much that nothing slips in the clamp",
        default=None,
    )
    rod_preload: float | None = a_force(
        "force by which the rod's bracket presses the leaves together; silent: from none to so "
        "much that nothing slips there",
        default=None,
    )

    def __post_init__(self) -> None:
        if not (self.leaves >= 1 and self.leaves % 1 == 0):
            raise ParameterError("leaves", f"must be 1, 2, 3 or so, got {self.leaves:g}")
        for name in ("length", "width", "thickness", "clamp_length", "rod_length"):
            check_above(name, getattr(self, name), 0)
        for name in ("contact_length", "contact_from"):
            check_above(name, getattr(self, name), 0)
        check_above("contact_to", self.contact_to, self.contact_from)
        check_at_least("clamp_factor", self.clamp_factor, 1, unit="")
        for name, unit in (("friction", ""), ("clamp_preload", "N"), ("rod_preload", "N")):
            if getattr(self, name) is not None:
                check_at_least(name, getattr(self, name), 0, unit=unit)
        self._check_that_patches_are_apart()

    def _check_that_patches_are_apart(self) -> None:
        pins = 2 * self.length
        check_below("clamp_length", self.clamp_length, pins, "where it meets the rod's pin")
        clear = pins - self.clamp_length
        check_at_most("rod_length", self.rod_length, clear, "where it meets the pivot's clamp")
        check_at_least("overhang", self.overhang, self.rod_length / 2)
        nearest = (self.clamp_length + self.contact_length) / 2
        if not within(nearest, self.contact_from):
            raise ParameterError(
                "contact_from",
                f"{self.contact_from:g} mm: the contact runs onto the clamp; "
                f"it must be at least {nearest:g} mm",
            )
        farthest = self.arm - self.contact_length / 2
        if not within(self.contact_to, farthest):
            raise ParameterError(
                "contact_to",
                f"{self.contact_to:g} mm: the contact leaves the end of the leaves, at "
                f"{self.arm:g} mm; it must be at most {farthest:g} mm",
            )

    @property
    def stressed_section(self) -> tuple[float, float]:
        """One leaf, thickness and width in mm, for Marin's size factor."""
        return (self.thickness, self.width)

    @property
    def notch_factors(self) -> Mapping[str, float]:
        """Fatigue notch factors by surface: fretting at the edges of the clamp."""
        return {"pivot": self.clamp_factor}

    @property
    def inertia_separate(self) -> float:
        """Second moment of area of leaves that slide on each other, n b t^3 / 12, mm4."""
        return self.leaves * self.width * self.thickness**3 / 12

    def link(self, poisson_ratio: float) -> Bar:
        """Leaves that slide on each other in the plane, side by side out of it; no clamp."""
        one = rectangle(self.thickness, self.width)
        pack = Sections(*(self.leaves * getattr(one, f.name) for f in fields(Sections)))
        return replace(even(pack, -self.arm, self.length), cuts=(-self.arm, 0.0, self.length))

    @property
    def bending(self) -> tuple[float, float, str]:
        """Leaves that slide on each other."""
        area = self.leaves * self.width * self.thickness
        words = f"{self.leaves} leaves that slide on each other"
        return area * self.thickness**2 / 12, area, words

    @property
    def proportions(self) -> Mapping[str, float]:
        """Number of leaves, and lengths over the thickness of one."""
        beside = self.contact_from - self.clamp_length / 2
        return {
            "leaves": float(self.leaves),
            "width / thickness": self.width / self.thickness,
            "clamp / thickness": self.clamp_length / self.thickness,
            "contact / thickness": self.contact_length / self.thickness,
            "clamp to contact / thickness": beside / self.thickness,
        }

    @property
    def ruling_sections(self) -> tuple[RulingSection, ...]:
        """Sizes that grade the strength of its material."""
        return (RulingSection(self.thickness),)

    @property
    def placed_interfaces(self) -> list[Interface]:
        """Where other parts press on it."""
        return [
            Interface("pivot", "clamp", np.zeros(3), length=self.width),
            Interface("rod", "clamp", np.array([self.length, 0, 0]), length=self.width),
            Interface(
                "contact",
                "slide",
                np.zeros(3),
                length=self.width,
                travel=(-self.contact_to, -self.contact_from),
                patch=self.contact_length / 2,
            ),
        ]

    def build(self, gmsh: Any) -> Body:
        """Build the leaves in gmsh's current model, with the patches imprinted on their faces."""
        occ = gmsh.model.occ
        total = self.arm + self.length + self.overhang
        leaves = [
            (3, occ.addBox(-self.arm, y, -self.width / 2, total, self.thickness, self.width))
            for y in self._levels()[:-1]
        ]
        imprints = [
            self._rectangle(occ, *x, y)
            for x in self._patches().values()
            for y in self._levels()[[0, -1]]
        ]
        imprints += [self._rectangle(occ, -self.arm, 0.0, y) for y in self._levels()[1:-1]]
        occ.fragment(leaves, imprints)
        occ.synchronize()
        return self._named(gmsh)

    def _levels(self) -> Any:
        """Heights of the leaves' faces from bottom to top, mm."""
        return self.thickness * (np.arange(self.leaves + 1) - self.leaves / 2)

    def _patches(self) -> dict[str, tuple[float, float]]:
        """Lowest and highest x at which each interface touches the leaves, mm."""
        half = self.contact_length / 2
        return {
            "pivot": (-self.clamp_length / 2, self.clamp_length / 2),
            "rod": (self.length - self.rod_length / 2, self.length + self.rod_length / 2),
            "contact": (-self.contact_to - half, -self.contact_from + half),
        }

    def _rectangle(self, occ: Any, start: float, stop: float, y: float) -> tuple[int, int]:
        """A strip across the whole width, from `start` to `stop` along x."""
        tag = occ.addRectangle(start, -self.width / 2, 0, stop - start, self.width)
        occ.rotate([(2, tag)], 0, 0, 0, 1, 0, 0, np.pi / 2)
        occ.translate([(2, tag)], 0, y, 0)
        return 2, tag

    def _named(self, gmsh: Any) -> Body:
        bottom, top = self._levels()[[0, -1]]
        patches = self._patches()
        surfaces = {
            name: self._strip(gmsh, patches[name], bottom) + self._strip(gmsh, patches[name], top)
            for name in ("pivot", "rod")
        }
        surfaces["contact+"] = self._strip(gmsh, patches["contact"], bottom)
        surfaces["contact-"] = self._strip(gmsh, patches["contact"], top)
        edges = gmsh.model.getBoundary(
            [(2, tag) for tag in surfaces["pivot"]], combined=False, oriented=False
        )
        return Body(
            surfaces=surfaces,
            interfaces=self.placed_interfaces,
            size=1.05 * self.thickness,
            regions=[Region(edges, self.thickness / 2, 2 * self.thickness)],
            stacked=True,
            bolted_at=0.0,
        )

    def _strip(self, gmsh: Any, x: tuple[float, float], y: float) -> list[int]:
        """Tags of the faces at height `y` that reach along x from one end to the other, mm."""
        return faces_where(
            gmsh,
            lambda box, _: bool(
                np.allclose(box[[0, 3, 1, 4]], (*x, y, y), rtol=0, atol=1e-4 * self.thickness)
            ),
        )


def as_leaves(shape: Shape) -> LeafPack | None:
    """Return a shape that is a leaf pack; None for another."""
    return shape if isinstance(shape, LeafPack) else None
