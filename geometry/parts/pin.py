"""A pin in its stack of lugs, stepped where a lug has a smaller bore."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite
from typing import Any, ClassVar

import numpy as np

from geometry.bars import RulingSection
from geometry.mesh import Interface
from geometry.parameters import (
    ParameterError,
    a_flag,
    a_length,
    check_above,
    check_at_least,
    within,
)
from geometry.parts._plates import Outline
from geometry.shape import Body, Region, Shape, faces_where

_LONGEST = 8.0  # elements over a lug's width


@dataclass(frozen=True)
class Seat:
    """Where one lug, or a pair of lugs at +-`at`, presses on the pin.

    A `single` lug stands at `at` alone, on either side of z = 0: plates mounted side by side.
    """

    name: str
    at: float = a_length("distance of the lug's mid-plane from the pin's mid-plane", default=0.0)
    width: float = a_length("width of the lug on the pin")
    diameter: float | None = a_length("diameter of the pin in this lug, if stepped", default=None)
    single: bool = a_flag("whether there is no second lug at -`at`; `at` may then be below 0")

    def __post_init__(self) -> None:
        if not isfinite(self.at):
            raise ParameterError("at", f"must be a finite length, got {self.at:g} mm")
        if not self.single:
            check_at_least("at", self.at, 0)
        check_above("width", self.width, 0)
        if self.diameter is not None:
            check_above("diameter", self.diameter, 0)
        if self.paired and not within(self.width / 2, self.at):
            raise ParameterError(
                "at",
                f"{self.at:g} mm: the pair of lugs at +-{self.at:g} mm overlaps itself; "
                f"it must be 0 mm or at least {self.width / 2:g} mm",
            )

    @property
    def paired(self) -> bool:
        """True if there are two lugs, one on either side of the pin's mid-plane."""
        return not self.single and self.at > 0

    @property
    def places(self) -> tuple[float, ...]:
        """The z of the mid-plane of each lug, mm."""
        return (-self.at, self.at) if self.paired else (self.at,)


@dataclass(frozen=True)
class Pin(Shape):
    """Round pin along z, one interface per seat; z = 0 is the mid-plane of the pairs of lugs.

    Where lugs sit on one side only, the pin is not in balance by forces alone: then it also carries
    couples out of the linkage's plane.
    """

    name: ClassVar[str] = "pin"
    interfaces: ClassVar[tuple[str, ...]] = ()  # the names of the seats

    seats: tuple[Seat, ...]
    diameter: float = a_length("diameter of the pin")
    step_fillet: float = a_length("radius at a step of the pin; 0 is a sharp edge", default=0.0)
    overhang: float = a_length("length of the pin beyond the outermost lug", default=5.0)

    def __post_init__(self) -> None:
        check_above("diameter", self.diameter, 0)
        check_at_least("overhang", self.overhang, 0)
        check_at_least("step_fillet", self.step_fillet, 0)
        if not self.seats:
            raise ParameterError("seats", "a pin needs at least one lug")
        names = [seat.name for seat in self.seats]
        for name in names:
            if names.count(name) > 1:
                raise ParameterError("seats", f"{name!r} is there twice")
        for seat in self.seats:
            if seat.diameter is not None and seat.diameter > self.diameter:
                raise ParameterError(
                    "seats",
                    f"{seat.name!r}: a neck of {seat.diameter:g} mm is thicker than the pin of "
                    f"{self.diameter:g} mm",
                )
            step = (self.diameter - self.neck(seat)) / 2
            if 0 < step < self.step_fillet:
                raise ParameterError(
                    "step_fillet",
                    f"{self.step_fillet:g} mm is larger than the step of {step:g} mm at "
                    f"{seat.name!r}",
                )
        self._check_that_lugs_are_apart()
        self._check_that_fillets_have_room()

    def _check_that_lugs_are_apart(self) -> None:
        seated = self.seated()
        for (lower, _, top), (upper, bottom, _) in pairwise(seated):
            if bottom < top - 1e-9 * self.diameter:
                raise ParameterError(
                    "seats",
                    f"{lower.name!r} and {upper.name!r} overlap by {top - bottom:g} mm on the pin",
                )

    def _check_that_fillets_have_room(self) -> None:
        """A fillet stands beyond its lug: not in the next one, nor beyond the pin's end."""
        seated = self.seated()
        taken = [
            self.step_fillet if self.neck(seat) < self.diameter else 0.0 for seat, _, _ in seated
        ]
        if max(taken[0], taken[-1]) > self.overhang:
            raise ParameterError(
                "overhang",
                f"{self.overhang:g} mm does not hold the fillet of {self.step_fillet:g} mm",
            )
        gaps = [upper[1] - lower[2] for lower, upper in pairwise(seated)]
        for index, gap in enumerate(gaps):
            wanted = taken[index] + taken[index + 1]
            if gap < wanted - 1e-9 * self.diameter:
                raise ParameterError(
                    "step_fillet",
                    f"{self.step_fillet:g} mm: between {seated[index][0].name!r} and "
                    f"{seated[index + 1][0].name!r} there are {gap:g} mm for {wanted:g} mm of "
                    "fillets",
                )

    @property
    def stressed_section(self) -> tuple[float]:
        """The pin's diameter, mm, for Marin's size factor."""
        return (self.diameter,)

    @property
    def proportions(self) -> Mapping[str, float]:
        """Lugs, gaps, necks and fillets over the diameter."""
        seated = self.seated()
        gaps = [upper[1] - lower[2] for lower, upper in pairwise(seated)]
        widths = [high - low for _, low, high in seated]
        neck = min(self.neck(seat) for seat in self.seats)
        scales = {
            "lug width / diameter": min(widths) / self.diameter,
            "widest lug / diameter": max(widths) / self.diameter,
            "gap / diameter": max([*gaps, 0.0]) / self.diameter,
            "neck / diameter": neck / self.diameter,
        }
        return scales | ({"fillet / neck": self.step_fillet / neck} if self.necked else {})

    @property
    def ruling_sections(self) -> tuple[RulingSection, ...]:
        """Sizes that grade the strength of its material."""
        return (RulingSection(self.diameter, round=True),)

    @property
    def placed_interfaces(self) -> list[Interface]:
        """Where other parts press on it."""
        tilts = any(seat.single for seat in self.seats)
        return [
            Interface(
                seat.name,
                "journal",
                np.array([0.0, 0.0, seat.at if seat.single else 0.0]),
                self.neck(seat) / 2,
                seat.width * len(seat.places),
                tilts=tilts,
            )
            for seat in self.seats
        ]

    def build(self, gmsh: Any) -> Body:
        """Build the pin in gmsh's current model."""
        self._outline().revolve(gmsh)
        gmsh.model.occ.synchronize()
        return self._named(gmsh)

    @property
    def ends(self) -> tuple[float, float]:
        """The z of the pin's lower and upper end: outermost lug faces plus the overhangs, mm."""
        seated = self.seated()
        lowest = min(lower for _, lower, _ in seated)
        highest = max(upper for _, _, upper in seated)
        return lowest - self.overhang, highest + self.overhang

    def neck(self, seat: Seat) -> float:
        """Diameter of the pin in a seat, mm."""
        return self.diameter if seat.diameter is None else seat.diameter

    @property
    def necked(self) -> bool:
        """True if the pin is thinner in one of its lugs."""
        return any(self.neck(seat) < self.diameter for seat in self.seats)

    @property
    def narrow(self) -> list[Seat]:
        """Lugs so narrow that they need smaller elements than the pin."""
        return [seat for seat in self.seats if _LONGEST * seat.width < self.diameter / 8]

    @property
    def heights(self) -> Mapping[str, float]:
        """Height z, mm, of single lugs that are not in the middle plane."""
        return {seat.name: seat.at for seat in self.seats if seat.single and seat.at}

    @property
    def length(self) -> float:
        """Length of the pin, mm."""
        lower, upper = self.ends
        return upper - lower

    def seated(self) -> list[tuple[Seat, float, float]]:
        """Every lug on the pin from bottom to top: its seat, lower and upper face, mm."""
        places = []
        for seat in self.seats:
            for middle in seat.places:
                places.append((seat, middle - seat.width / 2, middle + seat.width / 2))
        return sorted(places, key=lambda place: place[1])

    def _outline(self) -> Outline:
        radius, fillet = self.diameter / 2, self.step_fillet
        outline = Outline()
        lowest, highest = self.ends
        outline.line_to(0.0, lowest)
        outline.line_to(radius, lowest)
        for seat, lower, upper in self.seated():
            neck = self.neck(seat) / 2
            if neck < radius:
                outline.line_to(radius, lower - fillet)
                outline.line_to(neck + fillet, lower - fillet)
                outline.arc_to(neck, lower, (neck + fillet, lower))
                outline.line_to(neck, upper)
                outline.arc_to(neck + fillet, upper + fillet, (neck + fillet, upper))
                outline.line_to(radius, upper + fillet)
            else:
                outline.line_to(radius, lower)
                outline.line_to(radius, upper)
        outline.line_to(radius, highest)
        outline.line_to(0.0, highest)
        return outline

    def _named(self, gmsh: Any) -> Body:
        radius = self.diameter / 2
        faces: dict[str, list[int]] = {seat.name: [] for seat in self.seats}
        for seat, lower, upper in self.seated():
            faces[seat.name] += faces_where(gmsh, self._between(lower, upper))
        necks = [
            (2, tag)
            for seat in self.seats
            if self.neck(seat) < self.diameter
            for tag in faces[seat.name]
        ]
        edges = gmsh.model.getBoundary(necks, oriented=False) if necks else []
        steps = [(1, abs(tag)) for _, tag in edges]
        fine = self.step_fillet / 2.5 if self.step_fillet else self.diameter / 40
        return Body(
            surfaces=faces,
            interfaces=self.placed_interfaces,
            size=radius / 2.5,
            regions=[
                Region([(2, tag) for tags in faces.values() for tag in tags], radius / 4, radius),
                *self._narrow(gmsh, faces),
                *([Region(steps, fine, radius / 2)] if steps else []),
            ],
        )

    def _narrow(self, gmsh: Any, faces: Mapping[str, list[int]]) -> Iterator[Region]:
        """Edges of lugs so narrow that elements of the pin's size would fold there."""
        for seat in self.narrow:
            edges = gmsh.model.getBoundary([(2, tag) for tag in faces[seat.name]], False, False)
            lines = [(1, abs(tag)) for _, tag in edges]
            yield Region(lines, _LONGEST * seat.width, self.diameter / 2)

    def _between(self, lower: float, upper: float) -> Callable[[Any, str], bool]:
        """Test of a face's bounding box and type: a cylinder that reaches from lower to upper z."""
        return lambda box, kind: (
            kind == "Cylinder"
            and bool(np.allclose(box[[2, 5]], (lower, upper), rtol=0, atol=1e-4 * self.diameter))
        )


def as_pin(shape: Shape) -> Pin | None:
    """Return a shape that is a pin, the part of a joint; None for one of a body."""
    return shape if isinstance(shape, Pin) else None
