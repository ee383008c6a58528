"""Memory of gmsh's mesher HXT: whether its optimisation stays within what it has reserved.

HXT optimises a mesh only within the memory that it has reserved. `hxtEdgeRemoval_opti` of
gmsh 4.15 (contrib/hxt/tetMesh/src/hxt_edgeRemoval.c) keeps a pointer to the qualities of the
tetrahedra across `createNewDeleted`, which may move them: it then writes into memory that is free
or another's, and reads qualities that nobody has written. The mesh depends on what stood there, or
the process ends. It happens where the tetrahedra to be optimised and those that HXT reserves
together outgrow the array. So its size is followed through the messages of a meshing without
optimisation, by the rules of hxt_tetDelaunay.c and hxt_tetSync.c.
"""

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise

_RESERVED = re.compile(r"Initialization reserved (\d+) Tet")
_REFINED = re.compile(r"Refinement adds (\d+) points from (\d+) tetrahedra")
_BATCH = 8182  # tetrahedra by which the list of free ones is filled up (DELETED_BUFFER_SIZE)
_CAVITY = 250  # tetrahedra of one insertion at the most, which count as free ones
_RECOVERED = 0.02  # of the tetrahedra that recovering the boundary may add or take
_SWAPPED = 0.03  # of the tetrahedra that the optimisation may add
_Size = tuple[int, int]  # the least and the most that the array can have


def within_memory(messages: Sequence[str]) -> bool:
    """Tell whether HXT can optimise the mesh that gave these messages; else it may go astray.

    messages  of gmsh's logger at a verbosity of 6, of a volume meshed without optimisation; where
              it says nothing of HXT's memory, the answer is False
    """
    runs = list(_runs(messages))
    return bool(runs) and all(_fits(size, counts) for size, counts in runs)


def array_sizes(reserved: int, counts: Sequence[int]) -> list[_Size]:
    """Sizes that the array of tetrahedra may have before they are optimised.

    reserved  tetrahedra reserved at first
    counts    tetrahedra of the mesh before each refinement and after the last
    """
    sizes = {(reserved, reserved)}
    slack = int(_RECOVERED * counts[0])
    sizes = {found for size in sizes for found in _inserted(size, 5, counts[0], slack)}
    sizes = {(max(low, counts[0]), max(high, counts[0])) for low, high in sizes}
    for before, after in pairwise(counts):
        sizes = {found for size in sizes for found in _inserted(size, before, after, 0)}
    return sorted(sizes)


def _fits(reserved: int, counts: Sequence[int]) -> bool:
    batches = 1 + int(_SWAPPED * counts[-1] / _BATCH)
    needed = counts[-1] + batches * _BATCH
    return all(low >= needed for low, _ in array_sizes(reserved, counts))


def _inserted(size: _Size, before: int, after: int, slack: int) -> Iterator[_Size]:
    """Sizes of the array after points were inserted, from one size and two numbers of tetrahedra.

    Free tetrahedra are filled up to a batch whenever an insertion needs more than there are, those
    of its own cavity included.
    """
    low, high = before + _BATCH - _CAVITY, before + _BATCH
    for grown in _grown(size, low, high):
        yield from _more(grown, low, high, after, slack)


def _more(size: _Size, low: int, high: int, after: int, slack: int) -> Iterator[_Size]:
    if after - slack <= high:  # these may have been enough
        yield size
    if after + slack > low - _CAVITY:
        low, high = low + _BATCH - _CAVITY, high + _BATCH
        for grown in _grown(size, low, high):
            yield from _more(grown, low, high, after, slack)


def _grown(size: _Size, low: int, high: int) -> Iterator[_Size]:
    """Sizes of the array once a number of tetrahedra between two fits in: it grows by itself."""
    least, most = size
    if most >= low:
        yield max(least, low), most
    if least < high:
        yield least + max(low, least + 1), most + high


def _runs(messages: Sequence[str]) -> Iterator[tuple[int, list[int]]]:
    """Tetrahedra reserved at first, and their later numbers, of each connected volume."""
    reserved, counts = 0, list[int]()
    for message in messages:
        if found := _RESERVED.search(message):
            if reserved:
                yield reserved, counts
            reserved, counts = int(found[1]), []
        elif found := _REFINED.search(message):
            counts.append(int(found[2]))
    if reserved:
        yield reserved, counts
