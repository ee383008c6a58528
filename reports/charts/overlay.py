"""Curves over the shown position of a cycle: phases by their dashes, the busiest one enlarged."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np
import numpy.typing as npt

from checks.result.words import brief
from reports.svg import INK, SERIES, Drawing, draw

FloatArray = npt.NDArray[np.float64]

_WIDTH, _LEFT, _BETWEEN, _PANEL = 720.0, 50.0, 46.0, 130.0  # points
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

    order = list(dict.fromkeys(phases))
    wide = (_WIDTH - _LEFT) / len(windows)

    def plot(figure: Drawing) -> None:
        top = 0.0
        for title, unit, curves in panels:
            tints = {key: SERIES[k % len(SERIES)] for k, key in enumerate(curves)}
            names = [(brief(key, 28), {"color": tint}) for key, tint in tints.items()]
            high = figure.legend(names, (_LEFT, top + 20, _WIDTH - _LEFT))
            for column, window in enumerate(windows):
                left = _LEFT + column * wide
                phase = brief(phases[int(np.argmax(window))], 24)
                told = title if column == 0 else f"{title}: phase “{phase}”"
                figure.text(left, top + 13, told, anchor="start", weight="bold")
                shown = {key: values[window] for key, values in curves.items()}
                box = (left, top + 36 + high, wide - _BETWEEN, _PANEL)
                axes = figure.frame(box, *_ends(position[window], shown))
                figure.text(left - 44, box[1] - 7, unit, anchor="start", size=9)
                middle, below = left + (wide - _BETWEEN) / 2, box[1] + _PANEL + 27
                figure.text(middle, below, axis, size=9)
                for key, values in curves.items():
                    for phase, run in _runs(phases):
                        inside = run[window[run]]
                        axes.line(
                            np.stack([position[inside], values[inside]], axis=1), color=tints[key],
                            linestyle=_dash(order.index(phase)),
                            marker="." if len(inside) == 1 else "",
                        )  # fmt: skip
            top += 36 + high + _PANEL + 36
        if len(order) > 1:
            dashes = [
                (brief(p, 24), {"color": INK, "linestyle": _dash(i)}) for i, p in enumerate(order)
            ]
            top += figure.legend(dashes, (_LEFT, top, _WIDTH - _LEFT))
        figure.height = top + 4

    return draw(plot, (_WIDTH, 0.0), label)


def _ends(
    position: FloatArray, curves: Mapping[str, FloatArray]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Ends of both axes: all that is known, and some room."""
    return _with_room(position), _with_room(np.concatenate([np.zeros(0), *curves.values()]))


def _with_room(values: FloatArray) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 0.0)
    room = 0.05 * (high - low) or 0.05 * abs(high) or 1.0
    return low - room, high + room


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
