"""A planar linkage of one degree of freedom as data, checked when it is made.

Where its mobility is not 1, the missing and the redundant joints are named.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Self, TypeVar

import numpy as np

from loads.bodies import (
    GROUND,
    Angle,
    Body,
    Compliance,
    Coordinate,
    Distance,
    Fixed,
    FloatArray,
    Force,
    Friction,
    Joint,
    LinkageError,
    PointCoordinate,
    Pose,
    Revolute,
    Vector,
    nearest,
    same_coordinate,
)
from loads.kinematics import Kinematics

_SINGULAR = 1e-6  # of the largest: the assembled pose may be stated in rounded numbers
_NOTICED = 0.05  # share of a joint in what is held twice
ItemT = TypeVar("ItemT", bound=Joint | Force)


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

    def driver(self, along: Coordinate, solved: Sequence[str] = ()) -> str | None:
        """Return the force along a coordinate that drives it; None where none acts along it.

        The first of the `solved` ones there, or else by name: the order of forces decides nothing.
        """
        there = [one.name for one in self.forces if same_coordinate(one.coordinate, along)]
        return next((name for name in solved if name in there), min(there, default=None))

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


def _named(items: Iterable[ItemT], name: str, kind: str) -> ItemT:
    listed = tuple(items)
    for item in listed:
        if item.name == name:
            return item
    raise LinkageError(
        f"no {kind} is named {name!r}; {nearest(name, (item.name for item in listed))}"
    )


def freedom_problem(linkage: Linkage) -> str | None:
    """Return the fault of the count of joints, in words; None for one degree of freedom."""
    n_bodies = len(linkage.moving)
    n_constraints = sum(joint.n_constraints for joint in linkage.joints)
    freedom = 3 * n_bodies - n_constraints
    if freedom == 1:
        return None
    count = (
        f"{freedom} degrees of freedom (3 x {n_bodies} bodies - {n_constraints} constraints of "
        f"joints {', '.join(joint.name for joint in linkage.joints) or 'none'}), must be 1"
    )
    kinematics = Kinematics(linkage)
    left, sizes, right = np.linalg.svd(kinematics.joints_jacobian(kinematics.assembled)[0])
    rank = int(np.sum(sizes > _SINGULAR * sizes.max(initial=0.0)))
    if freedom > 1:
        return f"{count}: {freedom - 1} too many, {_missing(linkage, right[rank:])}"
    return f"{count}: {1 - freedom} too few, {_redundant(kinematics, left[:, rank:].T)}"


def _missing(linkage: Linkage, motions: FloatArray) -> str:
    """Name the bodies that are held least; motions (k, 3 moving) span what can move."""
    ways = {}
    for i, body in enumerate(linkage.moving):
        own = motions[:, 3 * i : 3 * i + 3]
        ways[body.name] = int(np.sum(np.linalg.svd(own, compute_uv=False) > _SINGULAR))
    most = max(ways.values())
    loose = [name for name in ways if ways[name] == most]
    told = []
    for name in loose:
        held = [j.name for j in linkage.joints if name in (j.body_a, j.body_b)]
        told.append(f"{name!r} ({'only joint' if len(held) == 1 else 'joints'} {', '.join(held)})")
        if not held:
            told[-1] = f"{name!r} (no joint)"
    one = len(told) == 1
    free = not any(
        isinstance(j, Revolute) and GROUND in (j.body_a, j.body_b) for j in linkage.joints
    )
    return (
        (
            f"a joint or guide is missing on body {told[0]}"
            if one
            else f"a joint or guide is missing on one of the bodies {', '.join(told)}"
        )
        + (f", which can move in {most} ways" if most > 1 else "")
        + ("; no pin is on the ground: are its points stated?" if free else "")
    )


def _redundant(kinematics: Kinematics, stresses: FloatArray) -> str:
    """Name the joints that hold the same motion; stresses (k, constraints) balance themselves."""
    if not len(stresses):
        return "nothing can move: a joint is one too many"
    shares = {
        name: float(np.linalg.norm(stresses[:, rows])) for name, rows in kinematics.rows.items()
    }
    names = sorted((n for n in shares if shares[n] > _NOTICED), key=lambda n: -shares[n])
    return (
        f"joints {', '.join(names)} hold the same motion: one of them is stated twice or too many"
    )
