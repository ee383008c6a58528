"""Drives, contacts and gates of the loads in sentences, for the terminal and the page alike."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot, inf, isfinite, pi

from checks.result.verdict import DesignResult, Gate, PartResult
from checks.result.words import brief, gate_sentence, number, place_text, quantity_unit
from reports.loads_figures import (
    BlowForceSummary,
    BlowSummary,
    ContactSpan,
    ContactSummary,
    Direction,
    DriveSummary,
    EventFigures,
    MotorFigures,
)
from reports.loads_summary import LoadsResult, ShownCycle

SIGNS = (
    "Reactions are what a joint does to the body under “on”; the body under “by” gets the "
    "opposite. Axes of the ground: x to the right, y up, moments counter-clockwise."
)
FRICTION = (
    "Friction of a guide or slot is its coefficient times |N|, the force across its line; the "
    "couple M of a guide does not add to it. Friction of a pin is a couple: its coefficient times "
    "its radius times |F|."
)
MEASURED = (
    "What was measured is the load on the body, at the point; axes of the ground: x to the right, "
    "y up, moments counter-clockwise."
)
_MOST_SPANS = 4
_NO_IMPULSE = 1e-9  # of a blow's: less is rounding


def header_sentences(result: LoadsResult) -> list[str]:
    """Signs and conventions that the result needs to be read."""
    said = [SIGNS] if result.cycles else []
    if result.rubbing:
        said.append(FRICTION)
    return [*said, MEASURED] if result.runs else said


def direction_sentence(direction: Direction, angular: bool, cycle: ShownCycle) -> str:
    """The largest effort of a drive in one direction against what is available."""
    unit, factor = quantity_unit(angular, max(direction.needed, direction.available or 0.0))
    said = (
        f"{direction.words} up to {number(direction.needed * factor, 4)} {unit} at "
        f"{brief(cycle.shown_name, 20)} = {place_text(direction.at)} {cycle.unit}"
    )
    if direction.available is None:
        return said
    share = direction.needed / direction.available
    return f"{said} of {number(direction.available * factor, 4)} {unit} available ({share:.1%})"


def drive_sentences(drive: DriveSummary, cycle: ShownCycle) -> list[str]:
    """Everything about a drive: its efforts, its power, and how evenly it would run."""
    said = [direction_sentence(d, drive.angular, cycle) for d in drive.directions]
    said.append(
        f"mean power {number(drive.mean_power * 1e-3)} W, "
        f"peak {number(drive.peak_power * 1e-3)} W, work {number(drive.work * 1e-3)} J a cycle"
    )
    if not drive.closed and cycle.event is None:
        said.append(
            "not closed: ends in another pose than it starts from; work and mean power are of this "
            "stretch"
        )
    if drive.impact_energy > 0.0:
        said.append(
            "the mean power does not contain the impact of what is touched, "
            f"{number(drive.impact_energy * 1e-3)} J a cycle"
        )
    if cycle.motor is not None and cycle.role(drive.name) == "solved":
        said.append(motor_sentence(cycle.motor, cycle))
    even = flywheel_sentence(drive) if cycle.motor is None else ""
    return [*said, even] if even else said


def flywheel_sentence(drive: DriveSummary) -> str:
    """Irregularity of a closed crank cycle, in words; "" where it does not apply."""
    if drive.ripple is None or drive.reduced_inertia is None:
        return ""
    if drive.irregularity is None or drive.flywheel is None:
        return "nothing that it drives has a mass: the ripple of its speed is unknown"
    return (
        f"reduced inertia {number(drive.reduced_inertia * 1e-3)} kg m2 in the mean; the torque's "
        f"ripple of {number(drive.ripple * 1e-3)} J would make the speed irregular by "
        f"{number(drive.irregularity)}; {number(drive.allowed)} needs "
        f"{number(drive.flywheel * 1e-3)} kg m2 in all"
    )


def motor_sentence(motor: MotorFigures, cycle: ShownCycle) -> str:
    """Speed and torque of a motor over a cycle."""
    unit, factor = quantity_unit(True, max(motor.largest, motor.rated))
    per_minute = 60.0 / (2.0 * pi)
    shown = brief(cycle.shown_name, 20)
    even = (motor.fastest - motor.slowest) / motor.mean
    return (
        f"the motor, geared {number(motor.ratio)} : 1, turns it at "
        f"{number(motor.mean * per_minute, 4)} rpm in the mean, "
        f"{number(motor.slowest * per_minute, 4)} at {shown} = {place_text(motor.slowest_at)} and "
        f"{number(motor.fastest * per_minute, 4)} at {place_text(motor.fastest_at)} {cycle.unit} "
        f"(irregularity {number(even)}); effective torque {number(motor.effective * factor)} of "
        f"{number(motor.rated * factor)} {unit} rated, largest {number(motor.largest * factor)} "
        f"{unit}, {number(motor.power * 1e-3)} W in the mean at its shaft"
    )


_EVENTS = {"start": "from rest", "coast": "to rest without motor", "brake": "to rest by the brake"}


def event_sentence(event: EventFigures) -> str:
    """A start or stop in words: from where, how long, and its peaks beside the steady ones."""
    force, per_force = quantity_unit(False, max(event.force, event.steady_force))
    torque, per_torque = quantity_unit(True, max(event.torque, event.steady_torque))
    of = f", worst of {event.tried} places" if event.tried else ""
    return (
        f"{_EVENTS[event.kind]} at {brief(event.shown_name, 20)} = {place_text(event.at)} "
        f"{event.unit}{of}: {number(event.time)} s and {number(event.turns)} turns of the cycle "
        f"{brief(event.cycle, 20)}; largest joint force {number(event.force * per_force, 4)} "
        f"{force}, {number(event.steady_force * per_force, 4)} in the steady run; largest torque "
        f"into the linkage {number(event.torque * per_torque, 4)} {torque}, "
        f"{number(event.steady_torque * per_torque, 4)} in the steady run"
    )


def contact_sentence(contact: ContactSummary, cycle: ShownCycle) -> str:
    """Contact in words: place, force, speed, and its effect on the body."""
    length = "rad" if contact.angular else "mm"
    said = brief(contact.name, 30)
    if contact.stated is not None:
        places = " and ".join(place_text(at) for at in contact.stated.at)
        said += f" at {brief(contact.stated.coordinate, 30)} = {places} {length}"
    known = [
        blow.solved
        for blow in cycle.blows
        if blow.force == contact.name and blow.solved is not None
    ]
    if not contact.spans and known:
        return f"{said}: touches in its blow alone"
    if not contact.spans:
        near = "" if contact.nearest is None else f", {number(contact.nearest)} {length} stay free"
        return f"{said}: does not touch in this cycle{near}"
    if contact.always:
        said += ": touches all the time"
    else:
        spans = [_span(span, cycle, length) for span in contact.spans[:_MOST_SPANS]]
        more = len(contact.spans) - len(spans)
        several = f" {len(contact.spans)} times" if len(contact.spans) > 1 else ""
        tail = f", and {more} more" if more else ""
        said += f": touches{several} " + ", ".join(spans) + tail
    if contact.start_depth is not None:
        said += (
            f"; already pressed by {number(contact.start_depth)} {length} at the start: is the "
            "contact on the other side?"
        )
    unit, factor = quantity_unit(contact.angular, contact.largest)
    phase = f" ({brief(contact.largest_phase, 20)})" if len(cycle.phases) > 1 else ""
    said += (
        f"; up to {number(contact.largest * factor, 4)} {unit} at {brief(cycle.shown_name, 20)} = "
        f"{place_text(contact.largest_at)} {cycle.unit}{phase}"
    )
    if contact.deflection > 0.0:
        said += f", the linkage gives way by up to {number(contact.deflection)} {length}"
    if any(blow.count for blow in known):
        return f"{said}; it would as if slowly, and swings by its blows in these loads"
    said += f"; {brief(contact.body, 30)} {_held(contact)}"
    return said if known or not contact.energy else f"{said}; the impact is not in these loads"


def blow_sentence(blow: BlowSummary, cycle: ShownCycle) -> str:
    """A blow in words: what strikes, impulse, energy, what joints take, and what is not known."""
    phase = f" ({brief(blow.phase, 20)})" if len(cycle.phases) > 1 else ""
    said = (
        f"{brief(blow.force, 30)} at {brief(cycle.shown_name, 20)} = {place_text(blow.at)} "
        f"{cycle.unit}{phase}: "
    )
    if blow.solved is not None:
        return f"{said}{_blow_force(blow, blow.solved)}"
    if not isfinite(blow.impulse[1]):
        return f"{said}no bound of the impulse, as the drive holds its speed behind rigid bodies"
    if blow.mass[1] <= 0.0:
        return f"{said}nothing that has a mass strikes"
    rest = blow.restitution[0]
    basis = f"restitution {rest:g}" if blow.stated else "restitution 0 ... 1, none is stated"
    said += (
        f"{_from_to(blow.mass, 1e3)} kg strike at {number(blow.speed)} mm/s ({basis}): impulse "
        f"{_from_to(blow.impulse)} N s, {_from_to(blow.energy, 1e-3)} J lost, rebound at "
        f"{_from_to(blow.rebound)} mm/s"
    )
    if blow.per_minute is not None:
        said += f", {number(blow.per_minute)} times a minute"
    if blow.open:
        joints = ", ".join(brief(name, 20) for name in blow.open)
        rigid = f"{number(blow.rigid_mass * 1e3)} kg" if isfinite(blow.rigid_mass) else "no bound"
        rigid = rigid if blow.drive_stated else f"at least {rigid}"
        if blow.mass[1] > blow.mass[0]:
            said += (
                f"; {joints} give way about as what is struck does, so that anything up to the "
                f"rigid linkage ({rigid}) may strike, and impulses of joints are not known"
            )
        else:
            said += f"; {joints} give way and pass nothing on ({rigid} if the linkage were rigid)"
    if blow.drive_struck and not blow.drive_stated:
        said += "; the drive's own inertia is not stated and adds to it (drive.flywheel)"
    least = _NO_IMPULSE * max(blow.impulse)
    taken = [
        f"{brief(joint.name, 20)} {number(hypot(joint.x, joint.y))} N s"
        + (f" and {number(abs(joint.couple) * 1e-3)} N m s" if joint.couple else "")
        for joint in blow.joints
        if hypot(joint.x, joint.y, joint.couple) > least
    ]
    if blow.joints:
        most = "" if blow.stated else " take up to"
        said += f"; joints{most}: {', '.join(taken)}" if taken else "; no joint takes any"
    return f"{said}; an impulse is no force: its peak is not computed"


def _blow_force(blow: BlowSummary, solved: BlowForceSummary) -> str:
    """A blow whose force is known, in words."""
    often = "" if blow.per_minute is None else f", {number(blow.per_minute)} times a minute"
    depth = f"; pressed in by {number(solved.depth)} mm" if solved.depth > 0.0 else ""
    if depth:
        depth += f", {number(solved.energy * 1e-3)} J left in it"
    gone = f"gone after {number(solved.contact * 1e3)} ms"
    if not isfinite(solved.contact):
        gone = "kept up by the drive"
    leaves = f"rebound at {number(solved.rebound)} mm/s" if solved.rebound else "no rebound"
    joints = ", ".join(
        f"{brief(name, 20)} {number(force)} N" for name, force in solved.joints.items()
    )
    hardest = f"the hardest of {solved.count} touches in a cycle, " if solved.count > 1 else ""
    return (
        f"{hardest}struck at {number(blow.speed)} mm/s{often}: force up to "
        f"{number(solved.peak * 1e-3)} kN, {gone}{depth}; {leaves}; joints in it up to: "
        f"{joints}; it stands in these loads"
    )


def _from_to(pair: tuple[float, float], factor: float = 1.0) -> str:
    """One number where both are the same, else both."""
    low, high = (number(value * factor) for value in pair)
    return low if low == high else f"{low} ... {high}"


def _held(contact: ContactSummary) -> str:
    """Effect of a contact on the motion of the body that it pushes, in words."""
    if contact.most_held <= 0.0:
        return "keeps its acceleration"
    if contact.least_held >= 1.0 - 1e-9:
        return "is held by it: no acceleration along the force"
    return (
        f"follows it: loses up to {100 * contact.most_held:.3g} % of its acceleration along the "
        "force"
    )


def _span(span: ContactSpan, cycle: ShownCycle, length: str) -> str:
    """From where to where a contact pushes, and how fast it is met."""
    start, stop = place_text(span.start), place_text(span.stop)
    begins, ends = brief(span.start_phase, 20), brief(span.stop_phase, 20)
    said = f"from {brief(cycle.shown_name, 20)} = {start} to {stop} {cycle.unit}"
    if span.start_phase != span.stop_phase:
        said = (
            f"from {brief(cycle.shown_name, 20)} = {start} {cycle.unit} in {begins} to {stop} "
            f"{cycle.unit} in {ends}"
        )
    elif len(cycle.phases) > 1:
        said += f" in {begins}"
    if not span.approach_speed:
        return said
    lost = f", which costs {number(span.energy * 1e-3)} J" if span.energy else ""
    return f"{said} (met at {number(span.approach_speed)} {length}/s{lost})"


_FEW = 3  # cycles of one kind of gate that are told one by one in short


@dataclass(frozen=True)
class BrokenGates:
    """Gates of one kind that do not hold, of one cycle or several, in a sentence.

    short          of many cycles their number and the worst alone
    meaning, cure  of the worst of them, as the gate has them
    """

    binding: bool
    sentence: str
    short: str
    meaning: str
    cure: str = ""

    @property
    def told(self) -> str:
        """Meaning of the number, followed by the cure if there is one."""
        return f"{self.meaning}. {self.cure}" if self.cure else self.meaning


def _excess(gate: Gate) -> float:
    """Ratio of a gate's value to its limit; infinite where nothing is allowed."""
    return gate.value / gate.limit if gate.limit else inf


def broken_by_kind(gates: Sequence[Gate]) -> list[BrokenGates]:
    """Validity checks that do not hold, those of one kind in several cycles as one."""
    kinds: dict[tuple[str, bool], list[tuple[str, Gate]]] = {}
    for gate in gates:
        if not gate.holds:
            cycle, _, kind = gate.name.partition(": ")
            kinds.setdefault((kind or gate.name, gate.binding), []).append((cycle, gate))
    result = []
    for (kind, binding), found in kinds.items():
        if len(found) == 1:
            ((_, gate),) = found
            said = gate_sentence(gate)
            result.append(BrokenGates(binding, said, said, gate.meaning, gate.cure))
            continue
        each = ", ".join(f"{cycle} {number(gate.value)}" for cycle, gate in found)
        limits = {number(gate.limit) for _, gate in found}
        limit = f", limit {limits.pop()}" if len(limits) == 1 else ""
        worst, gate = max(found, key=lambda entry: _excess(entry[1]))
        alike = len({gate.told for _, gate in found}) == 1
        meaning = gate.meaning if alike else f"The worst, {worst}: {gate.meaning}"
        said = short = f"{kind}: {each}{limit}"
        if len(found) > _FEW:
            short = f"{kind}: {len(found)} cycles, {worst} {number(gate.value)} the worst{limit}"
        result.append(BrokenGates(binding, said, short, meaning, gate.cure))
    return result


def broken_of(result: DesignResult) -> list[BrokenGates]:
    """Gates that do not hold, those that the verdict depends on first, each kind once."""
    owned = [*result.gates, *(_named(gate, part) for part in result.parts for gate in part.gates)]
    return sorted(broken_by_kind(owned), key=lambda gates: not gates.binding)


def _named(gate: Gate, part: PartResult) -> Gate:
    """A gate of a part with the part in its name."""
    if gate.name.startswith(f"{part.name}: "):
        return gate
    return replace(gate, name=f"{part.name}: {gate.name}")
