"""The safety that decides on a scale: its range by the error bars, and what it must show."""

from dataclasses import dataclass
from math import isfinite, log

from markupsafe import Markup

from checks.result.verdict import Check

_WIDTH, _HEIGHT = 100.0, 20.0
_LOWEST, _HIGHEST = 0.8, 1.25  # of the least and the largest that is shown: the ends of the scale
_FARTHEST = 4.0  # times the required safety: what lies beyond ends in an arrow


@dataclass(frozen=True)
class SafetyScale:
    """The scale as a picture without text, and where its labels stand.

    required  share of the width at which the required safety stands, percent
    """

    picture: Markup
    required: float


def safety_scale(check: Check) -> SafetyScale | None:
    """Draw a check's safety on a logarithmic scale; None for a part without load.

    Red is below the required safety, green above; the dot is the safety at the value, the line its
    range by the error bars, dotted where that has no end. Stretched to the width that it gets.
    """
    if not check.value:
        return None
    least = check.limit / check.upper if isfinite(check.upper) else 0.0
    most = check.limit / check.lower if check.lower > 0 else float("inf")
    need, has = check.required, check.safety
    top = _FARTHEST * need
    low = _LOWEST * min(need, has, least or need)
    high = _HIGHEST * max(need, min(has, top), min(most, top))

    def at(safety: float) -> float:
        return min(max(log(max(safety, low) / low) / log(high / low), 0.0), 1.0) * _WIDTH

    limit, middle = at(need), _HEIGHT / 2
    ends = at(least or low), at(min(most, high))
    drawn = [
        f'<rect class="short" x="0" y="5" width="{limit:.2f}" height="10"/>',
        f'<rect class="enough" x="{limit:.2f}" y="5" width="{_WIDTH - limit:.2f}" height="10"/>',
        f'<path class="range{"" if least else " endless"}" d="M{ends[0]:.2f} {middle:g}'
        f'H{ends[1]:.2f}"/>',
        "".join(f'<path class="end" d="M{x:.2f} 6V14"/>' for x in ends if 0 < x < _WIDTH),
        f'<path class="need" d="M{limit:.2f} 0V{_HEIGHT:g}"/>',
        f'<path class="has" d="M{at(has):.2f} {middle:g}h0"/>',
    ]
    if max(has, most if isfinite(most) else 0.0) > high:
        drawn.append(f'<path class="end" d="M{_WIDTH - 1.5:g} 6l1.4 4l-1.4 4"/>')
    picture = Markup(
        f'<svg class="safety-scale" viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" '
        f'preserveAspectRatio="none" aria-hidden="true">{"".join(drawn)}</svg>'
    )
    return SafetyScale(picture, round(limit, 2))
