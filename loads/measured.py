"""Loads that were measured, or computed elsewhere: no linkage is solved, but they must balance."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from loads.bodies import GROUND, Body, FloatArray, IntArray, LinkageError, Vector, nearest
from loads.forces import LoadHistory, PointLoad
from loads.kinematics import cross, rotated


@dataclass(frozen=True, eq=False)
class MeasuredLoad:
    """Measured force and moment ON a body at one of its points.

    force          (n, 2) N, in the ground's axes, or the body's
    moment         (n,) N mm
    in_body_frame  True if the force is in the body's axes
    """

    point: str
    force: FloatArray
    moment: FloatArray
    in_body_frame: bool = False


@dataclass(frozen=True, eq=False)
class MeasuredBody:
    """Measured motion of one body, and the loads on it at its points.

    angle                 (n,) rad, of the body's frame
    acceleration          (n, 2) mm/s2, of the centre of mass, without gravity
    angular_velocity      (n,) rad/s
    angular_acceleration  (n,) rad/s2
    """

    body: Body
    loads: tuple[MeasuredLoad, ...]
    angle: FloatArray
    acceleration: FloatArray
    angular_velocity: FloatArray
    angular_acceleration: FloatArray
    acceleration_in_body_frame: bool = False

    def __post_init__(self) -> None:
        n = len(self.angle)
        arrays = {
            "angle": (self.angle, (n,)),
            "acceleration": (self.acceleration, (n, 2)),
            "angular velocity": (self.angular_velocity, (n,)),
            "angular acceleration": (self.angular_acceleration, (n,)),
        }
        for load in self.loads:
            self.body.place(load.point)
            arrays[f"force at {load.point}"] = (load.force, (n, 2))
            arrays[f"moment at {load.point}"] = (load.moment, (n,))
        for name, (values, shape) in arrays.items():
            if values.shape != shape or not np.isfinite(values).all():
                raise LinkageError(
                    f"body {self.body.name!r}: {name} must be {shape} finite numbers, "
                    f"got shape {values.shape}"
                )
        points = [load.point for load in self.loads]
        if len(set(points)) < len(points):
            raise LinkageError(f"body {self.body.name!r}: one point is loaded twice: {points}")

    @property
    def size(self) -> float:
        """The largest distance between two points of the body, or to its centre [mm]; may be 0."""
        places = np.array([*self.body.points.values(), self.body.centre], dtype=float)
        apart = places[:, None] - places[None]
        return float(np.hypot(apart[..., 0], apart[..., 1]).max())

    def force_on(self, load: MeasuredLoad) -> FloatArray:
        """Return the force of a load (n, 2) in the ground's axes [N]."""
        return rotated(load.force, self.angle) if load.in_body_frame else load.force

    def pull(self, gravity: Vector) -> FloatArray:
        """Return the centre's acceleration minus gravity (n, 2) in the ground's axes [mm/s2]."""
        own = self.acceleration
        ground = rotated(own, self.angle) if self.acceleration_in_body_frame else own
        return np.asarray(ground - np.array(gravity, dtype=float))

    def pull_at(self, point: str, gravity: Vector) -> FloatArray:
        """Return a point's acceleration minus gravity (n, 2) in the ground's axes [mm/s2]."""
        arm = rotated(np.subtract(self.body.place(point), self.body.centre), self.angle)
        turning = self.angular_acceleration[:, None] * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        return self.pull(gravity) + turning - self.angular_velocity[:, None] ** 2 * arm

    def residual(self, gravity: Vector) -> FloatArray:
        """Return the residual force, and moment about the centre (n, 3) [N, N mm].

        In the ground's axes: Newton's and Euler's equations of the body, loads less inertia.
        """
        left = np.zeros((len(self.angle), 3))
        left[:, :2] = -self.body.mass * self.pull(gravity)
        left[:, 2] = -self.body.inertia * self.angular_acceleration
        for load in self.loads:
            force = self.force_on(load)
            arm = np.array(self.body.place(load.point), dtype=float) - self.body.centre
            left[:, :2] += force
            left[:, 2] += load.moment + cross(rotated(arm, self.angle), force)
        return left

    def largest_force(self, size: float) -> float:
        """Return the largest force at a point, or moment there over a size [N]."""
        sizes = [float(np.hypot(*load.force.T).max()) for load in self.loads]
        if size:
            sizes += [float(np.abs(load.moment).max()) / size for load in self.loads]
        return max(sizes, default=0.0)

    def shares(self, gravity: Vector, size: float) -> tuple[FloatArray, float]:
        """Return the residual (n,) over the largest force, and that force [N].

        The force, or the moment over a size where that is more.
        """
        left = self.residual(gravity)
        force = np.hypot(left[:, 0], left[:, 1])
        most = np.maximum(force, np.abs(left[:, 2]) / size) if size else force
        largest = self.largest_force(size)
        if not largest:  # nothing but weight and inertia: none of it is carried
            largest = float(most.max()) or 1.0
        return most / largest, largest

    def at(self, rows: IntArray) -> Self:
        """Return the same body at some of the positions."""
        return replace(
            self,
            loads=tuple(
                replace(load, force=load.force[rows], moment=load.moment[rows])
                for load in self.loads
            ),
            angle=self.angle[rows],
            acceleration=self.acceleration[rows],
            angular_velocity=self.angular_velocity[rows],
            angular_acceleration=self.angular_acceleration[rows],
        )


@dataclass(frozen=True, eq=False)
class MeasuredLoads:
    """Motion and loads of some bodies at every position of one run.

    positions      (n,) mm, rad or s
    times          (n,) s, or None where they were not measured
    bodies         by name
    gravity        mm/s2, in the ground frame
    position_name, position_unit   for sentences; "deg" shows rad in degrees
    """

    name: str
    positions: FloatArray
    times: FloatArray | None
    bodies: Mapping[str, MeasuredBody]
    gravity: Vector = (0.0, -9810.0)
    position_name: str = "position"
    position_unit: str = "mm"

    phases = ("run",)

    def __post_init__(self) -> None:
        n = len(self.positions)
        if n < 2:
            raise LinkageError(f"run {self.name!r}: needs at least 2 positions, got {n}")
        if not self.bodies:
            raise LinkageError(f"run {self.name!r}: has no body")
        for name, body in self.bodies.items():
            if len(body.angle) != n or body.body.name != name:
                raise LinkageError(
                    f"run {self.name!r}: body {name!r} needs {n} positions of its own, "
                    f"got {len(body.angle)} of {body.body.name!r}"
                )

    @property
    def phase_of(self) -> IntArray:
        """The phase of each position (n,): there is one."""
        return np.zeros(len(self.positions), dtype=np.int64)

    def with_mass_properties(self, properties: Mapping[str, tuple[float, Vector, float]]) -> Self:
        """Return a copy with other (mass, centre, inertia about the centre) of the named bodies."""
        return replace(
            self,
            bodies={
                name: replace(entry, body=entry.body.with_mass_properties(*properties[name]))
                if name in properties
                else entry
                for name, entry in self.bodies.items()
            },
        )

    def body(self, name: str) -> MeasuredBody:
        """Return the body of this name."""
        if name not in self.bodies:
            raise LinkageError(
                f"run {self.name!r} has nothing of body {name!r}; {nearest(name, self.bodies)}"
            )
        return self.bodies[name]

    def size(self, body: str) -> float:
        """Return the length [mm] that moments on a body are measured by: its own, or the largest.

        A body with one point has none of its own.
        """
        own = self.body(body).size
        return own or max(entry.size for entry in self.bodies.values())

    @cached_property
    def equilibrium_residual(self) -> Mapping[str, float]:
        """Residual force, and moment over size, on each body, over its largest force."""
        return {
            name: float(entry.shares(self.gravity, self.size(name))[0].max())
            for name, entry in self.bodies.items()
        }

    def spin_mismatch(self, body: str) -> float | None:
        """Return the error of the angular velocity against the angle's rate, over the largest rate.

        None without times, or where a body does not turn. The balance does not see this velocity.
        """
        if self.times is None:
            return None
        times, rows = np.unique(self.times, return_index=True)
        entry = self.body(body)
        angle = np.unwrap(entry.angle[rows])
        if len(times) < 3 or not (np.ptp(angle) or np.any(entry.angular_velocity)):
            return None
        middle = (angle[2:] - angle[:-2]) / (times[2:] - times[:-2])
        stated = entry.angular_velocity[rows][1:-1]
        largest = max(float(np.abs(middle).max()), float(np.abs(stated).max()))
        return float(np.abs(middle - stated).max()) / largest

    def body_loads(self, body: str) -> list[PointLoad]:
        """Return every load on a body but weight and inertia, in ground axes."""
        entry = self.body(body)
        return [
            PointLoad(
                f"the load at {load.point}",
                load.point,
                entry.force_on(load),
                load.moment,
                np.zeros_like(load.force),
            )
            for load in entry.loads
        ]

    def part_history(self, body: str, interfaces: Mapping[str, str]) -> LoadHistory:
        """Return the loads on a body at its interfaces (interface name -> point of the body).

        What the measurement leaves unbalanced is taken up by the accelerations, so that the loads
        are in equilibrium; a body without mass keeps its own accelerations.
        """
        entry, n = self.body(body), len(self.positions)
        for interface, point in interfaces.items():
            if point not in entry.body.points:
                raise LinkageError(
                    f"body {body!r}: interface {interface!r} needs a point {point!r} that it does "
                    "not have; measured loads act at points, they know no slots or guides; "
                    f"{nearest(point, entry.body.points)}"
                )
        names = {point: interface for interface, point in interfaces.items()}
        if len(names) < len(interfaces):
            raise LinkageError(f"body {body!r}: two interfaces are at the same point")
        wrenches = np.zeros((n, len(names), 6))
        for load in entry.loads:
            if load.point not in names:
                raise LinkageError(
                    f"body {body!r}: run {self.name!r} has a load at point {load.point!r}, "
                    f"which is no interface (these are at {', '.join(names) or 'none'})"
                )
            k = list(names).index(load.point)
            wrenches[:, k, :2] = rotated(entry.force_on(load), -entry.angle)
            wrenches[:, k, 5] = load.moment
        pull, alpha = entry.pull(self.gravity), entry.angular_acceleration
        left = entry.residual(self.gravity)
        if entry.body.mass:
            pull = pull + left[:, :2] / entry.body.mass
        if entry.body.inertia:
            alpha = alpha + left[:, 2] / entry.body.inertia
        omega2 = entry.angular_velocity**2
        own, (c_x, c_y) = rotated(pull, -entry.angle), entry.body.centre
        return LoadHistory(
            part=body,
            interfaces=tuple(names.values()),
            positions=self.positions,
            times=np.zeros(n) if self.times is None else self.times,
            phases=self.phases,
            phase_of=self.phase_of,
            locations=np.array([entry.body.place(point) for point in names]).reshape(-1, 2),
            wrenches=wrenches,
            accelerations=np.stack(
                [
                    own[:, 0] + alpha * c_y + omega2 * c_x,
                    own[:, 1] - alpha * c_x + omega2 * c_y,
                    alpha,
                    omega2,
                ],
                axis=1,
            ),
        )

    def pin_residual(self, point: str, seats: Mapping[str, str]) -> FloatArray | None:
        """Return the imbalance of a pin's seats (n, 3), ground axes [N, N mm].

        None where one seat was not measured and so takes what is left.
        """
        taken = self._on_pin(point, seats)
        return None if len(taken) < len(seats) else np.sum(list(taken.values()), axis=0)

    def _on_pin(self, point: str, seats: Mapping[str, str]) -> dict[str, FloatArray]:
        """Force and moment of each measured body on the pin at a point: source -> (n, 3)."""
        taken = {}
        for source in seats.values():
            for load in self.bodies[source].loads if source in self.bodies else ():
                if load.point == point:
                    force = self.bodies[source].force_on(load)
                    taken[source] = -np.column_stack([force, load.moment])
        return taken

    def pin_history(self, point: str, seats: Mapping[str, str], fixed_to: str) -> LoadHistory:
        """Return the loads on the massless pin of a joint (seat name -> body or force it carries).

        Every body gives the pin the opposite of its own load at the point. One seat may be left
        that was not measured, such as the ground's or a force's: it takes what the others leave.
        Between seats that were all measured, what is left is shared evenly. Axes of the body
        ``fixed_to``; no body load.
        """
        taken = self._on_pin(point, seats)
        unknown = [source for source in seats.values() if source not in taken]
        if not taken or len(unknown) > 1:
            raise LinkageError(
                f"pin {point!r}: run {self.name!r} has no load at {point} on "
                f"{', '.join(unknown)}; at most one seat can follow from the others"
            )
        if fixed_to != GROUND and fixed_to not in self.bodies:
            raise LinkageError(
                f"pin {point!r}: turns with {fixed_to!r}, of which run {self.name!r} has no angle"
            )
        left = np.sum(list(taken.values()), axis=0)
        if unknown:
            taken[unknown[0]] = -left
        else:
            taken = {source: load - left / len(taken) for source, load in taken.items()}
        n = len(self.positions)
        wrenches = np.zeros((n, len(seats), 6))
        angle = np.zeros(n) if fixed_to == GROUND else self.bodies[fixed_to].angle
        for k, source in enumerate(seats.values()):
            wrenches[:, k, :2] = rotated(taken[source][:, :2], -angle)
            wrenches[:, k, 5] = taken[source][:, 2]
        return LoadHistory(
            part=point,
            interfaces=tuple(seats),
            positions=self.positions,
            times=np.zeros(n) if self.times is None else self.times,
            phases=self.phases,
            phase_of=self.phase_of,
            locations=np.zeros((len(seats), 2)),
            wrenches=wrenches,
            accelerations=np.zeros((n, 4)),
        )
