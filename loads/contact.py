"""Forces that follow laws over the motion, and contacts that the elastic linkage settles.

A force of the law `Opposing` acts along its own coordinate q, against q's rate: of size
F_0 + c |q'|, or as a table over |q'| says, so its power -F |q'| is never above 0. Where q reverses
within a phase, dry friction jumps from one side to the other: there a phase ends and another one
begins, both with their own force at the same position, as at any other jump of a force.

A contact pushes with F = max(0, k (at - coordinate)), with the coordinate of the deflected linkage:
its rigid value plus the deflection delta(F) that all loads together cause. F and delta are
solved for together; without friction delta is linear in F and one step does it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from loads.bodies import (
    BoolArray,
    Coordinate,
    Fixed,
    FloatArray,
    Force,
    IntArray,
    LinkageError,
    PointCoordinate,
    in_words,
)
from loads.elasticity import LoadState, deflection
from loads.forces import ForceSolution, solve_forces, unit_forces
from loads.kinematics import dot, unit
from loads.laws import Contact, Expression, Law, Opposing, Table, expressed
from loads.linkage import Linkage
from loads.motion import Motion, coordinate_share
from loads.pace import Cycle, Phase, SteadyPace
from loads.path import Path, trace

Function = Callable[[FloatArray], FloatArray]
"""Values (n,) or of several functions (rows, n) at places (n,) of a grid."""


_ROOT_STEPS = 9  # of the Illinois method: from a step of the grid to rounding
_EXTREME_STEPS = 4  # parabolas, each through the best three points

_STEPS_OF_SPLIT = 400  # of a phase, at first, between which a coordinate may reverse
_STILL = 1e-9  # share of the motion: below it a coordinate stands still, for round-off
_EDGE = 1e-6  # of a phase: a reversal nearer to its end is its end


def opposing(motion: Motion, name: str, law: Opposing) -> FloatArray:
    """Return the value of a force against the motion (n,), N or N mm.

    Raises LinkageError where a table does not cover the speed.
    """
    kinematics, n = motion.kinematics, len(motion.values)
    force = kinematics.linkage.force(name)
    speed = coordinate_speed(motion, name)
    size = law.dry + law.viscous * speed
    if law.speeds:
        if speed.max() > law.speeds[-1] * (1 + _STILL):
            unit, factor = ("rad/s", 1.0) if force.coordinate.angular else ("m/s", 1e-3)
            raise LinkageError(
                f"force {name!r}: its table goes up to {factor * law.speeds[-1]:g} {unit} and does "
                f"not cover {factor * speed.max():g} {unit} at {motion.place(int(speed.argmax()))}"
            )
        size = np.interp(speed, law.speeds, law.forces)
    share = coordinate_share(kinematics, force.coordinate, motion.poses, motion.heading)
    way = np.where(np.abs(share) > _STILL, np.sign(share), 0.0)
    if n > 1:  # an end at a reversal belongs to its own phase
        way[0], way[-1] = way[0] or way[1], way[-1] or way[-2]
    return np.asarray(-force.sign * way * size)


def coordinate_speed(motion: Motion, name: str) -> FloatArray:
    """Return the speed of a force's own coordinate (n,), mm/s or rad/s, never negative."""
    coordinate = motion.kinematics.linkage.force(name).coordinate
    gradient = motion.kinematics.gradient(coordinate, motion.poses)
    return np.asarray(np.abs(dot(gradient, motion.velocities.reshape(len(gradient), -1))))


def split_cycle(linkage: Linkage, cycle: Cycle) -> tuple[Cycle, tuple[int, ...]]:
    """Return the cycle with phases that end where what sets forces or accelerations jumps.

    Where a force against the motion reverses, and where the cushion of the pace begins. Beside it
    the number of the phase, before the split, from which each has come. Parts of a phase are named
    <phase>-1, <phase>-2 and so on. Raises LinkageError where the cycle cannot be traced.
    """
    against = [
        [linkage.force(name).coordinate for name, law in phase.given.items()
         if isinstance(law, Opposing)]
        for phase in cycle.phases
    ]  # fmt: skip
    cushion = cycle.pace.cushion if isinstance(cycle.pace, SteadyPace) else 0.0
    if not any(against) and not cushion:
        return cycle, tuple(range(len(cycle.phases)))
    ends = [cycle.start, *(phase.stop for phase in cycle.phases)]
    path = trace(linkage, cycle.coordinate, min(ends), max(ends))
    taken = {phase.name for phase in cycle.phases}
    phases: list[Phase] = []
    origin: list[int] = []
    strokes = _strokes(ends)
    for k, (phase, span) in enumerate(zip(cycle.phases, pairwise(ends), strict=True)):
        found = _reversals(path, against[k], *span)
        if cushion:
            found += _cushioned(path, cycle.pace.coordinate, cushion, span, strokes[k])
        inner = _apart(found, *span)
        stops = [*inner, phase.stop]
        names = [phase.name] if not inner else _free(phase.name, len(stops), taken)
        phases += [replace(phase, name=n, stop=s) for n, s in zip(names, stops, strict=True)]
        origin += [k] * len(stops)
    return replace(cycle, phases=tuple(phases)), tuple(origin)


def _strokes(ends: Sequence[float]) -> list[float]:
    """Where the stroke of each phase ends: the last of those that go on in its direction."""
    found: list[float] = []
    for k in reversed(range(len(ends) - 1)):
        on = found and (ends[k + 1] > ends[k]) == (ends[k + 2] > ends[k + 1])
        found.append(found[-1] if on else ends[k + 1])
    return found[::-1]


def _cushioned(
    path: Path, pace: Coordinate, cushion: float, span: tuple[float, float], end: float
) -> list[float]:
    """Places of a phase where the pace's coordinate is a cushion before the end of its stroke."""

    def value(grid: FloatArray) -> FloatArray:
        return path.kinematics.value(pace, path.poses_at(grid))

    last = float(value(np.array([end]))[0])

    def beyond(grid: FloatArray) -> FloatArray:
        return np.abs(value(grid) - last) - cushion

    grid = with_roots(np.linspace(*span, _STEPS_OF_SPLIT + 1), beyond)
    inside = beyond(grid) <= _STILL * cushion
    return [] if inside.all() or not inside.any() else [float(grid[int(inside.argmax())])]


def _free(name: str, count: int, taken: set[str]) -> list[str]:
    """Names of the parts of a phase that no other phase has."""
    names = [f"{name}-{k + 1}" for k in range(count)]
    return names if not taken & set(names) else _free(f"{name}-", count, taken)


def _reversals(
    path: Path, coordinates: Sequence[Coordinate], start: float, stop: float
) -> list[float]:
    """Places of a phase where one of the coordinates reverses."""
    even = np.linspace(start, stop, _STEPS_OF_SPLIT + 1)
    found: set[float] = set()
    for coordinate in coordinates:

        def share(grid: FloatArray, coordinate: Coordinate = coordinate) -> FloatArray:
            geometry = path.at(grid)
            return coordinate_share(path.kinematics, coordinate, geometry.poses, geometry.first)

        grid = with_extremes(even, share)
        found |= set(with_roots(grid, share).tolist()) - set(grid.tolist())
        values = share(grid)
        found |= set(grid[1:-1][(values[1:-1] == 0.0) & (values[:-2] * values[2:] < 0.0)].tolist())
    return sorted(found)


def _apart(found: Sequence[float], start: float, stop: float) -> list[float]:
    """Places on the way from start to stop that are apart from each other and from both."""
    edge = _EDGE * abs(stop - start)
    kept: list[float] = []
    for place in sorted(found, reverse=bool(stop < start)):
        if all(abs(place - other) > edge for other in (start, stop, *kept)):
            kept.append(place)
    return kept


def with_roots(grid: FloatArray, function: Function) -> FloatArray:
    """Return the grid with the function's roots put in (Illinois method)."""
    values = np.atleast_2d(function(grid))
    before, after = values[:, :-1], values[:, 1:]
    row, k = np.nonzero(((before < 0.0) != (after < 0.0)) & np.isfinite(before + after))
    if not len(k):
        return grid
    one, other = grid[k], grid[k + 1]
    value_one, value_other = values[row, k], values[row, k + 1]
    for _ in range(_ROOT_STEPS):
        apart = value_other - value_one
        step = np.divide(value_other, apart, out=np.zeros_like(apart), where=apart != 0.0)
        middle = other - step * (other - one)
        value = _inside(grid, function, middle, row)
        crossed = (value < 0.0) != (value_other < 0.0)
        one = np.where(crossed, other, one)
        value_one = np.where(crossed, value_other, 0.5 * value_one)
        other, value_other = middle, value
    return _merged(grid, other)


def with_extremes(grid: FloatArray, function: Function) -> FloatArray:
    """Return the grid with the function's smallest and largest values between put in."""
    values = np.atleast_2d(function(grid))
    before, here, after = values[:, :-2], values[:, 1:-1], values[:, 2:]
    with np.errstate(invalid="ignore", over="ignore"):  # an exp may be beyond all numbers
        turning = np.isfinite(before + here + after) & ((here - before) * (after - here) < 0.0)
    row, k = np.nonzero(turning)
    if not len(k):
        return grid
    x = np.stack([grid[k], grid[k + 1], grid[k + 2]])
    y = np.stack([before[row, k], here[row, k], after[row, k]])
    for _ in range(_EXTREME_STEPS):
        trial = _vertex(x, y)
        value = _inside(grid, function, trial, row)
        x, y = _narrowed(x, y, trial, value)
    return _merged(grid, x[1])


def _vertex(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the vertex of the parabola through three points each (3, m), inside them."""
    left, right = x[1] - x[0], x[2] - x[1]
    rise, fall = (y[1] - y[0]) * right, (y[2] - y[1]) * left
    bend = 2.0 * (fall - rise)
    shift = np.divide(rise * right + fall * left, bend, out=np.zeros_like(bend), where=bend != 0.0)
    low, high = np.minimum(x[0], x[2]), np.maximum(x[0], x[2])
    vertex: FloatArray = np.clip(x[1] - shift, low, high)
    # a vertex on the middle point teaches nothing: look a little beside it
    same = vertex == x[1]
    return np.where(same, x[1] + 0.1 * np.where(np.abs(left) > np.abs(right), -left, right), vertex)


def _narrowed(
    x: FloatArray, y: FloatArray, trial: FloatArray, value: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the best of four points with its neighbours."""
    sense = np.sign(y[1] - y[0])  # 1: a top, -1: a bottom
    places = np.concatenate([x, trial[None]])
    heights = np.concatenate([y, value[None]])
    order = np.argsort(places, axis=0)
    places = np.take_along_axis(places, order, axis=0)
    heights = np.take_along_axis(heights, order, axis=0)
    best = 1 + np.argmax(sense * heights[1:3], axis=0)
    rows = best + np.arange(-1, 2)[:, None]
    return np.take_along_axis(places, rows, axis=0), np.take_along_axis(heights, rows, axis=0)


def _inside(grid: FloatArray, function: Function, places: FloatArray, row: IntArray) -> FloatArray:
    """Return the functions at a place each, between the grid's ends, which keep its direction.

    row  (m,) which of the functions is asked for at which of the places (m,)
    """
    values = np.atleast_2d(function(np.concatenate([grid[:1], places, grid[-1:]])))
    return np.asarray(values[:, 1:-1][row, np.arange(len(places))])


def _merged(grid: FloatArray, places: FloatArray) -> FloatArray:
    rising = np.sort(np.concatenate([grid, places]))
    apart = np.diff(rising, prepend=-np.inf) > 1e-13 * abs(grid[-1] - grid[0])
    kept = rising[apart]
    kept[0], kept[-1] = min(grid[0], grid[-1]), max(grid[0], grid[-1])
    return np.asarray(kept if grid[-1] > grid[0] else kept[::-1])


_STEPS = 60
_TOUCH = 1e-12  # of the linkage's size: a gap of round-off
_LEFT = 1e-12  # of depth and deflection: what may be left of a contact's gap


@dataclass(frozen=True, eq=False)
class Touch:
    """A contact at every position of a stretch of the motion.

    touching    (n,) True if the linkage, moving on freely, would be in what it touches
    gap         (n,) mm, of the freely moving linkage to the contact; below 0 where it touches
    lift        (n,) mm, of the linkage as it is held, without the contact's force; below 0 where
                the contact pushes
    deflection  (n,) mm, of the linkage along the force, under all its loads
    held        (n,) share of its acceleration along the force that the pushed body loses: 0 free,
                1 stopped by a rigid contact
    """

    touching: BoolArray
    gap: FloatArray
    lift: FloatArray
    deflection: FloatArray
    held: FloatArray


def solve_laws(
    motion: Motion, laws: Mapping[str, Law], solve: str
) -> tuple[Motion, ForceSolution, dict[str, Touch]]:
    """Return motion, forces and contacts for forces that follow laws.

    The motion differs from the one given where a contact holds a body still.
    Raises LinkageError where a table does not cover the motion or nothing gives way at a contact.
    """
    given, contacts = _sorted(motion, laws)
    if not contacts:
        return motion, solve_forces(motion, given, solve), {}
    if len(contacts) > 1:
        raise LinkageError(
            f"{' and '.join(contacts)} are contacts of one phase; only one is solved at a time"
        )
    ((name, contact),) = contacts.items()
    return _solve_contact(motion, given, solve, name, contact)


def _sorted(
    motion: Motion, laws: Mapping[str, Law]
) -> tuple[dict[str, float | FloatArray], dict[str, Contact]]:
    """Forces that are known at every position, and contacts, by name."""
    given: dict[str, float | FloatArray] = {}
    contacts: dict[str, Contact] = {}
    for name, law in laws.items():
        match law:
            case Contact():
                contacts[name] = law
            case Table():
                given[name] = _tabled(motion, name, law)
            case Expression():
                given[name] = expressed(motion, name, law)
            case Opposing():
                given[name] = opposing(motion, name, law)
            case _:
                given[name] = law
    return given, contacts


def _tabled(motion: Motion, name: str, table: Table) -> FloatArray:
    kinematics = motion.kinematics
    kinematics.linkage.check_coordinate(table.coordinate, f"table of force {name!r}")
    places = kinematics.value(table.coordinate, motion.poses)
    low, high = table.values[0], table.values[-1]
    slack = 1e-9 * (high - low)
    outside = (places < low - slack) | (places > high + slack)
    if outside.any():
        coordinate = table.coordinate
        wrap = "; angles are not wrapped, let the table go on" if coordinate.angular else ""
        raise LinkageError(
            f"force {name!r}: its table goes from {in_words(coordinate, low)} to "
            f"{in_words(coordinate, high)} of {coordinate.label}, the phase from "
            f"{in_words(coordinate, float(places.min()))} to "
            f"{in_words(coordinate, float(places.max()))}{wrap}"
        )
    return np.interp(places, table.values, table.forces)


class _Approach:
    """A linkage in front of a contact: how it gives way along the contact's force.

    sense     of the force's value where the contact pushes
    slope     (n,) mm/N, compliance of the linkage and the contact together
    held      (n,) as in Touch; `slowed` is the motion that follows from it
    depth     (n,) mm, how far the rigid linkage would be in the contact
    """

    def __init__(
        self,
        motion: Motion,
        given: Mapping[str, float | FloatArray],
        solve: str,
        name: str,
        contact: Contact,
    ) -> None:
        kinematics, poses = motion.kinematics, motion.poses
        force = kinematics.linkage.force(name)
        self._given, self._solve, self._name = given, solve, name
        self.motion, self.sense = motion, contact.side * force.sign
        self._unit = LoadState(unit_forces(motion, [name], self.sense, solve)[0], None)
        softness = deflection(kinematics, poses, self._unit, self._unit)
        self.soft = 0.0 if contact.stiffness is None else 1.0 / contact.stiffness
        self.slope = softness + self.soft
        # the pushed body follows the contact, whose surface gives way by this share of all
        self.held = np.zeros(len(poses))
        if contact.stops:
            np.divide(softness, self.slope, out=self.held, where=self.slope > 0.0)
        self.slowed = _slowed(motion, force, self.held)
        self.depth = contact.side * (contact.at - kinematics.value(force.coordinate, poses))

    def solved(self, moving: Motion, size: FloatArray) -> ForceSolution:
        """All forces where the contact pushes with some force (n,)."""
        return solve_forces(moving, {**self._given, self._name: self.sense * size}, self._solve)

    def way(self, moving: Motion, solution: ForceSolution) -> FloatArray:
        """Deflection of the linkage along the contact's force (n,), mm."""
        state = LoadState(solution, moving)
        return deflection(self.motion.kinematics, self.motion.poses, self._unit, state)

    def deflected(self, moving: Motion, size: FloatArray) -> FloatArray:
        """Deflection along the contact's force where it pushes with `size` (n,), mm."""
        return self.way(moving, self.solved(moving, size))

    @cached_property
    def gap(self) -> FloatArray:
        """As in Touch."""
        return self.deflected(self.motion, np.zeros(len(self.depth))) - self.depth

    @cached_property
    def lift(self) -> FloatArray:
        """As in Touch."""
        if self.slowed is self.motion:
            return self.gap
        return self.deflected(self.slowed, np.zeros(len(self.depth))) - self.depth


def contact_gaps(motion: Motion, laws: Mapping[str, Law], solve: str, name: str) -> FloatArray:
    """Gap and lift (2, n) of a contact as in Touch, mm, without settling its force."""
    given, contacts = _sorted(motion, laws)
    approach = _Approach(motion, given, solve, name, contacts[name])
    return np.stack([approach.gap, approach.lift])


def _solve_contact(
    motion: Motion,
    given: Mapping[str, float | FloatArray],
    solve: str,
    name: str,
    contact: Contact,
) -> tuple[Motion, ForceSolution, dict[str, Touch]]:
    kinematics = motion.kinematics
    approach = _Approach(motion, given, solve, name, contact)
    # the position that stands at the touch is free, whichever side of it rounding leaves it on
    touching, lift = approach.gap < -_TOUCH * kinematics.size, approach.lift
    if (touching & (lift < 0.0) & (approach.slope <= 0.0)).any():
        raise LinkageError(
            f"force {name!r}: nothing gives way between a rigid contact and a rigid linkage; "
            "state the stiffness of the contact, or the elasticity of a body or joint"
        )
    size = np.zeros(len(lift))
    if (touching & (lift < 0.0)).any():
        scale = kinematics.coordinate_scale(kinematics.linkage.force(name).coordinate)
        try:
            size = _settled(approach, touching, scale)
        except _Unsettled as unsettled:
            raise LinkageError(
                f"force {name!r}: contact and friction do not settle at "
                f"{motion.place(unsettled.position)}; friction comes close to locking there"
            ) from None
    mixed = _chosen(touching, approach.slowed, motion)
    final = approach.solved(mixed, size)
    held = np.where(touching, approach.held, 0.0)
    touch = Touch(touching, approach.gap, lift, approach.way(mixed, final), held)
    return mixed, final, {name: touch}


class _Unsettled(Exception):
    def __init__(self, position: int) -> None:
        super().__init__(position)
        self.position = position


def _settled(approach: _Approach, touching: BoolArray, scale: float) -> FloatArray:
    """Return the contact's force (n,): secants from the frictionless slope, each position alone."""
    depth, soft, slope = approach.depth, approach.soft, approach.slope
    size = np.zeros(len(depth))
    given_way = approach.lift + depth
    first = np.where(slope > 0.0, slope, 1.0)
    slope = first.copy()
    for _ in range(_STEPS):
        left = depth - given_way - soft * size
        allowed = _LEFT * (np.abs(depth) + np.abs(given_way)) + 1e-14 * scale
        settled = ~touching | (np.abs(left) <= allowed) | ((size == 0.0) & (left <= 0.0))
        if settled.all():
            return size
        following = np.where(settled, size, np.maximum(size + left / slope, 0.0))
        change = following - size
        way = approach.deflected(approach.slowed, following)
        moved = change != 0.0
        secant = np.divide(way - given_way + soft * change, change, out=slope.copy(), where=moved)
        slope = np.clip(secant, 0.05 * first, 1e3 * first)
        size, given_way = following, way
    raise _Unsettled(int(np.argmax(np.where(settled, 0.0, np.abs(left)))))


def rigidly_joined(linkage: Linkage, body: str) -> tuple[str, ...]:
    """Return a body and all that are welded to it."""
    together = [body]
    for name in together:
        for joint in linkage.joints:
            if isinstance(joint, Fixed) and name in (joint.body_a, joint.body_b):
                other = joint.body_b if joint.body_a == name else joint.body_a
                if other not in together:
                    together.append(other)
    return tuple(together)


def _slowed(motion: Motion, force: Force, held: FloatArray) -> Motion:
    """Return the motion in which the pushed body loses a share of its acceleration."""
    if not (held > 0.0).any():
        return motion
    kinematics, coordinate = motion.kinematics, force.coordinate
    cure = "state that the contact does not stop it (stops = false)"
    if not isinstance(coordinate, PointCoordinate):
        raise LinkageError(
            f"force {force.name!r}: a contact holds a body still only where it pushes a point "
            f"along a direction; {cure}"
        )
    row = kinematics.index[coordinate.body]
    turning = np.abs(motion.heading[:, row, 2]) * kinematics.size
    if (turning > 1e-9 * np.abs(motion.heading[:, row]).max(axis=1)).any():
        raise LinkageError(
            f"force {force.name!r}: body {coordinate.body!r} turns, and a contact can only hold a "
            f"body still that slides; {cure}"
        )
    along = unit(coordinate.direction)
    lost = held * dot(motion.accelerations[:, row, :2], along)
    accelerations = motion.accelerations.copy()
    for body in rigidly_joined(kinematics.linkage, coordinate.body):
        accelerations[:, kinematics.index[body], :2] -= lost[:, None] * along
    return replace(motion, accelerations=accelerations)


def _chosen(touching: BoolArray, held: Motion, free: Motion) -> Motion:
    accelerations = np.where(touching[:, None, None], held.accelerations, free.accelerations)
    return replace(free, accelerations=accelerations)
