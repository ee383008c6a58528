"""A check's utilisation drawn as a bar with its error bars, small enough for a cell of a table."""

import re
from dataclasses import dataclass, replace
from math import isfinite

from markupsafe import Markup

from checks.result.derivation import Derivation, Given
from checks.result.verdict import Check
from checks.result.words import clipped, range_text, safety_text

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


# Assumptions and models behind the deciding check's error bars: how far each moves its safety.

Bar = tuple[str, float, float]  # name, size above and below the value

_UNNAMED = "loads that are not known for certain"
_RUBBED = "friction adds"
_PLAIN = ("model band", "error band", "e_")  # begins a meaning that names no cause
_ROUND_OFF = 1e-9  # of a value


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
    """Assumptions and models behind a check's error bars, the widest first; none of no size."""
    mesh = check.numerical - check.sampling if isfinite(check.numerical) else check.numerical
    doubts = check.doubts or ((_UNNAMED, check.loads, check.loads_below),)
    found = [
        *_of_model(check),
        *doubts,
        ("mesh and numerics", mesh, mesh),
        ("between the positions of the cycle", check.sampling, check.sampling),
    ]
    found = [(name, above, below) for name, above, below in found if above > 0 or below > 0]
    found.sort(key=lambda each: -(each[1] + each[2]))
    return [_share(check, *each) for each in found]


def _of_model(check: Check) -> list[Bar]:
    """The model band by what it is made of, as far as its derivation tells it apart."""
    above, below = check.model - check.loads, check.below - check.loads_below
    derivation = check.derivation
    if derivation is None or not (isfinite(above) and isfinite(below)):
        return [("model", above, below)]
    words = derivation.bars.words.partition("model: ")[2] or derivation.bars.words
    meant = {item.symbol: item.meaning for item in derivation.items}
    sides = derivation.bars.above.split(), derivation.bars.below.split()
    own = {s: derivation.number(s) for s in (*sides[0], *sides[1]) if not s.startswith("e_load")}
    found = list[Bar]()
    for kind in dict.fromkeys(symbol[0] for symbol in own):
        up, low = (
            sum(size for s, size in own.items() if s[0] == kind and s in side) for side in sides
        )
        pressed = _of_pins(derivation) if kind == "b" else []
        said = meant[next(s for s in own if s[0] == kind)].rpartition(": ")[2]
        clause = words.partition("; ")[0]
        if said.startswith(_RUBBED):
            name = "friction and preload between the leaves"
        elif not said.startswith(_PLAIN):
            name = said
        else:
            name = derivation.bars.name or clause or "model"
        off = _ROUND_OFF * check.value
        up, low = up - sum(p[1] for p in pressed), low - sum(p[2] for p in pressed)
        rest = (name, 0.0 if abs(up) < off else up, 0.0 if abs(low) < off else low)
        found += [*pressed, *([rest] if any(rest[1:]) else [])]
    return found


def _of_pins(derivation: Derivation) -> list[Bar]:
    """Bands of a solid by arcs, clearances and bending of its pins, from their single values."""
    given = {
        item.symbol: (float(item.value), item.meaning)
        for item in derivation.items
        if isinstance(item, Given) and not isinstance(item.value, tuple)
    }
    found = list[Bar]()
    arcs = [given[s] for s in given if re.fullmatch(r"p_\d", s)]
    if arcs:
        (own, _), *_ = arcs
        most, least = max(value for value, _ in arcs), min(value for value, _ in arcs)
        wide = [re.sub(r".* arc of (\d+)°.*", r"\1", meaning) for _, meaning in (arcs[-1], arcs[0])]
        found.append((f"arc on which pins press: {wide[0]} to {wide[1]}°", most - own, own - least))
        if "p_b" in given:
            found.append(("fit of pins that is not stated", max(0.0, given["p_b"][0] - most), 0.0))
    fits = {s: value for s, (value, _) in given.items() if re.fullmatch(r"fit_\d+", s)}
    if fits:
        own = next(fits[s] for s in fits if " middle " in given[s][1])
        above = max(fits.values()) - own + given.get("fit_up", (0.0, ""))[0]
        below = own - min(fits.values()) + given.get("fit_lo", (0.0, ""))[0]
        found.append(("clearance of pins, over their fit", above, below))
    if "q_2" in given:
        more = given["q_2"][0] - given["q_1"][0]
        found.append(("pins that bend, which press at edges", max(more, 0.0), max(-more, 0.0)))
    if "s_b" in given:
        soft = given["s_b"][0] - own
        up = max(soft - sum(p[1] for p in found), 0.0)
        found.append(
            ("bushes whose material is not stated", up, max(-soft - sum(p[2] for p in found), 0.0))
        )
    return found


def _share(check: Check, name: str, above: float, below: float) -> Share:
    bare = replace(check, numerical=0.0, model=0.0, model_below=0.0)
    alone = replace(bare, model=above, model_below=below)
    ends = range_text(alone).removeprefix("between ").replace(" and ", " to ")
    if not ends:
        most = safety_text(check.limit / alone.lower, check.required) if alone.lower > 0 else "any"
        ends = f"0 to {most}"
    return Share(clipped(name, 120), gauge(alone), ends, alone.status is not bare.status)
