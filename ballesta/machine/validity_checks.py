"""Validity checks of loads: of a cycle, of a duty without end, and of its drive's capacity."""

from collections.abc import Collection, Iterator, Mapping
from math import ceil, sqrt

import numpy as np

import loads
from ballesta.machine.drive_speed import friction_gate, motor_figures, shown_cycle
from ballesta.machine.solved_cycles import event_figures
from checks.design.data import Cycle, Design, Part
from checks.part.part_loads import Runs, shown_name, shown_position
from checks.result.verdict import Gate
from checks.result.words import number
from fatigue import count_closed_cycles
from geometry.mesh import FloatArray
from reports.loads_words import event_sentence

_GAP = 1e-6  # mm
_RESIDUAL = 1e-9  # of the largest force, or of the power turned over
_RESIDUAL_WITH_FRICTION = 1e-6
_UNRESOLVED = 0.01  # share of the largest load that may lie between positions
_SECOND_ORDER = 0.05  # share of the largest force
_AT_END = 1e-9  # of the travel
_SENSITIVE = 0.13  # of the largest load: a toggle of two bars of 250 mm at 1.7 deg
_FRICTION_SHARE = 0.3  # a coefficient is known to a third at best: the efforts then to 10 %
_MOTOR_ENERGY = 1e-3  # the trapezoidal rule over some hundred positions
_KNEE = 1e6  # cycles, of metals with an endurance limit
_LARGE = 0.5  # of the largest cycle: smaller ones do less than a hundredth of its damage
_PAST_PIN = 0.05  # share of a pin's force that its bore lacks
_USED_TRAVEL = 0.98  # of a slot's length: closer than 1 % of it to an end, play lets it strike


def load_gates(
    design: Design, solved: Mapping[str, loads.CycleLoads], covered: Collection[str] = ()
) -> list[Gate]:
    """Every gate of the loads, cycle by cycle.

    covered  names of gates whose doubt is in the bars, by a pair of load histories
    """
    return [
        gate
        for name, cycle in solved.items()
        for gate in _cycle_gates(design, name, cycle, covered)
    ]


def endless_gates(design: Design, runs: Runs) -> Iterator[Gate]:
    """Gates for metals without an endurance limit whose duty goes on beyond their tests.

    A ratio at 1e6 cycles belongs to a metal with a limit, or to the end of the FKM guideline's
    curve; one at more is where tests of rotating bars were stopped.
    """
    for part in design.parts.values() if design.duty.life == "infinite" else ():
        metal = part.material
        if part.fkm is not None or metal.endurance_ratio is None or metal.endurance_cycles <= _KNEE:
            continue
        cycles = sum(
            often * _load_cycles(part, runs[name])
            for name, often in design.duty.cycles.items()
            if name in runs
        )
        if cycles > metal.endurance_cycles:
            yield Gate(
                f"{part.name}: cycles of an endless life",
                cycles / metal.endurance_cycles,
                1.0,
                f"{number(cycles)} cycles of the duty over the {metal.endurance_cycles:g} "
                f"that {metal.name} endures its endurance ratio: it has no endurance limit, "
                "and strength falls on beyond",
                cure='State duty.life = "finite", which follows its S-N curve there',
                key="duty.life=finite",
            )


def _load_cycles(part: Part, run: loads.CycleLoads | loads.MeasuredLoads) -> float:
    """Cycles of a part's loads in a run that are at least half as large as the largest; 1 or more.

    In the part's own axes, in which a steady force swings as the part turns; couples count by the
    force that they are on the part's length. A measured run may be hours of work.
    """
    bodies = [part.body] if part.body else [lug.body for lug in part.stack]
    angles = _angles(run)
    frame = np.exp(-1j * angles.get(part.body or part.fixed_to or "", np.zeros(1)))
    acting = [
        axis
        for body in bodies
        if body in angles
        for load in run.body_loads(str(body))
        for force in ((load.force @ [1.0, 1j]) * frame,)
        for axis in (force.real, force.imag, load.moment / part.geometry.length)
    ]
    counted = [count_closed_cycles(force) for force in acting]
    least = _LARGE * max((own.stress_amplitude[0] for own in counted), default=0.0)
    large = (own.cycle_counts[own.stress_amplitude >= least].sum() for own in counted)
    return float(max(large, default=1.0)) if least else 1.0


def _angles(run: loads.CycleLoads | loads.MeasuredLoads) -> dict[str, FloatArray]:
    """Angles (n,) rad of the bodies of a run."""
    if isinstance(run, loads.MeasuredLoads):
        return {name: body.angle for name, body in run.bodies.items()}
    return {name: run.poses[:, run.body_index(name), 2] for name in run.linkage.body_names}


def dead_centre_gate(cycle: str) -> str:
    """Name of the gate of a cycle that comes near to a dead centre."""
    return f"{cycle}: nearness to a dead centre"


def sensitivity_of(stated: Cycle, cycle: loads.CycleLoads) -> loads.Sensitivity:
    """Change of the loads of a cycle by lengths and position.

    A stop states how far off the end of the travel is, as built. Elsewhere the swept coordinate is
    where the cycle has it, and what lengths do to the pose there counts, too.
    """
    held = cycle.sensitivity
    ends = stated.stop is not None and _is_farthest(cycle, held.at)
    return cycle.shape_sensitivity if ends else held


def _is_farthest(cycle: loads.CycleLoads, at: float) -> bool:
    """True where a position is the end of the travel, at which a stop is."""
    way = np.abs(cycle.positions - cycle.positions[0])
    return bool(way.max() - abs(at - cycle.positions[0]) <= _AT_END * way.max())


def is_near_dead_centre(stated: Cycle, cycle: loads.CycleLoads) -> bool:
    """True where general tolerances of lengths and position change the loads by much."""
    return sensitivity_of(stated, cycle).most > _SENSITIVE


def _cycle_gates(
    design: Design, name: str, cycle: loads.CycleLoads, covered: Collection[str]
) -> list[Gate]:
    return [
        *_numerical(name, cycle),
        _positions(design, name, cycle),
        _dead_centre(design, name, cycle, dead_centre_gate(name) in covered),
        *_friction(name, cycle, friction_gate(name) in covered),
        *_deflected_shape(name, cycle),
        *_slot_ends(name, cycle),
        *_past_pins(design, name, cycle),
        *_drive_forces(design, name, cycle),
        *_cycle_time(design, name, cycle),
        *_motor(design, name, cycle),
        *_event(design, name, cycle),
    ]


def _numerical(name: str, cycle: loads.CycleLoads) -> list[Gate]:
    frictionless = not cycle.linkage.friction
    return [
        Gate(
            f"{name}: joints closed",
            cycle.constraint_residual,
            _GAP,
            "widest gap of a joint at any position, mm",
        ),
        Gate(
            f"{name}: equilibrium of the bodies",
            max(cycle.equilibrium_residual.values()),
            _RESIDUAL,
            "force and moment left on a body over the largest force",
        ),
        Gate(
            f"{name}: power balance",
            cycle.power_balance_error,
            _RESIDUAL if frictionless else _RESIDUAL_WITH_FRICTION,
            "power that is not accounted for, over the power turned over",
        ),
    ]


def _positions(design: Design, name: str, cycle: loads.CycleLoads) -> Gate:
    """Gate for peaks between the positions: the part missed falls with their number squared."""
    missed, count = cycle.unresolved, len(cycle.positions)
    meaning = (
        "how far loads rise between the positions of the cycle, over the largest of their kind, "
        "as the same cycle has them at other positions"
    )
    cure = key = ""
    if missed.share > _UNRESOLVED:
        enough = ceil(count * sqrt(missed.share / _UNRESOLVED) / 10) * 10
        meaning += f": {count} positions are too few, peaks are missed (most: {missed.what})"
        cure = f"State positions = {enough} or more, or leave it out"
        table = "cycles" if design.cycles[name].event is None else "events"
        key = f"{table}.{name}.positions={enough}"
    gate = f"{name}: loads between the positions"
    return Gate(gate, missed.share, _UNRESOLVED, meaning, cure=cure, key=key)


def _dead_centre(design: Design, name: str, cycle: loads.CycleLoads, doubted: bool) -> Gate:
    """Gate of what lengths and position leave open: the shift of a dead centre over its distance.

    The ratio of a transmission is none of it: a cutter of 1 to 200 may be far from its dead centre.
    """
    stated = design.cycles[name]
    sensitivity = sensitivity_of(stated, cycle)
    at = sensitivity.at
    shown, unit = shown_name(stated)
    place = f"{shown} = {shown_position(stated, np.array([at]))[0]:.4g} {unit}"
    cure = f"Keep the travel farther from {place}"
    if _is_farthest(cycle, at):
        stop = f"cycles.{name}.stop.tolerance"
        if stated.stop is None:
            stop = f'cycles.{name}.stop={{basis="mechanical", tolerance="0.1 {unit}"}}, say'
        cure += (
            f", or state {stop}, so that the loads at both ends of it are in the error bars, where "
            "that does not reach the dead centre"
        )
    return Gate(
        dead_centre_gate(name),
        sensitivity.most,
        _SENSITIVE,
        "change of the loads, over the largest, if lengths between pins and the position are off "
        "by the general tolerances of ISO 2768-1 m, each at its worst and added: it grows without "
        f"bound towards a dead centre or change point; most at {place}"
        + (": the loads at both ends are in the error bars" if doubted else ""),
        binding=not doubted,
        cure="" if doubted or not is_near_dead_centre(stated, cycle) else cure,
    )


def _motor(design: Design, name: str, cycle: loads.CycleLoads) -> list[Gate]:
    motor = motor_figures(design, cycle)
    if motor is None:
        return []
    said = "energy of a turn that motor and linkage do not agree on, over what is turned over"
    energy = _energy(cycle, f"cycles.{name}", f"{name}: energy of the motor", motor.missing, said)
    if motor.effective <= motor.rated:
        return [energy]
    heat = Gate(
        f"{name}: effective torque of the motor",
        motor.effective / motor.rated,
        1.0,
        "root mean square of its torque over the rated one: beyond the limit it gets too hot, "
        "which changes no load",
        binding=False,
        cure="A larger drive.motor.power, or less load",
    )
    return [energy, heat]


def _event(design: Design, name: str, cycle: loads.CycleLoads) -> list[Gate]:
    event = event_figures(design, cycle)
    if event is None:
        return []
    said = (
        "energy that motor, brake, flywheel and linkage do not agree on, over what is turned "
        f"over; {event_sentence(event)}"
    )
    gate = f"{name}: energy of the {event.kind}"
    return [_energy(cycle, f"events.{name}", gate, event.missing, said)]


def _energy(cycle: loads.CycleLoads, key: str, gate: str, missing: float, meaning: str) -> Gate:
    """Gate of a sum of energy over the positions of a cycle, with the number that is enough."""
    if missing <= _MOTOR_ENERGY:
        return Gate(gate, missing, _MOTOR_ENERGY, meaning)
    enough = ceil(len(cycle.positions) * sqrt(missing / _MOTOR_ENERGY) * 1.2 / 10) * 10
    cure = f"State positions = {enough} or more: the sum over them is too coarse"
    return Gate(gate, missing, _MOTOR_ENERGY, meaning, cure=cure, key=f"{key}.positions={enough}")


def _deflected_shape(name: str, cycle: loads.CycleLoads) -> list[Gate]:
    if not cycle.touches or not cycle.linkage.compliance:
        return []
    return [
        Gate(
            f"{name}: forces in the deflected shape",
            cycle.second_order,
            _SECOND_ORDER,
            "how much drive and joint forces change when they are solved again in the shape that "
            "they bend the linkage to; beyond the limit it is too soft for small deflections",
        )
    ]


def _friction(name: str, cycle: loads.CycleLoads, covered: bool) -> list[Gate]:
    if not cycle.linkage.friction:
        return []
    return [
        Gate(
            friction_gate(name),
            cycle.friction_share,
            _FRICTION_SHARE,
            "work that friction takes over the work turned over; beyond the limit the loads are as "
            "uncertain as the coefficients of friction"
            + (": those a third lower and higher are in the error bars" if covered else ""),
            binding=not covered,
        )
    ]


def _slot_ends(name: str, cycle: loads.CycleLoads) -> list[Gate]:
    gates = []
    for joint, margin in cycle.slot_margin.items():
        ends = cycle.linkage.joint(joint)
        assert isinstance(ends, loads.Slot | loads.Prismatic)
        assert ends.ends is not None
        low, high = ends.ends
        gates.append(
            Gate(
                f"{name}: travel in {joint}",
                1.0 - 2.0 * margin / (high - low),
                _USED_TRAVEL,
                f"share of the length between its ends that is used about the middle; "
                f"{number(margin)} mm are left to the nearer end, beyond the limit play and wear "
                "let it strike there, which is not in the loads",
            )
        )
    return gates


def _past_pins(design: Design, name: str, cycle: loads.CycleLoads) -> Iterator[Gate]:
    """Gates for bores at whose point more acts on the body than what comes through the pin.

    A part has the sum of both in its bore, as nothing says where else guides and forces enter it.
    Contacts on one of its own faces are none of that.
    """
    through = {
        (pin.joint, seat.force) for pin in design.parts.values() for seat in pin.stack if seat.force
    }
    slides = design.slides
    for part in design.parts.values():
        faces = {f"joint {slides[at].name!r}" for at in part.interfaces.values() if at in slides}
        for interface, point in part.interfaces.items() if part.body else ():
            every = [one for one in cycle.body_loads(str(part.body)) if one.point == point]
            acting = [one for one in every if one.source not in faces]
            own = [one for one in acting if _through_pin(cycle, one.source, point, through)]
            pinned = any(
                isinstance(joint, loads.Revolute) and f"joint {joint.name!r}" == one.source
                for joint in cycle.linkage.joints
                for one in own
            )
            if not pinned or len(own) == len(acting):
                continue
            kinds = {one.name: one.kind for one in part.geometry.placed_interfaces}
            if kinds[interface] not in ("bore", "journal"):
                continue
            pin, whole = (
                np.hypot(*np.sum([one.force for one in some], axis=0).T) for some in (own, acting)
            )
            hands_on = {one.source for one in own}
            beside = ", ".join(one.source for one in acting if one.source not in hands_on)
            yield Gate(
                f"{name}: pin in {interface} of {part.name}",
                float((pin - whole).max() / (pin.max() or 1.0)),
                _PAST_PIN,
                f"share of the pin's force that the bore lacks: past the pin {beside} acts on "
                f"{part.body} at the same point, and the part has the sum of all in its bore",
                cure=f"Let {beside} act at another point of {part.body}, an interface of its part "
                "(of a guide: the first of the body's pins); name a force whose eye is on the pin "
                "in the stack of that pin",
            )


def _through_pin(
    cycle: loads.CycleLoads, source: str, point: str, through: Collection[tuple[str | None, str]]
) -> bool:
    """True for what a pin at a point hands on: joints but guides, and forces with an eye there.

    through  joint and force of eyes in stated stacks
    """
    for joint in cycle.linkage.joints:
        if f"joint {joint.name!r}" == source:
            return not isinstance(joint, loads.Prismatic)
    for force in cycle.linkage.forces:
        if f"force {force.name!r}" == source:
            between = isinstance(force.coordinate, loads.Distance)
            return between or (point, force.name) in through
    return True


def _drive_forces(design: Design, name: str, cycle: loads.CycleLoads) -> list[Gate]:
    shown = shown_cycle(design, cycle)
    return [
        Gate(
            f"{name}: {force}, {direction.words}",
            direction.needed / direction.available,
            1.0,
            f"largest effort of the drive over what is available in this direction, at "
            f"{shown.shown_name} = {direction.at:.4g} {shown.unit}; the drive cannot do its work "
            "beyond the limit",
            binding=False,
        )
        for force in shown.available
        for direction in shown.directions(force)
        if direction.available is not None
    ]


def _cycle_time(design: Design, name: str, cycle: loads.CycleLoads) -> list[Gate]:
    event = design.cycles[name].event is not None  # has no part in the rate
    if design.duty.rate is None or name not in design.duty.cycles or event:
        return []
    allowed = 1.0 / design.duty.rate
    return [
        Gate(
            f"{name}: time of a cycle",
            round(float(cycle.times[-1]) / allowed, 9),  # a machine may run just as often
            1.0,
            f"one cycle takes {number(cycle.times[-1])} s, the duty of "
            f"{60 * design.duty.rate:.4g} 1/min allows {number(allowed)} s",
            binding=False,
        )
    ]
