"""Sections of a body cut by planes normal to x: areas, moments of area, least wall.

A plane cuts the triangles of a skin in segments, the material on their left as seen from +x. By
Green's theorem area and moments are sums over segments, whatever the order; only which ones belong
to one body of the section, and its holes, needs them as closed lines.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from geometry.bars import Section, stretches
from geometry.cad_body import Skin
from geometry.mesh import FloatArray, IntArray, MeshError

_AROUND = np.arange(16) * (np.pi / 8)  # directions in which a section's outermost points are asked
_TOUCHING = 1e-6  # of the breadth: a ray begins on its own segment
_PARALLEL = 1e-12  # sine of an angle
_AT_ONCE = 256  # rays


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

    @property
    def thickness(self) -> float:
        """Four times the area over the outline, mm: of a round or square bar, twice a wall's."""
        start, stop, _ = self.segments
        return float(4 * self.area / np.hypot(*(stop - start).T).sum())

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
    np.add.at(lines, line, _integrals(start, stop).T)
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


def _integrals(p: FloatArray, q: FloatArray) -> FloatArray:
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
