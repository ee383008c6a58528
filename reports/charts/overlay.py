"""Curves over the shown position of a cycle: phases by their dashes, the busiest one enlarged."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np
import numpy.typing as npt

from checks.result.words import brief
from reports.svg import SERIES, colour, draw

FloatArray = npt.NDArray[np.float64]

_DASHES = ["-", "--", ":", "-."]
_ENLARGE_BELOW = 0.4  # of the stroke: a phase shorter than this is drawn again, enlarged


def curves_chart(
    label: str,
    position: FloatArray,
    phases: Sequence[str],
    panels: Sequence[tuple[str, str, Mapping[str, FloatArray]]],
    axis: str,
) -> str:
    """Curves over the shown position, one panel (title, unit, curves) above the other.

    The phase in which the last panel peaks is drawn again, enlarged, when it is short.
    """
    windows = [np.ones(len(position), dtype=bool)]
    short = _busiest_phase(position, phases, panels)
    if short is not None:
        windows.append(short)

    def plot(figure: Any) -> None:
        grid = figure.subplots(len(panels), len(windows), squeeze=False)
        for row, (title, unit, curves) in enumerate(panels):
            for column, window in enumerate(windows):
                axes = grid[row, column]
                _curves(axes, position, phases, curves, window, legend=column == 0)
                phase = brief(phases[int(np.argmax(window))], 24)
                axes.set_title(title if column == 0 else f"{title}: phase “{phase}”")
                axes.set_xlabel(axis)
                axes.set_ylabel(unit)
        order = list(dict.fromkeys(phases))
        if len(order) > 1:
            handles = [
                grid[0, 0].plot(
                    [], [], color=colour("ink"), linestyle=_dash(i), label=brief(p, 24)
                )[0]
                for i, p in enumerate(order)
            ]
            figure.legend(handles=handles, loc="outside lower center", ncols=min(4, len(order)))

    return draw(plot, (10, 0.6 + 2.7 * len(panels)), label)


def _curves(
    axes: Any,
    position: FloatArray,
    phases: Sequence[str],
    curves: Mapping[str, FloatArray],
    window: npt.NDArray[np.bool_],
    legend: bool,
) -> None:
    """Each curve in its colour, each phase in its dashes; nothing joins across phases."""
    order = list(dict.fromkeys(phases))
    for number_of, (key, values) in enumerate(curves.items()):
        tint = SERIES[number_of % len(SERIES)]
        for phase, run in _runs(phases):
            inside = run[window[run]]
            dash = _dash(order.index(phase))
            mark = "." if len(inside) == 1 else ""
            axes.plot(position[inside], values[inside], color=tint, linestyle=dash, marker=mark)
        if legend:
            axes.plot([], [], color=tint, label=brief(key, 28))
    if legend:
        axes.legend(fontsize=8, loc="best")


def _dash(index: int) -> str:
    return _DASHES[index % len(_DASHES)]


def _runs(phases: Sequence[str]) -> list[tuple[str, npt.NDArray[np.intp]]]:
    """Neighbouring positions of the same phase, as (phase, indices)."""
    pairs = groupby(range(len(phases)), key=lambda i: phases[i])
    return [(phase, np.array(list(indices), dtype=np.intp)) for phase, indices in pairs]


def _busiest_phase(
    position: FloatArray, phases: Sequence[str], panels: Sequence[tuple[Any, ...]]
) -> npt.NDArray[np.bool_] | None:
    """Positions of the phase in which the last panel peaks, if it is short, else None."""
    curves = np.array([values for *_, shown in panels[-1:] for values in shown.values()])
    if not np.isfinite(curves).any():
        return None
    peak = int(np.nanargmax(np.nanmax(np.where(np.isfinite(curves), np.abs(curves), 0), axis=0)))
    run = next(run for _, run in _runs(phases) if peak in run)
    if len(run) < 3 or np.ptp(position[run]) > _ENLARGE_BELOW * np.ptp(position):
        return None
    window = np.zeros(len(position), dtype=bool)
    window[run] = True
    return window
