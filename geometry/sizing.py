"""Element sizes that follow an error estimate on an earlier mesh of the same part."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geometry.mesh import FloatArray, IntArray, Mesh

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
