"""Volume, centre and second moment of the plain parametric parts in closed form: no CAD kernel.

For those who ask thousands of bodies and draw none of them. Pieces that are bounded by arcs are
integrated over the arc's coordinate, exact to round-off; the rest is sums of boxes and discs.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from geometry.cad_body import SolidBody
from geometry.mesh import FloatArray
from geometry.parts import (
    Beam,
    LeafPack,
    Pin,
    PlateLink,
    PrismaticTube,
    SlottedLever,
    ToggleBar,
    TubeRod,
)
from geometry.parts.plate import Plate

_GAUSS_POINTS = 24  # per piece; the pieces are smooth in the roots of the distances to their ends

ClosedShape = ToggleBar | PrismaticTube | Pin | PlateLink | LeafPack | SlottedLever | TubeRod | Beam


def closed_body(shape: object) -> SolidBody | None:
    """Return a shape's mass and interfaces by formula; None for one that needs the CAD kernel."""
    match shape:
        case ToggleBar():
            return _toggle_bar(shape)
        case PrismaticTube():
            return _prismatic_tube(shape)
        case Pin():
            return _pin(shape)
        case PlateLink():
            return _plate_link(shape)
        case LeafPack():
            return _leaf_pack(shape)
        case Plate():
            return _plate(shape)
        case SlottedLever():
            return _slotted_lever(shape)
        case TubeRod():
            return _tube_rod(shape)
        case Beam():
            return _beam(shape)
        case _:
            return None


@dataclass(frozen=True)
class _Moments:
    """Integrals over a solid that is its own mirror image about y = 0 and z = 0.

    volume  mm3
    first   mm4, of x
    second  mm5, of x^2 + y^2
    """

    volume: float
    first: float
    second: float

    def __add__(self, other: "_Moments") -> "_Moments":
        return _Moments(
            self.volume + other.volume, self.first + other.first, self.second + other.second
        )

    def __sub__(self, other: "_Moments") -> "_Moments":
        return self + _Moments(-other.volume, -other.first, -other.second)

    def mirrored(self, length: float) -> "_Moments":
        """The solid turned end for end: x becomes length - x."""
        about = length**2 * self.volume - 2 * length * self.first + self.second
        return _Moments(self.volume, length * self.volume - self.first, about)

    def body(self, shape: ClosedShape, extent: float) -> SolidBody:
        """The body with its second moment about its own centre."""
        x = self.first / self.volume
        second = self.second - self.volume * x**2
        interfaces = {interface.name: interface for interface in shape.placed_interfaces}
        return SolidBody(interfaces, self.volume, np.array([x, 0.0, 0.0]), second, extent)


_NOTHING = _Moments(0.0, 0.0, 0.0)


def _box(start: float, stop: float, width: float, thickness: float) -> _Moments:
    """A box along x, `width` along y."""
    volume = (stop - start) * width * thickness
    first = (stop**2 - start**2) / 2 * width * thickness
    along = (stop**3 - start**3) / 3 * width * thickness
    return _Moments(volume, first, along + volume * width**2 / 12)


def _disc(x: float, radius: float, thickness: float) -> _Moments:
    """A round disc about z at (x, 0)."""
    volume = pi * radius**2 * thickness
    return _Moments(volume, volume * x, volume * (x**2 + radius**2 / 2))


def _half_disc(x: float, radius: float, thickness: float, outward: float) -> _Moments:
    """Half of a round disc, cut at x, on the side `outward` (1 or -1) along x."""
    volume = pi * radius**2 * thickness / 2
    first = volume * (x + outward * 4 * radius / (3 * pi))
    # x^2 = (x - x0)^2 + 2 x0 x - x0^2, about the cut (x - x0)^2 + y^2 is that of half a disc
    return _Moments(volume, first, volume * radius**2 / 2 + 2 * x * first - volume * x**2)


def _stadium(start: float, stop: float, width: float, thickness: float) -> _Moments:
    """A plate from start to stop along x whose ends are half round."""
    half = width / 2
    first, last = start + half, stop - half
    ends = _half_disc(first, half, thickness, -1.0) + _half_disc(last, half, thickness, 1.0)
    return _box(first, last, width, thickness) + ends


def _plate_link(shape: PlateLink) -> SolidBody:
    thick, half = shape.thickness, shape.width / 2
    solid = _stadium(-half, shape.length + half, shape.width, thick)
    for interface in shape.placed_interfaces:
        solid -= _disc(float(interface.centre[0]), interface.radius, thick)
    return solid.body(shape, max(shape.length + shape.width, thick))


def _plate(shape: Plate) -> SolidBody:
    found, thick = shape.outline.moments, shape.thickness
    interfaces = {interface.name: interface for interface in shape.placed_interfaces}
    centre = np.array([found.centre.real, found.centre.imag, 0.0])
    extent = max(shape.outline.size, thick)
    return SolidBody(interfaces, found.area * thick, centre, found.polar * thick, extent)


def _slotted_lever(shape: SlottedLever) -> SolidBody | None:
    """None where the slot's round end cuts into the boss."""
    outline = _stadium if shape.overhang is None else _box
    solid = outline(-shape.beyond, shape.length + shape.beyond, shape.width, shape.thickness)
    solid -= _stadium(shape.slot_from, shape.slot_to, shape.slot_width, shape.thickness)
    if shape.boss_diameter is not None:
        radius, fillet = shape.boss_diameter / 2, shape.boss_fillet
        if shape.slot_to > shape.length - radius - fillet:
            return None
        solid += _disc(shape.length, radius, 2 * shape.boss_height)
        solid += _foot(shape.length, radius, fillet) if fillet else _NOTHING
    for interface in shape.placed_interfaces:
        if interface.kind == "bore":
            solid -= _disc(float(interface.centre[0]), interface.radius, interface.length)
    deep = shape.thickness + 2 * shape.boss_height
    return solid.body(shape, max(shape.length + 2 * shape.beyond, shape.width, deep))


def _tube_rod(shape: TubeRod) -> SolidBody:
    """A solid of revolution whose balls are cut flat, less the tube's bore and the holes.

    Of a disc of radius R cut at |z| = h, with w^2 = R^2 - h^2 and the area A = 2 (h w + R^2
    asin(h/R)), the integral of y^2 is h w^3/3 + R^2 A/4.
    """
    eye, flat = shape.eye_diameter / 2, shape.eye_width / 2
    centre = shape.tube_diameter / 2 + shape.fillet  # of the fillet's arc, from the axis
    cut = [  # where flats end, in the ball and, if they reach it, in the fillet
        sqrt(max(eye**2 - flat**2, 0.0)),
        shape.shank_end - sqrt(max(shape.fillet**2 - max(centre - flat, 0.0) ** 2, 0.0)),
    ]
    middle = shape.length / 2
    inner = [eye, eye + shape.bore / 2] if shape.bore else []
    marks = {-eye, -cut[0], *cut, shape.joint, shape.shank_end, *inner, middle}
    x, weight = _gauss(sorted(marks))
    radius, bore = shape.outer_radius(x), shape.inner_radius(x)
    high = np.minimum(radius, flat)
    wide = np.sqrt(radius**2 - high**2)
    area = 2 * (high * wide + radius**2 * np.arcsin(high / radius))
    across = high * wide**3 / 3 + radius**2 * area / 4 - pi * bore**4 / 4
    area -= pi * bore**2
    one = _Moments(
        float(weight @ area),
        float(weight @ (area * x)),
        float(weight @ (area * x**2 + across)),
    )
    one -= _disc(0.0, shape.hole / 2, shape.eye_width)
    solid = one + one.mirrored(shape.length)
    return solid.body(shape, shape.length + shape.eye_diameter)


def _beam(shape: Beam) -> SolidBody:
    """The profile, and of each hole what the boss adds beside the webs and the hole takes away."""
    one = shape.form.section
    start, stop = -shape.overhang, shape.length + shape.overhang
    volume, first = one.area * (stop - start), one.area * (stop**2 - start**2) / 2
    along = one.area * (stop**3 - start**3) / 3
    solid = _Moments(volume, first, along + one.inertia_in_plane * (stop - start))
    for hole in shape.holes:
        solid += _disc(hole.at, hole.boss / 2, shape.gaps)
        solid += _foot(hole.at, hole.boss / 2, shape.fillet) if shape.fillet else _NOTHING
        solid -= _disc(hole.at, hole.diameter / 2, shape.boss_length)
    return solid.body(shape, max(stop - start, shape.height, shape.width, shape.boss_length))


def _foot(x: float, radius: float, fillet: float) -> _Moments:
    """The fillets all round both ends of a boss at (x, 0)."""
    out, weight = _gauss([0.0, fillet])
    high = fillet - _circle(fillet, out)
    ring = 4 * pi * (radius + out) * high * weight  # of both
    volume = float(ring.sum())
    return _Moments(volume, volume * x, volume * x**2 + float(ring @ (radius + out) ** 2))


def _leaf_pack(shape: LeafPack) -> SolidBody:
    high = shape.leaves * shape.thickness
    stop = shape.length + shape.overhang
    solid = _box(-shape.arm, stop, high, shape.width)
    return solid.body(shape, max(shape.arm + stop, high, shape.width))


def _prismatic_tube(shape: PrismaticTube) -> SolidBody:
    cheek = _box(0.0, shape.length, shape.width, 2 * shape.wall)
    solid = cheek + _side_walls(shape, np.zeros_like, shape.length, ())
    return solid.body(shape, max(shape.length, shape.width))


def _toggle_bar(shape: ToggleBar) -> SolidBody:
    stop = shape.length + shape.overhang
    corner, cut = shape.cutout_corner, shape.cutout_length - shape.overhang

    def start(depth: FloatArray) -> FloatArray:
        """Where the side walls begin, by the distance from the cheek."""
        return cut - corner + _circle(corner, depth)

    solid = _box(-shape.overhang, stop, shape.width, 2 * shape.wall)
    solid += _side_walls(shape, start, stop, (corner,))
    for interface in shape.placed_interfaces:
        solid -= _disc(float(interface.centre[0]), interface.radius, 2 * shape.wall)
    return solid.body(shape, max(stop + shape.overhang, shape.width))


def _circle(radius: float, depth: FloatArray) -> FloatArray:
    """Distance of an arc from its tangent's corner, at a depth beside it: 0 to the radius."""
    beside = np.clip(radius - depth, 0.0, radius)
    return np.asarray(np.sqrt(radius**2 - beside**2))


def _side_walls(
    shape: ToggleBar | PrismaticTube,
    start: Callable[[FloatArray], FloatArray],
    stop: float,
    corners: tuple[float, ...],
) -> _Moments:
    """Moments of a square tube's side walls, from start(distance from the cheek) to `stop`.

    The inner corners' fillets are a part of the side walls. corners: distances from the cheek, mm,
    at which `start` is not smooth.
    """
    half, radius = shape.width / 2, shape.inner_radius
    inside = half - shape.wall
    cuts = sorted({0.0, inside, *(c for c in (radius, *corners) if 0 < c < inside)})
    depth, weight = _gauss(cuts)
    inner = inside - (radius - _circle(radius, depth))  # of the wall, at y > 0
    first, last = start(depth), stop
    across, across_3 = 2 * (half - inner), 2 * (half**3 - inner**3) / 3
    weight = 2 * weight  # both cheeks
    return _Moments(
        float(weight @ ((last - first) * across)),
        float(weight @ ((last**2 - first**2) / 2 * across)),
        float(weight @ ((last**3 - first**3) / 3 * across + (last - first) * across_3)),
    )


def _gauss(cuts: list[float]) -> tuple[FloatArray, FloatArray]:
    """Places and weights of Gauss' rule between the cuts, in t of a + (b - a) sin^2(t)."""
    point, own = np.polynomial.legendre.leggauss(_GAUSS_POINTS)
    start, size = np.array(cuts[:-1])[:, None], np.diff(cuts)[:, None]
    angle = np.pi / 4 * (point + 1)
    weight = size * np.pi / 4 * own * np.sin(2 * angle)
    return (start + size * np.sin(angle) ** 2).ravel(), weight.ravel()


def _pin(shape: Pin) -> SolidBody:
    """A solid of revolution about z: cylinders, and necks with their fillets."""
    whole, fillet = shape.diameter / 2, shape.step_fillet
    low, high = shape.ends
    total = _cylinder(whole, low, high)
    for seat, lower, upper in shape.seated():
        neck = (seat.diameter or shape.diameter) / 2
        if neck < whole:
            total += _cylinder(neck, lower, upper) - _cylinder(whole, lower, upper)
            for edge, way in ((lower, -1.0), (upper, 1.0)):
                ends = sorted((edge, edge + way * fillet))
                total += _fillet(neck, fillet, edge, way) - _cylinder(whole, *ends)
    volume, first, second = total
    interfaces = {interface.name: interface for interface in shape.placed_interfaces}
    centre = np.array([0.0, 0.0, first / volume])
    return SolidBody(interfaces, volume, centre, second, max(high - low, shape.diameter))


def _cylinder(radius: float, low: float, high: float) -> FloatArray:
    """Volume, first moment of z and second moment about z of a cylinder along z."""
    area = pi * radius**2
    return np.array(
        [area * (high - low), area * (high**2 - low**2) / 2, area * radius**2 / 2 * (high - low)]
    )


def _fillet(neck: float, fillet: float, edge: float, way: float) -> FloatArray:
    """As `_cylinder`, of what a neck has beside its lug: radius a - q, q^2 = fillet^2 - (z-edge)^2.

    way  1 or -1, from the lug's edge along z
    """
    a, f = neck + fillet, fillet
    q1, q2, q3, q4 = pi * f**2 / 4, 2 * f**3 / 3, 3 * pi * f**4 / 16, 8 * f**5 / 15
    square = a**2 * f - 2 * a * q1 + q2
    beside = a**2 * f**2 / 2 - 2 * a * f**3 / 3 + f**4 / 4  # of the square times |z - edge|
    fourth = a**4 * f - 4 * a**3 * q1 + 6 * a**2 * q2 - 4 * a * q3 + q4
    return pi * np.array([square, edge * square + way * beside, fourth / 2])
