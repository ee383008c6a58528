"""Figures of the loads of a cycle or run: extremes, drives, contacts, as plain data."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geometry.mesh import FloatArray
from loads import GROUND, CycleLoads


@dataclass(frozen=True)
class Extremes:
    """Least and largest value of one quantity over a cycle, and where.

    low, high, mean  N or N mm (`angular`); the mean is over time, not a number without times
    low_at, high_at  shown position; low_phase, high_phase the phase
    """

    quantity: str
    angular: bool
    low: float
    low_at: float
    low_phase: str
    high: float
    high_at: float
    high_phase: str
    mean: float

    @property
    def largest(self) -> float:
        """The largest magnitude."""
        return max(abs(self.low), abs(self.high))


@dataclass(frozen=True)
class JointSummary:
    """Extremes of a joint's reaction on the body `on`; the body `by` gets the opposite."""

    name: str
    kind: str
    on: str
    by: str
    extremes: tuple[Extremes, ...]

    def largest(self, angular: bool) -> float:
        """The largest force, or moment, of all rows, which sets the unit of them all."""
        return max((row.largest for row in self.extremes if row.angular == angular), default=0.0)


@dataclass(frozen=True)
class PointSummary:
    """Extremes of the measured load on a body at one of its points."""

    body: str
    point: str
    extremes: tuple[Extremes, ...]

    def largest(self, angular: bool) -> float:
        """The largest force, or moment, of all rows, which sets the unit of them all."""
        return max((row.largest for row in self.extremes if row.angular == angular), default=0.0)


@dataclass(frozen=True)
class Direction:
    """The largest effort of a drive in one direction, and what is available there [N, N mm]."""

    words: str
    needed: float
    at: float
    phase: str
    available: float | None


@dataclass(frozen=True)
class DriveSummary:
    """One force as a drive; its power in N mm/s, and of a closed crank cycle its unevenness.

    closed         True if the cycle ends in the pose that it starts from
    impact_energy  N mm a cycle, of what meets its contacts at a speed: not in the powers
    reduced_inertia, flywheel  t mm2; ripple N mm; None unless the cycle is closed and runs at a
                   constant speed of this drive
    irregularity   (fastest - slowest) / mean speed; None, as flywheel, also without any mass
    allowed        the irregularity that the flywheel, inertia in all, is for
    """

    name: str
    angular: bool
    directions: tuple[Direction, ...]
    closed: bool
    mean_power: float
    peak_power: float
    work: float
    impact_energy: float
    reduced_inertia: float | None
    ripple: float | None
    irregularity: float | None
    flywheel: float | None
    allowed: float


@dataclass(frozen=True, eq=False)
class MotorFigures:
    """Speed and torque of a motor over a cycle.

    slowest, fastest, mean  rad/s of the angle that it turns; the first two with shown positions
    largest, effective, rated  N mm of torque at its own shaft; of either sign; effective: the
                                root mean square
    power    N mm/s that it gives in the mean
    ratio    its speed over the angle's
    missing  energy of a turn that motor and linkage do not agree on, over what is turned over
    speed    (n,) rad/s of the angle; torque (n,) N mm on it
    """

    slowest: float
    slowest_at: float
    fastest: float
    fastest_at: float
    mean: float
    largest: float
    effective: float
    rated: float
    power: float
    ratio: float
    missing: float
    speed: FloatArray
    torque: FloatArray

    def to_dict(self) -> dict[str, Any]:
        """The figures as plain data, without the history."""
        return {k: v for k, v in vars(self).items() if k not in ("speed", "torque")}


@dataclass(frozen=True)
class EventFigures:
    """A start or stop of a cycle.

    kind    start, coast or brake
    at      shown position where it begins; tried: of how many places the worst; 0 where stated
    time    s; turns: of the cycle, until it is over
    force   largest of any joint, N; torque: largest of the drive on the linkage, N mm; both beside
            those of the steady run
    missing energy that motor, brake, flywheel and linkage do not agree on, over what is turned over
    """

    kind: str
    cycle: str
    shown_name: str
    unit: str
    at: float
    tried: int
    time: float
    turns: float
    force: float
    steady_force: float
    torque: float
    steady_torque: float
    missing: float


@dataclass(frozen=True)
class ContactStated:
    """A contact as the design has it: from where on along the coordinate that was written there.

    at  mm, one for each place that it has in the cycle
    """

    coordinate: str
    at: tuple[float, ...]


@dataclass(frozen=True)
class ContactSpan:
    """A stretch of the cycle in which a contact pushes without a break.

    start, stop     shown position; start_phase, stop_phase the phase there
    approach_speed  mm/s or rad/s at which it is met; None where the cycle begins in touch, or the
                    contact appears with a phase
    energy          N mm, what the pushed body loses there
    """

    start: float
    start_phase: str
    stop: float
    stop_phase: str
    approach_speed: float | None
    energy: float | None


@dataclass(frozen=True)
class ContactSummary:
    """Contact of a force: place, force and speed; N, mm (or N mm, rad), N mm of energy.

    body           what is pushed
    always         True if it touches at every position
    start_depth    how far it is already pressed at the start of the cycle, or None
    nearest        how near it comes where it never touches, None if it does
    largest        the largest force, and the shown position and phase where it acts
    approach_speed, energy  the largest speed at which it is met, the energy of all times it is
    deflection     the largest by which the linkage gives way
    least_held, most_held  share of its acceleration along the force that the body loses in touch
    """

    name: str
    body: str
    angular: bool
    stated: ContactStated | None
    spans: tuple[ContactSpan, ...]
    always: bool
    start_depth: float | None
    nearest: float | None
    largest: float
    largest_at: float
    largest_phase: str
    deflection: float
    least_held: float
    most_held: float
    approach_speed: float
    energy: float


@dataclass(frozen=True)
class JointBlow:
    """Impulse of a joint on the body `on` in a blow: N s, N mm s, axes of the ground."""

    name: str
    on: str
    x: float
    y: float
    couple: float


@dataclass(frozen=True)
class BlowForceSummary:
    """The force of a blow that was solved.

    peak     N; contact  s until the force has gone; infinite where the drive presses on
    depth    mm that the workpiece is pressed in for good; energy  N mm left in it
    rebound  mm/s; 0 where the bodies stay in touch; until  s for which the blow is followed
    joints   N, largest force of each while the blow is followed
    count    touches in a cycle that swings by its blows, of which this is the hardest; 0 where it
             goes on as if slowly
    """

    peak: float
    contact: float
    depth: float
    energy: float
    rebound: float
    until: float
    joints: Mapping[str, float]
    count: int = 0


@dataclass(frozen=True)
class BlowSummary:
    """A contact that is met at a speed.

    restitution    least and largest that it may have
    stated         True where the design states the restitution
    at, phase      shown position and phase; time s
    speed          mm/s before, of the contact's coordinate
    mass           t, that the contact meets: with what gives way open, and as if rigid where that
                   is about as stiff as what is struck; infinite where the drive holds the speed
    impulse        N s on the contact, the least and the largest; energy N mm that is lost, with
                   the largest mass and least restitution, and the other way round
    joints         impulses in the joints with the largest restitution; none: not known
    open           joints that pass none on, as something gives way there
    rigid_mass     t, that the contact would meet if nothing gave way
    drive_struck   True if the drive's own inertia is in the blow; drive_stated: it is known
    per_minute     None where the cycle does not end as it begins
    solved         its force, where the workpiece is stated
    """

    force: str
    stated: bool
    restitution: tuple[float, float]
    at: float
    phase: str
    time: float
    speed: float
    mass: tuple[float, float]
    impulse: tuple[float, float]
    energy: tuple[float, float]
    joints: tuple[JointBlow, ...]
    open: tuple[str, ...]
    rigid_mass: float
    drive_struck: bool
    drive_stated: bool
    per_minute: float | None
    solved: BlowForceSummary | None = None

    @property
    def rebound(self) -> tuple[float, float]:
        """Speeds after, mm/s."""
        low, high = self.restitution
        return low * self.speed, high * self.speed


@dataclass(frozen=True)
class ShownPhase:
    """A phase: from and to as shown, s it takes, the force it solves for, the laws of others."""

    name: str
    start: float
    stop: float
    time: float
    solve: str
    given: tuple[str, ...]


def contact_summaries(
    loads: CycleLoads, shown: FloatArray, stated: Mapping[str, ContactStated]
) -> list[ContactSummary]:
    """Every contact of a cycle; `shown` (n,) is the position as people see it."""
    result = []
    for name, contact in loads.contacts.items():
        coordinate = loads.linkage.force(name).coordinate
        effort = np.where(contact.touching, np.abs(loads.efforts[name]), 0.0)  # without a blow's
        most = int(effort.argmax())
        gap = loads.touches[name].gap
        pushed = [body for body in coordinate.bodies if body != GROUND]
        spans = _spans(loads, name, shown)
        held = contact.held[contact.touching]
        result.append(
            ContactSummary(
                name=name,
                body=" and ".join(pushed),
                angular=coordinate.angular,
                stated=stated.get(name),
                spans=spans,
                always=bool(contact.touching.all()),
                start_depth=-float(gap[0]) if contact.touching[0] else None,
                nearest=None if spans else float(gap.min()),
                largest=float(effort.max()),
                largest_at=float(shown[most]),
                largest_phase=loads.phases[int(loads.phase_of[most])],
                deflection=float(np.abs(contact.deflection).max()),
                least_held=float(held.min(initial=1.0)),
                most_held=float(held.max(initial=0.0)),
                approach_speed=max((span.approach_speed or 0.0 for span in spans), default=0.0),
                energy=sum(span.energy or 0.0 for span in spans),
            )
        )
    return result


def _spans(loads: CycleLoads, name: str, shown: FloatArray) -> tuple[ContactSpan, ...]:
    """Stretches of touch; the positions where it begins and ends stand in the cycle, untouched."""
    contact = loads.contacts[name]
    touching, last = contact.touching, len(shown) - 1
    impacts = dict(zip(contact.begins.tolist(), contact.impacts.tolist(), strict=True))
    gap = loads.touches[name].gap
    edges = np.flatnonzero(np.diff(np.concatenate([[False], touching, [False]]).astype(int)))
    spans = []
    for first, behind in edges.reshape(-1, 2).tolist():
        start, stop = max(first - 1, 0), min(behind, last)
        # where the phase before has no contact, it is not met on the way but put there
        met = first > 0 and np.isfinite(gap[start])
        if not met:
            start = first
        if not np.isfinite(gap[stop]):
            stop = behind - 1
        speed = abs(float(contact.rate[start])) if met else None
        spans.append(
            ContactSpan(
                start=float(shown[start]),
                start_phase=loads.phases[int(loads.phase_of[first])],
                stop=float(shown[stop]),
                stop_phase=loads.phases[int(loads.phase_of[behind - 1])],
                approach_speed=speed,
                energy=float(impacts[start]) if start in impacts else None,
            )
        )
    return tuple(spans)
