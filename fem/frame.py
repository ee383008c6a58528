"""Frames of straight Timoshenko members in space: their stiffness.

A member's stiffness is the inverse of its flexibility, the integral of H' C H along it, where H
carries the forces at its end to the section and C is the section's compliance (Przemieniecki,
Theory of Matrix Structural Analysis, 1968, sections 5.6 and 8.3). So prismatic members are exact
at any slenderness, without locking; tapers are as exact as Gauss quadrature of 1/EI. Unknown
6 n + i of node n: displacements along x, y, z, then turns about x, y, z.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

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
