"""Loads of a whole machine over its cycles and its measured runs, as every command finds them."""

from collections.abc import Callable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace

import numpy as np

import loads
from ballesta.machine.balance import measured_loads
from ballesta.machine.blows import SWING_ENDS, Blows, Transients, swing_gates, transients_of
from ballesta.machine.drive_speed import (
    Evenness,
    LoadPair,
    Solved,
    evenness_of,
    friction_pairs,
    speed_assumptions,
    speed_doubts,
    speed_gates,
)
from ballesta.machine.elastic_parts import compliances_of
from ballesta.machine.events import with_events
from ballesta.machine.joint_play import play_pairs
from ballesta.machine.quasi_static import (
    CycleVibration,
    vibration_warnings,
)
from ballesta.machine.solved_cycles import (
    part_masses,
    solve_cycles,
    try_cycles,
    without_unknown_contacts,
)
from ballesta.machine.validity_checks import dead_centre_gate, is_near_dead_centre
from checks.design.data import Design
from checks.design.errors import DesignError
from checks.part.part_loads import Doubt, Runs, shown_name
from checks.result.verdict import Gate
from checks.store.store import Store
from checks.stress.kept_models import Models

_AT_END = 1e-9  # of the travel
_LEFT = 0.2  # of the share of the motion that the solved force sees: less is the dead centre


@dataclass(frozen=True, eq=False)
class MachineRuns:
    """Loads of a machine over every run.

    design      with its events among its cycles
    masses      body -> mass, centre and inertia of its part
    solved      cycle -> its loads, with dynamic factors where the design asks for them, and with
                the moments of blows whose workpiece is stated
    blows       cycle -> its blows whose workpiece is stated
    measured    run -> its loads
    rigid       cycle -> its loads without dynamic factors
    vibration   cycle -> how the linkage vibrates in it
    warnings    of vibration
    """

    design: Design
    masses: Mapping[str, tuple[float, tuple[float, float], float]]
    solved: Mapping[str, loads.CycleLoads]
    blows: Blows
    measured: Mapping[str, loads.MeasuredLoads]
    rigid: Mapping[str, loads.CycleLoads]
    vibration: Mapping[str, CycleVibration]
    warnings: list[str]

    @property
    def all(self) -> Runs:
        """Cycles, then measured runs, by name."""
        return {**self.solved, **self.measured}


def run_machine(
    design: Design,
    models: Models,
    say: Callable[[str], None] = lambda _: None,
    store: Store | None = None,
    *,
    skins: bool = False,
) -> MachineRuns:
    """Solve the cycles of a design and balance its measured runs.

    skins  True to begin the surfaces of all parts, for pictures, while the cycles are solved

    Cycles that cannot move or do not balance raise before anything is meshed. Raises DesignError,
    NumericsError, and loads.LinkageError for the linkage itself.
    """
    try_cycles(without_unknown_contacts(design))
    measured_loads(design, {})
    if skins:
        models.begin_skins(part.geometry for part in design.parts.values())
    masses = part_masses(design, models, say)
    compliances = compliances_of(design, models, say)
    say("loads: solving the cycles")
    design = with_events(design, masses, compliances)
    rigid = solve_cycles(design, masses, compliances, store)
    say("loads: vibration of the linkage")
    transients = transients_of(design, rigid)
    return MachineRuns(
        design=design,
        masses=masses,
        solved=transients.cycles,
        blows=transients.blows,
        measured=measured_loads(design, masses),
        rigid=rigid,
        vibration=transients.vibration,
        warnings=vibration_warnings(design, transients.smooth, transients.vibration),
    )


def solved_runs(design: Design, models: Models, say: Callable[[str], None]) -> tuple[Design, Runs]:
    """The design with its events, its cycles solved and its measured runs, as a check has them.

    Raises DesignError, for the linkage itself too, and NumericsError.
    """
    try:
        machine = run_machine(design, models, say)
        return machine.design, machine.all
    except loads.LinkageError as error:
        raise DesignError(design.file, "linkage", str(error)) from error


@dataclass(frozen=True, eq=False)
class MachineDoubts:
    """Doubts about the loads of a machine.

    evenness  cycle -> how evenly its drive turns
    covered   names of the validity checks of the loads that they take the place of
    gates     validity checks of doubts that have no loads at one of their ends
    all       each by the runs at its ends
    assumed   key and reason
    """

    evenness: Mapping[str, Evenness]
    covered: AbstractSet[str]
    gates: Sequence[Gate]
    all: Sequence[Doubt]
    assumed: Sequence[tuple[str, str]]


def doubts_of(design: Design, machine: MachineRuns) -> MachineDoubts:
    """Solve the cycles at the ends of every doubt about their loads."""
    evenness = evenness_of(design, machine.rigid)
    rubbing, unsolved = friction_pairs(design, machine.rigid)
    hitting, without_fit = play_pairs(design, machine.rigid)
    pairs = [
        *speed_doubts(design, machine.rigid, evenness),
        *stop_doubts(design, machine.rigid),
        *rubbing,
        *hitting,
    ]

    ends: list[Transients] = []

    def runs(end: Mapping[str, loads.CycleLoads], pick: str = "") -> Runs:
        ends.append(transients_of(design, end, machine.vibration, pick))
        return {**ends[-1].cycles, **machine.measured}

    doubts = [Doubt(pair.words, tuple(map(runs, pair.ends))) for pair in pairs]
    if any(one.swung for one in machine.blows.values()):
        words = "natural frequencies in the swing by blows, lowest or highest over the cycle"
        doubts.append(Doubt(words, tuple(runs(machine.rigid, one) for one in SWING_ENDS)))
    return MachineDoubts(
        evenness,
        {pair.gate for pair in pairs if pair.gate},
        [*speed_gates(evenness), *unsolved, *swing_gates([end.blows for end in ends])],
        doubts,
        [*speed_assumptions(evenness), *without_fit],
    )


# Ends of a travel beside a dead centre: the loads where it ends a little sooner or later.
#
# Next to a dead centre the loads of rigid bodies depend on where the travel ends. What its stop
# is off by at most is stated (`stop.tolerance`), so the loads at both ends of that are a doubt
# with bars. Where one of them comes next to the dead centre itself no bar tells anything: the
# gate binds.


def stop_doubts(design: Design, solved: Solved) -> list[LoadPair]:
    """The loads of every cycle that comes too near to a dead centre at a stop with a tolerance.

    None with `dynamics.apply`: what vibration adds is known at the cycle's own positions only.
    """
    found = []
    for name, cycle in solved.items():
        stop = design.cycles[name].stop
        if stop is None or design.dynamics.apply or not is_near_dead_centre(cycle):
            continue
        moved = [_moved(design, name, cycle, way * stop.tolerance) for way in (-1.0, 1.0)]
        if all(moved):
            _, unit = shown_name(design.cycles[name])
            size = float(np.degrees(stop.tolerance)) if unit == "deg" else stop.tolerance
            first, second = ({**solved, name: end} for end in moved if end is not None)
            words = f"{name}: end of its travel off by up to {size:.3g} {unit}"
            found.append(LoadPair(words, (first, second), dead_centre_gate(name)))
    return found


def _moved(
    design: Design, name: str, cycle: loads.CycleLoads, by: float
) -> loads.CycleLoads | None:
    """The cycle with the end next to the dead centre elsewhere; None where that tells nothing."""
    run = design.cycles[name].run
    worst = int(cycle.conditioning.argmin())
    at = float(cycle.positions[worst])
    ends = np.array([run.start, *(phase.stop for phase in run.phases)])
    there = np.abs(ends - at) <= _AT_END * float(np.ptp(ends))
    if not there.any():
        return None
    elsewhere = np.where(there, ends + by, ends)
    phases = tuple(
        replace(phase, stop=float(stop))
        for phase, stop in zip(run.phases, elsewhere[1:], strict=True)
    )
    try:
        found = loads.run_cycle(
            cycle.linkage, replace(run, start=float(elsewhere[0]), phases=phases)
        )
    except loads.LinkageError:
        return None
    return found if found.conditioning.min() >= _LEFT * cycle.conditioning[worst] else None
