"""Square tubes with loaded end faces, by formula."""

import numpy as np

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
    steel, apart = part.material, shape.width - shape.wall
    limit = pressed_edge_stress(shape.wall, apart, steel.youngs_modulus, steel.poisson_ratio)
    return bar_model(
        part,
        loads,
        points,
        bar,
        mass,
        shape.length,
        local=1 / (tube.area * limit),  # the walls at the free, pressed ends
        neglects="how the end faces bring forces in; bending of the walls across themselves",
    )


MODEL = ShapeModel(PrismaticTube, stress)
