"""The swing of a linkage between blows: what strikes leaves its workpiece, swings, strikes again.

A contact of which the workpiece's answer is stated is no load of known size, and no support either:
its force follows from where the swinging linkage is. The loads without it, a(t) of each mode over
the cycle, are taken as they act (`loads/harmonics.py` judges whether they may be, and can put on
them what vibration adds); the force F of the contact does the rest, by the equations of a blow
(`loads/blow_force.py`):

    q'' + 2 zeta omega q' + omega^2 q = phi F,     delta = G(t) - phi . q

where G is the way of the struck point of the free linkage, deflected by its loads, beyond the place
of the contact. Cycle follows cycle until one ends as it began; in each the workpiece is a new one,
unless it is touched as the cycle begins.
Modes that the contact hardly moves follow F statically. Frequencies and phi are those of the touch.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from loads.blow_force import BlowRun, Course, Struck, run_of
from loads.blow_loads import BlowLoads, Swinging, blow_loads
from loads.bodies import FloatArray, IntArray, LinkageError
from loads.contact import rigidly_joined, solve_laws
from loads.cycle_loads import CycleLoads
from loads.forces import ForceSolution, one_after_another, unit_forces
from loads.harmonics import SAMPLES, CycleResponse, sampled
from loads.kinematics import Kinematics
from loads.laws import Contact
from loads.motion import differentiate
from loads.pace import Cycle
from loads.vibration import grown, joint_strains, pushed_motion, with_body_loads

_SHARE = 0.05  # of the compliance of all modes at the contact: one below it follows statically
_STIFF = 0.01  # of it: what gives way without mass before a workpiece that only yields is rigid
_TOLERANCE = 1e-7
_TURNS = 40  # cycles, one after another, at most
_REPEATS = 0.005  # of the largest deformation: what the next cycle may begin with otherwise
_SOON = 1e-2  # of a sample's step after it has left: nothing is met again before
_ROUND_OFF = 1e-12  # of the way
_STEEP, _CLOSE = 3.0, 1e-4  # times the steepest rate elsewhere, and of the cycle: a jump
_NOISE = 1e-7  # of a signal: no jump
_HARD = 0.2  # of the fastest strike's speed: slower ones do not get moments of their own


@dataclass(frozen=True, eq=False)
class Strike:
    """Where the swinging linkage meets its workpiece in a cycle.

    time, speed   s, and mm/s of approach
    modal, rates  (k,) of the modes, mm sqrt(t) and mm sqrt(t)/s
    """

    time: float
    speed: float
    modal: FloatArray
    rates: FloatArray


@dataclass(frozen=True, eq=False)
class Swing:
    """A cycle in which the linkage swings by the force of a contact, after as many as it takes.

    force    (n,) N at the times asked for
    modal    (n, k) mm sqrt(t)
    strikes  in their order
    turns    cycles until it repeats
    changed  by how much the next cycle begins otherwise, over the largest deformation
    missing  energy that is not accounted for, over what motion and drive gave
    depth    mm that the workpiece is pressed in for good in a cycle
    """

    force: FloatArray
    modal: FloatArray
    strikes: tuple[Strike, ...]
    turns: int
    changed: float
    missing: float
    depth: float


def swing(
    omega: FloatArray,
    along: FloatArray,
    compliance: float,
    course: Course,
    speed: float,
    struck: Struck,
    damping: float,
    times: FloatArray,
) -> Swing:
    """Return the swing at times (n,) s of a cycle that ends with the last of them.

    Arguments as in `blow_force`; `course` over the cycle. Raises LinkageError where it touches as
    the cycle begins.
    """
    left = compliance / float((along / omega) @ (along / omega))
    soft = 0.0 if np.isinf(struck.stiffness) and left < _STIFF else compliance
    run = run_of(omega, along, soft, speed, struck, (damping, np.inf), len(omega), course)
    run.tolerance = _TOLERANCE
    state, modes = run.state, len(run.omega)
    turns, changed, mode = 0, np.inf, "free"
    if run.depth(0.0, state) > 0.0:
        raise LinkageError("it touches as the cycle begins")
    while changed > _REPEATS and turns < _TURNS:
        turns += 1
        before = state[: 2 * modes]
        run.given = run.energy(state)
        state = np.append(before, np.zeros(3))
        run.pieces = []
        if mode == "free" and run.depth(0.0, state) <= 0.0:
            run.set = 0.0  # another workpiece
        found, strikes, state, mode = _cycle(run, state, mode, float(times[-1]))
        states = _at(run, found, times)
        deformed = np.hypot(run.omega * states[:, :modes], states[:, modes : 2 * modes])
        change = state[: 2 * modes] - before
        size = float(np.linalg.norm(deformed, axis=1).max())
        moved = float(np.hypot(run.omega * change[:modes], change[modes:]).max())
        changed = moved / size if size else 0.0
    own = len(omega)
    return Swing(
        run.forces(times, states),
        states[:, :own],
        tuple(replace(one, modal=one.modal[:own], rates=one.rates[:own]) for one in strikes),
        turns,
        changed,
        run.missing(state),
        run.set,
    )


@dataclass(frozen=True, eq=False)
class SwungCycle:
    """A cycle whose linkage swings by the blows on a workpiece.

    swing  of its last turn
    loads  with the force of the contact and all that it sets swinging
    blows  its hard strikes, whose moments are not yet among the positions
    surge  range of the work that the swing asks of the drive beyond what its speed has, over twice
           its kinetic energy: how far it does not keep that speed; 0 where it is held
    still  share of the compliance of all modes at the contact in those that follow it statically
    turned  by how much the point gives way otherwise at later poses in touch than at the first,
            over the way that it presses
    """

    swing: Swing
    loads: CycleLoads
    blows: tuple[BlowLoads, ...]
    surge: float
    still: float
    turned: float


def swung_cycle(
    touching: CycleLoads,
    free: CycleLoads,
    elastic: CycleLoads,
    response: CycleResponse,
    force: str,
    law: Contact,
    damping: float,
    inertia: float = np.inf,
    pick: str = "",
    *,
    slowed: bool = False,
) -> SwungCycle:
    """Return a cycle with the swing by its contact's force.

    touching  the cycle with its contact as if slowly
    free      the same without it, with what vibration adds where that is wanted
    elastic   as `free` without vibration, of a linkage in which everything gives way that can
    response  of `elastic` to vibration
    inertia   t or t mm2 on the coordinate of the pace, by which the drive keeps its speed
    pick      "lowest" or "highest" frequency of every mode over the cycle; "": at the touch
    slowed    True where the speed follows from the work of the contact as if slowly

    Raises LinkageError where the cycle begins in touch, none of the followed modes gives way at the
    contact, and as `blow_loads` does.
    """
    assert law.struck is not None
    modes, times = response.modes, free.times
    pushed = pushed_motion(modes, elastic.pace)
    sense = float(law.side * free.linkage.force(force).sign)
    (unit,) = unit_forces(pushed, [force], sense, modes.holder)
    strain = joint_strains(modes.kinematics, modes.motion.poses, unit, modes.lumps)
    rows = np.arange(len(times))
    own = [
        modes.strains[rows, :, response.columns[:, k]] * response.signs[:, k, None]
        for k in range(response.columns.shape[1])
    ]
    shares = np.array([np.einsum("nr,nr->n", strain, one) for one in own])
    row = int(touching.contacts[force].begins[0])
    soft = float(strain[row] @ strain[row])
    modal = float(((modes.strains[row].T @ strain[row]) ** 2).sum())
    kept = np.flatnonzero(shares[:, row] ** 2 >= _SHARE * modal)
    if not len(kept):
        raise LinkageError("none of its six softest modes gives way there")
    swinging_share = float((shares[kept, row] ** 2).sum())
    omega = np.array([_omega(response, int(k), row, pick) for k in kept])
    along = omega * shares[kept, row]
    gap = touching.touches[force].gap.copy()
    if free.reactions is not elastic.reactions:  # vibration is in its way, too
        for share, mode in zip(shares, response.responses, strict=True):
            gap += share * np.interp(times, mode.times, mode.dynamic - mode.slow)
    way = _way(times, -gap, response.responses[0].rise)
    still = np.zeros(len(kept))
    found = swing(
        omega,
        along,
        max(soft - swinging_share, 0.0),
        Course(way, still, still),
        abs(float(touching.rate(force)[row])),
        law.struck,
        damping,
        times,
    )
    loads = _with_swing(
        free, elastic, response, unit, found, omega, kept, shares[:, row], sense, force
    )
    loads = replace(loads, touches=touching.touches, unstruck=touching, swings=True)
    shown = replace(free, touches=touching.touches)
    stretched = replace(free, linkage=elastic.linkage)
    least = _HARD * max((one.speed for one in found.strikes), default=0.0)
    blows = []
    for strike in found.strikes:
        if strike.speed >= least:
            at = int(np.searchsorted(times, strike.time, "right")) - 1
            bent = np.array([own[k][at] for k in kept]).T
            swinging = Swinging(
                strike.time,
                law.side,
                way,
                bent @ (omega * strike.modal),
                bent @ (omega * strike.rates),
            )
            blows.append(
                blow_loads(shown, stretched, force, at, law.struck, damping, swinging=swinging)
            )
    surge = _surge(loads, touching if slowed else free, modes.holder, inertia)
    touch = np.array([own[k][row] for k in kept])
    bent = omega * found.modal - np.outer(found.force, shares[kept, row])
    deformed = bent @ touch + np.outer(found.force, strain[row])
    turned = _turned(found.force, strain, row, deformed, gap)
    return SwungCycle(found, loads, tuple(blows), surge, 1.0 - swinging_share / modal, turned)


def _omega(response: CycleResponse, k: int, row: int, pick: str) -> float:
    one = response.responses[k]
    own = response.modes.frequencies[row, response.columns[row, k]]
    return 2.0 * np.pi * float({"lowest": one.lowest, "highest": one.highest}.get(pick, own))


def _way(
    times: FloatArray, values: FloatArray, rise: float
) -> Callable[[float], tuple[float, float, float]]:
    """Value, rate and change of a periodic signal at a time, by cubic splines."""
    from scipy.interpolate import CubicSpline

    period = float(times[-1])
    even, smooth, _ = sampled(_with_jumps(times, values), values, rise, smooth=True)
    spline = CubicSpline(np.append(even, period), np.append(smooth, smooth[0]), bc_type="periodic")
    cubes, step = spline.c.T.tolist(), period / len(even)

    def at(time: float) -> tuple[float, float, float]:
        place = (time % period) / step
        k = min(int(place), len(cubes) - 1)
        a, b, c, d = cubes[k]
        x = (place - k) * step
        return ((a * x + b) * x + c) * x + d, (3.0 * a * x + 2.0 * b) * x + c, 6.0 * a * x + 2.0 * b

    return at


def _with_jumps(times: FloatArray, values: FloatArray) -> FloatArray:
    """Times of a signal in which steep changes between close ones are jumps."""
    steps, changes = np.diff(times), np.abs(np.diff(values))
    close = steps < _CLOSE * times[-1]
    steepest = float((changes[~close] / steps[~close]).max())
    jump = close & (changes > _STEEP * steepest * steps + _NOISE * np.ptp(values))
    result = times.copy()
    result[1:][jump] = times[:-1][jump]
    return result


def _with_swing(
    free: CycleLoads,
    elastic: CycleLoads,
    response: CycleResponse,
    unit: ForceSolution,
    found: Swing,
    omega: FloatArray,
    kept: IntArray,
    shares: FloatArray,
    sense: float,
    force: str,
) -> CycleLoads:
    """The free cycle with the contact's force and the inertia of all that it sets swinging."""
    modes, rows = response.modes, np.arange(len(free.times))
    lumped = np.zeros(modes.shapes.shape[:2])
    for place, k in enumerate(kept.tolist()):
        column = response.columns[:, k]
        own = 2.0 * np.pi * modes.frequencies[rows, column]
        shape = modes.shapes[rows, :, column] * response.signs[:, k, None]
        beyond = omega[place] * found.modal[:, place] - shares[k] * found.force
        lumped += modes.lumps.masses * shape * (own * beyond)[:, None]
    moved = with_body_loads(modes, replace(free, linkage=elastic.linkage), lumped)
    reactions = {
        name: grown(load, unit.joints[name], found.force) for name, load in moved.reactions.items()
    }
    efforts = dict(moved.efforts)
    efforts[force] = efforts[force] + sense * found.force
    efforts[modes.holder] = efforts[modes.holder] + unit.efforts[modes.holder] * found.force
    return replace(
        free,
        accelerations=moved.accelerations,
        reactions=reactions,
        efforts=efforts,
        own_swing=moved.own_swing,
    )


def _turned(
    force: FloatArray, strain: FloatArray, row: int, deformed: FloatArray, gap: FloatArray
) -> float:
    """How far the point gives way otherwise at poses in touch than at the first, over its way.

    strain    (n, rows) levers of the force on all that it deforms; row, those of the touch
    deformed  (n, rows) by the force and the swing

    With levers s + d in place of s it is (s + d)^2 F - s^2 F = 2 d s F + d^2 F, where s F is what
    is deformed.
    """
    pressing = force > 0.0
    if not pressing.any():
        return 0.0
    change = strain - strain[row]
    ways = 2.0 * (change * deformed).sum(axis=1) + (change**2).sum(axis=1) * force
    size = np.maximum(np.abs(gap), np.abs(deformed @ strain[row]))
    return float(np.abs(ways[pressing]).max() / size[pressing].max())


def _surge(struck: CycleLoads, known: CycleLoads, holder: str, inertia: float) -> float:
    """Range of the drive's work beside that in a cycle whose speed it has, as in SwungCycle."""
    if np.isinf(inertia):
        return 0.0
    rate = known.rate(holder) * known.linkage.force(holder).sign
    power = (struck.efforts[holder] - known.efforts[holder]) * rate
    steps = 0.5 * (power[1:] + power[:-1]) * np.diff(known.times)
    work = np.concatenate([[0.0], np.cumsum(steps)])
    even = work - work[-1] * known.times / known.times[-1]
    return float(np.ptp(even) / (inertia * np.mean(rate**2)))


def _cycle(
    run: BlowRun, state: FloatArray, mode: str, period: float
) -> tuple[list[Any], list[Strike], FloatArray, str]:
    """Solutions of the states of one cycle, its strikes, and state and mode at its end."""
    time, n = 0.0, len(run.omega)
    found: list[Any] = []
    strikes = []
    while time < period:
        if mode == "free":
            flight = _Flight(run, time, state)
            run.pieces.append((time, mode, run.set))
            found.append(flight)
            met = flight.meets(period)
            time = period if met is None else met
            state = flight(time)
            if met is None:
                break
            approach = run.approach(time, state)
            strikes.append(Strike(time, approach, state[:n], state[n : 2 * n]))
        else:
            piece = run.piece(mode, time, period, state)
            found.append(piece.sol)
            time, state = float(piece.t[-1]), piece.y[:, -1]
            if piece.status != 1:
                break
        mode = run.following(mode, time, state)
    return found, strikes, state, mode


class _Flight:
    """Free swing of all modes from a state on: damped harmonic motions."""

    def __init__(self, run: BlowRun, start: float, state: FloatArray) -> None:
        n = len(run.omega)
        self._run, self._start, self._state = run, start, state
        self._decay = run.damping * run.omega
        self._turn = run.omega * np.sqrt(1.0 - run.damping**2)
        self._size = state[:n] - 1j * (state[n : 2 * n] + self._decay * state[:n]) / self._turn

    def __call__(self, time: float) -> FloatArray:
        """State at a time."""
        n = len(self._turn)
        since = time - self._start
        swing = self._size * np.exp((1j * self._turn - self._decay) * since)
        rates = ((1j * self._turn - self._decay) * swing).real
        sums = self._state[2 * n :].copy()
        state = np.concatenate([swing.real, rates, sums])
        state[-1] += self._run.energy(self._state) - self._run.energy(state)
        return state

    def _beyond(self, time: float, least: float) -> float:
        return self._run.depth(time, self(time)) - self._run.set - least

    def meets(self, period: float) -> float | None:
        """Time at which the workpiece is met; None where that is not before the cycle ends."""
        from scipy.optimize import brentq

        step = period / SAMPLES
        times = np.linspace(0.0, period, SAMPLES + 1)
        # it may fall back at once, long before the next of them
        soon = self._start + step * np.append(0.0, np.geomspace(_SOON, 1.0, 8))
        times = np.append(soon[soon < period], times[times > soon[-1]])
        since = (times - self._start)[:, None]
        swing = (self._size * np.exp((1j * self._turn - self._decay) * since)).real
        ways = np.array([self._run.course.at(time)[0] for time in times.tolist()])
        least = _ROUND_OFF * float(np.abs(ways).max())
        beyond = ways - swing @ self._run.along > self._run.set + least
        for k in np.flatnonzero(beyond[1:] & ~beyond[:-1]).tolist():
            at = float(brentq(self._beyond, times[k], times[k + 1], (least,), xtol=1e-15))
            if self._run.approach(at, self(at)) > 0.0:
                return at
        return None


def _at(run: BlowRun, found: Sequence[Any], times: FloatArray) -> FloatArray:
    """States (n, k) at some times of a cycle."""
    starts = [start for start, _, _ in run.pieces]
    rows = np.maximum(np.searchsorted(starts, times, "right") - 1, 0)
    return np.array([found[k](t) for k, t in zip(rows, times, strict=True)])


def without_contact(known: CycleLoads, cycle: Cycle, force: str) -> CycleLoads:
    """Return the loads of a solved cycle, at its rates, without the force of one of its contacts.

    What the contact has slowed moves on with the linkage.
    """
    kinematics = Kinematics(known.linkage)
    (pushed,) = known.linkage.force(force).coordinate.bodies[:1]
    slowed = [known.body_index(body) for body in rigidly_joined(known.linkage, pushed)]
    others = [k for k in range(1, kinematics.n_bodies) if k not in slowed]
    solutions, accelerations = [], known.accelerations.copy()
    for k, phase in enumerate(cycle.phases):
        rows = np.flatnonzero(known.phase_of == k)
        way = differentiate(kinematics, cycle.coordinate, known.positions[rows], known.poses[rows])
        gradient = kinematics.gradient(cycle.coordinate, known.poses[rows])
        rate = np.einsum("nj,nj->n", gradient, known.velocities[rows].reshape(len(rows), -1))
        bend = way.second * (rate**2)[:, None, None]
        scale = kinematics.pose_scale.reshape(-1, 3)[np.array(others) - 1]
        first = way.first[:, others] / scale
        left = (known.accelerations[rows] - bend)[:, others] / scale
        change = (first * left).sum(axis=(1, 2)) / (first**2).sum(axis=(1, 2))
        accelerations[rows] = bend + way.first * change[:, None, None]
        moved = replace(known, accelerations=accelerations)
        motion = moved.motion(kinematics, cycle.coordinate, rows)
        laws = {**phase.given, force: 0.0} if force in phase.given else phase.given
        solutions.append(solve_laws(motion, laws, phase.solve)[1])
    whole = one_after_another(solutions)
    return replace(
        known,
        accelerations=accelerations,
        reactions=whole.joints,
        efforts={one.name: whole.efforts[one.name] for one in known.linkage.forces},
        touches={},
    )
