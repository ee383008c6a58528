"""A stress field that is in balance with the loads and spares the sharp edges of a part.

Around its sharp re-entrant edges the part is solved again with a Young's modulus that falls to
nothing towards the edge, in proportion to the distance. Its stress is finite at the edge, and it
is in balance with the same loads as the part's own stress: where it stays below yield everywhere, a
ductile part does not collapse (the lower bound theorem of limit analysis).
"""

from collections.abc import Collection
from dataclasses import dataclass, field

import numpy as np

from checks.part.part_loads import PartLoads
from checks.stress.pins_in_bores import Contact
from checks.stress.solid_mesh_level import Level
from checks.stress.stress_result import Stressed, judge
from fem.recovery import von_mises
from fem.singularity import EdgePlaces
from fem.stress_history import StressHistory
from fem.unit_solutions import UnitSolutions, solve_unit_loads
from geometry.mesh import FloatArray, IntArray

_SHARE_OF_ROOM = 0.6  # within which the modulus falls
_SIDES = (1.5, 4.8)  # of the first mesh's elements at the edge, at least and at most
_JUDGED = 2.0  # times that distance, within which the stress inside of the part is judged too
_ON_A_SIDE = np.linspace(0.0, 1.0, 9)
_CHUNK = 4000  # elements at a time: bounds memory


@dataclass(frozen=True, eq=False)
class Spared:
    """How far around sharp edges a part is softened: places (n, 3) and distances (n,), mm."""

    points: FloatArray
    reach: FloatArray

    @classmethod
    def of(cls, first: Level) -> "Spared":
        """As the first mesh of a part has its edges; the same on all finer ones."""
        places = first.edge_places
        least, most = (sides * places.sizes for sides in _SIDES)
        return cls(places.points, np.clip(_SHARE_OF_ROOM * places.room, least, most))

    def share(self, level: Level, where: FloatArray) -> FloatArray:
        """Distance of places (n, 3) from the sharp edges of a mesh, over the reach there, (n,)."""
        from scipy.spatial import cKDTree

        mesh = level.solutions.mesh
        line = _lines(level.edge_places, mesh.nodes)
        away, _ = cKDTree(line).query(where)
        _, nearest = cKDTree(self.points).query(where)
        return np.asarray(away / self.reach[nearest])


def _lines(places: EdgePlaces, nodes: FloatArray) -> FloatArray:
    """Points (n, 3) close to each other along sharp edges."""
    first, second = (nodes[places.nodes[:, k]][:, None] for k in range(2))
    share = _ON_A_SIDE[:, None]
    chord = (1 - share) * first + share * second
    bulge = (places.points[:, None] - (first + second) / 2) * 4 * share * (1 - share)
    return np.asarray((chord + bulge).reshape(-1, 3))


@dataclass(frozen=True, eq=False, kw_only=True)
class SparedLevel(Stressed):
    """The stress that spares the edges, on one mesh.

    Its points are the surface points, and the elements around the edges, each with its mean stress.

    solid      the mesh, and the part as it is
    softened   the unit loads of the softened part
    around     (k,) elements around the edges
    """

    solid: Level
    softened: UnitSolutions
    around: IntArray
    left_out: IntArray
    direct_stresses: dict[bytes, dict[float, FloatArray]] = field(default_factory=dict)

    @property
    def solutions(self) -> UnitSolutions:
        """The unit loads."""
        return self.softened

    @property
    def contact(self) -> Contact | None:
        """Contact of pins whose fit is stated."""
        return self.solid.contact

    @property
    def solved_bores(self) -> Collection[str]:
        """Names of the bores whose pressure is solved."""
        return self.solid.solved_bores

    def stress_of(self, displacement: FloatArray) -> FloatArray:
        """Stress (n_points, 6, m) of displacement (3 n_nodes, m), mm."""
        return _stress(self.softened, displacement, self.around, self.left_out)

    def named(self, point: int) -> str:
        """Name of the surface that a point is on, or that it is inside of the part at an edge."""
        if point < len(self.solid.history.nodes):
            return self.solid.named(point)
        return "around the sharp edge"

    def depth(self, point: int) -> tuple[float, float] | None:
        """Least and largest |z| of that surface on the point's side, mm; None if not known."""
        return self.solid.depth(point) if point < len(self.solid.history.nodes) else None

    @property
    def scatter(self) -> float:
        """How far the stress inside the element of the peak exceeds its mean, MPa; 0 elsewhere."""
        element = self.peak.point - len(self.solid.history.nodes)
        if element < 0:
            return 0.0
        state = self.softened.displacement @ self.coefficients[:, self.peak.position]
        within = self.softened.recovery.quadrature_stress(state[:, None], self.around[[element]])
        return float(max(0.0, von_mises(within[0, :, :, 0]).max() - self.peak.value))


def spared_level(level: Level, loads: PartLoads, spared: Spared) -> SparedLevel:
    """Solve a mesh with its edges spared, under the loads of its positions.

    Raises SolverError and TooLargeError as any solution.
    """
    solutions = level.solutions
    mesh = solutions.mesh
    share = spared.share(level, mesh.nodes[mesh.elements[:, :4]].mean(axis=1))
    softened = solve_unit_loads(mesh, solutions.material, np.minimum(share, 1.0))
    if level.contact is not None:
        softened = level.contact.solutions.on(softened)
    around = np.flatnonzero(share < _JUDGED)
    # between the elements there, stress averaged at nodes is that of neither
    left_out = np.flatnonzero(spared.share(level, level.history.points) < 1.0)
    basis = _stress(softened, softened.displacement, around, left_out)
    middles = mesh.nodes[mesh.elements[around, :4]].mean(axis=1)
    history = StressHistory(
        np.concatenate([level.history.nodes, mesh.elements[around, 0]]),
        np.concatenate([level.history.points, middles]),
        basis,
        level.coefficients,
    )
    limits = np.ones(len(basis))
    judged = judge(history, limits, 1.0, 1.0, loads, {})  # of fatigue nothing is asked
    return SparedLevel(
        solid=level,
        softened=softened,
        around=around,
        left_out=left_out,
        history=history,
        limits=limits,
        peak=judged.peak,
        peaks_by_position=judged.peaks_by_position,
        duty=None,
    )


def _stress(
    solutions: UnitSolutions, displacement: FloatArray, around: IntArray, left_out: IntArray
) -> FloatArray:
    """Stress (n, 6, m) at the surface points and in some elements, MPa."""
    recovery = solutions.recovery
    surface = recovery.surface_stress(displacement)
    surface[left_out] = 0.0
    inside = [
        recovery.quadrature_stress(displacement, around[k : k + _CHUNK]).mean(axis=1)
        for k in range(0, len(around), _CHUNK)
    ]
    return np.concatenate([surface, *inside])
