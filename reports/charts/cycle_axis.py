"""The axis of a cycle: its positions in the order in which they are run through, phase by phase.

A linkage may pass the same place twice, and the phase that matters may be a thousandth of the way.
So each phase has a stretch of its own, as wide as its share of the positions, in which the shown
position runs from where the phase begins to where it ends, left to right.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from checks.result.words import brief, place_text
from reports.charts.chart import FloatArray, IntArray, numbers, thinned
from reports.svg import round_steps

_LEAST = 0.08  # of the width, that a phase has at least
_SLIP = 1e-9  # of the way, by which a position may go back by rounding
_GAP = 0.012  # of the width, between two phases
_ALIKE = 0.02  # of a scale: phases whose scales differ by less have the same
_APART = 0.062  # of the width, that two numbers on the axis need
_RIGHT_ANGLES = {"deg": (30.0, 45.0, 60.0, 90.0, 180.0, 360.0)}


@dataclass(frozen=True, eq=False)
class CycleAxis:
    """Where a cycle's positions are across a chart, as shares of its width.

    cycle    index of the cycle in the result
    across   (n,) share of the width
    runs     positions of each phase, in order
    phases   their names
    ticks    (share of the width, text)
    label    of the axis, with its unit
    values   (n,) what the ticks tell: shown position, time, or number of the position
    name, unit  of these
    """

    cycle: int
    across: FloatArray
    runs: tuple[IntArray, ...]
    phases: tuple[str, ...]
    ticks: tuple[tuple[float, str], ...]
    values: FloatArray
    name: str
    unit: str

    @property
    def label(self) -> str:
        """Name and unit."""
        return f"{self.name} [{self.unit}]"

    @property
    def scales_told(self) -> str:
        """That the phases have different scales, in a sentence; "" where they have one."""
        ways = [abs(float(self.values[run[-1]] - self.values[run[0]])) for run in self.runs]
        wide = [float(self.across[run[-1]] - self.across[run[0]]) for run in self.runs]
        per = [width / way for width, way in zip(wide, ways, strict=True) if way > 0]
        if len(self.runs) < 2 or (len(per) == len(ways) and max(per) < (1 + _ALIKE) * min(per)):
            return ""
        return f"Along {self.name} each phase has its own scale."

    def at(self, index: int) -> str:
        """A position in words."""
        unit = "" if self.unit == "–" else f" {self.unit}"
        return f"{self.name} = {self.value(index)}{unit}"

    def value(self, index: int) -> str:
        """Value of the axis at a position, to four digits."""
        return f"{round(float(self.values[index]), 9) + 0.0:.4g}".replace("-", "−")

    def track(self, width: float, start: float) -> dict[str, list[float]]:
        """Positions and where they are in a drawing whose axis is `width` wide from `start`."""
        kept = [run[thinned(self.across[run], 0.1 / width)] for run in self.runs]
        at = np.concatenate(kept) if kept else np.zeros(0, dtype=np.intp)
        places = start + width * self.across[at]
        return {"at": at.tolist(), "x": [round(float(x), 1) for x in places]}


def cycle_axis(index: int, cycle: Mapping[str, Any]) -> CycleAxis | None:
    """The axis of a cycle of a result; None for a cycle without positions."""
    position = numbers(cycle.get("position"))
    n = len(position)
    if not n:
        return None
    phases = [str(phase) for phase in cycle.get("phase") or [""] * n]
    found = [
        (name, np.array(list(run), dtype=np.intp))
        for name, run in groupby(range(n), key=lambda k: phases[k])
    ]
    runs = tuple(run for _, run in found)
    values, name, unit = _shown(cycle, position, runs)
    across = np.empty(n)
    start, ticks = 0.0, []
    for run, width in zip(runs, _widths(runs), strict=True):
        way = values[run[-1]] - values[run[0]]
        share = (values[run] - values[run[0]]) / way if way else np.full(len(run), 0.5)
        across[run] = start + width * share
        ticks.append(_ticks(values[run], unit, start, width))
        start += width + _GAP
    names = tuple(brief(phase, 40) for phase, _ in found)
    return CycleAxis(index, across, runs, names, _apart(ticks), values, name, unit)


def _shown(
    cycle: Mapping[str, Any], position: FloatArray, runs: tuple[IntArray, ...]
) -> tuple[FloatArray, str, str]:
    """Values of the axis: the shown position if it goes one way in each phase, else the time."""
    if all(_one_way(position[run]) for run in runs):
        name, unit = cycle.get("shown_name", "position"), cycle.get("unit", "–")
        return position, brief(name, 24), brief(unit, 8)
    time = numbers(cycle.get("time"))
    if len(time) == len(position) and all(_one_way(time[run]) for run in runs):
        return time, "time", "s"
    return np.arange(len(position), dtype=float), "number of the position", "–"


def _one_way(values: FloatArray) -> bool:
    steps = np.diff(values) * np.sign(values[-1] - values[0])
    if not np.isfinite(values).all():
        return False
    if len(values) == 1:
        return True
    way = abs(values[-1] - values[0])
    return bool(way > 0 and steps.min() >= -_SLIP * way)


def _widths(runs: tuple[IntArray, ...]) -> list[float]:
    shares = np.array([max(len(run) / sum(map(len, runs)), _LEAST) for run in runs])
    free = 1.0 - _GAP * (len(runs) - 1)
    return [float(width) for width in shares / shares.sum() * max(free, 0.1)]


def _ticks(values: FloatArray, unit: str, start: float, width: float) -> list[tuple[float, float]]:
    """(share of the width, value): both ends of a phase, then round values between them."""
    first, last = float(values[0]), float(values[-1])
    ends = [(start, first), (start + width, last)]
    if first == last:
        return [(start + width / 2, first)]
    low, high = min(first, last), max(first, last)
    between = [
        (start + width * (value - first) / (last - first), value)
        for value in _round_values(low, high, unit, max(1, int(width / 0.11)))
        if low < value < high
    ]
    return ends + between


def _round_values(low: float, high: float, unit: str, most: int) -> list[float]:
    for step in _RIGHT_ANGLES.get(unit, ()):
        if (high - low) / step <= most + 1 and high - low >= step:
            return [float(v) for v in np.arange(np.ceil(low / step), high / step + 1e-9) * step]
    return round_steps(low, high, most)


def _apart(phases: list[list[tuple[float, float]]]) -> tuple[tuple[float, str], ...]:
    """Ticks that have room: the ends of phases first, then what is between; equal ones once."""
    chosen: list[tuple[float, str]] = []
    ends = [tick for ticks in phases for tick in ticks[:2]]
    for share, value in ends + [tick for ticks in phases for tick in ticks[2:]]:
        text = place_text(value).replace("-", "−")
        need = _APART * max(1.0, len(text) / 4)
        near = [k for k, (other, _) in enumerate(chosen) if abs(other - share) < need]
        if not near:
            chosen.append((share, text))
        elif len(near) == 1 and chosen[near[0]][1] == text:
            other = chosen[near[0]][0]
            if abs(other - share) < 2 * _GAP:  # one number where a phase ends and the next begins
                chosen[near[0]] = ((other + share) / 2, text)
    return tuple(sorted(chosen))
