"""Charts over a cycle: loads of the interfaces, efforts and powers, peak stress of every part."""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

import numpy as np

from checks.result.verdict import Check, DesignResult, PartResult
from checks.result.words import brief, need_text, number, quantity_unit
from geometry.mesh import FloatArray
from reports.charts.chart import (
    Chart,
    Charts,
    Missing,
    gathered,
    largest,
    numbers,
    plain,
    power_unit,
    work_text,
)
from reports.charts.over_cycle import (
    Bar,
    Curve,
    CycleAxis,
    Limit,
    Panel,
    cycle_axis,
    cycle_table,
    over_cycle,
)

_TITLES = {
    "loads": "Loads of the interfaces",
    "drive": "Drive: effort and power",
    "peaks": "Peak stress of each part",
}
_ALIKE = 0.005  # of the largest load: curves that are nowhere further apart are drawn as one
_SAME = 1e-6  # of a value: a curve's peak and a check that tell of the same
_NOTHING = 1e-4  # of the work turned over: a work below it is about 0
_CLOSE = 0.001  # %, below which an agreement is not told more exactly
_NOTES = 4  # remarks on single parts in a caption


def cycle_charts(result: DesignResult) -> list[tuple[str, Charts]]:
    """The charts of every cycle of a result, in their order: (name, charts)."""
    return [
        (name, _of_cycle(result, index, name, cycle))
        for index, (name, cycle) in enumerate(result.cycles.items())
    ]


def _of_cycle(result: DesignResult, index: int, name: str, cycle: Mapping[str, Any]) -> Charts:
    axis = cycle_axis(index, cycle)
    if axis is None:
        why = "the cycle has no positions"
        return Charts((), tuple(Missing(key, title, why) for key, title in _TITLES.items()))
    return gathered(
        [
            loads_chart(name, axis, cycle),
            drive_chart(name, axis, cycle),
            peaks_chart(name, axis, cycle, result.parts),
        ]
    )


def loads_chart(name: str, axis: CycleAxis, cycle: Mapping[str, Any]) -> Chart | Missing:
    """Resultants at the interfaces of all parts; those that are alike are one curve."""
    title = _TITLES["loads"]
    links = _curves(cycle.get("links"), axis)
    if not links:
        return Missing("loads", title, "the cycle says nothing of the load of any part")
    size = largest(links)
    unit, factor = quantity_unit(False, size)
    groups = _alike(links, _ALIKE * size)
    curves = [Curve(_all(names), factor * links[names[0]], _first(names)) for names in groups]
    svg, series = over_cycle(
        f"Loads of the interfaces over cycle {brief(name, 40)}", axis,
        [Panel("resultant force", unit, curves)],
    )  # fmt: skip
    every = [Panel("resultant force", unit, [Curve(n, factor * v) for n, v in links.items()])]
    columns, rows = cycle_table(axis, every)
    told = "Size of the force on each interface, whatever its direction."
    if len(groups) < len(links):
        told += f" Loads that differ by less than {100 * _ALIKE:g} % of the largest are one curve."
    return Chart("loads", title, _with_scales(told, axis), svg, columns, rows, series)


def _alike(curves: Mapping[str, FloatArray], tolerance: float) -> list[list[str]]:
    """Names of curves that are nowhere further apart than the tolerance from the first of them."""
    groups: list[list[str]] = []
    for name in sorted(curves, key=lambda key: -_top(curves[key])):
        for group in groups:
            apart = np.abs(curves[name] - curves[group[0]])
            same_gaps = (np.isfinite(curves[name]) == np.isfinite(curves[group[0]])).all()
            if same_gaps and (apart[np.isfinite(apart)] <= tolerance).all():
                group.append(name)
                break
        else:
            groups.append([name])
    return groups


def _all(names: Sequence[str]) -> str:
    return ", ".join(brief(name, 40) for name in names)


def _first(names: Sequence[str]) -> str:
    more = f" +{len(names) - 1}" if len(names) > 1 else ""
    return brief(names[0], 26 - len(more)) + more


def _top(values: FloatArray) -> float:
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def _curves(named: Mapping[str, Any] | None, axis: CycleAxis) -> dict[str, FloatArray]:
    found = {name: numbers(values) for name, values in plain(named).items()}
    return {name: values for name, values in found.items() if len(values) == len(axis.values)}


def drive_chart(name: str, axis: CycleAxis, cycle: Mapping[str, Any]) -> Chart | Missing:
    """Forces, torques, and the power that each puts into the linkage."""
    title = _TITLES["drive"]
    forces, torques = (_curves(cycle.get(key), axis) for key in ("efforts", "torques"))
    powers = _curves(cycle.get("powers"), axis)
    if not forces and not torques:
        why = "the cycle has no drive: its loads were measured, or no force acts in it"
        return Missing("drive", title, why)
    panels = []
    drives = [*forces, *torques]
    for quantity, angular, found in (("force", False, forces), ("torque", True, torques)):
        if largest(found):
            unit, factor = quantity_unit(angular, largest(found))
            curves = [Curve(k, factor * v, "", drives.index(k)) for k, v in found.items()]
            panels.append(Panel(quantity, unit, curves))
    if not panels:
        return Missing("drive", title, "no force acts at any position of this cycle")
    if largest(powers):
        unit, factor = power_unit(largest(powers))
        curves = [
            Curve(f"power of {k}", factor * v, k, drives.index(k))
            for k, v in powers.items()
            if k in drives and _top(v)
        ]
        panels.append(Panel("power", unit, curves))
    svg, series = over_cycle(f"Efforts and powers over cycle {brief(name, 40)}", axis, panels)
    columns, rows = cycle_table(axis, panels)
    told = _with_scales(_work_told(cycle, powers), axis)
    return Chart("drive", title, told, svg, columns, rows, series)


def _work_told(cycle: Mapping[str, Any], powers: Mapping[str, FloatArray]) -> str:
    """Work of every force, its mean power, and how well the curves' areas agree with the work."""
    works, time = plain(cycle.get("works")), numbers(cycle.get("time"))
    if not powers:
        return "Powers are not known: the result does not have them."
    told = ["Power above 0 drives the linkage, below 0 it is taken from it."]
    timed = all(len(time) == len(values) for values in powers.values()) and len(time) > 1
    duration = float(time[-1] - time[0]) if timed else 0.0
    if not timed or not duration > 0:
        return " ".join([*told, "Without times there is no work of the cycle to compare with."])
    areas = {name: _area(values, time) for name, values in powers.items()}
    turnover = sum(_area(np.abs(values), time) for values in powers.values())
    for name, work in works.items():
        told.append(f"{brief(name, 40)}: {_work(float(work), turnover, duration)}.")
    missed = max((abs(areas[n] - float(works[n])) for n in areas if n in works), default=0.0)
    if turnover > 0 and works:
        share = max(100 * missed / turnover, _CLOSE)
        told.append(
            "The areas under the power curves agree with these works within "
            f"{share:.2g} % of all work that is turned over."
        )
    return " ".join(told)


def _work(work: float, turnover: float, duration: float) -> str:
    """A work of the cycle and its mean power; what is lost in rounding is about 0."""
    if abs(work) <= _NOTHING * turnover:
        return f"work about 0 J, less than {100 * _NOTHING:g} % of all that is turned over"
    unit, factor = power_unit(abs(work) / duration)
    mean = number(factor * work / duration).replace("-", "−")
    return f"work {work_text(work)}, mean power {mean} {unit}"


def _area(values: FloatArray, time: FloatArray) -> float:
    middle = (values[1:] + values[:-1]) / 2.0
    return float(np.nansum(middle * np.diff(time)))


def peaks_chart(
    name: str, axis: CycleAxis, cycle: Mapping[str, Any], parts: Sequence[PartResult]
) -> Chart | Missing:
    """The largest von Mises stress of each part at every position, and what is allowed of it."""
    title = _TITLES["peaks"]
    peaks = _curves(cycle.get("peaks"), axis)
    if not peaks:
        return Missing("peaks", title, "no part's stress was computed over this cycle")
    statics = {part.name: _static(part) for part in parts}
    bars, told = [], []
    for k, (part, values) in enumerate(peaks.items()):
        check = statics.get(part)
        if check is None:
            continue
        bar, remark = _peak_bar(name, k, values, check)
        bars += [bar] if bar else []
        told += [remark] if remark else []
    limits = _allowed({part: c for part, c in statics.items() if c and part in peaks})
    panel = Panel("von Mises", "MPa", [Curve(k, v) for k, v in peaks.items()], limits, bars)
    svg, series = over_cycle(f"Peak stress over cycle {brief(name, 40)}", axis, [panel])
    columns, rows = cycle_table(axis, [panel])
    high = panel.span[1]
    beyond = [limit.text for limit in limits if limit.value > high]
    if limits and not beyond:
        told.insert(0, "Red: yield stress over the required safety.")
    elif beyond:
        told.insert(0, f"Above the chart: {'; '.join(beyond)}.")
    if bars:
        told.append("Bars: error of the static check's value.")
    caption = _with_scales(" ".join(told[: _NOTES + 2]), axis)
    return Chart("peaks", title, caption, svg, columns, rows, series)


def _with_scales(caption: str, axis: CycleAxis) -> str:
    """The caption, and that the axis is not to scale from phase to phase where it is not."""
    return f"{caption} {axis.scales_told}".strip()


def _static(part: PartResult) -> Check | None:
    return next((c for c in part.checks if c.kind == "static" and c.unit == "MPa"), None)


def _peak_bar(name: str, k: int, values: FloatArray, check: Check) -> tuple[Bar | None, str]:
    """The error bar of a static check at its curve's peak; else why the curve has none."""
    if check.cycle != name:
        return None, ""
    peak = _top(values)
    if abs(check.value - peak) > _SAME * max(check.value, peak):
        return None, (
            f"{brief(check.part, 40)}: the static check has {number(check.value)} MPa by "
            f"{brief(check.method, 40)}, another model than the curve's."
        )
    above, below = check.numerical + check.model, check.numerical + check.below
    if not isfinite(above + below):
        return None, f"{brief(check.part, 40)}: the error bar is infinite."
    known = np.where(np.isfinite(values), values, -np.inf)
    return Bar(k, int(known.argmax()), min(below, peak), above), ""


def _allowed(checks: Mapping[str, Check]) -> list[Limit]:
    """Allowed values of parts: the limit over the required safety, equal ones together."""
    groups: dict[tuple[float, float], list[str]] = {}
    for part, check in checks.items():
        groups.setdefault((check.limit, check.required), []).append(part)
    return [
        Limit(limit / required, f"{_few(names)}: {number(limit)} MPa / {need_text(required)}")
        for (limit, required), names in groups.items()
    ]


def _few(names: Sequence[str]) -> str:
    if len(names) > 2:
        return f"{brief(names[0], 20)} and {len(names) - 1} more"
    return ", ".join(brief(name, 20) for name in names)
