"""Bodies of a stack that are tied to each other: which unknowns are one, and what the ties carry.

A tie makes the displacements of two nodes equal along one axis: u = T q, with the independent
unknowns q and a matrix T of zeros and ones. Stiffness and loads become T' K T and T' f. Ties along
y alone let the leaves of a spring slide on each other; along x and z something must hold them
together in at least one place (a centre bolt), or the stack is a mechanism, which is refused.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from geometry.mesh import FloatArray, IntArray, Mesh, MeshError


@dataclass(frozen=True, eq=False)
class Ties:
    """The independent unknowns of a tied mesh.

    number  (3 n_nodes,)  the independent unknown that each unknown is
    first   (n,)          the first unknown of each independent one
    """

    number: IntArray
    first: IntArray

    def expand(self, values: FloatArray) -> FloatArray:
        """Values (3 n_nodes, ...) of all unknowns from those of the independent ones (n, ...)."""
        return np.asarray(values[self.number])

    def collect(self, loads: FloatArray) -> FloatArray:
        """Loads (n, m) on the independent unknowns from those on all (3 n_nodes, m)."""
        return np.asarray(self._matrix.T @ loads)

    def collect_upper(self, upper: "scipy.sparse.csr_array") -> "scipy.sparse.csr_array":
        """Upper triangle of T' K T from the upper triangle of K."""
        entries = upper.tocoo()
        rows, columns = self.number[entries.row], self.number[entries.col]
        # an entry above the diagonal stands for two, which may fall on the diagonal together
        met = (rows == columns) & (entries.row != entries.col)
        values = np.where(met, 2 * entries.data, entries.data)
        low, high = np.minimum(rows, columns), np.maximum(rows, columns)
        n = len(self.first)
        return scipy.sparse.coo_array((values, (low, high)), shape=(n, n)).tocsr()

    @cached_property
    def _matrix(self) -> "scipy.sparse.csr_array":
        count = len(self.number)
        return scipy.sparse.csr_array(
            (np.ones(count), self.number, np.arange(count + 1)), shape=(count, len(self.first))
        )


def ties_of(mesh: Mesh) -> Ties | None:
    """Return the independent unknowns of a mesh, or None if nothing is tied.

    Raises MeshError if tied nodes are apart or the ties let the bodies move against each other.
    """
    if not any(len(tie.pairs) for tie in mesh.ties):
        return None
    _check_places(mesh)
    _check_rigidity(mesh)
    count = 3 * len(mesh.nodes)
    joined = np.concatenate([3 * tie.pairs + tie.axis for tie in mesh.ties])
    graph = scipy.sparse.coo_array((np.ones(len(joined)), tuple(joined.T)), shape=(count, count))
    _, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    _, first, number = np.unique(label, return_index=True, return_inverse=True)
    order = np.argsort(first)  # in the order of the nodes, which ordering methods like
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return Ties(place[number].astype(np.int64), first[order].astype(np.int64))


def bodies_of(mesh: Mesh) -> IntArray:
    """Number (n_nodes,) of the body that each node belongs to, counted from 0."""
    n = len(mesh.nodes)
    first = np.repeat(mesh.elements[:, 0], 9)
    others = mesh.elements[:, 1:].ravel()
    graph = scipy.sparse.coo_array((np.ones(len(first)), (first, others)), shape=(n, n))
    return np.asarray(
        scipy.sparse.csgraph.connected_components(graph, directed=False)[1], dtype=np.int64
    )


def _check_places(mesh: Mesh) -> None:
    size = float(np.ptp(mesh.nodes, axis=0).max())
    for tie in mesh.ties:
        apart = np.linalg.norm(mesh.nodes[tie.pairs[:, 0]] - mesh.nodes[tie.pairs[:, 1]], axis=1)
        if apart.max(initial=0.0) > 1e-7 * size:
            raise MeshError(
                f"nodes tied along {'xyz'[tie.axis]} must be at the same place, they are up to "
                f"{apart.max():.3g} mm apart"
            )


def _check_rigidity(mesh: Mesh) -> None:
    """MeshError unless the only rigid motions that the ties allow are the six of the whole."""
    body = bodies_of(mesh)
    count = int(body.max()) + 1
    middle = mesh.nodes.mean(axis=0)
    size = np.abs(mesh.nodes - middle).max()
    squares = np.zeros((6 * count, 6 * count))
    for tie in mesh.ties:
        rows = np.zeros((len(tie.pairs), count, 6))
        for side, sign in ((0, 1.0), (1, -1.0)):
            nodes = tie.pairs[:, side]
            arm = (mesh.nodes[nodes] - middle) / size
            turns = np.cross(np.eye(3), arm[:, None])[..., tie.axis]  # of unit turns about x, y, z
            shifts = np.broadcast_to(np.eye(3)[tie.axis], turns.shape)
            motion = np.concatenate([shifts, turns], axis=1)
            rows[np.arange(len(nodes)), body[nodes]] += sign * motion
        flat = rows.reshape(len(rows), -1)
        squares += flat.T @ flat / max(len(flat), 1)
    values = np.linalg.eigvalsh(squares)
    loose = int(np.count_nonzero(values < 1e-9 * max(values[-1], 1e-300))) - 6
    if loose > 0:
        raise MeshError(
            f"the {count} bodies of the stack can still move against each other in {loose} "
            "independent ways without deforming: they need ties along x and z in one place at "
            "least, such as a bolt through all of them"
        )
