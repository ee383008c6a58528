"""Frames of straight Timoshenko members in space: their stiffness, and how they buckle.

A member's stiffness is the inverse of its flexibility, the integral of H' C H along it, where H
carries the forces at its end to the section and C is the section's compliance (Przemieniecki,
Theory of Matrix Structural Analysis, 1968, sections 5.6 and 8.3). So prismatic members are exact
at any slenderness, without locking; tapers are as exact as Gauss quadrature of 1/EI. Unknown
6 n + i of node n: displacements along x, y, z, then turns about x, y, z.

**Buckling.** The work of the axial force on the slope of the deflection, 1/2 integral N (v'^2 +
w'^2 + r^2 t'^2), is taken with the member's own exact deflection: curvature and shear strain follow
from its end forces, so the slope is an unloaded Timoshenko member's, v' = turn + shear strain. A
prismatic pinned column then tends to Engesser's load Pe / (1 + Pe / k G A), and to Euler's without
shear. t' is the twist and r^2 = (I_y + I_z) / A (Wagner; Timoshenko and Gere, Theory of Elastic
Stability, 2nd ed., 5.3 and 2.17). Bending moments do not act on the twist here (no lateral buckling
of beams). Every assumed deflection is a possible one, so factors come from above and fall with h^4.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fem.solvers import SolverError
from fem.unit_solutions import Elastic
from geometry.bars import Sections
from geometry.mesh import FloatArray, IntArray

_COUNT = 6  # Gauss points along a member
POINTS, WEIGHTS = (np.polynomial.legendre.leggauss(_COUNT)[k] for k in (0, 1))
POINTS, WEIGHTS = (POINTS + 1) / 2, WEIGHTS / 2


def gauss_points(nodes: FloatArray, members: IntArray) -> FloatArray:
    """Where sections and distributed loads are given along each member, (m, 6, 3), mm."""
    start, end = nodes[members[:, 0]], nodes[members[:, 1]]
    return np.asarray(start[:, None] + POINTS[:, None] * (end - start)[:, None])


@dataclass(frozen=True, eq=False)
class Frame:
    """Straight members between nodes.

    nodes     (n, 3)  mm
    members   (m, 2)  nodes at their start and end
    up        (3,) or (m, 3)  a direction in each member's local x-y plane; y is on its side
    sections  along the members, at their Gauss points
    material  of all members
    """

    nodes: FloatArray
    members: IntArray
    up: FloatArray
    sections: Sections
    material: Elastic

    def __post_init__(self) -> None:
        if self.nodes.ndim != 2 or self.nodes.shape[1] != 3:
            raise ValueError(f"a frame's nodes must have shape (n, 3), got {self.nodes.shape}")
        if self.members.ndim != 2 or self.members.shape[1] != 2 or not len(self.members):
            raise ValueError(f"members must have shape (m, 2), m > 0, got {self.members.shape}")
        if self.members.min() < 0 or self.members.max() >= len(self.nodes):
            raise ValueError(f"members name nodes outside 0 .. {len(self.nodes) - 1}")
        short = np.flatnonzero(~(self.lengths > 0))
        if len(short):
            raise ValueError(f"member {short[0]} has no length")
        side = np.cross(self._along, np.broadcast_to(self.up, (len(self.members), 3)))
        bad = np.flatnonzero(~(np.linalg.norm(side, axis=1) > 1e-6 * np.linalg.norm(self.up)))
        if len(bad):
            raise ValueError(f"member {bad[0]} lies along its `up` direction, which must be aside")
        self.sections.broadcast((len(self.members), _COUNT))

    @cached_property
    def lengths(self) -> FloatArray:
        """(m,) mm."""
        ends = self.nodes[self.members]
        return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))

    @property
    def _along(self) -> FloatArray:
        ends = self.nodes[self.members]
        return np.asarray((ends[:, 1] - ends[:, 0]) / self.lengths[:, None])

    @cached_property
    def axes(self) -> FloatArray:
        """Local x, y, z of each member as rows, (m, 3, 3)."""
        along = self._along
        side = np.cross(along, np.broadcast_to(self.up, along.shape))
        side /= np.linalg.norm(side, axis=1, keepdims=True)
        return np.stack([along, np.cross(side, along), side], axis=1)

    @cached_property
    def compliance(self) -> FloatArray:
        """Strains of a section per section force, the diagonal (m, 6 points, 6)."""
        young = self.material.youngs_modulus
        shear = young / (2 * (1 + self.material.poisson_ratio))
        s = self.sections.broadcast((len(self.members), _COUNT))
        stiff = [young * s.area, shear * s.shear_area_y, shear * s.shear_area_z]
        stiff += [shear * s.torsion, young * s.inertia_y, young * s.inertia_z]
        return np.asarray(1 / np.stack(stiff, axis=-1))

    @cached_property
    def flexibility(self) -> FloatArray:
        """Motion of a member's end per force there, its start held, (m, 6, 6)."""
        carry = _carried(self.lengths[:, None] * (1 - POINTS))
        weights = WEIGHTS * self.lengths[:, None]
        return np.asarray(
            np.einsum("mg,mgik,mgi,mgil->mkl", weights, carry, self.compliance, carry)
        )

    @cached_property
    def deformation(self) -> FloatArray:
        """Local motion of the end against the start, per global unknown, (m, 6, 12)."""
        count = len(self.members)
        local = np.zeros((count, 6, 12))
        local[:, range(6), range(6)] = -1
        local[:, range(6), range(6, 12)] = 1
        local[:, 1, 5], local[:, 2, 4] = -self.lengths, self.lengths
        turned = np.einsum("mrfi,mij->mrfj", local.reshape(count, 6, 4, 3), self.axes)
        return np.asarray(turned.reshape(count, 6, 12))

    @cached_property
    def unknowns(self) -> IntArray:
        """Global unknowns of each member, (m, 12)."""
        own = 6 * self.members[:, :, None] + np.arange(6)
        return np.asarray(own.reshape(-1, 12))

    def dense_stiffness(self) -> FloatArray:
        """Stiffness matrix (6 n, 6 n), N/mm, N, N mm."""
        return self.assembled(self._stiffnesses)

    @cached_property
    def points(self) -> FloatArray:
        """The Gauss points of the members, (m, 6, 3), mm."""
        return gauss_points(self.nodes, self.members)

    def assembled(self, blocks: FloatArray) -> FloatArray:
        """Matrix (6 n, 6 n) of one (m, 12, 12) of each member."""
        result = np.zeros((6 * len(self.nodes),) * 2)
        np.add.at(result, (self.unknowns[:, :, None], self.unknowns[:, None, :]), blocks)
        return result

    @cached_property
    def _stiffnesses(self) -> FloatArray:
        """Of the members, (m, 12, 12)."""
        blocks = np.swapaxes(self.deformation, 1, 2) @ np.linalg.solve(
            self.flexibility, self.deformation
        )
        return np.asarray((blocks + np.swapaxes(blocks, 1, 2)) / 2)


def _carried(arm: FloatArray) -> FloatArray:
    """Section forces per force at the end, `arm` (...) mm away along x, (..., 6, 6)."""
    carry = np.broadcast_to(np.eye(6), (*arm.shape, 6, 6)).copy()
    carry[..., 5, 1], carry[..., 4, 2] = arm, -arm
    return carry


_NONE = 1e-9  # of the largest factor's inverse: below it, round-off
_BESIDE = 1e-6  # of a factor: how far from it the modes are counted
MECHANISM = 1e-13  # of the largest: stiffness below it is none, in unknowns of equal stiffness
_ROUND_OFF = 4 * np.finfo(float).eps  # of the largest stiffness, in the same unknowns


class LooseFrameError(ValueError):
    """A frame in which something moves without strain, or without any that double precision has."""


@dataclass(frozen=True, eq=False)
class FrameModes:
    """Buckling modes of one load state, lowest first.

    factors    (k,) load factors above 0
    shapes     (n, k) unknowns, without a scale of their own
    reversed   the factor of the loads turned round, > 0, that buckles first; None: none does
    round_off  of a factor, over it: members of unlike stiffness leave few digits to the softest
    """

    factors: FloatArray
    shapes: FloatArray
    reversed: float | None
    round_off: float = 0.0


def integration_matrix() -> FloatArray:
    """Integrals from 0 to each Gauss point of the polynomial through values there, (6, 6)."""
    powers = np.arange(6.0)
    primitive = POINTS[:, None] ** (powers + 1) / (powers + 1)
    return np.asarray(np.linalg.solve((POINTS[:, None] ** powers).T, primitive.T).T)


def work_of_axial_force(frame: Frame) -> FloatArray:
    """Geometric stiffness per unit of axial force at each Gauss point, (m, 6, 12, 12).

    In global axes and the order of `frame.unknowns`; each is symmetric and positive semidefinite.
    """
    ends = np.linalg.solve(frame.flexibility, frame.deformation)  # (m, 6, 12)
    reach = frame.lengths[:, None] * (1 - POINTS)
    compliance = frame.compliance
    force = np.repeat(ends[:, None], 6, axis=1)  # (m, g, 6, 12)
    force[:, :, 5] += reach[..., None] * ends[:, None, 1]
    force[:, :, 4] -= reach[..., None] * ends[:, None, 2]
    strain = compliance[..., None] * force
    turned = np.einsum("gh,m,mhiu->mgiu", integration_matrix(), frame.lengths, strain[:, :, 4:])
    start = np.zeros((len(frame.members), 3, 12))
    start[:, :, 3:6] = frame.axes  # local turns of the start
    slope_y = start[:, None, 2] + turned[:, :, 1] + strain[:, :, 1]
    slope_z = -start[:, None, 1] - turned[:, :, 0] + strain[:, :, 2]
    s = frame.sections.broadcast((len(frame.members), 6))
    twist = np.sqrt((s.inertia_y + s.inertia_z) / s.area)[..., None] * strain[:, :, 3]
    rows = np.stack([slope_y, slope_z, twist], axis=2)
    weight = WEIGHTS * frame.lengths[:, None]
    return np.asarray(np.einsum("mg,mgku,mgkv->mguv", weight, rows, rows, optimize=True))


def buckling_modes(stiffness: FloatArray, geometric: FloatArray, *, count: int = 1) -> FrameModes:
    """Lowest factors f > 0 at which (K + f K_s) x = 0, by the largest mu of -K_s x = mu K x.

    The loads' size drops out; those in tension or without load give none. That none was skipped is
    proven by the number of negative eigenvalues of K + f K_s just below the first and just above
    the last factor, as far from them as round-off may move them. Raises LooseFrameError
    if something moves without strain, SolverError where the counts differ.
    """
    scaled, scale, softest = _scaled(stiffness)
    round_off = _ROUND_OFF / softest
    beside = max(_BESIDE, round_off)
    size = float(np.abs(geometric).max(initial=0.0))
    nothing = FrameModes(np.zeros(0), np.zeros((len(stiffness), 0)), None)
    if not size > 0:
        return nothing
    lower = np.linalg.cholesky(scaled)
    load = -scale[:, None] * (geometric / size) * scale
    reduced = np.linalg.solve(lower, np.linalg.solve(lower, load).T)
    values, vectors = np.linalg.eigh((reduced + reduced.T) / 2)
    least = _NONE * np.abs(values).max()
    opposite = 1 / (-values[0] * size) if values[0] < -least else None
    order = np.flatnonzero(values > least)[::-1]
    if not len(order):
        return replace(nothing, reversed=opposite)
    positive = 1 / values[order]
    factors = positive[:count]
    for factor in (factors[0] * (1 - beside), factors[-1] * (1 + beside)):
        wanted = int((positive < factor).sum())
        found = _negative(scaled - factor * load)
        if found != wanted:
            raise SolverError(
                f"{found} buckling modes of a frame stand below the factor {factor / size:.6g}, "
                f"{wanted} were found"
            )
    shapes = np.linalg.solve(lower.T, vectors[:, order[:count]])
    return FrameModes(factors / size, scale[:, None] * shapes, opposite, round_off)


def whitening(stiffness: FloatArray) -> FloatArray:
    """Combinations X (n, n) with X' K X = 1; LooseFrameError if something moves without strain."""
    scaled, scale = unit_diagonal(stiffness)
    try:
        inverse = lower_inverse(scaled)
        # the smallest eigenvalue is above 1/|inverse|^2, the largest below the trace
        proven = (inverse**2).sum() * len(scaled) * MECHANISM < 1
    except np.linalg.LinAlgError:
        proven = False
    if not proven:
        _softest(scaled)
        inverse = lower_inverse(scaled)
    return np.asarray(scale[:, None] * inverse.T)


def lower_inverse(matrix: FloatArray) -> FloatArray:
    """Inverse of the lower triangle that makes matrices (..., n, n); LinAlgError without one."""
    lower = np.linalg.cholesky(matrix)
    return np.asarray(np.linalg.inv(lower))


def _scaled(stiffness: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Stiffness scaled to ones on its diagonal, the factors of the unknowns that do so.

    And the smallest eigenvalue over the largest.
    """
    scaled, scale = unit_diagonal(stiffness)
    return scaled, scale, _softest(scaled)


def unit_diagonal(stiffness: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Stiffness scaled to ones on its diagonal, and the factors that do so; or LooseFrameError."""
    diagonal = np.diag(stiffness)
    if not (diagonal > 0).all():
        raise LooseFrameError("the frame can move: an unknown has no stiffness")
    scale = 1 / np.sqrt(diagonal)
    return scale[:, None] * stiffness * scale, scale


def _softest(scaled: FloatArray) -> float:
    """The smallest eigenvalue over the largest."""
    values = np.linalg.eigvalsh(scaled)
    if values[0] < MECHANISM * values[-1]:
        raise LooseFrameError("the frame can move without strain")
    return float(values[0] / values[-1])


def _negative(matrix: FloatArray) -> int:
    """Number of negative eigenvalues."""
    return int((np.linalg.eigvalsh(matrix) < 0).sum())
