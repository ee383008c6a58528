"""Square tubes with loaded end faces, by formula."""

import numpy as np

from checks.columns.column_moments import axial_compression
from checks.design.data import Part
from checks.handbook.edge_buckling import pressed_edge_stress
from checks.models.formula_bars import (
    SectionForces,
    Stretches,
    bar_loads,
    bar_model,
    fine_cells,
)
from checks.models.formula_points import Points
from checks.models.shape_model import ShapeModel
from checks.models.tube_fibres import add_tube_fibres
from checks.part.part_loads import PartLoads
from checks.stress.part_model import RungModel
from geometry.mesh import FloatArray
from geometry.parts import PrismaticTube

_STATIONS = 19


def stress(part: Part, shape: PrismaticTube, loads: PartLoads) -> RungModel:
    """An even tube: axial force and bending at its sections, as its end faces bring them in."""
    (tube,) = shape.sections
    cuts = fine_cells(np.array([0.0, shape.length]), 64)
    ones, inertia = np.ones(len(cuts) - 1), tube.inertia_in_plane
    torsion = shape.wall * (shape.width - shape.wall) ** 3
    mass = Stretches(cuts, ones * tube.area, ones * inertia, ones * inertia, ones * torsion)
    bar = bar_loads(part, loads, {"start": 0.0, "end": shape.length}, mass)
    points = Points(len(loads.accelerations))
    inside = 1e-9 * shape.length  # the ends' own forces are beyond the first section
    along = np.linspace(inside, shape.length - inside, _STATIONS)
    sections = SectionForces(points, bar)
    add_tube_fibres(points, "tube", along, sections, tube, (shape.width, shape.wall))
    return bar_model(
        part,
        loads,
        points,
        bar,
        mass,
        shape.length,
        local=1 / (tube.area * _pressed_edges(part, shape)),  # the walls at the free, pressed ends
        neglects="how the end faces bring forces in; bending of the walls across themselves",
    )


def _pressed_edges(part: Part, shape: PrismaticTube) -> float:
    """Stress, MPa, under which the walls buckle at an end, whose edges are free."""
    steel, apart = part.material, shape.width - shape.wall
    return pressed_edge_stress(shape.wall, apart, steel.youngs_modulus, steel.poisson_ratio)


def walls(part: Part, shape: PrismaticTube, loads: PartLoads) -> FloatArray:
    """Share (n,) of the walls' buckling stress, by the force and the couple at an end."""
    (tube,) = shape.sections
    couples = np.stack([np.abs(loads.wrenches[name][:, 5]) for name in shape.interfaces])
    bent = couples.max(axis=0) * shape.width / 2 / tube.inertia_in_plane
    pressed = axial_compression(part, loads) / tube.area + bent
    return np.asarray(np.maximum(pressed, 0.0) / _pressed_edges(part, shape))


MODEL = ShapeModel(PrismaticTube, stress, walls=walls)
