"""Loads on one body, point by point."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from loads.bodies import FloatArray
from loads.forces import JointLoad
from loads.joints import Angle, Distance, Force, Prismatic, Slot
from loads.kinematics import Kinematics, cross, dot


@dataclass(frozen=True, eq=False)
class PointLoad:
    """One force and couple on a body, at one of its points.

    source  "joint B" or "force cylinder"
    point   of the body; None for a torque that enters at no stated point
    force   (n, 2) N, moment (n,) N mm about the point: ground axes
    reach   (n, 2) mm from the point to where the force really acts, ground axes: along the line of
            a guide or slot it moves, elsewhere it is zero
    """

    source: str
    point: str | None
    force: FloatArray
    moment: FloatArray
    reach: FloatArray


def body_loads(
    kinematics: Kinematics,
    poses: FloatArray,
    joints: Mapping[str, JointLoad],
    efforts: Mapping[str, FloatArray],
    body: str,
) -> list[PointLoad]:
    """Return every joint and force load on a body (not weight and inertia), one by one."""
    loads = []
    zero, nowhere = np.zeros(len(poses)), np.zeros((len(poses), 2))
    for joint in kinematics.linkage.joints:
        load = joints[joint.name]
        moment = load.moment + load.friction_couple
        source = f"joint {joint.name!r}"
        if body == joint.body_b:
            loads.append(PointLoad(source, joint.point_b, load.force, moment, nowhere))
        elif body == joint.body_a:
            # the force of a guide acts under the slider, not at the guide's own point
            lever = nowhere
            if isinstance(joint, Prismatic | Slot):
                lever = kinematics.separation(poses, joint)
            about = -moment - cross(lever, load.force)
            loads.append(PointLoad(source, joint.point_a, -load.force, about, lever))
    for force in kinematics.linkage.forces:
        for point, direction, couple in _force_on(kinematics, poses, force, body):
            size = force.sign * efforts[force.name]
            loads.append(
                PointLoad(
                    f"force {force.name!r}",
                    point,
                    direction * size[:, None],
                    zero + couple * size,
                    nowhere,
                )
            )
    return loads


def _force_on(
    kinematics: Kinematics, poses: FloatArray, force: Force, body: str
) -> list[tuple[str | None, FloatArray, float]]:
    """Return point, direction (n, 2) and couple of a unit force on a body."""
    coordinate, none = force.coordinate, np.zeros((len(poses), 2))
    result: list[tuple[str | None, FloatArray, float]] = []
    if isinstance(coordinate, Distance):
        span = kinematics.span(poses, coordinate)
        along = span / np.sqrt(dot(span, span))[:, None]
        if coordinate.body_b == body:
            result.append((coordinate.point_b, along, 0.0))
        if coordinate.body_a == body:
            result.append((coordinate.point_a, -along, 0.0))
    elif isinstance(coordinate, Angle):
        if coordinate.body == body:
            result.append((coordinate.point, none, 1.0))
        if coordinate.relative_to == body:
            known = coordinate.point in kinematics.linkage.body(body).points
            result.append((coordinate.point if known else None, none, -1.0))
    elif coordinate.body == body:
        result.append((coordinate.point, none + kinematics.along(poses, coordinate), 0.0))
    return result
