"""Levers with a slot, by formula.

A bar with a long slot: two rails joined at both ends only, bent in their plane.
"""

from dataclasses import dataclass
from functools import partial
from math import pi

import numpy as np

from checks.design.data import Part
from checks.handbook.bar_forces import BarLoads
from checks.handbook.lateral_buckling import (
    Acting,
    Chain,
    LateralBar,
    Pressed,
    Stiffness,
    bore_pressure,
    interpolated,
    spaced,
)
from checks.handbook.lug_stress import Lug, bent_plate_hole, curved_bar, stepped_bar, strip_outline
from checks.handbook.pin_loaded_hole import pin_loaded_hole
from checks.models.bands import beside_others
from checks.models.formula_bars import Aside, BarPart, Stretches, add_rectangle_fibres
from checks.models.formula_points import Points, add_bore, along_x, in_section, strip_edges
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads, first_largest
from checks.stress.stress_result import RungModel
from fem.unit_loads import harmonics_of
from geometry.bars import BESIDE, fine_cells, rectangle_torsion
from geometry.mesh import FloatArray
from geometry.parts import SlottedLever

_STATIONS = 25  # along the slot
_FINE = 97  # where the rails' forces are asked for buckling
_INTO = 1 / 4  # of the slot's width: how far into its round ends the rails are clamped in the plane


@dataclass(frozen=True, eq=False)
class RailForces:
    """Forces of the upper and lower rail (y > 0, y < 0) at k places over n positions.

    axial      (2, n)     N, even along the rails but for half of the bar's own
    moment     (2, k, n)  N mm, each rail's own, about its own axis
    spreading  (k, n)     N, slope of the moments by which the contact spreads the rails
    """

    axial: FloatArray
    moment: FloatArray
    spreading: FloatArray


def stress(part: Part, shape: SlottedLever, loads: PartLoads) -> RungModel | None:
    """Two lugs, and between them two rails beside the slot that are clamped at its ends.

    None for a boss without a fillet, where the elastic stress has no bound.
    """
    if shape.boss_diameter is not None and not shape.boss_fillet:
        return None
    mass = _stretches(shape)
    places = {"pivot": 0.0, "tip": shape.length, "slot": 0.0}
    whole = BarPart.of(part, loads, places, mass, shape.length)
    bar, points = whole.forces, whole.points
    room = {"pivot": shape.slot_from, "tip": shape.length - shape.slot_to}
    for name, bosses in (("pivot", 0.0), ("tip", 2 * shape.boss_height)):
        _add_lug(part, points, shape, name, bosses, loads, room[name])
    _add_rails(part, points, shape, loads, bar)
    _add_foot(points, shape, bar)
    return whole.model(
        aside=partial(_aside, part, shape, loads, bar),
        neglects="that the ends of the slot give way; that holes, slot and boss disturb each "
        "other; how wide the contact presses",
    )


def _add_lug(
    part: Part,
    points: Points,
    shape: SlottedLever,
    name: str,
    bosses: float,
    loads: PartLoads,
    room: float,
) -> None:
    """Add a bore as in a strip of the plate's width; the tip's is as thick as plate and bosses."""
    half, depth = shape.width / 2, shape.thickness + bosses
    cut = max(min(BESIDE * shape.width, 2 * room), 0.75 * shape.hole)
    outline = strip_outline(half, shape.overhang, cut)
    nu = part.material.poisson_ratio
    hole = pin_loaded_hole(shape.hole / 2, outline, nu, harmonics_of(loads.arc))
    _, modulus = rectangle_torsion(shape.width, depth)
    tip = name == "tip"
    lug = Lug(hole, depth, mirrored=tip, twist_modulus=float(modulus))
    edges = strip_edges(half, shape.overhang, min(room, cut), 1.0 if tip else -1.0)
    x = shape.length if tip else 0.0
    add_bore(points, part, loads, name, x, lug, (0.0,), edges=edges, tilts=True)


@dataclass(frozen=True)
class _Rail:
    """One of the two rails beside the slot: depth along y and thickness along z, mm."""

    depth: float
    thickness: float
    apart: float

    @property
    def area(self) -> float:
        return self.depth * self.thickness

    @property
    def inertia(self) -> float:
        return self.thickness * self.depth**3 / 12

    @property
    def across(self) -> float:
        return self.depth * self.thickness**3 / 12

    def warping(self, length: float, poisson_ratio: float) -> float:
        """Moment about y at the clamped ends of each rail per N mm of torque on both.

        Both twist by T/(2 G J + 24 E I (apart/2)^2/length^2) per length: as bars, and as clamped
        beams whose ends move aside against each other, E I per length^2 times 6 for the moment.
        """
        one = float(rectangle_torsion(self.depth, self.thickness)[0])
        shear = one / (2 * (1 + poisson_ratio))  # G J over E
        stiff = 2 * shear + 6 * self.across * self.apart**2 / length**2
        return 6 * self.across * self.apart / 2 / length / stiff


def _rails(
    shape: SlottedLever, loads: PartLoads, bar: BarLoads, count: int
) -> tuple[_Rail, FloatArray, RailForces]:
    """A rail, places along it between its clamped ends, mm, and the forces of both there."""
    depth, into = (shape.width - shape.slot_width) / 2, _INTO * shape.slot_width
    rail = _Rail(depth, shape.thickness, shape.width - depth)
    places = np.linspace(shape.slot_from + into, shape.slot_to - into, count)
    wrench = loads.wrenches["slot"]
    reach = loads.reaches.get("slot", np.zeros(len(wrench)))
    moment, pressed = bar.at(places).moment_z, np.abs(wrench[:, 1])
    sizes = {"area": rail.area, "inertia": rail.inertia, "apart": rail.apart}
    return rail, places, rail_forces(places, moment, pressed, reach, **sizes)


def _add_rails(
    part: Part, points: Points, shape: SlottedLever, loads: PartLoads, bar: BarLoads
) -> None:
    """Add the edges of the rails, with the factors of the slot's round ends where they are clamped.

    A rail is clamped half-way into the round end. There its own moment turns round the corner, as
    in a curved bar; axial force finds a shoulder, and bending out of the plane half of a hole.
    """
    rail, places, rails = _rails(shape, loads, bar, _STATIONS)
    depth, length = rail.depth, float(places[-1] - places[0])
    forces = bar.at(places)
    pulled = stepped_bar("tension", shape.width, 2 * depth, shape.slot_width / 2)
    bent = curved_bar(depth, shape.slot_width / 2)
    folded = bent_plate_hole(shape.slot_width, shape.thickness) * 2 * depth / shape.width
    warped = rail.warping(length, part.material.poisson_ratio)
    pairs = [
        points.column(axial, (f"axial force of the {side} rail by its pair", "N"))
        for axial, side in zip(rails.axial, ("upper", "lower"), strict=True)
    ]
    for k, x in enumerate(places):
        first, last = k == 0, k == len(places) - 1
        clamped = first or last
        whole, aside = points.columns(
            np.stack([forces.axial[k], forces.moment_y[k]]),
            in_section(x, "axial force", "moment M_y"),
        )
        warping = points.column(
            forces.torque[k] * (2 * k / (len(places) - 1) - 1), in_section(x, "torque")[0]
        )
        for number, side in enumerate((1.0, -1.0)):
            own = points.column(
                rails.moment[number, k], (f"own moment of a rail at x = {x:.4g} mm", "N mm")
            )
            middle = side * rail.apart / 2
            y = middle + np.array([-1.0, -1.0, 1.0, 1.0]) * depth / 2
            z = np.array([-1.0, 1.0, -1.0, 1.0]) * rail.thickness / 2
            notch = (np.abs(y) < rail.apart / 2) & clamped
            of_axial, of_moment, of_fold = (np.where(notch, f, 1.0) for f in (pulled, bent, folded))
            points.add(
                "slot's end" if clamped else "rail",
                np.column_stack([np.full(4, x), y, z]),
                {
                    whole: along_x(of_axial / (2 * rail.area)),
                    pairs[number]: along_x(of_axial / rail.area),
                    own: along_x(-of_moment * (y - middle) / rail.inertia),
                    aside: along_x(of_fold * z / (2 * rail.across)),
                    warping: along_x(side * of_fold * warped * z / rail.across),
                },
            )


def _add_foot(points: Points, shape: SlottedLever, bar: BarLoads) -> None:
    """Add the plate before the boss, with the fillet's factor on what bends it out of its plane."""
    if shape.boss_diameter is None:
        return
    foot = shape.length - shape.boss_diameter / 2 - shape.boss_fillet
    places = np.array([foot])
    size = (shape.width, shape.thickness)
    _, modulus = rectangle_torsion(*size)
    add_rectangle_fibres(points, "plate", places, bar.at(places), size, float(modulus))
    forces = bar.at(places)
    wide = shape.thickness + 2 * shape.boss_height
    pulled, bent = (
        stepped_bar(kind, wide, shape.thickness, shape.boss_fillet)
        for kind in ("tension", "bending")
    )
    axial, aside = points.columns(
        np.stack([forces.axial[0], forces.moment_y[0]]),
        in_section(foot, "axial force", "moment M_y"),
    )
    z = np.array([-1.0, 1.0]) * shape.thickness / 2
    points.add(
        "boss fillet",
        np.column_stack([np.full(2, foot), np.zeros(2), z]),
        {
            axial: along_x(np.full(2, pulled / (shape.width * shape.thickness))),
            aside: along_x(bent * z * 12 / (shape.width * shape.thickness**3)),
        },
    )


def _aside(part: Part, shape: SlottedLever, loads: PartLoads, bar: BarLoads, pulled: bool) -> Aside:
    """Buckling of the lever out of its plane, or of a rail in it.

    Two plates that hold a pin each, and between them two rails that are bent aside and twist each
    by itself, under their own moments in the plane. A plate's end twists with its sections warped,
    as a rail's slope and its pair's differ; how stiffly they hold the rails decides a quarter of
    the load. The rails are as deep as the slot's round ends leave them. In the plane a rail that is
    pressed is a column with clamped ends, as long as the slot.

    pulled  True if what pulls the whole lever counts as nothing
    """
    start, stop = shape.slot_from, shape.slot_to
    beyond = shape.width / 2 if shape.overhang is None else shape.overhang
    ends = (np.linspace(0.0, start, 4), np.linspace(stop, shape.length, 4))
    round_end = shape.slot_width * np.array([0.15, 0.5])
    along = np.linspace(start, stop, 9)
    nodes = spaced(np.r_[along, start + round_end, stop - round_end])
    rail, places, rails = _rails(shape, loads, bar, _FINE)
    plate, flat = partial(_plate_stiffness, part, shape), partial(_rail_stiffness, part, shape)
    chains = [
        Chain(np.r_[-beyond, ends[0]], plate),
        Chain(np.r_[ends[1], shape.length + beyond], plate),
        Chain(nodes, flat, rail.apart / 2),
        Chain(nodes, flat, -rail.apart / 2),
    ]
    acting = []
    for k, chain in enumerate(chains):
        forces = bar.at(chain.points)
        axial = np.minimum(forces.axial, 0.0) if pulled else forces.axial
        if k < 2:
            acting.append(Acting(axial, forces.moment_z, forces.shear))
            continue
        side = 1.0 if k == 2 else -1.0
        slope = interpolated(places, rails.spreading, chain.points)
        acting.append(
            Acting(
                axial / 2 + rails.axial[k - 2],
                interpolated(places, rails.moment[k - 2], chain.points),
                forces.shear / 2 - side * slope,
            )
        )
    radius = 0.0 if pulled else shape.hole / 2
    pressed = [
        Pressed(k, at, bore_pressure(radius, acts))
        for k, at, acts in (
            (0, 0.0, loads.wrenches["pivot"]),
            (1, shape.length, loads.wrenches["tip"]),
        )
    ]
    pins = [(0, 0.0), (1, shape.length)]
    whole = LateralBar(
        chains,
        held=pins[::-1] if loads.tilt_held_at == "tip" else pins,
        joined=[(k, at, branch) for k, at in ((0, start), (1, stop)) for branch in (2, 3)],
    )
    share, position, held = whole.worst_of_forks(acting, pressed)
    young = part.material.youngs_modulus
    middle = bar.at(np.array([(start + stop) / 2])).axial[0] / 2
    axial = middle + rails.axial
    push = -axial.min(axis=0)
    column = push * (stop - start) ** 2 / (4 * np.pi**2 * young * rail.inertia)
    (worst,) = first_largest(column)
    if column[worst] > share:
        own, upper = float(column[worst]), bool(axial[0, worst] < axial[1, worst])
        mode = partial(_rail_mode, shape, upper)
        return Aside(own, worst, own, mode, "in plane: a rail, clamped at the slot's ends")

    def bent(nodes: FloatArray) -> FloatArray:
        x, y, _ = nodes.T
        chain = np.where(x < start, 0, np.where(x > stop, 1, np.where(y > 0.0, 2, 3)))
        found = whole.mode(
            [one.at(position) for one in acting], [one.at(position) for one in pressed]
        )
        moved = np.zeros_like(nodes)
        for k in range(len(chains)):
            moved[chain == k] = found.moved(k, nodes[chain == k])
        return moved

    return Aside(share, position, held, bent)


def _rail_mode(shape: SlottedLever, upper: bool, nodes: FloatArray) -> FloatArray:
    """A rail in the plane as a column, clamped at the slot's ends: (1 - cos(2 pi x/l))/2."""
    x, y, _ = nodes.T
    length, apart = shape.slot_to - shape.slot_from, (shape.width + shape.slot_width) / 2
    side = 1.0 if upper else -1.0
    angle = 2 * pi * np.clip((x - shape.slot_from) / length, 0.0, 1.0)
    angle = np.where(side * y > 0.0, angle, 0.0)
    slope = pi / length * np.sin(angle)
    across = y - side * apart / 2
    return np.stack([-across * slope, (1 - np.cos(angle)) / 2, np.zeros_like(x)], axis=1)


def _plate_stiffness(part: Part, shape: SlottedLever, x: FloatArray) -> Stiffness:
    """Stiffness of the plate beyond the slot at places (k,), with its boss."""
    boss = 0.0 if shape.boss_diameter is None else shape.boss_diameter / 2
    on_boss = np.abs(x - shape.length) < boss
    thick = np.where(on_boss, shape.thickness + 2 * shape.boss_height, shape.thickness)
    return _flat_stiffness(part, np.full_like(x, shape.width), thick, 1.0)


def _rail_stiffness(part: Part, shape: SlottedLever, x: FloatArray) -> Stiffness:
    """Stiffness of one rail at places (k,): deeper beside the slot's round ends."""
    radius = shape.slot_width / 2
    into = np.clip(np.minimum(x - shape.slot_from, shape.slot_to - x), 0.0, radius)
    deep = shape.width / 2 - np.sqrt(radius**2 - (radius - into) ** 2)
    return _flat_stiffness(part, deep, np.full_like(x, shape.thickness), 0.0)


def _flat_stiffness(part: Part, wide: FloatArray, thick: FloatArray, warps: float) -> Stiffness:
    """Stiffness of rectangular sections (k,), with so much of a plate's warping."""
    young, twists = part.material.youngs_modulus, 2 * (1 + part.material.poisson_ratio)
    return Stiffness(
        young * wide * thick**3 / 12,
        young / twists * rectangle_torsion(wide, thick)[0],
        warps * young * (wide * thick) ** 3 / 144,
        (wide**2 + thick**2) / 12,
    )


def _stretches(shape: SlottedLever) -> Stretches:
    half = shape.width / 2
    beyond = half if shape.overhang is None else shape.overhang
    ends = [-beyond, 0.0, shape.slot_from, shape.slot_to, shape.length, shape.length + beyond]
    cuts = fine_cells(np.array(ends), 128)
    x = (cuts[1:] + cuts[:-1]) / 2
    height = np.full(len(x), shape.width)
    if shape.overhang is None:
        past = np.maximum(np.maximum(-x, x - shape.length), 0.0)
        height = 2 * np.sqrt(half**2 - past**2)
    in_slot = (x > shape.slot_from) & (x < shape.slot_to)
    into = np.minimum(x - shape.slot_from, shape.slot_to - x)
    deep = shape.slot_width / 2
    opened = np.sqrt(np.maximum(deep**2 - np.maximum(deep - into, 0.0) ** 2, 0.0))
    slot = np.where(in_slot, 2 * opened, 0.0)
    area = (height - slot) * shape.thickness
    bosses = 0.0 if shape.boss_diameter is None else shape.boss_diameter
    from_tip = x - shape.length
    area += 2 * shape.boss_height * _chord(bosses, from_tip)
    area -= shape.thickness * _chord(shape.hole, x)
    area -= (shape.thickness + 2 * shape.boss_height) * _chord(shape.hole, from_tip)
    rail = (shape.width - shape.slot_width) / 2
    one = float(rectangle_torsion(rail, shape.thickness)[0])
    whole = float(rectangle_torsion(shape.width, shape.thickness)[0])
    return Stretches(
        cuts,
        area,
        shape.thickness * (shape.width**3 - slot**3) / 12,
        (shape.width - slot) * shape.thickness**3 / 12,
        np.where(slot > 0, 2 * one, whole),
    )


def _chord(diameter: float, x: FloatArray) -> FloatArray:
    return np.asarray(2 * np.sqrt(np.maximum(diameter**2 / 4 - x**2, 0.0)))


MODEL = ShapeModel(
    SlottedLever, stress, family=beside_others, tilts=True, press_fits=True, arcs=True
)


def rail_forces(
    places: FloatArray,
    moment: FloatArray,
    pressed: FloatArray,
    reach: FloatArray,
    *,
    area: float,
    inertia: float,
    apart: float,
) -> RailForces:
    """Forces of two equal rails that nothing joins between their clamped ends.

    places   (k,) mm, even, from the rails' first clamped end to their second
    moment   (k, n) N mm about z, of the whole bar
    pressed  (n,) N, size of a force that presses one rail away from the other
    reach    (n,) mm, where; outside the rails it presses none
    area     mm2 and `inertia` mm4 of one rail, `apart` mm between their middles

    The rails push and pull by P, the same all along as they are joined at the ends only, and each
    bends by (M - P apart)/2. Their ends turn alike by bending, integral of (M - P apart)/(2 E I),
    and by lengthening, 2 P L/(E A apart): so P apart = mean(M) A apart^2/2 / (2 I + A apart^2/2).
    Half of the contact's force bends both rails alike, which is in M. The other half spreads them:
    both are clamped bars under a point load Q at a, L = a + b, with Q a b^2/L^2 at the first end,
    Q a^2 b/L^2 at the second and -2 Q a^2 b^2/L^3 at the load (Young and Budynas, Roark's Formulas
    for Stress and Strain, 7th ed., table 8.1, 1d).
    """
    start, length = places[0], places[-1] - places[0]
    steiner = area * apart**2 / 2
    weights = np.full(len(places), 1.0)
    weights[[0, -1]] = 0.5
    mean = weights @ moment / weights.sum()
    couple = mean / apart * steiner / (2 * inertia + steiner)
    own = (moment - couple * apart) / 2
    a = np.clip(reach - start, 0.0, length)
    b = length - a
    force = pressed / 2
    first, second = force * a * b**2 / length**2, force * a**2 * b / length**2
    x = (places - start)[:, None]
    straight = first + (second - first) * x / length
    triangle = np.minimum(x * b, (length - x) * a) / length  # of a hinged bar under 1 N
    spread = straight - force * triangle
    slope = (second - first - force * np.where(x < a, b, -a)) / length
    moments = np.stack([own + spread, own - spread])
    return RailForces(np.stack([-couple, couple]), moments, slope)
