"""Meshes of plane domains: mapped grids of triangles, and outlines meshed by gmsh."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geometry.mesh import FloatArray, IntArray
from geometry.meshing import gmsh_session

from .mesh import PlaneMesh, directed

SQUARE = ("bottom", "right", "top", "left")


def mapped(
    columns: int | FloatArray,
    rows: int | FloatArray,
    mapping: Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]],
    *,
    diagonals: str = "alternate",
) -> PlaneMesh:
    """The unit square cut into a grid, each cell into two triangles, and mapped.

    columns    number of cells along s, or the cells' limits from 0 to 1
    mapping    s, t -> x, y, keeping the orientation; mid-side nodes are mapped too
    diagonals  "alternate", or "same": all from the lower left to the upper right

    Edges "bottom" t=0, "right" s=1, "top" t=1, "left" s=0.
    """
    s, t = (_with_middles(cells) for cells in (columns, rows))
    grid_s, grid_t = np.meshgrid(s, t, indexing="ij")
    across = len(t)

    def node(i: IntArray, j: IntArray) -> IntArray:
        return i * across + j

    i, j = (
        k.ravel()
        for k in np.meshgrid(
            np.arange(0, len(s) - 1, 2), np.arange(0, across - 1, 2), indexing="ij"
        )
    )
    a, b, c, d = node(i, j), node(i + 2, j), node(i + 2, j + 2), node(i, j + 2)
    ab, bc, cd, da = node(i + 1, j), node(i + 2, j + 1), node(i + 1, j + 2), node(i, j + 1)
    middle = node(i + 1, j + 1)
    rising = np.stack([[a, b, c, ab, bc, middle], [a, c, d, middle, cd, da]])
    falling = np.stack([[a, b, d, ab, middle, da], [b, c, d, bc, cd, middle]])
    other = ((i + j) // 2 % 2 == 1) & (diagonals == "alternate")
    elements = np.where(other, falling, rising).transpose(0, 2, 1).reshape(-1, 6)

    first, last = np.arange(0, len(s) - 1, 2), np.arange(0, across - 1, 2)
    along_s = np.stack([first, first + 2, first + 1], axis=1)
    along_t = np.stack([last, last + 2, last + 1], axis=1)
    edges = {
        "bottom": node(along_s, 0 * along_s),
        "right": node(0 * along_t + len(s) - 1, along_t),
        "top": node(along_s, 0 * along_s + across - 1),
        "left": node(0 * along_t, along_t),
    }
    nodes = np.stack(mapping(grid_s.ravel(), grid_t.ravel()), axis=1)
    return PlaneMesh(nodes, elements, {k: directed(elements, e) for k, e in edges.items()})


def _with_middles(cells: int | FloatArray) -> FloatArray:
    limits = np.linspace(0, 1, cells + 1) if isinstance(cells, int) else np.asarray(cells)
    both = np.empty(2 * len(limits) - 1)
    both[::2], both[1::2] = limits, (limits[:-1] + limits[1:]) / 2
    return both


def geometric(count: int, growth: float) -> FloatArray:
    """Limits from 0 to 1 of `count` cells, each `growth` times its neighbour below."""
    return np.r_[0.0, np.cumsum(growth ** np.arange(count))] / (growth ** np.arange(count)).sum()


def ring(inner: float, outer: float, start: float, end: float):
    """A mapping of s to the radius and of t to the angle, degrees."""

    def mapping(s: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        radius, angle = inner + (outer - inner) * s, np.radians(start + (end - start) * t)
        return radius * np.cos(angle), radius * np.sin(angle)

    return mapping


@dataclass(frozen=True)
class Piece:
    """One curve of an outline, from `start` to the start of the next piece.

    name    edge it belongs to
    centre  of a circular arc
    major   a point on the major axis, if the arc is an ellipse's
    """

    start: tuple[float, float]
    name: str
    centre: tuple[float, float] | None = None
    major: tuple[float, float] | None = None


@dataclass(frozen=True)
class Fine:
    """A smaller element size on named edges or at points, grown to the general one at `reach`."""

    places: tuple[str | tuple[float, float], ...]
    size: float
    reach: float


@dataclass(frozen=True)
class Outline:
    """A plane domain: loops of pieces, the outer one first, and its element sizes.

    size   mm, general element size
    fines  where it is smaller
    """

    loops: tuple[tuple[Piece, ...], ...]
    size: float
    fines: tuple[Fine, ...] = ()


def meshed(outline: Outline, fineness: float = 1.0) -> PlaneMesh:
    """The outline meshed by gmsh with ballesta's pinned options; fineness divides every size."""
    with gmsh_session() as gmsh:
        points, curves, loops = {}, {}, []
        occ = gmsh.model.occ

        def point(place):
            key = tuple(np.round(place, 9))
            if key not in points:
                points[key] = occ.addPoint(*key, 0)
            return points[key]

        for loop in outline.loops:
            tags = []
            for piece, following in zip(loop, (*loop[1:], loop[0]), strict=True):
                ends = point(piece.start), point(following.start)
                if piece.centre is None:
                    tag = occ.addLine(*ends)
                elif piece.major is None:
                    tag = occ.addCircleArc(ends[0], point(piece.centre), ends[1])
                else:
                    tag = occ.addEllipseArc(
                        ends[0], point(piece.centre), point(piece.major), ends[1]
                    )
                tags.append(tag)
                curves.setdefault(piece.name, []).append(tag)
            loops.append(occ.addCurveLoop(tags))
        surface = occ.addPlaneSurface(loops)
        occ.synchronize()
        _set_sizes(gmsh, outline, fineness, points, curves)
        gmsh.model.mesh.generate(2)
        return _read(gmsh, surface, curves)


def _set_sizes(gmsh, outline, fineness, points, curves):
    field, thresholds = gmsh.model.mesh.field, []
    for fine in outline.fines:
        distance = field.add("Distance")
        at = [points[tuple(np.round(p, 9))] for p in fine.places if not isinstance(p, str)]
        field.setNumbers(distance, "PointsList", at)
        on = [tag for name in fine.places if isinstance(name, str) for tag in curves[name]]
        field.setNumbers(distance, "CurvesList", on)
        field.setNumber(distance, "Sampling", 200)
        threshold = field.add("Threshold")
        field.setNumber(threshold, "InField", distance)
        field.setNumber(threshold, "SizeMin", fine.size / fineness)
        field.setNumber(threshold, "SizeMax", outline.size / fineness)
        field.setNumber(threshold, "DistMin", 0.1 * fine.reach)
        field.setNumber(threshold, "DistMax", fine.reach)
        thresholds.append(threshold)
    if thresholds:
        smallest = field.add("Min")
        field.setNumbers(smallest, "FieldsList", thresholds)
        field.setAsBackgroundMesh(smallest)
    gmsh.option.setNumber("Mesh.MeshSizeMax", outline.size / fineness)


def _read(gmsh, surface, curves) -> PlaneMesh:
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    index = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    index[tags] = np.arange(len(tags))
    places = np.round(np.asarray(coordinates).reshape(-1, 3)[:, :2], 10)
    _, connectivity = gmsh.model.mesh.getElementsByType(9, surface)
    elements = index[np.asarray(connectivity, dtype=np.int64).reshape(-1, 6)]
    a, b, c = (places[elements[:, k]] for k in range(3))
    if np.linalg.det(np.stack([b - a, c - a], axis=1)).sum() < 0:
        elements = elements[:, [0, 2, 1, 5, 4, 3]]
    used, renumbered = np.unique(elements, return_inverse=True)
    elements = renumbered.reshape(-1, 6)
    edges = {}
    for name, members in curves.items():
        parts = [gmsh.model.mesh.getElementsByType(8, tag)[1] for tag in members]
        pieces = index[np.concatenate(parts).astype(np.int64).reshape(-1, 3)]
        edges[name] = directed(elements, np.searchsorted(used, pieces))
    return PlaneMesh(places[used], elements, edges)
