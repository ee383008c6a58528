"""Loads on one body, point by point.

`LoadHistory` holds those of one part over a cycle, in its own axes, for the part's models.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from loads.bodies import FloatArray, IntArray, Vector
from loads.forces import JointLoad
from loads.joints import Angle, Distance, Force, Prismatic, Slot
from loads.kinematics import Kinematics, cross, dot

_NOWHERE: FloatArray = np.zeros(0)


@dataclass(frozen=True, eq=False)
class LoadHistory:
    """Loads on one part over the cycle, in the part's own axes and in equilibrium.

    positions      (n,)       swept coordinate, mm or rad
    times          (n,)       s
    phases, phase_of          names of the phases, and the phase of each position (n,)
    locations      (m, 2)     mm, of the interfaces, in the body frame
    wrenches       (n, m, 6)  N, N mm: force and moment (Fx, Fy, Fz, Mx, My, Mz) ON the part
    accelerations  (n, 4)     mm/s2, mm/s2, rad/s2, rad2/s2: of the frame origin minus gravity,
                              angular, and omega**2
    reaches        (n, m, 2)  mm, in the body frame: from an interface's location, where its wrench
                              is stated, to where its force acts; not zero where a contact slides

    A material point (x, y) has the acceleration minus gravity
    (a_x - alpha y - omega2 x, a_y + alpha x - omega2 y).
    """

    part: str
    interfaces: tuple[str, ...]
    positions: FloatArray
    times: FloatArray
    phases: tuple[str, ...]
    phase_of: IntArray
    locations: FloatArray
    wrenches: FloatArray
    accelerations: FloatArray
    reaches: FloatArray = field(default_factory=lambda: _NOWHERE)

    def __post_init__(self) -> None:
        n, m = len(self.positions), len(self.interfaces)
        if self.reaches is _NOWHERE:
            object.__setattr__(self, "reaches", np.zeros((n, m, 2)))
        for name, expected in (
            ("positions", (n,)),
            ("times", (n,)),
            ("phase_of", (n,)),
            ("locations", (m, 2)),
            ("wrenches", (n, m, 6)),
            ("accelerations", (n, 4)),
            ("reaches", (n, m, 2)),
        ):
            values = np.asarray(getattr(self, name))
            if values.shape != expected:
                raise ValueError(
                    f"loads on {self.part!r}: {n} positions and {m} interfaces need {name} "
                    f"of shape {expected}, got {values.shape}"
                )
            if not np.isfinite(values).all():
                raise ValueError(f"loads on {self.part!r}: {name} are not all finite numbers")
        if n and not (np.min(self.phase_of) >= 0 and np.max(self.phase_of) < len(self.phases)):
            raise ValueError(f"loads on {self.part!r}: phase_of points outside {self.phases}")

    def scaled(self, factor: float) -> Self:
        """Return the same history with all loads and accelerations times a factor."""
        return replace(
            self, wrenches=factor * self.wrenches, accelerations=factor * self.accelerations
        )

    def equilibrium_residual(self, mass: float, centre: Vector, inertia: float) -> FloatArray:
        """Return residual forces and moment about the origin, d'Alembert's included (n, 3).

        mass, centre (in the body frame) and inertia about the centre belong to the part's model;
        the units are N and N mm. Zero where they agree with the linkage's body.
        """
        x, y = self.locations[:, 0], self.locations[:, 1]
        force_x, force_y = self.wrenches[:, :, 0], self.wrenches[:, :, 1]
        moment = np.sum(self.wrenches[:, :, 5] + x * force_y - y * force_x, axis=1)
        a_x, a_y, alpha, omega2 = self.accelerations.T
        c_x, c_y = centre
        centre_x = a_x - alpha * c_y - omega2 * c_x
        centre_y = a_y + alpha * c_x - omega2 * c_y
        return np.stack(
            [
                force_x.sum(axis=1) - mass * centre_x,
                force_y.sum(axis=1) - mass * centre_y,
                moment - inertia * alpha - mass * (c_x * centre_y - c_y * centre_x),
            ],
            axis=1,
        )


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
