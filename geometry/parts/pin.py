"""A pin in its stack of lugs, stepped where a lug has a smaller bore."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from geometry.mesh import Interface
from geometry.meshing import Body, Region, faces_where
from geometry.parameters import ParameterError, a_length, check_above, check_at_least
from geometry.parts._outline import Outline
from geometry.sections import Section


@dataclass(frozen=True)
class Seat:
    """Where one lug, or a pair of lugs at +-`at`, presses on the pin."""

    name: str
    at: float = a_length("distance of the lug's mid-plane from the pin's mid-plane", default=0.0)
    width: float = a_length("width of the lug on the pin")
    diameter: float | None = a_length("diameter of the pin in this lug, if stepped", default=None)

    def __post_init__(self) -> None:
        check_at_least("at", self.at, 0)
        check_above("width", self.width, 0)
        if self.diameter is not None:
            check_above("diameter", self.diameter, 0)
        if 0 < self.at < self.width / 2:
            raise ParameterError(
                "at",
                f"{self.at:g} mm: the pair of lugs at +-{self.at:g} mm overlaps itself; "
                f"it must be 0 mm or at least {self.width / 2:g} mm",
            )


@dataclass(frozen=True)
class Pin:
    """Round pin along z, mid-plane at z = 0, one interface per seat."""

    stressed_evenly: ClassVar[bool] = False
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
            step = (self.diameter - (seat.diameter or self.diameter)) / 2
            if 0 < step < self.step_fillet:
                raise ParameterError(
                    "step_fillet",
                    f"{self.step_fillet:g} mm is larger than the step of {step:g} mm at "
                    f"{seat.name!r}",
                )
        self._check_that_lugs_are_apart()

    def _check_that_lugs_are_apart(self) -> None:
        seated = self.seated()
        for (lower, _, top), (upper, bottom, _) in pairwise(seated):
            if bottom < top - 1e-9 * self.diameter:
                raise ParameterError(
                    "seats",
                    f"{lower.name!r} and {upper.name!r} overlap by {top - bottom:g} mm on the pin",
                )

    @property
    def stressed_section(self) -> tuple[float]:
        """The pin's diameter, mm, for Marin's size factor."""
        return (self.diameter,)

    @property
    def sections(self) -> tuple[Section, ...]:
        """None: a pin is bent and sheared, not compressed along its axis."""
        return ()

    def build(self, gmsh: Any) -> Body:
        """Build the pin in gmsh's current model."""
        self._outline().revolve(gmsh)
        gmsh.model.occ.synchronize()
        return self._named(gmsh)

    @property
    def total_length(self) -> float:
        """Length of the pin: outermost lug faces plus the overhangs, mm."""
        return 2 * (max(seat.at + seat.width / 2 for seat in self.seats) + self.overhang)

    def seated(self) -> list[tuple[Seat, float, float]]:
        """Every lug on the pin from bottom to top: its seat, lower and upper face, mm."""
        places = []
        for seat in self.seats:
            for sign in (-1, 1) if seat.at else (1,):
                middle = sign * seat.at
                places.append((seat, middle - seat.width / 2, middle + seat.width / 2))
        return sorted(places, key=lambda place: place[1])

    def _outline(self) -> Outline:
        radius, fillet = self.diameter / 2, self.step_fillet
        outline = Outline()
        outline.line_to(0.0, -self.total_length / 2)
        outline.line_to(radius, -self.total_length / 2)
        for seat, lower, upper in self.seated():
            neck = (seat.diameter or self.diameter) / 2
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
        outline.line_to(radius, self.total_length / 2)
        outline.line_to(0.0, self.total_length / 2)
        return outline

    def _named(self, gmsh: Any) -> Body:
        radius = self.diameter / 2
        faces: dict[str, list[int]] = {seat.name: [] for seat in self.seats}
        for seat, lower, upper in self.seated():
            faces[seat.name] += faces_where(gmsh, self._between(lower, upper))
        necks = [
            (2, tag)
            for seat in self.seats
            if (seat.diameter or self.diameter) < self.diameter
            for tag in faces[seat.name]
        ]
        edges = gmsh.model.getBoundary(necks, oriented=False) if necks else []
        steps = [(1, abs(tag)) for _, tag in edges]
        fine = self.step_fillet / 2.5 if self.step_fillet else self.diameter / 40
        return Body(
            surfaces=faces,
            interfaces=[
                Interface(
                    seat.name,
                    "journal",
                    np.zeros(3),
                    (seat.diameter or self.diameter) / 2,
                    seat.width * (2 if seat.at else 1),
                )
                for seat in self.seats
            ],
            size=radius / 2.5,
            regions=[
                Region([(2, tag) for tags in faces.values() for tag in tags], radius / 4, radius),
                *([Region(steps, fine, radius / 2)] if steps else []),
            ],
        )

    def _between(self, lower: float, upper: float) -> Callable[[Any, str], bool]:
        """Test of a face's bounding box and type: a cylinder that reaches from lower to upper z."""
        return lambda box, kind: (
            kind == "Cylinder"
            and bool(np.allclose(box[[2, 5]], (lower, upper), rtol=0, atol=1e-4 * self.diameter))
        )
