"""Single changes that make a design pass, or save mass where it passes: `ballesta improve`.

Every dimension of a part, and its material, is varied by formula (`ballesta.sweeps.screen`). A
change multiplies the demand that the deciding model has found, and its upper end, by the ratio of
the formula's demands after and before; where the formula decided, by the ratio of its upper ends.
With the reserve r, the least of limit over (upper demand times required safety) of a part's checks,
and a dimension x, r ~ x^p locally: p from two steps of 3 %, then three secant steps on log r over
log x, rounded to the safe side. A change is an estimate until a check by the deciding model has
verified it.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, exp, floor, inf, isfinite, log, log10
from pathlib import Path
from typing import Any

from ballesta.design.read import read_design
from ballesta.sweeps.screen import Screened, screen
from checks.design.data import Design
from checks.design.effort import DEFAULT_EFFORT, Effort
from checks.design.materials import known_materials
from checks.result.verdict import Check, DesignResult, Status

_DIMENSION = re.compile(r"^\s*(\d+(?:\.\d+)?)\s*(mm|cm|m|deg)\s*$")
_STEP = 0.03  # of a dimension, to find its exponent
_MATTERS = 0.05  # the least exponent: what changes the reserve less is no way out
MOST = 2.0  # the largest change that is looked at, as a factor
_SECANTS = 3
_NEXT = 1e-6  # of a dimension: to the next rounded value
_DIGITS = 2  # of the change, to which a dimension is rounded
_BEST = 3

Verify = Callable[[tuple[str, ...]], DesignResult]


@dataclass(frozen=True)
class Change:
    """One input with another value, and its effect.

    key, was, value  the input and its values as written
    parts            that pass with it, of those that it is meant for
    safety, least    of the check that then governs these: at its value, at the end of its bars
    required         safety that this check must show
    governing        that check in words
    mass             t, of all parts; saved is what it is less than before
    verified         the verdict of a check by the deciding model; None where none was made
    """

    key: str
    was: str
    value: str
    parts: tuple[str, ...]
    safety: float
    least: float
    required: float
    governing: str
    mass: float
    saved: float
    verified: Status | None = None
    verified_safety: float | None = None

    @property
    def override(self) -> str:
        """The change as `--set` takes it."""
        return f"{self.key}={self.value}"


@dataclass(frozen=True)
class Improved:
    """The best single changes of a design, best first.

    result   of the design as it is
    open     parts that do not pass; the changes are meant for them, else they save mass
    changes  at most three for each set of parts
    """

    result: DesignResult
    open: tuple[str, ...]
    changes: tuple[Change, ...]

    @property
    def exit_code(self) -> int:
        """0 where the design passes or a change makes every open part pass, else 1."""
        solved = {part for change in self.changes for part in change.parts}
        return 0 if solved >= set(self.open) else 1

    def to_dict(self) -> dict[str, Any]:
        """As plain data; masses in kg."""
        return {
            "format": "ballesta-improve/1",
            "file": self.result.file,
            "status": str(self.result.status),
            "open": list(self.open),
            "changes": [
                {
                    "key": change.key,
                    "was": change.was,
                    "value": change.value,
                    "parts": list(change.parts),
                    "safety": _number(change.safety),
                    "least safety": _number(change.least),
                    "required": change.required,
                    "governing": change.governing,
                    "mass [kg]": 1e3 * change.mass,
                    "saved [kg]": 1e3 * change.saved,
                    "verified": None if change.verified is None else str(change.verified),
                    "verified safety": change.verified_safety,
                    "command": f"ballesta check {self.result.file} --set '{change.override}'",
                }
                for change in self.changes
            ],
        }


def _number(value: float) -> float | None:
    return value if isfinite(value) else None


def improve(
    file: str | Path,
    overrides: Sequence[str] = (),
    *,
    effort: Effort = DEFAULT_EFFORT,
    verify: bool = False,
    check: Verify | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> Improved:
    """Find the best single changes of a design.

    verify  whether each change that is shown is checked by the models of `effort`
    check   the result of the design with further overrides; `ballesta.pipeline.check_file` without

    Raises DesignError and NumericsError as a check does.
    """
    path = Path(file)
    design = read_design(path, overrides)
    checked = check or _checker(path, overrides, effort)
    result = checked(())
    search = _Search(design, result)
    wanted = search.open or tuple(part.name for part in result.parts)
    found = search.dimensions(wanted, say)
    if search.open:
        found += search.materials(search.open)
    best = _ranked(found)
    if verify:
        best = [_verified(change, checked((change.override,)), say) for change in best]
    return Improved(result, search.open, tuple(best))


def _checker(path: Path, overrides: Sequence[str], effort: Effort) -> Verify:
    def checked(further: tuple[str, ...]) -> DesignResult:
        from ballesta.pipeline import check_file

        return check_file(path, (*overrides, *further), effort=effort)

    return checked


def _ranked(found: Iterable[Change]) -> list[Change]:
    """The three best for each set of parts: the lightest dimensions, then materials.

    Those for more parts come first.
    """
    sets: dict[tuple[str, ...], list[Change]] = {}
    for change in sorted(found, key=lambda change: (change.saved == 0, change.mass, change.key)):
        sets.setdefault(change.parts, []).append(change)
    ordered = sorted(sets.items(), key=lambda item: (-len(item[0]), item[0]))
    return [change for _, changes in ordered for change in changes[:_BEST]]


def _verified(change: Change, result: DesignResult, say: Callable[[str], None]) -> Change:
    checks = [check for part in result.parts if part.name in change.parts for check in part.checks]
    governing = min(checks, key=_reserve)
    status = Status.PASS
    for check in checks:
        if check.status is not Status.PASS:
            status = check.status if status is not Status.FAIL else status
    say(f"{change.override}: {status}, safety {governing.safety:.4g}")
    return replace(change, verified=status, verified_safety=governing.safety)


def _reserve(check: Check) -> float:
    """Limit over the upper demand times the required safety: at least 1 passes."""
    return check.limit / (check.upper * check.required) if check.upper else inf


class _Search:
    """Formula estimates of a design's variations, set against its result."""

    def __init__(self, design: Design, result: DesignResult) -> None:
        self.design, self.result = design, result
        self.open = tuple(
            part.name
            for part in result.parts
            if any(check.status is not Status.PASS for check in part.checks)
        )
        (self.base,) = screen(design, [{}])
        known = {_name(check): check for part in result.parts for check in part.checks}
        self._ratios: dict[tuple[str, str, str], tuple[float, float, bool]] = {}
        for check in self.base.checks:
            better = known.get(_name(check))
            if better is not None and check.value > 0:
                same = better.method == check.method
                reach = better.upper / check.upper if same else better.upper / check.value
                ratios = better.value / check.value, reach, same
                self._ratios[_name(check)] = ratios

    def dimensions(self, wanted: tuple[str, ...], say: Callable[[str], None]) -> list[Change]:
        """Changes of one dimension each, for the wanted parts that it matters for."""
        was = {
            key: dimension
            for key, value in self.design.inputs
            if (dimension := _dimension(key, value)) is not None
        }
        tried = self._screened(
            [(key, value * factor) for key, (value, _) in was.items() for factor in _ASIDE], was
        )
        found: list[Change | None] = []
        for key, (value, _) in was.items():
            below, above = (tried[key, value * factor] for factor in _ASIDE)
            if below.problem or above.problem:
                continue
            exponents = {
                part: self._exponent(part, below, above)
                for part in wanted
                if isfinite(self.reserve(self.base, (part,)))
            }
            parts = tuple(part for part, p in exponents.items() if abs(p) > _MATTERS)
            saves = below.mass != above.mass
            if parts and (self.open or saves):
                say(f"{key}: {', '.join(parts)}")
                found.append(self._change(key, was, parts, exponents[parts[0]]))
        return [change for change in found if change is not None]

    def materials(self, wanted: tuple[str, ...]) -> list[Change]:
        """The weakest of the known materials with which parts pass, for each key of one."""
        materials = sorted(known_materials().values(), key=lambda found: found.ultimate_stress)
        found = []
        for key, value in self.design.inputs:
            match = re.fullmatch(r"parts\.(\w+)\.material", key)
            if not match or value not in known_materials():
                continue
            others = [m.name for m in materials if m.name != value and m.ductile]
            for name, one in zip(
                others, screen(self.design, [{key: name} for name in others]), strict=True
            ):
                if one.problem:
                    continue
                parts = tuple(
                    part
                    for part in wanted
                    if self.reserve(one, (part,)) >= 1 > self.reserve(self.base, (part,))
                )
                if parts:
                    found.append(self._told(key, value, name, parts, one))
                    break
        return found

    def reserve(self, one: Screened, parts: Sequence[str]) -> float:
        """The least reserve of some parts' checks; 0 where a check has no upper end."""
        return min((r for r, *_ in self._reserves(one, parts)), default=inf)

    def _reserves(
        self, one: Screened, parts: Sequence[str]
    ) -> list[tuple[float, float, float, Check]]:
        """Reserve, safety at the value and at the upper end, and check, of some parts."""
        found = []
        for check in one.checks:
            if check.part not in parts or not check.value:
                continue
            ratio, reach, same = self._ratios.get(_name(check), (1.0, 1.0, True))
            safety = check.limit / (check.value * ratio)
            least = check.limit / ((check.upper if same else check.value) * reach)
            found.append((least / check.required, safety, least, check))
        return found

    def _exponent(self, part: str, below: Screened, above: Screened) -> float:
        first, second = (self.reserve(one, (part,)) for one in (below, above))
        if not 0 < first < inf or not 0 < second < inf:
            return 0.0
        return log(second / first) / log(_ASIDE[1] / _ASIDE[0])

    def _change(
        self,
        key: str,
        was: Mapping[str, tuple[float, str]],
        parts: tuple[str, ...],
        exponent: float,
    ) -> Change | None:
        """The value of a dimension at which the parts just pass."""
        old, unit = was[key]
        points = [(old, self.reserve(self.base, parts))]
        best: tuple[float, Screened] | None = None
        outward = exponent > 0  # whether larger is safer
        p = exponent
        for step in range(_SECANTS):
            x, r = points[-1]
            aim = x * exp(-log(r) / p)
            aim = min(max(aim, old / MOST), old * MOST)
            aim = _rounded(aim, old, up=outward)
            if aim == x and best is None:  # round-off short of it
                aim = _rounded(x * (1 + (_NEXT if outward else -_NEXT)), old, up=outward)
            if any(aim == x for x, _ in points):
                break
            one = self._screened([(key, aim)], was)[key, aim]
            if one.problem:
                return None
            reached = self.reserve(one, parts)
            if reached >= 1 and (best is None or reached < self.reserve(best[1], parts)):
                best = aim, one
            if not 0 < reached < inf:
                break
            points.append((aim, reached))
            if len(points) > 1 and step < _SECANTS - 1:
                (x0, r0), (x1, r1) = points[-2:]
                slope = log(r1 / r0) / log(x1 / x0)
                p = slope if slope * exponent > 0 else exponent
        if best is None:
            return None
        value, one = best
        change = self._told(key, _written(old, unit), _written(value, unit), parts, one)
        return change if self.open or change.saved > 0 else None

    def _told(
        self, key: str, was: str, value: str, parts: tuple[str, ...], one: Screened
    ) -> Change:
        _, safety, least, check = min(self._reserves(one, parts), key=lambda found: found[0])
        return Change(
            key,
            was,
            value,
            parts,
            safety,
            least,
            check.required,
            f"{check.part} {check.kind}",
            float(one.mass),
            float(self.base.mass - one.mass),
        )

    def _screened(
        self, values: Sequence[tuple[str, float]], was: Mapping[str, tuple[float, str]]
    ) -> dict[tuple[str, float], Screened]:
        found = screen(self.design, [{key: _written(x, was[key][1])} for key, x in values])
        return dict(zip(values, found, strict=True))


_ASIDE = (1 - _STEP, 1 + _STEP)


def _name(check: Check) -> tuple[str, str, str]:
    """By what checks of two models are the same; stress has other names by each."""
    alike = check.kind in ("static", "fatigue")
    return check.part, check.kind, "" if alike else check.quantity


def _dimension(key: str, value: str) -> tuple[float, str] | None:
    """Number and unit of an input that is a dimension of a part; its pin sets a hole's."""
    match = _DIMENSION.match(value)
    if not match or not re.match(r"parts\.\w+\.\w+(?<!hole)$", key) or not float(match[1]):
        return None
    return float(match[1]), match[2]


def _rounded(value: float, old: float, *, up: bool) -> float:
    """Rounded to two digits of the change, and no finer than a hundredth of the old value's."""
    change = abs(value - old)
    if not change:
        return value
    unit = 10.0 ** max(floor(log10(change)) - _DIGITS + 1, floor(log10(old)) - 2)
    count = value / unit
    return round((ceil(count - 1e-9) if up else floor(count + 1e-9)) * unit, 9)


def _written(value: float, unit: str) -> str:
    return f"{value:.9g} {unit}"
