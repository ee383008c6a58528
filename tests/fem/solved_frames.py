"""Frames under loads: displacement, section forces, inertia relief, for tests of `fem.frame`."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

import fem.frame
from fem.frame import POINTS, WEIGHTS
from fem.solvers import Factor, factorize
from fem.unit_solutions import rigid_modes
from geometry.mesh import FloatArray, IntArray

_COUNT = len(POINTS)


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

    def __add__(self, other: "FrameLoads") -> "FrameLoads":
        return FrameLoads(self.nodal + other.nodal, self.distributed + other.distributed)

    def combined(self, factors: FloatArray) -> "FrameLoads":
        """Sums of the cases: factors (c, k) give k new cases."""
        return FrameLoads(self.nodal @ factors, self.distributed @ factors)


class Frame(fem.frame.Frame):
    """A frame that takes loads."""

    @cached_property
    def stiffness(self) -> "scipy.sparse.csr_array":
        """The whole stiffness matrix, N/mm, N, N mm."""
        return scipy.sparse.csr_array(self.dense_stiffness())

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


def _carried(arm: FloatArray) -> FloatArray:
    """Section forces per force at the end, `arm` (...) mm away along x, (..., 6, 6)."""
    carry = np.broadcast_to(np.eye(6), (*arm.shape, 6, 6)).copy()
    carry[..., 5, 1], carry[..., 4, 2] = arm, -arm
    return carry
