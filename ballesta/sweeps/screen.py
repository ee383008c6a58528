"""Many variations of a design by formula: which pass, which fail, and by what.

Every variation is the design with other values at some of its keys, read through the same door as
any design. Its masses follow from its parts, in closed form where there is one; its loads are
solved for again with them, at the positions of the design as it is where only masses, friction and
constant forces differ (`loads.moves_alike`), else from the beginning. Every part is judged by the
rung `formula` with its error bars and by the checks that are formulas anyway. What a whole check
asks besides is left out: buckling of the linkage unless it is asked for, vibration unless the
design puts it on its loads, validity checks of the loads, and the proof of the fatigue safety.
"""

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import loads
from ballesta.design.read import read_design
from ballesta.machine.blows import transients_of
from ballesta.machine.elastic_parts import compliances_of
from ballesta.machine.measured_balance import measured_loads
from ballesta.machine.solved_cycles import linkage_of, part_masses, told_of_cycle, with_events
from checks.by_formula import formula_checks
from checks.columns.cylinders import cylinder_checks
from checks.columns.linkage_frame import linkage_check, worst_mode
from checks.design.data import Design, Part
from checks.design.effort import FORMULA
from checks.design.errors import DesignError, NumericsError
from checks.ladder.climb import Climb, answered, climb_cheap, start_climb
from checks.ladder.leaf_checks import LeafBand
from checks.ladder.result import rung_gates
from checks.models.checked import BUCKLING
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads, loads_on
from checks.result.verdict import Check, Gate, Status, deciding_of, status_of
from checks.strength.part_strength import elastic_of
from checks.stress.kept_models import told_of_part
from checks.stress.solid_mesh_level import Models
from checks.stress.stress_result import RungModel
from fem.unit_solutions import Elastic
from geometry.cad_body import SolidBody

Variation = Mapping[str, Any] | Sequence[str]
Masses = Mapping[str, tuple[float, tuple[float, float], float]]
Failed = Callable[[Sequence[Check]], bool]


@dataclass(frozen=True, eq=False, kw_only=True)
class Screened:
    """Formula estimate of one variation of a design.

    overrides  what it changes, each as "key=value"
    checks     of all parts, with their bars
    gates      of all parts
    masses     t, of the parts by name; a pin counts in no body
    open       part -> why no rung below the solid judges its stress
    rubbing    part -> friction between its leaves, as it was taken
    afresh     whether its loads were run from the beginning, their positions placed anew
    problem    why it could not be checked, else nothing
    """

    overrides: tuple[str, ...]
    checks: Sequence[Check] = ()
    gates: Sequence[Gate] = ()
    masses: Mapping[str, float] = field(default_factory=dict)
    open: Mapping[str, str] = field(default_factory=dict)
    rubbing: Mapping[str, LeafBand] = field(default_factory=dict)
    afresh: bool = False
    problem: str = ""

    @property
    def mass(self) -> float:
        """Mass of all parts, t."""
        return sum(self.masses.values())

    @property
    def status(self) -> Status | None:
        """As of a design's result, by what was asked; None where it could not be checked."""
        if self.problem:
            return None
        found = status_of(self.checks, self.gates)
        return Status.UNDECIDED if self.open and found is Status.PASS else found

    @property
    def governing(self) -> Check | None:
        """The check that is nearest to its limit, bars included."""
        return deciding_of(self.checks) if self.checks else None


def overrides_of(variation: Variation) -> tuple[str, ...]:
    """Return what a variation changes, each as "key=value"."""
    if isinstance(variation, Mapping):
        return tuple(f"{key}={json.dumps(value)}" for key, value in variation.items())
    return tuple(variation)


class Screening:
    """A design whose cycles are solved, to screen its variations one by one.

    between  whether the bars hold what the positions miss between them; without, a variation takes
             half the time
    rubbing  part -> friction between its leaves, whose share of the stress variations keep; it is
             solved where a part is not in it
    cycles   that are solved: those of the duty among them; None for all
    solved   cycles of the design as it is, without dynamic factors

    Raises DesignError and NumericsError for the design itself.
    """

    def __init__(
        self,
        design: Design,
        *,
        between: bool = True,
        rubbing: Mapping[str, LeafBand] | None = None,
        cycles: Collection[str] | None = None,
        solved: Mapping[str, loads.CycleLoads] | None = None,
    ) -> None:
        self.between, self._only = between, cycles
        self.rubbing = dict(rubbing or {})
        self.models = Models()
        masses = part_masses(design, self.models)
        self._linkages: dict[str, loads.Linkage] = {}
        self._cycles: dict[str, loads.Cycle] = {}
        self._solved: dict[str, loads.CycleLoads] = {}
        self._part_loads: dict[str, PartLoads] = {}  # in the design as it is
        self.stress: dict[str, RungModel] = {}  # of its parts by formula, before it is judged
        if solved is None:
            self.design, self._solved, _ = self.solve(design, masses)
        else:
            self.design = with_events(design, masses, compliances_of(design, self.models))
            self._solved = {
                name: run for name, run in solved.items() if cycles is None or name in cycles
            }
        for name in self._solved:
            self._linkages[name] = self._solved[name].linkage
            self._cycles[name] = self.design.cycles[name].run

    def solve(
        self, design: Design, masses: Masses
    ) -> tuple[Design, dict[str, loads.CycleLoads], bool]:
        """A variation with its events, its cycles, and whether any was run from the beginning."""
        compliances = compliances_of(design, self.models)
        design = with_events(design, masses, compliances)
        solved, afresh = {}, False
        for name, stated in design.cycles.items():
            if self._only is not None and name not in self._only:
                continue
            with told_of_cycle(design, name):
                linkage = linkage_of(design, masses, stated, compliances)
                cycle = stated.run
                known = self._solved.get(name)
                if known is None:
                    solved[name] = loads.run_cycle(linkage, cycle)
                    afresh = True
                elif (self._linkages[name], self._cycles[name]) == (linkage, cycle):
                    solved[name] = known
                elif loads.moves_alike(self._linkages[name], self._cycles[name], linkage, cycle):
                    solved[name] = loads.forces_again(known, linkage, cycle)
                else:
                    solved[name] = loads.run_cycle(linkage, cycle)
                    afresh = True
        return design, solved, afresh

    def of(
        self,
        variation: Variation,
        parts: Collection[str] | None = None,
        *,
        formulas: bool = True,
        linkage: bool = False,
        reserves: Mapping[str, float] | None = None,
        anew: bool = False,
        only_materials: bool = False,
        failed: Failed | None = None,
    ) -> Screened:
        """Check one variation by formula; its `problem` says what is wrong with it.

        parts     whose checks are wanted; None for all
        formulas  whether those are wanted besides stress: buckling, and what is a formula anyway
        linkage   whether buckling of the linkage as a whole is checked, too
        reserves  of parts in the design as it is: an unchanged part has no checks where its loads
                  grow by less than half of what its reserve is above 1
        anew      whether friction between leaves is solved, also where it is known of the design
        only_materials  True if nothing else is varied: what only has other strengths keeps its
                  stress, which is not computed again
        failed    of the stress checks of a part: True where its others are not wanted
        """
        overrides = overrides_of(variation)
        try:
            design = read_design(self.design.file, (*self.design.overrides, *overrides))
            masses = part_masses(design, self.models)
            design, solved, afresh = self.solve(design, masses)
            solved = transients_of(design, solved, every=False).cycles
            runs: dict[str, loads.CycleLoads | loads.MeasuredLoads] = {
                **solved,
                **measured_loads(design, masses),
            }
            checks: list[Check] = []
            gates: list[Gate] = []
            left: dict[str, str] = {}
            rubbed: dict[str, LeafBand] = {}
            for part in design.parts.values():
                with told_of_part(design, part):
                    body = self.models.body(part.geometry)
                    if parts is not None and part.name not in parts:
                        continue
                    if reserves and self.spares(
                        design, part, loads_on(design, part, runs), reserves[part.name]
                    ):
                        continue
                    loaded = LoadedPart.of(design, part, runs, self.models)
                    if not self.between:
                        loaded = loaded.under(replace(loaded.loads, path=None))
                    climb = start_climb(loaded, None if anew else self.rubbing.get(part.name))
                    keeps = only_materials and self.has_stress_of(part, solved)
                    if keeps:
                        climb.model = self.stress.get(part.name)
                    if not formulas:
                        climb.asked = tuple(kind for kind in climb.asked if kind != BUCKLING)
                    before = len(checks)
                    why = _check_part(climb, body, checks, gates)
                    if keeps and climb.model is not None:
                        self.stress[part.name] = climb.model
                    rubbed |= {} if climb.leaves is None else {part.name: climb.leaves}
                    if formulas and not (failed and failed(checks[before:])):
                        checks += formula_checks(loaded)
                if why:
                    left[part.name] = why
            mode = worst_mode(design, solved) if linkage else None
            if mode is not None:
                checks.append(linkage_check(design, mode.under(design.load_factor)))
            if linkage:
                checks += cylinder_checks(design, runs)
            return Screened(
                overrides=overrides,
                checks=checks,
                gates=gates,
                masses=self.weights(design),
                open=left,
                rubbing=rubbed,
                afresh=afresh,
            )
        except (DesignError, NumericsError) as error:
            return Screened(overrides=overrides, problem=str(error))

    def weights(self, design: Design) -> dict[str, float]:
        """Mass of every part of the design or of a variation, t."""
        found = {}
        for part in design.parts.values():
            with told_of_part(design, part):
                body = self.models.body(part.geometry)
                found[part.name] = body.mass_properties(part.material.density).mass
        return found

    @cached_property
    def _whole(self) -> dict[str, loads.CycleLoads]:
        return transients_of(self.design, self._solved, every=False).cycles

    def has_stress_of(self, part: Part, solved: Mapping[str, loads.CycleLoads]) -> bool:
        """True for a part as in the design but for its strengths, under the same cycles."""
        own = self.design.parts[part.name]
        return (
            elastic_of(part) == elastic_of(own)
            and replace(part, material=own.material) == own
            and not self.design.measured
            and all(solved[name] is run for name, run in self._solved.items())
        )

    def spares(self, varied: Design, part: Part, loads: PartLoads, reserve: float) -> bool:
        """True if a part is as in the design, and its loads leave the half of its reserve.

        So must be what bends the pins in its bores.
        """
        if part != self.design.parts[part.name] or not reserve > 1:
            return False
        if _bent_by(varied, part) != _bent_by(self.design, part):
            return False
        before = self._part_loads.get(part.name)
        if before is None:
            before = self._part_loads[part.name] = loads_on(self.design, part, self._whole)
        return loads.within(before, (reserve - 1) / 2)


def _bent_by(design: Design, part: Part) -> list[tuple[Part, list[Elastic]]]:
    """The pins in a body part's bores, each with how stiff the parts in its stack are."""
    if part.body is None:
        return []
    return [
        (pin, [elastic_of(one) for lug in pin.interfaces if (one := design.part_of(lug))])
        for pin in design.parts.values()
        if pin.joint is not None and pin.joint in part.interfaces.values()
    ]


def _check_part(climb: Climb, body: SolidBody, checks: list[Check], gates: list[Gate]) -> str:
    """Add checks and gates of a part's stress; returns why it is not judged, if it is not."""
    why = ""
    if climb_cheap(climb, FORMULA):
        why = "; ".join(tried.why for tried in climb.tried)
    else:
        checks += answered(climb)
        assert climb.level is not None
        gates += rung_gates(climb, climb.level, body.size)
    return why
