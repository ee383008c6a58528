"""The value of one input at which a design begins to pass: `--until pass`.

The search is a bisection, which needs an input of which more is safer all along the range, or less:
that is looked at, at both ends and at values spread between them, and where it is not so no value
is given.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from pathlib import Path
from typing import Any, Generic, TypeVar

from ballesta.design.read import read_design
from ballesta.sweeps.sweep import Sweep, parse_sweep, refusal, spread
from checks.design.effort import AUTO, DEFAULT_EFFORT, SOLID, Effort
from checks.design.errors import DesignError, listed, no_such
from checks.result.verdict import Check, DesignResult, Gate, Status, deciding_of, status_of
from checks.result.words import UNKNOWN_BAR, brief, need_text, number, safety_text
from reports.terminal import labelled, table

T = TypeVar("T")
PROBES = 5
TOLERANCE = 1e-3  # of the range
_ORDER = {None: 0, Status.FAIL: 1, Status.UNDECIDED: 2, Status.PASS: 3}
LARGER, SMALLER = "larger", "smaller"
_AT_LIMIT = 0.02  # of the need: what is nearer is the limit of strength
_LIKE = 0.9  # of a safety: what a neighbour has at least, unless the input itself jumps


@dataclass(frozen=True)
class Search(Generic[T]):
    """Result of a search for the value that just passes.

    tried    every value that was checked and its status (None: it cannot be checked), in the order
             of the values
    found    the value at the edge of those that pass; None without one
    beyond   its neighbour, which does not pass; None where every value that was tried passes
    safer    "larger" or "smaller": which values pass; None where the range does not tell
    problem  why no value is found
    """

    tried: tuple[tuple[T, Status | None], ...]
    found: T | None = None
    beyond: T | None = None
    safer: str | None = None
    problem: str = ""


@dataclass(frozen=True)
class Trial:
    """A value of the input that a design was checked with.

    overrides  that set it
    status     of the parts that are judged; None where the design cannot be checked with it
    words      what decides it, or why it cannot be checked
    mass       of all parts, kg; None where it cannot be checked
    unranged   why a model tells nothing of a check with it, where nothing fails; else ""
    effort     models that it was checked with
    check      nearest to its limit; None without any
    """

    overrides: tuple[str, ...]
    status: Status | None
    words: str
    mass: float | None
    unranged: str = ""
    effort: Effort = DEFAULT_EFFORT
    check: Check | None = None

    @property
    def value(self) -> str:
        """The value as written."""
        return self.overrides[0].partition("=")[2]


@dataclass(frozen=True)
class UntilResult:
    """Result of `--until pass`; without parts all of the design is judged."""

    file: str
    sweep: str
    parts: tuple[str, ...]
    not_judged: tuple[str, ...]
    effort: Effort
    trials: tuple[Trial, ...]
    search: Search[tuple[str, ...]]

    @property
    def found(self) -> Trial | None:
        """The trial at the edge of those that pass."""
        return next((t for t in self.trials if t.overrides == self.search.found), None)

    @property
    def exit_code(self) -> int:
        """0 when a value passes, else 1."""
        return 1 if self.found is None else 0

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data."""
        beyond = self.search.beyond
        return {
            "format": "ballesta-until/1",
            "file": self.file,
            "sweep": self.sweep,
            "parts": list(self.parts),
            "options": self.effort.options,
            "found": self.found.value if self.found else None,
            "beyond": beyond[0].partition("=")[2] if beyond else None,
            "safer": self.search.safer,
            "problem": self.search.problem,
            "trials": [
                {
                    "overrides": list(trial.overrides),
                    "value": trial.value,
                    "status": None if trial.status is None else str(trial.status),
                    "decided by": trial.words,
                    "mass [kg]": trial.mass,
                    "fidelity": trial.effort.fidelity,
                    "range of a model": trial.unranged,
                    "limits": None if trial.check is None else _plain(trial.check),
                }
                for trial in self.trials
            ],
        }


def _plain(check: Check) -> dict[str, Any]:
    """A check as plain data: place, model, safety, and safety at the upper end of its bars."""
    safety, least = check.safety, _least(check)
    return {
        "part": check.part,
        "kind": check.kind,
        "place": check.place,
        "method": check.method,
        "safety": safety if isfinite(safety) else None,
        "least safety": least if isfinite(least) else None,
        "needed": check.required,
    }


def _least(check: Check) -> float:
    """Safety at the upper end of the bars; 0 where a bar has none, infinite without load."""
    return check.limit / check.upper if check.upper else inf


def until_pass(
    file: str | Path,
    sweep: str,
    overrides: Sequence[str] = (),
    *,
    parts: Sequence[str] = (),
    effort: Effort = DEFAULT_EFFORT,
    check: Callable[[tuple[str, ...], Effort], DesignResult] | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> UntilResult:
    """Search the smallest value of one input with which a design passes.

    sweep  a range (to a thousandth of it), a range with a count or a step, or a list in its order
    parts  that are judged, by the loads' gates and the linkage's checks, too; all without any
    check  the result of a design with overrides, by models; `ballesta.pipeline.check_file` without
           one

    Where a check lies out of the range of a model below the solid, and nothing fails, the value is
    checked with the next better one (`auto`, then `solid`): what is searched is the limit of the
    part, not of the model.

    A value with which the design cannot be checked as written does not pass. Raises DesignError
    for a wrong sweep or part, and where no value can be checked; NumericsError where a solver gave
    up, as that is no verdict.
    """
    path = Path(file)
    design = read_design(path, overrides)
    for part in parts:
        if part not in design.parts:
            raise DesignError(path, "parts", no_such("part", part, design.parts))
    values = _values(spread(parse_sweep(sweep), design))
    if {value.partition("=")[0] for value in values[0]} & {
        override.partition("=")[0].strip() for override in overrides
    }:
        raise refusal(sweep, "the key that is searched is set by --set, too")
    trials: dict[tuple[str, ...], Trial] = {}
    errors: list[DesignError] = []

    def status(value: tuple[str, ...]) -> Status | None:
        every = (*overrides, *value)
        try:
            for better in _better(effort):
                result = check(every, better) if check else _check(path, every, better)
                trials[value] = replace(_judged(value, result, parts), effort=better)
                if not trials[value].unranged:
                    break
                say(f"{trials[value].value}: {trials[value].unranged}; by a better model")
        except DesignError as error:
            errors.append(error)
            trials[value] = Trial(value, None, str(error), None)
        trial = trials[value]
        say(f"{trial.value}: {trial.status or 'cannot be checked'}, {trial.words}")
        return trial.status

    search = search_passing(status, values)
    if len(errors) == len(trials):
        raise errors[0]
    left_out = tuple(name for name in design.parts if parts and name not in parts)
    ordered = tuple(trials[value] for value, _ in search.tried)
    return UntilResult(str(path), sweep.strip(), tuple(parts), left_out, effort, ordered, search)


def _values(sweep: Sweep) -> list[tuple[str, ...]]:
    if sweep.interval is not None:
        count = round(1 / TOLERANCE)
        return [sweep.at(k / count) for k in range(count + 1)]
    return [sweep.overrides(choice) for choice in sweep.choices]


def _check(path: Path, overrides: tuple[str, ...], effort: Effort) -> DesignResult:
    from ballesta.pipeline import check_file

    return check_file(path, overrides, effort=effort)


def _better(effort: Effort) -> list[Effort]:
    """The models that were asked for, then better ones."""
    rungs = [effort.fidelity, *(rung for rung in (AUTO, SOLID) if rung != effort.fidelity)]
    return [effort] if effort.fidelity == SOLID else [replace(effort, fidelity=r) for r in rungs]


def _unranged(checks: Sequence[Check], gates: Sequence[Gate]) -> str:
    """Reason that a check stays open although nothing fails and the loads hold; "" elsewhere."""
    open_ones = [check for check in checks if check.status is not Status.PASS]
    if any(check.status is Status.FAIL for check in open_ones):
        return ""
    if any(gate.binding and not gate.holds for gate in gates):
        return ""
    for check in open_ones:
        if not isfinite(check.model) and isfinite(check.numerical) and UNKNOWN_BAR in check.note:
            why = check.note.partition(UNKNOWN_BAR)[2]
            return f"{check.part} {check.kind} by {check.method} has no bar ({why})"
    return ""


def _judged(value: tuple[str, ...], result: DesignResult, parts: Sequence[str]) -> Trial:
    """The verdict on the parts that are asked for."""
    judged = [part for part in result.parts if not parts or part.name in parts]
    checks = [*(check for part in judged for check in part.checks), *result.linkage]
    gates = [*result.gates, *(gate for part in judged for gate in part.gates)]
    status = status_of(checks, gates)
    broken = [gate.name for gate in gates if gate.binding and not gate.holds]
    deciding = deciding_of(checks) if checks else None
    words = "nothing was checked" if deciding is None else _decided(deciding)
    if broken and status is Status.UNDECIDED:
        words += f"; validity checks do not hold: {listed(broken)}"
    mass = sum(float(part.facts["mass [kg]"]) for part in result.parts)
    return Trial(value, status, words, mass, _unranged(checks, gates), check=deciding)


def _decided(check: Check) -> str:
    """The deciding check in a line: its safety, also at the upper end of its bars."""
    least = safety_text(_least(check), check.required)
    return (
        f"{check.part} {check.kind}, safety {safety_text(check.safety, check.required)}, "
        f"{least} with its error bars, {need_text(check.required)} required"
    )


def _where(check: Check) -> str:
    """The check, its place and its model."""
    place = f" at {check.place}" if check.place else ""
    return f"{check.part} {check.kind}{place}, by {check.method}"


def until_text(result: UntilResult, width: int = 100) -> str:
    """The trials and the threshold as plain lines of at most `width` columns."""
    lines = labelled(
        "", f"until pass: {brief(result.sweep, 120)} ({brief(result.file, 60)})", width
    )
    rows = [
        [
            brief(trial.value, 24),
            str(trial.status or "–"),
            "" if trial.mass is None else number(trial.mass, 4),
            brief(trial.words, 160),
        ]
        for trial in result.trials
    ]
    found = next((k for k, trial in enumerate(result.trials) if trial is result.found), None)
    heads = ["value", "status", "mass, kg", "decided by"]
    lines += table(heads, rows, {0, 2}, width, marked=found)
    return "\n".join([*lines, *labelled("", _sentence(result), width)]) + "\n"


def _sentence(result: UntilResult) -> str:
    found, search = result.found, result.search
    options = f" with {' '.join(result.effort.options)}" if result.effort.options else ""
    tail = f" {len(result.trials)} checks{options}."
    if result.not_judged:
        tail += (
            f" Judged: {listed(result.parts)}, loads and linkage; not judged: "
            f"{listed(result.not_judged)}."
        )
    if found is None:
        said = [f"{t.value} {t.status or 'cannot be checked'}" for t in result.trials]
        return f"NO VALUE: {search.problem}: {listed(said)}.{tail}"
    if search.beyond is None:
        return (
            f"{found.value} passes, and so does every other value tried: the limit lies outside "
            f"of the range.{tail}"
        )
    edge = "smallest" if search.safer == LARGER else "largest"
    beyond = search.beyond[0].partition("=")[2]
    why = next(trial for trial in result.trials if trial.overrides == search.beyond)
    over = why.check is not None and why.check.utilisation > 1.0
    no_strength = "" if over else why.unranged or _of_bars(found, why)
    if no_strength:
        return (
            f"{found.value} passes, {beyond} does not, but that is NO limit of strength: "
            f"{no_strength}; {search.safer} is safer.{tail}"
        )
    limit = f" {beyond} is limited by {_where(why.check)}." if why.check else ""
    return (
        f"{found.value} is the {edge} that passes, {beyond} does not ({why.status or why.words}); "
        f"{search.safer} is safer.{limit}{tail}"
    )


def _of_bars(found: Trial, beyond: Trial) -> str:
    """Say that bars grow between two values, where the strength of neither is at its limit."""
    last, first = found.check, beyond.check
    if last is None or first is None or first.status is not Status.UNDECIDED:
        return ""
    in_hand = _least(last) / last.required
    if in_hand <= 1 + _AT_LIMIT or first.utilisation > 1.0 or first.safety < _LIKE * last.safety:
        return ""
    return (
        f"{first.part} {first.kind} by {first.method} still has a safety of "
        f"{safety_text(first.safety, first.required)} there, {need_text(first.required)} required, "
        "but its error bars are wider"
    )


def search_passing(
    check: Callable[[T], Status | None], values: Sequence[T], *, probes: int = PROBES
) -> Search[T]:
    """Return where, along values in their order, a check begins or ceases to pass.

    check   the status of a value, or None where it cannot be checked, which is no pass
    probes  how many values between the ends are looked at, evenly spread, before any bisection

    Statuses of all values that are looked at must be in order (FAIL, UNDECIDED, pass, or the other
    way round), else there is no `found` and `problem` says at which values they are not.
    """
    if len(values) < 2 or probes < 0:
        raise ValueError(f"a search needs two values or more, got {len(values)}, {probes} probes")
    known: dict[int, Status | None] = {}

    def passes(index: int) -> bool:
        if index not in known:
            known[index] = check(values[index])
        return known[index] is Status.PASS

    last = len(values) - 1
    places = sorted({round(k * last / (probes + 1)) for k in range(probes + 2)})
    passing = [index for index in places if passes(index)]
    if not passing:
        return Search(_tried(known, values), problem=f"none of {len(known)} values passes")
    if len(passing) == len(places):
        return Search(_tried(known, values), values[0])
    safer = LARGER if passes(last) else SMALLER
    if _ordered(known, safer):
        if safer == LARGER:
            good = passing[0]
            bad = max(index for index in places if index < good)
        else:
            good = passing[-1]
            bad = min(index for index in places if index > good)
        while abs(good - bad) > 1:
            middle = (good + bad) // 2
            good, bad = (middle, bad) if passes(middle) else (good, middle)
        if _ordered(known, safer):
            return Search(_tried(known, values), values[good], values[bad], safer)
    return Search(
        _tried(known, values), problem="passing does not go one way with this input over its range"
    )


def _ordered(known: dict[int, Status | None], safer: str) -> bool:
    ranks = [_ORDER[known[index]] for index in sorted(known, reverse=safer == SMALLER)]
    return ranks == sorted(ranks)


def _tried(
    known: dict[int, Status | None], values: Sequence[T]
) -> tuple[tuple[T, Status | None], ...]:
    return tuple((values[index], known[index]) for index in sorted(known))
