"""Puts the bodies of a design together, and tells points that nothing uses."""

import math

import loads
from ballesta.design.joints import points_of_joints
from checks.design.data import Pair
from checks.design.errors import Problems, no_such
from checks.design.model import DesignFile
from checks.design.tables import BodyEntry
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
