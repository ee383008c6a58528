"""Fatigue of a part on one mesh over its duty: each cycle alone, and all of them as one path.

Between two cycles of a duty the stress goes from the extremes of one to those of the other. Behind
one another, the positions of all cycles are a closed path that holds every such range, whatever
the order; infinite life asks that its largest be endured without end. How often each happens is
the business of finite life (`checks.strength.finite_life`).
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from checks.part.part_loads import first_largest
from fatigue import Verdict, ductile_verdict, goodman
from geometry.mesh import FloatArray, IntArray

JOINED = "between cycles"
WHOLE_DUTY = "the whole duty"
_SMALL, _KEPT = 50_000, 64  # numbers of a basis whose verdict is kept, and how many are
_NEAR = 0.9  # of the worst utilisation: points that are judged again to prove the safety


@dataclass(frozen=True)
class FatiguePeak:
    """The largest fatigue utilisation of a part on one mesh.

    value      MPa, amplitude of equal safety: utilisation times the endurance limit
    cycle      of the duty, JOINED, or WHOLE_DUTY for a finite life
    pair       the two positions that decide, of all positions of all cycles
    criterion  Goodman, Findley or Miner
    """

    value: float
    point: int
    cycle: str
    pair: tuple[int, int]
    criterion: str


@dataclass(frozen=True, eq=False)
class NodalUse:
    """Utilisation, amplitude [MPa] and mean [MPa] (n_points,), each point's on its worst path.

    goodman_only  how many points may be used more by Findley's criterion, which was not needed
                  there: only a bound of it is known, and it is above `utilisation`
    """

    utilisation: FloatArray
    amplitude: FloatArray
    mean: FloatArray
    goodman_only: int = 0


@dataclass(frozen=True, eq=False)
class DutyVerdict:
    """The fatigue verdict on every surface point of a part over its duty.

    runs      name -> (n,) positions that are judged as one closed path
    verdicts  name -> the verdict on that path
    limits    (n_points,) MPa, endurance limit at the surface points
    limit     MPa, endurance limit away from notches
    """

    runs: Mapping[str, IntArray]
    verdicts: Mapping[str, Verdict]
    basis: FloatArray
    coefficients: FloatArray
    limits: FloatArray
    limit: float
    ultimate: float

    @property
    def worst_run(self) -> str:
        """The path that decides; of equal ones the first, so a cycle before all of them."""
        names = list(self.verdicts)
        used = np.array([self.verdicts[name].utilisation.max() for name in names])
        return names[first_largest(used)[0]]

    @property
    def worst(self) -> Verdict:
        """The verdict on the path that decides."""
        return self.verdicts[self.worst_run]

    @property
    def peak(self) -> FatiguePeak:
        """The deciding peak of fatigue."""
        name, verdict = self.worst_run, self.worst
        first, second = (int(self.runs[name][k]) for k in verdict.pair)
        used = float(verdict.utilisation[verdict.critical])
        return FatiguePeak(
            used * self.limit, verdict.critical, name, (first, second), verdict.criterion
        )

    @property
    def pairs(self) -> list[int]:
        """Positions that decide on each of the paths."""
        return [
            int(self.runs[name][k]) for name, verdict in self.verdicts.items() for k in verdict.pair
        ]

    @property
    def known(self) -> FloatArray:
        """The utilisation (n_points,) of each point as far as it is known; exact at the worst."""
        known = [verdict.utilisation for verdict in self.verdicts.values()]
        return np.asarray(np.max(known, axis=0))

    @property
    def bound(self) -> FloatArray:
        """Not less than the utilisation (n_points,) of each point on any path."""
        bounds = [verdict.highest_utilisation for verdict in self.verdicts.values()]
        return np.asarray(np.max(bounds, axis=0))

    @property
    def path(self) -> FloatArray:
        """Coefficients (n_basis, n) of the path that decides."""
        return np.ascontiguousarray(self.coefficients[:, self.runs[self.worst_run]])

    @cached_property
    def everywhere(self) -> NodalUse:
        """The use of every surface point on the path that uses it most; of equal ones the first.

        Goodman's, and Findley's where its value was needed; amplitude and mean are Goodman's.
        """
        n = len(self.basis)
        used, amplitude, mean = np.full(n, -1.0), np.zeros(n), np.zeros(n)
        for name in sorted(self.runs, key=lambda name: name != self.worst_run):
            verdict = self.verdicts[name]
            plane = np.nan_to_num(verdict.plane_utilisation, nan=0.0)
            some = np.flatnonzero(np.maximum(verdict.goodman_bound, plane) > used)
            if not len(some):
                continue
            path = np.ascontiguousarray(self.coefficients[:, self.runs[name]])
            found = goodman(self.basis[some], path, self.limits[some], self.ultimate)
            now = np.maximum(found.utilisation, plane[some])
            higher = now > used[some]
            worse = some[higher]
            used[worse] = now[higher]
            amplitude[worse], mean[worse] = found.amplitude[higher], found.mean[higher]
        unknown = [
            np.isnan(verdict.plane_utilisation) & (verdict.plane_bound > used)
            for verdict in self.verdicts.values()
        ]
        return NodalUse(used, amplitude, mean, int(np.any(unknown, axis=0).sum()))

    def utilisation_at(self, points: IntArray) -> FloatArray:
        """Utilisation (n,) of some points on the path that decides.

        Goodman's, and Findley's where its value was needed: it is known at the worst point.
        """
        by_chord = goodman(self.basis[points], self.path, self.limits[points], self.ultimate)
        return np.asarray(np.fmax(by_chord.utilisation, self.worst.plane_utilisation[points]))

    def safety_missed(self) -> float:
        """How far the worst utilisation is from 1 when all loads are multiplied by the safety.

        The proof of the safety factor, by judging again every point on that path whose bound comes
        near the worst. The coefficients of the unit loads are scaled, not speeds or gaps, which act
        otherwise.
        """
        worst = self.worst
        safety = worst.safety
        if not np.isfinite(safety):
            return 0.0
        some = np.flatnonzero(worst.highest_utilisation >= _NEAR * worst.utilisation.max())
        again = ductile_verdict(
            self.basis[some], safety * self.path, self.limits[some], self.ultimate,
            every_point=False,
        )  # fmt: skip
        return abs(float(again.utilisation.max()) - 1.0)


def duty_runs(cycles: Mapping[str, slice], duty: Iterable[str]) -> dict[str, IntArray]:
    """Paths that a duty judges: the positions of each of its cycles, and of all where it has more.

    cycles  name -> slice of the positions; those that the duty does not name are left out
    """
    runs = {
        name: np.arange(cycles[name].start, cycles[name].stop) for name in duty if name in cycles
    }
    if len(runs) > 1:
        runs[JOINED] = np.concatenate(list(runs.values()))
    return runs


def widest(runs: Mapping[str, IntArray]) -> str:
    """The path that holds all the others."""
    return JOINED if JOINED in runs else next(iter(runs))


def most_used(
    basis: FloatArray,
    coefficients: FloatArray,
    limits: FloatArray,
    ultimate: float,
    runs: Mapping[str, IntArray],
) -> tuple[FloatArray, FloatArray]:
    """`DutyVerdict.known` and `DutyVerdict.bound` (n_points,), without which path decides.

    By Findley no plane is used more on a path than on one that holds it, so only the widest is
    asked; Goodman's longest chord may have less of a mean than a shorter one, so all are.
    """
    paths = {name: np.ascontiguousarray(coefficients[:, run]) for name, run in runs.items()}
    path = paths.pop(widest(runs))
    verdict = _verdict(basis, path, limits, ultimate)
    others = [goodman(basis, path, limits, ultimate).utilisation for path in paths.values()]
    known = np.max([verdict.utilisation, *others], axis=0)
    return known, np.max([verdict.highest_utilisation, *others], axis=0)


def duty_verdict(
    basis: FloatArray,
    coefficients: FloatArray,
    limits: FloatArray,
    limit: float,
    ultimate: float,
    runs: Mapping[str, IntArray],
    floor: float = -np.inf,
) -> DutyVerdict | None:
    """Return the verdict over a duty, None without a cycle in it.

    basis (n_points, 6, n_basis), MPa per unit; coefficients (n_basis, n) over all positions.
    floor  utilisation up to which nothing need be known (`ductile_verdict`)
    """
    if not runs:
        return None
    verdicts = {
        name: _verdict(
            basis, np.ascontiguousarray(coefficients[:, positions]), limits, ultimate, name, floor
        )
        for name, positions in runs.items()
    }
    return DutyVerdict(runs, verdicts, basis, coefficients, limits, limit, ultimate)


def _verdict(
    basis: FloatArray,
    path: FloatArray,
    limits: FloatArray,
    ultimate: float,
    cycle: str = "",
    floor: float = -np.inf,
) -> Verdict:
    """The verdict on one path, as far as it is needed for the worst point.

    Small ones are kept: suggestions set out from parts as a check has judged them by formula.
    """
    if basis.size > _SMALL:
        return ductile_verdict(
            basis, path, limits, ultimate, every_point=False, floor=floor, cycle=cycle
        )
    arrays = (np.ascontiguousarray(each, dtype=np.float64) for each in (basis, path, limits))
    numbers = tuple(each.tobytes() for each in arrays)
    return _kept_verdict(*numbers, len(basis), len(path), ultimate, cycle, floor)


@lru_cache(maxsize=_KEPT)
def _kept_verdict(
    basis: bytes,
    path: bytes,
    limits: bytes,
    n_points: int,
    n_basis: int,
    ultimate: float,
    cycle: str,
    floor: float,
) -> Verdict:
    """As `_verdict`, by the bytes of its arrays."""
    return ductile_verdict(
        np.frombuffer(basis).reshape(n_points, 6, n_basis),
        np.frombuffer(path).reshape(n_basis, -1),
        np.frombuffer(limits),
        ultimate,
        every_point=False,
        floor=floor,
        cycle=cycle,
    )
