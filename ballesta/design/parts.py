"""Puts the parts of a design together: shape, material, where they sit."""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import loads
from ballesta.design.files import Sources
from ballesta.design.linkage import bodies_at
from ballesta.design.part_joints import (
    SLIDING,
    WITH_HOLES,
    bolts_of,
    bush_materials_of,
    check_edges,
    fits_of,
    rollers_of,
    welds_of,
)
from ballesta.design.plate_parts import (
    beam_geometry,
    plate_geometry,
    shape_name,
    step_geometry,
)
from ballesta.design.stacks import check_stacks, with_plays, with_press_fits, with_widths
from checks.design.data import Part, Roller
from checks.design.errors import LINKAGE, DesignError, Problems, listed, no_such
from checks.design.materials import Material, known_materials
from checks.design.model import (
    BodyPartEntry,
    DesignFile,
    PlatePartEntry,
    StepPartEntry,
)
from checks.design.strength import FkmStrength, fkm_of
from checks.result.words import clipped
from geometry.parameters import GIVEN_BY_DESIGN, GIVEN_BY_LINKAGE, ParameterError
from geometry.parts import SHAPES, Beam, Pin, Seat
from geometry.shape import Shape, check_sizes, key_of

_LONGEST = 200  # bytes of a name: systems allow 255 for a file, with its suffix
_SHOWN = 40  # letters of a name that is longer


def materials_of(file: DesignFile, problems: Problems) -> dict[str, Material]:
    """Return ballesta's materials and the design's own."""
    materials = dict(known_materials())
    for name, entry in file.materials.items():
        if name in known_materials():
            problems.add(f"materials.{name}", "ballesta has a material of that name; rename yours")
            continue
        try:
            materials[name] = entry.named(name)
        except ParameterError as error:
            problems.add(f"materials.{name}.{error.field}", error.problem)
    return materials


def _why_no_name(name: str) -> str:
    """Why no part may have a name; "" where one may."""
    if name == LINKAGE:
        return "stands for the linkage as a whole; give the part another name"
    if (size := len(name.encode())) > _LONGEST:
        return (
            f"a part's name is that of its file, so it has at most {_LONGEST} letters, got {size}; "
            "give the part a shorter name"
        )
    return ""


def parts_of(
    file: DesignFile,
    bodies: Mapping[str, loads.Body],
    pins: Mapping[str, Sequence[str]],
    joints: Mapping[str, Sequence[loads.Joint]],
    materials: Mapping[str, Material],
    sources: Sources,
    problems: Problems,
) -> dict[str, Part]:
    """Return the parts whose entries are in order; STEP files are read and added to the sources."""
    parts: dict[str, Part] = {}
    owners: dict[tuple[str, str], str] = {}
    for name, entry in file.parts.items():
        key = f"parts.{name}"
        if unusable := _why_no_name(name):
            file_of_it = sources.file_of(key)
            problems.take(DesignError(file_of_it, f"parts.{clipped(name, _SHOWN)}", unusable))
            continue
        kind = "body" if isinstance(entry, BodyPartEntry) else "joint"
        place = getattr(entry, kind)
        first = owners.setdefault((kind, place), name)
        if first != name:
            problems.add(f"{key}.{kind}", f"{first} is already the part of {kind} {place}")
        # a material with a problem of its own is told once, at the material
        if entry.material not in materials and entry.material not in file.materials:
            problems.add(f"{key}.material", no_such("material", entry.material, materials))
        elif entry.material in materials and (why := materials[entry.material].why_not_goodman):
            problems.add(f"{key}.material", f"{why}; only ductile metals can be checked")
        if isinstance(entry, BodyPartEntry):
            sits = _sits_in_body(key, entry, file, joints, problems)
            rollers = rollers_of(key, entry, materials, problems)
        else:
            sits = _sits_in_joint(key, entry, file, pins, problems)
            rollers = {}
        bushes = bush_materials_of(key, entry, materials, problems)
        if not sits or entry.material not in materials or (kind == "body" and place not in bodies):
            continue
        try:
            geometry: Shape
            if isinstance(entry, StepPartEntry):
                geometry = step_geometry(key, entry, bodies[entry.body].points, sources)
            elif isinstance(entry, PlatePartEntry):
                points = bodies[entry.body].points
                order = file.bodies[entry.body].pins
                geometry = plate_geometry(key, entry, order, points, sources)
            else:
                geometry = _geometry(entry, bodies)
        except DesignError as error:
            problems.take(error)
            continue
        except ParameterError as error:
            field = "stack" + error.field[5:] if error.field.startswith("seats") else error.field
            if not isinstance(entry, WITH_HOLES):
                field = key_of(SHAPES[entry.shape], field)
            problems.add(f"{key}.{field}", error.problem)
            continue
        stated = sorted(entry.column.model_fields_set)
        if stated and not geometry.sections:
            problems.add(
                f"{key}.column.{stated[0]}",
                "the part is no column: it has no section that is compressed along its length; "
                "leave it out",
            )
        try:
            material = materials[entry.material].of(geometry.ruling_sections)
        except ParameterError as error:
            problems.add(f"{key}.{error.field}", error.problem)
            continue
        fkm = fkm_of(key, entry, material, geometry, problems) if material.ductile else None
        clearances = fits_of(key, entry, file, geometry, problems)
        welds = welds_of(key, entry, geometry, material, problems)
        check_edges(key, entry, geometry, problems)
        bolts = bolts_of(key, entry, problems)
        made = _part(name, entry, file, geometry, material, rollers, fkm, clearances)
        parts[name] = dataclasses.replace(made, welds=welds, bolts=bolts, bushes=bushes)
    parts = with_widths(parts)
    check_stacks(parts, file.parts, problems)
    return with_press_fits(with_plays(parts), problems)


def _part(
    name: str,
    entry: Any,
    file: DesignFile,
    geometry: Shape,
    material: Material,
    rollers: Mapping[str, Roller],
    fkm: FkmStrength | None,
    clearances: Mapping[str, tuple[float, float]],
) -> Part:
    is_body = isinstance(entry, BodyPartEntry)
    stack = () if is_body else tuple(entry.stack)
    beside = _beside(entry, file) if is_body else {}
    return Part(
        name=name,
        shape=_shape_name(entry),
        geometry=geometry,
        material=material,
        body=entry.body if is_body else None,
        joint=None if is_body else entry.joint,
        interfaces=dict(entry.interfaces)
        if is_body
        else {lug.body or lug.force: entry.joint for lug in stack},
        fixed_to=None if is_body else entry.fixed_to,
        offsets=dict(entry.offsets) if is_body else {lug.body or lug.force: 0.0 for lug in stack},
        tilt_held_at=_tilt_held_at(entry, beside, file),
        stack=stack,
        surface=entry.surface,
        bearing_arc=entry.bearing_arc,
        column=entry.column,
        reliability=entry.reliability,
        fineness=entry.mesh.fineness,
        most_unknowns=entry.mesh.most_unknowns,
        contacts=rollers,
        fkm=fkm,
        arc_stated="bearing_arc" in entry.model_fields_set,
        beside=beside,
        clearances=clearances,
        bore_edges=dict(entry.bore_edges) if is_body else {},
    )


def _shape_name(entry: Any) -> str:
    if isinstance(entry, StepPartEntry):
        return entry.shape.step
    if isinstance(entry, PlatePartEntry):
        return shape_name(entry)
    return str(entry.shape)


def _beside(entry: Any, file: DesignFile) -> dict[str, dict[str, float]]:
    """Interface without an offset -> lugs of the pin that is fixed there -> mm beside the part."""
    found = {}
    for pin in file.parts.values():
        if isinstance(pin, BodyPartEntry) or pin.fixed_to != entry.body:
            continue
        heights = {lug.body or lug.force: lug.at if lug.single else 0.0 for lug in pin.stack}
        arms = {name: at - heights.get(entry.body, 0.0) for name, at in heights.items()}
        for interface, point in entry.interfaces.items():
            if point == pin.joint and interface not in entry.offsets and any(arms.values()):
                found[interface] = arms
    return found


def _tilt_held_at(entry: Any, beside: Mapping[str, Any], file: DesignFile) -> str:
    """The interface that takes the couples out of the linkage's plane that the others leave.

    Where it is not stated: one without an offset, whose couple would have no effect there, on the
    ground if there is one, as a shaft has its bearings there; then as the body has its pins.
    """
    if not isinstance(entry, BodyPartEntry):
        return str(entry.fixed_to)
    if entry.tilt_held_at:
        return entry.tilt_held_at
    pins = file.bodies[entry.body].pins

    def rank(interface: str) -> tuple[bool, bool, int]:
        point = entry.interfaces[interface]
        offset = bool(entry.offsets.get(interface)) or interface in beside
        return offset, point not in file.ground, pins.index(point)

    return min((name for name in entry.interfaces if name not in SLIDING), key=rank)


def _sits_in_body(
    key: str,
    entry: Any,
    file: DesignFile,
    joints: Mapping[str, Sequence[loads.Joint]],
    problems: Problems,
) -> bool:
    if entry.body not in file.bodies:
        problems.add(f"{key}.body", no_such("body", entry.body, file.bodies))
        return False
    told, known = len(problems), True
    holes = isinstance(entry, WITH_HOLES)
    wanted = tuple(entry.holes) if holes else SHAPES[entry.shape].fixed_interfaces()
    kind = "hole of the part" if holes else f"interface of {entry.shape}"
    pins = file.bodies[entry.body].pins
    sliding = () if holes else SLIDING
    lines = [
        name
        for name, joined in joints.items()
        for joint in joined
        if isinstance(joint, loads.Slot | loads.Prismatic) and joint.body_a == entry.body
    ]
    for interface, point in entry.interfaces.items():
        here = f"{key}.interfaces.{interface}"
        if interface not in wanted:
            problems.add(here, no_such(kind, interface, wanted))
        elif interface in sliding:
            stated = file.joints.get(point)
            if (
                stated
                and stated.kind != "fixed"
                and (point not in joints or stated.on not in file.bodies)
            ):
                known = False  # what is wrong with the joint was told there
            elif point not in lines:
                problems.add(here, no_such(f"slot or guide on body {entry.body}", point, lines))
        elif point not in pins:
            problems.add(here, no_such(f"point of body {entry.body}", point, pins))
    for name, interface in (
        *((f"offsets.{name}", name) for name in entry.offsets),
        *([("tilt_held_at", entry.tilt_held_at)] if entry.tilt_held_at else []),
    ):
        if interface not in entry.interfaces or interface in sliding:
            fixed = [known for known in entry.interfaces if known not in sliding]
            problems.add(f"{key}.{name}", no_such("interface that may tilt", interface, fixed))
    missing = [interface for interface in wanted if interface not in entry.interfaces]
    if missing:
        problems.add(f"{key}.interfaces", f"must say at which point {listed(missing)} sits")
    elif len(set(entry.interfaces.values())) < len(entry.interfaces):
        problems.add(f"{key}.interfaces", "two of them sit at the same point")
    return known and len(problems) == told


def _sits_in_joint(
    key: str, entry: Any, file: DesignFile, pins: Mapping[str, Sequence[str]], problems: Problems
) -> bool:
    pins = {**_eyes(file, pins), **pins}
    if entry.joint not in pins:
        problems.add(f"{key}.joint", no_such("joint", entry.joint, pins))
        return False
    joined, told = pins[entry.joint], len(problems)
    here = [
        name
        for name, force in file.forces.items()
        if entry.joint in (force.between or ()) or force.at == entry.joint
    ]
    if entry.fixed_to not in joined:
        kind = f"body at joint {entry.joint}"
        problems.add(f"{key}.fixed_to", no_such(kind, entry.fixed_to, joined))
    for index, lug in enumerate(entry.stack):
        where = f"{key}.stack[{index}]"
        if (lug.body is None) == (lug.force is None):
            problems.add(where, "needs either body or force: what presses on the pin here")
        elif lug.body is not None and lug.body not in joined:
            kind = f"body at joint {entry.joint}"
            problems.add(f"{where}.body", no_such(kind, lug.body, joined))
        elif lug.force is not None and lug.force not in here:
            kind = f"force at point {entry.joint}"
            problems.add(f"{where}.force", no_such(kind, lug.force, here))
    absent = [body for body in joined if body not in [lug.body for lug in entry.stack]]
    if absent:
        problems.add(
            f"{key}.stack", f"joint {entry.joint} also has {listed(absent)}: where on the pin?"
        )
    return len(problems) == told


def _eyes(file: DesignFile, pins: Mapping[str, Sequence[str]]) -> dict[str, Sequence[str]]:
    """Points at which a force meets the one body that has them: a cylinder's eye on its pin."""
    met = {
        point
        for force in file.forces.values()
        for point in (*(force.between or ()), force.at if force.direction else None)
        if point is not None and point not in pins
    }
    users = {point: bodies_at(point, file) for point in file.points if point in met}
    return {point: bodies for point, bodies in users.items() if len(bodies) == 1}


def _geometry(entry: Any, bodies: Mapping[str, loads.Body]) -> Shape:
    shape = SHAPES[entry.shape]
    if issubclass(shape, Beam):
        beam = beam_geometry(shape, entry, bodies[entry.body].points)
        check_sizes(beam)
        return beam
    values: dict[str, Any] = {}
    for parameter in dataclasses.fields(shape):
        given_by = parameter.metadata.get("given_by")
        if given_by == GIVEN_BY_DESIGN:
            values[parameter.name] = _rounded(getattr(entry, parameter.name))
        elif given_by == GIVEN_BY_LINKAGE:
            first, second = (entry.interfaces[name] for name in shape.fixed_interfaces()[:2])
            points = bodies[entry.body].points
            values[parameter.name] = _rounded(math.dist(points[first], points[second]))
    if shape is Pin:
        values["seats"] = tuple(_seat(index, lug) for index, lug in enumerate(entry.stack))
    make: Callable[..., Shape] = shape
    made = make(**values)
    check_sizes(made)
    return made


def _rounded(value: Any) -> Any:
    """A dimension to 12 digits, as it is in any unit and however the machine is drawn.

    Mesh generation is chaotic: a plate larger by 2e-16 of its size had 1009 nodes instead of 1019.
    """
    return float(f"{value:.12g}") if isinstance(value, float) else value


def _seat(index: int, lug: Any) -> Seat:
    try:
        return Seat(
            lug.body or lug.force,
            at=_rounded(lug.at),
            width=_rounded(lug.width),
            diameter=_rounded(lug.diameter),
            single=lug.single,
        )
    except ParameterError as error:
        raise ParameterError(f"seats[{index}].{error.field}", error.problem) from None
