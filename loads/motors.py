"""Torque of a motor over its speed, at the coordinate that it turns.

Asynchronous: Kloss' formula T = 2 T_b / (s / s_b + s_b / s), slip s = 1 - speed / synchronous
speed, T_b the breakdown torque, s_b its slip; through the rated torque at the rated slip s_r it is
s_b = s_r (b + sqrt(b^2 - 1)), b = T_b / T_r (the root beyond the rated slip). Without a breakdown
torque, as direct current and servos: a straight line through the rated point and the speed without
load, cut at the torque that the controller lets through.

From rest an asynchronous motor differs from Kloss' formula, as currents crowd in its rotor's bars.
With its torque at standstill stated, below the breakdown speed a straight line over the speed leads
from there to the breakdown torque; a saddle between them is left out.
"""

from dataclasses import dataclass
from math import isfinite, sqrt

from loads.bodies import LinkageError


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


def _check(name: str, value: float) -> None:
    if not (isfinite(value) and value > 0.0):
        raise LinkageError(f"the {name} must be above 0, got {value:g}")
