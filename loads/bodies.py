"""Rigid bodies, their named points, and the error of a linkage that cannot work."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from math import isfinite
from typing import Self

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
Vector = tuple[float, float]
Pose = tuple[float, float, float]

GROUND = "ground"


class LinkageError(ValueError):
    """A linkage, or a cycle of it, that cannot be computed as stated."""


def nearest(name: str, known: Iterable[str]) -> str:
    """Return the end of an error message about an unknown name: the nearest right one, or all."""
    names = sorted(known)
    close = get_close_matches(name, names, n=1, cutoff=0.5)
    if close:
        return f"did you mean {close[0]!r}?"
    return f"known are {', '.join(names)}" if names else "none is known"


@dataclass(frozen=True)
class Body:
    """A rigid body with named points, all in its own frame.

    The body named ``ground`` is the frame of the machine: it does not move and has no mass.

    points   mm, of the body frame, by name
    mass     tonne (or the unit that goes with the other units)
    inertia  tonne mm2, about the centre of mass
    centre   mm, centre of mass in the body frame
    """

    name: str
    points: Mapping[str, Vector] = field(default_factory=dict)
    mass: float = 0.0
    inertia: float = 0.0
    centre: Vector = (0.0, 0.0)

    def __post_init__(self) -> None:
        if not self.name:
            raise LinkageError("a body has no name")
        for quantity, value in (("mass", self.mass), ("inertia", self.inertia)):
            if not (isfinite(value) and value >= 0.0):
                raise LinkageError(
                    f"body {self.name!r}: {quantity} must be 0 or above, got {value:g}"
                )
        if self.name == GROUND and (self.mass or self.inertia):
            raise LinkageError("body 'ground' does not move and takes no mass or inertia")
        for point, place in (*self.points.items(), ("centre", self.centre)):
            if len(place) != 2 or not all(isfinite(value) for value in place):
                raise LinkageError(
                    f"body {self.name!r}: point {point!r} must be two numbers, got {place}"
                )

    def place(self, point: str) -> Vector:
        """Return where a named point is in the body frame."""
        if point not in self.points:
            raise LinkageError(
                f"body {self.name!r} has no point {point!r}; {nearest(point, self.points)}"
            )
        return self.points[point]

    def with_mass_properties(self, mass: float, centre: Vector, inertia: float) -> Self:
        """Return the same body with other mass properties (inertia about the centre)."""
        return replace(self, mass=mass, centre=centre, inertia=inertia)
