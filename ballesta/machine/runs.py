"""Loads of a whole machine over its cycles and its measured runs, as every command finds them."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from contextlib import suppress
from dataclasses import dataclass, replace
from math import inf

import numpy as np

import loads
from ballesta.machine.blows import SWING_ENDS, Blows, Transients, driven, swing_gates, transients_of
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
from ballesta.machine.measured_balance import measured_loads
from ballesta.machine.quasi_static import CycleVibration, vibration_warnings
from ballesta.machine.solved_cycles import (
    part_masses,
    solve_cycles,
    try_cycles,
    with_events,
    without_unknown_contacts,
)
from ballesta.machine.validity_checks import (
    dead_centre_gate,
    is_near_dead_centre,
    sensitivity_of,
)
from checks.design.data import Cycle, Design, Part
from checks.design.errors import DesignError
from checks.handbook.fits import DEFAULT, clearances_of
from checks.part.part_loads import Doubt, Runs, shown_name
from checks.result.verdict import Gate
from checks.result.words import END_OF_TRAVEL, HITS, LENGTHS_OFF, LESS_IN, WOULD_HIT, number
from checks.store.store import Store
from checks.stress.kept_models import Models
from geometry.mesh import Interface

# Play of pins in their bores: what it adds to the loads as the force of a joint reverses. Where a
# part states the fit of its pin, the loads with and without the hits of that joint's pin are a
# doubt with bars (docs/theory/joint_play.md); where no fit is stated an assumption tells how much
# the usual one would add.
_NEAT = 1.51  # k / (E' L) of a pin without play in a bore, both as stiff as the stiffer of them
_NOTHING = 1e-3  # of a joint's largest force: less is not worth the loads at another end
_TOLD = 0.02


_NO_BLOWS: Solved = {}
_AS_DRAWN: Mapping[tuple[str, str], tuple[float, float]] = {}

_Told = tuple[float, str, str]  # share of the largest force that is added, point, words


@dataclass(frozen=True)
class _Seat:
    """Play that a joint's pin can cross, mm on diameter.

    stiffness  N/mm, of its contact at the most, and of the joint where the design states it
    """

    play: float
    stiffness: float


def play_pairs(
    design: Design, solved: Solved, struck: Solved = _NO_BLOWS
) -> tuple[list[LoadPair], list[tuple[str, str]]]:
    """Loads without and with the hits of every joint that has a fit, and what is assumed of others.

    struck  cycles with the moments of their blows, which have the hits of those without on top: a
            blow that began under a hit would keep its force for as long as it lasts

    Of several bores of a joint with fits the largest plays add up. Pins that are stated as
    cushioned hit nothing; an assumption has what they would add.
    """
    pairs, silent, cushioned = [], list[_Told](), list[_Told]()
    for joint in (one for joints in design.joints.values() for one in joints if solved):
        stated = _seat(design, joint, stated=True)
        seat = stated or _seat(design, joint, stated=False)
        if seat is None:
            continue
        name, play = joint.name, seat.play
        drives = {cycle: _inertia(design, cycle) for cycle in solved}
        hits = {
            cycle: loads.play_hits(own, name, play, seat.stiffness, drives[cycle])
            for cycle, own in solved.items()
        }
        added = max((hit.added for own in hits.values() for hit in own), default=0.0)
        most = max(float(np.hypot(*own.reactions[name].force.T).max()) for own in solved.values())
        told = stated is None or joint.point_b in design.dynamics.cushioned
        if told and added > _TOLD * most:
            said = f"{number(added)} N on top of its largest force of {number(most)} N"
            of = cushioned if joint.point_b in design.dynamics.cushioned else silent
            of.append((added / most, joint.point_b, said))
        elif not told and added > _NOTHING * most:
            acting = {**solved, **struck}
            times = {cycle: solved[cycle].times for cycle in struck}
            end = {
                cycle: loads.with_hits(own, name, hits[cycle], drives[cycle], times.get(cycle))
                for cycle, own in acting.items()
            }
            words = f"play of {play:g} mm in {name} {HITS}"
            pairs.append(LoadPair(words, (acting, end)))
    return pairs, [*_assumed(silent), *_taken(design.dynamics.cushioned, cushioned)]


def _assumed(silent: list[_Told]) -> list[tuple[str, str]]:
    if not silent:
        return []
    reason = (
        f"none is stated: pins without play; with {DEFAULT} that of {_worst(silent)}: bodies as if "
        "rigid, not in the error bars"
    )
    return [("parts.fits", reason)]


def _taken(stated: Sequence[str], cushioned: list[_Told]) -> list[tuple[str, str]]:
    if not stated:
        return []
    worst = f"; else that of {_worst(cushioned)}" if cushioned else ""
    names = ", ".join(stated)
    reason = f"stated of {names}: pins are slowed as they cross their play, and hit nothing{worst}"
    return [("dynamics.cushioned", reason)]


def _worst(told: list[_Told]) -> str:
    """The pin that hits hardest beside its joint's largest force, in words."""
    (_, point, said), *others = sorted(told, key=lambda one: -one[0])
    less = ", ".join(dict.fromkeys(other for _, other, _ in others if other != point))
    behind = f" ({LESS_IN} {less})" if less else ""
    return f"{point} {WOULD_HIT} {said} where its force reverses{behind}"


def _inertia(design: Design, cycle: str) -> float:
    _, inertia, known = driven(design, design.cycles[cycle].run.pace)
    return inertia if known else inf


def _seat(design: Design, joint: loads.Joint, *, stated: bool) -> _Seat | None:
    """The joint's seat; None where no part has a bore for it, or none with a fit.

    Plays of stated fits add up, and so does what gives way. Else a pin turns in one bore.
    """
    if not isinstance(joint, loads.Revolute):
        return None
    seats = []
    for part, bore in _bores(design, joint):
        if stated and bore.name not in part.clearances:
            continue
        pin = next((one for one in design.parts.values() if one.joint == joint.point_b), part)
        moduli = [
            m.youngs_modulus / (1.0 - m.poisson_ratio**2) for m in (part.material, pin.material)
        ]
        soft = 1.0 / (_NEAT * max(moduli) * bore.length)
        if stated:
            seats.append((part.clearances[bore.name][1], soft))
        else:
            with suppress(ValueError):  # a bore larger than any of the table
                seats.append((clearances_of(DEFAULT, 2.0 * bore.radius)[1], soft))
    if not seats:
        return None
    play, soft = np.sum(seats, axis=0) if stated else max(seats)
    if play <= 0.0:
        return None
    for one in design.compliance:
        if isinstance(one, loads.JointCompliance) and one.joint == joint.name:
            soft += 1.0 / one.stiffness
    return _Seat(float(play), float(1.0 / soft))


def _bores(design: Design, joint: loads.Revolute) -> Iterator[tuple[Part, Interface]]:
    for body, point in ((joint.body_a, joint.point_a), (joint.body_b, joint.point_b)):
        part = design.part_of(body)
        if part is None:
            continue
        for face in part.geometry.placed_interfaces:
            if face.kind == "bore" and part.interfaces.get(face.name) == point:
                yield part, face


# The machine.
_AT_END = 1e-9  # of the travel
_CLOSER = 5.0  # times as sensitive to lengths: the other end of a doubt is the dead centre
_WARNED_OF = 1.5  # times as sensitive: an assumed stop off by less is a warning's matter


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
    struck = {name: machine.solved[name] for name in machine.blows}
    hitting, without_fit = play_pairs(design, machine.rigid, struck)
    stopping, beyond = stop_doubts(design, machine.rigid)
    shaping, general = length_doubts(design, machine.rigid)
    speeds = speed_doubts(design, machine.rigid, evenness)
    pairs = [*speeds, *stopping, *shaping, *rubbing, *hitting]

    ends: list[Transients] = []

    def runs(end: Mapping[str, loads.CycleLoads], pick: str = "") -> Runs:
        done = {name: own for name, own in end.items() if own.unstruck is not None}
        still = {name: own for name, own in end.items() if name not in done}
        ends.append(transients_of(design, still, machine.vibration, pick))
        found = {**ends[-1].cycles, **done}
        return {**{name: found[name] for name in end}, **machine.measured}

    doubts = [
        Doubt(pair.words, tuple(map(runs, pair.ends)), speed=k < len(speeds))
        for k, pair in enumerate(pairs)
    ]
    if any(one.swung for one in machine.blows.values()):
        words = "natural frequencies in the swing by blows, lowest or highest over the cycle"
        doubts.append(Doubt(words, tuple(runs(machine.rigid, one) for one in SWING_ENDS)))
    return MachineDoubts(
        evenness,
        {gate for pair in pairs for gate in pair.gates},
        [*speed_gates(evenness), *unsolved, *beyond, *swing_gates([end.blows for end in ends])],
        doubts,
        [*speed_assumptions(evenness), *general, *without_fit],
    )


# Lengths next to a dead centre: the loads of a linkage whose places are off by general tolerances.


def length_doubts(design: Design, solved: Solved) -> tuple[list[LoadPair], list[tuple[str, str]]]:
    """The loads with lengths off of cycles near a dead centre, where no stop is stated.

    None where an end comes next to the dead centre itself, nor with `dynamics.apply`: a validity
    check binds.
    """
    pairs = []
    for name, cycle in solved.items():
        stated = design.cycles[name]
        known = design.dynamics.apply or stated.stop is not None or stated.event is not None
        if known or not is_near_dead_centre(stated, cycle):
            continue
        shifts = loads.worst_shifts(cycle, cycle.sensitivity.row)
        other = {place: (-x, -y) for place, (x, y) in shifts.items()}
        low, high = (_again(stated, cycle, stated.run, own) for own in (other, shifts))
        if low is not None and high is not None:
            ends = ({**solved, name: low}, {**solved, name: high})
            pairs.append(LoadPair(f"{name}: {LENGTHS_OFF}", ends, (dead_centre_gate(name),)))
    if not pairs:
        return [], []
    cycles = ", ".join(pair.words.removesuffix(f": {LENGTHS_OFF}") for pair in pairs)
    reason = f"lengths within the general tolerances of ISO 2768-1 m: both ends in {cycles}"
    return pairs, [("points", reason)]


def _again(
    stated: Cycle,
    cycle: loads.CycleLoads,
    run: loads.Cycle,
    shifts: Mapping[tuple[str, str], tuple[float, float]] = _AS_DRAWN,
) -> loads.CycleLoads | None:
    """The loads of a run of a cycle's linkage, places off; None next to the dead centre itself."""
    try:
        found = loads.run_cycle(loads.with_places_off(cycle.linkage, shifts), run)
    except loads.LinkageError:
        return None
    most = _CLOSER * sensitivity_of(stated, cycle).most
    return found if sensitivity_of(stated, found).most <= most else None


# Ends of a travel: the loads where it ends a little sooner or later.
#
# What a stop is off by at most is stated (`stop.tolerance`), so the loads at both ends of that are
# a doubt with bars: of every mechanical stop, and of an assumed one near a dead centre, or whose
# tolerance comes near to it. Where one of its ends comes next to the dead centre itself no bar
# tells anything: a validity check binds.


def stop_doubts(design: Design, solved: Solved) -> tuple[list[LoadPair], list[Gate]]:
    """The loads of all cycles whose stop has a tolerance that is in the bars.

    Cycles that end at the same mechanical stop move together. With `dynamics.apply` there are no
    such loads, as what vibration adds is known at the cycle's own positions only: a validity check
    binds then, too.
    """
    pairs: list[LoadPair] = []
    gates: list[Gate] = []
    stops: dict[tuple[object, ...], list[str]] = {}
    for name, cycle in solved.items():
        stop, run = design.cycles[name].stop, design.cycles[name].run
        if stop is None or not stop.tolerance:
            continue
        if is_near_dead_centre(design.cycles[name], cycle):
            stops[name,] = [name]
        elif stop.basis == "mechanical" or not design.dynamics.apply:
            end = round(_farthest(run), 9)
            stops.setdefault((str(run.coordinate), end, stop.basis, stop.tolerance), []).append(
                name
            )
    for names in stops.values():
        first = names[0]
        near = is_near_dead_centre(design.cycles[first], solved[first])
        if design.dynamics.apply:
            if not near:
                said = "vibration is on the loads"
                gates.append(_unknown_end(first, said, "or dynamics.apply=false"))
            continue
        ends: list[dict[str, loads.CycleLoads]] = []
        stop = design.cycles[first].stop
        assert stop is not None
        for way in (-1.0, 1.0):
            moved = {n: _moved(design, n, solved[n], way * stop.tolerance, near) for n in names}
            ends.append({n: cycle for n, cycle in moved.items() if cycle is not None})
        if all(len(end) == len(names) for end in ends):
            _, unit = shown_name(design.cycles[first])
            size = float(np.degrees(stop.tolerance)) if unit == "deg" else stop.tolerance
            low, high = ({**solved, **end} for end in ends)
            closer = any(
                end[n].shape_sensitivity.most > _WARNED_OF * solved[n].shape_sensitivity.most
                for end in ends
                for n in names
            )
            if stop.basis == "assumed" and not near and not closer:
                continue
            words = f"{first}: {END_OF_TRAVEL} {size:.3g} {unit}"
            covered = (dead_centre_gate(first),) if near else ()
            pairs.append(LoadPair(words, (low, high), covered))
        elif not near:
            said = "it reaches a dead centre, where the linkage cannot go, or a force is not given"
            gates.append(_unknown_end(first, said, "or end the travel before"))
    return pairs, gates


def _farthest(run: loads.Cycle) -> float:
    """End of a cycle's phases that is farthest from its start."""
    return max((phase.stop for phase in run.phases), key=lambda end: abs(end - run.start))


def _unknown_end(cycle: str, why: str, otherwise: str) -> Gate:
    return Gate(
        f"{cycle}: end of its travel",
        1.0,
        0.0,
        f"stops whose tolerance has no loads for the bars: {why}",
        cure=f"State a smaller cycles.{cycle}.stop.tolerance, 0 for none, {otherwise}",
    )


def _moved(
    design: Design, name: str, cycle: loads.CycleLoads, by: float, near: bool
) -> loads.CycleLoads | None:
    """The cycle with its stop elsewhere, the end next to the dead centre where one is near.

    None where that tells nothing.
    """
    stated = design.cycles[name]
    run = stated.run
    at = sensitivity_of(stated, cycle).at if near else _farthest(run)
    ends = np.array([run.start, *(phase.stop for phase in run.phases)])
    there = np.abs(ends - at) <= _AT_END * float(np.ptp(ends))
    if not there.any():
        return None
    elsewhere = np.where(there, ends + by, ends)
    phases = tuple(
        replace(phase, stop=float(stop))
        for phase, stop in zip(run.phases, elsewhere[1:], strict=True)
    )
    return _again(stated, cycle, replace(run, start=float(elsewhere[0]), phases=phases))
