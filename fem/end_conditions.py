"""Supports under which a solid's modes are sought, on the factor of its stress analysis.

Some unknowns may be fixed for good; any other condition is a row of C in C u = 0. With the rigid
modes R of a part that nothing fixes, K u + C' m = f, C u = 0 needs only solves with the held
stiffness and a dense system as small as C (docs/theory/buckling.md).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from fem.assembly import Pattern
from fem.elements import Elements
from fem.solvers import Factor, node_dissection
from fem.unit_loads import InterfaceLoads
from fem.unit_solutions import Elastic, UnitSolutions, rigid_modes
from geometry.mesh import FloatArray, IntArray, Interface


@dataclass(frozen=True, eq=False)
class SupportedSolid:
    """A solid, its stiffness and its supports.

    stiffness  upper triangle of the whole matrix, N/mm
    fixed      (k,) unknowns that never move
    rows       (c, 3 n_nodes) conditions rows @ u = 0, independent of each other
    held       (h,) unknowns left out of the factor: the fixed ones, or six if none is fixed
    factor     of the stiffness without the held unknowns
    """

    elements: Elements
    pattern: Pattern
    material: Elastic
    stiffness: "scipy.sparse.csr_array"
    fixed: IntArray
    rows: FloatArray
    held: IntArray
    factor: Factor

    def __post_init__(self) -> None:
        size = self.stiffness.shape[0]
        if self.rows.ndim != 2 or self.rows.shape[1] != size:
            raise ValueError(f"conditions must have shape (c, {size}), got {self.rows.shape}")
        if len(self.fixed) and not np.array_equal(np.sort(self.fixed), np.sort(self.held)):
            raise ValueError("a solid with fixed unknowns must be held at these and no others")
        known = np.linalg.matrix_rank(self.rows @ self.rows.T) if len(self.rows) else 0
        if known < len(self.rows):
            raise ValueError(f"of {len(self.rows)} conditions only {known} are independent")
        if not len(self.fixed) and len(self.rows) < 6:
            raise ValueError(f"{len(self.rows)} conditions cannot stop six rigid motions")

    @cached_property
    def free(self) -> IntArray:
        """Unknowns that may move."""
        return np.setdiff1d(np.arange(self.stiffness.shape[0]), self.fixed)

    @cached_property
    def place(self) -> IntArray | None:
        """Where each unknown stands in the order of elimination, None without CHOLMOD."""
        by_node = node_dissection(self.elements.mesh.elements)
        return None if by_node is None else np.repeat(by_node, 3)

    def inverse(self, forces: FloatArray) -> FloatArray:
        """Displacement (3 n_nodes, m) under forces (3 n_nodes, m), where the supports hold."""
        response = self._held_solve(forces)
        if not len(self.rows):
            return response
        modes, back, bordered = self._border
        right = np.concatenate([self._sparse_rows @ response, modes.T @ forces])
        response += back @ np.linalg.solve(bordered, right)
        return response

    @property
    def answers(self) -> FloatArray:
        """Displacement (3 n_nodes, c) of the held part under each condition's force."""
        return -self._border[1][:, : len(self.rows)]

    @cached_property
    def _border(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Rigid modes R (n, 6 or 0), [-K_h^-1 C', R] (n, c + 6 or c), and the dense system."""
        modes = rigid_modes(self.elements.mesh.nodes)
        if len(self.fixed):
            modes = modes[:, :0]
        else:
            modes[:, 3:] /= np.abs(modes[:, 3:]).max()
        responses = self._held_solve(self.rows.T.copy())
        count, size = len(self.rows), len(self.rows) + modes.shape[1]
        bordered = np.zeros((size, size))
        bordered[:count, :count] = self.rows @ responses
        bordered[:count, count:] = -self.rows @ modes
        bordered[count:, :count] = modes.T @ self.rows.T
        return modes, np.hstack([-responses, modes]), bordered

    @cached_property
    def _sparse_rows(self) -> "scipy.sparse.csr_array":
        """The conditions, of which those of a link touch its interfaces only."""
        return scipy.sparse.csr_array(self.rows)

    def _held_solve(self, forces: FloatArray) -> FloatArray:
        response = np.zeros(forces.shape)
        response[self._solved] = self.factor.apply(forces[self._solved])
        return response

    @cached_property
    def _solved(self) -> IntArray:
        return np.setdiff1d(np.arange(self.stiffness.shape[0]), self.held)


def link_solid(
    solutions: UnitSolutions, *, tilt_held: bool, twist_held_at: str | None = None, what: str
) -> SupportedSolid:
    """Return a part held at two of its interfaces as pins hold a link.

    tilt_held      True if both forks hold their ends against any turn but that about the pin
    twist_held_at  interface that holds the part against turning about its own axis where forks are
                   soft; None for the first one
    what           is asked, for the message

    At each interface the mean displacement is held, along the part at one only; about the pins both
    ends may turn. Raises ValueError for a stack of tied bodies and MeshError for half of a part.
    """
    check_whole(solutions, what)
    rows = end_conditions(solutions, tilt_held=tilt_held, twist_held_at=twist_held_at)
    return supported(solutions, rows)


def end_conditions(
    solutions: UnitSolutions, *, tilt_held: bool, twist_held_at: str | None = None
) -> FloatArray:
    """Rows (n_rows, 3 n_nodes) of mean displacements and rotations held to zero."""
    nodes, (first, second) = solutions.mesh.nodes, holding(solutions.interfaces, twist_held_at)
    c, s = unit_vector(second.centre[:2] - first.centre[:2])
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    rows = []
    for interface in (first, second):
        weights = surface_weights(solutions.elements, interface.name)
        x, y, z = axes @ (nodes - interface.centre).T

        def mean(axis: int, factor: FloatArray, weights: FloatArray = weights) -> FloatArray:
            return np.asarray(np.outer(weights * factor, axes[axis]).ravel())

        one = np.ones(len(weights))
        rows += [mean(axis, one) for axis in ((0, 1, 2) if interface is first else (1, 2))]
        if tilt_held or interface is first:  # no turning about the part's own axis
            rows.append(mean(2, y) - mean(1, z))
        if tilt_held:
            rows.append(mean(0, z) - mean(2, x))
    return np.array([row / np.linalg.norm(row) for row in rows])


def holding(interfaces: Sequence[InterfaceLoads], name: str | None) -> tuple[Interface, Interface]:
    """Return the two interfaces by which a part is held, the one called `name` first.

    The other is the one nearest to it, whatever their order, so that what lies beyond both is free
    for the longest way; of several as near, the one with the least x, then y. Contacts that slide
    hold nothing where two others do.
    """
    known = [loads.interface for loads in interfaces]
    fixed = [interface for interface in known if interface.kind != "slide"]
    known = fixed if len(fixed) > 1 else known
    first = next((one for one in known if one.name == name), known[0])
    others = [one for one in known if one is not first]
    return first, min(others, key=lambda one: nearness(one.centre[:2], first.centre[:2]))


def nearness(point: FloatArray, start: FloatArray) -> tuple[float, ...]:
    """Rank of a point (2,) by its distance from a start, then by x and y; to a nanometre."""
    return tuple(round(float(value), 6) for value in (np.hypot(*(point - start)), *point))


def unit_vector(apart: FloatArray) -> FloatArray:
    """Direction (2,) of a vector, along x of one without length."""
    length = np.hypot(*apart)
    return apart / length if length else np.array([1.0, 0.0])


def surface_weights(elements: Elements, name: str) -> FloatArray:
    """Shares (n_nodes,) of the nodes in the mean over a named surface; their sum is 1."""
    surface = elements.surface(name)
    weights = np.zeros(len(elements.mesh.nodes))
    np.add.at(weights, surface.nodes, np.einsum("aq,fq->fa", surface.shape, surface.weights))
    return np.asarray(weights / weights.sum())


def supported(solutions: UnitSolutions, rows: FloatArray) -> SupportedSolid:
    """Return a part with conditions rows @ u = 0 (c, 3 n_nodes) and nothing fixed for good."""
    return SupportedSolid(
        elements=solutions.elements,
        pattern=solutions.pattern,
        material=solutions.material,
        stiffness=solutions.stiffness,
        fixed=np.zeros(0, dtype=np.int64),
        rows=rows,
        held=solutions.held,
        factor=solutions.factor,
    )


def check_whole(solutions: UnitSolutions, what: str) -> None:
    """Raise ValueError for a stack of tied bodies, MeshError for half of a part."""
    solutions.mesh.check_whole(f"{what}, which may be sideways,")
    if solutions.ties is not None:
        raise ValueError(
            f"{what} is computed for parts of one body; this one is a stack of tied bodies that "
            "slide on each other"
        )
