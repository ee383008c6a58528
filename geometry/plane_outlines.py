"""A part seen along z, as a sheet of varying thickness: its outline in gmsh, meshed in the plane.

The sheet may be several regions: where the thickness jumps, stress jumps, and is recovered on each
side by itself. The regions of a stack keep nodes of their own (leaves that slide on each other).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from geometry.mesh import FloatArray, IntArray, Interface, MeshError
from geometry.meshing import Region, gmsh_session
from geometry.plane_mesh import TRIANGLE_EDGES, PlaneMesh, directed

_GROWTH = 0.5  # sizes grow by at most this share of the distance from a smaller one
_STEPS = 100.0  # a size is one of so many within a factor of e
_SAME = 1e-6  # of a length: how close a curve must be to be the one that is meant
_SAMPLES = 16  # of the thickness in an element
_LINE, _TRIANGLE = 8, 9  # gmsh's types of quadratic lines and triangles


@dataclass(frozen=True)
class Drawn:
    """What was drawn in gmsh's current model.

    curves   name -> tags of boundary curves
    size     mm, general element size
    regions  where elements are smaller
    """

    curves: Mapping[str, Sequence[int]]
    size: float
    regions: Sequence[Region]


@dataclass(frozen=True, eq=False)
class PlaneOutline:
    """A part as a sheet.

    draw        draws it in gmsh's current model
    thickness   points (n, 2) -> mm (n,), all its material along z together
    interfaces  where other parts press
    face        mm, height z at which stress is shown; None: on the faces of a solid sheet, +-t/2
    stacked     whether its regions have nodes of their own, with equal displacement along y
    bolted_at   mm, x at which a stack's regions do not slide on each other either
    seams       name of the lines inside at which the thickness jumps
    """

    draw: Callable[[Any], Drawn]
    thickness: Callable[[FloatArray], FloatArray]
    interfaces: Sequence[Interface]
    face: float | None = None
    stacked: bool = False
    bolted_at: float | None = None
    seams: str = "seam"


@dataclass(frozen=True, eq=False)
class SheetMesh:
    """The mesh of a sheet.

    region     (n_elements,) number of the region that each element belongs to
    thickness  (n_elements,) mm, mean of each element
    depth      points (n, 2) -> mm (n,), the thickness at any point
    ties       (n, 2) nodes of a stack's regions at the same place
    bolted     (k,) which of the ties hold along x, too
    """

    mesh: PlaneMesh
    region: IntArray
    thickness: FloatArray
    depth: Callable[[FloatArray], FloatArray]
    ties: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    bolted: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    @cached_property
    def sides(self) -> tuple[IntArray, IntArray]:
        """Node and region (n,) of every place of the sheet, a node on a seam once for each side."""
        keys = np.unique(self._keys)
        return keys // self._count, keys % self._count

    @cached_property
    def side_of(self) -> IntArray:
        """Number of the place in `sides` of every element's nodes, (n_elements, 6)."""
        return np.searchsorted(np.unique(self._keys), self._keys)

    @property
    def _count(self) -> int:
        return int(self.region.max()) + 1

    @property
    def _keys(self) -> IntArray:
        return np.asarray(self.mesh.elements * self._count + self.region[:, None])

    @cached_property
    def shown(self) -> IntArray:
        """Numbers of the places on the outline and on seams."""
        nodes, _ = self.sides
        on = np.zeros(len(self.mesh.nodes), dtype=bool)
        on[self.mesh.boundary] = True
        several = np.bincount(nodes, minlength=len(on)) > 1
        return np.flatnonzero(on[nodes] | several[nodes])

    @cached_property
    def element_sizes(self) -> FloatArray:
        """Mean length of every element's sides, (n_elements,) mm."""
        corners = self.mesh.nodes[self.mesh.elements[:, :3]]
        return np.asarray(
            np.mean(
                [np.linalg.norm(corners[:, i] - corners[:, j], axis=1) for i, j in TRIANGLE_EDGES],
                axis=0,
            )
        )


@dataclass(frozen=True, eq=False)
class PlaneSizes:
    """Wanted element sizes at the corners of an earlier mesh; between them they are linear.

    nodes (n, 2) mm, triangles (m, 3) corner node indices, sizes (n,) mm
    """

    nodes: FloatArray
    triangles: IntArray
    sizes: FloatArray

    def to_gmsh(self, gmsh: Any) -> int:
        """Add the field to gmsh's current model and return its tag."""
        places = np.zeros((len(self.triangles), 3, 3))
        places[:, :2] = np.moveaxis(self.nodes[self.triangles], 2, 1)
        rows = np.concatenate([places.reshape(-1, 9), self.sizes[self.triangles]], axis=1)
        view = gmsh.view.add("sizes")
        gmsh.view.addListData(view, "ST", len(rows), rows.ravel())
        number = int(gmsh.model.mesh.field.add("PostView"))
        gmsh.model.mesh.field.setNumber(number, "ViewTag", view)
        return number


def plane_sizes(sheet: SheetMesh, wanted: FloatArray) -> PlaneSizes:
    """Return the field of wanted sizes (n_elements,), smoothed so that neighbours fit together."""
    mesh = sheet.mesh
    wanted = np.exp(np.round(np.log(wanted) * _STEPS) / _STEPS)
    sizes = np.full(len(mesh.nodes), np.inf)
    np.minimum.at(sizes, mesh.elements[:, :3], wanted[:, None])
    edges = np.unique(
        np.sort(np.concatenate([mesh.elements[:, pair] for pair in TRIANGLE_EDGES]), axis=1), axis=0
    )
    if len(sheet.ties):
        edges = np.concatenate([edges, np.sort(sheet.ties, axis=1)])
    lengths = np.linalg.norm(mesh.nodes[edges[:, 0]] - mesh.nodes[edges[:, 1]], axis=1)
    while True:
        before = sizes.copy()
        for here, there in ((0, 1), (1, 0)):
            np.minimum.at(sizes, edges[:, there], before[edges[:, here]] + _GROWTH * lengths)
        if np.array_equal(before, sizes):
            known = np.where(np.isfinite(sizes), sizes, 1.0)
            return PlaneSizes(mesh.nodes, mesh.elements[:, :3], known)


def mesh_outline(
    outline: PlaneOutline, *, fineness: float = 1.0, sizes: PlaneSizes | None = None
) -> SheetMesh:
    """Mesh a sheet; `fineness` divides every element size, and `sizes` may ask for smaller ones.

    Raises MeshError if gmsh gives up or the mesh is not usable.
    """
    if not fineness > 0:
        raise ValueError(f"fineness must be above 0, got {fineness}")
    with gmsh_session() as gmsh:
        try:
            drawn = outline.draw(gmsh)
            _set_sizes(gmsh, drawn, fineness, sizes)
            gmsh.model.mesh.generate(2)
        except MeshError:
            raise
        except Exception as error:  # gmsh raises bare Exception only
            raise MeshError(f"gmsh could not mesh the part's outline: {error}") from error
        return _read(gmsh, outline, drawn)


def _set_sizes(gmsh: Any, drawn: Drawn, fineness: float, sizes: PlaneSizes | None) -> None:
    fields = gmsh.model.mesh.field
    parts = []
    for region in drawn.regions:
        distance, threshold = fields.add("Distance"), fields.add("Threshold")
        fields.setNumbers(distance, "CurvesList", [tag for _, tag in region.entities])
        fields.setNumber(distance, "Sampling", 60)
        fields.setNumber(threshold, "InField", distance)
        for name, value in (
            ("SizeMin", region.size / fineness),
            ("SizeMax", drawn.size / fineness),
            ("DistMin", 0.1 * region.reach),
            ("DistMax", region.reach),
        ):
            fields.setNumber(threshold, name, value)
        parts.append(threshold)
    if sizes is not None:
        parts.append(sizes.to_gmsh(gmsh))
    smallest = fields.add("Min")
    fields.setNumbers(smallest, "FieldsList", parts)
    fields.setAsBackgroundMesh(smallest)
    gmsh.option.setNumber("Mesh.MeshSizeMax", drawn.size / fineness)


def _read(gmsh: Any, outline: PlaneOutline, drawn: Drawn) -> SheetMesh:
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    index = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    index[tags] = np.arange(len(tags))
    places = np.asarray(coordinates, dtype=float).reshape(-1, 3)[:, :2]
    faces = [tag for _, tag in gmsh.model.getEntities(2)]
    parts = [_oriented(places, _elements(gmsh, index, _TRIANGLE, tag)) for tag in faces]
    region = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
    elements = np.concatenate(parts)
    key = elements + (len(places) * region[:, None] if outline.stacked else 0)
    used, own = np.unique(key, return_inverse=True)
    own = own.reshape(key.shape)
    nodes = places[used % len(places)]
    edges = {}
    for name, curves in drawn.curves.items():
        if not curves:
            raise MeshError(f"no curve of the outline was found for {name!r}")
        pieces = []
        for tag in curves:
            sheet = faces.index(int(gmsh.model.getAdjacencies(1, tag)[0][0]))
            wanted = _elements(gmsh, index, _LINE, tag)
            pieces.append(
                np.searchsorted(used, wanted + (len(places) * sheet if outline.stacked else 0))
            )
        edges[name] = directed(own, np.concatenate(pieces))
    mesh = PlaneMesh(nodes, own, edges)
    mean = outline.thickness(_inner_points(mesh)).reshape(-1, _SAMPLES).mean(axis=1)
    ties = _ties(used % len(places)) if outline.stacked else np.zeros((0, 2), dtype=np.int64)
    bolted = np.zeros(0, dtype=np.int64)
    if outline.bolted_at is not None and len(ties):
        size = float(np.ptp(nodes[:, 0]))
        away = np.abs(nodes[ties[:, 0], 0] - outline.bolted_at)
        bolted = np.flatnonzero(away < _SAME * size)
        if not len(bolted):
            raise MeshError(f"no nodes at x = {outline.bolted_at:g} mm, where the stack is bolted")
    return SheetMesh(mesh, region, mean, outline.thickness, ties, bolted)


def _inner_points(mesh: PlaneMesh) -> FloatArray:
    """Points inside of every element, (_SAMPLES n_elements, 2), of equal weight.

    The middles of the triangles into which its sides, taken as straight, divide it.
    """
    n = int(_SAMPLES**0.5)
    lower = [(i + 1 / 3, j + 1 / 3) for i in range(n) for j in range(n - i)]
    upper = [(i + 2 / 3, j + 2 / 3) for i in range(n) for j in range(n - i - 1)]
    shares = np.array(lower + upper) / n
    weights = np.column_stack([1 - shares.sum(axis=1), shares])
    return np.asarray((weights @ mesh.nodes[mesh.elements[:, :3]]).reshape(-1, 2))


def _ties(original: IntArray) -> IntArray:
    """Pairs of nodes that were the same one, each with the first of them, (n, 2)."""
    order = np.argsort(original, kind="stable")
    _, start, inverse = np.unique(original[order], return_index=True, return_inverse=True)
    first = order[start[inverse]]
    apart = first != order
    return np.stack([first[apart], order[apart]], axis=1)


def _oriented(places: FloatArray, elements: IntArray) -> IntArray:
    """The triangles with their corners counter-clockwise."""
    a, b, c = np.moveaxis(places[elements[:, :3]], 1, 0)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    return np.where(area[:, None] > 0, elements, elements[:, [0, 2, 1, 5, 4, 3]])


def _elements(gmsh: Any, index: IntArray, kind: int, tag: int) -> IntArray:
    """Node indices of the lines (3) or triangles (6) of a curve or face."""
    _, connectivity = gmsh.model.mesh.getElementsByType(kind, tag)
    found: IntArray = index[np.asarray(connectivity, dtype=np.int64)]
    return found.reshape(-1, 3 if kind == _LINE else 6)
