"""A part's stress over its cycles by any model, and what is judged of it.

Whatever made the stress, a formula or a solid, it is the same history:
points x unit loads, and the coefficients of these over the positions.

Stress of a part over the cycle by a rung below the solid, in the same history as a solid's.

A rung's points are the places where such a part can be stressed most: bores all round, fibres of
its sections, fillets. Its basis need not be one of unit loads of an elastic body: coefficients may
be any function of the link loads, as long as basis times coefficients is the stress.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import acos, degrees, hypot
from typing import TypedDict

import numpy as np

from checks.part.part_loads import PartLoads, first_largest
from checks.result.derivation import Item
from checks.stress.duty_verdict import DutyVerdict, FatiguePeak, duty_runs, duty_verdict
from fem.stress_history import StressHistory
from geometry.mesh import FloatArray, Interface

# Of a unit load: its name with where it acts, and the unit of its coefficient.
UnitName = tuple[str, str]
_AT_END = 0.02  # of a surface's depth: how near its end counts as its edge
_NEAR = 0.005  # of the way between two interfaces: a place as near as that is at one
_ALONG = 30.0  # deg from a line, within which a side of a bore faces along it
_OUTER_EDGE = " edge"  # ends the name of a lug's outer edge by the rung `formula`
_ON_THE_PIN = " on the pin"  # ends the name of a seat by the rung `formula`


@dataclass(frozen=True)
class ElasticLoad:
    """The largest share that a position's load is of the part's elastic buckling load.

    share     0 where nothing presses or bends; 1 is buckling
    position  at which it is largest
    words     how it buckles, and by which formula
    explain   the items of a derivation of the share, whose symbol is `share`, made when asked for
    unproved  why no formula gives the share, in words; "" for one that is a formula's
    pulled    True if no position presses the part, or hardly: the share is without what pulls
    fixity    what forks that hold its ends against tilting out of the plane may take of the share,
              over the share; 0 where it buckles otherwise
    plane     "in plane" where it buckles as a column in the linkage's plane, "" otherwise
    span      mm, between that column's ends
    weakest   the share if the weakest section stood all along; None where only solids compared tell
              how far a solid's may be from the share
    local     times the largest stress that walls and what is beside bores may count as having
    mode      displacements (n, 3), of free size, of nodes (n, 3) mm in the part's frame as it
              buckles; None where the model has a load alone
    """

    share: float
    position: int
    words: str
    explain: Callable[[], Sequence[Item]] = field(compare=False, repr=False)
    unproved: str = ""
    pulled: bool = False
    fixity: float = 0.0
    plane: str = ""
    span: float = 0.0
    weakest: float | None = None
    local: float = 1.0
    mode: Callable[[FloatArray], FloatArray] | None = field(default=None, compare=False, repr=False)


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

    @property
    def judged_duty(self) -> DutyVerdict:
        """Fatigue over the cycles of the duty, of a part that has one."""
        assert self.duty is not None
        return self.duty

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


def no_answer() -> None:
    """The elastic buckling load of a part for which the rung has none."""


@dataclass(frozen=True, eq=False, kw_only=True)
class RungModel:
    """A part's stress by the rung `formula`, before it is judged.

    history     of the stress at the rung's points; their places in the part's frame, mm
    places      (n_points,) what stands at each point, such as "bore knee" or "tube, mid-length"
    fretting    (n_points,) factor by which fretting lowers the endurance limit, 1 elsewhere
    residual    what is left of the part's balance, or did not reach it, over the largest force
    deflection  mm, largest displacement over the cycles, estimated; infinite if unknown
    buckles     largest share of the elastic buckling load, asked for once it is needed; None where
                the rung has no answer
    neglects    what the rung leaves out, in words
    ring        number of points at even angles around each section of a pin, section by section; 0
                where the points lie otherwise
    units       (n_basis,) names of what the history's coefficients are sizes of
    """

    history: StressHistory
    places: Sequence[str]
    fretting: FloatArray
    residual: float
    deflection: float
    neglects: str
    ring: int = 0
    units: Sequence[UnitName]
    buckles: Callable[[], ElasticLoad | None] = no_answer

    def __post_init__(self) -> None:
        if len(self.units) != len(self.history.coefficients):
            raise ValueError(
                f"the formula has {len(self.history.coefficients)} unit loads, "
                f"but {len(self.units)} names"
            )

    @cached_property
    def buckling(self) -> ElasticLoad | None:
        """Largest share of the elastic buckling load, None where the rung has no answer."""
        return self.buckles()


@dataclass(frozen=True, eq=False, kw_only=True)
class RungLevel(Stressed):
    """A rung's stress, judged."""

    model: RungModel = field()

    def named(self, point: int) -> str:
        """Name of the place at a point."""
        return self.model.places[point]

    def depth(self, point: int) -> tuple[float, float] | None:
        """None: a rung's points are on lines, not on surfaces."""
        return None


class Judgement(TypedDict):
    """A part's stress history with its judgement: the fields of `Stressed`."""

    limits: FloatArray
    history: StressHistory
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
    return Judgement(
        limits=limits, history=history, peak=peak, peaks_by_position=by_position, duty=verdict
    )


# Where a point of a part is, as an engineer says it: "knee bore, edge at the outer face".


def place_words(
    name: str, at: FloatArray, depth: tuple[float, float] | None, interfaces: Iterable[Interface]
) -> str:
    """Where a point of a part is, in words.

    name        of the surface or section that it is on; of several that meet there, "one/two"
    at          (3,) mm, in the part's own axes
    depth       least and largest |z| of that surface on the point's side, mm; None if not known
    interfaces  of the part: bores, seats, faces
    """
    by_name = {one.name: one for one in interfaces}
    seats = [one.removesuffix(_ON_THE_PIN) for one in name.split("/")]
    own = next((by_name[seat] for seat in seats if seat in by_name), None)
    end = _end(depth, abs(float(at[2])))
    others = [one for one in by_name.values() if one is not own and one.kind != "slide"]
    if own is not None and own.kind == "journal":
        return f"seat of {own.name}{', at its edge' if end else ''}"
    if own is not None and own.kind == "bore":
        edge = [f"edge at the {end}"] if end else []
        return ", ".join([f"{own.name} bore", *edge, *_side(own, at, others)])
    if (bore := name.removesuffix(_OUTER_EDGE)) in by_name:
        return f"outer edge beside the {bore} bore"
    return ", ".join([name, *_between(at, others)])


def coordinates(at: FloatArray) -> str:
    """A place (3,), mm, to tenths."""
    x, y, z = (f"{round(float(value), 1) + 0.0:.1f}" for value in at)
    return f"({x}, {y}, {z})"


def _end(depth: tuple[float, float] | None, height: float) -> str:
    """Which end of a surface's depth a height over the middle plane is at; "" between, or unknown.

    A surface through the middle plane has a depth from 0 on.
    """
    if depth is None:
        return ""
    low, high = depth
    near = _AT_END * (high - low)
    if height >= high - near:
        return "outer face" if low > near else "face"
    return "inner face" if low > near and height <= low + near else ""


def _side(own: Interface, at: FloatArray, others: list[Interface]) -> list[str]:
    """The side of a bore, by the line from its middle to the farthest other interface."""
    lines = [(other.centre - own.centre)[:2] for other in others]
    arm = (at - own.centre)[:2]
    k = max(range(len(lines)), key=lambda k: hypot(*lines[k]), default=-1)
    if k < 0 or not hypot(*lines[k]) * hypot(*arm):
        return []
    cosine = float(arm @ lines[k]) / (hypot(*arm) * hypot(*lines[k]))
    angle = degrees(acos(min(1.0, max(-1.0, cosine))))
    if angle <= _ALONG:
        return [f"towards {others[k].name}"]
    if angle >= 180.0 - _ALONG:
        return [f"away from {others[k].name}"]
    return [f"{angle:.0f} deg from the line to {others[k].name}"]


def _between(at: FloatArray, others: list[Interface]) -> list[str]:
    """How far along the line from the first interface to the second; [] outside of it."""
    if len(others) < 2:
        return []
    first, second = others[:2]
    line = second.centre - first.centre
    length = float(line @ line)
    share = float((at - first.centre) @ line) / length if length else -1.0
    if not _NEAR <= share <= 1.0 - _NEAR:
        return []
    return [f"{100 * share:.0f} % of the way from {first.name} to {second.name}"]


def depth_of(z: FloatArray, at: float) -> tuple[float, float]:
    """Lowest and highest distance (n,) from the middle plane, of what is on the side of `at`."""
    side = np.abs(z[z >= 0] if at >= 0 else z[z <= 0])
    return float(side.min()), float(side.max())
