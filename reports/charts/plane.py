"""A pair of axes that knows where its points are on paper, so that names find room beside them."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from reports.charts.chart import SIZE
from reports.charts.labels import Room, cut, dense
from reports.charts.numbers import FloatArray
from reports.svg import Marks, Plot, colour, draw, place

_LEFT, _RIGHT, _TOP, _BOTTOM = 46.0, 14.0, 20.0, 36.0  # points
LABEL = 9.0
_CLOUD = 1.6  # points: of dots that are nearer than this one is drawn


class Plane:
    """Axes of a chart, linear or logarithmic, in a frame of fixed size."""

    def __init__(
        self,
        figure: Any,
        across: tuple[float, float],
        up: tuple[float, float],
        *,
        logarithmic: str = "",
    ) -> None:
        wide, high = figure.get_figwidth() * 72.0, figure.get_figheight() * 72.0
        width, height = wide - _LEFT - _RIGHT, high - _TOP - _BOTTOM
        self.axes = figure.add_axes((_LEFT / wide, _BOTTOM / high, width / wide, height / high))
        if "x" in logarithmic:
            self.axes.set_xscale("log")
        if "y" in logarithmic:
            self.axes.set_yscale("log")
        self.axes.set_xlim(*across)
        self.axes.set_ylim(*up)
        self.axes.tick_params(length=0, pad=4)
        self.axes.minorticks_off()
        self.room = Room(width, height)

    def titles(self, across: str, up: str) -> None:
        """Names of the axes: below, and above the axis that goes up."""
        room = self.room
        self.axes.text(0.5, -30 / room.height, across, transform=self.axes.transAxes, ha="center",
                       size=LABEL + 0.5)  # fmt: skip
        self.axes.text(-_LEFT / room.width, 1 + 7 / room.height, up, weight="bold", va="bottom",
                       transform=self.axes.transAxes, size=LABEL + 0.5)  # fmt: skip

    def at(self, points: npt.ArrayLike) -> FloatArray:
        """Places (k, 2) in points from the lower left corner."""
        given = np.asarray(points, dtype=float).reshape(-1, 2)
        shares = self.axes.transData.transform(given)
        frame = self.axes.get_window_extent()
        scale = 72.0 / self.axes.figure.dpi
        return np.asarray((shares - [frame.x0, frame.y0]) * scale)

    def line(self, points: npt.ArrayLike, *, crossed: bool = False, **style: Any) -> FloatArray:
        """Draw a polyline (k, 2); names keep clear of it unless it may be crossed."""
        given = np.asarray(points, dtype=float).reshape(-1, 2)
        self.axes.plot(given[:, 0], given[:, 1], **style)
        if not crossed:
            self.room.lines += [dense(piece) for piece in cut(self.at(given), *self._size)]
        return given

    def name(
        self, text: str, points: npt.ArrayLike, colour_of: str, prefer: float | None = None,
        pull: float = 3.0, **style: Any,
    ) -> bool:  # fmt: skip
        """Write a text beside a polyline (k, 2) or a point; whether there was room."""
        inside = cut(self.at(points), *self._size)
        found = self.room.put(text, inside[0], LABEL, prefer, pull) if inside else None
        if found is None:
            return False
        self.axes.annotate(
            text, found, xycoords=self._points, ha="center", va="center", size=LABEL,
            color=colour_of, **style,
        )  # fmt: skip
        return True

    def dots(self, points: FloatArray, tint: str, size: float) -> None:
        """Many dots (k, 2), as one path; of those that fall on each other one."""
        if not len(points):
            return
        places = self.at(points)
        _, first = np.unique(np.round(places / _CLOUD), axis=0, return_index=True)
        kept = points[np.sort(first)]
        gap = np.full(len(kept), np.nan)
        xs = np.stack([kept[:, 0], kept[:, 0], gap], axis=1).ravel()
        ys = np.stack([kept[:, 1], kept[:, 1], gap], axis=1).ravel()
        self.axes.plot(xs, ys, color=tint, linewidth=size, solid_capstyle="round")

    def avoid(self, points: npt.ArrayLike, radius: float = 6.0) -> None:
        """Keep names off some points (k, 2)."""
        for x, y in self.at(points):
            self.room.taken.append((x - radius, y - radius, x + radius, y + radius))

    def drawn(self, points: npt.ArrayLike) -> list[tuple[float, float]]:
        """Places in the drawing's view box, when all is laid out."""
        given = np.asarray(points, dtype=float).reshape(-1, 2)
        return [place(self.axes, float(x), float(y)) for x, y in given]

    @property
    def _size(self) -> tuple[float, float]:
        return self.room.width, self.room.height

    @property
    def _points(self) -> Any:
        from matplotlib.transforms import Affine2D

        figure = self.axes.figure
        place_of = self.axes.get_position()
        corner = (place_of.x0 * figure.get_figwidth(), place_of.y0 * figure.get_figheight())
        return Affine2D().scale(1 / 72).translate(*corner) + figure.dpi_scale_trans


def drawing(
    plot: Callable[[Any], Callable[[], Marks] | None], label: str, height: float = SIZE[1]
) -> str:
    """The picture of what `plot` draws on a figure of the common width; height in inches."""
    made: Plot = plot
    return draw(made, (SIZE[0], height), label, layout=None)


def ink() -> str:
    """The colour of letters."""
    return colour("ink")


def upper(values: Sequence[float], share: float = 1.1) -> float:
    """An axis' upper end above some values; 1 where all are 0."""
    return share * max([*values, 0.0]) or 1.0
