"""Elastic buckling of a beam of a profile, with any number of pins in a row.

In the plane it is Euler's column from its first pin to its last one, under the largest compression
anywhere: pins between them hold nothing. Or it is hinged at the two pins that hold the solid and
free beyond them, where that is more. Out of it a bar that is bent aside and twisted
(checks/handbook/lateral_buckling.py), held by the same pins; bosses stiffen nothing.

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
from checks.models.bar_modes import bent_aside, half_wave, moved_with
from checks.models.formula_bars import (
    ASIDE,
    HARDLY,
    LATERAL,
    as_plate,
    column_items,
    factor_items,
    of_walls,
)
from checks.part.part_loads import PartLoads, first_largest
from checks.stress.stress_result import ElasticLoad
from fem.end_conditions import nearness
from geometry.mesh import FloatArray
from geometry.parts import Beam

_STATIONS = 33  # from the first pin to the last one
_MEMBERS = 6  # from pin to pin
_OF_MODE = 65  # places at which a mode is told
_IN_PLANE = "in plane: Euler's column from end to end, under the largest compression"
_BEYOND = "in plane: hinged at two pins, free beyond them"
_HINGED = "the share is the largest eigenvalue of a bar hinged at two pins, which no formula gives"


def elastic_load(part: Part, shape: Beam, loads: PartLoads, bar: BarLoads) -> ElasticLoad:
    """Largest share of the elastic buckling load over the positions, and what bounds a solid's."""
    form, young, length = shape.form, part.material.youngs_modulus, shape.length
    own, shear = form.section, young / (2 * (1 + part.material.poisson_ratio))
    places = {hole.name: hole.at for hole in sorted(shape.holes, key=lambda hole: hole.at)}
    along = np.linspace(0.0, length, _STATIONS)
    push = -bar.at(along[1:-1]).axial.min(axis=0)
    pulled = bool(push.max() <= HARDLY * loads.largest_force)
    push = np.maximum(push, 0.0)
    flat = np.full(_STATIONS, young * own.inertia_in_plane)
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
