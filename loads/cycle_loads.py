"""The result of a cycle: motion, reactions, efforts, their checks, and the loads on each part.

Loads of a body are assigned to the interfaces of its part.

Between the positions of a cycle loads may rise: the part that too few positions miss.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from loads.bodies import (
    GROUND,
    BoolArray,
    Coordinate,
    Distance,
    FloatArray,
    IntArray,
    LinkageError,
    PointCoordinate,
    Prismatic,
    Revolute,
    Slot,
    nearest,
)
from loads.contact import Touch, rigidly_joined
from loads.forces import ForceSolution, JointLoad, LoadHistory, PointLoad, body_loads
from loads.kinematics import Kinematics, acceleration_at, centre_arm, dot, rotated, velocity_at
from loads.linkage import Linkage
from loads.motion import Motion
from loads.path import worst_gaps
from loads.running import DriveFigures, drive_figures, kinetic_energy
from loads.sensitivity import Sensitivity, sensitivities

LEAST_SIZE = 1e-9  # over the largest load: below it stands what rounding leaves of balanced halves
Solved = Sequence[tuple[Motion, ForceSolution]]


@dataclass(frozen=True)
class Unresolved:
    """The largest load that other positions of a cycle have and its own have not.

    share  by which it is beyond that at the cycle's positions, over the largest of its kind
    what   the load, in words
    """

    share: float
    what: str


NOTHING = Unresolved(0.0, "")


@dataclass(frozen=True, eq=False)
class AssignedLoads:
    """The loads of a body, each at one of the interfaces.

    interfaces  names
    points      of the body, where the interfaces' wrenches are stated; None: the frame origin
    sliding     True if an interface is the line of a slot or guide, along which its force moves
    loads       number of the interface, and the load there
    """

    interfaces: tuple[str, ...]
    points: tuple[str | None, ...]
    sliding: tuple[bool, ...]
    loads: tuple[tuple[int, PointLoad], ...]


@dataclass(frozen=True, eq=False)
class ContactLoads:
    """A contact over a cycle, as if nothing were lost where it begins.

    touching    (n,)
    deflection  (n,) mm, of the linkage along the force, under all its loads
    held        (n,) share of its acceleration along the force that the pushed body loses
    rate        (n,) mm/s or rad/s, of the force's coordinate, moving on freely
    kinetic     (n,) N mm, energy of the pushed body and what is welded to it, moving on freely
    """

    touching: BoolArray
    deflection: FloatArray
    held: FloatArray
    rate: FloatArray
    kinetic: FloatArray

    @property
    def begins(self) -> IntArray:
        """Last positions before it touches; none where a cycle or phase starts in touch."""
        return np.flatnonzero(self.touching[1:] & ~self.touching[:-1])

    @property
    def approach_speed(self) -> float:
        """Largest rate with which it begins [mm/s or rad/s]."""
        return float(np.abs(self.rate[self.begins]).max(initial=0.0))

    @property
    def impacts(self) -> FloatArray:
        """Energy [N mm] that the pushed body loses at each beginning, and no load here has in it.

        It keeps the share of its speed that it keeps of its acceleration: all on a rigid linkage.
        """
        kept = 1.0 - self.held[self.begins + 1]
        return np.asarray(self.kinetic[self.begins] * (1.0 - kept**2))


@dataclass(frozen=True, eq=False)
class OwnSwing:
    """Inertia of a beam as it bends, beyond its rigid motion's, in balance by itself.

    places  (n, k) mm along x of the body
    across  (n, k) N on the body there, along its y
    """

    places: FloatArray
    across: FloatArray


@dataclass(frozen=True, eq=False)
class CycleLoads:
    """Motion and loads at every position of one cycle.

    positions      (n,)            swept coordinate, mm or rad
    times          (n,)            s, from the start of the cycle
    phases, phase_of               names, and the phase of each position (n,)
    poses          (n, bodies, 3)  mm, mm, rad, in the order of ``linkage.body_names``
    velocities     (n, bodies, 3)  mm/s, rad/s
    accelerations  (n, bodies, 3)  mm/s2, rad/s2
    heading        (n, bodies, 3)  direction of the motion, also where it rests
    reactions      of each joint, on its body b
    efforts        (n,) N or N mm, by force name, given and solved
    touches        contacts, by the name of their force
    second_order   relative change of effort and reactions in contact by the deflected shape
    swept          the coordinate that leads it
    pace           the coordinate that sets the time
    solved         the force that each phase is solved for
    unresolved     what the positions miss of loads that rise between them
    unstruck       the cycle without the moments of its blows; None where there are none
    swings         True for one that swings by its blows; `touches` then are those as if slowly
    own_swing      of beams that vibrate or are struck, by body
    moments        (n,) True at those of a blow; None where there are none
    """

    linkage: Linkage
    name: str
    swept: Coordinate
    pace: Coordinate
    solved: tuple[str, ...]
    positions: FloatArray
    times: FloatArray
    phases: tuple[str, ...]
    phase_of: IntArray
    poses: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
    heading: FloatArray
    reactions: Mapping[str, JointLoad]
    efforts: Mapping[str, FloatArray]
    touches: Mapping[str, Touch]
    second_order: float
    unresolved: Unresolved = NOTHING
    unstruck: "CycleLoads | None" = None
    swings: bool = False
    own_swing: Mapping[str, OwnSwing] = field(default_factory=dict)
    moments: BoolArray | None = None

    @property
    def slowly(self) -> "CycleLoads":
        """The cycle in which no blow makes the linkage swing, its contacts solved as if slowly."""
        return self.unstruck if self.swings and self.unstruck is not None else self

    @cached_property
    def _kinematics(self) -> Kinematics:
        return Kinematics(self.linkage)

    def body_index(self, body: str) -> int:
        """Return the row of a body in poses, velocities and accelerations."""
        self.linkage.body(body)
        return self.linkage.body_names.index(body)

    def motion(self, kinematics: Kinematics, coordinate: Coordinate, rows: IntArray) -> Motion:
        """Return the motion at some positions, to solve other forces at its rates."""
        return Motion(
            kinematics,
            coordinate,
            self.positions[rows],
            self.poses[rows],
            self.velocities[rows],
            self.accelerations[rows],
            self.heading[rows],
        )

    def centre_acceleration(self, body: str) -> FloatArray:
        """Return the acceleration of a body's centre of mass (n, 2) [mm/s2]."""
        row = self.body_index(body)
        arm = centre_arm(self.linkage.body(body), self.poses[:, row])
        return acceleration_at(arm, self.velocities[:, row], self.accelerations[:, row])

    def point(self, body: str, point: str) -> FloatArray:
        """Return where a point of a body is over the cycle (n, 2) [mm]."""
        return self._kinematics.point(self.poses, body, point)

    def acceleration(self, body: str, point: str) -> FloatArray:
        """Return the acceleration of a point of a body over the cycle (n, 2) [mm/s2]."""
        row = self.body_index(body)
        arm = self.point(body, point) - self.poses[:, row, :2]
        return acceleration_at(arm, self.velocities[:, row], self.accelerations[:, row])

    def body_loads(self, body: str) -> list[PointLoad]:
        """Return every load on a body but weight and inertia, in ground axes."""
        self.linkage.body(body)
        return body_loads(self._kinematics, self.poses, self.reactions, self.efforts, body)

    @cached_property
    def constraint_residual(self) -> float:
        """The widest gap of any joint at any position [mm]; angles count over the size."""
        return float(worst_gaps(self._kinematics, self.poses).max())

    @cached_property
    def equilibrium_residual(self) -> Mapping[str, float]:
        """Residual force, and moment over size, on each body, over the largest force."""
        loads = {body.name: self.body_loads(body.name) for body in self.linkage.moving}
        largest = max(
            [float(np.abs(load.force).max()) for part in loads.values() for load in part]
            + [
                float(np.abs(load.moment).max()) / self._kinematics.size
                for part in loads.values()
                for load in part
            ]
        )
        result = {}
        for body in self.linkage.moving:
            history = self._history(body.name, by_point(loads[body.name]))
            left = history.equilibrium_residual(body.mass, body.centre, body.inertia)
            left[:, 2] /= self._kinematics.size
            result[body.name] = float(np.abs(left).max()) / (largest or 1.0)
        return result

    @cached_property
    def _sensitivities(self) -> tuple[Sensitivity, Sensitivity]:
        return self.unstruck._sensitivities if self.unstruck else sensitivities(self)

    @property
    def shape_sensitivity(self) -> Sensitivity:
        """Change of the loads by lengths and position, of the shape alone, blows left out."""
        return self._sensitivities[0]

    @property
    def sensitivity(self) -> Sensitivity:
        """The same, or with the swept coordinate held if that is more."""
        return max(self._sensitivities, key=lambda own: own.most)

    @cached_property
    def _powers(self) -> tuple[FloatArray, FloatArray]:
        """Powers of forces, gravity and inertia (k, n), and of friction (m, n) [N mm/s]."""
        kinematics, n = self._kinematics, len(self.positions)
        powers, frictions = [], [np.zeros(n)]
        for force in self.linkage.forces:
            gradient = kinematics.gradient(force.coordinate, self.poses)
            rate = dot(gradient, self.velocities.reshape(n, -1))
            powers.append(force.sign * self.efforts[force.name] * rate)
        for joint in self.linkage.joints:
            load = self.reactions[joint.name]
            b, a = self.body_index(joint.body_b), self.body_index(joint.body_a)
            turning = self.velocities[:, b, 2] - self.velocities[:, a, 2]
            frictions.append(load.friction_couple * turning)
            if isinstance(joint, Prismatic | Slot):
                rate = kinematics.sliding(self.poses, self.velocities, joint)
                frictions.append(load.friction_force * rate)
        for i, body in enumerate(self.linkage.moving, start=1):
            rates, accelerations = self.velocities[:, i], self.accelerations[:, i]
            speed = velocity_at(centre_arm(body, self.poses[:, i]), rates)
            change = self.centre_acceleration(body.name)
            spin, turn = rates[:, 2], accelerations[:, 2]
            powers.append(body.mass * dot(speed, np.array(self.linkage.gravity, dtype=float)))
            powers.append(-body.mass * dot(speed, change) - body.inertia * spin * turn)
        return np.array(powers), np.array(frictions)

    @cached_property
    def power_balance_error(self) -> float:
        """Power of forces, friction and gravity less kinetic energy's rate, over their sum."""
        powers = np.concatenate(self._powers)
        turnover = np.sum(np.abs(powers), axis=0).max()
        return float(np.abs(np.sum(powers, axis=0)).max() / turnover) if turnover else 0.0

    @cached_property
    def friction_share(self) -> float:
        """Work that friction takes over the cycle, over the work of all forces that act on it."""
        powers, frictions = self._powers
        spans = np.diff(self.times)

        def total(rows: FloatArray) -> float:
            size = np.sum(np.abs(rows), axis=0)
            return float(np.sum(0.5 * (size[:-1] + size[1:]) * spans))

        # what flows in flows out again: half the sum of all powers is turned over
        turnover = 0.5 * (total(powers) + total(frictions))
        return total(frictions) / turnover if turnover else 0.0

    def travel(self, joint: str) -> FloatArray:
        """Return the travel of a pin along its slot or guide (n,) [mm], from the line's point."""
        return self._kinematics.travel_of(self.poses, joint)

    @cached_property
    def slot_margin(self) -> Mapping[str, float]:
        """Least distance of a pin from the end of its slot or guide [mm], where it has ends."""
        margins = {}
        for joint in self.linkage.joints:
            if isinstance(joint, Prismatic | Slot) and joint.ends is not None:
                travel = self.travel(joint.name)
                low, high = joint.ends
                margins[joint.name] = float(min(travel.min() - low, high - travel.max()))
        return margins

    def slope(self, force: str) -> FloatArray:
        """Return how a force's coordinate changes with the swept one (n,), along the motion.

        It changes its sign at a dead centre of the force.
        """
        gradient = self._kinematics.gradient(self.linkage.force(force).coordinate, self.poses)
        return dot(gradient, self.heading.reshape(len(self.positions), -1))

    def coordinate(self, force: str) -> FloatArray:
        """Return the coordinate of a force (n,) [mm or rad]."""
        return self._kinematics.value(self.linkage.force(force).coordinate, self.poses)

    def drive(self, force: str) -> DriveFigures:
        """Return the effort, work and power of a force or torque over the cycle.

        Of the cycle without blows, in whose moments the pose stays or goes by steps, but for the
        extreme efforts.
        """
        cycle = self.unstruck or self
        figures = drive_figures(
            cycle._kinematics,
            cycle.linkage.force(force),
            cycle.efforts[force],
            cycle.times,
            cycle.poses,
            cycle.velocities,
            cycle.heading,
        )
        own = self.efforts[force]
        return replace(figures, smallest=float(own.min()), largest=float(own.max()))

    def rate(self, force: str) -> FloatArray:
        """Return the rate of a force's coordinate (n,) [mm/s or rad/s]."""
        gradient = self._kinematics.gradient(self.linkage.force(force).coordinate, self.poses)
        return dot(gradient, self.velocities.reshape(len(self.positions), -1))

    @cached_property
    def contacts(self) -> Mapping[str, ContactLoads]:
        """The contacts of the cycle by the name of their force."""
        result = {}
        for name, touch in self.touches.items():
            pushed = [
                other
                for body in self.linkage.force(name).coordinate.bodies
                if body != GROUND
                for other in rigidly_joined(self.linkage, body)
            ]
            energy = kinetic_energy(self._kinematics, self.poses, self.velocities, pushed)
            result[name] = ContactLoads(
                touch.touching, touch.deflection, touch.held, self.rate(name), energy
            )
        return result

    def part_history(self, body: str, interfaces: Mapping[str, str]) -> LoadHistory:
        """Return the loads on a body at its interfaces (interface name -> point of the body).

        Everything that acts at a point is summed: joint forces, guide couples, friction and forces.
        The force of a guide or slot on the body that has the line is moved to the line's point,
        unless an interface names that joint in place of a point: the joint then acts there alone,
        with its wrench stated at the line's point and the way to the contact in ``reaches``.
        """
        loads = self.body_loads(body)
        return self._history(body, by_interface(self.linkage, body, interfaces, loads))

    def _history(self, body: str, assigned: AssignedLoads) -> LoadHistory:
        n, owner, row = len(self.positions), self.linkage.body(body), self.body_index(body)
        points = assigned.points
        wrenches = np.zeros((n, len(points), 6))
        reaches = np.zeros((n, len(points), 2))
        angle = self.poses[:, row, 2]
        for k, load in assigned.loads:
            wrenches[:, k, :2] += rotated(load.force, -angle)
            wrenches[:, k, 5] += load.moment
            if assigned.sliding[k]:
                reaches[:, k] = rotated(load.reach, -angle)
        accelerations = np.zeros((n, 4))
        pull = self.accelerations[:, row, :2] - np.array(self.linkage.gravity)
        accelerations[:, :2] = rotated(pull, -angle)
        accelerations[:, 2] = self.accelerations[:, row, 2]
        accelerations[:, 3] = self.velocities[:, row, 2] ** 2
        places = [(0.0, 0.0) if point is None else owner.points[point] for point in points]
        return LoadHistory(
            part=body,
            interfaces=assigned.interfaces,
            positions=self.positions,
            times=self.times,
            phases=self.phases,
            phase_of=self.phase_of,
            locations=np.array(places, dtype=float).reshape(len(points), 2),
            wrenches=wrenches,
            accelerations=accelerations,
            reaches=reaches,
        )

    def _meets_a_force(self, point: str, body: str) -> bool:
        """True if a force acts on a body at a point."""
        forces = {f"force {acting.name!r}" for acting in self.linkage.forces}
        acting_here = [load for load in self.body_loads(body) if load.point == point]
        return any(load.source in forces for load in acting_here)

    def pin_history(self, point: str, seats: Mapping[str, str], fixed_to: str) -> LoadHistory:
        """Return the loads on the massless pin of a joint (seat name -> body or force it carries).

        The pin gives every body its joint reactions at the point. A force between two points that
        acts there pulls at the pin itself, which hands it on to the body it is stated on. Where no
        joint is, a pin in the one body that a force meets, such as a cylinder's, has these two.
        Axes of the body ``fixed_to``; locations are the pin's own centre; no body load.
        """
        n = len(self.positions)
        bodies: dict[str, tuple[FloatArray, FloatArray]] = {}
        for joint in self.linkage.joints:
            if not isinstance(joint, Revolute) or joint.point != point:
                continue
            load = self.reactions[joint.name]
            for body, sign in ((joint.body_b, -1.0), (joint.body_a, 1.0)):
                force, moment = bodies.get(body, (np.zeros((n, 2)), np.zeros(n)))
                bodies[body] = (force + sign * load.force, moment + sign * load.friction_couple)
        if not bodies and self._meets_a_force(point, fixed_to):
            bodies[fixed_to] = (np.zeros((n, 2)), np.zeros(n))
        if not bodies:
            pins = {joint.point for joint in self.linkage.joints if isinstance(joint, Revolute)}
            raise LinkageError(f"no pin is at point {point!r}; {nearest(point, pins)}")
        if fixed_to not in bodies:
            raise LinkageError(
                f"pin {point!r}: it can be fixed to {', '.join(sorted(bodies))}, "
                f"not to {fixed_to!r}"
            )
        on_pin = dict(bodies)
        for acting in self.linkage.forces:
            coordinate = acting.coordinate
            stated = acting.name in seats.values() or isinstance(coordinate, Distance)
            if not stated or not isinstance(coordinate, Distance | PointCoordinate):
                continue
            for body in bodies:
                for part in self.body_loads(body):
                    if part.source == f"force {acting.name!r}" and part.point == point:
                        taken, couple = on_pin[body]
                        on_pin[body] = (taken - part.force, couple)
                        known = on_pin.get(acting.name, (np.zeros((n, 2)), np.zeros(n)))
                        on_pin[acting.name] = (known[0] + part.force, known[1])
        for seat, source in seats.items():
            if source not in on_pin:
                raise LinkageError(
                    f"pin {point!r}: seat {seat!r}: {source!r} does not act on the pin; "
                    f"{', '.join(sorted(on_pin))} do"
                )
        missing = sorted(set(on_pin) - set(seats.values()))
        if missing or len(set(seats.values())) < len(seats):
            raise LinkageError(
                f"pin {point!r}: every one of {', '.join(sorted(on_pin))} needs one seat"
                + (f"; {', '.join(missing)} has none" if missing else "")
            )
        angle = self.poses[:, self.body_index(fixed_to), 2]
        wrenches = np.zeros((n, len(seats), 6))
        for k, source in enumerate(seats.values()):
            wrenches[:, k, :2] = rotated(on_pin[source][0], -angle)
            wrenches[:, k, 5] = on_pin[source][1]
        left = np.abs(wrenches.sum(axis=1)).max()
        assert left <= 1e-9 * max(1.0, float(np.abs(wrenches).max())), "a pin out of equilibrium"
        return LoadHistory(
            part=point,
            interfaces=tuple(seats),
            positions=self.positions,
            times=self.times,
            phases=self.phases,
            phase_of=self.phase_of,
            locations=np.zeros((len(seats), 2)),
            wrenches=wrenches,
            accelerations=np.zeros((n, 4)),
        )


def by_point(loads: Sequence[PointLoad]) -> AssignedLoads:
    """Every loaded point of a body as an interface of its own."""
    points = tuple(dict.fromkeys(load.point for load in loads))
    return AssignedLoads(
        interfaces=tuple(str(point) for point in points),
        points=points,
        sliding=(False,) * len(points),
        loads=tuple((points.index(load.point), load) for load in loads),
    )


def by_interface(
    linkage: Linkage, body: str, interfaces: Mapping[str, str], loads: Sequence[PointLoad]
) -> AssignedLoads:
    """Every load at the interface of its point, or of its slot or guide where one names that.

    interfaces  name -> point of the body, or the slot or guide whose line the body has; a point
                goes before a joint of the same name
    """
    points = linkage.body(body).points
    lines = {
        joint.name: joint.point_a
        for joint in linkage.joints
        if isinstance(joint, Prismatic | Slot) and joint.body_a == body and joint.name not in points
    }
    order = list(interfaces.values())
    for interface, named in interfaces.items():
        if named not in points and named not in lines:
            line = " or a slot or guide on it" if lines else ""
            raise LinkageError(
                f"body {body!r}: interface {interface!r} needs a point{line}, {named!r}, that it "
                f"does not have; {nearest(named, [*points, *lines])}"
            )
        if order.count(named) > 1:
            what = "point" if named in points else f"joint {named!r}"
            raise LinkageError(f"body {body!r}: two interfaces are at the same {what}")
    joints = {f"joint {named!r}": named for named in order if named in lines}
    found = []
    for load in loads:
        place = joints.get(load.source, load.point)
        if place is None:
            raise LinkageError(
                f"body {body!r}: the torque of {load.source} enters at no stated point; "
                f"state its `at`, one of {', '.join(place for place in order if place in points)}"
            )
        if place not in order:
            raise LinkageError(
                f"body {body!r}: {load.source} acts at point {load.point!r}, "
                f"which is no interface (these are at {', '.join(order) or 'none'})"
            )
        found.append((order.index(place), load))
    return AssignedLoads(
        interfaces=tuple(interfaces),
        points=tuple(lines.get(named, named) for named in order),
        sliding=tuple(named in lines for named in order),
        loads=tuple(found),
    )


def unresolved(cycle: Solved, others: Sequence[Solved]) -> Unresolved:
    """Return the peaks that the positions of a cycle miss, found at other positions of it.

    cycle   motion and loads, phase by phase, at the positions that count
    others  the same at other positions

    Compared are the largest and least components of every joint's force in the axes of both its
    bodies, over the joint's largest force, and those of every effort over the largest effort: what
    bends and presses the parts. A size is at least `LEAST_SIZE` of the largest of all. A smooth
    peak between positions a step h apart is missed by a share of order h^2, so that a grid as fine
    as the cycle's own but placed otherwise tells its size.
    """
    found = NOTHING
    taken = {what: (low, high, size) for what, low, high, size in _extremes(cycle)}
    least_size = LEAST_SIZE * max(size for _, _, size in taken.values())
    for other in others:
        for what, low, high, size in _extremes(other):
            least, most, largest = taken[what]
            scale = max(size, largest, least_size)
            share = max(high - most, least - low, 0.0) / scale if scale else 0.0
            if share > found.share:
                found = Unresolved(share, what)
    return found


def _extremes(solved: Solved) -> Iterator[tuple[str, float, float, float]]:
    """Least and largest of every load over all phases, and the size of its kind."""
    motion, solution = solved[0]
    linkage = motion.kinematics.linkage
    for joint in linkage.joints:
        forces = [s.joints[joint.name].force for _, s in solved]
        size = max(float(np.hypot(*force.T).max()) for force in forces)
        for body in (joint.body_a, joint.body_b):
            row = motion.kinematics.index[body]
            turned = [
                rotated(force, -m.poses[:, row, 2])
                for force, (m, _) in zip(forces, solved, strict=True)
            ]
            for axis, name in enumerate("xy"):
                yield (
                    f"{name} of the force in joint {joint.name} on {body}",
                    *_ends([force[:, axis] for force in turned]),
                    size,
                )
    for name in solution.efforts:
        low, high = _ends([s.efforts[name] for _, s in solved])
        yield f"the effort of {name}", low, high, max(-low, high)


def _ends(values: Sequence[FloatArray]) -> tuple[float, float]:
    return min(float(v.min()) for v in values), max(float(v.max()) for v in values)
