"""Puts the linkage of a design together: bodies, joints, forces and friction that fit."""

import math
from collections.abc import Mapping

from ballesta.design_data import GROUND, Body, Force, Friction, Pair
from ballesta.design_model import BodyEntry, DesignFile, ForceEntry
from ballesta.errors import Problems
from ballesta.names import listed, no_such


def check_points(file: DesignFile, problems: Problems) -> None:
    """Note every point that does not exist, is of no use, or is on one body for no reason."""
    for index, name in enumerate(file.ground):
        if name not in file.points:
            problems.add(f"ground[{index}]", no_such("point", name, file.points))
        elif name in file.ground[:index]:
            problems.add(f"ground[{index}]", f"{name} is there twice")
    loaded = {force.at for force in file.forces.values()}
    loaded |= {point for force in file.forces.values() for point in force.between or ()}
    swept = {
        coordinate.rpartition(".")[0]
        for cycle in file.cycles.values()
        for coordinate in (cycle.coordinate, cycle.pace.coordinate)
    }
    for name in file.points:
        users = [body for body, entry in file.bodies.items() if name in entry.pins]
        if not users and name not in loaded:
            problems.add(f"points.{name}", "no body has it and no force uses it")
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


def bodies_of(file: DesignFile, problems: Problems) -> dict[str, Body]:
    """Return the bodies whose entries are in order."""
    part_of = {
        body: name
        for name, part in file.parts.items()
        if (body := getattr(part, "body", None)) is not None
    }
    bodies = {}
    for name, entry in file.bodies.items():
        key = f"bodies.{name}"
        if name == GROUND:
            problems.add(key, "the frame is named ground; choose another name")
        bad_pins = False
        for index, pin in enumerate(entry.pins):
            if pin not in file.points:
                problems.add(f"{key}.pins[{index}]", no_such("point", pin, file.points))
                bad_pins = True
            elif pin in entry.pins[:index]:
                problems.add(f"{key}.pins[{index}]", f"{pin} is there twice")
                bad_pins = True
        if bad_pins:
            continue
        if name not in part_of:
            _check_mass(key, entry, problems)
        places = [file.points[pin] for pin in entry.pins]
        if len(places) > 1 and places[0] == places[1]:
            problems.add(f"{key}.pins", f"{entry.pins[0]} and {entry.pins[1]} are the same place")
            continue
        bodies[name] = _body(name, entry, places, part_of.get(name))
    return bodies


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


def _body(name: str, entry: BodyEntry, places: list[Pair], part: str | None) -> Body:
    (x0, y0) = places[0]
    angle = math.atan2(places[1][1] - y0, places[1][0] - x0) if len(places) > 1 else 0.0
    cosine, sine = math.cos(angle), math.sin(angle)
    points = {
        pin: (cosine * (x - x0) + sine * (y - y0), -sine * (x - x0) + cosine * (y - y0))
        for pin, (x, y) in zip(entry.pins, places, strict=True)
    }
    without_part = part is None
    return Body(
        name=name,
        pins=tuple(entry.pins),
        points=points,
        position=(x0, y0),
        angle=angle,
        mass=entry.mass,
        inertia=0.0 if entry.inertia is None and without_part else entry.inertia,
        centre=(0.0, 0.0) if entry.centre is None and without_part else entry.centre,
        guide=entry.guide.along if entry.guide else None,
        part=part,
    )


def joints_of(file: DesignFile) -> dict[str, tuple[str, ...]]:
    """Return the pin joints: point -> the bodies that it joins, the ground first."""
    joints = {}
    for point in file.points:
        users = [GROUND] if point in file.ground else []
        users += [name for name, entry in file.bodies.items() if point in entry.pins]
        if len(users) > 1:
            joints[point] = tuple(users)
    return joints


def forces_of(file: DesignFile, problems: Problems) -> dict[str, Force]:
    """Return the forces whose entries are in order."""
    forces = {}
    for name, entry in file.forces.items():
        key = f"forces.{name}"
        if (entry.between is None) == (entry.body is None):
            problems.add(key, "needs either between = [point, point] or body, at and direction")
        elif entry.between is not None:
            ends = _ends(key, entry, file, problems)
            if ends is not None:
                forces[name] = Force(name, ends, None, None, None, entry.available)
        elif _is_placed(key, entry, file, problems):
            forces[name] = Force(name, None, entry.body, entry.at, entry.direction, entry.available)
    return forces


def _ends(
    key: str, entry: ForceEntry, file: DesignFile, problems: Problems
) -> tuple[tuple[str, str], tuple[str, str]] | None:
    assert entry.between is not None
    for other in ("at", "direction"):
        if getattr(entry, other) is not None:
            problems.add(f"{key}.{other}", "is not used beside between; leave it out")
    if entry.on is not None and entry.on not in file.bodies:
        problems.add(f"{key}.on", no_such("body", entry.on, file.bodies))
        return None
    ends, candidates = [], []
    for index, point in enumerate(entry.between):
        if point not in file.points:
            problems.add(f"{key}.between[{index}]", no_such("point", point, file.points))
            return None
        users = [name for name, body in file.bodies.items() if point in body.pins]
        candidates += users
        if point in file.ground:
            ends.append((GROUND, point))
        elif not users:
            problems.add(f"{key}.between[{index}]", f"point {point} is on no body")
            return None
        else:
            ends.append((entry.on if entry.on in users else users[0], point))
    if entry.on is not None and entry.on not in candidates:
        problems.add(
            f"{key}.on",
            f"body {entry.on} has neither {entry.between[0]} nor {entry.between[1]}; "
            f"there are {listed(dict.fromkeys(candidates))}",
        )
        return None
    if ends[0][0] == ends[1][0]:
        problems.add(f"{key}.between", f"both points are on {ends[0][0]}; nothing can move")
        return None
    return ends[0], ends[1]


def _is_placed(key: str, entry: ForceEntry, file: DesignFile, problems: Problems) -> bool:
    if entry.on is not None:
        problems.add(f"{key}.on", "is only used with between; leave it out")
        return False
    if entry.body not in file.bodies:
        problems.add(f"{key}.body", no_such("body", str(entry.body), file.bodies))
        return False
    if entry.at is None or entry.direction is None:
        missing = "at" if entry.at is None else "direction"
        problems.add(f"{key}.{missing}", "must be stated")
        return False
    pins = file.bodies[entry.body].pins
    if entry.at not in pins:
        problems.add(f"{key}.at", no_such(f"point of body {entry.body}", entry.at, pins))
        return False
    return True


def friction_of(
    file: DesignFile, joints: Mapping[str, tuple[str, ...]], problems: Problems
) -> dict[str, Friction]:
    """Return the friction of every joint that has some."""
    friction = {}
    pins, guides = file.friction.pins, file.friction.guides
    if pins is not None:
        friction = {joint: Friction(pins.coefficient, pins.diameter / 2) for joint in joints}
    for joint, own in file.friction.joints.items():
        if joint not in joints:
            problems.add(f"friction.joints.{joint}", no_such("joint", joint, joints))
        else:
            friction[joint] = Friction(own.coefficient, own.diameter / 2)
    if guides is not None:
        for name, body in file.bodies.items():
            if body.guide is not None:
                friction[f"guide:{name}"] = Friction(guides.coefficient, 0.0)
    return friction
