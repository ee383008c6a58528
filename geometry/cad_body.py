"""Mass and interfaces of a part that is not meshed, and a coarse skin to draw.

The linkage needs the mass properties, checks by formula need the holes, a report needs a picture.

Its sections by planes normal to x have areas, moments of area and a least wall. A plane cuts the
triangles of a skin in segments, the material on their left as seen from +x. By Green's theorem area
and moments are sums over segments, whatever the order; only which ones belong to one body of the
section, and its holes, needs them as closed lines.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from math import pi
from typing import Any, TypeVar

import numpy as np
import scipy

from geometry.bars import Section, stretches
from geometry.mesh import FloatArray, IntArray, Interface, MassProperties, MeshError
from geometry.meshing import gmsh_session
from geometry.shape import Body, Buildable, in_unit, unit_of
from geometry.sizing import check_skin

T = TypeVar("T")

_COARSE = 1.5  # of the part's general element size
_CURVED = 20  # facets on a full turn
_SMALLEST = 0.5  # of the facets' length on the smallest bore: rounder corners take fewer facets
_AROUND = np.arange(16) * (np.pi / 8)  # directions in which a section's outermost points are asked
_TOUCHING = 1e-6  # of the breadth: a ray begins on its own segment
_PARALLEL = 1e-12  # sine of an angle
_AT_ONCE = 256  # rays


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
    least = _SMALLEST * 2 * pi / per_turn * min(radii, default=0.0)
    check_skin(gmsh, (least, _COARSE * body.size), per_turn, unit)
    for name, value in (
        ("Mesh.ElementOrder", 1),
        ("Mesh.MeshSizeMax", _COARSE * body.size),
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


@dataclass(frozen=True, eq=False)
class Slice:
    """The section of a body at one place along x; y and z in mm.

    place       mm
    area        mm2
    centre      (2,) its centroid
    moments     second moments of area about it, mm4: of y y, z z and y z
    outline     (16, 2) its outermost points
    weak_area   mm2, of the body of the section with the least second moment, if it has several
    weak_moment  mm4, that one's least second moment about an axis through its own centroid
    breadth     mm, largest size of one body of the section
    segments    starts and ends (k, 2) of the outline's segments, and the closed line (k,) of each
    """

    place: float
    area: float
    centre: FloatArray
    moments: tuple[float, float, float]
    outline: FloatArray
    weak_area: float
    weak_moment: float
    breadth: float
    segments: tuple[FloatArray, FloatArray, IntArray]

    @cached_property
    def walls(self) -> tuple[float, float]:
        """Least thickness, mm: from a line of the outline to another, and to itself.

        Of the first both edges are held, of the second one may be free; `breadth` without any.
        """
        return _walls(*self.segments, self.breadth)


def sliced(skin: Skin, places: FloatArray) -> list[Slice]:
    """Sections of a body at places along x (n,), mm; none where a plane does not meet it.

    Raises MeshError for a surface that is not closed.
    """
    corners = skin.nodes[skin.triangles]
    low, high = corners[:, :, 0].min(axis=1), corners[:, :, 0].max(axis=1)
    found = []
    for place in places:
        crossed = (low < place) & (high >= place)
        if crossed.any():
            found.append(_slice(skin.nodes, skin.triangles[crossed], float(place)))
    return found


def in_stretches(slices: Sequence[Slice], length: float) -> list[Section]:
    """Stretches of a bar from 0 to its length, as `stretches` has them.

    A section bends in a plane as if nothing held it from bending sideways as well.
    """
    return stretches(
        np.array([one.place for one in slices]),
        np.array([_bending(one) for one in slices]),
        np.array([np.ptp(one.outline, axis=0) for one in slices]),
        length,
    )


def _bending(one: Slice) -> tuple[float, float, float]:
    """Area, mm2, and second moments in both planes, mm4, free to bend sideways as well."""
    yy, zz, yz = one.moments
    return one.area, yy - yz**2 / zz, zz - yz**2 / yy


def _slice(nodes: FloatArray, triangles: IntArray, place: float) -> Slice:
    start, stop, line = _segments(nodes, triangles, place)
    lines = np.zeros((int(line.max()) + 1, 6))
    np.add.at(lines, line, _section_integrals(start, stop).T)
    body = _bodies(start, stop, line, lines[:, 0])
    bodies = np.zeros((int(body.max()) + 1, 6))
    np.add.at(bodies, body, lines)
    bodies = bodies[bodies[:, 0] > 0]
    if not len(bodies):
        raise MeshError(f"the body's surface is not closed at x = {place:.4g} mm")
    least = [(_least(_centred(one)), float(one[0])) for one in bodies]
    weak_moment, weak_area = min(least)
    whole = bodies.sum(axis=0)
    normals = np.stack([np.cos(_AROUND), np.sin(_AROUND)])
    of_body = body[line]
    breadth = max(float(np.ptp(start[of_body == k] @ normals, axis=0).max()) for k in set(of_body))
    return Slice(
        place,
        float(whole[0]),
        whole[1:3] / whole[0],
        _centred(whole),
        start[(start @ normals).argmax(axis=0)],
        weak_area,
        weak_moment,
        breadth,
        (start, stop, line),
    )


def _segments(
    nodes: FloatArray, triangles: IntArray, place: float
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Starts and ends (k, 2) of the cuts of triangles, and the closed line (k,) of each."""
    above = nodes[triangles, 0] >= place
    lone = (above ^ (above.sum(axis=1) >= 2)[:, None]).argmax(axis=1)
    own, after, before = (triangles[np.arange(len(triangles)), (lone + k) % 3] for k in range(3))
    # material on the left: past a lone corner above, from the edge to the next one to the last's
    upwards = above[np.arange(len(triangles)), lone]
    first = np.where(upwards, after, before)
    second = np.where(upwards, before, after)
    points, names = [], []
    for other in (first, second):
        low, high = np.minimum(own, other), np.maximum(own, other)  # the same from both triangles
        share = (place - nodes[low, 0]) / (nodes[high, 0] - nodes[low, 0])
        points.append(nodes[low, 1:] + share[:, None] * (nodes[high, 1:] - nodes[low, 1:]))
        names.append(low * len(nodes) + high)
    known, index = np.unique(np.concatenate(names), return_inverse=True)
    one, two = index.reshape(2, -1)
    joined = scipy.sparse.coo_array((np.ones(len(one)), (one, two)), shape=(len(known), len(known)))
    _, line = scipy.sparse.csgraph.connected_components(joined, directed=False)
    return points[0], points[1], line[one]


def _section_integrals(p: FloatArray, q: FloatArray) -> FloatArray:
    """Of 1, y, z, y y, z z and y z over what is left of segments, (6, k)."""
    (a, b), (c, d) = p.T, q.T
    twice = a * d - c * b
    return np.stack(
        [
            twice / 2,
            twice * (a + c) / 6,
            twice * (b + d) / 6,
            twice * (a * a + a * c + c * c) / 12,
            twice * (b * b + b * d + d * d) / 12,
            twice * (2 * a * b + a * d + c * b + 2 * c * d) / 24,
        ]
    )


def _centred(integrals: FloatArray) -> tuple[float, float, float]:
    """Second moments of area about the centroid: y y, z z and y z."""
    area, y, z, yy, zz, yz = integrals.tolist()
    return yy - y * y / area, zz - z * z / area, yz - y * z / area


def _least(moments: tuple[float, float, float]) -> float:
    yy, zz, yz = moments
    return float((yy + zz) / 2 - np.hypot((yy - zz) / 2, yz))


def _bodies(p: FloatArray, q: FloatArray, line: IntArray, areas: FloatArray) -> IntArray:
    """Body (lines,) that each closed line bounds: a hole belongs to the least line around it."""
    body = np.arange(len(areas))
    outer = np.flatnonzero(areas > 0)
    for hole in np.flatnonzero(areas <= 0):
        y, z = p[line == hole][0]
        (a, b), (c, d) = p.T, q.T
        spans = (b <= z) != (d <= z)
        at = a + (z - b) / np.where(spans, d - b, 1.0) * (c - a)
        crossings = np.bincount(line[spans & (at > y)], minlength=len(areas))
        around = [k for k in outer if crossings[k] % 2]
        if around:
            body[hole] = min(around, key=lambda k: areas[k])
    return np.unique(body, return_inverse=True)[1].reshape(-1)


def _cross(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.asarray(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])


def _walls(p: FloatArray, q: FloatArray, line: IntArray, breadth: float) -> tuple[float, float]:
    """Least way from the middle of a segment, square to it, to where the material ends.

    To another line of the outline, and to the segment's own one.
    """
    along = q - p
    size = np.linalg.norm(along, axis=1)
    kept = size > _TOUCHING * breadth
    p, along, size, line = p[kept], along[kept], size[kept], line[kept]
    middle, inward = p + along / 2, np.stack([-along[:, 1], along[:, 0]], axis=1) / size[:, None]
    nearest, ends = np.empty(len(p)), np.empty(len(p), dtype=np.int64)
    for some in np.array_split(np.arange(len(p)), -(-len(p) // _AT_ONCE)):
        ray = inward[some, None]
        # middle_i + s inward_i = p_j + t along_j
        apart = p - middle[some, None]
        crossed = _cross(ray, along)
        safe = np.where(np.abs(crossed) > _PARALLEL * size, crossed, np.inf)
        s, t = _cross(apart, along) / safe, _cross(apart, ray) / safe
        met = (t >= 0) & (t <= 1) & (s > _TOUCHING * breadth) & (safe < np.inf)
        s = np.where(met, s, breadth)
        nearest[some], ends[some] = s.min(axis=1), line[s.argmin(axis=1)]
    wall, fin = (
        float(nearest.min(where=where, initial=breadth)) for where in (ends != line, ends == line)
    )
    return wall, fin
