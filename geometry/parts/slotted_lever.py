"""A lever with a slot in which a block or pin slides, as in quick-return drives."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi
from typing import Any, ClassVar

import numpy as np

from geometry.bars import RulingSection
from geometry.mesh import Interface
from geometry.parameters import (
    GIVEN_BY_LINKAGE,
    ParameterError,
    a_length,
    check_above,
    check_at_least,
    check_below,
    within,
)
from geometry.parts._plates import bore_at, drill, stadium
from geometry.shape import Body, Ligament, Region, Shape, faces_where

_EDGES = ((1.0, ">"), (-1.0, "<"))


@dataclass(frozen=True)
class SlottedLever(Shape):
    """Flat plate along x; holes along z at x = 0 (interface "pivot") and x = `length` ("tip").

    Between them a block or pin slides in a slot ("slot"): a force along +y presses on the flank at
    y > 0. The tip may be made thicker by a round boss on either side.
    """

    name: ClassVar[str] = "slotted_lever"
    middle_plane: ClassVar[bool] = True
    interfaces: ClassVar[tuple[str, ...]] = ("pivot", "tip", "slot")

    length: float = a_length(
        "distance between the axes of pivot and tip", given_by=GIVEN_BY_LINKAGE
    )
    width: float = a_length("width of the plate, in the linkage's plane")
    thickness: float = a_length("thickness of the plate")
    hole: float = a_length("diameter of the holes at pivot and tip")
    slot_width: float = a_length("width of the slot, whose ends are half round")
    slot_from: float = a_length("distance of the slot's near end from the pivot")
    slot_to: float = a_length("distance of the slot's far end from the pivot")
    overhang: float | None = a_length(
        "from each axis to the plate's square ends; without it the ends are half round",
        default=None,
    )
    boss_diameter: float | None = a_length("diameter of the boss at the tip, if any", default=None)
    boss_height: float = a_length("height of the boss on each side of the plate", default=0.0)
    boss_fillet: float = a_length("radius where the boss meets the plate", default=0.0)
    contact_length: float | None = a_length(
        "length on which block or pin presses; without it the slot's width", default=None
    )
    travel_from: float | None = a_length(
        "distance of the contact from the pivot at its nearest; without it where the contact "
        "reaches the round end",
        default=None,
    )
    travel_to: float | None = a_length(
        "distance of the contact from the pivot at its farthest; without it where the contact "
        "reaches the round end",
        default=None,
    )

    def __post_init__(self) -> None:
        for name in ("length", "width", "thickness", "hole", "slot_width"):
            check_above(name, getattr(self, name), 0)
        check_below("hole", self.hole, self.width, "the width of the plate")
        check_below("slot_width", self.slot_width, self.width, "the width of the plate")
        if self.overhang is not None:
            check_above("overhang", self.overhang, self.hole / 2)
        self._check_slot()
        self._check_boss()
        self._check_contact()

    def _check_slot(self) -> None:
        check_above("slot_from", self.slot_from, self.hole / 2)
        end = self.length - self.hole / 2
        check_below("slot_to", self.slot_to, end, "where the hole at the tip begins")
        check_above("slot_to", self.slot_to, self.slot_from + self.slot_width)

    def _check_boss(self) -> None:
        check_at_least("boss_height", self.boss_height, 0)
        check_at_least("boss_fillet", self.boss_fillet, 0)
        if self.boss_diameter is None:
            for name in ("boss_height", "boss_fillet"):
                if getattr(self, name) > 0:
                    raise ParameterError(name, "there is no boss: state boss_diameter too")
            return
        check_above("boss_diameter", self.boss_diameter, self.hole)
        check_above("boss_height", self.boss_height, 0)
        check_below("boss_fillet", self.boss_fillet, self.boss_height, "the boss's height")
        foot = self.boss_diameter / 2 + self.boss_fillet
        flank_end = self.slot_to - self.slot_width / 2
        if not foot < min(self.width / 2, self.beyond):
            raise ParameterError(
                "boss_diameter",
                f"{self.boss_diameter:g} mm with its fillet reaches beyond the plate; it must be "
                f"below {2 * (min(self.width / 2, self.beyond) - self.boss_fillet):g} mm",
            )
        if not within(flank_end, self.length - foot):
            raise ParameterError(
                "boss_diameter",
                f"{self.boss_diameter:g} mm with its fillet stands on the slot's straight flanks; "
                f"it must be at most {2 * (self.length - flank_end - self.boss_fillet):g} mm",
            )

    def _check_contact(self) -> None:
        if self.contact_length is not None:
            check_above("contact_length", self.contact_length, 0)
        half = self._patch
        first, last = self._flank
        nearest, farthest = self._travel
        if not within(first + half, nearest):
            raise ParameterError(
                "travel_from",
                f"{nearest:g} mm: the contact runs into the slot's round end; it must be at least "
                f"{first + half:g} mm",
            )
        if not within(farthest, last - half):
            raise ParameterError(
                "travel_to",
                f"{farthest:g} mm: the contact runs into the slot's round end; it must be at most "
                f"{last - half:g} mm",
            )
        if not nearest < farthest:
            where = "contact_length" if self.travel_from is self.travel_to is None else "travel_to"
            raise ParameterError(
                where, f"leaves the contact no way to slide: from {nearest:g} to {farthest:g} mm"
            )

    @property
    def beyond(self) -> float:
        """Overhang of the plate beyond its axes, mm."""
        return self.width / 2 if self.overhang is None else self.overhang

    @property
    def _patch(self) -> float:
        """Half the length on which the contact presses, mm."""
        return (self.slot_width if self.contact_length is None else self.contact_length) / 2

    @property
    def _flank(self) -> tuple[float, float]:
        """First and last x of the slot's straight part, mm."""
        return self.slot_from + self.slot_width / 2, self.slot_to - self.slot_width / 2

    @property
    def _travel(self) -> tuple[float, float]:
        """First and last x of the contact, mm."""
        first, last = self._flank
        return (
            first + self._patch if self.travel_from is None else self.travel_from,
            last - self._patch if self.travel_to is None else self.travel_to,
        )

    @property
    def stressed_section(self) -> tuple[float, float]:
        """The plate, width and thickness in mm, for Marin's size factor."""
        return (self.width, self.thickness)

    @property
    def proportions(self) -> Mapping[str, float]:
        """Rails, slot, ligaments and boss over width, hole and thickness."""
        rail = (self.width - self.slot_width) / 2
        near = self.slot_from - self.hole / 2
        far = self.length - self.slot_to - self.hole / 2
        return {
            "hole / width": self.hole / self.width,
            "slot / width": self.slot_width / self.width,
            "rail / slot length": rail / (self.slot_to - self.slot_from),
            "thickness / rail": self.thickness / rail,
            "boss height / thickness": self.boss_height / self.thickness,
            "pivot's ligament / hole": near / self.hole,
            "tip's ligament / hole": far / self.hole,
            "length / width": self.length / self.width,
        }

    def ligaments(self, interface: str) -> Sequence[Ligament]:
        """The plate behind a hole, on its other side up to the slot, and beside it; without a boss.

        Square ends, whose material is no less than in proportion, bear what points to each side.
        """
        direction, end = self.outward(interface)
        inner = self.slot_from if interface == "pivot" else self.length - self.slot_to
        behind, before, beside = (
            self.thickness * (reach - self.hole / 2)
            for reach in (self.beyond, inner, self.width / 2)
        )
        return [
            Ligament(direction, behind, end, round=float(self.overhang is None)),
            Ligament((-direction[0], 0.0), before, "the slot"),
            *(Ligament((0.0, y), beside, f"the edge at y {sign} 0") for y, sign in _EDGES),
        ]

    @property
    def told(self) -> Sequence[str]:
        """A check that it does not have: a sentence for the report."""
        return [
            "no column formula judged it, so yield was not checked by one: a force acts between "
            "its pins"
        ]

    @property
    def ruling_sections(self) -> tuple[RulingSection, ...]:
        """Sizes that grade the strength of its material."""
        return (RulingSection(self.thickness + 2 * self.boss_height),)

    @property
    def placed_interfaces(self) -> list[Interface]:
        """Where other parts press on it."""
        depths = {"pivot": self.thickness, "tip": self.thickness + 2 * self.boss_height}
        bores = [
            Interface(
                name, "bore", np.array([x, 0.0, 0.0]), self.hole / 2, depths[name], tilts=True
            )
            for name, x in self.pin_places.items()
        ]
        slot = Interface(
            "slot",
            "slide",
            np.zeros(3),
            length=self.thickness,
            travel=self._travel,
            patch=self._patch,
        )
        return [*bores, slot]

    def build(self, gmsh: Any) -> Body:
        """Build the lever in gmsh's current model."""
        occ = gmsh.model.occ
        solid = self._plate(gmsh)
        if self.boss_diameter is not None:
            solid = self._with_boss(gmsh, solid, self.boss_diameter)
        depth = self.thickness + 2 * self.boss_height
        tools = [drill(gmsh, x, self.hole, depth) for x in (0.0, self.length)]
        slot = stadium(gmsh, self.slot_from, self.slot_to, self.slot_width, 2 * depth)
        occ.cut([(3, solid)], [*tools, (3, slot)])
        occ.synchronize()
        return self.named(gmsh)

    def _plate(self, gmsh: Any) -> int:
        if self.overhang is None:
            half = self.width / 2
            return stadium(gmsh, -half, self.length + half, self.width, self.thickness)
        start, total = -self.overhang, self.length + 2 * self.overhang
        low = -self.thickness / 2
        box = gmsh.model.occ.addBox(start, -self.width / 2, low, total, self.width, self.thickness)
        return int(box)

    def _with_boss(self, gmsh: Any, plate: int, diameter: float) -> int:
        occ = gmsh.model.occ
        low, height = self.thickness / 2 + self.boss_height, self.thickness + 2 * self.boss_height
        boss = occ.addCylinder(self.length, 0, -low, 0, 0, height, diameter / 2)
        solids, _ = occ.fuse([(3, plate)], [(3, boss)])
        solid = int(solids[0][1])
        if not self.boss_fillet:
            return solid
        occ.synchronize()
        feet = []
        for _, tag in gmsh.model.getEntities(1):
            box = np.array(gmsh.model.getBoundingBox(1, tag))
            radius, z = (box[3] - box[0]) / 2, box[[2, 5]]
            flat = np.allclose(np.abs(z), self.thickness / 2, rtol=0, atol=1e-4 * self.thickness)
            if flat and np.isclose(radius, diameter / 2) and gmsh.model.getType(1, tag) == "Circle":
                feet.append(tag)
        rounded = occ.fillet([solid], feet, [self.boss_fillet])
        return int(rounded[0][1])

    def named(self, gmsh: Any) -> Body:
        """Return the body of the model, of the whole part or its half at z >= 0."""
        bores = {name: bore_at(gmsh, x, self.hole) for name, x in self.pin_places.items()}
        flanks = {f"slot{sign}": self._flank_at(gmsh, y) for sign, y in self._sides().items()}
        ends = faces_where(
            gmsh,
            lambda box, kind: (
                kind == "Cylinder"
                and bool(np.isclose(box[4] - box[1], self.slot_width, rtol=1e-4))
                and self.slot_from - 1 < box[0]
                and box[3] < self.slot_to + 1
            ),
        )
        feet = faces_where(gmsh, lambda _, kind: kind == "Torus")
        fine = [(2, tag) for tags in (*bores.values(), ends) for tag in tags]
        return Body(
            surfaces={**bores, **flanks},
            interfaces=self.placed_interfaces,
            size=min(self.thickness / 2, (self.width - self.slot_width) / 4),
            regions=[
                Region(fine, pi * min(self.hole, self.slot_width) / 40, self.hole / 2),
                *self._at_feet(feet),
            ],
        )

    def _at_feet(self, feet: list[int]) -> list[Region]:
        size = self.boss_fillet / 1.5
        return [Region([(2, tag) for tag in feet], size, 2 * size)] if feet else []

    def _sides(self) -> dict[str, float]:
        """The y of the flank on which a force of either sign presses, mm."""
        return {"+": self.slot_width / 2, "-": -self.slot_width / 2}

    def _flank_at(self, gmsh: Any, y: float) -> list[int]:
        wanted = (*self._flank, y, y)
        return faces_where(
            gmsh,
            lambda box, kind: (
                kind == "Plane"
                and bool(
                    np.allclose(box[[0, 3, 1, 4]], wanted, rtol=0, atol=1e-4 * self.slot_width)
                )
            ),
        )
