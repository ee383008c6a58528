"""All checks of a result side by side: utilisation with its error bars, part by part."""

from collections.abc import Sequence
from math import isfinite
from typing import Any

from reports.charts.chart import SIZE, Chart
from reports.svg import colour, draw
from reports.verdict import Check, DesignResult, Status
from reports.words import (
    brief,
    check_titles,
    need_text,
    number,
    safety_text,
    utilisation_text,
    value_and_bars,
)

_TITLE = "Utilisation of all checks"
_STATUS_COLOUR = {Status.PASS: "pass", Status.FAIL: "fail", Status.UNDECIDED: "undecided"}
_LONGEST_AXIS = 4.0  # utilisations beyond are cut off and written beside their bar
_ROW, _LETTER, _TOP, _BOTTOM, _NUMBERS = 15.0, 4.9, 20.0, 34.0, 44.0  # points
_WIDEST = 36  # letters of a check's name
_COLUMNS = ("part", "check", "value", "± numerical", "± model", "limit", "safety (need)",
            "utilisation", "status")  # fmt: skip


def utilisation_chart(result: DesignResult) -> Chart | None:
    """All checks as bars with numerical and model error bars drawn apart; None without a check."""
    checks = result.checks
    if not checks:
        return None
    titles = check_titles(checks)
    ends = [c.utilisation + _scaled(c, c.numerical + c.model) for c in checks]
    end = min(_LONGEST_AXIS, max([1.25, *(u * 1.06 for u in ends if isfinite(u))]))
    lines = _lines(checks, titles)

    def plot(figure: Any) -> None:
        _draw(figure, lines, end, result.deciding)

    height = (_TOP + _BOTTOM + _ROW * len(lines)) / 72.0
    svg = draw(plot, (SIZE[0], height), _TITLE, layout=None)
    rows = [_cells(check, title) for check, title in zip(checks, titles, strict=True)]
    caption = (
        "Bar: value × required safety / limit. Thick line: numerical error; thin line: the model's "
        "beyond it. The red line is the limit; the check with the arrow decides."
    )
    if any(not isfinite(top) for top in ends):
        caption += " Dotted: the error bar is infinite."
    if any(check.utilisation > end for check in checks):
        caption += f" Bars end at {end:.3g}; the number tells how far they go."
    return Chart("utilisation", _TITLE, caption, svg, _COLUMNS, rows)


def _lines(checks: Sequence[Check], titles: Sequence[str]) -> list[tuple[str, Check | None]]:
    """Lines of the chart: a part's name, then its checks."""
    lines: list[tuple[str, Check | None]] = []
    part: str | None = None
    for check, title in zip(checks, titles, strict=True):
        if check.part != part:
            part = check.part
            lines.append((brief(part, 40), None))
        lines.append((brief(title, _WIDEST), check))
    return lines


def _draw(
    figure: Any, lines: Sequence[tuple[str, Check | None]], end: float, deciding: Check
) -> None:
    wide, high = figure.get_figwidth() * 72.0, figure.get_figheight() * 72.0
    letters = max([12, *(len(text) for text, check in lines if check is not None)])
    left = 19.0 + _LETTER * letters
    frame = (left / wide, _BOTTOM / high, (wide - left - _NUMBERS) / wide,
             (high - _TOP - _BOTTOM) / high)  # fmt: skip
    axes = figure.add_axes(frame)
    axes.set_xlim(0, end)
    axes.set_ylim(len(lines) - 0.5, -0.5)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.tick_params(length=0, labelsize=9)
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("utilisation [–]", size=9.5)
    margin, indent = (points / (wide - left - _NUMBERS) for points in (-left, 9.0))
    place = axes.get_yaxis_transform()
    for row, (text, check) in enumerate(lines):
        if check is None:
            axes.text(margin, row, text, transform=place, va="center", size=9.5, weight="bold")
            continue
        bold = "bold" if check is deciding else "normal"
        axes.text(margin + indent, row, text, transform=place, va="center", size=9, weight=bold)
        if check is deciding:
            axes.text(margin, row, "▸", transform=place, va="center", size=9)
        _bar(axes, row, check, end)
    axes.axvline(1.0, color=colour("fail"), linewidth=1.6)
    axes.text(1.0, 1 + 5 / (high - _TOP - _BOTTOM), "limit", transform=axes.get_xaxis_transform(),
              ha="center", size=9, color=colour("fail"), weight="bold")  # fmt: skip


def _scaled(check: Check, bar: float) -> float:
    return bar * check.required / check.limit


def _bar(axes: Any, row: int, check: Check, end: float) -> None:
    ink, use = colour("ink"), check.utilisation
    status = colour(_STATUS_COLOUR[check.status])
    axes.barh(row, min(use, end), height=0.66, color=status, alpha=0.55, linewidth=0)
    numerical, model = _scaled(check, check.numerical), _scaled(check, check.model)
    known = isfinite(numerical + model)
    if known:
        # The whole bar first and thin, the numerical one over it and thick.
        below = _scaled(check, check.below)
        for under, over, width in (
            (numerical + below, numerical + model, 1.2),
            (numerical, numerical, 4.0),
        ):
            low, high = max(use - under, 0.0), min(use + over, end)
            if low < min(high, end):
                axes.plot([low, high], [row, row], color=ink, lw=width, solid_capstyle="butt")
        ends = [x for x in (use - numerical - below, use + numerical + model) if 0 < x < end]
        if numerical + model + below > 0:
            axes.plot(ends, [row] * len(ends), "|", color=ink, markersize=6)
    else:
        axes.plot([0, end], [row, row], color=ink, linewidth=1.2, linestyle=":")
        axes.plot(end, row, ">", color=ink, clip_on=False, markersize=4)
    text = utilisation_text(use) + ("" if known else " ±∞")
    axes.annotate(
        text, (1, row), xycoords=("axes fraction", "data"), xytext=(_NUMBERS - 3, 0),
        textcoords="offset points", va="center", ha="right", annotation_clip=False, color=ink,
        size=9,
    )  # fmt: skip


def _cells(check: Check, title: str) -> list[str]:
    value, numerical, model = value_and_bars(check)
    unit = f" {brief(check.unit, 12)}" if check.unit else ""
    safety = f"{safety_text(check.safety)} ({need_text(check.required)})"
    return [brief(check.part, 40), brief(title, 60), value + unit, numerical, model,
            number(check.limit) + unit, safety, utilisation_text(check.utilisation),
            str(check.status)]  # fmt: skip
