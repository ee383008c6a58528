"""Parts from CAD by formula: a straight bar of the sections that planes normal to x cut.

The line of the holes is x. A force N and moments M_y, M_z about it bend a section whose centroid
stands at (y_c, z_c) by M_y - N z_c and M_z + N y_c about that, and stress is linear over it:

    xx = N/A + a (y - y_c) + b (z - z_c)

with a and b by its second moments, the product of area included (docs/theory/buckling.md).

How far a solid's buckling share may be above the bar's is bounded without solids like it: by the
weakest section all along between the bores, and by its thinnest wall as a long plate.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from checks.design.data import Part
from checks.models.bar_modes import from_start
from checks.models.formula_bars import (
    SectionForces,
    Stretches,
    as_plate,
    bar_loads,
    elastic_load,
    holds_last,
    left_over,
    most_deflected,
    of_walls,
)
from checks.models.formula_points import XX, Points
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import ElasticLoad, RungModel, no_answer
from geometry.mesh import FloatArray
from geometry.parts.step_part import StepPart, bar_slices
from geometry.slices import Slice

_STRAIGHT = 1e-3  # of the outermost holes' distance: how far a hole may stand beside the line
_BESIDE = 1e-9  # of it: how far a section just beside a hole is from the hole's axis
_SHEARED = 0.4  # of the area: shear coefficients are 0.83 of a rectangle, 0.42 of a thin square box
_TWISTED = 0.12  # Saint-Venant's constant over A t^2, t the thinnest wall: a square has 0.14
_BESIDE_BORES = 4.0  # times the nominal stress of the sections


def stress(part: Part, shape: StepPart, loads: PartLoads) -> RungModel | None:
    """A bar of the solid's own sections along the line of the holes.

    None where the holes do not stand on one line along x with their middles in one plane, and for
    contacts that slide. The buckling load takes the force at two holes; a force at a third one
    changes the compression along the bar.
    """
    centres = {name: shape.centre(name) for name in shape.interfaces}
    along = np.sort([centre[0] for centre in centres.values()])
    span = float(along[-1] - along[0])
    aside = max(float(np.abs(centre[1:]).max()) for centre in centres.values())
    if loads.reaches or aside > _STRAIGHT * span:
        return None
    start = float(along[0])
    cut = bar_slices(shape)
    bar_of = _stretches(cut.cuts - start, cut.cells, shape.solid.volume)
    own = _on_line(loads, centres)
    places = {name: float(centre[0]) - start for name, centre in centres.items()}
    forces = bar_loads(part, own, places, bar_of)
    points = Points(len(loads.accelerations))
    sections = SectionForces(points, forces)
    for side in (-_BESIDE, _BESIDE):
        _add_fibres(points, sections, cut.at_holes, start, side * span)
    inside = [one for one in cut.cells if along[0] < one.place < along[-1]]
    _add_fibres(points, sections, inside, start)

    def buckles() -> ElasticLoad | None:
        names = sorted(places, key=lambda name: places[name])
        first, last = (shape.bore(name) / 2 for name in names)
        last_holds = holds_last(own, places)
        load = elastic_load(part, own, forces, bar_of, span, (first, last), held_last=last_holds)
        if load.mode is not None:
            load = replace(load, mode=partial(from_start, load.mode, start))
        if not cut.straight:
            return load
        weakest = _weakest(bar_of, cut.between)
        weak = elastic_load(part, own, forces, weakest, span, held_last=last_holds)
        worst = max(map(_as_plate, cut.between))
        local = _BESIDE_BORES * of_walls(worst)
        return replace(load, weakest=max(load.share, weak.share), local=local)

    return points.model(
        residual=left_over(forces, own, span),
        deflection=most_deflected(forces, part, bar_of, span),
        buckles=buckles if len(places) == 2 else no_answer,
        neglects="what is not linear over a section, shear, torsion, and that the bar is not "
        "straight",
    )


def family(_part: Part, _shape: StepPart, _loads: PartLoads, _kind: str) -> str:
    """One for all: a part is named after its file, whatever that is called."""
    return "CAD part"


def _stretches(cuts: FloatArray, cells: Sequence[Slice], volume: float) -> Stretches:
    """The bar by its sections, as heavy as the solid; x from the first hole."""
    area = np.array([one.area for one in cells])
    in_plane, across, _ = np.transpose([one.moments for one in cells])
    torsion = area**4 / (
        4 * np.pi**2 * (in_plane + across)
    )  # of an ellipse: pi a^3 b^3/(a^2 + b^2)
    heavy = area * volume / float(area @ np.diff(cuts))
    return Stretches(cuts, heavy, in_plane, across, torsion)


def _weakest(bar: Stretches, between: Sequence[Slice]) -> Stretches:
    """The bar with the least of every section between the bores all along.

    Where a section is of several bodies the least of them stands alone: nothing says how they are
    held together.
    """
    ones = np.ones_like(bar.area)
    area, moment = (
        ones * min(getattr(one, name) for one in between) for name in ("weak_area", "weak_moment")
    )
    torsion = ones * min(_TWISTED * one.weak_area * min(one.walls) ** 2 for one in between)
    sheared = _SHEARED * area / 2.6
    return replace(
        bar, inertia_z=moment, inertia_y=moment, torsion=torsion, racking=sheared, sliding=sheared
    )


def _as_plate(one: Slice) -> float:
    """Its thinnest wall, held along both edges or free at one, as wide as all of it."""
    wall, fin = one.walls
    return max(as_plate(one.breadth, wall), as_plate(one.breadth, fin, free=True))


def _on_line(loads: PartLoads, centres: Mapping[str, FloatArray]) -> PartLoads:
    """The same loads on the line y = z = 0.

    A force at (y, z) has the couple (-z F_y, z F_x, -y F_x) about the line. Accelerations stay
    those of the frame's origin, wherever the bar's x begins: of a bar in balance with its loads
    only omega2 is taken from them, which is the same everywhere.
    """
    moved = {}
    for name, wrench in loads.wrenches.items():
        _, y, z = centres[name]
        moved[name] = wrench.copy()
        moved[name][:, 3] -= z * wrench[:, 1]
        moved[name][:, 4] += z * wrench[:, 0]
        moved[name][:, 5] -= y * wrench[:, 0]
    return replace(loads, wrenches=moved)


def _add_fibres(
    points: Points,
    sections: SectionForces,
    slices: Sequence[Slice],
    start: float,
    beside: float = 0.0,
) -> None:
    """Outermost points of sections, `beside` mm further on; forces have x from `start`."""
    places = np.array([one.place for one in slices]) + beside
    columns, forces = sections.at(places - start)
    for k, one in enumerate(slices):
        (y_c, z_c), (yy, zz, yz) = one.centre, one.moments
        axial = forces.axial[k]
        about_z = forces.moment_z[k] + axial * y_c
        about_y = forces.moment_y[k] - axial * z_c
        slopes = np.linalg.solve([[yy, yz], [yz, zz]], np.stack([-about_z, about_y]))
        unit = np.zeros((len(one.outline), 6, len(columns)))
        unit[:, XX] = axial / one.area + (one.outline - one.centre) @ slopes
        at = np.column_stack([np.full(len(unit), places[k]), one.outline])
        points.add_block("section", at, columns, unit)


MODEL = ShapeModel(StepPart, stress, family=family)
