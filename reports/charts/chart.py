"""A chart as the page takes it: a picture, what it says in words, and the table behind it.

Its axes know where their points are on paper, so that names find room beside them. Names are
written where there is room, each nearest to its own curve.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import floor, isfinite, log10
from typing import Any

import numpy as np
import numpy.typing as npt

from geometry.mesh import FloatArray
from reports.svg import INK, SERIES, Drawing, draw

_DIGITS = 3  # that a curve's largest value is read off with
_ROWS = 13  # even places of a cycle that its table has
_LETTER, _HEIGHT = 0.56, 1.15  # of the font's size
_TRIES = 41  # places along a curve
_ALONE = 24.0  # points: a place on a curve that no other comes nearer to is as good as any
_OFFSETS = (0.75, -0.75, 1.5, -1.5, 2.6, -2.6)  # heights above and below the curve
_BESIDE = (0.0, 0.6, -0.6, 1.2, -1.2)  # heights, to the right and left of a single point
_STEP = 3.0  # points between those of a dense line
_FAR, _OVER, _NAMED = 0.35, 3.0, 60.0  # cost of distance, of crossing a curve, of covering a name


def numbers(values: Any) -> FloatArray:
    """Numbers (n,) with a gap where there is none; empty for None."""
    if values is None:
        return np.zeros(0)
    plain = np.asarray(values, dtype=object).ravel().tolist()
    return np.array([np.nan if value is None else value for value in plain], dtype=float)


def largest(curves: Mapping[str, FloatArray]) -> float:
    """The largest magnitude of some curves, 0 without any number."""
    found = [float(np.abs(v[np.isfinite(v)]).max(initial=0.0)) for v in curves.values()]
    return max(found, default=0.0)


def decimals_of(size: float) -> int:
    """Decimals that show a number of this size with three digits, at most six.

    >>> [decimals_of(size) for size in (207.2, 61.1, 0.0254, 0.0)]
    [0, 1, 4, 1]
    """
    if not (size > 0 and isfinite(size)):
        return 1
    return min(6, max(0, _DIGITS - 1 - floor(log10(size))))


def fixed(value: float, decimals: int) -> str:
    """A number with so many decimals, a true minus, and a dash for a gap."""
    if not isfinite(value):
        return "–"
    return f"{round(value, decimals) + 0.0:.{decimals}f}".replace("-", "−")


def table_rows(curves: Sequence[FloatArray], runs: Sequence[npt.NDArray[np.intp]]) -> list[int]:
    """Which positions a table shows: even ones, ends of phases, and every curve's extremes."""
    n = sum(len(run) for run in runs)
    if not n:
        return []
    chosen = set(np.linspace(0, n - 1, min(n, _ROWS)).round().astype(int).tolist())
    chosen |= {int(run[end]) for run in runs for end in (0, -1)}
    for values in curves:
        known = np.flatnonzero(np.isfinite(values))
        if len(known):
            chosen |= {int(known[values[known].argmax()]), int(known[values[known].argmin()])}
    return sorted(chosen)


def power_unit(size: float) -> tuple[str, float]:
    """Unit in which a power [N mm/s] of this size is read well, and the factor to it.

    >>> power_unit(2e6), power_unit(4e7)
    (('W', 0.001), ('kW', 1e-06))
    """
    return ("kW", 1e-6) if size >= 1e7 else ("W", 1e-3)


def work_text(work: float) -> str:
    """A work [N mm] in J or kJ, with its sign."""
    joule = work * 1e-3
    unit, value = ("kJ", joule * 1e-3) if abs(joule) >= 1e4 else ("J", joule)
    return f"{fixed(value, decimals_of(abs(value)))} {unit}"


SIZE = (460.8, 223.2)  # points of a chart: text of 10 points stays readable on a phone
_DASHES = ("-", (0, (6, 2)), (0, (1.5, 1.5)), (0, (7, 2, 1.5, 2)), (0, (3, 1.5)), (0, (10, 3)))


@dataclass(frozen=True)
class Series:
    """A row of a chart's readout.

    name      of the curve or number
    unit      "" for a number without one
    peak      its extreme and where, in words; "" of what has none
    swatch    SVG of its stroke, "" of a number that is no curve
    decimals  of its value as it is read off
    """

    name: str
    unit: str
    peak: str = ""
    swatch: str = ""
    decimals: int = 1


@dataclass(frozen=True)
class Chart:
    """A picture with its words and numbers; `svg` and the swatches are markup, all else is text.

    key      which chart it is, such as "haigh"
    columns  of the table behind the picture; rows as long as they are
    series   rows of the readout under the picture
    """

    key: str
    title: str
    caption: str
    svg: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    series: Sequence[Series] = ()

    def __post_init__(self) -> None:
        if any(len(row) != len(self.columns) for row in self.rows):
            raise ValueError(f"the table of {self.key} needs {len(self.columns)} cells in each row")


@dataclass(frozen=True)
class Missing:
    """A chart that there is no data for, and why."""

    key: str
    title: str
    why: str


@dataclass(frozen=True)
class Charts:
    """The charts of a part or cycle, and what is missing."""

    charts: tuple[Chart, ...]
    missing: tuple[Missing, ...]

    def __bool__(self) -> bool:
        return bool(self.charts)

    @property
    def reasons(self) -> list[tuple[str, list[str]]]:
        """Why charts are missing, each reason once, with the titles that it holds for."""
        found: dict[str, list[str]] = {}
        for item in self.missing:
            found.setdefault(item.why, []).append(item.title)
        return list(found.items())


def gathered(made: Sequence[Chart | Missing]) -> Charts:
    """Return the charts, and the missing ones."""
    return Charts(
        tuple(item for item in made if isinstance(item, Chart)),
        tuple(item for item in made if isinstance(item, Missing)),
    )


def stroke(index: int) -> dict[str, Any]:
    """Colour and dashes of a series, told apart without colour too."""
    return {
        "color": SERIES[index % len(SERIES)],
        "linestyle": _DASHES[index % len(_DASHES)],
        "linewidth": 1.7,
    }


def swatch(index: int) -> str:
    """A piece of a series' stroke as SVG."""
    tint, dashes = SERIES[index % len(SERIES)], _DASHES[index % len(_DASHES)]
    gaps = ""
    if dashes != "-":
        gaps = f";stroke-dasharray:{' '.join(f'{1.7 * float(d):g}' for d in dashes[1])}"
    return (
        '<svg class="swatch" viewBox="0 0 34 8" width="34" height="8" aria-hidden="true">'
        f'<path d="M1 4H33" style="stroke:{tint};stroke-width:2.4{gaps}"/></svg>'
    )


def plain(named: Mapping[str, Any] | None) -> dict[str, Any]:
    """A mapping that may be missing."""
    return dict(named or {})


# Curves with fewer points, none of which is missed by more than a stated amount.

IntArray = npt.NDArray[np.intp]


def thinned(values: FloatArray, tolerance: float, across: FloatArray | None = None) -> IntArray:
    """Which points of a curve (n,) to keep, so that straight lines between them hold it.

    Its ends and its extremes are kept as they are; every other value lies within the tolerance of
    the line, whether that is drawn over the index or over `across` (n,), which rises.
    """
    n = len(values)
    if n < 3:
        return np.arange(n)
    axes = [np.arange(n, dtype=float)] + ([] if across is None else [across])
    kept = sorted({0, n - 1, int(values.argmax()), int(values.argmin())})
    found = set(kept)
    waiting = list(pairwise(kept))
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        inside = slice(first + 1, last)
        missed = np.zeros(last - first - 1)
        for axis in axes:
            line = _line(axis, values, first, last)
            missed = np.maximum(missed, np.abs(line - values[inside]))
        worst = int(missed.argmax())
        if missed[worst] > tolerance:
            middle = first + 1 + worst
            found.add(middle)
            waiting += [(first, middle), (middle, last)]
    return np.array(sorted(found), dtype=np.intp)


def _line(axis: FloatArray, values: FloatArray, first: int, last: int) -> FloatArray:
    """The straight line between two points, at the points between them."""
    way = axis[last] - axis[first]
    if not way > 0:
        return np.full(last - first - 1, values[first])
    share = (axis[first + 1 : last] - axis[first]) / way
    return np.asarray(values[first] + share * (values[last] - values[first]))


def gapless(values: FloatArray, run: IntArray) -> list[IntArray]:
    """The pieces of a run of positions in which a curve has no gap."""
    known = run[np.isfinite(values[run])]
    if not len(known):
        return []
    return np.split(known, np.flatnonzero(np.diff(known) > 1) + 1)


@dataclass
class Room:
    """The space of a chart in points from its lower left corner.

    lines  that names should not cross, (k, 2) points each
    taken  boxes that are written on: left, bottom, right, top
    """

    width: float
    height: float
    lines: list[FloatArray] = field(default_factory=list)
    taken: list[tuple[float, float, float, float]] = field(default_factory=list)

    def put(
        self,
        text: str,
        line: FloatArray,
        size: float = 9.0,
        prefer: float | None = None,
        pull: float = 3.0,
        own: Collection[int] = (),
    ) -> tuple[float, float] | None:
        """The middle of a text beside a line (k, 2); None where it would cover another name.

        own     which of `lines` are its own: it stands where the others are far away
        prefer  share of the way along the line at which it stands best, and the `pull` of that
        """
        wide, high = _LETTER * size * len(text), _HEIGHT * size
        single = len(line) < 2
        points = line if single else _along(line, _TRIES)
        steps = [(0.0, high * offset) for offset in _OFFSETS]
        if single:
            beside = wide / 2 + 0.9 * size
            steps += [(side, high * up) for side in (beside, -beside) for up in _BESIDE]
        right, up = np.array(steps).T
        most_right = max(self.width - wide / 2 - 2, wide / 2 + 2)
        wanted = points[:, :1] + right  # (places along the line, steps beside it)
        across = np.clip(wanted, wide / 2 + 2, most_right)
        height = points[:, 1:] + up
        cost = self._cost(across, height, wide, high) + _FAR * np.abs(up) / high
        others = [line for k, line in enumerate(self.lines) if k not in own] if own else []
        lonely = 0.08 * np.maximum(0.0, _ALONE - _nearest(points, others))
        cost += 0.02 * np.abs(across - wanted) + lonely[:, None]
        if prefer is not None:
            cost += pull * np.abs(np.arange(len(points)) / (_TRIES - 1) - prefer)[:, None]
        if not cost.size or cost.min() >= _NAMED:
            return None
        best = np.unravel_index(np.argmax(cost <= cost.min() + 1e-9), cost.shape)
        middle = (float(across[best]), float(height[best]))
        self.take(middle, text, size)
        return middle

    def take(self, middle: tuple[float, float], text: str, size: float = 9.0) -> None:
        """Keep a text's place free of others."""
        wide, high = _LETTER * size * len(text), _HEIGHT * size
        x, y = middle
        self.taken.append((x - wide / 2, y - high / 2, x + wide / 2, y + high / 2))

    def _cost(self, x: FloatArray, y: FloatArray, wide: float, high: float) -> FloatArray:
        """Cost of a text of a width and height centred at (x, y), of any shape."""
        left, right = x - wide / 2 - 1, x + wide / 2 + 1
        low, top = y - high / 2, y + high / 2
        cost = np.where((low < 0) | (top > self.height), 2 * _NAMED, 0.0)
        for a, b, c, d in self.taken:
            cost += _NAMED * ((left < c) & (right > a) & (low < d) & (top > b))
        # places above each other: few points of a line are between their left and right
        above = (-1, x.shape[-1] if (x == x[..., :1]).all() else 1)
        sides = left.reshape(above)[:, :1], right.reshape(above)[:, :1]
        ends = low.reshape(above), top.reshape(above)
        for line in self.lines:
            column, point = np.nonzero((line[:, 0] > sides[0]) & (line[:, 0] < sides[1]))
            height = line[point, 1:]
            inside = (height > ends[0][column]) & (height < ends[1][column])
            count = np.zeros((len(inside) + 1, inside.shape[1]), dtype=int)
            np.cumsum(inside, axis=0, out=count[1:])
            first = np.searchsorted(column, np.arange(len(ends[0]) + 1))
            own = (count[first[1:]] - count[first[:-1]]).reshape(cost.shape)
            cost += _OVER * np.minimum(own, 6) / 2
        return cost


def _nearest(points: FloatArray, lines: Sequence[FloatArray]) -> FloatArray:
    """Distance of each point (n, 2) to the nearest of some lines' points; `_ALONE` without any."""
    crowd = np.concatenate([np.zeros((0, 2)), *lines])
    if not len(crowd):
        return np.full(len(points), _ALONE)
    between = points[:, None] - crowd
    return np.asarray(np.hypot(between[..., 0], between[..., 1]).min(axis=1))


def dense(line: FloatArray) -> FloatArray:
    """Points (k, 2) of a polyline, none further than a step from the next."""
    if len(line) < 2:
        return line
    lengths = np.hypot(*np.diff(line, axis=0).T)
    total = float(lengths.sum())
    return _along(line, max(2, int(total / _STEP) + 1))


def _along(line: FloatArray, n: int) -> FloatArray:
    """Points (n, 2) at even lengths along a polyline (k, 2)."""
    if len(line) < 2:
        return np.repeat(line, n, axis=0)
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    at = np.linspace(0.0, lengths[-1], n)
    return np.stack([np.interp(at, lengths, line[:, k]) for k in (0, 1)], axis=1)


def cut(line: FloatArray, width: float, height: float) -> Sequence[FloatArray]:
    """The piece of a polyline that is inside the space, as dense points."""
    size = np.array([width, height])
    if (line < -size).any() or (line > 2 * size).any():  # it may go on for miles
        pieces = [dense(piece) for piece in _clipped(line, -size, 2 * size)]
        points = np.concatenate([np.zeros((0, 2)), *pieces])
    else:
        points = dense(line)
    inside = (points >= 0).all(axis=1) & (points <= size).all(axis=1)
    return [points[inside]] if inside.any() else []


def _clipped(line: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Both ends (k, 2, 2) of what is within a frame of each piece of a polyline.

    By Liang and Barsky: a piece enters with its last entry between the sides, and leaves with its
    first exit.
    """
    start, step = line[:-1], np.diff(line, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = np.stack([(low - start) / step, (high - start) / step])
    enter = np.fmin(*sides).max(axis=1, initial=0.0)[:, None]
    leave = np.fmax(*sides).min(axis=1, initial=1.0)[:, None]
    met = (enter <= leave)[:, 0]
    start, step, enter, leave = start[met], step[met], enter[met], leave[met]
    return np.stack([start + enter * step, start + leave * step], axis=1)


_LEFT, _RIGHT, _TOP, _BOTTOM = 46.0, 14.0, 20.0, 36.0  # points
LABEL = 9.0
_CLOUD = 1.6  # points: of dots that are nearer than this one is drawn


class Plane:
    """Axes of a chart, linear or logarithmic, in a frame of fixed size."""

    def __init__(
        self,
        drawing: Drawing,
        across: tuple[float, float],
        up: tuple[float, float],
        *,
        logarithmic: str = "",
    ) -> None:
        width, height = drawing.width - _LEFT - _RIGHT, drawing.height - _TOP - _BOTTOM
        box = (_LEFT, _TOP, width, height)
        self.frame = drawing.frame(box, across, up, logarithmic=logarithmic)
        self.room = Room(width, height)
        self._drawing = drawing

    def titles(self, across: str, up: str) -> None:
        """Names of the axes: below, and above the axis that goes up."""
        size = LABEL + 0.5
        below = self._drawing.height - _BOTTOM + 30
        self._drawing.text(_LEFT + self.room.width / 2, below, across, size=size)
        self._drawing.text(0.0, _TOP - 9, up, size=size, anchor="start", weight="bold")

    def at(self, points: npt.ArrayLike) -> FloatArray:
        """Places (k, 2) in points from the lower left corner."""
        from_top = self.frame.places(points) - (_LEFT, _TOP)
        return np.asarray(from_top * (1, -1) + (0, self.room.height))

    def line(self, points: npt.ArrayLike, *, crossed: bool = False, **style: Any) -> FloatArray:
        """Draw a polyline (k, 2); names keep clear of it unless it may be crossed."""
        given = np.asarray(points, dtype=float).reshape(-1, 2)
        self.frame.line(given, **style)
        if not crossed:
            self.room.lines += [dense(piece) for piece in cut(self.at(given), *self._size)]
        return given

    def name(
        self,
        text: str,
        points: npt.ArrayLike,
        colour_of: str,
        prefer: float | None = None,
        **style: Any,
    ) -> bool:
        """Write a text beside a polyline (k, 2) or a point; whether there was room."""
        inside = cut(self.at(points), *self._size)
        found = self.room.put(text, inside[0], LABEL, prefer) if inside else None
        if found is None:
            return False
        self.write(text, found, color=colour_of, **style)
        return True

    def write(self, text: str, at: Sequence[float], *, size: float = LABEL, **style: Any) -> None:
        """Write a text centred at a place from the lower left corner."""
        self.frame.text(_LEFT + at[0], _TOP + self.room.height - at[1], text, size=size, **style)

    def dots(self, points: FloatArray, tint: str, size: float) -> None:
        """Many dots (k, 2), as one path; of those that fall on each other one."""
        if not len(points):
            return
        _, first = np.unique(np.round(self.at(points) / _CLOUD), axis=0, return_index=True)
        self.frame.dots(points[np.sort(first)], tint, size)

    def avoid(self, points: npt.ArrayLike, radius: float = 6.0) -> None:
        """Keep names off some points (k, 2)."""
        for x, y in self.at(points):
            self.room.taken.append((x - radius, y - radius, x + radius, y + radius))

    @property
    def _size(self) -> tuple[float, float]:
        return self.room.width, self.room.height


def drawing(
    plot: Callable[[Drawing], Mapping[str, str] | None], label: str, height: float = SIZE[1]
) -> str:
    """The picture of what `plot` draws on a drawing of the common width."""
    return draw(plot, (SIZE[0], height), label)


def ink() -> str:
    """The colour of letters."""
    return INK


def upper(values: Sequence[float], share: float = 1.1) -> float:
    """An axis' upper end above some values; 1 where all are 0."""
    return share * max([*values, 0.0]) or 1.0
