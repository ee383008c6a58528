"""One turn of a linkage by its motor under a linear demand, and the turn that repeats.

Along the way s of the angle that the motor turns, w = (ds/dt)^2 obeys

    dw/ds = 2 (T(sqrt w) - b w - c) / J,

T the motor's torque, J all inertia, b w + c the torque that the linkage takes at a place. Steps of
Radau's method with three points go from position to position, in halves where one is too long: a
polynomial of degree 3 meets the equation at the points, of which the last is the end; its end is
right to order 5, and a run that settles within a step ends where it settles. A turn that begins too
fast ends slower and one that begins too slow ends faster, or stands: Newton's method between such
two, from the motor's speed without load down, finds the one that repeats. Where turns that slow
down and turns that stand leave nothing between them, the motor stalls.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from loads.bodies import FloatArray, LinkageError
from loads.pace import Geared

Place = Callable[[int, int], str]
Row = tuple[float, float, float]  # J, b and c of a place

_ROOT = sqrt(6.0)
STEP_PLACES = ((4.0 - _ROOT) / 10.0, (4.0 + _ROOT) / 10.0, 1.0)
_SAME = 1e-10  # of the squared speed: how far from the turn that repeats another may begin
_ROUNDING = 1e-14  # of the squared speed: gain of a turn that repeats, by rounding alone
_SURE = 1e-6  # of the squared speed: how far that may leave it
_MOST_SPEED = 2.0  # of the speed without load: a load that drives faster runs away
_STILL = 1e-8  # of the squared speed without load: the machine stands
_STALLS = 1e-6  # of the squared speed: turns that stand and turns that slow down lie as close
_STIFFEST = 1e9  # 1/rad, of a difference in squared speed: rounding moves dw/ds by 1e-7 of w
_MOST_TURNS = 200
_MOST_STEPS = 12  # of Newton's method
_MOST_HALVES = 20


def _weights() -> list[list[float]]:
    """Integrals up to each point of the polynomials that are 1 at one point and 0 at the others."""
    powers = np.arange(3)
    values = np.array(STEP_PLACES)[:, None] ** powers
    integrals = np.array(STEP_PLACES)[:, None] ** (powers + 1) / (powers + 1)
    weights: list[list[float]] = (integrals @ np.linalg.inv(values)).tolist()
    return weights


def _cubics(share: FloatArray) -> FloatArray:
    """Cubics (n, 4), at shares (n,) of a step, that are 1 at its start or one of its points."""
    places = np.array([0.0, *STEP_PLACES])
    powers = np.arange(4)
    return np.asarray(share[:, None] ** powers @ np.linalg.inv(places[:, None] ** powers))


_WEIGHTS = _weights()


class StallError(LinkageError):
    """A motor that cannot turn a linkage over."""


class RunawayError(LinkageError):
    """A load that drives its motor away."""


class UnsettledError(LinkageError):
    """A run of a motor that the numerics did not find."""


def with_points(grid: FloatArray) -> FloatArray:
    """Return a grid (n,) with two places between each two, where a step meets its equation.

    (3 n - 2,)
    """
    steps = np.diff(grid)
    between = grid[:-1, None] + steps[:, None] * np.array(STEP_PLACES[:2])
    return np.append(np.column_stack([grid[:-1], between]).ravel(), grid[-1])


@dataclass(frozen=True, eq=False)
class Turn:
    """One turn of a motor.

    ways     per phase (3 m + 1,) rad since the start of the turn, `with_points`
    inertia  per phase (3 m + 1,) t mm2, of all that turns
    linear   per phase b (t mm2) and c (N mm) of the torque that is taken, (3 m + 1,) each
    place    where way i of phase k is, in words
    """

    motor: Geared
    ways: Sequence[FloatArray]
    inertia: Sequence[FloatArray]
    linear: Sequence[tuple[FloatArray, FloatArray]]
    place: Place

    def __post_init__(self) -> None:
        for k, inertia in enumerate(self.inertia):
            if not (inertia > 0.0).all():
                raise LinkageError(
                    f"nothing that the motor turns has a mass at "
                    f"{self.place(k, int(np.argmin(inertia)))}: state the masses of the bodies, or "
                    "drive.flywheel"
                )

    def repeated(self, known: float | None) -> list[tuple[FloatArray, FloatArray]]:
        """Squared speeds and their slopes per phase, (3 m + 1,) each, of the turn that repeats.

        known  where such a turn began under nearly the same demand

        Raises StallError where the motor stops, RunawayError where the load drives it on,
        UnsettledError where no turn is found.
        """
        free = self.motor.free_speed**2
        low, high, stall = _STILL * free, np.inf, None  # it begins between them
        begin = free if known is None else known
        for _ in range(_MOST_TURNS):
            try:
                turn, ahead = self._from(begin), -np.inf
            except RunawayError as runaway:
                raise runaway if stall is None else stall from None
            if isinstance(turn, StallError):
                low, stall = begin, turn
            else:
                path, share = turn
                gain = float(path[-1][0][-1]) - begin
                # share < 1: turns beside it come closer; Newton's distance is gain / (1 - share)
                if share < 1.0 and self._is_repeated(abs(gain) / begin, 1.0 - share):
                    self._check_digits(path)
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

    def slopes(self, k: int, way: FloatArray, squares: FloatArray) -> FloatArray:
        """Slopes of squared speeds (n,) at ways in phase k, by the equation of a turn."""
        knots = self.ways[k][::3]
        step = np.clip(np.searchsorted(knots, way, side="right") - 1, 0, len(knots) - 2)
        share = (way - knots[step]) / (knots[step + 1] - knots[step])
        rows = np.column_stack([self.inertia[k], *self.linear[k]])[3 * step[:, None] + np.arange(4)]
        between = np.einsum("nk,nkr->nr", _cubics(share), rows).tolist()
        return np.array(
            [self._slope(w, row)[0] for w, row in zip(squares.tolist(), between, strict=True)]
        )

    def _check_digits(self, path: Sequence[tuple[FloatArray, FloatArray]]) -> None:
        """Raise where rounding of the speed leaves its change no digits."""
        for k, (squares, _) in enumerate(path):
            rows = np.column_stack([self.inertia[k], *self.linear[k]]).tolist()
            for i, (w, row) in enumerate(zip(squares.tolist(), rows, strict=True)):
                if abs(self._slope(w, row)[1]) > _STIFFEST:
                    raise UnsettledError(
                        "the motor holds its speed to what rounding leaves of it, at "
                        f'{self.place(k, i)}: drive.control = "constant" states that'
                    )

    @staticmethod
    def _is_repeated(gain: float, closer: float) -> bool:
        return gain <= _SAME * closer or (gain <= _ROUNDING and gain <= _SURE * closer)

    def _from(self, begin: float) -> tuple[list[tuple[FloatArray, FloatArray]], float] | StallError:
        """The turn that begins at a squared speed, and how its end changes with it.

        A StallError where the motor stops on the way. Raises RunawayError, and UnsettledError where
        no step is short enough.
        """
        found, w, share = [], begin, 1.0
        for k, way in enumerate(self.ways):
            rows = np.column_stack([self.inertia[k], *self.linear[k]]).tolist()
            steps = np.diff(way[::3]).tolist()
            squares, slopes = [w], [self._slope(w, rows[0])[0]]
            for i, step in enumerate(steps):
                own = _Step(self._slope, self._least, step, rows[3 * i : 3 * i + 4])
                taken = own.taken(w)
                if taken is None:
                    if self.motor.torque(0.0)[0] >= max(row[2] for row in own.rows):
                        raise UnsettledError(
                            f"the speed of the motor cannot be followed beyond "
                            f"{self.place(k, 3 * i)}"
                        )
                    return self._stalled(k, 3 * i)
                values, closer = taken
                squares += [value for value, _ in values]
                slopes += [slope for _, slope in values]
                w, share = squares[-1], share * closer
                if not w <= 4.0 * _MOST_SPEED**2 * self.motor.free_speed**2:
                    raise self._runaway()
            found.append((np.array(squares), np.array(slopes)))
        return found, share

    @property
    def _least(self) -> float:
        return _STILL * self.motor.free_speed**2

    def _slope(self, w: float, row: Row) -> tuple[float, float]:
        """dw/ds, and its derivative by w."""
        inertia, b, c = row
        speed = sqrt(w)
        torque, steepness = self.motor.torque(speed)
        return 2.0 * (torque - b * w - c) / inertia, 2.0 * (0.5 * steepness / speed - b) / inertia

    def _runaway(self) -> RunawayError:
        return RunawayError(
            f"the load drives the motor to more than {_MOST_SPEED:g} times its speed without load, "
            f"{self.motor.free_speed:.4g} rad/s at the angle: more than the motor can brake"
        )

    def _stalled(self, k: int, i: int) -> StallError:
        """The machine stands beyond way i of phase k: where, and what torque is missing."""
        slow = [c for _, c in self.linear]
        worst = max(range(len(slow)), key=lambda number: float(slow[number].max()))
        at = int(slow[worst].argmax())
        needed, most = float(slow[worst][at]), self.motor.largest_torque
        missing = f", {(needed - most) * 1e-3:.4g} N m are missing" if needed > most else ""
        return StallError(
            f"the motor stalls at {self.place(k, i)}: turned slowly, the linkage takes up to "
            f"{needed * 1e-3:.4g} N m, at {self.place(worst, at)}; the motor gives "
            f"{most * 1e-3:.4g} N m at most and {self.motor.torque(0.0)[0] * 1e-3:.4g} N m from "
            f"rest{missing}; more inertia in drive.flywheel carries it over, or a stronger motor"
        )


@dataclass(frozen=True)
class _Step:
    """A step between two positions.

    least   w of a machine that stands
    length  rad; rows: at its start and its three points
    """

    slope: Callable[[float, Row], tuple[float, float]]
    least: float
    length: float
    rows: Sequence[Row]

    def taken(self, w: float) -> tuple[list[tuple[float, float]], float] | None:
        """Squared speeds and slopes at the three points, and how the last changes with w.

        None where the machine stands, or no part of the step is short enough.
        """
        whole = self._solved(w, self.length, self.rows[1:])
        if whole is not None:
            return whole
        return self._in_parts(w)

    def _in_parts(self, w: float) -> tuple[list[tuple[float, float]], float] | None:
        """The same by halves, and halves of these, that Newton's method solves."""
        values, closer, start = [], 1.0, 0.0
        for point in STEP_PLACES:
            part, taken = point - start, None
            while start < point:
                part = min(part, point - start)
                rows = [self._row(start + share * part) for share in STEP_PLACES]
                taken = self._solved(w, part * self.length, rows)
                if taken is None:
                    part *= 0.5
                    if part < 0.5**_MOST_HALVES:
                        return None
                    continue
                (*_, (w, _)), own = taken
                closer *= own
                start = point if start + part >= point - 1e-12 else start + part
                part *= 2.0
            values.append((w, self.slope(w, self._row(point))[0]))
        return values, closer

    def _row(self, share: float) -> Row:
        """J, b and c at a share of the step: the cubic through its four rows."""
        inertia, b, c = (_cubics(np.array([share]))[0] @ np.array(self.rows)).tolist()
        return inertia, b, c

    def _solved(
        self, w: float, length: float, rows: Sequence[Row]
    ) -> tuple[list[tuple[float, float]], float] | None:
        """Radau's equations by Newton's method; None where that fails or a speed is too small."""
        at, before = [w, w, w], np.inf
        for _ in range(_MOST_STEPS):
            states = [self.slope(value, row) for value, row in zip(at, rows, strict=True)]
            left = [
                value - w - length * sum(a * f for a, (f, _) in zip(weights, states, strict=True))
                for value, weights in zip(at, _WEIGHTS, strict=True)
            ]
            matrix = [
                [(i == j) - length * _WEIGHTS[i][j] * states[j][1] for j in range(3)]
                for i in range(3)
            ]
            change = _eliminated(matrix, left)
            size = max(abs(part) / value for part, value in zip(change, at, strict=True))
            # rounding leaves a change that gets no smaller
            if size <= 1e-15 or before <= size <= 1e-11:
                values = [(value, f) for value, (f, _) in zip(at, states, strict=True)]
                return values, _eliminated(matrix, [1.0, 1.0, 1.0])[2]
            at = [value - part for value, part in zip(at, change, strict=True)]
            if not min(at) >= self.least:
                return None
            before = size
        return None


def _eliminated(matrix: Sequence[Sequence[float]], right: Sequence[float]) -> list[float]:
    """Solution of three equations by Cramer's rule: numpy's calls take longer than all of it."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    x, y, z = right
    ei, di, dh = e * i - f * h, d * i - f * g, d * h - e * g
    whole = a * ei - b * di + c * dh
    yi, yh, dz = y * i - f * z, y * h - e * z, d * z - y * g
    return [
        (x * ei - b * yi + c * yh) / whole,
        (a * yi - x * di + c * dz) / whole,
        (-a * yh - b * dz + x * dh) / whole,
    ]
