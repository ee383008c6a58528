"""A quantity of a part that is judged at its worst point, and its value under other pressures."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from checks.part.loaded_part import Loose
from checks.part.part_loads import PartLoads
from checks.part.pressed_along import Uneven
from checks.stress.solid_mesh_level import Level, peak_of
from checks.stress.stress_result import Stressed
from fem.recovery import von_mises
from fem.unit_solutions import direct_displacement, tilting_columns
from geometry.mesh import FloatArray, IntArray

# Stress (n, 6, m), MPa, of a level at a position under pressures other than its own, by m numbers.
Under = Callable[[PartLoads, Level, int, Sequence[float]], FloatArray]


class Judged(ABC):
    """A quantity of a part that is judged at its worst point.

    loads  on the part
    """

    loads: PartLoads

    @abstractmethod
    def value(self, level: Stressed) -> float:
        """The quantity on one mesh, MPa."""

    @abstractmethod
    def point(self, level: Stressed) -> int:
        """Index of the surface point that carries it."""

    @abstractmethod
    def at(self, level: Stressed, points: IntArray) -> FloatArray:
        """The quantity at some surface points (n,), MPa."""

    @abstractmethod
    def bound(self, level: Stressed, points: IntArray) -> FloatArray:
        """Not less than the quantity (n,) at some surface points over all positions, MPa."""

    def endured(self, level: Stressed, points: IntArray) -> FloatArray:
        """Amplitude (n,) that some surface points endure as often as the duty asks, MPa."""
        return level.judged_duty.limits[points]

    @abstractmethod
    def of_pressure(self, level: Stressed, points: IntArray, more: Loose) -> float:
        """The most that the pressure of a loose pin adds to the quantity at some points, MPa.

        With as much hoop stress as pressure, both of one sign.
        """

    @abstractmethod
    def anew(
        self,
        level: Stressed,
        points: IntArray,
        basis: FloatArray,
        coefficients: FloatArray,
        cycles: Mapping[str, slice] | None = None,
        states: FloatArray | None = None,
    ) -> float:
        """The quantity at some surface points (n,) with another history, MPa.

        basis         (n, 6, m) MPa per unit
        coefficients  (m, n_positions)
        cycles        name -> slice of the positions; None where they are those of the loads
        states        (n_basis, m) of the unit loads, whose displacement goes with each column of
                      the basis; None where it begins with the level's own, and others move nothing
        """

    @abstractmethod
    def deciding(self, level: Stressed) -> list[int]:
        """Positions that decide it."""

    @abstractmethod
    def deciding_at(self, level: Stressed, points: IntArray) -> list[int]:
        """Positions that decide it at some surface points."""

    @abstractmethod
    def scatter(self, level: Level, *, of_edges: bool = True) -> float:
        """Scatter of the elements that meet at the point, in the quantity, MPa.

        of_edges  as in `Level.scatter`
        """

    @abstractmethod
    def states(self, level: Stressed) -> list[FloatArray]:
        """Coefficients (n_basis,) of the load states whose stress it is made of."""

    @abstractmethod
    def direct(
        self,
        level: Level,
        numbers: Sequence[float],
        under: Under | None = None,
        positions: Sequence[int] = (),
    ) -> list[float]:
        """The quantity under other pressures, by `under` and its numbers.

        Without `under` the numbers are arcs, rad, of bearing pressures as they are, without a
        series (`direct_under`).

        positions  at which; without any those that decide it
        """


@dataclass(frozen=True, eq=False)
class StaticPeak(Judged):
    """The largest von Mises stress over all cycles."""

    loads: PartLoads

    def value(self, level: Stressed) -> float:
        """The quantity on one mesh, MPa."""
        return level.peak.value

    def point(self, level: Stressed) -> int:
        """Index of the surface point that carries it."""
        return level.peak.point

    def at(self, level: Stressed, points: IntArray) -> FloatArray:
        """Von Mises stress at some surface points (n,) at the position of the peak, MPa."""
        return von_mises(level.history.at(level.peak.position)[points])

    def bound(self, level: Stressed, points: IntArray) -> FloatArray:
        """Largest von Mises stress (n,) over all positions, MPa."""
        return level.history.peaks_by_point(points)

    def of_pressure(self, level: Stressed, points: IntArray, more: Loose) -> float:
        """The pressure itself, as von Mises stress is a norm."""
        return more.peak

    def anew(
        self,
        level: Stressed,
        points: IntArray,
        basis: FloatArray,
        coefficients: FloatArray,
        cycles: Mapping[str, slice] | None = None,
        states: FloatArray | None = None,
    ) -> float:
        """The peak at some surface points (n,) with another history, MPa."""
        return float(von_mises(np.moveaxis(basis @ coefficients, 1, -1)).max())

    def deciding(self, level: Stressed) -> list[int]:
        """Position of the peak."""
        return [level.peak.position]

    def deciding_at(self, level: Stressed, points: IntArray) -> list[int]:
        """Position of the peak of some surface points."""
        peaks, _ = level.history.at_points(points).peaks_by_position()
        return [int(peaks.argmax())]

    def states(self, level: Stressed) -> list[FloatArray]:
        """The load state of the peak."""
        return [level.coefficients[:, level.peak.position]]

    def scatter(self, level: Level, *, of_edges: bool = True) -> float:
        """Scatter of the elements that meet at the point, MPa."""
        return level.scatter(self.states(level)[0], level.peak.point, of_edges=of_edges)

    def direct(
        self,
        level: Level,
        numbers: Sequence[float],
        under: Under | None = None,
        positions: Sequence[int] = (),
    ) -> list[float]:
        """The peak at the same position under other pressures."""
        (position,) = positions or self.deciding(level)
        stress = (under or direct_under)(self.loads, level, position, numbers)
        return [peak_of(stress[:, :, k]) for k in range(len(numbers))]


def direct_under(
    loads: PartLoads, level: Level, position: int, arcs: Sequence[float]
) -> FloatArray:
    """Surface stress (n, 6, n_arcs) at a position under bearing pressures as they are, MPa.

    Arcs (rad) that are new are solved together, each once per level for positions with the same
    loads.
    """
    state = level.coefficients[:, position]
    known = level.direct_stresses.setdefault(state.tobytes(), {})
    missing = [arc for arc in arcs if arc not in known]
    if missing:
        wrenches = {name: wrench[position] for name, wrench in loads.wrenches.items()}
        solved = level.solved_bores
        moved = direct_displacement(
            level.solutions, wrenches, state, missing, solved,
            {bore: float(force[position]) for bore, force in level.lasting.items()},
        )  # fmt: skip
        found = level.stress_of(moved)
        if level.contact is not None:  # short waves move nothing
            short = level.contact.short_waves
            found = found + (level.history.basis[:, :, short] @ state[short])[:, :, None]
        known.update(zip(missing, np.moveaxis(found, -1, 0), strict=True))
    return np.stack([known[arc] for arc in arcs], axis=-1)


@dataclass(frozen=True, eq=False)
class RaisedInBores:
    """Stress in the bores with more of the forces' share than on the assumed arcs.

    Lugs were compared under forces in their plane: the stress of couples out of it stays, and so
    does the stress of bushes pressed in.

    more    share by which arcs that are not stated may have more
    uneven  bore -> how much more its bent pin presses at the most, and where
    some    surface points (n,) in bores that are asked, where not all are
    """

    more: float
    uneven: Mapping[str, Uneven]
    some: IntArray | None = None

    def points(self, level: Level) -> IntArray:
        """Surface points (n,) that are asked."""
        return level.in_bores if self.some is None else self.some

    def __call__(
        self, loads: PartLoads, level: Level, position: int, arcs: Sequence[float]
    ) -> FloatArray:
        """Stress (n, 6, n_arcs) in the bores, as `direct_under`, MPa."""
        points, solutions = self.points(level), level.solutions
        tilting = tilting_columns(solutions)
        staying = level.lasting_states[:, position].copy()
        staying[tilting] = level.coefficients[tilting, position]
        stays = level.history.basis[points] @ staying
        stress = direct_under(loads, level, position, arcs)[points]
        times = (1 + self.more) * self._bent(level)[:, None, None]
        return np.asarray(times * stress - (times - 1) * stays[:, :, None])

    def _bent(self, level: Level) -> FloatArray:
        """Times (n,) the even pressure at the points in the bores."""
        mesh, nodes = level.solutions.mesh, level.history.nodes[self.points(level)]
        found = np.ones(len(nodes))
        for unit in level.solutions.interfaces:
            one = self.uneven.get(unit.interface.name)
            most = one.most if one else 1.0
            for name in unit.interface.surfaces:
                of_bore = np.isin(nodes, mesh.surfaces[name])
                found[of_bore] = np.maximum(found[of_bore], most)
        return found
