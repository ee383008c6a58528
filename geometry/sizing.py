"""Element sizes that follow an error estimate, and the number of elements before meshing."""

from dataclasses import dataclass
from functools import cached_property
from math import inf, pi, sqrt
from typing import Any

import numpy as np

from geometry.mesh import FloatArray, IntArray, Mesh, TooFineError
from geometry.shape import Body, Region

_STEPS = 100.0  # a size is one of so many within a factor of e
_GROWTH = 0.5  # sizes grow by at most this share of the distance from a smaller one
_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))


@dataclass(frozen=True, eq=False)
class SizeField:
    """Wanted element sizes at the corners of an earlier mesh; between them they are linear.

    Fields with the same numbers are equal, so that equal parts share their meshes.

    nodes     (n, 3) mm
    elements  (m, 4) corner node indices
    sizes     (n,)   mm, at the nodes; those of no corner are not used
    """

    nodes: FloatArray
    elements: IntArray
    sizes: FloatArray

    def __post_init__(self) -> None:
        if self.sizes.shape != (len(self.nodes),):
            raise ValueError(f"{len(self.nodes)} nodes need as many sizes, got {self.sizes.shape}")
        if not self.sizes[self.elements].min() > 0:
            raise ValueError("element sizes must be above 0")

    @cached_property
    def _content(self) -> tuple[bytes, ...]:
        return tuple(np.asarray(a).tobytes() for a in (self.nodes, self.elements, self.sizes))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, SizeField) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    def in_unit(self, unit: float) -> "SizeField":
        """Return the field with its lengths in a unit of so many mm."""
        return SizeField(self.nodes / unit, self.elements, self.sizes / unit)

    def to_gmsh(self, gmsh: Any) -> int:
        """Add the field to gmsh's current model and return its tag."""
        corners = self.nodes[self.elements]  # (m, 4, 3)
        rows = np.concatenate(
            [np.moveaxis(corners, 2, 1).reshape(-1, 12), self.sizes[self.elements]], axis=1
        )
        view = gmsh.view.add("sizes")
        gmsh.view.addListData(view, "SS", len(rows), rows.ravel())
        field = int(gmsh.model.mesh.field.add("PostView"))
        gmsh.model.mesh.field.setNumber(field, "ViewTag", view)
        return field


def element_sizes(mesh: Mesh) -> FloatArray:
    """Size of every element, (n_elements,) mm: the mean length of its six edges."""
    corners = mesh.nodes[mesh.elements[:, :4]]
    lengths = [np.linalg.norm(corners[:, i] - corners[:, j], axis=1) for i, j in _EDGES]
    return np.asarray(np.mean(lengths, axis=0))


def size_field(mesh: Mesh, wanted: FloatArray) -> SizeField:
    """Return the field of wanted sizes (n_elements,), smoothed so that neighbours fit together.

    A corner takes the smallest size of its elements; sizes then grow with distance at most as fast
    as a mesh can. Sizes come in steps of 1 %, so that the round-off of the stress that they follow
    does not change the mesh.
    """
    wanted = mesh.unit * np.exp(np.round(np.log(wanted / mesh.unit) * _STEPS) / _STEPS)
    corners = mesh.elements[:, :4]
    sizes = np.full(len(mesh.nodes), np.inf)
    np.minimum.at(sizes, corners, wanted[:, None])
    edges = np.unique(
        np.sort(np.concatenate([corners[:, pair] for pair in _EDGES]), axis=1), axis=0
    )
    lengths = np.linalg.norm(mesh.nodes[edges[:, 0]] - mesh.nodes[edges[:, 1]], axis=1)
    while True:
        before = sizes.copy()
        for here, there in ((0, 1), (1, 0)):
            reach = before[edges[:, here]] + _GROWTH * lengths
            np.minimum.at(sizes, edges[:, there], reach)
        if np.array_equal(before, sizes):
            return SizeField(mesh.nodes, corners, np.where(np.isfinite(sizes), sizes, 1.0))


_TRIANGLE = sqrt(3.0) / 4.0  # area of an equilateral triangle over its edge squared
_TETRAHEDRON = 1.0 / (6.0 * sqrt(2.0))  # volume of a regular one over its edge cubed
MOST_TRIANGLES = 150_000  # of a skin: half a minute
_MOST_ELEMENTS = 1_000_000  # of a solid before any error is known
_SAMPLES = 5  # along each parameter of a face, at which its curvature is asked
_CLOSE = 0.1  # of a region's reach, within which elements have its size
# Nodes of quadratic tetrahedra, fitted to the first meshes of all shipped parts, which they tell to
# 0.65 to 1.4: per tetrahedron of the general size and of regions, per triangle of the surface. In a
# wall of one element most edges lie on the surface.
_NODES_INSIDE, _NODES_IN_REGIONS, _NODES_ON_SURFACE = 1.4, 1.1, 1.5
SURE = 2.0  # an estimate of the unknowns may be wrong by this factor


def check_skin(gmsh: Any, sizes: tuple[float, float], per_turn: float, unit: float = 1.0) -> None:
    """Raise TooFineError where the faces of gmsh's model would take too many triangles.

    unit  mm, of the lengths in the model and of the sizes
    """
    count = skin_triangles(gmsh, sizes, per_turn)
    if not count <= MOST_TRIANGLES:
        raise TooFineError(
            f"its faces would need about {count:.1e} triangles, more than {MOST_TRIANGLES:.1e}: "
            f"elements of {unit * sizes[1]:.2g} mm where it is thinnest, smaller ones on its curves"
        )


def check_elements(count: float, size: float) -> None:
    """Raise TooFineError where a solid would take too many elements, of a size in mm."""
    if not count <= _MOST_ELEMENTS:
        raise TooFineError(
            f"would need about {count:.1e} elements of {size:.3g} mm or less, more than "
            f"{_MOST_ELEMENTS:.1e}; its walls or holes are too small for a solid, or mesh.fineness "
            "too high"
        )


def skin_triangles(gmsh: Any, sizes: tuple[float, float], per_turn: float) -> float:
    """Triangles on the faces of gmsh's model, of edges between two sizes, mm.

    per_turn  how many of them go round a full turn of a curved face
    """
    found = 0.0
    for _, face in gmsh.model.getEntities(2):
        bend = _largest_curvature(gmsh, face)
        edge = float(np.clip(2 * pi / (per_turn * bend) if bend else inf, *sizes))
        found += gmsh.model.occ.getMass(2, face) / (_TRIANGLE * edge**2)
    return found


def _largest_curvature(gmsh: Any, face: int) -> float:
    """Largest curvature that a face has at some of its points, 1/mm."""
    if gmsh.model.getType(2, face) == "Plane":
        return 0.0
    low, high = gmsh.model.getParametrizationBounds(2, face)
    u, v = (np.linspace(low[k], high[k], _SAMPLES + 2)[1:-1] for k in (0, 1))
    places = np.stack(np.meshgrid(u, v), axis=-1).ravel()
    largest, smallest, _, _ = gmsh.model.getPrincipalCurvatures(face, places)
    return float(np.abs([*largest, *smallest]).max(initial=0.0))


def solid_elements(gmsh: Any, body: Body, fineness: float) -> float:
    """Tetrahedra of a body, its regions included.

    A region's elements grow evenly from its size to the general one over its reach: of a face with
    the area A, the integral of A dx / (0.118 h(x)^3); of a curve A = pi x times its length.
    """
    general = body.size / fineness
    volume = sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.getEntities(3))
    found = volume / (_TETRAHEDRON * general**3)
    for region in body.regions:
        small = region.size / fineness
        if small < general:
            found += _region_elements(gmsh, region, small, general)[0]
    return float(found)


def solid_unknowns(gmsh: Any, body: Body, fineness: float) -> float:
    """Unknowns of a body's mesh of quadratic tetrahedra, estimated to a factor of two.

    A region below a face reaches no deeper than the volume over the area of the region's faces.
    """
    general = body.size / fineness
    volume = sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.getEntities(3))
    surface = sum(gmsh.model.occ.getMass(2, tag) for _, tag in gmsh.model.getEntities(2))
    near = taken = 0.0
    for region in body.regions:
        small = region.size / fineness
        if small < general:
            faces = sum(gmsh.model.occ.getMass(2, tag) for d, tag in region.entities if d == 2)
            depth = volume / faces if faces else inf
            elements, space = _region_elements(gmsh, region, small, general, depth)
            near, taken = near + elements, taken + space
    inside = max(volume - taken, 0.0) / (_TETRAHEDRON * general**3)
    nodes = _NODES_INSIDE * inside + _NODES_IN_REGIONS * near
    return float(3 * (nodes + _NODES_ON_SURFACE * surface / (_TRIANGLE * general**2)))


def _region_elements(
    gmsh: Any, region: Region, small: float, general: float, deepest: float = inf
) -> tuple[float, float]:
    """Tetrahedra of a region and its volume, mm3; below faces no deeper than a depth, mm."""
    depth = np.geomspace(1e-3 * _CLOSE, 1.0, 200) * region.reach
    grown = (depth / region.reach - _CLOSE) / (1.0 - _CLOSE)
    edge = small + (general - small) * np.clip(grown, 0.0, 1.0)
    found = space = 0.0
    for dimension, tag in region.entities:
        extent = gmsh.model.occ.getMass(dimension, tag)
        area: FloatArray = extent * (
            np.where(depth <= deepest, 1.0, 0.0) if dimension == 2 else pi * depth
        )
        found += float(np.trapezoid(area / (_TETRAHEDRON * edge**3), depth))
        space += float(np.trapezoid(area, depth))
    return found, space
