"""Half of a part that is its own mirror image about z = 0, for loads that are so too.

A load without a component out of the plane acts alike, mirrored, on both sides of the middle
plane: half the part, with no displacement along z where it was cut, gives the same
stress with half the unknowns (docs/theory/symmetry.md).
"""

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, TypeGuard

import numpy as np

from geometry.mesh import SYMMETRY, FloatArray, MeshError
from geometry.meshing import Body, Buildable, faces_where

_UNEVEN = 1e-4  # of volume and size: the kernel integrates slender rods to some 3e-5


class Mirrored(Buildable, Protocol):
    """A shape that says of itself that it is its own mirror image about z = 0.

    Its surface must cross that plane at right angles, where it does.
    """

    middle_plane: ClassVar[bool]

    @property
    def length(self) -> float:
        """Distance between its first two interfaces, mm."""
        ...

    def named(self, gmsh: Any) -> Body:
        """Return the body that stands in gmsh's current model, the solid or its half at z >= 0."""
        ...


def has_middle_plane(shape: Buildable) -> TypeGuard[Mirrored]:
    """Return True if a shape may be halved at a middle plane."""
    return bool(getattr(shape, "middle_plane", False))


@dataclass(frozen=True)
class Half:
    """The half at z >= 0 of a shape, to be meshed in its place."""

    whole: Mirrored

    def __post_init__(self) -> None:
        if not has_middle_plane(self.whole):
            raise MeshError(f"a {type(self.whole).__name__} has no middle plane to be halved at")

    def build(self, gmsh: Any) -> Body:
        """Build the shape in gmsh's current model and cut it.

        Raises MeshError if its halves are not alike.
        """
        self.whole.build(gmsh)
        occ = gmsh.model.occ
        solids = gmsh.model.getEntities(3)
        before = _measured(gmsh)
        low, high = np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3)
        size = float((high - low).max())
        start, extent = low[:2] - size, high - low + 2 * size
        occ.intersect(solids, [(3, occ.addBox(*start, 0.0, *extent))])
        occ.synchronize()
        _check_halves(before, _measured(gmsh), size)
        body = self.whole.named(gmsh)
        near = 1e-6 * size
        cut = faces_where(
            gmsh, lambda box, kind: kind == "Plane" and bool(np.abs(box[[2, 5]]).max() < near)
        )
        return replace(
            body,
            surfaces={**body.surfaces, SYMMETRY: cut},
            interfaces=[replace(interface, tilts=False) for interface in body.interfaces],
            half=True,
        )


def _measured(gmsh: Any) -> FloatArray:
    """Volume mm3 and mass centre (3,) mm of the bodies in the model, (4,)."""
    occ = gmsh.model.occ
    tags = [tag for _, tag in gmsh.model.getEntities(3)]
    volumes = np.array([occ.getMass(3, tag) for tag in tags])
    if not volumes.sum() > 0:
        raise MeshError("nothing of the part is at z >= 0")
    centres = np.array([occ.getCenterOfMass(3, tag) for tag in tags])
    return np.asarray(np.r_[volumes.sum(), volumes @ centres / volumes.sum()], dtype=np.float64)


def _check_halves(whole: FloatArray, half: FloatArray, size: float) -> None:
    """MeshError unless a body is twice its half, and its mass centre where a mirror puts it."""
    ratio = 2 * half[0] / whole[0]
    away = np.abs(np.r_[whole[1:3] - half[1:3], whole[3]]).max()
    if abs(ratio - 1) > _UNEVEN or away > _UNEVEN * size:
        raise MeshError(
            f"the part is not its own mirror image about z = 0: twice the half at z >= 0 has "
            f"{ratio:.9g} of its volume, its mass centre is {away:.3g} mm beside"
        )
