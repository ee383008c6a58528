"""A check's utilisation drawn as a bar with its error bars, small enough for a cell of a table."""

from math import isfinite

from markupsafe import Markup

from checks.result.verdict import Check

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


def limit_share() -> float:
    """Where the limit is across a gauge, in percent of its width."""
    return round(100.0 / END, 2)


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
