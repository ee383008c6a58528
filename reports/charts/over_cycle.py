"""Curves over the positions of a cycle, panel above panel, with what a moving cursor needs.

Positions stand in the order in which they are run through, phase by phase: a linkage may pass the
same place twice, and the phase that matters may be a thousandth of the way. So each phase has a
stretch of its own, as wide as its share of the positions, in which the shown position runs from
where the phase begins to where it ends, left to right.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from checks.result.words import brief, place_text
from geometry.mesh import FloatArray
from reports.charts.chart import (
    SIZE,
    IntArray,
    Room,
    Series,
    cut,
    decimals_of,
    dense,
    fixed,
    gapless,
    numbers,
    stroke,
    swatch,
    table_rows,
    thinned,
)
from reports.svg import INK, Drawing, Frame, colour, draw, round_steps

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


_LEFT, _RIGHT, _TOP, _BOTTOM, _PANEL, _BETWEEN = 44.0, 12.0, 18.0, 44.0, 122.0, 26.0  # points
_WIDE = SIZE[0] - _LEFT - _RIGHT
_TOLERANCE = 1e-3  # of a panel's height: what a thinned curve may miss
_LABEL = 9.0  # points


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve (n,) over the positions, which may have gaps.

    short  what stands beside it, "" for its name
    like   number of its stroke, -1 for the next one
    """

    name: str
    values: FloatArray
    short: str = ""
    like: int = -1


@dataclass(frozen=True)
class Limit:
    """A level that must not be exceeded, and its name."""

    value: float
    text: str


@dataclass(frozen=True)
class Bar:
    """Error bar of a curve's value at a position; `curve` is its number in the panel."""

    curve: int
    index: int
    below: float
    above: float


@dataclass(frozen=True, eq=False)
class Panel:
    """Curves of one quantity and unit."""

    quantity: str
    unit: str
    curves: Sequence[Curve]
    limits: Sequence[Limit] = ()
    bars: Sequence[Bar] = ()

    @property
    def span(self) -> tuple[float, float]:
        """Lower and upper end of the axis: 0, all curves and bars, limits that are not far away."""
        found = [v for c in self.curves for v in c.values[np.isfinite(c.values)].tolist()]
        for bar in self.bars:
            value = float(self.curves[bar.curve].values[bar.index])
            found += [value - bar.below, value + bar.above]
        low, high = min([0.0, *found]), max([0.0, *found])
        size = max(high, -low)
        near = [limit.value for limit in self.limits if limit.value <= 3.0 * size]
        high = max([high, *near])
        room = 0.06 * (high - low) or 1.0
        return (low - room if low < 0 else 0.0), (high + 2.2 * room if high > 0 else room)


def over_cycle(label: str, axis: CycleAxis, panels: Sequence[Panel]) -> tuple[str, list[Series]]:
    """The picture, and a row of the readout for every curve.

    Raises ValueError for panels without a curve.
    """
    if not panels or not all(panel.curves for panel in panels):
        raise ValueError("a chart over a cycle needs curves in every panel")
    height = _TOP + _BOTTOM + len(panels) * (_PANEL + _BETWEEN) - _BETWEEN
    strokes = _strokes(panels)

    def plot(figure: Drawing) -> dict[str, str]:
        drawn = []
        for row, panel in enumerate(panels):
            top = _TOP + row * (_PANEL + _BETWEEN)
            axes = figure.frame((_LEFT, top, _WIDE, _PANEL), (0.0, 1.0), panel.span, grid="y")
            figure.text(0.0, top - 8, f"{panel.quantity} [{panel.unit}]", size=_LABEL + 0.5,
                        anchor="start", weight="bold")  # fmt: skip
            last = row == len(panels) - 1
            _stretches(axes, axis, ticked=last)
            drawn.append((axes, _panel(axes, axis, panel, strokes[row])))
        _below(figure, axis, height - _BOTTOM)
        return _marks(axis, panels, drawn)

    svg = draw(plot, (SIZE[0], height), label)
    return svg, [
        _series(axis, panel, curve, strokes[row][k])
        for row, panel in enumerate(panels)
        for k, curve in enumerate(panel.curves)
    ]


def _strokes(panels: Sequence[Panel]) -> list[list[int]]:
    """The number of every curve's stroke."""
    count, found = 0, []
    for panel in panels:
        own = []
        for curve in panel.curves:
            own.append(count if curve.like < 0 else curve.like)
            count += curve.like < 0
        found.append(own)
    return found


def _stretches(axes: Frame, axis: CycleAxis, *, ticked: bool) -> None:
    """Bands where one phase ends and the next begins, and numbers if they are wanted."""
    for run in axis.runs[:-1]:
        ends = (float(axis.across[run[-1]]), float(axis.across[run[-1] + 1]))
        axes.area(ends, axes.up, colour("faint"), 0.55)
    axes.x_ticks = axis.ticks if ticked else ()


def _below(figure: Drawing, axis: CycleAxis, bottom: float) -> None:
    """Names of the phases and of the axis."""
    if len(axis.runs) > 1:
        for run, name in zip(axis.runs, axis.phases, strict=True):
            first, last = float(axis.across[run[0]]), float(axis.across[run[-1]])
            letters = int((last - first) * _WIDE / 4.8)
            if letters >= 3:
                figure.text(_LEFT + _WIDE * (first + last) / 2, bottom + 30, brief(name, letters),
                            size=_LABEL, slant="italic")  # fmt: skip
    under = 42 if len(axis.runs) > 1 else 30
    figure.text(_LEFT + _WIDE / 2, bottom + under, axis.label, size=_LABEL)


def _panel(
    axes: Frame, axis: CycleAxis, panel: Panel, strokes: list[int]
) -> list[list[np.ndarray[Any, Any]]]:
    """Draw the curves; returns the positions of each that were drawn, piece by piece."""
    low, high = panel.span
    scale = _PANEL / (high - low)
    space = Room(_WIDE, _PANEL)
    kept, own = [], []
    for curve in panel.curves:
        pieces = [
            piece[thinned(curve.values[piece], _TOLERANCE * (high - low), axis.across[piece])]
            for run in axis.runs
            for piece in gapless(curve.values, run)
        ]
        kept.append(pieces)
        first = len(space.lines)
        space.lines += [dense(_points(axis, curve, piece, low, scale)) for piece in pieces]
        own.append(range(first, len(space.lines)))
    _limits(axes, panel, space, low, high, scale)
    if low < 0:
        axes.line([[0.0, 0.0], [1.0, 0.0]], color=INK, linewidth=0.8)
    for k, (curve, pieces) in enumerate(zip(panel.curves, kept, strict=True)):
        style = stroke(strokes[k])
        for piece in pieces:
            axes.line(np.stack([axis.across[piece], curve.values[piece]], axis=1), **style,
                      marker="." if len(piece) == 1 else "")  # fmt: skip
    for bar in panel.bars:
        at, value = axis.across[bar.index], float(panel.curves[bar.curve].values[bar.index])
        axes.line([[at, value - bar.below], [at, value + bar.above]], color=INK, linewidth=1.2,
                  marker="_", markersize=7.0)  # fmt: skip
    order = sorted(range(len(kept)), key=lambda k: -_size(panel.curves[k].values))
    for k in order:
        _name(axes, axis, panel.curves[k], kept[k], space, own[k], strokes[k], low, scale)
    return kept


def _size(values: FloatArray) -> float:
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def _points(axis: CycleAxis, curve: Curve, piece: Any, low: float, scale: float) -> FloatArray:
    return np.stack([axis.across[piece] * _WIDE, (curve.values[piece] - low) * scale], axis=1)


def _limits(axes: Frame, panel: Panel, space: Room, low: float, high: float, scale: float) -> None:
    for limit in panel.limits:
        if limit.value > high:
            continue
        level = (limit.value - low) * scale
        line = np.array([[0.0, level], [space.width, level]])
        axes.line([[0.0, limit.value], [1.0, limit.value]], color=colour("fail"), linewidth=1.5)
        at = space.put(limit.text, line, _LABEL, prefer=0.02)
        space.lines.append(dense(line))
        if at:
            _write(axes, limit.text, at, color=colour("fail"))


def _name(
    axes: Frame, axis: CycleAxis, curve: Curve, pieces: Any, space: Room, own: range, index: int,
    low: float, scale: float,
) -> None:  # fmt: skip
    text = brief(curve.short or curve.name, 26)
    longest = max(pieces, key=lambda p: (_size(curve.values[p]), len(p)), default=None)
    if longest is None:
        return
    line = _points(axis, curve, longest, low, scale)
    inside = cut(line, space.width, _PANEL)
    at = space.put(text, inside[0], _LABEL, prefer=0.4, pull=0.8, own=own) if inside else None
    if at:
        _write(axes, text, at, color=stroke(index)["color"], weight="bold")


def _write(axes: Frame, text: str, at: tuple[float, float], **style: Any) -> None:
    """Write a text centred at a place from the lower left corner of the frame."""
    left, top, _, height = axes.box
    axes.text(left + at[0], top + height - at[1], text, size=_LABEL, **style)


def _marks(
    axis: CycleAxis, panels: Sequence[Panel], drawn: list[tuple[Frame, Any]]
) -> dict[str, str]:
    """Data for the cursor: where positions are, each curve's values, where these are."""
    rows = []
    for panel, (axes, kept) in zip(panels, drawn, strict=True):
        low, high = panel.span
        _, top, _, height = axes.box
        for curve, pieces in zip(panel.curves, kept, strict=True):
            at, values = _followed(curve.values, pieces)
            scale = [_short(v) for v in (low, top + height, high, top)]
            rows.append({"cycle": axis.cycle, "at": at, "value": values, "scale": scale})
    top, last = drawn[0][0].box[1], drawn[-1][0].box
    bottom = last[1] + last[3]
    track = {"cycle": axis.cycle, **axis.track(_WIDE, _LEFT)}
    data = {"line": track, "from": _short(top), "to": _short(bottom), "rows": rows}
    return {"data-cycle": str(axis.cycle), "data-cursor": cursor_text(data)}


def cursor_text(data: Mapping[str, Any]) -> str:
    """Data for the cursor as text of an attribute."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False)


def _followed(values: FloatArray, pieces: Sequence[Any]) -> tuple[list[int], list[float | None]]:
    """Positions of a thinned curve and its values there, with None on both sides of a gap."""
    places = decimals_of(_size(values)) + 1
    at: list[int] = []
    told: list[float | None] = []
    for piece in pieces:
        first = int(piece[0])
        if at and first > at[-1] + 1:
            edges = sorted({at[-1] + 1, first - 1})
            at += edges
            told += [None] * len(edges)
        at += [int(k) for k in piece]
        told += [round(float(values[k]), places) + 0.0 for k in piece]
    return at, told


def _short(value: float) -> float:
    return float(f"{value:.6g}")


def _series(axis: CycleAxis, panel: Panel, curve: Curve, index: int) -> Series:
    size = _size(curve.values)
    places = decimals_of(size)
    known = np.flatnonzero(np.isfinite(curve.values))
    peak = ""
    if len(known):
        sizes = np.abs(curve.values[known])
        k = int(known[(sizes >= size * (1 - 1e-9)).argmax()])
        peak = f"{fixed(float(curve.values[k]), places)} {panel.unit}"
        level = len(known) == len(curve.values) and np.ptp(curve.values) <= 1e-6 * size
        peak += " throughout" if level else f" at {axis.at(k)}"
    return Series(curve.name, panel.unit, peak, swatch(index), places)


def cycle_table(axis: CycleAxis, panels: Sequence[Panel]) -> tuple[list[str], list[list[str]]]:
    """The table behind a chart over a cycle; each curve's extremes are marked in it."""
    curves = [(panel, curve) for panel in panels for curve in panel.curves]
    columns = [axis.label] + ["phase"] * (len(axis.runs) > 1)
    columns += [f"{brief(curve.name, 60)} [{panel.unit}]" for panel, curve in curves]
    phase = {int(k): name for run, name in zip(axis.runs, axis.phases, strict=True) for k in run}
    ends = [_extremes(curve.values) for _, curve in curves]
    rows = []
    for k in table_rows([curve.values for _, curve in curves], axis.runs):
        cells = [axis.value(k)]
        cells += [phase[k]] * (len(axis.runs) > 1)
        for (_, curve), (lowest, highest) in zip(curves, ends, strict=True):
            mark = " ▲" if k == highest else " ▼" if k == lowest else ""
            cells.append(fixed(float(curve.values[k]), decimals_of(_size(curve.values)) + 1) + mark)
        rows.append(cells)
    return columns, rows


def _extremes(values: FloatArray) -> tuple[int, int]:
    """Positions of the least and the largest value; -1 for a curve that does not change."""
    known = np.flatnonzero(np.isfinite(values))
    if not len(known) or np.ptp(values[known]) == 0:
        return -1, -1
    return int(known[values[known].argmin()]), int(known[values[known].argmax()])
