"""Order in which a surface is written, and the prediction of a node's value by its neighbours."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from checks.result.live_fields import FloatArray, IntArray

Integers = npt.NDArray[np.int32]

BITS = 16  # of a position, over the longest side
_MORTON_BITS = 16


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
    """Order of nodes along Morton's curve, so that what is near stands near."""
    code = np.zeros(positions.shape[1], dtype=np.uint64)
    for bit in range(_MORTON_BITS):
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


def neighbours(triangles: Integers, count: int) -> Neighbours:
    """Neighbours along the edges of triangles (3, m) of `count` nodes."""
    first, second = triangles.astype(np.int64), np.roll(triangles, -1, axis=0).astype(np.int64)
    low, high = np.minimum(first, second).ravel(), np.maximum(first, second).ravel()
    edges = np.unique(high * count + low)
    high, lower = edges // count, edges % count
    nodes, starts, counts = np.unique(high, return_index=True, return_counts=True)
    return Neighbours(lower, nodes, starts, counts)
