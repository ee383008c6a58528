"""A mesh carried over to a shape of other dimensions, so that both are alike node by node.

Nodes keep the CAD vertex, edge or face that they are on: those of an edge stand at the same share
of its parameter, those of a face go by Laplace's equation between its edges and from there to the
nearest place on the face, those inside by Laplace's equation between the faces. A mid-side node
inside keeps its distance from the middle of its side. Elements that fold are mended as those of
a new mesh are (geometry/curving.py). Where the bodies differ in more than dimensions, or an element
stays folded, there is no such mesh.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from math import factorial
from typing import Any

import numpy as np

from geometry.curving import ENOUGH, bent, least_coefficients, nearly_folded
from geometry.mesh import (
    TET_EDGES,
    BoolArray,
    FloatArray,
    FoldedElementError,
    IntArray,
    Mesh,
    MeshError,
)
from geometry.meshing import gmsh_session, rounded
from geometry.shape import Body, Buildable, in_unit


class Carrier:
    """A mesh that is carried over to other shapes, and the body that it was made of.

    digest  of the mesh: equal ones carry it to the same mesh of a shape
    """

    def __init__(self, mesh: Mesh, shape: Buildable) -> None:
        """Take the mesh of a shape; raises MeshError for a stack of bodies."""
        if mesh.entities is None:
            raise MeshError("a mesh of a stack of bodies is not carried over")
        self._mesh, self._entities = mesh, mesh.entities
        self.digest = sha256(mesh.nodes.tobytes() + mesh.elements.tobytes()).hexdigest()
        self._nodes = mesh.nodes / mesh.unit
        with gmsh_session() as gmsh:
            _built(gmsh, shape, mesh.unit)
            self._topology, self._outline = _topology(gmsh), _Outline(gmsh)
            self._shares = self._outline.shares(self._nodes, self._entities)

    def to(self, shape: Buildable) -> Mesh:
        """Return the mesh of another shape.

        Raises MeshError where the two differ in more than dimensions, FoldedElementError where an
        element stays folded.
        """
        mesh, entities = self._mesh, self._entities
        with gmsh_session() as gmsh:
            body = _built(gmsh, shape, mesh.unit)
            if _topology(gmsh) != self._topology:
                raise MeshError("it has other faces and edges")
            nodes = self._on_edges(_Outline(gmsh))
            nodes = self._on_faces(gmsh, nodes)
            solids = gmsh.model.getEntities(3)
            volume = float(sum(gmsh.model.occ.getMass(3, tag) for _, tag in solids))
        nodes = self._moved(nodes, mesh.elements, TET_EDGES, 3)
        if least_coefficients(nodes, mesh.elements).min() < ENOUGH:
            nodes = bent(nodes, mesh.elements, np.flatnonzero(entities[:, 0] == 3))
            if nearly_folded(nodes, mesh.elements).any():
                raise FoldedElementError("an element folds")
        nodes = rounded(nodes)
        if mesh.half:
            nodes[mesh.cut_nodes, 2] = 0.0
        return replace(
            mesh,
            nodes=mesh.unit * nodes,
            interfaces={one.name: one.in_mm(mesh.unit) for one in body.interfaces},
            volume_cad=mesh.unit**3 * volume,
            mesher=f"{mesh.mesher}, carried over",
        )

    def _on_edges(self, outline: "_Outline") -> FloatArray:
        """Nodes (n, 3), those on vertices and edges at their places on another body."""
        nodes = self._nodes.copy()
        for tag, place in outline.vertices.items():
            nodes[(self._entities == (0, tag)).all(axis=1)] = place
        for tag, (some, shares) in self._shares.items():
            nodes[some] = outline.edges[tag].at(shares, self._outline.edges[tag])
        return nodes

    def _on_faces(self, gmsh: Any, nodes: FloatArray) -> FloatArray:
        """Nodes (n, 3), those on faces at their places too; `nodes` as those on edges have them."""
        nodes = self._moved(nodes, self._mesh.facets, ((0, 1), (1, 2), (2, 0)), 2)
        for _, tag in gmsh.model.getEntities(2):
            some = np.flatnonzero((self._entities == (2, tag)).all(axis=1))
            if len(some) and gmsh.model.getType(2, tag) != "Plane":  # there they are on it
                closest, _ = gmsh.model.getClosestPoint(2, tag, nodes[some].ravel())
                nodes[some] = np.reshape(closest, (-1, 3))
        return nodes

    def _moved(
        self, nodes: FloatArray, cells: IntArray, sides: Sequence[tuple[int, int]], dimension: int
    ) -> FloatArray:
        """Nodes (n, 3) where those on entities of a dimension follow those that have their places.

        cells  triangles or tetrahedra: corners, then the nodes of their sides

        Mid-side nodes move as the ends of their sides on the average.
        """
        free = self._entities[:, 0] == dimension
        count = cells.shape[1] - len(sides)
        away = harmonic(self._nodes, nodes - self._nodes, cells[:, :count], free)
        for k, side in enumerate(sides, count):
            some = cells[free[cells[:, k]]]
            away[some[:, k]] = away[some[:, side]].mean(axis=1)
        return np.asarray(self._nodes + away)


def harmonic(
    nodes: FloatArray, known: FloatArray, simplices: IntArray, free: BoolArray
) -> FloatArray:
    """Values (n, m) at nodes (n, 3), those at free corners of simplices by Laplace's equation.

    known  (n, m), of which those at the other corners count; free (n,)

    Linear triangles or tetrahedra: the integral of the gradients' products is m B^T (E E^T)^-1 B,
    with the sides E (d, 3) from the first corner, B = [-1 I] and the measure sqrt(det E E^T) / d!.
    """
    from scipy.sparse import csc_matrix
    from scipy.sparse.linalg import splu

    corners = np.unique(simplices)
    asked, held = corners[free[corners]], corners[~free[corners]]
    found = known.copy()
    if not len(asked):
        return found
    count = simplices.shape[1]
    sides = nodes[simplices[:, 1:]] - nodes[simplices[:, :1]]
    gram = sides @ sides.transpose(0, 2, 1)
    slopes = np.hstack([-np.ones((count - 1, 1)), np.eye(count - 1)])
    measure = np.sqrt(np.linalg.det(gram)) / factorial(count - 1)
    local = measure[:, None, None] * (slopes.T @ np.linalg.inv(gram) @ slopes)
    places = np.repeat(simplices, count, axis=1).ravel(), np.tile(simplices, (1, count)).ravel()
    rows = csc_matrix((local.ravel(), places), shape=(len(nodes),) * 2)[asked]
    found[asked] = splu(csc_matrix(rows[:, asked])).solve(-(rows[:, held] @ known[held]))
    return found


def _built(gmsh: Any, shape: Buildable, unit: float) -> Body:
    try:
        return in_unit(shape, unit).build(gmsh)
    except MeshError:
        raise
    except Exception as error:  # gmsh raises bare Exception only
        raise MeshError(f"gmsh could not build the part: {error}") from error


def _topology(gmsh: Any) -> list[tuple[Any, ...]]:
    """Every entity of the model, its kind, and those of one dimension less that it ends at."""
    return [
        (*entity, gmsh.model.getType(*entity), sorted(gmsh.model.getAdjacencies(*entity)[1]))
        for entity in gmsh.model.getEntities()
    ]


@dataclass(frozen=True, eq=False)
class _Edge:
    """An edge of the body in gmsh's current model.

    low, high  least and largest parameter
    start      its vertex at the least one, (3,); 0 of an edge without
    tangent    (3,) there
    closed     True if it ends where it starts
    """

    gmsh: Any
    tag: int
    low: float
    high: float
    start: int
    tangent: FloatArray
    closed: bool

    def at(self, shares: FloatArray, other: "_Edge") -> FloatArray:
        """Places (n, 3) at shares (n,) of the parameter, counted from the start of another edge."""
        if not len(shares):
            return np.zeros((0, 3))
        turned = self.tangent @ other.tangent < 0 if self.closed else self.start != other.start
        where = self.low + (1 - shares if turned else shares) * (self.high - self.low)
        return np.reshape(self.gmsh.model.getValue(1, self.tag, where), (-1, 3))


class _Outline:
    """Vertices and edges of the body in gmsh's current model, by tag."""

    def __init__(self, gmsh: Any) -> None:
        self._gmsh, model = gmsh, gmsh.model
        self.vertices = {
            tag: np.array(model.getValue(0, tag, [])) for _, tag in model.getEntities(0)
        }
        self.edges = {tag: self._edge(tag) for _, tag in model.getEntities(1)}

    def _edge(self, tag: int) -> _Edge:
        model = self._gmsh.model
        (low,), (high,) = model.getParametrizationBounds(1, tag)
        first = model.getValue(1, tag, [low])
        ends = [int(one) for one in model.getAdjacencies(1, tag)[1]]
        away = [float(np.linalg.norm(self.vertices[one] - first)) for one in ends]
        start = ends[int(np.argmin(away))] if ends else 0
        tangent = np.array(model.getDerivative(1, tag, [low]))
        return _Edge(self._gmsh, tag, float(low), float(high), start, tangent, len(ends) < 2)

    def shares(
        self, nodes: FloatArray, entities: IntArray
    ) -> dict[int, tuple[IntArray, FloatArray]]:
        """The nodes on each edge (n,), and the shares (n,) of its parameter where they stand."""
        found = {}
        for tag, edge in self.edges.items():
            some = np.flatnonzero((entities == (1, tag)).all(axis=1))
            flat = self._gmsh.model.getParametrization(1, tag, nodes[some].ravel())
            found[tag] = some, (np.asarray(flat) - edge.low) / (edge.high - edge.low)
        return found
