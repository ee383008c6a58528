"""Stress at sharp re-entrant edges by Taylor's point method, and the surface beside them.

Elements cannot follow the stress at a sharp edge. Williams' fields fitted around each place of it
(`fem.notch_intensity`) say what planes through the edge carry half a critical distance away, for
every unit load; there the edge is judged, and the surface near it is left out of what is judged
otherwise.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from checks.part.part_loads import PartLoads
from checks.stress.pins_in_bores import Contact
from checks.stress.solid_mesh_level import Level
from checks.stress.stress_result import Stressed, judge
from fem.notch_intensity import REACH, NotchIntensity, has_room, notch_intensity, room_at
from fem.recovery import von_mises
from fem.singularity import EdgePlaces, singular_exponent
from fem.stress_history import StressHistory
from fem.unit_solutions import UnitSolutions, solve_unit_loads
from geometry.mesh import FloatArray, IntArray

_PLANES = 13  # from face to face, these included
_LEFT_OUT = 1.5  # sides of elements at an edge of the coarser mesh: the surface that is left out
_MAY_DECIDE = 0.3  # of the largest stress along the edges, as elements show it


@dataclass(frozen=True, eq=False, kw_only=True)
class _OnSolid(Stressed):
    """A stress that another solution of a solid's mesh has.

    solid  the mesh and its solution
    """

    solid: Level
    direct_stresses: dict[bytes, dict[float, FloatArray]] = field(default_factory=dict)

    @property
    def contact(self) -> Contact | None:
        """Contact of pins whose fit is stated."""
        return self.solid.contact

    @property
    def solved_bores(self) -> Collection[str]:
        """Names of the bores whose pressure is solved."""
        return self.solid.solved_bores

    @property
    def lasting(self) -> Mapping[str, FloatArray]:
        """Even pressure (n,) of bushes that are pressed in, N by bore."""
        return self.solid.lasting

    @property
    def lasting_states(self) -> FloatArray:
        """Coefficients (n_basis, n) of what these make."""
        return self.solid.lasting_states


@dataclass(frozen=True, eq=False, kw_only=True)
class EdgeLevel(_OnSolid):
    """Planes through the sharp edges of a part on one mesh, each a point of the history.

    places    along the edges
    fitted    (k,) of the places, those where Williams' fields could be fitted
    at        mm, distance from the edge at which the planes are judged
    reach     as of `notch_intensity`
    leading   whether of the leading fields alone
    """

    places: EdgePlaces
    fitted: IntArray
    at: float
    reach: tuple[float, float]
    leading: bool

    @property
    def solutions(self) -> UnitSolutions:
        """The unit loads."""
        return self.solid.solutions

    def stress_of(self, displacement: FloatArray) -> FloatArray:
        """Stress (n_planes, 6, m) that the planes carry of displacement (3 n_nodes, m), mm."""
        places = self.places
        fits = [
            _fit(self.solid, displacement, places, int(k), self.reach, self.at) for k in self.fitted
        ]
        return _on_planes([fit for fit in fits if fit], self.at, leading=self.leading)

    def named(self, point: int) -> str:
        """Name of the edge that a plane goes through."""
        angle = np.degrees(self.places.angles[self.fitted[point // (_PLANES - 2)]])
        return f"sharp edge of {angle:.0f} deg"

    def depth(self, point: int) -> None:
        """None: an edge is no surface."""


def edge_level(
    level: Level,
    loads: PartLoads,
    duty: Mapping[str, float],
    at: float,
    *,
    reach: tuple[float, float] = REACH,
    leading: bool = False,
) -> EdgeLevel | None:
    """Judge the planes through a mesh's sharp edges at a distance (mm); None where none is fitted.

    Their endurance limit is the lowest of the edge's nodes there.
    """
    places = level.edge_places
    moved = level.solutions.displacement
    fits = {k: _fit(level, moved, places, k, reach, at) for k in _that_matter(level, at)}
    fitted = np.array([k for k, fit in fits.items() if fit], dtype=np.int64)
    if not len(fitted) or len(fitted) < len(fits):
        return None
    count = _PLANES - 2
    basis = _on_planes([fit for fit in fits.values() if fit], at, leading=leading)
    rows = np.searchsorted(level.history.nodes, places.nodes[fitted])
    limits = np.repeat(level.limits[rows].min(axis=1), count)
    history = StressHistory(
        np.repeat(places.nodes[fitted, 2], count),
        np.repeat(places.points[fitted], count, axis=0),
        basis,
        level.coefficients,
    )
    judged = judge(
        history, limits, level.judged_duty.limit, level.judged_duty.ultimate, loads, duty
    )
    return EdgeLevel(
        solid=level,
        places=places,
        fitted=fitted,
        at=at,
        reach=reach,
        leading=leading,
        **judged,
    )


def _that_matter(level: Level, at: float) -> list[int]:
    """Places whose edge may be used most at a distance (mm), of those with room for a fit.

    The stress that elements show at an edge is its fields' at a share of their size, within
    a factor of two: a place with less than a part of the largest, brought to the same distance by
    the edge's exponent, cannot be the worst.
    """
    places, duty = level.edge_places, level.judged_duty
    able = [k for k in range(len(places.points)) if has_room(places, k)]
    rows = np.searchsorted(level.history.nodes, places.nodes[able])
    exponents = np.array([singular_exponent(float(places.angles[k])) for k in able])
    shown = duty.bound[rows].max(axis=1, initial=0.0) * (places.sizes[able] / at) ** exponents
    return [k for k, used in zip(able, shown, strict=True) if used >= _MAY_DECIDE * shown.max()]


def beside_edges(
    levels: Sequence[Level], edges: Sequence[EdgeLevel], loads: PartLoads, duty: Mapping[str, float]
) -> list[Level]:
    """The same meshes without the surface near the edges that are judged apart.

    It is the same surface on every mesh: within some sides of the coarsest one's elements of a
    place with room for a fit on the finest, and less than where either face ends.
    """
    coarsest, finest = edges[0].places, edges[-1].places
    able = np.array([k for k in range(len(finest.points)) if has_room(finest, k)])
    points = finest.points[able]
    nearest = np.linalg.norm(points[:, None] - coarsest.points, axis=2).argmin(axis=1)
    room = np.array([room_at(finest, k) for k in able])
    radius = np.minimum(_LEFT_OUT * coarsest.sizes[nearest], room)
    if levels[-1].half:  # the first mesh is of the whole part
        points = np.concatenate([points, points * [1, 1, -1]])
        radius = np.concatenate([radius, radius])
    found = []
    for level in levels:
        near = np.zeros(len(level.history.nodes), dtype=bool)
        for place, far in zip(points, radius, strict=True):
            near |= np.linalg.norm(level.history.points - place, axis=1) < far
        found.append(without(level, np.flatnonzero(near), loads, duty))
    return found


def without(level: Level, left_out: IntArray, loads: PartLoads, duty: Mapping[str, float]) -> Level:
    """The same mesh, some of its surface points left out of what is judged."""
    basis = level.history.basis.copy()
    basis[left_out] = 0.0
    history = replace(level.history, basis=basis)
    limit, ultimate = (1.0, 1.0) if level.duty is None else (level.duty.limit, level.duty.ultimate)
    judged = judge(history, level.limits, limit, ultimate, loads, duty)
    return replace(level, left_out=left_out, **judged)


def _fit(
    level: Level,
    displacement: FloatArray,
    places: EdgePlaces,
    which: int,
    reach: tuple[float, float],
    at: float,
) -> NotchIntensity | None:
    return notch_intensity(level.solutions.recovery, displacement, places, which, reach, at)


def _on_planes(fits: Sequence[NotchIntensity], at: float, *, leading: bool) -> FloatArray:
    """Stress (n_planes, 6, m) on planes between the faces, place by place, MPa."""
    return np.stack(
        [
            fit.on_plane(at, theta, leading=leading)
            for fit in fits
            for theta in np.linspace(-fit.angle / 2, fit.angle / 2, _PLANES)[1:-1]
        ]
    )


# A stress field that is in balance with the loads and spares the sharp edges of a part.
#
# Around its sharp re-entrant edges the part is solved again with a Young's modulus that falls to
# nothing towards the edge, in proportion to the distance. Its stress is finite at the edge, and
# it is in balance with the same loads as the part's own stress: where it stays below yield
# everywhere, a ductile part does not collapse (the lower bound theorem of limit analysis).

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
class SparedLevel(_OnSolid):
    """The stress that spares the edges, on one mesh.

    Its points are the surface points, and the elements around the edges, each with its mean stress.

    softened   the unit loads of the softened part
    around     (k,) elements around the edges
    """

    softened: UnitSolutions
    around: IntArray
    left_out: IntArray

    @property
    def solutions(self) -> UnitSolutions:
        """The unit loads."""
        return self.softened

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
    return SparedLevel(solid=level, softened=softened, around=around, left_out=left_out, **judged)


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
