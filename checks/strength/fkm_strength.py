"""Fatigue of a part by the FKM guideline's chain: local stress, support from its gradient.

At a surface point and along a closed path of stress, the positions of a cycle:

    sigma_a   half the longest chord, von Mises, and
    sigma_m   largest principal stress of its middle, not below 0: both as `fatigue.goodman` has
              them, without the guideline's credit for compression
    G         related gradient of the chord along the inward normal, of its principal stress of
              largest size
    n         Stieler's support number of G
    a_BK      sigma_a / (K_AK K_BK sigma_WK), the roughness and n in sigma_WK

FKM guideline, 6th ed. (2012), chapter 4, overload case F2 (constant R), without safety factors: the
design asks for its own. Amplitude and mean are linear in the load and G is free of it, so a_BK is
linear, and the safety on all loads is 1/a_BK.

**The worst point is not missed.** n is never below 1, so a_BK does not exceed its value without
support; that one grows with amplitude and mean, so it does not exceed its value at the bounds of
`fatigue.path_bounds`. Points are judged in the order of that bound, until the next one is not above
the worst a_BK found.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from math import inf

import numpy as np

import fatigue
from checks.design.strength import FkmStrength
from checks.part.part_loads import first_largest
from fatigue.fkm import SURVIVAL
from fatigue.proportionality import PROPORTIONAL
from fem.gradient import SurfaceSlopes, inward_normals, related_gradient
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray, IntArray

SlopesAt = Callable[[IntArray], FloatArray]
_FIRST, _MOST = 64, 4096  # points that are judged together, at first and at most
_ROUND_OFF = 1e-9  # of a utilisation, by which a bound may fall short


@dataclass(frozen=True, eq=False)
class FkmPoints:
    """FKM's utilisation at some points of a part on one path, all (n,) but the pairs (n, 2).

    points       surface points
    pair         positions of the path at the ends of the chord
    amplitude    MPa, half the chord
    mean         MPa, largest principal stress of the chord's middle, not below 0
    gradient     1/mm
    support      n
    utilisation  a_BK, compression without credit
    """

    points: IntArray
    pair: IntArray
    amplitude: FloatArray
    mean: FloatArray
    gradient: FloatArray
    support: FloatArray
    utilisation: FloatArray


@dataclass(frozen=True, eq=False)
class FkmJudgement:
    """FKM's utilisation of a part over its duty, at its worst point.

    strength     of the part
    point        surface point
    run          name of the path that decides
    pair         the two positions that decide, of all positions of all cycles
    amplitude    MPa, half the chord, von Mises
    mean         MPa, largest principal stress of the chord's middle, not below 0
    gradient     1/mm, related gradient
    limit        sigma_WK at the point, with its factors
    width        of the point's path, see `fatigue.PathBounds`
    """

    strength: FkmStrength
    point: int
    run: str
    pair: tuple[int, int]
    amplitude: float
    mean: float
    gradient: float
    limit: fatigue.ComponentLimit
    width: float

    @property
    def utilisation(self) -> float:
        """a_BK without a safety factor; compression has no credit."""
        return self.utilisation_with(self.amplitude, self.mean)

    @property
    def safety(self) -> float:
        """The factor on all loads that uses the strength up; infinite without any amplitude."""
        return 1.0 / self.utilisation if self.utilisation > 0.0 else inf

    @property
    def demand(self) -> float:
        """Equivalent amplitude, MPa: what even, fully reversed stress is used as much by.

        To be held against `FkmStrength.reference`, which is the same on every mesh.
        """
        return self.utilisation * self.strength.reference

    @property
    def mean_factor(self) -> float:
        """K_AK of the mean as it counts."""
        return float(fatigue.fkm_factor(self.amplitude, self.mean, self.limit.sensitivity))

    def utilisation_with(self, amplitude: float, mean: float) -> float:
        """Return a_BK of other stresses, MPa, at the same point: its support and roughness."""
        return float(self.strength.utilisation(amplitude, mean, self.limit))

    def utilisation_between(self, stress: FloatArray) -> FloatArray:
        """Return a_BK (n,) of the chord between two states of stress (n, 6, 2), MPa.

        With the support of this point, such as for the same place under other bearing pressures.
        """
        swing = fatigue.von_mises(stress[..., 0] - stress[..., 1]) / 2.0
        middle = fatigue.principal_stresses(stress.mean(axis=-1))[..., 2]
        return self.strength.utilisation(swing, middle, self.limit)

    def facts(self) -> dict[str, float | str]:
        """Numbers of the deciding point for the report, by name."""
        own, limit = self.strength, self.limit
        said: dict[str, float | str] = {
            "fatigue amplitude [MPa]": self.amplitude,
            "fatigue mean stress [MPa]": self.mean,
            "FKM related stress gradient [1/mm]": self.gradient,
            "FKM support number (Stieler)": float(limit.support),
            "FKM factors": f"roughness K_R {limit.roughness:.3f} (Rz {own.roughness:g} um), "
            f"K_f~ {limit.notch_factor:g}, design factor K_WK {float(limit.design_factor):.3f} "
            f"on {limit.strength:.4g} MPa",
            "FKM component strength, fully reversed [MPa]": float(limit.limit),
            "FKM mean stress factor": f"K_AK {self.mean_factor:.3f}, M {limit.sensitivity:.3f}",
            "FKM group, survival": f"{own.material.group}, {100 * SURVIVAL:g} %",
        }
        if own.endurance_share < 1.0:
            said["FKM endurance"] = (
                f"{own.endurance_share:.3f} of the strength at 1e6 cycles: the group's curve falls "
                "on to 1e8"
            )
        if self.width > PROPORTIONAL:
            said["FKM stress path"] = (
                f"not proportional, {self.width:.2g} as wide as long: only its longest chord is "
                "judged, no critical plane"
            )
        return said


def slopes_of(solutions: UnitSolutions) -> SlopesAt:
    """Return what gives the slopes (n, 6, n_basis), MPa/mm per unit, of chosen surface points."""
    normals = inward_normals(solutions.mesh)

    def of(points: IntArray) -> FloatArray:
        slopes = SurfaceSlopes(solutions.recovery, points, normals[points])
        return slopes.of(solutions.displacement)

    return of


def fkm_judgement(
    strength: FkmStrength,
    basis: FloatArray,
    coefficients: FloatArray,
    runs: Mapping[str, IntArray],
    slopes: SlopesAt,
) -> FkmJudgement:
    """Return the judgement of the worst point over some paths; of equal paths the first.

    basis (n_points, 6, n_basis), MPa per unit; coefficients (n_basis, n) over all positions
    runs    name -> (n,) positions that are judged as one closed path, at least one
    """
    if not runs:
        raise ValueError("FKM's chain needs at least one cycle to judge")
    worst: FkmJudgement | None = None
    for name, run in runs.items():
        path = np.ascontiguousarray(coefficients[:, run])
        bound = fatigue.path_bounds(basis, path, 0.0)
        floor = -inf if worst is None else worst.utilisation
        for found in _governing(strength, basis, path, slopes, bound, floor):
            (row,) = first_largest(found.utilisation)
            if worst is not None and found.utilisation[row] <= worst.utilisation:
                continue
            first, second = (int(run[k]) for k in found.pair[row])
            worst = FkmJudgement(
                strength=strength,
                point=int(found.points[row]),
                run=name,
                pair=(min(first, second), max(first, second)),
                amplitude=float(found.amplitude[row]),
                mean=float(found.mean[row]),
                gradient=float(found.gradient[row]),
                limit=strength.limit(float(found.gradient[row])),
                width=float(bound.width[found.points[row]]),
            )
    assert worst is not None  # the first path has at least one point
    return worst


def fkm_points(
    strength: FkmStrength,
    basis: FloatArray,
    path: FloatArray,
    points: IntArray,
    slopes: SlopesAt,
    above: float = -inf,
) -> FkmPoints:
    """Return the utilisation of some points on one path, coefficients (n_basis, n).

    above  points that do not exceed this without support are left out; slopes cost more than chords
    """
    chords = fatigue.goodman(basis[points], path, 1.0, 1.0)
    plain = strength.utilisation(chords.amplitude, chords.mean, strength.plain)
    kept = np.flatnonzero(plain * (1.0 + _ROUND_OFF) > above)
    points, pair = points[kept], chords.pair[kept]
    amplitude, mean = chords.amplitude[kept], chords.mean[kept]
    loads = (path[:, pair[:, 0]] - path[:, pair[:, 1]]) / 2.0
    swing = _stress(basis[points], loads)
    own = slopes(points) if len(points) else np.zeros_like(basis[points])
    gradient = related_gradient(swing, _stress(own, loads))
    limit = strength.limit(gradient)
    used = strength.utilisation(amplitude, mean, limit)
    return FkmPoints(points, pair, amplitude, mean, gradient, limit.support, used)


def _stress(basis: FloatArray, weights: FloatArray) -> FloatArray:
    """Stress (n, 6) of points (n, 6, n_basis), each under its own loads (n_basis, n)."""
    return np.asarray(np.einsum("pcj,jp->pc", basis, weights))


def _governing(
    strength: FkmStrength,
    basis: FloatArray,
    path: FloatArray,
    slopes: SlopesAt,
    bound: fatigue.PathBounds,
    floor: float,
) -> Iterator[FkmPoints]:
    """Judge points, the highest bounds first, until no other can exceed the worst or the floor."""
    highest = strength.utilisation(bound.amplitude, bound.mean, strength.plain)
    highest = highest * (1.0 + _ROUND_OFF)
    order = np.argsort(-highest, kind="stable")
    start, together = 0, _FIRST
    while start < len(order) and highest[order[start]] > floor:
        some = order[start : start + together]
        found = fkm_points(strength, basis, path, some[highest[some] > floor], slopes, floor)
        if len(found.points):
            floor = max(floor, float(found.utilisation.max()))
            yield found
        start, together = start + together, min(2 * together, _MOST)
