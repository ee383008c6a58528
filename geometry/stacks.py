"""Bodies that touch without being one: nodes of their own on the shared faces, and ties."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.mesh import FloatArray, IntArray, MeshError, Tie

_NORMAL = 1  # a stack's faces are normal to y


@dataclass(frozen=True, eq=False)
class Split:
    """A conformal mesh of several bodies, taken apart.

    nodes     (n_nodes, 3) mm: the given ones, then a copy for each further body on a shared face
    copies    per body: the index of its own node for every given one, (n_given,)
    pairs     (n, 2) node indices at one place: of a body, then of the next one there
    """

    nodes: FloatArray
    copies: tuple[IntArray, ...]
    pairs: IntArray


def split_bodies(nodes: FloatArray, bodies: Sequence[IntArray]) -> Split:
    """Give every body of a conformal mesh nodes of its own.

    bodies  per body: elements (n, 10), indices into `nodes`

    Raises MeshError if a body touches none of the others.
    """
    owner = np.full(len(nodes), -1)
    latest = np.arange(len(nodes))
    grown, copies, pairs = [nodes], [], []
    touching = []
    count = len(nodes)
    for body, elements in enumerate(bodies):
        used = np.unique(elements)
        shared = used[owner[used] >= 0]
        own = np.arange(len(nodes))
        own[shared] = count + np.arange(len(shared))
        count += len(shared)
        grown.append(nodes[shared])
        pairs.append(np.column_stack([latest[shared], own[shared]]))
        touching += [(int(other), body) for other in np.unique(owner[shared])]
        latest[shared] = own[shared]
        owner[used] = body
        copies.append(own)
    _check_that_all_touch(len(bodies), touching)
    return Split(np.concatenate(grown), tuple(copies), np.concatenate(pairs))


def _check_that_all_touch(count: int, touching: Sequence[tuple[int, int]]) -> None:
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    first, second = np.array(touching, dtype=int).reshape(-1, 2).T
    links = coo_matrix((np.ones(len(first)), (first, second)), shape=(count, count))
    heaps, _ = connected_components(links, directed=False)
    if heaps > 1:
        raise MeshError(f"the {count} bodies of the stack fall into {heaps} that do not touch")


def ties_of(nodes: FloatArray, pairs: IntArray, bolted_at: float | None) -> tuple[Tie, ...]:
    """Return the ties of a stack: all pairs along y; those of the bolt at x, mm, along x too.

    Along z one pair of each two bodies is tied, the nearest to their middle: bent bodies widen
    where they are pressed and narrow where they are pulled, so two faces that meet must be free to
    slide across; a line tied along z carried a shear without a finite stress.
    Raises MeshError if there is a bolt and no pair in its plane.
    """
    if not len(pairs):
        return ()
    ties = (Tie(_NORMAL, pairs),)
    if bolted_at is None:
        return ties
    bolt = pairs[np.abs(nodes[pairs[:, 0], 0] - bolted_at) <= 1e-6]
    if not len(bolt):
        raise MeshError(f"no nodes of the stack lie at the bolt's x = {bolted_at:g} mm")
    heights = np.round(nodes[bolt[:, 0], 1], 6)
    middle = np.abs(nodes[bolt[:, 0], 2])
    order = np.lexsort((middle, heights))
    _, first = np.unique(heights[order], return_index=True)
    return (Tie(0, bolt), *ties, Tie(2, bolt[order[first]]))
