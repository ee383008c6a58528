"""Puts the bodies and joints of a design together, and tells points that nothing uses."""

import math
import re
from collections.abc import Mapping, Sequence

import loads
from ballesta.design.files import telling
from checks.design.data import Pair
from checks.design.errors import Problems, no_such
from checks.design.model import DesignFile, PinPartEntry
from checks.design.tables import BodyEntry, FrictionEntry, JointEntry
from checks.design.units import measure_pair
from geometry.parameters import ParameterError
from loads import GROUND


def check_points(file: DesignFile, problems: Problems) -> None:
    """Note every point that does not exist, is of no use, or is on one body for no reason."""
    for index, name in enumerate(file.ground):
        if name not in file.points:
            problems.add(f"ground[{index}]", no_such("point", name, file.points))
        elif name in file.ground[:index]:
            problems.add(f"ground[{index}]", f"{name} is there twice")
    loaded = {force.at for force in file.forces.values()}
    loaded |= {point for force in file.forces.values() for point in force.between or ()}
    loaded |= points_of_joints(file)
    loaded |= {
        point for run in file.measured.values() for body in run.bodies.values() for point in body.at
    }
    swept = {
        coordinate.rpartition(".")[0]
        for cycle in file.cycles.values()
        for coordinate in (cycle.coordinate, cycle.pace.coordinate)
    }
    for name in file.points:
        users = [body for body, entry in file.bodies.items() if name in entry.pins]
        if not users and name not in loaded:
            cure = "; remove it, or add it to a body's pins"
            if name in file.ground:
                cure = ", though it stands in ground" + cure
            problems.add(f"points.{name}", f"no body has it and no force or joint uses it{cure}")
        elif (
            len(users) == 1
            and name not in {*file.ground, *loaded, *swept}
            and file.bodies[users[0]].guide is None
        ):
            problems.add(
                f"points.{name}",
                f"is on body {users[0]} only, and neither ground, guided nor loaded; "
                "which body does it join?",
            )


def bodies_of(
    file: DesignFile, problems: Problems
) -> tuple[dict[str, loads.Body], dict[str, loads.Pose]]:
    """Return the bodies whose entries are in order, and the poses in which they are assembled.

    The frame's origin is the first pin and its x axis points to the second; with one pin its axes
    are the ground's. Mass properties that are not stated are 0.
    """
    part_of = {
        body: name
        for name, part in file.parts.items()
        if (body := getattr(part, "body", None)) is not None
    }
    bodies, assembled = {}, {}
    for name, entry in file.bodies.items():
        key = f"bodies.{name}"
        bad = name == GROUND
        if bad:
            problems.add(key, "the frame is named ground; choose another name")
        for index, pin in enumerate(entry.pins):
            if pin not in file.points:
                problems.add(f"{key}.pins[{index}]", no_such("point", pin, file.points))
                bad = True
            elif pin in entry.pins[:index]:
                problems.add(f"{key}.pins[{index}]", f"{pin} is there twice")
                bad = True
        if bad:
            continue
        if name not in part_of:
            _check_mass(key, entry, problems)
        _check_elastic(key, entry, part_of.get(name), problems)
        places = [file.points[pin] for pin in entry.pins]
        if len(places) > 1 and places[0] == places[1]:
            problems.add(f"{key}.pins", f"{entry.pins[0]} and {entry.pins[1]} are the same place")
            continue
        bodies[name], assembled[name] = _body(name, entry, places)
    return bodies, assembled


def _check_elastic(key: str, entry: BodyEntry, part: str | None, problems: Problems) -> None:
    elastic = entry.elastic
    if elastic is None:
        return
    beam = [field for field in ("bending", "axial") if getattr(elastic, field) is not None]
    if elastic.stiffness is None:
        if not beam:
            problems.add(
                f"{key}.elastic",
                'needs bending such as "2787 N m2", axial such as "390 MN", or both; or '
                'stiffness = "fem", to give way as the body\'s part does',
            )
        return
    for field in beam:
        problems.add(
            f"{key}.elastic.{field}",
            'is in the part, whose mesh tells how it gives way (stiffness = "fem"); leave one out',
        )
    if part is None:
        problems.add(
            f"{key}.elastic.stiffness",
            "needs a part to be meshed, and no part names this body; state bending or axial",
        )


def _check_mass(key: str, entry: BodyEntry, problems: Problems) -> None:
    if entry.mass is None:
        problems.add(f"{key}.mass", 'must be stated such as "10 kg": no part names this body')
    elif entry.guide is None and entry.mass > 0:
        for quantity, example in (("inertia", "0.02 kg m2"), ("centre", "125, 0 mm")):
            if getattr(entry, quantity) is None:
                problems.add(
                    f"{key}.{quantity}",
                    f'must be stated such as "{example}": the body can turn and no part names it',
                )


def _body(name: str, entry: BodyEntry, places: list[Pair]) -> tuple[loads.Body, loads.Pose]:
    (x0, y0) = places[0]
    angle = math.atan2(places[1][1] - y0, places[1][0] - x0) if len(places) > 1 else 0.0
    cosine, sine = math.cos(angle), math.sin(angle)
    points = {
        pin: (cosine * (x - x0) + sine * (y - y0), -sine * (x - x0) + cosine * (y - y0))
        for pin, (x, y) in zip(entry.pins, places, strict=True)
    }
    centre = entry.centre or (0.0, 0.0)
    body = loads.Body(name, points, entry.mass or 0.0, entry.inertia or 0.0, centre)
    return body, (x0, y0, angle)


def ground_of(file: DesignFile) -> loads.Body:
    """Return the frame: its points, and where guides on it go through the first pins of bodies."""
    points = {name: file.points[name] for name in file.ground if name in file.points}
    for name, entry in file.bodies.items():
        if entry.guide is not None and entry.pins[0] in file.points:
            points[f"guide:{name}"] = file.points[entry.pins[0]]
    return loads.Body(GROUND, points)


def body_compliances(file: DesignFile) -> list[loads.BeamCompliance]:
    """Return the compliance of every body that bends or shortens as the file states it."""
    return [
        loads.BeamCompliance(name, elastic.bending, elastic.axial)
        for name, entry in file.bodies.items()
        if (elastic := entry.elastic) is not None and elastic.stiffness is None
    ]


# Joints: pins, slots, guides and welds, their friction and give.

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

    Guides on the ground are named "guide:<body>". A pin of three bodies is two joints, both with
    the body that it turns with, where they rub; if no part is that pin, with the first of them.
    """
    joints: dict[str, tuple[loads.Joint, ...]] = {}
    for body, stated in file.bodies.items():
        if stated.guide is not None and body in bodies:
            name = f"guide:{body}"
            pin, way, ends = stated.pins[0], stated.guide.along, None
            with telling(problems, f"bodies.{body}.guide"):
                ends = _ends(stated.guide.ends)
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
    bearers = {
        part.joint: part.fixed_to for part in file.parts.values() if isinstance(part, PinPartEntry)
    }
    for point, users in pins.items():
        bearer = bearers.get(point) if len(users) > 2 else None
        first, *others = sorted(users, key=lambda user: user != bearer)
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
    direction = ends = None
    with telling(problems, key):
        ends = _ends(entry.ends)
    if not _stated(key, entry, _SLIDING, problems):
        return None
    on, body, through, point = entry.on, entry.body, entry.through, entry.point
    assert on is not None
    assert body is not None
    assert through is not None
    assert point is not None
    told = len(problems)
    for field, owner, place in (("on", on, "through"), ("body", body, "point")):
        if owner != GROUND and owner not in file.bodies:
            known = [GROUND, *file.bodies] if field == "on" else file.bodies
            problems.add(f"{key}.{field}", no_such("body", owner, known))
            continue
        if owner == GROUND and field == "body":
            problems.add(f"{key}.body", "the ground does not slide; exchange it with `on`")
            continue
        value = through if place == "through" else point
        if absent := _no_point(owner, value, file):
            problems.add(f"{key}.{place}", absent)
    if len(problems) == told and on == body:
        problems.add(f"{key}.body", f"{body} cannot slide on itself")
    if len(problems) == told:
        with telling(problems, f"{key}.along"):
            direction = _direction(entry, file, bodies)
    if direction is None or body not in bodies or (on != GROUND and on not in bodies):
        return None
    kind = loads.Slot if entry.kind == "slot" else loads.Prismatic
    return kind(name, on, body, through, point, direction, ends)


def _no_point(body: str, point: str, file: DesignFile) -> str:
    """Reason that a body or the ground has not a point; "" where it has."""
    if point not in file.points:
        return no_such("point", point, file.points)
    here = file.ground if body == GROUND else file.bodies[body].pins
    if point in here:
        return ""
    if body == GROUND:
        return no_such("point of the ground", point, here) + "; `ground` lists them"
    return no_such(f"point of body {body}", point, here) + "; `pins` lists them"


def _direction(
    entry: JointEntry, file: DesignFile, bodies: Mapping[str, loads.Body]
) -> Pair | None:
    """Return the direction of the line in the frame of `on`; None where that is not in order."""
    along, on, through = entry.along, entry.on, entry.through
    assert along is not None
    assert on is not None
    assert through is not None
    if along not in file.points and not _NAME.fullmatch(along.strip()):
        try:
            return measure_pair(along, "")
        except ValueError as error:
            told = f"{error}; or the name of a second point of {on}"
            raise ParameterError("", told) from error
    if told := _no_point(on, along, file):
        raise ParameterError("", told)
    if on != GROUND and on not in bodies:
        return None
    places = file.points if on == GROUND else bodies[on].points
    (x0, y0), (x1, y1) = places[through], places[along]
    length = math.hypot(x1 - x0, y1 - y0)
    if length == 0.0:
        raise ParameterError(
            "", f"{along} is where {through} is; a line needs two places, or a direction"
        )
    return (x1 - x0) / length, (y1 - y0) / length


def _ends(ends: list[float] | None) -> Pair | None:
    """Return the two ends of a travel; they must rise."""
    if ends is None:
        return None
    low, high = ends
    if low >= high:
        raise ParameterError("ends", f"must rise, got {low:g} mm and then {high:g} mm")
    return low, high


def _weld(name: str, entry: JointEntry, file: DesignFile, problems: Problems) -> loads.Fixed | None:
    key = f"joints.{name}"
    if not _stated(key, entry, ("bodies", "point"), problems):
        return None
    assert entry.bodies is not None
    assert entry.point is not None
    told = len(problems)
    for index, body in enumerate(entry.bodies):
        if body != GROUND and body not in file.bodies:
            known = [GROUND, *file.bodies]
            problems.add(f"{key}.bodies[{index}]", no_such("body", body, known))
        elif absent := _no_point(body, entry.point, file):
            problems.add(f"{key}.point", absent)
    first, second = entry.bodies
    if first == second:
        problems.add(f"{key}.bodies", f"{first} is there twice")
    return loads.Fixed(name, first, second, entry.point) if len(problems) == told else None


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
        if kind == "slot" and entry.slots is not None:
            friction[name] = loads.Friction(entry.slots.coefficient)
        if kind == "guide" and entry.guides is not None:
            length = entry.guides.length or 0.0
            friction[name] = loads.Friction(entry.guides.coefficient, length=length)
    for kind, stated in (("slot", entry.slots), ("guide", entry.guides)):
        if stated is not None and kind not in names.values():
            others = [f"{name} is a {found}" for name, found in names.items() if found != "pin"]
            hint = f"; {', '.join(others)}" if others else ""
            problems.add(f"{key}.{kind}s", f"no joint is a {kind}{hint}; leave it out")
    for name, own in entry.joints.items():
        here = f"{key}.joints.{name}"
        if name not in names:
            problems.add(here, no_such("joint", name, names))
            continue
        if names[name] == "pin" and own.diameter is None:
            problems.add(f"{here}.diameter", f"must be stated: {name} is a pin joint")
        for field, kind in (("diameter", "pin"), ("length", "guide")):
            if names[name] != kind and getattr(own, field) is not None:
                told = f"is not used, {name} is a {names[name]}; leave it out"
                problems.add(f"{here}.{field}", told)
        radius, length = (own.diameter or 0.0) / 2, own.length or 0.0
        friction[name] = loads.Friction(own.coefficient, radius, length)
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
