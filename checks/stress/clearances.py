"""A judged stress over the whole range of clearances that the fits of a part's pins leave.

At each clearance that is asked for contact is solved along the cycles, and the stress has its own
worst place and positions there. It need not rise or fall with the clearance: where it turns, more
clearances are asked for on both sides (docs/theory/contact.md).
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from checks.part.part_loads import PartLoads, first_largest
from checks.stress.judged import Judged, StaticPeak
from checks.stress.pins_in_bores import CLEARANCES, LARGEST, LEAST, MIDDLE, SOFT
from checks.stress.solid_mesh_level import Level
from checks.stress.stress_result import Stressed
from fem.recovery import von_mises
from geometry.mesh import FloatArray, IntArray

FIRST = (LEAST, 1 / 16, 1 / 8, 1 / 4, MIDDLE, 3 / 4, LARGEST)  # close where a pin becomes loose
_MOST = 16  # clearances
_SETTLED = 0.01  # of the value, by which it may lie farther out between two clearances
_NEAR = 0.75  # of the largest use by such a chord: points that other criteria may use more
POSITIONS = 36  # of each cycle, besides those that decide at the middle
_MAY_DECIDE = 0.5  # of what the judged point has at the middle, outside of bores


@dataclass(frozen=True)
class OverClearances:
    """A judged stress over the range of clearances.

    values       share of the range -> MPa, in order
    above_these  MPa, how far it may lie above the largest of them, between them; below_these alike
    soft         MPa, at the middle with soft bushes; None where their materials are stated
    """

    values: Mapping[float, float]
    above_these: float = 0.0
    below_these: float = 0.0
    soft: float | None = None

    @property
    def above(self) -> float:
        """How far the band reaches above the value at the middle, MPa."""
        return max(self.values.values()) + self.above_these - self.values[MIDDLE]

    @property
    def below(self) -> float:
        """How far the band reaches below the value at the middle, MPa."""
        return self.values[MIDDLE] - min(self.values.values()) + self.below_these


def over_clearances(judged: Judged, level: Level) -> OverClearances | None:
    """The quantity over the range of its pins' clearances, sought once; None without fits."""
    if level.contact is None:
        return None
    known = _known.setdefault(level, WeakKeyDictionary())
    if judged not in known:
        known[judged] = _sought(judged, level)
    return known[judged]


_known: WeakKeyDictionary[Level, WeakKeyDictionary[Judged, OverClearances]] = WeakKeyDictionary()


def _sought(judged: Judged, level: Level) -> OverClearances:
    assert level.contact is not None
    value = judged.value(level)
    soft = values_at(judged, level, [SOFT])[SOFT] if level.contact.unstated else None
    if level.contact.one_clearance:
        return OverClearances(dict.fromkeys(sorted(CLEARANCES), value), soft=soft)
    values = values_at(judged, level, FIRST)
    while True:
        high, above = turn_beyond(values)
        low, below = turn_beyond({share: -found for share, found in values.items()})
        asked = (high if above > _SETTLED * value else []) + (
            low if below > _SETTLED * value else []
        )
        if not asked or len(values) >= _MOST:
            return OverClearances(values, above, below, soft)
        values = dict(sorted((values | values_at(judged, level, asked)).items()))


def turn_beyond(values: Mapping[float, float]) -> tuple[list[float], float]:
    """Clearances to ask for beside the largest of some values, and how far it may be exceeded.

    values  share -> value, in order of the shares

    Half of the smaller step down beside it: an even peak, whose sides go on straight, exceeds its
    largest sample by no more, a round one by a quarter of that. Nothing at either end of the range,
    towards which values rise.
    """
    shares, found = list(values), np.array(list(values.values()))
    (k,) = first_largest(found)
    if k in (0, len(shares) - 1):
        return [], 0.0
    beside = [(shares[k - 1] + shares[k]) / 2, (shares[k] + shares[k + 1]) / 2]
    return beside, float(found[k] - max(found[k - 1], found[k + 1])) / 2


def values_at(
    judged: Judged,
    level: Level,
    shares: Iterable[float],
    loads: PartLoads | None = None,
    factor: float = 1.0,
) -> dict[float, float]:
    """The quantity, MPa, at shares of the range of clearances, each at its own worst positions.

    loads   of the level, where they are others than those that are judged
    factor  on all loads; values are over it
    """
    contact = level.contact
    assert contact is not None
    positions, cycles = some_positions(loads or judged.loads, level, [judged], POSITIONS)
    points = _points(judged, level, positions)
    basis = level.history.basis[points]
    endured = None if isinstance(judged, StaticPeak) else judged.endured(level, points)
    at_bores = isinstance(level, Level)  # other levels have no points at a bore's surface
    found = {}
    for share in shares:
        if contact.is_middle(share) and factor == 1.0:
            found[share] = judged.value(level)
            continue
        states = contact.solutions.state(contact.over(positions, share, factor))
        stress = np.asarray(basis @ states)
        if at_bores:
            contact.add_short_waves(stress, points, positions, share, factor)
        some = slice(None) if endured is None else that_swing(level, endured, stress)
        whole = np.eye(len(positions))
        found[share] = judged.anew(level, points[some], stress[some], whole, cycles, states)
    return found


def some_positions(
    loads: PartLoads, level: Stressed, judged: Iterable[Judged], count: int
) -> tuple[IntArray, dict[str, slice]]:
    """Some positions (n,) of every cycle, those of its largest stress and those that decide.

    Returns also, by the name of the cycle, which of them are its.
    """
    kept = [position for what in judged for position in what.deciding(level)]
    if level.duty is not None:  # the same contact for all that is judged
        kept += level.duty.pairs
    for cycle in loads.cycles.values():
        kept.append(cycle.start + first_largest(level.peaks_by_position[cycle])[0])
        some = np.linspace(cycle.start, cycle.stop - 1, min(count, cycle.stop - cycle.start))
        kept += some.round().astype(int).tolist()
    chosen = np.unique(kept)
    return chosen, {
        name: slice(*np.searchsorted(chosen, [c.start, c.stop]).tolist())
        for name, c in loads.cycles.items()
    }


def that_swing(
    level: Stressed, endured: FloatArray, stress: FloatArray, known: float = 0.0
) -> IntArray:
    """Which of some points (n,) may decide fatigue under stress (n, 6, m), MPa.

    Judged by a long chord of each path: from the position farthest from its middle to the one that
    is farthest from there. The longest one, Goodman's, is little longer; other criteria may use a
    point more than he does.

    endured  (n,) MPa, their amplitudes of equal safety
    known    MPa, what they must exceed in any case
    """
    duty, rows = level.judged_duty, np.arange(len(stress))

    def farthest(place: FloatArray) -> FloatArray:
        away = von_mises(np.moveaxis(stress - place[:, :, None], 1, -1))
        return stress[rows, :, away.argmax(axis=1)]

    one = farthest(stress.mean(axis=2))
    other = farthest(one)
    swing, middle = von_mises(one - other) / 2 / endured, (one + other) / 2
    even = middle[:, :3].mean(axis=1)  # the largest principal stress is this or more
    least = swing + np.maximum(even, 0.0) / duty.ultimate
    most = swing + np.maximum(even + 2 / 3 * von_mises(middle), 0.0) / duty.ultimate
    return np.flatnonzero(most >= _NEAR * max(known / duty.limit, least.max(initial=0.0)))


def _points(judged: Judged, level: Level, positions: IntArray) -> IntArray:
    """Points (n,) of the bores, and those that are stressed enough at the middle to decide."""
    if isinstance(judged, StaticPeak):
        stress = level.history.basis @ np.ascontiguousarray(level.coefficients[:, positions])
        most = von_mises(np.moveaxis(stress, 1, -1)).max(axis=1)
    else:
        most = level.judged_duty.bound
    some = most >= _MAY_DECIDE * most[judged.point(level)]
    if isinstance(level, Level):
        assert level.contact is not None
        for bore in level.contact.pins.harmonics:
            some[bore.points] = True
        some[level.left_out] = False
    return np.flatnonzero(some)
