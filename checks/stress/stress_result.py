"""A part's stress over its cycles by any model, and what is judged of it.

Whatever made the stress, a formula, a beam, a plane model or a solid, it is the same history:
points x unit loads, and the coefficients of these over the positions.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

from checks.part.first_maximum import first_largest
from checks.part.part_loads import PartLoads
from checks.stress.duty_verdict import DutyVerdict, FatiguePeak, duty_runs, duty_verdict
from checks.stress.place_words import coordinates, place_words
from fem.stress_history import StressHistory
from geometry.mesh import FloatArray, Interface


@dataclass(frozen=True)
class Peak:
    """The largest von Mises stress over all cycles: MPa, point index, position index."""

    value: float
    point: int
    position: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Stressed(ABC):
    """A part's stress over all cycles of a design, its peak and its fatigue.

    limits             (n_points,) MPa, endurance limit at the points, fretting included
    history            of the stress at the points
    peaks_by_position  (n,) MPa, largest von Mises stress at each position
    duty               fatigue over the cycles of the duty, None without one
    """

    limits: FloatArray
    history: StressHistory
    peak: Peak
    peaks_by_position: FloatArray
    duty: DutyVerdict | None

    @property
    def coefficients(self) -> FloatArray:
        """Coefficients (n_basis, n) of the unit loads over all positions."""
        return self.history.coefficients

    @cached_property
    def fatigue(self) -> FatiguePeak | None:
        """The deciding peak of fatigue over the duty; None without a duty."""
        return None if self.duty is None else self.duty.peak

    @abstractmethod
    def named(self, point: int) -> str:
        """Name of the surface or section that a point is on."""

    @abstractmethod
    def depth(self, point: int) -> tuple[float, float] | None:
        """Least and largest |z| of that surface on the point's side, mm; None if not known."""

    def place(self, point: int) -> str:
        """Name of the surface that a point is on, and its x, y, z in mm, to tenths."""
        return f"{self.named(point)} {coordinates(self.history.points[point])}"

    def place_in_words(self, point: int, interfaces: Iterable[Interface]) -> str:
        """Where a point is on a part with these interfaces, in words, then x, y, z in mm."""
        at = self.history.points[point]
        words = place_words(self.named(point), at, self.depth(point), interfaces)
        return f"{words} {coordinates(at)}"


@dataclass(frozen=True, eq=False)
class Judgement:
    """Judgement of a part's stress history, as in `Stressed`."""

    peak: Peak
    peaks_by_position: FloatArray
    duty: DutyVerdict | None


def judge(
    history: StressHistory,
    limits: FloatArray,
    endurance_limit: float,
    ultimate_stress: float,
    loads: PartLoads,
    duty: Mapping[str, float],
) -> Judgement:
    """Find the peak of a history, and its fatigue over the cycles of a duty.

    limits           (n_points,) MPa, endurance limit at the points
    endurance_limit  MPa, away from fretting
    """
    by_position, where = history.peaks_by_position()
    (position,) = first_largest(by_position)
    peak = Peak(float(by_position[position]), int(where[position]), position)
    runs = duty_runs(loads.cycles, duty)
    verdict = duty_verdict(
        history.basis, history.coefficients, limits, endurance_limit, ultimate_stress, runs
    )
    return Judgement(peak, by_position, verdict)
