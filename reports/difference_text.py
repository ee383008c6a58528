"""Differences between two designs or two runs: plain data, their text, the page with that text."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from decimal import ROUND_FLOOR, ROUND_HALF_EVEN
from math import inf, isinf
from pathlib import Path
from typing import Any

from checks.result.plain_data import plain_fields
from checks.result.words import brief, number
from reports.files import write_text
from reports.templating import page_template
from reports.terminal import labelled, line_width, table

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
        plain = plain_fields(self)
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
        return plain_fields(self)


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
        own = plain_fields(self, "changes", "only_a", "only_b")
        return own | {
            "same": self.same,
            "changes": {
                group: [change.to_dict() for change in changes]
                for group, changes in self.changes.items()
            },
            "only in a": list(self.only_a),
            "only in b": list(self.only_b),
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
        only = {"only in a": list(self.only_a), "only in b": list(self.only_b)}
        return {"format": "ballesta-diff/1"} | plain_fields(self, "only_a", "only_b") | only


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


SHOWN = 12  # changes of a group in text, but verdicts; the page and JSON have all
_VERDICTS_SHOWN = 100
_MOST_DIGITS = 12
_LISTED = 8  # of what only one side has


def difference_text(difference: Difference, width: int | None = None) -> str:
    """Differences as plain lines of at most `width` columns.

    width  None: the terminal's width (COLUMNS counts), and 100 when piped
    """
    width = line_width(width)
    lines = labelled("A", brief(difference.a, 300), width)
    lines += labelled("B", brief(difference.b, 300), width)
    for note in difference.notes:
        lines += labelled("NOTE", brief(note, 400), width)
    for label, names in (("ONLY IN A", difference.only_a), ("ONLY IN B", difference.only_b)):
        if names:
            lines += labelled(label, _few(names), width)
    for design in difference.changed:
        lines += ["", *_design(design, width)]
    same = [design.name for design in difference.designs if design.same]
    if same:
        lines.append("")
        told = [design for design in difference.designs if design.same]
        lines += labelled("SAME", _few(same), width)
        for design in told:
            for note in design.notes:
                lines += labelled("NOTE", f"{brief(design.name, 40)}: {brief(note, 400)}", width)
    lines += ["", *labelled("", summary_sentence(difference), width)]
    return "\n".join(lines) + "\n"


def summary_sentence(difference: Difference) -> str:
    """Sentence on the designs and verdicts that differ, and the difference that counts as none."""
    count, turned = len(difference.designs), sum(design.turned for design in difference.designs)
    if not difference.changed:
        said = f"no difference in {_designs(count)}"
    else:
        verdicts = f"{turned} verdict{'' if turned == 1 else 's'}" if turned else "no verdict"
        differ = "differs" if len(difference.changed) == 1 else "differ"
        said = f"{len(difference.changed)} of {_designs(count)} {differ}, in {verdicts}"
    return f"{said}; numbers that agree to {ROUND_OFF:g} count as the same"


def _designs(count: int) -> str:
    return f"{count} design{'' if count == 1 else 's'}"


def _design(design: DesignDifference, width: int) -> list[str]:
    lines = labelled("", f"{brief(design.name, 80)}", width)
    for label, side in (("A", design.a), ("B", design.b)):
        told = f"{brief(side.path, 100)}: {brief(side.status, 12)} ({brief(side.made, 200)})"
        lines += labelled(label, told, width)
    for note in design.notes:
        lines += labelled("NOTE", brief(note, 400), width)
    for group in GROUPS:
        changes = design.changes.get(group, ())
        if changes:
            lines += _group(group, changes, design.compared.get(group, 0), width)
    for label, names in (("ONLY IN A", design.only_a), ("ONLY IN B", design.only_b)):
        for name in names[:_LISTED]:
            lines += labelled(label, brief(name, 300), width)
        if len(names) > _LISTED:
            lines += labelled(label, f"{len(names) - _LISTED} more, in --html and --json", width)
    return lines


def _group(group: str, changes: Sequence[Change], compared: int, width: int) -> list[str]:
    title = f"{group.upper()}: {len(changes)} of {compared} changed"
    if group != VERDICTS:
        title += ", the largest first"
    shown = changes[: _VERDICTS_SHOWN if group == VERDICTS else SHOWN]
    rows = [
        [
            brief(change.of, 60),
            brief(change.what, 80),
            *values_text(change, group),
            change_text(change),
            brief(change.note, 160),
        ]
        for change in shown
    ]
    heads = ["of", "what", "A", "B", "change", ""]
    lines = [*labelled("", title, width), *table(heads, rows, {4}, width)]
    if len(shown) < len(changes):
        lines.append(f"  {len(changes) - len(shown)} more, in --html and --json")
    return lines


def values_text(change: Change, group: str) -> tuple[str, str]:
    """Both values with their unit, to four digits or as many as tell them apart.

    Safeties are rounded down, so that none looks better than it is.
    """
    rounding = ROUND_FLOOR if group == SAFETY else ROUND_HALF_EVEN
    digits = 4
    before, after = change.before, change.after
    if isinstance(before, float) and isinstance(after, float):
        while digits < _MOST_DIGITS and number(before, digits, rounding) == number(
            after, digits, rounding
        ):
            digits += 1
    one, other = (_value_text(value, change.unit, digits, rounding) for value in (before, after))
    return one, other


def _value_text(value: float | str | None, unit: str, digits: int, rounding: str) -> str:
    if value is None:
        return "–"
    if isinstance(value, str):
        return brief(value, 60)
    return f"{number(value, digits, rounding)} {brief(unit, 8)}".strip()


def change_text(change: Change) -> str:
    """Relative change in %, with three digits at most."""
    if change.relative is None:
        return ""
    if isinf(change.relative):
        return "from 0"
    percent = 100 * change.relative
    if percent >= 1000:
        return f"x {number(1 + change.relative, 3)}"
    return f"{'+' if percent >= 0 else ''}{number(percent, 3)} %"


def _few(names: Sequence[str]) -> str:
    shown = names[: 5 * _LISTED]
    more = f", and {len(names) - len(shown)} more" if len(names) > len(shown) else ""
    return ", ".join(brief(name, 60) for name in shown) + more


def difference_html(difference: Difference) -> str:
    """Page as text. The same difference gives the same page."""
    template = page_template("difference", change=change_text, amounts=values_text)
    return template.render(
        difference=difference,
        sentence=summary_sentence(difference),
        groups=GROUPS,
        round_off=f"{ROUND_OFF:g}",
    )


def write_difference(difference: Difference, path: str | Path) -> None:
    """Write the page as a file, which is there whole or not at all."""
    write_text(path, difference_html(difference))
