"""The part shapes of design files, and the solids that are built of them to be meshed.

A shape is a frozen dataclass that derives from `Shape`, in a module of its own in `geometry/parts`;
its formula model is a module of its own in `checks/models/shapes` (docs/extending.md).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np

from geometry.bars import Bar, RulingSection, Section, Walls
from geometry.mesh import Interface


@dataclass(frozen=True)
class Region:
    """A target size near some surfaces or curves.

    entities  (dimension, tag) pairs of gmsh
    size      mm, on the entities
    reach     mm, distance at which the size has grown to the part's general size
    """

    entities: Sequence[tuple[int, int]]
    size: float
    reach: float


@dataclass(frozen=True)
class Body:
    """A solid built in the running gmsh session, and what the mesher must know of it.

    Its lengths are in the unit in which it is built, mm but for very small and very large parts.

    surfaces    name -> tags of its CAD faces
    interfaces  the places where other parts press
    size        general element size
    regions     where elements are smaller
    stacked     True if it is several solids that share faces normal to y (made conformal in gmsh);
                they keep nodes of their own there, with equal displacement along y
    bolted_at   x of the plane in which a stack's solids do not slide on each other either
    half        True if it is the half at z >= 0 of a part (geometry/symmetry.py)
    """

    surfaces: Mapping[str, Sequence[int]]
    interfaces: Sequence[Interface]
    size: float
    regions: Sequence[Region]
    stacked: bool = False
    bolted_at: float | None = None
    half: bool = False


class Buildable(Protocol):
    """A shape that can build itself with gmsh's OpenCASCADE kernel."""

    def build(self, gmsh: Any) -> Body:
        """Build the solid in gmsh's current model and say what stands where."""
        ...


def faces_where(gmsh: Any, test: Callable[[Any, str], bool]) -> list[int]:
    """Tags of the CAD faces whose bounding box (6,) and type pass the test."""
    found = []
    for _, tag in gmsh.model.getEntities(2):
        box = np.array(gmsh.model.getBoundingBox(2, tag))
        if test(box, gmsh.model.getType(2, tag)):
            found.append(tag)
    return found


@dataclass(frozen=True)
class Ligament:
    """Material behind a hole: mm2 in one shear plane, and the name of its other side.

    direction  unit vector in the part's axes in which a force on the part tears it; None: any,
               and `area` is then given for 72 directions from +x on, counter-clockwise; infinite
               where nothing tears
    """

    direction: tuple[float, float] | None
    area: tuple[float, ...]
    until: str


@dataclass(frozen=True)
class Shape(ABC):
    """A part in its own axes: x along it, z along the pins, lengths in mm.

    The first interface is at the origin, the second at x = `length`.

    name             by which design files call the shape; "" for one that has another way in
    may_buckle       False for what has no compression along x worth a check
    stressed_evenly  True where axial force decides, for Marin's load factor
    middle_plane     True if z = 0 is a plane of symmetry, at which `named` finds a half, too
    """

    name: ClassVar[str] = ""
    stressed_evenly: ClassVar[bool] = False
    middle_plane: ClassVar[bool] = False
    may_buckle: ClassVar[bool] = True
    if TYPE_CHECKING:  # a field of most shapes

        @property
        def length(self) -> float:
            """Distance of the first two interfaces; of a pin its whole length, mm."""
            ...

    @property
    def interfaces(self) -> tuple[str, ...]:
        """Names of the places where other parts press, a constant of most shapes.

        Empty for a pin, whose stack has them.
        """
        return ()

    @classmethod
    def fixed_interfaces(cls) -> tuple[str, ...]:
        """The names of `interfaces` where all parts of the shape have the same; else none."""
        names = cls.interfaces
        return names if isinstance(names, tuple) else ()

    @property
    def pin_places(self) -> dict[str, float]:
        """Places along x, mm, of the first two interfaces by name."""
        return dict(zip(self.interfaces[:2], (0.0, self.length), strict=True))

    @abstractmethod
    def build(self, gmsh: Any) -> Body:
        """Build the solid in gmsh's current model and say what stands where."""

    def named(self, gmsh: Any) -> Body:
        """Return the body that stands in gmsh's current model, the solid or its half at z >= 0."""
        raise NotImplementedError(f"{type(self).__name__} has no middle plane")

    @property
    @abstractmethod
    def placed_interfaces(self) -> list[Interface]:
        """The interfaces, where they stand and how large they are."""

    @property
    @abstractmethod
    def stressed_section(self) -> tuple[float, ...]:
        """Height in the plane and thickness, or one diameter, mm, for Marin's size factor."""

    @property
    @abstractmethod
    def ruling_sections(self) -> tuple[RulingSection, ...]:
        """Sizes that grade the strength of its material."""

    @property
    def sections(self) -> Sequence[Section]:
        """Sections that are compressed along the length, as columns; none of what is bent."""
        return ()

    @property
    def walls(self) -> Sequence[Walls]:
        """Stretches across which a weld may run, the stress there known; none of most shapes."""
        return ()

    @property
    def notch_factors(self) -> Mapping[str, float]:
        """Fatigue notch factors by surface, of what the mesh does not show."""
        return {}

    @property
    def proportions(self) -> Mapping[str, float]:
        """Ratios of its sizes, by name, on which the error of its formula model depends.

        Names such as "hole / width"; one that begins with "length / " has no upper end in buckling.
        Empty for a shape whose proportions are not known: then no band of solids holds for it.
        """
        return {}

    def link(self, poisson_ratio: float) -> Bar | None:
        """The bar that it is between its first two interfaces; None for a shape that is no bar.

        Sections are taken without the bores: a pin fills them, and in compression its force enters
        beyond. With the linkage's other links it makes the frame whose buckling is checked.
        """
        return None

    @property
    def profile(self) -> Bar | None:
        """The bar that it is from end to end, bores taken out; None where that is not known.

        Section forces at its welds follow from it.
        """
        return None

    @property
    def bending(self) -> tuple[float, float, str] | None:
        """Least second moment in the plane, mm4, least area, mm2, and what it is of, in words.

        All along the part, for the vibration of the linkage; None for a shape that is no bar.
        """
        if not self.sections:
            return None
        least = min(self.sections, key=lambda section: section.inertia_in_plane)
        return least.inertia_in_plane, min(one.area for one in self.sections), least.name

    def ligaments(self, interface: str) -> Sequence[Ligament] | None:
        """Ligaments that a pin can tear out of a bore; None where they are measured on the mesh."""
        return ()

    def outward(self, interface: str) -> tuple[tuple[float, float], str]:
        """Direction from a bore to the end of the part behind it, and that end in words."""
        if interface == self.interfaces[0]:
            return (-1.0, 0.0), "the end at x < 0"
        return (1.0, 0.0), f"the end at x > {self.length:g} mm"

    def stated_bore(self, interface: str) -> float | None:
        """Stated diameter of the bore at an interface, mm; None where it has no bore there."""
        bores = {one.name: 2 * one.radius for one in self.placed_interfaces if one.kind == "bore"}
        return bores.get(interface)

    def bore_key(self, interface: str) -> str:
        """Key of the part's entry that states that diameter."""
        return "hole"

    @property
    def clear_width(self) -> float | None:
        """Clear width, mm, between the walls of a part that is loaded on its end faces."""
        return None

    @property
    def cheeks_at(self) -> float | None:
        """Height +-z of the middles of the cheeks of a part that has two, mm."""
        return None

    @property
    def cheeks_turn(self) -> float:
        """Least turn of one of its two cheeks under a couple of the pressure in its bore, with it.

        Times E over the couple, 1/mm3; 0 where it is not known: then it may be held.
        """
        return 0.0

    @property
    def told(self) -> Sequence[str]:
        """Notes on the reading of its file: sentences for the report."""
        return ()

    @property
    def heights(self) -> Mapping[str, float]:
        """Height z, mm, of the middle of each interface that is not in the middle plane."""
        return {}

    @property
    def shifts(self) -> Mapping[str, tuple[float, float]]:
        """Interface -> mm, from its point of the linkage to where the part has it."""
        return {}
