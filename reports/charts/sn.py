"""The S-N line of a part's critical point, and the cycles of its duty beside it."""

from collections.abc import Mapping
from math import inf, isfinite
from typing import Any

import numpy as np

from checks.result.verdict import Check, DesignResult, PartResult
from checks.result.words import brief, need_text, number, safety_text
from fatigue import equivalent_amplitude
from geometry.mesh import FloatArray
from reports.charts.chart import (
    Chart,
    Missing,
    Plane,
    Series,
    decimals_of,
    drawing,
    fixed,
    ink,
    numbers,
    thinned,
)
from reports.charts.haigh import LOWERED, SWING, limit_told, path_of, utilisation
from reports.charts.over_cycle import cursor_text
from reports.svg import SERIES, Drawing

_TITLE = "S-N line and duty"
_LEAST = 0.08  # of the endurance limit: smaller cycles are below the chart
_MARKED = 1e-3  # of the damage: a cycle that does more is marked as harmful
_NOTHING = 1e-9  # of a damage: what is below counts as nothing
_FIRST, _LAST = 1e3, 1e9  # cycles that the chart has at least
_ROWS = 30


def sn_chart(part: PartResult, result: DesignResult) -> Chart | Missing:
    """Counted cycles, as often as they come in a life, against what the part endures."""
    data = part.charts.get("sn")
    if not data:
        return Missing("sn", _TITLE, "no cycle of the duty loads this part")
    check = next((c for c in part.checks if c.kind == "fatigue"), None)
    data = _with_infinite(data)
    cycles = np.array([numbers(row) for row in data["cycles"]]).reshape(-1, 4)
    haigh = part.charts.get("haigh") or part.charts.get("fkm") or {}
    series = [Series(f"fully reversed amplitude of {SWING}", "MPa", decimals=1)]
    paths = _paths(haigh, data, result)

    def plot(figure: Drawing) -> dict[str, str]:
        plane = _plane(figure, data, cycles)
        _lines(plane, data)
        _duty(plane, data, cycles)
        return _marks(plane, paths)

    svg = drawing(plot, f"S-N line of {brief(part.name, 40)} and its duty", 230.0)
    columns, rows = _table(data, cycles)
    caption = _caption(data, cycles, check)
    return Chart("sn", _TITLE, caption, svg, columns, rows, series if paths else ())


def _with_infinite(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """The data with infinite damages for those that plain data cannot hold."""
    if not data.get("state"):
        return data
    cycles = [[n, size, _or_infinite(harm), up] for n, size, harm, up in data["cycles"]]
    damages = {name: _or_infinite(data[name]) for name in ("damage", "left_damage")}
    return {**data, "cycles": cycles, **damages}


def _or_infinite(damage: float | None) -> float:
    return inf if damage is None else damage


def _paths(
    haigh: Mapping[str, Any], data: Mapping[str, Any], result: DesignResult
) -> dict[int, tuple[float, FloatArray]]:
    """Cycle -> how often it runs, and the fully reversed amplitude (n,) of every position."""
    found = {}
    for k, (name, cycle) in enumerate(result.cycles.items()):
        path, count = path_of(haigh, name), float(cycle.get("duty") or 0.0)
        if path is None or not count > 0:
            continue
        found[k] = (count, reversed_amplitude(haigh, data, path))
    return found


def reversed_amplitude(
    haigh: Mapping[str, Any], data: Mapping[str, Any], path: FloatArray
) -> FloatArray:
    """Fully reversed amplitudes (n,), MPa, that use as much as points (n, 2) of the diagram.

    By Goodman s_a / (1 - s_m / S_u), infinite at the ultimate strength; by FKM in proportion to the
    utilisation.
    """
    if haigh.get("line"):
        return utilisation(haigh, path) * float(data["limit"])
    return equivalent_amplitude(path[:, 1], path[:, 0], float(data["ultimate"]))


def _plane(figure: Drawing, data: Mapping[str, Any], cycles: FloatArray) -> Plane:
    limit = float(data["limit"])
    tops = [limit, *(amplitude for _, amplitude in data["line"])]
    shown = cycles[cycles[:, 1] >= _LEAST * limit]
    raised = shown[np.isfinite(shown[:, 3])]
    low = min([0.45 * limit, *(0.7 * raised[:, 1]).tolist()])
    high = 1.35 * max([*tops, *raised[:, 3].tolist()])
    ends = [n for n, _ in data["line"]]
    first = min([_FIRST, *ends, *(0.5 * shown[:, 0]).tolist()])
    last = max([_LAST, *(8 * n for n in ends), *(8 * shown[:, 0]).tolist()])
    plane = Plane(figure, (max(first, 0.5), last), (low, high), logarithmic="xy")
    plane.titles("cycles in the life [–]", "fully reversed stress amplitude [MPa]")
    ticks = _log_ticks(low, high)
    plane.frame.y_ticks = [(tick, f"{tick:g}") for tick in ticks]
    tens = range(int(np.ceil(np.log10(plane.frame.across[0]))), int(np.log10(last)) + 1)
    shown_tens = [k for k in tens if k % (2 if len(tens) > 9 else 1) == 0]
    plane.frame.x_ticks = [(10.0**k, _ten(k)) for k in shown_tens]
    return plane


def times(count: float) -> str:
    """A number of cycles: 1.1·10⁷.

    >>> times(1.1e7), times(1e6), times(1250.0)
    ('1.1·10⁷', '10⁶', '1250')
    """
    if count < 1e4:
        return f"{count:.4g}"
    digits, _, power = f"{count:.2e}".partition("e")
    digits = digits.rstrip("0").rstrip(".")
    return ("" if digits == "1" else f"{digits}·") + _ten(int(power))


def _ten(power: int) -> str:
    return "10" + "".join("⁰¹²³⁴⁵⁶⁷⁸⁹"[int(digit)] for digit in str(power))


def _log_ticks(low: float, high: float) -> list[float]:
    """Round numbers on a logarithmic axis."""
    tens = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    wide = high / low > 30
    found = [step * 10.0**k for k in tens for step in ((1, 3) if wide else (1, 2, 3, 5, 7))]
    return [value for value in found if low <= value <= high]


def _lines(plane: Plane, data: Mapping[str, Any]) -> None:
    limit, (_, last) = float(data["limit"]), plane.frame.across
    strong: dict[str, Any] = {"color": SERIES[0], "linewidth": 1.8}
    line = data["line"]
    start = line[-1][0] if line else plane.frame.across[0]
    endless = bool(data["endless"])
    if line:
        upper = plane.line(line, **strong)
        plane.name("S-N line", upper, SERIES[0], prefer=0.4, weight="bold")
    if endless or not line:
        level = plane.line([[start, limit], [last, limit]], **strong)
        plane.name(_limit_name(data), level, SERIES[0], prefer=0.8, weight="bold")
    if data["below"]:
        below = plane.line(data["below"], color=SERIES[0], linewidth=1.4, linestyle=(0, (1.5, 1.5)))
        if endless:
            plane.name("where larger cycles do damage", below, SERIES[0], prefer=0.5)
        else:
            plane.line([[start, limit]], color=SERIES[0], marker="o", markersize=5)
            plane.name(_limit_name(data), [[start, limit]], SERIES[0], weight="bold")


def _limit_name(data: Mapping[str, Any]) -> str:
    """Name of the limit: for a metal whose line goes on below its knee, the strength at its end."""
    if data["endless"] or not data["line"]:
        return "endurance limit"
    return f"strength at {times(float(data['line'][-1][0]))} cycles"


def _duty(plane: Plane, data: Mapping[str, Any], cycles: FloatArray) -> None:
    """Every kind of cycle as a point, and above it how high the required safety lifts it."""
    low, high = plane.frame.up
    shown = cycles[(cycles[:, 1] >= low) & (cycles[:, 1] <= high)]
    damage = float(data["damage"] or 0.0)
    most = _MARKED * damage if isfinite(damage) else np.finfo(float).max
    bad = shown[:, 2] > most if damage else np.zeros(len(shown), dtype=bool)
    for points, tint, mark in ((shown[~bad], SERIES[4], "o"), (shown[bad], SERIES[1], "D")):
        for n, amplitude, _, raised in points:
            top = min(raised, high) if np.isfinite(raised) else high
            plane.line([[n, amplitude], [n, top]], color=tint, linewidth=1.2)
            plane.line([[n, top]], crossed=True, color=tint, marker="_", markersize=9,
                       markeredgewidth=2)  # fmt: skip
        if len(points):
            plane.line(points[:, :2], crossed=True, color=tint, marker=mark, markersize=6,
                       linestyle="", markerfacecolor="none" if mark == "o" else tint,
                       markeredgewidth=1.5)  # fmt: skip
            plane.avoid(points[:, :2], 5.0)
    if not len(cycles):
        return
    _name_worst(plane, data, shown if len(shown) else cycles, below=not len(shown))


def _name_worst(plane: Plane, data: Mapping[str, Any], cycles: FloatArray, *, below: bool) -> None:
    """Label the most damaging cycle: number, amplitude, and effect of the required safety."""
    worst = cycles[int(np.lexsort((cycles[:, 1], cycles[:, 2]))[-1])]
    text = f"{times(float(worst[0]))} × {number(worst[1])} MPa"
    if data["damage"]:
        text += f", damage {_damage(float(worst[2]))}"
    at = [float(worst[0]), float(worst[1])]
    if below:
        at[1] = plane.frame.up[0] * 1.04
        plane.line([at], crossed=True, color=ink(), marker="v", markersize=6)
        text += ", below the chart"
    elif data["required"] != 1 and np.isfinite(worst[3]):
        plane.avoid([[at[0], float(worst[3])]], 4.0)
        plane.name(f"loads × {need_text(data['required'])}", [[at[0], float(worst[3])]], ink())
    plane.name(text, [at], SERIES[1] if worst[2] > 0 else ink(), weight="bold")


def _damage(value: float) -> str:
    """A damage; what no duty could sum up to anything is not written with all its zeros."""
    if not isfinite(value):
        return "beyond the curve"
    return number(value) if value >= _NOTHING or not value else "below 10⁻⁹"


def _marks(plane: Plane, paths: Mapping[int, tuple[float, FloatArray]]) -> dict[str, str]:
    dots, rows = [], []
    low, high = plane.frame.up
    for cycle, (count, amplitude) in paths.items():
        finite = np.where(np.isfinite(amplitude), amplitude, high)
        at = thinned(finite, 1e-3 * (float(finite.max()) or 1.0))
        kept = finite[at]
        places = plane.frame.places([[count, np.clip(value, low, high)] for value in kept])
        dots.append({
            "cycle": cycle, "at": at.tolist(),
            "x": np.round(places[:, 0], 1).tolist(), "y": np.round(places[:, 1], 1).tolist(),
        })  # fmt: skip
        shown = [round(float(v), 2) for v in kept]
        rows.append({"cycle": cycle, "row": 0, "at": at.tolist(), "value": shown})
    return {"data-cursor": cursor_text({"dots": dots, "rows": rows})} if dots else {}


def _caption(data: Mapping[str, Any], cycles: FloatArray, check: Check | None) -> str:
    told, name = [], _limit_name(data)
    if data["why"]:
        told.append(f"{data['why'][0].upper()}{data['why'][1:]}. Shown is the {name}.")
    elif data["damage"] is None:
        told.append("The guideline's line of the component; each point is the largest swing of a "
                    "cycle of the duty.")  # fmt: skip
    elif not isfinite(data["damage"]):
        told.append("A cycle of the life is beyond the curve: it reaches the ultimate strength.")
    elif data["damage"]:
        allowed = number(data["allowed"])
        told.append(f"Miner's sum of the life is {_damage(data['damage'])}, allowed {allowed}.")
    else:
        told.append(f"No cycle exceeds the {name}, so Miner's sum is 0.")
    if data["asked"] == "infinite":
        told.append(f"The check asks for infinite life: the {name} decides, not the line.")
    else:
        safety = f": safety {safety_text(check.safety)} on all loads" if check else ""
        told.append(f"The check asks for a finite life{safety}.")
    lowered = limit_told(data, float(data["limit"]))
    if lowered:
        told.append(f"The {name} is lowered {LOWERED}: {lowered}.")
    small = int((cycles[:, 1] < _LEAST * float(data["limit"])).sum())
    left = float(data["left_out"])
    if small or left:
        kinds = "kind of cycle is" if small == 1 else "kinds of cycles are"
        many = f" {small} {kinds} too small for the chart." if small else ""
        more = f" Another {times(left)} cycles do a damage of {_damage(data['left_damage'])}."
        told.append((many + (more if left else "")).strip())
    return " ".join(told)


def _table(data: Mapping[str, Any], cycles: FloatArray) -> tuple[list[str], list[list[str]]]:
    columns = ["what", "cycles", "amplitude, fully reversed [MPa]",
               f"with all loads × {need_text(data['required'])} [MPa]", "damage"]  # fmt: skip
    end = "no end" if data["endless"] else "–"
    rows = [[_limit_name(data), end, _mpa(data["limit"]), "–", "–"]]
    for points, text in ((data["line"], "S-N line"), (data["below"], "below the knee")):
        rows += [[text, times(n), _mpa(s), "–", "–"] for n, s in points]

    def told(harm: float) -> str:
        return "–" if data["damage"] is None else _damage(harm)

    rows += [
        ["duty", times(n), _mpa(s), _mpa(raised), told(harm)]
        for n, s, harm, raised in cycles[:_ROWS].tolist()
    ]
    if data["damage"] is not None:
        count = times(float(cycles[:, 0].sum()) + data["left_out"])
        rows.append(["sum", count, "–", "–", told(data["damage"])])
    return columns, rows


def _mpa(value: float) -> str:
    if not np.isfinite(value):
        return "beyond the ultimate strength"
    return fixed(float(value), max(1, decimals_of(float(value))))
