"""Convergence of the governing stress from mesh to mesh, and the band in which it is known."""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

from checks.result.verdict import Check, PartResult
from checks.result.words import brief, number
from reports.charts.chart import Chart, Missing, decimals_of, fixed
from reports.charts.plane import Plane, drawing, ink
from reports.svg import SERIES, Drawing, colour

_TITLE = "Convergence of the governing stress"
_WORDS = {"static": "peak von Mises stress", "fatigue": "amplitude of equal safety"}
_WHOLE = ("the part", "half of the part")  # by whether a mesh is half of it
_ROOM = 0.004  # of the value, that the axis shows at least


def convergence_chart(part: PartResult) -> Chart | Missing:
    """Value against unknowns with its bars; the last one's bar goes on as a band."""
    data: Mapping[str, Sequence[Mapping[str, Any]]] = part.charts.get("convergence") or {}
    if not data:
        return Missing("convergence", _TITLE, _why_not(part))
    checks = {kind: _check(part, kind, entries) for kind, entries in data.items()}
    kind = max(data, key=lambda k: _use(part, k))
    entries, check = data[kind], checks[kind]

    def plot(figure: Any) -> None:
        _draw(figure, kind, entries, _bars(entries, check), check)

    svg = drawing(plot, f"Convergence of the {kind} stress of {brief(part.name, 40)}", 202.0)
    columns = [
        "check",
        "mesh of",
        "unknowns",
        "value [MPa]",
        "± numerical [MPa]",
        "change by the mesh",
    ]
    rows = []
    for name, meshes in data.items():
        own = _bars(meshes, checks[name])
        for k, (mesh, bar) in enumerate(zip(meshes, own, strict=True)):
            before = meshes[k - 1]["value"] if k else None
            change = "–" if not before else f"{fixed(100 * (mesh['value'] / before - 1), 2)} %"
            rows.append(
                [
                    name,
                    _WHOLE[_half(mesh)],
                    f"{mesh['unknowns']:d}",
                    number(mesh["value"], 5),
                    _bar(bar),
                    change,
                ]
            )
    return Chart("convergence", _TITLE, _caption(kind, entries, check), svg, columns, rows)


def _check(part: PartResult, kind: str, entries: Sequence[Mapping[str, Any]]) -> Check | None:
    """The part's check that tells of the last mesh; None where a cheaper model's stands."""
    value = float(entries[-1]["value"])
    for check in part.checks:
        if check.kind == kind and check.method.startswith("solid"):
            return check if abs(check.value - value) <= 1e-6 * value else None
    return None


def _half(entry: Mapping[str, Any]) -> bool:
    """Return True if an entry's mesh is half of the part, cut at its plane of symmetry."""
    return bool(entry.get("half"))


def _use(part: PartResult, kind: str) -> float:
    """The largest utilisation of a kind of check; a check by the solid comes first."""
    found = [c for c in part.checks if c.kind == kind]
    return max((c.utilisation + 1e3 * c.method.startswith("solid") for c in found), default=0.0)


def _bars(entries: Sequence[Mapping[str, Any]], check: Check | None) -> list[float | None]:
    """Half the numerical bar of every mesh; the last one takes its check's bar."""
    bars = [None if entry["bar"] is None else float(entry["bar"]) for entry in entries]
    return bars if check is None else [*bars[:-1], check.numerical]


def _draw(
    figure: Drawing, kind: str, entries: Sequence[Mapping[str, Any]], bars: list[float | None],
    check: Check | None,
) -> None:  # fmt: skip
    unknowns = [float(entry["unknowns"]) for entry in entries]
    values = [float(entry["value"]) for entry in entries]
    finite = [bar if bar is not None and isfinite(bar) else 0.0 for bar in bars]
    ends = [v - b for v, b in zip(values, finite, strict=True)]
    ends += [v + b for v, b in zip(values, finite, strict=True)]
    least, most = min(ends), max(ends)
    room = max(0.18 * (most - least), _ROOM * most)
    first, last = min(unknowns) / 1.35, max(unknowns) * 1.8
    plane = Plane(figure, (first, last), (least - room, most + 1.4 * room), logarithmic="x")
    halves = [_half(entry) for entry in entries]
    of_all = f", of {_WHOLE[True]}" if all(halves) else ""
    plane.titles(f"unknowns of the mesh{of_all} [–]", f"{_WORDS.get(kind, kind)} [MPa]")
    ticks = sorted({unknowns[0], unknowns[-1]}) if len(unknowns) < 4 else unknowns[::2]
    plane.frame.x_ticks = [(tick, f"{tick:,.0f}".replace(",", "\u2009")) for tick in ticks]
    final = finite[-1]
    if final:
        band = (values[-1] - final, values[-1] + final)
        plane.frame.area((unknowns[-1], last), band, SERIES[0], 0.22)
        plane.name(f"± {number(final, 2)} MPa", [[unknowns[-1] * 1.15, values[-1] + final],
                   [last, values[-1] + final]], SERIES[0], prefer=0.6)  # fmt: skip
    plane.line([[unknowns[-1], values[-1]], [last, values[-1]]], color=SERIES[0], linewidth=1.4,
               linestyle=(0, (1.5, 1.5)))  # fmt: skip
    plane.line(list(zip(unknowns, values, strict=True)), color=SERIES[0], linewidth=1.7)
    for x, value, bar in zip(unknowns, values, finite, strict=True):
        if bar:
            plane.line([[x, value - bar], [x, value + bar]], color=ink(), linewidth=1.2, marker="_",
                       markersize=9)  # fmt: skip
        plane.line([[x, value]], color=SERIES[0], marker="o", markersize=6.5)
        plane.avoid([[x, value]])
    for x, value, half in zip(unknowns, values, halves, strict=True):
        told = f", {_WHOLE[True]}" if half and not all(halves) else ""
        plane.name(f"{number(value, 4)}{told}", [[x, value]], SERIES[0], weight="bold")
    allowed = None if check is None else check.limit / check.required
    if allowed is not None and plane.frame.up[0] < allowed < plane.frame.up[1]:
        line = plane.line([[first, allowed], [last, allowed]], color=colour("fail"), linewidth=1.5)
        plane.name(f"allowed {number(allowed)} MPa", line, colour("fail"), prefer=0.1)


def _caption(kind: str, entries: Sequence[Mapping[str, Any]], check: Check | None) -> str:
    told = ["Bars: numerical error; the last one's band goes on to the right.",
            "The first mesh has no bar: it takes two to tell.",
            "The axis does not begin at 0."]  # fmt: skip
    if check is None:
        told.append(
            f"The verdict takes the {kind} stress from a cheaper model; this one was solved beside "
            "it, and its bar leaves out what the bearing pressures add."
        )
    elif not isfinite(check.numerical):
        told.append("The last mesh's bar is infinite: the stress is singular there.")
    elif check.value:
        told.append(
            f"The last step changed it by "
            f"{fixed(100 * abs(entries[-1]['value'] / (entries[-2]['value'] or 1) - 1), 2)} %; "
            f"the bar is {fixed(100 * check.numerical / check.value, 2)} %."
        )
    return " ".join(told)


def _bar(bar: float | None) -> str:
    if bar is None:
        return "–"
    return fixed(bar, max(1, decimals_of(bar))) if isfinite(bar) else "∞"


def _why_not(part: PartResult) -> str:
    if not part.meshes:
        methods = dict.fromkeys(brief(c.method, 40) for c in part.checks if c.kind == "static")
        return f"no mesh was solved: its stress is by {', '.join(methods) or 'no model'}"
    if len(part.meshes) == 1:
        return "one mesh alone was solved, which shows no convergence"
    return "the result does not have the values of its meshes"
