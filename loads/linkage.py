"""A planar linkage of one degree of freedom as data, checked when it is made."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Self, TypeVar

from loads.bodies import GROUND, Body, LinkageError, Pose, Vector, nearest
from loads.compliance import Compliance
from loads.joints import (
    Angle,
    Coordinate,
    Distance,
    Fixed,
    Force,
    Friction,
    Joint,
    PointCoordinate,
    Revolute,
)
from loads.mobility import freedom_problem


@dataclass(frozen=True)
class Linkage:
    """Bodies, the joints and forces between them, and one pose in which it is assembled.

    bodies     the body ``ground`` among them holds the points fixed to the frame
    friction   by joint name; joints not named have none
    gravity    mm/s2, in the ground frame
    compliance  of bodies and joints that deflect in front of a contact; all else is rigid
    assembled  x, y [mm] and angle [rad] of every moving body's frame, by body name
    """

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    forces: tuple[Force, ...]
    assembled: Mapping[str, Pose]
    friction: Mapping[str, Friction] = field(default_factory=dict)
    gravity: Vector = (0.0, -9810.0)
    compliance: tuple[Compliance, ...] = ()

    def __post_init__(self) -> None:
        for kind, names in (
            ("bodies", [body.name for body in self.bodies]),
            ("joints", [joint.name for joint in self.joints]),
            ("forces", [force.name for force in self.forces]),
        ):
            for name, count in Counter(names).items():
                if count > 1:
                    raise LinkageError(f"{count} {kind} are named {name!r}; names must differ")
        if not self.moving:
            raise LinkageError("a linkage needs at least one body besides 'ground'")
        for joint in self.joints:
            self._check_joint(joint)
        for force in self.forces:
            self.check_coordinate(force.coordinate, f"force {force.name!r}")
        for name, friction in self.friction.items():
            self._check_friction(name, friction)
        for body in self.moving:
            self._check_pose(body)
        for name in self.assembled:
            self.body(name)
        problem = freedom_problem(self)
        if problem is not None:
            raise LinkageError(f"the linkage has {problem}")

    @property
    def moving(self) -> tuple[Body, ...]:
        """All bodies but the ground."""
        return tuple(body for body in self.bodies if body.name != GROUND)

    @property
    def body_names(self) -> tuple[str, ...]:
        """The order of bodies in arrays of poses: the ground first."""
        return (GROUND, *(body.name for body in self.moving))

    def body(self, name: str) -> Body:
        """Return the body of this name."""
        for body in self.bodies:
            if body.name == name:
                return body
        if name == GROUND:
            return Body(GROUND)
        raise LinkageError(
            f"no body is named {name!r}; {nearest(name, (body.name for body in self.bodies))}"
        )

    def joint(self, name: str) -> Joint:
        """Return the joint of this name."""
        return _named(self.joints, name, "joint")

    def force(self, name: str) -> Force:
        """Return the force of this name."""
        return _named(self.forces, name, "force")

    def with_mass_properties(self, properties: Mapping[str, tuple[float, Vector, float]]) -> Self:
        """Return a copy with other (mass, centre, inertia about the centre) of the named bodies."""
        for name in properties:
            self.body(name)
        return replace(
            self,
            bodies=tuple(
                body.with_mass_properties(*properties[body.name])
                if body.name in properties
                else body
                for body in self.bodies
            ),
        )

    def check_coordinate(self, coordinate: Coordinate, owner: str) -> None:
        """Raise if a coordinate names a body or point that the linkage does not have."""
        try:
            match coordinate:
                case PointCoordinate(body=name, point=point, follows=other):
                    self.body(other)
                    self.body(name).place(point)
                case Distance():
                    self.body(coordinate.body_a).place(coordinate.point_a)
                    self.body(coordinate.body_b).place(coordinate.point_b)
                case Angle(body=name, relative_to=other, point=at):
                    self.body(other)
                    if at is not None:
                        self.body(name).place(at)
                    self.body(name)
        except LinkageError as error:
            raise LinkageError(f"{owner}: {error}") from None
        if all(name == GROUND for name in coordinate.bodies):
            raise LinkageError(f"{owner}: {coordinate.label} is fixed, both ends are on the ground")

    def _check_joint(self, joint: Joint) -> None:
        owner = f"joint {joint.name!r}"
        if joint.body_a == joint.body_b:
            raise LinkageError(f"{owner}: joins body {joint.body_a!r} with itself")
        try:
            self.body(joint.body_a).place(joint.point_a)
            self.body(joint.body_b).place(joint.point_b)
        except LinkageError as error:
            raise LinkageError(f"{owner}: {error}") from None

    def _check_friction(self, name: str, friction: Friction) -> None:
        try:
            joint = self.joint(name)
        except LinkageError as error:
            raise LinkageError(f"friction: {error}") from None
        if isinstance(joint, Fixed):
            raise LinkageError(f"friction: joint {name!r} is fixed, nothing slides in it")
        if isinstance(joint, Revolute) and friction.coefficient and not friction.radius:
            raise LinkageError(f"friction: joint {name!r} is a pin and needs its radius")

    def _check_pose(self, body: Body) -> None:
        if body.name not in self.assembled:
            raise LinkageError(f"body {body.name!r}: its assembled pose (x, y, angle) is missing")
        pose = self.assembled[body.name]
        if len(pose) != 3 or not all(isfinite(value) for value in pose):
            raise LinkageError(
                f"body {body.name!r}: the assembled pose must be x, y and angle, got {pose}"
            )


ItemT = TypeVar("ItemT", bound=Joint | Force)


def _named(items: Iterable[ItemT], name: str, kind: str) -> ItemT:
    listed = tuple(items)
    for item in listed:
        if item.name == name:
            return item
    raise LinkageError(
        f"no {kind} is named {name!r}; {nearest(name, (item.name for item in listed))}"
    )
