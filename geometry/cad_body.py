"""Mass and interfaces of a part that is not meshed, and a coarse skin to draw.

The linkage needs the mass properties, checks by formula need the holes, a report needs a picture.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from math import pi
from typing import Any, TypeVar

import numpy as np

from geometry.mesh import FloatArray, IntArray, Interface, MassProperties, MeshError
from geometry.meshing import gmsh_session
from geometry.shape import Body, Buildable, in_unit, unit_of
from geometry.sizing import MOST_TRIANGLES, check_skin, skin_triangles

T = TypeVar("T")

_COARSE = 1.5  # of the part's general element size
_CURVED = 20  # facets on a full turn
_SMALLEST = (0.5, 1.0)  # of the facets' length on the smallest bore: rounder corners take fewer


@dataclass(frozen=True, eq=False)
class SolidBody:
    """Mass properties and interfaces of a body that is not meshed, in the part's own axes.

    interfaces  name -> Interface
    volume      mm3
    centre      (3,) mm, of mass
    second      mm5, second moment of volume about z through the centre
    size        mm, largest size along an axis
    """

    interfaces: Mapping[str, Interface]
    volume: float
    centre: FloatArray
    second: float
    size: float

    def mass_properties(self, density: float) -> MassProperties:
        """Mass, centre and inertia of the body at a density in t/mm3."""
        return MassProperties(density * self.volume, self.centre, density * self.second)


@dataclass(frozen=True, eq=False)
class Skin:
    """A body's surface as flat triangles, each seen from outside counter-clockwise.

    nodes       (n, 3) mm
    triangles   (m, 3) indices of them
    """

    nodes: FloatArray
    triangles: IntArray


def cad_body(shape: Buildable) -> SolidBody:
    """Build a shape and ask the CAD kernel for what it knows; raises MeshError."""

    def known(gmsh: Any, body: Body, unit: float) -> SolidBody:
        volume, centre, second = _integrals(gmsh)
        return SolidBody(
            interfaces={one.name: one.in_mm(unit) for one in body.interfaces},
            volume=unit**3 * volume,
            centre=unit * centre,
            second=unit**5 * second,
            size=unit * _extent(gmsh),
        )

    return _built(shape, known)


def cad_skin(shape: Buildable, per_turn: int = _CURVED) -> Skin:
    """Build a shape and cover its faces with triangles; raises MeshError.

    per_turn  facets on a full turn
    """
    return _built(shape, partial(_skin, per_turn))


def _built(shape: Buildable, known: Callable[[Any, Body, float], T]) -> T:
    """Return known(gmsh, body, unit) of the shape in gmsh's model, in a unit of so many mm."""
    unit = unit_of(shape)
    with gmsh_session() as gmsh:
        try:
            return known(gmsh, in_unit(shape, unit).build(gmsh), unit)
        except MeshError:
            raise
        except Exception as error:  # gmsh raises bare Exception only
            raise MeshError(f"gmsh could not build the part: {error}") from error


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


def _extent(gmsh: Any) -> float:
    """Largest size of all solids together along an axis."""
    boxes = [gmsh.model.getBoundingBox(3, tag) for _, tag in gmsh.model.getEntities(3)]
    low, high = np.moveaxis(np.reshape(boxes, (-1, 2, 3)), 1, 0)
    return float((high.max(axis=0) - low.min(axis=0)).max())


def _skin(per_turn: int, gmsh: Any, body: Body, unit: float) -> Skin:
    """Flat triangles on all faces of the solids; TooFineError for too many of them."""
    radii = [interface.radius for interface in body.interfaces if interface.radius]
    on_bore, most = 2 * pi / per_turn * min(radii, default=0.0), _COARSE * body.size
    least = _SMALLEST[0] * on_bore
    if per_turn == _CURVED and skin_triangles(gmsh, (least, most), per_turn) > MOST_TRIANGLES:
        least = _SMALLEST[1] * on_bore  # a picture: corners along a slender part
    check_skin(gmsh, (least, most), per_turn, unit)
    for name, value in (
        ("Mesh.ElementOrder", 1),
        ("Mesh.MeshSizeMax", most),
        ("Mesh.MeshSizeMin", least),
        ("Mesh.MeshSizeFromCurvature", per_turn),
    ):
        gmsh.option.setNumber(name, value)
    gmsh.model.mesh.generate(2)
    nodes, triangles = skin_of(gmsh)
    return Skin(unit * nodes, triangles)


# The skin of solids as flat triangles, each seen from outside counter-clockwise.


def skin_of(gmsh: Any) -> tuple[FloatArray, IntArray]:
    """Nodes (n, 3) mm and triangles (m, 3) of the solids' faces, which have been meshed.

    Building may leave faces that bound nothing, such as an outline that was revolved; and the
    kernel's faces look either way, so each solid's are turned by their neighbours.
    """
    tags, places, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    places = places.reshape(-1, 3)
    found = []
    for solid in gmsh.model.getEntities(3):
        faces = [tag for _, tag in gmsh.model.getBoundary([solid], oriented=False)]
        corners = [gmsh.model.mesh.getElementsByType(2, tag)[1] for tag in faces]
        rows = [order[np.searchsorted(tags[order], three)].reshape(-1, 3) for three in corners]
        found.append(outwards([three for three in rows if len(three)], places))
    used, triangles = np.unique(np.concatenate(found), return_inverse=True)
    return places[used], triangles.reshape(-1, 3).astype(np.int64)


def outwards(faces: list[IntArray], places: FloatArray) -> IntArray:
    """Return all triangles (m, 3) of the faces that bound one solid, turned to look outwards.

    faces  (k, 3) each, triangles that look the same way within a face

    Of several closed shells the one that holds most is the outer one, the others are cavities.
    """
    owner = np.repeat(np.arange(len(faces)), [len(three) for three in faces])
    triangles = np.concatenate(faces)
    turned = np.zeros(len(faces), dtype=bool)
    shell = np.full(len(faces), -1)
    neighbours = _neighbours(triangles, owner)
    for first in range(len(faces)):
        if shell[first] >= 0:
            continue
        shell[first], waiting = first, [first]
        while waiting:
            face = waiting.pop()
            for other, against in neighbours[neighbours[:, 0] == face, 1:]:
                if shell[other] < 0:
                    shell[other] = first
                    turned[other] = turned[face] ^ bool(against)
                    waiting.append(int(other))
    corners = places[triangles]
    volumes = np.einsum("ij,ij->i", np.cross(corners[:, 0], corners[:, 1]), corners[:, 2]) / 6
    signed = np.where(turned[owner], -volumes, volumes)
    held = np.bincount(shell[owner], weights=signed, minlength=len(faces))
    outer = int(np.abs(held).argmax())
    inside_out = np.where(np.arange(len(faces)) == outer, held < 0, held > 0)
    turned ^= inside_out[shell]
    return np.asarray(np.where(turned[owner, None], triangles[:, ::-1], triangles))


def _neighbours(triangles: IntArray, owner: IntArray) -> IntArray:
    """Rows (face, other face, 1 if they look against each other), each pair both ways."""
    sides = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    of_side = np.repeat(owner, 3)
    low = np.sort(sides, axis=1)
    order = np.lexsort((low[:, 1], low[:, 0]))
    same = (low[order[1:]] == low[order[:-1]]).all(axis=1)
    one, two = order[:-1][same], order[1:][same]
    pairs = np.column_stack([of_side[one], of_side[two], sides[one, 0] == sides[two, 0]])
    pairs = np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
    return np.concatenate([pairs, pairs[:, [1, 0, 2]]])
