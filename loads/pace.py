"""Timing of a cycle: the rate of one coordinate along its way."""

from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING, Final

import numpy as np

from loads.bodies import FloatArray, LinkageError
from loads.joints import Coordinate
from loads.motors import Geared

if TYPE_CHECKING:
    from scipy.interpolate import BPoly

_BISECTIONS = 52
STROKE_LAWS: Final = ("harmonic", "cycloidal", "polynomial")


@dataclass(frozen=True)
class SteadyPace:
    """A coordinate that changes at a speed, which may itself rise or fall evenly.

    speed         mm/s or rad/s at the start of the cycle, a magnitude: its sign follows the phase
    acceleration  mm/s2 or rad/s2 along the way; above 0 the speed rises
    """

    coordinate: Coordinate
    speed: float
    acceleration: float = 0.0

    def __post_init__(self) -> None:
        if not (isfinite(self.speed) and self.speed > 0.0):
            raise LinkageError(
                f"the speed of {self.coordinate.label} must be above 0, got {self.speed:g}"
            )
        if not isfinite(self.acceleration):
            raise LinkageError(f"the acceleration of {self.coordinate.label} must be finite")


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
