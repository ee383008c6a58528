"""The rung `beam`: buckling of a part as a Timoshenko frame of its profile.

Its stress is the rung `formula`'s: over all kinds of checks that lies nearer to solids than a
frame's, which settled 19 of 512 recorded verdicts on stress, all as the solid does.

The part's wrenches are unit cases of the frame, solved with its inertia.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import scipy

from checks.design.data import Part
from checks.handbook.pin_loaded_hole import PATTERNS
from checks.models import shapes
from checks.models.shapes import shape_model
from checks.part.part_loads import PartLoads, first_largest
from checks.result.derivation import Given, Item, Step
from checks.strength.part_strength import elastic_of
from checks.stress.stress_result import ElasticLoad, RungModel
from fem.frame import POINTS, WEIGHTS, Frame, FrameLoads, FrameSolution
from fem.frame_buckling import geometric_forms
from fem.frame_joints import bar_frame
from fem.load_states import leading_states, worst_position
from fem.unit_loads import ACCELERATIONS, bearing_coefficients
from geometry.bars import bore_places
from geometry.mesh import FloatArray, Interface

_PIECES = 12  # of the longest stretch
_PLANAR, _TILTS = [0, 1, 5], [3, 4]
_CLOSE = 0.999  # of the largest share: an estimate below that over it asks for no other position
_COUNT = 3  # modes of each state
_SOFTEST = 40  # motions of the frame that modes are made of
_NONE = 1e-9  # of the largest factor's inverse: below it, round-off
_BLOCK = 4096  # positions at a time


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


def model_of(part: Part, loads: PartLoads) -> RungModel | None:
    """A part's stress by formula, its buckling by its frame; None where there is none of both."""
    solved = solve_frame(part)
    base = None if solved is None else shapes.model_of(part, loads)
    if solved is None or base is None:
        return None
    coefficients = solved.coefficients(loads)
    return replace(
        base,
        rung="beam",
        residual=max(base.residual, solved.residual(loads, coefficients)),
        buckling=buckling_of(part, loads, solved, coefficients),
        unknowns=6 * len(solved.frame.nodes),
    )


# At which position a part's frame buckles first, its pins as hinges that let it tilt.
#
# As for solids, by fem/load_states.py.


def buckling_of(
    part: Part, loads: PartLoads, solved: BeamSolution, coefficients: FloatArray
) -> ElasticLoad:
    """Largest share of the elastic buckling load over all positions."""
    search = _Search(solved, coefficients)
    found = search.worst()
    told = (
        f"the frame's factor is the eigenvalue of a frame of {6 * len(solved.frame.nodes)} "
        "unknowns, which no formula gives"
    )
    plane, share, position = "nothing presses or bends it", 0.0, 0
    if found is not None:
        position, factor, shape = found
        share = 1 / factor
        plane = f"{search.plane(shape)}: eigenvalue of the frame, its pins let it tilt"
    model = shape_model(part.geometry)
    walls = np.zeros(1) if model is None else model.walls(part, part.geometry, loads)
    if walls.max() > share:
        (position,) = first_largest(walls)
        wall = float(walls[position])
        said = "walls, at the end that is pressed"
        return ElasticLoad(wall, position, said, partial(_items, 0.0, wall), told)
    return ElasticLoad(share, position, plane, partial(_items, share, 0.0), told)


def _items(share: float, walls: float) -> list[Item]:
    """How the share comes about: frame or walls."""
    if walls:
        said = "share that the stress in the walls is of that under which plates buckle"
        source = "Timoshenko and Gere, 2nd ed., 9.2"
        first: Item = Given("f", said, walls, "", source, main=True)
    elif share:
        first = Given("lam", "lowest factor on all loads at which the frame buckles", 1 / share, "",
                      "eigenvalue: docs/theory/rungs_beam.md", main=True)  # fmt: skip
    else:
        return [Step("share", "share of the elastic buckling load", "0", main=True)]
    formula = "f" if walls else "1/lam"
    return [first, Step("share", "share of the elastic buckling load", formula, main=True)]


@dataclass(frozen=True, eq=False)
class _Search:
    solved: BeamSolution
    coefficients: FloatArray

    @cached_property
    def fields(self) -> FloatArray:
        """Motions (6 n, k) that the pins allow: the softest of the frame, of unit strain energy.

        Held are the displacements at each pin, along the part at the first only, and the turn about
        the part's axis there (fem.end_conditions.link_solid).
        """
        frame = self.solved.frame
        scale = np.tile(np.r_[np.ones(3), np.full(3, 1 / self.solved.size)], len(frame.nodes))
        rows = self._held() * scale
        free = np.linalg.qr(rows.T, mode="complete")[0][:, len(rows) :] * scale[:, None]
        values, vectors = scipy.linalg.eigh(
            free.T @ (frame.stiffness @ free), subset_by_index=(0, min(_SOFTEST, free.shape[1]) - 1)
        )
        return np.asarray(free @ (vectors / np.sqrt(values)))

    def _held(self) -> FloatArray:
        first, second = (6 * entry.node for entry in self.solved.entries[:2])
        held = [first, first + 1, first + 2, first + 3, second + 1, second + 2]
        return np.eye(6 * len(self.solved.frame.nodes))[held]

    @cached_property
    def forms(self) -> FloatArray:
        """Second-order work (n_basis, k, k) of each unit case between the fields.

        A pin's push goes through its axis, however far the bore turns (docs/theory/buckling.md):
        what acts along the part at a node keeps the moment that it has about the pin, none.
        """
        forms = geometric_forms(self.solved.frame, self.solved.at_points, self.fields)
        first = 0
        for entry in self.solved.entries:
            count = entry.loads.nodal.shape[1]
            along = entry.loads.nodal[::6]  # (n, columns)
            nodes = np.flatnonzero(np.abs(along).max(axis=1) > 0.0)
            place = self.solved.frame.nodes[nodes, 0] - entry.interface.centre[0]
            virials, turns = along[nodes] * place[:, None], self.fields[6 * nodes + 5]
            forms[first : first + count] -= np.einsum("nc,nk,nl->ckl", virials, turns, turns)
            first += count
        return forms

    def modes(self, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lowest factors above 0 of a state (n_basis,) of the loads, and shapes by the fields."""
        values, vectors = np.linalg.eigh(-np.tensordot(state, self.forms, axes=1))
        order = np.flatnonzero(values > _NONE * np.abs(values).max(initial=0.0))[::-1][:_COUNT]
        return 1 / values[order], vectors[:, order]

    def worst(self) -> tuple[int, float, FloatArray] | None:
        """The position with the lowest factor found, the factor and its shape (6 n,)."""
        states = leading_states(self._measure(), self.coefficients)
        fields = [self.modes(sign * state)[1] for state in states for sign in (1.0, -1.0)]
        shapes: dict[int, FloatArray] = {}

        def solve(position: int) -> tuple[float, FloatArray]:
            factors, modes = self.modes(self.coefficients[:, position])
            shapes[position] = modes
            return (float(1 / factors[0]) if len(factors) else 0.0), modes

        worst = worst_position(solve, self._shares, fields, close=_CLOSE)
        if worst is None:
            return None
        position, share = worst
        return position, 1 / share, self.fields @ shapes[position][:, 0]

    def plane(self, shape: FloatArray) -> str:
        """In which plane a mode moves more."""
        moved = np.abs(shape.reshape(-1, 6)[:, :3]).max(axis=0)
        return "out of plane" if moved[2] > moved[:2].max() else "in plane"

    def _measure(self) -> FloatArray:
        """Section forces (m, n_basis) of the unit cases, moments over the part's size."""
        scale = np.r_[np.ones(3), np.full(3, 1 / self.solved.size)]
        return np.asarray(
            (self.solved.at_points * scale[:, None]).reshape(-1, len(self.coefficients))
        )

    def _shares(self, fields: FloatArray) -> FloatArray:
        """Share (n,) of its lowest factor that each position's load is at least; 0 without any."""
        own = np.linalg.qr(fields)[0]
        forms = own.T @ self.forms @ own
        count = self.coefficients.shape[1]
        result = np.zeros(count)
        for start in range(0, count, _BLOCK):
            part = self.coefficients[:, start : start + _BLOCK]
            states = -np.tensordot(part.T, forms, axes=1)
            result[start : start + _BLOCK] = np.linalg.eigvalsh(states)[:, -1]
        return np.maximum(result, 0.0)


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
