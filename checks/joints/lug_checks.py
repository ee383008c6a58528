"""Lugs by formula: mean pressure of the pin in its hole, and the pin tearing out behind it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from checks.design.data import Design, Part
from checks.design.materials import Material
from checks.design.model import StackEntry
from checks.handbook.lugs import ball_ligament, bearing_pressure, shear_out
from checks.joints.tear_planes import tear_lengths
from checks.part.first_maximum import first_largest
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check
from geometry.cad_body import SolidBody
from geometry.mesh import FloatArray, Interface, Mesh
from geometry.parts import Pin, PlateLink, SlottedLever, ToggleBar, TubeRod
from geometry.parts.step_part import StepPart

_ROUND = ("bore", "journal")
_DIRECTIONS = 72


@dataclass(frozen=True)
class Ligament:
    """Material behind a hole: mm2 in one shear plane, and what stands at its other side.

    direction  unit vector in the part's axes in which a force on the part tears it; None: any,
               and `area` is then that of 72 directions from +x on, counter-clockwise; infinite
               where nothing tears
    """

    direction: tuple[float, float] | None
    area: tuple[float, ...]
    until: str


@dataclass(frozen=True)
class Lug:
    """A hole: what presses in it, mm, and the weaker of both.

    diameter, width  of the pin where it bears in the hole itself, else of the hole and its bush
    softer           the part's material, or the bare pin's if that yields first
    """

    interface: str
    diameter: float
    width: float
    softer: Material
    note: str


def lug_checks(loaded: LoadedPart, body: Mesh | SolidBody) -> list[Check]:
    """Pressure in the holes of a part and shear behind them, each where it is worst."""
    part = loaded.part
    if isinstance(part.geometry, Pin):
        return []
    lugs = lugs_of(loaded.design, part, body)
    if not lugs:
        return []
    torn = _shear_out(loaded, body, lugs)
    return [_bearing(loaded, lugs), *([torn] if torn else [])]


def lugs_of(design: Design, part: Part, body: Mesh | SolidBody) -> list[Lug]:
    """Return the holes and journals of a part that carry a pin of the machine."""
    return [
        _lug(design, part, interface)
        for name, interface in body.interfaces.items()
        if interface.kind in _ROUND and name in part.interfaces
    ]


def _lug(design: Design, part: Part, interface: Interface) -> Lug:
    """A hole or journal, and in a hole the pin of the design that is in it, if it has its part."""
    whole = Lug(interface.name, 2 * interface.radius, interface.length, part.material, "")
    pin = _pin_in(design, part, part.interfaces[interface.name])
    if interface.kind != "bore" or pin is None:
        return whole
    shape, entry = pin.geometry, _entry(pin, part)
    assert isinstance(shape, Pin)
    count = 2 if entry.at and not entry.single else 1
    if entry.bush is not None:
        return replace(whole, width=min(whole.width, count * entry.bush.length))
    diameter = min(whole.diameter, entry.diameter or shape.diameter)
    softer = min(part.material, pin.material, key=lambda material: material.yield_stress)
    told = f"pin of {diameter:g} mm in a hole of {whole.diameter:g} mm"
    return replace(
        whole,
        diameter=diameter,
        width=min(whole.width, count * entry.width),
        softer=softer,
        note=told if diameter < whole.diameter else "",
    )


def _pin_in(design: Design, part: Part, point: str) -> Part | None:
    """The part of the pin at a point of a part, if the design has it and the part a lug on it."""
    for other in design.parts.values():
        lugs = {entry.body for entry in other.stack}
        if isinstance(other.geometry, Pin) and other.joint == point and part.body in lugs:
            return other
    return None


def _entry(pin: Part, part: Part) -> StackEntry:
    return next(entry for entry in pin.stack if entry.body == part.body)


@dataclass(frozen=True)
class Pressed:
    """A hole at the position where it is pressed most: MPa, position, N."""

    pressure: float
    position: int
    force: float
    lug: Lug


def pressed_lugs(loads: PartLoads, lugs: Sequence[Lug]) -> list[Pressed]:
    """Every hole where it is pressed most, the largest share of what it may bear first."""
    found = []
    for lug in lugs:
        force = loads.resultant(lug.interface)
        (worst,) = first_largest(force)
        pressure = bearing_pressure(float(force[worst]), lug.diameter, lug.width)
        found.append(Pressed(pressure, worst, float(force[worst]), lug))
    (row,) = first_largest(np.array([one.pressure / one.lug.softer.yield_stress for one in found]))
    return [found[row], *(one for k, one in enumerate(found) if k != row)]


def _bearing(loaded: LoadedPart, lugs: Sequence[Lug]) -> Check:
    """Check the hole whose pressure is the largest share of what the softer of both may bear."""
    loads = loaded.loads
    most, *less = pressed_lugs(loads, lugs)
    lug, worst = most.lug, most.position
    others = ", ".join(f"{one.lug.interface} {one.pressure:.3g}" for one in less)
    return Check(
        part=loaded.part.name,
        kind="bearing",
        quantity="mean pressure of the pin F/(d t)",
        value=most.pressure,
        unit="MPa",
        numerical=0.0,
        model=0.0,
        limit=lug.softer.yield_stress,
        required=loaded.required.static,
        cycle=loads.cycle_names[worst],
        position=loads.labels[worst],
        place=f"{lug.interface}, {lug.diameter:g} x {lug.width:g} mm",
        method="formula",
        basis=f"yield stress of {lug.softer.name}, the weaker of pin and hole, on the projected "
        "area: EN 1993-1-8 table 3.10 allows 1.5 f_y where nothing moves, 0.6 f_y under service "
        "loads for a pin that is to come out again",
        note="; ".join(
            text
            for text in (
                f"F = {most.force:.0f} N",
                lug.note,
                f"other holes, MPa: {others}" if others else "",
            )
            if text
        ),
    )


@dataclass(frozen=True)
class Torn:
    """A ligament at the position where it is sheared most: MPa, position, N, mm2."""

    stress: float
    position: int
    force: float
    area: float
    lug: Lug
    ligament: Ligament


def torn_most(
    part: Part, loads: PartLoads, body: Mesh | SolidBody, lugs: Sequence[Lug]
) -> Torn | None:
    """The ligament behind a bore that is sheared most; None where no pin pulls at one."""
    found = []
    for lug in lugs:
        if body.interfaces[lug.interface].kind != "bore":
            continue
        wrench = loads.wrenches[lug.interface]
        for ligament in ligaments(part, body, lug.interface):
            pull, area = _pull(wrench, ligament)
            stress = shear_out(pull, area)
            (worst,) = first_largest(stress)
            tearing, plane = float(pull[worst]), float(area[worst])
            found.append(Torn(float(stress[worst]), worst, tearing, plane, lug, ligament))
    if not found or not max(one.stress for one in found) > 0:
        return None
    (row,) = first_largest(np.array([one.stress for one in found]))
    return found[row]


def _shear_out(loaded: LoadedPart, body: Mesh | SolidBody, lugs: Sequence[Lug]) -> Check | None:
    """Check the ligament that is sheared most; None where no pin pulls at one."""
    part, loads = loaded.part, loaded.loads
    torn = torn_most(part, loads, body, lugs)
    if torn is None:
        return None
    worst, lug = torn.position, torn.lug
    return Check(
        part=part.name,
        kind="shear-out",
        quantity="mean shear stress behind the pin F/(2 A)",
        value=torn.stress,
        unit="MPa",
        numerical=0.0,
        model=0.0,
        limit=part.material.yield_stress / float(np.sqrt(3)),
        required=loaded.required.static,
        cycle=loads.cycle_names[worst],
        position=loads.labels[worst],
        place=f"{lug.interface}, towards {torn.ligament.until}",
        method="formula",
        basis="yield stress over sqrt 3",
        note=f"F = {torn.force:.0f} N that way, A = {torn.area:.4g} mm2 in each of two planes",
    )


def _pull(wrench: FloatArray, ligament: Ligament) -> tuple[FloatArray, FloatArray]:
    """Force (n,) that tears a ligament, N, and the area (n,) of one plane, mm2."""
    if ligament.direction is not None:
        pull = np.maximum(wrench[:, :2] @ np.array(ligament.direction), 0.0)
        return pull, np.full(len(pull), ligament.area[0])
    angle = np.arctan2(wrench[:, 1], wrench[:, 0])
    sector = np.round(angle / (2 * np.pi) * _DIRECTIONS).astype(int) % _DIRECTIONS
    return np.hypot(wrench[:, 0], wrench[:, 1]), np.array(ligament.area)[sector]


def ligaments(part: Part, body: Mesh | SolidBody, interface: str) -> list[Ligament]:
    """What a pin can tear out of a hole: towards the part's end, or into a slot beside the hole.

    A boss is left out of it. Of a part from CAD the ligament is looked for in all directions.
    """
    shape = part.geometry
    length = getattr(shape, "length", 0.0)
    outward = (-1.0, 0.0) if interface == part.geometry.interfaces[0] else (1.0, 0.0)
    end = f"the end at x {'< 0' if outward[0] < 0 else f'> {length:g} mm'}"
    if isinstance(shape, ToggleBar):
        return [Ligament(outward, (2 * shape.wall * (shape.overhang - shape.hole / 2),), end)]
    if isinstance(shape, PlateLink):
        hole = 2 * body.interfaces[interface].radius
        return [Ligament(outward, (shape.thickness * (shape.width - hole) / 2,), end)]
    if isinstance(shape, TubeRod):
        area = ball_ligament(shape.eye_diameter, shape.eye_width, shape.hole)
        return [Ligament(outward, (area,), end)]
    if isinstance(shape, SlottedLever):
        beyond = shape.width / 2 if shape.overhang is None else shape.overhang
        inner = shape.slot_from if interface == "pivot" else shape.length - shape.slot_to
        inward = (-outward[0], 0.0)
        return [
            Ligament(outward, (shape.thickness * (beyond - shape.hole / 2),), end),
            Ligament(inward, (shape.thickness * (inner - shape.hole / 2),), "the slot"),
        ]
    if isinstance(shape, StepPart):
        if not isinstance(body, Mesh):
            raise TypeError("the ligaments of a CAD part are measured on its mesh")
        return [ligament_all_round(body, interface)]
    return []


def ligament_all_round(mesh: Mesh, name: str) -> Ligament:
    """The ligament of a hole in every direction, as the shear planes are on the mesh."""
    angles = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    areas = mesh.interfaces[name].length * tear_lengths(mesh, name, angles.tolist())
    return Ligament(None, tuple(areas.tolist()), "the wall that the force points at")
