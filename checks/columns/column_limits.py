"""Column strength of a part in one plane, by handbook, for every section.

A part whose sections tell their stretch is one column with steps; each of its sections is judged by
that column's lowest force, and one that has a free length of its own also by that. Pins are hinges
about their own axis only: out of the plane the ends are as stiff as their forks, which lie between
hinged and clamped (docs/theory/columns.md).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import inf, pi, sqrt

from checks.design.data import Design, Part
from checks.handbook.column_curves import ColumnStrength, column_strength, eurocode_stress
from checks.handbook.tapered_columns import (
    CLAMPED,
    HINGED,
    ColumnEnd,
    ColumnShape,
    critical_force,
    least_critical_force,
)
from checks.part.part_loads import interface_distance
from geometry.bars import Section

_JOINED = 1e-6  # of the column's length


@dataclass(frozen=True)
class Plane:
    """A plane in which a part may buckle.

    name      "in plane" or "out of plane" of the linkage
    length    mm, of the whole column between its ends
    own       mm, between the part's own pins
    ends      how both ends are held
    stiffest  mm and ends of the other bound: forks that clamp the part's own ends
    """

    name: str
    length: float
    own: float
    ends: ColumnEnd
    stiffest: tuple[float, ColumnEnd]

    def inertia(self, section: Section) -> float:
        """Second moment of area of a section as it stands alone, mm4."""
        inside = self.name == "in plane"
        return section.inertia_in_plane if inside else section.inertia_out_of_plane

    def built_up(self, section: Section) -> tuple[float, float]:
        """Second moment of area as a part of the whole column, mm4, and half its depth, mm."""
        if self.name == "in plane":
            return section.inertia_in_plane, section.depth_in_plane / 2
        inertia = section.inertia_built_up or section.inertia_out_of_plane
        return inertia, section.depth_out_of_plane / 2

    def free_length(self, section: Section) -> float | None:
        """Effective length, mm, that a section has of its own."""
        return section.length if self.name == "in plane" else section.length_out_of_plane

    def racking(self, section: Section) -> float:
        """Shear stiffness of a section over E, mm2; infinite where it knows none."""
        return inf if self.name == "in plane" else section.racking_area or inf


@dataclass(frozen=True)
class ColumnCase:
    """A section and the column that it is judged as.

    whole     whether that is the whole part, or the section's own free length
    stepped   whether the whole part changes its section
    length    mm, effective: the hinged, even column of this section with the same Euler force
    strength  yield, Johnson and Euler
    limit     MPa, axial stress that the section carries: by its strength, or by a stated curve
    law       name of the rule that gives the limit
    """

    section: Section
    whole: bool
    stepped: bool
    length: float
    strength: ColumnStrength
    limit: float
    law: str


def planes_of(design: Design, part: Part) -> tuple[Plane, Plane]:
    """The two planes of a part: hinged in the linkage's, between hinged and clamped out of it."""
    own = interface_distance(design, part)
    column = part.column
    within, across = column.in_plane or own, column.out_of_plane or own
    fork = HINGED if column.fork_stiffness is None else ColumnEnd(column.fork_stiffness)
    stiffest = (across, fork) if column.fork_stiffness else (min(across, own), CLAMPED)
    return (
        Plane("in plane", within, own, HINGED, (min(within, own), HINGED)),
        Plane("out of plane", across, own, fork, stiffest),
    )


def whole_force(part: Part, plane: Plane, section: Section, stiffest: bool = False) -> float:
    """Lowest elastic buckling force, N, of the whole part: as it is stepped, or even as `section`.

    An effective length beyond the part's own stands for two such parts, one the other's mirror
    image: the weaker of both ways round counts.
    """
    young = part.material.youngs_modulus
    if is_stepped(part):
        try:
            return _stepped_force(young, tuple(part.geometry.sections), plane, stiffest)
        except ValueError as error:
            raise ValueError(f"{part.name}: {error}") from error
    length, end = plane.stiffest if stiffest else (plane.length, plane.ends)
    shape = ColumnShape.stepped([length], [young * plane.built_up(section)[0]])
    return critical_force(shape, end, end)


@lru_cache(maxsize=256)
def _stepped_force(
    young: float, sections: tuple[Section, ...], plane: Plane, stiffest: bool
) -> float:
    """Lowest elastic buckling force, N, of a stepped part; asked for once for each section."""
    length, end = plane.stiffest if stiffest else (plane.length, plane.ends)
    own = _stepped(young, sections, plane)
    shapes = [own]
    if length > own.length * (1 + _JOINED):
        shapes = [own.followed_by(own.turned()), own.turned().followed_by(own), own]
    return least_critical_force([shape.over(length) for shape in shapes], end, end)


def is_stepped(part: Part) -> bool:
    """True if the part's sections state their stretches along it."""
    return bool(part.geometry.sections) and all(s.stretch for s in part.geometry.sections)


def cases_of(part: Part, plane: Plane, stiffest: bool = False) -> list[ColumnCase]:
    """All sections of a part as columns in one plane."""
    stepped = is_stepped(part)
    young = part.material.youngs_modulus
    found = []
    for section in part.geometry.sections:
        free = plane.free_length(section)
        inertia = plane.inertia(section)
        if free is not None:
            shorter = min(free, plane.own) if stiffest else free
            found.append(_case(part, plane, section, shorter, whole=False))
        if stepped or free is None:
            force = whole_force(part, plane, section, stiffest)
            length = pi * sqrt(young * inertia / force)
            found.append(_case(part, plane, section, length, whole=True))
    return found


def _case(part: Part, plane: Plane, section: Section, length: float, *, whole: bool) -> ColumnCase:
    material, inertia = part.material, plane.inertia(section)
    strength = column_strength(
        section.area, inertia, length, material.yield_stress, material.youngs_modulus
    )
    limit, law, curve = strength.critical, strength.governs, part.column.curve
    if curve is not None:
        limit = eurocode_stress(strength.euler, material.yield_stress, curve)
        law = f"Eurocode 3 curve {curve}"
    return ColumnCase(section, whole, is_stepped(part), length, strength, limit, law)


def _stepped(young: float, sections: Sequence[Section], plane: Plane) -> ColumnShape:
    """A part between its pins, in stretches."""
    found = [(s.stretch, s) for s in sections if s.stretch is not None]
    found.sort(key=lambda entry: entry[0])
    places = [0.0, *(stop for (_, stop), _ in found)]
    starts = [start for (start, _), _ in found]
    slack = _JOINED * plane.own
    if any(abs(a - b) > slack for a, b in zip(starts, places, strict=False)) or (
        abs(places[-1] - plane.own) > slack
    ):
        told = ", ".join(f"{s.name} {start:g} to {stop:g}" for (start, stop), s in found)
        raise ValueError(
            f"the sections' stretches must cover the part from 0 to {plane.own:g} mm "
            f"one behind the other, got {told} mm"
        )
    return ColumnShape.stepped(
        [stop - start for start, stop in pairwise(places)],
        [young * plane.built_up(section)[0] for _, section in found],
        [young * plane.racking(section) for _, section in found],
    )
