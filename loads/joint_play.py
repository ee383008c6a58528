"""Play in a pin joint: how hard the pin hits its bore as the force of the joint reverses.

A joint without play carries the force F(t). Where F passes through nothing the pin leaves its bore,
as F is missing from the bodies, and crosses the play: with W, the relative acceleration of both
bodies at the open joint by a unit force between them (all other joints closed),

    p = integral of F - F_0,     x = integral of W p,     |x| = c at the hit,

F_0 the least force on the way. What it then has more than bodies that stay together is the energy
E = p' W p / 2, in whatever direction it hits. Behind a contact of stiffness k, bodies of any
elasticity are pressed by no more than F + sqrt(F^2 + 2 k E) at the first hit: a falling weight's
force (docs/theory/joint_play.md). Later hits are weaker while no more than 0.84 of the speed comes
back. Where F turns in the bore without coming near to nothing the pin stays on its wall.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import inf, isinf, sqrt

import numpy as np

from loads.blow_loads import mass_matrix
from loads.bodies import Fixed, FloatArray, IntArray, Joint, Prismatic, Slot
from loads.cycle_loads import CycleLoads
from loads.forces import JointLoad
from loads.kinematics import Kinematics, dot, turned_left
from loads.vibration import closes

_LIGHT = 1e-9  # of the largest mass: of bodies that have none
_SAME = 1e-6  # of the largest speed
_HALVINGS = 50


@dataclass(frozen=True, eq=False)
class Hit:
    """A pin that crosses its play.

    leaves, hits  s, since the start of the cycle, of a later turn where it ends; in the reversal
    force         N, of the joint without play at the hit
    added         N, on top of it, at the most
    rows          of the cycle, from this crossing to the next one
    """

    leaves: float
    hits: float
    force: float
    added: float
    rows: IntArray


def play_hits(
    cycle: CycleLoads, joint: str, play: float, stiffness: float, inertia: float = inf
) -> list[Hit]:
    """Return how a pin hits its bore over a cycle, in the order in which it leaves it.

    play       mm on diameter, that the joint's pin can cross
    stiffness  N/mm, of its contact at the most, and of all that yields there without mass
    inertia    t or t mm2 on the coordinate of the pace besides the bodies; infinite where the drive
               keeps its rate

    None for a linkage without mass, or where the force never comes near to nothing.
    """
    force = cycle.reactions[joint].force
    if not any(body.mass or body.inertia for body in cycle.linkage.moving) or not force.any():
        return []
    yielding = _opened(cycle, joint, inertia).yielding
    turn = len(force) - 1
    if _repeats(cycle):  # a turn before it and one after
        rows = np.concatenate([np.arange(turn), np.arange(turn), np.arange(turn + 1)])
        whole = float(cycle.times[-1])
        times = cycle.times[rows] + whole * np.repeat([-1.0, 0.0, 1.0], [turn, turn, turn + 1])
        own = range(turn, 2 * turn)
    else:
        rows, times, own = np.arange(turn + 1), cycle.times, range(turn)
    way = _Way(times, force[rows], yielding[rows])
    least, shares = _nearest(way.force)
    found = []
    for k in own:
        before = least[k - 1] if k else inf
        after = least[k + 1] if k + 1 < len(least) else inf
        if least[k] <= before and least[k] < after:
            crossing = way.crossed(k, float(shares[k]), play)
            if crossing is not None:
                found.append(crossing)
    return _hits(way, found, rows, stiffness)


def with_hits(
    cycle: CycleLoads,
    joint: str,
    hits: Sequence[Hit],
    inertia: float = inf,
    times: FloatArray | None = None,
) -> CycleLoads:
    """Return the cycle with what hits add to a joint, along its force, and to all other loads.

    times  (m,) s, of the rows of the hits, where these are of the cycle without its blow

    Bodies stay in equilibrium: the pair of forces at the joint accelerates them. Poses stay.
    """
    force = cycle.reactions[joint].force
    added = np.zeros(len(force if times is None else times))
    for hit in hits:
        added[hit.rows] = np.maximum(added[hit.rows], hit.added)
    if times is not None:
        # the larger of both sides, also where loads jump and a time stands twice
        after = np.searchsorted(times, cycle.times).clip(max=len(times) - 1)
        before = np.searchsorted(times, cycle.times, "right").clip(min=1) - 1
        added = np.maximum(added[before], added[after])
    sizes = np.hypot(*force.T)
    push = force * (added / np.where(sizes > 0.0, sizes, 1.0))[:, None]
    opened = _opened(cycle, joint, inertia)
    answer = np.einsum("nqk,nk->nq", opened.answer, push)
    kinematics = opened.kinematics
    accelerations = cycle.accelerations.copy()
    free = kinematics.pose_scale.size
    accelerations[:, 1:] += (answer[:, :free] * kinematics.pose_scale).reshape(len(force), -1, 3)
    reactions = {
        other.name: _grown(opened, cycle, other, answer[:, free:]) for other in cycle.linkage.joints
    }
    own = cycle.reactions[joint]
    reactions[joint] = replace(own, force=own.force + push)
    efforts = dict(cycle.efforts)
    driver = cycle.linkage.driver(cycle.pace, cycle.solved)
    if driver is not None:
        acting = cycle.linkage.force(driver)
        scale = acting.sign / kinematics.coordinate_scale(acting.coordinate)
        efforts[driver] = efforts[driver] + scale * answer[:, -1]
    return replace(cycle, accelerations=accelerations, reactions=reactions, efforts=efforts)


@dataclass(frozen=True, eq=False)
class _Opened:
    """A linkage with one pin joint open, at every position.

    answer  (n, unknowns, 2) unit-free accelerations of the bodies, forces of all joints (0 of the
            open one) and of the drive on the linkage, by a pair of unit forces, N, along x and y,
            on body b and against body a
    yielding  (n, 2, 2) mm/s2 of b against a
    """

    kinematics: Kinematics
    answer: FloatArray
    yielding: FloatArray


def _opened(cycle: CycleLoads, joint: str, inertia: float) -> _Opened:
    kinematics, poses = Kinematics(cycle.linkage), cycle.poses
    scales = kinematics.pose_scale
    jacobian = kinematics.joints_jacobian(poses)
    n, count, free = jacobian.shape
    lead = kinematics.gradient(cycle.pace, poses)[:, 3:] * scales
    mass = mass_matrix(kinematics, poses) * np.outer(scales, scales)
    if not isinf(inertia):
        mass += inertia * lead[:, :, None] * lead[:, None, :]
    weights = np.arange(free)
    own = mass[:, weights, weights]
    mass[:, weights, weights] = np.maximum(own, _LIGHT * own.max())
    held = np.concatenate(
        [jacobian, lead[:, None] / kinematics.coordinate_scale(cycle.pace)], axis=1
    )
    opens = np.zeros(count + 1, dtype=bool)
    opens[kinematics.rows[joint]] = True
    pair = np.swapaxes(jacobian[:, opens[:-1]], 1, 2) * kinematics.size
    opens[-1] = not isinf(inertia)
    closed = np.flatnonzero(~opens)
    rows = held[:, closed]
    matrix = np.zeros((n, free + len(closed), free + len(closed)))
    matrix[:, :free, :free] = mass
    matrix[:, :free, free:] = -np.swapaxes(rows, 1, 2)
    matrix[:, free:, :free] = rows
    right = np.concatenate([pair, np.zeros((n, len(closed), 2))], axis=1)
    solved = np.linalg.solve(matrix, right)
    answer = np.zeros((n, free + count + 1, 2))
    answer[:, :free] = solved[:, :free]
    answer[:, free + closed] = solved[:, free:]
    if not isinf(inertia):  # its own inertia holds the drive back
        scale = kinematics.coordinate_scale(cycle.pace)
        answer[:, -1] = -inertia * scale * (lead[:, None] @ solved[:, :free])[:, 0]
    yielding = np.swapaxes(pair, 1, 2) @ solved[:, :free]
    return _Opened(kinematics, answer, yielding)


def _grown(opened: _Opened, cycle: CycleLoads, joint: Joint, answer: FloatArray) -> JointLoad:
    """A joint's load with what it takes of the answer (n, constraints + 1), unit-free."""
    kinematics, load = opened.kinematics, cycle.reactions[joint.name]
    own = kinematics.rows[joint.name]
    part = answer[:, own] / kinematics.row_scale[own]
    moment = load.moment
    if isinstance(joint, Prismatic | Slot):
        force = turned_left(kinematics.line(cycle.poses, joint)) * part[:, :1]
    else:
        force = part[:, :2]
    if isinstance(joint, Prismatic | Fixed):
        moment = moment + part[:, -1]
    return replace(load, force=load.force + force, moment=moment)


@dataclass(frozen=True)
class _Crossing:
    """A pin on its way: times, stretch in which it leaves its wall, force and energy at the hit."""

    leaves: float
    hits: float
    first: int
    force: float
    energy: float


@dataclass(frozen=True, eq=False)
class _Way:
    """A joint's force (m, 2) over times (m,), straight between them, and its `yielding`."""

    times: FloatArray
    force: FloatArray
    yielding: FloatArray

    def crossed(self, k: int, share: float, play: float) -> _Crossing | None:
        """The way of a pin that leaves its wall in stretch k; None where it stays there."""
        least = self.force[k] + share * (self.force[k + 1] - self.force[k])
        start = float(self.times[k] + share * (self.times[k + 1] - self.times[k]))
        impulse, way, time, before = np.zeros(2), np.zeros(2), start, np.zeros(2)
        for i in range(k, len(self.times) - 1):
            after = self.force[i + 1] - least
            span, gives = float(self.times[i + 1]) - time, self.yielding[i + 1]
            step = partial(_stepped, impulse, way, before, after, span, gives)
            if np.hypot(*step(1.0)[1]) >= play:
                part = _part(step, play)
                impulse, _ = step(part)
                force = least + before + part * (after - before)
                hits = time + part * span
                if float(self._at(2.0 * start - hits) @ force) > 0.0:
                    return None
                energy = 0.5 * float(impulse @ gives @ impulse)
                return _Crossing(start, hits, k, float(np.hypot(*force)), energy)
            impulse, way = step(1.0)
            time, before = float(self.times[i + 1]), after
        return None

    def _at(self, time: float) -> FloatArray:
        return np.array([np.interp(time, self.times, self.force[:, i]) for i in range(2)])


def _stepped(
    impulse: FloatArray,
    way: FloatArray,
    before: FloatArray,
    after: FloatArray,
    span: float,
    gives: FloatArray,
    part: float,
) -> tuple[FloatArray, FloatArray]:
    """Impulse and way after a part of a stretch, along which the force is straight."""
    own, end = part * span, before + part * (after - before)
    return (
        impulse + 0.5 * own * (before + end),
        way + gives @ (own * impulse + own**2 * (2.0 * before + end) / 6.0),
    )


def _part(step: Callable[[float], tuple[FloatArray, FloatArray]], play: float) -> float:
    """Part of a stretch after which the way is the play."""
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if np.hypot(*step(middle)[1]) >= play else (middle, high)
    return high


def _nearest(force: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least size of a force in every stretch (m - 1,), and the share of it gone by then."""
    start, change = force[:-1], np.diff(force, axis=0)
    squares = dot(change, change)
    share = np.clip(-dot(start, change) / np.where(squares > 0.0, squares, 1.0), 0.0, 1.0)
    return np.hypot(*(start + share[:, None] * change).T), share


def _hits(way: _Way, found: Sequence[_Crossing], rows: IntArray, stiffness: float) -> list[Hit]:
    turn = int(rows[-1])
    repeats = len(rows) > turn + 1
    result = []
    for i, one in enumerate(found):
        if i + 1 < len(found):
            end = found[i + 1].first
        else:
            end = found[0].first + turn if repeats else turn
        own = np.unique(rows[one.first : end + 2])
        if repeats and own[0] == 0:
            own = np.append(own, turn)
        added = sqrt(one.force**2 + 2.0 * stiffness * one.energy)
        result.append(Hit(one.leaves, one.hits, one.force, added, np.unique(own)))
    return result


def _repeats(cycle: CycleLoads) -> bool:
    """True where a cycle ends in the pose and at the speed at which it starts."""
    apart = np.abs(cycle.velocities[-1] - cycle.velocities[0]).max()
    return closes(cycle) and bool(apart <= _SAME * np.abs(cycle.velocities).max())
