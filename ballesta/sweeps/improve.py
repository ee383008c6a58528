"""Single changes that make a design pass, or save mass where it passes: `ballesta improve`.

Every dimension of a part, and its material, is varied by formula (`ballesta.sweeps.estimates`).
With the reserve r, the least of limit over (upper demand times required safety) of a part's checks,
and a dimension x, r ~ x^p locally: p from a step of 3 %, then secant steps on log r over log x,
each to the next length of R20, the preferred numbers of ISO 3, until the size beside it, less safe,
does not pass. Where another model than the formula decides, a margin of 10 % is kept: so far may
their ratio change with the part (7 % seen, tests/ballesta/sweeps/test_promises.py). Friction
between leaves keeps its share of the stress in a search, and is solved anew for what it finds. A
change is an estimate until a check by the deciding model has verified it.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from math import exp, inf, isfinite, log, sqrt
from pathlib import Path
from typing import Any

import loads
from ballesta.design.read import read_design
from ballesta.sweeps.estimates import (
    LINKAGE,
    MATERIAL,
    STRESS,
    Estimates,
    dimension,
    of_cylinder,
    reserve_of,
    standard,
    within,
    written,
)
from ballesta.sweeps.screen import Screened
from checks.design.data import Design
from checks.design.effort import DEFAULT_EFFORT, Effort
from checks.design.materials import known_materials
from checks.ladder.leaf_checks import LeafBand
from checks.result.verdict import Change, DesignResult, Status
from checks.result.ways import command_with
from fem.threads import one_thread

_STEP = 1.03  # of a dimension, as a factor, to find its exponent
_NEAR = 1.5  # times the least reserve: to pass it a step would need an exponent of 14
_MATTERS = 0.05  # the least exponent: what changes the reserve less is no way out
MOST = 2.0  # the largest change that is looked at, as a factor
_SIZES = 4  # of a dimension that are tried
_HOPELESS = 2.0  # times the largest change, in logarithms, that the exponent asks for: not sought
_AGAIN = 3  # times that a size is sought, each with the friction of leaves at the one before
_NEXT = 1e-6  # of a dimension: to the next standard size
_BEST = 3
_HEAVIEST = 2  # shapes that a check of what passes seeks to make lighter
_TRIES = 8  # of materials, from the weakest that may be strong enough
_MAY = 0.8  # of the strength that is needed: weaker ones are not tried
_SURE = 0.95  # of the yield stress that is needed: loads and bars change less with the material

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
                change.to_dict() | {"command": command_with(self.result, change.override)}
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
    say: Callable[[str], None] = lambda _: None,
) -> Improved:
    """Find the best single changes of a design.

    verify  whether each change that is shown is checked by the models of `effort`

    Raises DesignError and NumericsError as a check does.
    """
    path = Path(file)
    design = read_design(path, overrides)
    checked = _checker(path, overrides, effort)
    result = checked(())
    known = Estimates(design, result)
    search = _Search(known)
    best = _ranked(search.changes(say), search.harmless)
    if verify:
        best = [_verified(change, checked((change.override,)), say) for change in best]
    return Improved(result, known.all_open, tuple(best))


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
    known = Estimates(design, result, cycles, rubbing, between=False, shapes=_HEAVIEST)
    search = _Search(known)
    found = search.changes(say)
    if known.open:
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
        materials = [change for change in changes if change.key.endswith(MATERIAL)]
        sizes = [change for change in changes if not change.key.endswith(MATERIAL)]
        material = list(islice(filter(None, map(harmless, materials)), 1))
        sized = islice(filter(None, map(harmless, sizes)), _BEST - len(material))
        best += [*sorted(sized, key=lambda change: (change.mass, change.key)), *material]
    return best


def _verified(change: Change, result: DesignResult, say: Callable[[str], None]) -> Change:
    checks = [check for check in result.checks if check.part in change.parts]
    governing = min(checks, key=reserve_of)
    status = Status.PASS
    for check in checks:
        if check.status is not Status.PASS:
            status = check.status if status is not Status.FAIL else status
    say(f"{change.override}: {status}, safety {governing.safety:.4g}")
    return replace(change, verified=status, verified_safety=governing.safety)


class _Search:
    """Changes of a design's dimensions and materials, by formula estimates."""

    def __init__(self, known: Estimates) -> None:
        self.known = known

    def changes(self, say: Callable[[str], None]) -> list[Change]:
        """Changes with which the open parts pass, or that save mass where all passes."""
        if self.known.open:
            known = tuple(
                part for part in self.known.open if self.known.reserve(self.known.base, (part,)) > 0
            )
            return self.dimensions(known, say) + self.materials(known) + self.cylinders()
        if (
            self.known.linkage_open or not self.known.base.checks
        ):  # what makes a linkage stiffer is not sought
            return self.cylinders()
        return self.dimensions(self.known.lightened, say)

    @property
    def why_none(self) -> str:
        """Reason in words for an answer without changes."""
        part = self.known.result.deciding.part
        if self.known.linkage_open and (part == LINKAGE or not self.known.open):
            if self.known.result.deciding.place.startswith(("cylinder", "rod of", "tube of")):
                return f"no rod or tube up to {MOST:g} times as thick makes it pass"
            return "what makes the linkage as a whole stiffer is not sought"
        if self.known.open:
            if part in self.known.open and not self.known.reserve(self.known.base, (part,)):
                return f"no change is estimated: a formula of {part} has no error bar"
            stack = " (its stack's were not tried)" if self.known.design.parts[part].stack else ""
            return (
                f"no single dimension of {part}{stack} within a factor of {MOST:g}, nor a known "
                "material, is estimated to make it pass"
            )
        return "no single dimension of the heaviest parts is estimated to save mass and pass"

    def dimensions(self, wanted: tuple[str, ...], say: Callable[[str], None]) -> list[Change]:
        """Changes of one dimension each, for the wanted parts that it matters for."""
        found: list[Change | None] = []
        for key, text in self.known.design.inputs:
            stated = dimension(key, text)
            own = self.known.parts_of(key, wanted)
            if stated is None or not own:
                continue
            value, unit = stated
            stepped = {key: written(value * _STEP, unit)}
            aside = self.known.screening.of(stepped, own, formulas=self._formulas_near(own))
            if aside.problem:
                continue
            exponents = {
                part: self._exponent(part, aside)
                for part in own
                if isfinite(self.known.reserve(self.known.base, (part,)))
            }
            parts = tuple(part for part, p in exponents.items() if abs(p) > _MATTERS)
            saves = aside.mass != self.known.base.mass
            if parts and (self.known.open or saves):
                say(f"{key}: {', '.join(parts)}")
                found.append(self._change(key, value, unit, parts, exponents[parts[0]]))
        return [change for change in found if change is not None]

    def cylinders(self) -> list[Change]:
        """Thicker rods and tubes with which the linkage passes, each at the next standard size."""
        found = []
        for key, text in self.known.design.inputs if self.known.linkage_open else ():
            stated = of_cylinder(key, text)
            if stated is None:
                continue
            old, unit = stated
            size = old
            while (size := standard(size * (1 + _NEXT), unit, up=True)) <= old * MOST:
                one = self.known.screening.of({key: written(size, unit)}, (), linkage=True)
                if one.problem or self.known.reserve(one, (LINKAGE,)) >= 1:
                    break
            if size <= old * MOST and not one.problem:
                value = written(size, unit)
                found.append(self.known.told(key, text, value, (LINKAGE,), one))
        return found

    def materials(self, wanted: tuple[str, ...]) -> list[Change]:
        """The weakest material of the same group with which parts pass, for each key of one."""
        materials = known_materials()
        found = []
        for key, value in self.known.design.inputs:
            own = self.known.parts_of(key, wanted)
            if not key.endswith(MATERIAL) or value not in materials or not own:
                continue
            old = materials[value]
            least = old.ultimate_stress * _MAY / self.known.reserve(self.known.base, own)
            static = {c.part: r for r, *_, c in self.known.reserves(self.known.base, own)
                      if c.kind == "static"}  # fmt: skip
            sure = _SURE * old.yield_stress / max(static.get(part, inf) for part in own)
            others = sorted(
                (
                    m
                    for m in materials.values()
                    if m.ductile
                    and m.fkm_group == old.fkm_group
                    and m.ultimate_stress >= least
                    # what is no lighter has the same stress
                    and (m.yield_stress >= sure or m.density <= _SURE * old.density)
                ),
                key=lambda m: m.ultimate_stress,
            )
            for new in [m for m in others if m.name != value][:_TRIES]:
                name = new.name
                one = self.known.screening.of(
                    {key: name}, own, only_materials=True, failed=self.known.fails
                )
                if not one.problem and self.known.reserve(one, own) >= 1:
                    one = self.known.settled(key, name, own, one)
                if one.problem:
                    continue
                parts = tuple(
                    part
                    for part in own
                    if self.known.reserve(one, (part,))
                    >= 1
                    > self.known.reserve(self.known.base, (part,))
                )
                if parts:
                    found.append(self.known.told(key, value, name, parts, one))
                    break
        return found

    def harmless(self, change: Change) -> Change | None:
        """The change if no other part and not the linkage fails by it; a smaller one that saves.

        None where there is no such change. Other parts and the linkage may not pass already: then
        they must not come worse.
        """
        worst = self.known.beside(change)
        if worst >= 1:
            return change
        old, value = (dimension(change.key, text) for text in (change.was, change.value))
        if self.known.open or not worst or not old or not value or old[1] == "deg":
            return None
        least = min(map(self.known.before, [*self.known.others(change), LINKAGE]))
        exponent = log(worst / max(least, 1.0)) / log(value[0] / old[0])
        aim = value[0] * exp(-log(worst) / exponent)
        size = standard(aim, old[1], up=old[0] > aim)
        if not min(value[0], old[0]) < size < max(value[0], old[0]):
            return None
        one = self.known.screened(change.key, size, old[1], change.parts)
        one = self.known.settled(change.key, written(size, old[1]), change.parts, one)
        if (
            one.problem
            or self.known.reserve(one, change.parts) < 1
            or one.mass >= self.known.base.mass
        ):
            return None
        text = written(size, old[1])
        less = self.known.told(change.key, change.was, text, change.parts, one)
        return less if self.known.beside(less) >= 1 else None

    def _formulas_near(self, parts: Sequence[str]) -> bool:
        """True if a check of parts that is no stress may have the least reserve after a step."""
        found = self.known.reserves(self.known.base, parts)
        others = [r for r, *_, check in found if check.kind not in STRESS]
        return min(others, default=inf) < _NEAR * self.known.reserve(self.known.base, parts)

    def _exponent(self, part: str, aside: Screened) -> float:
        first, second = (self.known.reserve(one, (part,)) for one in (self.known.base, aside))
        if not 0 < first < inf or not 0 < second < inf:
            return 0.0
        return log(second / first) / log(_STEP)

    def _change(
        self, key: str, old: float, unit: str, parts: tuple[str, ...], exponent: float
    ) -> Change | None:
        """The change to the least safe standard size of a dimension with which the parts pass.

        Where they do not with the friction between leaves that it has, it is sought again with the
        share of the stress that friction has there.
        """
        known = dict(self.known.screening.rubbing)
        try:
            for _ in range(_AGAIN):
                found = self._sized(key, old, unit, parts, exponent)
                if found is None:
                    return None
                size, one = found
                one = self.known.settled(key, written(size, unit), parts, one)
                if not one.problem and self.known.reserve(one, parts) >= 1:
                    was, now = (written(number, unit) for number in (old, size))
                    change = self.known.told(key, was, now, parts, one)
                    return change if self.known.open or change.saved > 0 else None
                self.known.screening.rubbing |= one.rubbing
        finally:
            self.known.screening.rubbing = known
        return None

    def _sized(
        self, key: str, old: float, unit: str, parts: tuple[str, ...], exponent: float
    ) -> tuple[float, Screened] | None:
        """The least safe standard size of a dimension with which the parts pass.

        Beyond the old value where they do not pass with it, short of it where they do. Secants lead
        there; the next size beside it, less safe, is tried and does not pass.
        """
        x, r = old, self.known.reserve(self.known.base, parts)
        if -log(r) > _HOPELESS * log(MOST) * abs(exponent):
            return None
        safer = 1 if exponent > 0 else -1
        best: tuple[float, Screened] | None = None
        tried, beyond = {old}, safer if r < 1 else -safer
        aim = _aim(x, r, exponent)
        while len(tried) <= _SIZES:
            size = within(aim, old, MOST, unit, up=safer > 0)
            if size in tried and best is not None:
                size = standard(best[0] * (1 - safer * _NEXT), unit, up=safer < 0)
            if size in tried or (size - old) * beyond <= 0:
                break
            tried.add(size)
            one = self.known.screening.of(
                {key: written(size, unit)}, parts, failed=self.known.fails
            )
            reached = 0.0 if one.problem else self.known.reserve(one, parts)
            if not 0 < reached < inf:  # there is no such part, or no error bar
                aim = sqrt(x * size)
                continue
            if reached >= 1 and (best is None or (best[0] - size) * safer > 0):
                best = size, one
            slope = log(reached / r) / log(size / x)
            x, r = size, reached
            aim = _aim(x, r, slope if slope * exponent > 0 else exponent)
        return best


def _aim(x: float, reserve: float, exponent: float) -> float:
    """The dimension with a reserve of 1, if that goes with x to a power; within `MOST` squared."""
    most = 2 * log(MOST)
    return x * exp(min(max(-log(reserve) / exponent, -most), most))
