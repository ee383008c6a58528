"""Numbers, names and verdicts as people read them, the same on the terminal and on the page."""

import unicodedata
from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Decimal
from math import isfinite, isinf, isnan

from reports.verdict import Check, DesignResult, Gate, Status

# Marks that turn the direction of text and so could make a name read as something else.
_TURNING = {0x061C, 0x200E, 0x200F, *range(0x202A, 0x202F), *range(0x2066, 0x206A)}


def clean(text: object, *, lines: bool = False) -> str:
    """Text without anything that steers a terminal or turns the direction of reading.

    Line breaks and tabs stay with `lines`, and become spaces without.
    """
    if (plain := str(text)).isascii() and plain.isprintable():
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


def number(value: object, digits: int = 3, rounding: str = ROUND_HALF_EVEN) -> str:
    """A number to so many significant digits, without an exponent where it stays readable.

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


def safety_text(safety: float) -> str:
    """A safety to three digits, rounded down so that it never looks better than it is."""
    return number(safety, 3, ROUND_FLOOR)


def utilisation_text(utilisation: float) -> str:
    """A utilisation to two decimals, rounded up so that it never looks better than it is."""
    if not isfinite(utilisation):
        return number(utilisation)
    return str(Decimal(repr(utilisation)).quantize(Decimal("0.01"), ROUND_CEILING))


def bar_text(bar: float, value: float, unknown: str = "singular") -> str:
    """Half an error bar with its sign, to the decimals of its value, or why it is infinite."""
    if not isfinite(bar):
        return f"±∞ ({unknown})"
    written = number(value)
    if "e" in written or bar == 0:
        return f"±{number(bar, 2)}"
    decimals = len(written.partition(".")[2])
    rounded = f"{bar:.{decimals}f}"
    return f"±{rounded}" if float(rounded) else f"±{number(bar, 1)}"


def bars_text(check: Check) -> tuple[str, str]:
    """The numerical and the model bar of a check."""
    return (
        bar_text(check.numerical, check.value, "singular"),
        bar_text(check.model, check.value, "unknown"),
    )


def check_titles(checks: Sequence[Check]) -> list[str]:
    """What each check is called: its kind, with the quantity where a part has two of the kind."""
    seen = [(check.part, check.kind) for check in checks]
    return [
        f"{check.kind} ({check.quantity})" if seen.count(pair) > 1 else check.kind
        for check, pair in zip(checks, seen, strict=True)
    ]


def where(check: Check) -> str:
    """Where on the part and where in the cycle."""
    return ", ".join(text for text in (check.place, check.cycle, check.position) if text)


def broken_gates(result: DesignResult) -> list[Gate]:
    """The gates that do not hold, in order."""
    return [gate for gate in result.all_gates if not gate.holds]


def assumptions(result: DesignResult) -> list[tuple[str, str]]:
    """Everything that was assumed, of the design and of its parts, as (key, what)."""
    of_parts = [(part.name, what) for part in result.parts for what in part.assumed]
    return [*((key, what) for key, what in result.assumed), *of_parts]


def gate_sentence(gate: Gate) -> str:
    """What a gate measured, and what it had to stay below."""
    sign = "≤" if gate.holds else "is not a number, limit" if isnan(gate.value) else ">"
    return f"{gate.name}: {number(gate.value)} {sign} {number(gate.limit)}"


def reason(check: Check) -> str:
    """Why a check has the status that it has, in words."""
    bar = check.numerical + check.model
    least = safety_text(check.limit / (check.value + bar)) if check.value + bar else "∞"
    most = safety_text(check.limit / (check.value - bar)) if check.value > bar else "∞"
    has = f"safety {safety_text(check.safety)}, needs {number(check.required)}"
    if check.status is Status.PASS:
        return f"{has}; {least} at the upper end of its error bars"
    if check.status is Status.FAIL:
        return f"{has}; {most} at the lower end of its error bars"
    if not isfinite(check.numerical):
        return f"{has}; its numerical error bar is infinite (singular): no mesh settles it"
    if not isfinite(check.model):
        return f"{has}; its model error bar is infinite (unknown): no mesh settles it"
    cure = (
        "a finer mesh can settle it"
        if check.settled_by_mesh
        else "the model's own bar holds the limit, so a finer mesh cannot settle it"
    )
    return f"{has}; between {least} and {most} within its error bars: {cure}"


def verdict_sentence(result: DesignResult) -> str:
    """The verdict, what decides it, and why."""
    status = str(result.status).upper()
    if not result.checks:
        return f"{status}: nothing was checked"
    deciding = result.deciding
    titles = check_titles(result.checks)
    title = titles[next(i for i, check in enumerate(result.checks) if check is deciding)]
    decided = f"decided by {brief(deciding.part, 40)} {brief(title, 40)}, {reason(deciding)}"
    broken = broken_gates(result)
    if result.status is Status.UNDECIDED and deciding.status is Status.PASS:
        names = ", ".join(brief(gate.name, 40) for gate in broken)
        return f"{status}: every check passes, but these gates do not hold: {names}; {decided}"
    count = len(assumptions(result))
    under = f" (under {count} assumption{'s' if count > 1 else ''})" if count else ""
    doubt = " (gates are broken, too)" if broken else ""
    return f"{status}{under}; {decided}{doubt}"
