"""Numbers, names and verdicts as people read them, the same on the terminal and on the page."""

import unicodedata
from collections.abc import Mapping, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Decimal
from math import degrees, inf, isfinite, isinf, isnan

from checks.result.verdict import Check, DesignResult, Gate, Status

# Marks that turn the direction of text and so could make a name read as something else.
CONTACT = ": contact of its pins"  # ends the name of the gate of a part whose pins press by contact
_TURNING = {0x061C, 0x200E, 0x200F, *range(0x202A, 0x202F), *range(0x2066, 0x206A)}


TOO_MANY = "mesh.most_unknowns"  # begins why a solid was left out whose first mesh has more
UNKNOWN_BAR = "no error bar: "  # in a check's note, before why it has none
DOUBTED = "loads not known for certain"  # begins the part of a note that tells load bars
# words of doubts about loads
UNEVEN = "slower or faster than its mean"
SURGING = "changes of speed between its slowest and fastest"
SPEED_DOUBTS = (UNEVEN, SURGING)  # end those of a drive that does not run evenly
INTERFERENCE = "interference of"  # begins those of bushes that are pressed in
END_OF_TRAVEL = "end of its travel off by up to"  # in that of a stop, behind the cycle's name
LENGTHS_OFF = "lengths and position off by general tolerances"  # behind the cycle's name
HITS = "as its force reverses"  # ends those of play in a joint
WOULD_HIT = "hits its bore by up to"  # behind the point of the hardest hit that is in no bar
LESS_IN = "less in"  # before the points of the others
_NEAR = 0.05  # of the required safety, within which four digits tell the safety
_LONGEST_UTILISATION = 1e6  # that is written with all its digits


def by_arc_words(by_arc: Mapping[float, float]) -> str:
    """Stress, MPa, by arc of contact, rad, for a note."""
    return "by arc of contact, MPa: " + ", ".join(
        f"{degrees(arc):.0f} deg {value:.4g}" for arc, value in by_arc.items()
    )


def clean(text: object, *, lines: bool = False) -> str:
    """Text without anything that steers a terminal or turns the direction of reading.

    Line breaks and tabs stay with `lines`, and become spaces without.
    """
    if (plain := str(text)).isprintable():  # no control and no turning mark is printable
        return plain
    return "".join(_harmless(letter, lines) for letter in plain)


def _harmless(letter: str, lines: bool) -> str:
    if letter in "\n\t":
        return letter if lines else " "
    if letter == "\r":
        return "" if lines else " "
    if ord(letter) in _TURNING or unicodedata.category(letter) in ("Cc", "Cs"):
        return "\N{REPLACEMENT CHARACTER}"
    return letter


def brief(text: object, length: int = 60) -> str:
    """Text of at most `length` characters; of a longer one its beginning and its end."""
    plain = clean(text)
    if len(plain) <= length:
        return plain
    tail = (length - 1) // 3
    return f"{plain[: length - 1 - tail]}…{plain[len(plain) - tail :]}"


def clipped(text: object, length: int) -> str:
    """Text of at most `length` characters, without the end of a longer one."""
    plain = clean(text)
    return plain if len(plain) <= length else f"{plain[: length - 1].rstrip()}…"


def number(value: object, digits: int = 3, rounding: str = ROUND_HALF_EVEN) -> str:
    """Write a number to so many significant digits, without an exponent where it stays readable.

    >>> [number(value) for value in (141.34, 0.012345, 1.1e7, 0)]
    ['141', '0.0123', '1.1e+07', '0']
    """
    value = float(value)  # type: ignore[arg-type]
    if not isfinite(value):
        return "∞" if value > 0 else "-∞" if isinf(value) else "not a number"
    if value == 0:
        return "0"
    exact = Decimal(repr(value))
    rounded = exact.quantize(Decimal(1).scaleb(exact.adjusted() - digits + 1), rounding)
    if not 1e-4 <= abs(value) < 1e6:
        return f"{float(rounded):g}"
    return f"{rounded:f}" if int(rounded.as_tuple().exponent) <= 0 else f"{int(rounded)}"


def place_text(position: float) -> str:
    """A shown position to five digits, without rounding's -0.

    >>> place_text(1.99999999999), place_text(-1e-13)
    ('2', '0')
    """
    return f"{round(position, 9) + 0.0:.5g}"


def quantity_unit(angular: bool, largest: float) -> tuple[str, float]:
    """Unit in which a force [N] or torque [N mm] of this size is read well, and the factor to it.

    >>> quantity_unit(False, 61180.0), quantity_unit(True, 12e3)
    (('kN', 0.001), ('N m', 0.001))
    """
    if angular:
        return ("kN m", 1e-6) if largest >= 1e7 else ("N m", 1e-3)
    return ("kN", 1e-3) if largest >= 1e4 else ("N", 1.0)


def safety_text(safety: float, required: float = 0.0) -> str:
    """Safety to three digits, rounded down so that it never looks better than it is.

    required  safety that it is compared with; one within 5 % of it is written with four digits

    >>> safety_text(1.2999), safety_text(1.2885, 1.3), safety_text(inf)
    ('1.29', '1.288', 'not loaded')
    """
    if safety == inf:
        return "not loaded"
    near = abs(safety - required) <= _NEAR * required
    return number(safety, 4 if near else 3, ROUND_FLOOR)


def utilisation_text(utilisation: float) -> str:
    """Utilisation to two decimals, rounded up so that it never looks better than it is."""
    if not utilisation < _LONGEST_UTILISATION:
        return number(utilisation, 3, ROUND_CEILING)
    return str(Decimal(repr(float(utilisation))).quantize(Decimal("0.01"), ROUND_CEILING))


def need_text(required: float) -> str:
    """Write a required safety as people do, without zeros at the end."""
    return f"{required:g}"


def value_and_bars(check: Check) -> tuple[str, str, str]:
    """Value with its numerical and model bar, to the decimals that the smaller bar deserves."""
    bars = check.numerical, check.model, check.below
    written = number(check.value)
    if "e" in written:
        decimals = None
    else:
        decimals = len(written.partition(".")[2])
        least = min((bar for bar in bars if bar and isfinite(bar)), default=0.0)
        while decimals and least >= 10.0 ** (1 - decimals):
            decimals -= 1
        written = f"{check.value:.{decimals}f}"
    return (written, _bar(check.numerical, decimals, "singular"), _band(check, decimals))


def value_and_whole_bar(check: Check) -> tuple[str, str]:
    """Value with its numerical and model bar in one, to the decimals that the wider side deserves.

    A side below half of the last digit is 0, and both are "" where both are.

    >>> from checks.result.verdict import Check
    >>> check = Check("rod", "fatigue", "", 45.31, "MPa", 0.3, 26.6, 67.4, 1.3, "", "", "", "", "",
    ...               model_below=0.0)
    >>> value_and_whole_bar(check)
    ('45', '+27 −0')
    """
    written = number(check.value)
    sides = check.numerical + check.model, check.numerical + check.below
    if not isfinite(check.numerical):
        return written, "±∞ (singular)"
    decimals = 0 if "e" in written else len(written.partition(".")[2])
    wide = max((side for side in sides if isfinite(side)), default=0.0)
    while decimals and wide >= 10.0 ** (2 - decimals):
        decimals -= 1
    if "e" not in written:
        written = f"{check.value:.{decimals}f}"
    above, below = (_side(side, decimals, "e" in written) for side in sides)
    if above == below:
        return written, "" if above == "0" else f"±{above}"
    return written, f"+{above} −{below}"


def _side(bar: float, decimals: int, small: bool) -> str:
    if not isfinite(bar):
        return "∞ (unknown)"
    rounded = number(bar, 2) if small else f"{bar:.{decimals}f}"
    return rounded if float(rounded) else "0"


def bar_words(check: Check) -> str:
    """The error bars of a check with what leaves them open; those that are 0 are left out."""
    _, numerical, model = value_and_bars(check)
    said = [
        (f"{numerical} numerical", check.numerical),
        (f"{model} model", check.model + check.below),
    ]
    return ", ".join(text.replace(" ", "\N{NO-BREAK SPACE}") for text, size in said if size) or "±0"


def _band(check: Check, decimals: int | None) -> str:
    """The model band: ±, or + and − where it reaches differently far above and below."""
    above, below = (_bar(bar, decimals, "unknown") for bar in (check.model, check.below))
    return above if above == below else f"+{above[1:]} −{below[1:]}"


def _bar(bar: float, decimals: int | None, unknown: str) -> str:
    """Half an error bar with its sign, or why it is infinite; never 0 unless it is."""
    if not isfinite(bar):
        return f"±∞ ({unknown})"
    rounded = f"{bar:.{decimals}f}" if decimals is not None else number(bar, 2)
    return f"±{rounded if float(rounded) or not bar else number(bar, 1)}" if bar else "±0"


def check_titles(checks: Sequence[Check]) -> list[str]:
    """Names of the checks: each its kind, with the quantity where a part has two of the kind."""
    seen = [(check.part, check.kind) for check in checks]
    return [
        f"{check.kind} ({check.quantity})" if seen.count(pair) > 1 else check.kind
        for check, pair in zip(checks, seen, strict=True)
    ]


def moment(check: Check) -> str:
    """Where in the cycle; of a fatigue check the two ends of the swing that decides it."""
    swing = check.kind in ("fatigue", "weld") and " to " in check.position
    position = f"swing from {check.position}" if swing else check.position
    return ": ".join(text for text in (check.cycle, position) if text)


def where(check: Check) -> str:
    """Where on the part and where in the cycle."""
    return ", ".join(text for text in (check.place, moment(check)) if text)


def broken_gates(result: DesignResult) -> list[tuple[str, Gate]]:
    """Gates that do not hold, each with the part that it belongs to, or "loads"."""
    owned = [("loads", gate) for gate in result.gates]
    owned += [(part.name, gate) for part in result.parts for gate in part.gates]
    return [(owner, gate) for owner, gate in owned if not gate.holds]


def assumptions(result: DesignResult) -> list[tuple[str, str]]:
    """Everything that was assumed, of the design and of its parts, as (keys, what).

    What several parts assume in the same words is one assumption.
    """
    of_parts = [(part.name, what) for part in result.parts for what in part.assumed]
    keys: dict[str, dict[str, None]] = {}
    for key, what in (*result.assumed, *of_parts):
        keys.setdefault(what, {})[key] = None
    return [(", ".join(of), what) for what, of in keys.items()]


def gate_word(gate: Gate) -> str:
    """Return a word for a gate's state; one that does not alter the verdict is never "BROKEN"."""
    if gate.holds:
        return "holds"
    return "BROKEN" if gate.binding else "DOES NOT HOLD"


def gate_sentence(gate: Gate) -> str:
    """Sentence on a gate's measured value and the limit it had to stay below."""
    sign = "≤" if gate.holds else "is not a number, limit" if isnan(gate.value) else ">"
    return f"{gate.name}: {number(gate.value)} {sign} {number(gate.limit)}"


def reason(check: Check) -> str:
    """Reason for the status of a check, in words."""
    has = f"safety {_safety_of(check)}, {need_text(check.required)} required"
    if not check.value:
        has = f"not loaded: a value of 0 has no safety ({need_text(check.required)} required)"
    if check.status is Status.UNDECIDED:
        said = range_text(check)
        ends = f"; {said} within its error bars{_wider(check)}:" if said else ";"
        return f"{has}{ends} {open_reason(check)}"
    if check.status is Status.FAIL:
        best = safety_text(check.limit / check.lower, check.required)
        if not isfinite(check.model):
            return f"{has}; over the limit: {best} at the least plausible value"
        return f"{has}; {best} at the lower end of its error bars"
    if not check.upper:
        return has + _wider(check)
    least = safety_text(check.limit / check.upper, check.required)
    return f"{has}; {least} at the upper end of its error bars{_wider(check)}"


def range_text(check: Check) -> str:
    """Safeties at both ends of the error bars, in words; "" where a bar is infinite."""
    if not isfinite(check.upper):
        return ""
    least = _safety_at(check, check.upper, ROUND_FLOOR)
    best = _safety_at(check, check.lower, ROUND_CEILING) if check.lower > 0 else "no end"
    return f"between {least} and {best}"


def open_reason(check: Check) -> str:
    """Why an undecided check is open, and whether a finer mesh would settle it."""
    if not isfinite(check.numerical):
        return "its numerical error bar is infinite (singular): no mesh settles it"
    if not isfinite(check.model):
        why = check.note.partition(UNKNOWN_BAR)[2].partition(f"; {DOUBTED}")[0]
        if why:
            return f"its model error bar is unknown ({why}): a better model may settle it"
        return "its model error bar is infinite (unknown): no mesh settles it"
    if check.between_positions is not Status.UNDECIDED:
        return "more positions of its cycle can settle it (cycles.NAME.positions)"
    if check.settled_by_mesh:
        return "a finer mesh can settle it (accuracy, mesh.most_unknowns)"
    doubts = sorted(check.doubts, key=lambda doubt: -(doubt[1] + doubt[2]))
    for n in range(1, len(doubts) + 1):
        if check.without(doubts[:n]).status is not Status.UNDECIDED:
            widest = " and ".join(words for words, *_ in doubts[:n])
            return f"the limit lies within what is not known of its loads: {widest}"
    return "the limit lies within the model's own error bar, which no finer mesh narrows"


def _safety_of(check: Check) -> str:
    return safety_text(check.safety, check.required)


def _safety_at(check: Check, value: float, rounding: str) -> str:
    safety = check.limit / value if value else inf
    near = abs(safety - check.required) <= _NEAR * check.required
    return "not loaded" if safety == inf else number(safety, 4 if near else 3, rounding)


def _wider(check: Check) -> str:
    """Say of a bar that is wider than its value that the model tells little more than a bound."""
    _, numerical, model = value_and_bars(check)
    for bar, owner, written in (
        (check.numerical, "numerical", numerical),
        (check.model, "model", model),
    ):
        if check.value and bar > check.value:
            return (
                f"; its {owner} bar is wider than the value: {written} on "
                f"{number(check.value)} {check.unit}".rstrip()
                + ", so the value is a bound, not an estimate"
            )
    return ""


def verdict_sentence(result: DesignResult) -> str:
    """Verdict, what decides it, and why."""
    status = str(result.status).upper()
    if not result.checks:
        return f"{status}: nothing was checked"
    deciding = result.deciding
    titles = check_titles(result.checks)
    title = titles[next(i for i, check in enumerate(result.checks) if check is deciding)]
    decided = f"decided by {brief(deciding.part, 40)} {brief(title, 40)}, {reason(deciding)}"
    broken = [(owner, gate) for owner, gate in broken_gates(result) if gate.binding]
    if result.status is Status.UNDECIDED and deciding.status is Status.PASS:
        nearest = decided.replace("decided by", "nearest to its limit is", 1)
        names = ", ".join(f"{brief(owner, 40)} {brief(gate.name, 40)}" for owner, gate in broken)
        broken_ones = f"these validity checks do not hold: {names}"
        return f"{status}: every check passes, but {broken_ones}; {nearest}"
    count = len(assumptions(result))
    under = f" (under {count} assumption{'s' if count > 1 else ''})" if count else ""
    doubt = " (validity checks do not hold, too)" if broken else ""
    return f"{status}{under}; {decided}{doubt}"
