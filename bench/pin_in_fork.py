"""A pin in a fork: line load and hoop stress along it, CalculiX's contact beside fem/contact.

`python -m bench.pin_in_fork` prints the table of "Along the pin" in docs/theory/contact.md; it
needs CalculiX, `ccx` in the path, and about ten minutes. A quarter of a pin of 20 mm without
clearance, of the eye between (width b, half of it here) and of one cheek (b/2): linear bricks with
incompatible modes, fine towards the edges of the lugs. The eye is pulled at its end, the cheek is
clamped at its end, so that it gives way as a cantilever.
"""

import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from bench.frd_file import read_dat, read_frd
from fem.contact.beds import Lug, RoundBar
from fem.contact.cylinder_waves import Lining
from fem.contact.line_load import LineLoad, line_load
from geometry.mesh import FloatArray, IntArray

YOUNG, POISSON = 210e3, 0.3
RADIUS, WIDTH, REACH, GAP = 10.0, 50.0, 60.0, 1.0  # mm: WIDTH across a lug, REACH to its far end
CORE = 0.08  # of the radius, a hole along the pin's axis
FORCE = 40e3  # N on the whole eye
_RINGS = 3  # of elements through a bush
PENALTY = 2e6  # MPa/mm: 200 MPa sink in by 1e-4 mm, a hundredth of what the bore gives way


def _graded(start: float, stop: float, finest: float, coarsest: float) -> FloatArray:
    """Places from start to stop whose steps grow from `finest` at both ends."""
    half, size, growth = [0.0], finest, 1.35
    while half[-1] < abs(stop - start) / 2:
        half.append(half[-1] + size)
        size = min(size * growth, coarsest)
    shape = np.array(half) / half[-1] / 2
    return start + (stop - start) * np.r_[shape, 1 - shape[-2::-1]]


@dataclass(frozen=True, eq=False)
class Block:
    """Bricks of one body: nodes (layers, rings, angles, 3), mm; angles from 0 to pi."""

    nodes: FloatArray

    @property
    def numbers(self) -> IntArray:
        """Number, from 0, of each node (layers, rings, angles)."""
        return np.arange(self.nodes[..., 0].size).reshape(self.nodes.shape[:3])

    @property
    def bricks(self) -> IntArray:
        """Nodes (n, 8) in CalculiX's order."""
        n = self.numbers
        low = [n[:-1, :-1, :-1], n[:-1, 1:, :-1], n[:-1, 1:, 1:], n[:-1, :-1, 1:]]
        high = [n[1:, :-1, :-1], n[1:, 1:, :-1], n[1:, 1:, 1:], n[1:, :-1, 1:]]
        return np.stack([part.ravel() for part in low + high], axis=1)

    def ring(self, which: int) -> IntArray:
        """Numbers, from 0, of the bricks of the innermost ring, or of another."""
        layers, rings, angles = self.nodes.shape[:3]
        every = np.arange((layers - 1) * (rings - 1) * (angles - 1))
        return every.reshape(layers - 1, rings - 1, angles - 1)[:, which].ravel()


@dataclass(frozen=True)
class Fork:
    """A fork whose eye is b mm wide, of elements as fine as `fineness`.

    bush  bonded into all bores; its hoop stress stands in place of the bore's
    """

    eye: float
    fineness: float = 1.0
    bush: Lining | None = None

    @cached_property
    def angles(self) -> FloatArray:
        """Angles of the nodes, rad."""
        return np.linspace(0, np.pi, round(36 * self.fineness) + 1)

    @property
    def cheek(self) -> tuple[float, float]:
        """Faces of the cheek, mm."""
        low = self.eye / 2 + GAP
        return low, low + self.eye / 2

    def heights(self, low: float, high: float) -> FloatArray:
        """Layers between two faces, mm."""
        return _graded(low, high, 0.35 / self.fineness, 2.0 / self.fineness)

    def lug(self, heights: FloatArray, sign: float) -> Block:
        """A lug that reaches towards -x (sign 1) or x (-1), pressed at 0 or 180 degrees."""
        angles = self.angles
        x, y = np.cos(angles), np.sin(angles)
        back = np.where(sign * x < 0, REACH, WIDTH / 2)
        with np.errstate(divide="ignore"):
            outer = np.minimum(back / np.abs(x), WIDTH / 2 / np.abs(y))
        tops = np.stack([outer * x, outer * y], axis=-1)
        for corner in (WIDTH / 2 * sign, -REACH * sign):  # the nearest node goes there
            near = np.abs(angles - np.arctan2(WIDTH / 2, corner)).argmin()
            tops[near] = corner, WIDTH / 2
        share = np.cumsum(np.r_[0, 1.25 ** np.arange(round(9 * self.fineness))])
        share /= share[-1]
        bore = RADIUS * (self.bush.ratio if self.bush else 1.0)
        inner = np.stack([x, y], axis=-1)
        plane = bore * inner + share[:, None, None] * (tops - bore * inner)
        if self.bush:
            rings = np.linspace(RADIUS, bore, _RINGS + 1)[:-1, None, None]
            plane = np.concatenate([rings * inner, plane])
        return _block(plane, heights)

    @cached_property
    def parts(self) -> dict[str, Block]:
        """The eye, the cheek and the pin."""
        low, high = self.cheek
        eye = self.heights(-self.eye / 2, self.eye / 2)
        eye = eye[eye > -1e-9]
        eye = eye if eye[0] < 1e-9 else np.r_[0.0, eye]
        cheek = self.heights(low, high)
        end = high + np.array([0.5, 1.5, 3.0, 5.0])
        along = np.r_[eye, (eye[-1] + low) / 2, cheek, end]
        x, y = np.cos(self.angles), np.sin(self.angles)
        rings = CORE + (1 - CORE) * (1 - np.linspace(1, 0, round(9 * self.fineness) + 1) ** 1.5)
        plane = RADIUS * rings[:, None, None] * np.stack([x, y], axis=-1)
        return {"EYE": self.lug(eye, 1), "CHEEK": self.lug(cheek, -1), "PIN": _block(plane, along)}

    def deck(self) -> str:
        """The CalculiX deck."""
        lines, first, element = ["*NODE, NSET=ALL"], {}, {}
        count = bricks = 0
        for name, part in self.parts.items():
            first[name], element[name] = count, bricks
            rows = part.nodes.reshape(-1, 3)
            lines += [
                f"{count + i}, {a:.10g}, {b:.10g}, {c:.10g}" for i, (a, b, c) in enumerate(rows, 1)
            ]
            count, bricks = count + len(rows), bricks + len(part.bricks)
        for name, part in self.parts.items():
            lines.append(f"*ELEMENT, TYPE=C3D8I, ELSET={name}")
            lines += [
                ", ".join(map(str, (element[name] + i, *(row + first[name] + 1))))
                for i, row in enumerate(part.bricks, 1)
            ]
        lines += ["*MATERIAL, NAME=STEEL", f"*ELASTIC\n{YOUNG}, {POISSON}"]
        lines += [f"*SOLID SECTION, ELSET={name}, MATERIAL=STEEL" for name in self.parts]
        if self.bush:
            lines.append("*ELSET, ELSET=BUSH")
            for name in ("EYE", "CHEEK"):
                for ring in range(_RINGS):
                    lines += [f"{element[name] + e + 1}" for e in self.parts[name].ring(ring)]
            elastic = f"{self.bush.youngs_modulus}, {self.bush.poisson_ratio}"
            lines += ["*MATERIAL, NAME=BUSH", f"*ELASTIC\n{elastic}"]
            lines.append("*SOLID SECTION, ELSET=BUSH, MATERIAL=BUSH")
        for name, ring, side in (("EYE", 0, 6), ("CHEEK", 0, 6)):
            lines.append(f"*SURFACE, NAME={name}_HOLE")
            lines += [f"{element[name] + e + 1}, S{side}" for e in self.parts[name].ring(ring)]
        lines.append("*ELSET, ELSET=RINGS")
        for name in ("EYE", "CHEEK"):
            lines += [f"{element[name] + e + 1}" for e in self.parts[name].ring(0)]
        pin = self.parts["PIN"]
        outside = pin.ring(-1)
        height = pin.nodes.reshape(-1, 3)[pin.bricks[outside], 2].mean(axis=1)
        middle = self.eye / 2 + GAP / 2
        for name, chosen in (("EYE", height < middle), ("CHEEK", height > middle)):
            lines.append(f"*SURFACE, NAME={name}_ROUND")
            lines += [f"{element['PIN'] + e + 1}, S4" for e in outside[chosen]]
        fixed = []
        for name, part in self.parts.items():
            nodes = part.nodes.reshape(-1, 3)
            fixed += [(first[name] + i + 1, 2) for i in np.flatnonzero(np.abs(nodes[:, 1]) < 1e-9)]
            if name != "CHEEK":
                low = np.flatnonzero(np.abs(nodes[:, 2]) < 1e-9)
                fixed += [(first[name] + i + 1, 3) for i in low]
            else:
                held = np.flatnonzero(np.abs(nodes[:, 0] - REACH) < 1e-9)
                fixed += [(first[name] + i + 1, axis) for i in held for axis in (1, 2, 3)]
        lines += ["*BOUNDARY", *(f"{i}, {axis}, {axis}" for i, axis in sorted(set(fixed)))]
        springs = [first["PIN"] + 1, first["EYE"] + 1]
        lines.append("*ELEMENT, TYPE=SPRING1, ELSET=SOFT")
        lines += [f"{bricks + k}, {node}" for k, node in enumerate(springs, 1)]
        lines += [f"*SPRING, ELSET=SOFT\n1\n{1e-5 * YOUNG}", "*SURFACE INTERACTION, NAME=SMOOTH"]
        lines.append(f"*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{PENALTY}")
        for name in ("EYE", "CHEEK"):
            lines.append("*CONTACT PAIR, INTERACTION=SMOOTH, TYPE=SURFACE TO SURFACE")
            lines.append(f"{name}_HOLE, {name}_ROUND")
        lines += ["*STEP, INC=200\n*STATIC\n1, 1", "*CLOAD"]
        eye = self.parts["EYE"]
        face = np.abs(eye.nodes[0, -1, :, 0] + REACH) < 1e-9
        across, along = eye.nodes[0, -1, face, 1], eye.nodes[:, 0, 0, 2]
        weight = np.outer(_lengths(along), np.abs(_lengths(across)))
        weight *= -FORCE / 4 / weight.sum()
        at = first["EYE"] + eye.numbers[:, -1, face] + 1
        lines += [f"{i}, 1, {f:.10g}" for i, f in zip(at.ravel(), weight.ravel(), strict=True)]
        lines += ["*NODE FILE\nU", "*EL FILE\nS", "*EL PRINT, ELSET=RINGS\nS", "*END STEP", ""]
        return "\n".join(lines)


def _block(plane: FloatArray, heights: FloatArray) -> Block:
    flat = np.broadcast_to(plane, (len(heights), *plane.shape))
    up = np.broadcast_to(heights[:, None, None, None], (*flat.shape[:3], 1))
    return Block(np.concatenate([flat, up], axis=-1))


def _lengths(places: FloatArray) -> FloatArray:
    """Length that belongs to each place: half of the step on either side."""
    steps = np.diff(places)
    return np.asarray((np.r_[steps, 0] + np.r_[0, steps]) / 2)


@dataclass(frozen=True, eq=False)
class Pressed:
    """Line load and hoop stress by CalculiX in one lug.

    heights    (n,) mm, the layers' nodes
    intensity  (n,) N/mm, along the force
    hoop       (n,) MPa, stress along the edge of the bore, square to the force
    """

    heights: FloatArray
    intensity: FloatArray
    hoop: FloatArray

    @property
    def carried(self) -> float:
        """The whole force, N."""
        return float(self.intensity @ _lengths(self.heights))

    @property
    def shift(self) -> float:
        """Place of the resultant, mm from the middle of the layers."""
        weights = self.intensity * _lengths(self.heights)
        middle = (self.heights[0] + self.heights[-1]) / 2
        return float(weights @ self.heights / weights.sum() - middle)


def solved(fork: Fork, folder: Path) -> dict[str, Pressed]:
    """CalculiX's contact, by lug; raises RuntimeError where it does not finish or balance."""
    path = folder / "fork.inp"
    path.write_text(fork.deck(), encoding="ascii")
    done = subprocess.run(["ccx", "fork"], cwd=folder, capture_output=True, text=True)
    if "Job finished" not in done.stdout:
        raise RuntimeError(f"ccx did not finish:\n{done.stdout[-2000:]}")
    return read(fork, path)


def read(fork: Fork, path: Path) -> dict[str, Pressed]:
    """Read the results of a deck; raises RuntimeError where a lug does not carry its force."""
    stress = read_frd(path.with_suffix(".frd"))[-1].fields["STRESS"]
    (printed,) = read_dat(path.with_suffix(".dat"), "stresses")
    first = element = 0
    found = {}
    for name, part in fork.parts.items():
        layers, rings, angles = part.nodes.shape[:3]
        count = layers * rings * angles
        at_nodes = stress[first : first + count].reshape(layers, rings, angles, 6)
        ring = part.ring(0)
        if name != "PIN":
            own = printed[np.isin(printed[:, 0], element + ring + 1)]
            own = own[np.lexsort((own[:, 1], own[:, 0]))][:, 2:].reshape(len(ring), 8, 6)
            forces = _along_x(part, ring, own).reshape(layers, rings, angles)[:, 0].sum(axis=1)
            forces *= 2 if name == "CHEEK" else -2  # both halves
            side = at_nodes[:, 0, angles // 2, 0]
            pressed = Pressed(
                part.nodes[:, 0, 0, 2], -forces / _lengths(part.nodes[:, 0, 0, 2]), side
            )
            if abs(pressed.carried / (FORCE / 2) - 1) > 1e-3:
                raise RuntimeError(f"{name} carries {pressed.carried:.6g} N of {FORCE / 2:g}")
            found[name] = pressed
        first, element = first + count, element + len(part.bricks)
    return found


def _along_x(part: Block, chosen: IntArray, stress: FloatArray) -> FloatArray:
    """Forces (n_nodes,) along x, N, that stress (n, 8, 6) in some bricks asks of their nodes.

    The integral of grad(N) . stress, exact in what CalculiX balances; its order in the .dat file is
    xx, yy, zz, xy, xz, yz. What other bricks ask is not in it: right at the bore alone.
    """
    nodes, bricks = part.nodes.reshape(-1, 3), part.bricks[chosen]
    corners = np.array([(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1),
                        (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)])  # fmt: skip
    total = np.zeros(len(nodes))
    for point, at in enumerate(
        np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
    ):
        factor = 1 + corners * at / np.sqrt(3)
        slopes = np.stack(
            [corners[:, k] * np.delete(factor, k, axis=1).prod(axis=1) / 8 for k in range(3)],
            axis=1,
        )
        jacobian = np.einsum("ak,eai->eki", slopes, nodes[bricks])
        gradient = np.einsum("eik,ak->eai", np.linalg.inv(jacobian), slopes)
        size = np.linalg.det(jacobian)
        force = np.einsum("eai,ei->ea", gradient, stress[:, point][:, [0, 3, 4]]) * size[:, None]
        np.add.at(total, bricks, force)
    return total


def predicted(fork: Fork) -> LineLoad:
    """The line load of fem/contact; the cheek tilts as a cantilever REACH mm long."""
    low, high = fork.cheek
    width = high - low
    tilt = REACH / (YOUNG * WIDTH * width**3 / 12)
    bar = RoundBar((-high - 5, high + 5), (2 * RADIUS,), YOUNG, POISSON)
    elastic = YOUNG, POISSON
    return line_load(
        bar,
        [
            Lug(-high, -low, (-FORCE / 2, 0.0), *elastic, tilt, lining=fork.bush),
            Lug(-fork.eye / 2, fork.eye / 2, (FORCE, 0.0), *elastic, lining=fork.bush),
            Lug(low, high, (-FORCE / 2, 0.0), *elastic, tilt, lining=fork.bush),
        ],
    )


def table(fork: Fork, found: dict[str, Pressed]) -> str:
    """Return the Markdown rows of one fork: line load and hoop over their means."""
    ours, lines = predicted(fork), []
    bush = f", bush {fork.bush.youngs_modulus / 1e3:g} GPa" if fork.bush else ""
    for name, number in (("EYE", 1), ("CHEEK", 2)):
        pressed, hats = found[name], ours.hats[number]
        own = ours.intensity(number) / ours.lugs[number].size * ours.lugs[number].width
        z, mean = pressed.heights, pressed.carried / np.ptp(pressed.heights)
        hoop = pressed.hoop @ _lengths(z) / np.ptp(z)
        for place in z:
            one, other = (
                np.interp(place, z, pressed.intensity) / mean,
                np.interp(place, hats.nodes, own),
            )
            side = np.interp(place, z, pressed.hoop) / hoop
            lines.append(
                f"| {name.lower()}, b/d = {fork.eye / 2 / RADIUS:g}{bush} | {place:.2f} | "
                f"{one:.3f} | {other:.3f} | {side:.3f} |"
            )
        lug, forces = ours.lugs[number], ours.forces[number]
        beside = forces @ hats.places / forces.sum() - (lug.low + lug.high) / 2
        shift = f"{pressed.shift:.3f} and {beside:.3f} mm" if number == 2 else "none"
        lines.append(f"{name.lower()}: resultant off the middle, {shift}; mean hoop {hoop:.4g} MPa")
    return "\n".join(lines)


def main() -> None:
    """Measure and print."""
    if shutil.which("ccx") is None:
        sys.exit("bench.pin_in_fork compares with CalculiX, and there is no `ccx` in the path")
    print("| Lug | z, mm | q/mean, CalculiX | q/mean, fem/contact | hoop/mean, CalculiX |")
    print("| --- | --- | --- | --- | --- |")
    bushes = [Fork(20.0, 1.0, Lining(1.2, *elastic)) for elastic in ((90e3, 0.34), (10e3, 0.35))]
    for fork in (Fork(20.0, 1.0), Fork(40.0, 0.75), *bushes):
        with tempfile.TemporaryDirectory() as folder:
            print(table(fork, solved(fork, Path(folder))), flush=True)


if __name__ == "__main__":
    main()
