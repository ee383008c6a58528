"""A pair of axes that knows where its points are on paper, so that names find room beside them."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from reports.charts.chart import SIZE
from reports.charts.labels import Room, cut, dense
from reports.charts.numbers import FloatArray
from reports.svg import INK, Drawing, draw

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
        self, text: str, points: npt.ArrayLike, colour_of: str, prefer: float | None = None,
        pull: float = 3.0, **style: Any,
    ) -> bool:  # fmt: skip
        """Write a text beside a polyline (k, 2) or a point; whether there was room."""
        inside = cut(self.at(points), *self._size)
        found = self.room.put(text, inside[0], LABEL, prefer, pull) if inside else None
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
