"""The speed of the drive: how evenly it runs, and the loads where it does not run at its mean.

Inertia forces go with the square of the speed, and a change of speed has inertia forces of its own.
The rest of the loads does not change, so each doubt is a pair of load histories, solved at its
ends: the slowest and the fastest speed everywhere, and the drive's own acceleration forwards and
backwards.

So is the doubt about friction. A doubt that has a pair needs no validity check: the loads at its
ends are in the bars of every check of the parts.

Solved cycles are shown as people see them: positions, phases and pace in words, drives' limits.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

import loads
from ballesta.machine.solved_cycles import event_figures, summed
from checks.design.data import Cycle, Design
from checks.part.part_loads import shown_name, shown_of, shown_position
from checks.result.verdict import Gate
from checks.result.words import SURGING, UNEVEN, brief, number
from geometry.mesh import FloatArray
from reports.loads_figures import BlowSummary, ContactStated, DriveSummary, MotorFigures, ShownPhase
from reports.loads_summary import ShownCycle, ShownRun

Solved = Mapping[str, loads.CycleLoads]
_FRICTION = 1.0 / 3.0  # of a coefficient: a stated one is known to a third at best
_LARGEST = (
    0.3  # irregularity up to which the energy of the ripple gives it, as the mean speed holds
)
_NOTHING = 1e-6
_STOPS = 2.0  # (fastest - slowest) / mean speed, of which the slowest is 0
EVEN = 0.1  # irregularity that is assumed of a drive of which nothing is stated
_FINE = 5  # digits


def shown_cycle(
    design: Design, cycle: loads.CycleLoads, blows: Sequence[BlowSummary] = ()
) -> ShownCycle:
    """Return a solved cycle with the names and units of its positions and forces."""
    stated = design.cycles[cycle.name]
    name, unit = shown_name(stated)
    return ShownCycle(
        loads=cycle,
        shown_name=name,
        unit=unit,
        shown=shown_position(stated, cycle.positions),
        pace=_pace(stated.run.pace),
        motor=motor_figures(design, cycle),
        event=event_figures(design, cycle),
        duty=design.duty.cycles.get(cycle.name, 0.0),
        phases=_phases(cycle, stated),
        available=design.available,
        allowed_irregularity=design.drive.irregularity or EVEN,
        stated=_contacts(cycle.linkage, stated.run),
        blows=blows,
    )


def shown_run(design: Design, run: loads.MeasuredLoads) -> ShownRun:
    """Return a measured run of a design as people see it."""
    name, unit, shown = shown_of(design, run.name, run)
    return ShownRun(
        loads=run,
        file=design.measured[run.name].file,
        shown_name=name,
        unit=unit,
        shown=shown,
        duty=design.duty.cycles.get(run.name, 0.0),
    )


def _contacts(linkage: loads.Linkage, run: loads.Cycle) -> dict[str, ContactStated]:
    """The contacts as the design has them; a force may have another one in another phase."""
    touched: dict[str, dict[str, list[float]]] = {}
    for phase in run.phases:
        for force, law in phase.given.items():
            if isinstance(law, loads.Contact):
                coordinate, at = _touched(linkage, force, law)
                touched.setdefault(force, {}).setdefault(coordinate, []).append(at)
    return {
        force: ContactStated(coordinate, tuple(dict.fromkeys(places)))
        for force, own in touched.items()
        for coordinate, places in own.items()
    }


def _touched(linkage: loads.Linkage, force: str, law: loads.Contact) -> tuple[str, float]:
    """Coordinate at which a contact touches, as the design states it, without the force's sign."""
    coordinate = linkage.force(force).coordinate
    way = sum(coordinate.direction) if isinstance(coordinate, loads.PointCoordinate) else 1.0
    return coordinate.label.removeprefix("-"), way * law.at


def _phases(cycle: loads.CycleLoads, stated: Cycle) -> tuple[ShownPhase, ...]:
    run = stated.run
    ends = shown_position(stated, np.array(run.spans).ravel()).reshape(-1, 2)
    return tuple(
        ShownPhase(
            phase.name,
            float(start),
            float(stop),
            float(np.ptp(cycle.times[cycle.phase_of == k])),
            phase.solve,
            tuple(_law(cycle.linkage, name, law) for name, law in phase.given.items()),
        )
        for k, (phase, (start, stop)) in enumerate(zip(run.phases, ends.tolist(), strict=True))
    )


def _law(linkage: loads.Linkage, name: str, law: loads.Law) -> str:
    """A given force in words."""
    angular = linkage.force(name).coordinate.angular
    per_1e3, unit = (1e-3, "N m") if angular else (1.0, "N")
    if isinstance(law, loads.Table):
        low, high = min(law.forces) * per_1e3, max(law.forces) * per_1e3
        over = law.coordinate.label
        return f"{name} {number(low, 4)} ... {number(high, 4)} {unit} in a table over {over}"
    if isinstance(law, loads.Expression):
        return f"{name} = {brief(law.text, 200)}"
    if isinstance(law, loads.Contact):
        stiffness = "rigid" if law.stiffness is None else f"{number(law.stiffness, 4)} N/mm"
        coordinate, at = _touched(linkage, name, law)
        return f"{name} touches at {coordinate} = {at:.{_FINE}g} mm ({stiffness})"
    if isinstance(law, loads.Opposing):
        if law.speeds:
            low, high = min(law.forces) * per_1e3, max(law.forces) * per_1e3
            size = f"{number(low, 4)} ... {number(high, 4)} {unit} in a table over its speed"
        else:
            damping = "N m s/rad" if angular else "N s/mm"
            parts = [(law.dry * per_1e3, unit), (law.viscous * per_1e3, damping)]
            size = (
                " and ".join(f"{number(part, 4)} {of}" for part, of in parts if part) or "nothing"
            )
        return f"{name} against the motion, {size}"
    return f"{name} {law * per_1e3:.6g} {unit}"


def _pace(pace: loads.Pace) -> str:
    unit = "rad" if pace.coordinate.angular else "mm"
    if isinstance(pace, loads.StrokePace):
        rest = f"from rest to rest in {number(pace.time)} s a stroke"
        return f"{pace.coordinate.label} {pace.law} {rest}"
    if isinstance(pace, loads.MotorPace):
        return f"{pace.coordinate.label} by drive.motor"
    if isinstance(pace, loads.RunPace):
        return f"{pace.coordinate.label} as it starts or stops"
    rising = f", changing by {pace.acceleration:.4g} {unit}/s2" if pace.acceleration else ""
    if pace.falling is not None:
        rising = f" as it grows, {pace.falling:.4g} {unit}/s as it falls"
    if pace.cushion:
        rising += f", braked to rest along the last {pace.cushion:g} mm of a stroke"
    return f"{pace.coordinate.label} at {pace.speed:.4g} {unit}/s{rising}"


# Speed, torque and energy of a motor over a cycle.


def motor_figures(design: Design, cycle: loads.CycleLoads) -> MotorFigures | None:
    """Return the figures of a cycle that a motor turns; None for any other."""
    stated = design.cycles[cycle.name]
    pace = stated.run.pace
    if not isinstance(pace, loads.MotorPace):
        return None
    geared = pace.motor
    drive = stated.run.phases[0].solve

    def torques(speeds: FloatArray) -> FloatArray:
        return np.array([geared.torque(float(value))[0] for value in speeds])

    at_all = np.abs(cycle.rate(drive))
    cycle = cycle.unstruck or cycle  # in a blow the pose stays or goes by steps
    speed = np.abs(cycle.rate(drive))
    own = np.array([geared.motor.torque(float(value) * geared.ratio)[0] for value in speed])
    shown = shown_position(stated, cycle.positions)
    slowest, fastest = int(speed.argmin()), int(speed.argmax())
    duration = float(cycle.times[-1])
    return MotorFigures(
        slowest=float(speed[slowest]),
        slowest_at=float(shown[slowest]),
        fastest=float(speed[fastest]),
        fastest_at=float(shown[fastest]),
        mean=summed(cycle, speed, cycle.times) / duration,
        largest=float(np.abs(own).max()),
        effective=float(np.sqrt(summed(cycle, own**2, cycle.times) / duration)),
        rated=geared.motor.rated_torque,
        power=summed(cycle, own * speed * geared.ratio, cycle.times) / duration,
        ratio=geared.ratio,
        missing=_missing(cycle, drive, torques(speed) * speed),
        speed=at_all,
        torque=torques(at_all),
    )


def _missing(cycle: loads.CycleLoads, drive: str, power: FloatArray) -> float:
    """Energy balance error of a turn: motor less drive, over the energy the drive turns over."""
    sign = cycle.linkage.force(drive).sign
    taken = sign * cycle.efforts[drive] * cycle.rate(drive)
    whole = summed(cycle, np.abs(taken), cycle.times)
    return abs(summed(cycle, power - taken, cycle.times)) / whole if whole else 0.0


@dataclass(frozen=True, eq=False)
class LoadPair:
    """A doubt about the loads, by the cycles at its two ends.

    gates  names of the validity checks that the pair takes the place of
    """

    words: str
    ends: tuple[Solved, Solved]
    gates: tuple[str, ...] = ()


@dataclass(frozen=True)
class Evenness:
    """Speed fluctuation of a drive over a cycle.

    drive          name of its force
    irregularity   (fastest - slowest) / mean speed, as stated, computed or assumed
    alone          the same by the inertia of the bodies and the stated flywheel; None without any
    needed         t mm2 in all, on the driven coordinate, for `EVEN`
    present        t mm2 of the bodies on the driven coordinate, in the mean
    source         where `irregularity` is from, in words
    assumed        whether nothing states it
    """

    drive: str
    irregularity: float
    alone: float
    needed: float
    present: float
    source: str
    assumed: bool


def evenness_of(design: Design, solved: Solved) -> dict[str, Evenness]:
    """Evenness of every closed cycle that a torque turns at one speed; others have none.

    Nor those that a motor turns: their loads are those of the speed that it has.
    """
    found: dict[str, Evenness] = {}
    if design.drive.motor is not None:
        return found
    for name, cycle in solved.items():
        for drive in _turned(design, cycle):
            found[name] = _evenness(design, cycle, drive)
            break
    return found


def _turned(design: Design, cycle: loads.CycleLoads) -> Iterator[DriveSummary]:
    shown = shown_cycle(design, cycle)
    for drive in shown.drives:
        if drive.irregularity is not None and shown.role(drive.name) == "solved":
            yield drive


def _evenness(design: Design, cycle: loads.CycleLoads, drive: DriveSummary) -> Evenness:
    stated = design.drive
    figures = cycle.drive(drive.name)
    assert figures.energy_ripple is not None
    present = figures.mean_reduced_mass
    whole = present + (stated.flywheel or 0.0)
    alone = figures.energy_ripple / (whole * figures.speed**2)
    needed = figures.energy_ripple / (EVEN * figures.speed**2)
    if stated.control is not None:
        found, source = 0.0, f'drive.control = "{stated.control}"'
    elif stated.irregularity is not None:
        found, source = stated.irregularity, "drive.irregularity as stated"
    elif stated.flywheel is not None:
        found = alone
        source = f"by the torque's ripple on drive.flywheel and bodies, {_inertia(whole)}"
    elif alone <= EVEN:
        found, source = alone, f"by the torque's ripple on the bodies alone, {_inertia(whole)}"
    else:
        found, source = EVEN, "assumed"
    assumed = source == "assumed"
    return Evenness(drive.name, found, alone, needed, present, source, assumed)


def _inertia(value: float) -> str:
    return f"{number(value * 1e-3)} kg m2"


def speed_gates(found: Mapping[str, Evenness]) -> list[Gate]:
    """One gate for every cycle whose stated flywheel is too light for its mean speed to count."""
    return [
        Gate(
            f"{name}: speed irregularity of {even.drive}",
            even.irregularity,
            _LARGEST,
            f"(fastest - slowest) / mean speed {even.source}; beyond the limit the speed is no "
            "mean with a bar",
            cure=f"drive.flywheel = {number((even.needed - even.present) * 1e-3)} kg m2 brings it "
            f'to {EVEN:g}; or drive.control = "constant", or drive.irregularity, where the drive '
            "itself holds its speed",
            key=f'drive.flywheel="{number((even.needed - even.present) * 1e-3)} kg m2"',
        )
        for name, even in found.items()
        if not even.irregularity <= _LARGEST
    ]


def speed_warnings(found: Mapping[str, Evenness]) -> list[str]:
    """Warn of drives whose speed fluctuation is assumed, with the keys that state it."""
    silent = {name: even for name, even in found.items() if even.assumed}
    if not silent:
        return []
    name, worst = max(silent.items(), key=lambda entry: entry[1].alone)
    more = len(silent) - 1
    others = f" and {more} more cycle{'s' if more > 1 else ''}" if more else ""
    alone = "stop it" if worst.alone >= _STOPS else f"let it vary by {number(100 * worst.alone)} %"
    return [
        f"{name}{others}: {worst.drive} is ASSUMED to keep within {100 * EVEN:g} % of its "
        f"mean speed. Its mean torque with what it turns as flywheel would {alone}. "
        'State drive.control = "constant" (a servo, a motor far stronger than the '
        f"machine), drive.flywheel ({number((worst.needed - worst.present) * 1e-3)} kg m2 gives "
        f"{EVEN:g}) or drive.irregularity"
    ]


def speed_assumptions(found: Mapping[str, Evenness]) -> list[tuple[str, str]]:
    """The assumption, key and reason, for drives whose control the design does not state."""
    reason = (
        f"none is stated: irregularity of the speed {EVEN:g}, in the error bars of every check by "
        "the loads of the slowest and the fastest speed and of the changes between them"
    )
    return [("drive", reason)] if any(even.assumed for even in found.values()) else []


def speed_doubts(design: Design, solved: Solved, found: Mapping[str, Evenness]) -> list[LoadPair]:
    """The loads that the cycles may have as their drive does not run at one speed.

    None of a drive that would stop: it has no slowest speed, and its gate does not hold.
    """
    uneven = {name: even for name, even in found.items() if _NOTHING < even.irregularity < _STOPS}
    if not uneven:
        return []
    most = max(even.irregularity for even in uneven.values())
    half = 0.5 * most

    def ends(sign: float, *, surging: bool) -> dict[str, loads.CycleLoads]:
        again = dict(solved)
        for name, even in uneven.items():
            cycle, share = solved[name], sign * even.irregularity
            surge = share * _surge(cycle, even.drive) if surging else None
            factor = 1.0 if surging else 1.0 + 0.5 * share
            stated = design.cycles[name].run
            again[name] = loads.run_at_rates(cycle, stated, factor, surge)
        return again

    return [
        LoadPair(
            f"speed up to {100 * half:.2g} % {UNEVEN}",
            (ends(-1.0, surging=False), ends(1.0, surging=False)),
        ),
        LoadPair(
            SURGING,
            (ends(-1.0, surging=True), ends(1.0, surging=True)),
        ),
    ]


def _surge(cycle: loads.CycleLoads, drive: str) -> FloatArray:
    """Acceleration of the drive over its speed (n,) [1/s] and over the irregularity.

    A mass J that is turned by the mean of the torque accelerates by (mean - T) / J, and its
    irregularity is ripple / (J w^2): so w^2 (mean - T) / ripple for an irregularity of 1.
    """
    figures = cycle.drive(drive)
    ripple = figures.energy_ripple
    if not ripple:
        return np.zeros(len(cycle.positions))
    value = cycle.coordinate(drive)
    push = cycle.linkage.force(drive).sign * cycle.efforts[drive]
    way = float(value[-1] - value[0])
    return np.asarray(np.sign(way) * figures.speed * (figures.work / way - push) / ripple)


def friction_gate(cycle: str) -> str:
    """Name of the validity check of a cycle's friction."""
    return f"{cycle}: share of friction"


def friction_pairs(design: Design, solved: Solved) -> tuple[list[LoadPair], list[Gate]]:
    """The loads of all cycles with friction a third lower and a third higher than stated.

    All coefficients go the same way, in all cycles. Where no loads balance the higher ones
    (self-locking), no bar tells anything: a validity check that does not hold stands for that
    cycle.
    """
    lower, higher, gates = dict[str, loads.CycleLoads](), dict[str, loads.CycleLoads](), []
    for name, cycle in solved.items():
        if not any(one.coefficient for one in cycle.linkage.friction.values()):
            continue
        run = design.cycles[name].run
        try:
            low, high = (
                loads.run_cycle(_with_friction(cycle.linkage, factor), run)
                for factor in (1.0 - _FRICTION, 1.0 + _FRICTION)
            )
        except loads.LinkageError as error:
            gates.append(_unbalanced(name, str(error)))
            continue
        lower[name], higher[name] = low, high
    if not lower:
        return [], gates
    words = f"{', '.join(lower)}: coefficients of friction a third lower or higher"
    ends = ({**solved, **lower}, {**solved, **higher})
    return [LoadPair(words, ends, tuple(map(friction_gate, lower)))], gates


def _with_friction(linkage: loads.Linkage, factor: float) -> loads.Linkage:
    scaled = {
        joint: replace(one, coefficient=factor * one.coefficient)
        for joint, one in linkage.friction.items()
    }
    return replace(linkage, friction=scaled)


def _unbalanced(cycle: str, problem: str) -> Gate:
    return Gate(
        f"{cycle}: friction a third from its stated coefficients",
        1.0,
        0.0,
        "cycles that cannot be solved there, and a coefficient of friction is known to a third at "
        f"best: {problem}",
        cure="Less friction, or a mechanism farther from self-locking",
    )
