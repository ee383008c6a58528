"""A part's profile as a Timoshenko frame: its wrenches as unit cases, solved with its inertia."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from checks.design.data import Part
from checks.handbook.pin_loaded_hole import PATTERNS
from checks.part.part_loads import PartLoads
from checks.strength.part_strength import elastic_of
from fem.frame import POINTS, WEIGHTS, Frame, FrameLoads, FrameSolution
from fem.frame_joints import bar_frame
from fem.unit_loads import ACCELERATIONS, bearing_coefficients
from geometry.bars import bore_places
from geometry.mesh import FloatArray, Interface

_PIECES = 12  # of the longest stretch
_PLANAR, _TILTS = [0, 1, 5], [3, 4]


@dataclass(frozen=True, eq=False)
class Entry:
    """How the wrench of an interface comes into the frame.

    node   at the interface
    loads  one case per column: of a bore those of `bearing_coefficients` and couples about x and y,
           of an end face F_x, F_y and M_z
    """

    interface: Interface
    node: int
    loads: FrameLoads

    def coefficients(self, wrench: FloatArray) -> FloatArray:
        """Coefficients (n, columns) of the cases for wrenches (n, 6)."""
        planar = wrench[:, _PLANAR]
        if self.interface.kind != "bore":
            return np.asarray(planar)
        return np.hstack([bearing_coefficients(planar, inward=False), wrench[:, _TILTS]])


@dataclass(frozen=True, eq=False)
class BeamSolution:
    """A part's frame, solved for its unit cases.

    Each is in balance in the plane with the inertia of the frame, so that loads which come with
    other mass properties than the frame's are balanced as the solid balances them.

    resultants  (6, n_basis) of the balanced cases, about the origin
    """

    frame: Frame
    entries: Sequence[Entry]
    solution: FrameSolution
    resultants: FloatArray

    @cached_property
    def at_points(self) -> FloatArray:
        """Section forces (m, 6 points, 6, n_basis) at the members' Gauss points."""
        return self.solution.section_forces(POINTS)

    @cached_property
    def size(self) -> float:
        """The part's extent, mm."""
        return float(np.ptp(self.frame.nodes, axis=0).max())

    def coefficients(self, loads: PartLoads) -> FloatArray:
        """Coefficients (n_basis, n) of the cases; one interface takes the tilting that is left."""
        columns, held, first = [], [], 0
        for entry in self.entries:
            name = entry.interface.name
            columns.append(entry.coefficients(loads.wrenches[name]))
            first += columns[-1].shape[1]
            if name == loads.tilt_held_at and entry.interface.kind == "bore":
                held = [first - 2, first - 1]
        result = np.hstack([*columns, loads.accelerations]).T
        if held:
            result[held] -= self.resultants[_TILTS] @ result
        return np.ascontiguousarray(result)

    def residual(self, loads: PartLoads, coefficients: FloatArray) -> float:
        """Force on the frame's support, couples over the part's size, over the largest force."""
        largest = loads.largest_force
        if not largest:
            return 0.0
        scale = np.r_[np.ones(3), np.full(3, 1 / self.size)]
        held = np.abs(self.solution.reactions @ coefficients) * scale[:, None]
        return float(held.max()) / largest


def solve_frame(part: Part) -> BeamSolution | None:
    """Solve a part's profile for its interfaces' columns and the four accelerations.

    None for a shape without a profile, and where something else than pins in bores and end faces
    presses on it.
    """
    bar, interfaces = part.geometry.profile, part.geometry.placed_interfaces
    if bar is None or any(one.kind not in ("bore", "face") for one in interfaces):
        return None
    holes = [(float(one.centre[0]), one.radius) for one in interfaces if one.radius]
    frame = bar_frame(bar, elastic_of(part), _PIECES, bore_places(holes))
    entries = [_entry(frame, one) for one in interfaces]
    cases = _joined([*(entry.loads for entry in entries), frame.planar_inertia()])
    resultants = frame.resultants(cases)
    relief = _relief(resultants, float(np.ptp(frame.nodes[:, 0])))
    held = frame.held(6 * entries[0].node + np.arange(6))
    solution = held.solve(cases.combined(relief))
    return BeamSolution(frame, entries, solution, resultants @ relief)


def _entry(frame: Frame, interface: Interface) -> Entry:
    """An interface at the node where it stands."""
    away = np.abs(frame.nodes[:, 0] - interface.centre[0])
    node = int(away.argmin())
    assert away[node] <= 1e-9 * np.ptp(frame.nodes[:, 0])
    loads = frame.no_loads(6)
    loads.nodal[6 * node + np.arange(6), np.arange(6)] = 1.0
    if interface.kind == "face":
        return Entry(interface, node, loads.combined(np.eye(6)[:, _PLANAR]))
    tilted = loads.combined(np.eye(6)[:, _TILTS])
    return Entry(interface, node, _joined([_pressed(frame, interface), tilted]))


def _pressed(frame: Frame, interface: Interface) -> FrameLoads:
    """Columns of a bore's pressure, on the nodes that stand within it.

    The rim is cut half-way between the nodes' angles, r cos(angle) = x - centre; each arc with its
    image about the bar's axis presses on its node with its force, and turns it with its couple.
    """
    radius, centre = interface.radius, float(interface.centre[0])
    x = frame.nodes[:, 0] - centre
    close = 1e-9 * radius
    within = np.flatnonzero(np.abs(x) <= radius + close)[::-1]
    angles = np.arccos(np.clip(x[within] / radius, -1.0, 1.0))
    edges = np.r_[0.0, (angles[1:] + angles[:-1]) / 2, np.pi]
    loads = frame.no_loads(len(PATTERNS))
    for node, low, high in zip(within, edges[:-1], edges[1:], strict=True):
        angle = low + (high - low) * POINTS
        weight = 2 * WEIGHTS * (high - low) * radius  # both arcs
        rim = radius * np.stack([np.cos(angle), np.sin(angle)])
        for column, (along, across) in enumerate(_tractions(angle, radius)):
            even = PATTERNS[column].startswith("cos")
            force = (weight @ along, 0.0) if even else (0.0, weight @ across)
            turn = 0.0 if even else weight @ ((rim[0] - x[node]) * across - rim[1] * along)
            loads.nodal[6 * node + np.array(_PLANAR), column] += np.array([*force, turn])
    return loads


def _tractions(angle: FloatArray, radius: float) -> list[tuple[FloatArray, FloatArray]]:
    """Traction along x and y of each column at angles of a bore's rim, per mm of rim, 1/mm."""
    outward = np.cos(angle), np.sin(angle)
    found = []
    for name in PATTERNS[:-1]:
        wave, n = name.split()
        size = (np.cos if wave == "cos" else np.sin)(int(n) * angle) / (np.pi * radius)
        found.append((size * outward[0], size * outward[1]))
    turn = 1 / (2 * np.pi * radius**2)
    return [*found, (-turn * outward[1], turn * outward[0])]


def _relief(resultants: FloatArray, extent: float) -> FloatArray:
    """Combinations (n_basis, n_basis) of the cases in which accelerations balance each."""
    count = resultants.shape[1]
    closing = count - len(ACCELERATIONS) + np.arange(3)
    scale = np.array([1.0, 1.0, 1.0 / extent])[:, None]
    relief = np.eye(count)
    relief[closing] -= np.linalg.solve(
        scale * resultants[np.ix_(_PLANAR, closing)], scale * resultants[_PLANAR]
    )
    return relief


def _joined(loads: list[FrameLoads]) -> FrameLoads:
    return FrameLoads(
        np.concatenate([load.nodal for load in loads], axis=-1),
        np.concatenate([load.distributed for load in loads], axis=-1),
    )
