"""A cycle of a linkage: the positions it goes through, phase by phase, and the loads there.

A linkage whose points, joints and pace stay moves as before, whatever its bodies weigh and its
forces are; only the forces at its positions must be solved for again. The positions stay those that
were placed for the loads they were solved with first, closest where these turned fast, and hold
both ends of every phase and the corners of its tables whatever the loads.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from functools import partial
from math import ceil

import numpy as np

from loads.bodies import FloatArray, LinkageError, Prismatic, Slot, shared_points
from loads.contact import (
    Touch,
    contact_gaps,
    coordinate_speed,
    solve_laws,
    with_extremes,
    with_roots,
)
from loads.cycle_loads import CycleLoads, unresolved
from loads.elasticity import check_compliance, second_order
from loads.forces import ForceSolution, one_after_another
from loads.kinematics import Kinematics
from loads.laws import Contact, Expression, Law, Opposing, Table, crests, kinks, steps
from loads.linkage import Linkage
from loads.motion import Geometry, Motion, move
from loads.pace import Cycle, MotorPace, SteadyPace
from loads.path import Path, geometry_of, trace
from loads.running import Timing, driven_by, running
from loads.turning import with_points

_LEAST_PER_PHASE = 20
_LARGEST = 1e30  # N; squares and cubes of what is larger leave the range of numbers
_COARSE = 201  # positions per phase that find where the loads change
Rates = tuple[FloatArray, FloatArray]  # speed and acceleration (n,) of the pace


class CycleError(LinkageError):
    """A phase of a cycle that cannot be, and the reason."""

    def __init__(self, cycle: str, phase: int, phase_name: str, problem: str) -> None:
        super().__init__(cycle, phase, phase_name, problem)
        self.cycle, self.phase, self.phase_name, self.problem = cycle, phase, phase_name, problem

    def __str__(self) -> str:
        return f"cycle {self.cycle!r}, phase {self.phase_name!r}: {self.problem}"


def run_cycle(linkage: Linkage, cycle: Cycle) -> CycleLoads:
    """Return motion and loads at every position of a cycle.

    Each phase holds both its ends, so that a border appears twice, before and after a jump of the
    forces. Positions lie closer where the loads change faster; where a table has a corner and where
    a contact begins or ends there is one, too.
    Raises LinkageError, which names the phase, where the cycle cannot be.
    """
    run = begun(linkage, cycle)
    if isinstance(cycle.pace, MotorPace):
        run = run.at_motors_speed(cycle.pace)
    grids = _coarse(cycle)
    # the second time, what the first grid has stepped over is seen
    tried: list[list[Stretch]] = []
    for _ in range(2):
        tried.append([run.solve(k, grid) for k, grid in enumerate(grids)])
        grids = _placed(
            run.path.kinematics, cycle, grids, [stretch.solution for stretch in tried[-1]]
        )
    stretches = [run.solve(k, run.with_corners(k, grid)) for k, grid in enumerate(grids)]
    return _joined(linkage, cycle, run.timing, stretches, tried)


def run_at_rates(
    known: CycleLoads, cycle: Cycle, factor: float, surge: FloatArray | None = None
) -> CycleLoads:
    """Return the loads of a cycle that was run before, at the same positions, at other rates.

    factor  of the speed of its pace
    surge   (n,) 1/s: acceleration of the pace along its way, over its speed; none: as the pace has

    `unresolved` stays what the known loads have. Raises LinkageError as `run_cycle` does, and where
    the pace is not a steady one.
    """
    pace = cycle.pace
    if not isinstance(pace, SteadyPace):
        raise LinkageError(f"cycle {cycle.name!r}: its pace is not steady")
    faster = replace(cycle, pace=pace.times(factor))
    run = begun(known.linkage, faster)
    stretches = []
    for k in range(len(cycle.phases)):
        rows = known.phase_of == k
        grid = known.positions[rows]
        rates = None
        if surge is not None:
            speed, acceleration = run.timing.rates(k, run.path.at(grid))
            rates = speed, acceleration + surge[rows] * speed
        stretches.append(run.solve(k, grid, rates))
    again = _joined(known.linkage, faster, run.timing, stretches, [])
    return replace(again, unresolved=known.unresolved)


def run_at_positions(known: CycleLoads, linkage: Linkage, cycle: Cycle) -> CycleLoads:
    """Return the loads of a cycle at the positions of one that was run before.

    linkage  differs from the known one in masses and compliances only

    `unresolved` stays what the known loads have; a contact may begin beside its position. Raises
    LinkageError as `run_cycle` does.
    """
    run = begun(linkage, cycle)
    if isinstance(cycle.pace, MotorPace):
        run = run.at_motors_speed(cycle.pace)
    grids = [known.positions[known.phase_of == k] for k in range(len(cycle.phases))]
    stretches = [run.solve(k, grid) for k, grid in enumerate(grids)]
    return replace(_joined(linkage, cycle, run.timing, stretches, []), unresolved=known.unresolved)


def try_cycle(linkage: Linkage, cycle: Cycle) -> None:
    """Raise LinkageError where a cycle cannot be, as far as some 200 positions per phase tell.

    It takes a fraction of the time of `run_cycle`, which tells the rest: a motor's, too.
    """
    run = begun(linkage, cycle)
    for k, grid in enumerate(_coarse(cycle)):
        run.solve(k, grid)


def begun(linkage: Linkage, cycle: Cycle) -> "Run":
    """Return the path of a cycle and its timing; a motor's speed is not solved yet."""
    check_compliance(linkage)
    ends = [end for span in cycle.spans for end in span]
    path = trace(linkage, cycle.coordinate, min(ends), max(ends))
    return Run(path, cycle, Timing(path, cycle.pace, cycle.spans))


def _coarse(cycle: Cycle) -> list[FloatArray]:
    return [np.linspace(start, stop, _COARSE) for start, stop in cycle.spans]


@dataclass(frozen=True, eq=False)
class Stretch:
    """One phase, solved."""

    motion: Motion
    solution: ForceSolution
    touches: Mapping[str, Touch]


@dataclass(frozen=True, eq=False)
class Run:
    """Path and timing that all phases of a cycle are solved with."""

    path: Path
    cycle: Cycle
    timing: Timing

    def solve(self, k: int, grid: FloatArray, rates: Rates | None = None) -> Stretch:
        """Return phase k at the positions of a grid; rates other than the timing's, if any."""
        return self.solve_at(k, self.path.at(grid), rates)

    def solve_at(self, k: int, geometry: Geometry, rates: Rates | None) -> Stretch:
        """Return phase k at the positions of a geometry; rates other than the timing's, if any."""
        phase = self.cycle.phases[k]
        with self._told_of(k):
            motion = self._motion(k, geometry, rates)
            stretch = Stretch(*solve_laws(motion, phase.given, phase.solve))
            _check_sizes(stretch)
        return stretch

    def at_motors_speed(self, pace: MotorPace) -> "Run":
        """Return the run at the speeds at which the motor turns the linkage."""
        places = self.places()
        ways = [self.timing.way(k, geometry) for k, geometry in enumerate(places)]
        levers = driven_by(self.cycle, self.path.kinematics, places)

        def demand(k: int, squares: FloatArray, accelerations: FloatArray) -> FloatArray:
            stretch = self.solve_at(k, places[k], (np.sqrt(squares), accelerations))
            return levers[k] * stretch.solution.efforts[self.cycle.phases[k].solve]

        solved = running(
            demand,
            ways,
            pace.motor,
            pace.inertia,
            pace.steady.speed,
            lambda k, i: places[k].place(i),
        )
        return replace(self, timing=Timing(self.path, pace, self.cycle.spans, solved))

    def places(self) -> list[Geometry]:
        """Positions (3 m + 1,) of each phase, `with_points`, that follow its loads closely."""
        fine = replace(self.cycle, n_positions=_COARSE)
        grids = _coarse(self.cycle)
        solutions = [self.solve(k, grid).solution for k, grid in enumerate(grids)]
        placed = _placed(self.path.kinematics, fine, grids, solutions)
        grids = [self.with_corners(k, g) for k, g in enumerate(placed)]
        return [self.path.at(with_points(grid)) for grid in grids]

    @contextmanager
    def _told_of(self, k: int) -> Iterator[None]:
        """Say of an error in which phase it is."""
        try:
            yield
        except LinkageError as error:
            raise CycleError(self.cycle.name, k, self.cycle.phases[k].name, str(error)) from None

    def _motion(self, k: int, geometry: Geometry, rates: Rates | None = None) -> Motion:
        _check_ends(self.path.kinematics.linkage, geometry)
        speed, acceleration = self.timing.rates(k, geometry) if rates is None else rates
        direction = 1 if geometry.values[-1] > geometry.values[0] else -1
        return move(geometry, self.cycle.pace.coordinate, speed, direction, acceleration)

    def with_corners(self, k: int, grid: FloatArray) -> FloatArray:
        """Return the grid of phase k with the corners of its laws put in.

        Corners of tables, over a coordinate or a speed; kinks, peaks and steps of formulas; where
        a contact begins, ends, starts to push, and comes nearest.
        """
        for name, law in self.cycle.phases[k].given.items():
            if isinstance(law, Table):
                grid = with_extremes(grid, partial(self._above, law, [0.0]))
                if len(law.values) > 2:
                    grid = with_roots(grid, partial(self._above, law, law.values[1:-1]))
            elif isinstance(law, Expression):
                for terms in (crests, kinks):
                    grid = with_extremes(grid, partial(self._terms, k, law, terms))
                for terms in (kinks, steps):
                    grid = with_roots(grid, partial(self._terms, k, law, terms))
            elif isinstance(law, Contact):
                grid = with_extremes(grid, partial(self._gaps, k, name))
                grid = with_roots(grid, partial(self._gaps, k, name))
            elif isinstance(law, Opposing) and law.speeds:
                grid = with_extremes(grid, partial(self._speeds, k, name, law))
                grid = with_roots(grid, partial(self._speeds, k, name, law))
        return grid

    def _above(self, table: Table, corners: Sequence[float], grid: FloatArray) -> FloatArray:
        """A table's coordinate (m, n) above each of some corners."""
        value = self.path.kinematics.value(table.coordinate, self.path.poses_at(grid))
        return np.array([value - corner for corner in corners])

    def _terms(
        self,
        k: int,
        law: Expression,
        terms: Callable[[Motion, Expression], FloatArray],
        grid: FloatArray,
    ) -> FloatArray:
        return terms(self._motion(k, self.path.at(grid)), law)

    def _speeds(self, k: int, name: str, law: Opposing, grid: FloatArray) -> FloatArray:
        """Speed (m, n) of a force's own coordinate above each corner of its table."""
        speed = coordinate_speed(self._motion(k, self.path.at(grid)), name)
        return np.array([speed - corner for corner in law.speeds[1:]])

    def _gaps(self, k: int, name: str, grid: FloatArray) -> FloatArray:
        """Gap and lift (2, n) of a contact at the positions of a grid, mm."""
        phase = self.cycle.phases[k]
        with self._told_of(k):
            return contact_gaps(self._motion(k, self.path.at(grid)), phase.given, phase.solve, name)


def _check_sizes(stretch: Stretch) -> None:
    """Raise where forces are of no size that can be computed with."""
    sizes = np.abs(stretch.solution.vector).max(axis=1)
    if not (sizes < _LARGEST).all():
        k = int(np.argmax(~(sizes < _LARGEST)))
        raise LinkageError(
            f"the forces reach {sizes[k]:.3g} N at {stretch.motion.place(k)}, at most "
            f"{_LARGEST:g} N can be computed with: is a unit or an exponent wrong?"
        )


def _check_ends(linkage: Linkage, geometry: Geometry) -> None:
    """Raise where a pin has left its slot."""
    for joint in linkage.joints:
        if not isinstance(joint, Prismatic | Slot) or joint.ends is None:
            continue
        travel = geometry.kinematics.travel(geometry.poses, joint)
        low, high = joint.ends
        slack = 1e-9 * geometry.kinematics.size
        outside = (travel < low - slack) | (travel > high + slack)
        if outside.any():
            k = int(np.argmax(np.maximum(low - travel, travel - high)))
            raise LinkageError(
                f"joint {joint.name!r}: its point {joint.point_b!r} slides beyond the end of "
                f"{low:g} ... {high:g} mm, up to {travel[k]:.5g} mm at {geometry.place(k)}"
            )


def _placed(
    kinematics: Kinematics,
    cycle: Cycle,
    grids: list[FloatArray],
    solutions: list[ForceSolution],
) -> list[FloatArray]:
    """Return grids on which every step has the same share of the way plus the change of loads."""
    ways = [np.abs(np.diff(grid)) for grid in grids]
    changes = [_changes(kinematics, solution) for solution in solutions]
    way, change = (sum(float(part.sum()) for part in parts) for parts in (ways, changes))
    result = []
    for grid, step, jump in zip(grids, ways, changes, strict=True):
        monitor = step / way + (jump / change if change else 0.0)
        amount = monitor.sum() / (2.0 if change else 1.0)
        # less round-off, which would make one position more of it in one unit and not in another
        count = max(_LEAST_PER_PHASE, ceil(amount * cycle.n_positions - 1e-9))
        summed = np.concatenate([[0.0], np.cumsum(monitor)])
        placed = np.interp(np.linspace(0.0, summed[-1], count), summed, grid)
        placed[0], placed[-1] = grid[0], grid[-1]
        result.append(placed)
    return result


def _changes(kinematics: Kinematics, solution: ForceSolution) -> FloatArray:
    """Return the change of all reactions (n - 1,) from position to position, N.

    A point where three bodies and more are pinned or welded counts by half the squares of its loads
    on them, as one of two does whose load counts once: what its joints hold depends on which bodies
    they pair.
    """
    squares = np.sum(np.diff(solution.vector, axis=0) ** 2, axis=1)
    for point in shared_points(kinematics.linkage.joints):
        if len(point) < 2:
            continue
        on: dict[str, FloatArray] = {}
        for joint in point:
            load = solution.joints[joint.name]
            couple = load.moment / kinematics.size  # of a weld; that of a pin's friction is apart
            step = np.diff(np.column_stack([load.force, couple]), axis=0)
            squares -= np.sum(step**2, axis=1)
            for body, sign in ((joint.body_a, -1.0), (joint.body_b, 1.0)):
                on[body] = on.get(body, 0.0) + sign * step
        squares += sum(np.sum(step**2, axis=1) for step in on.values()) / 2
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)))


def _joined(
    linkage: Linkage,
    cycle: Cycle,
    timing: Timing,
    stretches: list[Stretch],
    tried: list[list[Stretch]],
) -> CycleLoads:
    motions = [stretch.motion for stretch in stretches]
    solutions = [stretch.solution for stretch in stretches]
    whole = one_after_another(solutions)
    return CycleLoads(
        linkage=linkage,
        name=cycle.name,
        swept=cycle.coordinate,
        pace=cycle.pace.coordinate,
        solved=tuple(phase.solve for phase in cycle.phases),
        positions=np.concatenate([motion.values for motion in motions]),
        times=np.concatenate([timing.times(k, motion) for k, motion in enumerate(motions)]),
        phases=tuple(phase.name for phase in cycle.phases),
        phase_of=np.repeat(np.arange(len(motions)), [len(m.values) for m in motions]),
        poses=np.concatenate([motion.poses for motion in motions]),
        velocities=np.concatenate([motion.velocities for motion in motions]),
        accelerations=np.concatenate([motion.accelerations for motion in motions]),
        heading=np.concatenate([motion.heading for motion in motions]),
        reactions=whole.joints,
        efforts={force.name: whole.efforts[force.name] for force in linkage.forces},
        touches=_touches(stretches),
        second_order=max(
            (
                second_order(
                    stretch.motion, stretch.solution, phase.solve, stretch.touches[name].touching
                )
                for stretch, phase in zip(stretches, cycle.phases, strict=True)
                for name in stretch.touches
            ),
            default=0.0,
        ),
        unresolved=unresolved(_solved(stretches), [_solved(other) for other in tried]),
    )


def _solved(stretches: list[Stretch]) -> list[tuple[Motion, ForceSolution]]:
    return [(stretch.motion, stretch.solution) for stretch in stretches]


def _touches(stretches: list[Stretch]) -> dict[str, Touch]:
    """Return the contacts over the whole cycle; in a phase without it, a contact is open."""
    result = {}
    for name in dict.fromkeys(name for stretch in stretches for name in stretch.touches):
        parts = []
        for stretch in stretches:
            n = len(stretch.motion.values)
            far, none = np.full(n, np.inf), np.zeros(n)
            open_ = Touch(np.zeros(n, dtype=bool), far, far, none, none)
            parts.append(stretch.touches.get(name, open_))
        result[name] = Touch(
            *(
                np.concatenate([getattr(part, field.name) for part in parts])
                for field in fields(Touch)
            )
        )
    return result


def moves_alike(known: Linkage, cycle: Cycle, other: Linkage, other_cycle: Cycle) -> bool:
    """Return True if a linkage goes through a cycle as a known one does, at the same positions.

    Masses, gravity, friction and constant forces may differ. False for cycles with a contact, which
    holds bodies still by an amount that depends on the forces, and for those that a motor turns.
    """
    if _has_contact(cycle) or _has_contact(other_cycle) or isinstance(cycle.pace, MotorPace):
        return False
    return (
        geometry_of(known) == geometry_of(other)
        and known.forces == other.forces
        and (cycle.coordinate, cycle.start, cycle.pace, cycle.n_positions)
        == (other_cycle.coordinate, other_cycle.start, other_cycle.pace, other_cycle.n_positions)
        and [(p.name, p.stop, p.solve, _variable(p.given)) for p in cycle.phases]
        == [(p.name, p.stop, p.solve, _variable(p.given)) for p in other_cycle.phases]
    )


def forces_again(known: CycleLoads, linkage: Linkage, cycle: Cycle) -> CycleLoads:
    """Return the loads of a linkage at the positions of a cycle that one like it went through.

    The two must move alike (`moves_alike`). `unresolved` stays what the known loads have: how well
    its positions follow them. Raises LinkageError, which names the phase, where friction locks the
    linkage or a force is missing.
    """
    kinematics, solutions = Kinematics(linkage), []
    for k, phase in enumerate(cycle.phases):
        rows = np.flatnonzero(known.phase_of == k)
        motion = known.motion(kinematics, cycle.coordinate, rows)
        try:
            solutions.append(solve_laws(motion, phase.given, phase.solve)[1])
        except LinkageError as error:
            raise CycleError(cycle.name, k, phase.name, str(error)) from None
    whole = one_after_another(solutions)
    return replace(
        known,
        linkage=linkage,
        reactions=whole.joints,
        efforts={force.name: whole.efforts[force.name] for force in linkage.forces},
    )


def _has_contact(cycle: Cycle) -> bool:
    return any(isinstance(law, Contact) for phase in cycle.phases for law in phase.given.values())


def _variable(given: Mapping[str, Law]) -> Mapping[str, Law | None]:
    """The laws of a phase, without the size of those that are constant."""
    return {name: None if isinstance(law, float | int) else law for name, law in given.items()}
