"""Result of `ballesta ladder`: rungs of every part, the choice of `auto`, and words for both."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

from checks.result.plain_data import plain_fields
from checks.result.verdict import Check, RungTried, Status
from checks.result.words import brief, clipped, number

_LONGEST_WHY = 90
AUTO = "auto"


@dataclass(frozen=True, eq=False)
class LadderPart:
    """The rungs of one part.

    kinds   of checks that a model decides: "static", "fatigue", "buckling"
    rungs   every rung by itself, solids of several finenesses last
    tried   what `auto` tried or passed over, in that order
    chosen  the checks as `auto` reports them
    """

    name: str
    shape: str
    material: str
    kinds: Sequence[str]
    rungs: Sequence[RungTried]
    tried: Sequence[RungTried]
    chosen: Sequence[Check]

    @property
    def seconds(self) -> float:
        """Time that `auto` takes for the part, s."""
        return sum(rung.seconds for rung in self.tried)

    def to_dict(self) -> dict[str, Any]:
        """The part as plain data."""
        auto = {
            "seconds": self.seconds,
            "rungs": [rung.to_dict() for rung in self.tried],
            "checks": [check.to_dict() for check in self.chosen],
        }
        return plain_fields(self, "tried", "chosen") | {"auto": auto}


@dataclass(frozen=True, eq=False)
class LadderResult:
    """The ladder of a design.

    solids  what the rows of solids mean, in words
    """

    name: str
    file: str
    sha256: str
    overrides: Sequence[str]
    parts: Sequence[LadderPart]
    solids: str
    command: str

    def to_dict(self) -> dict[str, Any]:
        """The ladder as plain data."""
        return {"format": "ballesta-ladder/1"} | plain_fields(self)


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
    """Reason that a rung has no value of a check."""
    return "no answer to it" if rung.checks else f"not available: {rung.why}"


def _bar(bar: float) -> str:
    return number(bar, 2)
