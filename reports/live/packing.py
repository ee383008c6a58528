"""Surfaces and numbers at their nodes as planes of bytes in one text, without loss.

viewer.js says what stands in it and reads it again, to the last bit.
"""

import zlib
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from geometry.mesh import FloatArray, IntArray

Integers = npt.NDArray[np.int32]

GZIP = 16 + zlib.MAX_WBITS
BITS = 16  # of a position, over the longest side
_MOST = 4  # planes: numbers of 32 bits


@dataclass
class Writer:
    """Collects arrays; `layout` then says what stands in the text, in its order.

    layout  per section its name, the length of its arrays, and the number of planes of each
    """

    layout: list[dict[str, object]] = field(default_factory=list)
    _chunks: list[bytes] = field(default_factory=list)

    def add(self, name: str, arrays: Sequence[npt.NDArray[np.int64]]) -> None:
        """Add a section of arrays of one length; raises ValueError beyond 32 bits.

        Signs go to the lowest bit: 0, -1, 1, -2 become 0, 1, 2, 3.
        """
        counts = []
        for values in arrays:
            folded = np.where(values < 0, -2 * values - 1, 2 * values)
            largest = int(folded.max(initial=0))
            if largest >= 1 << 8 * _MOST:
                raise ValueError(f"live payload: {name} needs more than 32 bits ({largest})")
            planes = (largest.bit_length() + 7) // 8
            whole = folded.astype("<u4").view(np.uint8).reshape(-1, 4)
            self._chunks += [whole[:, plane].tobytes() for plane in range(planes)]
            counts.append(planes)
        length = len(arrays[0]) if len(arrays) else 0
        self.layout.append({"name": name, "length": length, "planes": counts})

    def text(self) -> str:
        """All of it: base64 of gzip, the same for the same numbers."""
        # level 9 takes ten times as long for 2 % less
        packer = zlib.compressobj(5, zlib.DEFLATED, GZIP, 9, zlib.Z_FILTERED)
        return b64encode(packer.compress(b"".join(self._chunks)) + packer.flush()).decode()


@dataclass(frozen=True, eq=False)
class Placed:
    """Nodes as whole steps of a grid.

    origin     (3,) mm
    step       mm
    positions  (3, n) steps
    """

    origin: FloatArray
    step: float
    positions: Integers


def placed(nodes: FloatArray) -> Placed:
    """Round nodes (n, 3) to a grid of 2**BITS over their longest side."""
    origin = nodes.min(axis=0)
    side = float(np.ptp(nodes, axis=0).max())
    step = side / (2**BITS - 1) if side > 0 else 1.0
    return Placed(origin, step, np.rint((nodes - origin) / step).astype(np.int32).T.copy())


def morton_order(positions: Integers) -> IntArray:
    """Order of nodes along Morton's curve, which keeps neighbours together."""
    code = np.zeros(positions.shape[1], dtype=np.uint64)
    for bit in range(BITS):
        for axis in range(3):
            digit = (positions[axis].astype(np.uint64) >> np.uint64(bit)) & np.uint64(1)
            code |= digit << np.uint64(3 * bit + axis)
    return np.argsort(code, kind="stable").astype(np.int64)


def ordered_triangles(triangles: IntArray) -> Integers:
    """Triangles (3, m), each from its smallest node on, sorted by their nodes."""
    first = triangles.argmin(axis=1)
    turned = triangles[np.arange(len(triangles))[:, None], (first[:, None] + np.arange(3)) % 3]
    order = np.lexsort(turned.T[::-1])
    return np.ascontiguousarray(turned[order].T.astype(np.int32))


@dataclass(frozen=True, eq=False)
class Neighbours:
    """The neighbours of every node that come before it, each once.

    lower   all of them, node after node
    nodes   nodes that have any, ascending
    starts  where theirs begin in `lower`
    counts  how many they are
    """

    lower: IntArray
    nodes: IntArray
    starts: IntArray
    counts: IntArray

    def expected(self, values: Integers) -> npt.NDArray[np.int64]:
        """Prediction of values (n,) by earlier ones: neighbours' rounded mean, else the last value.

        The mean of k numbers of sum s is floor((2 s + k) / (2 k)), in whole numbers.
        """
        said = np.zeros(len(values), dtype=np.int64)
        said[1:] = values[:-1]
        if len(self.nodes):
            sums = np.add.reduceat(values[self.lower].astype(np.int64), self.starts)
            said[self.nodes] = (2 * sums + self.counts) // (2 * self.counts)
        return said

    def less_expected(self, arrays: Any) -> list[npt.NDArray[np.int64]]:
        """Rows of values at the nodes (n,), less what their neighbours predict."""
        return [
            values.astype(np.int64) - self.expected(values.astype(np.int32)) for values in arrays
        ]


def neighbours(triangles: Integers, count: int) -> Neighbours:
    """Neighbours along the edges of triangles (3, m) of `count` nodes."""
    first, second = triangles.astype(np.int64), np.roll(triangles, -1, axis=0).astype(np.int64)
    low, high = np.minimum(first, second).ravel(), np.maximum(first, second).ravel()
    edges = np.unique(high * count + low)
    high, lower = edges // count, edges % count
    nodes, starts, counts = np.unique(high, return_index=True, return_counts=True)
    return Neighbours(lower, nodes, starts, counts)


def relative(triangles: Integers) -> list[npt.NDArray[np.int64]]:
    """First nodes as steps from the last triangle's, the others as steps from the first."""
    first, second, third = triangles.astype(np.int64)
    return [np.diff(first, prepend=0), second - first, third - first]


def bent(weights: npt.NDArray[np.int64]) -> list[npt.NDArray[np.int64]]:
    """Second differences of a row of weights: each less the line through the last two."""
    return list(np.diff(weights, n=2, axis=1, prepend=np.zeros((len(weights), 2), dtype=np.int64)))
