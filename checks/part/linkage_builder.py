"""From a design to the linkage that `loads` solves, and from its loads to a part's own axes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import atan2, cos, hypot, sin

import numpy as np

import loads
from checks.design import data
from geometry.mesh import FloatArray, MassProperties
from geometry.parts.step_part import StepPart


@dataclass(frozen=True)
class Placing:
    """Where a part's frame stands in its body's frame.

    origin  mm, of the part's first interface in the body's frame
    angle   rad, from the body's x axis to the part's
    shifts  mm, interface -> from its point of the linkage to where the part has it, in the part's
            frame
    """

    origin: tuple[float, float]
    angle: float
    shifts: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def to_body(self, properties: MassProperties) -> tuple[float, tuple[float, float], float]:
        """Mass, centre in the body's frame and inertia of a part's mass properties."""
        x, y = properties.centre[:2]
        c, s = cos(self.angle), sin(self.angle)
        centre = (self.origin[0] + c * x - s * y, self.origin[1] + s * x + c * y)
        return properties.mass, centre, properties.inertia

    def reaches(self, history: loads.LoadHistory) -> dict[str, FloatArray]:
        """Where sliding contacts are, (n,) mm along the part's x from the interface's point.

        Raises loads.LinkageError for a contact that does not run along the part's x axis.
        """
        c, s = cos(self.angle), sin(self.angle)
        found = {}
        for k, name in enumerate(history.interfaces):
            x, y = history.reaches[:, k].T
            if not (x.any() or y.any()):
                continue
            found[name] = c * x + s * y
            across = -s * x + c * y
            if np.abs(across).max() > 1e-6 * np.abs(found[name]).max():
                raise loads.LinkageError(
                    f"the contact at {name!r} does not run along the part's x axis: it leaves it "
                    f"by {np.abs(across).max():.4g} mm"
                )
        return found

    def to_part(self, history: loads.LoadHistory) -> tuple[dict[str, FloatArray], FloatArray]:
        """Wrenches (n, 6) per interface and accelerations (n, 4) in the part's own frame."""
        c, s = cos(self.angle), sin(self.angle)
        wrenches = {}
        for k, name in enumerate(history.interfaces):
            wrench = history.wrenches[:, k].copy()
            x, y = wrench[:, 0].copy(), wrench[:, 1].copy()
            wrench[:, 0], wrench[:, 1] = c * x + s * y, -s * x + c * y
            along, across = self.shifts.get(name, (0.0, 0.0))
            wrench[:, 5] -= along * wrench[:, 1] - across * wrench[:, 0]
            wrenches[name] = wrench
        a_x, a_y, alpha, omega2 = history.accelerations.T
        x0, y0 = self.origin
        x = a_x - alpha * y0 - omega2 * x0
        y = a_y + alpha * x0 - omega2 * y0
        return wrenches, np.stack([c * x + s * y, -s * x + c * y, alpha, omega2], axis=1)


def part_placing(design: data.Design, part: data.Part) -> Placing:
    """Where a part stands in its body's frame.

    A body's part has its first interface at the origin and the second along x. A pin has its joint
    at the origin; its x is that of the body that it is fixed to, and where that has the ground's
    axes it points to the farthest point of the linkage, so that a machine that is drawn turned has
    the same pin under the same loads.
    """
    if part.body is None:
        return Placing((0.0, 0.0), _pin_angle(design, part))
    points = design.bodies[part.body].points
    first, second = (points[part.interfaces[name]] for name in part.geometry.interfaces[:2])
    angle = atan2(second[1] - first[1], second[0] - first[0])
    shape = part.geometry
    return Placing(first, angle, shape.shifts if isinstance(shape, StepPart) else {})


def _pin_angle(design: data.Design, part: data.Part) -> float:
    """Angle of a pin's x axis in the frame of the body that it is fixed to, rad."""
    assert part.joint is not None
    if part.fixed_to != data.GROUND and len(design.bodies[str(part.fixed_to)].pins) > 1:
        return 0.0
    x0, y0 = design.points[part.joint]
    arms = [(x - x0, y - y0) for x, y in design.points.values()]
    x, y = max(arms, key=lambda arm: round(hypot(*arm), 9))
    return atan2(y, x)


def interface_distance(design: data.Design, part: data.Part) -> float:
    """Distance of a body part's first two interfaces, mm."""
    assert part.body is not None
    points = design.bodies[part.body].points
    first, second = (points[part.interfaces[name]] for name in part.geometry.interfaces[:2])
    return hypot(second[0] - first[0], second[1] - first[1])


def linkage_of(
    design: data.Design,
    masses: Mapping[str, tuple[float, tuple[float, float], float]],
    cycle: data.Cycle | None = None,
    compliances: Mapping[str, loads.MatrixCompliance] | None = None,
) -> loads.Linkage:
    """Return the linkage of a design; `masses` (mass, centre, inertia) fill in unstated ones.

    With a cycle, under the friction of that cycle; `compliances` (ballesta.machine.elastic_parts)
    of bodies that give way as their parts, which a cycle with a contact needs. Raises
    loads.LinkageError where the linkage does not have one degree of freedom.
    """
    parts = compliances or {}
    missing = [
        body.name
        for body in design.bodies.values()
        if body.elastic is not None and body.elastic.as_part and body.name not in parts
    ]
    if missing and cycle is not None and cycle.has_contact:
        raise ValueError(f"cycle {cycle.name!r}: the compliance of {missing} has not been solved")
    ground = {name: design.points[name] for name in design.ground}
    bodies, assembled = [], {}
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
            ground[f"guide:{body.name}"] = design.points[body.pins[0]]
    joints = joints_of(design)
    stated = design.friction
    if cycle is not None and cycle.friction is not None:
        stated = cycle.friction
    return loads.Linkage(
        bodies=(loads.Body(loads.GROUND, ground), *bodies),
        joints=tuple(joint for group in joints.values() for joint in group),
        forces=tuple(_force(force) for force in design.forces.values()),
        assembled=assembled,
        friction={
            joint.name: loads.Friction(entry.coefficient, entry.radius)
            for name, entry in stated.items()
            for joint in joints[name]
        },
        gravity=design.gravity,
        compliance=(*_compliance(design, joints), *parts.values()),
    )


def joints_of(design: data.Design) -> dict[str, list[loads.Joint]]:
    """Return the joints that `loads` solves, by the name that the design file has for them.

    A point of three bodies is two joints of one name there.
    """
    joints: dict[str, list[loads.Joint]] = {}
    for body in design.bodies.values():
        if body.guide is not None:
            name = f"guide:{body.name}"
            joints[name] = [
                loads.Prismatic(
                    name, loads.GROUND, body.name, name, body.pins[0], body.guide, body.guide_ends
                )
            ]
    for slide in design.slides.values():
        kind = loads.Slot if slide.kind == "slot" else loads.Prismatic
        joints[slide.name] = [
            kind(
                slide.name,
                slide.on,
                slide.body,
                slide.through,
                slide.point,
                slide.direction,
                slide.ends,
            )
        ]
    for weld in design.welds.values():
        joints[weld.name] = [loads.Fixed(weld.name, *weld.bodies, weld.point)]
    for point, joined in design.joints.items():
        first, *others = joined
        joints[point] = []
        for index, other in enumerate(others, start=1):
            welded = any(
                weld.point == point and other in weld.bodies and {*weld.bodies} & {*joined[:index]}
                for weld in design.welds.values()
            )
            if not welded:  # else the weld already holds it
                name = point if len(others) == 1 else f"{point}:{other}"
                joints[point].append(loads.Revolute(name, first, other, point))
    return joints


def _compliance(
    design: data.Design, joints: Mapping[str, list[loads.Joint]]
) -> Iterator[loads.BeamCompliance | loads.JointCompliance]:
    for body in design.bodies.values():
        if body.elastic is not None and not body.elastic.as_part:
            yield loads.BeamCompliance(body.name, body.elastic.bending, body.elastic.axial)
    for name, stiffness in design.elastic_joints.items():
        for joint in joints[name]:
            yield loads.JointCompliance(joint.name, stiffness)


def cycle_of(design: data.Design, cycle: data.Cycle) -> loads.Cycle:
    """Return a design's cycle as `loads` runs it."""
    return loads.Cycle(
        name=cycle.name,
        coordinate=coordinate_of(design, cycle.coordinate),
        start=cycle.start,
        pace=_pace(design, cycle.pace),
        phases=tuple(
            loads.Phase(
                phase.name,
                phase.to,
                {force: _law(design, force, law) for force, law in phase.given.items()},
                phase.solve,
            )
            for phase in cycle.phases
        ),
        n_positions=cycle.positions,
    )


def _pace(design: data.Design, pace: data.Pace) -> loads.Pace:
    coordinate = coordinate_of(design, pace.coordinate)
    if pace.speed is not None:
        return loads.SteadyPace(coordinate, pace.speed, pace.acceleration)
    assert pace.law is not None
    assert pace.time is not None
    return loads.StrokePace(coordinate, pace.law, pace.time)


def _law(design: data.Design, force: str, law: data.Law) -> loads.Law:
    if isinstance(law, data.TableLaw):
        return loads.Table(coordinate_of(design, law.coordinate), law.values, law.forces)
    if isinstance(law, data.ContactLaw):
        direction = design.forces[force].direction
        # along its own direction, a force that points down has the coordinate -y; between two
        # points the contact pushes them apart when they come closer than `at`
        way = 1.0 if direction is None else sum(direction)
        return loads.Contact(way * law.at, law.stiffness, 1, law.stops)
    return law


def _force(force: data.Force) -> loads.Force:
    if force.between is not None:
        (body_a, point_a), (body_b, point_b) = force.between
        return loads.Force(force.name, loads.Distance(body_a, point_a, body_b, point_b), -1)
    if force.turns is not None:
        return loads.Force(force.name, loads.Angle(force.turns, force.against, force.at), 1)
    assert force.body is not None
    assert force.at is not None
    assert force.direction is not None
    return loads.Force(force.name, loads.PointCoordinate(force.body, force.at, force.direction), 1)


def coordinate_of(design: data.Design, coordinate: data.Coordinate) -> loads.Coordinate:
    """Return a design's coordinate as `loads` measures it."""
    if coordinate.what == "angle":
        return loads.Angle(coordinate.name)
    if coordinate.what == "length":
        return _force(design.forces[coordinate.name]).coordinate
    owner = next(b.name for b in design.bodies.values() if coordinate.name in b.points)
    direction = (1.0, 0.0) if coordinate.what == "x" else (0.0, 1.0)
    return loads.PointCoordinate(owner, coordinate.name, direction)
