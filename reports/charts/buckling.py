"""A part among the column curves: stress against slenderness, in and out of its plane."""

from collections.abc import Callable, Mapping
from math import pi
from typing import Any

import numpy as np

from checks.handbook.column_curves import eurocode_stress, johnson_stress, transition_slenderness
from checks.result.verdict import DesignResult, PartResult
from checks.result.words import brief, need_text, number, safety_text
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
from reports.charts.over_cycle import cursor_text
from reports.svg import SERIES, Drawing, colour

_TITLE = "Buckling: column curves"
_N = 161
_MARKS = ("o", "^", "s", "D")

Curve = Callable[[float], float]


def buckling_chart(part: PartResult, result: DesignResult) -> Chart | Missing:
    """Yield, Johnson, Euler, a stated curve of Eurocode 3, and where the part stands."""
    data = part.charts.get("column")
    if not data:
        return Missing("buckling", _TITLE, _why_not(part))
    planes = data["planes"]
    series = [
        Series(f"axial compression, {p['plane']}", "MPa", decimals=_digits(p)) for p in planes
    ]
    forces = {
        k: numbers(data["force"][name])
        for k, name in enumerate(result.cycles)
        if name in data["force"]
    }

    def plot(figure: Drawing) -> dict[str, str]:
        plane = _plane(figure, data)
        _curves(plane, data)
        allowed = [float(one["limit"]) / float(data["required"]) for one in planes]
        for key in ("stress", "limit"):
            plane.avoid([[one["slenderness"], one[key]] for one in planes])
        plane.avoid([[one["slenderness"], v] for one, v in zip(planes, allowed, strict=True)])
        for k, one in enumerate(planes):
            _point(plane, one, data, k)
        return _marks(plane, planes, forces)

    svg = drawing(plot, f"Column curves of {brief(part.name, 40)}", 245.0)
    columns, rows = _table(data)
    return Chart("buckling", _TITLE, _caption(data), svg, columns, rows, series)


def column_curves(data: Mapping[str, Any]) -> dict[str, Curve]:
    """The limits by name: MPa as a function of the slenderness."""
    young, strength = float(data["youngs_modulus"]), float(data["yield"])
    transition = transition_slenderness(strength, young)

    def euler(slenderness: float) -> float:
        return pi**2 * young / slenderness**2

    def johnson(slenderness: float) -> float:
        if slenderness > transition:
            return float("nan")
        return johnson_stress(slenderness, strength, young)

    curves: dict[str, Curve] = {"yield": lambda _: strength, "Johnson": johnson, "Euler": euler}
    if data["curve"]:
        stated = str(data["curve"])
        curves[f"Eurocode 3 {stated}"] = lambda x: eurocode_stress(euler(x), strength, stated)
    return curves


def _plane(figure: Drawing, data: Mapping[str, Any]) -> Plane:
    transition = transition_slenderness(float(data["yield"]), float(data["youngs_modulus"]))
    own = max(float(p["slenderness"]) for p in data["planes"])
    top = max(float(data["yield"]), *(float(p["stress"]) for p in data["planes"]))
    plane = Plane(figure, (0.0, max(2.1 * transition, 1.25 * own)), (0.0, 1.18 * top))
    plane.titles("slenderness: effective length over radius of gyration [–]", "axial stress [MPa]")
    return plane


def _curves(plane: Plane, data: Mapping[str, Any]) -> None:
    strength, (_, top) = float(data["yield"]), plane.frame.up
    transition = transition_slenderness(strength, float(data["youngs_modulus"]))
    across = np.linspace(1e-3 * plane.frame.across[1], plane.frame.across[1], _N)
    across = np.unique(np.append(across, transition))
    styles: dict[str, dict[str, Any]] = {
        "yield": {"color": SERIES[6], "linestyle": (0, (7, 2, 1.5, 2)), "linewidth": 1.5},
        "Johnson": {"color": SERIES[2], "linewidth": 1.9},
        "Euler": {"color": SERIES[0], "linewidth": 1.9},
    }
    named = []
    for name, curve in column_curves(data).items():
        places = across[across <= transition] if name == "Johnson" else across
        points = np.array([[x, curve(float(x))] for x in places])
        points = points[points[:, 1] <= top]
        points = points[thinned(points[:, 1], 5e-4 * top, points[:, 0])]
        style = styles.get(name, {"color": SERIES[3], "linewidth": 2.0})
        if name == "Euler":
            hidden = points[points[:, 0] <= transition]
            plane.line(hidden, color=SERIES[0], linewidth=1.1, linestyle=(0, (1.5, 1.5)))
            points = points[points[:, 0] >= transition]
        named.append((name, plane.line(points, **style), style["color"]))
    plane.line([[transition, 0], [transition, strength / 2]], color=colour("faint"), linewidth=1.2)
    for name, points, tint in named:
        plane.name(name, points, tint, prefer=_PREFER.get(name, 0.45), weight="bold")
    plane.name(f"λ = {number(transition)}", [[transition, 0], [transition, strength / 8]], ink())


_PREFER = {"yield": 0.9, "Johnson": 0.75, "Euler": 0.25}


def _point(plane: Plane, one: Mapping[str, Any], data: Mapping[str, Any], index: int) -> None:
    at, stress, limit = (float(one[key]) for key in ("slenderness", "stress", "limit"))
    tint = SERIES[1]
    plane.line([[at, stress], [at, limit]], crossed=True, color=tint, linestyle=":", linewidth=1.3)
    if one["stiffest"] < at:
        plane.line([[one["stiffest"], stress], [at, stress]], crossed=True, color=tint,
                   linewidth=1.3, marker="|", markersize=7)  # fmt: skip
    plane.line([[at, stress]], crossed=True, color=tint, marker=_MARKS[index % len(_MARKS)],
               markersize=7.5)  # fmt: skip
    allowed = limit / float(data["required"])
    plane.line([[at, allowed]], crossed=True, color=colour("fail"), marker="_", markersize=13,
               markeredgewidth=2)  # fmt: skip
    text = f"{one['plane']}, safety {safety_text(limit / stress)}"
    plane.name(text, [[at, stress]], tint, weight="bold")


def _marks(
    plane: Plane, planes: list[Mapping[str, Any]], forces: Mapping[int, FloatArray]
) -> dict[str, str]:
    rows: list[dict[str, Any]] = []
    top = plane.frame.up[1]
    for cycle, force in forces.items():
        same: dict[float, int] = {}  # area -> row of its numbers
        for row, one in enumerate(planes):
            ends = [[one["slenderness"], v] for v in (0.0, top)]
            (x, bottom), (_, upper) = plane.frame.places(ends).round(1).tolist()
            scale = [0.0, bottom, round(top, 6), upper]
            made: dict[str, Any] = {"row": row, "x": x}
            if one["area"] in same:
                made["as"] = same[one["area"]]
            else:
                same[one["area"]] = len(rows)
                made |= {"cycle": cycle, "scale": scale, **_stresses(force, one)}
            rows.append(made)
    return {"data-cursor": cursor_text({"rows": rows})} if rows else {}


def _stresses(force: FloatArray, one: Mapping[str, Any]) -> dict[str, list[float]]:
    """Axial stress over a cycle, MPa, thinned; gaps count as no load."""
    stress = force / float(one["area"])
    finite = np.where(np.isfinite(stress), stress, 0.0)
    at = thinned(finite, 1e-3 * float(one["stress"]))
    digits = _digits(one) + 1
    return {"at": at.tolist(), "value": [round(float(finite[k]), digits) + 0.0 for k in at]}


def _digits(one: Mapping[str, Any]) -> int:
    return decimals_of(float(one["stress"]))


def _caption(data: Mapping[str, Any]) -> str:
    told = [
        f"Largest compression at {brief(data['cycle'], 40)}, {brief(data['position'], 60)}; the "
        f"dotted ray ends at the limit that judges, the red mark is what a safety of "
        f"{need_text(float(data['required']))} leaves."
    ]
    for one in data["planes"]:
        told.append(
            f"{one['plane'][0].upper()}{one['plane'][1:]}: {brief(one['law'], 40)}, "
            f"{brief(one['section'], 40)} over {number(one['length'], 4)} mm."
        )
    if any(one["stiffest"] < one["slenderness"] for one in data["planes"]):
        told.append("Bar: from ends that are hinged to ends that are as stiff as their forks.")
    told.append("The crooked bar with its bending has a check of its own.")
    return " ".join(told)


def _table(data: Mapping[str, Any]) -> tuple[list[str], list[list[str]]]:
    curves = column_curves(data)
    columns = ["slenderness", *(f"{name} [MPa]" for name in curves)]
    transition = transition_slenderness(float(data["yield"]), float(data["youngs_modulus"]))
    places = [(round(float(x), 6), "") for x in np.linspace(0.2, 2.1, 12) * transition]
    places.append((transition, " (transition)"))
    places += [(float(p["slenderness"]), f" ({p['plane']})") for p in data["planes"]]
    rows = [
        [number(x, 4) + text, *(fixed(curve(x), 1) for curve in curves.values())]
        for x, text in sorted(places)
    ]
    for one in data["planes"]:
        stress = float(one["stress"])
        cells = [fixed(curve(float(one["slenderness"])) / stress, 2) for curve in curves.values()]
        rows.append([f"safety {one['plane']} at {number(stress)} MPa", *cells])
    return columns, rows


def _why_not(part: PartResult) -> str:
    if not any(check.kind == "buckling" for check in part.checks):
        return "the part is no column: it has no sections, or nothing compresses it"
    return "it is never compressed between its ends, or has no sections: there is no column curve"
