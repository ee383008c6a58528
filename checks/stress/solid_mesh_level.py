"""A part solved on one mesh: its stress history, peaks and fatigue, over all cycles of a design.

Half of a part may stand for all of it; its results are then mirrored.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from checks.design.data import Part
from checks.part.part_loads import PartLoads
from checks.result.verdict import Surface
from checks.stress.kept_models import Models as Models
from checks.stress.pins_in_bores import Contact, PinnedBores
from checks.stress.stress_result import Stressed, depth_of, judge
from fem.convergence import ORDER
from fem.gradient import inward_normals
from fem.recovery import tensor, von_mises
from fem.singularity import (
    EdgePlaces,
    across_notches,
    concave_curvatures,
    edge_places,
    notch_error,
    pressed_edges,
    reentrant_edges,
)
from fem.stress_history import StressHistory
from fem.unit_loads import ACCELERATIONS, IN_PLANE, inertia_of, resultants
from fem.unit_solutions import UnitSolutions, bore_openings, even_columns
from geometry.mesh import SYMMETRY, FloatArray, IntArray, MassProperties, Mesh
from geometry.shape import Half, has_middle_plane
from geometry.sizing import element_sizes

_MISSED = 0.01  # of the stress in a notch: smaller errors stay as they are
# Of a groove's own stress: von Mises stress grows by so much at the most, where stress along it is
# of the other sign (2 over the root of 3).
_BIAXIAL = 1.155
# Share from which on all of the stress counts as across: a facet beside a point tells the groove's
# direction to some 30 degrees.
_ALONG = 0.5
_LITTLE = 0.02  # of a point's largest: swings below it, round-off too, damage nothing
_TOGETHER = 200  # points
_BESIDE = 3.0  # elements from an edge where a pressure ends, within which it disturbs the stress
_JUMP = 0.09  # of that pressure: the least scatter there (tests/fem/test_pressed_edges.py)
DISPLACEMENT = "displacement [mm]"
STRESS = "stress [MPa]"
INVERSE_SAFETY = "1 / fatigue safety"
_MIRRORED = {3: (1, 1, -1), 6: (1, 1, 1, 1, -1, -1)}  # x, y, z; xx, yy, zz, xy, yz, zx
_NOTHING = 1e-12  # of the largest force, and of force times length
MEANING = (
    "half of the part, mirrored at its middle plane: its loads have no part out of it; what is "
    "told at z > 0 has its mirror image. The first mesh is of the whole part"
)


@dataclass(frozen=True, eq=False, kw_only=True)
class Level(Stressed):
    """A part as a solid on one mesh.

    limits  at the surface points, notches included
    added   (n, 3) rigid-body acceleration field that balances foreign mass properties
    left_out  (k,) surface points whose stress counts nothing: at sharp edges judged apart
    contact   of pins whose fit is stated; `solutions` and the history are then those with it
    lasting   bore -> (n,) N of its even pressure that a bush pressed in makes
    """

    fineness: float
    solutions: UnitSolutions
    added: FloatArray
    left_out: IntArray = field(default_factory=lambda: np.array([], dtype=np.int64))
    contact: Contact | None = None
    lasting: Mapping[str, FloatArray] = field(default_factory=dict)

    @cached_property
    def lasting_states(self) -> FloatArray:
        """Coefficients (n_basis, n) of what bushes that are pressed in make."""
        state = np.zeros_like(self.coefficients)
        columns = even_columns(self.solutions)
        for bore, force in self.lasting.items():
            state[columns[bore]] = force
        return state

    @property
    def half(self) -> bool:
        """True if the mesh is half of the part."""
        return self.solutions.mesh.half

    @property
    def unknowns(self) -> int:
        """Number of unknowns of the mesh."""
        return 3 * len(self.solutions.mesh.nodes)

    @cached_property
    def edges(self) -> tuple[IntArray, FloatArray]:
        """Surface points on sharp re-entrant edges (n,), and the interior angles there, rad."""
        found = reentrant_edges(self.solutions.mesh)
        points = np.searchsorted(self.history.nodes, found.nodes)
        counted = ~np.isin(points, self.left_out)
        return points[counted], found.angles[counted]

    def stress_of(self, displacement: FloatArray) -> FloatArray:
        """Stress (n_points, 6, m) of displacement (3 n_nodes, m), mm, as it counts, MPa."""
        stress = self.solutions.recovery.surface_stress(displacement)
        stress[self.left_out] = 0.0
        return stress

    @cached_property
    def edge_places(self) -> EdgePlaces:
        """Places along the sharp re-entrant edges."""
        return edge_places(self.solutions.mesh)

    @cached_property
    def direct_stresses(self) -> dict[bytes, dict[float, FloatArray]]:
        """Stress (n, 6) that was solved besides the basis, by loads and arc in rad, MPa."""
        return {}

    @cached_property
    def _sizes(self) -> FloatArray:
        return element_sizes(self.solutions.mesh)

    @cached_property
    def notch_errors(self) -> FloatArray:
        """Errors (n,) of the stress at the surface points in notches, as shares of it."""
        elements, count = self.solutions.mesh.elements, len(self.solutions.mesh.nodes)
        met = np.bincount(elements.ravel(), minlength=count)
        sizes = np.repeat(self._sizes, elements.shape[1])
        mean = np.bincount(elements.ravel(), sizes, count) / np.maximum(met, 1)
        nodes = self.history.nodes
        errors = notch_error(mean[nodes], concave_curvatures(self.solutions.mesh)[nodes])
        some = np.flatnonzero(errors > _MISSED)
        across = across_notches(self.solutions.mesh)[nodes[some]]
        errors[some] *= self._share_across(some, across)
        return errors

    def _share_across(self, points: IntArray, across: FloatArray) -> FloatArray:
        """Share (n,) of the stress at points that acts across a groove; 1 where there is none.

        Of the largest stress and of the largest swing about its mean on any path of the duty,
        whichever is more.
        """
        coefficients = self.history.coefficients
        runs = () if self.duty is None else self.duty.runs.values()
        paths = [coefficients[:, run] for run in runs]
        swings = [path - path.mean(axis=1, keepdims=True) for path in paths]
        shares = np.ones(len(points))
        grooves = np.flatnonzero(across.any(axis=1))
        for some in np.array_split(grooves, range(_TOGETHER, len(grooves), _TOGETHER)):
            basis, normal = self.history.basis[points[some]], across[some]
            traction = np.einsum("pmij,pj->pim", tensor(basis.swapaxes(1, 2)), normal)
            pulled = np.einsum("pim,pi->pm", traction, normal)
            parts, wholes = np.zeros((2, 1 + len(swings), len(some)))
            for k, states in enumerate((coefficients, *swings)):
                acts = 3 * ((traction @ states) ** 2).sum(axis=1) - 2 * (pulled @ states) ** 2
                wholes[k] = StressHistory(
                    self.history.nodes[points[some]],
                    self.history.points[points[some]],
                    basis,
                    states,
                ).peaks_by_point()
                parts[k] = np.sqrt(np.maximum(acts.max(axis=1), 0.0))
            counts = wholes > _LITTLE * wholes.max(axis=0)
            most = np.divide(parts, wholes, out=np.zeros_like(parts), where=counts).max(axis=0)
            found = _BIAXIAL * most
            shares[some] = np.where(found < _ALONG, found, 1.0)
        return shares

    @property
    def missed_in_notches(self) -> FloatArray:
        """Largest of them (n_elements,) at the nodes of each element."""
        mesh = self.solutions.mesh
        of_nodes = np.zeros(len(mesh.nodes))
        np.maximum.at(of_nodes, self.history.nodes, self.notch_errors)
        return np.asarray(of_nodes[mesh.elements].max(axis=1))

    @cached_property
    def in_bores(self) -> IntArray:
        """Surface points (n,) in the holes that pins press on as it is assumed."""
        faces = [unit.interface for unit in self.solutions.interfaces]
        bores = [face.name for face in faces if face.kind == "bore"]
        return self.in_bores_of(*(name for name in bores if name not in self.solved_bores))

    def in_bores_of(self, *bores: str) -> IntArray:
        """Surface points (n,) in some holes."""
        surfaces = self.solutions.mesh.surfaces
        pressed = np.zeros(len(self.history.nodes), dtype=bool)
        for unit in self.solutions.interfaces:
            for name in unit.interface.surfaces if unit.interface.name in bores else ():
                pressed |= np.isin(self.history.nodes, surfaces[name])
        return np.flatnonzero(pressed)

    @property
    def solved_bores(self) -> Collection[str]:
        """Names of the bores whose pressure is solved."""
        return () if self.contact is None else self.contact.pins.fits

    def size_at(self, point: int) -> float:
        """Mean size of the elements that meet at a surface point, mm."""
        meet = (self.solutions.mesh.elements == self.history.nodes[point]).any(axis=1)
        return float(self._sizes[meet].mean())

    def nearest(self, place: FloatArray) -> int:
        """Return the surface point nearest to a place (3,); half of a part has that at z >= 0."""
        if self.half:
            place = np.array([place[0], place[1], abs(place[2])])
        return int(((self.history.points - place) ** 2).sum(axis=1).argmin())

    def named(self, point: int) -> str:
        """Names of the surfaces that meet at a point."""
        return "/".join(self._surfaces_at(point)) or "surface"

    def depth(self, point: int) -> tuple[float, float] | None:
        """Least and largest |z| of its first named surface on the point's side, mm."""
        names = self._surfaces_at(point)
        if not names:
            return None
        mesh = self.solutions.mesh
        heights = mesh.nodes[np.unique(mesh.surfaces[names[0]]), 2]
        return depth_of(heights, float(self.history.points[point, 2]))

    def _surfaces_at(self, point: int) -> list[str]:
        node = self.history.nodes[point]
        return [
            name
            for name, facets in self.solutions.mesh.surfaces.items()
            if name != SYMMETRY and np.any(facets == node)
        ]

    def load_residual(self, loads: PartLoads) -> float:
        """Force and moment that reached the mesh less those asked for, over the largest force.

        Per interface and position; moments over the interface's radius or the part's size. Of half
        of a part, twice what reached it in its plane.
        """
        worst, column = 0.0, 0
        size = float(np.ptp(self.solutions.mesh.nodes, axis=0).max())
        for unit in self.solutions.interfaces:
            columns = slice(column, column + len(unit.names))
            column = columns.stop
            reached = (
                resultants(self.solutions.elements, unit.vectors, unit.interface.centre)
                @ self.coefficients[columns]
            )
            reached /= self.solutions.mesh.share
            missing = np.abs(reached - loads.wrenches[unit.interface.name].T)
            if self.half:
                missing[2:5] = 0.0  # the cut balances them
            if unit.interface.name == loads.tilt_held_at:
                missing[3:5] = 0.0  # it takes what inertia leaves, too; reactions tell if enough
            missing[3:] /= unit.interface.radius or size
            worst = max(worst, float(missing.max()))
        return worst / loads.largest_force if loads.largest_force else worst

    def balance_residual(self, loads: PartLoads, properties: MassProperties) -> float:
        """Resultant of the loads before the added field closed it, over the largest force.

        Interface loads and the inertia of the mass properties that the linkage was solved with
        balance by themselves; what the mesh's own differ from these by is taken off. This is the
        test of everything between the linkage and the mesh.
        """
        first = len(self.coefficients) - len(ACCELERATIONS)
        units = self.solutions.unit_resultants[IN_PLANE, first:] / self.solutions.mesh.share
        left = units[:, :3] @ self.added.T
        left += (units - inertia_of(properties)) @ loads.accelerations.T
        left[2] /= float(np.ptp(self.solutions.mesh.nodes, axis=0).max())
        left = np.abs(left)
        return float(left.max()) / (loads.largest_force or 1.0)

    def reaction_residual(self, loads: PartLoads) -> float:
        """Largest support reaction over the largest force: the support must carry nothing."""
        reactions = np.abs(self.solutions.reactions(self.coefficients))
        return float(reactions.max()) / (loads.largest_force or 1.0)

    @cached_property
    def _pressed_edges(self) -> FloatArray:
        """Places (n, 3) of the nodes on edges where a pressure ends, mm."""
        mesh = self.solutions.mesh
        return mesh.nodes[pressed_edges(mesh)]

    def order(self, point: int) -> float:
        """With which stress at a surface point converges: 1 beside an edge where a pressure ends.

        The judged point there is the nearest that the edge does not spoil, and moves towards it.
        """
        return 1.0 if self._beside_pressed_edge(point) else ORDER

    def _beside_pressed_edge(self, point: int) -> bool:
        if not len(self._pressed_edges):
            return False
        place = self.history.points[self.solutions.recovery.stands_for[point]]
        away = np.linalg.norm(self._pressed_edges - place, axis=1).min()
        return bool(away < _BESIDE * self.size_at(point))

    def scatter(self, coefficients: FloatArray, point: int, *, of_edges: bool = True) -> float:
        """Scatter of the elements that meet at a point under some load state, MPa.

        of_edges  whether it is, beside an edge where a pressure ends, not less than a share of that
                  pressure, which finer meshes leave
        """
        displacement = self.solutions.moved(coefficients)
        found = self.solutions.recovery.scatter(displacement, np.array([point]))[0]
        if not (of_edges and self._beside_pressed_edge(point)):
            return float(found)
        points = self.history.points
        near = np.linalg.norm(points - points[point], axis=1) < _BESIDE * self.size_at(point)
        normals = inward_normals(self.solutions.mesh)[near]
        stress = tensor(self.history.basis[near] @ coefficients)
        pressure = np.abs(np.einsum("pi,pij,pj->p", normals, stress, normals)).max()
        return float(max(found, _JUMP * pressure))


def solve_level(
    solutions: UnitSolutions,
    fineness: float,
    loads: PartLoads,
    endurance_limit: float,
    ultimate_stress: float,
    duty: Mapping[str, float],
    notch_factors: Mapping[str, float] | None = None,
    pins: PinnedBores | None = None,
) -> Level:
    """Superpose the cycle on solved unit loads; fatigue over the cycles of the duty.

    notch_factors  surface -> factor by which fatigue notch or fretting lowers the endurance limit
    pins           bores of `solutions` whose pins have a fit

    Raises ContactError and MeshError where pins have no contact.
    """
    coefficients, added, lasting = coefficients_of(solutions, loads)
    contact = None if pins is None else replace(pins, lasting=lasting).contact(coefficients)
    if contact is not None:
        solutions, coefficients = contact.solutions, contact.coefficients
    nodes = solutions.recovery.points
    history = StressHistory(nodes, solutions.mesh.nodes[nodes], solutions.basis, coefficients)
    limits = np.full(len(nodes), endurance_limit)
    for surface, factor in (notch_factors or {}).items():
        notched = np.isin(nodes, solutions.mesh.surfaces[surface])
        limits[notched] = np.minimum(limits[notched], endurance_limit / factor)
    judged = judge(history, limits, endurance_limit, ultimate_stress, loads, duty)
    return Level(
        fineness=fineness,
        solutions=solutions,
        added=added,
        **judged,
        contact=contact,
        lasting=lasting,
    )


def coefficients_of(
    solutions: UnitSolutions, loads: PartLoads
) -> tuple[FloatArray, FloatArray, dict[str, FloatArray]]:
    """Coefficients (n_basis, n) of the unit loads, what inertia was added (n, 3), what lasts.

    What lasts, in both, is the even pressure (n,), N of its unit load by bore, of bushes that are
    pressed in: as the interference has it with how much this mesh's bore gives way, and more where
    the loads close the bore.
    """
    coefficients, added = solutions.coefficients(
        loads.wrenches, loads.accelerations, loads.reaches, loads.tilt_held_at
    )
    columns, lasting = even_columns(solutions), {}
    for bore, fit in loads.press_fits.items():
        interface, openings = solutions.mesh.interfaces[bore], bore_openings(solutions, bore)
        own = columns[bore]
        per_pressure = fit.per_pressure(interface.length)
        lug, openings[own] = float(openings[own]) * per_pressure, 0.0
        even = coefficients[own] / per_pressure
        lasting[bore] = per_pressure * fit.pressures(lug, openings @ coefficients, even)
    for bore, force in lasting.items():
        coefficients[columns[bore]] += force
    return coefficients, added, lasting


def peak_of(stress: FloatArray) -> float:
    """Largest von Mises stress of surface stresses (n_points, 6), MPa."""
    return float(von_mises(stress).max())


def half_of(part: Part, loads: PartLoads) -> Half | None:
    """Return the half that answers for a part, if its shape and its loads over all cycles allow it.

    A part moves in its plane: its accelerations have no part out of it. Wrenches may not have any.
    """
    shape = part.geometry
    if not has_middle_plane(shape):
        return None
    largest = max(float(np.abs(wrench[:, :3]).max()) for wrench in loads.wrenches.values())
    for wrench in loads.wrenches.values():
        force = float(np.abs(wrench[:, 2]).max())
        couple = float(np.abs(wrench[:, 3:5]).max())
        if force > _NOTHING * largest or couple > _NOTHING * largest * shape.length:
            return None
    return Half(shape)


def shown_surface(loads: PartLoads, level: Level) -> Surface:
    """Stress at the worst position and 1 over the fatigue safety, on six-node facets split in four.

    The safety is for an endless life by Goodman and Findley, over all cycles of the duty.
    Of the whole part, also where a half was solved.
    """
    nodes = level.history.nodes
    triangles = surface_triangles(level.solutions.mesh, nodes)
    state = level.coefficients[:, level.peak.position]
    displacement = level.solutions.moved(state).reshape(-1, 3)[nodes]
    stress = level.history.at(level.peak.position)
    fields = {"von Mises [MPa]": von_mises(stress)}
    if level.duty is not None:
        fields[INVERSE_SAFETY] = level.duty.everywhere.utilisation
    directed = {DISPLACEMENT: displacement, STRESS: stress}
    surface = Surface(level.history.points, triangles, fields, level.peak.point, directed)
    if not level.half:
        return surface
    return _mirrored(surface, np.isin(nodes, level.solutions.mesh.cut_nodes))


def mode_surface(mesh: Mesh, nodes: IntArray, moved: FloatArray, size: FloatArray) -> Surface:
    """The surface of a whole part as a mode displaces it.

    nodes (n,) on the surface; moved (n_nodes, 3) mm and size (n_nodes,) of the whole mesh
    """
    places = mesh.nodes[nodes] + moved[nodes]
    fields = {"buckling mode": size[nodes]}
    return Surface(places, surface_triangles(mesh, nodes), fields, int(size[nodes].argmax()))


def surface_triangles(mesh: Mesh, nodes: IntArray) -> IntArray:
    """Six-node facets of the boundary split in four, (n, 3) indices of the surface nodes."""
    split = mesh.boundary[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]].reshape(-1, 3)
    return np.searchsorted(nodes, split)


def _mirrored(surface: Surface, on_cut: npt.NDArray[np.bool_]) -> Surface:
    """Return a half's surface with its mirror image; points on the cut belong to both."""
    nodes, triangles, beside = mirrored(surface.nodes, surface.triangles, on_cut)
    return Surface(
        nodes,
        triangles,
        {name: both_sides(values, beside) for name, values in surface.fields.items()},
        surface.peak,
        {name: both_sides(values, beside) for name, values in surface.directed.items()},
    )


def both_sides(values: FloatArray, beside: IntArray) -> FloatArray:
    """Values (n,), vectors (n, 3) or stress (n, 6) at the nodes, then at the mirror image.

    beside  nodes that the image is of, as `mirrored` tells them
    """
    signs = _MIRRORED[values.shape[1]] if values.ndim > 1 else 1.0
    return np.concatenate([values, values[beside] * signs])


def mirrored(
    nodes: FloatArray, triangles: IntArray, on_cut: npt.NDArray[np.bool_]
) -> tuple[FloatArray, IntArray, IntArray]:
    """Nodes and triangles of a half with its mirror image, and which nodes the image is of.

    on_cut  (n,) whether a node is on the cut, and so in both
    """
    count, beside = len(nodes), np.flatnonzero(~on_cut)
    image = np.arange(count)
    image[beside] = count + np.arange(len(beside))
    return (
        np.concatenate([nodes, nodes[beside] * [1, 1, -1]]),
        np.concatenate([triangles, image[triangles[:, ::-1]]]),
        beside,
    )
