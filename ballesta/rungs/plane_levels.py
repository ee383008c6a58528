"""A part as a sheet on finer and finer meshes, until its peaks are known well enough."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from time import perf_counter

import numpy as np

from ballesta.part_loads import PartLoads
from ballesta.ties import first_largest
from fem.convergence import ErrorBar, discretisation_error
from fem.plane_bores import direct_bore
from fem.plane_unit_solutions import PlaneUnitSolutions, solve_plane_loads
from fem.recovery import von_mises
from fem.stress_history import StressHistory
from fem.unit_solutions import Elastic
from geometry.mesh import FloatArray, IntArray
from geometry.plane_outlines import PlaneOutline, PlaneSizes, mesh_outline, plane_sizes

_MOST_MESHES = 4
_MOST_ELEMENTS = 12_000
_HOT, _NEAR, _FAR = 0.8, 0.5, 3.0  # as fem/error_estimate.py has them for solids
_STEP, _STEEPEST = 1.5, 3.0
_ORDER = 2.0
_TILTS = 1e-9  # of the forces times the sheet's size: couples that are round-off


@dataclass(frozen=True, eq=False)
class PlaneLevel:
    """A sheet on one mesh under the cycle.

    places  (n_points,) numbers among the sheet's places
    added   (n, 3) rigid-body acceleration field that closes the balance
    face    mm, height z of the points; None: on the faces of the sheet, +-t/2
    flat    whether nothing bends it, so that one face shows all
    """

    solutions: PlaneUnitSolutions
    history: StressHistory
    places: IntArray
    added: FloatArray
    face: float | None
    flat: bool

    def deciding(self) -> tuple[int, int]:
        """The position of the peak, and the one whose stress is farthest from its stress.

        The longest way of the stress from the peak's position stands for what fatigue asks.
        """
        history = self.history
        (worst,) = first_largest(history.peaks_by_position()[0])
        away = history.coefficients - history.coefficients[:, [worst]]
        farthest = StressHistory(history.nodes, history.points, history.basis, away)
        (other,) = first_largest(farthest.peaks_by_position()[0])
        return worst, other

    def states(self, positions: tuple[int, int]) -> list[FloatArray]:
        """The load state of the first of two positions, and what is between it and the other."""
        worst, other = (self.history.coefficients[:, position] for position in positions)
        return [worst, other - worst]

    def peak(self, state: FloatArray) -> tuple[float, int]:
        """Largest von Mises stress under a load state, MPa, and its point."""
        stress = von_mises(self.history.basis @ state)
        return float(stress.max()), int(stress.argmax())

    def everywhere(self) -> tuple[StressHistory, IntArray, IntArray]:
        """The history at all places of the sheet, not on its outline and seams alone.

        And the six-node elements between them split in four, (m, 3) of its points, seen from
        outside against the clock; and for each point of `history` which of these it is.
        """
        split = self.solutions.sheet.side_of[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]]
        triangles = split.reshape(-1, 3)
        count = len(self.solutions.sheet.sides[0])
        number, points, basis = _stress_at(self.solutions, self.face, np.arange(count), self.flat)
        shown = self.places.copy()
        if not self.flat:
            triangles = np.concatenate([triangles, triangles[:, ::-1] + count])
            shown[len(shown) // 2 :] += count
        history = StressHistory(number, points, basis, self.history.coefficients)
        return history, triangles, shown

    def size_at(self, place: FloatArray) -> float:
        """Mean size of the elements at the point nearest to a place (3,), mm."""
        point = int(((self.history.points - place) ** 2).sum(axis=1).argmin())
        sheet = self.solutions.sheet
        meet = (sheet.side_of == self.places[point]).any(axis=1)
        return float(sheet.element_sizes[meet].mean())


def solve_levels(
    outline: PlaneOutline,
    material: Elastic,
    loads: PartLoads,
    fineness: float,
    accuracy: float,
    deadline: float = inf,
) -> tuple[PlaneLevel, list[FloatArray], float]:
    """Solve a sheet on finer and finer meshes; none is begun that is expected to end too late.

    Returns the last level, the load states that decide there (of positions that were found on the
    first mesh), and its numerical bar: a share of the peak, of the state that is known worst.
    """
    levels: list[PlaneLevel] = []
    sizes: PlaneSizes | None = None
    positions: tuple[int, int] | None = None
    while True:
        start = perf_counter()
        sheet = mesh_outline(outline, fineness=fineness, sizes=sizes)
        solutions = solve_plane_loads(sheet, outline.interfaces, material)
        levels.append(level_of(solutions, outline, loads))
        positions = positions or levels[-1].deciding()
        states = [level.states(positions) for level in levels]
        errors = [solutions.element_error(state) for state in states[-1]]
        bar = max(
            _bar(levels, [each[number] for each in states], error[2])
            for number, error in enumerate(errors)
        )
        factor = _refinement([error[:2] for error in errors], accuracy)
        finer = (factor**-2.0).sum()
        late = perf_counter() + (perf_counter() - start) * finer / len(factor) > deadline
        if len(levels) > 1 and (
            bar <= accuracy or len(levels) == _MOST_MESHES or finer > _MOST_ELEMENTS or late
        ):
            return levels[-1], states[-1], bar + _cut_off(levels[-2:], loads, positions[0])
        sizes = plane_sizes(sheet, sheet.element_sizes * factor)


def level_of(solutions: PlaneUnitSolutions, outline: PlaneOutline, loads: PartLoads) -> PlaneLevel:
    """Superpose the cycle on solved unit loads."""
    flat = not _tilts(solutions, loads)
    coefficients, added = solutions.coefficients(
        loads.wrenches, loads.accelerations, loads.reaches, loads.tilt_held_at, flat=flat
    )
    places = solutions.sheet.shown
    number, points, basis = _stress_at(solutions, outline.face, places, flat)
    history = StressHistory(number, points, basis, coefficients)
    places = places if flat else np.tile(places, 2)
    return PlaneLevel(solutions, history, places, added, outline.face, flat)


def _stress_at(
    solutions: PlaneUnitSolutions, face: float | None, places: IntArray, flat: bool
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Node numbers, points (n, 3) and basis (n, 6, n_basis) at places, and below if it bends."""
    sheet = solutions.sheet
    nodes, _ = sheet.sides
    half = _half_thickness(solutions)[places] if face is None else face
    stress = solutions.stress_basis(places, flat=flat)
    points = np.column_stack([sheet.mesh.nodes[nodes[places]], np.broadcast_to(half, len(places))])
    basis = np.zeros((len(places), 6, stress.shape[2]))
    basis[:, [0, 1, 3]] = stress
    number = nodes[places]
    if flat:
        return number, points, basis
    below = basis.copy()
    below[:, :, solutions.displacement.shape[1] :] *= -1
    return (
        np.tile(number, 2),
        np.concatenate([points, points * [1, 1, -1]]),
        np.concatenate([basis, below]),
    )


def truncation(level: PlaneLevel, loads: PartLoads, position: int) -> float:
    """What the bearing series misses of the peak at a position, as a share of it.

    Measured against half-cosine pressures as they are, on the same factor.
    """
    solutions, history = level.solutions, level.history
    missing, first = np.zeros(len(solutions.loads)), 0
    for unit in solutions.interfaces:
        columns = slice(first, first + len(unit.names))
        first = columns.stop
        if unit.interface.kind == "bore":
            force = loads.wrenches[unit.interface.name][position, :2]
            couple = history.coefficients[columns, position] * (np.array(unit.names) == "couple")
            series = history.coefficients[columns, position] - couple
            missing += direct_bore(solutions.model, unit.interface, force)
            missing -= unit.vectors @ series
    change = solutions.flat_stress(level.places, solutions.solve(missing[:, None]))[..., 0]
    stress = history.at(position)
    before = float(von_mises(stress).max())
    stress[:, [0, 1, 3]] += change
    return abs(float(von_mises(stress).max()) - before) / before if before else 0.0


def _cut_off(levels: Sequence[PlaneLevel], loads: PartLoads, position: int) -> float:
    """Truncation, and what its measure may still change by: where a pressure ends, order 1."""
    missing = [truncation(level, loads, position) for level in levels]
    stress = von_mises(levels[-1].history.at(position))
    place = levels[-1].history.points[int(stress.argmax())]
    left = discretisation_error(missing, [level.size_at(place) for level in levels], 1.0)
    return missing[-1] + left


def _tilts(solutions: PlaneUnitSolutions, loads: PartLoads) -> bool:
    """Whether the loads bend the sheet out of its plane."""
    size = float(np.ptp(solutions.sheet.mesh.nodes, axis=0).max())
    largest = max(
        float(np.abs(loads.wrenches[name][:, 3:5]).max(initial=0.0)) for name in loads.wrenches
    )
    return largest > _TILTS * size * loads.largest_force


def _half_thickness(solutions: PlaneUnitSolutions) -> FloatArray:
    """Half of the thickness at the sheet's places, mm."""
    sheet = solutions.sheet
    flat = sheet.side_of.ravel()
    total = np.bincount(flat, np.repeat(sheet.thickness, 6))
    return np.asarray(total / np.bincount(flat) / 2)


def _bar(levels: Sequence[PlaneLevel], states: Sequence[FloatArray], scatter: FloatArray) -> float:
    """Numerical error of the last level's peak over its value; states are the same on each."""
    last = levels[-1]
    peaks = [level.peak(state) for level, state in zip(levels, states, strict=True)]
    value, point = peaks[-1]
    if not value:
        return 0.0
    if len(levels) < 2:
        return float("inf")
    sizes = [level.size_at(last.history.points[point]) for level in levels]
    left = discretisation_error([peak[0] for peak in peaks], sizes)
    return ErrorBar(left, float(scatter[last.places[point]]), 0.0, value).mesh / value


def _refinement(errors: Sequence[tuple[FloatArray, FloatArray]], accuracy: float) -> FloatArray:
    """Factor on the elements' sizes that brings the peaks of all states to an accuracy."""
    factor = np.ones(len(errors[0][0]))
    for stress, error in errors:
        peak = float(stress.max())
        if not peak > 0:
            continue
        hot = stress >= _HOT * peak
        allowed = np.where(hot, _NEAR, _FAR) * accuracy * peak
        wanted = (allowed / np.maximum(error, 1e-12 * peak)) ** (1 / _ORDER)
        wanted = np.clip(wanted, 1 / _STEEPEST, np.where(hot, 1 / _STEP, 1.0))
        factor = np.minimum(factor, wanted)
    return np.asarray(factor)
