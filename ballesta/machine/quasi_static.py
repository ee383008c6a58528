"""Quasi-static loads: the linkage's natural frequencies against the harmonics of its loads."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import acos, ceil, cos, inf, pi

import numpy as np

import loads
from checks.design.data import Design, Part
from checks.part.part_loads import shown_name, shown_position
from checks.result.verdict import Gate
from checks.result.words import number
from loads.harmonics import (
    CycleResponse,
    Harmonic,
    ModeResponse,
    cycle_response,
    with_vibration,
)
from loads.vibration import closes, cycle_modes

VALID = 1.05  # largest response with vibration over that without, which needs no word
_LIMIT = 1.2
_APPLIED = "dynamics.apply=true"
_SHARE = 0.05  # of the linkage's deformation: modes below it count by their share only
_TOLD_SUM = 1.01  # over the worst deviation: less is not told to be a sum
_LOST = 0.05  # of the largest deformation: waves of vibration between the positions
_MOST_POSITIONS = 20_000  # of a cycle
_PLACES = 12  # positions whose frequencies are told
_ON_AXIS = 1e-2  # of a body's length


@dataclass(frozen=True, eq=False)
class CycleVibration:
    """Natural frequencies of a cycle and its response to the loads.

    positions    (m,)    as shown, of the frequencies told; unit and name as shown
    frequencies  (m, 3)  Hz, the lowest ones, the drive held; infinite where there are fewer
    response     None where the cycle has no harmonics, `unasked` then says why
    contact      True where a contact counts as a load
    sections     (body, section) that give way by the section of their part
    rigid        bodies taken as rigid, with the reason where they have a part
    """

    cycle: str
    shown: tuple[str, str]
    positions: np.typing.NDArray[np.float64]
    frequencies: np.typing.NDArray[np.float64]
    response: CycleResponse | None
    unasked: str
    contact: bool
    sections: tuple[tuple[str, str], ...]
    rigid: tuple[str, ...]

    @property
    def telling(self) -> tuple[ModeResponse, ...]:
        """Modes that carry a share of the linkage's deformation worth judging."""
        if self.response is None:
            return ()
        return tuple(mode for mode in self.response.responses if mode.share >= _SHARE)

    @property
    def worst(self) -> ModeResponse | None:
        """The telling mode that differs most, or the one that adds most to a `summed` above it."""
        if self.response is None:
            return None
        own = max(self.telling, key=lambda mode: mode.deviation, default=None)
        if own is not None and own.deviation >= self.summed:
            return own
        return max(self.response.responses, key=_counted, default=None)

    @property
    def summed(self) -> float:
        """Deviations of all modes, each times its share of the linkage's deformation."""
        return 0.0 if self.response is None else sum(map(_counted, self.response.responses))

    @property
    def deviation(self) -> float:
        """Error of loads that ignore vibration.

        The deviation of the worst telling mode, or `summed` where that is more: in resonance a
        mode of little share can deform as much as all the others.
        """
        return max([self.summed, *(mode.deviation for mode in self.telling)])


def _counted(mode: ModeResponse) -> float:
    return mode.share * mode.deviation


def vibration_of(
    design: Design, solved: Mapping[str, loads.CycleLoads]
) -> dict[str, CycleVibration]:
    """Return the vibration of every cycle in which an elastic body moves.

    Where its modes cannot be followed through a cycle, `unasked` says so.
    Bodies without stated elasticity give way by the least section of their part, all along it.
    """
    result = {}
    for name, cycle in solved.items():
        elastic, sections, rigid = with_sections(design, cycle)
        masses = any(body.mass or body.inertia for body in elastic.linkage.moving)
        if elastic.linkage.compliance and masses:
            result[name] = _vibration(design, name, elastic, sections, rigid)
    return result


def _vibration(
    design: Design,
    name: str,
    cycle: loads.CycleLoads,
    sections: tuple[tuple[str, str], ...],
    rigid: tuple[str, ...],
) -> CycleVibration:
    even = np.linspace(cycle.times[0], cycle.times[-1], _PLACES + 1)[:_PLACES]
    chosen = np.unique(np.searchsorted(cycle.times, even))
    response, unasked = None, ""
    if design.cycles[name].event is not None:
        unasked = "it is a start or stop, which has no speed to compare with"
        lowest = cycle_modes(cycle, chosen).frequencies[:, :3]
    elif closes(cycle):
        modes = cycle_modes(cycle)
        lowest = modes.frequencies[chosen, :3]
        dynamics = design.dynamics
        try:
            response = cycle_response(cycle, dynamics.damping, dynamics.rise, modes)
        except loads.LinkageError as error:
            unasked = f"{error}; more positions may help"
    else:
        unasked = "it does not end where it starts, so it has no speed to compare with"
        lowest = cycle_modes(cycle, chosen).frequencies[:, :3]
    stated = design.cycles[name]
    found = np.full((len(chosen), 3), np.inf)
    found[:, : lowest.shape[1]] = lowest
    return CycleVibration(
        name,
        shown_name(stated),
        shown_position(stated, cycle.positions)[chosen],
        found,
        response,
        unasked,
        bool(cycle.touches),
        sections,
        rigid,
    )


def with_sections(
    design: Design, cycle: loads.CycleLoads
) -> tuple[loads.CycleLoads, tuple[tuple[str, str], ...], tuple[str, ...]]:
    """Return the cycle with every body elastic that can be, what was taken for it, and what is not.

    Stated elasticity stays. A body with a part gets the least E I and E A of its sections.
    """
    linkage = cycle.linkage
    known = {c.body for c in linkage.compliance if not isinstance(c, loads.JointCompliance)}
    added, sections, rigid = [], [], []
    for body in design.bodies:
        if body in known:
            continue
        part = design.part_of(body)
        if part is None:
            rigid.append(body)
            continue
        found = _stiffness(part)
        if found is None:
            rigid.append(f"{body} (shape {part.shape} has no section all along it)")
        elif not _beam_like(linkage, body):
            rigid.append(f"{body} (loaded beside its x axis, or at no stated point)")
        else:
            bending, area, words = found
            added.append(loads.BeamCompliance(body, bending, area))
            sections.append((body, words))
    elastic = replace(linkage, compliance=(*linkage.compliance, *added))
    return replace(cycle, linkage=elastic), tuple(sections), tuple(rigid)


def _stiffness(part: Part) -> tuple[float, float, str] | None:
    """Return E I in plane [N mm2], E A [N] and the section's name; None for a shape without."""
    young, known = part.material.youngs_modulus, part.geometry.bending
    return None if known is None else (young * known[0], young * known[1], known[2])


def _beam_like(linkage: loads.Linkage, name: str) -> bool:
    """True if all that acts on a body acts on its x axis, at stated points."""
    body = linkage.body(name)
    points, directions = [], []
    for joint in linkage.joints:
        if name == joint.body_a:
            points.append(joint.point_a)
            if isinstance(joint, loads.Slot | loads.Prismatic):
                directions.append(joint.direction)
        elif name == joint.body_b:
            points.append(joint.point_b)
    for force in linkage.forces:
        coordinate = force.coordinate
        if isinstance(coordinate, loads.Angle):
            if name in coordinate.bodies:
                if coordinate.point not in body.points:
                    return False
                points.append(str(coordinate.point))
        elif isinstance(coordinate, loads.Distance):
            ends = (coordinate.body_a, coordinate.point_a), (coordinate.body_b, coordinate.point_b)
            points += [point for owner, point in ends if owner == name]
        elif coordinate.body == name:
            points.append(coordinate.point)
    places = np.array([body.place(point) for point in points])
    length = float(np.ptp(places[:, 0]))
    straight = all(abs(y) <= 1e-6 * float(np.hypot(x, y)) for x, y in directions)
    return straight and bool(np.abs(places[:, 1]).max() <= _ON_AXIS * length)


def quasi_static_gates(design: Design, found: Mapping[str, CycleVibration]) -> list[Gate]:
    """One gate for every cycle whose speed is known: how far off the loads are that ignore it."""
    gates = []
    for name, vibration in found.items():
        worst = vibration.worst
        if worst is None:
            continue
        applied = design.dynamics.apply and not vibration.contact
        response = vibration.response
        followed = (
            None
            if vibration.contact or response is None or not response.responses
            else _followed_gate(name, response)
        )
        cure, key = ("", "") if applied or followed is None else _put_on(followed)
        gates.append(
            Gate(
                f"{name}: quasi-static loads",
                1.0 + vibration.deviation,
                _LIMIT,
                f"{verdict_words(1.0 + vibration.deviation)}. {_meaning(design, vibration, worst)}"
                + (" What it adds is in the loads." if applied else ""),
                binding=not applied,
                cure=cure,
                key=key,
            )
        )
        if applied and followed is not None:
            gates.append(followed)
    return gates


def _put_on(followed: Gate) -> tuple[str, str]:
    """Cure and override that put vibration on the loads; "" where no positions follow its waves."""
    if followed.holds:
        return f"Put what it adds on the loads ({_APPLIED})", _APPLIED
    if followed.key:
        return f"Put what it adds on the loads ({_APPLIED} with {followed.key})", ""
    return "", ""


def _followed_gate(name: str, response: CycleResponse) -> Gate:
    """Gate of vibration that is on the loads: its waves must not be lost between the positions.

    Loads are straight between them, so a wave of the frequency f keeps cos(pi f dt) of its size;
    and so is the response between the moments at which it is solved.
    """
    positions = len(response.modes.frequencies)

    def lost(mode: ModeResponse, step: float) -> float:
        return _counted(mode) * (1.0 - cos(pi * min(mode.highest * step, 1.0)))

    def moments(mode: ModeResponse) -> float:
        return float(mode.times[1] - mode.times[0])

    def both(mode: ModeResponse) -> float:
        return lost(mode, response.step) + lost(mode, moments(mode))

    worst = max(response.responses, key=both)
    value = both(worst)
    told = (
        f"mode {worst.mode}, up to {number(worst.highest)} Hz, has "
        f"{number(1.0 / (worst.highest * response.step))} positions in its period where they lie "
        "farthest apart, between which its waves are lost"
    )
    cure = key = ""
    if value > _LOST:
        left = _LOST - lost(worst, moments(worst))
        step = acos(1.0 - min(max(left, 0.0) / _counted(worst), 2.0)) / (pi * worst.highest)
        count = ceil(1.1 * positions * response.step / step) if step else inf
        if count <= _MOST_POSITIONS:
            cure = f"State cycles.{name}.positions = {count} or more"
            key = f"cycles.{name}.positions={count}"
        else:
            cure = (
                "It is too fast for the moments or the positions that a cycle can have: state a "
                "longer dynamics.rise, if loads rise so, or leave dynamics.apply out"
            )
    return Gate(f"{name}: vibration between the positions", value, _LOST, told, cure=cure, key=key)


def verdict_words(factor: float) -> str:
    """Return `valid`, `amplification 1.08` or `not valid`."""
    if factor <= VALID:
        return "valid"
    return f"amplification {factor:.3g}" if factor <= _LIMIT else "not valid"


def _meaning(design: Design, vibration: CycleVibration, worst: ModeResponse) -> str:
    assert vibration.response is not None
    rate = 1.0 / vibration.response.period
    told = ", ".join(_harmonic(one) for one in worst.harmonics)
    jump = contact = ""
    if vibration.contact:
        contact = " The contact counts as a load, not as a support."
    elif design.cycles[vibration.cycle].has_contact:
        contact = " Without the contact, by whose blows the linkage swings in the loads."
    if worst.jump > VALID - 1.0:
        jump = f" Its load jumps by {worst.jump:.0%} at once, which " + (
            f"is taken to rise in {number(worst.rise)} s (dynamics.rise): a single sudden jump "
            "adds up to as much again, repeated ones more where they come before it has died out."
            if design.dynamics.rise is None
            else f"rises in {number(design.dynamics.rise)} s."
        )
    if vibration.deviation > _TOLD_SUM * worst.deviation or worst not in vibration.telling:
        words = (
            "1 + sum over all modes of the largest difference that vibration makes at any time, "
            "over the largest response of the mode, times its share of the linkage's deformation; "
            f"most of it by mode {worst.mode}, share {worst.share:.2g}, difference "
            f"{number(worst.deviation)}"
        )
    else:
        words = (
            "1 + largest difference that vibration makes at any time, over the largest response "
            "of the mode that differs most"
        )
    return (
        f"{words}: {number(worst.lowest)} to {number(worst.highest)} Hz over the "
        f"cycle of {number(rate)} 1/s, the drive held, damping {design.dynamics.damping:g}; at the "
        f"worst frequency of this range, {number(worst.worst)} Hz, the largest response itself is "
        f"{number(worst.amplification)} times as large. Harmonics, half range x factor: {told}."
        f"{contact}{jump}"
    )


def _harmonic(one: Harmonic) -> str:
    return f"{one.number:g}: {one.amplitude:.2g} x {one.factor:.3g}"


def assumptions_of(design: Design, found: Mapping[str, CycleVibration]) -> list[tuple[str, str]]:
    """Assumptions on the vibration, which every result lists."""
    result: dict[tuple[str, str], None] = {}
    for name, vibration in found.items():
        for body, section in vibration.sections:
            reason = f"its part's section all along it ({section}), for vibration only"
            result[f"bodies.{body}.elastic", reason] = None
        if vibration.rigid:
            words = f"rigid in vibration: {', '.join(vibration.rigid)}"
            result["dynamics", words] = None
        if vibration.unasked:
            words = f"quasi-static: not asked, {vibration.unasked}"
            if design.dynamics.apply:
                words += "; vibration is not put on its loads"
            result[f"{_table(design, name)}.{name}", words] = None
        if design.dynamics.apply and vibration.contact:
            words = "vibration is not put on its loads: it would change the force of its contact"
            result[f"cycles.{name}", words] = None
    return list(result)


def _table(design: Design, name: str) -> str:
    return "cycles" if design.cycles[name].event is None else "events"


def vibration_warnings(
    design: Design, solved: Mapping[str, loads.CycleLoads], found: Mapping[str, CycleVibration]
) -> list[str]:
    """Warnings that name the cycles with and without vibration, where the design asks for it.

    solved  the cycles without vibration
    """
    if not design.dynamics.apply:
        return []
    warnings = []
    for name, vibration in found.items():
        if vibration.contact:
            why = "it would change the force of the cycle's contact"
        elif vibration.response is None:
            why = vibration.unasked
        else:
            vibrating = with_vibration(solved[name], vibration.response)
            most = [_largest_force(cycle) for cycle in (solved[name], vibrating)]
            warnings.append(
                f"{name}: vibration is on its loads: the largest joint force is {most[1]:.4g} N, "
                f"{most[0]:.4g} N without it"
            )
            continue
        warnings.append(f"{name}: vibration is NOT on its loads, though dynamics.apply asks: {why}")
    return warnings


def _largest_force(cycle: loads.CycleLoads) -> float:
    sizes = (np.hypot(*load.force.T).max() for load in cycle.reactions.values())
    return float(max(sizes, default=0.0))


def with_dynamics(
    design: Design, solved: Mapping[str, loads.CycleLoads], found: Mapping[str, CycleVibration]
) -> dict[str, loads.CycleLoads]:
    """Return the cycles with what vibration adds, where the design asks for it.

    Cycles with a contact, and those without harmonics, stay as they are (`assumptions_of`).
    """
    result = dict(solved)
    if not design.dynamics.apply:
        return result
    for name, vibration in found.items():
        if vibration.response is None or vibration.contact:
            continue
        result[name] = with_vibration(solved[name], vibration.response)
    return result
