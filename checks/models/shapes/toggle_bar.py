"""Square tubes with pin holes through two walls, by formula.

Its cheeks may spread apart beside a pin: they are plates that the side walls hold at their edges.
Where the side walls are cut away a cheek's edges are free; behind them the edges stand still and
turn together with the side walls, which are plates, too. By symmetry half a cheek and half a side
wall, laid out in one plane, buckle as one. Their stress is the lug's (pin_loaded_hole); the side
wall has as much as the edge beside it. Deflections are products of cubics on a grid (Bogner, Fox
and Schmit 1965); points within the hole have no stiffness. Kirchhoff's plates, with E t^3/(12 (1 -
nu^2)) (Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., 8.1).

The side walls' ends give way where they begin to hold the cheek. They count from half a wall behind
the cut-out's end, which is chosen: of solids of 18 bars the share is 0.87 to 1.10 of this.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from math import pi

import numpy as np

from checks.design.data import Part
from checks.handbook.lateral_buckling import cubics
from checks.handbook.lug_stress import Lug, stepped_bar, strip_outline
from checks.handbook.pin_loaded_hole import pin_loaded_hole
from checks.models.formula_bars import (
    BarPart,
    SectionForces,
    Stretches,
    add_fibres,
    add_tube_fibres,
    fibre_stress,
)
from checks.models.formula_points import Points, add_bore, strip_edges
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import RungModel
from fem.unit_loads import bearing_coefficients, harmonics_of
from geometry.bars import BESIDE, Section, fine_cells, plate_section, square_tube_section
from geometry.mesh import FloatArray, IntArray
from geometry.parts import ToggleBar

_STATIONS = 9
_GIVES = 0.5  # of the wall: how far behind the cut-out's end the side walls hold
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_ACROSS, _WALL = 4, 2  # elements of half a cheek and of half a side wall
_ALONG = 5  # elements on a tube's width, beside hole and cut-out
_EMPTY = 1e-5  # of the stiffness, left to what is in the hole
_EDGE = 1e-3  # of the wall: round-off of a cheek's inner face
_UNLOADED = 1e-9  # of the largest eigenvalue: round-off

# Stress xx, yy and xy (k, 3) of a cheek at places (k,), MPa per N of the pin's push.
Stress = Callable[[FloatArray, FloatArray], FloatArray]


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
        local=partial(spreading, shape, part.material.youngs_modulus, nu),
        stretch=partial(spread_mode, shape, nu),
        neglects="bending of the walls across themselves; that the side walls lag in taking their "
        "share",
    )


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


@dataclass(frozen=True, eq=False)
class _Grid:
    """Lines of the plates laid out, mm; each node has w, slopes across and along, mixed second one.

    along   (m,) from the bar's end, 0 at the pin
    across  (k,) from the cheek's middle over its edge to the side wall's middle
    held    mm along, from where the side walls hold the edge
    """

    along: FloatArray
    across: FloatArray
    held: float

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of lines."""
        return len(self.along), len(self.across)

    @property
    def free(self) -> IntArray:
        """Unknowns that may move; the far end is held."""
        count, lines = self.shape
        held = np.zeros((count, lines, 4), bool)
        held[:, [0, -1], 1] = held[:, [0, -1], 3] = True  # symmetric about both middles
        behind = self.along >= self.held
        held[behind, _ACROSS, 0] = held[behind, _ACROSS, 2] = True
        held[~behind, _ACROSS + 1 :] = True
        held[-1] = True
        return np.flatnonzero(~held)

    def field(
        self, unknowns: FloatArray, x: FloatArray, y: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Deflection w (n,) and its slopes along and across at places; 0 beyond the far end."""
        i, s, along = _within(self.along, np.maximum(x, self.along[0]))
        j, t, across = _within(self.across, y)
        a, p, b, q = np.indices((2, 2, 2, 2)).reshape(4, 16)
        index = 4 * ((i[:, None] + a) * len(self.across) + j[:, None] + b) + 2 * p + q
        own = unknowns[index].reshape(-1, 4, 4) * (x <= self.along[-1])[:, None, None]
        w, along_slope, across_slope = (
            np.einsum("na,nab,nb->n", cubics(s, along, n), own, cubics(t, across, m))
            for n, m in ((0, 0), (1, 0), (0, 1))
        )
        return w, along_slope, across_slope


def _within(lines: FloatArray, places: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Element of each place (n,) between lines, its share of it, and the element's size."""
    element = np.clip(np.searchsorted(lines, places) - 1, 0, len(lines) - 2)
    size = np.diff(lines)[element]
    return element, np.clip((places - lines[element]) / size, 0.0, 1.0), size


def spreading(shape: ToggleBar, young: float, poisson_ratio: float) -> float | None:
    """Share of their buckling load that 1 N of the pin's push is on the cheeks at the knee, 1/N.

    None where less than a wall is left between the hole and the side wall: no plate.
    """
    found = _lowest(shape, poisson_ratio)
    return None if found is None else found[0] / young


def spread_mode(shape: ToggleBar, poisson_ratio: float, nodes: FloatArray) -> FloatArray:
    """Displacements (n, 3) of nodes (n, 3) mm of a bar whose cheeks spread, of free size.

    Walls move outwards by w of their middle planes, and turn by its slopes. A cheek beyond its edge
    at the side wall's middle goes straight on.

    Raises ValueError for a shape without a share (`spreading`).
    """
    found = _lowest(shape, poisson_ratio)
    if found is None:
        raise ValueError("what is beside the hole is no plate: it has no mode")
    _, grid, unknowns = found
    half = (shape.width - shape.wall) / 2
    x, (y, z) = nodes[:, 0], np.abs(nodes[:, 1:]).T
    cheek = z > half - (0.5 + _EDGE) * shape.wall
    across = np.where(cheek, np.minimum(y, half), 2 * half - np.minimum(z, half))
    aside, along, over = grid.field(unknowns, x, across)
    aside = aside + np.where(cheek, np.maximum(y - half, 0.0), 0.0) * over
    outer, outwards = np.where(cheek, z, y) - half, np.sign(nodes[:, 1:])
    within = np.where(cheek, -outer * over, outer * over)  # away from the bar's axis
    moved = np.where(cheek, [within, aside], [aside, within]).T * outwards
    return np.column_stack([-outer * along, moved])


@lru_cache(64)  # bars of one size, and their variations in other dimensions than the part's
def _lowest(shape: ToggleBar, poisson_ratio: float) -> tuple[float, _Grid, FloatArray] | None:
    """Share of 1 N at a Young's modulus of 1 MPa, the plates laid out, and the mode on them.

    The mode by its unknowns. None without a plate.
    """
    lug = lug_at(shape, "knee", poisson_ratio)
    beside = shape.width / 2 - shape.wall - shape.hole / 2
    if beside < shape.wall:
        return None
    grid = _grid(shape)
    push = np.array([[1.0, 0.0, 0.0]])
    own = bearing_coefficients(push, inward=False)[0]
    area = 4 * (shape.width - shape.wall) * shape.wall
    cut = solved_to(shape)
    edge = shape.width / 2 * (1 - 1e-3)

    def stress(x: FloatArray, y: FloatArray) -> FloatArray:
        scaled = np.minimum(y * shape.width / (shape.width - shape.wall), edge)
        found = lug.stress(np.minimum(x, cut) + 1j * scaled) @ own
        found[x > cut] = -1 / area, 0.0, 0.0
        return np.asarray(found)

    elastic, loaded = _matrices(shape, grid, stress, poisson_ratio)
    free = grid.free
    lower = np.linalg.cholesky(elastic[np.ix_(free, free)])
    half = np.linalg.solve(lower, loaded[np.ix_(free, free)])
    values, modes = np.linalg.eigh(-np.linalg.solve(lower, half.T))
    largest = float(values[-1])
    unknowns = np.zeros(len(elastic))
    unknowns[free] = np.linalg.solve(lower.T, modes[:, -1])
    share = largest if largest > _UNLOADED * float(np.abs(values).max()) else 0.0
    return share, grid, unknowns


def solved_to(shape: ToggleBar) -> float:
    """How far from a hole's axis the stress about it is solved, mm."""
    return max(min(BESIDE * shape.width, shape.length / 2), shape.hole)


def _grid(shape: ToggleBar) -> _Grid:
    size, radius = shape.width - shape.wall, shape.hole / 2
    held = shape.cutout_length - shape.overhang + _GIVES * shape.wall
    beside = max(held, radius)
    far = beside + size
    marks = {-radius, 0.0, radius, held, beside + size / 2}
    marks = {mark for mark in marks if -shape.overhang < mark < far}
    along = [-shape.overhang]
    for mark in sorted(marks):
        count = int(np.ceil((mark - along[-1]) * _ALONG / size - 1e-9))
        along += np.linspace(along[-1], mark, max(1, count) + 1)[1:].tolist()
    along += np.linspace(along[-1], far, 3)[1:].tolist()
    across = np.r_[
        np.linspace(0.0, size / 2, _ACROSS + 1), np.linspace(size / 2, size, _WALL + 1)[1:]
    ]
    return _Grid(np.array(along), across, held)


def _matrices(
    shape: ToggleBar,
    grid: _Grid,
    stress: Stress,
    poisson_ratio: float,
) -> tuple[FloatArray, FloatArray]:
    """Elastic stiffness at 1 MPa, and the stress's own per N; both of all unknowns."""
    wall, radius = shape.wall, shape.hole / 2
    bending = wall**3 / 12 / (1 - poisson_ratio**2)
    x, x_weight, in_x = _along_lines(grid.along)
    y, y_weight, in_y = _along_lines(grid.across)
    on_wall = np.arange(len(y)) >= _ACROSS
    i, j = np.nonzero(~on_wall | (grid.along[1:, None] > grid.held))
    at_x, at_y = np.repeat(x[i], y.shape[1], axis=1), np.tile(y[j], (1, x.shape[1]))
    area = (x_weight[i][:, :, None] * y_weight[j][:, None]).reshape(at_x.shape)
    of_wall = on_wall[j][:, None]
    solid = of_wall | (np.hypot(at_x, at_y) > radius)
    # a side wall has as much along as the edge beside it
    beside = np.where(of_wall, grid.across[_ACROSS], at_y)
    acting = stress(at_x.ravel(), beside.ravel()).reshape(*at_x.shape, 3)
    acting[on_wall[j], :, 1:] = 0.0

    def field(a: int, b: int) -> FloatArray:
        pair = np.einsum("ngp,nhq->nghpq", in_x[a][i], in_y[b][j])
        return np.asarray(pair.reshape(*at_x.shape, 16))

    def summed(first: FloatArray, weight: FloatArray, second: FloatArray) -> FloatArray:
        return np.asarray(np.matmul((first * weight[..., None]).swapaxes(1, 2), second))

    bent_x, bent_y, twisted, slope_x, slope_y = (
        field(a, b) for a, b in ((2, 0), (0, 2), (1, 1), (1, 0), (0, 1))
    )
    weight = area * bending * np.where(solid, 1.0, _EMPTY)
    both = summed(bent_x, weight, bent_y)
    own = summed(bent_x, weight, bent_x) + summed(bent_y, weight, bent_y)
    own += poisson_ratio * (both + both.swapaxes(1, 2))
    own += 2 * (1 - poisson_ratio) * summed(twisted, weight, twisted)
    force = (area * solid * wall)[..., None] * acting
    crossed = summed(slope_x, force[..., 2], slope_y)
    work = summed(slope_x, force[..., 0], slope_x) + summed(slope_y, force[..., 1], slope_y)
    work += crossed + crossed.swapaxes(1, 2)
    # cubics along and across: (value, slope) at the start, then at the end
    a, p, b, q = np.indices((2, 2, 2, 2)).reshape(4, 16)
    index = 4 * ((i[:, None] + a) * len(grid.across) + j[:, None] + b) + 2 * p + q
    count = 4 * grid.shape[0] * grid.shape[1]
    elastic, loaded = np.zeros((count, count)), np.zeros((count, count))
    place = index[:, :, None], index[:, None]
    np.add.at(elastic, place, own)
    np.add.at(loaded, place, work)
    return elastic, loaded


def _along_lines(lines: FloatArray) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
    """Gauss points (m, 4) between neighbouring lines, their lengths (m, 4), and the cubics there.

    The cubics (m, 4, 4) stand with their first and second slopes.
    """
    size = np.diff(lines)
    shares = np.tile((1 + _POINTS) / 2, len(size))
    sizes = np.repeat(size, len(_POINTS))
    values = [cubics(shares, sizes, n).reshape(len(size), len(_POINTS), 4) for n in range(3)]
    points = lines[:-1, None] + size[:, None] * (1 + _POINTS) / 2
    return points, size[:, None] * _WEIGHTS / 2, values


MODEL = ShapeModel(ToggleBar, stress, press_fits=True, arcs=True)
