"""Loads on a plate with any number of pins, in balance, and the section forces that they make.

Section forces are per unit of what acts on it. Across any section that parts a plate in two, force
and couple are those of all that acts on one part: of its pins, and d'Alembert's of its mass,
-(a + alpha k x r - omega2 r) dm. No line of bars is assumed. Where the loads were computed with
another mass than the plate's, a rigid acceleration makes up for the rest, as in a solid.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from checks.design.data import Part
from checks.part.part_loads import PartLoads
from geometry.mesh import FloatArray
from geometry.outlines import Cut, Moments
from geometry.parts.plate import Plate


@dataclass(frozen=True, eq=False)
class FlatSection:
    """A straight section of a plate: where it has material, mm along i `along` from its point."""

    cut: Cut
    thickness: float

    @property
    def area(self) -> float:
        """Area, mm2."""
        return float(np.diff(self.cut.spans, axis=1).sum()) * self.thickness

    @property
    def middle(self) -> float:
        """Place of its centroid, mm."""
        return float(np.diff(self.cut.spans**2, axis=1).sum()) / 2 * self.thickness / self.area

    @property
    def inertia(self) -> float:
        """Second moment of area about the centroid, mm4."""
        about = float(np.diff(self.cut.spans**3, axis=1).sum()) / 3 * self.thickness
        return about - self.area * self.middle**2

    @property
    def centroid(self) -> complex:
        """The centroid's place in the plate, mm."""
        return self.cut.point + 1j * self.cut.along * self.middle

    def filled(self) -> "FlatSection":
        """The section with its holes filled."""
        spans = np.array([[self.cut.ends[0], self.cut.ends[1]]])
        cut = Cut(self.cut.point, self.cut.along, spans, self.cut.ahead, self.cut.boundary)
        return FlatSection(cut, self.thickness)


class PlateLoads:
    """All that acts on a plate, in balance: accelerations, then the wrench of every bore."""

    def __init__(self, part: Part, shape: Plate, loads: PartLoads) -> None:
        self.shape, self.loads = shape, loads
        self._mass = part.material.density * shape.thickness
        self.names = shape.interfaces
        self._columns = 4 + 6 * len(self.names)
        acting = np.concatenate(
            [loads.accelerations, *(loads.wrenches[name] for name in self.names)], axis=1
        ).T
        whole = self._resultant(shape.outline.moments, dict.fromkeys(self.names, 1.0))
        left = whole @ acting
        acting[:3] -= np.linalg.solve(whole[:, :3], left)
        self.acting = acting

    def _resultant(self, mass: Moments, ahead: Mapping[str, float]) -> FloatArray:
        """Force along x and y and couple about the origin (3, columns) of a part of the plate.

        ahead  bore -> share of its wrench that acts on this part
        """
        found = np.zeros((3, self._columns))
        area, (x, y), (xx, _, yy) = mass.area, mass.first, mass.second
        found[:, 0] = -area, 0.0, y
        found[:, 1] = 0.0, -area, -x
        found[:, 2] = y, -x, -(xx + yy)
        found[:, 3] = x, y, 0.0
        found *= self._mass
        for k, bore in enumerate(self.shape.bores):
            share, at = ahead.get(bore.name, 0.0), 4 + 6 * k
            found[0, at] = found[1, at + 1] = found[2, at + 5] = share
            found[2, at] = -share * bore.centre.imag
            found[2, at + 1] = share * bore.centre.real
        return found

    def across(self, section: FlatSection, ahead: Mapping[str, float]) -> FloatArray:
        """Force along, force across and couple about the centroid (3, columns) of a section.

        They are what the part ahead exerts on the other one; `ahead` as it says how much of every
        bore's wrench acts on the part ahead.
        """
        x, y, couple = self._resultant(section.cut.ahead, ahead)
        along, at = section.cut.along, section.centroid
        moment = couple - (at.real * y - at.imag * x)
        return np.stack([along.real * x + along.imag * y, -along.imag * x + along.real * y, moment])

    def is_ahead(self, section: FlatSection) -> dict[str, float]:
        """Bores whose middle lies ahead of a section, with the share 1."""
        return {bore.name: 1.0 for bore in self.shape.bores if section.cut.is_ahead(bore.centre)}

    def met(self, section: FlatSection) -> list[str]:
        """Bores that a section goes through."""
        low, high = section.cut.ends
        found = []
        for bore in self.shape.bores:
            arm = (bore.centre - section.cut.point) * np.conj(section.cut.along)
            if abs(arm.real) < bore.diameter / 2 and low < arm.imag < high:
                found.append(bore.name)
        return found
