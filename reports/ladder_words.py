"""The rungs that were tried for a part, in words: the same on terminal and page."""

from collections.abc import Sequence
from math import inf

from checks.result.verdict import Check, RungTried, Status
from checks.result.words import brief, clipped, number

_LONGEST_WHY = 90
AUTO = "auto"


def seconds_text(seconds: float) -> str:
    """A time to two digits.

    >>> seconds_text(0.0123), seconds_text(14.2)
    ('0.012 s', '14 s')
    """
    return f"{number(seconds, 2)} s"


def tried_sentence(rungs: Sequence[RungTried], longest: int = _LONGEST_WHY) -> str:
    """Rungs tried, their times and their outcomes, in words.

    Of the rungs passed over, only those before the first that answered, and the last, are named.
    """
    answering = [k for k, rung in enumerate(rungs) if rung.checks]
    first = answering[0] if answering else len(rungs)
    shown = [r for k, r in enumerate(rungs) if k < first or r.checks or r is rungs[-1]]
    return ", ".join(
        f"{brief(rung.rung, 24)} {seconds_text(rung.seconds) if rung.checks else 'passed over'} "
        f"({clipped(rung.why, longest)})"
        for rung in shown
    )


def chosen_sentence(chosen: Sequence[Check], seconds: float) -> str:
    """Return a sentence on the checks that `auto` reports, each with its rung."""
    if not chosen:
        return f"after {seconds_text(seconds)}: no answer"
    told = "; ".join(
        f"{brief(check.kind, 24)} {value_text(check)} by {brief(check.method, 40)}, "
        f"{status_word(check)}"
        for check in chosen
    )
    return f"after {seconds_text(seconds)}: {told}"


def value_text(check: Check) -> str:
    """The value with its whole bar and its unit.

    The numerical bar and the model band are added, as the verdict does.
    """
    value, bar = value_and_bar(check)
    return " ".join(text for text in (value, bar, brief(check.unit, 8)) if text)


def value_and_bar(check: Check) -> tuple[str, str]:
    """The value, and its whole bar: ±, or + and − where it reaches differently far."""
    above, below = whole_bar(check)
    value = number(check.value)
    if not (above < inf and below < inf):
        return value, "±∞ (no bar)"
    up, down = _bar(above), _bar(below)
    return value, f"±{up}" if up == down else f"+{up} −{down}"


def whole_bar(check: Check) -> tuple[float, float]:
    """Whole bar above and below the value, in the check's unit."""
    return check.numerical + check.model, check.numerical + check.below


def needed(check: Check) -> float:
    """Allowed value: the limit over the required safety."""
    return check.limit / check.required


def status_word(check: Check) -> str:
    """The status as the terminal shows it."""
    return "pass" if check.status is Status.PASS else str(check.status)


def check_of(checks: Sequence[Check], kind: str) -> Check | None:
    """The check of a kind, None without one."""
    return next((check for check in checks if check.kind == kind), None)


def no_answer(rung: RungTried) -> str:
    """Why a rung has no value of a check."""
    return "no answer to it" if rung.checks else f"not available: {rung.why}"


def _bar(bar: float) -> str:
    return number(bar, 2)
