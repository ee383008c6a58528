"""A part's loads as an input deck of CalculiX, for a second opinion from another program.

Plain text that CalculiX and Abaqus solve and PrePoMax opens: ten-node tetrahedra, the held
displacements, nodal forces, and what to write back. Lengths in mm, forces in N, stress in MPa,
mass in t. Node and element n of the mesh is n + 1 of the deck.
"""

import re
import unicodedata
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TextIO

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from fem.unit_solutions import Elastic
from geometry.mesh import FloatArray, IntArray, Mesh, Tie

_PER_LINE = 8  # of a node set; CalculiX takes 16 entries and 132 characters a line
_LINE = 120  # characters of a comment


def write_deck(
    target: Path | str | TextIO,
    mesh: Mesh,
    material: Elastic,
    hold: IntArray,
    nodal_loads: FloatArray,
    title: str,
    *,
    steps: Sequence[str] = (),
    printed: bool = False,
) -> None:
    """Write a part, its supports and its nodal forces as an input deck of CalculiX.

    target       a file to write or an open text stream
    hold         unknowns held at zero; unknown 3 n + i is displacement i of node n
    nodal_loads  (3 n_nodes,) N, or (3 n_nodes, m): one linear static step per column
    title        lines of the header: part, design, position
    steps        a name for each column
    printed      also have all displacements, and stress at the integration points, written to the
                 .dat file, which has seven digits where the .frd file has six

    Each tie becomes equations between unknowns (*EQUATION). Raises ValueError for half of a part.
    """
    mesh.check_whole("an input deck")
    columns = np.asarray(nodal_loads, dtype=np.float64).reshape(len(nodal_loads), -1)
    if len(columns) != 3 * len(mesh.nodes):
        raise ValueError(
            f"{len(mesh.nodes)} nodes need {3 * len(mesh.nodes)} nodal forces, got {len(columns)}"
        )
    if steps and len(steps) != columns.shape[1]:
        raise ValueError(f"{columns.shape[1]} load cases, but {len(steps)} names for them")
    if not np.isfinite(columns).all():
        raise ValueError("the nodal forces are not finite")
    held = np.unique(np.asarray(hold, dtype=np.int64))
    if len(held) and (held[0] < 0 or held[-1] >= len(columns)):
        raise ValueError(f"held unknowns must be from 0 to {len(columns) - 1}, got {held}")
    text = _lines(mesh, material, held, columns, title, steps, printed)
    if isinstance(target, str | Path):
        with Path(target).open("w", encoding="ascii", newline="\n") as stream:
            stream.writelines(text)
    else:
        target.writelines(text)


def set_names(mesh: Mesh) -> dict[str, str]:
    """The node set of each named surface: letters, digits and _, told apart without case."""
    names: dict[str, str] = {}
    for surface in mesh.surfaces:
        plain = _ascii(surface).replace("+", "_PLUS").replace("-", "_MINUS").upper()
        stem = "S_" + re.sub(r"[^A-Z0-9]+", "_", plain).strip("_")[:60]
        name, n = stem, 2
        while name in names.values():
            name, n = f"{stem}_{n}", n + 1
        names[surface] = name
    return names


def _lines(
    mesh: Mesh,
    material: Elastic,
    held: IntArray,
    columns: FloatArray,
    title: str,
    steps: Sequence[str],
    printed: bool,
) -> Iterator[str]:
    yield "*HEADING\n"
    yield (_ascii(title).strip().splitlines() or ["part"])[0][:_LINE] + "\n"
    yield from _comment(title)
    yield from _comment("Units: mm, N, MPa (N/mm2), t (tonne), s")
    yield from _nodes_and_elements(mesh)
    yield from _comment("Named surfaces of the part, as node sets")
    for surface, name in set_names(mesh).items():
        yield from _node_set(name, np.unique(mesh.surfaces[surface]))
    equations, dependent = _tie_equations(mesh, held)
    held = np.setdiff1d(held, dependent)
    if len(held):
        yield from _node_set("HELD", np.unique(held // 3))
    yield "*MATERIAL, NAME=MATERIAL\n*ELASTIC\n"
    yield f"{material.youngs_modulus:.12g}, {material.poisson_ratio:.12g}\n"
    if material.density > 0:
        yield f"*DENSITY\n{material.density:.12g}\n"
    yield "*SOLID SECTION, ELSET=PART, MATERIAL=MATERIAL\n"
    if equations:
        yield from _comment("Bodies that touch: equal displacement of node pairs")
        yield from equations
    if len(held):
        yield from _comment("Held just so that the part cannot move as a rigid body")
        yield "*BOUNDARY\n"
        yield from (f"{u // 3 + 1}, {u % 3 + 1}, {u % 3 + 1}\n" for u in held)
    for k in range(columns.shape[1]):
        yield from _comment(f"Load case {k + 1}: {steps[k]}" if steps else f"Load case {k + 1}")
        yield "*STEP\n*STATIC\n"
        yield from _forces(columns[:, k], fresh=k > 0)
        yield "*NODE FILE\nU, RF\n*EL FILE\nS\n"
        if len(held):
            yield "*NODE PRINT, NSET=HELD, TOTALS=YES\nRF\n"
        if printed:
            yield "*NODE PRINT, NSET=ALL\nU\n*EL PRINT, ELSET=PART\nS\n"
        yield "*END STEP\n"


def _nodes_and_elements(mesh: Mesh) -> Iterator[str]:
    count = len(mesh.nodes)
    yield "*NODE, NSET=ALL\n"
    numbered = np.column_stack([np.arange(1.0, count + 1), mesh.nodes])
    yield "%d, %.13g, %.13g, %.13g\n" * count % tuple(numbered.ravel().tolist())
    yield "*ELEMENT, TYPE=C3D10, ELSET=PART\n"  # its node order is the mesh's
    count = len(mesh.elements)
    whole = np.column_stack([np.arange(1, count + 1), mesh.elements + 1])
    yield (", ".join(["%d"] * 11) + "\n") * count % tuple(whole.ravel().tolist())


def _forces(column: FloatArray, *, fresh: bool) -> Iterator[str]:
    loaded = np.flatnonzero(column)
    if not len(loaded) and not fresh:
        return
    yield "*CLOAD, OP=NEW\n" if fresh else "*CLOAD\n"  # without NEW, the last step's forces stay
    for u in loaded:
        yield f"{u // 3 + 1}, {u % 3 + 1}, {column[u]:.12E}\n"


def _node_set(name: str, nodes: IntArray) -> Iterator[str]:
    yield f"*NSET, NSET={name}\n"
    numbers = (nodes + 1).tolist()
    for start in range(0, len(numbers), _PER_LINE):
        yield ", ".join(map(str, numbers[start : start + _PER_LINE])) + ",\n"


def _tie_equations(mesh: Mesh, held: IntArray) -> tuple[list[str], IntArray]:
    """Return equations that tie node groups, and the unknowns that they make depend on others.

    Of each group one unknown stays, a held one if there is any: an unknown that an equation makes
    dependent can be neither held nor made dependent twice.
    """
    lines: list[str] = []
    dependent: list[IntArray] = []
    for axis in sorted({tie.axis for tie in mesh.ties}):
        for kept, others in _groups([tie for tie in mesh.ties if tie.axis == axis], held):
            pair = "\n".join(
                f"2\n{n + 1}, {axis + 1}, 1., {kept + 1}, {axis + 1}, -1." for n in others
            )
            lines.append(f"*EQUATION\n{pair}\n")
            dependent.append(3 * others + axis)
    return lines, np.concatenate([np.zeros(0, dtype=np.int64), *dependent])


def _groups(ties: Sequence[Tie], held: IntArray) -> Iterator[tuple[int, IntArray]]:
    axis = ties[0].axis
    pairs = np.concatenate([tie.pairs for tie in ties])
    nodes, local = np.unique(pairs, return_inverse=True)
    local = local.reshape(-1, 2)
    ones = np.ones(len(local))
    graph = sp.coo_array((ones, (local[:, 0], local[:, 1])), shape=(len(nodes), len(nodes)))
    count, group = connected_components(graph, directed=False)
    free = ~np.isin(3 * nodes + axis, held)
    order = np.lexsort((nodes, free, group))
    starts = np.searchsorted(group[order], np.arange(count + 1))
    for first, last in pairwise(starts):
        members = nodes[order[first:last]]
        if last - first > 1:
            yield int(members[0]), members[1:]


def _comment(text: str) -> Iterator[str]:
    for line in _ascii(text).splitlines():
        yield f"** {line[:_LINE]}".rstrip() + "\n"


def _ascii(text: str) -> str:
    """Text without accents; what ASCII does not have becomes a question mark."""
    plain = unicodedata.normalize("NFKD", text)
    plain = "".join(letter for letter in plain if not unicodedata.combining(letter))
    return plain.encode("ascii", "replace").decode("ascii")
