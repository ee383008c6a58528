"""Differences between two designs or two runs, as plain data for text, page and JSON."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isinf
from typing import Any

ROUND_OFF = 1e-9  # same versions and threads repeat to this; less is no difference
VERDICTS, INPUTS, LOADS, STRESSES = "verdicts", "inputs", "loads", "stresses"
SAFETY, LIMITS, MASSES = "safety", "limits", "masses"
GROUPS = (VERDICTS, INPUTS, LOADS, STRESSES, SAFETY, LIMITS, MASSES)


@dataclass(frozen=True)
class Change:
    """One thing that is not the same on both sides.

    of        whose it is: a part, a cycle, a key; "design" for all of it
    what      which quantity, verdict or input
    before    number or text on side A; None where it has none
    after     on side B
    unit      of the numbers
    relative  (after - before) / |before|; infinite from 0; None for what is no number
    note      what a reader must know beside it, such as another model or place
    """

    of: str
    what: str
    before: float | str | None
    after: float | str | None
    unit: str = ""
    relative: float | None = None
    note: str = ""

    def to_dict(self) -> dict[str, Any]:
        """The change as plain data; an infinite relative change as the text "from 0"."""
        plain = {name: getattr(self, name) for name in self.__dataclass_fields__}
        endless = self.relative is not None and isinf(self.relative)
        return plain | {"relative": "from 0" if endless else self.relative}


@dataclass(frozen=True)
class Side:
    """One of the two that are compared: where it was read, the design, its verdict."""

    path: str
    name: str
    status: str
    made: str  # tool and version, command

    def to_dict(self) -> dict[str, Any]:
        """The side as plain data."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


@dataclass(frozen=True)
class DesignDifference:
    """Two results of a design, or of two designs.

    changes   group -> changes, the largest first; groups that were compared only
    compared  group -> how many things of it stand on both sides
    only_a    what only side A has: parts, checks, cycles, warnings, assumptions
    notes     what limits the comparison
    """

    name: str
    a: Side
    b: Side
    changes: Mapping[str, Sequence[Change]]
    compared: Mapping[str, int]
    only_a: Sequence[str] = ()
    only_b: Sequence[str] = ()
    notes: Sequence[str] = ()

    @property
    def same(self) -> bool:
        """True if nothing differs."""
        return not (any(self.changes.values()) or self.only_a or self.only_b)

    @property
    def turned(self) -> int:
        """Number of verdicts that differ."""
        return len(self.changes.get(VERDICTS, ()))

    @property
    def largest(self) -> float:
        """The largest relative change of a load, stress, safety, limit or mass."""
        sizes = [
            abs(change.relative)
            for group in (LOADS, STRESSES, SAFETY, LIMITS, MASSES)
            for change in self.changes.get(group, ())
            if change.relative is not None
        ]
        return max(sizes, default=0.0)

    def to_dict(self) -> dict[str, Any]:
        """The difference as plain data."""
        return {
            "name": self.name,
            "a": self.a.to_dict(),
            "b": self.b.to_dict(),
            "same": self.same,
            "changes": {
                group: [change.to_dict() for change in changes]
                for group, changes in self.changes.items()
            },
            "compared": dict(self.compared),
            "only in a": list(self.only_a),
            "only in b": list(self.only_b),
            "notes": list(self.notes),
        }


@dataclass(frozen=True)
class Difference:
    """Everything that differs between A and B; with several designs the ones that turned first."""

    a: str
    b: str
    designs: Sequence[DesignDifference]
    only_a: Sequence[str] = ()
    only_b: Sequence[str] = ()
    notes: Sequence[str] = field(default=())

    @property
    def changed(self) -> list[DesignDifference]:
        """The designs that are not the same."""
        return [design for design in self.designs if not design.same]

    def to_dict(self) -> dict[str, Any]:
        """The difference as plain data."""
        return {
            "format": "ballesta-diff/1",
            "a": self.a,
            "b": self.b,
            "designs": [design.to_dict() for design in self.designs],
            "only in a": list(self.only_a),
            "only in b": list(self.only_b),
            "notes": list(self.notes),
        }


def relative_change(before: float, after: float, scale: float = 0.0) -> float:
    """Change over the size of what was before; infinite from what is 0 beside a scale.

    >>> relative_change(-10.0, -15.0), relative_change(1e-13, 2.0, scale=100.0)
    (-0.5, inf)
    """
    if abs(before) <= ROUND_OFF * scale:
        return inf
    return (after - before) / abs(before)


def largest_first(changes: Sequence[Change]) -> list[Change]:
    """Changes in order: what is no number, numbers by relative change, what one side only has."""
    return sorted(
        changes, key=lambda change: (None in (change.before, change.after), -_size(change))
    )


def _size(change: Change) -> float:
    return inf if change.relative is None else abs(change.relative)
