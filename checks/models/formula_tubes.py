"""The rung `formula` of square tubes, with pin holes through two walls or with loaded end faces."""

from math import pi

import numpy as np

from checks.design.data import Part
from checks.handbook.bar_forces import BarForces
from checks.handbook.edge_buckling import pressed_edge_stress
from checks.handbook.lateral_buckling import plate_stress
from checks.handbook.lug_outlines import strip_outline
from checks.handbook.lug_stress import Lug
from checks.handbook.notch_factors import stepped_bar
from checks.handbook.pin_loaded_hole import pin_loaded_hole
from checks.models.formula_bars import (
    SectionForces,
    Stretches,
    bar_loads,
    elastic_load,
    fine_cells,
    left_over,
    most_deflected,
)
from checks.models.formula_lugs import add_bore, strip_edges
from checks.models.formula_points import XX, XY, Points
from checks.part.part_loads import PartLoads
from checks.stress.part_model import RungModel
from geometry.mesh import FloatArray
from geometry.parts import PrismaticTube, ToggleBar
from geometry.sections import Section, plate_section, square_tube_section

_CUT = 1.25  # widths from a hole to where the cheek's stress is that of the bar
_STATIONS = 9


def toggle_bar_model(part: Part, shape: ToggleBar, loads: PartLoads) -> RungModel:
    """Two cheeks with a hole at each end, stiffened by the side walls but where these are cut away.

    Each cheek carries half of a pin's force, as a plane lug whose edges are stringers: half of a
    side wall each.
    """
    free = shape.cutout_length - shape.overhang  # where the side walls begin
    tube, cheeks = _sections(shape)
    mass = _stretches(shape, free, tube, cheeks)
    places = {"knee": 0.0, "end": shape.length}
    bar = bar_loads(part, loads, places, mass)
    points = Points(len(loads.accelerations))
    cut = min(_CUT * shape.width, shape.length / 2)
    stringer = (shape.width - 2 * shape.wall) / 2
    for name, x in places.items():
        outline = strip_outline(
            shape.width / 2,
            shape.overhang,
            max(cut, shape.hole),
            stringer,
            free if name == "knee" or free > shape.length - shape.hole else -np.inf,
        )
        hole = pin_loaded_hole(shape.hole / 2, outline, part.material.poisson_ratio)
        lug = Lug(hole, 2 * shape.wall, mirrored=name == "end")
        outward = -1.0 if name == "knee" else 1.0
        edges = strip_edges(shape.width / 2, shape.overhang, shape.width / 2, outward)
        add_bore(points, name, x, lug, loads.wrenches[name], (shape.width / 2,), edges=edges)
    sections = SectionForces(points, bar)
    start, stop = max(free, 0.0), shape.length - shape.hole / 2
    if start < stop:
        along = np.linspace(start, stop, _STATIONS + 1)[:-1]
        _add_tube_fibres(points, "tube", along, sections, tube, (shape.width, shape.wall))
    _add_cheek_fibres(points, shape, min(free, stop), cheeks, sections)
    if 0 < free < shape.length:
        _add_cut_out(points, shape, free, cheeks, sections)
    return RungModel(
        rung="formula",
        history=points.history(),
        places=points.places,
        units=points.units,
        fretting=points.fretting,
        numerical=0.0,
        residual=left_over(bar, loads, shape.length),
        deflection=most_deflected(bar, part, mass, shape.length),
        buckling=elastic_load(
            part, loads, bar, mass, shape.length, local=_local_share(part, shape, free)
        ),
        neglects="bending of the walls across themselves; that the side walls lag in taking their "
        "share",
    )


def prismatic_tube_model(part: Part, shape: PrismaticTube, loads: PartLoads) -> RungModel:
    """An even tube: axial force and bending at its sections, as its end faces bring them in."""
    (tube,) = shape.sections
    cuts = fine_cells(np.array([0.0, shape.length]), 64)
    mass = _cells(cuts, np.zeros(len(cuts) - 1, bool), tube, tube, shape.width, shape.wall)
    bar = bar_loads(part, loads, {"start": 0.0, "end": shape.length}, mass)
    points = Points(len(loads.accelerations))
    inside = 1e-9 * shape.length  # the ends' own forces are beyond the first section
    along = np.linspace(inside, shape.length - inside, 2 * _STATIONS + 1)
    sections = SectionForces(points, bar)
    _add_tube_fibres(points, "tube", along, sections, tube, (shape.width, shape.wall))
    return RungModel(
        rung="formula",
        history=points.history(),
        places=points.places,
        units=points.units,
        fretting=points.fretting,
        numerical=0.0,
        residual=left_over(bar, loads, shape.length),
        deflection=most_deflected(bar, part, mass, shape.length),
        buckling=elastic_load(
            part, loads, bar, mass, shape.length, local=_pressed_ends(part, tube)
        ),
        neglects="how the end faces bring forces in; bending of the walls across themselves",
    )


def _plate(part: Part, shape: ToggleBar) -> float:
    """Stress, MPa, at which a wall of the tube buckles between its edges."""
    steel = part.material
    apart = shape.width - shape.wall
    return plate_stress(shape.wall, apart, steel.youngs_modulus, steel.poisson_ratio)


def _pressed_ends(part: Part, tube: Section) -> float:
    """Share of the walls' buckling load at the tube's free, pressed ends that 1 N is, 1/N."""
    shape, steel = part.geometry, part.material
    assert isinstance(shape, PrismaticTube)
    apart = shape.width - shape.wall
    stress = pressed_edge_stress(shape.wall, apart, steel.youngs_modulus, steel.poisson_ratio)
    return 1 / (tube.area * stress)


def _local_share(part: Part, shape: ToggleBar, free: float) -> float:
    """Share of its buckling load that 1 N is on the cheeks by themselves, 1/N.

    Beside the hole they carry the whole force: as plates held by the side walls, and beside the
    cut-out as columns with one end free. Both at once by Dunkerley's sum, a bound from below.
    """
    both = 2 * shape.width * shape.wall
    plates = 1 / (both * _plate(part, shape))
    if not free > 0:
        return plates
    euler = pi**2 * part.material.youngs_modulus * shape.wall**2 / 12 / (2 * free) ** 2
    return float(plates + 1 / (both * euler))


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


def _add_tube_fibres(
    points: Points,
    name: str,
    places: FloatArray,
    sections: SectionForces,
    tube: Section,
    size: tuple[float, float],
) -> None:
    """Add corners and middles of the walls: sigma of N, M_z, M_y; shear of V in the cheeks."""
    width, wall = size
    half = width / 2
    y = half * np.array([1.0, 1.0, -1.0, -1.0, 0.0, 0.0, 1.0, -1.0])
    z = half * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 0.0, 0.0])
    cheek = (y == 0).astype(float)
    columns, forces = sections.at(places)
    stress = _fibre_stress(forces, tube.area, y / tube.inertia_in_plane)
    stress[:, :, XX] += z[:, None] / tube.inertia_out_of_plane * forces.moment_y[:, None]
    # V S/(2 t I) in the middle of a thin square box: S = 3/8 of w^2 t, I = 2/3 w^3 t
    sheared = cheek[:, None] * 9 / (16 * (width - wall) * wall)
    stress[:, :, XY] = sheared * forces.shear[:, None]
    _add_fibres(points, name, places, (y, z), columns, stress)


def _fibre_stress(forces: BarForces, area: float, levers: FloatArray) -> FloatArray:
    """Stress (k, fibres, 6, columns) of N and M_z; levers (fibres,) y/I, 1/mm3."""
    stress = np.zeros((len(forces.axial), len(levers), 6, forces.axial.shape[1]))
    stress[:, :, XX] = forces.axial[:, None] / area - levers[:, None] * forces.moment_z[:, None]
    return stress


def _add_fibres(
    points: Points,
    name: str,
    places: FloatArray,
    at: tuple[FloatArray, FloatArray],
    columns: list[int],
    stress: FloatArray,
) -> None:
    """Add fibres at y and z (fibres,) of the sections at places (k,)."""
    y, z = at
    x = np.repeat(places, len(y))
    found = np.column_stack([x, np.tile(y, len(places)), np.tile(z, len(places))])
    points.add_block(name, found, columns, stress.reshape(len(found), 6, -1))


def _add_cheek_fibres(
    points: Points, shape: ToggleBar, free: float, cheeks: Section, sections: SectionForces
) -> None:
    """Add the edges of the cheeks alone, from beside the knee's hole to where the walls begin."""
    if free <= shape.hole / 2:
        return
    places = np.linspace(shape.hole / 2, free, 4)
    columns, forces = sections.at(places)
    y = np.array([1.0, -1.0]) * shape.width / 2
    stress = _fibre_stress(forces, cheeks.area, y / cheeks.inertia_in_plane)
    _add_fibres(points, "cheeks", places, (y, np.full(2, shape.width / 2)), columns, stress)


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
    stress = factor * _fibre_stress(forces, cheeks.area, y / cheeks.inertia_in_plane)
    z = np.full(2, shape.width / 2 - shape.wall)
    _add_fibres(points, "cut-out corner", places, (y, z), columns, stress)
