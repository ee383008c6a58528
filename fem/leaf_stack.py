"""Leaves on top of each other, each a Timoshenko beam: stiffness, loads, and stress of their faces.

All have the same places along x. What acts between them is contact's business
(fem/contact/leaves.py).

In a solid the leaves are tied: where the ties pull, the real leaves would part.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fem.assembly import bodies_of
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray, IntArray

SHEAR = 5 / 6  # share of a rectangle's section that its mean shear strain acts on


@dataclass(frozen=True, eq=False)
class LeafStack:
    """Equal leaves on top of each other.

    places     (k,) mm, rising, where neighbours can touch
    count      number of leaves, at least 2
    width, thickness                  mm, of one leaf
    youngs_modulus, poisson_ratio     MPa, 1
    bolted     index of the place where nothing slips, whatever presses; None for none

    Raises ValueError for a stack that cannot be.
    """

    places: FloatArray
    count: int
    width: float
    thickness: float
    youngs_modulus: float
    poisson_ratio: float
    bolted: int | None = None

    def __post_init__(self) -> None:
        if self.count < 2 or len(self.places) < 2 or not (np.diff(self.places) > 0).all():
            raise ValueError(
                f"a stack needs two leaves and two rising places, got {self.count} leaves on "
                f"{len(self.places)} places"
            )

    @property
    def n_dofs(self) -> int:
        """Displacements along x and y and turns of all leaves at all places."""
        return 3 * self.count * len(self.places)

    def dof(self, leaf: int, which: int) -> IntArray:
        """Numbers (k,) of a leaf's displacements along x (0), along y (1) or turns (2)."""
        return 3 * (leaf * len(self.places) + np.arange(len(self.places))) + which

    def at(self, x: float) -> FloatArray:
        """Shares (k,) of the two places next to x, which keep force and moment."""
        at, way = self._between(np.array([x]))
        k = len(self.places)
        return np.asarray(np.bincount(at, 1 - way, k) + np.bincount(at + 1, way, k))

    def spread(self, span: tuple[float, float], force: float, couple: float) -> FloatArray:
        """Forces along y (k,) of a clamp, N: even over its span, those of its couple grow along it.

        couple  N mm, about the middle of the span
        """
        weights = self.spans(span)
        share = weights / weights.sum()
        arms = self.places - share @ self.places
        couple = couple - force * (float(share @ self.places) - (span[0] + span[1]) / 2)
        return np.asarray(force * share + couple * share * arms / (share @ arms**2))

    def on_faces(self, forces: FloatArray, like: FloatArray | None = None) -> FloatArray:
        """Loads (..., n_dofs) of forces along y (..., k) that push on the outer faces.

        Upwards on the lowest leaf, downwards on the highest; with `like`, on the faces that the
        forces (..., k) of another load push on.
        """
        up = (forces if like is None else like) >= 0
        loads = np.zeros((*forces.shape[:-1], self.n_dofs))
        loads[..., self.dof(0, 1)] = np.where(up, forces, 0.0)
        loads[..., self.dof(self.count - 1, 1)] = np.where(up, 0.0, forces)
        return loads

    def squeezed(self, span: tuple[float, float], force: float) -> FloatArray:
        """Loads (n_dofs,) of a force, N, that presses the leaves together evenly over a span."""
        forces = self.spread(span, force, 0.0)
        return self.on_faces(forces) + self.on_faces(-forces)

    def spans(self, span: tuple[float, float]) -> FloatArray:
        """Length (k,) mm of a span that belongs to each place, by hats."""
        edges = np.unique(np.clip(np.r_[self.places, span], *span))
        lengths, k = np.diff(edges), len(self.places)
        at, way = self._between((edges[1:] + edges[:-1]) / 2)
        before, after = lengths * (1 - way), lengths * way
        return np.asarray(np.bincount(at, before, k) + np.bincount(at + 1, after, k))

    def _between(self, x: FloatArray) -> tuple[IntArray, FloatArray]:
        """Numbers (n,) of the places before x (n,), and how far to the next ones."""
        at = np.clip(np.searchsorted(self.places, x) - 1, 0, len(self.places) - 2)
        return at, (x - self.places[at]) / (self.places[at + 1] - self.places[at])

    @cached_property
    def stiffness(self) -> FloatArray:
        """Stiffness (n_dofs, n_dofs) N/mm, N, N mm of the leaves, each on its own."""
        n = 3 * len(self.places)
        leaf = np.zeros((n, n))
        for first, element in zip(range(0, n, 3), self._elements, strict=False):
            leaf[first : first + 6, first : first + 6] += element
        return np.asarray(np.kron(np.eye(self.count), leaf))

    @cached_property
    def _elements(self) -> FloatArray:
        """Stiffness (k - 1, 6, 6) of a leaf's beams between places, exact under end loads."""
        area, h = self.width * self.thickness, np.diff(self.places)
        bending = self.youngs_modulus * area * self.thickness**2 / 12
        shear = SHEAR * area * self.youngs_modulus / (2 * (1 + self.poisson_ratio))
        a, one = self.youngs_modulus * area / h, np.ones_like(h)
        soft = 12 * bending / (shear * h**2)
        near, far = (4 + soft) * h**2, (2 - soft) * h**2
        bent = np.array(
            [
                [12 * one, 6 * h, -12 * one, 6 * h],
                [6 * h, near, -6 * h, far],
                [-12 * one, -6 * h, 12 * one, -6 * h],
                [6 * h, far, -6 * h, near],
            ]
        )
        found = np.zeros((6, 6, len(h)))
        found[np.ix_([0, 3], [0, 3])] = a * np.array([[1, -1], [-1, 1]])[:, :, None]
        found[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = bending / (h**3 * (1 + soft)) * bent
        return np.moveaxis(found, 2, 0)

    @cached_property
    def relative(self) -> FloatArray:
        """Gaps, then slips, (2 m, n_dofs) of displacements; m = (count - 1) k."""
        k, m = len(self.places), (self.count - 1) * len(self.places)
        rows = np.zeros((2 * m, self.n_dofs))
        for i in range(self.count - 1):
            gap, slip = i * k + np.arange(k), m + i * k + np.arange(k)
            rows[gap, self.dof(i, 1)] = -1
            rows[gap, self.dof(i + 1, 1)] = 1
            rows[slip, self.dof(i, 0)] = -1
            rows[slip, self.dof(i + 1, 0)] = 1
            rows[slip, self.dof(i, 2)] = self.thickness / 2
            rows[slip, self.dof(i + 1, 2)] = self.thickness / 2
        return rows

    @cached_property
    def stress_places(self) -> FloatArray:
        """Places (2 (k - 1),) mm of stresses: both ends of every stretch between two places."""
        return np.repeat(self.places, 2)[1:-1]

    def stress(self, displacements: FloatArray) -> FloatArray:
        """Stress along x (n, count, 2, 2 (k - 1)) MPa: lower, upper face of each leaf.

        N/A - M y/I at both ends of each stretch: shear between faces acts at the places and makes
        steps there, whose higher side counts.
        """
        area, n = self.width * self.thickness, len(displacements)
        modulus = area * self.thickness / 6
        ends = displacements.reshape(n, self.count, len(self.places), 3)
        ends = np.concatenate([ends[:, :, :-1], ends[:, :, 1:]], axis=3)
        forces = np.einsum("eij,nlej->nlei", self._elements, ends)
        normal = np.stack([-forces[..., 0], forces[..., 3]], axis=-1).reshape(n, self.count, -1)
        moment = np.stack([-forces[..., 2], forces[..., 5]], axis=-1).reshape(n, self.count, -1)
        bent = moment / modulus
        return np.stack([normal / area + bent, normal / area - bent], axis=2)

    def balanced(self, loads: FloatArray) -> FloatArray:
        """Loads (..., n_dofs) with the inertia of a rigid acceleration that balances them."""
        weights = self.spans((self.places[0], self.places[-1]))
        rigid, inertia = np.zeros((3, self.n_dofs)), np.zeros((3, self.n_dofs))
        for leaf in range(self.count):
            y = (leaf - (self.count - 1) / 2) * self.thickness
            rigid[0, self.dof(leaf, 0)] = 1
            rigid[1, self.dof(leaf, 1)] = 1
            rigid[2, self.dof(leaf, 0)] = -y
            rigid[2, self.dof(leaf, 1)] = self.places
            rigid[2, self.dof(leaf, 2)] = 1
            inertia[0, self.dof(leaf, 0)] = weights
            inertia[1, self.dof(leaf, 1)] = weights
            inertia[2, self.dof(leaf, 0)] = -weights * y
            inertia[2, self.dof(leaf, 1)] = weights * self.places
        left = loads @ rigid.T
        return np.asarray(loads - left @ np.linalg.solve(inertia @ rigid.T, inertia))


def tie_tension(
    solutions: UnitSolutions,
    coefficients: FloatArray,
    clamped: Sequence[tuple[float, float]] = (),
    *,
    window: float,
) -> tuple[float, float]:
    """Largest tension and largest compression along y between the bodies of a stack, MPa.

    coefficients  (n_basis,) of one position or (n_basis, n) of several
    clamped       mm, lowest and highest x of stretches where tension is not looked for: a clamp
                  presses the bodies together there, which is in no load
    window        mm along x to either side over which a tie's force counts, less with distance

    The forces are those that hold tied nodes together, K u - f of the bodies by themselves: they
    balance each body's loads to round-off on any mesh, where stresses recovered on faces that
    carry next to nothing are all scatter of the bending beside them. They are summed over the width
    of every face and over hats of half-width `window`, and divided by the hats' areas. Each is 0
    where there is none of it. Raises ValueError if nothing is tied along y.
    """
    mesh = solutions.mesh
    pairs = [tie.pairs for tie in mesh.ties if tie.axis == 1 and len(tie.pairs)]
    if not pairs:
        raise ValueError("nothing is tied along y: the part has no faces that lie on each other")
    nodes = np.concatenate(pairs)
    body = bodies_of(mesh)
    count = np.bincount(body)
    middle = np.bincount(body, weights=mesh.nodes[:, 1]) / count
    upwards = np.sign(middle[body[nodes[:, 1]]] - middle[body[nodes[:, 0]]])
    pull = upwards[:, None] * _holding(solutions, 3 * nodes[:, 0] + 1)  # (n_pairs, n_basis)
    x, y, z = mesh.nodes[nodes[:, 0]].T
    step = window / 2
    places = np.linspace(x.min(), x.max(), 1 + max(1, round(np.ptp(x) / step)))
    weights = np.maximum(0.0, 1 - np.abs(x - places[:, None]) / window)
    sides = np.minimum(window, np.abs(places - np.array([[x.min()], [x.max()]])))
    lengths = (sides - sides**2 / (2 * window)).sum(axis=0)  # of the hats, less at the ends
    free = np.ones(len(places), dtype=bool)
    for low, high in clamped:
        free &= (places + window <= low) | (places - window >= high)
    tension = compression = 0.0
    faces = np.round(y / np.ptp(mesh.nodes[:, 1]), 6)
    for face in np.unique(faces):
        on = faces == face
        line = (weights[:, on] @ pull[on]) / (lengths[:, None] * np.ptp(z[on]))
        stress = line @ coefficients
        tension = max(tension, float(stress[free].max(initial=0.0)))
        compression = max(compression, float(-stress.min(initial=0.0)))
    return tension, compression


def _holding(solutions: UnitSolutions, unknowns: IntArray) -> FloatArray:
    """Forces (len(unknowns), n_basis) N that the ties of the unknowns give them per unit load."""
    upper = solutions.stiffness
    rows = upper[unknowns] + upper.T.tocsr()[unknowns]
    diagonal = upper.diagonal()[unknowns]
    internal = rows @ solutions.displacement - diagonal[:, None] * solutions.displacement[unknowns]
    return np.asarray(internal - solutions.loads[unknowns])
