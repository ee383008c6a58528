"""The rung `formula` of pins."""

from itertools import pairwise

import numpy as np

from ballesta.design_data import Part
from ballesta.part_loads import PartLoads
from ballesta.pin_checks import PinDiagram, pin_diagram
from ballesta.rungs.formula_points import Points
from ballesta.rungs.model import RungModel
from fem.notch_factors import stepped_shaft
from fem.pin_stress import section_stress, surface_stress, under_band
from fem.unit_loads import bearing_coefficients
from geometry.mesh import FloatArray
from geometry.parts import Pin, Seat

ANGLES = np.radians(np.arange(0.0, 360.0, 15.0))
_ROWS = (0, 1, 3, 4, 5)  # of a wrench: F_x, F_y, M_x, M_y, M_z
_BESIDE = 1e-6  # of the way to the middle of a stretch
_SLICES = 8  # of a pressure that grows along a lug
_WAVES = np.stack(
    [
        np.ones_like(ANGLES),
        *(wave(n * ANGLES) for n in (1, 2, 4) for wave in (np.cos, np.sin)),
        np.zeros_like(ANGLES),  # the friction couple presses nothing
    ]
)


def pin_model(part: Part, shape: Pin, loads: PartLoads) -> RungModel | None:
    """A pin as a bar in its stack: every lug presses evenly over its width, as on the solid.

    None for a pin with a step without a fillet, where the elastic stress has no bound.
    """
    if not shape.step_fillet and any(_neck(shape, seat) < shape.diameter for seat in shape.seats):
        return None
    points = Points(len(loads.accelerations))
    names = [seat.name for seat in shape.seats]
    forces = {name: points.columns(loads.wrenches[name][:, list(_ROWS)].T) for name in names}
    pressing = {
        name: points.columns(
            bearing_coefficients(loads.wrenches[name][:, [0, 1, 5]], inward=True).T
        )
        for name in names
    }
    diagram = pin_diagram(shape, _unit_wrenches(names), spread=True)
    columns = [column for name in names for column in forces[name]]
    nu = part.material.poisson_ratio
    sections = _sections(shape, diagram)
    sides = np.array([side for *_, side in sections])
    shares = {seat.name: _shares(shape, seat, sides, nu) for seat in shape.seats}
    for k, (index, seat, middle, _) in enumerate(sections):
        stress = _bar_stress(shape, diagram, index, seat, middle, columns, nu)
        place, name = float(diagram.places[index]), "pin"
        if seat is not None:
            name = f"{seat.name} on the pin"
        for lug in shape.seats:
            even, grown = shares[lug.name]
            _add_pressure(stress, even[:, k], grown[:, k], pressing[lug.name], forces[lug.name])
        radius = diagram.diameter[index] / 2
        at = np.column_stack(
            [radius * np.cos(ANGLES), radius * np.sin(ANGLES), np.full(len(ANGLES), place)]
        )
        points.add(name, at, stress)
    return RungModel(
        rung="formula",
        history=points.history(),
        places=points.places,
        fretting=points.fretting,
        numerical=0.0,
        residual=_left_over(shape, loads, diagram, names),
        deflection=_deflection(part, shape, loads, diagram, names),
        buckling=None,
        scales=_scales(shape),
        neglects="that a short pin is no slender bar; that lugs press less where it gives way; "
        "stress at the edges of the lugs' pressure",
    )


def _neck(shape: Pin, seat: Seat) -> float:
    return shape.diameter if seat.diameter is None else seat.diameter


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


def _sections(shape: Pin, diagram: PinDiagram) -> list[tuple[int, Seat | None, float, float]]:
    """Sections that can be stressed most: number, the seat there if any, middle of its lug, mm.

    Last the place, moved off the end of its stretch by next to nothing: a lug's pressure ends in a
    step, and so does the stress.
    Ends of the stretches between lugs, where shear is even; in a lug its ends, middles and middle.
    Of a pin with pairs of lugs only, z >= 0: the rest is stressed alike.
    """
    lowest = -np.inf if any(seat.single for seat in shape.seats) else 0.0
    found: list[tuple[int, Seat | None, float, float]] = []
    taken: set[tuple[float, str]] = set()
    for indices in _stretches(diagram):
        low, high = diagram.places[indices[0]], diagram.places[indices[-1]]
        seat, middle = _seat_at(shape, (low + high) / 2)
        if seat is None and not _between_lugs(shape, low, high):
            continue
        for index in indices if seat is not None else indices[[0, -1]]:
            place = float(diagram.places[index])
            key = (place, "" if seat is None else seat.name)
            if place >= lowest and key not in taken:
                taken.add(key)
                found.append(
                    (int(index), seat, middle, place + _BESIDE * ((low + high) / 2 - place))
                )
    return found


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
    index: int,
    seat: Seat | None,
    middle: float,
    columns: list[int],
    poisson_ratio: float,
) -> dict[int, FloatArray]:
    """Stress by column of bending, shear and twist at a section, with a neck's fillet."""
    diameter = float(diagram.diameter[index])
    along, sheared = section_stress(
        ANGLES,
        diameter,
        diagram.shear[:, index],
        diagram.moment[:, index],
        diagram.torque[:, index],
        poisson_ratio,
    )
    bent = turned = 1.0
    if seat is not None and diameter < shape.diameter:
        end = abs(abs(diagram.places[index] - middle) - seat.width / 2) < 1e-6 * seat.width
        if end:
            sizes = (shape.diameter, diameter, shape.step_fillet)
            bent, turned = stepped_shaft("bending", *sizes), stepped_shaft("torsion", *sizes)
    none = np.zeros(len(ANGLES))
    return {
        column: surface_stress(ANGLES, none, none, bent * along[:, k], turned * sheared[:, k])
        for k, column in enumerate(columns)
    }


def _shares(
    shape: Pin, seat: Seat, sides: FloatArray, poisson_ratio: float
) -> tuple[FloatArray, FloatArray]:
    """Stress (3, s) at places (s,) along the pin of a seat's pressure per waves around, 1/mm2.

    Of the half cosine's waves, and of the waves x and y of a couple: 1/mm3.
    """
    radius = _neck(shape, seat) / 2
    middles = np.array(seat.places)
    half = seat.width / 2
    even = under_band(sides, middles - half, middles + half, radius, poisson_ratio).sum(axis=2)
    even /= np.pi * radius * seat.width * len(middles)
    centre = 0.0 if seat.paired else seat.at
    second = sum(seat.width**3 / 12 + seat.width * (z - centre) ** 2 for z in middles)
    cuts = np.concatenate([z - half + seat.width * np.arange(_SLICES) / _SLICES for z in middles])
    thin = seat.width / _SLICES
    arms = cuts + thin / 2 - centre
    grown = under_band(sides, cuts, cuts + thin, radius, poisson_ratio) @ arms
    return even, grown / (second * np.pi * radius)


def _add_pressure(
    stress: dict[int, FloatArray],
    even: FloatArray,
    grown: FloatArray,
    pressing: list[int],
    forces: list[int],
) -> None:
    """Add a lug's pressure: the half cosine, and of a couple one that grows along the pin."""
    for column, wave in zip(pressing, _WAVES, strict=True):
        stress[column] = _pressed(even, wave)
    # f_x = z M_y/J pushes along +x where the pressure is -cos, f_y = -z M_x/J
    for column, wave in ((forces[2], np.sin(ANGLES)), (forces[3], -np.cos(ANGLES))):
        stress[column] = stress[column] + _pressed(grown, wave)


def _pressed(shares: FloatArray, pressure: FloatArray) -> FloatArray:
    """Stress (k, 6) of a pressure (k,) of which shares act along, around and along the radius."""
    along, around, radial = shares
    none = np.zeros(len(ANGLES))
    return surface_stress(ANGLES, radial * pressure, around * pressure, along * pressure, none)


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
    left = max(float(np.abs(force).max()), float(np.abs(moment).max()) / shape.total_length)
    return left / largest


def _scales(shape: Pin) -> dict[str, float]:
    seated = shape.seated()
    gaps = [upper[1] - lower[2] for lower, upper in pairwise(seated)]
    widths = [high - low for _, low, high in seated]
    neck = min(_neck(shape, seat) for seat in shape.seats)
    scales = {
        "lug width / diameter": min(widths) / shape.diameter,
        "widest lug / diameter": max(widths) / shape.diameter,
        "gap / diameter": max([*gaps, 0.0]) / shape.diameter,
        "neck / diameter": neck / shape.diameter,
    }
    if neck < shape.diameter:
        scales["fillet / neck"] = shape.step_fillet / neck
    return scales
