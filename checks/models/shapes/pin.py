"""Pins by formula.

Lugs press along a pin, around it and below their edges. Stress on its surface is of bending, shear
and twist, and of that pressure.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import pi

import numpy as np

from checks.design.data import Part
from checks.handbook.lug_stress import stepped_shaft
from checks.handbook.pin_diagrams import PinDiagram, pin_diagram
from checks.handbook.pin_loaded_hole import PATTERNS
from checks.models.formula_points import YZ, ZX, Points, interface_units
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import RungModel
from fem.unit_loads import bearing_coefficients
from geometry.mesh import FloatArray
from geometry.parts import Pin, Seat

_AT_EDGE = 1e-11  # of the radius: sums of lengths stray by that much from an edge that they mean

ANGLES = np.radians(np.arange(0.0, 360.0, 15.0))
_SLICES = 8  # of a pressure that grows along a lug
_WAVES = np.stack(
    [
        np.ones_like(ANGLES),
        *(wave(n * ANGLES) for n in (1, 2, 4) for wave in (np.cos, np.sin)),
        np.zeros_like(ANGLES),  # the friction couple presses nothing
    ]
)
_X, _Y = 1, 2  # the waves cos and sin
_ROWS = (0, 1, 3, 4, 5)  # of a wrench: F_x, F_y, M_x, M_y, M_z
# F_x, F_y and M_z have columns among those of the pressure: a lug presses against its force
_PUSHING = (PATTERNS.index("cos 1"), PATTERNS.index("sin 1"))
_SIGNS = (-1.0, -1.0, 1.0, 1.0, 1.0)
_PRESSED = 1.75  # mean pressure over a neck's bending stress, up to which the neck decides
_BESIDE = 1e-6  # of the way to the middle of a stretch


def section_stress(
    angles: FloatArray,
    diameter: float,
    shear: FloatArray,
    moment: FloatArray,
    torque: FloatArray,
    poisson_ratio: float,
) -> tuple[FloatArray, FloatArray]:
    """Stress along z, and shear of the sections (normal +z) around the pin, (k, c), MPa.

    At angles (k,) for c cases: shear (c, 2) and torque (c,) are sums over the loads below the
    section, moment (c, 2) the sum of forces times their distance below it, as in a pin's diagram.
    The upper part answers with the opposite: sigma = -M cos(..) 32/(pi d^3), and at the rim
    of a round bar (1 + 2 nu)/(1 + nu) V/A (Timoshenko and Goodier, Theory of Elasticity, 3rd ed.,
    article 122), around it where it is square to V, and 16 T/(pi d^3).
    """
    outward = np.stack([np.cos(angles), np.sin(angles)])
    around = np.stack([-np.sin(angles), np.cos(angles)])
    area = pi * diameter**2 / 4
    along = -(moment @ outward).T * 32 / (pi * diameter**3)
    rim = (1 + 2 * poisson_ratio) / (1 + poisson_ratio) / area
    sheared = -(shear @ around).T * rim - torque * 16 / (pi * diameter**3)
    return along, sheared


def surface_stress(
    angles: FloatArray,
    radial: FloatArray,
    around: FloatArray,
    along: FloatArray,
    sheared: FloatArray,
) -> FloatArray:
    """Stress (k, 6) xx, yy, zz, xy, yz, zx of tractions at angles (k,) of a pin's surface.

    For m cases at once, tractions are (k, m) and the stress is (k, 6, m).
    """
    c, s = np.cos(angles), np.sin(angles)
    if radial.ndim > 1:
        c, s = c[:, None], s[:, None]
    stress = np.zeros((len(angles), 6, *radial.shape[1:]))
    stress[:, 0] = radial * c**2 + around * s**2
    stress[:, 1] = radial * s**2 + around * c**2
    stress[:, 2] = along
    stress[:, 3] = (radial - around) * s * c
    stress[:, 4] = c * sheared
    stress[:, 5] = -s * sheared
    return stress


def under_band(
    places: FloatArray, low: FloatArray, high: FloatArray, radius: float, poisson_ratio: float
) -> FloatArray:
    """Stress (3, s, k) along, around and along the radius at z = `places` (s,) per pressure.

    It presses bands from z = `low` to `high` (k,), mm, of a long solid cylinder. The middle of a
    long band is pressed as a disc (`cylinder_stress`): -1 around and along the radius, nothing
    along z. Under a short one the surface behaves as a half-space's does: -1 along z, too, and
    -2 nu around. Between, and beside it, the stress comes from the Fourier integral of the even
    pressure around (Rankin, J. Appl. Mech. 11 (1944) A-77; Timoshenko and Goodier, Theory of
    Elasticity, 3rd ed., article 143), taken for every harmonic. At a band's edge half of it
    presses.
    """
    distance, table = _steps(poisson_ratio)
    found = np.zeros((3, len(places), len(low)))
    for sign, edge in ((-1.0, low), (1.0, high)):
        away = (places[:, None] - edge) / radius
        away[np.abs(away) < _AT_EDGE] = 0.0
        for row in (0, 1):
            found[row] += sign * np.sign(away) * np.interp(np.abs(away), distance, table[row])
        found[2] += sign * 0.5 * np.sign(away)
    return found


@lru_cache(maxsize=8)
def _steps(poisson_ratio: float) -> tuple[FloatArray, FloatArray]:
    """Half the stress along and around (2, m) that a step of the pressure makes at distances (m,).

    Love's function (A I0(k r) + B k r I1(k r)) sin(k z) has, over cos(k z) and with x = k r,

        tau_rz = 0:  A = -B (2 (1 - nu) + x I0/I1)
        sigma_z = (4 - 2 nu) B I0 + A I0 + B x I1
        sigma_t = 2 nu B I0 - A I1/x - B I0
        sigma_r = 2 nu B I0 - A (I0 - I1/x) - B (I0 + x I1)

    and a step is the integral of sin(k z)/(pi k) of it. The remainder of the ratios at large x
    falls as 1/x; it is integrated up to x = 150. Their limits 1 and 2 nu are half of a step.
    """
    x = (np.arange(7500) + 0.5) * 0.02
    # I_n(x) exp(-x), the mean of exp(x (cos t - 1)) cos(n t) over half a turn: exact by midpoints
    along_turn = np.cos((np.arange(100) + 0.5) * np.pi / 100)
    falling = np.exp(np.outer(x, along_turn - 1))
    zero, one = falling.mean(axis=1), (falling * along_turn).mean(axis=1)
    a = -(2 * (1 - poisson_ratio) + x * zero / one)
    radial = 2 * poisson_ratio * zero - a * (zero - one / x) - (zero + x * one)
    along = ((4 - 2 * poisson_ratio) * zero + a * zero + x * one) / radial
    around = (2 * poisson_ratio * zero - a * one / x - zero) / radial
    distance = np.concatenate([np.linspace(0.0, 3.0, 61), np.linspace(3.1, 8.0, 50)])
    waves = np.sin(np.outer(distance, x)) / (np.pi * x) * 0.02
    table = [
        end / 2 + waves @ (ratio - end)
        for ratio, end in ((along, 1.0), (around, 2 * poisson_ratio))
    ]
    return distance, np.array(table)


def _pressed() -> FloatArray:
    """Stress (3, k, 6, waves) of each wave along the pin, around it and along the radius."""
    none = np.zeros_like(_WAVES.T)
    return np.array(
        [
            surface_stress(ANGLES, none, none, _WAVES.T, none),
            surface_stress(ANGLES, none, _WAVES.T, none, none),
            surface_stress(ANGLES, _WAVES.T, none, none, none),
        ]
    )


def _sheared() -> FloatArray:
    """Stress (k, 6, waves) of each wave as a shear between the radius and z."""
    found = np.zeros((len(ANGLES), 6, len(_WAVES)))
    found[:, YZ], found[:, ZX] = (np.sin(ANGLES) * _WAVES).T, (np.cos(ANGLES) * _WAVES).T
    return found


_PRESSED_WAVES, _SHEARED = _pressed(), _sheared()


@dataclass(frozen=True)
class PinSection:
    """A section of the pin.

    index   in the diagram
    seat    whose lug is there, if any; `middle` of that lug, mm
    side    mm, where its surface stress is taken: off the place by next to nothing, as a lug's
            pressure ends in a step, and so does the stress; or at the place
    edge    1 or -1 just below the surface at a lug's upper or lower edge, else 0
    """

    index: int
    seat: Seat | None
    middle: float
    side: float
    edge: int = 0

    @property
    def name(self) -> str:
        """Where it is, in words."""
        return "pin" if self.seat is None else f"{self.seat.name} on the pin"


def pressure_shares(
    shape: Pin, seat: Seat, sides: FloatArray, poisson_ratio: float
) -> tuple[FloatArray, FloatArray]:
    """Stress (3, s) at places (s,) along the pin of a seat's pressure per waves around, 1/mm2.

    Of the half cosine's waves, and of the waves x and y of a couple: 1/mm3.
    """
    radius = shape.neck(seat) / 2
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


def add_pressure(
    stress: FloatArray, even: FloatArray, grown: FloatArray, pressing: list[int], forces: list[int]
) -> None:
    """Add a lug's pressure: the half cosine, and of a couple one that grows along the pin.

    stress      (s, k, 6, columns) at the sections, which is added to
    even, grown (3, s) as `pressure_shares` has them
    """
    stress[..., pressing] += np.tensordot(even.T, _PRESSED_WAVES, axes=1)
    # f_x = z M_y/J pushes along +x where the pressure is -cos, f_y = -z M_x/J
    couples = np.tensordot(grown.T, _PRESSED_WAVES[..., [_Y, _X]], axes=1)
    stress[..., forces[2]] += couples[..., 0]
    stress[..., forces[3]] -= couples[..., 1]


def add_edge(
    stress: FloatArray, shape: Pin, section: PinSection, pressing: list[int], forces: list[int]
) -> None:
    """Add the shear just below an edge of a lug's pressure p, p/pi straight beneath it.

    A half-space's under a pressure that ends in a step (Johnson, Contact Mechanics, 1985, 2.5), to
    the stress (k, 6, columns) at one section.
    """
    seat = section.seat
    assert seat is not None
    radius, count = shape.neck(seat) / 2, len(seat.places)
    centre = 0.0 if seat.paired else seat.at
    arm = section.middle + section.edge * seat.width / 2 - centre
    second = sum(seat.width**3 / 12 + seat.width * (z - centre) ** 2 for z in seat.places)
    unit = section.edge / (np.pi**2 * radius)
    stress[..., pressing] += unit / (seat.width * count) * _SHEARED
    stress[..., forces[2]] += unit * arm / second * _SHEARED[..., _Y]
    stress[..., forces[3]] -= unit * arm / second * _SHEARED[..., _X]


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
            interface_units(name, PATTERNS),
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
    shape: Pin, diagram: PinDiagram, section: PinSection, poisson_ratio: float
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
