"""Leaves that press and rub on each other: CalculiX's contact with friction against fem/contact.

`python -m bench.leaf_contact` prints the table of "Compared" in
docs/theory/leaf_packs.md: two and three leaves on two supports with a force in their middle, loaded
and then relieved to half of it, with and without a force that squeezes them over the supports. It
needs CalculiX, `ccx` in the path. Its half of the pack is of eight-node quadrilaterals in plane
stress, 1 mm wide, small displacements.
"""

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.frd_file import read_frd
from fem.contact.leaves import LeafContact
from fem.leaf_stack import LeafStack
from geometry.mesh import FloatArray

STEEL = (210e3, 0.3)
HALF, THICK = 200.0, 10.0  # mm: half the leaves' length, one leaf
MIDDLE, SUPPORT = (0.0, 10.0), (180.0, 190.0)  # mm, where they are pressed
FORCE = 20.0  # N on one half, 1 mm wide
PATH = (1.0, 0.5)  # of the force: loaded, relieved
SIZE, LAYERS = 5.0, 2  # elements, mm along and number through a leaf
# By number of leaves: stiffness of contact and of stick, MPa/mm, and the increments of a step. Of
# three, CalculiX needs softer ones: they give way by 1e-4 mm where leaves slip by hundredths.
SETTINGS = {2: (1e6, 1e5, "0.5, 1"), 3: (1e5, 1e4, "0.1, 1, 1e-6, 0.2")}


@dataclass(frozen=True)
class Pack:
    """A pack on its supports.

    squeeze  N, over each support, on both faces of the pack
    """

    leaves: int
    friction: float
    squeeze: float = 0.0


PACKS = tuple(
    Pack(leaves, friction, squeeze)
    for leaves in (2, 3)
    for friction, squeeze in ((0.3, 100.0), (0.3, 0.0), (0.1, 100.0))
)


@dataclass(frozen=True)
class Found:
    """A pack loaded, and relieved.

    deflection  (2,) mm, of the supports against the middle
    stress      (2,) MPa, of the lowest face in the middle
    """

    deflection: FloatArray
    stress: FloatArray


def beams(pack: Pack, spacing: float = SIZE) -> Found:
    """The pack by fem/contact."""
    places = np.linspace(-HALF, HALF, 2 * round(HALF / spacing) + 1)
    middle = len(places) // 2
    stack = LeafStack(places, pack.leaves, 1.0, THICK, *STEEL, bolted=middle)
    left = (-SUPPORT[1], -SUPPORT[0])
    pressed = sum(stack.squeezed(span, pack.squeeze) for span in (SUPPORT, left))
    bent = stack.spread((-MIDDLE[1], MIDDLE[1]), -2 * FORCE, 0.0)
    bent = stack.on_faces(bent) + stack.on_faces(
        stack.spread(SUPPORT, FORCE, 0.0) + stack.spread(left, FORCE, 0.0)
    )
    contact = LeafContact(stack)
    path = np.array([0.0, *PATH])
    loads = stack.balanced(pressed + path[:, None] * bent)
    history = contact.history(loads, pack.friction, once=True)
    lowest = history.displacements[1:, stack.dof(0, 1)]
    over = (stack.at(sum(SUPPORT) / 2) + stack.at(sum(left) / 2)) / 2 - stack.at(0.0)
    return Found(lowest @ over, history.stress[1:, 0, 0, 2 * middle])


def calculix(pack: Pack) -> Found:
    """The pack by CalculiX."""
    nodes, deck = _deck(pack)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "leaves.inp")
        path.write_text(deck, encoding="ascii")
        done = subprocess.run(["ccx", "leaves"], cwd=folder, capture_output=True, text=True)
        if "Job finished" not in done.stdout:
            raise RuntimeError(f"ccx did not finish {pack}:\n{done.stdout[-2000:]}")
        ends = [len(_steps(pack)) - 1.0, float(len(_steps(pack)))]
        steps = [s for s in read_frd(path.with_suffix(".frd")) if s.time in ends]
    if len(steps) != len(PATH):
        raise RuntimeError(f"ccx stopped {pack} before its last step")
    end, centre = (_at(nodes, x, THICK / 2) for x in (sum(SUPPORT) / 2, 0.0))
    low = _at(nodes, 0.0, 0.0)
    moved = np.array([s.fields["DISP"][[end, centre], 1] for s in steps])
    return Found(moved[:, 0] - moved[:, 1], np.array([s.fields["STRESS"][low, 0] for s in steps]))


def _steps(pack: Pack) -> tuple[float, ...]:
    """Shares of the force, one after the other; squeezed ones are squeezed first."""
    return (0.0, *PATH) if pack.squeeze else PATH


def _at(nodes: FloatArray, x: float, y: float) -> int:
    """Number of the first node at a place of the lowest leaf."""
    return int(np.hypot(nodes[:, 0] - x, nodes[:, 1] - y).argmin())


def _deck(pack: Pack) -> tuple[FloatArray, str]:
    """Nodes (n, 2) and the deck of half the pack."""
    stiff, stick, increments = SETTINGS[pack.leaves]
    across, up = round(HALF / SIZE), LAYERS
    number = -np.ones((2 * across + 1, 2 * up + 1), dtype=int)
    kept = np.add.outer(np.arange(2 * across + 1) % 2, np.arange(2 * up + 1) % 2) < 2
    number[kept] = np.arange(kept.sum())
    i, j = (index.ravel() for index in np.meshgrid(2 * np.arange(across), 2 * np.arange(up)))
    around = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1))
    elements = np.stack([number[i + a, j + b] for a, b in around], axis=1)
    at = np.argwhere(kept) * (SIZE / 2, THICK / up / 2)
    order = np.argsort(number[kept])
    leaf = at[order]
    nodes = np.concatenate([leaf + np.array([0.0, k * THICK]) for k in range(pack.leaves)])
    n, m = len(leaf), len(elements)
    lines = ["*NODE, NSET=ALL", *(f"{k}, {x:.9g}, {y:.9g}, 0" for k, (x, y) in enumerate(nodes, 1))]
    lines.append("*ELEMENT, TYPE=CPS8, ELSET=LEAVES")
    for k in range(pack.leaves):
        lines += [
            f"{k * m + e}, " + ", ".join(map(str, row + k * n + 1))
            for e, row in enumerate(elements, 1)
        ]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", f"{STEEL[0]}, {STEEL[1]}"]
    lines += ["*SOLID SECTION, ELSET=LEAVES, MATERIAL=STEEL", "1."]
    lines += ["*NSET, NSET=CUT", *map(str, np.flatnonzero(nodes[:, 0] < 1e-9) + 1)]
    below, above = np.flatnonzero(j == 0), np.flatnonzero(j == 2 * (up - 1))
    for k in range(pack.leaves):
        lines += [f"*SURFACE, NAME=BELOW{k}", *(f"{k * m + e + 1}, S1" for e in below)]
        lines += [f"*SURFACE, NAME=ABOVE{k}", *(f"{k * m + e + 1}, S3" for e in above)]
    lines += ["*SURFACE INTERACTION, NAME=RUBS"]
    lines += [f"*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{stiff}"]
    if pack.friction:
        lines.append(f"*FRICTION\n{pack.friction}, {stick}")
    for k in range(pack.leaves - 1):
        lines.append("*CONTACT PAIR, INTERACTION=RUBS, TYPE=SURFACE TO SURFACE")
        lines.append(f"BELOW{k + 1}, ABOVE{k}")
    for k in range(pack.leaves):  # a leaf that nothing holds along y, until contact does
        lines.append(
            f"*ELEMENT, TYPE=SPRING1, ELSET=SOFT{k}\n{pack.leaves * m + k + 1}, {k * n + 1}"
        )
        lines.append(f"*SPRING, ELSET=SOFT{k}\n2\n{1e-6 * STEEL[0]}")
    lines.append(f"*BOUNDARY\nCUT, 1, 1\n{_at(nodes, 0.0, 0.0) + 1}, 2, 2")
    for share in _steps(pack):
        forces = np.zeros(len(nodes))
        top = pack.leaves * THICK
        for y, span, size in (
            (0.0, SUPPORT, share * FORCE + pack.squeeze),
            (top, SUPPORT, -pack.squeeze),
            (top, MIDDLE, -share * FORCE),
        ):
            forces += _pressed(nodes, y, span, size)
        lines += [f"*STEP, INC=500\n*STATIC\n{increments}", "*CLOAD, OP=NEW"]
        lines += [f"{k + 1}, 2, {force:.12g}" for k, force in enumerate(forces) if force]
        lines += ["*NODE FILE, OUTPUT=2D\nU\n*EL FILE, OUTPUT=2D\nS", "*END STEP"]
    return nodes, "\n".join([*lines, ""])


def _pressed(nodes: FloatArray, y: float, span: tuple[float, float], force: float) -> FloatArray:
    """Forces (n,) along y at the nodes of an edge under an even pressure over whole elements."""
    forces = np.zeros(len(nodes))
    if not force:
        return forces
    count = round((span[1] - span[0]) / SIZE)
    for k in range(count):
        start = span[0] + k * SIZE
        for x, share in ((start, 1 / 6), (start + SIZE / 2, 4 / 6), (start + SIZE, 1 / 6)):
            here = np.flatnonzero(np.hypot(nodes[:, 0] - x, nodes[:, 1] - y) < 1e-6)
            forces[here[0]] += force / count * share
    return forces


def rows() -> Iterator[str]:
    """Yield the lines of the table; CalculiX's and ours in each cell, and the difference."""
    yield (
        "| Leaves | Friction | Squeezed, N | Deflection, loaded, mm | relieved to half | "
        "Stress, loaded, MPa | relieved to half |"
    )
    yield "| --- | --- | --- | --- | --- | --- | --- |"
    for pack in PACKS:
        one, other = calculix(pack), beams(pack)
        cells = [f"{pack.leaves}", f"{pack.friction:g}", f"{pack.squeeze:g}"]
        for theirs, ours in ((one.deflection, other.deflection), (one.stress, other.stress)):
            cells += [
                f"{a:.4g}, {b:.4g}: {100 * (b / a - 1):+.1f} %"
                for a, b in zip(theirs, ours, strict=True)
            ]
        yield "| " + " | ".join(cells) + " |"


def main() -> None:
    """Measure and print."""
    if shutil.which("ccx") is None:
        sys.exit("bench.leaf_contact compares with CalculiX, and there is no `ccx` in the path")
    for row in rows():
        print(row, flush=True)


if __name__ == "__main__":
    main()
