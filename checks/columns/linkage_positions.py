"""Positions of a linkage's cycles with the forces there, many solved together."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from checks.columns.link_joints import LinkForces
from fem.frame_joints import PlacedLinks
from geometry.mesh import FloatArray, IntArray

_NUMBERS_AT_ONCE = 2**22  # of geometric stiffness: 32 MB
Place = tuple[str, int]  # cycle and position


@dataclass(frozen=True, eq=False)
class Together:
    """Positions (p,) of one cycle with the forces there.

    name       of the cycle
    forces     on its links
    positions  (p,)
    """

    name: str
    forces: LinkForces
    positions: IntArray

    @cached_property
    def placed(self) -> PlacedLinks:
        """The links as they stand in each."""
        joints = self.forces.joints
        return joints.model.placed(joints.cycle.poses[self.positions])

    @cached_property
    def geometric(self) -> FloatArray:
        """Geometric stiffness (p, n, n) of all forces."""
        return self.forces.geometric(self.placed, self.positions)

    @cached_property
    def _rows(self) -> dict[bool, FloatArray]:
        return {}

    def rows(self, *, stiff: bool) -> FloatArray:
        """All joints and the held drive (p, r, n); cases share them."""
        if stiff not in self._rows:
            joints = self.forces.joints
            self._rows[stiff] = joints.rows(self.placed, self.positions, stiff=stiff)
        return self._rows[stiff]

    @cached_property
    def places(self) -> list[Place]:
        """Cycle and position of each."""
        return [(self.name, int(k)) for k in self.positions]


def together(forces: Mapping[str, LinkForces], places: Sequence[Place]) -> Iterator[Together]:
    """Yield places by cycle in their order, so many at once as memory is meant for."""
    for name in dict.fromkeys(name for name, _ in places):
        size = forces[name].joints.model.n_unknowns
        most = max(1, _NUMBERS_AT_ONCE // size**2)
        positions = np.array([k for other, k in places if other == name])
        for first in range(0, len(positions), most):
            yield Together(name, forces[name], positions[first : first + most])
