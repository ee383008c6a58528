"""The mesh of a plane domain: nodes, six-node triangles, named edges on its boundary."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from geometry.mesh import FloatArray, FoldedElementError, IntArray, MeshError

# Corner pairs of the mid-side nodes 3, 4, 5 of a six-node triangle.
TRIANGLE_EDGES = ((0, 1), (1, 2), (2, 0))
_SIDES = np.array([[0, 1, 3], [1, 2, 4], [2, 0, 5]])
_NODE_POINTS = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]])


@dataclass(frozen=True, eq=False)
class PlaneMesh:
    """Curved six-node triangles of one plane domain.

    nodes     (n, 2), mm
    elements  (m, 6): corners counter-clockwise, then mid-sides 01, 12, 20
    edges     name -> (k, 3): the two ends, then the middle, with the domain on the left; `directed`
              turns them that way
    """

    nodes: FloatArray
    elements: IntArray
    edges: Mapping[str, IntArray]

    def __post_init__(self) -> None:
        if self.nodes.ndim != 2 or self.nodes.shape[1] != 2:
            raise MeshError(f"nodes must have shape (n, 2), got {self.nodes.shape}")
        if self.elements.ndim != 2 or self.elements.shape[1] != 6 or not len(self.elements):
            raise MeshError(f"elements must have shape (n, 6), n > 0, got {self.elements.shape}")
        if not np.isfinite(self.nodes).all():
            raise MeshError("the mesher gave nodes without a place: is a ligament next to nothing?")
        used = np.zeros(len(self.nodes), dtype=bool)
        used[self.elements] = True
        if not used.all():
            raise MeshError(f"{np.count_nonzero(~used)} nodes belong to no element")
        for name, edge in self.edges.items():
            if edge.ndim != 2 or edge.shape[1] != 3 or not len(edge):
                raise MeshError(f"edge {name!r} must have shape (k, 3), k > 0, got {edge.shape}")
            outside = ~_rows_in(edge, self.boundary)
            if outside.any():
                raise MeshError(
                    f"edge {name!r}: {np.count_nonzero(outside)} of {len(edge)} pieces are no "
                    "sides of the boundary with the domain on their left"
                )
        worst = self.jacobian_minimum
        if not worst > 0:
            raise FoldedElementError(f"an element is folded: smallest scaled det J is {worst:.3g}")

    @cached_property
    def jacobian_minimum(self) -> float:
        """The smallest det J over all elements, scaled by the element's mean |det J|.

        Det J of a six-node triangle is a quadratic polynomial, so six values tell its smallest
        Bernstein coefficient, which is a bound from below: no folded element passes.
        """
        values = _jacobian_determinants(self.nodes, self.elements)
        corners, middles = values[:, :3], values[:, 3:]
        ends = corners + np.roll(corners, -1, axis=1)  # of sides 01, 12, 20
        bounds = np.concatenate([corners, 2 * middles - ends / 2], axis=1)
        mean = np.abs(values.mean(axis=1, keepdims=True))
        return float((bounds / np.where(mean > 0, mean, 1.0)).min())

    @cached_property
    def boundary(self) -> IntArray:
        """Sides that belong to one element only, (b, 3), with the domain on their left."""
        sides = self.elements[:, _SIDES].reshape(-1, 3)
        _, first, counts = np.unique(
            np.sort(sides[:, :2], axis=1), axis=0, return_index=True, return_counts=True
        )
        return np.asarray(sides[first[counts == 1]])

    def edge_nodes(self, name: str) -> IntArray:
        """Nodes of a named edge, ascending; raises MeshError for a name that is not there."""
        if name not in self.edges:
            raise MeshError(f"no edge is named {name!r}; the mesh has {', '.join(self.edges)}")
        return np.unique(self.edges[name])

    def nearest_node(self, x: float, y: float) -> int:
        """Index of the node nearest to a point."""
        return int(((self.nodes - [x, y]) ** 2).sum(axis=1).argmin())


def directed(elements: IntArray, edges: IntArray) -> IntArray:
    """Pieces (k, 3) of edges, each turned so that the element it belongs to is on its left."""
    sides = elements[:, _SIDES].reshape(-1, 3)
    turned = edges[:, [1, 0, 2]]
    return np.where(_rows_in(edges, sides)[:, None], edges, turned)


def _rows_in(rows: IntArray, table: IntArray) -> npt.NDArray[np.bool_]:
    size = int(max(rows.max(), table.max())) + 1
    weights = np.array([size * size, size, 1])
    return np.isin(rows @ weights, table @ weights)


def _jacobian_determinants(nodes: FloatArray, elements: IntArray) -> FloatArray:
    """Det J at the six nodes of every element, (m, 6)."""
    barycentric = np.column_stack([1 - _NODE_POINTS.sum(axis=1), _NODE_POINTS])
    slopes = np.vstack([-np.ones(2), np.eye(2)])
    corner = (4 * barycentric - 1)[:, :, None] * slopes
    middle = [
        4 * (barycentric[:, i, None] * slopes[j] + barycentric[:, j, None] * slopes[i])
        for i, j in TRIANGLE_EDGES
    ]
    gradients = np.concatenate([corner, np.stack(middle, axis=1)], axis=1)
    jacobians = np.einsum("eax,qar->eqxr", nodes[elements], gradients, optimize=True)
    determinants: FloatArray = np.linalg.det(jacobians)
    return determinants
