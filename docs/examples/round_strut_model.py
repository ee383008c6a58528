"""The solid round bar by formula: N/A and M y/I all along it."""

import numpy as np
from round_strut import RoundStrut

from checks.design.data import Part
from checks.models.formula_bars import (
    BarPart,
    SectionForces,
    Stretches,
    add_fibres,
    fibre_stress,
)
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import RungModel
from geometry.bars import fine_cells

_STATIONS = 17
_AROUND = np.radians(np.arange(0.0, 360.0, 45.0))


def stress(part: Part, shape: RoundStrut, loads: PartLoads) -> RungModel:
    """Fibres all round the bar, by its loads in balance with its own inertia."""
    (bar,) = shape.sections
    cuts = fine_cells(np.array([0.0, shape.length]), 64)
    area, inertia = np.full((2, len(cuts) - 1), [[bar.area], [bar.inertia_in_plane]])
    mass = Stretches(cuts, area, inertia, inertia, 2 * inertia)
    whole = BarPart.of(part, loads, {"start": 0.0, "end": shape.length}, mass, shape.length)
    inside = 1e-9 * shape.length  # the ends' own forces are beyond the first section
    places = np.linspace(inside, shape.length - inside, _STATIONS)
    columns, forces = SectionForces(whole.points, whole.forces).at(places)
    y, z = np.array([np.sin(_AROUND), np.cos(_AROUND)]) * shape.diameter / 2
    fibres = fibre_stress(forces, bar.area, y / bar.inertia_in_plane)
    add_fibres(whole.points, "bar", places, (y, z), columns, fibres)
    return whole.model(neglects="how the end faces bring forces in; shear")


MODEL = ShapeModel(RoundStrut, stress)
