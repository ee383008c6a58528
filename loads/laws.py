"""Laws of given forces: constant, a table, a formula, against the motion, or a contact."""

from dataclasses import dataclass
from itertools import pairwise
from math import isfinite

from loads.bodies import LinkageError
from loads.expressions import Expression
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
    restitution  speed after over speed before a blow; None: not known. Blows alone know it.
    """

    at: float
    stiffness: float | None = None
    side: int = 1
    stops: bool = True
    restitution: float | None = None

    def __post_init__(self) -> None:
        if not isfinite(self.at):
            raise LinkageError(f"a contact must be at a finite value, got {self.at:g}")
        if self.stiffness is not None and not (isfinite(self.stiffness) and self.stiffness > 0.0):
            raise LinkageError(f"the stiffness of a contact must be above 0, got {self.stiffness}")
        if self.side not in (1, -1):
            raise LinkageError(f"the side of a contact must be 1 or -1, got {self.side}")
        if self.restitution is not None and not 0.0 <= self.restitution <= 1.0:
            raise LinkageError(f"restitution goes from 0 to 1, got {self.restitution:g}")


@dataclass(frozen=True)
class Opposing:
    """A force against the rate of its own coordinate: dry, viscous, or along a table.

    dry      N (N mm), at any speed
    viscous  N s/mm (N mm s/rad), times the speed, besides
    speeds   mm/s (rad/s), rising from 0: instead of both, linear between; it must cover the motion
    forces   N (N mm), one for each speed

    It jumps where the coordinate reverses: `split_at_reversals` makes that the border of a phase.
    """

    dry: float = 0.0
    viscous: float = 0.0
    speeds: tuple[float, ...] = ()
    forces: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        sizes = (self.dry, self.viscous, *self.forces)
        if not all(isfinite(size) and size >= 0.0 for size in sizes):
            raise LinkageError(f"a force against the motion must be 0 or above, got {min(sizes):g}")
        if not self.speeds and not self.forces:
            return
        if self.dry or self.viscous:
            raise LinkageError("a table over the speed stands alone, without dry and viscous")
        if len(self.speeds) < 2 or len(self.speeds) != len(self.forces):
            raise LinkageError(
                "a table over the speed needs as many forces as speeds and at least two, got "
                f"{len(self.speeds)} speeds and {len(self.forces)} forces"
            )
        if self.speeds[0] != 0.0 or not isfinite(self.speeds[-1]):
            raise LinkageError(f"the speeds of a table must begin at 0, got {self.speeds[0]:g}")
        for before, after in pairwise(self.speeds):
            if after <= before:
                raise LinkageError(f"the speeds of a table must rise: {before:g}, then {after:g}")


Law = float | Table | Expression | Opposing | Contact
