"""Haigh's diagram of a part: where its critical point stands, and how the cycle gets it there."""

from collections.abc import Mapping, Sequence
from math import hypot, isfinite
from typing import Any

import numpy as np

from checks.result.verdict import Check, DesignResult, PartResult
from checks.result.words import brief, need_text, number, safety_text
from fatigue import goodman_utilisation
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
    upper,
)
from reports.charts.over_cycle import cursor_text
from reports.svg import SERIES, Drawing

_TITLE = "Haigh diagram"
_ROWS = 13
_ALIKE = 1e-3  # of a limit: what differs by less is the same
LOWERED = "by the notch or fretting factor at this place"
SWING = "the swing from the least stressed state to this position"
_RULES = {"Findley": "Findley's plane", "Miner": "Miner's sum", "FKM": "the FKM guideline"}


def haigh_chart(part: PartResult, result: DesignResult) -> Chart | Missing:
    """The diagram by the rule in use: Goodman's line, or the FKM guideline's."""
    data = part.charts.get("haigh") or part.charts.get("fkm")
    if not data:
        return Missing("haigh", _TITLE, "no cycle of the duty loads this part")
    check = next((c for c in part.checks if c.kind == "fatigue"), None)
    rule = "FKM" if data.get("criterion") == "FKM" else "Goodman"
    limit = limit_line(data)
    paths = {
        k: points
        for k, name in enumerate(result.cycles)
        if (points := path_of(data, name)) is not None
    }
    point = np.array([float(data["mean"]), float(data["amplitude"])])
    used = utilisation(data, point[None])[0]
    series = [
        Series(f"amplitude of {SWING}", "MPa", decimals=1),
        Series("its mean", "MPa", decimals=1),
        Series(f"its share of {rule}'s line", "", decimals=3),
    ]

    def plot(figure: Drawing) -> dict[str, str]:
        plane = _plane(figure, data, limit, point)
        _lines(plane, data, limit, rule, check)
        _points(plane, data, point, _safety_told(data, used, check), list(paths.values()))
        return _marks(plane, data, paths)

    label = f"Haigh diagram of {brief(part.name, 40)}"
    svg = drawing(plot, label, 245.0)
    columns, rows = _table(data, point, used, result)
    caption = _caption(data, check, rule, used)
    return Chart("haigh", _TITLE, caption, svg, columns, rows, series if paths else ())


def limit_line(data: Mapping[str, Any]) -> FloatArray:
    """Limit line of infinite life, (k, 2) mean and amplitude in MPa."""
    if data.get("line"):
        return np.array(data["line"], dtype=float)
    return np.array([[0.0, data["endurance"]], [data["ultimate"], 0.0]], dtype=float)


def limit_told(data: Mapping[str, Any], limit: float) -> str:
    """An endurance limit as a quotient of the one away from notches, MPa; "" if they are equal."""
    away = float(data.get("away") or limit)
    if not limit < (1.0 - _ALIKE) * away:
        return ""
    return f"{number(away)} MPa / {away / limit:.3g} = {number(limit)} MPa"


def utilisation(data: Mapping[str, Any], points: FloatArray) -> FloatArray:
    """Utilisation (n,) of points (n, 2) by the diagram's line, stresses in proportion."""
    mean, amplitude = np.maximum(points[:, 0], 0.0), points[:, 1]
    if not data.get("line"):
        endurance, ultimate = float(data["endurance"]), float(data["ultimate"])
        return goodman_utilisation(amplitude, mean, endurance, ultimate)
    line = limit_line(data)
    ratio = line[:, 0] / line[:, 1]  # mean over amplitude, which is the same along a ray
    own = np.divide(mean, amplitude, out=np.full(len(mean), ratio[-1]), where=amplitude > 0)
    growth = np.interp(own, ratio, data["endurance"] / line[:, 1])
    return np.asarray(amplitude * growth / data["endurance"])


def path_of(data: Mapping[str, Any], cycle: str) -> FloatArray | None:
    """Mean and amplitude (n, 2) of every position of a cycle, None where it is not judged."""
    path = (data.get("paths") or {}).get(cycle)
    if not path:
        return None
    return np.stack([numbers(path["mean"]), numbers(path["amplitude"])], axis=1)


def _plane(figure: Drawing, data: Mapping[str, Any], limit: FloatArray, point: FloatArray) -> Plane:
    cloud = _cloud(data)
    across = max(float(data["yield"]), float(point[0]), *cloud[:, 0].tolist(), 0.0)
    if not data.get("line"):
        across = max(across, float(data["ultimate"]))
    up = upper([float(limit[0, 1]), float(point[1]), *cloud[:, 1].tolist()], 1.18)
    plane = Plane(figure, (0.0, 1.04 * across), (0.0, up))
    plane.titles("mean stress [MPa]", "stress amplitude [MPa]")
    return plane


def _cloud(data: Mapping[str, Any]) -> FloatArray:
    return numbers(data.get("cloud")).reshape(-1, 2)


def _lines(
    plane: Plane, data: Mapping[str, Any], limit: FloatArray, rule: str, check: Check | None
) -> None:
    strength = float(data["yield"])
    plain: dict[str, Any] = {"color": SERIES[0], "linewidth": 1.8}
    plane.line(limit, **plain)
    named = [(rule, limit, SERIES[0])]
    if check is not None and check.required != 1:
        needed = limit / check.required
        plane.line(needed, linestyle=(0, (6, 2)), **plain)
        named.append((f"{rule} / {need_text(check.required)}", needed, SERIES[0]))
    yielding = plane.line(
        [[0, strength], [strength, 0]],
        color=SERIES[6],
        linewidth=1.5,
        linestyle=(0, (7, 2, 1.5, 2)),
    )
    named.append(("first yield", yielding, SERIES[6]))
    for text, line, tint in named:
        plane.name(text, line, tint, prefer=0.72, weight="bold")


def _decider(data: Mapping[str, Any]) -> str:
    """The criterion that decides where it is not the diagram's own, else ""."""
    criterion = str(data.get("criterion"))
    return criterion if criterion in _RULES and criterion != "FKM" else ""


def _safety_told(data: Mapping[str, Any], used: float, check: Check | None) -> str:
    """The critical point's safety in this diagram, and the check's where another rule decides."""
    safety = f"safety {safety_text(1 / used if used else np.inf)}"
    other = _decider(data)
    if not other or check is None:
        return f"critical point, {safety}"
    return f"{safety} by Goodman ({other} decides: {safety_text(check.safety)})"


def _points(
    plane: Plane, data: Mapping[str, Any], point: FloatArray, safety: str, paths: list[FloatArray]
) -> None:
    used = float(utilisation(data, point[None])[0])
    cloud = _cloud(data)
    plane.dots(cloud, SERIES[4], 2.6)
    if used > 0 and isfinite(used):
        end = point / used
        plane.line([point, end], color=ink(), linestyle=":", linewidth=1.3)
        plane.line([end], crossed=True, color=ink(), marker="x", markersize=6)
    for path in paths:
        kept = thinned(path[:, 1], 0.003 * float(path[:, 1].max() or 1.0), None)
        plane.line(path[kept], color=SERIES[1], linewidth=1.5)
    plane.line([point], crossed=True, color=SERIES[1], marker="o", markersize=8)
    plane.avoid([point])
    plane.name(safety, [point], SERIES[1], weight="bold")
    if used > 0 and isfinite(used):
        plane.name("ray of all loads", [point, point / used], ink(), prefer=0.6)


def _marks(
    plane: Plane, data: Mapping[str, Any], paths: Mapping[int, FloatArray]
) -> dict[str, str]:
    dots: list[dict[str, Any]] = []
    rows: list[dict[str, Any]] = []
    for cycle, path in paths.items():
        size = float(path.max()) or 1.0
        keep = set(thinned(path[:, 0], 1e-3 * size).tolist())
        keep |= set(thinned(path[:, 1], 1e-3 * size).tolist())
        at = sorted(keep)
        kept = path[at]
        places = plane.frame.places(kept)
        dots.append({
            "cycle": cycle, "at": at,
            "x": np.round(places[:, 0], 1).tolist(), "y": np.round(places[:, 1], 1).tolist(),
        })  # fmt: skip
        for values, digits in (
            (kept[:, 1], 2), (kept[:, 0], 2), (utilisation(data, kept), 4),
        ):  # fmt: skip
            shown = [round(float(v), digits) for v in values]
            rows.append({"cycle": cycle, "row": len(rows) % 3, "at": at, "value": shown})
    if not dots:
        return {}
    return {"data-cursor": cursor_text({"dots": dots, "rows": rows})}


def _caption(data: Mapping[str, Any], check: Check | None, rule: str, used: float) -> str:
    told = ["Dots: the most used points of the part"]
    told[0] += ", brought to the critical point's strength." if data.get("line") else "."
    told.append(
        "Orange line: the swing from the least stressed state of the deciding pair to each "
        "position; it ends in the critical point."
    )
    told.append(f"The dotted ray shows how far all loads may grow: × {safety_text(1 / used)}."
                if used else "The point is not loaded.")  # fmt: skip
    lowered = limit_told(data, float(data["endurance"]))
    if lowered and rule == "Goodman":
        told.append(f"The line begins at the endurance limit, lowered {LOWERED}: {lowered}.")
    other = _decider(data)
    if check is not None and other:
        told.append(
            f"The check is decided by {_RULES[other]}, with a safety of "
            f"{safety_text(check.safety)}; this diagram shows what Goodman says of the same point."
        )
    elif check is not None and not check.method.startswith("solid"):
        told.append(f"Stress by {brief(check.method, 40)}; its error bars stand with the check.")
    return " ".join(told)


def _table(
    data: Mapping[str, Any], point: FloatArray, used: float, result: DesignResult
) -> tuple[list[str], list[list[str]]]:
    columns = ["point", "mean [MPa]", "amplitude [MPa]", "share of the line"]
    rows = [_row("critical point", point, used)]
    limit = limit_line(data)
    for text, at in (("line, reversed stress", limit[0]), ("line, end", limit[-1])):
        rows.append(_row(text, at, None))
    rows.append(_row("first yield, reversed stress", np.array([0.0, data["yield"]]), None))
    if used > 0:
        rows.append(_row("end of the ray", point / used, 1.0))
    cloud = _cloud(data)
    if len(cloud):
        worst = utilisation(data, cloud)
        for k in np.argsort(-worst, kind="stable")[: min(_ROWS, len(cloud))]:
            rows.append(_row("most used points", cloud[k], float(worst[k])))
    for name, cycle in result.cycles.items():
        path = path_of(data, name)
        if path is None:
            continue
        shown = numbers(cycle.get("position"))
        where = f"{brief(name, 24)}, {brief(cycle.get('shown_name', 'position'), 16)}"
        even = np.linspace(0, len(path) - 1, min(_ROWS, len(path))).round().astype(int)
        chosen = sorted({*even.tolist(), int(path[:, 1].argmax())})
        for k in chosen:
            value = f" = {number(shown[k], 4)}" if len(shown) == len(path) else f" no. {k}"
            at = path[k]
            rows.append(_row(where + value, at, float(utilisation(data, at[None])[0])))
    return columns, rows


def _row(name: str, point: Sequence[float] | FloatArray, used: float | None) -> list[str]:
    size = hypot(float(point[0]), float(point[1]))
    places = decimals_of(size / 10)
    share = "–" if used is None else fixed(used, 3)
    return [name, fixed(float(point[0]), places), fixed(float(point[1]), places), share]
