"""Section forces of a part's frame over its cycle: unit cases and their coefficients."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from checks.models.beam_entries import PLANAR, TILTS, entry_coefficients, reached
from checks.models.beam_parts import PartFrame
from checks.part.part_loads import PartLoads
from fem.frame import POINTS, FrameLoads, FrameSolution
from fem.unit_loads import ACCELERATIONS
from geometry.mesh import FloatArray


@dataclass(frozen=True, eq=False)
class BeamSolution:
    """A part's frame, solved for its unit cases.

    Each is in balance in the plane with the inertia of the frame, so that loads which come with
    other mass properties than the frame's are balanced as the solid balances them.

    resultants  (6, n_basis) of the balanced cases, about the origin
    """

    part: PartFrame
    solution: FrameSolution
    resultants: FloatArray

    @cached_property
    def at_sites(self) -> FloatArray:
        """Section forces (n_sites, 6, n_basis) at the part's sites."""
        stations = np.array(sorted({site.at for site in self.part.sites}))
        forces = self.solution.section_forces(stations)
        chosen = np.searchsorted(stations, [site.at for site in self.part.sites])
        return np.asarray(forces[[site.member for site in self.part.sites], chosen])

    @cached_property
    def at_points(self) -> FloatArray:
        """Section forces (m, 6 points, 6, n_basis) at the members' Gauss points."""
        return self.solution.section_forces(POINTS)

    def coefficients(self, loads: PartLoads) -> FloatArray:
        """Coefficients (n_basis, n) of the cases; one interface takes the tilting that is left."""
        columns, held, first = [], [], 0
        for entry in self.part.entries:
            name = entry.interface.name
            columns.append(entry_coefficients(entry, loads.wrenches[name], loads.reaches.get(name)))
            if name == loads.tilt_held_at and "M_x" in entry.names:
                held = [first + entry.names.index(couple) for couple in ("M_x", "M_y")]
            first += len(entry.names)
        result = np.hstack([*columns, loads.accelerations]).T
        if held:
            result[held] -= self.resultants[TILTS] @ result
        return np.ascontiguousarray(result)

    def residual(self, loads: PartLoads, coefficients: FloatArray) -> float:
        """Force on the frame's support, or force that did not enter it, over the largest force.

        The larger of both counts. Couples over the part's size.
        """
        largest = loads.largest_force
        if not largest:
            return 0.0
        scale = np.r_[np.ones(3), np.full(3, 1 / self.size)]
        held = np.abs(self.solution.reactions @ coefficients) * scale[:, None]
        worst = float(held.max())
        for entry in self.part.entries:
            left = np.setdiff1d(np.arange(6), reached(entry))
            wrench = np.abs(loads.wrenches[entry.interface.name][:, left]) * scale[left]
            worst = max(worst, float(wrench.max(initial=0.0)))
        return worst / largest

    def deflection(self, coefficients: FloatArray) -> float:
        """Largest displacement over the cycle between the interfaces, mm.

        Of the nodes from the straight line through those that stand farthest apart.
        """
        return _largest(self._bent, coefficients)

    @cached_property
    def size(self) -> float:
        """The part's extent, mm."""
        return float(np.ptp(self.part.frame.nodes, axis=0).max())

    @cached_property
    def _bent(self) -> FloatArray:
        nodes = self.part.frame.nodes
        axis = int(np.argmax(np.ptp(nodes, axis=0)))
        moved = self.solution.displacement.reshape(len(nodes), 6, -1)[:, :3]
        first, last = int(nodes[:, axis].argmin()), int(nodes[:, axis].argmax())
        share = (nodes[:, axis] - nodes[first, axis]) / (nodes[last, axis] - nodes[first, axis])
        line = moved[first] + share[:, None, None] * (moved[last] - moved[first])
        return np.asarray(moved - line)


def _largest(moved: FloatArray, coefficients: FloatArray) -> float:
    """Largest size of vectors (k, 3, n_basis) over all positions."""
    return max(float(np.linalg.norm(one @ coefficients, axis=0).max()) for one in moved)


def solve_frame(part: PartFrame) -> BeamSolution:
    """Solve a part's frame for its interfaces' columns and the four accelerations."""
    frame = part.frame
    inertia = frame.planar_inertia()
    inertia.distributed[list(part.massless)] = 0.0
    cases = _joined([*(entry.loads for entry in part.entries), inertia])
    resultants = frame.resultants(cases)
    relief = _relief(resultants, np.ptp(frame.nodes, axis=0))
    held = frame.held(6 * part.held + np.arange(6))
    return BeamSolution(part, held.solve(cases.combined(relief)), resultants @ relief)


def _relief(resultants: FloatArray, extent: FloatArray) -> FloatArray:
    """Combinations (n_basis, n_basis) of the cases in which accelerations balance each.

    A frame along z has no inertia about its own axis, and no couple about it is balanced.
    """
    rows = PLANAR if extent[:2].any() else PLANAR[:2]
    count = resultants.shape[1]
    closing = count - len(ACCELERATIONS) + np.arange(len(rows))
    scale = np.array([1.0, 1.0, 1.0 / float(extent.max())])[: len(rows), None]
    relief = np.eye(count)
    relief[closing] -= np.linalg.solve(
        scale * resultants[np.ix_(rows, closing)], scale * resultants[rows]
    )
    return relief


def _joined(loads: list[FrameLoads]) -> FrameLoads:
    return FrameLoads(
        np.concatenate([load.nodal for load in loads], axis=-1),
        np.concatenate([load.distributed for load in loads], axis=-1),
    )
