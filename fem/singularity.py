"""Sharp re-entrant edges: where linear elasticity has no finite stress.

At a re-entrant edge whose interior angle is omega > 180 degrees the stress grows towards the edge
like r^(lambda - 1), with lambda in (1/2, 1) the smallest root of sin(lambda omega) +
lambda sin(omega) = 0 (M. L. Williams, J. Appl. Mech. 19 (1952) 526, free faces, symmetric mode). A
finite-element peak there grows with every refinement and means nothing.

Where a pressure ends on a smooth surface the stress is finite, but jumps: `pressed_edges`.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geometry.mesh import BoolArray, FloatArray, IntArray, Mesh

_PRESSED_EVENLY = ("bore", "journal")  # along their length; a clamp presses little
_STRAIGHT_ON = np.cos(np.radians(30))  # of the angle by which an edge goes on, or ends square
_BENT = 0.1  # of the distance from an edge: how far its face may have left its plane there
_FARTHEST = 8.0  # times an element's side at the edge: as far as its surroundings are looked at
_SHARP = np.radians(12)  # a turn of the surface beyond what curved facets leave between them


@dataclass(frozen=True, eq=False)
class ReentrantEdges:
    """Sharp concave edges of a mesh.

    nodes   (n,)  node indices on them
    angles  (n,)  rad, interior angle there (the largest, where several meet)
    """

    nodes: IntArray
    angles: FloatArray


def reentrant_edges(mesh: Mesh) -> ReentrantEdges:
    """Find edges where two boundary facets meet at an interior angle above 192 degrees.

    The facets' normals are those of the curved facets at the edge's mid-side node. A parabola
    through three points of a circle does not meet it at the right angle; twice what the facets' own
    turn lets expect of that is not taken for an edge.
    """
    found = _surface_edges(mesh)
    sharp = found.concave & ~found.smooth
    nodes = found.nodes[sharp]
    on_edge = np.unique(nodes)
    angles = np.zeros(len(mesh.nodes))
    np.maximum.at(angles, nodes, (np.pi + found.turn[sharp])[:, None])
    return ReentrantEdges(on_edge, angles[on_edge])


@dataclass(frozen=True, eq=False)
class EdgePlaces:
    """Places along the sharp concave edges of a mesh: the middles of its elements' sides there.

    nodes    (n, 3)  node indices of each side: its ends and its middle, which is the place
    points   (n, 3)  mm
    sizes    (n,)    mm, lengths of the sides
    angles   (n,)    rad, interior angle
    frames   (n, 3, 3) unit rows: into the body along the bisector, normal to that, along the edge
    room     (n,)    mm, how far both faces go on as they begin, and as they are loaded there
    loaded   (n,)    True where something presses on a face at the edge
    ends     (n,)    mm, how far away an edge branches, turns, or ends within the body's surface
    others   (m,)    elements that have no node on any of the edges
    middles  (m, 3)  mm, of these
    """

    nodes: IntArray
    points: FloatArray
    sizes: FloatArray
    angles: FloatArray
    frames: FloatArray
    room: FloatArray
    loaded: BoolArray
    ends: FloatArray
    others: IntArray
    middles: FloatArray

    def near(self, which: int, distance: float) -> IntArray:
        """Elements (n,) off the edges whose middle is within a distance (mm) of a place."""
        found = self._tree.query_ball_point(self.points[which], distance)
        return np.asarray(np.sort(self.others[found]))

    @cached_property
    def _tree(self) -> Any:
        from scipy.spatial import cKDTree

        return cKDTree(self.middles)


def edge_places(mesh: Mesh) -> EdgePlaces:
    """Places along the sharp concave edges of a mesh, as `reentrant_edges` finds them.

    An edge may end square on a smooth face, as in a plate that is cut through, or at the cut of a
    half: its stress goes on as before up to there, and that is no end.
    """
    found = _surface_edges(mesh)
    sharp = found.concave & ~found.smooth
    nodes = found.nodes[sharp]
    inward = -(found.normals[0] + found.normals[1])[sharp]
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    along = mesh.nodes[nodes[:, 1]] - mesh.nodes[nodes[:, 0]]
    sizes = np.linalg.norm(along, axis=1)
    along -= (along * inward).sum(axis=1, keepdims=True) * inward
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    frames = np.stack([inward, np.cross(along, inward), along], axis=1)
    others = np.flatnonzero(~np.isin(mesh.elements, nodes).any(axis=1))
    middles = mesh.nodes[mesh.elements[others, :4]].mean(axis=1)
    angles = np.pi + found.turn[sharp]
    points = mesh.nodes[nodes[:, 2]]
    loose = mesh.nodes[_loose_ends(mesh, nodes, along)]
    room, loaded = _rooms(mesh, points, frames, angles, sizes)
    ends = np.full(len(points), np.inf)
    if len(loose) and len(points):
        ends = np.linalg.norm(points[:, None] - loose, axis=2).min(axis=1)
    return EdgePlaces(nodes, points, sizes, angles, frames, room, loaded, ends, others, middles)


def _loose_ends(mesh: Mesh, sides: IntArray, along: FloatArray) -> IntArray:
    """Nodes (n,) where sharp edges branch, turn, or end otherwise than square on a face."""
    facets, normals = mesh.facets, facet_normals(mesh.nodes[mesh.facets], 1 / 3, 1 / 3)
    found = []
    for node in np.unique(sides[:, :2]):
        own = np.flatnonzero((sides[:, :2] == node).any(axis=1))
        away = np.where(sides[own, 0] == node, 1.0, -1.0)[:, None] * along[own]
        if len(own) == 2 and away[0] @ away[1] < -_STRAIGHT_ON:
            continue
        if len(own) == 1:
            meet = normals[(facets == node).any(axis=1)]
            if node in mesh.cut_nodes or (np.abs(meet @ away[0]) > _STRAIGHT_ON).any():
                continue
        found.append(node)
    return np.array(found, dtype=np.int64)


def _rooms(
    mesh: Mesh, points: FloatArray, frames: FloatArray, angles: FloatArray, sizes: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Distances (n,), mm, from places of an edge to where its faces end or begin to be loaded.

    The second answer is True for each place where a face is loaded from the edge on.
    """
    from scipy.spatial import cKDTree

    far = _FARTHEST * sizes
    loaded = np.zeros(len(points), dtype=bool)
    if not len(points):
        return far, loaded
    pressed = np.zeros(len(mesh.nodes), dtype=bool)
    for interface in mesh.interfaces.values():
        for name in interface.surfaces:
            pressed[mesh.surfaces[name]] = True
    corners = mesh.nodes[mesh.facets]
    normals = facet_normals(corners, 1 / 3, 1 / 3)
    around = cKDTree(corners[:, :3].mean(axis=1)).query_ball_point(points, far)
    for k, (place, frame, angle, size) in enumerate(
        zip(points, frames, angles, sizes, strict=True)
    ):
        away = (corners[around[k]] - place) @ frame.T
        r = np.hypot(away[..., 0], away[..., 1])
        off = np.abs(np.sin(np.abs(np.arctan2(away[..., 1], away[..., 0])) - angle / 2))
        other = ((off > _BENT) & (r > 0.3 * size)).any(axis=1)
        other &= np.abs(normals[around[k]] @ frame[2]) < _STRAIGHT_ON  # where the edge ends
        beside = (np.abs(away[..., 2]) < size) & other[:, None]
        far[k] = r[beside].min(initial=far[k])
        marked = pressed[mesh.facets[around[k]]]
        on = (np.abs(away[..., 2]) < size) & (off <= _BENT) & (r > 0.1 * size)
        for face in (on & (away[..., 1] > 0), on & (away[..., 1] < 0)):
            begins = r[face & marked].min(initial=np.inf)
            if begins > size:
                far[k] = min(far[k], begins)
                continue
            loaded[k] = True
            far[k] = r[face & ~marked].min(initial=far[k])
    return np.asarray(far), loaded


def pressed_edges(mesh: Mesh) -> IntArray:
    """Nodes (n,) where a pressed surface ends on a smooth one: its pressure ends there with a jump.

    Stress is finite there, but its limits from either side differ by the pressure, and elements
    that meet the edge are wrong by a share of that which no refinement lessens
    (tests/fem/test_pressed_edges.py). Where the pressed surface ends at an edge of the body, the
    stress has one limit.
    """
    found = _surface_edges(mesh)
    ends = np.zeros(len(found.nodes), dtype=bool)
    for name, interface in mesh.interfaces.items():
        if interface.kind in _PRESSED_EVENLY:
            pressed = _rows_of(found.facets, mesh.surfaces[name])
            ends |= pressed[found.first] != pressed[found.second]
    return np.unique(found.nodes[ends & found.smooth])


@dataclass(frozen=True, eq=False)
class _SurfaceEdges:
    """The edges between the facets of a mesh's surface.

    nodes          (n, 3) of each edge: its ends and its middle
    first, second  (n,) rows of `facets` that meet there
    facets         (m, 6) of the surface
    normals        (2, n, 3) unit vectors out of the body, of both at the edge's middle
    turn           (n,) rad, between them
    concave        (n,) True if it is re-entrant
    smooth         (n,) True if curved facets alone could leave that turn between them
    """

    nodes: IntArray
    first: IntArray
    second: IntArray
    facets: IntArray
    normals: FloatArray
    turn: FloatArray
    concave: BoolArray
    smooth: BoolArray


def _surface_edges(mesh: Mesh) -> _SurfaceEdges:
    facets = mesh.facets
    edges = facets[:, [[0, 1, 3], [1, 2, 4], [2, 0, 5]]].reshape(-1, 3)
    corners = mesh.nodes[facets]
    normals = np.stack([facet_normals(corners, *_MIDDLES[side]) for side in range(3)], axis=1)
    far = np.stack([facet_normals(corners, *_OPPOSITE[side]) for side in range(3)], axis=1)
    slack = 2 * _parabola_error(_angle(normals, far)).reshape(-1)
    normals = normals.reshape(-1, 3)
    opposite = facets[:, [2, 0, 1]].reshape(-1)
    order = np.argsort(edges[:, 2], kind="stable")  # a mid-side node names its edge
    first, second = order[0::2], order[1::2]
    if not np.array_equal(edges[first, 2], edges[second, 2]):
        raise AssertionError("the boundary of the mesh is not closed")
    turn = _angle(normals[first], normals[second])
    inward = mesh.nodes[opposite[second]] - mesh.nodes[edges[second, 2]]
    concave = np.einsum("ex,ex->e", normals[first], inward) > 0
    smooth = turn <= _SHARP + slack[first] + slack[second]
    both = np.stack([normals[first], normals[second]])
    return _SurfaceEdges(edges[first], first // 3, second // 3, facets, both, turn, concave, smooth)


def _rows_of(facets: IntArray, wanted: IntArray) -> BoolArray:
    """Which of some facets (n, 6) are among others (m, 6), by their corners."""
    keys = np.sort(facets[:, :3], axis=1), np.sort(wanted[:, :3], axis=1)
    base = int(max(key.max(initial=0) for key in keys)) + 1
    first, second = (key @ np.array([base * base, base, 1]) for key in keys)
    return np.isin(first, second)


def singular_exponent(interior_angle: float) -> float:
    """Exponent of the stress singularity at an edge: stress ~ r^-exponent. 0 up to 180 degrees.

    >>> round(singular_exponent(3 * 3.141592653589793 / 2), 4)
    0.4555
    """
    from scipy.optimize import brentq

    if interior_angle <= np.pi * (1 + 1e-9):
        return 0.0
    root = brentq(
        lambda x: np.sin(x * interior_angle) + x * np.sin(interior_angle), 0.5 - 1e-12, 1 - 1e-9
    )
    return float(1 - root)


def _angle(first: FloatArray, second: FloatArray) -> FloatArray:
    """Angles (...) between unit vectors (..., 3), rad."""
    return np.asarray(np.arccos(np.clip((first * second).sum(axis=-1), -1, 1)))


def _parabola_error(turn: FloatArray) -> FloatArray:
    """Angle by which a parabola through the ends and the middle of an arc misses its end's slope.

    turn  rad, by which the arc turns; a chord c of it rises by c tan(turn/4)/2 at the middle
    """
    return np.asarray(turn / 2 - np.arctan(2 * np.tan(turn / 4)))


_MIDDLES = ((0.5, 0.0), (0.5, 0.5), (0.0, 0.5))  # of a facet's sides, in its local coordinates
_OPPOSITE = ((0.0, 1.0), (0.0, 0.0), (1.0, 0.0))  # the corner that a side does not have


# Resolution of the notch in which a peak sits by the mesh.
#
# The stress below a concave surface of radius rho falls off within a fraction of rho. Elements of
# size h that are not small against it carry the peak too low, each of them alike, so that neither
# their scatter nor a short step from one such mesh to the next tells. The missing part is of the
# order (h / rho)^2; measured on fillets of 0.15 to 2 mm between bars under bending and tension it
# is 0.05 to 0.16 of the peak times that (tests/ballesta/test_small_fillets.py). Elements larger
# than the radius see a sharp corner, whose stress grows towards it like 1 / sqrt(distance) at
# most (a crack).
#
# A groove's stress across it, normal and shear, is concentrated and so missed. Stress along the
# groove is not: beside the inner corners of a hollow section that is bent, nothing is missed.

_SHARE = 0.17  # of the peak times (h / rho)^2
_CORNER = 1.5  # h / rho from which on elements see a sharp corner
_SIDES = ((0, 1), (1, 2), (2, 0))
_BOTH_WAYS = 0.2  # of the larger curvature: with more along it, a notch is no groove
_ALIKE = np.cos(np.radians(30.0))  # between lines along one groove
_FLAT = 0.1  # of the curvature beside it: less has no direction of its own
_CORNERS = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))


def concave_curvatures(mesh: Mesh) -> FloatArray:
    """Largest concave curvature (n_nodes,), 1/mm, of the surface of the elements at each node."""
    return _curved(mesh)[0]


def across_notches(mesh: Mesh) -> FloatArray:
    """Unit vectors (n_nodes, 3) along which the surface at each node is concave.

    Zero where it is flat or convex, or concave in every direction, as in a bore's round end, and
    where grooves meet: where the most curved one runs along another line than the node's own.
    """
    return _curved(mesh)[1]


def _curved(mesh: Mesh) -> tuple[FloatArray, FloatArray]:
    """`concave_curvatures` and `across_notches`.

    Both are taken from the most curved facet at any corner of the elements that meet a node; a node
    that is itself part of a curved facet has the direction of its own.
    """
    curvatures, across, along = _facets_curved(mesh)
    most = _most_curved(curvatures, mesh.facets[:, :3], len(mesh.nodes))
    known = np.append(curvatures, 0.0)
    of_elements = most[mesh.elements]
    highest = known[of_elements].argmax(axis=1)
    facet = of_elements[np.arange(len(highest)), highest]
    found = facet[_most_curved(known[facet], mesh.elements, len(mesh.nodes))]
    own = _most_curved(curvatures, mesh.facets, len(mesh.nodes))
    across, along = (np.append(one, np.zeros((1, 3)), axis=0) for one in (across, along))
    curved = known[own] > _FLAT * known[found]
    one_groove = np.abs((along[own] * along[found]).sum(axis=1)) > _ALIKE
    nearest = np.where(curved[:, None], across[own], across[found])
    return known[found], np.where((curved & ~one_groove)[:, None], 0.0, nearest)


def _most_curved(curvatures: FloatArray, members: IntArray, n_nodes: int) -> IntArray:
    """Row (n_nodes,) of the largest curvature that each node is a member of; -1 without any.

    curvatures (n,) of facets or elements, whose nodes are their members (n, m)
    """
    order = np.argsort(curvatures, kind="stable")  # of equal indices the last one stays
    rows = np.full(n_nodes, -1)
    rows[members[order].ravel()] = np.repeat(order, members.shape[1])
    return rows


def _facets_curved(mesh: Mesh) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Largest concave curvature (n,) of each facet along its sides, and unit vectors (n, 3).

    The vectors are across the groove that the facet is part of, and along it; zero in no groove.
    The curvatures k along three sides d make the tensor K of the surface, d K d = k; its principal
    direction is the one across.
    """
    corners = mesh.nodes[mesh.facets]
    normals = np.stack([facet_normals(corners, r, s) for r, s in _CORNERS], axis=1)
    normal = normals.mean(axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    largest = np.zeros(len(corners))
    rows, curved = [], []
    first_side = corners[:, 1] - corners[:, 0]
    u = first_side - (first_side * normal).sum(axis=1, keepdims=True) * normal
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(normal, u)
    for first, second in _SIDES:
        along = corners[:, second] - corners[:, first]
        turned = ((normals[:, second] - normals[:, first]) * along).sum(axis=1)
        # a chord c of a circle of curvature k: the normals' difference along it is k c
        one = -turned / (along**2).sum(axis=1)
        largest = np.maximum(largest, one)
        x, y = (along * u).sum(axis=1), (along * v).sum(axis=1)
        size = x**2 + y**2
        rows.append(np.stack([x * x, 2 * x * y, y * y], axis=1) / size[:, None])
        curved.append(one)
    tensor = np.linalg.solve(np.stack(rows, axis=1), np.stack(curved, axis=1)[..., None])[..., 0]
    values, vectors = np.linalg.eigh(tensor[:, [0, 1, 1, 2]].reshape(-1, 2, 2))
    across = vectors[:, :1, 1] * u + vectors[:, 1:, 1] * v
    one_way = (values[:, 1] > 0.0) & (values[:, 0] < _BOTH_WAYS * values[:, 1])
    across *= one_way[:, None]
    return largest, across, np.cross(normal, across)


def notch_error(size: FloatArray, curvature: FloatArray) -> FloatArray:
    """Errors of stresses, as shares of them, on elements of sizes (mm) in notches (1/mm)."""
    ratio = np.asarray(size * curvature)
    beyond = np.sqrt(np.maximum(ratio / _CORNER, 1.0))
    return (1.0 + _SHARE * np.minimum(ratio, _CORNER) ** 2) * beyond - 1.0


def facet_normals(corners: FloatArray, r: float, s: float) -> FloatArray:
    """Return unit outward normals (n, 3) of six-node facets (n, 6, 3) at local coordinates."""
    t = 1 - r - s
    by_r = np.array([1 - 4 * t, 4 * r - 1, 0, 4 * (t - r), 4 * s, -4 * s])
    by_s = np.array([1 - 4 * t, 0, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)])
    normal = np.cross(np.einsum("a,nax->nx", by_r, corners), np.einsum("a,nax->nx", by_s, corners))
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))
