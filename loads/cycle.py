"""A cycle of a linkage: the positions it goes through, phase by phase, and the loads there."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil, isfinite

import numpy as np

from loads.bodies import FloatArray, LinkageError
from loads.cycle_loads import CycleLoads
from loads.elements import Coordinate
from loads.forces import ForceSolution, JointLoad, solve_forces
from loads.laws import Law
from loads.linkage import Linkage
from loads.motion import Motion, Path, move, trace
from loads.pace import Pace

_LEAST_PER_PHASE = 20
_COARSE = 201  # positions per phase that find where the loads change


@dataclass(frozen=True)
class Phase:
    """A part of the cycle: up to which value, under which forces, solving for which one.

    stop   mm or rad, of the cycle's coordinate
    given  the law of each force, by name: N or N mm where it is constant; every force is either
           given or solved for
    """

    name: str
    stop: float
    given: Mapping[str, Law]
    solve: str


@dataclass(frozen=True)
class Cycle:
    """What a linkage does: a coordinate swept from start through the stops of the phases.

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
        """Where each phase starts and stops."""
        stops = [phase.stop for phase in self.phases]
        return tuple(zip([self.start, *stops[:-1]], stops, strict=True))


def run_cycle(linkage: Linkage, cycle: Cycle) -> CycleLoads:
    """Return motion and loads at every position of a cycle.

    Each phase holds both its ends, so that a border appears twice, before and after a jump of the
    forces. Positions lie closer where the loads change faster.
    """
    ends = [cycle.start, *(phase.stop for phase in cycle.phases)]
    path = trace(linkage, cycle.coordinate, min(ends), max(ends))
    grids = [np.linspace(start, stop, _COARSE) for start, stop in cycle.spans]
    # the second time, what the first grid has stepped over is seen
    for _ in range(2):
        solved = [_solve(path, cycle, k, grid) for k, grid in enumerate(grids)]
        grids = _placed(cycle, grids, [solution for _, solution in solved])
    motions, solutions = zip(
        *(_solve(path, cycle, k, grid) for k, grid in enumerate(grids)), strict=True
    )
    return _joined(linkage, cycle, motions, solutions)


def _solve(path: Path, cycle: Cycle, k: int, grid: FloatArray) -> tuple[Motion, ForceSolution]:
    phase = cycle.phases[k]
    try:
        motion = move(
            path.at(grid),
            cycle.pace.coordinate,
            cycle.pace.speed,
            1 if grid[-1] > grid[0] else -1,
        )
        return motion, solve_forces(motion, phase.given, phase.solve)
    except LinkageError as error:
        raise LinkageError(f"cycle {cycle.name!r}, phase {phase.name!r}: {error}") from None


def _placed(
    cycle: Cycle, grids: list[FloatArray], solutions: list[ForceSolution]
) -> list[FloatArray]:
    """Return grids on which every step has the same share of the way plus the change of loads."""
    ways = [np.abs(np.diff(grid)) for grid in grids]
    changes = [np.linalg.norm(np.diff(s.vector, axis=0), axis=1) for s in solutions]
    way, change = (sum(float(part.sum()) for part in parts) for parts in (ways, changes))
    result = []
    for grid, step, jump in zip(grids, ways, changes, strict=True):
        monitor = step / way + (jump / change if change else 0.0)
        amount = monitor.sum() / (2.0 if change else 1.0)
        count = max(_LEAST_PER_PHASE, ceil(amount * cycle.n_positions))
        summed = np.concatenate([[0.0], np.cumsum(monitor)])
        placed = np.interp(np.linspace(0.0, summed[-1], count), summed, grid)
        placed[0], placed[-1] = grid[0], grid[-1]
        result.append(placed)
    return result


def _joined(
    linkage: Linkage,
    cycle: Cycle,
    motions: tuple[Motion, ...],
    solutions: tuple[ForceSolution, ...],
) -> CycleLoads:
    times, clock = [], 0.0
    for motion in motions:
        pace = motion.kinematics.value(cycle.pace.coordinate, motion.poses)
        times.append(clock + np.abs(pace - pace[0]) / cycle.pace.speed)
        clock = float(times[-1][-1])
    reactions = {
        joint.name: JointLoad(
            *(
                np.concatenate([getattr(s.joints[joint.name], part) for s in solutions])
                for part in ("force", "moment", "friction_couple", "friction_force")
            )
        )
        for joint in linkage.joints
    }
    return CycleLoads(
        linkage=linkage,
        name=cycle.name,
        positions=np.concatenate([motion.values for motion in motions]),
        times=np.concatenate(times),
        phases=tuple(phase.name for phase in cycle.phases),
        phase_of=np.repeat(np.arange(len(motions)), [len(m.values) for m in motions]),
        poses=np.concatenate([motion.poses for motion in motions]),
        velocities=np.concatenate([motion.velocities for motion in motions]),
        accelerations=np.concatenate([motion.accelerations for motion in motions]),
        reactions=reactions,
        efforts={
            force.name: np.concatenate([s.efforts[force.name] for s in solutions])
            for force in linkage.forces
        },
        conditioning=np.concatenate([s.conditioning for s in solutions]),
    )
