"""Square tubes with pin holes through two walls, by formula."""

from functools import lru_cache, partial
from math import pi

import numpy as np

from checks.design.data import Part
from checks.handbook.lug_stress import Lug, stepped_bar, strip_outline
from checks.handbook.pin_loaded_hole import pin_loaded_hole
from checks.models.cheek_buckling import solved_to, spread_mode, spreading
from checks.models.formula_bars import (
    BarPart,
    SectionForces,
    Stretches,
    add_fibres,
    add_tube_fibres,
    fibre_stress,
)
from checks.models.formula_lugs import add_bore, strip_edges
from checks.models.formula_points import Points
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import RungModel
from fem.unit_loads import harmonics_of
from geometry.bars import Section, fine_cells, plate_section, square_tube_section
from geometry.mesh import FloatArray
from geometry.parts import ToggleBar

_STATIONS = 9


def stress(part: Part, shape: ToggleBar, loads: PartLoads) -> RungModel:
    """Two cheeks with a hole at each end, stiffened by the side walls but where these are cut away.

    Each cheek carries half of a pin's force, as a plane lug whose edges are stringers: half of a
    side wall each.
    """
    free = shape.cutout_length - shape.overhang  # where the side walls begin
    tube, cheeks = _sections(shape)
    mass = _stretches(shape, free, tube, cheeks)
    places = {"knee": 0.0, "end": shape.length}
    whole = BarPart.of(part, loads, places, mass, shape.length, (shape.hole / 2, shape.hole / 2))
    bar, points = whole.forces, whole.points
    nu = part.material.poisson_ratio
    lugs = {name: lug_at(shape, name, nu, loads.arc) for name in places}
    for name, x in places.items():
        outward = -1.0 if name == "knee" else 1.0
        edges = strip_edges(shape.width / 2, shape.overhang, shape.width / 2, outward)
        add_bore(points, part, loads, name, x, lugs[name], (shape.width / 2,), edges=edges)
    sections = SectionForces(points, bar)
    start, stop = max(free, 0.0), shape.length - shape.hole / 2
    if start < stop:
        along = np.linspace(start, stop, _STATIONS + 1)[:-1]
        add_tube_fibres(points, "tube", along, sections, tube, (shape.width, shape.wall))
    _add_cheek_fibres(points, shape, min(free, stop), cheeks, sections)
    if 0 < free < shape.length:
        _add_cut_out(points, shape, free, cheeks, sections)
    return whole.model(
        local=lambda: _spread(part, shape),
        stretch=partial(spread_mode, shape, lugs["knee"], nu),
        neglects="bending of the walls across themselves; that the side walls lag in taking their "
        "share",
    )


def _spread(part: Part, shape: ToggleBar) -> float | None:
    """Share of the cheeks' buckling load by 1 N of push; None where they are no plates."""
    share = _spreading(shape, part.material.poisson_ratio)
    return None if share is None else share / part.material.youngs_modulus


def cheeks_alone(shape: ToggleBar, plane: str, nodes: FloatArray) -> FloatArray:
    """Displacements (n, 3) of nodes (n, 3) mm where the cheeks buckle by themselves in a plane.

    In the plane of the linkage they are hinged at the pin and where the side walls begin. Out of it
    each is a cantilever from there, and they splay apart (`geometry.bars.plate_pair_section`).
    """
    free = shape.cutout_length - shape.overhang
    x, y, z = nodes.T
    share = np.clip(x / free, 0.0, 1.0)
    before, still = np.minimum(x, 0.0), np.zeros_like(x)
    if plane == "in plane":
        slope = pi / free * np.where(share < 1.0, np.cos(pi * share), 0.0)
        return np.stack([-y * slope, np.sin(pi * share) + slope * before, still], axis=1)
    slope = -pi / (2 * free) * np.cos(pi / 2 * share)
    aside = 1 - np.sin(pi / 2 * share) + slope * before
    off = np.abs(z) - shape.cheeks_at
    return np.stack([-off * slope, still, np.sign(z) * aside], axis=1)


@lru_cache(64)  # bars of one size, and their variations in other dimensions than the part's
def _spreading(shape: ToggleBar, poisson_ratio: float) -> float | None:
    """Share of the cheeks' buckling load by 1 N of push, at a Young's modulus of 1 MPa."""
    return spreading(shape, lug_at(shape, "knee", poisson_ratio), 1.0, poisson_ratio)


def lug_at(shape: ToggleBar, name: str, poisson_ratio: float, arc: float = pi) -> Lug:
    """Both cheeks about a hole, half of a side wall along each edge where it is not cut away.

    arc  rad, on which the pin presses
    """
    free = shape.cutout_length - shape.overhang
    behind = free if name == "knee" or free > shape.length - shape.hole else -np.inf
    outline = strip_outline(
        shape.width / 2, shape.overhang, solved_to(shape), shape.width / 2 - shape.wall, behind
    )
    hole = pin_loaded_hole(shape.hole / 2, outline, poisson_ratio, harmonics_of(arc))
    return Lug(hole, 2 * shape.wall, mirrored=name == "end")


def _sections(shape: ToggleBar) -> tuple[Section, Section]:
    """The tube, and its two cheeks alone."""
    tube = square_tube_section("tube", shape.width, shape.wall, shape.inner_radius)
    one = plate_section("cheeks", shape.width, 2 * shape.wall)
    return tube, one


def _stretches(shape: ToggleBar, free: float, tube: Section, cheeks: Section) -> Stretches:
    ends = [-shape.overhang, 0.0, shape.length, shape.length + shape.overhang]
    if ends[0] < free < ends[-1]:
        ends.append(free)
    cuts = fine_cells(np.unique(ends), 96)
    middles = (cuts[1:] + cuts[:-1]) / 2
    cells = _cells(cuts, middles < free, tube, cheeks, shape.width, shape.wall)
    for x in (0.0, shape.length):
        chord = 2 * np.sqrt(np.maximum(shape.hole**2 / 4 - (middles - x) ** 2, 0.0))
        cells.area[:] -= 2 * shape.wall * chord
    return cells


def _cells(
    cuts: FloatArray,
    cheeks_only: np.ndarray,
    tube: Section,
    cheeks: Section,
    width: float,
    wall: float,
) -> Stretches:
    """A tube, but for the cells where only its cheeks are left; torsion by Bredt, and of plates.

    The cheeks alone bend in S shape between side walls and pin, so that they rack.
    """
    apart = width - wall
    free = float(np.diff(cuts)[cheeks_only & (cuts[1:] > 0)].sum())
    racking = width * wall**3 / (2 * free**2) if free else np.inf
    across = 2 * width * wall * (apart / 2) ** 2
    return Stretches(
        cuts,
        np.where(cheeks_only, cheeks.area, tube.area),
        np.where(cheeks_only, cheeks.inertia_in_plane, tube.inertia_in_plane),
        np.where(cheeks_only, across, tube.inertia_out_of_plane),
        np.where(cheeks_only, 2 * width * wall**3 / 3, wall * apart**3),
        np.where(cheeks_only, racking, np.inf),
    )


def _add_cheek_fibres(
    points: Points, shape: ToggleBar, free: float, cheeks: Section, sections: SectionForces
) -> None:
    """Add the edges of the cheeks alone, from beside the knee's hole to where the walls begin."""
    if free <= shape.hole / 2:
        return
    places = np.linspace(shape.hole / 2, free, 4)
    columns, forces = sections.at(places)
    y = np.array([1.0, -1.0]) * shape.width / 2
    stress = fibre_stress(forces, cheeks.area, y / cheeks.inertia_in_plane)
    add_fibres(points, "cheeks", places, (y, np.full(2, shape.width / 2)), columns, stress)


def _add_cut_out(
    points: Points, shape: ToggleBar, free: float, cheeks: Section, sections: SectionForces
) -> None:
    """Add the cheeks' edges where the side walls begin: shoulder fillets of two flat bars.

    A cheek that widens into a side wall at its edge is half of a stepped bar, as thick as both
    cheeks and as wide as the tube.
    """
    factor = stepped_bar("tension", shape.width, 2 * shape.wall, shape.cutout_corner)
    places = np.array([free])
    columns, forces = sections.at(places)
    y = np.array([1.0, -1.0]) * shape.width / 2
    stress = factor * fibre_stress(forces, cheeks.area, y / cheeks.inertia_in_plane)
    z = np.full(2, shape.width / 2 - shape.wall)
    add_fibres(points, "cut-out corner", places, (y, z), columns, stress)


MODEL = ShapeModel(ToggleBar, stress, press_fits=True, arcs=True)
