"""A solid that is built in gmsh and is to be meshed: its surfaces, interfaces and element sizes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

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
