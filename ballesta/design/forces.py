"""Puts forces, torques and cylinders of a design together, and what their drives can give."""

import math
from collections.abc import Callable, Mapping

import loads
from ballesta.design.files import telling
from checks.design.data import Cylinder, Pair
from checks.design.errors import Problems, listed, no_such
from checks.design.materials import Material
from checks.design.model import DesignFile
from checks.design.tables import Available, CylinderEntry, ForceEntry
from checks.design.units import DIMENSIONS, Measured
from geometry.bars import RulingSection
from geometry.parameters import ParameterError
from loads import GROUND

_KINDS = {"between": "a force between two points", "body": "a force on a body", "turns": "a torque"}
_USED = {"between": ("on",), "body": ("at", "direction", "follows"), "turns": ("against", "at")}


def forces_of(
    file: DesignFile, problems: Problems
) -> tuple[dict[str, loads.Force], dict[str, Pair]]:
    """Return the forces whose entries are in order, and what the drives of some can give."""
    forces: dict[str, loads.Force] = {}
    available = {}
    for name, entry in file.forces.items():
        key = f"forces.{name}"
        kinds = [kind for kind in _KINDS if getattr(entry, kind) is not None]
        if len(kinds) != 1:
            problems.add(
                key,
                "needs one of between = [point, point], body with at and direction, or turns"
                + (f"; it has {' and '.join(kinds)}" if kinds else ""),
            )
            continue
        (kind,) = kinds
        if not _only_used(key, entry, kind, problems):
            continue
        with telling(problems, f"{key}.available"):
            if entry.available is not None:
                available[name] = _limits(entry.available, kind)
        make = _MAKERS[kind]
        with telling(problems, key):  # a positive force pulls its two points together
            coordinate = make(name, entry, file)
            forces[name] = loads.Force(name, coordinate, -1 if kind == "between" else 1)
    return forces, available


def dimension_of(entry: ForceEntry) -> str:
    """`force` or `moment`."""
    return "force" if entry.turns is None else "moment"


def wrong_dimension(value: Measured, wanted: str, whose: str) -> str:
    """Say that a value is a force where a torque is meant, or the other way round."""
    kind, other = DIMENSIONS[wanted], DIMENSIONS[value.dimension]
    return f'must be {kind.title} such as "{kind.example}", {whose}; got {other.title}'


def check_dimension(field: str, value: Measured, wanted: str) -> None:
    """Raise ParameterError where a value is of another dimension than wanted."""
    if value.dimension != wanted:
        kind, other = DIMENSIONS[wanted], DIMENSIONS[value.dimension]
        raise ParameterError(
            field, f'must be {kind.title} such as "{kind.example}", got {other.title}'
        )


def _only_used(key: str, entry: ForceEntry, kind: str, problems: Problems) -> bool:
    told = len(problems)
    for field in ("on", "at", "direction", "follows", "against"):
        if getattr(entry, field) is not None and field not in _USED[kind]:
            for_ = [_KINDS[other] for other, used in _USED.items() if field in used]
            problems.add(
                f"{key}.{field}",
                f"is only used for {' and '.join(for_)}, this is {_KINDS[kind]}; leave it out",
            )
    return len(problems) == told


def _limits(entry: Measured | Available, kind: str) -> Pair:
    """Return what the drive can give with a positive and with a negative sign, N or N mm."""
    wanted = "moment" if kind == "turns" else "force"
    if isinstance(entry, Measured):
        if entry.dimension != wanted:
            raise ParameterError("", wrong_dimension(entry, wanted, f"this is {_KINDS[kind]}"))
        return entry.value, entry.value
    stated = [field for field in Available.model_fields if getattr(entry, field) is not None]
    if kind != "between":
        example = DIMENSIONS[wanted].example
        raise ParameterError(
            "", f'a table is for a force between two points; write it such as "{example}"'
        )
    if stated and set(stated) <= {"push", "pull"}:
        if entry.push is None or entry.pull is None:
            missing = "push" if entry.push is None else "pull"
            raise ParameterError(missing, "must be stated beside the other direction")
        return entry.pull, entry.push
    if {"push", "pull"} & set(stated) or not stated:
        raise ParameterError(
            "", f"needs either push and pull, or bore, rod and pressure; it has {listed(stated)}"
        )
    if entry.bore is None or entry.pressure is None or entry.rod is None:
        first, *others = (field for field in ("bore", "rod", "pressure") if field not in stated)
        described = Available.model_fields[first].description
        also = f"; so must {listed(others)}" if others else ""
        raise ParameterError(first, f"must be stated: {described}{also}")
    if entry.rod >= entry.bore:
        raise ParameterError(
            "rod", f"must be below the bore of {entry.bore:g} mm, got {entry.rod:g} mm"
        )
    piston = math.pi * entry.bore**2 / 4
    ring = piston - math.pi * entry.rod**2 / 4
    return entry.pressure * ring, entry.pressure * piston


def _distance(name: str, entry: ForceEntry, file: DesignFile) -> loads.Distance:
    assert entry.between is not None
    if entry.on is not None and entry.on not in file.bodies:
        raise ParameterError("on", no_such("body", entry.on, file.bodies))
    ends, candidates = [], []
    for index, point in enumerate(entry.between):
        if point not in file.points:
            raise ParameterError(f"between[{index}]", no_such("point", point, file.points))
        users = [body for body, stated in file.bodies.items() if point in stated.pins]
        candidates += users
        if point in file.ground:
            ends.append((GROUND, point))
        elif not users:
            raise ParameterError(f"between[{index}]", f"point {point} is on no body")
        else:
            ends.append((entry.on if entry.on in users else users[0], point))
    if entry.on is not None and entry.on not in candidates:
        raise ParameterError(
            "on",
            f"body {entry.on} has neither {entry.between[0]} nor {entry.between[1]}; "
            f"there are {listed(dict.fromkeys(candidates))}",
        )
    if ends[0][0] == ends[1][0]:
        raise ParameterError("between", f"both points are on {ends[0][0]}; nothing can move")
    return loads.Distance(*ends[0], *ends[1], name)


def _along(_: str, entry: ForceEntry, file: DesignFile) -> loads.PointCoordinate:
    if entry.body not in file.bodies:
        raise ParameterError("body", no_such("body", str(entry.body), file.bodies))
    if entry.at is None or entry.direction is None:
        raise ParameterError("at" if entry.at is None else "direction", "must be stated")
    _check_at(entry.body, entry.at, file)
    if entry.follows is None:
        return loads.PointCoordinate(entry.body, entry.at, entry.direction)
    if entry.follows not in file.bodies:
        raise ParameterError("follows", no_such("body", entry.follows, file.bodies))
    return loads.PointCoordinate(entry.body, entry.at, entry.direction, entry.follows)


def _angle(_: str, entry: ForceEntry, file: DesignFile) -> loads.Angle:
    if entry.turns not in file.bodies:
        raise ParameterError("turns", no_such("body", str(entry.turns), file.bodies))
    if entry.against not in (None, GROUND, *file.bodies):
        known = [GROUND, *file.bodies]
        raise ParameterError("against", no_such("body", str(entry.against), known))
    if entry.against == entry.turns:
        raise ParameterError("against", f"{entry.turns} cannot be turned against itself")
    if entry.at is not None:
        _check_at(entry.turns, entry.at, file)
    return loads.Angle(entry.turns, entry.against or GROUND, entry.at)


def _check_at(body: str, point: str, file: DesignFile) -> None:
    pins = file.bodies[body].pins
    if point not in pins:
        raise ParameterError("at", no_such(f"point of body {body}", point, pins))


_MAKERS: Mapping[str, Callable[[str, ForceEntry, DesignFile], loads.Coordinate]] = {
    "between": _distance,
    "body": _along,
    "turns": _angle,
}


# Cylinders, each of a force between two points.

_SAME = 1e-9  # a length that is stated twice


def cylinders_of(
    file: DesignFile,
    forces: Mapping[str, loads.Force],
    materials: Mapping[str, Material],
    problems: Problems,
) -> dict[str, Cylinder]:
    """Return the cylinders whose entries are in order."""
    found = {}
    for name, entry in file.cylinders.items():
        before = len(problems)
        key = f"cylinders.{name}"
        between = [one for one in file.forces if file.forces[one].between is not None]
        if entry.force not in between:
            problems.add(f"{key}.force", no_such("force between two points", entry.force, between))
        rod = tube = None
        with telling(problems, f"{key}.material"):
            rod = _material(entry.material, RulingSection(entry.rod, round=True), materials)
        with telling(problems, f"{key}.tube_material"):
            tube = _material(entry.tube_material, RulingSection(entry.wall), materials)
        _check_sizes(key, entry, file, problems)
        if len(problems) > before or rod is None or tube is None or entry.force not in forces:
            continue
        available = file.forces[entry.force].available
        pressure = available.pressure if isinstance(available, Available) else None
        found[name] = Cylinder(
            entry.force, entry.rod, entry.bore, entry.bore + 2 * entry.wall, entry.closed,
            entry.stroke, entry.tube, rod, tube, entry.guide or 0.0, entry.play or 0.0,
            pressure or 0.0,
        )  # fmt: skip
    return found


def _material(name: str, section: RulingSection, materials: Mapping[str, Material]) -> Material:
    if name not in materials:
        raise ParameterError("", no_such("material", name, materials))
    if not materials[name].ductile:
        raise ParameterError("", f"{name} is brittle; only ductile metals can be checked")
    try:
        return materials[name].of((section,))
    except ParameterError as error:
        raise ParameterError("", error.problem) from error


def _check_sizes(key: str, entry: CylinderEntry, file: DesignFile, problems: Problems) -> None:
    if entry.rod >= entry.bore:
        problems.add(f"{key}.rod", f"must be thinner than the bore of {entry.bore:g} mm")
    if entry.tube >= entry.closed:
        problems.add(
            f"{key}.tube", f"must be shorter than closed, {entry.closed:g} mm: the rod's eye is out"
        )
    if entry.stroke >= entry.tube:
        problems.add(
            f"{key}.stroke",
            f"must be shorter than the tube, {entry.tube:g} mm, that it comes from",
        )
    if (entry.guide is None) != (entry.play is None):
        problems.add(key, "guide and play tell together how far the rod tilts in its tube")
    elif entry.guide is not None and entry.guide + entry.stroke > entry.tube:
        problems.add(
            f"{key}.guide", f"with the stroke must find room in the tube of {entry.tube:g} mm"
        )
    force = file.forces.get(entry.force)
    if force is None or not isinstance(force.available, Available):
        return
    for field in ("bore", "rod"):
        stated = getattr(force.available, field)
        if stated is not None and abs(stated - getattr(entry, field)) > _SAME * stated:
            problems.add(
                f"{key}.{field}",
                f"is {getattr(entry, field):g} mm, but forces.{entry.force}.available.{field} is "
                f"{stated:g} mm",
            )
