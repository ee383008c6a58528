"""Where the contacts of a cycle push, from where to where, how hard and how fast they are met."""

from collections.abc import Mapping

import numpy as np

from loads import GROUND, Angle, Coordinate, CycleLoads, Distance
from loads.contact import rigidly_joined
from reports.loads_figures import ContactSpan, ContactStated, ContactSummary, FloatArray


def contact_summaries(
    loads: CycleLoads, shown: FloatArray, stated: Mapping[str, ContactStated]
) -> list[ContactSummary]:
    """Every contact of a cycle; `shown` (n,) is the position as people see it."""
    result = []
    for name, contact in loads.contacts.items():
        coordinate = loads.linkage.force(name).coordinate
        effort = np.abs(loads.efforts[name])
        most = int(np.where(contact.touching, effort, -1.0).argmax())
        gap = loads.touches[name].gap
        pushed = [body for body in coordinate.bodies if body != GROUND]
        spans = _spans(loads, name, shown)
        held = contact.held[contact.touching]
        result.append(
            ContactSummary(
                name=name,
                body=" and ".join(pushed),
                angular=coordinate.angular,
                stated=stated.get(name),
                spans=spans,
                always=bool(contact.touching.all()),
                start_depth=-float(gap[0]) if contact.touching[0] else None,
                nearest=None if spans else float(gap.min()),
                largest=float(effort.max()),
                largest_at=float(shown[most]),
                largest_phase=loads.phases[int(loads.phase_of[most])],
                deflection=float(np.abs(contact.deflection).max()),
                least_held=float(held.min(initial=1.0)),
                most_held=float(held.max(initial=0.0)),
                approach_speed=max((span.approach_speed or 0.0 for span in spans), default=0.0),
                energy=sum(span.energy or 0.0 for span in spans),
            )
        )
    return result


def _spans(loads: CycleLoads, name: str, shown: FloatArray) -> tuple[ContactSpan, ...]:
    """Stretches of touch; the positions where it begins and ends stand in the cycle, untouched."""
    touching, last = loads.contacts[name].touching, len(shown) - 1
    coordinate = loads.linkage.force(name).coordinate
    gap = loads.touches[name].gap
    edges = np.flatnonzero(np.diff(np.concatenate([[False], touching, [False]]).astype(int)))
    spans = []
    for first, behind in edges.reshape(-1, 2).tolist():
        start, stop = max(first - 1, 0), min(behind, last)
        # where the phase before has no contact, it is not met on the way but put there
        met = first > 0 and np.isfinite(gap[start])
        if not met:
            start = first
        if not np.isfinite(gap[stop]):
            stop = behind - 1
        speed = abs(_rate(loads, coordinate, start)) if met else None
        spans.append(
            ContactSpan(
                start=float(shown[start]),
                start_phase=loads.phases[int(loads.phase_of[first])],
                stop=float(shown[stop]),
                stop_phase=loads.phases[int(loads.phase_of[behind - 1])],
                approach_speed=speed,
                energy=_energy(loads, coordinate, start) if speed else None,
            )
        )
    return tuple(spans)


def _rate(loads: CycleLoads, coordinate: Coordinate, row: int) -> float:
    """Rate of a coordinate at a position [mm/s or rad/s]."""

    def velocity(body: str, point: str) -> FloatArray:
        return _velocity(loads, body, loads.linkage.body(body).place(point), row)

    if isinstance(coordinate, Angle):
        spins = [
            0.0 if body == GROUND else float(loads.velocities[row, loads.body_index(body), 2])
            for body in (coordinate.body, coordinate.relative_to)
        ]
        return spins[0] - spins[1]
    if isinstance(coordinate, Distance):
        ends = (
            (coordinate.body_a, coordinate.point_a),
            (coordinate.body_b, coordinate.point_b),
        )
        along = loads.point(*ends[1])[row] - loads.point(*ends[0])[row]
        return float((velocity(*ends[1]) - velocity(*ends[0])) @ along / np.hypot(*along))
    along = np.array(coordinate.direction)
    return float(velocity(coordinate.body, coordinate.point) @ along / np.hypot(*along))


def _energy(loads: CycleLoads, coordinate: Coordinate, row: int) -> float:
    """Kinetic energy at a position of the bodies of a coordinate and what is welded to them."""
    total = 0.0
    pushed = [body for body in coordinate.bodies if body != GROUND]
    for name in dict.fromkeys(n for body in pushed for n in rigidly_joined(loads.linkage, body)):
        if name != GROUND:
            body = loads.linkage.body(name)
            speed = _velocity(loads, name, body.centre, row)
            spin = float(loads.velocities[row, loads.body_index(name), 2])
            total += 0.5 * (body.mass * float(speed @ speed) + body.inertia * spin**2)
    return total


def _velocity(loads: CycleLoads, body: str, place: tuple[float, float], row: int) -> FloatArray:
    """Velocity (2,) of a place in the frame of a body at a position [mm/s]."""
    if body == GROUND:
        return np.zeros(2)
    k = loads.body_index(body)
    angle, spin = loads.poses[row, k, 2], loads.velocities[row, k, 2]
    x, y = place
    arm_x, arm_y = x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)
    return np.asarray(loads.velocities[row, k, :2] + spin * np.array([-arm_y, arm_x]))
