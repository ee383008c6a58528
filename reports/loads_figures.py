"""What is told of one cycle's loads: extremes, drives and contacts, as plain data."""

from dataclasses import dataclass
from math import isfinite
from typing import Any


@dataclass(frozen=True)
class Extremes:
    """Least and largest value of one quantity over a cycle, and where.

    low, high, mean  N or N mm (`angular`); the mean is over time
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
    """What a joint does to the body `on`; `by` gets the opposite."""

    name: str
    kind: str
    on: str
    by: str
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

    reduced_inertia, flywheel  t mm2; ripple N mm; None unless the cycle is closed and turns
    irregularity               (fastest - slowest) / mean speed; infinite without any mass
    allowed                    the irregularity that the flywheel, inertia in all, is for
    """

    name: str
    angular: bool
    directions: tuple[Direction, ...]
    mean_power: float
    peak_power: float
    work: float
    reduced_inertia: float | None
    ripple: float | None
    irregularity: float | None
    flywheel: float | None
    allowed: float


@dataclass(frozen=True)
class ContactSummary:
    """Where a force touches; position as shown, N, mm (or N mm, rad), N mm of energy."""

    name: str
    angular: bool
    first_at: float | None
    last_at: float | None
    phase: str
    largest: float
    deflection: float
    approach_speed: float
    energy: float


@dataclass(frozen=True)
class ShownPhase:
    """A phase in words: from and to as shown, which force it solves for, the law of the others."""

    name: str
    start: float
    stop: float
    solve: str
    given: tuple[str, ...]


def plain_fields(item: Any) -> dict[str, Any]:
    """The fields of a small dataclass as plain data; None for what is not finite."""
    return {name: _plain(getattr(item, name)) for name in item.__dataclass_fields__}


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "__dataclass_fields__"):
        return plain_fields(value)
    if isinstance(value, float):
        return value if isfinite(value) else None
    return value
