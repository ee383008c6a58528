"""A sheet's stress under unit loads, solved once, and what each is worth over the cycle.

As fem/unit_solutions.py does for solids: loads of all interfaces and of four rigid-body
accelerations on a support that just stops the sheet from moving; loads in balance need no reaction
there. Interfaces that tilt also take couples about x and y, by the sheet's bending as a plate
(fem/plane_bending.py). The regions of a stack share their displacement along y.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from fem.plane import PlaneModel
from fem.plane_bending import BentSheet
from fem.plane_bores import PlaneLoads, acceleration_vectors, plane_loads, plane_resultants
from fem.plane_elements import EdgeQuadrature
from fem.solvers import Factor, factorize
from fem.unit_solutions import Elastic
from geometry.mesh import FloatArray, IntArray, Interface, MeshError
from geometry.plane_outlines import SheetMesh

_PLANAR = [0, 1, 5]
_REFUSED = 1e-9  # of a wrench: what may act along z


@dataclass(frozen=True, eq=False)
class SheetModel(PlaneModel):
    """Plane stress in a sheet whose thickness varies inside of its elements, too.

    Were it even in each, the force that flows along a round edge would jump from one to the next.

    depth  points (n, 2) -> mm (n,)
    """

    depth: Callable[[FloatArray], FloatArray] = field(kw_only=True)

    @cached_property
    def depths(self) -> FloatArray:
        """Thickness at the integration points, (n_elements, n_q) mm."""
        points = self.elements.points
        found = self.depth(points.reshape(-1, 2)).reshape(points.shape[:2])
        if not found.min() > 0:
            raise MeshError(f"a sheet's thickness must be above 0 mm, got {found.min():.3g}")
        return found

    def _edge_depths(self, name: str, edge: EdgeQuadrature) -> FloatArray:
        found = self.depth(edge.points.reshape(-1, 2)).reshape(edge.points.shape[:2])
        if not found.min() > 0:
            raise MeshError(f"edge {name!r} has no thickness in places")
        return found


@dataclass(frozen=True, eq=False)
class PlaneUnitSolutions:
    """Solved unit loads of a sheet.

    interfaces    in the order of their columns; then a_x, a_y, alpha, omega^2; then the couples
    loads         (2 n_nodes, n_flat) N, without the couples
    displacement  (2 n_nodes, n_flat) mm
    bent          (3 n_nodes, n_couples) mm and rad: M_x, M_y of each interface that tilts
    held          (3,) unknowns held still
    """

    sheet: SheetMesh
    model: PlaneModel
    plate: BentSheet
    interfaces: tuple[PlaneLoads, ...]
    loads: FloatArray
    displacement: FloatArray
    bent: FloatArray
    bent_reactions: FloatArray
    held: IntArray
    factor: Factor
    gather: sp.csr_array
    material: Elastic

    @property
    def unknowns(self) -> int:
        """How many were solved for."""
        return int(self.gather.shape[1]) + len(self.bent)

    @cached_property
    def resultants(self) -> FloatArray:
        """Force and moment about the frame's origin of every flat load, (3, n_flat)."""
        return plane_resultants(self.model.mesh.nodes, self.loads, np.zeros(2))

    @property
    def tilting(self) -> list[str]:
        """Names of the interfaces that take couples about x and y."""
        return [loads.interface.name for loads in self.interfaces if loads.interface.tilts]

    def coefficients(
        self,
        wrenches: Mapping[str, FloatArray],
        accelerations: FloatArray,
        reaches: Mapping[str, FloatArray],
        tilt_held_at: str | None,
        *,
        flat: bool,
    ) -> tuple[FloatArray, FloatArray]:
        """Coefficients (n_basis, n), and the acceleration field (n, 3) that closes the balance.

        flat  whether to leave out the columns of the couples
        """
        columns = []
        for loads in self.interfaces:
            wrench, name = np.asarray(wrenches[loads.interface.name]), loads.interface.name
            columns.append(loads.coefficients(wrench[:, _PLANAR], reaches.get(name)))
        columns.append(np.asarray(accelerations))
        coefficients = np.concatenate(columns, axis=1).T
        first = len(coefficients) - 4
        balance = self.resultants
        added = -np.linalg.solve(balance[:, first : first + 3], balance @ coefficients)
        coefficients[first : first + 3] += added
        if not flat:
            couples = self._couples(wrenches, tilt_held_at)
            coefficients = np.concatenate([coefficients, couples])
        return coefficients, np.asarray(added.T)

    def _couples(self, wrenches: Mapping[str, FloatArray], held_at: str | None) -> FloatArray:
        """Couples about x and y of the interfaces that tilt, (n_couples, n), in balance."""
        rows = [np.asarray(wrenches[name])[:, 3:5].T for name in self.tilting]
        couples = np.concatenate(rows)
        left = sum(rows)
        at = self.tilting.index(held_at) if held_at in self.tilting else 0
        couples[2 * at : 2 * at + 2] -= left
        return couples

    def stress_basis(self, places: IntArray, *, flat: bool) -> FloatArray:
        """Stress xx, yy, xy at places of the sheet, (n, 3, n_basis), MPa per unit.

        Of the flat loads through the thickness, of the couples on the face z = +t/2.
        """
        stress = self.flat_stress(places, self.displacement)
        if flat:
            return stress
        return np.concatenate([stress, self._at(places, self.plate.face_stress(self.bent))], axis=2)

    def flat_stress(self, places: IntArray, displacement: FloatArray) -> FloatArray:
        """Stress xx, yy, xy at places of the sheet, (n, 3, m), of displacement (2 n_nodes, m)."""
        return self._at(
            places, self.model.recovery.quadrature_stress(displacement)[:, :, [0, 1, 3]]
        )

    def _at(self, places: IntArray, stress: FloatArray) -> FloatArray:
        count, points, parts, columns = stress.shape
        averaged = self._averaging[places] @ stress.reshape(count * points, parts * columns)
        return np.asarray(averaged.reshape(len(places), parts, columns))

    @cached_property
    def _averaging(self) -> sp.csr_array:
        """Stress at the sheet's places of that at integration points, (n_sides, e q).

        The rule of recovery.py: linear continuation in each element, and the mean of the elements
        that meet at a place with their volumes as weights.
        """
        sides = self.sheet.side_of
        volumes = self.model.recovery.volumes.sum(axis=1)
        each = np.broadcast_to(volumes[:, None], sides.shape)
        total = np.bincount(sides.ravel(), each.ravel())
        share = (each / total[sides])[:, :, None] * self.model.elements.continuation
        count, points = len(sides), share.shape[2]
        columns = (points * np.arange(count)[:, None, None] + np.arange(points)) + np.zeros(
            (1, 6, 1), dtype=np.int64
        )
        rows = np.broadcast_to(sides[:, :, None], share.shape)
        return sp.coo_array(
            (share.ravel(), (rows.ravel(), columns.ravel())), (len(total), count * points)
        ).tocsr()

    def element_error(self, state: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Von Mises stress of a load state and its estimated error in every element, MPa.

        state (n_basis,). Returns (stress, error) (e,), and the elements' scatter (n_sides,) about
        the recovered stress. Zienkiewicz and Zhu (1987) as in fem/error_estimate.py; of a bent
        sheet on the face where the couples add up with the rest the more.
        """
        n_flat = self.displacement.shape[1]
        base = self.model.recovery.quadrature_stress(self.displacement @ state[:n_flat, None])
        raw = base[:, :, [0, 1, 3], 0]
        if len(state) > n_flat:
            tilt = self.plate.face_stress(self.bent @ state[n_flat:, None])[..., 0]
            above, below = (von_mises_flat(raw + sign * tilt).max() for sign in (1, -1))
            raw = raw + (tilt if above >= below else -tilt)
        sides, elements = self.sheet.side_of, self.model.elements
        smooth = (self._averaging @ raw.reshape(-1, 3))[sides]  # (e, 6, 3)
        inside = np.einsum("qa,eak->eqk", elements.values, smooth)
        volumes = self.model.recovery.volumes
        away = von_mises_flat(inside - raw) ** 2
        error = np.sqrt((away * volumes).sum(axis=1) / volumes.sum(axis=1))
        at_nodes = np.einsum("aq,eqk->eak", elements.continuation, raw) - smooth
        weights = np.broadcast_to(volumes.sum(axis=1)[:, None], sides.shape).ravel()
        squares = np.bincount(sides.ravel(), weights * von_mises_flat(at_nodes).ravel() ** 2)
        scatter = np.sqrt(squares / np.bincount(sides.ravel(), weights))
        return von_mises_flat(raw).max(axis=1), error, scatter

    def reactions(self, coefficients: FloatArray) -> FloatArray:
        """Reactions (6 or 3, n) of the supports, N."""
        n_flat = self.displacement.shape[1]
        needed = self.gather.T @ (self.model.stiffness @ self.displacement - self.loads)
        flat = needed[self.held] @ coefficients[:n_flat]
        if len(coefficients) == n_flat:
            return np.asarray(flat)
        return np.concatenate([flat, self.bent_reactions @ coefficients[n_flat:]])

    def solve(self, loads: FloatArray) -> FloatArray:
        """Displacement (2 n_nodes, m) of other nodal forces under the same hold."""
        return _solved(self.factor, self.gather, self.held, loads)


def von_mises_flat(stress: FloatArray) -> FloatArray:
    """Von Mises stress of plane stress (..., 3): xx, yy, xy."""
    xx, yy, xy = np.moveaxis(stress, -1, 0)
    return np.asarray(np.sqrt(xx**2 + yy**2 - xx * yy + 3 * xy**2))


def solve_plane_loads(
    sheet: SheetMesh, interfaces: Sequence[Interface], material: Elastic
) -> PlaneUnitSolutions:
    """Solve the unit loads of a sheet.

    Raises MeshError if a load cannot be brought onto the mesh, SolverError if the equations cannot
    be solved.
    """
    model = SheetModel(
        sheet.mesh,
        material.youngs_modulus,
        material.poisson_ratio,
        "stress",
        thickness=sheet.thickness,
        depth=sheet.depth,
    )
    on = tuple(plane_loads(model, interface) for interface in interfaces)
    inertia = acceleration_vectors(model, material.density)
    loads = np.concatenate([*(unit.vectors for unit in on), inertia], axis=1)
    gather = _gather(sheet)
    held = _hold(sheet, gather)
    reduced = (gather.T @ model.stiffness @ gather).tocsr()
    free = np.setdiff1d(np.arange(reduced.shape[0]), held)
    factor = factorize(sp.triu(reduced[free][:, free], format="csr"))
    plate = BentSheet(model)
    tilting = [unit for unit in on if unit.interface.tilts]
    bent, reactions = np.zeros((0, 0)), np.zeros((0, 0))
    if tilting:
        couples = [
            sign * unit.vectors[:, [unit.names.index(name)]]
            for unit in tilting
            for name, sign in (("sin 1", -1.0), ("cos 1", 1.0))
        ]
        bent, reactions = plate.solve(plate.couples(np.concatenate(couples, axis=1)))
    return PlaneUnitSolutions(
        sheet,
        model,
        plate,
        on,
        loads,
        _solved(factor, gather, held, loads),
        bent,
        reactions,
        held,
        factor,
        gather,
        material,
    )


def _gather(sheet: SheetMesh) -> sp.csr_array:
    """Displacement of the nodes of the independent unknowns, (2 n_nodes, n_independent)."""
    count = 2 * len(sheet.mesh.nodes)
    owner = np.arange(count)
    first, other = sheet.ties.T
    owner[2 * other + 1] = 2 * first + 1
    owner[2 * other[sheet.bolted]] = 2 * first[sheet.bolted]
    kept, place = np.unique(owner, return_inverse=True)
    matrix = sp.coo_array((np.ones(count), (np.arange(count), place)), (count, len(kept)))
    return matrix.tocsr()


def _hold(sheet: SheetMesh, gather: sp.csr_array) -> IntArray:
    """Three independent unknowns that just stop the sheet from moving in its plane."""
    nodes = sheet.mesh.nodes - sheet.mesh.nodes.mean(axis=0)
    nodes = nodes / np.abs(nodes).max()
    modes = np.zeros((len(nodes), 2, 3))
    modes[:, 0, 0] = modes[:, 1, 1] = 1.0
    modes[:, 0, 2], modes[:, 1, 2] = -nodes[:, 1], nodes[:, 0]
    first = np.full(gather.shape[1], -1)
    rows, columns = gather.nonzero()
    first[columns[::-1]] = rows[::-1]
    *_, order = scipy.linalg.qr(modes.reshape(-1, 3)[first].T, mode="economic", pivoting=True)
    return np.sort(order[:3])


def _solved(factor: Factor, gather: sp.csr_array, held: IntArray, loads: FloatArray) -> FloatArray:
    own = gather.T @ loads
    free = np.setdiff1d(np.arange(len(own)), held)
    moved = np.zeros_like(own)
    moved[free], _ = factor.solve(own[free])
    return np.asarray(gather @ moved)
