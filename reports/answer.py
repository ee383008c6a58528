"""The answer in about twenty lines: verdict, place, moment, why, each part's governing check."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path
from shlex import quote
from shutil import get_terminal_size

from rich.cells import cell_len

from checks.result.verdict import Check, DesignResult, PartResult, Status, deciding_of
from checks.result.ways import way_text
from checks.result.words import (
    assumptions,
    broken_gates,
    check_titles,
    clean,
    clipped,
    gate_sentence,
    moment,
    need_text,
    number,
    open_reason,
    range_text,
    safety_text,
    value_and_bars,
)
from reports.terminal import footer, labelled, table_row

_HEADINGS = ("part", "governing check", "value", "limit", "safety (needed)", "verdict")
_NARROWEST = (8, 10, 10, 5, 6, 9)  # columns that each keeps
_RIGHT = {2, 3, 4}
_MOST_WARNINGS = 4
_MOST_GATES = 3
_MOST_WAYS = 3
_LONGEST = 300  # letters of one sentence, so that no name floods the answer


def answer_text(
    result: DesignResult, width: int | None = None, report: str | Path | None = None
) -> str:
    """Verdict and its reason as plain lines of at most `width` columns.

    width   None: the terminal's width (COLUMNS counts), and 100 when piped
    report  path that the last line names

    Each part has its governing check alone, and parts of one outcome share a row; `verdict_text`
    has all checks. Of a warning the first sentence stands here.
    """
    width = max(60, width or get_terminal_size((100, 24)).columns)
    status = str(result.status).upper()
    lines = labelled("", f"{_short(result.name)} ({clean(result.file)}): {status}", width)
    for override in result.overrides:
        lines += labelled("set", _short(override), width)
    for label, text in _headline(result):
        lines += labelled(label, text, width, indent=13)
    if result.checks:
        lines += ["", *_table(result, width), ""]
    for label, text in _beside(result):
        lines += labelled(label, text, width, indent=13)
    lines += footer(result, report, width)
    return "\n".join(lines) + "\n"


def _headline(result: DesignResult) -> Iterator[tuple[str, str]]:
    """The deciding check: its safety, place and moment, and why it is open."""
    if not result.checks:
        yield "why", "nothing was checked"
        return
    check = result.deciding
    title = dict(zip(map(id, result.checks), check_titles(result.checks), strict=True))[id(check)]
    within = range_text(check)
    bars = f"; {within} within its error bars" if within and check.value else ""
    safety = f"{_safety(check)}, {need_text(check.required)} needed{bars}"
    yield "safety", safety
    yield "decided by", f"{_short(title)} of {_short(check.part)}"
    place = clean(check.place)
    yield "where", place or "whole part"
    if when := clean(moment(check)):
        yield "when", when
    if check.status is Status.UNDECIDED:
        yield "why open", open_reason(check)
    if check.status is Status.FAIL:
        yield "why", "the limit is exceeded even at the lower end of the error bars"
    if any(check.status is not Status.PASS for part in result.parts for check in part.checks):
        sets = "".join(f" --set {quote(override)}" for override in result.overrides)
        yield (
            "to pass",
            _short(f"ballesta improve {quote(clean(result.file))}{sets}")
            + (": least single changes"),
        )
    broken = broken_gates(result)
    for owner, gate in broken[:_MOST_GATES]:
        effect = "NOT VALID" if gate.binding else "not valid"
        whose = "" if owner == "loads" else f"{_short(owner)}: "
        yield effect, f"{whose}{_short(gate_sentence(gate))}; {_short(gate.told)}"
    if len(broken) > _MOST_GATES:
        yield "not valid", f"{len(broken) - _MOST_GATES} more validity checks do not hold"
    for text, command in map(way_text, result.ways[:_MOST_WAYS]):
        yield "way out", f"{_short(text)}: {clean(command)}" if command else _short(text)


def _safety(check: Check) -> str:
    return safety_text(check.safety, check.required)


def _table(result: DesignResult, width: int) -> list[str]:
    """One row for each part's governing check; parts that differ in their name alone share it."""
    owners: list[tuple[str, list[Check]]] = [(p.name, list(p.checks)) for p in result.parts]
    owners.append(("linkage", list(result.linkage)))
    rows = []
    for name, checks in owners:
        if checks:
            check = deciding_of(checks)
            title = check_titles(checks)[next(k for k, c in enumerate(checks) if c is check)]
            rows.append((name, check, _row(check, title)))
    rows.sort(key=lambda row: row[2])
    merged = [list(group) for _, group in groupby(rows, key=lambda row: row[2])]
    order = {name: k for k, (name, _) in enumerate(owners)}
    merged.sort(key=lambda group: min(order[name] for name, _, _ in group))
    table = [[", ".join(_short(n) for n, _, _ in group), *group[0][2]] for group in merged]
    widths = [max(cell_len(row[i]) for row in (*table, _HEADINGS)) for i in range(len(_HEADINGS))]
    for column in (0, 1, 2, 4, 3, 5):
        lack = sum(widths) + len(widths) + 2 - width
        widths[column] -= max(0, min(lack, widths[column] - _NARROWEST[column]))
    lines = table_row("  ", list(_HEADINGS), widths, _RIGHT)
    for group, row in zip(merged, table, strict=True):
        decides = any(check is result.deciding for _, check, _ in group)
        lines += table_row("> " if decides else "  ", row, widths, _RIGHT)
    rest = len(result.checks) - sum(len(group) for group in merged)
    if rest:
        open_ = sum(c.status is not Status.PASS for c in result.checks) - sum(
            check.status is not Status.PASS for group in merged for _, check, _ in group
        )
        said = f"{open_} of them open or failed" if open_ else "all pass"
        others = f"and {rest} other check{'s' if rest > 1 else ''}"
        lines.append(f"  {others}, {said}" if rest > 1 else f"  {others}, it {_outcome(open_)}")
    return lines


def _outcome(open_: int) -> str:
    return "is open or fails" if open_ else "passes"


def _row(check: Check, title: str) -> tuple[str, ...]:
    value, numerical, model = value_and_bars(check)
    bars = " ".join(bar for bar in (numerical, model) if bar != "±0")
    status = "pass" if check.status is Status.PASS else str(check.status)
    return (
        _short(title),
        " ".join(filter(None, (value, bars, clean(check.unit)))),
        number(check.limit),
        f"{_safety(check)} ({need_text(check.required)})",
        status,
    )


def _beside(result: DesignResult) -> Iterator[tuple[str, str]]:
    """Mass, warnings, assumptions, and subjects that no check covers."""
    if mass := _mass(result.parts):
        yield "mass", mass
    assumed, defaults = assumptions(result), len(result.defaults)
    counts = [f"{len(assumed)} assumption{'' if len(assumed) == 1 else 's'}"] if assumed else []
    counts += [f"{defaults} default value{'' if defaults == 1 else 's'}"] if defaults else []
    if counts:
        own = [part for part in result.parts if result.checks and part.name == result.deciding.part]
        first = [
            f"of {_short(part.name)}: {_first(part.assumed[0])}" for part in own if part.assumed
        ]
        yield "assumed", "; ".join([" and ".join(counts), *first])
    if result.not_checked:
        subjects = ", ".join(dict.fromkeys(_first(s).partition(",")[0] for s in result.not_checked))
        yield "not checked", f"{subjects} and what belongs to them"
    for warning in result.warnings[:_MOST_WARNINGS]:
        yield "warning", _short(clean(warning).partition(". ")[0])
    if len(result.warnings) > _MOST_WARNINGS:
        yield "warning", f"and {len(result.warnings) - _MOST_WARNINGS} more"
    yield "more", "-v prints all checks, warnings, assumptions and models tried; so does the report"


def _mass(parts: Sequence[PartResult]) -> str:
    key = "mass [kg]"
    masses = [(part.name, float(part.facts[key])) for part in parts if key in part.facts]
    if not masses:
        return ""
    one_by_one = ", ".join(f"{_short(name)} {number(mass)}" for name, mass in masses[:6])
    more = f" and {len(masses) - 6} more" if len(masses) > 6 else ""
    total = number(sum(mass for _, mass in masses))
    return f"{total} kg ({one_by_one}{more})" if len(masses) > 1 else f"{total} kg"


def _first(text: str) -> str:
    """A text up to its first semicolon."""
    return _short(clean(text).partition(";")[0])


def _short(text: object) -> str:
    return clipped(text, _LONGEST)
