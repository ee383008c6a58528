"""Elastic buckling and deflection of a plate with pins, as a bar along its bores laid straight.

Section forces of a plate with any number of pins are per unit of what acts on it. Across any
section that parts a plate in two, force and couple are those of all that acts on one part: of its
pins, and d'Alembert's of its mass, -(a + alpha k x r - omega2 r) dm. No line of bars is assumed.
Where the loads were computed with another mass than the plate's, a rigid acceleration makes up for
the rest, as in a solid.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from checks.design.data import Part
from checks.handbook.bar_forces import deflection
from checks.handbook.column_curves import column_force, lateral_share
from checks.models.formula_bars import HARDLY, PRESSED, column_items
from checks.models.formula_points import Points, acceleration_units, wrench_units
from checks.part.part_loads import PartLoads, first_largest
from checks.result.derivation import Item
from checks.stress.stress_result import ElasticLoad
from geometry.bars import rectangle_torsion
from geometry.mesh import FloatArray
from geometry.outlines import Cut, Moments
from geometry.parts.plate import Plate

_STATIONS = 33
_IN_PLANE = "in plane: Euler's column along its bores, under the largest compression of its arms"
_SIDEWAYS = "out of plane: Euler's column and lateral buckling of the arms, laid straight"


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


class PlateForces:
    """Loads on a plate, as columns of a model's points, and the section forces they make."""

    def __init__(self, part: Part, shape: Plate, loads: PartLoads, points: Points) -> None:
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
        units = acceleration_units() + [unit for name in self.names for unit in wrench_units(name)]
        self.columns = points.columns(acting, units)

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

    @cached_property
    def residual(self) -> float:
        """Couples out of the plane that no bore holds, over the largest force times the length."""
        largest = self.loads.largest_force * self.shape.length
        couples = sum(self.loads.wrenches[name][:, 3:5] for name in self.names)
        return float(np.abs(couples).max()) / largest if largest else 0.0


def elastic_load(part: Part, forces: PlateForces) -> ElasticLoad | None:
    """Largest share of the elastic buckling load over the positions.

    The plate is a bar along the longest way from bore to bore, laid straight, hinged at both ends;
    what holds it at bores between is left out, and its largest compression acts all along it.
    """
    way = _along(forces)
    if way is None:
        return None
    length = way.length
    young, ratio = part.material.youngs_modulus, part.material.poisson_ratio
    flat, across = young * way.flat, young * way.across
    twisting = young / (2 * (1 + ratio)) * way.torsion
    force = (-(way.axial @ forces.acting)).max(axis=0)
    moments = way.moment @ forces.acting
    largest = forces.loads.largest_force
    pulled = bool(force.max() <= HARDLY * largest)
    force = np.maximum(force, 0.0)
    shares = {
        _IN_PLANE: force / column_force(flat, np.inf, length),
        _SIDEWAYS: lateral_share(
            force / column_force(across, np.inf, way.pressed), moments, across, twisting, length
        ),
    }
    words = max(shares, key=lambda name: float(shares[name].max()))
    share = np.maximum(shares[words], 0.0)
    (position,) = first_largest(share)
    pressed = float(force[position])
    explain: Callable[[], Sequence[Item]]
    if words == _IN_PLANE:
        explain = partial(column_items, pressed, flat, np.inf, length)
    else:
        bent = moments[:, [position]]
        alone = float(lateral_share(np.zeros(1), bent, across, twisting, length)[0])
        explain = partial(column_items, pressed, across, np.inf, way.pressed, alone)
    return ElasticLoad(float(share[position]), position, words, explain, pulled=pulled)


def deflected(part: Part, forces: PlateForces) -> float:
    """Largest displacement in the plane, mm: off the chord of the ends of the bores' way."""
    way = _along(forces)
    if way is None:
        return np.inf
    young = part.material.youngs_modulus
    places = np.linspace(0.0, way.length, _STATIONS)
    moments = way.moment @ forces.acting
    chosen = np.unique(np.abs(moments).argmax(axis=1))
    off = deflection(moments[:, chosen], young * way.flat, places)
    along = np.abs(way.axial @ forces.acting) / way.area[:, None] / young
    return float(max(np.abs(off).max(), along.mean(axis=0).max() * way.length))


@dataclass(frozen=True, eq=False)
class _Way:
    """The bar along the bores' longest way, at even places (k,).

    length          mm
    pressed         mm, between where the pins at both ends press as they push
    area            (k,) mm2
    flat, across    (k,) mm4, bending in the plane and out of it
    torsion         (k,) mm4, Saint-Venant's
    axial, moment   (k, columns) N and N mm per unit of what acts
    """

    length: float
    pressed: float
    area: FloatArray
    flat: FloatArray
    across: FloatArray
    torsion: FloatArray
    axial: FloatArray
    moment: FloatArray


def _along(forces: PlateForces) -> _Way | None:
    """The bar; None where the way leaves the plate."""
    shape = forces.shape
    way = [shape.bores[k] for k in shape.longest_way]
    corners = np.array([bore.centre for bore in way])
    reached = np.r_[0.0, np.cumsum(np.abs(np.diff(corners)))]
    rows = []
    for place in np.linspace(0.0, reached[-1], _STATIONS):
        k = int(np.clip(np.searchsorted(reached, place) - 1, 0, len(way) - 2))
        low, high, arm = way[k], way[k + 1], float(reached[k + 1] - reached[k])
        along = complex(corners[k + 1] - corners[k]) / arm
        inside = np.clip(place - reached[k], low.diameter / 2, arm - high.diameter / 2)
        cut = shape.outline.cut(low.centre + along * float(inside), along)
        if cut is None:
            return None
        section = FlatSection(cut, shape.thickness).filled()
        ahead = {shape.bores[n].name: 1.0 for n in shape.beyond(low, high)}
        axial, _, moment = forces.across(section, ahead)
        height = cut.ends[1] - cut.ends[0]
        torsion = float(rectangle_torsion(height, shape.thickness)[0])
        across = height * shape.thickness**3 / 12
        rows.append((section.area, section.inertia, across, torsion, axial, moment))
    columns = (np.array(column) for column in zip(*rows, strict=True))
    length = float(reached[-1])
    pressed = length - PRESSED * (way[0].diameter + way[-1].diameter) / 2
    return _Way(length, pressed, *columns)


def directed(along: complex, axial: FloatArray, shear: FloatArray) -> FloatArray:
    """Stress (..., 6) of a normal stress along a unit vector and of shear across it."""
    c, s = along.real, along.imag
    found = np.zeros((*axial.shape, 6))
    found[..., 0] = axial * c**2 - 2 * c * s * shear
    found[..., 1] = axial * s**2 + 2 * c * s * shear
    found[..., 3] = axial * c * s + (c**2 - s**2) * shear
    return found
