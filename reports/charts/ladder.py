"""Answers of the models tried for a part over their time, and of a solid from mesh to mesh."""

from collections.abc import Mapping, Sequence
from math import inf, isfinite
from typing import Any

from checks.result.verdict import Check, PartResult, RungTried
from checks.result.words import brief, check_titles, number, value_and_whole_bar
from reports.charts.chart import Chart, Missing, Plane, decimals_of, drawing, fixed, ink
from reports.svg import SERIES, Drawing, colour

_TITLE = "Ladder of models"
_MARKERS = "os^Dv<>P"
_SHORTEST = 1e-3  # s: a logarithm needs more than 0
_LARGEST = 3.0  # utilisations beyond are cut off


def ladder_chart(part: PartResult) -> Chart | Missing:
    """Utilisation with its whole bar against the seconds of each rung, and which was chosen."""
    tried = [rung for rung in part.rungs if rung.checks]
    if not tried:
        return Missing("ladder", _TITLE, "no model was tried for this part")
    kinds = list(dict.fromkeys(check.kind for rung in tried for check in rung.checks))

    def plot(figure: Drawing) -> None:
        _draw(figure, part, tried, kinds)

    svg = drawing(plot, f"Ladder of models of {brief(part.name, 40)}", 216.0)
    columns, rows = _table(part)
    return Chart("ladder", _TITLE, _caption(part, tried), svg, columns, rows)


def _draw(figure: Drawing, part: PartResult, tried: Sequence[RungTried], kinds: list[str]) -> None:
    times = [max(rung.seconds, _SHORTEST) for rung in tried]
    low, high = min(times) / 3, max(times) * 3
    if high / low < 100:
        low, high = low / 3, high * 3
    tops = [_ends(check)[1] for rung in tried for check in rung.checks]
    top = min(_LARGEST, max([1.3, *(1.22 * t for t in tops if isfinite(t))]))
    plane = Plane(figure, (low, high), (0.0, top), logarithmic="x")
    plane.titles("time [s]", "utilisation, with its whole error bar [–]")
    tens = [10.0**k for k in range(-5, 7) if low <= 10.0**k <= high]
    plane.frame.x_ticks = [(ten, f"{ten:g}") for ten in tens]
    plane.line([[low, 1.0], [high, 1.0]], color=colour("fail"), linewidth=1.6)
    plane.name("limit", [[low, 1.0], [high, 1.0]], colour("fail"), prefer=0.02)
    for rung, seconds in zip(tried, times, strict=True):
        at = plane.at([[seconds, 0.0]])[0]
        text = f"{brief(rung.rung, 16)} {_time(rung)}"
        place = plane.room.put(text, plane.at([[seconds, top * 0.93], [seconds, top * 0.97]]))
        if place is not None:
            plane.write(text, place, weight="bold")
        shift = 9.0
        for check in rung.checks:
            k = kinds.index(check.kind)
            offset = (k - (len(kinds) - 1) / 2) * shift
            _one(plane, seconds, at[0] + offset, check, k, chosen=_chosen(part, rung, check))
    for k, kind in enumerate(kinds):
        first = next((r, c) for r in tried for c in r.checks if c.kind == kind)
        seconds = max(first[0].seconds, _SHORTEST)
        x = _moved(plane, seconds, (k - (len(kinds) - 1) / 2) * 9.0)
        use = min(first[1].utilisation, top)
        plane.name(brief(kind, 20), [[x, use]], SERIES[k % len(SERIES)], weight="bold")


def _moved(plane: Plane, seconds: float, points: float) -> float:
    """A time some points further right, so that kinds do not stand on each other."""
    first, last = plane.frame.across
    return float(seconds * (last / first) ** (points / plane.room.width))


def _one(
    plane: Plane, seconds: float, across: float, check: Check, k: int, *, chosen: bool
) -> None:
    """A check of a rung: its value, its bar, and a ring if the verdict takes it."""
    tint = SERIES[k % len(SERIES)]
    x = _moved(plane, seconds, across - float(plane.at([[seconds, 0.0]])[0][0]))
    top = plane.frame.up[1]
    low, high = _ends(check)
    if isfinite(high):
        plane.line([[x, low], [x, min(high, top)]], color=tint, marker="_", markersize=7,
                   linewidth=1.4)  # fmt: skip
    else:
        plane.line([[x, 0.0], [x, top]], color=tint, linestyle=":", linewidth=1.3)
    use = min(check.utilisation, top)
    plane.line([[x, use]], color=tint, marker=_MARKERS[k % len(_MARKERS)], markersize=6.5)
    plane.avoid([[x, use]], 5.0)
    if chosen:
        plane.line([[x, use]], color=ink(), marker="o", markersize=13, markerfacecolor="none",
                   markeredgewidth=1.3)  # fmt: skip


def _ends(check: Check) -> tuple[float, float]:
    """Lower and upper end of a check's whole bar, as utilisations; infinite without one."""
    if not (isfinite(check.upper) and isfinite(check.lower)):
        return 0.0, inf
    share = check.required / check.limit
    return max(0.0, check.lower * share), check.upper * share


def _chosen(part: PartResult, rung: RungTried, check: Check) -> bool:
    """Return True if the part's verdict takes this check of this rung."""
    return any(
        own.kind == check.kind
        and own.method.split(" ")[0] == rung.rung
        and abs(own.value - check.value) <= 1e-9 * max(own.value, check.value)
        for own in part.checks
    )


def _caption(part: PartResult, tried: Sequence[RungTried]) -> str:
    told = ["Ring: what the verdict takes, the narrowest error bar of its kind."]
    last = tried[-1]
    told.append(f"{brief(last.rung, 24)}, the last: {brief(last.why, 300)}.")
    skipped = [rung for rung in part.rungs if not rung.checks]
    told += [f"Passed over: {brief(rung.rung, 24)}, {brief(rung.why, 200)}." for rung in skipped]
    if any(not isfinite(_ends(check)[1]) for rung in tried for check in rung.checks):
        told.append("Dotted: no error bar.")
    if any(check.utilisation > _LARGEST for rung in tried for check in rung.checks):
        told.append(f"Utilisations above {_LARGEST:g} are drawn at the top.")
    return " ".join(told)


def _time(rung: RungTried) -> str:
    return f"{number(rung.seconds, 2)} s"


def _table(part: PartResult) -> tuple[list[str], list[list[str]]]:
    columns = ["model", "time", "unknowns", "check", "value ± bar", "allowed", "utilisation",
               "taken", "why it stopped or went on"]  # fmt: skip
    rows = []
    for rung in part.rungs:
        if not rung.checks:
            rows.append([rung.rung, "–", "–", "–", "passed over", "–", "–", "–", rung.why])
        titles = check_titles(rung.checks)
        for check, title in zip(rung.checks, titles, strict=True):
            value, bar = value_and_whole_bar(check)
            places = max(2, decimals_of(check.utilisation))
            rows.append([
                rung.rung, _time(rung), f"{rung.unknowns:d}", title,
                f"{value} {bar} {check.unit}".strip(),
                f"{number(check.limit / check.required)} {check.unit}".strip(),
                fixed(check.utilisation, places), "yes" if _chosen(part, rung, check) else "no",
                rung.why,
            ])  # fmt: skip
    return columns, rows


# Convergence of the governing stress from mesh to mesh, and the band in which it is known.
_CONVERGENCE = "Convergence of the governing stress"
_WORDS = {"static": "peak von Mises stress", "fatigue": "amplitude of equal safety"}
_WHOLE = ("the part", "half of the part")  # by whether a mesh is half of it
_ROOM = 0.004  # of the value, that the axis shows at least


def convergence_chart(part: PartResult) -> Chart | Missing:
    """Value against unknowns with its bars; the last one's bar goes on as a band."""
    data: Mapping[str, Sequence[Mapping[str, Any]]] = part.charts.get("convergence") or {}
    if not data:
        return Missing("convergence", _CONVERGENCE, _why_not(part))
    checks = {kind: _check(part, kind, entries) for kind, entries in data.items()}
    kind = max(data, key=lambda k: _use(part, k))
    entries, check = data[kind], checks[kind]

    def plot(figure: Any) -> None:
        _draw_meshes(figure, kind, entries, _bars(entries, check), check)

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
    caption = _caption_of_meshes(kind, entries, check)
    return Chart("convergence", _CONVERGENCE, caption, svg, columns, rows)


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


def _draw_meshes(
    figure: Drawing, kind: str, entries: Sequence[Mapping[str, Any]], bars: list[float | None],
    check: Check | None,
) -> None:  # fmt: skip
    unknowns = [float(entry["unknowns"]) for entry in entries]
    values = [float(entry["value"]) for entry in entries]
    finite = [bar if bar is not None and isfinite(bar) else 0.0 for bar in bars]
    ends = [v - b for v, b in zip(values, finite, strict=True)]
    ends += [v + b for v, b in zip(values, finite, strict=True)]
    least, most = min(ends), max(ends)
    room = max(0.18 * (most - least), _ROOM * most) or 1.0  # of a part without load
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


def _caption_of_meshes(kind: str, entries: Sequence[Mapping[str, Any]], check: Check | None) -> str:
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
