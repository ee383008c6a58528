"""The answer as data: what decides, how far, where, when, why, and what would make it pass.

The terminal (`answer_text`) and the first screen of the page write the same facts.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, product
from math import isfinite
from pathlib import Path

from checks.result.verdict import Check, DesignResult, PartResult, Status, Way, deciding_of
from checks.result.ways import (
    LEAST,
    NOTHING,
    SAVED,
    change_cells,
    change_text,
    improve_command,
    lower_by,
    run_in_edges,
)
from checks.result.words import (
    assumptions,
    check_titles,
    clean,
    clipped,
    moment,
    need_text,
    number,
    open_reason,
    range_text,
    safety_text,
    value_and_whole_bar,
)
from reports.gauge import shares
from reports.loads_words import broken_of
from reports.terminal import labelled, line_width, report_line, table, wrap

_MOST_LINES = 25
_MOST_WARNINGS = 2
_MOST_GATES = 3  # told in short beside the first of their kind
_MOST_WAYS = 2
_LONGEST_LIST = 75  # letters of subjects that no check covers: a line of a terminal
_MOST_MASSES = 4
_LONGEST_MEANING = 160  # letters of what a validity check measures, told beside its number
_LONGEST = 300  # letters of one sentence, so that no name floods the answer


@dataclass(frozen=True)
class Fact:
    """A label and what there is to say, with the command that does it, if there is one.

    grave  True if the result does not hold without it
    cells  the text as the cells of a row, where several facts make a table
    """

    label: str
    text: str
    command: str = ""
    grave: bool = False
    cells: tuple[str, ...] = ()

    @property
    def line(self) -> str:
        """Text and command in one."""
        return f"{self.text}: {self.command}" if self.command else self.text


@dataclass(frozen=True)
class PartRow:
    """Parts of one outcome and their governing check, each cell as text.

    check    of the first of the `count` parts
    decides  True if one of their checks decides the verdict
    """

    parts: str
    title: str
    value: str
    limit: str
    safety: str
    verdict: str
    check: Check
    count: int
    decides: bool

    @property
    def cells(self) -> tuple[str, ...]:
        """The cells in the order of `HEADINGS`."""
        return self.parts, self.title, self.value, self.limit, self.safety, self.verdict


HEADINGS = ("part", "governing check", "value", "limit", "safety (required)", "verdict")


@dataclass(frozen=True)
class Answer:
    """Content of the first lines and of the first screen.

    name, file, status  of the design; overrides as `--set` took them
    outcome    number of checks of each outcome, in words
    check      that decides; None where nothing was checked. title: its kind
    safety     its safety, in words; required: what it must show
    within     the range of its safety by its error bars, in words; "" without bars
    headline   what decides, where, when, why, changes that make it pass, ways out of what is open,
               what is not valid or not met
    beside     mass, assumptions, what is not checked
    rows       one for each part's governing check; others: the rest in one line
    warnings   the first of them, and how many more
    """

    name: str
    file: str
    status: Status
    overrides: Sequence[str]
    outcome: str
    check: Check | None
    title: str
    safety: str
    required: str
    within: str
    headline: Sequence[Fact]
    beside: Sequence[Fact]
    rows: Sequence[PartRow]
    others: str
    warnings: Sequence[Fact]


def answer_of(result: DesignResult) -> Answer:
    """Return the answer of a result."""
    check = result.deciding if result.checks else None
    titles = dict(zip(map(id, result.checks), check_titles(result.checks), strict=True))
    rows = _rows(result)
    return Answer(
        name=_short(result.name),
        file=clean(result.file),
        status=result.status,
        overrides=[_short(override) for override in result.overrides],
        outcome=_outcome(result),
        check=check,
        title=_short(titles[id(check)]) if check else "",
        safety=_safety(check) if check else "",
        required=need_text(check.required) if check else "",
        within=range_text(check) if check and check.value else "",
        headline=list(_headline(result, titles)),
        rows=rows,
        others=_others(result, rows),
        beside=list(_beside(result)),
        warnings=list(_warnings(result, _MOST_WARNINGS)),
    )


def _outcome(result: DesignResult) -> str:
    """Number of checks of each outcome: "2 of 23 checks open, 21 pass"."""
    count = len(result.checks)
    if not count:
        return "nothing was checked"
    outcomes = [check.status for check in result.checks]
    failed, open_ = outcomes.count(Status.FAIL), outcomes.count(Status.UNDECIDED)
    passed = count - failed - open_
    doubted = any(gate.binding and not gate.holds for gate in result.gates)
    proven = "; no pass is proven" if doubted and passed else ""
    if passed == count:
        return f"all {count} checks pass{proven}" if count > 1 else f"the one check passes{proven}"
    said = [f"{failed} fail{'s' if failed == 1 else ''}"] if failed else []
    said += [f"{open_} open"] if open_ else []
    said += [f"{passed} pass{'es' if passed == 1 else ''}"] if passed else []
    return f"of {count} check{'s' if count > 1 else ''} {', '.join(said)}{proven}"


def _headline(result: DesignResult, titles: dict[int, str]) -> Iterator[Fact]:
    """The deciding check: place, moment, why it is open, and what to do."""
    if not result.checks:
        yield Fact("why", "nothing was checked")
        return
    check = result.deciding
    yield Fact("decided by", f"{_short(titles[id(check)])} of {_short(check.part)}")
    yield Fact("where", clean(check.place) or "whole part")
    if when := clean(moment(check)):
        yield Fact("when", when)
    if check.status is Status.UNDECIDED:
        yield Fact("why open", open_reason(check))
    if check.status is Status.FAIL:
        yield Fact("why", "the limit is exceeded even at the lower end of the error bars")
    for edges in run_in_edges(result) if result.status is Status.PASS else ():
        yield Fact("rests on", _short(edges))
    yield from _changes(result)
    ways = _ways(result)
    yield from ways
    broken = broken_of(result)
    for binding, alike in groupby(broken, key=lambda gates: gates.binding):
        first, *left = alike
        told = first.told if len(first.told) <= _LONGEST_MEANING else first.cure
        if any(told in way.text for way in ways):
            told = ""  # stands above
        more = len(left) - _MOST_GATES
        shorts = [gates.short for gates in left[:_MOST_GATES]]
        said = (first.short, told, *shorts, f"and {more} more" if more > 0 else "")
        label = "NOT VALID" if binding else "not met"
        yield Fact(label, _short("; ".join(filter(None, said))), "", binding)
    if result.all_gates and not broken:
        yield Fact("validity", f"all {len(result.all_gates)} validity checks hold")


def _ways(result: DesignResult) -> list[Fact]:
    """The cheapest ways out; those that settle nothing are left out, since why stands above.

    What makes a failed check pass stands above, too. Beside a failed check, a way counts that can
    prove a part that does not fail. Ways of other checks alone wait for those of the deciding one.
    """
    changes = improve_command(result)
    failed = result.status is Status.FAIL
    fail = {_owner(check) for check in result.checks if check.status is Status.FAIL}
    ways = [
        way
        for way in result.ways
        if not way.text.startswith(NOTHING)
        and way.command != changes
        and not (failed and way.text.endswith(f"it is a {Status.FAIL}"))
        and any(one.rpartition(" of ")[2] not in fail for one in way.settled)
    ]
    label, most = ("also open", 1) if failed else ("way out", _MOST_WAYS)
    deciding = _deciding(result)
    ways = [way for way in ways if deciding in way.settled] or ways
    return [Fact(label, _way_text(way, result), clean(way.command)) for way in ways[:most]]


def _deciding(result: DesignResult) -> str:
    """Name of the deciding check, as ways have it."""
    titles = dict(zip(map(id, result.checks), check_titles(result.checks), strict=True))
    return f"{titles[id(result.deciding)]} of {_owner(result.deciding)}" if titles else ""


def _owner(check: Check) -> str:
    """Whose check it is, as ways have it."""
    return check.part if check.part != "linkage" else "the linkage"


def _way_text(way: Way, result: DesignResult) -> str:
    """A way with its time, and for how many checks it is, if not for the one that decides alone."""
    settled = way.settled
    owner = "" if way.settles == _deciding(result) else f"{way.settles}: "
    of = f" ({len(settled)} checks)" if len(settled) > 1 else ""
    time = "" if way.seconds is None else f" (about {number(way.seconds, 2)} s)"
    return _short(f"{'' if of else owner}{way.text.partition('; ')[0]}{of}{time}")


def _changes(result: DesignResult) -> Iterator[Fact]:
    """Single changes that would make it pass, or save mass, and the command that checks them."""
    command = _short(clean(improve_command(result)))
    passes = all(check.status is Status.PASS for check in result.checks)
    label = "to save" if passes else "to pass"
    if not result.changes and not (passes or isfinite(result.deciding.upper)):
        told = "no change is estimated without a model that knows its error bar"
        yield Fact(label, "; ".join(filter(None, (lower_by(result.deciding), told))))
        return
    if not result.changes:
        less = "" if passes else lower_by(result.deciding)
        said = result.unchanged or (SAVED if passes else LEAST)
        yield Fact(label, "; ".join(filter(None, (less, said))), command * (not result.unchanged))
        return
    for change in result.changes:
        cells = tuple(map(_short, change_cells(change, result.deciding)))
        yield Fact(label, _short(change_text(change, result.deciding)), cells=cells)
        label = "or"
    models = " and ".join(sorted({clean(change.model) for change in result.changes}))
    by = "by formula" + ("" if models == "formula" else f", set against the {models}")
    settled = {part for change in result.changes for part in change.parts}
    open_ = [p.name for p in result.parts if any(c.status is not Status.PASS for c in p.checks)]
    if left := [_short(name) for name in open_ if name not in settled]:
        by += f"; {', '.join(left)} {'does' if len(left) == 1 else 'do'} not pass by these"
    yield Fact("estimated", f"{by}; checked by", f"{command} --verify")


def _safety(check: Check) -> str:
    return safety_text(check.safety, check.required)


def _rows(result: DesignResult) -> list[PartRow]:
    """One row for each part's governing check; parts whose safeties read the same share it.

    Its value belongs to the part nearest to its limit.
    """
    owners: list[tuple[str, list[Check]]] = [(p.name, list(p.checks)) for p in result.parts]
    owners.append(("linkage", list(result.linkage)))
    found = []
    for name, checks in owners:
        if checks:
            check = deciding_of(checks)
            title = check_titles(checks)[next(k for k, c in enumerate(checks) if c is check)]
            found.append((name, check, _row(check, title)))
    found.sort(key=lambda row: (_shared(row[2]), -row[1].value * row[1].required / row[1].limit))
    merged = [list(group) for _, group in groupby(found, key=lambda row: _shared(row[2]))]
    order = {name: k for k, (name, _) in enumerate(owners)}
    merged.sort(key=lambda group: min(order[name] for name, _, _ in group))
    return [
        PartRow(
            ", ".join(
                _short(name) for name in sorted((g[0] for g in group), key=order.__getitem__)
            ),
            *group[0][2],
            check=group[0][1],
            count=len(group),
            decides=any(check is result.deciding for _, check, _ in group),
        )
        for group in merged
    ]


def _shared(cells: tuple[str, str, str, str, str]) -> tuple[str, str, str, str]:
    """The cells that parts of one row have alike: all but the value."""
    title, _, limit, safety, verdict = cells
    return title, limit, safety, verdict


def _others(result: DesignResult, rows: Sequence[PartRow]) -> str:
    """The checks that have no row, in one line; "" without any."""
    rest = len(result.checks) - sum(row.count for row in rows)
    if not rest:
        return ""
    shown = [row.check.status for row in rows for _ in range(row.count)]
    words = {Status.PASS: "pass", Status.UNDECIDED: "open", Status.FAIL: "failed"}
    counts = {
        word: sum(check.status is status for check in result.checks) - shown.count(status)
        for status, word in words.items()
    }
    told = ", ".join(f"{count} {word}" for word, count in counts.items() if count)
    if counts["pass"] == rest:
        return f"and {rest} other checks, all pass" if rest > 1 else "and 1 other check, it passes"
    return f"and {rest} other check{'s' if rest > 1 else ''}: {told}"


def _row(check: Check, title: str) -> tuple[str, str, str, str, str]:
    status = "pass" if check.status is Status.PASS else str(check.status)
    return (
        _short(title),
        " ".join(filter(None, (*value_and_whole_bar(check), clean(check.unit)))),
        number(check.limit),
        f"{_safety(check)} ({need_text(check.required)})",
        status,
    )


def _beside(result: DesignResult) -> Iterator[Fact]:
    """Mass, assumptions, and subjects that no check covers."""
    if mass := _mass(result.parts):
        yield Fact("mass", mass)
    assumed, defaults = assumptions(result), len(result.defaults)
    if assumed or defaults:
        kind, count = ("assumption", len(assumed)) if assumed else ("default", defaults)
        known = result.checks and isfinite(result.deciding.upper)  # else "why open" tells it
        widest = shares(result.deciding)[:1] if known else []
        first = [f"widest: {_cause(share.name)}, safety {share.ends}" for share in widest]
        counted = f"{count} {kind}{'' if count == 1 else 's'}"
        yield Fact("assumed", "; ".join([counted, *first]))
    if result.not_checked:
        subjects = list(dict.fromkeys(_first(s).partition(",")[0] for s in result.not_checked))
        fits = [len(", ".join(subjects[:k])) <= _LONGEST_LIST for k in range(len(subjects) + 1)]
        first = subjects[: max(1, sum(fits) - 1)]
        more = len(subjects) - len(first)
        yield Fact("not checked", ", ".join(first) + (f" and {more} more" if more else ""))


def _cause(name: str) -> str:
    """An assumption without the words about it."""
    return _short(name.partition(": ")[0])


def _warnings(result: DesignResult, most: int) -> Iterator[Fact]:
    more = len(result.warnings) - most
    for k, warning in enumerate(result.warnings[:most], 1):
        tail = f"; and {more} more" if k == most and more > 0 else ""
        yield Fact("warning", _short(clean(warning).partition(". ")[0]) + tail)


def _mass(parts: Sequence[PartResult]) -> str:
    key = "mass [kg]"
    masses = [(part.name, float(part.facts[key])) for part in parts if key in part.facts]
    if not masses:
        return ""
    total = number(sum(mass for _, mass in masses))
    more = ""
    if len(masses) > _MOST_MASSES:
        masses.sort(key=lambda entry: -entry[1])
        more = f" and {len(masses) - _MOST_MASSES + 1} lighter"
        del masses[_MOST_MASSES - 1 :]
    one_by_one = ", ".join(f"{_short(name)} {number(mass)}" for name, mass in masses)
    return f"{total} kg ({one_by_one}{more})" if len(masses) > 1 else f"{total} kg"


def _first(text: str) -> str:
    """A text up to its first semicolon."""
    return _short(clean(text).partition(";")[0])


def _short(text: object) -> str:
    return clipped(text, _LONGEST)


# The answer in about twenty lines: verdict, place, moment, why, each part's governing check.

_INDENT = 13


def first_word(result: DesignResult) -> str:
    """Verdict and deciding check on one line, for who waits until the whole answer stands."""
    told = f"{clean(result.file)}: {str(result.status).upper()}"
    if not result.checks:
        return told
    check = result.deciding
    safety = f"safety {_safety(check)}, {need_text(check.required)} required"
    return f"{told}, {safety}, {check.kind} of {_short(check.part)}"


def answer_text(
    result: DesignResult, width: int | None = None, report: str | Path | None = None
) -> str:
    """Verdict and its reason as plain lines of at most `width` columns.

    width   None: the terminal's width (COLUMNS counts), and 100 when piped
    report  path that the last line names

    Each part has its governing check alone, and parts of one outcome share a row; `verdict_text`
    has all checks. Of a warning the first sentence stands here; the second warning, the changes
    after the first and the dearer way out where the text keeps to 25 lines with them.
    """
    width = line_width(width)
    answer = answer_of(result)
    lines = labelled("", f"{answer.name} ({answer.file}): {str(answer.status).upper()}", width)
    for override in answer.overrides:
        lines += labelled("set", override, width)
    if answer.check:
        bars = f"; {answer.within} within its error bars" if answer.within else ""
        said = f"{answer.safety}, {answer.required} required{bars}"
        lines += labelled("safety", said, width, indent=_INDENT)
    headline = list(_with_place(answer.headline))
    below = _facts(answer.beside, width)
    if answer.rows:
        below += ["", *_table(answer, width)]
    others = f"{answer.others or 'no other check'}; -v tells all"
    below += [f"  {line}" for line in wrap(others, width - 2)]
    below += report_line(report)
    fewer = [headline]
    for label, kept in (("or", 1), ("way out", 1), ("or", 0)):
        dropped = [fact for fact in fewer[-1] if fact.label == label][kept:]
        fewer.append([fact for fact in fewer[-1] if fact not in dropped])
    for facts, most in product(fewer, range(_MOST_WARNINGS, 0, -1)):
        above = [*lines, *_facts(facts, width), *_facts(_warnings(result, most), width)]
        if len(above) + len(below) <= _MOST_LINES:
            break
    return "\n".join([*above, *below]) + "\n"


def _facts(facts: Iterable[Fact], width: int) -> list[str]:
    lines: list[str] = []
    for fact in facts:
        lines += labelled(fact.label, fact.line.removeprefix("parts."), width, indent=_INDENT)
    return lines


def _with_place(headline: Iterable[Fact]) -> Iterator[Fact]:
    """The facts with the place behind the check that decides, in one line."""
    facts = iter(headline)
    for fact in facts:
        if fact.label == "decided by":
            fact = replace(fact, text=f"{fact.text}: {next(facts).text}")
        yield fact


def _table(answer: Answer, width: int) -> list[str]:
    decides = next((k for k, row in enumerate(answer.rows) if row.decides), None)
    return table(HEADINGS, [row.cells for row in answer.rows], {2, 3, 4}, width, marked=decides)
