"""Nodes that move where the part lets them: free inside of it, on the surface along it.

A node on a CAD face has two coordinates of that face, one on a CAD edge has one, a corner of the
CAD body has none. Moves along the face are in mm along the tangents where the node began, so that
all count alike.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from geometry.mesh import BoolArray, FloatArray, IntArray

_SAME = 1e-6  # of the part's size: a node is where its coordinates on the face say
_FLAT = 1e-6  # of the longest tangent: a shorter second one is the pole of a face


@dataclass(frozen=True, eq=False)
class _Patch:
    """Some nodes on one CAD face or edge.

    entity   (dimension, tag) of gmsh
    rows     (n,)        their rows among the moving nodes
    start    (n, d)      coordinates on the face or edge
    per_mm   (n, d, d)   coordinates per mm along d tangents
    """

    entity: tuple[int, int]
    rows: IntArray
    start: FloatArray
    per_mm: FloatArray


class Gliding:
    """Nodes of gmsh's model that may move.

    moving  (m,) indices of nodes, ascending
    """

    def __init__(self, gmsh: Any, nodes: FloatArray, index: IntArray, wanted: IntArray) -> None:
        """Let the nodes `wanted` (k,) move; nodes (n, 3) mm, index of each of gmsh's node tags."""
        self._gmsh = gmsh
        inside: list[IntArray] = []
        on: list[tuple[tuple[int, int], IntArray, FloatArray, FloatArray]] = []
        chosen: BoolArray = np.zeros(len(nodes), dtype=bool)
        chosen[wanted] = True
        for entity in gmsh.model.getEntities():
            tags = gmsh.model.mesh.getNodes(*entity, returnParametricCoord=False)[0]
            some = index[np.asarray(tags, dtype=np.int64)]
            some = some[chosen[some]]
            if entity[0] == 3:
                inside.append(some)
            elif entity[0] in (1, 2) and len(some):
                on.extend(self._on(entity, some, nodes))
        self.moving: IntArray = np.sort(np.concatenate([*inside, *(some for _, some, *_ in on)]))
        self._start = nodes[self.moving]
        self._inside = np.searchsorted(self.moving, np.concatenate(inside))
        self._patches = [
            _Patch(entity, np.searchsorted(self.moving, some), start, per_mm)
            for entity, some, start, per_mm in on
        ]

    def _on(
        self, entity: tuple[int, int], some: IntArray, nodes: FloatArray
    ) -> Iterator[tuple[tuple[int, int], IntArray, FloatArray, FloatArray]]:
        """Those nodes of a face or edge that have coordinates and tangents there."""
        try:
            flat = self._gmsh.model.getParametrization(*entity, nodes[some].ravel())
            start = np.reshape(flat, (len(some), -1))
            places, tangents = self._at(entity, start)
        except Exception:  # gmsh raises bare Exception only; on such a face no node moves
            return
        upper = np.linalg.qr(tangents, mode="r")  # (n, d, d)
        lengths = np.abs(np.diagonal(upper, axis1=1, axis2=2))
        off = np.linalg.norm(places - nodes[some], axis=1)
        good = (off < _SAME * np.ptp(nodes, axis=0).max()) & (
            lengths.min(axis=1) > _FLAT * lengths.max(axis=1)
        )
        if good.any():
            yield entity, some[good], start[good], np.linalg.inv(upper[good])

    def _at(self, entity: tuple[int, int], where: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Places (n, 3) and tangents (n, 3, d) at coordinates (n, d) of a face or edge."""
        flat = where.ravel()
        places = np.reshape(self._gmsh.model.getValue(*entity, flat), (-1, 3))
        tangents = np.reshape(self._gmsh.model.getDerivative(*entity, flat), (len(where), -1, 3))
        return places, np.swapaxes(tangents, 1, 2)

    def places(self, moves: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Places (m, 3) mm after moves (m, 3) mm, and slopes (m, 3, 3): place by move.

        On a face the third move does nothing, on an edge the second and third.
        """
        found = self._start.copy()
        slopes = np.zeros((len(found), 3, 3))
        found[self._inside] += moves[self._inside]
        slopes[self._inside] = np.eye(3)
        for patch in self._patches:
            count = patch.start.shape[1]
            own = moves[patch.rows, :count]
            where = patch.start + np.einsum("nij,nj->ni", patch.per_mm, own)
            places, tangents = self._at(patch.entity, where)
            # where nothing moves, the node stays to the last bit
            found[patch.rows] = np.where(np.any(own, axis=1)[:, None], places, found[patch.rows])
            slopes[patch.rows, :, :count] = tangents @ patch.per_mm
        return found, slopes
