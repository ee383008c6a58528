"""Formula estimates of a design's variations, set against the result of its check.

A change multiplies the demand that the deciding model has found, and its upper end, by the ratio of
the formula's demands after and before; where the formula decided, by the ratio of its upper ends.
"""

import re
from collections.abc import Mapping, Sequence
from math import ceil, floor, inf, isfinite, log10

import numpy as np

import loads
from ballesta.sweeps.screen import Screened, Screening
from checks.design.data import Design
from checks.design.materials import known_materials
from checks.ladder.leaf_checks import LeafBand
from checks.models.checked import BUCKLING
from checks.part.part_loads import first_largest
from checks.result.verdict import Change, Check, DesignResult, Status

LINKAGE = "linkage"  # name of its checks' part
MATERIAL = ".material"  # with which the key of one ends
STRESS = ("static", "fatigue")
_MARGIN = 1.1  # on what another model than the formula decides: so far may their ratio change
_SAME = 1e-6  # of a reserve: no worse than before
_THIN = 0.02  # of the stiffness of a section may be left by a change of unknown effect
_LOADS = 2.0  # by so much may other masses change the loads


class Estimates:
    """Formula estimates of a design's variations, set against its result.

    open       parts that do not pass
    lightened  where all pass: the parts of the heaviest shapes, as many as are wanted, but for
               those of whose buckling no formula tells
    base       the formula's checks of the one or the other, as they are
    """

    def __init__(
        self,
        design: Design,
        result: DesignResult,
        solved: Mapping[str, loads.CycleLoads] | None = None,
        rubbing: Mapping[str, LeafBand] | None = None,
        *,
        between: bool = True,
        shapes: int | None = None,
    ) -> None:
        """Solve what a variation keeps of the design.

        between  as `Screening` has it
        shapes   that may save mass where all parts pass; None for all
        """
        self.design, self.result = design, result
        self.open = tuple(
            part.name
            for part in result.parts
            if any(check.status is not Status.PASS for check in part.checks)
        )
        self.linkage_open = any(check.status is not Status.PASS for check in result.linkage)
        deciding = {check.cycle for check in result.checks}
        cycles = None if between else {*design.duty.cycles, *deciding}
        self.screening = Screening(
            design, between=between, rubbing=rubbing, cycles=cycles, solved=solved
        )
        self._known = {_name(check): check for check in result.checks}
        self._ratios: dict[tuple[str, str, str], tuple[float, float, bool]] = {}
        self._compared: set[str] = set()
        self._unjudged: set[str] = set()  # parts whose stress no formula judges as they are
        self.lightened = () if self.open else self._heaviest(shapes)
        self.base = self._compare(self.open or self.lightened)
        told = {_name(check) for check in self.base.checks}
        blind = {part for part, kind, quantity in self._known
                 if kind == BUCKLING and (part, kind, quantity) not in told}  # fmt: skip
        self.lightened = tuple(part for part in self.lightened if part not in blind)

    def _heaviest(self, shapes: int | None) -> tuple[str, ...]:
        """Parts of the heaviest shapes: a part that is like another shares its shape."""
        masses = self.screening.weights(self.design)
        shared: dict[str, list[str]] = {}
        for part in self.result.parts:
            shared.setdefault(self.owners(part.name)[-1], []).append(part.name)
        heaviest = sorted(shared.values(), key=lambda parts: -sum(masses[part] for part in parts))
        return tuple(part for parts in heaviest[:shapes] for part in parts)

    def _compare(self, parts: Sequence[str]) -> Screened:
        """The formula's checks of some parts as they are, beside those of the result."""
        base = self.screening.of({}, parts, only_materials=True)
        self.screening.rubbing |= base.rubbing
        self._compared |= set(parts)
        self._unjudged |= base.open.keys()
        for check in base.checks:
            better = self._known.get(_name(check))
            if better is not None and check.value > 0:
                same = better.method == check.method
                reach = better.upper / check.upper if same else better.upper / check.value
                ratios = better.value / check.value, reach, same
                self._ratios[_name(check)] = ratios
        return base

    @property
    def all_open(self) -> tuple[str, ...]:
        """Parts that do not pass, and the linkage as a whole where it does not."""
        return (*self.open, *([LINKAGE] if self.linkage_open else []))

    def reserve(self, one: Screened, parts: Sequence[str], *, margin: bool = True) -> float:
        """The least reserve of some parts' checks; 0 where a check has no upper end, or is missing.

        margin  False for parts that keep their shape: so does the ratio of their models
        """
        if one.open.keys() & set(parts) - self._unjudged:
            return 0.0  # the formula gave up on the variation, as of a hole near an edge
        return min((r for r, *_ in self.reserves(one, parts, margin=margin)), default=inf)

    def fails(self, checks: Sequence[Check]) -> bool:
        """True if a check of a variation has a reserve below 1."""
        return any(reserve < 1 for reserve, *_ in self._reserves(checks, margin=True))

    def reserves(
        self, one: Screened, parts: Sequence[str], *, margin: bool = True
    ) -> list[tuple[float, float, float, Check]]:
        """Reserve, safety at the value and at the upper end, and check, of some parts."""
        return self._reserves([check for check in one.checks if check.part in parts], margin=margin)

    def _reserves(
        self, checks: Sequence[Check], *, margin: bool
    ) -> list[tuple[float, float, float, Check]]:
        found = []
        for check in checks:
            if not check.value:
                continue
            ratio, reach, same = self._ratios.get(_name(check), (1.0, 1.0, True))
            safety = check.limit / (check.value * ratio)
            least = check.limit / ((check.upper if same else check.value) * reach)
            kept = _MARGIN if margin and not same else 1.0
            found.append((least / (check.required * kept), safety, least, check))
        return found

    def before(self, name: str) -> float:
        """Reserve of a part, or of the linkage, in the design as it is."""
        checks = [check for check in self.result.checks if check.part == name]
        return min(map(reserve_of, checks), default=inf)

    def beside(self, change: Change) -> float:
        """The least reserve of other parts and of the linkage, over 1 or a lesser one before."""
        others = self.others(change)
        asks = self._asks_linkage(change)
        if not others and not asks:
            return inf
        reserves = {name: self.before(name) for name in others}
        one = self.screening.of({change.key: change.value}, others, linkage=asks, reserves=reserves)
        if one.problem:
            return 0.0
        new = {check.part for check in one.checks} - self._compared - {LINKAGE}
        if new:
            self._compare(sorted(new))
        ratios = [inf]
        for name in [*others, *([LINKAGE] if asks else [])]:
            has = self.before(name)
            before = min(1.0, (1 - _SAME) * has)
            reshaped = has >= 1 and bool(self.parts_of(change.key, (name,)))
            if before:  # 0 without an error bar: nothing can be said, before as after
                ratios.append(self.reserve(one, (name,), margin=reshaped) / before)
        return min(ratios)

    def others(self, change: Change) -> list[str]:
        """Parts that a change is not for."""
        return [part.name for part in self.result.parts if part.name not in change.parts]

    def _asks_linkage(self, change: Change) -> bool:
        """True if a change may matter for the linkage's buckling.

        The stiffness of a section goes at most with the fourth power of a dimension that is larger
        where it is stiffer; masses change the loads by less than a factor of two.
        """
        left = self.before(LINKAGE)
        old, value = (dimension(change.key, text) for text in (change.was, change.value))
        stiffness = _THIN
        if change.key.endswith(MATERIAL):
            known = known_materials()
            stiffness = known[change.value].youngs_modulus / known[change.was].youngs_modulus
        elif old and value and (value[0] > old[0]) == bool(self.open):
            stiffness = min(old[0] / value[0], value[0] / old[0]) ** 4
        return isfinite(left) and left * stiffness < _LOADS

    def parts_of(self, key: str, wanted: tuple[str, ...]) -> tuple[str, ...]:
        """The wanted parts whose shape or material a key states: its own, and those like it."""
        match = re.match(r"parts\.(\w+)\.", key)
        return tuple(part for part in wanted if match and match[1] in self.owners(part))

    def owners(self, part: str) -> list[str]:
        """A part, the part that it is like, and so on."""
        stated = dict(self.design.inputs)
        owners = [part]
        while (like := stated.get(f"parts.{owners[-1]}.like")) and like not in owners:
            owners.append(like)
        return owners

    def screened(self, key: str, value: float, unit: str, parts: tuple[str, ...]) -> Screened:
        """A variation of one dimension, by its checks of some parts."""
        return self.screening.of({key: written(value, unit)}, parts)

    def settled(self, key: str, value: str, parts: Sequence[str], one: Screened) -> Screened:
        """A variation with the friction between leaves that it has itself."""
        if all(one.rubbing[part].friction is None for part in parts if part in one.rubbing):
            return one
        return self.screening.of({key: value}, parts, anew=True)

    def told(self, key: str, was: str, value: str, parts: tuple[str, ...], one: Screened) -> Change:
        """A change with the safety and the mass that are estimated for some parts."""
        reserves = self.reserves(one, parts)
        first = first_largest(np.array([-reserve for reserve, *_ in reserves]))[0]  # of twins
        _, safety, lower, check = reserves[first]
        decided = self._known.get(_name(check), check).method
        return Change(
            key,
            was,
            value,
            parts,
            safety,
            lower,
            check.required,
            f"{check.part} {check.kind}",
            decided,
            float(one.mass),
            float(self.base.mass - one.mass),
        )


def reserve_of(check: Check) -> float:
    """Limit over the upper demand times the required safety: at least 1 passes."""
    return check.limit / (check.upper * check.required) if check.upper else inf


def _name(check: Check) -> tuple[str, str, str]:
    """By what checks of two models are the same; stress has other names by each."""
    alike = check.kind in STRESS
    return check.part, check.kind, "" if alike else check.quantity


# Dimensions of a design file as they are changed: read, at preferred sizes, written.

_DIMENSION = re.compile(r"^\s*(\d+(?:\.\d+)?)\s*(mm|cm|m|deg)\s*$")
_VARIED = re.compile(r"parts\.\w+\.(\w+(?<!hole)|welds\[\d+\]\.throat)$")  # a pin sets a hole
_CYLINDER = re.compile(r"cylinders\.\w+\.(rod|wall)$")
# R20 of ISO 3:1973, as the package renard 1.3 lists it: steps of about 12 %.
_R20 = (
    1.0, 1.12, 1.25, 1.4, 1.6, 1.8, 2.0, 2.24, 2.5, 2.8, 3.15, 3.55, 4.0, 4.5, 5.0, 5.6, 6.3, 7.1,
    8.0, 9.0,
)  # fmt: skip


def dimension(key: str, value: str) -> tuple[float, str] | None:
    """Number and unit of a dimension of a part but a hole's, or of a weld's throat; else None."""
    return _read(value) if _VARIED.match(key) else None


def of_cylinder(key: str, value: str) -> tuple[float, str] | None:
    """Number and unit of the thickness of a cylinder's rod or wall; else None."""
    return _read(value) if _CYLINDER.match(key) else None


def _read(value: str) -> tuple[float, str] | None:
    match = _DIMENSION.match(value)
    return (float(match[1]), match[2]) if match and float(match[1]) else None


def standard(value: float, unit: str, *, up: bool) -> float:
    """The next length of R20, or whole degree, on one side, or the value if it is one.

    >>> standard(6.42, "mm", up=True), standard(5.42, "m", up=False), standard(80.0, "mm", up=True)
    (7.1, 5.0, 80.0)
    >>> standard(6.42, "deg", up=True)
    7.0
    """
    if unit == "deg":
        return float(ceil(value - 1e-9) if up else floor(value + 1e-9))
    decade = 10.0 ** floor(log10(value))
    sizes = [round(decade * size * ten, 9) for ten in (0.1, 1.0, 10.0) for size in _R20]
    if up:
        return next(size for size in sizes if size >= value * (1 - 1e-9))
    return next(size for size in reversed(sizes) if size <= value * (1 + 1e-9))


def within(value: float, old: float, most: float, unit: str, *, up: bool) -> float:
    """The standard size on one side of a value, but none beyond the first so many times the old.

    >>> within(15.0, 6.3, 2.0, "mm", up=True), within(1.0, 6.3, 2.0, "mm", up=True)
    (14.0, 3.15)
    """
    least, largest = standard(old / most, unit, up=False), standard(old * most, unit, up=True)
    return min(max(standard(value, unit, up=up), least), largest)


def written(value: float, unit: str) -> str:
    """A length or angle as a design file has it."""
    return f"{value:.9g} {unit}"
