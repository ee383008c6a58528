"""A cycle as it is stated: a coordinate swept phase after phase, each under forces of its own."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite

from loads.bodies import LinkageError
from loads.joints import Coordinate
from loads.laws import Law
from loads.pace import Pace


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
