"""Text of a sweep: keys of a design and the values that they take, written with their unit."""

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ballesta.design.files import split_key
from checks.design.errors import DesignError

MOST = 100_000  # values of one sweep, and variations of one design
EXAMPLE = "write it such as parts.bar.wall = 4..8 mm : 9, or material = S275, S355"
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_ALONE = re.compile(rf"({_NUMBER})\s*(.*)")
_RANGE = re.compile(
    rf"\s*(?P<low>{_NUMBER})(?P<low_unit>[^,:]*?)\.\.\s*(?P<high>[^,:]*?)\s*(?::(?P<how>[^,:]*))?"
)

Values = tuple[str, ...]


@dataclass(frozen=True)
class Interval:
    """All values between two, in a unit as it is written."""

    low: float
    high: float
    unit: str

    def at(self, share: float) -> str:
        """Return the value at a share of the way from low to high, to six digits of the range."""
        value = self.low + share * (self.high - self.low)
        digits = 5 - math.floor(math.log10(self.high - self.low))
        return written(min(max(round(value, digits), self.low), self.high), self.unit)


@dataclass(frozen=True)
class Sweep:
    """A sweep: keys, and the values that they take together.

    text      as the user wrote it
    keys      dotted keys of the design
    choices   a value for each key, per choice; empty for an interval
    interval  that every key takes the same value of; None where there are choices
    """

    text: str
    keys: tuple[str, ...]
    choices: tuple[Values, ...] = ()
    interval: Interval | None = None

    def overrides(self, values: Values) -> Values:
        """Return what sets the keys to a choice's values."""
        return tuple(f"{key}={value}" for key, value in zip(self.keys, values, strict=True))

    def at(self, share: float) -> Values:
        """Return the overrides at a share of the way, 0 <= share < 1, through the values."""
        if self.interval is not None:
            return self.overrides((self.interval.at(share),) * len(self.keys))
        return self.overrides(self.choices[int(share * len(self.choices))])


def written(value: float, unit: str) -> str:
    """Write a number with its unit as a design file does.

    >>> written(0.1 + 0.2, "mm"), written(3.0, "")
    ('0.3 mm', '3')
    """
    return f"{value:.12g} {unit}".strip()


def refusal(text: str, problem: str) -> DesignError:
    """Return the error of a sweep as it was written."""
    return DesignError(Path("--sweep"), text.strip(), problem)


def parse_sweep(text: str) -> Sweep:
    """Parse a sweep; raises DesignError.

    >>> parse_sweep("leaves = 2..4 : 3").choices
    (('2',), ('3',), ('4',))
    """
    left, equals, right = text.partition("=")
    keys = tuple(key.strip() for key in left.split("&"))
    if not equals or not right.strip() or any(split_key(key) is None for key in keys):
        raise refusal(text, EXAMPLE)
    if len(set(keys)) < len(keys):
        raise refusal(text, "names a key twice")
    found = _RANGE.fullmatch(right)
    if found is None:
        return Sweep(text, keys, _listed(text, right, len(keys)))
    interval = _interval(text, found)
    if found["how"] is None:
        return Sweep(text, keys, interval=interval)
    values = _spaced(text, interval, found["how"].strip())
    return Sweep(text, keys, tuple((value,) * len(keys) for value in values))


def _interval(text: str, found: re.Match[str]) -> Interval:
    high = _ALONE.fullmatch(found["high"])
    if high is None:
        raise refusal(
            text, f"the upper end of the range must be a number, got {found['high']!r}; {EXAMPLE}"
        )
    unit, low_unit = high[2].strip(), found["low_unit"].strip()
    if low_unit not in ("", unit):
        raise refusal(
            text, f"both ends of a range have one unit, got {low_unit!r} and {unit or 'none'!r}"
        )
    ends = float(found["low"]), float(high[1])
    if not all(map(math.isfinite, ends)):
        raise refusal(text, "the ends of a range must be finite")
    if ends[0] == ends[1]:
        raise refusal(text, "the range is empty; --set sets one value")
    if ends[0] > ends[1]:
        turned = f"{written(ends[1], '')}..{written(ends[0], unit)}"
        raise refusal(text, f"a range goes from the smaller to the larger: {turned}")
    return Interval(*ends, unit)


def _spaced(text: str, interval: Interval, how: str) -> list[str]:
    """Return the values of a range as `: 9` or `: step 0.5 mm` spaces them, both ends included."""
    word, _, size = how.partition(" ")
    width = interval.high - interval.low
    if word == "step":
        step = _ALONE.fullmatch(size.strip())
        if step is None or step[2].strip() not in ("", interval.unit) or not float(step[1]) > 0:
            wanted = f"such as {written(width / 8, interval.unit)}"
            raise refusal(text, f"the step must be above 0 in the range's unit, {wanted}")
        count = width / float(step[1])
        if count > MOST or abs(count - round(count)) > 1e-9 * count or round(count) < 1:
            end = written(interval.low + max(1, math.floor(count)) * float(step[1]), interval.unit)
            raise refusal(
                text,
                f"steps of {written(float(step[1]), interval.unit)} do not end at "
                f"{written(interval.high, interval.unit)}; nearest is {end}"
                if count <= MOST
                else f"takes more than {MOST} steps",
            )
        n = round(count)
    else:
        if not how.isdecimal() or not 2 <= int(how) <= MOST:
            raise refusal(
                text,
                f"after the colon stands how many values, 2 to {MOST}, or a step such as "
                f"step {written(width / 8, interval.unit)}; got {how!r}",
            )
        n = int(how) - 1
    values = [interval.low + width * k / n for k in range(n)] + [interval.high]
    return [written(value, interval.unit) for value in values]


def _listed(text: str, right: str, n_keys: int) -> tuple[Values, ...]:
    """Return the choices of a list; quotes hold an item together that has commas."""
    if ".." in right and '"' not in right:
        raise refusal(text, f"a range stands alone and has two numbers; {EXAMPLE}")
    try:
        (items,) = csv.reader([right.strip()], skipinitialspace=True, strict=True)
    except (csv.Error, ValueError):
        raise refusal(text, "quotes must hold whole items") from None
    choices = []
    for item in items:
        values = tuple(value.strip() for value in item.split("&"))
        if not all(values):
            raise refusal(text, "an item of the list is empty")
        if len(values) not in (1, n_keys):
            raise refusal(
                text,
                f"{item.strip()!r} has {len(values)} values for {n_keys} "
                f"key{'s' if n_keys > 1 else ''}",
            )
        choices.append(values * n_keys if len(values) == 1 else values)
    choices = [*zip(*(_with_units(column) for column in zip(*choices, strict=True)), strict=True)]
    if len(choices) == 1:
        raise refusal(text, "is one value; --set sets one, a sweep has two or more")
    for index, choice in enumerate(choices):
        if choice in choices[:index]:
            raise refusal(text, f"{' & '.join(dict.fromkeys(choice))} stands twice")
    return tuple(choices)


def _with_units(items: Sequence[str]) -> list[str]:
    """Give the unit of the last number to those that have none: 4, 5, 6 mm."""
    numbers = [_ALONE.fullmatch(item) for item in items]
    if any(number is None for number in numbers):
        return list(items)
    last = numbers[-1]
    assert last is not None
    return [
        f"{item} {last[2]}" if number and not number[2] and last[2] else item
        for item, number in zip(items, numbers, strict=True)
    ]
