"""Single changes that make a design pass, or save mass where it passes: `ballesta improve`.

Every dimension of a part, and its material, is varied by formula (`ballesta.sweeps.screen`). A
change multiplies the demand that the deciding model has found, and its upper end, by the ratio of
the formula's demands after and before; where the formula decided, by the ratio of its upper ends.
With the reserve r, the least of limit over (upper demand times required safety) of a part's checks,
and a dimension x, r ~ x^p locally: p from a step of 3 %, then three secant steps on log r over
log x, rounded to the safe side; then the next length of R20, the preferred numbers of ISO 3, if it
is a change as well. Where another model than the formula decides, a margin of 10 % is kept: so far
may their ratio change with the part (7 % seen, tests/ballesta/sweeps/test_promises.py). Friction
between leaves keeps its share of the stress in a search, and is solved anew for what it finds. A
change is an estimate until a check by the deciding model has verified it.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from math import ceil, exp, floor, inf, isfinite, log, log10, sqrt
from pathlib import Path
from typing import Any

import loads
from ballesta.design.read import read_design
from ballesta.sweeps.screen import Screened, Screening
from checks.design.data import Design
from checks.design.effort import DEFAULT_EFFORT, Effort
from checks.design.materials import known_materials
from checks.ladder.leaf_checks import LeafBand
from checks.result.verdict import Change, Check, DesignResult, Status
from fem.threads import one_thread

_DIMENSION = re.compile(r"^\s*(\d+(?:\.\d+)?)\s*(mm|cm|m|deg)\s*$")
_VARIED = re.compile(r"parts\.\w+\.(\w+(?<!hole)|welds\[\d+\]\.throat)$")
_CYLINDER = re.compile(r"cylinders\.\w+\.(rod|wall)$")
_STEP = 1.03  # of a dimension, as a factor, to find its exponent
_NEAR = 1.5  # times the least reserve: to pass it a step would need an exponent of 14
_STRESS = ("static", "fatigue")
_MATTERS = 0.05  # the least exponent: what changes the reserve less is no way out
MOST = 2.0  # the largest change that is looked at, as a factor
_SECANTS = 3
_AGAIN = 3  # times that a size is sought, each with the friction of leaves at the one before
_NEXT = 1e-6  # of a dimension: to the next rounded value
_DIGITS = 2  # of the change, to which a dimension is rounded
_BEST = 3
_MARGIN = 1.1  # on what another model than the formula decides: so far may their ratio change
_HEAVIEST = 2  # shapes that a check of what passes seeks to make lighter
_TRIES = 8  # of materials, from the weakest that may be strong enough
_MAY = 0.8  # of the strength that is needed: weaker ones are not tried
_MATERIAL = ".material"
# R20 of ISO 3:1973, as the package renard 1.3 lists it: steps of about 12 %.
_R20 = (
    1.0, 1.12, 1.25, 1.4, 1.6, 1.8, 2.0, 2.24, 2.5, 2.8, 3.15, 3.55, 4.0, 4.5, 5.0, 5.6, 6.3, 7.1,
    8.0, 9.0,
)  # fmt: skip

_SAME = 1e-6  # of a reserve: no worse than before
_THIN = 0.02  # of the stiffness of a section may be left by a change of unknown effect
_LOADS = 2.0  # by so much may other masses change the loads
LINKAGE = "linkage"  # name of its checks' part

Verify = Callable[[tuple[str, ...]], DesignResult]


@dataclass(frozen=True)
class Improved:
    """The best single changes of a design, best first.

    result   of the design as it is
    open     parts that do not pass, and the linkage; changes are for them, else they save mass
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
                change.to_dict()
                | {"command": f"ballesta check {self.result.file} --set '{change.override}'"}
                for change in self.changes
            ],
        }


@one_thread()
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
    best = _ranked(search.changes(say), search.harmless)
    if verify:
        best = [_verified(change, checked((change.override,)), say) for change in best]
    return Improved(result, search.all_open, tuple(best))


@one_thread()
def with_changes(
    design: Design,
    result: DesignResult,
    cycles: Mapping[str, loads.CycleLoads] | None = None,
    rubbing: Mapping[str, LeafBand] | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> DesignResult:
    """The result with its three best single changes for the part that decides, and its like.

    cycles   as the check has solved them, without dynamic factors
    rubbing  part -> friction between its leaves, as the check has found it

    None where only the linkage does not pass. Where all pass, the two heaviest shapes are tried.
    Where none is found, the result tells why.
    Sampling errors are taken from the result, and of the cycles only those that decide a check or
    stand in the duty are solved; `improve` takes all, and finds sampling errors anew.
    """
    search = _Search(design, result, cycles, rubbing, between=False)
    found = search.changes(say, shapes=_HEAVIEST)
    if search.open:
        found = [change for change in found if result.deciding.part in change.parts]
    best = _ranked(found, search.harmless)[:_BEST]
    return replace(result, changes=best, unchanged="" if best else search.why_none)


def _checker(path: Path, overrides: Sequence[str], effort: Effort) -> Verify:
    def checked(further: tuple[str, ...]) -> DesignResult:
        from ballesta.pipeline import check_file

        return check_file(path, (*overrides, *further), effort=effort)

    return checked


def _ranked(found: Iterable[Change], harmless: Callable[[Change], Change | None]) -> list[Change]:
    """The three best for each set of parts, one of them a material if one helps.

    Dimensions by mass, the lightest first, then the material. Those for more parts come first.

    harmless  of a change, as far as nothing else fails by it
    """
    sets: dict[tuple[str, ...], list[Change]] = {}
    for change in sorted(found, key=lambda change: (change.mass, change.key)):
        sets.setdefault(change.parts, []).append(change)
    ordered = sorted(sets.items(), key=lambda item: (-len(item[0]), item[0]))
    best: list[Change] = []
    for _, changes in ordered:
        materials = [change for change in changes if change.key.endswith(_MATERIAL)]
        sizes = [change for change in changes if not change.key.endswith(_MATERIAL)]
        material = list(islice(filter(None, map(harmless, materials)), 1))
        sized = islice(filter(None, map(harmless, sizes)), _BEST - len(material))
        best += [*sorted(sized, key=lambda change: (change.mass, change.key)), *material]
    return best


def _verified(change: Change, result: DesignResult, say: Callable[[str], None]) -> Change:
    checks = [check for check in result.checks if check.part in change.parts]
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

    def __init__(
        self,
        design: Design,
        result: DesignResult,
        solved: Mapping[str, loads.CycleLoads] | None = None,
        rubbing: Mapping[str, LeafBand] | None = None,
        *,
        between: bool = True,
    ) -> None:
        self.design, self.result = design, result
        self.open = tuple(
            part.name
            for part in result.parts
            if any(check.status is not Status.PASS for check in part.checks)
        )
        self._linkage_open = any(check.status is not Status.PASS for check in result.linkage)
        deciding = {check.cycle for check in result.checks}
        cycles = None if between else {*design.duty.cycles, *deciding}
        self._screening = Screening(
            design, between=between, rubbing=rubbing, cycles=cycles, solved=solved
        )
        self._known = {_name(check): check for check in result.checks}
        self._ratios: dict[tuple[str, str, str], tuple[float, float, bool]] = {}
        self._compared: set[str] = set()
        self.base = self._compare(self.open or [part.name for part in result.parts])

    def _compare(self, parts: Sequence[str]) -> Screened:
        """The formula's checks of some parts as they are, beside those of the result."""
        base = self._screening.of({}, parts)
        self._screening.rubbing |= base.rubbing
        self._compared |= set(parts)
        for check in base.checks:
            better = self._known.get(_name(check))
            if better is not None and check.value > 0:
                same = better.method == check.method
                reach = better.upper / check.upper if same else better.upper / check.value
                ratios = better.value / check.value, reach, same
                self._ratios[_name(check)] = ratios
        return base

    def changes(self, say: Callable[[str], None], *, shapes: int | None = None) -> list[Change]:
        """Changes with which the open parts pass, or that save mass where all passes.

        shapes  that may save mass: the heaviest; None for all
        """
        if self.open:
            known = tuple(part for part in self.open if self.reserve(self.base, (part,)) > 0)
            return self.dimensions(known, say) + self.materials(known) + self.cylinders()
        if self._linkage_open or not self.base.checks:  # what makes a linkage stiffer is not sought
            return self.cylinders()
        shared: dict[str, list[str]] = {}
        for part in self.result.parts:
            shared.setdefault(self._owners(part.name)[-1], []).append(part.name)
        heaviest = sorted(
            shared.values(), key=lambda parts: -sum(self.base.masses[part] for part in parts)
        )
        return self.dimensions(tuple(part for parts in heaviest[:shapes] for part in parts), say)

    @property
    def all_open(self) -> tuple[str, ...]:
        """Parts that do not pass, and the linkage as a whole where it does not."""
        return (*self.open, *([LINKAGE] if self._linkage_open else []))

    @property
    def why_none(self) -> str:
        """Reason in words for an answer without changes."""
        part = self.result.deciding.part
        if self._linkage_open and (part == LINKAGE or not self.open):
            if self.result.deciding.place.startswith(("cylinder", "rod of", "tube of")):
                return f"no rod or tube up to {MOST:g} times as thick makes it pass"
            return "what makes the linkage as a whole stiffer is not sought"
        if self.open:
            if part in self.open and not self.reserve(self.base, (part,)):
                return f"no change is estimated: a formula of {part} has no error bar"
            stack = " (its stack's were not tried)" if self.design.parts[part].stack else ""
            return (
                f"no single dimension of {part}{stack} within a factor of {MOST:g}, nor a known "
                "material, is estimated to make it pass"
            )
        return "no single dimension of the heaviest parts is estimated to save mass and pass"

    def dimensions(self, wanted: tuple[str, ...], say: Callable[[str], None]) -> list[Change]:
        """Changes of one dimension each, for the wanted parts that it matters for."""
        found: list[Change | None] = []
        for key, text in self.design.inputs:
            dimension = _dimension(key, text)
            own = self._parts_of(key, wanted)
            if dimension is None or not own:
                continue
            value, unit = dimension
            stepped = {key: _written(value * _STEP, unit)}
            aside = self._screening.of(stepped, own, formulas=self._formulas_near(own))
            if aside.problem:
                continue
            exponents = {
                part: self._exponent(part, aside)
                for part in own
                if isfinite(self.reserve(self.base, (part,)))
            }
            parts = tuple(part for part, p in exponents.items() if abs(p) > _MATTERS)
            saves = aside.mass != self.base.mass
            if parts and (self.open or saves):
                say(f"{key}: {', '.join(parts)}")
                found.append(self._change(key, value, unit, parts, exponents[parts[0]]))
        return [change for change in found if change is not None]

    def cylinders(self) -> list[Change]:
        """Thicker rods and tubes with which the linkage passes, each at the next standard size."""
        found = []
        for key, text in self.design.inputs if self._linkage_open else ():
            match = _DIMENSION.match(text)
            if not match or not _CYLINDER.match(key):
                continue
            old, unit = float(match[1]), match[2]
            size = old
            while (size := _standard(size * (1 + _NEXT), up=True)) <= old * MOST:
                one = self._screening.of({key: _written(size, unit)}, (), linkage=True)
                if one.problem or self.reserve(one, (LINKAGE,)) >= 1:
                    break
            if size <= old * MOST and not one.problem:
                value = _written(size, unit)
                found.append(self._told(key, text, value, value, (LINKAGE,), one))
        return found

    def materials(self, wanted: tuple[str, ...]) -> list[Change]:
        """The weakest material of the same group with which parts pass, for each key of one."""
        known = known_materials()
        found = []
        for key, value in self.design.inputs:
            own = self._parts_of(key, wanted)
            if not key.endswith(_MATERIAL) or value not in known or not own:
                continue
            least = known[value].ultimate_stress * _MAY / self.reserve(self.base, own)
            group = known[value].fkm_group
            others = sorted(
                (
                    m
                    for m in known.values()
                    if m.ductile and m.fkm_group == group and m.ultimate_stress >= least
                ),
                key=lambda m: m.ultimate_stress,
            )
            for name in [m.name for m in others if m.name != value][:_TRIES]:
                one = self._screening.of({key: name}, own)
                if not one.problem and self.reserve(one, own) >= 1:
                    one = self._settled(key, name, own, one)
                if one.problem:
                    continue
                parts = tuple(
                    part
                    for part in own
                    if self.reserve(one, (part,)) >= 1 > self.reserve(self.base, (part,))
                )
                if parts:
                    found.append(self._told(key, value, name, name, parts, one))
                    break
        return found

    def harmless(self, change: Change) -> Change | None:
        """The change if no other part and not the linkage fails by it; a smaller one that saves.

        None where there is no such change. Other parts and the linkage may not pass already: then
        they must not come worse.
        """
        worst = self._beside(change)
        if worst >= 1:
            return change
        old, value = (_dimension(change.key, text) for text in (change.was, change.value))
        if self.open or not worst or not old or not value or old[1] == "deg":
            return None
        least = min(map(self._before, [*self._others(change), LINKAGE]))
        exponent = log(worst / max(least, 1.0)) / log(value[0] / old[0])
        aim = value[0] * exp(-log(worst) / exponent)
        size = _standard(aim, up=old[0] > aim)
        if not min(value[0], old[0]) < size < max(value[0], old[0]):
            return None
        one = self._screened(change.key, size, old[1], change.parts)
        one = self._settled(change.key, _written(size, old[1]), change.parts, one)
        if one.problem or self.reserve(one, change.parts) < 1 or one.mass >= self.base.mass:
            return None
        text = _written(size, old[1])
        less = self._told(change.key, change.was, text, text, change.parts, one)
        return less if self._beside(less) >= 1 else None

    def _beside(self, change: Change) -> float:
        """The least reserve of other parts and of the linkage, over 1 or a lesser one before."""
        others = self._others(change)
        asks = self._asks_linkage(change)
        if not others and not asks:
            return inf
        reserves = {name: self._before(name) for name in others}
        one = self._screening.of(
            {change.key: change.value}, others, linkage=asks, reserves=reserves
        )
        if one.problem:
            return 0.0
        new = {check.part for check in one.checks} - self._compared - {LINKAGE}
        if new:
            self._compare(sorted(new))
        ratios = [inf]
        for name in [*others, *([LINKAGE] if asks else [])]:
            has = self._before(name)
            before = min(1.0, (1 - _SAME) * has)
            reshaped = has >= 1 and bool(self._parts_of(change.key, (name,)))
            if before:  # 0 without an error bar: nothing can be said, before as after
                ratios.append(self.reserve(one, (name,), margin=reshaped) / before)
        return min(ratios)

    def _others(self, change: Change) -> list[str]:
        return [part.name for part in self.result.parts if part.name not in change.parts]

    def _before(self, name: str) -> float:
        """Reserve of a part, or of the linkage, in the design as it is."""
        checks = [check for check in self.result.checks if check.part == name]
        return min(map(_reserve, checks), default=inf)

    def _asks_linkage(self, change: Change) -> bool:
        """True if a change may matter for the linkage's buckling.

        The stiffness of a section goes at most with the fourth power of a dimension that is larger
        where it is stiffer; masses change the loads by less than a factor of two.
        """
        left = self._before(LINKAGE)
        old, value = (_dimension(change.key, text) for text in (change.was, change.value))
        stiffness = _THIN
        if change.key.endswith(_MATERIAL):
            known = known_materials()
            stiffness = known[change.value].youngs_modulus / known[change.was].youngs_modulus
        elif old and value and (value[0] > old[0]) == bool(self.open):
            stiffness = min(old[0] / value[0], value[0] / old[0]) ** 4
        return isfinite(left) and left * stiffness < _LOADS

    def _formulas_near(self, parts: Sequence[str]) -> bool:
        """True if a check of parts that is no stress may have the least reserve after a step."""
        found = self._reserves(self.base, parts)
        others = [r for r, *_, check in found if check.kind not in _STRESS]
        return min(others, default=inf) < _NEAR * self.reserve(self.base, parts)

    def _parts_of(self, key: str, wanted: tuple[str, ...]) -> tuple[str, ...]:
        """The wanted parts whose shape or material a key states: its own, and those like it."""
        match = re.match(r"parts\.(\w+)\.", key)
        return tuple(part for part in wanted if match and match[1] in self._owners(part))

    def _owners(self, part: str) -> list[str]:
        """A part, the part that it is like, and so on."""
        stated = dict(self.design.inputs)
        owners = [part]
        while (like := stated.get(f"parts.{owners[-1]}.like")) and like not in owners:
            owners.append(like)
        return owners

    def reserve(self, one: Screened, parts: Sequence[str], *, margin: bool = True) -> float:
        """The least reserve of some parts' checks; 0 where a check has no upper end.

        margin  False for parts that keep their shape: so does the ratio of their models
        """
        return min((r for r, *_ in self._reserves(one, parts, margin=margin)), default=inf)

    def _reserves(
        self, one: Screened, parts: Sequence[str], *, margin: bool = True
    ) -> list[tuple[float, float, float, Check]]:
        """Reserve, safety at the value and at the upper end, and check, of some parts."""
        found = []
        for check in one.checks:
            if check.part not in parts or not check.value:
                continue
            ratio, reach, same = self._ratios.get(_name(check), (1.0, 1.0, True))
            safety = check.limit / (check.value * ratio)
            least = check.limit / ((check.upper if same else check.value) * reach)
            kept = _MARGIN if margin and not same else 1.0
            found.append((least / (check.required * kept), safety, least, check))
        return found

    def _exponent(self, part: str, aside: Screened) -> float:
        first, second = (self.reserve(one, (part,)) for one in (self.base, aside))
        if not 0 < first < inf or not 0 < second < inf:
            return 0.0
        return log(second / first) / log(_STEP)

    def _change(
        self, key: str, old: float, unit: str, parts: tuple[str, ...], exponent: float
    ) -> Change | None:
        """The least change of a dimension with which the parts pass, at a standard size.

        Where they do not with the friction between leaves that it has, it is sought again with the
        share of the stress that friction has there.
        """
        known = dict(self._screening.rubbing)
        try:
            for _ in range(_AGAIN):
                found = self._sized(key, old, unit, parts, exponent)
                if found is None:
                    return None
                value, least, one = found
                one = self._settled(key, _written(value, unit), parts, one)
                if not one.problem and self.reserve(one, parts) >= 1:
                    was, now, just = (_written(number, unit) for number in (old, value, least))
                    change = self._told(key, was, now, just, parts, one)
                    return change if self.open or change.saved > 0 else None
                self._screening.rubbing |= one.rubbing
        finally:
            self._screening.rubbing = known
        return None

    def _settled(self, key: str, value: str, parts: Sequence[str], one: Screened) -> Screened:
        """A variation with the friction between leaves that it has itself."""
        if all(one.rubbing[part].friction is None for part in parts if part in one.rubbing):
            return one
        return self._screening.of({key: value}, parts, anew=True)

    def _sized(
        self, key: str, old: float, unit: str, parts: tuple[str, ...], exponent: float
    ) -> tuple[float, float, Screened] | None:
        """A standard size with which the parts pass, if it is a change, and the least size."""
        outward = exponent > 0  # whether larger is safer
        least = self._least(key, old, unit, parts, exponent)
        if least is None:
            return None
        value, one = least
        if unit != "deg" and value != old:
            size = _standard(value, up=outward)
            beyond = (size > old) if (value > old) else (size < old)
            if beyond and 1 / MOST <= size / old <= MOST:
                other = self._screened(key, size, unit, parts)
                if not other.problem and self.reserve(other, parts) >= 1:
                    value, one = size, other
        return value, least[0], one

    def _least(
        self, key: str, old: float, unit: str, parts: tuple[str, ...], exponent: float
    ) -> tuple[float, Screened] | None:
        """The value of a dimension at which the parts just pass."""
        points = [(old, self.reserve(self.base, parts))]
        best: tuple[float, Screened] | None = None
        outward = exponent > 0
        p, unknown = exponent, 0.0  # value at which there is no such part, or no error bar
        for step in range(_SECANTS):
            x, r = points[-1]
            aim = x * exp(-log(r) / p)
            aim = min(max(aim, old / MOST), old * MOST)
            if unknown and (aim - unknown) * (unknown - old) >= 0:
                aim = sqrt(x * unknown)
            aim = _rounded(aim, old, up=outward)
            if aim == x and best is None:  # round-off short of it
                aim = _rounded(x * (1 + (_NEXT if outward else -_NEXT)), old, up=outward)
            if aim == unknown or any(aim == x for x, _ in points):
                break
            one = self._screened(key, aim, unit, parts)
            reached = 0.0 if one.problem else self.reserve(one, parts)
            if not 0 < reached < inf:
                unknown = aim
                continue
            if reached >= 1 and (best is None or reached < self.reserve(best[1], parts)):
                best = aim, one
            points.append((aim, reached))
            if step < _SECANTS - 1:
                (x0, r0), (x1, r1) = points[-2:]
                slope = log(r1 / r0) / log(x1 / x0)
                p = slope if slope * exponent > 0 else exponent
        return best

    def _told(
        self, key: str, was: str, value: str, least: str, parts: tuple[str, ...], one: Screened
    ) -> Change:
        _, safety, lower, check = min(self._reserves(one, parts), key=lambda found: found[0])
        decided = self._known.get(_name(check), check).method
        return Change(
            key,
            was,
            value,
            least,
            parts,
            safety,
            lower,
            check.required,
            f"{check.part} {check.kind}",
            decided,
            float(one.mass),
            float(self.base.mass - one.mass),
        )

    def _screened(self, key: str, value: float, unit: str, parts: tuple[str, ...]) -> Screened:
        return self._screening.of({key: _written(value, unit)}, parts)


def _name(check: Check) -> tuple[str, str, str]:
    """By what checks of two models are the same; stress has other names by each."""
    alike = check.kind in _STRESS
    return check.part, check.kind, "" if alike else check.quantity


def _dimension(key: str, value: str) -> tuple[float, str] | None:
    """Number and unit of a dimension of a part, or of a weld's throat; its pin sets a hole's."""
    match = _DIMENSION.match(value)
    if not match or not _VARIED.match(key) or not float(match[1]):
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


def _standard(value: float, *, up: bool) -> float:
    """The next length of R20 on one side, or the value if it is one.

    >>> _standard(6.42, up=True), _standard(5.42, up=False), _standard(80.0, up=True)
    (7.1, 5.0, 80.0)
    """
    decade = 10.0 ** floor(log10(value))
    sizes = [round(decade * size * ten, 9) for ten in (0.1, 1.0, 10.0) for size in _R20]
    if up:
        return next(size for size in sizes if size >= value * (1 - 1e-9))
    return next(size for size in reversed(sizes) if size <= value * (1 + 1e-9))


def _written(value: float, unit: str) -> str:
    return f"{value:.9g} {unit}"
