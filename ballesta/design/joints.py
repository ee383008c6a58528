"""Puts the joints of a design together: pins, slots, guides and welds, their friction and give."""

import math
import re
from collections.abc import Mapping, Sequence

import loads
from checks.design.data import Pair
from checks.design.errors import Problems, no_such
from checks.design.model import DesignFile
from checks.design.tables import FrictionEntry, JointEntry
from checks.design.units import measure_pair
from loads import GROUND

_SLIDING = ("on", "through", "along", "body", "point")
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")


def points_of_joints(file: DesignFile) -> set[str]:
    """Return the points that the entries of [joints] name."""
    names = {
        name for entry in file.joints.values() for name in (entry.through, entry.point, entry.along)
    }
    return {name for name in names if name is not None}


def bodies_at(point: str, file: DesignFile) -> list[str]:
    """Return the bodies that have a point, the ground first where it is fixed."""
    users = [GROUND] if point in file.ground else []
    return users + [name for name, entry in file.bodies.items() if point in entry.pins]


def pins_of(file: DesignFile) -> dict[str, tuple[str, ...]]:
    """Return the pin joints: point -> the bodies that it joins, the ground first."""
    welded = {
        (entry.point, *sorted(entry.bodies))
        for entry in file.joints.values()
        if entry.kind == "fixed" and entry.bodies and entry.point
    }
    pins = {}
    for point in file.points:
        users = bodies_at(point, file)
        if len(users) > 1 and (point, *sorted(users)) not in welded:
            pins[point] = tuple(users)
    return pins


def joints_of(
    file: DesignFile,
    pins: Mapping[str, Sequence[str]],
    bodies: Mapping[str, loads.Body],
    problems: Problems,
) -> dict[str, tuple[loads.Joint, ...]]:
    """Return the joints whose entries are in order, by name in the file.

    Guides on the ground are named "guide:<body>". A pin of three bodies is two joints.
    """
    joints: dict[str, tuple[loads.Joint, ...]] = {}
    for body, stated in file.bodies.items():
        if stated.guide is not None and body in bodies:
            name = f"guide:{body}"
            ends = _ends(f"bodies.{body}.guide.ends", stated.guide.ends, problems)
            pin, way = stated.pins[0], stated.guide.along
            joints[name] = (loads.Prismatic(name, GROUND, body, name, pin, way, ends),)
    welds: list[loads.Fixed] = []
    for name, entry in file.joints.items():
        key = f"joints.{name}"
        if name in pins:
            problems.add(
                key, f"the pin joint at point {name} already has this name; choose another"
            )
        if entry.kind == "fixed":
            if (weld := _weld(name, entry, file, problems)) is not None:
                for other in welds:
                    if other.point == weld.point and _both(other) == _both(weld):
                        problems.add(key, f"is the same weld as joints.{other.name}")
                welds.append(weld)
        elif (slide := _slide(name, entry, file, bodies, problems)) is not None:
            joints[name] = (slide,)
    joints |= {weld.name: (weld,) for weld in welds}
    for point, (first, *others) in pins.items():
        held = [_both(weld) for weld in welds if weld.point == point]
        joints[point] = tuple(
            loads.Revolute(point if len(others) == 1 else f"{point}:{other}", first, other, point)
            for index, other in enumerate(others)
            if not any({before, other} in held for before in (first, *others[:index]))
        )
    return joints


def _both(joint: loads.Joint) -> set[str]:
    return {joint.body_a, joint.body_b}


def _stated(key: str, entry: JointEntry, wanted: tuple[str, ...], problems: Problems) -> bool:
    """Tell what a kind of joint needs and what it has no use for; whether all is there."""
    missing = [field for field in wanted if getattr(entry, field) is None]
    for field in missing:
        description = str(JointEntry.model_fields[field].description)
        what = next(
            (part.partition(": ")[2] for part in description.split("; ") if entry.kind in part),
            description.partition(": ")[2],
        )
        problems.add(f"{key}.{field}", f'must be stated for kind = "{entry.kind}": {what}')
    for field in (*_SLIDING, "ends", "bodies"):
        used = field in wanted or (field == "ends" and entry.kind != "fixed")
        if not used and getattr(entry, field) is not None:
            problems.add(f"{key}.{field}", f'is not used with kind = "{entry.kind}"; leave it out')
    return not missing


def _slide(
    name: str,
    entry: JointEntry,
    file: DesignFile,
    bodies: Mapping[str, loads.Body],
    problems: Problems,
) -> loads.Slot | loads.Prismatic | None:
    key = f"joints.{name}"
    ends = _ends(f"{key}.ends", entry.ends, problems)
    if not _stated(key, entry, _SLIDING, problems):
        return None
    on, body, through, point = entry.on, entry.body, entry.through, entry.point
    assert on is not None
    assert body is not None
    assert through is not None
    assert point is not None
    right = True
    for field, owner, place in (("on", on, "through"), ("body", body, "point")):
        if owner != GROUND and owner not in file.bodies:
            known = [GROUND, *file.bodies] if field == "on" else file.bodies
            problems.add(f"{key}.{field}", no_such("body", owner, known))
            right = False
            continue
        if owner == GROUND and field == "body":
            problems.add(f"{key}.body", "the ground does not slide; exchange it with `on`")
            right = False
            continue
        value = through if place == "through" else point
        right &= _has_point(f"{key}.{place}", owner, value, file, problems)
    if right and on == body:
        problems.add(f"{key}.body", f"{body} cannot slide on itself")
        right = False
    direction = _direction(key, entry, file, bodies, problems) if right else None
    if direction is None or body not in bodies or (on != GROUND and on not in bodies):
        return None
    kind = loads.Slot if entry.kind == "slot" else loads.Prismatic
    return kind(name, on, body, through, point, direction, ends)


def _has_point(key: str, body: str, point: str, file: DesignFile, problems: Problems) -> bool:
    if point not in file.points:
        problems.add(key, no_such("point", point, file.points))
        return False
    here = file.ground if body == GROUND else file.bodies[body].pins
    if point in here:
        return True
    if body == GROUND:
        problems.add(key, no_such("point of the ground", point, here) + "; `ground` lists them")
    else:
        problems.add(key, no_such(f"point of body {body}", point, here) + "; `pins` lists them")
    return False


def _direction(
    key: str,
    entry: JointEntry,
    file: DesignFile,
    bodies: Mapping[str, loads.Body],
    problems: Problems,
) -> Pair | None:
    """Return the direction of the line in the frame of `on`."""
    along, on, through = entry.along, entry.on, entry.through
    assert along is not None
    assert on is not None
    assert through is not None
    if along not in file.points and not _NAME.fullmatch(along.strip()):
        try:
            return measure_pair(along, "")
        except ValueError as error:
            problems.add(f"{key}.along", f"{error}; or the name of a second point of {on}")
            return None
    if not _has_point(f"{key}.along", on, along, file, problems):
        return None
    if on != GROUND and on not in bodies:
        return None
    places = file.points if on == GROUND else bodies[on].points
    (x0, y0), (x1, y1) = places[through], places[along]
    length = math.hypot(x1 - x0, y1 - y0)
    if length == 0.0:
        problems.add(
            f"{key}.along",
            f"{along} is where {through} is; a line needs two places, or a direction",
        )
        return None
    return (x1 - x0) / length, (y1 - y0) / length


def _ends(key: str, ends: list[float] | None, problems: Problems) -> Pair | None:
    """Return the two ends of a travel; they must rise."""
    if ends is None:
        return None
    low, high = ends
    if low >= high:
        problems.add(key, f"must rise, got {low:g} mm and then {high:g} mm")
        return None
    return low, high


def _weld(name: str, entry: JointEntry, file: DesignFile, problems: Problems) -> loads.Fixed | None:
    key = f"joints.{name}"
    if not _stated(key, entry, ("bodies", "point"), problems):
        return None
    assert entry.bodies is not None
    assert entry.point is not None
    right = True
    for index, body in enumerate(entry.bodies):
        if body != GROUND and body not in file.bodies:
            known = [GROUND, *file.bodies]
            problems.add(f"{key}.bodies[{index}]", no_such("body", body, known))
            right = False
        else:
            right &= _has_point(f"{key}.point", body, entry.point, file, problems)
    first, second = entry.bodies
    if first == second:
        problems.add(f"{key}.bodies", f"{first} is there twice")
        right = False
    return loads.Fixed(name, first, second, entry.point) if right else None


def _kinds(file: DesignFile) -> dict[str, str]:
    """Return every joint that can rub or give way, by name: "pin", "slot" or "guide"."""
    names = dict.fromkeys(pins_of(file), "pin")
    names |= {name: entry.kind for name, entry in file.joints.items() if entry.kind != "fixed"}
    return names | {f"guide:{name}": "guide" for name, body in file.bodies.items() if body.guide}


def friction_of(
    key: str,
    entry: FrictionEntry,
    file: DesignFile,
    joints: Mapping[str, Sequence[loads.Joint]],
    problems: Problems,
) -> dict[str, loads.Friction]:
    """Return the friction of every joint of the linkage that has some."""
    names = _kinds(file)
    friction = {}
    for name, kind in names.items():
        if kind == "pin" and entry.pins is not None:
            friction[name] = loads.Friction(entry.pins.coefficient, entry.pins.diameter / 2)
        sliding = {"slot": entry.slots, "guide": entry.guides}.get(kind)
        if sliding is not None:
            friction[name] = loads.Friction(sliding.coefficient)
    for kind, stated in (("slot", entry.slots), ("guide", entry.guides)):
        if stated is not None and kind not in names.values():
            others = [f"{name} is a {found}" for name, found in names.items() if found != "pin"]
            hint = f"; {', '.join(others)}" if others else ""
            problems.add(f"{key}.{kind}s", f"no joint is a {kind}{hint}; leave it out")
    for name, own in entry.joints.items():
        here = f"{key}.joints.{name}"
        if name not in names:
            problems.add(here, no_such("joint", name, names))
        elif names[name] == "pin" and own.diameter is None:
            problems.add(f"{here}.diameter", f"must be stated: {name} is a pin joint")
        elif names[name] != "pin" and own.diameter is not None:
            problems.add(
                f"{here}.diameter", f"is not used, {name} is a {names[name]}; leave it out"
            )
        else:
            friction[name] = loads.Friction(own.coefficient, (own.diameter or 0.0) / 2)
    return {
        joint.name: stated for name, stated in friction.items() for joint in joints.get(name, ())
    }


def joint_compliances(
    file: DesignFile, joints: Mapping[str, Sequence[loads.Joint]], problems: Problems
) -> list[loads.JointCompliance]:
    """Return the compliance of every joint of the linkage that gives way."""
    names = _kinds(file)
    for name in file.elastic.joints:
        if name not in names:
            problems.add(f"elastic.joints.{name}", no_such("joint", name, names))
    return [
        loads.JointCompliance(joint.name, stiffness)
        for name, stiffness in file.elastic.joints.items()
        for joint in joints.get(name, ())
    ]
