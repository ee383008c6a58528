"""The verdict of ductile metals at every point: Goodman, and Findley where paths are not straight.

Two passes over the points. The first is cheap and sees all of them: Goodman on the longest chord,
how straight the path is, and a bound that no shear plane exceeds. The second searches for the
critical plane, the point with the highest bound first, and ends when the next bound is not above
the worst utilisation found by then; no point that is left could have been the worst one.

Both criteria give 1 in reversed tension at the endurance limit and in reversed torsion at the
torsion limit, and both are linear in the load: utilisations compare and safety is 1/utilisation.
Goodman's sensitivity to mean stress is S_e/S_u, Findley's its own k (docs/theory/multiaxial.md);
the worse of both decides at each point.

Bounds of Findley's parameter of many paths at once tell which of them reach no floor on any plane.
As the search for one path (fatigue/shear_planes.py): on a triangle of planes with longest edge e
the parameter is at most its largest corner + M e^2/4, and triangles that stay below the floor are
dropped, the others divided. Here all paths take their triangles from the same grids, one twice as
fine as the other, so that each step is a few products for all of them. A path that is above its
floor somewhere, or near it, is left to the search.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from heapq import heappop, heappush
from math import sqrt

import numpy as np
import numpy.typing as npt

from fatigue.goodman import FatigueResult, check_strengths, goodman, goodman_utilisation
from fatigue.proportionality import PROPORTIONAL, PathBounds, path_bounds
from fatigue.shear_planes import (
    DUCTILE,
    CriticalPlane,
    critical_plane,
    findley_criterion,
    half_sphere,
    longest_edges,
    plane_rows,
)
from fatigue.stress_path import FloatArray, IntArray, check_history, deviatoric_basis

_TOGETHER = 64  # points that Goodman judges at once where not every point is asked for
_TOGETHER_ON_PLANES = 256  # points whose planes are bounded together
_FEW = 4  # points whose planes are sought one by one
_FIRST, _LAST = 2, 6  # divisions of the grids: edges of 18 and of 1.2 degrees
_MOST = 128  # triangles of a path that are divided: more are left to the search
_REACHED = 0.9  # of a bound at a normal: the parameter is seldom below, so it is above the floor
_NUMBERS = 1_500_000  # of resolved stresses at once


@dataclass(frozen=True, eq=False)
class Verdict:
    """Fatigue of a ductile part under one cycle repeated without end.

    goodman            Goodman's result at `points`
    points             (n_goodman,)  ascending; all of them unless the verdict was asked for less
    goodman_bound      (n_points,)  not less than Goodman's utilisation; equal to it at `points`
    bounds             straightness and bounds of the first pass at every point
    plane_utilisation  (n_points,)  Findley's, where its value was needed; elsewhere NaN
    plane_bound        (n_points,)  not less than Findley's; 0 where the path is proportional
    plane              Findley's plane at the critical point, None if the path is proportional
                       there, or if Goodman decides and the verdict was asked for less
    n_searched         points whose planes were looked at
    """

    goodman: FatigueResult
    points: IntArray
    goodman_bound: FloatArray
    bounds: PathBounds
    plane_utilisation: FloatArray
    plane_bound: FloatArray
    plane: CriticalPlane | None
    n_searched: int

    def __post_init__(self) -> None:
        n = len(self.bounds.width)
        arrays = (self.goodman_bound, self.plane_utilisation, self.plane_bound)
        shapes = [a.shape for a in arrays]
        if shapes != [(n,)] * 3 or self.points.shape != self.goodman.utilisation.shape:
            raise ValueError(
                f"a verdict on {n} points needs as many bounds and plane values, and a point for "
                f"each of Goodman's, got {shapes} and {self.points.shape}"
            )

    @property
    def utilisation(self) -> FloatArray:
        """The worse known utilisation of both criteria at each point; exact at the worst point.

        0 where nothing is known, which `ductile_verdict` leaves only to points that do not govern.
        """
        known = np.zeros(len(self.goodman_bound))
        known[self.points] = self.goodman.utilisation
        return np.asarray(np.fmax(known, self.plane_utilisation))

    @property
    def highest_utilisation(self) -> FloatArray:
        """Upper bound of the utilisation of each point, its plane searched or not."""
        known = np.isfinite(self.plane_utilisation)
        plane = np.where(known, self.plane_utilisation, self.plane_bound)
        return np.asarray(np.maximum(self.goodman_bound, plane))

    @property
    def proportional(self) -> npt.NDArray[np.bool_]:
        """True for each point whose path is a straight line, so that Goodman alone judges it."""
        return np.asarray(self.bounds.width <= PROPORTIONAL)

    @property
    def critical(self) -> int:
        """The point with the largest utilisation; the first of equal ones."""
        return int(self.utilisation.argmax())

    @property
    def criterion(self) -> str:
        """Which criterion decides at the critical point: Goodman or Findley."""
        plane = self.plane_utilisation[self.critical]
        return "Findley" if plane > self.goodman.utilisation[self._row] else "Goodman"

    @property
    def pair(self) -> tuple[int, int]:
        """The two positions of the deciding criterion at the critical point, the earlier first."""
        if self.plane is not None and self.criterion == "Findley":
            return self.plane.pair
        first, second = self.goodman.pair[self._row]
        return int(first), int(second)

    @property
    def _row(self) -> int:
        """Where the critical point stands in Goodman's result."""
        return int(np.searchsorted(self.points, self.critical))

    @property
    def safety(self) -> float:
        """The factor on all loads that brings the critical point to its limit; inf if unloaded."""
        largest = float(self.utilisation.max())
        return 1.0 / largest if largest > 0.0 else float("inf")


def ductile_verdict(
    basis: FloatArray,
    coefficients: FloatArray,
    endurance_limit: npt.ArrayLike,
    ultimate_strength: float,
    *,
    torsion_ratio: float = DUCTILE,
    every_point: bool = True,
    floor: float = -np.inf,
    cycle: str = "",
) -> Verdict:
    """Return the verdict on every point under one cycle.

    basis (n_points, 6, n_basis), coefficients (n_basis, n_positions) and strengths, MPa, as in
    `goodman`; torsion_ratio is the material's limit in reversed torsion over that in bending.
    Without `every_point` Goodman too is taken only where his bound says that he can govern, and
    Findley's plane is not sought at a point that Goodman decides: the same worst point and safety,
    bounds elsewhere. Then a utilisation not above `floor` is of no interest either: where no point
    has more, its place and value are any.
    """
    basis, coefficients = check_history(basis, coefficients)
    criterion = findley_criterion(torsion_ratio)
    endurance = np.asarray(endurance_limit, dtype=np.float64)
    if endurance.shape not in ((), (len(basis),)):
        raise ValueError(
            f"the endurance limit must be one number or one per point, ({len(basis)},), "
            f"got {endurance.shape}"
        )
    check_strengths(endurance, ultimate_strength)
    endurance = np.broadcast_to(endurance, (len(basis),))
    bounds = path_bounds(basis, coefficients, criterion.k)

    def by_goodman(points: IntArray) -> FatigueResult:
        limits = endurance[points]
        return goodman(basis[points], coefficients, limits, ultimate_strength, cycle)

    goodman_bound = goodman_utilisation(bounds.amplitude, bounds.mean, endurance, ultimate_strength)
    if every_point:
        points = np.arange(len(basis))
        by_chord = by_goodman(points)
    else:
        points, by_chord = _governing(goodman_bound, by_goodman, floor)
    worst = max(floor, float(by_chord.utilisation.max()))
    known = np.zeros(len(basis))
    known[points] = by_chord.utilisation
    limit = criterion.limit_ratio * endurance
    bound = np.where(bounds.width <= PROPORTIONAL, 0.0, bounds.findley / limit)
    value = np.full(len(basis), np.nan)
    planes: dict[int, CriticalPlane] = {}
    n_searched = 0
    order = np.argsort(-bound, kind="stable")
    order = order[bound[order] > worst]
    for start in [0, *range(1, len(order), _TOGETHER_ON_PLANES)]:
        some = order[start : start + _TOGETHER_ON_PLANES] if start else order[:1]
        some = some[bound[some] > worst]
        if len(some) > _FEW:
            sketched = _bound_by_few(basis[some], coefficients, criterion.k, worst * limit[some])
            bound[some] = np.minimum(bound[some], sketched / limit[some])
            left = some[bound[some] > worst]
            n_searched += len(some) - len(left)
            some = left
        for point in some:
            if bound[point] <= worst:
                break
            stress = basis[point] @ coefficients
            plane = critical_plane(stress, criterion.k, floor=worst * limit[point])
            n_searched += 1
            bound[point] = min(bound[point], plane.bound / limit[point])
            used = plane.value / limit[point]
            if used > worst:
                worst = value[point] = used
                planes = {int(point): plane}
    critical = int(np.fmax(known, value).argmax())
    if critical not in points:
        points = np.sort(np.append(points, critical))
        by_chord = by_goodman(points)
    goodman_bound[points] = by_chord.utilisation
    if every_point and critical not in planes and bounds.width[critical] > PROPORTIONAL:
        planes[critical] = critical_plane(basis[critical] @ coefficients, criterion.k)
        value[critical] = planes[critical].value / limit[critical]
        bound[critical] = min(bound[critical], planes[critical].bound / limit[critical])
        n_searched += 1
    return Verdict(
        goodman=by_chord,
        points=points,
        goodman_bound=goodman_bound,
        bounds=bounds,
        plane_utilisation=value,
        plane_bound=bound,
        plane=planes.get(critical),
        n_searched=n_searched,
    )


def _bound_by_few(
    basis: FloatArray, coefficients: FloatArray, k: float, floors: FloatArray
) -> FloatArray:
    """Bounds (n,) of Findley's parameter by few positions of each path; infinite above a floor."""
    coarse = coarse_path(basis, coefficients, k)
    stress = basis @ coefficients[:, coarse.kept]
    return plane_bounds(stress, k, floors - coarse.slack) + coarse.slack


def _governing(
    bound: FloatArray, by_goodman: Callable[[IntArray], FatigueResult], floor: float
) -> tuple[IntArray, FatigueResult]:
    """Return the points among which Goodman's worst is, ascending, and his result at them.

    The points with the highest bounds are judged first; more than one only where they may exceed a
    floor.
    """
    order = np.argsort(-bound, kind="stable")
    order = order[: max(1, np.count_nonzero(bound > floor))]
    worst, n = -np.inf, 0
    found: list[FatigueResult] = []
    while n == 0 or (n < len(order) and bound[order[n]] > worst):
        more = order[n : n + _TOGETHER]
        found.append(by_goodman(more))
        worst = max(worst, float(found[-1].utilisation.max()))
        n += len(more)
    rows = np.argsort(order[:n])
    return order[:n][rows], _joined(found, rows)


def _joined(found: list[FatigueResult], rows: IntArray) -> FatigueResult:
    """Return results of some points each as one, in another order of the points."""

    def column(name: str) -> FloatArray:
        return np.asarray(np.concatenate([getattr(result, name) for result in found])[rows])

    return FatigueResult(
        cycle=found[0].cycle,
        amplitude=column("amplitude"),
        mean=column("mean"),
        pair=np.concatenate([result.pair for result in found])[rows],
        endurance_limit=column("endurance_limit"),
        ultimate_strength=found[0].ultimate_strength,
        utilisation=column("utilisation"),
    )


def plane_bounds(stress: FloatArray, k: float, floors: FloatArray) -> FloatArray:
    """Return a proven bound of Findley's parameter of each path on any plane, MPa.

    stress (n, 6, n_positions), floors (n,) MPa. Where no plane is shown to stay below the floor the
    bound is infinite. Compression earns no credit.
    """
    bounds = np.full(len(stress), np.inf)
    size = max(1, _NUMBERS // (3 * 93 * stress.shape[2]))
    for start in range(0, len(stress), size):
        some = slice(start, start + size)
        bounds[some] = _bounds(stress[some], k, floors[some])
    return bounds


def _bounds(stress: FloatArray, k: float, floors: FloatArray) -> FloatArray:
    swing, scale = _swings(stress, k)
    normals, cells, rows, edges = _grid(_FIRST)
    upper = _upper(rows[None], swing[:, None], stress[:, None], k)
    tops = upper[:, cells].max(axis=2) + scale[:, None] * edges**2
    hopeful = tops > floors[:, None]
    lost = (_REACHED * upper.max(axis=1) > floors) | (hopeful.sum(axis=1) > _MOST)
    hopeful[lost] = False
    bounds = np.where(hopeful, -np.inf, tops).max(axis=1)
    path, cell = np.nonzero(hopeful)
    for level in range(_FIRST + 1, _LAST + 1):
        if not len(path):
            break
        before = len(cells)
        normals, cells, rows, edges = _grid(level)
        path = np.tile(path, 4)
        cell = np.concatenate([cell + before * child for child in range(4)])
        asked, which = np.unique(
            path[:, None] * len(normals) + cells[cell], return_inverse=True
        )  # each normal once for each path
        of, normal = np.divmod(asked, len(normals))
        upper = _upper(rows[normal], swing[of], stress[of], k)
        tops = upper[which.reshape(-1, 3)].max(axis=1) + scale[path] * edges[cell] ** 2
        above = tops > floors[path]
        np.maximum.at(bounds, path[~above], tops[~above])
        lost[of[_REACHED * upper > floors[of]]] = True
        lost |= np.bincount(path[above], minlength=len(stress)) > _MOST
        above &= ~lost[path]
        path, cell = path[above], cell[above]
    lost[path] = True
    bounds[lost] = np.inf
    return np.asarray(bounds)


def _swings(stress: FloatArray, k: float) -> tuple[FloatArray, FloatArray]:
    """Paths about the middle of a long chord of each, and M/4 (n,), MPa."""
    every = np.arange(len(stress))
    path = deviatoric_basis(stress)
    first = ((path - path.mean(axis=2, keepdims=True)) ** 2).sum(axis=1).argmax(axis=1)
    start = path[every, :, first]
    other = ((path - start[:, :, None]) ** 2).sum(axis=1).argmax(axis=1)
    middle = (start + path[every, :, other]) / 2.0
    radius = np.sqrt(((path - middle[:, :, None]) ** 2).sum(axis=1).max(axis=1))
    largest = np.sqrt((path**2).sum(axis=1).max(axis=1))
    centre = (stress[every, :, first] + stress[every, :, other]) / 2.0
    return stress - centre[:, :, None], (radius + k * np.maximum(largest, radius)) / sqrt(3.0)


def _upper(rows: FloatArray, swing: FloatArray, stress: FloatArray, k: float) -> FloatArray:
    """Upper bounds of the parameter: the circle around the middle of a long chord."""
    along, across, normal = rows[..., 0, :], rows[..., 1, :], rows[..., 2, :]
    if rows.ndim == 4:  # the same planes for all paths
        shear = along[0] @ swing[:, 0]
        other = across[0] @ swing[:, 0]
        pressed = normal[0] @ stress[:, 0]
    else:
        both = rows[:, :2] @ swing
        shear, other = both[:, 0], both[:, 1]
        pressed = (normal[:, None] @ stress)[:, 0]
    shear *= shear
    other *= other
    shear += other
    largest = pressed.max(axis=-1)
    counted = np.maximum(largest, (largest - pressed.min(axis=-1)) / 2.0)
    return np.asarray(np.sqrt(shear.max(axis=-1)) + k * counted)


@cache
def _grid(level: int) -> tuple[FloatArray, IntArray, FloatArray, FloatArray]:
    """Normals, triangles, rows and edges; triangle i + j n of a grid is part j of the last one's.

    n are the triangles of the grid before; its own order is kept.
    """
    normals, cells = half_sphere(level)
    return normals, cells, plane_rows(normals), longest_edges(normals, cells)


# Few positions of a stress path that answer for all of them, and how far the others lie off them.
#
# A path of hundreds of positions is mostly straight pieces. Of the positions that are kept,
# chords run from one to the next; each other position x has a place z on the chord beside it,
# which lies in the convex hull of what is kept. With e = |x - z| in von Mises stress and g the
# difference of the hydrostatic stresses, on the plane with normal n
#
#     |tau(x) - tau(z)| <= e / sqrt(3),    |sigma_n(x) - sigma_n(z)| <= 2/3 e + g
#
# as the largest shear of a deviator is at most its von Mises norm over sqrt(3), and its largest
# principal stress at most 2/3 of it. The circle around the kept shear holds all tau(z), and
# sigma_n and half its range are extreme at what is kept. So Findley's parameter of the whole path
# is at most
#
#     F(kept) + e (1/sqrt(3) + 2/3 k) + k g
#
# with the largest e and g of all positions, on every plane.

_MOST_PATH = 48  # positions kept
_CLOSE = 1e-3  # of the longest radius of the path: positions so near a chord need not be kept
_DIMENSIONS = 8  # of the path that is looked at for what to keep
_PRESSURE = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]) / 3.0


@dataclass(frozen=True, eq=False)
class CoarsePath:
    """Positions that are kept of the paths of some points, and what they miss.

    kept   (m,)        positions, ascending
    slack  (n_points,) MPa, by how much Findley's parameter may exceed the kept positions'
    """

    kept: IntArray
    slack: FloatArray


def coarse_path(basis: FloatArray, coefficients: FloatArray, k: float) -> CoarsePath:
    """Return positions that stand for all on every point; k is the weight of the normal stress.

    basis (n_points, 6, n_basis) and coefficients (n_basis, n_positions) as in `stress_path`.
    """
    vectors = np.concatenate([deviatoric_basis(basis), (_PRESSURE @ basis)[:, None]], axis=1)
    rows = vectors.reshape(-1, vectors.shape[2])
    values, turn = np.linalg.eigh(rows.T @ rows)
    main = slice(-min(_DIMENSIONS, len(values)), None)
    path = (turn[:, main] * np.sqrt(np.maximum(values[main], 0.0))).T @ coefficients
    kept, share = _chords(path)
    first = np.searchsorted(kept, np.arange(path.shape[1]), side="right") - 1
    last = np.minimum(first + 1, len(kept) - 1)
    ends = coefficients[:, kept]
    off = coefficients - (1.0 - share) * ends[:, first] - share * ends[:, last]
    off = np.delete(off, kept, axis=1)
    apart = (rows @ off).reshape(*vectors.shape[:2], -1)
    apart *= apart
    deviator = np.sqrt(apart[:, :5].sum(axis=1).max(axis=1, initial=0.0))
    pressure = np.sqrt(apart[:, 5].max(axis=1, initial=0.0))
    slack = deviator * (1.0 / sqrt(3.0) + 2.0 / 3.0 * k) + k * pressure
    return CoarsePath(kept, slack)


def _chords(path: FloatArray) -> tuple[IntArray, FloatArray]:
    """Positions to keep of a path (d, n), and each one's share (n,) of the chord beside it.

    The position farthest from its chord is kept next, until all are close.
    """
    n = path.shape[1]
    share = np.zeros(n)
    kept = [0, n - 1]
    middle = path.mean(axis=1, keepdims=True)
    close = _CLOSE**2 * float(((path - middle) ** 2).sum(axis=0).max())
    waiting: list[tuple[float, int, int, int]] = []

    def look(first: int, last: int) -> None:
        if last - first < 2:
            return
        start = path[:, first, None]
        chord, away = path[:, last, None] - start, path[:, first + 1 : last] - start
        length = float((chord * chord).sum())
        along = np.clip((chord * away).sum(axis=0) / length, 0.0, 1.0) if length else np.zeros(1)
        share[first + 1 : last] = along
        away = away - chord * along
        squared = (away * away).sum(axis=0)
        farthest = int(squared.argmax())
        heappush(waiting, (-float(squared[farthest]), first, first + 1 + farthest, last))

    look(0, n - 1)
    while waiting and len(kept) < _MOST_PATH:
        squared, first, farthest, last = heappop(waiting)
        if -squared <= close:
            break
        kept.append(farthest)
        share[farthest] = 0.0
        look(first, farthest)
        look(farthest, last)
    return np.unique(kept), share
