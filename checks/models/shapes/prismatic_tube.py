"""Square tubes with loaded end faces, by formula."""

from functools import partial
from math import pi, sqrt

import numpy as np

from checks.design.data import Part
from checks.models.formula_bars import BarPart, SectionForces, Stretches, add_tube_fibres
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import RungModel
from geometry.bars import fine_cells, square_tube
from geometry.mesh import FloatArray
from geometry.parts import PrismaticTube

_STATIONS = 19


def stress(part: Part, shape: PrismaticTube, loads: PartLoads) -> RungModel:
    """An even tube: axial force and bending at its sections, as its end faces bring them in."""
    (tube,) = shape.sections
    cuts = fine_cells(np.array([0.0, shape.length]), 64)
    ones, inertia = np.ones(len(cuts) - 1), tube.inertia_in_plane
    sections = square_tube(shape.width, shape.wall, tube.area, inertia)
    sheared = ones * sections.shear_area_y / (2 * (1 + part.material.poisson_ratio))
    bends, twists = ones * inertia, ones * sections.torsion
    mass = Stretches(cuts, ones * tube.area, bends, bends, twists, sheared, sheared)
    whole = BarPart.of(part, loads, {"start": 0.0, "end": shape.length}, mass, shape.length)
    bar, points = whole.forces, whole.points
    inside = 1e-9 * shape.length  # the ends' own forces are beyond the first section
    along = np.linspace(inside, shape.length - inside, _STATIONS)
    forces = SectionForces(points, bar)
    add_tube_fibres(points, "tube", along, forces, tube, (shape.width, shape.wall))
    return whole.model(
        local=lambda: 1 / (tube.area * _pressed_edges(part, shape)),  # walls at the pressed ends
        stretch=partial(_walls_mode, shape, part.material.poisson_ratio),
        neglects="how the end faces bring forces in; bending of the walls across themselves",
    )


def _pressed_edges(part: Part, shape: PrismaticTube) -> float:
    """Stress, MPa, under which the walls buckle at an end, whose edges are free."""
    steel, apart = part.material, shape.width - shape.wall
    return pressed_edge_stress(shape.wall, apart, steel.youngs_modulus, steel.poisson_ratio)


def _walls_mode(shape: PrismaticTube, poisson_ratio: float, nodes: FloatArray) -> FloatArray:
    """Displacements (n, 3) of the walls at both ends, out and in by turns round the tube.

    As in `pressed_edge_stress`, e^(-a x) (cos(b x) + c sin(b x)) from either end, which is straight
    on a line across the wall: f'' = nu f gives c.
    """
    apart = shape.width - shape.wall
    factor = (3 + poisson_ratio) * (1 - poisson_ratio)
    a, b = sqrt(1 - factor / 4), sqrt(factor) / 2
    c = (a**2 - b**2 - poisson_ratio) / (2 * a * b)
    aside, slope = np.zeros((2, len(nodes)))
    for way, from_end in ((1.0, nodes[:, 0]), (-1.0, shape.length - nodes[:, 0])):
        x = np.maximum(from_end, 0.0) * pi / apart
        dies, cosine, sine = np.exp(-a * x), np.cos(b * x), np.sin(b * x)
        aside += dies * (cosine + c * sine)
        slope += way * pi / apart * dies * ((b * c - a) * cosine - (b + a * c) * sine)
    y, z = nodes[:, 1:].T
    top = np.abs(z) > np.abs(y)
    place = np.where(top, y, z)
    across = np.clip(place, -apart / 2, apart / 2)
    wave, turn = np.cos(pi * across / apart), -pi / apart * np.sin(pi * across / apart)
    wave += turn * (place - across)  # corners go straight on
    outwards = np.where(top, np.sign(z), np.sign(y))
    outer = np.where(top, np.abs(z), np.abs(y)) - apart / 2
    out = np.where(top, 1.0, -1.0)  # walls beside each other turn alike at their edge
    normal, within = out * outwards * aside * wave, -out * outer * aside * turn
    moved = np.where(top, [within, normal], [normal, within]).T
    return np.column_stack([-out * outer * slope * wave, moved])


MODEL = ShapeModel(PrismaticTube, stress)


# Buckling of a long plate at the edge on which it is pressed, where nothing holds that edge.


def pressed_edge_stress(
    thickness: float, width: float, youngs_modulus: float, poisson_ratio: float
) -> float:
    """Pressure, MPa, on the free end of a long plate, its sides simply supported, that buckles it.

    thickness, width  mm, the width between the supported sides

    With w = f(x) sin(pi y/b), pressure k pi^2 D/(b^2 t) and lengths over b/pi the plate's equation
    (f'' - f) differentiated alike, f'''' + (k - 2) f'' + f = 0, has for k < 4 two conjugate
    solutions that die away from the end, of sum -2 sqrt(1 - k/4) and product 1. At the free end
    f'' = nu f and f''' + (k - 2 + nu) f' = 0 (no moment; shear of the plate's edge and of the
    pressure, which keeps its direction). Both hold for k = (3 + nu)(1 - nu): 2.31 for steel,
    against 4 of a plate whose ends are held.
    """
    if not (thickness > 0 and width > 0):
        raise ValueError(f"a plate needs sizes above 0 mm, got {thickness:g} and {width:g}")
    factor = (3 + poisson_ratio) * (1 - poisson_ratio)
    euler = pi**2 * youngs_modulus / (12 * (1 - poisson_ratio**2))
    return factor * euler * (thickness / width) ** 2
