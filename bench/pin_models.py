"""Eyes and cheeks with a pin in their hole: shapes, meshes, CalculiX decks.

For bench/pin_contact.py. Plane halves of six-node triangles, the pin's nodes opposite the hole's.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from geometry.mesh import FloatArray
from tests.validation.plane.domains import geometric, mapped
from tests.validation.plane.mesh import PlaneMesh
from tests.validation.plane.model import Kind, PlaneModel

STEEL = (210e3, 0.3)
Reach = Callable[[FloatArray], FloatArray]
PENALTY = 2e7  # MPa/mm: 200 MPa sink in by 1e-5 mm
LAYER = 1e-2  # mm, so thin that CalculiX's plane stress has no shear out of the plane


@dataclass(frozen=True)
class Eye:
    """One end of a part around its hole, in a plane; the pin pushes along +x.

    reach      angle -> distance of the outer edge from the middle of the hole, mm
    corners    rad, where the outer edge has corners
    held       mm, x of the end that is held
    force      N, on the whole eye of `thickness` mm
    elastic    Young's modulus, MPa, and Poisson's ratio; the pin is of steel
    """

    name: str
    hole: float
    thickness: float
    force: float
    reach: Reach
    corners: tuple[float, ...]
    held: float
    kind: Kind = "stress"
    elastic: tuple[float, float] = STEEL

    @property
    def compliance(self) -> float:
        """1/E* = (1 - nu^2)/E of both bodies in plane strain, 1/E in plane stress, 1/MPa."""
        strain = self.kind == "strain"
        return sum((1 - strain * nu**2) / young for young, nu in (self.elastic, STEEL))

    def parameter(self, clearance: float) -> float:
        """E* dR t / F of a clearance on diameter, mm."""
        return clearance / 2 * self.thickness / self.force / self.compliance

    def clearance(self, parameter: float) -> float:
        """The clearance on diameter, mm, of a value of E* dR t / F."""
        return 2 * parameter * self.force * self.compliance / self.thickness


def box(back: float, side: float, front: float) -> tuple[Reach, tuple[float, ...]]:
    """Outer edge x = -back, y = side, x = front, and its corners."""

    def reach(angle: FloatArray) -> FloatArray:
        x, y = np.cos(angle), np.sin(angle)
        with np.errstate(divide="ignore"):
            return np.minimum(np.where(x > 0, front, back) / np.abs(x), side / np.abs(y))

    return reach, (np.arctan2(side, front), np.arctan2(side, -back))


def rounded(side: float, back: float) -> tuple[Reach, tuple[float, ...]]:
    """A rounded end of radius `side` on a shank as wide that ends at x = -back."""
    shank, corners = box(back, side, side)

    def reach(angle: FloatArray) -> FloatArray:
        return np.where(angle < np.pi / 2, side, shank(angle))

    return reach, (np.pi / 2, corners[1])


def ring_eye(
    radius: float, side: float, fillet: float, back: float
) -> tuple[Reach, tuple[float, ...]]:
    """A round eye on a narrower shank, with a fillet between them."""
    up = side + fillet
    centre = np.array([-np.sqrt((radius + fillet) ** 2 - up**2), up])
    starts = np.arctan2(centre[1], centre[0]), np.arctan2(side, centre[0])
    shank, corners = box(back, side, radius)

    def reach(angle: FloatArray) -> FloatArray:
        along = centre[0] * np.cos(angle) + centre[1] * np.sin(angle)
        depth = np.maximum(along**2 - centre @ centre + fillet**2, 0.0)
        curve = np.where(angle < starts[1], along - np.sqrt(depth), shank(angle))
        return np.where(angle < starts[0], radius, curve)

    return reach, (*starts, corners[1])


EYES = (
    Eye("toggle bar, cheek", 44, 6.3, 30.8e3, *box(40, 40, 120), held=120),
    Eye("slider-crank, rod", 10, 10, 350, *rounded(10, 40), held=-40, elastic=(70e3, 0.33)),
    Eye("quick return, rod", 8, 6, 300, *rounded(8, 32), held=-32),
    Eye("hammer, rod", 16, 21, 600, *ring_eye(14.25, 10, 6, 50), held=-50, kind="strain"),
)


@dataclass(frozen=True, eq=False)
class Grid:
    """The meshes of an eye and of its pin, fine where they touch.

    half_arc  rad, expected
    fineness  elements per length, over those of the table
    """

    eye: Eye
    half_arc: float
    clearance: float
    fineness: float = 1.0

    @cached_property
    def angles(self) -> FloatArray:
        """Limits of the elements along the edge of the hole, rad."""
        breaks = np.unique(np.r_[0, np.pi, np.pi / 2, np.pi / 3, 5 * np.pi / 12, self.eye.corners])
        fine = self.finest
        pieces = [np.zeros(1)]
        for start, end in pairwise(breaks):
            at = np.linspace(start, end, 2001)
            away = np.maximum(at - 1.3 * self.half_arc, 0.0)
            size = np.minimum(fine + 0.15 * away, np.radians(3) / self.fineness)
            counted = np.r_[0, np.cumsum(np.diff(at) * (1 / size[1:] + 1 / size[:-1]) / 2)]
            steps = np.linspace(0, counted[-1], max(1, round(counted[-1])) + 1)
            pieces.append(np.interp(steps, counted, at)[1:])
        return np.concatenate(pieces)

    @property
    def finest(self) -> float:
        """Size of an element under the pin, rad."""
        return float(min(self.half_arc / 16, np.radians(2.5)) / self.fineness)

    @property
    def inner(self) -> float:
        """Radius of the hole, mm."""
        return self.eye.hole / 2

    def _depths(self, depth: float) -> FloatArray:
        """Limits from 0 to 1 of cells that grow from the size along the hole to its tenfold."""
        first, count, growth = self.inner * self.finest / depth, 3, 1 + 0.25 / self.fineness
        while geometric(count, growth)[1] > first:
            count += 1
        return geometric(count, growth)

    @cached_property
    def plate(self) -> PlaneMesh:
        """The eye: edges "hole", "outer", "ahead" (0 degrees) and "behind"."""
        wall = self.eye.reach(self.angles).min() - self.inner
        middle = self.inner + 0.6 * wall
        near = self._depths(0.6 * wall)
        far = np.linspace(0, 1, 1 + max(3, round(5 * self.fineness)))
        columns = np.r_[near / 2, 0.5 + far[1:] / 2]

        def mapping(s: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
            angle, outer = np.pi * t, self.eye.reach(np.pi * t)
            inside = self.inner + (middle - self.inner) * 2 * s
            radius = np.where(s <= 0.5, inside, middle + (outer - middle) * (2 * s - 1))
            return radius * np.cos(angle), radius * np.sin(angle)

        mesh = mapped(columns, self.angles / np.pi, mapping)
        return _renamed(mesh, left="hole", right="outer", bottom="ahead", top="behind")

    @cached_property
    def pin(self) -> PlaneMesh:
        """The pin, touching at 0 degrees, with a small hole on its axis."""
        radius = self.inner - self.clearance / 2
        core = 0.08 * radius
        columns = 1 - self._depths(radius - core)[::-1]

        def mapping(s: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
            r = core + (radius - core) * s
            return r * np.cos(np.pi * t) + self.clearance / 2, r * np.sin(np.pi * t)

        mesh = mapped(columns, self.angles / np.pi, mapping)
        return _renamed(mesh, left="core", right="surface", bottom="ahead", top="behind")


def _renamed(mesh: PlaneMesh, **names: str) -> PlaneMesh:
    return replace(mesh, edges={names[old]: edge for old, edge in mesh.edges.items()})


def deck(grid: Grid) -> str:
    """The CalculiX deck of an eye and its pin, LAYER mm thick."""
    eye, plate, pin = grid.eye, grid.plate, grid.pin
    shift = len(plate.nodes)
    kind = "CPE6" if eye.kind == "strain" else "CPS6"
    lines = ["*NODE, NSET=ALL"]
    lines += [
        f"{i}, {x:.12g}, {y:.12g}, 0" for i, (x, y) in enumerate([*plate.nodes, *pin.nodes], 1)
    ]
    for name, mesh, first, elastic in (
        ("PLATE", plate, 0, eye.elastic),
        ("PIN", pin, shift, STEEL),
    ):
        start = len(plate.elements) if first else 0
        lines.append(f"*ELEMENT, TYPE={kind}, ELSET={name}")
        lines += [
            ", ".join(map(str, (start + i, *(row + first + 1))))
            for i, row in enumerate(mesh.elements, 1)
        ]
        lines += [f"*MATERIAL, NAME={name}", "*ELASTIC", f"{elastic[0]}, {elastic[1]}"]
        lines += [f"*SOLID SECTION, ELSET={name}, MATERIAL={name}", f"{LAYER}"]
        cut = np.unique(np.r_[mesh.edge_nodes("ahead"), mesh.edge_nodes("behind")])
        lines += [f"*NSET, NSET={name}_CUT", *map(str, cut + first + 1)]
    held = np.flatnonzero(np.abs(plate.nodes[:, 0] - eye.held) < 1e-9)
    lines += ["*NSET, NSET=HELD", *map(str, held + 1)]
    for name, mesh, edge, start in (
        ("HOLE", plate, "hole", 0),
        ("ROUND", pin, "surface", len(plate.elements)),
    ):
        lines.append(f"*SURFACE, NAME={name}")
        lines += [f"{start + e + 1}, S{side}" for e, side in _sides(mesh, edge)]
    spring = len(plate.elements) + len(pin.elements) + 1
    end = shift + 1 + pin.nearest_node(*pin.nodes[pin.edge_nodes("core")].max(axis=0))
    along = np.array([1.0, 0.0])  # spread evenly over the pin's section
    load = PlaneModel(pin, *STEEL).loads(body=lambda p: np.broadcast_to(along, p.shape))
    load *= eye.force / 2 / eye.thickness * LAYER / load.sum()
    lines += [
        f"*ELEMENT, TYPE=SPRING1, ELSET=SOFT\n{spring}, {end}",
        f"*SPRING, ELSET=SOFT\n1\n{1e-5 * STEEL[0] * LAYER}",
        "*SURFACE INTERACTION, NAME=SMOOTH",
        f"*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{PENALTY}",
        "*CONTACT PAIR, INTERACTION=SMOOTH, TYPE=SURFACE TO SURFACE\nHOLE, ROUND",
        "*BOUNDARY\nPLATE_CUT, 2, 2\nPIN_CUT, 2, 2\nHELD, 1, 1",
        "*STEP, INC=200\n*STATIC\n1, 1",
        "*CLOAD",
    ]
    lines += [f"{shift + 1 + i}, 1, {f:.12g}" for i, f in enumerate(load[::2]) if f]
    return "\n".join([*lines, "*NODE FILE, OUTPUT=2D\nU", "*END STEP", ""])


def _sides(mesh: PlaneMesh, edge: str) -> list[tuple[int, int]]:
    """Element and side number 1 to 3 of the pieces of an edge."""
    owner = {
        int(node): (e, side)
        for e, row in enumerate(mesh.elements)
        for side, node in enumerate(row[3:], 1)
    }
    return [owner[int(node)] for node in mesh.edges[edge][:, 2]]
