"""Climbing the ladder: the cheapest model of a part whose error bars leave its verdict alone."""

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from time import perf_counter

from checks.design.data import Part
from checks.ladder.leaf_checks import LeafBand, leaf_band
from checks.models import beam, shapes
from checks.models.bands import known_band
from checks.models.checked import BUCKLING, FATIGUE, STATIC, Estimate, rung_estimates, rung_level
from checks.models.shapes import family_of
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check, RungTried, Status
from checks.strength.fatigue_assessment import FatigueUse
from checks.strength.load_doubts import load_bars
from checks.strength.part_strength import fatigue_use
from checks.stress.stress_result import RungLevel, RungModel
from fem.solvers import SolverError
from geometry.mesh import MeshError

AUTO, SOLID, SWEPT = "auto", "solid", "swept"
GAVE_UP = "gave up"
BUILDERS: Mapping[str, Callable[..., RungModel | None]] = {  # of part and its loads
    "formula": shapes.model_of,
    "beam": beam.model_of,
}
ANSWERS: Mapping[str, tuple[str, ...]] = {  # kinds of checks that a rung has an answer to
    "formula": (STATIC, FATIGUE, BUCKLING),
    "beam": (BUCKLING,),
}
FIDELITIES = (AUTO, *BUILDERS, SOLID)
FKM_NEEDS_SOLID = "FKM's notch support needs the stress below a solid's surface"

DOUBTED = "has bars of two rungs that exclude each other"

Say = Callable[[str], None]


@dataclass
class Climb:
    """State of a part's checks so far, and the rungs that gave it.

    asked      kinds of checks that a model decides: static, fatigue, buckling
    best       the narrowest estimate of each kind
    levels     rung -> its stress, judged
    bands      rung -> what friction between leaves widened its checks by
    tried      rungs in the order in which they were tried or passed over
    rubbing    the friction between leaves, if it is known beforehand
    doubted    kinds of which two rungs' bars have nothing in common: only a solid settles them
    """

    loaded: LoadedPart
    use: FatigueUse | None
    asked: tuple[str, ...]
    best: dict[str, Estimate] = field(default_factory=dict)
    levels: dict[str, RungLevel] = field(default_factory=dict)
    bands: dict[str, LeafBand] = field(default_factory=dict)
    tried: list[RungTried] = field(default_factory=list)
    unbuckled: bool = False
    doubted: set[str] = field(default_factory=set)
    rubbing: LeafBand | None = None

    @property
    def part(self) -> Part:
        """The part itself."""
        return self.loaded.part

    @property
    def loads(self) -> PartLoads:
        """Its loads at all positions."""
        return self.loaded.loads

    @property
    def open(self) -> list[str]:
        """Kinds that a better model may still settle."""
        return [kind for kind in self.asked if self._is_open(kind)]

    def _is_open(self, kind: str) -> bool:
        if kind == BUCKLING and self.unbuckled:
            return False
        estimate = self.best.get(kind)
        if estimate is None or kind in self.doubted:
            return True
        return not (estimate.settled or estimate.open_for_good)

    def take(self, rung: str, kinds: Sequence[str] | None = None) -> bool:
        """Try a rung, for some kinds of checks only; whether it has a model of the part."""
        asked = self.asked if kinds is None else kinds
        wanted = [kind for kind in asked if kind in ANSWERS[rung]]
        if not wanted:
            self.skip(rung, f"it answers {' and '.join(ANSWERS[rung])} only")
            return False
        start = perf_counter()
        try:
            model = BUILDERS[rung](self.part, self.loads)
        except (MeshError, SolverError) as error:
            self.skip(rung, f"{GAVE_UP}: {error}")
            return False
        if model is None:
            self.skip(rung, f"there is no {rung} of this shape")
            return False
        level = rung_level(self.loaded, model)
        leaves = self.rubbing or leaf_band(self.loaded)
        doubts = load_bars(self.loads, self._values(rung))

        def band(check: Check) -> Check:
            return doubts(leaves(check))

        found = {
            kind: _banded(estimate, band)
            for kind, estimate in rung_estimates(
                self.loaded, level, self.use, lambda some: BUILDERS[rung](self.part, some)
            ).items()
            if kind in wanted
        }
        self.levels[rung] = level
        self.bands[rung] = leaves
        if model.buckling is not None and not model.buckling.share > 0.0:
            self.unbuckled = True
        for kind, estimate in found.items():
            known = self.best.get(kind)
            if kind in self.doubted:
                continue
            if known is not None and not known.agrees(estimate):
                self.doubted.add(kind)
                self.best[kind] = _doubted(known)
            elif known is None or estimate.spread < known.spread:
                self.best[kind] = estimate
        self.tried.append(
            RungTried(
                rung,
                perf_counter() - start,
                model.unknowns,
                [estimate.check for estimate in found.values()],
                self._why(),
                self.open,
            )
        )
        return True

    def skip(self, rung: str, why: str, expected: float = 0.0) -> None:
        """Note a rung that was passed over, and the seconds that it was expected to take."""
        self.tried.append(RungTried(rung, 0.0, 0, [], why, self.open, expected))

    def worth(self, rung: str) -> str:
        """Why a rung would settle nothing that is open; nothing where it may."""
        narrow = []
        for kind in self.open:
            if kind not in ANSWERS[rung]:
                continue
            band = known_band(family_of(self.part, self.loads, kind), rung, kind)
            if band is None:
                continue
            if kind in self.doubted:
                continue
            estimate = self.best.get(kind)
            if estimate is None or not estimate.spread < float("inf"):
                return ""
            if band.width < estimate.spread and estimate.would_settle(band.low, band.high):
                return ""
            narrow.append(f"{kind}: {100 * (band.low - 1):+.0f} to {100 * (band.high - 1):+.0f} %")
        return (
            f"its error bars would settle nothing that is open ({'; '.join(narrow)})"
            if narrow
            else "it has no answer to what is open"
        )

    def _again(self, rung: str, *, all_round: bool = True) -> Callable[[PartLoads], RungLevel]:
        def level_of(loads: PartLoads) -> RungLevel:
            model = BUILDERS[rung](self.part, loads)
            assert model is not None
            return rung_level(self.loaded.under(loads), model, all_round=all_round)

        return level_of

    def _values(self, rung: str) -> Callable[[PartLoads], dict[str, float]]:
        """A function for a rung's values under other loads of the part, by kind of check.

        They are only compared with each other, so a pin's are at the angles of its points.
        """
        level_of = self._again(rung, all_round=False)

        def values_of(loads: PartLoads) -> dict[str, float]:
            level = level_of(loads)
            values = {STATIC: level.peak.value}
            use = fatigue_use(self.loaded.under(loads))
            if use is not None:
                values[FATIGUE] = use.value(level)
            if level.model.buckling is not None:
                values[BUCKLING] = max(0.0, level.model.buckling.share)
            return values

        return values_of

    def _why(self) -> str:
        """The reason to stop or go on after the estimates so far, in words."""
        open_ones = self.open
        if not open_ones:
            return "stopped: " + "; ".join(
                f"{kind} {_settled_words(self.best[kind])}"
                for kind in self.asked
                if kind in self.best
            )
        return "goes on: " + "; ".join(
            f"{kind} {DOUBTED if kind in self.doubted else _open_words(self.best.get(kind))}"
            for kind in open_ones
        )


def _banded(estimate: Estimate, band: Callable[[Check], Check]) -> Estimate:
    return Estimate(band(estimate.check), estimate.above, estimate.below, estimate.guard)


def _doubted(estimate: Estimate) -> Estimate:
    note = "; ".join(text for text in (estimate.check.note, f"it {DOUBTED}") if text)
    check = replace(estimate.check, model=inf, model_below=inf, note=note)
    return Estimate(check, inf, inf, estimate.guard)


def _settled_words(estimate: Estimate) -> str:
    if estimate.check.status is Status.UNDECIDED:
        return "stays UNDECIDED by what every model assumes"
    return f"{estimate.check.status}, {estimate.guard:g} times its error bars included"


def _open_words(estimate: Estimate | None) -> str:
    if estimate is None:
        return "is not known"
    if not estimate.spread < float("inf"):
        return "has no error bar"
    return f"has its limit within {estimate.guard:g} times its error bars"


def start_climb(loaded: LoadedPart, rubbing: LeafBand | None = None) -> Climb:
    """A climb at the foot of the ladder.

    rubbing  the friction between the leaves of a pack, if it is known; else it is solved
    """
    part, loads = loaded.part, loaded.loads
    use = fatigue_use(loaded)
    asked = [STATIC]
    if use is not None:
        asked.append(FATIGUE)
    if part.body is not None and part.geometry.may_buckle and len(loads.wrenches) > 1:
        asked.append(BUCKLING)
    return Climb(loaded, use, tuple(asked), rubbing=rubbing)


def climb_cheap(climb: Climb, fidelity: str, say: Say = lambda _: None) -> bool:
    """Climb the rungs below the solid; whether the solid is wanted.

    fidelity  "auto", or the one rung that was asked for; where it has no answer the others below
              the solid stand for it, and the solid where there are none; "swept": the solid, and
              rungs below it for buckling; of a pin as "auto"
    """
    rungs = climb_rungs(climb, fidelity, say)
    while True:
        try:
            next(rungs)
        except StopIteration as stop:
            return bool(stop.value)


def climb_rungs(
    climb: Climb, fidelity: str, say: Say = lambda _: None
) -> Generator[None, None, bool]:
    """Climb as `climb_cheap` does; pauses after each rung that another one follows."""
    if fidelity == SOLID or (fidelity == SWEPT and climb.part.fkm is not None):
        return True
    if climb.part.fkm is not None:
        climb.skip(next(iter(BUILDERS)) if fidelity == AUTO else fidelity, FKM_NEEDS_SOLID)
        return True
    if fidelity == SWEPT and climb.part.body is None:
        fidelity = AUTO  # a pin: its fillet takes ten times the unknowns of a bar
    if fidelity == SWEPT:
        for rung in BUILDERS:
            if BUCKLING in climb.open:
                climb.take(rung, [BUCKLING])
        return True
    if fidelity == AUTO:
        for rung in BUILDERS:
            why = climb.worth(rung) if climb.best or climb.unbuckled else ""
            if why:
                climb.skip(rung, why)
                continue
            say(f"{climb.part.name}: {rung}")
            climb.take(rung)
            if climb.levels and not climb.open:
                return False
            yield
        return True
    say(f"{climb.part.name}: {fidelity}")
    complete(climb, fidelity)
    if not climb.levels:
        yield
    return not climb.levels


def complete(climb: Climb, first: str = "") -> None:
    """Ask a rung, then the cheaper ones for the checks that it has no answer to."""
    for rung in sorted(BUILDERS, key=lambda rung: rung != first):
        missing = [kind for kind in climb.asked if kind not in climb.best]
        if climb.unbuckled:
            missing = [kind for kind in missing if kind != BUCKLING]
        if missing and rung not in climb.levels:
            climb.take(rung, missing)


def answered(climb: Climb, order: Sequence[str] = (STATIC, FATIGUE, BUCKLING)) -> list[Check]:
    """The checks that the rungs answer, each by its narrowest estimate."""
    return [climb.best[kind].check for kind in order if kind in climb.best]
