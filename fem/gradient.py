"""Stress gradient from a surface point into the part, for the support that a notch gives.

The rule: the stress at nodes, averaged as `recovery` does, is taken as quadratic in each element;
at a surface point the slopes along the inward normal of the elements that meet there are averaged
with their volumes as weights. It is linear in the displacement: the slopes of unit loads add up as
their stresses do. The error is of first order and mostly on the side of too small slopes, so of
too little support (docs/theory/strength.md has numbers).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from fem.recovery import Recovery, tensor
from geometry.mesh import TET_EDGES, FloatArray, IntArray, Mesh, shape_gradients

_CHUNK = 4000  # elements at a time: bounds memory
_CORNER_POINTS = np.vstack([np.zeros(3), np.eye(3)])
_NODES = np.vstack(
    [_CORNER_POINTS, [_CORNER_POINTS[list(edge)].mean(axis=0) for edge in TET_EDGES]]
)
_FACET_NODES = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]])


def inward_normals(mesh: Mesh) -> FloatArray:
    """Return unit normals (n_points, 3) into the part at `mesh.surface_nodes`.

    Where faces meet at an edge, the mean of their normals, each weighted by the angle that it
    takes up around the point: the same on any mesh.
    """
    facets = mesh.boundary
    corners = mesh.nodes[facets]  # (f, 6, 3)
    r, s = _FACET_NODES.T
    t, zero = 1 - r - s, np.zeros(6)
    by_r = np.stack([1 - 4 * t, 4 * r - 1, zero, 4 * (t - r), 4 * s, -4 * s])
    by_s = np.stack([1 - 4 * t, zero, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)])
    along = np.einsum("an,fax->fnx", by_r, corners)
    across = np.einsum("an,fax->fnx", by_s, corners)
    normals = np.cross(along, across)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    angles = np.full(facets.shape, np.pi)  # of a mid-side node the facet has half the surroundings
    for corner, (one, other) in enumerate(
        ((along, across), (along, along - across), (across, across - along))
    ):
        first, second = one[:, corner], other[:, corner]
        cosine = (first * second).sum(axis=1)
        cosine /= np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
        angles[:, corner] = np.arccos(np.clip(cosine, -1.0, 1.0))
    total = np.zeros_like(mesh.nodes)
    np.add.at(total, facets, -angles[..., None] * normals)
    total[mesh.cut_nodes, 2] = 0.0  # the other half's cancel
    total = total[mesh.surface_nodes]
    return np.asarray(total / np.linalg.norm(total, axis=1, keepdims=True))


def related_gradient(stress: FloatArray, slope: FloatArray) -> FloatArray:
    """Return G = -(d sigma/dn)/sigma, 1/mm, along the inward normal; negative where it rises.

    stress, slope  (..., 6) MPa and MPa/mm, also of the difference of two positions of a cycle

    sigma is the principal stress of largest size, in its direction at the surface.
    Without stress there is no gradient: 0.
    """
    stress, slope = np.broadcast_arrays(stress, slope)
    values, vectors = np.linalg.eigh(tensor(stress))
    largest = np.abs(values).argmax(axis=-1)[..., None]
    size = np.take_along_axis(values, largest, axis=-1)[..., 0]
    direction = np.take_along_axis(vectors, largest[..., None], axis=-1)[..., 0]
    change = np.einsum("...i,...ij,...j->...", direction, tensor(slope), direction)
    gradient = np.zeros(np.shape(size))
    np.divide(-change, size, out=gradient, where=np.abs(size) > 0.0)
    return gradient


@dataclass(frozen=True, eq=False)
class SurfaceSlopes:
    """The slope of stress along the inward normal, at some or all surface points of a mesh.

    recovery   of the stress at the surface points
    rows       (n,) which of `recovery.points`; None: all
    direction  (n, 3) unit vectors into the part; None: `inward_normals`
    """

    recovery: Recovery
    rows: IntArray | None = None
    direction: FloatArray | None = None

    def __post_init__(self) -> None:
        shape, direction = (len(self.nodes), 3), self.direction
        if direction is None:
            return
        if direction.shape != shape:
            raise ValueError(f"{shape[0]} points need directions {shape}, got {direction.shape}")
        if not np.allclose(np.linalg.norm(direction, axis=1), 1.0, rtol=0.0, atol=1e-9):
            raise ValueError("directions into the part must be unit vectors")

    @cached_property
    def nodes(self) -> IntArray:
        """Node indices of the points, (n,)."""
        points = self.recovery.points
        return points if self.rows is None else np.asarray(points[self.rows])

    @cached_property
    def normals(self) -> FloatArray:
        """Unit vectors into the part at the points, (n, 3)."""
        if self.direction is not None:
            return self.direction
        normals = inward_normals(self._mesh)
        return normals if self.rows is None else np.asarray(normals[self.rows])

    def of(self, displacement: FloatArray) -> FloatArray:
        """Return the slope (n, 6, m), MPa/mm, of displacement (3 n_nodes, m), mm."""
        columns = displacement.reshape(len(displacement), -1)
        stress = np.zeros((len(self._around), 6 * columns.shape[1]))
        for start in range(0, len(self._sources), _CHUNK):
            part = self._sources[start : start + _CHUNK]
            raw = self.recovery.quadrature_stress(columns, part)
            stress += self._averaging(part) @ raw.reshape(-1, stress.shape[1])
        stress /= (self._share_at_nodes @ self._volumes)[:, None]
        smooth = stress.reshape(len(stress), 6, -1)
        smooth[np.isin(self._around, self._mesh.cut_nodes), 4:] = 0.0  # the mirror's cancel
        slope = (self._slopes @ stress).reshape(len(self.nodes), 6, -1)
        slope[np.isin(self.nodes, self._mesh.cut_nodes), 4:] = 0.0
        return np.asarray(slope)

    @property
    def _mesh(self) -> Mesh:
        return self.recovery.elements.mesh

    @cached_property
    def _volumes(self) -> FloatArray:
        return np.asarray(self.recovery.elements.weights.sum(axis=1))

    @cached_property
    def _meeting(self) -> tuple[IntArray, IntArray, IntArray]:
        """Where elements have a point: element, local node, index of the point."""
        place = np.full(len(self._mesh.nodes), -1)
        place[self.nodes] = np.arange(len(self.nodes))
        element, node = np.nonzero(place[self._mesh.elements] >= 0)
        return element, node, place[self._mesh.elements[element, node]]

    @cached_property
    def _around(self) -> IntArray:
        """Nodes of the elements that meet at the points, ascending."""
        return np.unique(self._mesh.elements[self._meeting[0]])

    @cached_property
    def _sources(self) -> IntArray:
        """Elements whose stress counts at these nodes."""
        wanted = np.zeros(len(self._mesh.nodes), dtype=bool)
        wanted[self._around] = True
        return np.flatnonzero(wanted[self._mesh.elements].any(axis=1))

    @cached_property
    def _share_at_nodes(self) -> "scipy.sparse.csr_array":
        """Matrix (n_around, n_elements) of ones where an element has a node."""
        element, _, place = self._touching(self._sources)
        shape = (len(self._around), len(self._mesh.elements))
        return scipy.sparse.coo_array(
            (np.ones(len(place)), (place, self._sources[element])), shape
        ).tocsr()

    def _touching(self, part: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """Where some elements have nodes of `_around`: index in `part`, local node, place."""
        place = np.full(len(self._mesh.nodes), -1)
        place[self._around] = np.arange(len(self._around))
        own = place[self._mesh.elements[part]]
        element, node = np.nonzero(own >= 0)
        return element, node, own[element, node]

    def _averaging(self, part: IntArray) -> "scipy.sparse.csr_array":
        """Matrix (n_around, n_part n_q): continuation times volume, summed at nodes."""
        local = self.recovery.elements.local_points
        design = np.column_stack([np.ones(len(local)), local])
        continuation = np.column_stack([np.ones(10), _NODES]) @ np.linalg.inv(design)
        element, node, place = self._touching(part)
        shares = continuation[node] * self._volumes[part[element], None]
        columns = len(local) * element[:, None] + np.arange(len(local))
        return scipy.sparse.coo_array(
            (shares.ravel(), (np.repeat(place, len(local)), columns.ravel())),
            shape=(len(self._around), len(local) * len(part)),
        ).tocsr()

    @cached_property
    def _slopes(self) -> "scipy.sparse.csr_array":
        """Matrix (n, n_around): from stress at nodes to its slope at the points."""
        element, node, point = self._meeting
        nodes = self._mesh.elements[element]
        shapes = shape_gradients(_NODES)[node]  # (meetings, 10, 3)
        jacobian = np.einsum("max,mar->mxr", self._mesh.nodes[nodes], shapes)
        along = np.linalg.solve(jacobian, self.normals[point][..., None])  # dr/dn
        volumes = self._volumes[element]
        total = np.bincount(point, volumes, minlength=len(self.nodes))
        shares = (shapes @ along)[..., 0] * (volumes / total[point])[:, None]
        columns = np.searchsorted(self._around, nodes)
        shape = (len(self.nodes), len(self._around))
        rows = np.repeat(point, nodes.shape[1])
        return scipy.sparse.coo_array((shares.ravel(), (rows, columns.ravel())), shape).tocsr()
