"""Starts and stops of a linkage that a motor turns: its speed from rest, or to rest, over the time.

    (J + a) dv/dt = T - b v^2 - c,   ds/dt = v

s the way of the motor's angle, J flywheel and rotor, T the torques of motor and brake, and
a dv/dt + b v^2 + c the torque that the linkage takes, linearised about a run as `loads/running.py`
does. A turn follows from those before it, so each phase of a turn settles before the next begins:
it is followed again until the torque along it is the linkage's own. Over the time the equation is
smooth at rest, where the squared speed over the way is not. Forces and shape repeat with every
turn, so that the positions of all turns are those of one.
"""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil, isfinite
from typing import Final, overload

import numpy as np

from loads.bodies import FloatArray, LinkageError, place_in_words
from loads.cycle import Rates, Run, Stretch, begun
from loads.linkage import Linkage
from loads.motion import Geometry
from loads.pace import Cycle, MotorPace, Phase, RunPace
from loads.running import SolvedPace, driven_by
from loads.turning import STEP_PLACES, StallError, UnsettledError

EVENTS: Final = ("start", "coast", "brake")
PLACES: Final = 12  # of a turn, from which an event whose beginning is not stated is tried
NEAR: Final = 0.01  # of the steady speed: a start is over
MOST_TURNS: Final = 100
MOST_POSITIONS: Final = 20_000

_SETTLED = 1e-8  # of the largest squared speed: from a torque that is not the linkage's, in a turn
_MOST_ROUNDS = 40
_TOLERANCE, _ROUGH = 1e-10, 1e-5
_STEPS, _ROUGH_STEPS = 40, 6  # of a turn at the steady speed, at least
_KNOTS = 5  # of a step
_SAME = 1e-9  # of a turn: no way at all
_REST = 1e-12  # rad/s: friction needs a direction
_TIE = 1e-3  # of the largest force: places whose rough runs differ by less are alike
_STIFF = 1000.0  # of a turn's time over the time in which the motor takes up its speed
_CORNER = "corner of the motor's torque at "
_LONG = 1000  # turns' times at the steady speed: what takes longer does not come to an end


@dataclass(frozen=True)
class Event:
    """A start, a run-out without motor ("coast") or a braked stop ("brake") of a cycle.

    cycle      its name; a motor turns it over and over
    at         mm or rad, where the cycle's coordinate is as it begins; None: the worst of `PLACES`
    turns      of a start, after which it is followed no more
    torque     N mm, of the brake on the angle that the motor turns
    delay      s, from the beginning of a stop until the brake acts
    motor_on   True if the motor drives on through a braked stop; else it is off from its beginning
    """

    kind: str
    cycle: str
    at: float | None = None
    turns: float | None = None
    torque: float = 0.0
    delay: float = 0.0
    motor_on: bool = False
    n_positions: int | None = None

    def __post_init__(self) -> None:
        if self.kind not in EVENTS:
            raise LinkageError(f"an event is one of {', '.join(EVENTS)}, not {self.kind!r}")
        if self.kind == "brake" and not (isfinite(self.torque) and self.torque > 0.0):
            raise LinkageError(f"the torque of a brake must be above 0, got {self.torque:g}")
        if not (isfinite(self.delay) and self.delay >= 0.0):
            raise LinkageError(f"the delay of a brake is not negative, got {self.delay:g}")

    @property
    def drives(self) -> bool:
        """True if the motor gives its torque."""
        return self.kind == "start" or (self.kind == "brake" and self.motor_on)


@dataclass(frozen=True, eq=False)
class EventRun:
    """An event that was solved, as a cycle that can be run.

    at      mm or rad, of the coordinate, where it begins
    time    s; turns: of the cycle, until it is over
    tried   largest joint force, N, by the places from which it was tried: of the event itself where
            its place is stated, else of runs under the torque about the steady run
    force   largest of a joint, N; torque: largest that the drive puts in, N mm
    steady  both in the steady run
    """

    cycle: Cycle
    at: float
    time: float
    turns: float
    tried: tuple[tuple[float, float], ...]
    force: float
    torque: float
    steady: tuple[float, float]


def solve_event(name: str, linkage: Linkage, cycle: Cycle, event: Event) -> EventRun:
    """Return an event of a cycle that a motor turns, from the worst place where none is stated.

    The worst place is the one with the largest force in any joint. Raises LinkageError: StallError
    where a start stands still, and where a stop takes more than `MOST_TURNS`; UnsettledError where
    no run is found.
    """
    pace = cycle.pace
    if not isinstance(pace, MotorPace):
        raise LinkageError(f"cycle {cycle.name!r}: no motor turns it, so it has no {event.kind}")
    solver = _Solver(linkage, cycle, pace, event)
    if event.at is not None:
        run = solver.solved(solver.way_of(event.at))
        tried = [(event.at, run.largest[0])]
    else:
        begins = (solver.turn * np.arange(PLACES) / PLACES).tolist()
        forces = [solver.tried(begin) for begin in begins]
        tried = [
            (solver.value_at(begin), force) for begin, force in zip(begins, forces, strict=True)
        ]
        # less is what a rough run leaves open, and must not choose the place
        most = max(forces) * (1.0 - _TIE)
        worst = next(k for k, force in enumerate(forces) if force >= most)
        run = solver.solved(begins[worst])
        tried[worst] = (tried[worst][0], run.largest[0])
    return EventRun(
        solver.as_cycle(name, run),
        solver.value_at(run.begin),
        float(run.stretches[-1].knots[-1, 0]),
        (run.end - run.begin) / solver.turn,
        tuple(tried),
        *run.largest,
        solver.steady_peaks,
    )


@dataclass(frozen=True, eq=False)
class _Stretch:
    """A piece of a run in one phase of one turn, before or under the brake.

    knots  (n, 4) as `RunPace` has them
    """

    turn: int
    phase: int
    braked: bool
    knots: FloatArray


@dataclass(frozen=True, eq=False)
class _Followed:
    """A run between two ways; largest force of a joint, N, and torque of the drive, N mm."""

    stretches: Sequence[_Stretch]
    largest: tuple[float, float]

    @property
    def begin(self) -> float:
        return float(self.stretches[0].knots[0, 1])

    @property
    def end(self) -> float:
        return float(self.stretches[-1].knots[-1, 1])


@dataclass(frozen=True)
class _Leg:
    """The way ahead within one phase of a turn, before or under the brake.

    state  s, rad and rad/s: time, way and speed at its beginning
    end    rad, way of its end; until, s, time of its end
    """

    turn: int
    phase: int
    braked: bool
    state: tuple[float, float, float]
    end: float
    until: float


class _Solver:
    """The steady run of a cycle, and the events that leave it or lead to it."""

    def __init__(self, linkage: Linkage, cycle: Cycle, pace: MotorPace, event: Event) -> None:
        run = begun(linkage, cycle)
        self.cycle: Final = cycle
        self.event: Final = event
        self.motor: Final = pace.motor
        self.whole: Final = pace.inertia + pace.motor.reflected
        self.run: Final[Run] = run.at_motors_speed(pace)
        self.places: Final[Sequence[Geometry]] = self.run.places()
        self.ways: Final = [self.run.timing.way(k, at) for k, at in enumerate(self.places)]
        self.levers: Final = driven_by(cycle, run.path.kinematics, self.places)
        steady = self.run.timing.solved
        assert isinstance(steady, SolvedPace)
        self.steady: Final = steady
        self.turn: Final = float(self.ways[-1][-1])
        (start, stop), *_ = cycle.spans
        self.sign: Final = 1.0 if stop > start else -1.0
        steepness = self.motor.torque(self.motor.free_speed)[1]
        self.stiffness: Final = abs(steepness) / max(self.whole, 1e-30)
        self.fastest: Final = max(float(np.sqrt(one.c[-1].max())) for one in steady.phases)
        self._rows: Final[dict[int, FloatArray]] = {}  # a, b, c (3 m + 1, 3), by phase
        peaks = []
        for k, ways in enumerate(self.ways):
            rates = steady.rates(k, ways)
            self._rows[k] = self._linearised(k, *rates)
            peaks.append(self._peaks(k, self.run.solve_at(k, self.places[k], rates)))
        self.steady_peaks: Final = _largest_of(peaks)

    def way_of(self, value: float) -> float:
        """Way since the start of the cycle at a value of its coordinate."""
        return float(np.mod(self.sign * (value - self.cycle.start), self.turn))

    @overload
    def value_at(self, way: float) -> float: ...
    @overload
    def value_at(self, way: FloatArray) -> FloatArray: ...
    def value_at(self, way: float | FloatArray) -> float | FloatArray:
        """Value of the coordinate at a way within the cycle."""
        return self.cycle.start + self.sign * way

    def tried(self, begin: float) -> float:
        """Largest force of a joint, N, in a rough run; raises StallError as the run itself does."""
        try:
            return self.solved(begin, rough=True).largest[0]
        except StallError:
            return self.solved(begin).largest[0]

    def solved(self, begin: float, rough: bool = False) -> _Followed:
        """The run that begins at a way.

        A rough one keeps the linkage's torque as it is about the steady run.
        """
        event = self.event
        turn, k = 0, next(k for k, own in enumerate(self.ways) if begin < own[-1])
        still = event.kind == "start"
        speed = 0.0 if still else float(self.steady.rates(k, np.array([begin]))[0][0])
        state = 0.0, begin, speed
        braked = event.kind == "brake" and event.delay <= 0.0
        stop = begin + self.turn * (MOST_TURNS if event.turns is None else event.turns)
        rows, stretches = dict(self._rows), list[_Stretch]()
        while True:
            end = min(float(self.ways[k][-1]) + turn * self.turn, stop)
            until = np.inf if braked or event.kind != "brake" else event.delay
            leg = _Leg(turn, k, braked, state, end, until)
            piece, knots, why = self._settled(leg, rows, rough)
            if still and piece.slope(0.0, (begin, 0.0))[1] <= 0.0:
                raise self._stalled(piece, begin, begin)
            still = False
            state = knots[-1, 0].item(), knots[-1, 1].item(), knots[-1, 2].item()
            if state[1] - knots[0, 1] > _SAME * self.turn:
                stretches.append(_Stretch(turn, k, braked, knots))
            if why == "delay":
                braked = True
            elif why == "way" and state[1] < stop:
                turn, k = (turn, k + 1) if k + 1 < len(self.ways) else (turn + 1, 0)
            else:
                break
        self._check_end(why, piece, begin, *state[1:])
        return _Followed(stretches, self._largest(stretches, rough))

    def _settled(
        self, leg: _Leg, rows: dict[int, FloatArray], rough: bool
    ) -> tuple["_Piece", FloatArray, str]:
        """A leg under the linkage's own torque, its knots and how it ended; `rows` follow it."""
        for _ in range(_MOST_ROUNDS):
            piece = _Piece(self, leg, rows[leg.phase])
            knots, why = piece.followed(leg.state, rough)
            about = None if rough else self._apart_from(piece, knots)
            if about is None:
                return piece, knots, why
            rows[leg.phase] = self._linearised(leg.phase, *about)
        raise UnsettledError(
            f"forces of the joints and the speed of the {self.event.kind} do not settle on each "
            f"other near {self._place(leg.state[1])}"
        )

    def _apart_from(self, piece: "_Piece", knots: FloatArray) -> Rates | None:
        """Rates of a leg at the places of its phase, if the linkage takes another torque there."""
        k, ways = piece.leg.phase, self.ways[piece.leg.phase]
        own = ways + piece.before
        rates = _rates(knots, own)
        a, b, c = piece.rows.T
        taken = self._taken(k, *rates)
        missing = np.abs(taken - (a * rates[1] + b * rates[0] ** 2 + c))
        first = max(int(np.searchsorted(own, knots[0, 1], side="right")) - 4, 0)
        last = int(np.searchsorted(own, knots[-1, 1])) + 4
        small = max(0.5 * self.whole * self.fastest**2 / self.turn, float(np.abs(taken).max()))
        return rates if missing[first:last].max() > _SETTLED * small else None

    def as_cycle(self, name: str, run: _Followed) -> Cycle:
        """A run as a cycle, each turn of it at the positions of the first."""
        phases = []
        for stretch in run.stretches:
            stated = self.cycle.phases[stretch.phase]
            low, high = self.value_at(self._in_turn(stretch, stretch.knots[[0, -1], 1])).tolist()
            braked = " braked" if stretch.braked else ""
            phases.append(
                Phase(
                    f"{stated.name} {stretch.turn + 1}{braked}",
                    high,
                    stated.given,
                    stated.solve,
                    low,
                )
            )
        gone = np.array([0.0, run.begin, 0.0, 0.0])
        turns = (run.end - run.begin) / self.turn
        count = self.event.n_positions or ceil(turns * self.cycle.n_positions)
        return Cycle(
            name,
            self.cycle.coordinate,
            self.cycle.start,
            RunPace(
                self.cycle.pace.coordinate,
                self.whole,
                tuple(stretch.knots - gone for stretch in run.stretches),
            ),
            tuple(phases),
            min(max(count, 2), MOST_POSITIONS),
        )

    def _in_turn(self, stretch: _Stretch, ways: FloatArray) -> FloatArray:
        """Ways (n,) within their own turn: turns that add up leave round-off at a phase's ends."""
        own = self.ways[stretch.phase]
        return np.clip(ways - stretch.turn * self.turn, own[0], own[-1])

    def _largest(self, stretches: Sequence[_Stretch], rough: bool) -> tuple[float, float]:
        """Largest force of a joint and torque along a run.

        At both ends of every stretch, too; a rough one at the places of its phase alone.
        """
        found = []
        for stretch in stretches:
            k, (first, last) = stretch.phase, stretch.knots[[0, -1], 1].tolist()
            ways = self.ways[k] + stretch.turn * self.turn
            low, high = np.searchsorted(ways, [first, last])
            if rough:
                low, high = max(low - 1, 0), min(high + 1, len(ways))
                inside, geometry = slice(low, high), self.places[k]
            else:
                inside, ways = slice(None), np.array([first, *ways[low:high], last])
                geometry = self.run.path.at(self.value_at(self._in_turn(stretch, ways)))
            solved = self.run.solve_at(k, geometry, _rates(stretch.knots, ways))
            found.append(self._peaks(k, solved, inside))
        return _largest_of(found)

    def _peaks(self, k: int, stretch: Stretch, rows: slice = slice(None)) -> tuple[float, float]:
        solution, solve = stretch.solution, self.cycle.phases[k].solve
        force = max(float(np.hypot(*one.force[rows].T).max()) for one in solution.joints.values())
        return force, float(np.abs(solution.efforts[solve][rows]).max())

    def _linearised(self, k: int, speed: FloatArray, acceleration: FloatArray) -> FloatArray:
        """a, b and c (3 m + 1, 3) of a phase about speeds."""
        more = 0.01 * self.fastest**2
        here = self._taken(k, speed, acceleration)
        b = (self._taken(k, np.sqrt(speed**2 + more), acceleration) - here) / more
        a = (self._taken(k, speed, acceleration + more) - here) / more
        a = np.maximum(a, -0.5 * self.whole)  # less is the jump of a contact that opens
        if not (self.whole + a > 0.0).all():
            at = self.places[k].place(int(np.argmin(a)))
            raise LinkageError(f"nothing that the motor turns has a mass at {at}")
        return np.column_stack([a, b, here - a * acceleration - b * speed**2])

    def _taken(self, k: int, speed: FloatArray, acceleration: FloatArray) -> FloatArray:
        """Torque (3 m + 1,) that the linkage takes at the places of a phase."""
        solution = self.run.solve_at(k, self.places[k], (speed, acceleration)).solution
        return self.levers[k] * solution.efforts[self.cycle.phases[k].solve]

    def _check_end(self, why: str, own: "_Piece", begin: float, way: float, speed: float) -> None:
        """Raise where a run did not come to its end."""
        kind = self.event.kind
        if kind == "start" and why == "rest":
            raise self._stalled(own, begin, way)
        if kind == "start" and why != "near" and self.event.turns is None:
            raise LinkageError(
                f"the start from {self._place(begin)} has {speed:.4g} rad/s after {MOST_TURNS} "
                f"turns, not within {NEAR:.0%} of the steady speed: turns of the event states how "
                "far it is followed, or a stronger motor"
            )
        if kind != "start" and why != "rest":
            cure = "a stronger brake" if kind == "brake" else "a brake"
            raise LinkageError(
                f"the stop from {self._place(begin)} still has {speed:.4g} rad/s after "
                f"{MOST_TURNS} turns: {cure} brings it to rest"
            )
        if way - begin <= _SAME * self.turn:
            raise LinkageError(f"the stop from {self._place(begin)} takes no way at all")

    def _place(self, way: float) -> str:
        return place_in_words(self.cycle.coordinate, self.value_at(way % self.turn))

    def _stalled(self, own: "_Piece", begin: float, way: float) -> StallError:
        needed, given = own.row(way)[2], self.motor.torque(0.0)[0]
        missing = f", {(needed - given) * 1e-3:.4g} N m are missing" if needed > given else ""
        return StallError(
            f"the start from rest at {self._place(begin)} stalls at {self._place(way)}: at rest "
            f"the linkage takes {needed * 1e-3:.4g} N m there, the motor gives "
            f"{given * 1e-3:.4g} N m{missing}; another place to start from, or a stronger motor"
        )


class _Piece:
    """The equation of motion of a leg: rows (3 m + 1, 3) are a, b and c at the places of its phase.

    before  rad, way of the turns that are behind
    """

    def __init__(self, solver: _Solver, leg: _Leg, rows: FloatArray) -> None:
        self._solver, self.leg, self.rows = solver, leg, rows
        self.before: Final = leg.turn * solver.turn
        self._knots: Final = solver.ways[leg.phase][::3].tolist()
        places = np.array([0.0, *STEP_PLACES])
        inverse = np.linalg.inv(places[:, None] ** np.arange(4))
        index = 3 * np.arange(len(self._knots) - 1)[:, None] + np.arange(4)
        self._powers = np.einsum("pk,mkr->mrp", inverse, rows[index]).tolist()
        self._brake = solver.event.torque if leg.braked else 0.0

    def row(self, way: float) -> tuple[float, float, float]:
        """a, b and c at a way; beyond the phase as at its end."""
        knots = self._knots
        way = min(max(way - self.before, knots[0]), knots[-1])
        i = min(bisect_right(knots, way), len(knots) - 1) - 1
        u = (way - knots[i]) / (knots[i + 1] - knots[i])
        (a0, a1, a2, a3), (b0, b1, b2, b3), (c0, c1, c2, c3) = self._powers[i]
        return (
            a0 + u * (a1 + u * (a2 + u * a3)),
            b0 + u * (b1 + u * (b2 + u * b3)),
            c0 + u * (c1 + u * (c2 + u * c3)),
        )

    def slope(self, _: float, state: Sequence[float]) -> tuple[float, float]:
        """Rates of way and speed."""
        way, speed = float(state[0]), float(state[1])
        a, b, c = self.row(way)
        torque = self._solver.motor.torque(speed)[0] if self._solver.event.drives else 0.0
        taken = b * speed * speed + c + self._brake
        return speed, (torque - taken) / (self._solver.whole + a)

    def followed(
        self, state: tuple[float, float, float], rough: bool, gone: tuple[float, ...] = ()
    ) -> tuple[FloatArray, str]:
        """Knots from a state to a way or time, to rest or the steady speed, and which it was.

        gone  corners of the motor's torque, rad/s, that are behind
        """
        from scipy.integrate import solve_ivp  # a third of a second that few linkages need

        solver = self._solver
        whole = solver.turn / solver.fastest
        (time, way, speed), end, until = state, self.leg.end, self.leg.until
        tolerance = _ROUGH if rough else _TOLERANCE
        ends: list[tuple[str, Callable[[float, FloatArray], float], float]] = [
            ("way", lambda _, y: y[0] - end, 1.0),
            ("rest", lambda _, y: y[1], -1.0),
        ]
        if solver.event.kind == "start" and solver.event.turns is None:
            steady = solver.steady.phases[self.leg.phase]

            def near(_: float, y: FloatArray) -> float:
                place = min(y[0] - self.before, steady.x[-1])
                return float(y[1] - (1.0 - NEAR) * np.sqrt(steady(place)))

            ends.append(("near", near, 1.0))
        corners = solver.motor.motor.corners if solver.event.drives else ()
        for corner in (one / solver.motor.ratio for one in corners):
            if corner not in gone:
                ends.append((f"{_CORNER}{corner!r}", _Above(corner), 0.0))
        for _, function, direction in ends:
            vars(function).update(terminal=True, direction=direction)
        found = solve_ivp(
            self.slope,
            (time, min(until, time + _LONG * whole)),
            [way, speed],
            "LSODA" if solver.stiffness * whole > _STIFF else "RK45" if rough else "DOP853",
            events=[function for _, function, _ in ends],
            max_step=whole / (_ROUGH_STEPS if rough else _STEPS),
            dense_output=True,
            rtol=tolerance,
            atol=[1e-2 * tolerance * solver.turn, 1e-2 * tolerance * solver.fastest],
        )
        if not found.success:
            raise UnsettledError(
                f"the {solver.event.kind} cannot be followed beyond "
                f"{solver._place(float(found.y[0, -1]))}: {found.message}"
            )
        why = next(
            (name for (name, _, _), at in zip(ends, found.t_events, strict=True) if len(at)),
            "delay",
        )
        if why == "delay" and found.t[-1] < until:
            raise LinkageError(
                f"the {solver.event.kind} creeps at {solver._place(float(found.y[0, -1]))}, with "
                f"{found.y[1, -1]:.2g} rad/s: it comes neither to rest nor on"
            )
        steps = np.diff(found.t)[:, None] * np.arange(_KNOTS) / _KNOTS
        times = np.append((found.t[:-1, None] + steps).ravel(), found.t[-1])
        states = found.sol(times).T
        states[::_KNOTS] = found.y.T
        if why == "way":
            states[-1, 0] = end
        if why == "rest":
            states[-1, 1] = 0.0
        slopes = [self.slope(0.0, state)[1] for state in states]
        knots = _apart(np.column_stack([times, states, slopes]), 0.01 * whole / _STEPS)
        if not why.startswith(_CORNER):
            return knots, why
        passed = (*gone, float(why.removeprefix(_CORNER)))
        beyond, why = self.followed(tuple(knots[-1, :3].tolist()), rough, passed)
        return np.concatenate([knots, beyond[1:]]), why


def _rates(knots: FloatArray, ways: FloatArray) -> Rates:
    """Speed and acceleration (n,) at ways; beyond the knots as at their ends.

    Closely: the squared speed is cubic over the way between knots, the acceleration linear.
    """
    at, speeds, slopes = knots[:, 1:].T
    ways = np.clip(ways, at[0], at[-1])
    i = np.clip(np.searchsorted(at, ways, side="right") - 1, 0, len(at) - 2)
    h = np.maximum(at[i + 1] - at[i], np.finfo(float).tiny)
    u = (ways - at[i]) / h
    low, high = speeds[i] ** 2, speeds[i + 1] ** 2
    first, last = (2.0 * h * slopes[j] - (high - low) for j in (i, i + 1))
    squares = low + u * (high - low) + u * (1.0 - u) * ((1.0 - u) * first - u * last)
    return np.maximum(np.sqrt(np.maximum(squares, 0.0)), _REST), np.interp(ways, at, slopes)


def _largest_of(peaks: Sequence[tuple[float, float]]) -> tuple[float, float]:
    return max(force for force, _ in peaks), max(torque for _, torque in peaks)


class _Above:
    """How far the speed is above a value."""

    def __init__(self, value: float) -> None:
        self._value = value

    def __call__(self, _: float, state: FloatArray) -> float:
        return float(state[1] - self._value)


def _apart(knots: FloatArray, least: float) -> FloatArray:
    """Knots but for those that follow the one before within `least` s, where rounding shows."""
    kept = [0]
    for i in range(1, len(knots)):
        if knots[i, 0] - knots[kept[-1], 0] >= least:
            kept.append(i)
    last = len(knots) - 1
    if kept[-1] != last:
        kept = [0, *kept[1:-1], last]
    return np.asarray(knots[kept])
