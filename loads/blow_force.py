"""Force over time of a blow: an elastic linkage, by its modes, strikes a workpiece that gives way.

The linkage's drive keeps its rate, so the point that strikes goes on towards the workpiece with the
speed v before the blow, less what the modes yield: with modal coordinates q of unit modal mass,
shapes phi of the point along the contact, and the force F of the workpiece,

    q'' + 2 zeta omega q' + omega^2 q = phi F,     delta = v t - phi . q

where delta is the approach (Clough and Penzien, Dynamics of Structures, ch. 12: mode
superposition). An anvil that gives way is one more mode, phi = 1/sqrt(m), omega = sqrt(k/m). Modes
that are left out, and what yields without mass, are a compliance c behind the workpiece's stiffness
k: 1/k' = 1/k + c. The workpiece is elastic up to its yield force F_y, and plastic beyond:
F = k' (delta - p), where p grows so that F never exceeds F_y. Without any compliance F is F_y as
long as it is pressed in; then it holds the point, F = phi . omega^2 q / phi^2, until that is
negative or above F_y.

Between changes of these states the equations are linear; they are integrated by SciPy's DOP853 with
the changes as events. A blow is over when the force has gone, or the pressing in ended, and nothing
is struck in as long a time again, and in half a period of every mode that swings, but for the
softest: that is the motion with which the point came. It is followed for that time, too. Not all
modes are needed: their number is doubled until the largest force, the impulse and the largest
deformation move by less than 0.5 %.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import inf, isinf, pi, sqrt
from typing import Any

import numpy as np

from loads.bodies import FloatArray, LinkageError

_FIRST = 4  # modes
_PERIODS = 3.0
_SETTLED = 0.005  # relative change by twice as many modes
_SAMPLES = (60, 600)
_PER_PERIOD = 16  # samples, of the fastest mode that tells: a peak between two is 2 % of it at most
_TELLS = 0.02  # of the largest deformation of all modes together
_TOLERANCE = 1e-9
_LONGEST = 4.0  # time scales of a blow, for which what the drive presses on is followed
_MOST_CHANGES = 2000
_NONE = 1e-9  # of the yield force
_AT_ONCE = 1e3  # rad, that an anvil swings in the time of a blow
_RIGID = 1e-3  # of the depth by plasticity alone: an elastic deformation that is left out


@dataclass(frozen=True)
class _Event:
    """Where a value changes its sign, as SciPy's solvers ask: 1 rising, -1 falling, 0 both.

    A change of one direction ends a state; both ways it is only kept, as the largest force is.
    """

    value: Callable[[float, FloatArray], float]
    direction: float

    def __call__(self, time: float, state: FloatArray) -> float:
        return self.value(time, state)

    @property
    def terminal(self) -> bool:
        return self.direction != 0.0


@dataclass(frozen=True)
class Struck:
    """A workpiece, and the anvil beneath it.

    stiffness        N/mm, infinite without elasticity
    yields           N, force at which it is pressed in for good; infinite for never
    anvil_mass       t; 0 for an anvil that does not move
    anvil_stiffness  N/mm, between the anvil and the ground
    """

    stiffness: float = inf
    yields: float = inf
    anvil_mass: float = 0.0
    anvil_stiffness: float = 0.0

    def __post_init__(self) -> None:
        if not (self.stiffness > 0.0 and self.yields > 0.0):
            raise LinkageError("stiffness and yield force of a workpiece must be above 0")
        if isinf(self.stiffness) and isinf(self.yields):
            raise LinkageError("a workpiece that is struck must yield or have a stiffness")
        if (self.anvil_mass > 0.0) != (self.anvil_stiffness > 0.0):
            raise LinkageError("an anvil that moves has a mass and a stiffness, both above 0")


@dataclass(frozen=True, eq=False)
class Course:
    """Way of the point that strikes towards the workpiece, without the answer of its modes.

    at     way, its rate and its change: mm, mm/s and mm/s2 at a time in s
    modal  (k,) mm sqrt(t) and rates (k,) mm sqrt(t)/s, of the modes at time 0
    """

    at: Callable[[float], tuple[float, float, float]]
    modal: FloatArray
    rates: FloatArray

    @staticmethod
    def steady(speed: float, count: int) -> "Course":
        """The course of a point that moves on at a speed in mm/s, and of modes at rest."""
        return Course(lambda time: (speed * time, speed, 0.0), np.zeros(count), np.zeros(count))


@dataclass(frozen=True, eq=False)
class BlowForce:
    """The force of a blow, and the modes that answer to it.

    times     (n,) s from the first touch
    force     (n,) N on the point that strikes
    modal     (n, modes) mm sqrt(t); modes that were left out follow statically
    contact   s until the force has gone, and stays away as long again; infinite where the drive
              presses on
    deepest   mm, largest approach since the first touch
    depth     mm that the workpiece is pressed in for good
    energy    N mm left in the workpiece
    rebound   mm/s at which the point leaves the workpiece; 0 while they touch
    kept      number of modes in the integration; highest  1/s, the highest of their frequencies
    missing   energy that is not accounted for, over the energy that the drive and the motion gave
    """

    times: FloatArray
    force: FloatArray
    modal: FloatArray
    contact: float
    deepest: float
    depth: float
    energy: float
    rebound: float
    kept: int
    highest: float
    missing: float

    @property
    def lasts(self) -> float:
        """Time of contact as far as it was followed, or of a half wave of the same impulse, s."""
        wave = 0.5 * pi * self.impulse / float(self.force.max())
        return min(self.contact, float(self.times[-1]), wave)

    @property
    def unresolved(self) -> float:
        """Three periods of the fastest mode over the time of contact: at most 1 where it counts."""
        return _PERIODS / (self.lasts * self.highest) if self.highest else inf

    @property
    def impulse(self) -> float:
        """Impulse of the force over the time that was followed, N s."""
        return float(np.trapezoid(self.force, self.times))


def blow_force(
    omega: FloatArray,
    shapes: FloatArray,
    compliance: float,
    speed: float,
    struck: Struck,
    damping: float = 0.0,
    holds: float = inf,
    course: Course | None = None,
) -> BlowForce:
    """Return the force of a blow.

    omega       (k,) rad/s, ascending; 0 for a motion that nothing holds back
    shapes      (k,) 1/sqrt(t), of the point that strikes, along the contact
    compliance  mm/N of the point without mass
    speed       mm/s towards the workpiece
    damping     ratio of every mode
    holds       s, for which the modes are those of this pose: slower swing is followed no longer
    course      from the touch; None: steady, at that speed

    Raises LinkageError where the blow cannot be followed.
    """
    course = Course.steady(speed, len(omega)) if course is None else course
    count = min(_FIRST, len(omega))

    def with_modes(count: int) -> BlowForce:
        swings = damping, holds
        run = run_of(omega, shapes, compliance, speed, struck, swings, count, course)
        return _followed(run, omega, shapes, struck, count)

    found = with_modes(count)
    while count < len(omega):
        count = min(2 * count, len(omega))
        before = found
        found = with_modes(count)
        sizes = zip(_sizes(before, omega), _sizes(found, omega), strict=True)
        settled = all(abs(one - other) <= _SETTLED * other for one, other in sizes)
        if settled and found.unresolved <= 1.0:
            break
    return found


def _sizes(blow: BlowForce, omega: FloatArray) -> tuple[float, float, float]:
    """Largest force, impulse, and largest deformation of all modes."""
    deformed = np.linalg.norm(blow.modal * omega, axis=1)
    return float(blow.force.max()), blow.impulse, float(deformed.max())


def _followed(
    run: "BlowRun", omega: FloatArray, shapes: FloatArray, struck: Struck, count: int
) -> BlowForce:
    """The blow with the lowest modes alone; the others yield without mass."""
    follow = shapes[count:] / omega[count:] ** 2
    times, states = run.followed()
    force = run.forces(times, states)
    modal = np.concatenate([states[:, :count], force[:, None] * follow], axis=1)
    elastic = 0.5 * float(force[-1]) ** 2 / struck.stiffness
    depths = [run.depth(time, state) for time, state in zip(times, states, strict=True)]
    return BlowForce(
        times=times,
        force=force,
        modal=modal,
        contact=run.contact,
        deepest=max(depths),
        depth=run.set,
        energy=float(states[-1, -3]) - elastic,
        rebound=run.rebound if force[-1] == 0.0 else 0.0,
        kept=count,
        highest=float(omega[:count].max()) / (2.0 * pi),
        missing=run.missing(states[-1]),
    )


def run_of(
    omega: FloatArray,
    shapes: FloatArray,
    compliance: float,
    speed: float,
    struck: Struck,
    swings: tuple[float, float],
    count: int,
    course: Course,
) -> "BlowRun":
    """Return the run of the lowest modes, and of the anvil; the other modes yield without mass.

    swings  damping, and time for which the pose holds
    """
    left = (shapes[count:] / omega[count:]) ** 2
    own, along = omega[:count], shapes[:count]
    still = 0.0
    if struck.anvil_mass and not _follows(struck, own, along, speed):
        own = np.append(own, sqrt(struck.anvil_stiffness / struck.anvil_mass))
        along = np.append(along, 1.0 / sqrt(struck.anvil_mass))
    elif struck.anvil_mass:
        still = 1.0 / struck.anvil_stiffness
    yielding = 1.0 / struck.stiffness + compliance + still + float(left.sum())
    pressed_in = 0.5 * speed**2 / float(along @ along) / struck.yields
    if isinf(struck.stiffness) and yielding * struck.yields < _RIGID * pressed_in:
        yielding = 0.0
    return BlowRun(own, along, yielding, speed, struck.yields, swings, count, course)


def _follows(struck: Struck, omega: FloatArray, along: FloatArray, speed: float) -> bool:
    """True for an anvil that answers far sooner than the blow lasts: it has no mass then."""
    mass = 1.0 / float(along @ along)
    lasts = pi * sqrt(mass / struck.stiffness) + mass * speed / struck.yields
    own = sqrt(struck.anvil_stiffness / struck.anvil_mass)
    return own > _AT_ONCE / lasts and own > _AT_ONCE * 1e-2 * float(omega.max(initial=0.0))


class BlowRun:
    """The states of a blow, one after another.

    A state vector holds q, q', then integrals over time: force times approach (the work on the
    workpiece with its compliance), force times v, dissipation in the modes.
    """

    def __init__(
        self,
        omega: FloatArray,
        along: FloatArray,
        yielding: float,
        speed: float,
        yields: float,
        swings: tuple[float, float],
        linkage: int,
        course: Course,
    ) -> None:
        self.omega, self.along = omega, along
        self.damping, self.holds = swings
        self.linkage = linkage  # number of modes that are the linkage's
        self.course = course
        started = np.zeros((2, len(omega)))
        started[:, :linkage] = course.modal[:linkage], course.rates[:linkage]
        self.state = np.concatenate([started.ravel(), np.zeros(3)])
        self.given = self.energy(self.state)
        self.stiffness = 1.0 / yielding if yielding > 0.0 else inf
        self.speed, self.yields = speed, yields
        self.set = 0.0
        self.contact, self.rebound = inf, 0.0
        self.pieces: list[tuple[float, str, float]] = []  # start, state and set of each
        self.tolerance = _TOLERANCE

    def approach(self, time: float, state: FloatArray) -> float:
        """Rate at which the point comes nearer, mm/s."""
        n = len(self.omega)
        return self.course.at(time)[1] - float(self.along @ state[n : 2 * n])

    def depth(self, time: float, state: FloatArray) -> float:
        """Approach since the first touch, mm."""
        return self.course.at(time)[0] - float(self.along @ state[: len(self.omega)])

    def force(self, mode: str, time: float, state: FloatArray) -> float:
        """Force in one of the states elastic, plastic, held, free."""
        if mode == "free":
            return 0.0
        if mode == "plastic":
            return self.yields
        if mode == "held":
            pull = self.along @ self._back(state) + self.course.at(time)[2]
            return float(pull) / float(self.along @ self.along)
        return self.stiffness * (self.depth(time, state) - self.set)

    def _back(self, state: FloatArray) -> FloatArray:
        """Accelerations by which springs and damping of the modes bring them back."""
        n = len(self.omega)
        drag = 2.0 * self.damping * self.omega * state[n : 2 * n]
        return np.asarray(self.omega**2 * state[:n] + drag)

    def forces(self, times: FloatArray, states: FloatArray) -> FloatArray:
        """Force at every sample."""
        starts = [start for start, _, _ in self.pieces]
        found = np.empty(len(times))
        last = self.set
        for row, (time, state) in enumerate(zip(times, states, strict=True)):
            _, mode, self.set = self.pieces[max(int(np.searchsorted(starts, time, "right")) - 1, 0)]
            found[row] = self.force(mode, time, state)
        self.set = last
        return found

    def followed(self) -> tuple[FloatArray, FloatArray]:
        """Samples of times and states."""
        state = self.state
        time, mode = 0.0, "plastic" if isinf(self.stiffness) else "elastic"
        end = _LONGEST * self._longest()
        solutions, peaks = [], []
        while time < end:
            found = self.piece(mode, time, end, state)
            solutions.append((time, found.sol))
            peaks += [float(at) for one in found.t_events for at in one]
            time, state = float(found.t[-1]), found.y[:, -1]
            if found.status != 1:
                break
            mode = self.following(mode, time, state)
            if mode in ("free", "held"):
                self.contact, self.rebound = time, max(-self.approach(time, state), 0.0)
                end = time + max(time, min(self._swing(state), self.holds))
        if mode == "plastic":
            self.set = self._pressed(time, state)
        fastest = self._fastest(np.array([sol(t) for _, sol in solutions for t in sol.ts]))
        count = int(np.clip(_PER_PERIOD * fastest * end / (2.0 * pi), *_SAMPLES))
        peaks = [at for at in peaks if at <= end]
        times = np.unique(np.r_[np.linspace(0.0, end, count), peaks])
        starts = [start for start, _ in solutions]
        rows = np.maximum(np.searchsorted(starts, times, "right") - 1, 0)
        return times, np.array([solutions[k][1](t) for k, t in zip(rows, times, strict=True)])

    def piece(self, mode: str, time: float, end: float, state: FloatArray) -> Any:
        """SciPy's solution of one state, until it ends."""
        from scipy.integrate import solve_ivp

        if len(self.pieces) > _MOST_CHANGES:
            raise LinkageError("a blow that touches and leaves without end cannot be followed")
        self.pieces.append((time, mode, self.set))
        n, longest = len(self.omega), self._longest()
        root = self.speed / sqrt(float(self.along @ self.along))
        scale = np.concatenate([np.full(n, root * longest), np.full(n, root), np.full(3, root**2)])
        return solve_ivp(
            partial(self._rates, mode), (time, end), state, method="DOP853",
            events=self._events(mode), rtol=self.tolerance, atol=1e-3 * self.tolerance * scale,
            dense_output=True, max_step=end / 20.0,
        )  # fmt: skip

    def _longest(self) -> float:
        """Time scale of the whole blow, s: the softest mode on all that yields besides it."""
        softest = self._softest()
        mass = 1.0 / float(self.along[softest]) ** 2
        soft = float(np.delete(self._yields(), softest).sum())
        soft += 0.0 if isinf(self.stiffness) else 1.0 / self.stiffness
        return pi * sqrt(mass * soft) + mass * self.speed / self.yields

    def _softest(self) -> int:
        """The mode of the linkage that yields most at the point that strikes."""
        return int(self._yields()[: self.linkage].argmax())

    def _yields(self) -> FloatArray:
        """Compliance of each mode at the point that strikes, mm/N."""
        found = np.full(len(self.omega), inf)
        held = self.omega > 0.0
        found[held] = (self.along[held] / self.omega[held]) ** 2
        return found

    def _swing(self, state: FloatArray) -> float:
        """Half a period of the linkage's slowest mode that a blow has set swinging, s.

        Without the softest at the point that strikes: that is the motion with which it came.
        """
        n = len(self.omega)
        size = np.hypot(self.omega * state[:n], state[n : 2 * n])
        size[self._softest()] = 0.0
        size[self.linkage :] = 0.0
        told = self.omega[(size >= _TELLS * np.linalg.norm(size)) & (self.omega > 0.0)]
        return pi / float(told.min()) if len(told) and size.any() else 0.0

    def _fastest(self, states: FloatArray) -> float:
        """Frequency of the fastest mode whose deformation counts, rad/s."""
        deformed = np.abs(self.omega * states[:, : len(self.omega)])
        largest = np.linalg.norm(deformed, axis=1).max()
        return float(self.omega[deformed.max(axis=0) >= _TELLS * largest].max(initial=0.0))

    def missing(self, state: FloatArray) -> float:
        """Energy that is not accounted for, relative."""
        kept = self.energy(state)
        work, given, lost = state[2 * len(self.omega) :]
        left = float(self.given + given - kept - work - lost)
        return abs(left) / float(self.given + abs(given) + kept)

    def energy(self, state: FloatArray) -> float:
        """Energy of the modes, N mm."""
        n = len(self.omega)
        return 0.5 * float((state[n : 2 * n] ** 2 + (self.omega * state[:n]) ** 2).sum())

    def _rates(self, mode: str, time: float, state: FloatArray) -> FloatArray:
        n = len(self.omega)
        force = self.force(mode, time, state)
        rates = state[n : 2 * n]
        lost = float(rates @ (2.0 * self.damping * self.omega * rates))
        return np.concatenate(
            [rates, self.along * force - self._back(state),
             [force * self.approach(time, state), force * self.course.at(time)[1], lost]]
        )  # fmt: skip

    def _events(self, mode: str) -> list[_Event]:
        none = _NONE * self.yields if mode == "held" else 0.0

        def gone(time: float, state: FloatArray) -> float:
            return self.force(mode, time, state) + none

        def too_much(time: float, state: FloatArray) -> float:
            return self.force(mode, time, state) - self.yields

        ends = self.approach

        def meets(time: float, state: FloatArray) -> float:
            return self.depth(time, state) - self.set

        yields = [] if isinf(self.yields) else [_Event(too_much, 1.0)]
        return {
            "elastic": [_Event(gone, -1.0), *yields, _Event(ends, 0.0)],
            "held": [_Event(gone, -1.0), *yields],
            "plastic": [_Event(ends, -1.0)],
            "free": [_Event(meets, 1.0)],
        }[mode]

    def _pressed(self, time: float, state: FloatArray) -> float:
        """Depth without the elastic part of the yield force, mm."""
        elastic = 0.0 if isinf(self.stiffness) else self.yields / self.stiffness
        return self.depth(time, state) - elastic

    def following(self, mode: str, time: float, state: FloatArray) -> str:
        """The state after an event of another one."""
        rigid = isinf(self.stiffness)
        if mode == "plastic":
            self.set = self._pressed(time, state)
            if not rigid:
                return "elastic"
            return "held" if self.force("held", time, state) >= -_NONE * self.yields else "free"
        if mode == "free":
            return "plastic" if rigid else "elastic"
        return "plastic" if self.force(mode, time, state) > 0.5 * self.yields else "free"
