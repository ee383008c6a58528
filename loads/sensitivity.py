"""Change of the loads as lengths and positions are off by general tolerances.

Every hole of a body may be off its place by half the tolerance of its distance from the nearest
other, and the linkage may be off along its motion. Far from any singular position the loads change
by about as much as the lengths do; next to a dead centre or a change point by the shift of that
over the distance from it, whatever the ratio of the transmission is.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from loads.bodies import (
    Distance,
    Fixed,
    FloatArray,
    IntArray,
    PointCoordinate,
    Prismatic,
    Slot,
    Vector,
    shared_pins,
)
from loads.kinematics import Kinematics, dot, turned_left
from loads.linkage import Linkage

if TYPE_CHECKING:
    from loads.cycle_loads import CycleLoads

# General tolerances of lengths, ISO 2768-1 class m: up to this length, mm.
_GENERAL = ((6.0, 0.1), (30.0, 0.2), (120.0, 0.3), (400.0, 0.5), (1000.0, 0.8), (2000.0, 1.2))
_LONGEST = 2.0  # mm, of all that is longer
_ROUNDING = 1e-9  # of the largest load, and mm of motion over that of the whole linkage
_CLOSINGS = 8  # steps of Newton: gaps of a hundredth of the linkage are closed to rounding in 4
_SAME = 1e-6  # mm: two names of one place

_Place = tuple[str, str]


@dataclass(frozen=True)
class Sensitivity:
    """Change of the loads for lengths and a position within general tolerances.

    most     largest change of reactions and effort together, over the largest of the phase: every
             place off in its worst direction, and the position along the motion if it is not held,
             added
    row, at  the position where it is, and the swept coordinate there, mm or rad
    """

    most: float
    row: int
    at: float


def general_tolerance(length: float) -> float:
    """Return the general tolerance of a length, mm (ISO 2768-1, class m)."""
    return next((size for up_to, size in _GENERAL if length <= up_to), _LONGEST)


def with_places_off(linkage: Linkage, shifts: Mapping[_Place, Vector]) -> Linkage:
    """Return the linkage with places of its bodies elsewhere, assembled by the least motion."""
    if not shifts:
        return linkage
    moved = _displaced(linkage, shifts)
    kinematics = Kinematics(moved)
    pose = kinematics.assembled.copy()
    for _ in range(_CLOSINGS):
        gap = kinematics.constraints(pose) / kinematics.row_scale
        step = np.linalg.pinv(kinematics.joints_jacobian(pose)[0]) @ gap[0]
        pose[0, 1:] -= (step * kinematics.pose_scale).reshape(-1, 3)
    poses = {body.name: tuple(own) for body, own in zip(moved.moving, pose[0, 1:], strict=True)}
    return replace(moved, assembled=poses)


def _displaced(linkage: Linkage, shifts: Mapping[_Place, Vector]) -> Linkage:
    bodies = []
    for body in linkage.bodies:
        points = dict(body.points)
        for (name, point), (x, y) in shifts.items():
            if name == body.name:
                points[point] = (points[point][0] + x, points[point][1] + y)
        bodies.append(replace(body, points=points))
    return replace(linkage, bodies=tuple(bodies))


def sensitivities(cycle: "CycleLoads") -> tuple[Sensitivity, Sensitivity]:
    """Return how much the loads of a cycle change with lengths and position, by two measures.

    By the shape: the gaps that a shift opens are closed by the least motion of all bodies,
    whichever coordinate is swept. With the swept one held: all counts that lengths do to the pose.
    To first order, at fixed weights, inertia and given forces: in A v = r the shape changes A, and
    so v by -A^-1 dA v.
    """
    changes = _Changes(cycle)
    lengths, held = (
        np.sqrt(np.sum((ways @ changes.loads.on_bodies.T) ** 2, axis=(1, 3))).sum(axis=0)
        for ways in (changes.free, changes.held)
    )
    return changes.most(lengths + changes.along), changes.most(held)


def worst_shifts(cycle: "CycleLoads", row: int) -> dict[_Place, Vector]:
    """Return how places are off, mm in the axes of their bodies, where it raises the loads most.

    row  of the position that they are asked for; the swept coordinate stays
    """
    changes = _Changes(cycle)
    onto = changes.loads.on_bodies
    grows = changes.held[:, :, row] @ (onto.T @ (onto @ changes.loads.vector[row]))
    shifts = {}
    for (place, off), grow in zip(_places(cycle.linkage), grows, strict=True):
        if grow.any():
            x, y = off / float(np.hypot(*grow)) * grow
            shifts[place] = (float(x), float(y))
    return shifts


class _Changes:
    """Changes of the loads of a cycle by every place off along x and y of its body.

    free, held  (places, 2, n, unknowns) N, by the least motion, and with the swept coordinate held
    along       (n,) N, by the motion in which the fastest place is off by its tolerance
    """

    def __init__(self, cycle: "CycleLoads") -> None:
        self.cycle, self.loads = cycle, _Loads(cycle)
        loads, poses, kinematics = self.loads, cycle.poses, self.loads.kinematics
        n = len(poses)
        way = cycle.heading.reshape(n, -1)[:, 3:] / kinematics.pose_scale
        way /= np.linalg.norm(way, axis=1)[:, None]
        rows = np.concatenate([kinematics.joints_jacobian(poses), way[:, None]], axis=1)
        closing = np.linalg.inv(rows)[:, :, :-1]
        kept = kinematics.gradient(cycle.swept, poses)[:, 3:] * kinematics.pose_scale
        led = dot(kept, way)
        fastest = np.full(n, _ROUNDING)
        free, slides = [], []
        for place, off in _places(cycle.linkage):
            for shift in ((off, 0.0), (0.0, off)):
                other = Kinematics(_displaced(cycle.linkage, {place: shift}))
                gap = other.constraints(poses) / kinematics.row_scale
                step = -np.einsum("nij,nj->ni", closing, gap)
                slip = other.value(cycle.swept, poses) - kinematics.value(cycle.swept, poses)
                free.append(loads.change(other, step))
                slides.append(-(dot(kept, step) + slip) / led)
            rate = np.concatenate([np.zeros((n, 3)), way * kinematics.pose_scale], axis=1)
            arm = kinematics.arm(poses, *place)
            speed = kinematics.velocity(poses, rate.reshape(n, -1, 3), place[0], arm)
            fastest = np.maximum(fastest, np.linalg.norm(speed, axis=1) / (2.0 * off))
        moved = loads.change(kinematics, way / fastest[:, None])
        self.along: FloatArray = np.linalg.norm(moved @ loads.on_bodies.T, axis=1)
        self.free = np.reshape(free, (-1, 2, *loads.vector.shape))
        slid = np.reshape(slides, (-1, 2, n, 1))
        self.held = self.free + slid * (moved * fastest[:, None])

    def most(self, change: FloatArray) -> Sensitivity:
        """Return where changes (n,) N are most, over the largest load of their phase."""
        size = np.linalg.norm(self.loads.vector @ self.loads.on_bodies.T, axis=1)
        largest = np.empty(len(size))
        for rows in self.loads.phases:
            largest[rows] = size[rows].max()
        loaded = largest > _ROUNDING * size.max()
        share = np.divide(change, largest, out=np.zeros(len(size)), where=loaded)
        worst = int(share.argmax())
        return Sensitivity(float(share[worst]), worst, float(self.cycle.positions[worst]))


def _places(linkage: Linkage) -> Iterator[tuple[_Place, float]]:
    """Places of bodies that joints and forces are at, and how far each is off, mm.

    A length between two of them is off by the sum of both: the shortest from each is what a drawing
    states.
    """
    ends = {end for j in linkage.joints for end in ((j.body_a, j.point_a), (j.body_b, j.point_b))}
    for force in linkage.forces:
        match force.coordinate:
            case Distance() as span:
                ends |= {(span.body_a, span.point_a), (span.body_b, span.point_b)}
            case PointCoordinate() as line:
                ends.add((line.body, line.point))
    at = {end: np.array(linkage.body(end[0]).place(end[1])) for end in sorted(ends)}
    for end, own in at.items():
        away = [float(np.hypot(*(at[other] - own))) for other in at if other[0] == end[0]]
        yield end, 0.5 * general_tolerance(min((d for d in away if d > _SAME), default=0.0))


def _on_bodies(kinematics: Kinematics) -> FloatArray:
    """Rows that take reactions and effort to the forces on the bodies (`_Loads.on_bodies`)."""
    onto = np.sqrt(2.0) * np.eye(kinematics.n_constraints + 1)
    more = []
    for joints in shared_pins(kinematics.linkage.joints):
        if len(joints) == 1:
            continue
        for name in dict.fromkeys(
            body for joint in joints for body in (joint.body_a, joint.body_b)
        ):
            row = np.zeros((2, len(onto)))
            for joint in joints:
                sign = float(name == joint.body_b) - float(name == joint.body_a)
                row[:, kinematics.rows[joint.name]] = sign * np.eye(2)
            more.append(row)
        for joint in joints:
            onto[kinematics.rows[joint.name]] = 0.0
    return np.concatenate([onto, *more])


class _Loads:
    """Reactions and solved effort of a cycle as one vector, and how a change of the shape moves it.

    vector     (n, constraints + 1) N, couples over the linkage's size
    phases     rows of each
    on_bodies  (m, constraints + 1) what the vector does to each body, whichever joints pair those
               of a pin; of a joint that alone is there sqrt(2), of both its bodies
    """

    def __init__(self, cycle: "CycleLoads") -> None:
        self.cycle = cycle
        self.kinematics = kinematics = Kinematics(cycle.linkage)
        phases = [np.flatnonzero(cycle.phase_of == k) for k in range(len(cycle.solved))]
        self.phases: list[IntArray] = [rows for rows in phases if len(rows)]
        solved = [cycle.solved[int(cycle.phase_of[rows[0]])] for rows in self.phases]
        self._of = list(zip(self.phases, solved, strict=True))
        n, size = len(cycle.positions), kinematics.size
        self._unit = np.ones((n, kinematics.n_constraints + 1))  # N or N mm of one of `vector`
        self._unit[:, :-1] = size / kinematics.row_scale
        self._own = np.zeros_like(self._unit)
        for joint in cycle.linkage.joints:
            load, own = cycle.reactions[joint.name], kinematics.rows[joint.name]
            parts = [load.force[:, 0], load.force[:, 1], load.moment]
            if isinstance(joint, Slot | Prismatic):
                normal = turned_left(kinematics.line(cycle.poses, joint))
                parts = [dot(normal, load.force), load.moment]
            elif not isinstance(joint, Fixed):
                parts = parts[:2]
            self._own[:, own] = np.stack(parts[: own.stop - own.start], axis=1)
        for rows, force in self._of:
            coordinate = cycle.linkage.force(force).coordinate
            self._unit[rows, -1] = size / kinematics.coordinate_scale(coordinate)
            self._own[rows, -1] = cycle.efforts[force][rows]
        self.vector: FloatArray = self._own / self._unit
        self.on_bodies = _on_bodies(kinematics)
        matrix, self._given = self._acting(kinematics, cycle.poses)
        self._matrix = matrix
        self._inverse = np.linalg.inv(matrix * self._unit[:, None, :])

    def change(self, other: Kinematics, step: FloatArray) -> FloatArray:
        """Return the change of the vector in another shape, and a step (n, 3 moving) from here."""
        poses = self.cycle.poses.copy()
        poses[:, 1:] += (step * self.kinematics.pose_scale).reshape(len(poses), -1, 3)
        matrix, given = self._acting(other, poses)
        left = np.einsum("nij,nj->ni", matrix - self._matrix, self._own) + given - self._given
        return np.asarray(-np.einsum("nij,nj->ni", self._inverse, left))

    def _acting(self, kinematics: Kinematics, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what reactions and effort do to the bodies (n, 3 moving, unknowns), and given."""
        cycle = self.cycle
        matrix = np.empty((len(poses), 3 * len(cycle.linkage.moving), self._own.shape[1]))
        matrix[:, :, :-1] = np.swapaxes(kinematics.jacobian(poses)[:, :, 3:], 1, 2)
        given = np.zeros(matrix.shape[:2])
        for force in cycle.linkage.forces:
            acts = force.sign * kinematics.gradient(force.coordinate, poses)[:, 3:]
            for rows, solved in self._of:
                if force.name == solved:
                    matrix[rows, :, -1] = acts[rows]
                else:
                    given[rows] += cycle.efforts[force.name][rows, None] * acts[rows]
        return matrix, given
