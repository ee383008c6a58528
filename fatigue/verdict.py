"""The verdict of ductile metals at every point: Goodman, and Findley where paths are not straight.

Two passes over the points. The first is cheap and sees all of them: Goodman on the longest chord,
how straight the path is, and a bound that no shear plane exceeds. The second searches for the
critical plane, the point with the highest bound first, and ends when the next bound is not above
the worst utilisation found by then; no point that is left could have been the worst one.

Both criteria give 1 in reversed tension at the endurance limit and in reversed torsion at the
torsion limit, and both are linear in the load: utilisations compare and safety is 1/utilisation.
Goodman's sensitivity to mean stress is S_e/S_u, Findley's its own k (docs/theory/multiaxial.md);
the worse of both decides at each point.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fatigue.goodman import FatigueResult, check_strengths, goodman, goodman_utilisation
from fatigue.plane_bounds import coarse_path, plane_bounds
from fatigue.proportionality import PROPORTIONAL, PathBounds, path_bounds
from fatigue.shear_planes import DUCTILE, CriticalPlane, critical_plane, findley_criterion
from fatigue.stress_path import FloatArray, IntArray, check_history

_TOGETHER = 64  # points that Goodman judges at once where not every point is asked for
_TOGETHER_ON_PLANES = 256  # points whose planes are bounded together
_FEW = 4  # points whose planes are sought one by one


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
