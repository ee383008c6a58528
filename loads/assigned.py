"""Assignment of the loads of a body to the interfaces of its part."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from loads.bodies import LinkageError, nearest
from loads.joints import Prismatic, Slot
from loads.linkage import Linkage
from loads.point_loads import PointLoad


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
                "state the point of its angle"
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
