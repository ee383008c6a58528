"""Reads how parts are joined: welds, screws, rollers, bushes, fits of pins and edges of bores."""

from collections.abc import Mapping
from math import inf
from typing import Any

from checks.design.data import Roller, Weld
from checks.design.errors import Problems, listed, no_such
from checks.design.materials import Material
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
from checks.handbook.fits import clearances_of
from checks.handbook.weld_details import HIGHEST, STANDARD, category_of
from geometry.bars import RulingSection, Walls
from geometry.mesh import Interface
from geometry.parameters import ParameterError
from geometry.parts import SHAPES
from geometry.parts.plate import Plate
from geometry.shape import Shape

_STEEL = (185e3, 220e3)  # MPa, Young's modulus of steels
# whose interfaces are holes that the entry names
WITH_HOLES = (StepPartEntry, PlatePartEntry, BeamPartEntry)
SLIDING = ("contact", "slot")  # interfaces of shapes on which a slot or guide of the linkage runs


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


def bolts_of(key: str, entry: Any, problems: Problems) -> tuple[BoltsEntry, ...]:
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


def rollers_of(
    key: str, entry: Any, materials: Mapping[str, Material], problems: Problems
) -> dict[str, Roller]:
    """Pins and rollers on the part's sliding contacts; flat blocks are left out."""
    sliding = [name for name in entry.interfaces if name in SLIDING]
    rollers = {}
    for name, contact in entry.contacts.items():
        if name not in sliding or isinstance(entry, WITH_HOLES):
            known = no_such("sliding interface of the part", name, sliding)
            problems.add(f"{key}.contacts.{name}", known)
        elif contact.material is not None and contact.material not in materials:
            known = no_such("material", contact.material, materials)
            problems.add(f"{key}.contacts.{name}.material", known)
        elif 2 * contact.radius > (room := getattr(entry, "slot_width", inf)):
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


def bush_materials_of(
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


def fits_of(
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


def check_edges(key: str, entry: Any, geometry: Shape, problems: Problems) -> None:
    """Tell of edges that are stated of what is no bore."""
    bores = _bores(geometry)
    for name in entry.bore_edges if isinstance(entry, BodyPartEntry) else ():
        if name not in bores:
            problems.add(f"{key}.bore_edges.{name}", no_such("bore of the part", name, bores))


def _bores(geometry: Shape) -> dict[str, Interface]:
    return {face.name: face for face in geometry.placed_interfaces if face.kind == "bore"}
