"""Speed at which a motor turns a linkage over and over.

The torque D that the linkage takes at a place depends on speed and acceleration, by its inertia and
by its joints' friction. D is linearised about a run, D = a dv/dt + b v^2 + c, which is exact where
nothing rubs; the turn that repeats is found (`loads/turning.py`), D is linearised about it, and so
on until the run stays.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from loads.bodies import FloatArray
from loads.motors import Geared
from loads.turning import Place, Turn, UnsettledError

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

# torque (n,) that the linkage takes in phase k at squared speeds and accelerations (n,)
Demand = Callable[[int, FloatArray, FloatArray], FloatArray]
Run = tuple[FloatArray, FloatArray]  # squared speeds and accelerations (n,) of a phase
Linear = tuple[FloatArray, FloatArray, FloatArray]  # a, b and c (n,) of a phase

_SETTLED = 1e-9  # of the squared speed: change by another linearisation of a run that stays
_ROUGH = 1e-3  # of the squared speed: change that asks for slopes anew
_LEAST_SHARE = 1 / 8  # of a change that is gone where runs do not settle
_MOST_ROUNDS = 60
_GAUSS = np.polynomial.legendre.leggauss(6)


@dataclass(frozen=True, eq=False)
class SolvedPace:
    """Speeds over the way, phase by phase.

    phases  squared speed, rad2/s2, over the way since the start of the cycle, rad
    starts  (phases,) s, the time at which each begins
    turn    the linear problem that they solve
    """

    phases: "Sequence[CubicHermiteSpline]"
    starts: FloatArray
    turn: Turn

    def rates(self, k: int, way: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Speed and acceleration (n,) at ways in phase k."""
        squares = np.asarray(self.phases[k](way))
        return np.sqrt(squares), 0.5 * self.turn.slopes(k, way, squares)

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
    ways     per phase (3 m + 1,) rad, of the motor's coordinate since the start of the cycle:
             `with_points` of positions
    inertia  t mm2, of all that turns with the coordinate besides linkage and rotor
    start    rad/s, a speed to begin with
    place    where way i of phase k is, in words

    Raises StallError where the motor stops, RunawayError where the load drives it on, LinkageError
    where nothing has a mass, UnsettledError where no run is found.
    """
    runs = [(np.full(len(way), start**2), np.zeros(len(way))) for way in ways]
    whole = inertia + motor.reflected
    linear: list[Linear] = []
    known, change, share, switching = None, np.inf, 1.0, False
    for _ in range(_MOST_ROUNDS):
        anew = change > _ROUGH or switching
        linear = [
            _linearised(demand, k, run, whole, None if anew else linear[k])
            for k, run in enumerate(runs)
        ]
        turn = Turn(
            motor,
            ways,
            [whole + a for a, _, _ in linear],
            [(b, c) for _, b, c in linear],
            place,
        )
        found = turn.repeated(known)
        known, before = float(found[0][0][0]), change
        change = max(
            float((np.abs(new - old) / new).max())
            for (new, _), (old, _) in zip(found, runs, strict=True)
        )
        if change < _SETTLED:
            return _pace(turn, found)
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


def _linearised(demand: Demand, k: int, run: Run, whole: float, known: Linear | None) -> Linear:
    """Torque that a phase takes near a run, with known slopes a and b, or with slopes anew."""
    squares, accelerations = run
    taken, more = demand(k, squares, accelerations), 0.01 * squares
    if known is None:
        b = (demand(k, squares + more, accelerations) - taken) / more
        a = (demand(k, squares, accelerations + more) - taken) / more
        a = np.maximum(a, -0.5 * whole)  # less is the jump of a contact that opens
    else:
        a, b, _ = known
    return a, b, taken - a * accelerations - b * squares


def _pace(turn: Turn, found: Sequence[tuple[FloatArray, FloatArray]]) -> SolvedPace:
    from scipy.interpolate import CubicHermiteSpline  # half a second that few linkages need

    splines = [
        CubicHermiteSpline(way, w, slope) for way, (w, slope) in zip(turn.ways, found, strict=True)
    ]
    took = [float(_time_along(spline, spline.x[-1:])[0]) for spline in splines]
    return SolvedPace(splines, np.concatenate([[0.0], np.cumsum(took)[:-1]]), turn)
