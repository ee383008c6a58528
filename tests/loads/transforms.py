"""The same linkage seen otherwise: turned, mirrored, in other units, with other masses."""

from dataclasses import replace
from math import cos, sin

from loads import GROUND, Angle, PointCoordinate, Prismatic, Slot


def _coordinate(coordinate, place):
    if isinstance(coordinate, PointCoordinate):
        return replace(coordinate, direction=place(coordinate.direction))
    return coordinate


def turned(linkage, angle):
    """The linkage and its gravity turned ccw about the origin; bodies keep their own frames."""

    def place(point):
        x, y = point
        return (x * cos(angle) - y * sin(angle), x * sin(angle) + y * cos(angle))

    return replace(
        linkage,
        bodies=tuple(
            replace(body, points={name: place(p) for name, p in body.points.items()})
            if body.name == GROUND
            else body
            for body in linkage.bodies
        ),
        joints=tuple(
            replace(joint, direction=place(joint.direction))
            if isinstance(joint, Prismatic | Slot) and joint.body_a == GROUND
            else joint
            for joint in linkage.joints
        ),
        forces=tuple(
            replace(force, coordinate=_coordinate(force.coordinate, place))
            for force in linkage.forces
        ),
        assembled={
            name: (*place((x, y)), turn + angle) for name, (x, y, turn) in linkage.assembled.items()
        },
        gravity=place(linkage.gravity),
    )


def mirrored(linkage):
    """The linkage seen in a mirror along the x axis: y and every angle change their signs."""

    def place(point):
        return (point[0], -point[1])

    return replace(
        linkage,
        bodies=tuple(
            replace(
                body,
                points={name: place(p) for name, p in body.points.items()},
                centre=place(body.centre),
            )
            for body in linkage.bodies
        ),
        joints=tuple(
            replace(joint, direction=place(joint.direction))
            if isinstance(joint, Prismatic | Slot)
            else joint
            for joint in linkage.joints
        ),
        forces=tuple(
            replace(force, coordinate=_coordinate(force.coordinate, place))
            for force in linkage.forces
        ),
        assembled={name: (x, -y, -turn) for name, (x, y, turn) in linkage.assembled.items()},
        gravity=place(linkage.gravity),
    )


def in_mm_and_tonnes(linkage):
    """A linkage stated in metres and kilograms in millimetres and tonnes: the newtons stay."""

    def place(point):
        return (1000.0 * point[0], 1000.0 * point[1])

    return replace(
        linkage,
        bodies=tuple(
            replace(
                body,
                points={name: place(p) for name, p in body.points.items()},
                centre=place(body.centre),
                mass=body.mass / 1000.0,
                inertia=body.inertia * 1000.0,
            )
            for body in linkage.bodies
        ),
        friction={
            name: replace(friction, radius=1000.0 * friction.radius)
            for name, friction in linkage.friction.items()
        },
        assembled={
            name: (*place((x, y)), turn) for name, (x, y, turn) in linkage.assembled.items()
        },
        gravity=place(linkage.gravity),
    )


def with_masses(linkage, factors):
    """The linkage with every body's mass and inertia times the factor of its name (0 if none)."""
    return linkage.with_mass_properties(
        {
            body.name: (
                body.mass * factors.get(body.name, 0.0),
                body.centre,
                body.inertia * factors.get(body.name, 0.0),
            )
            for body in linkage.moving
        }
    )


def is_angle(force):
    """Whether a force is a torque."""
    return isinstance(force.coordinate, Angle)
