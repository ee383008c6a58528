"""Flat links by formula."""

import numpy as np

from checks.design.data import Part
from checks.handbook.lug_stress import Lug, strip_outline
from checks.handbook.pin_loaded_hole import pin_loaded_hole
from checks.models.bands import beside_others
from checks.models.formula_bars import BarPart, Stretches, add_rectangle_fibres
from checks.models.formula_points import add_bore, strip_edges
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import RungModel
from fem.unit_loads import harmonics_of
from geometry.bars import BESIDE, fine_cells, rectangle_torsion
from geometry.parts import PlateLink

_STATIONS = 13


def stress(part: Part, shape: PlateLink, loads: PartLoads) -> RungModel:
    """A flat link: two lugs that are round about their pins, and the bar between them."""
    second = shape.hole if shape.second_hole is None else shape.second_hole
    holes = {"first": (0.0, shape.hole), "second": (shape.length, second)}
    half, thickness = shape.width / 2, shape.thickness
    mass = _stretches(shape, holes)
    whole = BarPart.of(
        part,
        loads,
        {name: x for name, (x, _) in holes.items()},
        mass,
        shape.length,
        (shape.hole / 2, second / 2),
    )
    bar, points = whole.forces, whole.points
    modulus = float(rectangle_torsion(shape.width, thickness)[1])
    cut = min(BESIDE * shape.width, shape.length / 2)
    for name, (x, hole) in holes.items():
        outline = strip_outline(half, None, max(cut, 0.75 * hole))
        nu, harmonics = part.material.poisson_ratio, harmonics_of(loads.arc)
        found = pin_loaded_hole(hole / 2, outline, nu, harmonics)
        lug = Lug(found, thickness, mirrored=x > 0, twist_modulus=modulus)
        edges = strip_edges(half, None, half, 1.0 if x > 0 else -1.0)
        add_bore(points, part, loads, name, x, lug, (0.0,), edges=edges, tilts=True)
    low, high = shape.hole / 2, shape.length - second / 2
    places = np.linspace(low, high, _STATIONS + 2)[1:-1]
    add_rectangle_fibres(points, "plate", places, bar.at(places), (shape.width, thickness), modulus)
    return whole.model(
        neglects="stress not linear through the thickness; that the holes disturb each other",
    )


def _stretches(shape: PlateLink, holes: dict[str, tuple[float, float]]) -> Stretches:
    half = shape.width / 2
    ends = np.array([-half, 0.0, shape.length, shape.length + half])
    cuts = fine_cells(np.unique(ends), 96)
    x = (cuts[1:] + cuts[:-1]) / 2
    beyond = np.maximum(np.maximum(-x, x - shape.length), 0.0)
    height = 2 * np.sqrt(half**2 - beyond**2)
    for at, hole in holes.values():
        height = height - 2 * np.sqrt(np.maximum(hole**2 / 4 - (x - at) ** 2, 0.0))
    thickness = shape.thickness
    ones = np.ones(len(x))
    torsion, _ = rectangle_torsion(shape.width, thickness)
    return Stretches(
        cuts,
        height * thickness,
        ones * thickness * shape.width**3 / 12,
        ones * shape.width * thickness**3 / 12,
        ones * torsion,
    )


MODEL = ShapeModel(PlateLink, stress, family=beside_others, tilts=True, press_fits=True, arcs=True)
