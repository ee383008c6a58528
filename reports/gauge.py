"""A check's utilisation drawn as a bar with its error bars, small enough for a cell of a table."""

from dataclasses import dataclass, replace
from math import isfinite

from markupsafe import Markup

from checks.result.verdict import Check
from checks.result.words import clipped, safety_text

END = 1.3  # utilisation at the right end; what reaches further ends in an arrow
_UNIT = 100.0  # of the drawing, for a utilisation of 1
_WIDTH, _HEIGHT = END * _UNIT, 16.0
_MIDDLE = _HEIGHT / 2


def gauge(check: Check) -> Markup:
    """SVG of the bar: its length is the utilisation, the line across is the limit at 1.

    Thick is the numerical error bar, thin the model band beyond it; a bar without an end is dotted.
    It is stretched to the width that it gets, so that no text stands in it.
    """
    use = _at(check, check.value)
    drawn = [
        _line("track", 0.0, _WIDTH),
        f'<rect class="fill" y="3" width="{min(use, _WIDTH):.2f}" height="{_HEIGHT - 6:g}"/>',
        *_bars(check, use),
        f'<path class="limit" d="M{_UNIT:g} 0V{_HEIGHT:g}"/>',
    ]
    if max(use, _high(check)) > _WIDTH:
        drawn.append(f'<path class="beyond" d="M{_WIDTH - 6:g} 3l5 {_MIDDLE - 3:g}l-5 5"/>')
    return Markup(
        f'<svg class="gauge {check.status}" viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" '
        f'preserveAspectRatio="none" aria-hidden="true">{"".join(drawn)}</svg>'
    )


def _at(check: Check, value: float) -> float:
    """Where a value of a check is across the drawing."""
    return value * check.required / check.limit * _UNIT


def _bars(check: Check, use: float) -> list[str]:
    if not isfinite(check.upper):
        return [_line("endless", min(max(0.0, _low(check)), _WIDTH), _WIDTH)]
    low, high = _low(check), _high(check)
    if high - low < 0.05:  # nothing to be seen
        return []
    drawn = [_line("model", low, high)]
    if check.numerical:
        numerical = _at(check, check.numerical)
        drawn.append(_line("numerical", use - numerical, use + numerical))
    ends = "".join(f"M{x:.2f} 4V{_HEIGHT - 4:g}" for x in (low, high) if 0 < x < _WIDTH)
    return [*drawn, f'<path class="ends" d="{ends}"/>'] if ends else drawn


def _high(check: Check) -> float:
    """Where the upper end of the bars is; of endless ones the value, since they are dotted."""
    return _at(check, check.upper if isfinite(check.upper) else check.value)


def _low(check: Check) -> float:
    return _at(check, check.lower) if isfinite(check.lower) else 0.0


def _line(name: str, start: float, end: float) -> str:
    start, end = (min(max(x, 0.0), _WIDTH) for x in (start, end))
    return f'<path class="{name}" d="M{start:.2f} {_MIDDLE:g}H{end:.2f}"/>'


# Error bars of the deciding check one by one: how far each alone moves its safety.


@dataclass(frozen=True)
class Share:
    """A source of doubt by itself.

    ends      safety at both ends of its bar, in words
    decides   True if the check has another status with this bar than without any
    """

    name: str
    gauge: Markup
    ends: str
    decides: bool


def shares(check: Check) -> list[Share]:
    """Sources of a check's error bars, the widest first; those of no size are left out."""
    mesh = check.numerical - check.sampling if isfinite(check.numerical) else check.numerical
    words = check.derivation.bars.words if check.derivation else ""
    said = words.partition("model: ")[2]
    found = [
        (
            f"model: {said}" if said else "model",
            check.model - check.loads,
            check.below - check.loads_below,
        ),
        ("loads that are not known for certain", check.loads, check.loads_below),
        ("mesh and numerics", mesh, mesh),
        ("between the positions of the cycle", check.sampling, check.sampling),
    ]
    found = [(name, above, below) for name, above, below in found if above > 0 or below > 0]
    found.sort(key=lambda each: -(each[1] + each[2]))
    return [_share(check, *each) for each in found]


def _share(check: Check, name: str, above: float, below: float) -> Share:
    bare = replace(check, numerical=0.0, model=0.0, model_below=0.0)
    alone = replace(bare, model=above, model_below=below)
    least = check.limit / alone.upper if isfinite(above) else 0.0
    most = check.limit / alone.lower if alone.lower > 0 else float("inf")
    ends = f"{safety_text(least, check.required)} to " + (
        safety_text(most, check.required) if isfinite(most) else "any"
    )
    return Share(clipped(name, 120), gauge(alone), ends, alone.status is not bare.status)
