"""Half of a part that is its own mirror image about z = 0, for loads that are so too.

A load without a component out of the plane acts alike, mirrored, on both sides of the middle
plane: half the part, with no displacement along z where it was cut, gives the same
stress with half the unknowns (docs/theory/symmetry.md).
"""

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, TypeGuard

import numpy as np

from geometry.mesh import SYMMETRY, FloatArray, MeshError
from geometry.shape import Body, Buildable, faces_where

_BESIDE = 1e-6  # of its size: how far the mirror image of a surface may lie beside the part
_UNEVEN = 1e-3  # of its volume: the kernel integrates that of slender rods to some 3e-4 only
_PLACES = (0.07, 0.29, 0.5, 0.71, 0.93)  # of a face's two parameters: where it is compared


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
        low, high = np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3)
        size = float((high - low).max())
        _check_mirror_image(gmsh, size)
        before = _volume(gmsh)
        start, extent = low[:2] - size, high - low + 2 * size
        occ.intersect(solids, [(3, occ.addBox(*start, 0.0, *extent))])
        occ.synchronize()
        if abs(2 * _volume(gmsh) / before - 1) > _UNEVEN:
            raise MeshError(f"the cut at z = 0 leaves {_volume(gmsh) / before:.6g} of the volume")
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


def _volume(gmsh: Any) -> float:
    """Volume of the bodies in the model."""
    return float(sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.getEntities(3)))


def _check_mirror_image(gmsh: Any, size: float) -> None:
    """MeshError unless the mirror images of points on every face lie on faces of the part.

    Points, not integrals: the kernel's volume of a slender rod errs by more than a step of 0.1 mm
    in it is worth.
    """
    near = _BESIDE * size
    solids = gmsh.model.getEntities(3)
    faces = [tag for _, tag in gmsh.model.getBoundary(solids, oriented=False)]
    boxes = np.array([gmsh.model.getBoundingBox(2, tag) for tag in faces]).reshape(-1, 2, 3)
    for tag in faces:
        image = _points_of(gmsh, tag) * [1, 1, -1]
        beside = np.full(len(image), np.inf)
        for other, (low, high) in zip(faces, boxes, strict=True):
            asked = ((image > low - near) & (image < high + near)).all(axis=1) & (beside > near)
            if asked.any():
                closest, _ = gmsh.model.getClosestPoint(2, other, image[asked].ravel())
                away = np.linalg.norm(image[asked] - np.reshape(closest, (-1, 3)), axis=1)
                beside[asked] = np.minimum(beside[asked], away)
        if beside.max(initial=0.0) > near:
            x, y, z = image[beside.argmax()] * [1, 1, -1]
            raise MeshError(
                f"the part is not its own mirror image about z = 0: its surface at x = {x:.6g}, "
                f"y = {y:.6g}, z = {z:.6g} mm has none at z = {-z:.6g} mm"
            )


def _points_of(gmsh: Any, tag: int) -> FloatArray:
    """Places on a face, (n, 3): those of a grid of its parameters that lie within its edges."""
    low, high = (np.array(bound) for bound in gmsh.model.getParametrizationBounds(2, tag))
    grid = np.stack(np.meshgrid(_PLACES, _PLACES), axis=-1).reshape(-1, 2)
    places = [at for at in low + grid * (high - low) if gmsh.model.isInside(2, tag, at, True)]
    return np.reshape(gmsh.model.getValue(2, tag, np.ravel(places)), (-1, 3))
