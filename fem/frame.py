"""Frames of straight Timoshenko members in space: displacement, section forces, inertia relief.

A member's stiffness is the inverse of its flexibility, the integral of H' C H along it, where H
carries the forces at its end to the section and C is the section's compliance (Przemieniecki,
Theory of Matrix Structural Analysis, 1968, sections 5.6 and 8.3). So prismatic members are exact
at any slenderness, without locking; tapers are as exact as Gauss quadrature of 1/EI. Loads
distributed along a member enter with their exact fixed-end forces. Unknown 6 n + i of node n:
displacements along x, y, z, then turns about x, y, z.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
import scipy

from fem.solvers import Factor, factorize
from fem.unit_solutions import Elastic, rigid_modes
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
class FrameLoads:
    """Load cases on a frame, in global axes.

    nodal        (6 n_nodes, c)  N, N mm
    distributed  (m, 6, 3, c)    N/mm at the members' Gauss points
    """

    nodal: FloatArray
    distributed: FloatArray

    def __post_init__(self) -> None:
        if self.nodal.ndim != 2 or self.distributed.ndim != 4:
            raise ValueError(
                f"loads on a frame need nodal (6 n, c) and distributed (m, {_COUNT}, 3, c), got "
                f"{self.nodal.shape} and {self.distributed.shape}"
            )
        if self.nodal.shape[-1] != self.distributed.shape[-1]:
            raise ValueError(
                f"{self.nodal.shape[-1]} cases of nodal loads cannot go with "
                f"{self.distributed.shape[-1]} of distributed ones"
            )

    def __add__(self, other: Self) -> "FrameLoads":
        return FrameLoads(self.nodal + other.nodal, self.distributed + other.distributed)

    def combined(self, factors: FloatArray) -> "FrameLoads":
        """Sums of the cases: factors (c, k) give k new cases."""
        return FrameLoads(self.nodal @ factors, self.distributed @ factors)


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

    @cached_property
    def stiffness(self) -> "scipy.sparse.csr_array":
        """The whole stiffness matrix, N/mm, N, N mm."""
        rows = np.repeat(self.unknowns, 12, axis=1).ravel()
        columns = np.tile(self.unknowns, (1, 12)).ravel()
        places, size = (rows, columns), 6 * len(self.nodes)
        values = self._stiffnesses.ravel()
        return scipy.sparse.coo_array((values, places), shape=(size, size)).tocsr()

    def dense_stiffness(self) -> FloatArray:
        """The same with its zeros: of a frame of few nodes."""
        return self.assembled(self._stiffnesses)

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

    # loads ------------------------------------------------------------------------------------

    def no_loads(self, cases: int = 1) -> FrameLoads:
        """Loads of zero, to add to."""
        return FrameLoads(
            np.zeros((6 * len(self.nodes), cases)), np.zeros((len(self.members), _COUNT, 3, cases))
        )

    def nodal(self, node: int, wrench: Iterable[float]) -> FrameLoads:
        """One case: force and couple (6,) at a node, N and N mm."""
        loads = self.no_loads()
        loads.nodal[6 * node : 6 * node + 6, 0] = list(wrench)
        return loads

    @cached_property
    def points(self) -> FloatArray:
        """The Gauss points of the members, (m, 6, 3), mm."""
        return gauss_points(self.nodes, self.members)

    def inertia(self, accelerations: FloatArray) -> FrameLoads:
        """Loads of a field of accelerations (m, 6, 3, c) at the Gauss points, mm/s2.

        The mass lies on the members' axes: the sections' own rotary inertia is left out.
        """
        area = self.sections.broadcast((len(self.members), _COUNT)).area
        force = -self.material.density * area[..., None, None] * accelerations
        return FrameLoads(np.zeros((6 * len(self.nodes), force.shape[-1])), force)

    def planar_inertia(self) -> FrameLoads:
        """Unit cases a_x, a_y, alpha, omega^2 of a body that moves in the x-y plane."""
        x, y, _ = np.moveaxis(self.points, -1, 0)
        zero, one = np.zeros_like(x), np.ones_like(x)
        fields = [[one, zero, zero], [zero, one, zero], [-y, x, zero], [-x, -y, zero]]
        return self.inertia(np.moveaxis(np.array(fields), (0, 1), (3, 2)))

    def resultants(self, loads: FrameLoads) -> FloatArray:
        """Force and moment about the origin of each case, (6, c)."""
        nodal = loads.nodal.reshape(len(self.nodes), 2, 3, -1)
        force = np.einsum("g,m,mgic->mgic", WEIGHTS, self.lengths, loads.distributed, optimize=True)
        turn = np.cross(self.nodes[:, :, None], nodal[:, 0], axis=1).sum(axis=0)
        turn += nodal[:, 1].sum(axis=0)
        turn += np.cross(self.points[..., None], force, axis=2).sum(axis=(0, 1))
        return np.concatenate([nodal[:, 0].sum(axis=0) + force.sum(axis=(0, 1)), turn])

    def relieved(self, loads: FrameLoads) -> tuple[FrameLoads, FloatArray]:
        """Loads in balance with the inertia of a free frame, and its accelerations (6, c).

        The accelerations are those of the point at the origin (mm/s2) and angular ones (rad/s2).
        Raises ValueError if a load turns the frame about an axis on which all its mass lies.
        """
        fields = np.zeros((*self.points.shape, 6))
        fields[..., [0, 1, 2], [0, 1, 2]] = 1
        for k, axis in enumerate(np.eye(3)):
            fields[..., 3 + k] = np.cross(axis, self.points)
        unit = self.inertia(fields)
        size = float(np.ptp(self.nodes, axis=0).max())
        scale = np.r_[np.ones(3), np.full(3, 1 / size)]
        balance = self.resultants(unit) * scale[:, None] * scale
        wanted = -self.resultants(loads) * scale[:, None]
        found, *_ = np.linalg.lstsq(balance, wanted, rcond=1e-10)
        left = np.abs(balance @ found - wanted).max(axis=0)
        largest = np.abs(loads.nodal.reshape(len(self.nodes), 6, -1)) * scale[:, None]
        largest = np.maximum(largest.max(axis=(0, 1)), np.abs(wanted).max(axis=0))
        if (left > 1e-9 * largest).any():
            raise ValueError(
                f"case {int(np.argmax(left))} turns the frame about an axis on which all its mass "
                "lies: no acceleration of the frame balances it"
            )
        accelerations = found * scale[:, None]
        return loads + unit.combined(accelerations), accelerations

    def held(self, held: IntArray) -> "HeldFrame":
        """Return the frame with these unknowns kept still, ready to be solved.

        Raises ValueError if it can move as a rigid body.
        """
        return HeldFrame(self, np.unique(held))


@dataclass(frozen=True, eq=False)
class HeldFrame:
    """A frame with some unknowns held still.

    held  (k,) unknowns
    """

    frame: Frame
    held: IntArray

    def __post_init__(self) -> None:
        frame = self.frame
        count = len(frame.nodes)
        ones, (start, end) = np.ones(len(frame.members)), frame.members.T
        joined = scipy.sparse.coo_array((ones, (start, end)), shape=(count, count))
        bodies, body = scipy.sparse.csgraph.connected_components(joined, directed=False)
        turns = np.zeros((count, 3, 6))
        turns[:, [0, 1, 2], [3, 4, 5]] = 1
        for k in range(bodies):
            nodes = np.flatnonzero(body == k)
            size = float(np.ptp(frame.nodes[nodes], axis=0).max(initial=0.0)) or 1.0
            moves = rigid_modes(frame.nodes[nodes] / size).reshape(-1, 3, 6)
            modes = np.zeros((6 * count, 6))
            modes[(6 * nodes[:, None] + np.arange(6)).ravel()] = np.concatenate(
                [moves, turns[nodes]], axis=1
            ).reshape(-1, 6)
            held = int(np.linalg.matrix_rank(modes[self.held], tol=1e-8))
            if held < 6:
                raise ValueError(
                    f"the frame can move: of the six rigid motions of what holds together with "
                    f"node {nodes[0]}, its supports stop {held}"
                )

    @cached_property
    def _free(self) -> IntArray:
        return np.setdiff1d(np.arange(6 * len(self.frame.nodes)), self.held)

    @cached_property
    def _factor(self) -> Factor:
        return factorize(scipy.sparse.triu(self.frame.stiffness[self._free][:, self._free]).tocsr())

    def solve(self, loads: FrameLoads) -> "FrameSolution":
        """Solve all load cases."""
        frame = self.frame
        local = np.einsum("mji,mgic->mgjc", frame.axes, loads.distributed)
        beyond = _beyond(local, np.r_[0.0, POINTS], frame.lengths)  # (m, 1 + g, 6, c)
        carry = _carried(frame.lengths[:, None] * (1 - POINTS))
        weights = WEIGHTS * frame.lengths[:, None]
        moved = np.einsum(
            "mg,mgik,mgi,mgic->mkc", weights, carry, frame.compliance, beyond[:, 1:], optimize=True
        )
        clamping = np.linalg.solve(frame.flexibility, moved)
        nodal = np.einsum("mku,mkc->muc", frame.deformation, clamping)
        whole = beyond[:, 0].reshape(len(frame.members), 2, 3, -1)
        nodal[:, :6] += np.einsum("mji,mfjc->mfic", frame.axes, whole).reshape(*nodal[:, :6].shape)
        right = loads.nodal.copy()
        np.add.at(right, frame.unknowns, nodal)
        displacement = np.zeros_like(right)
        displacement[self._free], residual = self._factor.solve(right[self._free])
        reactions = (frame.stiffness @ displacement - right)[self.held]
        deformed = np.einsum("mku,muc->mkc", frame.deformation, displacement[frame.unknowns])
        ends = np.linalg.solve(frame.flexibility, deformed) - clamping
        return FrameSolution(frame, displacement, reactions, ends, local, residual)


@dataclass(frozen=True, eq=False)
class FrameSolution:
    """A solved frame.

    displacement  (6 n_nodes, c)  mm, rad
    reactions     (k, c)          N, N mm at the held unknowns, in ascending order
    end_forces    (m, 6, c)       on each member's end, local axes, N and N mm
    distributed   (m, 6, 3, c)    N/mm at Gauss points, local axes
    residual      largest backward error of the solve
    """

    frame: Frame
    displacement: FloatArray
    reactions: FloatArray
    end_forces: FloatArray
    distributed: FloatArray
    residual: float

    def section_forces(self, stations: FloatArray) -> FloatArray:
        """N, V_y, V_z, T, M_y, M_z in local axes at stations (s,) in 0 .. 1, (m, s, 6, c).

        They are what the part beyond the section exerts: N above 0 is tension, and M_z above 0
        stretches the fibres at -y.
        """
        stations = np.asarray(stations, dtype=float)
        carry = _carried(self.frame.lengths[:, None] * (1 - stations))
        constant = np.einsum("msik,mkc->msic", carry, self.end_forces)
        return np.asarray(constant + _beyond(self.distributed, stations, self.frame.lengths))


def _carried(arm: FloatArray) -> FloatArray:
    """Section forces per force at the end, `arm` (...) mm away along x, (..., 6, 6)."""
    carry = np.broadcast_to(np.eye(6), (*arm.shape, 6, 6)).copy()
    carry[..., 5, 1], carry[..., 4, 2] = arm, -arm
    return carry


def _beyond(distributed: FloatArray, stations: FloatArray, lengths: FloatArray) -> FloatArray:
    """Section forces of the distributed load beyond each station, (m, s, 6, c).

    The load is the polynomial through its values at the Gauss points.
    """
    reach = 1 - stations
    inner = stations[:, None] + reach[:, None] * POINTS  # (s, g)
    powers = np.vander(POINTS, _COUNT)
    shapes = np.linalg.solve(powers.T, np.vander(inner.ravel(), _COUNT).T).T
    shapes = shapes.reshape(len(stations), _COUNT, _COUNT)  # (s, point, load point)
    total = reach[:, None] * np.einsum("g,sgh->sh", WEIGHTS, shapes)
    first = reach[:, None] ** 2 * np.einsum("g,sgh->sh", WEIGHTS * POINTS, shapes)
    force = np.einsum("sh,m,mhic->msic", total, lengths, distributed)
    moment = np.einsum("sh,m,mhic->msic", first, lengths**2, distributed)
    zero = np.zeros_like(force[:, :, 0])
    return np.stack([*np.moveaxis(force, 2, 0), zero, -moment[:, :, 2], moment[:, :, 1]], axis=2)
