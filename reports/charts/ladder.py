"""The models that were tried for a part: what each said, with its bar, against the time it took."""

from collections.abc import Sequence
from math import inf, isfinite

from checks.result.verdict import Check, PartResult, RungTried
from checks.result.words import brief, check_titles, number, value_and_whole_bar
from reports.charts.chart import Chart, Missing, decimals_of, fixed
from reports.charts.plane import Plane, drawing, ink
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
