"""Speed at which a motor turns a linkage over and over.

The torque D that the linkage takes at a place depends on speed and acceleration, by its inertia and
by its joints' friction. D is linearised about a run, D = a dv/dt + b v^2 + c, which is exact where
nothing rubs; the turn that repeats is found (`loads/turning.py`), D is linearised about it, and so
on until the run stays.

Times and speeds of a cycle from its pace, phase by phase.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Final

import numpy as np

from loads.bodies import BoolArray, FloatArray, Force, LinkageError, in_words
from loads.kinematics import Kinematics, centre_arm, dot, velocity_at
from loads.motion import Geometry, Motion
from loads.pace import (
    Cycle,
    Geared,
    MotorPace,
    Pace,
    RunPace,
    SteadyPace,
    StrokePace,
    stroke_law,
    stroke_time,
)
from loads.path import Path
from loads.turning import Place, Turn, UnsettledError

_STEADY = 1e-6  # of the speed: what a steady speed may vary by rounding
_NO_TIME = 1e-12  # of a cycle


@dataclass(frozen=True, eq=False)
class DriveFigures:
    """Effort, work and power of one force or torque over a cycle.

    angular             True for a torque (N mm, rad), False for a force (N, mm)
    closed              True if the cycle ends in the pose that it starts from
    smallest, largest   N or N mm, signed
    mean_effort         over the way of its coordinate, N or N mm; 0 where it does not move
    work                N mm, done on the linkage over the cycle
    mean_power, peak_power  N mm/s; the peak is the largest magnitude
    reduced_mass        (n,) t or t mm2, kinetic energy over half the squared rate
    mean_reduced_mass   over the way
    speed               mm/s or rad/s, way over time
    energy_ripple       N mm, largest less smallest of the integral of effort - mean over the way;
                        None unless the cycle is closed and the coordinate turns at one speed
    """

    force: str
    angular: bool
    closed: bool
    smallest: float
    largest: float
    mean_effort: float
    work: float
    mean_power: float
    peak_power: float
    reduced_mass: FloatArray
    mean_reduced_mass: float
    speed: float
    energy_ripple: float | None

    @property
    def irregularity(self) -> float | None:
        """Largest less smallest speed over the mean speed that the ripple would cause.

        ripple / (mean reduced mass x speed^2) (Norton, Design of Machinery, ch. 11), which takes
        the speed as nearly constant: above some tenths it only says that the speed is not.
        Raises LinkageError where nothing that moves has mass.
        """
        if self.energy_ripple is None:
            return None
        if self.mean_reduced_mass <= 0.0:
            raise LinkageError(
                f"force {self.force!r}: nothing that it drives has a mass, so the ripple of "
                "its speed is unknown; state the masses"
            )
        return self.energy_ripple / (self.mean_reduced_mass * self.speed**2)

    def reduced_mass_for(self, irregularity: float) -> float | None:
        """Reduced mass [t, t mm2] in all, with a flywheel, that keeps to an irregularity."""
        if self.energy_ripple is None:
            return None
        return self.energy_ripple / (irregularity * self.speed**2)


def drive_figures(
    kinematics: Kinematics,
    force: Force,
    efforts: FloatArray,
    times: FloatArray,
    poses: FloatArray,
    velocities: FloatArray,
    heading: FloatArray,
) -> DriveFigures:
    """Return the figures of a force over the positions of a cycle."""
    n = len(times)
    coordinate = force.coordinate
    gradient = kinematics.gradient(coordinate, poses)
    steps = kinematics.steps(coordinate, poses)
    # from one turn of a start to the next the positions go back to the first one's, in no time
    steps = np.where(np.diff(times) > _NO_TIME * float(times[-1]), steps, 0.0)
    way = float(np.abs(steps).sum())
    push = force.sign * efforts
    work = float(np.sum(0.5 * (push[:-1] + push[1:]) * steps))
    lead = dot(gradient, heading.reshape(n, -1))
    energy = 2.0 * kinetic_energy(kinematics, poses, heading, kinematics.linkage.body_names)
    reduced = np.divide(energy, lead**2, out=np.full(n, np.inf), where=lead != 0.0)
    duration = float(times[-1] - times[0])
    closed = is_closed(kinematics, poses)
    rate = dot(gradient, velocities.reshape(n, -1))
    steady = bool(np.ptp(rate) <= _STEADY * np.abs(rate).max())
    ripple = None
    if closed and steady and coordinate.angular and way > 0.0:
        value = kinematics.value(coordinate, poses)
        mean = work / float(value[-1] - value[0])
        left = push - mean
        stored = np.concatenate([[0.0], np.cumsum(0.5 * (left[:-1] + left[1:]) * steps)])
        ripple = float(np.ptp(stored))
    weights = np.abs(steps) / way if way else np.zeros(n - 1)
    middle = 0.5 * (reduced[:-1] + reduced[1:])
    # the reduced mass is infinite where the coordinate stands still; the mean then is, too
    moving = weights > 0.0
    mean_mass = float(np.sum(weights[moving] * middle[moving])) if way else float("inf")
    return DriveFigures(
        force=force.name,
        angular=coordinate.angular,
        closed=closed,
        smallest=float(efforts.min()),
        largest=float(efforts.max()),
        mean_effort=float(np.sum(weights * 0.5 * (efforts[:-1] + efforts[1:]))),
        work=work,
        mean_power=work / duration if duration else 0.0,
        peak_power=float(np.abs(push * rate).max()),
        reduced_mass=reduced,
        mean_reduced_mass=mean_mass,
        speed=way / duration if duration else 0.0,
        energy_ripple=ripple,
    )


def kinetic_energy(
    kinematics: Kinematics, poses: FloatArray, rates: FloatArray, bodies: Collection[str]
) -> FloatArray:
    """Return the kinetic energy of some bodies for rates of the poses (n,)."""
    total = np.zeros(len(poses))
    for i, body in enumerate(kinematics.linkage.moving, start=1):
        if body.name not in bodies:
            continue
        speed = velocity_at(centre_arm(body, poses[:, i]), rates[:, i])
        total += 0.5 * (body.mass * dot(speed, speed) + body.inertia * rates[:, i, 2] ** 2)
    return total


def is_closed(kinematics: Kinematics, poses: FloatArray) -> bool:
    """Return True if the last pose is the first, whole turns aside."""
    change = poses[-1, 1:] - poses[0, 1:]
    turns = change[:, 2] / (2.0 * np.pi)
    change = change.copy()
    change[:, 2] = 2.0 * np.pi * (turns - np.round(turns))
    scaled = np.abs(change.reshape(-1) / kinematics.pose_scale)
    return bool(scaled.max(initial=0.0) < 1e-6)


if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline


# torque (n,) that the linkage takes in phase k at squared speeds and accelerations (n,)
Demand = Callable[[int, FloatArray, FloatArray], FloatArray]
Run = tuple[FloatArray, FloatArray]  # squared speeds and accelerations (n,) of a phase
Linear = tuple[FloatArray, FloatArray, FloatArray]  # a, b and c (n,) of a phase

_SETTLED = 1e-9  # of the squared speed: change by another linearisation of a run that stays
_ROUGH = 1e-3  # of the squared speed: change that asks for slopes anew
_LEAST_SHARE = 1 / 8  # of a change that is gone where runs do not settle
_MOST_ROUNDS = 60
_SAME_PLACE = 1e-6  # of a cushion
_GAUSS = np.polynomial.legendre.leggauss(6)


@dataclass(frozen=True, eq=False)
class SolvedPace:
    """Speeds over the way, phase by phase.

    phases  squared speed, rad2/s2, over the way since the start of the cycle, rad
    starts  (phases,) s, the time at which each begins
    turn    the linear problem that they solve
    """

    phases: "Sequence[CubicHermiteSpline]"
    starts: FloatArray
    turn: Turn

    def rates(self, k: int, way: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Speed and acceleration (n,) at ways in phase k."""
        squares = np.asarray(self.phases[k](way))
        return np.sqrt(squares), 0.5 * self.turn.slopes(k, way, squares)

    def times(self, k: int, way: FloatArray) -> FloatArray:
        """Time since the start of the cycle (n,), s."""
        return np.asarray(self.starts[k] + _time_along(self.phases[k], np.asarray(way)))


def _time_along(squares: "CubicHermiteSpline", way: FloatArray) -> FloatArray:
    """Time from the start of a phase to ways of it (n,), s, by Gauss' rule between its knots."""
    knots = squares.x
    index = np.clip(np.searchsorted(knots, way, side="right") - 1, 0, len(knots) - 2)

    def between(low: FloatArray, high: FloatArray) -> FloatArray:
        half = 0.5 * (high - low)[:, None]
        at = 0.5 * (high + low)[:, None] + half * _GAUSS[0]
        return np.asarray((half * _GAUSS[1] / np.sqrt(squares(at))).sum(axis=1))

    whole = np.concatenate([[0.0], np.cumsum(between(knots[:-1], knots[1:]))])
    return np.asarray(whole[index] + between(knots[index], way))


def running(
    demand: Demand,
    ways: Sequence[FloatArray],
    motor: Geared,
    inertia: float,
    start: float,
    place: Place,
) -> SolvedPace:
    """Return the speeds at which a motor turns a linkage, cycle after cycle.

    demand   torque that the linkage takes at the ways of a phase, N mm
    ways     per phase (3 m + 1,) rad, of the motor's coordinate since the start of the cycle:
             `with_points` of positions
    inertia  t mm2, of all that turns with the coordinate besides linkage and rotor
    start    rad/s, a speed to begin with
    place    where way i of phase k is, in words

    Raises StallError where the motor stops, RunawayError where the load drives it on, LinkageError
    where nothing has a mass, UnsettledError where no run is found.
    """
    runs = [(np.full(len(way), start**2), np.zeros(len(way))) for way in ways]
    whole = inertia + motor.reflected
    linear: list[Linear] = []
    known, change, share, switching = None, np.inf, 1.0, False
    for _ in range(_MOST_ROUNDS):
        anew = change > _ROUGH or switching
        linear = [
            _linearised(demand, k, run, whole, None if anew else linear[k])
            for k, run in enumerate(runs)
        ]
        turn = Turn(
            motor,
            ways,
            [whole + a for a, _, _ in linear],
            [(b, c) for _, b, c in linear],
            place,
        )
        found = turn.repeated(known)
        known, before = float(found[0][0][0]), change
        change = max(
            float((np.abs(new - old) / new).max())
            for (new, _), (old, _) in zip(found, runs, strict=True)
        )
        if change < _SETTLED:
            return _pace(turn, found)
        # a contact or friction may switch to and fro between two rounds
        switching = change > (1.0 - 0.5 * share) * before
        share = max(0.5 * share, _LEAST_SHARE) if switching else min(2.0 * share, 1.0)
        runs = [
            (old + share * (new - old), slow + share * (0.5 * slope - slow))
            for (old, slow), (new, slope) in zip(runs, found, strict=True)
        ]
    raise UnsettledError(
        "forces of the joints and speed of the motor do not settle on each other: the squared "
        f"speed still changes by {change:.1g} of itself"
    )


def _linearised(demand: Demand, k: int, run: Run, whole: float, known: Linear | None) -> Linear:
    """Torque that a phase takes near a run, with known slopes a and b, or with slopes anew."""
    squares, accelerations = run
    taken, more = demand(k, squares, accelerations), 0.01 * squares
    if known is None:
        b = (demand(k, squares + more, accelerations) - taken) / more
        a = (demand(k, squares, accelerations + more) - taken) / more
        a = np.maximum(a, -0.5 * whole)  # less is the jump of a contact that opens
    else:
        a, b, _ = known
    return a, b, taken - a * accelerations - b * squares


def _pace(turn: Turn, found: Sequence[tuple[FloatArray, FloatArray]]) -> SolvedPace:
    from scipy.interpolate import CubicHermiteSpline  # half a second that few linkages need

    splines = [
        CubicHermiteSpline(way, w, slope) for way, (w, slope) in zip(turn.ways, found, strict=True)
    ]
    took = [float(_time_along(spline, spline.x[-1:])[0]) for spline in splines]
    return SolvedPace(splines, np.concatenate([[0.0], np.cumsum(took)[:-1]]), turn)


class Timing:
    """The pace of a cycle over its phases; way is how far the pace coordinate has gone.

    solved  the run of the motor of a MotorPace, or a RunPace; None: at the stated speed
    """

    def __init__(
        self,
        path: Path,
        pace: Pace,
        spans: tuple[tuple[float, float], ...],
        solved: SolvedPace | None = None,
    ) -> None:
        self._pace: Final = pace.steady if isinstance(pace, MotorPace) else pace
        self.solved: Final = pace if isinstance(pace, RunPace) else solved
        kinematics = path.kinematics
        kinematics.linkage.check_coordinate(pace.coordinate, "pace")
        ends = np.array(spans)
        before, after = (
            kinematics.value(pace.coordinate, path.at(end).poses)
            for end in (ends[:, 0], ends[:, 1])
        )
        self._values: Final = before
        self._falling: Final = after < before
        ways = self._ways = np.abs(after - before)
        rising = [stop > start for start, stop in spans]
        self._stroke_of: Final = np.zeros(len(spans), dtype=int)
        self._before: Final = np.zeros(len(spans))  # way before the phase, in its stroke or in all
        self._left: Final = np.zeros(len(spans))  # way from its start to the end of its stroke
        self._strokes: list[float] = []
        phase = 0
        for number, (_, group) in enumerate(groupby(rising)):
            first = phase
            for _ in group:
                start = first if isinstance(pace, StrokePace) else 0
                self._before[phase] = ways[start:phase].sum()
                self._stroke_of[phase] = number
                phase += 1
            self._strokes.append(float(ways[first:phase].sum()))
            self._left[first:phase] = np.cumsum(ways[first:phase][::-1])[::-1]
        if isinstance(self._pace, SteadyPace) and self._pace.cushion:
            self._check_cushion(self._pace)

    def _check_cushion(self, pace: SteadyPace) -> None:
        if min(self._strokes) < pace.cushion:
            raise LinkageError(
                f"the cushion of {pace.cushion:g} mm is longer than a stroke of "
                f"{min(self._strokes):g} mm"
            )
        after = self._left - self._ways
        if (~self._cushioned(pace) & (after < (1.0 - _SAME_PLACE) * pace.cushion)).any():
            raise LinkageError("a phase must begin where the cushion does (split_cycle)")

    def _cushioned(self, pace: SteadyPace) -> BoolArray:
        """True for each phase that is in a cushion."""
        return np.asarray(self._left <= (1.0 + _SAME_PLACE) * pace.cushion) & (pace.cushion > 0.0)

    def way(self, k: int, geometry: Geometry | Motion) -> FloatArray:
        """Return how far the pace coordinate has gone (n,) at positions of phase k."""
        values = geometry.kinematics.value(self._pace.coordinate, geometry.poses)
        return np.asarray(self._before[k] + np.abs(values - self._values[k]))

    def rates(self, k: int, geometry: Geometry) -> tuple[FloatArray, FloatArray]:
        """Return speed and acceleration of the pace (n,) at positions of phase k."""
        pace = self._pace
        way = self.way(k, geometry)
        if self.solved is not None:
            return self.solved.rates(k, way)
        assert not isinstance(pace, RunPace)
        if isinstance(pace, SteadyPace):
            if self._cushioned(pace)[k]:
                speed = self._speed(pace, k)
                share = self._share(pace, k, way - self._before[k])
                slows = np.full(len(way), -(speed**2) / (2.0 * pace.cushion))
                return speed * np.sqrt(share), slows
            if pace.falling is not None or pace.cushion:
                return np.full(len(way), self._speed(pace, k)), np.zeros(len(way))
            square = pace.speed**2 + 2.0 * pace.acceleration * way
            if (square <= 0.0).any():
                at = geometry.place(int(np.argmax(square <= 0.0)))
                slowing = in_words(pace.coordinate, -pace.acceleration)
                raise LinkageError(
                    f"{pace.coordinate.label} slows down by {slowing}/s2 and stands still before "
                    f"{at}"
                )
            return np.sqrt(square), np.full(len(way), pace.acceleration)
        length = self._length(k)
        _, rate, change = stroke_law(pace.law, stroke_time(pace.law, way / length))
        return rate * length / pace.time, change * length / pace.time**2

    def times(self, k: int, motion: Motion) -> FloatArray:
        """Return the time since the start of the cycle (n,) [s] at positions of phase k."""
        pace = self._pace
        way = self.way(k, motion)
        if self.solved is not None:
            return self.solved.times(k, way)
        assert not isinstance(pace, RunPace)
        if isinstance(pace, SteadyPace):
            if pace.falling is not None or pace.cushion:
                gone = sum(float(self._took(pace, j, self._ways[j : j + 1])[0]) for j in range(k))
                return np.asarray(gone + self._took(pace, k, way - self._before[k]))
            # way = v t + a t2 / 2, solved without losing digits where a is small
            root = np.sqrt(pace.speed**2 + 2.0 * pace.acceleration * way)
            return np.asarray(2.0 * way / (pace.speed + root))
        share = stroke_time(pace.law, way / self._length(k))
        return np.asarray((self._stroke_of[k] + share) * pace.time)

    def _took(self, pace: SteadyPace, k: int, gone: FloatArray) -> FloatArray:
        """Time since the start of phase k (n,), s, for a way gone in it, at the speed or braked."""
        speed = self._speed(pace, k)
        if not self._cushioned(pace)[k]:
            return np.asarray(gone / speed)
        roots = np.sqrt(self._share(pace, k, np.zeros(1))) - np.sqrt(self._share(pace, k, gone))
        return np.asarray(2.0 * pace.cushion / speed * roots)

    def _share(self, pace: SteadyPace, k: int, gone: FloatArray) -> FloatArray:
        """Share of the cushion that is left (n,)."""
        return np.asarray(np.clip((self._left[k] - gone) / pace.cushion, 0.0, 1.0))

    def _speed(self, pace: SteadyPace, k: int) -> float:
        return pace.falling if pace.falling is not None and self._falling[k] else pace.speed

    def _length(self, k: int) -> float:
        length = self._strokes[int(self._stroke_of[k])]
        if length <= 0.0:
            raise LinkageError(
                f"{self._pace.coordinate.label} sets the pace but does not move in phase {k + 1}"
            )
        return length


# Cycles that a motor can turn over and over, and how the force solved for follows its angle.

_SAME = 1e-9  # of a rate


def driven_by(cycle: Cycle, kinematics: Kinematics, places: Sequence[Geometry]) -> list[FloatArray]:
    """Return per phase the torque along the way over the force solved for (n,): 1 or -1.

    Raises LinkageError unless the cycle goes round once and again in one direction, by the angle
    that sets its pace, and every phase solves for a torque on that angle.
    """
    pace = cycle.pace.coordinate
    if cycle.coordinate != pace:
        raise LinkageError(
            f"cycle {cycle.name!r}: a motor turns {pace.label}, so that coordinate must lead the "
            f"cycle, not {cycle.coordinate.label}"
        )
    ends = np.stack([places[0].poses[0], places[-1].poses[-1]])
    rising = {stop > start for start, stop in cycle.spans}
    if len(rising) > 1 or not is_closed(kinematics, ends):
        raise LinkageError(
            f"cycle {cycle.name!r}: a motor turns {pace.label} over and over, so the cycle must go "
            "on in one direction and end in the pose that it starts from"
        )
    if len({phase.solve for phase in cycle.phases}) > 1:
        raise LinkageError(
            f"cycle {cycle.name!r}: one torque on {pace.label} is the motor's, so all phases must "
            "solve for the same"
        )
    found = []
    for phase, geometry in zip(cycle.phases, places, strict=True):
        force = kinematics.linkage.force(phase.solve)
        first = geometry.first.reshape(len(geometry.values), -1)
        rates = [
            dot(kinematics.gradient(coordinate, geometry.poses), first)
            for coordinate in (force.coordinate, pace)
        ]
        if (
            not force.coordinate.angular
            or (np.abs(np.abs(rates[0] / rates[1]) - 1.0) > _SAME).any()
        ):
            raise LinkageError(
                f"cycle {cycle.name!r}, phase {phase.name!r}: the motor turns {pace.label}, so the "
                f"phase must solve for a torque on it, not for {force.name!r}"
            )
        found.append(force.sign * np.sign(rates[0] * (1.0 if rising == {True} else -1.0)))
    return found
