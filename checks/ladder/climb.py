"""Climbing the ladder: the formula where its error bars leave the verdict alone, else a solid."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter

from checks.design.data import Part
from checks.design.effort import AUTO, FORMULA, SOLID, SWEPT
from checks.ladder.leaf_checks import LeafBand, leaf_band
from checks.models import shapes
from checks.models.checked import BUCKLING, FATIGUE, STATIC, Estimate, rung_estimates, rung_level
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check, RungTried, Status
from checks.strength.fatigue_assessment import FatigueUse
from checks.strength.load_doubts import AMPLITUDE, LoadBars, load_bars
from checks.strength.part_strength import amplitude_use, fatigue_use
from checks.stress.stress_result import RungLevel, RungModel
from fem.solvers import SolverError
from geometry.mesh import MeshError

GAVE_UP = "gave up"
FKM_NEEDS_SOLID = "FKM's notch support needs the stress below a solid's surface"

Say = Callable[[str], None]


@dataclass
class Climb:
    """State of a part's checks so far, and the rungs that gave it.

    asked      kinds of checks that a model decides: static, fatigue, buckling
    best       the formula's estimate of each kind
    level      its stress, judged; None without a formula of the part
    leaves     what friction between leaves widened its checks by
    tried      rungs in the order in which they were tried or passed over
    rubbing    the friction between leaves, if it is known beforehand
    model      the formula's stress before it is judged: of geometry, elasticity and loads alone; it
               may be known beforehand
    doubts     bars of its loads, by the formula
    """

    loaded: LoadedPart
    use: FatigueUse | None
    asked: tuple[str, ...]
    best: dict[str, Estimate] = field(default_factory=dict)
    level: RungLevel | None = None
    leaves: LeafBand | None = None
    tried: list[RungTried] = field(default_factory=list)
    unbuckled: bool = False
    rubbing: LeafBand | None = None
    model: RungModel | None = None
    doubts: LoadBars | None = None

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
        """Kinds that a solid may still settle."""
        return [kind for kind in self.asked if self._is_open(kind)]

    def _is_open(self, kind: str) -> bool:
        if kind == BUCKLING and self.unbuckled:
            return False
        estimate = self.best.get(kind)
        return estimate is None or not (estimate.settled or estimate.open_for_good)

    def by_formula(self, kinds: Sequence[str] | None = None) -> bool:
        """Estimate some kinds of checks by formula; False where the part has none."""
        start, wanted = perf_counter(), self.asked if kinds is None else kinds
        try:
            model = self.model = self.model or shapes.model_of(self.part, self.loads)
            load = None if model is None or BUCKLING not in wanted else model.buckling
        except (MeshError, SolverError) as error:
            self.skip(FORMULA, f"{GAVE_UP}: {error}")
            return False
        if model is None:
            self.skip(FORMULA, shapes.why_none(self.part, self.loads))
            return False
        self.level = rung_level(self.loaded, model)
        self.leaves = self.rubbing or leaf_band(self.loaded)
        self.doubts = load_bars(self.loads, self._values, self.loaded.narrowest_arc)
        found = self._estimates(self.loaded, wanted)
        if load is not None and not load.share > 0.0:
            self.unbuckled = True
        self.best |= found
        self.tried.append(
            RungTried(
                FORMULA,
                perf_counter() - start,
                0,
                [estimate.check for estimate in found.values()],
                self._why(),
                self.open,
            )
        )
        return True

    def _estimates(self, loaded: LoadedPart, kinds: Sequence[str]) -> dict[str, Estimate]:
        """Estimates of the part, whose edges may be others, by kind of check."""
        level, leaves, doubts = self.level, self.leaves, self.doubts
        assert level is not None
        assert leaves is not None
        assert doubts is not None
        return {
            kind: replace(estimate, check=doubts(leaves(estimate.check)))
            for kind, estimate in rung_estimates(
                loaded, level, self.use, lambda some: shapes.model_of(self.part, some), kinds
            ).items()
        }

    def with_edges(self, loaded: LoadedPart, kind: str) -> tuple[Check, Check]:
        """A check that the formula has estimated, of the part with other edges of its bores.

        Twice, as formulas know no bushes (`edges_that_pass`).
        """
        check = self._estimates(loaded, [kind])[kind].check
        return check, check

    def skip(self, rung: str, why: str, expected: float = 0.0) -> None:
        """Note a rung that was passed over, and the seconds that it was expected to take."""
        self.tried.append(RungTried(rung, 0.0, 0, [], why, self.open, expected))

    def _values(self, loads: PartLoads) -> dict[str, float]:
        """The formula's values under other loads of the part, by kind of check.

        They are only compared with each other, so a pin's are at the angles of its points.
        """
        level = self.level
        if loads is not self.loads or level is None or level.model.ring:
            model = shapes.model_of(self.part, loads)
            assert model is not None
            level = rung_level(self.loaded.under(loads), model, all_round=False)
        values = {STATIC: level.peak.value}
        use = fatigue_use(self.loaded.under(loads))
        if use is not None:
            values[FATIGUE] = use.value(level)
            if loads.rubs[1]:
                values[AMPLITUDE] = amplitude_use(self.loaded.under(loads)).value(level)
        if BUCKLING in self.asked and level.model.buckling is not None:
            values[BUCKLING] = max(0.0, level.model.buckling.share)
        return values

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
            f"{kind} {_open_words(self.best.get(kind))}" for kind in open_ones
        )


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
    """Climb the rung below the solid; returns True if the solid is wanted.

    fidelity  "auto", or the one rung that was asked for, a solid where the part has no formula;
              "swept": the solid, but a formula for buckling; of a pin as "auto"
    """
    if fidelity == SOLID or (fidelity == SWEPT and climb.part.fkm is not None):
        return True
    if climb.part.fkm is not None:
        climb.skip(FORMULA, FKM_NEEDS_SOLID)
        return True
    if fidelity == SWEPT and climb.part.body is None:
        fidelity = AUTO  # a pin: its fillet takes ten times the unknowns of a bar
    if fidelity == SWEPT:
        if BUCKLING in climb.open:
            climb.by_formula([BUCKLING])
        return True
    say(f"{climb.part.name}: {FORMULA}")
    climb.by_formula()
    return climb.level is None or (fidelity == AUTO and bool(climb.open))


def answered(climb: Climb) -> list[Check]:
    """The checks that the formula answers."""
    return [climb.best[kind].check for kind in (STATIC, FATIGUE, BUCKLING) if kind in climb.best]
