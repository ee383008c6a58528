"""Beams of a profile with pins in bosses, by formula.

They have any number of pins in a row, and buckle elastically. In the plane a beam is Euler's column
from its first pin to its last one, under the largest compression anywhere: pins between them hold
nothing. Or it is hinged at the two pins that hold the solid and free beyond them, where that is
more. Out of it a bar that is bent aside and twisted (checks/handbook/lateral_buckling.py), held by
the same pins; bosses stiffen nothing.

No solids tell how far a solid's share is from that. It is bounded as one of any sections is, by
multiples of the bar's share and by its most slender wall as a long plate under the largest stress
of the part.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from checks.design.data import Part
from checks.handbook.bar_forces import BarLoads
from checks.handbook.boss_in_plate import BossInPlate, boss_in_plate
from checks.handbook.column_curves import column_force
from checks.handbook.lateral_buckling import (
    Acting,
    Chain,
    LateralBar,
    Pressed,
    Stiffness,
    bore_pressure,
    spaced,
)
from checks.handbook.lug_stress import stepped_bar
from checks.models.bar_modes import bent_aside, half_wave, moved_with
from checks.models.formula_bars import (
    ASIDE,
    HARDLY,
    LATERAL,
    BarPart,
    SectionForces,
    Stretches,
    as_plate,
    column_items,
    factor_items,
    of_walls,
)
from checks.models.formula_points import ANGLES, XX, XY, YY, Points, bore_columns
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads, first_largest
from checks.stress.stress_result import ElasticLoad, RungModel
from fem.mode_count import nearness
from fem.unit_loads import harmonics_of
from geometry.bars import fine_cells
from geometry.mesh import FloatArray
from geometry.parts import Beam, IBeam, PinHole, RhsBeam

_PLANE = [XX, YY, XY]
_STATIONS = 9  # between two pins
LONG, _FROM = ", long", 4.0  # a family of solids: times the height, of both stretches
_BESIDE = 1e-9  # of the length: on one side of a pin
_ALONG = 33  # from the first pin to the last one
_MEMBERS = 6  # from pin to pin
_OF_MODE = 65  # places at which a mode is told
_IN_PLANE = "in plane: Euler's column from end to end, under the largest compression"
_BEYOND = "in plane: hinged at two pins, free beyond them"
_HINGED = "the share is the largest eigenvalue of a bar hinged at two pins, which no formula gives"


def stress(part: Part, shape: Beam, loads: PartLoads) -> RungModel | None:
    """Fibres of the profile from pin to pin, and bosses as thick rings in their webs.

    None for bosses without a fillet, where the elastic stress has no bound.
    """
    if not shape.fillet:
        return None
    places = {hole.name: hole.at for hole in shape.holes}
    whole = BarPart.of(part, loads, places, _stretches(shape), shape.length)
    sections = SectionForces(whole.points, whole.forces)
    row = sorted(shape.holes, key=lambda hole: hole.at)
    for one, other in pairwise(row):
        _add_fibres(whole.points, shape, sections, one, other)
    for hole in row:
        _add_boss(whole.points, part, shape, loads, sections, hole)
    return whole.model(
        buckles=partial(elastic_load, part, shape, loads, whole.forces),
        neglects="that a boss is near to flanges and ends; bending of the walls across themselves; "
        "sleeves that bend between the webs",
    )


def family(part: Part, shape: Beam, _loads: PartLoads, _kind: str) -> str:
    """Solids that were compared have three pins; few of long stretches, with bars of all."""
    row = sorted(hole.at for hole in shape.holes)
    if len(row) != 3:
        return f"{part.shape} with {len(row)} pins"
    long = min(b - a for a, b in pairwise(row)) >= _FROM * shape.height
    return part.shape + LONG if long else part.shape


def _stretches(shape: Beam) -> Stretches:
    """The profile's cells, bosses and holes in their area."""
    bar, form = shape.profile, shape.form
    cuts = fine_cells(np.unique(bar.cuts), 160)
    x = (cuts[1:] + cuts[:-1]) / 2
    ones = np.ones(len(x))
    return Stretches(
        cuts,
        bar.at(x[:, None]).area[:, 0],
        ones * form.section.inertia_in_plane,
        ones * form.section.inertia_out_of_plane,
        ones * form.sections.torsion,
    )


def _add_fibres(
    points: Points, shape: Beam, sections: SectionForces, one: PinHole, other: PinHole
) -> None:
    """Add the profile's outermost fibres and its webs', from one pin to the next."""
    aside = _BESIDE * shape.length
    places = np.linspace(one.at + aside, other.at - aside, _STATIONS)
    columns, forces = sections.at(places)
    form = shape.form
    y = np.array([0.5, 0.0, -0.5]) * shape.height
    y = np.concatenate([y, np.array([0.5, -0.5]) * shape.flat])
    webs = np.array([0.0, 1.0, 0.0, 1.0, 1.0])
    stress = np.zeros((len(places), len(y), 6, len(columns)))
    stress[:, :, XX] = forces.axial[:, None] / form.section.area
    stress[:, :, XX] -= y[:, None] / form.section.inertia_in_plane * forces.moment_z[:, None]
    stress[:, :, XY] = webs[:, None] * form.shear * forces.shear[:, None]
    at = np.column_stack(
        [np.repeat(places, len(y)), np.tile(y, len(places)),
         np.tile(webs * shape.web_face, len(places))]
    )  # fmt: skip
    name = f"{one.name} to {other.name}"
    points.add_block(name, at, columns, stress.reshape(len(at), 6, -1))


def _add_boss(
    points: Points,
    part: Part,
    shape: Beam,
    loads: PartLoads,
    sections: SectionForces,
    hole: PinHole,
) -> None:
    """Add the rim of a hole, and the web at the fillet about its boss.

    The web has what the beam passes on, the mean of both sides of the pin, and what the pin's force
    adds in a wide plate. At the fillet its stress is raised as at the shoulder of a flat bar.
    """
    form, thick = shape.form, shape.boss_length
    found = boss_in_plate(
        hole.diameter / 2, hole.boss / 2, thick, form.webs, part.material.poisson_ratio,
        harmonics_of(loads.arc),
    )  # fmt: skip
    aside = _BESIDE * shape.length
    passed, forces = sections.at(hole.at + aside * np.array([-1.0, 1.0]))
    area, inertia = form.section.area, form.section.inertia_in_plane
    fields = np.stack(
        [forces.axial / area, -forces.moment_z / inertia, form.shear * forces.shear]
    ).mean(axis=1)
    rim = hole.diameter / 2 * np.exp(1j * ANGLES)
    foot = (hole.boss / 2 + shape.fillet) * np.exp(1j * ANGLES)
    raised = stepped_bar("tension", thick, shape.shoulder, shape.fillet)
    on_rim, passing = _of(found, rim, fields, ring=True)
    at_foot, beside = (_across(one, raised) for one in _of(found, foot, fields, ring=False))
    columns, patterns = bore_columns(
        points, part, loads, hole.name, on_rim[:, _PLANE], ANGLES, thick,
        (passed, passing[:, _PLANE]),
    )  # fmt: skip
    for name, arms, z, own, past in (
        (hole.name, rim, 0.0, on_rim, passing),
        (f"foot of {hole.name}", foot, shape.web_face, at_foot, beside),
    ):
        at = np.column_stack([hole.at + arms.real, arms.imag, np.full(len(arms), z)])
        stress = np.concatenate([own[:, :, patterns], past], axis=2)
        points.add_block(name, at, [*columns, *passed], stress)


def _across(stress: FloatArray, raised: float) -> FloatArray:
    """Stress (k, 6, columns) at the angles with its part across the fillet raised."""
    c, s = np.cos(ANGLES)[:, None], np.sin(ANGLES)[:, None]
    more = stress[:, XX] * c**2 + stress[:, YY] * s**2 + 2 * stress[:, XY] * s * c
    more *= raised - 1
    found = stress.copy()
    found[:, XX] += more * c**2
    found[:, YY] += more * s**2
    found[:, XY] += more * s * c
    return found


def _of(
    found: BossInPlate, arms: np.ndarray, fields: FloatArray, *, ring: bool
) -> tuple[FloatArray, FloatArray]:
    """Stress (k, 6, columns) of the pin's patterns, and of the fields (3, columns)."""
    plane, pressed = found.at(arms, ring=ring), len(found.patterns)
    full = np.zeros((len(arms), 6, plane.shape[2]))
    full[:, _PLANE] = plane
    return full[:, :, :pressed], full[:, :, pressed:] @ fields


def elastic_load(part: Part, shape: Beam, loads: PartLoads, bar: BarLoads) -> ElasticLoad:
    """Largest share of the elastic buckling load over the positions, and what bounds a solid's."""
    form, young, length = shape.form, part.material.youngs_modulus, shape.length
    own, shear = form.section, young / (2 * (1 + part.material.poisson_ratio))
    places = {hole.name: hole.at for hole in sorted(shape.holes, key=lambda hole: hole.at)}
    along = np.linspace(0.0, length, _ALONG)
    push = -bar.at(along[1:-1]).axial.min(axis=0)
    pulled = bool(push.max() <= HARDLY * loads.largest_force)
    push = np.maximum(push, 0.0)
    flat = np.full(_ALONG, young * own.inertia_in_plane)
    sliding = shear * float(form.sections.shear_area_y)
    column = push / column_force(flat, sliding, length)

    def stiffness(x: FloatArray, *, twists: bool = True) -> Stiffness:
        ones = np.ones_like(x)
        bending = own.inertia_out_of_plane if twists else own.inertia_in_plane
        polar = own.inertia_in_plane + own.inertia_out_of_plane if twists else 0.0
        return Stiffness(
            ones * young * bending,
            ones * shear * float(form.sections.torsion),
            ones * young * form.warping,
            ones * polar / own.area,
        )

    stations = np.array([*places.values()])
    parts = (np.linspace(*ends, _MEMBERS + 1) for ends in pairwise(stations))
    chain = Chain(spaced(np.concatenate([*parts])), stiffness)
    forces = bar.at(chain.points)
    axial = np.minimum(forces.axial, 0.0) if pulled else forces.axial
    acting = [Acting(axial, forces.moment_z, forces.shear)]
    pressed = [
        Pressed(0, hole.at, bore_pressure(0.0 if pulled else hole.diameter / 2, wrench))
        for hole, wrench in ((hole, loads.wrenches[hole.name]) for hole in shape.holes)
    ]
    names = _holding(places, loads.tilt_held_at or shape.interfaces[0])
    held = [(0, places[name]) for name in names]
    lateral = LateralBar([chain], held)
    share, position, stiff = lateral.worst_of_forks(acting, pressed)
    flat_bar = LateralBar([replace(chain, stiffness=partial(stiffness, twists=False))], held)
    along_only = [Acting(axial, np.zeros_like(axial), np.zeros_like(axial))]
    beyond, where = flat_bar.worst(along_only, [])
    beyond += float(push[where]) / sliding
    (worst,) = first_largest(column)
    local = of_walls(max(as_plate(wide, thick, free=free) for wide, thick, free in shape.plates))
    told = np.linspace(0.0, length, _OF_MODE)

    def swung(nodes: FloatArray) -> FloatArray:
        one = flat_bar.mode([each.at(where) for each in along_only], [])
        moves, turns, nothing = one.at(0, told)[0], one.at(0, told, 1)[0], np.zeros_like(told)
        at = np.stack([told, nothing, nothing], axis=1)
        return moved_with(nodes, at, np.stack([nothing, moves, *3 * [nothing], turns], axis=1))

    def moved(nodes: FloatArray) -> FloatArray:
        one = lateral.mode(
            [each.at(position) for each in acting], [each.at(position) for each in pressed]
        )
        (aside, twist), (slope, _) = one.at(0, told), one.at(0, told, 1)
        return bent_aside(np.array([0.0, length]), told, aside, slope, twist)(nodes)

    if beyond > max(share, float(column[worst])):
        items = partial(factor_items, beyond)
        load = ElasticLoad(beyond, where, _BEYOND, items, _HINGED, pulled, mode=swung)
    elif column[worst] >= share:
        explain = partial(column_items, float(push[worst]), flat, sliding, length)
        load = ElasticLoad(float(column[worst]), worst, _IN_PLANE, explain, pulled=pulled)
        mode = half_wave(np.zeros(3), np.array([length, 0.0, 0.0]), "in plane")
        load = replace(load, plane="in plane", span=length, mode=mode)
    else:
        others = max(float(column[position]), stiff, beyond)
        items, fixity = partial(factor_items, share), max(0.0, 1 - others / share)
        load = ElasticLoad(share, position, ASIDE, items, LATERAL, pulled, fixity, mode=moved)
    return replace(load, weakest=load.share, local=local)


def _holding(places: Mapping[str, float], first: str) -> list[str]:
    """The two pins at which the solid is held, the one that holds its twist first."""
    start = np.array([places[first], 0.0])
    order = {name: nearness(np.array([at, 0.0]), start) for name, at in places.items()}
    return sorted(places, key=lambda name: order[name])[:2]


_MODEL = partial(ShapeModel, stress=stress, family=family, press_fits=True, arcs=True)
RHS, I_SECTION = _MODEL(RhsBeam), _MODEL(IBeam)
