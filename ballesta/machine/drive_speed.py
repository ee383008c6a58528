"""The speed of the drive: how evenly it runs, and the loads where it does not run at its mean.

Inertia forces go with the square of the speed, and a change of speed has inertia forces of its own.
The rest of the loads does not change, so each doubt is a pair of load histories, solved at its
ends: the slowest and the fastest speed everywhere, and the drive's own acceleration forwards and
backwards.

So is the doubt about friction. A doubt that has a pair needs no validity check: the loads at its
ends are in the bars of every check of the parts.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

import loads
from ballesta.machine.shown_loads import EVEN, shown_cycle
from checks.design.data import Design
from checks.result.verdict import Gate
from checks.result.words import SURGING, UNEVEN, number
from geometry.mesh import FloatArray
from reports.loads_figures import DriveSummary

Solved = Mapping[str, loads.CycleLoads]
_FRICTION = 1.0 / 3.0  # of a coefficient: a stated one is known to a third at best
_LARGEST = (
    0.3  # irregularity up to which the energy of the ripple gives it, as the mean speed holds
)
_NOTHING = 1e-6
_STOPS = 2.0  # (fastest - slowest) / mean speed, of which the slowest is 0


@dataclass(frozen=True, eq=False)
class LoadPair:
    """A doubt about the loads, by the cycles at its two ends.

    gate  name of the validity check that the pair takes the place of; empty for none
    """

    words: str
    ends: tuple[Solved, Solved]
    gate: str = ""


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
    """The loads of every cycle with friction a third lower and a third higher than stated.

    All coefficients go the same way. Where no loads balance the higher ones (self-locking), no bar
    tells anything: a validity check that does not hold stands for that cycle.
    """
    pairs, gates = [], []
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
        words = f"{name}: coefficients of friction a third lower or higher"
        ends = ({**solved, name: low}, {**solved, name: high})
        pairs.append(LoadPair(words, ends, friction_gate(name)))
    return pairs, gates


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
