"""From a design to the linkage that `loads` solves, and from its loads to a part's own axes."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import atan2, cos, hypot, sin

import numpy as np

import loads
from ballesta import design_data
from geometry.mesh import FloatArray, MassProperties


@dataclass(frozen=True)
class Placing:
    """Where a part's frame stands in its body's frame.

    origin  mm, of the part's first interface in the body's frame
    angle   rad, from the body's x axis to the part's
    """

    origin: tuple[float, float]
    angle: float

    def to_body(self, properties: MassProperties) -> tuple[float, tuple[float, float], float]:
        """Mass, centre in the body's frame and inertia of a part's mass properties."""
        x, y = properties.centre[:2]
        c, s = cos(self.angle), sin(self.angle)
        centre = (self.origin[0] + c * x - s * y, self.origin[1] + s * x + c * y)
        return properties.mass, centre, properties.inertia

    def to_part(self, history: loads.LoadHistory) -> tuple[dict[str, FloatArray], FloatArray]:
        """Wrenches (n, 6) per interface and accelerations (n, 4) in the part's own frame."""
        c, s = cos(self.angle), sin(self.angle)
        wrenches = {}
        for k, name in enumerate(history.interfaces):
            wrench = history.wrenches[:, k].copy()
            x, y = wrench[:, 0].copy(), wrench[:, 1].copy()
            wrench[:, 0], wrench[:, 1] = c * x + s * y, -s * x + c * y
            wrenches[name] = wrench
        a_x, a_y, alpha, omega2 = history.accelerations.T
        x0, y0 = self.origin
        x = a_x - alpha * y0 - omega2 * x0
        y = a_y + alpha * x0 - omega2 * y0
        return wrenches, np.stack([c * x + s * y, -s * x + c * y, alpha, omega2], axis=1)


def part_placing(design: design_data.Design, part: design_data.Part) -> Placing:
    """Where a body's part stands: its first interface at the origin, the second along x."""
    if part.body is None:
        return Placing((0.0, 0.0), 0.0)
    points = design.bodies[part.body].points
    first, second = (points[part.interfaces[name]] for name in part.geometry.interfaces[:2])
    return Placing(first, atan2(second[1] - first[1], second[0] - first[0]))


def interface_distance(design: design_data.Design, part: design_data.Part) -> float:
    """Distance of a body part's first two interfaces, mm."""
    assert part.body is not None
    points = design.bodies[part.body].points
    first, second = (points[part.interfaces[name]] for name in part.geometry.interfaces[:2])
    return hypot(second[0] - first[0], second[1] - first[1])


def linkage_of(
    design: design_data.Design, masses: Mapping[str, tuple[float, tuple[float, float], float]]
) -> loads.Linkage:
    """Return the linkage of a design; `masses` (mass, centre, inertia) fill in unstated ones.

    Raises loads.LinkageError where the linkage does not have one degree of freedom.
    """
    bodies = [loads.Body(loads.GROUND, {name: design.points[name] for name in design.ground})]
    joints: list[loads.Joint] = []
    assembled = {}
    for body in design.bodies.values():
        mass, centre, inertia = masses.get(body.name, (0.0, (0.0, 0.0), 0.0))
        bodies.append(
            loads.Body(
                body.name,
                body.points,
                mass=mass if body.mass is None else body.mass,
                inertia=inertia if body.inertia is None else body.inertia,
                centre=centre if body.centre is None else body.centre,
            )
        )
        assembled[body.name] = (*body.position, body.angle)
        if body.guide is not None:
            point = body.pins[0]
            bodies[0] = loads.Body(
                loads.GROUND, {**bodies[0].points, f"guide:{body.name}": design.points[point]}
            )
            joints.append(
                loads.Prismatic(
                    f"guide:{body.name}",
                    loads.GROUND,
                    body.name,
                    f"guide:{body.name}",
                    point,
                    body.guide,
                )
            )
    for point, joined in design.joints.items():
        first, *others = joined
        for other in others:
            name = point if len(others) == 1 else f"{point}:{other}"
            joints.append(loads.Revolute(name, first, other, point))
    friction = {
        joint.name: loads.Friction(entry.coefficient, entry.radius)
        for joint in joints
        for key, entry in design.friction.items()
        if key in (joint.name, joint.name.split(":")[0])
    }
    return loads.Linkage(
        bodies=tuple(bodies),
        joints=tuple(joints),
        forces=tuple(_force(force) for force in design.forces.values()),
        assembled=assembled,
        friction=friction,
        gravity=design.gravity,
    )


def cycle_of(design: design_data.Design, cycle: design_data.Cycle) -> loads.Cycle:
    """Return a design's cycle as `loads` runs it."""
    return loads.Cycle(
        name=cycle.name,
        coordinate=_coordinate(design, cycle.coordinate),
        start=cycle.start,
        pace=loads.SteadyPace(_coordinate(design, cycle.pace), cycle.pace_speed),
        phases=tuple(loads.Phase(p.name, p.to, p.given, p.solve) for p in cycle.phases),
        n_positions=cycle.positions,
    )


def _force(force: design_data.Force) -> loads.Force:
    if force.between is not None:
        (body_a, point_a), (body_b, point_b) = force.between
        return loads.Force(force.name, loads.Distance(body_a, point_a, body_b, point_b), -1)
    assert force.body is not None
    assert force.at is not None
    assert force.direction is not None
    return loads.Force(force.name, loads.PointCoordinate(force.body, force.at, force.direction), 1)


def _coordinate(design: design_data.Design, coordinate: design_data.Coordinate) -> loads.Coordinate:
    if coordinate.what == "angle":
        return loads.Angle(coordinate.name)
    if coordinate.what == "length":
        return _force(design.forces[coordinate.name]).coordinate
    owner = next(b.name for b in design.bodies.values() if coordinate.name in b.points)
    direction = (1.0, 0.0) if coordinate.what == "x" else (0.0, 1.0)
    return loads.PointCoordinate(owner, coordinate.name, direction)
