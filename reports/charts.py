"""Charts of a result as SVG text: utilisations, the cycle's loads and stresses, Haigh diagrams."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from math import isfinite
from typing import Any

import numpy as np
import numpy.typing as npt

from reports.svg import SERIES, colour, draw
from reports.verdict import Check, DesignResult, PartResult, Status
from reports.words import brief, check_titles, need_text, utilisation_text

FloatArray = npt.NDArray[np.float64]

_DASHES = ["-", "--", ":", "-."]
_STATUS_COLOUR = {Status.PASS: "pass", Status.FAIL: "fail", Status.UNDECIDED: "undecided"}
_ENLARGE_BELOW = 0.4  # of the stroke: a phase shorter than this is drawn again, enlarged
_LONGEST_AXIS = 4.0  # utilisations beyond are cut off and written beside their bar


def utilisation_chart(result: DesignResult) -> str:
    """All checks as bars of utilisation with numerical and model error bars drawn apart."""
    checks = result.checks
    if not checks:
        return ""
    upper = [c.utilisation + _scaled(c, c.numerical) + _scaled(c, c.model) for c in checks]
    end = min(_LONGEST_AXIS, max([1.25, *(u * 1.08 for u in upper if isfinite(u))]))
    titles = check_titles(checks)
    labels = [f"{brief(c.part, 24)} {brief(t, 36)}" for c, t in zip(checks, titles, strict=True)]

    def plot(figure: Any) -> None:
        figure.get_layout_engine().set(rect=(0, 0, 0.94, 1))  # room for the numbers on the right
        axes = figure.add_subplot()
        for row, check in enumerate(checks):
            _utilisation_row(axes, row, check, end)
        axes.axvline(1.0, color=colour("fail"), linewidth=1.6)
        axes.set_yticks(range(len(checks)), labels)
        deciding = next(i for i, c in enumerate(checks) if c is result.deciding)
        axes.get_yticklabels()[deciding].set_fontweight("bold")
        axes.set_ylim(len(checks) - 0.4, -0.6)
        axes.set_xlim(0, end)
        axes.grid(visible=False, axis="y")
        axes.set_xlabel("utilisation = value × required safety / limit [–]; bold decides")
        ink = colour("ink")
        handles = [
            axes.plot([], [], color=ink, linewidth=5, alpha=0.9, label="± numerical")[0],
            axes.plot([], [], color=ink, linewidth=1.2, marker="|", label="± model, beyond")[0],
            axes.plot([], [], color=colour("fail"), label="limit")[0],
        ]
        figure.legend(handles=handles, loc="outside upper right", ncols=3)

    return draw(plot, (9, 1.2 + 0.34 * len(checks)), "Utilisation of all checks")


def _scaled(check: Check, bar: float) -> float:
    return bar * check.required / check.limit


def _utilisation_row(axes: Any, row: int, check: Check, end: float) -> None:
    ink, use = colour("ink"), check.utilisation
    status = colour(_STATUS_COLOUR[check.status])
    axes.barh(row, min(use, end), height=0.62, color=status, alpha=0.55, linewidth=0)
    numerical, model = _scaled(check, check.numerical), _scaled(check, check.model)
    if isfinite(numerical + model):
        # The whole bar first and thin, the numerical one over it and thick.
        below = _scaled(check, check.below)
        for under, over, width in (
            (numerical + below, numerical + model, 1.2),
            (numerical, numerical, 5.0),
        ):
            low, high = max(use - under, 0.0), min(use + over, end)
            if low < end:
                axes.plot([low, high], [row, row], color=ink, lw=width, solid_capstyle="butt")
        ends = [x for x in (use - numerical - below, use + numerical + model) if 0 < x < end]
        axes.plot(ends, [row] * len(ends), "|", color=ink, markersize=8)
    else:
        axes.plot([0, end], [row, row], color=ink, linewidth=1.2, linestyle=":")
        axes.plot(end, row, ">", color=ink, clip_on=False)
    text = utilisation_text(use) + ("" if isfinite(numerical + model) else " ±∞")
    axes.annotate(
        text, (1, row), xycoords=("axes fraction", "data"), xytext=(10, 0),
        textcoords="offset points", va="center", annotation_clip=False,
        color=ink,
    )  # fmt: skip


def cycle_chart(name: str, cycle: Mapping[str, Any]) -> str:
    """Efforts, link loads and peak stresses over the shown position of one cycle.

    The phase that carries the largest load is drawn again, enlarged, when it is short.
    """
    position = _array(cycle["position"])
    phases = [str(phase) for phase in cycle.get("phase", [""] * len(position))]
    panels = [
        (title, unit, {key: _array(values) * scale for key, values in curves.items()})
        for title, unit, scale, curves in (
            ("Forces", "force [kN]", 1e-3, cycle.get("efforts") or {}),
            ("Torques", "torque [N m]", 1e-3, cycle.get("torques") or {}),
            ("Loads of the joints", "resultant [kN]", 1e-3, cycle.get("links") or {}),
            ("Peak stress of each part", "von Mises [MPa]", 1.0, cycle.get("peaks") or {}),
        )
        if curves
    ]
    if not panels or not len(position):
        return ""
    axis = f"{brief(cycle.get('shown_name', 'position'), 20)} [{brief(cycle.get('unit', '–'), 8)}]"
    return curves_chart(f"Cycle {brief(name, 40)}", position, phases, panels, axis)


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


def haigh_chart(part: PartResult, cycles: Mapping[str, Mapping[str, Any]]) -> str:
    """Haigh diagram of a part and the stress path of its critical point, or "" without one."""
    haigh = part.charts.get("haigh")
    if not haigh:
        return ""
    required = [check.required for check in part.checks if check.kind == "fatigue"]

    def plot(figure: Any) -> None:
        left, right = figure.subplots(1, 2, width_ratios=[1.25, 1])
        _haigh_lines(left, haigh, required[0] if required else None)
        _stress_path(right, haigh, cycles.get(haigh["cycle"], {}))

    return draw(plot, (10, 4.2), f"Haigh diagram of {brief(part.name, 40)}")


def _haigh_lines(axes: Any, haigh: Mapping[str, Any], required: float | None) -> None:
    endurance, ultimate, strength = (haigh[key] for key in ("endurance", "ultimate", "yield"))
    mean, amplitude = haigh["mean"], haigh["amplitude"]
    cloud = _array(haigh.get("cloud")).reshape(-1, 2)
    axes.plot([0, ultimate], [endurance, 0], color=SERIES[0], label="Goodman")
    if required:
        axes.plot(
            [0, ultimate / required], [endurance / required, 0],
            color=SERIES[0], linestyle="--", label=f"Goodman / {need_text(required)}",
        )  # fmt: skip
    axes.plot([0, strength], [strength, 0], color=SERIES[6], label="yield (Langer)")
    axes.scatter(
        cloud[:, 0], cloud[:, 1], s=8, color=SERIES[4], alpha=0.6, linewidths=0,
        label="most used points",
    )  # fmt: skip
    use = amplitude / endurance + max(mean, 0) / ultimate
    if use > 0:
        # Onwards to the Goodman line: how much the stress may grow in proportion.
        far = 1 / use
        axes.plot([mean, mean * far], [amplitude, amplitude * far], ":", color=colour("ink"))
    axes.plot(mean, amplitude, "o", color=SERIES[1], markersize=8, label="critical point")
    axes.set_xlim(min(0, mean, *cloud[:, 0]) * 1.05, max(ultimate, mean) * 1.03)
    axes.set_ylim(0, 1.15 * max(endurance, amplitude, *cloud[:, 1]))
    axes.set_xlabel("mean stress [MPa]")
    axes.set_ylabel("stress amplitude [MPa]")
    axes.set_title(f"Haigh diagram, cycle {brief(haigh['cycle'], 24)}")
    axes.legend(fontsize=8, loc="upper right")


def _stress_path(axes: Any, haigh: Mapping[str, Any], cycle: Mapping[str, Any]) -> None:
    along = _array(haigh.get("along"))
    time = _array(cycle.get("time"))
    timed = len(time) == len(along)
    axes.plot(time if timed else np.arange(len(along)), along, color=SERIES[1])
    if len(along):
        middle = (along.max() + along.min()) / 2
        axes.axhline(middle, color=colour("ink"), linestyle=":", linewidth=1.2)
        for level in (along.min(), along.max()):
            axes.axhline(level, color=colour("faint"), linewidth=1.2)
    axes.set_xlabel("time [s]" if timed else "number of the position [–]")
    axes.set_ylabel("stress along the longest chord [MPa]")
    axes.set_title("Path of the critical point")


def _array(values: Any) -> FloatArray:
    """Numbers with a gap where there is none; empty for None."""
    if values is None:
        return np.zeros(0)
    return np.array([np.nan if v is None else v for v in np.asarray(values).tolist()], dtype=float)
