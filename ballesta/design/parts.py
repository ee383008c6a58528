"""Puts the parts of a design together: shape, material, welds, screws, where they sit."""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import loads
from ballesta.design.files import Sources
from ballesta.design.linkage import bodies_at
from ballesta.design.plate_parts import (
    beam_geometry,
    plate_geometry,
    shape_name,
    step_geometry,
)
from ballesta.design.stacks import check_stacks, with_plays, with_press_fits, with_widths
from checks.design.data import Part, Roller, Weld
from checks.design.errors import LINKAGE, DesignError, Problems, listed, no_such
from checks.design.materials import Material, known_materials
from checks.design.model import (
    BeamPartEntry,
    BodyPartEntry,
    BoltsEntry,
    DesignFile,
    PinPartEntry,
    PlatePartEntry,
    StepPartEntry,
    WeldEntry,
)
from checks.design.strength import FkmStrength, fkm_of
from checks.handbook.fits import clearances_of
from checks.handbook.weld_details import HIGHEST, STANDARD, category_of
from checks.result.words import clipped
from geometry.bars import RulingSection, Walls
from geometry.mesh import Interface
from geometry.parameters import GIVEN_BY_DESIGN, GIVEN_BY_LINKAGE, ParameterError
from geometry.parts import SHAPES, Beam, Pin, Seat
from geometry.parts.plate import Plate
from geometry.shape import Shape, check_sizes, key_of

_STEEL = (185e3, 220e3)  # MPa, Young's modulus of steels


def welds_of(
    key: str, entry: Any, geometry: Shape, material: Material, problems: Problems
) -> tuple[Weld, ...]:
    """The welds of a part that are in order; what is wrong with the others is noted."""
    found: list[Weld] = []
    if getattr(entry, "welds", ()) and not _STEEL[0] <= material.youngs_modulus <= _STEEL[1]:
        problems.add(
            f"{key}.welds",
            f"welds are judged by {STANDARD}, which is of steel; {material.name} is none, as its "
            f"Young's modulus of {material.youngs_modulus / 1e3:.4g} GPa says; leave them out",
        )
        return ()
    if getattr(entry, "welds", ()) and geometry.walls and geometry.profile is None:
        problems.add(f"{key}.welds", "the shape tells no profile, so no force in a weld is known")
        return ()
    for index, stated in enumerate(getattr(entry, "welds", ())):
        here = f"{key}.welds[{index}]"
        try:
            new = _weld(stated, geometry)
        except ParameterError as error:
            problems.add(f"{here}.{error.field}", error.problem)
            continue
        if any(one.place == new.place for one in found):
            problems.add(f"{here}.at", f"another weld of the part stands at {new.place}")
        found.append(new)
    return tuple(found)


def _weld(stated: WeldEntry, geometry: Shape) -> Weld:
    """A weld; raises ParameterError where there is no wall, or none that its detail is for."""
    walls = _walls_at(stated, geometry)
    if stated.throat is not None and walls.outline == "I":
        raise ParameterError("throat", "of an I section's welds is not judged; leave it out")
    if stated.throat is not None and stated.throat > walls.wall:
        raise ParameterError(
            "throat",
            f"{stated.throat:g} mm is more than the wall of {walls.wall:g} mm; it must be at most "
            f"{walls.wall:g} mm; is {stated.throat:g} mm the leg, which is 1.41 times the throat?",
        )
    if (stated.detail is None) == (stated.category is None):
        raise ParameterError("detail", "needs either detail or category, one of the two")
    category, where = _stated_category(stated) if stated.category else _of_detail(stated, walls)
    return Weld(
        stated.at,
        walls,
        category,
        where,
        stated.throat,
        stated.partial_factor,
        geometry.interfaces[0],
        tuple(stated.between or ()),
    )


def _walls_at(stated: WeldEntry, geometry: Shape) -> Walls:
    at = stated.at
    if isinstance(geometry, Plate):
        return geometry.walls_across(at, stated.between or ())
    if type(geometry).walls is Shape.walls:
        able = sorted(name for name, one in SHAPES.items() if one.walls is not Shape.walls)
        able += ["levers and drawn plates"]
        raise ParameterError("at", f"no weld is judged on this shape, but on {listed(able)}")
    if stated.between is not None:
        raise ParameterError("between", "is of levers and drawn plates; leave it out")
    if not geometry.walls:
        raise ParameterError("at", "the part has no stretch with even walls, away from holes")
    for walls in geometry.walls:
        if walls.stretch[0] <= at <= walls.stretch[1]:
            return walls
    spans = listed("{:.4g} to {:.4g} mm".format(*one.stretch) for one in geometry.walls)
    raise ParameterError(
        "at", f"at {at:g} mm the stress is not that of even walls; it is from {spans}"
    )


def _stated_category(stated: WeldEntry) -> tuple[float, str]:
    assert stated.category is not None
    if stated.category > HIGHEST:
        raise ParameterError(
            "category",
            f"{stated.category:g} MPa is above {HIGHEST:g} MPa, the highest of {STANDARD}, figure "
            "7.1",
        )
    if stated.length is not None:
        raise ParameterError("length", "is of a detail; a stated category needs none")
    return stated.category, "stated in the design"


def _of_detail(stated: WeldEntry, walls: Walls) -> tuple[float, str]:
    """Category of a named detail, MPa, and where it is from."""
    assert stated.detail is not None
    if walls.outline == "round" and 2 * walls.wall >= walls.size:
        raise ParameterError(
            "detail",
            f"{stated.detail!r}: {STANDARD} has it of tubes, the part is a solid rod there; state "
            "a category of another source",
        )
    try:
        category, row = category_of(stated.detail, walls.outline, walls.wall, stated.length)
    except ValueError as error:
        raise ParameterError("detail", f"{stated.detail!r}: {error}") from None
    if row.throat and stated.throat is None:
        raise ParameterError("throat", "must be stated: the root of a fillet weld carries the load")
    if stated.throat is not None and not row.throat:
        raise ParameterError(
            "throat", f"{stated.detail!r} has no root that carries load; leave it out"
        )
    return category, f"{STANDARD}, {row.where}"


_WITH_HOLES = (
    StepPartEntry,
    PlatePartEntry,
    BeamPartEntry,
)  # whose interfaces are holes that the entry names
SLIDING = ("contact", "slot")  # interfaces of shapes on which a slot or guide of the linkage runs
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
            rollers = _rollers(key, entry, materials, problems)
        else:
            sits = _sits_in_joint(key, entry, file, pins, problems)
            rollers = {}
        bushes = _bush_materials(key, entry, materials, problems)
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
            if not isinstance(entry, _WITH_HOLES):
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
        clearances = _clearances(key, entry, file, geometry, problems)
        welds = welds_of(key, entry, geometry, material, problems)
        _check_edges(key, entry, geometry, problems)
        bolts = _bolts(key, entry, problems)
        made = _part(name, entry, file, geometry, material, rollers, fkm, clearances)
        parts[name] = dataclasses.replace(made, welds=welds, bolts=bolts, bushes=bushes)
    parts = with_widths(parts)
    check_stacks(parts, file.parts, problems)
    return with_press_fits(with_plays(parts), problems)


def _bolts(key: str, entry: Any, problems: Problems) -> tuple[BoltsEntry, ...]:
    """Screws of a part; what is wrong with them is noted."""
    stated: tuple[BoltsEntry, ...] = tuple(getattr(entry, "bolts", ()))
    fixed = [name for name in getattr(entry, "interfaces", ()) if name not in SLIDING]
    for index, one in enumerate(stated):
        here = f"{key}.bolts[{index}]"
        if one.at not in fixed:
            problems.add(f"{here}.at", no_such("interface with a pin", one.at, fixed))
        if any(one.at == other.at for other in stated[:index]):
            problems.add(
                f"{here}.at", f"other screws stand at {one.at}; state all of them together"
            )
        if (one.torque is None) == (one.largest_preload is None):
            problems.add(f"{here}.torque", "needs either torque or largest_preload, one of the two")
        for field in ("head_friction", "head_diameter"):
            if (one.torque is None) != (getattr(one, field) is None):
                why = "is of a torque; leave it out" if one.torque is None else "must be stated"
                problems.add(f"{here}.{field}", f"{why}: of a torque it takes its share")
        if one.torque is not None and not one.thread_friction:
            problems.add(
                f"{here}.thread_friction",
                "0 is for screws that no torque tightens; a torque needs its friction",
            )
    return stated


def _rollers(
    key: str, entry: Any, materials: Mapping[str, Material], problems: Problems
) -> dict[str, Roller]:
    """Pins and rollers on the part's sliding contacts; flat blocks are left out."""
    sliding = [name for name in entry.interfaces if name in SLIDING]
    rollers = {}
    for name, contact in entry.contacts.items():
        if name not in sliding or isinstance(entry, _WITH_HOLES):
            known = no_such("sliding interface of the part", name, sliding)
            problems.add(f"{key}.contacts.{name}", known)
        elif contact.material is not None and contact.material not in materials:
            known = no_such("material", contact.material, materials)
            problems.add(f"{key}.contacts.{name}.material", known)
        elif 2 * contact.radius > (room := getattr(entry, "slot_width", math.inf)):
            problems.add(
                f"{key}.contacts.{name}.radius",
                f"a roller of radius {contact.radius:g} mm cannot stand in a slot of {room:g} mm; "
                f"it must be at most {room / 2:g} mm; is {contact.radius:g} mm its diameter?",
            )
        else:
            size = RulingSection(2 * contact.radius, round=True)
            try:
                own = materials[contact.material].of((size,)) if contact.material else None
            except ParameterError as error:
                problems.add(f"{key}.contacts.{name}.material", error.problem)
                continue
            rollers[name] = Roller(contact.radius, own)
    return rollers


def _bush_materials(
    key: str, entry: Any, materials: Mapping[str, Material], problems: Problems
) -> dict[str, Material]:
    """Materials of a pin's bushes that state one, by what presses there."""
    found = {}
    for index, lug in enumerate([] if isinstance(entry, BodyPartEntry) else entry.stack):
        name = lug.bush.material if lug.bush else None
        if name is None:
            continue
        if name in materials:
            found[lug.name] = materials[name]
        else:
            where = f"{key}.stack[{index}].bush.material"
            problems.add(where, no_such("material", name, materials))
    return found


def _clearances(
    key: str, entry: Any, file: DesignFile, geometry: Shape, problems: Problems
) -> dict[str, tuple[float, float]]:
    """Least and largest clearance of the pin in each bore whose fit is stated, mm on diameter."""
    found: dict[str, tuple[float, float]] = {}
    if not isinstance(entry, BodyPartEntry):
        return found
    bores = _bores(geometry)
    if bores and "bearing_arc" in entry.model_fields_set and set(bores) <= set(entry.fits):
        problems.add(
            f"{key}.bearing_arc",
            "the fit of the pin in every bore of the part is stated (fits), so where pins press is "
            "solved and no arc is assumed; state only one of the two",
        )
    for name, fit in sorted(entry.fits.items()):
        if name not in bores:
            problems.add(f"{key}.fits.{name}", no_such("bore of the part", name, bores))
            continue
        nominal = _pin_in_bush(file, entry, name) or 2 * bores[name].radius
        try:
            found[name] = fit if isinstance(fit, tuple) else clearances_of(fit, nominal)
        except ValueError as error:
            problems.add(f"{key}.fits.{name}", str(error))
            continue
        if found[name][1] >= bores[name].radius / 5:
            problems.add(
                f"{key}.fits.{name}",
                f"a clearance of {found[name][1]:g} mm is more than a tenth of the bore's diameter "
                f"of {2 * bores[name].radius:g} mm; is it in another unit?",
            )
    return found


def _pin_in_bush(file: DesignFile, entry: BodyPartEntry, bore: str) -> float | None:
    """Diameter of the pin that runs in the bush of a bore, mm; None of a bore without a bush."""
    for pin in file.parts.values():
        if isinstance(pin, PinPartEntry) and pin.joint == entry.interfaces.get(bore):
            for lug in pin.stack:
                if lug.body == entry.body and lug.bush is not None:
                    return lug.diameter or vars(pin).get("diameter")
    return None


def _check_edges(key: str, entry: Any, geometry: Shape, problems: Problems) -> None:
    """Tell of edges that are stated of what is no bore."""
    bores = _bores(geometry)
    for name in entry.bore_edges if isinstance(entry, BodyPartEntry) else ():
        if name not in bores:
            problems.add(f"{key}.bore_edges.{name}", no_such("bore of the part", name, bores))


def _bores(geometry: Shape) -> dict[str, Interface]:
    return {face.name: face for face in geometry.placed_interfaces if face.kind == "bore"}


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
    holes = isinstance(entry, _WITH_HOLES)
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
