"""All parts of a design, each by the cheapest models that settle its verdict."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, isfinite
from time import perf_counter

from checks import by_formula
from checks.columns import cylinders
from checks.columns.linkage_frame import LINKAGE
from checks.columns.stability import ELASTIC
from checks.derivations.buckling import elastic_share
from checks.derivations.stresses import fatigue, rung_bars, static
from checks.design.data import Design
from checks.design.effort import AUTO, FORMULA, SOLID, SWEPT
from checks.design.effort import DEFAULT_EFFORT as DEFAULT_EFFORT
from checks.design.effort import Effort as Effort
from checks.design.errors import DesignError, NumericsError
from checks.ladder.carried import Neighbour, carried_result
from checks.ladder.climb import FKM_NEEDS_SOLID, GAVE_UP, Climb, climb_cheap, start_climb
from checks.ladder.leaf_checks import LeafBand
from checks.ladder.levels import first_of
from checks.ladder.part_fields import undrawn, with_drawn_fields
from checks.ladder.result import cheap_result, solid_result, with_mode_by_formula
from checks.models import stress_words
from checks.models.checked import BUCKLING, FATIGUE, STATIC
from checks.part.derived import Kind
from checks.part.loaded_part import FIRST, LoadedPart
from checks.part.part_loads import Doubt, PartLoads, Runs
from checks.result.derivation import BARS, BarSymbols, Derivation, Given, Item, Section
from checks.result.live_fields import LiveFields
from checks.result.verdict import Check, PartResult
from checks.result.words import TOO_MANY
from checks.stress.kept_models import check_seconds, report_seconds, told_of_part
from checks.stress.solid_mesh_level import Models, half_of
from checks.stress.stress_result import RungLevel
from geometry.mesh import TooManyElementsError

Say = Callable[[str], None]
Finished = Callable[[PartResult, Sequence[str]], None]
UNKNOWN = "no derivation of this check is known: its numbers are put in as the check has them"
_ANEW = "--update-baselines --baseline-fidelity auto chooses the rungs anew"


@dataclass(eq=False)
class Ladder:
    """All parts of a design on the ladder of models.

    begun     when the check began, on the clock of `perf_counter`
    live      whether a page will show the fields at every position
    finished  is handed each part's result, and what a better model may still settle of it, before
              the models that take longer are begun, and when it is final
    neighbours  the neighbour of each part, or why it has none, where solids are swept

    The formulas of all parts come first, so that what time there is goes to solids that settle
    something; under a time limit the ones that are expected to be quickest come first.
    """

    design: Design
    models: Models
    effort: Effort
    begun: float
    say: Say
    live: bool = False
    finished: Finished | None = None
    neighbours: Callable[[str], Neighbour | str] | None = None
    climbs: dict[str, Climb] = field(default_factory=dict)
    results: dict[str, PartResult] = field(default_factory=dict)
    _wanted: dict[str, bool] = field(default_factory=dict)  # whether a part's solid is
    _settled: list[str] = field(default_factory=list)  # without a mesh
    _pinned: dict[str, frozenset[str]] = field(default_factory=dict)  # kinds that are the solid's
    _why_anew: dict[str, str] = field(default_factory=dict)
    # a result without and with the checks that are formulas
    _complete: dict[str, tuple[PartResult, PartResult]] = field(default_factory=dict)

    def check(self, runs: Runs, doubts: Sequence[Doubt] = ()) -> list[PartResult]:
        """Check every part under the loads of some runs; raises DesignError and NumericsError.

        doubts  what the runs may be instead
        """
        for part in self.design.parts.values():
            with told_of_part(self.design, part):
                self._begin(LoadedPart.of(self.design, part, runs, self.models, doubts))
        self._tell_waiting()
        waiting = [name for name in self.design.parts if self._wanted[name]]
        costs = self._costs(waiting)
        waiting.sort(key=lambda name: costs.get(name, 0.0))
        for done, name in enumerate(waiting):
            self._solve(name, costs.get(name, 0.0))
            self._completed(name, self.results[name])  # while the mesh is there to measure on
            left = waiting[done + 1 :]
            self.models.keep_only({self.climbs[other].part.geometry for other in left})
        for name in self._settled if self.live and self.effort.fields else []:
            self.results[name] = self._drawn(name)
            self._tell(name)
            self.models.keep_only(set())
        return [self._completed(name, self.results[name]) for name in self.design.parts]

    @property
    def rubbing(self) -> dict[str, LeafBand]:
        """Friction between the leaves of the parts that a rung below the solid has judged."""
        return {
            name: climb.leaves for name, climb in self.climbs.items() if climb.leaves is not None
        }

    @property
    def deadline(self) -> float:
        """When the last model must be done, on the clock of `perf_counter`."""
        if self.effort.within is None:
            return inf
        return self.begun + self.effort.within - report_seconds(len(self.design.parts))

    def _begin(self, loaded: LoadedPart) -> None:
        name = loaded.name
        climb = self.climbs[name] = start_climb(loaded)
        rungs = self.effort.pinned.get(name)
        if rungs:
            self._pinned[name] = climb_pinned(climb, rungs, self.say)
            self._wanted[name] = bool(self._pinned[name])
        else:
            self._wanted[name] = climb_cheap(climb, self.effort.fidelity, self.say)
        if not self._wanted[name]:
            self._settle(name)

    def _tell_waiting(self) -> None:
        """Hand over what formulas know of the parts that wait for a solid."""
        for name, climb in self.climbs.items():
            if self.finished is not None and self._wanted[name] and climb.level is not None:
                with told_of_part(self.design, climb.part):
                    known = cheap_result(climb, self.models, live=self.live)
                    self._tell(name, known, climb.open)

    def _settle(self, name: str) -> None:
        """Take what the rungs below the solid know as a part's result."""
        self.results[name] = cheap_result(self.climbs[name], self.models, live=self.live)
        self._settled.append(name)
        self._tell(name)

    def _solve(self, name: str, cost: float) -> None:
        """Check a part as a solid, if there is time for one."""
        climb, left = self.climbs[name], self.deadline - perf_counter()
        with told_of_part(self.design, climb.part):
            if climb.level is not None and cost > left:
                climb.skip(
                    SOLID,
                    f"no time: about {cost:.0f} s, {max(left, 0.0):.0f} s are left; it may settle "
                    f"{', '.join(climb.open)}",
                    cost,
                )
                self._settle(name)
                return
            if self.effort.fidelity == SWEPT and not self._anew(name):
                return
            self.say(f"{name}: solving")
            pinned = self._pinned.get(name)
            try:
                self.results[name] = solid_result(
                    climb,
                    self.models,
                    self.say,
                    everything=self.effort.fidelity == SOLID and pinned is None,
                    deadline=self.deadline,
                    pinned=pinned,
                    live=self.live,
                )
            except TooManyElementsError as error:
                if climb.level is None or self.effort.fidelity != AUTO or pinned is not None:
                    raise
                climb.skip(SOLID, f"{error}; it may settle {', '.join(climb.open)}")
                self._settle(name)
                return
            if name in self._why_anew:
                assumed = [
                    *self.results[name].assumed,
                    f"meshes of its own: {self._why_anew[name]}",
                ]
                self.results[name] = replace(self.results[name], assumed=assumed)
            self._tell(name)

    def _anew(self, name: str) -> bool:
        """True if a part's solid needs meshes of its own; else its result is there."""
        climb = self.climbs[name]
        found: PartResult | str = "its buckling is open"
        if BUCKLING not in climb.open and self.neighbours is not None:
            neighbour = self.neighbours(name)
            found = (
                neighbour
                if isinstance(neighbour, str)
                else carried_result(climb, neighbour, self.models, self.say)
            )
        if isinstance(found, str):
            self._why_anew[name] = found
            return True
        self.results[name] = found
        self._tell(name)
        return False

    def _costs(self, names: Sequence[str]) -> dict[str, float]:
        """Expected times of solids, s; none without a time limit."""
        if self.effort.within is None:
            return {}
        if names:
            self.say(f"meshing {', '.join(names)}, to tell the time of their solids")
        return {name: self._cost(name) for name in names}

    def _cost(self, name: str) -> float:
        """Expected time of a part's solid, s, from the mesh that it begins with."""
        climb = self.climbs[name]
        part, kinds = climb.part, climb.open
        stress = self.effort.fidelity != SOLID and name not in self._pinned
        stress = stress and self._wanted[name] and BUCKLING not in kinds
        shape = half_of(part, climb.loads) if stress else None
        first = first_of(climb.loaded.accuracy, kinds) if stress else FIRST
        with told_of_part(self.design, part):
            mesh = self.models.mesh(shape or part.geometry, first * part.fineness)
            return check_seconds(3 * len(mesh.nodes), stress=stress)

    def _drawn(self, name: str) -> PartResult:
        """A result with stress to look at, if there is time for a mesh."""
        climb, result = self.climbs[name], self.results[name]
        if self.deadline < inf and isinstance(result.live, LiveFields):
            cost, left = self._cost(name), self.deadline - perf_counter()
            if cost > left:
                why = f"about {cost:.0f} s for its mesh, {max(left, 0.0):.0f} s are left"
                return replace(result, live=undrawn(result.live, why))
        return with_drawn_fields(climb.loaded, climb.use, result, self.models, self.say)

    def _tell(self, name: str, result: PartResult | None = None, left: Sequence[str] = ()) -> None:
        """Hand over what is known of a part: its final result, if nothing else is said."""
        if self.finished is not None:
            self.finished(self._completed(name, result or self.results[name]), left)

    def _completed(self, name: str, result: PartResult) -> PartResult:
        if name not in self._complete or self._complete[name][0] is not result:
            whole = _with_formulas(self.climbs[name], result)
            self._complete[name] = result, whole
        return self._complete[name][1]


def time_warnings(results: Sequence[PartResult]) -> list[str]:
    """Warnings of solids that time or unknowns left out, with the checks they may settle."""
    return [
        f"{result.name}: solid: {tried.why}"
        for result in results
        for tried in result.rungs
        if tried.rung == SOLID and tried.why.startswith(("no time", TOO_MANY))
    ]


def _with_formulas(climb: Climb, result: PartResult) -> PartResult:
    """Add the checks that are formulas on every rung, and the mode where buckling governs."""
    whole = replace(
        result,
        checks=[*explained(climb, result.checks), *by_formula.formula_checks(climb.loaded)],
        assumed=[*result.assumed, *by_formula.not_checked(climb.loaded)],
    )
    return with_mode_by_formula(climb, whole)


# All kinds of checks, and derivations of those by models of stress, after these are made.


def known_kinds() -> list[Kind]:
    """Every kind of check: by models of stress, of buckling, and by formula."""
    return [*stress_words.KINDS, ELASTIC, LINKAGE, *cylinders.KINDS, *by_formula.kinds()]


def explained(climb: Climb, checks: Sequence[Check]) -> list[Check]:
    """Return the checks of a part by its models of stress, each with its derivation.

    Those of a solid have theirs already (`checks.derivations.stresses`): its mesh is gone by now.
    Those at sharp edges have none yet, and say so (`UNKNOWN`).
    """
    done = []
    for check in checks:
        derivation = check.derivation
        if derivation is None and check.kind in (STATIC, FATIGUE, BUCKLING):
            derivation = _of_rung(climb, check)
        done.append(check.explained_by(derivation or _unknown(check)))
    return done


def _of_rung(climb: Climb, check: Check) -> Derivation | None:
    level = climb.level
    if level is None or check.method != FORMULA:
        return None
    part, part_loads = climb.part, climb.loads
    if check.kind == "buckling":
        load = level.model.buckling
        if load is None:
            return None
        found = elastic_share(climb.loaded, load)
    elif check.kind == "static":
        found = static(part, part_loads, level)
    else:
        if climb.use is None:
            return None
        found = fatigue(part, part_loads, level, climb.use)
    return _with_rung_bars(found, part_loads, climb, level, check)


def _with_rung_bars(
    found: Derivation, part_loads: PartLoads, climb: Climb, level: RungLevel, check: Check
) -> Derivation:
    if part_loads.is_nothing:
        return replace(found, bars=BarSymbols(words="nothing loads the part"))
    best = climb.best[check.kind]
    bars, items = rung_bars(climb.part, part_loads, level.model, check, found.value, best.bores)
    if (bars.above and not isfinite(check.model)) or (bars.below and not isfinite(check.below)):
        bars, items = BarSymbols(words="no model band: see the note of the check"), []
    found = replace(found, bars=bars, sections=(*found.sections, Section(BARS, tuple(items))))
    assert climb.leaves is not None
    return climb.leaves.explained(check, found)


def _unknown(check: Check) -> Derivation:
    """A derivation that derives nothing and says so."""
    source = f"the check, by {check.method}"
    bars, widths = {}, list[Item]()
    for side, name, size in (
        ("numerical", "numerical error bar", check.numerical - check.sampling),
        ("above", "model band above", check.model - check.loads),
        ("below", "model band below", check.below - check.loads_below),
    ):
        if size and isfinite(size):
            bars[side] = f"e_{side}"
            widths.append(Given(f"e_{side}", name, size, check.unit, source))
    return Derivation(
        cases=(),
        sections=(
            Section("Demand", (Given("v", check.quantity, check.value, check.unit, source, True),)),
            Section("Limit", (Given("L", check.basis, check.limit, check.unit, source, True),)),
            Section(BARS, tuple(widths)),
        ),
        value="v",
        limit="L",
        bars=BarSymbols(**bars, words="bars as the check has them"),
        unproved=UNKNOWN,
    )


# A part by the rungs that decided it before, so that a check can be repeated.


def climb_pinned(
    climb: Climb, rungs: Mapping[str, str], say: Callable[[str], None]
) -> frozenset[str]:
    """Take each kind of check by its rung; returns the kinds that are the solid's.

    rungs  kind of check -> rung; kinds that are asked for without a rung of theirs go to the solid
           if another does, else to the formula

    Raises DesignError where the part has no formula any more, and NumericsError where that gave up:
    no solid may stand for it unsaid.
    """
    solids = frozenset(kind for kind in climb.asked if rungs.get(kind) == SOLID)
    free = frozenset(climb.asked) - rungs.keys()
    pinned = [kind for kind in climb.asked if rungs.get(kind) == FORMULA]
    if climb.part.fkm is not None:
        if pinned:
            _refuse(climb, pinned, FKM_NEEDS_SOLID)
        return solids | free
    say(f"{climb.part.name}: {FORMULA}")
    wanted = pinned if solids else [*pinned, *free]
    if wanted and not climb.by_formula(wanted) and pinned:
        _refuse(climb, pinned, climb.tried[-1].why)
    return solids | free if solids or climb.level is None else frozenset()


def _refuse(climb: Climb, kinds: list[str], why: str) -> None:
    where, file = f"parts.{climb.part.name}", climb.loaded.design.file
    said = f"{', '.join(kinds)} {'is' if len(kinds) == 1 else 'are'} pinned to the rung {FORMULA}"
    if why.startswith(GAVE_UP):
        raise NumericsError(f"{said}, which {why}", f"{file}: {where}", _ANEW)
    raise DesignError(file, where, f"{said}, but {why}; {_ANEW}")
