"""Timing of a cycle: the rate of one coordinate along its way.

A motor has a torque over its speed, at the coordinate that it turns. Asynchronous: Kloss' formula T
= 2 T_b / (s / s_b + s_b / s), slip s = 1 - speed / synchronous speed, T_b the breakdown torque, s_b
its slip; through the rated torque at the rated slip s_r it is s_b = s_r (b + sqrt(b^2 - 1)), b =
T_b / T_r (the root beyond the rated slip). Without a breakdown torque, as direct current and
servos: a straight line through the rated point and the speed without load, cut at the torque that
the controller lets through.

From rest an asynchronous motor differs from Kloss' formula, as currents crowd in its rotor's bars.
With its torque at standstill stated, below the breakdown speed a straight line over the speed leads
from there to the breakdown torque; a saddle between them is left out.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isfinite, sqrt
from typing import TYPE_CHECKING, Final

import numpy as np

from loads.bodies import Coordinate, FloatArray, LinkageError
from loads.laws import Law

_BISECTIONS = 52
STROKE_LAWS: Final = ("harmonic", "cycloidal", "polynomial")


@dataclass(frozen=True)
class Motor:
    """A motor by its plate.

    rated_torque  N mm, at the rated speed
    rated_speed   rad/s
    free_speed    rad/s without load: the synchronous speed of an asynchronous motor
    breakdown     largest over rated torque of an asynchronous motor; None: a straight line
    most          N mm, that the controller of a straight line lets through; None: all
    starting      torque at standstill over rated torque, with a breakdown torque; None: by Kloss
    """

    rated_torque: float
    rated_speed: float
    free_speed: float
    breakdown: float | None = None
    most: float | None = None
    starting: float | None = None

    def __post_init__(self) -> None:
        _check("rated torque of a motor", self.rated_torque)
        _check("rated speed of a motor", self.rated_speed)
        if not (isfinite(self.free_speed) and self.free_speed > self.rated_speed):
            raise LinkageError(
                "the speed of a motor without load lies above its rated speed, "
                f"{self.rated_speed:g} rad/s, not at {self.free_speed:g}"
            )
        if self.breakdown is not None and not (isfinite(self.breakdown) and self.breakdown > 1.0):
            raise LinkageError(
                "the breakdown torque of a motor lies above its rated torque, not at "
                f"{self.breakdown:g} of it"
            )
        if self.most is not None:
            _check("torque limit of a motor", self.most)
            if self.breakdown is not None:
                raise LinkageError("a motor has a breakdown torque or a torque limit, not both")
        if self.starting is not None:
            _check("starting torque of a motor", self.starting)
            if self.breakdown is None:
                raise LinkageError("only a motor with a breakdown torque has a starting torque")
            if self.starting > self.breakdown:
                raise LinkageError(
                    "the starting torque of a motor is at most its breakdown torque, "
                    f"{self.breakdown:g} of the rated one, not {self.starting:g}"
                )

    @property
    def rated_slip(self) -> float:
        """Slip at the rated speed."""
        return 1.0 - self.rated_speed / self.free_speed

    @property
    def corners(self) -> tuple[float, ...]:
        """Speeds, rad/s, at which the slope of the torque jumps."""
        if self.starting is not None and self.breakdown is not None:
            most = self.rated_slip * (self.breakdown + sqrt(self.breakdown**2 - 1.0))
            return ((1.0 - most) * self.free_speed,) if most < 1.0 else ()
        if self.most is None:
            return ()
        share = self.most / self.rated_torque * self.rated_slip
        return tuple(self.free_speed * end for end in (1.0 - share, 1.0 + share) if end > 0.0)

    @property
    def largest_torque(self) -> float:
        """Largest torque, N mm."""
        if self.breakdown is not None:
            return self.breakdown * self.rated_torque
        stall = self.rated_torque / self.rated_slip
        return stall if self.most is None else min(self.most, stall)

    def torque(self, speed: float) -> tuple[float, float]:
        """Torque at a speed, N mm, and its derivative, N mm s."""
        slip, per_slip = 1.0 - speed / self.free_speed, -1.0 / self.free_speed
        if self.breakdown is None:
            line = self.rated_torque * slip / self.rated_slip
            if abs(line) >= self.largest_torque:
                return (self.largest_torque if line > 0 else -self.largest_torque), 0.0
            return line, self.rated_torque / self.rated_slip * per_slip
        most = self.rated_slip * (self.breakdown + sqrt(self.breakdown**2 - 1.0))
        if self.starting is not None and slip > most:
            rise = (self.breakdown - self.starting) / (1.0 - most) * self.rated_torque
            return self.largest_torque - rise * (slip - most), -rise * per_slip
        twice, below = 2.0 * self.largest_torque * most, slip**2 + most**2
        return twice * slip / below, twice * (most**2 - slip**2) / below**2 * per_slip


@dataclass(frozen=True)
class Geared:
    """A motor behind a gear, as the coordinate that it turns sees it.

    ratio       speed of the motor over the coordinate's
    efficiency  of the gear, above 0 up to 1, whichever way the power goes
    inertia     t mm2, of the rotor, at its own speed
    """

    motor: Motor
    ratio: float = 1.0
    efficiency: float = 1.0
    inertia: float = 0.0

    def __post_init__(self) -> None:
        _check("gear ratio of a motor", self.ratio)
        if not 0.0 < self.efficiency <= 1.0:
            raise LinkageError(
                f"the efficiency of a gear is above 0 and at most 1, not {self.efficiency:g}"
            )
        if not (isfinite(self.inertia) and self.inertia >= 0.0):
            raise LinkageError(f"the inertia of a rotor is not negative, got {self.inertia:g}")

    @property
    def free_speed(self) -> float:
        """Speed of the coordinate without load, rad/s."""
        return self.motor.free_speed / self.ratio

    @property
    def largest_torque(self) -> float:
        """Largest torque on the coordinate, N mm."""
        return self.motor.largest_torque * self.ratio * self.efficiency

    @property
    def reflected(self) -> float:
        """Inertia of the rotor about the coordinate, t mm2."""
        return self.inertia * self.ratio**2

    def torque(self, speed: float) -> tuple[float, float]:
        """Torque on the coordinate at its speed, N mm, and its derivative, N mm s."""
        own, slope = self.motor.torque(speed * self.ratio)
        gear = self.ratio * (self.efficiency if own > 0.0 else 1.0 / self.efficiency)
        return gear * own, gear * slope * self.ratio


if TYPE_CHECKING:
    from scipy.interpolate import BPoly


@dataclass(frozen=True)
class SteadyPace:
    """A coordinate that changes at a speed, which may itself rise or fall evenly.

    speed         mm/s or rad/s at the start of the cycle, a magnitude: its sign follows the phase
    acceleration  mm/s2 or rad/s2 along the way; above 0 the speed rises
    falling       mm/s or rad/s in phases in which the coordinate falls; None: `speed` there, too
    cushion       mm before the end of every stroke (phases in one direction) along which the speed
                  falls evenly over the time to rest; a phase begins there (`split_cycle`)
    """

    coordinate: Coordinate
    speed: float
    acceleration: float = 0.0
    falling: float | None = None
    cushion: float = 0.0

    def __post_init__(self) -> None:
        for speed in (self.speed, self.speed if self.falling is None else self.falling):
            if not (isfinite(speed) and speed > 0.0):
                raise LinkageError(
                    f"the speed of {self.coordinate.label} must be above 0, got {speed:g}"
                )
        if self.falling is not None and self.acceleration:
            raise LinkageError(
                f"{self.coordinate.label} has a speed for each direction and an acceleration"
            )
        if not isfinite(self.acceleration):
            raise LinkageError(f"the acceleration of {self.coordinate.label} must be finite")
        if not (isfinite(self.cushion) and self.cushion >= 0.0):
            raise LinkageError(f"a cushion is not negative, got {self.cushion:g}")
        if self.cushion and self.acceleration:
            raise LinkageError(f"{self.coordinate.label} has a cushion and an acceleration")

    def times(self, factor: float) -> "SteadyPace":
        """The same way in a time that is shorter by a factor."""
        falling = None if self.falling is None else factor * self.falling
        return replace(
            self,
            speed=factor * self.speed,
            acceleration=factor**2 * self.acceleration,
            falling=falling,
        )


@dataclass(frozen=True)
class StrokePace:
    """A coordinate led from rest to rest in every stroke (phases in one direction) of the cycle.

    law   harmonic, cycloidal, or polynomial (3-4-5): share of the way over share of the time
          (Norton, Design of Machinery, ch. 8)
    time  s, of each stroke
    """

    coordinate: Coordinate
    law: str
    time: float

    def __post_init__(self) -> None:
        if self.law not in STROKE_LAWS:
            raise LinkageError(f"the law of a stroke is one of {STROKE_LAWS}, not {self.law!r}")
        if not (isfinite(self.time) and self.time > 0.0):
            raise LinkageError(f"the time of a stroke must be above 0, got {self.time:g}")


@dataclass(frozen=True)
class MotorPace:
    """An angle that a motor turns over and over, as fast as the linkage lets it.

    steady   the angle and a speed to begin with
    inertia  t mm2, of all that turns with it besides linkage and rotor
    """

    steady: SteadyPace
    motor: Geared
    inertia: float = 0.0

    def __post_init__(self) -> None:
        if not self.coordinate.angular:
            raise LinkageError(f"a motor turns an angle, not {self.coordinate.label}")
        if self.steady.acceleration:
            raise LinkageError(
                f"the acceleration of {self.coordinate.label} follows from its motor"
            )
        if not (isfinite(self.inertia) and self.inertia >= 0.0):
            raise LinkageError(f"the inertia of a flywheel is not negative, got {self.inertia:g}")

    @property
    def coordinate(self) -> Coordinate:
        """The angle that the motor turns."""
        return self.steady.coordinate


@dataclass(frozen=True, eq=False)
class RunPace:
    """A coordinate that goes once through a cycle, at solved speeds (`loads/events.py`).

    inertia  t mm2, of all that turns with it besides the bodies
    knots    per phase (n, 4), rows of time s, way since the start rad, speed rad/s and acceleration
             rad/s2; between them the way is the polynomial of degree 5 over the time through both
    """

    coordinate: Coordinate
    inertia: float
    knots: tuple[FloatArray, ...]

    def rates(self, k: int, way: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Speed and acceleration (n,) at ways in phase k."""
        over = self._over(k)
        times = self.times(k, way)
        return np.maximum(over(times, 1), 0.0), np.asarray(over(times, 2))

    def times(self, k: int, way: FloatArray) -> FloatArray:
        """Time since the start of the cycle (n,), s: bisection of the way, which rises."""
        times, ways = self.knots[k][:, 0], self.knots[k][:, 1]
        way = np.asarray(way, dtype=float)
        index = np.clip(np.searchsorted(ways, way, side="right") - 1, 0, len(ways) - 2)
        low, high, over = times[index], times[index + 1], self._over(k)
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            short = over(middle) < way
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        return np.asarray(0.5 * (low + high))

    def _over(self, k: int) -> "BPoly":
        from scipy.interpolate import BPoly  # half a second that few linkages need

        times, ways, speeds, accelerations = self.knots[k].T
        h = np.diff(times)
        slopes, bends = speeds / 5.0, accelerations / 20.0
        # the Bernstein coefficients of a polynomial with way, speed and acceleration at both ends
        ordinates = [
            ways[:-1],
            ways[:-1] + slopes[:-1] * h,
            ways[:-1] + 2.0 * slopes[:-1] * h + bends[:-1] * h**2,
            ways[1:] - 2.0 * slopes[1:] * h + bends[1:] * h**2,
            ways[1:] - slopes[1:] * h,
            ways[1:],
        ]
        return BPoly(np.array(ordinates), times)


Pace = SteadyPace | StrokePace | MotorPace | RunPace


def stroke_law(law: str, tau: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return share of the way, its rate and the rate's rate, at shares of the time (0 to 1)."""
    tau = np.asarray(tau, dtype=float)
    turn = 2.0 * np.pi * tau
    if law == "harmonic":
        half = np.pi * tau
        return (
            np.sin(half / 2.0) ** 2,
            np.pi / 2.0 * np.sin(half),
            np.pi**2 / 2.0 * np.cos(half),
        )
    if law == "cycloidal":
        return tau - np.sin(turn) / (2.0 * np.pi), 1.0 - np.cos(turn), 2.0 * np.pi * np.sin(turn)
    return (
        tau**3 * (10.0 - 15.0 * tau + 6.0 * tau**2),
        30.0 * tau**2 * (1.0 - tau) ** 2,
        60.0 * tau * (1.0 - 3.0 * tau + 2.0 * tau**2),
    )


def stroke_time(law: str, share: FloatArray) -> FloatArray:
    """Return the share of the time at which a law has gone these shares of the way (bisection)."""
    share = np.clip(np.asarray(share, dtype=float), 0.0, 1.0)
    low, high = np.zeros_like(share), np.ones_like(share)
    for _ in range(60):
        middle = 0.5 * (low + high)
        short = stroke_law(law, middle)[0] < share
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    result: FloatArray = np.where(
        share == 0.0, 0.0, np.where(share == 1.0, 1.0, 0.5 * (low + high))
    )
    return result


def _check(name: str, value: float) -> None:
    if not (isfinite(value) and value > 0.0):
        raise LinkageError(f"the {name} must be above 0, got {value:g}")


# A cycle as it is stated: a coordinate swept phase after phase, each under forces of its own.


@dataclass(frozen=True)
class Phase:
    """A part of the cycle: up to which value, under which forces, solving for which one.

    stop   mm or rad, of the cycle's coordinate
    begin  the same where it starts; None: where the phase before stops
    given  the law of each force, by name: N or N mm where it is constant; every force is either
           given or solved for
    """

    name: str
    stop: float
    given: Mapping[str, Law]
    solve: str
    begin: float | None = None


@dataclass(frozen=True)
class Cycle:
    """Cycle of a linkage: a coordinate swept from start through the stops of the phases.

    pace         the coordinate that sets the time; its direction follows the phase
    n_positions  at least, over all phases
    """

    name: str
    coordinate: Coordinate
    start: float
    pace: Pace
    phases: tuple[Phase, ...]
    n_positions: int = 361

    def __post_init__(self) -> None:
        owner = f"cycle {self.name!r}"
        if not self.phases:
            raise LinkageError(f"{owner}: has no phases")
        if self.n_positions < 2:
            raise LinkageError(f"{owner}: needs at least 2 positions, got {self.n_positions}")
        names = [phase.name for phase in self.phases]
        for name in names:
            if names.count(name) > 1:
                raise LinkageError(f"{owner}: two phases are named {name!r}")
        for phase, (start, stop) in zip(self.phases, self.spans, strict=True):
            if not (isfinite(start) and isfinite(stop)) or start == stop:
                raise LinkageError(
                    f"{owner}, phase {phase.name!r}: goes from {start:g} to {stop:g}, "
                    "a phase must move"
                )

    @property
    def spans(self) -> tuple[tuple[float, float], ...]:
        """Start and stop of each phase."""
        before = [self.start, *(phase.stop for phase in self.phases[:-1])]
        return tuple(
            (stop if phase.begin is None else phase.begin, phase.stop)
            for stop, phase in zip(before, self.phases, strict=True)
        )
