"""Where a part stands in its body's frame, and the loads of its body in the part's own axes."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import atan2, cos, hypot, sin

import numpy as np

import loads
from checks.design.data import Design, Part
from geometry.mesh import FloatArray, MassProperties


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


def part_placing(design: Design, part: Part) -> Placing:
    """Place of a part in its body's frame.

    A body's part has its first interface at the origin and the second along x. A pin has its joint
    at the origin; its x is the x of the body that it is fixed to; where this has the ground's
    axes it points to the farthest point of the linkage, so that a machine that is drawn turned has
    the same pin under the same loads.
    """
    if part.body is None:
        return Placing((0.0, 0.0), _pin_angle(design, part))
    points = design.bodies[part.body].points
    first, second = (points[part.interfaces[name]] for name in part.geometry.interfaces[:2])
    angle = atan2(second[1] - first[1], second[0] - first[0])
    return Placing(first, angle, part.geometry.shifts)


def _pin_angle(design: Design, part: Part) -> float:
    """Angle of a pin's x axis in the frame of the body that it is fixed to, rad."""
    assert part.joint is not None
    if part.fixed_to != loads.GROUND and len(design.bodies[str(part.fixed_to)].points) > 1:
        return 0.0
    x0, y0 = design.points[part.joint]
    arms = [(x - x0, y - y0) for x, y in design.points.values()]
    x, y = max(arms, key=lambda arm: round(hypot(*arm), 9))
    return atan2(y, x)


def interface_distance(design: Design, part: Part) -> float:
    """Distance of a body part's first two interfaces, mm."""
    assert part.body is not None
    points = design.bodies[part.body].points
    first, second = (points[part.interfaces[name]] for name in part.geometry.interfaces[:2])
    return hypot(second[0] - first[0], second[1] - first[1])
