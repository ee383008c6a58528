"""Sharp re-entrant edges: where linear elasticity has no finite stress.

At a re-entrant edge whose interior angle is omega > 180 degrees the stress grows towards the edge
like r^(lambda - 1), with lambda in (1/2, 1) the smallest root of sin(lambda omega) +
lambda sin(omega) = 0 (M. L. Williams, J. Appl. Mech. 19 (1952) 526, free faces, symmetric mode). A
finite-element peak there grows with every refinement and means nothing.

Where a pressure ends on a smooth surface the stress is finite, but jumps: `pressed_edges`.
"""

from dataclasses import dataclass

import numpy as np

from fem.notch_resolution import facet_normals
from geometry.mesh import BoolArray, FloatArray, IntArray, Mesh

_PRESSED_EVENLY = ("bore", "journal")  # along their length; a clamp presses little
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
    turn           (n,) rad, between the normals of both
    concave        (n,) True if it is re-entrant
    smooth         (n,) True if curved facets alone could leave that turn between them
    """

    nodes: IntArray
    first: IntArray
    second: IntArray
    facets: IntArray
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
    return _SurfaceEdges(edges[first], first // 3, second // 3, facets, turn, concave, smooth)


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
