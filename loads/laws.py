"""Laws of given forces: constant, along a table, or as a contact that pushes back."""

from dataclasses import dataclass
from itertools import pairwise
from math import isfinite

from loads.bodies import LinkageError
from loads.joints import Coordinate


@dataclass(frozen=True)
class Table:
    """A force tabled over a coordinate, linear between the points; it must cover the phase.

    values  mm or rad of the coordinate, rising
    forces  N or N mm, one for each value
    """

    coordinate: Coordinate
    values: tuple[float, ...]
    forces: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.values) < 2 or len(self.values) != len(self.forces):
            raise LinkageError(
                "a table needs as many forces as values and at least two, got "
                f"{len(self.values)} values and {len(self.forces)} forces"
            )
        if not all(isfinite(number) for number in (*self.values, *self.forces)):
            raise LinkageError("a table holds finite numbers only")
        for before, after in pairwise(self.values):
            if after <= before:
                raise LinkageError(f"the values of a table must rise: {before:g}, then {after:g}")


@dataclass(frozen=True)
class Contact:
    """A one-sided spring along the force's own coordinate: it pushes, and never pulls.

    at         mm or rad, value of the force's coordinate where an undeformed linkage touches
    stiffness  N/mm (N mm/rad) of what is touched; None is rigid, then the linkage must be elastic
    side       1: touches below `at` and pushes the coordinate up; -1: above, and down
    stops      the body that is pushed follows the contact while it touches: stopped by a rigid one,
               slowed by one that gives way less than the linkage. Only a body that slides can be.
    """

    at: float
    stiffness: float | None = None
    side: int = 1
    stops: bool = True

    def __post_init__(self) -> None:
        if not isfinite(self.at):
            raise LinkageError(f"a contact must be at a finite value, got {self.at:g}")
        if self.stiffness is not None and not (isfinite(self.stiffness) and self.stiffness > 0.0):
            raise LinkageError(f"the stiffness of a contact must be above 0, got {self.stiffness}")
        if self.side not in (1, -1):
            raise LinkageError(f"the side of a contact must be 1 or -1, got {self.side}")


Law = float | Table | Contact
