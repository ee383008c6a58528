"""Pins by formula."""

import numpy as np

from checks.design.data import Part
from checks.handbook.notch_factors import stepped_shaft
from checks.handbook.pin_loaded_hole import PATTERNS
from checks.handbook.pin_stress import section_stress, surface_stress
from checks.joints.pin_diagrams import PinDiagram, pin_diagram
from checks.models.formula_pin_pressure import (
    ANGLES,
    PinSection,
    add_edge,
    add_pressure,
    pressure_shares,
)
from checks.models.formula_points import Points
from checks.models.shape_model import ShapeModel
from checks.models.unit_names import bearing_units, interface_units
from checks.part.part_loads import PartLoads
from checks.stress.part_model import RungModel
from fem.unit_loads import bearing_coefficients
from geometry.mesh import FloatArray
from geometry.parts import Pin, Seat

_ROWS = (0, 1, 3, 4, 5)  # of a wrench: F_x, F_y, M_x, M_y, M_z
# F_x, F_y and M_z have columns among those of the pressure: a lug presses against its force
_PUSHING = (PATTERNS.index("cos 1"), PATTERNS.index("sin 1"))
_SIGNS = (-1.0, -1.0, 1.0, 1.0, 1.0)
_PRESSED = 1.75  # mean pressure over a neck's bending stress, up to which the neck decides
_BESIDE = 1e-6  # of the way to the middle of a stretch


def stress(part: Part, shape: Pin, loads: PartLoads) -> RungModel | None:
    """A pin as a bar in its stack: every lug presses evenly over its width, as on the solid.

    None for a pin with a step without a fillet, where the elastic stress has no bound.
    """
    if shape.necked and not shape.step_fillet:
        return None
    points = Points(len(loads.accelerations))
    names = [seat.name for seat in shape.seats]
    pressing = {
        name: points.columns(
            bearing_coefficients(loads.wrenches[name][:, [0, 1, 5]], inward=True).T,
            bearing_units(name),
        )
        for name in names
    }
    forces = {}
    for name in names:
        couples = points.columns(
            loads.wrenches[name][:, 3:5].T, interface_units(name, ("M_x", "M_y"))
        )
        forces[name] = [pressing[name][k] for k in _PUSHING] + couples + pressing[name][-1:]
    diagram = pin_diagram(shape, _unit_wrenches(names))
    columns = [column for name in names for column in forces[name]]
    signs = np.tile(_SIGNS, len(names))
    nu = part.material.poisson_ratio
    sections = _sections(shape, diagram)
    sides = np.array([section.side for section in sections])
    stress = np.zeros((len(sections), len(ANGLES), 6, points.width))
    for at_section, section in zip(stress, sections, strict=True):
        at_section[..., columns] = signs * _bar_stress(shape, diagram, section, nu)
    for lug in shape.seats:
        even, grown = pressure_shares(shape, lug, sides, nu)
        add_pressure(stress, even, grown, pressing[lug.name], forces[lug.name])
    every = list(range(points.width))
    for at_section, section in zip(stress, sections, strict=True):
        if section.edge and section.seat is not None:
            seat = section.seat.name
            add_edge(at_section, shape, section, pressing[seat], forces[seat])
        radius, place = diagram.diameter[section.index] / 2, float(diagram.places[section.index])
        at = np.column_stack(
            [radius * np.cos(ANGLES), radius * np.sin(ANGLES), np.full(len(ANGLES), place)]
        )
        points.add_block(section.name, at, every, at_section)
    return points.model(
        ring=len(ANGLES),
        residual=_left_over(shape, loads, diagram, names),
        deflection=_deflection(part, shape, loads, diagram, names),
        buckling=None,
        neglects="that a short pin is no slender bar; that lugs press less where it gives way",
    )


def family(part: Part, shape: Pin, loads: PartLoads, _kind: str) -> str:
    """By the lugs, and by a neck.

    A pin in lugs that all stand on one side is bent out of a couple, one with a neck at the neck,
    unless a short arc of contact presses harder on a seat: then no half circle tells its stress.
    """
    if shape.necked:
        weaker = _pressed_over_bent(shape, loads) > _PRESSED
        return f"{part.shape} with a neck" + (" and short seats" if weaker else "")
    if not any(seat.single for seat in shape.seats):
        return part.shape
    if all(seat.single or (not seat.paired and seat.at == 0.0) for seat in shape.seats):
        return f"{part.shape} in single lugs"
    return f"{part.shape} in single and paired lugs"


def _pressed_over_bent(shape: Pin, loads: PartLoads) -> float:
    """Largest mean pressure on a seat over the largest bending stress of the necks.

    Nominal both, F/(d w) and 32 M/(pi d^3), each over all positions.
    """
    pressures = [
        float(np.hypot(*loads.wrenches[seat.name][:, :2].T).max())
        / (shape.neck(seat) * seat.width * len(seat.places))
        for seat in shape.seats
    ]
    diagram = pin_diagram(shape, dict(loads.wrenches), ends_only=True)
    bent = float(diagram.bending_stress[:, diagram.diameter < shape.diameter].max())
    return max(pressures) / bent if bent else np.inf


def _unit_wrenches(names: list[str]) -> dict[str, FloatArray]:
    """Wrenches (5 per seat, 6) of which each has one component at one seat."""
    count = len(_ROWS)
    found = {}
    for k, name in enumerate(names):
        unit = np.zeros((count * len(names), 6))
        unit[np.arange(count * k, count * (k + 1)), list(_ROWS)] = 1.0
        found[name] = unit
    return found


def _stretches(diagram: PinDiagram) -> list[FloatArray]:
    """Numbers of ends and middle of each stretch of equal load and diameter."""
    starts = np.flatnonzero(np.r_[True, np.diff(diagram.places) <= 0])
    stops = np.r_[starts[1:], len(diagram.places)] - 1
    return [np.array([a, (a + b) // 2, b]) for a, b in zip(starts, stops, strict=True)]


def _sections(shape: Pin, diagram: PinDiagram) -> list[PinSection]:
    """Sections that can be stressed most.

    Ends of the stretches between lugs, where shear is even; in a lug its ends, middles and middle.
    Of a pin with pairs of lugs only, z >= 0: the rest is stressed alike.
    """
    lowest = -np.inf if any(seat.single for seat in shape.seats) else 0.0
    found: list[PinSection] = []
    taken: set[tuple[float, str]] = set()
    for indices in _stretches(diagram):
        low, high = diagram.places[indices[0]], diagram.places[indices[-1]]
        seat, middle = _seat_at(shape, (low + high) / 2)
        if seat is None and not _between_lugs(shape, low, high):
            continue
        for index in indices if seat is not None else indices[[0, -1]]:
            place = float(diagram.places[index])
            key = (place, "" if seat is None else seat.name)
            if place < lowest or key in taken:
                continue
            taken.add(key)
            side = place + _BESIDE * ((low + high) / 2 - place)
            found.append(PinSection(int(index), seat, middle, side))
            if seat is not None and _ends(seat, middle, place):
                edge = 1 if place > middle else -1
                found.append(PinSection(int(index), seat, middle, place, edge))
    return found


def _ends(seat: Seat, middle: float, place: float) -> bool:
    """True if a place is at an edge of a lug."""
    return abs(abs(place - middle) - seat.width / 2) < 1e-6 * seat.width


def _seat_at(shape: Pin, place: float) -> tuple[Seat | None, float]:
    """The seat whose lug is at a place of the pin, and the middle of that lug."""
    for seat, low, high in shape.seated():
        if low < place < high:
            return seat, (low + high) / 2
    return None, 0.0


def _between_lugs(shape: Pin, low: float, high: float) -> bool:
    seated = shape.seated()
    return bool(min(s[1] for s in seated) <= low and high <= max(s[2] for s in seated))


def _bar_stress(
    shape: Pin,
    diagram: PinDiagram,
    section: PinSection,
    poisson_ratio: float,
) -> FloatArray:
    """Stress (k, 6, c) of bending, shear and twist at a section, with a neck's fillet."""
    index, seat = section.index, section.seat
    diameter = float(diagram.diameter[index])
    along, across = section_stress(
        ANGLES,
        diameter,
        diagram.shear[:, index],
        diagram.moment[:, index],
        diagram.torque[:, index],
        poisson_ratio,
    )
    bent = turned = 1.0
    necked = seat is not None and diameter < shape.diameter
    if necked and seat is not None and _ends(seat, section.middle, diagram.places[index]):
        sizes = (shape.diameter, diameter, shape.step_fillet)
        bent, turned = stepped_shaft("bending", *sizes), stepped_shaft("torsion", *sizes)
    none = np.zeros_like(along)
    return surface_stress(ANGLES, none, none, bent * along, turned * across)


def _deflection(
    part: Part, shape: Pin, loads: PartLoads, diagram: PinDiagram, names: list[str]
) -> float:
    """Largest deflection off the chord, mm: at most the largest curvature times length^2/8."""
    unit = np.concatenate([loads.wrenches[name][:, list(_ROWS)] for name in names], axis=1)
    curvature = 0.0
    for index in np.concatenate(_stretches(diagram)):
        moment = unit @ diagram.moment[:, index]
        inertia = np.pi * diagram.diameter[index] ** 4 / 64
        largest = float(np.hypot(moment[:, 0], moment[:, 1]).max())
        curvature = max(curvature, largest / (part.material.youngs_modulus * inertia))
    low, high = shape.ends
    return curvature * (high - low) ** 2 / 8


def _left_over(shape: Pin, loads: PartLoads, diagram: PinDiagram, names: list[str]) -> float:
    """Force, and moment over the pin's length, beyond its upper end, over the largest force."""
    largest = loads.largest_force
    if not largest:
        return 0.0
    unit = np.concatenate([loads.wrenches[name][:, list(_ROWS)] for name in names], axis=1)
    force, moment = unit @ diagram.shear[:, -1], unit @ diagram.moment[:, -1]
    left = max(float(np.abs(force).max()), float(np.abs(moment).max()) / shape.length)
    return left / largest


MODEL = ShapeModel(Pin, stress, family=family, tilts=True)
