"""Collects what differs between two results, and reads plain data that may be of any shape."""

from collections.abc import Iterable, Mapping, Sequence
from math import isfinite
from typing import Any

from reports.difference_summary import ROUND_OFF, VERDICTS, Change, relative_change

Data = Mapping[str, Any]


class Changes:
    """Collects changes by group and counts the comparisons."""

    def __init__(self) -> None:
        self.changes: dict[str, list[Change]] = {}
        self.counts: dict[str, int] = {}
        self.only_a: list[str] = []
        self.only_b: list[str] = []
        self.notes: list[str] = []

    def _count(self, group: str) -> None:
        self.counts[group] = self.counts.get(group, 0) + 1
        self.changes.setdefault(group, [])

    def number(
        self,
        group: str,
        of: str,
        what: str,
        pair: tuple[Any, Any],
        unit: str,
        note: str = "",
        scale: float = 0.0,
        none: str = "none",
    ) -> None:
        """Compare two numbers; `none` is what stands for one that is not finite or not there."""
        self._count(group)
        a, b = (number_of(value) for value in pair)
        if a is None or b is None:
            if a is not b:
                before, after = (none if value is None else value for value in (a, b))
                self.changes[group].append(Change(of, what, before, after, unit, None, note))
            return
        if abs(b - a) > ROUND_OFF * max(abs(a), abs(b), scale):
            relative = relative_change(a, b, scale)
            self.changes[group].append(Change(of, what, a, b, unit, relative, note))

    def keep(self, group: str, change: Change | None) -> None:
        """Count a thing, and keep its change if there is one."""
        self._count(group)
        if change is not None:
            self.changes[group].append(change)

    def verdict(self, of: str, what: str, a: str, b: str, note: str) -> None:
        """Compare two verdicts."""
        self.keep(VERDICTS, None if a == b else Change(of, what, a, b, note=note))

    def both(self, kind: str, a: Iterable[str], b: Iterable[str]) -> list[str]:
        """Return the names on both sides; the others are noted as only on one."""
        in_a, in_b = list(a), list(b)
        self.only_a += [f"{kind} {name}" for name in in_a if name not in in_b]
        self.only_b += [f"{kind} {name}" for name in in_b if name not in in_a]
        return [name for name in in_a if name in in_b]

    def lines(self, word: str, a: Any, b: Any) -> None:
        """Note the sentences that only one side has."""
        self.both(f"{word}:", *(dict.fromkeys(map(sentence, list_of(side))) for side in (a, b)))


def table_of(value: Any) -> Data:
    """Return a table, empty for anything else."""
    return value if isinstance(value, Mapping) else {}


def list_of(value: Any) -> Sequence[Any]:
    """Return a list, empty for anything else."""
    return value if isinstance(value, list | tuple) else ()


def tables_of(value: Any) -> list[Data]:
    """Return the tables of a list."""
    return [entry for entry in list_of(value) if isinstance(entry, Mapping)]


def sentence(value: Any) -> str:
    """Return a told thing as one text; of a pair its key and its reason."""
    return ": ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)


def number_of(value: Any) -> float | None:
    """Return a finite number, None for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return float(value) if isfinite(value) else None
