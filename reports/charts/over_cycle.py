"""Curves over the positions of a cycle, panel above panel, with what a moving cursor needs."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from checks.result.words import brief
from reports.charts.chart import SIZE, Series, stroke, swatch
from reports.charts.cycle_axis import CycleAxis
from reports.charts.labels import Room, cut, dense
from reports.charts.numbers import FloatArray, decimals_of, fixed, table_rows
from reports.charts.thin import gapless, thinned
from reports.svg import Marks, colour, draw, place

_LEFT, _RIGHT, _TOP, _BOTTOM, _PANEL, _BETWEEN = 44.0, 12.0, 18.0, 44.0, 122.0, 26.0  # points
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
    width, height = SIZE[0] * 72.0, _TOP + _BOTTOM + len(panels) * (_PANEL + _BETWEEN) - _BETWEEN
    strokes = _strokes(panels)

    def plot(figure: Any) -> Any:
        drawn = []
        for row, panel in enumerate(panels):
            top = _TOP + row * (_PANEL + _BETWEEN)
            bottom = 1.0 - (top + _PANEL) / height
            across = (width - _LEFT - _RIGHT) / width
            axes = figure.add_axes((_LEFT / width, bottom, across, _PANEL / height))
            last = row == len(panels) - 1
            _frame(axes, axis, panel, ticked=last)
            kept = _panel(axes, axis, panel, strokes[row], width - _LEFT - _RIGHT)
            drawn.append((axes, kept))
        return lambda: _marks(axis, panels, drawn, width)

    svg = draw(plot, (width / 72.0, height / 72.0), label, layout=None)
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


def _frame(axes: Any, axis: CycleAxis, panel: Panel, *, ticked: bool) -> None:
    axes.set_xlim(0, 1)
    axes.set_ylim(*panel.span)
    axes.margins(0)
    axes.locator_params(axis="y", nbins=5)
    axes.ticklabel_format(axis="y", useOffset=False, style="plain")
    axes.tick_params(length=0, pad=3)
    axes.tick_params(axis="x", pad=7)
    axes.grid(visible=False, axis="x")
    axes.text(
        -_LEFT / (SIZE[0] * 72 - _LEFT - _RIGHT), 1.0 + 6 / _PANEL,
        f"{panel.quantity} [{panel.unit}]", transform=axes.transAxes, va="bottom", weight="bold",
        size=_LABEL + 0.5,
    )  # fmt: skip
    for run in axis.runs[:-1]:
        edge = float(axis.across[run[-1]])
        after = float(axis.across[run[-1] + 1])
        axes.axvspan(edge, after, color=colour("faint"), alpha=0.55, linewidth=0)
    axes.set_xticks([share for share, _ in axis.ticks], [text for _, text in axis.ticks])
    if not ticked:
        axes.tick_params(labelbottom=False)
        return
    below = -30 / _PANEL
    if len(axis.runs) > 1:
        room = SIZE[0] * 72 - _LEFT - _RIGHT
        for run, name in zip(axis.runs, axis.phases, strict=True):
            first, last = float(axis.across[run[0]]), float(axis.across[run[-1]])
            letters = int((last - first) * room / 4.8)
            if letters >= 3:
                axes.text((first + last) / 2, below, brief(name, letters),
                          transform=axes.transAxes, ha="center", size=_LABEL,
                          style="italic")  # fmt: skip
        below = -42 / _PANEL
    axes.text(0.5, below, axis.label, transform=axes.transAxes, ha="center", size=_LABEL)


def _panel(
    axes: Any, axis: CycleAxis, panel: Panel, strokes: list[int], room: float
) -> list[list[np.ndarray[Any, Any]]]:
    """Draw the curves; returns the positions of each that were drawn, piece by piece."""
    low, high = panel.span
    scale = _PANEL / (high - low)
    space = Room(room, _PANEL)
    kept, own = [], []
    for curve in panel.curves:
        pieces = [
            piece[thinned(curve.values[piece], _TOLERANCE * (high - low), axis.across[piece])]
            for run in axis.runs
            for piece in gapless(curve.values, run)
        ]
        kept.append(pieces)
        first = len(space.lines)
        space.lines += [dense(_points(axis, curve, piece, room, low, scale)) for piece in pieces]
        own.append(range(first, len(space.lines)))
    _limits(axes, panel, space, low, high, scale)
    if low < 0:
        axes.axhline(0, color=colour("ink"), linewidth=0.8)
    for k, (curve, pieces) in enumerate(zip(panel.curves, kept, strict=True)):
        style = stroke(strokes[k])
        for piece in pieces:
            axes.plot(axis.across[piece], curve.values[piece], **style,
                      marker="." if len(piece) == 1 else "")  # fmt: skip
    for bar in panel.bars:
        value = float(panel.curves[bar.curve].values[bar.index])
        axes.errorbar(axis.across[bar.index], value, [[bar.below], [bar.above]],
                      color=colour("ink"), capsize=3.5, linewidth=1.2)  # fmt: skip
    order = sorted(range(len(kept)), key=lambda k: -_size(panel.curves[k].values))
    for k in order:
        _name(axes, axis, panel.curves[k], kept[k], space, own[k], strokes[k], low, scale)
    return kept


def _size(values: FloatArray) -> float:
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def _points(
    axis: CycleAxis, curve: Curve, piece: Any, room: float, low: float, scale: float
) -> FloatArray:
    return np.stack([axis.across[piece] * room, (curve.values[piece] - low) * scale], axis=1)


def _limits(axes: Any, panel: Panel, space: Room, low: float, high: float, scale: float) -> None:
    for limit in panel.limits:
        if limit.value > high:
            continue
        level = (limit.value - low) * scale
        line = np.array([[0.0, level], [space.width, level]])
        axes.axhline(limit.value, color=colour("fail"), linewidth=1.5)
        at = space.put(limit.text, line, _LABEL, prefer=0.02)
        space.lines.append(dense(line))
        if at:
            axes.text(at[0] / space.width, low + at[1] / scale, limit.text, color=colour("fail"),
                      ha="center", va="center", size=_LABEL)  # fmt: skip


def _name(
    axes: Any, axis: CycleAxis, curve: Curve, pieces: Any, space: Room, own: range, index: int,
    low: float, scale: float,
) -> None:  # fmt: skip
    text = brief(curve.short or curve.name, 26)
    longest = max(pieces, key=lambda p: (_size(curve.values[p]), len(p)), default=None)
    if longest is None:
        return
    line = _points(axis, curve, longest, space.width, low, scale)
    inside = cut(line, space.width, _PANEL)
    at = space.put(text, inside[0], _LABEL, prefer=0.4, pull=0.8, own=own) if inside else None
    if at:
        axes.text(at[0] / space.width, low + at[1] / scale, text, ha="center", va="center",
                  size=_LABEL, color=stroke(index)["color"], weight="bold")  # fmt: skip


def _marks(
    axis: CycleAxis, panels: Sequence[Panel], drawn: list[tuple[Any, Any]], width: float
) -> Marks:
    """Data for the cursor: where positions are, each curve's values, where these are."""
    rows = []
    for panel, (axes, kept) in zip(panels, drawn, strict=True):
        low, high = panel.span
        bottom, top = place(axes, 0, low)[1], place(axes, 0, high)[1]
        for curve, pieces in zip(panel.curves, kept, strict=True):
            at, values = _followed(curve.values, pieces)
            scale = [_short(v) for v in (low, bottom, high, top)]
            rows.append({"cycle": axis.cycle, "at": at, "value": values, "scale": scale})
    top = place(drawn[0][0], 0, panels[0].span[1])[1]
    bottom = place(drawn[-1][0], 0, panels[-1].span[0])[1]
    track = {"cycle": axis.cycle, **axis.track(width - _LEFT - _RIGHT, _LEFT)}
    data = {"line": track, "from": _short(top), "to": _short(bottom), "rows": rows}
    return {"": {"data-cycle": str(axis.cycle), "data-cursor": cursor_text(data)}}


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
