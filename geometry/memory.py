"""Memory that a part's solve will take, by its number of unknowns, and memory that is free.

Measured with CHOLMOD on quadratic tetrahedra: assembly takes a fixed number of bytes per unknown,
the factor of nested dissection grows like n^(4/3) in three dimensions (George 1973; Gilbert and
Tarjan 1987), and with the cross-section that cuts the part in two: a cube fills up most, a plate
or a rod less. PARDISO's factor is as large; for another solver the caller states `fill`.

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
from pathlib import Path

import numpy as np

from geometry.mesh import FloatArray, TooManyElementsError

# Bytes per unknown, fitted to solves of cubes, plates and rods (docs/extremes.md), which it tells
# to 30 %: assembly; factor, for a cube of one unknown; each load's vectors.
_ASSEMBLY, _FILL, _COLUMN = 2000.0, 216.0, 64.0
_FLATTENED = 0.65  # exponent of the compactness
_GIBIBYTE = 2.0**30
_CGROUPS = Path("/sys/fs/cgroup")
_OWN_GROUP = Path("/proc/self/cgroup")
_MEMINFO = Path("/proc/meminfo")


class TooLargeError(TooManyElementsError):
    """A mesh whose solve would need more memory than there is."""


def solve_bytes(
    unknowns: int, columns: int, compactness: float = 1.0, *, fill: float = 1.0
) -> float:
    """Memory to assemble, factorise and solve a solid's equations, bytes.

    columns      right-hand sides
    compactness  cube root of the volume over the greatest extent: 1 for a cube, less for others
    fill         memory of the solver's factor over the memory of CHOLMOD's factor
    """
    fill *= float(_FILL * min(compactness, 1.0) ** _FLATTENED * np.cbrt(unknowns))
    return unknowns * (_ASSEMBLY + fill + _COLUMN * columns)


def compactness_of(nodes: FloatArray, volume: float) -> float:
    """Cube root of a part's volume, mm3, over its greatest extent; nodes (n, 3) or corners, mm."""
    return float(np.cbrt(volume) / np.ptp(nodes, axis=0).max())


def available_bytes() -> float:
    """Memory that a process can still take: the machine's, or less if its control groups have less.

    Linux: /proc/meminfo(5), cgroups(7); a group's file cache that is not in use counts as free, as
    the machine's does. Elsewhere what psutil tells.
    """
    if _MEMINFO.exists():
        found = [1024.0 * _entry(_MEMINFO.read_text(encoding="utf-8"), "MemAvailable:")]
    else:
        import psutil

        found = [float(psutil.virtual_memory().available)]
    for group, names in _groups():
        most, used, cache = names
        limit = (group / most).read_text(encoding="utf-8").strip()
        if limit != "max":
            taken = float((group / used).read_text(encoding="utf-8"))
            unused = _entry((group / "memory.stat").read_text(encoding="utf-8"), cache)
            found.append(float(limit) - taken + unused)
    return max(min(found), 0.0)


_SECOND = ("memory.max", "memory.current", "inactive_file")
_FIRST = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")


def _groups() -> list[tuple[Path, tuple[str, str, str]]]:
    """Folders of the control groups that bound this process, and the names of their files."""
    own = _OWN_GROUP.read_text(encoding="utf-8").splitlines() if _OWN_GROUP.exists() else []
    paths = [Path(line.removeprefix("0::/")) for line in own if line.startswith("0::/")]
    folders = [_CGROUPS / part for path in paths or [Path()] for part in (path, *path.parents)]
    groups = [(folder, _SECOND) for folder in folders]
    return [
        (folder, names)
        for folder, names in [*groups, (_CGROUPS / "memory", _FIRST)]
        if all((folder / name).exists() for name in (*names[:2], "memory.stat"))
    ]


def _entry(text: str, name: str) -> float:
    """The number behind a name at the start of a line; 0 where there is none."""
    lines = (line.split() for line in text.splitlines())
    return next((float(words[1]) for words in lines if words[0] == name), 0.0)


def check_memory(
    unknowns: int, columns: int, compactness: float = 1.0, *, fill: float = 1.0
) -> None:
    """Raise TooLargeError if a solve would need more memory than there is; see solve_bytes."""
    needed = solve_bytes(unknowns, columns, compactness, fill=fill)
    there = available_bytes()
    if needed > there:
        raise TooLargeError(
            f"solving about {unknowns:.2g} unknowns with {columns} loads would need "
            f"{needed / _GIBIBYTE:.3g} GiB of memory and {there / _GIBIBYTE:.3g} GiB are free; "
            "lower mesh.fineness or mesh.most_unknowns, or take a machine with more"
        )


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
