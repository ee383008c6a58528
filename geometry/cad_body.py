"""A part's body from the CAD kernel alone: its mass, its interfaces and a coarse skin; no mesh.

What a part that is not meshed needs all the same: the linkage its mass properties, checks by
formula its holes, and a report its picture.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geometry.mesh import FloatArray, IntArray, Interface, MassProperties, MeshError
from geometry.meshing import Buildable, gmsh_session
from geometry.skin import skin_of

_COARSE = 1.5  # of the part's general element size
_CURVED = 20  # facets on a full turn


@dataclass(frozen=True, eq=False)
class SolidBody(ABC):
    """What is known of a body that is not meshed, in the part's own axes.

    interfaces  name -> Interface
    volume      mm3
    centre      (3,) mm, of mass
    second      mm5, second moment of volume about z through the centre
    """

    interfaces: Mapping[str, Interface]
    volume: float
    centre: FloatArray
    second: float

    def mass_properties(self, density: float) -> MassProperties:
        """Mass, centre and inertia of the body at a density in t/mm3."""
        return MassProperties(density * self.volume, self.centre, density * self.second)

    @property
    @abstractmethod
    def size(self) -> float:
        """Largest size along an axis, mm."""


@dataclass(frozen=True, eq=False)
class CadBody(SolidBody):
    """A body as the CAD kernel knows it.

    nodes       (n, 3) mm, of a skin of flat triangles
    triangles   (m, 3) indices of them
    """

    nodes: FloatArray
    triangles: IntArray

    @property
    def size(self) -> float:
        """Largest size along an axis, mm."""
        return float(np.ptp(self.nodes, axis=0).max())


def cad_body(shape: Buildable) -> CadBody:
    """Build a shape and ask the kernel for what it knows; raises MeshError."""
    with gmsh_session() as gmsh:
        try:
            body = shape.build(gmsh)
            volume, centre, second = _integrals(gmsh)
            nodes, triangles = _skin(gmsh, body.size)
        except MeshError:
            raise
        except Exception as error:  # gmsh raises bare Exception only
            raise MeshError(f"gmsh could not build the part: {error}") from error
    interfaces = {interface.name: interface for interface in body.interfaces}
    return CadBody(interfaces, volume, centre, second, nodes, triangles)


def _integrals(gmsh: Any) -> tuple[float, FloatArray, float]:
    """Volume, centre and second moment about z through it, of all solids together."""
    occ = gmsh.model.occ
    tags = [tag for _, tag in gmsh.model.getEntities(3)]
    volumes = np.array([occ.getMass(3, tag) for tag in tags])
    centres = np.array([occ.getCenterOfMass(3, tag) for tag in tags])
    own = np.array([occ.getMatrixOfInertia(3, tag)[8] for tag in tags])
    volume = float(volumes.sum())
    centre = volumes @ centres / volume
    arms = ((centres - centre)[:, :2] ** 2).sum(axis=1)
    return volume, centre, float((own + volumes * arms).sum())


def _skin(gmsh: Any, size: float) -> tuple[FloatArray, IntArray]:
    """Flat triangles on all faces of the solids, (n, 3) mm and (m, 3)."""
    for name, value in (
        ("Mesh.ElementOrder", 1),
        ("Mesh.MeshSizeMax", _COARSE * size),
        ("Mesh.MeshSizeFromCurvature", _CURVED),
    ):
        gmsh.option.setNumber(name, value)
    gmsh.model.mesh.generate(2)
    return skin_of(gmsh)
