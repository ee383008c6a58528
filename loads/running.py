"""Speed at which a motor turns a linkage over and over: the periodic solution, by shooting.

Along the way s of the coordinate that the motor turns, w = (ds/dt)^2 obeys

    dw/ds = 2 (T(sqrt w) - D(s, w, dw/ds / 2)) / J,

T the motor's torque, J the inertia of flywheel and rotor, D the torque that the linkage takes at
this place, speed and acceleration: its joints' friction, too, depends on all of them. D is
linearised about a run, D = a dv/dt + b w + c, which is exact where nothing rubs; the run is found,
D is linearised about it, and so on until the run stays. Hermite-Simpson's steps (a cubic over each
step that meets the equation at both ends and midway; order 4) go from position to position. Steps
in which the run settles many times over, of a strong motor on hardly any inertia, are refused. A
turn that begins too fast ends slower and one that begins too slow ends faster, or stands: Newton's
method between such two, from the motor's speed without load down, finds the speed that repeats.
Where runs that slow down and runs that stand leave nothing between them, the motor stalls.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from loads.bodies import FloatArray, LinkageError
from loads.motors import Geared

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

# torque (n,) that the linkage takes in phase k at squared speeds and accelerations (n,)
Demand = Callable[[int, FloatArray, FloatArray], FloatArray]
Place = Callable[[int, int], str]

_SAME = 1e-8  # of the squared speed: how far from the run that repeats a turn may begin
_MOST_SPEED = 2.0  # of the speed without load: a load that drives faster runs away
_SETTLED = 1e-9  # of the squared speed: change by another linearisation of a run that stays
_ROUGH = 1e-3  # of the squared speed: change that asks for slopes anew
_STILL = 1e-8  # of the squared speed without load: the machine stands
_LEAST_SHARE = 1 / 8  # of a change that is gone where runs do not settle
_STALLS = 1e-6  # of the squared speed: runs that stop and runs that slow down lie as close
_MOST_TURNS = 200
_MOST_ROUNDS = 60
_MOST_STEPS = 30  # of Newton's method within a step
_GAUSS = np.polynomial.legendre.leggauss(6)


class StallError(LinkageError):
    """A motor that cannot turn a linkage over."""


class RunawayError(LinkageError):
    """A load that drives its motor away."""


class UnsettledError(LinkageError):
    """A run of a motor that the numerics did not find."""


@dataclass(frozen=True, eq=False)
class SolvedPace:
    """Speeds over the way, phase by phase.

    phases  squared speed over the way since the start of the cycle, mm2/s2 or rad2/s2
    starts  (phases,) s, the time at which each begins
    """

    phases: "Sequence[CubicHermiteSpline]"
    starts: FloatArray

    def rates(self, k: int, way: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Speed and acceleration (n,) at ways in phase k."""
        squares = self.phases[k]
        return np.sqrt(squares(way)), 0.5 * squares(way, 1)

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
    ways     per phase (2 m - 1,) rad, of the motor's coordinate since the start of the cycle; every
             other one midway between its neighbours
    inertia  t mm2, of all that turns with the coordinate besides linkage and rotor
    start    rad/s, a speed to begin with
    place    where way i of phase k is, in words

    Raises StallError where the motor stops, RunawayError where the load drives it on, LinkageError
    where nothing has a mass, UnsettledError where no run is found.
    """
    runs = [(np.full(len(way), start**2), np.zeros(len(way))) for way in ways]
    turn = _Turn(motor, inertia + motor.reflected, ways, place)
    known, change, share, switching = None, np.inf, 1.0, False
    for _ in range(_MOST_ROUNDS):
        for k, run in enumerate(runs):
            turn.linearise(demand, k, *run, anew=change > _ROUGH or switching)
        found = turn.repeated(known)
        known, before = float(found[0][0][0]), change
        change = max(
            float((np.abs(new - old) / new).max())
            for (new, _), (old, _) in zip(found, runs, strict=True)
        )
        if change < _SETTLED:
            return _pace(ways, found)
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


def _pace(ways: Sequence[FloatArray], found: Sequence[tuple[FloatArray, FloatArray]]) -> SolvedPace:
    from scipy.interpolate import CubicHermiteSpline  # half a second that few linkages need

    splines = [
        CubicHermiteSpline(way[::2], w[::2], slope[::2])
        for way, (w, slope) in zip(ways, found, strict=True)
    ]
    took = [float(_time_along(spline, spline.x[-1:])[0]) for spline in splines]
    return SolvedPace(splines, np.concatenate([[0.0], np.cumsum(took)[:-1]]))


@dataclass(eq=False)
class _Turn:
    """One cycle of the motor's run under a linearised demand.

    linear  phase -> a, b and c of a dv/dt + b w + c, (2 m - 1,) each
    """

    motor: Geared
    inertia: float
    ways: Sequence[FloatArray]
    place: Place
    linear: dict[int, tuple[FloatArray, FloatArray, FloatArray]] = field(default_factory=dict)

    def linearise(
        self, demand: Demand, k: int, squares: FloatArray, accelerations: FloatArray, *, anew: bool
    ) -> None:
        """Linearise the torque that a phase takes about a run, with its slopes anew or as known.

        Exact everywhere where nothing rubs.
        """
        taken, more = demand(k, squares, accelerations), 0.01 * squares
        if anew:
            b = (demand(k, squares + more, accelerations) - taken) / more
            a = (demand(k, squares, accelerations + more) - taken) / more
            a = np.maximum(a, -0.5 * self.inertia)  # less is the jump of a contact that opens
        else:
            a, b, _ = self.linear[k]
        self.linear[k] = a, b, taken - a * accelerations - b * squares

    def repeated(self, known: float | None) -> list[tuple[FloatArray, FloatArray]]:
        """Squared speeds and their slopes per phase, (2 m - 1,) each, of the run that repeats.

        known  where such a run began under nearly the same demand
        """
        self._check_masses()
        free = self.motor.free_speed**2
        low, high, stall = _STILL * free, np.inf, None  # the run begins between them
        begin = free if known is None else known
        for _ in range(_MOST_TURNS):
            run, ahead = self._from(begin), -np.inf
            if isinstance(run, StallError):
                low, stall = begin, run
            else:
                path, share = run
                gain = float(path[-1][0][-1]) - begin
                # Newton's distance to the run that repeats; share < 1: runs beside it come closer
                if share < 1.0 and abs(gain) <= _SAME * (1.0 - share) * begin:
                    return path
                low, high = (begin, high) if gain > 0.0 else (low, begin)
                stall = None if gain > 0.0 else stall
                ahead = begin + gain / (1.0 - share) if share < 1.0 else -np.inf
            if stall is not None and high - low < _STALLS * high:
                raise stall
            if low < ahead < high:
                begin = ahead
            else:
                begin = sqrt(low * high) if high < np.inf else max(free, 1.5 * low)
            if begin > _MOST_SPEED**2 * free:
                raise self._runaway() if stall is None else stall
        raise UnsettledError("the motor's speed does not repeat from cycle to cycle")

    def _check_masses(self) -> None:
        for k, (a, _, _) in self.linear.items():
            whole = a + self.inertia
            if not (whole > 0.0).all():
                raise LinkageError(
                    f"nothing that the motor turns has a mass at "
                    f"{self.place(k, int(np.argmin(whole)))}: state the masses of the bodies, or "
                    "drive.flywheel"
                )

    def _from(self, begin: float) -> tuple[list[tuple[FloatArray, FloatArray]], float] | StallError:
        """The cycle that begins at a squared speed, and how its end changes with it.

        A StallError where the motor stops on the way. Raises RunawayError, and UnsettledError where
        a step is too long for the motor.
        """
        found, w, share = [], begin, 1.0
        for k, way in enumerate(self.ways):
            a, b, c = self.linear[k]
            rows = np.column_stack([a + self.inertia, b, c]).tolist()
            ways = way.tolist()
            squares, slopes = np.empty(len(ways)), np.empty(len(ways))
            slope, steep = self._slope(w, rows[0])
            squares[0], slopes[0] = w, slope
            for i in range(0, len(ways) - 1, 2):
                step = ways[i + 2] - ways[i]
                try:
                    taken = self._step((w, slope, steep), step, rows[i + 1], rows[i + 2])
                except ArithmeticError:
                    raise self._too_stiff(k, i) from None
                if taken is None:
                    # it stands only where it is held at rest
                    if self.motor.torque(0.0)[0] >= max(rows[i + 1][2], rows[i + 2][2]):
                        raise self._too_stiff(k, i)
                    return self._stalled(k, i)
                (half, half_slope), (w, slope, steep), own = taken
                share *= own
                if not w <= 4.0 * _MOST_SPEED**2 * self.motor.free_speed**2:
                    raise self._runaway()
                squares[i + 1], slopes[i + 1] = half, half_slope
                squares[i + 2], slopes[i + 2] = w, slope
            found.append((squares, slopes))
        return found, share

    def _slope(self, w: float, row: Sequence[float]) -> tuple[float, float]:
        """dw/ds, and its derivative by w, where whole inertia, b and c are those of a row."""
        whole, b, c = row
        speed = sqrt(w)
        torque, steepness = self.motor.torque(speed)
        return 2.0 * (torque - b * w - c) / whole, 2.0 * (0.5 * steepness / speed - b) / whole

    def _step(
        self,
        old: tuple[float, float, float],
        step: float,
        middle: Sequence[float],
        last: Sequence[float],
    ) -> tuple[tuple[float, float], tuple[float, float, float], float] | None:
        """Squared speed and slope midway and, with the slope's derivative, after a step.

        Also how the last changes with the squared speed before. None where the machine stands.
        Raises ArithmeticError where Newton's method does not end.
        """
        w, slope, steep = old
        least = _STILL * self.motor.free_speed**2
        new = max(w + step * slope, 0.25 * w)
        change = np.inf
        for _ in range(_MOST_STEPS):
            end, end_steep = self._slope(new, last)
            half = 0.5 * (w + new) + 0.125 * step * (slope - end)
            if half < least:
                return None
            mid, mid_steep = self._slope(half, middle)
            by_new = 0.5 - 0.125 * step * end_steep
            gain = 1.0 - step / 6.0 * (4.0 * mid_steep * by_new + end_steep)
            before, change = change, (new - w - step / 6.0 * (slope + 4.0 * mid + end)) / gain
            # rounding leaves a change that gets no smaller
            if abs(change) <= 1e-15 * new or abs(before) <= abs(change) <= 1e-11 * new:
                by_old = 0.5 + 0.125 * step * steep
                loss = 1.0 + step / 6.0 * (steep + 4.0 * mid_steep * by_old)
                return (half, mid), (new, end, end_steep), loss / gain
            new -= change
            if new < least:
                return None
        raise ArithmeticError

    def _runaway(self) -> RunawayError:
        return RunawayError(
            f"the load drives the motor to more than {_MOST_SPEED:g} times its speed without load, "
            f"{self.motor.free_speed:.4g} rad/s at the angle: more than the motor can brake"
        )

    def _too_stiff(self, k: int, i: int) -> UnsettledError:
        return UnsettledError(
            f"the speed of the motor cannot be followed beyond {self.place(k, i)}: it is strong "
            "beside the inertia that it turns; drive.motor.inertia and drive.flywheel add the "
            "rotor's and the flywheel's"
        )

    def _stalled(self, k: int, i: int) -> StallError:
        """The machine stands beyond way i of phase k: where, and what torque is missing."""
        slow = [c for _, _, c in self.linear.values()]
        worst = max(range(len(slow)), key=lambda number: float(slow[number].max()))
        at = int(slow[worst].argmax())
        needed, most = float(slow[worst][at]), self.motor.largest_torque
        missing = f", {(needed - most) * 1e-3:.4g} N m are missing" if needed > most else ""
        return StallError(
            f"the motor stalls at {self.place(k, i + 1)}: turned slowly, the linkage takes up to "
            f"{needed * 1e-3:.4g} N m, at {self.place(worst, at)}; the motor gives "
            f"{most * 1e-3:.4g} N m at most and {self.motor.torque(0.0)[0] * 1e-3:.4g} N m from "
            f"rest{missing}; more inertia in drive.flywheel carries it over, or a stronger motor"
        )
